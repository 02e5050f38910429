//! Corners at which the tool turns back: they are exact stops.
//!
//! A rounded corner leaves its programmed point by `3/16 |w - u| d` (see `path.rs`). The joints
//! must come to rest in the direction of a reversal in any case, so rounding one gains hardly any
//! time, and it takes the point away from the part, which for a hole is its depth. Therefore a
//! tangent that turns by [`REVERSAL`] or more ends the run: the path goes to the programmed point
//! and stops there.
//!
//! ```text
//!        a | ^ b             a \ ^ b
//!          | |                  \|         turned by 180 and by 170 degrees: the point is reached
//!          v |                   v
//!
//!        a \   / b           turned by less: rounded within the tolerance; a rounded corner is passed
//!           \_/              at cos(85) of the feed at 170 degrees, at cos(67.5) at 135 degrees
//! ```
//!
//! The tangent is that of the tip relative to the workpiece: with tool center point control the
//! linear task coordinates; without, the linear joints, or, where rotary joints turn as well, the
//! tip as it moves relative to the table (a cam that is milled by a slide that goes to and fro
//! while the table turns does not turn back). If the tip is at rest in both blocks, the tangent is
//! that of the rotary joints. If it is at rest in one of them, the tip has no corner: the blend
//! brings it to the programmed point, since a polynomial of `corner_rounding.rs` ends on the exact path.
//!
//! *Limits.* Rotary joints that turn back while the tip goes on do not stop: their end is rounded
//! within the tolerance of the orientation, as wherever the tool pivots in a cut. Several kinks
//! close together that turn back in sum are a narrow curve, not a corner, and are rounded within
//! the tolerance.

use proveout_machine::{JointKind, JointValues, Machine};

use super::PathContext;
use crate::jet::JointJet;

/// Turn of the tangent from which on a corner is a reversal, degrees.
pub(super) const REVERSAL_DEG: f64 = 170.0;
/// Parts of a slope below this part of the largest one are rounding.
const NO_SLOPE: f64 = 1e-12;
/// Turn of the fastest rotary joint (radian) and way (mm) over which the direction of the tip is taken by
/// differences: their relative error is the square of the turn.
const SMALL: f64 = 1e-4;

/// Whether the tangent of the first jet turns back in the second; `tip_moves` of both blocks.
pub(super) fn reverses(frame: &PathContext<'_>, tip_moves: [bool; 2], end: &JointJet, start: &JointJet) -> bool {
    let machine = frame.kinematics.machine;
    let slopes = [end.first(), start.first()];
    let rotary = slopes.map(|slope| part(machine, &slope, JointKind::Rotary));
    match tip_moves {
        [true, true] => {
            let turns = rotary.iter().any(|slope| slope.max_abs() > 0.0);
            if turns && !frame.kinematics.is_tcp() {
                opposite(&slopes.map(|slope| way_of_tip(frame, &end.0[0], &slope)))
            } else {
                opposite(&slopes.map(|slope| part(machine, &slope, JointKind::Linear)))
            }
        }
        [false, false] => opposite(&rotary),
        _ => false,
    }
}

fn part(machine: &Machine, slope: &JointValues, kind: JointKind) -> JointValues {
    let mut out = JointValues::ZERO;
    for (i, _) in machine.joints.iter().enumerate().filter(|(_, j)| j.kind == kind) {
        out[i] = slope[i];
    }
    out
}

fn dot(u: &JointValues, w: &JointValues) -> f64 {
    u.0.iter().zip(&w.0).map(|(a, b)| a * b).sum()
}

fn opposite([u, w]: &[JointValues; 2]) -> bool {
    let sizes = [u, w].map(|v| dot(v, v).sqrt());
    let (least, most) = (sizes[0].min(sizes[1]), sizes[0].max(sizes[1]));
    least > NO_SLOPE * most && dot(u, w) <= REVERSAL_DEG.to_radians().cos() * least * most
}

/// Direction in which the tip moves against the table while the joints move by `slope`, in the first three
/// entries.
fn way_of_tip(frame: &PathContext<'_>, at: &JointValues, slope: &JointValues) -> JointValues {
    let h = SMALL / slope.max_abs().max(f64::MIN_POSITIVE);
    let [before, behind] = [-h, h].map(|h| frame.kinematics.pose(&(*at + *slope * h)).tip);
    let mut way = JointValues::ZERO;
    for k in 0..3 {
        way[k] = (behind[k] - before[k]) / (2.0 * h);
    }
    way
}
