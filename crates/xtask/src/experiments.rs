//! `docs/experiments.md` from the results of comparisons; no number in it is typed.

use std::path::{Path, PathBuf};

use proveout_sim::compare::{Comparison, markdown};

use crate::{Failure, files};

const HEAD: &str = "\
# Published experiments, repeated

Original against re-scheduled program on the same twin. This page is written by `cargo xtask figures` from the
`compare.json` of `proveout compare`; no number in it is typed. Each section names its scene; the scene's README tells what was
published, what was chosen, and what must happen.

";

/// Writes the page from folders of comparisons; with `--check` first, only compares.
pub(crate) fn run(root: &Path, words: &[&str]) -> Result<(), Failure> {
    let (check, folders) = match words {
        ["--check", folders @ ..] => (true, folders),
        folders => (false, folders),
    };
    let mut page = HEAD.to_owned();
    for folder in folders {
        let path = PathBuf::from(folder).join("compare.json");
        let text = files::get(&path)?;
        let comparison: Comparison = serde_json::from_str(&text)
            .map_err(|e| Failure(format!("{}:{}:{}: {e}", path.display(), e.line(), e.column())))?;
        page += &markdown(&comparison);
        page.push('\n');
    }
    let path = root.join("docs/experiments.md");
    files::put(&path, &(page.trim_end().to_owned() + "\n"), check, "cargo xtask figures")?;
    println!("{}", path.display());
    Ok(())
}
