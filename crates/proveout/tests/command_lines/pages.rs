//! The command lines that the pages of the project and the help texts show, found by themselves: a new one
//! cannot be forgotten.
//!
//! *Where.* Every Markdown file at the root and below `docs`, `scenes`, `machines`, `tools` and `crates`. In
//! a fenced block without a language (or `sh`) each line that begins with `proveout` or `cargo` (after
//! variables such as `N=1`) is a command; text after two blanks is its description, and a backslash
//! at the end joins lines. In the running text and in tables it is the text between backticks.
//!
//! *What.* `cargo run --release -- X` is `proveout X`, with `--no-default-features` too. A product's command
//! without a positional argument (`proveout nc --post`) cannot be typed: it mentions a command. Brackets are
//! dropped, so that what may be left out is given; words in capitals mean what the table of the sandbox
//! gives them.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// A command as a page shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shown {
    /// Page and line, for people.
    pub(crate) place: String,
    /// The words, without variables before the program.
    pub(crate) words: Vec<String>,
}

impl Shown {
    /// The words of the product's command line without its name; none where another program is called.
    pub(crate) fn of_product(&self) -> Option<&[String]> {
        let words: Vec<&str> = self.words.iter().map(String::as_str).collect();
        match words.as_slice() {
            ["proveout", ..] => Some(&self.words[1..]),
            ["cargo", "run", "--release", "--", ..] => Some(&self.words[4..]),
            ["cargo", "run", "--release", "--no-default-features", "--", ..] => Some(&self.words[5..]),
            _ => None,
        }
    }

    /// Whether a product's command can be typed: it has a positional argument, or `--profile` or
    /// `--list-machines`, which replace one, or is one of the first words of clap.
    pub(crate) fn can_be_typed(&self) -> bool {
        let Some(words) = self.of_product() else { return false };
        match words.first().map(String::as_str) {
            Some("help" | "--help" | "--version" | "doctor") => true,
            _ => words.get(1).is_some_and(|w| !w.starts_with("--") || w == "--profile" || w == "--list-machines"),
        }
    }
}

/// Markdown files of the project, sorted; paths below the root.
pub(crate) fn pages(root: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(root).expect("the root").map(|e| e.expect("an entry").path()) {
        if entry.extension().is_some_and(|e| e == "md") {
            all.push(entry);
        }
    }
    for folder in ["docs", "scenes", "machines", "tools", "crates"] {
        below(&root.join(folder), &mut all);
    }
    let mut all: Vec<PathBuf> = all.into_iter().map(|p| p.strip_prefix(root).expect("below").to_owned()).collect();
    all.sort();
    all
}

fn below(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()) {
        if entry.is_dir() {
            below(&entry, all);
        } else if entry.extension().is_some_and(|e| e == "md") {
            all.push(entry);
        }
    }
}

/// Commands of a Markdown text.
pub(crate) fn commands(page: &str, text: &str) -> Vec<Shown> {
    let mut out = Vec::new();
    let mut fence: Option<bool> = None;
    let mut joined = String::new();
    // Running text up to the line, for spans that go over the end of a line.
    let mut span: Option<String> = None;
    for (number, line) in (1..).zip(text.lines()) {
        let place = format!("{page}:{number}");
        if let Some(language) = line.trim_start().strip_prefix("```") {
            fence = match fence {
                Some(_) => None,
                None => Some(matches!(language.trim(), "" | "sh" | "console")),
            };
            (span, joined) = (None, String::new());
            continue;
        }
        match fence {
            Some(true) => {
                let line = line.trim().trim_start_matches("$ ");
                if let Some(head) = line.strip_suffix('\\') {
                    joined += head;
                    continue;
                }
                let whole = std::mem::take(&mut joined) + line;
                let typed = whole.split("   ").next().unwrap_or_default();
                let typed = typed.split("  ").next().unwrap_or_default();
                out.extend(shown(&place, typed));
            }
            Some(false) => {}
            None => {
                if line.trim().is_empty() {
                    span = None;
                    continue;
                }
                for (k, part) in line.split('`').enumerate() {
                    if k > 0 {
                        // A backtick: a span ends or begins.
                        match span.take() {
                            Some(words) => out.extend(shown(&place, &words)),
                            None => span = Some(String::new()),
                        }
                    }
                    if let Some(words) = &mut span {
                        *words += part;
                    }
                }
                if let Some(words) = &mut span {
                    words.push(' ');
                }
            }
        }
    }
    out
}

/// Commands of scenes that take minutes: lines that begin with the program in a block whose language is
/// `text`.
pub(crate) fn long_commands(page: &str, text: &str) -> Vec<Shown> {
    let mut inside = false;
    let mut out = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        match line.trim_start().strip_prefix("```") {
            Some(language) => inside = !inside && language.trim() == "text",
            None if inside
                && ["run", "compare", "plan", "reschedule"]
                    .iter()
                    .any(|c| line.starts_with(&format!("proveout {c} "))) =>
            {
                out.extend(shown(&format!("{page}:{number}"), line))
            }
            None => {}
        }
    }
    out
}

/// Examples of a help text: lines that are set in and begin with the program.
pub(crate) fn examples(page: &str, help: &str) -> Vec<Shown> {
    help.lines().filter(|l| l.starts_with("  proveout ")).flat_map(|l| shown(page, l.trim())).collect()
}

/// Lines of a list of commands; `#` begins a remark.
pub(crate) fn listed(page: &str, text: &str) -> Vec<Shown> {
    let lines = (1..).zip(text.lines()).filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
    lines.flat_map(|(number, line)| shown(&format!("{page}:{number}"), line)).collect()
}

fn shown(place: &str, text: &str) -> Option<Shown> {
    let words: Vec<String> = text.split_whitespace().map(|w| w.replace(['[', ']'], "")).collect();
    let variable = |w: &String| {
        w.split_once('=').is_some_and(|(name, _)| name.bytes().all(|b| b.is_ascii_uppercase() || b == b'_'))
    };
    let words: Vec<String> = words.into_iter().skip_while(variable).collect();
    let program = words.first().is_some_and(|w| w == "proveout" || w == "cargo") && words.len() > 1;
    program.then(|| Shown { place: place.to_owned(), words })
}
