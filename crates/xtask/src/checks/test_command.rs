//! `.ci/run` runs what the README says to run, and nothing else.

use std::path::Path;

use crate::{TaskError, files};

/// The one command.
pub(crate) const COMMAND: &str = "cargo xtask ci";

/// Commands of a shell script: lines that are not empty, comments, or settings (`set`, and `export` of a
/// setting of Cargo).
fn commands(script: &str) -> Vec<&str> {
    let is_setting = |l: &str| l.starts_with("set ") || l.starts_with("export CARGO_");
    script.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#') && !is_setting(l)).collect()
}

/// Fails when script or README names another command.
pub(crate) fn check(root: &Path) -> Result<String, TaskError> {
    let script = files::get(&root.join(".ci/run"))?;
    let found = commands(&script);
    if found != ["cd \"$(dirname \"$0\")/..\"", COMMAND] {
        return Err(TaskError(format!(
            ".ci/run must go to the root and run `{COMMAND}`, nothing else; found: {found:?}"
        )));
    }
    if !files::get(&root.join("README.md"))?.lines().any(|l| l.trim() == COMMAND) {
        return Err(TaskError(format!("README.md must show the test command on a line of its own: {COMMAND}")));
    }
    Ok(format!("both say: {COMMAND}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_and_comments_are_no_commands() {
        assert_eq!(
            commands("#!/usr/bin/env bash\n\nset -euo pipefail\nexport CARGO_INCREMENTAL=0\n  cargo xtask ci\n# end\n"),
            [COMMAND]
        );
    }
}
