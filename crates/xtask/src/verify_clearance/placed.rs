//! A convex piece of a body in all the places that a span gives it, as the query library asks for it: by its farthest point along a direction.

use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::shape::SupportMap;
use proveout_geom::{Aabb, Point, Pose, Vector};
use proveout_machine::{JointValues, Machine};

use super::Body;
use super::table::Span;

/// Points round the axis of a body of revolution.
pub(super) const ROUND: usize = 180;

/// [`ROUND`] points each on rings about one line, by radius and height.
pub(super) struct Rings {
    pub(super) pose: Pose,
    pub(super) outline: Vec<[f64; 2]>,
}

/// Point `k` of a ring.
pub(super) fn on_ring([r, z]: [f64; 2], k: usize) -> Point {
    let (s, c) = (std::f64::consts::TAU * k as f64 / ROUND as f64).sin_cos();
    Point::new(r * c, r * s, z)
}

/// Places of the first body as the second one sees it.
pub(super) struct Places {
    pub(super) poses: [Pose; 2],
    /// The one in the middle, where points go along the parabolas through all three.
    pub(super) middle: Option<Pose>,
    pub(super) shifts: Vec<Vector>,
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

    pub(super) fn still() -> Self {
        Self { poses: [Pose::identity(); 2], middle: None, shifts: Vec::new() }
    }

    /// Box of the places of all points of a box: each goes where its corners do, or between.
    pub(super) fn of_box(&self, bounds: &Aabb) -> Aabb {
        let end = |high: bool, k: usize| if high { bounds.max[k] } else { bounds.min[k] };
        let corners = (0..8).map(|c| Point::new(end(c & 1 > 0, 0), end(c & 2 > 0, 1), end(c & 4 > 0, 2)));
        let points: Vec<Point> = corners.flat_map(|p| self.of_point(&p).collect::<Vec<_>>()).collect();
        let grown = self.shifts.iter().fold(Vector::zeros(), |sum, s| sum + s.abs());
        let bounds = Aabb::of_points(&points);
        Aabb { min: bounds.min - grown, max: bounds.max + grown }
    }

    /// A direction as the points see it in each of the images that [`Self::of_point`] gives, in their order: the farthest point along it in an image is the
    /// farthest along this in the body.
    fn seen(&self, d: &Vector) -> impl Iterator<Item = Vector> {
        let [from, to] = self.poses.each_ref().map(|x| x.rotation.tr_mul(d));
        let corner = self.middle.as_ref().map(|x| x.rotation.tr_mul(d) * 2.0 - (from + to) * 0.5);
        [Some(from), Some(to), corner].into_iter().flatten()
    }

    fn shifted(&self, p: Point, d: &Vector) -> Point {
        shifted(&self.shifts, p, d)
    }

    /// Points whose hull holds all the way of a point: its ends, and where the tangents of its parabola meet.
    pub(super) fn of_point(&self, p: &Point) -> impl Iterator<Item = Point> {
        let [from, to] = self.poses.each_ref().map(|x| x.point(p));
        let corner =
            self.middle.as_ref().map(|x| Point::from(x.point(p).coords * 2.0 - (from.coords + to.coords) * 0.5));
        [Some(from), Some(to), corner].into_iter().flatten()
    }
}

fn shifted(shifts: &[Vector], p: Point, d: &Vector) -> Point {
    shifts.iter().fold(p, |p, s| if s.dot(d) > 0.0 { p + s } else { p - s })
}

/// A piece of a body in all its places.
pub(super) enum Placed<'a> {
    Hull(Hull<'a>),
    Rings(&'a Rings, &'a Places),
}

impl Placed<'_> {
    pub(super) fn bounds(&self) -> (Point, Point) {
        let along = |k: usize, sign: f64| {
            let d = Vector::ith(k, sign);
            self.local_support_point(ParryVector::new(d.x, d.y, d.z))[k]
        };
        let end = |sign: f64| Point::new(along(0, sign), along(1, sign), along(2, sign));
        (end(-1.0), end(1.0))
    }
}

impl SupportMap for Placed<'_> {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        match self {
            Self::Hull(hull) => hull.local_support_point(direction),
            Self::Rings(rings, places) => {
                let p = rings.support(places, &Vector::new(direction.x, direction.y, direction.z));
                ParryVector::new(p.x, p.y, p.z)
            }
        }
    }
}

impl Rings {
    /// The farthest point of all images along a direction: on each ring the one that lies nearest to its side.
    fn support(&self, places: &Places, d: &Vector) -> Point {
        let step = std::f64::consts::TAU / ROUND as f64;
        let mut best = (f64::NEG_INFINITY, Point::origin());
        for (image, seen) in places.seen(d).enumerate() {
            let e = self.pose.rotation.tr_mul(&seen);
            let k = (e.y.atan2(e.x) / step).round().rem_euclid(ROUND as f64) as usize % ROUND;
            let side = on_ring([1.0, 0.0], k).coords;
            let across = side.dot(&e);
            let height = |p: &[f64; 2]| p[0] * across + p[1] * e.z;
            let Some(top) = self.outline.iter().max_by(|a, b| height(a).total_cmp(&height(b))) else { continue };
            let point = self.pose.point(&on_ring(*top, k));
            if let Some(p) = places.of_point(&point).nth(image)
                && p.coords.dot(d) > best.0
            {
                best = (p.coords.dot(d), p);
            }
        }
        places.shifted(best.1, d)
    }
}

pub(super) struct Hull<'a> {
    pub(super) points: Vec<Point>,
    pub(super) shifts: &'a [Vector],
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
        let p = shifted(self.shifts, best.1, &d);
        ParryVector::new(p.x, p.y, p.z)
    }
}

/// Hull of circles about one line, shifted.
pub(super) struct Circles<'a> {
    pub(super) point: Point,
    pub(super) direction: Vector,
    pub(super) circles: &'a [[f64; 2]],
    pub(super) shifts: &'a [Vector],
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
        shifted(self.shifts, p, d)
    }

    pub(super) fn bounds(&self) -> (Point, Point) {
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
