//! A blade skinned through closed sections of points: a bicubic spline (de Boor 1962; Piegl & Tiller 1997,
//! section 10.3).
//!
//! Point k of every section lies on one line of constant u. The parameters of lines and sections are chord
//! lengths of each section and of each line, divided by their sum and averaged over all of them, and the
//! knots are these parameters. Round a section the spline is periodic and its second derivative continuous;
//! its seam is the first point of the file. Where the file names the edges, each edge and each side is a
//! spline of its own between the points where they join: place and tangent are common there (the tangent is
//! that of the circle through the last three points of the edge), the curvature jumps, as it does between an
//! arc and a side; the seam is the first point of the leading edge. Along the blade the ends of the spline
//! are not-a-knot; three sections give parabolas, two straight lines.
//!
//! Nothing is smoothed: the surface passes through every point.

use proveout_geom::{Point, Vector};
use thiserror::Error;

use super::{
    bicubic::{self, Net, hermite},
    cells::{CellCover, CurvatureBounds},
    scalar::{Interval, Scalar},
    section_file::{PointedSection, SectionPart},
    spline::{SplineEnds, slopes},
    surface::{Domain, Foot, Local, ParametricSurface},
};

/// Points of a section may be out of step with those of the one before by this part of them: more is another
/// beginning, not a twist.
const MOST_SHIFT: f64 = 0.1;
/// Fewest points of a section.
const FEWEST: usize = 8;
/// Points of one section nearer to each other than this are one point, mm.
const SAME_MM: f64 = 1e-6;
/// Ends of ranges that lie on lines of patches touch those beyond; so far inside they do not, in patches.
const INSIDE: f64 = 1e-12;

/// Why points make no blade.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SectionsError {
    /// Too few sections.
    #[error("{count} sections make no blade; give at least two")]
    Few {
        /// How many there are.
        count: usize,
    },
    /// Another count of points than the first section, or too few.
    #[error(
        "section {section} has {count} points, {first} has {expected}; give every section the same count, at least 8"
    )]
    Count {
        /// Its name.
        section: String,
        /// Its points.
        count: usize,
        /// Name of the first section.
        first: String,
        /// Points of the first section.
        expected: usize,
    },
    /// A point belongs to another part than the same point of the first section.
    #[error(
        "section {section}, point {point}: it belongs to another part than point {point} of {first}; mark the same points in every section"
    )]
    Parts {
        /// Its name.
        section: String,
        /// Which point, from 1.
        point: usize,
        /// Name of the first section.
        first: String,
    },
    /// The marked parts are not four runs of points.
    #[error(
        "section {section}, point {point}: the parts do not follow each other as leading edge, side, trailing edge, side, with three points or more to an edge"
    )]
    Order {
        /// Its name.
        section: String,
        /// Which point, from 1.
        point: usize,
    },
    /// Two points are one.
    #[error("section {section}, point {point}: it lies on the point before it; give each point once")]
    Double {
        /// Its name.
        section: String,
        /// Which point, from 1.
        point: usize,
    },
    /// Run through the other way than the first section.
    #[error("section {section} runs the other way round than {first}; turn the order of its points")]
    Direction {
        /// Its name.
        section: String,
        /// Name of the first section.
        first: String,
    },
    /// Begins at another place than the section before it.
    #[error(
        "section {section} begins at a different place than {before}: its point 1 lies where {before} has point {point}; begin every section at the same place"
    )]
    Shift {
        /// Its name.
        section: String,
        /// The section before it.
        before: String,
        /// Point of that section, from 1.
        point: usize,
    },
    /// Crosses itself.
    #[error("section {section} crosses itself between points {point} and {other}")]
    CrossesItself {
        /// Its name.
        section: String,
        /// Which point, from 1.
        point: usize,
        /// The other one.
        other: usize,
    },
    /// Crosses the section before it.
    #[error("section {section} crosses {before} near point {point}: the blade turns back there")]
    Crosses {
        /// Its name.
        section: String,
        /// The section before it.
        before: String,
        /// Which point, from 1.
        point: usize,
    },
}

/// A blade through sections.
#[derive(Clone, Debug)]
pub struct SkinnedBlade {
    u: Vec<f64>,
    v: Vec<f64>,
    /// `nets[k][j]`: from `u[k]` to `u[k + 1]`, from `v[j]` to `v[j + 1]`.
    nets: Vec<Vec<Net>>,
    breaks: Vec<f64>,
    /// 1 where `S_u x S_v` points outward, else -1.
    sense: f64,
    cells: CellCover,
}

/// Twice the area vector of a closed polygon.
fn area_vector(points: &[Point]) -> Vector {
    let first = points[0];
    points.windows(2).map(|w| (w[0] - first).cross(&(w[1] - first))).sum()
}

/// Chord lengths added up and divided by their sum: from 0 to 1, with the way back to the first point.
fn chord_parameters(points: &[Point]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for (k, p) in points.iter().enumerate() {
        sum += (points[(k + 1) % points.len()] - p).norm();
        out.push(sum);
    }
    out.into_iter().map(|s| s / sum).collect()
}

impl SkinnedBlade {
    /// Skins sections.
    ///
    /// # Errors
    /// The points make no blade: named with section and point.
    pub fn new(sections: &[PointedSection]) -> Result<Self, SectionsError> {
        let Some(first) = sections.first().filter(|_| sections.len() >= 2) else {
            return Err(SectionsError::Few { count: sections.len() });
        };
        let sections = from_leading_edge(sections, first)?;
        let first = &sections[0];
        let count = first.points.len();
        let joints = joints(first)?;
        for s in &sections {
            check_section(s)?;
        }
        let axis = centroid(&sections[sections.len() - 1].points) - centroid(&first.points);
        let sense = area_vector(&first.points).dot(&axis).signum();
        for s in &sections[1..] {
            if area_vector(&s.points).dot(&area_vector(&first.points)) <= 0.0 {
                return Err(SectionsError::Direction { section: s.name.clone(), first: first.name.clone() });
            }
        }
        let rounds: Vec<Vec<f64>> = sections.iter().map(|s| chord_parameters(&s.points)).collect();
        let u: Vec<f64> = (0..=count).map(|k| rounds.iter().map(|r| r[k]).sum::<f64>() / rounds.len() as f64).collect();
        for pair in sections.windows(2) {
            let shift = shift(&pair[0].points, &pair[1].points);
            if shift.min(count - shift) as f64 > MOST_SHIFT * count as f64 {
                let (section, before) = (pair[1].name.clone(), pair[0].name.clone());
                return Err(SectionsError::Shift { section, before, point: shift + 1 });
            }
        }
        for pair in sections.windows(2) {
            let up = area_vector(&pair[0].points) * sense;
            if let Some(k) = (0..count).find(|&k| (pair[1].points[k] - pair[0].points[k]).dot(&up) <= 0.0) {
                let (section, before) = (pair[1].name.clone(), pair[0].name.clone());
                return Err(SectionsError::Crosses { section, before, point: k + 1 });
            }
        }
        let v = along_parameters(&sections);
        let nets = nets(&sections, &u, &v, &joints);
        let breaks = joints.iter().map(|&k| u[k]).collect();
        let bare = Self { u, v, nets, breaks, sense, cells: CellCover::default() };
        let cells = CellCover::new(&bare, [&bare.u, &bare.v]);
        Ok(Self { cells, ..bare })
    }

    /// Parameters of the points of each section, from 0 to 1; the last one is the first again.
    pub fn u_of_points(&self) -> &[f64] {
        &self.u
    }

    /// Parameters of the sections, from 0 to 1.
    pub fn v_of_sections(&self) -> &[f64] {
        &self.v
    }

    fn patch(&self, u: f64, v: f64) -> (usize, usize) {
        let place = |ends: &[f64], x: f64| ends.partition_point(|e| *e <= x).clamp(1, ends.len() - 1) - 1;
        (place(&self.u, u), place(&self.v, v))
    }
}

/// The cyclic shift of points for which two sections, laid on their middles, fit best.
fn shift(before: &[Point], here: &[Point]) -> usize {
    let (n, a, b) = (before.len(), centroid(before), centroid(here));
    let misfit = |s: usize| -> f64 { (0..n).map(|k| (here[k] - b - (before[(k + s) % n] - a)).norm_squared()).sum() };
    (0..n).map(|s| (misfit(s), s)).min_by(|x, y| x.0.total_cmp(&y.0)).map_or(0, |best| best.1)
}

fn centroid(points: &[Point]) -> Point {
    Point::from(points.iter().map(|p| p.coords).sum::<Vector>() / points.len() as f64)
}

/// The sections with their counts and parts compared, begun at the leading edge where the file names it.
fn from_leading_edge(
    sections: &[PointedSection],
    first: &PointedSection,
) -> Result<Vec<PointedSection>, SectionsError> {
    let expected = first.points.len();
    let mut start = 0;
    if let Some(k) = (0..first.parts.len()).find(|&k| {
        let before = first.parts[(k + first.parts.len() - 1) % first.parts.len()];
        first.parts[k] == SectionPart::Leading && before != SectionPart::Leading
    }) {
        start = k;
    }
    let turned = |s: &PointedSection| {
        if s.points.len() != expected || expected < FEWEST {
            let (section, first) = (s.name.clone(), first.name.clone());
            return Err(SectionsError::Count { section, count: s.points.len(), first, expected });
        }
        if let Some(k) = (0..s.parts.len()).find(|&k| s.parts[k] != first.parts[k]) {
            return Err(SectionsError::Parts { section: s.name.clone(), point: k + 1, first: first.name.clone() });
        }
        let mut out = s.clone();
        out.points.rotate_left(start);
        if !out.parts.is_empty() {
            out.parts.rotate_left(start);
        }
        Ok(out)
    };
    sections.iter().map(turned).collect()
}

/// Points where edges and sides join; empty where no parts are named.
fn joints(section: &PointedSection) -> Result<Vec<usize>, SectionsError> {
    let parts = &section.parts;
    if parts.is_empty() {
        return Ok(Vec::new());
    }
    let wrong = |k: usize| SectionsError::Order { section: section.name.clone(), point: k + 1 };
    let mut runs: Vec<(SectionPart, usize)> = Vec::new();
    for (k, part) in parts.iter().enumerate() {
        if runs.last().is_none_or(|(p, _)| p != part) {
            runs.push((*part, k));
        }
    }
    let ok = matches!(
        runs.iter().map(|r| r.0).collect::<Vec<_>>().as_slice(),
        [
            SectionPart::Leading,
            SectionPart::Suction | SectionPart::Pressure,
            SectionPart::Trailing,
            SectionPart::Suction | SectionPart::Pressure
        ]
    );
    if !ok || runs[1].0 == runs[3].0 {
        return Err(wrong(runs.get(4).map_or(0, |r| r.1)));
    }
    // The points where they join belong to the edges.
    let joints = vec![0, runs[1].1 - 1, runs[2].1, runs[3].1 - 1];
    for edge in [0, 2] {
        if joints[edge + 1] < joints[edge] + 2 {
            return Err(wrong(joints[edge]));
        }
    }
    Ok(joints)
}

fn check_section(s: &PointedSection) -> Result<(), SectionsError> {
    let n = s.points.len();
    let next = |k: usize| s.points[(k + 1) % n];
    if let Some(k) = (0..n).find(|&k| (next(k) - s.points[k]).norm() < SAME_MM) {
        return Err(SectionsError::Double { section: s.name.clone(), point: (k + 1) % n + 1 });
    }
    // Seen along its area vector.
    let up = area_vector(&s.points);
    let beside = |a: &Point, b: &Point, p: &Point| (b - a).cross(&(p - a)).dot(&up);
    for i in 0..n {
        for j in i + 2..n {
            if i == 0 && j == n - 1 {
                continue;
            }
            let (a, b, c, d) = (&s.points[i], &next(i), &s.points[j], &next(j));
            if beside(a, b, c) * beside(a, b, d) < 0.0 && beside(c, d, a) * beside(c, d, b) < 0.0 {
                return Err(SectionsError::CrossesItself { section: s.name.clone(), point: i + 1, other: j + 1 });
            }
        }
    }
    Ok(())
}

/// Chord lengths of all lines along the blade, divided by their sums and averaged.
fn along_parameters(sections: &[PointedSection]) -> Vec<f64> {
    let count = sections[0].points.len();
    let mut out = vec![0.0; sections.len()];
    for k in 0..count {
        let steps: Vec<f64> = sections.windows(2).map(|w| (w[1].points[k] - w[0].points[k]).norm()).collect();
        let whole: f64 = steps.iter().sum();
        let mut sum = 0.0;
        for (j, step) in steps.iter().enumerate() {
            sum += step;
            out[j + 1] += sum / whole / count as f64;
        }
    }
    // Rounding of the averages.
    if let Some(last) = out.last_mut() {
        *last = 1.0;
    }
    out
}

/// Slope at the first of three points of an edge: along the circle through them (inverted at that point the
/// circle is a straight line, parallel to its tangent there), as fast as the chord to the second.
fn circle_slope(u: [f64; 2], p: [Vector; 3]) -> Vector {
    let [a, b] = [p[1] - p[0], p[2] - p[0]];
    let chord = a / (u[1] - u[0]);
    let tangent = a / a.norm_squared() - b / b.norm_squared();
    let tangent = tangent.try_normalize(0.0).unwrap_or(chord);
    tangent * (chord.norm() * chord.dot(&tangent).signum())
}

/// Slopes round a closed row of vectors (without the repeated first one).
fn round_slopes(u: &[f64], row: &[Vector], joints: &[usize]) -> Vec<Vector> {
    let mut closed = row.to_vec();
    closed.push(row[0]);
    let &[a, b, c, d] = joints else { return slopes(u, &closed, SplineEnds::Closed) };
    let end = closed.len() - 1;
    let slope = |k: [usize; 3]| circle_slope([u[k[0]], u[k[1]]], k.map(|i| row[i]));
    let tangents =
        [slope([a, a + 1, a + 2]), slope([b, b - 1, b - 2]), slope([c, c + 1, c + 2]), slope([d, d - 1, d - 2])];
    let mut out = vec![Vector::zeros(); closed.len()];
    for (k, (from, to)) in [(a, b), (b, c), (c, d), (d, end)].into_iter().enumerate() {
        let ends = SplineEnds::Slopes([tangents[k], tangents[(k + 1) % 4]]);
        out[from..=to].copy_from_slice(&slopes(&u[from..=to], &closed[from..=to], ends));
    }
    out
}

/// Control points of all patches from places, both slopes and the mixed derivative at all points.
fn nets(sections: &[PointedSection], u: &[f64], v: &[f64], joints: &[usize]) -> Vec<Vec<Net>> {
    let rows: Vec<Vec<Vector>> = sections.iter().map(|s| s.points.iter().map(|p| p.coords).collect()).collect();
    let around: Vec<Vec<Vector>> = rows.iter().map(|row| round_slopes(u, row, joints)).collect();
    let count = rows[0].len();
    let line = |field: &[Vec<Vector>], k: usize| field.iter().map(|row| row[k]).collect::<Vec<_>>();
    // The slopes along v are linear in the values: those of the slopes round the section are the mixed
    // derivatives.
    let columns = |field: &[Vec<Vector>]| -> Vec<Vec<Vector>> {
        (0..count).map(|k| slopes(v, &line(field, k), SplineEnds::NotAKnot)).collect()
    };
    let (along, mixed) = (columns(&rows), columns(&around));
    let net = |k: usize, j: usize| -> Net {
        let (du, dv, next) = (u[k + 1] - u[k], v[j + 1] - v[j], (k + 1) % count);
        // At both ends along v: the cubic along u of places, and that of slopes along v.
        let [low, high] = [j, j + 1].map(|j| {
            let places = hermite([rows[j][k], rows[j][next]], [around[j][k], around[j][next]], du);
            let rises = hermite([along[k][j], along[next][j]], [mixed[k][j], mixed[next][j]], du);
            (places, rises)
        });
        std::array::from_fn(|i| hermite([low.0[i], high.0[i]], [low.1[i], high.1[i]], dv))
    };
    (0..count).map(|k| (0..v.len() - 1).map(|j| net(k, j)).collect()).collect()
}

impl CurvatureBounds for SkinnedBlade {
    fn second(&self, u: [f64; 2], v: [f64; 2]) -> [[Interval; 3]; 3] {
        let inner = |r: [f64; 2]| [r[0] + INSIDE, r[1] - INSIDE];
        let (u, v, patches) = (inner(u), inner(v), self.nets.len() as i64);
        let turn = |x: f64| {
            let turns = x.floor();
            turns as i64 * patches + self.patch(x - turns, v[0]).0 as i64
        };
        let (from, to) = (turn(u[0]), turn(u[1]).max(turn(u[0])));
        let (low, high) = (self.patch(0.0, v[0]).1, self.patch(0.0, v[1]).1);
        let mut all: Option<[[Interval; 3]; 3]> = None;
        for k in (from..=to).take(self.nets.len()) {
            let k = k.rem_euclid(patches) as usize;
            for j in low..=high.max(low) {
                let one = bicubic::second(&self.nets[k][j], [self.u[k + 1] - self.u[k], self.v[j + 1] - self.v[j]]);
                all = Some(
                    all.map_or(one, |a| std::array::from_fn(|d| std::array::from_fn(|c| a[d][c].with(one[d][c])))),
                );
            }
        }
        all.unwrap_or([[Interval::of(0.0); 3]; 3])
    }
}

impl ParametricSurface for SkinnedBlade {
    fn domain(&self) -> Domain {
        Domain { u: [0.0, 1.0], v: [0.0, 1.0], u_closed: true }
    }

    fn local(&self, u: f64, v: f64) -> Local {
        let u = u - u.floor();
        let (k, j) = self.patch(u, v);
        let widths = [self.u[k + 1] - self.u[k], self.v[j + 1] - self.v[j]];
        let [p, du, dv, uu, uv, vv] =
            bicubic::at(&self.nets[k][j], widths, (u - self.u[k]) / widths[0], (v - self.v[j]) / widths[1]);
        let normal = du.cross(&dv) * self.sense;
        Local {
            point: Point::from(p),
            normal: normal.try_normalize(0.0).unwrap_or_else(Vector::x),
            first: [du, dv],
            second: [uu, uv, vv],
        }
    }

    fn nearest(&self, p: &Point) -> [f64; 2] {
        self.foot(p).parameters
    }

    fn foot(&self, p: &Point) -> Foot {
        self.cells.foot(self, p)
    }

    fn is_beyond(&self, p: &Point, reach: f64) -> bool {
        self.cells.is_beyond(self, p, reach)
    }

    fn breaks(&self) -> Vec<f64> {
        self.breaks.clone()
    }
}
