//! Blades and re-scheduling, as written in a scene.

use proveout_blade::{Blade, BladeEnd, BladeError, BladeSpec, CamberSection, Plate, Platform};
use proveout_geom::rad;
use schemars::JsonSchema;
use serde::Deserialize;

/// A blade along +X of the workpiece frame, or a face. Kind `camber`: circles on a circular camber line,
/// stacked on their centroid, on a platform whose top face is X = 0.
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
    /// Chord error asked of the mesh that approximates the blade on the rays, in the pictures and
    /// as stock, mm. Its actual error is measured and given in the verdict as `mesh_error_mm`;
    /// points of the cut part are compared with the closed form.
    pub chord_error_mm: f64,
}

/// Marks a number that the scene does not give: whether it may be left out depends on the kind, see
/// [`BladeFile::fault`].
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
    /// A key that its kind needs and that is left out, or that it does not read: what is wrong, and what to
    /// write. `sections`: whether the part names a file of sections.
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
            return Some((format!("a blade of kind {name:?} does not read `{key}`"), "remove the key".into()));
        }
        let of_sections = kind == BladeKindFile::Sections;
        match (of_sections, sections) {
            (true, false) => {
                Some(("a blade of kind \"sections\" needs its file".into(), "give `sections` in [part]".into()))
            }
            (false, true) => {
                Some((format!("a blade of kind {name:?} reads no sections"), "remove `sections` from [part]".into()))
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
