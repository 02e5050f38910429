//! A limit of a joint, a drive or the spindle is passed ([`OVERTRAVEL`], [`PLANNED_MOTION`],
//! [`DRIVE_SATURATED`], [`SPINDLE_SPEED`], gate `limits`).
//!
//! The control reports them as events, with the limits of the machine file and the tool library.

use proveout_controller::{LimitKind, servo::leg_names};
use proveout_machine::{Joint, JointKind, Machine};

use crate::{
    units::N_M_PER_N_MM,
    verdict::{
        finding::{DRIVE_SATURATED, Finding, LimitSource, OVERTRAVEL, PLANNED_MOTION, SPINDLE_SPEED},
        log::FindingLog,
    },
};

/// What an event of the control says of a limit; `value` and `limit` in the units of the event.
pub(crate) fn finding(
    machine: &Machine,
    joint: Option<usize>,
    [value, limit]: [f64; 2],
    kind: LimitKind,
) -> Option<Finding> {
    if let (LimitKind::DriveForce, Some(legs)) = (kind, joint.and_then(|j| leg_names(machine, j))) {
        return Some(past_leg_force(&legs, [value, limit]));
    }
    let known = joint.and_then(|j| Some((j, machine.joints.get(j)?)));
    let mut f = past_limit(known.map(|(_, joint)| joint), [value, limit], kind)?;
    if let (LimitKind::Travel, Some((index, joint))) = (kind, known) {
        f = f.limited_by(LimitSource::Travel(index));
        f.message.push_str(machine.doubt_of_travel(joint));
    }
    Some(f)
}

/// A leg's drive at its limit, N.
fn past_leg_force(legs: &str, [value, limit]: [f64; 2]) -> Finding {
    let message = format!(
        "the control demands a force of {value:.1} N from the drive of {legs}; its limit is {limit:.1} N, so the platform leaves its set points"
    );
    let mut f = FindingLog::of(&DRIVE_SATURATED, message);
    (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some("N".into()));
    f
}

/// A limit that was passed; `value` and `limit` in the units of the event.
fn past_limit(joint: Option<&Joint>, [value, limit]: [f64; 2], kind: LimitKind) -> Option<Finding> {
    let kind_of_joint = joint.map_or(JointKind::Linear, |j| j.kind);
    let (unit, scale) = (kind_of_joint.unit(), kind_of_joint.unit_factor());
    let name = joint.map_or("a joint", |j| j.name.as_str());
    let (code, message, value, limit, unit) = match kind {
        LimitKind::Travel => {
            let (value, limit) = (value * scale, limit * scale);
            let past = (value - limit).abs();
            let message =
                format!("{name} is sent to {value:.3} {unit}, {past:.3} {unit} past its travel of {limit:.3} {unit}");
            (&OVERTRAVEL, message, value, limit, unit.to_owned())
        }
        LimitKind::DriveForce => {
            let linear = kind_of_joint == JointKind::Linear;
            let (word, unit, scale) = if linear { ("force", "N", 1.0) } else { ("torque", "Nm", N_M_PER_N_MM) };
            let (value, limit) = (value * scale, limit * scale);
            let message = format!(
                "the control demands a {word} of {value:.1} {unit} from the drive of {name}; its limit is {limit:.1} {unit}, so the joint leaves its set points"
            );
            (&DRIVE_SATURATED, message, value, limit, unit.to_owned())
        }
        LimitKind::Velocity | LimitKind::Acceleration | LimitKind::Jerk => {
            let (word, per) = match kind {
                LimitKind::Velocity => ("velocity", "s"),
                LimitKind::Acceleration => ("acceleration", "s²"),
                _ => ("jerk", "s³"),
            };
            let (value, limit, unit) = (value * scale, limit * scale, format!("{unit}/{per}"));
            let message = format!(
                "the set points demand a {word} of {value:.3} {unit} from {name}; its limit is {limit:.3} {unit}"
            );
            (&PLANNED_MOTION, message, value, limit, unit)
        }
        LimitKind::SpindleSpeed => {
            let message = format!("spindle speed {value:.0} 1/min is above the limit of {limit:.0} 1/min");
            let mut f = FindingLog::of(&SPINDLE_SPEED, message);
            (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some("1/min".into()));
            return Some(f);
        }
    };
    let mut f = FindingLog::of(code, message);
    (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some(unit));
    f.bodies = vec![name.into()];
    Some(f)
}
