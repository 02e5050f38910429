//! Distance of a mesh from the material on the rays: both trees at once with a shrinking bound.

use proveout_geom::{Aabb, Point, Pose, Vector};
use proveout_stock::{RaySegment, TileNode, TileTree, TriDexel};

use super::segment::segment_triangle;
use crate::box_tree::{BoxTree, Branch};
use crate::shape::{MeshShape, from_parry, to_parry};
use crate::triangle_tree::TriangleTree;

/// Material that counts: what lies on one side of a plane, where one is given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfSpace {
    pub(crate) normal: Vector,
    /// Points with `normal * p` at or above it count, mm.
    pub(crate) offset: f64,
}

impl HalfSpace {
    /// The part of a triangle that counts, in triangles: none, one or two.
    pub(crate) fn part_of(&self, triangle: &[Point; 3]) -> Vec<[Point; 3]> {
        let mut outline: Vec<Point> = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            let [of_a, of_b] = [a, b].map(|p| self.normal.dot(&p.coords) - self.offset);
            if of_a >= 0.0 {
                outline.push(a);
            }
            if (of_a >= 0.0) != (of_b >= 0.0) {
                outline.push(a + (b - a) * (of_a / (of_a - of_b)));
            }
        }
        (2..outline.len()).map(|k| [outline[0], outline[k - 1], outline[k]]).collect()
    }
}

/// The stock as it is asked. Frame of the stock, W.
#[derive(Clone, Copy)]
pub(crate) struct Rays<'a> {
    pub(crate) stock: &'a TriDexel,
    pub(crate) tree: &'a TileTree,
    pub(crate) counts: Option<HalfSpace>,
}

/// Nearest points of a body and the material on rays, in W.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearRay {
    /// mm; zero where a ray's material meets the skin.
    pub(crate) distance: f64,
    pub(crate) on_body: Point,
    pub(crate) on_ray: Point,
}

/// Nearest points of the skin of a body and the material on the rays, where they are nearer than
/// `limit` (mm).
///
/// Pairs of boxes are opened nearest first, the larger of the two; a pair that is as far as the
/// best distance so far is left. So a few boxes suffice for a body that is farther than the limit.
pub(crate) fn nearest(body: &TriangleTree, work_from_body: &Pose, rays: &Rays<'_>, limit: f64) -> Option<NearRay> {
    let whole = body.root()?;
    let turn = work_from_body.rotation.abs();
    let boxed = |node: u32| {
        let (middle, half) = body.bounds(node);
        let (middle, half) = (work_from_body.point(&middle), turn * half);
        Aabb { min: middle - half, max: middle + half }
    };
    let mut search = RaySearch { rays, best: limit, found: None };
    let mut open: Vec<(f64, u32, Aabb, TileNode)> = Vec::with_capacity(64);
    let root = boxed(whole);
    for tile in rays.tree.roots() {
        let apart = apart(&root, rays.tree.bounds(tile));
        open.push((apart, whole, root, tile));
    }
    farthest_first(&mut open);
    while let Some((bound, node, own, tile)) = open.pop() {
        // An empty box is infinitely far.
        if bound.is_nan() || bound >= search.best {
            continue;
        }
        let first = open.len();
        match body.open(node) {
            Branch::Leaf(items) if rays.tree.is_tile(tile) => {
                items.for_each(|item| search.leaf(body.corners(item), work_from_body, tile));
                if search.best <= 0.0 {
                    break;
                }
            }
            Branch::Two(one, other)
                if rays.tree.is_tile(tile) || own.size().max() >= rays.tree.bounds(tile).size().max() =>
            {
                for child in [one, other] {
                    let own = boxed(child);
                    open.push((apart(&own, rays.tree.bounds(tile)), child, own, tile));
                }
            }
            _ => {
                for child in rays.tree.children(tile) {
                    open.push((apart(&own, rays.tree.bounds(child)), node, own, child));
                }
            }
        }
        farthest_first(&mut open[first..]);
    }
    search.found
}

fn farthest_first(open: &mut [(f64, u32, Aabb, TileNode)]) {
    open.sort_unstable_by(|x, y| y.0.total_cmp(&x.0));
}

/// Distance of two boxes, mm.
fn apart(a: &Aabb, b: &Aabb) -> f64 {
    let mut square = 0.0;
    for i in 0..3 {
        let d = (a.min[i] - b.max[i]).max(b.min[i] - a.max[i]).max(0.0);
        square += d * d;
    }
    square.sqrt()
}

struct RaySearch<'a> {
    rays: &'a Rays<'a>,
    best: f64,
    found: Option<NearRay>,
}

impl RaySearch<'_> {
    fn leaf(&mut self, triangle: &[Point; 3], work_from_body: &Pose, tile: TileNode) {
        let rays = *self.rays;
        let corners = triangle.map(|p| work_from_body.point(&p));
        let round = Aabb::of_points(&corners);
        rays.tree.segments(rays.stock, tile, &round.expanded(self.best), |segment| {
            let Some(ends) = counted(&segment, rays.counts.as_ref()) else { return };
            if apart(&round, &Aabb { min: ends[0], max: ends[1] }) >= self.best {
                return;
            }
            let (distance, on_ray, on_body) = segment_triangle(ends, &corners);
            if distance < self.best {
                self.best = distance;
                self.found = Some(NearRay { distance, on_body, on_ray });
            }
        });
    }
}

/// Ends of the part of a segment that counts.
fn counted(segment: &RaySegment, counts: Option<&HalfSpace>) -> Option<[Point; 2]> {
    let (mut lo, mut hi) = (segment.lo, segment.hi);
    if let Some(plane) = counts {
        let [low, high] = [lo, hi].map(|p| plane.normal.dot(&p.coords) - plane.offset);
        if low < 0.0 && high < 0.0 {
            return None;
        }
        if low < 0.0 || high < 0.0 {
            let crossing = lo + (hi - lo) * (low / (low - high));
            if low < 0.0 { lo = crossing } else { hi = crossing }
        }
    }
    Some([lo, hi])
}

/// A point of the material inside of a body whose skin no ray's material meets, in W.
///
/// Round a point of the material lies a ball as large as its distance from the skin, and all material in it
/// is on the same side of it. So one winding number answers for a box of the tree that its ball holds, and
/// boxes far from the skin are not opened.
pub(crate) fn material_inside(mesh: &MeshShape, body_from_work: &Pose, rays: &Rays<'_>) -> Option<Point> {
    let everywhere = Aabb { min: Point::from([f64::NEG_INFINITY; 3]), max: Point::from([f64::INFINITY; 3]) };
    let skin = mesh.tree.local_aabb();
    let skin = Aabb { min: from_parry(skin.mins), max: from_parry(skin.maxs) };
    let turn = body_from_work.rotation.abs();
    let mut open: Vec<TileNode> = rays.tree.roots().into();
    let mut found = None;
    while let (Some(node), None) = (open.pop(), found) {
        let bounds = rays.tree.bounds(node);
        if bounds.is_empty() {
            continue;
        }
        let middle = body_from_work.point(&nalgebra::center(&bounds.min, &bounds.max));
        let half = turn * bounds.size() * 0.5;
        if apart(&Aabb { min: middle - half, max: middle + half }, &skin) > 0.0 {
            continue;
        }
        // Points already known to be outside, with their distance from the skin.
        let mut outside: Option<(Point, f64)> = None;
        let mut see = |segment: RaySegment| {
            let Some([lo, hi]) = counted(&segment, rays.counts.as_ref()) else { return };
            let p = nalgebra::center(&lo, &hi);
            if found.is_some() || outside.is_some_and(|(q, d)| (p - q).norm() <= d) {
                return;
            }
            let local = body_from_work.point(&p);
            if mesh.contains(&local) {
                found = Some(p);
            } else {
                outside = Some((p, mesh.distance_to_skin(&local)));
            }
        };
        if rays.tree.is_tile(node) {
            rays.tree.segments(rays.stock, node, &everywhere, &mut see);
            continue;
        }
        let Some(tile) = some_tile(rays.tree, node) else { continue };
        let mut first = None;
        rays.tree.segments(rays.stock, tile, &everywhere, |s| first = first.or(Some(s)));
        if let Some(segment) = first {
            see(segment);
        }
        let farthest = |p: &Point| (p - bounds.min).abs().sup(&(p - bounds.max).abs()).norm();
        if found.is_none() && outside.is_none_or(|(p, d)| farthest(&p) > d) {
            open.extend(rays.tree.children(node));
        }
    }
    found
}

/// A tile under a box.
fn some_tile(tree: &TileTree, mut node: TileNode) -> Option<TileNode> {
    while !tree.is_tile(node) {
        node = tree.children(node).next()?;
    }
    Some(node)
}

/// Points of the material tried for the estimate of the penetration.
const MOST_POINTS: usize = 400;

/// Depth of the material on the rays in a body, mm: the largest depth of points of it; a lower
/// estimate.
pub(crate) fn penetration(mesh: &MeshShape, work_from_body: &Pose, rays: &Rays<'_>) -> f64 {
    let Some(root) = mesh.boxes.root() else { return 0.0 };
    let (middle, half) = mesh.boxes.bounds(root);
    let (middle, half) = (work_from_body.point(&middle), work_from_body.rotation.abs() * half);
    let region = Aabb { min: middle - half, max: middle + half };
    let body_from_work = work_from_body.inverse();
    let mut points = Vec::new();
    let mut open: Vec<TileNode> = rays.tree.roots().into();
    while let Some(node) = open.pop() {
        if !rays.tree.bounds(node).intersects(&region) {
            continue;
        }
        rays.tree.segments(rays.stock, node, &region, |segment| {
            if let Some([lo, hi]) = counted(&segment, rays.counts.as_ref()) {
                let (lo, hi) = (lo.sup(&region.min).inf(&region.max), hi.sup(&region.min).inf(&region.max));
                points.extend([lo, nalgebra::center(&lo, &hi), hi]);
            }
        });
        open.extend(rays.tree.children(node));
    }
    // Three points a segment: no multiple of three, which would take the same one of each.
    let stride = points.len().div_ceil(MOST_POINTS).max(1);
    let stride = if stride % 3 == 0 { stride + 1 } else { stride };
    let depth = |p: &Point| {
        let local = to_parry(&body_from_work.point(p));
        if !mesh.tree.local_aabb().contains_local_point(local) { 0.0 } else { mesh.depth(local) }
    };
    points.iter().step_by(stride).map(depth).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The part above a plane has the area that a closed form gives it, whichever corner lies above.
    #[test]
    fn a_triangle_is_cut_at_the_plane() {
        let [low, high, aside] = [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]].map(Point::from);
        let area = |ts: &[[Point; 3]]| -> f64 { ts.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum() };
        for turned in [[low, high, aside], [high, aside, low], [aside, low, high]] {
            for (offset, left) in [(1.0, 4.5), (3.0, 0.5), (-1.0, 8.0), (5.0, 0.0)] {
                let parts = HalfSpace { normal: Vector::z(), offset }.part_of(&turned);
                assert!((area(&parts) - left).abs() < 1e-12, "{offset}: {parts:?}");
                assert!(parts.iter().flatten().all(|p| p.z >= offset - 1e-12), "{offset}: {parts:?}");
            }
        }
    }
}
