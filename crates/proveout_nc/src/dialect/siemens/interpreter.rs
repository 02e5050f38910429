//! Runs a program line by line: control structures, jumps, subprograms.
//!
//! Commands leave one by one; what is kept is the text, the index of its structure, the variables and the modal state, never
//! the executed blocks.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;

use super::eval::{self, Val, Variables};
use super::expr::Expr;
use super::index::{self, Index, Section};
use super::modal::{Modal, Technology};
use super::parser::{self, Block, Call, Definition, Direction, Jump, Parameter, Statement, Type};
use crate::codes;
use crate::diagnostic::{Diagnostic, Diagnostics, Fault, Span, column_and_length};
use crate::source::{Mark, Source};
use crate::state::Position;
use crate::{Command, Location, Op, Settings, WorkOffset};

/// A program file with its structure.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) source: Source,
    index: Index,
}

impl Loaded {
    pub(crate) fn new(source: Source) -> Result<Self, Diagnostics> {
        let mut faults = Vec::new();
        let index = Index::new(&source, &mut faults);
        if faults.is_empty() { Ok(Self { source, index }) } else { Err(Diagnostics(faults)) }
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
struct Level {
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
    files: BTreeMap<PathBuf, Arc<Loaded>>,
    main: Arc<Loaded>,
    stack: Vec<Level>,
    block: Block,
    pub(crate) queue: VecDeque<Command>,
    location: Location,
    done: bool,
    /// What ended the run, to be told behind the commands before it.
    failure: Option<Box<Diagnostic>>,
    passes: u64,
    idle_passes: u64,
    /// The FOR line is reached from its ENDFOR.
    next_pass_of_for: bool,
    block_numbers: BTreeMap<(Arc<str>, usize, u32, bool), Mark>,
    pub(crate) variables: Variables,
    pub(crate) offsets: BTreeMap<String, WorkOffset>,
    pub(crate) modal: Modal,
    pub(crate) technology: Technology,
    pub(crate) position: Position,
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
    pub(crate) fn new(source: Source, folder: Option<PathBuf>, settings: &Settings) -> Result<Self, Diagnostics> {
        let loaded = Arc::new(Loaded::new(source)?);
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
        Ok(Self {
            folders: folder.into_iter().chain(settings.subprogram_folders.iter().cloned()).collect(),
            files: BTreeMap::new(),
            main,
            stack: vec![level],
            block: Block::default(),
            queue: VecDeque::new(),
            location,
            done: false,
            failure: None,
            passes: 0,
            idle_passes: 0,
            next_pass_of_for: false,
            block_numbers: BTreeMap::new(),
            variables: Variables::new(&settings.variables, settings.limits.max_array_elements),
            offsets: settings.work_offsets.iter().map(|(word, &offset)| (word.to_ascii_uppercase(), offset)).collect(),
            modal: Modal::new(settings.orientation_interpolation),
            technology: Technology::new(),
            position: Position::new(),
            tangent: None,
            modal_call: None,
            contour_tolerance: None,
            orientation_tolerance: None,
            rounding: 0.0,
            settings: settings.clone(),
        })
    }

    /// Hands a command out with the place of the block.
    pub(crate) fn emit(&mut self, op: Op) {
        self.queue.push_back(Command { location: self.location.clone(), op });
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
        self.idle_passes = 0;
    }

    /// Ends the program, or the subprogram.
    pub(crate) fn end_of_program(&mut self) {
        if self.stack.len() <= 1 {
            self.emit(Op::End);
            self.done = true;
            self.stack.clear();
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
                    .map_err(|fault| Box::new(fault.at(&loaded.source.name, at.line, line)));
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
        let mut block = std::mem::take(&mut self.block);
        let result = self.run_line(&loaded, line, at, &mut block);
        self.block = block;
        result.map_err(|fault| Box::new(fault.at(&loaded.source.name, at.line, line)))
    }

    fn run_line(&mut self, loaded: &Arc<Loaded>, line: &str, at: Mark, block: &mut Block) -> Result<(), Fault> {
        parser::parse_line(line, block)?;
        if block.is_empty() || block.skip.is_some_and(|level| self.settings.skipped_levels >> level & 1 == 1) {
            return Ok(());
        }
        let (column, length) = column_and_length(line, block.span);
        let depth = self.depth() as u32;
        if Arc::ptr_eq(&self.location.file, &loaded.source.name) {
            self.location.line = at.line;
            self.location.column = column;
            self.location.length = length;
            self.location.depth = depth;
        } else {
            self.location = Location { file: Arc::clone(&loaded.source.name), line: at.line, column, length, depth };
        }
        match block.statement.take() {
            Some(statement) => self.statement(loaded, at, statement, block.span),
            None => self.execute(block, line),
        }
    }

    fn set_cursor(&mut self, to: Mark) {
        if let Some(level) = self.stack.last_mut() {
            level.cursor = to;
        }
    }

    /// Continues behind a line.
    fn continue_after(&mut self, loaded: &Loaded, line: Mark) {
        let next = loaded.source.line(line).map_or(line, |(_, next)| next);
        self.set_cursor(next);
    }

    fn partner(loaded: &Loaded, at: Mark, span: Span) -> Result<Mark, Fault> {
        loaded.index.partners.get(&at.offset).copied().ok_or_else(|| {
            Fault::new(codes::STRUCTURE, span, "the other end of this control structure is missing").help("write it")
        })
    }

    fn truth(&self, condition: &Expr, span: Span) -> Result<bool, Fault> {
        Ok(self.variables.number(condition, span)? != 0.0)
    }

    /// Counts a jump back and refuses one too many.
    fn count_pass(&mut self, span: Span) -> Result<(), Fault> {
        self.passes += 1;
        self.idle_passes += 1;
        let limits = self.settings.limits;
        if self.passes > limits.max_loop_passes {
            let message =
                format!("the program has jumped back {} times, the limit of the settings", limits.max_loop_passes);
            return Err(Fault::new(codes::LOOP_LIMIT, span, message)
                .help("check the conditions of the loops, or raise max_loop_passes"));
        }
        if self.idle_passes > limits.max_idle_passes {
            let message = format!("the loop has run {} times without a motion", limits.max_idle_passes);
            return Err(Fault::new(codes::LOOP_LIMIT, span, message)
                .help("check the condition of the loop, or raise max_idle_passes"));
        }
        Ok(())
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
                let name = name.rsplit('/').next().unwrap_or_default();
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

    fn define(&mut self, kind: Type, definition: &Definition) -> Result<(), Fault> {
        let span = definition.span;
        let sizes = self.variables.indices(&definition.sizes, span)?;
        let count = sizes.len();
        self.variables.define(&definition.name, kind, sizes.clone(), span)?;
        let Some(initial) = &definition.initial else { return Ok(()) };
        if count > 0 {
            return self.fill(&definition.name, &sizes, initial, span);
        }
        let value = self.variables.eval(initial, span)?;
        self.variables.assign(&definition.name, &[], value, span).map(|_| ())
    }

    /// `DEF REAL A[3] = SET(1, 2, 3)`, `= REP(0)`, `= 5`.
    fn fill(&mut self, name: &str, sizes: &[usize], initial: &Expr, span: Span) -> Result<(), Fault> {
        let (list, repeat) = match initial {
            Expr::Call(function, arguments) if function == "SET" => {
                (arguments.iter().flatten().cloned().collect(), false)
            }
            Expr::Call(function, arguments) if function == "REP" => {
                (arguments.iter().flatten().take(1).cloned().collect(), true)
            }
            other => (vec![other.clone()], true),
        };
        let count: usize = sizes.iter().product();
        for at in 0..count {
            let Some(expr) = (if repeat { list.first() } else { list.get(at) }) else { break };
            let mut rest = at;
            let mut indices = vec![0; sizes.len()];
            for (index, size) in indices.iter_mut().zip(sizes).rev() {
                *index = rest % size;
                rest /= size;
            }
            let value = self.variables.eval(expr, span)?;
            self.variables.assign(name, &indices, value, span)?;
        }
        Ok(())
    }

    /// Assigns to a variable, an element or an R parameter given as an expression.
    pub(crate) fn assign_expr(&mut self, target: &Expr, value: Val, span: Span) -> Result<(), Fault> {
        let (name, indices) = match target {
            Expr::Param(index) => {
                let index = eval::param_index(self.variables.number(index, span)?, span)?;
                let Val::Number(value) = value else {
                    return Err(Fault::new(codes::TYPE, span, format!("R{index} cannot hold a text"))
                        .help("use a STRING variable"));
                };
                self.variables.assign_param(index, value);
                return Ok(());
            }
            Expr::Name(name) => (name, Vec::new()),
            Expr::Element(name, indices) => (name, self.variables.indices(indices, span)?),
            _ => {
                return Err(
                    Fault::new(codes::SYNTAX, span, "only a variable can be assigned to").help("write NAME=value")
                );
            }
        };
        if self.variables.assign(name, &indices, value, span)? {
            return Ok(());
        }
        let fault = if name.starts_with('$') {
            Fault::new(codes::UNSUPPORTED_WORD, span, format!("the system variable `{name}` cannot be written here"))
                .help("of the system variables, $P_UIFR can be written")
        } else {
            Fault::new(codes::UNKNOWN_VARIABLE, span, format!("the variable `{name}` is not defined"))
                .help(format!("write DEF REAL {name} before it is used"))
        };
        Err(fault)
    }

    fn jump(&mut self, loaded: &Arc<Loaded>, at: Mark, jump: &Jump) -> Result<(), Fault> {
        let name = match &jump.target {
            Expr::Name(name) if !self.variables.is_defined(name) => name.clone(),
            other => eval::shown(&self.variables.eval(other, jump.span)?).to_ascii_uppercase(),
        };
        let found = match jump.direction {
            Direction::Forward => self.find_target(loaded, at, &name, true),
            Direction::Backward => self.find_target(loaded, at, &name, false),
            Direction::Either => {
                self.find_target(loaded, at, &name, true).or_else(|| self.find_target(loaded, at, &name, false))
            }
        };
        let Some(target) = found else {
            let way = match jump.direction {
                Direction::Forward => "behind this block",
                Direction::Backward => "before this block",
                Direction::Either => "in this program",
            };
            return Err(Fault::new(codes::JUMP_TARGET, jump.span, format!("the jump target `{name}` is not {way}"))
                .help("write the label with a colon, or jump in the other direction"));
        };
        if target.offset <= at.offset {
            self.count_pass(jump.span)?;
        }
        self.set_cursor(target);
        Ok(())
    }

    fn find_target(&mut self, loaded: &Arc<Loaded>, at: Mark, name: &str, forward: bool) -> Option<Mark> {
        let section = self.stack.last()?.section;
        if let Some(mark) = loaded.index.label(name, section, at.offset, forward) {
            return Some(mark);
        }
        let number: u32 = name.strip_prefix('N')?.parse().ok()?;
        let key = (Arc::clone(&loaded.source.name), at.offset, number, forward);
        if let Some(mark) = self.block_numbers.get(&key) {
            return Some(*mark);
        }
        let mark = index::find_block_number(&loaded.source, section, number, at, forward)?;
        self.block_numbers.insert(key, mark);
        Some(mark)
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one statement")]
    fn repeat(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        first: &str,
        last: Option<&str>,
        count: Option<&Expr>,
        only_block: bool,
        span: Span,
    ) -> Result<(), Fault> {
        let count = match count {
            Some(count) => self.variables.number(count, span)?.round().clamp(0.0, f64::from(u32::MAX)) as u32,
            None => 1,
        };
        if count == 0 {
            return Ok(());
        }
        let missing = |name: &str| {
            Fault::new(codes::JUMP_TARGET, span, format!("the label `{name}` of the repetition is not in this program"))
                .help("write the label with a colon")
        };
        let from = self
            .find_target(loaded, at, first, false)
            .or_else(|| self.find_target(loaded, at, first, true))
            .ok_or_else(|| missing(first))?;
        let after = |mark: Mark| loaded.source.line(mark).map_or(mark, |(_, next)| next).offset;
        let end = if only_block {
            after(from)
        } else {
            let last_line = match last {
                Some(last) => Some(
                    self.find_target(loaded, from, last, true)
                        .or_else(|| (last == first).then_some(from))
                        .ok_or_else(|| missing(last))?,
                ),
                None => self
                    .find_target(loaded, from, "ENDLABEL", true)
                    .filter(|m| m.offset < at.offset || from.offset > at.offset),
            };
            match last_line {
                Some(mark) => after(mark),
                None if from.offset < at.offset => at.offset,
                None => return Err(missing("ENDLABEL")),
            }
        };
        let Some(level) = self.stack.last_mut() else { return Ok(()) };
        let resume = level.cursor;
        // A repetition that was left by a jump is given up when its REPEAT is reached again.
        if let Some(old) = level.repetitions.iter().position(|r| r.resume == resume) {
            level.repetitions.truncate(old);
        }
        level.repetitions.push(Repetition { first: from, end, remaining: count, resume });
        level.cursor = from;
        self.count_pass(span)
    }

    /// The call with its arguments replaced by their values.
    fn with_values(&self, call: &Call, span: Span) -> Result<Call, Fault> {
        let arguments = match &call.arguments {
            None => None,
            Some(list) => Some(
                list.iter()
                    .map(|argument| match argument {
                        None => Ok(None),
                        Some(expr) => self.variables.eval(expr, span).map(|value| {
                            Some(match value {
                                Val::Number(number) => Expr::Number(number),
                                Val::Text(text) => Expr::Text(text),
                            })
                        }),
                    })
                    .collect::<Result<Vec<_>, Fault>>()?,
            ),
        };
        Ok(Call { name: call.name.clone(), arguments })
    }

    /// Enters a subprogram of the same file or of the folders; false when there is none with this name.
    pub(crate) fn call_subprogram(&mut self, call: &Call, passes: u32, span: Span) -> Result<bool, Fault> {
        let Some((loaded, section)) = self.find_subprogram(&call.name, span)? else {
            return Ok(false);
        };
        let limit = self.settings.limits.max_call_depth;
        if self.stack.len() > limit as usize {
            let message = format!("`{}` is called at depth {}; the limit is {limit}", call.name, self.stack.len());
            return Err(
                Fault::new(codes::NESTING_LIMIT, span, message).help("check for a subprogram that calls itself")
            );
        }
        let (parameters, save, first_line) = procedure_head(&loaded, section).map_err(|fault| {
            let message = format!("the head of the subprogram `{}` is broken: {}", call.name, fault.message);
            Fault { code: codes::SUBPROGRAM, message, help: fault.help, span }
        })?;
        let given = call.arguments.as_deref().unwrap_or_default();
        if given.len() > parameters.len() {
            let message = format!("`{}` takes {} arguments and is given {}", call.name, parameters.len(), given.len());
            return Err(Fault::new(codes::ARGUMENTS, span, message).help("compare the call with the PROC line"));
        }
        let mut values = Vec::new();
        let mut references = Vec::new();
        for (i, parameter) in parameters.iter().enumerate() {
            let argument = given.get(i).and_then(Option::as_ref);
            let value = match argument.or(parameter.initial.as_ref()) {
                Some(expr) => Some(self.variables.eval(expr, span)?),
                None => None,
            };
            if let Some(argument) = argument.filter(|_| parameter.by_reference) {
                references.push((parameter.name.clone(), argument.clone()));
            }
            values.push(value);
        }
        self.variables.enter();
        for (parameter, value) in parameters.iter().zip(values) {
            self.variables.define(&parameter.name, parameter.kind, Vec::new(), span)?;
            if let Some(value) = value {
                self.variables.assign(&parameter.name, &[], value, span)?;
            }
        }
        let saved = save.then(|| Box::new(self.modal.clone()));
        self.stack.push(Level {
            loaded,
            section,
            cursor: first_line,
            repetitions: Vec::new(),
            passes_left: passes.saturating_sub(1),
            first_line,
            references,
            saved,
        });
        Ok(true)
    }

    /// Leaves a subprogram, or begins its next pass.
    fn leave(&mut self) {
        if let Some(level) = self.stack.last_mut()
            && level.passes_left > 0
        {
            level.passes_left -= 1;
            level.cursor = level.first_line;
            return;
        }
        let Some(level) = self.stack.pop() else { return };
        let locals = self.variables.leave();
        for (inside, outside) in level.references {
            if let Some(value) = locals.get(&inside).and_then(|variable| variable.single()) {
                // The target was read when the call was made, so that it can be assigned now.
                let _ = self.assign_expr(&outside, value.clone(), Span::default());
            }
        }
        if self.modal_call.as_ref().is_some_and(|modal| modal.level > self.depth()) {
            self.modal_call = None;
        }
        if let Some(saved) = level.saved {
            let (path_mode, side) = (self.modal.path_mode, self.modal.compensation.side);
            self.modal = *saved;
            if self.modal.compensation.side != side {
                self.tell_compensation();
            }
            if self.modal.path_mode != path_mode {
                self.emit(Op::PathMode(self.modal.path_mode));
            }
            if *self.position.frame() != self.modal.frames.total() {
                self.take_frames("SAVE");
            }
        }
    }

    fn find_subprogram(&mut self, name: &str, span: Span) -> Result<Option<(Arc<Loaded>, Section)>, Fault> {
        for level in self.stack.iter().rev() {
            if let Some(section) = level.loaded.index.procs.get(name) {
                return Ok(Some((Arc::clone(&level.loaded), *section)));
            }
        }
        for folder in self.folders.clone() {
            let Ok(entries) = std::fs::read_dir(&folder) else { continue };
            let mut found: Vec<PathBuf> = entries
                .filter_map(|entry| Some(entry.ok()?.path()))
                .filter(|path| {
                    let stem = path.file_stem().map(|s| s.to_string_lossy().to_ascii_uppercase());
                    let ending = path.extension().map(|s| s.to_string_lossy().to_ascii_uppercase());
                    stem.as_deref() == Some(name) && matches!(ending.as_deref(), Some("SPF" | "MPF"))
                })
                .collect();
            // SPF before MPF, then by name: the order of a folder decides nothing.
            found.sort_by_key(|path| {
                let main = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("MPF"));
                (main, path.clone())
            });
            if let Some(path) = found.into_iter().next() {
                if let Some(loaded) = self.files.get(&path) {
                    return Ok(Some((Arc::clone(loaded), loaded.index.main)));
                }
                let failed = |text: String| Fault::new(codes::SUBPROGRAM, span, text).help("correct the subprogram");
                let source =
                    Source::read(&path).map_err(|d| failed(format!("the subprogram `{name}` cannot be read: {d}")))?;
                let loaded =
                    Loaded::new(source).map_err(|d| failed(format!("the subprogram `{name}` is broken: {d}")))?;
                let loaded = Arc::new(loaded);
                let section = loaded.index.main;
                self.files.insert(path, Arc::clone(&loaded));
                return Ok(Some((loaded, section)));
            }
        }
        Ok(None)
    }
}

pub(crate) fn missing_subprogram(name: &str, span: Span) -> Fault {
    Fault::new(codes::SUBPROGRAM, span, format!("the subprogram `{name}` is not there"))
        .help(format!("put {name}.SPF into the folder of the program, or `PROC {name}` into its file"))
}

/// Parameters of a subprogram, whether it saves modal state, and its first line behind PROC.
fn procedure_head(loaded: &Loaded, section: Section) -> Result<(Vec<Parameter>, bool, Mark), Fault> {
    let mut block = Block::default();
    let mut at = section.start;
    while let Some((line, next)) = loaded.source.line(at) {
        if at.offset >= section.end {
            break;
        }
        parser::parse_line(line, &mut block)?;
        if let Some(Statement::Proc { parameters, save, .. }) = block.statement.take() {
            return Ok((parameters, save, next));
        }
        if !block.is_empty() {
            break;
        }
        at = next;
    }
    Ok((Vec::new(), false, section.start))
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
                self.stack.clear();
                self.failure = Some(diagnostic);
            }
        }
    }
}
