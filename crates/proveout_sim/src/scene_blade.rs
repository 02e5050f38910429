//! Blades and re-scheduling, as they stand in a scene.

use std::f64::consts::TAU;

use proveout_geom::blade::{Blade, BladeEnd, BladeError, BladeSpec, CamberSection, Plate, Platform};
use proveout_geom::rad;
use proveout_toolpath::reschedule::{
    Junction, Method, MinAngularAcceleration, Quaternion, STheta, Singularity, ThetaUnit,
};
use schemars::JsonSchema;
use serde::Deserialize;

/// A blade along +X of the workpiece frame, or a face. Kind `camber`: circles on a circular camber line, stacked on their centroid, on a platform
/// whose top face is X = 0.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BladeFile {
    /// Which closed form.
    #[serde(default)]
    pub kind: BladeKindFile,
    /// The end of lower X of `lu`, `lu-untwisted` and `sections`.
    pub root: Option<EndFile>,
    /// The end of higher X.
    pub tip: Option<EndFile>,
    /// Z of the underside below a face of kind `sine`, `sine-gentle` or `dong`, mm.
    pub underside_mm: Option<f64>,
    /// Chord of the camber line, mm.
    #[serde(default = "left_out")]
    pub chord_mm: f64,
    /// Angle between the tangents at its ends, degrees.
    #[serde(default = "left_out")]
    pub camber_angle_deg: f64,
    /// Largest thickness, mm.
    #[serde(default = "left_out")]
    pub thickness_mm: f64,
    /// Radius of the leading edge, mm.
    #[serde(default = "left_out")]
    pub leading_radius_mm: f64,
    /// Radius of the trailing edge, mm.
    #[serde(default = "left_out")]
    pub trailing_radius_mm: f64,
    /// Height above the platform, mm.
    #[serde(default = "left_out")]
    pub length_mm: f64,
    /// Turn of the section for each mm of height, degrees.
    #[serde(default)]
    pub twist_deg_per_mm: f64,
    /// The platform.
    pub platform: Option<PlatformFile>,
    /// Chord error asked of the mesh that stands for the blade on the rays, in the pictures and as stock, mm. How far it is off is measured and
    /// stands in the verdict as `mesh_error_mm`; points of the cut part are held against the closed form.
    pub chord_error_mm: f64,
}

/// Stands for a number that the scene does not give: whether it may be left out depends on the kind, see [`BladeFile::fault`].
fn left_out() -> f64 {
    f64::NAN
}

/// Which closed form a blade has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BladeKindFile {
    /// Circles on a circular camber line.
    #[default]
    Camber,
    /// The compressor blade on which the method of Lu et al. 2022 is tried.
    Lu,
    /// The same without its twist.
    LuUntwisted,
    /// The steep sine surface of Ma et al. 2020.
    Sine,
    /// Their sine surface that a ball of 3 mm can cut.
    SineGentle,
    /// The free-form surface for the method of Dong et al. 2023.
    Dong,
    /// The ruled face for the method of Cui et al. 2022, along +Z.
    Cui,
    /// A spline through the sections of the file `part.sections`.
    Sections,
}

impl BladeKindFile {
    fn name(self) -> &'static str {
        match self {
            Self::Camber => "camber",
            Self::Lu => "lu",
            Self::LuUntwisted => "lu-untwisted",
            Self::Sine => "sine",
            Self::SineGentle => "sine-gentle",
            Self::Dong => "dong",
            Self::Cui => "cui",
            Self::Sections => "sections",
        }
    }

    pub(crate) fn has_ends(self) -> bool {
        matches!(self, Self::Lu | Self::LuUntwisted | Self::Sections)
    }

    fn has_underside(self) -> bool {
        matches!(self, Self::Sine | Self::SineGentle | Self::Dong)
    }
}

/// An end of a blade: flat at X, or a platform with a fillet whose face towards the blade is at X.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EndFile {
    /// Where it lies, mm.
    pub x_mm: f64,
    /// The platform; without one the end is flat.
    pub platform: Option<EndPlatformFile>,
}

/// A platform at an end of a blade: a block.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EndPlatformFile {
    /// Radius of the ball that rolls along blade and platform, mm.
    pub fillet_radius_mm: f64,
    /// Thickness, mm.
    pub thickness_mm: f64,
    /// From and to along Y, mm.
    pub y_mm: [f64; 2],
    /// From and to along Z, mm.
    pub z_mm: [f64; 2],
}

impl EndFile {
    /// The end as the geometry has it.
    pub fn end(&self) -> BladeEnd {
        let plate = self.platform.map(|p| Plate {
            fillet_radius: p.fillet_radius_mm,
            thickness: p.thickness_mm,
            y: p.y_mm,
            z: p.z_mm,
        });
        BladeEnd { x: self.x_mm, plate }
    }
}

/// Platform below a blade.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlatformFile {
    /// Fillet between blade and platform, mm.
    pub fillet_radius_mm: f64,
    /// Distance of its rim from the section, mm.
    pub margin_mm: f64,
    /// Thickness, mm.
    pub thickness_mm: f64,
}

impl BladeFile {
    /// A key that its kind needs and that is left out, or that it does not read: what is wrong, and what to write. `sections`: whether the part names
    /// a file of sections.
    pub(crate) fn fault(&self, sections: bool) -> Option<(String, String)> {
        let kind = self.kind;
        let camber = [
            ("chord_mm", self.chord_mm),
            ("camber_angle_deg", self.camber_angle_deg),
            ("thickness_mm", self.thickness_mm),
            ("leading_radius_mm", self.leading_radius_mm),
            ("trailing_radius_mm", self.trailing_radius_mm),
            ("length_mm", self.length_mm),
        ];
        let of_camber = kind == BladeKindFile::Camber;
        let mut keys: Vec<(&str, bool, bool)> =
            camber.into_iter().map(|(key, value)| (key, !value.is_nan(), of_camber)).collect();
        keys.extend([
            ("root", self.root.is_some(), kind.has_ends()),
            ("tip", self.tip.is_some(), kind.has_ends()),
            ("underside_mm", self.underside_mm.is_some(), kind.has_underside()),
        ]);
        let name = kind.name();
        if let Some((key, ..)) = keys.iter().find(|(_, given, needed)| !given && *needed) {
            return Some((
                format!("missing key `{key}` of a blade of kind {name:?}"),
                format!("give `{key}` in [part.blade]"),
            ));
        }
        keys.push(("platform", self.platform.is_some(), of_camber));
        keys.push(("twist_deg_per_mm", self.twist_deg_per_mm != 0.0, of_camber));
        if let Some((key, ..)) = keys.iter().find(|(_, given, read)| *given && !read) {
            return Some((format!("a blade of kind {name:?} does not read `{key}`"), "take the key out".into()));
        }
        let of_sections = kind == BladeKindFile::Sections;
        match (of_sections, sections) {
            (true, false) => {
                Some(("a blade of kind \"sections\" needs its file".into(), "give `sections` in [part]".into()))
            }
            (false, true) => {
                Some((format!("a blade of kind {name:?} reads no sections"), "take `sections` out of [part]".into()))
            }
            _ => None,
        }
    }

    fn section(&self) -> CamberSection {
        CamberSection {
            chord: self.chord_mm,
            camber_angle: rad(self.camber_angle_deg),
            thickness: self.thickness_mm,
            leading_radius: self.leading_radius_mm,
            trailing_radius: self.trailing_radius_mm,
            shift: [0.0; 2],
        }
    }

    /// The blade with so much more material on its sides (mm); the platform keeps its rim.
    ///
    /// # Errors
    /// Numbers that make no blade, or another kind.
    pub fn blade(&self, allowance: f64) -> Result<Blade, BladeError> {
        if self.kind != BladeKindFile::Camber {
            return Err(BladeError::Kind);
        }
        let design = self.section();
        design.check()?;
        let section = CamberSection {
            thickness: design.thickness + 2.0 * allowance,
            leading_radius: design.leading_radius + allowance,
            trailing_radius: design.trailing_radius + allowance,
            shift: design.centroid().map(|v| -v),
            ..design
        };
        let platform = self.platform.map(|p| Platform {
            fillet_radius: p.fillet_radius_mm,
            margin: p.margin_mm - allowance,
            thickness: p.thickness_mm,
        });
        Blade::new(BladeSpec { section, length: self.length_mm, twist: rad(self.twist_deg_per_mm), platform })
    }
}

/// A program that is made from another one.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RescheduleFile {
    /// The method.
    pub method: MethodFile,
    /// Name of the program that it starts from.
    pub from: String,
    /// `s-theta`: clearance from both limits, degrees. `quaternion`: of the channel that is shown; it changes no axis.
    pub clearance_deg: Option<f64>,
    /// `s-theta`: distance of key points from the limits, degrees.
    pub inset_deg: Option<f64>,
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
}

impl MethodFile {
    /// Every method with its name.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("s-theta", Self::STheta),
        ("quaternion", Self::Quaternion),
        ("singularity", Self::Singularity),
        ("min-angular-acceleration", Self::MinAngularAcceleration),
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
    pub const OPTIONS: [&'static str; 12] = [
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
    ];

    /// Options that a method reads.
    pub fn options_of(method: MethodFile) -> &'static [&'static str] {
        match method {
            MethodFile::STheta => {
                &["clearance_deg", "inset_deg", "start_flat_mm", "end_flat_percent", "merge_mm", "theta_unit"]
            }
            MethodFile::Quaternion => &["clearance_deg", "keys"],
            MethodFile::Singularity => &["cone_deg", "rate_deg_mm", "junction"],
            MethodFile::MinAngularAcceleration => &["cap_deg", "window_mm"],
        }
    }

    /// Options that are given, as `KEY=VALUE`.
    pub fn given(&self) -> Vec<(&'static str, String)> {
        let number = |v: f64| v.to_string();
        let unit =
            |u: ThetaUnitFile| ThetaUnitFile::NAMES.iter().find(|(_, k)| *k == u).map_or("", |(n, _)| n).to_owned();
        let values = [
            self.clearance_deg.map(number),
            self.inset_deg.map(number),
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
        ];
        Self::OPTIONS.into_iter().zip(values).filter_map(|(key, value)| Some((key, value?))).collect()
    }

    /// An option that is given and that the method does not read.
    pub fn unread(&self) -> Option<&'static str> {
        let read = Self::options_of(self.method);
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
            "inset_deg" => self.inset_deg = Some(number()?),
            "start_flat_mm" => self.start_flat_mm = Some(number()?),
            "end_flat_percent" => self.end_flat_percent = Some(number()?),
            "merge_mm" => self.merge_mm = Some(number()?),
            "cone_deg" => self.cone_deg = Some(number()?),
            "rate_deg_mm" => self.rate_deg_mm = Some(number()?),
            "cap_deg" => self.cap_deg = Some(number()?),
            "window_mm" => self.window_mm = Some(number()?),
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
                self.keys = Some(count);
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
        }
    }

    /// The method with its parameters.
    pub fn method(&self) -> Box<dyn Method> {
        let defaults = STheta::default();
        let clearance = self.clearance_deg.map_or(defaults.clearance, |d| d * TAU / 360.0);
        match self.method {
            MethodFile::STheta => Box::new(STheta {
                clearance,
                inset: self.inset_deg.map_or(defaults.inset, |d| d * TAU / 360.0),
                unit: match self.theta_unit {
                    None | Some(ThetaUnitFile::Degree) => ThetaUnit::Degree,
                    Some(ThetaUnitFile::Radian) => ThetaUnit::Radian,
                    Some(ThetaUnitFile::Normalized) => ThetaUnit::Normalized,
                    Some(ThetaUnitFile::UnitFree) => ThetaUnit::UnitFree,
                },
                start_flat: self.start_flat_mm.unwrap_or(defaults.start_flat),
                end_flat: self.end_flat_percent.map_or(defaults.end_flat, |p| p / 100.0),
                merge: self.merge_mm.unwrap_or(defaults.merge),
            }),
            MethodFile::Quaternion => {
                Box::new(Quaternion { keys: self.keys.unwrap_or(Quaternion::default().keys), clearance })
            }
            MethodFile::MinAngularAcceleration => {
                let defaults = MinAngularAcceleration::default();
                Box::new(MinAngularAcceleration {
                    cap: self.cap_deg.map_or(defaults.cap, |d| d * TAU / 360.0),
                    window: self.window_mm.unwrap_or(defaults.window),
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
