//! A blade section as the envelope of circles whose centers run along a circular camber line.
//!
//! ```text
//!                  suction side (convex)
//!              .----------------------.
//!           .-'    . - - c(x) - - .    '-.
//!    LE   (     -                   -     )   TE
//!          '-.-'   pressure side      '-.-'
//!
//!    c(x)  center on the camber arc, x = 0 at the leading edge, x = 1 at the trailing edge
//!    r(x)  = (1-x) r_le + x r_te + (t/2 - (r_le+r_te)/2) sin^2(pi x)
//!    n     outward normal, angle w from +y, P = c + r n
//!    t     tangent, n turned by +90 degrees: the section is run through counter-clockwise
//!          (material on the left)
//! ```
//!
//! The envelope of circles fulfills `n . c' + r' = 0` (differentiate `|P - c|^2 = r^2` for x). With `L =
//! |c'|` (arc length of the camber line), `rho = r'/L` and `tau` the angle of `c'`, the two solutions are `w
//! = tau +- acos(-rho)`. Then `dw/dx = tau' +- rho'/sqrt(1-rho^2)` and `P' = c' + r' n + r w' t` has only a
//! part along t: `P' . t = -+ L sqrt(1-rho^2) + r w'`. Curvature is `dw/ds`. An offset by d replaces r by r +
//! d, everything else stays: the path of a ball's center, a fillet and a platform's rim are the same curve
//! with another d. Both ends are closed by arcs of the first and last circle; tangents meet there, curvatures
//! do not.
//!
//! Section law of the substitute blade: specification of the S-theta method (Li et al. 2022,
//! doi:10.3390/machines10100953), data file `s-theta.toml`, table `standin`.

use std::f64::consts::{PI, TAU};

use proveout_input::MAX_LENGTH_MM;
use thiserror::Error;

/// Panels of Gauss-Legendre quadrature on each of the four pieces of a section.
const PANELS: usize = 24;
/// Smallest camber angle, radian: below it the radius of the camber line has no digits left.
const LEAST_CAMBER: f64 = 1e-6;
/// Largest shift, mm.
const MOST_SHIFT_MM: f64 = 1e6;
/// Nodes and weights of the 5-point Gauss-Legendre rule on -1..1 (Abramowitz & Stegun 1964, table 25.4).
pub(crate) const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// Why numbers do not make a section.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SectionError {
    /// A number is not finite or outside of its range.
    #[error("{name} is {value}; it must be {range}")]
    Value {
        /// The number.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// The outline turns back on itself.
    #[error("with an offset of {offset_mm} mm the outline of the section folds (camber position {at:.3})")]
    Folds {
        /// Offset of the outline, mm.
        offset_mm: f64,
        /// Camber position from 0 to 1.
        at: f64,
    },
    /// Parts of the outline lie within others.
    #[error("with an offset of {offset_mm} mm the outline of the section crosses itself (camber position {at:.3})")]
    Crosses {
        /// Offset of the outline, mm.
        offset_mm: f64,
        /// Camber position from 0 to 1.
        at: f64,
    },
}

/// A section: envelope of circles on a circular camber line. Coordinates y, z in mm; the chord runs along y.
#[derive(Clone, Debug, PartialEq)]
pub struct CamberSection {
    /// Chord of the camber line, mm.
    pub chord: f64,
    /// Angle between the tangents at both ends of the camber line, radian.
    pub camber_angle: f64,
    /// Largest thickness, mm, at half of the camber line.
    pub thickness: f64,
    /// Radius of the leading edge, mm.
    pub leading_radius: f64,
    /// Radius of the trailing edge, mm.
    pub trailing_radius: f64,
    /// Shift of the outline in y and z, mm.
    pub shift: [f64; 2],
}

/// A point of an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPoint {
    /// y and z, mm.
    pub position: [f64; 2],
    /// Angle of the outward normal from +y, radian; the tangent is 90 degrees further.
    pub normal_angle: f64,
    /// Curvature along the counter-clockwise run, 1/mm: positive where the section is convex.
    pub curvature: f64,
}

impl SectionPoint {
    /// Outward unit normal.
    pub fn normal(&self) -> [f64; 2] {
        let (s, c) = self.normal_angle.sin_cos();
        [c, s]
    }
}

/// Position on one of the four pieces.
#[derive(Clone, Copy)]
struct Local {
    point: SectionPoint,
    /// Arc length for each unit of the piece's parameter, mm.
    speed: f64,
}

impl CamberSection {
    /// The substitute section of the S-theta specification.
    pub fn stand_in() -> Self {
        let mut section = Self {
            chord: 60.0,
            camber_angle: PI / 3.0,
            thickness: 8.0,
            leading_radius: 1.6,
            trailing_radius: 1.2,
            shift: [0.0; 2],
        };
        section.shift = section.centroid().map(|v| -v);
        section
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// A number is out of its range.
    pub fn check(&self) -> Result<(), SectionError> {
        let value = |name, value: f64, low: f64, high: f64, range| {
            let fits = value.is_finite() && value > low && value < high;
            if fits { Ok(()) } else { Err(SectionError::Value { name, value, range }) }
        };
        value("the chord", self.chord, 0.0, MAX_LENGTH_MM, "above zero")?;
        value("the camber angle", self.camber_angle, LEAST_CAMBER, 3.0, "between 0 and 170 degrees")?;
        value(
            "the leading edge radius",
            self.leading_radius,
            0.0,
            0.5 * self.chord,
            "above zero, below half the chord",
        )?;
        value(
            "the trailing edge radius",
            self.trailing_radius,
            0.0,
            0.5 * self.chord,
            "above zero, below half the chord",
        )?;
        let edges = self.leading_radius + self.trailing_radius;
        value("the thickness", self.thickness, 0.0, self.chord, "above zero, below the chord")?;
        value("the thickness over the edges", 2.0 * self.thickness - edges, 0.0, f64::MAX, "above zero")?;
        value("the shift", self.shift[0], -MOST_SHIFT_MM, MOST_SHIFT_MM, "finite")?;
        value("the shift", self.shift[1], -MOST_SHIFT_MM, MOST_SHIFT_MM, "finite")
    }

    /// Radius of the camber line, mm.
    pub fn camber_radius(&self) -> f64 {
        0.5 * self.chord / (0.5 * self.camber_angle).sin()
    }

    fn camber_length(&self) -> f64 {
        self.camber_radius() * self.camber_angle
    }

    /// Radius of the circle at camber position x, with its first and second derivatives.
    fn circle(&self, x: f64) -> [f64; 3] {
        let bulge = 0.5 * self.thickness - 0.5 * (self.leading_radius + self.trailing_radius);
        let (sine, slope) = ((PI * x).sin(), self.trailing_radius - self.leading_radius);
        [
            self.leading_radius + slope * x + bulge * sine * sine,
            slope + bulge * PI * (TAU * x).sin(),
            bulge * 2.0 * PI * PI * (TAU * x).cos(),
        ]
    }

    /// Center of the circle at camber position x and the angle of the camber line there.
    fn center(&self, x: f64) -> ([f64; 2], f64) {
        let radius = self.camber_radius();
        let angle = 0.5 * PI + self.camber_angle * (0.5 - x);
        let (s, c) = angle.sin_cos();
        let sag = radius * (0.5 * self.camber_angle).cos();
        ([radius * c + self.shift[0], radius * s - sag + self.shift[1]], angle - 0.5 * PI)
    }

    /// A point of the side: `upper` is the suction side. The parameter runs with x.
    fn side(&self, x: f64, upper: bool, offset: f64) -> Local {
        let [r, dr, ddr] = self.circle(x);
        let length = self.camber_length();
        let (rho, drho) = (dr / length, ddr / length);
        let root = (1.0 - rho * rho).sqrt();
        let sign = if upper { 1.0 } else { -1.0 };
        let (center, tau) = self.center(x);
        let angle = tau + sign * (-rho).acos();
        let turn = -self.camber_angle + sign * drho / root;
        let along = -sign * length * root + (r + offset) * turn;
        let (s, c) = angle.sin_cos();
        let position = [center[0] + (r + offset) * c, center[1] + (r + offset) * s];
        Local {
            point: SectionPoint { position, normal_angle: angle, curvature: turn / along },
            // The upper side is run through from the trailing to the leading edge.
            speed: -sign * along,
        }
    }

    /// Angles of the normal at both ends of an edge arc.
    fn edge_angles(&self, trailing: bool) -> [f64; 2] {
        let x = if trailing { 1.0 } else { 0.0 };
        let lower = self.side(x, false, 0.0).point.normal_angle;
        let upper = self.side(x, true, 0.0).point.normal_angle;
        if trailing { [lower, upper] } else { [upper, lower + TAU] }
    }

    fn edge(&self, u: f64, trailing: bool, offset: f64) -> Local {
        let x = if trailing { 1.0 } else { 0.0 };
        let radius = self.circle(x)[0] + offset;
        let [from, to] = self.edge_angles(trailing);
        let angle = from + (to - from) * u;
        let (center, _) = self.center(x);
        let (s, c) = angle.sin_cos();
        let position = [center[0] + radius * c, center[1] + radius * s];
        Local {
            point: SectionPoint { position, normal_angle: angle, curvature: 1.0 / radius },
            speed: radius * (to - from),
        }
    }

    /// Piece 0 pressure side, 1 trailing edge, 2 suction side, 3 leading edge; u from 0 to 1 along the
    /// counter-clockwise run. The normal angle rises by a full turn over the four pieces.
    fn local(&self, piece: usize, u: f64, offset: f64) -> Local {
        match piece {
            0 => self.side(u, false, offset),
            1 => self.edge(u, true, offset),
            2 => self.side(1.0 - u, true, offset),
            _ => self.edge(u, false, offset),
        }
    }

    /// Circle at camber position x: its center and the two points of the outline that belong to it, pressure
    /// side first.
    pub fn pair(&self, x: f64, offset: f64) -> ([f64; 2], [SectionPoint; 2]) {
        (self.center(x).0, [self.side(x, false, offset).point, self.side(x, true, offset).point])
    }

    /// Points of the two edge arcs, `count` equal angles each, both ends included: leading edge from suction
    /// to pressure side, trailing edge from pressure to suction side.
    pub fn edge_points(&self, trailing: bool, count: usize, offset: f64) -> Vec<SectionPoint> {
        (0..=count).map(|i| self.edge(i as f64 / count as f64, trailing, offset).point).collect()
    }

    /// The outline at an offset, by arc length.
    ///
    /// # Errors
    /// The outline folds: the offset is larger than the radius of curvature on a concave side.
    pub fn curve(&self, offset: f64) -> Result<SectionCurve, SectionError> {
        self.check()?;
        let mut ends = Vec::with_capacity(4 * PANELS + 1);
        let mut sum = 0.0;
        ends.push(0.0);
        for piece in 0..4 {
            for panel in 0..PANELS {
                let from = panel as f64 / PANELS as f64;
                sum += self.panel_length(piece, from, 1.0 / PANELS as f64, offset)?;
                ends.push(sum);
            }
        }
        Ok(SectionCurve { section: self.clone(), offset, ends })
    }

    fn panel_length(&self, piece: usize, from: f64, width: f64, offset: f64) -> Result<f64, SectionError> {
        let mut sum = 0.0;
        for (node, weight) in GAUSS {
            let u = from + 0.5 * width * (1.0 + node);
            let speed = self.local(piece, u, offset).speed;
            // Not finite where the circles outrun their envelope (|rho| > 1).
            if speed.is_nan() || speed <= 0.0 {
                return Err(SectionError::Folds { offset_mm: offset, at: if piece == 2 { 1.0 - u } else { u } });
            }
            sum += 0.5 * width * weight * speed;
        }
        Ok(sum)
    }

    /// Centroid of the area, mm (Green's theorem over the outline).
    pub fn centroid(&self) -> [f64; 2] {
        let (mut area, mut moment) = (0.0, [0.0; 2]);
        for piece in 0..4 {
            for panel in 0..PANELS {
                for (node, weight) in GAUSS {
                    let width = 1.0 / PANELS as f64;
                    let local = self.local(piece, (panel as f64 + 0.5 * (1.0 + node)) * width, 0.0);
                    let ([y, z], [ny, nz]) = (local.point.position, local.point.normal());
                    let ds = 0.5 * width * weight * local.speed;
                    area += 0.5 * (y * ny + z * nz) * ds;
                    moment[0] += 0.5 * y * y * ny * ds;
                    moment[1] += 0.5 * z * z * nz * ds;
                }
            }
        }
        moment.map(|m| m / area)
    }
}

/// An outline of a section at an offset, by arc length from the leading end of the pressure side,
/// counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionCurve {
    section: CamberSection,
    offset: f64,
    /// Arc length at the ends of the panels, mm.
    ends: Vec<f64>,
}

impl SectionCurve {
    /// Length of the whole outline, mm.
    pub fn perimeter(&self) -> f64 {
        self.ends.last().copied().unwrap_or_default()
    }

    /// Arc length where the pressure side, trailing edge, suction side and leading edge begin, mm.
    pub fn piece_starts(&self) -> [f64; 4] {
        std::array::from_fn(|piece| self.ends.get(piece * PANELS).copied().unwrap_or_default())
    }

    /// The point at an arc length, mm; any real number, full turns are counted in `normal_angle`.
    pub fn at(&self, arc: f64) -> SectionPoint {
        let perimeter = self.perimeter();
        let turns = (arc / perimeter).floor();
        let rest = (arc - turns * perimeter).clamp(0.0, perimeter);
        let panel = self.ends.partition_point(|&end| end <= rest).clamp(1, self.ends.len() - 1) - 1;
        let (piece, width) = (panel / PANELS, 1.0 / PANELS as f64);
        let from = (panel % PANELS) as f64 * width;
        let (low, wanted) = (self.ends[panel], rest - self.ends[panel]);
        let whole = self.ends[panel + 1] - low;
        let mut u = from + width * wanted / whole;
        // Newton on the arc length of the panel, which is smooth and nearly linear: three steps reach
        // rounding.
        for _ in 0..4 {
            let length = self.section.panel_length(piece, from, u - from, self.offset).unwrap_or(wanted);
            let speed = self.section.local(piece, u, self.offset).speed;
            u = (u + (wanted - length) / speed).clamp(from, from + width);
        }
        let mut point = self.section.local(piece, u, self.offset).point;
        point.normal_angle += turns * TAU;
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stand_in_has_the_lengths_of_its_specification() {
        // s-theta.toml [standin], given with two decimals.
        let section = CamberSection::stand_in();
        assert!((section.curve(0.0).unwrap().perimeter() - 134.99).abs() < 0.005);
        assert!((section.curve(8.0).unwrap().perimeter() - 185.26).abs() < 0.005);
        assert!((section.camber_radius() - 60.0).abs() < 1e-12);
    }

    #[test]
    fn an_offset_adds_a_circle_to_the_perimeter() {
        // Steiner: parallel curves of a closed curve of turning number one differ by 2 pi d.
        let section = CamberSection::stand_in();
        let base = section.curve(0.0).unwrap().perimeter();
        for offset in [0.5, 3.0, 8.0, 20.0] {
            assert!((section.curve(offset).unwrap().perimeter() - base - TAU * offset).abs() < 1e-9);
        }
    }

    #[test]
    fn arc_length_normal_and_curvature_agree_with_finite_differences() {
        let curve = CamberSection::stand_in().curve(8.0).unwrap();
        let (n, h) = (997, 1e-4);
        for i in 0..n {
            let s = curve.perimeter() * (f64::from(i) + 0.37) / f64::from(n);
            let (a, b, m) = (curve.at(s - h), curve.at(s + h), curve.at(s));
            // Steps across a joint of pieces see two curvatures.
            if curve.piece_starts().iter().any(|p| (s - p).abs() < 2.0 * h) {
                continue;
            }
            let chord = [b.position[0] - a.position[0], b.position[1] - a.position[1]];
            assert!((chord[0].hypot(chord[1]) / (2.0 * h) - 1.0).abs() < 1e-7, "{s}");
            let dot = chord[0] * m.normal()[0] + chord[1] * m.normal()[1];
            assert!(dot.abs() / (2.0 * h) < 1e-6, "{s}: {dot}");
            assert!(((b.normal_angle - a.normal_angle) / (2.0 * h) - m.curvature).abs() < 1e-5, "{s}");
        }
        assert!((curve.at(curve.perimeter() + 5.0).normal_angle - curve.at(5.0).normal_angle - TAU).abs() < 1e-12);
    }

    #[test]
    fn the_outline_touches_every_circle_and_crosses_none() {
        let section = CamberSection::stand_in();
        let curve = section.curve(0.0).unwrap();
        let circles: Vec<_> =
            (0..=2000).map(|i| f64::from(i) / 2000.0).map(|x| (section.center(x).0, section.circle(x)[0])).collect();
        for i in 0..500 {
            let p = curve.at(curve.perimeter() * f64::from(i) / 500.0).position;
            let gap = circles.iter().map(|(c, r)| (p[0] - c[0]).hypot(p[1] - c[1]) - r).fold(f64::MAX, f64::min);
            // The nearest of 2001 circles is at most 0.016 mm of camber away from the touching one: 0.016^2 /
            // (2 * 1.2).
            assert!(gap > -1e-9 && gap < 1.1e-4, "{gap}");
        }
    }

    #[test]
    fn numbers_that_make_no_section_are_named() {
        let section = CamberSection { leading_radius: -1.0, ..CamberSection::stand_in() };
        assert!(section.curve(0.0).unwrap_err().to_string().contains("leading edge radius"));
        let error = CamberSection::stand_in().curve(57.0).unwrap_err();
        assert!(matches!(error, SectionError::Folds { .. }), "{error}");
        assert!(CamberSection { chord: f64::NAN, ..CamberSection::stand_in() }.check().is_err());
    }

    #[test]
    fn the_centroid_of_the_stand_in_is_the_origin() {
        // Polygon centroid of a fine outline, by the shoelace formula.
        let curve = CamberSection::stand_in().curve(0.0).unwrap();
        let n = 20_000;
        let points: Vec<_> =
            (0..n).map(|i| curve.at(curve.perimeter() * f64::from(i) / f64::from(n)).position).collect();
        let (mut area, mut c) = (0.0, [0.0; 2]);
        for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
            let w = a[0] * b[1] - b[0] * a[1];
            area += 0.5 * w;
            c[0] += w * (a[0] + b[0]) / 6.0;
            c[1] += w * (a[1] + b[1]) / 6.0;
        }
        assert!(area > 0.0 && (c[0] / area).abs() < 1e-5 && (c[1] / area).abs() < 1e-5, "{c:?} {area}");
    }
}
