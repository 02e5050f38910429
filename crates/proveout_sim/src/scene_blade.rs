//! Blades and re-scheduling, as they stand in a scene.

use std::f64::consts::TAU;

use proveout_geom::blade::{Blade, BladeError, BladeSpec, CamberSection, Platform};
use proveout_geom::rad;
use proveout_toolpath::reschedule::{Method, Quaternion, STheta, ThetaUnit};
use schemars::JsonSchema;
use serde::Deserialize;

/// A blade along +X of the workpiece frame: circles on a circular camber line, stacked on their centroid, on a platform whose
/// top face is X = 0.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BladeFile {
    /// Chord of the camber line, mm.
    pub chord_mm: f64,
    /// Angle between the tangents at its ends, degrees.
    pub camber_angle_deg: f64,
    /// Largest thickness, mm.
    pub thickness_mm: f64,
    /// Radius of the leading edge, mm.
    pub leading_radius_mm: f64,
    /// Radius of the trailing edge, mm.
    pub trailing_radius_mm: f64,
    /// Height above the platform, mm.
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
    /// Numbers that make no blade.
    pub fn blade(&self, allowance: f64) -> Result<Blade, BladeError> {
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
    /// `s-theta`: unit of theta in the construction of corners.
    pub theta_unit: Option<ThetaUnitFile>,
    /// `quaternion`: key blocks of a layer.
    pub keys: Option<usize>,
}

/// Methods that re-plan tool axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MethodFile {
    /// Li et al. 2022.
    STheta,
    /// Ho, Hwang, Hu 2003.
    Quaternion,
}

impl MethodFile {
    /// Every method with its name.
    pub const NAMES: [(&'static str, Self); 2] = [("s-theta", Self::STheta), ("quaternion", Self::Quaternion)];
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

impl RescheduleFile {
    /// Keys of options, in the order of the scene file.
    pub const OPTIONS: [&'static str; 4] = ["clearance_deg", "inset_deg", "theta_unit", "keys"];

    /// Options that a method reads.
    pub fn options_of(method: MethodFile) -> &'static [&'static str] {
        match method {
            MethodFile::STheta => &["clearance_deg", "inset_deg", "theta_unit"],
            MethodFile::Quaternion => &["clearance_deg", "keys"],
        }
    }

    /// Options that are given, as `KEY=VALUE`.
    pub fn given(&self) -> Vec<(&'static str, String)> {
        let degrees = |v: f64| v.to_string();
        let unit =
            |u: ThetaUnitFile| ThetaUnitFile::NAMES.iter().find(|(_, k)| *k == u).map_or("", |(n, _)| n).to_owned();
        let values = [
            self.clearance_deg.map(degrees),
            self.inset_deg.map(degrees),
            self.theta_unit.map(unit),
            self.keys.map(|k| k.to_string()),
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
            number.ok_or_else(|| (format!("{key}={value} is no number"), "write degrees with a point".to_owned()))
        };
        match key {
            "clearance_deg" => self.clearance_deg = Some(number()?),
            "inset_deg" => self.inset_deg = Some(number()?),
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
        Self { method, from: from.to_owned(), clearance_deg: None, inset_deg: None, theta_unit: None, keys: None }
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
                ..defaults
            }),
            MethodFile::Quaternion => {
                Box::new(Quaternion { keys: self.keys.unwrap_or(Quaternion::default().keys), clearance })
            }
        }
    }
}
