//! Every command line of the pages, of the help texts and of `more.txt` runs as a person types it, and its
//! output is compared with what it was. After a wanted change: `INSTA_UPDATE=always cargo test -p proveout
//! --test cli command_lines::`, and look at the difference. That every option is in one of these lines, and
//! that clap takes them, is held by the tests of `src/every_option.rs`.

mod pages;
mod sandbox;
mod typed;

use std::{
    collections::BTreeSet,
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    process::Command,
};

use insta_cmd::assert_cmd_snapshot;

use crate::command_lines::{
    pages::{Shown, commands, examples, listed, long_commands, pages},
    sandbox::{root, sandbox},
    typed::{Typed, typed},
};

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_proveout"))
}

/// Help texts: of the program, and of each of its commands.
fn help() -> Vec<(String, String)> {
    let text = |words: &[&str]| {
        let output = program().args(words).output().expect("the program starts");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let first = text(&["--help"]);
    let names = first.split_once("Commands:").expect("commands").1.split_once("\n\n").expect("an end").0;
    let names: Vec<String> = names.lines().filter_map(|l| l.split_whitespace().next().map(str::to_owned)).collect();
    assert!(names.len() > 8, "{first}");
    names.into_iter().filter(|n| n != "help").map(|n| (format!("proveout {n} --help"), text(&[&n, "--help"]))).collect()
}

/// Every command of pages, help texts and `more.txt`.
fn all() -> Vec<Shown> {
    let root = root();
    let read = |path: &Path| fs::read_to_string(root.join(path)).expect("readable");
    let mut all: Vec<Shown> = pages(&root).iter().flat_map(|p| commands(&p.display().to_string(), &read(p))).collect();
    all.extend(help().iter().flat_map(|(name, text)| examples(name, text)));
    all.extend(listed("more.txt", include_str!("more.txt")));
    all
}

/// What differs from run to run, or from machine to machine: wall time, pace, memory.
const NOISE: &[(&str, &str)] = &[
    (r"(?m)^line \d+: .* simulated, .* findings\n", ""),
    (
        r"computed in [0-9.]+ s: [0-9]+ times faster than the machine",
        "computed in [time]: [n] times faster than the machine",
    ),
    (r"computed in [0-9.]+ s", "computed in [time]"),
    (r"planned in [0-9.]+ s", "planned in [time]"),
    (r"started, [0-9.]+ s", "started, [time]"),
    (
        r"cut in [0-9.]+ s of [0-9.]+ s(?:, [0-9.]+ s of processor time)?; stock ([0-9.]+) MiB(?:, process [0-9]+ MiB at most)?",
        "cut in [time]; stock $1 MiB",
    ),
    // What the checks cost is no promise.
    (r"collision: [0-9.]+ % of .* to the stock", "collision: [counts]"),
    (r"total [0-9.]+ of", "total [n] of"),
    (r"[0-9.]+ MiB", "[n] MiB"),
    // What the machine has.
    (r"(?m)^(ok {7}|missing {2}|wrong {4})([a-z]+): .*$", "[state] $2: [found]"),
    (r#""(state|found|remedy)": "[^\n]*""#, "\"$1\": [host]"),
    // The folder of the sandbox.
    (r"(?m)^/\S+/part: ", "[sandbox]/part: "),
    // Where the project lies, as seen from a scene in the sandbox.
    (r"(\.\./)+\S*/tests/first-part/", "[project]/tests/first-part/"),
];

#[test]
fn every_command_line_does_what_it_did() {
    let folder = sandbox();
    let mut settings = insta::Settings::clone_current();
    for (pattern, shown) in NOISE {
        settings.add_filter(pattern, *shown);
    }
    settings.set_prepend_module_to_snapshot(false);
    let typed = typed(&all()).unwrap_or_else(|e| panic!("{e}"));
    assert!(typed.len() > 60, "the pages show more than {} commands", typed.len());
    let (mut names, mut failed) = (BTreeSet::new(), Vec::new());
    for one in &typed {
        assert!(names.insert(one.name()), "two commands are told apart by nothing: {}", one.line());
        settings.set_description(one.line());
        let ran = catch_unwind(AssertUnwindSafe(|| settings.bind(|| run(one, folder.path()))));
        if ran.is_err() {
            failed.push(format!("{} ({})", one.line(), one.places.join(", ")));
        }
    }
    assert!(failed.is_empty(), "these commands do not do what they did:\n{}", failed.join("\n"));
    let kept = fs::read_dir(root().join("crates/proveout/tests/command_lines/snapshots")).expect("snapshots");
    for name in kept.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()) {
        let known = name.strip_suffix(".snap").is_some_and(|n| names.contains(n));
        assert!(known, "snapshots/{name} belongs to no command any more: remove it");
    }
}

fn run(typed: &Typed, folder: &Path) {
    let mut command = program();
    // The viewer of the sandbox is found first.
    command.current_dir(folder).args(&typed.words).env("PATH", "bin:/usr/bin:/bin");
    let input = typed.input.as_ref().map(|f| fs::read(folder.join(f)).expect("the input is in the sandbox"));
    assert_cmd_snapshot!(typed.name(), command.pass_stdin(input.unwrap_or_default()));
    for pair in typed.words.windows(2) {
        if let [option, file] = pair
            && matches!(option.as_str(), "--output" | "--out")
        {
            let written = folder.join(file).exists();
            assert_eq!(written, !file.starts_with("never"), "{file}: written {written}");
        }
    }
}

/// Commands of pages that take minutes name what is there, and with `PROVEOUT_LONG_COMMANDS=1` each is typed,
/// on the scenes as they are.
#[test]
fn long_commands_end_with_a_result() {
    let root = root();
    let read = |path: &Path| fs::read_to_string(root.join(path)).expect("readable");
    let all: Vec<Shown> = pages(&root).iter().flat_map(|p| long_commands(&p.display().to_string(), &read(p))).collect();
    assert!(all.len() > 2, "{all:?}");
    let folder = tempfile::tempdir().expect("temporary folder");
    for name in ["scenes", "machines", "tools", "controls"] {
        std::os::unix::fs::symlink(root.join(name), folder.path().join(name)).expect("a link");
    }
    for shown in &all {
        let typed = Typed::new(shown).unwrap_or_else(|e| panic!("{e}"));
        let scene = typed.words.get(1).map(|w| root.join(w));
        assert!(scene.is_some_and(|s| s.exists()), "{}: {} names no scene", shown.place, typed.line());
        if std::env::var_os("PROVEOUT_LONG_COMMANDS").is_none() {
            continue;
        }
        let output = program().current_dir(folder.path()).args(&typed.words).output().expect("the program starts");
        let printed = String::from_utf8_lossy(&output.stderr);
        // Pass, fail or unchecked: what a page says of it is held by other tests.
        assert!(matches!(output.status.code(), Some(0 | 1 | 3)), "{}: {}\n{printed}", shown.place, typed.line());
    }
}

/// Commands of other programs: they are long, and each names something that must be there.
#[test]
fn commands_of_developers_name_what_is_there() {
    let root = root();
    let xtask = fs::read_to_string(root.join("crates/xtask/src/main.rs")).expect("xtask");
    let help = xtask.split_once("const HELP").expect("its help").1.split_once("\";").expect("an end").0;
    let tasks: Vec<&str> = help.lines().filter_map(|l| l.strip_prefix("  ")?.split_whitespace().next()).collect();
    let mut seen = 0;
    for shown in all().iter().filter(|s| s.of_product().is_none()) {
        let words: Vec<&str> = shown.words.iter().map(String::as_str).collect();
        let after = |option: &str| words.iter().position(|w| *w == option).and_then(|i| words.get(i + 1)).copied();
        let fault = |what: &str| panic!("{}: {what}: {}", shown.place, words.join(" "));
        seen += 1;
        let crate_folder = after("-p").map(|name| match name {
            "proveout_tests" => root.join("tests"),
            name => root.join("crates").join(name),
        });
        if let Some(folder) = crate_folder.as_ref().filter(|_| after("-p") != Some("CRATE")) {
            // The one test program of a crate, and after its name the module that is chosen.
            if let Some(name) = after("--test") {
                let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
                if !manifest.contains(&format!("[[test]]\nname = \"{name}\"")) {
                    fault("no such test program");
                }
                let module = after(name).and_then(|m| m.split_once("::")).map(|(module, _)| module);
                let is_there = |module: &str| {
                    [format!("tests/{module}.rs"), format!("tests/{module}/mod.rs"), format!("{module}/mod.rs")]
                        .iter()
                        .any(|path| folder.join(path).is_file())
                };
                if !module.is_some_and(is_there) {
                    fault("no such module of tests");
                }
            }
            if !folder.join("Cargo.toml").is_file() {
                fault("no such crate");
            }
            for (option, place) in [("--bench", "benches"), ("--example", "examples")] {
                let Some(name) = after(option) else { continue };
                let file = folder.join(place).join(format!("{name}.rs"));
                if !file.is_file() && !folder.join(place).join(name).join("main.rs").is_file() {
                    fault("no such target");
                }
            }
        }
        match words[1] {
            "xtask" => {
                if !words.get(2).is_some_and(|task| tasks.contains(task)) {
                    fault("xtask has no such command");
                }
            }
            "bench" | "run" | "test" if crate_folder.is_some() || words.contains(&"--workspace") => {}
            "build" | "fmt" | "clippy" | "doc" | "deny" | "install" | "fetch" => {}
            _ => fault("say in command_lines/mod.rs how this command is checked"),
        }
    }
    assert!(seen > 20, "{seen}");
}
