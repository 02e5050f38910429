//! What a fault leaves in doubt on an 840D, and where the run continues after it.

use super::index::Index;
use super::parser::{SiemensBlock, WordKind};
use super::run_state::{Interpreter, Siemens};
use crate::channel::doubt::{Doubt, Stage};
use crate::channel::{FailedBlock, Salvage, TakenOut};
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, FaultSubject, Span};

/// Whether a fault may follow from an earlier one.
pub(super) fn may_follow(channel: &Interpreter, fault: &Diagnostic) -> bool {
    let faults = &channel.recovery.faults;
    // A subprogram whose head cannot be read.
    let call = faults.stage == Stage::Acting
        && matches!(fault.code, codes::UNKNOWN_WORD | codes::SUBPROGRAM)
        && channel.loaded().any(|loaded| loaded.index.unreadable);
    // A variable of the control that holds a position.
    let position = faults.doubt.axes != 0
        && fault.code == codes::UNSUPPORTED_WORD
        && fault.about.as_deref() == Some(&FaultSubject::PositionVariable);
    let contour = channel.own.contour_torn && fault.code == codes::SUBPROGRAM;
    faults.doubt.hides(fault, faults.stage) || call || position || contour
}

/// Clears the doubt about what later blocks have set again.
pub(super) fn settle_doubt(channel: &mut Interpreter) {
    channel.own.two_lines_torn = false;
    channel.own.contour_torn = false;
    let doubt = &mut channel.recovery.faults.doubt;
    if !doubt.any() {
        return;
    }
    doubt.settle(&channel.position.work, channel.technology.feed.is_some(), channel.technology.selected.is_some());
    let letter = |wanted: &dyn Fn(u8) -> bool| {
        let is = |kind: &WordKind| matches!(kind, WordKind::Address { letter, .. } if wanted(*letter));
        channel.block.iter().any(|block| block.words.iter().any(|word| is(&word.kind)))
    };
    doubt.mode &= !(letter(&|l| l == b'G') && letter(&|l| matches!(l, b'X'..=b'Z')));
}

/// Continues after the failed block; returns what is in doubt there.
pub(super) fn go_on(channel: &mut Interpreter, failed: &FailedBlock<Index>) -> Doubt {
    match (failed.code, channel.recovery.faults.stage) {
        // Jumps and loops: the run continues with the next block.
        (_, stage) if is_flow(&failed.line) => {
            channel.own.next_pass_of_for = false;
            if failed.times > 1
                && let Some(end) = failed.loaded.index.partners.get(&failed.at.offset).filter(|m| **m > failed.at)
            {
                channel.continue_after(&failed.loaded, *end);
            }
            let defines = failed.line.to_ascii_uppercase().contains("DEF") || failed.line.contains('=');
            // If the text cannot be read, its jump target is not known.
            if stage == Stage::Unread { Doubt::ALL } else { Doubt { values: defines, ..Doubt::NONE } }
        }
        (_, Stage::Unread) => channel.salvage_words(failed, true),
        (_, Stage::Read) => channel.salvage_words(failed, false),
        // A word that may be the name of a subprogram.
        (codes::UNKNOWN_WORD, _) => Doubt { values: false, ..Doubt::ALL },
        _ if failed.follows => Doubt::of_text(&failed.line),
        (code, _) => Doubt::of_motion(code, &failed.line),
    }
}

impl Salvage for Siemens {
    fn touching(block: &SiemensBlock, byte: u32) -> Option<u32> {
        block.words.iter().find(|word| word.span.end >= byte && word.span.start <= byte).map(|word| word.span.start)
    }

    fn take_out(block: &mut SiemensBlock, span: Span, executed: u32) -> TakenOut {
        let before = block.words.len();
        let mut values = false;
        block.words.retain(|word| {
            let assigns = matches!(word.kind, WordKind::Assign { .. } | WordKind::Address { letter: b'R', .. });
            values |= assigns && word.span.end > span.start && word.span.start < span.end;
            let good = word.span.end <= span.start || word.span.start >= span.end;
            good && !(word.span.start < executed && assigns)
        });
        TakenOut { any: block.words.len() != before, values }
    }

    fn execute(channel: &mut Interpreter, block: &SiemensBlock, line: &str) -> Result<(), Fault> {
        channel.execute(block, line)
    }
}

/// The line begins with a word of control flow or a definition.
fn is_flow(line: &str) -> bool {
    const WORDS: [&str; 16] = [
        "IF", "ELSE", "ENDIF", "FOR", "ENDFOR", "WHILE", "ENDWHILE", "REPEAT", "REPEATB", "UNTIL", "LOOP", "ENDLOOP",
        "CASE", "DEF", "PROC", "RET",
    ];
    let upper = line.to_ascii_uppercase();
    let mut words = upper.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty());
    let first = words.find(|word| {
        // Block numbers and labels come first.
        !(word.strip_prefix('N').is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
            || upper.contains(&format!("{word}:")))
    });
    first.is_some_and(|word| WORDS.contains(&word) || word.starts_with("GOTO"))
}
