//! What a comparison says: `compare.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::uncertainty::{TimeGain, VariationKind};
pub use crate::scene_limits::ChangedLimit;
use crate::verdict::{Axis, Clearance, Deviation, Gate, State, Surface, Time};

/// Version of the layout of [`Comparison`]; raised when a key changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// Programs of a scene on the same twin, side by side (`compare.json`). Holds only what the inputs decide.
///
/// All keys are always present; a value that is not known is `null`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Name of the scene.
    pub scene: String,
    /// What the scene shows.
    pub description: String,
    /// The experiment that is repeated.
    pub experiment: String,
    /// Name of the machine of the baseline.
    pub machine: String,
    /// Limits of joints that the scene sets in place of the machine's own, for all programs; each once for every machine.
    #[serde(default)]
    pub joint_limits: Vec<ChangedLimit>,
    /// Program that the others are compared with.
    pub baseline: String,
    /// Programs in the order of the scene.
    pub order: Vec<String>,
    /// All programs pass, all criteria, and every published value with a band lies in it: fail if one fails, else unchecked if
    /// one is unchecked.
    pub verdict: State,
    /// The programs by name.
    pub programs: BTreeMap<String, ProgramFigures>,
    /// What each program gains against the baseline, by name; without the baseline.
    pub gains: BTreeMap<String, Gain>,
    /// The twin with one parameter changed.
    pub variations: Vec<Variation>,
    /// The twin with the limits of the machine itself in place of those that the scene sets; null where it sets none. It is another
    /// twin: its gains are in no error.
    #[serde(default)]
    pub own_limits: Option<Variation>,
    /// Published values beside ours.
    pub published: Vec<Published>,
    /// Criteria of the scene.
    pub expectations: Vec<Expectation>,
    /// Rules that numbers were made by, in words, by name.
    pub rules: BTreeMap<String, String>,
}

impl Comparison {
    /// The limits that the scene sets, in one line; none where it sets none.
    pub fn limits_in_words(&self) -> Option<String> {
        let one = |l: &ChangedLimit| {
            let own = l.of_machine.map_or_else(|| "none".to_owned(), |v| v.to_string());
            format!("{} of {} {} {} (machine {own})", l.quantity, l.joint, l.of_scene, l.unit)
        };
        let all: Vec<String> = self.joint_limits.iter().map(one).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }

    /// Time of the cutting stretch that a program saves on the machine with its own limits, percent; none where the scene sets no
    /// limit.
    pub fn at_own_limits(&self, program: &str) -> Option<f64> {
        self.own_limits.as_ref()?.gains.get(program)?.stretch_time_percent
    }
}

/// One program on the twin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProgramFigures {
    /// Its run folder beside `compare.json`.
    pub folder: String,
    /// Verdict of its run.
    pub verdict: State,
    /// Its gates.
    pub gates: Vec<Gate>,
    /// Errors that its run found.
    pub errors: u64,
    /// SHA-256 of its inputs by role.
    pub digests: BTreeMap<String, String>,
    /// How it was made from another program; null when it has a text of its own.
    pub made: Option<Made>,
    /// Cycle time.
    pub time: Time,
    /// Extremes of every joint over the whole program.
    pub axes: BTreeMap<String, Axis>,
    /// The cutting stretch; null when the program has none.
    pub stretch: Option<Stretch>,
    /// Cut part against the design.
    pub deviation: Deviation,
    /// Texture of the surface; scallop after the rule `scallop`.
    pub surface: Surface,
    /// Cut part of this program less that of the baseline; null for the baseline and without a design.
    pub difference: Option<Difference>,
    /// Interference.
    pub clearance: Clearance,
}

/// How a program was made from another one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Made {
    /// Name of the method.
    pub method: String,
    /// Paper.
    pub source: String,
    /// Program that it starts from.
    pub from: String,
    /// Largest shift of a ball center at the end of a block, as posted and read again, mm; null where no ball cuts.
    pub center_shift_mm: Option<f64>,
    /// What the method tells of its work; of the first run that was made anew.
    pub figures: Vec<StudyFigure>,
}

/// A number that a method tells of its work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StudyFigure {
    /// What it is.
    pub name: String,
    /// Its unit; empty for counts and ratios.
    pub unit: String,
    /// Its value.
    pub value: f64,
}

/// The part of a program that cuts, without approach, run-up and retract.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stretch {
    /// Blocks.
    pub blocks: u64,
    /// Time that it takes, s.
    pub time_s: f64,
    /// Time that it would take at the programmed feed, s.
    pub programmed_s: f64,
    /// Joints by name; mm or degrees, seconds.
    pub axes: BTreeMap<String, StretchAxis>,
}

/// A joint over the cutting stretch; mm or degrees, seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StretchAxis {
    /// `mm` or `deg`.
    pub unit: String,
    /// Largest speed of the set points.
    pub max_velocity: f64,
    /// Largest acceleration of the set points.
    pub max_acceleration: f64,
    /// Largest jerk of the set points.
    pub max_jerk: f64,
    /// Reversals of direction.
    pub reversals: u64,
    /// Largest speed that the program asks for at its programmed feed.
    pub demand_velocity: Option<f64>,
    /// Largest acceleration that the program asks for at its programmed feed, by differences of its blocks.
    pub demand_acceleration: Option<f64>,
}

/// Cut part of a program less that of the baseline, at the vertices of the baseline's cut part where the design is judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Difference {
    /// Places compared.
    pub samples: u64,
    /// Mean, mm; positive where this program leaves more.
    pub mean_mm: Option<f64>,
    /// Root mean square, mm.
    pub rms_mm: Option<f64>,
    /// Smallest, mm.
    pub min_mm: Option<f64>,
    /// Largest, mm.
    pub max_mm: Option<f64>,
}

/// What a program gains against the baseline. Positive numbers are less time, less motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Gain {
    /// Cycle time saved, percent of the baseline's.
    pub cycle_time_percent: Option<f64>,
    /// Its error, after the rule `error`.
    pub error_percent: Option<f64>,
    /// The whole program.
    pub cycle_time: TimeGain,
    /// All motion in feed.
    pub cutting_time: TimeGain,
    /// The cutting stretch.
    pub stretch_time: TimeGain,
    /// Reductions of the joints' extremes over the cutting stretch, by name.
    pub axes: BTreeMap<String, AxisGain>,
    /// Change of the largest scallop, percent of the baseline's; positive where this program leaves more.
    pub scallop_max_change_percent: Option<f64>,
    /// Change of the mean scallop, percent of the baseline's.
    pub scallop_mean_change_percent: Option<f64>,
}

/// Reductions of a joint's extremes, percent; null where the baseline does not move the joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisGain {
    /// Of the set points.
    pub velocity_percent: Option<f64>,
    /// Of the set points.
    pub acceleration_percent: Option<f64>,
    /// Of the set points.
    pub jerk_percent: Option<f64>,
    /// Of what the program asks for at its programmed feed.
    pub demand_velocity_percent: Option<f64>,
    /// Of what the program asks for at its programmed feed.
    pub demand_acceleration_percent: Option<f64>,
}

/// Times of a program in one variation, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VariedTime {
    /// The whole program.
    pub total_s: f64,
    /// All motion in feed.
    pub cutting_s: f64,
    /// The cutting stretch.
    pub stretch_s: f64,
}

/// The twin with one parameter changed, all programs run again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Variation {
    /// What was changed, and to what.
    pub name: String,
    /// The parameter; variations of one parameter count once.
    pub parameter: String,
    /// Precision of the computation, or uncertainty of the model.
    pub kind: VariationKind,
    /// Why it was not made; null when it was.
    pub unchecked: Option<String>,
    /// Times of every program by name.
    pub times: BTreeMap<String, VariedTime>,
    /// Gains of every program but the baseline.
    pub gains: BTreeMap<String, VariedGains>,
}

/// Gains of a program in one variation, and their differences from the nominal twin, percent of the baseline's time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct VariedGains {
    /// Cycle time saved.
    pub cycle_time_percent: Option<f64>,
    /// Difference from the nominal twin.
    pub cycle_time_change_percent: Option<f64>,
    /// Time in feed saved.
    pub cutting_time_percent: Option<f64>,
    /// Difference from the nominal twin.
    pub cutting_time_change_percent: Option<f64>,
    /// Time of the cutting stretch saved.
    pub stretch_time_percent: Option<f64>,
    /// Difference from the nominal twin.
    pub stretch_time_change_percent: Option<f64>,
}

/// A published value beside ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Published {
    /// What it is.
    pub name: String,
    /// What was measured here, in words.
    pub measured: String,
    /// Unit of both values.
    pub unit: String,
    /// What was published.
    pub published: f64,
    /// What we get; null when it is not known.
    pub value: Option<f64>,
    /// From where to where it counts as reproduced; null when the scene sets no band.
    pub band: Option<[f64; 2]>,
    /// Our value lies in the band; unchecked without a band or a value.
    pub state: State,
    /// Where it was published.
    pub source: String,
    /// Why it can, or cannot, be reached.
    pub remark: String,
}

/// A criterion of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Expectation {
    /// What must hold.
    pub name: String,
    /// What was measured, in words.
    pub measured: String,
    /// Unit of the value and its bounds.
    pub unit: String,
    /// What we get; null when it is not known, and for gates.
    pub value: Option<f64>,
    /// Smallest value that passes.
    pub at_least: Option<f64>,
    /// Largest value that passes.
    pub at_most: Option<f64>,
    /// Judgement.
    pub state: State,
    /// Why, for gates and where it was not checked.
    pub reason: String,
    /// Where the criterion comes from.
    pub source: String,
}
