//! Going on behind a fault, for [`crate::check`].
//!
//! A block of path words is executed with the words that could be read; everything else that a block with a fault would have
//! set is in doubt.

use std::sync::Arc;

use super::interpreter::{Interpreter, Loaded};
use super::text;
use super::words::Statement;
use crate::channel::doubt::{Doubt, Faults, Stage};
use crate::channel::passes::Passes;
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::source::Mark;

/// What going on needs to know.
#[derive(Debug, Default)]
pub(crate) struct Recovery {
    pub(crate) faults: Faults,
    /// The fault is one of an earlier block, of this line, that waited for its end.
    pub(crate) earlier: Option<u32>,
    failed: Option<Failed>,
    /// Motions since the position is known again, and where the last one went.
    since: u32,
    last: crate::AxisValues,
    /// The element that waited for its corner went out with the fault.
    element_out: bool,
}

/// Motions that a corner looks back: the start of the element before it.
const LOOKED_BACK: u32 = 3;

/// The block that has failed last.
#[derive(Debug)]
struct Failed {
    text: String,
    code: &'static str,
    /// It may follow from a fault before: its block has done nothing that could be relied on.
    follows: bool,
    earlier: bool,
    times: u32,
}

impl Interpreter {
    /// Places a fault and keeps what going on needs to know.
    pub(crate) fn failed(&mut self, loaded: &Arc<Loaded>, at: Mark, text: &str, fault: Fault) -> Box<Diagnostic> {
        let earlier = self.recovery.earlier.take();
        let times = self.recovery.faults.count(loaded.file, earlier.unwrap_or(at.line));
        let shown = earlier.and_then(|line| crate::compensation::line_of(&loaded.source, line));
        let (code, text_of_fault) = (fault.code, shown.clone().unwrap_or_else(|| text.to_owned()));
        let diagnostic = match (earlier, shown) {
            (Some(line), Some(shown)) => {
                let start = shown.len() - shown.trim_start().len();
                Fault { span: Span::new(start, shown.trim_end().len()), ..fault }.at(&loaded.source.name, line, &shown)
            }
            _ => text::locate(fault, &loaded.source, at, text),
        };
        // What this fault itself takes out is no reason for it.
        let follows = self.may_follow(&diagnostic);
        self.recovery.element_out |= self.state.held;
        self.recovery.failed = Some(Failed { text: text_of_fault, code, follows, earlier: earlier.is_some(), times });
        Box::new(diagnostic)
    }

    /// The fault that was placed last may follow from one before it.
    pub(crate) fn last_follows(&self, fault: &Diagnostic) -> bool {
        self.recovery.failed.as_ref().map_or_else(|| self.may_follow(fault), |failed| failed.follows)
    }

    /// A fault that may follow from one before. What a call finds missing may stand in a block that is lost.
    pub(crate) fn may_follow(&self, fault: &Diagnostic) -> bool {
        let faults = &self.recovery.faults;
        let call = faults.stage != Stage::Unread && matches!(fault.code, codes::UNKNOWN_WORD | codes::SYNTAX);
        let target = fault.code == codes::JUMP_TARGET && self.loaded().any(|loaded| loaded.unreadable);
        let corner = fault.code == codes::STRUCTURE && self.recovery.element_out;
        faults.doubt.hides(fault, faults.stage) || call && faults.doubt.modal || target || corner
    }

    /// What later blocks have set anew is in doubt no more.
    pub(crate) fn settle_doubt(&mut self) {
        if !self.recovery.faults.doubt.any() && !self.recovery.element_out {
            return;
        }
        let moved = std::mem::replace(&mut self.recovery.last, self.position.work) != self.position.work;
        self.recovery.element_out &= !moved;
        let doubt = &mut self.recovery.faults.doubt;
        let known =
            (0..9).filter(|axis| self.position.work.get(*axis).is_some()).fold(0, |mask, axis| mask | 1 << axis);
        self.recovery.since = if doubt.axes & !known == 0 { self.recovery.since + u32::from(moved) } else { 0 };
        if self.recovery.since > LOOKED_BACK {
            doubt.axes = 0;
        }
        doubt.mode = false;
        doubt.feed &= self.state.feed.is_none();
        doubt.tool &= self.state.tool.is_none();
    }

    /// Goes on behind the block that has failed; false where nothing can follow.
    pub(crate) fn recover(&mut self) -> bool {
        let Some(failed) = self.recovery.failed.take() else { return !self.done };
        if self.stack.is_empty() || matches!(failed.code, codes::NESTING_LIMIT | codes::PROGRAM_ALARM) {
            return false;
        }
        self.done = false;
        let unread = self.recovery.faults.stage == Stage::Unread || failed.code == codes::JUMP_TARGET;
        if !unread || failed.earlier || failed.text.is_empty() {
            // Nothing waits for its end any more.
            (self.state.corner, self.state.approach, self.state.departing) = (None, None, None);
            self.state.held = false;
            self.state.pending_cycle = None;
        }
        let doubt = match (failed.code, self.recovery.faults.stage) {
            (codes::NO_END, _) => Doubt::NONE,
            (codes::SUBPROGRAM, _) => Doubt::ALL,
            (codes::LOOP_LIMIT, _) => {
                self.passes = Passes::default();
                if failed.times > 1 {
                    return false;
                }
                Doubt { values: true, ..Doubt::NONE }
            }
            (codes::JUMP_TARGET, _) => Doubt::NONE,
            (codes::STRUCTURE, _) if failed.text.is_empty() => {
                // A label whose text ends with the file: as if LBL 0 stood there.
                self.label_end();
                Doubt::NONE
            }
            (_, Stage::Unread) => self.salvage_path(&failed.text),
            _ if failed.earlier => Doubt { modal: true, ..Doubt::NONE },
            _ if failed.follows => Self::doubt_of(&failed.text),
            (code, _) => match Doubt::of_motion(code, &failed.text) {
                doubt if !doubt.modal && !doubt.values => doubt,
                _ => Self::doubt_of(&failed.text),
            },
        };
        self.recovery.since = 0;
        self.recovery.faults.doubt.add(doubt);
        self.position.forget(doubt.axes);
        self.recovery.last = self.position.work;
        if doubt.axes != 0 || doubt.modal {
            self.state.tangent = None;
        }
        true
    }

    /// What a block that is not executed leaves in doubt.
    fn doubt_of(text: &str) -> Doubt {
        let upper = text.to_ascii_uppercase();
        let words = upper.trim_start_matches(|c: char| c.is_ascii_digit() || c.is_whitespace() || c == '/');
        let begins = |list: &[&str]| list.iter().any(|word| words.starts_with(word));
        let values = begins(&["Q", "FN 0", "FN0", "FN 1:", "FN 2", "DECLARE"])
            || words.starts_with('D') && !words.starts_with("DEP");
        if values {
            return Doubt { values: true, ..Doubt::NONE };
        }
        if begins(&["IF", "GOTO", "LBL", "CALL", "SEL", "CYCL CALL"]) || words.contains("M99") || words.contains("M89")
        {
            return Doubt { values: !begins(&["CYCL CALL"]), ..Doubt::ALL };
        }
        if begins(&["CYCL DEF", "PATTERN", "FUNCTION", "PLANE", "TRANS"]) {
            return Doubt { modal: true, axes: 0x1ff, ..Doubt::NONE };
        }
        Doubt { values: words.contains('='), ..Doubt::of_text(words) }
    }

    /// Executes the words of a path that could be read; gives what is in doubt behind it.
    fn salvage_path(&mut self, text: &str) -> Doubt {
        let mut block = self.block.take().unwrap_or_default();
        let doubt = Self::doubt_of(text);
        if let Statement::Path(path) = block.statement {
            block.statement = Statement::Empty;
            // Its faults belong to the fault that was told.
            let _ = self.path(path, &block.words, block.span);
            (self.state.corner, self.state.approach, self.state.departing) = (None, None, None);
            self.state.held = false;
        }
        self.block = Some(block);
        doubt
    }
}
