//! Some intervals of a problem with the rows that count there, laid out for eight intervals at once: what the
//! solver needs of them.
//!
//! ```text
//!   lane        0     1     2    ..   7        a bundle: eight intervals with as many nodes,
//!                                              wherever they lie
//!   slot 0     k=3   k=4   k=9  ..   k=20      their first nodes, each coefficient side by side;
//!                                              rows that any of them is near to
//!   slot 1     ..                              their second nodes
//! ```
//!
//! Both sides of a limit have the same coefficients, and are one row of the layout.
//!
//! What the nodes of an interval give to the system of its four unknowns is summed lane by lane, and goes
//! there once a bundle. Lanes without a node have no weight and no rows.

use std::ops::Range;

use proveout_machine::MAX_JOINTS;

use super::{
    lanes::{LANES, Lanes},
    problem::{JointRow, Problem, RELAXED},
    side::{AT_FIRST, INSIDE, RowSlacks, RowSums, SolverStep, even, jerk},
    solver::{Before, SolverVectors},
    system::System,
};

/// Names of a node's rows as bits: the speed, and of each joint acceleration and jerk, both sides of each.
pub(super) type Names = u32;

/// Name of the row of speed.
pub(super) const SPEED: usize = 0;

/// How many there are.
const NAMES: usize = 1 + 2 * MAX_JOINTS;

/// Names of a joint's rows: acceleration and jerk.
pub(super) const fn names(joint: usize) -> [usize; 2] {
    [1 + 2 * joint, 2 + 2 * joint]
}

/// Eight intervals.
struct Bundle {
    /// First of the four unknowns of each.
    first: [usize; LANES],
    slots: Range<usize>,
}

/// A node of each of eight intervals.
pub(super) struct LaneNodes {
    /// b, b', b'' by the unknowns.
    basis: [[Lanes; 4]; 3],
    weight: Lanes,
    /// The row of speed, where there is one.
    speed: Range<usize>,
    /// Rows limited on both sides: of acceleration, and of jerk over the tempo.
    even: Range<usize>,
    jerk: Range<usize>,
    /// Places of the names among its rows of both sides, counted from one.
    index: [u8; NAMES],
}

impl Bundle {
    /// The unknowns of the eight intervals.
    #[inline(always)]
    fn unknowns(&self, c: &[f64]) -> [Lanes; 4] {
        let mut u = [Lanes::ZERO; 4];
        for lane in 0..LANES {
            let own = &c[self.first[lane]..self.first[lane] + 4];
            for i in 0..4 {
                u[i].0[lane] = own[i];
            }
        }
        u
    }
}

impl LaneNodes {
    #[inline(always)]
    fn state(&self, u: &[Lanes; 4]) -> [Lanes; 3] {
        let mut x = [Lanes::ZERO; 3];
        for (x, row) in x.iter_mut().zip(&self.basis) {
            *x = row[0] * u[0] + row[1] * u[1] + row[2] * u[2] + row[3] * u[3];
        }
        x
    }

    /// Running number of its first row of both sides: those without the tempo come first.
    fn first(&self) -> usize {
        self.even.start + self.jerk.start
    }

    /// Running number of its row of speed, and of its row of both sides with a name.
    pub(super) fn single(&self) -> Option<usize> {
        self.speed.clone().next()
    }

    pub(super) fn pair(&self, name: usize) -> Option<usize> {
        let place = usize::from(self.index[name]);
        (place > 0).then(|| self.first() + place - 1)
    }
}

/// Names of all rows of acceleration.
const ACCELERATIONS: Names = {
    let (mut all, mut joint) = (0, 0);
    while joint < MAX_JOINTS {
        all |= 1 << names(joint)[0];
        joint += 1;
    }
    all
};

/// Some intervals with the rows that count there.
#[derive(Default)]
pub(super) struct LaneRows {
    fixed: [bool; 2],
    pub(super) unknowns: usize,
    pub(super) nodes: usize,
    bundles: Vec<Bundle>,
    slots: Vec<LaneNodes>,
    /// Those of the first slot, of the second, and so on.
    speed: Vec<[Lanes; 2]>,
    even: Vec<[Lanes; 2]>,
    jerk: Vec<[Lanes; 3]>,
    /// Slot and lane of each node, and node of each lane of the slots.
    places: Vec<[usize; 2]>,
    lanes: Vec<[usize; LANES]>,
}

impl LaneRows {
    /// Takes a problem with some of its rows, named node by node; the unknowns at given ends stay.
    pub(super) fn fill(&mut self, problem: &Problem, rows: &[Names]) {
        self.bundles.clear();
        self.slots.clear();
        self.speed.clear();
        self.even.clear();
        self.jerk.clear();
        self.lanes.clear();
        self.fixed = problem.fixed;
        self.unknowns = 2 * problem.lengths.len() + 2;
        self.nodes = problem.nodes.len();
        self.places.clear();
        self.places.resize(self.nodes, [0; 2]);
        // Intervals with nodes: number, first node, count.
        let mut own: Vec<[usize; 3]> = Vec::with_capacity(problem.lengths.len());
        for (at, node) in problem.nodes.iter().enumerate() {
            match own.last_mut().filter(|last| last[0] == node.k) {
                Some(last) => last[2] += 1,
                None => own.push([node.k, at, 1]),
            }
        }
        own.sort_by_key(|interval| interval[2]);
        for eight in own.chunks(LANES) {
            let slots = self.slots.len();
            let most = eight.iter().map(|interval| interval[2]).max().unwrap_or(0);
            for number in 0..most {
                self.add(problem, rows, eight, number);
            }
            let first = std::array::from_fn(|lane| 2 * eight[lane.min(eight.len() - 1)][0]);
            self.bundles.push(Bundle { first, slots: slots..self.slots.len() });
        }
    }

    /// Number of rows, both sides of a limit counted.
    pub(super) fn rows(&self) -> usize {
        ((self.speed.len() + 2 * (self.even.len() + self.jerk.len())) * LANES).max(1)
    }

    /// Adds the nodes with a number in their intervals.
    fn add(&mut self, problem: &Problem, rows: &[Names], eight: &[[usize; 3]], number: usize) {
        let zero = Lanes::ZERO;
        let [speed, even, jerk] = [self.speed.len(), self.even.len(), self.jerk.len()];
        let inside = eight.iter().filter(|interval| number < interval[2]).map(|interval| interval[1] + number);
        // Rows that an interval shares with the next one are kept there, unless there is none or
        // its rows may be exceeded a little.
        let until = problem.lengths.len().saturating_sub(if self.fixed[1] { 2 } else { 1 });
        let own = inside.fold(0, |all, at| {
            let twin = problem.nodes[at].twin && problem.nodes[at].k < until;
            all | if twin { rows[at] & !ACCELERATIONS } else { rows[at] }
        });
        let has = |name: usize| own >> name & 1 == 1;
        // Joints with rows of acceleration and of jerk.
        let (mut joints, mut count) = ([[0; MAX_JOINTS]; 2], [0; 2]);
        let mut index = [0; NAMES];
        for kind in 0..2 {
            for joint in (0..problem.count).filter(|joint| has(names(*joint)[kind])) {
                joints[kind][count[kind]] = joint;
                count[kind] += 1;
                index[names(joint)[kind]] = (kind * count[0] + count[kind]) as u8;
            }
        }
        self.speed.resize(speed + usize::from(has(SPEED)), [zero; 2]);
        self.even.resize(even + count[0], [zero; 2]);
        self.jerk.resize(jerk + count[1], [zero; 3]);
        let mut slot = LaneNodes {
            basis: [[zero; 4]; 3],
            weight: zero,
            speed: speed..self.speed.len(),
            even: even..self.even.len(),
            jerk: jerk..self.jerk.len(),
            index,
        };
        let mut lanes = [NONE; LANES];
        for lane in 0..LANES {
            let [k, begin, nodes] = eight[lane.min(eight.len() - 1)];
            let there = lane < eight.len() && number < nodes;
            let at = if there { begin + number } else { begin };
            let node = &problem.nodes[at];
            for (own, row) in slot.basis.iter_mut().zip(problem.basis(k, node.tau)) {
                for (own, value) in own.iter_mut().zip(row) {
                    own.0[lane] = value;
                }
            }
            if !there {
                continue;
            }
            lanes[lane] = at;
            self.places[at] = [self.slots.len(), lane];
            slot.weight.0[lane] = node.weight;
            let near = [self.fixed[0] && k == 0, self.fixed[1] && k + 1 == problem.lengths.len()];
            // What was found with an excess within the tolerance must stay possible, and what both given
            // unknowns decide is no longer a question.
            let given = near[0] && node.tau < 0.01 || near[1] && node.tau > 0.99;
            let factor = if near[0] || near[1] { 1.0 - RELAXED } else { 1.0 };
            let decided = if given { 0.0 } else { factor };
            let out = near[0] && node.lead > 0.0 || near[1] && node.lead < 0.0;
            if let Some(row) = self.speed[slot.speed.clone()].first_mut().filter(|_| !out) {
                (row[0].0[lane], row[1].0[lane]) = (node.speed * node.lead, node.speed);
            }
            let own: &[JointRow] = &problem.joints[at * problem.count..(at + 1) * problem.count];
            for (row, joint) in self.even[slot.even.clone()].iter_mut().zip(&joints[0]) {
                for q in 0..2 {
                    row[q].0[lane] = f64::from(own[*joint][q]) * decided;
                }
            }
            for (row, joint) in self.jerk[slot.jerk.clone()].iter_mut().zip(&joints[1]) {
                for q in 0..3 {
                    row[q].0[lane] = f64::from(own[*joint][2 + q]) * factor;
                }
            }
        }
        self.slots.push(slot);
        self.lanes.push(lanes);
    }

    /// Slacks and multipliers of all rows at the begin: those that a search before has left, and new ones
    /// elsewhere.
    pub(super) fn begin(&self, c: &[f64], mu: f64, before: Option<&Before<'_>>, work: &mut SolverVectors) {
        let new = [mu, if before.is_some() { INSIDE } else { AT_FIRST }];
        work.single.clear();
        work.single.reserve(self.speed.len());
        work.pairs.clear();
        work.pairs.reserve(self.even.len() + self.jerk.len());
        for bundle in &self.bundles {
            let u = bundle.unknowns(c);
            for at in bundle.slots.clone() {
                let slot = &self.slots[at];
                let x = slot.state(&u);
                let slow = x[0].each(|b| 1.0 / b.sqrt());
                let left: [_; LANES] =
                    std::array::from_fn(|lane| Some((lane, before?, before?.slot(self.lanes[at][lane])?)));
                let (number, mut names) = (slot.first(), [0; NAMES]);
                for (name, place) in slot.index.iter().enumerate().filter(|(_, place)| **place > 0) {
                    names[usize::from(*place) - 1] = name;
                }
                for q in &self.speed[slot.speed.clone()] {
                    let mut side = RowSlacks::begun(even(q, x) - Lanes::all(1.0), new);
                    for (lane, b, slot) in left.iter().flatten() {
                        if let Some(own) = b.single(*slot) {
                            side.go_on(*lane, own);
                        }
                    }
                    work.single.push(side);
                }
                let mut add = |value: Lanes, limit: Lanes| {
                    let name = names[work.pairs.len() - number];
                    let mut sides = [RowSlacks::begun(value - limit, new), RowSlacks::begun(-value - limit, new)];
                    for (lane, b, slot) in left.iter().flatten() {
                        if let Some(own) = b.pair(*slot, name) {
                            sides.iter_mut().zip(own).for_each(|(side, own)| side.go_on(*lane, own));
                        }
                    }
                    work.pairs.push(sides);
                };
                for q in &self.even[slot.even.clone()] {
                    add(even(q, x), Lanes::all(1.0));
                }
                for q in &self.jerk[slot.jerk.clone()] {
                    add(jerk(q, x), slow);
                }
            }
        }
    }

    /// Slot and lane of a node.
    pub(super) fn place(&self, node: usize) -> Option<(&LaneNodes, usize)> {
        let [slot, lane] = *self.places.get(node)?;
        Some((self.slots.get(slot)?, lane))
    }

    /// Sum of w / sqrt(b); infinite where b is not above zero.
    #[inline(always)]
    pub(super) fn time(&self, c: &[f64]) -> f64 {
        let mut sum = Lanes::ZERO;
        for bundle in &self.bundles {
            let u = bundle.unknowns(c);
            for slot in &self.slots[bundle.slots.clone()] {
                let b = slot.state(&u)[0];
                sum += slot.weight.with(b, |w, b| if b > 0.0 { w / b.sqrt() } else { f64::INFINITY });
            }
        }
        sum.sum()
    }

    /// Goes along the step before, and takes matrix and right sides of the next one.
    #[inline(always)]
    pub(super) fn assemble(&self, c: &[f64], going: SolverStep, work: &mut SolverVectors) -> RowSums {
        work.matrix.fill([0.0; 4]);
        work.right.fill(0.0);
        work.central.fill(0.0);
        work.states.clear();
        let mut sums = RowSums::ZERO;
        let (mut single, mut pairs) = (std::mem::take(&mut work.single), std::mem::take(&mut work.pairs));
        let (mut singles, mut both) = (single.iter_mut(), pairs.iter_mut());
        let one = Lanes::all(1.0);
        for bundle in &self.bundles {
            let u = bundle.unknowns(c);
            let mut system = System::ZERO;
            for slot in &self.slots[bundle.slots.clone()] {
                let x = slot.state(&u);
                let slow = x[0].each(|b| 1.0 / b.sqrt());
                work.states.push([x[0], x[1], x[2], slow]);
                let over = slow * slow;
                let tangent = slow * over * 0.5;
                let zero = Lanes::ZERO;
                let (mut g, mut central) = ([-slot.weight * tangent, zero, zero], [zero; 3]);
                // Upper triangle: 00 01 02 11 12 22.
                let mut m = [slot.weight * tangent * over * 1.5, zero, zero, zero, zero, zero];
                // Sides have weights w and v, and give f and h along their own rows.
                for (q, side) in self.speed[slot.speed.clone()].iter().zip(&mut singles) {
                    let (w, f) = side.advance(even(q, x) - one, going, &mut sums);
                    g[0] += q[1] * f;
                    g[1] += q[0] * f;
                    central[0] += q[1] * side.over;
                    central[1] += q[0] * side.over;
                    let [w0, w1] = [w * q[1], w * q[0]];
                    m[0] += w0 * q[1];
                    m[1] += w0 * q[0];
                    m[3] += w1 * q[0];
                }
                for (q, [up, down]) in self.even[slot.even.clone()].iter().zip(&mut both) {
                    let value = even(q, x);
                    let (w, f) = up.advance(value - one, going, &mut sums);
                    let (v, h) = down.advance(-value - one, going, &mut sums);
                    let (w, f, o) = (w + v, f - h, up.over - down.over);
                    g[0] += q[1] * f;
                    g[1] += q[0] * f;
                    central[0] += q[1] * o;
                    central[1] += q[0] * o;
                    let [w0, w1] = [w * q[1], w * q[0]];
                    m[0] += w0 * q[1];
                    m[1] += w0 * q[0];
                    m[3] += w1 * q[0];
                }
                // Rows q + t e and t e - q with e along b and the tangent t: (w + v)(q q' + t^2 e e') + (w -
                // v) t (q e' + e q').
                for (q, [up, down]) in self.jerk[slot.jerk.clone()].iter().zip(&mut both) {
                    let value = jerk(q, x);
                    let (w, f) = up.advance(value - slow, going, &mut sums);
                    let (v, h) = down.advance(-value - slow, going, &mut sums);
                    let (along, o) = (f - h, up.over - down.over);
                    g[0] += tangent * (f + h);
                    central[0] += tangent * (up.over + down.over);
                    let a = [q[2], q[1], q[0]];
                    for i in 0..3 {
                        g[i] += a[i] * along;
                        central[i] += a[i] * o;
                    }
                    let (w, v) = (w + v, (w - v) * tangent);
                    let [w0, w1] = [w * a[0] + v, w * a[1]];
                    m[0] += w0 * a[0] + tangent * (w * tangent) + v * a[0];
                    m[1] += w0 * a[1];
                    m[2] += w0 * a[2];
                    m[3] += w1 * a[1];
                    m[4] += w1 * a[2];
                    m[5] += w * a[2] * a[2];
                }
                system.add(&slot.basis, &g, &central, &m);
            }
            system.put(&bundle.first, work);
        }
        (work.single, work.pairs) = (single, pairs);
        self.give(work);
        sums
    }

    /// Takes the given unknowns out of the system.
    fn give(&self, work: &mut SolverVectors) {
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
    pub(super) fn steps(&self, mu: f64, work: &mut SolverVectors) -> (f64, RowSums) {
        let mut sums = RowSums::ZERO;
        // Highest part of b that a full step takes.
        let mut taken = Lanes::ZERO;
        let (mut singles, mut pairs) = (work.single.iter_mut(), work.pairs.iter_mut());
        let one = Lanes::all(1.0);
        for bundle in &self.bundles {
            let du = bundle.unknowns(&work.right);
            let slots = self.slots[bundle.slots.clone()].iter().zip(&work.states[bundle.slots.clone()]);
            for (slot, [b, b1, b2, slow]) in slots {
                let (x, d, slow) = ([*b, *b1, *b2], slot.state(&du), *slow);
                let over = slow * slow;
                taken = taken.higher(-d[0] * over);
                let tangent = slow * over * d[0] * 0.5;
                for (q, side) in self.speed[slot.speed.clone()].iter().zip(&mut singles) {
                    side.step(even(q, x) - one, even(q, d), mu, &mut sums);
                }
                for (q, [up, down]) in self.even[slot.even.clone()].iter().zip(&mut pairs) {
                    let (value, change) = (even(q, x), even(q, d));
                    up.step(value - one, change, mu, &mut sums);
                    down.step(-value - one, -change, mu, &mut sums);
                }
                for (q, [up, down]) in self.jerk[slot.jerk.clone()].iter().zip(&mut pairs) {
                    let (value, change) = (jerk(q, x), jerk(q, d));
                    up.step(value - slow, tangent + change, mu, &mut sums);
                    down.step(-value - slow, tangent - change, mu, &mut sums);
                }
            }
        }
        let taken = taken.highest();
        (if taken > 0.6 { 0.6 / taken } else { 1.0 }, sums)
    }
}

/// A lane without a node.
const NONE: usize = usize::MAX;
