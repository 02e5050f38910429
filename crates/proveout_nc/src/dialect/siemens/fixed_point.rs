//! G74 and G75: to the reference point and to a fixed point of the machine.
//!
//! ```text
//!   G74 Z1=0            reference point of the machine axis Z1
//!   G75 FP=2 X1=0 Y1=0  fixed point 2 of X1 and Y1; FP=1 without FP
//! ```
//!
//! The values after the axes have no meaning. The axes are named by the machine (`X1`) or by their
//! letter. Offsets, frames and the tool length do not count. After Siemens, *Programming Manual
//! Fundamentals* (840D sl), "Reference point approach (G74)" and "Approaching a fixed point (G75)":
//! the points are machine data of each axis (MD34100, MD30600). The twin has the two reference
//! points of the machine file; a program that is read without a machine goes to machine zero, with
//! a note, as G28 does.

use super::block::LINEAR;
use super::pending::Pending;
use super::run_state::Interpreter;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{AxisValues, Offset, Op};

impl Interpreter {
    pub(super) fn fixed_point(&mut self, code: u32, p: &Pending, span: Span) -> Result<(), Fault> {
        let word = format!("G{code}");
        if p.has_orientation() || p.has_center() || p.machine || p.frame.is_some() {
            return Err(Fault::new(codes::CONFLICT, span, format!("`{word}` in a block with words of another motion"))
                .help("write it in a block of its own"));
        }
        if self.own.tcp() {
            let message = format!("`{word}` under TRAORI or in a swivel plane is not supported");
            return Err(
                Fault::new(codes::UNSUPPORTED_WORD, span, message).help("write TRAFOOF and CYCLE800() before it")
            );
        }
        if p.programmed == 0 {
            return Err(Fault::new(codes::MISSING_VALUE, span, format!("`{word}` names no axis"))
                .help(format!("write {word} Z1=0, in a block of its own")));
        }
        let which = p.fixed_point_number.unwrap_or(1.0);
        if code == 74 && p.fixed_point_number.is_some() || ![1.0, 2.0].contains(&which) {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`{word} FP={which}` is not supported"))
                .help("FP=1 and FP=2 of G75 are the two reference points of the machine file; program SUPA G0 with coordinates"));
        }
        let mut end = AxisValues::NONE;
        let points = self.settings.reference_points.clone();
        for axis in (0..9usize).filter(|axis| p.programmed >> axis & 1 == 1) {
            let value = match &points {
                Some(points) => Self::stated_reference(points, which == 2.0, axis, &word, span)?,
                None => 0.0,
            };
            end.put(axis, value);
        }
        match &points {
            None => self.note(format!("{word} FP={which}: the point is taken as machine zero, where no machine is named that states it")),
            Some(_) if code == 75 => self.assume(format!(
                "{word} FP={which} goes to the {} reference point of the machine file; on the control it is a machine data of its own (MD30600)",
                if which == 2.0 { "second" } else { "first" }
            )),
            Some(_) => {}
        }
        // The axes without the tool length.
        let edge = self.own.edge.filter(|edge| *edge > 0);
        if edge.is_some() {
            self.emit(Op::Offset(Offset::ToolEdge { edge: 0 }));
        }
        self.position.moved_in_machine(&end, p.programmed, false);
        self.own.tangent = None;
        self.go_in_machine(end, p.programmed, true, true);
        if let Some(edge) = edge {
            self.emit(Op::Offset(Offset::ToolEdge { edge }));
        }
        self.position.forget(p.programmed & LINEAR);
        Ok(())
    }
}
