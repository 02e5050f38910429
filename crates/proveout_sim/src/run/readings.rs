//! Readings of a program: with the blocks that a `/` begins and without them, with M1 as a stop and without.
//!
//! Switches at the control decide them. A scene states them (`block_skip`, `optional_stop` of a
//! `[[program]]`), or has `"both"` proved: each reading is run of its own, and every gate gets the
//! worse of its judgements. Where a scene states nothing, the reader reports what it has `assumed`.

use std::path::Path;

use proveout_nc::{OptionalStop, Settings};

use crate::{
    prepare::{choice::Choice, error::SimError, prepared::Prepared},
    run::main_loop,
    scene::{ProgramFile, SwitchFile},
    verdict::{
        finding::Finding,
        gates,
        verdict_file::{Gate, State, Verdict},
    },
};

/// All levels of `/`.
const ALL_LEVELS: u16 = 0x3ff;

/// How the switches are set; none where not stated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Blocks with `/` are left out.
    pub skip: Option<bool>,
    /// M1 stops.
    pub stop: Option<bool>,
}

impl Reading {
    /// Sets the switches of a reader.
    pub(crate) fn apply(self, settings: &mut Settings) {
        if let Some(skip) = self.skip {
            (settings.skip_stated, settings.skipped_levels) = (true, if skip { ALL_LEVELS } else { 0 });
        }
        if let Some(stop) = self.stop {
            settings.optional_stop = if stop { OptionalStop::On } else { OptionalStop::Off };
        }
    }

    fn words(self) -> String {
        let skip = self.skip.map(|s| if s { "without the `/` blocks" } else { "with the `/` blocks" });
        let stop = self.stop.map(|s| if s { "with M1 as a stop" } else { "without a stop at M1" });
        skip.into_iter().chain(stop).collect::<Vec<_>>().join(" and ")
    }
}

/// The readings that a scene wants of a program, the one of the run first.
pub(crate) fn of(entry: Option<&ProgramFile>) -> Vec<Reading> {
    let set = |switch: Option<SwitchFile>| match switch {
        None => vec![None],
        Some(SwitchFile::On) => vec![Some(true)],
        Some(SwitchFile::Off) => vec![Some(false)],
        Some(SwitchFile::Both) => vec![Some(false), Some(true)],
    };
    let (skips, stops) = (set(entry.and_then(|e| e.block_skip)), set(entry.and_then(|e| e.optional_stop)));
    skips.iter().flat_map(|skip| stops.iter().map(|stop| Reading { skip: *skip, stop: *stop })).collect()
}

/// The calls of the other readings than the one of the run.
pub(crate) fn others(entry: Option<&ProgramFile>, choice: &Choice) -> Vec<Choice> {
    // A run that ends early judges nothing to its end.
    if choice.reading.is_some() || choice.stop_at.is_some() {
        return Vec::new();
    }
    let others = of(entry).into_iter().skip(1);
    others.map(|reading| Choice { reading: Some(reading), free_axes: 0, ..choice.clone() }).collect()
}

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

fn worse(gate: &mut Gate, other: &Gate, words: &str) {
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

/// Takes the judgements of the other readings into that of the run: the worse one of every gate, and findings that are new.
pub(crate) fn fold(verdict: &mut Verdict, proved: usize, others: Vec<(String, Verdict)>) {
    if proved == 0 {
        return;
    }
    if let Some(program) = verdict.gates.iter_mut().find(|g| g.name == "program" && g.state == State::Pass) {
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
    verdict.verdict = gates::overall(&verdict.gates);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(more: &str) -> ProgramFile {
        toml::from_str(&format!("name = \"p\"\nfile = \"p.nc\"\n{more}")).unwrap_or_else(|e| panic!("{more}: {e}"))
    }

    #[test]
    fn both_of_a_switch_is_each_of_its_readings() {
        let count = |more: &str| of(Some(&program(more))).len();
        assert_eq!((of(None), count("")), (vec![Reading::default()], 1));
        for (more, readings) in [
            ("block_skip = \"on\"\n", 1),
            ("block_skip = \"both\"\n", 2),
            ("optional_stop = \"both\"\n", 2),
            ("block_skip = \"both\"\noptional_stop = \"both\"\n", 4),
            ("block_skip = \"both\"\noptional_stop = \"off\"\n", 2),
        ] {
            assert_eq!(count(more), readings, "{more}");
            let choices = others(Some(&program(more)), &Choice::default());
            assert_eq!(choices.len(), readings - 1, "{more}");
            assert!(choices.iter().all(|c| others(Some(&program(more)), c).is_empty()), "a reading has no others");
        }
        assert!(toml::from_str::<ProgramFile>("name = \"p\"\nblock_skip = \"maybe\"\n").is_err());
    }

    #[test]
    fn the_worse_judgement_of_a_gate_stands_with_its_reading() {
        use State::{Fail, NotAsked, Pass, Unchecked};
        let gate = |state, reason: &str| Gate { name: "process".into(), state, reason: reason.into() };
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
