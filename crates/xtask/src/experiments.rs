//! `docs/experiments.md` from the results of comparisons; no number in it is typed.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use proveout_sim::compare::{Comparison, markdown};

use crate::{Failure, files};

const HEAD: &str = "\
# Published experiments, repeated

Original against re-scheduled program on the same twin. This page is written by `cargo xtask figures` from the
`compare.json` of `proveout compare`; no number in it is typed. Each section names its scene; the scene's README tells what was
published, what was chosen, and what must happen. Under each heading stand the command, the cells of the stock and digests of all
inputs; `cargo xtask ci` makes the runs again and compares this page, so that it cannot be older than what it tells of.

";

/// Begin of the line that says when the page was written.
const WRITTEN: &str = "Written at commit ";
/// Hexadecimal digits of a digest that are shown.
const SHOWN: usize = 12;

/// Writes the page from folders of comparisons; with `--check` first, only compares.
pub(crate) fn run(root: &Path, words: &[&str]) -> Result<(), Failure> {
    let (check, folders) = match words {
        ["--check", folders @ ..] => (true, folders),
        folders => (false, folders),
    };
    let path = root.join("docs/experiments.md");
    // When it was written is not compared: the commit that holds the page comes after it.
    let before = fs::read_to_string(&path).unwrap_or_default();
    let written = before.lines().find(|l| l.starts_with(WRITTEN)).filter(|_| check).map(str::to_owned);
    let written = written.map_or_else(|| commit(root), Ok)?;
    let mut page = format!("{HEAD}{written}\n\n");
    for folder in folders {
        let path = PathBuf::from(folder).join("compare.json");
        let text = files::get(&path)?;
        let comparison: Comparison = serde_json::from_str(&text)
            .map_err(|e| Failure(format!("{}:{}:{}: {e}", path.display(), e.line(), e.column())))?;
        let section = markdown(&comparison);
        let (head, rest) = section.split_once("\n\n").unwrap_or((&section, ""));
        page += &format!("{head}\n\n{}\n\n{rest}\n", origin(root, folder, &comparison)?);
    }
    files::put(&path, &(page.trim_end().to_owned() + "\n"), check, "cargo xtask figures")?;
    println!("{}", path.display());
    Ok(())
}

/// Commit that the page is written at, and whether files beside it have changed since.
fn commit(root: &Path) -> Result<String, Failure> {
    let git = |words: &[&str]| -> Result<String, Failure> {
        let output = Command::new("git").args(words).current_dir(root).output();
        let output = output.map_err(|e| Failure(format!("cannot start git: {e}")))?;
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let changed = git(&["status", "--porcelain", "--", "crates", "machines", "scenes", "tools"])?;
    let changed = if changed.is_empty() { "" } else { ", with changes that were not committed yet" };
    Ok(format!("{WRITTEN}{}{changed}.", git(&["log", "-1", "--format=%h of %cs"])?))
}

/// What a comparison was made by, and from what.
fn origin(root: &Path, folder: &str, c: &Comparison) -> Result<String, Failure> {
    let name = Path::new(folder).file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let registry: toml::Table = toml::from_str(&files::get(&root.join("docs/figures.toml"))?)
        .map_err(|e| Failure(format!("docs/figures.toml: {e}")))?;
    let runs = registry.get("run").and_then(toml::Value::as_array).into_iter().flatten();
    let run = |key: &str| {
        let of = |r: &toml::Value, key: &str| r.get(key).and_then(toml::Value::as_str).map(str::to_owned);
        runs.clone().find(|r| of(r, "name").as_deref() == Some(&name)).and_then(|r| of(r, key))
    };
    let mut out = match run("command") {
        Some(command) => format!("Made by `proveout {command}`"),
        None => "Made by `proveout compare`".to_owned(),
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
