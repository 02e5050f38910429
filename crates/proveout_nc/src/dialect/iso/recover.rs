//! Going on behind a fault, for [`crate::check`].
//!
//! The words that can be read are executed, so that little is in doubt behind the block; the rest of the block is.

use std::sync::Arc;

use super::interpreter::{Interpreter, Loaded};
use super::parser::{Block, Word};
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::dialect::doubt::{Doubt, Faults, Stage};
use crate::dialect::passes::Passes;
use crate::source::Mark;

/// What going on needs to know.
#[derive(Debug, Default)]
pub(crate) struct Recovery {
    pub(crate) faults: Faults,
    failed: Option<Failed>,
}

/// The block that has failed last.
#[derive(Debug)]
struct Failed {
    line: String,
    code: &'static str,
    span: Span,
    /// It may follow from a fault before: its block has done nothing that could be relied on.
    follows: bool,
    loaded: Arc<Loaded>,
    at: Mark,
    times: u32,
}

impl Interpreter {
    /// Places a fault and keeps what going on needs to know.
    pub(crate) fn failed(&mut self, loaded: &Arc<Loaded>, at: Mark, line: &str, fault: Fault) -> Box<Diagnostic> {
        let times = self.recovery.faults.count(loaded.file, at.line);
        let (code, span) = (fault.code, fault.span);
        let diagnostic = fault.at(&loaded.source.name, at.line, line);
        self.recovery.failed = Some(Failed {
            line: line.to_owned(),
            code,
            span,
            follows: self.may_follow(&diagnostic),
            loaded: Arc::clone(loaded),
            at,
            times,
        });
        Box::new(diagnostic)
    }

    /// A fault that may follow from one before. A word that nobody takes may belong to a modal word that is lost.
    pub(crate) fn may_follow(&self, fault: &Diagnostic) -> bool {
        let faults = &self.recovery.faults;
        let left_over = faults.stage == Stage::Acted && fault.code == codes::UNKNOWN_WORD;
        // A head, label or closing word that cannot be read.
        let target = faults.stage != Stage::Unread
            && matches!(fault.code, codes::STRUCTURE | codes::SUBPROGRAM | codes::JUMP_TARGET | codes::NO_END)
            && self.loaded().any(|loaded| loaded.index.unreadable);
        faults.doubt.hides(fault, faults.stage) || left_over && faults.doubt.mode || target
    }

    /// What later blocks have set anew is in doubt no more.
    pub(crate) fn settle_doubt(&mut self) {
        if !self.recovery.faults.doubt.any() {
            return;
        }
        let doubt = &mut self.recovery.faults.doubt;
        for axis in 0..9 {
            if self.position.work.get(axis).is_some() {
                doubt.axes &= !(1 << axis);
            }
        }
        doubt.feed &= self.technology.feed.is_none();
        doubt.tool &= self.technology.selected.is_none();
        doubt.mode &= !(self.moved_in_block && self.block.words.iter().any(|word| word.letter == b'G'));
    }

    /// Goes on behind the block that has failed; false where nothing can follow.
    pub(crate) fn recover(&mut self) -> bool {
        let Some(failed) = self.recovery.failed.take() else { return !self.done };
        if self.stack.is_empty() || matches!(failed.code, codes::NESTING_LIMIT | codes::PROGRAM_ALARM) {
            return false;
        }
        self.done = false;
        if failed.code == codes::NO_END {
            // The text goes on as if the head were not there.
            self.join_next_part(&failed);
            return true;
        }
        let doubt = match (failed.code, self.recovery.faults.stage) {
            (codes::SUBPROGRAM, _) => Doubt::ALL,
            (codes::LOOP_LIMIT, _) => {
                self.passes = Passes::default();
                if failed.times > 1 {
                    return false;
                }
                Doubt { values: true, ..Doubt::NONE }
            }
            // Jumps and loops: the flow goes on with the next block.
            (_, stage) if is_flow(&failed.line) => {
                if failed.times > 1
                    && let Some(partner) = failed.loaded.index.partners.get(&failed.at.offset)
                {
                    let end = partner.end;
                    self.continue_after(&failed.loaded, end);
                }
                // Where it would have gone is not known if the text cannot be read.
                let assigns = Doubt { values: failed.line.contains('='), ..Doubt::NONE };
                if stage == Stage::Unread { Doubt::ALL } else { assigns }
            }
            (_, Stage::Unread) => self.salvage_words(&failed, true),
            (_, Stage::Read) => self.salvage_words(&failed, false),
            (_, Stage::Acting) if failed.follows => Doubt::of_text(&failed.line),
            (code, Stage::Acting) => Doubt::of_motion(code, &failed.line),
            (_, Stage::Acted) => Doubt::NONE,
        };
        let mut doubt = doubt;
        if doubt.axes != 0 {
            self.held = crate::AxisValues::NONE;
            // The next spline would take up the direction of this one.
            doubt.modal |= self.spline_end.take().is_some();
        }
        self.recovery.faults.doubt.add(doubt);
        self.position.forget(doubt.axes);
        true
    }

    /// Executes the words of the block that are no fault; gives what is in doubt behind them.
    fn salvage_words(&mut self, failed: &Failed, unread: bool) -> Doubt {
        let mut block: Block = std::mem::take(&mut self.block);
        // Behind a fault of grammar nothing is read; before it words are good unless they touch it. Where a block with a fault
        // would have gone is not known, even if its axis words can be read.
        let touches = |word: &&Word| word.span.end >= failed.span.start && word.span.start <= failed.span.start;
        let lost = block.words.iter().find(touches).map_or(failed.span.start, |word| word.span.start) as usize;
        let lost = if unread { lost } else { failed.line.len() };
        let mut doubt = Doubt::of_text(failed.line.get(lost..).unwrap_or(&failed.line));
        doubt.axes |= Doubt::of_text(&failed.line).axes;
        let mut span = if unread { Span::new(lost, failed.line.len()) } else { failed.span };
        for _ in 0..16 {
            let words = block.words.len();
            block.words.retain(|word| word.span.end <= span.start || word.span.start >= span.end);
            let assignments = block.assignments.len();
            block.assignments.retain(|a| a.span.end <= span.start || a.span.start >= span.end);
            if assignments != block.assignments.len() {
                doubt.values = true;
            }
            if !unread && words == block.words.len() && assignments == block.assignments.len() {
                doubt.add(Doubt::of_text(&failed.line));
                break;
            }
            match self.execute(&block, &failed.line) {
                Ok(()) => break,
                Err(fault) if self.recovery.faults.stage == Stage::Read => span = fault.span,
                Err(_) => {
                    if self.recovery.faults.stage != Stage::Acted {
                        doubt.add(Doubt::of_text(&failed.line));
                    }
                    break;
                }
            }
        }
        self.block = block;
        doubt
    }

    /// The section that ran into a head goes on to the end of the part behind it.
    fn join_next_part(&mut self, failed: &Failed) {
        let Some(part) = failed.loaded.index.parts.iter().find(|p| p.lines[0] == failed.at.line) else { return };
        let mut end = failed.at;
        while let Some((_, next)) = failed.loaded.source.line(end).filter(|_| end.line < part.lines[1]) {
            end = next;
        }
        if let Some(level) = self.stack.last_mut() {
            level.section.end = end.offset;
        }
    }
}

/// The line begins with a word that steers the flow.
fn is_flow(line: &str) -> bool {
    let line = line.trim_start_matches(|c: char| c == '/' || c.is_whitespace()).to_ascii_uppercase();
    let line = line.strip_prefix('N').map_or(line.as_str(), |rest| {
        rest.trim_start().trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').trim_start()
    });
    ["IF", "GOTO", "WHILE", "DO", "END", "O"].iter().any(|word| line.starts_with(word))
}
