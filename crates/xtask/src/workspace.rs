//! What cargo says about the workspace: its crates and what their manifests name.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;

use crate::TaskError;

/// Section of a manifest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum DependencyKind {
    /// `[dependencies]`, `[build-dependencies]`.
    Normal,
    /// `[dev-dependencies]`.
    Dev,
}

/// One entry of a manifest.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Dependency {
    /// Package name.
    pub(crate) name: String,
    /// Section.
    pub(crate) kind: DependencyKind,
}

/// One member of the workspace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Member {
    /// Package name.
    pub(crate) name: String,
    /// Folder of its manifest.
    pub(crate) folder: PathBuf,
    /// What it names, sorted.
    pub(crate) dependencies: Vec<Dependency>,
}

/// The workspace as reported by `cargo metadata`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Workspace {
    /// Members, sorted by name.
    pub(crate) members: Vec<Member>,
    /// Build folder.
    pub(crate) target: PathBuf,
}

impl Workspace {
    /// Asks cargo. Reads manifests only: no network, no lock file, no build.
    pub(crate) fn read(root: &Path) -> Result<Self, TaskError> {
        let output = Command::new(cargo())
            .args(["metadata", "--no-deps", "--format-version", "1", "--offline"])
            .current_dir(root)
            .output()
            .map_err(|e| TaskError(format!("cannot start cargo: {e}")))?;
        if !output.status.success() {
            return Err(TaskError(format!(
                "cargo metadata failed: {}",
                String::from_utf8_lossy(&output.stderr).trim()
            )));
        }
        Self::parse(&output.stdout)
    }

    /// Reads the answer of `cargo metadata --no-deps`.
    pub(crate) fn parse(json: &[u8]) -> Result<Self, TaskError> {
        let strange = |what: &str| TaskError(format!("cargo metadata contains no {what}"));
        let value: Value =
            serde_json::from_slice(json).map_err(|e| TaskError(format!("cargo metadata is not valid JSON: {e}")))?;
        let text = |value: &Value, key: &str| value[key].as_str().map(str::to_owned).ok_or_else(|| strange(key));
        let list = |value: &Value, key: &str| value[key].as_array().cloned().ok_or_else(|| strange(key));
        let mut members = Vec::new();
        for package in list(&value, "packages")? {
            let mut dependencies = Vec::new();
            for dependency in list(&package, "dependencies")? {
                let kind = if dependency["kind"].as_str() == Some("dev") {
                    DependencyKind::Dev
                } else {
                    DependencyKind::Normal
                };
                dependencies.push(Dependency { name: text(&dependency, "name")?, kind });
            }
            dependencies.sort();
            let manifest = PathBuf::from(text(&package, "manifest_path")?);
            let folder = manifest.parent().ok_or_else(|| strange("folder of a manifest"))?.to_path_buf();
            members.push(Member { name: text(&package, "name")?, folder, dependencies });
        }
        members.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(Self { members, target: PathBuf::from(text(&value, "target_directory")?) })
    }

    /// True when a member has this name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.members.iter().any(|m| m.name == name)
    }
}

impl Member {
    /// Members of the workspace that this one uses, without duplicates, sorted.
    pub(crate) fn uses<'a>(&'a self, workspace: &'a Workspace, kinds: &[DependencyKind]) -> Vec<&'a str> {
        let mut names: Vec<&str> = self
            .dependencies
            .iter()
            .filter(|d| kinds.contains(&d.kind) && workspace.has(&d.name))
            .map(|d| d.name.as_str())
            .collect();
        names.dedup();
        names
    }
}

/// The cargo that started this program, or the one on the path.
pub(crate) fn cargo() -> String {
    std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned())
}
