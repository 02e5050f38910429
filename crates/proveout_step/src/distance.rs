//! The largest distance of points from a mesh.
//!
//! A point of the exact surface belongs to a triangle, but the nearest one may be another: at the pole of a
//! sphere a thin triangle passes its points at 69 micrometers, its neighbor at 7. So the distance to the own
//! triangle is only an upper bound. Points are taken by falling bound; a point is looked up in a tree of
//! boxes only while its bound exceeds the largest distance so far, and the search ends as soon as it cannot
//! exceed it.

use proveout_geom::{Aabb, Point, TriMesh, Vector};

/// Triangles of a leaf.
const LEAF: usize = 4;

/// A point with an upper bound of its squared distance from the mesh, mm².
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundedPoint {
    pub(crate) point: Point,
    pub(crate) bound: f64,
}

impl BoundedPoint {
    /// A point that belongs to a triangle.
    pub(crate) fn of_triangle(point: Point, corners: &[Point; 3]) -> Self {
        Self { point, bound: squared_distance(&point, corners) }
    }

    /// A point of which nothing is known.
    pub(crate) fn unbounded(point: Point) -> Self {
        Self { point, bound: f64::INFINITY }
    }
}

/// The largest distance of points from the nearest triangle of a mesh, mm, with the point that has it. None
/// without points.
pub(crate) fn largest_distance(mesh: &TriMesh, mut points: Vec<BoundedPoint>) -> Option<(f64, Point)> {
    let tree = BoxTree::new(mesh);
    points.sort_by(|a, b| b.bound.total_cmp(&a.bound));
    let mut worst: Option<(f64, Point)> = None;
    for BoundedPoint { point, bound } in points {
        let least = worst.map_or(-1.0, |w| w.0);
        if bound <= least {
            break;
        }
        let found = tree.nearest(mesh, &point, bound, least);
        if found > least {
            worst = Some((found, point));
        }
    }
    worst.map(|(squared, point)| (squared.sqrt(), point))
}

/// Squared distance of a point from a triangle. A triangle without area is its edges.
fn squared_distance(p: &Point, [a, b, c]: &[Point; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let inside = |from: &Point, to: &Point| normal.dot(&(to - from).cross(&(p - from))) >= 0.0;
    let area = normal.norm_squared();
    if area > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        let height = normal.dot(&(p - a));
        return height * height / area;
    }
    [(a, b), (b, c), (c, a)]
        .map(|(from, to)| squared_from_edge(p, from, &(to - from)))
        .into_iter()
        .fold(f64::MAX, f64::min)
}

fn squared_from_edge(p: &Point, from: &Point, way: &Vector) -> f64 {
    let length = way.norm_squared();
    let share = if length > 0.0 { ((p - from).dot(way) / length).clamp(0.0, 1.0) } else { 0.0 };
    (p - (from + way * share)).norm_squared()
}

/// Boxes round triangles, halved at the median of their middles.
struct BoxTree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

struct Node {
    bounds: Aabb,
    /// First child of an inner node, whose second one follows it; first place in the order of a leaf.
    first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    count: u32,
}

impl BoxTree {
    fn new(mesh: &TriMesh) -> Self {
        let middles: Vec<Point> = (0..mesh.triangles.len())
            .map(|t| Point::from(mesh.corners(t).iter().fold(Vector::zeros(), |sum, p| sum + p.coords) / 3.0))
            .collect();
        let mut tree = Self { nodes: Vec::new(), order: (0..mesh.triangles.len() as u32).collect() };
        tree.nodes.push(Node { bounds: mesh.aabb(), first: 0, count: tree.order.len() as u32 });
        let mut open = vec![0];
        while let Some(at) = open.pop() {
            open.extend(tree.split(mesh, &middles, at).into_iter().flatten());
        }
        tree
    }

    /// Fills in the box of a node, and halves it where it has more triangles than a leaf may.
    fn split(&mut self, mesh: &TriMesh, middles: &[Point], at: usize) -> Option<[usize; 2]> {
        let Node { first, count, .. } = self.nodes[at];
        let own = &mut self.order[first as usize..(first + count) as usize];
        let corners: Vec<Point> = own.iter().flat_map(|t| mesh.corners(*t as usize)).collect();
        self.nodes[at].bounds = Aabb::of_points(&corners);
        if own.len() <= LEAF {
            return None;
        }
        let size = Aabb::of_points(&own.iter().map(|t| middles[*t as usize]).collect::<Vec<_>>()).size();
        let axis = size.imax();
        let half = own.len() / 2;
        own.select_nth_unstable_by(half, |a, b| {
            middles[*a as usize][axis].total_cmp(&middles[*b as usize][axis]).then(a.cmp(b))
        });
        let (left, half) = (self.nodes.len(), half as u32);
        let bounds = self.nodes[at].bounds;
        self.nodes.push(Node { bounds, first, count: half });
        self.nodes.push(Node { bounds, first: first + half, count: count - half });
        (self.nodes[at].first, self.nodes[at].count) = (left as u32, 0);
        Some([left, left + 1])
    }

    /// Squared distance of a point from the nearest triangle, where it is above `least`; any value up to
    /// `least` otherwise. It is at most `bound`.
    fn nearest(&self, mesh: &TriMesh, point: &Point, bound: f64, least: f64) -> f64 {
        let mut best = bound;
        let mut open = vec![0_usize];
        while let Some(at) = open.pop() {
            let node = &self.nodes[at];
            if squared_from_box(point, &node.bounds) >= best {
                continue;
            }
            if node.count == 0 {
                let children = [node.first as usize, node.first as usize + 1];
                let [a, b] = children.map(|c| squared_from_box(point, &self.nodes[c].bounds));
                open.extend(if a < b { [children[1], children[0]] } else { children });
                continue;
            }
            for t in &self.order[node.first as usize..(node.first + node.count) as usize] {
                best = best.min(squared_distance(point, &mesh.corners(*t as usize)));
            }
            if best <= least {
                return best;
            }
        }
        best
    }
}

fn squared_from_box(p: &Point, b: &Aabb) -> f64 {
    (b.min - p).sup(&(p - b.max)).map(|x| x.max(0.0)).norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proveout_geom::cylinder_mesh;

    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn point(&mut self, size: f64) -> Point {
            let mut next = || size * (self.next() - 0.5);
            Point::new(next(), next(), next())
        }
    }

    /// Minimum over a fine grid of the triangle: never below the distance, and near it.
    fn by_grid(p: &Point, [a, b, c]: &[Point; 3]) -> f64 {
        const STEPS: usize = 200;
        let mut best = f64::INFINITY;
        for i in 0..=STEPS {
            for k in 0..=STEPS - i {
                let [u, v] = [i, k].map(|n| n as f64 / STEPS as f64);
                best = best.min((p - (a + (b - a) * u + (c - a) * v)).norm());
            }
        }
        best
    }

    #[test]
    fn the_distance_from_a_triangle_is_that_of_a_search_over_it() {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        for _ in 0..60 {
            let corners = [random.point(2.0), random.point(2.0), random.point(2.0)];
            let p = random.point(4.0);
            let (found, searched) = (squared_distance(&p, &corners).sqrt(), by_grid(&p, &corners));
            // A cell of the grid has edges of at most 2 * sqrt(3) / 200.
            assert!(found <= searched + 1e-12 && searched - found < 0.02, "{found} and {searched}");
        }
        let needle = [Point::origin(), Point::new(2.0, 0.0, 0.0), Point::new(1.0, 0.0, 0.0)];
        assert_eq!(squared_distance(&Point::new(1.0, 3.0, 0.0), &needle), 9.0);
    }

    #[test]
    fn the_largest_distance_is_that_of_all_points_from_all_triangles() {
        let mut random = Random(7);
        for case in 0..20 {
            let mesh = cylinder_mesh(3.0, -2.0, 2.0, 5 + case);
            let points: Vec<Point> = (0..80).map(|_| random.point(9.0)).collect();
            let from = |p: &Point| {
                (0..mesh.triangles.len()).map(|t| squared_distance(p, &mesh.corners(t))).fold(f64::MAX, f64::min)
            };
            let slow = points.iter().map(from).fold(0.0, f64::max).sqrt();
            let bounded = points.iter().enumerate().map(|(k, p)| match k % 2 {
                0 => BoundedPoint::unbounded(*p),
                _ => BoundedPoint::of_triangle(*p, &mesh.corners(k % mesh.triangles.len())),
            });
            let (found, at) = largest_distance(&mesh, bounded.collect()).expect("points");
            assert!((found - slow).abs() < 1e-12, "case {case}: {found} and {slow}");
            assert!((from(&at).sqrt() - slow).abs() < 1e-12, "case {case}: the place");
        }
        assert!(largest_distance(&cylinder_mesh(1.0, 0.0, 1.0, 8), Vec::new()).is_none());
    }
}
