//! A side of a part as a map S(u, v): what planning of paths and judging of surfaces ask of any blade.
//!
//! `u` runs round the section (or across an open surface), `v` along the blade, both in the units that the
//! kind chooses. The outward normal is `S_u x S_v` up to the sign that [`Local::normal`] already has.
//! Curvatures are the roots of `det(II - k I) = 0` of the two fundamental forms, with the sign that makes a
//! convex surface positive (do Carmo 1976, section 3.3).

use std::fmt::Debug;

use proveout_geom::{Point, Vector};

/// Shorter sums of derivatives have no direction: all directions have the same curvature.
const SHORTEST: f64 = 1e-12;

/// Range of the two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Lowest and highest u.
    pub u: [f64; 2],
    /// Lowest and highest v.
    pub v: [f64; 2],
    /// Whether both ends of u are the same line: then any u is allowed and taken modulo the range.
    pub u_closed: bool,
}

/// Place, normal and derivatives of a surface at (u, v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// mm.
    pub point: Point,
    /// Outward unit normal.
    pub normal: Vector,
    /// `S_u`, `S_v`, mm for each unit of the parameter.
    pub first: [Vector; 2],
    /// `S_uu`, `S_uv`, `S_vv`.
    pub second: [Vector; 3],
}

impl Local {
    /// Principal curvatures, 1/mm, positive where the surface is convex, with their unit directions; the
    /// larger one first.
    pub fn principal(&self) -> [(f64, Vector); 2] {
        let [u, v] = &self.first;
        let [e, f, g] = [u.dot(u), u.dot(v), v.dot(v)];
        let [l, m, n] = self.second.each_ref().map(|d| -d.dot(&self.normal));
        let det = e * g - f * f;
        let half_sum = 0.5 * (l * g - 2.0 * m * f + n * e) / det;
        let product = (l * n - m * m) / det;
        let root = (half_sum * half_sum - product).max(0.0).sqrt();
        let high = half_sum + root;
        // (II - k I) (a, b) = 0: from the row that is farther from zero.
        let rows = [[l - high * e, m - high * f], [m - high * f, n - high * g]];
        let row = if rows[0][0].hypot(rows[0][1]) > rows[1][0].hypot(rows[1][1]) { rows[0] } else { rows[1] };
        let direction = (u * row[1] - v * row[0]).try_normalize(SHORTEST).unwrap_or_else(|| u.normalize());
        [(high, direction), (half_sum - root, self.normal.cross(&direction))]
    }

    /// Normal curvature in a direction of the tangent plane (any length), 1/mm, positive where convex
    /// (Euler's formula).
    pub fn curvature_along(&self, direction: &Vector) -> f64 {
        let [(high, along), (low, _)] = self.principal();
        let cosine = (direction.dot(&along) / direction.norm()).clamp(-1.0, 1.0);
        high * cosine * cosine + low * (1.0 - cosine * cosine)
    }
}

/// A point of a surface as the nearest one to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// u and v.
    pub parameters: [f64; 2],
    /// mm.
    pub distance: f64,
    /// No point of the surface is nearer than `distance - error`, mm; infinite where nothing is proved.
    pub error: f64,
}

/// A side of a part as a map S(u, v).
pub trait ParametricSurface: Debug + Send + Sync {
    /// Range of the parameters.
    fn domain(&self) -> Domain;
    /// Place and derivatives; outside of the domain the surface is continued, so that a search can step over
    /// its rim.
    fn local(&self, u: f64, v: f64) -> Local;
    /// Parameters of the point nearest to p, in or on the rim of the domain.
    fn nearest(&self, p: &Point) -> [f64; 2];
    /// The same with its distance, and how far that is proved to be the least one: [`super::FOOT_ERROR_MM`],
    /// or more where a search ended before its end, as for a point to which a whole patch is equally near.
    fn foot(&self, p: &Point) -> Foot {
        let parameters = self.nearest(p);
        let distance = (self.local(parameters[0], parameters[1]).point - p).norm();
        Foot { parameters, distance, error: f64::INFINITY }
    }
    /// Whether no point of the surface is nearer to p than `reach`, mm, where a few looks prove it: much less
    /// than a foot costs. False says nothing.
    fn is_beyond(&self, _p: &Point, _reach: f64) -> bool {
        false
    }
    /// Lines u = constant on which the curvature jumps, in ascending order: ends of edge arcs, knots.
    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }
}
