//! What a distance query proves when its effort ends early, against all triangles one by one.
//!
//! The oracle knows nothing of trees, GJK or planes: the signed distance from a convex body is a convex
//! function (Rockafellar 1970), so that its least value on a triangle is found by two searches of an
//! interval, one within the other, and never changes by more than the way.

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, box_mesh, revolved_mesh};
use proveout_tool::Cutter;

use crate::box_tree::Effort;
use crate::distance::{PROVED_WITHIN_MM, Separation, WarmStart, gap_with};
use crate::shape::{MeshShape, PartShape, Revolved};
use crate::swept::{BodyPlaces, least_distance_with};

/// Narrowings of an interval to a third less: 30 mm come to 1e-6 mm, a distance with a minimum to far less.
const NARROWINGS: usize = 42;
/// By how much the oracle may be above the true distance, mm.
const ORACLE_MM: f64 = 1e-6;

struct Random(u64);

impl Random {
    fn next(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self, reach: f64) -> Point {
        Point::new(self.next(-reach, reach), self.next(-reach, reach), self.next(-reach, reach))
    }
}

/// Least value of a convex function on 0..1.
fn least_of(f: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (0.0, 1.0);
    let mut best = f(0.0).min(f(1.0));
    for _ in 0..NARROWINGS {
        let (p, q) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        let (u, v) = (f(p), f(q));
        best = best.min(u).min(v);
        if u < v { b = q } else { a = p }
    }
    best
}

/// Signed distance of the nearest point of triangles from a body, in the frame of the body; below zero where
/// they reach into it.
fn oracle(bodies: &[Revolved], triangles: &[[Point; 3]], body_from_mesh: &Pose) -> f64 {
    let mut best = f64::INFINITY;
    for corners in triangles {
        let [a, b, c] = corners.map(|p| body_from_mesh.point(&p));
        let middle = Point::from((a.coords + b.coords + c.coords) / 3.0);
        let round = [a, b, c].iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        for body in bodies {
            if body.signed_distance(&middle) - round >= best {
                continue;
            }
            let along = |u: f64| {
                let (p, q) = (a + (b - a) * u, a + (c - a) * u);
                least_of(|v| body.signed_distance(&(p + (q - p) * v)))
            };
            best = best.min(least_of(along));
        }
    }
    best
}

fn bodies(random: &mut Random, k: usize) -> Vec<Revolved> {
    let d = random.next(2.0, 14.0);
    let cutter = match k % 5 {
        0 => Cutter::ball(d),
        1 => Cutter::flat(d),
        2 => Cutter::bull_nose(d, 0.3 * d),
        3 => Cutter::chamfer(d, 90.0, 0.0),
        _ => Cutter::barrel(12.0, 3.0, 80.0, 25.0),
    };
    let profiles = cutter.expect("a cutter").bodies(24.0).expect("bodies");
    profiles.iter().map(Revolved::new).collect()
}

/// A closed mesh, or triangles anywhere: some are lines, points, or there twice.
fn mesh(random: &mut Random, k: usize) -> TriMesh {
    match k % 4 {
        0 => box_mesh(&Aabb { min: Point::new(-20.0, -9.0, -6.0), max: Point::new(20.0, 9.0, 0.0) }),
        1 => revolved_mesh(&[[0.0, -30.0], [9.0, -30.0], [12.0, -12.0], [7.0, 0.0], [0.0, 2.0]], 41),
        2 => revolved_mesh(&[[14.0, -3.0], [17.0, 0.0], [14.0, 3.0], [11.0, 0.0]], 37),
        _ => {
            let mut positions = Vec::new();
            for t in 0..90 {
                let (at, size) = (random.point(25.0), random.next(0.01, 12.0));
                let mut corners = [0, 1, 2].map(|_| at + random.point(size).coords);
                match t % 9 {
                    0 => corners[2] = nalgebra::center(&corners[0], &corners[1]),
                    1 => corners = [corners[0]; 3],
                    2 => corners[2] = corners[1],
                    _ => {}
                }
                positions.extend(corners);
                if t % 9 == 3 {
                    positions.extend(corners);
                }
            }
            let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            TriMesh { positions, triangles }
        }
    }
}

/// Poses that are far, touch to a nanometer, reach in, and lie anywhere.
fn pose(random: &mut Random, bodies: &[Revolved], triangles: &[[Point; 3]], k: usize) -> Pose {
    let turn = Pose::from_rpy(Vector::zeros(), random.next(-3.0, 3.0), random.next(-1.5, 1.5), random.next(-3.0, 3.0));
    let reach = if k.is_multiple_of(3) { 90.0 } else { 22.0 };
    let mut pose = Pose { translation: random.point(reach).coords, ..turn };
    if k % 3 == 1 {
        // Along the way to the nearest corner until a wanted distance is left; that of the whole is what the
        // oracle says.
        for _ in 0..12 {
            let apart = oracle(bodies, triangles, &pose.inverse());
            let wanted = [1e-6, 1e-3, 0.2, -0.5][k / 3 % 4];
            let outward = pose.translation.try_normalize(1e-9).unwrap_or_else(Vector::z);
            pose.translation += outward * (wanted - apart);
        }
    }
    pose
}

fn shapes(bodies: &[Revolved], mesh: &TriMesh) -> (PartShape, PartShape, Vec<[Point; 3]>) {
    let tree = MeshShape::surface(mesh).expect("triangles");
    let triangles = tree.boxes.triangles().to_vec();
    (PartShape::Convex(bodies.to_vec()), PartShape::Mesh(Box::new(tree)), triangles)
}

/// How often each answer came.
#[derive(Debug, Default)]
struct Seen {
    beyond: usize,
    short: usize,
    between: usize,
    at: usize,
    meeting: usize,
}

impl Seen {
    /// Compares an answer with the true distance; `ended` where the effort was used up.
    fn hold(&mut self, found: &Separation, least: f64, limit: f64, ended: bool, about: &str) {
        let most = least + ORACLE_MM;
        match *found {
            Separation::Beyond(proved) => {
                assert!(proved <= most, "{about}: {proved} is proved, {least} is there");
                assert!(ended || proved >= limit - PROVED_WITHIN_MM * (1.0 + limit), "{about}: {proved} of {limit}");
                if proved < limit { self.short += 1 } else { self.beyond += 1 }
            }
            Separation::Between([low, high], p, q) => {
                assert!(ended && low <= high && high < limit, "{about}: {low} {high}");
                assert!(
                    low <= most && least <= high + PROVED_WITHIN_MM * (1.0 + high),
                    "{about}: {low} {least} {high}"
                );
                assert!((p - q).norm() >= low - 1e-9, "{about}: {p} {q}");
                self.between += 1;
            }
            Separation::At(d, ..) => {
                let within = ORACLE_MM + PROVED_WITHIN_MM * (1.0 + d);
                assert!((d - least).abs() <= within, "{about}: {d}, {least} is there");
                self.at += 1;
            }
            Separation::Meeting(_) => {
                assert!(least <= 2.0 * ORACLE_MM, "{about}: they meet, {least} is there");
                self.meeting += 1;
            }
        }
    }
}

#[test]
fn what_is_proved_with_little_effort_is_true() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut seen = Seen::default();
    for k in 0..24 {
        let bodies = bodies(&mut random, k);
        let (tool, wall, triangles) = shapes(&bodies, &mesh(&mut random, k / 2));
        let pose = pose(&mut random, &bodies, &triangles, k);
        let least = oracle(&bodies, &triangles, &pose.inverse()).max(0.0);
        let mut warm: WarmStart = None;
        for limit in [f64::INFINITY, 1.5 * least + 0.1, 0.9 * least] {
            for most in [0, 1, 3, 20, 60, 150, 400, u64::MAX] {
                let about = format!("case {k}, limit {limit}, effort {most}");
                let mut effort = Effort::at_most(most);
                let found = gap_with((&tool, &wall), &pose, [limit; 2], &mut warm, &mut effort);
                let ended = effort.spent >= most;
                seen.hold(&found, least, limit, ended, &about);
                // What may still be under way when the effort ends: one leaf for each body.
                assert!(most == u64::MAX || effort.spent <= most + 40 * bodies.len() as u64, "{about}: {effort:?}");
                let mut effort = Effort::at_most(most);
                let turned = gap_with((&wall, &tool), &pose.inverse(), [limit; 2], &mut None, &mut effort);
                let ended = effort.spent >= most;
                seen.hold(&turned, least, limit, ended, &about);
            }
        }
    }
    let Seen { beyond, short, between, at, meeting } = seen;
    assert!([beyond, short, between, at, meeting].into_iter().all(|n| n > 8), "{seen:?}");
}

/// The same of a body in all its places: at both ends, between them on a slide, and shifted.
#[test]
#[ignore = "nightly, 16 s"]
fn what_is_proved_of_all_places_with_little_effort_is_true() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let (mut exact, mut short) = (0, 0);
    for k in 0..15 {
        let bodies = bodies(&mut random, k);
        let (tool, wall, triangles) = shapes(&bodies, &mesh(&mut random, k / 2));
        let first = pose(&mut random, &bodies, &triangles, k);
        let way = random.point(4.0).coords;
        let slid = |t: f64| Pose { translation: first.translation + way * t, ..first };
        let mut shifted = BodyPlaces::at(slid(0.5));
        shifted.shift(way * 0.5);
        let nearest = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|t| oracle(&bodies, &triangles, &slid(t).inverse()));
        let least = nearest.into_iter().fold(f64::INFINITY, f64::min).max(0.0);
        for places in
            [BodyPlaces::between([slid(0.0), slid(1.0)]), BodyPlaces::along([0.0, 0.5, 1.0].map(slid)), shifted]
        {
            for limit in [1e6, 1.5 * least + 0.1, 0.5 * least] {
                let mut all = 0.0;
                for most in [u64::MAX, 0, 3, 60, 400] {
                    let mut effort = Effort::at_most(most);
                    let proved = least_distance_with((&tool, &wall), &places, limit, &mut effort);
                    let about = format!("case {k}, limit {limit}, effort {most}");
                    assert!(proved <= least + ORACLE_MM, "{about}: {proved} is proved, {least} is there");
                    if most == u64::MAX {
                        all = proved;
                        exact += usize::from(limit > 1.0 && proved > 0.5 * least && least > 0.0);
                    } else {
                        assert!(proved.min(limit) <= all.min(limit) + ORACLE_MM, "{about}: {proved} {all}");
                        short += usize::from(proved < all.min(limit) - 1e-3);
                    }
                }
            }
        }
    }
    assert!(exact > 20 && short > 20, "{exact} {short}");
}
