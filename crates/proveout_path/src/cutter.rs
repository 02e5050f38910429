//! From contact to cutter location, for any convex cutter of revolution: ball, bull-nose, drum wheel, barrel,
//! lens, general APT.
//!
//! In the half plane through the axis T and the contact, with r from the axis towards the contact and z along
//! the axis,
//!
//! ```text
//!        z = T
//!        |        d = (|n - (n.T) T|, -n.T)    the direction -n in this half plane: where the
//!        |  .--.                               outward normal of the cutter points
//!        | (    )--> d     the contact is the support point (r, z) of the profile in the direction d
//!        |  '--'
//!        +------> r        tip = contact - r e_r - z T,    e_r = -(n - (n.T) T) / |n - (n.T) T|
//! ```
//!
//! which for a disk of radius D/2 - R thickened by R is equation (2.8) of Cui et al. 2022 with its vector
//! normalized. The cutter's curvatures at the contact are 1/R of its arc in the half plane and `d_r / r`
//! round the axis (Meusnier).
//!
//! The cutter is convex, so that the distance of its skin from a plane with normal n is that of its support
//! point, exactly: [`PathCutter::gap`] judges poses between two contacts by it.

use proveout_geom::{Point, ToolPose, Vector};
use proveout_tool::{Profile, Segment};

use super::place::{Form, PathPoint};

/// Sine of the angle between axis and normal below which the half plane is not defined: the one before is
/// kept.
const NO_HALF_PLANE: f64 = 1e-9;
/// Two support points nearer to each other in the direction asked for than this part of the cutter's size are
/// a flat.
const FLAT: f64 = 1e-12;
/// Curvature of a sharp corner, 1/mm: a radius of a tenth of a nanometer.
const SHARP: f64 = 1e7;
/// Rounding of the ends of an arc of the profile, part of its radius.
const ARC_END: f64 = 1e-12;
/// A contact nearer to the tool's axis than this is on it, mm.
const ON_AXIS_MM: f64 = 1e-9;

/// The cutting end of a tool as planning needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct PathCutter {
    profile: Profile,
    ball: Option<f64>,
}

/// Where a cutter touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutterTouch {
    /// Tip and axis.
    pub pose: ToolPose,
    /// Unit vector across the axis, from it towards the contact.
    pub radial: Vector,
    /// The contact in the half plane, `[r, z]`, mm.
    pub on_profile: [f64; 2],
    /// Normal curvatures of the cutter along the feed, mixed, and across, 1/mm, positive as it is convex.
    pub form: Form,
}

impl PathCutter {
    /// The cutting end with this profile.
    pub fn new(profile: Profile) -> Self {
        Self { ball: profile.ball_radius(), profile }
    }

    /// The profile.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Radius of a ball end mill, mm.
    pub fn ball_radius(&self) -> Option<f64> {
        self.ball
    }

    /// Support point `[r, z]` in the direction `[d_r >= 0, d_z]` of unit length, with the curvature of the
    /// profile there. On a flat the point nearest to an arc that ends it: the rim of a wheel's face, the
    /// lower end of a cylinder.
    fn support(&self, d: [f64; 2]) -> ([f64; 2], f64) {
        let flat = FLAT * (self.profile.max_radius() + self.profile.z_max() - self.profile.z_min());
        let mut best = ([0.0, 0.0], 0.0);
        let mut reach = f64::NEG_INFINITY;
        let along = |p: [f64; 2]| p[0] * d[0] + p[1] * d[1];
        for segment in self.profile.segments() {
            // An arc of half a turn at most has the normals between those of its ends, counter-clockwise.
            if let Segment::Arc { center, radius, from, to } = *segment {
                let turned = |p: [f64; 2]| (p[0] - center[0]) * d[1] - (p[1] - center[1]) * d[0];
                let slack = ARC_END * radius;
                if turned(from) >= -slack && turned(to) <= slack {
                    let point = [(center[0] + radius * d[0]).max(0.0), center[1] + radius * d[1]];
                    if along(point) > reach + flat {
                        (best, reach) = ((point, 1.0 / radius), along(point));
                    }
                }
            }
        }
        for segment in self.profile.segments() {
            for corner in [segment.from(), segment.to()] {
                if along(corner) > reach + flat {
                    (best, reach) = ((corner, SHARP), along(corner));
                }
            }
            if let Segment::Line { from, to } = *segment
                && (along(from) - reach).abs() <= flat
                && (along(to) - reach).abs() <= flat
            {
                best.1 = 0.0;
            }
        }
        best
    }

    /// The cutter with an axis (unit vector from the tip to the holder) at a place, with so much
    /// material (mm) left. `before` is the radial direction of the previous contact, kept where the
    /// axis is along the normal.
    pub fn touch(&self, place: &PathPoint, axis: &Vector, allowance: f64, before: Option<Vector>) -> CutterTouch {
        let n = &place.normal;
        let upright = n.dot(axis);
        let across_axis = n - axis * upright;
        let sine = across_axis.norm();
        let radial = if sine > NO_HALF_PLANE {
            -across_axis / sine
        } else {
            let kept = before.unwrap_or(place.feed);
            (kept - axis * kept.dot(axis)).try_normalize(NO_HALF_PLANE).unwrap_or(place.feed)
        };
        let (on_profile, meridian) = self.support([sine, -upright]);
        let contact = place.point + n * allowance;
        let tip = contact - radial * on_profile[0] - axis * on_profile[1];
        let pose = ToolPose { tip, axis: *axis };
        let round = if on_profile[0] > ON_AXIS_MM { sine / on_profile[0] } else { meridian };
        // Directions on the skin: round the axis, and along the profile.
        let about = axis.cross(&radial);
        let (f, k) = (place.feed.dot(&about), place.across.dot(&about));
        let form = [
            round * f * f + meridian * (1.0 - f * f),
            (round - meridian) * f * k,
            round * k * k + meridian * (1.0 - k * k),
        ];
        CutterTouch { pose, radial, on_profile, form }
    }

    /// Signed distance of the cutter in a pose from the plane through `point` with the unit normal n, mm:
    /// negative where the cutter reaches below it.
    ///
    /// ```
    /// use proveout_geom::{Point, ToolPose, Vector};
    /// use proveout_tool::Cutter;
    /// use proveout_path::PathCutter;
    ///
    /// let ball = PathCutter::new(Cutter::ball(6.0)?.bodies(20.0)?.remove(0)); // mm
    /// let pose = ToolPose { tip: Point::new(0.0, 0.0, 1.0), axis: Vector::new(0.6, 0.0, 0.8) };
    /// // The center lies 3 mm up the axis, at z = 1 + 3 * 0.8 = 3.4: the ball reaches down to 0.4.
    /// let gap = ball.gap(&pose, &Point::origin(), &Vector::z());
    /// assert!((gap - 0.4).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn gap(&self, pose: &ToolPose, point: &Point, n: &Vector) -> f64 {
        let upright = n.dot(&pose.axis);
        let sine = (n - pose.axis * upright).norm();
        let (on_profile, _) = self.support([sine, -upright]);
        (pose.tip - point).dot(n) - (on_profile[0] * sine - on_profile[1] * upright)
    }
}

/// Curvature across the feed of the surface that the moving cutter leaves, 1/mm, positive as the cutter is
/// convex; none where the cutter is locally larger than the surface.
///
/// The envelope touches the surface along the path, so that both share the normals on it and with them the
/// first row of their forms, `[-s_ff, -s_fk]` as seen from the cutter; and it touches the cutter along a
/// curve, so that `det(C - E) = 0`:
///
/// ```text
///   e = c_kk - (c_fk + s_fk)^2 / (c_ff + s_ff)
/// ```
pub fn envelope_across(cutter: &Form, surface: &Form) -> Option<f64> {
    let along = cutter[0] + surface[0];
    let mixed = cutter[1] + surface[1];
    let across = cutter[2] + surface[2];
    (along > 0.0 && along * across > mixed * mixed).then(|| cutter[2] - mixed * mixed / along)
}

/// Where a cutter does not fit: its curvature and the hollowness of the surface in the direction in which
/// they differ least.
pub(crate) fn overlap(cutter: &Form, surface: &Form) -> Option<[f64; 2]> {
    let [a, b, c] = std::array::from_fn(|i| cutter[i] + surface[i]);
    let least = 0.5 * (a + c) - (0.25 * (a - c) * (a - c) + b * b).sqrt();
    if least > 0.0 {
        return None;
    }
    // The direction of the lower root of the form.
    let (x, y) = if a <= c { (least - c, b) } else { (b, least - a) };
    let norm = x.hypot(y);
    let (x, y) = if norm > 0.0 { (x / norm, y / norm) } else { (1.0, 0.0) };
    let value = |f: &Form| f[0] * x * x + 2.0 * f[1] * x * y + f[2] * y * y;
    Some([value(cutter), -value(surface)])
}
