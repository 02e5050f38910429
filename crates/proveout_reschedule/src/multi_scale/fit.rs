//! The rotary curve with the least sum of squared speeds that passes through fixed values: a clamped uniform
//! cubic B-spline.
//!
//! ```text
//!   q(u) = sum_j N_j(u) Q_j                      (17)
//!   a_ij = (N_j(u_i+1) - N_j(u_i)) / dt_i        (18)      minimize sum_i (sum_j a_ij Q_j)^2      (19), (20)
//!   subject to q(u_p) = q_p at the fixed contacts, the ends among them
//!
//!   | A  C^T | | Q  |   | 0 |
//!   | C   0  | | mu | = | q |       A = sum_i a_i a_i^T
//! ```
//!
//! As printed, (25) and (26) stack the normal equations (22) and the fixed values (24) into one least-squares
//! problem, which keeps neither and changes with the unit of time.

use nalgebra::{DMatrix, DVector};

const DEGREE: usize = 3;
/// Largest residual of the equations, part of their right side and one.
const MISSED: f64 = 1e-9;

/// Values of the four basis functions that are not zero at `u` in 0 .. 1, and the index of the first, of a
/// clamped uniform cubic B-spline with `coefficients` of them (at least four).
pub fn basis(u: f64, coefficients: usize) -> (usize, [f64; 4]) {
    let spans = coefficients - DEGREE;
    let span = ((u.clamp(0.0, 1.0) * spans as f64) as usize).min(spans - 1);
    let knot = |i: usize| (i.saturating_sub(DEGREE).min(spans)) as f64 / spans as f64;
    let at = span + DEGREE;
    let mut n = [1.0, 0.0, 0.0, 0.0];
    for d in 1..=DEGREE {
        let mut saved = 0.0;
        for (r, n) in n.iter_mut().enumerate().take(d) {
            let (right, left) = (knot(at + r + 1) - u, u - knot(at + 1 + r - d));
            let part = *n / (right + left);
            *n = saved + right * part;
            saved = left * part;
        }
        n[d] = saved;
    }
    (span, n)
}

/// The value at `u` of the spline with these coefficients.
pub fn value(coefficients: &[f64], u: f64) -> f64 {
    let (first, n) = basis(u, coefficients.len());
    n.iter().zip(&coefficients[first..]).map(|(n, q)| n * q).sum()
}

/// Coefficients for several curves with the same parameters `u` (rising, 0 .. 1), times between them (s), and
/// fixed places; `fixed` holds the index of a parameter and the value of each curve there. None where the
/// fixed places do not fit on so few coefficients.
pub fn fitted<const N: usize>(
    u: &[f64],
    times: &[f64],
    coefficients: usize,
    fixed: &[(usize, [f64; N])],
) -> Option<[Vec<f64>; N]> {
    let unknown = coefficients + fixed.len();
    if coefficients <= DEGREE || fixed.is_empty() || fixed.len() > coefficients || times.len() + 1 != u.len() {
        return None;
    }
    let mut kkt = DMatrix::<f64>::zeros(unknown, unknown);
    // Scaled by the mean time, so that the pivots of both parts of the system are alike in size.
    let scale = times.iter().sum::<f64>() / times.len() as f64;
    for (pair, dt) in u.windows(2).zip(times) {
        let (from, a) = basis(pair[0], coefficients);
        let (to, b) = basis(pair[1], coefficients);
        let mut row = [0.0; 2 * (DEGREE + 1)];
        let wide = to + DEGREE + 1 - from;
        if wide > row.len() {
            // A step over more than a span: the two ends share no function.
            return None;
        }
        for k in 0..=DEGREE {
            row[k] -= a[k] * scale / dt;
            row[to - from + k] += b[k] * scale / dt;
        }
        for i in 0..wide {
            for j in 0..wide {
                kkt[(from + i, from + j)] += row[i] * row[j];
            }
        }
    }
    for (p, (at, _)) in fixed.iter().enumerate() {
        let (first, n) = basis(*u.get(*at)?, coefficients);
        for (k, n) in n.into_iter().enumerate() {
            kkt[(coefficients + p, first + k)] = n;
            kkt[(first + k, coefficients + p)] = n;
        }
    }
    let solver = kkt.clone().full_piv_lu();
    let mut out: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
    for (curve, out) in out.iter_mut().enumerate() {
        let mut right = DVector::<f64>::zeros(unknown);
        for (p, (_, values)) in fixed.iter().enumerate() {
            right[coefficients + p] = values[curve];
        }
        let solved = solver.solve(&right)?;
        let missed = (&kkt * &solved - &right).amax();
        if missed.is_nan() || missed >= MISSED * (1.0 + right.amax()) {
            return None;
        }
        *out = solved.rows(0, coefficients).iter().copied().collect();
    }
    Some(out)
}
