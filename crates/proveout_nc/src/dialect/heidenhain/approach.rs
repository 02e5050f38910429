//! APPR and DEP: approach and departure of a contour.
//!
//! ```text
//!   PS start      LT: the line PH-PA goes on in the direction of the contour, LEN long
//!   PH auxiliary  LN: the line PH-PA is normal to the contour, on the side of the radius compensation
//!   PA first      CT: an arc of radius R and angle CCA ends in the direction of the contour
//!   PE last       LCT: a line from PS touches an arc of radius R that ends in the direction of the contour
//!   PN end        DEP the same backwards from PE
//! ```
//!
//! Geometry after HEIDENHAIN, *TNC 640 Klartext programming*, "Approaching and departing a
//! contour". The way from PS to PH runs at the feed of the previous block, at rapid after FMAX:
//! first in the working plane, then along the tool axis. An approach waits until the first element
//! of the contour is known. RL and RR say on which side the contour is approached; R0 is refused
//! for LN, CT and LCT.

use super::circle::FULL_CIRCLE;
use super::motion::Goal;
use super::run_state::Interpreter;
use super::words::{Lead, RadiusSide, Words};
use crate::arc::{self, PlaneArc};
use crate::channel::arc_fault;
use crate::codes;
use crate::control::ArcTolerance;
use crate::diagnostic::{Fault, Span};
use crate::{AxisValues, Command, Feed, Location};

type Point = [f64; 2];

/// An approach that waits for the first element of the contour.
#[derive(Clone, Debug)]
pub(crate) struct Approach {
    lead: Lead,
    from: AxisValues,
    from_base: AxisValues,
    to: AxisValues,
    programmed: u16,
    length: f64,
    radius: f64,
    /// Radian.
    angle: f64,
    side: RadiusSide,
    rapid: bool,
    feed_before: Option<Feed>,
    feed: Option<Feed>,
    /// Place in the queue.
    at: usize,
    location: Location,
}

/// Unit vector and the vector left of it.
fn sides(t: Point) -> Option<(Point, Point)> {
    let l = t[0].hypot(t[1]);
    (l > 0.0 && l.is_finite()).then(|| ([t[0] / l, t[1] / l], [-t[1] / l, t[0] / l]))
}

fn shifted(p: Point, d: Point, by: f64) -> Point {
    [p[0] + by * d[0], p[1] + by * d[1]]
}

/// Point where the tangent from `from` touches the circle, such that moving on runs around it in the given
/// sense.
fn touch(from: Point, center: Point, radius: f64, ccw: bool) -> Option<Point> {
    let d = [from[0] - center[0], from[1] - center[1]];
    let distance = d[0].hypot(d[1]);
    if distance <= radius {
        return None;
    }
    // The angle at the center between the point and the foot has the cosine radius / distance. A
    // counter-clockwise run continues from the foot that is that angle ahead.
    let angle = (radius / distance).acos();
    let foot = arc::end_after(from, center, angle, !ccw);
    let scale = radius / distance;
    Some([center[0] + (foot[0] - center[0]) * scale, center[1] + (foot[1] - center[1]) * scale])
}

fn cannot(span: Span, message: &str, help: &str) -> Fault {
    Fault::new(codes::ARC_GEOMETRY, span, message).help(help)
}

/// Tolerance of the end points of arcs computed here, mm: covers rounding only.
const EXACT: ArcTolerance = ArcTolerance::absolute(1e-6);

impl Interpreter {
    fn lead_number(
        &self,
        value: Option<super::words::Value>,
        word: &str,
        factor: f64,
        span: Span,
    ) -> Result<f64, Fault> {
        let Some(value) = value else {
            return Err(Fault::new(
                codes::MISSING_VALUE,
                span,
                format!("`{word}` is missing in the approach or departure"),
            )
            .help(format!("write {word}")));
        };
        let number = self.variables.value(value, span)? * factor;
        if number == 0.0 || !number.is_finite() {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("`{word}` must not be zero")).help("write a length"));
        }
        Ok(number)
    }

    /// LEN, R and CCA (radian) that a form takes.
    fn lead_words(&self, lead: Lead, w: &Words, span: Span) -> Result<[f64; 3], Fault> {
        let unit = self.modal.unit();
        let mut found = [0.0; 3];
        match lead {
            Lead::LineTangent | Lead::LineNormal => found[0] = self.lead_number(w.length, "LEN", unit, span)?,
            Lead::Circle => {
                found[1] = self.lead_number(w.radius, "R", unit, span)?;
                found[2] = self.lead_number(w.arc_angle, "CCA", 1.0, span)?.to_radians();
                if !(found[2] > 0.0 && found[2] < std::f64::consts::TAU) {
                    return Err(Fault::new(codes::BAD_VALUE, span, "CCA must lie between 0 and 360 degrees")
                        .help("write CCA90"));
                }
            }
            Lead::LineCircle => found[1] = self.lead_number(w.radius, "R", unit, span)?.abs(),
        }
        Ok(found)
    }

    fn lead_side(lead: Lead, side: RadiusSide, span: Span) -> Result<f64, Fault> {
        match side {
            RadiusSide::Left => Ok(1.0),
            RadiusSide::Right => Ok(-1.0),
            RadiusSide::Off if lead == Lead::LineTangent => Ok(0.0),
            RadiusSide::Off => Err(super::lexer::refused(
                "APPR or DEP with R0",
                span,
                "write RL or RR, which say on which side the contour is approached",
            )),
        }
    }

    /// The end point of the block: Cartesian, or by PR and PA about the pole (PLT, PLN, PCT, PLCT).
    fn lead_goal(&mut self, w: &Words, span: Span) -> Result<Goal, Fault> {
        if w.polar_radius.is_some() || w.polar_angle.is_some() { self.polar_point(w, span) } else { self.goal(w, span) }
    }

    /// APPR: the position is PA from here on; the motions follow when the contour goes on.
    pub(crate) fn approach(&mut self, lead: Lead, w: &Words, rapid: bool, span: Span) -> Result<(), Fault> {
        if rapid {
            return Err(Fault::new(codes::NO_FEED, span, "an approach needs a feed and has FMAX").help("write F"));
        }
        if self.modal.approach.is_some() {
            return Err(no_contour(span));
        }
        let [length, radius, angle] = self.lead_words(lead, w, span)?;
        let side = self.modal.side.unwrap_or(RadiusSide::Off);
        Self::lead_side(lead, side, span)?;
        self.need_feed(span)?;
        let (from, from_base) = (self.position.work, self.position.base);
        self.flat(span)?;
        let goal = self.lead_goal(w, span)?;
        let motion = self.complete(goal, span)?;
        // The feed of this block is already emitted. The way to PH runs at the feed of the block
        // before.
        self.modal.approach = Some(Approach {
            lead,
            from,
            from_base,
            to: motion.end,
            programmed: w.programmed,
            length,
            radius,
            angle,
            side,
            rapid: self.modal.rapid_before,
            feed_before: self.modal.feed_before,
            feed: self.technology.feed,
            at: self.queue.len(),
            location: self.location.clone(),
        });
        self.position.move_to(motion.end, motion.end_base);
        self.modal.tangent = None;
        Ok(())
    }

    /// Puts the motions of a waiting approach into the queue; `tangent`: direction in which the contour
    /// begins.
    pub(crate) fn finish_approach(&mut self, tangent: Point, span: Span) -> Result<(), Fault> {
        let Some(a) = self.modal.approach.take() else { return Ok(()) };
        let [u, v, n] = self.modal.plane_axes();
        let Some((t, left)) = sides(tangent) else { return Err(no_contour(span)) };
        let point = |values: &AxisValues| [values.get(u).unwrap_or(0.0), values.get(v).unwrap_or(0.0)];
        let (start, first) = (point(&a.from), point(&a.to));
        let side = Self::lead_side(a.lead, a.side, span)?;
        let (helper, arc) = match a.lead {
            Lead::LineTangent => (shifted(first, t, -a.length), None),
            Lead::LineNormal => (shifted(first, left, side * a.length.abs()), None),
            Lead::Circle => {
                let side = side * a.radius.signum();
                let center = shifted(first, left, side * a.radius.abs());
                // Backwards from the first point of the contour.
                let helper = arc::end_after(first, center, a.angle, side > 0.0);
                (helper, Some((PlaneArc { center, radius: a.radius.abs(), sweep: a.angle }, side < 0.0)))
            }
            Lead::LineCircle => {
                let center = shifted(first, left, side * a.radius);
                let Some(helper) = touch(start, center, a.radius, side > 0.0) else {
                    return Err(cannot(
                        span,
                        "the start of the approach lies inside of its arc",
                        "start further away, or use a smaller R",
                    ));
                };
                let arc = arc::from_center(helper, first, center, side < 0.0, EXACT)
                    .map_err(|f| arc_fault(f, EXACT, FULL_CIRCLE, span))?;
                (helper, Some((arc, side < 0.0)))
            }
        };
        // The motions are emitted as if they were executed at the APPR block.
        let (work, base, location) = (self.position.work, self.position.base, self.location.clone());
        let later: Vec<(Command, ())> = self.queue.drain(a.at.min(self.queue.len())..).collect();
        let (feed, told, kept) = (self.technology.feed, self.technology.told_feed, self.modal.tangent);
        self.position.move_to(a.from, a.from_base);
        self.location = a.location.clone();
        let lead_feed = if a.lead == Lead::LineCircle { a.feed } else { a.feed_before.or(a.feed) };
        let rapid = a.rapid && a.lead != Lead::LineCircle;
        self.technology.feed = lead_feed;
        self.technology.told_feed = a.feed;
        self.lead_to(helper, None, rapid, span)?;
        if a.programmed >> n & 1 == 1 && a.to.get(n) != a.from.get(n) {
            self.lead_to(helper, a.to.get(n), rapid, span)?;
        }
        self.technology.feed = a.feed;
        self.lead_on(first, arc, span)?;
        // The commands queued since the APPR block come after these and count on its feed.
        self.tell_feed();
        self.technology.feed = feed;
        self.technology.told_feed = told;
        self.modal.tangent = kept;
        self.location = location;
        self.queue.extend(later);
        self.position.move_to(work, base);
        Ok(())
    }

    fn plane_goal(&self, p: Point, height: Option<f64>) -> Goal {
        let [u, v, n] = self.modal.plane_axes();
        let mut goal = Goal { end: self.position.work, programmed: 1 << u | 1 << v, tool_axis: None };
        goal.end.put(u, p[0]);
        goal.end.put(v, p[1]);
        if let Some(height) = height {
            goal.end.put(n, height);
            goal.programmed = 1 << n;
        }
        goal
    }

    /// Straight to a point of the plane, or to a height above it.
    fn lead_to(&mut self, p: Point, height: Option<f64>, rapid: bool, span: Span) -> Result<(), Fault> {
        let goal = self.plane_goal(p, height);
        self.straight(goal, rapid, span)
    }

    /// Line or arc in feed to a point of the plane.
    fn lead_on(&mut self, p: Point, arc: Option<(PlaneArc, bool)>, span: Span) -> Result<(), Fault> {
        let goal = self.plane_goal(p, None);
        match arc {
            None => self.straight(goal, false, span),
            Some((arc, clockwise)) => self.arc_to(goal, arc, clockwise, span),
        }
    }

    /// DEP: departure from the end of the contour. Compensation is off after it.
    pub(crate) fn depart(&mut self, lead: Lead, w: &Words, rapid: bool, span: Span) -> Result<(), Fault> {
        if rapid {
            return Err(Fault::new(codes::NO_FEED, span, "a departure needs a feed and has FMAX").help("write F"));
        }
        let [length, radius, angle] = self.lead_words(lead, w, span)?;
        if matches!(w.side, Some(RadiusSide::Left | RadiusSide::Right)) {
            return Err(Fault::new(codes::CONFLICT, span, "DEP does not take `RL` or `RR`: it ends the compensation")
                .help("remove it"));
        }
        let along = 1 << self.modal.plane_axes()[2];
        if lead != Lead::LineCircle && w.programmed & !along != 0 {
            return Err(Fault::new(
                codes::CONFLICT,
                span,
                "DEP LT, LN and CT take no coordinates in the working plane: their length or arc gives the end",
            )
            .help("remove the coordinates, or write DEP LCT"));
        }
        let side = Self::lead_side(lead, self.modal.departing.unwrap_or(RadiusSide::Off), span)?;
        let [u, v, n] = self.modal.plane_axes();
        let last = self.flat(span)?;
        let Some((t, left)) = self.modal.tangent.and_then(sides) else {
            return Err(Fault::new(codes::POSITION_UNKNOWN, span, "the departure has no contour element before it")
                .help("write DEP after the last element of the contour"));
        };
        let goal = self.lead_goal(w, span)?;
        match lead {
            Lead::LineTangent => self.lead_on(shifted(last, t, length), None, span)?,
            Lead::LineNormal => self.lead_on(shifted(last, left, side * length.abs()), None, span)?,
            Lead::Circle => {
                let side = side * radius.signum();
                let center = shifted(last, left, side * radius.abs());
                let end = arc::end_after(last, center, angle, side < 0.0);
                self.lead_on(end, Some((PlaneArc { center, radius: radius.abs(), sweep: angle }, side < 0.0)), span)?;
            }
            Lead::LineCircle => {
                let end = [goal.end.get(u).unwrap_or(last[0]), goal.end.get(v).unwrap_or(last[1])];
                let center = shifted(last, left, side * radius);
                // Backwards, the line comes from PN and runs around the other way.
                let Some(helper) = touch(end, center, radius, side < 0.0) else {
                    return Err(cannot(
                        span,
                        "the end of the departure lies inside of its arc",
                        "end further away, or use a smaller R",
                    ));
                };
                let arc = arc::from_center(last, helper, center, side < 0.0, EXACT)
                    .map_err(|f| arc_fault(f, EXACT, FULL_CIRCLE, span))?;
                self.lead_on(helper, Some((arc, side < 0.0)), span)?;
                self.compensation(RadiusSide::Off);
                self.lead_on(end, None, span)?;
            }
        }
        if w.programmed >> n & 1 == 1 {
            self.compensation(RadiusSide::Off);
            let at = self.flat(span)?;
            self.lead_to(at, goal.end.get(n), false, span)?;
        }
        self.compensation(RadiusSide::Off);
        Ok(())
    }
}

pub(crate) fn no_contour(span: Span) -> Fault {
    Fault::new(codes::STRUCTURE, span, "APPR is not followed by an element of the contour")
        .help("write L, C, CR or CP after APPR")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tangent_runs_on_around_the_circle() {
        for ccw in [true, false] {
            let (from, center, radius) = ([-30.0, 7.0], [5.0, -2.0], 6.0);
            let foot = touch(from, center, radius, ccw).unwrap();
            let line = [foot[0] - from[0], foot[1] - from[1]];
            let out = [foot[0] - center[0], foot[1] - center[1]];
            assert!((out[0].hypot(out[1]) - radius).abs() < 1e-12);
            assert!((line[0] * out[0] + line[1] * out[1]).abs() < 1e-9, "square");
            // Moving on along the line runs counter-clockwise when it passes with the center on its left.
            let turn = out[0] * line[1] - out[1] * line[0];
            assert_eq!(turn > 0.0, ccw);
        }
    }
}
