//! Cuts a motion into pieces whose tip runs straight and whose axis runs on a great circle, within a
//! tolerance at the cutting edges and a wider one at the rest of the tool.
//!
//! ```text
//!        gauge line o----------.          an axis that is off by e moves a point by its way from the tip
//!                   |           '.  e     times e: edges that end at 15 mm allow 8 times the e of a gauge
//!             edges |.                    line at 120 mm
//!               tip o======o true
//! ```

use proveout_geom::ToolPose;
use proveout_machine::{JointKind, JointValues, Machine};

use crate::settings::Settings;

/// Joints and tool pose at a place of the path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointPose {
    pub(crate) s: f64,
    pub(crate) q: JointValues,
    pub(crate) pose: ToolPose,
}

/// Depth of the halving: 2^20 pieces of one block are more than any real path needs, and end a path that
/// never fits.
const DEEPEST: u32 = 20;
/// Surcharge on a deviation measured at the quarters: a cubic error passes them by 3 percent,
const BETWEEN: f64 = 1.05;
/// a kink next to one of them (a table of geometric errors bends) by a sixth.
const BENT: f64 = 1.2;
/// A number that is above a whole one by no more than this is that one: rounding.
pub(crate) const WHOLE: f64 = 1e-9;
/// Most parts of one way.
const MOST_PARTS: f64 = 1e6;
/// Square of the way of a tip below which it has no direction, mm2.
pub(crate) const NO_WAY_MM2: f64 = 1e-12;
/// A tool axis that turns by no more than this stands, radian.
pub(crate) const NO_TURN: f64 = 1e-12;

/// How far the true motion leaves a piece, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Off {
    /// Points of the cutting edges.
    pub(crate) edges: f64,
    /// Any point between tip and gauge line.
    pub(crate) tool: f64,
}

impl Off {
    const NONE: Self = Self { edges: 0.0, tool: 0.0 };

    fn or(self, o: &Self) -> Self {
        Self { edges: self.edges.max(o.edges), tool: self.tool.max(o.tool) }
    }

    fn times(self, factor: f64) -> Self {
        Self { edges: self.edges * factor, tool: self.tool * factor }
    }

    /// The highest part of the tolerances.
    fn used(&self, settings: &Settings) -> f64 {
        (self.edges / settings.piece_tolerance).max(self.tool / settings.piece_body_tolerance)
    }
}

/// What takes pieces.
pub(crate) type Emit<'a> = dyn FnMut(&JointPose, &JointPose, &Off, Option<&[JointPose; 3]>) + 'a;

/// Cuts paths into pieces.
pub(crate) struct PieceCutter<'a, F: Fn(f64) -> JointPose> {
    pub(crate) machine: &'a Machine,
    pub(crate) settings: &'a Settings,
    /// Ways from the tip to the end of the cutting edges and to the gauge line, mm.
    pub(crate) lengths: [f64; 2],
    pub(crate) stance: F,
}

impl<F: Fn(f64) -> JointPose> PieceCutter<'_, F> {
    /// Pieces of the path through the given places; a place in the middle is a border only where that is
    /// needed. `emit` gets begin, end and deviation, and the stances at the quarters where these were looked
    /// at.
    pub(crate) fn cut(&self, places: &[f64], emit: &mut Emit<'_>) {
        let (Some(&first), Some(&last)) = (places.first(), places.last()) else { return };
        let (a, b) = ((self.stance)(first), (self.stance)(last));
        if places.len() > 2 {
            if let Some(off) = self.fits(&a, &b, places) {
                emit(&a, &b, &off, None);
                return;
            }
            let mut from = a;
            for pair in places.windows(2) {
                let to = (self.stance)(pair[1]);
                self.cut_smooth(&from, &to, 0, emit);
                from = to;
            }
            return;
        }
        self.cut_smooth(&a, &b, 0, emit);
    }

    fn cut_smooth(&self, a: &JointPose, b: &JointPose, depth: u32, emit: &mut Emit<'_>) {
        let mut parts = self.parts_by_size(a, b);
        if parts == 1 {
            let quarters = [0.25, 0.5, 0.75].map(|part| (self.stance)(a.s + (b.s - a.s) * part));
            let off = [0.25, 0.5, 0.75].into_iter().zip(&quarters);
            let off = off.fold(Off::NONE, |worst, (part, x)| worst.or(&self.off(a, b, part, x)));
            let used = off.used(self.settings);
            if used <= 1.0 || depth >= DEEPEST {
                emit(a, b, &off, Some(&quarters));
                return;
            }
            // The deviation falls with the square of the length.
            parts = used.sqrt().ceil().clamp(2.0, 64.0) as usize;
        }
        let mut from = *a;
        for k in 1..=parts {
            let to = if k == parts { *b } else { (self.stance)(a.s + (b.s - a.s) * k as f64 / parts as f64) };
            self.cut_smooth(&from, &to, depth + 1, emit);
            from = to;
        }
    }

    fn parts_by_size(&self, a: &JointPose, b: &JointPose) -> usize {
        let mut parts = ((b.pose.tip - a.pose.tip).norm() / self.settings.piece_length)
            .max(a.pose.angle_to(&b.pose) / self.settings.piece_angle);
        for (i, joint) in self.machine.joints.iter().enumerate() {
            if joint.kind == JointKind::Rotary {
                parts = parts.max((b.q[i] - a.q[i]).abs() / self.settings.piece_angle);
            }
        }
        // One kink a piece is seen at the quarters, several may hide between them.
        let bends = self.machine.error_bends(&a.q, &b.q);
        if bends > 1 {
            parts = parts.max(bends as f64);
        }
        (parts - WHOLE).ceil().clamp(1.0, MOST_PARTS) as usize
    }

    /// Deviation of the whole way through several smooth parts, if it is within the tolerance.
    fn fits(&self, a: &JointPose, b: &JointPose, places: &[f64]) -> Option<Off> {
        if self.parts_by_size(a, b) > 1 {
            return None;
        }
        let span = b.s - a.s;
        let mut worst = Off::NONE;
        for (k, pair) in places.windows(2).enumerate() {
            for part in 0..4 {
                if k == 0 && part == 0 {
                    continue;
                }
                let t = (pair[0] + (pair[1] - pair[0]) * 0.25 * f64::from(part) - a.s) / span;
                worst = worst.or(&self.off(a, b, t, &(self.stance)(a.s + span * t)));
                if worst.used(self.settings) > 1.0 {
                    return None;
                }
            }
        }
        Some(worst)
    }

    /// Deviation at a part of the way, where the tool is at x.
    fn off(&self, a: &JointPose, b: &JointPose, part: f64, x: &JointPose) -> Off {
        let way = b.pose.tip - a.pose.tip;
        let length2 = way.norm_squared();
        // Where on the piece the true pose belongs is free: the uniform motion of a piece is not bound to
        // time.
        let t = if length2 > NO_WAY_MM2 {
            (x.pose.tip - a.pose.tip).dot(&way) / length2
        } else {
            let turn = a.pose.angle_to(&b.pose);
            if turn > NO_TURN { a.pose.angle_to(&x.pose) / turn } else { part }
        };
        let ideal = a.pose.interpolated(&b.pose, t.clamp(0.0, 1.0));
        let (tip, axis) = ((x.pose.tip - ideal.tip).norm(), (x.pose.axis - ideal.axis).norm());
        let [edges, tool] = self.lengths.map(|length| tip + length * axis);
        Off { edges, tool }.times(if self.machine.error_bends(&a.q, &b.q) > 0 { BENT } else { BETWEEN })
    }
}
