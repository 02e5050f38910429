//! What a run says: `verdict.json`.

use std::collections::BTreeMap;

use proveout_collision::Unchecked;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::verdict::partial_run::{Partial, PreviewUsed, Stopped};
pub use crate::verdict::scallop_figures::{
    Scallop, ScallopBar, ScallopHeights, ScallopPass, ScallopPatch, ScallopRegion,
};
use crate::verdict::{finding::Finding, gate::Gate};

/// Version of the layout of [`Verdict`]; raised when a key changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// Judgement of a gate or of the whole run. `Unchecked` never counts as `Pass`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Checked, and nothing was found.
    Pass,
    /// Checked, and at least one error was found.
    Fail,
    /// Not checked, or not wholly; the reason says what was left out.
    Unchecked,
    /// A question that the scene does not ask, such as roughness without a tolerance: the gate has no part in
    /// the verdict. A whole run never has this state.
    NotAsked,
}

impl State {
    /// The state as people read it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Unchecked => "unchecked",
            Self::NotAsked => "not asked",
        }
    }

    /// The state as the name of a class on pages, and as `verdict.json` has it.
    pub fn class(self) -> &'static str {
        match self {
            Self::NotAsked => "not_asked",
            other => other.word(),
        }
    }
}

/// One question that a program must pass before it goes to the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Gate")]
pub struct GateVerdict {
    /// `program`, `limits`, `process`, `collision`, `near_miss`, `gouge`, `excess` or `surface`.
    #[serde(rename = "name")]
    #[schemars(with = "String")]
    pub gate: Gate,
    /// Judgement.
    pub state: State,
    /// Why, in words.
    pub reason: String,
}

/// Everything that a run says and that does not depend on the clock of the host (`verdict.json`).
///
/// All keys are always present; a value that was not checked is `null` and its gate says why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Name of the scene.
    pub scene: String,
    /// Name of the program within the scene, or the file name.
    pub program: String,
    /// The machine that ran it.
    #[serde(default)]
    pub machine: MachineUsed,
    /// SHA-256 of every input file, by role (`scene`, `machine`, `tools`, `program`, `stock`, `part`, ...).
    pub digests: BTreeMap<String, String>,
    /// Values of the call that override those in the files (`run --set`, sweeps), by key; `digests`
    /// are those of the files.
    #[serde(default)]
    pub set: BTreeMap<String, String>,
    /// The whole run: fail if one gate fails, else unchecked if one is unchecked, else pass; gates that are
    /// not asked have no part in it.
    pub verdict: State,
    /// The gates, in fixed order.
    pub gates: Vec<GateVerdict>,
    /// In what the run is less than the whole check (`run --preview`, `run --stop-at`); null where it is
    /// whole.
    #[serde(default)]
    pub partial: Option<Partial>,
    /// What was found, in order of time.
    pub findings: Vec<Finding>,
    /// Cycle time.
    pub time: Time,
    /// Extremes of every joint, by name; mm or degrees, seconds.
    pub axes: BTreeMap<String, Axis>,
    /// Path figures.
    pub path: Path,
    /// Material removal.
    pub removal: Removal,
    /// Cut part against the design.
    pub deviation: Deviation,
    /// Texture of the surface.
    pub surface: Surface,
    /// Interference.
    pub clearance: Clearance,
    /// Use of each tool, in order of first use.
    pub tools: Vec<ToolUse>,
    /// Features measured on the cut part by the scene's inspection plan.
    pub inspection: Vec<Inspected>,
    /// What the probing motions of the program have met, in their order; empty where it does not probe with a
    /// tool of kind `probe`.
    #[serde(default)]
    pub probing: Vec<Probed>,
}

/// One probing motion of the program with what is true of it. All in the workpiece frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Probed {
    /// Program file as given.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Tool in the spindle; null for an empty one.
    pub tool: Option<String>,
    /// Diameter of the ball of the stylus, mm; null where the tool is no probe: what it finds is then not
    /// known.
    pub ball_diameter_mm: Option<f64>,
    /// What was touched: `stock` or the name of a fixture; null where nothing was, and for a motion that
    /// leaves a surface.
    pub met: Option<String>,
    /// Center of the ball where the motion has ended, mm.
    pub center_mm: Option<[f64; 3]>,
    /// Place that was touched, mm.
    pub point_mm: Option<[f64; 3]>,
    /// Outward unit normal there.
    pub normal: Option<[f64; 3]>,
    /// The true touch is within this of `center_mm` along the normal, mm.
    pub bound_mm: Option<f64>,
}

/// The machine of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MachineUsed {
    /// Name in its `machine.toml`.
    pub name: String,
    /// SHA-256 of its `machine.toml`, as under `machine` in `digests`; the limits that the scene lowers are
    /// not in it.
    pub digest: String,
}

impl Verdict {
    /// Names of the gates that the scene does not ask.
    pub fn not_asked(&self) -> Vec<&str> {
        self.gates.iter().filter(|g| g.state == State::NotAsked).map(|g| g.gate.name()).collect()
    }
}

/// Cycle time in seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Time {
    /// From the first command to the end of the program.
    pub total_s: f64,
    /// Motion in feed.
    pub cutting_s: f64,
    /// Motion at rapid rate.
    pub rapid_s: f64,
    /// Programmed dwell and waiting for the spindle.
    pub dwell_s: f64,
    /// Tool changes.
    pub tool_change_s: f64,
    /// No controller can be below: a bound for every motion within the tolerances of the programmed
    /// path, whatever path it takes there, under the same feeds, velocities and accelerations of
    /// the joints, that stops where the program stops.
    pub lower_bound_s: Option<f64>,
    /// The same for the path that is run alone, with these roundings of its corners: no controller can run it
    /// in less. Another rounding within the tolerance may be faster.
    #[serde(default)]
    pub path_bound_s: Option<f64>,
}

/// Unit of the position of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AxisUnit {
    /// Millimeters, of a linear joint.
    #[default]
    Mm,
    /// Degrees, of a rotary joint.
    Deg,
}

impl AxisUnit {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Deg => "deg",
        }
    }
}

/// Extremes of one joint; mm or degrees, seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Axis {
    /// Unit of length.
    pub unit: AxisUnit,
    /// Smallest position.
    pub min: f64,
    /// Largest position.
    pub max: f64,
    /// Largest speed.
    pub max_velocity: f64,
    /// Largest acceleration.
    pub max_acceleration: f64,
    /// Largest jerk.
    pub max_jerk: f64,
    /// Largest speed over its limit; null without a limit.
    pub velocity_utilisation: Option<f64>,
    /// Largest acceleration over its limit; null without a limit.
    pub acceleration_utilisation: Option<f64>,
    /// Largest jerk over its limit; null without a limit.
    pub jerk_utilisation: Option<f64>,
    /// Number of reversals of direction.
    pub reversals: u64,
    /// Largest distance of the actual from the commanded position; null when the drives are not simulated.
    pub max_following_error: Option<f64>,
    /// Largest force or torque of the drive; null when the drives are not simulated.
    #[serde(default)]
    pub max_drive_force: Option<f64>,
    /// Unit of the force: `N` or `Nm`.
    #[serde(default)]
    pub drive_force_unit: Option<String>,
    /// Largest force over the limit of the drive; null without a limit.
    #[serde(default)]
    pub drive_utilisation: Option<f64>,
    /// Largest mechanical power of the drive to either side, W.
    #[serde(default)]
    pub max_drive_power_w: Option<f64>,
    /// Work that the drive has drawn, J, without what braking gives back.
    #[serde(default)]
    pub drive_energy_j: Option<f64>,
}

/// Path figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Path {
    /// Executed blocks with motion.
    pub blocks: u64,
    /// Length of the tip's path that is run, with its corners rounded, mm.
    pub length_mm: f64,
    /// Largest distance of the straight pieces from the path that they approximate, mm.
    pub max_chord_error_mm: Option<f64>,
    /// Largest distance of the tip from the programmed path (corner rounding; following error in feed), mm:
    /// measured against the words of the program, not against what the control made of them.
    pub max_contour_error_mm: Option<f64>,
    /// Largest angle between the tool axis and the programmed one at the same share of the block's way,
    /// degrees; likewise.
    #[serde(default)]
    pub max_axis_error_deg: Option<f64>,
    /// Smallest ratio of reached to programmed feed along the path that is run: where the feed falls between
    /// the ramps from and to standstills and rapid motions, at the control samples; where a motion between
    /// them does not reach it, the most that it reaches; and what the velocities of the joints allow in a
    /// block.
    pub min_feed_ratio: Option<f64>,
}

/// Material removal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Removal {
    /// Swept pieces.
    pub moves: u64,
    /// Removed volume, mm³.
    pub volume_mm3: f64,
    /// Stock that is left, mm³.
    pub stock_left_mm3: f64,
    /// Volume of the parts that were cut off and fell out of the stock, mm³; it is not in `volume_mm3`.
    #[serde(default)]
    pub fallen_mm3: f64,
    /// Bound on the distance of a dexel end from the exact swept surface, mm.
    pub sweep_bound_mm: f64,
    /// Distance of neighboring rays, mm: the largest of `cells_mm`.
    pub cell_mm: f64,
    /// Edges of the cells along x, y and z, mm.
    #[serde(default)]
    pub cells_mm: [f64; 3],
    /// Where the stock was taken over from an earlier run into another pose or other cells: largest distance
    /// of its faces from those that the earlier run left, mm; null where nothing was lost.
    #[serde(default)]
    pub regrid_bound_mm: Option<f64>,
    /// The same within a cell of edges and of details thinner than a cell, mm.
    #[serde(default)]
    pub regrid_edge_bound_mm: Option<f64>,
    /// Boxes in which the surface was taken from finer cells.
    #[serde(default)]
    pub patches: Vec<PatchUsed>,
}

/// A patch of the stock: deviation, gouge and excess, inspection and surface inside of its box are those of
/// its cells. Volume, process, collision and near-miss are judged on the stock.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PatchUsed {
    /// Name in the scene.
    pub name: String,
    /// Smallest coordinates of its box, workpiece frame, mm.
    pub min_mm: [f64; 3],
    /// Largest coordinates.
    pub max_mm: [f64; 3],
    /// Edges of its cells along x, y and z, mm.
    pub cells_mm: [f64; 3],
    /// Largest error of the surface that the sweeps left in it, mm.
    pub sweep_bound_mm: f64,
    /// As `regrid_bound_mm` of the stock.
    pub regrid_bound_mm: Option<f64>,
    /// As `regrid_edge_bound_mm` of the stock.
    pub regrid_edge_bound_mm: Option<f64>,
    /// Exact surface points in the box.
    pub points: u64,
}

/// Cut part against the design part. Positive is material left, negative is gouge.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Deviation {
    /// What the points of the cut part are compared with: `mesh`, `closed form of the blade` or
    /// `closed form of the cone`.
    #[serde(default)]
    pub against: Option<String>,
    /// Error of that design, mm: the chord error that the scene states for a mesh, the numerical error of a
    /// closed form.
    #[serde(default)]
    pub design_error_mm: Option<f64>,
    /// Largest distance of the design's mesh from the design, mm: as the scene states it, or as measured
    /// where the design has a closed form. Missing walls are looked for on rays through the mesh; null where
    /// there is none.
    #[serde(default)]
    pub mesh_error_mm: Option<f64>,
    /// Chord error that the scene asks of that mesh where the design has a closed form, mm; null elsewhere.
    #[serde(default)]
    pub mesh_asked_mm: Option<f64>,
    /// Deviations below this may come from the error of the design (`design_error_mm`) or the sweep bound,
    /// mm.
    pub tolerance_floor_mm: Option<f64>,
    /// Deepest gouge, mm, as a positive number: of the points of the cut part, or of the material that is
    /// missing on a ray where that is more (a wall that is gone counts with its thickness).
    pub gouge_max_mm: Option<f64>,
    /// Largest excess, mm.
    pub excess_max_mm: Option<f64>,
    /// Mean of the signed deviation, mm.
    pub mean_mm: Option<f64>,
    /// Root mean square of the deviation, mm.
    pub rms_mm: Option<f64>,
    /// Area that is gouged by more than the tolerance, mm².
    pub gouge_area_mm2: Option<f64>,
    /// Number of surface points measured.
    pub samples: Option<u64>,
    /// Point of the largest absolute deviation in the workpiece frame, mm.
    pub worst_point: Option<[f64; 3]>,
    /// Connected areas that are gouged deeper than allowed.
    #[serde(default)]
    pub gouges: Option<u64>,
    /// Their volume, mm³.
    #[serde(default)]
    pub gouge_volume_mm3: Option<f64>,
    /// Connected areas on which more material is left than allowed.
    #[serde(default)]
    pub excesses: Option<u64>,
    /// Its volume, mm³.
    #[serde(default)]
    pub excess_volume_mm3: Option<f64>,
    /// Threads that taps have cut outside of the core holes of the design: they count as no gouge.
    #[serde(default)]
    pub threads: Option<u64>,
    /// Their volume between core and outer diameter, mm³.
    #[serde(default)]
    pub thread_volume_mm3: Option<f64>,
    /// Sheets of material above the design by more than allowed that are no thicker than `film_thickness_mm`:
    /// they count for nothing else.
    #[serde(default)]
    pub films: Option<u64>,
    /// Their volume, mm³.
    #[serde(default)]
    pub film_volume_mm3: Option<f64>,
    /// The highest of them above the design, mm; null where there is none.
    #[serde(default)]
    pub film_max_mm: Option<f64>,
    /// A sheet that is thinner may not be there, mm: twice what each of its faces is known to (bounds of
    /// sweeps and of pieces of motion), and at most the excess that is allowed.
    #[serde(default)]
    pub film_thickness_mm: Option<f64>,
}

/// Smallest, mean and largest of a roughness parameter, micrometer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spread {
    /// Smallest.
    pub min: f64,
    /// Mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// Texture of the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Surface {
    /// Largest scallop, µm.
    pub scallop_max_um: Option<f64>,
    /// Mean scallop, µm.
    pub scallop_mean_um: Option<f64>,
    /// 95th percentile of the scallop, µm.
    #[serde(default)]
    pub scallop_p95_um: Option<f64>,
    /// The ridges between the passes in figures; null where the scene sets no tolerance for them.
    #[serde(default)]
    pub scallop: Option<Scallop>,
    /// Number of evaluated patches.
    pub patches: Option<u64>,
    /// ISO 21920 Ra.
    pub ra_um: Option<Spread>,
    /// ISO 21920 Rz.
    pub rz_um: Option<Spread>,
    /// ISO 25178 Sa of the unfiltered patches.
    pub sa_um: Option<Spread>,
    /// ISO 25178 Sz of the unfiltered patches.
    pub sz_um: Option<Spread>,
    /// The filter chain in words.
    pub filter: Option<String>,
    /// Patches and profiles of `[surface]`, in the order of the scene.
    #[serde(default)]
    pub textures: Vec<TextureUsed>,
}

/// The texture of one patch or profile. Heights are those of the kinematic surface, exact for the motion;
/// what else the process leaves is `residual`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TextureUsed {
    /// Name in the scene.
    pub name: String,
    /// Middle on the design, workpiece frame, mm.
    pub at_mm: [f64; 3],
    /// Outward normal of the design there.
    pub normal: [f64; 3],
    /// `envelope` or `teeth`.
    pub model: String,
    /// Tools that come near.
    pub tools: Vec<String>,
    /// Sides of the patch, mm; null for a profile of its own.
    pub size_mm: Option<[f64; 2]>,
    /// Spacing of its nodes, µm.
    pub step_um: Option<f64>,
    /// Nodes.
    pub nodes: u64,
    /// Nodes that no motion cuts.
    pub uncut: u64,
    /// Whether every node has its row in `surface.parquet`.
    pub nodes_in_table: bool,
    /// Sa of the unfiltered map (ISO 25178-2), µm; null where nodes are not cut.
    pub sa_um: Option<f64>,
    /// Sq, likewise.
    pub sq_um: Option<f64>,
    /// Sz, likewise.
    pub sz_um: Option<f64>,
    /// Everything about the map: filtered and unfiltered values, standard and edition, class, cut-offs, end
    /// rule, spacing, lay.
    pub area: Option<serde_json::Value>,
    /// Profiles.
    pub profiles: Vec<ProfileUsed>,
    /// Spread over random spindle phases; null where the phase is given or does not matter.
    pub phases: Option<PhaseSpread>,
    /// Height of the marks along the path that teeth could leave and an envelope does not have, µm: `f^2 / 8
    /// r` with the way `f` in one turn of the spindle and the smallest arc `r` of the edge; 0 for a sharp
    /// corner, null where teeth are modeled.
    #[serde(default)]
    pub teeth_rz_um: Option<f64>,
    /// Error of the design that the heights are counted from, µm.
    pub design_error_um: f64,
    /// What vibration, ploughing and tear may add to Ra and Rz, as the tools state it.
    pub residual: ResidualUsed,
    /// The blocks that made most of it.
    pub blocks: Vec<BlockShare>,
    /// What could not be evaluated, and why; empty when everything was.
    pub unchecked: Vec<String>,
    /// What a reader should know in addition to the values.
    pub remarks: Vec<String>,
    /// Whether the envelope has no height along the path, so that teeth would leave all of it; absent
    /// otherwise.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_flat: bool,
}

/// A profile of a texture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProfileUsed {
    /// Direction, in words.
    pub direction: String,
    /// Direction at the middle, workpiece frame.
    pub along: [f64; 3],
    /// Smallest and largest Ra over the spindle phases, µm; null where it could not be evaluated.
    pub ra_um: Option<[f64; 2]>,
    /// The same of Rz.
    pub rz_um: Option<[f64; 2]>,
    /// What the profile model of Dong et al. 2023 says of it; across the lay alone, null where the model has
    /// no answer.
    pub analytic: Option<AnalyticUsed>,
    /// Everything about it: filtered and unfiltered values, standard and edition, class, cut-offs, evaluation
    /// length, end rule, spacing.
    pub report: serde_json::Value,
}

/// The profile model of Dong et al. 2023 at the middle of a profile, with all that it depends on;
/// both Ra unfiltered, over whole passes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AnalyticUsed {
    /// Mean distance of the passes along the profile.
    pub pitch_mm: f64,
    /// Inclination of the axis from the normal.
    pub inclination_deg: f64,
    /// Azimuth of its lean from the feed, to the left.
    pub azimuth_deg: f64,
    /// Radius of the torus that osculates the cutter at its contact.
    pub radius_mm: f64,
    /// Corner radius of the same.
    pub corner_radius_mm: f64,
    /// Curvature of the design across the feed, positive where it is hollow.
    pub curvature_per_mm: f64,
    /// Distance of the cuts of two teeth; null for the envelope.
    pub feed_per_tooth_mm: Option<f64>,
    /// Ra of the model, µm.
    pub ra_um: f64,
    /// Ra of the simulated profile, µm.
    pub simulated_ra_um: f64,
    /// Simulated less model, µm.
    pub difference_um: f64,
}

/// Smallest and largest values over repetitions with random spindle phases, µm.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PhaseSpread {
    /// Repetitions.
    pub repeats: u32,
    /// Sa of the unfiltered map.
    pub sa_um: [f64; 2],
    /// Sz of the same.
    pub sz_um: [f64; 2],
}

/// What the model of the motion does not know, added to Ra and Rz, µm.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualUsed {
    /// Least and most that it adds to Ra.
    pub ra_um: [f64; 2],
    /// Least and most that it adds to Rz.
    pub rz_um: [f64; 2],
    /// Where the numbers come from, or that none are stated.
    pub source: String,
    /// Tools that state none: what they add is left out of all values.
    #[serde(default)]
    pub missing: Vec<String>,
}

/// A block and the part of a texture that it made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BlockShare {
    /// Index of the executed block.
    pub block: u32,
    /// Program file.
    pub file: Option<String>,
    /// Line.
    pub line: Option<u32>,
    /// Part of the nodes, percent.
    pub percent: f64,
}

/// Interference figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Clearance {
    /// Least clearance of all checked pairs over the run, mm: measured at `time_s`, and the true one is
    /// nowhere less than this less `error_mm`. Bodies against the stock count where material was seen nearer;
    /// how far else they keep away is only bounded (`pairs`). Null when nothing was checked.
    pub min_mm: Option<f64>,
    /// By how much the true least clearance may be less, mm: what the search left, the piece tolerance, what
    /// joints may be off.
    #[serde(default)]
    pub error_mm: Option<f64>,
    /// The two bodies.
    pub pair: Option<[String; 2]>,
    /// When, s.
    pub time_s: Option<f64>,
    /// Number of checks of a motion piece against the world.
    pub checks: u64,
    /// Every checked pair.
    #[serde(default)]
    pub pairs: Vec<PairClearance>,
    /// Pairs that are not checked, each with the reason; those that move as one are not listed.
    #[serde(default)]
    pub unchecked: Vec<UncheckedPair>,
}

/// Least clearance of one pair over the run. It is searched to a micrometer below 20 mm and where it is the
/// smallest of all, and elsewhere to 5 percent; `error_mm` says what was reached.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PairClearance {
    /// The two bodies; `stock` for the in-process stock.
    pub bodies: [String; 2],
    /// Measured, mm; against the stock that of the nearest material on a ray. Null where no distance
    /// beyond the proved bound was asked for.
    pub min_mm: Option<f64>,
    /// By how much the true one may be less, mm.
    pub error_mm: Option<f64>,
    /// It is nowhere less than this, mm; `clearance.parquet` holds the proof for all but the stock.
    pub proved_mm: f64,
    /// When, s.
    pub time_s: Option<f64>,
    /// Distance that the machine file wants of the pair, mm; null where that of the scene holds.
    #[serde(default)]
    pub near_miss_mm: Option<f64>,
}

/// A pair that is not checked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UncheckedPair {
    /// The two bodies.
    pub bodies: [String; 2],
    /// Why.
    pub reason: String,
    /// Why, as the check of the bodies has it. Known while the run lasts, not written to files.
    #[serde(skip)]
    pub cause: Option<Unchecked>,
}

/// Use of one tool.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ToolUse {
    /// Place in the library.
    pub number: u32,
    /// Name in the program.
    pub name: String,
    /// Time in the spindle, s.
    pub time_s: f64,
    /// Time in feed, s.
    pub cut_time_s: f64,
    /// Path of the tip in feed, mm.
    pub length_mm: f64,
    /// Removed volume, mm³.
    pub volume_mm3: f64,
    /// Least overhang at which nothing comes too near while the tool is in the spindle, mm, found
    /// by runs of its own (`run --find-stickout`); null where it was not searched, or where no overhang
    /// is clear.
    pub min_overhang_mm: Option<f64>,
}

/// One feature of the inspection plan, measured on the cut part.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Inspected {
    /// Name in the scene.
    pub name: String,
    /// Nominal value, mm.
    pub nominal_mm: f64,
    /// Measured value, mm; null when the probe met no surface.
    pub measured_mm: Option<f64>,
    /// Allowed deviation to both sides, mm.
    pub tolerance_mm: f64,
}
