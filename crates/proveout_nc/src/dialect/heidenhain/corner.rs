//! RND and CHF: rounding and chamfer between two elements of a contour.
//!
//! ```text
//!        next
//!         |          The center of the rounding is as far from both elements: it lies where the two
//!         T2         elements, both moved by r to the side of the turn, meet. T1 and T2 are its feet on
//!         |` .  c    the elements.
//! prev ---T1--K      K: the corner as programmed. Lines and arcs alike; an arc moved sideways is an arc
//!                    of another radius about the same center.
//! ```
//!
//! The previous element waits in the queue until the next one is known. It then ends at T1, and the
//! next one begins at T2. Limits: both elements lie in the working plane and move no rotary axis; a
//! chamfer joins two lines.

use std::f64::consts::TAU;

use super::motion::{Goal, ROTARY};
use super::run_state::Interpreter;
use super::words::{PathFunction, Words};
use crate::arc::PlaneArc;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{ArcMotion, AxisValues, Command, Feed, Location, Motion, Op};

/// Feet of the rounding may lie this far outside an element, mm: allows for rounded coordinates,
/// not for geometry.
const SLACK_MM: f64 = 1e-6;
/// Sine of the angle between two lines below which they do not meet.
const PARALLEL: f64 = 1e-12;
/// Sine of the angle between two elements below which they form no corner.
const NO_CORNER: f64 = 1e-9;

type Point = [f64; 2];

/// A corner that waits for its second element.
#[derive(Clone, Debug)]
pub(crate) struct PendingCorner {
    chamfer: bool,
    /// Radius or side, mm.
    size: f64,
    feed: Option<Feed>,
    location: Location,
}

#[derive(Clone, Copy, Debug)]
enum CornerElement {
    Line { from: Point, to: Point },
    Arc { center: Point, radius: f64, from: Point, to: Point, sweep: f64, ccw: bool },
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn along(a: Point, d: Point, t: f64) -> Point {
    [a[0] + t * d[0], a[1] + t * d[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn length(a: Point) -> f64 {
    a[0].hypot(a[1])
}

fn unit(a: Point) -> Option<Point> {
    let l = length(a);
    (l > crate::arc::SAME_POINT_MM).then(|| [a[0] / l, a[1] / l])
}

/// Angle from a to b about a center, in [0, 2 pi).
fn turned(center: Point, a: Point, b: Point, ccw: bool) -> f64 {
    let (p, q) = (minus(a, center), minus(b, center));
    let angle = cross(p, q).atan2(dot(p, q));
    let angle = if ccw { angle } else { -angle };
    if angle < 0.0 { angle + TAU } else { angle }
}

impl CornerElement {
    /// Direction of motion at the start or at the end.
    fn direction(&self, at_end: bool) -> Option<Point> {
        match *self {
            Self::Line { from, to } => unit(minus(to, from)),
            Self::Arc { center, from, to, ccw, .. } => {
                let r = unit(minus(if at_end { to } else { from }, center))?;
                Some(if ccw { [-r[1], r[0]] } else { [r[1], -r[0]] })
            }
        }
    }

    /// Foot of a point on the element as extended.
    fn foot(&self, p: Point) -> Option<Point> {
        match *self {
            Self::Line { from, to } => {
                let d = unit(minus(to, from))?;
                Some(along(from, d, dot(minus(p, from), d)))
            }
            Self::Arc { center, radius, .. } => Some(along(center, unit(minus(p, center))?, radius)),
        }
    }

    /// True when a point of the extended element lies on the element itself.
    fn holds(&self, p: Point) -> bool {
        match *self {
            Self::Line { from, to } => {
                let Some(d) = unit(minus(to, from)) else { return false };
                let t = dot(minus(p, from), d);
                t > -SLACK_MM && t < length(minus(to, from)) + SLACK_MM
            }
            Self::Arc { center, radius, from, sweep, ccw, .. } => {
                let angle = turned(center, from, p, ccw);
                let slack = SLACK_MM / radius;
                angle <= sweep + slack || angle >= TAU - slack
            }
        }
    }
}

/// Points where two elements, each moved to the left by `shift`, meet.
fn meets(a: &CornerElement, b: &CornerElement, shift: f64) -> Vec<Point> {
    // A moved line is a point and a direction, a moved arc a center and a radius.
    enum OffsetElement {
        Line(Point, Point),
        Circle(Point, f64),
    }
    let moved = |e: &CornerElement| match *e {
        CornerElement::Line { from, to } => {
            unit(minus(to, from)).map(|d| OffsetElement::Line(along(from, [-d[1], d[0]], shift), d))
        }
        CornerElement::Arc { center, radius, ccw, .. } => {
            let r = if ccw { radius - shift } else { radius + shift };
            (r > SLACK_MM).then_some(OffsetElement::Circle(center, r))
        }
    };
    let line_circle = |p: Point, d: Point, c: Point, r: f64| {
        let foot = along(p, d, dot(minus(c, p), d));
        let h2 = r * r - dot(minus(foot, c), minus(foot, c));
        if h2 < -SLACK_MM * r {
            return Vec::new();
        }
        let h = h2.max(0.0).sqrt();
        vec![along(foot, d, h), along(foot, d, -h)]
    };
    match (moved(a), moved(b)) {
        (Some(OffsetElement::Line(p, d)), Some(OffsetElement::Line(q, e))) => {
            let det = cross(d, e);
            if det.abs() < PARALLEL { Vec::new() } else { vec![along(p, d, cross(minus(q, p), e) / det)] }
        }
        (Some(OffsetElement::Line(p, d)), Some(OffsetElement::Circle(c, r)))
        | (Some(OffsetElement::Circle(c, r)), Some(OffsetElement::Line(p, d))) => line_circle(p, d, c, r),
        (Some(OffsetElement::Circle(c, r)), Some(OffsetElement::Circle(k, s))) => {
            let between = minus(k, c);
            let Some(d) = unit(between) else { return Vec::new() };
            let distance = length(between);
            // The common chord of the two circles is a line across the line of centers.
            let t = (distance * distance + r * r - s * s) / (2.0 * distance);
            line_circle(along(c, d, t), [-d[1], d[0]], c, r)
        }
        _ => Vec::new(),
    }
}

pub(crate) fn no_element(span: Span) -> Fault {
    Fault::new(codes::STRUCTURE, span, "RND or CHF is not followed by an element of the contour")
        .help("write L, C, CR, CT, LP or CP after RND and CHF")
}

fn wrong(message: impl Into<String>) -> Fault {
    Fault::new(codes::ARC_GEOMETRY, Span::default(), message).help("choose a smaller rounding or chamfer")
}

impl Interpreter {
    /// RND R5, CHF 2.
    pub(crate) fn begin_corner(&mut self, path: PathFunction, w: &Words, span: Span) -> Result<(), Fault> {
        let chamfer = path == PathFunction::Chamfer;
        let name = if chamfer { "CHF" } else { "RND" };
        let Some(size) = (if chamfer { w.length } else { w.radius }) else {
            return Err(Fault::new(codes::MISSING_VALUE, span, format!("`{name}` has no size")).help(if chamfer {
                "write CHF 2"
            } else {
                "write RND R5"
            }));
        };
        let size = self.variables.value(size, span)? * self.modal.unit();
        if !(size > 0.0 && size.is_finite()) {
            return Err(Fault::new(
                codes::BAD_VALUE,
                span,
                format!("the size of `{name}` must be above zero and is {size}"),
            )
            .help("write a length above zero"));
        }
        if !w.functions.is_empty() || w.programmed != 0 || w.side.is_some() {
            return Err(Fault::new(codes::CONFLICT, span, format!("`{name}` takes its size and a feed only"))
                .help("write the other words in another block"));
        }
        if self.modal.corner.is_some() {
            return Err(no_element(span));
        }
        let usable = self.modal.held && self.queue.len() == 1;
        if !usable {
            return Err(Fault::new(
                codes::STRUCTURE,
                span,
                format!("`{name}` does not follow a contour element at feed rate"),
            )
            .help("write it directly after L, C, CR, CT, LP or CP at feed rate"));
        }
        let feed = match w.feed {
            Some(word) => self.feed_of(word, span)?,
            None => None,
        };
        self.modal.corner = Some(PendingCorner { chamfer, size, feed, location: self.location.clone() });
        Ok(())
    }

    fn plane_point(&self, values: &AxisValues) -> Option<Point> {
        let [u, v, _] = self.modal.plane_axes();
        Some([values.get(u)?, values.get(v)?])
    }

    /// The element that waits in the queue.
    fn waiting(&self) -> Option<CornerElement> {
        let [u, v, n] = self.modal.plane_axes();
        match &self.queue.front()?.0.op {
            Op::Linear(m) => {
                let from = &self.modal.line_start;
                let level = from.get(n)? == m.end.get(n)?;
                let flat = level && m.programmed & ROTARY == 0 && m.tool_axis.is_none();
                flat.then_some(())?;
                Some(CornerElement::Line { from: self.plane_point(from)?, to: self.plane_point(&m.end)? })
            }
            Op::Arc(a) => {
                let (center, to) = ([a.center[u], a.center[v]], self.plane_point(&a.motion.end)?);
                // The plane of the center carries the height of the start.
                (a.center[n] == a.motion.end.get(n)?).then_some(())?;
                let ccw = a.normal[n] > 0.0;
                let from = crate::arc::end_after(to, center, a.sweep, ccw);
                Some(CornerElement::Arc { center, radius: length(minus(to, center)), from, to, sweep: a.sweep, ccw })
            }
            _ => None,
        }
    }

    /// Corner before a straight element.
    pub(crate) fn corner_to_line(&mut self, start: AxisValues, motion: &Motion, span: Span) -> Result<(), Fault> {
        let [_, _, n] = self.modal.plane_axes();
        let flat = start.get(n) == motion.end.get(n) && motion.programmed & ROTARY == 0 && motion.tool_axis.is_none();
        let ends = self.plane_point(&start).zip(self.plane_point(&motion.end)).filter(|_| flat);
        let Some((from, to)) = ends else { return Err(not_flat(span)) };
        self.corner_between(CornerElement::Line { from, to }, span).map(|_| ())
    }

    /// Corner before an arc: gives the arc without its beginning.
    pub(crate) fn corner_to_arc(&mut self, mut op: ArcMotion, span: Span) -> Result<ArcMotion, Fault> {
        let [u, v, n] = self.modal.plane_axes();
        let from = self.plane_point(&self.position.work);
        let ends =
            from.zip(self.plane_point(&op.motion.end)).filter(|_| self.position.work.get(n) == op.motion.end.get(n));
        let Some((from, to)) = ends else { return Err(not_flat(span)) };
        let (center, ccw) = ([op.center[u], op.center[v]], op.normal[n] > 0.0);
        let element =
            CornerElement::Arc { center, radius: length(minus(from, center)), from, to, sweep: op.sweep, ccw };
        let begin = self.corner_between(element, span)?;
        op.sweep -= turned(center, from, begin, ccw);
        Ok(op)
    }

    /// Shortens the waiting element, inserts the corner after it, and returns the point where the
    /// next element begins.
    fn corner_between(&mut self, next: CornerElement, span: Span) -> Result<Point, Fault> {
        let at = |fault: Fault| Fault { span, ..fault };
        let Some(corner) = self.modal.corner.take() else { return Err(no_element(span)) };
        let Some(previous) = self.waiting() else { return Err(not_flat(span)) };
        let (Some(t1), Some(t2)) = (previous.direction(true), next.direction(false)) else {
            return Err(at(wrong("an element at the corner has no length")));
        };
        let side = cross(t1, t2);
        if side.abs() < NO_CORNER {
            return Err(at(wrong("the two elements that RND or CHF joins do not form a corner")));
        }
        let left = side > 0.0;
        let (from, to, center) = if corner.chamfer {
            let (CornerElement::Line { to: k, .. }, CornerElement::Line { .. }) = (previous, next) else {
                return Err(at(wrong("CHF needs a straight line on both sides")));
            };
            let (a, b) = (along(k, t1, -corner.size), along(k, t2, corner.size));
            if !previous.holds(a) || !next.holds(b) {
                return Err(at(wrong(format!(
                    "the chamfer of {} mm is longer than an element that it joins",
                    corner.size
                ))));
            }
            (a, b, None)
        } else {
            let k = match previous {
                CornerElement::Line { to, .. } | CornerElement::Arc { to, .. } => to,
            };
            let found = meets(&previous, &next, if left { corner.size } else { -corner.size })
                .into_iter()
                .filter_map(|c| Some((c, previous.foot(c)?, next.foot(c)?)))
                .filter(|(_, a, b)| previous.holds(*a) && next.holds(*b))
                .min_by(|a, b| length(minus(a.0, k)).total_cmp(&length(minus(b.0, k))));
            let Some((c, a, b)) = found else {
                return Err(at(wrong(format!(
                    "a rounding of {} mm does not fit between the two elements",
                    corner.size
                ))));
            };
            (a, b, Some(c))
        };
        self.shorten(from, span)?;
        self.insert_corner(&corner, from, to, center, left, span)?;
        Ok(to)
    }

    fn flat_goal(&self, point: Point) -> Goal {
        let [u, v, _] = self.modal.plane_axes();
        let mut goal = Goal { end: self.position.work, programmed: 1 << u | 1 << v, tool_axis: None };
        goal.end.put(u, point[0]);
        goal.end.put(v, point[1]);
        goal
    }

    fn shorten(&mut self, end: Point, span: Span) -> Result<(), Fault> {
        let [u, v, n] = self.modal.plane_axes();
        let motion = self.complete(self.flat_goal(end), span)?;
        match self.queue.front_mut().map(|(c, ())| &mut c.op) {
            Some(Op::Linear(m)) => (m.end, m.end_base) = (motion.end, motion.end_base),
            Some(Op::Arc(a)) => {
                let center = [a.center[u], a.center[v]];
                let old = [a.motion.end.get(u).unwrap_or(0.0), a.motion.end.get(v).unwrap_or(0.0)];
                a.sweep -= turned(center, end, old, a.normal[n] > 0.0);
                (a.motion.end, a.motion.end_base) = (motion.end, motion.end_base);
            }
            _ => {}
        }
        Ok(())
    }

    fn insert_corner(
        &mut self,
        corner: &PendingCorner,
        from: Point,
        to: Point,
        center: Option<Point>,
        left: bool,
        span: Span,
    ) -> Result<(), Fault> {
        let op = match center {
            None => Op::Linear(self.complete(self.flat_goal(to), span)?),
            Some(center) => {
                let sweep = turned(center, from, to, left);
                let arc = PlaneArc { center, radius: corner.size, sweep };
                Op::Arc(self.arc_motion(self.modal.normal, self.flat_goal(to), arc, !left, span)?)
            }
        };
        let mut ops = vec![op];
        // A feed of RND or CHF holds for the corner only. The previous feed holds again until the
        // next block sets its own.
        if let (Some(feed), Some(before)) = (corner.feed, self.feed_before_corner()) {
            ops = vec![Op::Feed(feed), ops.remove(0), Op::Feed(before)];
        }
        for (at, op) in ops.into_iter().enumerate() {
            self.queue.insert(1 + at, (Command { location: corner.location.clone(), op }, ()));
        }
        Ok(())
    }

    /// The feed in force at the corner: that of the element before it.
    fn feed_before_corner(&self) -> Option<Feed> {
        self.modal.element_feed
    }
}

fn not_flat(span: Span) -> Fault {
    Fault::new(codes::ARC_GEOMETRY, span, "the elements that RND or CHF joins do not lie in the working plane")
        .help("write RND and CHF between elements that move in the working plane only")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_touches_both_elements() {
        // A line along x into a circle of radius 20 about (30, 20): rounding 3 on the left of both.
        let line = CornerElement::Line { from: [0.0, 0.0], to: [30.0, 5.0] };
        let arc = CornerElement::Arc {
            center: [50.0, 5.0],
            radius: 20.0,
            from: [30.0, 5.0],
            to: [50.0, 25.0],
            sweep: 3.0 * TAU / 4.0,
            ccw: true,
        };
        for shift in [3.0, -3.0] {
            for c in meets(&line, &arc, shift) {
                let (a, b) = (line.foot(c).unwrap(), arc.foot(c).unwrap());
                assert!((length(minus(a, c)) - 3.0).abs() < 1e-9);
                assert!((length(minus(b, c)) - 3.0).abs() < 1e-9);
            }
        }
    }
}
