//! Seeds of the fuzz targets, and some changes of each, run as tests; `examples/fuzz.rs` runs them for
//! minutes.

#![allow(clippy::unwrap_used, unreachable_pub, dead_code, reason = "helpers of tests fail by panic")]

#[path = "common/mutate.rs"]
mod mutate;

use std::path::Path;

use mutate::{DIALECTS, Random, mutate, run};

/// Programs of a folder, and the cases of the dialect, which are seeds too.
fn seeds(folder: &str) -> Vec<String> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let mut files = Vec::new();
    for kind in ["fuzz_seeds", "cases", "bad"] {
        let Ok(entries) = std::fs::read_dir(tests.join(kind).join(folder)) else { continue };
        files.extend(
            entries.map(|e| e.unwrap().path()).filter(|p| p.is_file() && p.extension().is_some_and(|e| e != "jsonl")),
        );
    }
    files.sort();
    files.iter().map(|f| String::from_utf8_lossy(&std::fs::read(f).unwrap()).into_owned()).collect()
}

#[test]
fn every_dialect_has_seeds_and_they_run() {
    for (folder, dialect) in DIALECTS {
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz_seeds").join(folder);
        assert!(std::fs::read_dir(own).unwrap().count() > 0, "{folder} has no seeds");
        for seed in seeds(folder) {
            run(&seed, dialect);
        }
    }
}

#[test]
fn changed_seeds_neither_panic_nor_run_on() {
    // Some seconds; PROVEOUT_FUZZ_RUNS raises it.
    let runs = std::env::var("PROVEOUT_FUZZ_RUNS").ok().and_then(|n| n.parse().ok()).unwrap_or(300);
    for (folder, dialect) in DIALECTS {
        let seeds = seeds(folder);
        let mut random = Random(7);
        for _ in 0..runs {
            run(&mutate(&seeds, &mut random), dialect);
        }
    }
}
