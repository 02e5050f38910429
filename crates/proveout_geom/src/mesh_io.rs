use std::{
    fs::File,
    io::{BufReader, BufWriter, Write},
    path::{Path, PathBuf},
};

use nalgebra::{Matrix4, Point3};
use thiserror::Error;

use crate::{Point, TriMesh};

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

/// Reads a triangle mesh by the ending of its file: STL (both forms) and OBJ in millimeter as they stand; glTF is in
/// meter with Y up and becomes millimeter with Z up, node poses applied. Equal vertices are joined.
///
/// # Errors
/// [`MeshFileError`] with the path; the mesh itself is not checked, see [`TriMesh::check_solid`].
pub fn read_mesh(path: &Path) -> Result<TriMesh, MeshFileError> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let mesh = match ending.as_deref() {
        Some("stl") => read_stl(path)?,
        Some("obj") => read_obj(path)?,
        Some("glb" | "gltf") => read_gltf(path)?,
        _ => return Err(MeshFileError::UnknownFormat { path: path.into() }),
    };
    Ok(mesh.merge_equal_vertices())
}

fn open(path: &Path) -> Result<BufReader<File>, MeshFileError> {
    File::open(path).map(BufReader::new).map_err(|source| MeshFileError::Open { path: path.into(), source })
}

fn content(path: &Path, message: impl ToString) -> MeshFileError {
    MeshFileError::Content { path: path.into(), message: message.to_string() }
}

fn read_stl(path: &Path) -> Result<TriMesh, MeshFileError> {
    let mesh = stl_io::read_stl(&mut open(path)?).map_err(|e| content(path, e))?;
    Ok(TriMesh {
        positions: mesh.vertices.iter().map(|v| Point::new(v[0].into(), v[1].into(), v[2].into())).collect(),
        triangles: mesh.faces.iter().map(|f| f.vertices.map(|i| i as u32)).collect(),
    })
}

fn read_obj(path: &Path) -> Result<TriMesh, MeshFileError> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let (models, _) =
        tobj::load_obj_buf(&mut open(path)?, &options, |_| Ok(Default::default())).map_err(|e| content(path, e))?;
    let mut all = TriMesh::default();
    for model in &models {
        let to_f64 = |p: &[f32]| Point3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
        all.append(&TriMesh {
            positions: model.mesh.positions.chunks_exact(3).map(to_f64).collect(),
            triangles: model.mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        });
    }
    Ok(all)
}

fn read_gltf(path: &Path) -> Result<TriMesh, MeshFileError> {
    let file = gltf::Gltf::from_reader(open(path)?).map_err(|e| content(path, e))?;
    let blob = file.blob.as_deref();
    let scene = file.default_scene().or_else(|| file.scenes().next());
    let scene = scene.ok_or_else(|| content(path, "the file has no scene"))?;
    // Meter, Y up, to millimeter, Z up: x = 1000 x, y = -1000 z, z = 1000 y.
    let mm_from_gltf = Matrix4::new(
        1e3, 0.0, 0.0, 0.0, //
        0.0, 0.0, -1e3, 0.0, //
        0.0, 1e3, 0.0, 0.0, //
        0.0, 0.0, 0.0, 1.0,
    );
    let mut all = TriMesh::default();
    let mut open_nodes: Vec<_> = scene.nodes().map(|n| (n, mm_from_gltf)).collect();
    while let Some((node, parent)) = open_nodes.pop() {
        let local = node.transform().matrix();
        let here = parent * Matrix4::from_fn(|row, column| f64::from(local[column][row]));
        for primitive in node.mesh().into_iter().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
            let reader = primitive.reader(|buffer| match buffer.source() {
                gltf::buffer::Source::Bin => blob,
                gltf::buffer::Source::Uri(_) => None,
            });
            let positions = reader.read_positions();
            let positions = positions.ok_or_else(|| content(path, "a mesh has no positions in the binary chunk"))?;
            let positions: Vec<Point> =
                positions.map(|p| here.transform_point(&Point::new(p[0].into(), p[1].into(), p[2].into()))).collect();
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..positions.len() as u32).collect(),
            };
            if indices.iter().any(|&i| i as usize >= positions.len()) {
                return Err(content(path, "an index is past the last vertex"));
            }
            let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
            all.append(&TriMesh { positions, triangles });
        }
        open_nodes.extend(node.children().map(|child| (child, here)));
    }
    Ok(all)
}

/// Writes a binary STL (32-bit floats, mm).
///
/// # Errors
/// [`MeshFileError::Open`] when the file cannot be written.
pub fn write_stl(path: &Path, mesh: &TriMesh) -> Result<(), MeshFileError> {
    let fail = |source| MeshFileError::Open { path: path.into(), source };
    let faces: Vec<stl_io::Triangle> = (0..mesh.triangles.len())
        .map(|t| {
            let single = |v: [f64; 3]| stl_io::Vector::new(v.map(|x| x as f32));
            let normal = mesh.area_normal(t).try_normalize(0.0).unwrap_or_default();
            stl_io::Triangle {
                normal: single(normal.into()),
                vertices: mesh.corners(t).map(|p| single(p.coords.into())),
            }
        })
        .collect();
    let mut out = BufWriter::new(File::create(path).map_err(fail)?);
    stl_io::write_stl(&mut out, faces.iter()).map_err(fail)?;
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
