//! Motions in machine coordinates: G53, G28, G30; words that act once.
//!
//! **Reference points.** G28 and G30 move with the named axes alone, through the point that the
//! block programs, to the first and second reference point. G91 with zero makes that point the
//! present position. Where the reference points are is data of the machine: parameters `#5161` and
//! `#5181` and up, which the program or the settings give, else [`crate::ReferencePoints`].
//!
//! **Tool length after them.** A machine coordinate is that of the axis, without tool length. What
//! the length does from the next block on differs:
//!
//! * `LinuxCNC`: it is in force as before (RS274/NGC: neither word changes G43).
//! * Haas: G53 leaves it; G28 cancels it "for the following lines of code" (*Mill operator's manual*, G28),
//!   and G234 with it.
//! * Fanuc: the offset of the axes that moved is canceled while the display still shows G43. Bit 6 of
//!   parameter 5001 decides whether the next motion or only the next G43, G44 or H brings it back
//!   (*Operator's manual*, "G53, G28 and G30 commands in tool length compensation mode"). The reader
//!   takes the offset as back from the next block on. Where a machine is to run the program, a
//!   motion of Z before such a word reports that as an assumption.
//!
//! **Under tool center point control** every axis of the machine moves the tip in all coordinates
//! of the table, so that none of them is known after such a block; axes that the next block does
//! not name stay where they are.

use super::flavor::Flavor;
use super::modal::{Length, MotionMode};
use super::pending::{AXES, Pending};
use super::run_state::Interpreter;
use super::words::Group;
use crate::channel::unknown_axes;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::g_code::*;
use crate::{AxisValues, Offset, Op};

/// What the twin does with machine coordinates under tool center point control.
fn under_tcp(word: &str) -> String {
    format!(
        "machine coordinates under {word} are positions of the axes; tool center point control continues from the \
         position reached: write G49 before them"
    )
}

/// Numbers of the parameters that hold the reference points of G28 and G30 on a `LinuxCNC`; settings may give
/// them for all.
const FIRST_REFERENCE: u32 = 5161;
const SECOND_REFERENCE: u32 = 5181;

impl Interpreter {
    /// A word that acts in its block only.
    pub(crate) fn one_shot(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        match code {
            G93 if self.settings.control.depth_in_i => self.fagor_pole(p, span)?,
            G70 | G71 if self.own.flavor == Flavor::Haas => self.bolt_holes(code, p, span)?,
            G12 | G13 => self.circular_pocket(code, p, span)?,
            G71 => self.return_level_word(p, span)?,
            G5 | G5_1 => {
                // High-speed and smoothing modes of a Fanuc: where corners go is the tolerance of the
                // machine.
                let mut text = code.to_string();
                for letter in *b"PQRXYZABC" {
                    if let Some(value) = p.take(letter) {
                        text.push_str(&format!(" {}{value}", char::from(letter)));
                    }
                }
                self.note(text);
            }
            G10 => self.write_data(p, span)?,
            G27 | G60 => self.positioning(code, p, span)?,
            G28 => self.reference(p, "G28", FIRST_REFERENCE, span)?,
            G30 => self.reference(p, "G30", SECOND_REFERENCE, span)?,
            G28_1 => self.store_reference(FIRST_REFERENCE, span)?,
            G30_1 => self.store_reference(SECOND_REFERENCE, span)?,
            G31 => {
                self.before_motion(p.axes(), p, span)?;
                self.probe(p, G31, span)?;
            }
            G52 | GCode(92, 0..=3) => self.shift_word(code, p, span)?,
            G53 => self.machine_block(p, span)?,
            G53_1 | G53_6 | G253 => self.turn_to_plane(code, p, span)?,
            _ => {}
        }
        Ok(())
    }

    /// G27 and G60 of a Fanuc: a rapid motion to the programmed point. G27 checks that it is the reference
    /// point; G60 comes from one side, by an overrun that is a parameter of the control.
    fn positioning(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let axes = p.axes();
        if axes == 0 {
            let word = if code == G27 { "G27" } else { "G60" };
            return Err(Fault::new(codes::MISSING_VALUE, span, format!("{word} names no axis")).help("write its point"));
        }
        self.before_motion(axes, p, span)?;
        let (end, programmed) = self.targets(p, span)?;
        self.assume(if code == G27 {
            "G27 goes to the programmed point at rapid rate; whether it is the reference point is not checked"
        } else {
            "G60 goes straight to its point at rapid rate, without the overrun of the control (parameter 5440)"
        });
        if programmed == 0 { Ok(()) } else { self.rapid(end, programmed, true, span) }
    }

    /// G53: coordinates of the machine axes, only the programmed ones move.
    fn machine_block(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let axes = p.axes();
        if axes == 0 {
            return Ok(());
        }
        if self.modal.incremental && self.own.flavor.is_linuxcnc() && !self.settings.control.grbl_words {
            let message = "G53 under G91: the control refuses both a position and an increment";
            return Err(Fault::new(codes::CONFLICT, span, message).help("write G90 G53"));
        }
        if self.modal.incremental && (self.own.flavor == Flavor::Haas || self.own.assumed) {
            self.assume("G53 under G91 goes to machine coordinates, as it does under G90");
        } else if self.modal.incremental && !self.own.flavor.is_linuxcnc() {
            return Err(Fault::new(
                codes::POSITION_UNKNOWN,
                span,
                "G53 with G91: the control ignores the word or the increment",
            )
            .help("write G90 G53"));
        }
        let rapid = match self.modal.motion {
            Some(MotionMode::Rapid) => true,
            Some(MotionMode::Linear) => self.own.flavor == Flavor::Fanuc,
            None if !self.own.flavor.is_linuxcnc() => true,
            _ if self.own.flavor == Flavor::Fanuc => true,
            _ => {
                return Err(
                    Fault::new(codes::CONFLICT, span, "G53 needs G0 or G1 in force").help("write G0 or G1 with G53")
                );
            }
        };
        let mut end = AxisValues::NONE;
        for (axis, &letter) in AXES.iter().enumerate().filter(|(axis, _)| axes >> axis & 1 == 1) {
            let rotary = (3..6).contains(&axis);
            let value = if rotary { self.rotary_of(p, letter) } else { self.length_of(p, letter) };
            end.put(axis, value.unwrap_or(0.0));
        }
        self.forget_kept();
        self.begin_motion();
        if !rapid {
            self.need_feed(axes, span)?;
        }
        let exact_stop = p.g(Group::ExactStop).is_some();
        self.machine_motion(end, axes, rapid, exact_stop);
        self.known_in_machine(&end, axes);
        self.length_in_doubt("G53", axes);
        Ok(())
    }

    /// At rapid rate to machine coordinates that no word of the block gives.
    pub(crate) fn goes_in_machine(&mut self, end: AxisValues, axes: u16) {
        self.begin_motion();
        self.machine_motion(end, axes, true, false);
        self.known_in_machine(&end, axes);
    }

    /// A machine coordinate is that of the axis: the place of the tip is known from it, in Z where no tool
    /// length of the table is in force.
    pub(super) fn known_in_machine(&mut self, end: &AxisValues, axes: u16) {
        if self.modal.in_table() {
            return;
        }
        let length = matches!(self.modal.length, Length::Edge(edge) if edge > 0);
        self.position.stands_in_machine(end, if length { axes & 0b011 } else { axes & 0b111 });
    }

    /// A Fanuc has canceled the tool length in Z, and its set-up says what brings it back.
    fn length_in_doubt(&mut self, word: &'static str, axes: u16) {
        let length = matches!(self.modal.length, Length::Edge(_) | Length::Programmed(_));
        let runs = self.settings.reference_points.is_some();
        if runs && self.own.flavor == Flavor::Fanuc && length && !self.modal.in_table() && axes & 0b100 != 0 {
            self.own.length_canceled_by = Some(word);
        }
    }

    /// Reports, before a motion of Z, that its tool length depends on the set-up of the control.
    pub(crate) fn tell_length(&mut self, axes: u16) {
        let moves = axes & 0b100 != 0 || axes != 0 && self.modal.cycle.is_some();
        if let Some(word) = self.own.length_canceled_by.take_if(|_| moves) {
            self.assume(format!(
                "the tool length that {word} has canceled in Z is active again without G43; the control does so only \
                 if parameter 5001, bit 6, is set: write G43 with its H before Z moves"
            ));
        }
    }

    /// Machine coordinates are those of the axes without tool length: the length goes out of effect for the
    /// motion.
    fn machine_motion(&mut self, end: AxisValues, axes: u16, rapid: bool, exact_stop: bool) {
        let edge = match self.modal.length {
            Length::Edge(edge) if edge > 0 => Some(edge),
            _ => None,
        };
        if edge.is_some() {
            self.emit(Op::Offset(Offset::ToolEdge { edge: 0 }));
        }
        self.position.moved_in_machine(&end, axes, self.modal.in_table());
        if self.modal.tcp && axes != 0 {
            let word = if self.modal.vectors {
                "G43.5"
            } else if self.own.flavor == Flavor::Haas {
                "G234"
            } else {
                "G43.4"
            };
            self.assume(under_tcp(word));
        }
        self.go_in_machine(end, axes, rapid, exact_stop);
        if let Some(edge) = edge {
            self.emit(Op::Offset(Offset::ToolEdge { edge }));
        }
    }

    /// G28 and G30: by rapid to the intermediate point, then to the reference point of the programmed axes.
    fn reference(&mut self, p: &mut Pending, word: &'static str, first: u32, span: Span) -> Result<(), Fault> {
        if word == "G30" && self.settings.control.osp_words {
            return self.okuma_home(p, span);
        }
        p.use_up(if word == "G30" { b"P" } else { b"" });
        if let Some(which) = p.peek(b'P').filter(|&which| word == "G30" && which != 2.0) {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`G30 P{which}` is not supported"))
                .help("program the point with G53"));
        }
        let named = p.axes();
        self.forget_kept();
        self.begin_motion();
        if named == 0 && self.own.assumed {
            self.assume(format!(
                "{word} without an axis sends all axes, as on a Haas and a LinuxCNC; a Fanuc refuses it"
            ));
        } else if named == 0 && self.own.flavor == Flavor::Fanuc {
            return Err(Fault::new(codes::MISSING_VALUE, span, format!("{word} names no axis"))
                .help(format!("write G91 {word} Z0")));
        }
        let axes = if named == 0 { self.all_axes() } else { named };
        if named != 0 {
            let before = self.position.work;
            let (end, programmed) = self.targets(p, span)?;
            let moves = (0..9).any(|axis| programmed >> axis & 1 == 1 && end.get(axis) != before.get(axis));
            if moves {
                self.before_motion(programmed, p, span)?;
                let motion = self.complete(end, programmed, false, span)?;
                self.go(motion, true);
            }
        }
        let turned = self.is_rs274() && self.modal.frames.turn != 0.0 && matches!(axes & 0b11, 0b01 | 0b10);
        let (end, axes) = if turned {
            self.reference_point_in_turned(word, first, axes, span)?
        } else {
            (self.reference_point(word, first, axes, span)?, axes)
        };
        if word == "G28" && self.own.flavor == Flavor::Haas && self.modal.length != Length::Off {
            self.set_length(Length::Off, [0.0; 3]);
            self.set_tcp(false, false);
        }
        self.machine_motion(end, axes, true, false);
        // Where no machine is known the point is a placeholder, and what follows must not rely on
        // it.
        let stated = (0..3).all(|axis| self.variables.numbered(first + axis).is_some() || axes >> axis & 1 == 0);
        if stated || self.settings.reference_points.is_some() {
            self.known_in_machine(&end, axes);
        }
        self.length_in_doubt(word, axes);
        Ok(())
    }

    /// A `LinuxCNC` converts the reference point into the coordinates of the work offset and goes
    /// there with the axes that the block names (`convert_home`, `find_relative` of its
    /// interpreter). Where the offset is turned and one of X and Y is named, both axes of the
    /// machine move, and neither reaches its reference point. Returns the end in machine
    /// coordinates, and the axes that go there.
    fn reference_point_in_turned(
        &mut self,
        word: &'static str,
        first: u32,
        axes: u16,
        span: Span,
    ) -> Result<(AxisValues, u16), Fault> {
        let named = usize::from(axes & 0b01 == 0);
        let axes = axes | 0b11;
        let mut end = self.reference_point(word, first, axes, span)?;
        let mut there = self.position.clone();
        there.stands_in_machine(&end, 0b11);
        let mut work = self.position.work;
        work.put(named, there.work.get(named).unwrap_or(0.0));
        let base = self.position.base_of(&work, 0b11).map_err(|missing| unknown_axes(&missing, span))?;
        for axis in 0..2 {
            end.put(axis, base.get(axis).unwrap_or(0.0));
        }
        self.note(format!(
            "{word} with {} alone under the rotation of {}: X and Y both move, along the turned axis, and miss the \
             reference point; G53 moves to a position of the machine",
            char::from(AXES[named]),
            self.modal.offset
        ));
        Ok((end, axes))
    }

    /// G30 P of an Okuma: all axes to a home position of the machine, of which the twin has two.
    fn okuma_home(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let number = p.take(b'P').unwrap_or(1.0);
        let first = match number {
            1.0 => FIRST_REFERENCE,
            2.0 => SECOND_REFERENCE,
            _ => {
                return Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`G30 P{number}` is not supported"))
                    .help(
                        "P1 and P2 are the two reference points of the machine file; write G16 H0 with coordinates",
                    ));
            }
        };
        self.forget_kept();
        self.begin_motion();
        self.assume(format!(
            "G30 P{number} goes to the reference points of the machine file, Z first; the home positions of the control and their \
             order are data of the machine"
        ));
        let all = self.all_axes();
        for axes in [all & 0b100, all & !0b100] {
            if axes != 0 {
                let end = self.reference_point("G30", first, axes, span)?;
                self.machine_motion(end, axes, true, false);
            }
        }
        Ok(())
    }

    /// `$H` of a grbl: Z goes home, then the other axes.
    pub(super) fn home(&mut self, span: Span) -> Result<(), Fault> {
        self.begin_motion();
        let all = self.all_axes();
        for axes in [all & 0b100, all & !0b100] {
            if axes != 0 {
                let end = self.reference_point("$H", FIRST_REFERENCE, axes, span)?;
                self.machine_motion(end, axes, true, false);
            }
        }
        Ok(())
    }

    /// The axes of G28 without a coordinate: those of the machine, or, where no machine is known, those that
    /// the program uses.
    fn all_axes(&self) -> u16 {
        match &self.settings.reference_points {
            Some(points) => points.axes,
            None => (3..9).fold(0b111, |axes, axis| axes | u16::from(self.position.base.get(axis).is_some()) << axis),
        }
    }

    /// Reference point of some axes: of the parameters, else of the machine.
    fn reference_point(&mut self, word: &'static str, first: u32, axes: u16, span: Span) -> Result<AxisValues, Fault> {
        let mut end = AxisValues::NONE;
        for axis in (0..9usize).filter(|axis| axes >> axis & 1 == 1) {
            if let Some(value) = self.variables.numbered(first + axis as u32) {
                end.put(axis, if (3..6).contains(&axis) { value.to_radians() } else { value });
            }
        }
        let open = (0..9).filter(|&axis| axes >> axis & 1 == 1 && end.get(axis).is_none());
        let open: Vec<usize> = open.collect();
        let Some(points) = self.settings.reference_points.clone() else {
            for &axis in &open {
                end.put(axis, 0.0);
            }
            if !open.is_empty() && !self.own.noted_references.contains(&first) {
                self.own.noted_references.push(first);
                self.note(format!(
                    "{word}: the reference point is taken as machine zero; #{first} and up, given with --variable or in the control file, say another"
                ));
            }
            return Ok(end);
        };
        for axis in open {
            let value = Self::stated_reference(&points, first != FIRST_REFERENCE, axis, word, span)?;
            end.put(axis, value);
        }
        Ok(end)
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
