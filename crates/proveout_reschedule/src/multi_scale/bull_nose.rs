//! A bull-nose cutter at a contact: where it gouges by its curvature, how wide a strip it cuts, what section
//! it leaves.
//!
//! Everything is in the frame of the contact: origin at the contact, x along the feed, y = normal x feed, z
//! the outward normal N. With T the tool axis, e the radius of the circle of corner centers and r the corner
//! radius, the middle of that circle is `r N + e w`, `w = (N - (N.T) T) / |..|`: the tip is r below it along
//! T.
//!
//! Local gouge (derived from (5)-(9), as the printed search over the inclination is not needed): with `kC_max
//! = 1/r` along the lean and `kC_min` across it, the smallest relative curvature is zero where
//!
//! ```text
//!   kC_min = [ a (S1 sin^2 g + S2 cos^2 g) - S1 S2 ] / ( a - S1 cos^2 g - S2 sin^2 g ),     a = 1/r
//! ```
//!
//! which is linear because the terms in `(a - kC_min)^2` cancel; `kC_min = sin l / (e + r sin l)` gives the
//! inclination l.

use proveout_geom::Vector;
use proveout_tool::{Profile, Segment};

use super::judge::root;

/// Steps in which the rim of a strip is looked for, mm, and how far at most.
const RIM_STEP: f64 = 0.05;
const RIM_MOST: f64 = 10.0;
/// How near to its place a rim is found, mm.
const RIM_CLOSE: f64 = 1e-12;
/// Rounding of a profile's corner, mm.
const ROUNDING_MM: f64 = 1e-9;
/// Sine of the angle between axis and normal below which they count as parallel.
const UPRIGHT: f64 = 1e-12;
/// Least length of the direction to a rim: the place on the circle stays finite.
const LEAST_RIM: f64 = 1e-12;

/// The cutting end: a circle of corner centers thickened by the corner radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BullNose {
    /// Radius of the circle of corner centers, mm, above zero.
    pub circle: f64,
    /// Corner radius, mm.
    pub corner: f64,
}

impl BullNose {
    /// Takes a profile whose lowest point is on a corner with its center off the axis.
    pub fn of(profile: &Profile) -> Option<Self> {
        profile.segments().iter().find_map(|segment| match *segment {
            Segment::Arc { center, radius, .. }
                if center[0] > ROUNDING_MM && (center[1] - radius).abs() < ROUNDING_MM =>
            {
                Some(Self { circle: center[0], corner: radius })
            }
            _ => None,
        })
    }

    /// Smallest inclination (radian) at which the tool, leaned at the angle `gamma` from the direction of the
    /// most hollow curvature, does not gouge by its curvature. `hollow` are the surface's principal
    /// curvatures, the larger first, positive where it is hollow, 1/mm. None where no inclination will do.
    pub fn least_lean(&self, hollow: [f64; 2], gamma: f64) -> Option<f64> {
        let a = 1.0 / self.corner;
        let [s1, s2] = hollow;
        let (sin, cos) = gamma.sin_cos();
        let (sin2, cos2) = (sin * sin, cos * cos);
        let room = a - s1 * cos2 - s2 * sin2;
        if room <= 0.0 {
            return None;
        }
        let needed = (a * (s1 * sin2 + s2 * cos2) - s1 * s2) / room;
        if needed <= 0.0 {
            return Some(0.0);
        }
        let sine = needed * self.circle / (1.0 - needed * self.corner);
        (needed * self.corner < 1.0 && sine <= 1.0).then(|| sine.asin())
    }

    /// Normal curvatures of the cutter along x, mixed, and along y, with its axis `t` (unit), 1/mm, positive
    /// as it is convex.
    pub fn form(&self, t: &Vector) -> [f64; 3] {
        let sine = t.x.hypot(t.y);
        let along = 1.0 / self.corner;
        let across = sine / (self.circle + self.corner * sine);
        let (x, y) = if sine > UPRIGHT { (t.x / sine, t.y / sine) } else { (1.0, 0.0) };
        [along * x * x + across * y * y, (along - across) * x * y, along * y * y + across * x * x]
    }

    /// Center of the circle of corner centers.
    fn middle(&self, t: &Vector) -> Vector {
        Vector::new(0.0, 0.0, self.corner) + across(&Vector::z(), t) * self.circle
    }

    /// Signed distance of a point from the cutting end with its flank as a cylinder above the corners, mm;
    /// negative inside.
    fn outside(&self, middle: &Vector, t: &Vector, p: &Vector) -> f64 {
        let from = p - middle;
        let height = from.dot(t);
        let radius = (from - t * height).norm();
        if radius <= self.circle {
            -height - self.corner
        } else if height >= 0.0 {
            radius - self.circle - self.corner
        } else {
            (radius - self.circle).hypot(height) - self.corner
        }
    }

    /// Widths of the strip on the left (y > 0) and on the right of the contact in the section across the
    /// feed, mm: where the tool is `h` above the surface, measured along N ((12), (13)). `surface` is its
    /// height over y. None where the tool leaves the section sooner.
    pub fn strip(&self, t: &Vector, surface: &dyn Fn(f64) -> f64, h: f64) -> Option<[f64; 2]> {
        let middle = self.middle(t);
        self.rims(surface, h, &|p| self.outside(&middle, t, &p))
    }

    /// The same for the strip that the moving tool leaves: the shadow of the cutter along the feed.
    pub fn swept_strip(&self, t: &Vector, surface: &dyn Fn(f64) -> f64, h: f64) -> Option<[f64; 2]> {
        let middle = self.middle(t);
        let nearest = |p: Vector| {
            // The distance from a convex body along a line has one minimum.
            let at = |x: f64| self.outside(&middle, t, &Vector::new(x, p.y, p.z));
            let reach = self.circle + self.corner;
            let (mut low, mut high) = (middle.x - reach, middle.x + reach);
            // To a millionth of a millimeter: the distance is flat there.
            for _ in 0..42 {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if at(a) <= at(b) { high = b } else { low = a }
            }
            at(0.5 * (low + high))
        };
        self.rims(surface, h, &nearest)
    }

    fn rims(&self, surface: &dyn Fn(f64) -> f64, h: f64, outside: &dyn Fn(Vector) -> f64) -> Option<[f64; 2]> {
        let above = |y: f64| outside(Vector::new(0.0, y, surface(y) + h));
        let begin = above(0.0);
        if begin >= 0.0 {
            return None;
        }
        let rim = |side: f64| {
            let (mut inner, mut below) = (0.0, begin);
            while inner < RIM_MOST {
                let outer = inner + RIM_STEP;
                let next = above(side * outer);
                if next > 0.0 {
                    return Some(root([inner, outer], [below, next], RIM_CLOSE, |y| above(side * y)));
                }
                (inner, below) = (outer, next);
            }
            None
        };
        Some([rim(1.0)?, rim(-1.0)?])
    }

    /// The section that the tool leaves as it moves along x, of a contact elsewhere: `at` with the normal `n`
    /// there, all in one frame. The boundary of a shadow is that of the support points whose normals lie in
    /// its plane.
    pub(super) fn shadow(&self, at: &Vector, n: &Vector, t: &Vector) -> Shadow {
        let middle = at + n * self.corner + across(n, t) * self.circle;
        Shadow { tool: *self, middle: [middle.y, middle.z], axis: *t }
    }
}

/// The shadow of a bull-nose cutter along x.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shadow {
    tool: BullNose,
    /// Center of the circle of corner centers, y and z.
    middle: [f64; 2],
    axis: Vector,
}

impl Shadow {
    /// The place of its boundary whose normal leans by an angle (radian) from -z to y.
    ///
    /// With `c = d.t` for the normal d, the circle is seen from the side as an ellipse, whose radius of
    /// curvature is `e t_x^2 / (1 - c^2)^(3/2)`.
    pub(super) fn at(&self, slope: f64) -> Rim {
        let BullNose { circle, corner } = self.tool;
        let (sin, cos) = slope.sin_cos();
        let c = self.axis.y * sin - self.axis.z * cos;
        let rim = [-self.axis.x * c, sin - self.axis.y * c, -cos - self.axis.z * c];
        let length = (rim[0] * rim[0] + rim[1] * rim[1] + rim[2] * rim[2]).sqrt().max(LEAST_RIM);
        let part = circle / length;
        let radius = corner + part * self.axis.x * self.axis.x / (length * length);
        Rim {
            slope,
            y: self.middle[0] + rim[1] * part + sin * corner,
            z: self.middle[1] + rim[2] * part - cos * corner,
            rate: radius * cos,
            rise: sin / cos,
        }
    }
}

/// A place of the boundary of a shadow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rim {
    /// Angle of its normal from -z to y, radian.
    pub(super) slope: f64,
    pub(super) y: f64,
    pub(super) z: f64,
    /// How fast y grows with the angle, mm.
    pub(super) rate: f64,
    /// Slope of the boundary.
    pub(super) rise: f64,
}

/// Unit vector across the axis `t`, from the contact's normal: away from the contact towards the tool's
/// middle.
fn across(n: &Vector, t: &Vector) -> Vector {
    let w = n - t * n.dot(t);
    let length = w.norm();
    if length > UPRIGHT { w / length } else { Vector::zeros() }
}

/// Smallest relative curvature of cutter and surface over all directions, 1/mm ((9)); `convex` is
/// the surface's form, positive where it is convex. Below zero the cutter gouges near its contact.
pub fn critical(cutter: [f64; 3], convex: [f64; 3]) -> f64 {
    let [a, b, c] = std::array::from_fn(|i| cutter[i] + convex[i]);
    0.5 * (a + c) - (0.25 * (a - c) * (a - c) + b * b).sqrt()
}
