//! Boring cycles: CYCLE85 to CYCLE88.
//!
//! Courses after Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02): Boring 1 to 4.

use super::drilling::wait;
use super::interpreter::Interpreter;
use crate::channel::milling::Heights;
use crate::channel::{Stroke, direction_of};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::Fault;
use crate::{Feed, Op, SpindleDirection};

impl Interpreter {
    /// CYCLE85: down with FFR, up with RFF.
    pub(crate) fn reaming(&mut self, h: Heights, v: &Values) -> Result<(), Fault> {
        let (down, up) = (v.get("FFR")?, v.get("RFF")?);
        let before = self.technology.feed;
        self.course(&[h.approach()], v.span)?;
        self.cycle_feed(down);
        self.course(&[h.to_depth(), wait(v.dwell()?)], v.span)?;
        self.cycle_feed(up.or(down));
        self.course(&[Stroke::Feed(h.clear)], v.span)?;
        if self.technology.feed != before {
            self.set_feed(before);
        }
        self.course(&[h.out()], v.span)
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
    fn cycle_spindle(&mut self, v: &Values) -> Result<(), Fault> {
        match v.get("SDIR")? {
            None => {}
            Some(m @ (3.0 | 4.0)) => self.turn_spindle(direction_of(m)),
            Some(other) => {
                let message = format!("the direction (SDIR) of `{}` is {other}", v.name());
                return Err(v.fault(codes::ARGUMENTS, message, "write 3 for M3 or 4 for M4"));
            }
        }
        Ok(())
    }

    /// CYCLE86: down in feed, dwell, oriented stop, lift off by RPA, RPO, RPAP, up at rapid rate, back over
    /// the hole.
    pub(crate) fn boring_with_lift(&mut self, h: Heights, v: &Values) -> Result<(), Fault> {
        let lift = [v.value("RPA")?, v.value("RPO")?, v.value("RPAP")?];
        self.course(&[h.approach()], v.span)?;
        self.cycle_spindle(v)?;
        self.course(&[h.to_depth(), wait(v.dwell()?)], v.span)?;
        self.turn_spindle(SpindleDirection::Off);
        self.note(format!("CYCLE86 orients the spindle at {} degrees", v.value("POSS")?));
        let axes = self.modal.plane_axes();
        let hole = self.position.work;
        let moved: u16 = axes.iter().zip(lift).filter(|(_, by)| *by != 0.0).map(|(axis, _)| 1 << axis).sum();
        if moved != 0 {
            let mut end = hole;
            for (&axis, by) in axes.iter().zip(lift).filter(|(_, by)| *by != 0.0) {
                let Some(now) = hole.get(axis) else {
                    let message = "CYCLE86 lifts off from an unknown position";
                    return Err(v.fault(codes::POSITION_UNKNOWN, message, "program X, Y and Z before the cycle"));
                };
                end.put(axis, now + by);
            }
            self.straight(end, moved, true, v.span)?;
        }
        self.course(&[h.out()], v.span)?;
        let plane: u16 = moved & (1 << axes[0] | 1 << axes[1]);
        if plane != 0 {
            let mut end = self.position.work;
            for axis in [axes[0], axes[1]] {
                if let Some(value) = hole.get(axis) {
                    end.put(axis, value);
                }
            }
            self.straight(end, plane, true, v.span)?;
        }
        Ok(())
    }

    /// CYCLE87 and CYCLE88: spindle and program stop at the depth, up at rapid rate.
    pub(crate) fn boring_with_stop(&mut self, h: Heights, v: &Values) -> Result<(), Fault> {
        let dwell = v.get("DTB")?;
        v.get("SDIR")?;
        self.course(&[h.approach()], v.span)?;
        self.cycle_spindle(v)?;
        self.course(&[h.to_depth(), wait(dwell)], v.span)?;
        self.turn_spindle(SpindleDirection::Off);
        self.emit(Op::Stop { optional: false });
        self.course(&[h.out()], v.span)
    }
}
