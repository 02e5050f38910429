//! Interior point method for the tempo over a grid (`problem.rs`).
//!
//! All rows but those of jerk are linear. 1/sqrt(b) on their right side is replaced by its tangent
//! in b at the present point: 1/sqrt(b) is convex and its tangent lies below it, so the linear row
//! allows no more than the true one, and a point that keeps all rows keeps them after every full
//! step. Every iteration solves one system of Newton's method for the conditions of Karush, Kuhn
//! and Tucker with slacks s and multipliers l, s l = m (Nocedal and Wright 2006, chapter 19), with
//! new tangents; m falls to a tenth after a long step. The start need not keep the rows.
//!
//! *Cost.* About 12 iterations up to the first check between the points, 9 to 10 after it and 4 to
//! 8 around each place that needs a point later (`stages.rs`), each of linear cost; both passes of
//! an iteration treat eight intervals at once (`part.rs`).
//!
//! *Limits.* The rows of jerk make the problem nonconvex: the result is a local optimum, and the
//! gap at the end, a thousandth, is that of the problem with the last tangents. From other starts
//! and with other objectives (the sum of ln b, of b, of sqrt b instead of the time) the same law
//! was found on 20 curves (`tests/against_copp.rs`). The caller checks on the result itself that it
//! keeps its rows.

use pulp::{Simd, WithSimd};

use super::{
    band::factor_and_solve,
    lanes::Lanes,
    part::{LaneNodes, LaneRows, Names},
    problem::Problem,
    side::{RowSlacks, SolverStep, TO_BORDER},
};

/// Most iterations; 8 to 14 are usual.
const ITERATIONS: usize = 60;
/// The end of the search: the gap between the time and its lower bound by duality, as part of the time.
pub(super) const GAP: f64 = 1e-3;
/// The gap at the begin.
const WIDE: f64 = 0.9;
/// Part of the gap looked for below which no step aims: rows that join later find room where the others are
/// not at their borders.
const LEAST: f64 = 0.3;
/// Least slack of a row in a search that goes on with new rows added, for the same reason: with the
/// slacks left as they were, steps of some percent are usual, and twice as many of them.
const ROOM: f64 = 0.04;
/// Largest remaining excess over a row, as part of its limit.
const EXCESS: f64 = 2e-5;
/// Gap over the time at the start above which rows contradict each other.
const DIVERGED: f64 = 1e3;
/// Step, part of the full one, below which rows contradict each other.
const STUCK: f64 = 1e-7;

/// Vectors that live through the iterations.
#[derive(Default)]
pub(super) struct SolverVectors {
    /// Rows of one side and of both, of the first slot, of the second, and so on.
    pub(super) single: Vec<RowSlacks>,
    pub(super) pairs: Vec<[RowSlacks; 2]>,
    /// b, b', b'' and 1/sqrt(b) of each slot.
    pub(super) states: Vec<[Lanes; 4]>,
    /// Diagonal and the three above it.
    pub(super) matrix: Vec<[f64; 4]>,
    pub(super) right: Vec<f64>,
    /// What m is multiplied with in the right side.
    pub(super) central: Vec<f64>,
}

/// A search that can go on: its rows, their slacks and multipliers, and the mean product of both.
#[derive(Default)]
pub(super) struct TempoSolver {
    part: LaneRows,
    work: SolverVectors,
    mean: f64,
}

/// A node that was not there in the search before.
pub(super) const NEW: usize = usize::MAX;

/// What a search goes on from: another one, and the nodes there of those here.
pub(super) struct Before<'a> {
    pub(super) search: &'a TempoSolver,
    pub(super) nodes: &'a [usize],
}

impl Before<'_> {
    /// Slot and lane of a node there.
    pub(super) fn slot(&self, node: usize) -> Option<(&LaneNodes, usize)> {
        self.search.part.place(*self.nodes.get(node)?)
    }

    /// Slack and multiplier of the row of speed.
    pub(super) fn single(&self, (slot, lane): (&LaneNodes, usize)) -> Option<[f64; 2]> {
        let side = self.search.work.single.get(slot.single()?)?;
        Some(roomy(side.of_lane(lane)))
    }

    /// Those of both sides of another row.
    pub(super) fn pair(&self, (slot, lane): (&LaneNodes, usize), name: usize) -> Option<[[f64; 2]; 2]> {
        let both = self.search.work.pairs.get(slot.pair(name)?)?;
        Some([0, 1].map(|side: usize| roomy(both[side].of_lane(lane))))
    }
}

/// With some room at the limit.
fn roomy([slack, multiplier]: [f64; 2]) -> [f64; 2] {
    [slack.max(ROOM), multiplier]
}

/// A search on the widest vectors that the processor has.
struct VectorSearch<'a> {
    part: &'a LaneRows,
    work: &'a mut SolverVectors,
    c: &'a mut [f64],
    mean: &'a mut f64,
    /// The gap up to which is searched.
    to: f64,
}

impl WithSimd for VectorSearch<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        self.part.search(self.c, self.to, self.work, self.mean)
    }
}

impl TempoSolver {
    /// Looks for the fastest tempo from `c` on, up to a gap, under the rows named node by node; the
    /// given unknowns stay. It resumes from the state of an earlier search, or starts over. Returns
    /// false if it does not get there.
    pub(super) fn run(
        &mut self,
        problem: &Problem,
        rows: &[Names],
        c: &mut [f64],
        to: f64,
        before: Option<&Before<'_>>,
    ) -> bool {
        self.part.fill(problem, rows);
        let start = self.part.time(c);
        if !start.is_finite() || self.part.nodes == 0 || c.len() != self.part.unknowns {
            return false;
        }
        self.mean = before.map_or(WIDE * start / self.part.rows() as f64, |b| b.search.mean);
        let (mean, work) = (self.mean, &mut self.work);
        self.part.begin(c, mean, before, work);
        let n = self.part.unknowns;
        work.matrix.resize(n, [0.0; 4]);
        work.right.resize(n, 0.0);
        work.central.resize(n, 0.0);
        pulp::Arch::new().dispatch(VectorSearch { part: &self.part, work, c, mean: &mut self.mean, to })
    }
}

impl LaneRows {
    #[inline(always)]
    fn search(&self, c: &mut [f64], to: f64, work: &mut SolverVectors, mean: &mut f64) -> bool {
        let start = self.time(c);
        let total = self.rows() as f64;
        let mut mu = *mean;
        // Nothing before the first step.
        let mut going: Option<SolverStep> = None;
        for _ in 0..=ITERATIONS {
            let sums = self.assemble(c, going.unwrap_or_default(), work);
            let (gap, excess) = (sums.gap.sum(), sums.excess.highest());
            if !gap.is_finite() || gap > DIVERGED * start || going.is_some_and(|going| going.primal < STUCK) {
                return false; // rows that contradict each other
            }
            if let Some(SolverStep { primal, dual, .. }) = going {
                if gap < to * start && excess < EXCESS {
                    *mean = gap / total;
                    return true;
                }
                let step = primal.min(dual);
                let factor = if step > 0.9 {
                    0.1
                } else if step > 0.5 {
                    0.3
                } else {
                    0.9
                };
                mu = (gap / total * factor).max(LEAST * to * start / total);
            }
            for (right, central) in work.right.iter_mut().zip(&work.central) {
                *right += mu * central;
            }
            if !factor_and_solve(&mut work.matrix, &mut work.right) {
                return false;
            }
            let (within, sums) = self.steps(mu, work);
            let full = |part: f64| if part > TO_BORDER { TO_BORDER / part } else { 1.0 };
            let primal = within.min(full(sums.primal.highest()));
            going = Some(SolverStep { primal, dual: full(sums.dual.highest()), aim: mu });
            for (c, d) in c.iter_mut().zip(&work.right) {
                *c += primal * d;
            }
        }
        false
    }
}
