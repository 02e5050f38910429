//! `manifest.json`: every file that a run has opened and written, with size and SHA-256, so that a run folder can be held against
//! what it was, and its inputs against what they are now.
//!
//! Paths of inputs are relative to the folder of the scene, so that the manifest is the same from wherever the run was started. What
//! differs from run to run (`run.json`, a recording) is named without a digest.

use std::{
    collections::BTreeMap,
    fs,
    path::{Component, Path, PathBuf},
};

use proveout_geom::read_regular_text;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    digest::{self, InputFile},
    signature::SIGNATURE,
};

/// Name of the file in a run folder.
pub const MANIFEST: &str = "manifest.json";
/// Version of the layout.
const VERSION: u32 = 1;
/// Files whose bytes differ between two runs of the same inputs.
const VOLATILE: [&str; 2] = ["run.json", "recording.rrd"];
/// Largest manifest that is read.
const MAX_BYTES: u64 = 64 << 20;

/// What a run has opened and written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Layout of this file.
    pub manifest_version: u32,
    /// Program and version that wrote it.
    pub made_by: String,
    /// Files that were opened.
    pub inputs: Vec<Listed>,
    /// Files of the run folder.
    pub files: Vec<Written>,
    /// Files of the run folder that differ from run to run: they are the run's own, and no digest covers them.
    pub without_digest: Vec<String>,
}

/// A file that was opened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// What it is to the run.
    pub role: String,
    /// Path from the folder of the scene.
    pub path: String,
    /// Its size.
    pub bytes: u64,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
}

/// A file of the run folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Written {
    /// Path from the run folder.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// SHA-256 in hexadecimal digits.
    pub sha256: String,
}

/// Why a manifest cannot be used.
#[derive(Debug, Error)]
pub enum ManifestError {
    /// It is missing or may not be read.
    #[error("{} cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is no manifest.
    #[error("{} is no manifest of this version: {message}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
}

impl Manifest {
    /// Lists what lies in a folder, and what the run has opened; `scene_folder` is that of the scene.
    ///
    /// # Errors
    /// What the system says.
    pub fn of(folder: &Path, inputs: &[InputFile], scene_folder: &Path) -> std::io::Result<Self> {
        let (mut files, mut without_digest) = (Vec::new(), Vec::new());
        for name in names_below(folder)? {
            if name == MANIFEST || name == SIGNATURE {
                continue;
            }
            if VOLATILE.contains(&name.rsplit('/').next().unwrap_or_default()) {
                without_digest.push(name);
                continue;
            }
            let (bytes, sha256) = digest::measure(&folder.join(&name))?;
            files.push(Written { name, bytes, sha256 });
        }
        let mut listed: Vec<Listed> = inputs
            .iter()
            .map(|i| Listed {
                role: i.role.clone(),
                path: relative(scene_folder, &i.path),
                bytes: i.bytes,
                sha256: i.sha256.clone(),
            })
            .collect();
        // Programs of a comparison share most of their inputs.
        listed.sort_by(|a, b| (&a.role, &a.path).cmp(&(&b.role, &b.path)));
        listed.dedup();
        let made_by = format!("proveout {}", env!("CARGO_PKG_VERSION"));
        Ok(Self { manifest_version: VERSION, made_by, inputs: listed, files, without_digest })
    }

    /// Writes it into its folder.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        fs::write(folder.join(MANIFEST), serde_json::to_string_pretty(self)? + "\n")
    }

    /// Reads that of a run folder.
    ///
    /// # Errors
    /// [`ManifestError`].
    pub fn read(folder: &Path) -> Result<Self, ManifestError> {
        let path = folder.join(MANIFEST);
        let text =
            read_regular_text(&path, MAX_BYTES).map_err(|source| ManifestError::Read { path: path.clone(), source })?;
        let content = |message: String| ManifestError::Content { path: path.clone(), message };
        let read: Self = serde_json::from_str(&text).map_err(|e| content(e.to_string()))?;
        if read.manifest_version != VERSION {
            return Err(content(format!("it is of version {}, and {VERSION} is known", read.manifest_version)));
        }
        // A manifest says what may be replaced: it must not reach out of its folder.
        let names = read.files.iter().map(|f| &f.name).chain(&read.without_digest);
        let outside = |name: &&String| !Path::new(name).components().all(|c| matches!(c, Component::Normal(_)));
        if let Some(name) = names.filter(|n| !n.is_empty()).find(outside) {
            return Err(content(format!("it names {name:?}, which is not in its folder")));
        }
        Ok(read)
    }

    /// Names of all files of the run, the manifest itself and its signature included.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let files = self.files.iter().map(|f| f.name.as_str());
        files.chain(self.without_digest.iter().map(String::as_str)).chain([MANIFEST, SIGNATURE])
    }

    /// The digest of a file of the run folder.
    pub fn digest_of(&self, name: &str) -> Option<&str> {
        self.files.iter().find(|f| f.name == name).map(|f| f.sha256.as_str())
    }
}

/// How a run folder and its inputs compare with the manifest.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verified {
    /// Files of the folder that are as they were.
    pub same_files: usize,
    /// Files of the folder that are not, with what is wrong.
    pub changed_files: Vec<String>,
    /// Files in the folder that the run has not written.
    pub foreign_files: Vec<String>,
    /// Inputs that are as they were.
    pub same_inputs: usize,
    /// Inputs that have changed since, or are gone, with what is wrong.
    pub changed_inputs: Vec<String>,
}

impl Verified {
    /// The folder holds what the run wrote.
    pub fn holds(&self) -> bool {
        self.changed_files.is_empty()
    }
}

/// Holds a run folder against its manifest, and the inputs below `scene_folder` where it is known.
///
/// # Errors
/// [`ManifestError`] when there is no manifest.
pub fn verify(folder: &Path, scene_folder: Option<&Path>) -> Result<Verified, ManifestError> {
    let manifest = Manifest::read(folder)?;
    let mut found = Verified::default();
    for file in &manifest.files {
        match compared(&folder.join(&file.name), file.bytes, &file.sha256) {
            None => found.same_files += 1,
            Some(fault) => found.changed_files.push(format!("{}: {fault}", file.name)),
        }
    }
    let path = folder.to_owned();
    let there = names_below(folder).map_err(|source| ManifestError::Read { path, source })?;
    found.foreign_files = there.into_iter().filter(|name| manifest.names().all(|own| own != name)).collect();
    for input in scene_folder.iter().flat_map(|_| &manifest.inputs) {
        let path = scene_folder.map(|folder| folder.join(&input.path)).unwrap_or_default();
        match compared(&path, input.bytes, &input.sha256) {
            None => found.same_inputs += 1,
            Some(fault) => found.changed_inputs.push(format!("{} ({}): {fault}", input.role, input.path)),
        }
    }
    Ok(found)
}

fn compared(path: &Path, bytes: u64, sha256: &str) -> Option<String> {
    match digest::measure(path) {
        Err(e) => Some(format!("cannot be read: {e}")),
        Ok((now, _)) if now != bytes => Some(format!("has {now} bytes where the run had {bytes}")),
        Ok((_, now)) if now != sha256 => Some(format!("its SHA-256 is {now} where the run had {sha256}")),
        Ok(_) => None,
    }
}

/// Files below a folder by their paths from it, with `/` between, in order; links are not followed.
pub(crate) fn names_below(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut found = BTreeMap::new();
    let mut open = vec![(folder.to_owned(), String::new())];
    while let Some((at, prefix)) = open.pop() {
        for entry in fs::read_dir(at)? {
            let entry = entry?;
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if entry.file_type()?.is_dir() {
                open.push((entry.path(), format!("{name}/")));
            } else {
                found.insert(name, ());
            }
        }
    }
    Ok(found.into_keys().collect())
}

/// A path as seen from a folder, with `/` between; as it is where one of the two is not there.
pub(crate) fn relative(folder: &Path, path: &Path) -> String {
    let from = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (Ok(from), Ok(to)) = (from.canonicalize(), path.canonicalize()) else { return path.display().to_string() };
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(shared).map(|_| "..".to_owned());
    let down = to.components().skip(shared).map(|c| c.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run() -> (tempfile::TempDir, PathBuf) {
        let root = tempfile::tempdir().expect("temporary folder");
        fs::create_dir_all(root.path().join("scene")).expect("made");
        fs::create_dir_all(root.path().join("run/part")).expect("made");
        for (name, text) in [
            ("scene/scene.toml", "a"),
            ("tools.toml", "b"),
            ("run/verdict.json", "c"),
            ("run/run.json", "d"),
            ("run/part/x", "e"),
        ] {
            fs::write(root.path().join(name), text).expect("written");
        }
        let inputs = [("scene", "scene/scene.toml"), ("tools", "scene/../tools.toml")];
        let inputs: Vec<InputFile> =
            inputs.iter().map(|(role, path)| digest::of_input(role, &root.path().join(path)).expect("there")).collect();
        let folder = root.path().join("run");
        Manifest::of(&folder, &inputs, &root.path().join("scene")).expect("listed").write(&folder).expect("written");
        (root, folder)
    }

    #[test]
    fn paths_are_those_from_the_scene_and_what_varies_has_no_digest() {
        let (_root, folder) = run();
        let manifest = Manifest::read(&folder).expect("read");
        let paths: Vec<&str> = manifest.inputs.iter().map(|i| i.path.as_str()).collect();
        assert_eq!(paths, ["scene.toml", "../tools.toml"]);
        assert_eq!(manifest.without_digest, ["run.json"]);
        assert_eq!(manifest.files.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["part/x", "verdict.json"]);
    }

    #[test]
    fn each_change_is_told_by_name() {
        let (root, folder) = run();
        let scene = root.path().join("scene");
        let fresh = verify(&folder, Some(&scene)).expect("a manifest");
        assert!(fresh.holds() && fresh.same_inputs == 2 && fresh.same_files == 2 && fresh.foreign_files.is_empty());
        fs::write(folder.join("verdict.json"), "C").expect("written");
        fs::remove_file(folder.join("part/x")).expect("gone");
        fs::write(folder.join("notes.txt"), "mine").expect("written");
        fs::write(folder.join("run.json"), "another time").expect("written");
        fs::write(root.path().join("tools.toml"), "bb").expect("written");
        let found = verify(&folder, Some(&scene)).expect("a manifest");
        assert!(!found.holds());
        assert!(found.changed_files[0].starts_with("part/x: cannot be read"), "{found:?}");
        assert!(found.changed_files[1].starts_with("verdict.json: its SHA-256"), "{found:?}");
        assert_eq!(found.foreign_files, ["notes.txt"]);
        assert_eq!(found.changed_inputs, ["tools (../tools.toml): has 2 bytes where the run had 1"]);
    }

    #[test]
    fn a_manifest_that_reaches_out_of_its_folder_is_refused() {
        let (_root, folder) = run();
        let text = fs::read_to_string(folder.join(MANIFEST)).expect("read");
        for name in ["../thesis.txt", "/etc/passwd", "./x/../../y"] {
            fs::write(folder.join(MANIFEST), text.replace("part/x", name)).expect("written");
            let told = Manifest::read(&folder).expect_err(name).to_string();
            assert!(told.contains("not in its folder"), "{told}");
        }
    }
}
