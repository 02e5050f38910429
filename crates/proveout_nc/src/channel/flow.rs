//! Lines, jumps and calls: which block comes next.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Channel, Language, LineLanguage};
use crate::Op;
use crate::codes;
use crate::diagnostic::{Diagnostic, Diagnostics, Fault, Span};
use crate::source::{Mark, Source};

/// A program file with its structure.
#[derive(Debug)]
pub(crate) struct LoadedProgram<I> {
    pub(crate) source: Source,
    pub(crate) index: I,
    /// Its number among the files of the run.
    pub(crate) file: usize,
}

/// Lines of one program or subprogram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ProgramSection {
    pub(crate) start: Mark,
    /// Byte after the last line.
    pub(crate) end: usize,
}

/// One level of the call stack.
#[derive(Debug)]
pub(crate) struct StackLevel<L: Language> {
    pub(crate) loaded: Arc<LoadedProgram<L::Index>>,
    pub(crate) section: ProgramSection,
    pub(crate) cursor: Mark,
    /// First line, for further passes.
    pub(crate) first: Mark,
    pub(crate) passes_left: u32,
    pub(crate) own: L::Level,
}

impl<L: LineLanguage> Channel<L> {
    /// Executes one line.
    pub(crate) fn step_line(&mut self) -> Result<(), Box<Diagnostic>> {
        let Some(level) = self.stack.last_mut() else {
            self.done = true;
            return Ok(());
        };
        let (at, end) = (level.cursor, level.section.end);
        let loaded = Arc::clone(&level.loaded);
        let line = loaded.source.line(at).filter(|_| at.offset < end);
        let Some((line, next)) = line else {
            return L::end_of_text(self, &loaded, at);
        };
        level.cursor = next;
        self.coverage.mark(loaded.file, at.line, next.line);
        let mut block = self.block.take().unwrap_or_default();
        let result = L::run_line(self, &loaded, line, at, &mut block);
        self.block = Some(block);
        match result {
            Ok(()) => {
                L::settle_doubt(self);
                Ok(())
            }
            Err(fault) => Err(self.failed(&loaded, at, line, fault)),
        }
    }
}

impl<L: Language> Channel<L> {
    /// Call level: 0 in the main program.
    pub(crate) fn depth(&self) -> usize {
        self.stack.len().saturating_sub(1)
    }

    pub(crate) fn set_cursor(&mut self, to: Mark) {
        if let Some(level) = self.stack.last_mut() {
            level.cursor = to;
        }
    }

    /// Continues after a line.
    pub(crate) fn continue_after(&mut self, loaded: &LoadedProgram<L::Index>, line: Mark) {
        let next = loaded.source.line(line).map_or(line, |(_, next)| next);
        self.set_cursor(next);
    }

    /// Counts a jump back and refuses one too many.
    pub(crate) fn count_pass(&mut self, span: Span) -> Result<(), Fault> {
        self.passes.count(&self.settings.limits, span)
    }

    /// Jumps from a place to another; a jump back is a pass.
    pub(crate) fn jump_to(&mut self, from: Mark, to: Mark, span: Span) -> Result<(), Fault> {
        if to.offset <= from.offset {
            self.count_pass(span)?;
        }
        self.set_cursor(to);
        Ok(())
    }

    /// Refuses one call too deep. `what` is called: the subject of the message.
    pub(crate) fn room_for_call(&self, what: &str, span: Span) -> Result<(), Fault> {
        let limit = self.settings.limits.max_call_depth;
        if self.stack.len() <= limit as usize {
            return Ok(());
        }
        let message = format!("{what} at depth {}; the limit is {limit}", self.stack.len());
        Err(Fault::new(codes::NESTING_LIMIT, span, message)
            .help("check for a subprogram that calls itself; controls allow 8 to 16 levels"))
    }

    /// Enters a subprogram at its first line.
    pub(crate) fn enter(
        &mut self,
        (loaded, section): (Arc<LoadedProgram<L::Index>>, ProgramSection),
        first: Mark,
        passes: u32,
        own: L::Level,
    ) {
        let passes_left = passes.saturating_sub(1);
        self.stack.push(StackLevel { loaded, section, cursor: first, first, passes_left, own });
    }

    /// Begins the next pass of a subprogram; false when all are done.
    pub(crate) fn next_pass(&mut self) -> bool {
        let Some(level) = self.stack.last_mut().filter(|level| level.passes_left > 0) else { return false };
        level.passes_left -= 1;
        level.cursor = level.first;
        true
    }

    /// The end of the whole program.
    pub(crate) fn end_of_program(&mut self) {
        self.emit(Op::End);
        self.done = true;
        for level in self.stack.drain(..) {
            self.coverage.end(level.loaded.file, level.cursor.line);
        }
    }

    /// The file of the lowest rank, then of the first name, in the first folder that has one: the order of a
    /// folder decides nothing.
    pub(crate) fn file_beside<R: Ord>(&self, rank: impl Fn(&Path) -> Option<R>) -> Option<PathBuf> {
        self.folders.iter().find_map(|folder| {
            let paths = std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
            let found = paths.filter_map(|path| Some((rank(&path)?, path)));
            found.min().map(|(_, path)| path)
        })
    }

    /// A program file that the run reads besides the main one. `kind` and `name` are for messages.
    pub(crate) fn load(
        &mut self,
        path: PathBuf,
        kind: &str,
        name: &str,
        span: Span,
    ) -> Result<Arc<LoadedProgram<L::Index>>, Fault> {
        if let Some(loaded) = self.files.get(&path) {
            return Ok(Arc::clone(loaded));
        }
        let failed = |what: String| {
            Fault::new(codes::SUBPROGRAM, span, format!("the {kind} `{name}` {what}"))
                .help(format!("correct the {kind}"))
        };
        let mut source = Source::read(&path).map_err(|fault| failed(format!("cannot be read: {fault}")))?;
        source.take_out(&self.settings.control.header, &self.settings.control.trailer);
        source.speak_as(&self.settings.control);
        let mut faults = Vec::new();
        let index = self.own.index(&source, false, &mut faults);
        if !faults.is_empty() {
            return Err(failed(format!("is broken: {}", Diagnostics(faults))));
        }
        let loaded = Arc::new(LoadedProgram { source, index, file: self.files.len() + 1 });
        self.files.insert(path, Arc::clone(&loaded));
        Ok(loaded)
    }
}
