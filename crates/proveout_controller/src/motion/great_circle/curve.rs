//! The way of the tool axis of a block: a great circle, led through a pole where it would pass too near to
//! it.
//!
//! ```text
//!     from o                          o to       the circle passes the pole p at the angle d, at its point c
//!           \__                    __/
//!              \__              __/              s: angle from c along the circle, t the direction in c
//!                 \____ c _____/                 N: across the circle, towards p
//!                       | d
//!                       p
//! ```
//!
//! Past a pole the first rotary joint swings by nearly half a turn within a way of d, and with d = 0 by none
//! at all: both branches meet there, and the tilt changes its sign instead. Where d is below the cone's angle
//! g the control takes this other way. The axis is turned about t by an angle that is d in the middle and
//! zero from s = 2 g on, with four continuous derivatives at its ends:
//!
//! ```text
//!   u(s) = (c cos b + N sin b) cos s + t sin s        b(s) = d (1 - (s/2g)^2)^4
//! ```
//!
//! It has length one, runs through p in the direction t, and leaves the circle by b cos s, thus by d at most.
//! With d <= g the direction to p turns by less than 35 degrees on either side.

use proveout_geom::Vector;

use crate::jet::{Jet, VectorJet};

/// Two opposite axes have no circle between them; nearer to that than this (radian), rounding chooses it.
pub(super) const OPPOSITE: f64 = 1e-6;
/// Sine of the angle between two axes below which they are the same: no circle is between them.
const SAME_AXIS: f64 = 1e-12;

/// A pole nearer than this (radian) to an end of the circle is that end: a tenth of what counts as a pole.
const AT_END: f64 = 1e-7;

/// Tool axis over t in 0..=1.
#[derive(Clone, Debug)]
pub(super) struct AxisCurve {
    from: Vector,
    /// Unit vector across `from` in the direction of travel.
    way: Vector,
    /// Length of the circle, radian.
    pub(super) angle: f64,
    pub(super) pass: Option<PolePassage>,
}

/// Where the axis is led through a pole.
#[derive(Clone, Debug)]
pub(super) struct PolePassage {
    /// The pole, a unit vector of K.
    pub(super) pole: Vector,
    /// Parameter at which the axis is in it.
    pub(super) t: f64,
    /// Angle by which the axis leaves the circle there, radian.
    pub(super) off: f64,
    half_width: f64,
    closest: Vector,
    across: Vector,
    along: Vector,
}

fn angle_between(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

impl AxisCurve {
    /// The shorter great circle between two unit vectors; none where they are the same or opposite.
    pub(super) fn circle(from: &Vector, to: &Vector) -> Option<Self> {
        let angle = angle_between(from, to);
        if angle > std::f64::consts::PI - OPPOSITE {
            return None;
        }
        let across = to - from * from.dot(to);
        let way = (across - from * from.dot(&across)).try_normalize(SAME_AXIS)?;
        Some(Self { from: *from, way, angle, pass: None })
    }

    /// Angle from a unit vector to the nearest point of the circle within the block, where it is nearest
    /// neither in the begin nor in the end, and the angle from the begin to that point.
    fn foot(&self, pole: &Vector) -> Option<(f64, f64)> {
        let s = pole.dot(&self.way).atan2(pole.dot(&self.from));
        (s > 0.0 && s < self.angle).then(|| (angle_between(pole, &self.point(s)), s))
    }

    /// Leads the circle through the first of the poles that it passes within an angle of `cone`. A pole so
    /// near to an end that the circle would be left by more than half of the way to it is passed as
    /// programmed.
    pub(super) fn through_poles(mut self, poles: &[Vector], cone: f64) -> Self {
        for pole in poles {
            let Some((off, s)) = self.foot(pole) else { continue };
            let half_width = (2.0 * cone).min(s).min(self.angle - s);
            // An end in the pole itself is not passed, whatever rounding says of its side.
            if off > cone || off > 0.5 * half_width || half_width < AT_END {
                continue;
            }
            let (closest, along) = (self.point(s), self.way * s.cos() - self.from * s.sin());
            // Across the circle, on the pole's side; any where the circle runs through it.
            let across = closest.cross(&along);
            let across = if across.dot(pole) < 0.0 { -across } else { across };
            let t = s / self.angle;
            self.pass = Some(PolePassage { pole: *pole, t, off, half_width, closest, across, along });
            break;
        }
        self
    }

    fn point(&self, s: f64) -> Vector {
        let (sine, cosine) = s.sin_cos();
        self.from * cosine + self.way * sine
    }

    /// Tool axis at t.
    pub(super) fn at(&self, t: f64) -> Vector {
        self.jet(t).0[0]
    }

    /// Taylor coefficients by t.
    pub(super) fn jet(&self, t: f64) -> VectorJet {
        let s = self.angle * t;
        if let Some(pass) = &self.pass {
            let x = s - self.angle * pass.t;
            if x.abs() < pass.half_width {
                return pass.jet(x, self.angle);
            }
        }
        let (sine, cosine) = Jet([s, self.angle, 0.0, 0.0]).sin_cos();
        VectorJet::constant(self.from).times(&cosine).plus(&VectorJet::constant(self.way).times(&sine))
    }
}

impl PolePassage {
    fn jet(&self, x: f64, angle: f64) -> VectorJet {
        let place = Jet::<4>([x / self.half_width, angle / self.half_width, 0.0, 0.0]);
        let mut rest = Jet(place.times(&place).0.map(|v| -v));
        rest.0[0] += 1.0;
        let square = rest.times(&rest);
        let lean = Jet(square.times(&square).0.map(|v| v * self.off));
        let (sine, cosine) = lean.sin_cos();
        let middle =
            VectorJet::constant(self.closest).times(&cosine).plus(&VectorJet::constant(self.across).times(&sine));
        let (sine, cosine) = Jet([x, angle, 0.0, 0.0]).sin_cos();
        middle.times(&cosine).plus(&VectorJet::constant(self.along).times(&sine))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pole() -> Vector {
        Vector::z()
    }

    /// A circle of 40 degrees that passes the pole at an angle, a third of the way.
    fn passing(off: f64) -> AxisCurve {
        let closest = pole() * off.cos() + Vector::y() * off.sin();
        let at = |s: f64| closest * s.cos() + Vector::x() * s.sin();
        AxisCurve::circle(&at(-0.2), &at(0.4)).expect("no opposite ends")
    }

    #[test]
    fn the_circle_keeps_its_ends_and_its_length() {
        let curve = passing(0.05);
        assert!((curve.angle - 0.6).abs() < 1e-14 && curve.pass.is_none());
        for k in 0..=20 {
            let u = curve.at(f64::from(k) / 20.0);
            assert!((u.norm() - 1.0).abs() < 1e-14);
        }
        assert!(AxisCurve::circle(&Vector::x(), &-Vector::x()).is_none());
        assert!(AxisCurve::circle(&Vector::x(), &Vector::x()).is_none());
    }

    #[test]
    fn inside_of_the_cone_the_axis_runs_through_the_pole_and_leaves_the_circle_by_no_more_than_its_distance() {
        let cone = 0.01;
        for off in [0.0, 1e-9, 1e-4, 0.005, 0.009_99] {
            let circle = passing(off);
            let curve = circle.clone().through_poles(&[-pole(), pole()], cone);
            let pass = curve.pass.clone().expect("inside of the cone");
            assert!((curve.at(pass.t) - pole()).norm() < 1e-14, "{off}");
            assert!((pass.off - off).abs() < 1e-12 && (pass.t - 1.0 / 3.0).abs() < 1e-12);
            let mut worst = 0.0_f64;
            for k in 0..=20_000 {
                let t = f64::from(k) / 20_000.0;
                let (a, b) = (circle.at(t), curve.at(t));
                let left = angle_between(&a, &b);
                worst = worst.max(left);
                assert!((b.norm() - 1.0).abs() < 1e-14);
                if angle_between(&b, &pole()) > 2.3 * cone {
                    assert_eq!(a, b, "outside of twice the cone the circle is the programmed one");
                }
            }
            assert!(worst <= off * (1.0 + 1e-9) + 1e-15 && worst >= 0.99 * off, "{off}: {worst}");
        }
        assert!(passing(0.0101).through_poles(&[pole()], cone).pass.is_none());
    }

    #[test]
    fn derivatives_match_differences() {
        let curve = passing(0.008).through_poles(&[pole()], 0.01);
        for k in 1..600 {
            let t = 1.0 / 3.0 + 0.035 * (f64::from(k) / 300.0 - 1.0);
            let jet = curve.jet(t);
            let h = 1e-5;
            let slope = (curve.at(t + h) - curve.at(t - h)) / (2.0 * h);
            let bend = (curve.jet(t + h).0[1] - curve.jet(t - h).0[1]) / (4.0 * h);
            let third = (curve.jet(t + h).0[2] - curve.jet(t - h).0[2]) / (6.0 * h);
            // Errors of h^2 times derivatives by scales of 1/30 of the block.
            assert!((jet.0[1] - slope).norm() < 1e-6 && (jet.0[2] - bend).norm() < 1e-4, "{t}");
            assert!((jet.0[3] - third).norm() < 1e-2 * (1.0 + third.norm()), "{t}");
        }
    }

    #[test]
    fn an_end_in_a_pole_is_not_passed() {
        // Rounding puts the foot of the pole before or after the end.
        for k in 0..2000 {
            let (azimuth, tilt) = (0.37 * f64::from(k), 0.02 + 0.0007 * f64::from(k));
            let from = Vector::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos());
            for (a, b) in [(from, pole()), (pole(), from)] {
                let curve = AxisCurve::circle(&a, &b).expect("a circle").through_poles(&[pole(), -pole()], 1e-5);
                assert!(curve.pass.is_none(), "{k}");
            }
        }
    }

    #[test]
    fn a_pole_beside_an_end_is_passed_as_programmed() {
        let closest = pole() * 0.005_f64.cos() + Vector::y() * 0.005_f64.sin();
        let at = |s: f64| closest * s.cos() + Vector::x() * s.sin();
        let near = AxisCurve::circle(&at(-0.009), &at(0.4)).expect("a circle").through_poles(&[pole()], 0.01);
        assert!(near.pass.is_none());
        let further = AxisCurve::circle(&at(-0.011), &at(0.4)).expect("a circle").through_poles(&[pole()], 0.01);
        assert!(further.pass.is_some());
    }
}
