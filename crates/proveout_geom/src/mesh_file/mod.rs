//! Mesh files. The readers are written here and read the bytes of a whole file. The file is not trusted:
//! counts are checked against the number of bytes before memory is allocated, and what cannot be read is
//! refused by name.

mod glb;
mod glb_container;
mod obj;
mod stl;

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use proveout_input::{MAX_LENGTH_MM, read_regular_file};
use thiserror::Error;

pub use self::glb::{GlbNode, read_glb_nodes};
pub use self::glb_container::write_glb_container;
use crate::{Point, TriMesh};

/// Largest file: an STL with the most triangles.
const MAX_FILE_BYTES: u64 = 1 << 30;
/// Most triangles of a file; they take some 2 GB while vertices are joined.
const MAX_TRIANGLES: usize = 20_000_000;

/// Why a mesh file could not be read or written.
#[derive(Debug, Error)]
pub enum MeshFileError {
    /// The file is missing or may not be read.
    #[error("cannot open {path}: {source}")]
    Open {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The ending is none of those that are read.
    #[error("{path}: mesh files end in .stl, .obj, .glb or .gltf")]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The content does not follow its format.
    #[error("{path}: {message}")]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
}

/// Reads a triangle mesh; the file extension decides the format. STL (both forms) and OBJ are taken as
/// millimeters. glTF is in meters with Y up and is converted to millimeters with Z up, node poses applied.
/// Equal vertices are merged.
///
/// ```
/// use proveout_geom::{Aabb, Point, box_mesh, read_mesh, write_stl};
///
/// let block = Aabb { min: Point::origin(), max: Point::new(100.0, 60.0, 20.0) }; // mm
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("block.stl");
/// write_stl(&path, &box_mesh(&block))?;
/// let mesh = read_mesh(&path)?;
/// assert_eq!(mesh.positions.len(), 8); // equal corners of the 12 triangles are joined
/// assert_eq!(mesh.aabb(), block);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MeshFileError`] with the path; the mesh itself is not checked, see [`TriMesh::check_solid`].
pub fn read_mesh(path: &Path) -> Result<TriMesh, MeshFileError> {
    read_mesh_and_flat(path).map(|(mesh, _)| mesh)
}

/// The same, and what of the file has no area: such triangles bound nothing, and those with two equal corners
/// are not in the mesh.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_and_flat(path: &Path) -> Result<(TriMesh, Option<FlatTriangles>), MeshFileError> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let read: fn(&Path, &[u8]) -> Result<TriMesh, MeshFileError> = match ending.as_deref() {
        Some("stl") => stl::read,
        Some("obj") => obj::read,
        Some("glb" | "gltf") => |path, bytes| {
            let mut all = TriMesh::default();
            glb::nodes(path, bytes)?.iter().for_each(|node| all.append(&node.mesh));
            Ok(all)
        },
        _ => return Err(MeshFileError::UnknownFormat { path: path.into() }),
    };
    let mesh = read(path, &bytes_of(path)?)?;
    checked(path, &mesh)?;
    Ok((mesh.merge_equal_vertices(), FlatTriangles::of(&mesh)))
}

/// Triangles of a mesh without area: two corners at one place, or all three on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatTriangles {
    /// How many.
    pub count: usize,
    /// Of how many in all.
    pub all: usize,
    /// The first one's place in the file, from 1.
    pub first: usize,
    /// One of its corners, mm.
    pub at: Point,
}

/// Height of a triangle over its longest edge, as a part of that edge, below which it is flat. Coordinates of
/// 32 bits that are not on a line are off it by 1e-7 of their size and more.
const FLAT: f64 = 1e-9;

impl FlatTriangles {
    /// Those of a mesh, where it has any.
    pub fn of(mesh: &TriMesh) -> Option<Self> {
        let is_flat = |t: &usize| {
            let [a, b, c] = mesh.corners(*t);
            let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
            mesh.area_normal(*t).norm() <= FLAT * longest
        };
        let mut flat = (0..mesh.triangles.len()).filter(is_flat);
        let first = flat.next()?;
        Some(Self { count: 1 + flat.count(), all: mesh.triangles.len(), first: first + 1, at: mesh.corners(first)[0] })
    }
}

/// Bytes of a mesh file.
fn bytes_of(path: &Path) -> Result<Vec<u8>, MeshFileError> {
    read_regular_file(path, MAX_FILE_BYTES).map_err(|source| MeshFileError::Open { path: path.into(), source })
}

fn content(path: &Path, message: impl ToString) -> MeshFileError {
    MeshFileError::Content { path: path.into(), message: message.to_string() }
}

fn too_many(path: &Path) -> MeshFileError {
    content(path, format!("more than {MAX_TRIANGLES} triangles: save it with a coarser tolerance"))
}

/// A finite number of a text file.
fn number(word: Option<&str>) -> Option<f64> {
    // Coordinates are kept as the formats define them, in 32 bits: a vertex that is written twice is one
    // vertex.
    word?.parse::<f32>().ok().filter(|x| x.is_finite()).map(f64::from)
}

/// Refuses what no workshop has, before anything calculates with it.
fn checked(path: &Path, mesh: &TriMesh) -> Result<(), MeshFileError> {
    let far = |p: &&Point| !p.iter().all(|x| x.abs() <= MAX_LENGTH_MM);
    match mesh.positions.iter().find(far) {
        None => Ok(()),
        Some(p) => {
            let place = format!("a vertex lies at ({:e}, {:e}, {:e}) mm", p.x, p.y, p.z);
            Err(content(path, format!("{place}; the limit is {MAX_LENGTH_MM} mm: check the unit of the file")))
        }
    }
}

/// Triangles without shared corners, as they come.
#[derive(Default)]
struct Mesh(TriMesh);

/// Writes a binary STL (32-bit floats, mm).
///
/// # Errors
/// [`MeshFileError::Open`] when the file cannot be written.
pub fn write_stl(path: &Path, mesh: &TriMesh) -> Result<(), MeshFileError> {
    let fail = |source| MeshFileError::Open { path: path.into(), source };
    let mut out = BufWriter::new(File::create(path).map_err(fail)?);
    let mut put = |bytes: &[u8]| out.write_all(bytes).map_err(fail);
    put(&[0; 80])?;
    put(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for t in 0..mesh.triangles.len() {
        let normal = mesh.area_normal(t).try_normalize(0.0).unwrap_or_default();
        for x in normal.iter().chain(mesh.corners(t).iter().flat_map(|p| p.coords.iter())) {
            put(&(*x as f32).to_le_bytes())?;
        }
        put(&[0; 2])?;
    }
    out.flush().map_err(fail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cylinder_mesh;

    #[test]
    fn stl_keeps_the_solid() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("part.stl");
        let mesh = cylinder_mesh(5.0, 0.0, 7.0, 40);
        write_stl(&path, &mesh).expect("written");
        let back = read_mesh(&path).expect("read");
        back.check_solid().expect("still closed");
        assert!((back.volume() / mesh.volume() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn obj_quads_become_triangles() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("tetra.obj");
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
            .expect("written");
        let mesh = read_mesh(&path).expect("read");
        mesh.check_solid().expect("closed");
        assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-7);
    }

    #[test]
    fn triangles_without_area_are_counted_and_needles_are_not() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("tetra.obj");
        let solid = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0.5 0 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
        std::fs::write(&path, solid).expect("written");
        assert_eq!(read_mesh_and_flat(&path).expect("read").1, None);
        std::fs::write(&path, format!("{solid}f 1 1 2\nf 1 5 2\nf 4 4 4\n")).expect("written");
        let (mesh, flat) = read_mesh_and_flat(&path).expect("read");
        assert_eq!(flat, Some(FlatTriangles { count: 3, all: 7, first: 5, at: Point::origin() }));
        assert_eq!(mesh.triangles.len(), 5, "what keeps its corners stays");
        // A needle of 100 mm and the last bit of its coordinates is a triangle.
        std::fs::write(&path, "v 0 0 64\nv 100 0 64\nv 50 0 64.00001\nf 1 2 3\n").expect("written");
        assert_eq!(read_mesh_and_flat(&path).expect("read").1, None);
    }

    #[test]
    fn bad_files_are_refused_with_their_path() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let missing = read_mesh(&folder.path().join("none.stl")).expect_err("missing");
        assert!(missing.to_string().contains("none.stl"), "{missing}");
        let unknown = read_mesh(Path::new("part.step")).expect_err("unknown");
        assert!(matches!(unknown, MeshFileError::UnknownFormat { .. }));
        let path = folder.path().join("noise.glb");
        std::fs::write(&path, b"not a mesh").expect("written");
        assert!(matches!(read_mesh(&path), Err(MeshFileError::Content { .. })));
    }
}
