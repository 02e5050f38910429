//! Sections v = constant of a closed surface with a label that runs round them: part of the length, or polar
//! angle. A line of a path is where the label is constant.
//!
//! The section fit of Lu et al. 2022, section 3.1: the two points of a section that are farthest
//! apart are its edges. A similarity that brings the trailing one to (0.5, 0) and the leading one
//! to (-0.5, 0), the convex side above, makes the chord 1 and a = 1/4. The surface says which edge
//! is the trailing one (`trailing` of [`Sections::new`]) for the first section; the others follow
//! by nearness. The paper resamples points by cubics in theta before skinning, whose normals are
//! 1.7 degrees wrong at the edges, where a cubic in theta is singular. Here the line goes through
//! the exact points of the surface with that theta in every section, and the normals are the
//! surface's own.

use std::f64::consts::{PI, TAU};

use proveout_blade::ParametricSurface;
use proveout_geom::Point;

use super::{
    ParameterCurve, PathError,
    curve::fitted,
    polar_angle::{ContourSide, polar_point},
};

/// What is constant along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Label {
    /// Part of the section's length from its start, 0 to 1: the chord-length parameter (equation (2)) of
    /// infinitely many points.
    Length,
    /// theta / 2 pi. `focus_inside`: how far the branch points lie inside of the edges, parts of the chord; 0
    /// is the paper's, half of the nose radius is Theodorsen's and makes the angle regular at the edge.
    PolarAngle {
        /// Parts of the chord.
        focus_inside: f64,
    },
    /// The surface's own u, as part of its range.
    Surface,
}

/// A section with its edges.
#[derive(Clone, Debug)]
pub struct BladeLoop {
    /// Parameter along the blade.
    pub v: f64,
    /// u of the trailing and of the leading edge: the two points that are farthest apart.
    pub edges: [f64; 2],
    /// Distance of the edges, mm.
    pub chord: f64,
    /// +1 where u grows from the trailing edge over the convex side to the leading edge.
    turn: f64,
    trailing: Point,
    /// Unit vectors of the standardized section: from the leading to the trailing edge, and towards the
    /// convex side.
    axes: [proveout_geom::Vector; 2],
    /// Length of the section up to the ends of equal pieces of u, mm.
    lengths: Vec<f64>,
    range: [f64; 2],
}

/// Points of a section among which the farthest pair is looked for before it is refined.
const SCAN: usize = 360;
/// Pieces of u of a section in the table of its length.
const PIECES: usize = 256;
/// Step of u at which a search ends, part of the period.
const FOUND: f64 = 1e-15;
/// Height of a section over its chord below which it has none, part of the chord.
const NO_THICKNESS: f64 = 1e-9;
/// Error of the place at a length at which its search ends, part of the section.
const AT_LENGTH: f64 = 1e-13;
/// Default number of sections between which lines are fitted.
pub const SECTIONS: usize = 101;

/// Sections of a surface, from one v to another.
#[derive(Clone, Debug)]
pub struct Sections<'a> {
    surface: &'a dyn ParametricSurface,
    label: Label,
    sections: Vec<BladeLoop>,
}

impl<'a> Sections<'a> {
    /// `count` sections from `v[0]` to `v[1]`. `trailing` is a u near the trailing edge of the first one.
    ///
    /// # Errors
    /// A section is not closed, or has no two edges.
    pub fn new(
        surface: &'a dyn ParametricSurface,
        label: Label,
        v: [f64; 2],
        count: usize,
        trailing: f64,
    ) -> Result<Self, PathError> {
        if let Label::PolarAngle { focus_inside } = label {
            PathError::within("focus_inside", focus_inside, 0.0, 0.25)?;
        }
        let domain = surface.domain();
        let count = count.max(2);
        let mut sections: Vec<BladeLoop> = Vec::with_capacity(count);
        let mut near = surface.local(trailing, v[0]).point;
        for j in 0..count {
            let at = v[0] + (v[1] - v[0]) * j as f64 / (count - 1) as f64;
            let section = if matches!(label, Label::PolarAngle { .. }) {
                if !domain.u_closed {
                    let what = "an open surface has no edges and no polar angle".to_owned();
                    return Err(PathError::NoLine { what, section: part(at, domain.v) });
                }
                BladeLoop::with_edges(surface, at, near)?
            } else {
                BladeLoop::plain(surface, at)
            };
            near = section.trailing;
            sections.push(section);
        }
        Ok(Self { surface, label, sections })
    }

    /// The sections.
    pub fn sections(&self) -> &[BladeLoop] {
        &self.sections
    }

    /// The label of a point of section j; theta runs from 0 to 1 over the convex side first.
    pub fn label(&self, j: usize, u: f64) -> f64 {
        let section = &self.sections[j];
        match self.label {
            Label::Surface => part(u, section.range),
            Label::Length => section.length(self.surface, u) / section.lengths[PIECES],
            Label::PolarAngle { focus_inside } => section.theta(self.surface, u, focus_inside) / TAU,
        }
    }

    /// The line on which the label is constant, through the exact points of all sections; t is v.
    ///
    /// # Errors
    /// A section that the label does not run round.
    pub fn line(&self, label: f64) -> Result<ParameterCurve, PathError> {
        let mut t = Vec::with_capacity(self.sections.len());
        let mut points: Vec<[f64; 2]> = Vec::with_capacity(self.sections.len());
        let period = self.surface.domain().u_closed.then(|| self.surface.domain().u[1] - self.surface.domain().u[0]);
        for (j, section) in self.sections.iter().enumerate() {
            let mut u = self.find(j, label)?;
            // The same turn as in the section before.
            if let (Some(period), Some(&[before, _])) = (period, points.last()) {
                u += period * ((before - u) / period).round();
            }
            t.push(section.v);
            points.push([u, section.v]);
        }
        fitted(&t, &points, "the line of a constant label", 0.0)
    }

    /// u of section j at which the label has a value.
    fn find(&self, j: usize, label: f64) -> Result<f64, PathError> {
        let section = &self.sections[j];
        let [low, high] = section.range;
        match self.label {
            Label::Surface => Ok(low + label * (high - low)),
            Label::Length => Ok(section.at_length(self.surface, label * section.lengths[PIECES])),
            Label::PolarAngle { focus_inside } => {
                let theta = (label * TAU).rem_euclid(TAU);
                let period = high - low;
                // From the trailing edge round: u = trailing + turn * x, x in 0 to the period; the leading
                // edge is theta = pi.
                let [trailing, leading] = section.edges;
                let at_leading = (section.turn * (leading - trailing)).rem_euclid(period);
                if theta == 0.0 {
                    return Ok(trailing);
                }
                if theta == PI {
                    return Ok(trailing + section.turn * at_leading);
                }
                let (mut a, mut b) = if theta < PI { (0.0, at_leading) } else { (at_leading, period) };
                let off = |x: f64| section.theta(self.surface, trailing + section.turn * x, focus_inside) - theta;
                // Regula falsi of Anderson and Bjorck 1973 with bisection where it stalls: theta grows like a
                // root at the edges.
                let (mut fa, mut fb) =
                    (if theta < PI { -theta } else { PI - theta }, if theta < PI { PI - theta } else { TAU - theta });
                for round in 0..200 {
                    let x = if round % 3 == 2 { 0.5 * (a + b) } else { (a * fb - b * fa) / (fb - fa) };
                    let x = if x > a.min(b) && x < a.max(b) { x } else { 0.5 * (a + b) };
                    let f = off(x);
                    if f == 0.0 || (b - a).abs() <= FOUND * period {
                        return Ok(trailing + section.turn * x);
                    }
                    if (f > 0.0) == (fb > 0.0) {
                        (b, fb) = (x, f);
                    } else {
                        (a, fa) = (x, f);
                    }
                }
                Ok(trailing + section.turn * 0.5 * (a + b))
            }
        }
    }
}

pub(crate) fn part(x: f64, [low, high]: [f64; 2]) -> f64 {
    (x - low) / (high - low)
}

impl BladeLoop {
    fn plain(surface: &dyn ParametricSurface, v: f64) -> Self {
        let range = surface.domain().u;
        let zero = proveout_geom::Vector::zeros();
        let trailing = surface.local(range[0], v).point;
        let mut section =
            Self { v, edges: range, chord: 0.0, turn: 1.0, trailing, axes: [zero; 2], lengths: vec![0.0], range };
        let piece = (range[1] - range[0]) / PIECES as f64;
        let mut sum = 0.0;
        for k in 0..PIECES {
            sum += section.way(surface, range[0] + piece * k as f64, range[0] + piece * (k + 1) as f64);
            section.lengths.push(sum);
        }
        section
    }

    fn with_edges(surface: &dyn ParametricSurface, v: f64, near: Point) -> Result<Self, PathError> {
        let domain = surface.domain();
        let range = domain.u;
        let period = range[1] - range[0];
        let points: Vec<Point> =
            (0..SCAN).map(|k| surface.local(range[0] + period * k as f64 / SCAN as f64, v).point).collect();
        let mut pair = (0, SCAN / 2, 0.0);
        for i in 0..SCAN {
            for k in i + 1..SCAN {
                let apart = (points[i] - points[k]).norm_squared();
                if apart > pair.2 {
                    pair = (i, k, apart);
                }
            }
        }
        let of = |k: usize| range[0] + period * k as f64 / SCAN as f64;
        let mut edges = [of(pair.0), of(pair.1)];
        // The distance is stationary: d = S(a) - S(b) across both tangents. Newton, held to the neighborhood
        // of the pair.
        let reach = period / SCAN as f64;
        for _ in 0..60 {
            let [p, q] = edges.map(|u| surface.local(u, v));
            let d = p.point - q.point;
            let g = [d.dot(&p.first[0]), -d.dot(&q.first[0])];
            let hessian = [
                p.first[0].norm_squared() + d.dot(&p.second[0]),
                -p.first[0].dot(&q.first[0]),
                q.first[0].norm_squared() - d.dot(&q.second[0]),
            ];
            let det = hessian[0] * hessian[2] - hessian[1] * hessian[1];
            if hessian[0] >= 0.0 || det <= 0.0 {
                let what =
                    "the two points of the section that are farthest apart are not edges: it has no chord".to_owned();
                return Err(PathError::NoLine { what, section: part(v, domain.v) });
            }
            let step = [(hessian[2] * g[0] - hessian[1] * g[1]) / det, (hessian[0] * g[1] - hessian[1] * g[0]) / det];
            edges[0] -= step[0].clamp(-reach, reach);
            edges[1] -= step[1].clamp(-reach, reach);
            if step[0].abs().max(step[1].abs()) < FOUND * period {
                break;
            }
        }
        let at = edges.map(|u| surface.local(u, v).point);
        if (at[1] - near).norm() < (at[0] - near).norm() {
            edges.swap(0, 1);
        }
        let [trailing, leading] = edges.map(|u| surface.local(u, v).point);
        let chord = (trailing - leading).norm();
        let along = (trailing - leading) / chord;
        // The convex side is the one that lies farther from the chord line.
        let from = leading + along * (0.5 * chord);
        let height = |p: &Point| {
            let d = p - from;
            d - along * d.dot(&along)
        };
        let farthest = points
            .iter()
            .map(height)
            .fold(proveout_geom::Vector::zeros(), |far, h| if h.norm_squared() > far.norm_squared() { h } else { far });
        let Some(up) = farthest.try_normalize(NO_THICKNESS * chord) else {
            let what = "the section has no thickness".to_owned();
            return Err(PathError::NoLine { what, section: part(v, domain.v) });
        };
        // u grows over the convex side where the point half way to the leading edge is the higher one.
        let half_way = (leading_after(edges, period)) * 0.5;
        let mean = |sign: f64, whole: f64| {
            let h = (1..8).map(|k| surface.local(edges[0] + sign * whole * f64::from(k) / 8.0, v).point);
            h.map(|p| height(&p).dot(&up)).sum::<f64>()
        };
        let over = mean(1.0, 2.0 * half_way);
        let under = mean(-1.0, period - 2.0 * half_way);
        let turn = if over > under { 1.0 } else { -1.0 };
        Ok(Self { v, edges, chord, turn, trailing, axes: [along, up], lengths: vec![0.0; PIECES + 1], range })
    }

    /// Place in the standardized section: trailing edge at (0.5, 0), leading edge at (-0.5, 0), convex side
    /// above.
    pub fn standard(&self, p: &Point) -> [f64; 2] {
        let d = p - self.trailing;
        [0.5 + d.dot(&self.axes[0]) / self.chord, d.dot(&self.axes[1]) / self.chord]
    }

    fn theta(&self, surface: &dyn ParametricSurface, u: f64, focus_inside: f64) -> f64 {
        let period = self.range[1] - self.range[0];
        let x = (self.turn * (u - self.edges[0])).rem_euclid(period);
        let at_leading = (self.turn * (self.edges[1] - self.edges[0])).rem_euclid(period);
        let side = if x <= at_leading { ContourSide::Suction } else { ContourSide::Pressure };
        let [x, y] = self.standard(&surface.local(u, self.v).point);
        polar_point(x, y, 0.5 * (0.5 - focus_inside), side).theta
    }

    fn way(&self, surface: &dyn ParametricSurface, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        // Gauss's rule of three points; the pieces are short.
        let node = 0.6_f64.sqrt();
        let speed = |x: f64| surface.local(middle + half * x, self.v).first[0].norm();
        half * (5.0 * speed(-node) + 8.0 * speed(0.0) + 5.0 * speed(node)) / 9.0
    }

    fn length(&self, surface: &dyn ParametricSurface, u: f64) -> f64 {
        let piece = (self.range[1] - self.range[0]) / PIECES as f64;
        let k = ((u - self.range[0]) / piece).clamp(0.0, (PIECES - 1) as f64) as usize;
        self.lengths[k] + self.way(surface, self.range[0] + piece * k as f64, u)
    }

    fn at_length(&self, surface: &dyn ParametricSurface, length: f64) -> f64 {
        let piece = (self.range[1] - self.range[0]) / PIECES as f64;
        let k = self.lengths.partition_point(|&l| l <= length).clamp(1, PIECES) - 1;
        let from = self.range[0] + piece * k as f64;
        let mut u = from + piece * (length - self.lengths[k]) / (self.lengths[k + 1] - self.lengths[k]);
        for _ in 0..6 {
            let off = self.lengths[k] + self.way(surface, from, u) - length;
            u -= off / surface.local(u, self.v).first[0].norm();
            if off.abs() < AT_LENGTH * self.lengths[PIECES] {
                break;
            }
        }
        u
    }
}

/// From the trailing edge with growing u to the leading edge.
fn leading_after(edges: [f64; 2], period: f64) -> f64 {
    (edges[1] - edges[0]).rem_euclid(period)
}
