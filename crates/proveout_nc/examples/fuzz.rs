//! Runs changed seed programs through a reader for some time and says what it found:
//! `cargo run -p proveout_nc --release --example fuzz -- --dialect fanuc --seconds 120`.
//!
//! Needs no special toolchain. No input may take more than 64 MiB (peak of the process, from /proc), and none
//! more than ten seconds. The first input that panics, runs on or takes more is written to `fuzz-failure.txt`
//! and ends the run with code 1.

#![allow(dead_code, unreachable_pub, reason = "the file with the mutations is shared with the tests")]

#[path = "../tests/common/mutate.rs"]
mod mutate;

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use mutate::{DIALECTS, Random, mutate, run};

/// Memory one input may take beyond that before it, KiB.
const MAX_KIB: u64 = 64 << 10;
/// Longest run of one input.
const MAX_TIME: Duration = Duration::from_secs(10);

/// Most memory of this process since `reset_peak`, KiB; 0 where the system does not say.
fn peak_kib() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or_default();
    line.split_whitespace().next().and_then(|n| n.parse().ok()).unwrap_or(0)
}

/// The memory in use now is the peak again (proc(5)).
fn reset_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

fn seeds(folder: &str) -> Vec<String> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let mut files = Vec::new();
    for kind in ["fuzz_seeds", "cases", "bad"] {
        let Ok(entries) = std::fs::read_dir(tests.join(kind).join(folder)) else { continue };
        files.extend(entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e != "jsonl")));
    }
    files.sort();
    files.iter().filter_map(|f| std::fs::read(f).ok()).map(|b| String::from_utf8_lossy(&b).into_owned()).collect()
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().collect();
    let value = |name: &str| args.iter().position(|a| a == name).and_then(|at| args.get(at + 1));
    let wanted = value("--dialect").cloned();
    let seconds = value("--seconds").and_then(|s| s.parse().ok()).unwrap_or(60);
    let start = value("--seed").and_then(|s| s.parse().ok()).unwrap_or(1);
    let mut out = std::io::stdout();
    let chosen: Vec<_> = DIALECTS.into_iter().filter(|(name, _)| wanted.as_ref().is_none_or(|w| w == name)).collect();
    if chosen.is_empty() {
        let _ = writeln!(out, "no such dialect; choose one of {:?}", DIALECTS.map(|(name, _)| name));
        return ExitCode::from(2);
    }
    for (folder, dialect) in chosen {
        let seeds = seeds(folder);
        let mut random = Random(start);
        let begin = Instant::now();
        let (mut inputs, mut commands, mut slowest, mut largest) = (0u64, 0u64, Duration::ZERO, 0u64);
        while begin.elapsed() < Duration::from_secs(seconds) {
            let text = mutate(&seeds, &mut random);
            reset_peak();
            let (before, time) = (peak_kib(), Instant::now());
            let result = catch_unwind(AssertUnwindSafe(|| run(&text, dialect)));
            let (took, kib) = (time.elapsed(), peak_kib().saturating_sub(before));
            inputs += 1;
            slowest = slowest.max(took);
            largest = largest.max(kib);
            let fault = match result {
                Err(_) => Some("panicked".to_owned()),
                Ok(_) if took > MAX_TIME => Some(format!("took {took:?}")),
                Ok(_) if kib > MAX_KIB => Some(format!("took {kib} KiB")),
                Ok(count) => {
                    commands += count as u64;
                    None
                }
            };
            if let Some(fault) = fault {
                let _ = std::fs::write("fuzz-failure.txt", &text);
                let _ = writeln!(out, "{folder}: an input {fault}; it is in fuzz-failure.txt");
                return ExitCode::FAILURE;
            }
        }
        let _ = writeln!(
            out,
            "{folder}: {inputs} inputs, {commands} commands in {:.0} s; slowest {slowest:.1?}, most memory {:.1} MiB; nothing found",
            begin.elapsed().as_secs_f64(),
            largest as f64 / 1024.0
        );
    }
    ExitCode::SUCCESS
}
