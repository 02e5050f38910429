//! Boring with a bar that moves off the wall or off its edge: cycles 202 and 204.
//!
//! Courses after HEIDENHAIN, *TNC 640 Programming of machining cycles*, "Boring" and "Back boring". Cycle 204
//! cuts a counterbore from below, through a hole that is there before:
//!
//! ```text
//!        |  |bar|  |   <- Q251     Q203                      surface
//!   _____|  |   |  |_____
//!   #####|  |   |  |#####          Q203 - Q250               underside of the workpiece
//!   #####|  |___|  |#####
//!         __|   |__           Q249 above the underside: the counterbore
//!        |edge     |          the edge lies Q252 above the tip; below the workpiece it keeps Q200
//!           |___|             tip: lowest at Q203 - Q250 - Q200 - Q252
//! ```
//!
//! The spindle stops at the angle Q336. The bar moves off its edge by Q251 in the direction Q214, down
//! through the hole and back to its middle. The spindle turns and the bar cuts upward by Q200 + Q249,
//! dwells (Q255) and comes down again; then it leaves the hole as it came. The manual names the feeds
//! Q253 (positioning) and Q254 (counterbore), and none for the way down out of the counterbore: Q253 is
//! taken, and said.

use super::interpreter::Interpreter;
use super::motion::Goal;
use crate::channel::Stroke;
use crate::channel::milling::Heights;
use crate::codes;
use crate::cycle::{Values, heidenhain as table};
use crate::diagnostic::Fault;
use crate::{Feed, SpindleDirection};

/// Retraction of the boring bar from the wall in cycle 202, mm: fixed in the control.
const FREE_MM: f64 = 0.2;

/// Lowest position of the tip in cycle 204, from the surface.
pub(super) fn lowest(v: &Values) -> Result<f64, Fault> {
    Ok(-(v.value(250)? + v.value(252)? + v.value(200)?))
}

/// Checks the parameters of cycle 204 when it is defined.
pub(super) fn check_back_boring(v: &Values) -> Result<(), Fault> {
    let height = v.value(249)?;
    if height == 0.0 {
        let message = "the depth Q249 of cycle 204 is zero";
        return Err(v.fault(codes::ARGUMENTS, message, "write the depth of the counterbore, above zero"));
    }
    if height < 0.0 {
        let remedy = "the counterbore runs upward from the underside: write a depth above zero";
        return Err(super::lexer::refused(&format!("Q249={height} of cycle 204"), v.span, remedy));
    }
    for key in [250, 251, 252] {
        let value = v.value(key)?;
        if value.is_nan() || value <= 0.0 {
            let message = format!("Q{key} of cycle 204 is {value}");
            return Err(v.fault(codes::ARGUMENTS, message, "write a length above zero"));
        }
    }
    for key in [253, 254] {
        if v.given(key).is_none() {
            return Err(v.missing(&table::parameter(key)));
        }
    }
    match v.value(214)? {
        1.0 | 2.0 | 3.0 | 4.0 => Ok(()),
        way => Err(v.fault(codes::ARGUMENTS, format!("Q214 takes 1 to 4 and has {way}"), "write 1 to 4")),
    }
}

impl Interpreter {
    /// 202: orients the spindle, moves the bar off the wall, retracts it and brings it back to the
    /// middle.
    pub(super) fn bore_back(&mut self, v: &Values, h: Heights, down: Option<Feed>) -> Result<(), Fault> {
        let span = v.span;
        let direction = self.technology.direction;
        self.orient_spindle(v)?;
        let off = self.off_wall(v, FREE_MM)?;
        let up = self.retraction_feed(v, down)?;
        self.aside(v, off, 1.0)?;
        self.course(&[Stroke::at(h.clear, up), Stroke::Rapid(h.second)], span)?;
        self.aside(v, off, -1.0)?;
        self.turn_spindle(direction);
        Ok(())
    }

    /// 204: down through the hole beside its middle, counterbore upward, and out the same way.
    pub(super) fn back_bore(&mut self, v: &Values, h: Heights) -> Result<(), Fault> {
        let span = v.span;
        let direction = self.technology.direction;
        let cutting = if direction == SpindleDirection::Off { SpindleDirection::Clockwise } else { direction };
        let off = self.off_wall(v, v.value(251)?)?;
        let (through, cut) = (self.cycle_feed(v, 253)?, self.cycle_feed(v, 254)?);
        let top = h.depth + v.value(200)? + v.value(249)?;
        self.orient_spindle(v)?;
        self.aside(v, off, 1.0)?;
        self.course(&[Stroke::at(h.depth, through)], span)?;
        self.aside(v, off, -1.0)?;
        self.turn_spindle(cutting);
        let up = [Stroke::at(top, cut), Stroke::wait(Some(v.value(255)?)), Stroke::at(h.depth, through)];
        self.course(&up, span)?;
        self.orient_spindle(v)?;
        self.aside(v, off, 1.0)?;
        self.course(&[Stroke::at(h.clear, through)], span)?;
        self.aside(v, off, -1.0)?;
        self.turn_spindle(direction);
        Ok(())
    }

    fn orient_spindle(&mut self, v: &Values) -> Result<(), Fault> {
        let angle = v.value(336)?;
        self.turn_spindle(SpindleDirection::Off);
        self.note(format!("spindle oriented to {angle} degrees"));
        Ok(())
    }

    /// Axis and way of a displacement in the direction Q214; none for 0.
    fn off_wall(&self, v: &Values, by: f64) -> Result<Option<(usize, f64)>, Fault> {
        let [first, second, _] = self.modal.plane_axes();
        Ok(match v.value(214)? {
            0.0 => None,
            1.0 => Some((first, -by)),
            2.0 => Some((second, -by)),
            3.0 => Some((first, by)),
            4.0 => Some((second, by)),
            way => return Err(v.fault(codes::ARGUMENTS, format!("Q214 takes 0 to 4 and has {way}"), "write 0 to 4")),
        })
    }

    /// Moves the bar by a displacement, or back.
    fn aside(&mut self, v: &Values, off: Option<(usize, f64)>, sign: f64) -> Result<(), Fault> {
        let Some((axis, by)) = off else { return Ok(()) };
        let Some(now) = self.position.work.get(axis) else {
            let message = format!("cycle {} needs the position in the working plane", v.name());
            return Err(v.fault(codes::POSITION_UNKNOWN, message, "program X and Y before the cycle"));
        };
        let mut goal = Goal { end: self.position.work, programmed: 1 << axis, tool_axis: None };
        goal.end.put(axis, now + sign * by);
        self.straight(goal, true, v.span)
    }
}
