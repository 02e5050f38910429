//! Joint values for a pose along a chain: rotary joints from the tool axis, slides from the tip.

use nalgebra::{Matrix3, SMatrix};
use proveout_geom::{Point, Vector};

use crate::{
    Joint, JointValues, MAX_JOINTS,
    axis_pair::{AxisAngles, AxisPair, solve_single},
    kinematic_chain::{Chain, ChainLink},
};

/// What the inverse kinematics can compute ahead for a chain.
#[derive(Clone, Debug)]
pub(crate) struct Solver {
    /// Joints that turn the tool, from the table to the tool; with more than two the way is numerical.
    rotary: Vec<usize>,
    /// Linear joints that place the tip; of more than three the smallest motion is taken.
    linear: Vec<usize>,
    held: Vec<usize>,
    held_rotary: bool,
    home: JointValues,
    /// Constants of the rotary pair, when no held joint changes them.
    pair: Option<AxisPair>,
    block: Option<LinearBlock>,
}

/// Three linear joints with no rotary joint between them: their directions are constant.
#[derive(Clone, Debug)]
struct LinearBlock {
    /// First and last link, in the chain.
    first: usize,
    last: usize,
    joints_from_offset: Matrix3<f64>,
}

/// Determinant of three unit directions below which they count as lying in a plane; they are then solved in
/// the sense of least squares.
const FLAT_DETERMINANT: f64 = 1e-9;

/// The numerical way gives up after this many steps; from a neighboring pose it needs three to five.
const NUMERICAL_STEPS: usize = 200;

/// Angle (radian) at which the numerical way is at its end: rounding of the axis.
const NUMERICAL_FLOOR: f64 = 4e-16;

/// Longest step of the tool axis and of a joint, radian: the rates change by as much along it.
const MAX_AXIS_STEP: f64 = 0.3;
const MAX_JOINT_STEP: f64 = 0.6;

/// Damping of the numerical way: at first and at least, after a step that did not help at least, and where it
/// gives up.
const LEAST_DAMPING: f64 = 1e-12;
const DAMPED: f64 = 1e-9;
const MOST_DAMPING: f64 = 1e6;

/// Sine of the angle between two axes below which no turn about the direction across them is seen.
const PARALLEL: f64 = 1e-14;

impl Solver {
    pub(crate) fn new(chain: &Chain, joints: &[Joint]) -> Self {
        let pick = |rotary: bool| {
            let links = chain.links.iter().filter(move |l| l.rotary == rotary && !joints[l.joint].held);
            links.map(|l| l.joint).collect::<Vec<_>>()
        };
        let (rotary, linear) = (pick(true), pick(false));
        let held: Vec<usize> = chain.links.iter().map(|l| l.joint).filter(|&j| joints[j].held).collect();
        let mut home = JointValues::ZERO;
        for (i, joint) in joints.iter().enumerate() {
            home[i] = joint.home;
        }
        let mut solver = Self {
            held_rotary: held.iter().any(|&j| joints[j].is_rotary()),
            block: LinearBlock::new(chain, &linear),
            pair: None,
            rotary,
            linear,
            held,
            home,
        };
        if !solver.held_rotary && solver.rotary.len() == 2 {
            let (first, second, tool, _) = solver.frame(chain, &home, &Vector::z());
            solver.pair = AxisPair::new(first, second, tool);
        }
        solver
    }

    /// Rotary axes that inverse kinematics moves, table side first.
    pub(crate) fn rotary(&self) -> &[usize] {
        &self.rotary
    }

    /// True where the rotary joints follow from the tool axis in closed form.
    pub(crate) fn has_closed_form(&self) -> bool {
        self.rotary.len() <= 2
    }

    /// Rotary angles near those of `q` that bring the tool axis into the unit vector `u` of K, for any number
    /// of rotary joints; sets them in `q` and returns the angle that is left.
    ///
    /// Each step is the smallest motion that brings the axis onto `u` at first order, damped where the joints
    /// turn the axis little (Levenberg 1944, Marquardt 1963): with the rates A (3 x n) it is `A' (A A' + m
    /// I)^-1 e`. Newton's way from a neighboring pose doubles the digits with each step.
    ///
    /// A joint at its end stop that would be pushed past it is left out of the step.
    pub(crate) fn turn_numerically(&self, chain: &Chain, joints: &[Joint], q: &mut JointValues, u: &Vector) -> f64 {
        let mut damping = LEAST_DAMPING;
        let (mut axis, mut rates) = self.axis_rates(chain, q);
        let angle = |axis: &Vector| axis.cross(u).norm().atan2(axis.dot(u));
        let mut left = angle(&axis);
        for _ in 0..NUMERICAL_STEPS {
            if left <= NUMERICAL_FLOOR {
                break;
            }
            // The way on the great circle; upside down any way across will do.
            let across = axis.cross(u).try_normalize(PARALLEL);
            let way = match across {
                Some(w) => w.cross(&axis) * left.min(MAX_AXIS_STEP),
                None if left < 1.0 => u - axis,
                None => rates.column(self.rotary.first().copied().unwrap_or(0)) * 0.1,
            };
            let next = self.damped_step(joints, q, rates, &way, damping);
            let (next_axis, next_rates) = self.axis_rates(chain, &next);
            let next_left = angle(&next_axis);
            if next_left < left {
                (*q, axis, rates, left) = (next, next_axis, next_rates, next_left);
                damping = (damping * 0.1).max(LEAST_DAMPING);
            } else {
                damping = (damping * 100.0).max(DAMPED);
                if damping > MOST_DAMPING {
                    break;
                }
            }
        }
        left
    }

    fn damped_step(
        &self,
        joints: &[Joint],
        q: &JointValues,
        mut rates: SMatrix<f64, 3, MAX_JOINTS>,
        way: &Vector,
        damping: f64,
    ) -> JointValues {
        loop {
            let normal = rates * rates.transpose() + Matrix3::identity() * damping;
            let Some(inverse) = normal.try_inverse() else { return *q };
            let step = rates.transpose() * (inverse * way);
            let mut next = *q;
            let mut stopped = None;
            for &j in &self.rotary {
                let wanted = q[j] + step[j].clamp(-MAX_JOINT_STEP, MAX_JOINT_STEP);
                next[j] = match joints[j].travel {
                    Some([low, high]) if q[j] >= low && q[j] <= high => wanted.clamp(low, high),
                    _ => wanted,
                };
                if next[j] != wanted && next[j] == q[j] {
                    stopped = Some(j);
                }
            }
            match stopped {
                // Each round leaves one joint more out, so that it ends.
                Some(j) if rates.column(j).norm() > 0.0 => rates.column_mut(j).fill(0.0),
                _ => return next,
            }
        }
    }

    /// Tool axis in K and its rate with each moving rotary joint.
    fn axis_rates(&self, chain: &Chain, q: &JointValues) -> (Vector, SMatrix<f64, 3, MAX_JOINTS>) {
        let mut axis: Vector = chain.spindle_at_zero.rotation.column(2).into();
        let mut rates = SMatrix::<f64, 3, MAX_JOINTS>::zeros();
        for link in chain.links.iter().rev().filter(|l| l.rotary) {
            let turn = link.pose(q[link.joint]).rotation;
            axis = turn * axis;
            rates = turn * rates;
            if self.rotary.contains(&link.joint) {
                rates.set_column(link.joint, &link.direction.cross(&axis));
            }
        }
        (axis, rates)
    }

    /// Second singular value, at its largest over a set of joint values, of the tool axis rates: zero when
    /// the rotary joints can only swing the tool in a plane.
    pub(crate) fn freedom(&self, chain: &Chain) -> f64 {
        let mut best = 0.0_f64;
        for k in 0..16 {
            let mut q = self.home;
            for (i, &j) in self.rotary.iter().enumerate() {
                // Multiples of the golden angle: no two joints alike, no right angles.
                q[j] = 2.399_963 * f64::from(k) + 0.7 * i as f64;
            }
            let (_, rates) = self.axis_rates(chain, &q);
            let mut values = (rates * rates.transpose()).symmetric_eigenvalues();
            values.as_mut_slice().sort_by(f64::total_cmp);
            best = best.max(values[1].max(0.0).sqrt());
        }
        best
    }

    /// Held joints.
    pub(crate) fn held(&self) -> &[usize] {
        &self.held
    }

    /// Home of every joint, the position of held joints unless stated otherwise.
    pub(crate) fn home(&self) -> &JointValues {
        &self.home
    }

    /// Slides that inverse kinematics moves, in the order of the chain.
    pub(crate) fn linear(&self) -> &[usize] {
        &self.linear
    }

    /// True when the two rotary joints can be solved at the home values of the held ones.
    pub(crate) fn has_pair(&self, chain: &Chain) -> bool {
        let (first, second, tool, _) = self.frame(chain, &self.home, &Vector::z());
        self.pair.is_some() || AxisPair::new(first, second, tool).is_some()
    }

    /// First and second rotary axis and tool axis, each with the held joints between it and the first rotary
    /// joint applied, and the wanted axis seen from before the first rotary joint.
    fn frame(&self, chain: &Chain, held: &JointValues, u: &Vector) -> (Vector, Vector, Vector, Vector) {
        let first = self.rotary.first().copied();
        let mut wanted = *u;
        let mut start = 0;
        for (i, link) in chain.links.iter().enumerate() {
            if Some(link.joint) == first {
                start = i;
                break;
            }
            if link.rotary {
                wanted = link.pose(-held[link.joint]).vector(&wanted);
            }
        }
        let mut axes = [Vector::zeros(); 2];
        let mut tool: Vector = chain.spindle_at_zero.rotation.column(2).into();
        for link in chain.links[start..].iter().rev().filter(|l| l.rotary) {
            if let Some(k) = self.rotary.iter().position(|&j| j == link.joint) {
                if let Some(axis) = axes.get_mut(k) {
                    *axis = link.direction;
                }
            } else {
                let turn = link.pose(held[link.joint]);
                tool = turn.vector(&tool);
                axes[1] = turn.vector(&axes[1]);
            }
        }
        (axes[0], axes[1], tool, wanted)
    }

    /// Rotary angles that bring the tool axis into the unit vector `u` of K, with held joints at their
    /// present values.
    pub(crate) fn axis_angles(&self, chain: &Chain, held: &JointValues, u: &Vector) -> AxisAngles {
        if let Some(pair) = &self.pair {
            return pair.solve(u);
        }
        let (first, second, tool, wanted) = self.frame(chain, held, u);
        let none = || {
            let error = tool.cross(&wanted).norm().atan2(tool.dot(&wanted));
            AxisAngles { count: 1, error, ..AxisAngles::default() }
        };
        match self.rotary.len() {
            0 => none(),
            1 => solve_single(&first, &tool, &wanted),
            _ => AxisPair::new(first, second, tool).map_or_else(none, |pair| pair.solve(&wanted)),
        }
    }

    /// Angle between a tool axis and the nearest singular one.
    pub(crate) fn cone_angle(&self, chain: &Chain, u: &Vector) -> Option<f64> {
        if self.rotary.len() != 2 {
            return None;
        }
        let (first, second, tool, wanted) = self.frame(chain, &self.home, u);
        Some(AxisPair::new(first, second, tool)?.cone_angle(&wanted))
    }

    /// The pair of rotary axes with held joints where `held` has them, if there are exactly two.
    pub(crate) fn pair(&self, chain: &Chain, held: &JointValues) -> Option<AxisPair> {
        if self.rotary.len() != 2 {
            return None;
        }
        if self.pair.is_some() {
            return self.pair;
        }
        let (first, second, tool, _) = self.frame(chain, held, &Vector::z());
        AxisPair::new(first, second, tool)
    }

    /// A direction of K as the pair sees it: turned back by the held rotary joints on the table's side.
    pub(crate) fn seen_by_pair(&self, chain: &Chain, held: &JointValues, u: &Vector) -> Vector {
        self.frame(chain, held, u).3
    }

    /// The way back of [`Self::seen_by_pair`].
    pub(crate) fn seen_from_outside(&self, chain: &Chain, held: &JointValues, v: &Vector) -> Vector {
        let first = self.rotary.first().copied();
        let before = chain.links.iter().take_while(|l| Some(l.joint) != first).filter(|l| l.rotary);
        let before: Vec<&ChainLink> = before.collect();
        before.iter().rev().fold(*v, |v, link| link.pose(held[link.joint]).vector(&v))
    }

    /// Sets the linear joints of `q` so that the tip comes to `tip`; returns the distance that is left, mm.
    pub(crate) fn place_tip(&self, chain: &Chain, q: &mut JointValues, tip: &Point, tool_length: f64) -> f64 {
        if let Some(block) = &self.block {
            let offset = block.offset(chain, q, tip, tool_length, &self.linear);
            let values = block.joints_from_offset * offset;
            for (&j, value) in self.linear.iter().zip(values.iter()) {
                q[j] = *value;
            }
            return 0.0;
        }
        let (at_zero, columns) = chain.linear_columns(q, tool_length, &self.linear);
        if self.linear.len() > 3 {
            return self.place_redundantly(q, &(tip - at_zero), &columns);
        }
        let column = |k: usize| self.linear.get(k).map_or_else(Vector::zeros, |&j| columns[j]);
        let matrix = Matrix3::from_columns(&[column(0), column(1), column(2)]);
        if matrix.determinant().abs() > FLAT_DETERMINANT
            && let Some(inverse) = matrix.try_inverse()
        {
            let values = inverse * (tip - at_zero);
            for (&j, value) in self.linear.iter().zip(values.iter()) {
                q[j] = *value;
            }
            return 0.0;
        }
        // Fewer than three directions: the smallest motion from the given values that comes nearest.
        let given = Vector::from_fn(|k, _| self.linear.get(k).map_or(0.0, |&j| q[j]));
        let missing = tip - at_zero - matrix * given;
        let Ok(pseudo) = matrix.pseudo_inverse(FLAT_DETERMINANT) else { return missing.norm() };
        let step: Vector = pseudo * missing;
        for (k, &j) in self.linear.iter().enumerate() {
            q[j] += step[k];
        }
        (missing - matrix * step).norm()
    }
}

impl Solver {
    /// More slides than three: the smallest motion from the given values.
    fn place_redundantly(&self, q: &mut JointValues, wanted: &Vector, columns: &[Vector; MAX_JOINTS]) -> f64 {
        let reached: Vector = self.linear.iter().map(|&j| columns[j] * q[j]).sum();
        let missing = wanted - reached;
        let normal: Matrix3<f64> = self.linear.iter().map(|&j| columns[j] * columns[j].transpose()).sum();
        let Ok(pseudo) = normal.pseudo_inverse(FLAT_DETERMINANT) else { return missing.norm() };
        let pull = pseudo * missing;
        let mut left = missing;
        for &j in &self.linear {
            let step = columns[j].dot(&pull);
            q[j] += step;
            left -= columns[j] * step;
        }
        left.norm()
    }
}

impl LinearBlock {
    fn new(chain: &Chain, linear: &[usize]) -> Option<Self> {
        let is_free = |link: &ChainLink| linear.contains(&link.joint);
        let first = chain.links.iter().position(is_free)?;
        let last = chain.links.iter().rposition(is_free)?;
        if linear.len() != 3 || chain.links[first..=last].iter().any(|l| l.rotary) {
            return None;
        }
        let mut directions = chain.links[first..=last].iter().filter(|l| is_free(l)).map(|l| l.direction);
        let mut next = || directions.next().unwrap_or_default();
        let matrix = Matrix3::from_columns(&[next(), next(), next()]);
        let flat = matrix.determinant().abs() <= FLAT_DETERMINANT;
        let joints_from_offset = matrix.try_inverse().filter(|_| !flat)?;
        Some(Self { first, last, joints_from_offset })
    }

    /// What the three joints together must add, in the frame that they slide in: the wanted tip is carried
    /// through the links on the table side, the tip at zero through those on the tool side.
    fn offset(&self, chain: &Chain, q: &JointValues, tip: &Point, tool_length: f64, linear: &[usize]) -> Vector {
        let mut wanted = *tip;
        for link in &chain.links[..self.first] {
            wanted = link.moved_back(&wanted, q[link.joint]);
        }
        let s0 = &chain.spindle_at_zero;
        let mut reached = Point::from(s0.translation - s0.rotation.column(2) * tool_length);
        for link in chain.links[self.last + 1..].iter().rev() {
            reached = link.moved(&reached, q[link.joint]);
        }
        let between = chain.links[self.first..=self.last].iter().filter(|l| !linear.contains(&l.joint));
        let held = between.fold(Vector::zeros(), |sum, l| sum + l.direction * q[l.joint]);
        wanted - reached - held
    }
}
