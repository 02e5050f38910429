//! Keys of a mesh that is a STEP file: such a file states its unit, and its chord error is measured.

use std::path::PathBuf;

use proveout_step::{CHORD_UM, DEFAULT_CHORD_UM, is_step};
use serde_spanned::Spanned;

use crate::scene::mesh_unit::MeshUnitFile;

/// A mesh that a scene names, with what it says about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NamedMesh<'a> {
    /// The file.
    pub(crate) file: &'a Spanned<PathBuf>,
    /// Unit of its numbers.
    pub(crate) unit: Option<MeshUnitFile>,
    /// Chord error that is asked of a STEP file, um.
    pub(crate) chord_um: Option<f64>,
}

impl NamedMesh<'_> {
    /// Chord error that a STEP file is read with, um.
    pub(crate) fn asked_um(&self) -> f64 {
        self.chord_um.unwrap_or(DEFAULT_CHORD_UM)
    }
}

/// Whether a mesh is a STEP file.
pub(crate) fn is_step_file(mesh: Option<&Spanned<PathBuf>>) -> bool {
    mesh.is_some_and(|file| is_step(file.get_ref()))
}

/// What is wrong with the keys next to a mesh: the key, message and help.
pub(crate) fn fault(
    mesh: Option<&Spanned<PathBuf>>,
    unit: Option<MeshUnitFile>,
    chord_um: Option<f64>,
) -> Option<(&'static str, String, String)> {
    if !is_step_file(mesh) {
        return chord_um.map(|_| {
            let help = "leave it out, or name a .step or .stp file with `mesh`";
            ("chord_um", "`chord_um` belongs to a STEP file".to_owned(), help.to_owned())
        });
    }
    if unit.is_some() {
        let help = "leave `mesh_unit` out";
        return Some(("mesh_unit", "a STEP file states its unit: `mesh_unit` has no effect on it".into(), help.into()));
    }
    chord_um.filter(|asked| !CHORD_UM.contains(asked)).map(|asked| {
        let message = format!("chord_um = {asked} um is out of range");
        ("chord_um", message, format!("write {} to {} um", CHORD_UM.start(), CHORD_UM.end()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_a_step_file_are_its_own() {
        let [step, stl] = ["part.step", "part.stl"].map(|name| Spanned::new(0..1, PathBuf::from(name)));
        let key = |mesh, unit, chord| fault(mesh, unit, chord).map(|f| f.0);
        assert_eq!(key(Some(&step), None, Some(2.0)), None);
        assert_eq!(key(Some(&step), None, None), None);
        assert_eq!(key(Some(&stl), Some(MeshUnitFile::Mm), None), None);
        assert_eq!(key(Some(&stl), None, Some(2.0)), Some("chord_um"));
        assert_eq!(key(None, None, Some(2.0)), Some("chord_um"));
        assert_eq!(key(Some(&step), Some(MeshUnitFile::Mm), None), Some("mesh_unit"));
        for out in [0.0, 0.09, 1000.1, -5.0, f64::NAN] {
            assert_eq!(key(Some(&step), None, Some(out)), Some("chord_um"), "{out}");
        }
    }
}
