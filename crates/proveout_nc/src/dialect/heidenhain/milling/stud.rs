//! Cycles 256 and 257: studs, from the outside in.
//!
//! ```text
//!        blank                 Rings of the tool center, one overlap apart, run from the blank to the
//!     .----------.    s        finished stud. The tool plunges at s, 2 mm clear of the blank, comes
//!     |  .----.  |  (          onto the ring on a half circle, and leaves the last one on another.
//!     |  |stud|  |   ' start of a ring
//!     '----------'
//! ```

use super::pocket::position;
use crate::channel::milling::{Job, MAX_PASSES, Plan, Plunge, WHOLE};
use crate::channel::shape::{Leg, Pass, Place, Point, Shape};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::Fault;
use crate::dialect::heidenhain::interpreter::Interpreter;
use crate::dialect::heidenhain::lexer::refused;

/// Distance of the tool from the blank where it plunges, mm: fixed in the control.
const BESIDE_BLANK_MM: f64 = 2.0;

impl Interpreter {
    /// Where the stud lies, its wall, the largest thickness of the material around it, and half of
    /// the blank along the first axis.
    pub(super) fn stud_shape(v: &Values, here: Point) -> Result<(Place, Shape, f64, f64), Fault> {
        let half = |key: u32, blank: u32| {
            let (stud, blank_size) = (0.5 * v.value(key)?, 0.5 * v.value(blank)?);
            if stud > 0.0 && blank_size > stud {
                return Ok((stud, blank_size));
            }
            let message = format!("the blank Q{blank} is not larger than the stud Q{key}");
            Err(v.fault(codes::BAD_VALUE, message, "write the size of the blank"))
        };
        if v.name() == "257" {
            let (r, blank) = half(223, 222)?;
            let angle = v.raw(376)?.unwrap_or(-1.0);
            let place = Place::new(here, if angle < 0.0 { 0.0 } else { angle });
            return Ok((place, Shape::Rounded { a: r, b: r, corner: r }, blank - r, blank));
        }
        let start = v.value(437)?;
        if start != 0.0 {
            let word = format!("Q437={start} (approach at a corner of the stud)");
            return Err(refused(&word, v.span, "write Q437=0: the approach is to the right of the stud"));
        }
        let ((a, blank_a), (b, blank_b)) = (half(218, 424)?, half(219, 425)?);
        let corner = v.value(220)?;
        if corner < 0.0 {
            let word = "Q220 below zero (a chamfer at the corners of the stud)";
            return Err(refused(word, v.span, "write the contour as L and CHF blocks"));
        }
        let at = position(v, 4.0, "it gives the tool position relative to the stud")?;
        let from = [[0.0, 0.0], [-a, -b], [a, -b], [a, b], [-a, b]][at];
        let place = super::pocket::about(here, from, v.value(224)?);
        let shape = Shape::Rounded { a, b, corner: corner.min(a).min(b) };
        Ok((place, shape, (blank_a - a).max(blank_b - b), blank_a))
    }

    pub(super) fn stud_plan(&self, v: &Values, job: &Job, here: Point) -> Result<Plan, Fault> {
        let (place, shape, thickness, blank) = Self::stud_shape(v, here)?;
        let overlap = self.overlap(v, job.radius)?;
        let Shape::Rounded { a, .. } = shape else {
            return Err(v.fault(codes::ARGUMENTS, "a stud is a rectangle or a circle", "check the cycle"));
        };
        let ring = |outside: f64| -> Pass {
            let ring = shape.ring(-outside);
            if job.climb { ring.reversed() } else { ring }
        };
        let count =
            |allowance: f64| ((thickness - allowance) / overlap - WHOLE).ceil().clamp(1.0, MAX_PASSES as f64) as usize;
        // The half circle reaches from the plunge to the ring.
        let outermost = job.radius + job.side + (count(job.side) - 1) as f64 * overlap;
        let entry = [job.radius + BESIDE_BLANK_MM + blank.max(a + outermost - job.radius), 0.0];
        let lead = |to: Point, ring: Point| {
            let center = [0.5 * (entry[0] + ring[0]), 0.5 * (entry[1] + ring[1])];
            Leg::Arc { to, center, clockwise: !job.climb }
        };
        let with_leads = |mut passes: Vec<Pass>| {
            if let Some(first) = passes.first_mut() {
                first.legs.insert(0, lead(first.start, first.start));
                first.start = entry;
            }
            if let Some(last) = passes.last_mut() {
                last.legs.push(lead(entry, last.end()));
            }
            passes
        };
        let rings = |allowance: f64| -> Vec<Pass> {
            with_leads((0..count(allowance)).rev().map(|j| ring(job.radius + allowance + j as f64 * overlap)).collect())
        };
        let wall = with_leads(vec![ring(job.radius)]).swap_remove(0);
        Ok(Plan {
            place,
            entry,
            plunge: Plunge::Vertical,
            rough: rings(job.side),
            wall,
            floor: rings(0.0),
            returns: false,
        })
    }
}
