//! What a fault leaves in doubt on an ISO control, and where its run goes on.

use super::index::Index;
use super::parser::IsoBlock;
use super::run_state::{Interpreter, Iso};
use crate::channel::doubt::{Doubt, Stage};
use crate::channel::{FailedBlock, Salvage, TakenOut};
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span};

/// A fault that may follow from one before. A word without a use may belong to a modal word that is
/// lost.
pub(super) fn may_follow(channel: &Interpreter, fault: &Diagnostic) -> bool {
    let faults = &channel.recovery.faults;
    let left_over = faults.stage == Stage::Acted && fault.code == codes::UNKNOWN_WORD;
    // A head, label or closing word that cannot be read.
    let target = faults.stage != Stage::Unread
        && matches!(fault.code, codes::STRUCTURE | codes::SUBPROGRAM | codes::JUMP_TARGET | codes::NO_END)
        && channel.loaded().any(|loaded| loaded.index.unreadable);
    faults.doubt.hides(fault, faults.stage) || left_over && faults.doubt.mode || target
}

/// Ends the doubt about what later blocks have set again.
pub(super) fn settle_doubt(channel: &mut Interpreter) {
    let doubt = &mut channel.recovery.faults.doubt;
    if !doubt.any() {
        return;
    }
    doubt.settle(&channel.position.work, channel.own.feed.is_some(), channel.technology.selected.is_some());
    let named = channel.block.iter().any(|block| block.words.iter().any(|word| word.letter == b'G'));
    doubt.mode &= !(channel.own.moved_in_block && named);
}

/// Goes on after the block that has failed; returns what is in doubt there.
pub(super) fn go_on(channel: &mut Interpreter, failed: &FailedBlock<Index>) -> Option<Doubt> {
    Some(match (failed.code, channel.recovery.faults.stage) {
        (codes::NO_END, _) => {
            // The text goes on as if the head were not there.
            join_next_part(channel, failed);
            return None;
        }
        // Jumps and loops: the flow goes on with the next block.
        (_, stage) if is_flow(&failed.line) => {
            if failed.times > 1
                && let Some(partner) = failed.loaded.index.partners.get(&failed.at.offset)
            {
                channel.continue_after(&failed.loaded, partner.end);
            }
            // Where it would have gone is not known if the text cannot be read.
            let assigns = Doubt { values: failed.line.contains('='), ..Doubt::NONE };
            if stage == Stage::Unread { Doubt::ALL } else { assigns }
        }
        (_, Stage::Unread) => channel.salvage_words(failed, true),
        (_, Stage::Read) => channel.salvage_words(failed, false),
        (_, Stage::Acting) if failed.follows => Doubt::of_text(&failed.line),
        (code, Stage::Acting) => Doubt::of_motion(code, &failed.line),
        (_, Stage::Acted) => Doubt::NONE,
    })
}

impl Salvage for Iso {
    fn touching(block: &IsoBlock, byte: u32) -> Option<u32> {
        block.words.iter().find(|word| word.span.end >= byte && word.span.start <= byte).map(|word| word.span.start)
    }

    fn take_out(block: &mut IsoBlock, span: Span, _executed: u32) -> TakenOut {
        let before = (block.words.len(), block.assignments.len());
        block.words.retain(|word| word.span.end <= span.start || word.span.start >= span.end);
        block.assignments.retain(|a| a.span.end <= span.start || a.span.start >= span.end);
        let after = (block.words.len(), block.assignments.len());
        TakenOut { any: before != after, values: before.1 != after.1 }
    }

    fn execute(channel: &mut Interpreter, block: &IsoBlock, line: &str) -> Result<(), Fault> {
        channel.execute(block, line)
    }
}

/// The section that ran into a head goes on to the end of the part after it.
fn join_next_part(channel: &mut Interpreter, failed: &FailedBlock<Index>) {
    let Some(part) = failed.loaded.index.parts.iter().find(|p| p.lines[0] == failed.at.line) else { return };
    let mut end = failed.at;
    while let Some((_, next)) = failed.loaded.source.line(end).filter(|_| end.line < part.lines[1]) {
        end = next;
    }
    if let Some(level) = channel.stack.last_mut() {
        level.section.end = end.offset;
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
