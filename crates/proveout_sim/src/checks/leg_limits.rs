//! Limits of the legs of a platform are passed ([`finding::OVERTRAVEL`], [`finding::PLANNED_MOTION`], gate
//! `limits`).
//!
//! The control plans heave and tilt and knows nothing of these limits, so they are checked on the set points
//! at every control sample.

use std::collections::BTreeMap;

use proveout_controller::Sample;
use proveout_machine::{LimitKind, LimitViolation, Limited, Machine, MotionState};

use crate::{
    checks::check::{Check, RunEnd, StretchView},
    verdict::{
        finding::{self, Finding},
        gate::Gate,
        log::FindingLog,
    },
};

/// Part by which rates may pass their limits: as those of the joints.
const RATE_TOLERANCE: f64 = 1e-3;

/// See the module.
#[derive(Debug)]
pub(crate) struct LegLimits;

impl Check for LegLimits {
    fn stretch(&mut self, view: &StretchView<'_>, log: &mut FindingLog) {
        for (mut f, at) in breaches(&view.prepared.machine, &view.chunk.samples) {
            (f.block, f.time_s, f.axes) = (Some(at.block), Some(at.time), view.axes(&at.commanded));
            log.push(f);
        }
    }

    /// Limits that are not stated were not checked.
    fn finish(&mut self, end: &RunEnd<'_>, log: &mut FindingLog) {
        for words in missing(&end.prepared.machine) {
            log.leave_out(Gate::Limits, words);
        }
    }
}

/// The worst breach of each limit of each leg in each block, in the order of the blocks.
fn breaches(machine: &Machine, samples: &[Sample]) -> Vec<(Finding, Sample)> {
    if machine.platforms.is_empty() {
        return Vec::new();
    }
    let mut worst: BTreeMap<(u32, usize, usize, LimitKind), (LimitViolation, Sample)> = BTreeMap::new();
    for sample in samples {
        let state = MotionState {
            q: sample.commanded,
            velocity: sample.velocity,
            acceleration: sample.acceleration,
            jerk: sample.jerk,
        };
        for found in machine.limit_violations(&state, RATE_TOLERANCE) {
            let Limited::Leg { platform, leg } = found.limited else { continue };
            let key = (sample.block, platform, leg, found.kind);
            let excess = |v: &LimitViolation| (v.value.abs() - v.limit.abs()).abs();
            if worst.get(&key).is_none_or(|(known, _)| excess(&found) > excess(known)) {
                worst.insert(key, (found, *sample));
            }
        }
    }
    worst.into_values().map(|(found, sample)| (finding_of(&found), sample)).collect()
}

fn finding_of(found: &LimitViolation) -> Finding {
    let name = &found.name;
    let (value, limit) = (found.value, found.limit);
    let (code, unit, message) = match found.kind {
        LimitKind::Travel => {
            let message = format!("leg {name} would be {value:.3} mm long; its travel ends at {limit:.3} mm");
            (&finding::OVERTRAVEL, "mm", message)
        }
        kind => {
            let (word, unit) = match kind {
                LimitKind::Velocity => ("velocity", "mm/s"),
                LimitKind::Acceleration => ("acceleration", "mm/s²"),
                _ => ("jerk", "mm/s³"),
            };
            let message = format!(
                "the set points demand a {word} of {value:.3} {unit} from leg {name}; its limit is {limit:.3} {unit}"
            );
            (&finding::PLANNED_MOTION, unit, message)
        }
    };
    let mut f = FindingLog::of(code, message);
    (f.value, f.limit, f.unit) = (Some(value), Some(limit), Some(unit.into()));
    f.bodies = vec![name.clone()];
    f
}

/// Limits of legs that are not stated, for the gate.
fn missing(machine: &Machine) -> Vec<String> {
    let legs = machine.platforms.iter().flat_map(|p| &p.legs);
    let of_leg = |leg: &proveout_machine::Leg| {
        let stated = [
            (leg.travel.is_some(), "travel"),
            (leg.max_velocity.is_some(), "velocity"),
            (leg.max_acceleration.is_some(), "acceleration"),
            (leg.max_jerk.is_some(), "jerk"),
        ];
        let missing: Vec<&str> = stated.iter().filter(|(stated, _)| !stated).map(|(_, word)| *word).collect();
        (!missing.is_empty()).then(|| format!("leg {} has no limit of {}", leg.name, missing.join(", ")))
    };
    legs.filter_map(of_leg).collect()
}
