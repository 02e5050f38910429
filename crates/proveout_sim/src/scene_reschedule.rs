//! Programs that are made from others: the method and its options, in scenes and on the command line.

use std::f64::consts::TAU;

use proveout_toolpath::reschedule::{
    ChannelKind, Criterion, Junction, Measurement, Method, MinAngularAcceleration, MultiScale, Quaternion, RowEnds,
    STheta, SearchedInset, Singularity, Smooth, SmoothRows, ThetaUnit,
};
use schemars::JsonSchema;
use serde::Deserialize;

/// A program that is made from another one.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RescheduleFile {
    /// The method.
    pub method: MethodFile,
    /// Name of the program that it starts from.
    pub from: String,
    /// `s-theta`, `smooth`: clearance from both limits, degrees. `quaternion`: of the channel that is shown; it changes no axis.
    pub clearance_deg: Option<f64>,
    /// `s-theta`: distance of key points from the limits, degrees; or `search` for the one with the least peak of acceleration at the programmed feed.
    pub inset_deg: Option<InsetFile>,
    /// `s-theta`: shortest flat at the start of a layer, mm.
    pub start_flat_mm: Option<f64>,
    /// `s-theta`: flat at the end of a layer, percent of the layer's length.
    pub end_flat_percent: Option<f64>,
    /// `s-theta`: key points nearer than this are merged, mm.
    pub merge_mm: Option<f64>,
    /// `s-theta`: unit of theta in the construction of corners.
    pub theta_unit: Option<ThetaUnitFile>,
    /// `quaternion`: key blocks of a layer.
    pub keys: Option<usize>,
    /// `singularity`: blocks whose axis is nearer to the table's axis than this are looked at, degrees.
    pub cone_deg: Option<f64>,
    /// `singularity`: they are changed where the table turns by more than this for a mm of contact path, degrees.
    pub rate_deg_mm: Option<f64>,
    /// `singularity`: how the ends of a changed stretch are smoothed.
    pub junction: Option<JunctionFile>,
    /// `min-angular-acceleration`: largest lean of key axes from the table's axis, degrees.
    pub cap_deg: Option<f64>,
    /// `min-angular-acceleration`: half of the window at a key, mm.
    pub window_mm: Option<f64>,
    /// `min-angular-acceleration`: what the axes between keys are the least of.
    pub criterion: Option<CriterionFile>,
    /// `min-angular-acceleration`: where the axes of the keys come from.
    pub key_axes: Option<KeyAxesFile>,
    /// `multi-scale`, `smooth` of rows: narrowest strip, mm.
    pub strip_min_mm: Option<f64>,
    /// `multi-scale`, `smooth` of rows: widest strip, mm.
    pub strip_max_mm: Option<f64>,
    /// `multi-scale`, `smooth` of rows: height over the surface at which a strip is measured, mm.
    pub strip_height_mm: Option<f64>,
    /// `multi-scale`, `smooth` of rows: largest Ra across the feed, um; 0 for no limit.
    pub ra_um: Option<f64>,
    /// `multi-scale`, `smooth` of rows: evaluation length of Ra, mm.
    pub evaluation_length_mm: Option<f64>,
    /// `multi-scale`, `smooth` of rows: way at both ends of a row that is not judged while its first and last axis stay, mm.
    pub run_in_mm: Option<f64>,
    /// `multi-scale`: how far inside of its interval a contact is fixed, degrees.
    pub margin_deg: Option<f64>,
    /// `multi-scale`: coefficients of a rotary curve at the start.
    pub coefficients: Option<usize>,
    /// `multi-scale`, `smooth` of rows: what a measurement is taken to read of the computed Ra, as a part of it; with it the study tells how many of 90
    /// places are expected above `ra_um`.
    pub measured_part: Option<f64>,
    /// `multi-scale`, `smooth` of rows: standard deviation of what is read, as a part of it; 0 when left out.
    pub measured_spread: Option<f64>,
    /// `smooth`: where the limits of the axis come from.
    pub channel: Option<ChannelFile>,
    /// `smooth`: largest lean of the tool axis from the normal in the channel of the tool and of rows, degrees.
    pub lean_max_deg: Option<f64>,
    /// `smooth`: the rotary axis does not turn back.
    pub monotone: Option<bool>,
    /// `smooth` of rows: largest turn of the tool axis from the program's own, degrees.
    pub turn_max_deg: Option<f64>,
    /// `smooth` of rows: whether the axes at both ends of a row stay.
    pub ends: Option<EndsFile>,
}

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
    /// What the tool leaves free beside part and fixtures, up to `lean_max_deg`.
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
    /// The program's own, up to `cap_deg`.
    Program,
    /// They are looked for in the free cells of their contacts.
    Search,
}

impl KeyAxesFile {
    /// Every rule with its name.
    pub const NAMES: [(&'static str, Self); 2] = [("program", Self::Program), ("search", Self::Search)];
}

/// Methods that re-plan tool axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MethodFile {
    /// Li et al. 2022.
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

impl RescheduleFile {
    /// Keys of options, in the order of the scene file.
    pub const OPTIONS: [&'static str; 29] = [
        "clearance_deg",
        "inset_deg",
        "start_flat_mm",
        "end_flat_percent",
        "merge_mm",
        "theta_unit",
        "keys",
        "cone_deg",
        "rate_deg_mm",
        "junction",
        "cap_deg",
        "window_mm",
        "strip_min_mm",
        "strip_max_mm",
        "strip_height_mm",
        "ra_um",
        "evaluation_length_mm",
        "run_in_mm",
        "margin_deg",
        "coefficients",
        "measured_part",
        "measured_spread",
        "channel",
        "lean_max_deg",
        "monotone",
        "turn_max_deg",
        "ends",
        "criterion",
        "key_axes",
    ];

    /// Options that a method reads.
    pub fn options_of(method: MethodFile) -> &'static [&'static str] {
        match method {
            MethodFile::STheta => {
                &["clearance_deg", "inset_deg", "start_flat_mm", "end_flat_percent", "merge_mm", "theta_unit"]
            }
            MethodFile::Quaternion => &["clearance_deg", "keys"],
            MethodFile::Singularity => &["cone_deg", "rate_deg_mm", "junction"],
            MethodFile::MinAngularAcceleration => &["cap_deg", "window_mm", "criterion", "key_axes"],
            MethodFile::MultiScale => &[
                "strip_min_mm",
                "strip_max_mm",
                "strip_height_mm",
                "ra_um",
                "evaluation_length_mm",
                "run_in_mm",
                "margin_deg",
                "coefficients",
                "measured_part",
                "measured_spread",
            ],
            MethodFile::Smooth => &[
                "channel",
                "clearance_deg",
                "lean_max_deg",
                "monotone",
                "turn_max_deg",
                "ends",
                "strip_min_mm",
                "strip_max_mm",
                "strip_height_mm",
                "ra_um",
                "evaluation_length_mm",
                "run_in_mm",
                "measured_part",
                "measured_spread",
            ],
        }
    }

    /// Options that the method reads with the channel and the criterion that are given.
    pub fn read(&self) -> Vec<&'static str> {
        let all = Self::options_of(self.method).iter().copied();
        let rows = self.channel == Some(ChannelFile::Rows);
        all.filter(|key| match (self.method, *key) {
            (MethodFile::MinAngularAcceleration, "window_mm") => self.criterion != Some(CriterionFile::TrueMinimum),
            // A measurement counts places above a limit.
            (_, "measured_part") if self.ra_um == Some(0.0) => false,
            (_, "measured_spread") if self.ra_um == Some(0.0) || self.measured_part.is_none() => false,
            (MethodFile::Smooth, "channel" | "lean_max_deg") => true,
            (MethodFile::Smooth, "clearance_deg" | "monotone") => !rows,
            (MethodFile::Smooth, _) => rows,
            _ => true,
        })
        .collect()
    }

    /// Options that are given, as `KEY=VALUE`.
    pub fn given(&self) -> Vec<(&'static str, String)> {
        let number = |v: f64| v.to_string();
        let unit =
            |u: ThetaUnitFile| ThetaUnitFile::NAMES.iter().find(|(_, k)| *k == u).map_or("", |(n, _)| n).to_owned();
        let values = [
            self.clearance_deg.map(number),
            self.inset_deg.map(|inset| match inset {
                InsetFile::Degrees(degrees) => number(degrees),
                InsetFile::Word(InsetWordFile::Search) => "search".to_owned(),
            }),
            self.start_flat_mm.map(number),
            self.end_flat_percent.map(number),
            self.merge_mm.map(number),
            self.theta_unit.map(unit),
            self.keys.map(|k| k.to_string()),
            self.cone_deg.map(number),
            self.rate_deg_mm.map(number),
            self.junction.map(|j| JunctionFile::NAMES.iter().find(|(_, k)| *k == j).map_or("", |(n, _)| n).to_owned()),
            self.cap_deg.map(number),
            self.window_mm.map(number),
            self.strip_min_mm.map(number),
            self.strip_max_mm.map(number),
            self.strip_height_mm.map(number),
            self.ra_um.map(number),
            self.evaluation_length_mm.map(number),
            self.run_in_mm.map(number),
            self.margin_deg.map(number),
            self.coefficients.map(|k| k.to_string()),
            self.measured_part.map(number),
            self.measured_spread.map(number),
            self.channel.map(|c| ChannelFile::NAMES.iter().find(|(_, k)| *k == c).map_or("", |(n, _)| n).to_owned()),
            self.lean_max_deg.map(number),
            self.monotone.map(|m| m.to_string()),
            self.turn_max_deg.map(number),
            self.ends.map(|e| name_of(&EndsFile::NAMES, e)),
            self.criterion.map(|c| name_of(&CriterionFile::NAMES, c)),
            self.key_axes.map(|k| name_of(&KeyAxesFile::NAMES, k)),
        ];
        Self::OPTIONS.into_iter().zip(values).filter_map(|(key, value)| Some((key, value?))).collect()
    }

    /// An option that is given and that the method does not read.
    pub fn unread(&self) -> Option<&'static str> {
        let read = self.read();
        self.given().into_iter().map(|(key, _)| key).find(|key| !read.contains(key))
    }

    /// Sets an option from its text.
    ///
    /// # Errors
    /// What is wrong, and what to write: an option that the method does not read, or a value that is none.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), (String, String)> {
        let read = Self::options_of(self.method);
        if !read.contains(&key) {
            let method = MethodFile::NAMES.iter().find(|(_, m)| *m == self.method).map_or("", |(n, _)| n);
            return Err((
                format!("{method} has no option {key:?}"),
                format!("options of {method}: {}", read.join(", ")),
            ));
        }
        let number = || {
            let number = value.parse::<f64>().ok().filter(|v| v.is_finite());
            number.ok_or_else(|| (format!("{key}={value} is no number"), "write a number with a point".to_owned()))
        };
        match key {
            "clearance_deg" => self.clearance_deg = Some(number()?),
            "inset_deg" if value == "search" => self.inset_deg = Some(InsetFile::Word(InsetWordFile::Search)),
            "inset_deg" => {
                let (message, _) = match number() {
                    Ok(degrees) => {
                        self.inset_deg = Some(InsetFile::Degrees(degrees));
                        return Ok(());
                    }
                    Err(wrong) => wrong,
                };
                return Err((message, "write degrees with a point, or search".to_owned()));
            }
            "start_flat_mm" => self.start_flat_mm = Some(number()?),
            "end_flat_percent" => self.end_flat_percent = Some(number()?),
            "merge_mm" => self.merge_mm = Some(number()?),
            "cone_deg" => self.cone_deg = Some(number()?),
            "rate_deg_mm" => self.rate_deg_mm = Some(number()?),
            "cap_deg" => self.cap_deg = Some(number()?),
            "window_mm" => self.window_mm = Some(number()?),
            "strip_min_mm" => self.strip_min_mm = Some(number()?),
            "strip_max_mm" => self.strip_max_mm = Some(number()?),
            "strip_height_mm" => self.strip_height_mm = Some(number()?),
            "ra_um" => self.ra_um = Some(number()?),
            "evaluation_length_mm" => self.evaluation_length_mm = Some(number()?),
            "run_in_mm" => self.run_in_mm = Some(number()?),
            "margin_deg" => self.margin_deg = Some(number()?),
            "measured_part" => self.measured_part = Some(number()?),
            "measured_spread" => self.measured_spread = Some(number()?),
            "lean_max_deg" => self.lean_max_deg = Some(number()?),
            "turn_max_deg" => self.turn_max_deg = Some(number()?),
            "ends" => self.ends = Some(named(&EndsFile::NAMES, key, value)?),
            "criterion" => self.criterion = Some(named(&CriterionFile::NAMES, key, value)?),
            "key_axes" => self.key_axes = Some(named(&KeyAxesFile::NAMES, key, value)?),
            "monotone" => {
                let Ok(monotone) = value.parse::<bool>() else {
                    return Err((format!("{key}={value} is neither true nor false"), "write true or false".to_owned()));
                };
                self.monotone = Some(monotone);
            }
            "channel" => {
                let Some((_, channel)) = ChannelFile::NAMES.iter().find(|(name, _)| *name == value) else {
                    let names: Vec<&str> = ChannelFile::NAMES.iter().map(|(name, _)| *name).collect();
                    return Err((format!("{key}={value} is no channel"), format!("write one of {}", names.join(", "))));
                };
                self.channel = Some(*channel);
            }
            "junction" => {
                let Some((_, rule)) = JunctionFile::NAMES.iter().find(|(name, _)| *name == value) else {
                    let names: Vec<&str> = JunctionFile::NAMES.iter().map(|(name, _)| *name).collect();
                    return Err((format!("{key}={value} is no rule"), format!("write one of {}", names.join(", "))));
                };
                self.junction = Some(*rule);
            }
            "theta_unit" => {
                let Some((_, unit)) = ThetaUnitFile::NAMES.iter().find(|(name, _)| *name == value) else {
                    let names: Vec<&str> = ThetaUnitFile::NAMES.iter().map(|(name, _)| *name).collect();
                    return Err((format!("{key}={value} is no unit"), format!("write one of {}", names.join(", "))));
                };
                self.theta_unit = Some(*unit);
            }
            _ => {
                let Ok(count) = value.parse::<usize>() else {
                    return Err((format!("{key}={value} is no count"), "write a whole number".to_owned()));
                };
                match key {
                    "coefficients" => self.coefficients = Some(count),
                    _ => self.keys = Some(count),
                }
            }
        }
        Ok(())
    }

    /// A method with its published or default parameters.
    pub fn plain(method: MethodFile, from: &str) -> Self {
        Self {
            method,
            from: from.to_owned(),
            clearance_deg: None,
            inset_deg: None,
            start_flat_mm: None,
            end_flat_percent: None,
            merge_mm: None,
            theta_unit: None,
            keys: None,
            cone_deg: None,
            rate_deg_mm: None,
            junction: None,
            cap_deg: None,
            window_mm: None,
            strip_min_mm: None,
            strip_max_mm: None,
            strip_height_mm: None,
            ra_um: None,
            evaluation_length_mm: None,
            run_in_mm: None,
            margin_deg: None,
            coefficients: None,
            measured_part: None,
            measured_spread: None,
            channel: None,
            lean_max_deg: None,
            monotone: None,
            turn_max_deg: None,
            ends: None,
            criterion: None,
            key_axes: None,
        }
    }

    /// Rules of a bull-nose.
    fn multi_scale(&self) -> MultiScale {
        let defaults = MultiScale::default();
        let [narrow, wide] = defaults.strip;
        MultiScale {
            strip: [self.strip_min_mm.unwrap_or(narrow), self.strip_max_mm.unwrap_or(wide)],
            strip_height: self.strip_height_mm.unwrap_or(defaults.strip_height),
            roughness: self.ra_um.map_or(defaults.roughness, |um| 1e-3 * um),
            evaluation_length: self.evaluation_length_mm.unwrap_or(defaults.evaluation_length),
            run_in: self.run_in_mm.unwrap_or(defaults.run_in),
            margin: self.margin_deg.map_or(defaults.margin, |d| d * TAU / 360.0),
            coefficients: self.coefficients.unwrap_or(defaults.coefficients),
            measurement: self
                .measured_part
                .map(|part| Measurement { part, spread: self.measured_spread.unwrap_or(0.0) }),
        }
    }

    /// The method with its parameters.
    pub fn method(&self) -> Box<dyn Method> {
        let defaults = STheta::default();
        let clearance = self.clearance_deg.map_or(defaults.clearance, |d| d * TAU / 360.0);
        match self.method {
            MethodFile::STheta => {
                let method = STheta {
                    clearance,
                    inset: match self.inset_deg {
                        Some(InsetFile::Degrees(degrees)) => degrees * TAU / 360.0,
                        Some(InsetFile::Word(InsetWordFile::Search)) | None => defaults.inset,
                    },
                    unit: match self.theta_unit {
                        None | Some(ThetaUnitFile::Degree) => ThetaUnit::Degree,
                        Some(ThetaUnitFile::Radian) => ThetaUnit::Radian,
                        Some(ThetaUnitFile::Normalized) => ThetaUnit::Normalized,
                        Some(ThetaUnitFile::UnitFree) => ThetaUnit::UnitFree,
                    },
                    start_flat: self.start_flat_mm.unwrap_or(defaults.start_flat),
                    end_flat: self.end_flat_percent.map_or(defaults.end_flat, |p| p / 100.0),
                    merge: self.merge_mm.unwrap_or(defaults.merge),
                };
                match self.inset_deg {
                    Some(InsetFile::Word(InsetWordFile::Search)) => Box::new(SearchedInset(method)),
                    _ => Box::new(method),
                }
            }
            MethodFile::Quaternion => {
                Box::new(Quaternion { keys: self.keys.unwrap_or(Quaternion::default().keys), clearance })
            }
            MethodFile::MinAngularAcceleration => {
                let defaults = MinAngularAcceleration::default();
                Box::new(MinAngularAcceleration {
                    cap: self.cap_deg.map_or(defaults.cap, |d| d * TAU / 360.0),
                    window: self.window_mm.unwrap_or(defaults.window),
                    criterion: match self.criterion {
                        None => defaults.criterion,
                        Some(CriterionFile::Paper) => Criterion::Paper,
                        Some(CriterionFile::TrueMinimum) => Criterion::TrueMinimum,
                    },
                    search: self.key_axes.map_or(defaults.search, |k| k == KeyAxesFile::Search),
                })
            }
            MethodFile::MultiScale => Box::new(self.multi_scale()),
            MethodFile::Smooth if self.channel == Some(ChannelFile::Rows) => {
                let defaults = SmoothRows::default();
                Box::new(SmoothRows {
                    lean_max: self.lean_max_deg.map_or(defaults.lean_max, |d| d * TAU / 360.0),
                    turn_max: self.turn_max_deg.map(|d| d * TAU / 360.0),
                    ends: match self.ends {
                        None => defaults.ends,
                        Some(EndsFile::Kept) => RowEnds::Kept,
                        Some(EndsFile::Free) => RowEnds::Free,
                    },
                    rules: self.multi_scale(),
                })
            }
            MethodFile::Smooth => {
                let defaults = Smooth::default();
                Box::new(Smooth {
                    channel: match self.channel {
                        None => defaults.channel,
                        Some(ChannelFile::Clearance | ChannelFile::Rows) => ChannelKind::Clearance,
                        Some(ChannelFile::Tool) => ChannelKind::Tool,
                    },
                    clearance,
                    lean_max: self.lean_max_deg.map_or(defaults.lean_max, |d| d * TAU / 360.0),
                    monotone: self.monotone.unwrap_or(defaults.monotone),
                })
            }
            MethodFile::Singularity => {
                let defaults = Singularity::default();
                Box::new(Singularity {
                    cone: self.cone_deg.map_or(defaults.cone, |d| d * TAU / 360.0),
                    rate: self.rate_deg_mm.map_or(defaults.rate, |d| d * TAU / 360.0),
                    junction: match self.junction {
                        None => defaults.junction,
                        Some(JunctionFile::Off) => Junction::Off,
                        Some(JunctionFile::Free) => Junction::Free,
                        Some(JunctionFile::Pinned) => Junction::Pinned,
                    },
                })
            }
        }
    }
}

fn name_of<T: Copy + PartialEq>(names: &[(&'static str, T)], value: T) -> String {
    names.iter().find(|(_, v)| *v == value).map_or("", |(name, _)| name).to_owned()
}

fn named<T: Copy>(names: &[(&'static str, T)], key: &str, value: &str) -> Result<T, (String, String)> {
    names.iter().find(|(name, _)| *name == value).map(|(_, v)| *v).ok_or_else(|| {
        let all: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
        (format!("{key}={value} is none of its words"), format!("write one of {}", all.join(", ")))
    })
}
