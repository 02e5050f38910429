//! How a part is set up: its mounting, fixtures, work offsets, and the state of the machine before
//! the first block.

use std::path::PathBuf;

use proveout_geom::{Pose, Vector, rad};
use proveout_nc::WorkOffset;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::scene::{
    BoxFile, CylinderFile,
    fixture::{self, FixtureKindFile},
    mesh_unit::MeshUnitFile,
    step_file::{self, NamedMesh},
};

/// Where the workpiece frame sits in the table frame (which equals the machine frame when all joints are at
/// zero).
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mount {
    /// Origin of the workpiece frame, mm.
    #[serde(default)]
    pub translation_mm: [f64; 3],
    /// Turns about the fixed x, y and z axes, in this order, degrees.
    #[serde(default)]
    pub rotation_deg: [f64; 3],
    /// The place was assumed, not given: findings about what is mounted on the table say so.
    #[serde(default)]
    pub assumed: bool,
}

impl Mount {
    /// Workpiece frame to table frame.
    pub fn table_from_work(&self) -> Pose {
        let [x, y, z] = self.rotation_deg.map(rad);
        Pose::from_rpy(Vector::from(self.translation_mm), x, y, z)
    }
}

/// A body mounted on the table or on the bed.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixtureFile {
    /// Name in findings.
    pub name: String,
    /// Mesh file, mm, or a STEP file.
    #[schemars(with = "Option<PathBuf>")]
    pub mesh: Option<Spanned<PathBuf>>,
    /// Unit of the numbers of `mesh`, which is converted to millimeters: `mm`, `cm`, `m` or `inch`.
    /// Millimeters when left out; a mesh that cannot be a fixture of the stock is refused then. Say `mm`
    /// where the size is meant.
    pub mesh_unit: Option<MeshUnitFile>,
    /// Of a STEP file: largest distance of its mesh from the exact surfaces that is asked for, micrometers;
    /// 5 when left out, which is reported as assumed. The distance that is measured counts.
    pub chord_um: Option<f64>,
    /// Block.
    #[serde(rename = "box")]
    pub block: Option<BoxFile>,
    /// Round body.
    pub cylinder: Option<CylinderFile>,
    /// A fixture by its dimensions: each kind needs its own ones, and refuses those of others.
    pub kind: Option<FixtureKindFile>,
    /// Of a kind, its place: `vise` middle between the jaws at their upper edge, `plate` middle of the upper
    /// face, `chuck` middle of the front face, `tombstone` middle of the foot, `toe-clamp` on the edge of the
    /// part, under the toe.
    pub at_mm: Option<[f64; 3]>,
    /// Of a kind, its turns at that place about the fixed x, y and z axes, in this order; none when left out.
    pub rotation_deg: Option<[f64; 3]>,
    /// Of a vise: distance of the jaws, which close along y.
    pub opening_mm: Option<f64>,
    /// Width of the jaws of a vise (along x) or of a chuck.
    pub jaw_width_mm: Option<f64>,
    /// Height of the jaws of a vise over its bed, or of a chuck over its front face.
    pub jaw_height_mm: Option<f64>,
    /// Thickness of the jaws of a vise.
    pub jaw_thickness_mm: Option<f64>,
    /// Height of the bed of a vise below its jaws.
    pub bed_height_mm: Option<f64>,
    /// Length of a plate (along x), of a chuck from its front face to its back, of the bar of a toe
    /// clamp.
    pub length_mm: Option<f64>,
    /// Width of a plate (along y) or of a toe clamp.
    pub width_mm: Option<f64>,
    /// Thickness of a plate or of the bar of a toe clamp.
    pub thickness_mm: Option<f64>,
    /// Diameter of a chuck.
    pub diameter_mm: Option<f64>,
    /// Diameter on which the jaws of a chuck grip.
    pub grip_diameter_mm: Option<f64>,
    /// Number of jaws of a chuck, 2 to 8.
    pub jaws: Option<u32>,
    /// Side of the square column of a tombstone.
    pub side_mm: Option<f64>,
    /// Height of a tombstone with its foot; of a toe clamp, from the table to the toe.
    pub height_mm: Option<f64>,
    /// Side of the square foot of a tombstone.
    pub base_side_mm: Option<f64>,
    /// Thickness of that foot.
    pub base_thickness_mm: Option<f64>,
    /// How far the toe of a clamp lies over the part.
    pub reach_mm: Option<f64>,
    /// Diameter of the stud of a toe clamp.
    pub stud_diameter_mm: Option<f64>,
    /// Height of that stud above the bar.
    pub stud_height_mm: Option<f64>,
    /// Coordinates are those of the workpiece frame (default) or of the table frame.
    #[serde(default)]
    pub frame: FixtureFrame,
    /// Where the numbers come from.
    #[serde(default)]
    pub source: String,
}

impl FixtureFile {
    /// Its mesh, where it has one.
    pub(crate) fn named_mesh(&self) -> Option<NamedMesh<'_>> {
        let (unit, chord_um) = (self.mesh_unit, self.chord_um);
        self.mesh.as_ref().map(|file| NamedMesh { file, unit, chord_um })
    }
}

/// What is wrong with the fixtures of a scene: offset in its text, message and help.
pub(crate) fn fixture_fault(text: &str, fixtures: &[FixtureFile]) -> Option<(usize, String, String)> {
    let place = |k: usize| text.match_indices("[[fixture]]").nth(k).map_or(0, |(at, _)| at);
    fixtures.iter().enumerate().find_map(|(k, fixture)| {
        let name = &fixture.name;
        let (message, help) = if name.trim().is_empty() {
            ("a fixture has no name".to_owned(), "name it: findings refer to it by its name")
        } else if name == "stock" {
            (
                "a fixture is named \"stock\", which is the name of the stock in findings".to_owned(),
                "give it another name",
            )
        } else if fixtures[..k].iter().any(|f| f.name == *name) {
            (
                format!("two fixtures have the name {name:?}: findings could not distinguish them"),
                "give each fixture its own name",
            )
        } else {
            let forms =
                [fixture.mesh.is_some(), fixture.block.is_some(), fixture.cylinder.is_some(), fixture.kind.is_some()];
            if forms.iter().filter(|f| **f).count() != 1 {
                (format!("fixture {name:?} needs exactly one form"), "give one of `mesh`, `box`, `cylinder`, `kind`")
            } else if fixture.mesh_unit.is_some() && fixture.mesh.is_none() {
                (format!("`mesh_unit` of fixture {name:?} has no mesh to convert"), "leave it out, or give `mesh`")
            } else if let Some((key, message, help)) =
                step_file::fault(fixture.mesh.as_ref(), fixture.mesh_unit, fixture.chord_um)
            {
                return Some((key_in(text, place(k), key), format!("fixture {name:?}: {message}"), help));
            } else if let Some((key, message, help)) = fixture::fault(fixture) {
                return Some((key_in(text, place(k), key), message, help));
            } else if fixture.kind.is_some() && fixture.at_mm.is_none() {
                (format!("fixture {name:?} has no place"), "add at_mm")
            } else if fixture.block.is_some_and(|b| (0..3).any(|i| b.min_mm[i] >= b.max_mm[i])) {
                (format!("the box of fixture {name:?} is empty"), "min_mm must be below max_mm")
            } else if fixture.cylinder.is_some_and(|c| c.radius_mm <= 0.0 || c.height_mm <= 0.0) {
                (format!("the cylinder of fixture {name:?} is empty"), "radius_mm and height_mm must be above 0")
            } else {
                return None;
            }
        };
        Some((place(k), message, help.to_owned()))
    })
}

/// Place of a key after another place, up to the next table; that place where the key is not
/// written there.
fn key_in(text: &str, from: usize, key: &str) -> usize {
    let behind = text.get(from..).unwrap_or_default();
    let mut at = from;
    for (number, line) in behind.split_inclusive('\n').enumerate() {
        if number > 0 && line.starts_with('[') {
            break;
        }
        if line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('=')) {
            return at;
        }
        at += line.len();
    }
    from
}

/// Frame of a fixture's coordinates; it moves with the table in both cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FixtureFrame {
    /// Workpiece frame.
    #[default]
    Workpiece,
    /// Table frame.
    Table,
}

/// A work offset of the control.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case, reason = "axis letters as the machinist writes them")]
pub struct OffsetFile {
    /// mm.
    #[serde(default)]
    pub X_mm: f64,
    /// mm.
    #[serde(default)]
    pub Y_mm: f64,
    /// mm.
    #[serde(default)]
    pub Z_mm: f64,
    /// degrees.
    #[serde(default)]
    pub A_deg: f64,
    /// degrees.
    #[serde(default)]
    pub B_deg: f64,
    /// degrees.
    #[serde(default)]
    pub C_deg: f64,
}

impl From<&OffsetFile> for WorkOffset {
    fn from(o: &OffsetFile) -> Self {
        Self { translation: [o.X_mm, o.Y_mm, o.Z_mm], rotary: [rad(o.A_deg), rad(o.B_deg), rad(o.C_deg)] }
    }
}

/// State of the machine before the first block of each program.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StartFile {
    /// Number of the tool in the spindle, for programs that call none before they cut; an empty
    /// spindle when left out. Its length is active wherever it is after a tool change (840D,
    /// Klartext, CL data), elsewhere after G43.
    pub tool: Option<u32>,
}
