//! Two rotary joints as angles of the tool axis: one about a fixed direction of the frame of the run, one
//! that inclines the axis to it.
//!
//! Of two rotary joints the one nearer to the workpiece, the *turn*, moves the tool axis on a circle about a
//! direction of the frame of the run that never changes; the other, the *tilt*, decides which circle it is:
//!
//! ```text
//!   V(turn, tilt) = R(pole, turn) V(0, tilt)
//! ```
//!
//! That holds for tables, trunnions, heads and what is between them, at right angles or not. The pole is
//! found from three positions.

use std::f64::consts::{PI, TAU};

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, KinematicsError, Machine};

use super::super::super::{CuttingRun, RescheduleError};

/// Turn and tilt, radian.
pub(super) type Angles = [f64; 2];

/// Axes that agree within this are the same, radian.
const SAME: f64 = 1e-9;
/// Turns that differ by more than this from those that follow from the poses must be written out,
/// radian.
const TOLD: f64 = 1e-7;
/// Three axes whose steps span less than this lie on no circle.
const IN_LINE: f64 = 1e-3;

pub(super) struct TwoJoints<'a> {
    machine: &'a Machine,
    joints: [usize; 2],
    /// Two directions across the pole, and the pole: the axis turns about it right-handed as the turn grows.
    pub(super) basis: [Vector; 3],
}

impl<'a> TwoJoints<'a> {
    /// None for a machine that has not two rotary joints, or whose joints do not move the axis so.
    pub(super) fn new(machine: Option<&'a Machine>) -> Option<Self> {
        let machine = machine?;
        let &[turn, tilt] = machine.rotary_joints() else { return None };
        let mut made = Self { machine, joints: [turn, tilt], basis: [Vector::x(), Vector::y(), Vector::z()] };
        let pole = [0.4, 1.1, -0.7].into_iter().find_map(|tilt| {
            let [a, b, c] = [0.0, 1.0, 2.0].map(|turn| made.axis([turn, tilt]));
            (b - a).cross(&(c - b)).try_normalize(IN_LINE)
        })?;
        let helper = if pole.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
        let u = (helper - pole * helper.dot(&pole)).normalize();
        made.basis = [u, pole.cross(&u), pole];
        let holds = [[0.3, 1.0], [-0.8, 0.4], [1.1, -2.0], [-2.5, 0.1]].into_iter().all(|[turn, tilt]| {
            let [x, y, z] = made.basis.map(|b| b.dot(&made.axis([0.0, tilt])));
            let (s, c) = f64::sin_cos(turn);
            let turned = made.basis[0] * (x * c - y * s) + made.basis[1] * (x * s + y * c) + made.basis[2] * z;
            (turned - made.axis([turn, tilt])).norm() < SAME
        });
        holds.then_some(made)
    }

    pub(super) fn values(&self, q: Angles) -> JointValues {
        let mut all = self.machine.home();
        for (joint, value) in self.joints.iter().zip(q) {
            all[*joint] = value;
        }
        all
    }

    /// Turn and tilt among positions of all joints.
    pub(super) fn of(&self, q: &JointValues) -> Angles {
        self.joints.map(|j| q[j])
    }

    pub(super) fn axis(&self, q: Angles) -> Vector {
        self.machine.forward(&self.values(q), 0.0).axis
    }

    /// Velocity and acceleration that a joint may have, rad/s and rad/s2; infinite where the
    /// machine gives none.
    pub(super) fn limits(&self, which: usize) -> [f64; 2] {
        let joint = &self.machine.joints[self.joints[which]];
        [joint.max_velocity, joint.max_acceleration].map(|l| l.filter(|v| *v > 0.0).unwrap_or(f64::INFINITY))
    }

    /// Travel of a joint; the tilt is looked at for one turn at most.
    pub(super) fn travel(&self, which: usize) -> Option<[f64; 2]> {
        self.machine.joints[self.joints[which]].travel
    }

    fn nearest(&self, axis: &Vector, near: &JointValues) -> Result<JointValues, KinematicsError> {
        let pose = ToolPose { tip: Point::origin(), axis: *axis };
        match self.machine.inverse_nearest(&pose, 0.0, near) {
            Ok(solution) => Ok(solution.q),
            // Slides depend on the length of the tool and are judged when the program runs.
            Err(KinematicsError::OverTravel { rotary: false, solution, .. }) => Ok(solution.q),
            Err(e) => Err(e),
        }
    }

    /// Turn and tilt of the axes of a run as a control goes through them.
    ///
    /// # Errors
    /// `reschedule-range`: an axis that the joints do not reach, with its block.
    pub(super) fn course<'v>(
        &self,
        run: &CuttingRun,
        axes: impl Iterator<Item = &'v Vector>,
    ) -> Result<Vec<Angles>, RescheduleError> {
        let mut q = self.machine.home();
        let mut course = Vec::with_capacity(run.blocks.len());
        for (axis, block) in axes.zip(&run.blocks) {
            q = self.nearest(axis, &q).map_err(|e| {
                let help = "turn the part on the table, or take a machine with a wider range";
                RescheduleError::new("reschedule-range", block.line, format!("out of reach: {e}"), help)
            })?;
            course.push(self.joints.map(|j| q[j]));
        }
        Ok(course)
    }

    /// All turns and tilts of an axis within ranges: both branches, whole turns apart.
    pub(super) fn all(&self, axis: &Vector, [turns, tilts]: [[f64; 2]; 2]) -> Vec<Angles> {
        let pose = ToolPose { tip: Point::origin(), axis: *axis };
        let mut out = Vec::new();
        for branch in self.machine.inverse(&pose, 0.0).iter() {
            let [turn, tilt] = self.joints.map(|j| branch.q[j]);
            let whole = |value: f64, [low, high]: [f64; 2]| {
                let from = ((low - SAME - value) / TAU).ceil() as i64;
                let to = ((high + SAME - value) / TAU).floor() as i64;
                (from..=to).map(move |k| value + TAU * k as f64)
            };
            for tilt in whole(tilt, tilts) {
                out.extend(whole(turn, turns).map(|turn| [turn, tilt]));
            }
        }
        out
    }

    /// Whether a control that is given axes alone takes other turns and tilts than these.
    pub(super) fn must_be_told(&self, angles: &[Angles]) -> bool {
        let mut q = self.machine.home();
        let mut last: Option<Angles> = None;
        for (i, wanted) in angles.iter().enumerate() {
            let Ok(next) = self.nearest(&self.axis(*wanted), &q) else { return true };
            let here = self.joints.map(|j| next[j]);
            let off = match (last, i.checked_sub(1).and_then(|k| angles.get(k))) {
                // Where the row begins only whole turns of the turn may be off.
                (Some(last), Some(before)) => {
                    [0, 1].map(|k| (here[k] - last[k]) - (wanted[k] - before[k])).into_iter().fold(0.0, larger)
                }
                _ => {
                    let turn = here[0] - wanted[0];
                    larger(turn - TAU * (turn / TAU).round(), here[1] - wanted[1])
                }
            };
            if off > TOLD {
                return true;
            }
            (q, last) = (next, Some(here));
        }
        false
    }
}

fn larger(a: f64, b: f64) -> f64 {
    a.abs().max(b.abs())
}

/// The range of the tilt that is looked at.
pub(super) fn one_turn(travel: Option<[f64; 2]>) -> [f64; 2] {
    let [low, high] = travel.unwrap_or([-PI, PI]);
    [low.max(-PI), high.min(PI)]
}
