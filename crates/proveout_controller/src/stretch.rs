//! Plans the known part of a path and measures the plan at the control samples.

use proveout_machine::JointValues;

use crate::{
    jet::JointJet,
    limits::slow_down,
    path::{Frame, Path},
    plan::{Cell, Node, Plan},
    profile::{Cursor, Law, PathState},
    retime::{Course, Entry, Rounds, Settled, Spot, jerk_along},
    watch::{Over, REACH, over_limits},
};

/// Part by which a sample may pass a limit before rows are tightened, and after several rounds of that; the promise is 0.1
/// percent.
const ALLOWED: f64 = 1.0005;
const PROMISED: f64 = 1.0009;
/// Rounds in which the rows of the tempo are tightened, before the first law is kept where limits are still passed; four are
/// usual.
const TIGHTENINGS: i32 = 12;
/// Rounds in which rows are tightened and solved again; later ones lower the tempo around what little is left.
const SOLVED_AGAIN: i32 = 6;
/// How often cells are slowed down.
const SLOWINGS: usize = 2;
/// How much more than the excess the tempo is lowered: the dip itself takes a third back.
const TIGHTER: f64 = 1.2;
/// Half width of a dip over the time sqrt(v/J), see `retime.rs`.
const DIP: f64 = 3.5;
/// Part of the known cells that do not count yet: what comes next may act on them.
const UNKNOWN: usize = 4;
/// Time before the last node up to which a part of a run is committed, s: several times what the slowest joints need for
/// a change of their acceleration.
const AHEAD: f64 = 0.5;

/// State at a control sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured {
    pub(crate) time: f64,
    pub(crate) state: PathState,
    pub(crate) task: JointJet,
    pub(crate) q: JointValues,
    pub(crate) velocity: JointValues,
    pub(crate) acceleration: JointValues,
    pub(crate) jerk: JointValues,
}

/// A planned stretch from the begin of the path's first cell.
pub(crate) struct Stretch {
    pub(crate) law: Law,
    /// Number of cells in the stretch.
    pub(crate) cells: usize,
    /// Path parameter and speed at its end.
    pub(crate) s_end: f64,
    pub(crate) v_end: f64,
    /// The tempo with which the path goes on.
    pub(crate) entry: Entry,
    pub(crate) samples: Vec<Measured>,
}

/// Control cycle, the time at which a law begins, and the set points at the last three times of the grid before it.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub(crate) cycle: f64,
    pub(crate) start: f64,
    pub(crate) before: [JointValues; REACH],
}

impl Clock {
    /// Number of the first time of the grid from the start on.
    fn first(&self) -> f64 {
        (self.start / self.cycle).ceil()
    }

    /// Sample times within `duration` from the start, on the grid of the cycle.
    pub(crate) fn samples(self, duration: f64) -> impl Iterator<Item = f64> {
        let first = self.first();
        (0_u64..).map(move |k| (first + k as f64) * self.cycle).take_while(move |t| *t < self.start + duration)
    }

    /// What passes a part `allowed` of the limits; `finish` tells that the machine stands at the end of the path then.
    fn over_limits(
        &self,
        path: &Path,
        frame: &Frame<'_>,
        samples: &[Measured],
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

/// Plans all cells of the path from speed `v_start`, begun with the tempo of `entry`. With `finish` the whole is taken;
/// otherwise up to a node where what is still unknown hardly acts: none when there is no such node yet.
pub(crate) fn plan(
    path: &mut Path,
    frame: &Frame<'_>,
    clock: Clock,
    v_start: f64,
    entry: &Entry,
    finish: bool,
) -> Option<Stretch> {
    let borders: Vec<f64> = std::iter::once(path.s_begin).chain(path.cells.iter().map(|c| c.s1)).collect();
    let n = path.cells.len();
    let mut slowed = 0;
    loop {
        let cells: Vec<Cell> = path.cells.iter().map(|c| c.limits.cell).collect();
        let plan = Plan::new(&cells, &borders, [v_start, 0.0]);
        // What lies behind the last node does not act on the first law before it.
        let last = if finish { Node::end(n) } else { plan.split_before(n - n / UNKNOWN)? };
        let first_law = plan.law(&borders, last.border);
        let node = if finish { last } else { committed(&plan, &first_law, &borders, last)? };
        let until = if finish {
            first_law.planned
        } else {
            first_law.planned_time_at(borders[node.border], &mut Cursor::default())
        };
        let mut rounds = Rounds::default();
        let mut round = 0;
        let rest = [v_start == 0.0, finish];
        loop {
            let mut law = rounds.retimed(&Course { path, frame, law: &first_law, cells: last.border, entry, rest });
            // What goes on behind the committed part must keep the limits too: the next part begins with its state.
            let mut samples = measure(path, frame, clock, &law);
            let allowed = if round < TIGHTENINGS / 2 { ALLOWED } else { PROMISED };
            let over = clock.over_limits(path, frame, &samples, finish, allowed);
            round += 1;
            if over.is_empty() || round > TIGHTENINGS && slowed == SLOWINGS {
                if rest == [true, true] {
                    slow_throughout(path, frame, clock, &mut law, &mut samples);
                }
                let behind = law.cut(until);
                let count = samples.partition_point(|m| m.time < clock.start + law.duration);
                samples.truncate(count);
                return Some(Stretch {
                    law,
                    cells: node.border,
                    s_end: borders[node.border],
                    v_end: node.speed,
                    entry: Entry::new(behind),
                    samples,
                });
            }
            let mut cursor = Cursor::default();
            let spots: Vec<Spot> = over
                .iter()
                .map(|Over { time, s, v, ratios: [velocity, a, j] }| {
                    let t = (time - clock.start).max(0.0);
                    let cell = path.cells.partition_point(|c| c.s1 < *s).min(n - 1);
                    let pace = v / jerk_along(frame, &path.cells[cell]);
                    // Widths are times of the first law, which passes faster by the tempo.
                    let [at, ahead] = [t, t + 1e-3].map(|t| law.planned_time(t, &mut cursor));
                    let tempo = ((ahead - at) / 1e-3).max(1.0);
                    let excess = (a - 1.0).max(j - 1.0).max(2.0 * (velocity - 1.0)).max(0.0);
                    let width = (DIP * tempo * pace.sqrt()).clamp(0.01, 1.0);
                    Spot { at, excess: (TIGHTER * excess).min(0.3), width }
                })
                .collect();
            if round <= TIGHTENINGS {
                rounds.slow_down(&spots, round > SOLVED_AGAIN);
                continue;
            }
            match rounds.settle(&spots) {
                Settled::Slower => {}
                // Around what is as it was, tempos are found anew.
                Settled::AsItWas => round = 0,
                // The first law itself passes a limit: between the points at which its cells were looked at.
                Settled::Nothing => {
                    slow_cells(path, &borders, &over);
                    slowed += 1;
                    break;
                }
            }
        }
    }
}

/// Runs a law from rest to rest slower as a whole, where samples pass limits that nothing else has brought down: speed falls with
/// the factor, acceleration with its square, jerk with its cube.
fn slow_throughout(path: &Path, frame: &Frame<'_>, clock: Clock, law: &mut Law, samples: &mut Vec<Measured>) {
    // Samples fall elsewhere on the slower law: a second time is rare, a third was never seen.
    for _ in 0..4 {
        let over = clock.over_limits(path, frame, samples, true, PROMISED);
        let factor = over.iter().map(|o| o.ratios).fold(1.0, |m: f64, [v, a, j]| m.max(v).max(a.sqrt()).max(j.cbrt()));
        if over.is_empty() || !factor.is_finite() {
            return;
        }
        law.slow_down(factor);
        *samples = measure(path, frame, clock, law);
    }
}

/// The last node that lies far enough before `last` for the tempo there not to act on what is committed.
fn committed(plan: &Plan, law: &Law, borders: &[f64], last: Node) -> Option<Node> {
    let until = (law.planned - AHEAD).max(0.5 * law.planned);
    let mut cursor = Cursor::default();
    let border = borders[..=last.border].partition_point(|s| law.planned_time_at(*s, &mut cursor) <= until);
    plan.split_before(border.saturating_sub(1))
}

/// Joint states at the control samples of a law.
pub(crate) fn measure(path: &Path, frame: &Frame<'_>, clock: Clock, law: &Law) -> Vec<Measured> {
    let (mut phase, mut span) = (Cursor::default(), 0);
    clock
        .samples(law.duration)
        .map(|time| {
            let state = law.at(time - clock.start, &mut phase);
            let task = path.rounded(state.s, &mut span);
            let q = frame.kinematics.joints(&task);
            let (q1, q2, q3) = (q.first(), q.second(), q.third());
            let PathState { v, a, j, .. } = state;
            Measured {
                time,
                state,
                task,
                q: q.0[0],
                velocity: q1 * v,
                acceleration: q1 * a + q2 * (v * v),
                jerk: q1 * j + q2 * (3.0 * v * a) + q3 * (v * v * v),
            }
        })
        .collect()
}

/// Slows down the cells of samples that pass a limit, and their neighbors.
fn slow_cells(path: &mut Path, borders: &[f64], over: &[Over]) {
    let mut cell = 0;
    let last = path.cells.len() - 1;
    for Over { s, ratios, .. } in over {
        while cell + 2 < borders.len() && borders[cell + 1] < *s {
            cell += 1;
        }
        for k in cell.saturating_sub(1)..=(cell + 1).min(last) {
            slow_down(&mut path.cells[k].limits, *ratios);
        }
    }
}
