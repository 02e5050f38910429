//! The 2D profile model of a bull-nose tool: Dong, He, Liu, Wan, Chang, "A Multi-Scale Tool Orientation
//! Generation Method for Freeform Surface Machining with Bull-Nose Tool", Micromachines 2023, 14, 1199. A
//! fast alternative to a simulated patch.
//!
//! Frame at a contact: x the feed, z the outward normal N, y = z x x across the feed. The tool axis leans by
//! the inclination l from N, its projection lies at the azimuth w from the feed: T = (sin l cos w, sin l sin
//! w, cos l) (equation 2 with g - s = w).
//!
//! ```text
//!              T                    curvatures of the tool at the contact (R total radius, r corner radius)
//!             /   N                   along T'  a = 1 / r
//!        ____/    |                   across    b = sin l / ((R - r) + r sin l)
//!       (___/__)  |  l
//!          r   `--|                 across the feed (5):   k = a sin^2 w + b cos^2 w
//!      ___________|____ y           of what it sweeps:     k = a b / (a cos^2 w + b sin^2 w)
//! ```
//!
//! The second one is the least height over all places along the feed (the paper takes the first, a single
//! section; both agree for w = 0 to second order). Against a surface of curvature c across the feed, positive
//! where it bends towards N, passes at distance d leave parabolas of height H = (k - c) d^2 / 8, with Ra = 4
//! H / (9 sqrt 3) about their mean line (16).
//!
//! [`Dong::profile`] is the paper's own procedure with the exact torus in place of the parabolas of (15): for
//! a line through each nominal point along the normal of the middle, the smallest signed distance to the cuts
//! of all passes. The distance to a torus is known in closed form, and a line meets it by steps of that
//! distance (Hart 1996), which cannot jump over it. Cuts rise to both sides of their contact, so that only
//! the two passes round a point can be the lowest.
//!
//! Limits: passes are parallel, straight along the feed and alike, the surface is a cylinder across the feed,
//! teeth have no run-out (a comparison with the kinematics of four teeth gave 0.5 percent, with 10 um of
//! run-out 4.4).

use super::{Profile, TextureError, cusp};

/// What passes of a bull-nose tool leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dong {
    radius: f64,
    corner: f64,
    inclination: f64,
    azimuth: f64,
    curvature: f64,
}

/// Which cut of the tool is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// The section through the contact across the feed, as in the paper.
    Section,
    /// What the tool sweeps as it moves along the feed.
    Swept,
    /// What it leaves at stops of this distance along the feed, mm: the feed per tooth. One stop is at the
    /// section.
    Stops(f64),
}

/// Why the model has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DongError {
    /// A radius that is none.
    #[error(
        "a tool of radius {radius_mm} mm with a corner of {corner_mm} mm; the corner lies above 0 and not above the radius"
    )]
    Tool {
        /// Total radius, mm.
        radius_mm: f64,
        /// Corner radius, mm.
        corner_mm: f64,
    },
    /// Beyond the model.
    #[error("an inclination of {0} degrees; the model holds above 0 and below 90")]
    Inclination(f64),
    /// Not a number.
    #[error("an azimuth of {azimuth_deg} degrees and a curvature of {curvature_per_mm} 1/mm: both are finite numbers")]
    Number {
        /// Azimuth, degrees.
        azimuth_deg: f64,
        /// Curvature across the feed, 1/mm.
        curvature_per_mm: f64,
    },
    /// The surface bends more than the tool.
    #[error(
        "the surface bends by {surface_per_mm:.6} 1/mm across the feed and the tool by {tool_per_mm:.6}: it gouges; \
         lean it less"
    )]
    Gouge {
        /// Curvature of the surface, 1/mm.
        surface_per_mm: f64,
        /// Curvature of the tool, 1/mm.
        tool_per_mm: f64,
    },
    /// Passes that do not meet.
    #[error("passes {pitch_mm} mm apart do not meet below the tool: step over less")]
    Apart {
        /// Distance of passes, mm.
        pitch_mm: f64,
    },
    /// A length that is none.
    #[error("{what} of {value_mm} mm is not a length")]
    Length {
        /// Name of the length.
        what: &'static str,
        /// Value, mm.
        value_mm: f64,
    },
    /// The profile.
    #[error(transparent)]
    Profile(#[from] TextureError),
}

/// Steps along a line after which it passes the tool by.
const STEPS: usize = 400;
/// A distance that is none, mm.
const TOUCH: f64 = 1e-12;
/// Narrowings of the search round the ring: the width shrinks by 0.618 each, to 1e-8 of a turn, where a
/// minimum is exact to rounding.
const NARROWINGS: usize = 44;
/// Most points of a profile.
const MOST_POINTS: f64 = 10_000_000.0;
/// The tool is as high as asked within this part: else it has ended below.
const REACHED: f64 = 1e-6;
/// Angle of an arc below which it is as good as its parabola, radian.
const PARABOLA: f64 = 1e-9;

impl Dong {
    /// A tool of total and corner radius (mm) whose axis is inclined by `inclination` (rad) to the normal at
    /// `azimuth` (rad) from the feed, on a surface of normal curvature `curvature` (1/mm, positive where it
    /// bends towards the tool) across the feed.
    ///
    /// # Errors
    /// [`DongError`] for numbers beyond the model, and where the tool gouges across the feed.
    pub fn new(radius: f64, corner: f64, inclination: f64, azimuth: f64, curvature: f64) -> Result<Self, DongError> {
        if !(corner > 0.0 && radius >= corner && radius.is_finite()) {
            return Err(DongError::Tool { radius_mm: radius, corner_mm: corner });
        }
        if !(inclination > 0.0 && inclination < std::f64::consts::FRAC_PI_2) {
            return Err(DongError::Inclination(inclination.to_degrees()));
        }
        if !(azimuth.is_finite() && curvature.is_finite()) {
            return Err(DongError::Number { azimuth_deg: azimuth.to_degrees(), curvature_per_mm: curvature });
        }
        let model = Self { radius, corner, inclination, azimuth, curvature };
        let tool = model.swept_curvature();
        if tool <= curvature {
            return Err(DongError::Gouge { surface_per_mm: curvature, tool_per_mm: tool });
        }
        Ok(model)
    }

    /// Largest and smallest curvature of the tool at the contact, 1/mm.
    pub fn tool_curvatures(&self) -> (f64, f64) {
        let sin = self.inclination.sin();
        (1.0 / self.corner, sin / ((self.radius - self.corner) + self.corner * sin))
    }

    /// Curvature of the tool's section across the feed, 1/mm (equation 5).
    pub fn section_curvature(&self) -> f64 {
        let ((a, b), (sin, cos)) = (self.tool_curvatures(), self.azimuth.sin_cos());
        a * sin * sin + b * cos * cos
    }

    /// Curvature across the feed of what the tool sweeps, 1/mm.
    pub fn swept_curvature(&self) -> f64 {
        let ((a, b), (sin, cos)) = (self.tool_curvatures(), self.azimuth.sin_cos());
        a * b / (a * cos * cos + b * sin * sin)
    }

    /// Height of the ridges between passes at a distance (mm along the surface), to second order, mm.
    pub fn ridge_height(&self, pitch: f64, cut: Cut) -> f64 {
        let tool = if cut == Cut::Section { self.section_curvature() } else { self.swept_curvature() };
        (tool - self.curvature) * pitch * pitch / 8.0
    }

    /// Ra of passes at a distance (mm), unfiltered and to second order, mm: 4 H / (9 sqrt 3).
    pub fn ra(&self, pitch: f64, cut: Cut) -> f64 {
        cusp::parabola_ra(self.ridge_height(pitch, cut))
    }

    /// Width of the strip that stays within `height` (mm) of the surface, to either side of the feed (left,
    /// right; mm), for the exact torus, heights along the normal of the contact. None where the tool ends
    /// before it is so high.
    pub fn strip_width(&self, height: f64, cut: Cut) -> Option<(f64, f64)> {
        if !(height > 0.0 && height.is_finite()) {
            return None;
        }
        // Above the point of the surface at `y`, along the normal of the contact.
        let above = |y: f64| {
            let nominal = self.nominal_over_tangent(y)?;
            Some(self.height(y, cut)? - nominal)
        };
        let side = |sign: f64| {
            let (mut low, mut high) = (0.0, 2.0 * self.radius);
            for _ in 0..80 {
                let y = 0.5 * (low + high);
                // Where the tool has ended, it is higher than anything.
                if above(sign * y).is_none_or(|z| z > height) { high = y } else { low = y }
            }
            // At its end the tool is not as high as asked.
            above(sign * low).filter(|z| (z - height).abs() < REACHED * height).map(|_| low)
        };
        // The left side lies towards +y as seen along the feed.
        Some((side(1.0)?, side(-1.0)?))
    }

    /// Height of the surface over its tangent plane at `y`, mm.
    fn nominal_over_tangent(&self, y: f64) -> Option<f64> {
        let c = self.curvature;
        let root = 1.0 - (c * y).powi(2);
        (root > 0.0).then(|| c * y * y / (1.0 + root.sqrt()))
    }

    /// Signed distance of a point (contact frame, mm) from the torus (section 6 of the specification of the
    /// model).
    fn distance(&self, p: [f64; 3]) -> f64 {
        let ((sin_l, cos_l), (sin_w, cos_w)) = (self.inclination.sin_cos(), self.azimuth.sin_cos());
        let axis = [sin_l * cos_w, sin_l * sin_w, cos_l];
        // u = (N - (N T) T) / |.|, from the axis outward through the contact's side.
        let out = [-cos_l * cos_w, -cos_l * sin_w, sin_l];
        let ring = self.radius - self.corner;
        // The center of the tool's ring: along N to the center of the corner, and from there towards the
        // axis.
        let q: [f64; 3] = [0, 1, 2].map(|k| p[k] - ring * out[k] - if k == 2 { self.corner } else { 0.0 });
        let along = q[0] * axis[0] + q[1] * axis[1] + q[2] * axis[2];
        let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
        ((square - along * along).max(0.0).sqrt() - ring).hypot(along) - self.corner
    }

    /// Where a line from below meets the tool first: distance from `from` along the unit vector `along`, mm.
    fn meet(&self, from: [f64; 3], along: [f64; 3]) -> Option<f64> {
        // Begin well below the contact plane, so that the first meeting is the lower side.
        let mut t = -2.0 * self.radius;
        for _ in 0..STEPS {
            let f = self.distance([0, 1, 2].map(|k| from[k] + t * along[k]));
            if f < TOUCH {
                return Some(t);
            }
            t += f;
            if t > 4.0 * self.radius {
                return None;
            }
        }
        None
    }

    fn height(&self, y: f64, cut: Cut) -> Option<f64> {
        self.lowest(cut, [y, 0.0], [0.0, 1.0])
    }

    /// Where the cut is met first by a line across the feed: through (y, z) = `from` along the unit vector
    /// `along`.
    fn lowest(&self, cut: Cut, from: [f64; 2], along: [f64; 2]) -> Option<f64> {
        let torus = |x: f64| self.meet([x, from[0], from[1]], [0.0, along[0], along[1]]);
        match cut {
            Cut::Section => torus(0.0),
            Cut::Swept => self.swept(from, along).map(|(t, _)| t),
            Cut::Stops(step) => {
                // The lower side is convex along the feed: one of the two stops round its lowest place is the
                // lowest.
                let (_, x) = self.swept(from, along)?;
                let below = (x / step).floor();
                [below, below + 1.0].into_iter().filter_map(|k| torus(k * step)).reduce(f64::min)
            }
        }
    }

    /// Where a line across the feed first meets what the tool sweeps, and the place of that cut along the
    /// feed.
    ///
    /// A torus is the union of balls of radius r round the points of its ring; swept along the feed, each
    /// ball leaves a cylinder. In the plane across the feed these are discs round the points of an ellipse.
    /// With P the distance of such a point from the line and L its distance along the line, the line meets
    /// the disc at t = L - sqrt(r^2 - P^2). On the lower arc of the ellipse L is a convex function of P,
    /// and so is t: a golden-section search finds its least value.
    fn swept(&self, from: [f64; 2], along: [f64; 2]) -> Option<(f64, f64)> {
        let ((sin_l, cos_l), (sin_w, cos_w)) = (self.inclination.sin_cos(), self.azimuth.sin_cos());
        let out = [-cos_l * cos_w, -cos_l * sin_w, sin_l];
        let side = [-sin_w, cos_w, 0.0];
        let ring = self.radius - self.corner;
        let center = [0, 1, 2].map(|k| ring * out[k] + if k == 2 { self.corner } else { 0.0 });
        let across = |c: [f64; 3]| c[1] * along[1] - c[2] * along[0];
        let forth = |c: [f64; 3]| c[1] * along[0] + c[2] * along[1];
        let origin = [0.0, from[0], from[1]];
        let (p0, l0) = (across(center) - across(origin), forth(center) - forth(origin));
        // The point of the ring at an angle from the contact's side: center + ring (-out cos + side sin).
        let (pa, pb) = (-ring * across(out), ring * across(side));
        let (la, lb) = (-ring * forth(out), ring * forth(side));
        let (width, turned) = (pa.hypot(pb), pb.atan2(pa));
        let at = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let p = p0 + pa * cos + pb * sin;
            let inside = self.corner * self.corner - p * p;
            if inside >= 0.0 { l0 + la * cos + lb * sin - inside.sqrt() } else { f64::INFINITY }
        };
        // Angles at which P lies within the corner radius, on either arc.
        let bound = |p: f64| if width > 0.0 { ((p - p0) / width).clamp(-1.0, 1.0).acos() } else { 0.0 };
        let (near, far) = (bound(self.corner), bound(-self.corner));
        let share = 0.5 * (5.0_f64.sqrt() - 1.0);
        let search = |sign: f64| {
            let (mut low, mut high) = (near, far);
            for _ in 0..NARROWINGS {
                let (a, b) = (high - share * (high - low), low + share * (high - low));
                if at(turned + sign * a) <= at(turned + sign * b) { high = b } else { low = a }
            }
            let angle = turned + sign * 0.5 * (low + high);
            (at(angle), angle)
        };
        let (one, other) = (search(1.0), search(-1.0));
        let (t, angle) = if one.0 <= other.0 { one } else { other };
        let (sin, cos) = angle.sin_cos();
        t.is_finite().then(|| (t, center[0] + ring * (-out[0] * cos + side[0] * sin)))
    }

    /// The profile across the feed that passes at a distance (mm along the surface) leave, over `length` (mm)
    /// at a step (mm), a pass at its middle: heights over the nominal section along the normal of its middle,
    /// mm.
    ///
    /// # Errors
    /// [`DongError`] for lengths that are none, and where passes do not meet.
    pub fn profile(&self, pitch: f64, length: f64, step: f64, cut: Cut) -> Result<Profile, DongError> {
        let stops = if let Cut::Stops(s) = cut { s } else { 1.0 };
        for (what, value_mm) in
            [("a distance of passes", pitch), ("a length", length), ("a step", step), ("a feed per tooth", stops)]
        {
            if !(value_mm.is_finite() && value_mm > 0.0) {
                return Err(DongError::Length { what, value_mm });
            }
        }
        // Beyond a quarter turn of the section, lines along the middle's normal no longer meet it.
        let count = (length / step).round();
        if !(1.0..=MOST_POINTS).contains(&count) || (self.curvature * length).abs() > 2.0 {
            return Err(DongError::Length { what: "a length that the section carries, in steps,", value_mm: length });
        }
        let heights = (0..=count as usize)
            .map(|i| {
                let s = i as f64 * step - 0.5 * count * step;
                let below = (s / pitch).floor();
                [below, below + 1.0]
                    .into_iter()
                    .filter_map(|m| self.over_nominal(s, m * pitch, cut))
                    .reduce(f64::min)
                    .ok_or(DongError::Apart { pitch_mm: pitch })
            })
            .collect::<Result<Vec<f64>, _>>()?;
        Ok(Profile::new(step, heights)?)
    }

    /// Distance from the nominal point at arc length `s` along the normal of the middle to the cut of the
    /// pass at arc length `pass`.
    fn over_nominal(&self, s: f64, pass: f64, cut: Cut) -> Option<f64> {
        let c = self.curvature;
        // Point of a circle of curvature c at an arc length: sin(c s) / c, (1 - cos(c s)) / c.
        let point = |s: f64| {
            let angle = c * s;
            if angle.abs() < PARABOLA {
                [s, 0.5 * c * s * s]
            } else {
                [angle.sin() / c, 2.0 * (0.5 * angle).sin().powi(2) / c]
            }
        };
        let ([y, z], [py, pz]) = (point(s), point(pass));
        // Into the frame of the pass, which is turned by its angle about the feed.
        let (sin, cos) = (c * pass).sin_cos();
        let turn = |y: f64, z: f64| [cos * y + sin * z, -sin * y + cos * z];
        let ([y, z], [vy, vz]) = (turn(y - py, z - pz), turn(0.0, 1.0));
        self.lowest(cut, [y, z], [vy, vz])
    }
}
