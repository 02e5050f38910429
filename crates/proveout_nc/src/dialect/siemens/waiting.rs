//! Rapid motions on a turned plane of which one coordinate is not known yet.
//!
//! ```text
//!   SUPA G0 Z0 D0          the axes of the machine: no coordinate of the tip is known after it
//!   CYCLE800(..)           the plane turns
//!   G0 X10 Y5              where the tip goes depends on a Z that only the machine knows: there it stays
//!   G0 Z50                 now all three are known
//! ```
//!
//! Posts write every change of plane like this. The motion is made as written; axes without a word
//! stay at their machine position. The coordinates it sets are kept for the motion that sets the
//! rest.

use super::pending::Pending;
use super::run_state::Interpreter;
use crate::AxisValues;

use super::block::LINEAR;

impl Interpreter {
    /// Adds the coordinates set by earlier rapid motions to the end of a motion that sets the rest.
    pub(super) fn with_kept(&mut self, end: &mut AxisValues, programmed: &mut u16) {
        if *programmed & LINEAR == 0 {
            return;
        }
        for axis in 0..3 {
            if let Some(value) = self.own.held.get(axis)
                && *programmed >> axis & 1 == 0
            {
                end.put(axis, value);
                *programmed |= 1 << axis;
            }
        }
        if end.xyz().is_some() {
            self.own.held = AxisValues::NONE;
        }
    }

    /// Makes a rapid motion whose end is not known in all coordinates; returns false where it is
    /// known. `words`: the axes named by its own block.
    pub(super) fn rapid_left_open(&mut self, end: AxisValues, programmed: u16, words: u16, exact_stop: bool) -> bool {
        let open = programmed & LINEAR != 0 && end.xyz().is_none() && self.motion_to(end, programmed).is_err();
        if open {
            for axis in (0..3).filter(|axis| programmed >> axis & 1 == 1) {
                if let Some(value) = end.get(axis) {
                    self.own.held.put(axis, value);
                }
            }
            self.go_left_open(end, words, exact_stop);
            self.own.tangent = None;
        }
        open
    }

    /// Drops the coordinates kept from rapid motions: they do not hold once coordinates count
    /// differently.
    pub(super) fn forget_kept(&mut self) {
        self.own.held = AxisValues::NONE;
    }

    /// Drops them where words of the block change the meaning of coordinates.
    pub(super) fn forget_kept_before(&mut self, p: &Pending) {
        let edge = p.edge.is_some_and(|edge| self.own.edge != Some(edge));
        let changes = p.machine
            || edge
            || p.frame.is_some()
            || p.transformation.is_some()
            || p.tool_frame.is_some()
            || p.offset.is_some()
            || p.fixed_point.is_some()
            || p.pole.is_some()
            || p.functions.iter().any(|m| matches!(m, 2 | 6 | 30));
        if changes {
            self.forget_kept();
        }
    }
}
