//! Motions in machine coordinates: G53, G28, G30; words that act once.

use super::interpreter::Interpreter;
use super::modal::{Length, MotionMode};
use super::pending::{AXES, Pending};
use super::words::Group;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{AxisValues, Motion, Offset, Op};

/// Numbers of the parameters that hold the reference points of G28 and G30 (`LinuxCNC`; the settings give them for the others).
const FIRST_REFERENCE: u32 = 5161;
const SECOND_REFERENCE: u32 = 5181;

impl Interpreter {
    /// A word that acts in its block only.
    pub(crate) fn one_shot(&mut self, code: u32, p: &mut Pending, span: Span) -> Result<(), Fault> {
        match code {
            50 | 51 => {
                // High-speed and smoothing modes of a Fanuc: where corners go is the tolerance of the machine.
                let mut text = if code == 50 { "G5".to_owned() } else { "G5.1".to_owned() };
                for letter in *b"PQRXYZABC" {
                    if let Some(value) = p.take(letter) {
                        text.push_str(&format!(" {}{value}", char::from(letter)));
                    }
                }
                self.note(text);
            }
            100 => self.write_data(p, span)?,
            280 => self.reference(p, "G28", FIRST_REFERENCE, span)?,
            300 => self.reference(p, "G30", SECOND_REFERENCE, span)?,
            281 => self.store_reference(FIRST_REFERENCE, span)?,
            301 => self.store_reference(SECOND_REFERENCE, span)?,
            310 => {
                self.before_motion(p.axes(), p, span)?;
                self.probe(p, 310, span)?;
            }
            520 | 920..=923 => self.shift_word(code, p, span)?,
            530 => self.machine_block(p, span)?,
            531 => self.turn_to_plane(p, span)?,
            _ => {}
        }
        Ok(())
    }

    /// G53: coordinates of the machine axes, only the programmed ones move.
    fn machine_block(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let axes = p.axes();
        if axes == 0 {
            return Ok(());
        }
        if self.modal.incremental && !self.flavor.is_linuxcnc() {
            return Err(Fault::new(
                codes::POSITION_UNKNOWN,
                span,
                "G53 with G91: the control ignores the word or the increment",
            )
            .help("write G90 G53"));
        }
        let rapid = match self.modal.motion {
            Some(MotionMode::Rapid) => true,
            Some(MotionMode::Linear) => self.flavor == super::flavor::Flavor::Fanuc,
            None if !self.flavor.is_linuxcnc() => true,
            _ if self.flavor == super::flavor::Flavor::Fanuc => true,
            _ => {
                return Err(
                    Fault::new(codes::CONFLICT, span, "G53 needs G0 or G1 in force").help("write G0 or G1 with G53")
                );
            }
        };
        let mut end = AxisValues::NONE;
        for (axis, &letter) in AXES.iter().enumerate().filter(|(axis, _)| axes >> axis & 1 == 1) {
            let rotary = (3..6).contains(&axis);
            let value = if rotary { p.take(letter).map(f64::to_radians) } else { self.length_of(p, letter) };
            end.put(axis, value.unwrap_or(0.0));
        }
        self.nothing_held(span)?;
        self.begin_motion();
        if !rapid {
            self.need_feed(axes, span)?;
        }
        let exact_stop = p.g(Group::ExactStop).is_some();
        self.machine_motion(end, axes, rapid, exact_stop);
        Ok(())
    }

    /// Machine coordinates are those of the axes without tool length: the length goes out of effect for the motion.
    fn machine_motion(&mut self, end: AxisValues, axes: u16, rapid: bool, exact_stop: bool) {
        let edge = match self.modal.length {
            Length::Edge(edge) if edge > 0 => Some(edge),
            _ => None,
        };
        if edge.is_some() {
            self.emit(Op::Offset(Offset::ToolEdge { edge: 0 }));
        }
        self.position.moved_in_machine(&end, axes);
        let motion = Motion {
            end,
            end_base: end,
            tool_axis: None,
            tool_axis_base: None,
            programmed: axes,
            machine_coordinates: true,
            exact_stop,
        };
        self.begin_motion();
        self.emit(if rapid { Op::Rapid(motion) } else { Op::Linear(motion) });
        if let Some(edge) = edge {
            self.emit(Op::Offset(Offset::ToolEdge { edge }));
        }
    }

    /// G28 and G30: by rapid to the intermediate point, then to the reference point of the programmed axes.
    fn reference(&mut self, p: &mut Pending, word: &str, first: u32, span: Span) -> Result<(), Fault> {
        p.use_up(if word == "G30" { b"P" } else { b"" });
        if let Some(which) = p.peek(b'P').filter(|&which| word == "G30" && which != 2.0) {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`G30 P{which}` is not supported"))
                .help("program the point with G53"));
        }
        let mut axes = p.axes();
        self.nothing_held(span)?;
        self.begin_motion();
        if axes == 0 {
            if self.flavor == super::flavor::Flavor::Fanuc {
                return Err(Fault::new(codes::MISSING_VALUE, span, format!("{word} names no axis"))
                    .help(format!("write G91 {word} Z0")));
            }
            // All axes that the program uses.
            axes = 0b111;
            for axis in 3..9 {
                axes |= u16::from(self.position.base.get(axis).is_some()) << axis;
            }
        } else {
            let before = self.position.work;
            let (end, programmed) = self.targets(p, span)?;
            let moves = (0..9).any(|axis| programmed >> axis & 1 == 1 && end.get(axis) != before.get(axis));
            if moves {
                self.before_motion(programmed, p, span)?;
                let motion = self.complete(end, programmed, false, span)?;
                self.go(motion, true);
            }
        }
        let mut end = AxisValues::NONE;
        let mut given = true;
        for axis in (0..9usize).filter(|axis| axes >> axis & 1 == 1) {
            let value = self.variables.numbered(first + axis as u32);
            given &= value.is_some();
            let value = value.unwrap_or(0.0);
            end.put(axis, if (3..6).contains(&axis) { value.to_radians() } else { value });
        }
        if !given && !self.noted_references.contains(&first) {
            self.noted_references.push(first);
            self.note(format!(
                "{word}: the reference point is taken as machine zero; #{first} and up of the settings give another"
            ));
        }
        self.machine_motion(end, axes, true, false);
        Ok(())
    }

    /// G28.1, G30.1: the position becomes the reference point.
    fn store_reference(&mut self, first: u32, span: Span) -> Result<(), Fault> {
        let readable = matches!(self.modal.length, Length::Off | Length::Programmed(_)) && !self.modal.in_table();
        let Some(point) = self.position.base.xyz().filter(|_| readable) else {
            let message = "the machine position is not known to the program here";
            return Err(
                Fault::new(codes::POSITION_UNKNOWN, span, message).help("program X, Y and Z, with G49, before it")
            );
        };
        for (axis, value) in (0..).zip(point) {
            self.variables.set(first + axis, Some(value));
        }
        for axis in 3..6 {
            if let Some(value) = self.position.base.get(axis) {
                self.variables.set(first + axis as u32, Some(value.to_degrees()));
            }
        }
        Ok(())
    }
}
