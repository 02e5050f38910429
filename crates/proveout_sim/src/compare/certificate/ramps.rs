//! A schedule without its ramps: what is left to gain where the axes are under way.
//!
//! Lead-in and lead-out keep their axis, so that every joint of the stretch begins and ends at
//! rest. No schedule of a channel can save the time that this costs. The bound does not count it,
//! since it says nothing of how a stretch begins and ends. Time and bound are therefore compared a
//! second time, between the first block that begins [`RAMP`] after the start and the last one that
//! ends as long before the end: the bound holds for a part of the blocks as it does for all of
//! them.

use proveout_reschedule::{JointGates, Schedules};
use serde::Serialize;

use super::{WindowCertificate, window};

/// What is left out at either end, s of the new program.
const RAMP: f64 = 0.5;

/// Time and bound of the blocks between the ramps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RampsApart {
    /// What is left out at least at either end, s.
    pub ramp_s: f64,
    /// First and last gate of what is left; 0 is the begin of the stretch.
    pub gates: [usize; 2],
    /// Time of the new program between them, s.
    pub time_s: f64,
    /// No schedule of the channel is below, s.
    pub bound_s: f64,
    /// How much longer the new program takes, percent of the bound.
    pub gap_percent: f64,
    /// The proof: consecutive windows, from the first gate to the last; gates are those of the
    /// stretch.
    pub windows: Vec<WindowCertificate>,
}

impl RampsApart {
    /// None where less than one block is left, or no more time than the ramps take.
    pub(super) fn new(counted: &Schedules, seams: &[f64], new_s: &[f64]) -> Option<Self> {
        let whole: f64 = new_s.iter().sum();
        let mut at = 0.0;
        let mut starts = vec![at];
        starts.extend(new_s.iter().map(|t| {
            at += t;
            at
        }));
        let from = starts.partition_point(|t| *t < RAMP);
        let to = starts.partition_point(|t| *t <= whole - RAMP).checked_sub(1)?;
        if from >= to {
            return None;
        }
        let time_s: f64 = new_s.get(from..to)?.iter().sum();
        if time_s <= 2.0 * RAMP {
            return None;
        }
        let joints = counted.joints.iter().map(|j| JointGates { gates: j.gates[from..=to].to_vec(), ..j.clone() });
        let part = Schedules { least: counted.least.get(from..to)?.to_vec(), joints: joints.collect() };
        let found = part.certificate_within(seams.get(from..=to)?).ok()?;
        let shifted = |mut w: WindowCertificate| {
            w.gates.iter_mut().for_each(|g| *g += from);
            w
        };
        let windows = found.windows.iter().map(|(proof, time)| shifted(window(proof, *time, &part))).collect();
        let bound_s = found.bound;
        let gap_percent = 100.0 * (time_s / bound_s - 1.0);
        Some(Self { ramp_s: RAMP, gates: [from, to], time_s, bound_s, gap_percent, windows })
    }
}

#[cfg(test)]
mod tests {
    use proveout_reschedule::SwingLimits;

    use super::*;

    fn turning() -> Schedules {
        // Sixty blocks of 0.1 s; the joint must go from 0 to 6 rad in one sense: 1 rad/s, as fast as it may.
        let gates = (0..=60).map(|k| [0.1 * f64::from(k), 0.1 * f64::from(k) + 1e-3]).collect();
        let limits = SwingLimits { velocity: 1.0, acceleration: 10.0, jerk: 100.0 };
        Schedules { least: vec![0.05; 60], joints: vec![JointGates { name: "C".into(), limits, gates }] }
    }

    #[test]
    fn slow_ends_are_left_out_and_a_slow_middle_is_not() {
        let mut new_s = vec![0.1; 60];
        (new_s[0], new_s[59]) = (0.4, 0.4);
        let found = RampsApart::new(&turning(), &[0.0; 61], &new_s).expect("long enough");
        // 0.4 s + 0.1 s are the ramp; three blocks of 0.1 s would be less.
        assert_eq!(found.gates, [2, 58]);
        assert!((found.time_s - 5.6).abs() < 1e-9 && (found.bound_s - 5.599).abs() < 1e-9, "{found:?}");
        assert!((found.gap_percent - 100.0 * (5.6 / 5.599 - 1.0)).abs() < 1e-9);
        assert_eq!((found.windows[0].gates[0], found.windows.last().expect("one").gates.last()), (2, Some(&58)));
        new_s[30] = 0.2;
        assert!(RampsApart::new(&turning(), &[0.0; 61], &new_s).expect("long enough").gap_percent > 1.7);
    }

    #[test]
    fn a_stretch_of_ramps_has_no_middle() {
        for times in [vec![], vec![1.0], vec![0.5, 0.5], vec![0.2; 9]] {
            let mut short = turning();
            short.least.truncate(times.len());
            short.joints[0].gates.truncate(times.len() + 1);
            assert_eq!(RampsApart::new(&short, &vec![0.0; times.len() + 1], &times), None, "{times:?}");
        }
    }
}
