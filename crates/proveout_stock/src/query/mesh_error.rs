//! How far the extracted mesh is off the true surface, by the tangents at its crossings (see
//! `persist::regrid`).

use proveout_geom::{Point, Vector};

/// One and the cosine between two normals are together this at least: opposite normals say nothing.
const OPPOSITE: f64 = 1e-9;

/// The part of the error at a vertex of the mesh that follows from the crossings of its cell.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VertexSpread {
    /// Height of the largest triangle of tangents, and distance from the tangent planes, mm.
    pub height: f64,
    /// The normals turn by more than [`EDGE_COSINE`] allows.
    pub edge: bool,
}

/// Cosine of the angle between normals of a cell from which the surface has an edge: 30 degrees.
const EDGE_COSINE: f64 = 0.866;

/// Looks at the crossings (point and unit normal) of a vertex.
pub(crate) fn spread(vertex: &Point, crossings: &[(Point, Vector)]) -> VertexSpread {
    let mut out = VertexSpread::default();
    let mut off = 0.0_f64;
    for (k, (p, n)) in crossings.iter().enumerate() {
        off = off.max(n.dot(&(vertex - p)).abs());
        for (q, m) in &crossings[..k] {
            let cosine = n.dot(m).clamp(-1.0, 1.0);
            out.edge |= cosine < EDGE_COSINE;
            // tan(t / 2) with t the angle between the normals.
            let half = ((1.0 - cosine) / (1.0 + cosine).max(OPPOSITE)).sqrt();
            // No farther than the points are apart: beyond 127 degrees the triangle says nothing.
            out.height = out.height.max((0.5 * (p - q).norm() * half).min((p - q).norm()));
        }
    }
    out.height += off;
    out
}

/// Distance of a point from a triangle, mm.
pub(crate) fn to_triangle(p: &Point, corners: [&Point; 3]) -> f64 {
    (nearest_on_triangle(p, corners) - p).norm()
}

/// The point of a triangle nearest to `p` (Ericson 2005, "Real-Time Collision Detection", 5.1.5).
pub(crate) fn nearest_on_triangle(p: &Point, [a, b, c]: [&Point; 3]) -> Point {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    a + ab * (vb / sum) + ac * (vc / sum)
}
