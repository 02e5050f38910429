//! Cycles 263, 264 and 265: threads that are countersunk, drilled, or milled downwards in one helix.
//!
//! ```text
//!   263   countersink at the front (Q358 deep, Q359 off the middle), then one turn of the thread
//!   264   drilled in infeeds Q202 to Q356, out to the set-up clearance and back to Q258 above the
//!         last depth; then one turn
//!   265   countersink before (Q360=0) or after (1) the thread, which is one helix from the surface
//!         down to its depth
//! ```
//!
//! After HEIDENHAIN, *TNC 640 Programming of machining cycles* (34059x), "Thread
//! milling/countersinking", "Thread drilling/milling", "Helical thread drilling/milling". Refused
//! by name: the countersunk hole of 263 (Q356), because the approach to the core diameter depends
//! on the room there; chip breaking (Q257) and the countersink (Q358) of 264; a hole of 264 in
//! which the leads of the thread would cut the bottom.

use std::f64::consts::TAU;

use super::bore::Helix;
use crate::channel::milling::{Heights, SAME_HEIGHT_MM, levels};
use crate::channel::shape::{NO_WIDTH_MM, Place};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::Fault;
use crate::dialect::heidenhain::interpreter::Interpreter;

impl Interpreter {
    pub(super) fn thread_cycle(&mut self, v: &Values, radius: f64) -> Result<(), Fault> {
        let span = v.span;
        let h = self.heights(v)?;
        let path = Self::hole_radius(v, radius)?;
        let pitch = Self::thread_of(v, path)?;
        let (p, total) = (pitch.abs(), (h.depth - h.surface).abs());
        // A right-hand thread rises where the tool turns counter-clockwise; 265 always goes down.
        let counter = if v.name() == "265" { pitch < 0.0 } else { self.climbs(v)? };
        let rises = v.name() != "265" && counter == (pitch > 0.0);
        let center = self.flat(span)?;
        self.come_over(center, h.clear, span)?;
        if v.name() == "264" {
            let hole = v.value(356)?.abs();
            if total + 0.5 * p > hole + SAME_HEIGHT_MM {
                let message = format!(
                    "the thread of cycle 264 with its lead of half a pitch is {:.3} mm deep, and its hole Q356 {hole:.3} mm",
                    total + 0.5 * p
                );
                return Err(v.fault(codes::ARGUMENTS, message, "drill deeper, or mill the thread alone (262)"));
            }
            self.drill_for_thread(v, h)?;
        }
        let feed = self.cycle_feed(v, 207)?;
        let helix = Helix { center, path, counter, feed };
        let countersink_last = v.name() == "265" && Self::countersinks_last(v)?;
        if v.name() != "264" && !countersink_last {
            self.countersink(helix, v, if v.name() == "263" { 253 } else { 254 }, h.surface)?;
        }
        let piece = if v.name() == "265" { (total, 0.0) } else { (total, total - p) };
        self.thread_pieces(helix, v, &[piece], (p, rises), h)?;
        if countersink_last {
            self.countersink(helix, v, 253, h.surface)?;
        }
        self.mill_to(None, Some(h.clear), None, span)?;
        self.mill_to(None, Some(h.second), None, span)
    }

    /// Q360: countersink after the thread.
    fn countersinks_last(v: &Values) -> Result<bool, Fault> {
        match v.value(360)? {
            0.0 => Ok(false),
            1.0 => Ok(true),
            other => {
                let message = format!("Q360 takes 0 or 1 and has {other}");
                Err(v.fault(codes::BAD_VALUE, message, "0 countersinks before the thread, 1 after it"))
            }
        }
    }

    /// Infeeds of 264 down to Q356.
    fn drill_for_thread(&mut self, v: &Values, h: Heights) -> Result<(), Fault> {
        let span = v.span;
        let hole = v.value(356)?;
        if hole * h.down <= 0.0 || !hole.is_finite() {
            let message = format!("the depth Q356 of the hole is {hole} mm");
            return Err(v.fault(codes::ARGUMENTS, message, "write it with the sign of the depth of the thread"));
        }
        let (infeed, stop) = (v.value(202)?.abs(), v.value(258)?.abs());
        let feed = self.cycle_feed(v, 206)?;
        let depths = levels(hole.abs(), infeed);
        for (i, &depth) in depths.iter().enumerate() {
            self.mill_to(None, Some(h.surface + h.down * depth), feed, span)?;
            if i + 1 < depths.len() {
                self.mill_to(None, Some(h.clear), None, span)?;
                let ahead = h.surface + h.down * (depth - stop);
                // Not above the height it has retracted to.
                let ahead = if h.down < 0.0 { ahead.min(h.clear) } else { ahead.max(h.clear) };
                self.mill_to(None, Some(ahead), None, span)?;
            }
        }
        Ok(())
    }

    /// At the front: down to Q358, off the middle by Q359 on a half circle, once around, and back. Nothing
    /// where Q358 is zero.
    fn countersink(&mut self, helix: Helix, v: &Values, key: u32, surface: f64) -> Result<(), Fault> {
        let span = v.span;
        let depth = v.value(358)?;
        if depth == 0.0 {
            return Ok(());
        }
        let offset = v.value(359)?.abs();
        let to = self.cycle_feed(v, key)?;
        let feed = self.cycle_feed(v, 254)?;
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
