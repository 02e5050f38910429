//! Exact discretization of a linear system whose inputs are constant or follow from a constant jerk.
//!
//! For `z' = F z + G u` the inputs join the state: those that are constant have the derivative zero, the
//! reference is the chain `r1' = r2, r2' = r3, r3' = 0`. The matrix exponential of the whole over the step h
//! then holds both blocks
//!
//! ```text
//!        | F  G |       | A(h)  B(h) |
//!   exp( | 0  N | h ) = |  0    ...  |       z(h) = A z(0) + B u(0)
//! ```
//!
//! without any error of integration at any h (Van Loan 1978; Åström and Wittenmark 1997, section 2.3).

use nalgebra::DMatrix;

/// Inputs of every map, in this order.
pub(crate) const INPUTS: usize = 7;
/// Commanded velocity, acceleration and jerk at the begin of the step.
pub(crate) const RATE: usize = 0;
pub(crate) const ACCELERATION: usize = 1;
pub(crate) const JERK: usize = 2;
/// Dry friction.
pub(crate) const FRICTION: usize = 3;
/// What the bodies put on the load.
pub(crate) const LOAD: usize = 4;
/// Force of a saturated motor.
pub(crate) const MOTOR: usize = 5;
/// Place of the flank that touches, or of the load in the lost motion.
pub(crate) const OFFSET: usize = 6;
/// Largest element of the power above which the motion does not die out: the next square could overflow.
const GROWN: f64 = 1e80;
/// Largest element of the power below which the motion dies out.
const DIED_OUT: f64 = 1e-3;

/// One step: `z = A z + B u`.
#[derive(Clone, Debug)]
pub(crate) struct Map<const N: usize> {
    pub(crate) a: [[f64; N]; N],
    pub(crate) b: [[f64; INPUTS]; N],
}

impl<const N: usize> Map<N> {
    /// Discretizes `z' = F z + G u` over `h`.
    pub(crate) fn new(f: &[[f64; N]; N], g: &[[f64; INPUTS]; N], h: f64) -> Self {
        let mut whole = DMatrix::<f64>::zeros(N + INPUTS, N + INPUTS);
        for i in 0..N {
            for k in 0..N {
                whole[(i, k)] = f[i][k] * h;
            }
            for k in 0..INPUTS {
                whole[(i, N + k)] = g[i][k] * h;
            }
        }
        whole[(N + RATE, N + ACCELERATION)] = h;
        whole[(N + ACCELERATION, N + JERK)] = h;
        let e = whole.exp();
        Self {
            a: std::array::from_fn(|i| std::array::from_fn(|k| e[(i, k)])),
            b: std::array::from_fn(|i| std::array::from_fn(|k| e[(i, N + k)])),
        }
    }

    /// The state after the step.
    #[inline]
    pub(crate) fn apply(&self, z: &[f64; N], u: &[f64; INPUTS]) -> [f64; N] {
        std::array::from_fn(|i| {
            let mut sum = 0.0;
            for k in 0..N {
                sum += self.a[i][k] * z[k];
            }
            for k in 0..INPUTS {
                sum += self.b[i][k] * u[k];
            }
            sum
        })
    }

    /// True when the free motion dies out: the state is carried over 2^30 steps by squaring.
    ///
    /// An eigenvalue outside the unit circle by more than 1e-8 lets the power grow beyond every bound; one
    /// inside it by as much lets it vanish.
    pub(crate) fn dies_out(&self) -> bool {
        let mut power = DMatrix::from_fn(N, N, |i, k| self.a[i][k]);
        for _ in 0..30 {
            power = &power * &power;
            let size = power.amax();
            if size.is_nan() || size >= GROWN {
                return false;
            }
            if size < DIED_OUT {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillator_turns_exactly() {
        let w = 40.0;
        for h in [1e-5, 1e-3, 0.3] {
            let map = Map::new(&[[0.0, 1.0], [-w * w, 0.0]], &[[0.0; INPUTS]; 2], h);
            let (s, c) = (w * h).sin_cos();
            let expected = [[c, s / w], [-w * s, c]];
            for i in 0..2 {
                for k in 0..2 {
                    // Entries up to w; an exponential by squaring keeps about 1e-13 of the largest.
                    assert!((map.a[i][k] - expected[i][k]).abs() < 1e-11, "{h} {i} {k}");
                }
            }
        }
    }

    #[test]
    fn a_free_mass_under_constant_jerk_follows_its_polynomial() {
        // x' = r1: the integral of the reference's chain.
        let mut g = [[0.0; INPUTS]; 1];
        g[0][RATE] = 1.0;
        let h = 0.02;
        let map = Map::new(&[[0.0]], &g, h);
        let z = map.apply(&[1.0], &[3.0, -2.0, 50.0, 0.0, 0.0, 0.0, 0.0]);
        let expected = 1.0 + 3.0 * h - 2.0 * h * h / 2.0 + 50.0 * h.powi(3) / 6.0;
        assert!((z[0] - expected).abs() < 1e-15);
    }

    #[test]
    fn stable_and_unstable_are_distinguished() {
        let with = |damping: f64| Map::new(&[[0.0, 1.0], [-100.0, -damping]], &[[0.0; INPUTS]; 2], 1e-3);
        assert!(with(0.1).dies_out());
        assert!(!with(-0.1).dies_out());
        assert!(!with(0.0).dies_out());
    }
}
