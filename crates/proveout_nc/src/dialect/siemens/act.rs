//! What a block does, once all of its words are known.
//!
//! Order within a block: G words and frames, transformation, feed, speed, tool and edge, functions
//! before the motion (M3 M4 M6 M7 M8 M19 and machine-builder functions), compensation, motion or
//! dwell, functions after the motion (M5 M9 M0 M1), cycle or subprogram call, end of program.

use std::sync::Arc;

use super::parser::{Call, SiemensBlock, WordKind};
use super::pending::Pending;
use super::run_state::Interpreter;
use crate::codes;
use crate::diagnostic::{Fault, FaultSubject, Span};
use crate::machine_data::KinematicsKind;

use super::block::LINEAR;

impl Interpreter {
    pub(super) fn act(&mut self, p: &mut Pending, block: &SiemensBlock) -> Result<(), Fault> {
        let span = block.span;
        if self.own.first_line.is_some() {
            self.second_line(p, span)?;
        }
        if !self.own.held.is_empty() {
            self.forget_kept_before(p);
        }
        if p.machine_axes != 0 && p.fixed_point.is_none() || p.fixed_point_number.is_some() && p.fixed_point.is_none() {
            let message = "a machine axis name, such as X1=, or FP= without G74 or G75";
            return Err(Fault::new(codes::UNKNOWN_WORD, span, message).help("write the axis as X, Y, Z, A, B or C"));
        }
        // Plain blocks, which make up nearly all of a program, have none of them.
        if p.may_be_left() {
            self.without_use(p, span)?;
        }
        if let Some(code) = p.limits {
            self.note(limits_text(code, p));
            return Ok(());
        }
        if let Some(percent) = p.feed_override {
            self.feed_override(percent, span)?;
        }
        if let Some(code) = p.pole {
            return self.set_pole(code, p, span);
        }
        if p.polar_angle.is_some() || p.polar_radius.is_some() {
            self.resolve_polar(p, span)?;
        }
        if let Some(angle) = p.angle {
            self.resolve_angle(p, angle, span)?;
        }
        if let Some(rounding) = p.rounding {
            self.rounding_word(rounding, span)?;
        }
        if let Some(offset) = p.offset {
            self.work_offset(offset);
        }
        if let Some((word, frame_span)) = p.frame {
            if p.machine || p.has_orientation() || p.has_center() {
                return Err(Fault::new(
                    codes::CONFLICT,
                    frame_span,
                    format!("`{}` cannot share a block with a motion", word.name()),
                )
                .help("write the frame in a block of its own"));
            }
            self.frame_instruction(word, p, frame_span)?;
        }
        if let Some(on) = p.transformation {
            if on {
                let word = p.transformation_word.as_deref().unwrap_or("TRAORI");
                self.settings.check_kinematics(KinematicsKind::Tcp, word, span)?;
            }
            let before = self.own.tcp();
            self.own.tool_axis = None;
            self.own.transformed = on;
            self.tell_tcp();
            if before != self.own.tcp() {
                self.position.forget(LINEAR);
            }
        }
        if let Some(wanted) = p.tool_frame {
            self.tool_frame(wanted, p, span)?;
        }
        if !p.dwell {
            self.feed_word(p, span)?;
            self.speed_word(p, span)?;
        }
        if let Some(tool) = &p.tool {
            self.select_tool(tool.clone());
        }
        if let Some(edge) = p.edge {
            self.edge(edge);
        }
        if !p.functions.is_empty() {
            self.functions_before(p, span)?;
        }
        if let Some(side) = p.compensation {
            self.compensate(side, span)?;
        }
        if p.corner_feed.is_some() && self.corner_of(p, span)?.is_none() {
            self.note("FRC= has no effect: the block has neither chamfer nor rounding");
        }
        if p.dwell {
            self.dwell(p, span)?;
        } else if let Some(code) = p.fixed_point {
            self.fixed_point(code, p, span)?;
        } else if p.frame.is_none() && (p.has_axis() || p.has_orientation() || p.has_center() || p.opening.is_some()) {
            if p.positioning {
                self.positioning(p, span)?;
            } else {
                let before = self.block_feed(p, span)?;
                self.motion_with_corner(p, span)?;
                if self.own.transformed {
                    self.keep_tool_axis(p, span)?;
                }
                if let Some(before) = before {
                    self.set_feed(before);
                }
            }
        }
        if !p.functions.is_empty() {
            self.functions_after(p);
        }
        self.calls(p, block)?;
        if p.functions.iter().any(|m| matches!(m, 2 | 17 | 30)) {
            self.end_or_return();
        }
        Ok(())
    }

    pub(super) fn calls(&mut self, p: &Pending, block: &SiemensBlock) -> Result<(), Fault> {
        let passes = p.passes.unwrap_or(1);
        if p.passes.is_some() && p.call.is_none() && p.numbered_call.is_none() {
            return Err(Fault::new(codes::UNKNOWN_WORD, block.span, "`P` has no subprogram in its block")
                .help("write P with a subprogram call, such as L100 P3"));
        }
        if let Some(number) = p.numbered_call
            && passes > 0
        {
            let call = Call { name: format!("L{number}"), arguments: None };
            if !self.call_subprogram(&call, passes, block.span)? {
                self.missing(&call.name, block.span)?;
            }
        }
        if let Some(name) = &p.listed_call {
            let call = Call { name: name.clone(), arguments: None };
            if !self.call_subprogram(&call, 1, block.span)? {
                self.missing(&call.name, block.span)?;
            }
        }
        if let Some(word) = p.call.and_then(|at| block.words.get(at)) {
            let call = match &word.kind {
                WordKind::Call(call) => call.clone(),
                WordKind::Name(name) => Call { name: name.clone(), arguments: None },
                _ => return Ok(()),
            };
            if passes > 0 {
                self.run_call(&call, p.passes, word.span)?;
            }
        } else if p.has_axis()
            && p.frame.is_none()
            && !p.machine
            && p.fixed_point.is_none()
            && let Some(modal) = self.own.modal_call.clone()
            && modal.level == self.depth()
        {
            let file = Arc::clone(&self.location.file);
            self.run_call(&modal.call, None, block.span).map_err(|fault| modal.at_call(fault, &file))?;
        }
        Ok(())
    }

    pub(super) fn run_call(&mut self, call: &Call, passes: Option<u32>, span: Span) -> Result<(), Fault> {
        if self.run_cycle(call, span)? {
            return match passes {
                None => Ok(()),
                Some(_) => Err(Fault::new(codes::CONFLICT, span, format!("`{}` does not take `P`", call.name))
                    .help("remove P, or write the cycle once for each pass")),
            };
        }
        if self.call_subprogram(call, passes.unwrap_or(1), span)? {
            return Ok(());
        }
        if self.settings.missing_subprogram.is_some() {
            return self.missing(&call.name, span);
        }
        let name = &call.name;
        let message = format!("unknown word `{name}`");
        let help = format!("it is not a word of the 840D reader, and the folder of the program has no {name}.SPF");
        let subject = FaultSubject::UnknownWord(name.to_string());
        Err(Fault::new(codes::UNKNOWN_WORD, span, message).help(help).about(Some(subject)))
    }
}

/// Limits of the working area or of the spindle speed, for a note.
fn limits_text(code: u32, p: &Pending) -> String {
    let mut text = format!("G{code}");
    for (letter, coordinate) in crate::AXIS_LETTERS.iter().zip(&p.axes) {
        if let Some(coordinate) = coordinate {
            text.push_str(&format!(" {letter}{}", coordinate.value));
        }
    }
    if let Some(speed) = p.speed {
        text.push_str(&format!(" S{speed}"));
    }
    text
}
