//! `docs/` as a book: every page is in `docs/SUMMARY.md`, and every link of every page leads somewhere.
//!
//! It needs no `mdbook`, which takes minutes to install: what it would refuse is found here, and links that
//! leave the book as well.

use std::{
    collections::BTreeSet,
    fs,
    path::{Component, Path, PathBuf},
};

use crate::{TaskError, files};

/// Folders with pages, in addition to those at the root.
const FOLDERS: [&str; 6] = ["docs", "scenes", "machines", "tools", "crates", "controls"];
/// The list of pages of the book.
const SUMMARY: &str = "docs/SUMMARY.md";

/// Fails with every page that is missing, doubled, or has a link that leads nowhere.
pub(crate) fn check(root: &Path) -> Result<String, TaskError> {
    let mut pages = Vec::new();
    below(root, root, false, &mut pages)?;
    for folder in FOLDERS {
        below(root, &root.join(folder), true, &mut pages)?;
    }
    pages.sort();
    let mut faults = Vec::new();
    let mut count = 0;
    for page in &pages {
        for link in links(&files::get(&root.join(page))?) {
            count += 1;
            let target = resolved(page, &link);
            if target.as_ref().is_none_or(|t| !root.join(t).exists()) {
                faults.push(format!("{}: broken link {link}", page.display()));
            }
        }
    }
    let listed: Vec<PathBuf> =
        links(&files::get(&root.join(SUMMARY))?).iter().filter_map(|l| resolved(Path::new(SUMMARY), l)).collect();
    let known: BTreeSet<&PathBuf> = listed.iter().collect();
    if known.len() < listed.len() {
        faults.push(format!("{SUMMARY} lists a page twice"));
    }
    for page in pages.iter().filter(|p| p.starts_with("docs") && *p != Path::new(SUMMARY)) {
        if !known.contains(page) {
            faults.push(format!("{SUMMARY} does not list {}", page.display()));
        }
    }
    if faults.is_empty() {
        Ok(format!("{} pages in the book, {count} links on {} pages", listed.len(), pages.len()))
    } else {
        Err(TaskError(faults.join("\n")))
    }
}

/// Markdown files of a folder, as paths from the root.
fn below(root: &Path, folder: &Path, deep: bool, pages: &mut Vec<PathBuf>) -> Result<(), TaskError> {
    let fault = |e: std::io::Error| TaskError(format!("{}: {e}", folder.display()));
    for entry in fs::read_dir(folder).map_err(fault)? {
        let path = entry.map_err(fault)?.path();
        if path.is_dir() && deep {
            below(root, &path, true, pages)?;
        } else if path.is_file() && path.extension().is_some_and(|e| e == "md") {
            pages.extend(path.strip_prefix(root).map(Path::to_owned));
        }
    }
    Ok(())
}

/// Targets of the links and pictures of a page that stay in the project: without addresses, places in the
/// page itself, and code.
fn links(text: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut fenced = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
            continue;
        }
        if fenced {
            continue;
        }
        // Text between backticks is code.
        let plain: String = line.split('`').step_by(2).collect::<Vec<_>>().join("code");
        for part in plain.split("](").skip(1) {
            let Some((target, _)) = part.split_once(')') else { continue };
            let target = target.split('#').next().unwrap_or_default().trim();
            if !target.is_empty() && !target.contains("://") && !target.starts_with("mailto:") {
                out.push(target.to_owned());
            }
        }
    }
    out
}

/// A link as a path from the root; none where it leaves the project.
fn resolved(page: &Path, link: &str) -> Option<PathBuf> {
    let mut path = page.parent().map_or_else(PathBuf::new, Path::to_owned);
    for part in Path::new(link).components() {
        match part {
            Component::Normal(name) => path.push(name),
            Component::ParentDir => {
                if !path.pop() {
                    return None;
                }
            }
            Component::CurDir => {}
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_those_that_a_reader_can_follow() {
        let text = "[a](b.md#part) ![c](d.png) `[no](code.md)` [w](https://x.org/y) [here](#part)\n```\n[no](fence.md)\n```\n[e](../f)";
        assert_eq!(links(text), ["b.md", "d.png", "../f"]);
    }

    #[test]
    fn a_link_is_followed_from_its_page() {
        let from = |link| resolved(Path::new("docs/findings/x.md"), link);
        assert_eq!(from("../plan.md"), Some(PathBuf::from("docs/plan.md")));
        assert_eq!(from("../../README.md"), Some(PathBuf::from("README.md")));
        assert_eq!(from("./y.md"), Some(PathBuf::from("docs/findings/y.md")));
        assert_eq!(from("../../../../etc"), None);
        assert_eq!(from("/etc/hosts"), None);
    }

    #[test]
    fn the_pages_of_this_project_hold() {
        check(&crate::workspace_root()).unwrap_or_else(|e| panic!("{}", e.0));
    }
}
