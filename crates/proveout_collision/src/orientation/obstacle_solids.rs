//! Solids as the search sees them: a tree of balls over their triangles.

use proveout_geom::{Point, TriMesh};

use super::BALL_ROUNDING;
use crate::parts::{MeshDemand, mesh_shape};
use crate::report::CollisionError;
use crate::shape::MeshShape;

/// Triangles with longer edges are halved along them, mm, or by the share of the solid's size:
/// balls round long ones do not locate them.
const LONGEST_EDGE_MM: f64 = 3.0;
const LONGEST_EDGE_SHARE: f64 = 0.01;

/// A ball that holds some triangles of a skin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BallNode {
    pub(crate) center: Point,
    pub(crate) radius: f64,
    /// A point of the skin near the center.
    pub(crate) anchor: Point,
    /// A triangle (leaf), or the first of two nodes.
    pub(crate) first: u32,
    pub(crate) leaf: bool,
}

/// A solid.
#[derive(Clone, Debug)]
pub(crate) struct ObstacleSolid {
    /// The cutter may touch it.
    pub(crate) cut: bool,
    pub(crate) nodes: Vec<BallNode>,
    pub(crate) triangles: Vec<[Point; 3]>,
    shape: MeshShape,
}

impl ObstacleSolid {
    pub(crate) fn new(name: &str, mesh: &TriMesh, cut: bool) -> Result<Self, CollisionError> {
        let shape = mesh_shape("solid", name, mesh, MeshDemand::Solid)?;
        let triangles = halved((0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect());
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let empty = BallNode { center: Point::origin(), radius: 0.0, anchor: Point::origin(), first: 0, leaf: true };
        let mut nodes = vec![empty];
        grow(&triangles, &mut order, &mut nodes, 0);
        Ok(Self { cut, nodes, triangles, shape })
    }

    pub(crate) fn contains(&self, p: &Point) -> bool {
        self.shape.contains(p)
    }

    /// Distance of a point from the skin, as far as it is below `limit`.
    pub(crate) fn skin_distance(&self, p: &Point, limit: f64) -> f64 {
        self.nearest(p, limit).map_or(limit, |q| (q - p).norm())
    }

    /// The point of the skin that is nearest to `p`; none where it is no nearer than `limit`.
    pub(crate) fn nearest(&self, p: &Point, limit: f64) -> Option<Point> {
        let (mut least, mut found) = (limit, None);
        let mut stack = vec![0_u32];
        while let Some(node) = stack.pop().and_then(|i| self.nodes.get(i as usize)) {
            if (node.center - p).norm() - node.radius >= least {
                continue;
            }
            if node.leaf {
                let q = closest(&self.triangles[node.first as usize], p);
                let far = (q - p).norm();
                if far < least {
                    (least, found) = (far, Some(q));
                }
            } else {
                let far = |i: u32| (self.nodes[i as usize].center - p).norm() - self.nodes[i as usize].radius;
                let (a, b) = (node.first, node.first + 1);
                stack.extend(if far(a) < far(b) { [b, a] } else { [a, b] });
            }
        }
        found
    }
}

/// The same faces with no edge longer than the limit.
fn halved(triangles: Vec<[Point; 3]>) -> Vec<[Point; 3]> {
    let all = || triangles.iter().flatten();
    let Some(first) = all().next() else { return triangles };
    let (low, high) = all().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let limit = LONGEST_EDGE_MM.max(LONGEST_EDGE_SHARE * (high - low).norm());
    let mut out = Vec::with_capacity(triangles.len());
    let mut stack = triangles;
    stack.reverse();
    while let Some([a, b, c]) = stack.pop() {
        // Turned so that the first edge is the longest.
        let [x, y, z] = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
        let [a, b, c] = if x >= y && x >= z {
            [a, b, c]
        } else if y >= z {
            [b, c, a]
        } else {
            [c, a, b]
        };
        if x.max(y).max(z) > limit {
            let m = nalgebra::center(&a, &b);
            stack.extend([[a, m, c], [m, b, c]]);
        } else {
            out.push([a, b, c]);
        }
    }
    out
}

/// Makes the node `index` of the triangles in `order` and what is below it.
fn grow(triangles: &[[Point; 3]], order: &mut [u32], nodes: &mut Vec<BallNode>, index: usize) {
    let corners = |order: &[u32]| order.iter().flat_map(|&t| triangles[t as usize]).collect::<Vec<_>>();
    let all = corners(order);
    let (mut low, mut high) = (all[0], all[0]);
    for p in &all {
        (low, high) = (low.inf(p), high.sup(p));
    }
    let center = nalgebra::center(&low, &high);
    let radius = all.iter().map(|p| (p - center).norm()).fold(0.0, f64::max);
    let first_anchor = if let [only] = order { closest(&triangles[*only as usize], &center) } else { all[0] };
    let anchor = all.iter().fold(first_anchor, |a, p| if (p - center).norm() < (a - center).norm() { *p } else { a });
    // Rounding of the center must not leave a corner out.
    let radius = radius * (1.0 + BALL_ROUNDING) + BALL_ROUNDING;
    if let [only] = order {
        nodes[index] = BallNode { center, radius, anchor, first: *only, leaf: true };
        return;
    }
    let axis = (high - low).imax();
    let middle = order.len() / 2;
    let place = |t: &u32| triangles[*t as usize].iter().map(|p| p[axis]).sum::<f64>();
    order.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)).then(a.cmp(b)));
    let first = nodes.len();
    let empty = nodes[index];
    nodes.extend([empty, empty]);
    nodes[index] = BallNode { center, radius, anchor, first: first as u32, leaf: false };
    let (left, right) = order.split_at_mut(middle);
    grow(triangles, left, nodes, first);
    grow(triangles, right, nodes, first + 1);
}

/// The point of a triangle nearest to `p`.
pub(crate) fn closest(triangle: &[Point; 3], p: &Point) -> Point {
    let [a, b, c] = triangle;
    let normal = (b - a).cross(&(c - a));
    let square = normal.norm_squared();
    let edges = [(a, b), (b, c), (c, a)];
    if square > 0.0 && edges.iter().all(|(u, v)| normal.dot(&(*v - *u).cross(&(p - *u))) >= 0.0) {
        return p - normal * (normal.dot(&(p - a)) / square);
    }
    let mut best = *a;
    for (u, v) in edges {
        let d = v - u;
        let length2 = d.norm_squared();
        let t = if length2 > 0.0 { ((p - u).dot(&d) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let q = u + d * t;
        if (q - p).norm_squared() < (best - p).norm_squared() {
            best = q;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, box_mesh, revolved_mesh};

    use super::*;

    #[test]
    fn balls_hold_their_triangles_and_distances_are_those_of_all_triangles() {
        let ring = revolved_mesh(&[[0.0, 0.0], [20.0, 0.0], [14.0, 4.0], [0.0, 9.0]], 48);
        let solid = ObstacleSolid::new("ring", &ring, true).expect("solid");
        assert_eq!(solid.nodes.len(), 2 * solid.triangles.len() - 1);
        let area = |t: &[Point; 3]| 0.5 * (t[1] - t[0]).cross(&(t[2] - t[0])).norm();
        let whole: f64 = (0..ring.triangles.len()).map(|t| area(&ring.corners(t))).sum();
        assert!((solid.triangles.iter().map(area).sum::<f64>() - whole).abs() < 1e-9 * whole);
        assert!(solid.triangles.iter().all(|[a, b, c]| (b - a).norm().max((c - b).norm()).max((a - c).norm()) <= 3.0));
        fn below(solid: &ObstacleSolid, i: u32, out: &mut Vec<u32>) {
            let node = solid.nodes[i as usize];
            if node.leaf {
                out.push(node.first);
            } else {
                below(solid, node.first, out);
                below(solid, node.first + 1, out);
            }
        }
        for (i, node) in solid.nodes.iter().enumerate() {
            let mut leaves = Vec::new();
            below(&solid, i as u32, &mut leaves);
            assert!(
                leaves
                    .iter()
                    .flat_map(|&t| solid.triangles[t as usize])
                    .all(|p| (p - node.center).norm() <= node.radius)
            );
            let skin = solid.triangles.iter().map(|t| (closest(t, &node.anchor) - node.anchor).norm());
            assert!(skin.fold(f64::MAX, f64::min) < 1e-9, "an anchor lies on the skin");
        }
        for k in 0..300 {
            let a = 0.37 * f64::from(k);
            let p = Point::new(25.0 * a.cos(), 18.0 * (1.3 * a).sin(), 12.0 * (0.7 * a).sin());
            let brute = solid.triangles.iter().map(|t| (closest(t, &p) - p).norm()).fold(f64::MAX, f64::min);
            assert!((solid.skin_distance(&p, 1e9) - brute).abs() < 1e-12);
            assert!((solid.skin_distance(&p, 2.0) - brute.min(2.0)).abs() < 1e-12);
        }
        let block = Aabb { min: Point::new(-1.0, -2.0, -3.0), max: Point::new(1.0, 2.0, 3.0) };
        let block = ObstacleSolid::new("block", &box_mesh(&block), false).expect("solid");
        assert!((block.skin_distance(&Point::new(3.0, 4.0, 3.5), 9.0) - (4.0_f64 + 4.0 + 0.25).sqrt()).abs() < 1e-12);
        assert!(block.contains(&Point::new(0.9, 1.9, 2.9)) && !block.contains(&Point::new(1.1, 0.0, 0.0)));
    }
}
