//! What the machine does while a part falls: the tool against the table, and how the table itself is
//! accelerated.
//!
//! A loose part is followed in the table frame K. Seen from there it feels gravity as the table is
//! oriented, less the acceleration of the place where it is:
//!
//! ```text
//!   f(t) = R_KM(q) (g - p''(t))     p(t) = X_MK(q(t)) p_K     p'' by differences of p at q + v h + a h^2 / 2
//! ```
//!
//! While the table turns, the frame gives forces to what moves in it (Coriolis) that are not followed: a fall
//! in that time is not decided.

use proveout_controller::Chunk;
use proveout_geom::{Point, Pose, ToolPose, Vector};
use proveout_machine::{JointValues, Machine};

use super::fall::STANDARD_GRAVITY;

/// Step of the differences, s.
const H: f64 = 1e-3;
/// A rotary joint below the table that is slower counts as at rest, radian/s.
const STANDS: f64 = 1e-6;
/// Sine of the angle to Z below which an axis is along it.
const PARALLEL: f64 = 1e-12;

/// Motion of the machine from some moment on.
#[derive(Clone, Debug, Default)]
pub(super) struct Course {
    samples: Vec<Felt>,
    tool: Vec<([f64; 2], [ToolPose; 2])>,
}

#[derive(Clone, Copy, Debug)]
struct Felt {
    time: f64,
    acceleration: Vector,
    turns: bool,
}

/// The machine at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now {
    /// What a part feels, in K, mm/s².
    pub(super) acceleration: Vector,
    /// The table turns.
    pub(super) turns: bool,
}

/// What a thing at a place in K feels while it rests on the table, mm/s²; none where the machine
/// does not state `up`.
pub(super) fn felt(machine: &Machine, at: &Point, [q, v, a]: [&JointValues; 3]) -> Option<Vector> {
    let up = machine.up?;
    let place = |h: f64| {
        let moved = q.zip_map(v.zip_map(*a, |v, a| v * h + 0.5 * a * h * h), |q, d| q + d);
        machine.machine_from_table(&moved).point(at)
    };
    let here = machine.machine_from_table(q);
    let second = ((place(H) - here.point(at)) - (here.point(at) - place(-H))) / (H * H);
    Some(here.inverse().vector(&(up * -STANDARD_GRAVITY - second)))
}

/// Whether a rotary joint below the table moves.
pub(super) fn table_turns(machine: &Machine, v: &JointValues) -> bool {
    machine.work_chain.iter().any(|&j| machine.joints[j].is_rotary() && v[j].abs() > STANDS)
}

impl Course {
    /// Takes the motion of a stretch from `since` on, for a part about `at` in K.
    pub(super) fn extend(&mut self, machine: &Machine, chunk: &Chunk, since: f64, at: &Point) {
        for sample in chunk.samples.iter().filter(|s| s.time >= since) {
            let state = [&sample.commanded, &sample.velocity, &sample.acceleration];
            let Some(acceleration) = felt(machine, at, state) else { continue };
            self.samples.push(Felt { time: sample.time, acceleration, turns: table_turns(machine, &sample.velocity) });
        }
        let later = chunk.pieces.iter().filter(|p| p.time[1] > since);
        self.tool.extend(later.map(|p| (p.time, p.pose)));
    }

    /// What is known reaches to this time, s.
    pub(super) fn end(&self) -> f64 {
        let samples = self.samples.last().map_or(f64::NEG_INFINITY, |s| s.time);
        self.tool.last().map_or(samples, |(time, _)| time[1].max(samples))
    }

    /// When a part is accelerated by more than `push` against what it `felt` at rest, by the sum of the
    /// absolute values along the axes.
    pub(super) fn beyond(&self, felt: &Vector, push: f64) -> Option<f64> {
        self.samples.iter().find(|s| (s.acceleration - felt).lp_norm(1) > push).map(|s| s.time)
    }

    /// The machine at a time; after the end it stays as it was then. `rest` is what a part feels
    /// while nothing moves.
    pub(super) fn at(&self, time: f64, rest: Vector) -> Now {
        let next = self.samples.partition_point(|s| s.time < time);
        match self.samples.get(next) {
            Some(s) => Now { acceleration: s.acceleration, turns: s.turns },
            None => Now { acceleration: rest, turns: false },
        }
    }

    /// Pose of the tool in K at a time; none where no piece of motion is known.
    pub(super) fn tool(&self, time: f64) -> Option<ToolPose> {
        let next = self.tool.partition_point(|(t, _)| t[1] < time);
        let Some(([from, to], [start, end])) = self.tool.get(next) else { return self.tool.last().map(|(_, p)| p[1]) };
        let part = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        Some(start.interpolated(end, part))
    }
}

/// A pose of T in K: its tip and axis, any turn about the axis.
pub(super) fn placed(tool: &ToolPose) -> Pose {
    let z = tool.axis;
    // The least turn that carries z there: close axes give close poses.
    let axis = Vector::z().cross(&z);
    let turn = match axis.try_normalize(PARALLEL) {
        Some(axis_of_turn) => Pose::from_axis_angle(&axis_of_turn, axis.norm().atan2(z.z)),
        None if z.z < 0.0 => Pose::from_axis_angle(&Vector::x(), std::f64::consts::PI),
        None => Pose::identity(),
    };
    Pose { rotation: turn.rotation, translation: tool.tip.coords }
}
