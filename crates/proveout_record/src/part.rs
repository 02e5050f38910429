//! The cut part as pictures: `part.glb`, `deviation.glb`, and what the report and the recording show of it.

use std::path::Path;

use proveout_sim::{
    Observer, SurfaceMap, SurfaceShape, SurfaceTexture,
    observer::{Batch, MeshPart, ObserverError, Outcome, PointBand, Setup},
};

use crate::{
    color::{DeviationMap, Rgba},
    error::RecordError,
    glb::write_glb_file,
    picture::Picture,
    roughness_map::{ShownTexture, range_of},
    surface_picture::{ShownSurface, SurfacePicture},
};

/// Most triangles of a glTF file: 2 million are 60 MB and still turn in a viewer.
pub(crate) const GLB_TRIANGLES: usize = 2_000_000;

/// Most roughness maps of a glTF file or a recording, and nodes along their sides: 4 million triangles at
/// most.
pub(crate) const MOST_MAPS: usize = 100;
pub(crate) const MAP_SIDE: usize = 141;

/// Colors of the vertices; empty without a map.
pub(crate) fn colors_of(picture: &Picture, map: Option<DeviationMap>) -> Vec<Rgba> {
    map.map_or_else(Vec::new, |map| picture.values.iter().map(|v| map.color(f64::from(*v))).collect())
}

/// Writes `part.glb` (steel), and `deviation.glb` (the same in colors) where deviations were measured.
///
/// A surface above two million triangles is gathered in cells; the file then says so in its extras.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub fn write_part_files(folder: &Path, surface: &SurfaceMap, range_floor_mm: f64) -> Result<(), RecordError> {
    write_shown(folder, &SurfacePicture::of(surface, GLB_TRIANGLES), &surface.shape(), range_floor_mm)
}

fn write_shown(
    folder: &Path,
    shown: &ShownSurface,
    shape: &SurfaceShape,
    range_floor_mm: f64,
) -> Result<(), RecordError> {
    let picture = &shown.picture;
    let size = shown.cell.map_or_else(
        || "the whole extracted surface".to_owned(),
        |c| {
            let whole = shape.all_triangles();
            format!("{} of {whole} triangles, gathered in cells of {c:.3} mm", picture.triangles.len())
        },
    );
    let size = if shape.patches.is_empty() {
        size
    } else {
        let names: Vec<&str> = shape.patches.iter().map(|p| p.name.as_str()).collect();
        format!("{size}; finer in the patches {}, not joined at their faces", names.join(", "))
    };
    write_file(folder, "part", &size, picture, &[])?;
    if let Some(map) = shown.map(range_floor_mm) {
        let colored = format!("red -{0} mm (gouge), gray 0, blue +{0} mm (material left)", map.range);
        let colors = colors_of(picture, Some(map));
        write_file(folder, "deviation", &format!("{size}; {colored}"), picture, &colors)?;
    }
    Ok(())
}

/// Smallest range of the deviation colors, mm: a tenth of the tighter tolerance of the scene.
pub(crate) fn range_floor(setup: &Setup<'_>) -> f64 {
    let t = &setup.scene.file.tolerances;
    0.1 * t.gouge_mm.min(t.excess_mm)
}

/// Writes `roughness.glb`: all maps on their places, colored by height on one scale; nothing without maps.
fn write_roughness(folder: &Path, textures: &[ShownTexture]) -> Result<(), RecordError> {
    if textures.is_empty() {
        return Ok(());
    }
    let range = range_of(textures);
    let (mut picture, mut colors) = (Picture::default(), Vec::new());
    for texture in textures {
        picture.append(&texture.picture());
        colors.extend(texture.colors(range));
    }
    let every = textures.iter().map(|t| t.every).max().unwrap_or(1);
    let note = format!(
        "{} maps, up to every {every}. node; height above the design from dark blue {:.4} um to yellow {:.4} um",
        textures.len(),
        range[0],
        range[1]
    );
    write_file(folder, "roughness", &note, &picture, &colors)
}

fn write_file(folder: &Path, name: &str, note: &str, picture: &Picture, colors: &[Rgba]) -> Result<(), RecordError> {
    let path = folder.join(format!("{name}.glb"));
    write_glb_file(&path, name, note, picture, colors).map_err(RecordError::io(&path))
}

/// Writes the glTF files at the end of a run, from the bands of the surface.
#[derive(Debug, Default)]
pub struct GltfObserver {
    surface: Option<SurfacePicture>,
    textures: Vec<ShownTexture>,
}

impl GltfObserver {
    fn surface(&mut self) -> &mut SurfacePicture {
        self.surface.get_or_insert_with(|| SurfacePicture::new(GLB_TRIANGLES))
    }
}

impl Observer for GltfObserver {
    fn name(&self) -> &'static str {
        "gltf"
    }

    fn begin(&mut self, _setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        self.surface = None;
        self.textures.clear();
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn surface_points(&mut self, setup: &Setup<'_>, band: &PointBand<'_>) -> Result<(), ObserverError> {
        self.surface().points(setup, band);
        Ok(())
    }

    fn surface_mesh(
        &mut self,
        _setup: &Setup<'_>,
        shape: &SurfaceShape,
        part: &MeshPart<'_>,
    ) -> Result<(), ObserverError> {
        self.surface().mesh(shape, part);
        Ok(())
    }

    fn surface_texture(&mut self, _setup: &Setup<'_>, texture: &SurfaceTexture) -> Result<(), ObserverError> {
        if texture.map.is_some() && self.textures.len() < MOST_MAPS {
            self.textures.push(ShownTexture::of(texture, MAP_SIDE));
        }
        Ok(())
    }

    fn end(&mut self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        write_roughness(outcome.folder, &std::mem::take(&mut self.textures))?;
        let shown = self.surface.take().map(SurfacePicture::finish).unwrap_or_default();
        Ok(write_shown(outcome.folder, &shown, outcome.surface, range_floor(setup))?)
    }
}
