//! The least that the bound of motion of a span must be, from the vertices of the bodies.
//!
//! At the middle of the span the farthest vertex of the moving body from the axis of each joint that turns is
//! R. A bound that holds for the whole span is nowhere smaller than what R says there: for a box `sum R h`
//! over the joints that turn, for a place `sum R |dq|` over all, for a chord what the samples leave it by,
//! and the quarter of turn times way by which points leave a straight line; for parabolas what leaves these,
//! a third derivative of three times the square of the turn times the way.

use proveout_geom::Point;
use proveout_machine::{JointValues, Machine};

use super::table::{ClearanceClaim, JointSample};
use super::{CarriedBody, carriers, holds_joints};

/// A corner for each joint.
pub(super) type JointCorners = Vec<usize>;

/// What a third derivative of one does between a parabola's three places, one apart: the largest of `t (t -
/// 1/2) (t - 1) / 6`.
const OFF_PARABOLA: f64 = 0.008_018_7;

/// `near` are corners of both bodies that were farthest from the joints in another span.
pub(super) fn least(
    machine: &Machine,
    [a, b]: [&CarriedBody; 2],
    span: &ClearanceClaim,
    samples: &[JointSample],
    near: &mut [JointCorners; 2],
) -> f64 {
    let middle = span.middle();
    let (of_a, of_b) = (carriers(machine, a.attached), carriers(machine, b.attached));
    let shared = of_a.iter().zip(&of_b).take_while(|(x, y)| x == y).count();
    let mut weights = JointValues::ZERO;
    for ((joints, body), near) in [(&of_a[shared..], a), (&of_b[shared..], b)].into_iter().zip(near) {
        near.resize(machine.joints.len(), 0);
        for &j in joints {
            let turns = machine.joints[j].is_rotary();
            weights[j] = if turns { farthest(machine, body, j, &middle, &mut near[j]) } else { 1.0 };
        }
    }
    let turns = |j: usize| machine.joints[j].is_rotary();
    let all = 0..machine.joints.len();
    let Some([from, to]) = span.straight else {
        // A joint with unlimited range is covered by the distance.
        let counts = |j: &usize| turns(*j) && span.high[*j].is_finite();
        return all.filter(counts).map(|j| 0.5 * weights[j] * (span.high[j] - span.low[j])).sum();
    };
    let way = to - from;
    let length: f64 = all.clone().map(|j| (weights[j] * way[j]).powi(2)).sum();
    let first = samples.partition_point(|s| s.time < span.time[0]);
    let mut most: f64 = 0.0;
    // At its time the joints may be in another part of the same piece of the motion.
    let within = samples[first..].iter().take_while(|s| s.time <= span.time[1]);
    for sample in within.filter(|s| holds_joints(machine, span, &s.joints)) {
        let beside = sample.joints - from;
        let along: f64 = all.clone().map(|j| weights[j] * weights[j] * beside[j] * way[j]).sum();
        let t = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
        let off = |j: usize| weights[j] * (beside[j] - way[j] * t).abs();
        // Nearest by squares is no farther than by the sum from any other place, but for the number of
        // joints.
        let sum: f64 = all.clone().map(off).sum();
        let largest = all.clone().map(off).fold(0.0, f64::max);
        most = most.max(if length > 0.0 { largest } else { sum });
    }
    let turn: f64 = all.clone().filter(|&j| turns(j) && weights[j] > 0.0).map(|j| way[j].abs()).sum();
    let motion: f64 = all.map(|j| weights[j] * way[j].abs()).sum();
    most.max(if span.curved { 3.0 * OFF_PARABOLA * turn * turn * motion } else { 0.25 * turn * motion })
}

/// Farthest vertex of a body from the axis of a joint, mm, at some joints.
fn farthest(machine: &Machine, body: &CarriedBody, joint: usize, q: &JointValues, near: &mut usize) -> f64 {
    let machine_from_body = machine.attachment_pose(body.attached, q);
    let machine_from_joint = machine.attachment_pose(proveout_machine::Attachment::Joint(joint), q);
    let axis = &machine.joints[joint];
    let (point, direction) = (machine_from_joint.point(&axis.point), machine_from_joint.vector(&axis.direction));
    let off = |p: &Point| (machine_from_body.point(p) - point).cross(&direction).norm();
    body.form.corners.largest(off, near)
}
