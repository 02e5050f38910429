//! What a comparison says: `compare.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::uncertainty::{TimeGain, VariationKind};
pub use crate::scene::joint_limits::ChangedLimit;
use crate::{
    compare::certificate::VelocityLimit,
    scene::PublishedKindFile,
    verdict::verdict_file::{Axis, Clearance, Deviation, GateVerdict, State, Surface, Time},
};

pub use super::agreement::Agreement;
pub use crate::observe::study::StudyFigure;

/// Version of the layout of [`Comparison`]; raised when a key changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 2;

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
    /// Limits of joints that the scene sets in place of the machine's own, for all programs; each once for
    /// every machine.
    #[serde(default)]
    pub joint_limits: Vec<ChangedLimit>,
    /// Program that the others are compared with.
    pub baseline: String,
    /// Cells of the stock along x, y and z, mm.
    #[serde(default)]
    pub cells_mm: [f64; 3],
    /// They are those of the scene.
    #[serde(default)]
    pub scene_cells: bool,
    /// Nothing was cut: motion alone.
    #[serde(default)]
    pub motion_only: bool,
    /// Programs in the order of the scene.
    pub order: Vec<String>,
    /// All programs pass, all criteria, and every published value with a band lies in it: fail if one fails,
    /// else unchecked if one is unchecked.
    pub verdict: State,
    /// The programs by name.
    pub programs: BTreeMap<String, ProgramFigures>,
    /// What each program gains against the baseline, by name; without the baseline.
    pub gains: BTreeMap<String, Gain>,
    /// The twin with one parameter changed.
    pub variations: Vec<Variation>,
    /// The twin with the limits of the machine itself in place of those that the scene sets; null where it
    /// sets none. It is another twin: its gains are in no error.
    #[serde(default)]
    pub own_limits: Option<Variation>,
    /// What the experiment leaves open, and what it does to the published values; null where the scene lists
    /// nothing.
    #[serde(default)]
    pub choices: Option<Choices>,
    /// Program that the simplest plan gives; null where the scene names none.
    #[serde(default)]
    pub null_program: Option<String>,
    /// Programs whose own verdict counts; null where all do.
    #[serde(default)]
    pub must_pass: Option<Vec<String>>,
    /// Published values compared with ours.
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

    /// Programs whose texts are the same to the byte, in one line: two results of them are one. None where
    /// all differ.
    pub fn same_texts_in_words(&self) -> Option<String> {
        let text = |p: &ProgramFigures| p.digests.get("made_program").or_else(|| p.digests.get("program")).cloned();
        let mut by_text: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        for (name, program) in self.order.iter().filter_map(|n| self.programs.get_key_value(n)) {
            if let Some(digest) = text(program) {
                by_text.entry(digest).or_default().push(name.as_str());
            }
        }
        let mut groups: Vec<String> = by_text.into_values().filter(|g| g.len() > 1).map(|g| g.join(" = ")).collect();
        groups.sort();
        (!groups.is_empty()).then(|| groups.join(", "))
    }

    /// Time of the cutting stretch that a program saves on the machine with its own limits, percent; none
    /// where the scene sets no limit.
    pub fn at_own_limits(&self, program: &str) -> Option<f64> {
        self.own_limits.as_ref()?.gains.get(program)?.stretch_time_percent
    }
}

/// One program on the twin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProgramFigures {
    /// Its run folder, next to `compare.json`.
    pub folder: String,
    /// Verdict of its run.
    pub verdict: State,
    /// Its gates.
    pub gates: Vec<GateVerdict>,
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

impl ProgramFigures {
    /// Of a program that was not run: motion alone, no gate checked.
    pub(crate) fn of_motion(folder: String, time: Time, made: Option<Made>, stretch: Option<Stretch>) -> Self {
        Self {
            folder,
            verdict: State::Unchecked,
            gates: Vec::new(),
            errors: 0,
            digests: BTreeMap::new(),
            made,
            time,
            axes: BTreeMap::new(),
            stretch,
            deviation: Deviation::default(),
            surface: Surface::default(),
            difference: None,
            clearance: Clearance::default(),
        }
    }
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
    /// Largest shift of a ball center at the end of a block, as posted and read again, mm; null where no ball
    /// cuts.
    pub center_shift_mm: Option<f64>,
    /// What the method reports of its work, for the first run that was re-planned.
    pub figures: Vec<StudyFigure>,
    /// What it saves of the stretch of that run over the velocity limit of each joint, falling; empty where
    /// no limit binds.
    #[serde(default)]
    pub over_velocity: Vec<GainAtLimit>,
}

/// Time that a program saves at one velocity limit of a joint, by feed and this limit alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainAtLimit {
    /// The joint.
    pub joint: String,
    /// The limit.
    pub velocity_deg_s: f64,
    /// Where it comes from.
    pub is: VelocityLimit,
    /// Against the program that it was made from, percent.
    pub saved_percent: f64,
    /// What the best schedule of the channel would save, percent.
    pub saved_at_most_percent: f64,
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
    /// All rotary joints together; null where there is none.
    #[serde(default)]
    pub rotary: Option<RotaryDemand>,
    /// Largest distance of the tip from its chord if the joints run straight from block to block, micrometer.
    #[serde(default)]
    pub straight_joints_tip_um: Option<f64>,
    /// Largest motion of the linear joints that comes from turning alone, for each mm of the tip's path,
    /// mm/mm.
    #[serde(default)]
    pub from_turning: Option<f64>,
    /// How deep the cutter went; null where the scene does not ask for it or the tool is no ball.
    #[serde(default)]
    pub depth: Option<Depth>,
}

/// Depth of a ball below the raw blade, by the nearest point of the closed form, micrometer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Depth {
    /// Places that were measured.
    pub places: u64,
    /// Mean over all lines.
    pub mean_um: f64,
    /// Largest standard deviation along a line about its own mean.
    pub deviation_um: f64,
    /// Least.
    pub least_um: f64,
    /// Most.
    pub most_um: f64,
}

/// What a program asks of all rotary joints together at its programmed feed: roots of sums of squares,
/// degrees and seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RotaryDemand {
    /// Largest speed.
    pub velocity: Option<f64>,
    /// Largest acceleration.
    pub acceleration: Option<f64>,
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
    /// Sum of its steps from block to block.
    #[serde(default)]
    pub travel: f64,
    /// Largest range within one run.
    #[serde(default)]
    pub range: f64,
    /// Largest speed that the program asks for at its programmed feed.
    pub demand_velocity: Option<f64>,
    /// Largest acceleration that the program asks for at its programmed feed, by differences of its blocks.
    pub demand_acceleration: Option<f64>,
}

/// Cut part of a program less that of the baseline, at the vertices of the baseline's cut part where the
/// design is judged.
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
    /// It changes the time of some cutting stretch: one that does not cannot act on a gain, and is not
    /// counted.
    #[serde(default)]
    pub acts: bool,
    /// Times of every program by name.
    pub times: BTreeMap<String, VariedTime>,
    /// Gains of every program but the baseline.
    pub gains: BTreeMap<String, VariedGains>,
}

/// Gains of a program in one variation, and their differences from the nominal twin, percent of the
/// baseline's time.
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

/// What an experiment leaves open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Choices {
    /// The choices.
    pub choices: Vec<TriedChoice>,
    /// Draws of all of them at once, by Latin hypercube.
    pub draws: u64,
    /// Draws that a method or the control refused; they count in no range.
    pub refused: u64,
    /// Why the first of them were refused.
    pub reasons: Vec<String>,
}

/// A choice, and what it does alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TriedChoice {
    /// What it is.
    pub name: String,
    /// Its key.
    pub key: String,
    /// The values that were tried, in words.
    pub tried: Vec<String>,
    /// `published`, `chosen` or `inferred`.
    pub source: String,
    /// Why this range.
    pub reason: String,
    /// Published values that it changes, by name: their range over the tries of this choice alone,
    /// with the value of the scene.
    pub acts_on: BTreeMap<String, [f64; 2]>,
    /// Why a value could not be tried; empty where all were.
    pub refused: String,
}

/// A published value compared with ours.
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
    /// Who states it: the publication, a reader of its figure, or a count of our own.
    #[serde(default)]
    pub kind: PublishedKindFile,
    /// What we get; null when it is not known.
    pub value: Option<f64>,
    /// From where to where it counts as reproduced; null when the scene sets no band.
    pub band: Option<[f64; 2]>,
    /// Whether it counts for the comparison: by its agreement where the scene lists choices that act on it,
    /// else our value lies in the band. Unchecked without a band or a value, and where only draws of all
    /// choices at once reach the published value or the sign turns.
    pub state: State,
    /// The same quantity of the null program; null where there is none, or for the null program itself.
    #[serde(default)]
    pub null_value: Option<f64>,
    /// From where to where our value goes over the choices one at a time; null where none of them acts on it.
    #[serde(default)]
    pub over_choices: Option<[f64; 2]>,
    /// The same over draws of all choices at once.
    #[serde(default)]
    pub over_draws: Option<[f64; 2]>,
    /// The same over the variations of the twin; null where they cannot act.
    #[serde(default)]
    pub over_twin: Option<[f64; 2]>,
    /// How it compares with ours.
    pub agreement: Agreement,
    /// Choice that moves our value most, with the range of it; null where none acts.
    #[serde(default)]
    pub decided_by: Option<(String, [f64; 2])>,
    /// Why it cannot be compared; null where it can.
    #[serde(default)]
    pub not_comparable: Option<String>,
    /// It is a headline of the publication.
    #[serde(default)]
    pub headline: bool,
    /// Where it was published.
    pub source: String,
    /// Why it can, or cannot, be reached.
    pub remark: String,
}

impl Published {
    /// A row of which nothing but the name is known.
    #[cfg(test)]
    pub(crate) fn named(name: &str) -> Self {
        Self {
            name: name.into(),
            measured: String::new(),
            unit: "%".into(),
            published: 0.0,
            kind: PublishedKindFile::default(),
            value: None,
            band: Some([0.0, 1.0]),
            state: State::Pass,
            null_value: None,
            over_choices: None,
            over_draws: None,
            over_twin: None,
            agreement: Agreement::NotComparable,
            decided_by: None,
            not_comparable: None,
            headline: false,
            source: String::new(),
            remark: String::new(),
        }
    }
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
