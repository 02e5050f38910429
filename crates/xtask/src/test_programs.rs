//! Runs the test programs of the workspace in parallel. `cargo test` starts one after the other, and while
//! the last test of each runs alone, the other cores wait: a sixth of the time on two cores. Here each
//! program has one thread for its tests, as many programs run at once as there are cores, and the longest
//! start first.

use std::{
    collections::VecDeque,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::{Mutex, PoisonError},
    thread,
};

use serde_json::Value;

use crate::{Failure, workspace::cargo};

/// Programs that take longest, the first one first; the order of all others does not matter.
const LONG: [&str; 14] = [
    "prove_out",
    "keys",
    "command_lines",
    "reschedule",
    "hostile",
    "first_part",
    "loose_parts",
    "roughness_maps",
    "blade_kinds",
    "judging",
    "proveout_stock",
    "report_page",
    "proveout_collision",
    "xtask",
];

/// One of them.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Program {
    name: String,
    path: PathBuf,
    /// Where it is started: the folder of its crate, as by cargo.
    folder: PathBuf,
}

/// Builds all, runs all, and hands every line of their output to `line`; a failure does not keep the others from running.
///
/// # Errors
/// Those that failed, by name.
pub(crate) fn run(root: &Path, line: &mut (dyn FnMut(&str) + Send)) -> Result<(), Failure> {
    let programs = built(root)?;
    let (all, threads) = (programs.len(), thread::available_parallelism().map_or(1, usize::from));
    let waiting = Mutex::new(VecDeque::from(programs));
    let told = Mutex::new((0, Vec::new(), line));
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(program) = waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front() {
                    let (text, passed) = called(&program);
                    let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
                    let (ended, failed, line) = &mut *told;
                    *ended += 1;
                    line(&format!("{ended} of {all}: {} in {}", program.name, program.folder.display()));
                    text.lines().for_each(&mut *line);
                    if !passed {
                        failed.push(program.name.clone());
                    }
                }
            });
        }
    });
    let (_, failed, _) = told.into_inner().unwrap_or_else(PoisonError::into_inner);
    if failed.is_empty() { Ok(()) } else { Err(Failure(format!("failed: {}", failed.join(", ")))) }
}

/// Output of a program, and whether its tests passed.
fn called(program: &Program) -> (String, bool) {
    let output = Command::new(&program.path)
        .current_dir(&program.folder)
        .env("CARGO_MANIFEST_DIR", &program.folder)
        .env("RUST_TEST_THREADS", "1")
        .output();
    match output {
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
            let ended = if output.status.success() { String::new() } else { format!("\n{}", output.status) };
            (text + &ended, output.status.success())
        }
        Err(e) => (format!("cannot start {}: {e}", program.path.display()), false),
    }
}

/// Builds the test programs and lists them, the long ones first.
fn built(root: &Path) -> Result<Vec<Program>, Failure> {
    let output = Command::new(cargo())
        .args(["test", "--workspace", "--locked", "--no-run", "--message-format", "json-render-diagnostics"])
        .current_dir(root)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| Failure(format!("cannot start cargo: {e}")))?;
    if !output.status.success() {
        return Err(Failure("the tests could not be built".into()));
    }
    let mut programs: Vec<Program> = String::from_utf8_lossy(&output.stdout).lines().filter_map(program).collect();
    if programs.is_empty() {
        return Err(Failure("cargo names no test program".into()));
    }
    programs.sort_by_key(|p| LONG.iter().position(|name| *name == p.name).unwrap_or(LONG.len()));
    Ok(programs)
}

/// The test program that a message of cargo names, if it names one.
fn program(message: &str) -> Option<Program> {
    let message: Value = serde_json::from_str(message).ok()?;
    if message["reason"] != "compiler-artifact" || message["profile"]["test"] != true {
        return None;
    }
    Some(Program {
        name: message["target"]["name"].as_str()?.to_owned(),
        path: message["executable"].as_str()?.into(),
        folder: Path::new(message["manifest_path"].as_str()?).parent()?.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_cargo_name_the_test_programs_alone() {
        let message = |test: bool, executable: &str| {
            format!(
                r#"{{"reason":"compiler-artifact","manifest_path":"/w/crates/a/Cargo.toml","target":{{"name":"law"}},
                   "profile":{{"test":{test}}},"executable":{executable}}}"#
            )
        };
        let expected = Program { name: "law".into(), path: "/t/law-1".into(), folder: "/w/crates/a".into() };
        assert_eq!(program(&message(true, r#""/t/law-1""#)), Some(expected));
        assert_eq!(program(&message(false, r#""/t/law-1""#)), None, "the product");
        assert_eq!(program(&message(true, "null")), None, "a library");
        assert_eq!(program(r#"{"reason":"build-finished","success":true}"#), None);
        assert_eq!(program("warning: not JSON"), None);
    }

    #[test]
    fn a_program_that_fails_or_is_not_there_is_told() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let missing = Program { name: "none".into(), path: folder.path().join("none"), folder: folder.path().into() };
        let (text, passed) = called(&missing);
        assert!(!passed && text.contains("cannot start"), "{text}");
        let here = std::env::current_exe().expect("this program");
        let listing = Program { name: "this".into(), path: here, folder: folder.path().join("none") };
        assert!(!called(&listing).1, "a folder that is not there");
    }
}
