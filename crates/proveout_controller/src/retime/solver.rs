//! Interior point method for the tempo over a grid.
//!
//! *Unknowns.* b is a cubic with continuous slope over intervals of length `h_k`, given by its values and slopes at their borders
//! (Hermite): `x = (b_0, b'_0 H, b_1, b'_1 H, ..)` with the mean length H, so that interval k takes the four unknowns from 2 k on
//! and all matrices have seven diagonals. Within an interval b'' is linear and free to jump at the borders: where b is a
//! quadratic there, the jerk cannot stay at its limit while the speed changes, which costs 3 percent of the time at corners.
//!
//! *Problem.* Minimize the sum of w / sqrt(b) over points under the rows of each point and joint
//!
//! ```text
//!   u c <= 1          |a1 b' + a0 b| <= 1          |j2 b'' + j1 b' + j0 b| <= 1/sqrt(b)
//! ```
//!
//! where c are the two inner control points of b in Bezier form: b lies in their hull, so that no speed is passed between the
//! points. All but the last are linear. The last is replaced by its tangent in b at the present point: 1/sqrt(b) is convex, its tangent
//! lies below it, so that the linear row allows no more than the true one, and a point that keeps all rows keeps them after every
//! full step. Every iteration solves one system of Newton's method for the conditions of Karush, Kuhn and Tucker with slacks s
//! and multipliers l, s l = m (Nocedal and Wright 2006, chapter 19), with the tangents taken anew; m falls by a tenth after a
//! long step. The start need not keep the rows.
//!
//! *Cost.* About 20 iterations of linear cost. *Limits.* The rows of jerk make the problem not convex: the result is a local
//! optimum. That it keeps its rows is checked by the caller on the result itself.

/// Five coefficients a joint and point, over the limits: a1, a0 of acceleration; j2, j1, j0 of jerk.
pub(super) type JointRow = [f64; 5];

/// A place where limits are kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Interval, and part of it.
    pub(super) k: usize,
    pub(super) tau: f64,
    /// b, b', b'' by the four unknowns of the interval.
    pub(super) basis: [[f64; 4]; 3],
    /// Part of the time that this point stands for.
    pub(super) weight: f64,
    /// One over the highest b that velocities and feed allow, for b + lead b'.
    pub(super) speed: f64,
    /// Way from the node to the control point of b that must keep to it; that of the begin lies a third of the interval
    /// ahead, that of the end a third behind.
    pub(super) lead: f64,
}

/// Grid and rows.
#[derive(Debug, Default)]
pub(super) struct Problem {
    /// What the unknown slopes are multiplied with.
    pub(super) scale: f64,
    /// Lengths of the intervals.
    pub(super) lengths: Vec<f64>,
    pub(super) nodes: Vec<Node>,
    /// Joints of the first node, of the second, and so on.
    pub(super) joints: Vec<JointRow>,
    /// Number of joints with rows.
    pub(super) count: usize,
    /// b and its slope, the first (last) two unknowns, are given.
    pub(super) fixed: [bool; 2],
}

/// Most iterations; 20 are usual.
const ITERATIONS: usize = 60;
/// The end of the search: the gap between the time and its lower bound by duality, as part of the time.
const GAP: f64 = 1e-3;
/// Largest remaining excess over a row, as part of its limit.
const EXCESS: f64 = 2e-5;
/// Part of the way to the border of a slack or multiplier that a step may go.
const TO_BORDER: f64 = 0.95;
/// What rows next to given unknowns may pass their limits, so that these have an inside.
const RELAXED: f64 = 2e-4 + MARGIN;
/// Part by which rows of acceleration and jerk are tighter than the limits: between the points of the grid and between
/// samples a law may pass its rows by so much. It costs a thousandth of the time.
pub(super) const MARGIN: f64 = 0.003;

impl Problem {
    /// Basis of b, b', b'' in interval `k` at part `tau` of it.
    pub(super) fn basis(&self, k: usize, tau: f64) -> [[f64; 4]; 3] {
        let h = self.lengths[k];
        let (t, r, w) = (tau, 1.0 - tau, h / self.scale);
        let value = [r * r * (1.0 + 2.0 * t), w * t * r * r, t * t * (3.0 - 2.0 * t), -w * t * t * r];
        let slope = [-6.0 * t * r, w * r * (r - 2.0 * t), 6.0 * t * r, w * t * (t - 2.0 * r)];
        let bend = [12.0 * t - 6.0, w * (6.0 * t - 4.0), 6.0 - 12.0 * t, w * (6.0 * t - 2.0)];
        [value, slope.map(|x| x / h), bend.map(|x| x / (h * h))]
    }

    /// The unknowns of the law's own tempo.
    pub(super) fn even(&self) -> Vec<f64> {
        (0..2 * (self.lengths.len() + 1)).map(|i| if i % 2 == 0 { 1.0 } else { 0.0 }).collect()
    }

    /// b as polynomial of the time since the begin of interval `k`.
    pub(super) fn polynomial(&self, c: &[f64], k: usize) -> [f64; 4] {
        let (h, scale) = (self.lengths[k], self.scale);
        let (b0, d0, b1, d1) = (c[2 * k], c[2 * k + 1] / scale, c[2 * k + 2], c[2 * k + 3] / scale);
        let rise = (b1 - b0) / h;
        [b0, d0, (3.0 * rise - 2.0 * d0 - d1) / h, (d0 + d1 - 2.0 * rise) / (h * h)]
    }

    /// Sets the first two unknowns so that b and its slope begin with these values.
    pub(super) fn set_start(&self, c: &mut [f64], [b, slope]: [f64; 2]) {
        c[0] = b;
        c[1] = slope * self.scale;
    }

    fn state(&self, node: &Node, c: &[f64]) -> [f64; 3] {
        let c = &c[2 * node.k..2 * node.k + 4];
        node.basis.map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2] + row[3] * c[3])
    }

    /// Sum of w / sqrt(b); infinite where b is not above zero.
    pub(super) fn time(&self, c: &[f64]) -> f64 {
        self.nodes
            .iter()
            .map(|n| {
                let b = self.state(n, c)[0];
                if b > 0.0 { n.weight / b.sqrt() } else { f64::INFINITY }
            })
            .sum()
    }

    /// Highest part of the limits at a node: below one where all rows hold.
    pub(super) fn used(&self, at: usize, c: &[f64]) -> f64 {
        let node = &self.nodes[at];
        let [b, b1, b2] = self.state(node, c);
        let root = b.max(0.0).sqrt();
        let mut worst = ((b + node.lead * b1) * node.speed).max(0.0).sqrt();
        for q in &self.joints[at * self.count..(at + 1) * self.count] {
            let a = q[0] * b1 + q[1] * b;
            let j = (q[2] * b2 + q[3] * b1 + q[4] * b) * root;
            worst = worst.max(a.abs()).max(j.abs());
        }
        worst
    }

    /// The problem of the intervals from `from` up to `to` alone; the unknowns at its inner ends are given.
    pub(super) fn part(&self, from: usize, to: usize) -> Self {
        let last = self.lengths.len();
        let fixed = [from > 0 || self.fixed[0], to < last || self.fixed[1]];
        let nodes = self.nodes.partition_point(|n| n.k < from)..self.nodes.partition_point(|n| n.k < to);
        let mut part = Self {
            scale: self.scale,
            lengths: self.lengths[from..to].to_vec(),
            nodes: self.nodes[nodes.clone()].to_vec(),
            joints: self.joints[nodes.start * self.count..nodes.end * self.count].to_vec(),
            count: self.count,
            fixed,
        };
        for (at, node) in part.nodes.iter_mut().enumerate() {
            node.k -= from;
            let near = [fixed[0] && node.k == 0, fixed[1] && node.k + 1 == to - from];
            // What was found with an excess within the tolerance must stay possible, and what both given unknowns decide
            // is no longer a question.
            let given = near[0] && node.tau < 0.01 || near[1] && node.tau > 0.99;
            if near[0] || near[1] {
                for row in &mut part.joints[at * self.count..(at + 1) * self.count] {
                    row.iter_mut().for_each(|r| *r *= 1.0 - RELAXED);
                    if given {
                        (row[0], row[1]) = (0.0, 0.0);
                    }
                }
            }
            if near[0] && node.lead > 0.0 || near[1] && node.lead < 0.0 {
                node.speed = 0.0;
            }
        }
        part
    }

    /// Divides the limits in an interval by a factor.
    pub(super) fn tighten(&mut self, k: usize, factor: f64) {
        let nodes = self.nodes.partition_point(|n| n.k < k)..self.nodes.partition_point(|n| n.k <= k);
        for node in &mut self.nodes[nodes.clone()] {
            node.speed *= factor;
        }
        for row in &mut self.joints[nodes.start * self.count..nodes.end * self.count] {
            row.iter_mut().for_each(|r| *r *= factor);
        }
    }

    /// Looks for the fastest tempo from `c` on; the given unknowns stay. False when it does not get there.
    pub(super) fn solve(&self, c: &mut [f64]) -> bool {
        let rows = 1 + 4 * self.count;
        let total = rows * self.nodes.len();
        let start = self.time(c);
        if !start.is_finite() || self.nodes.is_empty() {
            return false;
        }
        let mut mu = 0.3 * start / total as f64;
        let mut work = Work {
            slack: vec![0.0; total],
            multiplier: vec![0.0; total],
            slack_step: vec![0.0; total],
            multiplier_step: vec![0.0; total],
            matrix: vec![[0.0; 4]; c.len()],
            right: vec![0.0; c.len()],
        };
        for (at, node) in self.nodes.iter().enumerate() {
            let x = self.state(node, c);
            self.each_row(at, node, x, |r, value, _| {
                let s = (-value).max(0.02);
                work.slack[at * rows + r] = s;
                work.multiplier[at * rows + r] = mu / s;
            });
        }
        for _ in 0..ITERATIONS {
            self.assemble(c, mu, &mut work);
            if !factor_and_solve(&mut work.matrix, &mut work.right) {
                return false;
            }
            let [primal, dual] = self.step_lengths(c, mu, &mut work);
            for (c, d) in c.iter_mut().zip(&work.right) {
                *c += primal * d;
            }
            let (mut gap, mut excess) = (0.0, 0.0_f64);
            for (at, node) in self.nodes.iter().enumerate() {
                let x = self.state(node, c);
                self.each_row(at, node, x, |r, value, _| {
                    let i = at * rows + r;
                    let s = work.slack[i] + primal * work.slack_step[i];
                    work.multiplier[i] += dual * work.multiplier_step[i];
                    excess = excess.max(value + s);
                    work.slack[i] = s.max(-value);
                    gap += work.slack[i] * work.multiplier[i];
                });
            }
            if !gap.is_finite() || gap > 1e3 * start || primal < 1e-7 {
                return false; // rows that contradict each other
            }
            if gap < GAP * start && excess < EXCESS {
                return true;
            }
            let step = primal.min(dual);
            let factor = if step > 0.9 {
                0.1
            } else if step > 0.5 {
                0.3
            } else {
                0.7
            };
            mu = (gap / total as f64 * factor).max(0.02 * GAP * start / total as f64);
        }
        false
    }

    /// Calls back with number, value (row minus limit) and gradient by b, b', b'' of every row of a node.
    #[inline]
    fn each_row(&self, at: usize, node: &Node, [b, b1, b2]: [f64; 3], mut each: impl FnMut(usize, f64, [f64; 3])) {
        let slow = 1.0 / b.sqrt();
        let tangent = 0.5 * slow / b;
        each(0, (b + node.lead * b1) * node.speed - 1.0, [node.speed, node.speed * node.lead, 0.0]);
        for (i, q) in self.joints[at * self.count..(at + 1) * self.count].iter().enumerate() {
            let a = q[0] * b1 + q[1] * b;
            let j = q[2] * b2 + q[3] * b1 + q[4] * b;
            let r = 1 + 4 * i;
            each(r, a - 1.0, [q[1], q[0], 0.0]);
            each(r + 1, -a - 1.0, [-q[1], -q[0], 0.0]);
            each(r + 2, j - slow, [q[4] + tangent, q[3], q[2]]);
            each(r + 3, -j - slow, [tangent - q[4], -q[3], -q[2]]);
        }
    }

    /// Matrix and right side of the step.
    fn assemble(&self, c: &[f64], mu: f64, work: &mut Work) {
        let rows = 1 + 4 * self.count;
        let n = c.len();
        work.matrix.fill([0.0; 4]);
        work.right.fill(0.0);
        for (at, node) in self.nodes.iter().enumerate() {
            let x = self.state(node, c);
            let slow = 1.0 / x[0].sqrt();
            let tangent = 0.5 * node.weight * slow / x[0];
            let mut g = [-tangent, 0.0, 0.0];
            // Upper triangle: 00 01 02 11 12 22.
            let mut m = [1.5 * tangent / x[0], 0.0, 0.0, 0.0, 0.0, 0.0];
            let (slack, multiplier) = (&work.slack[at * rows..][..rows], &work.multiplier[at * rows..][..rows]);
            self.each_row(at, node, x, |r, value, a| {
                let (s, l) = (slack[r], multiplier[r]);
                let over = 1.0 / s;
                let f = (mu + l * (value + s)) * over;
                let q = l * over;
                for i in 0..3 {
                    g[i] += a[i] * f;
                }
                m[0] += q * a[0] * a[0];
                m[1] += q * a[0] * a[1];
                m[2] += q * a[0] * a[2];
                m[3] += q * a[1] * a[1];
                m[4] += q * a[1] * a[2];
                m[5] += q * a[2] * a[2];
            });
            let full = [[m[0], m[1], m[2]], [m[1], m[3], m[4]], [m[2], m[4], m[5]]];
            let e = &node.basis;
            let column = |i: usize| [e[0][i], e[1][i], e[2][i]];
            for i in 0..4 {
                let ei = column(i);
                let row = 2 * node.k + i;
                if self.is_fixed(row, n) {
                    continue;
                }
                work.right[row] -= ei[0] * g[0] + ei[1] * g[1] + ei[2] * g[2];
                let left: [f64; 3] =
                    std::array::from_fn(|c| ei[0] * full[0][c] + ei[1] * full[1][c] + ei[2] * full[2][c]);
                for j in i..4 {
                    if self.is_fixed(2 * node.k + j, n) {
                        continue;
                    }
                    let ej = column(j);
                    work.matrix[row][j - i] += left[0] * ej[0] + left[1] * ej[1] + left[2] * ej[2];
                }
            }
        }
        for i in 0..n {
            if self.is_fixed(i, n) {
                work.matrix[i][0] = 1.0;
            }
        }
    }

    fn is_fixed(&self, i: usize, n: usize) -> bool {
        self.fixed[0] && i < 2 || self.fixed[1] && i + 2 >= n
    }

    /// Steps of slacks and multipliers, and how far both may go.
    fn step_lengths(&self, c: &[f64], mu: f64, work: &mut Work) -> [f64; 2] {
        let rows = 1 + 4 * self.count;
        let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
        for (at, node) in self.nodes.iter().enumerate() {
            let x = self.state(node, c);
            let d = self.state(node, &work.right);
            if d[0] < 0.0 {
                primal = primal.min(-0.6 * x[0] / d[0]);
            }
            let first = at * rows;
            let (slack, multiplier) = (&work.slack[first..][..rows], &work.multiplier[first..][..rows]);
            let slack_step = &mut work.slack_step[first..][..rows];
            let multiplier_step = &mut work.multiplier_step[first..][..rows];
            self.each_row(at, node, x, |r, value, a| {
                let (s, l) = (slack[r], multiplier[r]);
                let ds = -(value + s) - (a[0] * d[0] + a[1] * d[1] + a[2] * d[2]);
                let dl = (mu - l * ds) / s - l;
                slack_step[r] = ds;
                multiplier_step[r] = dl;
                if primal * ds < -TO_BORDER * s {
                    primal = -TO_BORDER * s / ds;
                }
                if dual * dl < -TO_BORDER * l {
                    dual = -TO_BORDER * l / dl;
                }
            });
        }
        [primal, dual]
    }
}

/// Vectors that live through the iterations.
struct Work {
    slack: Vec<f64>,
    multiplier: Vec<f64>,
    slack_step: Vec<f64>,
    multiplier_step: Vec<f64>,
    /// Diagonal and the three above it.
    matrix: Vec<[f64; 4]>,
    right: Vec<f64>,
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
