//! Lengths and direction of a texture: Sal, Str, Std of ISO 25178-2:2021.
//!
//! The autocorrelation is linear, not circular: the map is padded with zeros and every lag divided by the
//! number of pairs that it has. Sal is the shortest, Sal / Str the longest distance from the middle to where
//! it has fallen to 0.2, over all directions of the region above 0.2 that contains the middle. Where this
//! region reaches the border of the map, as along the marks of a milled surface, the longest distance is not
//! in the data and Str is none.
//!
//! The direction of the lay is that across the strongest waves: the angle at which the power spectrum, under
//! a Hann window in both directions and added up along rays, is largest, turned by a right angle.

use realfft::{RealFftPlanner, num_complex::Complex, num_traits::Zero};
use rustfft::FftPlanner;

use super::HeightMap;

/// Share of its value in the middle to which the autocorrelation must fall (ISO 25178-3, default).
const DECAY: f64 = 0.2;
/// Heights below this are what the transform leaves of a flat, mm: rounding.
const ROUNDING: f64 = 1e-12;
/// Their square, mm^2.
const ROUNDING_SQUARED: f64 = 1e-24;

/// Lengths over which heights are alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Autocorrelation {
    /// Sal, mm; none on a flat or where nothing decays within the map.
    pub sal: Option<f64>,
    /// Str, from 0 (marks) to 1 (the same in all directions); none where the longest length is beyond the
    /// map.
    pub str: Option<f64>,
}

/// Real two-dimensional transforms of one size.
struct Transform {
    nx: usize,
    ny: usize,
    bins: usize,
}

impl Transform {
    fn new(nx: usize, ny: usize) -> Self {
        Self { nx, ny, bins: nx / 2 + 1 }
    }

    fn columns(&self, spectrum: &mut [Complex<f64>], inverse: bool) {
        let mut planner = FftPlanner::new();
        let fft = if inverse { planner.plan_fft_inverse(self.ny) } else { planner.plan_fft_forward(self.ny) };
        let mut line = vec![Complex::zero(); self.ny];
        let mut scratch = vec![Complex::zero(); fft.get_inplace_scratch_len()];
        for i in 0..self.bins {
            for (j, c) in line.iter_mut().enumerate() {
                *c = spectrum[j * self.bins + i];
            }
            fft.process_with_scratch(&mut line, &mut scratch);
            for (j, c) in line.iter().enumerate() {
                spectrum[j * self.bins + i] = *c;
            }
        }
    }

    /// Spectrum of `value(i, j)`, rows of `bins` bins; none if the library refuses the sizes, which it does
    /// not for these.
    fn forward(&self, value: impl Fn(usize, usize) -> f64) -> Option<Vec<Complex<f64>>> {
        let fft = RealFftPlanner::new().plan_fft_forward(self.nx);
        let mut line = fft.make_input_vec();
        let mut spectrum = vec![Complex::zero(); self.bins * self.ny];
        for (j, row) in spectrum.chunks_mut(self.bins).enumerate() {
            for (i, z) in line.iter_mut().enumerate() {
                *z = value(i, j);
            }
            fft.process(&mut line, row).ok()?;
        }
        self.columns(&mut spectrum, false);
        Some(spectrum)
    }

    /// Values of a spectrum of a real field, times the number of points.
    fn inverse(&self, mut spectrum: Vec<Complex<f64>>) -> Option<Vec<f64>> {
        self.columns(&mut spectrum, true);
        let fft = RealFftPlanner::new().plan_fft_inverse(self.nx);
        let mut values = vec![0.0; self.nx * self.ny];
        for (row, out) in spectrum.chunks_mut(self.bins).zip(values.chunks_mut(self.nx)) {
            // What rounding left where a real field has none.
            row[0].im = 0.0;
            if self.nx.is_multiple_of(2) {
                row[self.bins - 1].im = 0.0;
            }
            fft.process(row, out).ok()?;
        }
        Some(values)
    }
}

/// The next number with no prime factor above five, for which transforms are fast.
fn smooth_size(at_least: usize) -> usize {
    (at_least..)
        .find(|&n| {
            let mut m = n;
            for p in [2, 3, 5] {
                while m.is_multiple_of(p) {
                    m /= p;
                }
            }
            m == 1
        })
        .unwrap_or(at_least)
}

fn centered(map: &HeightMap) -> Vec<f64> {
    let mean = super::areal::sum(map.heights().iter().copied()) / map.heights().len() as f64;
    map.heights().iter().map(|z| z - mean).collect()
}

impl Autocorrelation {
    /// Of a map, its mean taken off.
    pub fn of(map: &HeightMap) -> Self {
        let none = Self { sal: None, str: None };
        let (nx, ny) = (map.columns(), map.rows());
        let z = centered(map);
        let size = Transform::new(smooth_size(2 * nx - 1), smooth_size(2 * ny - 1));
        let Some(mut spectrum) = size.forward(|i, j| if i < nx && j < ny { z[j * nx + i] } else { 0.0 }) else {
            return none;
        };
        for c in &mut spectrum {
            *c = Complex::new(c.norm_sqr(), 0.0);
        }
        let Some(raw) = size.inverse(spectrum) else { return none };
        let lag = Lags { raw: &raw, size: &size, nx: nx as isize, ny: ny as isize };
        let top = lag.at(0, 0);
        // Rounding of the transform is not texture.
        if top.is_nan() || top <= 0.0 || map.parameters().sz <= ROUNDING {
            return none;
        }
        let Some((shortest, longest, inside)) = lag.decay(DECAY * top, map.step_x(), map.step_y()) else { return none };
        Self { sal: Some(shortest), str: inside.then(|| shortest / longest) }
    }
}

/// Autocorrelation by lag, unbiased.
struct Lags<'a> {
    raw: &'a [f64],
    size: &'a Transform,
    nx: isize,
    ny: isize,
}

impl Lags<'_> {
    fn at(&self, i: isize, j: isize) -> f64 {
        let (x, y) = (i.rem_euclid(self.size.nx as isize) as usize, j.rem_euclid(self.size.ny as isize) as usize);
        let pairs = (self.nx - i.abs()) * (self.ny - j.abs());
        self.raw[y * self.size.nx + x] / pairs as f64
    }

    fn within(&self, i: isize, j: isize) -> bool {
        i.abs() < self.nx && j.abs() < self.ny
    }

    /// Bilinear between lags.
    fn between(&self, x: f64, y: f64) -> f64 {
        let (i, j) = (x.floor(), y.floor());
        let (u, v) = (x - i, y - j);
        let (i, j) = (i as isize, j as isize);
        let at = |i: isize, j: isize| self.at(i.clamp(1 - self.nx, self.nx - 1), j.clamp(1 - self.ny, self.ny - 1));
        (1.0 - v) * ((1.0 - u) * at(i, j) + u * at(i + 1, j)) + v * ((1.0 - u) * at(i, j + 1) + u * at(i + 1, j + 1))
    }

    /// Shortest and longest distance (mm) to the border of the region above `threshold`, and whether the
    /// region ends inside.
    fn decay(&self, threshold: f64, step_x: f64, step_y: f64) -> Option<(f64, f64, bool)> {
        let width = (2 * self.nx - 1) as usize;
        let index = |i: isize, j: isize| (j + self.ny - 1) as usize * width + (i + self.nx - 1) as usize;
        let mut seen = vec![false; width * (2 * self.ny - 1) as usize];
        let mut queue = vec![(0_isize, 0_isize)];
        seen[index(0, 0)] = true;
        let (mut shortest, mut longest, mut inside) = (f64::INFINITY, 0.0_f64, true);
        while let Some((i, j)) = queue.pop() {
            for (di, dj) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let (a, b) = (i + di, j + dj);
                if !self.within(a, b) {
                    inside = false;
                    continue;
                }
                if std::mem::replace(&mut seen[index(a, b)], true) {
                    continue;
                }
                if self.at(a, b) > threshold {
                    queue.push((a, b));
                } else {
                    let (x, y) = (a as f64, b as f64);
                    let t = self.crossing(x, y, threshold);
                    let length = t * (x * step_x).hypot(y * step_y);
                    shortest = shortest.min(length);
                    longest = longest.max(length);
                }
            }
        }
        shortest.is_finite().then_some((shortest, longest, inside))
    }

    /// Where along the way from the middle to a lag below the threshold it is met, 0 to 1.
    fn crossing(&self, x: f64, y: f64, threshold: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let t = 0.5 * (low + high);
            if self.between(t * x, t * y) > threshold {
                low = t;
            } else {
                high = t;
            }
        }
        high
    }
}

/// Direction of the lay, radians from the x direction of the map in [0, pi), to half a degree: along the
/// marks, not across them. None on a flat.
pub fn lay(map: &HeightMap) -> Option<f64> {
    const DIRECTIONS: usize = 360;
    let (nx, ny) = (map.columns(), map.rows());
    let z = centered(map);
    let hann = |k: usize, n: usize| (std::f64::consts::PI * k as f64 / (n - 1) as f64).sin().powi(2);
    let size = Transform::new(smooth_size(2 * nx - 1), smooth_size(2 * ny - 1));
    let spectrum =
        size.forward(|i, j| if i < nx && j < ny { z[j * nx + i] * hann(i, nx) * hann(j, ny) } else { 0.0 })?;
    // Frequencies of a bin, 1/mm, along x and y.
    let (fx, fy) = (1.0 / (size.nx as f64 * map.step_x()), 1.0 / (size.ny as f64 * map.step_y()));
    let power = |i: isize, j: isize| {
        // A real field: the half that is not kept mirrors the other.
        let (i, j) = if i < 0 { (-i, -j) } else { (i, j) };
        spectrum[j.rem_euclid(size.ny as isize) as usize * size.bins + (i as usize).min(size.bins - 1)].norm_sqr()
    };
    let radius = (0.5 / map.step_x()).min(0.5 / map.step_y());
    let step = fx.min(fy);
    // Below two waves over the map nothing has a direction.
    let first = 2.0 / map.size()[0].min(map.size()[1]);
    let mut best = (0.0, 0);
    for d in 0..DIRECTIONS {
        let (sin, cos) = (std::f64::consts::PI * d as f64 / DIRECTIONS as f64).sin_cos();
        let mut total = 0.0;
        let mut f = first;
        while f < radius {
            let (x, y) = (f * cos / fx, f * sin / fy);
            let (i, j) = (x.floor(), y.floor());
            let (u, v) = (x - i, y - j);
            let (i, j) = (i as isize, j as isize);
            total += (1.0 - v) * ((1.0 - u) * power(i, j) + u * power(i + 1, j))
                + v * ((1.0 - u) * power(i, j + 1) + u * power(i + 1, j + 1));
            f += step;
        }
        if total > best.0 {
            best = (total, d);
        }
    }
    // Squares of what rounding leaves of a flat.
    let flat = ROUNDING_SQUARED * (nx * ny) as f64;
    (best.0 > flat).then(|| std::f64::consts::PI * ((best.1 + DIRECTIONS / 2) % DIRECTIONS) as f64 / DIRECTIONS as f64)
}
