//! The tempo over a grid as a problem with rows: what is unknown, what limits it, and where.
//!
//! *Unknowns.* b is a cubic with continuous slope over intervals of length `h_k`, given by its values and
//! slopes at their borders (Hermite): `x = (b_0, b'_0 H, b_1, b'_1 H, ..)` with the mean length H, so that
//! interval k takes the four unknowns from 2 k on and all matrices have seven diagonals. Within an interval
//! b'' is linear and free to jump at the borders: where b is a quadratic there, the jerk cannot stay at its
//! limit while the speed changes, which costs 3 percent of the time at corners.
//!
//! *Problem.* Minimize the sum of w / sqrt(b) over points under the rows of each point and joint
//!
//! ```text
//!   u c <= 1          |a1 b' + a0 b| <= 1          |j2 b'' + j1 b' + j0 b| <= 1/sqrt(b)
//! ```
//!
//! where c are the two inner control points of b in Bezier form: b lies in the hull of its control points, so
//! that no speed is passed between the points (`cap.rs`).
//!
//! *Rows that never bind.* Rows of acceleration (of jerk) of a joint that stay far below their limit in all
//! of the intervals under way are left out (`far`, `near`); the caller looks at all rows of the result and
//! takes them in where they are needed (`stages.rs`).
//!
//! *Between the points* of an interval a row may pass its limit. Where the parabola through three neighbors
//! does, the caller puts a point at its vertex (`peaks`) and goes on from there: nodes lie where they are
//! needed.

use proveout_machine::MAX_JOINTS;

use super::part::{Names, SPEED, names};

/// Nodes, to either side of which rows near to their limits take part: as many up to twice as many.
const AROUND: usize = 32;

/// Parts of the limits that rows reach.
#[derive(Debug, Default)]
pub(super) struct Loads {
    /// Acceleration and jerk of the joints of the first node, of the second, and so on.
    joints: Vec<[f64; 2]>,
}

/// b, b', b'' of a polynomial.
fn at_part([b0, b1, b2, b3]: &[f64; 4], x: f64) -> [f64; 3] {
    [b0 + x * (b1 + x * (b2 + x * b3)), b1 + x * (2.0 * b2 + 3.0 * x * b3), 2.0 * b2 + 6.0 * x * b3]
}

fn speed(node: &TempoNode) -> Names {
    Names::from(node.speed > 0.0) << SPEED
}

/// Five coefficients a joint and point, over the limits: a1, a0 of acceleration; j2, j1, j0 of jerk. There
/// are some hundred of them a block, and memory is what they cost; in single precision each is known to 6e-8
/// of itself, far below the margin of a row.
pub(super) type JointRow = [f32; 5];

/// Highest coefficient: far above any that a limit leaves some motion, and a number in single precision.
const HIGHEST: f64 = 1e30;

/// Coefficients as they are kept.
pub(super) fn joint_row(row: [f64; 5]) -> JointRow {
    row.map(|x| x.clamp(-HIGHEST, HIGHEST) as f32)
}

/// Acceleration and jerk over the limits, without and over the tempo.
fn loads_of(row: &JointRow, [b, b1, b2]: [f64; 3]) -> [f64; 2] {
    let q = row.map(f64::from);
    [q[0] * b1 + q[1] * b, q[2] * b2 + q[3] * b1 + q[4] * b]
}

/// A place where limits are kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct TempoNode {
    /// Interval, and part of it.
    pub(super) k: usize,
    pub(super) tau: f64,
    /// Cell of the path, and a number that changes where derivatives may jump.
    pub(super) cell: usize,
    pub(super) smooth: u32,
    /// The next node is the same place, seen from the next interval: only b'' differs there, and
    /// rows of acceleration need not be listed twice.
    pub(super) twin: bool,
    /// Part of the time that this point represents.
    pub(super) weight: f64,
    /// One over the highest b that velocities and feed allow, for b + lead b'.
    pub(super) speed: f64,
    /// Distance from the node to the control point of b that must keep the limit; for the node at
    /// the begin it lies a third of the interval ahead, for the one at the end a third back.
    pub(super) lead: f64,
}

/// Grid and rows.
#[derive(Debug, Default)]
pub(super) struct Problem {
    /// What the unknown slopes are multiplied with.
    pub(super) scale: f64,
    /// Lengths of the intervals, and their begins in the time of the first law.
    pub(super) lengths: Vec<f64>,
    pub(super) begins: Vec<f64>,
    pub(super) nodes: Vec<TempoNode>,
    /// Joints of the first node, of the second, and so on.
    pub(super) joints: Vec<JointRow>,
    /// Number of joints with rows, and which joints of the machine they are.
    pub(super) count: usize,
    pub(super) used: Vec<usize>,
    /// b and its slope, the first (last) two unknowns, are given.
    pub(super) fixed: [bool; 2],
}

/// What rows next to given unknowns may pass their limits, so that these have an inside.
pub(super) const RELAXED: f64 = 2e-4 + MARGIN;
/// Part by which rows of acceleration and jerk are tighter than the limits: between the points of the grid
/// and between samples a law may pass its rows by so much. It costs a thousandth of the time.
pub(super) const MARGIN: f64 = 0.003;
/// Nodes do not lie closer than this part of an interval; and what a peak between two must rise above them,
/// as part.
const CLOSEST: f64 = 0.03;
const HIGHER: f64 = 0.0005;

impl Problem {
    /// Basis of b, b', b'' in interval `k` at part `tau` of it.
    pub(super) fn basis(&self, k: usize, tau: f64) -> [[f64; 4]; 3] {
        let h = self.lengths[k];
        let (t, r, w) = (tau, 1.0 - tau, h / self.scale);
        let value = [r * r * (1.0 + 2.0 * t), w * t * r * r, t * t * (3.0 - 2.0 * t), -w * t * t * r];
        let slope = [-6.0 * t * r, w * r * (r - 2.0 * t), 6.0 * t * r, w * t * (t - 2.0 * r)];
        let bend = [12.0 * t - 6.0, w * (6.0 * t - 4.0), 6.0 - 12.0 * t, w * (6.0 * t - 2.0)];
        let over = 1.0 / h;
        [value, slope.map(|x| x * over), bend.map(|x| x * (over * over))]
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

    /// Highest part of the limits at a node: below one where all rows hold.
    pub(super) fn used(&self, at: usize, c: &[f64]) -> f64 {
        self.used_of(at, &self.polynomial(c, self.nodes[at].k))
    }

    /// The same of all nodes, with the interval of each.
    pub(super) fn all_used(&self, c: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        let mut own = (usize::MAX, [0.0; 4]);
        self.nodes.iter().enumerate().map(move |(at, node)| {
            if own.0 != node.k {
                own = (node.k, self.polynomial(c, node.k));
            }
            (node.k, self.used_of(at, &own.1))
        })
    }

    /// The same where b has this polynomial.
    fn used_of(&self, at: usize, polynomial: &[f64; 4]) -> f64 {
        let node = &self.nodes[at];
        let [b, b1, b2] = at_part(polynomial, node.tau * self.lengths[node.k]);
        let root = b.max(0.0).sqrt();
        let mut worst = ((b + node.lead * b1) * node.speed).max(0.0).sqrt();
        for q in &self.joints[at * self.count..(at + 1) * self.count] {
            let [a, j] = loads_of(q, [b, b1, b2]);
            worst = worst.max(a.abs()).max((j * root).abs());
        }
        worst
    }

    /// What all rows have of their limits.
    pub(super) fn loads(&self, c: &[f64], loads: &mut Loads) {
        loads.joints.clear();
        loads.joints.reserve(self.joints.len());
        let mut own = (usize::MAX, [0.0; 4]);
        for (at, node) in self.nodes.iter().enumerate() {
            if own.0 != node.k {
                own = (node.k, self.polynomial(c, node.k));
            }
            let [b, b1, b2] = at_part(&own.1, node.tau * self.lengths[node.k]);
            let root = b.max(0.0).sqrt();
            let own = &self.joints[at * self.count..(at + 1) * self.count];
            let of = |q: &JointRow| {
                let [a, j] = loads_of(q, [b, b1, b2]);
                [a, j * root]
            };
            loads.joints.extend(own.iter().map(of));
        }
    }

    /// Where a row of acceleration or jerk between the nodes exceeds a part of its limit, and its
    /// values at the nodes: the node before the place, and the part of the interval.
    pub(super) fn peaks(&self, loads: &Loads, above: f64) -> Vec<(usize, f64)> {
        let mut out: Vec<(usize, f64)> = Vec::new();
        for at in 1..self.nodes.len().max(1) - 1 {
            let [l, m, r] = [&self.nodes[at - 1], &self.nodes[at], &self.nodes[at + 1]];
            if l.k != r.k || l.smooth != r.smooth || r.tau - l.tau < 2.0 * CLOSEST {
                continue;
            }
            let (x0, x1) = (l.tau - m.tau, r.tau - m.tau);
            for i in 0..self.count {
                let [fl, fm, fr] = [at - 1, at, at + 1].map(|n| &loads.joints[n * self.count + i]);
                for kind in 0..2 {
                    let (f0, f, f1) = (fl[kind], fm[kind], fr[kind]);
                    let highest = f.abs().max(f0.abs()).max(f1.abs());
                    if highest < 0.9 * above {
                        continue;
                    }
                    // f + slope x + bend x^2 through the three.
                    let (d0, d1) = ((f0 - f) / x0, (f1 - f) / x1);
                    let bend = (d1 - d0) / (x1 - x0);
                    let slope = d0 - bend * x0;
                    let x = -0.5 * slope / bend;
                    let inside = x > x0 + CLOSEST && x < x1 - CLOSEST && x.abs() > CLOSEST;
                    if inside && (f + 0.5 * slope * x).abs() > above.max((1.0 + HIGHER) * highest) {
                        out.push((if x < 0.0 { at - 1 } else { at }, m.tau + x));
                    }
                }
            }
        }
        out.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        out.dedup_by(|b, a| a.0 == b.0 && b.1 - a.1 < CLOSEST);
        out
    }

    /// Adds points with their rows, each after a node.
    pub(super) fn insert(&mut self, points: &[(usize, f64)], mut rows: impl FnMut(usize, f64) -> Vec<JointRow>) {
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
        let range = first.0..last.0 + 1;
        let count = self.count;
        let mut nodes = Vec::with_capacity(range.len() + points.len());
        let mut joints = Vec::with_capacity((range.len() + points.len()) * count);
        let mut next = points.iter().peekable();
        for at in range.clone() {
            let node = self.nodes[at];
            nodes.push(node);
            joints.extend_from_slice(&self.joints[at * count..(at + 1) * count]);
            while let Some((_, tau)) = next.next_if(|p| p.0 == at) {
                nodes.push(TempoNode { tau: *tau, twin: false, weight: 0.0, speed: 0.0, lead: 0.0, ..node });
                joints.extend(rows(node.cell, self.begins[node.k] + tau * self.lengths[node.k]));
            }
        }
        self.joints.splice(range.start * count..range.end * count, joints);
        self.nodes.splice(range, nodes);
    }

    /// Divides the limits of a node by a factor.
    pub(super) fn tighten(&mut self, at: usize, factor: f64) {
        self.nodes[at].speed *= factor;
        self.nodes[at].twin = false;
        for row in &mut self.joints[at * self.count..(at + 1) * self.count] {
            *row = joint_row(row.map(|r| f64::from(r) * factor));
        }
    }

    /// Rows of all joints that reach a part of the highest load of all, for a start that is far from all
    /// limits; the same at each node.
    pub(super) fn far(&self, loads: &Loads, part: f64, rows: &mut Vec<Names>) {
        let mut high = [[0.0_f64; 2]; MAX_JOINTS];
        for own in loads.joints.chunks(self.count.max(1)) {
            for (high, [a, j]) in high.iter_mut().zip(own) {
                *high = [high[0].max(a.abs()), high[1].max(j.abs())];
            }
        }
        let highest = high.iter().flatten().fold(0.0_f64, |m, h| m.max(*h));
        let above = part * highest.min(1.0);
        let mut all = 0;
        for (i, [a, j]) in high.into_iter().enumerate().take(self.count) {
            let [acceleration, jerk] = names(i);
            all |= Names::from(a > above) << acceleration | Names::from(j > above) << jerk;
        }
        rows.clear();
        rows.extend(self.nodes.iter().map(|node| all | speed(node)));
    }

    /// Rows of joints that come above a part of a limit, node by node, with those of the nodes around: to
    /// both sides of the limit, since a tempo that nothing holds there goes to the other one.
    pub(super) fn near(&self, loads: &Loads, part: f64, rows: &mut Vec<Names>) {
        let of = |own: &[[f64; 2]]| {
            own.iter().enumerate().fold(0, |all, (i, [a, j])| {
                let [acceleration, jerk] = names(i);
                all | Names::from(a.abs() > part) << acceleration | Names::from(j.abs() > part) << jerk
            })
        };
        let count = self.count.max(1);
        let blocks: Vec<Names> = loads
            .joints
            .chunks(AROUND * count)
            .map(|block| block.chunks(count).fold(0, |all, own| all | of(own)))
            .collect();
        rows.clear();
        rows.extend(self.nodes.iter().enumerate().map(|(at, node)| {
            let block = at / AROUND;
            let own = blocks.iter().take(block + 2).skip(block.saturating_sub(1));
            own.fold(speed(node), |all, names| all | names)
        }));
    }

    /// Intervals with rows that take no part and pass their limits.
    pub(super) fn passed(&self, loads: &Loads, rows: &[Names]) -> Vec<usize> {
        let own = loads.joints.chunks(self.count.max(1)).zip(rows).zip(&self.nodes);
        let passed = own.filter(|((own, rows), _)| {
            own.iter().enumerate().any(|(i, load)| {
                let left_out = names(i).map(|name| *rows >> name & 1 == 0);
                load[0].abs() > 1.0 && left_out[0] || load[1].abs() > 1.0 && left_out[1]
            })
        });
        passed.map(|(_, node)| node.k).collect()
    }

    /// The intervals from `from` up to `to` as a problem of their own; the unknowns at inner ends are given.
    pub(super) fn between(&self, [from, to]: [usize; 2]) -> Self {
        let first = self.nodes.partition_point(|n| n.k < from);
        let last = self.nodes.partition_point(|n| n.k < to);
        Self {
            scale: self.scale,
            lengths: self.lengths[from..to].to_vec(),
            begins: self.begins[from..to].to_vec(),
            nodes: self.nodes[first..last].iter().map(|n| TempoNode { k: n.k - from, ..*n }).collect(),
            joints: self.joints[first * self.count..last * self.count].to_vec(),
            count: self.count,
            used: self.used.clone(),
            fixed: [from > 0 || self.fixed[0], to < self.lengths.len() || self.fixed[1]],
        }
    }
}
