//! Tool axes of a bull-nose cutter on two scales: a strip of nearly the same width, and a roughness across
//! the feed below a limit.
//!
//! Source: Dong J., He J., Liu S., Wan N., Chang Z. (2023), A Multi-Scale Tool Orientation Generation Method
//! for Freeform Surface Machining with Bull-Nose Tool, Micromachines 14, 1199, doi:10.3390/mi14061199.
//! Angles: equations (1), (2). Local gouge: (5)-(9), with the boundary in closed form and the missing
//! condition (10), `bull_nose.rs`. Strip: (12), (13), measured along the normal of the contact. Roughness:
//! (15), (16), with the exact torus, `cross_section.rs`. Curves: (17)-(24) with (25), (26) corrected,
//! `fit.rs`.
//!
//! With the lean in the direction of the feed the strip falls and the roughness rises with the inclination,
//! so that each contact has one interval:
//!
//! ```text
//!   max(gouge, strip = widest)  <=  inclination  <=  min(strip = narrowest, Ra = limit)
//! ```
//!
//! The rotary curves with the least sum of squared speeds are laid through the ends. Where a contact then
//! breaks a rule, the worst of its neighbors is moved into its interval, with a margin, and becomes a fixed
//! value; this repeats until no contact breaks one. The published procedure assigns every one of them, in the
//! limit a polygon. The lateral lean that the curves leave between fixed contacts is judged as it is: gouge,
//! strip and roughness of the true axis decide.
//!
//! Published: window 2.15 to 3.15 mm, Ra 1.6 um over 4 mm, ends that keep their axes. The height at which a
//! strip is measured is inferred (0.1 mm: the center of the window at 20 degrees), 21 coefficients and a
//! margin of 0.2 degrees are chosen. Published ends and a roughness below the limit at every contact exclude
//! each other where the ends leave more: `run_in` mm at both ends are then not judged, else the ends move as
//! well.
//!
//! The distance of the rows is that of the program, the larger one of both sides, each cutter leaned as the
//! one between them. Marks of teeth along the feed are left out.

mod bull_nose;
mod cross_section;
mod fit;
mod judge;

use std::{collections::BTreeMap, ops::Range};

use proveout_geom::{ToolPose, Vector};
use proveout_machine::{JointValues, KinematicsError, Machine};
use proveout_path::PathCutter;

use super::{
    CuttingRun, Figure, Method, RescheduleError, Rescheduled, Surroundings,
    meeting::newly_met,
    touching::{TouchOffset, touching},
};

pub use bull_nose::{BullNose, critical};
pub use cross_section::{ContactFrame, CrossSection, leaned, mean_deviation, mean_line};
pub use fit::{basis, fitted, value};
pub use judge::AxisEffect;
use judge::study;
pub(super) use judge::{Judge, Measures, ruled_figures};

/// Rounds of assigning and fitting.
const ROUNDS: usize = 50;
/// Bounds of the margin, radian, and of the count of coefficients at the start.
const MARGINS: [f64; 2] = [0.0, 5.0 * std::f64::consts::PI / 180.0];
const COUNTS: [usize; 2] = [4, 1000];
/// What the solution of the fit may be over a limit by rounding, as a part of it: without a margin contacts
/// are fixed on their limits.
const ROUNDED: f64 = 1e-9;
/// Largest step of a rotary joint between two contacts, radian: beyond, the axis passes the pole.
const POLE_STEP: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Blocks whose contacts are nearer than this to each other at the end of a row may be lifted from it, mm.
const LIFTED: f64 = 1e-2;
/// Largest turn of the row between two steps, as a cosine.
const STRAIGHT_ON: f64 = 0.5;
/// Micrometers in a millimeter.
const UM_PER_MM: f64 = 1e3;
/// Roughness where none is asked for, mm.
const USUAL_ROUGHNESS_MM: f64 = 1.6e-3;
/// Shorter ways have no direction, mm.
const SHORTEST_MM: f64 = 1e-9;

/// Parameters of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiScale {
    /// Narrowest and widest strip, mm.
    pub strip: [f64; 2],
    /// Height over the surface at which a strip is measured, mm.
    pub strip_height: f64,
    /// Largest Ra across the feed, mm; zero for no limit.
    pub roughness: f64,
    /// Evaluation length of the roughness, mm.
    pub evaluation_length: f64,
    /// Way at both ends of a row that is not judged while its first and last axis stay, mm; zero: they are
    /// judged and move.
    pub run_in: f64,
    /// How far inside of its interval a contact is fixed, radian.
    pub margin: f64,
    /// Coefficients of a rotary curve at the start.
    pub coefficients: usize,
    /// How a measurement of the roughness is taken to read, for the count of places above the limit.
    pub measurement: Option<Measurement>,
}

/// A model of what a probe reads of a computed roughness: a part of it, scattered by a normal distribution
/// from place to place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// What is read over what is computed.
    pub part: f64,
    /// Standard deviation over what is read.
    pub spread: f64,
}

impl Measurement {
    /// Probability that a place of this roughness is read above the limit, in the same unit.
    pub fn above(&self, roughness: f64, limit: f64) -> f64 {
        let mean = self.part * roughness;
        let sigma = self.spread * mean;
        if sigma > 0.0 {
            // The normal distribution's upper tail.
            0.5 * libm::erfc((limit - mean) / (sigma * std::f64::consts::SQRT_2))
        } else {
            f64::from(u8::from(mean > limit))
        }
    }
}

impl Default for MultiScale {
    fn default() -> Self {
        Self {
            strip: [2.15, 3.15],
            strip_height: 0.1,
            roughness: USUAL_ROUGHNESS_MM,
            evaluation_length: 4.0,
            run_in: 0.0,
            margin: 0.2 * std::f64::consts::PI / 180.0,
            coefficients: 21,
            measurement: None,
        }
    }
}

/// The rotary joints of the machine, turn by turn.
struct Rotary<'a> {
    machine: &'a Machine,
    joints: [usize; 2],
}

impl<'a> Rotary<'a> {
    fn new(machine: Option<&'a Machine>) -> Option<Self> {
        let machine = machine?;
        let &[a, b] = machine.rotary_joints() else { return None };
        Some(Self { machine, joints: [a, b] })
    }

    /// Positions that give an axis, next to others.
    fn of(&self, axis: &Vector, near: &JointValues) -> Result<JointValues, KinematicsError> {
        let pose = ToolPose { tip: proveout_geom::Point::origin(), axis: *axis };
        match self.machine.inverse_nearest(&pose, 0.0, near) {
            Ok(solution) => Ok(solution.q),
            // Slides depend on the length of the tool and are judged when the program runs.
            Err(KinematicsError::OverTravel { rotary: false, solution, .. }) => Ok(solution.q),
            Err(e) => Err(e),
        }
    }

    fn joints(&self, values: [f64; 2]) -> JointValues {
        let mut q = self.machine.home();
        for (joint, value) in self.joints.iter().zip(values) {
            q[*joint] = value;
        }
        q
    }

    fn values(&self, q: &JointValues) -> [f64; 2] {
        self.joints.map(|j| q[j])
    }

    fn axis(&self, values: [f64; 2]) -> Vector {
        self.machine.forward(&self.joints(values), 0.0).axis
    }
}

impl MultiScale {
    fn check(&self) -> Result<(), RescheduleError> {
        let [low, high] = self.strip;
        let positive = |v: f64| v > 0.0 && v.is_finite();
        let message = if !(positive(low) && positive(high) && low < high) {
            format!("a strip of {low} to {high} mm")
        } else if !(positive(self.strip_height) && self.strip_height <= 1.0) {
            format!("a strip measured {} mm over the surface", self.strip_height)
        } else if !(self.roughness >= 0.0 && self.roughness.is_finite()) {
            format!("a roughness of {} um", UM_PER_MM * self.roughness)
        } else if !(positive(self.evaluation_length) && self.evaluation_length <= 50.0) {
            format!("an evaluation length of {} mm", self.evaluation_length)
        } else if !(self.run_in >= 0.0 && self.run_in.is_finite()) {
            format!("a run-in of {} mm", self.run_in)
        } else if !(MARGINS[0]..=MARGINS[1]).contains(&self.margin) {
            format!("a margin of {:.6} degrees", self.margin.to_degrees())
        } else if !(COUNTS[0]..=COUNTS[1]).contains(&self.coefficients) {
            format!("{} coefficients of a curve", self.coefficients)
        } else if let Some(m) = self.measurement.filter(|m| !(positive(m.part) && m.spread >= 0.0 && m.spread < 1.0)) {
            format!("a measurement that reads {} of the roughness with a spread of {}", m.part, m.spread)
        } else {
            return Ok(());
        };
        let help = "give a strip that is wider than its narrowest, a height up to 1 mm, an evaluation length up to 50 mm, a margin up to 5 degrees, \
                    4 to 1000 coefficients, a spread below 1, and nothing below zero";
        Err(RescheduleError::new("reschedule-option", 0, message, help))
    }
}

/// Refuses a run at its first block.
fn refusing<T>(run: &CuttingRun) -> impl Fn(&'static str, &str, &str) -> Result<T, RescheduleError> + use<T> {
    let first = run.blocks.first().map_or(0, |b| b.line);
    move |code, message, help| Err(RescheduleError::new(code, first, message, help))
}

impl RowRules {
    /// What the rules say of axes of the stretch before and after.
    pub(super) fn figures(&self, axes: [&[Vector]; 2]) -> Vec<Figure> {
        let judged = |axes: &[Vector]| -> Vec<AxisEffect> {
            self.judges.iter().zip(axes).map(|(judge, axis)| judge.judged(&judge.frame.local(axis))).collect()
        };
        let [before, after] = axes.map(judged);
        let Some(judge) = self.judges.first() else { return Vec::new() };
        ruled_figures(judge.method(), &self.judged, [&before, &after])
    }
}

/// The contacts of a row with what the method asks of them.
pub(super) struct RowRules {
    /// The blocks along the surface.
    pub(super) stretch: Range<usize>,
    /// Contacts of all blocks.
    pub(super) contacts: Vec<TouchOffset>,
    /// Rules of the blocks of the stretch.
    pub(super) judges: Vec<Judge>,
    /// Way along their contacts, mm.
    pub(super) arc: Vec<f64>,
    /// Which of them are judged: not those of the run-in.
    pub(super) judged: Vec<bool>,
}

impl MultiScale {
    /// The rules at every contact of a row.
    ///
    /// # Errors
    /// The tool has no corner radius, the surface is not known or does not reach to a block, or
    /// there is no adjacent row.
    pub(super) fn rules(
        &self,
        run: &CuttingRun,
        around: &Surroundings<'_>,
        cutter: &PathCutter,
    ) -> Result<RowRules, RescheduleError> {
        self.check()?;
        let refuse = refusing(run);
        let Some(tool) = BullNose::of(around.cutter) else {
            let help = "use a bull-nose cutter, or another method";
            return refuse("reschedule-tool", "the tool has no corner radius about a flat face", help);
        };
        let Some(surface) = around.surface else {
            let help = "describe the surface of the scene under [part.blade]";
            return refuse("reschedule-path", "the surface that is cut is not known", help);
        };
        let contacts = contacts(run, cutter, around)?;
        let stretch = row_of(&contacts);
        let own = CuttingRun { blocks: run.blocks[stretch.clone()].to_vec() };
        let frames = frames(&own, &contacts[stretch.clone()])?;
        let distances = match self.roughness > 0.0 {
            true => judge::row_distances(&frames, around, cutter),
            false => vec![None; frames.len()],
        };
        if self.roughness > 0.0 && distances.iter().all(Option::is_none) {
            let help = "re-schedule programs of several rows with a rapid between them, or leave the roughness out with ra_um = 0";
            return refuse(
                "reschedule-path",
                "this row has no neighboring row: its roughness across the feed is not known",
                help,
            );
        }
        let judges: Vec<Judge> =
            frames.iter().zip(&distances).map(|(f, d)| Judge::new(self, tool, surface, *f, *d)).collect();
        let mut arc = vec![0.0; frames.len()];
        for i in 1..arc.len() {
            arc[i] = arc[i - 1] + (frames[i].point - frames[i - 1].point).norm();
        }
        let total = arc.last().copied().unwrap_or(0.0);
        let judged = arc.iter().map(|s| *s >= self.run_in && *s <= total - self.run_in).collect();
        Ok(RowRules { stretch, contacts, judges, arc, judged })
    }
}

impl Method for MultiScale {
    fn name(&self) -> &'static str {
        "multi-scale"
    }

    fn source(&self) -> &'static str {
        "Dong et al. 2023, doi:10.3390/mi14061199"
    }

    fn needs_region(&self) -> bool {
        true
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        self.check()?;
        let cutter = PathCutter::new(around.cutter.clone());
        let mut rules = self.rules(run, around, &cutter)?;
        let contacts = std::mem::take(&mut rules.contacts);
        let (poses, done) = self.by_rules(run, around, &cutter, (&rules, &contacts))?;
        let RowRules { stretch, judges, arc, .. } = rules;
        let judged = |(judge, pose): (&Judge, &ToolPose)| judge.judged(&judge.frame.local(&pose.axis));
        let own = run.blocks[stretch.clone()].iter().map(|b| &b.pose);
        let before: Vec<AxisEffect> = judges.iter().zip(own).map(judged).collect();
        let after: Vec<AxisEffect> = judges.iter().zip(&poses[stretch.clone()]).map(judged).collect();
        let study = study(self, (&arc, &judges), [&before, &after], &done);
        Ok(Rescheduled { stretch, poses, rotary: None, channel: None, study })
    }
}

impl MultiScale {
    /// Poses of all blocks of a run by the rules of its row, which were made of its contacts.
    ///
    /// # Errors
    /// No curves keep the rules, or shank and holder touch; with the block.
    pub(super) fn by_rules(
        &self,
        whole: &CuttingRun,
        around: &Surroundings<'_>,
        cutter: &PathCutter,
        (rules, contacts): (&RowRules, &[TouchOffset]),
    ) -> Result<(Vec<ToolPose>, FitResult), RescheduleError> {
        let Some(rotary) = Rotary::new(around.machine) else {
            let help = "choose a five-axis machine";
            return refusing(whole)("reschedule-path", "the machine does not have two rotary joints", help);
        };
        let stretch = &rules.stretch;
        let run = &CuttingRun { blocks: whole.blocks[stretch.clone()].to_vec() };
        let work = FitInput { method: self, run, rotary: &rotary, judges: &rules.judges, arc: &rules.arc };
        let done = work.solve()?;
        let mut poses = Vec::with_capacity(whole.blocks.len());
        for (i, (at, block)) in contacts.iter().zip(&whole.blocks).enumerate() {
            // Lead-in and lead-out keep to their ends.
            let axis = rotary.axis(done.joints[i.clamp(stretch.start, stretch.end - 1) - stretch.start]);
            let pose = ToolPose { tip: cutter.touch(&at.place, &axis, 0.0, None).pose.tip + at.off, axis };
            if let Some(region) = around.region
                && let Some(deep) = newly_met(region, &pose, &block.pose)
            {
                let message = format!("the new axis makes shank or holder collide: {deep} along the tool axis");
                let help = "give the tool a slimmer shank and holder, or widen the strip";
                return Err(RescheduleError::new("reschedule-channel", block.line, message, help));
            }
            poses.push(pose);
        }
        Ok((poses, done))
    }
}

/// Contacts of the blocks of a row, where they are found.
fn found(run: &CuttingRun, cutter: &PathCutter, around: &Surroundings<'_>) -> Vec<Option<TouchOffset>> {
    run.blocks.iter().map(|b| touching(&b.pose, cutter, around)).collect()
}

fn contacts(
    run: &CuttingRun,
    cutter: &PathCutter,
    around: &Surroundings<'_>,
) -> Result<Vec<TouchOffset>, RescheduleError> {
    let touching_block = |(touching, block): (Option<TouchOffset>, &super::CuttingBlock)| {
        touching.ok_or_else(|| {
            let message = "the surface of the part does not reach to this block";
            let help = "re-schedule rows on the surface that the scene describes";
            RescheduleError::new("reschedule-path", block.line, message, help)
        })
    };
    found(run, cutter, around).into_iter().zip(&run.blocks).map(touching_block).collect()
}

/// The blocks along the surface: without those at both ends that are lifted from its first and last contact.
fn row_of(contacts: &[TouchOffset]) -> Range<usize> {
    // A lift is rounded as the program is: the contact stays but for its last digits, and the tip goes
    // elsewhere.
    let is_lift = |i: usize| {
        let way = contacts[i + 1].place.point - contacts[i].place.point;
        way.norm() < LIFTED && (contacts[i + 1].off - contacts[i].off).norm() > 10.0 * way.norm()
    };
    let last = contacts.len().saturating_sub(1);
    let start = (0..last).find(|&i| !is_lift(i)).unwrap_or(0);
    let end = (start..last).rfind(|&i| !is_lift(i)).map_or(last, |i| i + 1);
    start..(end + 1).min(contacts.len())
}

/// Frames of the contacts, with the feed along the row.
fn frames(run: &CuttingRun, contacts: &[TouchOffset]) -> Result<Vec<ContactFrame>, RescheduleError> {
    let n = contacts.len();
    let point = |i: usize| contacts[i].place.point;
    let same_place = |line: u32| {
        let message = "two blocks follow each other with the tool at the same place";
        RescheduleError::new("reschedule-path", line, message, "remove one of them")
    };
    let line = |i: usize| run.blocks.get(i).map_or(0, |b| b.line);
    if n < 5 {
        let message = format!("the row has only {n} blocks");
        return Err(RescheduleError::new("reschedule-layers", line(0), message, "give a row of five blocks or more"));
    }
    let mut out = Vec::with_capacity(n);
    for (i, contact) in contacts.iter().enumerate() {
        let steps = [(i > 0).then(|| point(i) - point(i - 1)), (i + 1 < n).then(|| point(i + 1) - point(i))];
        let ways: Vec<Vector> = steps.iter().flatten().filter_map(|s| s.try_normalize(SHORTEST_MM)).collect();
        if ways.len() < steps.iter().flatten().count() {
            return Err(same_place(line(i)));
        }
        if let [a, b] = ways.as_slice()
            && a.dot(b) < STRAIGHT_ON
        {
            let message = format!("the row turns by {:.0} degrees here", a.dot(b).clamp(-1.0, 1.0).acos().to_degrees());
            let help = "the method is for single rows: lift the tool with a rapid between them";
            return Err(RescheduleError::new("reschedule-path", line(i), message, help));
        }
        let feed = ways.iter().fold(Vector::zeros(), |sum, w| sum + w);
        let frame = ContactFrame::new(point(i), contact.place.normal, feed);
        out.push(frame.ok_or_else(|| same_place(line(i)))?);
    }
    Ok(out)
}

/// What the fit works on.
struct FitInput<'a> {
    method: &'a MultiScale,
    run: &'a CuttingRun,
    rotary: &'a Rotary<'a>,
    judges: &'a [Judge],
    arc: &'a [f64],
}

/// What came out.
pub(super) struct FitResult {
    joints: Vec<[f64; 2]>,
    fixed: Vec<usize>,
    coefficients: usize,
    rounds: usize,
    judged: Vec<bool>,
}

impl FitInput<'_> {
    fn error(&self, at: usize, message: String, help: &str) -> RescheduleError {
        RescheduleError::new("reschedule-channel", self.run.blocks[at].line, message, help)
    }

    /// The axis at a contact moved into its interval along the feed.
    fn assigned(&self, at: usize, lean: f64) -> Vector {
        let judge = &self.judges[at];
        let [low, high] = judge.limits;
        let margin = self.method.margin.min(0.5 * (high - low));
        judge.frame.global(&leaned(lean.clamp(low + margin, high - margin), 0.0))
    }

    fn solve(&self) -> Result<FitResult, RescheduleError> {
        let n = self.arc.len();
        let total = self.arc[n - 1];
        let run_in = self.method.run_in;
        let judged: Vec<bool> = self.arc.iter().map(|s| *s >= run_in && *s <= total - run_in).collect();
        if let Some(at) = (0..n).find(|&i| judged[i] && self.judges[i].limits[0] > self.judges[i].limits[1]) {
            let [low, high] = self.judges[at].limits.map(f64::to_degrees);
            let message = format!(
                "no inclination will do: gouge and the widest strip ask for {low:.2} degrees at least, the narrowest strip and \
                 the roughness for {high:.2} at most"
            );
            return Err(self.error(
                at,
                message,
                "widen the strip, allow more roughness, or lay the rows closer together",
            ));
        }
        let (rows, times): (Vec<f64>, Vec<f64>) =
            (self.arc.iter().map(|s| s / total).collect(), self.arc.windows(2).map(|w| w[1] - w[0]).collect());
        let before: Vec<Vector> = self.run.blocks.iter().map(|b| b.pose.axis).collect();
        let end = |at: usize| match run_in > 0.0 {
            true => before[at],
            false => self.assigned(at, self.judges[at].lean(&before[at])),
        };
        // The program's own axes say on which side of the pole and in which turn the row runs.
        let mut course = Vec::with_capacity(n);
        let mut q = self.rotary.machine.home();
        for (i, axis) in before.iter().enumerate() {
            q = self.rotary.of(axis, &q).map_err(|e| self.error(i, format!("out of reach: {e}"), RANGE))?;
            course.push(q);
        }
        let placed = |at: usize, axis: &Vector| {
            let q =
                self.rotary.of(axis, &course[at]).map_err(|e| self.error(at, format!("out of reach: {e}"), RANGE))?;
            Ok::<[f64; 2], RescheduleError>(self.rotary.values(&q))
        };
        let mut fixed: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        for at in [0, n - 1] {
            fixed.insert(at, placed(at, &end(at))?);
        }
        let mut coefficients = self.method.coefficients.min(n + 2);
        for round in 1..=ROUNDS {
            let list: Vec<(usize, [f64; 2])> = fixed.iter().map(|(k, v)| (*k, *v)).collect();
            let Some([a, b]) = fitted(&rows, &times, coefficients, &list) else {
                if coefficients >= n + 2 {
                    break;
                }
                coefficients = (2 * coefficients).min(n + 2);
                continue;
            };
            let joints: Vec<[f64; 2]> = rows.iter().map(|u| [value(&a, *u), value(&b, *u)]).collect();
            let axes: Vec<Vector> = joints.iter().map(|q| self.rotary.axis(*q)).collect();
            let mut worst: Option<(f64, usize)> = None;
            let mut new = Vec::new();
            for i in 0..=n {
                let excess = (i < n && judged[i]).then(|| self.judges[i].excess(&axes[i])).filter(|e| *e > ROUNDED);
                match (excess, worst) {
                    (Some(e), None) => worst = Some((e, i)),
                    (Some(e), Some((most, _))) if e > most => worst = Some((e, i)),
                    (None, Some((_, at))) => {
                        new.push(at);
                        worst = None;
                    }
                    _ => {}
                }
            }
            if new.is_empty() {
                self.steps(&joints)?;
                let fixed = fixed.keys().copied().collect();
                return Ok(FitResult { joints, fixed, coefficients, rounds: round, judged });
            }
            let mut stuck = true;
            for at in new {
                let axis = self.assigned(at, self.judges[at].lean(&axes[at]));
                let here = placed(at, &axis)?;
                stuck &= fixed.insert(at, here) == Some(here);
            }
            if stuck {
                coefficients = (2 * coefficients).min(n + 2);
            }
        }
        let message = format!("no curves through all intervals were found in {ROUNDS} rounds");
        Err(self.error(0, message, "widen the strip, allow more roughness, or give the row more blocks"))
    }

    /// Refuses curves that run through the pole.
    fn steps(&self, joints: &[[f64; 2]]) -> Result<(), RescheduleError> {
        for (i, pair) in joints.windows(2).enumerate() {
            let step = (0..2).map(|k| (pair[1][k] - pair[0][k]).abs()).fold(0.0, f64::max);
            if step > POLE_STEP {
                let message = format!("a rotary joint turns by {:.1} degrees between two blocks", step.to_degrees());
                return Err(self.error(
                    i + 1,
                    message,
                    "the tool axis passes the pole of the machine: turn the part on the table",
                ));
            }
        }
        Ok(())
    }
}

/// Help where a rotary joint has no travel left.
const RANGE: &str = "turn the part on the table, or take a machine with a wider range";
