//! Where a mesh crosses itself.
//!
//! Two triangles cross when an edge of one passes through the inside of the other. Corners are taken on a
//! lattice of a nanometer, so that the side of a plane on which a corner lies is the sign of an integer:
//! touching, shared corners and shared edges give zero and are no crossing, whatever the rounding.
//!
//! ```text
//!        p           p and q on different sides of the plane a b c, and the line p q
//!      a |  b        on the same side of the three edges:
//!       \|_/         signs of the volumes (a b c p), (a b c q) differ; (p q a b), (p q b c), (p q c a) agree
//!        |\          Both ends must be farther from the plane than [`CLEAR`]: rounding of a file is no
//!        q c         crossing.
//! ```
//!
//! Candidates come from a tree of boxes, halved at the median of the centers.

use crate::{Aabb, Point, TriMesh};

/// Step of the lattice, mm: 2^-20. Exact for bodies up to 10 m.
const LATTICE: f64 = 1.0 / 1_048_576.0;
/// Ends of an edge nearer to a plane than this (mm) touch it.
pub(crate) const CLEAR: f64 = 1e-5;
/// Triangles of a leaf.
const LEAF: usize = 8;

type Place = [i64; 3];

/// An edge that passes through a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Triangle with the edge.
    pub of: usize,
    /// Triangle that it passes through.
    pub through: usize,
    /// Ends of the edge, mm.
    pub edge: [Point; 2],
    /// Where, mm.
    pub at: Point,
}

pub(crate) struct TriangleBoxes {
    /// Box of each node; the children of node k are 2 k + 1 and 2 k + 2.
    nodes: Vec<Aabb>,
    order: Vec<u32>,
}

impl TriMesh {
    /// The crossing of the triangle with the lowest index; none when no edge passes through a face. Faces
    /// that lie in each other are for [`Self::first_overlap`]. Corners must be finite and exist.
    pub fn first_crossing(&self) -> Option<Crossing> {
        let lattice = |p: &Point| [p.x, p.y, p.z].map(|x| (x / LATTICE).round() as i64);
        let places: Vec<Place> = self.positions.iter().map(lattice).collect();
        let boxes: Vec<Aabb> = (0..self.triangles.len()).map(|t| Aabb::of_points(&self.corners(t))).collect();
        let tree = TriangleBoxes::new(&boxes);
        (0..self.triangles.len()).find_map(|t| {
            let mut found = None;
            tree.meeting(&boxes[t], |other| {
                if other > t && found.is_none() && boxes[other].intersects(&boxes[t]) {
                    found = self.pierced(&places, t, other).or_else(|| self.pierced(&places, other, t));
                }
            });
            found
        })
    }

    /// Whether an edge of one triangle passes through another.
    fn pierced(&self, places: &[Place], of: usize, through: usize) -> Option<Crossing> {
        let [a, b, c] = self.triangles[through].map(|v| places[v as usize]);
        let corners = self.triangles[of];
        let heights = corners.map(|v| volume(&a, &b, &c, &places[v as usize]));
        if heights.iter().all(|h| *h >= 0) || heights.iter().all(|h| *h <= 0) {
            return None;
        }
        (0..3).find_map(|k| {
            let (i, j) = (k, (k + 1) % 3);
            if heights[i].signum() * heights[j].signum() >= 0 {
                return None;
            }
            let (p, q) = (&places[corners[i] as usize], &places[corners[j] as usize]);
            let sides = [volume(p, q, &a, &b), volume(p, q, &b, &c), volume(p, q, &c, &a)].map(i128::signum);
            if sides[0] == 0 || sides[1] != sides[0] || sides[2] != sides[0] {
                return None;
            }
            let normal = self.area_normal(through);
            let area = normal.norm();
            let [on, ..] = self.corners(through);
            let edge = [corners[i], corners[j]].map(|v| self.positions[v as usize]);
            let [up, down] = edge.map(|x| (x - on).dot(&normal) / area);
            (up.abs() > CLEAR && down.abs() > CLEAR).then(|| Crossing {
                of,
                through,
                edge,
                at: edge[0] + (edge[1] - edge[0]) * (up / (up - down)),
            })
        })
    }
}

/// Six times the volume of the tetrahedron, in steps of the lattice. Differences have up to 35 bits, so the
/// sum of products of three has less than 108.
fn volume(a: &Place, b: &Place, c: &Place, d: &Place) -> i128 {
    let from = |p: &Place| [0, 1, 2].map(|k| i128::from(p[k]) - i128::from(a[k]));
    let [u, v, w] = [from(b), from(c), from(d)];
    u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0])
}

impl TriangleBoxes {
    pub(crate) fn new(boxes: &[Aabb]) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let leaves = boxes.len().div_ceil(LEAF).max(1).next_power_of_two();
        let mut tree = Self { nodes: vec![Aabb::empty(); 2 * leaves - 1], order: Vec::new() };
        tree.divide(0, &mut order, boxes);
        tree.order = order;
        tree
    }

    /// Boxes of a node and those below it; the halves of the order are those of the node's children.
    fn divide(&mut self, node: usize, order: &mut [u32], boxes: &[Aabb]) {
        let whole = order.iter().fold(Aabb::empty(), |all, t| all.union(&boxes[*t as usize]));
        self.nodes[node] = whole;
        if 2 * node + 2 >= self.nodes.len() {
            return;
        }
        let middle = order.len() / 2;
        if !order.is_empty() {
            let axis = whole.size().imax();
            let center = |t: u32| boxes[t as usize].min[axis] + boxes[t as usize].max[axis];
            order.select_nth_unstable_by(middle, |x, y| center(*x).total_cmp(&center(*y)).then(x.cmp(y)));
        }
        let (left, right) = order.split_at_mut(middle);
        self.divide(2 * node + 1, left, boxes);
        self.divide(2 * node + 2, right, boxes);
    }

    /// Calls with the triangles of all leaves whose box meets another.
    pub(crate) fn meeting(&self, other: &Aabb, mut see: impl FnMut(usize)) {
        let mut open = vec![(0, 0, self.order.len())];
        while let Some((node, from, to)) = open.pop() {
            if from == to || !self.nodes[node].intersects(other) {
                continue;
            }
            if 2 * node + 2 >= self.nodes.len() {
                self.order[from..to].iter().for_each(|t| see(*t as usize));
            } else {
                let middle = from + (to - from) / 2;
                open.push((2 * node + 1, from, middle));
                open.push((2 * node + 2, middle, to));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pose, Vector, box_mesh, cylinder_mesh};

    fn cube(min: [f64; 3], max: [f64; 3]) -> TriMesh {
        box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) })
    }

    #[test]
    fn bodies_that_touch_or_stand_apart_do_not_cross() {
        assert_eq!(cube([0.0; 3], [1.0; 3]).first_crossing(), None);
        assert_eq!(cylinder_mesh(5.0, 0.0, 9.0, 96).first_crossing(), None);
        for shift in [1.0, 1.5, 0.3] {
            // Face on face, apart, and one inside of the other.
            let mut two = cube([0.0; 3], [1.0; 3]);
            let size = if shift < 1.0 { 0.4 } else { 1.0 };
            two.append(&cube([shift, 0.3, 0.3], [shift + size, 0.7, 0.7]));
            assert_eq!(two.first_crossing(), None, "{shift}");
        }
        let pose = Pose::from_rpy(Vector::new(1.0, 2.0, 3.0), 0.3, -0.8, 2.9);
        assert_eq!(cylinder_mesh(5.0, 0.0, 9.0, 360).transformed(&pose).first_crossing(), None);
        assert_eq!(TriMesh::default().first_crossing(), None);
    }

    #[test]
    fn a_crossing_is_found_wherever_it_is() {
        let pose = Pose::from_rpy(Vector::new(4.0, 0.3, 3.0), 0.3, -0.8, 2.9);
        let mut two = cylinder_mesh(5.0, 0.0, 9.0, 96);
        two.append(&cylinder_mesh(5.0, 0.0, 9.0, 96).transformed(&pose));
        let crossing = two.first_crossing().expect("they cross");
        let normal = two.area_normal(crossing.through).normalize();
        let [corner, ..] = two.corners(crossing.through);
        assert!((crossing.at - corner).dot(&normal).abs() < 1e-9, "it lies on the face");
        let [p, q] = crossing.edge;
        assert!(((crossing.at - p).norm() + (crossing.at - q).norm() - (p - q).norm()).abs() < 1e-9, "and on the edge");
        // A single corner that is pushed through the far face.
        let mut spike = cube([0.0; 3], [1.0; 3]);
        spike.positions[0] = Point::new(0.4, 0.45, 1.5);
        assert!(spike.first_crossing().is_some());
        // Deeper than rounding, or not.
        for (depth, crosses) in [(1e-7, false), (1e-3, true)] {
            let mut near = cube([0.0; 3], [1.0; 3]);
            near.append(&cube([1.0 - depth, 0.31, 0.33], [2.0, 0.72, 0.7]));
            assert_eq!(near.first_crossing().is_some(), crosses, "{depth}");
        }
    }

    #[test]
    fn all_pairs_agree_with_the_tree() {
        let mut state = 9_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        for _ in 0..40 {
            let mut soup = TriMesh::default();
            for t in 0..60_u32 {
                let at = [random(), random(), random()].map(|x| 8.0 * x);
                soup.positions.extend((0..3).map(|_| Point::new(at[0] + random(), at[1] + random(), at[2] + random())));
                soup.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
            }
            let places: Vec<Place> =
                soup.positions.iter().map(|p| [p.x, p.y, p.z].map(|x| (x / LATTICE).round() as i64)).collect();
            let pairs = (0..60).flat_map(|a| (0..60).map(move |b| (a, b)));
            let any = pairs.clone().any(|(a, b)| a != b && soup.pierced(&places, a, b).is_some());
            assert_eq!(soup.first_crossing().is_some(), any);
        }
    }
}
