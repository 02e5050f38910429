//! Free contours (FK): FL, FLT, FC, FCT, as far as their data fix each element from the one before or by the
//! next ones.
//!
//! ```text
//!        C1  .--.                      FC DR- R18 CCX CCY        its end waits for what follows
//!          (  .--)-. P1                FLT                       tangential: waits too
//!           '-'     '.  d              FCT DR- R15 CCX CCY       both contacts are known now
//!                     '.  P2  .--.
//!                       '.--(    )     with s = 1 counter-clockwise, -1 clockwise, n to the left of d:
//!                            '--' C2   P = C - s R n,  (C2 - C1) n = s2 R2 - s1 R1
//! ```
//!
//! After HEIDENHAIN, *TNC 640 Klartext programming*, "FK free contour programming": end point X Y or PR PA
//! (about FPOL), length LEN and angle AN of a line, center CCX CCY, radius R, sense DR and angle CCA of a
//! circle, CLSD+ and CLSD- for the first and the last element of a closed contour, FLT and FCT tangential to
//! the element before. Elements that have several solutions (FSELECT), relative data (RX, PAR, DP) and
//! auxiliary points (P1X) are refused.

use super::motion::Goal;
use super::run_state::{Free, Heidenhain, Held, Interpreter, SignedCircle};
use super::words::{Coordinate, FreeKind, Reference, Words};
use crate::arc::{self, PlaneArc};
use crate::channel::milling::Mills;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::sin_cos_degrees;

type Point = [f64; 2];

/// How far a point may be from where its other data put it, mm: coordinates are written with three
/// decimals.
const WRITTEN_MM: f64 = 0.005;

/// What a block says of its element, mm and degrees.
struct Data {
    end: [Option<f64>; 2],
    direction: Option<Point>,
    length: Option<f64>,
    center: Option<Point>,
    radius: Option<f64>,
    clockwise: Option<bool>,
    through: Option<f64>,
}

fn open(span: Span) -> Fault {
    Fault::new(
        codes::UNSUPPORTED_WORD,
        span,
        "the data of this element of a free contour do not fix it by itself or with the next ones",
    )
    .help(
        "write its end X Y, LEN and AN, or center, R and DR; or convert the contour into L and C blocks on the control",
    )
}

fn contradicts(span: Span, what: String) -> Fault {
    Fault::new(codes::ARC_GEOMETRY, span, what).help("check the data of the free contour")
}

fn left(d: Point) -> Point {
    [-d[1], d[0]]
}

fn along(p: Point, d: Point, by: f64) -> Point {
    [p[0] + by * d[0], p[1] + by * d[1]]
}

fn way(from: Point, to: Point) -> f64 {
    (to[0] - from[0]).hypot(to[1] - from[1])
}

/// Direction of the line that leaves one circle and meets another, each in its own sense. A point
/// is a circle of radius zero.
fn tangent(from: SignedCircle, to: SignedCircle) -> Option<Point> {
    let d = [to.center[0] - from.center[0], to.center[1] - from.center[1]];
    let sine = (to.signed - from.signed) / d[0].hypot(d[1]);
    if sine.is_nan() || sine.abs() > 1.0 {
        return None;
    }
    let (s, c) = (d[1].atan2(d[0]) - sine.asin()).sin_cos();
    Some([c, s])
}

/// Where a circle has this direction.
fn contact(circle: SignedCircle, d: Point) -> Point {
    along(circle.center, left(d), -circle.signed)
}

impl Interpreter {
    /// The fault of a block that follows waiting elements and does not determine their ends.
    pub(super) fn free_is_open(&mut self, span: Span) -> Option<Fault> {
        if !self.own.free.waits() {
            return None;
        }
        self.own.free = Free { pole: self.own.free.pole, ..Free::default() };
        Some(open(span))
    }

    fn free_data(&self, w: &Words, span: Span) -> Result<Data, Fault> {
        let [u, v, _] = self.modal.plane_axes();
        let value = |v| self.variables.value(v, span);
        let mm = |v| value(v).map(|v| v * self.modal.unit());
        if w.programmed & !(1 << u | 1 << v) != 0 {
            return Err(Fault::new(
                codes::UNSUPPORTED_WORD,
                span,
                "axes outside of the working plane are not read in a free contour",
            )
            .help("move them before the contour"));
        }
        let waits = self.own.free.waits();
        let mut end = [None; 2];
        for (slot, axis) in end.iter_mut().zip([u, v]) {
            let Some(c) = w.axes[axis] else { continue };
            let distance = self.coordinate(axis, value(c.value)?);
            *slot = Some(match c.reference {
                Reference::Incremental if waits => return Err(open(span)),
                Reference::Incremental => self.known(axis, span)? + distance,
                _ => distance,
            });
        }
        match (w.polar_radius, w.polar_angle) {
            (None, None) => {}
            (Some(radius), Some(angle))
                if w.programmed == 0
                    && radius.reference != Reference::Incremental
                    && angle.reference != Reference::Incremental =>
            {
                let pole = self.own.free.pole.ok_or_else(|| {
                    Fault::new(
                        codes::MISSING_VALUE,
                        span,
                        "PR and PA of a free contour count from FPOL, and none is there",
                    )
                    .help("write FPOL X Y before the element")
                })?;
                let (s, c) = sin_cos_degrees(value(angle.value)?);
                let radius = mm(radius.value)?;
                end = [Some(pole[0] + radius * c), Some(pole[1] + radius * s)];
            }
            _ => return Err(open(span)),
        }
        if w.closed == Some(false) {
            let start = self.own.free.start.ok_or_else(|| {
                Fault::new(codes::MISSING_VALUE, span, "CLSD- ends a contour that no CLSD+ has begun")
                    .help("write CLSD+ in its first element")
            })?;
            end = start.map(Some);
        }
        let center = match w.circle {
            [None, None] => None,
            [Some(x), Some(y)] => Some([mm(x)?, mm(y)?]),
            _ => return Err(open(span)),
        };
        let direction = w.line_angle.map(&value).transpose()?.map(|angle| {
            let (s, c) = sin_cos_degrees(angle);
            [c, s]
        });
        Ok(Data {
            end,
            direction,
            length: w.length.map(mm).transpose()?,
            center,
            radius: w.radius.map(mm).transpose()?.map(f64::abs),
            clockwise: w.clockwise,
            through: w.arc_angle.map(value).transpose()?,
        })
    }

    /// FPOL: where PR and PA of a free contour count from.
    pub(super) fn free_pole(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        let [u, v, _] = self.modal.plane_axes();
        let other = w.feed.is_some() || w.side.is_some() || !w.functions.is_empty() || w.polar_angle.is_some();
        let (Some(x), Some(y), false) = (w.axes[u], w.axes[v], other || w.polar_radius.is_some()) else {
            return Err(Fault::new(
                codes::MISSING_VALUE,
                span,
                "FPOL takes both coordinates of the plane and nothing else",
            )
            .help("write FPOL X+20 Y+30"));
        };
        if [x, y].iter().any(|c| c.reference == Reference::Incremental) || w.programmed & !(1 << u | 1 << v) != 0 {
            return Err(open(span));
        }
        let at = |axis, c: Coordinate| self.variables.value(c.value, span).map(|value| self.coordinate(axis, value));
        self.own.free.pole = Some([at(u, x)?, at(v, y)?]);
        Ok(())
    }

    /// Executes an element.
    pub(super) fn free(&mut self, kind: FreeKind, w: &Words, rapid: bool, span: Span) -> Result<(), Fault> {
        let done = self.free_element(kind, w, rapid, span);
        if done.is_err() {
            self.own.free = Free { pole: self.own.free.pole, ..Free::default() };
        }
        done
    }

    fn free_element(&mut self, kind: FreeKind, w: &Words, rapid: bool, span: Span) -> Result<(), Fault> {
        let waited = self.own.free.waits();
        let other = !w.functions.is_empty() || w.side.is_some();
        if rapid || waited && (other || w.feed.is_some() || w.closed == Some(true)) {
            return Err(Fault::new(
                codes::CONFLICT,
                span,
                "FMAX in a free contour, or F, M, RL or RR after an element whose end is still open",
            )
            .help("write them in front of the contour"));
        }
        let data = self.free_data(w, span)?;
        if w.closed == Some(true) {
            self.own.free.start = Some(self.flat(span)?);
        }
        match kind {
            FreeKind::Line | FreeKind::LineTangent => self.free_line(kind == FreeKind::LineTangent, &data, span)?,
            FreeKind::Arc | FreeKind::ArcTangent => self.free_arc(kind == FreeKind::ArcTangent, &data, span)?,
        }
        if !waited && other && self.own.free.waits() && !w.functions.is_empty() {
            return Err(Fault::new(codes::CONFLICT, span, "an M function at an element whose end is still open")
                .help("write it in front of the contour"));
        }
        if w.closed == Some(false) {
            self.own.free.start = None;
        }
        Ok(())
    }

    fn free_line(&mut self, tangential: bool, data: &Data, span: Span) -> Result<(), Fault> {
        if data.center.is_some() || data.radius.is_some() || data.clockwise.is_some() || data.through.is_some() {
            return Err(Fault::new(codes::CONFLICT, span, "words of a circle in a straight line of a free contour")
                .help("write FC or FCT"));
        }
        let waited = self.own.free.waits();
        if waited && tangential && data.end == [None; 2] && data.direction.is_none() && data.length.is_none() {
            if matches!(self.own.free.held.as_slice(), [(_, Held::Arc(_))]) {
                self.own.free.held.push((self.location.clone(), Held::Line));
                return Ok(());
            }
            return Err(open(span));
        }
        let mut direction = data.direction;
        if waited {
            let Some(&(_, Held::Arc(circle))) = self.own.free.held.last() else { return Err(open(span)) };
            if !tangential {
                return Err(open(span));
            }
            let d = match (data.direction, data.end) {
                (Some(d), _) => d,
                (None, [Some(x), Some(y)]) => tangent(circle, SignedCircle { center: [x, y], signed: 0.0 })
                    .ok_or_else(|| {
                        contradicts(span, "the end of the tangential line lies inside of the circle".to_owned())
                    })?,
                _ => return Err(open(span)),
            };
            self.end_held(contact(circle, d), span)?;
            direction = Some(d);
        } else if tangential {
            let d = self.modal.tangent.ok_or_else(|| open(span))?;
            let length = d[0].hypot(d[1]);
            direction = direction.or(Some([d[0] / length, d[1] / length]));
        }
        let from = self.flat(span)?;
        let to = match (data.end, direction, data.length) {
            ([Some(x), Some(y)], _, _) => [x, y],
            ([Some(x), None], Some(d), None) if d[0] != 0.0 => along(from, d, (x - from[0]) / d[0]),
            ([None, Some(y)], Some(d), None) if d[1] != 0.0 => along(from, d, (y - from[1]) / d[1]),
            ([None, None], Some(d), Some(length)) => along(from, d, length),
            _ => return Err(open(span)),
        };
        let reach = way(from, to);
        if let Some(d) = direction {
            let beside = (to[0] - from[0]) * left(d)[0] + (to[1] - from[1]) * left(d)[1];
            let ahead = (to[0] - from[0]) * d[0] + (to[1] - from[1]) * d[1];
            if beside.abs() > WRITTEN_MM || ahead < 0.0 {
                return Err(contradicts(span, "the end of the line does not lie in its direction".to_owned()));
            }
        }
        if data.length.is_some_and(|length| (length - reach).abs() > WRITTEN_MM) {
            return Err(contradicts(span, format!("the line is {reach:.4} mm long, but LEN gives another length")));
        }
        self.free_goal(to, None, span)
    }

    fn free_arc(&mut self, tangential: bool, data: &Data, span: Span) -> Result<(), Fault> {
        if data.direction.is_some() || data.length.is_some() {
            return Err(open(span));
        }
        let Some(clockwise) = data.clockwise else {
            return Err(Fault::new(codes::MISSING_VALUE, span, "the circle of a free contour has no DR")
                .help("write DR+ or DR-"));
        };
        let sense = if clockwise { -1.0 } else { 1.0 };
        let end = match data.end {
            [Some(x), Some(y)] => Some([x, y]),
            [None, None] => None,
            _ => return Err(open(span)),
        };
        let circle = if self.own.free.waits() {
            let (Some(center), true) = (data.center, tangential) else { return Err(open(span)) };
            let radius = data.radius.or(end.map(|end| way(center, end))).ok_or_else(|| open(span))?;
            let circle = SignedCircle { center, signed: sense * radius };
            self.meet(circle, span)?;
            circle
        } else {
            let from = self.flat(span)?;
            let heading = self.modal.tangent.map(|t| {
                let length = t[0].hypot(t[1]);
                [t[0] / length, t[1] / length]
            });
            let center = match (data.center, data.radius, heading) {
                (Some(center), ..) => center,
                (None, Some(radius), Some(d)) if tangential => along(from, left(d), sense * radius),
                _ => return Err(open(span)),
            };
            let circle = SignedCircle { center, signed: sense * way(center, from) };
            if tangential {
                let d = heading.ok_or_else(|| open(span))?;
                if way(contact(circle, d), from) > WRITTEN_MM {
                    return Err(contradicts(span, "the circle is not tangential to the element before".to_owned()));
                }
            }
            circle
        };
        if data.radius.is_some_and(|radius| (radius - circle.signed.abs()).abs() > WRITTEN_MM) || circle.signed == 0.0 {
            let message =
                format!("the start lies {:.4} mm from the center, but R gives another radius", circle.signed.abs());
            return Err(contradicts(span, message));
        }
        if end.is_some_and(|end| (way(circle.center, end) - circle.signed.abs()).abs() > WRITTEN_MM) {
            return Err(contradicts(span, "the end does not lie on the circle".to_owned()));
        }
        match (end, data.through) {
            (Some(end), None) => self.free_goal(end, Some(circle), span),
            (None, Some(angle)) if angle > 0.0 && angle < 360.0 => {
                let from = self.flat(span)?;
                let (s, c) = sin_cos_degrees(sense * angle);
                let d = [from[0] - circle.center[0], from[1] - circle.center[1]];
                let end = [circle.center[0] + c * d[0] - s * d[1], circle.center[1] + s * d[0] + c * d[1]];
                self.free_goal(end, Some(circle), span)
            }
            (None, None) => {
                self.own.free.held.push((self.location.clone(), Held::Arc(circle)));
                Ok(())
            }
            _ => Err(open(span)),
        }
    }

    /// Ends what waits at a circle that it is tangential to.
    fn meet(&mut self, next: SignedCircle, span: Span) -> Result<(), Fault> {
        let waits: Vec<Held> = self.own.free.held.iter().map(|(_, held)| *held).collect();
        let none =
            || contradicts(span, "no tangential line or contact joins this circle and the one before".to_owned());
        match waits.as_slice() {
            [Held::Arc(circle)] => {
                let d = [next.center[0] - circle.center[0], next.center[1] - circle.center[1]];
                let (apart, k) = (d[0].hypot(d[1]), next.signed - circle.signed);
                if k == 0.0 || (apart - k.abs()).abs() > WRITTEN_MM {
                    return Err(none());
                }
                self.end_held(along(circle.center, d, -circle.signed / k), span)
            }
            [Held::Arc(circle), Held::Line] => {
                let d = tangent(*circle, next).ok_or_else(none)?;
                let line = self.own.free.held.pop();
                self.end_held(contact(*circle, d), span)?;
                let here = line.map(|(place, _)| std::mem::replace(&mut self.location, place));
                let moved = self.free_goal(contact(next, d), None, span);
                if let Some(here) = here {
                    self.location = here;
                }
                moved
            }
            _ => Err(open(span)),
        }
    }

    /// The circle that waits ends here.
    fn end_held(&mut self, at: Point, span: Span) -> Result<(), Fault> {
        let Some((place, Held::Arc(circle))) = self.own.free.held.pop() else { return Err(open(span)) };
        let here = std::mem::replace(&mut self.location, place);
        let moved = self.free_goal(at, Some(circle), span);
        self.location = here;
        moved
    }

    /// Straight or on a circle to a point of the working plane.
    fn free_goal(&mut self, to: Point, circle: Option<SignedCircle>, span: Span) -> Result<(), Fault> {
        let [u, v, _] = Heidenhain::working_plane(self);
        let mut end = self.position.work;
        end.put(u, to[0]);
        end.put(v, to[1]);
        let goal = Goal { end, programmed: 1 << u | 1 << v, tool_axis: None };
        let Some(circle) = circle else { return self.straight(goal, false, span) };
        let from = self.flat(span)?;
        let clockwise = circle.signed < 0.0;
        let sweep = arc::sweep(from, to, circle.center, clockwise);
        self.arc_to(goal, PlaneArc { center: circle.center, radius: circle.signed.abs(), sweep }, clockwise, span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tangent_leaves_and_meets_its_circles_in_their_sense() {
        for (r1, r2) in [(18.0, 15.0), (-18.0, -15.0), (18.0, -15.0), (-18.0, 15.0), (7.0, 0.0)] {
            let (a, b) =
                (SignedCircle { center: [20.0, 30.0], signed: r1 }, SignedCircle { center: [50.0, 75.0], signed: r2 });
            let d = tangent(a, b).unwrap();
            let (p, q) = (contact(a, d), contact(b, d));
            assert!((way(p, a.center) - r1.abs()).abs() < 1e-9 && (way(q, b.center) - r2.abs()).abs() < 1e-9);
            let line = [q[0] - p[0], q[1] - p[1]];
            let length = line[0].hypot(line[1]);
            // The line has the direction, and each circle runs along it where it touches.
            assert!((line[0] / length - d[0]).abs() < 1e-9 && (line[1] / length - d[1]).abs() < 1e-9);
            for (c, at) in [(a, p), (b, q)] {
                let out = [at[0] - c.center[0], at[1] - c.center[1]];
                assert!((out[0] * d[0] + out[1] * d[1]).abs() < 1e-9);
                assert!(c.signed * (out[0] * d[1] - out[1] * d[0]) >= 0.0);
            }
        }
        let (a, b) =
            (SignedCircle { center: [0.0, 0.0], signed: 10.0 }, SignedCircle { center: [3.0, 0.0], signed: 2.0 });
        assert!(tangent(a, b).is_none());
    }
}
