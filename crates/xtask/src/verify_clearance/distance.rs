//! Whether a body in all its places is nearer to another than claimed.
//!
//! A body is a list of convex pieces: triangles of a mesh, or the bodies of revolution of a tool. A piece in
//! all its places is the hull of its images at both ends, or of the parabolas between them, shifted along a
//! few vectors; at all turns of a joint it is the hull of the circles that its corners run through.
//!
//! A claim holds if every two pieces are separated by a plane with at least the claimed room between them
//! along its normal, and by nothing else. One plane often separates both bodies as a whole, or a box of
//! pieces from the other body. A plane is found by GJK of the query library between two pieces that no known
//! plane separates, and is kept for what comes next in the trees and in the next span. Where a plane comes
//! from does not matter: its room is computed on both bodies each time.
//!
//! ```text
//!    a in all places        |<- limit ->|       b
//!       ____                |           |   ____________
//!      /    \               |           |   \  box of   \
//!     |      |  highest ----|           |-----\ pieces   \     lowest along d - highest along d >= limit
//!      \____/   along d     |           |       \_________\
//!                           ---- d ---->
//! ```

use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;
use proveout_geom::Vector;

use super::form::{BodyPieces, RevolvedBody};
use super::placed::{Circles, PieceTree, PlacedBody, QueryPiece, RelativePoses, SupportPoints};

/// Planes that are kept from one look to the next.
const KEPT: usize = 12;
/// Room that is asked of the query library beyond the claim, mm: rounding.
const ROUNDING_MM: f64 = 1e-9;

/// What is known of a pair of bodies from the spans before.
#[derive(Default)]
pub(super) struct SeparationSearch {
    /// Directions of planes that have parted them, the last one first.
    known: Vec<Vector>,
    /// Looks at whole bodies, and those that one plane has settled.
    pub(super) looks: usize,
    pub(super) by_one_plane: usize,
    /// Nodes looked at, and pieces that the library was asked of.
    pub(super) nodes: usize,
    pub(super) asked: usize,
}

/// A direction, of length one, and how both bodies see it.
struct SeparatingPlane {
    direction: Vector,
    of_a: SupportPoints,
    of_b: SupportPoints,
    /// The last node of each, and how far it reaches.
    last_a: (usize, f64),
    last_b: (usize, f64),
}

impl SeparatingPlane {
    fn new(way: &Vector, a: &impl PieceTree, b: &impl PieceTree) -> Option<Self> {
        let direction = way.try_normalize(0.0).filter(|d| d.iter().all(|x| x.is_finite()))?;
        let (of_a, of_b) = (a.see(&direction), b.see(&-direction));
        Some(Self { direction, of_a, of_b, last_a: (usize::MAX, 0.0), last_b: (usize::MAX, 0.0) })
    }

    /// Whether it has that much room between two nodes.
    fn parts(&mut self, a: &impl PieceTree, b: &impl PieceTree, [of_a, of_b]: [usize; 2], limit: f64) -> bool {
        if self.last_a.0 != of_a {
            self.last_a = (of_a, a.height(of_a, &self.of_a));
        }
        if self.last_b.0 != of_b {
            self.last_b = (of_b, b.height(of_b, &self.of_b));
        }
        -self.last_b.1 - self.last_a.1 >= limit
    }
}

impl SeparationSearch {
    /// A distance of a body in its places from another below `limit` (mm), where there is one.
    pub(super) fn nearer_than(
        &mut self,
        a: &BodyPieces,
        b: &BodyPieces,
        places: &RelativePoses,
        limit: f64,
    ) -> Option<f64> {
        let still = RelativePoses::still();
        if a.tree.is_empty() || b.tree.is_empty() {
            return None;
        }
        self.nearer(&PlacedBody::new(a, places), &PlacedBody::new(b, &still), limit, &[])
    }

    /// The same of a body at all its turns.
    pub(super) fn turned_nearer_than(
        &mut self,
        a: &RevolvedBody,
        b: &BodyPieces,
        places: &RelativePoses,
        limit: f64,
    ) -> Option<f64> {
        let still = RelativePoses::still();
        if a.tree.is_empty() || b.tree.is_empty() {
            return None;
        }
        let a = Circles::new(a, places);
        self.nearer(&a, &PlacedBody::new(b, &still), limit, &a.axes())
    }

    fn nearer(&mut self, a: &impl PieceTree, b: &impl PieceTree, limit: f64, ways: &[Vector]) -> Option<f64> {
        self.looks += 1;
        if limit <= 0.0 {
            self.by_one_plane += 1;
            return None;
        }
        let between = b.middle() - a.middle();
        let known = self.known.len();
        let ways: Vec<Vector> = self.known.drain(..).chain(ways.iter().copied()).chain([between]).collect();
        let mut waiting = ways.iter().enumerate();
        let mut planes: Vec<SeparatingPlane> = Vec::new();
        let mut open = vec![[0, 0]];
        let (mut nodes, mut found) = (0, None);
        while let Some(two) = open.pop() {
            nodes += 1;
            let mut settled = planes.iter_mut().position(|p| p.parts(a, b, two, limit));
            while settled.is_none()
                && let Some((_, way)) = waiting.next()
            {
                if let Some(mut plane) = SeparatingPlane::new(way, a, b) {
                    settled = plane.parts(a, b, two, limit).then_some(planes.len());
                    planes.push(plane);
                }
            }
            if let Some(k) = settled {
                planes[..=k].rotate_right(1);
                continue;
            }
            match (a.parts(two[0]), b.parts(two[1])) {
                (None, None) => match self.plane_between(a, b, two, limit, planes.first().map(|p| &p.direction)) {
                    Ok(plane) => {
                        planes.insert(0, plane);
                        planes.truncate(KEPT);
                    }
                    Err(nearer) => {
                        found = Some(nearer);
                        break;
                    }
                },
                (Some(parts), None) => open.extend(parts.map(|k| [k, two[1]])),
                (Some(parts), Some(_)) if a.size(two[0]) > b.size(two[1]) => open.extend(parts.map(|k| [k, two[1]])),
                (_, Some(parts)) => open.extend(parts.map(|k| [two[0], k])),
            }
        }
        self.nodes += nodes;
        self.by_one_plane += usize::from(nodes == 1 && found.is_none());
        let unused = waiting.filter(|(k, _)| *k < known).map(|(_, way)| *way);
        self.known.extend(planes.iter().map(|p| p.direction).chain(unused).take(KEPT));
        found
    }

    /// A plane with enough room between two pieces, or a distance that leaves no room for one.
    fn plane_between(
        &mut self,
        a: &impl PieceTree,
        b: &impl PieceTree,
        [of_a, of_b]: [usize; 2],
        limit: f64,
        start: Option<&Vector>,
    ) -> Result<SeparatingPlane, f64> {
        self.asked += 1;
        let pieces = (&QueryPiece(a, of_a), &QueryPiece(b, of_b));
        let mut simplex = VoronoiSimplex::new();
        let start = start.map_or(ParryVector::X, |d| ParryVector::new(d.x, d.y, d.z));
        simplex.reset(CsoPoint::from_shapes(&ParryPose::IDENTITY, pieces.0, pieces.1, start));
        let wanted = limit + ROUNDING_MM;
        let way = match closest_points(&ParryPose::IDENTITY, pieces.0, pieces.1, wanted, true, &mut simplex) {
            GJKResult::Intersection => None,
            GJKResult::ClosestPoints(_, _, d) | GJKResult::Proximity(d) | GJKResult::NoIntersection(d) => Some(d),
        };
        // The library may lose its way where it is asked of bodies that are shifted far.
        let by_library = way.and_then(|d| with_room(a, b, [of_a, of_b], limit, d));
        by_library.map_or_else(
            || {
                let way = witnessed(pieces.0, pieces.1, limit)?;
                with_room(a, b, [of_a, of_b], limit, way).ok_or(limit)
            },
            Ok,
        )
    }
}

/// A plane across a direction, if it has enough room between two nodes.
fn with_room(
    a: &impl PieceTree,
    b: &impl PieceTree,
    two: [usize; 2],
    limit: f64,
    d: ParryVector,
) -> Option<SeparatingPlane> {
    let mut plane = SeparatingPlane::new(&Vector::new(d.x, d.y, d.z), a, b)?;
    plane.parts(a, b, two, limit).then_some(plane)
}

/// Steps of [`witnessed`]: they shrink slowly, and are only needed where the library has gone astray.
const STEPS: usize = 4000;

/// A direction along which two pieces are at least `limit` apart, or their distance if it is less. Each
/// step goes from a difference of two points towards the one that lies farthest back along it (Frank and
/// Wolfe 1956). Each is a difference of points of the bodies, so a returned distance is a real one.
fn witnessed(a: &impl SupportMap, b: &impl SupportMap, limit: f64) -> Result<ParryVector, f64> {
    let lowest = |along: ParryVector| b.local_support_point(-along) - a.local_support_point(along);
    let mut way = lowest(ParryVector::new(0.0, 0.0, 1.0));
    for _ in 0..STEPS {
        let length = way.length();
        if length < limit {
            return Err(length);
        }
        let back = lowest(way);
        if way.dot(back) >= (limit + ROUNDING_MM) * length {
            return Ok(way);
        }
        let step = back - way;
        let square = step.dot(step);
        if square <= 0.0 {
            return Ok(way);
        }
        way += step * (-way.dot(step) / square).clamp(0.0, 1.0);
    }
    Err(limit)
}
