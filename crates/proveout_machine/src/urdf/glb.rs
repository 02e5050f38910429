//! A glTF 2.0 binary file of meshes, a node each: what `model.rs` reads.
//!
//! glTF is in meter with Y up: (x, y, z) mm of the machine become (x, z, -y) / 1000, in 32 bits.

use std::fmt::Write as _;
use std::io;

use proveout_geom::{Point, TriMesh, write_glb_container};

use crate::units::M_PER_MM;

fn vertex(p: &Point) -> [f32; 3] {
    [p.x, p.z, -p.y].map(|v| (v * M_PER_MM) as f32 + 0.0)
}

/// A string of JSON; names have no control characters.
fn json(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Bytes of the file.
///
/// # Errors
/// Meshes above 4 GiB, which the format cannot hold.
pub(super) fn bytes(parts: &[(String, TriMesh)]) -> io::Result<Vec<u8>> {
    let mut bin: Vec<u8> = Vec::new();
    let (mut nodes, mut meshes, mut accessors, mut views) =
        (String::new(), String::new(), String::new(), String::new());
    for (k, (name, mesh)) in parts.iter().enumerate() {
        let comma = if k == 0 { "" } else { "," };
        let points: Vec<[f32; 3]> = mesh.positions.iter().map(vertex).collect();
        let end = |start: f32, of: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|c| points.iter().map(|p| p[c]).fold(start, of)).map(|v| v.to_string()).join(",")
        };
        let (low, high) = (end(f32::INFINITY, f32::min), end(f32::NEG_INFINITY, f32::max));
        let start = bin.len();
        bin.extend(points.iter().flatten().flat_map(|v| v.to_le_bytes()));
        let middle = bin.len();
        bin.extend(mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()));
        let _ = write!(
            views,
            "{comma}{{\"buffer\":0,\"byteOffset\":{start},\"byteLength\":{}}},{{\"buffer\":0,\"byteOffset\":{middle},\"byteLength\":{}}}",
            middle - start,
            bin.len() - middle
        );
        let _ = write!(
            accessors,
            "{comma}{{\"bufferView\":{},\"componentType\":5126,\"count\":{},\"type\":\"VEC3\",\"min\":[{low}],\"max\":[{high}]}},{{\"bufferView\":{},\
             \"componentType\":5125,\"count\":{},\"type\":\"SCALAR\"}}",
            2 * k,
            points.len(),
            2 * k + 1,
            3 * mesh.triangles.len()
        );
        let _ = write!(
            meshes,
            "{comma}{{\"primitives\":[{{\"attributes\":{{\"POSITION\":{}}},\"indices\":{}}}]}}",
            2 * k,
            2 * k + 1
        );
        let _ = write!(nodes, "{comma}{{\"name\":{},\"mesh\":{k}}}", json(name));
    }
    let roots: Vec<String> = (0..parts.len()).map(|k| k.to_string()).collect();
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\",\"generator\":\"proveout machine\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[{}]}}],\"nodes\":[{nodes}],\"meshes\":[{meshes}],\
         \"accessors\":[{accessors}],\"bufferViews\":[{views}],\"buffers\":[{{\"byteLength\":{}}}]}}",
        roots.join(","),
        bin.len()
    );
    let mut file = Vec::with_capacity(32 + text.len() + bin.len());
    write_glb_container(&mut file, text.as_bytes(), bin.len(), |out| out.write_all(&bin))?;
    Ok(file)
}
