//! Going on behind a fault, for [`crate::check`], and the text behind the end.

use super::reader::AptReader;
use super::statement::{self, Statement};
use super::words::{self, Class};
use crate::channel::coverage::{Flow, Layout, Role};
use crate::channel::doubt::{Doubt, Faults, Stage};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::not_run::NotRun;
use crate::source::Mark;

/// What going on needs to know.
#[derive(Debug, Default)]
pub(crate) struct Recovery {
    pub(crate) faults: Faults,
    /// Major word of the statement that has failed, and whether it is a definition.
    pub(crate) failed: Option<(String, bool)>,
}

impl AptReader {
    /// A fault that may follow from one before.
    pub(crate) fn may_follow(&self, fault: &Diagnostic) -> bool {
        let doubt = self.recovery.faults.doubt;
        if self.recovery.faults.stage == Stage::Unread {
            return false;
        }
        match fault.code {
            codes::POSITION_UNKNOWN | codes::ARC_GEOMETRY | codes::ARC_RADIUS | codes::COMPENSATION => {
                doubt.axes != 0 || doubt.modal
            }
            codes::NO_FEED => doubt.feed,
            codes::CONFLICT | codes::STRUCTURE | codes::MISSING_VALUE => doubt.modal,
            codes::UNKNOWN_VARIABLE | codes::TYPE => doubt.values,
            _ => false,
        }
    }

    /// What later statements have set anew is in doubt no more.
    pub(crate) fn settle_doubt(&mut self) {
        let doubt = &mut self.recovery.faults.doubt;
        if !doubt.any() {
            return;
        }
        if self.position.work.xyz().is_some() {
            doubt.axes = 0;
        }
        doubt.feed &= self.feed.is_none();
    }

    /// Goes on behind the statement that has failed.
    pub(crate) fn recover(&mut self) -> bool {
        let Some((major, assignment)) = self.recovery.failed.take() else { return !self.done };
        self.done = false;
        let doubt = if assignment {
            Doubt { values: true, ..Doubt::NONE }
        } else {
            match major.as_str() {
                "GOTO" | "GODLTA" | "FROM" | "HOME" | "GOHOME" => Doubt { axes: 0b111, ..Doubt::NONE },
                "CIRCLE" | "MOVARC" | "INDIRV" | "INDIRP" | "TLON,GOFWD" => {
                    // The point behind it is the end of a circle that is lost, and cannot be the end of another.
                    Doubt { axes: 0b111, modal: true, ..Doubt::NONE }
                }
                "FEDRAT" | "RAPID" => Doubt { feed: true, ..Doubt::NONE },
                "LOADTL" | "LOAD" | "SELCTL" | "SELECTL" | "SELECT" | "TOOL PATH" => {
                    Doubt { tool: true, ..Doubt::NONE }
                }
                "SPINDL" | "COOLNT" | "CUTCOM" | "DELAY" | "INSERT" | "AUXFUN" => Doubt { modal: true, ..Doubt::NONE },
                _ => Doubt { values: false, ..Doubt::ALL },
            }
        };
        self.circle = None;
        self.forward = None;
        self.recovery.faults.doubt.add(doubt);
        self.position.forget(doubt.axes & 0b111);
        true
    }

    pub(crate) fn leftover(&self) -> Vec<NotRun> {
        // Statements can take several lines: each line has the role of its statement.
        let mut roles = vec![Role::default()];
        let (mut read, mut at) = (Statement::new(), Mark::START);
        while let Some((_, next)) = statement::read(&self.source, at, &mut read) {
            let code = !read.major.is_empty()
                && !matches!(read.major.as_str(), "FINI" | "END" | "PARTNO")
                && words::classify(&read.major) != Class::Note;
            let moves = matches!(read.major.as_str(), "GOTO" | "GODLTA" | "GOHOME" | "TLON,GOFWD");
            roles.resize(next.line as usize, Role { code, moves, flow: Flow::On });
            at = next;
        }
        let layout = Layout {
            source: &self.source,
            parts: Vec::new(),
            regions: Vec::new(),
            role: &|_, at| roles.get(at.line as usize).copied().unwrap_or_default(),
        };
        self.coverage.not_run(0, &layout)
    }
}
