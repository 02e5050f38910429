//! The mesh of a design: from its file, or made of its closed form.

use std::path::PathBuf;

use proveout_geom::TriMesh;

use crate::{
    evidence::inputs::{Inputs, MeshRole},
    prepare::{
        error::SimError,
        part_shape::{self, Shape},
    },
    scene::Scene,
};

/// The mesh of the design, and how far it lies from a closed form or the surfaces of a STEP file as measured,
/// mm.
pub(crate) fn part_mesh(scene: &Scene, inputs: &mut Inputs) -> Result<Option<(TriMesh, Option<f64>)>, SimError> {
    let Some(part) = &scene.file.part else { return Ok(None) };
    if let Some(named) = part.named_mesh() {
        let (mesh, path) = inputs.mesh(scene, MeshRole::Part, named)?;
        return Ok(Some((solid(mesh, path)?, inputs.chord_error_of_part())));
    }
    match &part.blade {
        Some(blade) => {
            inputs.extend(part_shape::sections_file(scene).map(|path| ("sections".to_owned(), path)));
            Ok(Some(Shape::of_scene(scene, blade, 0.0)?.mesh(scene, blade.chord_error_mm)?))
        }
        None => Ok(None),
    }
}

/// The mesh of a file, proved to bound a solid.
pub(crate) fn solid(mesh: TriMesh, path: PathBuf) -> Result<TriMesh, SimError> {
    mesh.check_solid().map_err(|source| SimError::Mesh { path, source })?;
    Ok(mesh)
}
