use std::{f64::consts::TAU, ops::Deref};

use proveout_geom::{Point, ToolPose, Vector};
use thiserror::Error;

use crate::{Joint, JointValues, Machine, axis_pair::SINGULAR_ANGLE, joint::TRAVEL_TOLERANCE};

/// Largest angle (radian) between the wanted and the reached tool axis for a pose to count as reached: 1e-6
/// rad is 0.2 arc second and admits axes that were written with six digits on the edge of what a machine
/// reaches.
pub const AXIS_TOLERANCE: f64 = 1e-6;
/// A shorter tool axis has no direction.
const SHORTEST: f64 = 1e-9;

/// Largest distance (mm) between the wanted and the reached tip; it only matters for machines whose linear
/// joints do not span space.
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
    /// Distance between wanted and reached tip, mm: zero in closed form, the residual of a numerical
    /// solution.
    pub tip_error: f64,
    /// Angle between wanted and reached tool axis, radian.
    pub axis_error: f64,
    /// The position that [`Machine::inverse_chosen`] was asked for is out of travel, and this is the other
    /// one.
    pub other: bool,
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
    /// A joint would pass its travel in every branch. The branch nearest to the previous position is
    /// reported.
    #[error("joint {name} would be at {}, its limit is {}", shown(*value, *rotary), shown(*limit, *rotary))]
    OverTravel {
        /// Index of the joint.
        joint: usize,
        /// Its name.
        name: String,
        /// Whether value and limit are radian.
        rotary: bool,
        /// Position that the joint would need, mm or radian.
        value: f64,
        /// The limit, mm or radian.
        limit: f64,
        /// The joint values with the violation in them, so that a report can go on.
        solution: Box<Solution>,
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

impl Machine {
    /// All joint values that bring the tip of a tool of `tool_length` (mm) into a pose in the table frame K.
    ///
    /// The rotary joints follow from the tool axis in closed form, the linear joints from the tip. Order of
    /// the branches: of the two rotary joints let the second be the one nearer to the tool (along the chain
    /// from the table over the base to the spindle); branch 0 has the larger cosine of the second angle, thus
    /// the smaller tilt, and where both tilts are equal and opposite it has the positive one. At a singular
    /// pose there is one branch.
    ///
    /// Travel is not checked; held joints are at home. If the axis cannot be reached, there are no branches
    /// and [`Branches::axis_error`] gives the remaining angle. A pose that is not finite gives no branches
    /// and an infinite error.
    ///
    /// ```
    /// use proveout_geom::rad;
    /// use proveout_machine::Machine;
    ///
    /// let machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
    /// let [b, c] = ["B", "C"].map(|name| machine.joint(name).expect("a joint of this machine"));
    /// let mut q = machine.home();
    /// (q[b], q[c]) = (rad(30.0), rad(40.0));
    /// // B30 C40 and B-30 C-140 point the tool alike.
    /// let branches = machine.inverse(&machine.forward(&q, 120.0), 120.0);
    /// assert_eq!(branches.len(), 2);
    /// assert!(branches.iter().any(|branch| (branch.q - q).max_abs() < 1e-9)); // mm, radian
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inverse(&self, pose_in_table: &ToolPose, tool_length: f64) -> Branches {
        let all = self.inverse_closest(pose_in_table, tool_length);
        let reached = all.axis_error <= AXIS_TOLERANCE;
        Branches { count: if reached { all.count } else { 0 }, ..all }
    }

    /// As [`Machine::inverse`], yet with the nearest tool axis where the wanted one cannot be reached, as on
    /// machines with fewer than two rotary joints; each branch carries its errors.
    pub fn inverse_closest(&self, pose_in_table: &ToolPose, tool_length: f64) -> Branches {
        self.branches(pose_in_table, tool_length, self.solver.home())
    }

    fn branches(&self, pose: &ToolPose, tool_length: f64, given: &JointValues) -> Branches {
        let finite = pose.tip.iter().chain(pose.axis.iter()).all(|v| v.is_finite()) && tool_length.is_finite();
        let axis = pose.axis.try_normalize(SHORTEST).filter(|_| finite);
        let Some(axis) = axis else { return Branches { axis_error: f64::INFINITY, ..Branches::default() } };
        if !self.solver.has_closed_form() {
            return self.numerical_branch(pose, &axis, tool_length, given);
        }
        let found = self.solver.axis_angles(&self.chain, given, &axis);
        let mut result = Branches { count: found.count, axis_error: found.error, ..Branches::default() };
        let free_joint = self.solver.rotary().first().copied().filter(|_| found.free_first);
        for (index, branch) in result.items.iter_mut().enumerate().take(found.count) {
            let mut q = JointValues::ZERO;
            // With more than three slides, each moves as little as possible from its current position.
            let redundant = self.solver.linear().iter().filter(|_| self.solver.linear().len() > 3);
            for &j in self.solver.held().iter().chain(redundant) {
                q[j] = given[j];
            }
            for (&j, angle) in self.solver.rotary().iter().zip(found.angles[index]) {
                q[j] = angle;
            }
            let tip_error = self.solver.place_tip(&self.chain, &mut q, &pose.tip, tool_length);
            *branch = Branch { q, index, singular: found.singular, free_joint, axis_error: found.error, tip_error };
        }
        result
    }

    /// The one solution of a machine with more than two moving rotary joints: the nearest to the given
    /// values.
    fn numerical_branch(&self, pose: &ToolPose, axis: &Vector, tool_length: f64, given: &JointValues) -> Branches {
        let mut q = *given;
        let axis_error = self.solver.turn_numerically(&self.chain, &self.joints, &mut q, axis);
        let tip_error = self.solver.place_tip(&self.chain, &mut q, &pose.tip, tool_length);
        let singular = self.smallest_axis_rate(&q).is_some_and(|rate| rate < SINGULAR_ANGLE);
        let branch = Branch { q, index: 0, singular, free_joint: None, axis_error, tip_error };
        Branches { items: [branch, Branch::default()], count: 1, axis_error }
    }

    /// True where inverse kinematics is in closed form: at most two rotary joints that are not held. Else it
    /// is numerical: the smallest motion of the rotary joints from the previous position (from home for
    /// [`Machine::inverse`]), one branch, with the residual in its errors.
    pub fn has_closed_form(&self) -> bool {
        self.solver.has_closed_form()
    }

    /// The joint values for a pose that continue a motion from `previous`.
    ///
    /// Each branch is unwrapped to the turn nearest to `previous` that its travel admits; of the branches
    /// whose rotary joints stay within travel the one with the least |d r1| + |d r2| is taken, on a tie the
    /// lower branch. Where the pose leaves a rotary joint free it keeps its previous value. Held joints stay
    /// where `previous` has them.
    ///
    /// ```
    /// use proveout_geom::{Point, ToolPose, Vector, deg};
    /// use proveout_machine::Machine;
    ///
    /// let machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
    /// let [x, z, b] = ["X", "Z", "B"].map(|name| machine.joint(name).expect("it has this joint"));
    /// // A tool of 120 mm along X of the table, 20 mm below the axis of B at 120 mm.
    /// let pose = ToolPose { tip: Point::new(0.0, 0.0, 100.0), axis: Vector::x() };
    /// let found = machine.inverse_nearest(&pose, 120.0, &machine.home())?;
    /// assert!((deg(found.q[b]) - 90.0).abs() < 1e-9);
    /// assert!((found.q[x] - 20.0).abs() < 1e-9 && (found.q[z] - 240.0).abs() < 1e-9); // mm
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`KinematicsError`]: the axis is out of reach, or a joint would pass its travel. Linear travel is
    /// tested on the chosen branch only: a control does not turn the tool over because a slide ends.
    pub fn inverse_nearest(
        &self,
        pose_in_table: &ToolPose,
        tool_length: f64,
        previous: &JointValues,
    ) -> Result<Solution, KinematicsError> {
        self.inverse_by(pose_in_table, tool_length, previous, None)
    }

    /// As [`Machine::inverse_nearest`], but of two branches the one with the lower (or higher) angle of a
    /// rotary joint; where its rotary joints pass their travel, the other one ([`Solution::other`]). An
    /// endless joint is compared within a turn, from -180 to 180 degrees.
    ///
    /// # Errors
    /// As [`Machine::inverse_nearest`].
    pub fn inverse_chosen(
        &self,
        pose_in_table: &ToolPose,
        tool_length: f64,
        previous: &JointValues,
        (joint, higher): (usize, bool),
    ) -> Result<Solution, KinematicsError> {
        self.inverse_by(pose_in_table, tool_length, previous, Some((joint, higher)))
    }

    fn inverse_by(
        &self,
        pose_in_table: &ToolPose,
        tool_length: f64,
        previous: &JointValues,
        wanted: Option<(usize, bool)>,
    ) -> Result<Solution, KinematicsError> {
        let branches = self.branches(pose_in_table, tool_length, previous);
        if branches.axis_error == f64::INFINITY {
            let ToolPose { tip, axis } = pose_in_table;
            return Err(KinematicsError::NotFinite { tip: tip.coords.into(), axis: (*axis).into() });
        }
        if branches.axis_error > AXIS_TOLERANCE {
            return Err(KinematicsError::AxisUnreachable { angle: branches.axis_error });
        }
        let mut best: Option<(bool, f64, f64, Solution)> = None;
        // The rank of the branch that the choice alone would take.
        let mut first = f64::INFINITY;
        for branch in branches.iter() {
            let mut q = branch.q;
            let mut inside = true;
            let mut distance = 0.0;
            for &j in self.solver.rotary() {
                let free = branch.free_joint == Some(j);
                let angle = if free { previous[j] } else { q[j] };
                let placed = unwrapped(&self.joints[j], angle, previous[j]);
                inside &= self.joints[j].travel_violation(placed).is_none();
                distance += (placed - previous[j]).abs();
                q[j] = placed;
            }
            let rank = wanted.map_or(0.0, |(joint, higher)| {
                let angle = if self.joints[joint].travel.is_some() { q[joint] } else { branch.q[joint] };
                if higher { -angle } else { angle }
            });
            first = first.min(rank);
            let better = best.is_none_or(|(was_inside, was_rank, was, _)| {
                let same = (rank - was_rank).abs() <= TRAVEL_TOLERANCE;
                (inside && !was_inside)
                    || (inside == was_inside && ((!same && rank < was_rank) || (same && distance < was)))
            });
            if better {
                best = Some((
                    inside,
                    rank,
                    distance,
                    Solution {
                        q,
                        branch: branch.index,
                        singular: branch.singular,
                        tip_error: 0.0,
                        axis_error: branch.axis_error,
                        other: false,
                    },
                ));
            }
        }
        let Some((_, rank, _, mut solution)) = best else {
            return Err(KinematicsError::AxisUnreachable { angle: branches.axis_error });
        };
        let distance = self.solver.place_tip(&self.chain, &mut solution.q, &pose_in_table.tip, tool_length);
        solution.tip_error = distance;
        solution.other = rank > first + TRAVEL_TOLERANCE;
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
                solution: Box::new(solution),
            }),
        }
    }

    /// The linear joints that bring the tip to a point of the table frame K while the rotary (and held)
    /// joints keep their values in `rotary`: tool center point control with programmed rotary axes.
    ///
    /// On machines whose linear joints do not span space the tip comes as near as it can; compare with
    /// [`Machine::forward`].
    pub fn inverse_with_rotary(&self, tip_in_table: &Point, rotary: &JointValues, tool_length: f64) -> JointValues {
        let mut q = *rotary;
        self.solver.place_tip(&self.chain, &mut q, tip_in_table, tool_length);
        q
    }

    /// First joint outside its travel, rotary ones first, and the limit that it passes.
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
pub(crate) fn unwrapped(joint: &Joint, angle: f64, previous: f64) -> f64 {
    let turns = ((previous - angle) / TAU).round();
    let Some([low, high]) = joint.travel else { return angle + TAU * turns };
    let least = ((low - TRAVEL_TOLERANCE - angle) / TAU).ceil();
    let most = ((high + TRAVEL_TOLERANCE - angle) / TAU).floor();
    if least <= most { angle + TAU * turns.clamp(least, most) } else { angle + TAU * turns }
}
