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

impl ChannelFile {
    /// Every channel with its name.
    pub const NAMES: [(&'static str, Self); 3] =
        [("clearance", Self::Clearance), ("tool", Self::Tool), ("rows", Self::Rows)];
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
