//! The cone, the cylinder that rolls on it, and the rotary words for a tool axis.
//!
//! All points and directions are in the workpiece frame W of the scene: origin at the center of the blank's
//! top face, z up. Lengths in mm, angles in radian.
//!
//! ```text
//!              apex                     a   cone axis, from base to apex, tilted about +Y
//!               /\                      d   generator, from the apex downward
//!              /  \  |  tool axis       n   outward normal of the cone along the generator
//!             /    \ |                  t   tool axis, tip to holder, t = -d
//!   top face /------\|---- z = 0
//!           /        \|                 contact line   p(s)   = apex + s d
//!          /   base   \|                tip            tip(s) = apex + s d + (radius + allowance) n
//!         /------------\|__             s: distance from the apex to the tool's lower end along generator
//! ```
//!
//! The tool cylinder touches the tangent plane of the cone along the whole generator and lies outside of it.
//! A cone is convex, so the cylinder enters the cone nowhere, and turning it about the cone's axis cuts the
//! cone exactly. The lower end of the tool is a disk square to the generator. Its rim point on the contact
//! line is the lowest point of the disk along the cone's axis, so the wall is exact down to the circle s.

/// Point or direction in W.
pub(crate) type Xyz = [f64; 3];

/// `a + k b`.
pub(crate) fn along(a: Xyz, k: f64, b: Xyz) -> Xyz {
    [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]]
}

/// Scalar product.
pub(crate) fn dot(a: Xyz, b: Xyz) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Length.
pub(crate) fn norm(a: Xyz) -> f64 {
    dot(a, a).sqrt()
}

/// A right circular cone whose axis is tilted in the XZ plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cone {
    /// Tip of the cone, mm.
    pub(crate) apex: Xyz,
    /// Unit vector from base to apex.
    pub(crate) axis: Xyz,
    /// Between axis and generator.
    pub(crate) half_angle: f64,
}

impl Cone {
    /// The cone with this base circle; `tilt` turns the axis from +Z toward +X.
    pub(crate) fn from_base(center: Xyz, radius: f64, half_angle: f64, tilt: f64) -> Self {
        let axis = [tilt.sin(), 0.0, tilt.cos()];
        Self { apex: along(center, radius / half_angle.tan(), axis), axis, half_angle }
    }

    /// Unit vector square to the axis at the angle `theta` about it; 0 is the side of +X.
    pub(crate) fn radial(&self, theta: f64) -> Xyz {
        let (sin, cos) = theta.sin_cos();
        [cos * self.axis[2], sin, -cos * self.axis[0]]
    }

    /// Generator from the apex downward, unit vector.
    pub(crate) fn generator(&self, theta: f64) -> Xyz {
        let (sin, cos) = self.half_angle.sin_cos();
        let down = [-cos * self.axis[0], -cos * self.axis[1], -cos * self.axis[2]];
        along(down, sin, self.radial(theta))
    }

    /// Outward normal along the generator, unit vector.
    pub(crate) fn normal(&self, theta: f64) -> Xyz {
        let (sin, cos) = self.half_angle.sin_cos();
        let r = self.radial(theta);
        along([cos * r[0], cos * r[1], cos * r[2]], sin, self.axis)
    }

    /// Signed distance of a point from the cone, positive outside; valid where the foot of the perpendicular
    /// lies below the apex.
    pub(crate) fn distance(&self, p: Xyz) -> f64 {
        let v = along(p, -1.0, self.apex);
        let below_apex = -dot(v, self.axis);
        let from_axis = norm(along(v, below_apex, self.axis));
        from_axis * self.half_angle.cos() - below_apex * self.half_angle.sin()
    }
}

/// Tool tip and unit tool axis (tip to holder) in W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Location {
    /// Center of the tool's flat end, mm.
    pub(crate) tip: Xyz,
    /// Unit vector.
    pub(crate) axis: Xyz,
}

impl Location {
    /// The same tool drawn back along its axis until the tip has this height, mm.
    pub(crate) fn raised_to(&self, z: f64) -> Self {
        Self { tip: along(self.tip, (z - self.tip[2]) / self.axis[2], self.axis), axis: self.axis }
    }
}

/// The cylinder of radius `radius` on the generator `theta`, lower end `s` from the apex, `allowance` off the
/// cone.
pub(crate) fn on_generator(cone: &Cone, theta: f64, s: f64, radius: f64, allowance: f64) -> Location {
    let d = cone.generator(theta);
    let contact = along(cone.apex, s, d);
    Location { tip: along(contact, radius + allowance, cone.normal(theta)), axis: [-d[0], -d[1], -d[2]] }
}

/// Order and letters of the two rotary axes of a machine; angles count as motion of the tool against the
/// workpiece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rotaries {
    /// `t = Rz(C) Ry(B) e_z`, B positive.
    Bc,
    /// `t = Rz(C) Rx(A) e_z`, A negative.
    Ac,
}

impl Rotaries {
    /// Letter of the tilting axis.
    pub(crate) fn tilt_letter(self) -> char {
        match self {
            Self::Bc => 'B',
            Self::Ac => 'A',
        }
    }

    /// Tilt and C (radian) for a unit tool axis off the Z direction; of the equal angles C, the one next to
    /// `near`.
    pub(crate) fn angles(self, t: Xyz, near: f64) -> [f64; 2] {
        let inclination = t[0].hypot(t[1]).atan2(t[2]);
        let (tilt, c) = match self {
            Self::Bc => (inclination, t[1].atan2(t[0])),
            Self::Ac => (-inclination, (-t[0]).atan2(t[1])),
        };
        [tilt, c + std::f64::consts::TAU * ((near - c) / std::f64::consts::TAU).round()]
    }

    /// Tool axis for tilt and C (radian).
    pub(crate) fn tool_axis(self, tilt: f64, c: f64) -> Xyz {
        let (st, ct) = tilt.sin_cos();
        let (sc, cc) = c.sin_cos();
        match self {
            Self::Bc => [cc * st, sc * st, ct],
            Self::Ac => [sc * st, -cc * st, ct],
        }
    }
}

/// Largest entry of the cylinder into the cone on the way between two locations, mm; negative is a distance.
///
/// The tip runs on a straight line. Two laws are tried for the axis: both rotary angles in proportion (840D
/// `ORIAXES`) and the great circle (`ORIVECT`). A disk of the cylinder lies within the ball of the same
/// radius and center, so `radius - distance(center)` over the axis up to `reach` bounds the entry; it is
/// exact to second order in the small angle between tool axis and generator.
pub(crate) fn entry_between(
    cone: &Cone,
    rotaries: Rotaries,
    from: &Location,
    to: &Location,
    radius: f64,
    reach: f64,
) -> f64 {
    const STEPS: u32 = 8;
    let mut worst = f64::NEG_INFINITY;
    let [tilt_0, c_0] = rotaries.angles(from.axis, 0.0);
    let [tilt_1, c_1] = rotaries.angles(to.axis, c_0);
    for i in 0..=STEPS {
        let u = f64::from(i) / f64::from(STEPS);
        let tip = along(from.tip, u, along(to.tip, -1.0, from.tip));
        let linear = rotaries.tool_axis(tilt_0 + u * (tilt_1 - tilt_0), c_0 + u * (c_1 - c_0));
        for axis in [linear, great_circle(from.axis, to.axis, u)] {
            for j in 0..=STEPS {
                let center = along(tip, reach * f64::from(j) / f64::from(STEPS), axis);
                worst = worst.max(radius - cone.distance(center));
            }
        }
    }
    worst
}

/// Unit vector on the great circle from `a` to `b` at the fraction `u` of the angle.
fn great_circle(a: Xyz, b: Xyz, u: f64) -> Xyz {
    let chord = norm(along(a, -1.0, b));
    let angle = 2.0 * (0.5 * chord).asin();
    if angle < 1e-12 {
        return a;
    }
    let (wa, wb) = (((1.0 - u) * angle).sin() / angle.sin(), (u * angle).sin() / angle.sin());
    along([wa * a[0], wa * a[1], wa * a[2]], wb, b)
}
