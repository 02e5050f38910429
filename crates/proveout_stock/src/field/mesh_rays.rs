//! Watertight rays through a closed mesh.
//!
//! Seen along the rays the mesh is a set of triangles in a plane, and the rays are points. Corners and points
//! are moved to a lattice of [`LATTICE`] mm, so that the side of an edge on which a point lies is an exact
//! integer; both triangles at an edge use the same numbers and decide alike. A point exactly on an edge or
//! corner is taken as moved by (epsilon, epsilon^2), smaller than everything (Edelsbrunner and Mücke 1990,
//! "Simulation of Simplicity"), so that it lies in exactly one of the triangles of a closed fan. Thus each
//! ray enters as often as it leaves. The height of a crossing is computed from the unmoved corners.

use std::ops::Range;

use proveout_geom::{Point, TriMesh};

use crate::{
    StockError,
    field::grid::RayGrid,
    field::span::{EndMark, INITIAL, MaterialSpan, SLIVER},
};

/// Step of the lattice for the inside test, mm: 2^-20, a nanometer. Exact for bodies up to 10 m.
const LATTICE: f64 = 1.0 / 1_048_576.0;
/// Crossings closer than this (mm) may change places by rounding without being called a self-crossing.
const SAME: f64 = 1e-6;

/// How shells that overlap are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shells {
    /// They may not: a ray that enters twice is an error.
    Apart,
    /// Their union counts: material is where the winding number is positive.
    Union,
}

struct Crossing {
    s: f64,
    /// +1: the ray leaves the body, -1: enters.
    leaves: i32,
    mark: EndMark,
}

fn snap(x: f64) -> i64 {
    (x / LATTICE).round() as i64
}

/// Twice the signed area of (a, b, p); on the line the sign that it has after the small move.
fn side(a: [i64; 2], b: [i64; 2], p: [i64; 2]) -> i64 {
    let product = |x: i64, y: i64| i128::from(x) * i128::from(y);
    let area = product(b[0] - a[0], p[1] - a[1]) - product(b[1] - a[1], p[0] - a[0]);
    if area != 0 {
        return area.signum() as i64;
    }
    // d(area) = (b - a) x (epsilon, epsilon^2)
    if b[1] != a[1] { -(b[1] - a[1]).signum() } else { (b[0] - a[0]).signum() }
}

/// A closed mesh as the rays of one set see it.
pub(crate) struct MeshOnRays<'a> {
    mesh: &'a TriMesh,
    grid: &'a RayGrid,
    a: usize,
    shells: Shells,
    /// Corners in the plane of the rays, on the lattice.
    flat: Vec<[i64; 2]>,
    /// Places of the rays along u and v, on the lattice.
    us: Vec<i64>,
    vs: Vec<i64>,
}

impl<'a> MeshOnRays<'a> {
    pub(crate) fn new(mesh: &'a TriMesh, grid: &'a RayGrid, a: usize, shells: Shells) -> Self {
        let (u, v) = ((a + 1) % 3, (a + 2) % 3);
        Self {
            mesh,
            grid,
            a,
            shells,
            flat: mesh.positions.iter().map(|p| [snap(p[u]), snap(p[v])]).collect(),
            us: (0..grid.n[u]).map(|i| snap(grid.center(u, i))).collect(),
            vs: (0..grid.n[v]).map(|j| snap(grid.center(v, j))).collect(),
        }
    }

    /// Rays along u (0) or v (1) that the box of a triangle holds.
    pub(crate) fn range(&self, t: usize, axis: usize) -> Range<usize> {
        let [p, q, r] = self.mesh.triangles[t].map(|c| self.flat[c as usize]);
        let low = p[axis].min(q[axis]).min(r[axis]);
        let high = p[axis].max(q[axis]).max(r[axis]);
        let centers = if axis == 0 { &self.us } else { &self.vs };
        centers.partition_point(|&c| c < low)..centers.partition_point(|&c| c <= high)
    }

    /// Material on the rays `rows` along v, u fastest; `triangles` are all that meet these rays, in rising
    /// order.
    pub(crate) fn intervals(
        &self,
        triangles: impl Iterator<Item = usize>,
        rows: Range<usize>,
    ) -> Result<Vec<Vec<MaterialSpan>>, StockError> {
        let (a, grid) = (self.a, self.grid);
        let (u, v) = ((a + 1) % 3, (a + 2) % 3);
        let nu = grid.n[u];
        let mut crossings: Vec<Vec<Crossing>> = Vec::new();
        crossings.resize_with(nu * rows.len(), Vec::new);
        for t in triangles {
            let [p, q, r] = self.mesh.triangles[t].map(|c| self.flat[c as usize]);
            // The triangle's own orientation is that of its exact area; seen edge-on it covers no point.
            let area =
                i128::from(q[0] - p[0]) * i128::from(r[1] - p[1]) - i128::from(q[1] - p[1]) * i128::from(r[0] - p[0]);
            if area == 0 {
                continue;
            }
            let (columns, lines) = (self.range(t, 0), self.range(t, 1));
            let turn = area.signum() as i64;
            let normal = self.mesh.area_normal(t);
            let mark = EndMark::new(INITIAL, normal.into());
            let corner = self.mesh.corners(t);
            for j in lines.start.max(rows.start)..lines.end.min(rows.end) {
                for i in columns.clone() {
                    let x = [self.us[i], self.vs[j]];
                    if [(p, q), (q, r), (r, p)].iter().all(|&(from, to)| side(from, to, x) == turn) {
                        let s = height(&corner, &normal.into(), a, [grid.center(u, i), grid.center(v, j)]);
                        crossings[(j - rows.start) * nu + i].push(Crossing { s, leaves: turn as i32, mark });
                    }
                }
            }
        }
        let mut rays = Vec::with_capacity(crossings.len());
        for (k, mut list) in crossings.into_iter().enumerate() {
            list.sort_by(|x, y| x.s.total_cmp(&y.s).then(x.leaves.cmp(&y.leaves)));
            let place = [grid.center(u, k % nu), grid.center(v, rows.start + k / nu)];
            rays.push(match self.shells {
                Shells::Union => union_of(&list),
                Shells::Apart => spans_of(&list).map_err(|s| StockError::SelfCrossing {
                    point: RayGrid::point(a, s, place[0], place[1]),
                    axis: ['x', 'y', 'z'][a],
                })?,
            });
        }
        Ok(rays)
    }
}

/// Material on each ray of set `a`, u fastest.
pub(crate) fn mesh_intervals(
    mesh: &TriMesh,
    grid: &RayGrid,
    a: usize,
    shells: Shells,
) -> Result<Vec<Vec<MaterialSpan>>, StockError> {
    MeshOnRays::new(mesh, grid, a, shells).intervals(0..mesh.triangles.len(), 0..grid.n[(a + 2) % 3])
}

/// Where the plane of a triangle meets the ray, kept within the triangle's height.
fn height(corner: &[Point; 3], normal: &[f64; 3], a: usize, at: [f64; 2]) -> f64 {
    let (u, v) = ((a + 1) % 3, (a + 2) % 3);
    let low = corner.iter().map(|c| c[a]).fold(f64::INFINITY, f64::min);
    let high = corner.iter().map(|c| c[a]).fold(f64::NEG_INFINITY, f64::max);
    let c = &corner[0];
    let s = c[a] - (normal[u] * (at[0] - c[u]) + normal[v] * (at[1] - c[v])) / normal[a];
    if s.is_finite() { s.clamp(low, high) } else { 0.5 * (low + high) }
}

/// Material where more shells were entered than left.
fn union_of(list: &[Crossing]) -> Vec<MaterialSpan> {
    let mut spans: Vec<MaterialSpan> = Vec::new();
    let mut depth = 0;
    let mut entry: Option<&Crossing> = None;
    for c in list {
        let before = depth;
        depth -= c.leaves;
        if before <= 0 && depth > 0 {
            entry = Some(c);
        } else if before > 0
            && depth <= 0
            && let Some(from) = entry.take()
        {
            match spans.last_mut() {
                Some(last) if from.s - last.hi <= SLIVER => (last.hi, last.hi_mark) = (c.s, c.mark),
                _ if c.s - from.s > SLIVER => {
                    spans.push(MaterialSpan { lo: from.s, hi: c.s, lo_mark: from.mark, hi_mark: c.mark });
                }
                _ => {}
            }
        }
    }
    spans
}

/// Pairs entries with exits; the error is the height where they do not alternate.
fn spans_of(list: &[Crossing]) -> Result<Vec<MaterialSpan>, f64> {
    let mut spans: Vec<MaterialSpan> = Vec::new();
    let mut open: Vec<&Crossing> = Vec::new();
    let mut early: Vec<&Crossing> = Vec::new(); // exits that rounding put before their entries
    for c in list {
        if c.leaves < 0 {
            if let Some(exit) = early.pop() {
                if c.s - exit.s > SAME {
                    return Err(exit.s);
                }
            } else {
                if let Some(entry) = open.last()
                    && c.s - entry.s > SAME
                {
                    return Err(c.s);
                }
                open.push(c);
            }
        } else {
            match open.pop() {
                Some(entry) => {
                    let hi = c.s;
                    match spans.last_mut() {
                        // Bodies that touch, or a fold of the mesh within rounding.
                        Some(last) if entry.s - last.hi <= SLIVER => {
                            (last.hi, last.hi_mark) = (hi.max(last.hi), c.mark)
                        }
                        _ if hi - entry.s > SLIVER => {
                            spans.push(MaterialSpan { lo: entry.s, hi, lo_mark: entry.mark, hi_mark: c.mark });
                        }
                        _ => {}
                    }
                }
                None => early.push(c),
            }
        }
    }
    match (open.first(), early.first()) {
        (Some(c), _) | (None, Some(c)) => Err(c.s),
        (None, None) => Ok(spans),
    }
}
