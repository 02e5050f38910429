use thiserror::Error;

/// Two profile points closer than this (mm) are one: far below any tolerance of the trade, far above
/// rounding.
pub(crate) const JOIN_MM: f64 = 1e-9;
/// Allowed turn to the wrong side at a joint of two segments (radian) before the profile counts as concave.
pub(crate) const CONVEX_RAD: f64 = 1e-7;
/// How far the ends of an arc may be off its circle, mm: coordinates of a text are rounded.
pub(crate) const ON_CIRCLE_MM: f64 = 1e-6;
/// Chord error over radius that a picture is not finer than.
const FINEST_CHORD: f64 = 1e-6;

/// One piece of a generating curve; points are `[r, z]`, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// Straight: a cone, cylinder or plane face of the body.
    Line {
        /// Start.
        from: [f64; 2],
        /// End.
        to: [f64; 2],
    },
    /// Circular, counter-clockwise (convex outward): a part of a torus or sphere.
    Arc {
        /// Center `[r, z]`; r may be negative (barrels).
        center: [f64; 2],
        /// Radius of the arc.
        radius: f64,
        /// Start.
        from: [f64; 2],
        /// End.
        to: [f64; 2],
    },
}

impl Segment {
    /// Start point `[r, z]`.
    pub fn from(&self) -> [f64; 2] {
        match self {
            Self::Line { from, .. } | Self::Arc { from, .. } => *from,
        }
    }

    /// End point `[r, z]`.
    pub fn to(&self) -> [f64; 2] {
        match self {
            Self::Line { to, .. } | Self::Arc { to, .. } => *to,
        }
    }

    /// Unit tangent `[r, z]` at a point of the segment, in the sense of travel.
    pub(crate) fn tangent(&self, at: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Line { from, to } => unit([to[0] - from[0], to[1] - from[1]]),
            Self::Arc { center, .. } => unit([-(at[1] - center[1]), at[0] - center[0]]),
        }
    }

    /// The point of the segment nearest to `p`.
    fn nearest(&self, p: [f64; 2]) -> [f64; 2] {
        match *self {
            Self::Line { from, to } => {
                let d = [to[0] - from[0], to[1] - from[1]];
                let length2 = d[0] * d[0] + d[1] * d[1];
                let t = if length2 > 0.0 { ((p[0] - from[0]) * d[0] + (p[1] - from[1]) * d[1]) / length2 } else { 0.0 };
                let t = t.clamp(0.0, 1.0);
                [from[0] + t * d[0], from[1] + t * d[1]]
            }
            Self::Arc { center, radius, from, to } => {
                let start = (from[1] - center[1]).atan2(from[0] - center[0]);
                let sweep = ((to[1] - center[1]).atan2(to[0] - center[0]) - start).rem_euclid(std::f64::consts::TAU);
                let angle = ((p[1] - center[1]).atan2(p[0] - center[0]) - start).rem_euclid(std::f64::consts::TAU);
                if angle <= sweep {
                    let u = unit([p[0] - center[0], p[1] - center[1]]);
                    [center[0] + radius * u[0], center[1] + radius * u[1]]
                } else if distance(p, from) < distance(p, to) {
                    from
                } else {
                    to
                }
            }
        }
    }
}

/// A point of the skin in the half plane (r, z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinPoint {
    /// The point `[r, z]`, mm.
    pub point: [f64; 2],
    /// Outward unit normal of its segment, `[r, z]`; at a corner that of the first of the two segments.
    pub normal: [f64; 2],
    /// Curvature of the segment in the half plane, 1/mm: 0 on a line. Round the axis the curvature of the
    /// body is `normal[0] / point[0]`.
    pub curvature: f64,
    /// Index of the segment.
    pub segment: usize,
}

fn unit(v: [f64; 2]) -> [f64; 2] {
    let n = v[0].hypot(v[1]);
    if n > 0.0 { [v[0] / n, v[1] / n] } else { [1.0, 0.0] }
}

pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Why a curve does not generate a convex body of revolution.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ProfileError {
    /// No segment, or a number that is not finite.
    #[error("the profile is empty or has a number that is not finite")]
    NotFinite,
    /// The curve must begin and end on the axis.
    #[error("the profile must begin and end on the axis (r = 0), but reaches r = {r_mm} mm")]
    OffAxis {
        /// Distance from the axis, mm.
        r_mm: f64,
    },
    /// A segment does not begin where the one before ended.
    #[error("segment {segment} begins {gap_mm} mm away from the end of the one before")]
    Gap {
        /// Index of the segment.
        segment: usize,
        /// Distance, mm.
        gap_mm: f64,
    },
    /// Radius below zero, an arc whose ends are not on its circle, or a segment of no length.
    #[error("segment {segment} is degenerate: {reason}")]
    Degenerate {
        /// Index of the segment.
        segment: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// The body would not be convex.
    #[error("the profile turns inward by {turn_rad} rad before segment {segment}: split the body there")]
    Concave {
        /// Index of the segment.
        segment: usize,
        /// Turn to the wrong side, radian.
        turn_rad: f64,
    },
}

/// Generating curve of a convex body of revolution, from the lowest axis point outward and up to the highest
/// axis point (counter-clockwise in the half plane r >= 0).
///
/// ```
/// use proveout_tool::{Profile, Segment};
///
/// // A pin of radius 3 mm and height 8 mm.
/// let line = |from, to| Segment::Line { from, to };
/// let pin = Profile::new(vec![
///     line([0.0, 0.0], [3.0, 0.0]),
///     line([3.0, 0.0], [3.0, 8.0]),
///     line([3.0, 8.0], [0.0, 8.0]),
/// ])?;
/// assert!((pin.volume() - 72.0 * std::f64::consts::PI).abs() < 1e-9); // mm3
/// assert!((pin.signed_distance([6.0, 12.0]) - 5.0).abs() < 1e-12); // to the rim: 3, 4, 5
/// assert!((pin.signed_distance([2.0, 4.0]) + 1.0).abs() < 1e-12); // inside, mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    segments: Vec<Segment>,
    max_radius: f64,
    z_min: f64,
    z_max: f64,
}

impl Profile {
    /// Radius of the ball where the profile begins with a whole quarter circle about a point of the axis, mm;
    /// none for every other shape.
    pub fn ball_radius(&self) -> Option<f64> {
        match self.segments.first()? {
            Segment::Arc { center, radius, from, to } => {
                let half = center[0].abs() < JOIN_MM && from[0].abs() < JOIN_MM && (to[0] - radius).abs() < JOIN_MM;
                half.then_some(*radius)
            }
            Segment::Line { .. } => None,
        }
    }

    /// Checks and takes a curve.
    ///
    /// # Errors
    /// [`ProfileError`] names the first segment that does not fit.
    pub fn new(segments: Vec<Segment>) -> Result<Self, ProfileError> {
        let (Some(first), Some(last)) = (segments.first(), segments.last()) else {
            return Err(ProfileError::NotFinite);
        };
        for end in [first.from(), last.to()] {
            if !end.iter().all(|v| v.is_finite()) {
                return Err(ProfileError::NotFinite);
            }
            if end[0].abs() > JOIN_MM {
                return Err(ProfileError::OffAxis { r_mm: end[0] });
            }
        }
        let mut heading = [1.0, 0.0]; // a plane bottom is the flattest start
        for (segment, s) in segments.iter().enumerate() {
            let (from, to) = (s.from(), s.to());
            if ![from[0], from[1], to[0], to[1]].iter().all(|v| v.is_finite()) {
                return Err(ProfileError::NotFinite);
            }
            if segment > 0 && distance(segments[segment - 1].to(), from) > JOIN_MM {
                return Err(ProfileError::Gap { segment, gap_mm: distance(segments[segment - 1].to(), from) });
            }
            let degenerate = |reason| ProfileError::Degenerate { segment, reason };
            if distance(from, to) <= JOIN_MM {
                return Err(degenerate("it has no length"));
            }
            if from[0] < -JOIN_MM || to[0] < -JOIN_MM {
                return Err(degenerate("r is below zero"));
            }
            if let Segment::Arc { center, radius, .. } = *s {
                let off = [from, to].map(|p| (distance(p, center) - radius).abs());
                if !(radius > 0.0 && off[0] < ON_CIRCLE_MM && off[1] < ON_CIRCLE_MM) {
                    return Err(degenerate("the ends of the arc are not on its circle"));
                }
            }
            let start = s.tangent(from);
            let turn =
                (heading[0] * start[1] - heading[1] * start[0]).atan2(heading[0] * start[0] + heading[1] * start[1]);
            if turn < -CONVEX_RAD {
                return Err(ProfileError::Concave { segment, turn_rad: -turn });
            }
            heading = s.tangent(to);
        }
        if heading[0] > CONVEX_RAD {
            return Err(ProfileError::Degenerate { segment: segments.len() - 1, reason: "it ends outward" });
        }
        let mut profile = Self { max_radius: 0.0, z_min: first.from()[1], z_max: last.to()[1], segments };
        profile.max_radius = profile.segments.iter().map(largest_radius).fold(0.0, f64::max);
        Ok(profile)
    }

    /// The pieces, from the lowest to the highest axis point.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Largest distance from the axis, mm.
    pub fn max_radius(&self) -> f64 {
        self.max_radius
    }

    /// Height of the lowest point, mm.
    pub fn z_min(&self) -> f64 {
        self.z_min
    }

    /// Height of the highest point, mm.
    pub fn z_max(&self) -> f64 {
        self.z_max
    }

    /// Signed distance of `[r, z]` (r >= 0) from the body's skin, mm; negative inside.
    pub fn signed_distance(&self, p: [f64; 2]) -> f64 {
        let mut best = f64::INFINITY;
        let mut outside = false;
        for s in &self.segments {
            let q = s.nearest(p);
            best = best.min(distance(p, q));
            // Convex body: outside exactly when outside of one supporting line or arc.
            outside |= match *s {
                Segment::Line { from, to } => {
                    (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]) < 0.0
                }
                Segment::Arc { .. } => {
                    let t = s.tangent(q);
                    t[0] * (p[1] - q[1]) - t[1] * (p[0] - q[0]) < 0.0
                }
            };
        }
        outside |= p[1] < self.z_min || p[1] > self.z_max;
        if outside { best } else { -best }
    }

    /// The point of the skin nearest to `[r, z]` (r >= 0), mm, with normal and curvature there; exact for
    /// lines and arcs.
    pub fn nearest(&self, p: [f64; 2]) -> SkinPoint {
        let mut best = SkinPoint { point: self.segments[0].from(), normal: [0.0, -1.0], curvature: 0.0, segment: 0 };
        let mut least = f64::INFINITY;
        for (segment, s) in self.segments.iter().enumerate() {
            let point = s.nearest(p);
            let off = distance(p, point);
            if off < least {
                least = off;
                let t = s.tangent(point);
                let curvature = match *s {
                    Segment::Line { .. } => 0.0,
                    Segment::Arc { radius, .. } => 1.0 / radius,
                };
                best = SkinPoint { point, normal: [t[1], -t[0]], curvature, segment };
            }
        }
        best
    }

    /// Radius of the body at height `z`, mm; none outside of its height.
    ///
    /// ```
    /// use proveout_tool::Cutter;
    ///
    /// let bull_nose = Cutter::bull_nose(12.0, 2.0)?.bodies(10.0)?.remove(0); // mm
    /// assert_eq!(bull_nose.radius_at(0.0), Some(4.0)); // the flat bottom
    /// assert_eq!(bull_nose.radius_at(2.0), Some(6.0)); // the end of the corner
    /// assert_eq!(bull_nose.radius_at(10.5), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn radius_at(&self, z: f64) -> Option<f64> {
        let reach = self.segments.iter().filter_map(|s| {
            let (from, to) = (s.from(), s.to());
            match *s {
                Segment::Line { .. } if from[1] == to[1] => (z == from[1]).then(|| from[0].max(to[0])),
                Segment::Line { .. } => {
                    let t = (z - from[1]) / (to[1] - from[1]);
                    (0.0..=1.0).contains(&t).then(|| from[0] + t * (to[0] - from[0]))
                }
                Segment::Arc { center, radius, .. } => {
                    let h = z - center[1];
                    let (low, high) = (from[1].min(to[1]), from[1].max(to[1]));
                    (low..=high).contains(&z).then(|| center[0] + (radius * radius - h * h).max(0.0).sqrt())
                }
            }
        });
        reach.reduce(f64::max)
    }

    /// Volume of the body, mm³: the integral of pi r² over z, in closed form for each segment.
    pub fn volume(&self) -> f64 {
        let slices: f64 = self.segments.iter().map(slice_integral).sum();
        std::f64::consts::PI * slices
    }

    /// The curve at distance `distance` (mm, zero or more) outside of this one: the body and everything
    /// nearer to it than that. Straight pieces move outward, arcs get the larger radius, corners become arcs
    /// round themselves.
    ///
    /// ```text
    ///      ____      d: distance
    ///     /    \  <- arc round the corner
    ///    |  __  |
    ///    | |  | |
    /// ```
    ///
    /// # Errors
    /// [`ProfileError`] for a distance that is negative or not finite.
    pub fn widened(&self, distance: f64) -> Result<Self, ProfileError> {
        if !(distance >= 0.0 && distance.is_finite()) {
            return Err(ProfileError::NotFinite);
        }
        if distance <= JOIN_MM {
            return Ok(self.clone());
        }
        let outward = |t: [f64; 2]| [t[1], -t[0]];
        let moved = |p: [f64; 2], n: [f64; 2]| [(p[0] + distance * n[0]).max(0.0), p[1] + distance * n[1]];
        let corner = |at: [f64; 2], before: [f64; 2], after: [f64; 2]| {
            let (from, to) = (moved(at, before), moved(at, after));
            let apart = (from[0] - to[0]).hypot(from[1] - to[1]) > JOIN_MM;
            apart.then_some(Segment::Arc { center: at, radius: distance, from, to })
        };
        let mut segments: Vec<Segment> = Vec::with_capacity(2 * self.segments.len() + 1);
        let mut normal = [0.0, -1.0]; // below the lowest axis point
        for s in &self.segments {
            let [start, end] = [s.from(), s.to()].map(|p| outward(s.tangent(p)));
            segments.extend(corner(s.from(), normal, start));
            let from = segments.last().map_or(moved(s.from(), start), Segment::to);
            let to = moved(s.to(), end);
            segments.push(match *s {
                Segment::Line { .. } => Segment::Line { from, to },
                Segment::Arc { center, radius, .. } => Segment::Arc { center, radius: radius + distance, from, to },
            });
            normal = end;
        }
        segments.extend(corner([0.0, self.z_max], normal, [0.0, 1.0]));
        Self::new(segments)
    }

    /// Points `[r, z]` of the curve with chords nearer than `tolerance` (mm), from axis to axis; for
    /// pictures.
    pub fn polyline(&self, tolerance: f64) -> Vec<[f64; 2]> {
        let mut points = vec![self.segments[0].from()];
        for s in &self.segments {
            if let Segment::Arc { center, radius, from, to } = *s {
                let start = (from[1] - center[1]).atan2(from[0] - center[0]);
                let sweep = ((to[1] - center[1]).atan2(to[0] - center[0]) - start).rem_euclid(std::f64::consts::TAU);
                let step = 2.0 * (1.0 - (tolerance / radius).clamp(FINEST_CHORD, 1.0)).acos();
                let n = (sweep / step).ceil().max(1.0) as usize;
                points.extend((1..n).map(|k| {
                    let a = start + sweep * k as f64 / n as f64;
                    [(center[0] + radius * a.cos()).max(0.0), center[1] + radius * a.sin()]
                }));
            }
            points.push(s.to());
        }
        points
    }
}

/// Integral of r² dz along a segment, mm³.
///
/// On an arc r = c + R cos(a) and dz = R cos(a) da, so that the integrand is
/// R (c² cos(a) + 2 c R cos²(a) + R² cos³(a)), whose three terms have elementary integrals.
fn slice_integral(s: &Segment) -> f64 {
    match *s {
        Segment::Line { from, to } => (to[1] - from[1]) * (from[0] * from[0] + from[0] * to[0] + to[0] * to[0]) / 3.0,
        Segment::Arc { center, radius, from, to } => {
            let start = (from[1] - center[1]).atan2(from[0] - center[0]);
            let sweep = ((to[1] - center[1]).atan2(to[0] - center[0]) - start).rem_euclid(std::f64::consts::TAU);
            let primitive = |a: f64| {
                let (sine, cosine) = a.sin_cos();
                radius
                    * (center[0] * center[0] * sine
                        + center[0] * radius * (a + sine * cosine)
                        + radius * radius * (sine - sine.powi(3) / 3.0))
            };
            primitive(start + sweep) - primitive(start)
        }
    }
}

fn largest_radius(s: &Segment) -> f64 {
    let ends = s.from()[0].max(s.to()[0]);
    match *s {
        Segment::Arc { center, radius, from, to } if from[1] <= center[1] && center[1] <= to[1] => {
            ends.max(center[0] + radius)
        }
        _ => ends,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball_end(radius: f64, length: f64) -> Profile {
        Profile::new(vec![
            Segment::Arc { center: [0.0, radius], radius, from: [0.0, 0.0], to: [radius, radius] },
            Segment::Line { from: [radius, radius], to: [radius, length] },
            Segment::Line { from: [radius, length], to: [0.0, length] },
        ])
        .expect("a ball end is convex")
    }

    #[test]
    fn distance_of_a_ball_end() {
        let p = ball_end(4.0, 20.0);
        assert!((p.signed_distance([0.0, -3.0]) - 3.0).abs() < 1e-12);
        assert!((p.signed_distance([0.0, 4.0]) + 4.0).abs() < 1e-12);
        assert!((p.signed_distance([7.0, 10.0]) - 3.0).abs() < 1e-12);
        assert!((p.signed_distance([3.5, 10.0]) + 0.5).abs() < 1e-12);
        assert!((p.signed_distance([4.0, 0.0]) - (4.0 * 2_f64.sqrt() - 4.0)).abs() < 1e-12);
        assert_eq!(p.max_radius(), 4.0);
        assert!((p.radius_at(2.0).expect("inside") - 12_f64.sqrt()).abs() < 1e-12);
        assert_eq!(p.radius_at(20.5), None);
    }

    #[test]
    fn a_widened_body_is_everything_nearer_than_the_distance() {
        let line = |from, to| Segment::Line { from, to };
        let cone = vec![line([0.0, -1.0], [3.0, 2.0]), line([3.0, 2.0], [2.0, 9.0]), line([2.0, 9.0], [0.0, 9.0])];
        for profile in [ball_end(4.0, 20.0), Profile::new(cone).expect("a cone is convex")] {
            let wide = profile.widened(1.5).expect("wider");
            for i in 0..4000 {
                let p = [f64::from(i % 63) * 0.13, f64::from(i / 63) * 0.45 - 4.0];
                let outside = profile.signed_distance(p);
                // Outside, the distance to the wide body is smaller by exactly 1.5; inside, only the sign
                // is defined.
                if outside > 1.5 {
                    assert!((wide.signed_distance(p) - (outside - 1.5)).abs() < 1e-9, "{p:?}");
                } else if (outside - 1.5).abs() > 1e-9 {
                    assert!(wide.signed_distance(p) < 0.0, "{p:?} {outside}");
                }
            }
        }
        assert_eq!(ball_end(4.0, 20.0).widened(0.0), Ok(ball_end(4.0, 20.0)));
        assert!(ball_end(4.0, 20.0).widened(-1.0).is_err());
    }

    #[test]
    fn curves_that_are_not_convex_bodies_are_refused() {
        let line = |from, to| Segment::Line { from, to };
        assert_eq!(Profile::new(vec![]), Err(ProfileError::NotFinite));
        let open = vec![line([1.0, 0.0], [1.0, 5.0]), line([1.0, 5.0], [0.0, 5.0])];
        assert!(matches!(Profile::new(open), Err(ProfileError::OffAxis { .. })));
        let gap = vec![line([0.0, 0.0], [1.0, 0.0]), line([1.0, 1.0], [0.0, 5.0])];
        assert!(matches!(Profile::new(gap), Err(ProfileError::Gap { segment: 1, .. })));
        let waist = vec![
            line([0.0, 0.0], [3.0, 0.0]),
            line([3.0, 0.0], [2.0, 3.0]),
            line([2.0, 3.0], [3.0, 6.0]),
            line([3.0, 6.0], [0.0, 6.0]),
        ];
        assert!(matches!(Profile::new(waist), Err(ProfileError::Concave { segment: 2, .. })));
    }
}
