//! `cargo xtask quick`: format, lints and tests of the crates that a change touches, for the minutes between
//! two edits.

use std::{collections::BTreeSet, path::Path, process::Command, time::Instant};

use crate::{
    TaskError,
    test_programs::{self, TestSelection},
    workspace::{Member, Workspace, cargo},
};

/// Checks the crates with files that differ from `reference` (a commit), new files included.
pub(crate) fn run(root: &Path, reference: &str) -> Result<(), TaskError> {
    let start = Instant::now();
    let mut paths = git(root, &["diff", "--name-only", reference])?;
    paths += &git(root, &["ls-files", "--others", "--exclude-standard"])?;
    let workspace = Workspace::read(root)?;
    let packages: Vec<&str> = touched(&workspace.members, root, &paths).into_iter().collect();
    call(root, &["fmt", "--all", "--check"])?;
    if packages.is_empty() {
        println!("no crate differs from {reference}; format checked");
        return Ok(());
    }
    println!("crates that differ from {reference}: {}", packages.join(", "));
    let selected: Vec<&str> = packages.iter().flat_map(|p| ["--package", *p]).collect();
    call(root, &[&["clippy", "--locked", "--all-targets"], selected.as_slice(), &["--", "-D", "warnings"]].concat())?;
    let slowest = test_programs::run(root, &packages, TestSelection::Usual, &mut |line| println!("{line}"))?;
    println!("{slowest}\nquick passed in {:.1} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// Packages whose folder holds one of the paths (one a line, from the root).
fn touched<'a>(members: &'a [Member], root: &Path, paths: &str) -> BTreeSet<&'a str> {
    let in_member = |member: &Member, path: &str| root.join(path).starts_with(&member.folder);
    members.iter().filter(|m| paths.lines().any(|path| in_member(m, path))).map(|m| m.name.as_str()).collect()
}

fn git(root: &Path, words: &[&str]) -> Result<String, TaskError> {
    let output = Command::new("git")
        .args(words)
        .current_dir(root)
        .output()
        .map_err(|e| TaskError(format!("cannot start git: {e}")))?;
    if !output.status.success() {
        return Err(TaskError(String::from_utf8_lossy(&output.stderr).trim().to_owned()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn call(root: &Path, words: &[&str]) -> Result<(), TaskError> {
    println!("cargo {}", words.join(" "));
    let status = Command::new(cargo())
        .args(words)
        .current_dir(root)
        .status()
        .map_err(|e| TaskError(format!("cannot start cargo: {e}")))?;
    if status.success() { Ok(()) } else { Err(TaskError(format!("failed: cargo {}", words.join(" ")))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_names_the_crate_of_its_folder() {
        let member = |name: &str, folder: &str| Member {
            name: name.into(),
            folder: Path::new("/w").join(folder),
            dependencies: vec![],
        };
        let members = [member("a", "crates/a"), member("ab", "crates/ab"), member("tests", "tests")];
        let found = touched(&members, Path::new("/w"), "crates/ab/src/lib.rs\nREADME.md\ntests/main.rs\n");
        assert_eq!(found, BTreeSet::from(["ab", "tests"]));
    }
}
