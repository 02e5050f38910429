//! Cycles 251 to 254: pockets and slots, from the inside out.
//!
//! Rings of the tool center are one overlap apart, counted from the wall. The innermost one leaves
//! no more than the radius of the tool inside it, or is the spine. Cycles 253 and 254 have no
//! overlap factor: one radius is used.

use super::{Values, plunge_slope};
use crate::channel::milling::{self, Job, Plan, Plunge};
use crate::channel::shape::{Leg, NO_WIDTH_MM, Pass, Place, Point, Shape};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::dialect::heidenhain::interpreter::Interpreter;
use crate::frame::sin_cos_degrees;

/// Parameters that the control writes, and what is taken for granted.
pub(super) fn words(number: u32) -> (&'static [u32], &'static str) {
    const CHOSEN: &str = "rings from the inside out, joined by straight lines; plunging with Q366 at 3 degrees (ANGLE of the tool \
                          table is not read); leads of at most the tool radius";
    match number {
        251 => {
            (&[215, 218, 219, 220, 368, 224, 367, 207, 351, 201, 202, 369, 206, 338, 200, 203, 204, 370, 366], CHOSEN)
        }
        252 => (&[215, 223, 368, 207, 351, 201, 202, 369, 206, 338, 200, 203, 204, 370, 366], CHOSEN),
        253 => (&[215, 218, 219, 368, 374, 367, 207, 351, 201, 202, 369, 206, 338, 200, 203, 204, 366], CHOSEN),
        _ => (
            &[
                215, 219, 368, 375, 367, 216, 217, 376, 248, 378, 377, 207, 351, 201, 202, 369, 206, 338, 200, 203,
                204, 366,
            ],
            CHOSEN,
        ),
    }
}

impl Interpreter {
    /// Where the pocket lies, its wall, and how often it is repeated by which angle (254).
    pub(super) fn pocket_shape(
        &self,
        number: u32,
        values: &Values,
        here: Point,
        span: Span,
    ) -> Result<(Place, Shape, u32, f64), Fault> {
        let len = |key: u32| {
            let value = self.mm(values, key, None, span)?;
            if value > 0.0 && value.is_finite() {
                return Ok(value);
            }
            Err(Fault::new(
                codes::BAD_VALUE,
                span,
                format!("Q{key} of cycle {number} must be above zero and is {value}"),
            )
            .help("write a length above zero"))
        };
        let position = |most: f64| {
            let value = self.cycle_number(values, 367, Some(0.0), span)?;
            if value.fract() == 0.0 && (0.0..=most).contains(&value) {
                return Ok(value as usize);
            }
            Err(Fault::new(codes::BAD_VALUE, span, format!("Q367 takes 0 to {most} and has {value}"))
                .help("it gives the tool position relative to the pocket"))
        };
        let number_of = |key: u32| self.cycle_number(values, key, None, span);
        match number {
            252 => {
                let r = 0.5 * len(223)?;
                Ok((Place::new(here, 0.0), Shape::Rounded { a: r, b: r, corner: r }, 0, 0.0))
            }
            251 => {
                let (a, b) = (0.5 * len(218)?, 0.5 * len(219)?);
                let corner = self.mm(values, 220, Some(0.0), span)?.abs();
                let angle = number_of(224)?;
                // Tool position: the middle, or one of the four corners, counter-clockwise from the
                // lower left.
                let from = [[0.0, 0.0], [-a, -b], [a, -b], [a, b], [-a, b]][position(4.0)?];
                let place = about(here, from, angle);
                Ok((place, Shape::Rounded { a, b, corner: corner.min(a).min(b) }, 0, 0.0))
            }
            253 => {
                let (a, b) = (0.5 * len(218)?, 0.5 * len(219)?);
                if a < b {
                    return Err(Fault::new(codes::BAD_VALUE, span, "the slot Q218 is shorter than its width Q219")
                        .help("exchange both and turn the slot with Q374, or mill a pocket"));
                }
                let along = [0.0, -a, -(a - b), a - b, a][position(4.0)?];
                let place = about(here, [along, 0.0], number_of(374)?);
                Ok((place, Shape::Rounded { a, b, corner: b }, 0, 0.0))
            }
            _ => {
                let (half, pitch) = (0.5 * len(219)?, 0.5 * len(375)?);
                let (from, through) = (number_of(376)?, number_of(248)?);
                if !(through > 0.0 && through <= 360.0) {
                    return Err(Fault::new(codes::BAD_VALUE, span, format!("the opening angle Q248 is {through}"))
                        .help("write an angle above 0 and up to 360"));
                }
                if half >= pitch {
                    return Err(Fault::new(codes::BAD_VALUE, span, "the slot Q219 is wider than its circle Q375")
                        .help("mill a pocket"));
                }
                let unit = self.modal.unit();
                let origin = match position(3.0)? {
                    0 => [number_of(216)? * unit, number_of(217)? * unit],
                    at => {
                        let (s, c) = sin_cos_degrees(from + [0.0, 0.5, 1.0][at - 1] * through);
                        [here[0] - pitch * c, here[1] - pitch * s]
                    }
                };
                let count = number_of(377)?;
                if !(1.0..=10_000.0).contains(&count) || count.fract() != 0.0 {
                    return Err(Fault::new(codes::BAD_VALUE, span, format!("Q377 slots: {count}"))
                        .help("write a whole number from 1"));
                }
                let shape = Shape::Curved { pitch, from, through, half };
                Ok((Place::new(origin, 0.0), shape, count as u32 - 1, number_of(378)?))
            }
        }
    }

    pub(super) fn pocket_plans(
        &self,
        number: u32,
        values: &Values,
        job: &Job,
        here: Point,
        span: Span,
    ) -> Result<Vec<Plan>, Fault> {
        let (place, shape, repeats, step) = self.pocket_shape(number, values, here, span)?;
        // Corners smaller than the tool get the radius of the tool.
        let shape = match shape {
            Shape::Rounded { a, b, corner } => Shape::Rounded { a, b, corner: corner.max(job.radius) },
            other => other,
        };
        let overlap = if matches!(number, 251 | 252) { self.overlap(values, job.radius, span)? } else { job.radius };
        let rings = |allowance: f64| -> Result<Vec<Pass>, Fault> {
            milling::rings(shape, job.radius, allowance, overlap, job.climb).ok_or_else(|| {
                let message = format!(
                    "a tool of radius {} mm does not fit into cycle {number}: half its width less the allowance is {:.3} mm",
                    job.radius,
                    shape.half_width() - allowance
                );
                Fault::new(codes::COMPENSATION, span, message).help("use a smaller tool")
            })
        };
        let entry = match shape {
            Shape::Rounded { a, b, .. } if number == 253 => [-(a - b), 0.0],
            Shape::Rounded { .. } => [0.0; 2],
            Shape::Curved { pitch, from, .. } => {
                let (s, c) = sin_cos_degrees(from);
                [pitch * c, pitch * s]
            }
        };
        let room = (shape.half_width() - job.radius - job.side).max(0.0);
        let stroke = match shape {
            Shape::Rounded { a, b, .. } if number == 253 => Leg::Line([a - b, 0.0]),
            Shape::Rounded { a, b, .. } if a >= b => {
                Leg::Line([(a - job.radius - job.side).clamp(0.0, 4.0 * job.radius), 0.0])
            }
            Shape::Rounded { b, .. } => Leg::Line([0.0, (b - job.radius - job.side).clamp(0.0, 4.0 * job.radius)]),
            Shape::Curved { pitch, from, through, .. } => {
                let (s, c) = sin_cos_degrees(from + through);
                Leg::Arc { to: [pitch * c, pitch * s], center: [0.0; 2], clockwise: false }
            }
        };
        let plunge = match (self.cycle_number(values, 366, Some(0.0), span)?, number) {
            (0.0, _) => Plunge::Vertical,
            (1.0, 251 | 252) if room > NO_WIDTH_MM => {
                Plunge::Helix { radius: room.min(job.radius), slope: plunge_slope() }
            }
            (1.0 | 2.0, 252) => Plunge::Vertical,
            (1.0 | 2.0, _) => Plunge::Strokes { leg: stroke, slope: plunge_slope() },
            (other, _) => {
                return Err(Fault::new(codes::BAD_VALUE, span, format!("Q366 takes 0, 1 or 2 and has {other}"))
                    .help("0 plunges vertically, 1 on a helix, 2 to and fro"));
            }
        };
        let finished = rings(0.0)?;
        let rough = rings(job.side)?;
        let width = shape.half_width() - job.radius;
        let ring = shape.ring(job.radius);
        let ring = if job.climb { ring } else { ring.reversed() };
        let wall =
            if width > NO_WIDTH_MM { ring.with_leads(job.radius.min(width), false, job.climb, true) } else { ring };
        let plan = |place| Plan {
            place,
            entry,
            plunge,
            rough: rough.clone(),
            wall: wall.clone(),
            floor: finished.clone(),
            returns: true,
        };
        Ok((0..=repeats).map(|i| plan(place.turned(f64::from(i) * step))).collect())
    }
}

/// The place of a shape, turned by an angle about one of its points, which is at the tool position.
pub(super) fn about(here: Point, point: Point, degrees: f64) -> Place {
    let turned = Place::new([0.0; 2], degrees).at(point);
    Place::new([here[0] - turned[0], here[1] - turned[1]], degrees)
}
