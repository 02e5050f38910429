//! Machine models: one glTF binary file, whose named nodes become bodies.
//!
//! glTF is in meters with Y up; the machine is in millimeters with Z up: x = 1000 x, y = -1000 z, z = 1000
//! y. Node poses are applied, so that every mesh is in machine coordinates with all joints at zero.

use std::path::Path;

use proveout_geom::{GlbNode, TriMesh, read_glb_nodes};

/// The nodes of a file; parents come before their children.
#[derive(Debug)]
pub(crate) struct Model {
    nodes: Vec<GlbNode>,
}

impl Model {
    /// Reads a file; the error is a sentence with the path.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let joined = |node: GlbNode| GlbNode { mesh: node.mesh.merge_equal_vertices(), ..node };
        let nodes = read_glb_nodes(path).map_err(|e| e.to_string())?;
        Ok(Self { nodes: nodes.into_iter().map(joined).collect() })
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
        let loose = |(i, n): &(usize, &GlbNode)| !n.mesh.triangles.is_empty() && self.owner(*i, bound).is_none();
        self.nodes.iter().enumerate().filter(loose).map(|(_, n)| n.name.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::{fs, path::PathBuf};

    use proveout_geom::{Aabb, Point};

    use super::*;
    use crate::Machine;

    /// A glTF binary with one tetrahedron of 1 m edges along the axes, at the nodes Column (1 m to the right
    /// and 2 m up), its child Head (turned by a quarter about glTF's y and 0.5 m up), and Loose.
    fn write_model(folder: &Path) -> PathBuf {
        let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2]}],
            "nodes":[{"name":"Column","mesh":0,"translation":[1,2,0],"children":[1]},
                     {"name":"Head","mesh":0,"translation":[0,0.5,0],"rotation":[0,0.7071067811865476,0,0.7071067811865476]},
                     {"name":"Loose","mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
                         {"bufferView":1,"componentType":5121,"count":12,"type":"SCALAR"}],
            "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
            "buffers":[{"byteLength":60}]}"#;
        let mut json = json.as_bytes().to_vec();
        while !json.len().is_multiple_of(4) {
            json.push(b' ');
        }
        let mut bin = Vec::new();
        for p in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            bin.extend(p.iter().flat_map(|v| v.to_le_bytes()));
        }
        bin.extend([0_u8, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
        let mut file = Vec::new();
        let word = |n: usize| (n as u32).to_le_bytes();
        file.extend(b"glTF");
        file.extend(word(2));
        file.extend(word(12 + 8 + json.len() + 8 + bin.len()));
        file.extend(word(json.len()));
        file.extend(b"JSON");
        file.extend(&json);
        file.extend(word(bin.len()));
        file.extend(b"BIN\0");
        file.extend(&bin);
        let path = folder.join("model.glb");
        fs::write(&path, file).expect("written");
        path
    }

    fn near(a: &Aabb, min: [f64; 3], max: [f64; 3]) -> bool {
        (a.min - Point::from(min)).norm() < 1e-3 && (a.max - Point::from(max)).norm() < 1e-3
    }

    #[test]
    fn nodes_stand_in_machine_coordinates() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let model = Model::read(&write_model(folder.path())).expect("read");
        assert_eq!(model.names(), ["Column", "Head", "Loose"]);
        // glTF x, y (up), z become x, z, -y: 1 m right and 2 m up, the tetrahedron's z edge to the front.
        let column = model.node_mesh("Column", &["Column", "Head"]).expect("node");
        assert!(near(&column.aabb(), [1000.0, -1000.0, 2000.0], [2000.0, 0.0, 3000.0]), "{:?}", column.aabb());
        // A quarter about the upright axis turns the x edge to the back (glTF -z, machine +y), the z edge to
        // +x.
        let head = model.node_mesh("Head", &["Column", "Head"]).expect("node");
        assert!(near(&head.aabb(), [1000.0, 0.0, 2500.0], [2000.0, 1000.0, 3500.0]), "{:?}", head.aabb());
        for mesh in [&column, &head] {
            mesh.check_solid().expect("still a solid with outward faces");
        }
        let both = model.node_mesh("Column", &["Column"]).expect("node");
        assert_eq!(both.triangles.len(), 8, "an unbound child belongs to its parent");
        assert_eq!(model.nodes_without(&["Column"]), ["Loose"]);
        assert!(model.node_mesh("Table", &[]).is_none());
    }

    #[test]
    fn a_machine_takes_its_bodies_from_the_model() {
        let folder = tempfile::tempdir().expect("temporary folder");
        write_model(folder.path());
        let text = r#"
name = "with a model"
model = "model.glb"
spindle = { on = "Z", origin_mm = [0, 0, 0], direction = [0, 0, 1], start_time_s = 1 }
table = { on = "base", point_mm = [0, 0, 0], normal = [0, 0, 1] }
control = { cycle_time_ms = 1, block_time_ms = 0, tool_change_time_s = 5, rapid_mode = "independent", default_tolerance_mm = 0.01 }
[[joint]]
name = "Z"
kind = "linear"
carries = "tool"
parent = "base"
direction = [0, 0, 1]
[[body]]
name = "column"
role = "column"
attached_to = "Z"
check = true
node = "Column"
"#;
        let file = folder.path().join("machine.toml");
        fs::write(&file, text).expect("written");
        let machine = Machine::read(&file).expect("read");
        assert_eq!(machine.bodies[0].mesh.triangles.len(), 8);
        let unused = machine.diagnose().into_iter().find(|d| d.code == "machine-model-node-unused");
        assert!(unused.expect("Loose is in no body").message.contains("Loose"));
        let wrong = text.replace("node = \"Column\"", "node = \"Colum\"");
        let error = Machine::from_text(&file, &wrong).expect_err("no such node");
        let reason = error.to_string();
        assert!(
            reason.contains("no node \"Colum\"") && reason.contains("the model has Column, Head, Loose"),
            "{reason}"
        );
    }

    #[test]
    fn damaged_models_are_refused_with_their_path() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = write_model(folder.path());
        let good = fs::read(&path).expect("read");
        for cut in [0, 3, 12, 20, good.len() - 20] {
            fs::write(&path, &good[..cut]).expect("written");
            assert!(Model::read(&path).expect_err("damaged").contains("model.glb"));
        }
    }
}
