//! What taps have cut outside of the core holes of a design.
//!
//! A design has the core hole of a thread, or its outer diameter, seldom the thread itself. A tap cuts as the
//! cylinder round its teeth, so that in a design with the core hole a ring is missing that is no fault:
//!
//! ```text
//!        outer     core          axis of the stroke
//!     ____|__________|______________.______________
//!         |   ring   |   core hole  .             r in [core - m, outer + m]: thread
//!         |  thread  |   of the     .             anywhere else: gouge (off the axis, deeper than the core
//!         |__________|   design     .             hole, wider than the tap)
//!                    |______________.
//! ```
//!
//! What a tap has cut is thread where all of it lies in the ring round the axis of the stroke that
//! cut it. A tap that is off its hole cuts the wall of the hole inside of the core radius; one that
//! goes deeper than the hole cuts its bottom there. The margin m is the gouge that the scene allows
//! and what the measurement cannot resolve. Only motion along the tool's own axis makes a thread.

use std::collections::BTreeMap;

use proveout_geom::{Point, Vector};
use proveout_stock::SweepMotion;
use proveout_tool::{Thread, ToolLibrary};

/// A motion is along the axis when it leaves it by less than this part of its way.
const ALONG: f64 = 1e-3;

/// One motion of a tap along its axis, workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    point: Point,
    axis: Vector,
    thread: Thread,
    /// Place of the tap in the library.
    tool: usize,
}

/// Strokes by the number of the piece of motion.
pub(crate) type Strokes = BTreeMap<u32, Stroke>;

impl Stroke {
    /// The stroke of a motion; none where the tap moves across its axis or leans.
    pub(crate) fn of(motion: &SweepMotion, thread: Thread, tool: usize) -> Option<Self> {
        let (way, axis) = (motion.to.tip - motion.from.tip, motion.from.axis);
        let across = (way - axis * way.dot(&axis)).norm();
        let along = across <= ALONG * way.norm() && motion.to.axis.dot(&axis) > 1.0 - ALONG * ALONG;
        along.then_some(Self { point: motion.from.tip, axis, thread, tool })
    }

    /// Place of the tap in the library.
    pub(crate) fn tool(&self) -> usize {
        self.tool
    }

    /// Whether all points of a straight way lie in the ring of the thread, `margin` mm wider on both sides.
    pub(crate) fn holds(&self, [a, b]: [&Point; 2], margin: f64) -> bool {
        let off = |p: &Point| {
            let d = p - self.point;
            d - self.axis * d.dot(&self.axis)
        };
        let (a, b) = (off(a), off(b));
        let way = b - a;
        let square = way.norm_squared();
        let nearest = if square > 0.0 { (-a.dot(&way) / square).clamp(0.0, 1.0) } else { 0.0 };
        let least = (a + way * nearest).norm();
        least >= self.thread.core_radius - margin && a.norm().max(b.norm()) <= self.thread.outer_radius + margin
    }
}

/// Whether a piece of motion has cut thread alone on a straight way.
pub(crate) fn is_thread(strokes: &Strokes, made_by: Option<u32>, way: [&Point; 2], margin: f64) -> bool {
    made_by.and_then(|piece| strokes.get(&piece)).is_some_and(|stroke| stroke.holds(way, margin))
}

/// What taps and thread mills of a run have done.
#[derive(Debug)]
pub(crate) struct ThreadCuts {
    /// Whether each tool of the library cuts as the cylinder round it.
    is_envelope: Vec<bool>,
    /// Tools that cut as the cylinder round them, by the block that they cut in.
    pub(crate) envelopes: BTreeMap<u32, usize>,
    /// Motions of taps along their axis.
    pub(crate) strokes: Strokes,
}

impl ThreadCuts {
    pub(crate) fn new(tools: &ToolLibrary) -> Self {
        let is_envelope = tools.tools.iter().map(|t| t.is_thread_mill || t.is_tap && t.thread.is_none()).collect();
        Self { is_envelope, envelopes: BTreeMap::new(), strokes: Strokes::new() }
    }

    /// Takes a piece of motion by its number and block, in the workpiece frame.
    pub(crate) fn add(
        &mut self,
        [id, block]: [u32; 2],
        tools: &ToolLibrary,
        tool: Option<usize>,
        motion: &SweepMotion,
    ) {
        let Some(index) = tool else { return };
        if self.is_envelope.get(index) == Some(&true) {
            self.envelopes.insert(block, index);
        }
        let thread = tools.tools.get(index).and_then(|tool| tool.thread);
        if let Some(stroke) = thread.and_then(|thread| Stroke::of(motion, thread, index)) {
            self.strokes.insert(id, stroke);
        }
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::ToolPose;

    use super::*;

    fn motion(from: [f64; 3], to: [f64; 3]) -> SweepMotion {
        let at = |tip: [f64; 3]| ToolPose { tip: tip.into(), axis: Vector::z() };
        SweepMotion { from: at(from), to: at(to) }
    }

    #[test]
    fn the_ring_round_the_stroke_is_thread_and_nothing_else() {
        let m8 = Thread::new(8.0, 1.25).expect("a thread");
        let stroke = Stroke::of(&motion([10.0, 5.0, 3.0], [10.0, 5.0, -12.0]), m8, 0).expect("along the axis");
        let strokes: Strokes = [(7, stroke)].into();
        let on_thread = |made_by, a: [f64; 3], b: [f64; 3]| is_thread(&strokes, made_by, [&a.into(), &b.into()], 0.05);
        assert!(on_thread(Some(7), [13.4, 5.0, -3.0], [13.9, 5.0, -3.0]), "across the ring");
        assert!(on_thread(Some(7), [10.0, 8.6, -12.0], [10.0, 8.6, 0.0]), "along it");
        assert!(!on_thread(Some(7), [13.4, 5.0, -3.0], [14.1, 5.0, -3.0]), "wider than the tap");
        assert!(!on_thread(Some(7), [12.0, 5.0, -3.0], [13.9, 5.0, -3.0]), "inside of the core");
        assert!(
            !on_thread(Some(7), [6.3, 5.0, -3.0], [13.7, 5.0, -3.0]),
            "both ends in the ring, the way through the core"
        );
        assert!(!on_thread(Some(8), [13.4, 5.0, -3.0], [13.9, 5.0, -3.0]), "another motion");
        assert!(!on_thread(None, [13.4, 5.0, -3.0], [13.9, 5.0, -3.0]));
        assert_eq!(Stroke::of(&motion([0.0; 3], [5.0, 0.0, -5.0]), m8, 0), None, "a ramp is no thread");
    }
}
