//! Bicubic patches as Bernstein polynomials: place, derivatives, and bounds of the second ones.
//!
//! A patch over the unit square is `sum B_i(s) B_j(t) P_ij` (Farin 2002, chapter 16). Each of its derivatives
//! is such a sum over differences of the control points, and a sum of Bernstein polynomials lies in the
//! convex hull of its control points: the largest of them bounds the derivative.

use proveout_geom::Vector;

use super::scalar::{Interval, Scalar};

/// Control points, the first index along u.
pub(super) type Net = [[Vector; 4]; 4];

/// Point and derivatives of one cubic of control points, for each unit of its parameter from 0 to 1.
#[inline]
fn cubic(p: &[Vector; 4], t: f64) -> [Vector; 3] {
    let r = 1.0 - t;
    let [d0, d1, d2] = [p[1] - p[0], p[2] - p[1], p[3] - p[2]];
    [
        p[0] * (r * r * r) + p[1] * (3.0 * r * r * t) + p[2] * (3.0 * r * t * t) + p[3] * (t * t * t),
        (d0 * (r * r) + d1 * (2.0 * r * t) + d2 * (t * t)) * 3.0,
        ((d1 - d0) * r + (d2 - d1) * t) * 6.0,
    ]
}

/// Control points from values and derivatives at both ends.
pub(super) fn hermite(ends: [Vector; 2], slopes: [Vector; 2], width: f64) -> [Vector; 4] {
    [ends[0], ends[0] + slopes[0] * (width / 3.0), ends[1] - slopes[1] * (width / 3.0), ends[1]]
}

/// Place, first and second derivatives (`u`, `v`, `uu`, `uv`, `vv`) of a patch of the widths given, at (s, t)
/// of the unit square; any real numbers.
pub(super) fn at(net: &Net, widths: [f64; 2], s: f64, t: f64) -> [Vector; 6] {
    // Loops, no maps of arrays: those are calls, and took more time than the sums.
    let mut across = [[Vector::zeros(); 4]; 3];
    for (i, row) in net.iter().enumerate() {
        let [place, slope, bend] = cubic(row, t);
        (across[0][i], across[1][i], across[2][i]) = (place, slope, bend);
    }
    let (place, along, bend) = (cubic(&across[0], s), cubic(&across[1], s), cubic(&across[2], s));
    let [a, b] = widths;
    [place[0], place[1] / a, along[0] / b, place[2] / (a * a), along[1] / (a * b), bend[0] / (b * b)]
}

/// Ranges of x, y, z of `S_uu`, `S_uv`, `S_vv` over the patch: those of the control points of each.
pub(super) fn second(net: &Net, widths: [f64; 2]) -> [[Interval; 3]; 3] {
    let mut out = [[Interval { low: f64::INFINITY, high: f64::NEG_INFINITY }; 3]; 3];
    let mut take = |k: usize, d: Vector, factor: f64| {
        for (c, value) in d.iter().enumerate() {
            out[k][c] = out[k][c].with(Interval::of(value * factor));
        }
    };
    let [a, b] = widths;
    for rows in net.windows(3) {
        for (low, (here, high)) in rows[0].iter().zip(rows[1].iter().zip(&rows[2])) {
            take(0, low - here * 2.0 + high, 6.0 / (a * a));
        }
    }
    for rows in net.windows(2) {
        for (low, high) in rows[0].windows(2).zip(rows[1].windows(2)) {
            take(1, high[1] - high[0] - low[1] + low[0], 9.0 / (a * b));
        }
    }
    for p in net.iter().flat_map(|row| row.windows(3)) {
        take(2, p[0] - p[1] * 2.0 + p[2], 6.0 / (b * b));
    }
    out
}
