//! Contours of milling cycles: a subprogram, or the blocks between two labels, run for its path in the
//! working plane alone.
//!
//! ```text
//!   CYCLE72("PART", ..)            the subprogram PART, else the blocks between the labels
//!                                  E_LAB_A_PART: and E_LAB_E_PART:
//!   CYCLE72("PIECE:PIECE_E", ..)   the blocks from the label PIECE: to the label PIECE_E:,
//!                                  both lines included
//!   CYCLE62("PART",1,,)            names a contour for the next cycle; with 2 by the labels
//!                                  of arguments 3 and 4
//! ```
//!
//! After Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02), "Programming the contour": the first
//! block is the start point, G0 or G1 in the plane with G90; lines, arcs, chamfers and roundings follow.
//! CYCLE62 and the labels of the editor from memory.

use std::sync::Arc;

use super::run_state::{CallLevel, Interpreter, Loaded, Named, Siemens};
use crate::channel::Language;
use crate::channel::ProgramSection;
use crate::channel::corners::CornerLanguage;
use crate::channel::doubt::Stage;
use crate::channel::shape::{Leg, Pass, Point};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::{Fault, Span};
use crate::{Command, Feed, Op};

/// Most blocks of a contour.
const MAX_BLOCKS: usize = 20_000;
/// Ends closer than this are one point, mm.
const SAME_MM: f64 = 1e-9;

impl Named {
    /// `"PART"` or `"FIRST:LAST"`.
    pub(super) fn of(text: &str) -> Self {
        let upper = text.trim().to_ascii_uppercase();
        match upper.split_once(':') {
            Some((first, last)) => Self::Labels(first.trim().to_owned(), last.trim().to_owned()),
            None => Self::Program(upper),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Program(name) => name.clone(),
            Self::Labels(first, last) => format!("{first}:{last}"),
        }
    }
}

impl Interpreter {
    /// CYCLE62
    pub(super) fn contour_call(&mut self, v: &Values) -> Result<(), Fault> {
        let missing = |what: &str| {
            let message = format!("`CYCLE62` has no {what}");
            v.fault(codes::ARGUMENTS, message, "write CYCLE62(\"PART\",1,,) or CYCLE62(,2,\"FIRST\",\"LAST\")")
        };
        let named = match v.value("TYPE")? {
            0.0 | 1.0 => Named::of(v.text("KNAME").ok_or_else(|| missing("name of a contour (argument 1)"))?),
            2.0 => {
                let label = |name: &str| v.text(name).map(|text| text.trim().to_ascii_uppercase());
                match (label("LAB1"), label("LAB2")) {
                    (Some(first), Some(last)) => Named::Labels(first, last),
                    _ => return Err(missing("two labels (arguments 3 and 4)")),
                }
            }
            other => {
                let message = format!("`CYCLE62` with the kind of call {other} (argument 2) is not supported");
                let help = "0 is a subprogram, 1 a contour of this program, 2 two labels of this program";
                return Err(v.fault(codes::UNSUPPORTED_WORD, message, help));
            }
        };
        self.note(format!("CYCLE62: contour {}", named.text()));
        self.own.contours.push(named);
        Ok(())
    }

    /// The contour that the argument names, or else the one called by CYCLE62.
    pub(super) fn named_contour(&mut self, v: &Values) -> Result<Named, Fault> {
        let called = std::mem::take(&mut self.own.contours);
        if let Some(text) = v.text("KNAME") {
            return Ok(Named::of(text));
        }
        match called.as_slice() {
            [one] => Ok(one.clone()),
            [] => {
                let message = format!("`{}` names no contour (argument 1)", v.name());
                Err(v.fault(codes::ARGUMENTS, message, "write its name, or call it with CYCLE62 before the cycle"))
            }
            more => {
                let message = format!("`{}` mills one contour, and CYCLE62 has called {}", v.name(), more.len());
                Err(v.fault(codes::UNSUPPORTED_WORD, message, "call one contour before each cycle"))
            }
        }
    }

    fn section_of(&mut self, named: &Named, span: Span) -> Result<(Arc<Loaded>, ProgramSection), Fault> {
        let (first, last) = match named {
            Named::Program(name) => {
                if let Some(found) = self.find_subprogram(name, span)? {
                    return Ok(found);
                }
                (format!("E_LAB_A_{name}"), format!("E_LAB_E_{name}"))
            }
            Named::Labels(first, last) => (first.clone(), last.clone()),
        };
        let missing = |what: &str| {
            Fault::new(codes::SUBPROGRAM, span, format!("contour `{}` not found: {what}", named.text()))
                .help("put it into the folder of the program as a subprogram, or between two labels of this program")
        };
        let Some(level) = self.stack.last() else { return Err(missing("no program runs")) };
        let (loaded, at) = (Arc::clone(&level.loaded), level.section.start);
        let label = |name: &str, interpreter: &mut Self| {
            interpreter
                .find_target(&loaded, at, name, true)
                .or_else(|| interpreter.find_target(&loaded, at, name, false))
        };
        let from = label(&first, self).ok_or_else(|| match named {
            Named::Program(name) => missing(&format!("there is no subprogram {name}.SPF and no label {first}")),
            Named::Labels(..) => missing(&format!("there is no label {first}")),
        })?;
        let to = self
            .find_target(&loaded, from, &last, true)
            .ok_or_else(|| missing(&format!("there is no label {last} after {first}")))?;
        let end = loaded.source.line(to).map_or(to, |(_, next)| next).offset;
        Ok((loaded, ProgramSection { start: from, end }))
    }

    /// The path of a contour in the working plane, work coordinates. The state of the program does
    /// not change.
    pub(super) fn contour(&mut self, named: &Named, span: Span) -> Result<Pass, Fault> {
        if self.own.in_contour {
            return Err(wrong(named, "it is called within another contour", span));
        }
        let (loaded, section) = self.section_of(named, span)?;
        self.room_for_call(&format!("the contour `{}` is called", named.text()), span)?;
        let queue = std::mem::take(&mut self.queue);
        let corners = std::mem::take(self.own.corners());
        let (position, technology, location) = (self.position.clone(), self.technology.clone(), self.location.clone());
        let (tangent, modal_call) = (self.own.tangent, self.own.modal_call.take());
        let modal = self.modal.clone();
        // A contour needs no feed of its own.
        self.technology.feed = self.technology.feed.or(Some(Feed::PerTime(1.0)));
        let depth = self.stack.len();
        self.variables.enter();
        self.enter((loaded, section), section.start, 1, CallLevel::default());
        self.own.contour_torn = false;
        self.own.in_contour = true;
        let commands = self.run_to_depth(depth, named, span);
        self.own.in_contour = false;
        self.recovery.faults.stage = Stage::Acting;
        while self.stack.len() > depth {
            self.stack.pop();
            self.variables.leave();
        }
        let changed = self.modal.frames.total() != modal.frames.total();
        (self.queue, *self.own.corners()) = (queue, corners);
        (self.position, self.technology, self.location) = (position, technology, location);
        (self.own.tangent, self.own.modal_call, self.modal) = (tangent, modal_call, modal);
        self.done = false;
        let commands = commands?;
        if changed {
            return Err(wrong(named, "it changes the frame", span));
        }
        self.path_of(named, &commands, span)
    }

    fn run_to_depth(&mut self, depth: usize, named: &Named, span: Span) -> Result<Vec<Command>, Fault> {
        let mut commands = Vec::new();
        let mut blocks = 0;
        loop {
            let over = self.stack.len() <= depth;
            // What waits for the next block is emitted as at the end of a program.
            self.done = over;
            while let Some(command) = Siemens::hand_out(self) {
                commands.push(command);
            }
            if let Some(failure) = self.failure.take() {
                return Err(wrong(named, &format!("line {}: {}", failure.line, failure.message), span));
            }
            if over {
                return Ok(commands);
            }
            blocks += 1;
            if blocks > MAX_BLOCKS || commands.len() > 10 * MAX_BLOCKS {
                return Err(wrong(named, &format!("it has more than {MAX_BLOCKS} blocks"), span));
            }
            if let Err(fault) = Siemens::step(self) {
                self.recovery.failed = None;
                // A line that cannot be read, or with a word that is always refused, is reported
                // separately.
                self.own.contour_torn = self.recovery.faults.stage != Stage::Acting;
                return Err(wrong(named, &format!("line {}: {}", fault.line, fault.message), span));
            }
        }
    }

    fn path_of(&self, named: &Named, commands: &[Command], span: Span) -> Result<Pass, Fault> {
        let [u, v, w] = self.modal.plane_axes();
        let mut path: Option<Pass> = None;
        for command in commands {
            let (motion, arc) = match &command.op {
                Op::Rapid(motion) | Op::Linear(motion) => (motion, None),
                Op::Arc(arc) => (&arc.motion, Some(arc)),
                Op::Spline(_) | Op::Probe(_) | Op::Thread(_) | Op::Retract(_) => {
                    return Err(wrong(named, "a contour is made of lines and arcs", span));
                }
                Op::CutterComp(_) | Op::Tool(_) | Op::Tcp(_) | Op::End => {
                    let what = "it changes the tool, the compensation or the transformation, or ends the program";
                    return Err(wrong(named, what, span));
                }
                _ => continue,
            };
            if motion.machine_coordinates || motion.programmed & !(1 << u | 1 << v) != 0 {
                return Err(wrong(named, "it moves another axis than the two of the working plane", span));
            }
            let (Some(x), Some(y)) = (motion.end.get(u), motion.end.get(v)) else {
                return Err(wrong(named, "its first block must set both coordinates of the plane", span));
            };
            let to: Point = [x, y];
            let Some(path) = &mut path else {
                if arc.is_some() {
                    return Err(wrong(named, "it begins with an arc, and the first block is its start point", span));
                }
                path = Some(Pass { start: to, legs: Vec::new() });
                continue;
            };
            let from = path.end();
            match arc {
                Some(arc) => {
                    if arc.normal[w].abs() < 0.5 || arc.sweep > std::f64::consts::TAU + SAME_MM {
                        return Err(wrong(
                            named,
                            "an arc lies outside of the working plane or has several turns",
                            span,
                        ));
                    }
                    let center = [arc.center[u], arc.center[v]];
                    path.legs.push(Leg::Arc { to, center, clockwise: arc.normal[w] < 0.0 });
                }
                None if (to[0] - from[0]).hypot(to[1] - from[1]) <= SAME_MM => {}
                None => path.legs.push(Leg::Line(to)),
            }
        }
        path.filter(|path| !path.legs.is_empty()).ok_or_else(|| wrong(named, "it has fewer than two points", span))
    }
}

fn wrong(named: &Named, what: &str, span: Span) -> Fault {
    Fault::new(codes::SUBPROGRAM, span, format!("the contour `{}` cannot be milled: {what}", named.text()))
        .help("a contour is its start point and lines and arcs in the working plane, with chamfers and roundings")
}
