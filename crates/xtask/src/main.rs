//! Developer programs: CI steps, dependency check, asset generators.
//!
//! `cargo xtask` without words lists the commands. Nothing here is part of the product, and nothing here pulls in the
//! heavy crates: `cargo xtask` must build in seconds.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line prints")]

mod cone_frustum;
mod files;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Why a command did not do its work, in words for people.
#[derive(Debug)]
struct Failure(String);

/// The folder of the workspace.
fn workspace_root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_path_buf()
}

const HELP: &str = "\
cargo xtask COMMAND

  cone-frustum     write the programs of scenes/cone-frustum

  --check          with a command that writes files: compare only, fail on a difference
";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match run(&words.iter().map(String::as_str).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure(text)) => {
            eprintln!("xtask: {text}");
            ExitCode::FAILURE
        }
    }
}

fn run(words: &[&str]) -> Result<(), Failure> {
    let root = workspace_root();
    match words {
        [] | ["--help" | "-h" | "help"] => {
            print!("{HELP}");
            Ok(())
        }
        ["cone-frustum"] => cone_frustum::run(&root, false),
        ["cone-frustum", "--check"] => cone_frustum::run(&root, true),
        _ => Err(Failure(format!("unknown command: {}\n\n{HELP}", words.join(" ")))),
    }
}
