//! Bounded distances between shapes.

use parry3d_f64::math::Pose as ParryPose;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::query::details::closest_points_support_map_support_map_with_params;
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d_f64::shape::{SupportMap, Triangle};
use proveout_geom::{Point, Pose, Vector};

use crate::box_tree::{BoxTree, Effort, NearestLeaves, near_leaves_grown, nearest_leaf};
use crate::gjk;
use crate::shape::{MeshShape, PartShape, Revolved, from_parry, pose_to_parry, to_parry};
use crate::triangle;
use crate::triangle_tree::TriangleTree;

/// By how much less than the distance of a tool may be proved, mm, and as a part of it.
pub(crate) const PROVED_WITHIN_MM: f64 = 1e-7;
/// Rounds of nearest points in turn: a few are enough where GJK came near. Where the two points creep, the
/// search of `gjk.rs` goes on from them.
const MOST_PROJECTIONS: usize = 12;
/// Shorter products of edges and directions have no direction: zero alone.
const NOT_ZERO: f64 = 1e-300;

/// Answer to "how far apart, as far as nearer than a limit".
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Separation {
    /// At least as far as the limit asked for; the distance that is proved, mm.
    Beyond(f64),
    /// This far; the two nearest points, in the frame of the second shape.
    At(f64, Point, Point),
    /// Farther than needs to be known exactly: the distance that is proved, that of two points, and these in
    /// the frame of the second shape.
    Between([f64; 2], Point, Point),
    /// The skins meet; a point near there, in the frame of the second shape.
    Meeting(Point),
}

impl Separation {
    /// What both say together of two pairs of shapes: the distance of the nearer one.
    pub(crate) fn nearer(self, other: Self) -> Self {
        let most = |gap: &Self| match *gap {
            Self::Beyond(_) => f64::INFINITY,
            Self::At(d, ..) | Self::Between([_, d], ..) => d,
            Self::Meeting(_) => -1.0,
        };
        let least = |gap: &Self| match *gap {
            Self::Beyond(d) | Self::At(d, ..) | Self::Between([d, _], ..) => d,
            Self::Meeting(_) => -1.0,
        };
        let (near, far) = if most(&other) < most(&self) { (other, self) } else { (self, other) };
        match near {
            Self::Meeting(_) => near,
            Self::Beyond(d) => Self::Beyond(d.min(least(&far))),
            Self::At(d, p, q) if least(&far) < d => Self::Between([least(&far), d], p, q),
            Self::At(..) => near,
            Self::Between([low, high], p, q) => Self::Between([low.min(least(&far)), high], p, q),
        }
    }
}

/// What was nearest at the last look: triangle or convex body of the first shape, and of the second.
pub(crate) type WarmStart = Option<[u32; 2]>;

/// Distance of shape `a` from shape `b`: exact below the first limit, reported below the second
/// (mm). The skins count, not the inside. `warm` only makes it quicker.
pub(crate) fn gap(
    a: &PartShape,
    b: &PartShape,
    b_from_a: &Pose,
    [exact, limit]: [f64; 2],
    warm: &mut WarmStart,
) -> Separation {
    match (a, b) {
        // What is proved of two meshes is far more than any limit that would have been asked for, at the same
        // cost.
        (PartShape::Mesh(a), PartShape::Mesh(b)) => skins(&a.boxes, &b.boxes, b_from_a, [exact, f64::INFINITY], warm),
        _ => gap_with((a, b), b_from_a, [exact, limit], warm, &mut Effort::unlimited()),
    }
}

/// The same with an end to what it may cost: then [`Separation::Beyond`] may be nearer than the limit, and
/// what should be exact is [`Separation::Between`].
pub(crate) fn gap_with(
    (a, b): (&PartShape, &PartShape),
    b_from_a: &Pose,
    [exact, limit]: [f64; 2],
    warm: &mut WarmStart,
    effort: &mut Effort,
) -> Separation {
    match (a, b) {
        (PartShape::Convex(bodies), PartShape::Mesh(mesh)) => {
            bodies_mesh(bodies, mesh, b_from_a, (limit, effort), warm)
        }
        (PartShape::Mesh(a), PartShape::Mesh(b)) => {
            skins_with((&a.boxes, &b.boxes), b_from_a, [exact, limit], warm, effort)
        }
        (PartShape::Mesh(mesh), PartShape::Convex(bodies)) => {
            turned(bodies_mesh(bodies, mesh, &b_from_a.inverse(), (limit, effort), warm), b_from_a)
        }
        (PartShape::Convex(x), PartShape::Convex(y)) => convex_convex(x, y, b_from_a, limit),
    }
}

/// The same answer with the shapes exchanged; points go from the frame of a to that of b.
fn turned(gap: Separation, b_from_a: &Pose) -> Separation {
    match gap {
        Separation::Beyond(_) => gap,
        Separation::At(d, p, q) => Separation::At(d, b_from_a.point(&q), b_from_a.point(&p)),
        Separation::Between(d, p, q) => Separation::Between(d, b_from_a.point(&q), b_from_a.point(&p)),
        Separation::Meeting(p) => Separation::Meeting(b_from_a.point(&p)),
    }
}

fn convex_convex(x: &[Revolved], y: &[Revolved], b_from_a: &Pose, limit: f64) -> Separation {
    let pose = pose_to_parry(&b_from_a.inverse());
    let mut best = Separation::Beyond(limit);
    let mut bound = limit;
    for p in x {
        for q in y {
            let mut simplex = VoronoiSimplex::new();
            let found = closest_points_support_map_support_map_with_params(&pose, p, q, bound, &mut simplex, None);
            let start = match found {
                GJKResult::ClosestPoints(u, v, _) => b_from_a.point(&from_parry(u)) - from_parry(v),
                // It says so of bodies that are apart by micrometers as well.
                GJKResult::Intersection => b_from_a.point(&p.middle()) - q.middle(),
                GJKResult::NoIntersection(_) | GJKResult::Proximity(_) => continue,
            };
            let supports = |along: &Vector| {
                let high = b_from_a.point(&support(p, &b_from_a.rotation.tr_mul(along)));
                [high, support(q, &-along)]
            };
            let found = gjk::nearest(supports, &-start, [PROVED_WITHIN_MM, bound]);
            if found.meet || found.proved <= 0.0 {
                return Separation::Meeting(q.middle());
            }
            if found.proved < bound {
                (best, bound) = (Separation::At(found.proved, found.on_first, found.on_second), found.proved);
            }
        }
    }
    best
}

fn support(body: &Revolved, along: &Vector) -> Point {
    from_parry(body.local_support_point(to_parry(&Point::from(*along))))
}

/// Bodies of a tool one after the other, the one that was nearest last time first.
fn bodies_mesh(
    bodies: &[Revolved],
    mesh: &MeshShape,
    mesh_from_body: &Pose,
    (limit, effort): (f64, &mut Effort),
    warm: &mut WarmStart,
) -> Separation {
    let before = *warm;
    let first = before.map_or(0, |w| w[0] as usize).min(bodies.len().saturating_sub(1));
    let order = std::iter::once(first).chain((0..bodies.len()).filter(|k| *k != first));
    let mut best = None;
    let mut bound = limit;
    // Nothing is nearer than this, of what the search has not looked at to the end.
    let mut proved = f64::INFINITY;
    for k in order.take(bodies.len()) {
        let start = before.filter(|w| w[0] as usize == k).map(|w| w[1]);
        let (found, triangle) = convex_mesh(&bodies[k], mesh, mesh_from_body, (bound, effort), start);
        match found {
            Separation::Meeting(_) => {
                *warm = Some([k as u32, triangle]);
                return found;
            }
            Separation::At(d, p, q) | Separation::Between([_, d], p, q) => {
                if let Separation::Between([least, _], ..) = found {
                    proved = proved.min(least);
                }
                (best, bound) = (Some((p, q)), d);
                *warm = Some([k as u32, triangle]);
            }
            Separation::Beyond(least) => proved = proved.min(least),
        }
    }
    match best {
        None => Separation::Beyond(proved),
        Some((p, q)) if proved < bound => Separation::Between([proved, bound], p, q),
        Some((p, q)) => Separation::At(bound, p, q),
    }
}

/// Branch and bound over the tree of the mesh; gives the nearest triangle, too. The bound of a node is the
/// largest of three: boxes apart; the distance of the node's middle from the axis of the body less half its
/// diagonal less the radius, which is the sharp one for a long slanted tool, whose box is fat; and, where
/// these are not enough, planes across the way to its box along the wall that its triangles make
/// (`triangle_tree.rs`).
fn convex_mesh(
    body: &Revolved,
    mesh: &MeshShape,
    mesh_from_body: &Pose,
    (limit, effort): (f64, &mut Effort),
    warm: Option<u32>,
) -> (Separation, u32) {
    let placed = BodyInMesh {
        mesh_from_body: *mesh_from_body,
        body_from_mesh: mesh_from_body.inverse(),
        parry: pose_to_parry(mesh_from_body),
    };
    let (low, high, radius) = body.capsule();
    let (low, high) = (mesh_from_body.point(&low), mesh_from_body.point(&high));
    let axis = high - low;
    let length2 = axis.norm_squared();
    // Box of a cylinder: the axis, and the radius times the sine of its angle to each coordinate axis.
    let unit = if length2 > 0.0 { axis / length2.sqrt() } else { axis };
    let across = unit.map(|u| radius * (1.0 - (u * u).min(1.0)).max(0.0).sqrt());
    let (box_middle, box_half) = (nalgebra::center(&low, &high), axis.abs() * 0.5 + across);
    let (spine, _, _) = body.spine();
    let spine = mesh_from_body.point(&spine);
    let highest = |along: &Vector| highest(body, mesh_from_body, along);
    let round = body.ball().map_or(0.0, |(_, radius)| radius);
    let amid = |p: &Point| on_segment(p, [&spine, &high]);
    let apart = |node: u32, bound: f64| {
        let (middle, half) = mesh.boxes.bounds(node);
        let outside = ((middle - box_middle).abs() - box_half - half).map(|x| x.max(0.0)).norm();
        let from_axis = from_segment(&middle, [&spine, &high]) - half.norm() - radius;
        let of_box = from_axis.max(outside);
        if of_box >= bound { of_box } else { of_box.max(mesh.boxes.node_distance(node, amid, highest, (round, bound))) }
    };
    let of = |item: u32, bound: f64| body_triangle(body, mesh.boxes.corners(item), &placed, item, bound);
    let start = warm.filter(|i| (*i as usize) < mesh.boxes.triangles().len()).map(|i| of(i, limit));
    match nearest_leaf(&*mesh.boxes, apart, (limit, effort), start, of) {
        NearestLeaves::Beyond(proved) => (Separation::Beyond(proved), 0),
        NearestLeaves::At(_, TriangleTouch { meeting: true, p, item, .. }) => (Separation::Meeting(p), item),
        NearestLeaves::At(d, TriangleTouch { p, q, item, .. }) => (Separation::At(d, q, p), item),
        NearestLeaves::Between(d, TriangleTouch { p, q, item, .. }) => (Separation::Between(d, q, p), item),
    }
}

/// Where on a segment it is nearest to a point, 0 to 1.
pub(crate) fn along_segment(p: &Point, [a, b]: [&Point; 2]) -> f64 {
    let (way, to) = (b - a, p - a);
    let length2 = way.norm_squared();
    if length2 > 0.0 { (to.dot(&way) / length2).clamp(0.0, 1.0) } else { 0.0 }
}

/// The point of a segment that is nearest to another one.
pub(crate) fn on_segment(p: &Point, [a, b]: [&Point; 2]) -> Point {
    a + (b - a) * along_segment(p, [a, b])
}

/// Distance of a point from a segment, mm.
pub(crate) fn from_segment(p: &Point, segment: [&Point; 2]) -> f64 {
    (p - on_segment(p, segment)).norm()
}

/// Two points near each other, on the triangle of this number and on the body.
struct TriangleTouch {
    meeting: bool,
    p: Point,
    q: Point,
    item: u32,
}

/// The iteration of GJK stops where its two points are near enough to each other, or where it gets no
/// further: the distance of its points is above the true one, near contact by up to a micrometer. So it is
/// taken as a beginning only. What is given is the separation of two parallel planes with the triangle on one
/// side and the body on the other: their distance, got from two supports, is proved. The direction is
/// improved by nearest points in turn (alternating projections; each of them exact) until proof and points
/// agree.
fn body_triangle(
    body: &Revolved,
    corners: &[Point; 3],
    pose: &BodyInMesh,
    item: u32,
    bound: f64,
) -> (f64, TriangleTouch) {
    let [a, b, c] = corners.map(|p| to_parry(&p));
    let triangle = Triangle::new(a, b, c);
    let mut simplex = VoronoiSimplex::new();
    let touch = |meeting, p, q| TriangleTouch { meeting, p, q, item };
    if let Some((proved, p, q)) = ball_end(body, corners, &pose.mesh_from_body, bound) {
        return (proved, touch(false, p, q));
    }
    let begin =
        closest_points_support_map_support_map_with_params(&pose.parry, &triangle, body, bound, &mut simplex, None);
    let (mut p, mut q, mut proved) = match begin {
        GJKResult::ClosestPoints(p, q, _) => (from_parry(p), from_parry(q), f64::NEG_INFINITY),
        // Where edges and lines of the body are almost parallel it may say so of bodies that are apart: that
        // is looked into.
        GJKResult::Intersection => {
            let q = pose.mesh_from_body.point(&body.middle());
            (triangle::point_triangle(q, corners).on_second, q, f64::NEG_INFINITY)
        }
        GJKResult::NoIntersection(along) | GJKResult::Proximity(along) => {
            let proved = separation(body, corners, &pose.mesh_from_body, &from_parry(along).coords);
            if proved >= bound {
                return (proved, touch(false, corners[0], corners[0]));
            }
            // It gave up: from the middle of the body on.
            let q = pose.mesh_from_body.point(&body.middle());
            (triangle::point_triangle(q, corners).on_second, q, proved)
        }
    };
    for _ in 0..MOST_PROJECTIONS {
        let between = q - p;
        let apart = between.norm();
        if apart > 0.0 {
            proved = proved.max(separation(body, corners, &pose.mesh_from_body, &(between / apart)));
        }
        if apart - proved <= PROVED_WITHIN_MM * (1.0 + apart) || proved >= bound {
            return (proved.max(0.0), touch(proved <= 0.0, p, q));
        }
        let Some(nearest) = body.nearest(&pose.body_from_mesh.point(&p)) else { return (0.0, touch(true, p, p)) };
        q = pose.mesh_from_body.point(&nearest);
        p = triangle::point_triangle(q, corners).on_second;
    }
    // A side along the axis and a face or edge almost parallel to it: the two points creep along. The planes
    // that lie on the face, or on an edge and the axis, prove what is to be proved there; else the search
    // that ends where proof and points agree.
    for along in parallel_planes(corners, &pose.mesh_from_body.vector(&Vector::z())) {
        proved = proved.max(separation(body, corners, &pose.mesh_from_body, &along));
    }
    let apart = (q - p).norm();
    if apart - proved <= PROVED_WITHIN_MM * (1.0 + apart) || proved >= bound {
        return (proved.max(0.0), touch(proved <= 0.0, p, q));
    }
    let supports = |along: &Vector| {
        let local = pose.mesh_from_body.rotation.tr_mul(&-along);
        [highest_corner(corners, along), pose.mesh_from_body.point(&support(body, &local))]
    };
    let found = gjk::nearest(supports, &(q - p), [PROVED_WITHIN_MM, bound]);
    if found.apart < apart {
        (p, q) = (found.on_first, found.on_second);
    }
    proved = proved.max(found.proved);
    (proved.max(0.0), touch(found.meet || proved <= 0.0, p, q))
}

/// The corner of a triangle that is farthest along a direction.
fn highest_corner(corners: &[Point; 3], along: &Vector) -> Point {
    let height = |p: &Point| p.coords.dot(along);
    corners.iter().fold(corners[0], |best, p| if height(p) > height(&best) { *p } else { best })
}

/// The distance of a triangle from a body whose ball end is what is nearest, or one above the bound, and the
/// points: the planes across the way from the center of the ball to the triangle prove it, since the support
/// of the body there is that of its ball. None where it is not, or they may meet.
fn ball_end(body: &Revolved, corners: &[Point; 3], mesh_from_body: &Pose, bound: f64) -> Option<(f64, Point, Point)> {
    let (center, radius) = body.ball()?;
    let center = mesh_from_body.point(&center);
    let p = triangle::point_triangle(center, corners).on_second;
    let way = p - center;
    let far = way.norm();
    if far <= radius {
        return None;
    }
    let along = way / far;
    // From the body to the triangle; `separation` takes the opposite direction.
    let proved = separation(body, corners, mesh_from_body, &-along);
    (proved >= bound || proved >= (far - radius) - PROVED_WITHIN_MM).then(|| (proved, p, center + along * radius))
}

/// Unit normals to both sides of a triangle, and of the planes that hold one of its edges and a direction.
fn parallel_planes(corners: &[Point; 3], axis: &Vector) -> impl Iterator<Item = Vector> {
    let [a, b, c] = *corners;
    let edges = [b - a, c - b, a - c];
    let all = [edges[0].cross(&edges[1]), edges[0].cross(axis), edges[1].cross(axis), edges[2].cross(axis)];
    all.into_iter().filter_map(|n| n.try_normalize(NOT_ZERO)).flat_map(|n| [n, -n])
}

/// Pose of a body in the frame of a mesh, the way back, and the same for the query library.
struct BodyInMesh {
    mesh_from_body: Pose,
    body_from_mesh: Pose,
    parry: ParryPose,
}

/// Width of the gap between a triangle and a body along a unit vector of the frame of the mesh, mm; never
/// above their distance.
fn separation(body: &Revolved, corners: &[Point; 3], mesh_from_body: &Pose, along: &Vector) -> f64 {
    let high = corners.iter().map(|p| p.coords.dot(along)).fold(f64::NEG_INFINITY, f64::max);
    -highest(body, mesh_from_body, &-along) - high
}

/// Largest component of the points of a body along a direction of the frame of the mesh, mm.
fn highest(body: &Revolved, mesh_from_body: &Pose, along: &Vector) -> f64 {
    body.height(&mesh_from_body.rotation.tr_mul(along)) + mesh_from_body.translation.dot(along)
}

/// Both trees at once, starting with the triangles that were nearest last time; limits as in [`gap`].
pub(crate) fn skins(
    a: &TriangleTree,
    b: &TriangleTree,
    b_from_a: &Pose,
    limits: [f64; 2],
    warm: &mut WarmStart,
) -> Separation {
    skins_with((a, b), b_from_a, limits, warm, &mut Effort::unlimited())
}

/// The same with no more than some effort: then what is proved may be below the limit
/// ([`Separation::Beyond`]), or below the first limit and not exact.
pub(crate) fn skins_with(
    (a, b): (&TriangleTree, &TriangleTree),
    b_from_a: &Pose,
    limits: [f64; 2],
    warm: &mut WarmStart,
    effort: &mut Effort,
) -> Separation {
    let of = |i: u32, j: u32, bound: f64| {
        let moved = a.corners(i).map(|p| b_from_a.point(&p));
        let near = triangle::nearest_within(&moved, b.corners(j), bound);
        (near.square.sqrt(), (near.on_first, near.on_second, [i, j]))
    };
    let known = |w: &[u32; 2]| (w[0] as usize) < a.triangles().len() && (w[1] as usize) < b.triangles().len();
    let start = warm.filter(known).map(|[i, j]| of(i, j, limits[1]));
    match near_leaves_grown((a, b), b_from_a, ([Vector::zeros(); 2], effort), limits, start, of) {
        NearestLeaves::Beyond(proved) => Separation::Beyond(proved),
        NearestLeaves::Between(d, (p, q, items)) => {
            *warm = Some(items);
            Separation::Between(d, p, q)
        }
        NearestLeaves::At(d, (p, q, items)) => {
            *warm = Some(items);
            if d > 0.0 { Separation::At(d, p, q) } else { Separation::Meeting(q) }
        }
    }
}

/// A point of one shape that lies inside of the other although the skins are apart, in the frame of `b`.
pub(crate) fn inside(a: &PartShape, b: &PartShape, b_from_a: &Pose) -> Option<Point> {
    match (a, b) {
        (PartShape::Convex(bodies), PartShape::Mesh(mesh)) => {
            let a_from_b = b_from_a.inverse();
            let tool_inside = bodies.iter().map(|c| b_from_a.point(&c.middle())).find(|p| mesh.contains(p));
            tool_inside.or_else(|| {
                let mut shells = mesh.shells.iter();
                shells.find(|p| bodies.iter().any(|c| c.signed_distance(&a_from_b.point(p)) < 0.0)).copied()
            })
        }
        (PartShape::Mesh(x), PartShape::Mesh(y)) => {
            let a_from_b = b_from_a.inverse();
            let x_inside = x.shells.iter().map(|p| b_from_a.point(p)).find(|p| y.contains(p));
            x_inside.or_else(|| y.shells.iter().find(|p| x.contains(&a_from_b.point(p))).copied())
        }
        (PartShape::Mesh(_), PartShape::Convex(_)) => inside(b, a, &b_from_a.inverse()).map(|p| b_from_a.point(&p)),
        (PartShape::Convex(x), PartShape::Convex(y)) => {
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

/// How deep one shape reaches into the other, mm: the largest depth of points of each inside of the other. A
/// lower estimate, since only vertices and points on the generating curves are tried.
pub(crate) fn penetration(a: &PartShape, b: &PartShape, b_from_a: &Pose) -> f64 {
    let a_from_b = b_from_a.inverse();
    let of_a = probes(a).map(|p| depth_in(b, &b_from_a.point(&p))).fold(0.0, f64::max);
    let of_b = probes(b).map(|p| depth_in(a, &a_from_b.point(&p))).fold(0.0, f64::max);
    of_a.max(of_b)
}

fn probes(shape: &PartShape) -> Box<dyn Iterator<Item = Point> + '_> {
    match shape {
        PartShape::Mesh(m) => {
            let stride = m.tree.vertices().len().div_ceil(MOST_VERTICES).max(1);
            Box::new(m.vertices().step_by(stride))
        }
        PartShape::Convex(bodies) => Box::new(bodies.iter().flat_map(|b| {
            b.profile().polyline(CURVE_MM).into_iter().flat_map(|[r, z]| {
                (0..SECTORS).map(move |k| {
                    let (s, c) = proveout_geom::sin_cos(std::f64::consts::TAU * f64::from(k) / f64::from(SECTORS));
                    Point::new(r * c, r * s, z)
                })
            })
        })),
    }
}

fn depth_in(shape: &PartShape, p: &Point) -> f64 {
    match shape {
        PartShape::Convex(bodies) => bodies.iter().map(|b| -b.signed_distance(p)).fold(0.0, f64::max),
        PartShape::Mesh(m) => {
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

    fn mesh(m: &proveout_geom::TriMesh) -> PartShape {
        PartShape::Mesh(Box::new(MeshShape::new(m).expect("solid")))
    }

    fn convex(cutter: Cutter, length: f64) -> PartShape {
        PartShape::Convex(cutter.bodies(length).expect("bodies").iter().map(Revolved::new).collect())
    }

    fn block() -> PartShape {
        mesh(&box_mesh(&Aabb { min: Point::new(-50.0, -50.0, -20.0), max: Point::new(50.0, 50.0, 0.0) }))
    }

    fn distance(g: Separation) -> f64 {
        match g {
            Separation::At(d, p, q) => {
                assert!((0.0..1e-6 * (1.0 + d)).contains(&((p - q).norm() - d + 1e-12)), "{p} {q} {d}");
                d
            }
            Separation::Meeting(_) => 0.0,
            Separation::Beyond(_) | Separation::Between(..) => f64::INFINITY,
        }
    }

    /// Of a tool the points are nearer to each other than what is proved by its uncertainty only.
    fn gap_of(a: &PartShape, b: &PartShape, b_from_a: &Pose, limit: f64) -> Separation {
        super::gap(a, b, b_from_a, [limit; 2], &mut None)
    }

    /// Without a warm start.
    fn gap(a: &PartShape, b: &PartShape, b_from_a: &Pose, limit: f64) -> Separation {
        super::gap(a, b, b_from_a, [limit; 2], &mut None)
    }

    /// A limit that is missed; what is proved lies between it and the distance.
    fn is_beyond(g: Separation, limit: f64, exact: f64) -> bool {
        matches!(g, Separation::Beyond(proved) | Separation::Between([proved, _], ..) if limit <= proved && proved <= exact + 1e-9)
    }

    /// Lowest point of a body of revolution tilted by `tilt` about y: the support in the direction of -z, in
    /// closed form.
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
                    assert!(is_beyond(gap(cutter, &table, &pose, exact - 1e-3), exact - 1e-3, exact));
                    let other = distance(gap(&table, cutter, &pose.inverse(), 100.0));
                    assert!((other - exact).abs() < 2e-6);
                }
            }
        }
    }

    /// Heights from a nanometer to a centimeter over a face, bodies of every kind, tilted: the distance is
    /// proved, so never above the true one, and below it by no more than is said.
    #[test]
    fn distances_of_tools_are_proved_near_contact_as_well() {
        use parry3d_f64::shape::SupportMap;
        let cutters = [
            ("ball", Cutter::ball(10.0).expect("ball")),
            ("flat", Cutter::flat(10.0).expect("flat")),
            ("bull", Cutter::bull_nose(10.0, 2.0).expect("bull")),
            ("cone", Cutter::chamfer(8.0, 90.0, 0.0).expect("cone")),
            ("barrel", Cutter::barrel(12.0, 3.0, 80.0, 25.0).expect("barrel")),
        ];
        let table = block();
        for (name, cutter) in cutters {
            let bodies = cutter.bodies(25.0).expect("bodies");
            let shape = PartShape::Convex(bodies.iter().map(Revolved::new).collect());
            for height in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0] {
                for k in 0..300 {
                    let turn = Pose::from_axis_angle(&Vector::new(0.6, 0.8, 0.0), 0.0051 * f64::from(k));
                    let down = to_parry(&Point::from(turn.inverse().vector(&-Vector::z())));
                    let lowest =
                        bodies.iter().map(|b| turn.point(&from_parry(Revolved::new(b).local_support_point(down))).z);
                    let lowest = lowest.fold(f64::INFINITY, f64::min);
                    let pose =
                        Pose { translation: Vector::new(1.0 + 0.1 * f64::from(k % 40), 0.3, height - lowest), ..turn };
                    let found = distance(gap_of(&shape, &table, &pose, 100.0));
                    assert!(found <= height + 1e-12, "{name} {k} {height}: {found}");
                    assert!(
                        height - found <= PROVED_WITHIN_MM * (1.0 + height),
                        "{name} {k} {height}: {:e}",
                        height - found
                    );
                }
            }
        }
    }

    #[test]
    fn overlapping_skins_meet() {
        let table = block();
        let ball = convex(Cutter::ball(10.0).expect("ball"), 30.0);
        let at = |z| Pose::from_translation(Vector::new(1.0, 2.0, z));
        assert!(matches!(gap(&ball, &table, &at(-1.0), 5.0), Separation::Meeting(_)));
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
                assert!(is_beyond(gap(shape, &table, &pose, exact - 1e-6), exact - 1e-6, exact));
            }
        }
        let inner = mesh(&cylinder_mesh(1.0, -11.0, -9.0, 12));
        assert!(
            matches!(gap(&inner, &table, &Pose::identity(), 100.0), Separation::At(d, ..) if (d - 9.0).abs() < 1e-9)
        );
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
            assert!((body.height(&from_parry(d * 3.0).coords) - 3.0 * exact).abs() < 1e-12, "{w}");
            let sampled =
                curve.iter().map(|p| p[0] * (1.0 - w * w).sqrt() + p[1] * w).fold(f64::NEG_INFINITY, f64::max);
            assert!(exact >= sampled - 1e-12 && exact <= sampled + 1e-4, "{w}: {exact} {sampled}");
        }
    }
}
