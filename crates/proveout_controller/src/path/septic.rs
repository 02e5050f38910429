//! Joints over a cell as polynomials of the path parameter.
//!
//! With tool center point control the joints are functions of tip and rotary joints through the chains of the
//! machine (`rtcp.rs`): a product of jets at every place that is looked at, some tens of them a block. Over a
//! cell, which turns a rotary joint by three degrees at most, the polynomial of seventh degree with value and
//! three derivatives of both ends is the same function for every purpose:
//!
//! ```text
//!   q(s) - p(s) = q^(8) (s - a)^4 (s - b)^4 / 8!   (Hermite's remainder, Stoer and Bulirsch 2002, 2.1.5)
//! ```
//!
//! It is highest in the middle. The polynomial is taken where it is as near as [`NEAR`] to the kinematics at
//! the places at which the cell was looked at, and its derivatives as near as [`ALIKE`]; elsewhere the
//! kinematics is asked. Rotary joints and rounded corners are of fifth degree, and are met exactly. The run
//! follows the polynomial: limits, set points and pieces are all of one motion, whose acceleration has no
//! jumps that the path has not, since neighbors share the jets at their border.

use proveout_machine::JointValues;

use crate::{jet::JointJet, limits::JointLimits};

/// Largest way of a joint from the kinematics at a place that is looked at, mm and radian: a ten thousandth
/// of the finest tolerance of a path for slides, and as little at a radius of 300 mm.
const NEAR: f64 = 1e-7;
const NEAR_TURN: f64 = 3e-10;
/// Largest error of the second and third derivative, as part of the highest one in the cell, or of what the
/// joint's limit allows at the highest speed: far below the surcharge on the cell's bounds.
const ALIKE: f64 = 1e-4;

/// A polynomial a joint over `from..=from + length`, by powers of the part of the length.
#[derive(Clone, Debug)]
pub(crate) struct Septic {
    from: f64,
    over: f64,
    powers: [JointValues; 8],
}

impl Septic {
    /// The polynomial with these jets at its ends.
    pub(super) fn hermite([from, to]: [f64; 2], begin: &JointJet, end: &JointJet) -> Self {
        let h = to - from;
        let scaled = |jet: &JointJet| [jet.0[0], jet.0[1] * h, jet.0[2] * (h * h), jet.0[3] * (h * h * h)];
        let ([a0, a1, a2, a3], [b0, b1, b2, b3]) = (scaled(begin), scaled(end));
        // What the cubic at the begin lacks at the end, as power series about it.
        let e0 = b0 - a0 - (a1 + a2 + a3);
        let e1 = b1 - (a1 + a2 * 2.0 + a3 * 3.0);
        let e2 = b2 - (a2 + a3 * 3.0);
        let e3 = b3 - a3;
        // That over t^4 = (1 + u)^4 with u = t - 1, then by powers of t.
        let g0 = e0;
        let g1 = e1 - e0 * 4.0;
        let g2 = e2 - e1 * 4.0 + e0 * 10.0;
        let g3 = e3 - e2 * 4.0 + e1 * 10.0 - e0 * 20.0;
        let powers = [a0, a1, a2, a3, g0 - g1 + g2 - g3, g1 - g2 * 2.0 + g3 * 3.0, g2 - g3 * 3.0, g3];
        Self { from, over: 1.0 / h, powers }
    }

    fn part(&self, s: f64) -> f64 {
        ((s - self.from) * self.over).clamp(0.0, 1.0)
    }

    /// Joint positions at s.
    pub(crate) fn at(&self, s: f64) -> JointValues {
        let t = self.part(s);
        let [.., last] = self.powers;
        self.powers[..7].iter().rev().fold(last, |sum, power| sum * t + *power)
    }

    /// Taylor coefficients at s.
    pub(crate) fn jet(&self, s: f64) -> JointJet {
        let t = self.part(s);
        // Horner's rule for a value and its derivatives at once: every order takes the sum of the one below
        // as it was.
        let [.., last] = self.powers;
        let zero = JointValues::ZERO;
        let [mut d0, mut d1, mut d2, mut d3] = [last, zero, zero, zero];
        for power in self.powers[..7].iter().rev() {
            d3 = d3 * t + d2;
            d2 = d2 * t + d1;
            d1 = d1 * t + d0;
            d0 = d0 * t + *power;
        }
        let over = self.over;
        JointJet([d0, d1 * over, d2 * (over * over), d3 * (over * over * over)])
    }

    /// Whether it approximates the kinematics, checked by its jets at some places; `second` and
    /// `third` are the highest derivatives in the cell, `highest` the highest speed.
    pub(super) fn stands_for(
        &self,
        limits: &JointLimits,
        rotary: impl Fn(usize) -> bool,
        places: &[(f64, JointJet)],
        [second, third]: [&JointValues; 2],
        highest: f64,
    ) -> bool {
        places.iter().all(|(s, jet)| {
            let own = self.jet(*s);
            (0..limits.count).all(|i| {
                let off = |k: usize| (own.0[k][i] - jet.0[k][i]).abs();
                let bend = ALIKE * second[i].max(limits.acceleration[i] / (highest * highest));
                let twist = ALIKE * third[i].max(limits.jerk[i] / (highest * highest * highest));
                off(0) <= if rotary(i) { NEAR_TURN } else { NEAR } && 2.0 * off(2) <= bend && 6.0 * off(3) <= twist
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jet::Jet;

    /// A polynomial of seventh degree is met to rounding; the jets at both ends are those that were given.
    #[test]
    fn polynomials_of_the_seventh_degree_are_met() {
        let c = [300.0, -2.0, 0.7, 0.4, -0.3, 0.05, 0.02, -0.011];
        // Taylor coefficients about s: binomials times powers.
        let jet = |s: f64| {
            let mut out = [0.0; 4];
            for (m, out) in out.iter_mut().enumerate() {
                let mut binomial = 1.0;
                for (k, c) in c.iter().enumerate().skip(m) {
                    *out += c * binomial * s.powi((k - m) as i32);
                    binomial *= (k + 1) as f64 / (k + 1 - m) as f64;
                }
            }
            let mut all = JointJet::constant(JointValues::ZERO);
            all.set(1, &Jet(out));
            all
        };
        let septic = Septic::hermite([-0.4, 1.3], &jet(-0.4), &jet(1.3));
        for k in 0..=20 {
            let s = -0.4 + 0.085 * f64::from(k);
            let (own, exact) = (septic.jet(s), jet(s));
            // Rounding of 300, times what three derivatives make of it.
            for (m, bound) in [1e-12, 1e-11, 1e-10, 1e-10].into_iter().enumerate() {
                assert!((own.0[m] - exact.0[m]).max_abs() < bound, "{k} {m}");
            }
            assert!((septic.at(s) - own.0[0]).max_abs() < 1e-12);
        }
    }
}
