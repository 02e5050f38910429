//! Distance of a body that may be at many places from another: one bound for all of them at once.
//!
//! With the rotary joints held, slides only shift a body: a place within their ranges is `sum s_k g_k` with `-1 <= s_k <= 1`, so that all places
//! together are the body and a *zonotope* Z added (Minkowski). A triangle and Z, or a convex body and Z, have the support
//!
//! ```text
//!    h(n) = h_body(n) + sum |g_k n|               dist(body + Z, other) = min over all places of dist(body, other)
//! ```
//!
//! and are convex: two planes across a direction that GJK finds prove their distance. A slide that passes beside a wall keeps its distance in
//! this bound, however far it goes, where a bound by the length of its way (Mirtich 1996) would have to be cut into pieces of a micrometer; it is
//! the bound along the separating normal of Tang, Kim and Manocha (2009), taken for each two triangles.
//!
//! Where joints turn as well, a short way is the hull of the body at both of its ends: each point goes almost straight from one to the other.

use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::query::details::closest_points_support_map_support_map_with_params;
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;
use proveout_geom::{Point, Pose, Vector};
use proveout_machine::{JointValues, MAX_JOINTS};

use crate::boxes::{BoxTree, Effort, NearestLeaves, TriangleTree, near_leaves_grown, nearest_leaf};
use crate::distance::from_segment;
use crate::shape::{Revolved, Shape, from_parry, to_parry};
use crate::triangle;

/// Shortest vector that counts as a shift, mm.
const SHIFT_MM: f64 = 1e-9;

/// By how much less than the distance of a ball its planes may prove, mm: rounding.
const BALL_WITHIN_MM: f64 = 1e-7;

/// Effort for one bound: what takes more is better cut into shorter stretches.
const MOST_EFFORT: u64 = 1000;

/// Where a body may stand, in the frame of the other: at one of two poses, or with each of its points straight between (the hull of both), and
/// shifted by -1 to 1 of each of some vectors, mm.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    pub(crate) poses: [Pose; 2],
    shifts: Vec<Vector>,
}

impl Places {
    pub(crate) fn between(poses: [Pose; 2]) -> Self {
        Self { poses, shifts: Vec::new() }
    }

    pub(crate) fn at(pose: Pose) -> Self {
        Self::between([pose; 2])
    }

    pub(crate) fn shift(&mut self, way: Vector) {
        if way.norm() > SHIFT_MM {
            self.shifts.push(way);
        }
    }

    /// The pose, where there is but one.
    pub(crate) fn single(&self) -> Option<Pose> {
        (self.shifts.is_empty() && self.poses[0] == self.poses[1]).then_some(self.poses[0])
    }

    /// Half edges of the box of the shifts.
    fn half(&self) -> Vector {
        self.shifts.iter().fold(Vector::zeros(), |sum, g| sum + g.abs())
    }

    /// How far the points of a box may be from where the first pose puts them, along the axes of the other frame; a box goes farthest at a corner.
    fn farthest_from_first(&self, middle: &Point, half: &Vector) -> Vector {
        let [first, second] = &self.poses;
        let corner = |k: u8| {
            let sign = |bit: u8| if k & bit == 0 { -1.0 } else { 1.0 };
            middle + half.component_mul(&Vector::new(sign(1), sign(2), sign(4)))
        };
        let way = |k: u8| (second.point(&corner(k)) - first.point(&corner(k))).abs();
        (0..8).fold(Vector::zeros(), |most, k| most.sup(&way(k))) + self.half()
    }

    fn shifted(&self, along: &Vector) -> Vector {
        self.shifts.iter().fold(Vector::zeros(), |sum, g| if g.dot(along) > 0.0 { sum + g } else { sum - g })
    }
}

/// A triangle in all its places.
struct Triangle<'a> {
    corners: [[Point; 3]; 2],
    places: Option<&'a Places>,
}

impl<'a> Triangle<'a> {
    fn moved(corners: &[Point; 3], places: &'a Places) -> Self {
        let [first, second] = &places.poses;
        Self { corners: [corners.map(|p| first.point(&p)), corners.map(|p| second.point(&p))], places: Some(places) }
    }

    fn still(corners: &[Point; 3]) -> Self {
        Self { corners: [*corners; 2], places: None }
    }
}

impl SupportMap for Triangle<'_> {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        let along = from_parry(direction).coords;
        let mut best = (f64::NEG_INFINITY, self.corners[0][0]);
        for p in self.corners.iter().take(if self.places.is_some() { 2 } else { 1 }).flatten() {
            let height = p.coords.dot(&along);
            if height > best.0 {
                best = (height, *p);
            }
        }
        to_parry(&self.places.map_or(best.1, |places| best.1 + places.shifted(&along)))
    }
}

/// A body of revolution in all its places.
struct Body<'a> {
    body: &'a Revolved,
    places: &'a Places,
}

impl SupportMap for Body<'_> {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        let along = from_parry(direction).coords;
        let of = |pose: &Pose| {
            let local = pose.rotation.tr_mul(&along);
            pose.point(&from_parry(self.body.local_support_point(to_parry(&Point::from(local)))))
        };
        let [first, second] = self.places.poses.each_ref().map(of);
        let best = if first.coords.dot(&along) >= second.coords.dot(&along) { first } else { second };
        to_parry(&(best + self.places.shifted(&along)))
    }
}

/// By how much points may leave the hull of both ends of a straight motion of the joints, where they are nearer to the other body than `wanted`, mm: at most
/// an eighth of their second derivative (text of `least/search.rs`). `weights` say how far a point goes for a unit of each joint, `turns` which joints
/// turn, `of_b` which carry the other body, `way` how far each goes.
pub(crate) fn bent(
    weights: &[f64; MAX_JOINTS],
    turns: &[bool; MAX_JOINTS],
    of_b: &[bool; MAX_JOINTS],
    way: &JointValues,
    wanted: f64,
) -> f64 {
    let moves = |j: usize| if weights[j] > 0.0 { way[j].abs() } else { 0.0 };
    let turn: f64 = (0..MAX_JOINTS).filter(|&j| turns[j]).map(moves).sum();
    let motion: f64 = (0..MAX_JOINTS).map(|j| weights[j] * way[j].abs()).sum();
    let farther: f64 = (0..MAX_JOINTS).filter(|&j| turns[j] && of_b[j]).map(moves).sum();
    0.25 * turn * (motion + farther * (wanted + motion))
}

/// Proved distance of two convex bodies in one frame, as far as below `limit`; zero where none is proved.
fn proved(a: &impl SupportMap, b: &impl SupportMap, limit: f64) -> f64 {
    let across = |along: &Vector| {
        let high = a.local_support_point(to_parry(&Point::from(*along)));
        let low = b.local_support_point(to_parry(&Point::from(-along)));
        (from_parry(low) - from_parry(high)).dot(along)
    };
    let identity = ParryPose::IDENTITY;
    let mut simplex = VoronoiSimplex::new();
    match closest_points_support_map_support_map_with_params(&identity, a, b, limit, &mut simplex, None) {
        GJKResult::ClosestPoints(p, q, along) => {
            let between = from_parry(q) - from_parry(p);
            let by_points = between.try_normalize(0.0).map_or(0.0, |n| across(&n));
            let along = from_parry(along).coords.try_normalize(0.0).map_or(0.0, |n| across(&n));
            by_points.max(along).max(0.0)
        }
        GJKResult::NoIntersection(along) | GJKResult::Proximity(along) => {
            from_parry(along).coords.try_normalize(0.0).map_or(0.0, |n| across(&n)).max(0.0)
        }
        GJKResult::Intersection => 0.0,
    }
}

/// Lower bound of the distance of shape `a` in all its places from shape `b`, mm; exact but for rounding below `limit`, and at least the limit
/// elsewhere. Of two meshes the skins count, not the inside; nothing is proved of a mesh against a convex body.
pub(crate) fn least_distance(a: &Shape, b: &Shape, places: &Places, limit: f64) -> f64 {
    least_distance_with((a, b), places, limit, &mut Effort::unlimited())
}

/// The same, with what it has cost; of a tool and a mesh it ends with less proved where that is the most.
pub(crate) fn least_distance_with((a, b): (&Shape, &Shape), places: &Places, limit: f64, effort: &mut Effort) -> f64 {
    match (a, b) {
        (Shape::Mesh(a), Shape::Mesh(b)) => least_of_skins(&a.boxes, &b.boxes, places, limit),
        (Shape::Convex(bodies), Shape::Mesh(b)) => bodies_skin(bodies, &b.boxes, places, (limit, effort)),
        (Shape::Convex(a), Shape::Convex(b)) => {
            let still = Places::at(Pose::identity());
            let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
            let of = |limit: f64, (a, b)| {
                limit.min(proved(&Body { body: a, places }, &Body { body: b, places: &still }, limit))
            };
            pairs.fold(limit, of)
        }
        (Shape::Mesh(_), Shape::Convex(_)) => 0.0,
    }
}

/// The same of two skins.
pub(crate) fn least_of_skins(a: &TriangleTree, b: &TriangleTree, places: &Places, limit: f64) -> f64 {
    let Some(whole) = a.root() else { return f64::INFINITY };
    let of = |i: u32, j: u32, bound: f64| {
        (proved(&Triangle::moved(a.corners(i), places), &Triangle::still(b.corners(j)), bound), ())
    };
    let (middle, half) = a.bounds(whole);
    let in_b = places.farthest_from_first(&middle, &half);
    let b_from_a = &places.poses[0];
    let in_a = b_from_a.rotation.abs().tr_mul(&in_b);
    let limits = [f64::INFINITY, limit];
    let mut effort = Effort::at_most(MOST_EFFORT);
    distance(near_leaves_grown((a, b), b_from_a, ([in_a, in_b], &mut effort), limits, None, of))
}

/// Proved distance of a triangle from a body with a ball end that goes straight from one place to the other, where it is above the limit or the ball is
/// what is nearest: the ball in all its places is a capsule, and the planes across the way from its axis to the triangle prove a distance.
fn ball_end(placed: &Body<'_>, triangle: &Triangle<'_>, limit: f64) -> Option<f64> {
    let (center, radius) = placed.body.ball()?;
    if !placed.places.shifts.is_empty() {
        return None;
    }
    let [from, to] = placed.places.poses.each_ref().map(|pose| pose.point(&center));
    let across = |way: Vector| {
        let along = way.try_normalize(0.0)?;
        let high = placed.local_support_point(to_parry(&Point::from(along)));
        let low = triangle.local_support_point(to_parry(&Point::from(-along)));
        Some((from_parry(low) - from_parry(high)).dot(&along))
    };
    // Mostly one of the ends is nearest, or tells enough.
    let ends = [from, to].map(|p| triangle::point_triangle(p, &triangle.corners[0]).on_second - p);
    let nearer = if ends[0].norm_squared() <= ends[1].norm_squared() { ends[0] } else { ends[1] };
    if let Some(proved) = across(nearer).filter(|proved| *proved >= limit) {
        return Some(proved);
    }
    let near = triangle::nearest_within(&[from, to, to], &triangle.corners[0], f64::INFINITY);
    let far = near.square.sqrt();
    if far <= radius {
        return None;
    }
    let proved = across(near.on_second - near.on_first)?;
    (proved >= limit || proved >= (far - radius) - BALL_WITHIN_MM).then(|| proved.max(0.0))
}

fn bodies_skin(bodies: &[Revolved], skin: &TriangleTree, places: &Places, (limit, effort): (f64, &mut Effort)) -> f64 {
    let mut least = f64::INFINITY;
    for body in bodies {
        let round = |pose: &Pose| {
            let (low, high, radius) = body.capsule();
            let (low, high) = (pose.point(&low), pose.point(&high));
            let unit = (high - low).try_normalize(0.0).unwrap_or_else(Vector::z);
            let across = unit.map(|u| radius * (1.0 - (u * u).min(1.0)).max(0.0).sqrt());
            (low.inf(&high) - across, low.sup(&high) + across)
        };
        let [first, second] = places.poses.each_ref().map(round);
        let (low, high) = (first.0.inf(&second.0), first.1.sup(&second.1));
        let (middle, half) = (nalgebra::center(&low, &high), (high - low) * 0.5 + places.half());
        // Of the hull of both places no point is farther from the spine at the first than its radius and the way of its ends.
        let (from, to, radius) = body.spine();
        let spines = places.poses.each_ref().map(|pose| [pose.point(&from), pose.point(&to)]);
        let way = (spines[1][0] - spines[0][0]).norm().max((spines[1][1] - spines[0][1]).norm());
        let reach = radius + way + places.shifts.iter().map(Vector::norm).sum::<f64>();
        let apart = |m: &Point, h: &Vector| {
            let outside = ((m - middle).abs() - half - h).map(|x| x.max(0.0)).norm();
            outside.max(from_segment(m, spines[0].each_ref()) - h.norm() - reach)
        };
        let placed = Body { body, places };
        let of = |item: u32, bound: f64| {
            let triangle = Triangle::still(skin.corners(item));
            let by_ball = ball_end(&placed, &triangle, bound);
            (by_ball.unwrap_or_else(|| proved(&placed, &triangle, bound)), ())
        };
        least = least.min(distance(nearest_leaf(skin, apart, (limit.min(least), &mut *effort), None, of)));
    }
    least
}

fn distance(found: NearestLeaves<()>) -> f64 {
    match found {
        NearestLeaves::Beyond(proved) | NearestLeaves::At(proved, ()) => proved,
        NearestLeaves::Between([proved, _], ()) => proved,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proveout_geom::{Aabb, box_mesh};
    use proveout_tool::Cutter;

    /// A ball that goes askew over a wall, past a wall and through it: by closed forms, whatever the limit.
    #[test]
    fn all_places_of_a_slide_are_one_distance() {
        let wall = box_mesh(&Aabb { min: Point::new(-0.1, -30.0, 0.0), max: Point::new(0.1, 30.0, 17.7) });
        let cutter = Cutter::ball(12.0).expect("ball").bodies(20.0).expect("bodies");
        let ball = Shape::Convex(cutter.iter().map(Revolved::new).collect());
        let mesh = Shape::Mesh(Box::new(crate::shape::MeshShape::new(&wall).expect("solid")));
        for (tip, way, exact) in [
            ([1.0, 2.0, 17.8], [5.0, -15.0, 0.0], 0.1),
            ([9.1, 2.0, 4.0], [0.0, 25.0, 0.0], 3.0),
            ([9.1, 2.0, 4.0], [-2.5, 25.0, 0.0], 0.5),
            ([9.1, 2.0, 4.0], [5.0, 0.0, 0.0], 0.0),
        ] {
            let pose = Pose::from_translation(Vector::from(tip));
            let mut shifted = Places::at(pose);
            shifted.shift(Vector::from(way));
            let [from, to] = [-1.0, 1.0].map(|k| Pose::from_translation(Vector::from(tip) + Vector::from(way) * k));
            for limit in [1e-3, 0.05, 0.0991, 0.1, 0.11, 0.2, 1.0, 100.0, 1e6] {
                let places = [shifted.clone(), Places::between([from, to])];
                for found in places.map(|p| least_distance(&ball, &mesh, &p, limit)) {
                    assert!(
                        found <= exact + 1e-12 && found >= exact.min(limit) - 1e-8,
                        "{tip:?} {way:?} {limit}: {found}"
                    );
                }
            }
        }
    }
}
