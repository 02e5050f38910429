//! Plans the known part of a path and measures the plan at the control samples.

use proveout_machine::JointValues;

use crate::{
    limits::slow_down,
    look_ahead::{SpeedCell, SpeedNode, SpeedPlan},
    path::{PathContext, RunPath, WayMeasure},
    profile::{Cursor, Law, PathState},
    retime::{LawEntry, LimitExcess, RepairOutcome, RetimeTask, Rounds, Stages, jerk_along},
    watch::{Over, REACH, over_limits},
};

/// Part by which a sample may pass a limit before rows are tightened, and after several rounds of that; the
/// promise is 0.1 percent.
const ALLOWED: f64 = 1.0005;
const PROMISED: f64 = 1.0009;
/// Rounds in which the rows of the tempo are tightened, before the first law is kept where limits are still
/// passed; four are usual.
const TIGHTENINGS: i32 = 12;
/// Rounds in which rows are tightened and solved again; later ones lower the tempo around what little is
/// left.
const SOLVED_AGAIN: i32 = 6;
/// Rounds after which a stretch is given up.
const ROUNDS: usize = 60;
/// How often cells are slowed down.
const SLOWINGS: usize = 2;
/// How much more than the excess the tempo is lowered: the dip itself takes a third back.
const TIGHTER: f64 = 1.2;
/// Half width of a dip over the time sqrt(v/J), see `retime.rs`.
const DIP: f64 = 3.5;
/// Part of the known cells that do not count yet: what comes next may act on them.
const UNKNOWN: usize = 8;
/// Trials to run a law slower as a whole, and the least change of a trial.
const SLOWER: usize = 200;
const SLOWER_BY: f64 = 1.001;
/// Most samples of a law: all of them are measured and held together, a kilobyte each. Slow joints at a short
/// control cycle come here, whose motion takes far longer than their way at full speed.
pub(crate) const MOST_SAMPLES: f64 = 2e6;
/// Time before the last node up to which a part of a run is committed, s: several times what the slowest
/// joints need for a change of their acceleration.
const AHEAD: f64 = 0.5;
/// Step of time by which the tempo of a law is measured, s.
const TEMPO_STEP_S: f64 = 1e-3;
/// Most samples that room is made for.
const ROOM_SAMPLES: f64 = 1e6;

/// State at a control sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlanSample {
    pub(crate) time: f64,
    pub(crate) state: PathState,
    /// Way by the path parameter on the path that is run: of the tip (or of the linear joints), and of the
    /// rotary joints.
    pub(crate) rate: [f64; 2],
    /// Feed on the path that is run over the programmed one; zero in rapid motion.
    pub(crate) feed_use: f64,
    pub(crate) q: JointValues,
    pub(crate) velocity: JointValues,
    pub(crate) acceleration: JointValues,
    pub(crate) jerk: JointValues,
}

/// A planned stretch from the begin of the path's first cell.
pub(crate) struct PlanStretch {
    pub(crate) law: Law,
    /// Number of cells in the stretch.
    pub(crate) cells: usize,
    /// Path parameter and speed at its end.
    pub(crate) s_end: f64,
    pub(crate) v_end: f64,
    /// The tempo with which the path goes on.
    pub(crate) entry: LawEntry,
    pub(crate) samples: Vec<PlanSample>,
    /// How the machine comes to rest from there.
    pub(crate) reserve: Option<Reserve>,
}

/// A law from the end of a stretch to rest, which keeps the limits at all samples.
pub(crate) struct Reserve {
    law: Law,
    cells: usize,
    s_end: f64,
}

impl Reserve {
    /// The reserve as a stretch, at the end of the one with which it was made.
    pub(crate) fn stretch(self, path: &RunPath, frame: &PathContext<'_>, clock: Clock) -> PlanStretch {
        let Self { law, cells, s_end } = self;
        let samples = measure(path, frame, clock, &law, 0);
        PlanStretch { law, cells, s_end, v_end: 0.0, entry: LawEntry::default(), samples, reserve: None }
    }
}

/// What came of planning.
pub(crate) enum Outcome {
    /// A stretch that keeps the limits at all samples.
    Planned(Box<PlanStretch>),
    /// No node lies far enough before the end of what is known.
    NotYet,
    /// The motion takes this time, s, and more than [`MOST_SAMPLES`]; path parameter of what takes most of
    /// it.
    TooLong(f64, f64),
    /// No tempo was found that keeps the limits from a begin in motion on, or none from which the machine
    /// comes to rest.
    Failed,
}

/// Control cycle, the time at which a law begins, and the set points at the last three times of the grid
/// before it.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub(crate) cycle: f64,
    pub(crate) start: f64,
    pub(crate) before: [JointValues; REACH],
}

/// Part of a cycle within which a time is one of the grid: motions of round numbers end on the grid but for
/// rounding, and the sample there must be neither lost nor taken twice.
const ON_GRID: f64 = 1e-6;

/// Number of the first time of the grid that is not before `time`.
pub(crate) fn grid_number(time: f64, cycle: f64) -> f64 {
    (time / cycle - ON_GRID).ceil()
}

impl Clock {
    /// Number of the first time of the grid from the start on.
    fn first(&self) -> f64 {
        grid_number(self.start, self.cycle)
    }

    /// Sample times within `duration` from the start, on the grid of the cycle.
    pub(crate) fn samples(self, duration: f64) -> impl Iterator<Item = f64> {
        let (first, end) = (self.first(), grid_number(self.start + duration, self.cycle));
        (0_u64..).map(move |k| first + k as f64).take_while(move |k| *k < end).map(move |k| k * self.cycle)
    }

    /// True where a law has more samples than are held.
    pub(crate) fn takes_too_many(&self, law: &Law) -> bool {
        law.duration > MOST_SAMPLES * self.cycle
    }

    /// Places that exceed a part `allowed` of the limits; `finish` says that the machine stops at
    /// the end of the path.
    fn over_limits(
        &self,
        path: &RunPath,
        frame: &PathContext<'_>,
        samples: &[PlanSample],
        finish: bool,
        allowed: f64,
    ) -> Vec<Over> {
        let end = path.cells.last().map_or(path.s_begin, |c| c.s1);
        let stands =
            finish.then(|| frame.kinematics.position(&path.rounded(end, &mut path.spans.len().saturating_sub(1)).0[0]));
        let times = [self.cycle, self.first() * self.cycle];
        over_limits(frame.limits, times, &self.before, samples, stands.as_ref(), allowed)
    }
}

/// Plans all cells of the path from speed `v_start`, begun with the tempo of `entry`. With `finish` the whole
/// is taken; otherwise up to a node where what is still unknown hardly acts.
///
/// *What is committed keeps the limits.* A stretch is returned if the samples of the whole law keep
/// them, from its begin over its end up to rest at the end of the known path. The part after its
/// end is its reserve: if the next part of the path finds no law, the machine comes to rest with
/// it. From rest to rest a law is always found, since running it slower brings all differences as
/// low as required ([`slow_throughout`]):
///
/// ```text
///   v |   ____          ____
///     |  /    \________/    \ .  .  .         next window: from the end of the stretch on
///     | /      stretch   |    ' .
///     |/                 |       ' . reserve   not run, unless the next window fails
///     +------------------+-----------+-------> t
/// ```
pub(crate) fn plan(
    path: &mut RunPath,
    frame: &PathContext<'_>,
    clock: Clock,
    v_start: f64,
    (entry, stages): (&LawEntry, &mut Stages),
    finish: bool,
) -> Outcome {
    let borders: Vec<f64> = std::iter::once(path.s_begin).chain(path.cells.iter().map(|c| c.s1)).collect();
    let n = path.cells.len();
    let rest = [v_start == 0.0, finish];
    let mut slowed = 0;
    loop {
        let cells: Vec<SpeedCell> = path.cells.iter().map(|c| c.limits.cell).collect();
        let plan = SpeedPlan::new(&cells, &borders, [v_start, 0.0]);
        // What comes after the last node does not act on the first law before it.
        let last = if finish { Some(SpeedNode::end(n)) } else { plan.split_before(n - n / UNKNOWN) };
        let Some(last) = last else { return Outcome::NotYet };
        let first_law = plan.law(&borders, last.border);
        let node = if finish { Some(last) } else { committed(&plan, &first_law, &borders, last) };
        let Some(node) = node else { return Outcome::NotYet };
        if clock.takes_too_many(&first_law) {
            return Outcome::TooLong(first_law.duration, slowest(&first_law, &borders[..=last.border]));
        }
        let until = if finish {
            first_law.planned
        } else {
            first_law.planned_time_at(borders[node.border], &mut Cursor::default())
        };
        let course = RetimeTask { path, frame, law: &first_law, cells: last.border, entry, rest };
        let mut found = within_limits(&course, clock, stages);
        if let Err((law, samples, _)) = &mut found
            && slowed == SLOWINGS
            && rest == [true, true]
        {
            slow_throughout(path, frame, clock, law, samples);
            found = Ok((std::mem::take(law), std::mem::take(samples)));
        }
        let over = match found {
            Err((_, _, over)) => over,
            Ok((law, mut samples)) => {
                let mut law = if finish { law } else { law.followed_by(plan.law(&borders, n)) };
                if clock.takes_too_many(&law) {
                    return Outcome::TooLong(law.duration, slowest(&plan.law(&borders, n), &borders));
                }
                // What was not looked at yet: the way to rest.
                let known = samples.len();
                samples.extend(measure(path, frame, clock, &law, known));
                let over = if finish { Vec::new() } else { clock.over_limits(path, frame, &samples, true, PROMISED) };
                if over.is_empty() {
                    let behind = law.cut(until);
                    let end = grid_number(clock.start + law.duration, clock.cycle);
                    let count = samples.partition_point(|m| grid_number(m.time, clock.cycle) < end);
                    samples.truncate(count);
                    let entry = LawEntry::new(behind.tempos.clone());
                    let reserve = (!finish).then(|| Reserve { law: behind, cells: n - node.border, s_end: borders[n] });
                    let (cells, s_end, v_end) = (node.border, borders[node.border], node.speed);
                    return Outcome::Planned(Box::new(PlanStretch {
                        law,
                        cells,
                        s_end,
                        v_end,
                        entry,
                        samples,
                        reserve,
                    }));
                }
                over
            }
        };
        if slowed == SLOWINGS {
            return Outcome::Failed;
        }
        // The first law itself passes a limit: between the points at which its cells were looked at.
        slow_cells(path, &borders, &over);
        slowed += 1;
    }
}

/// Middle of the cell on which a law spends most time.
fn slowest(law: &Law, borders: &[f64]) -> f64 {
    let mut cursor = Cursor::default();
    let times: Vec<f64> = borders.iter().map(|s| law.planned_time_at(*s, &mut cursor)).collect();
    let cells = times.windows(2).zip(borders.windows(2));
    let longest = cells.max_by(|(a, _), (b, _)| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    longest.map_or(0.0, |(_, s)| f64::midpoint(s[0], s[1]))
}

/// A law with its samples, and the places where it passes limits.
type Trial = (Law, Vec<PlanSample>, Vec<Over>);

/// The fastest law that is found whose samples keep the limits; otherwise the last one that was tried.
fn within_limits(course: &RetimeTask<'_>, clock: Clock, stages: &mut Stages) -> Result<(Law, Vec<PlanSample>), Trial> {
    let RetimeTask { path, frame, rest, .. } = *course;
    let mut rounds = Rounds::new(stages);
    let (mut round, mut all) = (0, 0);
    let mut samples = Vec::new();
    loop {
        let law = rounds.retimed(course);
        // The continuation after the committed part must keep the limits too: the next part begins
        // with its state.
        measure_into(&mut samples, path, frame, clock, &law, 0);
        let allowed = if round < TIGHTENINGS / 2 { ALLOWED } else { PROMISED };
        let over = clock.over_limits(path, frame, &samples, rest[1], allowed);
        round += 1;
        all += 1;
        if over.is_empty() {
            return Ok((law, samples));
        }
        if all == ROUNDS {
            return Err((law, samples, over));
        }
        let spots = spots(path, frame, clock, &law, &over);
        if round <= TIGHTENINGS {
            rounds.slow_down(&spots, round > SOLVED_AGAIN);
            continue;
        }
        match rounds.settle(&spots) {
            RepairOutcome::Slower => {}
            // Around the parts that returned to the first law, tempos are solved again.
            RepairOutcome::AsItWas => round = 0,
            RepairOutcome::Nothing => return Err((law, samples, over)),
        }
    }
}

/// Places of the first law where the tempo must change.
fn spots(path: &RunPath, frame: &PathContext<'_>, clock: Clock, law: &Law, over: &[Over]) -> Vec<LimitExcess> {
    let mut cursor = Cursor::default();
    let last = path.cells.len() - 1;
    over.iter()
        .map(|Over { time, s, v, ratios: [velocity, a, j] }| {
            let t = (time - clock.start).max(0.0);
            let cell = path.cells.partition_point(|c| c.s1 < *s).min(last);
            let pace = v / jerk_along(frame, &path.cells[cell]);
            // Widths are times of the first law, which passes faster by the tempo.
            let [at, ahead] = [t, t + TEMPO_STEP_S].map(|t| law.planned_time(t, &mut cursor));
            let tempo = ((ahead - at) / TEMPO_STEP_S).max(1.0);
            let excess = (a - 1.0).max(j - 1.0).max(2.0 * (velocity - 1.0)).max(0.0);
            let width = (DIP * tempo * pace.sqrt()).clamp(0.01, 1.0);
            LimitExcess { at, excess: (TIGHTER * excess).min(0.3), width }
        })
        .collect()
}

/// Runs a law from rest to rest slower as a whole, where samples pass limits that nothing else has brought
/// down: speed falls with the factor, acceleration with its square, jerk with its cube, so that this ends
/// below every limit above zero.
fn slow_throughout(
    path: &RunPath,
    frame: &PathContext<'_>,
    clock: Clock,
    law: &mut Law,
    samples: &mut Vec<PlanSample>,
) {
    // Samples fall elsewhere on the slower law: a second time is rare, a third was never seen.
    for _ in 0..SLOWER {
        let over = clock.over_limits(path, frame, samples, true, PROMISED);
        let ratios = over.iter().map(|o| o.ratios);
        let factor = ratios.fold(SLOWER_BY, |m: f64, [v, a, j]| m.max(v).max(a.sqrt()).max(j.cbrt()));
        if over.is_empty() || !factor.is_finite() {
            return;
        }
        law.slow_down(factor);
        *samples = measure(path, frame, clock, law, 0);
    }
}

/// The last node that lies far enough before `last` for the tempo there not to act on what is committed.
fn committed(plan: &SpeedPlan, law: &Law, borders: &[f64], last: SpeedNode) -> Option<SpeedNode> {
    let until = (law.planned - AHEAD).max(0.5 * law.planned);
    let mut cursor = Cursor::default();
    let border = borders[..=last.border].partition_point(|s| law.planned_time_at(*s, &mut cursor) <= until);
    plan.split_before(border.saturating_sub(1))
}

/// Joint states at the control samples of a law but the first ones.
pub(crate) fn measure(
    path: &RunPath,
    frame: &PathContext<'_>,
    clock: Clock,
    law: &Law,
    skipped: usize,
) -> Vec<PlanSample> {
    let mut samples = Vec::new();
    measure_into(&mut samples, path, frame, clock, law, skipped);
    samples
}

/// The same into room that is there: samples are many, and measured several times.
fn measure_into(
    samples: &mut Vec<PlanSample>,
    path: &RunPath,
    frame: &PathContext<'_>,
    clock: Clock,
    law: &Law,
    skipped: usize,
) {
    let (mut phase, mut span) = (Cursor::default(), 0);
    let machine = frame.kinematics.machine;
    let mut cell = 0;
    // A law that never ends has no samples to make room for.
    let count = (law.duration / clock.cycle).clamp(0.0, ROOM_SAMPLES) as usize + 1;
    samples.clear();
    // The way to rest follows the known part of a window: untouched memory costs nothing, moving
    // all samples does.
    samples.reserve(count.saturating_sub(skipped) * 5 / 4);
    for time in clock.samples(law.duration).skip(skipped) {
        let state = law.at(time - clock.start, &mut phase);
        while cell + 1 < path.cells.len() && path.cells[cell].s1 < state.s {
            cell += 1;
        }
        let task = path.rounded(state.s, &mut span);
        let q = match path.cells.get(cell).and_then(|c| c.joints.as_ref()) {
            Some(joints) => joints.jet(state.s),
            None => frame.kinematics.joints(&task),
        };
        let (q1, q2, q3) = (q.first(), q.second(), q.third());
        let PathState { v, a, j, .. } = state;
        let mut rate = [WayMeasure::Tip, WayMeasure::Turn].map(|way| way.rate(machine, &task)[0]);
        let feed_use = path.cells.get(cell).map_or(0.0, |c| {
            let counted = match c.limits.way {
                WayMeasure::Parameter => 1.0,
                WayMeasure::Tip => rate[0],
                WayMeasure::Turn => rate[1],
            };
            if c.limits.way == WayMeasure::Parameter && !c.exact {
                rate = [1.0; 2]; // between motion and turning
            }
            v * counted / c.limits.feed
        });
        samples.push(PlanSample {
            time,
            state,
            rate,
            feed_use,
            q: q.0[0],
            velocity: q1 * v,
            acceleration: q1 * a + q2 * (v * v),
            jerk: q1 * j + q2 * (3.0 * v * a) + q3 * (v * v * v),
        });
    }
}

/// Slows down the cells of samples that pass a limit, and their neighbors, each by the highest excess.
fn slow_cells(path: &mut RunPath, borders: &[f64], over: &[Over]) {
    let last = path.cells.len() - 1;
    let mut highest = vec![[1.0_f64; 3]; path.cells.len()];
    for Over { s, ratios, .. } in over {
        let cell = borders[1..].partition_point(|border| border < s).min(last);
        for worst in &mut highest[cell.saturating_sub(1)..=(cell + 1).min(last)] {
            for (worst, ratio) in worst.iter_mut().zip(ratios) {
                *worst = worst.max(*ratio);
            }
        }
    }
    for (cell, ratios) in path.cells.iter_mut().zip(highest) {
        if ratios != [1.0; 3] {
            slow_down(&mut cell.limits, ratios);
        }
    }
}

#[cfg(test)]
mod tests;
