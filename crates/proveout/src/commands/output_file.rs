//! Output files of a command: written to a temporary file in the same folder and renamed when complete. An
//! existing file is overwritten only with `--force`.

use std::{
    ffi::OsString,
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

use crate::failure::Failure;

/// Refuses a place that is taken, before the work is done.
pub(super) fn check(path: &Path, force: bool) -> Result<(), Failure> {
    let failure = |message: String, help: &str| Err(Failure::new(message).with_help(help));
    match fs::metadata(path) {
        Ok(about) if !about.is_file() => {
            failure(format!("{} is not a regular file: nothing is written to it", path.display()), "name another file")
        }
        Ok(_) if !force => {
            failure(format!("{} already exists", path.display()), "name another file, or overwrite it with --force")
        }
        Err(e) if e.kind() == ErrorKind::NotFound && fs::symlink_metadata(path).is_ok() => {
            failure(format!("{} is a link to a file that does not exist", path.display()), "name another file")
        }
        _ => Ok(()),
    }
}

/// Lets `write` write a temporary file next to the place, and moves it there.
pub(super) fn put(path: &Path, force: bool, write: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
    check(path, force)?;
    // Links are followed, so that the file that is meant is replaced and not the link.
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let beside = beside(&place);
    let done = write(&beside).and_then(|()| {
        fs::rename(&beside, &place).map_err(|e| {
            Failure::new(format!("{} cannot be written: {e}", path.display())).with_help("name another file")
        })
    });
    if done.is_err() {
        fs::remove_file(&beside).ok();
    }
    done
}

/// The same with bytes.
pub(super) fn put_bytes(path: &Path, force: bool, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
    put(path, force, |beside| {
        fs::write(beside, bytes).map_err(|e| {
            Failure::new(format!("{} cannot be written: {e}", path.display())).with_help("name another file")
        })
    })
}

/// A name of its own in the same folder, with the same ending.
fn beside(place: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let mut name = OsString::from(format!(".part-{}-{}-", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
    name.push(place.file_name().unwrap_or_default());
    place.with_file_name(name)
}
