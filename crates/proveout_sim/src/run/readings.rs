//! Readings of a program: with the blocks that a `/` begins and without them, with M1 as a stop and without.
//!
//! Switches at the control decide them. A scene states them (`block_skip`, `optional_stop` of a
//! `[[program]]`), or has `"both"` proved: each reading is run of its own, and every gate gets the
//! worse of its judgements. Where a scene states nothing, the reader reports what it has `assumed`.

use std::path::Path;

use crate::{
    prepare::{error::SimError, prepared::Prepared},
    run::main_loop,
    verdict::{
        finding::Finding,
        gate::Gate,
        gates,
        verdict_file::{GateVerdict, State, Verdict},
    },
};

/// Runs the other readings of a program whose commands differ; the judgement of each with its words.
///
/// # Errors
/// As [`main_loop::run`], of the first one that cannot be run.
pub(crate) fn run_others(prepared: &Prepared, folder: &Path) -> Result<Vec<(String, Verdict)>, SimError> {
    let mut all = Vec::new();
    for choice in &prepared.other_readings {
        let other = Prepared::read(&prepared.scene.path, choice)?;
        let words = choice.reading.unwrap_or_default().words();
        if same_commands(prepared, &other)? {
            continue;
        }
        all.push((words, main_loop::run(other, &mut [], folder)?.verdict));
    }
    Ok(all)
}

fn same_commands(one: &Prepared, other: &Prepared) -> Result<bool, SimError> {
    let (mut a, mut b) = (one.program()?, other.program()?);
    loop {
        match (a.next(), b.next()) {
            (None, None) => return Ok(true),
            (Some(Ok(x)), Some(Ok(y))) if x == y => {}
            _ => return Ok(false),
        }
    }
}

fn rank(state: State) -> u8 {
    match state {
        State::NotAsked => 0,
        State::Pass => 1,
        State::Unchecked => 2,
        State::Fail => 3,
    }
}

fn worse(gate: &mut GateVerdict, other: &GateVerdict, words: &str) {
    if rank(other.state) > rank(gate.state) {
        let own =
            if gate.state == State::Pass { String::new() } else { format!("; the other reading: {}", gate.reason) };
        (gate.state, gate.reason) = (other.state, format!("{words}: {}{own}", other.reason));
    } else if other.state == gate.state
        && gate.state != State::NotAsked
        && gate.state != State::Pass
        && other.reason != gate.reason
    {
        gate.reason += &format!("; {words}: {}", other.reason);
    }
}

/// Takes the judgements of the other readings into that of the run: the worse one of every gate, and findings
/// that are new.
pub(crate) fn fold(verdict: &mut Verdict, proved: usize, others: Vec<(String, Verdict)>) {
    if proved == 0 {
        return;
    }
    if let Some(program) = verdict.gates.iter_mut().find(|g| g.gate == Gate::Program && g.state == State::Pass) {
        program.reason +=
            &format!("; all {} readings of `/` blocks and M1 that the scene asks for were run", proved + 1);
    }
    for (words, other) in others {
        for (gate, theirs) in verdict.gates.iter_mut().zip(&other.gates) {
            worse(gate, theirs, &words);
        }
        let same = |a: &Finding, b: &Finding| {
            a.code == b.code && a.file == b.file && a.line == b.line && a.message == b.message
        };
        let new: Vec<Finding> =
            other.findings.into_iter().filter(|f| !verdict.findings.iter().any(|own| same(own, f))).collect();
        verdict.findings.extend(new.into_iter().map(|f| Finding { message: format!("{words}: {}", f.message), ..f }));
    }
    verdict.verdict = gates::overall(verdict.gates.iter().map(|g| g.state));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worse_judgement_of_a_gate_stands_with_its_reading() {
        use State::{Fail, NotAsked, Pass, Unchecked};
        let gate = |state, reason: &str| GateVerdict { gate: Gate::Process, state, reason: reason.into() };
        for (own, other, both) in [
            (Pass, Fail, Fail),
            (Fail, Pass, Fail),
            (Pass, Unchecked, Unchecked),
            (Unchecked, Fail, Fail),
            (Pass, Pass, Pass),
            (NotAsked, NotAsked, NotAsked),
        ] {
            let mut worst = gate(own, "own");
            worse(&mut worst, &gate(other, "theirs"), "without the `/` blocks");
            assert_eq!(worst.state, both, "{own:?} {other:?}");
            assert_eq!(
                worst.reason.contains("without the `/` blocks: theirs"),
                rank(other) > rank(own),
                "{}",
                worst.reason
            );
        }
    }
}
