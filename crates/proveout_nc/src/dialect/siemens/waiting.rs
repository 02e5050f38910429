//! Rapid motions on a turned plane of which one coordinate is not known yet.
//!
//! ```text
//!   SUPA G0 Z0 D0          the axes of the machine: no coordinate of the tip is known behind it
//!   CYCLE800(..)           the plane turns
//!   G0 X10 Y5              where the tip goes depends on a Z that only the machine knows
//!   G0 Z50                 now all three are known
//! ```
//!
//! Posts write every change of plane like this. The motion is held back and made together with the rapid motion that tells the rest,
//! as the readers of the other languages do. What comes between and needs the position is refused.

use super::interpreter::Interpreter;
use super::pending::Pending;
use crate::AxisValues;
use crate::codes;
use crate::diagnostic::{Fault, Span};

use super::block::LINEAR;

impl Interpreter {
    /// Puts what waits into the end of a rapid motion. True where it cannot be made yet, and waits itself.
    pub(super) fn rapid_waits(&mut self, end: &mut AxisValues, programmed: &mut u16) -> bool {
        for axis in 0..3 {
            if let Some(value) = self.own.held.get(axis)
                && *programmed >> axis & 1 == 0
            {
                end.put(axis, value);
                *programmed |= 1 << axis;
            }
        }
        let open = *programmed & LINEAR != 0 && end.xyz().is_none() && self.motion_to(*end, *programmed).is_err();
        if !open {
            self.own.held = AxisValues::NONE;
            return false;
        }
        for axis in 0..3 {
            if let Some(value) = end.get(axis).filter(|_| *programmed >> axis & 1 == 1) {
                self.own.held.put(axis, value);
            }
        }
        self.note("the rapid motion is made together with the next one, which tells the rest of the position on the turned plane");
        true
    }

    /// A rapid motion that waits has never been made.
    pub(super) fn nothing_waits(&self, span: Span) -> Result<(), Fault> {
        if self.own.held.is_empty() {
            return Ok(());
        }
        let letters: String = self.own.held.iter().map(|(letter, _)| letter).collect();
        let missing: String =
            (0..3).filter(|&i| self.own.held.get(i).is_none()).map(|i| crate::AXIS_LETTERS[i]).collect();
        let message = format!(
            "in the turned frame the rapid motion of {letters} needs the position of {missing}, which the program has not set"
        );
        Err(Fault::new(codes::POSITION_UNKNOWN, span, message)
            .help("program X, Y and Z by rapid motions before feed, another frame, another tool or the end"))
    }

    /// Words of a block that would change what the waiting motion means.
    pub(super) fn nothing_waits_before(&self, p: &Pending, span: Span) -> Result<(), Fault> {
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
        if changes { self.nothing_waits(span) } else { Ok(()) }
    }
}
