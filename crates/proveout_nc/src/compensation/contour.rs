//! Elements of a programmed contour in their plane, and their equidistants.

use std::f64::consts::TAU;

/// Two points of the plane nearer than this are one, mm: below the resolution of every program.
pub(crate) const SAME_POINT_MM: f64 = 1e-6;
/// Rounding of lengths and of arc lengths in intersections, mm: coordinates up to 10 m carry 2e-12 mm.
pub(crate) const ROUNDING_MM: f64 = 1e-9;
/// Radius that rounding is an angle of at least, mm: a smaller one would make it a large angle.
pub(super) const LEAST_RADIUS_MM: f64 = 1e-3;
/// Sine of the angle between two lines below which they do not meet.
const PARALLEL: f64 = 1e-12;

pub(crate) type Point = [f64; 2];

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn along(a: Point, direction: Point, length: f64) -> Point {
    [a[0] + length * direction[0], a[1] + length * direction[1]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(crate) fn norm(a: Point) -> f64 {
    a[0].hypot(a[1])
}

/// The direction turned by a quarter to the left.
pub(crate) fn left(direction: Point) -> Point {
    [-direction[1], direction[0]]
}

pub(crate) fn unit(a: Point) -> Point {
    let length = norm(a);
    if length > 0.0 { [a[0] / length, a[1] / length] } else { [1.0, 0.0] }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ElementShape {
    Line,
    Arc {
        center: Point,
        /// mm.
        radius: f64,
        counter_clockwise: bool,
        /// Angle run through, radian, above zero.
        sweep: f64,
    },
}

/// One block of the programmed contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Element {
    pub(crate) start: Point,
    pub(crate) end: Point,
    pub(crate) shape: ElementShape,
}

impl Element {
    /// Unit direction of motion at a point of the element.
    pub(crate) fn tangent_at(&self, point: Point) -> Point {
        match self.shape {
            ElementShape::Line => unit(sub(self.end, self.start)),
            ElementShape::Arc { center, counter_clockwise, .. } => {
                let turned = left(unit(sub(point, center)));
                if counter_clockwise { turned } else { turned.map(|v| -v) }
            }
        }
    }

    /// Unit direction of motion at the start.
    pub(crate) fn first_tangent(&self) -> Point {
        self.tangent_at(self.start)
    }

    /// Unit direction of motion at the end.
    pub(crate) fn last_tangent(&self) -> Point {
        self.tangent_at(self.end)
    }

    /// Radius of the equidistant of an arc: `offset` to the left brings it nearer to a center on the left.
    pub(crate) fn offset_radius(&self, offset: f64) -> Option<f64> {
        match self.shape {
            ElementShape::Line => None,
            ElementShape::Arc { radius, counter_clockwise, .. } => {
                Some(if counter_clockwise { radius - offset } else { radius + offset })
            }
        }
    }

    /// Start of the equidistant, `offset` to the left of the motion.
    pub(crate) fn offset_start(&self, offset: f64) -> Point {
        self.offset_point(self.start, offset)
    }

    /// End of the equidistant.
    pub(crate) fn offset_end(&self, offset: f64) -> Point {
        self.offset_point(self.end, offset)
    }

    fn offset_point(&self, point: Point, offset: f64) -> Point {
        match (self.shape, self.offset_radius(offset)) {
            // On the one circle of all its points, although start and end of a programmed arc may differ by
            // rounding.
            (ElementShape::Arc { center, .. }, Some(radius)) => along(center, unit(sub(point, center)), radius),
            _ => along(point, left(self.first_tangent()), offset),
        }
    }

    /// How far a point of the equidistant lies before its end: mm on a line, radian on an arc.
    pub(crate) fn back_from_end(&self, point: Point, offset: f64) -> f64 {
        match self.shape {
            ElementShape::Line => dot(sub(self.offset_end(offset), point), self.last_tangent()),
            ElementShape::Arc { center, counter_clockwise, .. } => {
                angle(sub(point, center), sub(self.end, center), counter_clockwise, self.offset_radius(offset))
            }
        }
    }

    /// How far a point of the equidistant lies after its start, in the unit of
    /// [`Self::back_from_end`].
    pub(crate) fn on_from_start(&self, point: Point, offset: f64) -> f64 {
        match self.shape {
            ElementShape::Line => dot(sub(point, self.offset_start(offset)), self.first_tangent()),
            ElementShape::Arc { center, counter_clockwise, .. } => {
                angle(sub(self.start, center), sub(point, center), counter_clockwise, self.offset_radius(offset))
            }
        }
    }

    /// As [`Self::back_from_end`] for points near the end; negative beyond the end.
    pub(crate) fn before_end(&self, point: Point, offset: f64) -> f64 {
        match self.shape {
            ElementShape::Line => self.back_from_end(point, offset),
            ElementShape::Arc { center, counter_clockwise, .. } => {
                turn(sub(point, center), sub(self.end, center), counter_clockwise)
            }
        }
    }

    /// As [`Self::on_from_start`] for points near the start, below zero before it.
    pub(crate) fn after_start(&self, point: Point, offset: f64) -> f64 {
        match self.shape {
            ElementShape::Line => self.on_from_start(point, offset),
            ElementShape::Arc { center, counter_clockwise, .. } => {
                turn(sub(self.start, center), sub(point, center), counter_clockwise)
            }
        }
    }

    /// Point of the element itself that is nearest to a point of its equidistant.
    pub(crate) fn foot(&self, point: Point, offset: f64) -> Point {
        match self.shape {
            ElementShape::Line => along(point, left(self.first_tangent()), -offset),
            ElementShape::Arc { center, radius, .. } => along(center, unit(sub(point, center)), radius),
        }
    }

    /// Curvature, 1/mm, above zero where the path bends to the left.
    pub(crate) fn curvature(&self) -> f64 {
        match self.shape {
            ElementShape::Line => 0.0,
            ElementShape::Arc { radius, counter_clockwise, .. } => {
                if counter_clockwise {
                    1.0 / radius
                } else {
                    -1.0 / radius
                }
            }
        }
    }

    /// Length along the element, mm.
    pub(crate) fn length(&self) -> f64 {
        match self.shape {
            ElementShape::Line => self.extent(),
            ElementShape::Arc { radius, sweep, .. } => radius * sweep,
        }
    }

    /// Point of the equidistant `by` beyond its end: mm on a line, radian on an arc; before the end
    /// where `by` is negative.
    pub(crate) fn behind_end(&self, by: f64, offset: f64) -> Point {
        self.moved_along(self.offset_end(offset), self.last_tangent(), by)
    }

    /// Point of the equidistant `by` after its start, in the unit of [`Self::behind_end`].
    pub(crate) fn behind_start(&self, by: f64, offset: f64) -> Point {
        self.moved_along(self.offset_start(offset), self.first_tangent(), by)
    }

    fn moved_along(&self, from: Point, tangent: Point, by: f64) -> Point {
        match self.shape {
            ElementShape::Line => along(from, tangent, by),
            ElementShape::Arc { center, counter_clockwise, .. } => {
                let (sine, cosine) = if counter_clockwise { by } else { -by }.sin_cos();
                let [x, y] = sub(from, center);
                [center[0] + cosine * x - sine * y, center[1] + sine * x + cosine * y]
            }
        }
    }

    /// Length of the whole element in the unit of [`Self::back_from_end`].
    pub(crate) fn extent(&self) -> f64 {
        match self.shape {
            ElementShape::Line => norm(sub(self.end, self.start)),
            ElementShape::Arc { sweep, .. } => sweep,
        }
    }
}

/// Angle from one radius to another in the direction of motion, from minus pi to pi.
fn turn(from: Point, to: Point, counter_clockwise: bool) -> f64 {
    let angle = cross(from, to).atan2(dot(from, to));
    if counter_clockwise { angle } else { -angle }
}

/// Angle from one radius to another in the direction of motion, in [0, 2 pi); what is a full turn but for
/// rounding is none.
fn angle(from: Point, to: Point, counter_clockwise: bool, radius: Option<f64>) -> f64 {
    let angle = turn(from, to, counter_clockwise);
    let rounding = ROUNDING_MM / radius.unwrap_or(1.0).abs().max(LEAST_RADIUS_MM);
    if angle >= 0.0 {
        angle
    } else if angle > -rounding {
        0.0
    } else {
        angle + TAU
    }
}

/// Where two equidistants meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    pub(crate) point: Point,
    /// What the corner cuts off the end of the first, in the unit of [`Element::extent`]; negative
    /// where the first goes on beyond its end.
    pub(crate) taken: f64,
    /// What lies before it on the second; below zero where the second begins before its start.
    pub(crate) used: f64,
}

/// Where the equidistants of two elements that follow each other meet in an inside corner.
///
/// `rest`: what the corner before has left of the first element, in the unit of its extent. Of
/// several intersections that lie on both equidistants, the one that shortens the first least is
/// returned; none where there is no such point.
pub(crate) fn inside_corner(first: &Element, second: &Element, offset: f64, rest: f64) -> Option<Meeting> {
    let rounding = |e: &Element| match e.offset_radius(offset) {
        None => ROUNDING_MM,
        Some(radius) => ROUNDING_MM / radius.abs().max(LEAST_RADIUS_MM),
    };
    let mut best: Option<Meeting> = None;
    for point in intersections(first, second, offset).into_iter().flatten() {
        let (taken, used) = (first.back_from_end(point, offset), second.on_from_start(point, offset));
        let on_first = taken >= -rounding(first) && taken <= rest + rounding(first);
        let on_second = used >= -rounding(second) && used <= second.extent() + rounding(second);
        if on_first && on_second && best.is_none_or(|best| taken < best.taken) {
            best = Some(Meeting { point, taken, used });
        }
    }
    best
}

/// Intersections of the equidistants, taken as whole lines and circles.
pub(crate) fn intersections(first: &Element, second: &Element, offset: f64) -> [Option<Point>; 2] {
    let (p, q) = (first.offset_end(offset), second.offset_start(offset));
    let (s, t) = (first.last_tangent(), second.first_tangent());
    match (first.shape, second.shape) {
        (ElementShape::Line, ElementShape::Line) => {
            let across = cross(s, t);
            if across.abs() < PARALLEL {
                return [None, None];
            }
            [Some(along(p, s, cross(sub(q, p), t) / across)), None]
        }
        (ElementShape::Line, ElementShape::Arc { center, .. }) => {
            line_and_circle(p, s, center, second.offset_radius(offset).unwrap_or(0.0))
        }
        (ElementShape::Arc { center, .. }, ElementShape::Line) => {
            line_and_circle(q, t, center, first.offset_radius(offset).unwrap_or(0.0))
        }
        (ElementShape::Arc { center: a, .. }, ElementShape::Arc { center: b, .. }) => {
            let radii = (first.offset_radius(offset).unwrap_or(0.0), second.offset_radius(offset).unwrap_or(0.0));
            let between = sub(b, a);
            let distance = norm(between);
            if distance < ROUNDING_MM {
                return [None, None];
            }
            let foot = (distance * distance + radii.0 * radii.0 - radii.1 * radii.1) / (2.0 * distance);
            let Some(height) = root(radii.0 * radii.0 - foot * foot, radii.0) else { return [None, None] };
            let direction = unit(between);
            let middle = along(a, direction, foot);
            [Some(along(middle, left(direction), height)), Some(along(middle, left(direction), -height))]
        }
    }
}

fn line_and_circle(point: Point, direction: Point, center: Point, radius: f64) -> [Option<Point>; 2] {
    let to_center = sub(center, point);
    let (foot, distance) = (dot(to_center, direction), cross(direction, to_center));
    let Some(half) = root(radius * radius - distance * distance, radius) else { return [None, None] };
    [Some(along(point, direction, foot - half)), Some(along(point, direction, foot + half))]
}

/// Square root that takes a touch of two curves, a little below zero by rounding, as zero.
fn root(square: f64, radius: f64) -> Option<f64> {
    if square >= 0.0 { Some(square.sqrt()) } else { (square > -2.0 * ROUNDING_MM * radius.abs()).then_some(0.0) }
}

/// Largest tool radius that fits into the inside corner between two elements, found by halving; mm.
pub(crate) fn largest_inside(first: &Element, second: &Element, offset: f64) -> f64 {
    let fits = |offset: f64| {
        let room = |e: &Element| e.offset_radius(offset).is_none_or(|r| r > 0.0);
        room(first) && room(second) && inside_corner(first, second, offset, first.extent()).is_some()
    };
    let (mut low, mut high) = (0.0, offset.abs());
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if fits(middle * offset.signum()) { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(start: Point, end: Point) -> Element {
        Element { start, end, shape: ElementShape::Line }
    }

    #[test]
    fn lines_at_a_right_angle_meet_on_the_bisector() {
        let (a, b) = (line([0.0, 0.0], [10.0, 0.0]), line([10.0, 0.0], [10.0, 10.0]));
        let point = inside_corner(&a, &b, 2.0, 10.0).unwrap().point;
        assert!(norm(sub(point, [8.0, 2.0])) < 1e-12, "{point:?}");
        assert_eq!(inside_corner(&a, &b, 2.0, 1.5), None);
        assert!((largest_inside(&a, &b, 20.0) - 10.0).abs() < 1e-6);
    }

    #[test]
    fn line_and_arc_meet_at_the_distance_of_both() {
        // A chord enters the circle about (0, 0): the tool runs inside of it.
        let a = line([-5.0, 6.0], [8.0, 6.0]);
        let b = Element {
            start: [8.0, 6.0],
            end: [-8.0, 6.0],
            shape: ElementShape::Arc { center: [0.0, 0.0], radius: 10.0, counter_clockwise: true, sweep: 1.0 },
        };
        let point = inside_corner(&a, &b, 1.0, 13.0).unwrap().point;
        assert!((norm(point) - 9.0).abs() < 1e-12 && (point[1] - 7.0).abs() < 1e-12, "{point:?}");
        assert!(point[0] > 0.0);
    }

    #[test]
    fn two_arcs_meet_at_the_distance_of_both() {
        let arc = |start: Point, end: Point, center: Point| Element {
            start,
            end,
            shape: ElementShape::Arc { center, radius: 10.0, counter_clockwise: true, sweep: 2.0 },
        };
        // Two circles of radius 10 about (-6, 0) and (6, 0) cross at (0, 8): a lens run counter-clockwise has
        // there a corner with the tool inside, on the left.
        let a = arc([4.0, 0.0], [0.0, 8.0], [-6.0, 0.0]);
        let b = arc([0.0, 8.0], [-4.0, 0.0], [6.0, 0.0]);
        let point = inside_corner(&a, &b, 1.0, 2.0).unwrap().point;
        assert!(point[0].abs() < 1e-12 && (point[1] - (81.0f64 - 36.0).sqrt()).abs() < 1e-12, "{point:?}");
    }
}
