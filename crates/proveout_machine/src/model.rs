//! Machine models: one glTF binary file, whose named nodes become bodies.
//!
//! glTF is in metre with Y up; the machine is in millimetre with Z up: x = 1000 x, y = -1000 z, z = 1000 y. Node poses
//! are applied, so that every mesh stands in machine coordinates with all joints at zero.

use std::{fs::File, io::BufReader, path::Path};

use nalgebra::Matrix4;
use proveout_geom::{Point, TriMesh};

/// A node with its own mesh (not its children's) in machine coordinates.
#[derive(Debug)]
struct Node {
    name: String,
    parent: Option<usize>,
    mesh: TriMesh,
}

/// The nodes of a file; parents stand before their children.
#[derive(Debug)]
pub(crate) struct Model {
    nodes: Vec<Node>,
}

impl Model {
    /// Reads a file; the error is a sentence with the path.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let shown = path.display();
        let file = File::open(path).map_err(|e| format!("cannot open {shown}: {e}"))?;
        let gltf = gltf::Gltf::from_reader(BufReader::new(file)).map_err(|e| format!("{shown}: {e}"))?;
        let scene = gltf.default_scene().or_else(|| gltf.scenes().next());
        let scene = scene.ok_or_else(|| format!("{shown}: the file has no scene"))?;
        let mm_from_gltf = Matrix4::new(
            1e3, 0.0, 0.0, 0.0, //
            0.0, 0.0, -1e3, 0.0, //
            0.0, 1e3, 0.0, 0.0, //
            0.0, 0.0, 0.0, 1.0,
        );
        let mut model = Self { nodes: Vec::new() };
        let mut open: Vec<_> = scene.nodes().map(|n| (n, None, mm_from_gltf)).collect();
        open.reverse();
        while let Some((node, parent, above)) = open.pop() {
            let local = node.transform().matrix();
            let here = above * Matrix4::from_fn(|row, column| f64::from(local[column][row]));
            let mut mesh = TriMesh::default();
            for primitive in node.mesh().into_iter().flat_map(|m| m.primitives().collect::<Vec<_>>()) {
                mesh.append(&read_primitive(&primitive, gltf.blob.as_deref(), &here).map_err(|e| format!("{shown}: {e}"))?);
            }
            let index = model.nodes.len();
            let name = node.name().map_or_else(|| format!("node {}", node.index()), str::to_owned);
            model.nodes.push(Node { name, parent, mesh: mesh.merge_equal_vertices() });
            let mut children: Vec<_> = node.children().map(|child| (child, Some(index), here)).collect();
            children.reverse();
            open.append(&mut children);
        }
        Ok(model)
    }

    /// Names of all nodes.
    pub(crate) fn names(&self) -> Vec<&str> {
        self.nodes.iter().map(|n| n.name.as_str()).collect()
    }

    /// The nearest node upward, the node itself included, that is bound to a body.
    fn owner(&self, mut index: usize, bound: &[&str]) -> Option<&str> {
        loop {
            let node = &self.nodes[index];
            if bound.contains(&node.name.as_str()) {
                return Some(&node.name);
            }
            index = node.parent?;
        }
    }

    /// Meshes of a node and of all below it that no other body has; `None` without such a node.
    pub(crate) fn node_mesh(&self, name: &str, bound: &[&str]) -> Option<TriMesh> {
        self.nodes.iter().find(|n| n.name == name)?;
        let mut mesh = TriMesh::default();
        for (i, node) in self.nodes.iter().enumerate() {
            if self.owner(i, bound) == Some(name) {
                mesh.append(&node.mesh);
            }
        }
        Some(mesh)
    }

    /// Nodes with meshes that no body has.
    pub(crate) fn nodes_without(&self, bound: &[&str]) -> Vec<String> {
        let loose = |(i, n): &(usize, &Node)| !n.mesh.triangles.is_empty() && self.owner(*i, bound).is_none();
        self.nodes.iter().enumerate().filter(loose).map(|(_, n)| n.name.clone()).collect()
    }
}

fn read_primitive(
    primitive: &gltf::Primitive<'_>,
    blob: Option<&[u8]>,
    mm_from_node: &Matrix4<f64>,
) -> Result<TriMesh, String> {
    if primitive.mode() != gltf::mesh::Mode::Triangles {
        return Err("a mesh is not made of triangles".into());
    }
    let reader = primitive.reader(|buffer| match buffer.source() {
        gltf::buffer::Source::Bin => blob,
        gltf::buffer::Source::Uri(_) => None,
    });
    let positions = reader.read_positions().ok_or("a mesh has no positions in the binary chunk")?;
    let to_mm = |p: [f32; 3]| mm_from_node.transform_point(&Point::from(p.map(f64::from)));
    let positions: Vec<Point> = positions.map(to_mm).collect();
    let indices: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..positions.len() as u32).collect(),
    };
    if indices.iter().any(|&i| i as usize >= positions.len()) {
        return Err("an index is past the last vertex".into());
    }
    // A mirrored node turns its triangles inside out.
    let mirrored = mm_from_node.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
    let turn = |t: &[u32]| if mirrored { [t[0], t[2], t[1]] } else { [t[0], t[1], t[2]] };
    Ok(TriMesh { positions, triangles: indices.chunks_exact(3).map(turn).collect() })
}
