//! Bodies in all the places that a span gives them, asked for their farthest points along directions.

use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::shape::SupportMap;
use proveout_geom::{Point, Pose, Vector};
use proveout_machine::{JointValues, Machine};

use super::CarriedBody;
use super::form::{BodyPieces, RevolvedBody, beats};
use super::table::ClearanceClaim;

/// Places of the first body as the second one sees it.
pub(super) struct RelativePoses {
    pub(super) poses: [Pose; 2],
    /// The one in the middle, where points go along the parabolas through all three.
    pub(super) middle: Option<Pose>,
    pub(super) shifts: Vec<Vector>,
}

impl RelativePoses {
    pub(super) fn of(machine: &Machine, [a, b]: [&CarriedBody; 2], span: &ClearanceClaim) -> Self {
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

    pub(super) fn still() -> Self {
        Self { poses: [Pose::identity(); 2], middle: None, shifts: Vec::new() }
    }

    /// Maps of the points of the first body whose images hold, in their hull, all the way of each: to its
    /// ends, and to where the tangents of its parabola meet.
    fn images(&self) -> impl Iterator<Item = AffineMap> {
        let [from, to] = self.poses.each_ref().map(AffineMap::of);
        let corner = self.middle.as_ref().map(AffineMap::of).map(|x| {
            let meet = |x: Vector, a: Vector, b: Vector| x * 2.0 - (a + b) * 0.5;
            AffineMap {
                turn: [0, 1, 2].map(|k| meet(x.turn[k], from.turn[k], to.turn[k])),
                shift: meet(x.shift, from.shift, to.shift),
            }
        });
        let moves = from != to;
        [Some(from), moves.then_some(to), corner].into_iter().flatten()
    }
}

/// An affine map; where points go along parabolas it is no pose.
#[derive(Clone, Copy, PartialEq)]
struct AffineMap {
    /// Where it takes the axes.
    turn: [Vector; 3],
    shift: Vector,
}

impl AffineMap {
    fn of(pose: &Pose) -> Self {
        Self { turn: [0, 1, 2].map(|k| pose.rotation.column(k).into_owned()), shift: pose.translation }
    }

    fn vector(&self, v: &Vector) -> Vector {
        self.turn[0] * v.x + self.turn[1] * v.y + self.turn[2] * v.z
    }

    fn point(&self, p: &Vector) -> Vector {
        self.vector(p) + self.shift
    }

    /// A direction as the points see it before the map.
    fn seen(&self, d: &Vector) -> Vector {
        Vector::from(self.turn.each_ref().map(|axis| axis.dot(d)))
    }

    /// After another map.
    fn after(&self, first: &Self) -> Self {
        Self { turn: first.turn.each_ref().map(|axis| self.vector(axis)), shift: self.point(&first.shift) }
    }
}

/// At most: both ends and the corner between.
const IMAGES: usize = 3;

/// A direction as a body sees it in its places: the farthest point along it in an image is the farthest along
/// `along` in the body, and as much farther as `beyond`.
#[derive(Clone)]
pub(super) struct SupportPoints {
    along: [Vector; IMAGES],
    beyond: [f64; IMAGES],
}

/// A tree of pieces in all their places.
pub(super) trait PieceTree {
    /// The two branches of a node; none of one that is a piece.
    fn parts(&self, node: usize) -> Option<[usize; 2]>;
    /// Size of a node, mm: the larger one is parted.
    fn size(&self, node: usize) -> f64;
    /// Somewhere in the middle of all places.
    fn middle(&self) -> Vector;
    fn see(&self, d: &Vector) -> SupportPoints;
    /// No point of a node is farther along a direction in any of its places; of a piece the farthest is as
    /// far.
    fn height(&self, node: usize, seen: &SupportPoints) -> f64;
    /// The farthest point of a piece.
    fn farthest(&self, node: usize, d: &Vector) -> Vector;
}

/// A body in its places.
pub(super) struct PlacedBody<'a> {
    form: &'a BodyPieces,
    images: Vec<AffineMap>,
    shifts: &'a [Vector],
}

impl<'a> PlacedBody<'a> {
    pub(super) fn new(form: &'a BodyPieces, places: &'a RelativePoses) -> Self {
        let own = form.own.as_ref().map(AffineMap::of);
        let images = places.images().map(|x| own.map_or(x, |own| x.after(&own)));
        Self { form, images: images.collect(), shifts: &places.shifts }
    }
}

fn beyond(shifts: &[Vector], d: &Vector) -> f64 {
    shifts.iter().map(|s| s.dot(d).abs()).sum()
}

fn shifted(shifts: &[Vector], p: Vector, d: &Vector) -> Vector {
    shifts.iter().fold(p, |p, s| if s.dot(d) > 0.0 { p + s } else { p - s })
}

impl PieceTree for PlacedBody<'_> {
    fn parts(&self, node: usize) -> Option<[usize; 2]> {
        self.form.tree[node].holds.err()
    }

    fn size(&self, node: usize) -> f64 {
        self.form.tree[node].size
    }

    fn middle(&self) -> Vector {
        let center = self.form.tree.first().map_or(Vector::zeros(), |n| n.bound.center);
        let sum = self.images.iter().fold(Vector::zeros(), |sum, x| sum + x.point(&center));
        sum / self.images.len() as f64
    }

    fn see(&self, d: &Vector) -> SupportPoints {
        let mut seen = SupportPoints { along: [Vector::zeros(); IMAGES], beyond: [beyond(self.shifts, d); IMAGES] };
        for (k, image) in self.images.iter().enumerate() {
            seen.along[k] = image.seen(d);
            seen.beyond[k] += image.shift.dot(d);
        }
        seen
    }

    fn height(&self, node: usize, seen: &SupportPoints) -> f64 {
        let node = &self.form.tree[node];
        let mut most = f64::NEG_INFINITY;
        for k in 0..self.images.len() {
            let along = &seen.along[k];
            let height = match node.holds {
                Err(_) => node.bound.height(along),
                Ok(item) => self.form.farthest(item, along).0,
            };
            let height = height + seen.beyond[k];
            if beats(height, most) {
                most = height;
            }
        }
        most
    }

    fn farthest(&self, node: usize, d: &Vector) -> Vector {
        let mut best = (f64::NEG_INFINITY, Vector::zeros());
        if let Ok(item) = self.form.tree[node].holds {
            for image in &self.images {
                let (height, p) = self.form.farthest(item, &image.seen(d));
                let height = height + image.shift.dot(d);
                if height > best.0 {
                    best = (height, image.point(&p));
                }
            }
        }
        shifted(self.shifts, best.1, d)
    }
}

/// A body at all turns about a line.
pub(super) struct Circles<'a> {
    turned: &'a RevolvedBody,
    point: Vector,
    direction: Vector,
    shifts: &'a [Vector],
}

impl<'a> Circles<'a> {
    pub(super) fn new(turned: &'a RevolvedBody, places: &'a RelativePoses) -> Self {
        let [here, _] = &places.poses;
        let (point, direction) = (here.point(&turned.point).coords, here.vector(&turned.direction));
        Self { turned, point, direction, shifts: &places.shifts }
    }

    /// The axis of the circles, both ways: planes normal to it often separate the bodies.
    pub(super) fn axes(&self) -> [Vector; 2] {
        [self.direction, -self.direction]
    }
}

impl PieceTree for Circles<'_> {
    fn parts(&self, node: usize) -> Option<[usize; 2]> {
        self.turned.tree[node].holds.err()
    }

    fn size(&self, node: usize) -> f64 {
        self.turned.tree[node].size
    }

    fn middle(&self) -> Vector {
        let height = self.turned.tree.first().map_or(0.0, |n| 0.5 * (n.bound.low + n.bound.high));
        self.point + self.direction * height
    }

    fn see(&self, d: &Vector) -> SupportPoints {
        let along = d.dot(&self.direction);
        let across = (d - self.direction * along).norm();
        let beyond = self.point.dot(d) + beyond(self.shifts, d);
        SupportPoints { along: [Vector::new(across, along, 0.0); IMAGES], beyond: [beyond; IMAGES] }
    }

    fn height(&self, node: usize, seen: &SupportPoints) -> f64 {
        let node = &self.turned.tree[node];
        let ([across, along], drum) = ([seen.along[0].x, seen.along[0].y], &node.bound);
        let height = match node.holds {
            Err(_) => drum.radius * across + (drum.low * along).max(drum.high * along),
            Ok(item) => self.turned.farthest(item, across, along).0,
        };
        height + seen.beyond[0]
    }

    fn farthest(&self, node: usize, d: &Vector) -> Vector {
        let along = d.dot(&self.direction);
        let across = d - self.direction * along;
        let size = across.norm();
        let unit = if size > 0.0 { across / size } else { Vector::zeros() };
        let [radius, height] =
            self.turned.tree[node].holds.map_or([0.0; 2], |item| self.turned.farthest(item, size, along).1);
        shifted(self.shifts, self.point + self.direction * height + unit * radius, d)
    }
}

/// A piece of a body, as the query library asks for it.
pub(super) struct QueryPiece<'a, S>(pub(super) &'a S, pub(super) usize);

impl<S: PieceTree> SupportMap for QueryPiece<'_, S> {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        let p = self.0.farthest(self.1, &Vector::new(direction.x, direction.y, direction.z));
        ParryVector::new(p.x, p.y, p.z)
    }
}
