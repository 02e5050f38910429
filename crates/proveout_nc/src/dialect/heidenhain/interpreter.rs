//! Runs a program block by block: labels, repetitions, jumps, program calls.
//!
//! Commands leave one by one; what is kept is the text, the labels of each file, the Q parameters and the modal state. The
//! last motion of a contour waits until the next block has been read, because RND and CHF shorten it.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;

use super::recover::Recovery;
use super::state::State;
use super::text;
use super::variables::Variables;
use super::words::{Block, Label, Statement};
use super::{din, parser};
use crate::channel::coverage::Coverage;
use crate::channel::doubt::Stage;
use crate::channel::passes::Passes;
use crate::codes;
use crate::diagnostic::{Diagnostic, Diagnostics, Fault, Span, column_and_length};
use crate::not_run::NotRun;
use crate::settings::Dialect;
use crate::source::{Mark, Source};
use crate::state::Position;
use crate::{Command, Location, Op, Settings};

/// A program file with its labels.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) source: Source,
    pub(crate) din: bool,
    pub(crate) labels: BTreeMap<String, Mark>,
    /// Its number among the files of the run.
    pub(crate) file: usize,
    /// A line that may hold a label cannot be read.
    pub(crate) unreadable: bool,
}

/// Key of a label: numbers and names live in one space.
pub(crate) fn label_key(number: f64) -> String {
    format!("{number}")
}

impl Loaded {
    /// The file, and what is wrong with its labels.
    pub(crate) fn new(source: Source, din: bool, file: usize) -> (Self, Vec<Diagnostic>) {
        let mut labels = BTreeMap::new();
        let mut faults = Vec::new();
        let mut unreadable = false;
        let mut at = Mark::START;
        let mut block = Block::default();
        while let Some((line, next)) = source.line(at) {
            // Only lines that can hold a label are looked at closely.
            let found = if din { line.contains("G98") || line.contains("g98") } else { has_label(line) };
            if found {
                let parsed = if din { din::parse(line, &mut block) } else { parser::parse(line, &mut block) };
                unreadable |= parsed.is_err();
                let key = match (&parsed, &block.statement) {
                    (Ok(()), Statement::Label(Label::Number(super::words::Value::Number(n)))) if *n != 0.0 => {
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
                            format!("the label {shown} stands twice in the program"),
                        )
                        .help("give each LBL a number or name of its own");
                        faults.push(fault.at(&source.name, at.line, line));
                    }
                }
            }
            at = next;
        }
        (Self { source, din, labels, file, unreadable }, faults)
    }
}

fn has_label(line: &str) -> bool {
    let line = line.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ' || c == '\t' || c == '/');
    line.get(..3).is_some_and(|head| head.eq_ignore_ascii_case("LBL"))
}

/// One level of the call stack.
#[derive(Debug)]
pub(crate) struct Level {
    pub(crate) loaded: Arc<Loaded>,
    pub(crate) cursor: Mark,
    /// A program called with CALL PGM, not a label.
    program: bool,
    /// Repetitions still to do, by the place of their CALL LBL block.
    repetitions: BTreeMap<usize, u64>,
    /// Unit of the calling program.
    inch: bool,
}

#[derive(Debug)]
pub(crate) struct Interpreter {
    pub(crate) settings: Settings,
    folders: Vec<PathBuf>,
    pub(crate) main: Arc<Loaded>,
    pub(crate) files: BTreeMap<PathBuf, Arc<Loaded>>,
    pub(crate) stack: Vec<Level>,
    /// Boxed, because it is taken out for every block.
    pub(crate) block: Option<Box<Block>>,
    buffer: String,
    pub(crate) queue: VecDeque<Command>,
    pub(crate) location: Location,
    pub(crate) done: bool,
    failure: Option<Box<Diagnostic>>,
    /// What is wrong with the labels of the main file.
    pub(crate) structure: Vec<Diagnostic>,
    pub(crate) recovery: Recovery,
    pub(crate) coverage: Coverage,
    pub(crate) passes: Passes,
    calls: u64,
    selected: Option<String>,
    pub(crate) variables: Variables,
    pub(crate) position: Position,
    pub(crate) state: State,
    /// The block that is executed is DIN/ISO.
    pub(crate) din_now: bool,
    /// Words of the control file whose reason has been told.
    pub(super) told_words: BTreeSet<usize>,
    /// Programs that were called and are not there.
    pub(super) missing: Vec<NotRun>,
}

impl Interpreter {
    /// `folder`: where the main program lies, if it is a file.
    pub(crate) fn new(dialect: Dialect, source: Source, folder: Option<PathBuf>, settings: &Settings) -> Self {
        let (loaded, structure) = Loaded::new(source, dialect == Dialect::HeidenhainIso, 0);
        let loaded = Arc::new(loaded);
        let location = Location { file: Arc::clone(&loaded.source.name), line: 0, column: 1, length: 0, depth: 0 };
        let level = Level {
            loaded: Arc::clone(&loaded),
            cursor: Mark::START,
            program: true,
            repetitions: BTreeMap::new(),
            inch: false,
        };
        Self {
            main: loaded,
            folders: folder.into_iter().chain(settings.subprogram_folders.iter().cloned()).collect(),
            files: BTreeMap::new(),
            stack: vec![level],
            block: None,
            buffer: String::new(),
            queue: VecDeque::new(),
            location,
            done: false,
            failure: None,
            structure,
            recovery: Recovery::default(),
            coverage: Coverage::default(),
            passes: Passes::default(),
            calls: 0,
            selected: None,
            variables: Variables::new(&settings.variables, settings.limits.max_array_elements),
            position: Position::new(),
            state: State::new(settings),
            din_now: false,
            told_words: BTreeSet::new(),
            missing: Vec::new(),
            settings: settings.clone(),
        }
    }

    /// Hands a command out with the place of the block.
    pub(crate) fn emit(&mut self, op: Op) {
        self.queue.push_back(Command { location: self.location.clone(), op });
    }

    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.emit(Op::Note(text.into()));
    }

    /// A motion was made: loops that move are not idle.
    pub(crate) fn moved(&mut self) {
        self.passes.moved();
    }

    /// M2, M30 or the end of the main program.
    pub(crate) fn end_of_program(&mut self) {
        self.emit(Op::End);
        self.done = true;
        for level in self.stack.drain(..) {
            self.coverage.end(level.loaded.file, level.cursor.line);
        }
    }

    fn step(&mut self) -> Result<(), Box<Diagnostic>> {
        let Some(level) = self.stack.last_mut() else {
            self.done = true;
            return Ok(());
        };
        let at = level.cursor;
        let loaded = Arc::clone(&level.loaded);
        let mut buffer = std::mem::take(&mut self.buffer);
        let mut block = self.block.take().unwrap_or_default();
        self.recovery.faults.stage = Stage::Unread;
        let result = match text::block(&loaded.source, at, &mut buffer) {
            None => self.end_of_text().map_err(|fault| self.failed(&loaded, at, "", fault)),
            Some(found) => {
                if let Some(level) = self.stack.last_mut() {
                    level.cursor = found.next;
                }
                self.coverage.mark(loaded.file, at.line, found.next.line);
                match self.run(&loaded, &found, at, &mut block) {
                    Ok(()) => {
                        self.settle_doubt();
                        Ok(())
                    }
                    Err(fault) => Err(self.failed(&loaded, at, found.text, fault)),
                }
            }
        };
        self.buffer = buffer;
        self.block = Some(block);
        result
    }

    /// The text ends without END PGM: as END PGM.
    fn end_of_text(&mut self) -> Result<(), Fault> {
        let label = self.stack.last().is_some_and(|level| !level.program);
        if label {
            return Err(Fault::new(
                codes::STRUCTURE,
                Span::default(),
                "the subprogram of a label does not end before the file does",
            )
            .help("write LBL 0 at its end"));
        }
        self.settle()?;
        self.end_of_file();
        Ok(())
    }

    fn end_of_file(&mut self) {
        while self.stack.last().is_some_and(|level| !level.program) {
            self.stack.pop();
        }
        if self.stack.len() > 1 {
            if let Some(level) = self.stack.pop() {
                self.state.inch = level.inch;
            }
            self.variables.leave();
        } else {
            self.end_of_program();
        }
    }

    fn run(&mut self, loaded: &Arc<Loaded>, found: &text::Text<'_>, at: Mark, block: &mut Block) -> Result<(), Fault> {
        let text = found.text;
        self.din_now = loaded.din;
        if loaded.din {
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
        // The place of a joined block is that of its first line.
        self.recovery.faults.stage = Stage::Acting;
        let first = if found.joined { text.split('\n').next().unwrap_or(text) } else { text };
        let (column, length) = column_and_length(first, block.span);
        let depth = self.stack.len().saturating_sub(1) as u32;
        // What an earlier block left open is told with the place of that block.
        if self.state.pending_cycle.is_some()
            && !matches!(block.statement, Statement::OldCycle { part: 1.., .. } | Statement::OldCycleProgram(_))
            && let Err(fault) = self.finish_old_cycle()
        {
            // The block itself is run when the run goes on.
            self.recovery.earlier = Some(self.location.line);
            if let Some(level) = self.stack.last_mut() {
                level.cursor = at;
            }
            return Err(fault);
        }
        self.location.move_to(&loaded.source.name, at.line, column, length, depth);
        if let Statement::Path(path) = block.statement {
            return self.path(path, &block.words, block.span);
        }
        let statement = std::mem::replace(&mut block.statement, Statement::Empty);
        self.statement(loaded, at, statement, block)
    }

    /// Counts a jump back and refuses one too many.
    fn count_pass(&mut self, span: Span) -> Result<(), Fault> {
        self.passes.count(&self.settings.limits, span)
    }

    fn key(&self, label: &Label, span: Span) -> Result<String, Fault> {
        Ok(match label {
            Label::Number(value) => label_key(self.variables.value(*value, span)?),
            Label::Name(name) => format!("\"{}", name.to_ascii_uppercase()),
            Label::Text(param) => format!("\"{}", self.variables.text(*param, span)?.to_ascii_uppercase()),
        })
    }

    fn label_target(loaded: &Loaded, key: &str, span: Span) -> Result<Mark, Fault> {
        loaded.labels.get(key).copied().ok_or_else(|| {
            let name = key.trim_start_matches('"');
            Fault::new(codes::JUMP_TARGET, span, format!("the label {name} is not in this program"))
                .help(format!("write LBL {name}"))
        })
    }

    /// Jumps to a label of the file.
    pub(crate) fn goto(&mut self, loaded: &Loaded, at: Mark, label: &Label, span: Span) -> Result<(), Fault> {
        let target = Self::label_target(loaded, &self.key(label, span)?, span)?;
        if target.offset <= at.offset {
            self.count_pass(span)?;
        }
        if let Some(level) = self.stack.last_mut() {
            level.cursor = target;
        }
        Ok(())
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
            let level = Level {
                loaded: Arc::clone(loaded),
                cursor: target,
                program: false,
                repetitions: BTreeMap::new(),
                inch: self.state.inch,
            };
            self.stack.push(level);
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
        let left = level.repetitions.entry(at.offset).or_insert(repeat as u64);
        if *left == 0 {
            level.repetitions.remove(&at.offset);
            return Ok(());
        }
        *left -= 1;
        level.cursor = target;
        self.count_pass(span)
    }

    /// LBL 0: back to the block behind the call.
    pub(crate) fn label_end(&mut self) {
        if self.stack.last().is_some_and(|level| !level.program) {
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
        let limit = self.settings.limits.max_call_depth;
        if self.stack.len() > limit as usize {
            let message = format!("the call stands at depth {}; the limit is {limit}", self.stack.len());
            return Err(
                Fault::new(codes::NESTING_LIMIT, span, message).help("check for a subprogram that calls itself")
            );
        }
        // Calls within calls can multiply without a jump back.
        self.calls += 1;
        if self.calls > self.settings.limits.max_loop_passes {
            let message = format!("the program has made {} calls, the limit of the settings", self.calls - 1);
            return Err(Fault::new(codes::LOOP_LIMIT, span, message).help("raise max_loop_passes"));
        }
        self.count_pass(span)
    }

    pub(crate) fn select_program(&mut self, name: String) {
        self.selected = Some(name);
    }

    pub(crate) fn call_selected(&mut self, span: Span) -> Result<(), Fault> {
        let Some(name) = self.selected.clone() else {
            return Err(Fault::new(codes::SUBPROGRAM, span, "no program is selected").help("write SEL PGM before it"));
        };
        self.call_program(&name, span)
    }

    pub(crate) fn call_program(&mut self, name: &str, span: Span) -> Result<(), Fault> {
        let Some(loaded) = self.find_program(name, span)? else { return self.missing(&file_name(name), span) };
        self.room(span)?;
        self.variables.enter();
        self.stack.push(Level {
            loaded,
            cursor: Mark::START,
            program: true,
            repetitions: BTreeMap::new(),
            inch: self.state.inch,
        });
        Ok(())
    }

    fn find_program(&mut self, name: &str, span: Span) -> Result<Option<Arc<Loaded>>, Fault> {
        let file = file_name(name);
        let (stem, ending) = match file.rsplit_once('.') {
            Some((stem, ending)) => (stem.to_owned(), Some(ending.to_owned())),
            None => (file.clone(), None),
        };
        for folder in self.folders.clone() {
            let Ok(entries) = std::fs::read_dir(&folder) else { continue };
            let mut found: Vec<PathBuf> = entries
                .filter_map(|entry| Some(entry.ok()?.path()))
                .filter(|path| {
                    let part = |s: Option<&std::ffi::OsStr>| s.map(|s| s.to_string_lossy().to_ascii_uppercase());
                    let own = part(path.extension()).unwrap_or_default();
                    part(path.file_stem()).as_deref() == Some(&stem)
                        && ending.as_deref().map_or(matches!(own.as_str(), "H" | "I"), |e| e == own)
                })
                .collect();
            found.sort();
            let Some(path) = found.into_iter().next() else { continue };
            if let Some(loaded) = self.files.get(&path) {
                return Ok(Some(Arc::clone(loaded)));
            }
            let failed = |text: String| Fault::new(codes::SUBPROGRAM, span, text).help("correct the program");
            let mut source =
                Source::read(&path).map_err(|d| failed(format!("the program `{file}` cannot be read: {d}")))?;
            source.take_out(&self.settings.control.header, &self.settings.control.trailer);
            let din = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("i"));
            let (loaded, faults) = Loaded::new(source, din, self.files.len() + 1);
            if !faults.is_empty() {
                return Err(failed(format!("the program `{file}` is broken: {}", Diagnostics(faults))));
            }
            let loaded = Arc::new(loaded);
            self.files.insert(path, Arc::clone(&loaded));
            return Ok(Some(loaded));
        }
        Ok(None)
    }
}

/// Name of a program without its folder.
fn file_name(name: &str) -> String {
    name.trim().rsplit(['\\', '/', ':']).next().unwrap_or_default().to_ascii_uppercase()
}

impl Iterator for Interpreter {
    type Item = Result<Command, Box<Diagnostic>>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            // The last motion of a contour is held back until its corner is known.
            let held = self.state.held && !self.done;
            let waits = (self.state.approach.is_some() || self.state.corner.is_some()) && !self.done;
            if !waits && self.queue.len() > usize::from(held) {
                return self.queue.pop_front().map(Ok);
            }
            if let Some(failure) = self.failure.take() {
                return Some(Err(failure));
            }
            if self.done {
                return None;
            }
            if let Err(diagnostic) = self.step() {
                // Commands of the block before the fault stay in the queue and are given out first.
                self.done = true;
                self.failure = Some(diagnostic);
            }
        }
    }
}
