//! Runs a program line by line: control structures, jumps, subprograms.
//!
//! Commands leave one by one; what is kept is the text, the index of its structure, the variables and the modal state, never
//! the executed blocks.

mod assign;
mod calls;
mod jumps;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;

use super::corners::{Corner, CornerMark};
use super::eval::{self, Val, Variables};
use super::expr::Expr;
use super::index::{Index, Section};
use super::modal::{Modal, Technology};
use super::parser::{self, Block, Call, Statement};
use super::recover::Recovery;
use crate::diagnostic::{Diagnostic, Fault, Span, column_and_length};
use crate::dialect::coverage::Coverage;
use crate::dialect::doubt::Stage;
use crate::dialect::passes::Passes;
use crate::frame::Frame;
use crate::not_run::NotRun;
use crate::source::{Mark, Source};
use crate::state::Position;
use crate::{Command, Location, Op, Settings, WorkOffset};

pub(crate) use calls::missing_subprogram;

/// A program file with its structure.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) source: Source,
    pub(super) index: Index,
    /// Its number among the files of the run.
    pub(crate) file: usize,
}

impl Loaded {
    /// The file, and what is wrong with its structure.
    pub(crate) fn new(source: Source, file: usize) -> (Self, Vec<Diagnostic>) {
        let mut faults = Vec::new();
        let index = Index::new(&source, &mut faults);
        (Self { source, index, file }, faults)
    }
}

/// Part of a program that a REPEAT with labels runs again.
#[derive(Debug)]
struct Repetition {
    first: Mark,
    /// A pass is complete when the next line begins here.
    end: usize,
    remaining: u32,
    resume: Mark,
}

/// One level of the call stack.
#[derive(Debug)]
pub(super) struct Level {
    loaded: Arc<Loaded>,
    section: Section,
    cursor: Mark,
    repetitions: Vec<Repetition>,
    /// Passes of `L100 P3` still to do after this one.
    passes_left: u32,
    first_line: Mark,
    /// Parameters by reference: name inside and name outside.
    references: Vec<(String, Expr)>,
    saved: Option<Box<Modal>>,
}

/// A modal call with the values of its arguments.
#[derive(Clone, Debug)]
pub(crate) struct ModalCall {
    pub(crate) call: Call,
    /// Call level at which it is in force.
    pub(crate) level: usize,
}

#[derive(Debug)]
pub(crate) struct Interpreter {
    pub(crate) settings: Settings,
    folders: Vec<PathBuf>,
    pub(super) files: BTreeMap<PathBuf, Arc<Loaded>>,
    pub(super) main: Arc<Loaded>,
    pub(super) stack: Vec<Level>,
    pub(super) block: Block,
    queue: VecDeque<(Command, Option<Box<CornerMark>>)>,
    /// Commands that have passed the corners.
    pub(crate) ready: VecDeque<Command>,
    /// The last motion asked for a chamfer or rounding at its end.
    pub(crate) corner_waits: bool,
    /// Motions handed out so far.
    pub(crate) moves: u64,
    /// A motion that waits for the block behind it.
    pub(crate) corner: Option<Box<Corner>>,
    location: Location,
    pub(super) done: bool,
    /// What ended the run, to be told behind the commands before it.
    failure: Option<Box<Diagnostic>>,
    /// What is wrong with the structure of the main file.
    pub(super) structure: Vec<Diagnostic>,
    pub(super) recovery: Recovery,
    pub(super) coverage: Coverage,
    pub(super) passes: Passes,
    /// The FOR line is reached from its ENDFOR.
    pub(super) next_pass_of_for: bool,
    block_numbers: BTreeMap<(Arc<str>, usize, u32, bool), Mark>,
    pub(crate) variables: Variables,
    /// Settable frames by the G word that calls them.
    pub(crate) offsets: BTreeMap<String, Frame>,
    /// Variables of type FRAME; one scope for the whole run.
    pub(crate) frame_variables: BTreeMap<String, Frame>,
    pub(crate) modal: Modal,
    pub(crate) technology: Technology,
    pub(crate) position: Position,
    /// Words of the control file whose reason has been told.
    pub(super) told_words: BTreeSet<usize>,
    /// Subprograms that were called and are not there.
    pub(super) missing: Vec<NotRun>,
    /// Direction of motion at the end of the last motion, work coordinates: for CT.
    pub(crate) tangent: Option<[f64; 3]>,
    pub(crate) modal_call: Option<ModalCall>,
    /// CTOL, mm.
    pub(crate) contour_tolerance: Option<f64>,
    /// OTOL, radian.
    pub(crate) orientation_tolerance: Option<f64>,
    /// ADIS in the unit of the program.
    pub(crate) rounding: f64,
}

impl Interpreter {
    /// `folder`: where the main program lies, if it is a file.
    pub(crate) fn new(source: Source, folder: Option<PathBuf>, settings: &Settings) -> Self {
        let (loaded, structure) = Loaded::new(source, 0);
        let loaded = Arc::new(loaded);
        let section = loaded.index.main;
        let location = Location { file: Arc::clone(&loaded.source.name), line: 0, column: 1, length: 0, depth: 0 };
        let main = Arc::clone(&loaded);
        let level = Level {
            loaded,
            section,
            cursor: section.start,
            repetitions: Vec::new(),
            passes_left: 0,
            first_line: section.start,
            references: Vec::new(),
            saved: None,
        };
        Self {
            folders: folder.into_iter().chain(settings.subprogram_folders.iter().cloned()).collect(),
            files: BTreeMap::new(),
            main,
            stack: vec![level],
            block: Block::default(),
            queue: VecDeque::new(),
            ready: VecDeque::new(),
            corner: None,
            corner_waits: false,
            moves: 0,
            location,
            done: false,
            failure: None,
            structure,
            recovery: Recovery::default(),
            coverage: Coverage::default(),
            passes: Passes::default(),
            next_pass_of_for: false,
            block_numbers: BTreeMap::new(),
            variables: Variables::new(&settings.variables, settings.limits.max_array_elements),
            offsets: settings
                .work_offsets
                .iter()
                .map(|(word, &offset)| (word.to_ascii_uppercase(), settable(offset)))
                .collect(),
            frame_variables: BTreeMap::new(),
            modal: Modal::new(settings.orientation_interpolation, &settings.control),
            technology: Technology::new(),
            position: {
                let mut position = Position::new();
                position.begin_at(&settings.start_position);
                position
            },
            told_words: BTreeSet::new(),
            missing: Vec::new(),
            tangent: None,
            modal_call: None,
            contour_tolerance: None,
            orientation_tolerance: None,
            rounding: 0.0,
            settings: settings.clone(),
        }
    }

    /// The text that is run, and the line of the block.
    pub(super) fn place_now(&self) -> Option<(&Source, u32)> {
        self.stack.last().map(|level| (&level.loaded.source, self.location.line))
    }

    /// Hands a command out with the place of the block.
    pub(crate) fn emit(&mut self, op: Op) {
        self.queue.push_back((Command { location: self.location.clone(), op }, None));
    }

    /// Marks the motion handed out last, with what its end needs.
    pub(crate) fn mark_corner(&mut self, mark: CornerMark) {
        if let Some((_, slot)) = self.queue.back_mut() {
            *slot = Some(Box::new(mark));
        }
    }

    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.emit(Op::Note(text.into()));
    }

    /// A line of a program that was read, for messages.
    pub(crate) fn line_of(&self, file: &str, line: u32) -> Option<String> {
        let mut programs = std::iter::once(&self.main).chain(self.files.values());
        let program = programs.find(|program| &*program.source.name == file)?;
        crate::compensation::line_of(&program.source, line)
    }

    /// Call level: 0 in the main program.
    pub(crate) fn depth(&self) -> usize {
        self.stack.len().saturating_sub(1)
    }

    /// A motion was made: loops that move are not idle.
    pub(crate) fn moved(&mut self) {
        self.passes.moved();
        self.moves += 1;
    }

    /// Ends the program, or the subprogram.
    pub(crate) fn end_of_program(&mut self) {
        if self.stack.len() <= 1 {
            self.emit(Op::End);
            self.done = true;
            for level in self.stack.drain(..) {
                self.coverage.end(level.loaded.file, level.cursor.line);
            }
        } else {
            self.leave();
        }
    }

    /// Executes one line.
    fn step(&mut self) -> Result<(), Box<Diagnostic>> {
        let Some(level) = self.stack.last_mut() else {
            self.done = true;
            return Ok(());
        };
        if let Some(repetition) = level.repetitions.last_mut()
            && repetition.end == level.cursor.offset
        {
            if repetition.remaining > 1 {
                repetition.remaining -= 1;
                level.cursor = repetition.first;
                let loaded = Arc::clone(&level.loaded);
                let at = level.cursor;
                let line = loaded.source.line(at).map_or("", |(line, _)| line);
                return self
                    .count_pass(Span::new(0, line.len()))
                    .map_err(|fault| self.failed(&loaded, at, line, fault));
            }
            level.cursor = repetition.resume;
            level.repetitions.pop();
        }
        let (at, section) = (level.cursor, level.section);
        let loaded = Arc::clone(&level.loaded);
        let line = loaded.source.line(at).filter(|_| at.offset < section.end);
        let Some((line, next)) = line else {
            // The end of the text ends the program as M30 and the subprogram as M17 do.
            if self.stack.len() > 1 {
                self.leave();
            } else {
                self.done = true;
            }
            return Ok(());
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

    fn run_line(&mut self, loaded: &Arc<Loaded>, line: &str, at: Mark, block: &mut Block) -> Result<(), Fault> {
        self.recovery.faults.stage = Stage::Unread;
        parser::parse_line(line, block)?;
        self.recovery.faults.stage = Stage::Read;
        if block.is_empty() || block.skip.is_some_and(|level| self.settings.skipped_levels >> level & 1 == 1) {
            return Ok(());
        }
        let (column, length) = column_and_length(line, block.span);
        let depth = self.depth() as u32;
        self.location.move_to(&loaded.source.name, at.line, column, length, depth);
        if line.contains('$') || !self.frame_variables.is_empty() {
            self.refresh_system(block);
        }
        match block.statement.take() {
            Some(statement) => self.statement(loaded, at, statement, block.span),
            None => self.execute(block, line),
        }
    }

    fn truth(&self, condition: &Expr, span: Span) -> Result<bool, Fault> {
        Ok(self.variables.number(condition, span)? != 0.0)
    }

    fn statement(&mut self, loaded: &Arc<Loaded>, at: Mark, statement: Statement, span: Span) -> Result<(), Fault> {
        match statement {
            Statement::If(condition) => {
                if !self.truth(&condition, span)? {
                    self.continue_after(loaded, Self::partner(loaded, at, span)?);
                }
            }
            Statement::Else => self.continue_after(loaded, Self::partner(loaded, at, span)?),
            Statement::EndIf | Statement::Repeat | Statement::Loop | Statement::Extern | Statement::Proc { .. } => {}
            Statement::IfGoto(condition, jump) => {
                if self.truth(&condition, span)? {
                    self.jump(loaded, at, &jump)?;
                }
            }
            Statement::For { variable, from, to } => {
                let value = if std::mem::take(&mut self.next_pass_of_for) {
                    self.variables.number(&variable, span)? + 1.0
                } else {
                    self.variables.number(&from, span)?
                };
                self.assign_expr(&variable, Val::Number(value), span)?;
                if value > self.variables.number(&to, span)? {
                    self.continue_after(loaded, Self::partner(loaded, at, span)?);
                }
            }
            Statement::EndFor => {
                self.count_pass(span)?;
                self.next_pass_of_for = true;
                self.set_cursor(Self::partner(loaded, at, span)?);
            }
            Statement::While(condition) => {
                if !self.truth(&condition, span)? {
                    self.continue_after(loaded, Self::partner(loaded, at, span)?);
                }
            }
            Statement::EndWhile => {
                self.count_pass(span)?;
                self.set_cursor(Self::partner(loaded, at, span)?);
            }
            Statement::EndLoop => {
                self.count_pass(span)?;
                self.continue_after(loaded, Self::partner(loaded, at, span)?);
            }
            Statement::Until(condition) => {
                if !self.truth(&condition, span)? {
                    self.count_pass(span)?;
                    self.continue_after(loaded, Self::partner(loaded, at, span)?);
                }
            }
            Statement::GotoStart => {
                self.count_pass(span)?;
                if let Some(level) = self.stack.last_mut() {
                    level.cursor = level.section.start;
                }
            }
            Statement::Goto(jump) => self.jump(loaded, at, &jump)?,
            Statement::Case { selector, branches, default } => {
                let selector = self.variables.number(&selector, span)?;
                for (value, jump) in &branches {
                    if self.variables.number(value, span)? == selector {
                        return self.jump(loaded, at, jump);
                    }
                }
                if let Some(jump) = default {
                    self.jump(loaded, at, &jump)?;
                }
            }
            Statement::RepeatLabel { first, last, count, only_block } => {
                self.repeat(loaded, at, &first, last.as_deref(), count.as_ref(), only_block, span)?;
            }
            Statement::Define { kind, variables } => {
                for definition in &variables {
                    self.define(kind, definition)?;
                }
            }
            Statement::Return => self.end_of_program(),
            Statement::ModalCall(call) => {
                self.modal_call = match call {
                    None => None,
                    Some(call) => Some(ModalCall { call: self.with_values(&call, span)?, level: self.depth() }),
                };
            }
            Statement::CallText(name) => {
                let name = eval::shown(&self.variables.eval(&name, span)?).to_ascii_uppercase();
                let name = name.rsplit(['/', '\\']).next().unwrap_or_default();
                let name = name.strip_prefix("_N_").unwrap_or(name);
                let name =
                    ["_SPF", "_MPF", ".SPF", ".MPF"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(name);
                let call = Call { name: name.to_owned(), arguments: None };
                if !self.call_subprogram(&call, 1, span)? {
                    return Err(missing_subprogram(&call.name, span));
                }
            }
        }
        Ok(())
    }
}

/// Settable frame of a work offset of the settings.
fn settable(offset: WorkOffset) -> Frame {
    Frame { rotary: offset.rotary, ..Frame::translation(offset.translation) }
}

impl Iterator for Interpreter {
    type Item = Result<Command, Box<Diagnostic>>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(command) = self.ready.pop_front() {
                return Some(Ok(command));
            }
            if let Some((command, mark)) = self.queue.pop_front() {
                if mark.is_none() && self.corner.is_none() {
                    return Some(Ok(command));
                }
                if let Err(fault) = self.through_corners(command, mark) {
                    self.queue.clear();
                    self.done = true;
                    self.corner_failed();
                    self.failure = Some(fault);
                }
                continue;
            }
            if self.done
                && let Some(corner) = self.corner.take()
            {
                self.no_corner(corner);
                continue;
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
