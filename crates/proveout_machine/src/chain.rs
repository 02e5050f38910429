//! The machine as one chain of screws from the table to the spindle.
//!
//! ```text
//!   K (table) <- work joints, last first -> M (base) <- tool joints, first first -> S (gauge line) -> T (tip)
//!
//!   table_from_spindle(q) = Wn^-1 ... W1^-1  T1 ... Tm  S0          all in M at zero
//! ```
//!
//! With every joint given by its line in M at zero, the pose is a product of exponentials (Brockett 1984; Lynch and
//! Park 2017, section 4.1): no frames between the joints are needed. A work joint enters with the opposite sign, since
//! its motion is undone. Each factor then is a slide or turn by the joint value about a signed direction, and the
//! chain is handled alike whatever is on which side.

use proveout_geom::{Point, Pose, ToolPose, Vector, sin_cos};

use crate::{Carries, Joint, JointKind, JointValues, MAX_JOINTS};

/// One joint in the chain, sign applied: a positive joint value moves what is nearer to the tool by +value about
/// `direction`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) joint: usize,
    pub(crate) rotary: bool,
    pub(crate) direction: Vector,
    pub(crate) point: Point,
}

/// The links in order from the table to the spindle.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub(crate) links: Vec<Link>,
    /// Gauge line in M at zero, `machine_from_spindle`.
    pub(crate) spindle_at_zero: Pose,
}

/// Turns the vector by the angle with the given sine and cosine about a unit direction (Rodrigues 1840).
fn turned(v: &Vector, direction: &Vector, (s, c): (f64, f64)) -> Vector {
    v * c + direction.cross(v) * s + direction * (direction.dot(v) * (1.0 - c))
}

impl Link {
    fn new(joint: usize, data: &Joint) -> Self {
        let sign = if data.carries == Carries::Tool { data.sense } else { -data.sense };
        Self { joint, rotary: data.kind == JointKind::Rotary, direction: data.direction * sign, point: data.point }
    }

    /// Where a point goes when the joint moves to a value.
    pub(crate) fn moved(&self, p: &Point, value: f64) -> Point {
        if self.rotary {
            self.point + turned(&(p - self.point), &self.direction, sin_cos(value))
        } else {
            p + self.direction * value
        }
    }

    /// The motion at a joint value.
    pub(crate) fn pose(&self, value: f64) -> Pose {
        if self.rotary {
            Pose::about_line(&self.point, &self.direction, value)
        } else {
            Pose::from_translation(self.direction * value)
        }
    }
}

impl Chain {
    pub(crate) fn new(joints: &[Joint], tool_chain: &[usize], work_chain: &[usize], spindle_at_zero: Pose) -> Self {
        let order = work_chain.iter().rev().chain(tool_chain);
        Self { links: order.map(|&j| Link::new(j, &joints[j])).collect(), spindle_at_zero }
    }

    /// Tip and axis in K: the two are carried through the links from the tool to the table, which costs two turned
    /// vectors a rotary joint and no matrix.
    pub(crate) fn forward(&self, q: &JointValues, tool_length: f64) -> ToolPose {
        let s0 = &self.spindle_at_zero;
        let mut axis: Vector = s0.rotation.column(2).into();
        let mut tip = Point::from(s0.translation - axis * tool_length);
        for link in self.links.iter().rev() {
            let value = q[link.joint];
            if link.rotary {
                let sc = sin_cos(value);
                axis = turned(&axis, &link.direction, sc);
                tip = link.point + turned(&(tip - link.point), &link.direction, sc);
            } else {
                tip += link.direction * value;
            }
        }
        ToolPose { tip, axis }
    }

    /// The tip in K with every linear joint that `free` names at zero, and the direction in K along which each linear
    /// joint moves it. The tip is linear in those joints whatever rotary joints stand between them.
    pub(crate) fn linear_columns(
        &self,
        q: &JointValues,
        tool_length: f64,
        free: &[usize],
    ) -> (Point, [Vector; MAX_JOINTS]) {
        let s0 = &self.spindle_at_zero;
        let mut tip = Point::from(s0.translation - s0.rotation.column(2) * tool_length);
        let mut columns = [Vector::zeros(); MAX_JOINTS];
        for link in self.links.iter().rev() {
            if link.rotary {
                let sc = sin_cos(q[link.joint]);
                tip = link.point + turned(&(tip - link.point), &link.direction, sc);
                for &j in free {
                    columns[j] = turned(&columns[j], &link.direction, sc);
                }
            } else if free.contains(&link.joint) {
                columns[link.joint] = link.direction;
            } else {
                tip += link.direction * q[link.joint];
            }
        }
        (tip, columns)
    }
}
