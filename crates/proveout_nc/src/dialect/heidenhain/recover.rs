//! What a fault leaves in doubt on a TNC, and where the run continues after it.
//!
//! A block of path words is executed with the words that could be read; everything else that a block with a
//! fault would have set is in doubt.

use super::run_state::{Interpreter, Labels};
use super::words::Statement;
use crate::channel::FailedBlock;
use crate::channel::doubt::{Doubt, Stage};
use crate::codes;
use crate::diagnostic::Diagnostic;

/// How many motions a corner looks back: to the start of the element before it.
const LOOKED_BACK: u32 = 3;

/// Whether a fault may follow from an earlier one. What a call does not find may be in a block that
/// was lost.
pub(super) fn may_follow(channel: &Interpreter, fault: &Diagnostic) -> bool {
    let faults = &channel.recovery.faults;
    let call = faults.stage != Stage::Unread && matches!(fault.code, codes::UNKNOWN_WORD | codes::SYNTAX);
    let target = fault.code == codes::JUMP_TARGET && channel.loaded().any(|loaded| loaded.index.unreadable);
    let corner = fault.code == codes::STRUCTURE && channel.own.element_out;
    faults.doubt.hides(fault, faults.stage) || call && faults.doubt.modal || target || corner
}

/// Clears the doubt about what later blocks have set again.
pub(super) fn settle_doubt(channel: &mut Interpreter) {
    if !channel.recovery.faults.doubt.any() && !channel.own.element_out {
        return;
    }
    let moved = std::mem::replace(&mut channel.own.last, channel.position.work) != channel.position.work;
    channel.own.element_out &= !moved;
    let doubt = &mut channel.recovery.faults.doubt;
    let known = (0..9).filter(|axis| channel.position.work.get(*axis).is_some()).fold(0, |mask, axis| mask | 1 << axis);
    channel.own.since = if doubt.axes & !known == 0 { channel.own.since + u32::from(moved) } else { 0 };
    if channel.own.since > LOOKED_BACK {
        doubt.axes = 0;
    }
    doubt.mode = false;
    doubt.feed &= channel.technology.feed.is_none();
    doubt.tool &= channel.technology.in_spindle.is_none();
}

/// Drops what waits for its end.
pub(super) fn nothing_waits(channel: &mut Interpreter) {
    (channel.modal.corner, channel.modal.approach, channel.modal.departing) = (None, None, None);
    channel.modal.held = false;
}

/// Continues after the failed block; returns what is in doubt there.
pub(super) fn go_on(channel: &mut Interpreter, failed: &FailedBlock<Labels>) -> Doubt {
    match (failed.code, channel.recovery.faults.stage) {
        (codes::NO_END | codes::JUMP_TARGET, _) => Doubt::NONE,
        (codes::STRUCTURE, _) if failed.line.is_empty() => {
            // A label whose text ends with the file: as if LBL 0 followed.
            channel.label_end();
            Doubt::NONE
        }
        (_, Stage::Unread) => salvage_path(channel, &failed.line),
        _ if channel.own.earlier_failed => Doubt { modal: true, ..Doubt::NONE },
        _ if failed.follows => doubt_of(&failed.line),
        (code, _) => match Doubt::of_motion(code, &failed.line) {
            doubt if !doubt.modal && !doubt.values => doubt,
            _ => doubt_of(&failed.line),
        },
    }
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
    if begins(&["IF", "GOTO", "LBL", "CALL", "SEL", "CYCL CALL"]) || words.contains("M99") || words.contains("M89") {
        return Doubt { values: !begins(&["CYCL CALL"]), ..Doubt::ALL };
    }
    if begins(&["CYCL DEF", "PATTERN", "FUNCTION", "PLANE", "TRANS"]) {
        return Doubt { modal: true, axes: 0x1ff, ..Doubt::NONE };
    }
    Doubt { values: words.contains('='), ..Doubt::of_text(words) }
}

/// Executes the words of a path that could be read; returns what is in doubt after it.
fn salvage_path(channel: &mut Interpreter, text: &str) -> Doubt {
    let mut block = channel.block.take().unwrap_or_default();
    if let Statement::Path(path) = block.statement {
        block.statement = Statement::Empty;
        // Its faults belong to the fault already reported.
        let _ = channel.path(path, &block.words, block.span);
        nothing_waits(channel);
    }
    channel.block = Some(block);
    doubt_of(text)
}
