//! The machine as one chain of screws from the table to the spindle.
//!
//! ```text
//!   K (table) <- work joints, last first -> M (base) <- tool joints in order -> S (gauge line) -> T (tip)
//!
//!   table_from_spindle(q) = Wn^-1 ... W1^-1  T1 ... Tm  S0          all in M at zero
//! ```
//!
//! With every joint given by its line in M at zero, the pose is a product of exponentials (Brockett 1984;
//! Lynch and Park 2017, section 4.1): no frames between the joints are needed. A work joint enters with the
//! opposite sign, since its motion is undone. Each factor then is a slide or turn by the joint value about a
//! signed direction, and the chain is handled alike whatever is on which side. The tilt joint of a platform
//! shifts sideways as it turns ([`TurnShift`]): after the turn on the tool side, before the undone turn on
//! the work side.

use proveout_geom::{Point, Pose, ToolPose, Vector, sin_cos};

use crate::{Carries, Joint, JointKind, JointValues, MAX_JOINTS, TurnShift};

/// One joint in the chain, sign applied: a positive joint value moves what is nearer to the tool by +value
/// about `direction`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChainLink {
    pub(crate) joint: usize,
    pub(crate) rotary: bool,
    pub(crate) direction: Vector,
    pub(crate) point: Point,
    pub(crate) shift: Option<Shift>,
}

/// Sideways motion of a link.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift {
    motion: TurnShift,
    /// Work side: the shift is taken back before the turn is.
    undone: bool,
}

/// The links in order from the table to the spindle.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub(crate) links: Vec<ChainLink>,
    /// Gauge line in M at zero, `machine_from_spindle`.
    pub(crate) spindle_at_zero: Pose,
}

/// Turns the vector by the angle with the given sine and cosine about a unit direction (Rodrigues 1840).
fn turned(v: &Vector, direction: &Vector, (s, c): (f64, f64)) -> Vector {
    v * c + direction.cross(v) * s + direction * (direction.dot(v) * (1.0 - c))
}

impl ChainLink {
    fn new(joint: usize, data: &Joint) -> Self {
        let sign = if data.carries == Carries::Tool { data.sense } else { -data.sense };
        let undone = data.carries == Carries::Workpiece;
        Self {
            joint,
            rotary: data.kind == JointKind::Rotary,
            direction: data.direction * sign,
            point: data.point,
            shift: data.turn_shift.map(|motion| Shift { motion, undone }),
        }
    }

    /// Shifts before and after the turn.
    fn shifts(&self, value: f64) -> [Vector; 2] {
        match &self.shift {
            None => [Vector::zeros(); 2],
            Some(s) if s.undone => [-s.motion.at(value), Vector::zeros()],
            Some(s) => [Vector::zeros(), s.motion.at(value)],
        }
    }

    /// Where a point goes with a rotary link, whose sine and cosine are known.
    fn turned_point(&self, p: &Point, value: f64, sc: (f64, f64)) -> Point {
        if self.shift.is_none() {
            return self.point + turned(&(p - self.point), &self.direction, sc);
        }
        let [before, after] = self.shifts(value);
        self.point + turned(&(p + before - self.point), &self.direction, sc) + after
    }

    /// Where a point goes when the joint moves to a value.
    pub(crate) fn moved(&self, p: &Point, value: f64) -> Point {
        if !self.rotary {
            return p + self.direction * value;
        }
        self.turned_point(p, value, sin_cos(value))
    }

    /// Where a point came from that the joint has moved by its value.
    pub(crate) fn moved_back(&self, p: &Point, value: f64) -> Point {
        if !self.rotary {
            return p - self.direction * value;
        }
        let turn = |p: &Point| self.point + turned(&(p - self.point), &self.direction, sin_cos(-value));
        if self.shift.is_none() {
            return turn(p);
        }
        let [before, after] = self.shifts(value);
        turn(&(p - after)) - before
    }

    /// The motion at a joint value.
    pub(crate) fn pose(&self, value: f64) -> Pose {
        if !self.rotary {
            return Pose::from_translation(self.direction * value);
        }
        let turn = Pose::about_line(&self.point, &self.direction, value);
        if self.shift.is_none() {
            return turn;
        }
        let [before, after] = self.shifts(value);
        Pose { translation: turn.translation + turn.rotation * before + after, ..turn }
    }

    /// What the shift adds to the velocity of everything beyond the link for one radian per second, in the
    /// frame before it, when the turn is counted about the line at rest: after the turn the line itself has
    /// shifted.
    pub(crate) fn shift_rate(&self, value: f64) -> Vector {
        match &self.shift {
            None => Vector::zeros(),
            Some(s) if s.undone => turned(&-s.motion.rate(value), &self.direction, sin_cos(value)),
            Some(s) => s.motion.rate(value) - self.direction.cross(&s.motion.at(value)),
        }
    }
}

impl Chain {
    pub(crate) fn new(joints: &[Joint], tool_chain: &[usize], work_chain: &[usize], spindle_at_zero: Pose) -> Self {
        let order = work_chain.iter().rev().chain(tool_chain);
        Self { links: order.map(|&j| ChainLink::new(j, &joints[j])).collect(), spindle_at_zero }
    }

    /// Tip and axis in K: the two are carried through the links from the tool to the table, which costs two
    /// turned vectors a rotary joint and no matrix.
    pub(crate) fn forward(&self, q: &JointValues, tool_length: f64) -> ToolPose {
        let s0 = &self.spindle_at_zero;
        let mut axis: Vector = s0.rotation.column(2).into();
        let mut tip = Point::from(s0.translation - axis * tool_length);
        for link in self.links.iter().rev() {
            let value = q[link.joint];
            if link.rotary {
                let sc = sin_cos(value);
                axis = turned(&axis, &link.direction, sc);
                tip = link.turned_point(&tip, value, sc);
            } else {
                tip += link.direction * value;
            }
        }
        ToolPose { tip, axis }
    }

    /// The tip in K with every linear joint in `free` at zero, and the direction in K along which each
    /// linear joint moves it. The tip is linear in those joints, whatever rotary joints lie between them.
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
                tip = link.turned_point(&tip, q[link.joint], sc);
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
