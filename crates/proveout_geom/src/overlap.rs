//! Where faces of a mesh lie in each other: bodies that share a piece of face with their material on the same
//! side, and doubled faces. No edge passes through a face there, so that `crossing` sees nothing.
//!
//! ```text
//!    n ^      ^ n          Two triangles overlap when each lies in the plane of the other, within
//!   ___|______|___         rounding of a file, they look to the same side, and their insides have
//!      '------+----        points in common.
//! ```
//!
//! Faces that look at each other are bodies that touch, which is no fault.
//!
//! Seen along the longest axis of the normal, the insides are apart exactly where all corners of one lie
//! beyond or on a side of the other, which they may pass by rounding: shared corners and edges, and faces
//! that continue each other, are no overlap.

use crate::{
    Aabb, Point, TriMesh,
    crossing::{CLEAR, TriangleBoxes},
};

/// Cosine of the angle between normals from which two faces do not look to the same side.
const ALIKE: f64 = 0.999;
/// A triangle with less area has no normal, mm^2.
const NO_AREA: f64 = 1e-300;

/// Two triangles that share a piece of face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// One of them, the lower index.
    pub first: usize,
    /// The other one.
    pub second: usize,
    /// Middle of the box that both share, mm.
    pub near: Point,
}

impl TriMesh {
    /// The overlap of the triangle with the lowest index; none when no two faces lie in each other. Corners
    /// must be finite and exist.
    pub fn first_overlap(&self) -> Option<Overlap> {
        let boxes: Vec<Aabb> =
            (0..self.triangles.len()).map(|t| Aabb::of_points(&self.corners(t)).expanded(CLEAR)).collect();
        let tree = TriangleBoxes::new(&boxes);
        (0..self.triangles.len()).find_map(|first| {
            let mut found: Option<usize> = None;
            tree.meeting(&boxes[first], |other| {
                let nearer = other > first && found.is_none_or(|f| other < f);
                if nearer && boxes[other].intersects(&boxes[first]) && self.overlap(first, other) {
                    found = Some(other);
                }
            });
            found.map(|second| {
                let (a, b) = (boxes[first], boxes[second]);
                Overlap { first, second, near: nalgebra::center(&a.min.sup(&b.min), &a.max.inf(&b.max)) }
            })
        })
    }

    fn overlap(&self, s: usize, t: usize) -> bool {
        let (Some(n), Some(m)) =
            (self.area_normal(s).try_normalize(NO_AREA), self.area_normal(t).try_normalize(NO_AREA))
        else {
            return false;
        };
        let (p, q) = (self.corners(s), self.corners(t));
        let in_plane = |corners: &[Point; 3], on: &Point, n: &crate::Vector| {
            corners.iter().all(|c| (c - on).dot(n).abs() <= CLEAR)
        };
        if n.dot(&m) < ALIKE || !in_plane(&q, &p[0], &n) || !in_plane(&p, &q[0], &m) {
            return false;
        }
        let axis = n.iamax();
        let flat = |corners: &[Point; 3]| corners.map(|c| [c[(axis + 1) % 3], c[(axis + 2) % 3]]);
        let (p, q) = (flat(&p), flat(&q));
        // The normals are alike, so that both turn alike.
        let turn = n[axis].signum();
        !beyond_a_side(&p, &q, turn) && !beyond_a_side(&q, &p, turn)
    }
}

/// Whether a triangle has a side with all corners of another beyond it, or inside by no more than rounding.
fn beyond_a_side(of: &[[f64; 2]; 3], other: &[[f64; 2]; 3], turn: f64) -> bool {
    (0..3).any(|k| {
        let (a, b) = (of[k], of[(k + 1) % 3]);
        let side = [b[0] - a[0], b[1] - a[1]];
        let play = CLEAR * side[0].hypot(side[1]);
        other.iter().all(|c| turn * (side[0] * (c[1] - a[1]) - side[1] * (c[0] - a[0])) <= play)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MeshError, Pose, Vector, box_mesh, cylinder_mesh};

    fn cube(min: [f64; 3], max: [f64; 3]) -> TriMesh {
        box_mesh(&Aabb { min: Point::from(min), max: Point::from(max) })
    }

    fn two(a: TriMesh, b: &TriMesh) -> TriMesh {
        let mut all = a;
        all.append(b);
        all
    }

    #[test]
    fn bodies_that_stand_apart_or_touch_do_not_overlap() {
        let whole = cube([0.0; 3], [2.0; 3]);
        assert_eq!(whole.first_overlap(), None);
        assert_eq!(cylinder_mesh(5.0, 1.0, 9.0, 96).first_overlap(), None);
        // Face on face, edge on edge, corner on corner, apart; faces that continue each other.
        for low in [[2.0, 0.5, 0.5], [2.0, 2.0, 0.0], [2.0, 2.0, 2.0], [3.0, 0.0, 0.0], [2.0, 0.0, 0.0]] {
            let other = cube(low, low.map(|x| x + 1.0));
            let both = two(whole.clone(), &other);
            assert_eq!(both.first_overlap(), None, "{low:?}");
            // Rounded to single precision in another pose, as in a file.
            let mut turned = both.transformed(&Pose::from_rpy(Vector::new(4.0, 0.3, -3.0), 0.3, -0.8, 2.9));
            turned.positions.iter_mut().for_each(|p| *p = p.map(|x| f64::from(x as f32)));
            assert_eq!(turned.first_overlap(), None, "{low:?}");
        }
        let pose = Pose::from_rpy(Vector::new(1.0, 2.0, 3.0), 0.3, -0.8, 2.9);
        assert_eq!(cylinder_mesh(5.0, 0.0, 9.0, 720).transformed(&pose).first_overlap(), None);
        assert_eq!(TriMesh::default().first_overlap(), None);
    }

    #[test]
    fn a_shared_piece_of_face_is_found_in_any_pose() {
        let whole = cube([0.0; 3], [2.0; 3]);
        let poses = [
            Pose::identity(),
            Pose::from_rpy(Vector::new(4.0, 0.3, -3.0), 0.3, -0.8, 2.9),
            Pose::from_rpy(Vector::new(-100.0, 50.0, 7.0), 1.3, 0.2, -0.4),
        ];
        // The same body twice; a smaller one in its corner, on one of its faces from within, and level with
        // a face next to it.
        let others = [
            whole.clone(),
            cube([0.0; 3], [1.0; 3]),
            cube([0.5, 0.5, 1.0], [1.5, 1.5, 2.0]),
            cube([1.0, 0.5, 1.0], [3.0, 1.5, 2.0]),
        ];
        for pose in poses {
            for other in &others {
                let mesh = two(whole.clone(), other).transformed(&pose);
                let found = mesh.first_overlap().expect("they share a piece of face");
                assert!(found.first < 12 && found.second >= 12, "{found:?}");
                let near = pose.inverse().point(&found.near);
                assert!(near.iter().all(|x| (-1.0..=4.0).contains(x)), "{near}");
                assert!(matches!(mesh.check_uncrossed(), Err(MeshError::Overlap { .. } | MeshError::Crossing(_))));
            }
        }
        // Only the first three are without any edge through a face.
        assert!(others[..3].iter().all(|o| two(whole.clone(), o).first_crossing().is_none()));
    }

    #[test]
    fn faces_nearer_than_rounding_are_one_and_others_are_two() {
        for (gap, overlaps) in [(0.0, true), (1e-6, true), (1e-3, false)] {
            let inner = cube([0.5, 0.5, 1.0], [1.5, 1.5, 2.0 - gap]);
            assert_eq!(two(cube([0.0; 3], [2.0; 3]), &inner).first_overlap().is_some(), overlaps, "{gap}");
        }
    }
}
