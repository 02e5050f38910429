//! Runs a program line by line.
//!
//! Commands leave one by one; what is kept is the text, the index of its structure, the parameters and the modal state, never
//! the executed blocks.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;

use super::calls::{CallKind, MacroCall};
use super::flavor::{Flavor, Told};
use super::index::{Index, Section};
use super::modal::{CycleValues, Modal, Technology};
use super::parser::{self, Block, Remark};
use super::recover::Recovery;
use super::variables::Variables;
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span, column_and_length};
use crate::dialect::coverage::Coverage;
use crate::dialect::doubt::Stage;
use crate::dialect::passes::Passes;
use crate::not_run::NotRun;
use crate::source::{Mark, Source};
use crate::state::Position;
use crate::{ASSUMED, Command, Location, Offset, Op, Settings, WorkOffset};

/// A program file with its structure.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) source: Source,
    pub(crate) index: Index,
    /// Its number among the files of the run.
    pub(crate) file: usize,
}

impl Loaded {
    /// The file, and what is wrong with its structure.
    pub(crate) fn new(source: Source, flavor: Flavor, file: usize) -> (Self, Vec<Diagnostic>) {
        let mut faults = Vec::new();
        let index = Index::new(&source, flavor, &mut faults);
        (Self { source, index, file }, faults)
    }
}

/// One level of the call stack.
#[derive(Debug)]
pub(crate) struct Level {
    pub(crate) loaded: Arc<Loaded>,
    pub(crate) section: Section,
    pub(crate) cursor: Mark,
    /// First line, for further passes.
    pub(crate) first: Mark,
    pub(crate) passes_left: u32,
    pub(crate) kind: CallKind,
    /// Passes left of O REPEAT loops, by the offset of their first line.
    pub(crate) repeats: Vec<(usize, u64)>,
}

#[derive(Debug)]
pub(crate) struct Interpreter {
    pub(crate) settings: Settings,
    pub(crate) flavor: Flavor,
    /// The flavor is only the default: nothing tells it.
    pub(crate) assumed: bool,
    pub(crate) folders: Vec<PathBuf>,
    pub(crate) main: Arc<Loaded>,
    pub(crate) files: BTreeMap<PathBuf, Arc<Loaded>>,
    pub(crate) stack: Vec<Level>,
    pub(crate) block: Block,
    pub(crate) queue: VecDeque<Command>,
    location: Location,
    pub(crate) done: bool,
    /// What ended the run, to be told behind the commands before it.
    failure: Option<Box<Diagnostic>>,
    /// What is wrong with the structure of the main file.
    pub(crate) structure: Vec<Diagnostic>,
    pub(crate) recovery: Recovery,
    pub(crate) coverage: Coverage,
    pub(crate) passes: Passes,
    pub(crate) block_numbers: BTreeMap<(usize, usize, u32), Mark>,
    pub(crate) variables: Variables,
    pub(crate) offsets: BTreeMap<String, WorkOffset>,
    /// Rotations of work offsets (`LinuxCNC`), degrees.
    pub(crate) turns: BTreeMap<String, f64>,
    /// Tool lengths that the program writes itself: geometry and wear, mm.
    pub(crate) lengths: BTreeMap<u32, (Option<f64>, f64)>,
    /// Tool radii that the program writes itself: geometry and wear, mm.
    pub(crate) radii: BTreeMap<u32, (Option<f64>, f64)>,
    pub(crate) modal: Modal,
    /// M70
    pub(crate) kept_modal: Option<Box<Modal>>,
    pub(crate) technology: Technology,
    pub(crate) position: Position,
    pub(crate) cycle: CycleValues,
    /// Coordinates of a rapid motion on a tilted plane that waits for the rest of its end.
    pub(crate) held: crate::AxisValues,
    /// Control vector at the end of the last G5, for the next one.
    pub(crate) spline_end: Option<[f64; 2]>,
    pub(crate) modal_macro: Option<MacroCall>,
    /// A modal macro waits for the end of the block with its motion.
    pub(crate) moved_in_block: bool,
    /// Line number of the block.
    pub(crate) sequence: u32,
    /// The state at the start has been handed out.
    started: bool,
    pub(crate) noted_integers: bool,
    /// Words of the control file whose reason has been told.
    pub(crate) told_words: BTreeSet<usize>,
    /// Subprograms that were called and are not there.
    pub(crate) missing: Vec<NotRun>,
    /// First parameter of the reference points that a note has named.
    pub(crate) noted_references: Vec<u32>,
}

impl Interpreter {
    /// `folder`: where the main program lies, if it is a file.
    pub(crate) fn new(source: Source, folder: Option<PathBuf>, settings: &Settings, told: Told) -> Self {
        let flavor = told.flavor;
        let (loaded, structure) = Loaded::new(source, flavor, 0);
        let loaded = Arc::new(loaded);
        let section = loaded.index.main.unwrap_or(Section { start: Mark::START, end: 0 });
        let location = Location { file: Arc::clone(&loaded.source.name), line: 0, column: 1, length: 0, depth: 0 };
        let level = Level {
            loaded: Arc::clone(&loaded),
            section,
            cursor: section.start,
            first: section.start,
            passes_left: 0,
            kind: CallKind::Main,
            repeats: Vec::new(),
        };
        let mut interpreter = Self {
            flavor,
            assumed: !told.certain,
            folders: folder.into_iter().chain(settings.subprogram_folders.iter().cloned()).collect(),
            main: loaded,
            files: BTreeMap::new(),
            stack: vec![level],
            block: Block::default(),
            queue: VecDeque::new(),
            location,
            done: false,
            failure: None,
            structure,
            recovery: Recovery::default(),
            coverage: Coverage::default(),
            passes: Passes::default(),
            block_numbers: BTreeMap::new(),
            variables: Variables::new(flavor, &settings.variables),
            offsets: settings.work_offsets.iter().map(|(word, &offset)| (offset_key(word), offset)).collect(),
            turns: BTreeMap::new(),
            lengths: BTreeMap::new(),
            radii: BTreeMap::new(),
            modal: Modal::new(&settings.control),
            kept_modal: None,
            technology: Technology::new(),
            position: Position::new(),
            cycle: CycleValues::default(),
            held: crate::AxisValues::NONE,
            spline_end: None,
            modal_macro: None,
            moved_in_block: false,
            sequence: 0,
            started: false,
            noted_integers: false,
            told_words: BTreeSet::new(),
            missing: Vec::new(),
            noted_references: Vec::new(),
            settings: settings.clone(),
        };
        interpreter.load_offset("G54");
        let total = interpreter.modal.frames.total(flavor);
        interpreter.position.set_frame(total);
        interpreter.position.begin_at(&settings.start_position);
        interpreter
    }

    /// Hands a command out with the place of the block.
    pub(crate) fn emit(&mut self, op: Op) {
        self.queue.push_back(Command { location: self.location.clone(), op });
    }

    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.emit(Op::Note(text.into()));
    }

    /// Tells what is taken for granted where controls or their set-ups differ.
    pub(crate) fn assume(&mut self, text: impl AsRef<str>) {
        self.note(format!("{ASSUMED}{}", text.as_ref()));
    }

    /// A motion is made: loops that move are not idle.
    pub(crate) fn begin_motion(&mut self) {
        self.passes.moved();
        self.moved_in_block = true;
        self.begin();
    }

    /// Before the first motion or plane: what is in force without a word of the program.
    pub(crate) fn begin(&mut self) {
        if std::mem::replace(&mut self.started, true) {
            return;
        }
        if self.assumed {
            self.note("no word tells the control: read as Fanuc");
        }
        if self.modal.inch.is_none() {
            self.note("neither G20 nor G21 stands in the program: lengths are read as millimeters");
        }
        let word = self.modal.offset.clone();
        self.emit(Op::Offset(Offset::Work { word: word.clone() }));
        self.tell_frame(&word);
    }

    /// Work offset and frame have been told by a word of the program.
    pub(crate) fn has_begun(&self) -> bool {
        self.started
    }

    pub(crate) fn location(&self) -> &Location {
        &self.location
    }

    /// Call level: 0 in the main program.
    pub(crate) fn depth(&self) -> usize {
        self.stack.len().saturating_sub(1)
    }

    /// Executes one line.
    fn step(&mut self) -> Result<(), Box<Diagnostic>> {
        let Some(level) = self.stack.last_mut() else {
            self.done = true;
            return Ok(());
        };
        let (at, end) = (level.cursor, level.section.end);
        let loaded = Arc::clone(&level.loaded);
        let line = loaded.source.line(at).filter(|_| at.offset < end);
        let Some((line, next)) = line else {
            return self.end_of_text(&loaded, at);
        };
        level.cursor = next;
        self.coverage.mark(loaded.file, at.line, next.line);
        let mut block = std::mem::take(&mut self.block);
        let result = self.run_line(&loaded, line, at, &mut block);
        self.block = block;
        match result {
            Ok(()) => {
                self.settle_doubt();
                Ok(())
            }
            Err(fault) => Err(self.failed(&loaded, at, line, fault)),
        }
    }

    /// The end of the text ends the program as M30 and the subprogram as M99 do. On a Fanuc and a Haas no program runs into the
    /// next one of its file.
    fn end_of_text(&mut self, loaded: &Arc<Loaded>, at: Mark) -> Result<(), Box<Diagnostic>> {
        if let Some((line, _)) = loaded.source.line(at)
            && let Some(part) = loaded.index.parts.iter().find(|p| p.lines[0] == at.line && !p.outside)
            && let Some(name) = &part.name
        {
            let (first, last) = (part.lines[0], part.lines[1].saturating_sub(1).max(part.lines[0]));
            let fault = Fault::new(
                codes::NO_END,
                Span::new(0, line.trim_end().len()),
                format!("the program before runs into the head of program {name} without an end: lines {first} to {last} would not be run"),
            )
            .help("write M30 (M99 in a subprogram) before it; where it is the number of this program, write it first");
            return Err(self.failed(loaded, at, line, fault));
        }
        if self.stack.len() > 1 {
            let line = "";
            return self.leave(Span::default()).map_err(|fault| self.failed(loaded, at, line, fault));
        }
        self.done = true;
        Ok(())
    }

    fn run_line(&mut self, loaded: &Arc<Loaded>, line: &str, at: Mark, block: &mut Block) -> Result<(), Fault> {
        self.recovery.faults.stage = Stage::Unread;
        parser::parse_line(line, self.flavor, block)?;
        self.recovery.faults.stage = Stage::Read;
        if block.is_empty() || block.skip.is_some_and(|level| self.is_skipped(level)) {
            return Ok(());
        }
        let (column, length) = column_and_length(line, block.span);
        let depth = self.depth() as u32;
        self.location.move_to(&loaded.source.name, at.line, column, length, depth);
        if let Some(number) = block.number {
            self.sequence = number;
        }
        for remark in block.remarks.drain(..) {
            match remark {
                Remark::Message(text) => self.emit(Op::Message(text)),
                Remark::Note(text) => self.note(format!("({text})")),
                Remark::Abort(text) => return Err(alarm(&text, block.span)),
            }
        }
        if let Some(statement) = block.statement.take() {
            self.statement(loaded, at, statement, block, line)?;
            if block.words.is_empty() && block.assignments.is_empty() {
                return Ok(());
            }
        }
        self.execute(block, line)
    }

    /// `/` is the first level of a Fanuc.
    fn is_skipped(&self, level: u8) -> bool {
        let bits = self.settings.skipped_levels;
        bits >> level & 1 == 1 || level <= 1 && bits & 0b11 != 0
    }

    pub(crate) fn set_cursor(&mut self, to: Mark) {
        if let Some(level) = self.stack.last_mut() {
            level.cursor = to;
        }
    }

    /// Counts a jump back and refuses one too many.
    pub(crate) fn count_pass(&mut self, span: Span) -> Result<(), Fault> {
        self.passes.count(&self.settings.limits, span)
    }

    /// The end of the whole program.
    pub(crate) fn end_of_program(&mut self) {
        self.emit(Op::End);
        self.done = true;
        for level in self.stack.drain(..) {
            self.coverage.end(level.loaded.file, level.cursor.line);
        }
    }
}

/// Name of a work offset as a key: upper case, no blanks.
pub(crate) fn offset_key(word: &str) -> String {
    word.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_ascii_uppercase()
}

/// `#3000 = 1 (TEXT)`, `(ABORT, TEXT)`: the program ends itself.
pub(crate) fn alarm(text: &str, span: Span) -> Fault {
    Fault::new(codes::PROGRAM_ALARM, span, format!("the program raises an alarm: {}", text.trim()))
        .help("find out which of its conditions is not met")
}

impl Iterator for Interpreter {
    type Item = Result<Command, Box<Diagnostic>>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(command) = self.queue.pop_front() {
                return Some(Ok(command));
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
