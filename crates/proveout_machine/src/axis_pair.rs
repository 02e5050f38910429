//! Two rotary joints that bring the tool axis into a given direction.
//!
//! With `a1` the rotary axis nearer to the table, `a2` the one nearer to the tool and `u0` the tool axis at
//! zero, the angles solve `R(a1, t1) R(a2, t2) u0 = u` (subproblem 2 of Paden 1986 and Kahan; Murray, Li and
//! Sastry 1994, section 3.2, with `d`, `e`, `f` the arcs below). The direction `v = R(a2, t2) u0` lies on two
//! cones:
//!
//! ```text
//!            a1          v . a1 = u . a1     = cos f    cone of u turned back about a1
//!            /\          v . a2 = u0 . a2    = cos e    cone of u0 turned about a2
//!         f /  \ d       a1 . a2             = cos d
//!          /    \
//!         v------a2      a spherical triangle with the sides d, e, f
//!             e
//! ```
//!
//! The cones meet in two directions, mirror images in the plane of `a1` and `a2`. Their height over that
//! plane is `v . (a1 x a2) = +-sqrt(G)` with the Gram determinant `G = sin² d sin² f - (cos e - cos d cos
//! f)²`. Written like that it loses all digits where the triangle is flat, which is at every singular pose;
//! with the arcs it factors as
//!
//! ```text
//!   G = 4 sin((e+f-d)/2) sin((e-f+d)/2) sin((d+f-e)/2) sin((d+e+f)/2)
//! ```
//!
//! (the spherical form of Heron's formula), where each factor keeps its relative precision. The axis can be
//! reached when `|d - e| <= f <= min(d + e, 2 pi - d - e)`. Limits: where `f` is 0 or pi the angle `t1` is
//! free (the singular cone has shrunk to the axis `a1`); on the other ends of the range both branches meet,
//! and the angles react to the square root of a change of `u`.

use std::f64::consts::{PI, TAU};

use proveout_geom::Vector;

/// Below this angle (radian) between the tool axis and the first rotary axis, the first angle is free; also
/// the distance from the end of reach at which two branches count as one. 1e-10 rad moves a tool of 1 m by
/// 0.1 nm, so what is dropped here is below the precision promised for poses.
pub(crate) const SINGULAR_ANGLE: f64 = 1e-10;
/// Branches whose cosines of the second angle differ by less are mirror images: rounding.
const MIRRORED: f64 = 1e-9;

/// Sine below which two axes count as parallel: the angles would amplify rounding a million times.
pub(crate) const PARALLEL_SINE: f64 = 1e-6;

/// Height over the plane of both axes (sine of an angle) below which the branches count as one: the tool axis
/// is then nearer to the end of its reach than rounding.
const SAME_BRANCH: f64 = 1e-8;

/// Solutions for one tool axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AxisAngles {
    /// First and second angle of each branch, in (-pi, pi].
    pub(crate) angles: [[f64; 2]; 2],
    /// Number of branches, 1 or 2.
    pub(crate) count: usize,
    /// The first angle does not change the tool axis here; it is given as zero.
    pub(crate) free_first: bool,
    /// The branches meet, or the first angle is free.
    pub(crate) singular: bool,
    /// Angle between the wanted axis and the one reached, radian.
    pub(crate) error: f64,
}

/// The constants of two rotary axes and the tool axis at zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisPair {
    first: Vector,
    /// Unit vectors across the first axis: in the plane of both axes, and normal to it.
    plane: Vector,
    normal: Vector,
    /// Unit vectors across the second axis: towards `u0`, and a quarter turn ahead.
    cosine: Vector,
    sine: Vector,
    cos_d: f64,
    sin_d: f64,
    cos_e: f64,
    d: f64,
    e: f64,
    /// Side of the plane on which branch 0 lies.
    branch_sign: f64,
}

/// Unit vector of the part of `v` across the unit vector `axis`, if there is one.
fn across(v: &Vector, axis: &Vector) -> Option<Vector> {
    let part = v - axis * axis.dot(v);
    // Subtract twice, so that the result is normal to the axis even where little was left.
    let part = part - axis * axis.dot(&part);
    part.try_normalize(PARALLEL_SINE)
}

fn arc(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// The same angle in (-pi, pi], without a negative zero.
pub(crate) fn principal(angle: f64) -> f64 {
    let a = if angle <= -PI {
        angle + TAU
    } else if angle > PI {
        angle - TAU
    } else {
        angle
    };
    a + 0.0
}

impl AxisPair {
    /// `None` when the axes are parallel, or when the second one is parallel to the tool.
    pub(crate) fn new(first: Vector, second: Vector, tool_at_zero: Vector) -> Option<Self> {
        let plane = across(&second, &first)?;
        let cosine = across(&tool_at_zero, &second)?;
        let normal = first.cross(&plane);
        let sine = second.cross(&cosine);
        // Branch 0 has the larger cosine of the second angle; when the branches are mirror images it has the
        // larger sine.
        let side = cosine.dot(&normal);
        let side = if side.abs() > MIRRORED { side } else { sine.dot(&normal) };
        Some(Self {
            first,
            plane,
            normal,
            cosine,
            sine,
            cos_d: first.dot(&second),
            sin_d: first.cross(&second).norm(),
            cos_e: second.dot(&tool_at_zero),
            d: arc(&first, &second),
            e: arc(&second, &tool_at_zero),
            branch_sign: side.signum(),
        })
    }

    /// Angle between `u` and the nearest axis at which the first angle is free or the branches meet.
    pub(crate) fn cone_angle(&self, u: &Vector) -> f64 {
        let f = arc(&self.first, u);
        let (low, high) = ((self.d - self.e).abs(), (self.d + self.e).min(TAU - self.d - self.e));
        (f - low).abs().min((high - f).abs())
    }

    /// Tool axes at which the first angle is free: `a1` where the cones about it close (d = e), its opposite
    /// where d + e = pi.
    pub(crate) fn poles(&self) -> [Option<Vector>; 2] {
        let closed = |gap: f64| gap.abs() <= SINGULAR_ANGLE;
        [closed(self.d - self.e).then_some(self.first), closed(self.d + self.e - PI).then_some(-self.first)]
    }

    /// Branch to which a second angle belongs: the side of the plane of both axes on which the tool axis
    /// lies. None next to the plane, where the branches meet.
    pub(crate) fn branch_of(&self, second: f64) -> Option<usize> {
        let (s, c) = second.sin_cos();
        let height = self.e.sin() * (self.cosine.dot(&self.normal) * c + self.sine.dot(&self.normal) * s);
        (height.abs() > SAME_BRANCH).then(|| usize::from(height * self.branch_sign < 0.0))
    }

    /// Limits of both branches where the tool axis leaves a pole in a direction (a unit vector across `a1`):
    /// in [`Self::solve`] the part in the plane vanishes with the square of f, the height with f itself.
    pub(crate) fn leave(&self, pole: &Vector, direction: &Vector) -> [[f64; 2]; 2] {
        let second = pole.dot(&self.sine).atan2(pole.dot(&self.cosine));
        let (in_plane, across) = (direction.dot(&self.plane), direction.dot(&self.normal));
        [self.branch_sign, -self.branch_sign].map(|side| {
            let first = (-in_plane * side).atan2(across * side);
            [principal(first), principal(second)]
        })
    }

    /// All pairs of angles for the unit vector `u`. If `u` is out of reach, solves for the nearest
    /// direction, and `error` is the distance to it.
    pub(crate) fn solve(&self, u: &Vector) -> AxisAngles {
        let (mut sin_f, mut cos_f) = (self.first.cross(u).norm(), self.first.dot(u));
        let wanted = sin_f.atan2(cos_f);
        let (low, high) = ((self.d - self.e).abs(), (self.d + self.e).min(TAU - self.d - self.e));
        let f = wanted.clamp(low, high);
        let error = (wanted - f).abs();
        if error > 0.0 {
            (sin_f, cos_f) = f.sin_cos();
        }
        let free_first = sin_f <= SINGULAR_ANGLE;
        let singular = free_first || f - low <= SINGULAR_ANGLE || high - f <= SINGULAR_ANGLE;
        let half = |x: f64| (0.5 * x).sin();
        let (d, e) = (self.d, self.e);
        let gram = 4.0 * half(e + f - d) * half(e - f + d) * half(d + f - e) * half(d + e + f);
        let height = if singular { 0.0 } else { gram.max(0.0).sqrt() / self.sin_d };
        let in_plane = (self.cos_e - self.cos_d * cos_f) / self.sin_d;
        let (u_plane, u_normal) = (u.dot(&self.plane), u.dot(&self.normal));
        let mut result =
            AxisAngles { count: if singular { 1 } else { 2 }, free_first, singular, error, ..AxisAngles::default() };
        for (angles, sign) in result.angles.iter_mut().zip([self.branch_sign, -self.branch_sign]) {
            let h = sign * height;
            let v = self.first * cos_f + self.plane * in_plane + self.normal * h;
            let second = v.dot(&self.sine).atan2(v.dot(&self.cosine));
            let first = if free_first {
                0.0
            } else {
                (u_normal * in_plane - u_plane * h).atan2(u_plane * in_plane + u_normal * h)
            };
            *angles = [principal(first), principal(second)];
        }
        result
    }
}

/// One rotary axis: the angle that brings `tool_at_zero` nearest to `u`, in the form of [`AxisPair::solve`]
/// with the angle first.
pub(crate) fn solve_single(axis: &Vector, tool_at_zero: &Vector, u: &Vector) -> AxisAngles {
    let (from, to) = (arc(axis, tool_at_zero), arc(axis, u));
    let mut result = AxisAngles { count: 1, error: (from - to).abs(), ..AxisAngles::default() };
    match across(tool_at_zero, axis) {
        Some(cosine) if to.sin() > SINGULAR_ANGLE => {
            let sine = axis.cross(&cosine);
            result.angles[0][0] = principal(u.dot(&sine).atan2(u.dot(&cosine)));
        }
        _ => {
            result.free_first = true;
            result.singular = true;
        }
    }
    result
}
