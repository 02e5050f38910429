//! Collects the words of a block; [`super::act`] executes them.

use super::eval::{self, Val};
use super::expr::Expr;
use super::modal::{FeedMode, Interpolation, SplineEnd, SplineKind, Units};
use super::parser::{AddressValue, Call, SiemensBlock, Word, WordKind};
use super::pending::ToolFrame;
use super::pending::{Coordinate, FrameWord, Pending, Reference};
use super::run_state::Interpreter;
use super::words::{self, Class};
use crate::channel::doubt::Stage;
use crate::codes;
use crate::control::words::WordKey;
use crate::control::{Control, Meaning, OrientationAngles};
use crate::diagnostic::{Fault, FaultSubject, Span, twice};
use crate::dialect::listed::{WordState, refused_by, unlisted};
use crate::g_code::GCode;
use crate::{AxisValues, Op, OrientationInterpolation, PathMode, ToolName};

pub(crate) use crate::diagnostic::refused;

/// Bits of X, Y and Z.
pub(super) const LINEAR: u16 = 0b111;
/// Tool numbers from here on are none: they are whole numbers of 32 bits.
const TOOL_NUMBERS: f64 = 4.0e9;
/// Numbers of G from here on are in no control file.
const G_LISTED: f64 = 1e6;
/// Numbers of M from here on are in no control file.
const M_LISTED: f64 = 1e9;
/// Numbers of G from here on are not told as words that no control file lists.
const G_TOLD: f64 = 1e4;
/// Numbers of M from here on are not told as words that no control file lists.
const M_TOLD: f64 = 1e8;

impl Interpreter {
    /// Executes the words of a block.
    pub(crate) fn execute(&mut self, block: &SiemensBlock, line: &str) -> Result<(), Fault> {
        if self.own.curve.is_some()
            && let Err(cut) = self.curve_before(block)
        {
            // If the block that cut the curve short is faulty itself, its own fault is returned.
            return Err(self.fault_of_words(block, line).unwrap_or(cut));
        }
        let mut pending = Pending::default();
        for (at, word) in block.words.iter().enumerate() {
            self.collect(&mut pending, word, at, line)?;
        }
        self.recovery.faults.stage = Stage::Acting;
        if self.own.curve.is_some() {
            self.curve_into(&pending, block, block.span)?;
        }
        self.act(&mut pending, block)
    }

    /// Faults in the words of a block that do not depend on the state in force; sets no variables.
    fn fault_of_words(&mut self, block: &SiemensBlock, line: &str) -> Option<Fault> {
        let mut pending = Pending::default();
        let sets = |kind: &WordKind| matches!(kind, WordKind::Assign { .. } | WordKind::Address { letter: b'R', .. });
        let mut words = block.words.iter().enumerate().filter(|(_, word)| !sets(&word.kind));
        words.find_map(|(at, word)| self.collect(&mut pending, word, at, line).err())
    }

    fn collect(&mut self, pending: &mut Pending, word: &Word, at: usize, line: &str) -> Result<(), Fault> {
        let span = word.span;
        match &word.kind {
            WordKind::Address { letter, extension: None, value } => self.address(pending, *letter, value, span, line),
            WordKind::Address { letter, extension: Some(extension), value } => {
                self.extended_address(pending, *letter, *extension, value, span, line)
            }
            WordKind::Assign { name, indices, value } => self.assignment(pending, name, indices, value, span, line),
            WordKind::Name(name) => self.name(pending, name, span, at),
            WordKind::Call(call) => self.call_word(pending, call, span, at),
        }
    }

    fn number(&self, value: &AddressValue, span: Span) -> Result<f64, Fault> {
        match value {
            AddressValue::Number(number) => Ok(*number),
            AddressValue::Expr(expr) => self.variables.number(expr, span),
        }
    }

    /// A number that must be an integer from 0 to a limit.
    fn integer(&self, letter: char, value: &AddressValue, limit: u32, span: Span) -> Result<u32, Fault> {
        let number = self.number(value, span)?;
        if number.fract() == 0.0 && (0.0..=f64::from(limit)).contains(&number) {
            return Ok(number as u32);
        }
        Err(Fault::new(
            codes::BAD_VALUE,
            span,
            format!("`{letter}` takes an integer from 0 to {limit} and has {number}"),
        )
        .help("write a whole number"))
    }

    /// Coordinate of an address.
    #[inline]
    fn coordinate(&self, value: &AddressValue, span: Span) -> Result<Coordinate, Fault> {
        match value {
            AddressValue::Number(value) => Ok(Coordinate { value: *value, reference: Reference::Modal }),
            AddressValue::Expr(expr) => self.coordinate_of(expr, span),
        }
    }

    /// Coordinate with `AC()`, `IC()`, `DC()`, `ACP()`, `ACN()`.
    pub(super) fn coordinate_of(&self, expr: &Expr, span: Span) -> Result<Coordinate, Fault> {
        if let Expr::Call(name, arguments) = expr {
            let reference = match name.as_str() {
                "AC" => Some(Reference::Absolute),
                "IC" => Some(Reference::Incremental),
                "DC" => Some(Reference::Shortest),
                "ACP" => Some(Reference::Positive),
                "ACN" => Some(Reference::Negative),
                _ => None,
            };
            if let Some(reference) = reference {
                let [Some(argument)] = arguments.as_slice() else {
                    return Err(
                        Fault::new(codes::ARGUMENTS, span, format!("`{name}` takes one value")).help("write X=AC(10)")
                    );
                };
                return Ok(Coordinate { value: self.variables.number(argument, span)?, reference });
            }
        }
        Ok(Coordinate { value: self.variables.number(expr, span)?, reference: Reference::Modal })
    }

    fn address(
        &mut self,
        p: &mut Pending,
        letter: u8,
        value: &AddressValue,
        span: Span,
        line: &str,
    ) -> Result<(), Fault> {
        let character = char::from(letter);
        if let Some(axis) = AxisValues::index(character) {
            set_once(p.axes[axis].is_some(), character, span)?;
            p.axes[axis] = Some(self.coordinate(value, span)?);
            p.programmed |= 1 << axis;
            return Ok(());
        }
        match letter {
            b'G' => return self.g_word(p, value, span),
            b'M' => {
                let code = self.integer('M', value, 99_999_999, span)?;
                self.m_word(p, code, span)?;
            }
            b'I' | b'J' | b'K' => {
                let at = usize::from(letter - b'I');
                set_once(p.center[at].is_some(), character, span)?;
                p.center[at] = Some(self.coordinate(value, span)?);
            }
            b'F' => put_once(&mut p.feed, self.number(value, span)?, "F", span)?,
            b'S' => put_once(&mut p.speed, self.number(value, span)?, "S", span)?,
            b'D' => put_once(&mut p.edge, self.integer('D', value, 32_000, span)?, "D", span)?,
            b'T' => put_once(&mut p.tool, self.tool_name(value, span)?, "T", span)?,
            b'L' => put_once(&mut p.numbered_call, self.integer('L', value, 9_999_999, span)?, "L", span)?,
            b'P' => put_once(&mut p.passes, self.integer('P', value, 9_999, span)?, "P", span)?,
            b'H' => {
                let number = self.number(value, span)?;
                self.note(format!("H{number}"));
            }
            b'R' => {
                return Err(Fault::new(codes::SYNTAX, span, "an R parameter is assigned with `=`").help("write R1=5"));
            }
            _ => return Err(unknown_word(span, line)),
        }
        Ok(())
    }

    fn extended_address(
        &mut self,
        p: &mut Pending,
        letter: u8,
        extension: u32,
        value: &AddressValue,
        span: Span,
        line: &str,
    ) -> Result<(), Fault> {
        match (letter, extension) {
            (b'R', _) => {
                let number = self.number(value, span)?;
                self.variables.assign_param(extension, number);
            }
            (b'X'..=b'Z' | b'A'..=b'C' | b'U'..=b'W', 1) if letter != b'R' => {
                let axis = AxisValues::index(char::from(letter)).unwrap_or_default();
                set_once(p.axes[axis].is_some(), char::from(letter), span)?;
                p.axes[axis] = Some(self.coordinate(value, span)?);
                p.programmed |= 1 << axis;
                p.machine_axes |= 1 << axis;
            }
            (b'A'..=b'C', 2 | 3) => {
                if extension == 2 {
                    self.orientation_angles();
                }
                let slots = if extension == 3 { &mut p.vector } else { &mut p.angles };
                let number = self.number(value, span)?;
                put_once(&mut slots[usize::from(letter - b'A')], number, &word_text(span, line), span)?;
            }
            (b'I'..=b'K', 1) => {
                let coordinate = self.coordinate(value, span)?;
                put_once(&mut p.intermediate[usize::from(letter - b'I')], coordinate, &word_text(span, line), span)?;
            }
            (b'S', 1) => put_once(&mut p.speed, self.number(value, span)?, "S", span)?,
            (b'M', 1) => {
                let code = self.integer('M', value, 99_999_999, span)?;
                self.m_word(p, code, span)?;
            }
            (b'T', 1) => put_once(&mut p.tool, self.tool_name(value, span)?, "T", span)?,
            (b'S' | b'M' | b'H', _) => {
                // A spindle other than that of the tool, or a function sent to the machine.
                let number = self.number(value, span)?;
                self.note(format!("{}{extension}={number}", char::from(letter)));
            }
            (b'A'..=b'C', 4..=7) => {
                return Err(refused(
                    &word_text(span, line),
                    span,
                    "program the orientation at the end of the block with A3= B3= C3=",
                ));
            }
            _ => return Err(unknown_word(span, line)),
        }
        Ok(())
    }

    fn tool_name(&self, value: &AddressValue, span: Span) -> Result<ToolName, Fault> {
        let value = match value {
            AddressValue::Number(number) => Val::Number(*number),
            AddressValue::Expr(expr) => self.variables.eval(expr, span)?,
        };
        match value {
            Val::Text(name) if name.trim().is_empty() || name.trim() == "0" => Ok(ToolName::Empty),
            Val::Text(name) => Ok(ToolName::Name(name)),
            Val::Number(0.0) => Ok(ToolName::Empty),
            Val::Number(number) if number.fract() == 0.0 && (0.0..TOOL_NUMBERS).contains(&number) => {
                Ok(ToolName::Number(number as u32))
            }
            Val::Number(number) => Err(Fault::new(codes::BAD_VALUE, span, format!("{number} is not a tool number"))
                .help("write T5 or T=\"NAME\"")),
        }
    }

    fn g_word(&mut self, p: &mut Pending, value: &AddressValue, span: Span) -> Result<(), Fault> {
        let code = self.integer('G', value, 9999, span)?;
        if let Some((at, listed)) = self.settings.control.words.g(GCode(code, 0)) {
            let listed = listed.clone();
            return self.listed_word(p, at, &listed, span);
        }
        self.own_g(p, code, span)
    }

    /// A G word as the reader takes it without a control file.
    pub(super) fn own_g(&mut self, p: &mut Pending, code: u32, span: Span) -> Result<(), Fault> {
        let group = words::g_group(code).and_then(|group| p.groups.get_mut(group));
        if let Some(other) = group.and_then(|group| group.replace(code)).filter(|&other| other != code) {
            let message = format!("G{other} and G{code} are in one group, and a block may hold one word of it");
            return Err(Fault::new(codes::CONFLICT, span, message).help("write them in blocks of their own"));
        }
        let modal = &mut self.modal;
        match code {
            0 => modal.interpolation = Interpolation::Rapid,
            1 => modal.interpolation = Interpolation::Linear,
            2 => modal.interpolation = Interpolation::Clockwise,
            3 => modal.interpolation = Interpolation::CounterClockwise,
            33 => modal.interpolation = Interpolation::Thread,
            331 => modal.interpolation = Interpolation::TapIn,
            332 => modal.interpolation = Interpolation::TapOut,
            63 => {
                // Feed and speed are programmed to match; the chuck takes up the difference.
                p.tapping_feed = true;
                self.note("G63");
            }
            4 => p.dwell = true,
            9 => p.exact_stop = true,
            74 | 75 => p.fixed_point = Some(code),
            17..=19 => {
                modal.normal = [2, 1, 0][code as usize - 17];
                let normal = ['X', 'Y', 'Z'][modal.normal];
                self.emit(Op::Plane(normal));
            }
            40..=42 => self.compensation_word(p, code, span)?,
            450 | 451 => self.corner_word(code),
            25 | 26 => p.limits = Some(code),
            58 | 59 => {
                let word = if code == 58 { FrameWord::G58 } else { FrameWord::G59 };
                p.frame = Some((word, span));
            }
            110..=112 => p.pole = Some(code),
            53 | 153 => p.machine = true,
            54..=57 | 500 | 505..=599 => p.offset = Some(code),
            60 => self.path_mode(PathMode::ExactStop),
            64 | 641..=645 => {
                modal.exact_stop = false;
                let tolerance = self.own.contour_tolerance;
                let orientation_tolerance = self.own.orientation_tolerance;
                self.path_mode(PathMode::Continuous { tolerance, orientation_tolerance });
                if code == 641 {
                    p.rounding = p.rounding.or(Some(self.own.rounding));
                }
            }
            70 => modal.units = Units::InchLengths,
            700 => modal.units = Units::Inch,
            71 | 710 => modal.units = Units::Metric,
            90 => modal.incremental = false,
            91 => modal.incremental = true,
            93 => self.feed_mode(FeedMode::InverseTime),
            94 => self.feed_mode(FeedMode::PerTime),
            95 => self.feed_mode(FeedMode::PerRevolution),
            97 => self.note("G97"),
            _ if words::is_noted_g(code) => self.note(format!("G{code}")),
            _ => {
                return Err(g_fault(code, span));
            }
        }
        Ok(())
    }

    fn name(&mut self, p: &mut Pending, name: &str, span: Span, at: usize) -> Result<(), Fault> {
        if let Some((at, listed)) = self.settings.control.words.name(name) {
            let listed = listed.clone();
            return self.listed_word(p, at, &listed, span);
        }
        if let Some(frame) = FrameWord::from_name(name) {
            if p.frame.is_some() {
                return Err(Fault::new(
                    codes::CONFLICT,
                    span,
                    format!("`{name}` is the second frame instruction of the block"),
                )
                .help("write it in a block of its own"));
            }
            p.frame = Some((frame, span));
            return Ok(());
        }
        if self.compensation_name(name) {
            return Ok(());
        }
        if let Some(frame) = ToolFrame::from_name(name) {
            p.tool_frame = Some(frame);
            return Ok(());
        }
        match name {
            "SUPA" => p.machine = true,
            "TRAORI" => p.transformation = Some(true),
            "TRAFOOF" => p.transformation = Some(false),
            "BSPLINE" => self.modal.interpolation = Interpolation::Spline(SplineKind::Basis),
            "CSPLINE" => self.modal.interpolation = Interpolation::Spline(SplineKind::Cubic),
            "ASPLINE" => self.modal.interpolation = Interpolation::Spline(SplineKind::Akima),
            "POLY" => self.modal.interpolation = Interpolation::Polynomial,
            "BAUTO" => self.modal.spline_begin = SplineEnd::Auto,
            "BNAT" => self.modal.spline_begin = SplineEnd::Natural,
            "BTAN" => self.modal.spline_begin = SplineEnd::Tangent,
            "EAUTO" => self.modal.spline_end = SplineEnd::Auto,
            "ENAT" => self.modal.spline_end = SplineEnd::Natural,
            "ETAN" => self.modal.spline_end = SplineEnd::Tangent,
            "CIP" => self.modal.interpolation = Interpolation::Intermediate,
            "CT" => self.modal.interpolation = Interpolation::Tangential,
            "ORIAXES" => self.orientation(OrientationInterpolation::Axes),
            "ORIVECTPATH" => {
                self.note("ORIVECTPATH: taken as ORIVECT");
                self.orientation(OrientationInterpolation::GreatCircle);
            }
            "ORIVECT" | "ORIPLANE" => self.orientation(OrientationInterpolation::GreatCircle),
            "ORIWKS" | "ORIMKS" => {
                self.modal.machine_vectors = name == "ORIMKS";
                self.tell_tcp();
            }
            "ORIRPY" => {
                self.modal.angles = Some(OrientationAngles::Rpy);
                self.note(name);
            }
            "ORIEULER" => {
                self.modal.angles = Some(OrientationAngles::Euler);
                self.note(name);
            }
            _ => match words::classify_name(name) {
                Class::Note => self.note(name),
                Class::Assumed(text) => self.assume(text),
                Class::Refused(remedy) => return Err(refused(name, span, remedy)),
                Class::Unknown => self.take_call(p, name, span, at)?,
            },
        }
        Ok(())
    }

    fn call_word(&mut self, p: &mut Pending, call: &Call, span: Span, at: usize) -> Result<(), Fault> {
        if let Some((at, listed)) = self.settings.control.words.name(&call.name) {
            let listed = listed.clone();
            return self.listed_word(p, at, &listed, span);
        }
        let arguments = call.arguments.as_deref().unwrap_or_default();
        match call.name.as_str() {
            "MSG" => {
                let text = match arguments.first() {
                    Some(Some(text)) => eval::shown(&self.variables.eval(text, span)?),
                    _ => String::new(),
                };
                self.emit(Op::Message(text));
            }
            "TRAORI" => {
                self.check_data_set(call, span)?;
                p.transformation = Some(true);
            }
            "TRAFOOF" => p.transformation = Some(false),
            "FGROUP" => self.feed_group(arguments, span)?,
            name => match words::classify_name(name) {
                Class::Note => self.note(name),
                Class::Assumed(text) => self.assume(text),
                Class::Refused(remedy) => return Err(refused(name, span, remedy)),
                Class::Unknown => self.take_call(p, name, span, at)?,
            },
        }
        Ok(())
    }

    /// TRAORI(n, X, Y, Z, A, B): the twin has one kinematics, that of the machine file, and the
    /// tool along its spindle.
    fn check_data_set(&self, call: &Call, span: Span) -> Result<(), Fault> {
        let values = self.arguments(call, span)?;
        // Number of the data set, direction of the tool, offsets of the rotary axes.
        for (at, standard) in [1.0, 0.0, 0.0, 1.0, 0.0, 0.0].into_iter().enumerate() {
            let Some(value) = number(&values, at, "TRAORI", span)?.filter(|v| *v != standard) else {
                continue;
            };
            let what = match at {
                0 => format!(
                    "`TRAORI({value})` switches to another data set of the control, which the twin does not know"
                ),
                1..=3 => {
                    "`TRAORI` with a direction of the tool other than that of the spindle is not supported".to_owned()
                }
                _ => "`TRAORI` with offsets of the rotary axes is not supported".to_owned(),
            };
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, what)
                .help("write TRAORI, which takes the kinematics of the machine file"));
        }
        Ok(())
    }

    fn take_call(&self, p: &mut Pending, name: &str, span: Span, at: usize) -> Result<(), Fault> {
        if p.call.replace(at).is_some() || p.numbered_call.is_some() {
            return Err(Fault::new(codes::CONFLICT, span, format!("`{name}` is the second call of the block"))
                .help("write it in a block of its own"));
        }
        Ok(())
    }
}

fn set_once(already: bool, letter: char, span: Span) -> Result<(), Fault> {
    if already {
        return Err(twice(letter, span));
    }
    Ok(())
}

/// Stores a word that may appear only once in its block.
pub(super) fn put_once<T>(slot: &mut Option<T>, value: T, word: &str, span: Span) -> Result<(), Fault> {
    if slot.replace(value).is_some() {
        return Err(twice(word, span));
    }
    Ok(())
}

pub(super) fn word_text(span: Span, line: &str) -> String {
    line.get(span.start as usize..span.end as usize).unwrap_or_default().trim().to_owned()
}

fn unknown_word(span: Span, line: &str) -> Fault {
    let word = word_text(span, line);
    Fault::new(codes::UNKNOWN_WORD, span, format!("unknown word `{word}`"))
        .help("see the coverage table for the words that are read")
        .about(Some(FaultSubject::UnknownWord(word)))
}

/// The fault of a word that is not valid in any state of the control.
pub(crate) fn refused_word(word: &Word, control: &Control) -> Option<Fault> {
    let span = word.span;
    let listed = match &word.kind {
        WordKind::Address { letter: b'G', extension: None, value: AddressValue::Number(code) }
            if (0.0..G_LISTED).contains(code) =>
        {
            control.words.g(GCode(*code as u32, 0))
        }
        WordKind::Address { letter: b'M', extension: None | Some(1), value: AddressValue::Number(code) }
            if (0.0..M_LISTED).contains(code) =>
        {
            let code = *code as u32;
            if control.refuses_unlisted && control.words.m(code).is_none() && !is_function(code) {
                return Some(unlisted(control, &format!("M{code}"), span));
            }
            control.words.m(code)
        }
        WordKind::Name(name) | WordKind::Call(Call { name, .. }) => control.words.name(name),
        _ => None,
    };
    if let Some((_, listed)) = listed {
        let Meaning::Refuse(remedy) = &listed.meaning else { return None };
        return Some(refused_by(control, &listed.word, span, remedy));
    }
    match &word.kind {
        WordKind::Address { letter: b'G', extension: None, value: AddressValue::Number(code) } => {
            let known = does_g(*code as i64);
            if known || *code < 0.0 || code.fract() != 0.0 || words::is_noted_g(*code as u32) {
                return None;
            }
            Some(g_fault(*code as u32, span))
        }
        WordKind::Address { letter: b'E' | b'O' | b'Q', .. } => Some(
            Fault::new(codes::UNKNOWN_WORD, span, "unknown word")
                .help("see the coverage table for the words that are read"),
        ),
        WordKind::Name(name) | WordKind::Call(Call { name, .. }) => match words::classify_name(name) {
            Class::Refused(remedy) => Some(refused(name, span, remedy)),
            _ => None,
        },
        _ => None,
    }
}

/// A word defined neither by the reader nor by the control file, and what the reader does with it.
pub(crate) fn unlisted_word(word: &Word, control: &Control) -> Option<(WordKey, WordState)> {
    match &word.kind {
        WordKind::Address { letter: b'G', extension: None, value: AddressValue::Number(code) }
            if (0.0..G_TOLD).contains(code) =>
        {
            let code = *code as u32;
            if does_g(i64::from(code)) || words::is_noted_g(code) || control.words.g(GCode(code, 0)).is_some() {
                return None;
            }
            let known = words::refused_g(code).is_some();
            Some((WordKey::G(GCode(code, 0)), if known { WordState::NotSupported } else { WordState::Unknown }))
        }
        WordKind::Address { letter: b'M', extension: None | Some(1), value: AddressValue::Number(code) }
            if (0.0..M_TOLD).contains(code) =>
        {
            let code = *code as u32;
            if is_function(code) || control.words.m(code).is_some() {
                return None;
            }
            let now = if control.refuses_unlisted { WordState::Unknown } else { WordState::Noted };
            Some((WordKey::M(code), now))
        }
        WordKind::Name(name) | WordKind::Call(Call { name, .. }) => {
            let refused = matches!(words::classify_name(name), Class::Refused(_)) && control.words.name(name).is_none();
            refused.then(|| (WordKey::Name(name.clone()), WordState::NotSupported))
        }
        _ => None,
    }
}

/// G words that are executed.
pub(super) fn does_g(code: i64) -> bool {
    matches!(
        code,
        0..=4 | 9 | 17..=19 | 74 | 75 | 25 | 26 | 58 | 59 | 110..=112 | 33 | 63 | 331 | 332 | 40..=42 | 450 | 451 | 53..=57 | 60 | 64 | 70 | 71 | 90 | 91 | 93..=95 | 97 | 153 | 500 | 505..=599 | 641..=645 | 700 | 710
    )
}

/// M words that are executed.
pub(super) fn is_function(code: u32) -> bool {
    matches!(code, 0..=9 | 17 | 30)
}

fn g_fault(code: u32, span: Span) -> Fault {
    match words::refused_g(code) {
        Some(remedy) => refused(&format!("G{code}"), span, remedy),
        None => Fault::new(codes::UNKNOWN_WORD, span, format!("unknown word `G{code}`"))
            .help("see the coverage table for the G words that are read"),
    }
}

/// An argument that must be a number.
fn number(values: &[Option<Val>], at: usize, name: &str, span: Span) -> Result<Option<f64>, Fault> {
    match values.get(at) {
        None | Some(None) => Ok(None),
        Some(Some(Val::Number(number))) => Ok(Some(*number)),
        Some(Some(Val::Text(text))) => {
            let message = format!("argument {} of `{name}` is the text \"{text}\"", at + 1);
            Err(Fault::new(codes::ARGUMENTS, span, message).help("write a number there"))
        }
    }
}
