//! The convex pieces of a body: triangles of a mesh, or the bodies of revolution of a tool.

use std::collections::BTreeSet;

use proveout_geom::{Point, Pose, TriMesh, Vector};
use proveout_tool::{Profile, Segment};

use super::tree::{BoundNode, Corners, OrientedBox, grow, of_pieces};

/// Points on an arc of a tool, and round it, where its corners are asked for.
const ARC: usize = 48;
const ROUND: usize = 180;
/// Circles that differ by less are one, mm.
const SAME_MM: f64 = 1e-6;

/// Convex pieces of a body, and a tree of boxes over them.
pub(super) struct BodyPieces {
    /// Corners of each piece; of a body of revolution points on it.
    pub(super) pieces: Vec<Vec<Point>>,
    /// Half planes of the pieces where they are bodies of revolution about z of `own`, which is their pose
    /// then.
    outlines: Vec<Vec<Segment>>,
    pub(super) own: Option<Pose>,
    pub(super) tree: Vec<BoundNode<OrientedBox>>,
    pub(super) corners: Corners,
}

impl BodyPieces {
    pub(super) fn mesh(mesh: &TriMesh) -> Self {
        let pieces: Vec<Vec<Point>> = (0..mesh.triangles.len()).map(|t| mesh.corners(t).to_vec()).collect();
        let corners = Corners::new(pieces.iter().flatten().copied().collect());
        Self { tree: of_pieces(&pieces), pieces, outlines: Vec::new(), own: None, corners }
    }

    /// Bodies of revolution of a tool in the spindle, in M with all joints at zero.
    pub(super) fn revolved(profiles: &[&Profile], gauge: &Pose, gauge_length: f64) -> Self {
        let pose = *gauge * Pose::from_translation(Vector::new(0.0, 0.0, -gauge_length));
        let outlines: Vec<Vec<Segment>> = profiles.iter().map(|p| p.segments().to_vec()).collect();
        let ring = |[r, z]: [f64; 2]| {
            (0..ROUND).map(move |k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / ROUND as f64).sin_cos();
                Point::new(r * c, r * s, z)
            })
        };
        let points = |outline: &Vec<Segment>| outline.iter().flat_map(points_of).collect::<Vec<[f64; 2]>>();
        let pieces: Vec<Vec<Point>> =
            outlines.iter().map(|o| points(o).into_iter().flat_map(ring).map(|q| pose.point(&q)).collect()).collect();
        let drums: Vec<Drum> = outlines.iter().map(|o| Drum::of(&points(o))).collect();
        let bound = |items: &[usize]| Drum::round(items.iter().map(|&i| &drums[i])).upright_box();
        let tree = grow(drums.len(), bound, OrientedBox::reach, |i| drums[i].upright_box().center);
        let corners = Corners::new(pieces.iter().flatten().copied().collect());
        Self { pieces, outlines, own: Some(pose), tree, corners }
    }

    /// How far a piece reaches along a direction, and the point that does; of a body of revolution in its own
    /// frame.
    pub(super) fn farthest(&self, item: usize, d: &Vector) -> (f64, Vector) {
        if let Some(outline) = self.outlines.get(item) {
            return farthest_of(outline, d);
        }
        let mut best = (f64::NEG_INFINITY, Vector::zeros());
        for p in &self.pieces[item] {
            let height = p.coords.dot(d);
            if beats(height, best.0) {
                best = (height, p.coords);
            }
        }
        best
    }

    /// Each piece as the circles that its corners run through about a line, none twice.
    pub(super) fn turned(&self, point: &Point, direction: &Vector) -> RevolvedBody {
        let of = |p: &Point| {
            let (way, along) = (p - point, (p - point).dot(direction));
            [(way - direction * along).norm(), along]
        };
        let mut known: BTreeSet<Vec<[i64; 2]>> = BTreeSet::new();
        let mut pieces = Vec::new();
        for piece in &self.pieces {
            let rings = outermost(piece.iter().map(of).collect());
            let mut name: Vec<[i64; 2]> = rings.iter().map(|p| p.map(|x| (x / SAME_MM).round() as i64)).collect();
            name.sort_unstable();
            if known.insert(name) {
                pieces.push(rings);
            }
        }
        let drums: Vec<Drum> = pieces.iter().map(|p| Drum::of(p)).collect();
        let bound = |items: &[usize]| Drum::round(items.iter().map(|&i| &drums[i]));
        let size = |d: &Drum| d.radius.hypot(0.5 * (d.high - d.low));
        let center = |i: usize| Vector::new(drums[i].radius, 0.5 * (drums[i].low + drums[i].high), 0.0);
        RevolvedBody { point: *point, direction: *direction, tree: grow(drums.len(), bound, size, center), pieces }
    }
}

/// Whether a height is the larger one; a number that is none is, and stays.
pub(super) fn beats(height: f64, best: f64) -> bool {
    height > best || height.is_nan()
}

/// The circles that are the farthest ones along some direction: all others lie in the hull of these and of
/// the line.
fn outermost(mut circles: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    circles.sort_by(|a, b| a[1].total_cmp(&b[1]).then_with(|| a[0].total_cmp(&b[0])));
    let mut hull: Vec<[f64; 2]> = Vec::new();
    for c in circles {
        if hull.last().is_some_and(|b| b[1] >= c[1]) {
            hull.pop();
        }
        while let [.., a, b] = hull[..]
            && (b[0] - a[0]) * (c[1] - a[1]) <= (c[0] - a[0]) * (b[1] - a[1])
        {
            hull.pop();
        }
        hull.push(c);
    }
    hull
}

/// The farthest point of a body of revolution about z.
fn farthest_of(outline: &[Segment], d: &Vector) -> (f64, Vector) {
    let across = d.x.hypot(d.y);
    let length = across.hypot(d.z);
    let mut best = (f64::NEG_INFINITY, [0.0; 2]);
    let mut take = |p: [f64; 2]| {
        let height = p[0] * across + p[1] * d.z;
        if beats(height, best.0) {
            best = (height, p);
        }
    };
    for segment in outline {
        take(segment.from());
        take(segment.to());
        if let Segment::Arc { center, radius, from, to } = *segment
            && length > 0.0
        {
            // Where the tangent lies across the direction, if the arc goes there (it turns by half a turn at
            // most, to the left).
            let u = [across / length, d.z / length];
            let left = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0] >= 0.0;
            let way = |p: [f64; 2]| [p[0] - center[0], p[1] - center[1]];
            if left(way(from), u) && left(u, way(to)) {
                take([(center[0] + radius * u[0]).max(0.0), center[1] + radius * u[1]]);
            }
        }
    }
    let (height, [r, z]) = best;
    let side = if across > 0.0 { [d.x / across, d.y / across] } else { [1.0, 0.0] };
    (height, Vector::new(r * side[0], r * side[1], z))
}

/// Ends of a segment, and points on it where it is an arc.
fn points_of(segment: &Segment) -> Vec<[f64; 2]> {
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

/// A body at all turns about a line: circles, by distance from it and height along it.
///
/// At all turns each piece is the hull of the circles that its corners run through. It holds the piece at
/// every turn, and lies within the hull that a claim may take for several pieces at once, so that no true
/// claim is refused.
pub(super) struct RevolvedBody {
    pub(super) point: Point,
    pub(super) direction: Vector,
    pieces: Vec<Vec<[f64; 2]>>,
    pub(super) tree: Vec<BoundNode<Drum>>,
}

impl RevolvedBody {
    /// How far the circles of a piece reach along a direction, by what it has across and along the line, and
    /// the circle that does.
    pub(super) fn farthest(&self, item: usize, across: f64, along: f64) -> (f64, [f64; 2]) {
        let mut best = (f64::NEG_INFINITY, [0.0; 2]);
        for circle in &self.pieces[item] {
            let height = circle[0] * across + circle[1] * along;
            if beats(height, best.0) {
                best = (height, *circle);
            }
        }
        best
    }
}

/// A cylinder about a line.
#[derive(Clone, Copy)]
pub(super) struct Drum {
    pub(super) radius: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Drum {
    const NONE: Self = Self { radius: 0.0, low: f64::INFINITY, high: f64::NEG_INFINITY };

    fn of(circles: &[[f64; 2]]) -> Self {
        let one = |[r, z]: &[f64; 2]| Self { radius: *r, low: *z, high: *z };
        circles.iter().map(one).fold(Self::NONE, |all, one| all.with(&one))
    }

    fn round<'a>(all: impl Iterator<Item = &'a Self>) -> Self {
        all.fold(Self::NONE, |sum, one| sum.with(one))
    }

    fn with(&self, other: &Self) -> Self {
        Self { radius: self.radius.max(other.radius), low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box round it, its line along z.
    fn upright_box(&self) -> OrientedBox {
        let middle = Vector::new(0.0, 0.0, 0.5 * (self.low + self.high));
        let half = 0.5 * (self.high - self.low);
        OrientedBox::new(middle, [Vector::x() * self.radius, Vector::y() * self.radius, Vector::z() * half])
    }
}
