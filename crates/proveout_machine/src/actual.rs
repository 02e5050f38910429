//! The actual machine: the described one with its geometric errors.

use proveout_geom::{Point, Pose, ToolPose, Vector};

use crate::{
    ErrorOf, ErrorTable, Joint, JointValues, KinematicsError, MAX_JOINTS, Machine, Solution, TIP_TOLERANCE,
    errors::turn,
};

/// One joint with its errors.
#[derive(Clone, Debug)]
struct ActualJoint {
    /// Line or direction as they are.
    joint: Joint,
    /// Offset of the joint from its displayed position, mm or radian.
    offset: f64,
    table: Option<ErrorTable>,
}

/// Joints and gauge line of the actual machine.
#[derive(Clone, Debug)]
pub(crate) struct ActualChain {
    joints: Vec<ActualJoint>,
    gauge_pose: Pose,
}

impl ActualJoint {
    fn motion(&self, value: f64) -> Pose {
        let nominal = self.joint.motion(value + self.offset);
        let Some(table) = &self.table else { return nominal };
        let error = table.motion(value, self.joint.endless);
        if self.joint.is_rotary() { error * nominal } else { nominal * error }
    }
}

impl ActualChain {
    /// `None` when the machine has no errors.
    pub(crate) fn new(machine: &Machine) -> Option<Self> {
        if machine.errors.is_zero() {
            return None;
        }
        let of_joint = |(j, data): (usize, &Joint)| {
            let mut actual = ActualJoint { joint: data.clone(), offset: 0.0, table: None };
            for constant in machine.errors.constant.iter().filter(|c| c.of == ErrorOf::Joint(j)) {
                let (shift, rotation) = constant.parts();
                let d = data.direction;
                if data.is_rotary() {
                    actual.offset += d.dot(&rotation) * data.sense;
                    actual.joint.point += shift;
                } else {
                    actual.offset += d.dot(&shift) * data.sense;
                }
                let tilt = turn(&(rotation - d * d.dot(&rotation)));
                actual.joint.direction = tilt.vector(&d);
                actual.joint.turn_shift = data.turn_shift.map(|s| crate::TurnShift(tilt.vector(&s.0)));
            }
            actual.table = machine.errors.tables.iter().find(|t| t.joint == j).cloned();
            actual
        };
        let mut gauge_pose = machine.spindle.gauge_pose;
        for constant in machine.errors.constant.iter().filter(|c| c.of == ErrorOf::Spindle) {
            let (shift, rotation) = constant.parts();
            let translation = gauge_pose.translation + shift;
            gauge_pose = Pose { translation, ..turn(&rotation) * gauge_pose };
        }
        Some(Self { joints: machine.joints.iter().enumerate().map(of_joint).collect(), gauge_pose })
    }

    fn chain_pose(&self, chain: &[usize], q: &JointValues) -> Pose {
        let joints = chain.iter().filter_map(|&j| Some((self.joints.get(j)?, q[j])));
        joints.fold(Pose::identity(), |pose, (joint, value)| pose * joint.motion(value))
    }
}

/// Newton steps after which the compensation gives up: errors of a thousandth shrink the rest a thousandfold
/// each.
const COMPENSATION_STEPS: usize = 12;

/// What is left of tip (mm) and axis (radian) when the compensation is at its end: a tenth of what poses are
/// promised to, and a hundred times the rounding of levers of a meter.
const COMPENSATED_MM: f64 = 1e-10;
const COMPENSATED_RAD: f64 = 1e-13;

impl Machine {
    /// True when the actual machine differs from the described one.
    pub fn has_errors(&self) -> bool {
        self.actual.is_some()
    }

    /// Places between two positions of the joints at which a table of errors bends: the actual path has a
    /// kink there.
    pub fn error_bends(&self, from: &JointValues, to: &JointValues) -> usize {
        let tables = self.actual.iter().flat_map(|actual| actual.joints.iter().enumerate());
        tables.filter_map(|(j, joint)| Some(joint.table.as_ref()?.bends(from[j], to[j], joint.joint.endless))).sum()
    }

    /// Tip and axis in the table frame K as the machine with its geometric errors brings them; those of
    /// [`Machine::forward`], bit by bit, where there are no errors.
    pub fn actual_forward(&self, q: &JointValues, tool_length: f64) -> ToolPose {
        if self.actual.is_none() {
            return self.forward(q, tool_length);
        }
        let pose = self.actual_table_from_spindle(q);
        let axis: Vector = pose.rotation.column(2).into();
        ToolPose { tip: Point::from(pose.translation - axis * tool_length), axis }
    }

    /// Pose of the gauge line in the table frame K with the geometric errors.
    pub fn actual_table_from_spindle(&self, q: &JointValues) -> Pose {
        let Some(actual) = &self.actual else { return self.table_from_spindle(q) };
        let machine_from_table = actual.chain_pose(&self.work_chain, q);
        machine_from_table.inverse() * actual.chain_pose(&self.tool_chain, q) * actual.gauge_pose
    }

    /// Motion of everything that each joint carries, with the geometric errors, as
    /// [`Machine::joint_poses`].
    pub fn actual_joint_poses(&self, q: &JointValues) -> [Pose; MAX_JOINTS] {
        let Some(actual) = &self.actual else { return self.joint_poses(q) };
        let mut poses = [Pose::identity(); MAX_JOINTS];
        for chain in [&self.tool_chain, &self.work_chain] {
            let mut pose = Pose::identity();
            for &j in chain {
                if let Some(joint) = actual.joints.get(j) {
                    pose = pose * joint.motion(q[j]);
                }
                poses[j] = pose;
            }
        }
        poses
    }

    /// The joint values that bring the *actual* machine to a pose, continuous with `previous`: what a control
    /// with a complete volumetric compensation would command. Numerical, from the described machine's closed
    /// form.
    ///
    /// The wanted pose is corrected by the error found until nothing is left; each round shrinks the rest
    /// by the size of the errors. The residual is in [`Solution::tip_error`] and [`Solution::axis_error`].
    ///
    /// # Errors
    /// As [`Machine::inverse_nearest`]; [`KinematicsError::TipUnreachable`] and
    /// [`KinematicsError::AxisUnreachable`] also where the rest does not shrink, as next to a singular pose.
    pub fn actual_inverse_nearest(
        &self,
        pose_in_table: &ToolPose,
        tool_length: f64,
        previous: &JointValues,
    ) -> Result<Solution, KinematicsError> {
        let mut solution = self.inverse_nearest(pose_in_table, tool_length, previous)?;
        if self.actual.is_none() {
            return Ok(solution);
        }
        let rest = |q: &JointValues| {
            let reached = self.actual_forward(q, tool_length);
            (pose_in_table.tip - reached.tip, pose_in_table.axis - reached.axis)
        };
        let mut aim = *pose_in_table;
        let (mut tip, mut axis) = rest(&solution.q);
        for _ in 0..COMPENSATION_STEPS {
            if tip.norm() <= COMPENSATED_MM && axis.norm() <= COMPENSATED_RAD {
                break;
            }
            aim = ToolPose { tip: aim.tip + tip, axis: (aim.axis + axis).normalize() };
            let next = self.inverse_nearest(&aim, tool_length, &solution.q)?;
            let (next_tip, next_axis) = rest(&next.q);
            if next_tip.norm() >= tip.norm() && next_axis.norm() >= axis.norm() {
                break;
            }
            (solution, tip, axis) = (next, next_tip, next_axis);
        }
        (solution.tip_error, solution.axis_error) = (tip.norm(), axis.norm());
        if solution.tip_error > TIP_TOLERANCE {
            return Err(KinematicsError::TipUnreachable { distance: solution.tip_error });
        }
        if solution.axis_error > crate::AXIS_TOLERANCE {
            return Err(KinematicsError::AxisUnreachable { angle: solution.axis_error });
        }
        Ok(solution)
    }
}
