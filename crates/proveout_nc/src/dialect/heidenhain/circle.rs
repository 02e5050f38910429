//! Circles about a pole, by radius, by tangent; polar coordinates and helices.
//!
//! Words after HEIDENHAIN, *TNC 640 Klartext programming*, "Path functions": CC is modal; CR with R above
//! zero runs at most half a turn, below zero more; DR+ is counter-clockwise seen against the tool axis; the
//! polar angle counts from the first axis of the working plane; CP with IPA runs through that angle, several
//! turns too. "Circular motion in another plane": CC with two other axes than those of the working plane;
//! angles count from Y in the plane Y Z and from Z in the plane Z X ("Polar coordinates: defining pole and
//! angle reference axis").

use std::f64::consts::TAU;

use super::motion::{Goal, LINEAR};
use super::run_state::{Heidenhain, Interpreter};
use super::words::{Coordinate, RadiusSide, Words};
use crate::arc::{self, ArcFault, PlaneArc};
use crate::channel::{Language, arc_fault};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{ArcMotion, Op};

/// How a full circle is written.
pub(crate) const FULL_CIRCLE: &str = "program a full circle with CC and C";
/// An angle below this is a full circle, degree: rounding of the start.
const NO_TURN_DEG: f64 = 1e-7;
/// Most turns of an arc.
const MOST_TURNS: f64 = 1e5;

/// A pole with the plane of its circles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pole {
    /// In the axes of the plane, mm.
    pub(crate) at: [f64; 2],
    /// Index of the axis square to the plane.
    pub(crate) normal: usize,
}

/// First and second axis of a plane and the axis square to it, right-handed: X Y, Y Z, Z X.
pub(crate) fn plane_of(normal: usize) -> [usize; 3] {
    [(normal + 1) % 3, (normal + 2) % 3, normal]
}

impl Interpreter {
    /// CC: a new pole. An axis that is not written keeps its value; without any axis the pole is
    /// the position. Two axes of another plane than the working plane put the circles into that
    /// plane.
    pub(crate) fn pole_block(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        if !w.functions.is_empty() || w.feed.is_some() {
            return Err(Fault::new(codes::CONFLICT, span, "CC takes coordinates only")
                .help("write the other words in another block"));
        }
        let normal = self.pole_normal(w, span)?;
        let old = self.modal.pole.filter(|pole| pole.normal == normal && w.programmed != 0);
        let axes = plane_of(normal);
        let mut at = [0.0; 2];
        for (i, slot) in at.iter_mut().enumerate() {
            let axis = axes[i];
            *slot = match (w.axes[axis], old) {
                (Some(c), _) if self.is_incremental(c.reference) => {
                    self.known(axis, span)? + self.coordinate(axis, self.variables.value(c.value, span)?)
                }
                (Some(c), _) => self.coordinate(axis, self.variables.value(c.value, span)?),
                (None, Some(old)) => old.at[i],
                (None, None) => self.known(axis, span)?,
            };
        }
        self.modal.pole = Some(Pole { at, normal });
        Ok(())
    }

    /// Axis square to the plane that the words of CC are in.
    fn pole_normal(&self, w: &Words, span: Span) -> Result<usize, Fault> {
        let work = self.modal.normal;
        let named = w.programmed;
        let lies_in = |normal: usize| named & !(LINEAR & !(1 << normal)) == 0;
        if named & LINEAR == named && named.count_ones() == 2 {
            return Ok((LINEAR & !named).trailing_zeros() as usize);
        }
        // A single axis changes the pole in force.
        match self.modal.pole {
            Some(pole) if named != 0 && lies_in(pole.normal) => Ok(pole.normal),
            _ if lies_in(work) => Ok(work),
            _ => Err(Fault::new(codes::ARC_GEOMETRY, span, "the words of CC do not belong to one plane")
                .help("write the two axes of the plane of the circle, such as CC X+10 Z-5")),
        }
    }

    fn pole(&self, span: Span) -> Result<Pole, Fault> {
        self.modal.pole.ok_or_else(|| {
            Fault::new(codes::ARC_GEOMETRY, span, "no pole is defined").help("write CC X+0 Y+0 before it")
        })
    }

    pub(crate) fn flat(&self, span: Span) -> Result<[f64; 2], Fault> {
        self.flat_in(self.modal.normal, span)
    }

    /// The position in the plane square to an axis.
    fn flat_in(&self, normal: usize, span: Span) -> Result<[f64; 2], Fault> {
        let [u, v, _] = plane_of(normal);
        Ok([self.known(u, span)?, self.known(v, span)?])
    }

    fn direction(w: &Words, span: Span) -> Result<bool, Fault> {
        w.clockwise.ok_or_else(|| {
            Fault::new(codes::ARC_GEOMETRY, span, "the arc has no direction of rotation").help("write DR+ or DR-")
        })
    }

    /// C: arc about the pole to a point.
    pub(crate) fn arc_block(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        let pole = self.pole(span)?;
        let [u, v, _] = plane_of(pole.normal);
        if w.programmed & LINEAR & !(1 << u | 1 << v) != 0 {
            let letters = [u, v].map(|axis| crate::AXIS_LETTERS[axis]);
            return Err(super::lexer::refused(
                &format!("C with an axis outside of the plane {} {} of CC", letters[0], letters[1]),
                span,
                "write a helix with CP, a circle in another plane with the two axes of that plane in CC and C",
            ));
        }
        let clockwise = Self::direction(w, span)?;
        let start = self.flat_in(pole.normal, span)?;
        let goal = self.goal(w, span)?;
        let end = [goal.end.get(u).unwrap_or(start[0]), goal.end.get(v).unwrap_or(start[1])];
        let tolerance = self.settings.arc_limit();
        let arc = arc::from_center(start, end, pole.at, clockwise, tolerance)
            .map_err(|f| arc_fault(f, tolerance, FULL_CIRCLE, span))?;
        self.arc_in(pole.normal, goal, arc, clockwise, span)
    }

    /// CR: arc of a radius to a point.
    pub(crate) fn radius_arc(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        let [u, v, _] = self.modal.plane_axes();
        let clockwise = Self::direction(w, span)?;
        let Some(radius) = w.radius else {
            return Err(Fault::new(codes::ARC_GEOMETRY, span, "CR has no radius").help("write R+20"));
        };
        let radius = self.variables.value(radius, span)? * self.modal.unit();
        let start = self.flat(span)?;
        let goal = self.goal(w, span)?;
        let end = [goal.end.get(u).unwrap_or(start[0]), goal.end.get(v).unwrap_or(start[1])];
        let tolerance = self.settings.arc_limit();
        let arc = arc::from_radius(start, end, radius, clockwise, tolerance)
            .map_err(|f| arc_fault(f, tolerance, FULL_CIRCLE, span))?;
        self.arc_to(goal, arc, clockwise, span)
    }

    /// CT: arc that goes on tangentially from the element before.
    pub(crate) fn tangent_arc(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        let goal = self.goal(w, span)?;
        self.tangent_to(goal, span)
    }

    pub(crate) fn tangent_to(&mut self, goal: Goal, span: Span) -> Result<(), Fault> {
        let [u, v, _] = self.modal.plane_axes();
        let start = self.flat(span)?;
        let Some(tangent) = self.modal.tangent else {
            return Err(Fault::new(
                codes::POSITION_UNKNOWN,
                span,
                "the arc has no contour element before it to be tangential to",
            )
            .help("program a line or an arc in the working plane before it"));
        };
        let end = [goal.end.get(u).unwrap_or(start[0]), goal.end.get(v).unwrap_or(start[1])];
        match arc::from_tangent(start, end, tangent) {
            Some((arc, clockwise)) => self.arc_to(goal, arc, clockwise, span),
            // The end lies straight ahead: the circle has become a line.
            None if end != start => self.straight(goal, false, span),
            None => {
                Err(Fault::new(codes::ARC_GEOMETRY, span, "start and end of the tangential arc are the same point")
                    .help("program another end point"))
            }
        }
    }

    /// Radius and angle (degrees) of the position about the pole.
    fn polar_now(&self, pole: Pole, span: Span) -> Result<(f64, f64), Fault> {
        let [x, y] = self.flat_in(pole.normal, span)?;
        let (dx, dy) = (x - pole.at[0], y - pole.at[1]);
        Ok((dx.hypot(dy), dy.atan2(dx).to_degrees()))
    }

    fn polar_value(
        &self,
        c: Coordinate,
        now: impl FnOnce() -> Result<f64, Fault>,
        factor: f64,
        span: Span,
    ) -> Result<f64, Fault> {
        let value = self.variables.value(c.value, span)? * factor;
        Ok(if self.is_incremental(c.reference) { now()? + value } else { value })
    }

    /// The goal of a polar block: the point in the plane replaces the two axes.
    fn polar_goal(&mut self, w: &Words, radius: f64, degrees: f64, pole: Pole, span: Span) -> Result<Goal, Fault> {
        let [u, v, _] = plane_of(pole.normal);
        if w.programmed >> u & 1 == 1 || w.programmed >> v & 1 == 1 {
            return Err(Fault::new(codes::CONFLICT, span, "polar and Cartesian coordinates of the plane in one block")
                .help("write PR and PA, or L, C with the two axes"));
        }
        let mut goal = self.goal(w, span)?;
        let (s, c) = crate::frame::sin_cos_degrees(degrees);
        let point = [pole.at[0] + radius * c, pole.at[1] + radius * s];
        if !point.iter().all(|p| p.is_finite()) {
            return Err(
                Fault::new(codes::BAD_VALUE, span, "the polar coordinates are not finite").help("check PR and PA")
            );
        }
        goal.end.put(u, point[0]);
        goal.end.put(v, point[1]);
        goal.programmed |= 1 << u | 1 << v;
        Ok(goal)
    }

    /// PR and PA of a line or tangential arc; what is not written stays.
    pub(super) fn polar_point(&mut self, w: &Words, span: Span) -> Result<Goal, Fault> {
        let pole = self.pole(span)?;
        let unit = self.modal.unit();
        let radius = match w.polar_radius {
            Some(c) => self.polar_value(c, || self.polar_now(pole, span).map(|p| p.0), unit, span)?,
            None => self.polar_now(pole, span)?.0,
        };
        let degrees = match w.polar_angle {
            Some(c) => self.polar_value(c, || self.polar_now(pole, span).map(|p| p.1), 1.0, span)?,
            None => self.polar_now(pole, span)?.1,
        };
        self.polar_goal(w, radius, degrees, pole, span)
    }

    pub(crate) fn polar_line(&mut self, w: &Words, rapid: bool, span: Span) -> Result<(), Fault> {
        let goal = self.polar_point(w, span)?;
        self.straight(goal, rapid, span)
    }

    pub(crate) fn polar_tangent(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        let goal = self.polar_point(w, span)?;
        self.tangent_to(goal, span)
    }

    /// CP: arc or helix about the pole through an angle.
    pub(crate) fn polar_arc(&mut self, w: &Words, span: Span) -> Result<(), Fault> {
        let pole = self.pole(span)?;
        let (radius, now) = self.polar_now(pole, span)?;
        let Some(angle) = w.polar_angle else {
            return Err(Fault::new(codes::ARC_GEOMETRY, span, "CP has no polar angle").help("write PA or IPA"));
        };
        if w.polar_radius.is_some() {
            return Err(
                Fault::new(codes::CONFLICT, span, "CP takes its radius from the position before it").help("remove PR")
            );
        }
        if radius < arc::SAME_POINT_MM {
            return Err(arc_fault(ArcFault::NoRadius, self.settings.arc_limit(), FULL_CIRCLE, span));
        }
        let value = self.variables.value(angle.value, span)?;
        let incremental = self.is_incremental(angle.reference);
        let (clockwise, turn) = if incremental {
            let clockwise = w.clockwise.unwrap_or(value < 0.0);
            if value != 0.0 && clockwise != (value < 0.0) {
                return Err(Fault::new(
                    codes::CONFLICT,
                    span,
                    format!("IPA{value:+} and the direction DR contradict each other"),
                )
                .help("give DR and IPA the same sign"));
            }
            (clockwise, value.abs())
        } else {
            let clockwise = Self::direction(w, span)?;
            let turn = if clockwise { now - value } else { value - now }.rem_euclid(360.0);
            // Rounding of the start must not turn a full circle into none.
            (clockwise, if turn < NO_TURN_DEG { turn + 360.0 } else { turn })
        };
        if !(turn > 0.0 && turn.to_radians() / TAU <= MOST_TURNS) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("the angle of the arc is {turn} degrees"))
                .help("write an angle above zero and below 100 000 turns"));
        }
        let end = if clockwise { now - turn } else { now + turn };
        // A whole number of turns ends where it began, to the bit.
        let goal = if turn % 360.0 == 0.0 {
            let mut goal = self.goal(w, span)?;
            let [u, v, _] = plane_of(pole.normal);
            goal.programmed |= 1 << u | 1 << v;
            goal
        } else {
            let degrees = if incremental { end } else { value };
            self.polar_goal(w, radius, degrees, pole, span)?
        };
        let arc = PlaneArc { center: pole.at, radius, sweep: turn.to_radians() };
        self.arc_in(pole.normal, goal, arc, clockwise, span)
    }

    /// Emits an arc in the working plane.
    pub(crate) fn arc_to(&mut self, goal: Goal, arc: PlaneArc, clockwise: bool, span: Span) -> Result<(), Fault> {
        self.arc_in(self.modal.normal, goal, arc, clockwise, span)
    }

    /// Emits an arc in the plane square to an axis.
    fn arc_in(&mut self, normal: usize, goal: Goal, arc: PlaneArc, clockwise: bool, span: Span) -> Result<(), Fault> {
        self.need_feed(span)?;
        if normal != self.modal.normal {
            self.needs_no_plane(span)?;
        }
        if self.modal.approach.is_some() {
            let from = self.flat(span)?;
            let out = [from[0] - arc.center[0], from[1] - arc.center[1]];
            self.finish_approach(if clockwise { [out[1], -out[0]] } else { [-out[1], out[0]] }, span)?;
        }
        let op = self.arc_motion(normal, goal, arc, clockwise, span)?;
        let op = if self.modal.corner.is_some() { self.corner_to_arc(op, span)? } else { op };
        let [u, v, _] = plane_of(normal);
        let end =
            [op.motion.end.get(u).unwrap_or(0.0) - op.center[u], op.motion.end.get(v).unwrap_or(0.0) - op.center[v]];
        self.modal.tangent =
            (normal == self.modal.normal).then_some(if clockwise { [end[1], -end[0]] } else { [-end[1], end[0]] });
        self.before_feed(&op.motion);
        self.position.move_to(op.motion.end, op.motion.end_base);
        Heidenhain::moving(self);
        self.emit(Op::Arc(op));
        Ok(())
    }

    /// An arc outside the working plane cannot be an element after RND, CHF or APPR, and cannot be
    /// compensated.
    fn needs_no_plane(&self, span: Span) -> Result<(), Fault> {
        if self.modal.corner.is_none()
            && self.modal.approach.is_none()
            && self.modal.side.unwrap_or(RadiusSide::Off) == RadiusSide::Off
        {
            return Ok(());
        }
        Err(Fault::new(
            codes::ARC_GEOMETRY,
            span,
            "a circle outside of the working plane under RL or RR, or after RND, CHF or APPR",
        )
        .help("write R0 before it, and its lead-in as a block of its own"))
    }

    /// An arc in the plane square to an axis as a command.
    pub(crate) fn arc_motion(
        &self,
        normal: usize,
        goal: Goal,
        arc: PlaneArc,
        clockwise: bool,
        span: Span,
    ) -> Result<ArcMotion, Fault> {
        let [u, v, n] = plane_of(normal);
        let start = self.arc_start("the arc", [u, v, n], span)?;
        let mut center = start;
        center[u] = arc.center[0];
        center[v] = arc.center[1];
        let mut axis = [0.0; 3];
        axis[n] = if clockwise { -1.0 } else { 1.0 };
        self.arc_about(center, axis, &arc, span, |channel| channel.complete(goal, span))
    }
}
