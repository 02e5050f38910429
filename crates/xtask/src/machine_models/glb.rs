//! glTF binary files: one node a part, below the node of the joint that carries it.
//!
//! glTF is in meters with Y up: (x, y, z) of the machine becomes (x, z, -y) / 1000. The node of a rotary
//! joint is at its axis, so that a viewer can turn it. No normals are written, which glTF 2.0 (section
//! 3.7.2.1) defines as flat facets. Coordinates are rounded to a micrometer first, so that the bytes do not
//! depend on the last digit of a sine.

use std::{collections::BTreeMap, io};

use proveout_geom::write_glb_container;
use serde_json::json;

use crate::machine_models::{numbers::KinematicNumbers, part::MachinePart, solid::V3};

/// A vertex in meter, Y up.
fn vertex(p: V3, origin: V3) -> [f32; 3] {
    let [x, y, z] = [0, 1, 2].map(|k| (p[k] * 1e3).round() - (origin[k] * 1e3).round());
    [x, z, -y].map(|v| (v * 1e-6) as f32 + 0.0)
}

/// sRGB byte to the linear value that glTF wants, to four digits.
fn linear(byte: u8) -> f64 {
    let v = f64::from(byte) / 255.0;
    let l = if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    (l * 1e4).round() / 1e4
}

/// The bytes of `model.glb`.
///
/// # Errors
/// Parts above 4 GiB, which the format cannot hold.
pub(crate) fn bytes(numbers: &KinematicNumbers, parts: &[MachinePart]) -> io::Result<Vec<u8>> {
    let mut bin: Vec<u8> = Vec::new();
    let (mut nodes, mut meshes, mut accessors, mut views, mut materials) = (vec![], vec![], vec![], vec![], vec![]);
    let mut material_of: BTreeMap<[u8; 3], usize> = BTreeMap::new();

    // Node 0 is the base, node 1 + j joint j.
    let joint_node = |name: &str| numbers.joints.iter().position(|j| j.name == name).map_or(0, |j| 1 + j);
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); 1 + numbers.joints.len()];
    let mut origins = vec![[0.0; 3]];
    for (j, joint) in numbers.joints.iter().enumerate() {
        children[joint_node(&joint.parent)].push(1 + j);
        let parent = joint_node(&joint.parent);
        let above = if parent <= j { origins[parent] } else { [0.0; 3] };
        origins.push(joint.point.unwrap_or(above));
    }
    for (k, part) in parts.iter().enumerate() {
        let owner = joint_node(&part.on);
        children[owner].push(1 + numbers.joints.len() + k);
        let material = *material_of.entry(part.color).or_insert_with(|| {
            let [r, g, b] = part.color.map(linear);
            let metal = if part.bright { 0.6 } else { 0.1 };
            materials.push(json!({
                "pbrMetallicRoughness":
                    {"baseColorFactor": [r, g, b, 1.0], "metallicFactor": metal, "roughnessFactor": 0.55}
            }));
            materials.len() - 1
        });
        let (points, triangles) = merged(part, origins[owner]);
        let low = [0, 1, 2].map(|c| points.iter().map(|p| p[c]).fold(f32::INFINITY, f32::min));
        let high = [0, 1, 2].map(|c| points.iter().map(|p| p[c]).fold(f32::NEG_INFINITY, f32::max));
        let wide = points.len() > usize::from(u16::MAX);
        let start = bin.len();
        bin.extend(points.iter().flatten().flat_map(|v| v.to_le_bytes()));
        views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": bin.len() - start, "target": 34962}));
        accessors.push(json!({"bufferView": views.len() - 1, "componentType": 5126, "count": points.len(),
            "type": "VEC3", "min": low, "max": high}));
        let start = bin.len();
        for index in triangles.iter().flatten() {
            if wide {
                bin.extend(index.to_le_bytes());
            } else {
                bin.extend((*index as u16).to_le_bytes());
            }
        }
        views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": bin.len() - start, "target": 34963}));
        accessors.push(json!({"bufferView": views.len() - 1, "componentType": if wide { 5125 } else { 5123 },
            "count": 3 * triangles.len(), "type": "SCALAR"}));
        bin.resize(bin.len().next_multiple_of(4), 0);
        meshes.push(json!({"name": part.name, "primitives": [{"attributes": {"POSITION": accessors.len() - 2},
            "indices": accessors.len() - 1, "material": material}]}));
    }
    for (j, below) in children.iter().enumerate() {
        let mut node = json!({"name": "base"});
        if let Some(joint) = j.checked_sub(1).and_then(|j| numbers.joints.get(j)) {
            let parent = joint_node(&joint.parent);
            node["name"] = json!(format!("joint_{}", joint.name));
            let from_parent = vertex(origins[j], origins[parent]);
            if from_parent != [0.0; 3] {
                node["translation"] = json!(from_parent);
            }
        }
        if !below.is_empty() {
            node["children"] = json!(below);
        }
        nodes.push(node);
    }
    nodes.extend(parts.iter().enumerate().map(|(k, part)| json!({"name": part.name, "mesh": k})));
    let document = json!({
        "asset": {"version": "2.0", "generator": "cargo xtask machine-models"},
        "scene": 0, "scenes": [{"name": numbers.name, "nodes": [0]}], "nodes": nodes, "meshes": meshes,
        "materials": materials, "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": bin.len()}]
    });
    let mut file = Vec::new();
    write_glb_container(&mut file, document.to_string().as_bytes(), bin.len(), |out| out.write_all(&bin))?;
    Ok(file)
}

/// Equal vertices joined, as seen by readers in single precision; triangles that lost a corner by it are left
/// out.
fn merged(part: &MachinePart, origin: V3) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut seen: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for triangle in &part.solid.triangles {
        let t = triangle.map(|i| {
            let p = vertex(part.solid.points[i as usize], origin);
            *seen.entry(p.map(f32::to_bits)).or_insert_with(|| {
                points.push(p);
                points.len() as u32 - 1
            })
        });
        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
            triangles.push(t);
        }
    }
    (points, triangles)
}
