//! Feed, spindle, tool, coolant and machine functions.

use super::block::{NOTED_G, RETURNS, kinematics_switch};
use super::calls::whole;
use super::listed::LISTED;
use super::modal::FeedMode;
use super::pending::Pending;
use super::run_state::Interpreter;
use super::words::{self, Function, Group};
use crate::channel::direction_of;
use crate::codes;
use crate::control::WholeNumbers;
use crate::diagnostic::{Fault, Span};
use crate::g_code::{G50, G92, G96, G97, GCode};
use crate::{Feed, Op, Override, SpindleDirection, ToolName};

/// The analog output that selects the kinematics in the documentation of `LinuxCNC` and in the configurations
/// that come with it.
const KINEMATICS_OUTPUT: f64 = 3.0;

/// A word that has this meaning on lathes only: *Operator's manual (lathe system)*, "Maximum spindle speed
/// clamp" and "Threading cycle (G92)".
pub(super) fn of_a_lathe(word: &str, does: &str, span: Span) -> Fault {
    Fault::new(
        codes::UNSUPPORTED_WORD,
        span,
        format!("`{word}` {does} on a lathe, and turning is not part of the twin"),
    )
    .help("prove out milling programs; the speed limit of a mill is G92 S")
}

/// Bits of X, Y and Z.
pub(crate) const LINEAR: u16 = 0b111;

impl Interpreter {
    pub(crate) fn feed_word(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(value) = p.take(b'F') else { return Ok(()) };
        if !(value >= 0.0 && value.is_finite()) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("the feed must be above zero and is {value}"))
                .help("write F100"));
        }
        // F0 is no feed: a motion that needs one is refused.
        self.own.feed = (value > 0.0).then_some(value);
        self.own.feed_unit = self.modal.unit();
        if self.modal.feed_mode != FeedMode::InverseTime && value > 0.0 {
            self.tell_feed_word(value, false);
        }
        Ok(())
    }

    /// Hands the feed out when it differs from the last one.
    fn tell_feed_word(&mut self, value: f64, rotary_only: bool) {
        // Without a linear axis the number is degrees, in every unit of length.
        let unit = if rotary_only { 1.0 } else { self.own.feed_unit };
        let feed = match self.modal.feed_mode {
            FeedMode::PerTime => Feed::PerTime(value * unit / 60.0),
            FeedMode::PerRevolution => Feed::PerRevolution(value * unit),
            FeedMode::InverseTime => Feed::InverseTime(60.0 / value),
        };
        self.set_feed(Some(feed));
    }

    /// Before a motion in feed of these axes.
    pub(crate) fn need_feed(&mut self, axes: u16, span: Span) -> Result<(), Fault> {
        if let Some(feed) = self.own.feed {
            self.tell_feed_word(feed, axes & !0b111000 == 0 && axes != 0);
            return Ok(());
        }
        if self.modal.feed_mode == FeedMode::PerTime
            && let Some(mm_min) = self.default_feed()
        {
            let feed = mm_min / self.modal.unit();
            self.own.feed = Some(feed);
            self.own.feed_unit = self.modal.unit();
            self.tell_feed_word(feed, axes & !0b111000 == 0 && axes != 0);
            return Ok(());
        }
        Err(self.no_feed(span))
    }

    pub(crate) fn no_feed(&self, span: Span) -> Fault {
        let (message, help) = if self.modal.feed_mode == FeedMode::InverseTime {
            ("G93 needs F in every block with a feed motion", "write F in this block")
        } else {
            ("the motion has no feed", "write F before or in this block")
        };
        Fault::new(codes::NO_FEED, span, message).help(help)
    }

    /// S, G96, G97, and the speed limit of G92 S.
    pub(crate) fn speed_words(&mut self, p: &mut Pending, one_shot: Option<GCode>, span: Span) -> Result<(), Fault> {
        let mode = p.g(Group::SpindleMode);
        let limit = if mode == Some(G96) && self.own.flavor.is_linuxcnc() { p.take(b'D') } else { None };
        let Some(speed) = p.take(b'S') else {
            if mode == Some(G96) {
                return Err(
                    Fault::new(codes::MISSING_VALUE, span, "G96 has no S").help("write the surface speed: G96 S200")
                );
            }
            if mode == Some(G97) {
                self.modal.surface = None;
            }
            return Ok(());
        };
        let speed = Self::checked_speed(speed, span)?;
        if one_shot == Some(G92) && p.axes() == 0 {
            if let Some((_, highest)) = &mut self.modal.surface {
                *highest = speed;
            }
            self.note(format!("G92 S{speed}: highest spindle speed"));
            p.use_up(b"G");
            return Ok(());
        }
        if mode == Some(G96) || mode.is_none() && self.modal.surface.is_some() {
            let highest = limit.or(self.modal.surface.map(|(_, highest)| highest)).unwrap_or(f64::INFINITY);
            let unit = if self.modal.inch == Some(true) { 0.3048 } else { 1.0 };
            self.modal.surface = Some((speed * unit, highest));
            return Ok(());
        }
        self.modal.surface = None;
        self.set_speed(speed, p.m().iter().any(|m| matches!(m, 3..=5)));
        Ok(())
    }

    /// G96: the speed for the radius X at the end of a motion.
    pub(crate) fn surface_speed(&mut self, x: Option<f64>) {
        let Some((surface, highest)) = self.modal.surface else { return };
        let Some(x) = x else { return };
        let speed = (1000.0 * surface / (std::f64::consts::TAU * x.abs())).min(highest);
        if !speed.is_finite() {
            // The spindle would turn as fast as it can: what that is the machine says.
            if !std::mem::replace(&mut self.own.noted_surface_speed, true) {
                self.assume(
                    "G96 has no highest speed at X0: the speed before stays, where the spindle would turn as fast as it can; write G92 S, or D on a LinuxCNC",
                );
            }
            return;
        }
        self.set_speed(speed, false);
    }

    pub(crate) fn tool_word(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(tool) = p.take(b'T') else { return Ok(()) };
        let number = whole(tool, "T", 99_999_999.0, span)?;
        let tool = if number == 0 { ToolName::Empty } else { ToolName::Number(number) };
        self.select_tool(tool);
        Ok(())
    }

    /// `T1 T2 M6`: the first tool goes into the spindle, the second is made ready.
    pub(crate) fn second_tool_word(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let Some(number) = p.second_tool() else { return Ok(()) };
        if !p.has_m(6) {
            return Err(Fault::new(codes::CONFLICT, span, "`T` appears twice in a block without M6").help("remove one"));
        }
        let number = whole(number, "T", 99_999_999.0, span)?;
        let tool = if number == 0 { ToolName::Empty } else { ToolName::Number(number) };
        self.assume("of two T words with M6 the first tool goes into the spindle, and the second is preselected");
        self.select_tool(tool);
        Ok(())
    }

    pub(crate) fn functions_before(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let early = self.own.flavor.is_linuxcnc();
        let list: Vec<u32> = p.m().to_vec();
        for m in list {
            if m >= LISTED {
                self.listed_word(m, p, span)?;
                continue;
            }
            if m == NOTED_G + G50.tenths() && p.has(b'S') {
                return Err(of_a_lathe("G50 S", "limits the speed of the spindle", span));
            }
            if m == NOTED_G + G50.tenths() && self.is_scaled() {
                self.scaling(G50, p, span)?;
                continue;
            }
            if m >= NOTED_G {
                self.note_with_values(&GCode::from_tenths(m - NOTED_G).to_string(), p);
                continue;
            }
            if RETURNS.contains(&m) && self.settings.control.stated_returns {
                self.modal.back_to_level = Some(m == 53);
                continue;
            }
            match words::function(self.own.flavor, m) {
                Function::Spindle if m != 5 => {
                    self.technology.direction = direction_of(f64::from(m));
                    if self.modal.surface.is_none() || self.technology.speed.is_some() {
                        self.tell_spindle();
                    }
                }
                Function::Spindle if early => self.spindle_off(),
                Function::CoolantOff if early => self.coolant(m),
                Function::ToolChange => self.tool_change(span)?,
                Function::CoolantOn => self.coolant(m),
                Function::Override => {
                    self.own.overrides = m == 48;
                    self.emit(Op::Override(Override { enabled: m == 48, feed: 1.0 }));
                }
                Function::Orient => {
                    self.note_with_values("M19", p);
                    if self.technology.direction != SpindleDirection::Off {
                        self.spindle_off();
                    }
                }
                Function::Rigid => {
                    self.modal.rigid = true;
                    self.note("M29");
                }
                Function::State => self.state_word(m, p, span)?,
                Function::AnalogOutput if p.peek(b'E') == Some(KINEMATICS_OUTPUT) => {
                    return Err(kinematics_switch(&format!("M{m} E{KINEMATICS_OUTPUT}"), span));
                }
                Function::Note | Function::AnalogOutput => self.note_with_values(&format!("M{m}"), p),
                _ => {}
            }
        }
        Ok(())
    }

    /// A word of the machine builder with the values that go with it.
    fn note_with_values(&mut self, word: &str, p: &mut Pending) {
        let mut text = word.to_owned();
        // A LinuxCNC calls the cycle in force only in blocks with a place.
        let cycle = if self.is_rs274() {
            self.motion_to_be(p).is_some_and(|code| matches!(code, GCode(73 | 74 | 81..=89, 0)))
        } else {
            self.modal.cycle.is_some()
        };
        for letter in *b"PQERLK" {
            // In a cycle these are its own.
            if !cycle
                && p.any_free(&[letter])
                && let Some(value) = p.take(letter)
            {
                text.push_str(&format!(" {}{value}", char::from(letter)));
            }
        }
        self.note(text);
    }

    fn tool_change(&mut self, span: Span) -> Result<(), Fault> {
        let tool = self.selected_tool(span)?;
        self.forget_kept();
        if self.is_rs274() && self.technology.direction != SpindleDirection::Off {
            self.spindle_off();
        }
        self.change_to(tool);
        Ok(())
    }

    fn change_to(&mut self, tool: ToolName) {
        // On a LinuxCNC X and Y stay.
        let stays = self.own.flavor.is_linuxcnc() && !self.modal.in_table() && !self.position.frame().is_rotated();
        self.change_tool(tool, if stays { 0b100 } else { LINEAR });
        let end = self.settings.control.tool_change;
        let axes = (0..9).fold(0, |axes, axis| axes | u16::from(end.get(axis).is_some()) << axis);
        if axes != 0 {
            // The control file says where M6 leaves these axes.
            self.goes_in_machine(end, axes);
        } else if let Some(points) = &self.settings.reference_points {
            // The machine says where it drives them.
            let end = points.tool_change;
            let axes = (0..3).fold(0, |axes, axis| axes | u16::from(end.get(axis).is_some()) << axis);
            if axes != 0 {
                self.position.forget(axes);
                self.known_in_machine(&end, axes);
            }
        }
    }

    /// M61 Q, M70, M72.
    fn state_word(&mut self, m: u32, p: &mut Pending, span: Span) -> Result<(), Fault> {
        match m {
            61 => {
                let Some(number) = p.take(b'Q') else {
                    return Err(Fault::new(codes::MISSING_VALUE, span, "M61 has no Q").help("write M61 Q5"));
                };
                let number = whole(number, "Q", 99_999.0, span)?;
                self.change_to(if number == 0 { ToolName::Empty } else { ToolName::Number(number) });
            }
            70 => self.own.kept_modal = Some(Box::new(self.modal.clone())),
            _ => {
                let Some(kept) = self.own.kept_modal.clone() else {
                    return Err(Fault::new(codes::STRUCTURE, span, "M72 has no M70 before it").help("write M70"));
                };
                // Offsets stay: M70 keeps the modal words, not the values of the coordinate systems.
                let frames = self.modal.frames.clone();
                let (offset, length) = (self.modal.offset.clone(), self.modal.length);
                if kept.offset != offset || kept.length != length {
                    return Err(Fault::new(
                        codes::UNSUPPORTED_WORD,
                        span,
                        "M72 would change the work offset or the tool length",
                    )
                    .help("write G54 and G43 instead"));
                }
                self.modal = *kept;
                self.modal.frames = frames;
                self.emit(Op::Plane(['X', 'Y', 'Z'][self.modal.normal]));
                if let Some(mode) = self.modal.path_mode {
                    self.emit(Op::PathMode(mode));
                }
                self.own.feed = None;
            }
        }
        Ok(())
    }

    pub(crate) fn spindle_off(&mut self) {
        self.spindle(SpindleDirection::Off);
    }

    pub(crate) fn functions_after(&mut self, p: &Pending) {
        let early = self.own.flavor.is_linuxcnc();
        for &m in p.m() {
            match m {
                5 if !early => self.spindle_off(),
                9 if !early => self.coolant(9),
                0 | 1 => self.emit(Op::Stop { optional: m == 1 }),
                60 if early => self.emit(Op::Stop { optional: false }),
                _ => {}
            }
        }
    }

    /// A length of the program in mm.
    pub(crate) fn length_of(&self, p: &mut Pending, letter: u8) -> Option<f64> {
        let point = p.has_point(letter);
        p.take(letter).map(|value| self.mm(value, point))
    }

    /// mm of a length as written.
    pub(crate) fn mm(&self, value: f64, point: bool) -> f64 {
        match self.settings.whole_numbers {
            WholeNumbers::Increments { inch, .. }
                if !point && self.has_increments() && self.modal.inch == Some(true) =>
            {
                value * inch * 25.4
            }
            WholeNumbers::Increments { mm, .. } if !point && self.has_increments() => value * mm,
            _ => value * self.modal.unit(),
        }
    }

    /// Radian of the word of a rotary axis as written.
    pub(crate) fn rotary_of(&self, p: &mut Pending, letter: u8) -> Option<f64> {
        let point = p.has_point(letter);
        p.take(letter).map(|value| match self.settings.whole_numbers {
            WholeNumbers::Increments { deg, .. } if !point && self.has_increments() => (value * deg).to_radians(),
            _ => value.to_radians(),
        })
    }

    /// A `LinuxCNC` reads every number as it is written.
    fn has_increments(&self) -> bool {
        !self.own.flavor.is_linuxcnc()
    }
}
