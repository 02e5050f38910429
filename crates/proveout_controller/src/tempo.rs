//! A stretch of a law that is run faster or slower than it was planned.
//!
//! A *first law* gives the path s = S(p) in its own time p. Run with a tempo dp/dt = sqrt(b), where b is quadratic in p over a
//! stretch, p(t) obeys a linear equation, since half the slope of b is the second derivative of p:
//!
//! ```text
//!   b(x) = b0 + b1 x + b2 x^2,   x = p - begin        x.^2 = b        x.. = b1/2 + b2 x        x... = b2 x.
//! ```
//!
//! so that with S1(t) = sinh(w t)/w and S2(t) = (cosh(w t) - 1)/w^2, w^2 = b2 (sine and cosine for b2 < 0, powers of t for 0)
//!
//! ```text
//!   x(t) = sqrt(b0) S1 + b1/2 S2        t(x) = 2 x / (v0 + v) f(b2 x^2 / (v0 + v)^2),   v = sqrt(b),  f(y) = artanh(sqrt y)/sqrt y
//! ```
//!
//! The second follows from the integral of dx/sqrt(b), a logarithm, with b1 replaced by (v^2 - v0^2)/x - b2 x: then the
//! argument of the logarithm is (1 + z)/(1 - z) with z = w x / (v0 + v). Both directions are closed forms without iteration.

/// A stretch of constant b2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tempo {
    /// Begin in the time of the first law, s.
    pub(crate) begin: f64,
    /// Length in the time of the first law, s.
    pub(crate) length: f64,
    /// Square of the tempo as polynomial of the time since `begin`.
    pub(crate) square: [f64; 3],
    /// Begin in the time of the run, s.
    pub(crate) time: f64,
    /// Length in the time of the run, s.
    pub(crate) duration: f64,
}

/// artanh(sqrt y) / sqrt y, for y < 0 arctan(sqrt -y) / sqrt -y.
fn mean_slowness(y: f64) -> f64 {
    if y.abs() < 1e-3 {
        1.0 + y * (1.0 / 3.0 + y * (0.2 + y * (1.0 / 7.0 + y * (1.0 / 9.0 + y / 11.0))))
    } else if y > 0.0 {
        let z = y.sqrt().min(1.0 - 1e-15);
        z.atanh() / z
    } else {
        let z = (-y).sqrt();
        z.atan() / z
    }
}

/// sinh(w t)/w and (cosh(w t) - 1)/w^2 with w^2 = `b2` of either sign.
fn hyperbolic(b2: f64, t: f64) -> [f64; 2] {
    let y = b2 * t * t;
    if y.abs() < 0.1 {
        // The first terms left out are below 1e-19 of the sum.
        let s1 = 1.0
            + y / 6.0 * (1.0 + y / 20.0 * (1.0 + y / 42.0 * (1.0 + y / 72.0 * (1.0 + y / 110.0 * (1.0 + y / 156.0)))));
        let s2 = 1.0
            + y / 12.0 * (1.0 + y / 30.0 * (1.0 + y / 56.0 * (1.0 + y / 90.0 * (1.0 + y / 132.0 * (1.0 + y / 182.0)))));
        [s1 * t, 0.5 * s2 * t * t]
    } else if y > 0.0 {
        let w = b2.sqrt();
        let half = (0.5 * w * t).sinh();
        [(w * t).sinh() / w, 2.0 * half * half / b2]
    } else {
        let w = (-b2).sqrt();
        let half = (0.5 * w * t).sin();
        [(w * t).sin() / w, -2.0 * half * half / b2]
    }
}

impl Tempo {
    /// The stretch from `begin` over `length`; its time of the run begins at `time`.
    pub(crate) fn new(begin: f64, length: f64, square: [f64; 3], time: f64) -> Self {
        let mut tempo = Self { begin, length, square, time, duration: 0.0 };
        tempo.duration = if square == [1.0, 0.0, 0.0] { length } else { tempo.passed(length) };
        tempo
    }

    /// The first law as it is.
    pub(crate) fn even(begin: f64, length: f64, time: f64) -> Self {
        Self { begin, length, square: [1.0, 0.0, 0.0], time, duration: length }
    }

    /// Square of the tempo and its derivative at `x` behind the begin.
    pub(crate) fn square_at(&self, x: f64) -> [f64; 2] {
        let [b0, b1, b2] = self.square;
        [b0 + x * (b1 + x * b2), b1 + 2.0 * x * b2]
    }

    /// Time of the first law with three derivatives by the time of the run, `t` after the begin of the stretch.
    pub(crate) fn at(&self, t: f64) -> [f64; 4] {
        let [b0, b1, b2] = self.square;
        if self.square == [1.0, 0.0, 0.0] {
            return [self.begin + t.min(self.length), 1.0, 0.0, 0.0];
        }
        let (v0, half) = (b0.sqrt(), 0.5 * b1);
        let [s1, s2] = hyperbolic(b2, t);
        let x = (v0 * s1 + half * s2).clamp(0.0, self.length);
        let v = v0 * (1.0 + b2 * s2) + half * s1;
        [self.begin + x, v, half + b2 * x, b2 * v]
    }

    /// Time of the run since the begin of the stretch at which the time of the first law has grown by `x`.
    pub(crate) fn passed(&self, x: f64) -> f64 {
        let x = x.clamp(0.0, self.length);
        if self.square == [1.0, 0.0, 0.0] {
            return x;
        }
        let [b0, b1, b2] = self.square;
        let sum = b0.sqrt() + (b0 + x * (b1 + x * b2)).max(0.0).sqrt();
        2.0 * x / sum * mean_slowness(b2 * x * x / (sum * sum))
    }

    /// The parts before and behind `p`, a time of the first law within the stretch; times of the run stay.
    pub(crate) fn cut(&self, p: f64) -> [Self; 2] {
        let x = (p - self.begin).clamp(0.0, self.length);
        let t = self.passed(x);
        let [b, slope] = self.square_at(x);
        let square = if self.square == [1.0, 0.0, 0.0] { self.square } else { [b, slope, self.square[2]] };
        [
            Self { length: x, duration: t, ..*self },
            Self {
                begin: self.begin + x,
                length: self.length - x,
                square,
                time: self.time + t,
                duration: self.duration - t,
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_places_are_inverse_and_solve_the_equation() {
        for square in [[1.0, 0.0, 0.0], [1.0, 3.0, 0.0], [1.2, -2.0, 40.0], [0.9, 5.0, -30.0], [1.0, 0.01, 1e-4]] {
            let tempo = Tempo::new(2.0, 0.1, square, 7.0);
            // The sum of dx/sqrt(b) by the rule of midpoints.
            let n = 20_000;
            let sum: f64 = (0..n)
                .map(|k| 0.1 / f64::from(n) / tempo.square_at(0.1 * (f64::from(k) + 0.5) / f64::from(n))[0].sqrt())
                .sum();
            assert!((sum - tempo.duration).abs() < 1e-9, "{square:?}: {sum} {}", tempo.duration);
            for k in 0..=20 {
                let x = 0.005 * f64::from(k);
                let [p, v, a, j] = tempo.at(tempo.passed(x));
                assert!((p - 2.0 - x).abs() < 1e-13, "{square:?}: {p} {x}");
                let [b, slope] = tempo.square_at(x);
                assert!((v * v - b).abs() < 1e-12 && (a - 0.5 * slope).abs() < 1e-11);
                assert!((j - square[2] * v).abs() < 1e-11);
            }
            let [left, right] = tempo.cut(2.03);
            assert!((left.duration + right.duration - tempo.duration).abs() < 1e-15);
            assert!((right.at(0.02)[0] - tempo.at(0.02 + left.duration)[0]).abs() < 1e-13);
            assert!((right.passed(right.length) - right.duration).abs() < 1e-13);
        }
    }
}
