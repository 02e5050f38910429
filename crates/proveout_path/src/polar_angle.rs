//! The polar angle of the Joukowski pre-image of a point of a standardized section (Lu, Yang and Zhao 2022,
//! equations (3) to (7), doi:10.21203/rs.3.rs-1213345/v1), with the branch and the exact formulas that the
//! paper does not give.
//!
//! With `z = a (rho e^(i theta))` and `sigma = z + a^2 / z`, 2a half of the distance of the branch points and
//! rho = e^psi:
//!
//! ```text
//!   x / 2a = cosh psi cos theta        y / 2a = sinh psi sin theta
//!   h = (4 a^2 - x^2 - y^2) / 4 a^2 = sin^2 theta - sinh^2 psi,        q = y / 2a = sinh psi sin theta
//!   r = sqrt(h^2 + 4 q^2) = sin^2 theta + sinh^2 psi
//! ```
//!
//! so that `sin^2 theta = (r + h) / 2` and `sinh^2 psi = (r - h) / 2`. The one of the two in which
//! signs agree is used directly, the other is computed from the product
//! `sin^2 theta sinh^2 psi = q^2`: no digit is lost near an edge, where both go to zero. The
//! side of the section, not the sign of y, decides the half of the circle: on a cambered section
//! the pressure side lies partly above the chord line, with rho < 1.

use std::f64::consts::{PI, TAU};

/// Pre-image of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarPoint {
    /// Polar angle, 0 at the trailing edge, pi at the leading edge, radian in 0 to 2 pi.
    pub theta: f64,
    /// Radius, parts of a; below 1 where the section lies inside of its branch cut.
    pub rho: f64,
}

impl PolarPoint {
    /// The parameter of the paper, theta / 2 pi.
    pub fn u(&self) -> f64 {
        self.theta / TAU
    }

    /// The point (x, y) of this pre-image, for the radius a (equation (6)).
    pub fn image(&self, a: f64) -> [f64; 2] {
        let (s, c) = self.theta.sin_cos();
        [a * (self.rho + 1.0 / self.rho) * c, a * (self.rho - 1.0 / self.rho) * s]
    }
}

/// Half of the contour between the edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContourSide {
    /// From the trailing edge over the convex side to the leading edge: theta from 0 to pi.
    Suction,
    /// From the leading edge over the concave side to the trailing edge: theta from pi to 2 pi.
    Pressure,
}

/// The pre-image of (x, y), branch points at (-2a, 0) and (2a, 0).
pub fn polar_point(x: f64, y: f64, a: f64, side: ContourSide) -> PolarPoint {
    let (p, q) = (x / (2.0 * a), y / (2.0 * a));
    // (1 - p)(1 + p) keeps its digits near the edges.
    let h = (1.0 - p) * (1.0 + p) - q * q;
    let r = h.hypot(2.0 * q);
    let (sine2, sinh2) = if h >= 0.0 {
        let sine2 = 0.5 * (r + h);
        (sine2, if sine2 > 0.0 { q * q / sine2 } else { 0.0 })
    } else {
        let sinh2 = 0.5 * (r - h);
        (q * q / sinh2, sinh2)
    };
    let sign = if side == ContourSide::Suction { 1.0 } else { -1.0 };
    let sine = sign * sine2.sqrt();
    let cosine = p / (1.0 + sinh2).sqrt();
    let mut theta = sine.atan2(cosine);
    if side == ContourSide::Pressure && theta <= 0.0 {
        theta += TAU;
    }
    // q = sinh psi sin theta gives the sign of psi.
    let psi = sinh2.sqrt().asinh().copysign(if q * sign < 0.0 { -1.0 } else { 1.0 });
    PolarPoint { theta: theta.clamp(0.0, 2.0 * PI), rho: psi.exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOLDEN: &str = include_str!("../tests/data/quasi_circle_golden_theta.csv");

    #[test]
    fn the_golden_angles_and_their_negative() {
        let (mut rows, mut naive_fails) = (0, 0);
        for line in GOLDEN.lines().skip(1) {
            let v: Vec<f64> = line.split(',').map(|n| n.trim().parse().unwrap()).collect();
            let side = if v[0] > 0.0 { ContourSide::Suction } else { ContourSide::Pressure };
            let found = polar_point(v[1], v[2], 0.25, side);
            assert!((found.theta.to_degrees() - v[3]).abs() < 1e-9, "{line}: {}", found.theta.to_degrees());
            assert!((found.rho - v[4]).abs() < 1e-9 && (found.u() - v[5]).abs() < 1e-9, "{line}: {found:?}");
            naive_fails += usize::from((found.theta.to_degrees() - v[6]).abs() > 1.0);
            rows += 1;
        }
        assert_eq!(
            (rows, naive_fails),
            (18, 7),
            "the sign of y puts seven points of the pressure side on the suction side"
        );
    }

    #[test]
    fn points_come_back_to_the_last_digits_up_to_the_edges() {
        for a in [0.25, 7.0] {
            for k in 1..200 {
                // Towards the trailing edge by powers of ten, both sides, thin and thick, cambered.
                let gap = 10_f64.powf(-0.08 * f64::from(k));
                for (xi, side) in [(1.0 - gap, 1.0), (gap - 1.0, -1.0), (gap, -1.0), (0.3 - gap, 1.0)] {
                    let (x, half) = (2.0 * a * xi, (1.0 - xi * xi).max(0.0));
                    let y = 2.0 * a * (0.24 * half + side * 0.06 * half.sqrt());
                    let which = if side > 0.0 { ContourSide::Suction } else { ContourSide::Pressure };
                    let found = polar_point(x, y, a, which);
                    let [bx, by] = found.image(a);
                    assert!(
                        (bx - x).abs() < 2e-15 * a.max(1.0) && (by - y).abs() < 2e-15 * a.max(1.0),
                        "{xi} {side} {found:?}"
                    );
                    assert!(if side > 0.0 { found.theta <= PI } else { found.theta >= PI });
                }
            }
        }
    }

    #[test]
    fn the_edges_themselves() {
        assert_eq!(polar_point(0.5, 0.0, 0.25, ContourSide::Suction), PolarPoint { theta: 0.0, rho: 1.0 });
        assert_eq!(polar_point(-0.5, 0.0, 0.25, ContourSide::Suction).theta, PI);
        assert_eq!(polar_point(-0.5, 0.0, 0.25, ContourSide::Pressure).theta, PI);
        // An edge half a nose radius outside of the branch point: theta is 0 there, rho is above 1.
        let outside = polar_point(0.55, 0.0, 0.25, ContourSide::Suction);
        assert!(outside.theta == 0.0 && (outside.rho - 1.1_f64.acosh().exp()).abs() < 1e-14);
        let last = polar_point(0.5, 0.0, 0.25, ContourSide::Pressure).theta;
        assert!(last == TAU, "{last}");
    }
}
