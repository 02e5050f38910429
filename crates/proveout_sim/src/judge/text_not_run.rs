//! Text of a program that its run does not reach: findings, and what the gates leave unchecked.

use proveout_nc::{NotRun, NotRunKind, Weight};

use crate::{
    prepare::prepared::Prepared,
    verdict::{
        finding::{self, Code},
        gate::{Gate, PerGate},
        gates::Coverage,
        log::FindingLog,
    },
};

/// Most stretches of text that are reported by name; further ones are counted.
const MAX_TOLD: usize = 50;

/// Findings for the text that is not run.
pub(crate) fn judge(prepared: &Prepared, log: &mut FindingLog) {
    for part in prepared.survey.not_run.iter().take(MAX_TOLD) {
        let code: &Code = match (part.weight(), &part.kind) {
            (Weight::Lost, _) => &finding::TEXT_LOST,
            (Weight::Unproven, _) => &finding::TEXT_UNPROVEN,
            (Weight::Harmless, NotRunKind::Branch) if part.moves => &finding::TEXT_SKIPPED,
            (Weight::Harmless, _) => &finding::TEXT_NOT_CALLED,
        };
        let mut f = FindingLog::of(code, part.to_string());
        (f.file, f.line) = (Some(part.file.to_string()), Some(part.lines[0]));
        log.push(f);
    }
    // Long dwells, which the commands themselves do not show.
    for remark in prepared.survey.notes.iter().filter(|remark| !remark.among_commands).take(MAX_TOLD) {
        let times = if remark.count > 1 { format!(", {} times", remark.count) } else { String::new() };
        let mut f = FindingLog::of(&finding::LONG_DWELL, format!("{}{times}", remark.text));
        (f.file, f.line) = (Some(remark.file.to_string()), Some(remark.line));
        log.push(f);
    }
    if let Some(more) = prepared.survey.not_run.len().checked_sub(MAX_TOLD).filter(|more| *more > 0) {
        log.push(FindingLog::of(&finding::TEXT_NOT_CALLED, format!("{more} more stretches of text are not run")));
    }
}

/// Gates that judge what was run: they have seen only a part of what the files may make the machine do.
pub(crate) fn leave_out(prepared: &Prepared, gates: &mut PerGate<Coverage>) {
    let parts: Vec<&NotRun> = prepared.survey.not_run.iter().filter(|part| part.weight() > Weight::Harmless).collect();
    let Some(first) = parts.first() else { return };
    let more = if parts.len() > 1 { format!(" (and {} more such stretches)", parts.len() - 1) } else { String::new() };
    // What is lost is a finding that fails the gate.
    if let Some(part) = parts.iter().find(|part| part.weight() == Weight::Unproven) {
        gates[Gate::Program].left_out.push(part.to_string());
    }
    let [from, to] = first.lines;
    for (_, other) in gates.iter_mut().filter(|(gate, _)| *gate != Gate::Program) {
        other
            .left_out
            .push(format!("lines {from} to {to} of {} were not run{more}, see the gate `program`", first.file));
    }
}
