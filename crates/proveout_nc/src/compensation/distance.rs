//! Distances between elements of a plane: lines and arcs, in closed form.
//!
//! The least distance of two curves lies at an end of one of them and the nearest point of the other, or
//! inside of both where the joining line is square to both: on the perpendicular from a center to a line, on
//! the line of two centers, or at a crossing. All of these are tried; each is a distance that exists, so the
//! least of them is the least of all.
//!
//! ```text
//!      line and arc                    arc and arc
//!
//!   ------f-----------          .-'''-.        .-'''-.
//!         |                    /       v------w       \
//!       .-v-.                 |    c1  |      | c2     |      v, w on the line of the centers
//!      /  |  \                 \       '      '       /
//!     |   c   |                 '-...-'        '-...-'
//! ```

use super::contour::{Element, ElementShape, Point, along, cross, dot, left, norm, sub, unit};

/// Below this distance two centers are one, or a point is a center, mm: no direction is defined.
const NO_DIRECTION_MM: f64 = 1e-12;

/// Part of an element on which a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementPart {
    Start,
    Inside,
    End,
}

/// Nearest point of an element to a point, its distance, and where on the element it is.
pub(super) fn nearest(element: &Element, point: Point) -> (f64, Point, ElementPart) {
    match element.shape {
        ElementShape::Line => {
            let way = sub(element.end, element.start);
            let length = norm(way);
            let s = if length > 0.0 { dot(sub(point, element.start), way) / length } else { 0.0 };
            let (foot, part) = if s <= 0.0 {
                (element.start, ElementPart::Start)
            } else if s >= length {
                (element.end, ElementPart::End)
            } else {
                (along(element.start, way, s / length), ElementPart::Inside)
            };
            (norm(sub(point, foot)), foot, part)
        }
        ElementShape::Arc { center, radius, .. } => {
            let from = sub(point, center);
            if norm(from) > NO_DIRECTION_MM && is_beside_arc(element, point) {
                return ((norm(from) - radius).abs(), along(center, unit(from), radius), ElementPart::Inside);
            }
            let [start, end] = ends(element);
            let (a, b) = (norm(sub(point, start)), norm(sub(point, end)));
            if a <= b { (a, start, ElementPart::Start) } else { (b, end, ElementPart::End) }
        }
    }
}

/// First and last point; those of an arc on its circle.
pub(super) fn ends(element: &Element) -> [Point; 2] {
    match element.shape {
        ElementShape::Line => [element.start, element.end],
        ElementShape::Arc { center, radius, counter_clockwise, sweep } => {
            let from = unit(sub(element.start, center));
            let turn = if counter_clockwise { sweep } else { -sweep };
            let (sine, cosine) = turn.sin_cos();
            let to = [cosine * from[0] - sine * from[1], sine * from[0] + cosine * from[1]];
            [along(center, from, radius), along(center, to, radius)]
        }
    }
}

/// Whether the ray from the center through a point meets an arc.
fn is_beside_arc(element: &Element, point: Point) -> bool {
    match element.shape {
        ElementShape::Line => false,
        ElementShape::Arc { center, counter_clockwise, sweep, .. } => {
            let (from, to) = (sub(element.start, center), sub(point, center));
            let angle = cross(from, to).atan2(dot(from, to));
            let angle = if counter_clockwise { angle } else { -angle };
            angle.rem_euclid(std::f64::consts::TAU) <= sweep
        }
    }
}

/// Whether the foot of a point on the line of an element lies within the element.
fn is_beside_line(element: &Element, point: Point) -> bool {
    let way = sub(element.end, element.start);
    let s = dot(sub(point, element.start), way);
    // A line without length has no direction; its ends are tried anyway.
    s >= 0.0 && s <= dot(way, way) && way != [0.0; 2]
}

/// Least distance of two elements, and the points where it is: on the first, on the second.
pub(super) fn between(a: &Element, b: &Element) -> (f64, Point, Point) {
    let mut best = (f64::INFINITY, a.start, b.start);
    let mut consider = |p: Point, q: Point| {
        let distance = norm(sub(p, q));
        if distance < best.0 {
            best = (distance, p, q);
        }
    };
    for p in ends(a) {
        consider(p, nearest(b, p).1);
    }
    for q in ends(b) {
        consider(nearest(a, q).1, q);
    }
    for (p, q) in square(a, b).into_iter().flatten() {
        consider(p, q);
    }
    for x in crossings(a, b).into_iter().flatten() {
        consider(x, x);
    }
    best
}

/// Points inside of both elements with the joining line square to both.
fn square(a: &Element, b: &Element) -> [Option<(Point, Point)>; 4] {
    let mut found = [None; 4];
    match (a.shape, b.shape) {
        (ElementShape::Line, ElementShape::Line) => {}
        (ElementShape::Line, ElementShape::Arc { center, radius, .. }) => {
            found = perpendicular(a, b, center, radius);
        }
        (ElementShape::Arc { center, radius, .. }, ElementShape::Line) => {
            found = perpendicular(b, a, center, radius).map(|pair| pair.map(|(p, q)| (q, p)));
        }
        (ElementShape::Arc { center: c, radius: r, .. }, ElementShape::Arc { center: d, radius: s, .. }) => {
            let way = sub(d, c);
            // With a common center the distance is constant; the ends of the two give it.
            if norm(way) > NO_DIRECTION_MM {
                let u = unit(way);
                let pairs = [(r, s), (r, -s), (-r, s), (-r, -s)];
                for (place, (r, s)) in found.iter_mut().zip(pairs) {
                    let (p, q) = (along(c, u, r), along(d, u, s));
                    *place = (is_beside_arc(a, p) && is_beside_arc(b, q)).then_some((p, q));
                }
            }
        }
    }
    found
}

/// Foot of the center on the line, and the points of the circle in line with it.
fn perpendicular(line: &Element, arc: &Element, center: Point, radius: f64) -> [Option<(Point, Point)>; 4] {
    if !is_beside_line(line, center) {
        return [None; 4];
    }
    let direction = line.first_tangent();
    let foot = along(line.start, direction, dot(sub(center, line.start), direction));
    let normal = left(direction);
    let pair = |r: f64| Some((foot, along(center, normal, r))).filter(|(_, q)| is_beside_arc(arc, *q));
    [pair(radius), pair(-radius), None, None]
}

/// Points that lie on both elements; none where they touch by rounding only.
pub(super) fn crossings(a: &Element, b: &Element) -> [Option<Point>; 2] {
    let on = |e: &Element, x: Point| match e.shape {
        ElementShape::Line => is_beside_line(e, x),
        ElementShape::Arc { .. } => is_beside_arc(e, x),
    };
    whole_crossings(a, b).map(|x| x.filter(|x| on(a, *x) && on(b, *x)))
}

/// Crossings of the lines and circles on which the elements lie.
fn whole_crossings(a: &Element, b: &Element) -> [Option<Point>; 2] {
    let line_and_circle = |line: &Element, center: Point, radius: f64| {
        let direction = line.first_tangent();
        let to_center = sub(center, line.start);
        let distance = cross(direction, to_center);
        let square = radius * radius - distance * distance;
        if square < 0.0 {
            return [None, None];
        }
        let foot = dot(to_center, direction);
        [foot - square.sqrt(), foot + square.sqrt()].map(|s| Some(along(line.start, direction, s)))
    };
    match (a.shape, b.shape) {
        (ElementShape::Line, ElementShape::Line) => {
            let (s, t) = (sub(a.end, a.start), sub(b.end, b.start));
            let across = cross(s, t);
            if across == 0.0 {
                return [None, None];
            }
            [Some(along(a.start, s, cross(sub(b.start, a.start), t) / across)), None]
        }
        (ElementShape::Line, ElementShape::Arc { center, radius, .. }) => line_and_circle(a, center, radius),
        (ElementShape::Arc { center, radius, .. }, ElementShape::Line) => line_and_circle(b, center, radius),
        (ElementShape::Arc { center: c, radius: r, .. }, ElementShape::Arc { center: d, radius: s, .. }) => {
            let way = sub(d, c);
            let distance = norm(way);
            if distance < NO_DIRECTION_MM {
                return [None, None];
            }
            let foot = (distance * distance + r * r - s * s) / (2.0 * distance);
            let square = r * r - foot * foot;
            if square < 0.0 {
                return [None, None];
            }
            let u = unit(way);
            let middle = along(c, u, foot);
            [square.sqrt(), -square.sqrt()].map(|h| Some(along(middle, left(u), h)))
        }
    }
}

/// Box about an element: least and greatest coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    low: Point,
    high: Point,
}

impl Bounds {
    pub(super) const EMPTY: Self = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    pub(super) fn of(element: &Element) -> Self {
        let mut bounds = Self::EMPTY;
        for p in ends(element) {
            bounds.take(p);
        }
        if let ElementShape::Arc { center, radius, .. } = element.shape {
            for u in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
                let p = along(center, u, radius);
                if is_beside_arc(element, p) {
                    bounds.take(p);
                }
            }
        }
        bounds
    }

    fn take(&mut self, p: Point) {
        for (i, at) in p.into_iter().enumerate() {
            self.low[i] = self.low[i].min(at);
            self.high[i] = self.high[i].max(at);
        }
    }

    pub(super) fn join(&mut self, other: &Self) {
        self.take(other.low);
        self.take(other.high);
    }

    /// A distance that no point of the box goes below, to an element with the given box; NaN coordinates give
    /// zero.
    pub(super) fn at_least(&self, element: &Element, bounds: &Self) -> f64 {
        let gap = |i: usize| (bounds.low[i] - self.high[i]).max(self.low[i] - bounds.high[i]).max(0.0);
        let boxes = norm([gap(0), gap(1)]);
        let center = [0.5 * (self.low[0] + self.high[0]), 0.5 * (self.low[1] + self.high[1])];
        let half = [0.5 * (self.high[0] - self.low[0]), 0.5 * (self.high[1] - self.low[1])];
        let curve = match element.shape {
            // Along the normal of the line, the box reaches as far as its corners.
            ElementShape::Line => {
                let n = left(element.first_tangent());
                dot(sub(center, element.start), n).abs() - half[0] * n[0].abs() - half[1] * n[1].abs()
            }
            ElementShape::Arc { center: c, radius, .. } => (norm(sub(center, c)) - radius).abs() - norm(half),
        };
        boxes.max(curve)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn random(state: &mut u64, low: f64, high: f64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((*state >> 33) as f64 / f64::from(1u32 << 31))
    }

    fn element(state: &mut u64) -> Element {
        let mut point = || [random(state, -10.0, 10.0), random(state, -10.0, 10.0)];
        let (start, other) = (point(), point());
        if random(state, 0.0, 1.0) < 0.5 {
            return Element { start, end: other, shape: ElementShape::Line };
        }
        let (sweep, counter_clockwise) = (random(state, 0.01, TAU), random(state, 0.0, 1.0) < 0.5);
        let shape = ElementShape::Arc { center: other, radius: norm(sub(start, other)), counter_clockwise, sweep };
        let mut arc = Element { start, end: start, shape };
        arc.end = ends(&arc)[1];
        arc
    }

    fn at(e: &Element, s: f64) -> Point {
        match e.shape {
            ElementShape::Line => along(e.start, sub(e.end, e.start), s),
            ElementShape::Arc { center, radius, counter_clockwise, sweep } => {
                let shape = ElementShape::Arc { center, radius, counter_clockwise, sweep: s * sweep };
                ends(&Element { shape, ..*e })[1]
            }
        }
    }

    #[test]
    fn distances_are_those_of_dense_points() {
        // 400 points on each of two curves of up to 60 mm: the least distance of points is above the true one
        // by at most the way between two points, and never below.
        let mut state = 5;
        for _ in 0..300 {
            let (a, b) = (element(&mut state), element(&mut state));
            let (distance, p, q) = between(&a, &b);
            assert!((norm(sub(p, q)) - distance).abs() < 1e-12);
            assert!(nearest(&a, p).0 < 1e-9 && nearest(&b, q).0 < 1e-9, "{a:?} {b:?}");
            let points = |e: &Element| -> Vec<Point> { (0..=400).map(|k| at(e, f64::from(k) / 400.0)).collect() };
            let (on_a, on_b) = (points(&a), points(&b));
            let dense = on_a
                .iter()
                .map(|p| on_b.iter().map(|q| norm(sub(*p, *q))).fold(f64::INFINITY, f64::min))
                .fold(f64::INFINITY, f64::min);
            assert!(distance <= dense + 1e-9 && dense <= distance + 0.4, "{distance} {dense} {a:?} {b:?}");
            let sampled = on_b.iter().map(|q| nearest(&a, *q).0).fold(f64::INFINITY, f64::min);
            assert!(distance <= sampled + 1e-9 && sampled <= distance + 0.2, "{distance} {sampled}");
            assert!(Bounds::of(&b).at_least(&a, &Bounds::of(&a)) <= distance + 1e-9);
        }
    }

    #[test]
    fn a_touch_and_one_center_are_reported() {
        let arc = |center: Point, start: Point, sweep: f64| Element {
            start,
            end: start,
            shape: ElementShape::Arc { center, radius: norm(sub(start, center)), counter_clockwise: true, sweep },
        };
        // Two full circles that touch from outside, one inside of the other, and about one center.
        assert!(between(&arc([0.0; 2], [3.0, 0.0], TAU), &arc([5.0, 0.0], [5.0, 2.0], TAU)).0 < 1e-12);
        assert!((between(&arc([0.0; 2], [9.0, 0.0], TAU), &arc([5.0, 0.0], [5.0, 2.0], TAU)).0 - 2.0).abs() < 1e-12);
        assert!((between(&arc([0.0; 2], [3.0, 0.0], TAU), &arc([0.0; 2], [0.0, 5.0], 1.0)).0 - 2.0).abs() < 1e-12);
        let point = Element { start: [1.0, 1.0], end: [1.0, 1.0], shape: ElementShape::Line };
        assert!((between(&point, &arc([0.0; 2], [3.0, 0.0], TAU)).0 - (3.0 - 2f64.sqrt())).abs() < 1e-12);
    }
}
