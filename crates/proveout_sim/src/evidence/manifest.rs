//! `manifest.json`: every file that a run has opened and written, with size and SHA-256, so that a
//! run folder can be checked against what it was, and its inputs against what they are now.
//!
//! Paths of inputs are relative to the folder of the scene, and the scene's folder to that of the run, so
//! that the manifest is the same from wherever the run was started. `run.json` differs from run to run (time,
//! memory, the call): it is named without a digest, and [`verify`] says so. A recording has a digest: its
//! bytes are not the same in two runs, but they are those of this one.

use std::{
    collections::BTreeMap,
    fs,
    path::{Component, Path, PathBuf},
};

use proveout_input::read_regular_text;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::evidence::{
    digest::{self, InputFile},
    signature::SIGNATURE,
};

/// Name of the file in a run folder.
pub const MANIFEST: &str = "manifest.json";
/// Version of the layout.
const VERSION: u32 = 2;
/// The layout before: it does not name the scene, and no digest covers a recording.
const VERSION_WITHOUT_SCENE: u32 = 1;
/// The file whose bytes say how long the run took, and where: no digest covers it.
const RUN_JSON: &str = "run.json";
/// A recording, which manifests of the first layout have without a digest.
const RECORDING: &str = "recording.rrd";
/// What a run, a comparison and a job decide: a manifest that covers none of them is evidence of nothing.
const DECISIONS: [&str; 3] = ["verdict.json", "compare.json", "job.json"];
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
    /// Folder of the scene (of a job: that of the job), from the folder of this file; none in manifests of
    /// the first layout.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Files that were opened.
    pub inputs: Vec<Listed>,
    /// Files of the run folder.
    pub files: Vec<Written>,
    /// Files of the run folder that differ from run to run: they are the run's own, and no digest covers
    /// them.
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
    #[error("{} is not a manifest of this version: {message}", path.display())]
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
            if is_run_json(&name) {
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
        let path = relative(folder, scene_folder);
        let scene = Some(if path.is_empty() { ".".to_owned() } else { path });
        Ok(Self { manifest_version: VERSION, made_by, scene, inputs: listed, files, without_digest })
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
        if ![VERSION, VERSION_WITHOUT_SCENE].contains(&read.manifest_version) {
            return Err(content(format!(
                "it has version {}, and this program reads version {VERSION}",
                read.manifest_version
            )));
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

    /// What keeps it from being evidence: it covers no verdict, names no inputs, or leaves a file without a
    /// digest that has to have one.
    fn hollow(&self) -> Option<String> {
        if !DECISIONS.iter().any(|name| self.digest_of(name).is_some()) {
            return Some(format!("it covers no {}", DECISIONS.join(", no ")));
        }
        if !self.inputs.iter().any(|input| ["scene", "job"].contains(&input.role.as_str())) {
            return Some("it names no scene among its inputs".into());
        }
        let recording = |name: &str| self.manifest_version == VERSION_WITHOUT_SCENE && last_of(name) == RECORDING;
        let bare = self.without_digest.iter().find(|name| !is_run_json(name) && !recording(name));
        bare.map(|name| format!("it has no digest of {name}, and every run writes one"))
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
    /// Files of the folder that are there, and that no digest covers: whatever is in them, they are not
    /// checked.
    pub uncovered_files: Vec<String>,
    /// Files in the folder that the run has not written.
    pub foreign_files: Vec<String>,
    /// Folder of the scene, as the manifest names it.
    pub scene: Option<PathBuf>,
    /// A signature lies in the folder.
    pub has_signature: bool,
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

/// Checks a run folder against its manifest, and the inputs below `scene_folder`; where that is
/// none, below the folder that the manifest names, if it exists.
///
/// # Errors
/// [`ManifestError`] when there is no manifest, or when it covers no verdict or no inputs.
pub fn verify(folder: &Path, scene_folder: Option<&Path>) -> Result<Verified, ManifestError> {
    let manifest = Manifest::read(folder)?;
    let mut found = files_of(folder, &manifest)?;
    let scene_folder = scene_folder.map(Path::to_owned).or_else(|| found.scene.clone().filter(|scene| scene.is_dir()));
    for input in scene_folder.iter().flat_map(|_| &manifest.inputs) {
        let path = scene_folder.as_ref().map(|folder| folder.join(&input.path)).unwrap_or_default();
        match compared(&path, input.bytes, &input.sha256) {
            None => found.same_inputs += 1,
            Some(fault) => found.changed_inputs.push(format!("{} ({}): {fault}", input.role, input.path)),
        }
    }
    Ok(found)
}

/// Checks a run folder against its manifest; inputs are not looked at.
///
/// # Errors
/// Those of [`verify`].
pub(crate) fn verify_files(folder: &Path) -> Result<Verified, ManifestError> {
    files_of(folder, &Manifest::read(folder)?)
}

fn files_of(folder: &Path, manifest: &Manifest) -> Result<Verified, ManifestError> {
    if let Some(message) = manifest.hollow() {
        return Err(ManifestError::Content { path: folder.join(MANIFEST), message });
    }
    let scene = manifest.scene.as_ref().map(|scene| folder.join(scene));
    let has_signature = fs::symlink_metadata(folder.join(SIGNATURE)).is_ok();
    let mut found = Verified { scene, has_signature, ..Verified::default() };
    for file in &manifest.files {
        match compared(&folder.join(&file.name), file.bytes, &file.sha256) {
            None => found.same_files += 1,
            Some(fault) => found.changed_files.push(format!("{}: {fault}", file.name)),
        }
    }
    for name in &manifest.without_digest {
        match digest::measure(&folder.join(name)) {
            Ok(_) => found.uncovered_files.push(name.clone()),
            Err(e) => found.changed_files.push(format!("{name}: cannot be read: {e}")),
        }
    }
    let path = folder.to_owned();
    let there = names_below(folder).map_err(|source| ManifestError::Read { path, source })?;
    found.foreign_files = there.into_iter().filter(|name| manifest.names().all(|own| own != name)).collect();
    Ok(found)
}

fn last_of(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or_default()
}

/// `run.json`, also that of a run in a comparison or a job.
fn is_run_json(name: &str) -> bool {
    last_of(name) == RUN_JSON
}

fn compared(path: &Path, bytes: u64, sha256: &str) -> Option<String> {
    match digest::measure(path) {
        Err(e) => Some(format!("cannot be read: {e}")),
        Ok((now, _)) if now != bytes => Some(format!("has {now} bytes; the run had {bytes}")),
        Ok((_, now)) if now != sha256 => Some(format!("its SHA-256 is {now}; the run had {sha256}")),
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
    // The folder of a bare file name is the empty path.
    let or_here =
        |path: &Path| if path.as_os_str().is_empty() { Path::new(".").canonicalize() } else { path.canonicalize() };
    let (Ok(from), Ok(to)) = (or_here(folder), or_here(path)) else { return path.display().to_string() };
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
        assert_eq!(manifest.scene.as_deref(), Some("../scene"));
        assert_eq!(manifest.files.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["part/x", "verdict.json"]);
    }

    #[test]
    fn each_change_is_reported_by_name() {
        let (root, folder) = run();
        let scene = root.path().join("scene");
        let fresh = verify(&folder, Some(&scene)).expect("a manifest");
        assert!(fresh.holds() && fresh.same_inputs == 2 && fresh.same_files == 2 && fresh.foreign_files.is_empty());
        assert_eq!(fresh.uncovered_files, ["run.json"]);
        assert_eq!(verify(&folder, None).expect("a manifest").same_inputs, 2, "the manifest names the scene");
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
        assert_eq!(found.changed_inputs, ["tools (../tools.toml): has 2 bytes; the run had 1"]);
    }

    #[test]
    fn a_manifest_that_covers_nothing_is_no_evidence() {
        type Change = fn(&mut Manifest);
        let cases: [(&str, Change); 7] = [
            ("covers no verdict.json", |m| m.files.clear()),
            ("covers no verdict.json", |m| m.files.retain(|f| f.name != "verdict.json")),
            ("covers no verdict.json", |m| m.files.iter_mut().for_each(|f| f.name = format!("old/{}", f.name))),
            ("names no scene", |m| m.inputs.clear()),
            ("names no scene", |m| m.inputs.retain(|i| i.role != "scene")),
            ("no digest of part/x", |m| {
                m.files.retain(|f| f.name != "part/x");
                m.without_digest.push("part/x".into());
            }),
            ("no digest of recording.rrd", |m| m.without_digest.push(RECORDING.into())),
        ];
        for (word, change) in cases {
            let (_root, folder) = run();
            let mut manifest = Manifest::read(&folder).expect("read");
            change(&mut manifest);
            manifest.write(&folder).expect("written");
            let output = verify(&folder, None).expect_err(word).to_string();
            assert!(output.contains(word), "{output}");
        }
        // An older manifest has a recording without a digest, and does not know where the scene is.
        let (_root, folder) = run();
        let mut older = Manifest::read(&folder).expect("read");
        (older.manifest_version, older.scene) = (VERSION_WITHOUT_SCENE, None);
        older.without_digest.push(RECORDING.into());
        fs::write(folder.join(RECORDING), "any bytes").expect("written");
        older.write(&folder).expect("written");
        let found = verify(&folder, None).expect("a manifest");
        assert_eq!((found.uncovered_files.len(), found.same_inputs, found.scene), (2, 0, None));
    }

    #[test]
    fn a_manifest_that_reaches_out_of_its_folder_is_refused() {
        let (_root, folder) = run();
        let text = fs::read_to_string(folder.join(MANIFEST)).expect("read");
        for name in ["../thesis.txt", "/etc/passwd", "./x/../../y"] {
            fs::write(folder.join(MANIFEST), text.replace("part/x", name)).expect("written");
            let message = Manifest::read(&folder).expect_err(name).to_string();
            assert!(message.contains("not in its folder"), "{message}");
        }
    }
}
