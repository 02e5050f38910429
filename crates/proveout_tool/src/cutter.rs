//! Cutters by their catalogue dimensions.

use proveout_geom::sin_cos;
use thiserror::Error;

use crate::outline::ToolOutline;
use crate::profile::JOIN_MM;
use crate::{Profile, ProfileError, Segment};

/// Largest dimension of a tool, mm: above it a value is a slip of the unit.
pub(crate) const LARGEST_MM: f64 = 10_000.0;
/// Part of the radius of a circle, of a millimeter at least, within which a line touches it: rounding.
const TANGENT: f64 = 1e-9;

/// Why dimensions do not make a tool.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShapeError {
    /// One dimension is outside of what the others allow.
    #[error("{key} = {value} {limit}")]
    Dimension {
        /// Key of the library file.
        key: &'static str,
        /// Value given.
        value: f64,
        /// What it must be.
        limit: String,
    },
    /// The curve is not one of a convex body.
    #[error(transparent)]
    Profile(#[from] ProfileError),
}

pub(crate) fn refuse<T>(key: &'static str, value: f64, limit: impl Into<String>) -> Result<T, ShapeError> {
    Err(ShapeError::Dimension { key, value, limit: limit.into() })
}

/// Refuses a length that is not finite, not above zero, or absurd.
pub(crate) fn length(key: &'static str, value: f64) -> Result<f64, ShapeError> {
    if value > 0.0 && value <= LARGEST_MM {
        return Ok(value);
    }
    refuse(key, value, format!("must be above 0 and at most {LARGEST_MM} mm"))
}

/// Refuses a value outside of a closed range.
pub(crate) fn within(key: &'static str, value: f64, low: f64, high: f64) -> Result<f64, ShapeError> {
    if value >= low && value <= high { Ok(value) } else { refuse(key, value, format!("must be {low} to {high}")) }
}

/// The seven parameters of the APT cutter statement (ISO 4343 CLDATA, `CUTTER`).
///
/// ```text
///        |        / beta        upper line through (D/2, D/2 tan alpha), beta from axis, outward positive
///        |       |
///    F _ |_ _ _ ( )  R          corner circle about (E, F)
///        |   _.-'
///        |_-'  alpha            lower line through the tip, alpha from the plane across the axis
///        +----E--D/2--> r
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apt {
    /// D: twice the radius where the lower and the upper line meet, mm.
    pub diameter: f64,
    /// R: radius of the corner circle, mm; zero for a sharp corner.
    pub corner_radius: f64,
    /// E: distance of the center of the corner circle from the axis, mm; negative for a barrel.
    pub center_radius: f64,
    /// F: height of that center above the tip, mm.
    pub center_height: f64,
    /// Alpha: rise of the lower line, degree, 0 to below 90.
    pub lower_angle_deg: f64,
    /// Beta: inclination of the upper line to the axis, degree, above -90 to below 90; positive opens upward.
    pub upper_angle_deg: f64,
    /// H: height of the cutter, mm.
    pub height: f64,
}

/// The cutting end of a tool: its outline from the tip upward.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutter {
    outline: ToolOutline,
    /// The outline goes on as a cylinder above its end.
    continues: bool,
}

impl Cutter {
    /// Ball end mill.
    ///
    /// ```
    /// use proveout_tool::Cutter;
    ///
    /// // Flutes of 20 mm: half a ball of radius 5 mm, and a cylinder of 15 mm above it.
    /// let bodies = Cutter::ball(10.0)?.bodies(20.0)?;
    /// let volume = std::f64::consts::PI * (2.0 / 3.0 * 125.0 + 25.0 * 15.0); // mm3
    /// assert_eq!(bodies.len(), 1);
    /// assert!((bodies[0].volume() - volume).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A diameter that is not above zero.
    pub fn ball(diameter: f64) -> Result<Self, ShapeError> {
        let r = 0.5 * length("diameter_mm", diameter)?;
        Ok(Self::continuing(ToolOutline::start(0.0).arc([0.0, r], [r, r])))
    }

    /// Ball of a stylus, up to where its stem comes out of it.
    ///
    /// # Errors
    /// A diameter that is not above zero, or a stem that is as thick as the ball.
    pub fn stylus(diameter: f64, stem_diameter: f64) -> Result<Self, ShapeError> {
        let r = 0.5 * length("diameter_mm", diameter)?;
        let stem = 0.5 * length("neck_diameter_mm", stem_diameter)?;
        if stem >= r - JOIN_MM {
            let limit = format!("must be below {diameter} mm, the diameter of the ball");
            return refuse("neck_diameter_mm", stem_diameter, limit);
        }
        let outline = ToolOutline::start(0.0).arc([0.0, r], [stem, r + (r * r - stem * stem).sqrt()]);
        Ok(Self { outline, continues: false })
    }

    /// Flat end mill with a sharp corner.
    ///
    /// # Errors
    /// A diameter that is not above zero.
    pub fn flat(diameter: f64) -> Result<Self, ShapeError> {
        let r = 0.5 * length("diameter_mm", diameter)?;
        Ok(Self::continuing(ToolOutline::start(0.0).line([r, 0.0])))
    }

    /// End mill with a corner radius below half of its diameter.
    ///
    /// # Errors
    /// A dimension outside of its range.
    pub fn bull_nose(diameter: f64, corner_radius: f64) -> Result<Self, ShapeError> {
        let r = 0.5 * length("diameter_mm", diameter)?;
        if !(corner_radius > 0.0 && corner_radius < r) {
            return refuse(
                "corner_radius_mm",
                corner_radius,
                format!("must be above 0 and below half of the diameter ({r} mm)"),
            );
        }
        let center = [r - corner_radius, corner_radius];
        let outline = ToolOutline::start(0.0).line([center[0], 0.0]).arc(center, [r, corner_radius]);
        Ok(Self::continuing(outline))
    }

    /// Ball of `tip_diameter`, tangent cone of `half_angle_deg` to the axis, then a cylinder of `diameter`.
    ///
    /// # Errors
    /// A dimension outside of its range.
    pub fn taper_ball(tip_diameter: f64, half_angle_deg: f64, diameter: f64) -> Result<Self, ShapeError> {
        let tip = 0.5 * length("tip_diameter_mm", tip_diameter)?;
        let largest = 0.5 * length("diameter_mm", diameter)?;
        let (s, c) = sin_cos(proveout_geom::rad(half_angle(half_angle_deg)?));
        let tangent = [tip * c, tip * (1.0 - s)];
        if largest <= tangent[0] + JOIN_MM {
            return refuse(
                "diameter_mm",
                diameter,
                format!("must be above {}, where the cone leaves the ball", 2.0 * tangent[0]),
            );
        }
        let top = [largest, tangent[1] + (largest - tangent[0]) * c / s];
        Ok(Self::continuing(ToolOutline::start(0.0).arc([0.0, tip], tangent).line(top)))
    }

    /// Barrel: a ball of `tip_radius`, then a tangent arc of `side_radius` that is widest (`diameter`) at its
    /// equator and goes on to `flute_length`.
    ///
    /// The arcs touch from inside, so the distance of their centers (0, r) and (D/2 - R, z) is R - r.
    ///
    /// # Errors
    /// A dimension outside of its range, or an arc that has come to the axis below the flute length.
    pub fn barrel(diameter: f64, tip_radius: f64, side_radius: f64, flute_length: f64) -> Result<Self, ShapeError> {
        let widest = 0.5 * length("diameter_mm", diameter)?;
        let tip = length("tip_radius_mm", tip_radius)?;
        let side = length("side_radius_mm", side_radius)?;
        let top = length("flute_length_mm", flute_length)?;
        if tip >= widest {
            return refuse("tip_radius_mm", tip, format!("must be below half of the diameter ({widest} mm)"));
        }
        if side <= widest {
            return refuse("side_radius_mm", side, format!("must be above half of the diameter ({widest} mm)"));
        }
        let back = side - widest;
        let equator = tip + ((side - tip).powi(2) - back * back).sqrt();
        let tangent = [tip * back / (side - tip), tip + tip * (tip - equator) / (side - tip)];
        if top <= tangent[1] + JOIN_MM {
            return refuse("flute_length_mm", top, format!("must be above {} mm, where the side begins", tangent[1]));
        }
        let up = top - equator;
        let r_top = if up.abs() < side { (side * side - up * up).sqrt() - back } else { 0.0 };
        if r_top <= 0.0 {
            return refuse("flute_length_mm", top, "is above the height at which the barrel reaches the axis");
        }
        let outline = ToolOutline::start(0.0).arc([0.0, tip], tangent).arc([-back, equator], [r_top, top]);
        Ok(Self { outline, continues: false })
    }

    /// Oval (tangential barrel): a ball of `tip_radius`, then a tangent arc of `side_radius` up to its
    /// equator, where it runs into a cylinder of `diameter`.
    ///
    /// ```text
    ///      |  |   cylinder, tangent at the equator
    ///      |  |
    ///      | /    side arc: center (D/2 - R, equator)
    ///      |/
    ///      '      ball: center (0, r)
    /// ```
    ///
    /// # Errors
    /// A dimension outside of its range.
    pub fn oval(diameter: f64, tip_radius: f64, side_radius: f64) -> Result<Self, ShapeError> {
        let widest = 0.5 * length("diameter_mm", diameter)?;
        let tip = length("tip_radius_mm", tip_radius)?;
        let side = length("side_radius_mm", side_radius)?;
        if tip >= widest {
            return refuse("tip_radius_mm", tip, format!("must be below half of the diameter ({widest} mm)"));
        }
        if side <= widest {
            return refuse("side_radius_mm", side, format!("must be above half of the diameter ({widest} mm)"));
        }
        let back = side - widest;
        let equator = tip + ((side - tip).powi(2) - back * back).sqrt();
        let tangent = [tip * back / (side - tip), tip + tip * (tip - equator) / (side - tip)];
        Ok(Self::continuing(ToolOutline::start(0.0).arc([0.0, tip], tangent).arc([-back, equator], [widest, equator])))
    }

    /// Drum wheel: a disk of `diameter` and height `flute_length` with a rim of `side_radius`, widest at
    /// mid-height, that runs into plane faces through corners of `corner_radius` (0: sharp).
    ///
    /// ```text
    ///      |____
    ///      |    )   corner radius
    ///      |     |  rim: center (D/2 - R, H/2)
    ///      |____)
    /// ```
    ///
    /// # Errors
    /// A dimension outside of its range, or a rim that has come to the axis at the faces.
    pub fn drum_wheel(
        diameter: f64,
        side_radius: f64,
        corner_radius: f64,
        flute_length: f64,
    ) -> Result<Self, ShapeError> {
        let widest = 0.5 * length("diameter_mm", diameter)?;
        let side = length("side_radius_mm", side_radius)?;
        let height = length("flute_length_mm", flute_length)?;
        let half = 0.5 * height;
        if side < half {
            return refuse("side_radius_mm", side, format!("must be at least half of the flute length ({half} mm)"));
        }
        if !(0.0..half).contains(&corner_radius) {
            let limit = format!("must be 0 or more and below half of the flute length ({half} mm)");
            return refuse("corner_radius_mm", corner_radius, limit);
        }
        let back = side - widest;
        // The corner touches the rim from inside: its center is R - r from the center of the rim, and r above
        // the face.
        let center_r = ((side - corner_radius).powi(2) - (half - corner_radius).powi(2)).max(0.0).sqrt() - back;
        if center_r <= JOIN_MM {
            return refuse("flute_length_mm", height, "is above the height at which the rim reaches the axis");
        }
        let scale = side / (side - corner_radius);
        let low = [(center_r + back) * scale - back, half - (half - corner_radius) * scale];
        let high = [low[0], height - low[1]];
        let outline = ToolOutline::start(0.0)
            .line([center_r, 0.0])
            .arc([center_r, corner_radius], low)
            .arc([-back, half], high)
            .arc([center_r, height - corner_radius], [center_r, height]);
        Ok(Self { outline, continues: false })
    }

    /// Lens: a flat arc of `lens_radius` over the tip, a tangent corner of `corner_radius` (zero: sharp),
    /// then a cylinder of `diameter`.
    ///
    /// # Errors
    /// A dimension outside of its range.
    pub fn lens(diameter: f64, lens_radius: f64, corner_radius: f64) -> Result<Self, ShapeError> {
        let r = 0.5 * length("diameter_mm", diameter)?;
        let big = length("lens_radius_mm", lens_radius)?;
        if big <= r {
            return refuse("lens_radius_mm", big, format!("must be above half of the diameter ({r} mm)"));
        }
        if !(0.0..r).contains(&corner_radius) {
            return refuse(
                "corner_radius_mm",
                corner_radius,
                format!("must be 0 or more and below half of the diameter ({r} mm)"),
            );
        }
        let center_r = r - corner_radius;
        let center = [center_r, big - ((big - corner_radius).powi(2) - center_r * center_r).sqrt()];
        let scale = big / (big - corner_radius);
        let tangent = [center[0] * scale, big + (center[1] - big) * scale];
        let outline = ToolOutline::start(0.0).arc([0.0, big], tangent).arc(center, [r, center[1]]);
        Ok(Self::continuing(outline))
    }

    /// Drill: a cone of `point_angle_deg` (full angle), then a cylinder.
    ///
    /// # Errors
    /// A dimension outside of its range.
    pub fn drill(diameter: f64, point_angle_deg: f64) -> Result<Self, ShapeError> {
        Self::chamfer(diameter, point_angle_deg, 0.0)
    }

    /// Chamfer cutter: a flat tip of `tip_diameter` (zero: a point), a cone of `point_angle_deg` (full angle)
    /// to `diameter`, then a cylinder.
    ///
    /// # Errors
    /// A dimension outside of its range.
    pub fn chamfer(diameter: f64, point_angle_deg: f64, tip_diameter: f64) -> Result<Self, ShapeError> {
        let r = 0.5 * length("diameter_mm", diameter)?;
        if !(point_angle_deg > 0.0 && point_angle_deg < 180.0) {
            return refuse("point_angle_deg", point_angle_deg, "must be above 0 and below 180");
        }
        if !(tip_diameter >= 0.0 && tip_diameter < diameter) {
            let limit = format!("must be 0 or more and below the diameter ({diameter} mm)");
            return refuse("tip_diameter_mm", tip_diameter, limit);
        }
        let tip = 0.5 * tip_diameter;
        let (s, c) = sin_cos(proveout_geom::rad(point_angle_deg));
        // Cotangent of the half angle; exactly 1 at 90 degrees.
        let slope = (1.0 + c) / s;
        let outline = ToolOutline::start(0.0).line([tip, 0.0]).line([r, (r - tip) * slope]);
        Ok(Self::continuing(outline))
    }

    /// Face mill with inserts: `diameter` where the face and the side of the inserts meet, corner radius
    /// (zero: sharp), side at `entering_angle_deg` to the face (90: a shoulder mill), up to the depth of the
    /// inserts.
    ///
    /// # Errors
    /// A dimension outside of its range.
    pub fn face_mill(
        diameter: f64,
        corner_radius: f64,
        entering_angle_deg: f64,
        flute_length: f64,
    ) -> Result<Self, ShapeError> {
        length("diameter_mm", diameter)?;
        if !(entering_angle_deg > 0.0 && entering_angle_deg <= 90.0) {
            return refuse("entering_angle_deg", entering_angle_deg, "must be above 0 and at most 90");
        }
        let (s, c) = sin_cos(proveout_geom::rad(entering_angle_deg));
        Self::apt(&Apt {
            diameter,
            corner_radius,
            center_radius: 0.5 * diameter - corner_radius * s / (1.0 + c),
            center_height: corner_radius,
            lower_angle_deg: 0.0,
            upper_angle_deg: 90.0 - entering_angle_deg,
            height: flute_length,
        })
    }

    /// The general APT cutter. Where the lines are not tangent to the corner circle, the corner is the part
    /// of the circle between its intersections with the lines.
    ///
    /// # Errors
    /// A parameter outside of its range, a circle that does not reach a line, or a curve that is not convex.
    pub fn apt(a: &Apt) -> Result<Self, ShapeError> {
        let r = 0.5 * length("diameter_mm", a.diameter)?;
        let height = length("cutter_height_mm", a.height)?;
        within("corner_radius_mm", a.corner_radius, 0.0, LARGEST_MM)?;
        within("corner_center_radius_mm", a.center_radius, -LARGEST_MM, LARGEST_MM)?;
        within("corner_center_height_mm", a.center_height, 0.0, LARGEST_MM)?;
        if !(0.0..90.0).contains(&a.lower_angle_deg) {
            return refuse("lower_angle_deg", a.lower_angle_deg, "must be 0 or more and below 90");
        }
        if !(a.upper_angle_deg > -90.0 && a.upper_angle_deg < 90.0) {
            return refuse("upper_angle_deg", a.upper_angle_deg, "must be above -90 and below 90");
        }
        let (lower_s, lower_c) = sin_cos(proveout_geom::rad(a.lower_angle_deg));
        let (upper_s, upper_c) = sin_cos(proveout_geom::rad(a.upper_angle_deg));
        let corner = [r, r * lower_s / lower_c];
        let mut outline = ToolOutline::start(0.0);
        let mut side = corner;
        if a.corner_radius > 0.0 {
            let center = [a.center_radius, a.center_height];
            let low = line_circle([0.0, 0.0], [lower_c, lower_s], center, a.corner_radius, 1.0);
            let high = line_circle(corner, [upper_s, upper_c], center, a.corner_radius, -1.0);
            let (Some(low), Some(high)) = (low, high) else {
                let which = if low.is_none() { "lower" } else { "upper" };
                let limit = format!("is too small: the circle does not reach the {which} line");
                return refuse("corner_radius_mm", a.corner_radius, limit);
            };
            if low[0] < -JOIN_MM {
                let limit = "puts the end of the lower line on the other side of the axis";
                return refuse("corner_center_radius_mm", a.center_radius, limit);
            }
            outline = outline.line([low[0].max(0.0), low[1]]).arc(center, high);
            side = high;
        } else {
            outline = outline.line(corner);
        }
        if height < side[1] - JOIN_MM {
            return refuse("cutter_height_mm", height, format!("must be above {} mm, the end of the corner", side[1]));
        }
        let top = side[0] + (height - side[1]) * upper_s / upper_c;
        if top < 0.0 {
            return refuse("cutter_height_mm", height, "is above the height at which the upper line meets the axis");
        }
        Self::from_outline(outline.line([top, height]), false)
    }

    /// Any curve of lines and convex arcs from the tip `[0, 0]` upward; z must not fall.
    ///
    /// # Errors
    /// A curve that does not begin at the tip or on the axis, falls, or crosses the axis.
    pub fn profile(segments: &[Segment]) -> Result<Self, ShapeError> {
        let Some(first) = segments.first() else { return Err(ProfileError::NotFinite.into()) };
        let mut outline = ToolOutline::start(first.from()[1]);
        if first.from()[0].abs() > JOIN_MM {
            return Err(ProfileError::OffAxis { r_mm: first.from()[0] }.into());
        }
        for (segment, s) in segments.iter().enumerate() {
            let gap_mm = crate::profile::distance(outline.end(), s.from());
            if gap_mm > JOIN_MM {
                return Err(ProfileError::Gap { segment, gap_mm }.into());
            }
            outline = match *s {
                Segment::Line { to, .. } => outline.line(to),
                Segment::Arc { center, to, .. } => outline.arc(center, to),
            };
        }
        Self::from_outline(outline, false)
    }

    fn from_outline(outline: ToolOutline, continues: bool) -> Result<Self, ShapeError> {
        if let Some(segment) = outline.first_falling() {
            return Err(ProfileError::Degenerate { segment, reason: "z falls along it" }.into());
        }
        outline.convex_bodies()?;
        Ok(Self { outline, continues })
    }

    fn continuing(outline: ToolOutline) -> Self {
        Self { outline, continues: true }
    }

    /// Height at which the described curve ends, mm.
    pub fn height(&self) -> f64 {
        self.outline.end()[1]
    }

    /// The cutter up to a height: the flutes below it, what the curve goes on with above it.
    ///
    /// # Errors
    /// `flute_length_mm` above the end of a curve that does not continue, or not above zero.
    pub(crate) fn divided(&self, flute_length: f64) -> Result<(ToolOutline, ToolOutline), ShapeError> {
        length("flute_length_mm", flute_length)?;
        if !self.continues && flute_length > self.height() + JOIN_MM {
            let limit = format!("must be at most {} mm, the height of the cutter", self.height());
            return refuse("flute_length_mm", flute_length, limit);
        }
        let whole = self.outline.clone().extended(flute_length);
        Ok(whole.split_at(flute_length))
    }

    /// The flutes as convex bodies from the tip up to `flute_length` (mm); all kinds but concave free
    /// profiles give one.
    ///
    /// # Errors
    /// As for a library file: a flute length that the cutter does not have.
    pub fn bodies(&self, flute_length: f64) -> Result<Vec<Profile>, ShapeError> {
        Ok(self.divided(flute_length)?.0.convex_bodies()?)
    }
}

fn half_angle(degrees: f64) -> Result<f64, ShapeError> {
    if degrees > 0.0 && degrees < 90.0 {
        return Ok(degrees);
    }
    refuse("half_angle_deg", degrees, "must be above 0 and below 90")
}

/// Intersection of the line through `p` along the unit vector `d` with a circle: the one further along `d`
/// (`side` = 1) or the other (`side` = -1); none when the line passes outside. A line that touches within
/// rounding is tangent.
fn line_circle(p: [f64; 2], d: [f64; 2], center: [f64; 2], radius: f64, side: f64) -> Option<[f64; 2]> {
    let to_center = [center[0] - p[0], center[1] - p[1]];
    let along = to_center[0] * d[0] + to_center[1] * d[1];
    let off = (to_center[0] * d[1] - to_center[1] * d[0]).abs();
    let t = if (radius - off).abs() <= TANGENT * radius.max(1.0) {
        along
    } else if off < radius {
        along + side * ((radius - off) * (radius + off)).sqrt()
    } else {
        return None;
    };
    Some([p[0] + t * d[0], p[1] + t * d[1]])
}
