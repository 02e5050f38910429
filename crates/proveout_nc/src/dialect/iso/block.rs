//! Executes a block of words: collects them, then acts in the order of the control.
//!
//! Order within a block, whatever the order of the words: modal words, macro call, feed, speed,
//! tool, functions before the motion, dwell, compensation and length, work offset, path mode,
//! rotation and plane, words that act once, motion, functions after it (on a `LinuxCNC` only the
//! stops), subprogram call, end of program.
//!
//! A `LinuxCNC` (*G-code overview*, "G-code order of execution") does of the modal words only G93 to G95
//! first: F is read in the unit of the block before, the plane and the unit follow the dwell, G90, G98 and
//! the motion word the path mode.

use super::calls::whole;
use super::corners;
use super::flavor::Flavor;
use super::modal::{FeedMode, MotionMode};
use super::parser::{CHAMFER, IsoBlock, IsoWord, ROUNDING, WordValue};
use super::pending::{Full, Pending};
use super::run_state::Interpreter;
use super::words::{self, Function, GWordClass, Group};
use crate::channel::doubt::Stage;
use crate::codes;
use crate::control::words::WordKey;
use crate::control::{Control, DwellUnit, Meaning};
use crate::diagnostic::{Fault, Span, twice};
use crate::dialect::listed::{refused_by, unlisted};
use crate::g_code::*;
use crate::{Dwell, Op};

pub(crate) use crate::diagnostic::refused;

impl Interpreter {
    /// Executes the words and assignments of a block.
    pub(crate) fn execute(&mut self, block: &IsoBlock, line: &str) -> Result<(), Fault> {
        self.own.moved_in_block = false;
        self.own.no_cycle = block.no_cycle;
        let mut p = Pending::new();
        for word in &block.words {
            self.collect_word(&mut p, word, block)?;
        }
        // Words are read with the values before the assignments of the block.
        if !block.assignments.is_empty() {
            self.assign_all(&block.assignments, block.comment, line)?;
        }
        if block.words.is_empty() {
            return Ok(());
        }
        if let Some(&m) = p.m().last().filter(|m| **m < NOTED_G) {
            self.own.last_m = m;
        }
        for letter in p.vacant() {
            if self.own.noted_vacant.len() < MAX_VACANT && self.own.noted_vacant.insert((self.location.line, letter)) {
                self.note(format!("{} is left out: its variable has no value", char::from(letter)));
            }
        }
        self.recovery.faults.stage = Stage::Acting;
        self.act(&mut p, block)?;
        self.recovery.faults.stage = Stage::Acted;
        if let Some(letter) = p.left_over() {
            return Err(left_over(letter, block, line));
        }
        if p.corner_left() {
            return Err(corners::misplaced(block));
        }
        if self.own.modal_macro.is_some() && self.own.moved_in_block {
            self.after_motion(block.span)?;
        }
        Ok(())
    }

    fn collect_word(&self, p: &mut Pending, word: &IsoWord, block: &IsoBlock) -> Result<(), Fault> {
        let span = word.span;
        let (value, point) = match &word.value {
            WordValue::Number { value, point } => (*value, *point),
            WordValue::Expr(expr) => match self.value(expr, span)? {
                Some(value) => (value, true),
                // A parameter of a Fagor that nothing has set is zero.
                None if self.settings.control.depth_in_i => (0.0, true),
                // A word with a vacant parameter is left out.
                None => {
                    p.leave_out(word.letter);
                    return Ok(());
                }
            },
        };
        match word.letter {
            b'G' => {
                let code = g_code(value, span)?;
                match self.settings.control.words.g(code) {
                    Some((at, listed)) => self.put_listed(p, at, listed, span)?,
                    None => self.put_g(p, code, span)?,
                }
            }
            b'M' => {
                let code = whole(value, "M", 99_999_999.0, span)?;
                match self.settings.control.words.m(code) {
                    Some((at, listed)) => self.put_listed(p, at, listed, span)?,
                    None => self.put_m(p, code, span)?,
                }
            }
            b'@' | b'^' => {
                if !p.put_polar(word.letter == b'^', value) {
                    return Err(twice(char::from(word.letter), span));
                }
            }
            CHAMFER | ROUNDING => {
                if !p.put_corner(word.letter == ROUNDING, value) {
                    return Err(twice(char::from(word.letter.to_ascii_uppercase()), span));
                }
            }
            b'T' if p.has(b'T') && self.is_fanuc() && !is_macro_call(block) && p.put_second_tool(value) => {}
            letter => {
                // In a macro call only letters that are arguments may be repeated.
                if !p.put(letter, value, point) && (matches!(letter, b'P' | b'L') || !is_macro_call(block)) {
                    return Err(twice(char::from(letter), span));
                }
            }
        }
        Ok(())
    }

    /// A G word as the reader alone takes it.
    pub(super) fn put_g(&self, p: &mut Pending, code: GCode, span: Span) -> Result<(), Fault> {
        if code == RETURN_LEVEL && self.settings.control.stated_returns {
            return match p.put_g(code, Group::OneShot) {
                Ok(_) => Ok(()),
                Err(Full) => Err(too_many("G", span)),
            };
        }
        match words::class(self.own.flavor, self.own.assumed, &self.settings.control, code) {
            GWordClass::Known(group) => match p.put_g(code, group) {
                Ok(Some(other)) if group != Group::ExactStop && (other != code || self.own.flavor.is_linuxcnc()) => {
                    let message = format!("{other} and {code} exclude each other in a block");
                    Err(Fault::new(codes::CONFLICT, span, message).help("write them in blocks of their own"))
                }
                Ok(_) => Ok(()),
                Err(Full) => Err(too_many("G", span)),
            },
            // Noted with the functions; its values belong to it.
            GWordClass::Note => p.put_m(NOTED_G + code.tenths()).map_err(|Full| too_many("G", span)),
            GWordClass::Refused(remedy) => Err(refused(&code.to_string(), span, remedy)),
            GWordClass::Unknown => Err(unknown_g(self.own.flavor, code, span)),
        }
    }

    /// An M word as the reader alone takes it.
    pub(super) fn put_m(&self, p: &mut Pending, code: u32, span: Span) -> Result<(), Fault> {
        if let Some(fault) = refused_m(self.own.flavor, code, &self.settings.control, span) {
            return Err(fault);
        }
        self.check_function(p, code, span)?;
        p.put_m(code).map_err(|Full| too_many("M", span))
    }

    /// M words of one group exclude each other.
    fn check_function(&self, p: &Pending, code: u32, span: Span) -> Result<(), Fault> {
        let kind = words::function(self.own.flavor, code);
        for &other in p.m().iter().filter(|&&m| m < NOTED_G && m != code) {
            let clash = match (words::function(self.own.flavor, other), kind) {
                (Function::CoolantOn, Function::CoolantOff) | (Function::CoolantOff, Function::CoolantOn) => true,
                (a, b) => {
                    a == b && matches!(a, Function::Stop | Function::Spindle | Function::Call | Function::Override)
                }
            };
            if clash {
                let message = format!("M{other} and M{code} exclude each other in a block");
                return Err(Fault::new(codes::CONFLICT, span, message).help("write them in blocks of their own"));
            }
        }
        Ok(())
    }

    fn act(&mut self, p: &mut Pending, block: &IsoBlock) -> Result<(), Fault> {
        let span = block.span;
        if p.g(Group::Rotation) != Some(G68_2)
            && let Some(fault) = self.plane_is_open(span)
        {
            return Err(fault);
        }
        let call = p
            .m()
            .iter()
            .copied()
            .find(|m| matches!(m, 97 | 98 | 99 | 198))
            .filter(|&m| words::function(self.own.flavor, m) == Function::Call);
        let call_words = call.map(|_| (p.take(b'P'), p.take(b'L')));
        let linuxcnc = self.own.flavor.is_linuxcnc();
        if linuxcnc {
            self.refused_by_interpreter(p, span)?;
            if self.settings.control.grbl_words {
                self.refused_by_grbl(p, block)?;
            }
        }
        if !p.no_g() {
            if linuxcnc {
                self.feed_mode_word(p);
                if self.settings.control.grbl_words {
                    // F counts in the unit of its block.
                    self.unit_word(p, span)?;
                }
            } else {
                self.modal_words(p, span)?;
            }
            if p.g(Group::OneShot) == Some(G65) || p.g(Group::Macro) == Some(G66) {
                p.use_all();
                return self.macro_call(block, p.g(Group::Macro).is_some());
            }
            if p.g(Group::Macro) == Some(G67) {
                self.own.modal_macro = None;
            }
        }
        self.fagor_cycle_words(p);
        if self.listed_macro(p, block)? {
            return Ok(());
        }
        if self.own.flavor.is_linuxcnc() && p.has_m(19) && p.g(Group::PathMode).is_some() {
            let word = p.g(Group::PathMode).unwrap_or(G64);
            let message = format!("{word} and M19 in one block: both take P, Q and R");
            return Err(Fault::new(codes::CONFLICT, span, message).help("write them in blocks of their own"));
        }
        let one_shot = p.g(Group::OneShot);
        let thread_lead = self.modal.motion == Some(MotionMode::Thread) && !self.own.flavor.is_linuxcnc();
        let dwell_in_f = one_shot == Some(G4) && self.settings.control.dwell_unit(b'F').is_some();
        if !(dwell_in_f || thread_lead && p.axes() != 0) {
            self.feed_word(p, span)?;
        }
        self.speed_words(p, one_shot, span)?;
        self.tool_word(p, span)?;
        if !p.m().is_empty() {
            self.functions_before(p, span)?;
        }
        if one_shot == Some(G4) {
            self.dwell(p, span)?;
        }
        if linuxcnc && !p.no_g() {
            self.plane_word(p);
            self.unit_word(p, span)?;
        }
        self.compensation_words(p, span)?;
        self.length_words(p, span)?;
        if !p.no_g() {
            self.offset_word(p, span)?;
            self.path_words(p, span)?;
            if linuxcnc {
                self.distance_words(p);
                self.motion_words(p);
            }
            self.rotation_words(p, span)?;
            // A word of the control file may have called one.
            if let Some(code) = p.g(Group::OneShot) {
                self.one_shot(code, p, span)?;
            }
        }
        self.motion_with_corner(p, span)?;
        if !p.m().is_empty() {
            self.functions_after(p);
        }
        self.second_tool_word(p, span)?;
        if let (Some(m), Some((program, times))) = (call, call_words) {
            match m {
                97 => self.call_local(program, times, span)?,
                99 => self.return_from_sub(program, span)?,
                _ => self.call_sub(program, times, span)?,
            }
        }
        self.listed_call(p, span)?;
        if p.has_m(2) || p.has_m(30) {
            self.end_of_program();
        }
        if self.modal.feed_mode == FeedMode::InverseTime {
            // Inverse time holds for one block.
            self.own.feed = None;
        }
        Ok(())
    }

    /// Words that set how the others are read; a `LinuxCNC` does them one by one, between other words of the
    /// block.
    fn modal_words(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        self.unit_word(p, span)?;
        self.feed_mode_word(p);
        self.plane_word(p);
        self.distance_words(p);
        self.motion_words(p);
        Ok(())
    }

    /// G20, G21, G70, G71.
    fn unit_word(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(code) = p.g(Group::Units) else { return Ok(()) };
        let before = self.modal.unit();
        if matches!(code, G70 | G71) {
            let cycle: &[u8] = if self.own.flavor.is_linuxcnc() { b"DEIPQR" } else { b"PQRUW" };
            if p.any_free(cycle) {
                return Err(refused(&code.to_string(), span, words::TURNING));
            }
            let unit = if code == G70 { "inch" } else { "mm" };
            let other = if self.own.flavor.is_linuxcnc() {
                "as on a Mach3; on a LinuxCNC it is a cycle of turning"
            } else {
                "where no word identifies the control; on others it is a cycle"
            };
            self.assume(format!("{code} sets lengths in {unit}, {other}"));
        }
        self.modal.inch = Some(matches!(code, G20 | G70));
        if before != self.modal.unit() && !self.own.flavor.is_linuxcnc() {
            self.own.feed = None;
            if p.has(b'F') {
                let unit = if self.modal.inch == Some(true) { "inch" } else { "mm" };
                self.note(format!("F in the block of {code} counts in {unit}: the unit of its own block"));
            }
        }
        Ok(())
    }

    /// G93, G94, G95.
    fn feed_mode_word(&mut self, p: &Pending) {
        let Some(code) = p.g(Group::FeedMode) else { return };
        let mode = match code {
            G93 => FeedMode::InverseTime,
            G94 => FeedMode::PerTime,
            _ => FeedMode::PerRevolution,
        };
        // A number keeps no meaning across modes: F must be programmed again. The interpreter of a
        // LinuxCNC forgets the feed at each of these words (`convert_feed_mode`).
        if self.modal.feed_mode != mode || self.is_rs274() {
            self.modal.feed_mode = mode;
            self.own.feed = None;
        }
    }

    /// G17, G18, G19.
    fn plane_word(&mut self, p: &Pending) {
        let Some(code) = p.g(Group::Plane) else { return };
        self.modal.normal = match code {
            G17 => 2,
            G18 => 1,
            _ => 0,
        };
        self.emit(Op::Plane(['X', 'Y', 'Z'][self.modal.normal]));
    }

    /// G90, G91, G90.1, G91.1, G98, G99, G15, G16.
    fn distance_words(&mut self, p: &Pending) {
        if let Some(code) = p.g(Group::Distance) {
            self.modal.incremental = code == G91;
        }
        if let Some(code) = p.g(Group::ArcDistance) {
            self.modal.absolute_centers = code == G90_1;
        }
        if let Some(code) = p.g(Group::Return) {
            self.modal.return_to_r = Some(code == G99);
        }
        if let Some(code) = p.g(Group::Polar) {
            self.modal.polar = code == G16;
            (self.modal.polar_radius, self.modal.polar_angle) = (None, None);
        }
    }

    fn motion_words(&mut self, p: &Pending) {
        if let Some(code) = p.g(Group::Motion) {
            self.motion_word(code);
        }
        if let Some(code) = p.g(Group::Cycle) {
            if code == G80 && self.settings.control.stated_returns && self.modal.cycle.is_some() {
                self.spindle_off();
            }
            self.cycle_word(code);
        }
    }

    fn motion_word(&mut self, code: GCode) {
        self.modal.motion_code = code;
        if code >= G73 {
            // LinuxCNC: cycles are in this group.
            self.modal.motion = None;
            self.cycle_word(code);
            return;
        }
        self.cycle_word(G80);
        self.modal.motion = Some(match code {
            G0 => MotionMode::Rapid,
            G1 => MotionMode::Linear,
            G2 => MotionMode::Clockwise,
            G3 => MotionMode::CounterClockwise,
            G33 | G33_1 => MotionMode::Thread,
            G5 | G5_1 => MotionMode::Spline,
            G5_2 | G5_3 => MotionMode::Nurbs,
            _ => MotionMode::Probe,
        });
        if code != G5 {
            self.own.spline_end = None;
        }
        if !matches!(code, G5_2 | G5_3) {
            self.own.nurbs = None;
        }
    }

    /// G4. Fanuc: P in milliseconds, X or U in seconds; Haas: P in milliseconds, with a decimal point in
    /// seconds; `LinuxCNC`: P in seconds.
    fn dwell(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let point = p.has_point(b'P');
        let in_p = p.take(b'P');
        // Other axis words belong to the motion, which a `LinuxCNC` makes after the dwell.
        let moves = self.own.flavor.is_linuxcnc() || self.own.assumed && in_p.is_some();
        let mut in_x = if moves { None } else { p.take(b'X').or_else(|| p.take(b'U')) };
        let mut stated = 0;
        for letter in *b"XUFK" {
            let Some(unit) = self.settings.control.dwell_unit(letter) else { continue };
            let point = p.has_point(letter);
            if let Some(value) = p.peek(letter) {
                stated += 1;
                let another = in_x.is_some() && !(letter == b'X' && stated == 1) && (letter != b'U' || p.has(b'X'));
                if another || stated > 1 {
                    return Err(Fault::new(codes::CONFLICT, span, "G4 has more than one time")
                        .help("write one of them, such as G4 F2"));
                }
                p.use_up(&[letter]);
                in_x = Some(unit.seconds(value, point));
            }
        }
        if let (Some(value), true) = (in_p, point)
            && self.own.flavor == Flavor::Fanuc
            && !self.own.assumed
            && self.settings.control.dwell_unit(b'P').is_none()
            && value.fract() == 0.0
        {
            let text = format!(
                "P of G4 is {value} ms though it has a decimal point, which a Fanuc does not take there: write P{value} or X{}",
                value / 1000.0
            );
            self.assume(text);
        }
        let seconds = match (in_p, in_x) {
            (Some(p), None) => self.seconds(p, point, span)?,
            (None, Some(x)) => x,
            _ => {
                return Err(Fault::new(codes::MISSING_VALUE, span, "G4 needs one time").help(self.dwell_example()));
            }
        };
        if moves && !self.own.flavor.is_linuxcnc() && p.axes() != 0 {
            self.assume("the motion in the block of a G4 is made after the dwell");
        } else if !moves && p.axes() != 0 {
            return Err(Fault::new(codes::CONFLICT, span, "G4 cannot share a block with a motion")
                .help("write G4 in a block of its own"));
        }
        if seconds.is_nan() || seconds < 0.0 {
            return Err(Fault::new(codes::BAD_VALUE, span, "the dwell must not be negative").help(self.dwell_example()));
        }
        self.emit(Op::Dwell(Dwell::Seconds(seconds)));
        Ok(())
    }

    /// Half a second, as the control reads it.
    pub(crate) fn dwell_example(&self) -> String {
        let control = &self.settings.control;
        let spelled = |letter: u8, unit: DwellUnit| match unit {
            DwellUnit::Seconds => format!("G4 {}0.5 (seconds)", char::from(letter)),
            DwellUnit::Milliseconds | DwellUnit::MillisecondsOrSeconds => {
                format!("G4 {}500 (milliseconds)", char::from(letter))
            }
            DwellUnit::Hundredths => format!("G4 {}50 (hundredths of a second)", char::from(letter)),
        };
        // P of a control with another letter too is that of its cycles.
        let stated = b"FXUKP".iter().find_map(|&letter| Some(spelled(letter, control.dwell_unit(letter)?)));
        if let Some(stated) = stated {
            return format!("write {stated}");
        }
        match self.own.flavor {
            Flavor::LinuxCnc => "write G4 P0.5 (seconds)".to_owned(),
            Flavor::Haas => "write G4 P500 (milliseconds), or G4 P0.5 (seconds)".to_owned(),
            Flavor::Fanuc => "write G4 P500 (milliseconds), or G4 X0.5 (seconds)".to_owned(),
        }
    }

    /// Seconds of a word P.
    pub(crate) fn seconds(&self, value: f64, point: bool, span: Span) -> Result<f64, Fault> {
        if let Some(unit) = self.settings.control.dwell_unit(b'P') {
            return Ok(unit.seconds(value, point));
        }
        match self.own.flavor {
            Flavor::LinuxCnc => Ok(value),
            Flavor::Haas if point => Ok(value),
            // Both controls that take a decimal point read seconds.
            Flavor::Fanuc if point && self.own.assumed => Ok(value),
            Flavor::Fanuc if point && value.fract() != 0.0 => {
                Err(Fault::new(codes::BAD_VALUE, span, "P of a dwell takes whole milliseconds on a Fanuc")
                    .help("write P500 or X0.5"))
            }
            _ => Ok(value / 1000.0),
        }
    }
}

/// Most words without a value that notes report.
const MAX_VACANT: usize = 1000;

/// G71 on a control whose cycles come back to its level.
const RETURN_LEVEL: GCode = G71;
/// M52 to M54 on such a control: to the end of travel, to the level of G71, to the R plane.
pub(crate) const RETURNS: std::ops::RangeInclusive<u32> = 52..=54;

/// G words that are only noted are kept among the functions, by ten times their number above this one.
pub(crate) const NOTED_G: u32 = 1_000_000_000;
/// Numbers of M from here on are in no control file.
const M_LISTED: f64 = 1e9;
/// Numbers of M from here on are not told as words that no control file lists.
const M_TOLD: f64 = 1e8;

fn is_macro_call(block: &IsoBlock) -> bool {
    block.words.iter().any(|w| w.letter == b'G' && matches!(w.value, WordValue::Number { value: 65.0 | 66.0, .. }))
}

fn g_code(value: f64, span: Span) -> Result<GCode, Fault> {
    GCode::of(value).ok_or_else(|| {
        Fault::new(codes::BAD_VALUE, span, format!("G{value} is not a G word"))
            .help("write a G word of the coverage table")
    })
}

/// The set-up of the control decides what such a word switches to.
pub(crate) fn kinematics_switch(word: &str, span: Span) -> Fault {
    let message = format!(
        "`{word}` switches the kinematics of the control, and the result depends on the set-up of the control: it is \
         not supported"
    );
    let post = "post the program for positions of the axes";
    // An output whose effect depends on many things cannot be listed as one switch.
    let help = if word.contains(' ') {
        format!("{post}, or for a control whose words are known (G43.4, G234, TRAORI, M128 of a TNC)")
    } else {
        format!(
            "say in a control file what it switches, [words] {word} = {{ kinematics = \"tcp-on\" }} or \"tcp-off\", or {post}"
        )
    };
    Fault::new(codes::UNSUPPORTED_WORD, span, message).help(help)
}

fn too_many(letter: &str, span: Span) -> Fault {
    Fault::new(codes::BAD_VALUE, span, format!("the block has too many {letter} words")).help("write several blocks")
}

fn left_over(letter: u8, block: &IsoBlock, line: &str) -> Fault {
    let span = block.words.iter().find(|w| w.letter == letter).map_or(block.span, |w| w.span);
    let text = line.get(span.start as usize..span.end as usize).unwrap_or_default();
    let axis = matches!(letter, b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C' | b'U' | b'V' | b'W');
    if axis {
        return Fault::new(codes::MISSING_VALUE, span, format!("`{text}` without a motion word in force"))
            .help("write G0 or G1 before it");
    }
    let help = match letter {
        b'R' => "a rounding has a comma before it, `,R2`, and the radius of an arc needs G2 or G3; else remove it",
        _ => "remove it, or write the G word that it belongs to",
    };
    Fault::new(codes::UNKNOWN_WORD, span, format!("`{text}` has no meaning in this block")).help(help)
}

/// The fault of a word that no state of the control makes valid.
pub(crate) fn refused_word(flavor: Flavor, assumed: bool, control: &Control, word: &IsoWord) -> Option<Fault> {
    let WordValue::Number { value, .. } = word.value else { return None };
    let listed = match word.letter {
        b'G' => control.words.g(g_code(value, word.span).ok()?),
        b'M' if (0.0..M_LISTED).contains(&value) => control.words.m(value as u32),
        _ => return None,
    };
    if let Some((_, listed)) = listed {
        let Meaning::Refuse(remedy) = &listed.meaning else { return None };
        return Some(refused_by(control, &listed.word, word.span, remedy));
    }
    if word.letter == b'M' {
        return refused_m(flavor, value as u32, control, word.span);
    }
    let code = g_code(value, word.span).ok()?;
    if code == RETURN_LEVEL && control.stated_returns {
        return None;
    }
    match words::class(flavor, assumed, control, code) {
        GWordClass::Refused(remedy) => Some(refused(&code.to_string(), word.span, remedy)),
        GWordClass::Unknown => Some(unknown_g(flavor, code, word.span)),
        _ => None,
    }
}

/// A G or M word that neither the reader nor the control file gives a meaning, and what the reader does with
/// it.
pub(crate) fn unlisted_word(
    flavor: Flavor,
    assumed: bool,
    control: &Control,
    word: &IsoWord,
) -> Option<(WordKey, &'static str)> {
    let WordValue::Number { value, .. } = word.value else { return None };
    match word.letter {
        b'G' => {
            let code = g_code(value, word.span).ok()?;
            if code == RETURN_LEVEL && control.stated_returns {
                return None;
            }
            let now = match words::class(flavor, assumed, control, code) {
                GWordClass::Unknown => "refused: unknown",
                GWordClass::Refused(_) => "refused: not supported",
                GWordClass::Known(_) | GWordClass::Note => return None,
            };
            control.words.g(code).is_none().then_some((WordKey::G(code), now))
        }
        b'M' if (0.0..M_TOLD).contains(&value) => {
            let code = value as u32;
            if RETURNS.contains(&code) && control.stated_returns {
                return None;
            }
            let now = match words::function(flavor, code) {
                Function::Note if control.refuses_unlisted => "refused: unknown",
                Function::Note => "a note, without effect",
                Function::Refused(_) | Function::Kinematics => "refused: not supported",
                _ => return None,
            };
            control.words.m(code).is_none().then_some((WordKey::M(code), now))
        }
        _ => None,
    }
}

fn unknown_g(flavor: Flavor, code: GCode, span: Span) -> Fault {
    let name = code.to_string();
    let fault =
        Fault::new(codes::UNKNOWN_WORD, span, format!("unknown word `{name}` for the {} reader", flavor.name()));
    let help = "see the coverage table for the G words that are read, or give the word a meaning in a control file";
    match words::classify(Flavor::Haas, code) {
        // What a Haas has and no other control may be what the program was written for.
        GWordClass::Known(_) | GWordClass::Note if flavor == Flavor::Fanuc => {
            fault.help(format!("{name} is a word of a Haas: --control haas-ngc reads it; else {help}"))
        }
        _ if flavor == Flavor::LinuxCnc && code == G50 => fault.help(format!(
            "a PathPilot cancels a scale with it; a file for --control leaves it out: inherits = \"linuxcnc-2.9\", \
             [words] G50 = {{ ignore = \"no scale is in force\" }}; else {help}"
        )),
        _ => fault.help(help),
    }
}

/// The fault of an M word that the control file does not list.
fn refused_m(flavor: Flavor, code: u32, control: &Control, span: Span) -> Option<Fault> {
    if RETURNS.contains(&code) && control.stated_returns {
        let remedy = "cycles come back to the end of travel, which the reader does not know: write M53 or M54";
        return (code == 52).then(|| refused("M52", span, remedy));
    }
    match words::function(flavor, code) {
        Function::Refused(remedy) => Some(refused(&format!("M{code}"), span, remedy)),
        Function::Kinematics => Some(kinematics_switch(&format!("M{code}"), span)),
        Function::Note if control.refuses_unlisted => Some(unlisted(control, &format!("M{code}"), span)),
        _ => None,
    }
}
