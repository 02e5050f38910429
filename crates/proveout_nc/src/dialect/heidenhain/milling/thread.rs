//! Cycles 263, 264 and 265: threads that are countersunk, drilled, or milled downwards in one helix.
//!
//! ```text
//!   263   countersink at the front (Q358 deep, Q359 off the middle), then one turn of the thread
//!   264   drilled in infeeds Q202 to Q356, out to the set-up clearance and back to Q258 above the last depth; then one turn
//!   265   countersink before (Q360=0) or after (1) the thread, which is one helix from the surface down to its depth
//! ```
//!
//! After HEIDENHAIN, *TNC 640 Programming of machining cycles* (34059x), "Thread
//! milling/countersinking", "Thread drilling/milling", "Helical thread drilling/milling". Refused
//! by name: the countersunk hole of 263 (Q356), because the approach to the core diameter depends
//! on the room there; chip breaking (Q257) and the countersink (Q358) of 264; a hole of 264 in
//! which the leads of the thread would cut the bottom.

use std::f64::consts::TAU;

use super::Values;
use super::bore::Helix;
use crate::Feed;
use crate::channel::milling::{SAME_HEIGHT_MM, levels};
use crate::channel::shape::{NO_WIDTH_MM, Place};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::dialect::heidenhain::interpreter::Interpreter;

/// Parameters that the control writes, and what is taken for granted.
pub(super) fn words(number: u32) -> (&'static [u32], &'static str) {
    const LEADS: &str = "the tool comes onto the thread and leaves it on half circles that rise or fall by half a pitch; countersinking \
                         runs the way of the thread, with Q254 from the middle on";
    match number {
        263 => (&[335, 239, 201, 356, 253, 351, 200, 357, 358, 359, 203, 204, 254, 207], LEADS),
        264 => (&[335, 239, 201, 356, 253, 351, 202, 258, 257, 256, 358, 359, 200, 203, 204, 206, 207], LEADS),
        _ => (&[335, 239, 201, 253, 358, 359, 360, 200, 203, 204, 254, 207], LEADS),
    }
}

/// Parameters that must be zero, with what to do instead.
pub(super) fn zeros(number: u32) -> &'static [(u32, &'static str)] {
    match number {
        263 => &[(356, "countersink the hole with a cycle of its own, and write Q356=0")],
        264 => &[
            (257, "write Q257=0: the tool comes out between the infeeds"),
            (358, "countersink with a cycle of its own, and write Q358=0"),
        ],
        _ => &[],
    }
}

impl Interpreter {
    pub(super) fn thread_cycle(
        &mut self,
        number: u32,
        values: &Values,
        radius: f64,
        lift: f64,
        span: Span,
    ) -> Result<(), Fault> {
        let h = self.heights(number, values, lift, span)?;
        let path = self.hole_radius(number, values, radius, span)?;
        let pitch = self.mm(values, 239, None, span)?;
        let (p, total) = (pitch.abs(), (h.depth - h.surface).abs());
        if pitch == 0.0 || !pitch.is_finite() || path <= NO_WIDTH_MM {
            return Err(Fault::new(codes::ARGUMENTS, span, "the thread has no pitch, or is not wider than the tool")
                .help("check Q239 and Q335"));
        }
        // A right-hand thread rises where the tool turns counter-clockwise; 265 always goes down.
        let counter = if number == 265 { pitch < 0.0 } else { self.climbs(values, span)? };
        let rises = number != 265 && counter == (pitch > 0.0);
        let center = self.flat(span)?;
        self.come_over(center, h.clear, span)?;
        if number == 264 {
            let hole = self.mm(values, 356, None, span)?.abs();
            if total + 0.5 * p > hole + SAME_HEIGHT_MM {
                let message = format!(
                    "the thread of cycle 264 with its lead of half a pitch is {:.3} mm deep, and its hole Q356 {hole:.3} mm",
                    total + 0.5 * p
                );
                return Err(
                    Fault::new(codes::ARGUMENTS, span, message).help("drill deeper, or mill the thread alone (262)")
                );
            }
            self.drill_for_thread(values, (h.surface, h.down, h.clear), span)?;
        }
        let feed = self.cycle_feed(values, 207, span)?;
        let helix = Helix { center, path, counter, feed };
        let countersink_last = number == 265 && self.thread_flag(values, span)?;
        if number != 264 && !countersink_last {
            let key = if number == 263 { 253 } else { 254 };
            self.countersink(helix, values, key, h.surface, span)?;
        }
        let piece = if number == 265 { (total, 0.0) } else { (total, total - p) };
        self.thread_pieces(helix, values, &[piece], (p, rises), (h.surface, h.down), span)?;
        if countersink_last {
            self.countersink(helix, values, 253, h.surface, span)?;
        }
        self.mill_to(None, Some(h.clear), None, span)?;
        self.mill_to(None, Some(h.second), None, span)
    }

    /// Q360: countersink after the thread.
    fn thread_flag(&self, values: &Values, span: Span) -> Result<bool, Fault> {
        match self.cycle_number(values, 360, Some(0.0), span)? {
            0.0 => Ok(false),
            1.0 => Ok(true),
            other => Err(Fault::new(codes::BAD_VALUE, span, format!("Q360 takes 0 or 1 and has {other}"))
                .help("0 countersinks before the thread, 1 after it")),
        }
    }

    /// Infeeds of 264 down to Q356.
    fn drill_for_thread(
        &mut self,
        values: &Values,
        (surface, down, clear): (f64, f64, f64),
        span: Span,
    ) -> Result<(), Fault> {
        let hole = self.mm(values, 356, None, span)?;
        if hole * down <= 0.0 || !hole.is_finite() {
            return Err(Fault::new(codes::ARGUMENTS, span, format!("the depth Q356 of the hole is {hole} mm"))
                .help("write it with the sign of the depth of the thread"));
        }
        let infeed = self.mm(values, 202, Some(0.0), span)?.abs();
        let stop = self.mm(values, 258, Some(0.0), span)?.abs();
        let feed = self.cycle_feed(values, 206, span)?;
        let depths = levels(hole.abs(), infeed);
        for (i, &depth) in depths.iter().enumerate() {
            self.mill_to(None, Some(surface + down * depth), feed, span)?;
            if i + 1 < depths.len() {
                self.mill_to(None, Some(clear), None, span)?;
                let ahead = surface + down * (depth - stop);
                // Not above the height it has retracted to.
                let ahead = if down < 0.0 { ahead.min(clear) } else { ahead.max(clear) };
                self.mill_to(None, Some(ahead), None, span)?;
            }
        }
        Ok(())
    }

    /// At the front: down to Q358, off the middle by Q359 on a half circle, once around, and back. Nothing where Q358 is zero.
    fn countersink(&mut self, helix: Helix, values: &Values, key: u32, surface: f64, span: Span) -> Result<(), Fault> {
        let depth = self.mm(values, 358, Some(0.0), span)?;
        if depth == 0.0 {
            return Ok(());
        }
        let offset = self.mm(values, 359, Some(0.0), span)?.abs();
        let to: Option<Feed> = self.cycle_feed(values, key, span)?;
        let feed = self.cycle_feed(values, 254, span)?;
        self.mill_to(None, Some(surface + depth), to, span)?;
        if offset <= NO_WIDTH_MM {
            return Ok(());
        }
        let place = Place::new(helix.center, 0.0);
        let (side, half) = (place.at([offset, 0.0]), place.at([0.5 * offset, 0.0]));
        self.mill_arc((side, half, !helix.counter), 0.5 * TAU, None, feed, span)?;
        self.mill_arc((side, helix.center, !helix.counter), TAU, None, feed, span)?;
        self.mill_arc((helix.center, half, !helix.counter), 0.5 * TAU, None, feed, span)
    }
}
