//! Distance of a body that may be at many places from another: one bound for all of them at once.
//!
//! With the rotary joints held, slides only shift a body: a place within their ranges is `sum s_k g_k` with
//! `-1 <= s_k <= 1`, so that all places together are the body and a *zonotope* Z added (Minkowski). A
//! triangle and Z, or a convex body and Z, have the support
//!
//! ```text
//!    h(n) = h_body(n) + sum |g_k n|         dist(body + Z, other) = min over all places of dist(body, other)
//! ```
//!
//! and are convex: two planes across a direction that GJK finds prove their distance. A slide that
//! passes along a wall keeps its distance in this bound, however far it goes, where a bound by the
//! length of its way (Mirtich 1996) would have to be cut into pieces of 1 um; it is the bound along
//! the separating normal of Tang, Kim and Manocha (2009), taken for each two triangles.
//!
//! Where joints turn as well, a short way is the hull of the body at both of its ends: each point goes almost
//! straight from one to the other. A longer one is a *curve*: each point goes almost along the parabola
//! through its places at both ends and in the middle, which lies in the triangle of its control points
//! (Bezier). The ones in the middle are an affine image of the body, so that all of it lies in the hull of
//! three images:
//!
//! ```text
//!                 2 B(1/2) - (B(0) + B(1)) / 2
//!                    .
//!                 . ' ' .                 B(t) the pose at t: what leaves the parabola is a third
//!              . '   _   ' .              derivative, 0.024 turn2 way, where the chord has 0.25 turn way
//!           . ' _ -     - _ ' .
//!        B(0) -             - B(1)
//! ```

use nalgebra::Matrix3;
use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::query::details::closest_points_support_map_support_map_with_params;
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;
use proveout_geom::{Point, Pose, Vector};
use proveout_machine::{JointValues, MAX_JOINTS};

use crate::box_tree::{BoxTree, Effort, NearestLeaves, near_leaves_grown, nearest_leaf};
use crate::distance::{PROVED_WITHIN_MM, along_segment, from_segment, on_segment};
use crate::gjk;
use crate::shape::{PartShape, Revolved, from_parry, to_parry};
use crate::triangle;
use crate::triangle_tree::TriangleTree;

/// Shortest vector that counts as a shift, mm.
const SHIFT_MM: f64 = 1e-9;

/// By how much less than the distance of a ball its planes may prove, mm: rounding.
const BALL_WITHIN_MM: f64 = 1e-7;

/// What two points and the planes that prove may differ by, mm, before a better proof is looked for.
const AGREE_MM: f64 = 1e-5;

/// The same on a curve: below the accuracy of the least distance.
const CURVE_WITHIN_MM: f64 = 2e-4;

/// Effort for one bound: what takes more is better cut into shorter stretches.
const MOST_EFFORT: u64 = 1000;

/// Part of `turn2 way` by which points leave their parabolas at most: their third derivative is no more than
/// three times that, and the error of the parabola through three places `1 / (12 sqrt 3)` of a sixth of it.
const OFF_PARABOLA: f64 = 0.024_056_3;

/// Places of a body in the frame of the other: at one of two poses, or with each of its points
/// straight between (the hull of both) or along a parabola, and shifted by -1 to 1 of each of some
/// vectors, mm.
#[derive(Clone, Debug)]
pub(crate) struct BodyPlaces {
    pub(crate) poses: [Pose; 2],
    /// The control points in the middle of the parabolas.
    control: Option<Image>,
    shifts: Vec<Vector>,
}

/// A body as an affine map leaves it.
#[derive(Clone, Copy, Debug)]
struct Image {
    linear: Matrix3<f64>,
    shift: Vector,
}

impl Image {
    fn point(&self, p: &Point) -> Point {
        Point::from(self.linear * p.coords + self.shift)
    }
}

impl BodyPlaces {
    pub(crate) fn between(poses: [Pose; 2]) -> Self {
        Self { poses, control: None, shifts: Vec::new() }
    }

    /// Along the parabolas through three poses; the second is that in the middle.
    pub(crate) fn along([from, middle, to]: [Pose; 3]) -> Self {
        let control = Image {
            linear: middle.rotation * 2.0 - (from.rotation + to.rotation) * 0.5,
            shift: middle.translation * 2.0 - (from.translation + to.translation) * 0.5,
        };
        Self { poses: [from, to], control: Some(control), shifts: Vec::new() }
    }

    /// All images of a point, the last one twice where there are but two.
    fn images(&self, p: &Point) -> [Point; 3] {
        let [first, second] = self.poses.each_ref().map(|pose| pose.point(p));
        [first, second, self.control.map_or(second, |c| c.point(p))]
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
        (self.shifts.is_empty() && self.control.is_none() && self.poses[0] == self.poses[1]).then_some(self.poses[0])
    }

    /// Half edges of the box of the shifts.
    fn half(&self) -> Vector {
        self.shifts.iter().fold(Vector::zeros(), |sum, g| sum + g.abs())
    }

    /// How far the points of a box may be from where the first pose puts them, along the axes of the other
    /// frame; a box goes farthest at a corner.
    fn farthest_from_first(&self, middle: &Point, half: &Vector) -> Vector {
        let corner = |k: u8| {
            let sign = |bit: u8| if k & bit == 0 { -1.0 } else { 1.0 };
            middle + half.component_mul(&Vector::new(sign(1), sign(2), sign(4)))
        };
        let way = |k: u8| {
            let [first, second, third] = self.images(&corner(k));
            (second - first).abs().sup(&(third - first).abs())
        };
        (0..8).fold(Vector::zeros(), |most, k| most.sup(&way(k))) + self.half()
    }

    fn shifted(&self, along: &Vector) -> Vector {
        self.shifts.iter().fold(Vector::zeros(), |sum, g| if g.dot(along) > 0.0 { sum + g } else { sum - g })
    }
}

/// A triangle in all its places.
struct Triangle<'a> {
    /// As the places leave it; the first ones count.
    corners: [[Point; 3]; 3],
    images: usize,
    places: Option<&'a BodyPlaces>,
}

impl<'a> Triangle<'a> {
    fn moved(corners: &[Point; 3], places: &'a BodyPlaces) -> Self {
        let [a, b, c] = corners.map(|p| places.images(&p));
        let corners = std::array::from_fn(|k| [a[k], b[k], c[k]]);
        Self { corners, images: if places.control.is_some() { 3 } else { 2 }, places: Some(places) }
    }

    fn still(corners: &[Point; 3]) -> Self {
        Self { corners: [*corners; 3], images: 1, places: None }
    }
}

impl SupportMap for Triangle<'_> {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        let along = from_parry(direction).coords;
        let mut best = (f64::NEG_INFINITY, self.corners[0][0]);
        for p in self.corners.iter().take(self.images).flatten() {
            let height = p.coords.dot(&along);
            if height > best.0 {
                best = (height, *p);
            }
        }
        to_parry(&self.places.map_or(best.1, |places| best.1 + places.shifted(&along)))
    }
}

/// A body of revolution in all its places.
struct PlacedBody<'a> {
    body: &'a Revolved,
    places: &'a BodyPlaces,
}

impl SupportMap for PlacedBody<'_> {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        let along = from_parry(direction).coords;
        let of = |pose: &Pose| {
            let local = pose.rotation.tr_mul(&along);
            pose.point(&from_parry(self.body.local_support_point(to_parry(&Point::from(local)))))
        };
        let [first, second] = self.places.poses.each_ref().map(of);
        let mut best = if first.coords.dot(&along) >= second.coords.dot(&along) { first } else { second };
        if let Some(image) = &self.places.control {
            let local = image.linear.tr_mul(&along);
            let third = image.point(&from_parry(self.body.local_support_point(to_parry(&Point::from(local)))));
            if third.coords.dot(&along) > best.coords.dot(&along) {
                best = third;
            }
        }
        to_parry(&(best + self.places.shifted(&along)))
    }
}

impl PlacedBody<'_> {
    /// Largest component along a direction, mm.
    fn highest(&self, along: &Vector) -> f64 {
        let of = |pose: &Pose| self.body.height(&pose.rotation.tr_mul(along)) + pose.translation.dot(along);
        let [first, second] = self.places.poses.each_ref().map(of);
        let third = |image: &Image| self.body.height(&image.linear.tr_mul(along)) + image.shift.dot(along);
        let most = self.places.control.as_ref().map_or(f64::NEG_INFINITY, third).max(first).max(second);
        self.places.shifts.iter().fold(most, |sum, g| sum + g.dot(along).abs())
    }
}

/// By how much points may leave the hull of both ends of a straight motion of the joints, and the parabolas
/// through their places at both ends and in the middle, where they are nearer to the other body than
/// `wanted`, mm: at most an eighth of their second derivative, and [`OFF_PARABOLA`] of their third (text of
/// `least_clearance/search.rs`). `weights` say how far a point goes for a unit of each joint, `turns` which
/// joints turn, `of_b` which carry the other body, `way` how far each goes.
pub(crate) fn bent(
    weights: &[f64; MAX_JOINTS],
    turns: &[bool; MAX_JOINTS],
    of_b: &[bool; MAX_JOINTS],
    way: &JointValues,
    wanted: f64,
) -> [f64; 2] {
    let moves = |j: usize| if weights[j] > 0.0 { way[j].abs() } else { 0.0 };
    let turn: f64 = (0..MAX_JOINTS).filter(|&j| turns[j]).map(moves).sum();
    let motion: f64 = (0..MAX_JOINTS).map(|j| weights[j] * way[j].abs()).sum();
    let farther: f64 = (0..MAX_JOINTS).filter(|&j| turns[j] && of_b[j]).map(moves).sum();
    let way = motion + farther * (wanted + motion);
    [0.25 * turn * way, OFF_PARABOLA * turn * turn * way]
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
    let (proved, start) =
        match closest_points_support_map_support_map_with_params(&identity, a, b, limit, &mut simplex, None) {
            GJKResult::ClosestPoints(p, q, along) => {
                let between = from_parry(q) - from_parry(p);
                let by_points = between.try_normalize(0.0).map_or(0.0, |n| across(&n));
                let along = from_parry(along).coords.try_normalize(0.0).map_or(0.0, |n| across(&n));
                let proved = by_points.max(along).max(0.0);
                if proved >= limit || between.norm() - proved <= AGREE_MM {
                    return proved;
                }
                (proved, between)
            }
            GJKResult::NoIntersection(along) | GJKResult::Proximity(along) => {
                return from_parry(along).coords.try_normalize(0.0).map_or(0.0, |n| across(&n)).max(0.0);
            }
            GJKResult::Intersection => (0.0, Vector::z()),
        };
    // It has ended too early, or takes bodies for met that are apart by micrometers.
    let supports = |along: &Vector| {
        [
            from_parry(a.local_support_point(to_parry(&Point::from(*along)))),
            from_parry(b.local_support_point(to_parry(&Point::from(-along)))),
        ]
    };
    let found = gjk::nearest(supports, &start, [PROVED_WITHIN_MM, limit]);
    if found.meet { 0.0 } else { proved.max(found.proved) }
}

/// Lower bound of the distance of shape `a` in all its places from shape `b`, mm; exact but for rounding
/// below `limit`, and at least the limit elsewhere. Of two meshes the skins count, not the inside; nothing is
/// proved of a mesh against a convex body.
pub(crate) fn least_distance(a: &PartShape, b: &PartShape, places: &BodyPlaces, limit: f64) -> f64 {
    least_distance_with((a, b), places, limit, &mut Effort::unlimited())
}

/// The same, with what it has cost; of a tool and a mesh it ends with less proved where that is the most.
pub(crate) fn least_distance_with(
    (a, b): (&PartShape, &PartShape),
    places: &BodyPlaces,
    limit: f64,
    effort: &mut Effort,
) -> f64 {
    match (a, b) {
        (PartShape::Mesh(a), PartShape::Mesh(b)) => least_of_skins(&a.boxes, &b.boxes, places, limit),
        (PartShape::Convex(bodies), PartShape::Mesh(b)) => bodies_skin(bodies, &b.boxes, places, (limit, effort)),
        (PartShape::Convex(a), PartShape::Convex(b)) => {
            let still = BodyPlaces::at(Pose::identity());
            let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
            let of = |limit: f64, (a, b)| {
                limit.min(proved(&PlacedBody { body: a, places }, &PlacedBody { body: b, places: &still }, limit))
            };
            pairs.fold(limit, of)
        }
        (PartShape::Mesh(_), PartShape::Convex(_)) => 0.0,
    }
}

/// The same of two skins.
pub(crate) fn least_of_skins(a: &TriangleTree, b: &TriangleTree, places: &BodyPlaces, limit: f64) -> f64 {
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

/// Proved distance of a still triangle from a body with a ball end on its way, where it is above the limit or
/// the ball is what is nearest: the ball in all its places is the hull of two or three balls, and the planes
/// across the way from the segment or triangle of their centers to the triangle prove a distance.
fn ball_end(placed: &PlacedBody<'_>, corners: &[Point; 3], limit: f64) -> Option<f64> {
    let (center, radius) = placed.body.ball()?;
    if !placed.places.shifts.is_empty() {
        return None;
    }
    let [from, to, control] = placed.places.images(&center);
    let across = |way: Vector| {
        let along = way.try_normalize(0.0)?;
        let low = corners.iter().map(|p| p.coords.dot(&along)).fold(f64::INFINITY, f64::min);
        Some(low - placed.highest(&along))
    };
    // Mostly one of the ends is nearest, or suffices.
    let ends = [from, to].map(|p| triangle::point_triangle(p, corners).on_second - p);
    let nearer = if ends[0].norm_squared() <= ends[1].norm_squared() { ends[0] } else { ends[1] };
    if let Some(proved) = across(nearer).filter(|proved| *proved >= limit) {
        return Some(proved);
    }
    let near = triangle::nearest_within(&[from, to, control], corners, f64::INFINITY);
    let far = near.square.sqrt();
    if far <= radius {
        return None;
    }
    let proved = across(near.on_second - near.on_first)?;
    // The image in the middle of a parabola is no ball, but nearly.
    let within = if placed.places.control.is_some() { CURVE_WITHIN_MM } else { BALL_WITHIN_MM };
    (proved >= limit || proved >= (far - radius) - within).then(|| proved.max(0.0))
}

fn bodies_skin(
    bodies: &[Revolved],
    skin: &TriangleTree,
    places: &BodyPlaces,
    (limit, effort): (f64, &mut Effort),
) -> f64 {
    let mut least = f64::INFINITY;
    for body in bodies {
        let placed = PlacedBody { body, places };
        let axes = [Vector::x(), Vector::y(), Vector::z()];
        let high = Vector::from(axes.map(|n| placed.highest(&n)));
        let low = Vector::from(axes.map(|n| -placed.highest(&-n)));
        let (middle, half) = (Point::from((low + high) * 0.5), (high - low) * 0.5);
        // Of the hull of all places no point is farther from the spine at the first than its radius and the
        // way of its ends.
        let (from, to, radius) = body.spine();
        let [from, to] = [from, to].map(|p| places.images(&p));
        let way = |[first, second, third]: &[Point; 3]| (second - first).norm().max((third - first).norm());
        let stretched = places.control.map_or(0.0, |image| stretch(&image) * radius);
        let reach = radius + stretched + way(&from).max(way(&to)) + places.shifts.iter().map(Vector::norm).sum::<f64>();
        // Amid all places: on the spine, then on the way of that point of it.
        let lower = nalgebra::center(&from[0], &from[1]);
        let upper = nalgebra::center(&to[0], &to[1]);
        let amid = |p: &Point| {
            let t = along_segment(p, [&lower, &upper]);
            let ends = [0, 1].map(|k| from[k] + (to[k] - from[k]) * t);
            on_segment(p, [&ends[0], &ends[1]])
        };
        let highest = |along: &Vector| placed.highest(along);
        let round = body.ball().map_or(0.0, |(_, radius)| radius);
        let apart = |node: u32, bound: f64| {
            let (m, h) = skin.bounds(node);
            let outside = ((m - middle).abs() - half - h).map(|x| x.max(0.0)).norm();
            let of_box = outside.max(from_segment(&m, [&from[0], &to[0]]) - h.norm() - reach);
            if of_box >= bound { of_box } else { of_box.max(skin.node_distance(node, amid, highest, (round, bound))) }
        };
        let of = |item: u32, bound: f64| {
            let corners = skin.corners(item);
            let by_ball = ball_end(&placed, corners, bound);
            (by_ball.unwrap_or_else(|| proved(&placed, &Triangle::still(corners), bound)), ())
        };
        least = least.min(distance(nearest_leaf(skin, apart, (limit.min(least), &mut *effort), None, of)));
    }
    least
}

/// By how much more than one a linear map stretches a vector at most, if it does: the root of its squared
/// norm is no more than half above one.
fn stretch(image: &Image) -> f64 {
    // |A v|2 = v' A'A v, and the norm of A'A is at most one plus the norm of A'A - 1.
    let beside = image.linear.transpose() * image.linear - Matrix3::identity();
    0.5 * beside.norm()
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
        let ball = PartShape::Convex(cutter.iter().map(Revolved::new).collect());
        let mesh = PartShape::Mesh(Box::new(crate::shape::MeshShape::new(&wall).expect("solid")));
        for (tip, way, exact) in [
            ([1.0, 2.0, 17.8], [5.0, -15.0, 0.0], 0.1),
            ([9.1, 2.0, 4.0], [0.0, 25.0, 0.0], 3.0),
            ([9.1, 2.0, 4.0], [-2.5, 25.0, 0.0], 0.5),
            ([9.1, 2.0, 4.0], [5.0, 0.0, 0.0], 0.0),
        ] {
            let pose = Pose::from_translation(Vector::from(tip));
            let mut shifted = BodyPlaces::at(pose);
            shifted.shift(Vector::from(way));
            let [from, to] = [-1.0, 1.0].map(|k| Pose::from_translation(Vector::from(tip) + Vector::from(way) * k));
            for limit in [1e-3, 0.05, 0.0991, 0.1, 0.11, 0.2, 1.0, 100.0, 1e6] {
                let places = [shifted.clone(), BodyPlaces::between([from, to])];
                for found in places.map(|p| least_distance(&ball, &mesh, &p, limit)) {
                    assert!(
                        found <= exact + 1e-12 && found >= exact.min(limit) - 1e-8,
                        "{tip:?} {way:?} {limit}: {found}"
                    );
                }
            }
        }
    }

    /// A body that two joints turn while a slide moves it, seen from one that a third joint turns: points
    /// leave their parabolas, and bodies their hull, by no more than is said; a point far out on a turn about
    /// one axis by a third of it, where the straight line is left by half of what is said of that.
    #[test]
    fn points_keep_to_their_parabolas() {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut random = |low: f64, high: f64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut most = [0.0_f64; 2];
        for case in 0..400 {
            let unit = |x: f64, y: f64, z: f64| Vector::new(x, y, z).normalize();
            let axes = [0, 1, 2].map(|_| unit(random(-1.0, 1.0), random(-1.0, 1.0), random(0.1, 1.0)));
            let slide = unit(random(-1.0, 1.0), random(-1.0, 1.0), random(-1.0, 1.0));
            let alone = case % 4 == 0;
            let size = 10.0_f64.powf(random(-3.0, -0.3));
            let turn: [f64; 3] = std::array::from_fn(|k| if alone && k > 0 { 0.0 } else { size * random(-1.0, 1.0) });
            let length = if alone { 0.0 } else { random(-9.0, 9.0) };
            let offset = Vector::new(random(-20.0, 20.0), random(-20.0, 20.0), random(-20.0, 20.0));
            let (first, second) = (Pose::from_translation(offset), Pose::from_translation(-offset * 0.7));
            let pose = |t: f64| {
                let of = |k: usize| Pose::from_axis_angle(&axes[k], turn[k] * t);
                of(0).inverse() * Pose::from_translation(slide * (length * t)) * first * of(1) * second * of(2)
            };
            let p = Point::new(random(-30.0, 30.0), random(-30.0, 30.0), random(-30.0, 30.0));
            // Levers of the point: those of the inner two are fixed, that of the outer one changes along the
            // way.
            let lever = |k: usize, q: Point| q.coords.cross(&axes[k]).norm();
            let inner = [lever(2, p), p.coords.norm() + second.translation.norm()];
            let outer = (0..=50).map(|i| pose(f64::from(i) / 50.0).point(&p).coords.norm()).fold(0.0, f64::max);
            let joint = |x: [f64; 4]| {
                let mut q = JointValues::ZERO;
                x.into_iter().enumerate().for_each(|(k, x)| q[k] = x);
                q
            };
            let weights = joint([outer, inner[1], inner[0], 1.0]).0;
            let mut turns = [false; MAX_JOINTS];
            turns[..3].fill(true);
            let way = joint([turn[0], turn[1], turn[2], length]);
            let [chord, parabola] = bent(&weights, &turns, &[false; MAX_JOINTS], &way, 0.0);
            let places = BodyPlaces::along([0.0, 0.5, 1.0].map(pose));
            let [from, to, control] = places.images(&p);
            for i in 0..=40 {
                let t = f64::from(i) / 40.0;
                let now = pose(t).point(&p);
                let straight = from.coords * (1.0 - t) + to.coords * t;
                let on = from.coords * (1.0 - t).powi(2) + control.coords * (2.0 * t * (1.0 - t)) + to.coords * t * t;
                let off = [(now.coords - straight).norm(), (now.coords - on).norm()];
                assert!(off[0] <= chord + 1e-12 && off[1] <= parabola + 1e-12, "{case}: {off:?}, {chord} {parabola}");
                if alone && size > 0.05 {
                    most = [most[0].max(off[0] / chord), most[1].max(off[1] / parabola)];
                }
            }
        }
        assert!(most[0] > 0.3 && most[1] > 0.2, "{most:?}");
    }

    /// A ball and a flat end that turn past a wall with a corner: the bound of all places on the way is below
    /// the distance at each of them and, but for what leaves the parabolas and their hull, no farther below
    /// the least of them than the hull is wide.
    #[test]
    fn all_places_of_a_turn_are_one_distance() {
        let wall = box_mesh(&Aabb { min: Point::new(-4.0, -30.0, -30.0), max: Point::new(0.0, 30.0, 17.7) });
        let mesh = PartShape::Mesh(Box::new(crate::shape::MeshShape::new(&wall).expect("solid")));
        let cutters = [Cutter::ball(12.0), Cutter::flat(12.0), Cutter::bull_nose(12.0, 2.0)];
        for (k, cutter) in cutters.into_iter().enumerate() {
            let bodies = cutter.expect("cutter").bodies(30.0).expect("bodies");
            let tool = PartShape::Convex(bodies.iter().map(Revolved::new).collect());
            for turn in [0.003, 0.02, 0.1, 0.3] {
                // About an axis along y, 25 mm from the wall; the tool leans.
                let pose = |t: f64| {
                    Pose::from_translation(Vector::new(25.0, 0.0, 10.0))
                        * Pose::from_axis_angle(&Vector::y(), turn * (t - 0.4))
                        * Pose::from_translation(Vector::new(-14.0, 6.0 * t, -8.0))
                        * Pose::from_axis_angle(&Vector::y(), 0.3)
                };
                let at = |t: f64| match crate::distance::gap(&tool, &mesh, &pose(t), [1e6; 2], &mut None) {
                    crate::distance::Separation::At(d, ..) => d,
                    other => panic!("{other:?}"),
                };
                let least = (0..=200).map(|i| at(f64::from(i) / 200.0)).fold(f64::INFINITY, f64::min);
                // Farthest point of the tool from the axis, and the slide.
                let motion = turn * 45.0 + 6.0;
                let off = OFF_PARABOLA * turn * turn * motion;
                for limit in [1e6, least + 1e-3, 0.5 * least] {
                    let found = least_distance(&tool, &mesh, &BodyPlaces::along([0.0, 0.5, 1.0].map(pose)), limit);
                    let about = format!("cutter {k}, turn {turn}, limit {limit}: {found} of {least}");
                    assert!(found - off <= least + 1e-9, "{about}");
                    // The control point of a parabola is as far from it as half of its rise.
                    let rise = 45.0 * turn * turn / 8.0 + 6.0 * turn / 4.0;
                    assert!(found >= least.min(limit) - off - rise - CURVE_WITHIN_MM, "{about}");
                }
            }
        }
    }
}
