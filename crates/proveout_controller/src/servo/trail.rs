//! The actual motion as a curve over time, and its pieces for removal and interference.
//!
//! Between two control samples the load's position is the cubic with its positions and velocities at both.
//! With the load's acceleration known to stay within [low, high] over the cycle, the difference to the true
//! motion has value and slope zero at both ends and a second derivative within D = max(high - c, C - low), c
//! and C the ends of the cubic's linear acceleration, so that it stays within
//!
//! ```text
//!   D T^2 / 16       (reached when the difference's acceleration is +D, -D, +D over T/4, T/2, T/4)
//! ```
//!
//! Each joint's bound moves the tool by no more than the joint's rate times it, which goes into the pieces'
//! deviation.

use std::collections::VecDeque;

use proveout_geom::ToolPose;
use proveout_machine::{JointValues, MAX_JOINTS, Machine};

use crate::{
    output::{MoveKind, Piece},
    pieces::{NO_TURN, NO_WAY_MM2, WHOLE},
    settings::Settings,
    straightness::Straightness,
};

/// The joints at a control sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ServoKnot {
    pub(crate) time: f64,
    pub(crate) q: JointValues,
    pub(crate) v: JointValues,
    /// Block of the set point.
    pub(crate) block: u32,
    /// Bound of the cubic's deviation since the knot before, at the tool, mm.
    pub(crate) bound: f64,
    /// The same of each joint.
    pub(crate) joint_bound: JointValues,
    /// Pose of a tool of this length, mm.
    pub(crate) tool_length: f64,
    pub(crate) pose: ToolPose,
}

/// Knots that are still needed, in order of time.
#[derive(Debug, Default)]
pub(crate) struct Trail {
    knots: VecDeque<ServoKnot>,
    /// The stretch in use, for forward walks.
    at: usize,
}

/// Intervals between knots that are tried as one piece.
const TOGETHER: usize = 8;
/// Halvings of one interval; ends a motion that never fits.
const DEEPEST: u32 = 16;
/// Surcharge on a deviation measured at points, and where a table of geometric errors bends: as in
/// `pieces.rs`.
const BETWEEN: f64 = 1.05;
const BENT: f64 = 1.2;
/// A tool that moves less than this (mm at tip and gauge line) counts as at rest.
const STANDS: f64 = 1e-9;

#[derive(Clone, Copy)]
struct TimedPose {
    time: f64,
    q: JointValues,
    pose: ToolPose,
}

/// What the pieces of a span have in common.
#[derive(Clone, Copy)]
pub(crate) struct SpanOf<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) settings: &'a Settings,
    pub(crate) tool_length: f64,
    pub(crate) block: u32,
    pub(crate) kind: MoveKind,
}

impl Trail {
    pub(crate) fn push(&mut self, knot: ServoKnot) {
        self.knots.push_back(knot);
    }

    /// Drops what lies before a time.
    pub(crate) fn forget(&mut self, time: f64) {
        while self.knots.len() > 2 && self.knots[1].time <= time {
            self.knots.pop_front();
        }
        self.at = 0;
    }

    /// The block of the set point at a time.
    pub(crate) fn block_after(&self, time: f64) -> Option<u32> {
        self.knots.iter().find(|k| k.time > time).map(|k| k.block)
    }

    /// Index of the interval that holds a time.
    fn interval(&self, time: f64, hint: usize) -> usize {
        let last = self.knots.len().saturating_sub(2);
        let mut i = hint.min(last);
        while i > 0 && self.knots[i].time > time {
            i -= 1;
        }
        while i < last && self.knots[i + 1].time < time {
            i += 1;
        }
        i
    }

    fn position(&self, time: f64, hint: usize) -> JointValues {
        let i = self.interval(time, hint);
        let (Some(a), Some(b)) = (self.knots.get(i), self.knots.get(i + 1)) else {
            return self.knots.get(i).map_or(JointValues::ZERO, |k| k.q);
        };
        let h = b.time - a.time;
        if h <= 0.0 || time >= b.time {
            return b.q;
        }
        let t = ((time - a.time) / h).clamp(0.0, 1.0);
        let (t2, t3) = (t * t, t * t * t);
        let (h01, h10, h11) = (3.0 * t2 - 2.0 * t3, t3 - 2.0 * t2 + t, t3 - t2);
        let mut q = a.q;
        for j in 0..MAX_JOINTS {
            q[j] += h01 * (b.q[j] - a.q[j]) + h * (h10 * a.v[j] + h11 * b.v[j]);
        }
        q
    }

    /// Pieces of the motion from one time to another.
    pub(crate) fn cut(&mut self, from: f64, to: f64, of: SpanOf<'_>, emit: &mut dyn FnMut(Piece)) {
        if to <= from || self.knots.len() < 2 {
            return;
        }
        let mut begin = from;
        let mut group: Vec<f64> = Vec::with_capacity(TOGETHER + 1);
        while begin < to {
            self.at = self.interval(begin, self.at);
            group.clear();
            group.push(begin);
            let next = self.knots.iter().skip(self.at).map(|k| k.time).filter(|t| *t > begin && *t < to);
            group.extend(next.take(TOGETHER));
            if group.len() <= TOGETHER {
                group.push(to);
            }
            begin = group[group.len() - 1];
            self.cut_group(&group, &of, emit);
        }
    }

    fn stance(&self, time: f64, of: &SpanOf<'_>) -> TimedPose {
        let at = self.interval(time, self.at);
        let knots = self.knots.iter().skip(at).take(2);
        if let Some(k) = knots.into_iter().find(|k| k.time == time && k.tool_length == of.tool_length) {
            return TimedPose { time, q: k.q, pose: k.pose };
        }
        let q = self.position(time, at);
        TimedPose { time, q, pose: of.machine.actual_forward(&q, of.tool_length) }
    }

    fn cut_group(&self, times: &[f64], of: &SpanOf<'_>, emit: &mut dyn FnMut(Piece)) {
        // Nodes at even places, middles between them.
        let mut stances: Vec<TimedPose> = Vec::with_capacity(2 * times.len());
        for pair in times.windows(2) {
            stances.push(self.stance(pair[0], of));
            stances.push(self.stance(0.5 * (pair[0] + pair[1]), of));
        }
        stances.push(self.stance(times[times.len() - 1], of));
        self.cut_stances(&stances, of, emit);
    }

    fn cut_stances(&self, stances: &[TimedPose], of: &SpanOf<'_>, emit: &mut dyn FnMut(Piece)) {
        let (Some(a), Some(b)) = (stances.first(), stances.last()) else { return };
        if stances.len() <= 3 {
            self.cut_interval(a, b, of, 0, emit);
            return;
        }
        let bound = self.bound(a.time, b.time);
        if parts_by_size(a, b, of) <= 1.0 {
            let inner = &stances[1..stances.len() - 1];
            let tolerance = of.settings.piece_tolerance;
            let (mut worst, between) = (0.0_f64, between(a, b, of));
            let fits = inner.iter().all(|x| {
                worst = worst.max(deviation(a, b, x, of.tool_length));
                worst * between + bound <= tolerance
            });
            if fits {
                self.put(a, b, worst * between + bound, of, emit);
                return;
            }
        }
        let middle = (stances.len() / 4) * 2;
        self.cut_stances(&stances[..=middle], of, emit);
        self.cut_stances(&stances[middle..], of, emit);
    }

    fn cut_interval(&self, a: &TimedPose, b: &TimedPose, of: &SpanOf<'_>, depth: u32, emit: &mut dyn FnMut(Piece)) {
        let at = |part: f64| self.stance(a.time + (b.time - a.time) * part, of);
        let bound = self.bound(a.time, b.time);
        let mut worst = 0.0_f64;
        for part in [0.25, 0.5, 0.75] {
            worst = worst.max(deviation(a, b, &at(part), of.tool_length));
        }
        let (small, between) = (parts_by_size(a, b, of) <= 1.0, between(a, b, of));
        if depth >= DEEPEST || small && worst * between <= of.settings.piece_tolerance {
            self.put(a, b, worst * between + bound, of, emit);
            return;
        }
        let middle = at(0.5);
        self.cut_interval(a, &middle, of, depth + 1, emit);
        self.cut_interval(&middle, b, of, depth + 1, emit);
    }

    fn put(&self, a: &TimedPose, b: &TimedPose, deviation: f64, of: &SpanOf<'_>, emit: &mut dyn FnMut(Piece)) {
        let moved = (b.pose.tip - a.pose.tip).norm() + of.tool_length * (b.pose.axis - a.pose.axis).norm();
        let joint_deviation = self.joint_deviation(a, b, of.machine);
        let still = moved <= STANDS && deviation <= STANDS;
        if still && (b.q - a.q).max_abs() <= STANDS && joint_deviation.max_abs() <= STANDS {
            return;
        }
        emit(Piece {
            time: [a.time, b.time],
            block: of.block,
            kind: of.kind,
            joints: [a.q, b.q],
            pose: [a.pose, b.pose],
            deviation,
            edge_deviation: deviation,
            joint_deviation,
            finer: None,
        });
    }

    /// How far each joint leaves the straight motion: the cubics at the quarters and at the knots within, and
    /// what they are off.
    fn joint_deviation(&self, a: &TimedPose, b: &TimedPose, machine: &Machine) -> JointValues {
        let mut straightness = Straightness::new(machine, &a.q, &b.q);
        for part in [0.25, 0.5, 0.75] {
            straightness.look(&self.position(a.time + (b.time - a.time) * part, self.at));
        }
        let mut off = JointValues::ZERO;
        for knot in self.knots.iter().skip(self.interval(a.time, self.at) + 1) {
            off = off.zip_map(knot.joint_bound, f64::max);
            if knot.time >= b.time {
                break;
            }
            straightness.look(&knot.q);
        }
        straightness.bound() + off
    }

    /// Largest bound of the intervals between two times.
    fn bound(&self, from: f64, to: f64) -> f64 {
        let first = self.interval(from, self.at);
        let after = self.knots.iter().skip(first + 1);
        let mut worst = 0.0_f64;
        for knot in after {
            worst = worst.max(knot.bound);
            if knot.time >= to {
                break;
            }
        }
        worst
    }
}

fn between(a: &TimedPose, b: &TimedPose, of: &SpanOf<'_>) -> f64 {
    if of.machine.error_bends(&a.q, &b.q) > 0 { BENT } else { BETWEEN }
}

fn parts_by_size(a: &TimedPose, b: &TimedPose, of: &SpanOf<'_>) -> f64 {
    let mut parts = (b.pose.tip - a.pose.tip).norm() / of.settings.piece_length;
    parts = parts.max(a.pose.angle_to(&b.pose) / of.settings.piece_angle);
    for (i, joint) in of.machine.joints.iter().enumerate() {
        if joint.is_rotary() {
            parts = parts.max((b.q[i] - a.q[i]).abs() / of.settings.piece_angle);
        }
    }
    // As in `pieces.rs`: one kink of a table of errors is seen between nodes and middles, several may hide.
    let bends = of.machine.error_bends(&a.q, &b.q);
    if bends > 1 {
        parts = parts.max(bends as f64);
    }
    parts - WHOLE
}

/// Distance of a stance from the piece between two others, anywhere between tip and gauge line.
fn deviation(a: &TimedPose, b: &TimedPose, x: &TimedPose, tool_length: f64) -> f64 {
    let way = b.pose.tip - a.pose.tip;
    let length2 = way.norm_squared();
    let turn = a.pose.angle_to(&b.pose);
    let t = if length2 > NO_WAY_MM2 {
        (x.pose.tip - a.pose.tip).dot(&way) / length2
    } else if turn > NO_TURN {
        a.pose.angle_to(&x.pose) / turn
    } else {
        0.5
    };
    let on = a.pose.interpolated(&b.pose, t.clamp(0.0, 1.0));
    (x.pose.tip - on.tip).norm() + tool_length * (x.pose.axis - on.axis).norm()
}

/// Bound of the cubic's deviation over a cycle `h` of one joint, from way, velocities and the extremes of
/// acceleration.
pub(crate) fn cubic_bound(h: f64, way: f64, v: [f64; 2], [low, high]: [f64; 2]) -> f64 {
    let slope = 6.0 * way / (h * h);
    let ends = [slope - (4.0 * v[0] + 2.0 * v[1]) / h, (2.0 * v[0] + 4.0 * v[1]) / h - slope];
    let (c_low, c_high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    (high - c_low).max(c_high - low).max(0.0) * h * h / 16.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_holds_for_the_worst_motion_and_is_reached() {
        // Acceleration +1, -1, +1 over quarters: the cubic through its ends is zero, and the middle lies at
        // 1/16.
        let bound = cubic_bound(1.0, 0.0, [0.0, 0.0], [-1.0, 1.0]);
        assert_eq!(bound, 1.0 / 16.0);
        let (mut x, mut v, mut highest) = (0.0, 0.0, 0.0_f64);
        let n = 40_000;
        for k in 0..n {
            let a = if (n / 4..3 * n / 4).contains(&k) { -1.0 } else { 1.0 };
            let h = 1.0 / f64::from(n);
            x += v * h + 0.5 * a * h * h;
            v += a * h;
            highest = highest.max(x.abs());
        }
        // Grid of 1/40000: 1e-9 of rounding and grid.
        assert!((highest - bound).abs() < 1e-8 && x.abs() < 1e-9, "{highest} {x}");
    }
}
