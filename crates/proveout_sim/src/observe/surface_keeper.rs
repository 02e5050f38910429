//! The observer that gathers the whole surface of a run in memory.

use std::{
    path::Path,
    sync::{Arc, Mutex, PoisonError},
};

use proveout_geom::TriMesh;

use crate::observe::{
    observer::{Batch, Observer, Outcome, Setup},
    observer_error::ObserverError,
    surface_map::{MeshPart, PatchMap, PointBand, SurfaceMap, SurfaceShape},
};

/// Gathers the whole surface of a run in memory, to compare several parts with each other. Takes
/// about 200 bytes a point.
#[derive(Debug, Default)]
pub struct SurfaceKeeper(Arc<Mutex<SurfaceMap>>);

impl SurfaceKeeper {
    /// An observer, and where it puts the surface.
    pub fn new() -> (Self, Arc<Mutex<SurfaceMap>>) {
        let place = Arc::new(Mutex::new(SurfaceMap::default()));
        (Self(Arc::clone(&place)), place)
    }
}

impl Observer for SurfaceKeeper {
    fn name(&self) -> &'static str {
        "surface"
    }

    fn begin(&mut self, setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        let patch = |p: &proveout_stock::Patch| PatchMap {
            name: p.name().into(),
            window: *p.window(),
            cells_mm: p.stock().cells_mm(),
            mesh: TriMesh::default(),
            normals: Vec::new(),
            vertex_deviation: Vec::new(),
            points: 0..0,
        };
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = SurfaceMap {
            cells_mm: setup.stock.cells_mm(),
            patches: setup.patches.iter().map(patch).collect(),
            ..SurfaceMap::default()
        };
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn surface_points(&mut self, _setup: &Setup<'_>, band: &PointBand<'_>) -> Result<(), ObserverError> {
        let mut map = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        map.points.extend_from_slice(band.points);
        let end = map.points.len();
        // Patches that come later begin where this one ends.
        let first = band.patch.map_or(0, |k| k + 1);
        if let Some(patch) = band.patch.and_then(|k| map.patches.get_mut(k)) {
            patch.points.end = end;
        }
        map.patches.iter_mut().skip(first).for_each(|p| p.points = end..end);
        Ok(())
    }

    fn surface_mesh(
        &mut self,
        _setup: &Setup<'_>,
        _shape: &SurfaceShape,
        part: &MeshPart<'_>,
    ) -> Result<(), ObserverError> {
        let map = &mut *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (mesh, normals, deviations) = match part.patch {
            None => (&mut map.mesh, &mut map.normals, &mut map.vertex_deviation),
            Some(k) => match map.patches.get_mut(k) {
                Some(p) => (&mut p.mesh, &mut p.normals, &mut p.vertex_deviation),
                None => return Ok(()),
            },
        };
        mesh.positions.extend_from_slice(part.positions);
        mesh.triangles.extend_from_slice(part.triangles);
        normals.extend_from_slice(part.normals);
        deviations.extend_from_slice(part.deviations);
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, _outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}
