//! Cycles 208 and 262: bore milling and thread milling, on helices.
//!
//! ```text
//!   208   half circle onto the hole at the set-up clearance, helix of pitch Q334 to the depth,
//!         a full circle there, half circle back to the middle; a hole wider than the helix can
//!         clear is made by several, from the inside out
//!   262   half circle onto the thread, one turn (Q355=0), all turns (1) or turns in steps of
//!         Q355 threads, half circle back
//! ```

use std::f64::consts::TAU;

use crate::Feed;
use crate::channel::milling::{Heights, MAX_PASSES, levels};
use crate::channel::shape::{NO_WIDTH_MM, Place, Point};
use crate::codes;
use crate::cycle::Values;
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

impl Interpreter {
    pub(super) fn hole_radius(v: &Values, radius: f64) -> Result<f64, Fault> {
        let diameter = v.value(335)?;
        let path = 0.5 * diameter - radius;
        if path < -NO_WIDTH_MM || !path.is_finite() {
            let message =
                format!("a tool of radius {radius} mm does not fit into a hole of {diameter} mm (cycle {})", v.name());
            return Err(v.fault(codes::COMPENSATION, message, "use a smaller tool"));
        }
        Ok(path.max(0.0))
    }

    /// The pitch of a thread, with its sign.
    pub(super) fn thread_of(v: &Values, path: f64) -> Result<f64, Fault> {
        let pitch = v.value(239)?;
        if pitch == 0.0 || !pitch.is_finite() || path <= NO_WIDTH_MM {
            let message = "the thread has no pitch, or is not wider than the tool";
            return Err(v.fault(codes::ARGUMENTS, message, "check Q239 and Q335"));
        }
        Ok(pitch)
    }

    pub(super) fn bore_mill(&mut self, v: &Values, radius: f64) -> Result<(), Fault> {
        let span = v.span;
        let h = self.heights(v)?;
        let path = Self::hole_radius(v, radius)?;
        let feed = self.cycle_feed(v, 206)?;
        let pitch = v.value(334)?.abs();
        let roughed = 0.5 * v.value(342)?;
        let center = self.flat(span)?;
        self.come_over(center, h.clear, span)?;
        if path <= NO_WIDTH_MM {
            // A hole of the tool diameter is drilled.
            self.mill_to(None, Some(h.depth), feed, span)?;
            self.mill_to(None, Some(h.clear), None, span)?;
            return self.mill_to(None, Some(h.second), None, span);
        }
        let mut radii = vec![path];
        if v.given(370).is_some() {
            let step = if v.value(370)? == 0.0 { radius } else { self.overlap(v, radius)? };
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
            let help =
                "give the diameter that is roughed before in Q342, or the overlap in Q370, or mill a pocket (252)";
            return Err(v.fault(codes::ARGUMENTS, message, help));
        }
        let climb = self.climbs(v)?;
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

    pub(super) fn thread_mill(&mut self, v: &Values, radius: f64) -> Result<(), Fault> {
        let span = v.span;
        let h = self.heights(v)?;
        let path = Self::hole_radius(v, radius)?;
        let pitch = Self::thread_of(v, path)?;
        let per_step = v.value(355)?;
        if per_step < 0.0 || per_step.fract() != 0.0 {
            let help = "write 0, 1 or the number of threads that the tool cuts at once";
            return Err(v.fault(codes::BAD_VALUE, format!("Q355 is {per_step}"), help));
        }
        // As the figures in the manual show: climb turns counter-clockwise, with M4 the other way.
        let counter = self.climbs(v)?;
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
        let feed = self.cycle_feed(v, 207)?;
        let helix = Helix { center, path, counter, feed };
        self.thread_pieces(helix, v, &pieces, (p, rises), h)?;
        self.mill_to(None, Some(h.clear), None, span)?;
        self.mill_to(None, Some(h.second), None, span)
    }

    /// Pieces of a thread of the pitch `p`, each from a depth to a depth below the surface, up where it
    /// `rises`.
    pub(super) fn thread_pieces(
        &mut self,
        helix: Helix,
        v: &Values,
        pieces: &[(f64, f64)],
        (p, rises): (f64, bool),
        h: Heights,
    ) -> Result<(), Fault> {
        let span = v.span;
        let position = self.feed_if_written(v, 253)?;
        let at = |depth: f64| h.surface + h.down * depth;
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
