//! Runs a program block by block: labels, repetitions, jumps, program calls.
//!
//! The last motion of a contour waits until the next block has been read, because RND and CHF shorten it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::run_state::{KlartextCall, Labels, Loaded, label_key};
use super::state::HeidenhainState;
use super::variables::QParameters;
use super::words::{self, Block, Label, Statement};
use super::{din, leftover, parser, recover, text};
use crate::channel::doubt::{Doubt, Stage};
use crate::channel::{Channel, FailedBlock, Language, ProgramSection, UsualFeed};
use crate::codes;
use crate::compensation::CompStyle;
use crate::control::MixedFeed;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::not_run::NotRun;
use crate::settings::Dialect;
use crate::source::{Mark, Source};
use crate::{Command, Settings};

pub(super) use super::run_state::{Heidenhain, Interpreter};

impl Labels {
    fn new(source: &Source, din: bool, faults: &mut Vec<Diagnostic>) -> Self {
        let mut labels = BTreeMap::new();
        let mut unreadable = false;
        let mut at = Mark::START;
        let mut block = Block::default();
        while let Some((line, next)) = source.line(at) {
            // Only lines that may hold a label are parsed.
            let found = if din { line.contains("G98") || line.contains("g98") } else { has_label(line) };
            if found {
                let parsed = if din { din::parse(line, &mut block) } else { parser::parse(line, &mut block) };
                unreadable |= parsed.is_err();
                let key = match (&parsed, &block.statement) {
                    (Ok(()), Statement::Label(Label::Number(words::Value::Number(n)))) if *n != 0.0 => {
                        Some(label_key(*n))
                    }
                    (Ok(()), Statement::Label(Label::Name(name))) => Some(format!("\"{}", name.to_ascii_uppercase())),
                    _ => None,
                };
                if let Some(key) = key {
                    let shown = key.trim_start_matches('"').to_owned();
                    if labels.insert(key, next).is_some() {
                        let fault = Fault::new(
                            codes::STRUCTURE,
                            block.span,
                            format!("the label {shown} is defined twice in the program"),
                        )
                        .help("give each LBL a number or name of its own");
                        faults.push(fault.at(&source.name, at.line, line));
                    }
                }
            }
            at = next;
        }
        Self { din, labels, unreadable }
    }
}

fn has_label(line: &str) -> bool {
    let line = line.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ' || c == '\t' || c == '/');
    line.get(..3).is_some_and(|head| head.eq_ignore_ascii_case("LBL"))
}

/// The program, before its first block. `folder`: where it lies, if it is a file.
pub(super) fn begin(dialect: Dialect, source: Source, folder: Option<PathBuf>, settings: &Settings) -> Interpreter {
    let own = Heidenhain { din: dialect == Dialect::HeidenhainIso, ..Heidenhain::default() };
    let variables = QParameters::new(&settings.variables, settings.limits.max_array_elements);
    let section = whole(&source);
    Channel::new(
        source,
        folder,
        settings,
        own,
        |_| (section, KlartextCall::new(true, false)),
        variables,
        HeidenhainState::new(settings),
    )
}

fn whole(source: &Source) -> ProgramSection {
    ProgramSection { start: Mark::START, end: source.text.len() }
}

impl Language for Heidenhain {
    type Index = Labels;
    type Level = KlartextCall;
    type Block = Block;
    type Mark = ();
    type Variables = QParameters;
    type Modal = HeidenhainState;

    fn index(&self, source: &Source, main: bool, faults: &mut Vec<Diagnostic>) -> Labels {
        let ending = || Path::new(&*source.name).extension().is_some_and(|e| e.eq_ignore_ascii_case("i"));
        Labels::new(source, if main { self.din } else { ending() }, faults)
    }

    fn step(channel: &mut Interpreter) -> Result<(), Box<Diagnostic>> {
        let Some(level) = channel.stack.last() else {
            channel.done = true;
            return Ok(());
        };
        let (loaded, at) = (Arc::clone(&level.loaded), level.cursor);
        let mut buffer = std::mem::take(&mut channel.own.buffer);
        let mut block = channel.block.take().unwrap_or_default();
        channel.recovery.faults.stage = Stage::Unread;
        let result = match text::block(&loaded.source, at, &mut buffer) {
            None => channel.end_of_text().map_err(|fault| channel.fail(&loaded, at, "", fault)),
            Some(found) => {
                channel.set_cursor(found.next);
                channel.coverage.mark(loaded.file, at.line, found.next.line);
                match channel.run(&loaded, &found, at, &mut block) {
                    Ok(()) => {
                        recover::settle_doubt(channel);
                        Ok(())
                    }
                    Err(fault) => Err(channel.fail(&loaded, at, found.text, fault)),
                }
            }
        };
        channel.own.buffer = buffer;
        channel.block = Some(block);
        result
    }

    /// One degree counts as one millimeter (from memory).
    fn mixed_feed(_channel: &Interpreter) -> UsualFeed {
        UsualFeed::Usual(MixedFeed::Vector)
    }

    /// The last motion of a contour is held back until its corner is known.
    fn hand_out(channel: &mut Interpreter) -> Option<Command> {
        let held = channel.modal.held && !channel.done;
        let waits = (channel.modal.approach.is_some() || channel.modal.corner.is_some()) && !channel.done;
        if waits || channel.queue.len() <= usize::from(held) {
            return None;
        }
        channel.queue.pop_front().map(|(command, ())| command)
    }

    fn moving(channel: &mut Interpreter) {
        channel.passes.moved();
    }

    fn may_follow(channel: &Interpreter, fault: &Diagnostic) -> bool {
        recover::may_follow(channel, fault)
    }

    fn follows(channel: &Interpreter, fault: &Diagnostic) -> bool {
        // A fault is not a consequence of what it takes out itself.
        channel.recovery.failed.as_ref().map_or_else(|| recover::may_follow(channel, fault), |failed| failed.follows)
    }

    fn locate(fault: Fault, source: &Source, at: Mark, text: &str) -> Diagnostic {
        text::locate(fault, source, at, text)
    }

    fn settle_doubt(channel: &mut Interpreter) {
        recover::settle_doubt(channel);
    }

    fn give_up(channel: &mut Interpreter, failed: &FailedBlock<Labels>) {
        let unread = channel.recovery.faults.stage == Stage::Unread || failed.code == codes::JUMP_TARGET;
        if !unread || channel.own.earlier_failed || failed.line.is_empty() {
            recover::nothing_waits(channel);
            channel.modal.pending_cycle = None;
        }
    }

    fn go_on(channel: &mut Interpreter, failed: &FailedBlock<Labels>) -> Option<Doubt> {
        Some(recover::go_on(channel, failed))
    }

    fn doubted(channel: &mut Interpreter, doubt: Doubt) {
        channel.own.since = 0;
        channel.own.last = channel.position.work;
        if doubt.axes != 0 || doubt.modal {
            channel.modal.tangent = None;
        }
    }

    fn comp_style(channel: &Interpreter) -> Option<CompStyle> {
        Some(CompStyle { look_ahead: channel.modal.look_ahead, ..CompStyle::PLAIN })
    }

    fn not_run(channel: &Interpreter) -> Vec<NotRun> {
        leftover::not_run(channel)
    }
}

impl Interpreter {
    /// Places a fault; a fault of an earlier block is placed in the line of that block.
    fn fail(&mut self, loaded: &Arc<Loaded>, at: Mark, text: &str, fault: Fault) -> Box<Diagnostic> {
        let earlier = self.own.earlier.take();
        self.own.earlier_failed = earlier.is_some();
        let shown = earlier.and_then(|line| Some((line, crate::compensation::line_of(&loaded.source, line)?)));
        let diagnostic = match shown {
            Some((line, shown)) => {
                let start = shown.len() - shown.trim_start().len();
                let fault = Fault { span: Span::new(start, shown.trim_end().len()), ..fault };
                self.failed(loaded, Mark { line, ..at }, &shown, fault)
            }
            None => self.failed(loaded, at, text, fault),
        };
        self.own.element_out |= self.modal.held;
        diagnostic
    }

    /// A text that ends without END PGM is treated as if it had one.
    fn end_of_text(&mut self) -> Result<(), Fault> {
        let label = self.stack.last().is_some_and(|level| !level.own.program);
        if label {
            return Err(Fault::new(
                codes::STRUCTURE,
                Span::default(),
                "the subprogram of a label is not closed before the file ends",
            )
            .help("write LBL 0 at its end"));
        }
        self.settle()?;
        self.end_of_file();
        Ok(())
    }

    fn end_of_file(&mut self) {
        while self.stack.last().is_some_and(|level| !level.own.program) {
            self.stack.pop();
        }
        if self.stack.len() > 1 {
            if let Some(level) = self.stack.pop() {
                self.modal.inch = level.own.inch;
            }
            self.variables.leave();
        } else {
            self.end_of_program();
        }
    }

    fn run(
        &mut self,
        loaded: &Arc<Loaded>,
        found: &text::BlockText<'_>,
        at: Mark,
        block: &mut Block,
    ) -> Result<(), Fault> {
        let text = found.text;
        self.own.din_now = loaded.index.din;
        if loaded.index.din {
            din::parse(text, block)?
        } else {
            parser::parse(text, block)?
        }
        if block.statement == Statement::Empty || block.skip && self.settings.skipped_levels & 1 == 1 {
            return Ok(());
        }
        if !block.words.functions.is_empty() {
            self.list_functions(block)?;
        }
        // A joined block is located at its first line.
        self.recovery.faults.stage = Stage::Acting;
        let first = if found.joined { text.split('\n').next().unwrap_or(text) } else { text };
        // A fault of a cycle left open by an earlier block is reported at the place of that block.
        if self.modal.pending_cycle.is_some()
            && !matches!(block.statement, Statement::OldCycle { part: 1.., .. } | Statement::OldCycleProgram(_))
            && let Err(fault) = self.finish_old_cycle()
        {
            // The block itself is run when the run continues.
            self.own.earlier = Some(self.location.line);
            self.set_cursor(at);
            return Err(fault);
        }
        self.stands_at(&loaded.source.name, at, first, block.span);
        if block.skip {
            self.run_with_slash();
        }
        if let Some(incremental) = block.incremental {
            self.modal.incremental = incremental;
        }
        if let Statement::Path(path) = block.statement {
            return self.path(path, &block.words, block.span);
        }
        let statement = std::mem::replace(&mut block.statement, Statement::Empty);
        self.statement(loaded, at, statement, block)
    }

    fn key(&self, label: &Label, span: Span) -> Result<String, Fault> {
        Ok(match label {
            Label::Number(value) => label_key(self.variables.value(*value, span)?),
            Label::Name(name) => format!("\"{}", name.to_ascii_uppercase()),
            Label::Text(param) => format!("\"{}", self.variables.text(*param, span)?.to_ascii_uppercase()),
        })
    }

    fn label_target(loaded: &Loaded, key: &str, span: Span) -> Result<Mark, Fault> {
        loaded.index.labels.get(key).copied().ok_or_else(|| {
            let name = key.trim_start_matches('"');
            Fault::new(codes::JUMP_TARGET, span, format!("the program has no label {name}"))
                .help(format!("write LBL {name}"))
        })
    }

    /// Jumps to a label of the file.
    pub(crate) fn goto(&mut self, loaded: &Loaded, at: Mark, label: &Label, span: Span) -> Result<(), Fault> {
        let target = Self::label_target(loaded, &self.key(label, span)?, span)?;
        self.jump_to(at, target, span)
    }

    pub(crate) fn call_label(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        label: &Label,
        repeat: Option<f64>,
        span: Span,
    ) -> Result<(), Fault> {
        let target = Self::label_target(loaded, &self.key(label, span)?, span)?;
        let Some(repeat) = repeat else {
            self.room(span)?;
            let own = KlartextCall::new(false, self.modal.inch);
            self.enter((Arc::clone(loaded), whole(&loaded.source)), target, 1, own);
            return Ok(());
        };
        if !(0.0..=65535.0).contains(&repeat) || repeat.fract() != 0.0 {
            return Err(Fault::new(
                codes::BAD_VALUE,
                span,
                format!("REP takes 0 to 65535 repetitions and has {repeat}"),
            )
            .help("write a whole number"));
        }
        let Some(level) = self.stack.last_mut() else { return Ok(()) };
        let left = level.own.repetitions.entry(at.offset).or_insert(repeat as u64);
        if *left == 0 {
            level.own.repetitions.remove(&at.offset);
            return Ok(());
        }
        *left -= 1;
        level.cursor = target;
        self.count_pass(span)
    }

    /// LBL 0: returns to the block after the call.
    pub(crate) fn label_end(&mut self) {
        if self.stack.last().is_some_and(|level| !level.own.program) {
            self.stack.pop();
        }
    }

    /// END PGM.
    pub(crate) fn program_end(&mut self) -> Result<(), Fault> {
        self.settle()?;
        self.end_of_file();
        Ok(())
    }

    fn room(&mut self, span: Span) -> Result<(), Fault> {
        self.room_for_call("the call is nested", span)?;
        // Nested calls can multiply without a jump back.
        self.own.calls += 1;
        if self.own.calls > self.settings.limits.max_loop_passes {
            let message = format!("the program has made {} calls, which is the limit", self.own.calls - 1);
            return Err(Fault::new(codes::LOOP_LIMIT, span, message).help("check for calls that call each other"));
        }
        self.count_pass(span)
    }

    pub(crate) fn select_program(&mut self, name: String) {
        self.own.selected = Some(name);
    }

    pub(crate) fn call_selected(&mut self, span: Span) -> Result<(), Fault> {
        let Some(name) = self.own.selected.clone() else {
            return Err(Fault::new(codes::SUBPROGRAM, span, "no program is selected").help("write SEL PGM before it"));
        };
        self.call_program(&name, span)
    }

    pub(crate) fn call_program(&mut self, name: &str, span: Span) -> Result<(), Fault> {
        let Some(loaded) = self.find_program(name, span)? else { return self.missing(&file_name(name), span) };
        self.room(span)?;
        self.variables.enter();
        let own = KlartextCall::new(true, self.modal.inch);
        let section = whole(&loaded.source);
        self.enter((loaded, section), Mark::START, 1, own);
        Ok(())
    }

    fn find_program(&mut self, name: &str, span: Span) -> Result<Option<Arc<Loaded>>, Fault> {
        let file = file_name(name);
        let (stem, ending) = match file.rsplit_once('.') {
            Some((stem, ending)) => (stem.to_owned(), Some(ending.to_owned())),
            None => (file.clone(), None),
        };
        let found = self.file_beside(|path| {
            let part = |s: Option<&std::ffi::OsStr>| s.map(|s| s.to_string_lossy().to_ascii_uppercase());
            let own = part(path.extension()).unwrap_or_default();
            let fits = part(path.file_stem()).as_deref() == Some(&stem)
                && ending.as_deref().map_or(matches!(own.as_str(), "H" | "I"), |e| e == own);
            fits.then_some(())
        });
        if let Some(path) = found {
            return self.load(path, "program", &file, span).map(Some);
        }
        Ok(None)
    }
}

/// Name of a program without its folder.
fn file_name(name: &str) -> String {
    name.trim().rsplit(['\\', '/', ':']).next().unwrap_or_default().to_ascii_uppercase()
}
