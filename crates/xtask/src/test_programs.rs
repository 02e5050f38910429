//! The test programs of the workspace, run in parallel by module.
//!
//! `cargo test` starts one program after the other, and the other cores wait while the last test of each runs
//! alone: a sixth of the time on two cores. Here every module of a program, two levels deep, is a group of
//! its own. A group runs on one thread, as many groups at once as there are cores, and those that take
//! longest come first.

use std::{
    collections::{BTreeMap, VecDeque},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::{Mutex, PoisonError},
    thread,
    time::{Duration, Instant},
};

use serde_json::Value;

use crate::{TaskError, workspace::cargo};

/// Groups that take longest, as `program/module` or the begin of it, the longest first; the order of all
/// others does not matter.
const LONG: [&str; 16] = [
    "prove_outs/prove_out",
    "cli/reschedule",
    "cli/command_lines",
    "cli/hostile",
    "cli/first_part",
    "prove_outs/keys",
    "sim/loose_parts",
    "xtask/schemas",
    "sim/judging",
    "sim/roughness_maps",
    "blade/kinds",
    "cli/sweep",
    "cli/report_page",
    "proveout_collision/least",
    "controller/poles",
    "prove_outs/injection",
];

/// How many of the slowest groups the account names.
const SLOWEST: usize = 12;

/// One test program.
#[derive(Clone, Debug, PartialEq, Eq)]
struct TestProgram {
    name: String,
    path: PathBuf,
    /// Where it is started: the folder of its crate, as by cargo.
    folder: PathBuf,
}

/// The tests of one module of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
struct TestModule {
    program: TestProgram,
    module: String,
    tests: Vec<String>,
}

impl TestModule {
    fn name(&self) -> String {
        format!("{}/{}", self.program.name, self.module)
    }
}

/// Which tests run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TestSelection {
    /// Those that are not marked `#[ignore]`.
    Usual,
    /// Those marked `#[ignore]` as well.
    All,
}

/// Builds all programs, runs all groups, and hands every line of their output to `line`. A failure does not
/// keep the others from running. Returns the slowest groups with their times.
///
/// # Errors
/// The groups that failed, by name.
pub(crate) fn run(
    root: &Path,
    packages: &[&str],
    selection: TestSelection,
    line: &mut (dyn FnMut(&str) + Send),
) -> Result<String, TaskError> {
    let mut groups = Vec::new();
    for program in built(root, packages)? {
        groups.extend(groups_of(&program)?);
    }
    groups.sort_by_key(|g| LONG.iter().position(|name| g.name().starts_with(name)).unwrap_or(LONG.len()));
    let (all, threads) = (groups.len(), thread::available_parallelism().map_or(1, usize::from));
    let waiting = Mutex::new(VecDeque::from(groups));
    let shared = Mutex::new((Vec::new(), Vec::new(), line));
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(group) = next(&waiting) {
                    let start = Instant::now();
                    let (text, passed) = called(&group, selection);
                    let time = start.elapsed();
                    let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
                    let (times, failed, line) = &mut *shared;
                    times.push((time, group.name()));
                    line(&format!("{} of {all}: {} in {:.1} s", times.len(), group.name(), time.as_secs_f64()));
                    text.lines().for_each(&mut *line);
                    if !passed {
                        failed.push(group.name());
                    }
                }
            });
        }
    });
    let (times, failed, _) = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    if failed.is_empty() { Ok(slowest(times)) } else { Err(TaskError(format!("failed: {}", failed.join(", ")))) }
}

fn next(waiting: &Mutex<VecDeque<TestModule>>) -> Option<TestModule> {
    waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
}

/// The slowest groups, one a line.
fn slowest(mut times: Vec<(Duration, String)>) -> String {
    times.sort_by(|a, b| b.cmp(a));
    let sum: f64 = times.iter().map(|(t, _)| t.as_secs_f64()).sum();
    let mut text = format!("{} groups, {sum:.0} s on all threads together", times.len());
    for (time, name) in times.iter().take(SLOWEST) {
        text += &format!("\n  {:<13} {:>7.1} s  {name}", "", time.as_secs_f64());
    }
    text
}

/// Output of a group, and whether its tests passed.
fn called(group: &TestModule, selection: TestSelection) -> (String, bool) {
    let mut command = Command::new(&group.program.path);
    command.arg("--exact").args(&group.tests);
    if selection == TestSelection::All {
        command.arg("--include-ignored");
    }
    let output = command
        .current_dir(&group.program.folder)
        .env("CARGO_MANIFEST_DIR", &group.program.folder)
        .env("RUST_TEST_THREADS", "1")
        .output();
    match output {
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
            let ended = if output.status.success() { String::new() } else { format!("\n{}", output.status) };
            (text + &ended, output.status.success())
        }
        Err(e) => (format!("cannot start {}: {e}", group.program.path.display()), false),
    }
}

/// Builds the test programs of some packages, or of all.
fn built(root: &Path, packages: &[&str]) -> Result<Vec<TestProgram>, TaskError> {
    let mut command = Command::new(cargo());
    command.args(["test", "--locked", "--no-run", "--message-format", "json-render-diagnostics"]);
    if packages.is_empty() {
        command.arg("--workspace");
    }
    command.args(packages.iter().flat_map(|p| ["--package", *p]));
    let output = command
        .current_dir(root)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| TaskError(format!("cannot start cargo: {e}")))?;
    if !output.status.success() {
        return Err(TaskError("the tests could not be built".into()));
    }
    let programs: Vec<TestProgram> = String::from_utf8_lossy(&output.stdout).lines().filter_map(program).collect();
    if programs.is_empty() { Err(TaskError("cargo names no test program".into())) } else { Ok(programs) }
}

/// A test program, where a message of cargo names one.
fn program(message: &str) -> Option<TestProgram> {
    let message: Value = serde_json::from_str(message).ok()?;
    if message["reason"] != "compiler-artifact" || message["profile"]["test"] != true {
        return None;
    }
    Some(TestProgram {
        name: message["target"]["name"].as_str()?.to_owned(),
        path: message["executable"].as_str()?.into(),
        folder: Path::new(message["manifest_path"].as_str()?).parent()?.to_owned(),
    })
}

/// Asks a program for its tests and groups them by module.
fn groups_of(program: &TestProgram) -> Result<Vec<TestModule>, TaskError> {
    let output = Command::new(&program.path)
        .args(["--list", "--format", "terse"])
        .current_dir(&program.folder)
        .output()
        .map_err(|e| TaskError(format!("cannot start {}: {e}", program.path.display())))?;
    if !output.status.success() {
        return Err(TaskError(format!("{} does not list its tests", program.name)));
    }
    Ok(grouped(program, &String::from_utf8_lossy(&output.stdout)))
}

fn grouped(program: &TestProgram, list: &str) -> Vec<TestModule> {
    let mut modules: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for test in list.lines().filter_map(|l| l.strip_suffix(": test")) {
        modules.entry(module_of(test)).or_default().push(test.to_owned());
    }
    modules
        .into_iter()
        .map(|(module, tests)| TestModule { program: program.clone(), module: module.to_owned(), tests })
        .collect()
}

/// The first two parts of the path of a test, without its own name.
fn module_of(test: &str) -> &str {
    let path = test.rsplit_once("::").map_or(test, |(path, _)| path);
    path.match_indices("::").nth(1).map_or(path, |(end, _)| &path[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that only the night runs are listed in TESTING.md, and no other is.
    #[test]
    fn the_list_of_nightly_tests_is_that_of_their_marks() {
        let root = crate::workspace_root();
        let mut marked = std::collections::BTreeSet::new();
        let is_test =
            |file: &PathBuf| file.extension().is_some_and(|e| e == "rs") && !file.ends_with("test_programs.rs");
        for file in crate::checks::style::text_files(&root).expect("readable").into_iter().filter(is_test) {
            let text = std::fs::read_to_string(root.join(&file)).expect("text");
            for after in text.split("#[ignore = \"nightly").skip(1) {
                let name = after.lines().nth(1).unwrap_or_default().trim().trim_start_matches("fn ");
                marked.insert(name.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>());
            }
        }
        assert!(marked.len() > 10, "{marked:?}");
        let page = std::fs::read_to_string(root.join("TESTING.md")).expect("the page");
        let table = page.split("| nightly test |").nth(1).expect("the table").split("\n\n").next().unwrap_or_default();
        let listed: std::collections::BTreeSet<String> = table
            .lines()
            .filter_map(|row| row.split('|').nth(1))
            .flat_map(|cell| cell.split('`').skip(1).step_by(2))
            .filter_map(|name| name.rsplit("::").next().map(str::to_owned))
            .collect();
        assert_eq!(marked, listed);
    }

    #[test]
    fn messages_of_cargo_name_the_test_programs_alone() {
        let message = |test: bool, executable: &str| {
            format!(
                r#"{{"reason":"compiler-artifact","manifest_path":"/w/crates/a/Cargo.toml","target":{{"name":"law"}},
                   "profile":{{"test":{test}}},"executable":{executable}}}"#
            )
        };
        let expected = TestProgram { name: "law".into(), path: "/t/law-1".into(), folder: "/w/crates/a".into() };
        assert_eq!(program(&message(true, r#""/t/law-1""#)), Some(expected));
        assert_eq!(program(&message(false, r#""/t/law-1""#)), None, "the product");
        assert_eq!(program(&message(true, "null")), None, "a library");
        assert_eq!(program(r#"{"reason":"build-finished","success":true}"#), None);
        assert_eq!(program("warning: not JSON"), None);
    }

    #[test]
    fn a_group_is_the_tests_of_a_module() {
        let program = TestProgram { name: "sim".into(), path: "sim".into(), folder: ".".into() };
        let list = "keys::a: test\nkeys::deep::b: test\nkeys::deep::er::c: test\nother: test\nkeys::c: benchmark\n\n";
        let all: Vec<(String, usize)> = grouped(&program, list).iter().map(|g| (g.name(), g.tests.len())).collect();
        let expected = [("sim/keys", 1), ("sim/keys::deep", 2), ("sim/other", 1)];
        assert_eq!(all, expected.map(|(name, count)| (name.to_owned(), count)));
    }

    #[test]
    fn a_program_that_fails_or_is_missing_is_reported() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let group = |path: PathBuf, folder: PathBuf| TestModule {
            program: TestProgram { name: "none".into(), path, folder },
            module: "none".into(),
            tests: vec!["none".into()],
        };
        let (text, passed) = called(&group(folder.path().join("none"), folder.path().into()), TestSelection::Usual);
        assert!(!passed && text.contains("cannot start"), "{text}");
        let here = std::env::current_exe().expect("this program");
        assert!(
            !called(&group(here, folder.path().join("none")), TestSelection::All).1,
            "a folder that does not exist"
        );
    }

    #[test]
    fn the_slowest_come_first() {
        let text = slowest(vec![(Duration::from_secs(1), "a".into()), (Duration::from_secs(3), "b".into())]);
        assert!(text.starts_with("2 groups, 4 s") && text.find("3.0 s  b") < text.find("1.0 s  a"), "{text}");
    }
}
