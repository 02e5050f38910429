//! Judges control samples by the promise: no joint passes velocity, acceleration or jerk by more than 0.1
//! percent.
//!
//! The promise is about what the drives get: positions q on the grid of the control's cycle h. Their
//! differences
//!
//! ```text
//!   q1 - q0        q2 - 2 q1 + q0        q3 - 3 q2 + 3 q1 - q0          over h, h^2, h^3
//!   o---o          o---o---o             o---o---o---o
//! ```
//!
//! are means of velocity, acceleration and jerk over one, two and three cycles, weighted by the spline of
//! that order. A short excess between two samples shows there and in no state at a sample; a short one at a
//! sample shows in its state alone. The differences of velocity and acceleration from one sample to the next,
//! means over one cycle, are sharper where they are known. All are looked at, and the differences of
//! positions reach back over the border to what was emitted before. The feed of the tip counts as a velocity
//! too.

use proveout_machine::{JointValues, MAX_JOINTS};

use crate::{limits::JointLimits, profile::PathState, stretch::PlanSample};

/// The number of set points needed before a law (the last of the grid) and after it (those at which
/// the machine is at rest).
pub(crate) const REACH: usize = 3;

/// A place where a limit is passed.
pub(crate) struct Over {
    pub(crate) time: f64,
    pub(crate) s: f64,
    pub(crate) v: f64,
    /// Parts of the limits of velocity, acceleration and jerk.
    pub(crate) ratios: [f64; 3],
}

/// Rounding of positions in a difference, as part of the largest of them: the weights of the third one add up
/// to eight.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Places where samples exceed a part `allowed` of the limits, by their states or by differences.
/// The first lies at the time `first`, or would; `before` are the last set points before it; with
/// `stands` the machine is at rest after the last.
pub(crate) fn over_limits(
    limits: &JointLimits,
    [cycle, first]: [f64; 2],
    before: &[JointValues; REACH],
    samples: &[PlanSample],
    stands: Option<&JointValues>,
    allowed: f64,
) -> Vec<Over> {
    let mut over = Vec::new();
    let parts = LimitReciprocals::new(limits);
    let mut row = [before[0], before[0], before[1], before[2]];
    let after = if stands.is_some() { REACH } else { 0 };
    let last = samples.len().saturating_sub(1);
    for k in 0..samples.len() + after {
        let Some(q) = samples.get(k).map(|m| &m.q).or(stands) else { break };
        row = [row[1], row[2], row[3], *q];
        let state = samples.get(k).map_or([0.0; 3], |m| {
            let [v, a, j] = parts.states(m);
            [v.max(m.feed_use), a, j]
        });
        if let Some([a, b]) = k.checked_sub(1).and_then(|before| samples.get(before..=k)?.first_chunk()) {
            let [acceleration, jerk] = parts.over_a_cycle(cycle, a, b);
            if acceleration > allowed && acceleration > state[1] || jerk > allowed && jerk > state[2] {
                let PathState { s, v, .. } = b.state;
                over.push(Over { time: b.time - 0.5 * cycle, s, v, ratios: [0.0, acceleration, jerk] });
            }
        }
        let mut ratios = parts.differences(cycle, &row);
        // Middles of the differences: half a cycle back for each order.
        let mut back = 0;
        for order in 0..3 {
            if ratios[order] > allowed && ratios[order] > state[order] {
                back = back.max(order + 1);
            } else {
                ratios[order] = 0.0;
            }
        }
        if back > 0 {
            let state = samples.get(k.saturating_sub(back / 2).min(last)).map_or(PathState::default(), |m| m.state);
            let time = first + cycle * (k as f64 - 0.5 * back as f64);
            over.push(Over { time, s: state.s, v: state.v, ratios });
        }
        if let Some(m) = samples.get(k).filter(|_| state.iter().any(|r| *r > allowed)) {
            over.push(Over { time: m.time, s: m.state.s, v: m.state.v, ratios: state });
        }
    }
    over
}

/// One over the limits of velocity, acceleration and jerk of the joints: samples are judged by the hundred
/// thousand.
pub(crate) struct LimitReciprocals {
    count: usize,
    per: [[f64; MAX_JOINTS]; 3],
}

impl LimitReciprocals {
    pub(crate) fn new(l: &JointLimits) -> Self {
        Self { count: l.count, per: [l.velocity, l.acceleration, l.jerk].map(|limits| limits.map(|x| 1.0 / x)) }
    }

    /// Highest parts of the limits of a state.
    fn states(&self, m: &PlanSample) -> [f64; 3] {
        let highest = |values: &JointValues, per: &[f64; MAX_JOINTS]| {
            (0..self.count).fold(0.0, |high: f64, i| high.max(values[i].abs() * per[i]))
        };
        let [v, a, j] = &self.per;
        [highest(&m.velocity, v), highest(&m.acceleration, a), highest(&m.jerk, j)]
    }

    /// Highest parts of the limits of mean acceleration and mean jerk between two samples.
    fn over_a_cycle(&self, cycle: f64, a: &PlanSample, b: &PlanSample) -> [f64; 2] {
        let per = 1.0 / cycle;
        let highest = |from: &JointValues, to: &JointValues, limit: &[f64; MAX_JOINTS]| {
            (0..self.count).fold(0.0, |high: f64, i| high.max((to[i] - from[i]).abs() * per * limit[i]))
        };
        [highest(&a.velocity, &b.velocity, &self.per[1]), highest(&a.acceleration, &b.acceleration, &self.per[2])]
    }

    /// Highest parts of the limits of the first, second and third difference that end at the last of four set
    /// points.
    fn differences(&self, cycle: f64, row: &[JointValues; 4]) -> [f64; 3] {
        let mut ratios = [0.0_f64; 3];
        for i in 0..self.count {
            let means = means(cycle, row, i);
            for order in 0..3 {
                ratios[order] = ratios[order].max(means[order] * self.per[order][i]);
            }
        }
        ratios
    }
}

/// Sizes of the mean velocity, acceleration and jerk of a joint over the last one, two and three cycles, less
/// rounding.
fn means(cycle: f64, row: &[JointValues; 4], joint: usize) -> [f64; 3] {
    let q = row.map(|q| q[joint]);
    let (d0, d1, d2) = (q[1] - q[0], q[2] - q[1], q[3] - q[2]);
    let rounding = ROUNDING * q[3].abs().max(1.0);
    let per = 1.0 / cycle;
    [
        (d2.abs() - rounding) * per,
        ((d2 - d1).abs() - rounding) * per * per,
        (((d2 - d1) - (d1 - d0)).abs() - rounding) * per * per * per,
    ]
}

/// Part of a limit that no set point passes.
const PROMISE: f64 = 1.001;

/// The promised limit that a set point exceeds when it is emitted after three others, by its state
/// or by a difference: joint, order (velocity, acceleration, jerk), value and limit.
pub(crate) fn broken(
    (limits, parts): (&JointLimits, &LimitReciprocals),
    cycle: f64,
    before: &[JointValues; REACH],
    m: &PlanSample,
) -> Option<(usize, usize, f64, f64)> {
    let row = [before[0], before[1], before[2], m.q];
    let highest = |ratios: [f64; 3]| ratios.iter().any(|r| *r > PROMISE);
    if !highest(parts.states(m)) && !highest(parts.differences(cycle, &row)) {
        return None;
    }
    let mut worst = (0, 0, 0.0, f64::INFINITY);
    for i in 0..limits.count {
        let means = means(cycle, &row, i);
        let states = [m.velocity[i], m.acceleration[i], m.jerk[i]];
        for (order, limit) in [limits.velocity[i], limits.acceleration[i], limits.jerk[i]].into_iter().enumerate() {
            let value = states[order].abs().max(means[order]);
            if value / limit > worst.2 / worst.3 {
                worst = (i, order, value, limit);
            }
        }
    }
    Some(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of x = t^3, whose third difference is 6 h^3 exactly, of a joint alone.
    fn cubic(cycle: f64, n: usize, state_jerk: f64) -> Vec<PlanSample> {
        (0..n)
            .map(|k| {
                let t = k as f64 * cycle;
                let one = |x: f64| {
                    let mut q = JointValues::ZERO;
                    q[0] = x;
                    q
                };
                PlanSample {
                    time: 5.0 + t,
                    state: PathState { s: t, v: 1.0, a: 0.0, j: 0.0 },
                    rate: [1.0, 0.0],
                    feed_use: 0.0,
                    q: one(t * t * t),
                    velocity: one(3.0 * t * t),
                    acceleration: one(6.0 * t),
                    jerk: one(state_jerk),
                }
            })
            .collect()
    }

    fn limits(jerk: f64) -> JointLimits {
        let free = [f64::INFINITY; MAX_JOINTS];
        let mut l = JointLimits { count: 1, velocity: free, rapid: free, acceleration: free, jerk: free };
        l.jerk[0] = jerk;
        l
    }

    #[test]
    fn third_differences_tell_what_states_do_not() {
        let before = [JointValues::ZERO; REACH];
        let mut samples = cubic(0.01, 12, 0.0);
        samples.iter_mut().for_each(|m| m.acceleration = JointValues::ZERO);
        assert!(over_limits(&limits(6.0), [0.01, 5.0], &before, &samples, None, 1.0 + 1e-6).is_empty());
        // From the fourth set point on, each difference is 6; those that reach back to the standstill are 1,
        // 5 and 6 parts of it.
        let over = over_limits(&limits(5.5), [0.01, 5.0], &before, &samples, None, 1.0 + 1e-6);
        assert_eq!(over.len(), 9);
        for (k, o) in over.iter().enumerate() {
            assert!((o.ratios[2] - 6.0 / 5.5).abs() < 1e-6 && o.ratios[..2] == [0.0, 0.0], "{:?}", o.ratios);
            assert!((o.time - (5.015 + 0.01 * k as f64)).abs() < 1e-12, "{}", o.time);
        }
    }

    #[test]
    fn the_mean_jerk_of_a_cycle_is_the_difference_of_its_accelerations() {
        let samples = cubic(0.01, 12, 0.0);
        let over = over_limits(&limits(5.5), [0.01, 5.0], &[samples[0].q; REACH], &samples, None, 1.0 + 1e-6);
        let means: Vec<&Over> = over.iter().filter(|o| ((o.time - 5.0) * 100.0).fract().abs() > 0.4).collect();
        assert!(means.len() >= 11 && means.iter().all(|o| (o.ratios[2] - 6.0 / 5.5).abs() < 1e-6));
    }

    #[test]
    fn differences_reach_over_both_ends() {
        let samples = cubic(0.01, 6, 6.0);
        let stop = samples[5].q;
        let over = |before: f64, stands: Option<&JointValues>| {
            let mut q = JointValues::ZERO;
            q[0] = before;
            over_limits(&limits(7.0), [0.01, 5.0], &[q; REACH], &samples, stands, 1.0).len()
        };
        assert_eq!(over(0.0, None), 0);
        assert_eq!(over(1e-4, None), 3, "a step before the first sample");
        assert_eq!(over(0.0, Some(&stop)), 2, "a stop in no time");
        // A motion between two times of the grid has no sample of its own.
        let none = over_limits(&limits(7.0), [0.01, 5.0], &[JointValues::ZERO; REACH], &[], Some(&stop), 1.0);
        assert_eq!(none.len(), 3);
    }

    #[test]
    fn what_breaks_the_promise_is_named() {
        let samples = cubic(0.01, 6, 6.0);
        let before = [samples[0].q, samples[1].q, samples[2].q];
        let broken_at =
            |jerk: f64| broken((&limits(jerk), &LimitReciprocals::new(&limits(jerk))), 0.01, &before, &samples[3]);
        assert_eq!(broken_at(6.0), None);
        assert_eq!(broken_at(5.995), None, "within 0.1 percent");
        let (joint, order, value, limit) = broken_at(5.9).expect("jerk 6 of 5.9");
        assert!(joint == 0 && order == 2 && (value - 6.0).abs() < 1e-6 && limit == 5.9);
    }
}
