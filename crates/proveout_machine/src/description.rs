//! The content of `machine.toml` as written: one Rust type per table, one field per key. The JSON Schema is
//! generated from these types.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::{
    Carries, JointKind, RapidMode, drive_file::DriveFile, errors_reader::ErrorsFile, platform_reader::PlatformFile,
    reading::Notes,
};

/// A machine tool: joints, spindle, table, control and bodies.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MachineFile {
    /// Name of the machine.
    pub(crate) name: String,
    /// Description for the reader.
    #[serde(default)]
    pub(crate) description: String,
    /// Direction against gravity in machine coordinates, a unit vector; loads by weight are not known without
    /// it.
    pub(crate) up: Option<[f64; 3]>,
    /// Where control and programs count X, Y and Z from. Everything else of the file counts as it is written,
    /// with either word.
    #[serde(default)]
    pub(crate) zero: ZeroFile,
    /// glTF file with the meshes of bodies that name a node, in the folder of machine.toml.
    pub(crate) model: Option<String>,
    /// Axes, in the order of tables and reports.
    #[serde(default)]
    pub(crate) joint: Vec<JointFile>,
    /// Parallel sub-chains: pairs of joints that legs drive together.
    #[serde(default)]
    pub(crate) platform: Vec<PlatformFile>,
    /// Geometric errors, by which the actual machine differs from the one that the control believes in.
    pub(crate) errors: Option<ErrorsFile>,
    /// The spindle.
    pub(crate) spindle: SpindleFile,
    /// The surface that workpieces are clamped on.
    pub(crate) table: TableFile,
    /// The control.
    pub(crate) control: MachineControlFile,
    /// Mean densities of bodies that state no mass, for drive loads; without it such a body's mass is not
    /// known.
    pub(crate) body_density: Option<DensityFile>,
    /// Parts for collision checks and pictures.
    #[serde(default)]
    pub(crate) body: Vec<BodyFile>,
    /// Pairs of bodies with a rule of their own.
    #[serde(default)]
    pub(crate) pairs: Vec<PairFile>,
}

/// Zero of X, Y and Z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ZeroFile {
    /// As the file counts them.
    #[default]
    File,
    /// At home: travel, home and tool change position are those of the file less `home_mm`.
    Home,
}

/// One axis. A limit that is left out is reported as missing, and the gate that needs it stays unchecked.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct JointFile {
    /// Name, as programs address it: X, B, C.
    pub(crate) name: String,
    /// linear or rotary.
    pub(crate) kind: JointKind,
    /// tool or workpiece: what the joint carries.
    pub(crate) carries: Carries,
    /// Joint that this one is mounted on, or base.
    pub(crate) parent: String,
    /// Unit vector in machine coordinates with all joints at zero.
    pub(crate) direction: [f64; 3],
    /// A point on the axis of a rotary joint, machine coordinates with all joints at zero.
    pub(crate) point_mm: Option<[f64; 3]>,
    /// 1 or -1: physical motion of what the joint carries along or about the direction, for a growing value.
    /// Required for rotary joints; linear joints have 1 when left out.
    pub(crate) sense: Option<f64>,
    /// Lowest and highest position of a linear joint.
    pub(crate) travel_mm: Option<[f64; 2]>,
    /// Lowest and highest position of a rotary joint.
    pub(crate) travel_deg: Option<[f64; 2]>,
    /// A rotary joint without end stops.
    #[serde(default)]
    pub(crate) endless: bool,
    /// The setup holds this joint at its home position; kinematics never moves it.
    #[serde(default)]
    pub(crate) held: bool,
    /// Highest velocity of a linear joint.
    pub(crate) max_velocity_mm_min: Option<f64>,
    /// Highest velocity of a rotary joint.
    pub(crate) max_velocity_deg_s: Option<f64>,
    /// Highest velocity of a rotary joint, in revolutions.
    pub(crate) max_velocity_rev_min: Option<f64>,
    /// Highest acceleration of a linear joint.
    pub(crate) max_acceleration_mm_s2: Option<f64>,
    /// Highest acceleration of a rotary joint.
    pub(crate) max_acceleration_deg_s2: Option<f64>,
    /// Highest jerk of a linear joint.
    pub(crate) max_jerk_mm_s3: Option<f64>,
    /// Highest jerk of a rotary joint.
    pub(crate) max_jerk_deg_s3: Option<f64>,
    /// Velocity of rapid moves of a linear joint.
    pub(crate) rapid_velocity_mm_min: Option<f64>,
    /// Velocity of rapid moves of a rotary joint.
    pub(crate) rapid_velocity_deg_s: Option<f64>,
    /// Velocity of rapid moves of a rotary joint, in revolutions.
    pub(crate) rapid_velocity_rev_min: Option<f64>,
    /// Home position of a linear joint, in machine coordinates: its position when the program begins, and its
    /// first reference point (G28; G30 where no tool change position is stated).
    pub(crate) home_mm: Option<f64>,
    /// Home position of a rotary joint, likewise.
    pub(crate) home_deg: Option<f64>,
    /// Position of a linear joint for a tool change; also its second reference point (G30, G30 P2).
    pub(crate) tool_change_mm: Option<f64>,
    /// Position of a rotary joint for a tool change, likewise.
    pub(crate) tool_change_deg: Option<f64>,
    /// Mass that the drive of a linear joint moves.
    pub(crate) moving_mass_kg: Option<f64>,
    /// Moment of inertia about the axis that the drive of a rotary joint moves.
    pub(crate) moving_inertia_kg_m2: Option<f64>,
    /// The drive: needed where the axis dynamics are simulated.
    pub(crate) drive: Option<DriveFile>,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// The spindle and its gauge line.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpindleFile {
    /// Joint that carries the spindle, or base.
    pub(crate) on: String,
    /// Middle of the gauge line in machine coordinates with all joints at zero: [0, 0, 0] where the axes read
    /// the place of the gauge line; where the axes are zero at home, its place at home.
    pub(crate) origin_mm: [f64; 3],
    /// Unit vector from the tool into the spindle.
    pub(crate) direction: [f64; 3],
    /// Highest speed.
    pub(crate) max_speed_rpm: Option<f64>,
    /// Time to reach the programmed speed from standstill, or to stop from it.
    pub(crate) start_time_s: f64,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// The clamping surface.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TableFile {
    /// Joint that carries the table, or base.
    pub(crate) on: String,
    /// Middle of the clamping surface in machine coordinates with all joints at zero.
    pub(crate) point_mm: [f64; 3],
    /// Unit vector out of the clamping surface.
    pub(crate) normal: [f64; 3],
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// A kinematics that programs switch on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum KinematicsFile {
    /// Tool center point control: TRAORI, G43.4, G43.5, G234, M128, FUNCTION TCPM.
    Tcp,
    /// Tilted working planes: G68.2, G254, CYCLE800, PLANE, cycle 19.
    TiltedPlane,
}

/// What the control does and takes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MachineControlFile {
    /// Control file that says what words of its programs mean: the name of a built-in one (fanuc-30i), or a
    /// path from the folder of this file.
    pub(crate) file: Option<String>,
    /// Interpolation cycle.
    pub(crate) cycle_time_ms: f64,
    /// Shortest time for preparing one block.
    pub(crate) block_time_ms: f64,
    /// Time of a tool change, once in its position.
    pub(crate) tool_change_time_s: f64,
    /// How rapids run: straight or independent.
    pub(crate) rapid_mode: RapidMode,
    /// Kinematics that programs may switch on; an empty list for a control that only moves its axes. A
    /// program that switches on another one is refused. Where the key is missing, it is not known, and every
    /// one is taken.
    pub(crate) kinematics: Option<Vec<KinematicsFile>>,
    /// Path tolerance where the program states none.
    pub(crate) default_tolerance_mm: f64,
    /// Tolerance of the tool orientation where the program states none; when left out, that of the tip over
    /// the way from the tip to the end of the cutting edges, at most 0.05 degrees.
    pub(crate) default_orientation_tolerance_deg: Option<f64>,
    /// Cone about a pole of the rotary axes, 0 to 5 degrees: a great circle of the tool axis that passes the
    /// pole nearer than this is led through it. 0.001 when left out.
    pub(crate) pole_cone_deg: Option<f64>,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// A part of the machine: boxes, cylinders, prisms, or a node of the model. Coordinates are those of the
/// machine with all joints at zero.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyFile {
    /// Name, unique in the machine.
    pub(crate) name: String,
    /// What it is: bed, column, table, spindle nose.
    pub(crate) role: String,
    /// Joint that carries it, or base.
    pub(crate) attached_to: String,
    /// Red, green, blue and, if wanted, alpha, 0 to 255.
    pub(crate) color: Option<Vec<u8>>,
    /// False for a body that is only drawn.
    pub(crate) check: bool,
    /// Mass, for drive loads; when left out, volume times the mean density of its role, where the machine
    /// states one.
    pub(crate) mass: Option<MassFile>,
    /// Node of the model file whose meshes, children included, make the body.
    pub(crate) node: Option<String>,
    /// Boxes.
    #[serde(default, rename = "box")]
    pub(crate) boxes: Vec<BoxFile>,
    /// Cylinders and cones.
    #[serde(default, rename = "cylinder")]
    pub(crate) cylinders: Vec<CylinderFile>,
    /// Convex outlines with a thickness.
    #[serde(default, rename = "prism")]
    pub(crate) prisms: Vec<PrismFile>,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// Mass of a body: what it weighs, or the density of its shape. Coordinates are those of the machine with all
/// joints at zero.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MassFile {
    /// Mass. Without center and inertia the mass is spread evenly over the shape, and the body counts as
    /// estimated.
    pub(crate) mass_kg: Option<f64>,
    /// Instead of the mass: mean density over the shape as drawn, hollows included (solid steel 7850, solid
    /// cast iron 7200; ribbed castings a quarter to a half). The body counts as estimated.
    pub(crate) density_kg_m3: Option<f64>,
    /// Center of mass.
    pub(crate) center_mm: Option<[f64; 3]>,
    /// Inertia about the center, along the machine axes: xx, yy, zz, xy, yz, zx, where xy is minus the
    /// integral of x y.
    pub(crate) inertia_kg_m2: Option<[f64; 6]>,
}

/// Mean densities of the bodies that state no mass of their own, over their shapes as drawn, hollows
/// included. Such bodies count as estimated.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DensityFile {
    /// Bodies of every role that is not named.
    pub(crate) default_kg_m3: f64,
    /// Bodies of a role, by its name.
    #[serde(default)]
    pub(crate) roles_kg_m3: BTreeMap<String, f64>,
    /// Where numbers of this table come from.
    #[serde(default)]
    pub(crate) source: Notes,
    /// Numbers of this table that were chosen, and why.
    #[serde(default)]
    pub(crate) chosen: Notes,
}

/// Two bodies with a rule of their own: either another near-miss distance, or no check of one against the
/// other.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PairFile {
    /// Two bodies of this file, or one and a part of any tool: cutter, neck, shank, holder.
    pub(crate) bodies: [String; 2],
    /// Distance that they are to keep, instead of that of the scene.
    pub(crate) near_miss_mm: Option<f64>,
    /// False: they are not checked against each other, and the verdict says so with the reason.
    pub(crate) check: Option<bool>,
    /// Why; needed where they are not checked.
    pub(crate) reason: Option<String>,
}

/// A box along the machine axes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BoxFile {
    /// Corner with the smallest coordinates.
    pub(crate) min_mm: [f64; 3],
    /// Corner with the largest coordinates.
    pub(crate) max_mm: [f64; 3],
}

/// A cylinder, or the frustum of a cone.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CylinderFile {
    /// Middle of the first end.
    pub(crate) from_mm: [f64; 3],
    /// Middle of the second end.
    pub(crate) to_mm: [f64; 3],
    /// Radius, at the first end.
    pub(crate) radius_mm: f64,
    /// Radius at the second end, where it differs.
    pub(crate) end_radius_mm: Option<f64>,
}

/// Axis along which an outline is drawn out.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum AlongFile {
    /// Outline in (y, z).
    X,
    /// Outline in (z, x).
    Y,
    /// Outline in (x, y).
    Z,
}

/// A convex outline drawn out along a machine axis.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrismFile {
    /// x, y or z.
    pub(crate) along: AlongFile,
    /// Lowest and highest coordinate along the axis.
    pub(crate) range_mm: [f64; 2],
    /// Corners of the outline, counter-clockwise: (y, z) along x, (z, x) along y, (x, y) along z.
    pub(crate) outline_mm: Vec<[f64; 2]>,
}

/// JSON Schema of `machine.toml`.
pub fn machine_schema() -> schemars::Schema {
    schemars::schema_for!(MachineFile)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_names_every_table_and_closes_it() {
        let schema = machine_schema().to_value();
        for key in ["name", "joint", "spindle", "table", "control", "body", "model", "platform", "errors"] {
            assert!(schema["properties"][key].is_object(), "{key}");
        }
        let joint = &schema["$defs"]["JointFile"];
        assert_eq!(joint["additionalProperties"], false);
        assert!(joint["properties"]["max_jerk_deg_s3"]["description"].as_str().is_some_and(|d| d.contains("jerk")));
        let required: Vec<&str> =
            joint["required"].as_array().expect("list").iter().filter_map(|v| v.as_str()).collect();
        assert_eq!(required, ["name", "kind", "carries", "parent", "direction"]);
    }
}
