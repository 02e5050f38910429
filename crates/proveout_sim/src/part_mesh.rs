//! The mesh of a design: from its file, or made of its closed form.

use std::path::{Path, PathBuf};

use proveout_geom::{TriMesh, read_mesh};

use crate::{
    error::SimError,
    scene::Scene,
    shape::{self, Shape},
};

/// The mesh of the design, and how far it lies from a closed form as measured, mm.
pub(crate) fn part_mesh(
    scene: &Scene,
    inputs: &mut Vec<(String, PathBuf)>,
) -> Result<Option<(TriMesh, Option<f64>)>, SimError> {
    let Some(part) = &scene.file.part else { return Ok(None) };
    if let Some(path) = &part.mesh {
        let path = scene.resolve(path);
        inputs.push(("part".into(), path.clone()));
        return Ok(Some((read_solid(&path)?, None)));
    }
    match &part.blade {
        Some(blade) => {
            inputs.extend(shape::sections_file(scene).map(|path| ("sections".to_owned(), path)));
            Ok(Some(Shape::of_scene(scene, blade, 0.0)?.mesh(scene, blade.chord_error_mm)?))
        }
        None => Ok(None),
    }
}

pub(crate) fn read_solid(path: &Path) -> Result<TriMesh, SimError> {
    let mesh = read_mesh(path)?;
    mesh.check_solid().map_err(|source| SimError::Mesh { path: path.into(), source })?;
    Ok(mesh)
}
