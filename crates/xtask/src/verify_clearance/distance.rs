//! Whether a body in all its places is nearer to another than claimed.
//!
//! A body is a list of convex pieces: triangles of a mesh, or the rings of points of a body of revolution. A piece in all its places is the hull of
//! its points at both ends, or of the parabolas between them, shifted along a few vectors. Boxes leave out what is far; GJK of the query library tells the rest.
//! Of rings of points none is asked but the one on the side of the direction.
//!
//! At all turns of a joint each piece is the hull of the circles that its points run through. It holds the piece at every turn, and lies within the hull
//! that a claim may take for several pieces at once, so that no true claim is refused.

use std::collections::BTreeSet;

use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::query::details::distance_support_map_support_map;
use parry3d_f64::shape::SupportMap;
use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector};
use proveout_tool::{Profile, Segment};

use super::placed::{Circles, Hull, Placed, Places, ROUND, Rings, on_ring};

/// Points on an arc of a tool.
const ARC: usize = 48;
/// Circles that differ by less are one, mm.
const SAME_MM: f64 = 1e-6;

/// Convex pieces of a body, each by its points, and a tree of boxes over them.
pub(super) struct Form {
    pub(super) pieces: Vec<Vec<Point>>,
    /// The pieces once more, where they are rings of points.
    rings: Vec<Rings>,
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
        let ring = |at: [f64; 2]| (0..ROUND).map(move |k| on_ring(at, k));
        let outlines = || profiles.iter().map(|p| p.segments().iter().flat_map(outline).collect::<Vec<[f64; 2]>>());
        let points = outlines().map(|o| o.into_iter().flat_map(ring).map(|q| pose.point(&q)).collect());
        Self { rings: outlines().map(|outline| Rings { pose, outline }).collect(), ..Self::new(points.collect()) }
    }

    /// The largest of `of` at a point of the body; between two points it changes by no more than their distance.
    pub(super) fn largest(&self, of: impl Fn(&Point) -> f64) -> f64 {
        let mut most: f64 = 0.0;
        let mut open = Vec::from_iter((!self.tree.is_empty()).then_some(0));
        while let Some(at) = open.pop() {
            let node = &self.tree[at];
            if of(&node.bounds.center()) + 0.5 * node.bounds.size().norm() <= most {
                continue;
            }
            match node.holds {
                Err(two) => open.extend(two),
                Ok(item) => most = self.pieces[item].iter().map(&of).fold(most, f64::max),
            }
        }
        most
    }

    /// A piece in all its places.
    pub(super) fn placed<'a>(&'a self, item: usize, places: &'a Places) -> Placed<'a> {
        match self.rings.get(item) {
            Some(rings) => Placed::Rings(rings, places),
            None => {
                let points = self.pieces[item].iter().flat_map(|p| places.of_point(p)).collect();
                Placed::Hull(Hull { points, shifts: &places.shifts })
            }
        }
    }

    fn new(pieces: Vec<Vec<Point>>) -> Self {
        let mut form = Self { tree: Vec::new(), rings: Vec::new(), pieces };
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

/// A distance below `limit` (mm), where there is one.
pub(super) fn nearer_than(a: &Form, b: &Form, places: &Places, limit: f64) -> Option<f64> {
    let whole = &b.tree.first()?.bounds;
    let mut open = Vec::from_iter((!a.tree.is_empty()).then_some(0));
    while let Some(at) = open.pop() {
        let node = &a.tree[at];
        let bounds = places.of_box(&node.bounds);
        if gap(&bounds, whole) >= limit {
            continue;
        }
        match node.holds {
            Err(two) => open.extend(two),
            Ok(item) => {
                let piece = a.placed(item, places);
                let found = piece_nearer_than(&piece, piece.bounds(), b, limit, None);
                if found.is_some() {
                    return found;
                }
            }
        }
    }
    None
}

/// No two points of two boxes are nearer to each other.
fn gap(a: &Aabb, b: &Aabb) -> f64 {
    (a.min - b.max).sup(&(b.min - a.max)).map(|x| x.max(0.0)).norm()
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
    let (still, bounds) = (Places::still(), Aabb { min: low, max: high });
    let mut open = Vec::from_iter((!b.tree.is_empty()).then_some(0));
    while let Some(at) = open.pop() {
        let node = &b.tree[at];
        if gap(&bounds, &node.bounds) >= limit {
            continue;
        }
        match node.holds {
            Err(two) => open.extend(two),
            Ok(item) => {
                let other = b.placed(item, &still);
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
