//! Every option of every command is in a command line that `tests/command_lines` runs, and clap accepts
//! these lines.

#[path = "../tests/command_lines/pages.rs"]
mod pages;
#[allow(dead_code, reason = "the command lines are run by tests/command_lines")]
#[path = "../tests/command_lines/typed.rs"]
mod typed;

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use clap::{ArgMatches, CommandFactory, Parser, error::ErrorKind, parser::ValueSource};

use crate::args::{Cli, with_new_name};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// Commands of the pages and of the examples in the help texts.
fn shown() -> Vec<pages::Shown> {
    let root = root();
    let read = |path: &Path| fs::read_to_string(root.join(path)).expect("readable");
    let mut all: Vec<pages::Shown> =
        pages::pages(&root).iter().flat_map(|p| pages::commands(&p.display().to_string(), &read(p))).collect();
    for command in Cli::command().get_subcommands_mut() {
        let (name, help) = (command.get_name().to_owned(), command.render_long_help().to_string());
        all.extend(pages::examples(&format!("proveout {name} --help"), &help));
    }
    all
}

#[test]
fn clap_takes_every_command_line_of_a_page() {
    let mut all = typed::typed(&shown()).unwrap_or_else(|e| panic!("{e}"));
    assert!(all.len() > 30, "{}", all.len());
    // Those that take minutes run in tests/command_lines only where a variable asks for it.
    let root = root();
    let read = |path: &Path| fs::read_to_string(root.join(path)).expect("readable");
    let pages = pages::pages(&root);
    let long = pages.iter().flat_map(|p| pages::long_commands(&p.display().to_string(), &read(p)));
    all.extend(long.map(|s| typed::Typed::new(&s).unwrap_or_else(|e| panic!("{e}"))));
    for one in &all {
        let words = std::iter::once("proveout").chain(one.words.iter().map(String::as_str));
        if let Err(e) = Cli::command().try_get_matches_from(words) {
            panic!("{}: {}\n{e}", one.places.join(", "), one.line());
        }
    }
}

/// The command that is called, with those above it: `sweep plan`.
fn innermost(matches: &ArgMatches) -> (String, &ArgMatches) {
    let (mut names, mut at) = (Vec::new(), matches);
    while let Some((name, inner)) = at.subcommand() {
        names.push(name);
        at = inner;
    }
    (names.join(" "), at)
}

/// All commands without commands of their own.
fn leaves(of: &clap::Command) -> Vec<(String, clap::Command)> {
    let below = |command: &clap::Command| match leaves(command) {
        inner if inner.is_empty() => vec![(command.get_name().to_owned(), command.clone())],
        inner => inner.into_iter().map(|(name, leaf)| (format!("{} {name}", command.get_name()), leaf)).collect(),
    };
    of.get_subcommands().flat_map(below).collect()
}

#[test]
fn every_option_of_every_command_is_typed_in_a_test() {
    let mut all = shown();
    all.extend(pages::listed("more.txt", include_str!("../tests/command_lines/more.txt")));
    let typed = typed::typed(&all).unwrap_or_else(|e| panic!("{e}"));
    let mut seen: BTreeSet<(String, String)> = BTreeSet::new();
    for one in &typed {
        let words = std::iter::once("proveout").chain(one.words.iter().map(String::as_str));
        match Cli::command().try_get_matches_from(words) {
            Ok(matches) => {
                let (name, matches) = innermost(&matches);
                for id in matches.ids().map(clap::Id::as_str) {
                    if matches.value_source(id) == Some(ValueSource::CommandLine) {
                        seen.insert((name.clone(), id.to_owned()));
                    }
                }
            }
            // Calls that clap refuses are typed too, for their texts.
            Err(e) => assert!(!e.to_string().is_empty(), "{}", one.line()),
        }
    }
    let mut missing = Vec::new();
    for (name, command) in leaves(&Cli::command()) {
        for argument in command.get_arguments() {
            let key = (name.clone(), argument.get_id().to_string());
            if !seen.contains(&key) {
                missing.push(format!("proveout {}: {}", key.0, key.1));
            }
        }
    }
    assert!(
        missing.is_empty(),
        "no test types these: add a line to tests/command_lines/more.txt\n{}",
        missing.join("\n")
    );
}

/// A page may name a command without its arguments (`proveout nc --post`): command and options are there all
/// the same.
#[test]
fn commands_that_pages_mention_are_there() {
    for mention in shown().iter().filter(|s| s.of_product().is_some() && !s.can_be_typed()) {
        let words = mention.of_product().unwrap_or_default();
        let known = Cli::command();
        let Some(command) = known.find_subcommand(&words[0]) else {
            panic!("{}: there is no command {:?}", mention.place, words[0]);
        };
        for option in words[1..].iter().filter_map(|w| w.strip_prefix("--")) {
            let is = |a: &clap::Arg| a.get_long() == Some(option);
            assert!(command.get_arguments().any(is) || option == "help", "{}: {words:?}", mention.place);
        }
    }
}

#[test]
fn an_old_option_is_refused_with_its_new_name_and_out_is_taken() {
    let parse = |line: &str| Cli::try_parse_from(line.split(' '));
    for (line, tip) in [
        ("proveout run part --free-axes 5", "the name of '--free-axes' is '--orientation-maps' now"),
        ("proveout run part --free-axes=5", "the name of '--free-axes' is '--orientation-maps' now"),
        ("proveout run part --overhang", "the name of '--overhang' is '--find-stickout' now"),
    ] {
        let error = with_new_name(parse(line).expect_err("an old option"));
        assert_eq!(error.kind(), ErrorKind::UnknownArgument, "{line}");
        let text = error.to_string();
        assert!(text.contains(tip) && text.matches("tip:").count() == 1, "{text}");
    }
    let other = with_new_name(parse("proveout run part --overhung").expect_err("no option")).to_string();
    assert!(!other.contains("now"), "{other}");
    for line in [
        "proveout run part --out a",
        "proveout job part --out a",
        "proveout compare part --out a",
        "proveout sweep plan part --out a",
        "proveout measure part --out a --force",
    ] {
        assert!(parse(line).is_ok() && parse(&line.replace("--out", "--output")).is_ok(), "{line}");
    }
    let mut help = Vec::new();
    for (name, mut command) in leaves(&Cli::command()) {
        help.push((name, command.render_long_help().to_string()));
    }
    for (name, text) in help {
        let shown = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-')).any(|word| word == "--out");
        assert!(!shown, "{name}: {text}");
    }
}

#[test]
fn a_wrong_call_is_named_as_such() {
    for (words, kind) in [
        (vec!["kinematics", "m"], ErrorKind::MissingRequiredArgument),
        (vec!["kinematics", "m", "--forward", "--inverse"], ErrorKind::ArgumentConflict),
        (vec!["kinematics", "m", "--forward", "--nearest"], ErrorKind::ArgumentConflict),
        (vec!["kinematics", "m", "--nearest"], ErrorKind::MissingRequiredArgument),
        (vec!["nc", "p", "--inch"], ErrorKind::MissingRequiredArgument),
    ] {
        let error = Cli::command().try_get_matches_from(std::iter::once("proveout").chain(words.clone()));
        assert_eq!(error.map_err(|e| e.kind()).err(), Some(kind), "{words:?}");
    }
}
