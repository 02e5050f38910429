//! What a cutter leaves at one contact: curvatures, profile across the feed, width of the strip that it cuts.
//!
//! Frame of the contact: X along the feed, N the outward normal of the design, Y = N x X, so that +Y is on
//! the left as seen along the feed. The cutter is any convex body of revolution, its axis T from tip to
//! holder.
//!
//! **Section.** The cut of the standing cutter with the plane Y N (Dong et al. 2023, equations (12), (13));
//! distances are taken along N.
//!
//! **Swept.** While the cutter moves along X it leaves the outline of its shadow on the plane Y N. The shadow
//! of a convex body has the body's own support function on directions u across X: the farthest point of a
//! body of revolution in direction u lies on the half plane of u, at the place (r, z) of the generating curve
//! that is farthest along (sin g, cos g), cos g = u T. For a torus this is the outline of an ellipse with
//! half axes R - r and (R - r) |T X|, grown by r. So, with u = Y sin p - N cos p,
//!
//! ```text
//!   place(p) = place of the farthest point in direction u(p) across the feed,   (y, z) = place(p) - place(0)
//! ```
//!
//! runs along the profile from the contact outward. Its curvature at the contact is k1 k2 / k(X), k1 and k2
//! being the curvatures of the cutter along and across the lean: both widths agree to second order where the
//! cutter leans along the feed.

use proveout_geom::{Point, Vector};
use proveout_tool::{Profile, Segment};

use crate::topography::StandingCutter;

/// A lean below this is none, radian.
const UPRIGHT: f64 = 1e-6;
/// Halvings: an angle is then exact to rounding.
const HALVINGS: usize = 60;
/// Shorter vectors have no direction.
const SHORTEST: f64 = 1e-12;
/// The axis may lie below the tangent plane by this sine: rounding.
const TILTED: f64 = 1e-9;
/// Places are equally far along a direction within this, mm.
const EQUALLY_FAR: f64 = 1e-12;
/// A direction ends on an arc where it lies this part of the radius beyond: rounding.
const BEYOND_ARC: f64 = 1e-12;
/// A sine below this is zero: the direction lies on the axis.
const ON_AXIS: f64 = 1e-15;
/// A share below this is none, also of a curvature without bound.
const NO_SHARE: f64 = 1e-15;
/// Sine of a lean below which it has no azimuth.
const NO_LEAN: f64 = 1e-12;
/// Radius of a place below which it lies on the axis, mm.
const CENTER_MM: f64 = 1e-12;
/// Ends of a flat end are level, and apart, by more than this, mm.
const FLAT_MM: f64 = 1e-9;
/// The search for the width steps back from the edge of the shadow by this part of the widest.
const BACK: f64 = 1e-9;
/// There the height is as asked within this part of it and mm: else the cutter has ended below it.
const REACHED: [f64; 2] = [1e-3, 1e-6];
/// Two cutters are equally high where they cross within this, mm, and part of the step.
const CROSSED: f64 = 1e-9;

/// A cutter that touches the design.
#[derive(Clone, Copy, Debug)]
pub struct CutterContact<'a> {
    profile: &'a Profile,
    axis: Vector,
    normal: Vector,
    feed: Vector,
    left: Vector,
}

impl<'a> CutterContact<'a> {
    /// A contact; none where a direction has no length, the feed runs along the normal, or the cutter lies in
    /// the part.
    pub fn new(profile: &'a Profile, axis: Vector, normal: Vector, feed: Vector) -> Option<Self> {
        let (axis, normal) = (axis.try_normalize(SHORTEST)?, normal.try_normalize(SHORTEST)?);
        let feed = (feed - normal * feed.dot(&normal)).try_normalize(SHORTEST)?;
        (axis.dot(&normal) > -TILTED).then_some(Self { profile, axis, normal, feed, left: normal.cross(&feed) })
    }

    /// The same with lead and tilt: inclination of the axis to the normal, and azimuth of the lean from the
    /// feed toward the left, radian.
    pub fn with_tilt(profile: &'a Profile, inclination: f64, azimuth: f64) -> Option<Self> {
        let (sine, cosine) = inclination.sin_cos();
        let axis = Vector::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine);
        Self::new(profile, axis, Vector::z(), Vector::x())
    }

    /// Place (r, z) of the generating curve that is farthest along (sin, cos), and the curvature there.
    fn farthest(&self, sine: f64, cosine: f64) -> ([f64; 2], f64) {
        let mut best = (f64::NEG_INFINITY, [0.0, 0.0], 0.0);
        let mut offer = |place: [f64; 2], curvature: f64| {
            let along = place[0] * sine + place[1] * cosine;
            // Of two places equally far, the one with the larger curvature: the end of an arc rather than
            // the face next to it.
            if along > best.0 + EQUALLY_FAR || along > best.0 - EQUALLY_FAR && curvature > best.2 {
                best = (along.max(best.0), place, curvature);
            }
        };
        for segment in self.profile.segments() {
            offer(segment.from(), f64::INFINITY);
            offer(segment.to(), f64::INFINITY);
            if let Segment::Arc { center, radius, from, to } = *segment {
                let cross = |p: [f64; 2]| (p[0] - center[0]) * cosine - (p[1] - center[1]) * sine;
                if cross(from) >= -BEYOND_ARC * radius && cross(to) <= BEYOND_ARC * radius {
                    return ([center[0] + radius * sine, center[1] + radius * cosine], 1.0 / radius);
                }
            }
        }
        (best.1, best.2)
    }

    /// The farthest point of the cutter in a direction, from its tip.
    fn support(&self, u: &Vector) -> Vector {
        let cosine = u.dot(&self.axis).clamp(-1.0, 1.0);
        let across = u - self.axis * cosine;
        let sine = across.norm();
        let ([r, z], _) = self.farthest(sine, cosine);
        let out = if sine > ON_AXIS { across / sine } else { Vector::zeros() };
        out * r + self.axis * z
    }

    /// The tip, from the contact.
    fn tip(&self) -> Vector {
        -self.support(&-self.normal)
    }

    /// Inclination of the axis to the normal and azimuth of its lean from the feed toward the left, radian.
    pub fn lean(&self) -> [f64; 2] {
        let aside = [self.axis.dot(&self.feed), self.axis.dot(&self.left)];
        let sine = aside[0].hypot(aside[1]);
        [sine.atan2(self.axis.dot(&self.normal)), if sine > NO_LEAN { aside[1].atan2(aside[0]) } else { 0.0 }]
    }

    /// Curvatures of the cutter at the contact along and across its lean, 1/mm: k1 of the generating curve
    /// (infinite at a sharp corner), k2 = sin / r round the axis (Dong et al. 2023, section 3).
    pub fn curvatures(&self) -> [f64; 2] {
        let [inclination, _] = self.lean();
        let (sine, cosine) = inclination.sin_cos();
        let ([r, _], k1) = self.farthest(sine, -cosine);
        [k1, if r > CENTER_MM { sine / r } else { k1 }]
    }

    /// Radius of curvature of the cutter across the feed, in the plane Y N, mm.
    pub fn radius_across(&self) -> f64 {
        let ([k1, k2], [_, azimuth]) = (self.curvatures(), self.lean());
        let (sine, cosine) = azimuth.sin_cos();
        let part = |k: f64, share: f64| if share.abs() < NO_SHARE { 0.0 } else { k * share };
        1.0 / (part(k1, sine * sine) + part(k2, cosine * cosine))
    }

    /// Curvature of what the moving cutter leaves, 1/mm: k1 k2 / k(X).
    pub fn swept_curvature(&self) -> f64 {
        let ([k1, k2], [_, azimuth]) = (self.curvatures(), self.lean());
        let (sine, cosine) = azimuth.sin_cos();
        // Divided by k1, which is infinite at a sharp corner.
        k2 / (cosine * cosine + k2 / k1 * sine * sine)
    }

    /// Width of the strip by the radius across the feed, 2 sqrt(R^2 - (R - h)^2) (Dong et al. 2023, middle of
    /// equation (14)), mm.
    pub fn width_by_radius(&self, height: f64) -> f64 {
        let radius = self.radius_across();
        2.0 * (radius * radius - (radius - height).powi(2)).sqrt()
    }

    /// The cutter lies on the design with the flat of its end: it touches along a line or a face, and no
    /// single place of it is the contact.
    pub fn rests_on_flat(&self) -> bool {
        let [inclination, _] = self.lean();
        let lowest = self.profile.z_min();
        inclination < UPRIGHT
            && self.profile.segments().iter().any(|segment| {
                let (from, to) = (segment.from(), segment.to());
                let level = |p: [f64; 2]| p[1] <= lowest + FLAT_MM;
                matches!(segment, Segment::Line { .. }) && level(from) && level(to) && (to[0] - from[0]).abs() > FLAT_MM
            })
    }

    /// Widths to the left and to the right up to a height above a plane design, of the standing cutter, mm.
    pub fn section_width(&self, height: f64) -> Option<[f64; 2]> {
        self.section_width_over(height, 0.0)
    }

    /// The same along a design of constant curvature across the feed, 1/mm, positive where it is convex:
    /// widths are arcs of the design.
    pub fn section_width_over(&self, height: f64, curvature: f64) -> Option<[f64; 2]> {
        let standing = StandingCutter::new(self.profile, Point::from(self.tip()), self.axis);
        let widest = 2.0 * (self.profile.max_radius() + self.profile.z_max().abs());
        let width = |side: f64| {
            let at = |y: f64| {
                let z = standing.height(&Point::from(self.left * (side * y)), &self.normal)?;
                above_arc([y, z], curvature)
            };
            let (mut low, mut high) = (0.0, widest);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if at(middle).is_some_and(|h| h[1] < height) { low = middle } else { high = middle }
            }
            // Beyond the cutter nothing has a height: the edge of its shadow is no width.
            let last = low - BACK * widest;
            let ends = at(last).filter(|h| (h[1] - height).abs() < REACHED[0] * height + REACHED[1]);
            ends.and_then(|_| at(low)).map(|h| h[0])
        };
        Some([width(1.0)?, width(-1.0)?])
    }

    /// The profile at an angle from the contact, to the left for positive ones: (y, z), mm.
    fn profile_at(&self, angle: f64, from: &Vector) -> [f64; 2] {
        let u = self.left * angle.sin() - self.normal * angle.cos();
        let place = self.support(&u) - from;
        [place.dot(&self.left), place.dot(&self.normal)]
    }

    /// Where the profile on one side reaches `wanted` in coordinate `k` (0: y to that side, 1: z), both
    /// counted along and above a design of this curvature; the other coordinate too.
    fn reach(&self, side: f64, k: usize, wanted: f64, curvature: f64) -> Option<[f64; 2]> {
        let from = self.support(&-self.normal);
        let at = |angle: f64| {
            let [y, z] = self.profile_at(side * angle, &from);
            // Beyond the middle of a hollow no place of the design is the nearest one.
            above_arc([side * y, z], curvature).unwrap_or([side * y, f64::MAX])
        };
        let (mut low, mut high) = (0.0, std::f64::consts::PI);
        let (mut first, mut last) = ([0.0, 0.0], at(high));
        // The half circle ends at the top; y grows up to the widest place only.
        if k == 0 {
            high *= 0.5;
            last = at(high);
        }
        if last[k] < wanted {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let here = at(middle);
            if here[k] < wanted { (low, first) = (middle, here) } else { (high, last) = (middle, here) }
        }
        // On a straight part both ends of the step stay apart.
        let share = if last[k] > first[k] { (wanted - first[k]) / (last[k] - first[k]) } else { 0.0 };
        Some([first[0] + share * (last[0] - first[0]), first[1] + share * (last[1] - first[1])])
    }

    /// Widths to the left and to the right up to a height above a plane design, of the moving cutter, mm.
    pub fn swept_width(&self, height: f64) -> Option<[f64; 2]> {
        self.swept_width_over(height, 0.0)
    }

    /// The same along a design of constant curvature across the feed, 1/mm, positive where it is convex:
    /// widths are arcs of the design.
    pub fn swept_width_over(&self, height: f64, curvature: f64) -> Option<[f64; 2]> {
        Some([self.reach(1.0, 1, height, curvature)?[0], self.reach(-1.0, 1, height, curvature)?[0]])
    }

    /// Height that the moving cutter leaves to the side of the contact, mm, `y` counted to the left; none
    /// beyond its shadow.
    pub fn swept_height(&self, y: f64) -> Option<f64> {
        Some(self.reach(if y < 0.0 { -1.0 } else { 1.0 }, 0, y.abs(), 0.0)?[1])
    }
}

/// A place of the plane across the feed, from the contact, as arc along and height above the circle of the
/// design through the contact, mm; none beyond the middle of a hollow.
fn above_arc([y, z]: [f64; 2], curvature: f64) -> Option<[f64; 2]> {
    if curvature == 0.0 {
        return Some([y, z]);
    }
    let (a, b) = (y * curvature, 1.0 + z * curvature);
    if b <= 0.0 {
        return None;
    }
    let grown = a.hypot(b);
    Some([a.atan2(b) / curvature, (2.0 * z + curvature * (y * y + z * z)) / (1.0 + grown)])
}

/// Height of the ridge between two passes above a design of constant curvature across the feed, and its
/// place.
///
/// The contacts lie `step` apart (their chord, mm), `first` to the right of `second` as seen along the feed
/// of `first`; `curvature` is that of the design, positive where it is convex. The ridge is the place at
/// which the profiles of both meet: Newton's method by secants on the height of the one over the other. None
/// where they do not meet.
pub fn scallop_between(
    first: &CutterContact<'_>,
    second: &CutterContact<'_>,
    step: f64,
    curvature: f64,
) -> Option<f64> {
    // The plane across the feed: origin at the first contact, its left as x, its normal as z.
    let half = (0.5 * step * curvature).asin();
    let turn = 2.0 * half;
    let (sine, cosine) = turn.sin_cos();
    let origin = [step * half.cos(), -step * half.sin()];
    // Seen along the other way, the other pass lies to its own left.
    let other_side = if first.left.dot(&second.left) >= 0.0 { 1.0 } else { -1.0 };
    let above = |y: f64| {
        let z = first.swept_height(y)?;
        let d = [y - origin[0], z - origin[1]];
        let own = [d[0] * cosine - d[1] * sine, d[0] * sine + d[1] * cosine];
        Some((own[1] - second.swept_height(own[0] * other_side)?, z))
    };
    // Below the second profile at the first contact, above it at the second one.
    let (mut low, mut high) = (0.0, origin[0]);
    let mut best = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match above(middle) {
            Some((d, z)) if d < 0.0 => (low, best) = (middle, Some(z)),
            Some((_, z)) => (high, best) = (middle, Some(z)),
            // Beyond the shadow of the one it is on the side of the other.
            None if first.swept_height(middle).is_none() => high = middle,
            None => low = middle,
        }
    }
    let (y, z) = (0.5 * (low + high), best?);
    above(y).filter(|(d, _)| d.abs() < CROSSED * (1.0 + step))?;
    // Height above the circle of the design through the first contact: center at -1 / curvature on the
    // normal.
    let (a, b) = (y * curvature, 1.0 + z * curvature);
    let grown = a.hypot(b);
    Some(if curvature == 0.0 { z } else { (2.0 * z + curvature * (y * y + z * z)) / (1.0 + grown) })
}
