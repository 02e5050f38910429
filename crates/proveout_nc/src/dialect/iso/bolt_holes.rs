//! G70 and G71 of a Haas: the cycle in force at holes on a circle about the present position.
//!
//! Haas, *Mill operator's manual*, "G70 Bolt hole circle", "G71 Bolt hole arc": I is the radius, J the angle
//! of the first hole from the first axis of the plane, counter-clockwise, L the number of holes; G70 spreads
//! them over the whole circle, G71 by the angle K. They act in their block, with a cycle in force (`L0` in
//! its block drills no hole at the center).

use super::calls::whole;
use super::interpreter::Interpreter;
use super::pending::Pending;
use super::words::Group;
use crate::channel::finite;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::sin_cos_degrees;
use crate::g_code::{G70, GCode};

/// Most holes of one block.
const MOST_HOLES: f64 = 9999.0;

impl Interpreter {
    pub(super) fn bolt_holes(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let name = code.to_string();
        let Some(cycle) = self.modal.cycle else {
            return Err(Fault::new(codes::STRUCTURE, span, format!("{name} has no drilling cycle in force"))
                .help("write the cycle before it, with L0 where no hole is at the center"));
        };
        if p.g(Group::Cycle).is_some() || p.axes() != 0 || p.any_free(b"RQP") {
            return Err(Fault::new(codes::CONFLICT, span, format!("{name} in a block with words of a cycle or axes"))
                .help("write the cycle in a block before it"));
        }
        let missing = |letter: char| {
            Fault::new(codes::MISSING_VALUE, span, format!("{name} has no {letter}"))
                .help("write G70 I25. J0 L6, or G71 I25. J0 K30. L4")
        };
        let radius = self.length_of(p, b'I').ok_or_else(|| missing('I'))?;
        let first = p.take(b'J').unwrap_or(0.0);
        let count = whole(p.take(b'L').ok_or_else(|| missing('L'))?, "L", MOST_HOLES, span)?;
        let step =
            if code == G70 { 360.0 / f64::from(count.max(1)) } else { p.take(b'K').ok_or_else(|| missing('K'))? };
        let [u, v, normal] = self.modal.plane_axes();
        let center = [self.known(u, span)?, self.known(v, span)?];
        self.before_motion(0, p, span)?;
        if self.own.cycle.initial.is_none() {
            self.own.cycle.initial = self.position.work.get(normal);
        }
        let levels = self.levels(cycle, self.own.cycle.initial, span)?;
        for hole in 0..count {
            let (s, c) = sin_cos_degrees(first + f64::from(hole) * step);
            let mut end = self.position.work;
            end.put(u, finite(u, center[0] + radius * c, span)?);
            end.put(v, finite(v, center[1] + radius * s, span)?);
            self.cycle_motion(end, 1 << u | 1 << v, true, span)?;
            self.drill(cycle, levels, span)?;
        }
        Ok(())
    }
}
