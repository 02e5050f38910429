//! Schedules of a method that knows no channel of one angle: axes no farther from those of the program before
//! than the method has gone.

use proveout_geom::{ToolPose, Vector};
use proveout_machine::{Carries, JointValues, Machine};
use proveout_reschedule::{AxisPair, Caps};

/// Axes that move by less than this are those of the program before, radian.
const MOVED: f64 = 1e-6;
/// What eight decimals of a tool vector and five of a joint may be off, radian.
const ROUNDED: f64 = 2e-7;
/// How near the axis of a pair must be to that of the machine.
const SAME: f64 = 1e-9;

/// All schedules whose tool axes stay near those of the program before, with both rotary joints free.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoAngles {
    /// Names of the inner and the outer joint.
    pub names: [String; 2],
    /// The joints.
    pub pair: AxisPair,
    /// The farthest that the method has turned an axis, radian.
    pub stray: f64,
    /// The axes at each gate: within [`Self::stray`], widened by what the control may leave both joints by.
    pub caps: Caps,
    /// Positions of both joints at the gates in the program before.
    pub before: Vec<[f64; 2]>,
    /// The same of the new program.
    pub after: Vec<[f64; 2]>,
}

impl TwoAngles {
    /// Of poses at the gates with their joints; none where the machine has not two rotary joints with
    /// velocity limits, or no axis moves.
    pub(super) fn new(
        machine: &Machine,
        [before, after]: [&[ToolPose]; 2],
        [old, new]: [&[JointValues]; 2],
        rounding: f64,
    ) -> Option<Self> {
        let &[outer, inner] = machine.rotary_joints() else { return None };
        let apart = |a: &Vector, b: &Vector| a.cross(b).norm().atan2(a.dot(b));
        let stray = before.iter().zip(after).map(|(b, a)| apart(&b.axis, &a.axis)).fold(0.0, f64::max);
        if stray < MOVED {
            return None;
        }
        // The axis as the table sees it: joints that carry the workpiece turn it the other way.
        let direction = |j: usize| {
            let joint = &machine.joints[j];
            let sense = if joint.carries == Carries::Workpiece { -joint.sense } else { joint.sense };
            joint.direction * sense
        };
        let at = |values: [f64; 2]| {
            let mut q = machine.home();
            (q[inner], q[outer]) = (values[0], values[1]);
            machine.forward(&q, 0.0).axis
        };
        let turn = std::f64::consts::PI;
        let pair = AxisPair {
            inner: direction(inner),
            outer: direction(outer),
            zero: at([0.0; 2]),
            travel: machine.joints[inner].travel.unwrap_or([-turn, turn]),
            velocity: [machine.joints[inner].max_velocity?, machine.joints[outer].max_velocity?],
        };
        // More than two turning links between table and tool, or one that moves in another way: not a pair.
        let tried = [[0.3, -0.7], [-0.4, 2.0], [1.0, 0.5]];
        if tried.iter().any(|values| (pair.axis(*values) - at(*values)).norm() > SAME) {
            return None;
        }
        let values = |all: &[JointValues]| all.iter().map(|q| [q[inner], q[outer]]).collect::<Vec<_>>();
        Some(Self {
            names: [inner, outer].map(|j| machine.joints[j].name.clone()),
            pair,
            stray,
            caps: Caps { middles: before.iter().map(|p| p.axis).collect(), radius: stray + 2.0 * rounding + ROUNDED },
            before: values(old),
            after: values(new),
        })
    }
}
