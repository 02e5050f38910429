//! glTF 2.0 in one binary file: the geometry of its nodes, and nothing else.
//!
//! ```text
//!   file    = "glTF" 2 length, chunk JSON, chunk BIN        (Khronos, glTF 2.0 specification, section 4)
//!   node    -> mesh -> primitive -> accessor -> buffer view -> bytes of BIN
//! ```
//!
//! The file is not trusted: every count is checked against the number of bytes before memory is allocated.
//! Each node is visited once, since the nodes of a scene are trees (section 3.5.2). What is not read
//! (sparse accessors, strips and fans, buffers outside of the file, required extensions) is refused by
//! name.

use std::path::Path;

use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3};
use serde::Deserialize;

use super::{MAX_TRIANGLES, MeshFileError, content, too_many};
use crate::{Point, TriMesh};

const FLOAT: u32 = 5126;
const TRIANGLES: u32 = 4;
/// Millimeters in a meter, the unit of glTF.
const MM_PER_M: f64 = 1e3;
/// A quaternion that is shorter is no turn.
const SHORTEST_TURN: f64 = 1e-6;

/// A node of a glTF file.
#[derive(Debug)]
pub struct GlbNode {
    /// Its name, or `node 3`.
    pub name: String,
    /// Index of the node above, in the list of [`read_glb_nodes`].
    pub parent: Option<usize>,
    /// Its own mesh without those of its children, in millimeter with Z up, all poses applied; faces of
    /// mirrored nodes are turned.
    pub mesh: TriMesh,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Document {
    #[serde(default)]
    extensions_required: Vec<String>,
    scene: Option<usize>,
    #[serde(default)]
    scenes: Vec<Scene>,
    #[serde(default)]
    nodes: Vec<SceneNode>,
    #[serde(default)]
    meshes: Vec<MeshOf>,
    #[serde(default)]
    accessors: Vec<Accessor>,
    #[serde(default)]
    buffer_views: Vec<BufferView>,
    #[serde(default)]
    buffers: Vec<Buffer>,
}

#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
struct SceneNode {
    name: Option<String>,
    mesh: Option<usize>,
    #[serde(default)]
    children: Vec<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct MeshOf {
    #[serde(default)]
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    mode: Option<u32>,
}

#[derive(Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<serde::de::IgnoredAny>,
}

/// A file in memory.
struct Glb<'a> {
    document: Document,
    bytes: &'a [u8],
}

/// The nodes of the scene that the file shows (else of its first), parents before their children, in the
/// order of the file.
///
/// # Errors
/// [`MeshFileError`] with the path, when the file is not what it says or holds something that is not read.
pub fn read_glb_nodes(path: &Path) -> Result<Vec<GlbNode>, MeshFileError> {
    let nodes = nodes(path, &super::bytes_of(path)?)?;
    nodes.iter().try_for_each(|node| super::checked(path, &node.mesh))?;
    Ok(nodes)
}

pub(super) fn nodes(path: &Path, file: &[u8]) -> Result<Vec<GlbNode>, MeshFileError> {
    read(file).map_err(|fault| match fault {
        GlbFault::Words(words) => content(path, words),
        GlbFault::TooMany => too_many(path),
    })
}

enum GlbFault {
    Words(String),
    TooMany,
}

impl<T: Into<String>> From<T> for GlbFault {
    fn from(words: T) -> Self {
        Self::Words(words.into())
    }
}

fn read(file: &[u8]) -> Result<Vec<GlbNode>, GlbFault> {
    let (json, bytes) = chunks(file)?;
    let document: Document = serde_json::from_slice(json).map_err(|e| format!("its JSON cannot be read: {e}"))?;
    if !document.extensions_required.is_empty() {
        let names: Vec<String> =
            document.extensions_required.iter().take(5).map(|n| n.escape_default().to_string()).collect();
        return Err(format!("it needs {}: save it without compression and extensions", names.join(", ")).into());
    }
    let scene = document.scenes.get(document.scene.unwrap_or(0)).ok_or("the file has no scene")?;
    // Meter, Y up, to millimeter, Z up: x = 1000 x, y = -1000 z, z = 1000 y.
    let mm_from_gltf = Matrix4::new(
        MM_PER_M, 0.0, 0.0, 0.0, //
        0.0, 0.0, -MM_PER_M, 0.0, //
        0.0, MM_PER_M, 0.0, 0.0, //
        0.0, 0.0, 0.0, 1.0,
    );
    let mut open: Vec<_> = scene.nodes.iter().rev().map(|&node| (node, None, mm_from_gltf)).collect();
    let glb = Glb { document, bytes };
    let mut visited = vec![false; glb.document.nodes.len()];
    let mut triangles = 0;
    let mut found: Vec<GlbNode> = Vec::new();
    while let Some((index, parent, above)) = open.pop() {
        let node = glb.document.nodes.get(index).ok_or_else(|| format!("node {index} is not there"))?;
        if std::mem::replace(&mut visited[index], true) {
            let words = format!("node {index} is a child of two nodes or of itself, and a scene must be a tree");
            return Err(words.into());
        }
        let here = above * pose(node).ok_or_else(|| format!("the pose of node {index} is not valid"))?;
        let mut mesh = TriMesh::default();
        if let Some(at) = node.mesh {
            let of = glb.document.meshes.get(at).ok_or_else(|| format!("mesh {at} is not there"))?;
            for primitive in &of.primitives {
                let part = glb.primitive(primitive, &here, MAX_TRIANGLES - triangles)?;
                triangles += part.triangles.len();
                mesh.append(&part);
            }
        }
        let name = node.name.clone().unwrap_or_else(|| format!("node {index}"));
        open.extend(node.children.iter().rev().map(|&child| (child, Some(found.len()), here)));
        found.push(GlbNode { name, parent, mesh });
    }
    Ok(found)
}

/// Chunks JSON and BIN; the second one may be missing.
fn chunks(file: &[u8]) -> Result<(&[u8], &[u8]), GlbFault> {
    let word = |at: usize| {
        let bytes = file.get(at..at + 4)?;
        Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize)
    };
    if file.get(..4) != Some(b"glTF") {
        // The text form.
        return Ok((file, &[]));
    }
    if word(4) != Some(2) {
        return Err("it is not of version 2 of glTF".into());
    }
    let length = word(8).filter(|&n| n <= file.len()).ok_or("it is cut off")?;
    let chunk = |at: usize, kind: &[u8; 4]| {
        let size = word(at)?;
        let body = file.get(at + 8..(at + 8).checked_add(size)?)?;
        (file.get(at + 4..at + 8)? == kind && at + 8 + size <= length).then_some(body)
    };
    let json = chunk(12, b"JSON").ok_or("its first chunk is not whole, or not JSON")?;
    let second = 20 + json.len();
    let bytes =
        if second + 8 <= length { chunk(second, b"BIN\0").ok_or("its binary chunk is not whole")? } else { &[] };
    Ok((json, bytes))
}

fn pose(node: &SceneNode) -> Option<Matrix4<f64>> {
    let own = match node.matrix {
        Some(columns) => Matrix4::from_column_slice(&columns),
        None => {
            let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
            let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), SHORTEST_TURN)?;
            Matrix4::new_translation(&Vector3::from(node.translation.unwrap_or_default()))
                * turn.to_homogeneous()
                * Matrix4::new_nonuniform_scaling(&Vector3::from(node.scale.unwrap_or([1.0; 3])))
        }
    };
    own.iter().all(|x| x.is_finite()).then_some(own)
}

impl Glb<'_> {
    /// A primitive with its corners in millimeter.
    fn primitive(&self, primitive: &Primitive, mm_from_node: &Matrix4<f64>, most: usize) -> Result<TriMesh, GlbFault> {
        if primitive.mode.unwrap_or(TRIANGLES) != TRIANGLES {
            return Err("a mesh is not made of single triangles".into());
        }
        let positions = primitive.attributes.position.ok_or("a mesh has no positions")?;
        let positions: Vec<Point> = self
            .elements(positions, "VEC3", &[(FLOAT, 12)])?
            .1
            .map(|b| {
                let x = |at: usize| f64::from(f32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]]));
                mm_from_node.transform_point(&Point::new(x(0), x(4), x(8)))
            })
            .collect();
        let indices: Vec<u32> = match primitive.indices {
            None => (0..positions.len() as u32).collect(),
            Some(at) => {
                let (_, elements) = self.elements(at, "SCALAR", &[(5121, 1), (5123, 2), (5125, 4)])?;
                elements.map(|b| b.iter().rev().fold(0, |n, &byte| n << 8 | u32::from(byte))).collect()
            }
        };
        if indices.iter().any(|&i| i as usize >= positions.len()) {
            return Err("an index is past the last vertex".into());
        }
        if !indices.len().is_multiple_of(3) {
            return Err(format!("{} corners are not a whole number of triangles", indices.len()).into());
        }
        if indices.len() / 3 > most {
            return Err(GlbFault::TooMany);
        }
        // A mirrored node turns its triangles inside out.
        let mirrored = mm_from_node.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let turn = |t: &[u32]| if mirrored { [t[0], t[2], t[1]] } else { [t[0], t[1], t[2]] };
        Ok(TriMesh { positions, triangles: indices.chunks_exact(3).map(turn).collect() })
    }

    /// Bytes of an element, and the elements of an accessor, which has one of the types with their sizes.
    fn elements(
        &self,
        index: usize,
        kind: &str,
        types: &[(u32, usize)],
    ) -> Result<(usize, impl Iterator<Item = &[u8]>), GlbFault> {
        let words = |what: &str| GlbFault::from(format!("accessor {index} {what}"));
        let accessor = self.document.accessors.get(index).ok_or_else(|| words("is not there"))?;
        if accessor.sparse.is_some() {
            return Err(words("is sparse, which is not supported: save the mesh with all its positions"));
        }
        let known = types.iter().find(|(code, _)| *code == accessor.component_type);
        let &(_, size) =
            known.filter(|_| accessor.kind == kind).ok_or_else(|| words("has a type that is not allowed here"))?;
        let view = accessor.buffer_view.and_then(|at| self.document.buffer_views.get(at));
        let view = view.ok_or_else(|| words("has no buffer view"))?;
        if view.buffer != 0 || self.document.buffers.first().is_none_or(|buffer| buffer.uri.is_some()) {
            return Err(words("lies outside of the binary chunk, which is not read: save one .glb file"));
        }
        let end = view.byte_offset.checked_add(view.byte_length);
        let view_bytes = end.and_then(|end| self.bytes.get(view.byte_offset..end));
        let view_bytes = view_bytes.ok_or_else(|| words("has a buffer view past the end of the binary chunk"))?;
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            return Err(words("has a stride shorter than its elements"));
        }
        let bytes = view_bytes.get(accessor.byte_offset..).unwrap_or_default();
        // The last element need not fill its stride.
        let held = if bytes.len() < size { 0 } else { (bytes.len() - size) / stride + 1 };
        if accessor.count > held {
            return Err(words(&format!("announces {} elements, and {held} are there", accessor.count)));
        }
        Ok((size, (0..accessor.count).map(move |k| &bytes[k * stride..k * stride + size])))
    }
}
