//! `cargo xtask ci`: everything that must hold before a change lands, in the order of cost.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use crate::{
    TaskError,
    checks::{architecture, book, facts, findings, layers, style, test_command},
    cone_frustum, figures, files, machine_models,
    test_programs::{self, TestSelection},
    tools::{self, DENY, TYPOS},
    workspace::{Workspace, cargo},
};

/// One step.
struct CiStep {
    /// For `--only`.
    name: &'static str,
    /// Why it exists.
    why: &'static str,
    /// Does the work; gives a short account.
    run: fn(&CiContext) -> Result<String, TaskError>,
}

struct CiContext {
    root: PathBuf,
    workspace: Workspace,
    tests: TestSelection,
}

const STEPS: &[CiStep] = &[
    CiStep { name: "format", why: "one layout, so that a diff shows only what changed", run: format },
    CiStep {
        name: "layers",
        why: "a crate uses only crates before it: program, motion, geometry, judgement, record",
        run: layers,
    },
    CiStep {
        name: "architecture",
        why: "the map in ARCHITECTURE.md names every crate and what it truly uses",
        run: architecture,
    },
    CiStep { name: "findings", why: "a machinist can look up every code that a run can raise", run: findings },
    CiStep { name: "book", why: "every page of docs/ is in its list, and no link is broken", run: book },
    CiStep { name: "test-command", why: "one test command: in the README, in .ci/run, here", run: test_command },
    CiStep { name: "clippy", why: "no warning in any target; each exception carries its reason", run: clippy },
    CiStep { name: "quick-build", why: "the build without recordings that README offers first", run: quick_build },
    CiStep { name: "docs", why: "public items are documented and their links work", run: docs },
    CiStep {
        name: "generated",
        why: "generated programs and models match the code (schemas: a test of xtask, which has the types)",
        run: generated,
    },
    CiStep { name: "tests", why: "laws, closed forms, reference data and whole prove-outs hold", run: tests },
    CiStep { name: "figures", why: "a number on a page is the one that its run gives today", run: figures },
    CiStep { name: "facts", why: "no code looks into a sentence to find a fact", run: facts },
    CiStep { name: "style", why: "plain English in comments, messages and pages", run: style },
    CiStep { name: "typos", why: "American spelling, and names without slips", run: typos },
    CiStep {
        name: "deny",
        why: "allowed licenses, crates.io only, one version of the crates whose types we exchange",
        run: deny,
    },
];

/// Steps that take minutes for little that the others do not see: only `cargo xtask nightly` runs them.
const NIGHTLY: &[&str] = &["figures"];

/// Runs what must hold before a change lands, or the one step named, and stops at the first failure.
pub(crate) fn run(root: &Path, only: Option<&str>) -> Result<(), TaskError> {
    let steps: Vec<&CiStep> =
        STEPS.iter().filter(|s| only.map_or(!NIGHTLY.contains(&s.name), |name| name == s.name)).collect();
    if steps.is_empty() {
        let names: Vec<&str> = STEPS.iter().map(|s| s.name).collect();
        return Err(TaskError(format!("no step {:?}; steps: {}", only.unwrap_or_default(), names.join(", "))));
    }
    run_steps(root, &steps, TestSelection::Usual)
}

/// Runs all steps with all tests, those that take long included.
pub(crate) fn nightly(root: &Path) -> Result<(), TaskError> {
    run_steps(root, &STEPS.iter().collect::<Vec<_>>(), TestSelection::All)
}

fn run_steps(root: &Path, steps: &[&CiStep], tests: TestSelection) -> Result<(), TaskError> {
    let context = CiContext { root: root.to_path_buf(), workspace: Workspace::read(root)?, tests };
    let start = Instant::now();
    let mut lines = Vec::new();
    for (index, step) in steps.iter().enumerate() {
        println!("\n=== {}/{} {}: {}", index + 1, steps.len(), step.name, step.why);
        let step_start = Instant::now();
        let result = (step.run)(&context);
        let time = seconds(step_start.elapsed());
        match result {
            Ok(account) => {
                println!("=== {} passed in {time}: {account}", step.name);
                lines.push(format!("  {:<13} {time:>9}  {account}", step.name));
            }
            Err(TaskError(reason)) => {
                println!("\n{}", lines.join("\n"));
                return Err(TaskError(format!("{reason}\nci FAILED at step {} after {time}", step.name)));
            }
        }
    }
    println!("\n{}\nci passed: {} steps in {}", lines.join("\n"), steps.len(), seconds(start.elapsed()));
    Ok(())
}

fn seconds(time: Duration) -> String {
    format!("{:.1} s", time.as_secs_f64())
}

/// Runs a command with its output in view.
fn call(
    context: &CiContext,
    program: &Path,
    arguments: &[&str],
    environment: &[(&str, &str)],
) -> Result<(), TaskError> {
    let shown = shown(program, arguments, environment);
    println!("{shown}");
    let status = Command::new(program)
        .args(arguments)
        .envs(environment.iter().copied())
        .current_dir(&context.root)
        .status()
        .map_err(|e| TaskError(format!("cannot start {}: {e}", program.display())))?;
    if status.success() { Ok(()) } else { Err(TaskError(format!("failed: {shown}"))) }
}

fn shown(program: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> String {
    let name = program.file_name().unwrap_or_default().to_string_lossy();
    let variables: Vec<String> = environment.iter().map(|(k, v)| format!("{k}={v:?}")).collect();
    [variables, vec![name.into_owned()], arguments.iter().map(|&a| a.to_owned()).collect()].concat().join(" ")
}

fn cargo_call(context: &CiContext, arguments: &[&str], environment: &[(&str, &str)]) -> Result<(), TaskError> {
    call(context, Path::new(&cargo()), arguments, environment)
}

fn format(context: &CiContext) -> Result<String, TaskError> {
    cargo_call(context, &["fmt", "--all", "--check"], &[])
        .map_err(|TaskError(text)| TaskError(format!("{text}\nremedy: cargo fmt --all")))?;
    Ok("all crates".into())
}

fn layers(context: &CiContext) -> Result<String, TaskError> {
    layers::check(&context.workspace)
}

fn architecture(context: &CiContext) -> Result<String, TaskError> {
    architecture::check(&files::get(&context.root.join("ARCHITECTURE.md"))?, &context.workspace)
}

fn book(context: &CiContext) -> Result<String, TaskError> {
    book::check(&context.root)
}

fn findings(context: &CiContext) -> Result<String, TaskError> {
    findings::check(&context.root)
}

fn test_command(context: &CiContext) -> Result<String, TaskError> {
    test_command::check(&context.root)
}

fn clippy(context: &CiContext) -> Result<String, TaskError> {
    cargo_call(
        context,
        &["clippy", "--workspace", "--all-targets", "--all-features", "--locked", "--", "-D", "warnings"],
        &[],
    )?;
    Ok("all targets, all features, no warning".into())
}

fn quick_build(context: &CiContext) -> Result<String, TaskError> {
    let quick = ["clippy", "--package", "proveout", "--no-default-features", "--locked", "--", "-D", "warnings"];
    cargo_call(context, &quick, &[])?;
    Ok("no warning".into())
}

fn docs(context: &CiContext) -> Result<String, TaskError> {
    cargo_call(
        context,
        &["doc", "--workspace", "--no-deps", "--all-features", "--locked"],
        &[("RUSTDOCFLAGS", "-D warnings")],
    )?;
    Ok("no warning".into())
}

fn generated(context: &CiContext) -> Result<String, TaskError> {
    cone_frustum::run(&context.root, true)?;
    machine_models::run(&context.root, true)?;
    Ok("cone frustum programs, machine models".into())
}

/// Tests, with their output in view and their closing lines counted; those in texts of the documentation come
/// last.
fn tests(context: &CiContext) -> Result<String, TaskError> {
    let (mut total, mut left_out) = (TestTotal::default(), BTreeSet::new());
    let mut line = |line: &str| {
        println!("{line}");
        total.add(line);
        left_out.extend(line.trim().strip_prefix(LEFT_OUT).map(str::to_owned));
    };
    let mut result = test_programs::run(&context.root, &[], context.tests, &mut line);
    let documented = Command::new(cargo())
        .args(["test", "--workspace", "--locked", "--doc"])
        .current_dir(&context.root)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| TaskError(format!("cannot start cargo: {e}")))?;
    String::from_utf8_lossy(&documented.stdout).lines().for_each(&mut line);
    if !documented.status.success() {
        let before = result.err().map_or_else(String::new, |TaskError(text)| text + "\n");
        result = Err(TaskError(format!("{before}failed: examples in the documentation")));
    }
    result
        .map(|slowest| format!("{}\n  {:<13} {:>9}  {slowest}", account(&total, &left_out), "", ""))
        .map_err(|TaskError(text)| TaskError(format!("{total}\n{text}")))
}

/// Start of the line with which a test reports that it passed without checking, for lack of data; not
/// captured by the test harness.
const LEFT_OUT: &str = "LEFT OUT: ";

/// The tests, and what passed without looking.
fn account(total: &TestTotal, left_out: &BTreeSet<String>) -> String {
    if left_out.is_empty() {
        return total.to_string();
    }
    let list: Vec<String> = left_out.iter().map(|l| format!("\n  {:<13} {:>9}    {l}", "", "")).collect();
    format!("{total}; {} LEFT OUT for lack of data:{}", left_out.len(), list.concat())
}

/// Sum over the closing lines `test result: ok. 7 passed; 0 failed; 0 ignored; ...`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct TestTotal {
    suites: u64,
    passed: u64,
    failed: u64,
    ignored: u64,
}

impl TestTotal {
    fn add(&mut self, line: &str) {
        let Some(counts) = line.strip_prefix("test result: ") else { return };
        self.suites += 1;
        let words: Vec<&str> = counts.split([' ', ';', '.']).filter(|w| !w.is_empty()).collect();
        for pair in words.windows(2) {
            let [count, what] = pair else { continue };
            let Ok(count) = count.parse::<u64>() else { continue };
            match *what {
                "passed" => self.passed += count,
                "failed" => self.failed += count,
                "ignored" => self.ignored += count,
                _ => {}
            }
        }
    }
}

impl std::fmt::Display for TestTotal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { suites, passed, failed, ignored } = self;
        write!(f, "{passed} tests passed, {failed} failed, {ignored} ignored in {suites} suites")
    }
}

fn figures(context: &CiContext) -> Result<String, TaskError> {
    figures::run(&context.root, &figures::FigureRequest { check: true, ..figures::FigureRequest::default() })
}

fn facts(context: &CiContext) -> Result<String, TaskError> {
    facts::check(&context.root)
}

fn style(context: &CiContext) -> Result<String, TaskError> {
    style::check(&context.root)
}

fn typos(context: &CiContext) -> Result<String, TaskError> {
    let program = tools::find(&TYPOS, &context.workspace.target)?;
    call(context, &program, &["--config", ".typos.toml"], &[])?;
    Ok("no misspelling".into())
}

fn deny(context: &CiContext) -> Result<String, TaskError> {
    let program = tools::find(&DENY, &context.workspace.target)?;
    // cargo-deny reads the manifests of all crates for the target in deny.toml; cargo has them after this.
    cargo_call(context, &["fetch", "--locked", "--quiet", "--target", "x86_64-unknown-linux-gnu"], &[])?;
    let mut checks = vec!["--offline", "--locked", "check", "bans", "licenses", "sources"];
    let advisories = advisory_database();
    if advisories {
        checks.push("advisories");
    }
    call(context, &program, &checks, &[])?;
    if advisories {
        return Ok("bans, licenses, sources, advisories".into());
    }
    Ok("bans, licenses, sources; ADVISORIES LEFT OUT: no database on this machine (fetch it: cargo deny fetch)".into())
}

/// True when a database of advisories lies where cargo-deny keeps it.
fn advisory_database() -> bool {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::var_os("HOME").map(|h| PathBuf::from(h).join(".cargo")));
    home.and_then(|home| std::fs::read_dir(home.join("advisory-dbs")).ok())
        .is_some_and(|mut entries| entries.any(|e| e.is_ok_and(|e| e.path().is_dir())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closing_lines_are_summed() {
        let mut total = TestTotal::default();
        total.add("running 7 tests");
        total.add("test result: ok. 7 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 2.28s");
        total.add("test result: FAILED. 2 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.00s");
        assert_eq!(total, TestTotal { suites: 2, passed: 9, failed: 3, ignored: 1 });
        assert_eq!(total.to_string(), "9 tests passed, 3 failed, 1 ignored in 2 suites");
    }

    #[test]
    fn tests_that_did_not_look_are_named_in_the_summary() {
        let total = TestTotal { suites: 1, passed: 2, failed: 0, ignored: 0 };
        assert!(!account(&total, &BTreeSet::new()).contains("LEFT OUT"));
        let text = account(&total, &["the axis cross: no data set".to_owned()].into());
        assert!(
            text.contains("1 LEFT OUT for lack of data:") && text.ends_with("the axis cross: no data set"),
            "{text}"
        );
    }

    #[test]
    fn steps_have_their_own_names() {
        for (i, step) in STEPS.iter().enumerate() {
            assert!(STEPS[i + 1..].iter().all(|other| other.name != step.name), "{} twice", step.name);
        }
        assert!(run(Path::new("."), Some("no-such-step")).expect_err("an unknown step").0.contains("format, layers"));
    }
}
