//! A point of a path on a surface: contact, feed direction, and the curvatures that steps and
//! scallops depend on.
//!
//! With c(t) = S(u(t), v(t)), f the unit vector along c', n the outward normal and k = n x f the direction
//! across,
//!
//! ```text
//!   c'  = S_u u' + S_v v'
//!   c'' = S_uu u'^2 + 2 S_uv u' v' + S_vv v'^2 + S_u u'' + S_v v''          curvature |c' x c''| / |c'|^3
//!   II(a, b) = - sum S_ij a_i b_j . n                                        positive where convex
//! ```

use proveout_blade::{Domain, Local, ParametricSurface};
use proveout_geom::{Point, Vector};

use super::{BladeLocation, ParameterCurve};

/// The symmetric form [along feed, feed with across, across] of normal curvatures at a contact, 1/mm.
pub type Form = [f64; 3];

/// A point of a path on a surface.
///
/// ```
/// use proveout_geom::Vector;
/// use proveout_blade::{ClosedSurface, Sine};
/// use proveout_path::{ParameterCurve, PathPoint};
///
/// // Waves along y, 12 mm high and 40 mm long, straight along x; the line runs on a crest.
/// let face = ClosedSurface::new(Sine::gentle());
/// let crest = ParameterCurve::straight([0.0, 20.0], [30.0, 20.0]).expect("two points");
/// let place = PathPoint::on(&face, &crest, 0.5);
/// assert!((place.point.coords - Vector::new(15.0, 20.0, 12.0)).norm() < 1e-9); // mm
/// assert!((place.feed - Vector::x()).norm() < 1e-9);
/// // z = 6 (1 - cos k y) has the curvature 6 k^2 across the crest.
/// let k = std::f64::consts::TAU / 40.0;
/// assert!((place.form[2] - 6.0 * k * k).abs() < 1e-9); // 1/mm
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Parameter of the curve.
    pub t: f64,
    /// Parameters of the surface.
    pub uv: [f64; 2],
    /// mm.
    pub point: Point,
    /// Outward unit normal.
    pub normal: Vector,
    /// Unit direction of travel.
    pub feed: Vector,
    /// Unit direction across, `normal x feed`.
    pub across: Vector,
    /// mm of way for each unit of t.
    pub speed: f64,
    /// Curvature of the path in space, 1/mm.
    pub path_curvature: f64,
    /// Normal curvatures of the surface, positive where convex.
    pub form: Form,
}

impl PathPoint {
    /// The place at t of a curve. Where the curve has no direction (c' = 0) the direction is that
    /// of u.
    pub fn on(surface: &dyn ParametricSurface, curve: &ParameterCurve, t: f64) -> Self {
        let at = curve.at(t);
        Self::of(surface.local(at.u[0], at.v[0]), t, [at.u, at.v])
    }

    fn of(local: Local, t: f64, [u, v]: [[f64; 3]; 2]) -> Self {
        let [su, sv] = &local.first;
        let [suu, suv, svv] = &local.second;
        let first = su * u[1] + sv * v[1];
        let second = suu * (u[1] * u[1]) + suv * (2.0 * u[1] * v[1]) + svv * (v[1] * v[1]) + su * u[2] + sv * v[2];
        let speed = first.norm();
        let feed = if speed > 0.0 { first / speed } else { su.normalize() };
        let across = local.normal.cross(&feed);
        // Parameters of the two directions, by the inverse of the first fundamental form.
        let (e, f, g) = (su.norm_squared(), su.dot(sv), sv.norm_squared());
        let det = e * g - f * f;
        let parameters = |d: &Vector| {
            let (a, b) = (d.dot(su), d.dot(sv));
            [(g * a - f * b) / det, (e * b - f * a) / det]
        };
        let (along, over) = (parameters(&feed), parameters(&across));
        let [l, m, n] = local.second.each_ref().map(|d| -d.dot(&local.normal));
        let form = |a: [f64; 2], b: [f64; 2]| l * a[0] * b[0] + m * (a[0] * b[1] + a[1] * b[0]) + n * a[1] * b[1];
        Self {
            t,
            uv: [u[0], v[0]],
            point: local.point,
            normal: local.normal,
            feed,
            across,
            speed,
            path_curvature: if speed > 0.0 { first.cross(&second).norm() / speed.powi(3) } else { 0.0 },
            form: [form(along, along), form(along, over), form(over, over)],
        }
    }

    /// Where it is, for messages.
    pub fn named(&self, domain: &Domain) -> BladeLocation {
        named(domain, self.uv, &self.point)
    }
}

/// Where a point is, for messages.
pub(crate) fn named(domain: &Domain, uv: [f64; 2], point: &Point) -> BladeLocation {
    let part = |x: f64, [low, high]: [f64; 2]| (x - low) / (high - low);
    let round = part(uv[0], domain.u);
    BladeLocation {
        section: part(uv[1], domain.v),
        round: if domain.u_closed { round.rem_euclid(1.0) } else { round },
        point: point.coords.into(),
    }
}
