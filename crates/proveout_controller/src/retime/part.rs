//! Some intervals of a problem with the rows that count there, laid out for eight intervals at once: what the solver needs of them.
//!
//! ```text
//!   lane        0     1     2    ..   7        a bundle: eight intervals with as many nodes, wherever they lie
//!   slot 0     k=3   k=4   k=9  ..   k=20      their first nodes, each coefficient side by side; rows that any of them is near to
//!   slot 1     ..                              their second nodes
//! ```
//!
//! What the nodes of an interval give to the system of its four unknowns is summed lane by lane, and goes there once a bundle. Lanes
//! without a node have no weight and no rows.

use std::ops::Range;

use proveout_machine::MAX_JOINTS;

use super::{
    lanes::{LANES, Lanes},
    problem::{JointRow, Problem, RELAXED},
    side::{Sums, even, jerk},
    solver::Work,
    system::System,
};

/// Names of a node's rows as bits: the speed, and of each joint both sides of acceleration and of jerk.
pub(super) type Names = u64;

/// Name of the row of speed.
pub(super) const SPEED: usize = 0;

/// How many there are.
const NAMES: usize = 1 + 4 * MAX_JOINTS;

/// Names of a joint's rows: acceleration above and below, jerk above and below.
pub(super) fn names(joint: usize) -> [usize; 4] {
    [1 + 4 * joint, 2 + 4 * joint, 3 + 4 * joint, 4 + 4 * joint]
}

/// Eight intervals.
struct Bundle {
    /// First of the four unknowns of each.
    first: [usize; LANES],
    slots: Range<usize>,
}

/// A node of each of eight intervals.
struct Slot {
    /// b, b', b'' by the unknowns.
    basis: [[Lanes; 4]; 3],
    weight: Lanes,
    /// Rows without and with the tempo on their right side.
    even: Range<usize>,
    jerk: Range<usize>,
    /// Places of the names among its rows, counted from one.
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

impl Slot {
    #[inline(always)]
    fn state(&self, u: &[Lanes; 4]) -> [Lanes; 3] {
        let mut x = [Lanes::ZERO; 3];
        for (x, row) in x.iter_mut().zip(&self.basis) {
            *x = row[0] * u[0] + row[1] * u[1] + row[2] * u[2] + row[3] * u[3];
        }
        x
    }

    /// Running numbers of its rows: those without the tempo come first.
    fn rows(&self) -> Range<usize> {
        self.even.start + self.jerk.start..self.even.end + self.jerk.end
    }
}

/// Some intervals with the rows that count there.
#[derive(Default)]
pub(super) struct Part {
    fixed: [bool; 2],
    pub(super) unknowns: usize,
    pub(super) nodes: usize,
    bundles: Vec<Bundle>,
    slots: Vec<Slot>,
    /// Those of the first slot, of the second, and so on.
    even: Vec<[Lanes; 2]>,
    jerk: Vec<[Lanes; 3]>,
    /// Names of the rows, slot by slot, those without the tempo first.
    names: Vec<u8>,
    /// Slot and lane of each node, and node of each lane of the slots.
    places: Vec<[usize; 2]>,
    lanes: Vec<[usize; LANES]>,
}

impl Part {
    /// Takes a problem with some of its rows, named node by node; the unknowns at given ends stay.
    pub(super) fn fill(&mut self, problem: &Problem, rows: &[Names]) {
        self.bundles.clear();
        self.slots.clear();
        self.even.clear();
        self.jerk.clear();
        self.names.clear();
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

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        (self.names.len() * LANES).max(1)
    }

    /// Adds the nodes with a number in their intervals.
    fn add(&mut self, problem: &Problem, rows: &[Names], eight: &[[usize; 3]], number: usize) {
        let zero = Lanes::ZERO;
        let [even, jerk, first] = [self.even.len(), self.jerk.len(), self.names.len()];
        let inside = eight.iter().filter(|interval| number < interval[2]);
        let names = inside.fold(0, |all, interval| all | rows[interval[1] + number]);
        let has = |name: usize| names >> name & 1 == 1;
        if has(SPEED) {
            self.names.push(SPEED as u8);
        }
        for kind in 0..2 {
            for joint in 0..problem.count {
                let own = names_of(joint, kind).into_iter().filter(|name| has(*name));
                self.names.extend(own.map(|name| name as u8));
            }
            if kind == 0 {
                self.even.resize(even + self.names.len() - first, [zero; 2]);
            }
        }
        let without = self.even.len() - even;
        self.jerk.resize(jerk + self.names.len() - first - without, [zero; 3]);
        let (even, jerk) = (even..self.even.len(), jerk..self.jerk.len());
        let mut slot = Slot { basis: [[zero; 4]; 3], weight: zero, even, jerk, index: [0; NAMES] };
        for (place, name) in (1..).zip(&self.names[first..]) {
            slot.index[usize::from(*name)] = place;
        }
        let mut lanes = [NONE; LANES];
        for lane in 0..LANES {
            let [k, begin, count] = eight[lane.min(eight.len() - 1)];
            let there = lane < eight.len() && number < count;
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
            // What was found with an excess within the tolerance must stay possible, and what both given unknowns decide
            // is no longer a question.
            let given = near[0] && node.tau < 0.01 || near[1] && node.tau > 0.99;
            let factor = if near[0] || near[1] { 1.0 - RELAXED } else { 1.0 };
            let decided = if given { 0.0 } else { factor };
            let out = near[0] && node.lead > 0.0 || near[1] && node.lead < 0.0;
            let joints: &[JointRow] = &problem.joints[at * problem.count..(at + 1) * problem.count];
            let (without, with) = self.names[first..].split_at(without);
            for (row, name) in self.even[slot.even.clone()].iter_mut().zip(without) {
                let [a1, a0] = match of_joint(*name) {
                    None if out => [0.0; 2],
                    None => [node.speed * node.lead, node.speed],
                    Some((joint, sign)) => [joints[joint][0] * decided * sign, joints[joint][1] * decided * sign],
                };
                (row[0].0[lane], row[1].0[lane]) = (a1, a0);
            }
            for (row, name) in self.jerk[slot.jerk.clone()].iter_mut().zip(with) {
                let Some((joint, sign)) = of_joint(*name) else { continue };
                for q in 0..3 {
                    row[q].0[lane] = joints[joint][2 + q] * factor * sign;
                }
            }
        }
        self.slots.push(slot);
        self.lanes.push(lanes);
    }

    /// Nodes in the lanes, names and values of all rows in their order.
    pub(super) fn values(&self, c: &[f64], mut take: impl FnMut(&[usize; LANES], u8, Lanes)) {
        for bundle in &self.bundles {
            let u = bundle.unknowns(c);
            for at in bundle.slots.clone() {
                let (slot, nodes) = (&self.slots[at], &self.lanes[at]);
                let x = slot.state(&u);
                let slow = x[0].each(|b| 1.0 / b.sqrt());
                let mut names = self.names[slot.rows()].iter();
                for (q, name) in self.even[slot.even.clone()].iter().zip(&mut names) {
                    take(nodes, *name, even(q, x));
                }
                for (q, name) in self.jerk[slot.jerk.clone()].iter().zip(&mut names) {
                    take(nodes, *name, jerk(q, x, slow));
                }
            }
        }
    }

    /// Running number and lane of a node's row with a name.
    pub(super) fn row(&self, node: usize, name: u8) -> Option<[usize; 2]> {
        let [at, lane] = *self.places.get(node)?;
        let slot = self.slots.get(at)?;
        let place = slot.index[usize::from(name)];
        (place > 0).then(|| [slot.rows().start + usize::from(place) - 1, lane])
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
    pub(super) fn assemble(&self, c: &[f64], steps: [f64; 2], work: &mut Work) -> Sums {
        work.matrix.fill([0.0; 4]);
        work.right.fill(0.0);
        work.central.fill(0.0);
        let mut sums = Sums::ZERO;
        let mut all = std::mem::take(&mut work.sides);
        let mut sides = all.iter_mut();
        for bundle in &self.bundles {
            let u = bundle.unknowns(c);
            let mut system = System::ZERO;
            for slot in &self.slots[bundle.slots.clone()] {
                let x = slot.state(&u);
                let slow = x[0].each(|b| 1.0 / b.sqrt());
                let over = slow * slow;
                let tangent = slow * over * 0.5;
                let zero = Lanes::ZERO;
                let (mut g, mut central) = ([-slot.weight * tangent, zero, zero], [zero; 3]);
                // Upper triangle: 00 01 02 11 12 22.
                let mut m = [slot.weight * tangent * over * 1.5, zero, zero, zero, zero, zero];
                for (q, side) in self.even[slot.even.clone()].iter().zip(&mut sides) {
                    let (w, f) = side.advance(even(q, x), steps, &mut sums);
                    g[0] += q[1] * f;
                    g[1] += q[0] * f;
                    central[0] += q[1] * side.over;
                    central[1] += q[0] * side.over;
                    let [w0, w1] = [w * q[1], w * q[0]];
                    m[0] += w0 * q[1];
                    m[1] += w0 * q[0];
                    m[3] += w1 * q[0];
                }
                for (q, side) in self.jerk[slot.jerk.clone()].iter().zip(&mut sides) {
                    let (w, f) = side.advance(jerk(q, x, slow), steps, &mut sums);
                    let a = [q[2] + tangent, q[1], q[0]];
                    for i in 0..3 {
                        g[i] += a[i] * f;
                        central[i] += a[i] * side.over;
                    }
                    let [w0, w1] = [w * a[0], w * a[1]];
                    m[0] += w0 * a[0];
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
        work.sides = all;
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
        let mut sums = Sums::ZERO;
        // Highest part of b that a full step takes.
        let mut taken = Lanes::ZERO;
        let mut sides = work.sides.iter_mut();
        for bundle in &self.bundles {
            let (u, du) = (bundle.unknowns(c), bundle.unknowns(&work.right));
            for slot in &self.slots[bundle.slots.clone()] {
                let (x, d) = (slot.state(&u), slot.state(&du));
                let slow = x[0].each(|b| 1.0 / b.sqrt());
                let over = slow * slow;
                taken = taken.higher(-d[0] * over);
                let tangent = slow * over * d[0] * 0.5;
                for (q, side) in self.even[slot.even.clone()].iter().zip(&mut sides) {
                    side.step(even(q, x), q[0] * d[1] + q[1] * d[0], mu, &mut sums);
                }
                for (q, side) in self.jerk[slot.jerk.clone()].iter().zip(&mut sides) {
                    let change = q[0] * d[2] + q[1] * d[1] + q[2] * d[0];
                    side.step(jerk(q, x, slow), tangent + change, mu, &mut sums);
                }
            }
        }
        let taken = taken.highest();
        (if taken > 0.6 { 0.6 / taken } else { 1.0 }, sums)
    }
}

/// A lane without a node.
const NONE: usize = usize::MAX;

/// Both sides of acceleration (0) or jerk (1).
fn names_of(joint: usize, kind: usize) -> [usize; 2] {
    let all = names(joint);
    [all[2 * kind], all[2 * kind + 1]]
}

/// Joint of a row, and its side; none of the row of speed.
fn of_joint(name: u8) -> Option<(usize, f64)> {
    let number = usize::from(name).checked_sub(1)?;
    Some((number / 4, if number % 2 == 0 { 1.0 } else { -1.0 }))
}
