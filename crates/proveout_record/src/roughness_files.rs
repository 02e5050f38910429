//! Roughness maps as files of their own: pictures, and SDF and X3P for programs that evaluate texture.

use std::{fs, path::Path};

use proveout_sim::{
    Observer, SurfaceTexture,
    observer::{Batch, ObserverError, Outcome, Setup},
};
use proveout_surface::texture::{
    HeightMap,
    file::{SdfForm, write_sdf, write_x3p},
};

use crate::{error::RecordError, roughness_picture::write_height_map_png};

/// Folder of the maps in the run folder.
pub(crate) const MAPS_FOLDER: &str = "maps";

/// Writes `maps/NAME.png`, `.sdf` and `.x3p` of every patch that is cut at all nodes, as they come.
#[derive(Debug, Default)]
pub struct MapFilesObserver {
    folder: Option<std::path::PathBuf>,
}

impl Observer for MapFilesObserver {
    fn name(&self) -> &'static str {
        "maps"
    }

    fn begin(&mut self, _setup: &Setup<'_>, folder: &Path) -> Result<(), ObserverError> {
        self.folder = Some(folder.join(MAPS_FOLDER));
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn surface_texture(&mut self, setup: &Setup<'_>, texture: &SurfaceTexture) -> Result<(), ObserverError> {
        let (Some(folder), Some(map)) = (&self.folder, &texture.map) else { return Ok(()) };
        let [x, y] = map.step_mm;
        // A map with holes is no lattice that these files could hold; the page shows it.
        let Ok(heights) = HeightMap::new(map.columns, map.rows, x, y, map.heights.clone()) else { return Ok(()) };
        fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
        let place = |ending: &str| folder.join(format!("{}.{ending}", texture.name));
        write_height_map_png(&place("png"), &heights, &texture.name, map.lay_deg.map(f64::to_radians))?;
        if setup.scene.file.surface.as_ref().is_some_and(|s| s.save_nodes) {
            let failed = |e: proveout_surface::texture::file::TextureFileError| ObserverError {
                what: e.path.display().to_string(),
                message: e.message,
            };
            write_sdf(&place("sdf"), &heights, SdfForm::Binary).map_err(failed)?;
            write_x3p(&place("x3p"), &heights).map_err(failed)?;
        }
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, _outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}
