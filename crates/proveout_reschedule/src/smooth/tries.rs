//! Schedules that the control was asked about, and which of them is handed out.
//!
//! ```text
//!   peak |  x  least peak of the programmed times
//!        |     \
//!        |       x  two between them: limits of a channel are convex, and so is the peak, which
//!        |         x   is no higher than the straight line here
//!        |            x  fastest for the control
//!        +---------------- sooner
//! ```
//!
//! The control takes the feeds of blocks in steps; where the table speeds up within a block's time it loses
//! half a step, so that the motion with the least peak over all times is not the one that it runs through
//! soonest.

/// Ways from the fastest schedule to the most even one that are tried.
const BETWEEN: [f64; 2] = [0.4, 0.7];
/// Length of the ramp at either end that is left out when schedules are compared by their peaks, s.
const RAMPS: f64 = 0.5;

/// A schedule that was tried.
#[derive(Clone, Debug)]
pub(super) struct TimedSchedule {
    pub(super) angles: Vec<f64>,
    /// Of the control, s.
    pub(super) time: f64,
    /// Largest acceleration between the ramps as it was planned, rad/s2.
    pub(super) asked: Option<f64>,
}

/// Schedules between the fastest and the one with the least peak; none where these are one.
pub(super) fn between(all: &[TimedSchedule], least: &[f64]) -> Vec<Vec<f64>> {
    let least_of =
        |of: &dyn Fn(&TimedSchedule) -> f64| (0..all.len()).min_by(|a, b| of(&all[*a]).total_cmp(&of(&all[*b])));
    let ends = least_of(&|t| t.time).zip(least_of(&|t| peak_between_ramps(&t.angles, least)));
    let Some((fast, even)) = ends.filter(|(fast, even)| fast != even) else { return Vec::new() };
    let pair = |w: f64| all[fast].angles.iter().zip(&all[even].angles).map(|(f, e)| f + w * (e - f)).collect();
    BETWEEN.map(pair).into()
}

/// Of the schedules that take no more than a part of the least time longer the one with the least peak.
pub(super) fn chosen(all: Vec<TimedSchedule>, least: &[f64], given_up: f64) -> Option<TimedSchedule> {
    let fastest = all.iter().map(|t| t.time).fold(f64::INFINITY, f64::min);
    let near = all.into_iter().filter(|t| t.time <= fastest * (1.0 + given_up));
    let peaks = near.map(|t| (peak_between_ramps(&t.angles, least), t));
    peaks.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, tried)| tried)
}

/// Largest rate of change over blocks, and of its change, s.
pub(crate) fn peaks(angles: &[f64], least: &[f64]) -> [f64; 2] {
    let rate: Vec<f64> = angles.windows(2).zip(least).map(|(q, t)| (q[1] - q[0]) / t).collect();
    let change = rate.windows(2).zip(least.windows(2)).map(|(v, t)| 2.0 * (v[1] - v[0]) / (t[0] + t[1]));
    [rate.iter().fold(0.0, |m, v| v.abs().max(m)), change.fold(0.0, |m, a| a.abs().max(m))]
}

/// Largest acceleration at the programmed feed but for the first and the last [`RAMPS`], rad/s2.
fn peak_between_ramps(angles: &[f64], least: &[f64]) -> f64 {
    let skipped = |times: &mut dyn Iterator<Item = &f64>| {
        let mut sum = 0.0;
        times.take_while(|t| (sum < RAMPS, sum += **t).0).count()
    };
    let (from, behind) = (skipped(&mut least.iter()), skipped(&mut least.iter().rev()));
    let to = least.len() - behind;
    if from >= to { 0.0 } else { peaks(&angles[from..=to], &least[from..to])[1] }
}

/// Largest acceleration at the programmed feed, from rest and to rest, rad/s2.
pub(super) fn effort(angles: &[f64], least: &[f64]) -> f64 {
    let rate = |i: Option<usize>| i.and_then(|i| Some((angles.get(i + 1)? - angles.get(i)?) / least[i]));
    let ends = [(rate(Some(0)), least.first()), (rate(least.len().checked_sub(1)), least.last())];
    let jumps = ends.into_iter().filter_map(|(rate, time)| Some(rate?.abs() / time?));
    jumps.fold(peaks(angles, least)[1], f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten blocks of 0.2 s; a half second at either end is no matter.
    fn tried(time: f64, middle: f64) -> TimedSchedule {
        let mut angles: Vec<f64> = (0..=10).map(f64::from).collect();
        angles[5] += middle;
        angles[0] -= 7.0;
        TimedSchedule { angles, time, asked: None }
    }

    #[test]
    fn of_schedules_that_are_nearly_as_fast_the_most_even_one_is_taken() {
        let least = [0.2; 10];
        let all = || vec![tried(10.0, 0.3), tried(10.009, 0.2), tried(10.2, 0.1), tried(10.005, 0.25)];
        let time = |given: f64| chosen(all(), &least, given).expect("one").time;
        assert_eq!([0.0, 0.001, 0.03].map(time), [10.0, 10.009, 10.2]);
        assert!(chosen(Vec::new(), &least, 0.1).is_none());
        let found = between(&all(), &least);
        assert_eq!(found.len(), 2);
        assert!((found[0][5] - 5.22).abs() < 1e-12 && (found[1][5] - 5.16).abs() < 1e-12, "{found:?}");
        assert!(between(&all()[..1], &least).is_empty(), "the fastest is the most even one");
    }

    #[test]
    fn ramps_are_left_out_of_a_peak() {
        let least = [0.2; 10];
        let peak = peak_between_ramps(&tried(1.0, 0.3).angles, &least);
        // A second difference of 0.6 in steps of 0.2 s; the jump at the begin is thirty times that.
        assert!((peak - 0.6 / 0.04).abs() < 1e-9, "{peak}");
        assert_eq!(peak_between_ramps(&[0.0, 1.0, 5.0], &[0.4, 0.4]), 0.0, "nothing but ramps");
        assert_eq!(peak_between_ramps(&[0.0], &[]), 0.0);
    }
}
