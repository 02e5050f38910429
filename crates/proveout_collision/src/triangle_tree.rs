//! Triangles in a tree of boxes, with a slab for each.
//!
//! A box along the axes is fat about a face that leans. A tool that slides along a wall has all boxes near it, and each of their triangles would have to
//! be asked. So every node also knows how far its triangles reach along the mean of their normals:
//!
//! ```text
//!         ___--~~~--___   high        of a patch r wide of a surface with radius R the slab is r2 / 2R thick,
//!     _--~  patch      ~--_           of a single triangle it has no thickness at all
//!    ------------------------ low
//! ```
//!
//! Two planes across that direction, one on the slab and one on the other body, prove a distance.

use proveout_geom::{Point, TriMesh, Vector};

use crate::boxes::{BoxTree, Branch};

/// Triangles in a tree of boxes.
#[derive(Clone, Debug)]
pub(crate) struct TriangleTree {
    nodes: Vec<Node>,
    /// One for each node.
    slabs: Vec<Slab>,
    /// Corners, in the order of the leaves.
    triangles: Vec<[Point; 3]>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    middle: Point,
    half: Vector,
    /// First item of a leaf, or first of two nodes in a row.
    first: u32,
    /// Number of items; zero for a node with two others.
    count: u32,
}

/// How far the triangles of a node reach along a direction.
#[derive(Clone, Copy, Debug)]
struct Slab {
    /// Mean of the normals, of length one; zero where they have none in common: then it tells nothing.
    normal: Vector,
    low: f64,
    high: f64,
}

impl Slab {
    fn of(triangles: &[[Point; 3]]) -> Self {
        let across = |[a, b, c]: &[Point; 3]| (b - a).cross(&(c - a));
        let sum = triangles.iter().fold(Vector::zeros(), |sum, t| sum + across(t));
        let normal = sum.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector::zeros);
        let heights = triangles.iter().flatten().map(|p| p.coords.dot(&normal));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        Self { normal, low, high }
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
        let mut slabs = Vec::with_capacity(2 * triangles.len());
        if !triangles.is_empty() {
            nodes.push(node_of(&triangles, 0));
            slabs.push(Slab::of(&triangles));
            let mut open = vec![(0, 0..triangles.len())];
            while let Some((at, range)) = open.pop() {
                if range.len() <= LEAF {
                    continue;
                }
                let middle = split(&mut triangles[range.clone()]) + range.start;
                let first = nodes.len();
                for half in [range.start..middle, middle..range.end] {
                    nodes.push(node_of(&triangles[half.clone()], half.start));
                    slabs.push(Slab::of(&triangles[half.clone()]));
                    open.push((nodes.len() - 1, half));
                }
                (nodes[at].first, nodes[at].count) = (first as u32, 0);
            }
        }
        Self { nodes, slabs, triangles }
    }

    /// How often a half line from a point leaves the triangles less how often it enters them: the winding number of closed shells about
    /// the point, if the half line passes through no edge.
    pub(crate) fn leaving(&self, from: &Point, along: &Vector) -> i32 {
        let mut sum = 0;
        let mut open = Vec::from_iter(self.root());
        while let Some(at) = open.pop() {
            let (middle, half) = self.bounds(at);
            // Box and half line are apart where one of the separating axes says so (Gottschalk 1996): the axes of the box and the
            // products of the direction with them.
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

    /// Lower bound of the distance of a convex body from the triangles of a node, mm, by planes across their mean normal; zero where it tells nothing. `within` is a
    /// point of the body, `support` the largest component of its points along a direction.
    pub(crate) fn beside(&self, node: u32, within: &Point, support: impl Fn(&Vector) -> f64) -> f64 {
        let Slab { normal, low, high } = &self.slabs[node as usize];
        let height = within.coords.dot(normal);
        if height > *high {
            -support(&-normal) - high
        } else if height < *low {
            low - support(normal)
        } else {
            0.0
        }
    }

    /// Corners of an item, mm.
    pub(crate) fn corners(&self, item: u32) -> &[Point; 3] {
        &self.triangles[item as usize]
    }

    pub(crate) fn triangles(&self) -> &[[Point; 3]] {
        &self.triangles
    }
}

fn node_of(triangles: &[[Point; 3]], first: usize) -> Node {
    let b = proveout_geom::Aabb::of_points(triangles.iter().flatten());
    // A middle is rounded: half an edge reaches both sides all the same.
    let middle = b.center();
    let half = (b.max - middle).sup(&(middle - b.min));
    Node { middle, half, first: first as u32, count: triangles.len() as u32 }
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
