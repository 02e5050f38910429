//! A run folder is written beside its place and moved there when it is complete.

use std::{
    fs,
    io::{Error, ErrorKind},
    path::{Path, PathBuf},
};

/// File that marks a folder as a run folder.
const MARK: &str = "verdict.json";

/// A run folder being written; removed again when it is dropped before [`RunFolder::commit`].
#[derive(Debug)]
pub struct RunFolder {
    place: PathBuf,
    partial: PathBuf,
    done: bool,
}

impl RunFolder {
    /// Makes the partial folder beside `place`.
    ///
    /// # Errors
    /// When `place` holds something that is not a run folder (it is then left alone), or the system refuses.
    pub fn create(place: &Path) -> Result<Self, Error> {
        Self::create_marked(place, MARK)
    }

    /// The same for a folder that another file marks.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn create_marked(place: &Path, mark: &str) -> Result<Self, Error> {
        let taken = match fs::read_dir(place) {
            Ok(mut entries) => entries.next().is_some() && !place.join(mark).is_file(),
            Err(e) if e.kind() == ErrorKind::NotFound => false,
            Err(e) => return Err(e),
        };
        if taken {
            let message =
                format!("{} is not empty and not a run folder with {mark}: nothing is written over", place.display());
            return Err(Error::new(ErrorKind::AlreadyExists, message));
        }
        let name =
            place.file_name().ok_or_else(|| Error::new(ErrorKind::InvalidInput, "the run folder has no name"))?;
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".partial-{}", std::process::id()));
        let partial = place.with_file_name(hidden);
        if partial.exists() {
            fs::remove_dir_all(&partial)?;
        }
        fs::create_dir_all(&partial)?;
        Ok(Self { place: place.into(), partial, done: false })
    }

    /// Where to write for now.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Moves the complete folder into place; an older run there goes.
    ///
    /// # Errors
    /// When the system refuses; the older run is then still there or beside its place.
    pub fn commit(mut self) -> Result<PathBuf, Error> {
        let old = self.partial.with_extension("old");
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
        if had_old {
            fs::remove_dir_all(&old)?;
        }
        Ok(self.place.clone())
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        if !self.done {
            // Nobody can be told any more; a partial folder that stays is hidden and named as such.
            fs::remove_dir_all(&self.partial).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complete_runs_replace_and_broken_ones_leave_no_trace() {
        let root = tempfile::tempdir().expect("temporary folder");
        let place = root.path().join("out/run");
        let names = || fs::read_dir(root.path().join("out")).map_or(0, Iterator::count);
        drop(RunFolder::create(&place).expect("new"));
        assert_eq!(names(), 0);
        for text in ["first", "second"] {
            let folder = RunFolder::create(&place).expect("new or older run");
            fs::write(folder.path().join(MARK), text).expect("written");
            folder.commit().expect("moved");
            assert_eq!(fs::read_to_string(place.join(MARK)).expect("read"), text);
            assert_eq!(names(), 1);
        }
    }

    #[test]
    fn a_folder_with_other_things_is_left_alone() {
        let root = tempfile::tempdir().expect("temporary folder");
        fs::write(root.path().join("thesis.txt"), "work of years").expect("written");
        let error = RunFolder::create(root.path()).expect_err("taken");
        assert!(error.to_string().contains("not a run folder"));
        assert!(root.path().join("thesis.txt").exists());
    }
}
