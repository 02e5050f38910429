//! What is asked of trees and planes is what all pieces answer, one by one.

use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::query::details::distance_support_map_support_map;
use parry3d_f64::shape::SupportMap;
use proveout_geom::{Aabb, Point, Pose, TriMesh, box_mesh};

use super::super::{
    distance::SeparationSearch,
    form::BodyPieces,
    placed::{PieceTree, PlacedBody, RelativePoses},
    tree::Corners,
};
use super::*;

/// Numbers between -1 and 1, the same at every run.
struct KinematicNumbers(u64);

impl KinematicNumbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, size: f64) -> Vector {
        Vector::from_fn(|_, _| size * self.next())
    }

    fn pose(&mut self, place: Vector, turn: f64) -> Pose {
        let [x, y, z] = [0; 3].map(|_| turn * self.next());
        Pose::from_rpy(place, x, y, z)
    }

    /// Triangles here and there, on a wave.
    fn mesh(&mut self, count: usize) -> TriMesh {
        let vertices = (0..count).flat_map(|_| {
            let mut at = self.vector(20.0);
            at.z = 3.0 * (0.2 * at.x).sin() + 0.1 * self.next();
            [0; 3].map(|_| Point::from(at + self.vector(1.0)))
        });
        let vertices = vertices.collect();
        TriMesh { positions: vertices, triangles: (0..count as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect() }
    }

    fn places(&mut self, k: usize) -> RelativePoses {
        let at = self.vector(6.0) + Vector::new(0.0, 0.0, 12.0 + 4.0 * self.next());
        let from = self.pose(at, 1.0);
        let moved = |s: &mut Self, by: f64| {
            let turn = s.pose(Vector::zeros(), 0.05 * by);
            Pose { rotation: turn.rotation * from.rotation, translation: from.translation + s.vector(by) }
        };
        match k % 3 {
            0 => RelativePoses { poses: [from, moved(self, 2.0)], middle: None, shifts: Vec::new() },
            1 => RelativePoses { poses: [from, moved(self, 2.0)], middle: Some(moved(self, 1.0)), shifts: Vec::new() },
            _ => {
                RelativePoses { poses: [from; 2], middle: None, shifts: (0..k % 4).map(|_| self.vector(1.0)).collect() }
            }
        }
    }
}

/// Points, and the sums of them with some vectors.
struct Hull(Vec<Point>, Vec<Vector>);

impl SupportMap for Hull {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        let d = Vector::new(direction.x, direction.y, direction.z);
        let top = self.0.iter().max_by(|a, b| a.coords.dot(&d).total_cmp(&b.coords.dot(&d))).expect("a point");
        let p = self.1.iter().fold(*top, |p, s| if s.dot(&d) > 0.0 { p + s } else { p - s });
        ParryVector::new(p.x, p.y, p.z)
    }
}

/// Places of a point whose hull holds its way.
fn images(places: &RelativePoses, p: &Point) -> Vec<Point> {
    let [from, to] = places.poses.each_ref().map(|x| x.point(p));
    let corner = places.middle.as_ref().map(|x| Point::from(x.point(p).coords * 2.0 - (from.coords + to.coords) * 0.5));
    [from, to].into_iter().chain(corner).collect()
}

fn hulls(form: &BodyPieces, places: &RelativePoses) -> Vec<Hull> {
    let of = |piece: &Vec<Point>| Hull(piece.iter().flat_map(|p| images(places, p)).collect(), places.shifts.clone());
    form.pieces.iter().map(of).collect()
}

/// Distance by all pairs of pieces.
fn distance(a: &[Hull], b: &[Hull]) -> f64 {
    let of = |x: &Hull| {
        b.iter().map(|y| distance_support_map_support_map(&ParryPose::IDENTITY, x, y)).fold(f64::INFINITY, f64::min)
    };
    a.iter().map(of).fold(f64::INFINITY, f64::min)
}

fn tool() -> BodyPieces {
    let cutter = proveout_tool::Cutter::ball(12.0).expect("ball").bodies(20.0).expect("bodies");
    let profiles: Vec<_> = cutter.iter().collect();
    BodyPieces::revolved(&profiles, &Pose::from_rpy(Vector::new(0.0, 0.0, 6.0), 0.4, -0.3, 1.2), 6.0)
}

#[test]
fn nodes_reach_as_far_as_all_their_points() {
    let mut numbers = KinematicNumbers(1);
    let (tool, mesh) = (tool(), BodyPieces::mesh(&numbers.mesh(70)));
    let block = BodyPieces::mesh(&box_mesh(&Aabb { min: Point::new(-9.0, 2.0, 1.0), max: Point::new(4.0, 8.0, 6.0) }));
    // Points round the tool and on its ball approximate the round bodies: 180 a circle of 6 mm, 48 a
    // quarter of the ball.
    let rough =
        6.0 * (1.0 - (0.5_f64 * 2.0).to_radians().cos()) + 6.0 * (1.0 - (0.5_f64 * 90.0 / 48.0).to_radians().cos());
    for k in 0..120 {
        let (places, d) = (numbers.places(k), numbers.vector(1.0).normalize());
        let shift: f64 = places.shifts.iter().map(|s| s.dot(&d).abs()).sum();
        for (form, slack) in [(&tool, rough), (&mesh, 0.0), (&block, 0.0)] {
            let moved = PlacedBody::new(form, &places);
            let seen = moved.see(&d);
            // Branches come after their node.
            let mut below = vec![f64::NEG_INFINITY; form.tree.len()];
            for node in (0..form.tree.len()).rev() {
                let height = moved.height(node, &seen);
                below[node] = match form.tree[node].holds {
                    Err([one, other]) => below[one].max(below[other]),
                    Ok(item) => {
                        let all = form.pieces[item].iter().flat_map(|p| images(&places, p));
                        let highest = all.map(|p| p.coords.dot(&d)).fold(f64::NEG_INFINITY, f64::max) + shift;
                        assert!((highest - 1e-9..highest + slack + 1e-9).contains(&height), "{k}: {height} {highest}");
                        assert!((moved.farthest(node, &d).dot(&d) - height).abs() < 1e-9, "{k}");
                        height
                    }
                };
                assert!(below[node] <= height + 1e-9, "{k}: {height} {}", below[node]);
            }
        }
        let (mut near, corners) = (k, Corners::new(mesh.pieces.iter().flatten().copied().collect()));
        let off = |p: &Point| (p - Point::new(1.0, -2.0, k as f64)).cross(&d).norm();
        let most = mesh.pieces.iter().flatten().map(off).fold(0.0, f64::max);
        assert!((corners.largest(off, &mut near) - most).abs() < 1e-12, "{k}");
    }
}

/// A claim of a little less than the distance of all pieces holds, one of a little more does not, whatever
/// planes are known from other places.
#[test]
fn claims_hold_up_to_the_distance_of_all_pieces() {
    let mut numbers = KinematicNumbers(2);
    let (tool, one, other) = (tool(), BodyPieces::mesh(&numbers.mesh(25)), BodyPieces::mesh(&numbers.mesh(60)));
    let still = hulls(&other, &RelativePoses::still());
    let (mut search, mut turned, mut apart) = (SeparationSearch::default(), SeparationSearch::default(), 0);
    for k in 0..60 {
        let places = numbers.places(k);
        for (form, slack) in [(&one, 1e-6), (&tool, 5e-3)] {
            let true_one = distance(&hulls(form, &places), &still);
            apart += usize::from(true_one > 0.1);
            let mut nearer_than = |limit: f64| search.nearer_than(form, &other, &places, limit);
            assert_eq!(nearer_than(true_one - slack), None, "{k}: {true_one}");
            let nearer = nearer_than(true_one + 1e-6).expect("nearer than claimed");
            assert!(nearer < true_one + 1.1e-6, "{k}: {nearer} {true_one}");
            assert!(
                nearer_than(true_one + 3.0).is_some() && nearer_than(1e4).is_some() && nearer_than(f64::NAN).is_some(),
                "{k}"
            );
            // The other way round, the moving body is the mesh.
            let back = RelativePoses::still();
            let true_one = distance(&hulls(&other, &back), &hulls(form, &RelativePoses::still()));
            assert_eq!(search.nearer_than(&other, form, &back, true_one - slack), None, "{k}");
            assert!(search.nearer_than(&other, form, &back, true_one + 1e-6).is_some(), "{k}");
        }
        // At all turns about a line: circles of 360 points, which come as near as the round ones but for
        // little.
        let (point, direction) = (Point::from(numbers.vector(3.0)), numbers.vector(1.0).normalize());
        let places = RelativePoses { poses: [places.poses[0]; 2], middle: None, shifts: places.shifts };
        let at_turns = |piece: &Vec<Point>| {
            let turned = |k: i32| {
                let turn = Pose::about_line(&point, &direction, f64::from(k).to_radians());
                piece.iter().map(move |p| places.poses[0].point(&turn.point(p)))
            };
            Hull((0..360).flat_map(turned).collect(), places.shifts.clone())
        };
        let true_one = distance(&one.pieces.iter().map(at_turns).collect::<Vec<_>>(), &still);
        let circles = one.turned(&point, &direction);
        assert_eq!(turned.turned_nearer_than(&circles, &other, &places, true_one - 5e-3), None, "{k}: {true_one}");
        assert!(turned.turned_nearer_than(&circles, &other, &places, true_one + 1e-6).is_some(), "{k}: {true_one}");
    }
    println!(
        "{apart} apart; {} looks, {} by one plane, {} nodes, {} asked",
        search.looks, search.by_one_plane, search.nodes, search.asked
    );
    assert!(apart > 30 && search.by_one_plane > 0);
}
