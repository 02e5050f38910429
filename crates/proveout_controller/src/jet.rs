//! Functions of the path parameter up to the third order.
//!
//! A jet holds Taylor coefficients `[f, f', f''/2, f'''/6]` at one place. Sums and products of jets are the
//! truncated products of power series, so that derivatives of long expressions are exact without writing them
//! out (Griewank and Walther 2008, chapter 13).

use proveout_geom::{Vector, sin_cos};
use proveout_machine::JointValues;

/// Taylor coefficients of a number; one alone is the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jet<const N: usize = 4>(pub(crate) [f64; N]);

impl<const N: usize> Jet<N> {
    #[inline]
    pub(crate) fn times(&self, o: &Self) -> Self {
        let mut out = [0.0; N];
        for k in 0..N {
            out[k] = self.0[0] * o.0[k];
            for m in 1..=k {
                out[k] += self.0[m] * o.0[k - m];
            }
        }
        Self(out)
    }

    #[inline]
    fn plus(&self, o: &Self) -> Self {
        let mut out = *self;
        for (a, b) in out.0.iter_mut().zip(&o.0) {
            *a += b;
        }
        out
    }

    #[inline]
    fn minus(&self, o: &Self) -> Self {
        let mut out = *self;
        for (a, b) in out.0.iter_mut().zip(&o.0) {
            *a -= b;
        }
        out
    }

    /// Sine and cosine; exact at right angles.
    #[inline]
    pub(crate) fn sin_cos(&self) -> (Self, Self) {
        let (s, c) = sin_cos(self.0[0]);
        let a = |k: usize| if k < N { self.0[k] } else { 0.0 };
        let (a1, a2, a3) = (a(1), a(2), a(3));
        // With r = a1 h + a2 h^2 + a3 h^3: sin r = r - r^3/6 and 1 - cos r = r^2/2 up to h^3.
        let sine = [0.0, a1, a2, a3 - a1 * a1 * a1 / 6.0];
        let drop = [0.0, 0.0, 0.5 * a1 * a1, a1 * a2];
        let (mut sines, mut cosines) = ([s; N], [c; N]);
        for k in 1..N.min(4) {
            sines[k] = c * sine[k] + -s * drop[k];
            cosines[k] = -s * sine[k] + -c * drop[k];
        }
        (Self(sines), Self(cosines))
    }
}

/// Taylor coefficients of a vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VectorJet<const N: usize = 4>(pub(crate) [Vector; N]);

impl<const N: usize> VectorJet<N> {
    #[inline]
    pub(crate) fn constant(v: Vector) -> Self {
        Self(std::array::from_fn(|k| if k == 0 { v } else { Vector::zeros() }))
    }

    #[inline]
    pub(crate) fn plus(&self, o: &Self) -> Self {
        let mut out = *self;
        for (a, b) in out.0.iter_mut().zip(&o.0) {
            *a += b;
        }
        out
    }

    #[inline]
    pub(crate) fn minus(&self, o: &Self) -> Self {
        let mut out = *self;
        for (a, b) in out.0.iter_mut().zip(&o.0) {
            *a -= b;
        }
        out
    }

    #[inline]
    pub(crate) fn times(&self, f: &Jet<N>) -> Self {
        let mut out = *self;
        for k in 0..N {
            out.0[k] = self.0[0] * f.0[k];
            for m in 1..=k {
                out.0[k] += self.0[m] * f.0[k - m];
            }
        }
        out
    }

    /// Turned about the line through the origin along the unit vector `axis` (Rodrigues 1840) by the angle
    /// whose sine and cosine are given.
    #[inline]
    pub(crate) fn turned(&self, axis: &Vector, sine: &Jet<N>, cosine: &Jet<N>) -> Self {
        for k in 0..3 {
            if axis[(k + 1) % 3] == 0.0 && axis[(k + 2) % 3] == 0.0 {
                return self.turned_about(k, axis[k], sine, cosine);
            }
        }
        let across = Self(self.0.map(|v| axis.cross(&v)));
        let inward = Self(across.0.map(|v| axis.cross(&v)));
        let mut versine = Jet(cosine.0.map(|c| -c));
        versine.0[0] += 1.0;
        self.plus(&across.times(sine)).plus(&inward.times(&versine))
    }

    /// The same about coordinate axis `k`, in its sense (1) or against it (-1).
    #[inline]
    fn turned_about(&self, k: usize, sense: f64, sine: &Jet<N>, cosine: &Jet<N>) -> Self {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (mut x, mut y, mut sine) = (Jet([0.0; N]), Jet([0.0; N]), *sine);
        for m in 0..N {
            (x.0[m], y.0[m]) = (self.0[m][i], self.0[m][j]);
            sine.0[m] *= sense;
        }
        let (u, v) = (cosine.times(&x).minus(&sine.times(&y)), sine.times(&x).plus(&cosine.times(&y)));
        let mut out = *self;
        for m in 0..N {
            (out.0[m][i], out.0[m][j]) = (u.0[m], v.0[m]);
        }
        out
    }
}

/// Taylor coefficients of one number a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointJet(pub(crate) [JointValues; 4]);

impl JointJet {
    pub(crate) fn constant(q: JointValues) -> Self {
        Self([q, JointValues::ZERO, JointValues::ZERO, JointValues::ZERO])
    }

    /// The first N coefficients of a joint.
    #[inline]
    pub(crate) fn joint<const N: usize>(&self, i: usize) -> Jet<N> {
        let mut out = [0.0; N];
        for (own, values) in out.iter_mut().zip(&self.0) {
            *own = values[i];
        }
        Jet(out)
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
        let (s, c) = Jet::<4>([0.3, 0.7, -0.4, 0.9]).sin_cos();
        for h in [1e-3, -2e-3] {
            let sum = |j: &Jet| j.0[0] + h * (j.0[1] + h * (j.0[2] + h * j.0[3]));
            // The first term left out is of fourth order, with a coefficient below two.
            let bound = 2.0 * h.powi(4);
            assert!((sum(&s) - at(h).sin()).abs() < bound);
            assert!((sum(&c) - at(h).cos()).abs() < bound);
        }
    }

    #[test]
    fn a_turn_about_a_coordinate_axis_is_the_turn_about_any_axis() {
        let p = VectorJet::<4>([
            Vector::new(1.0, -2.0, 0.5),
            Vector::new(0.3, 0.1, -0.7),
            Vector::new(-0.2, 0.4, 0.6),
            Vector::new(0.9, -0.8, 0.2),
        ]);
        let (s, c) = Jet::<4>([0.4, -0.3, 0.2, 0.1]).sin_cos();
        for (k, sense) in [(0, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
            let mut axis = Vector::zeros();
            axis[k] = sense;
            let short = p.turned(&axis, &s, &c);
            // A hair off the axis takes the other way; its error is the size of the hair.
            axis[(k + 1) % 3] = 1e-13;
            let long = p.turned(&axis, &s, &c);
            for m in 0..4 {
                assert!((short.0[m] - long.0[m]).norm() < 1e-12, "axis {k}, order {m}");
            }
            let value = VectorJet::<1>([p.0[0]]);
            axis[(k + 1) % 3] = 0.0;
            assert_eq!(value.turned(&axis, &Jet([s.0[0]]), &Jet([c.0[0]])).0[0], short.0[0]);
        }
    }
}
