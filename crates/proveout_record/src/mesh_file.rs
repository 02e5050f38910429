//! A mesh alone in a file, by the ending of its name.

use std::{io, path::Path};

use proveout_geom::{MeshFileError, TriMesh, write_stl};

use crate::{glb::write_glb_file, picture::Picture};

/// Edges sharper than this stay sharp in the picture, radian.
const CREASE: f64 = 0.5;

/// Writes a mesh (mm) as binary STL, or as binary glTF (meter, Y up at its root) with a note, into a file of
/// that ending.
///
/// # Errors
/// The ending is neither `.stl` nor `.glb`, or the file cannot be written.
pub fn write_mesh(path: &Path, name: &str, note: &str, mesh: &TriMesh) -> io::Result<()> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("stl") => write_stl(path, mesh).map_err(|e| match e {
            MeshFileError::Open { source, .. } => source,
            other => io::Error::other(other),
        }),
        Some("glb") => write_glb_file(path, name, note, &Picture::creased(mesh, CREASE), &[]),
        _ => Err(io::Error::new(io::ErrorKind::InvalidInput, "its name ends neither in .stl nor in .glb")),
    }
}
