//! Quadratic programs whose rows look at a few neighbors: an interior-point method in time that grows with
//! the length only.
//!
//! ```text
//!   minimize   1/2 w sum (third difference of x)^2  +  c z
//!
//!   with       low_r <= a_r x <= high_r      |a_p x| <= z   (peak rows)
//! ```
//!
//! Every row `a_r` has up to four weights at unknowns that follow each other, so that the normal equations
//! are a band of three diagonals on each side with one full column for z. Primal-dual steps with a predictor
//! and a corrector (S. Mehrotra 1992, On the implementation of a primal-dual interior point method, SIAM J.
//! Optim. 2, 575-601; J. Nocedal, S. J. Wright 2006, Numerical optimization, section 16.6):
//!
//! ```text
//!   G y + s = h,  s, l >= 0        (P + G' (l/s) G) dy = -r_d + G' (r_c / s - (l/s) r_p)
//! ```
//!
//! The band is factored by Cholesky; the column is taken out by its Schur complement. One thread, sums in a
//! fixed order: the same numbers everywhere.

use crate::band::{factor, solve};

/// Weights of a row.
pub(crate) const WEIGHTS: usize = 4;
/// Diagonals of the band, the main one counted.
const BAND: usize = 4;
/// Steps after which a program counts as one without a solution.
const MOST_STEPS: usize = 80;
/// Mean product of slack and multiplier at the end, in the units of rows that are about one.
const CENTERED: f64 = 1e-9;
/// Largest violation of a row at the end.
const HELD: f64 = 1e-9;
/// By how much z starts above the peaks of the start.
const OVER_PEAKS: f64 = 1e-3;
/// Least slack of a row at the start.
const LEAST_SLACK: f64 = 1e-2;
/// Largest slope of the Lagrangian at the end.
const STEEP: f64 = 1e-5;
/// Added to the diagonal of the band: part of its largest element, and a number in any case.
const DAMPING: [f64; 2] = [1e-15, 1e-13];

/// A row: `low <= sum weights[k] x[at + k] <= high`; a peak row has z in place of both limits and ignores
/// them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CorridorRow {
    pub(crate) at: usize,
    pub(crate) weights: [f64; WEIGHTS],
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) peak: bool,
}

impl CorridorRow {
    pub(super) fn value(&self, x: &[f64]) -> f64 {
        self.weights.iter().zip(&x[self.at..]).map(|(w, x)| w * x).sum()
    }
}

/// A program.
#[derive(Clone, Debug, Default)]
pub(crate) struct CorridorProgram {
    pub(crate) unknowns: usize,
    pub(crate) rows: Vec<CorridorRow>,
    /// w.
    pub(crate) smoothness: f64,
    /// c; no z where it is zero.
    pub(crate) peak_cost: f64,
}

/// One side of a row: `sign a x - (z) <= bound`.
#[derive(Clone, Copy)]
struct OneSidedRow {
    row: u32,
    sign: f64,
    bound: f64,
    peak: bool,
}

/// Symmetric matrix of [`BAND`] diagonals: `m[i][k]` is the element (i, i - k).
type Band = Vec<[f64; BAND]>;

/// State of the iteration.
struct Point {
    x: Vec<f64>,
    z: f64,
    slack: Vec<f64>,
    multiplier: Vec<f64>,
}

impl CorridorProgram {
    fn sides(&self) -> Vec<OneSidedRow> {
        let mut sides = Vec::with_capacity(2 * self.rows.len());
        for (row, r) in (0..).zip(&self.rows) {
            let [low, high] = if r.peak { [0.0; 2] } else { [r.low, r.high] };
            if high.is_finite() {
                sides.push(OneSidedRow { row, sign: 1.0, bound: high, peak: r.peak });
            }
            if low.is_finite() {
                sides.push(OneSidedRow { row, sign: -1.0, bound: -low, peak: r.peak });
            }
        }
        sides
    }

    /// Adds `w` times the third differences' normal matrix, or its product with x.
    fn smooth_band(&self, band: &mut Band) {
        const D: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];
        for at in 0..self.unknowns.saturating_sub(3) {
            for a in 0..4 {
                for b in 0..=a {
                    band[at + a][a - b] += self.smoothness * D[a] * D[b];
                }
            }
        }
    }

    fn smooth_product(&self, x: &[f64], out: &mut [f64]) {
        const D: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];
        for at in 0..self.unknowns.saturating_sub(3) {
            let third: f64 = D.iter().zip(&x[at..]).map(|(d, x)| d * x).sum();
            for (k, d) in D.iter().enumerate() {
                out[at + k] += self.smoothness * d * third;
            }
        }
    }

    fn value(&self, side: &OneSidedRow, x: &[f64], z: f64) -> f64 {
        side.sign * self.rows[side.row as usize].value(x) - if side.peak { z } else { 0.0 }
    }

    /// `out += G' v`; gives the part of z.
    fn transposed(&self, sides: &[OneSidedRow], v: &[f64], out: &mut [f64]) -> f64 {
        let mut of_z = 0.0;
        for (side, v) in sides.iter().zip(v) {
            let row = &self.rows[side.row as usize];
            for (w, out) in row.weights.iter().zip(&mut out[row.at..]) {
                *out += side.sign * v * w;
            }
            if side.peak {
                of_z -= v;
            }
        }
        of_z
    }

    /// The solution from a start that need not hold any row: unknowns and z. None where there is none, or
    /// where none was found.
    pub(super) fn solved(&self, start: &[f64]) -> Option<(Vec<f64>, f64)> {
        self.solved_with_multipliers(start).map(|(x, z, _)| (x, z))
    }

    /// The same, with what each row pushes: the multiplier of its upper limit less that of its lower one.
    pub(crate) fn solved_with_multipliers(&self, start: &[f64]) -> Option<(Vec<f64>, f64, Vec<f64>)> {
        let sides = self.sides();
        let n = self.unknowns;
        let with_z = self.peak_cost > 0.0;
        if start.len() != n || self.rows.iter().any(|r| r.at + WEIGHTS > n) || sides.is_empty() {
            return None;
        }
        let peaks = self.rows.iter().filter(|r| r.peak).map(|r| r.value(start).abs()).fold(0.0, f64::max);
        let mut now =
            Point { x: start.to_vec(), z: 1.1 * peaks + OVER_PEAKS, slack: Vec::new(), multiplier: Vec::new() };
        now.slack = sides.iter().map(|s| (s.bound - self.value(s, &now.x, now.z)).max(LEAST_SLACK)).collect();
        now.multiplier = now.slack.iter().map(|s| (0.1 / s).min(10.0)).collect();
        let count = sides.len() as f64;
        for _ in 0..MOST_STEPS {
            let mean = now.slack.iter().zip(&now.multiplier).map(|(s, l)| s * l).sum::<f64>() / count;
            let primal: Vec<f64> = sides
                .iter()
                .zip(&now.slack)
                .map(|(side, s)| self.value(side, &now.x, now.z) + s - side.bound)
                .collect();
            let violated = primal.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
            let mut dual = vec![0.0; n];
            self.smooth_product(&now.x, &mut dual);
            let dual_z = self.transposed(&sides, &now.multiplier, &mut dual) + self.peak_cost;
            if !mean.is_finite() {
                return None;
            }
            let steep = dual.iter().fold(dual_z.abs(), |m, r| m.max(r.abs()));
            if mean < CENTERED && violated < HELD && steep < STEEP {
                let mut pushes = vec![0.0; self.rows.len()];
                for (side, multiplier) in sides.iter().zip(&now.multiplier) {
                    pushes[side.row as usize] += side.sign * multiplier;
                }
                return Some((now.x, now.z, pushes));
            }
            let mut band: Band = vec![[0.0; BAND]; n];
            self.smooth_band(&mut band);
            let mut column = vec![0.0; n];
            let mut corner = 0.0;
            for (side, (s, l)) in sides.iter().zip(now.slack.iter().zip(&now.multiplier)) {
                let weight = l / s;
                let row = &self.rows[side.row as usize];
                for a in 0..WEIGHTS {
                    for b in 0..=a {
                        band[row.at + a][a - b] += weight * row.weights[a] * row.weights[b];
                    }
                    if side.peak {
                        column[row.at + a] -= weight * side.sign * row.weights[a];
                    }
                }
                if side.peak {
                    corner += weight;
                }
            }
            let diagonal = band.iter().map(|r| r[0]).fold(0.0, f64::max);
            band.iter_mut().for_each(|r| r[0] += DAMPING[0] * diagonal + DAMPING[1]);
            if !factor(&mut band) {
                return None;
            }
            let mut behind = column.clone();
            solve(&band, &mut behind);
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let schur = corner - dot(&column, &behind);
            // Direction for given products of slack and multiplier.
            let direction = |products: &[f64]| {
                let pull: Vec<f64> =
                    (0..sides.len()).map(|i| (products[i] - now.multiplier[i] * primal[i]) / now.slack[i]).collect();
                let mut dx: Vec<f64> = dual.iter().map(|r| -r).collect();
                let mut dz = -dual_z + self.transposed(&sides, &pull, &mut dx);
                solve(&band, &mut dx);
                dz = if with_z && schur > 0.0 { (dz - dot(&column, &dx)) / schur } else { 0.0 };
                if dz != 0.0 {
                    dx.iter_mut().zip(&behind).for_each(|(x, b)| *x -= b * dz);
                }
                let ds: Vec<f64> = sides.iter().zip(&primal).map(|(side, r)| -r - self.value(side, &dx, dz)).collect();
                let dl: Vec<f64> =
                    (0..sides.len()).map(|i| -(products[i] + now.multiplier[i] * ds[i]) / now.slack[i]).collect();
                (dx, dz, ds, dl)
            };
            let longest = |v: &[f64], d: &[f64]| {
                v.iter().zip(d).filter(|(_, d)| **d < 0.0).map(|(v, d)| -v / d).fold(1.0_f64, f64::min)
            };
            let affine: Vec<f64> = now.slack.iter().zip(&now.multiplier).map(|(s, l)| s * l).collect();
            let (_, _, ds, dl) = direction(&affine);
            let (p, d) = (longest(&now.slack, &ds), longest(&now.multiplier, &dl));
            let reached =
                (0..sides.len()).map(|i| (now.slack[i] + p * ds[i]) * (now.multiplier[i] + d * dl[i])).sum::<f64>()
                    / count;
            let target = mean * (reached / mean).powi(3).clamp(0.0, 1.0);
            let products: Vec<f64> = (0..sides.len()).map(|i| affine[i] + ds[i] * dl[i] - target).collect();
            let (dx, dz, ds, dl) = direction(&products);
            let (p, d) = (0.995 * longest(&now.slack, &ds), 0.995 * longest(&now.multiplier, &dl));
            // With a quadratic cost both steps are the same.
            let (p, d) = if self.smoothness > 0.0 { (p.min(d), p.min(d)) } else { (p, d) };
            now.x.iter_mut().zip(&dx).for_each(|(x, dx)| *x += p * dx);
            now.z += p * dz;
            now.slack.iter_mut().zip(&ds).for_each(|(s, ds)| *s += p * ds);
            now.multiplier.iter_mut().zip(&dl).for_each(|(l, dl)| *l += d * dl);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn second(at: usize, scale: f64) -> CorridorRow {
        CorridorRow { at, weights: [scale, -2.0 * scale, scale, 0.0], low: 0.0, high: 0.0, peak: true }
    }

    fn value(at: usize, low: f64, high: f64) -> CorridorRow {
        let (at, weights) = if at < 4 {
            (0, std::array::from_fn(|k| f64::from(u8::from(k == at))))
        } else {
            (at - 3, [0.0, 0.0, 0.0, 1.0])
        };
        CorridorRow { at, weights, low, high, peak: false }
    }

    /// From 0 to 1 and back to 0 in given steps, ends free of slope: the least peak is that of two parabolas,
    /// known in closed form.
    #[test]
    fn the_least_peak_of_a_bump_is_that_of_its_parabolas() {
        for n in [41_usize, 401, 4001] {
            let middle = n / 2;
            let h = 1.0 / (n - 1) as f64;
            let scale = 1.0 / (h * h) / 100.0;
            let mut rows: Vec<CorridorRow> = (0..n - 3).map(|i| second(i, scale)).collect();
            rows.push(CorridorRow { weights: [0.0, scale, -2.0 * scale, scale], ..second(n - 4, scale) });
            rows.extend((0..n).map(|i| match i {
                0 => value(i, -1.0, 0.0),
                i if i == n - 1 => value(i, -1.0, 0.0),
                i if i == middle => value(i, 1.0, 2.0),
                _ => value(i, -3.0, 3.0),
            }));
            let program = CorridorProgram { unknowns: n, rows, smoothness: 0.0, peak_cost: 1.0 };
            let (x, z) = program.solved(&vec![0.0; n]).expect("a solution");
            // q = 1 - a t^2 / 2 with q(1/2) = 0: a = 8.
            assert!((100.0 * z - 8.0).abs() < 0.5 / n as f64 * 41.0, "{n}: {}", 100.0 * z);
            assert!(program.rows.iter().all(|r| r.peak || (r.value(&x) < r.high + 1e-8 && r.value(&x) > r.low - 1e-8)));
        }
    }

    #[test]
    fn without_a_peak_the_smoothest_way_through_points_is_found() {
        // Through the ends and the middle of a parabola third differences can be zero: the parabola itself.
        let n = 101;
        let rows = [0_usize, 50, 100].map(|i| {
            let q = (i as f64 / 100.0).powi(2);
            value(i, q - 1e-6, q + 1e-6)
        });
        let all = (0..n).map(|i| value(i, -10.0, 10.0));
        let program = CorridorProgram {
            unknowns: n,
            rows: rows.into_iter().chain(all).collect(),
            smoothness: 1e6,
            peak_cost: 0.0,
        };
        let (x, _) = program.solved(&vec![0.5; n]).expect("a solution");
        for (i, x) in x.iter().enumerate() {
            assert!((x - (i as f64 / 100.0).powi(2)).abs() < 1e-4, "{i} {x}");
        }
    }

    #[test]
    fn rows_that_contradict_have_no_solution() {
        let rows = vec![value(0, 1.0, 2.0), value(0, -2.0, 0.5), value(3, 0.0, 1.0)];
        let program = CorridorProgram { unknowns: 8, rows, smoothness: 1.0, peak_cost: 0.0 };
        assert!(program.solved(&[0.0; 8]).is_none());
    }
}
