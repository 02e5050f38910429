//! Slopes of interpolating cubic splines: the second derivative is continuous, knots are the parameters (de
//! Boor 1978, chapter IV).
//!
//! With steps `h_k = u_{k+1} - u_k` and chord slopes `c_k = (P_{k+1} - P_k) / h_k` the slopes m obey, at
//! every inner point,
//!
//! ```text
//!   h_k m_{k-1} + 2 (h_{k-1} + h_k) m_k + h_{k-1} m_{k+1} = 3 (h_k c_{k-1} + h_{k-1} c_k)
//! ```

use proveout_geom::Vector;

/// What holds at the ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum SplineEnds {
    /// Both ends are one point, and the second derivative passes through it; the last point is the first one
    /// again.
    Closed,
    /// The slopes there.
    Slopes([Vector; 2]),
    /// The third derivative passes through the second point and the last but one: one cubic over two steps.
    /// Fewer than four points: the one polynomial through them.
    NotAKnot,
}

/// Slope of the parabola through three points, at the first, second or third of them.
fn parabola_slope(u: [f64; 3], p: [Vector; 3], at: usize) -> Vector {
    let c = [(p[1] - p[0]) / (u[1] - u[0]), (p[2] - p[1]) / (u[2] - u[1])];
    let second = (c[1] - c[0]) / (u[2] - u[0]);
    c[0] + second * (2.0 * u[at] - u[0] - u[1])
}

/// Slopes at all points; at least two, parameters ascending.
pub(super) fn slopes(u: &[f64], p: &[Vector], ends: SplineEnds) -> Vec<Vector> {
    let n = p.len();
    if n == 2 {
        return match ends {
            SplineEnds::Slopes(s) => s.to_vec(),
            _ => vec![(p[1] - p[0]) / (u[1] - u[0]); 2],
        };
    }
    if n == 3 && matches!(ends, SplineEnds::NotAKnot) {
        return (0..3).map(|k| parabola_slope([u[0], u[1], u[2]], [p[0], p[1], p[2]], k)).collect();
    }
    let h: Vec<f64> = u.windows(2).map(|w| w[1] - w[0]).collect();
    let c: Vec<Vector> = p.windows(2).zip(&h).map(|(w, h)| (w[1] - w[0]) / *h).collect();
    let row = |k: usize, before: usize| {
        let (a, b) = (h[before], h[k]);
        ([b, 2.0 * (a + b), a], (c[before] * b + c[k] * a) * 3.0)
    };
    match ends {
        SplineEnds::Closed => closed(n - 1, row),
        SplineEnds::Slopes([first, last]) => {
            let mut rows = vec![([0.0, 1.0, 0.0], first)];
            rows.extend((1..n - 1).map(|k| row(k, k - 1)));
            rows.push(([0.0, 1.0, 0.0], last));
            thomas(&rows)
        }
        SplineEnds::NotAKnot => {
            // de Boor 1978, IV: the condition, freed of the third slope by the row of the second point.
            let end = |h0: f64, h1: f64, c0: Vector, c1: Vector| {
                let sum = h0 + h1;
                ([h1, sum], (c0 * ((h0 + 2.0 * sum) * h1) + c1 * (h0 * h0)) / sum)
            };
            let ([a, b], right) = end(h[0], h[1], c[0], c[1]);
            let mut rows = vec![([0.0, a, b], right)];
            rows.extend((1..n - 1).map(|k| row(k, k - 1)));
            let ([a, b], right) = end(h[n - 2], h[n - 3], c[n - 2], c[n - 3]);
            rows.push(([b, a, 0.0], right));
            thomas(&rows)
        }
    }
}

/// Solves rows (below, diagonal, above) of a matrix that is dominated by its diagonal, without exchanging
/// rows.
fn thomas(rows: &[([f64; 3], Vector)]) -> Vec<Vector> {
    let mut above = Vec::with_capacity(rows.len());
    let mut right: Vec<Vector> = Vec::with_capacity(rows.len());
    for (k, ([a, b, c], r)) in rows.iter().enumerate() {
        let (last_above, last_right) = if k == 0 { (0.0, Vector::zeros()) } else { (above[k - 1], right[k - 1]) };
        let pivot = b - a * last_above;
        above.push(c / pivot);
        right.push((r - last_right * *a) / pivot);
    }
    for k in (0..rows.len() - 1).rev() {
        let next = right[k + 1];
        right[k] -= next * above[k];
    }
    right
}

/// A cyclic system of `n` rows by Sherman and Morrison's correction (Press et al. 2007, section 2.7.2). The
/// last slope is the first one again.
fn closed(n: usize, row: impl Fn(usize, usize) -> ([f64; 3], Vector)) -> Vec<Vector> {
    let rows: Vec<([f64; 3], Vector)> = (0..n).map(|k| row(k, (k + n - 1) % n)).collect();
    let (corner_low, corner_high) = (rows[n - 1].0[2], rows[0].0[0]);
    let gamma = -rows[0].0[1];
    let mut plain = rows.clone();
    plain[0].0[0] = 0.0;
    plain[0].0[1] -= gamma;
    plain[n - 1].0[2] = 0.0;
    plain[n - 1].0[1] -= corner_low * corner_high / gamma;
    let x = thomas(&plain);
    let mut side = plain;
    for (k, row) in side.iter_mut().enumerate() {
        let value = if k == 0 {
            gamma
        } else if k == n - 1 {
            corner_low
        } else {
            0.0
        };
        row.1 = Vector::new(value, 0.0, 0.0);
    }
    let z: Vec<f64> = thomas(&side).iter().map(|v| v.x).collect();
    let part = (x[0] + x[n - 1] * (corner_high / gamma)) / (1.0 + z[0] + z[n - 1] * corner_high / gamma);
    let mut out: Vec<Vector> = x.iter().zip(&z).map(|(x, z)| x - part * *z).collect();
    out.push(out[0]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_itself_and_a_circle_is_met_to_fourth_order() {
        let cubic = |t: f64| Vector::new(t * t * t, 1.0 - t, 2.0 * t * t);
        let slope = |t: f64| Vector::new(3.0 * t * t, -1.0, 4.0 * t);
        let u = [0.0, 0.3, 1.1, 1.4, 2.6, 3.0];
        let p = u.map(cubic);
        let ends = [slope(u[0]), slope(u[5])];
        for kind in [SplineEnds::NotAKnot, SplineEnds::Slopes(ends)] {
            for (m, t) in slopes(&u, &p, kind).iter().zip(u) {
                assert!((m - slope(t)).norm() < 1e-12, "{kind:?} {t}: {m}");
            }
        }
        let error = |n: u32| {
            // Unequal steps.
            let at = |k: u32| f64::from(k) / f64::from(n);
            let u: Vec<f64> = (0..=n)
                .map(|k| std::f64::consts::TAU * (at(k) + 0.05 * (std::f64::consts::TAU * at(k)).sin()))
                .collect();
            let p: Vec<Vector> = u.iter().map(|a| Vector::new(a.cos(), a.sin(), 0.0)).collect();
            let m = slopes(&u, &p, SplineEnds::Closed);
            m.iter().zip(&u).map(|(m, a)| (m - Vector::new(-a.sin(), a.cos(), 0.0)).norm()).fold(0.0, f64::max)
        };
        assert!(error(20) < 2e-3 && error(40) < error(20) / 7.0, "{} {}", error(20), error(40));
    }

    #[test]
    fn few_points_are_met_by_one_polynomial() {
        let p = [Vector::zeros(), Vector::new(1.0, 2.0, 0.0)];
        assert!((slopes(&[0.0, 2.0], &p, SplineEnds::NotAKnot)[1] - Vector::new(0.5, 1.0, 0.0)).norm() < 1e-15);
        let square = [0.0, 1.0, 3.0].map(|t: f64| Vector::new(t * t, 0.0, 0.0));
        let m = slopes(&[0.0, 1.0, 3.0], &square, SplineEnds::NotAKnot);
        assert!(m.iter().zip([0.0, 2.0, 6.0]).all(|(m, s)| (m.x - s).abs() < 1e-14));
    }
}
