//! The registry of finding codes against the pages in `docs/findings`.

use std::{fs, path::Path};

use crate::{TaskError, files};

/// Where the codes are.
const REGISTRY: &str = "crates/proveout_sim/src/verdict/finding.rs";
/// Where the pages are.
const PAGES: &str = "docs/findings";
/// Headings of a page, in order.
const HEADINGS: [&str; 5] = ["## What it is", "## Why it matters", "## How it is found", "## Example", "## Remedy"];

/// Code, family, severity and summary of a row of `codes! { ... }`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FindingCode {
    code: String,
    family: String,
    severity: String,
    summary: String,
}

/// Rows `NAME = "code", Family, Severity, fails Gate, limit Source, "summary";` of the registry; `fails` and
/// `limit` may be missing.
fn entries(source: &str) -> Vec<FindingCode> {
    let Some((_, body)) = source.split_once("\ncodes! {") else { return Vec::new() };
    let body = body.split_once("\n}").map_or(body, |(inside, _)| inside);
    let row = |row: &str| {
        let (_, right) = row.split_once('=')?;
        let mut quoted = right.split('"');
        let (_, code, middle, summary) = (quoted.next()?, quoted.next()?, quoted.next()?, quoted.next()?);
        let mut words = middle.split(',').map(str::trim).filter(|w| !w.is_empty());
        let (family, severity) = (words.next()?, words.next()?);
        Some(FindingCode {
            code: code.into(),
            family: family.into(),
            severity: severity.into(),
            summary: summary.into(),
        })
    };
    body.split(';').filter_map(row).collect()
}

/// The first lines of a page, which repeat the registry.
fn head(entry: &FindingCode) -> String {
    format!(
        "# {}\n\n{}\n\nFamily: {}. Severity: {}.\n",
        entry.code,
        entry.summary,
        entry.family.to_lowercase(),
        entry.severity.to_lowercase()
    )
}

/// Fails with every code without a page, page without a code, and page whose head or headings differ.
pub(crate) fn check(root: &Path) -> Result<String, TaskError> {
    let entries = entries(&files::get(&root.join(REGISTRY))?);
    if entries.is_empty() {
        return Err(TaskError(format!("no `codes! {{ ... }}` found in {REGISTRY}")));
    }
    let mut faults = Vec::new();
    for entry in &entries {
        let name = format!("{PAGES}/{}.md", entry.code);
        match fs::read_to_string(root.join(&name)) {
            Err(_) => faults.push(format!("{} has no page: write {name}", entry.code)),
            Ok(page) => faults.extend(page_faults(&name, &page, entry)),
        }
    }
    let listing = fs::read_dir(root.join(PAGES)).map_err(|e| TaskError(format!("cannot list {PAGES}: {e}")))?;
    let mut pages: Vec<String> = listing
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| name.strip_suffix(".md").map(str::to_owned))
        .filter(|name| name != "README")
        .collect();
    pages.sort();
    for page in pages {
        if !entries.iter().any(|e| e.code == page) {
            faults.push(format!("{PAGES}/{page}.md explains a code that {REGISTRY} does not have"));
        }
    }
    let index = files::get(&root.join(PAGES).join("README.md"))?;
    for entry in &entries {
        if !index.contains(&format!("[`{0}`]({0}.md)", entry.code)) {
            faults.push(format!("{PAGES}/README.md does not link {0}.md: add [`{0}`]({0}.md)", entry.code));
        }
    }
    if faults.is_empty() {
        Ok(format!("{} codes, each with its page", entries.len()))
    } else {
        Err(TaskError(faults.join("\n")))
    }
}

fn page_faults(name: &str, page: &str, entry: &FindingCode) -> Vec<String> {
    let mut faults = Vec::new();
    let head = head(entry);
    if !page.starts_with(&head) {
        faults.push(format!("{name} must begin as the registry says:\n{head}"));
    }
    let found: Vec<&str> = page.lines().filter(|l| l.starts_with("## ")).collect();
    if found != HEADINGS {
        faults.push(format!("{name} has the headings {found:?}; wanted are {HEADINGS:?}"));
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "macro_rules! codes {\n    () => {};\n}\n\ncodes! {\n    STOPPED = \"program-stopped\", Program, Error, \
        fails Program, \"It stopped.\";\n    GOUGE = \"geometry-gouge\", Geometry, Error, fails Gouge, limit GougeTolerance,\n        \
        \"Too deep.\";\n    NOTE = \"program-note\", Program, Info, \"No effect.\";\n}\n\nfn f() { let a = \"b\"; }\n";

    #[test]
    fn the_registry_is_read_with_rows_on_one_line_or_two() {
        let entries = entries(SOURCE);
        assert_eq!(entries.len(), 3);
        assert_eq!(entries[0].code, "program-stopped");
        assert_eq!(entries[1].severity, "Error");
        assert_eq!(entries[1].summary, "Too deep.");
        assert_eq!(entries[2].severity, "Info");
        assert_eq!(entries[2].summary, "No effect.");
    }

    #[test]
    fn a_page_must_follow_the_form() {
        let entry = &entries(SOURCE)[0];
        let page = format!("{}\n{}\n", head(entry), HEADINGS.join("\n\ntext\n\n"));
        assert!(page_faults("p", &page, entry).is_empty());
        assert_eq!(page_faults("p", &page.replace("stopped.", "halted."), entry).len(), 1);
        assert_eq!(page_faults("p", &page.replace("## Remedy", "## Cure"), entry).len(), 1);
    }
}
