//! The least of the paper's sum over a whole row with given key axes: a discrete cubic spline on the sphere.
//!
//! ```text
//!   r_i = log(V_i -> V_(i+1)) / L_i + log(V_i -> V_(i-1)) / L_(i-1)
//!   minimize  sum |r_i|^2                                              (28), with the turn as a vector
//! ```
//!
//! `r_i` is the change of the turn for a mm of way at block i, across `V_i`.
//!
//! On one great circle with even turning all r are zero; between two keys that is the law of the paper, whose
//! sum has a jump at each key. The least of the whole sum spreads it over the row. By steps of Gauss and
//! Newton: in frames that are carried along the row without turning, small moves of the axes change r as in a
//! plane, the same for both directions, so that one symmetric band of five diagonals is factored for all
//! steps.

use proveout_geom::Vector;

use super::{touching, turned_by};
use crate::band::{factor, solve};

/// Steps, and the largest move at which they end, radian.
const STEPS: usize = 60;
const MOVED: f64 = 1e-12;
/// Diagonals of the band, the main one counted.
const BAND: usize = 3;
/// Sine of the angle between two directions below which they count as parallel.
const PARALLEL: f64 = 1e-9;

/// Axes at arc lengths with the least sum of squared changes of their turning, through axes that are given at
/// some of them: keys rise, the first and the last block among them. Also their sum, rad2/mm2.
pub fn true_minimum(arc: &[f64], keys: &[(usize, Vector)], start: Vec<Vector>) -> (Vec<Vector>, f64) {
    let n = arc.len();
    let mut axes = start;
    if n < 3 || axes.len() != n {
        return (axes, 0.0);
    }
    let mut fixed = vec![false; n];
    for (i, axis) in keys {
        axes[*i] = *axis;
        fixed[*i] = true;
    }
    let weight: Vec<f64> = arc.windows(2).map(|s| 1.0 / (s[1] - s[0])).collect();
    let row = |i: usize| [weight[i - 1], -(weight[i - 1] + weight[i]), weight[i]];
    let mut band = vec![[0.0; BAND]; n];
    for i in 1..n - 1 {
        let d = row(i);
        for a in 0..3 {
            for b in 0..=a {
                band[i - 1 + a][a - b] += d[a] * d[b];
            }
        }
    }
    for i in 0..n {
        for k in 1..BAND {
            if i >= k && (fixed[i] || fixed[i - k]) {
                band[i][k] = 0.0;
            }
        }
        if fixed[i] {
            band[i][0] = 1.0;
        }
    }
    if !factor(&mut band) {
        let sum = sum(&axes, &weight);
        return (axes, sum);
    }
    let mut best = sum(&axes, &weight);
    for _ in 0..STEPS {
        let frames = frames(&axes);
        let mut pull = [vec![0.0; n], vec![0.0; n]];
        for i in 1..n - 1 {
            let r = change(&axes, &weight, i);
            for (pull, direction) in pull.iter_mut().zip(frames[i]) {
                let part = r.dot(&direction);
                for (k, d) in row(i).into_iter().enumerate() {
                    pull[i - 1 + k] -= d * part;
                }
            }
        }
        for pull in &mut pull {
            pull.iter_mut().zip(&fixed).for_each(|(p, fixed)| *p = if *fixed { 0.0 } else { *p });
            solve(&band, pull);
        }
        let moved = |part: f64| -> Vec<Vector> {
            (0..n)
                .map(|i| {
                    if fixed[i] {
                        return axes[i];
                    }
                    turned_by(&axes[i], &((frames[i][0] * pull[0][i] + frames[i][1] * pull[1][i]) * part)).normalize()
                })
                .collect()
        };
        let largest = pull[0].iter().zip(&pull[1]).map(|(a, b)| a.hypot(*b)).fold(0.0, f64::max);
        // A step that does not gain is taken shorter.
        let tried = [1.0, 0.5, 0.1].map(moved).into_iter().map(|new| (sum(&new, &weight), new));
        let Some((least, new)) = tried.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(s, _)| *s < best) else { break };
        (best, axes) = (least, new);
        if largest < MOVED {
            break;
        }
    }
    (axes, best)
}

/// The change of the turn at a block.
fn change(axes: &[Vector], weight: &[f64], i: usize) -> Vector {
    touching(&axes[i], &axes[i + 1]) * weight[i] + touching(&axes[i], &axes[i - 1]) * weight[i - 1]
}

fn sum(axes: &[Vector], weight: &[f64]) -> f64 {
    (1..axes.len() - 1).map(|i| change(axes, weight, i).norm_squared()).sum()
}

/// Two directions across each axis, carried from one to the next without turning about it.
fn frames(axes: &[Vector]) -> Vec<[Vector; 2]> {
    let mut out: Vec<[Vector; 2]> = Vec::with_capacity(axes.len());
    for axis in axes {
        let helper = match out.last() {
            Some(last) => last[0],
            None if axis.x.abs() < 0.9 => Vector::x(),
            None => Vector::y(),
        };
        let across =
            (helper - axis * helper.dot(axis)).try_normalize(PARALLEL).unwrap_or_else(|| axis.cross(&Vector::z()));
        out.push([across, axis.cross(&across)]);
    }
    out
}
