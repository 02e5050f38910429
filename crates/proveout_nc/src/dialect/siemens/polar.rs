//! Polar coordinates: G110, G111, G112, AP=, RP=; a straight line by its angle: ANG=. Two lines by their
//! angles are in [`super::two_lines`].
//!
//! After Siemens, *NC programming, Fundamentals*, "Travel commands with polar coordinates": the angle counts
//! from the first axis of the working plane, the radius is modal, the pole is the zero of the work
//! coordinates before it is programmed, and a circle without center and radius runs about the pole. "Contour
//! definitions": the angle of a straight line counts from the first axis of the plane too, and one coordinate
//! of its end gives the other.

use super::modal::Interpolation;
use super::pending::{Coordinate, Pending, Reference};
use super::run_state::Interpreter;
use crate::AXIS_LETTERS;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::sin_cos_degrees;

/// Sine or cosine below which a line is taken to run along an axis.
const ALONG_AXIS: f64 = 1e-9;

impl Interpreter {
    /// Replaces ANG= by the coordinate of the plane that the block leaves out; keeps the first of two lines.
    pub(crate) fn resolve_angle(&mut self, p: &mut Pending, angle: f64, span: Span) -> Result<(), Fault> {
        let [u, v, _] = self.modal.plane_axes();
        if !matches!(self.modal.interpolation, Interpolation::Linear | Interpolation::Rapid) || p.machine {
            return Err(Fault::new(codes::CONFLICT, span, "ANG= is the angle of a straight line in work coordinates")
                .help("write G1, or remove ANG="));
        }
        let (given, other) = match [u, v].map(|axis| p.axes[axis].is_some()) {
            [true, false] => (u, v),
            [false, true] => (v, u),
            [true, true] => {
                // The end of the second of two lines, after the first one failed.
                if self.own.two_lines_torn {
                    return Ok(());
                }
                return Err(Fault::new(
                    codes::CONFLICT,
                    span,
                    "ANG= with both coordinates of the end is the second of two lines, and the block before has no first one",
                )
                .help("write the first line as ANG= alone, or leave one of the coordinates out"));
            }
            [false, false] => return self.hold_first_line(p, angle, span),
        };
        let length = self.modal.units.length();
        let end = self.targets(p, span)?.get(given).unwrap_or(0.0);
        let from = [self.known(u, span)?, self.known(v, span)?];
        let (s, c) = sin_cos_degrees(angle);
        let (along, across, start, side) = if given == u { (c, s, from[0], from[1]) } else { (s, c, from[1], from[0]) };
        let letter = AXIS_LETTERS[given];
        if along.abs() < ALONG_AXIS || !angle.is_finite() {
            let message = format!("the line under ANG={angle} does not move {letter}, which gives its end");
            return Err(
                Fault::new(codes::BAD_VALUE, span, message).help(format!("give its end with {}", AXIS_LETTERS[other]))
            );
        }
        let way = (end - start) / along;
        if way < 0.0 {
            let message = format!("the line under ANG={angle} leads away from {letter}{}", end / length);
            return Err(Fault::new(codes::BAD_VALUE, span, message)
                .help("check the angle: it counts counter-clockwise from the first axis of the plane"));
        }
        let value = (side + way * across) / length;
        p.axes[other] = Some(Coordinate { value, reference: Reference::Absolute });
        p.programmed |= 1 << other;
        Ok(())
    }

    /// G110 (from the position), G111 (work coordinates), G112 (from the last pole).
    pub(crate) fn set_pole(&mut self, code: u32, p: &Pending, span: Span) -> Result<(), Fault> {
        let [u, v, _] = self.modal.plane_axes();
        if p.programmed & !(1 << u | 1 << v) != 0 {
            return Err(Fault::new(codes::CONFLICT, span, format!("the pole of G{code} lies in the working plane"))
                .help("write its two coordinates in the plane"));
        }
        let length = self.modal.units.length();
        let from = match code {
            110 => {
                let at = |axis: usize| {
                    self.position.work.get(axis).ok_or_else(|| {
                        Fault::new(codes::POSITION_UNKNOWN, span, "G110 counts from a position that is not known")
                            .help("use G111")
                    })
                };
                [at(u)?, at(v)?]
            }
            112 => self.modal.pole,
            _ => [0.0; 2],
        };
        self.modal.pole = match (p.polar_angle, p.polar_radius) {
            (Some(angle), Some(radius)) => {
                let (s, c) = sin_cos_degrees(angle.value);
                [from[0] + radius.value * length * c, from[1] + radius.value * length * s]
            }
            (None, None) => {
                let by = |axis: usize| p.axes[axis].map_or(0.0, |c| c.value * length);
                [from[0] + by(u), from[1] + by(v)]
            }
            _ => {
                return Err(Fault::new(codes::MISSING_VALUE, span, "the pole has an angle or a radius and not both")
                    .help("write AP= and RP="));
            }
        };
        Ok(())
    }

    /// Replaces AP= and RP= of a motion by the coordinates they define.
    pub(crate) fn resolve_polar(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let [u, v, _] = self.modal.plane_axes();
        if p.programmed & (1 << u | 1 << v) != 0 {
            return Err(Fault::new(codes::CONFLICT, span, "polar coordinates and axes of the plane in one block")
                .help("keep one of the two"));
        }
        let length = self.modal.units.length();
        let missing = |word: &str| {
            Fault::new(codes::MISSING_VALUE, span, format!("the polar coordinates have no {word}"))
                .help(format!("write {word}"))
        };
        let take = |given: Option<Coordinate>, before: Option<f64>, factor: f64, word: &str| match given {
            None => before.ok_or_else(|| missing(word)),
            Some(Coordinate { value, reference: Reference::Incremental }) => {
                before.map(|b| b + value * factor).ok_or_else(|| missing(word))
            }
            Some(Coordinate { value, .. }) => Ok(value * factor),
        };
        let radius = take(p.polar_radius, self.modal.polar_radius, length, "RP=")?;
        let angle = take(p.polar_angle, self.modal.polar_angle, 1.0, "AP=")?;
        (self.modal.polar_radius, self.modal.polar_angle) = (Some(radius), Some(angle));
        let (s, c) = sin_cos_degrees(angle);
        let pole = self.modal.pole;
        let absolute = |value: f64| Some(Coordinate { value: value / length, reference: Reference::Absolute });
        p.axes[u] = absolute(pole[0] + radius * c);
        p.axes[v] = absolute(pole[1] + radius * s);
        p.programmed |= 1 << u | 1 << v;
        let circle = matches!(self.modal.interpolation, Interpolation::Clockwise | Interpolation::CounterClockwise);
        if circle && !p.has_center() && p.radius.is_none() && p.opening.is_none() {
            p.center[u] = absolute(pole[0]);
            p.center[v] = absolute(pole[1]);
        }
        Ok(())
    }
}
