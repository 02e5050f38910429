//! Interior point method for the tempo over a grid (`problem.rs`).
//!
//! All rows but those of jerk are linear. 1/sqrt(b) on their right side is replaced by its tangent in b at the present point: 1/sqrt(b) is convex, its tangent
//! lies below it, so that the linear row allows no more than the true one, and a point that keeps all rows keeps them after every
//! full step. Every iteration solves one system of Newton's method for the conditions of Karush, Kuhn and Tucker with slacks s
//! and multipliers l, s l = m (Nocedal and Wright 2006, chapter 19), with the tangents taken anew; m falls by a tenth after a
//! long step. The start need not keep the rows.
//!
//! *Cost.* About 14 iterations up to the first look between the points and 8 after each look, of linear cost; both passes of one
//! treat the rows to either side of a limit together. *Limits.* The rows of jerk make the problem not convex: the result is a local
//! optimum, and its time is known to the gap at the end, a thousandth. That it keeps its rows is checked by the caller on the
//! result itself.

use super::{
    pair::{Pair, Sums, acceleration, higher, jerk},
    problem::{Problem, RELAXED, Rows},
};

/// Most iterations; 8 to 14 are usual.
const ITERATIONS: usize = 60;
/// The end of the search: the gap between the time and its lower bound by duality, as part of the time.
pub(super) const GAP: f64 = 1e-3;
/// The gap at the begin.
const WIDE: f64 = 0.3;
/// Largest remaining excess over a row, as part of its limit.
const EXCESS: f64 = 2e-5;
/// Part of the way to the border of a slack or multiplier that a step may go.
const TO_BORDER: f64 = 0.95;

/// A node of a part.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// First of its four unknowns.
    first: usize,
    basis: [[f64; 4]; 3],
    weight: f64,
    speed: f64,
    lead: f64,
}

impl Place {
    #[inline]
    fn state(&self, c: &[f64]) -> [f64; 3] {
        let c = &c[self.first..self.first + 4];
        self.basis.map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2] + row[3] * c[3])
    }
}

/// Some intervals with the rows that count there.
pub(super) struct Part {
    fixed: [bool; 2],
    unknowns: usize,
    nodes: Vec<Place>,
    /// Those of the first node, of the second, and so on.
    acceleration: Vec<[f64; 2]>,
    jerk: Vec<[f64; 3]>,
    /// Joints with either.
    counts: [usize; 2],
}

/// Where a search stands.
pub(super) struct Search {
    pairs: Vec<Pair>,
    /// The gap, as part of the time.
    gap: f64,
}

impl Default for Search {
    fn default() -> Self {
        Self { pairs: Vec::new(), gap: WIDE }
    }
}

impl Search {
    /// Makes room for nodes added to the part, each behind one of its nodes; there are `count` of them before.
    pub(super) fn insert(&mut self, count: usize, behind: impl Iterator<Item = usize>) {
        let each = self.pairs.len() / count.max(1);
        let mut pairs = Vec::with_capacity(self.pairs.len());
        let mut from = 0;
        for at in behind {
            let to = ((at + 1) * each).max(from);
            pairs.extend_from_slice(&self.pairs[from..to]);
            pairs.extend(std::iter::repeat_n(Pair::NEW, each));
            from = to;
        }
        pairs.extend_from_slice(&self.pairs[from..]);
        self.pairs = pairs;
    }
}

/// Vectors that live through the iterations.
struct Work {
    /// Of each node the row of its speed, acceleration rows, jerk rows.
    pairs: Vec<Pair>,
    /// Diagonal and the three above it.
    matrix: Vec<[f64; 4]>,
    right: Vec<f64>,
    /// What m is multiplied with in the right side.
    central: Vec<f64>,
}

impl Part {
    /// The intervals from `from` up to `to` alone, with some of the rows; the unknowns at inner ends are given.
    pub(super) fn new(problem: &Problem, [from, to]: [usize; 2], rows: &Rows) -> Self {
        let last = problem.lengths.len();
        let fixed = [from > 0 || problem.fixed[0], to < last || problem.fixed[1]];
        let range = problem.nodes.partition_point(|n| n.k < from)..problem.nodes.partition_point(|n| n.k < to);
        let chosen = |flags: &[bool]| -> Vec<usize> { (0..problem.count).filter(|i| flags[*i]).collect() };
        let (with_a, with_j) = (chosen(&rows.acceleration), chosen(&rows.jerk));
        let mut part = Self {
            fixed,
            unknowns: 2 * (to - from) + 2,
            nodes: Vec::with_capacity(range.len()),
            acceleration: Vec::with_capacity(range.len() * with_a.len()),
            jerk: Vec::with_capacity(range.len() * with_j.len()),
            counts: [with_a.len(), with_j.len()],
        };
        for at in range {
            let node = &problem.nodes[at];
            let near = [fixed[0] && node.k == from, fixed[1] && node.k + 1 == to];
            // What was found with an excess within the tolerance must stay possible, and what both given unknowns decide
            // is no longer a question.
            let given = near[0] && node.tau < 0.01 || near[1] && node.tau > 0.99;
            let factor = if near[0] || near[1] { 1.0 - RELAXED } else { 1.0 };
            let own = &problem.joints[at * problem.count..(at + 1) * problem.count];
            let decided = if given { 0.0 } else { factor };
            part.acceleration.extend(with_a.iter().map(|i| [own[*i][0] * decided, own[*i][1] * decided]));
            part.jerk.extend(with_j.iter().map(|i| [own[*i][2], own[*i][3], own[*i][4]].map(|r| r * factor)));
            let speed = if near[0] && node.lead > 0.0 || near[1] && node.lead < 0.0 { 0.0 } else { node.speed };
            part.nodes.push(Place {
                first: 2 * (node.k - from),
                basis: node.basis,
                weight: node.weight,
                speed,
                lead: node.lead,
            });
        }
        part
    }

    /// Sum of w / sqrt(b); infinite where b is not above zero.
    fn time(&self, c: &[f64]) -> f64 {
        self.nodes
            .iter()
            .map(|n| {
                let b = n.state(c)[0];
                if b > 0.0 { n.weight / b.sqrt() } else { f64::INFINITY }
            })
            .sum()
    }

    /// Looks for the fastest tempo from `c` on, up to a gap; the given unknowns stay. `search` is a search that has not yet begun, or one
    /// that goes on. False when it does not get there.
    pub(super) fn solve(&self, c: &mut [f64], to: f64, search: &mut Search) -> bool {
        let start = self.time(c);
        if !start.is_finite() || self.nodes.is_empty() || c.len() != self.unknowns {
            return false;
        }
        let speeds = self.nodes.iter().filter(|n| n.speed > 0.0).count();
        let total = (2 * (self.acceleration.len() + self.jerk.len()) + speeds).max(1) as f64;
        let mut mu = search.gap * start / total;
        let mut work = self.begin(c, mu, search);
        let mut steps = [0.0; 2];
        for _ in 0..=ITERATIONS {
            let sums = self.assemble(c, steps, &mut work);
            if !sums.gap.is_finite() || sums.gap > 1e3 * start || steps != [0.0; 2] && steps[0] < 1e-7 {
                return false; // rows that contradict each other
            }
            if steps != [0.0; 2] {
                if sums.gap < to * start && sums.excess < EXCESS {
                    *search = Search { pairs: work.pairs, gap: sums.gap / start };
                    return true;
                }
                let step = steps[0].min(steps[1]);
                let factor = if step > 0.9 {
                    0.1
                } else if step > 0.5 {
                    0.3
                } else {
                    0.7
                };
                mu = (sums.gap / total * factor).max(0.02 * to * start / total);
            }
            for (right, central) in work.right.iter_mut().zip(&work.central) {
                *right += mu * central;
            }
            if !factor_and_solve(&mut work.matrix, &mut work.right) {
                return false;
            }
            steps = self.steps(c, mu, &mut work);
            for (c, d) in c.iter_mut().zip(&work.right) {
                *c += steps[0] * d;
            }
        }
        false
    }

    fn begin(&self, c: &[f64], mu: f64, search: &mut Search) -> Work {
        let [with_a, with_j] = self.counts;
        let mut pairs = std::mem::take(&mut search.pairs);
        pairs.resize(self.nodes.len() * (1 + with_a + with_j), Pair::NEW);
        let mut all = pairs.iter_mut();
        for (at, node) in self.nodes.iter().enumerate() {
            let x = node.state(c);
            let slow = 1.0 / x[0].sqrt();
            let speed = std::iter::once([node.speed_value(x), -1.0]);
            let a = self.acceleration[at * with_a..][..with_a].iter().map(|q| acceleration(q, x));
            let j = self.jerk[at * with_j..][..with_j].iter().map(|q| jerk(q, x, slow));
            for (values, pair) in speed.chain(a).chain(j).zip(&mut all) {
                if pair.slack[0] <= 0.0 {
                    *pair = Pair::new(values, mu);
                } else {
                    pair.rest_here();
                }
            }
        }
        let n = self.unknowns;
        Work { pairs, matrix: vec![[0.0; 4]; n], right: vec![0.0; n], central: vec![0.0; n] }
    }

    /// Goes along the step before, and takes matrix and right sides of the next one.
    fn assemble(&self, c: &[f64], steps: [f64; 2], work: &mut Work) -> Sums {
        let [with_a, with_j] = self.counts;
        work.matrix.fill([0.0; 4]);
        work.right.fill(0.0);
        work.central.fill(0.0);
        let mut sums = Sums::default();
        let mut pairs = work.pairs.iter_mut();
        for (at, node) in self.nodes.iter().enumerate() {
            let x = node.state(c);
            let slow = 1.0 / x[0].sqrt();
            let tangent = 0.5 * slow / x[0];
            let (mut g, mut central) = ([-node.weight * tangent, 0.0, 0.0], [0.0; 3]);
            // Upper triangle: 00 01 02 11 12 22.
            let mut m = [1.5 * node.weight * tangent / x[0], 0.0, 0.0, 0.0, 0.0, 0.0];
            if let Some(pair) = pairs.next()
                && node.speed > 0.0
            {
                pair.forward(node.speed_value(x), steps, &mut sums);
                let (q, a) = (pair.multiplier[0] * pair.over[0], [node.speed, node.speed * node.lead]);
                let f = q * (node.speed_value(x) + pair.slack[0]);
                for i in 0..2 {
                    g[i] += a[i] * f;
                    central[i] += a[i] * pair.over[0];
                }
                m[0] += q * a[0] * a[0];
                m[1] += q * a[0] * a[1];
                m[3] += q * a[1] * a[1];
            }
            for (q, pair) in self.acceleration[at * with_a..][..with_a].iter().zip(&mut pairs) {
                let f = pair.advance(acceleration(q, x), steps, &mut sums);
                let a = [q[1], q[0]];
                for i in 0..2 {
                    g[i] += a[i] * f.rest[0];
                    central[i] += a[i] * f.central[0];
                }
                m[0] += f.sum * a[0] * a[0];
                m[1] += f.sum * a[0] * a[1];
                m[3] += f.sum * a[1] * a[1];
            }
            for (q, pair) in self.jerk[at * with_j..][..with_j].iter().zip(&mut pairs) {
                let f = pair.advance(jerk(q, x, slow), steps, &mut sums);
                // Gradients: the tangent in both, +-(q2, q1, q0).
                let a = [q[2], q[1], q[0]];
                for i in 0..3 {
                    g[i] += a[i] * f.rest[0];
                    central[i] += a[i] * f.central[0];
                }
                g[0] += tangent * f.rest[1];
                central[0] += tangent * f.central[1];
                let mixed = f.sum * a[0] + f.difference * tangent;
                m[0] += mixed * a[0] + (f.sum * tangent + f.difference * a[0]) * tangent;
                m[1] += mixed * a[1];
                m[2] += mixed * a[2];
                m[3] += f.sum * a[1] * a[1];
                m[4] += f.sum * a[1] * a[2];
                m[5] += f.sum * a[2] * a[2];
            }
            let e = &node.basis;
            let full = [[m[0], m[1], m[2]], [m[1], m[3], m[4]], [m[2], m[4], m[5]]];
            for i in 0..4 {
                let ei = [e[0][i], e[1][i], e[2][i]];
                let row = node.first + i;
                work.right[row] -= ei[0] * g[0] + ei[1] * g[1] + ei[2] * g[2];
                work.central[row] -= ei[0] * central[0] + ei[1] * central[1] + ei[2] * central[2];
                let left: [f64; 3] =
                    std::array::from_fn(|c| ei[0] * full[0][c] + ei[1] * full[1][c] + ei[2] * full[2][c]);
                for j in i..4 {
                    work.matrix[row][j - i] += left[0] * e[0][j] + left[1] * e[1][j] + left[2] * e[2][j];
                }
            }
        }
        self.give(work);
        sums
    }

    /// Takes the given unknowns out of the system.
    fn give(&self, work: &mut Work) {
        let n = self.unknowns;
        let mut given = Vec::new();
        if self.fixed[0] {
            given.extend([0, 1]);
        }
        if self.fixed[1] {
            given.extend([n - 2, n - 1]);
        }
        for i in given {
            for back in 1..=i.min(3) {
                work.matrix[i - back][back] = 0.0;
            }
            work.matrix[i] = [1.0, 0.0, 0.0, 0.0];
            (work.right[i], work.central[i]) = (0.0, 0.0);
        }
    }

    /// Steps of slacks and multipliers, and how far both may go.
    fn steps(&self, c: &[f64], mu: f64, work: &mut Work) -> [f64; 2] {
        let [with_a, with_j] = self.counts;
        let mut sums = Sums::default();
        let mut primal = 1.0_f64;
        let mut pairs = work.pairs.iter_mut();
        for (at, node) in self.nodes.iter().enumerate() {
            let (x, d) = (node.state(c), node.state(&work.right));
            if d[0] < 0.0 {
                primal = primal.min(-0.6 * x[0] / d[0]);
            }
            let slow = 1.0 / x[0].sqrt();
            let tangent = 0.5 * slow / x[0] * d[0];
            if let Some(pair) = pairs.next()
                && node.speed > 0.0
            {
                // The other half of the pair has no row.
                let change = node.speed * (d[0] + node.lead * d[1]);
                let (s, l, over) = (pair.slack[0], pair.multiplier[0], pair.over[0]);
                let ds = -(node.speed_value(x) + s) - change;
                let dl = (mu - l * ds) * over - l;
                sums.primal = higher(sums.primal, -ds * over);
                sums.shorten_dual(dl, l);
                (pair.slack_step[0], pair.multiplier_step[0]) = (ds, dl);
            }
            for (q, pair) in self.acceleration[at * with_a..][..with_a].iter().zip(&mut pairs) {
                let change = q[0] * d[1] + q[1] * d[0];
                pair.step(acceleration(q, x), [change, -change], mu, &mut sums);
            }
            for (q, pair) in self.jerk[at * with_j..][..with_j].iter().zip(&mut pairs) {
                let change = q[0] * d[2] + q[1] * d[1] + q[2] * d[0];
                pair.step(jerk(q, x, slow), [tangent + change, tangent - change], mu, &mut sums);
            }
        }
        let full = |part: f64| if part > TO_BORDER { TO_BORDER / part } else { 1.0 };
        [primal.min(full(sums.primal)), full(sums.dual)]
    }
}

impl Place {
    #[inline]
    fn speed_value(&self, [b, b1, _]: [f64; 3]) -> f64 {
        (b + self.lead * b1) * self.speed - 1.0
    }
}

/// Cholesky's way without roots (L D L'), in place; the solution replaces the right side. False where the matrix is not
/// positive definite.
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
