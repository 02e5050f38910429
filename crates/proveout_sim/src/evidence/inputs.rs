//! The files that a run reads, and what was noticed in them.

use std::{
    fmt,
    path::{Path, PathBuf},
    sync::Arc,
};

use proveout_geom::{FlatTriangles, MeshFileError, TriMesh, read_mesh_and_flat};
use proveout_input::InputError;
use proveout_step::{StepFiles, StepMesh, is_step};

use crate::{
    scene::{Scene, step_file::NamedMesh},
    verdict::{
        finding::{FLAT_TRIANGLES, Finding},
        log::FindingLog,
    },
};

/// Files in the order in which they are read, by role: `scene`, `machine`, `part`, `fixture vise`.
#[derive(Debug, Default)]
pub(crate) struct Inputs {
    files: Vec<(String, PathBuf)>,
    flat: Vec<FlatMesh>,
    step: Vec<StepInput>,
    step_files: StepFiles,
}

/// A STEP file of a scene, as it was read.
#[derive(Clone, Debug)]
pub(crate) struct StepInput {
    /// What it is to the scene.
    pub(crate) role: MeshRole,
    /// Its path, as the scene writes it.
    pub(crate) path: PathBuf,
    /// The scene states no chord error.
    pub(crate) is_assumed: bool,
    /// The mesh of its solids.
    pub(crate) mesh: Arc<StepMesh>,
}

/// What a mesh file of a scene is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum MeshRole {
    /// The design.
    Part,
    /// The raw stock.
    Stock,
    /// The fixture of this name.
    Fixture(String),
}

impl MeshRole {
    /// Name of the body in findings.
    pub(crate) fn body(&self) -> &str {
        match self {
            Self::Part => "part",
            Self::Stock => "stock",
            Self::Fixture(name) => name,
        }
    }
}

impl fmt::Display for MeshRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if matches!(self, Self::Fixture(_)) {
            f.write_str("fixture ")?;
        }
        f.write_str(self.body())
    }
}

/// A mesh file with triangles that have no area.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FlatMesh {
    role: MeshRole,
    path: PathBuf,
    flat: FlatTriangles,
}

/// What was noticed in files.
#[derive(Debug, Default)]
pub(crate) struct Noticed {
    /// Meshes with triangles that have no area.
    pub(crate) flat_meshes: Vec<FlatMesh>,
    /// STEP files.
    pub(crate) step_files: Vec<StepInput>,
}

impl Inputs {
    /// None yet; STEP files are read with those of the command.
    pub(crate) fn new(step_files: StepFiles) -> Self {
        Self { step_files, ..Self::default() }
    }

    /// A file that is read elsewhere.
    pub(crate) fn push(&mut self, role: impl Into<String>, path: PathBuf) {
        self.files.push((role.into(), path));
    }

    /// Reads the mesh that a key of the scene names, unchecked, in millimeters; gives its path as well.
    ///
    /// # Errors
    /// What keeps the file from being read, with the line of the key.
    pub(crate) fn mesh(
        &mut self,
        scene: &Scene,
        role: MeshRole,
        mesh: NamedMesh<'_>,
    ) -> Result<(TriMesh, PathBuf), InputError> {
        let named = mesh.file;
        let path = scene.resolve(named.get_ref());
        if is_step(&path) {
            return self.step(scene, role, mesh, path);
        }
        let (mut solid, flat) = read_mesh_and_flat(&path).map_err(|e| {
            let help = match &e {
                MeshFileError::Open { .. } => "correct the path of `mesh`, or put the file there",
                MeshFileError::UnknownFormat { .. } => "export it as STL, OBJ, glTF or STEP",
                MeshFileError::Content { .. } => "export it again",
            };
            scene.fault(named.span().start, format!("{role}: {e}"), help)
        })?;
        if let Some(FlatTriangles { all, .. }) = flat.filter(|_| solid.triangles.is_empty()) {
            let which = if all == 1 { "the only triangle" } else { &format!("each of the {all} triangles") };
            let message = format!("{role}: {which} of {} has no area", path.display());
            let help = "export it again: corners that became one point mean a unit or a tolerance that is too coarse";
            return Err(scene.fault(named.span().start, message, help));
        }
        if let Some(unit) = mesh.unit {
            unit.convert(&mut solid);
        }
        self.flat.extend(flat.map(|flat| FlatMesh { role: role.clone(), path: named.get_ref().clone(), flat }));
        self.files.push((role.to_string(), path.clone()));
        Ok((solid, path))
    }

    fn step(
        &mut self,
        scene: &Scene,
        role: MeshRole,
        mesh: NamedMesh<'_>,
        path: PathBuf,
    ) -> Result<(TriMesh, PathBuf), InputError> {
        let read = self
            .step_files
            .read(&path, mesh.asked_um())
            .map_err(|e| scene.fault(mesh.file.span().start, format!("{role}: {e}"), e.help()))?;
        self.files.push((role.to_string(), path.clone()));
        let solids = read.mesh.clone();
        let (named, is_assumed) = (mesh.file.get_ref().clone(), mesh.chord_um.is_none());
        self.step.push(StepInput { role, path: named, is_assumed, mesh: read });
        Ok((solids, path))
    }

    /// Chord error of the design, mm, where it is a STEP file that was read.
    pub(crate) fn chord_error_of_part(&self) -> Option<f64> {
        self.step.iter().find(|s| s.role == MeshRole::Part).map(|s| s.mesh.chord_error_mm())
    }

    /// Files by role, and what was noticed in them.
    pub(crate) fn into_parts(self) -> (Vec<(String, PathBuf)>, Noticed) {
        (self.files, Noticed { flat_meshes: self.flat, step_files: self.step })
    }
}

impl Extend<(String, PathBuf)> for Inputs {
    fn extend<I: IntoIterator<Item = (String, PathBuf)>>(&mut self, files: I) {
        self.files.extend(files);
    }
}

impl FlatMesh {
    /// The finding that reports it to a machinist.
    pub(crate) fn finding(&self) -> Finding {
        let Self { role, path, flat: FlatTriangles { count, all, first, at } } = self;
        let message = format!(
            "{role}: {count} of the {all} triangles of {} have no area, the first is number {first} at ({:.4}, {:.4}, {:.4}): they enclose nothing, and those with two equal corners are left out",
            shown(path),
            at.x,
            at.y,
            at.z
        );
        let mut finding = FindingLog::of(&FLAT_TRIANGLES, message);
        finding.bodies = vec![role.body().to_owned()];
        (finding.value, finding.unit) = (Some(*count as f64), Some("triangles".into()));
        finding
    }
}

/// A path as the scene writes it.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string().replace('\\', "/")
}
