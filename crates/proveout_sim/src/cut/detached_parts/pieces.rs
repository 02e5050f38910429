//! A body in convex pieces, with the error of its shape.
//!
//! The hull of a convex body is the body. A body that is not convex is cut at the vertex that lies deepest
//! below the hull, along the axis that leaves the least volume in the hulls of both sides, until no vertex
//! lies deeper than the tolerance:
//!
//! ```text
//!     .________           .________             .___
//!     |     ___|          |  hull .|            |   |____
//!     |    |       ->     |    |.'       ->     |   |____|   two hulls, each a box
//!     |____|              |____|                |___|
//!           the inner corner lies deepest
//! ```
//!
//! Each side is the mesh cut at the planes, with those corners of the cut that lie in material: its
//! hull is the hull of that part of the body. The excess of the hulls is reported as the error.

use proveout_geom::{Aabb, Point, Vector};
use proveout_stock::{SurfaceMesh, TriDexel};

use super::{SAME_MM, rapier_world::hull, world::Hull};

/// Pieces of a body at most; a body that needs more is given with the error that is left.
const MOST_PIECES: usize = 48;
/// Twice the area below which a face of a hull has no normal, mm2.
const LEAST_FACE: f64 = 1e-12;

/// Half of the gap between the sides of a cut, mm: a face that is off the cut by a rounding error
/// leaves no sliver on its other side.
const GAP_MM: f64 = 1e-3;

/// Convex pieces of a body.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    /// Corners of each, mm.
    pub(super) pieces: Vec<Vec<Point>>,
    /// Largest depth of a vertex of the body's mesh below the hull that holds it, mm.
    pub(super) error: f64,
}

/// A stretch of the body within a box.
struct Chunk {
    bounds: Aabb,
    hull: Hull,
    /// The vertex that lies deepest below the hull, and how deep.
    deepest: (Point, f64),
}

/// Outward normal and distance from the origin of each face.
fn planes(hull: &Hull) -> Vec<(Vector, f64)> {
    let face = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| hull.points[i as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(LEAST_FACE)?;
        Some((normal, normal.dot(&a.coords)))
    };
    hull.triangles.iter().filter_map(face).collect()
}

fn volume(hull: &Hull) -> f64 {
    let Some(from) = hull.points.first() else { return 0.0 };
    let part = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| hull.points[i as usize] - from);
        a.dot(&b.cross(&c)) / 6.0
    };
    hull.triangles.iter().map(part).sum()
}

impl Chunk {
    fn new(surface: &SurfaceMesh, stock: &TriDexel, bounds: Aabb) -> Option<Self> {
        let cut = surface.inside(&bounds);
        let mut used = vec![false; cut.mesh.positions.len()];
        cut.mesh.triangles.iter().flatten().for_each(|&i| used[i as usize] = true);
        let mut points: Vec<Point> =
            cut.mesh.positions.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p).collect();
        let skin = points.len();
        for k in 0..8 {
            let side = |c: usize| if k >> c & 1 == 0 { bounds.min[c] } else { bounds.max[c] };
            let corner = Point::new(side(0), side(1), side(2));
            if holds(stock, &corner) {
                points.push(corner);
            }
        }
        let hull = hull(&points)?;
        let planes = planes(&hull);
        let depth = |p: &Point| planes.iter().map(|(n, d)| d - n.dot(&p.coords)).fold(f64::INFINITY, f64::min);
        // Vertices on the planes of the cut lie on the hull or in material.
        let inner = |p: &Point| (0..3).all(|c| p[c] > bounds.min[c] + SAME_MM && p[c] < bounds.max[c] - SAME_MM);
        let deepest = points[..skin].iter().filter(|p| inner(p)).map(|p| (*p, depth(p)));
        let deepest = deepest.fold((bounds.center(), 0.0), |best, d| if d.1 > best.1 { d } else { best });
        Some(Self { bounds, hull, deepest })
    }

    /// Both sides of the best cut through the deepest vertex; none where every cut leaves a side empty.
    fn split(&self, surface: &SurfaceMesh, stock: &TriDexel) -> Option<[Self; 2]> {
        let mut best: Option<(f64, [Self; 2])> = None;
        for axis in 0..3 {
            let at = self.deepest.0[axis];
            let [mut low, mut high] = [self.bounds; 2];
            (low.max[axis], high.min[axis]) = (at - GAP_MM, at + GAP_MM);
            let sides = [low, high].map(|b| Self::new(surface, stock, b));
            let [Some(one), Some(other)] = sides else { continue };
            let both = volume(&one.hull) + volume(&other.hull);
            if best.as_ref().is_none_or(|(least, _)| both < *least) {
                best = Some((both, [one, other]));
            }
        }
        best.map(|(_, sides)| sides)
    }
}

/// Whether a point lies in the material, by the nearest ray along z.
fn holds(stock: &TriDexel, p: &Point) -> bool {
    let (_, spans) = stock.intervals_on(2, p.x, p.y);
    spans.iter().any(|s| s.lo <= p.z && p.z <= s.hi)
}

/// Convex pieces of all material of a stock; none where it has no volume.
pub(super) fn pieces(stock: &TriDexel, surface: &SurfaceMesh, tolerance: f64) -> Option<Pieces> {
    let bounds = surface.mesh.aabb().expanded(1.0);
    let mut chunks = vec![Chunk::new(surface, stock, bounds)?];
    let mut whole = Vec::new();
    while let Some(worst) = deepest(&chunks, tolerance).filter(|_| chunks.len() + whole.len() < MOST_PIECES) {
        let chunk = chunks.swap_remove(worst);
        match chunk.split(surface, stock) {
            Some(sides) => chunks.extend(sides),
            None => whole.push(chunk),
        }
    }
    chunks.extend(whole);
    let error = chunks.iter().map(|c| c.deepest.1).fold(0.0, f64::max);
    Some(Pieces { pieces: chunks.into_iter().map(|c| c.hull.points).collect(), error })
}

/// The chunk with the deepest vertex, where that is too deep.
fn deepest(chunks: &[Chunk], tolerance: f64) -> Option<usize> {
    let all = chunks.iter().enumerate().filter(|(_, c)| c.deepest.1 > tolerance);
    all.max_by(|a, b| a.1.deepest.1.total_cmp(&b.1.deepest.1)).map(|(k, _)| k)
}

#[cfg(test)]
mod tests {
    use proveout_geom::box_mesh;

    use super::*;

    fn body(boxes: &[[[f64; 3]; 2]]) -> TriDexel {
        let mut mesh = proveout_geom::TriMesh::default();
        for [min, max] in boxes {
            mesh.append(&box_mesh(&Aabb { min: Point::from(*min), max: Point::from(*max) }));
        }
        TriDexel::from_mesh(&mesh, 0.5, 1 << 30).unwrap()
    }

    #[test]
    fn a_box_is_one_piece_and_an_angle_is_two() {
        let block = body(&[[[0.0; 3], [10.0, 6.0, 4.0]]]);
        let one = pieces(&block, &block.surface(), 0.25).unwrap();
        assert_eq!(one.pieces.len(), 1);
        assert!(one.error < 1e-6, "{}", one.error);
        // An angle of one mesh: a box with a corner cut out by a tool is shown by the run; here it is a mesh.
        let angle = angle();
        let two = pieces(&angle, &angle.surface(), 0.25).unwrap();
        assert!(two.pieces.len() == 2 && two.error <= 0.25, "{} {}", two.pieces.len(), two.error);
        let sum: f64 = two.pieces.iter().map(|p| volume(&hull(p).unwrap())).sum();
        assert!((sum / angle.volume() - 1.0).abs() < 0.01, "{sum} {}", angle.volume());
    }

    /// An L of 10 x 10 mm with legs of 3 mm, 5 mm high.
    fn angle() -> TriDexel {
        let at = [[0.0, 0.0], [10.0, 0.0], [10.0, 3.0], [3.0, 3.0], [3.0, 10.0], [0.0, 10.0]];
        let mut mesh = proveout_geom::TriMesh::default();
        for z in [0.0, 5.0] {
            mesh.positions.extend(at.iter().map(|p| Point::new(p[0], p[1], z)));
        }
        for k in 0..6_u32 {
            let n = (k + 1) % 6;
            mesh.triangles.extend([[k, n, n + 6], [k, n + 6, k + 6]]);
        }
        for t in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
            mesh.triangles.push([t[0], t[2], t[1]]);
            mesh.triangles.push(t.map(|i| i + 6));
        }
        TriDexel::from_mesh(&mesh, 0.5, 1 << 30).unwrap()
    }
}
