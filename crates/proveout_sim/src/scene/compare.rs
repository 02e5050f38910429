//! What `proveout compare` takes from a scene: baseline, stretch that counts, published values,
//! criteria.

use std::path::Path;

use proveout_input::{InputError, Step, Step::Item, Step::Key};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    scene::{SceneFile, choice::ChoiceFile, place::offset_of},
    verdict::gate::Gate,
};

/// Comparison of the programs of a scene.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompareFile {
    /// Program that the others are compared with; the first one when left out.
    pub baseline: Option<String>,
    /// The experiment that is repeated, for people.
    #[serde(default)]
    pub experiment: String,
    /// Time at both ends of every run in feed that does not belong to the cutting stretch (approach, run-up,
    /// retract), by the programmed feed, s. Programs of the same structure leave out the same blocks.
    #[serde(default)]
    pub trimmed_ends_s: f64,
    /// Part of the cutting stretch that the plots show closely, s of programmed feed from its begin.
    pub plot_window_s: Option<[f64; 2]>,
    /// Programs whose own verdict counts; all when left out. An original that shows the fault of which a
    /// method frees it does not pass.
    pub must_pass: Option<Vec<String>>,
    /// Looks at the motion of the programs alone: nothing is cut, and every gate is unchecked.
    #[serde(default)]
    pub motion_only: bool,
    /// Program that the simplest plan gives, in addition to the method: published values are given
    /// for it too.
    pub null_program: Option<String>,
    /// What the published experiment leaves open, or states, and its other possible values.
    #[serde(default)]
    pub choice: Vec<ChoiceFile>,
    /// Draws of all choices at once, by Latin hypercube.
    #[serde(default = "draws")]
    pub draws: usize,
    /// Values that others have published.
    #[serde(default)]
    pub published: Vec<PublishedFile>,
    /// Criteria that must hold.
    #[serde(default)]
    pub expect: Vec<ExpectFile>,
}

impl Default for CompareFile {
    fn default() -> Self {
        Self {
            baseline: None,
            experiment: String::new(),
            trimmed_ends_s: 0.0,
            plot_window_s: None,
            must_pass: None,
            motion_only: false,
            null_program: None,
            choice: Vec::new(),
            draws: DRAWS,
            published: Vec::new(),
            expect: Vec::new(),
        }
    }
}

/// Draws where a scene does not say: each choice is met in as many parts of its range.
const DRAWS: usize = 12;
/// More would take hours.
const MOST_DRAWS: usize = 1000;

fn draws() -> usize {
    DRAWS
}

/// A published value and how far from it counts as reproduced.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedFile {
    /// What it is, in words.
    pub name: String,
    /// Program that it is about.
    pub program: String,
    /// Program that it is compared with; the value itself when left out.
    pub against: Option<String>,
    /// What is measured.
    pub quantity: QuantityFile,
    /// Joint, for quantities of a joint; `rotary` for all rotary ones together, of the demand alone.
    pub axis: Option<String>,
    /// Name of the number, for `quantity = "study"`.
    pub figure: Option<String>,
    /// How two values become one.
    #[serde(default)]
    pub form: FormFile,
    /// The published value, in the unit of the quantity; percent with `against`.
    pub value: f64,
    /// From where to where it counts as reproduced.
    pub band: Option<[f64; 2]>,
    /// Where it was published.
    pub source: String,
    /// Who states the value: the publication in numbers, its reader from a figure, or a count of our own.
    #[serde(default)]
    pub kind: PublishedKindFile,
    /// Why it can, or cannot, be reached.
    #[serde(default)]
    pub remark: String,
    /// Why it cannot be compared with ours: the publication does not define it, or it is another quantity.
    pub not_comparable: Option<String>,
    /// It is what the publication is known for: a row of the first table of the experiments.
    #[serde(default)]
    pub headline: bool,
}

/// Who states a value that ours is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PublishedKindFile {
    /// The publication, in numbers.
    #[default]
    Paper,
    /// Read from a figure of the publication.
    Figure,
    /// A second count of our own: it reproduces no publication.
    OwnCount,
}

impl PublishedKindFile {
    /// What precedes the value in a table; empty for the publication's own.
    pub fn label(self) -> &'static str {
        match self {
            Self::Paper => "",
            Self::Figure => "from a figure: ",
            Self::OwnCount => "second count: ",
        }
    }
}

/// A criterion: a bound of a quantity, or a gate that must pass.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectFile {
    /// What must hold, in words.
    pub name: String,
    /// Program that it is about.
    pub program: String,
    /// Program that it is compared with; the value itself when left out.
    pub against: Option<String>,
    /// What is measured; left out with `gate`.
    pub quantity: Option<QuantityFile>,
    /// Joint, for quantities of a joint; `rotary` for all rotary ones together, of the demand alone.
    pub axis: Option<String>,
    /// Name of the number, for `quantity = "study"`.
    pub figure: Option<String>,
    /// How two values become one.
    #[serde(default)]
    pub form: FormFile,
    /// Smallest value that passes.
    pub at_least: Option<f64>,
    /// Largest value that passes.
    pub at_most: Option<f64>,
    /// Gate of the verdict that must pass, instead of a quantity.
    pub gate: Option<String>,
    /// Where the criterion comes from.
    #[serde(default)]
    pub source: String,
}

/// How the values of two programs become one number, percent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FormFile {
    /// `100 (1 - value / against)`: what is saved.
    #[default]
    Reduction,
    /// `100 (against / value - 1)`: how much more is done in the same time.
    Rate,
}

/// Quantities of a compared program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum QuantityFile {
    /// Time of the whole program, s.
    CycleTime,
    /// Time of all motion in feed, s.
    CuttingTime,
    /// Time of the cutting stretch, s.
    StretchTime,
    /// Smallest gain in the time of the cutting stretch against the baseline under all variations, percent.
    SmallestGain,
    /// Largest velocity of a joint at constant programmed feed, by differences of the program's blocks.
    DemandVelocity,
    /// Largest acceleration of a joint at constant programmed feed, by differences of the program's blocks.
    DemandAcceleration,
    /// Largest velocity of a joint in the cutting stretch.
    MaxVelocity,
    /// Largest acceleration of a joint in the cutting stretch.
    MaxAcceleration,
    /// Largest jerk of a joint in the cutting stretch.
    MaxJerk,
    /// Reversals of a joint in the cutting stretch.
    Reversals,
    /// Sum of the steps of a joint over the blocks of the cutting stretch.
    Travel,
    /// Largest range of a joint within one run of the cutting stretch.
    Range,
    /// Largest distance of the tip from its chord if the joints run straight from block to block, micrometer.
    StraightJointsTip,
    /// Largest motion of the linear joints that comes from turning alone, for each mm of the tip's path:
    /// concomitant motion, mm/mm.
    FromTurning,
    /// Mean depth of a ball below the raw blade over the cutting stretch, micrometer.
    DepthMean,
    /// Standard deviation of that depth along a line, the largest of the lines, micrometer.
    DepthDeviation,
    /// Least depth, micrometer.
    DepthLeast,
    /// Largest depth, micrometer.
    DepthMost,
    /// Deepest gouge, mm.
    Gouge,
    /// Most material left, mm.
    Excess,
    /// Largest scallop, micrometer.
    ScallopMax,
    /// Mean scallop, micrometer.
    ScallopMean,
    /// 95th percentile of the scallop, micrometer; the scene sets `scallop_um`.
    ScallopP95,
    /// Largest shift of a ball center against the program that it was made from, mm.
    CenterShift,
    /// Smallest proved clearance of bodies, mm.
    Clearance,
    /// A number that the method reports of its work.
    Study,
}

impl QuantityFile {
    /// Whether it belongs to a joint.
    pub fn of_joint(self) -> bool {
        use QuantityFile::*;
        matches!(
            self,
            DemandVelocity | DemandAcceleration | MaxVelocity | MaxAcceleration | MaxJerk | Reversals | Travel | Range
        )
    }

    /// Whether the depth of the cut has to be measured for it.
    pub fn of_depth(self) -> bool {
        matches!(self, Self::DepthMean | Self::DepthDeviation | Self::DepthLeast | Self::DepthMost)
    }

    /// Whether all rotary joints have it together.
    fn of_rotary(self) -> bool {
        matches!(self, Self::DemandVelocity | Self::DemandAcceleration)
    }

    /// Name for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::CycleTime => "cycle time",
            Self::CuttingTime => "time in feed",
            Self::StretchTime => "time of the cutting stretch",
            Self::SmallestGain => "smallest gain under all variations",
            Self::DemandVelocity => "velocity at programmed feed",
            Self::DemandAcceleration => "acceleration at programmed feed",
            Self::MaxVelocity => "velocity",
            Self::MaxAcceleration => "acceleration",
            Self::MaxJerk => "jerk",
            Self::Reversals => "reversals",
            Self::Travel => "travel",
            Self::Range => "range within one line",
            Self::StraightJointsTip => "tip from its chord, joints led straight",
            Self::FromTurning => "motion of the slides that comes from turning",
            Self::DepthMean => "mean depth of the cut",
            Self::DepthDeviation => "deviation of the depth along a line",
            Self::DepthLeast => "least depth of the cut",
            Self::DepthMost => "largest depth of the cut",
            Self::Gouge => "deepest gouge",
            Self::Excess => "most material left",
            Self::ScallopMax => "largest scallop",
            Self::ScallopMean => "mean scallop",
            Self::ScallopP95 => "95th percentile of the scallop",
            Self::CenterShift => "shift of ball centers",
            Self::Clearance => "least clearance",
            Self::Study => "number of the method",
        }
    }
}

/// In place of a joint: all rotary ones together.
pub(crate) const ROTARY: &str = "rotary";

/// Checks the section against the programs of its scene.
pub(crate) fn check(path: &Path, text: &str, file: &SceneFile) -> Result<(), InputError> {
    let Some(compare) = &file.compare else { return Ok(()) };
    let at_path = |keys: &[Step<'_>], message: String, help: &str| {
        let keys: Vec<Step<'_>> = [Key("compare")].into_iter().chain(keys.iter().copied()).collect();
        Err(InputError::at(path, text, offset_of(text, &keys), message, help))
    };
    let fault = |key: &str, message: String, help: &str| at_path(&[Key(key)], message, help);
    let known = |name: &str| file.program.iter().any(|p| p.name == name);
    let names: Vec<&str> = file.program.iter().map(|p| p.name.as_str()).collect();
    let programs = format!("programs of the scene: {}", names.join(", "));
    if let Some(name) = compare.baseline.as_deref().filter(|name| !known(name)) {
        return fault("baseline", format!("the baseline {name:?} is not a program of the scene"), &programs);
    }
    if !(0.0..1e6).contains(&compare.trimmed_ends_s) {
        let message = format!("trimmed_ends_s = {} is not a time", compare.trimmed_ends_s);
        return fault("trimmed_ends_s", message, "write seconds from 0");
    }
    if let Some([from, to]) = compare.plot_window_s.filter(|[from, to]| !(0.0 <= *from && from < to && to.is_finite()))
    {
        return fault(
            "plot_window_s",
            format!("plot_window_s = [{from}, {to}] is not a stretch"),
            "write [from, to] in seconds",
        );
    }
    let must = compare.must_pass.iter().flatten().enumerate().map(|(i, name)| (vec![Key("must_pass"), Item(i)], name));
    let null = compare.null_program.iter().map(|name| (vec![Key("null_program")], name));
    if let Some((at, name)) = must.chain(null).find(|(_, name)| !known(name)) {
        return at_path(&at, format!("{name:?} is not a program of the scene"), &programs);
    }
    if !compare.choice.is_empty() && !(1..=MOST_DRAWS).contains(&compare.draws) {
        let message = format!("draws = {} is out of range", compare.draws);
        return fault("draws", message, &format!("write 1 to {MOST_DRAWS}, or leave it out for {DRAWS}"));
    }
    for (i, choice) in compare.choice.iter().enumerate() {
        let double = compare.choice[..i].iter().any(|c| c.key == choice.key || c.name == choice.name);
        let double = double.then(|| (format!("the choice {:?} is given twice", choice.name), "remove one".to_owned()));
        if let Some((message, help)) = double.or_else(|| choice.fault(file)) {
            return at_path(&[Key("choice"), Item(i)], message, &help);
        }
    }
    let published = compare.published.iter().enumerate().map(|(i, p)| {
        (
            ("published", i),
            &p.name,
            &p.program,
            p.against.as_ref(),
            Some(p.quantity),
            p.axis.as_deref(),
            p.figure.is_some(),
        )
    });
    let expected = compare.expect.iter().enumerate().map(|(i, e)| {
        (("expect", i), &e.name, &e.program, e.against.as_ref(), e.quantity, e.axis.as_deref(), e.figure.is_some())
    });
    for ((list, i), name, program, against, quantity, axis, figure) in published.chain(expected) {
        let fault = |key: &str, message: String, help: &str| at_path(&[Key(list), Item(i), Key(key)], message, help);
        let named = [("program", Some(program)), ("against", against)];
        if let Some((key, unknown)) = named.into_iter().filter_map(|(k, p)| Some((k, p?))).find(|(_, p)| !known(p)) {
            return fault(key, format!("{name:?} names {unknown:?}, which is not a program of the scene"), &programs);
        }
        if quantity.is_some_and(|q| q.of_joint() != axis.is_some()) {
            return fault(
                "axis",
                format!("`axis` of {name:?} is missing or superfluous"),
                "give `axis` for quantities of a joint only",
            );
        }
        if axis == Some(ROTARY) && quantity.is_some_and(|q| !q.of_rotary()) {
            return fault(
                "axis",
                format!("{name:?} asks all rotary joints for a quantity that only a single joint has"),
                "name a joint; `rotary` belongs to demand-velocity and demand-acceleration",
            );
        }
        if quantity.is_some_and(|q| (q == QuantityFile::Study) != figure) {
            return fault(
                "figure",
                format!("`figure` of {name:?} is missing or superfluous"),
                "give `figure` with quantity = \"study\" only",
            );
        }
    }
    for (i, e) in compare.expect.iter().enumerate() {
        let fault =
            |key: &str, message: String, help: &str| at_path(&[Key("expect"), Item(i), Key(key)], message, help);
        let bounds = e.at_least.is_some() || e.at_most.is_some();
        if e.quantity.is_some() != bounds || e.quantity.is_some() == e.gate.is_some() {
            let message = format!("criterion {:?} cannot be judged", e.name);
            return fault("name", message, "give a `quantity` with `at_least` or `at_most`, or a `gate`");
        }
        if let Some(gate) = e.gate.as_deref().filter(|g| Gate::named(g).is_none()) {
            return fault("gate", format!("there is no gate {gate:?}"), &format!("gates: {}", Gate::NAMES.join(", ")));
        }
    }
    for (i, p) in compare.published.iter().enumerate() {
        if p.band.is_some_and(|[low, high]| low.is_nan() || high.is_nan() || low > high) {
            return at_path(
                &[Key("published"), Item(i), Key("band")],
                format!("the band of {:?} is empty", p.name),
                "write [low, high]",
            );
        }
    }
    Ok(())
}
