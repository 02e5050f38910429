//! Going on after a fault, for [`crate::check`].
//!
//! The words that can be read are executed, so that little is in doubt after the block; the rest of
//! the block is.

use std::sync::Arc;

use super::doubt::{Doubt, Faults, Stage};
use super::passes::Passes;
use super::{Channel, Language, LoadedProgram};
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::source::Mark;

/// Blocks are tried with fewer and fewer of their words; no block has more that are at fault.
const MAX_TRIES: u32 = 16;

/// What going on needs to know.
#[derive(Debug)]
pub(crate) struct Recovery<I> {
    pub(crate) faults: Faults,
    pub(crate) failed: Option<FailedBlock<I>>,
}

impl<I> Default for Recovery<I> {
    fn default() -> Self {
        Self { faults: Faults::default(), failed: None }
    }
}

/// The block that has failed last.
#[derive(Debug)]
pub(crate) struct FailedBlock<I> {
    pub(crate) line: String,
    pub(crate) code: &'static str,
    pub(crate) span: Span,
    /// It may follow from a fault before: its block has done nothing that could be relied on.
    pub(crate) follows: bool,
    pub(crate) loaded: Arc<LoadedProgram<I>>,
    pub(crate) at: Mark,
    /// How often it has failed.
    pub(crate) times: u32,
}

/// What was taken out of a block.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TakenOut {
    pub(crate) any: bool,
    /// A word among it would have set a variable.
    pub(crate) values: bool,
}

/// A language whose blocks are lists of words: of a block with a fault the others are executed.
pub(crate) trait Salvage: Language {
    /// Start of the first word that touches a byte of the line.
    fn touching(block: &Self::Block, byte: u32) -> Option<u32>;

    /// Takes out the words that touch a span, and assignments before `executed`, which are done already.
    fn take_out(block: &mut Self::Block, span: Span, executed: u32) -> TakenOut;

    /// Executes the words of a block.
    fn execute(channel: &mut Channel<Self>, block: &Self::Block, line: &str) -> Result<(), Fault>;
}

impl<L: Language> Channel<L> {
    /// Places a fault and keeps what going on needs to know.
    pub(crate) fn failed(
        &mut self,
        loaded: &Arc<LoadedProgram<L::Index>>,
        at: Mark,
        line: &str,
        fault: Fault,
    ) -> Box<Diagnostic> {
        let times = self.recovery.faults.count(loaded.file, at.line);
        let (code, span) = (fault.code, fault.span);
        let diagnostic = L::locate(fault, &loaded.source, at, line);
        self.recovery.failed = Some(FailedBlock {
            line: line.to_owned(),
            code,
            span,
            follows: L::may_follow(self, &diagnostic),
            loaded: Arc::clone(loaded),
            at,
            times,
        });
        Box::new(diagnostic)
    }

    /// Goes on after the block that has failed; false where nothing can follow.
    pub(super) fn resume_after_error(&mut self) -> bool {
        if let Some(answer) = L::resume(self) {
            return answer;
        }
        let Some(failed) = self.recovery.failed.take() else { return !self.done };
        let alarm = matches!(failed.code, codes::NESTING_LIMIT | codes::PROGRAM_ALARM)
            || failed.code == codes::PROBE && self.settings.touches.is_some();
        if self.stack.is_empty() || alarm {
            return false;
        }
        self.done = false;
        L::give_up(self, &failed);
        let doubt = match failed.code {
            codes::SUBPROGRAM => Some(Doubt::ALL),
            codes::LOOP_LIMIT => {
                self.passes = Passes::default();
                if failed.times > 1 {
                    return false;
                }
                Some(Doubt { values: true, ..Doubt::NONE })
            }
            _ => L::go_on(self, &failed),
        };
        if let Some(doubt) = doubt {
            self.recovery.faults.doubt.add(doubt);
            self.position.forget(doubt.axes);
            L::doubted(self, doubt);
        }
        true
    }
}

impl<L: Salvage> Channel<L> {
    /// Executes the words of the block that have no fault; returns what is in doubt after them.
    pub(crate) fn salvage_words(&mut self, failed: &FailedBlock<L::Index>, unread: bool) -> Doubt {
        let mut block = self.block.take().unwrap_or_default();
        // After a fault of grammar nothing is read; words before it are good unless they touch it.
        // The end point of a block with a fault is unknown, even if its axis words can be read.
        let start = L::touching(&block, failed.span.start).unwrap_or(failed.span.start) as usize;
        let lost = if unread { start } else { failed.line.len() };
        let mut doubt = Doubt::of_text(failed.line.get(lost..).unwrap_or(&failed.line));
        doubt.axes |= Doubt::of_text(&failed.line).axes;
        let mut span = if unread { Span::new(lost, failed.line.len()) } else { failed.span };
        let mut executed = if unread { 0 } else { span.start };
        for _ in 0..MAX_TRIES {
            let taken = L::take_out(&mut block, span, executed);
            doubt.values |= taken.values;
            if !unread && !taken.any {
                doubt.add(Doubt::of_text(&failed.line));
                break;
            }
            match L::execute(self, &block, &failed.line) {
                Ok(()) => break,
                Err(fault) if self.recovery.faults.stage == Stage::Read => {
                    span = fault.span;
                    executed = executed.max(span.start);
                }
                Err(_) => {
                    if self.recovery.faults.stage != Stage::Acted {
                        doubt.add(Doubt::of_text(&failed.line));
                    }
                    break;
                }
            }
        }
        self.block = Some(block);
        // A fault of a corner after this block could follow from what the block left out: none is
        // looked for.
        self.queue.iter_mut().for_each(|(_, mark)| *mark = L::Mark::default());
        doubt
    }
}
