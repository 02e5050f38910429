//! Continues after a fault, for [`crate::check`], and classifies the text after the end.

use super::reader::AptReader;
use super::statement::{self, AptStatement};
use super::words::{self, MajorWordClass};
use crate::channel::coverage::{Flow, Layout, LineRole};
use crate::channel::doubt::{Doubt, Stage};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::not_run::NotRun;
use crate::source::Mark;

/// Whether a fault may follow from an earlier one.
pub(super) fn may_follow(channel: &AptReader, fault: &Diagnostic) -> bool {
    let doubt = channel.recovery.faults.doubt;
    if channel.recovery.faults.stage == Stage::Unread {
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

/// Clears the doubt about what later statements have set again.
pub(super) fn settle_doubt(channel: &mut AptReader) {
    let doubt = &mut channel.recovery.faults.doubt;
    if !doubt.any() {
        return;
    }
    if channel.position.work.xyz().is_some() {
        doubt.axes = 0;
    }
    doubt.feed &= channel.technology.feed.is_none();
}

/// What a failed statement leaves in doubt.
pub(super) fn doubt_of(statement: &AptStatement) -> Doubt {
    if statement.assignment {
        return Doubt { values: true, ..Doubt::NONE };
    }
    match statement.major.as_str() {
        "GOTO" | "GODLTA" | "FROM" | "HOME" | "GOHOME" => Doubt { axes: 0b111, ..Doubt::NONE },
        "CIRCLE" | "MOVARC" | "INDIRV" | "INDIRP" | "TLON,GOFWD" => {
            // The point after it is the end of a circle that is lost, and cannot be the end of
            // another.
            Doubt { axes: 0b111, modal: true, ..Doubt::NONE }
        }
        "FEDRAT" | "RAPID" => Doubt { feed: true, ..Doubt::NONE },
        "LOADTL" | "LOAD" | "SELCTL" | "SELECTL" | "SELECT" | "TOOL PATH" => Doubt { tool: true, ..Doubt::NONE },
        "SPINDL" | "COOLNT" | "CUTCOM" | "DELAY" | "INSERT" | "AUXFUN" => Doubt { modal: true, ..Doubt::NONE },
        _ => Doubt { values: false, ..Doubt::ALL },
    }
}

pub(super) fn not_run(channel: &AptReader) -> Vec<NotRun> {
    // Statements can take several lines: each line has the role of its statement.
    let mut roles = vec![LineRole::default()];
    let (mut read, mut at) = (AptStatement::default(), Mark::START);
    while let Some((_, next)) = statement::read(&channel.main.source, at, &mut read) {
        let code = !read.major.is_empty()
            && !matches!(read.major.as_str(), "FINI" | "END" | "PARTNO")
            && words::classify(&read.major) != MajorWordClass::Note;
        let moves = matches!(read.major.as_str(), "GOTO" | "GODLTA" | "GOHOME" | "TLON,GOFWD");
        roles.resize(next.line as usize, LineRole { code, moves, flow: Flow::On });
        at = next;
    }
    let layout = Layout {
        source: &channel.main.source,
        parts: Vec::new(),
        regions: Vec::new(),
        role: &|_, at| roles.get(at.line as usize).copied().unwrap_or_default(),
    };
    channel.coverage.not_run(0, &layout)
}
