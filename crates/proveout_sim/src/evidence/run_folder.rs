//! A run folder is written next to its place and moved there when it is complete.
//!
//! ```text
//!   .NAME.partial-PID    what is being written; that of a process that is gone is removed by the next run
//!   NAME                 a complete run with its manifest
//!   .NAME.journal        what its sweeps did: a run that was stopped goes on with it, one that is
//!                        complete removes it
//!   .NAME.old            the run before, while the new one takes its place; left by a kill, it is
//!                        taken back by the next run
//! ```
//!
//! Only files that the manifest of the older run names are replaced. Whatever else lies in its
//! folder is somebody's own: it is moved into the new folder, and reported.

use std::{
    collections::BTreeSet,
    ffi::OsString,
    fs,
    io::{Error, ErrorKind},
    path::{Path, PathBuf},
};

use crate::evidence::manifest::{MANIFEST, Manifest, names_below};

/// A run folder being written; removed again when it is dropped before [`RunFolder::commit`].
#[derive(Debug)]
pub struct RunFolder {
    place: PathBuf,
    partial: PathBuf,
    done: bool,
}

/// A run folder in its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Committed {
    /// Where it is.
    pub place: PathBuf,
    /// Files that lay there and are no run's: they stay.
    pub kept: Vec<String>,
}

impl RunFolder {
    /// Makes the partial folder next to `place`.
    ///
    /// # Errors
    /// When `place` holds something that is not a run folder with its manifest (it is then left alone), is a
    /// link to nothing, or the system refuses.
    pub fn create(place: &Path) -> Result<Self, Error> {
        let place = followed(place)?;
        let name =
            place.file_name().ok_or_else(|| Error::new(ErrorKind::InvalidInput, "the run folder has no name"))?;
        take_back(&place)?;
        let taken = match fs::read_dir(&place) {
            Ok(mut entries) => entries.next().is_some() && !place.join(MANIFEST).is_file(),
            Err(e) if e.kind() == ErrorKind::NotFound => false,
            Err(e) => return Err(Error::new(e.kind(), format!("{} cannot be a run folder: {e}", place.display()))),
        };
        if taken {
            let message =
                format!("{} is not empty and not a run folder with {MANIFEST}: it is not overwritten", place.display());
            return Err(Error::new(ErrorKind::AlreadyExists, message));
        }
        if place.join(MANIFEST).is_file() {
            // Reported before the run, not after it.
            Manifest::read(&place).map_err(|e| Error::new(ErrorKind::InvalidData, e.to_string()))?;
        }
        remove_dead(&place, name);
        let partial = beside(&place, &format!(".partial-{}", std::process::id()))?;
        if partial.exists() {
            fs::remove_dir_all(&partial)?;
        }
        fs::create_dir_all(&partial)?;
        Ok(Self { place, partial, done: false })
    }

    /// Where to write for now.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// The journal of the run, next to its place.
    pub fn journal(&self) -> PathBuf {
        let mut name = OsString::from(".");
        name.push(self.place.file_name().unwrap_or_default());
        name.push(".journal");
        self.place.with_file_name(name)
    }

    /// Moves the complete folder into place. The files of an older run there go, all others stay.
    ///
    /// # Errors
    /// When the system refuses; the older run is then still there or next to its place.
    pub fn commit(mut self) -> Result<Committed, Error> {
        let old = beside(&self.place, ".old")?;
        let had_old = self.place.exists();
        if had_old {
            fs::rename(&self.place, &old)?;
        }
        if let Err(e) = fs::rename(&self.partial, &self.place) {
            if had_old {
                fs::rename(&old, &self.place)?;
            }
            return Err(e);
        }
        self.done = true;
        // Where it cannot be removed, the next run writes over it.
        fs::remove_file(self.journal()).ok();
        let kept = if had_old { empty_into(&old, &self.place)? } else { Vec::new() };
        Ok(Committed { place: self.place.clone(), kept })
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        if !self.done {
            // No report is possible here; a partial folder that stays is hidden and named as such.
            fs::remove_dir_all(&self.partial).ok();
        }
    }
}

/// The folder that is meant, where `place` is a link.
fn followed(place: &Path) -> Result<PathBuf, Error> {
    if !fs::symlink_metadata(place).is_ok_and(|about| about.file_type().is_symlink()) {
        return Ok(place.to_owned());
    }
    let gone = |e: Error| {
        let to = fs::read_link(place).unwrap_or_default();
        Error::new(e.kind(), format!("{} is a link to {}, which is not there: {e}", place.display(), to.display()))
    };
    place.canonicalize().map_err(gone)
}

/// `.NAME` with an ending, next to a place.
fn beside(place: &Path, ending: &str) -> Result<PathBuf, Error> {
    let name = place.file_name().ok_or_else(|| Error::new(ErrorKind::InvalidInput, "the run folder has no name"))?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(ending);
    Ok(place.with_file_name(hidden))
}

/// What a kill between the two moves of a commit has left: the older run, or what had stayed in its folder.
fn take_back(place: &Path) -> Result<(), Error> {
    let old = beside(place, ".old")?;
    match (old.is_dir(), place.exists()) {
        (false, _) => Ok(()),
        (true, false) => fs::rename(&old, place),
        (true, true) => empty_into(&old, place).map(|_| ()),
    }
}

/// Removes the files of a run from its old folder and moves all others into the new one; returns
/// their names. One whose place is taken by a file of the new run gets `.kept` after its name.
fn empty_into(old: &Path, new: &Path) -> Result<Vec<String>, Error> {
    let own: BTreeSet<String> = Manifest::read(old).map(|m| m.names().map(str::to_owned).collect()).unwrap_or_default();
    let mut kept = Vec::new();
    for name in names_below(old)?.into_iter().filter(|name| !own.contains(name)) {
        let mut to = new.join(&name);
        while fs::symlink_metadata(&to).is_ok() {
            to.as_mut_os_string().push(".kept");
        }
        if let Some(parent) = to.parent() {
            fs::create_dir_all(parent)?;
        }
        fs::rename(old.join(&name), &to)?;
        kept.push(to.strip_prefix(new).unwrap_or(&to).display().to_string());
    }
    fs::remove_dir_all(old)?;
    Ok(kept)
}

/// Removes partial folders left by processes that are gone; only where the system says which
/// processes exist.
fn remove_dead(place: &Path, name: &std::ffi::OsStr) {
    let processes = Path::new("/proc");
    if !processes.join("self").exists() {
        return;
    }
    let Some(Ok(entries)) =
        place.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p }).map(fs::read_dir)
    else {
        return;
    };
    let begin = format!(".{}.partial-", name.to_string_lossy());
    for entry in entries.flatten() {
        let found = entry.file_name();
        let Some(id) = found.to_str().and_then(|n| n.strip_prefix(&begin)).and_then(|id| id.parse::<u32>().ok()) else {
            continue;
        };
        if !processes.join(id.to_string()).exists() {
            // Nothing depends on it; the next run tries again.
            fs::remove_dir_all(entry.path()).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write_run(folder: &RunFolder, text: &str) {
        fs::write(folder.path().join("verdict.json"), text).expect("written");
        Manifest::of(folder.path(), &[], Path::new("")).expect("listed").write(folder.path()).expect("written");
    }

    fn names(folder: &Path) -> Vec<String> {
        names_below(folder).unwrap_or_default()
    }

    #[test]
    fn complete_runs_replace_and_broken_ones_leave_no_trace() {
        let root = tempfile::tempdir().expect("temporary folder");
        let place = root.path().join("out/run");
        drop(RunFolder::create(&place).expect("new"));
        assert!(names(&root.path().join("out")).is_empty());
        for text in ["first", "second"] {
            let folder = RunFolder::create(&place).expect("new or older run");
            write_run(&folder, text);
            assert_eq!(folder.commit().expect("moved").kept, Vec::<String>::new());
            assert_eq!(fs::read_to_string(place.join("verdict.json")).expect("read"), text);
            assert_eq!(names(&root.path().join("out")), ["run/manifest.json", "run/verdict.json"]);
        }
    }

    #[test]
    fn files_that_are_no_runs_stay_and_are_reported() {
        let root = tempfile::tempdir().expect("temporary folder");
        let place = root.path().join("run");
        let folder = RunFolder::create(&place).expect("new");
        write_run(&folder, "first");
        folder.commit().expect("moved");
        fs::create_dir(place.join("photos")).expect("made");
        fs::write(place.join("photos/part.jpg"), "mine").expect("written");
        fs::write(place.join("later.csv"), "mine").expect("written");
        let folder = RunFolder::create(&place).expect("older run");
        fs::write(folder.path().join("later.csv"), "the run's").expect("written");
        write_run(&folder, "second");
        assert_eq!(folder.commit().expect("moved").kept, ["later.csv.kept", "photos/part.jpg"]);
        assert_eq!(fs::read_to_string(place.join("photos/part.jpg")).expect("kept"), "mine");
        assert_eq!(fs::read_to_string(place.join("later.csv.kept")).expect("kept"), "mine");
        assert_eq!(fs::read_to_string(place.join("later.csv")).expect("new"), "the run's");
        assert!(!root.path().join(".run.old").exists());
    }

    #[test]
    fn what_a_kill_has_left_is_taken_back() {
        let root = tempfile::tempdir().expect("temporary folder");
        let place = root.path().join("run");
        let folder = RunFolder::create(&place).expect("new");
        write_run(&folder, "first");
        folder.commit().expect("moved");
        // Killed after the first move.
        fs::rename(&place, root.path().join(".run.old")).expect("moved");
        let id = u32::MAX;
        fs::create_dir(root.path().join(format!(".run.partial-{id}"))).expect("made");
        let folder = RunFolder::create(&place).expect("older run");
        assert_eq!(fs::read_to_string(place.join("verdict.json")).expect("taken back"), "first");
        assert!(!root.path().join(format!(".run.partial-{id}")).exists(), "no process has this number");
        // Killed after the second one.
        fs::create_dir(root.path().join(".run.old")).expect("made");
        fs::write(root.path().join(".run.old/mine.txt"), "mine").expect("written");
        write_run(&folder, "second");
        drop(folder);
        drop(RunFolder::create(&place).expect("older run"));
        assert_eq!(names(root.path()), ["run/manifest.json", "run/mine.txt", "run/verdict.json"]);
    }

    #[test]
    fn a_folder_with_other_things_is_left_alone() {
        let root = tempfile::tempdir().expect("temporary folder");
        fs::write(root.path().join("thesis.txt"), "work of years").expect("written");
        fs::write(root.path().join("verdict.json"), "of another program").expect("written");
        let error = RunFolder::create(root.path()).expect_err("taken");
        assert!(error.to_string().contains("not a run folder"));
        assert_eq!(names(root.path()), ["thesis.txt", "verdict.json"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_those_to_nothing_refused() {
        let root = tempfile::tempdir().expect("temporary folder");
        let (link, real) = (root.path().join("link"), root.path().join("real"));
        std::os::unix::fs::symlink(&real, &link).expect("linked");
        assert!(RunFolder::create(&link).expect_err("to nothing").to_string().contains("is not there"));
        fs::create_dir(&real).expect("made");
        let folder = RunFolder::create(&link).expect("to a folder");
        write_run(&folder, "through the link");
        folder.commit().expect("moved");
        assert!(real.join("verdict.json").is_file() && link.join("verdict.json").is_file());
    }
}
