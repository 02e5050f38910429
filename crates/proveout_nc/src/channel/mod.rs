//! The channel: what every reader does in the same way, whatever language it reads.
//!
//! ```text
//!   text ─► Language::step ─► words of a block ─► Channel ─► queue ─► Language::hand_out ─► commands
//!              grammar            meanings           technology, motion, holes:
//!                                                    emitted once, for all languages
//! ```
//!
//! [`Channel`] holds what a run needs: the files and the stack of calls ([`flow`]), the queue of commands
//! with the place of their block, position ([`motion`]), feed, spindle and tool ([`technology`]), the courses
//! of holes ([`holes`]) and pockets ([`milling`]), motions that wait for the next one ([`corners`]) or for
//! the answer of a probe ([`probing`]), what is known of faults ([`recover`], [`doubt`]), how often the
//! program has jumped back ([`passes`]), and which lines have run ([`coverage`]). Formulas of all languages
//! are one tree ([`expression`]) with one parser ([`formula`]); [`listed`] does what a control file says. A
//! language is a type with [`Language`]: it says how one block is read and executed, and keeps in
//! [`Channel::own`] what no other language has. Everything is resolved when it is compiled; nothing is boxed
//! for a block.

pub(crate) mod corners;
pub(crate) mod coverage;
pub(crate) mod doubt;
pub(crate) mod expression;
mod flow;
pub(crate) mod formula;
mod holes;
mod listed;
pub(crate) mod milling;
mod motion;
pub(crate) mod parameters;
pub(crate) mod passes;
pub(crate) mod probing;
mod recover;
pub(crate) mod shape;
mod technology;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Debug;
use std::path::PathBuf;
use std::sync::Arc;

use crate::compensation::CompStyle;
use crate::diagnostic::{Diagnostic, Fault, Span, column_and_length};
use crate::dialect::Reader;
use crate::not_run::NotRun;
use crate::source::{Mark, Source};
use crate::state::Position;
use crate::{Command, Location, Note, Op, Settings, codes};

use coverage::Coverage;
use doubt::Doubt;
use passes::Passes;

pub(crate) use flow::{LoadedProgram, ProgramSection, StackLevel};
pub(crate) use holes::{Holes, Stroke};
pub(crate) use motion::{arc_fault, differ_by_little, finite, unknown_axes, unknown_axis};
pub(crate) use parameters::UsualFeed;
pub(crate) use recover::{FailedBlock, Recovery, Salvage, TakenOut};
pub(crate) use technology::{Technology, direction_of, direction_of_thread, opposite};

/// A language of programs: how its blocks are read, and what they mean.
pub(crate) trait Language: Debug + Sized {
    /// Structure of a program file.
    type Index: Debug;
    /// What a level of the call stack keeps besides its place.
    type Level: Debug;
    /// The words of a block; one is kept for the whole run.
    type Block: Debug + Default;
    /// What a command carries on its way out of the queue.
    type Mark: Debug + Default;
    type Variables: Debug;
    /// What stays in force from block to block.
    type Modal: Debug;

    /// Structure of a file, and what is wrong with it. `main`: the file is that of the program, not of a
    /// subprogram.
    fn index(&self, source: &Source, main: bool, faults: &mut Vec<Diagnostic>) -> Self::Index;

    /// Executes the next block.
    fn step(channel: &mut Channel<Self>) -> Result<(), Box<Diagnostic>>;

    /// The next command that may leave; languages in which a motion depends on the next block keep
    /// it back here.
    #[inline]
    fn hand_out(channel: &mut Channel<Self>) -> Option<Command> {
        channel.queue.pop_front().map(|(command, _)| command)
    }

    /// A fault that may be there only because of one before.
    fn may_follow(channel: &Channel<Self>, fault: &Diagnostic) -> bool;

    /// The reported fault may follow from one before.
    fn follows(channel: &Channel<Self>, fault: &Diagnostic) -> bool {
        Self::may_follow(channel, fault)
    }

    /// Places a fault of a block in its line.
    fn locate(fault: Fault, source: &Source, at: Mark, text: &str) -> Diagnostic {
        fault.at(&source.name, at.line, text)
    }

    /// Ends the doubt about what the executed block has set again.
    fn settle_doubt(channel: &mut Channel<Self>);

    /// Called before the run goes on after a fault; the answer, if there is one, is that of
    /// [`Reader::recover`].
    fn resume(_channel: &mut Channel<Self>) -> Option<bool> {
        None
    }

    /// Goes on after the block that has failed; returns what is in doubt there. None: nothing is,
    /// and all is settled.
    fn go_on(channel: &mut Channel<Self>, failed: &FailedBlock<Self::Index>) -> Option<Doubt>;

    /// A block has failed, and what waited for its end is given up.
    fn give_up(_channel: &mut Channel<Self>, _failed: &FailedBlock<Self::Index>) {}

    /// What else is lost after a block that leaves this in doubt.
    fn doubted(_channel: &mut Channel<Self>, _doubt: Doubt) {}

    /// A motion is about to be emitted.
    fn moving(channel: &mut Channel<Self>);

    /// What F counts in a block that moves linear and rotary axes together.
    fn mixed_feed(channel: &Channel<Self>) -> UsualFeed;

    /// How cutter compensation goes around corners; none: as is usual.
    fn comp_style(_channel: &Channel<Self>) -> Option<CompStyle> {
        None
    }

    /// Text of the files that was not run.
    fn not_run(channel: &Channel<Self>) -> Vec<NotRun>;

    /// The main file is a subprogram.
    fn is_subprogram(_channel: &Channel<Self>) -> bool {
        false
    }
}

/// A language whose blocks are lines.
pub(crate) trait LineLanguage: Language {
    /// Executes a line.
    fn run_line(
        channel: &mut Channel<Self>,
        loaded: &Arc<LoadedProgram<Self::Index>>,
        line: &str,
        at: Mark,
        block: &mut Self::Block,
    ) -> Result<(), Fault>;

    /// The text of the program or subprogram that runs is at its end.
    fn end_of_text(
        channel: &mut Channel<Self>,
        loaded: &Arc<LoadedProgram<Self::Index>>,
        at: Mark,
    ) -> Result<(), Box<Diagnostic>>;
}

/// A program being executed. Commands leave one by one; what is kept is the text, the structure of its files,
/// the variables and the modal state, never the executed blocks.
#[derive(Debug)]
pub(crate) struct Channel<L: Language> {
    pub(crate) settings: Settings,
    pub(crate) folders: Vec<PathBuf>,
    pub(crate) main: Arc<LoadedProgram<L::Index>>,
    pub(crate) files: BTreeMap<PathBuf, Arc<LoadedProgram<L::Index>>>,
    pub(crate) stack: Vec<StackLevel<L>>,
    /// Words of the block, boxed, because it is taken out for every block.
    pub(crate) block: Option<Box<L::Block>>,
    pub(crate) queue: VecDeque<(Command, L::Mark)>,
    pub(crate) location: Location,
    pub(crate) done: bool,
    /// What ended the run; reported after the commands before it.
    pub(crate) failure: Option<Box<Diagnostic>>,
    /// What is wrong with the structure of the main file.
    structure: Vec<Diagnostic>,
    pub(crate) recovery: Recovery<L::Index>,
    pub(crate) coverage: Coverage,
    pub(crate) passes: Passes,
    pub(crate) probing: probing::Probing,
    /// Blocks so far.
    blocks: u64,
    pub(crate) variables: L::Variables,
    pub(crate) modal: L::Modal,
    pub(crate) technology: Technology,
    pub(crate) position: Position,
    /// Words of the control file whose reason has been reported, by their place in its table.
    pub(crate) told_words: BTreeSet<usize>,
    /// Calls of subprograms that are not there and were left out.
    pub(crate) missing: Vec<NotRun>,
    /// What commands so far say of how the parameters of the control count.
    pub(crate) told: parameters::CountingState,
    /// What this language keeps and no other does.
    pub(crate) own: L,
}

impl<L: Language> Channel<L> {
    /// `folder`: the folder of the main program, if it is a file. `main`: the lines of the main
    /// program, and the data of its level.
    pub(crate) fn new(
        source: Source,
        folder: Option<PathBuf>,
        settings: &Settings,
        own: L,
        main: impl FnOnce(&L::Index) -> (ProgramSection, L::Level),
        variables: L::Variables,
        modal: L::Modal,
    ) -> Self {
        let mut structure = Vec::new();
        let index = own.index(&source, true, &mut structure);
        let (section, level) = main(&index);
        let location = Location { file: Arc::clone(&source.name), line: 0, column: 1, length: 0, depth: 0 };
        let loaded = Arc::new(LoadedProgram { source, index, file: 0 });
        let level = StackLevel {
            loaded: Arc::clone(&loaded),
            section,
            cursor: section.start,
            first: section.start,
            passes_left: 0,
            own: level,
        };
        Self {
            folders: folder.into_iter().chain(settings.subprogram_folders.iter().cloned()).collect(),
            main: loaded,
            files: BTreeMap::new(),
            stack: vec![level],
            block: None,
            queue: VecDeque::new(),
            location,
            done: false,
            failure: None,
            structure,
            recovery: Recovery::default(),
            coverage: Coverage::default(),
            passes: Passes::default(),
            probing: probing::Probing::new(),
            blocks: 0,
            variables,
            modal,
            technology: Technology::default(),
            position: Position::new(),
            told_words: BTreeSet::new(),
            missing: Vec::new(),
            told: parameters::CountingState::default(),
            own,
            settings: settings.clone(),
        }
    }

    /// Hands a command out with the place of the block.
    #[inline]
    pub(crate) fn emit(&mut self, op: Op) {
        self.told.look(&op);
        self.queue.push_back((Command { location: self.location.clone(), op }, L::Mark::default()));
    }

    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.emit(Op::Note(Note::new(text)));
    }

    /// Emits a note on what is assumed where controls or their set-ups differ.
    pub(crate) fn assume(&mut self, text: impl AsRef<str>) {
        self.emit(Op::Note(Note::assuming(text)));
    }

    /// A block with `/` is run.
    pub(crate) fn run_with_slash(&mut self) {
        if !self.settings.skip_stated {
            self.assume(
                "a block with `/` is run, as with the block-skip switch off; with the switch on the control skips \
                 it: state the switch as `block_skip` of the program in the scene, or as `blocks.skipped_levels` of a \
                 control file",
            );
        }
    }

    /// Sets the location of the block that is executed now, for its commands and faults.
    pub(crate) fn stands_at(&mut self, file: &Arc<str>, at: Mark, line: &str, span: Span) {
        let (column, length) = column_and_length(line, span);
        let depth = self.depth() as u32;
        self.location.move_to(file, at.line, column, length, depth);
    }

    /// Counts a block and refuses one too many, at the one before.
    fn room_for_block(&mut self) -> Result<(), Box<Diagnostic>> {
        self.blocks += 1;
        let limit = self.settings.limits.max_blocks;
        if self.blocks <= limit {
            return Ok(());
        }
        let Location { file, line, column, length, .. } = self.location.clone();
        Err(Box::new(Diagnostic {
            code: codes::LOOP_LIMIT,
            message: format!("the program has run {limit} blocks, which is the limit, and has not ended"),
            source_line: self.line_of(&file, line).unwrap_or_default().into(),
            file,
            line,
            column,
            length,
            about: None,
            help: Some(
                "end the loop, split the program, or raise the limit (blocks under [run_limits] of a scene)".into(),
            ),
        }))
    }

    /// The files that were read so far, the main program first.
    pub(crate) fn loaded(&self) -> impl Iterator<Item = &Arc<LoadedProgram<L::Index>>> {
        std::iter::once(&self.main).chain(self.files.values())
    }

    /// A line of a program that was read, for messages.
    pub(crate) fn line_of(&self, file: &str, line: u32) -> Option<String> {
        let program = self.loaded().find(|program| &*program.source.name == file)?;
        crate::compensation::line_of(&program.source, line)
    }
}

impl<L: Language> Reader for Channel<L> {
    fn next_command(&mut self) -> Option<Result<Command, Box<Diagnostic>>> {
        loop {
            if let Some(command) = L::hand_out(self) {
                return Some(Ok(command));
            }
            if let Some(failure) = self.failure.take() {
                return Some(Err(failure));
            }
            if self.probing.is_asked() {
                if self.answered() {
                    continue;
                }
                return None;
            }
            if self.done {
                return None;
            }
            if let Err(diagnostic) = self.room_for_block().and_then(|()| L::step(self)) {
                // Commands of the block before the fault stay in the queue and are given out first.
                self.done = true;
                self.failure = Some(diagnostic);
            }
        }
    }

    fn comp_style(&self) -> Option<CompStyle> {
        L::comp_style(self)
    }

    fn source_line(&self, file: &str, line: u32) -> Option<String> {
        self.line_of(file, line)
    }

    fn take_structure_faults(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.structure)
    }

    fn recover(&mut self) -> bool {
        self.resume_after_error()
    }

    fn follows(&self, fault: &Diagnostic) -> bool {
        L::follows(self, fault)
    }

    fn sources(&self) -> Vec<&Source> {
        self.loaded().map(|loaded| &loaded.source).collect()
    }

    fn not_run(&self) -> Vec<NotRun> {
        let mut parts = self.missing.clone();
        parts.extend(L::not_run(self));
        parts
    }

    fn is_subprogram(&self) -> bool {
        L::is_subprogram(self)
    }

    fn waits_for_probe(&self) -> bool {
        self.probing.waits
    }
}
