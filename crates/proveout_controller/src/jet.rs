//! Functions of the path parameter up to the third order.
//!
//! A jet holds Taylor coefficients `[f, f', f''/2, f'''/6]` at one place. Sums and products of jets are the truncated
//! products of power series, so that derivatives of long expressions are exact without writing them out (Griewank and
//! Walther 2008, chapter 13).

use proveout_geom::{Vector, sin_cos};
use proveout_machine::JointValues;

/// Taylor coefficients of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Jet(pub(crate) [f64; 4]);

impl Jet {
    pub(crate) fn scaled(&self, by: f64) -> Self {
        Self(self.0.map(|c| c * by))
    }

    pub(crate) fn times(&self, o: &Self) -> Self {
        let (a, b) = (&self.0, &o.0);
        Self([
            a[0] * b[0],
            a[0] * b[1] + a[1] * b[0],
            a[0] * b[2] + a[1] * b[1] + a[2] * b[0],
            a[0] * b[3] + a[1] * b[2] + a[2] * b[1] + a[3] * b[0],
        ])
    }

    /// Sine and cosine; exact at right angles.
    pub(crate) fn sin_cos(&self) -> (Self, Self) {
        let (s, c) = sin_cos(self.0[0]);
        let [_, a1, a2, a3] = self.0;
        // With r = a1 h + a2 h^2 + a3 h^3: sin r = r - r^3/6 and 1 - cos r = r^2/2 up to h^3.
        let sine = [0.0, a1, a2, a3 - a1 * a1 * a1 / 6.0];
        let drop = [0.0, 0.0, 0.5 * a1 * a1, a1 * a2];
        let mut out = (Self([s, 0.0, 0.0, 0.0]), Self([c, 0.0, 0.0, 0.0]));
        for k in 1..4 {
            out.0.0[k] = c * sine[k] - s * drop[k];
            out.1.0[k] = -s * sine[k] - c * drop[k];
        }
        out
    }
}

/// Taylor coefficients of a vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VectorJet(pub(crate) [Vector; 4]);

impl VectorJet {
    pub(crate) fn constant(v: Vector) -> Self {
        Self([v, Vector::zeros(), Vector::zeros(), Vector::zeros()])
    }

    pub(crate) fn is_constant(&self) -> bool {
        self.0[1..].iter().all(|v| *v == Vector::zeros())
    }

    pub(crate) fn plus(&self, o: &Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + o.0[k]))
    }

    pub(crate) fn minus(&self, o: &Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - o.0[k]))
    }

    pub(crate) fn times(&self, f: &Jet) -> Self {
        let (a, b) = (&self.0, &f.0);
        Self([
            a[0] * b[0],
            a[0] * b[1] + a[1] * b[0],
            a[0] * b[2] + a[1] * b[1] + a[2] * b[0],
            a[0] * b[3] + a[1] * b[2] + a[2] * b[1] + a[3] * b[0],
        ])
    }

    /// Turned about the line through the origin along the unit vector `axis` (Rodrigues 1840) by the angle whose sine
    /// and cosine are given.
    pub(crate) fn turned(&self, axis: &Vector, sine: &Jet, cosine: &Jet) -> Self {
        let across = Self(self.0.map(|v| axis.cross(&v)));
        let inward = Self(across.0.map(|v| axis.cross(&v)));
        let mut versine = cosine.scaled(-1.0);
        versine.0[0] += 1.0;
        self.plus(&across.times(sine)).plus(&inward.times(&versine))
    }
}

/// Taylor coefficients of one number a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointJet(pub(crate) [JointValues; 4]);

impl JointJet {
    pub(crate) fn constant(q: JointValues) -> Self {
        Self([q, JointValues::ZERO, JointValues::ZERO, JointValues::ZERO])
    }

    pub(crate) fn joint(&self, i: usize) -> Jet {
        Jet([self.0[0][i], self.0[1][i], self.0[2][i], self.0[3][i]])
    }

    pub(crate) fn set(&mut self, i: usize, jet: &Jet) {
        for k in 0..4 {
            self.0[k][i] = jet.0[k];
        }
    }

    pub(crate) fn first(&self) -> JointValues {
        self.0[1]
    }

    pub(crate) fn second(&self) -> JointValues {
        self.0[2] * 2.0
    }

    pub(crate) fn third(&self) -> JointValues {
        self.0[3] * 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_of_a_cubic_matches_differences() {
        let at = |h: f64| 0.3 + 0.7 * h - 0.4 * h * h + 0.9 * h * h * h;
        let (s, c) = Jet([0.3, 0.7, -0.4, 0.9]).sin_cos();
        for h in [1e-3, -2e-3] {
            let sum = |j: &Jet| j.0[0] + h * (j.0[1] + h * (j.0[2] + h * j.0[3]));
            // The first term left out is of fourth order, with a coefficient below two.
            let bound = 2.0 * h.powi(4);
            assert!((sum(&s) - at(h).sin()).abs() < bound);
            assert!((sum(&c) - at(h).cos()).abs() < bound);
        }
    }
}
