//! Boring with a shift of the tip off the wall: G76, G87 of a Fanuc, G77 of a Haas.
//!
//! The spindle stops oriented, and the tool moves aside in the plane: by I and J, or by Q along the first
//! axis. Which way the edge points at the oriented stop is set up on the machine; along the first axis is the
//! usual setting.

use super::cycles::Levels;
use super::interpreter::Interpreter;
use crate::SpindleDirection;
use crate::channel::Stroke;
use crate::codes;
use crate::control::FineBoring;
use crate::diagnostic::{Fault, Span};

impl Interpreter {
    /// G76: out of the hole with the tip shifted off the wall.
    pub(super) fn fine_bore(&mut self, levels: Levels, back: f64, span: Span) -> Result<(), Fault> {
        let shift = match self.settings.control.fine_boring {
            FineBoring::Refused => {
                let message = format!(
                    "`G76` of the control \"{}\" is another cycle than fine boring: it is not supported",
                    self.settings.control.name
                );
                return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message)
                    .help("let the CAM system write the motions of the cycle"));
            }
            FineBoring::ShiftMayBeLeftOut if self.own.cycle.q.is_none() && self.own.cycle.ijk == [None; 3] => [0.0; 2],
            _ => self.bore_shift("G76", span)?,
        };
        let direction = self.technology.direction;
        self.course(&[Stroke::Feed(levels.depth), Stroke::wait(self.own.cycle.p)], span)?;
        self.orient();
        self.shifted(shift, 1.0, span)?;
        self.course(&[Stroke::Rapid(back)], span)?;
        self.shifted(shift, -1.0, span)?;
        self.spindle(direction);
        Ok(())
    }

    /// G87 of a Fanuc, G77 of a Haas: down clear of the wall, up in feed.
    pub(super) fn back_bore(&mut self, levels: Levels, span: Span) -> Result<(), Fault> {
        let shift = self.bore_shift("back boring", span)?;
        let initial = Levels { initial: levels.initial, ..levels }.initial.ok_or_else(|| {
            Fault::new(
                codes::POSITION_UNKNOWN,
                span,
                "back boring comes back to the initial level, which the program has not set",
            )
            .help("program Z before the cycle")
        })?;
        let direction = match self.technology.direction {
            SpindleDirection::Off => SpindleDirection::Clockwise,
            other => other,
        };
        self.orient();
        self.shifted(shift, 1.0, span)?;
        self.course(&[Stroke::Rapid(levels.r)], span)?;
        self.shifted(shift, -1.0, span)?;
        self.spindle(direction);
        self.course(&[Stroke::Feed(levels.depth), Stroke::wait(self.own.cycle.p)], span)?;
        self.orient();
        self.shifted(shift, 1.0, span)?;
        self.course(&[Stroke::Rapid(initial)], span)?;
        self.shifted(shift, -1.0, span)?;
        self.spindle(direction);
        Ok(())
    }

    fn orient(&mut self) {
        self.note("M19");
        self.spindle_off();
    }

    /// Shift off the wall in the plane: I and J, or Q along the first axis.
    fn bore_shift(&mut self, name: &str, span: Span) -> Result<[f64; 2], Fault> {
        match (self.own.cycle.ijk, self.own.cycle.q) {
            ([None, None, None], Some(q)) => Ok([q.abs(), 0.0]),
            // A control file says whether Q may be left out; here the control is not known.
            ([None, None, None], None) if name == "G76" && self.own.assumed => {
                self.assume("G76 without Q: the tool retracts without a shift");
                Ok([0.0; 2])
            }
            ([i, j, None], _) if i.is_some() || j.is_some() => Ok([i.unwrap_or(0.0), j.unwrap_or(0.0)]),
            _ => Err(Fault::new(
                codes::MISSING_VALUE,
                span,
                format!("{name} has no shift Q, and no I and J in the plane"),
            )
            .help("write Q, or I and J")),
        }
    }

    fn shifted(&mut self, shift: [f64; 2], sign: f64, span: Span) -> Result<(), Fault> {
        if shift == [0.0; 2] {
            return Ok(());
        }
        let [u, v, _] = self.modal.plane_axes();
        let mut end = self.position.work;
        for (axis, value) in [(u, shift[0]), (v, shift[1])] {
            end.put(axis, self.known(axis, span)? + sign * value);
        }
        self.cycle_motion(end, 1 << u | 1 << v, true, span)
    }
}
