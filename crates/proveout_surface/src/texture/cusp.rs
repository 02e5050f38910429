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
//! (Mean and square by integration; Ra since the parts above and below the mean line are equal.) For a parabola of height h:
//! Ra = 4 h / (9 sqrt 3), Rq = 2 h / (3 sqrt 5), Rsk = 2 sqrt 5 / 7, Rku = 15 / 7; a row of parabolas has the developed ratio
//! (sqrt(1 + g^2) + asinh(g) / g) / 2 - 1 with g = 4 h / p, its steepest slope.

/// Height of a row of arcs of radius `radius` at pitch `pitch`, mm; none where the arcs do not meet.
pub fn arc_height(radius: f64, pitch: f64) -> Option<f64> {
    let a = 0.5 * pitch;
    // R - sqrt(R^2 - a^2) without loss of digits.
    (radius > 0.0 && a > 0.0 && a <= radius).then(|| a * a / (radius + (radius * radius - a * a).sqrt()))
}

/// Ra and Rq of a row of arcs, mm; none where the arcs do not meet.
///
/// The closed forms above lose the digits of R over z; the same integrals are taken of z itself by a rule of Gauss and Legendre,
/// which on these smooth integrands is exact to rounding.
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

/// Developed ratio (length over projection, less one) of a row of parabolas of height `h` at pitch `pitch`.
pub fn parabola_developed_ratio(h: f64, pitch: f64) -> f64 {
    let g = 4.0 * h / pitch;
    if g.abs() < 1e-3 {
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
