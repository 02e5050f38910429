//! The corner between two blocks: what a fit needs to know about it, or its rounding.

use proveout_machine::{JointKind, JointValues, Machine};

use super::{PathBlock, PathContext, SHORT, Tolerance, WayMeasure, fit::Kink, reversal::reverses};
use crate::{jet::JointJet, output::MoveKind, shape::Quintic};

/// Half width of a blend below which the control stops in the corner, as part of the shorter block: the blend
/// would be a stop in all but name.
const NARROWEST: f64 = 1e-6;
/// Part of the joint limits that a blend may use at the programmed feed when its width is chosen.
const BLEND_SHARE: f64 = 0.5;
/// Largest kink (radian) between chords of a curve: more is a corner, also between short blocks.
const GENTLE: f64 = 0.5;
/// Lowest way by the parameter in the middle of a corner that its width is made for: that of 170 degrees,
/// where it becomes a stop.
const SLOWEST_MIDDLE: f64 = 0.087;
/// Half width over length of short blocks. The transform of the parabola, `3 (sin x - x cos x)/x^3` with `x =
/// 2 pi d/L`, has its second zero here: the second derivative of equal chords has no wave of the blocks'
/// frequency, and 2.5 percent of itself at twice that. An averaged arc of curvature k lies `k d^2/10` inside
/// of its chords, in their middle 0.15 `k L^2` where those are 0.125 `k L^2` off: by so much its points are
/// moved outward first (`points.rs`).
const OVER_SHORT: f64 = 1.23;
/// Half width over feed of short blocks, s: waves of many tiny blocks are to die out as well.
const SMOOTHED: f64 = 0.005;
/// A step of the slope that is smaller than this part of it is rounding.
const KINKED: f64 = 1e-9;
/// A step of the curvature that is smaller than this part of it is rounding.
const BENT: f64 = 1e-9;
/// Least half width of a kink, part of the largest slope of a joint, and what that counts for at least.
const SOME_WIDTH: [f64; 2] = [1e-3, 1e-3];

pub(super) enum CornerRounding {
    /// Value, slope and curvature agree: nothing to do.
    Smooth,
    Blend {
        half_width: f64,
        rounding: f64,
        quintic: Box<Quintic>,
    },
    /// Between two lines in feed: rounded together with its neighbors.
    Kink(Box<Kink>),
    Stop,
}

/// What to do with the corner at the end of block `a`, which has this running number.
pub(super) fn corner(
    frame: &PathContext<'_>,
    (number, a): (u64, &PathBlock),
    b: &PathBlock,
    tolerance: Tolerance,
) -> CornerRounding {
    // What a chord has taken of its block's tolerance is missing at both of its ends.
    let tolerance = b.corner.filter(|_| b.chord.is_some()).map_or(tolerance, |other| tolerance.min(other));
    let (end, start) = (a.course().jet(a.length), b.course().jet(0.0));
    if reverses(frame, [a.tip_moves, b.tip_moves], &end, &start) {
        return CornerRounding::Stop;
    }
    let slope = start.first() - end.first();
    let bend = start.second() - end.second();
    let lines = a.course().is_line() && b.course().is_line();
    let scale = end.first().max_abs().max(start.first().max_abs());
    let kinked = slope.max_abs() > KINKED * scale;
    if a.is_rapid() != b.is_rapid() && (kinked || !lines) {
        return CornerRounding::Stop;
    }
    let feeds = a.kind == MoveKind::Feed && b.kind == MoveKind::Feed && a.tip_moves == b.tip_moves;
    let longest = a.length.max(b.length);
    let short = longest <= SHORT * a.feed.min(b.feed);
    if !kinked && lines && feeds {
        let none = Tolerance { tip: 0.0, angle: 0.0 };
        let slopes = [end.first(), JointValues::ZERO];
        let kink = Kink::new((number, b.s0), slopes, none, f64::INFINITY, (tolerance, short));
        return CornerRounding::Kink(Box::new(kink));
    }
    if !kinked && (lines || bend.max_abs() < BENT * end.second().max_abs().max(start.second().max_abs())) {
        return CornerRounding::Smooth;
    }
    let machine = frame.kinematics.machine;
    let room = 0.5 * a.length.min(b.length);
    let feed = a.feed.min(b.feed);
    let way = WayMeasure::of([a.tip_moves, b.tip_moves]);
    let need = needed_half_width(frame, (way, &end, &start), feed, a.is_rapid() && b.is_rapid());
    let mut d = room.min(need);
    if kinked {
        let (tip, angle) = size(machine, &(slope * (3.0 / 16.0)));
        d = d.min(tolerance.tip / tip).min(tolerance.angle / angle);
    }
    if lines {
        if d.is_nan() || d <= NARROWEST * room {
            return CornerRounding::Stop;
        }
        if feeds {
            let (tip, angle) = size(machine, &slope);
            let wanted = if short { need.max(OVER_SHORT * longest).max(SMOOTHED * feed) } else { need };
            let turn = if a.tip_moves { tip } else { angle / scale };
            let gentle = short && turn <= GENTLE;
            let tighter = b.corner.map_or(tolerance, |other| tolerance.min(other));
            let size = Tolerance { tip, angle };
            return CornerRounding::Kink(Box::new(Kink::new(
                (number, b.s0),
                [end.first(), slope],
                size,
                wanted.min(f64::MAX),
                (tighter, gentle),
            )));
        }
        let quintic = Box::new(blend(a, b, d));
        let (tip, _) = size(machine, &(slope * (3.0 / 16.0 * d)));
        return CornerRounding::Blend { half_width: d, rounding: tip, quintic };
    }
    for _ in 0..12 {
        if d.is_nan() || d <= NARROWEST * room {
            return CornerRounding::Stop;
        }
        let quintic = Box::new(blend(a, b, d));
        let (tip, angle) = blend_deviation(frame, a, b, &quintic, d);
        let excess = (tip / tolerance.tip).max(angle / tolerance.angle);
        if excess <= 1.0 {
            return CornerRounding::Blend { half_width: d, rounding: tip, quintic };
        }
        // Deviation grows with d (kink) or with its square (curvature): the step of the first kind is always
        // enough.
        d *= (0.98 / excess).max(0.1);
    }
    CornerRounding::Stop
}

fn blend(a: &PathBlock, b: &PathBlock, d: f64) -> Quintic {
    Quintic::hermite(b.s0 - d, b.s0 + d, &a.course().jet(a.length - d), &b.course().jet(d))
}

/// Largest distance between blend and exact path at equal parameter, tip (or linear joints) and rotary
/// joints.
fn blend_deviation(frame: &PathContext<'_>, a: &PathBlock, b: &PathBlock, quintic: &Quintic, d: f64) -> (f64, f64) {
    const STEPS: i32 = 16;
    let mut worst = (0.0_f64, 0.0_f64);
    for i in 1..STEPS {
        let x = d * (2.0 * f64::from(i) / f64::from(STEPS) - 1.0);
        let exact = if x < 0.0 { a.course().jet(a.length + x) } else { b.course().jet(x) };
        let difference = quintic.jet(b.s0 + x).0[0] - exact.0[0];
        let (tip, angle) = size(frame.kinematics.machine, &difference);
        worst = (worst.0.max(tip), worst.1.max(angle));
    }
    (worst.0 * 1.02, worst.1 * 1.02) // between the points: at most 2 percent for a fifth degree
}

/// Euclidean size of the linear part (mm) and largest rotary part (radian) of a difference of task
/// coordinates.
pub(super) fn size(machine: &Machine, difference: &JointValues) -> (f64, f64) {
    let (mut linear, mut angle) = (0.0_f64, 0.0_f64);
    for (i, joint) in machine.joints.iter().enumerate() {
        match joint.kind {
            JointKind::Linear => linear += difference[i] * difference[i],
            JointKind::Rotary => angle = angle.max(difference[i].abs()),
        }
    }
    (linear.sqrt(), angle)
}

/// Half width at which the joints can take the corner at the feed, or at the highest speed of both blocks if
/// that is lower: with the largest second and third derivative of the blend (text of `path.rs`).
///
/// In the middle of the blend between slopes u and w the way by the parameter is |u + w|/2 = cos(half of the
/// angle), so that at the feed the parameter runs faster by one over that, and the joints accelerate by its
/// square. The jerk is highest between middle and ends, about by its cube: at 90 degrees 2.4 times as much as
/// at the ends of the blend where the parameter runs at the feed, cube 2.8; at 120 degrees 11 times, cube 8,
/// within what the share of the limits leaves.
fn needed_half_width(
    frame: &PathContext<'_>,
    (way, end, start): (WayMeasure, &JointJet, &JointJet),
    feed: f64,
    rapid: bool,
) -> f64 {
    let (qa, qb) = (frame.kinematics.joints(end), frame.kinematics.joints(start));
    let l = frame.limits;
    let velocity = if rapid { &l.rapid } else { &l.velocity };
    let mut speed = feed;
    for i in 0..l.count {
        let most = qa.first()[i].abs().max(qb.first()[i].abs());
        if most > 0.0 {
            speed = speed.min(velocity[i] / most);
        }
    }
    if !speed.is_finite() {
        return f64::INFINITY;
    }
    let ends = [end, start].map(|jet| way.rate(frame.kinematics.machine, jet)[0]);
    let mean = JointJet([JointValues::ZERO, (end.first() + start.first()) * 0.5, JointValues::ZERO, JointValues::ZERO]);
    let middle = way.rate(frame.kinematics.machine, &mean)[0] / ends[0].max(ends[1]).max(f64::MIN_POSITIVE);
    let faster = if rapid { 1.0 } else { 1.0 / middle.clamp(SLOWEST_MIDDLE, 1.0) };
    let mut d = 0.0_f64;
    for i in 0..l.count {
        let kink = (qb.first()[i] - qa.first()[i]).abs();
        let bend = (qb.second()[i] - qa.second()[i]).abs();
        let (a, j) = (BLEND_SHARE * l.acceleration[i], BLEND_SHARE * l.jerk[i]);
        d = d.max(0.75 * kink * (faster * speed).powi(2) / a).max((1.5 * kink * (faster * speed).powi(3) / j).sqrt());
        // A step of curvature is spread over 2 d: third derivative about 1.5 bend / (2 d).
        d = d.max(0.75 * bend * speed.powi(3) / j);
    }
    // Some width in any case: a kink that needs no rounding at the feed still must not jump in velocity.
    d.max(SOME_WIDTH[0] * end.first().max_abs().max(SOME_WIDTH[1]))
}
