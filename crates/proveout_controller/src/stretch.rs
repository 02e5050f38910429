//! Plans the known part of a path and measures the plan at the control samples.

use proveout_machine::JointValues;

use crate::{
    jet::JointJet,
    limits::{reshaped, slow_down},
    path::{Frame, Path},
    plan::{Cell, Node, Plan},
    profile::{Law, PathState},
};

/// Part by which a sample may pass a limit before cells are slowed down; the promise is 0.1 percent.
const ALLOWED: f64 = 1.0005;
/// Rounds of slowing down; each lowers the excess to nearly nothing, so that two are usual and this many never happen.
const ROUNDS: usize = 12;

/// How far above the speed of the law V stays in each round of refinement.
const REFINE: [f64; 8] = [1.5, 1.3, 1.2, 1.1, 1.1, 1.1, 1.05, 1.05];
/// A round of refinement that gains less than this part of the time is the last one.
const WORTHWHILE: f64 = 1e-3;

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
    pub(crate) samples: Vec<Measured>,
}

/// Control cycle and the time at which a law begins.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub(crate) cycle: f64,
    pub(crate) start: f64,
}

impl Clock {
    /// Sample times within `duration` from the start, on the grid of the cycle.
    pub(crate) fn samples(self, duration: f64) -> impl Iterator<Item = f64> {
        let first = (self.start / self.cycle).ceil();
        (0_u64..).map(move |k| (first + k as f64) * self.cycle).take_while(move |t| *t < self.start + duration)
    }
}

/// Plans all cells of the path from speed `v_start`. With `finish` the whole is taken; otherwise up to a node, not
/// behind `keep` cells before the end, where what is still unknown cannot act: none when there is no such node.
pub(crate) fn plan(
    path: &mut Path,
    frame: &Frame<'_>,
    clock: Clock,
    v_start: f64,
    finish: bool,
    keep: usize,
) -> Option<Stretch> {
    let borders: Vec<f64> = std::iter::once(path.s_begin).chain(path.cells.iter().map(|c| c.s1)).collect();
    let n = path.cells.len();
    let mut round = 0;
    loop {
        let cells: Vec<Cell> = path.cells.iter().map(|c| c.limits.cell).collect();
        let plan = Plan::new(&cells, &borders, [v_start, 0.0]);
        // The part that is taken is refined by itself: what lies behind it does not act on it.
        let node = if finish { Node::end(n) } else { plan.split_before(n.saturating_sub(keep))? };
        let law =
            refined(path, frame, &borders[..=node.border], [v_start, node.speed], plan.law(&borders, node.border));
        let samples = measure(path, frame, clock, &law);
        round += 1;
        if round > ROUNDS || !calm(path, frame, &borders, &samples) {
            return Some(Stretch { law, cells: node.border, s_end: borders[node.border], v_end: node.speed, samples });
        }
    }
}

/// Plans again with V of each cell reshaped to a little above the speed that the law has there: A and J, which hold for all
/// speeds up to V, grow with it where the path curves, and the law gets quicker. Ends when a round gains nothing.
fn refined(path: &Path, frame: &Frame<'_>, borders: &[f64], ends: [f64; 2], law: Law) -> Law {
    let n = borders.len() - 1;
    let mut best = law;
    if n == 0 || path.cells[..n].iter().all(|c| c.limits.bounds.second.max_abs() == 0.0) {
        return best;
    }
    for room in REFINE {
        let peaks = best.peaks(borders);
        let cells: Vec<Cell> = (0..n).map(|k| reshaped(frame.limits, &path.cells[k].limits, peaks[k] * room)).collect();
        let next = Plan::new(&cells, borders, ends).law(borders, n);
        let worthwhile = next.duration < best.duration * (1.0 - WORTHWHILE);
        if next.duration < best.duration {
            best = next;
        }
        if !worthwhile {
            break;
        }
    }
    best
}

/// Joint states at the control samples of a law.
pub(crate) fn measure(path: &Path, frame: &Frame<'_>, clock: Clock, law: &Law) -> Vec<Measured> {
    let (mut phase, mut span) = (0, 0);
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

/// Slows down the cells of samples that pass a limit, and their neighbors; true when there were any.
fn calm(path: &mut Path, frame: &Frame<'_>, borders: &[f64], samples: &[Measured]) -> bool {
    let l = frame.limits;
    let mut any = false;
    let mut cell = 0;
    for m in samples {
        let mut ratios = [0.0_f64; 3];
        for i in 0..l.count {
            ratios[0] = ratios[0].max(m.velocity[i].abs() / l.velocity[i]);
            ratios[1] = ratios[1].max(m.acceleration[i].abs() / l.acceleration[i]);
            ratios[2] = ratios[2].max(m.jerk[i].abs() / l.jerk[i]);
        }
        if ratios.iter().all(|r| *r <= ALLOWED) {
            continue;
        }
        any = true;
        while cell + 2 < borders.len() && borders[cell + 1] < m.state.s {
            cell += 1;
        }
        let last = path.cells.len() - 1;
        for k in cell.saturating_sub(1)..=(cell + 1).min(last) {
            slow_down(&mut path.cells[k].limits, ratios);
        }
    }
    any
}
