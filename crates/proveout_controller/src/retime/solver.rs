//! Interior point method for the tempo over a grid (`problem.rs`).
//!
//! All rows but those of jerk are linear. 1/sqrt(b) on their right side is replaced by its tangent in b at the present point: 1/sqrt(b) is convex, its tangent
//! lies below it, so that the linear row allows no more than the true one, and a point that keeps all rows keeps them after every
//! full step. Every iteration solves one system of Newton's method for the conditions of Karush, Kuhn and Tucker with slacks s
//! and multipliers l, s l = m (Nocedal and Wright 2006, chapter 19), with the tangents taken anew; m falls to a tenth after a
//! long step. The start need not keep the rows.
//!
//! *Cost.* About 14 iterations up to the first look between the points and 8 after each look, of linear cost; both passes of one
//! treat the rows to either side of a limit together, and eight nodes at once (`part.rs`). *Limits.* The rows of jerk make the problem not convex: the result is a local
//! optimum, and its time is known to the gap at the end, a thousandth. That it keeps its rows is checked by the caller on the
//! result itself.

use pulp::{Simd, WithSimd};

use super::{lanes::LANES, pair::Pair, part::Part};

/// Most iterations; 8 to 14 are usual.
const ITERATIONS: usize = 60;
/// The end of the search: the gap between the time and its lower bound by duality, as part of the time.
pub(super) const GAP: f64 = 1e-3;
/// The gap at the begin.
const WIDE: f64 = 0.9;
/// Part of the gap looked for below which no step aims: rows that join later find room where the others are not at their borders.
const LEAST: f64 = 0.3;
/// Least slack of a row in a search that goes on with new rows beside it, for the same reason: with slacks as they were left, steps of
/// some percent are usual, and twice as many of them.
const ROOM: f64 = 0.04;
/// Largest remaining excess over a row, as part of its limit.
const EXCESS: f64 = 2e-5;
/// Part of the way to the border of a slack or multiplier that a step may go.
const TO_BORDER: f64 = 0.99;

/// Where a search stands.
pub(super) struct Search {
    /// Slacks and multipliers of each node's rows, those of the first node, of the second, and so on; zero where a node is new.
    kept: Vec<[f64; 4]>,
    /// Which rows of a node they are (`Part::slots`).
    slots: Vec<usize>,
    /// The gap, as part of the time.
    gap: f64,
}

impl Default for Search {
    fn default() -> Self {
        Self { kept: Vec::new(), slots: Vec::new(), gap: WIDE }
    }
}

impl Search {
    /// Makes room for nodes added to the part, each behind one of its nodes.
    pub(super) fn insert(&mut self, behind: impl Iterator<Item = usize>) {
        let each = self.slots.len();
        let mut kept = Vec::with_capacity(self.kept.len());
        let mut from = 0;
        for at in behind {
            let to = ((at + 1) * each).max(from).min(self.kept.len());
            kept.extend_from_slice(&self.kept[from..to]);
            kept.extend(std::iter::repeat_n([0.0; 4], each));
            from = to;
        }
        kept.extend_from_slice(&self.kept[from..]);
        self.kept = kept;
    }

    /// Slacks and multipliers of a node's row; none where it is new.
    fn kept(&self, node: usize, place: Option<usize>) -> Option<[f64; 4]> {
        let [s0, s1, l0, l1] = *self.kept.get(node * self.slots.len() + place?)?;
        (s0 > 0.0).then(|| [s0.max(ROOM), s1.max(ROOM), l0, l1])
    }
}

/// Vectors that live through the iterations.
pub(super) struct Work {
    /// Of each eight nodes the row of their speed, acceleration rows, jerk rows.
    pub(super) pairs: Vec<Pair>,
    /// Diagonal and the three above it.
    pub(super) matrix: Vec<[f64; 4]>,
    pub(super) right: Vec<f64>,
    /// What m is multiplied with in the right side.
    pub(super) central: Vec<f64>,
}

/// A search on the widest vectors that the processor has.
pub(super) struct Fastest<'a> {
    pub(super) part: &'a Part,
    pub(super) c: &'a mut [f64],
    /// The gap up to which is searched.
    pub(super) to: f64,
    pub(super) search: &'a mut Search,
}

impl WithSimd for Fastest<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        self.part.search(self.c, self.to, self.search)
    }
}

impl Part {
    /// Looks for the fastest tempo from `c` on, up to a gap; the given unknowns stay. `search` is a search that has not yet begun, or one
    /// that goes on. False when it does not get there.
    pub(super) fn solve(&self, c: &mut [f64], to: f64, search: &mut Search) -> bool {
        pulp::Arch::new().dispatch(Fastest { part: self, c, to, search })
    }

    #[inline(always)]
    fn search(&self, c: &mut [f64], to: f64, search: &mut Search) -> bool {
        let start = self.time(c);
        if !start.is_finite() || self.nodes == 0 || c.len() != self.unknowns {
            return false;
        }
        let total = self.rows as f64;
        let mut mu = search.gap * start / total;
        let mut work = self.begin(c, mu, search);
        let mut steps = [0.0; 2];
        for _ in 0..=ITERATIONS {
            let sums = self.assemble(c, steps, &mut work);
            let (gap, excess) = (sums.gap.sum(), sums.excess.highest());
            if !gap.is_finite() || gap > 1e3 * start || steps != [0.0; 2] && steps[0] < 1e-7 {
                return false; // rows that contradict each other
            }
            if steps != [0.0; 2] {
                if gap < to * start && excess < EXCESS {
                    self.keep(&work, search);
                    search.gap = gap / start;
                    return true;
                }
                let step = steps[0].min(steps[1]);
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
            let (within, sums) = self.steps(c, mu, &mut work);
            let full = |part: f64| if part > TO_BORDER { TO_BORDER / part } else { 1.0 };
            steps = [within.min(full(sums.primal.highest())), full(sums.dual.highest())];
            for (c, d) in c.iter_mut().zip(&work.right) {
                *c += steps[0] * d;
            }
        }
        false
    }

    fn begin(&self, c: &[f64], mu: f64, search: &Search) -> Work {
        let slots = self.slots();
        let places: Vec<Option<usize>> = slots.iter().map(|slot| search.slots.iter().position(|s| s == slot)).collect();
        let each = slots.len();
        let mut pairs = Vec::with_capacity(self.groups.len() * each);
        for at in 0..self.groups.len() {
            for (row, place) in places.iter().enumerate() {
                let values = self.values(at, row, c);
                pairs.push(Pair::begun(values, mu, |lane| search.kept(at * LANES + lane, *place)));
            }
        }
        let n = self.unknowns;
        Work { pairs, matrix: vec![[0.0; 4]; n], right: vec![0.0; n], central: vec![0.0; n] }
    }

    /// Keeps slacks and multipliers for a search that goes on.
    fn keep(&self, work: &Work, search: &mut Search) {
        search.slots = self.slots();
        let each = search.slots.len();
        search.kept.clear();
        search.kept.reserve(self.nodes * each);
        for node in 0..self.nodes {
            let pairs = &work.pairs[node / LANES * each..][..each];
            search.kept.extend(pairs.iter().map(|pair| pair.of_lane(node % LANES)));
        }
    }
}

/// Cholesky's way without roots (L D L'), in place; the solution replaces the right side. False where the matrix is not
/// positive definite.
#[inline(always)]
fn factor_and_solve(m: &mut [[f64; 4]], x: &mut [f64]) -> bool {
    let n = m.len();
    for i in 0..n {
        let row = m[i];
        let d = row[0];
        if !(d > 0.0 && d.is_finite()) {
            return false;
        }
        let below = (n - 1 - i).min(3);
        for k in 1..=below {
            let l = row[k] / d;
            for j in k..=below {
                m[i + k][j - k] -= l * row[j];
            }
            x[i + k] -= l * x[i];
            m[i][k] = l;
        }
    }
    for i in (0..n).rev() {
        let below = (n - 1 - i).min(3);
        let mut v = x[i] / m[i][0];
        for k in 1..=below {
            v -= m[i][k] * x[i + k];
        }
        x[i] = v;
    }
    true
}
