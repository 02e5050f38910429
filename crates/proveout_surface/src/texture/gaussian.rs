//! The linear Gaussian filter, ISO 16610-21:2011 for profiles and ISO 16610-61:2015 for areas.
//!
//! Weighting function for cut-off c (ISO 16610-21, equation 1):
//!
//! ```text
//!   s(x) = exp(-pi (x / (alpha c))^2) / (alpha c),     alpha = sqrt(ln 2 / pi) = 0.469718639...
//! ```
//!
//! half of the amplitude passes at the wave length c. The integral is replaced by the sum over the lattice.
//! The weights are divided by the sum of those that lie on the data, which is regression of order zero at
//! the ends (ISO 16610-28:2016): a plane passes unchanged inside, and no point is lost. The function is cut
//! at one whole cut-off on either side. What is left beyond, erfc(sqrt(pi) / alpha) = 9e-8 of the weight,
//! is below the 1e-6 that the filter promises; at half a cut-off it would be 0.76 percent.

use rayon::prelude::*;

use super::HeightMap;

/// sqrt(ln 2 / pi).
const ALPHA: f64 = 0.469_718_639_349_826;
/// Part by which a cut-off of whole steps may round below them.
const WHOLE_STEPS: f64 = 1e-12;

/// Weights at 0, 1, 2 ... steps from the middle, not yet divided by their sum.
fn half_weights(cutoff: f64, step: f64) -> Vec<f64> {
    let reach = (cutoff / step * (1.0 + WHOLE_STEPS)).floor();
    // A cut-off below a step has one weight: nothing is filtered.
    let reach = if reach.is_finite() && reach > 0.0 { reach as usize } else { 0 };
    (0..=reach)
        .map(|k| {
            let x = k as f64 * step / (ALPHA * cutoff);
            (-std::f64::consts::PI * x * x).exp()
        })
        .collect()
}

/// The mean line of heights at equal steps (mm) for a cut-off (mm): what a low-pass leaves. Subtract it for
/// the high-pass.
pub fn gaussian_mean(heights: &[f64], step: f64, cutoff: f64) -> Vec<f64> {
    let weights = half_weights(cutoff, step);
    let mut out = vec![0.0; heights.len()];
    smooth_line(heights, &weights, &mut out);
    out
}

fn smooth_line(heights: &[f64], weights: &[f64], out: &mut [f64]) {
    let n = heights.len();
    for (x, y) in out.iter_mut().zip(heights) {
        *x = weights[0] * y;
    }
    // Tap by tap over the whole line: inner loops without branches.
    for (k, &w) in weights.iter().enumerate().skip(1) {
        if k >= n {
            break;
        }
        let m = n - k;
        for (x, y) in out[..m].iter_mut().zip(&heights[k..]) {
            *x += w * y;
        }
        for (x, y) in out[k..].iter_mut().zip(&heights[..m]) {
            *x += w * y;
        }
    }
    for (x, norm) in out.iter_mut().zip(norms(n, weights)) {
        *x /= norm;
    }
}

/// Sum of the weights that lie on a line of `n` points, for each of its points.
fn norms(n: usize, weights: &[f64]) -> Vec<f64> {
    let mut sums = Vec::with_capacity(weights.len() + 1);
    let mut sum = 0.0;
    sums.push(0.0);
    for &w in &weights[1..] {
        sum += w;
        sums.push(sum);
    }
    let last = weights.len() - 1;
    (0..n).map(|i| weights[0] + sums[i.min(last)] + sums[(n - 1 - i).min(last)]).collect()
}

/// The mean surface of a map for a cut-off (mm); the filter is separable, one pass along each direction.
pub fn gaussian_mean_of_map(map: &HeightMap, cutoff: f64) -> HeightMap {
    let (nx, ny) = (map.columns(), map.rows());
    let along_x = half_weights(cutoff, map.step_x());
    let mut rows = vec![0.0; nx * ny];
    rows.par_chunks_mut(nx).zip(map.heights().par_chunks(nx)).for_each(|(out, line)| smooth_line(line, &along_x, out));
    let along_y = half_weights(cutoff, map.step_y());
    let norm = norms(ny, &along_y);
    let mut heights = vec![0.0; nx * ny];
    heights.par_chunks_mut(nx).enumerate().for_each(|(j, out)| {
        let reach = along_y.len() - 1;
        for i in j.saturating_sub(reach)..=(j + reach).min(ny - 1) {
            let w = along_y[i.abs_diff(j)] / norm[j];
            for (x, y) in out.iter_mut().zip(&rows[i * nx..(i + 1) * nx]) {
                *x += w * y;
            }
        }
    });
    map.with_heights(heights)
}
