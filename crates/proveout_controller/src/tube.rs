//! A lower bound of the time of every motion within the tolerances, whatever path it takes.
//!
//! *What is bound.* A control may round the programmed path as it likes within the tolerances: its
//! tip stays within `e` of the programmed path and its rotary joints within `a` of theirs (in the
//! same branch of the inverse kinematics). It passes along the path in order (there is a
//! correspondence of both that never goes back). It keeps the programmed feeds for the tip on its
//! own path, and velocities and accelerations of the joints. Where the program makes the machine
//! stop (exact stop, dwell, tool change, probing, tapping stroke, end), it is in the programmed
//! point; dwell, tool changes and waits for the spindle take their time. Jerk counts for nothing
//! here: a control without limits of jerk is bound as well.
//!
//! *Gates.* Let `p_0, p_1, ..` be points of the programmed path in order, and `t_0 <= t_1 <= ..` times at
//! which the motion corresponds to them. At `t_i` the tip is within `e_i` of `p_i`. So from `t_i` to `t_j`
//!
//! ```text
//!      e_i          |p_j - p_i|           e_j        It goes at least |p_j - p_i| - e_i - e_j along
//!     (  o------------------------------o  )         the line from p_i to p_j, no faster than the
//!                                                    highest feed between both gates.
//! ```
//!
//! and each joint k goes at least `|q_k(p_j) - q_k(p_i)|` less what it may be off at both. With a velocity v
//! and an acceleration A, a distance D takes at least
//!
//! ```text
//!     D/v                                          in motion at both gates
//!     D/v + v/2A,  or sqrt(2 D/A) up to D = v^2/2A    at rest in one
//!     D/v + v/A,   or 2 sqrt(D/A) up to D = v^2/A     at rest in both
//! ```
//!
//! (a motion that is nowhere faster than v, nor than A times the time from or to its rest, covers no more).
//! The largest of these is a *leg*. Times between gates do not overlap, so that the legs over any choice of
//! gates add up to a lower bound. The choice with the largest sum is found gate by gate, from the left:
//! `best_j = max over i < j of best_i + leg(i, j)`.
//!
//! *What joints may be off.* A rotary joint by `a`, a linear one without tool center point control by `e`.
//! With it, linear joints follow the tip and the rotary ones (`Rig::slack`). The acceleration of the tip
//! along a line of direction d without tool center point control is at most the sum of `|d_k| A_k` over the
//! linear joints; with it none is counted.
//!
//! *Limits.* Corners and curves that joints cannot pass at the feed cost nothing here:
//! `Summary::path_bound_s` counts them, for the path that is run. Tolerances change what a gate gives: in a
//! curve of radius R legs of `(48 e R^2)^(1/3)` are best, and lose about `3 e` over that, one percent at R =
//! 10 mm and e = 0.01 mm.

use std::collections::VecDeque;

use proveout_machine::{JointKind, JointValues};

use crate::{
    limits::JointLimits,
    output::MoveKind,
    path::{PathBlock, PathContext, Tolerance},
    shape::BlockShape,
};

/// Gates that are kept, and how many before a gate a leg may begin: legs of many sizes, none longer than the
/// row.
const KEPT: usize = 33;
const BACK: [usize; 10] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32];
/// Distance of gates that are no rests, as part of the tolerances: with 32 of them legs lose 0.4 percent on a
/// straight line.
const APART: f64 = 16.0;
/// Part by which the feed may be passed (`limits.rs`).
const FEED_PASSED: f64 = 1.0005;
/// Angles of an arc and turn of rotary joints between two gates, radian.
const ARC: [f64; 2] = [0.05, 1.0];
const TURN: f64 = 0.2;
/// Gates within a curve whose radius is not looked at.
const IN_CURVE: usize = 16;
/// Most gates of a block.
const MOST_PARTS: f64 = 1e4;

/// What may happen between two gates.
#[derive(Clone, Copy, Debug)]
struct GateInterval {
    /// Highest feed of the tip, mm/s, and of rotary joints while the tip is at rest, degree/s;
    /// infinite where none is programmed.
    tip: f64,
    turn: f64,
    /// Some of it is no rapid motion: joints may have their full velocity.
    feed: bool,
}

impl GateInterval {
    const NOTHING: Self = Self { tip: 0.0, turn: 0.0, feed: false };

    fn of(block: &PathBlock) -> Self {
        let feed = if block.kind == MoveKind::Feed && block.feed_programmed > 0.0 {
            block.feed_programmed * FEED_PASSED
        } else {
            f64::INFINITY
        };
        let [tip, turn] = if block.tip_moves { [feed, f64::INFINITY] } else { [f64::INFINITY, feed] };
        Self { tip, turn, feed: block.kind != MoveKind::Rapid }
    }

    fn and(self, other: Self) -> Self {
        Self { tip: self.tip.max(other.tip), turn: self.turn.max(other.turn), feed: self.feed || other.feed }
    }
}

/// A place that every motion passes.
#[derive(Clone, Copy, Debug)]
struct TubeGate {
    task: JointValues,
    q: JointValues,
    /// What tip, rotary joints and each joint may be off.
    loose: Tolerance,
    slack: JointValues,
    rest: bool,
    /// Since the gate before.
    between: GateInterval,
    /// Bound of the time up to here since the first gate.
    best: f64,
}

/// The end of the last block, whose tolerance depends on the next one too.
#[derive(Clone, Copy, Debug)]
struct BlockEnd {
    task: JointValues,
    tolerance: Tolerance,
}

/// Collects gates block by block.
#[derive(Debug)]
pub(crate) struct Tube {
    /// Bound of all before the first gate of the row, and the row's last gates.
    done: f64,
    gates: VecDeque<TubeGate>,
    /// Since the last gate.
    between: GateInterval,
    end: Option<BlockEnd>,
    /// How the row begins: none, at rest; otherwise in motion, with this tolerance.
    begin: Option<Tolerance>,
}

const NONE: Tolerance = Tolerance { tip: 0.0, angle: 0.0 };

fn wider(a: Tolerance, b: Tolerance) -> Tolerance {
    Tolerance { tip: a.tip.max(b.tip), angle: a.angle.max(b.angle) }
}

impl Default for Tube {
    fn default() -> Self {
        Self { done: 0.0, gates: VecDeque::with_capacity(KEPT), between: GateInterval::NOTHING, end: None, begin: None }
    }
}

impl Tube {
    /// Bound of the time so far.
    pub(crate) fn bound_s(&self) -> f64 {
        self.done + self.gates.back().map_or(0.0, |g| g.best)
    }

    /// The machine is at rest for a time, where the program makes it stop.
    pub(crate) fn stand(&mut self, frame: &PathContext<'_>, duration: f64) {
        self.close(frame, None);
        self.done += duration;
    }

    /// The coordinates change their meaning after the last block; nothing makes the machine stop.
    pub(crate) fn remap(&mut self, frame: &PathContext<'_>) {
        if let Some(BlockEnd { tolerance, .. }) = self.end {
            self.close(frame, Some(tolerance));
            // Rotary joints mean the same; of the tip in the new coordinates nothing is known until the next
            // gate.
            self.begin = Some(Tolerance { tip: f64::INFINITY, ..tolerance });
        }
    }

    /// The next block, programmed from where the one before ends.
    pub(crate) fn block(&mut self, frame: &PathContext<'_>, block: &PathBlock) {
        let own = block.loose.unwrap_or(NONE);
        let mut loose = own;
        if let Some(end) = self.end.take() {
            loose = wider(own, end.tolerance);
            self.pass(frame, &end.task, (loose, false));
        } else if self.gates.is_empty() {
            let start = block.shape.jet(0.0).0[0];
            self.put(frame, &start, self.begin.map_or((NONE, true), |before| (wider(own, before), false)));
        }
        self.between = self.between.and(GateInterval::of(block));
        let n = parts(frame, block, loose.tip);
        for k in 1..n {
            let task = block.shape.jet(block.length * k as f64 / n as f64).0[0];
            self.pass(frame, &task, (loose, false));
            // What follows the gate is still within this block.
            self.between = self.between.and(GateInterval::of(block));
        }
        self.end = Some(BlockEnd { task: block.shape.jet(block.length).0[0], tolerance: own });
        if block.stands {
            self.close(frame, None);
        }
    }

    /// Ends the row of gates at the end of the last block: at rest, or in motion with a tolerance.
    fn close(&mut self, frame: &PathContext<'_>, moving: Option<Tolerance>) {
        if let Some(end) = self.end.take() {
            self.put(frame, &end.task, moving.map_or((NONE, true), |tolerance| (tolerance, false)));
        }
        self.done = self.bound_s();
        self.gates.clear();
        self.between = GateInterval::NOTHING;
        self.begin = moving;
    }

    /// A gate, unless it is so near to the last one that its tolerance takes most of the way.
    fn pass(&mut self, frame: &PathContext<'_>, task: &JointValues, (loose, rest): (Tolerance, bool)) {
        if let Some(last) = self.gates.back() {
            let way = *task - last.task;
            let near = |kind, tolerance: f64| size(frame, &way, kind) < APART * tolerance;
            if near(JointKind::Linear, loose.tip) && near(JointKind::Rotary, loose.angle) {
                return;
            }
        }
        self.put(frame, task, (loose, rest));
    }

    fn put(&mut self, frame: &PathContext<'_>, task: &JointValues, (loose, rest): (Tolerance, bool)) {
        let between = std::mem::replace(&mut self.between, GateInterval::NOTHING);
        let q = frame.kinematics.position(task);
        let mut gate = TubeGate { task: *task, q, loose, slack: slack(frame, task, loose), rest, between, best: 0.0 };
        let mut since = GateInterval::NOTHING;
        for (back, from) in self.gates.iter().rev().enumerate() {
            let later = if back == 0 { between } else { self.gates[self.gates.len() - back].between };
            since = since.and(later);
            if BACK.contains(&(back + 1)) {
                gate.best = gate.best.max(from.best + leg(frame, from, &gate, since));
            }
        }
        if self.gates.len() == KEPT {
            self.gates.pop_front();
        }
        self.gates.push_back(gate);
    }
}

/// Euclidean size of the linear or the rotary part.
fn size(frame: &PathContext<'_>, way: &JointValues, kind: JointKind) -> f64 {
    let joints = frame.kinematics.machine.joints.iter().enumerate().filter(|(_, j)| j.kind == kind);
    joints.map(|(i, _)| way[i] * way[i]).sum::<f64>().sqrt()
}

/// What each joint may be off where tip and rotary joints are within a tolerance; infinite where that is not
/// known.
fn slack(frame: &PathContext<'_>, task: &JointValues, loose: Tolerance) -> JointValues {
    let mut slack = JointValues::ZERO;
    for (i, joint) in frame.kinematics.machine.joints.iter().enumerate() {
        slack[i] = if joint.kind == JointKind::Rotary { loose.angle } else { loose.tip };
    }
    if let (Some(length), Some(rig), true) = (frame.kinematics.mapping.tcp_length, frame.kinematics.rig, loose != NONE)
    {
        let linear = rig.slack(task, length, loose.tip, loose.angle).unwrap_or([f64::INFINITY; 3]);
        for (slot, off) in rig.slots.into_iter().zip(linear) {
            slack[slot] = off;
        }
    }
    slack
}

/// Number of stretches between gates in a block: the ends alone say little about what turns on the
/// way.
fn parts(frame: &PathContext<'_>, block: &PathBlock, tolerance: f64) -> usize {
    let turn = |shape: &BlockShape| {
        let way = shape.jet(block.length).0[0] - shape.jet(0.0).0[0];
        let most = size(frame, &way, JointKind::Rotary) / TURN;
        if frame.kinematics.is_tcp() { most } else { 0.0 }
    };
    let parts = match &block.shape {
        BlockShape::Line { .. } => turn(&block.shape),
        BlockShape::Arc(arc) => {
            let best = (48.0 * tolerance / arc.radius.max(f64::MIN_POSITIVE)).cbrt();
            (arc.omega.abs() * block.length / best.clamp(ARC[0], ARC[1])).max(turn(&block.shape))
        }
        BlockShape::Spline(_) | BlockShape::Bezier(_) => (IN_CURVE as f64).max(turn(&block.shape)),
        BlockShape::Timed(_) => 1.0,
    };
    parts.ceil().clamp(1.0, MOST_PARTS) as usize
}

/// Least time from one gate to another.
fn leg(frame: &PathContext<'_>, from: &TubeGate, to: &TubeGate, between: GateInterval) -> f64 {
    let machine = frame.kinematics.machine;
    let limits: &JointLimits = frame.limits;
    let rests = [from.rest, to.rest];
    let velocity = if between.feed { &limits.velocity } else { &limits.rapid };
    let mut time = 0.0_f64;
    for i in 0..limits.count {
        let way = (to.q[i] - from.q[i]).abs() - from.slack[i] - to.slack[i];
        time = time.max(shortest(way, velocity[i], limits.acceleration[i], rests));
    }
    let way = to.task - from.task;
    if between.tip.is_finite() {
        let whole = size(frame, &way, JointKind::Linear);
        let linear = machine.joints.iter().enumerate().filter(|(_, j)| j.kind == JointKind::Linear);
        let along =
            linear.filter(|(i, _)| way[*i] != 0.0).map(|(i, _)| (way[i] / whole).abs() * limits.acceleration[i]);
        let acceleration = if frame.kinematics.is_tcp() { f64::INFINITY } else { along.sum() };
        time = time.max(shortest(whole - from.loose.tip - to.loose.tip, between.tip, acceleration, rests));
    }
    if between.turn.is_finite() {
        let count = machine.joints.iter().filter(|j| j.kind == JointKind::Rotary).count() as f64;
        let loose = (from.loose.angle + to.loose.angle) * count.sqrt();
        let whole = size(frame, &way, JointKind::Rotary);
        time = time.max(shortest((whole - loose).to_degrees(), between.turn, f64::INFINITY, rests));
    }
    time
}

/// Least time for a way with a velocity and an acceleration, from or to rest or in motion.
fn shortest(way: f64, velocity: f64, acceleration: f64, rests: [bool; 2]) -> f64 {
    if way.is_nan() || way <= 0.0 {
        return 0.0;
    }
    let rests = f64::from(u8::from(rests[0]) + u8::from(rests[1]));
    // Ramps on which the velocity is not reached: each covers half of the way, or all of it.
    let ramped = rests * velocity * velocity / (2.0 * acceleration);
    if rests > 0.0 && (way < ramped || velocity.is_infinite()) {
        return (2.0 * rests * way / acceleration).sqrt();
    }
    way / velocity + if acceleration.is_finite() { rests * velocity / (2.0 * acceleration) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_takes_what_a_ramp_and_a_cruise_take() {
        let (v, a) = (10.0_f64, 50.0_f64);
        for rests in [[false, false], [true, false], [false, true], [true, true]] {
            let ends = f64::from(u8::from(rests[0]) + u8::from(rests[1]));
            for way in [1e-6, 0.3, 0.999, 1.0, 1.001, 1.999, 2.0, 2.001, 30.0] {
                // By small steps: the fastest is at its acceleration from both ends.
                let n = 20_000;
                let h = way / f64::from(n);
                let slow = |x: f64| {
                    let begin = if rests[0] { 2.0 * a * x } else { f64::INFINITY };
                    let end = if rests[1] { 2.0 * a * (way - x) } else { f64::INFINITY };
                    v.min(begin.min(end).sqrt())
                };
                let sum: f64 = (0..n).map(|k| h / slow(h * (f64::from(k) + 0.5))).sum();
                let time = shortest(way, v, a, rests);
                // The rule of midpoints misses a part of the root at a rest: 0.6 h/sqrt(2 a h).
                assert!(
                    time >= sum - 1e-9 && time < sum + ends * 0.7 * (h / (2.0 * a)).sqrt() + 1e-9,
                    "{way} {rests:?}"
                );
            }
        }
        assert_eq!(shortest(-1.0, 1.0, 1.0, [true, true]), 0.0);
        assert_eq!(shortest(f64::NEG_INFINITY, 1.0, 1.0, [true, true]), 0.0);
        assert_eq!(shortest(8.0, f64::INFINITY, 2.0, [true, true]), 4.0);
        assert_eq!(shortest(8.0, f64::INFINITY, f64::INFINITY, [true, true]), 0.0);
        assert_eq!(shortest(8.0, 4.0, f64::INFINITY, [true, true]), 2.0);
    }
}
