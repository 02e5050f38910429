//! Circular motions: G2, G3, CIP, CT.

use std::f64::consts::TAU;

use super::modal::Interpolation;
use super::pending::{Pending, Reference};
use super::run_state::Interpreter;
use crate::arc::{self, PlaneArc};
use crate::channel::arc_fault;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame;
use crate::{AxisValues, Motion};

/// Sine of the angle between the ways to intermediate point and end below which they lie on one line.
const ON_LINE: f64 = 1e-9;

impl Interpreter {
    pub(super) fn arc(&mut self, p: &Pending, mut end: AxisValues, span: Span) -> Result<(), Fault> {
        let [u, v, w] = self.modal.plane_axes();
        let in_space = self.modal.interpolation == Interpolation::Intermediate;
        let start =
            if in_space { self.start_point("the arc", span)? } else { self.arc_start("the arc", [u, v, w], span)? };
        if in_space {
            return self.intermediate_arc(p, start, end, span);
        }
        let flat = |q: [f64; 3]| [q[u], q[v]];
        let end_point: [f64; 3] = std::array::from_fn(|axis| end.get(axis).unwrap_or(start[axis]));
        let mut programmed = p.programmed;
        let mut clockwise = self.modal.interpolation == Interpolation::Clockwise;
        let tolerance = self.settings.arc_limit();
        let result = if self.modal.interpolation == Interpolation::Tangential {
            let Some(tangent) = self.own.tangent else {
                return Err(Fault::new(
                    codes::POSITION_UNKNOWN,
                    span,
                    "CT has no motion before it to be tangential to",
                )
                .help("program a motion in the same frame before it"));
            };
            let Some((arc, turned)) = arc::from_tangent(flat(start), flat(end_point), flat(tangent)) else {
                // The end lies straight ahead: the circle has degenerated to a line.
                let motion = self.complete(p, end, programmed, span)?;
                self.go(motion, false);
                return Ok(());
            };
            clockwise = turned;
            Ok(arc)
        } else if let Some(radius) = p.radius {
            if p.has_center() || p.opening.is_some() {
                return Err(Fault::new(codes::CONFLICT, span, "CR= together with a center or an opening angle")
                    .help("keep one"));
            }
            arc::from_radius(flat(start), flat(end_point), radius * self.modal.units.length(), clockwise, tolerance)
        } else if let Some(opening) = p.opening {
            self.in_plane(p, w, span)?;
            let angle = opening.to_radians();
            if !(angle > 0.0 && angle < TAU) {
                let message = format!("AR= must lie between 0 and 360 degrees and is {opening}");
                return Err(Fault::new(codes::BAD_VALUE, span, message).help("program a full circle with I J K"));
            }
            if p.has_center() {
                let center = flat(self.arc_center(p, start, span)?);
                let turned = arc::end_after(flat(start), center, angle, clockwise);
                end.put(u, turned[0]);
                end.put(v, turned[1]);
                programmed |= 1 << u | 1 << v;
                arc::from_center(flat(start), turned, center, clockwise, tolerance)
            } else {
                arc::from_angle(flat(start), flat(end_point), angle, clockwise)
            }
        } else if p.has_center() {
            self.in_plane(p, w, span)?;
            let center = flat(self.arc_center(p, start, span)?);
            arc::from_center(flat(start), flat(end_point), center, clockwise, tolerance)
        } else {
            return Err(Fault::new(codes::ARC_GEOMETRY, span, "the arc has no center and no radius")
                .help("write I J K, CR= or AR="));
        };
        let mut arc = result.map_err(|fault| arc_fault(fault, tolerance, "program a full circle with I J K", span))?;
        arc.sweep += TAU * self.extra_turns(p, span)?;
        let mut center = start;
        center[u] = arc.center[0];
        center[v] = arc.center[1];
        let mut normal = [0.0; 3];
        normal[w] = if clockwise { -1.0 } else { 1.0 };
        let motion = self.complete(p, end, programmed, span)?;
        self.go_around(motion, [center, normal], &arc, span)
    }

    /// The center is one of the working plane, square to axis `w`.
    fn in_plane(&self, p: &Pending, w: usize, span: Span) -> Result<(), Fault> {
        if p.center[w].is_none() {
            return Ok(());
        }
        let letter = ['I', 'J', 'K'][w];
        let message = format!("`{letter}` does not lie in the working plane G{}", 19 - w);
        Err(Fault::new(codes::ARC_GEOMETRY, span, message).help("choose the plane with G17, G18 or G19"))
    }

    pub(super) fn extra_turns(&self, p: &Pending, span: Span) -> Result<f64, Fault> {
        match p.turns {
            None => Ok(0.0),
            Some(turns) if turns.fract() == 0.0 && (0.0..=999.0).contains(&turns) => Ok(turns),
            Some(turns) => {
                Err(Fault::new(codes::BAD_VALUE, span, format!("TURN= takes an integer from 0 to 999 and has {turns}"))
                    .help("write the number of additional full turns"))
            }
        }
    }

    /// I J K: from the start, or absolute with `AC()`.
    pub(super) fn arc_center(&self, p: &Pending, start: [f64; 3], span: Span) -> Result<[f64; 3], Fault> {
        let mut center = start;
        for (axis, coordinate) in p.center.iter().enumerate() {
            let Some(coordinate) = coordinate else { continue };
            let value = coordinate.value * self.modal.units.length();
            center[axis] = match coordinate.reference {
                Reference::Absolute => value,
                Reference::Modal | Reference::Incremental => start[axis] + value,
                _ => {
                    return Err(
                        Fault::new(codes::BAD_VALUE, span, "I, J and K take AC() or IC()").help("write I=AC(10)")
                    );
                }
            };
        }
        Ok(center)
    }

    /// CIP: the circle through start, intermediate point and end, anywhere in space.
    pub(super) fn intermediate_arc(
        &mut self,
        p: &Pending,
        start: [f64; 3],
        end: AxisValues,
        span: Span,
    ) -> Result<(), Fault> {
        if p.intermediate.iter().all(Option::is_none) {
            return Err(
                Fault::new(codes::ARC_GEOMETRY, span, "CIP has no intermediate point").help("write I1= J1= K1=")
            );
        }
        let mut middle = start;
        for (axis, coordinate) in p.intermediate.iter().enumerate() {
            let Some(coordinate) = coordinate else { continue };
            let value = coordinate.value * self.modal.units.length();
            let incremental = match coordinate.reference {
                Reference::Modal => self.modal.incremental,
                reference => reference == Reference::Incremental,
            };
            middle[axis] = if incremental { start[axis] + value } else { value };
        }
        let end_point = end.xyz().unwrap_or(start);
        let (a, b) = (frame::sub(middle, start), frame::sub(end_point, start));
        let across = frame::cross(a, b);
        let span_area = frame::norm(a) * frame::norm(b);
        let Some(normal) = frame::unit(across).filter(|_| frame::norm(across) > ON_LINE * span_area) else {
            return Err(Fault::new(codes::ARC_GEOMETRY, span, "start, intermediate point and end lie on one line")
                .help("choose an intermediate point off the line, or use G1"));
        };
        // Circumcenter of the triangle start, middle, end (standard vector form).
        let (aa, bb) = (frame::dot(a, a), frame::dot(b, b));
        let weighted: [f64; 3] = std::array::from_fn(|i| bb * a[i] - aa * b[i]);
        let offset = frame::cross(across, weighted).map(|v| v / (2.0 * frame::dot(across, across)));
        let center = frame::add_scaled(start, offset, 1.0);
        let (from, to) = (frame::sub(start, center), frame::sub(end_point, center));
        let angle = frame::dot(normal, frame::cross(from, to)).atan2(frame::dot(from, to));
        let sweep = if angle > 0.0 { angle } else { angle + TAU } + TAU * self.extra_turns(p, span)?;
        let plane_arc = PlaneArc { center: [0.0; 2], radius: frame::norm(from), sweep };
        let motion = self.complete(p, end, p.programmed, span)?;
        self.go_around(motion, [center, normal], &plane_arc, span)
    }

    /// Emits the arc and keeps the direction at its end.
    fn go_around(&mut self, motion: Motion, circle: [[f64; 3]; 2], arc: &PlaneArc, span: Span) -> Result<(), Fault> {
        let [center, normal] = circle;
        let end = motion.end.xyz().unwrap_or(center);
        self.go_arc(motion, center, normal, arc, span)?;
        self.own.tangent = frame::unit(frame::cross(normal, frame::sub(end, center)));
        Ok(())
    }
}
