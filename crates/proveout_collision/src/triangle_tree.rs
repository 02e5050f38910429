//! Triangles in a tree of boxes, each along the axes, and once more along the wall that its triangles make.
//!
//! A box along the axes is fat about a face that leans. A tool that slides along a wall has all boxes near
//! it, and each of their triangles would have to be asked. So every node also has a box along the mean of its
//! normals:
//!
//! ```text
//!         ___--~~~--___           of a patch r wide of a surface with radius R it is r2 / 2R thick,
//!     _--~  patch      ~--_       of a single triangle it has no thickness at all
//!    '---------------------'
//! ```
//!
//! Two planes across the way from it to a point of the other body's middle, one on the box and one on that
//! body, prove a distance; of a ball it is the distance from the box itself.

use nalgebra::Matrix3;
use proveout_geom::{Point, TriMesh, Vector};

use crate::box_tree::{BoxTree, Branch};

/// Part of the longest edge that must lie across the mean normal to give a direction.
const ACROSS: f64 = 1e-9;

/// Triangles in a tree of boxes.
#[derive(Clone, Debug)]
pub(crate) struct TriangleTree {
    nodes: Vec<TriangleNode>,
    /// One for each node.
    leans: Vec<WallBox>,
    /// Corners, in the order of the leaves.
    triangles: Vec<[Point; 3]>,
}

#[derive(Clone, Copy, Debug)]
struct TriangleNode {
    middle: Point,
    half: Vector,
    /// First item of a leaf, or first of two nodes in a row.
    first: u32,
    /// Number of items; zero for a node with two others.
    count: u32,
}

/// The box of a node along its wall.
#[derive(Clone, Copy, Debug)]
struct WallBox {
    middle: Point,
    /// Its directions: the last one across the wall, the first one along its longest way.
    axes: Matrix3<f64>,
    half: Vector,
}

impl WallBox {
    fn of(triangles: &[[Point; 3]]) -> Self {
        let across = |[a, b, c]: &[Point; 3]| (b - a).cross(&(c - a));
        let sum = triangles.iter().fold(Vector::zeros(), |sum, t| sum + across(t));
        let longest = triangles.iter().flat_map(|[a, b, c]| [b - a, c - b, a - c]);
        let longest =
            longest.max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared())).unwrap_or_else(Vector::zeros);
        let frame = sum.try_normalize(f64::MIN_POSITIVE).and_then(|z| {
            let x = (longest - z * longest.dot(&z)).try_normalize(ACROSS * longest.norm())?;
            Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
        });
        let axes = frame.unwrap_or_else(Matrix3::identity);
        let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        for p in triangles.iter().flatten() {
            let p = axes.tr_mul(&p.coords);
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        let middle = (low + high) * 0.5;
        // A middle is rounded: half an edge reaches both sides all the same.
        let half = (high - middle).sup(&(middle - low));
        Self { middle: Point::from(axes * middle), axes, half }
    }

    /// The point of it that is nearest to another one.
    fn nearest(&self, p: &Point) -> Point {
        let way = self.axes.tr_mul(&(p - self.middle));
        self.middle + self.axes * way.sup(&-self.half).inf(&self.half)
    }
}

/// Triangles of a leaf.
const LEAF: usize = 1;

impl TriangleTree {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        Self::of_triangles((0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect())
    }

    pub(crate) fn of_triangles(mut triangles: Vec<[Point; 3]>) -> Self {
        let mut nodes = Vec::with_capacity(2 * triangles.len());
        let mut leans = Vec::with_capacity(2 * triangles.len());
        if !triangles.is_empty() {
            nodes.push(node_of(&triangles, 0));
            leans.push(WallBox::of(&triangles));
            let mut open = vec![(0, 0..triangles.len())];
            while let Some((at, range)) = open.pop() {
                if range.len() <= LEAF {
                    continue;
                }
                let middle = split(&mut triangles[range.clone()]) + range.start;
                let first = nodes.len();
                for half in [range.start..middle, middle..range.end] {
                    nodes.push(node_of(&triangles[half.clone()], half.start));
                    leans.push(WallBox::of(&triangles[half.clone()]));
                    open.push((nodes.len() - 1, half));
                }
                (nodes[at].first, nodes[at].count) = (first as u32, 0);
            }
        }
        Self { nodes, leans, triangles }
    }

    /// How often a half line from a point leaves the triangles less how often it enters them: the winding
    /// number of closed shells about the point, if the half line passes through no edge.
    pub(crate) fn winding_crossings(&self, from: &Point, along: &Vector) -> i32 {
        let mut sum = 0;
        let mut open = Vec::from_iter(self.root());
        while let Some(at) = open.pop() {
            let (middle, half) = self.bounds(at);
            // Box and half line are apart where one of the separating axes says so (Gottschalk 1996): the
            // axes of the box and the products of the direction with them.
            let way = from - middle;
            let size = along.abs();
            let behind = (0..3).any(|k| way[k].abs() > half[k] && way[k] * along[k] >= 0.0);
            let product = way.cross(along).abs();
            let limit = Vector::new(
                half.y * size.z + half.z * size.y,
                half.x * size.z + half.z * size.x,
                half.x * size.y + half.y * size.x,
            );
            if behind || (0..3).any(|k| product[k] > limit[k]) {
                continue;
            }
            match self.open(at) {
                Branch::Two(x, y) => open.extend([x, y]),
                Branch::Leaf(items) => {
                    for [a, b, c] in items.map(|i| self.corners(i)) {
                        let (u, v, w) = (a - from, b - from, c - from);
                        let volumes = [u.cross(&v).dot(along), v.cross(&w).dot(along), w.cross(&u).dot(along)];
                        let normal = (b - a).cross(&(c - a));
                        let ahead = u.dot(&normal) * along.dot(&normal) > 0.0;
                        if ahead && volumes.iter().all(|x| *x > 0.0) {
                            sum += 1;
                        } else if ahead && volumes.iter().all(|x| *x < 0.0) {
                            sum -= 1;
                        }
                    }
                }
            }
        }
        sum
    }

    /// Lower bound of the distance of a convex body from the triangles of a node, mm, below zero where none
    /// is proved, by planes across the way between their box and the middle of the body. `amid` gives the
    /// point amid the body that is nearest to a point, `support` the largest component of the body's points
    /// along a unit vector. The body reaches at least `round` about its middle: where no more than `wanted`
    /// can be proved by that, it is not asked for its support.
    pub(crate) fn node_distance(
        &self,
        node: u32,
        amid: impl Fn(&Point) -> Point,
        support: impl Fn(&Vector) -> f64,
        (round, wanted): (f64, f64),
    ) -> f64 {
        let lean = &self.leans[node as usize];
        let first = lean.nearest(&amid(&lean.middle));
        let p = amid(&first);
        let q = lean.nearest(&p);
        // No point of the box lies farther along the way out than the nearest one.
        let way = p - q;
        if way.norm_squared() < (wanted + round).powi(2) {
            return f64::NEG_INFINITY;
        }
        let Some(out) = way.try_normalize(0.0) else { return 0.0 };
        let box_high = lean.middle.coords.dot(&out) + lean.axes.tr_mul(&out).abs().dot(&lean.half);
        -support(&-out) - box_high
    }

    /// Corners of an item, mm.
    pub(crate) fn corners(&self, item: u32) -> &[Point; 3] {
        &self.triangles[item as usize]
    }

    pub(crate) fn triangles(&self) -> &[[Point; 3]] {
        &self.triangles
    }
}

fn node_of(triangles: &[[Point; 3]], first: usize) -> TriangleNode {
    let b = proveout_geom::Aabb::of_points(triangles.iter().flatten());
    // A middle is rounded: half an edge reaches both sides all the same.
    let middle = b.center();
    let half = (b.max - middle).sup(&(middle - b.min));
    TriangleNode { middle, half, first: first as u32, count: triangles.len() as u32 }
}

/// Parts triangles at the median of their middles along the longest side; gives the number in the first part.
fn split(triangles: &mut [[Point; 3]]) -> usize {
    let middle = |t: &[Point; 3]| t[0].coords + t[1].coords + t[2].coords;
    let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    for t in triangles.iter() {
        (low, high) = (low.inf(&middle(t)), high.sup(&middle(t)));
    }
    let axis = (high - low).imax();
    let half = triangles.len() / 2;
    triangles.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    half
}

impl BoxTree for TriangleTree {
    type Node = u32;

    fn root(&self) -> Option<u32> {
        (!self.nodes.is_empty()).then_some(0)
    }

    fn bounds(&self, node: u32) -> (Point, Vector) {
        let n = &self.nodes[node as usize];
        (n.middle, n.half)
    }

    fn open(&self, node: u32) -> Branch<u32> {
        let n = &self.nodes[node as usize];
        if n.count == 0 { Branch::Two(n.first, n.first + 1) } else { Branch::Leaf(n.first..n.first + n.count) }
    }
}
