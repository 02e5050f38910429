//! Some intervals of a problem with the rows that count there, laid out for eight nodes at once: what the solver needs of them.
//!
//! ```text
//!   nodes   0 1 2 3 4 5 6 7 | 8 9 ..        a group holds each coefficient of its nodes side by side
//!   group   ------- 0 ------+-- 1 -- ..     the last one is filled up with its last node, without weight and rows
//! ```

use super::{
    lanes::{LANES, Lanes},
    pair::{Sums, acceleration, jerk},
    problem::{Problem, RELAXED, Rows},
    solver::Work,
};

/// Eight nodes.
pub(super) struct Group {
    /// First of the four unknowns of each.
    first: [usize; LANES],
    /// b, b', b'' by the unknowns.
    basis: [[Lanes; 4]; 3],
    weight: Lanes,
    speed: Lanes,
    lead: Lanes,
}

impl Group {
    #[inline(always)]
    fn state(&self, c: &[f64]) -> [Lanes; 3] {
        let mut u = [Lanes::ZERO; 4];
        for lane in 0..LANES {
            let own = &c[self.first[lane]..self.first[lane] + 4];
            for i in 0..4 {
                u[i].0[lane] = own[i];
            }
        }
        let mut x = [Lanes::ZERO; 3];
        for (x, row) in x.iter_mut().zip(&self.basis) {
            *x = row[0] * u[0] + row[1] * u[1] + row[2] * u[2] + row[3] * u[3];
        }
        x
    }

    #[inline(always)]
    fn speed_value(&self, [b, b1, _]: [Lanes; 3]) -> Lanes {
        (b + self.lead * b1) * self.speed - Lanes::all(1.0)
    }
}

/// Some intervals with the rows that count there.
pub(super) struct Part {
    fixed: [bool; 2],
    pub(super) unknowns: usize,
    pub(super) nodes: usize,
    /// Number of rows.
    pub(super) rows: usize,
    pub(super) groups: Vec<Group>,
    /// Those of the first group, of the second, and so on.
    acceleration: Vec<[Lanes; 2]>,
    jerk: Vec<[Lanes; 3]>,
    /// Joints with either.
    with: [Vec<usize>; 2],
}

impl Part {
    /// A problem with some of its rows; the unknowns at given ends stay.
    pub(super) fn new(problem: &Problem, rows: &Rows) -> Self {
        let chosen = |flags: &[bool]| -> Vec<usize> { (0..problem.count).filter(|i| flags[*i]).collect() };
        let with = [chosen(&rows.acceleration), chosen(&rows.jerk)];
        let count = problem.nodes.len();
        let groups = count.div_ceil(LANES);
        let each = 1 + 2 * (with[0].len() + with[1].len());
        let mut part = Self {
            fixed: problem.fixed,
            unknowns: 2 * problem.lengths.len() + 2,
            nodes: count,
            rows: (each * groups * LANES).max(1),
            groups: Vec::with_capacity(groups),
            acceleration: Vec::with_capacity(groups * with[0].len()),
            jerk: Vec::with_capacity(groups * with[1].len()),
            with,
        };
        for from in (0..count).step_by(LANES) {
            part.add(problem, from);
        }
        part
    }

    /// Adds the eight nodes from one on.
    fn add(&mut self, problem: &Problem, from: usize) {
        let last = problem.lengths.len();
        let zero = Lanes::ZERO;
        let mut group = Group { first: [0; LANES], basis: [[zero; 4]; 3], weight: zero, speed: zero, lead: zero };
        let (a, j) = (self.acceleration.len(), self.jerk.len());
        self.acceleration.resize(a + self.with[0].len(), [zero; 2]);
        self.jerk.resize(j + self.with[1].len(), [zero; 3]);
        for lane in 0..LANES {
            let at = (from + lane).min(self.nodes - 1);
            let node = &problem.nodes[at];
            group.first[lane] = 2 * node.k;
            for (own, row) in group.basis.iter_mut().zip(&node.basis) {
                for (own, value) in own.iter_mut().zip(row) {
                    own.0[lane] = *value;
                }
            }
            if from + lane >= self.nodes {
                continue;
            }
            let near = [self.fixed[0] && node.k == 0, self.fixed[1] && node.k + 1 == last];
            // What was found with an excess within the tolerance must stay possible, and what both given unknowns decide
            // is no longer a question.
            let given = near[0] && node.tau < 0.01 || near[1] && node.tau > 0.99;
            let factor = if near[0] || near[1] { 1.0 - RELAXED } else { 1.0 };
            let decided = if given { 0.0 } else { factor };
            let own = &problem.joints[at * problem.count..(at + 1) * problem.count];
            for (row, i) in self.acceleration[a..].iter_mut().zip(&self.with[0]) {
                row[0].0[lane] = own[*i][0] * decided;
                row[1].0[lane] = own[*i][1] * decided;
            }
            for (row, i) in self.jerk[j..].iter_mut().zip(&self.with[1]) {
                for q in 0..3 {
                    row[q].0[lane] = own[*i][2 + q] * factor;
                }
            }
            let out = near[0] && node.lead > 0.0 || near[1] && node.lead < 0.0;
            group.weight.0[lane] = node.weight;
            group.speed.0[lane] = if out { 0.0 } else { node.speed };
            group.lead.0[lane] = node.lead;
        }
        self.groups.push(group);
    }

    /// Names of a node's rows, the same in every part of a problem: that of the speed, of acceleration, of jerk.
    pub(super) fn slots(&self) -> Vec<usize> {
        let [a, j] = &self.with;
        std::iter::once(0).chain(a.iter().map(|i| 1 + 2 * i)).chain(j.iter().map(|i| 2 + 2 * i)).collect()
    }

    /// Values of the pair of rows with a running number in a group.
    pub(super) fn values(&self, at: usize, row: usize, c: &[f64]) -> [Lanes; 2] {
        let group = &self.groups[at];
        let [with_a, with_j] = [self.with[0].len(), self.with[1].len()];
        let x = group.state(c);
        if row == 0 {
            [group.speed_value(x), Lanes::all(-1.0)]
        } else if row <= with_a {
            acceleration(&self.acceleration[at * with_a + row - 1], x)
        } else {
            jerk(&self.jerk[at * with_j + row - 1 - with_a], x, x[0].each(|b| 1.0 / b.sqrt()))
        }
    }

    /// Sum of w / sqrt(b); infinite where b is not above zero.
    #[inline(always)]
    pub(super) fn time(&self, c: &[f64]) -> f64 {
        let mut sum = Lanes::ZERO;
        for group in &self.groups {
            let b = group.state(c)[0];
            sum += group.weight.with(b, |w, b| if b > 0.0 { w / b.sqrt() } else { f64::INFINITY });
        }
        sum.sum()
    }

    /// Goes along the step before, and takes matrix and right sides of the next one.
    #[inline(always)]
    pub(super) fn assemble(&self, c: &[f64], steps: [f64; 2], work: &mut Work) -> Sums {
        let [with_a, with_j] = [self.with[0].len(), self.with[1].len()];
        work.matrix.fill([0.0; 4]);
        work.right.fill(0.0);
        work.central.fill(0.0);
        let mut sums = Sums::ZERO;
        let mut all = std::mem::take(&mut work.pairs);
        let mut pairs = all.iter_mut();
        for (at, group) in self.groups.iter().enumerate() {
            let x = group.state(c);
            let slow = x[0].each(|b| 1.0 / b.sqrt());
            let over = slow * slow;
            let tangent = slow * over * 0.5;
            let zero = Lanes::ZERO;
            let (mut g, mut central) = ([-group.weight * tangent, zero, zero], [zero; 3]);
            // Upper triangle: 00 01 02 11 12 22.
            let mut m = [group.weight * tangent * over * 1.5, zero, zero, zero, zero, zero];
            if let Some(pair) = pairs.next() {
                let (q, f) = pair.advance_one(0, group.speed_value(x), steps, &mut sums);
                let a = [group.speed, group.speed * group.lead];
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
            group.add(&g, &central, &m, work);
        }
        work.pairs = all;
        self.give(work);
        sums
    }

    /// Takes the given unknowns out of the system.
    fn give(&self, work: &mut Work) {
        let n = self.unknowns;
        for (fixed, own) in self.fixed.iter().zip([[0, 1], [n - 2, n - 1]]) {
            if !fixed {
                continue;
            }
            for i in own {
                for back in 1..=i.min(3) {
                    work.matrix[i - back][back] = 0.0;
                }
                work.matrix[i] = [1.0, 0.0, 0.0, 0.0];
                (work.right[i], work.central[i]) = (0.0, 0.0);
            }
        }
    }

    /// Steps of slacks and multipliers, how far the tempo may fall, and how far both may go.
    #[inline(always)]
    pub(super) fn steps(&self, c: &[f64], mu: f64, work: &mut Work) -> (f64, Sums) {
        let [with_a, with_j] = [self.with[0].len(), self.with[1].len()];
        let mut sums = Sums::ZERO;
        // Highest part of b that a full step takes.
        let mut taken = Lanes::ZERO;
        let mut pairs = work.pairs.iter_mut();
        for (at, group) in self.groups.iter().enumerate() {
            let (x, d) = (group.state(c), group.state(&work.right));
            let slow = x[0].each(|b| 1.0 / b.sqrt());
            let over = slow * slow;
            taken = taken.higher(-d[0] * over);
            let tangent = slow * over * d[0] * 0.5;
            if let Some(pair) = pairs.next() {
                let change = group.speed * (d[0] + group.lead * d[1]);
                pair.step_one(0, group.speed_value(x), change, mu, &mut sums);
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
        let taken = taken.highest();
        (if taken > 0.6 { 0.6 / taken } else { 1.0 }, sums)
    }
}

impl Group {
    /// Adds what eight nodes give to the system of their unknowns.
    #[inline(always)]
    fn add(&self, g: &[Lanes; 3], central: &[Lanes; 3], m: &[Lanes; 6], work: &mut Work) {
        let e = &self.basis;
        let full = [[m[0], m[1], m[2]], [m[1], m[3], m[4]], [m[2], m[4], m[5]]];
        for i in 0..4 {
            let own = [e[0][i], e[1][i], e[2][i]];
            let right = own[0] * g[0] + own[1] * g[1] + own[2] * g[2];
            let middle = own[0] * central[0] + own[1] * central[1] + own[2] * central[2];
            let mut left = [Lanes::ZERO; 3];
            for (c, left) in left.iter_mut().enumerate() {
                *left = own[0] * full[0][c] + own[1] * full[1][c] + own[2] * full[2][c];
            }
            let mut row = [Lanes::ZERO; 4];
            for j in i..4 {
                row[j - i] = left[0] * e[0][j] + left[1] * e[1][j] + left[2] * e[2][j];
            }
            for lane in 0..LANES {
                let at = self.first[lane] + i;
                work.right[at] -= right.0[lane];
                work.central[at] -= middle.0[lane];
                let matrix = &mut work.matrix[at];
                for j in 0..4 - i {
                    matrix[j] += row[j].0[lane];
                }
            }
        }
    }
}
