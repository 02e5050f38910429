//! Developer programs: CI steps, dependency check, asset generators.
//!
//! `cargo xtask` without words lists the commands. Nothing here is part of the product, and nothing here
//! pulls in the heavy crates: `cargo xtask` must build in seconds.
//!
//! | file or folder | holds |
//! |---|---|
//! | `ci.rs`, `quick.rs`, `test_programs.rs` | `ci`, `nightly`, `quick`; the tests in parallel |
//! | `checks/` | checks of our own: crate table, layers, book, findings, style, facts |
//! | `workspace.rs`, `files.rs`, `tools.rs` | crates and manifests; generated files; pinned tools |
//! | `figures/`, `experiments.rs` | figures of the pages from runs; `docs/experiments.md` |
//! | `schemas.rs` | `docs/schemas` |
//! | `machine_models/` | glTF models and bodies of `machines/` |
//! | `cone_frustum/` | the programs of `scenes/cone-frustum` |
//! | `jobs/` | typical long-running scenes, to be timed |
//! | `verify_clearance/`, `verify_schedule/` | checks of certificates, with code of their own |
//! | `wheel.rs` | the Python package, built and tested |
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line prints")]

mod checks;
mod ci;
mod cone_frustum;
#[cfg(feature = "schemas")]
mod experiments;
mod figures;
mod files;
#[cfg(any(test, feature = "certificates"))]
mod jobs;
mod machine_models;
mod quick;
#[cfg(any(test, feature = "schemas"))]
mod schemas;
mod test_programs;
mod tools;
#[cfg(any(test, feature = "certificates"))]
mod verify_clearance;
mod verify_schedule;
mod wheel;
mod workspace;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Why a command did not do its work, in words for people.
#[derive(Debug)]
struct TaskError(String);

/// The folder of the workspace.
fn workspace_root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_path_buf()
}

const HELP: &str = "\
cargo xtask COMMAND

  ci               run every check required before a change is merged
  ci --only STEP   run one step of it
  quick            check format, lints and tests of the crates changed since the last commit; --since REF: since REF
  nightly          run all of ci, the long tests, and the figures of all pages
  deps             list which crate uses which
  cone-frustum     write the programs of scenes/cone-frustum
  machine-models   write the glTF models of machines/ and the body tables of their machine.toml
  jobs DIR         write typical long-running scenes, to be timed with `proveout run`
  schemas          write docs/schemas
  experiments DIR  write docs/experiments.md from the compare.json of these folders, made by `proveout compare`
  verify-clearance RUN SCENE
                   check the clearances in a run folder, pair by pair, with independent distance computations
  verify-schedule FILE
                   check the bound of `proveout reschedule --certificate FILE` and its proof with independent code
  figures          run docs/figures.toml and update the figures on the pages; --run NAME: only that run (also a long one),
                   --kept: use the results in target/figures
  wheel            build the Python package and test it in its own environment; --release, --rerun: with recordings, --no-test

  --check          with a command that writes files: compare only, fail on a difference
";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match run(&words.iter().map(String::as_str).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(TaskError(text)) => {
            eprintln!("xtask: {text}");
            ExitCode::FAILURE
        }
    }
}

fn run(words: &[&str]) -> Result<(), TaskError> {
    let root = workspace_root();
    match words {
        [] | ["--help" | "-h" | "help"] => {
            print!("{HELP}");
            Ok(())
        }
        ["ci"] => ci::run(&root, None),
        ["ci", "--only", step] => ci::run(&root, Some(step)),
        ["nightly"] => ci::nightly(&root),
        ["quick"] => quick::run(&root, "HEAD"),
        ["quick", "--since", reference] => quick::run(&root, reference),
        ["deps"] => {
            let workspace = workspace::Workspace::read(&root)?;
            print!("{}", checks::layers::table(&workspace));
            checks::layers::check(&workspace).map(|_| ())
        }
        ["jobs", out] => write_jobs(&root, out),
        ["schemas", options @ ..] => schemas(&root, options),
        ["experiments", words @ ..] if words.iter().any(|w| *w != "--check") => experiments(&root, words),
        ["figures", options @ ..] => {
            println!("{}", figures::run(&root, &figures::FigureRequest::read(options)?)?);
            Ok(())
        }
        ["verify-clearance", folder, scene] => verify_clearance(&root, folder, scene),
        ["verify-schedule", file] => {
            println!("{}", verify_schedule::run(Path::new(file))?);
            Ok(())
        }
        ["wheel", options @ ..] => {
            println!("{}", wheel::run(&root, wheel::WheelOptions::read(options)?)?);
            Ok(())
        }
        ["machine-models"] => machine_models::run(&root, false),
        ["machine-models", "--check"] => machine_models::run(&root, true),
        ["cone-frustum"] => cone_frustum::run(&root, false),
        ["cone-frustum", "--check"] => cone_frustum::run(&root, true),
        _ => Err(TaskError(format!("unknown command: {}\n\n{HELP}", words.join(" ")))),
    }
}

/// The schemas come from types of the product; only the build with this feature waits for its crates.
#[cfg(feature = "schemas")]
fn schemas(root: &Path, options: &[&str]) -> Result<(), TaskError> {
    match options {
        [] => schemas::run(root, false),
        ["--check"] => schemas::run(root, true),
        _ => Err(TaskError(format!("unknown options: {}", options.join(" ")))),
    }
}

#[cfg(feature = "schemas")]
fn experiments(root: &Path, folders: &[&str]) -> Result<(), TaskError> {
    experiments::run(root, folders)
}

#[cfg(feature = "certificates")]
fn write_jobs(root: &Path, out: &str) -> Result<(), TaskError> {
    for scene in jobs::write(root, Path::new(out))? {
        println!("{}", scene.display());
    }
    Ok(())
}

#[cfg(not(feature = "certificates"))]
fn write_jobs(root: &Path, out: &str) -> Result<(), TaskError> {
    let out = std::path::absolute(out).map_err(|e| TaskError(format!("{out}: {e}")))?;
    with_product(root, "certificates", "jobs", &[&out.display().to_string()])
}

#[cfg(feature = "certificates")]
fn verify_clearance(_: &Path, folder: &str, scene: &str) -> Result<(), TaskError> {
    println!("{}", verify_clearance::run(Path::new(folder), Path::new(scene))?);
    Ok(())
}

#[cfg(not(feature = "certificates"))]
fn verify_clearance(root: &Path, folder: &str, scene: &str) -> Result<(), TaskError> {
    with_product(root, "certificates", "verify-clearance", &[folder, scene])
}

#[cfg(not(feature = "schemas"))]
fn schemas(root: &Path, options: &[&str]) -> Result<(), TaskError> {
    with_product(root, "schemas", "schemas", options)
}

#[cfg(not(feature = "schemas"))]
fn experiments(root: &Path, folders: &[&str]) -> Result<(), TaskError> {
    with_product(root, "schemas", "experiments", folders)
}

/// Starts the build that has the types of the product.
#[cfg(not(all(feature = "schemas", feature = "certificates")))]
fn with_product(root: &Path, feature: &str, command: &str, words: &[&str]) -> Result<(), TaskError> {
    let status = std::process::Command::new(workspace::cargo())
        .args(["run", "--quiet", "--locked", "--package", "xtask", "--features", feature, "--", command])
        .args(words)
        .current_dir(root)
        .status()
        .map_err(|e| TaskError(format!("cannot start cargo: {e}")))?;
    if status.success() { Ok(()) } else { Err(TaskError(format!("{command}: not written"))) }
}
