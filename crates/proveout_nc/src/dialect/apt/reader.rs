//! Runs the statements of CL data one by one; executed statements are not kept.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::drilling::Cycle;
use super::recover;
use super::statement::{self, AptStatement, Bad, Item, LineRange, Token};
use super::words::{self, MajorWordClass};
use crate::channel::doubt::{Doubt, Stage};
use crate::channel::{Channel, FailedBlock, Language, ProgramSection, UsualFeed};
use crate::codes;
use crate::control::{Control, Meaning, MixedFeed};
use crate::diagnostic::{Diagnostic, Span};
use crate::frame::Frame;
use crate::not_run::NotRun;
use crate::source::{Mark, Source};
use crate::{CompSide, Offset, Op, Settings, SpindleDirection, ToolAction, ToolName, WorkOffset};

/// Millimeters of an inch.
pub(crate) const INCH: f64 = 25.4;
/// Most names that a text may define.
const MAX_NAMES: usize = 100_000;
/// Numbers from here on are out of range: a double has no more digits.
const LARGEST: f64 = 1e15;

/// A circle that waits for the point where it ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PendingCircle {
    pub(crate) center: [f64; 3],
    pub(crate) normal: [f64; 3],
    /// None: given by the start point.
    pub(crate) radius: Option<f64>,
    /// Programmed angle, radian.
    pub(crate) angle: Option<f64>,
    /// A circle of NX: with start and end at one point it is no motion, not a full turn.
    pub(crate) zero_at_one_point: bool,
}

/// CL data being executed.
pub(crate) type AptReader = Channel<Apt>;

/// State of CL data.
#[derive(Debug)]
pub(crate) struct Apt {
    started: bool,
    max_names: usize,
    names: BTreeMap<String, f64>,
    offsets: BTreeMap<String, WorkOffset>,
    settable: Frame,
    /// Coordinate system of the operation (MSYS) seen from the first one, and TRANS.
    pub(crate) local: Frame,
    pub(crate) shift: [f64; 3],
    pub(crate) first_msys: Option<Frame>,
    /// What the text says about itself.
    pub(crate) facts: super::writer::ClDataFacts,
    /// The last statement was END-OF-PATH of an NX operation.
    path_ended: bool,
    /// mm of a length unit.
    pub(crate) unit: f64,
    /// Tool axis, work coordinates.
    pub(crate) axis: [f64; 3],
    /// Tool center point control is on.
    pub(crate) tcp: bool,
    pub(crate) rapid: bool,
    pub(crate) noted_no_feed: bool,
    /// Direction that SPINDL/ON takes up again.
    pub(crate) last_direction: SpindleDirection,
    pub(crate) side: CompSide,
    pub(crate) circle: Option<PendingCircle>,
    /// INDIRV: direction in which the next circle starts.
    pub(crate) forward: Option<[f64; 3]>,
    pub(crate) cycle: Option<Cycle>,
    pub(crate) cycle_on: bool,
    /// Point of the hole in work.
    pub(crate) hole: [f64; 3],
    /// Tool position when the cycle began.
    pub(crate) cycle_from: Option<[f64; 3]>,
    pub(crate) home: Option<([f64; 3], [f64; 3])>,
    /// The program loads a tool by its number.
    pub(crate) tool_loaded: bool,
    pub(crate) path_tool: Option<String>,
    pub(crate) pending_tool: Option<String>,
}

/// The text, before its first statement.
pub(super) fn begin(source: Source, settings: &Settings) -> AptReader {
    let stated = settings.control.start.inch.map(|inch| if inch { INCH } else { 1.0 });
    let facts = super::writer::facts(&source, settings.control.clockwise_circles, stated);
    let own = Apt {
        started: false,
        unit: stated.or(facts.unit).unwrap_or(1.0),
        facts,
        path_ended: false,
        max_names: settings.limits.max_array_elements.min(MAX_NAMES),
        names: settings.variables.iter().map(|(name, &value)| (name.to_ascii_uppercase(), value)).collect(),
        offsets: settings.work_offsets.iter().map(|(word, &offset)| (word.to_ascii_uppercase(), offset)).collect(),
        settable: Frame::IDENTITY,
        local: Frame::IDENTITY,
        shift: [0.0; 3],
        first_msys: None,
        axis: [0.0, 0.0, 1.0],
        tcp: false,
        rapid: false,
        last_direction: SpindleDirection::Clockwise,
        noted_no_feed: false,
        side: CompSide::Off,
        circle: None,
        forward: None,
        cycle: None,
        cycle_on: false,
        hole: [0.0; 3],
        cycle_from: None,
        home: None,
        tool_loaded: false,
        path_tool: None,
        pending_tool: None,
    };
    let whole = ProgramSection { start: Mark::START, end: source.text.len() };
    Channel::new(source, None, settings, own, |()| (whole, ()), (), ())
}

impl Language for Apt {
    type Index = ();
    type Level = ();
    type Block = AptStatement;
    type Mark = ();
    type Variables = ();
    type Modal = ();

    fn index(&self, _source: &Source, _main: bool, _faults: &mut Vec<Diagnostic>) {}

    fn step(channel: &mut AptReader) -> Result<(), Box<Diagnostic>> {
        let Some(level) = channel.stack.last() else {
            channel.done = true;
            return Ok(());
        };
        let (loaded, at) = (Arc::clone(&level.loaded), level.cursor);
        let mut statement = channel.block.take().unwrap_or_default();
        let Some((read, next)) = statement::read(&loaded.source, at, &mut statement) else {
            // NX ends its text with the last operation.
            if std::mem::take(&mut channel.own.path_ended) {
                channel.end_of_program();
            }
            channel.done = true;
            return Ok(());
        };
        channel.coverage.mark(loaded.file, at.line, next.line);
        channel.set_cursor(next);
        channel.recovery.faults.stage = Stage::Unread;
        let result = read.and_then(|()| channel.run(&loaded.source, &statement));
        channel.block = Some(statement);
        match result {
            Ok(()) => {
                recover::settle_doubt(channel);
                Ok(())
            }
            Err(bad) => {
                let line = loaded.source.line(bad.mark).map_or("", |(line, _)| line);
                Err(channel.failed(&loaded, bad.mark, line, bad.fault))
            }
        }
    }

    fn moving(_channel: &mut AptReader) {}

    /// CL data contains only tip and tool axis.
    fn mixed_feed(_channel: &AptReader) -> UsualFeed {
        UsualFeed::Rule(MixedFeed::Linear)
    }

    fn may_follow(channel: &AptReader, fault: &Diagnostic) -> bool {
        recover::may_follow(channel, fault)
    }

    fn settle_doubt(channel: &mut AptReader) {
        recover::settle_doubt(channel);
    }

    fn give_up(channel: &mut AptReader, _failed: &FailedBlock<()>) {
        channel.own.circle = None;
        channel.own.forward = None;
    }

    fn go_on(channel: &mut AptReader, _failed: &FailedBlock<()>) -> Option<Doubt> {
        channel.block.as_deref().map(recover::doubt_of)
    }

    fn not_run(channel: &AptReader) -> Vec<NotRun> {
        recover::not_run(channel)
    }
}

impl AptReader {
    fn run(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        if st.major.is_empty() {
            return Ok(());
        }
        let mark = st.head.mark;
        let line = source.line(mark).map_or("", |(line, _)| line);
        let end =
            st.items.iter().take_while(|i| i.place.mark == mark).last().map_or(st.head.span.end, |i| i.place.span.end);
        let end = end.max(st.literal.span.end).max(st.head.span.end);
        self.stands_at(&source.name, mark, line, Span { start: st.head.span.start, end });
        self.recovery.faults.stage = Stage::Acting;
        if !self.own.started {
            self.own.started = true;
            self.work_offset("G54");
            let start = self.settings.start_position;
            self.position.begin_at(&start);
            if let Some(text) = self.own.facts.unit_assumed.take() {
                self.assume(text);
            }
            if let Some(text) = self.own.facts.unit_told.take() {
                self.note(text);
            }
        }
        if let Some(lines) = self.own.facts.unit_contradicts
            && matches!(st.major.as_str(), "GOTO" | "FROM" | "GODLTA" | "HOME" | "CIRCLE" | "MOVARC")
        {
            let message = format!(
                "no UNITS states whether lengths are mm or inch, and the feeds contradict each other: inch in line \
                 {} and mm in line {}",
                lines[0], lines[1]
            );
            return Err(st.head.bad(
                codes::CONFLICT,
                message,
                "write UNITS/MM or UNITS/INCHES in front, or state start.unit in the control file",
            ));
        }
        self.own.path_ended = st.major == "END-OF-PATH";
        if st.assignment {
            return self.assign(source, st);
        }
        if let Some(bad) = refused_word(st, &self.settings.control) {
            return Err(bad);
        }
        if self.listed_word(&st.major) {
            return Ok(());
        }
        if words::classify(&st.major) == MajorWordClass::Note {
            let text = line.get(st.head.span.start as usize..end as usize).unwrap_or(line);
            self.note(text.trim());
            return Ok(());
        }
        match st.major.as_str() {
            "GOTO" => self.goto(source, st),
            "RAPID" => {
                if let Some(item) = st.items.first() {
                    return Err(item.place.bad(
                        codes::UNSUPPORTED_WORD,
                        format!("`RAPID/{}` is not supported", item.place.text(source)),
                        "write RAPID alone: it holds for the next motion",
                    ));
                }
                self.own.rapid = true;
                Ok(())
            }
            "FEDRAT" => self.feed_statement(source, st),
            "GODLTA" => self.godlta(source, st),
            "FROM" | "HOME" => self.from(source, st),
            "GOHOME" => self.go_home(st),
            "CIRCLE" | "MOVARC" => self.circle_statement(source, st),
            "INDIRV" | "INDIRP" => self.direction_statement(source, st),
            "TLON,GOFWD" => self.along_circle(source, st),
            "CYCLE" => self.cycle_statement(source, st),
            "MULTAX" => self.multax(source, st),
            "TLAXIS" => self.tool_axis_statement(source, st),
            "MSYS" => self.msys(source, st),
            "ORIGIN" | "TRANS" => self.shift_statement(source, st),
            "UNIT" | "UNITS" => self.units(source, st),
            "CSYS" => self.csys(source, st),
            "TRNTYP" => self.transform_type(source, st),
            _ => self.technology(source, st),
        }?;
        super::items::all_used(source, st)
    }

    /// Executes a word of the control file; false if it lists none of this name.
    fn listed_word(&mut self, major: &str) -> bool {
        let Some((at, _)) = self.settings.control.words.name(major) else { return false };
        self.tell_listed(at, "");
        true
    }

    /// Puts a work offset into effect and emits it.
    pub(crate) fn work_offset(&mut self, word: &str) {
        let values = self.own.offsets.get(word).copied().unwrap_or_default();
        self.own.settable = Frame::from(values);
        self.emit(Op::Offset(Offset::Work { word: word.to_owned() }));
        self.take_frame(word);
    }

    /// Puts the frames into effect and emits the result if it has changed.
    pub(crate) fn take_frame(&mut self, word: &str) {
        let total = self.own.settable.then(&self.own.local).then(&Frame::translation(self.own.shift));
        if total == *self.position.frame() {
            return;
        }
        self.position.set_frame(total);
        self.tell_frame(word);
    }

    /// `NAME=3.5`.
    fn assign(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let place = st.head;
        match st.items.as_slice() {
            [item] => {
                let value = self.number(source, item)?;
                if self.own.names.len() >= self.own.max_names && !self.own.names.contains_key(&st.major) {
                    let message = format!("the text defines more than {} names", self.own.max_names);
                    return Err(place.bad(codes::LOOP_LIMIT, message, "use fewer names, or split the text"));
                }
                self.own.names.insert(st.major.clone(), value);
                Ok(())
            }
            _ => Err(place.bad(
                codes::UNSUPPORTED_WORD,
                format!("the definition of `{}` is not supported", st.major),
                "only a number can be given a name; use the CL data that the geometry and calculations produce",
            )),
        }
    }

    /// An item that must be a number, or a name that was given one.
    pub(crate) fn number(&self, source: &Source, item: &Item) -> Result<f64, Box<Bad>> {
        let value = match item.token {
            Token::Number(value) => value,
            Token::Word => {
                let text = item.place.text(source);
                match self.own.names.get(&text.to_ascii_uppercase()) {
                    Some(&value) => value,
                    None if text.starts_with(|c: char| c.is_ascii_alphabetic()) && !self.own.names.is_empty() => {
                        let message = format!("`{text}` has no value here");
                        return Err(item.place.bad(codes::UNKNOWN_VARIABLE, message, "give it one before, NAME=3.5"));
                    }
                    None => {
                        let message = format!("`{text}` is not a number");
                        return Err(item.place.bad(codes::TYPE, message, "write a decimal number"));
                    }
                }
            }
            _ => return Err(item.place.bad(codes::SYNTAX, "a bracket in place of a number", "remove it")),
        };
        if value.is_finite() && value.abs() < LARGEST {
            return Ok(value);
        }
        Err(item.place.bad(codes::BAD_VALUE, "the number is out of range", "write a number below 1e15"))
    }

    /// All items as numbers, into a buffer; returns their number.
    pub(crate) fn numbers<const N: usize>(
        &self,
        source: &Source,
        st: &AptStatement,
        out: &mut [f64; N],
    ) -> Result<usize, Box<Bad>> {
        for (item, slot) in st.items.iter().zip(out.iter_mut()) {
            *slot = self.number(source, item)?;
        }
        Ok(st.items.len())
    }

    /// The item as an upper-case word.
    pub(crate) fn word(source: &Source, item: &Item) -> String {
        item.place.text(source).to_ascii_uppercase()
    }

    pub(crate) fn units(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let word = st.items.first().map(|i| Self::word(source, i)).unwrap_or_default();
        self.own.unit = match word.as_str() {
            "MM" => 1.0,
            "INCHES" | "INCH" => INCH,
            "" => return Err(st.head.bad(codes::MISSING_VALUE, "UNITS has no unit", "write UNITS/MM or UNITS/INCHES")),
            _ => {
                let message = format!("the unit `{word}` is not supported");
                return Err(st.head.bad(codes::BAD_VALUE, message, "write UNITS/MM or UNITS/INCHES"));
            }
        };
        self.note(format!("UNITS/{word}"));
        Ok(())
    }

    /// The tool of the operation goes into the spindle before its first motion, unless the program loads one
    /// by number.
    pub(crate) fn take_path_tool(&mut self) {
        if let Some(name) = self.own.pending_tool.take() {
            self.load_into_spindle(ToolName::Name(name), 1);
        }
    }

    pub(crate) fn load_into_spindle(&mut self, tool: ToolName, edge: u32) {
        self.emit(Op::Tool(ToolAction::Select(tool.clone())));
        self.emit(Op::Tool(ToolAction::Change(tool)));
        self.emit(Op::Offset(Offset::ToolEdge { edge }));
        // The change moves the machine to its tool changer.
        self.position.forget(0b111);
    }
}

/// The fault of a statement whose word is not valid in any state.
pub(crate) fn refused_word(st: &AptStatement, control: &Control) -> Option<Box<Bad>> {
    if st.major.is_empty() || st.assignment {
        return None;
    }
    if let Some((_, listed)) = control.words.name(&st.major) {
        let Meaning::Refuse(remedy) = &listed.meaning else { return None };
        let message = format!("`{}` is refused by the control \"{}\"", listed.word, control.name);
        return Some(st.head.bad(codes::UNSUPPORTED_WORD, message, remedy));
    }
    let help = "correct the word, or make it a comment with `$$` when it has no effect";
    match words::classify(&st.major) {
        MajorWordClass::Done | MajorWordClass::Note => None,
        MajorWordClass::Refused(remedy) => {
            Some(st.head.bad(codes::UNSUPPORTED_WORD, format!("`{}` is not supported", st.major), remedy))
        }
        MajorWordClass::Unknown => {
            Some(st.head.bad(codes::UNKNOWN_WORD, format!("unknown word `{}`", shown(&st.major)), help))
        }
    }
}

/// The beginning of a long word.
fn shown(word: &str) -> String {
    if word.chars().count() <= 40 { word.to_owned() } else { word.chars().take(40).chain("...".chars()).collect() }
}

/// The fault of a statement that takes a certain number of items and has another number of them.
pub(crate) fn arity(place: LineRange, word: &str, count: usize, want: &str) -> Box<Bad> {
    place.bad(codes::ARGUMENTS, format!("{word} with {count} values"), format!("give {want}"))
}
