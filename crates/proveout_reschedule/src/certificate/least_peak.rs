//! The least peak of acceleration or jerk that a joint needs for a channel at programmed times: a linear
//! program with its dual.
//!
//! *Primal.* A joint passes gate i at the time `t_i`. Divided differences of its positions are means of its
//! derivatives: with nodes `t_i .. t_i+m`
//!
//! ```text
//!   D_i q = m! sum_k q_i+k / prod_(l != k) (t_i+k - t_i+l)
//!         = integral of q^(m) B_i,    B_i >= 0, integral of B_i = 1      (Peano kernel)
//! ```
//!
//! so that *every* motion with `|q^(m)| <= z` has `|D_i q| <= z`, whatever it does between the gates. The
//! least z of `|D_i q| <= z`, with q in the gates and each step `q_i+1 - q_i` between `a_i` and `b_i` (the
//! velocity limit; zero on one side where the joint must not turn back) is therefore a bound for all motions
//! in the channel at these times.
//!
//! *Dual.* For any weights w with `sum |w_i| <= 1` and any pushes p
//!
//! ```text
//!   z  >=  sum w_i D_i q
//!      >=  sum w_i D_i q + sum p_i (q_i+1 - q_i) - P  =  c . q - P
//!      >=  C - P
//!
//!   P = sum of p_i b_i where p_i > 0, p_i a_i where not
//!   C = sum of c_g low_g where c_g > 0, c_g high_g where not
//! ```
//!
//! Nothing has to be believed of a solver: whatever w and p it gives, C - P is a bound. That is what is
//! written out, and what `cargo xtask verify-schedule` counts again.
//!
//! Solved by the interior-point method of `smooth/corridor_program.rs`, in time that grows with the blocks.

use crate::smooth::corridor_program::{CorridorProgram, CorridorRow, WEIGHTS};

/// Part of the largest weight below which one is rounding of the solver.
const NOTHING: f64 = 1e-9;
/// Least unit of positions, radian: gates that are points stay numbers.
const LEAST_UNIT: f64 = 1e-9;

/// A least peak with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastPeak {
    /// 2: acceleration, 3: jerk.
    pub order: usize,
    /// Lowest and highest velocity of all steps, in units of the gates and seconds.
    pub velocity: [f64; 2],
    /// The peak of the best row of positions that was found, in units of the gates and seconds.
    pub reached: f64,
    /// What the dual proves: no motion in the channel has less.
    pub proved: f64,
    /// Weight of each divided difference.
    pub weights: Vec<f64>,
    /// What the limits of each step push: above zero at the highest velocity, below at the lowest.
    pub pushes: Vec<f64>,
}

/// Weights of a divided difference on its positions.
fn difference(nodes: &[f64]) -> [f64; WEIGHTS] {
    let order = nodes.len() - 1;
    let factorial: f64 = (1..=order).map(|k| k as f64).product();
    let mut weights = [0.0; WEIGHTS];
    for (k, weight) in weights.iter_mut().enumerate().take(nodes.len()) {
        let product: f64 = (0..nodes.len()).filter(|l| *l != k).map(|l| nodes[k] - nodes[l]).product();
        *weight = factorial / product;
    }
    weights
}

/// The largest divided difference of an order.
fn peak(times: &[f64], positions: &[f64], order: usize) -> f64 {
    let one = |i: usize| -> f64 {
        let weights = difference(&times[i..=i + order]);
        weights.iter().zip(&positions[i..=i + order]).map(|(w, q)| w * q).sum()
    };
    (0..positions.len().saturating_sub(order)).map(|i| one(i).abs()).fold(0.0, f64::max)
}

impl LeastPeak {
    /// The least peak of a derivative (2 or 3) over blocks of these times (s) in gates, one more, with steps
    /// between these velocities. `start` is any row of positions. None where the gates are open or empty,
    /// there are too few, or none was found: no motion passes at these times, mostly.
    pub fn new(least: &[f64], gates: &[[f64; 2]], order: usize, velocity: [f64; 2], start: &[f64]) -> Option<Self> {
        let n = gates.len();
        let sound = |t: &f64| t.is_finite() && *t > 0.0;
        let open = |[low, high]: &[f64; 2]| !(low.is_finite() && high.is_finite() && low <= high);
        if n < WEIGHTS + 1 || n != least.len() + 1 || start.len() != n || !matches!(order, 2 | 3) {
            return None;
        }
        if gates.iter().any(open) || !least.iter().all(sound) || open(&velocity) {
            return None;
        }
        let times = times(least);
        // In units in which positions and differences are about one.
        let zero = gates[0][0];
        let unit =
            gates.iter().map(|[low, high]| (high - zero).abs().max((low - zero).abs())).fold(LEAST_UNIT, f64::max);
        let slowest = times[n - 1].powi(-(order as i32));
        let scale = (peak(&times, start, order) / unit).max(slowest);
        let placed = |at: usize, weights: [f64; WEIGHTS]| {
            // A row is placed where all of its weights have an unknown.
            let shift = (at + WEIGHTS).saturating_sub(n);
            let mut moved = [0.0; WEIGHTS];
            moved[shift..].copy_from_slice(&weights[..WEIGHTS - shift]);
            (at - shift, moved)
        };
        let mut rows = Vec::with_capacity(3 * n);
        for i in 0..n - order {
            let (at, weights) = placed(i, difference(&times[i..=i + order]).map(|w| w / scale));
            rows.push(CorridorRow { at, weights, low: 0.0, high: 0.0, peak: true });
        }
        let peaks = rows.len();
        // Steps in parts of the fastest one.
        let fastest = velocity[0].abs().max(velocity[1].abs()).max(f64::MIN_POSITIVE) / unit;
        for (i, t) in least.iter().enumerate() {
            let slope = 1.0 / (t * fastest);
            let (at, weights) = placed(i, [-slope, slope, 0.0, 0.0]);
            let [low, high] = velocity.map(|v| v / unit / fastest);
            rows.push(CorridorRow { at, weights, low, high, peak: false });
        }
        let slopes = rows.len();
        for (i, [low, high]) in gates.iter().enumerate() {
            let (at, weights) = placed(i, [1.0, 0.0, 0.0, 0.0]);
            rows.push(CorridorRow { at, weights, low: (low - zero) / unit, high: (high - zero) / unit, peak: false });
        }
        let program = CorridorProgram { unknowns: n, rows, smoothness: 0.0, peak_cost: 1.0 };
        let begin: Vec<f64> = start.iter().map(|q| (q - zero) / unit).collect();
        let (_, reached, pushes) = program.solved_with_multipliers(&begin)?;
        let most = pushes[..peaks].iter().fold(0.0_f64, |m, w| m.max(w.abs()));
        let kept = |w: f64| if w.abs() > NOTHING * most { w } else { 0.0 };
        let weights: Vec<f64> = pushes[..peaks].iter().map(|w| kept(*w)).collect();
        let steps = pushes[peaks..slopes].iter().zip(least);
        let steps: Vec<f64> = steps.map(|(push, t)| kept(*push) * scale / (t * fastest)).collect();
        let total: f64 = weights.iter().map(|w| w.abs()).sum();
        let even = |v: Vec<f64>| v.into_iter().map(|w| w / total.max(f64::MIN_POSITIVE)).collect();
        let mut out = Self {
            order,
            velocity,
            reached: reached * scale * unit,
            proved: 0.0,
            weights: even(weights),
            pushes: even(steps),
        };
        out.proved = out.counted(&times, gates);
        if out.proved < 0.0 {
            // Rounding of a channel that a motion without any passes: no weights prove zero.
            out.weights.fill(0.0);
            out.pushes.fill(0.0);
            out.proved = 0.0;
        }
        Some(out)
    }

    /// What the weights prove.
    fn counted(&self, times: &[f64], gates: &[[f64; 2]]) -> f64 {
        let mut pull = vec![0.0; gates.len()];
        for (i, weight) in self.weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            for (k, d) in difference(&times[i..=i + self.order]).iter().take(self.order + 1).enumerate() {
                pull[i + k] += weight * d;
            }
        }
        let mut limits = 0.0;
        for (i, push) in self.pushes.iter().enumerate() {
            pull[i + 1] += push;
            pull[i] -= push;
            limits += push * self.velocity[usize::from(*push > 0.0)] * (times[i + 1] - times[i]);
        }
        pull.iter().zip(gates).map(|(c, [low, high])| if *c > 0.0 { c * low } else { c * high }).sum::<f64>() - limits
    }
}

fn times(least: &[f64]) -> Vec<f64> {
    let mut times = vec![0.0];
    for t in least {
        times.push(times[times.len() - 1] + t);
    }
    times
}

/// The peak of a derivative (2 or 3) of positions at programmed times, as the bound counts it: by divided
/// differences.
pub fn peak_of(least: &[f64], positions: &[f64], order: usize) -> f64 {
    peak(&times(least), positions, order)
}

#[cfg(test)]
mod tests {
    use super::super::tests::Random;
    use super::*;

    #[test]
    fn up_and_down_again_takes_two_parabolas() {
        // From below 0 at both ends to above 1 in the middle of a second: q = 1 - a t^2 / 2 with q(1/2) = 0.
        for n in [40_usize, 400] {
            let least = vec![1.0 / n as f64; n];
            let gates: Vec<[f64; 2]> = (0..=n)
                .map(|i| match i {
                    0 => [-1.0, 0.0],
                    i if i == n => [-1.0, 0.0],
                    i if i == n / 2 => [1.0, 2.0],
                    _ => [-3.0, 3.0],
                })
                .collect();
            let start: Vec<f64> = (0..=n).map(|i| (3.1 * i as f64 / n as f64).sin()).collect();
            let found = LeastPeak::new(&least, &gates, 2, [-1e3, 1e3], &start).expect("a solution");
            assert!((found.proved - 8.0).abs() < 0.1 && found.proved <= found.reached * (1.0 + 1e-6), "{found:?}");
            assert!((found.reached / found.proved - 1.0).abs() < 1e-4, "{} {}", found.reached, found.proved);
        }
    }

    /// Motions of waves in channels round them, at times that are even or not: no peak of a motion is below
    /// what is proved for its channel, and primal and dual meet.
    #[test]
    fn no_motion_in_a_channel_has_less_and_the_dual_meets_the_primal() {
        let mut random = Random(71);
        let (mut monotone, mut limited, mut met) = (0, 0, 0);
        for case in 0..120 {
            let n = 12 + (120.0 * random.next()) as usize;
            let least: Vec<f64> =
                (0..n).map(|_| if case % 2 == 0 { 0.05 } else { random.between(0.02, 0.1) }).collect();
            let at = times(&least);
            let waves: Vec<[f64; 3]> = (0..3)
                .map(|_| [random.between(0.05, 0.5), random.between(0.3, 6.0), random.between(0.0, 6.3)])
                .collect();
            // Every third motion rises all the way.
            let drift = if case % 3 == 0 { 1.01 * waves.iter().map(|[a, w, _]| a * w).sum::<f64>() } else { 0.0 };
            let value = |t: f64, order: i32| -> f64 {
                let quarter = f64::from(order) * std::f64::consts::FRAC_PI_2;
                let wave: f64 = waves.iter().map(|[a, w, p]| a * w.powi(order) * (w * t + p + quarter).sin()).sum();
                wave + [drift * t, drift][order.clamp(0, 1) as usize] * f64::from(u8::from(order < 2))
            };
            let width = 10_f64.powf(random.between(-3.0, -0.5));
            let motion: Vec<f64> = at.iter().map(|t| value(*t, 0)).collect();
            let gates: Vec<[f64; 2]> =
                motion.iter().map(|q| [q - width * random.next(), q + width * random.next()]).collect();
            let fastest = (0..=4000).map(|k| value(at[n] * f64::from(k) / 4000.0, 1).abs()).fold(0.0, f64::max);
            let velocity = [if drift > 0.0 { 0.0 } else { -1.001 * fastest }, 1.001 * fastest];
            for order in [2, 3] {
                let largest =
                    (0..=4000).map(|k| value(at[n] * f64::from(k) / 4000.0, order as i32).abs()).fold(0.0, f64::max);
                let Some(found) = LeastPeak::new(&least, &gates, order, velocity, &motion) else { continue };
                assert!(found.proved <= largest * 1.001, "{case}: {} above {largest}", found.proved);
                assert!(found.proved <= found.reached * (1.0 + 1e-6) + 1e-9, "{case}");
                monotone += usize::from(drift > 0.0 && found.pushes.iter().any(|p| *p < 0.0));
                limited += usize::from(found.pushes.iter().any(|p| *p > 0.0));
                met += usize::from(found.reached - found.proved < 1e-3 * found.reached.max(1e-3));
            }
        }
        assert!(monotone > 20 && limited > 20 && met > 200, "{monotone} {limited} {met} of 240");
    }

    #[test]
    fn what_is_no_channel_has_none() {
        let gates = [[0.0, 1.0]; 9];
        assert!(LeastPeak::new(&[0.1; 8], &gates, 2, [-9.0, 9.0], &[0.5; 9]).is_some_and(|p| p.proved.abs() < 1e-9));
        assert!(LeastPeak::new(&[0.1; 7], &gates, 2, [-9.0, 9.0], &[0.5; 9]).is_none());
        assert!(LeastPeak::new(&[0.1; 8], &gates, 4, [-9.0, 9.0], &[0.5; 9]).is_none());
        // From 0 to 1 in 0.1 s at no more than 5 a second.
        let mut far = [[0.0, 0.0]; 9];
        far[4..].fill([1.0, 1.0]);
        assert!(LeastPeak::new(&[0.1; 8], &far, 2, [-5.0, 5.0], &[0.5; 9]).is_none());
        let mut open = gates;
        open[3][1] = f64::INFINITY;
        assert!(LeastPeak::new(&[0.1; 8], &open, 2, [-9.0, 9.0], &[0.5; 9]).is_none());
    }
}
