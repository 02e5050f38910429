//! The cut part as pictures: `part.glb`, `deviation.glb`, and what the report and the recording show of it.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::Path,
};

use proveout_sim::{
    Observer, SurfaceMap,
    observer::{Batch, ObserverError, Outcome, Setup},
};

use crate::{
    color::{DeviationMap, Rgba, STEEL},
    error::RecordError,
    glb::write_glb,
    picture::Picture,
};

/// Most triangles of a glTF file: 2 million are 60 MB and still turn in a viewer.
pub(crate) const GLB_TRIANGLES: usize = 2_000_000;

/// Part of the triangles of a picture that patches may take together: they are there to be seen.
const FOR_PATCHES: f64 = 0.5;

/// The surface of a run as a picture of at most `limit` triangles, with the deviation (mm) as value of each vertex, and the
/// largest edge (mm) of the cells in which it was gathered, if it was.
///
/// Patches are gathered on their own, so that a large part does not take their details away.
pub(crate) fn picture_of(surface: &SurfaceMap, limit: usize) -> (Picture, Option<f64>) {
    let each = (FOR_PATCHES * limit as f64) as usize / surface.patches.len().max(1);
    let mut patches = Picture::default();
    for p in &surface.patches {
        patches.append(&Picture::new(&p.mesh, &p.normals, &p.vertex_deviation).reduced(each).0);
    }
    let left = limit.saturating_sub(patches.triangles.len());
    let whole = Picture::new(&surface.mesh, &surface.normals, &surface.vertex_deviation);
    let (mut picture, cell) = whole.reduced(left);
    picture.append(&patches);
    (picture, cell)
}

/// The color map for the deviations of a surface; none when it has none.
///
/// The range follows the measured points, and the mesh where there are none; it is never below `floor` (mm).
pub(crate) fn map_of(surface: &SurfaceMap, floor: f64) -> Option<DeviationMap> {
    let points: Vec<f64> = surface.points.iter().filter_map(|p| p.deviation).collect();
    let values = if points.is_empty() { surface.whole_deviation() } else { points };
    values.iter().any(|d| d.is_finite()).then(|| DeviationMap::of(&values, floor))
}

/// Colors of the vertices; empty without a map.
pub(crate) fn colors_of(picture: &Picture, map: Option<DeviationMap>) -> Vec<Rgba> {
    map.map_or_else(Vec::new, |map| picture.values.iter().map(|v| map.color(f64::from(*v))).collect())
}

/// Writes `part.glb` (steel) and `deviation.glb` (colored, or steel when the scene has no design).
///
/// A surface above two million triangles is gathered in cells; the file then says so in its extras.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub fn write_part_files(folder: &Path, surface: &SurfaceMap, range_floor_mm: f64) -> Result<(), RecordError> {
    let whole = surface.triangles();
    let (picture, cell) = picture_of(surface, GLB_TRIANGLES);
    let size = cell.map_or_else(
        || "the whole extracted surface".to_owned(),
        |c| format!("{} of {whole} triangles, gathered in cells of {c:.3} mm", picture.triangles.len()),
    );
    let size = if surface.patches.is_empty() {
        size
    } else {
        let names: Vec<&str> = surface.patches.iter().map(|p| p.name.as_str()).collect();
        format!("{size}; finer in the patches {}, not joined at their faces", names.join(", "))
    };
    let map = map_of(surface, range_floor_mm);
    let colored = map.map_or_else(
        || "no design part: the surface carries no deviations".to_owned(),
        |m| format!("red -{0} mm (gouge), gray 0, blue +{0} mm (material left)", m.range),
    );
    let colors = colors_of(&picture, map);
    for (name, note, colors) in
        [("part", size.clone(), &[][..]), ("deviation", format!("{size}; {colored}"), colors.as_slice())]
    {
        let path = folder.join(format!("{name}.glb"));
        let mut out = BufWriter::new(File::create(&path).map_err(RecordError::io(&path))?);
        write_glb(&mut out, name, &note, &picture, colors, STEEL)
            .and_then(|()| out.flush())
            .map_err(RecordError::io(&path))?;
    }
    Ok(())
}

/// Smallest range of the deviation colors, mm: a tenth of the tighter tolerance of the scene.
pub(crate) fn range_floor(setup: &Setup<'_>) -> f64 {
    let t = &setup.scene.file.tolerances;
    0.1 * t.gouge_mm.min(t.excess_mm)
}

/// Writes the glTF files at the end of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct GltfObserver;

impl Observer for GltfObserver {
    fn name(&self) -> &'static str {
        "gltf"
    }

    fn begin(&mut self, _setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn end(&mut self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(write_part_files(outcome.folder, outcome.surface, range_floor(setup))?)
    }
}
