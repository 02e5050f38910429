//! Work offsets and shifts: G54 and its relatives, G52, G92, G10; corners: G61, G64.

use super::calls::whole;
use super::flavor::Flavor;
use super::modal::{Plane, Shift};
use super::pending::{AXES, Pending};
use super::run_state::{Interpreter, offset_key};
use super::technology::of_a_lathe;
use super::words::Group;
use crate::channel::unknown_axis;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::Frame;
use crate::g_code::*;
use crate::{Offset, Op, Override, PathMode, WorkOffset};

/// Tolerance that bounds nothing on a machine tool, mm.
const NO_TOLERANCE_MM: f64 = 1000.0;

impl Interpreter {
    /// Takes the values of a work offset into the frames.
    pub(crate) fn load_offset(&mut self, word: &str) {
        let key = offset_key(word);
        let WorkOffset { translation: [x, y, z], rotary: [a, b, c] } =
            self.own.offsets.get(&key).copied().unwrap_or_default();
        self.modal.frames.settable = [x, y, z, a, b, c];
        self.modal.frames.turn = self.own.turns.get(&key).copied().unwrap_or(0.0);
    }

    /// Takes changed frames into effect: the tool stays where it is.
    pub(crate) fn frames_changed(&mut self, word: &str) {
        let total = self.modal.frames.total(self.own.flavor);
        if total == *self.position.frame() {
            return;
        }
        self.position.set_frame(total);
        self.forget_kept();
        (self.modal.polar_radius, self.modal.polar_angle) = (None, None);
        if self.has_begun() {
            self.tell_frame(word);
        }
    }

    /// The values of a work offset have changed.
    pub(crate) fn offset_changed(&mut self, word: &str) {
        if offset_key(&self.modal.offset) == offset_key(word) {
            self.load_offset(word);
            self.frames_changed(word);
        }
    }

    /// G54 to G59.3, G54.1 P, G154 P, G110 to G129.
    pub(crate) fn offset_word(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(code) = p.g(Group::WorkOffset) else { return Ok(()) };
        // `G54 P1` is another spelling of `G54.1 P1`.
        let numbered =
            code == G54_1 || code == G154 || code == G54 && self.own.flavor == Flavor::Fanuc && p.any_free(b"P");
        let word = if numbered {
            let highest = if self.own.flavor == Flavor::Haas { 99.0 } else { 300.0 };
            let number = p.take(b'P').ok_or_else(|| {
                Fault::new(codes::MISSING_VALUE, span, format!("{code} has no P")).help("write G54.1 P1 or G154 P1")
            })?;
            let number = whole(number, "P", highest, span)?;
            let head = if code == G154 { "G154" } else { "G54.1" };
            format!("{head} P{number}")
        } else if let GCode(number @ 110.., _) = code {
            format!("G154 P{}", number - 109)
        } else {
            code.to_string()
        };
        self.call_offset(word, span)
    }

    /// The work offset of this word comes into force.
    pub(super) fn call_offset(&mut self, word: String, span: Span) -> Result<(), Fault> {
        if self.modal.plane == Plane::Dynamic {
            if offset_key(&word) == offset_key(&self.modal.offset) {
                // The one that is in force changes nothing.
                return Ok(());
            }
            return Err(Fault::new(codes::CONFLICT, span, format!("{word} while G254 is in force"))
                .help("write G255 before it"));
        }
        self.load_offset(&word);
        self.modal.offset.clone_from(&word);
        if !self.has_begun() {
            // The first motion emits the offset in force at the start.
            let total = self.modal.frames.total(self.own.flavor);
            self.position.set_frame(total);
            return Ok(());
        }
        self.emit(Op::Offset(Offset::Work { word: word.clone() }));
        self.frames_changed(&word);
        Ok(())
    }

    /// Values of the axes X Y Z A B C of the block in mm and radian; U V W are refused.
    fn shift_values(&mut self, p: &mut Pending, word: &str, span: Span) -> Result<[Option<f64>; 6], Fault> {
        if p.axes() >> 6 != 0 {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`{word}` of U, V and W is not supported"))
                .help("use X, Y, Z, A, B, C"));
        }
        let mut values = [None; 6];
        for (axis, slot) in values.iter_mut().enumerate() {
            if p.any_free(&[AXES[axis]]) {
                *slot = if axis < 3 { self.length_of(p, AXES[axis]) } else { self.rotary_of(p, AXES[axis]) };
            }
        }
        if values.iter().flatten().any(|v| !v.is_finite()) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("a value of {word} is not finite")).help("check it"));
        }
        Ok(values)
    }

    /// G52, G92, G92.1 to G92.3.
    pub(crate) fn shift_word(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let word = code.to_string();
        if code == G92 && p.axes() != 0 && p.has(b'F') && !self.own.flavor.is_linuxcnc() {
            return Err(of_a_lathe("G92 with F", "cuts a thread", span));
        }
        if code == G92 && p.axes() == 0 {
            // G92 S has been read with the speeds.
            return if p.has(b'S') {
                Ok(())
            } else {
                Err(Fault::new(codes::MISSING_VALUE, span, "G92 names no axis").help("write G92 X0"))
            };
        }
        let linuxcnc = self.own.flavor.is_linuxcnc();
        // Axis letters in a block with G92.1 to G92.3 belong to the motion of the block there.
        let values = if linuxcnc && code > G92 { [None; 6] } else { self.shift_values(p, &word, span)? };
        let frames = &mut self.modal.frames;
        match code {
            // On a LinuxCNC G52 writes the registers of G92.
            G52 => {
                let target: &mut Shift = if linuxcnc { &mut frames.shift } else { &mut frames.local };
                for (slot, value) in target.iter_mut().zip(values) {
                    *slot = value.unwrap_or(*slot);
                }
            }
            G92 => self.set_position(values, span)?,
            G92_1 if !linuxcnc => {
                for (axis, value) in values.iter().enumerate() {
                    if value.is_some() {
                        frames.shift[axis] = 0.0;
                        frames.local[axis] = 0.0;
                    }
                }
            }
            G92_1 => (frames.shift, frames.kept_shift) = ([0.0; 6], None),
            G92_2 => {
                if frames.kept_shift.is_none() {
                    frames.kept_shift = Some(std::mem::take(&mut frames.shift));
                }
            }
            _ => {
                if let Some(kept) = frames.kept_shift.take() {
                    frames.shift = kept;
                }
            }
        }
        self.frames_changed(&word);
        Ok(())
    }

    /// G92: the shift that gives the present position these coordinates.
    fn set_position(&mut self, values: [Option<f64>; 6], span: Span) -> Result<(), Fault> {
        let mut bare = self.modal.frames.clone();
        if bare.plane != Frame::IDENTITY || bare.rotation != Frame::IDENTITY || bare.mirror != Frame::IDENTITY {
            return Err(Fault::new(codes::CONFLICT, span, "G92 under a rotation, a mirror or a tilted plane")
                .help("write G69 before it"));
        }
        for (axis, value) in values.iter().enumerate() {
            if value.is_some() {
                bare.shift[axis] = 0.0;
                bare.local[axis] = 0.0;
            }
        }
        let mut without = self.position.clone();
        without.set_frame(bare.total(self.own.flavor));
        for (axis, value) in values.iter().enumerate() {
            let Some(value) = value else { continue };
            let Some(now) = without.work.get(axis) else {
                let letter = char::from(AXES[axis]);
                let message = format!("G92 needs the position of `{letter}`, which the program has not set");
                return Err(Fault::new(codes::POSITION_UNKNOWN, span, message)
                    .help("move there in work coordinates first, or use a work offset (G54)"));
            };
            bare.shift[axis] = now - value;
        }
        bare.kept_shift = None;
        self.modal.frames = bare;
        Ok(())
    }

    /// G10 L2, L20: work offsets; L1, L10 to L13: tool offsets.
    pub(crate) fn write_data(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let list = p.take(b'L');
        let number = p.take(b'P');
        let refuse = |what: &str| {
            Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`G10 {what}` is not supported"))
                .help("G10 L2, L20 write work offsets, L10 to L13 (Fanuc, Haas) and L1 (LinuxCNC) tool offsets"))
        };
        let Some(list) = list else {
            return Err(Fault::new(codes::MISSING_VALUE, span, "G10 has no L").help("write G10 L2 P1 X0 Y0 Z0"));
        };
        let number = whole(
            number.unwrap_or(if list == 20.0 && self.own.flavor.is_linuxcnc() { 0.0 } else { 1.0 }),
            "P",
            999.0,
            span,
        )?;
        match (list, self.own.flavor) {
            (2.0, _) => {
                let word = match (number, self.own.flavor) {
                    (0, Flavor::LinuxCnc) => self.modal.offset.clone(),
                    (0, _) => return self.write_external(p, span),
                    (1..=6, _) => format!("G{}", 53 + number),
                    (7..=9, Flavor::LinuxCnc) => format!("G59.{}", number - 6),
                    _ => return refuse(&format!("L2 P{number}")),
                };
                self.write_offset(&word, p, span)
            }
            (20.0, Flavor::LinuxCnc) => self.offset_from_position(number, p, span),
            (20.0, Flavor::Fanuc) => self.write_offset(&format!("G54.1 P{number}"), p, span),
            (20.0, Flavor::Haas) => self.write_offset(&format!("G154 P{number}"), p, span),
            (1.0, Flavor::LinuxCnc) => self.write_tool_table(number, p, span),
            (10.0..=13.0, Flavor::Fanuc | Flavor::Haas) => self.write_tool_offset(list, number, p, span),
            _ => refuse(&format!("L{list}")),
        }
    }

    fn write_external(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let values = self.shift_values(p, "G10", span)?;
        let incremental = self.modal.incremental;
        for (slot, value) in self.modal.frames.external.iter_mut().zip(values) {
            if let Some(value) = value {
                *slot = if incremental { *slot + value } else { value };
            }
        }
        self.frames_changed("G10");
        Ok(())
    }

    fn write_offset(&mut self, word: &str, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let values = self.shift_values(p, "G10", span)?;
        let key = offset_key(word);
        if self.own.flavor.is_linuxcnc()
            && let Some(turn) = p.take(b'R')
        {
            self.turn_under_shift(word, turn, span)?;
            self.own.turns.insert(key.clone(), turn);
        }
        // G91 adds on a Fanuc and a Haas; LinuxCNC writes absolute values.
        let add = self.modal.incremental && !self.own.flavor.is_linuxcnc();
        let offset = self.own.offsets.entry(key).or_default();
        for (axis, value) in values.into_iter().enumerate() {
            let Some(value) = value else { continue };
            let slot = if axis < 3 { &mut offset.translation[axis] } else { &mut offset.rotary[axis - 3] };
            *slot = if add { *slot + value } else { value };
        }
        self.offset_changed(word);
        Ok(())
    }

    /// When the rotation of the system in force changes, a `LinuxCNC` turns the position of the
    /// tool without the shift of G92 (`convert_setup` of its interpreter), and its machine
    /// coordinates with it. The axis that the next block does not name then moves, by a distance
    /// that depends on when the control reads its position again.
    fn turn_under_shift(&self, word: &str, turn: f64, span: Span) -> Result<(), Fault> {
        let frames = &self.modal.frames;
        let in_force = offset_key(word) == offset_key(&self.modal.offset);
        let shifted = frames.shift[0] != 0.0 || frames.shift[1] != 0.0;
        if !(self.is_rs274() && in_force && shifted && (turn - frames.turn) % 360.0 != 0.0) {
            return Ok(());
        }
        let message =
            format!("R of G10 L2 turns {word} under the shift of G92, and the control loses the place of X and Y");
        Err(Fault::new(codes::CONFLICT, span, message).help("write G92.2 before it and G92.3 after it"))
    }

    /// G10 L20 of `LinuxCNC`: the offset that gives the present position these coordinates.
    fn offset_from_position(&mut self, number: u32, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let values = self.shift_values(p, "G10 L20", span)?;
        let word = match number {
            0 => self.modal.offset.clone(),
            1..=6 => format!("G{}", 53 + number),
            7..=9 => format!("G59.{}", number - 6),
            _ => {
                return Err(Fault::new(codes::BAD_VALUE, span, format!("G10 L20 P{number}: there are 9 work offsets"))
                    .help("use P0 to P9"));
            }
        };
        let key = offset_key(&word);
        let turn = self.own.turns.get(&key).copied().unwrap_or(0.0);
        let mut offset = self.own.offsets.get(&key).copied().unwrap_or_default();
        // The present position in that system, without its origin; a rotation turns what is missing
        // into the axes of the machine.
        let mut there = self.modal.frames.clone();
        (there.settable, there.turn) = ([0.0; 6], turn);
        if turn != 0.0 {
            let [x, y, z] = offset.translation;
            there.settable = [x, y, z, 0.0, 0.0, 0.0];
        }
        let mut seen = self.position.clone();
        seen.set_frame(there.total(self.own.flavor));
        let mut moved = [0.0; 3];
        for (axis, value) in values.into_iter().enumerate() {
            let Some(value) = value else { continue };
            let Some(now) = seen.work.get(axis) else {
                return Err(unknown_axis(axis, span));
            };
            match axis {
                0..3 if turn != 0.0 => moved[axis] = now - value,
                0..3 => offset.translation[axis] = now - value,
                _ => offset.rotary[axis - 3] = now - value,
            }
        }
        let moved = Frame::rotation(2, turn).apply_vector(moved);
        offset.translation = std::array::from_fn(|axis| offset.translation[axis] + moved[axis]);
        self.own.offsets.insert(key, offset);
        self.offset_changed(&word);
        Ok(())
    }

    /// G64 without P of a `LinuxCNC` has no tolerance: "best possible speed, no matter how far away from the
    /// programmed point you end up".
    fn without_tolerance(&mut self) -> Option<f64> {
        if let stated @ Some(_) = self.settings.control.parameters.g64_tolerance_mm {
            return stated;
        }
        self.assume(
            "G64 without P rounds corners as far as the acceleration of the axes needs, without a tolerance: write G64 P0.01, or state \
             parameters.g64_tolerance_mm of the control file",
        );
        Some(NO_TOLERANCE_MM)
    }

    /// G61 G61.1 G62 G63 G64, G187.
    pub(crate) fn path_words(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(code) = p.g(Group::PathMode) else { return Ok(()) };
        let bound = |v: Option<f64>| match v {
            Some(v) if !(v >= 0.0 && v.is_finite()) => {
                Err(Fault::new(codes::BAD_VALUE, span, format!("the tolerance must not be negative and is {v}"))
                    .help("write G64 P0.01"))
            }
            v => Ok(v),
        };
        let continuous = |tolerance| PathMode::Continuous { tolerance, orientation_tolerance: None };
        let mode = match code {
            // LinuxCNC: exact path, corners are met but not stopped at when they are smooth.
            G61 if self.own.flavor.is_linuxcnc() => continuous(Some(0.0)),
            G61 => PathMode::ExactStop,
            G61_1 if self.own.flavor == Flavor::Fanuc && !self.own.assumed => {
                self.assume("G61.1 is the path mode of a Mazak and a Mitsubishi, which runs through the blocks: a Fanuc has no such word");
                continuous(None)
            }
            G61_1 => {
                if !self.own.flavor.is_linuxcnc() {
                    self.assume("G61.1 stops at every block, as on a LinuxCNC; on a Mazak and a Mitsubishi it makes corners more exact");
                }
                PathMode::ExactStop
            }
            G64 if self.own.flavor.is_linuxcnc() => {
                let written = bound(self.length_of(p, b'P'))?;
                let tolerance = written.or_else(|| self.without_tolerance());
                if let Some(q) = p.take(b'Q') {
                    self.note(format!("G64 Q{q}: straight blocks within this distance are joined"));
                }
                continuous(tolerance)
            }
            G187 => {
                if let Some(level) = p.take(b'P') {
                    self.note(format!("G187 P{level}"));
                }
                continuous(bound(self.length_of(p, b'E'))?)
            }
            G62 => {
                self.note("G62");
                continuous(None)
            }
            _ => continuous(None),
        };
        if (code == G63) != self.modal.tapping {
            // G63 fixes the overrides until another word of the group.
            self.modal.tapping = code == G63;
            let enabled = self.own.overrides && code != G63;
            self.emit(Op::Override(Override { enabled, feed: 1.0 }));
        }
        self.modal.path_mode = Some(mode);
        self.emit(Op::PathMode(mode));
        Ok(())
    }
}
