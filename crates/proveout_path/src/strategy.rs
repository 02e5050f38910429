//! Strategies: families of lines over a surface, spaced by the scallop that they leave.

use std::fmt::Debug;

use proveout_blade::ParametricSurface;

use super::{
    AxisRule, Line, LineContacts, PathCutter, PathError, PathPoint, Sampler, StepRule,
    error::LEAST_SCALLOP_MM,
    scallop::{scallop_height, side_step},
};

/// What a strategy plans for.
///
/// ```
/// use proveout_blade::{ClosedSurface, Sine};
/// use proveout_tool::Cutter;
/// use proveout_path::{AxisRule, PathCutter, Spacing, StepRule, Task, Transverse};
///
/// let face = ClosedSurface::new(Sine::gentle()); // 30 mm wide, two waves of 40 mm
/// let ball = PathCutter::new(Cutter::ball(6.0)?.bodies(20.0)?.remove(0));
/// let (rule, step) = (AxisRule::Normal, StepRule::Length(1.0));
/// let task = Task { surface: &face, cutter: &ball, rule: &rule, step, allowance: 0.0 };
/// let spacing = Spacing::At(vec![0.25]); // along the first crest
/// let line = Transverse { round: [0.1, 0.9], range: [0.0, 1.0], spacing, one_way: true };
/// let plan = task.plan(&line)?;
/// let last = plan[0].contacts.last().expect("a line has contacts");
/// assert!((last.length - 24.0).abs() < 1e-9); // 0.8 of the width, mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The surface.
    pub surface: &'a dyn ParametricSurface,
    /// The cutter.
    pub cutter: &'a PathCutter,
    /// The tool axis.
    pub rule: &'a AxisRule,
    /// The step along a line.
    pub step: StepRule,
    /// Material left on the surface, mm; a strategy of layers has its own.
    pub allowance: f64,
}

/// Spacing of the lines of a family.
#[derive(Clone, Debug, PartialEq)]
pub enum Spacing {
    /// Ridges between neighbors are nowhere higher than this, mm.
    Scallop(f64),
    /// Lines at these values of the family's label.
    At(Vec<f64>),
}

/// A strategy of paths.
pub trait Strategy: Debug {
    /// The lines, in the order and direction in which they are cut.
    ///
    /// # Errors
    /// What does not exist on this surface or for this cutter, with section and point.
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError>;
    /// Whether its lines have allowances of their own.
    fn has_layers(&self) -> bool {
        false
    }
}

/// The lines of a strategy, each in the direction of the first one instead of to and fro: the chord of a line
/// that points against that of the first is turned.
#[derive(Debug)]
pub struct OneWay(pub Box<dyn Strategy>);

impl Strategy for OneWay {
    fn lines(&self, task: &Task<'_>) -> Result<Vec<Line>, PathError> {
        let mut lines = self.0.lines(task)?;
        let chord = |line: &Line| {
            let [from, to] = line.curve.range().map(|t| {
                let at = line.curve.at(t);
                task.surface.local(at.u[0], at.v[0]).point
            });
            to - from
        };
        if let Some(first) = lines.first().map(chord) {
            for line in lines.iter_mut().filter(|line| chord(line).dot(&first) < 0.0) {
                line.curve = line.curve.reversed();
            }
        }
        Ok(lines)
    }

    fn has_layers(&self) -> bool {
        self.0.has_layers()
    }
}

/// Lines that differ by one number.
pub(crate) trait LineFamily {
    /// The line with a label.
    fn line(&self, label: f64) -> Result<Line, PathError>;
}

/// Places of a line at which its distance to a neighbor is looked at.
const LOOKS: usize = 65;
/// Lines of a family beyond which its numbers are a mistake.
const MOST_LINES: usize = 100_000;
/// Least part of a side step that counts as used: the next try stays finite.
pub(super) const LEAST_USED: f64 = 1e-3;
/// Largest allowance, mm.
const MOST_ALLOWANCE_MM: f64 = 1e3;
/// By how much a side step may be passed by rounding, part of it.
const ROUNDING: f64 = 1e-9;
/// Shortest step from label to label, part of their range: with shorter ones the lines come to no end.
const LEAST_STEP: f64 = 1e-9;
/// Cosine of the angle between feeds below which the next line runs across.
const ACROSS: f64 = 1e-9;
/// Step at which the search on the next line ends, part of it.
const FOUND: f64 = 1e-12;
/// How far off the plane across the feed the place of the next line may be, part of the side step.
const OFF_PLANE: f64 = 1e-3;
/// Side step that is taken for this at least, mm.
const LEAST_BESIDE_MM: f64 = 1e-6;
/// Ends whose squared distances differ by no more than this are one place, mm2.
const CLOSED_MM2: f64 = 1e-9;

impl Task<'_> {
    /// Contacts of all lines with the scallops between neighbors.
    ///
    /// # Errors
    /// As [`Sampler::line`].
    pub fn contacts(&self, lines: &[Line]) -> Result<Vec<LineContacts>, PathError> {
        let sampler = Sampler { surface: self.surface, cutter: self.cutter, rule: self.rule, step: self.step };
        sampler.check()?;
        lines.iter().map(|line| sampler.line(line)).collect()
    }

    /// Plans a strategy: lines, contacts, scallops.
    ///
    /// # Errors
    /// As [`Strategy::lines`] and [`Sampler::line`].
    pub fn plan(&self, strategy: &dyn Strategy) -> Result<Vec<LineContacts>, PathError> {
        PathError::within("the allowance in mm", self.allowance, 0.0, MOST_ALLOWANCE_MM)?;
        let mut lines = strategy.lines(self)?;
        if !strategy.has_layers() {
            lines.iter_mut().for_each(|line| line.allowance = self.allowance);
        }
        let mut paths = self.contacts(&lines)?;
        for k in 0..paths.len().saturating_sub(1) {
            let [from, to] = [&lines[k], &lines[k + 1]];
            if from.allowance == to.allowance {
                fill_scallops(self.surface, &mut paths[k], to);
            }
        }
        Ok(paths)
    }

    /// Side step that the scallop allows at a place of a line, mm.
    pub(crate) fn allowed(&self, line: &Line, t: f64, part: f64, scallop: f64) -> Result<(PathPoint, f64), PathError> {
        let place = PathPoint::on(self.surface, &line.curve, t);
        let at = || place.named(&self.surface.domain());
        let axis = self.rule.axis(&place, part).ok_or_else(|| PathError::NoAxis { at: at() })?;
        let touch = self.cutter.touch(&place, &axis, line.allowance, None);
        let no = |reason| PathError::NoSideStep { at: at(), scallop_mm: scallop, reason };
        let envelope = super::envelope_across(&touch.form, &place.form)
            .ok_or_else(|| no("the cutter is larger than the hollow of the surface"))?;
        if envelope <= 0.0 {
            return Err(no(
                "the cutter leaves a flat across the feed, which has no ridge: give the lines by their values",
            ));
        }
        let step = side_step(envelope, place.form[2], scallop);
        Ok((place, step.ok_or_else(|| no("no step leaves so high a ridge"))?))
    }

    /// Lines of a family from one label to another whose ridges are nowhere higher than `scallop`.
    pub(crate) fn spaced(
        &self,
        family: &dyn LineFamily,
        from: f64,
        to: f64,
        scallop: f64,
    ) -> Result<Vec<Line>, PathError> {
        PathError::within("the scallop in mm", scallop, LEAST_SCALLOP_MM, 10.0)?;
        let mut label = from;
        let mut line = family.line(label)?;
        let mut lines = Vec::new();
        let ahead = if to >= from { 1.0 } else { -1.0 };
        let mut step = 0.01 * (to - from);
        while (to - label) * ahead > 0.0 {
            let looks = self.looks(&line, scallop)?;
            // The largest part of its allowed side step that a step of the label takes anywhere.
            let used = |next: &Line| -> f64 {
                let [start, end] = next.curve.range();
                looks.iter().enumerate().fold(0.0, |most, (k, (place, allowed))| {
                    let other =
                        PathPoint::on(self.surface, &next.curve, start + (end - start) * k as f64 / (LOOKS - 1) as f64);
                    f64::max(most, beside(place, &other) / allowed)
                })
            };
            // The range ends with a line, and none lies beyond it.
            if (to - label - step) * ahead <= 0.0 {
                step = to - label;
            }
            let mut next = family.line(label + step)?;
            for _ in 0..30 {
                let taken = used(&next);
                if taken <= 1.0 && (taken > 0.98 || (to - label - step) * ahead <= 0.0) {
                    break;
                }
                let whole = step * (0.99 / taken.max(LEAST_USED)).clamp(0.05, 20.0);
                step = if (to - label - whole) * ahead <= 0.0 { to - label } else { whole };
                next = family.line(label + step)?;
            }
            if used(&next) > 1.0 + ROUNDING || step.abs() < LEAST_STEP * (to - from).abs() {
                let place = PathPoint::on(self.surface, &line.curve, line.curve.range()[0]);
                let reason =
                    "neighboring lines of this family are too far apart somewhere, however near their labels are";
                return Err(PathError::NoSideStep {
                    at: place.named(&self.surface.domain()),
                    scallop_mm: scallop,
                    reason,
                });
            }
            lines.push(line);
            label += step;
            line = next;
            if lines.len() > MOST_LINES {
                return Err(PathError::TooLong);
            }
        }
        lines.push(line);
        Ok(lines)
    }

    /// Places of a line with the side steps that the scallop allows there.
    pub(crate) fn looks(&self, line: &Line, scallop: f64) -> Result<Vec<(PathPoint, f64)>, PathError> {
        let [start, end] = line.curve.range();
        let part = |k: usize| k as f64 / (LOOKS - 1) as f64;
        (0..LOOKS).map(|k| self.allowed(line, start + (end - start) * part(k), part(k), scallop)).collect()
    }

    /// The lines of a family as a spacing says.
    pub(crate) fn family(
        &self,
        family: &dyn LineFamily,
        range: [f64; 2],
        spacing: &Spacing,
    ) -> Result<Vec<Line>, PathError> {
        match spacing {
            Spacing::At(labels) => {
                PathError::within("the number of lines", labels.len() as f64, 1.0, MOST_LINES as f64)?;
                labels.iter().map(|&label| family.line(label)).collect()
            }
            Spacing::Scallop(height) => self.spaced(family, range[0], range[1], *height),
        }
    }
}

/// Distance of a place of the next line across the feed, mm: the chord in the plane across.
pub(crate) fn beside(place: &PathPoint, other: &PathPoint) -> f64 {
    let d = other.point - place.point;
    d.dot(&place.across).hypot(d.dot(&place.normal))
}

/// Every second line the other way, so that the cutter goes to and fro.
pub(crate) fn to_and_fro(lines: &mut [Line]) {
    for line in lines.iter_mut().skip(1).step_by(2) {
        line.curve = line.curve.reversed();
    }
}

/// Side steps and scallops of a line against the next one: the place of the next line in the plane across the
/// feed, by Newton on t.
fn fill_scallops(surface: &dyn ParametricSurface, path: &mut LineContacts, next: &Line) {
    let [start, end] = next.curve.range();
    let mut t = None;
    for contact in &mut path.contacts {
        let here = contact.place;
        let along = |t: f64| (PathPoint::on(surface, &next.curve, t), t);
        let begin = t.unwrap_or_else(|| nearest_end(surface, next, &here));
        let (mut place, mut at) = along(begin);
        for _ in 0..8 {
            let off = (place.point - here.point).dot(&here.feed);
            let rate = place.feed.dot(&here.feed) * place.speed;
            if rate.abs() < ACROSS * place.speed {
                break;
            }
            let stepped = (at - off / rate).clamp(start, end);
            let done = (stepped - at).abs() <= FOUND * (end - start);
            (place, at) = along(stepped);
            if done {
                break;
            }
        }
        t = Some(at);
        // Beyond the end of the next line there is no neighbor, and none on the other side of the part.
        if place.normal.dot(&here.normal) <= 0.0 {
            t = None;
            continue;
        }
        if (place.point - here.point).dot(&here.feed).abs() > OFF_PLANE * beside(&here, &place).max(LEAST_BESIDE_MM) {
            continue;
        }
        let step = beside(&here, &place);
        contact.side_step = Some(step);
        contact.scallop = contact.envelope().filter(|e| *e > 0.0).and_then(|e| scallop_height(e, here.form[2], step));
    }
}

fn nearest_end(surface: &dyn ParametricSurface, line: &Line, here: &PathPoint) -> f64 {
    let ends = line.curve.range();
    let off = |t: f64| (PathPoint::on(surface, &line.curve, t).point - here.point).norm_squared();
    let [first, last] = ends.map(off);
    // Both ends of a line that closes are one place: the one from which it goes the way of the feed.
    let ahead = PathPoint::on(surface, &line.curve, ends[0]).feed.dot(&here.feed) >= 0.0;
    let start = if (first - last).abs() <= CLOSED_MM2 { ahead } else { first < last };
    if start { ends[0] } else { ends[1] }
}
