//! Closed forms of periodic profiles: what a cutter of constant curvature leaves at a constant step.
//!
//! A row of arcs of radius R at pitch p, over one period |x| <= a = p / 2, z(x) = R - sqrt(R^2 - x^2):
//!
//! ```text
//!   height   h  = R - sqrt(R^2 - a^2)
//!   with     s(x) = sqrt(R^2 - x^2),  mean of s:  m = sqrt(R^2 - a^2) / 2 + R^2 / (2 a) asin(a / R)
//!   Rq^2     = mean of s^2 - m^2 = R^2 - a^2 / 3 - m^2
//!   Ra       = (2 / a) ((x0 m + R^2 asin(x0 / R)) / 2 - m x0),   x0 = sqrt(R^2 - m^2) where s = m
//! ```
//!
//! (Mean and square by integration; Ra since the parts above and below the mean line are equal.) For a
//! parabola of height h: Ra = 4 h / (9 sqrt 3), Rq = 2 h / (3 sqrt 5), Rsk = 2 sqrt 5 / 7, Rku = 15 / 7; a
//! row of parabolas has the developed ratio (sqrt(1 + g^2) + asinh(g) / g) / 2 - 1 with g = 4 h / p, its
//! steepest slope.
//!
//! Two rows of parabolas across each other, z = z1(x) + z2(y): their central moments are those of independent
//! quantities, m2 = 4 / 45 h^2, m3 = 16 / 945 h^3, m4 = 16 / 945 h^4 each (the last two agree for a
//! parabola), so that Sq^2 = m2(h1) + m2(h2), Ssk Sq^3 = m3(h1) + m3(h2), Sku Sq^4 = m4(h1) + m4(h2) + 6
//! m2(h1) m2(h2).
//!
//! Through the Gaussian filter: the high-pass leaves 1 - 2^-(c / l)^2 of a wave of length l for a cut-off c
//! (ISO 16610-21). A row of parabolas is the Fourier series with amplitudes 4 h (-1)^n / (pi n)^2, so that
//! Rq^2 = 4 / 45 h^2 - sum of (amplitude^2 / 2) (1 - share^2): the terms fall faster than exp(-(n c / p)^2),
//! and a few give all digits.

/// Height of a row of arcs of radius `radius` at pitch `pitch`, mm; none where the arcs do not meet.
pub fn arc_height(radius: f64, pitch: f64) -> Option<f64> {
    let a = 0.5 * pitch;
    // R - sqrt(R^2 - a^2) without loss of digits.
    (radius > 0.0 && a > 0.0 && a <= radius).then(|| a * a / (radius + (radius * radius - a * a).sqrt()))
}

/// Ra and Rq of a row of arcs, mm; none where the arcs do not meet.
///
/// The closed forms above lose the digits of R over z; the same integrals are taken of z itself by a rule of
/// Gauss and Legendre, which on these smooth integrands is exact to rounding.
pub fn arc_ra_rq(radius: f64, pitch: f64) -> Option<(f64, f64)> {
    let h = arc_height(radius, pitch)?;
    let a = 0.5 * pitch;
    let z = |x: f64| x * x / (radius + (radius * radius - x * x).sqrt());
    let mean = integral(z, 0.0, a) / a;
    let square = integral(|x| (z(x) - mean).powi(2), 0.0, a) / a;
    // z(x0) = mean: x0^2 = mean (2 R - mean).
    let x0 = (mean * (2.0 * radius - mean)).sqrt();
    let ra = 2.0 / a * integral(|x| mean - z(x), 0.0, x0);
    debug_assert!(ra <= h);
    Some((ra, square.sqrt()))
}

/// Ra of a row of parabolas of height `h`.
pub fn parabola_ra(h: f64) -> f64 {
    4.0 * h / (9.0 * 3.0_f64.sqrt())
}

/// Rq of a row of parabolas of height `h`.
pub fn parabola_rq(h: f64) -> f64 {
    2.0 * h / (3.0 * 5.0_f64.sqrt())
}

/// Rsk of a row of parabolas, ridges upward.
pub const PARABOLA_RSK: f64 = 0.638_876_564_999_939_9;
/// Rku of a row of parabolas.
pub const PARABOLA_RKU: f64 = 15.0 / 7.0;
/// Terms of a series of sum 1 that are smaller add no digit.
const LAST_TERM: f64 = 1e-18;
/// Steepest slope up to which the series of the developed ratio is exact.
const SERIES: f64 = 1e-3;

/// Sq, Ssk and Sku of two rows of parabolas of heights `h1` and `h2` across each other; none where both are
/// flat.
pub fn crossed(h1: f64, h2: f64) -> Option<(f64, f64, f64)> {
    let m2 = |h: f64| 4.0 / 45.0 * h * h;
    let (m3, m4) = (|h: f64| 16.0 / 945.0 * h.powi(3), |h: f64| 16.0 / 945.0 * h.powi(4));
    let square = m2(h1) + m2(h2);
    let sq = square.sqrt();
    (square > 0.0).then(|| {
        let sku = (m4(h1) + m4(h2) + 6.0 * m2(h1) * m2(h2)) / (square * square);
        (sq, (m3(h1) + m3(h2)) / (square * sq), sku)
    })
}

/// Share of the amplitude of a wave (length in mm) that the Gaussian high-pass leaves for a cut-off (mm).
pub fn high_pass_share(wave_length: f64, cutoff: f64) -> f64 {
    // 1 - 2^-q without loss of digits for small q.
    -(-std::f64::consts::LN_2 * (cutoff / wave_length).powi(2)).exp_m1()
}

/// Rq of a row of parabolas of height `h` at pitch `pitch` (mm) after the Gaussian high-pass with a cut-off
/// (mm).
pub fn parabola_rq_high_pass(h: f64, pitch: f64, cutoff: f64) -> f64 {
    let mut lost = 0.0;
    for n in 1..=10_000 {
        let n = f64::from(n);
        let share = high_pass_share(pitch / n, cutoff);
        let term = 8.0 / (std::f64::consts::PI * n).powi(4) * (1.0 - share) * (1.0 + share);
        lost += term;
        if term < LAST_TERM {
            break;
        }
    }
    h * (4.0 / 45.0 - lost).max(0.0).sqrt()
}

/// Developed ratio (length over projection, less one) of a row of parabolas of height `h` at pitch `pitch`.
pub fn parabola_developed_ratio(h: f64, pitch: f64) -> f64 {
    let g = 4.0 * h / pitch;
    if g.abs() < SERIES {
        // Series of (sqrt(1 + g^2) + asinh(g) / g) / 2 - 1.
        g * g / 6.0 - g.powi(4) / 40.0
    } else {
        0.5 * ((1.0 + g * g).sqrt() + g.asinh() / g) - 1.0
    }
}

/// Integral over an interval by panels of five Gauss and Legendre points.
fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    const NODES: [(f64, f64); 3] = [
        (0.0, 128.0 / 225.0),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    const PANELS: usize = 32;
    let width = (to - from) / PANELS as f64;
    let mut total = 0.0;
    for k in 0..PANELS {
        let middle = from + (k as f64 + 0.5) * width;
        for (node, weight) in NODES {
            let dx = 0.5 * width * node;
            total += weight * if node == 0.0 { f(middle) } else { f(middle - dx) + f(middle + dx) };
        }
    }
    0.5 * width * total
}
