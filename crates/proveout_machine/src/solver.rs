//! Joint values for a pose along a chain: rotary joints from the tool axis, slides from the tip.

use nalgebra::Matrix3;
use proveout_geom::{Point, Vector};

use crate::{
    Joint, JointValues,
    axis_pair::{AxisAngles, AxisPair, solve_single},
    chain::{Chain, Link},
};

/// What the inverse kinematics can compute ahead for a chain.
#[derive(Clone, Debug)]
pub(crate) struct Solver {
    /// Joints that turn the tool, from the table to the tool; at most two.
    rotary: Vec<usize>,
    /// Linear joints that place the tip; at most three.
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

/// Determinant of three unit directions below which they count as lying in a plane; they are then solved in the sense
/// of least squares.
const FLAT_DETERMINANT: f64 = 1e-9;

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

    /// Held joints.
    pub(crate) fn held(&self) -> &[usize] {
        &self.held
    }

    /// Home of every joint, where held joints stand unless told otherwise.
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

    /// First and second rotary axis and tool axis, each with the held joints between it and the first rotary joint
    /// applied, and the wanted axis seen from before the first rotary joint.
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

    /// Rotary angles that bring the tool axis into the unit vector `u` of K, with held joints where they stand.
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

impl LinearBlock {
    fn new(chain: &Chain, linear: &[usize]) -> Option<Self> {
        let is_free = |link: &Link| linear.contains(&link.joint);
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

    /// What the three joints together must add, in the frame that they slide in: the wanted tip is carried through the
    /// links on the table side, the tip at zero through those on the tool side.
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
