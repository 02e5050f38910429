//! `docs/experiments.md` from the results of comparisons; no number in it is typed.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use proveout_sim::compare::{Comparison, markdown};

use crate::{TaskError, files};

const HEAD: &str = "\
# Published experiments, repeated

Each section compares an original program with re-scheduled ones on the same twin. `cargo xtask figures` writes this page from the
`compare.json` of `proveout compare`; no number in it is typed. A section begins with the commit, the command, the cells of the stock and the
digests of all inputs. The README of its scene states what was published, what was chosen, and what must happen.

`cargo xtask nightly` repeats the runs that take a minute and compares them with this page; `cargo xtask figures --run NAME` makes the others. The tests make
all of them at coarse cells, and compare digests and motion with this page, so that no section can be older than what it describes.

| verdict on a published value | meaning |
|---|---|
| `reproduced` | it lies in the range of ours over the choices one at a time and the twin, and ours has its sign everywhere |
| `possible` | only draws of all choices at once come as far, or a choice turns the sign |
| `not` | it lies outside of all that was tried |

A wider range reproduces more: read it with the other columns. A value that the publication does not state in numbers is marked: `from a figure`, or
`own count`, a second count of our own, with which ours may agree and which reproduces nothing.

";

/// Begin of the line that says when a section was written.
const WRITTEN: &str = "Written at commit ";
/// Start of the line with the command that made a section. It differs from what a person types, since tests
/// run the commands on pages, and some of these take minutes.
const MADE: &str = "Made by proveout: `";
/// Hexadecimal digits of a digest that are shown.
const SHOWN: usize = 12;

/// Writes sections of the page from folders of comparisons and keeps the others; with `--check` first, only
/// compares.
pub(crate) fn run(root: &Path, words: &[&str]) -> Result<(), TaskError> {
    let (check, folders) = match words {
        ["--check", folders @ ..] => (true, folders),
        folders => (false, folders),
    };
    let path = root.join("docs/experiments.md");
    let before = fs::read_to_string(&path).unwrap_or_default();
    let mut sections = sections(&before);
    let now = commit(root)?;
    for folder in folders {
        let path = PathBuf::from(folder).join("compare.json");
        let text = files::get(&path)?;
        let comparison: Comparison = serde_json::from_str(&text)
            .map_err(|e| TaskError(format!("{}:{}:{}: {e}", path.display(), e.line(), e.column())))?;
        let section = markdown(&comparison);
        let (head, rest) = section.split_once("\n\n").unwrap_or((&section, ""));
        let known = sections.iter_mut().find(|s| heading(s) == head);
        // When it was written is not compared: the commit that holds the page comes after it.
        let before = known.as_deref().and_then(|s| s.lines().find(|l| l.starts_with(WRITTEN))).filter(|_| check);
        let written = before.unwrap_or(&now);
        let shown = drawn(root, folder, check)?;
        let text =
            format!("{head}\n\n{written}\n\n{}\n\n{shown}{}\n", origin(root, folder, &comparison)?, rest.trim_end());
        match known {
            Some(known) => *known = text,
            None => sections.push(text),
        }
    }
    // In the order of the registry; a section that no run makes any longer goes.
    let commands = commands(root)?;
    let place = |section: &String| {
        let made = section.lines().find_map(|l| l.strip_prefix(MADE))?.split('`').next()?;
        commands.iter().position(|c| c == made)
    };
    let mut placed: Vec<(usize, String)> = sections.into_iter().filter_map(|s| Some((place(&s)?, s))).collect();
    placed.sort();
    let page = HEAD.to_owned() + &placed.into_iter().map(|(_, text)| text).collect::<Vec<_>>().join("\n");
    files::put(&path, &(page.trim_end().to_owned() + "\n"), check, "cargo xtask figures")?;
    println!("{}", path.display());
    Ok(())
}

/// Sections of the page, each from its heading on.
fn sections(page: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for line in page.lines() {
        if line.starts_with("## ") {
            out.push(String::new());
        }
        if let Some(last) = out.last_mut() {
            *last += line;
            last.push('\n');
        }
    }
    out.iter_mut().for_each(|s| *s = s.trim_end().to_owned() + "\n");
    out
}

fn heading(section: &str) -> &str {
    section.lines().next().unwrap_or_default()
}

/// Commands of the experiments, in the order of the registry.
fn commands(root: &Path) -> Result<Vec<String>, TaskError> {
    let runs = registry(root)?;
    let experiment = |r: &&toml::Value| r.get("experiment").and_then(toml::Value::as_bool).unwrap_or(false);
    let command = |r: &toml::Value| r.get("command").and_then(toml::Value::as_str).map(str::to_owned);
    Ok(runs.iter().filter(experiment).filter_map(command).collect())
}

fn registry(root: &Path) -> Result<Vec<toml::Value>, TaskError> {
    let table: toml::Table = toml::from_str(&files::get(&root.join("docs/figures.toml"))?)
        .map_err(|e| TaskError(format!("docs/figures.toml: {e}")))?;
    Ok(table.get("run").and_then(toml::Value::as_array).cloned().unwrap_or_default())
}

/// Commit that the page is written at, and whether other files have changed since.
fn commit(root: &Path) -> Result<String, TaskError> {
    let git = |words: &[&str]| -> Result<String, TaskError> {
        let output = Command::new("git").args(words).current_dir(root).output();
        let output = output.map_err(|e| TaskError(format!("cannot start git: {e}")))?;
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let changed = git(&["status", "--porcelain", "--", "crates", "machines", "scenes", "tools"])?;
    let changed = if changed.is_empty() { "" } else { ", with changes that were not committed yet" };
    Ok(format!("{WRITTEN}{}{changed}.", git(&["log", "-1", "--format=%h of %cs"])?))
}

/// Drawings that a comparison writes with its results, and what they show.
const DRAWINGS: [(&str, &str); 2] = [
    ("published-ranges.svg", "Published values and ours, with the ranges of ours over choices, draws and twin"),
    ("gain-over-limit.svg", "Time saved over the velocity limit of a joint, and what the best schedule would save"),
];

/// Puts the drawings of a comparison next to the page, and shows them.
fn drawn(root: &Path, folder: &str, check: bool) -> Result<String, TaskError> {
    let name = Path::new(folder).file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let mut shown = String::new();
    for (file, words) in DRAWINGS {
        let Ok(text) = fs::read_to_string(Path::new(folder).join(file)) else { continue };
        let path = format!("pictures/experiments/{name}-{file}");
        files::put(&root.join("docs").join(&path), &text, check, "cargo xtask figures")?;
        shown += &format!("![{words}]({path})\n\n");
    }
    Ok(shown)
}

/// What a comparison was made by, and from what.
fn origin(root: &Path, folder: &str, c: &Comparison) -> Result<String, TaskError> {
    let name = Path::new(folder).file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let runs = registry(root)?;
    let run = |key: &str| {
        let of = |r: &toml::Value, key: &str| r.get(key).and_then(toml::Value::as_str).map(str::to_owned);
        runs.iter().find(|r| of(r, "name").as_deref() == Some(&name)).and_then(|r| of(r, key))
    };
    let mut out = match run("command") {
        Some(command) => format!("{MADE}{command}`"),
        None => "Made by proveout: `compare`".to_owned(),
    };
    let [x, y, z] = c.cells_mm;
    let own = if c.scene_cells { "those of the scene" } else { "not those of the scene" };
    if c.motion_only {
        out += ", motion alone: nothing is cut.";
    } else {
        out += &format!(" at cells of {x} x {y} x {z} mm, {own}.");
    }
    if let Some(second) = run("second_count") {
        out += &format!(" Second count by other code, run by hand: `{second}`.");
    }
    let short = |digest: &String| digest.chars().take(SHOWN).collect::<String>();
    let mut seen: Vec<String> = Vec::new();
    for (name, program) in c.order.iter().filter_map(|n| c.programs.get_key_value(n)) {
        for (role, digest) in &program.digests {
            let of = if role.contains("program") { format!(" ({name})") } else { String::new() };
            let entry = format!("{role}{of} `{}`", short(digest));
            if !seen.contains(&entry) {
                seen.push(entry);
            }
        }
    }
    Ok(format!("{out} SHA-256: {}.", seen.join(", ")))
}
