use std::{f64::consts::TAU, ops::Deref};

use nalgebra::Matrix3;
use proveout_geom::{Point, ToolPose, Vector};
use thiserror::Error;

use crate::{
    Joint, JointValues, MAX_JOINTS, Machine,
    axis_pair::{AxisAngles, AxisPair, solve_single},
    chain::Chain,
    joint::TRAVEL_TOLERANCE,
};

/// Largest angle (radian) between the wanted and the reached tool axis for a pose to count as reached: 1e-6 rad is
/// 0.2 arc second and admits axes that were written with six digits on the edge of what a machine reaches.
pub const AXIS_TOLERANCE: f64 = 1e-6;

/// Largest distance (mm) between the wanted and the reached tip; it only matters for machines whose linear joints do
/// not span space.
pub const TIP_TOLERANCE: f64 = 1e-6;

/// One set of joint values for a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Branch {
    /// Joint values; rotary joints in (-pi, pi], held joints where they are held.
    pub q: JointValues,
    /// Number of the branch, see [`Machine::inverse`].
    pub index: usize,
    /// A rotary joint is not determined by the pose, or two branches meet.
    pub singular: bool,
    /// Joint that the pose leaves free, given as zero.
    pub free_joint: Option<usize>,
    /// Angle between wanted and reached tool axis, radian.
    pub axis_error: f64,
    /// Distance between wanted and reached tip, mm.
    pub tip_error: f64,
}

/// Up to two branches, in a fixed order and without allocation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Branches {
    items: [Branch; 2],
    count: usize,
    /// Angle between the wanted tool axis and the nearest one that the machine reaches, radian. Above
    /// [`AXIS_TOLERANCE`] there are no branches.
    pub axis_error: f64,
}

impl Deref for Branches {
    type Target = [Branch];

    fn deref(&self) -> &[Branch] {
        &self.items[..self.count]
    }
}

/// The joint values chosen for a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Joint values, unwrapped within travel.
    pub q: JointValues,
    /// Number of the branch.
    pub branch: usize,
    /// A rotary joint is not determined by the pose and keeps its previous value, or two branches meet.
    pub singular: bool,
}

/// Why a machine cannot take a pose.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum KinematicsError {
    /// The rotary joints cannot point the tool there, limits apart.
    #[error("the tool axis is {:.6} degrees away from any that the machine reaches", angle.to_degrees())]
    AxisUnreachable {
        /// Angle to the nearest axis that is reached, radian.
        angle: f64,
    },
    /// The linear joints cannot bring the tip there, limits apart.
    #[error("the tip is {distance:.6} mm away from what the linear joints reach with this tool axis")]
    TipUnreachable {
        /// Distance, mm.
        distance: f64,
    },
    /// A joint would pass its travel in every branch. The branch nearest to the previous position is reported.
    #[error("joint {name} would stand at {} and its limit is {}", shown(*value, *rotary), shown(*limit, *rotary))]
    OverTravel {
        /// Index of the joint.
        joint: usize,
        /// Its name.
        name: String,
        /// Whether value and limit are radian.
        rotary: bool,
        /// Where it would stand, mm or radian.
        value: f64,
        /// The limit, mm or radian.
        limit: f64,
        /// The joint values with the violation in them, so that a report can go on.
        solution: Solution,
    },
    /// A number of the pose is not finite, or the axis has no length.
    #[error("the pose is not a number: tip {tip:?}, axis {axis:?}")]
    NotFinite {
        /// Tip, mm.
        tip: [f64; 3],
        /// Axis.
        axis: [f64; 3],
    },
}

fn shown(value: f64, rotary: bool) -> String {
    if rotary { format!("{:.6} degrees", value.to_degrees()) } else { format!("{value:.6} mm") }
}

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

    fn axis_angles(&self, chain: &Chain, held: &JointValues, u: &Vector) -> AxisAngles {
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
    fn place_tip(&self, chain: &Chain, q: &mut JointValues, tip: &Point, tool_length: f64) -> f64 {
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
        let is_free = |link: &crate::chain::Link| linear.contains(&link.joint);
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
            wanted = link.moved(&wanted, -q[link.joint]);
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

impl Machine {
    /// All joint values that bring the tip of a tool of `tool_length` (mm) into a pose in the table frame K.
    ///
    /// The rotary joints follow from the tool axis in closed form, the linear joints from the tip. Order of the
    /// branches: of the two rotary joints let the second be the one nearer to the tool (along the chain from the
    /// table over the base to the spindle); branch 0 has the larger cosine of the second angle, thus the smaller tilt,
    /// and where both tilts are equal and opposite it has the positive one. At a singular pose there is one branch.
    ///
    /// Travel is not looked at; held joints stand at home. When the axis cannot be reached there are no branches and
    /// [`Branches::axis_error`] tells by how much; a pose that is not finite gives none with an infinite error.
    pub fn inverse(&self, pose_in_table: &ToolPose, tool_length: f64) -> Branches {
        let all = self.inverse_closest(pose_in_table, tool_length);
        let reached = all.axis_error <= AXIS_TOLERANCE;
        Branches { count: if reached { all.count } else { 0 }, ..all }
    }

    /// As [`Machine::inverse`], yet with the nearest tool axis where the wanted one cannot be reached, as on machines with
    /// fewer than two rotary joints; each branch carries its errors.
    pub fn inverse_closest(&self, pose_in_table: &ToolPose, tool_length: f64) -> Branches {
        self.branches(pose_in_table, tool_length, &self.solver.home)
    }

    fn branches(&self, pose: &ToolPose, tool_length: f64, given: &JointValues) -> Branches {
        let finite = pose.tip.iter().chain(pose.axis.iter()).all(|v| v.is_finite()) && tool_length.is_finite();
        let axis = pose.axis.try_normalize(1e-9).filter(|_| finite);
        let Some(axis) = axis else { return Branches { axis_error: f64::INFINITY, ..Branches::default() } };
        let found = self.solver.axis_angles(&self.chain, given, &axis);
        let mut result = Branches { count: found.count, axis_error: found.error, ..Branches::default() };
        let free_joint = self.solver.rotary.first().copied().filter(|_| found.free_first);
        for (index, branch) in result.items.iter_mut().enumerate().take(found.count) {
            let mut q = JointValues::ZERO;
            for &j in &self.solver.held {
                q[j] = given[j];
            }
            for (&j, angle) in self.solver.rotary.iter().zip(found.angles[index]) {
                q[j] = angle;
            }
            let tip_error = self.solver.place_tip(&self.chain, &mut q, &pose.tip, tool_length);
            *branch =
                Branch { q, index, singular: found.singular, free_joint, axis_error: found.error, tip_error };
        }
        result
    }

    /// The joint values for a pose that continue a motion from `previous`.
    ///
    /// Each branch is unwrapped to the turn nearest to `previous` that its travel admits; of the branches whose rotary
    /// joints stay within travel the one with the least |d r1| + |d r2| is taken, on a tie the lower branch. Where the
    /// pose leaves a rotary joint free it keeps its previous value. Held joints stay where `previous` has them.
    ///
    /// # Errors
    /// [`KinematicsError`]: the axis is out of reach, or a joint would pass its travel. Linear travel is tested on the
    /// chosen branch only: a control does not turn the tool over because a slide ends.
    pub fn inverse_nearest(
        &self,
        pose_in_table: &ToolPose,
        tool_length: f64,
        previous: &JointValues,
    ) -> Result<Solution, KinematicsError> {
        let branches = self.branches(pose_in_table, tool_length, previous);
        if branches.axis_error == f64::INFINITY {
            let ToolPose { tip, axis } = pose_in_table;
            return Err(KinematicsError::NotFinite { tip: tip.coords.into(), axis: (*axis).into() });
        }
        if branches.axis_error > AXIS_TOLERANCE {
            return Err(KinematicsError::AxisUnreachable { angle: branches.axis_error });
        }
        let mut best: Option<(bool, f64, Solution)> = None;
        for branch in branches.iter() {
            let mut q = branch.q;
            let mut inside = true;
            let mut distance = 0.0;
            for &j in &self.solver.rotary {
                let free = branch.free_joint == Some(j);
                let angle = if free { previous[j] } else { q[j] };
                let placed = unwrapped(&self.joints[j], angle, previous[j]);
                inside &= self.joints[j].travel_violation(placed).is_none();
                distance += (placed - previous[j]).abs();
                q[j] = placed;
            }
            let better = best.is_none_or(|(was_inside, was, _)| (inside && !was_inside) || (inside == was_inside && distance < was));
            if better {
                best = Some((inside, distance, Solution { q, branch: branch.index, singular: branch.singular }));
            }
        }
        let Some((_, _, mut solution)) = best else {
            return Err(KinematicsError::AxisUnreachable { angle: branches.axis_error });
        };
        let distance = self.solver.place_tip(&self.chain, &mut solution.q, &pose_in_table.tip, tool_length);
        if distance > TIP_TOLERANCE {
            return Err(KinematicsError::TipUnreachable { distance });
        }
        match self.first_over_travel(&solution.q) {
            None => Ok(solution),
            Some((joint, limit)) => Err(KinematicsError::OverTravel {
                joint,
                name: self.joints[joint].name.clone(),
                rotary: self.joints[joint].is_rotary(),
                value: solution.q[joint],
                limit,
                solution,
            }),
        }
    }

    /// The linear joints that bring the tip to a point of the table frame K while the rotary (and held) joints stand
    /// where `rotary` has them: tool center point control with programmed rotary axes.
    ///
    /// On machines whose linear joints do not span space the tip comes as near as it can; compare with
    /// [`Machine::forward`].
    pub fn inverse_with_rotary(&self, tip_in_table: &Point, rotary: &JointValues, tool_length: f64) -> JointValues {
        let mut q = *rotary;
        self.solver.place_tip(&self.chain, &mut q, tip_in_table, tool_length);
        q
    }

    /// First joint, rotary ones first, that stands outside its travel, and the limit that it passes.
    pub fn first_over_travel(&self, q: &JointValues) -> Option<(usize, f64)> {
        let rotary = (0..self.joints.len()).filter(|&j| self.joints[j].is_rotary());
        let linear = (0..self.joints.len()).filter(|&j| !self.joints[j].is_rotary());
        rotary.chain(linear).find_map(|j| Some((j, self.joints[j].travel_violation(q[j])?)))
    }

    /// The two rotary joints (table side first) that inverse kinematics turns; fewer on machines with fewer.
    pub fn rotary_joints(&self) -> &[usize] {
        self.solver.rotary()
    }

    /// The linear joints that inverse kinematics moves.
    pub fn linear_joints(&self) -> &[usize] {
        self.solver.linear()
    }
}

/// The turn of `angle` nearest to `previous` within travel; nearest at all when no turn is within.
fn unwrapped(joint: &Joint, angle: f64, previous: f64) -> f64 {
    let turns = ((previous - angle) / TAU).round();
    let Some([low, high]) = joint.travel else { return angle + TAU * turns };
    let least = ((low - TRAVEL_TOLERANCE - angle) / TAU).ceil();
    let most = ((high + TRAVEL_TOLERANCE - angle) / TAU).floor();
    if least <= most { angle + TAU * turns.clamp(least, most) } else { angle + TAU * turns }
}

// The arrays of this module are indexed by joint numbers below MAX_JOINTS, which the reader checks.
const _: () = assert!(MAX_JOINTS >= 5);
