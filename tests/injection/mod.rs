//! Faults put into small scenes on purpose, and the gates that must not pass them.
//!
//! What must hold, for every case of [`families`] and at any size of the cells:
//!
//! - no gate that is responsible says `pass` where there is a fault;
//! - with cells of a fifth of the fault or finer it says `fail` (a refusal of the scene is no verdict, so
//!   that is allowed only for coarser cells);
//! - a clean twin never says `fail`, and at least 95 percent of the gates of clean twins are decided at the
//!   default cell.
//!
//! `cargo test -p proveout_tests --test prove_outs injection::` runs a hundredth of the cases, 48 of them;
//! all of them run with `PROVEOUT_INJECTIONS=4800 cargo test -p proveout_tests --test prove_outs injection::
//! -- --nocapture`. `PROVEOUT_INJECTION=N` runs one case alone and prints what its gates say.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a failed test says why; the table is for people")]

mod families;
mod random;
mod shop;
mod solids;

use std::{
    collections::BTreeMap,
    env,
    path::Path,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use proveout_sim::verdict::State;

use families::{FAMILIES, case};
use random::Random;
use shop::{Answer, Case};

/// Cases of an ordinary test run: three of every family.
const CASES: usize = 3 * FAMILIES;
/// The cell that `proveout new` takes for a part of this size, mm.
const DEFAULT_CELL_MM: f64 = 0.4;
/// Cells between these are tried, mm.
const CELLS_MM: [f64; 2] = [0.1, 10.0];
/// A fault of so many cells must be found.
const FOUND_AT: f64 = 5.0;
/// Stack of a thread that runs cases: the dev profile keeps large frames.
const STACK_BYTES: usize = 32 << 20;
/// Gates of clean twins that must be decided at the default cell.
const DECIDED: f64 = 0.95;
/// Gates that a clean twin is asked for, in addition to those of its family.
const ALWAYS: [&str; 3] = ["process", "collision", "limits"];

fn cell_of(number: usize) -> f64 {
    Random::new(number as u64 ^ 0xce11).log(CELLS_MM[0], CELLS_MM[1])
}

/// What was counted over the cases of a family.
#[derive(Clone, Debug, Default)]
struct Count {
    faults: usize,
    failed: usize,
    unchecked: usize,
    refused: usize,
    clean: usize,
    gates: usize,
    decided: usize,
    wrong: Vec<String>,
}

impl Count {
    fn add(mut self, other: Self) -> Self {
        self.faults += other.faults;
        self.failed += other.failed;
        self.unchecked += other.unchecked;
        self.refused += other.refused;
        self.clean += other.clean;
        self.gates += other.gates;
        self.decided += other.decided;
        self.wrong.extend(other.wrong);
        self
    }
}

fn with_fault(number: usize, folder: &Path) -> (Case, Count) {
    let case = case(number, true);
    let cell = cell_of(number);
    let answer = shop::run(&case, cell, folder);
    let mut count = Count { faults: 1, ..Count::default() };
    let seen_at = format!("case {number}, {}: {:.4} mm at cells of {cell:.4}", case.family, case.size_mm);
    let must_fail = cell * FOUND_AT <= case.size_mm;
    for name in case.gates {
        match answer.gate(name) {
            Some((State::Fail, _)) => count.failed += 1,
            Some((State::Pass, reason)) => count.wrong.push(format!("{seen_at}: `{name}` passes: {reason}")),
            Some((_, reason)) if must_fail => {
                count.wrong.push(format!("{seen_at}: `{name}` must fail and is unchecked: {reason}"));
            }
            Some(_) => count.unchecked += 1,
            None => {
                count.refused += 1;
                if let Answer::Refused(why) = &answer
                    && must_fail
                {
                    count.wrong.push(format!("{seen_at}: refused: {why}"));
                }
            }
        }
    }
    (case, count)
}

fn without_fault(number: usize, folder: &Path) -> Count {
    let case = case(number, false);
    let at_default = (number / FAMILIES).is_multiple_of(2);
    let cell = if at_default { DEFAULT_CELL_MM } else { cell_of(number) };
    let answer = shop::run(&case, cell, folder);
    let mut count = Count { clean: 1, ..Count::default() };
    let seen_at = format!("case {number}, clean, {}: cells of {cell:.4}", case.family);
    let mut gates: Vec<&str> = ALWAYS.iter().chain(case.gates).copied().collect();
    gates.sort_unstable();
    gates.dedup();
    for name in gates {
        let state = answer.gate(name);
        if let Some((State::Fail, reason)) = state {
            count.wrong.push(format!("{seen_at}: `{name}` fails: {reason}"));
        }
        if at_default {
            count.gates += 1;
            count.decided += usize::from(matches!(state, Some((State::Pass, _))));
        }
    }
    count
}

/// One case alone: its files stay, and every gate is printed.
fn show(number: usize) {
    for fault in [true, false] {
        let case = case(number, fault);
        for cell in [cell_of(number), DEFAULT_CELL_MM, case.size_mm / FOUND_AT] {
            let folder = env::temp_dir().join(format!("proveout-injection-{number}-{fault}-{cell:.4}"));
            println!("{} fault={fault} size={:.4} cell={cell:.4} {}", case.family, case.size_mm, folder.display());
            match shop::run(&case, cell, &folder) {
                Answer::Refused(why) => println!("  refused: {why}"),
                Answer::Verdict(v) => {
                    for gate in v.gates {
                        println!("  {:?} {}: {}", gate.state, gate.gate, gate.reason);
                    }
                    for f in v.findings {
                        println!("  {} line {:?}: {}", f.code, f.line, f.message);
                    }
                }
            }
        }
    }
}

#[test]
fn no_gate_passes_an_injected_fault_and_no_clean_twin_fails() {
    if let Some(number) = env::var("PROVEOUT_INJECTION").ok().and_then(|n| n.parse().ok()) {
        show(number);
        return;
    }
    let cases = env::var("PROVEOUT_INJECTIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(CASES);
    let folder = tempfile::tempdir().unwrap();
    let next = AtomicUsize::new(0);
    let counts = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            let work = || {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= cases {
                        break;
                    }
                    let folder = folder.path().join(number.to_string());
                    let (case, with) = with_fault(number, &folder.join("fault"));
                    let without = without_fault(number, &folder.join("clean"));
                    std::fs::remove_dir_all(&folder).ok();
                    counts.lock().unwrap().push((number, case.family, with.add(without)));
                }
            };
            thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work).unwrap();
        }
    });
    let mut counts = counts.into_inner().unwrap();
    counts.sort_by_key(|(number, ..)| *number);
    let mut families: BTreeMap<&str, Count> = BTreeMap::new();
    for (_, family, count) in counts {
        let sum = families.remove(family).unwrap_or_default();
        families.insert(family, sum.add(count));
    }
    println!(
        "{:<34} {:>6} {:>6} {:>9} {:>7} {:>6} {:>14}",
        "family", "faults", "fail", "unchecked", "refused", "clean", "decided"
    );
    for (family, c) in &families {
        println!(
            "{family:<34} {:>6} {:>6} {:>9} {:>7} {:>6} {:>7}/{:<6}",
            c.faults, c.failed, c.unchecked, c.refused, c.clean, c.decided, c.gates
        );
    }
    let all = families.into_values().fold(Count::default(), Count::add);
    let share = all.decided as f64 / all.gates.max(1) as f64;
    println!("{} wrong; {:.1} percent of the gates of clean twins are decided", all.wrong.len(), 100.0 * share);
    assert!(all.wrong.is_empty(), "{}", all.wrong.join("\n"));
    assert!(share >= DECIDED, "only {:.1} percent of the gates of clean twins are decided", 100.0 * share);
}
