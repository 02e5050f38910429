//! The figures of the pages, from runs: `cargo xtask figures` makes the runs of `docs/figures.toml` and
//! fills the pages, `cargo xtask figures --check` makes them and compares. A figure that a page lists in its
//! block, or that is between remarks, is never typed by hand.

mod block;
mod marker;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;

use self::{
    block::all_markers,
    marker::{Marker, filled, value},
};
use crate::{
    TaskError, files,
    workspace::{Workspace, cargo},
};

/// The file that lists the runs.
const REGISTRY: &str = "docs/figures.toml";
/// Folders with pages, below the root; pages at the root too.
const FOLDERS: [&str; 5] = ["docs", "scenes", "machines", "tools", "crates"];

/// A run that figures come from.
#[derive(Clone, Debug)]
struct FigureRun {
    name: String,
    /// Words after `proveout`; `DATA` is replaced by the file of `data`.
    command: String,
    /// `docs/experiments.md` reports it.
    experiment: bool,
    /// A file that is published elsewhere, below `shared/cases` in a folder above the checkout.
    data: Option<String>,
    /// Not made by `ci`.
    long: bool,
    /// Commit and day of the figures of a long run.
    made: String,
}

/// What the call asks for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct FigureRequest {
    /// Compare, write nothing.
    pub(crate) check: bool,
    /// Take results that lie in `target/figures` from the call before.
    pub(crate) kept: bool,
    /// Runs by name; all but the long ones when empty.
    pub(crate) runs: Vec<String>,
}

impl FigureRequest {
    /// Words after `figures`.
    pub(crate) fn read(words: &[&str]) -> Result<Self, TaskError> {
        let mut out = Self::default();
        let mut rest = words.iter();
        while let Some(word) = rest.next() {
            match *word {
                "--check" => out.check = true,
                "--kept" => out.kept = true,
                "--run" => {
                    out.runs.push((*rest.next().ok_or_else(|| TaskError("--run needs a name".into()))?).to_owned())
                }
                other => return Err(TaskError(format!("unknown option of figures: {other}"))),
            }
        }
        Ok(out)
    }
}

/// A page with its figures.
struct Page {
    name: String,
    text: String,
    markers: Vec<Marker>,
}

/// Makes the runs and fills or compares the pages; gives a short account.
pub(crate) fn run(root: &Path, wanted: &FigureRequest) -> Result<String, TaskError> {
    let runs = registry(&files::get(&root.join(REGISTRY))?)?;
    let pages = pages(root)?;
    well_named(&runs, &pages)?;
    if let Some(unknown) = wanted.runs.iter().find(|name| !runs.iter().any(|r| r.name == **name)) {
        return Err(TaskError(format!("{REGISTRY} has no run {unknown:?}")));
    }
    let chosen = |r: &&FigureRun| if wanted.runs.is_empty() { !r.long } else { wanted.runs.contains(&r.name) };
    let program = program(root)?;
    let mut results: BTreeMap<String, Value> = BTreeMap::new();
    let mut left_out = Vec::new();
    for run in runs.iter().filter(chosen) {
        match made(root, &program, run, wanted)? {
            Some(mut result) => {
                let today = if wanted.check || !run.long { run.made.clone() } else { commit_and_day(root)? };
                result["@command"] = format!("proveout {}", run.command).into();
                result["@made"] = today.into();
                results.insert(run.name.clone(), result);
            }
            None => left_out.push(run.name.clone()),
        }
    }
    let account = if wanted.check { compare(&pages, &results)? } else { write(root, &runs, &pages, &results)? };
    let experiments = runs.iter().filter(|r| r.experiment && results.contains_key(&r.name));
    let folders: Vec<String> = experiments.map(|r| folder(root, r).display().to_string()).collect();
    if !folders.is_empty() {
        let check = wanted.check.then_some("--check");
        let words: Vec<&str> = check.into_iter().chain(folders.iter().map(String::as_str)).collect();
        crate::experiments(root, &words)?;
    }
    let long: Vec<&str> = runs.iter().filter(|r| !results.contains_key(&r.name)).map(|r| r.name.as_str()).collect();
    let rest = if long.is_empty() { String::new() } else { format!("; not made here: {}", long.join(", ")) };
    for name in left_out {
        println!("LEFT OUT: the figures of {name}: its data set is not next to the checkout");
    }
    Ok(account + &rest)
}

/// The runs of the registry.
fn registry(text: &str) -> Result<Vec<FigureRun>, TaskError> {
    let fault = |what: String| TaskError(format!("{REGISTRY}: {what}"));
    let table: toml::Table = toml::from_str(text).map_err(|e| fault(e.to_string()))?;
    let list = table.get("run").and_then(toml::Value::as_array).ok_or_else(|| fault("no [[run]]".into()))?;
    let mut out: Vec<FigureRun> = Vec::new();
    for entry in list {
        let entry = entry.as_table().ok_or_else(|| fault("a run is not a table".into()))?;
        let known = ["name", "command", "experiment", "data", "long", "made", "paper", "second_count"];
        if let Some(key) = entry.keys().find(|k| !known.contains(&k.as_str())) {
            return Err(fault(format!("unknown key {key:?}; a run has {}", known.join(", "))));
        }
        let text = |key: &str| entry.get(key).and_then(toml::Value::as_str).map(str::to_owned);
        let flag = |key: &str| entry.get(key).and_then(toml::Value::as_bool).unwrap_or(false);
        let run = FigureRun {
            name: text("name").ok_or_else(|| fault("a run without a name".into()))?,
            command: text("command").ok_or_else(|| fault("a run without a command".into()))?,
            experiment: flag("experiment"),
            data: text("data"),
            long: flag("long"),
            made: text("made").unwrap_or_default(),
        };
        if run.long && run.made.is_empty() {
            return Err(fault(format!("{}: a long run needs `made`, the date of its figures", run.name)));
        }
        if out.iter().any(|r| r.name == run.name) {
            return Err(fault(format!("two runs are named {}", run.name)));
        }
        out.push(run);
    }
    Ok(out)
}

fn pages(root: &Path) -> Result<Vec<Page>, TaskError> {
    let mut paths = Vec::new();
    listed(root, false, &mut paths)?;
    for folder in FOLDERS {
        listed(&root.join(folder), true, &mut paths)?;
    }
    paths.sort();
    let mut out = Vec::new();
    for path in paths {
        let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
        let text = files::get(&path)?;
        let markers = all_markers(&name, &text)?;
        if !markers.is_empty() {
            out.push(Page { name, text, markers });
        }
    }
    Ok(out)
}

fn listed(folder: &Path, below: bool, out: &mut Vec<PathBuf>) -> Result<(), TaskError> {
    let fault = |e: std::io::Error| TaskError(format!("cannot list {}: {e}", folder.display()));
    for entry in fs::read_dir(folder).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        if path.is_dir() && below {
            listed(&path, true, out)?;
        } else if path.extension().is_some_and(|e| e == "md") {
            out.push(path);
        }
    }
    Ok(())
}

/// Every figure names a run that there is, and every run has a figure.
fn well_named(runs: &[FigureRun], pages: &[Page]) -> Result<(), TaskError> {
    let mut faults = Vec::new();
    for (page, marker) in pages.iter().flat_map(|p| p.markers.iter().map(move |m| (p, m))) {
        match runs.iter().find(|r| r.name == marker.run) {
            None => faults.push(format!("{}:{}: {REGISTRY} has no run {:?}", page.name, marker.line, marker.run)),
            Some(_) if marker.bound.is_some() && !marker.of_surface() => faults.push(format!(
                "{}:{}: {} depends on the motion alone, which is compared exactly: omit the bound",
                page.name, marker.line, marker.key
            )),
            Some(_) => {}
        }
    }
    for run in runs {
        // An experiment has its section of docs/experiments.md.
        if !run.experiment && !pages.iter().flat_map(|p| &p.markers).any(|m| m.run == run.name) {
            faults.push(format!("{REGISTRY}: no page has a figure of the run {:?}", run.name));
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(TaskError(faults.join("\n"))) }
}

/// The product as the tests build it, so that `ci` builds it once.
fn program(root: &Path) -> Result<PathBuf, TaskError> {
    let build = ["test", "--quiet", "--workspace", "--locked", "--no-run", "--test", "cli"];
    let status = Command::new(cargo()).args(build).current_dir(root).status();
    if !status.map_err(|e| TaskError(format!("cannot start cargo: {e}")))?.success() {
        return Err(TaskError("the product could not be built".into()));
    }
    Ok(Workspace::read(root)?.target.join("debug").join(format!("proveout{}", std::env::consts::EXE_SUFFIX)))
}

/// Where a run lies.
fn folder(root: &Path, run: &FigureRun) -> PathBuf {
    root.join("target/figures").join(&run.name)
}

/// The result of a run; `None` where its data set is not there.
fn made(root: &Path, program: &Path, run: &FigureRun, wanted: &FigureRequest) -> Result<Option<Value>, TaskError> {
    let folder = folder(root, run);
    let result = folder.join(if run.command.starts_with("compare") { "compare.json" } else { "verdict.json" });
    if !(wanted.kept && result.is_file()) {
        let data = match &run.data {
            None => None,
            Some(data) => {
                let beside = root.ancestors().skip(1).take(2).map(|up| up.join("shared/cases").join(data));
                let Some(found) = beside.into_iter().find(|p| p.is_file()) else { return Ok(None) };
                Some(found)
            }
        };
        let mut command = Command::new(program);
        command.current_dir(root);
        for word in run.command.split_whitespace() {
            match (&data, word) {
                (Some(data), "DATA") => command.arg(data),
                _ => command.arg(word),
            };
        }
        command.arg("--output").arg(&folder);
        println!("proveout {}", run.command);
        let output = command.output().map_err(|e| TaskError(format!("cannot start {}: {e}", program.display())))?;
        // 1: the verdict is fail, 3: unchecked; both are results.
        if !matches!(output.status.code(), Some(0 | 1 | 3)) {
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            return Err(TaskError(format!("{}: {}\n{told}", run.name, output.status)));
        }
    }
    let text = files::get(&result)?;
    let fault = |e: serde_json::Error| TaskError(format!("{}: {e}", result.display()));
    Ok(Some(serde_json::from_str(&text).map_err(fault)?))
}

/// Commit and day, for figures that `ci` does not make again.
fn commit_and_day(root: &Path) -> Result<String, TaskError> {
    let output = Command::new("git").args(["log", "-1", "--format=commit %h of %cs"]).current_dir(root).output();
    let output = output.map_err(|e| TaskError(format!("cannot start git: {e}")))?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// The text of a figure from the results; none where its run was not made.
fn text_of(page: &Page, marker: &Marker, results: &BTreeMap<String, Value>) -> Result<Option<String>, TaskError> {
    let Some(result) = results.get(&marker.run) else { return Ok(None) };
    let fault = |e: String| TaskError(format!("{}:{}: run {}: {e}", page.name, marker.line, marker.run));
    let found = if marker.key.starts_with('@') { Ok(&result[marker.key.as_str()]) } else { value(result, &marker.key) };
    marker.text(found.map_err(fault)?).map(Some).map_err(fault)
}

fn compare(pages: &[Page], results: &BTreeMap<String, Value>) -> Result<String, TaskError> {
    let (mut count, mut faults) = (0, Vec::new());
    for (page, marker) in pages.iter().flat_map(|p| p.markers.iter().map(move |m| (p, m))) {
        let Some(now) = text_of(page, marker, results)? else { continue };
        count += 1;
        let said = &page.text[marker.span.clone()];
        if !marker.agree(said, &now) {
            faults.push(format!(
                "{}:{}: {} of {}: the page says {said}, the run {now}",
                page.name, marker.line, marker.key, marker.run
            ));
        }
    }
    if faults.is_empty() {
        return Ok(format!("{count} figures are those of their runs"));
    }
    Err(TaskError(format!("{}\nremedy: cargo xtask figures, then review the changes", faults.join("\n"))))
}

fn write(
    root: &Path,
    runs: &[FigureRun],
    pages: &[Page],
    results: &BTreeMap<String, Value>,
) -> Result<String, TaskError> {
    let mut changed = 0;
    for page in pages {
        let texts = page.markers.iter().map(|m| text_of(page, m, results)).collect::<Result<Vec<_>, _>>()?;
        let text = filled(&page.text, &page.markers, &texts);
        if text != page.text {
            changed += 1;
            println!("{}", page.name);
        }
        files::put(&root.join(&page.name), &text, false, "cargo xtask figures")?;
    }
    // The registry also records when the figures of a long run were made.
    let path = root.join(REGISTRY);
    let mut registry = files::get(&path)?;
    for run in runs.iter().filter(|r| r.long) {
        if let Some(made) = results.get(&run.name).and_then(|r| r["@made"].as_str()) {
            registry = registry.replace(&format!("made = {:?}", run.made), &format!("made = {made:?}"));
        }
    }
    files::put(&path, &registry, false, "cargo xtask figures")?;
    Ok(format!("{changed} pages have other figures now"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGISTERED: &str = "[[run]]\nname = \"r\"\ncommand = \"run scenes/s\"\n";

    fn page(text: &str) -> Page {
        Page { name: "p.md".into(), text: text.into(), markers: all_markers("p.md", text).expect("figures") }
    }

    #[test]
    fn the_figures_of_the_pages_are_well_named() {
        let root = crate::workspace_root();
        let runs = registry(&files::get(&root.join(REGISTRY)).expect("the registry")).expect("runs");
        well_named(&runs, &pages(&root).expect("pages")).expect("well named");
    }

    #[test]
    fn a_run_without_figures_a_figure_without_run_and_a_bound_on_motion_are_faults() {
        let runs = registry(REGISTERED).expect("a run");
        let fault_of = |text: &str| well_named(&runs, &[page(text)]).expect_err(text).0;
        assert!(fault_of("<!--= q time.total_s .1 -->1<!--/-->").contains("no run \"q\""));
        assert!(fault_of("<!--= r time.total_s .1 +-1 -->1<!--/-->").contains("compared exactly"));
        assert!(well_named(&runs, &[]).expect_err("no figure").0.contains("no page has"));
        well_named(&runs, &[page("<!--= r deviation.rms_mm .1 +-1 -->1<!--/-->")]).expect("in order");
        assert!(
            registry("[[run]]\nname = \"r\"\ncommand = \"run s\"\nlong = true\n")
                .expect_err("undated")
                .0
                .contains("made")
        );
        assert!(registry("[[run]]\nname = \"r\"\ncomand = \"run s\"\n").expect_err("misspelt").0.contains("comand"));
    }

    #[test]
    fn what_differs_is_reported_with_its_page_and_line() {
        let results = |total: f64, rms: f64| {
            let result = serde_json::json!({"time": {"total_s": total}, "deviation": {"rms_mm": rms}});
            BTreeMap::from([("r".to_owned(), result)])
        };
        let text =
            "\n<!--= r time.total_s .1 -->5.0<!--/--> s, <!--= r deviation.rms_mm .1um +-0.3 -->2.0<!--/--> µm\n";
        let pages = [page(text)];
        assert_eq!(compare(&pages, &results(5.0, 0.0022)).expect("agrees"), "2 figures are those of their runs");
        let TaskError(told) = compare(&pages, &results(5.1, 0.0024)).expect_err("differs");
        assert!(told.contains("p.md:2: time.total_s of r: the page says 5.0, the run 5.1"), "{told}");
        assert!(told.contains("rms_mm") && told.contains("remedy: cargo xtask figures"), "{told}");
    }

    #[test]
    fn words_after_figures() {
        let wanted = FigureRequest::read(&["--check", "--run", "li", "--kept"]).expect("words");
        assert_eq!(wanted, FigureRequest { check: true, kept: true, runs: vec!["li".into()] });
        assert!(FigureRequest::read(&["--chek"]).is_err() && FigureRequest::read(&["--run"]).is_err());
    }
}
