//! Mesh files that a URDF names: where they lie, and their triangles in mm.

use std::path::{Path, PathBuf};

use proveout_geom::{TriMesh, Vector, read_mesh};
use proveout_input::{InputError, MAX_LENGTH_MM};

use super::source::{Place, UrdfSource, reach, shown};

/// Most triangles of all meshes together; a verdict needs no finer machine.
const MAX_TRIANGLES: usize = 3_000_000;

/// Where a mesh is read, and how many triangles have been.
#[derive(Default)]
pub(super) struct Meshes {
    triangles: usize,
}

/// File of a name: a path from the folder of the URDF file, `file://`, or `package://NAME/...`, where NAME
/// is one of the folders above the file or next to one of them.
fn locate(urdf: &Path, name: &str) -> Option<PathBuf> {
    let folder = urdf.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let package = ["package://", "model://"].into_iter().find_map(|scheme| name.strip_prefix(scheme));
    let Some(in_package) = package else {
        let path = name.strip_prefix("file://").unwrap_or(name);
        return Some(folder.join(path)).filter(|p| p.is_file());
    };
    let (package, rest) = in_package.split_once('/')?;
    let folder = folder.canonicalize().ok()?;
    let of = |above: &Path| {
        let own = above.file_name().is_some_and(|n| n == package).then(|| above.join(rest));
        own.into_iter().chain([above.join(package).join(rest)]).find(|p| p.is_file())
    };
    folder.ancestors().find_map(of)
}

impl Meshes {
    /// Triangles of a file in mm, its own axes; none where its kind is not read, which `notes` learns.
    pub(super) fn read(
        &mut self,
        source: &UrdfSource<'_>,
        place: &Place,
        link: &str,
        (file, scale): (&str, &Vector),
        notes: &mut Vec<String>,
    ) -> Result<Option<TriMesh>, InputError> {
        let ending = Path::new(file).extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        if !matches!(ending.as_deref(), Some("stl" | "obj")) {
            notes.push(format!("mesh {} of link {} is not imported: save it as STL", shown(file), shown(link)));
            return Ok(None);
        }
        let Some(path) = locate(source.file, file) else {
            let remedy = if file.contains("package://") || file.contains("model://") {
                "put the folder of the package into the folder of the URDF file or above it, or write the path from \
                 the URDF file"
            } else {
                "correct the path: it counts from the folder of the URDF file"
            };
            return Err(source.at(place, format!("mesh {} of link {} not found", shown(file), shown(link)), remedy));
        };
        let mut mesh = read_mesh(&path).map_err(|e| {
            source.at(place, format!("mesh of link {}: {e}", shown(link)), "name a mesh, or leave the shape out")
        })?;
        mesh.positions.iter_mut().for_each(|p| p.coords.component_mul_assign(scale));
        if scale.product() < 0.0 {
            // A mirrored mesh is inside out.
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let far = reach(&mesh.positions);
        if far > MAX_LENGTH_MM {
            let message = format!(
                "mesh {} of link {} reaches {far:.0} mm far; the limit is {MAX_LENGTH_MM} mm",
                shown(file),
                shown(link)
            );
            return Err(source.at(
                place,
                message,
                "meshes are in meters: scale=\"0.001 0.001 0.001\" where the file is in mm",
            ));
        }
        self.triangles += mesh.triangles.len();
        if self.triangles > MAX_TRIANGLES {
            let message = format!("the meshes have more than {MAX_TRIANGLES} triangles");
            return Err(source.at(place, message, "save them with a coarser tolerance"));
        }
        if let Err(fault) = mesh.check_solid() {
            notes.push(format!("mesh {} of link {}: {fault}", shown(file), shown(link)));
        }
        Ok(Some(mesh).filter(|m| !m.triangles.is_empty()))
    }
}
