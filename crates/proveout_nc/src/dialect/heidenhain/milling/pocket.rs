//! Cycles 251 to 254: pockets and slots, from the inside out.
//!
//! Rings of the tool center are one overlap apart, counted from the wall. The innermost one leaves
//! no more than the radius of the tool inside it, or is the spine. Cycles 253 and 254 have no
//! overlap factor: one radius is used.

use super::plunge_slope;
use crate::channel::milling::{self, Job, Plan, Plunge};
use crate::channel::shape::{Leg, NO_WIDTH_MM, Place, Point, Shape};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::Fault;
use crate::dialect::heidenhain::interpreter::Interpreter;
use crate::frame::sin_cos_degrees;

/// Q367, 0 to `most`.
pub(super) fn position(v: &Values, most: f64, help: &'static str) -> Result<usize, Fault> {
    let value = v.value(367)?;
    if value.fract() == 0.0 && (0.0..=most).contains(&value) {
        return Ok(value as usize);
    }
    Err(v.fault(codes::BAD_VALUE, format!("Q367 takes 0 to {most} and has {value}"), help))
}

impl Interpreter {
    /// Where the pocket lies, its wall, and how often it is repeated by which angle (254).
    pub(super) fn pocket_shape(v: &Values, here: Point) -> Result<(Place, Shape, u32, f64), Fault> {
        let len = |key: u32| {
            let value = v.value(key)?;
            if value > 0.0 && value.is_finite() {
                return Ok(value);
            }
            let message = format!("Q{key} of cycle {} must be above zero and is {value}", v.name());
            Err(v.fault(codes::BAD_VALUE, message, "write a length above zero"))
        };
        let position = |most: f64| position(v, most, "it gives the tool position relative to the pocket");
        let wrong = |message: String, help: &'static str| Err(v.fault(codes::BAD_VALUE, message, help));
        match v.name() {
            "252" => {
                let r = 0.5 * len(223)?;
                Ok((Place::new(here, 0.0), Shape::Rounded { a: r, b: r, corner: r }, 0, 0.0))
            }
            "251" => {
                let (a, b) = (0.5 * len(218)?, 0.5 * len(219)?);
                let corner = v.value(220)?.abs();
                let angle = v.value(224)?;
                // Tool position: the middle, or one of the four corners, counter-clockwise from the
                // lower left.
                let from = [[0.0, 0.0], [-a, -b], [a, -b], [a, b], [-a, b]][position(4.0)?];
                let place = about(here, from, angle);
                Ok((place, Shape::Rounded { a, b, corner: corner.min(a).min(b) }, 0, 0.0))
            }
            "253" => {
                let (a, b) = (0.5 * len(218)?, 0.5 * len(219)?);
                if a < b {
                    let message = "the slot Q218 is shorter than its width Q219".to_owned();
                    return wrong(message, "exchange both and turn the slot with Q374, or mill a pocket");
                }
                let along = [0.0, -a, -(a - b), a - b, a][position(4.0)?];
                let place = about(here, [along, 0.0], v.value(374)?);
                Ok((place, Shape::Rounded { a, b, corner: b }, 0, 0.0))
            }
            _ => {
                let (half, pitch) = (0.5 * len(219)?, 0.5 * len(375)?);
                let (from, through) = (v.value(376)?, v.value(248)?);
                if !(through > 0.0 && through <= 360.0) {
                    let message = format!("the opening angle Q248 is {through}");
                    return wrong(message, "write an angle above 0 and up to 360");
                }
                if half >= pitch {
                    return wrong("the slot Q219 is wider than its circle Q375".to_owned(), "mill a pocket");
                }
                let origin = match position(3.0)? {
                    0 => [v.value(216)?, v.value(217)?],
                    at => {
                        let (s, c) = sin_cos_degrees(from + [0.0, 0.5, 1.0][at - 1] * through);
                        [here[0] - pitch * c, here[1] - pitch * s]
                    }
                };
                let count = v.value(377)?;
                if !(1.0..=10_000.0).contains(&count) || count.fract() != 0.0 {
                    return wrong(format!("Q377 slots: {count}"), "write a whole number from 1");
                }
                let shape = Shape::Curved { pitch, from, through, half };
                Ok((Place::new(origin, 0.0), shape, count as u32 - 1, v.value(378)?))
            }
        }
    }

    pub(super) fn pocket_plans(&self, v: &Values, job: &Job, here: Point) -> Result<Vec<Plan>, Fault> {
        let (place, shape, repeats, step) = Self::pocket_shape(v, here)?;
        let along = v.name() == "253";
        // Corners smaller than the tool get the radius of the tool.
        let shape = match shape {
            Shape::Rounded { a, b, corner } => Shape::Rounded { a, b, corner: corner.max(job.radius) },
            other => other,
        };
        let overlap = if matches!(v.name(), "251" | "252") { self.overlap(v, job.radius)? } else { job.radius };
        let rings = |allowance: f64| {
            milling::rings(shape, job.radius, allowance, overlap, job.climb)
                .ok_or_else(|| milling::too_wide(shape, job.radius, allowance, &format!("cycle {}", v.name()), v.span))
        };
        let entry = match shape {
            Shape::Rounded { a, b, .. } if along => [-(a - b), 0.0],
            Shape::Rounded { .. } => [0.0; 2],
            Shape::Curved { pitch, from, .. } => {
                let (s, c) = sin_cos_degrees(from);
                [pitch * c, pitch * s]
            }
        };
        let room = (shape.half_width() - job.radius - job.side).max(0.0);
        let stroke = match shape {
            Shape::Rounded { a, b, .. } if along => Leg::Line([a - b, 0.0]),
            Shape::Rounded { a, b, .. } if a >= b => {
                Leg::Line([(a - job.radius - job.side).clamp(0.0, 4.0 * job.radius), 0.0])
            }
            Shape::Rounded { b, .. } => Leg::Line([0.0, (b - job.radius - job.side).clamp(0.0, 4.0 * job.radius)]),
            Shape::Curved { pitch, from, through, .. } => {
                let (s, c) = sin_cos_degrees(from + through);
                Leg::Arc { to: [pitch * c, pitch * s], center: [0.0; 2], clockwise: false }
            }
        };
        let plunge = match (v.value(366)?, v.name()) {
            (0.0, _) => Plunge::Vertical,
            (1.0, "251" | "252") if room > NO_WIDTH_MM => {
                Plunge::Helix { radius: room.min(job.radius), slope: plunge_slope() }
            }
            (1.0 | 2.0, "252") => Plunge::Vertical,
            (1.0 | 2.0, _) => Plunge::Strokes { leg: stroke, slope: plunge_slope() },
            (other, _) => {
                let message = format!("Q366 takes 0, 1 or 2 and has {other}");
                return Err(v.fault(codes::BAD_VALUE, message, "0 plunges vertically, 1 on a helix, 2 to and fro"));
            }
        };
        let finished = rings(0.0)?;
        let rough = rings(job.side)?;
        let lead = job.radius.min(shape.half_width() - job.radius);
        let wall = milling::wall(shape, job.radius, lead, job.climb);
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
