//! Bounded distances between shapes.

use std::cell::Cell;

use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::partitioning::BvhNode;
use parry3d_f64::query::ClosestPoints;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::query::details::closest_points_support_map_support_map;
use proveout_geom::{Point, Pose};

use crate::shape::{MeshShape, Revolved, Shape, from_parry, pose_to_parry, to_parry};

/// Answer to "how far apart, as far as nearer than a limit".
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Gap {
    /// Further than the limit asked for.
    Beyond,
    /// This far; the two nearest points, in the frame of the second shape.
    At(f64, Point, Point),
    /// The skins meet; a point near there, in the frame of the second shape.
    Meeting(Point),
}

/// Distance of shape `a` from shape `b`, where it is below `limit` (mm). The skins count, not the inside.
pub(crate) fn gap(a: &Shape, b: &Shape, b_from_a: &Pose, limit: f64) -> Gap {
    match (a, b) {
        (Shape::Convex(bodies), Shape::Mesh(mesh)) => {
            let mut best = Gap::Beyond;
            let mut bound = limit;
            for body in bodies {
                let found = convex_mesh(body, mesh, b_from_a, bound);
                match found {
                    Gap::Meeting(_) => return found,
                    Gap::At(d, ..) => (best, bound) = (found, d),
                    Gap::Beyond => {}
                }
            }
            best
        }
        (Shape::Mesh(a), Shape::Mesh(b)) => mesh_mesh(a, b, b_from_a, limit),
        (Shape::Mesh(_), Shape::Convex(_)) => turned(gap(b, a, &b_from_a.inverse(), limit), b_from_a),
        (Shape::Convex(x), Shape::Convex(y)) => convex_convex(x, y, b_from_a, limit),
    }
}

/// The same answer with the shapes exchanged; points go from the frame of a to that of b.
fn turned(gap: Gap, b_from_a: &Pose) -> Gap {
    match gap {
        Gap::Beyond => Gap::Beyond,
        Gap::At(d, p, q) => Gap::At(d, b_from_a.point(&q), b_from_a.point(&p)),
        Gap::Meeting(p) => Gap::Meeting(b_from_a.point(&p)),
    }
}

fn convex_convex(x: &[Revolved], y: &[Revolved], b_from_a: &Pose, limit: f64) -> Gap {
    let pose = pose_to_parry(&b_from_a.inverse());
    let mut best = Gap::Beyond;
    let mut bound = limit;
    for p in x {
        for q in y {
            match closest_points_support_map_support_map(&pose, p, q, bound) {
                ClosestPoints::Intersecting => return Gap::Meeting(q.middle()),
                ClosestPoints::WithinMargin(u, v) => {
                    let (u, v) = (b_from_a.point(&from_parry(u)), from_parry(v));
                    let d = (u - v).norm();
                    if d < bound {
                        (best, bound) = (Gap::At(d, u, v), d);
                    }
                }
                ClosestPoints::Disjoint => {}
            }
        }
    }
    best
}

/// Branch and bound over the tree of the mesh. The bound of a node is the larger of two: boxes apart, and the distance of
/// the node's middle from the axis of the body less half its diagonal less the radius. The second is the sharp one for a
/// long slanted tool, whose box is fat.
fn convex_mesh(body: &Revolved, mesh: &MeshShape, mesh_from_body: &Pose, limit: f64) -> Gap {
    let pose = pose_to_parry(mesh_from_body);
    let (low, high, radius) = body.capsule();
    let (low, high) = (mesh_from_body.point(&low), mesh_from_body.point(&high));
    let axis = high - low;
    let length2 = axis.norm_squared();
    // Box of a cylinder: the axis, and the radius times the sine of its angle to each coordinate axis.
    let unit = if length2 > 0.0 { axis / length2.sqrt() } else { axis };
    let across = unit.map(|u| radius * (1.0 - (u * u).min(1.0)).max(0.0).sqrt());
    let (mins, maxs) = (low.inf(&high) - across, low.sup(&high) + across);
    let node_bound = |node: &BvhNode, _: f64| {
        let (a, b) = (from_parry(node.mins()), from_parry(node.maxs()));
        let mut square = 0.0;
        for i in 0..3 {
            let apart = (a[i] - maxs[i]).max(mins[i] - b[i]).max(0.0);
            square += apart * apart;
        }
        let middle = nalgebra::center(&a, &b);
        let t = if length2 > 0.0 { ((middle - low).dot(&axis) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let from_axis = (middle - (low + axis * t)).norm() - 0.5 * (b - a).norm() - radius;
        from_axis.max(square.sqrt())
    };
    let leaf = |triangle: u32, bound: f64| {
        let triangle = mesh.tree.triangle(triangle);
        match closest_points_support_map_support_map(&pose, &triangle, body, bound) {
            ClosestPoints::Intersecting => Some((0.0, (true, triangle.center(), triangle.center()))),
            ClosestPoints::WithinMargin(p, q) => {
                let q = pose * q;
                Some(((p - q).length(), (false, p, q)))
            }
            ClosestPoints::Disjoint => None,
        }
    };
    match mesh.tree.bvh().find_best(limit, node_bound, leaf) {
        None => Gap::Beyond,
        Some((_, (_, (true, p, _)))) => Gap::Meeting(from_parry(p)),
        Some((_, (d, (false, p, q)))) => Gap::At(d, from_parry(q), from_parry(p)),
    }
}

/// Both trees at once with a shrinking bound.
fn mesh_mesh(a: &MeshShape, b: &MeshShape, b_from_a: &Pose, limit: f64) -> Gap {
    let best = Cell::new(limit);
    let turn = b_from_a.rotation.abs();
    let near = |in_b: &BvhNode, in_a: &BvhNode| {
        let (low, high) = (from_parry(in_a.mins()), from_parry(in_a.maxs()));
        let middle = b_from_a.point(&nalgebra::center(&low, &high));
        let half = turn * (high - low) * 0.5;
        let (mins, maxs) = (from_parry(in_b.mins()), from_parry(in_b.maxs()));
        let mut square = 0.0;
        for i in 0..3 {
            let apart = (mins[i] - middle[i] - half[i]).max(middle[i] - half[i] - maxs[i]).max(0.0);
            square += apart * apart;
        }
        square.sqrt() < best.get()
    };
    let still = pose_to_parry(&Pose::identity());
    let moved = |p: ParryVector| to_parry(&b_from_a.point(&from_parry(p)));
    let mut found = Gap::Beyond;
    for (in_b, in_a) in b.tree.bvh().leaf_pairs(a.tree.bvh(), near) {
        let (s, mut t) = (b.tree.triangle(in_b), a.tree.triangle(in_a));
        (t.a, t.b, t.c) = (moved(t.a), moved(t.b), moved(t.c));
        match closest_points_support_map_support_map(&still, &s, &t, best.get()) {
            ClosestPoints::Intersecting => return Gap::Meeting(from_parry(s.center())),
            ClosestPoints::WithinMargin(p, q) => {
                let d = (p - q).length();
                if d < best.get() {
                    best.set(d);
                    found = Gap::At(d, from_parry(q), from_parry(p));
                }
            }
            ClosestPoints::Disjoint => {}
        }
    }
    found
}

/// A point of one shape that lies inside of the other although the skins are apart, in the frame of `b`.
pub(crate) fn inside(a: &Shape, b: &Shape, b_from_a: &Pose) -> Option<Point> {
    match (a, b) {
        (Shape::Convex(bodies), Shape::Mesh(mesh)) => {
            let a_from_b = b_from_a.inverse();
            let tool_inside = bodies.iter().map(|c| b_from_a.point(&c.middle())).find(|p| mesh.contains(p));
            tool_inside.or_else(|| {
                let mut shells = mesh.shells.iter();
                shells.find(|p| bodies.iter().any(|c| c.signed_distance(&a_from_b.point(p)) < 0.0)).copied()
            })
        }
        (Shape::Mesh(x), Shape::Mesh(y)) => {
            let a_from_b = b_from_a.inverse();
            let x_inside = x.shells.iter().map(|p| b_from_a.point(p)).find(|p| y.contains(p));
            x_inside.or_else(|| y.shells.iter().find(|p| x.contains(&a_from_b.point(p))).copied())
        }
        (Shape::Mesh(_), Shape::Convex(_)) => inside(b, a, &b_from_a.inverse()).map(|p| b_from_a.point(&p)),
        (Shape::Convex(x), Shape::Convex(y)) => {
            let a_from_b = b_from_a.inverse();
            let first = x.iter().map(|c| b_from_a.point(&c.middle()));
            first.into_iter().find(|p| y.iter().any(|c| c.signed_distance(p) < 0.0)).or_else(|| {
                let mut second = y.iter().map(Revolved::middle);
                second.find(|p| x.iter().any(|c| c.signed_distance(&a_from_b.point(p)) < 0.0))
            })
        }
    }
}

/// Points tried on a body for the estimate of the penetration.
const SECTORS: u32 = 16;
/// Vertices of a mesh tried for the estimate of the penetration.
const MOST_VERTICES: usize = 2000;
/// Chord error of the points tried on arcs, mm.
const CURVE_MM: f64 = 0.2;

/// How deep one shape reaches into the other, mm: the largest depth of points of each inside of the other. A lower
/// estimate, since only vertices and points on the generating curves are tried.
pub(crate) fn penetration(a: &Shape, b: &Shape, b_from_a: &Pose) -> f64 {
    let a_from_b = b_from_a.inverse();
    let of_a = probes(a).map(|p| depth_in(b, &b_from_a.point(&p))).fold(0.0, f64::max);
    let of_b = probes(b).map(|p| depth_in(a, &a_from_b.point(&p))).fold(0.0, f64::max);
    of_a.max(of_b)
}

fn probes(shape: &Shape) -> Box<dyn Iterator<Item = Point> + '_> {
    match shape {
        Shape::Mesh(m) => {
            let stride = m.tree.vertices().len().div_ceil(MOST_VERTICES).max(1);
            Box::new(m.vertices().step_by(stride))
        }
        Shape::Convex(bodies) => Box::new(bodies.iter().flat_map(|b| {
            b.profile().polyline(CURVE_MM).into_iter().flat_map(|[r, z]| {
                (0..SECTORS).map(move |k| {
                    let (s, c) = proveout_geom::sin_cos(std::f64::consts::TAU * f64::from(k) / f64::from(SECTORS));
                    Point::new(r * c, r * s, z)
                })
            })
        })),
    }
}

fn depth_in(shape: &Shape, p: &Point) -> f64 {
    match shape {
        Shape::Convex(bodies) => bodies.iter().map(|b| -b.signed_distance(p)).fold(0.0, f64::max),
        Shape::Mesh(m) => {
            let q = to_parry(p);
            if !m.tree.local_aabb().contains_local_point(q) {
                return 0.0;
            }
            let (projection, _) = m.tree.project_local_point_and_get_location(q, false);
            if projection.is_inside { (projection.point - q).length() } else { 0.0 }
        }
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, Vector, box_mesh, cylinder_mesh, revolved_mesh};
    use proveout_tool::Cutter;

    use super::*;

    fn mesh(m: &proveout_geom::TriMesh) -> Shape {
        Shape::Mesh(Box::new(MeshShape::new(m).expect("solid")))
    }

    fn convex(cutter: Cutter, length: f64) -> Shape {
        Shape::Convex(cutter.bodies(length).expect("bodies").iter().map(Revolved::new).collect())
    }

    fn block() -> Shape {
        mesh(&box_mesh(&Aabb { min: Point::new(-50.0, -50.0, -20.0), max: Point::new(50.0, 50.0, 0.0) }))
    }

    fn distance(g: Gap) -> f64 {
        match g {
            Gap::At(d, p, q) => {
                assert!(((p - q).norm() - d).abs() < 1e-9);
                d
            }
            Gap::Meeting(_) => 0.0,
            Gap::Beyond => f64::INFINITY,
        }
    }

    /// Lowest point of a body of revolution tilted by `tilt` about y: the support in the direction of -z, in closed form.
    fn lowest(shape: &str, tilt: f64) -> f64 {
        let (s, c) = tilt.sin_cos();
        match shape {
            "ball" => 5.0 * c - 5.0,                  // center at 5 along the axis, less the radius
            "flat" => -5.0 * s.abs(),                 // rim of the bottom
            "bull" => 2.0 * c - 2.0 - 3.0 * s.abs(),  // center circle of the corner, less its radius
            _ => (-4.0 * s.abs() + 4.0 * c).min(0.0), // point or rim of a 90 degree cone
        }
    }

    #[test]
    fn tilted_cutters_over_a_plane_have_their_exact_distance() {
        let table = block();
        let cutters = [
            ("ball", convex(Cutter::ball(10.0).expect("ball"), 30.0)),
            ("flat", convex(Cutter::flat(10.0).expect("flat"), 30.0)),
            ("bull", convex(Cutter::bull_nose(10.0, 2.0).expect("bull"), 30.0)),
            ("cone", convex(Cutter::chamfer(8.0, 90.0, 0.0).expect("cone"), 30.0)),
        ];
        for (name, cutter) in &cutters {
            for k in 0..80 {
                let tilt = 0.015 * f64::from(k);
                for height in [12.0, 8.0, 6.5] {
                    let pose = Pose::from_translation(Vector::new(3.0, -2.0, height))
                        * Pose::from_axis_angle(&Vector::y(), tilt);
                    let exact = height + lowest(name, tilt);
                    let found = distance(gap(cutter, &table, &pose, 100.0));
                    // Relative 1e-7 is what GJK promises for curved bodies at this distance.
                    assert!((found - exact).abs() < 2e-6, "{name} tilt {tilt} height {height}: {found} {exact}");
                    assert_eq!(gap(cutter, &table, &pose, exact - 1e-3), Gap::Beyond);
                    let other = distance(gap(&table, cutter, &pose.inverse(), 100.0));
                    assert!((other - exact).abs() < 2e-6);
                }
            }
        }
    }

    #[test]
    fn overlapping_skins_meet() {
        let table = block();
        let ball = convex(Cutter::ball(10.0).expect("ball"), 30.0);
        let at = |z| Pose::from_translation(Vector::new(1.0, 2.0, z));
        assert!(matches!(gap(&ball, &table, &at(-1.0), 5.0), Gap::Meeting(_)));
        assert!(inside(&ball, &table, &at(1.0)).is_none());
        assert!((penetration(&ball, &table, &at(-1.5)) - 1.5).abs() < 1e-9);
    }

    #[test]
    fn meshes_have_the_distance_of_their_solids() {
        let table = block();
        let post = mesh(&cylinder_mesh(6.0, 0.0, 40.0, 64));
        let ring = mesh(&revolved_mesh(&[[0.0, 0.0], [20.0, 0.0], [20.0, 4.0], [0.0, 4.0]], 48));
        for k in 0..60 {
            let tilt = 0.02 * f64::from(k);
            let pose = Pose::from_translation(Vector::new(2.0, 1.0, 30.0)) * Pose::from_axis_angle(&Vector::y(), tilt);
            // The tilt is about y and one vertex of the rim lies in the plane of the tilt.
            for (shape, radius) in [(&post, 6.0), (&ring, 20.0)] {
                let exact = 30.0 - radius * tilt.sin();
                assert!((distance(gap(shape, &table, &pose, 100.0)) - exact).abs() < 1e-9);
                assert_eq!(gap(shape, &table, &pose, exact - 1e-6), Gap::Beyond);
            }
        }
        let inner = mesh(&cylinder_mesh(1.0, -11.0, -9.0, 12));
        assert!(matches!(gap(&inner, &table, &Pose::identity(), 100.0), Gap::At(d, ..) if (d - 9.0).abs() < 1e-9));
        assert!(inside(&inner, &table, &Pose::identity()).is_some());
        assert!(inside(&table, &inner, &Pose::identity()).is_some());
        assert!(inside(&post, &table, &Pose::from_translation(Vector::z())).is_none());
    }

    #[test]
    fn supports_are_the_highest_of_many_points() {
        use parry3d_f64::math::Vector as ParryVector;
        use parry3d_f64::shape::SupportMap;
        let barrel = Cutter::barrel(12.0, 3.0, 80.0, 25.0).expect("barrel").bodies(25.0).expect("bodies");
        let body = Revolved::new(&barrel[0]);
        // Chords of 8e-5 mm error: the finest that a picture of a radius of 80 mm has.
        let curve = body.profile().polyline(1e-7);
        for k in 0..500 {
            let a = 0.37 * f64::from(k);
            let w = (0.011 * f64::from(k) * 1.7).sin();
            let d = ParryVector::new(a.cos() * (1.0 - w * w).sqrt(), a.sin() * (1.0 - w * w).sqrt(), w);
            let exact = body.local_support_point(d).dot(d);
            let sampled =
                curve.iter().map(|p| p[0] * (1.0 - w * w).sqrt() + p[1] * w).fold(f64::NEG_INFINITY, f64::max);
            assert!(exact >= sampled - 1e-12 && exact <= sampled + 1e-4, "{w}: {exact} {sampled}");
        }
    }
}
