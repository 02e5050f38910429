//! Going on behind a fault, for [`crate::check`].
//!
//! The words that can be read are executed, so that little is in doubt behind the block; the rest of the block is.

use std::sync::Arc;

use super::interpreter::{Interpreter, Loaded};
use super::parser::{Block, Word, WordKind};
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
    /// The fault is one of a chamfer or rounding: its blocks themselves were executed.
    corner: bool,
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
    pub(super) fn failed(&mut self, loaded: &Arc<Loaded>, at: Mark, line: &str, fault: Fault) -> Box<Diagnostic> {
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

    /// A chamfer or rounding cannot be put in.
    pub(super) fn corner_failed(&mut self) {
        self.recovery.corner = true;
    }

    /// A fault that may follow from one before.
    pub(super) fn may_follow(&self, fault: &Diagnostic) -> bool {
        let faults = &self.recovery.faults;
        // A subprogram whose head cannot be read.
        let call = faults.stage == Stage::Acting
            && matches!(fault.code, codes::UNKNOWN_WORD | codes::SUBPROGRAM)
            && self.loaded().any(|loaded| loaded.index.unreadable);
        // A variable of the control that holds a position.
        let position = faults.doubt.axes != 0
            && fault.code == codes::UNSUPPORTED_WORD
            && ["$P_EP", "$AA_I"].iter().any(|name| fault.message.contains(name));
        faults.doubt.hides(fault, faults.stage) || call || position
    }

    /// What later blocks have set anew is in doubt no more.
    pub(super) fn settle_doubt(&mut self) {
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
        let letter = |wanted: &dyn Fn(u8) -> bool| {
            let is = |kind: &WordKind| matches!(kind, WordKind::Address { letter, .. } if wanted(*letter));
            self.block.words.iter().any(|word| is(&word.kind))
        };
        doubt.mode &= !(letter(&|l| l == b'G') && letter(&|l| matches!(l, b'X'..=b'Z')));
    }

    /// Goes on behind the block that has failed; false where nothing can follow.
    pub(super) fn recover(&mut self) -> bool {
        self.corner = None;
        self.corner_waits = false;
        if std::mem::take(&mut self.recovery.corner) {
            self.done = self.stack.is_empty();
            return true;
        }
        let Some(failed) = self.recovery.failed.take() else { return !self.done };
        if self.stack.is_empty() || matches!(failed.code, codes::NESTING_LIMIT | codes::PROGRAM_ALARM) {
            return false;
        }
        self.done = false;
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
                self.next_pass_of_for = false;
                if failed.times > 1
                    && let Some(end) = failed.loaded.index.partners.get(&failed.at.offset).filter(|m| **m > failed.at)
                {
                    let end = *end;
                    self.continue_after(&failed.loaded, end);
                }
                let defines = failed.line.to_ascii_uppercase().contains("DEF") || failed.line.contains('=');
                // Where it would have gone is not known if the text cannot be read.
                if stage == Stage::Unread { Doubt::ALL } else { Doubt { values: defines, ..Doubt::NONE } }
            }
            (_, Stage::Unread) => self.salvage_words(&failed, true),
            (_, Stage::Read) => self.salvage_words(&failed, false),
            // A word that may be the name of a subprogram.
            (codes::UNKNOWN_WORD, _) => Doubt { values: false, ..Doubt::ALL },
            _ if failed.follows => Doubt::of_text(&failed.line),
            (code, _) => Doubt::of_motion(code, &failed.line),
        };
        self.recovery.faults.doubt.add(doubt);
        self.position.forget(doubt.axes);
        if doubt.axes != 0 {
            self.tangent = None;
        }
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
        let mut executed = if unread { 0 } else { span.start };
        for _ in 0..16 {
            let before = block.words.len();
            let lost = block.words.iter().filter(|w| w.span.end > span.start && w.span.start < span.end);
            doubt.values |= lost.into_iter().any(|word| assigns(&word.kind));
            // What was assigned before the fault is not assigned twice.
            block.words.retain(|word| {
                let good = word.span.end <= span.start || word.span.start >= span.end;
                good && !(word.span.start < executed && assigns(&word.kind))
            });
            if !unread && before == block.words.len() {
                doubt.add(Doubt::of_text(&failed.line));
                break;
            }
            match self.execute(&block, &failed.line) {
                Ok(()) => break,
                Err(fault) if self.recovery.faults.stage == Stage::Read => {
                    span = fault.span;
                    executed = executed.max(span.start);
                }
                Err(_) => {
                    doubt.add(Doubt::of_text(&failed.line));
                    break;
                }
            }
        }
        self.block = block;
        doubt
    }
}

fn assigns(kind: &WordKind) -> bool {
    matches!(kind, WordKind::Assign { .. } | WordKind::Address { letter: b'R', .. })
}

/// The line begins with a word that steers the flow or defines.
fn is_flow(line: &str) -> bool {
    const WORDS: [&str; 16] = [
        "IF", "ELSE", "ENDIF", "FOR", "ENDFOR", "WHILE", "ENDWHILE", "REPEAT", "REPEATB", "UNTIL", "LOOP", "ENDLOOP",
        "CASE", "DEF", "PROC", "RET",
    ];
    let upper = line.to_ascii_uppercase();
    let mut words = upper.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty());
    let first = words.find(|word| {
        // Block numbers and labels stand in front.
        !(word.strip_prefix('N').is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
            || upper.contains(&format!("{word}:")))
    });
    first.is_some_and(|word| WORDS.contains(&word) || word.starts_with("GOTO"))
}
