//! Files that are made by a program and kept in the repository.

use std::{fs, path::Path};

use crate::TaskError;

/// Writes the file where its content differs; with `check`, a difference is a failure and nothing is written.
pub(crate) fn put(path: &Path, content: &str, check: bool, command: &str) -> Result<(), TaskError> {
    put_bytes(path, content.as_bytes(), check, command)
}

/// As [`put`], for files that are no text.
pub(crate) fn put_bytes(path: &Path, content: &[u8], check: bool, command: &str) -> Result<(), TaskError> {
    let now = fs::read(path).ok();
    if now.as_deref() == Some(content) {
        return Ok(());
    }
    if check {
        return Err(TaskError(format!("{} differs from what the code generates; run: {command}", path.display())));
    }
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|e| TaskError(format!("cannot make {}: {e}", folder.display())))?;
    }
    fs::write(path, content).map_err(|e| TaskError(format!("cannot write {}: {e}", path.display())))
}

/// Reads a text file.
pub(crate) fn get(path: &Path) -> Result<String, TaskError> {
    fs::read_to_string(path).map_err(|e| TaskError(format!("cannot read {}: {e}", path.display())))
}
