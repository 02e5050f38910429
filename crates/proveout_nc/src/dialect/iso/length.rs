//! Tool length and cutter radius: G43 and its relatives, G49, G40 to G42, H, D, tool offsets written by the
//! program.
//!
//! A length that the program writes itself (G43.1, G10 L10) moves the axes by this number whatever
//! tool is in the spindle. It is emitted as its effect: length off, and a shift of the frame.

use super::calls::whole;
use super::flavor::Flavor;
use super::modal::{Length, MotionMode, Plane};
use super::pending::{AXES, Pending};
use super::run_state::Interpreter;
use super::technology::LINEAR;
use super::words::Group;
use crate::codes;
use crate::control::LengthWord;
use crate::diagnostic::{Fault, Span};
use crate::g_code::{G40, G41, G41_1, G42_1, G43_1, G43_2, G43_4, G43_5, G44, G49, G234, GCode};
use crate::machine_data::KinematicsKind;
use crate::{CompSide, CutterComp, Offset, Op, ToolName};

/// A column of the offset memory C of a Fanuc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct OffsetColumn {
    pub(super) radius: bool,
    pub(super) wear: bool,
}

impl Interpreter {
    /// Takes the number of an offset in a block whose word ends that offset; notes a number other
    /// than zero.
    fn tell_idle_number(&mut self, p: &mut Pending, letter: u8, word: &str) {
        if p.take(letter).is_some_and(|number| number != 0.0) {
            self.note(format!("{} has no effect together with {word}", char::from(letter)));
        }
    }

    /// G43 G43.1 G43.2 G43.4 G43.5 G44 G49 G234, and H alone.
    pub(crate) fn length_words(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let before = (self.modal.length, self.modal.frames.length);
        let level = self.position.work.get(2);
        self.take_length_words(p, span)?;
        let changed = before != (self.modal.length, self.modal.frames.length);
        if changed && p.axes() & 0b100 == 0 && self.own.flavor == Flavor::Fanuc {
            self.length_alone(level, span)?;
        }
        Ok(())
    }

    /// The tool length changes in a block without Z. Bit 6 (TOS) of parameter 5006 of a Fanuc decides whether
    /// coordinates shift and nothing moves, or whether Z moves by the length. `level`: Z before the block.
    fn length_alone(&mut self, level: Option<f64>, span: Span) -> Result<(), Fault> {
        if self.modal.in_table() || self.modal.tcp {
            return Ok(());
        }
        match self.settings.control.parameters.length_word {
            Some(LengthWord::Shifts) => Ok(()),
            Some(LengthWord::Moves) => {
                let Some(level) = level else {
                    return Err(Fault::new(
                        codes::POSITION_UNKNOWN,
                        span,
                        "the tool length moves Z here, and the program has not set the position of Z",
                    )
                    .help("write Z in this block"));
                };
                let mut end = self.position.work;
                end.put(2, level);
                let rapid = !matches!(self.modal.motion, Some(MotionMode::Linear));
                if !rapid {
                    self.need_feed(LINEAR, span)?;
                }
                let motion = self.complete(end, 0b100, false, span)?;
                self.go(motion, rapid);
                Ok(())
            }
            None => {
                if !std::mem::replace(&mut self.own.noted_length, true) {
                    self.assume(
                        "a tool length that changes in a block without Z shifts the coordinates, and nothing moves; with bit 6 (TOS) of \
                         parameter 5006 at 0 Z moves by the length: write Z in the block, or state parameters.length_word of the \
                         control file",
                    );
                }
                Ok(())
            }
        }
    }

    fn take_length_words(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(code) = p.g(Group::ToolLength) else {
            // H is modal on a Fanuc and a Haas.
            if p.any_free(b"H") && !self.own.flavor.is_linuxcnc() {
                let h = self.offset_number(p, b'H', span)?;
                if matches!(self.modal.length, Length::Edge(_) | Length::Programmed(_)) {
                    self.take_length(h, 1.0, span)?;
                }
            }
            return Ok(());
        };
        match code {
            G49 => {
                self.tell_idle_number(p, b'H', "G49");
                self.set_length(Length::Off, [0.0; 3]);
                self.set_tcp(false, false);
            }
            G43_1 => {
                self.length_of_axes(p, span)?;
            }
            G43_2 => self.additional_length(p, span)?,
            _ => {
                let h = self.length_number(p, code, span)?;
                let tcp = matches!(code, G43_4 | G43_5 | G234);
                if tcp {
                    self.settings.check_kinematics(KinematicsKind::Tcp, &code.to_string(), span)?;
                }
                if tcp && (self.own.lengths.contains_key(&h) || self.has_programmed_length()) {
                    let message = format!("{code} with a length that the program writes itself is not supported");
                    return Err(
                        Fault::new(codes::UNSUPPORTED_WORD, span, message).help("give the length in the tool library")
                    );
                }
                if tcp && self.modal.plane == Plane::Dynamic {
                    return Err(
                        Fault::new(codes::CONFLICT, span, "G234 while G254 is in force").help("write G255 before it")
                    );
                }
                self.take_length(h, if code == G44 { -1.0 } else { 1.0 }, span)?;
                if tcp || self.modal.tcp {
                    self.set_tcp(tcp, code == G43_5);
                }
            }
        }
        Ok(())
    }

    /// Number of the offset: H, else the one before, on a `LinuxCNC` the tool in the spindle.
    fn length_number(&mut self, p: &mut Pending, code: GCode, span: Span) -> Result<u32, Fault> {
        // On a LinuxCNC H0 is the tool in the spindle too (`find_tool_index`: tool 0 is entry 0 of the
        // table).
        let of_spindle = self.is_rs274() && p.peek(b'H') == Some(0.0);
        if p.has(b'H') && !of_spindle {
            return self.offset_number(p, b'H', span);
        }
        p.use_up(b"H");
        let of_tool = self.settings.control.length_of_tool;
        if self.own.flavor.is_linuxcnc() || of_tool {
            return match self.technology.in_spindle {
                Some(ToolName::Number(number)) if of_tool && self.own.d.is_some_and(|d| d != 0 && d != number) => {
                    let message = format!("{code} with an offset D of another number than tool {number}");
                    Err(Fault::new(codes::UNSUPPORTED_WORD, span, message)
                        .help("give the offset the number of its tool"))
                }
                Some(ToolName::Number(number)) => Ok(number),
                Some(ToolName::Empty) => Ok(0),
                _ => Err(Fault::new(
                    codes::NO_TOOL,
                    span,
                    if of_spindle {
                        format!("{} H0 uses the length of the tool in the spindle, but no tool is in the spindle", code)
                    } else {
                        format!("{code} has no H, and no tool is in the spindle")
                    },
                )
                .help("write H, or change a tool first")),
            };
        }
        self.own.h.ok_or_else(|| {
            Fault::new(codes::MISSING_VALUE, span, format!("{code} has no H, and no H was programmed before it"))
                .help("write H1")
        })
    }

    fn offset_number(&mut self, p: &mut Pending, letter: u8, span: Span) -> Result<u32, Fault> {
        let value = p.take(letter).unwrap_or(0.0);
        let name = char::from(letter).to_string();
        let number = whole(value, &name, 99_999.0, span)?;
        if letter == b'H' {
            self.own.h = Some(number);
        } else {
            self.own.d = Some(number);
        }
        Ok(number)
    }

    /// H of G53.6, which switches the tool length on where none is in force.
    pub(super) fn length_of_turn(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        // An H alone has been taken by now where a length is in force; it switches none on.
        if matches!(self.modal.length, Length::Off) {
            if p.has(b'H') {
                let h = self.offset_number(p, b'H', span)?;
                return self.take_length(h, 1.0, span);
            }
            return Err(Fault::new(codes::MISSING_VALUE, span, "G53.6 has no H, and no tool length is in force")
                .help("write H1, so that the tip stays, or G53.1"));
        }
        Ok(())
    }

    /// Takes the offset with this number: what the program wrote under it, or the tool's own length.
    fn take_length(&mut self, h: u32, sign: f64, span: Span) -> Result<(), Fault> {
        if let Some(&(Some(geometry), wear)) = self.own.lengths.get(&h) {
            self.set_length(Length::Programmed(h), [0.0, 0.0, sign * (geometry + wear)]);
            return Ok(());
        }
        if sign < 0.0 && h != 0 {
            return Err(Fault::new(
                codes::UNSUPPORTED_WORD,
                span,
                "`G44` is supported only for a length that the program writes with G10",
            )
            .help("use G43"));
        }
        self.set_length(if h == 0 { Length::Off } else { Length::Edge(h) }, [0.0; 3]);
        Ok(())
    }

    pub(crate) fn set_length(&mut self, length: Length, shift: [f64; 3]) {
        self.own.length_canceled_by = None;
        let edge = |length: Length| if let Length::Edge(edge) = length { edge } else { 0 };
        self.emit(Op::Offset(Offset::ToolEdge { edge: edge(length) }));
        let before = std::mem::replace(&mut self.modal.length, length);
        if before == length && shift == self.modal.frames.length {
            return;
        }
        self.modal.frames.length = shift;
        if edge(before) != edge(length) {
            // The tool does not move, and its tip is now another point along it.
            self.position.forget(if self.modal.in_table() { LINEAR } else { 0b100 });
        }
        self.begin();
        // Along the tool, which is normal to the plane, the length changes only the third
        // coordinate of the plane.
        let kept = self.own.held;
        self.frames_changed("G43");
        self.own.held = kept;
    }

    pub(crate) fn set_tcp(&mut self, on: bool, vectors: bool) {
        self.modal.vectors = on && vectors;
        let before = self.modal.in_table();
        self.modal.tcp = on;
        if before == self.modal.in_table() {
            return;
        }
        // With all rotary axes of the machine at zero the axes of the table are those of the machine.
        let zero = (3..6).filter(|&axis| self.position.base.get(axis) == Some(0.0)).count();
        let known = (3..6).filter(|&axis| self.position.base.get(axis).is_some()).count();
        if !(zero == known && zero >= 2) {
            self.position.forget(LINEAR);
        }
        self.begin();
        self.tell_tcp();
    }

    /// G43.1: the axes that it names get these offsets, the others keep theirs (`convert_tool_length_offset`
    /// of the interpreter).
    fn length_of_axes(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let named = p.axes();
        let given = self.length_shift(p, span)?;
        let mut shift = self.modal.frames.length;
        for axis in (0..3).filter(|axis| named >> axis & 1 == 1) {
            shift[axis] = given[axis];
        }
        let of_table = matches!(self.modal.length, Length::Edge(edge) if edge > 0);
        if of_table && named & 0b100 == 0 {
            // The length of the table stays in force along the tool.
            self.modal.frames.length = shift;
            self.begin();
            self.frames_changed("G43.1");
        } else {
            self.set_length(Length::Programmed(0), shift);
        }
        Ok(())
    }

    /// X Y Z of G43.1.
    fn length_shift(&mut self, p: &mut Pending, span: Span) -> Result<[f64; 3], Fault> {
        if p.axes() & !LINEAR != 0 || p.axes() == 0 {
            return Err(Fault::new(codes::BAD_VALUE, span, "G43.1 takes X, Y and Z").help("write G43.1 Z50"));
        }
        Ok([0, 1, 2].map(|axis: usize| self.length_of(p, AXES[axis]).unwrap_or(0.0)))
    }

    /// G43.2: adds a further offset to the one in force.
    fn additional_length(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let mut shift = self.modal.frames.length;
        if p.has(b'H') {
            let h = whole(p.take(b'H').unwrap_or(0.0), "H", 99_999.0, span)?;
            let Some(&(Some(geometry), wear)) = self.own.lengths.get(&h) else {
                return Err(Fault::new(
                    codes::UNSUPPORTED_WORD,
                    span,
                    format!("`G43.2 H{h}`: the length of tool {h} is not known to the program"),
                )
                .help("write it with G10 L1, or write the offset with G43.2 Z"));
            };
            shift[2] += geometry + wear;
        } else {
            let more = self.length_shift(p, span)?;
            shift = std::array::from_fn(|i| shift[i] + more[i]);
        }
        // The shift comes on top of the tool length in force.
        self.modal.frames.length = shift;
        self.begin();
        self.frames_changed("G43.2");
        Ok(())
    }

    /// G40 G41 G42 G41.1 G42.1, and D alone.
    pub(crate) fn compensation_words(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(code) = p.g(Group::CutterComp) else {
            if p.any_free(b"D") && !self.own.flavor.is_linuxcnc() {
                let before = self.own.d;
                let number = self.offset_number(p, b'D', span)?;
                if self.modal.comp != CompSide::Off && before != Some(number) {
                    self.tell_compensation(Some(number), None);
                }
            }
            return Ok(());
        };
        self.modal.comp = match code {
            G40 => CompSide::Off,
            G41 | G41_1 => CompSide::Left,
            _ => CompSide::Right,
        };
        if code == G40 {
            self.tell_idle_number(p, b'D', "G40");
            self.tell_compensation(None, None);
            return Ok(());
        }
        if matches!(code, G41_1 | G42_1) {
            let Some(diameter) = self.length_of(p, b'D') else {
                return Err(Fault::new(codes::MISSING_VALUE, span, format!("{code} has no D"))
                    .help("write the diameter of the cutter"));
            };
            if let Some(orientation) = p.take(b'L').filter(|&l| l != 0.0) {
                return Err(Fault::new(
                    codes::UNSUPPORTED_WORD,
                    span,
                    format!("`L{orientation}` (orientation of a turning tool) is not supported"),
                )
                .help("remove it"));
            }
            self.tell_compensation(None, Some(0.5 * diameter));
            return Ok(());
        }
        let offset = if p.has(b'D') {
            Some(self.offset_number(p, b'D', span)?)
        } else if self.own.flavor.is_linuxcnc() {
            None
        } else {
            if self.own.d.is_none() {
                self.without_radius(code, span)?;
            }
            self.own.d
        };
        self.tell_compensation(offset, None);
        Ok(())
    }

    /// G41 and G42 without a D, where no D came before. A control takes the offset zero then, and
    /// the path is that of the center: refused. Where the control is only assumed, the radius of
    /// the tool in the spindle is taken.
    fn without_radius(&mut self, code: GCode, span: Span) -> Result<(), Fault> {
        let name = code.to_string();
        if self.settings.control.length_of_tool {
            return Ok(());
        }
        if !self.own.assumed {
            return Err(Fault::new(
                codes::MISSING_VALUE,
                span,
                format!("{name} has no D, and no D was programmed before it"),
            )
            .help("write D1"));
        }
        self.assume(format!("{name} without D takes the radius of the tool in the spindle"));
        Ok(())
    }

    fn tell_compensation(&mut self, offset: Option<u32>, radius: Option<f64>) {
        let written =
            offset.and_then(|d| self.own.radii.get(&d)).and_then(|&(geometry, wear)| geometry.map(|g| g + wear));
        self.emit(Op::CutterComp(CutterComp { side: self.modal.comp, offset, radius: radius.or(written) }));
    }

    /// G10 L10 to L13: geometry and wear of length and radius.
    pub(crate) fn write_tool_offset(
        &mut self,
        list: f64,
        number: u32,
        p: &mut Pending,
        span: Span,
    ) -> Result<(), Fault> {
        let Some(value) = self.length_of(p, b'R') else {
            return Err(Fault::new(codes::MISSING_VALUE, span, format!("G10 L{list} has no R"))
                .help("write the offset: G10 L10 P1 R100"));
        };
        let kept = OffsetColumn { radius: list >= 12.0, wear: list == 11.0 || list == 13.0 };
        self.store_tool_offset(kept, number, value, self.modal.incremental, &format!("G10 L{list}"), span)
    }

    /// Writes a length or a radius of the offset memory, mm.
    pub(super) fn store_tool_offset(
        &mut self,
        kept: OffsetColumn,
        number: u32,
        value: f64,
        add: bool,
        word: &str,
        span: Span,
    ) -> Result<(), Fault> {
        let wear = kept.wear;
        let table = if kept.radius { &mut self.own.radii } else { &mut self.own.lengths };
        let entry = table.entry(number).or_insert((None, 0.0));
        let slot = if wear { &mut entry.1 } else { entry.0.get_or_insert(0.0) };
        *slot = if add { *slot + value } else { value };
        if entry.0.is_none() {
            let zero = entry.1 == 0.0;
            table.remove(&number);
            if !zero {
                let message =
                    format!("{word} writes the wear of offset {number}, whose geometry the program has not written");
                return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message)
                    .help("write the geometry with G10 L10 or L12, or put the wear into the tool library"));
            }
        }
        Ok(())
    }

    /// What the program has written of a length or a radius, mm.
    pub(super) fn stored_tool_offset(&self, kept: OffsetColumn, number: u32) -> Option<f64> {
        let table = if kept.radius { &self.own.radii } else { &self.own.lengths };
        let (geometry, wear) = table.get(&number).copied()?;
        if kept.wear { Some(wear) } else { geometry }
    }

    /// G10 L1 P Z R of `LinuxCNC`.
    pub(crate) fn write_tool_table(&mut self, number: u32, p: &mut Pending, span: Span) -> Result<(), Fault> {
        if let Some(radius) = self.length_of(p, b'R') {
            self.own.radii.insert(number, (Some(radius), 0.0));
        }
        if let Some(length) = self.length_of(p, b'Z') {
            self.own.lengths.insert(number, (Some(length), 0.0));
        }
        for letter in *b"IJQ" {
            p.take(letter);
        }
        if p.axes() != 0 {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, "`G10 L1` of other axes than Z is not supported")
                .help("write Z and R"));
        }
        Ok(())
    }

    /// The control has macro B.
    pub(crate) fn is_fanuc(&self) -> bool {
        self.own.flavor == Flavor::Fanuc
    }
}
