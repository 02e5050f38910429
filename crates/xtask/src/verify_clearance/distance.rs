//! Whether a body in all its places is nearer to another than claimed.
//!
//! A body is a list of convex pieces: triangles of a mesh, or the rings of points of a body of revolution. A piece in all its places is the hull of
//! its points at both ends, or of the parabolas between them, shifted along a few vectors. Boxes leave out what is far; GJK of the query library tells the rest.
//!
//! At all turns of a joint each piece is the hull of the circles that its points run through. It holds the piece at every turn, and lies within the hull
//! that a claim may take for several pieces at once, so that no true claim is refused.

use std::collections::BTreeSet;

use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::query::details::distance_support_map_support_map;
use parry3d_f64::shape::SupportMap;
use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_tool::{Profile, Segment};

use super::Body;
use super::table::Span;

/// Points on an arc of a tool, and round its axis.
const ARC: usize = 48;
const ROUND: usize = 180;
/// Circles that differ by less are one, mm.
const SAME_MM: f64 = 1e-6;

/// Convex pieces of a body, each by its points, and a tree of boxes over them.
pub(super) struct Form {
    pub(super) pieces: Vec<Vec<Point>>,
    tree: Vec<Node>,
}

/// A body at all turns about a line: circles, by distance from it and height along it.
pub(super) struct Turned {
    point: Point,
    direction: Vector,
    pieces: Vec<Vec<[f64; 2]>>,
}

struct Node {
    bounds: Aabb,
    /// A piece, or two nodes.
    holds: Result<usize, [usize; 2]>,
}

impl Form {
    /// Each piece as its points' distances from a line and heights along it, none twice.
    pub(super) fn turned(&self, point: &Point, direction: &Vector) -> Turned {
        let of = |p: &Point| {
            let (way, along) = (p - point, (p - point).dot(direction));
            [(way - direction * along).norm(), along]
        };
        let mut known: BTreeSet<Vec<[i64; 2]>> = BTreeSet::new();
        let mut pieces = Vec::new();
        for piece in &self.pieces {
            let rings: Vec<[f64; 2]> = piece.iter().map(of).collect();
            let mut name: Vec<[i64; 2]> = rings.iter().map(|p| p.map(|x| (x / SAME_MM).round() as i64)).collect();
            name.sort_unstable();
            if known.insert(name) {
                pieces.push(rings);
            }
        }
        Turned { point: *point, direction: *direction, pieces }
    }

    pub(super) fn mesh(mesh: &TriMesh) -> Self {
        Self::new((0..mesh.triangles.len()).map(|t| mesh.corners(t).to_vec()).collect())
    }

    /// Bodies of revolution of a tool in the spindle, in M with all joints at zero; their points lie on the bodies.
    pub(super) fn revolved(profiles: &[&Profile], gauge: &Pose, gauge_length: f64) -> Self {
        let pose = *gauge * Pose::from_translation(Vector::new(0.0, 0.0, -gauge_length));
        let ring = |[r, z]: [f64; 2]| {
            (0..ROUND).map(move |k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / ROUND as f64).sin_cos();
                Point::new(r * c, r * s, z)
            })
        };
        let of = |p: &&Profile| p.segments().iter().flat_map(outline).flat_map(ring).map(|q| pose.point(&q)).collect();
        Self::new(profiles.iter().map(of).collect())
    }

    fn new(pieces: Vec<Vec<Point>>) -> Self {
        let mut form = Self { tree: Vec::new(), pieces };
        let mut all: Vec<usize> = (0..form.pieces.len()).collect();
        if !all.is_empty() {
            form.grow(&mut all);
        }
        form
    }

    fn grow(&mut self, items: &mut [usize]) -> usize {
        let bounds = Aabb::of_points(items.iter().flat_map(|&i| &self.pieces[i]));
        let at = self.tree.len();
        self.tree.push(Node { bounds, holds: Ok(items[0]) });
        if items.len() > 1 {
            let axis = bounds.size().imax();
            let middle = |i: &usize| Aabb::of_points(&self.pieces[*i]).center()[axis];
            items.sort_by(|x, y| middle(x).total_cmp(&middle(y)));
            let (low, high) = items.split_at_mut(items.len() / 2);
            self.tree[at].holds = Err([self.grow(low), self.grow(high)]);
        }
        at
    }
}

fn outline(segment: &Segment) -> Vec<[f64; 2]> {
    match *segment {
        Segment::Line { from, to } => vec![from, to],
        Segment::Arc { center, radius, from, to } => {
            let angle = |p: [f64; 2]| (p[1] - center[1]).atan2(p[0] - center[0]);
            let (a, mut b) = (angle(from), angle(to));
            if b < a {
                b += std::f64::consts::TAU;
            }
            let at = |k: usize| {
                let (s, c) = (a + (b - a) * k as f64 / ARC as f64).sin_cos();
                [(center[0] + radius * c).max(0.0), center[1] + radius * s]
            };
            (0..=ARC).map(at).collect()
        }
    }
}

/// Places of the first body as the second one sees it.
pub(super) struct Places {
    poses: [Pose; 2],
    /// The one in the middle, where points go along the parabolas through all three.
    middle: Option<Pose>,
    shifts: Vec<Vector>,
}

impl Places {
    pub(super) fn of(machine: &Machine, [a, b]: [&Body; 2], span: &Span) -> Self {
        let b_from_a =
            |q: &JointValues| machine.attachment_pose(b.attached, q).inverse() * machine.attachment_pose(a.attached, q);
        if let Some(ends) = &span.straight {
            let middle = span.curved.then(|| b_from_a(&((ends[0] + ends[1]) * 0.5)));
            return Self { poses: ends.each_ref().map(b_from_a), middle, shifts: Vec::new() };
        }
        let middle = span.middle();
        let here = b_from_a(&middle);
        let slides = machine.joints.iter().enumerate().filter(|(_, j)| !j.is_rotary());
        let shifts = slides.map(|(j, _)| {
            let mut end = middle;
            end[j] = span.high[j];
            b_from_a(&end).point(&Point::origin()) - here.point(&Point::origin())
        });
        Self { poses: [here; 2], middle: None, shifts: shifts.filter(|v| v.norm() > 0.0).collect() }
    }

    /// Points whose hull holds all the way of a point: its ends, and where the tangents of its parabola meet.
    fn of_point(&self, p: &Point) -> impl Iterator<Item = Point> {
        let [from, to] = self.poses.each_ref().map(|x| x.point(p));
        let corner =
            self.middle.as_ref().map(|x| Point::from(x.point(p).coords * 2.0 - (from.coords + to.coords) * 0.5));
        [Some(from), Some(to), corner].into_iter().flatten()
    }
}

struct Hull<'a> {
    points: Vec<Point>,
    shifts: &'a [Vector],
}

impl SupportMap for Hull<'_> {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        let d = Vector::new(direction.x, direction.y, direction.z);
        let mut best = (f64::NEG_INFINITY, Point::origin());
        for p in &self.points {
            let height = p.coords.dot(&d);
            if height > best.0 {
                best = (height, *p);
            }
        }
        let p = self.shifts.iter().fold(best.1, |p, s| if s.dot(&d) > 0.0 { p + s } else { p - s });
        ParryVector::new(p.x, p.y, p.z)
    }
}

/// Hull of circles about one line, shifted.
struct Circles<'a> {
    point: Point,
    direction: Vector,
    circles: &'a [[f64; 2]],
    shifts: &'a [Vector],
}

impl Circles<'_> {
    fn support(&self, d: &Vector) -> Point {
        let along = d.dot(&self.direction);
        let across = d - self.direction * along;
        let size = across.norm();
        let unit = if size > 0.0 { across / size } else { Vector::zeros() };
        let height = |c: &[f64; 2]| c[0] * size + c[1] * along;
        let best = self.circles.iter().max_by(|a, b| height(a).total_cmp(&height(b))).copied().unwrap_or_default();
        let p = self.point + self.direction * best[1] + unit * best[0];
        self.shifts.iter().fold(p, |p, s| if s.dot(d) > 0.0 { p + s } else { p - s })
    }

    fn bounds(&self) -> (Point, Point) {
        let end = |sign: f64| Point::from(Vector::from_fn(|k, _| self.support(&(Vector::ith(k, 1.0) * sign))[k]));
        (end(-1.0), end(1.0))
    }
}

impl SupportMap for Circles<'_> {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        let p = self.support(&Vector::new(direction.x, direction.y, direction.z));
        ParryVector::new(p.x, p.y, p.z)
    }
}

/// A distance below `limit` (mm), where there is one.
pub(super) fn nearer_than(a: &Form, b: &Form, places: &Places, limit: f64) -> Option<f64> {
    let grown = places.shifts.iter().fold(Vector::zeros(), |sum, s| sum + s.abs());
    a.pieces.iter().find_map(|piece| {
        let points: Vec<Point> = piece.iter().flat_map(|p| places.of_point(p)).collect();
        let bounds = Aabb::of_points(&points);
        let hull = Hull { points, shifts: &places.shifts };
        piece_nearer_than(&hull, (bounds.min - grown, bounds.max + grown), b, limit, None)
    })
}

/// The same of a body at all its turns.
pub(super) fn turned_nearer_than(a: &Turned, b: &Form, places: &Places, limit: f64) -> Option<f64> {
    let [here, _] = &places.poses;
    a.pieces.iter().find_map(|circles| {
        let (point, direction) = (here.point(&a.point), here.vector(&a.direction));
        let hull = Circles { point, direction, circles, shifts: &places.shifts };
        piece_nearer_than(&hull, hull.bounds(), b, limit, Some(direction))
    })
}

/// The same of one piece; `axis` is that of its circles, along which two planes often tell.
fn piece_nearer_than(
    hull: &impl SupportMap,
    (low, high): (Point, Point),
    b: &Form,
    limit: f64,
    axis: Option<Vector>,
) -> Option<f64> {
    let mut open = Vec::from_iter((!b.tree.is_empty()).then_some(0));
    while let Some(at) = open.pop() {
        let node = &b.tree[at];
        let apart = (low - node.bounds.max).sup(&(node.bounds.min - high)).map(|x| x.max(0.0)).norm();
        if apart >= limit {
            continue;
        }
        match node.holds {
            Err(two) => open.extend(two),
            Ok(item) => {
                let other = Hull { points: b.pieces[item].clone(), shifts: &[] };
                let distance = distance_support_map_support_map(&ParryPose::IDENTITY, hull, &other);
                // Of circles that are shifted far the library's points may lie outside of both.
                if let Some(nearer) = (distance < limit).then(|| witnessed(hull, &other, limit, axis)).flatten() {
                    return Some(nearer);
                }
            }
        }
    }
    None
}

/// Steps of [`witnessed`]: they shrink slowly, and are only needed where the library has gone astray.
const STEPS: usize = 4000;

/// A distance below `limit`, unless two planes with the bodies on either side are farther apart: steps from a difference of two points towards the
/// one that lies farthest back along it (Frank and Wolfe 1956), each a point of both bodies, so that what is told is one of them.
fn witnessed(a: &impl SupportMap, b: &impl SupportMap, limit: f64, axis: Option<Vector>) -> Option<f64> {
    let lowest = |along: ParryVector| a.local_support_point(-along) - b.local_support_point(along);
    let ends = axis.into_iter().flat_map(|n| [n, -n]).map(|n| ParryVector::new(n.x, n.y, n.z));
    if ends.into_iter().any(|along| along.dot(lowest(along)) >= limit * along.length()) {
        return None;
    }
    let mut way = lowest(ParryVector::new(0.0, 0.0, 1.0));
    for _ in 0..STEPS {
        let length = way.length();
        if length < limit {
            return Some(length);
        }
        let back = lowest(way);
        if way.dot(back) >= limit * length {
            return None;
        }
        let step = back - way;
        let square = step.dot(step);
        if square <= 0.0 {
            return None;
        }
        way += step * (-way.dot(step) / square).clamp(0.0, 1.0);
    }
    Some(limit)
}
