//! Cycles 208 and 262: bore milling and thread milling, on helices.
//!
//! ```text
//!   208   half circle onto the hole at the set-up clearance, helix of pitch Q334 to the depth, a full circle there, half circle
//!         back to the middle; a hole wider than the helix can clear is made by several, from the inside out
//!   262   half circle onto the thread, one turn (Q355=0), all turns (1) or turns in steps of Q355 threads, half circle back
//! ```

use std::f64::consts::TAU;

use super::Values;
use crate::Feed;
use crate::channel::milling::{MAX_PASSES, levels};
use crate::channel::shape::{NO_WIDTH_MM, Place, Point};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::dialect::heidenhain::interpreter::Interpreter;

/// Most turns of a helix.
const MAX_TURNS: f64 = 100_000.0;

/// A helix of the tool center about the middle of a hole.
#[derive(Clone, Copy)]
pub(super) struct Helix {
    pub(super) center: Point,
    /// mm.
    pub(super) path: f64,
    /// Counter-clockwise.
    pub(super) counter: bool,
    pub(super) feed: Option<Feed>,
}

/// Parameters that the control writes for 208, and what is taken for granted.
pub(super) fn bore_words() -> (&'static [u32], &'static str) {
    (
        &[200, 201, 206, 334, 203, 204, 335],
        "the helix begins at the set-up clearance and ends with a full circle at the depth; leads are half circles; without Q370 a \
         hole that is roughed before (Q342) is made by one helix",
    )
}

/// Parameters that the control writes for 262, and what is taken for granted.
pub(super) fn thread_words() -> (&'static [u32], &'static str) {
    (
        &[335, 239, 201, 355, 253, 351, 200, 203, 204, 207],
        "the tool comes onto the thread and leaves it on half circles that rise by half a pitch; all turns (Q355=1) run between the \
         depth and the surface",
    )
}

impl Interpreter {
    pub(super) fn hole_radius(&self, number: u32, values: &Values, radius: f64, span: Span) -> Result<f64, Fault> {
        let diameter = self.mm(values, 335, None, span)?;
        let path = 0.5 * diameter - radius;
        if path < -NO_WIDTH_MM || !path.is_finite() {
            let message =
                format!("a tool of radius {radius} mm does not fit into a hole of {diameter} mm (cycle {number})");
            return Err(Fault::new(codes::COMPENSATION, span, message).help("use a smaller tool"));
        }
        Ok(path.max(0.0))
    }

    pub(super) fn bore_mill(&mut self, values: &Values, radius: f64, lift: f64, span: Span) -> Result<(), Fault> {
        let h = self.heights(208, values, lift, span)?;
        let path = self.hole_radius(208, values, radius, span)?;
        let feed = self.cycle_feed(values, 206, span)?;
        let pitch = self.mm(values, 334, None, span)?.abs();
        let roughed = 0.5 * self.mm(values, 342, Some(0.0), span)?;
        let center = self.flat(span)?;
        self.come_over(center, h.clear, span)?;
        if path <= NO_WIDTH_MM {
            // A hole of the tool diameter is drilled.
            self.mill_to(None, Some(h.depth), feed, span)?;
            self.mill_to(None, Some(h.clear), None, span)?;
            return self.mill_to(None, Some(h.second), None, span);
        }
        let mut radii = vec![path];
        if values.contains_key(&370) {
            let step = if self.cycle_number(values, 370, None, span)? == 0.0 {
                radius
            } else {
                self.overlap(values, radius, span)?
            };
            // Adds helices inwards until only what was roughed before is left inside the innermost
            // one.
            while let Some(&innermost) = radii.last()
                && innermost - radius > roughed.max(NO_WIDTH_MM)
                && radii.len() < MAX_PASSES
            {
                radii.push((innermost - step).max(0.5 * radius.min(innermost)));
            }
        } else if roughed == 0.0 && path > radius + NO_WIDTH_MM {
            let message = format!(
                "a hole of {} mm is more than twice as wide as the tool of {} mm, which leaves a post in its middle",
                2.0 * (path + radius),
                2.0 * radius
            );
            return Err(Fault::new(codes::ARGUMENTS, span, message).help(
                "give the diameter that is roughed before in Q342, or the overlap in Q370, or mill a pocket (252)",
            ));
        }
        let climb = self.climbs(values, span)?;
        for path in radii.into_iter().rev() {
            let side = [center[0] + path, center[1]];
            let half = [center[0] + 0.5 * path, center[1]];
            let drop = (h.depth - h.clear).abs();
            let turns = if pitch > 0.0 { (drop / pitch).min(MAX_TURNS) } else { 1.0 };
            self.mill_arc((side, half, !climb), 0.5 * TAU, None, feed, span)?;
            // The helix ends where its turns end; the full circle and the way back begin there.
            let angle = turns.fract() * TAU * if climb { 1.0 } else { -1.0 };
            let (s, c) = if angle == 0.0 { (0.0, 1.0) } else { angle.sin_cos() };
            let end = [center[0] + c * path, center[1] + s * path];
            self.mill_arc((end, center, !climb), turns * TAU, Some(h.depth), feed, span)?;
            self.mill_arc((end, center, !climb), TAU, None, feed, span)?;
            let half = [0.5 * (center[0] + end[0]), 0.5 * (center[1] + end[1])];
            self.mill_arc((center, half, !climb), 0.5 * TAU, None, feed, span)?;
            self.mill_to(None, Some(h.clear), None, span)?;
        }
        self.mill_to(None, Some(h.second), None, span)
    }

    pub(super) fn thread_mill(&mut self, values: &Values, radius: f64, lift: f64, span: Span) -> Result<(), Fault> {
        let h = self.heights(262, values, lift, span)?;
        let path = self.hole_radius(262, values, radius, span)?;
        let pitch = self.mm(values, 239, None, span)?;
        let per_step = self.cycle_number(values, 355, None, span)?;
        if pitch == 0.0 || !pitch.is_finite() || path <= NO_WIDTH_MM {
            return Err(Fault::new(codes::ARGUMENTS, span, "the thread has no pitch, or is not wider than the tool")
                .help("check Q239 and Q335"));
        }
        if per_step < 0.0 || per_step.fract() != 0.0 {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("Q355 is {per_step}"))
                .help("write 0, 1 or the number of threads that the tool cuts at once"));
        }
        // As the figures in the manual show: climb turns counter-clockwise, with M4 the other way.
        let counter = self.climbs(values, span)?;
        // A right-hand thread rises where the tool turns counter-clockwise.
        let rises = counter == (pitch > 0.0);
        let (p, total) = (pitch.abs(), (h.depth - h.surface).abs());
        // Depths at which a piece of the thread begins and ends.
        let pieces: Vec<(f64, f64)> = match per_step {
            0.0 => vec![(total, total - p)],
            1.0 => vec![(total, 0.0)],
            n => levels(total, n * p).into_iter().map(|depth| (depth, depth - p)).collect(),
        };
        let center = self.flat(span)?;
        self.come_over(center, h.clear, span)?;
        let feed = self.cycle_feed(values, 207, span)?;
        let helix = Helix { center, path, counter, feed };
        self.thread_pieces(helix, values, &pieces, (p, rises), (h.surface, h.down), span)?;
        self.mill_to(None, Some(h.clear), None, span)?;
        self.mill_to(None, Some(h.second), None, span)
    }

    /// Pieces of a thread of the pitch `p`, each from a depth to a depth below the surface, up where it `rises`.
    pub(super) fn thread_pieces(
        &mut self,
        helix: Helix,
        values: &Values,
        pieces: &[(f64, f64)],
        (p, rises): (f64, bool),
        (surface, down): (f64, f64),
        span: Span,
    ) -> Result<(), Fault> {
        let position = if values.contains_key(&253) { self.cycle_feed(values, 253, span)? } else { None };
        let at = |depth: f64| surface + down * depth;
        for &(low, high) in pieces {
            let (from, to) = if rises { (low, high) } else { (high, low) };
            let lead = if rises { -0.5 * p } else { 0.5 * p };
            self.mill_to(None, Some(at(from - lead)), position, span)?;
            self.turns(helix, [at(from), at(to), at(to + lead)], (from - to).abs() / p, span)?;
        }
        Ok(())
    }

    /// Half circle onto the thread, its turns, half circle back to the middle.
    fn turns(&mut self, helix: Helix, [begin, end, out]: [f64; 3], turns: f64, span: Span) -> Result<(), Fault> {
        let Helix { center, path, counter, feed } = helix;
        let place = Place::new(center, 0.0);
        let (side, half) = (place.at([path, 0.0]), place.at([0.5 * path, 0.0]));
        self.mill_arc((side, half, !counter), 0.5 * TAU, Some(begin), feed, span)?;
        let turns = turns.min(MAX_TURNS);
        let angle = turns.fract() * TAU * if counter { 1.0 } else { -1.0 };
        let (s, c) = if angle == 0.0 { (0.0, 1.0) } else { angle.sin_cos() };
        let last = place.at([c * path, s * path]);
        self.mill_arc((last, center, !counter), turns * TAU, Some(end), feed, span)?;
        let half = place.at([0.5 * c * path, 0.5 * s * path]);
        self.mill_arc((center, half, !counter), 0.5 * TAU, Some(out), feed, span)
    }
}
