//! Words that options of re-scheduling are given in, each list with its names.

use schemars::JsonSchema;
use serde::Deserialize;

/// Distance of key points from the limits.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "write degrees, or \"search\"")]
pub enum InsetFile {
    /// Degrees.
    Degrees(f64),
    /// A word.
    Word(InsetWordFile),
}

/// How the distance of key points from the limits is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InsetWordFile {
    /// The one with the least peak of acceleration at the programmed feed.
    Search,
}

/// Where the limits of a tool axis come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ChannelFile {
    /// The rule of Li et al. 2022 with `clearance_deg` on both sides.
    Clearance,
    /// What the tool leaves free next to part and fixtures, up to `lean_max_deg`.
    Tool,
    /// Both rotary joints free, row by row.
    Rows,
}

/// Whether the axes at both ends of a row stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EndsFile {
    /// As the program has them.
    Kept,
    /// They move as all others do.
    Free,
}

impl EndsFile {
    /// Every rule with its name.
    pub const NAMES: [(&'static str, Self); 2] = [("kept", Self::Kept), ("free", Self::Free)];
}

impl ChannelFile {
    /// Every channel with its name.
    pub const NAMES: [(&'static str, Self); 3] =
        [("clearance", Self::Clearance), ("tool", Self::Tool), ("rows", Self::Rows)];
}

/// What the axes between keys are the least of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CriterionFile {
    /// The sum of the paper between two keys each, with windows at the keys.
    Paper,
    /// That sum over the whole row.
    TrueMinimum,
}

impl CriterionFile {
    /// Every criterion with its name.
    pub const NAMES: [(&'static str, Self); 2] = [("paper", Self::Paper), ("true-minimum", Self::TrueMinimum)];
}

/// Where the axes of keys come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum KeyAxesFile {
    /// The program's own, up to `max_key_lean_deg`.
    Program,
    /// They are looked for in the free cells of their contacts.
    Search,
}

impl KeyAxesFile {
    /// Every rule with its name.
    pub const NAMES: [(&'static str, Self); 2] = [("program", Self::Program), ("search", Self::Search)];
}

/// Methods that re-plan tool axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MethodFile {
    /// Li et al. 2022.
    #[default]
    STheta,
    /// Ho, Hwang, Hu 2003.
    Quaternion,
    /// Cui et al. 2022.
    Singularity,
    /// Ma et al. 2020.
    MinAngularAcceleration,
    /// Dong et al. 2023.
    MultiScale,
    /// A method of this project.
    Smooth,
}

impl MethodFile {
    /// Every method with its name.
    pub const NAMES: [(&'static str, Self); 6] = [
        ("s-theta", Self::STheta),
        ("quaternion", Self::Quaternion),
        ("singularity", Self::Singularity),
        ("min-angular-acceleration", Self::MinAngularAcceleration),
        ("multi-scale", Self::MultiScale),
        ("smooth", Self::Smooth),
    ];
}

/// Unit of theta.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ThetaUnitFile {
    /// Degrees.
    Degree,
    /// Radian.
    Radian,
    /// Turns and layers.
    Normalized,
    /// A rule that does not depend on units.
    UnitFree,
}

impl ThetaUnitFile {
    /// Every unit with its name.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("degree", Self::Degree),
        ("radian", Self::Radian),
        ("normalized", Self::Normalized),
        ("unit-free", Self::UnitFree),
    ];
}

/// How the ends of a stretch near the pole are smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JunctionFile {
    /// Not at all.
    Off,
    /// By the least-squares quadratic through five blocks, as published.
    Free,
    /// By the one that keeps the first and the last of them.
    Pinned,
}

impl JunctionFile {
    /// Every rule with its name.
    pub const NAMES: [(&'static str, Self); 3] = [("off", Self::Off), ("free", Self::Free), ("pinned", Self::Pinned)];
}
