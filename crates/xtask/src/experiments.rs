//! `docs/experiments.md` and its pages, one a paper, from the results of comparisons; no number in them is
//! typed.
//!
//! A page holds a section for each comparison of its paper, and each section begins with its headlines. The
//! first page shows the headlines of all sections in one table.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use proveout_sim::compare::{Comparison, HEADLINES, headlines, markdown};

use crate::{TaskError, files};

const HEAD: &str = "\
# Published experiments, repeated

What five papers state, and what the twin gives for it. Each value was measured on the simulated part or motion by the command at the head of its
section.

| verdict | meaning |
|---|---|
| agrees | ours lies within 10 percent of the published value, under the choices of the scene |
| compatible | the published value lies in the range of ours over what the paper leaves open |
| not reproduced | it lies outside of everything that was tried |
| not comparable | the paper does not define it, or it was not measured here |

A wide range is compatible with much. Read the verdict together with three columns: the range, the *null program* (the simplest plan, without the
method: where it does as well, the value says little about the method), and the choice that moves our value most.

## Headlines

";

const TAIL: &str = "
## How the pages are made

| page | paper |
|---|---|
";

const END: &str = "
`cargo xtask figures` writes these pages from the `compare.json` of `proveout compare`; no number in them is typed. A section begins with the commit, the
command, the cells of the stock and the digests of all inputs. The README of its scene states what was published, what was chosen, and what must
happen. A time saved whose error reaches zero is marked `no gain shown`. Values of a second count by other code of ours are in tables of their own.

`cargo xtask nightly` repeats the runs that take a minute and compares them with these pages; `cargo xtask figures --run NAME` makes the others. The tests
make all of them at coarse cells, and compare digests and motion with these pages, so that no section can be older than what it describes.
";

/// Title of the table of headlines in a section.
const OWN_HEADLINES: &str = "### Headlines\n\n";

/// Begin of the line that says when a section was written.
const WRITTEN: &str = "Written at commit ";
/// Start of the line with the command that made a section. It differs from what a person types, since tests
/// run the commands on pages, and some of these take minutes.
const MADE: &str = "Made by proveout: `";
/// Hexadecimal digits of a digest that are shown.
const SHOWN: usize = 12;

/// Writes sections of the pages from folders of comparisons and keeps the others; with `--check` first, only
/// compares.
pub(crate) fn run(root: &Path, words: &[&str]) -> Result<(), TaskError> {
    let (check, folders) = match words {
        ["--check", folders @ ..] => (true, folders),
        folders => (false, folders),
    };
    let papers = papers(root)?;
    let mut sections: Vec<String> = Vec::new();
    for paper in &papers {
        sections.extend(self::sections(&fs::read_to_string(root.join(paper.path())).unwrap_or_default()));
    }
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
        let made = origin(root, folder, &comparison)?;
        let paper = papers.iter().find(|p| made_by(&made).is_some_and(|c| p.commands.contains(&c)));
        let link = paper.map_or_else(String::new, |p| format!("experiments/{}.md#{}", p.name, comparison.scene));
        let own = match headlines(&comparison, &link) {
            rows if rows.is_empty() => String::new(),
            rows => format!("{OWN_HEADLINES}{HEADLINES}{rows}\n"),
        };
        let text = format!("{head}\n\n{written}\n\n{made}\n\n{shown}{own}{}\n", rest.trim_end());
        match known {
            Some(known) => *known = text,
            None => sections.push(text),
        }
    }
    let mut first = HEAD.to_owned() + HEADLINES;
    let mut list = String::new();
    for paper in &papers {
        // In the order of the registry; a section that no run makes any longer goes.
        let place = |s: &String| paper.commands.iter().position(|c| made_by(s).as_deref() == Some(c));
        let mut placed: Vec<(usize, &String)> = sections.iter().filter_map(|s| Some((place(s)?, s))).collect();
        placed.sort();
        let all: Vec<&str> = placed.iter().map(|(_, text)| text.as_str()).collect();
        let title = format!("# {}\n\nOne of the [published experiments](../experiments.md).\n\n", paper.title);
        let page = (title + &all.join("\n").replace("](experiments/", "](")).trim_end().to_owned() + "\n";
        files::put(&root.join(paper.path()), &page, check, "cargo xtask figures")?;
        list += &format!("| [{0}](experiments/{0}.md) | {1} |\n", paper.name, paper.title);
        for (_, text) in placed {
            let own =
                text.split_once(&format!("{OWN_HEADLINES}{HEADLINES}")).and_then(|(_, rest)| rest.split_once("\n\n"));
            if let Some((rows, _)) = own {
                first += &rows.replace("](", "](experiments/").replace("(experiments/experiments/", "(experiments/");
                first.push('\n');
            }
        }
    }
    first += &(TAIL.to_owned() + &list + END);
    let path = root.join("docs/experiments.md");
    files::put(&path, &first, check, "cargo xtask figures")?;
    println!("{}", path.display());
    Ok(())
}

/// A page of sections.
struct Paper {
    name: String,
    title: String,
    /// Commands of its sections, in their order.
    commands: Vec<String>,
}

impl Paper {
    fn path(&self) -> String {
        format!("docs/experiments/{}.md", self.name)
    }
}

/// The command that made a section.
fn made_by(section: &str) -> Option<String> {
    section.lines().find_map(|l| l.strip_prefix(MADE))?.split('`').next().map(str::to_owned)
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

/// The pages with the commands of their experiments, in the order of the registry.
fn papers(root: &Path) -> Result<Vec<Paper>, TaskError> {
    let text = |r: &toml::Value, key: &str| r.get(key).and_then(toml::Value::as_str).map(str::to_owned);
    let mut papers: Vec<Paper> = Vec::new();
    for paper in registry(root, "paper")? {
        let (Some(name), Some(title)) = (text(&paper, "name"), text(&paper, "title")) else {
            return Err(TaskError("docs/figures.toml: a paper needs `name` and `title`".into()));
        };
        papers.push(Paper { name, title, commands: Vec::new() });
    }
    for run in registry(root, "run")? {
        let (Some(name), Some(command)) = (text(&run, "paper"), text(&run, "command")) else { continue };
        match papers.iter_mut().find(|p| p.name == name) {
            Some(paper) => paper.commands.push(command),
            None => return Err(TaskError(format!("docs/figures.toml: there is no paper {name:?}"))),
        }
    }
    Ok(papers)
}

fn registry(root: &Path, list: &str) -> Result<Vec<toml::Value>, TaskError> {
    let table: toml::Table = toml::from_str(&files::get(&root.join("docs/figures.toml"))?)
        .map_err(|e| TaskError(format!("docs/figures.toml: {e}")))?;
    Ok(table.get(list).and_then(toml::Value::as_array).cloned().unwrap_or_default())
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
        shown += &format!("![{words}](../{path})\n\n");
    }
    Ok(shown)
}

/// What a comparison was made by, and from what.
fn origin(root: &Path, folder: &str, c: &Comparison) -> Result<String, TaskError> {
    let name = Path::new(folder).file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let runs = registry(root, "run")?;
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
