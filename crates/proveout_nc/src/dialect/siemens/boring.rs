//! Boring cycles: CYCLE85 to CYCLE89.
//!
//! Courses after Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02): Boring 1 to 5.

use super::drilling::{Planes, in_revolutions, wait};
use super::eval::Val;
use super::frames::number;
use super::interpreter::Interpreter;
use crate::channel::{Stroke, direction_of};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{Feed, Op, SpindleDirection};

impl Interpreter {
    /// CYCLE85(RTP, RFP, SDIS, DP, DPR, DTB, FFR, RFF): down with FFR, up with RFF.
    pub(crate) fn reaming(&mut self, planes: Planes, values: &[Option<Val>], span: Span) -> Result<(), Fault> {
        let (down, up) = (number(values, 6, "CYCLE85", span)?, number(values, 7, "CYCLE85", span)?);
        let before = self.technology.feed;
        self.course(&[planes.approach()], span)?;
        self.cycle_feed(down);
        let dwell = in_revolutions(number(values, 5, "CYCLE85", span)?, number(values, 10, "CYCLE85", span)?);
        self.course(&[planes.down(), wait(dwell)], span)?;
        self.cycle_feed(up.or(down));
        self.course(&[Stroke::Feed(planes.start)], span)?;
        if self.technology.feed != before {
            self.set_feed(before);
        }
        self.course(&[planes.out()], span)
    }

    fn cycle_feed(&mut self, value: Option<f64>) {
        let factor = self.modal.units.feed();
        if let Some(value) = value.filter(|v| *v > 0.0) {
            self.technology.feed = Some(match self.technology.feed {
                Some(Feed::PerRevolution(_)) => Feed::PerRevolution(value * factor),
                _ => Feed::PerTime(value * factor / 60.0),
            });
            self.tell_feed();
        }
    }

    /// Spindle direction of a boring cycle: 3 or 4.
    fn cycle_spindle(&mut self, value: Option<f64>, name: &str, span: Span) -> Result<(), Fault> {
        let direction = match value {
            None => return Ok(()),
            Some(m @ (3.0 | 4.0)) => direction_of(m),
            Some(other) => {
                return Err(Fault::new(codes::ARGUMENTS, span, format!("the direction (SDIR) of `{name}` is {other}"))
                    .help("write 3 for M3 or 4 for M4"));
            }
        };
        self.turn_spindle(direction);
        Ok(())
    }

    /// CYCLE86(RTP, RFP, SDIS, DP, DPR, DTB, SDIR, RPA, RPO, RPAP, POSS): down in feed, dwell, oriented stop, lift off by
    /// RPA, RPO, RPAP, up at rapid rate, back over the hole.
    pub(crate) fn boring_with_lift(&mut self, planes: Planes, values: &[Option<Val>], span: Span) -> Result<(), Fault> {
        const NAME: &str = "CYCLE86";
        let value = |at: usize| number(values, at, NAME, span);
        let length = self.modal.units.length();
        let lift = [value(7)?, value(8)?, value(9)?].map(|v| v.unwrap_or(0.0) * length);
        self.course(&[planes.approach()], span)?;
        self.cycle_spindle(value(6)?, NAME, span)?;
        self.course(&[planes.down(), wait(in_revolutions(value(5)?, value(13)?))], span)?;
        self.turn_spindle(SpindleDirection::Off);
        self.note(format!("CYCLE86 orients the spindle at {} degrees", value(10)?.unwrap_or(0.0)));
        let axes = self.modal.plane_axes();
        let hole = self.position.work;
        let moved: u16 = axes.iter().zip(lift).filter(|(_, by)| *by != 0.0).map(|(axis, _)| 1 << axis).sum();
        if moved != 0 {
            let mut end = hole;
            for (&axis, by) in axes.iter().zip(lift).filter(|(_, by)| *by != 0.0) {
                let Some(now) = hole.get(axis) else {
                    return Err(Fault::new(
                        codes::POSITION_UNKNOWN,
                        span,
                        "CYCLE86 lifts off from an unknown position",
                    )
                    .help("program X, Y and Z before the cycle"));
                };
                end.put(axis, now + by);
            }
            self.straight(end, moved, true, span)?;
        }
        self.course(&[planes.out()], span)?;
        let plane: u16 = moved & (1 << axes[0] | 1 << axes[1]);
        if plane != 0 {
            let mut end = self.position.work;
            for axis in [axes[0], axes[1]] {
                if let Some(value) = hole.get(axis) {
                    end.put(axis, value);
                }
            }
            self.straight(end, plane, true, span)?;
        }
        Ok(())
    }

    /// CYCLE87(RTP, RFP, SDIS, DP, DPR, SDIR) and CYCLE88(RTP, RFP, SDIS, DP, DPR, DTB, SDIR): spindle and program stop at
    /// the depth, up at rapid rate.
    pub(crate) fn boring_with_stop(
        &mut self,
        name: &str,
        planes: Planes,
        values: &[Option<Val>],
        span: Span,
    ) -> Result<(), Fault> {
        let dwell = if name == "CYCLE88" { number(values, 5, name, span)? } else { None };
        let direction = number(values, if name == "CYCLE88" { 6 } else { 5 }, name, span)?;
        self.course(&[planes.approach()], span)?;
        self.cycle_spindle(direction, name, span)?;
        self.course(&[planes.down(), wait(dwell)], span)?;
        self.turn_spindle(SpindleDirection::Off);
        self.emit(Op::Stop { optional: false });
        self.course(&[planes.out()], span)
    }

    /// CYCLE89(RTP, RFP, SDIS, DP, DPR, DTB): down, dwell and up in the same feed.
    pub(crate) fn boring_in_and_out(
        &mut self,
        planes: Planes,
        values: &[Option<Val>],
        span: Span,
    ) -> Result<(), Fault> {
        let dwell = wait(number(values, 5, "CYCLE89", span)?);
        self.course(&[planes.approach(), planes.down(), dwell, Stroke::Feed(planes.start), planes.out()], span)
    }
}
