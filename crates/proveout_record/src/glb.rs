//! Binary glTF 2.0: one mesh, written in a stable byte order.

use std::{
    fs::File,
    io::{self, BufWriter, Write},
    path::Path,
};

use gltf_json::{
    Accessor, Asset, Buffer, Index, Material, Mesh, Node, Root, Scene,
    accessor::{ComponentType, GenericComponentType, IndexComponentType, Type},
    buffer::{Target, View},
    material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor},
    mesh::{Mode, Primitive, Semantic},
    scene::UnitQuaternion,
    validation::{Checked::Valid, USize64},
};

use proveout_geom::write_glb_container;

use crate::{
    color::{Rgba, STEEL, linear_from_srgb},
    picture::Picture,
};

/// Millimeter, Z up (workpiece) to meter, Y up (glTF): scale, and a turn by -90 degrees about X as quaternion
/// x y z w.
const METRE_FROM_MM: [f32; 3] = [1e-3; 3];
const Y_UP_FROM_Z_UP: [f32; 4] = [-std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2];

/// Writes a file with a mesh of the color of steel where it has no colors.
pub(crate) fn write_glb_file(
    path: &Path,
    name: &str,
    note: &str,
    picture: &Picture,
    colors: &[Rgba],
) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    write_glb(&mut out, name, note, picture, colors, STEEL)?;
    out.flush()
}

/// Writes a mesh as binary glTF. Vertices stay in mm and the frame of `picture`; the root node carries the
/// scale to meter and the turn to Y up. `colors` (one a vertex) are turned from sRGB to linear light, as
/// `COLOR_0` wants them; without them the material gets the color `plain`. `note` goes to the extras of the
/// asset. A mesh without triangles gives a file whose only node has no mesh.
///
/// # Errors
/// What `out` returns, or a mesh above 4 GiB, which the format cannot hold.
fn write_glb(
    out: &mut impl Write,
    name: &str,
    note: &str,
    picture: &Picture,
    colors: &[Rgba],
    plain: Rgba,
) -> io::Result<()> {
    let extras = serde_json::json!({ "unit": "millimeter in the mesh, meter at the root", "note": note }).to_string();
    let mut root = Root {
        asset: Asset {
            generator: Some(format!("proveout {}", env!("CARGO_PKG_VERSION"))),
            extras: serde_json::value::RawValue::from_string(extras).ok(),
            ..Asset::default()
        },
        ..Root::default()
    };
    let colors = if colors.len() == picture.positions.len() { colors } else { &[] };
    let bin = if picture.triangles.is_empty() {
        root.push(Node { name: Some(name.into()), ..Node::default() });
        0
    } else {
        add_mesh(&mut root, name, picture, !colors.is_empty(), plain)?
    };
    let scene =
        root.push(Scene { extensions: None, extras: None, name: Some(name.into()), nodes: vec![Index::new(0)] });
    root.scene = Some(scene);

    let json = root.to_vec().map_err(io::Error::other)?;
    write_glb_container(out, &json, bin, |out| {
        // In the order of the views of `add_mesh`, number by number: no copy of the mesh is made.
        for v in picture.positions.iter().chain(&picture.normals).flatten() {
            out.write_all(&v.to_le_bytes())?;
        }
        let light = lights();
        for c in colors {
            out.write_all(&light(c))?;
        }
        for i in picture.triangles.iter().flatten() {
            out.write_all(&i.to_le_bytes())?;
        }
        Ok(())
    })
}

/// From sRGB to linear light.
fn lights() -> impl Fn(&Rgba) -> Rgba {
    let linear: [u8; 256] = std::array::from_fn(|c| (linear_from_srgb(c as u8) * 255.0).round() as u8);
    move |c| [linear[c[0] as usize], linear[c[1] as usize], linear[c[2] as usize], c[3]]
}

fn too_large() -> io::Error {
    io::Error::other("the mesh is above 4 GiB, which binary glTF cannot hold")
}

/// Adds buffer, accessors, material, mesh and root node; gives the length of the binary chunk (every part is
/// a multiple of 4 bytes).
fn add_mesh(root: &mut Root, name: &str, picture: &Picture, colored: bool, plain: Rgba) -> io::Result<usize> {
    let bounds = picture.positions.iter().fold([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]], |[low, high], p| {
        [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
    });
    let mut parts = GlbChunks { root, bin: 0 };
    let vertices = picture.positions.len();
    let float = ComponentType::F32;
    let position = parts.vertices(12, vertices, float, Type::Vec3)?;
    parts.root.accessors[position.value()].min = Some(serde_json::json!(bounds[0]));
    parts.root.accessors[position.value()].max = Some(serde_json::json!(bounds[1]));
    let mut attributes = std::collections::BTreeMap::from([
        (Valid(Semantic::Positions), position),
        (Valid(Semantic::Normals), parts.vertices(12, vertices, float, Type::Vec3)?),
    ]);
    if colored {
        let color = parts.vertices(4, vertices, ComponentType::U8, Type::Vec4)?;
        parts.root.accessors[color.value()].normalized = true;
        attributes.insert(Valid(Semantic::Colors(0)), color);
    }
    let indices = parts.indices(3 * picture.triangles.len())?;
    let GlbChunks { root, bin } = parts;

    let base = if colored { [1.0; 4] } else { lights()(&plain).map(|c| f32::from(c) / 255.0) };
    let material = root.push(Material {
        name: Some("skin".into()),
        double_sided: true,
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor(base),
            metallic_factor: StrengthFactor(0.1),
            roughness_factor: StrengthFactor(0.6),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    });
    let primitive = Primitive {
        attributes,
        extensions: None,
        extras: None,
        indices: Some(indices),
        material: Some(material),
        mode: Valid(Mode::Triangles),
        targets: None,
    };
    let mesh = root.push(Mesh {
        extensions: None,
        extras: None,
        name: Some(name.into()),
        primitives: vec![primitive],
        weights: None,
    });
    root.push(Node {
        mesh: Some(mesh),
        name: Some(name.into()),
        rotation: Some(UnitQuaternion(Y_UP_FROM_Z_UP)),
        scale: Some(METRE_FROM_MM),
        ..Node::default()
    });
    root.push(Buffer { byte_length: USize64::from(bin), name: None, uri: None, extensions: None, extras: None });
    Ok(bin)
}

struct GlbChunks<'a> {
    root: &'a mut Root,
    /// Length of the binary chunk so far.
    bin: usize,
}

impl GlbChunks<'_> {
    fn view(&mut self, length: usize, target: Target) -> io::Result<Index<View>> {
        let offset = self.bin;
        self.bin += length;
        u32::try_from(self.bin).map_err(|_above| too_large())?;
        Ok(self.root.push(View {
            buffer: Index::new(0),
            byte_length: USize64::from(length),
            byte_offset: Some(USize64::from(offset)),
            byte_stride: None,
            name: None,
            target: Some(Valid(target)),
            extensions: None,
            extras: None,
        }))
    }

    /// `bytes` of a vertex.
    fn vertices(&mut self, bytes: usize, count: usize, part: ComponentType, kind: Type) -> io::Result<Index<Accessor>> {
        let view = self.view(bytes * count, Target::ArrayBuffer)?;
        Ok(self.root.push(accessor(view, count, GenericComponentType(part), kind)))
    }

    fn indices(&mut self, count: usize) -> io::Result<Index<Accessor>> {
        let view = self.view(4 * count, Target::ElementArrayBuffer)?;
        let part: ComponentType = IndexComponentType(ComponentType::U32).0;
        Ok(self.root.push(accessor(view, count, GenericComponentType(part), Type::Scalar)))
    }
}

fn accessor(view: Index<View>, count: usize, part: GenericComponentType, kind: Type) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: Some(USize64(0)),
        count: USize64::from(count),
        component_type: Valid(part),
        type_: Valid(kind),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
        extensions: None,
        extras: None,
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, Point, box_mesh};

    use super::*;
    use crate::color::STEEL;

    fn picture() -> Picture {
        let mesh = box_mesh(&Aabb { min: Point::new(-1.0, 0.0, 0.0), max: Point::new(10.0, 20.0, 30.0) });
        Picture::new(&mesh, &[], &[])
    }

    fn bytes(picture: &Picture, colors: &[Rgba]) -> Vec<u8> {
        let mut out = Vec::new();
        write_glb(&mut out, "part", "whole \"part\"", picture, colors, STEEL).expect("a vector takes everything");
        out
    }

    #[test]
    fn an_independent_reader_finds_the_same_mesh() {
        let picture = picture();
        let colors: Vec<Rgba> = (0..8).map(|i| [i * 30, 255, 0, 255]).collect();
        let file = gltf::Gltf::from_slice(&bytes(&picture, &colors)).expect("valid glTF");
        let blob = file.blob.as_deref().expect("binary chunk");
        let node = file.default_scene().expect("scene").nodes().next().expect("root node");
        let mesh = node.mesh().expect("mesh");
        let primitive = mesh.primitives().next().expect("primitive");
        let reader = primitive.reader(|_| Some(blob));
        let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
        assert_eq!(positions, picture.positions);
        assert_eq!(reader.read_normals().expect("normals").count(), 8);
        let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
        assert_eq!(indices, picture.triangles.concat());
        let colors: Vec<[u8; 4]> = reader.read_colors(0).expect("colors").into_rgba_u8().collect();
        assert_eq!(colors[0], [0, 255, 0, 255], "0 and 255 are the same in linear light");
        assert_eq!(primitive.bounding_box().max, [10.0, 20.0, 30.0]);
        // Z up in mm becomes Y up in meter.
        let m = node.transform().matrix();
        let to = |p: [f32; 3]| [0, 1, 2].map(|r| m[0][r] * p[0] + m[1][r] * p[1] + m[2][r] * p[2] + m[3][r]);
        let up = to([0.0, 0.0, 1000.0]);
        assert!((up[1] - 1.0).abs() < 1e-6 && up[0].abs() < 1e-6 && up[2].abs() < 1e-6, "{up:?}");
        let depth = to([0.0, 1000.0, 0.0]);
        assert!((depth[2] + 1.0).abs() < 1e-6, "Y of the workpiece looks away from the viewer");
    }

    #[test]
    fn same_mesh_same_bytes_and_plain_color() {
        assert_eq!(bytes(&picture(), &[]), bytes(&picture(), &[]));
        let file = gltf::Gltf::from_slice(&bytes(&picture(), &[])).expect("valid glTF");
        let base = file.materials().next().expect("material").pbr_metallic_roughness().base_color_factor();
        assert!((f64::from(base[0]) - linear_from_srgb(STEEL[0])).abs() < 3e-3);
    }

    #[test]
    fn nothing_to_show_gives_a_valid_file_without_mesh() {
        let file = gltf::Gltf::from_slice(&bytes(&Picture::default(), &[])).expect("valid glTF");
        let nodes: Vec<_> = file.default_scene().expect("scene").nodes().collect();
        assert!(nodes.len() == 1 && nodes[0].mesh().is_none());
    }
}
