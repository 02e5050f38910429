//! Bodies from primitives and from model nodes.

use std::f64::consts::PI;

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, box_mesh, revolved_mesh};
use proveout_input::{Document, Step, Step::Item, Step::Key};

use crate::{
    Attachment, MachineBody,
    description::{AlongFile, BodyFile, BoxFile, CylinderFile, MachineFile, PrismFile},
    mass::{check_densities, read_mass},
    model::Model,
    reading::{Checked, finite_vector},
};

/// Largest distance (mm) from the cylinder to the edges of its facets. The facets touch the cylinder from
/// outside, so the faceted body is nowhere smaller than the real one, and larger by no more than this. That
/// is below any usual clearance between machine parts, and coarse enough for a few hundred facets per body.
const FACET_TOLERANCE_MM: f64 = 0.05;
/// Sine of the angle to Z below which a direction is along it.
const PARALLEL: f64 = 1e-12;
/// Angles of a convex outline add up to a turn within this, radian: rounding.
const ONE_TURN: f64 = 1e-6;

/// Color of a body that states none: the gray of castings.
const DEFAULT_COLOR: [u8; 4] = [150, 155, 160, 255];

/// All bodies, and the model nodes with meshes that none of them uses.
pub(crate) fn read_bodies(
    source: &Document<'_>,
    content: &MachineFile,
    attachment: impl Fn(&[Step<'_>], &str) -> Checked<Attachment>,
) -> Checked<(Vec<MachineBody>, Vec<String>)> {
    let model = match &content.model {
        None => None,
        Some(name) => {
            let path = source.file().with_file_name(name);
            let model = Model::read(&path).map_err(|message| {
                source.error(
                    "machine-model",
                    &[Key("model")],
                    message,
                    "name a .glb file in the folder of machine.toml",
                )
            })?;
            Some(model)
        }
    };
    check_densities(source, content)?;
    let bound: Vec<&str> = content.body.iter().filter_map(|b| b.node.as_deref()).collect();
    let mut bodies: Vec<MachineBody> = Vec::new();
    for (i, body) in content.body.iter().enumerate() {
        let at = |key| [Key("body"), Item(i), Key(key)];
        if bodies.iter().any(|b| b.name == body.name) {
            let message = format!("two bodies have the name {:?}", body.name);
            return Err(source.error("machine-duplicate-body", &at("name"), message, "give each body its own name"));
        }
        let attached_to = attachment(&at("attached_to"), &body.attached_to)?;
        let color = match body.color.as_deref() {
            None => DEFAULT_COLOR,
            Some(&[r, g, b]) => [r, g, b, 255],
            Some(&[r, g, b, a]) => [r, g, b, a],
            Some(other) => {
                let message = format!("a color has 3 or 4 numbers, not {}", other.len());
                return Err(source.error("machine-color", &at("color"), message, "write red, green, blue, 0 to 255"));
            }
        };
        let mesh = body_mesh(source, i, body, model.as_ref(), &bound)?;
        let mass = read_mass(source, i, content, &mesh)?;
        let (name, role) = (body.name.clone(), body.role.clone());
        bodies.push(MachineBody { name, role, attached_to, mesh, mass, color, check: body.check });
    }
    Ok((bodies, model.map_or_else(Vec::new, |m| m.nodes_without(&bound))))
}

fn body_mesh(
    source: &Document<'_>,
    index: usize,
    body: &BodyFile,
    model: Option<&Model>,
    bound: &[&str],
) -> Checked<TriMesh> {
    let at = |key| [Key("body"), Item(index), Key(key)];
    let mut mesh = TriMesh::default();
    if let Some(node) = &body.node {
        let Some(model) = model else {
            let remedy = "add model = \"model.glb\" at the top of the file";
            return Err(source.error("machine-model", &at("node"), "the machine has no model file", remedy));
        };
        match model.node_mesh(node, bound) {
            Some(part) if !part.triangles.is_empty() => mesh.append(&part),
            Some(_) => {
                let message = format!("node {node:?} has no mesh");
                return Err(source.error("machine-model", &at("node"), message, "name a node with a mesh below it"));
            }
            None => {
                let remedy = format!("the model has {}", model.names().join(", "));
                let message = format!("the model has no node {node:?}");
                return Err(source.error("machine-model", &at("node"), message, remedy));
            }
        }
    }
    for (k, part) in body.boxes.iter().enumerate() {
        mesh.append(&part_box(source, &[Key("body"), Item(index), Key("box"), Item(k)], part)?);
    }
    for (k, part) in body.cylinders.iter().enumerate() {
        mesh.append(&part_cylinder(source, &[Key("body"), Item(index), Key("cylinder"), Item(k)], part)?);
    }
    for (k, part) in body.prisms.iter().enumerate() {
        mesh.append(&part_prism(source, &[Key("body"), Item(index), Key("prism"), Item(k)], part)?);
    }
    if mesh.triangles.is_empty() {
        let remedy = "add a box, a cylinder, a prism or a node";
        return Err(source.error("machine-empty-body", &at("name"), "the body has no shape", remedy));
    }
    Ok(mesh)
}

fn part_box(source: &Document<'_>, path: &[Step<'_>], part: &BoxFile) -> Checked<TriMesh> {
    let min = Point::from(finite_vector(source, path, part.min_mm)?);
    let max = Point::from(finite_vector(source, path, part.max_mm)?);
    if (0..3).any(|k| min[k] >= max[k]) {
        let message = format!("the box from {:?} to {:?} is empty", part.min_mm, part.max_mm);
        return Err(source.error("machine-empty-body", path, message, "write the smaller coordinates as min_mm"));
    }
    Ok(box_mesh(&Aabb { min, max }))
}

fn part_cylinder(source: &Document<'_>, path: &[Step<'_>], part: &CylinderFile) -> Checked<TriMesh> {
    let from = finite_vector(source, path, part.from_mm)?;
    let along = finite_vector(source, path, part.to_mm)? - from;
    let radii = [part.radius_mm, part.end_radius_mm.unwrap_or(part.radius_mm)];
    let length = along.norm();
    if !(length > 0.0 && radii.iter().all(|r| *r > 0.0 && r.is_finite())) {
        let message = format!("a cylinder of length {length} and radii {radii:?} is empty");
        return Err(source.error("machine-empty-body", path, message, "write two places and a radius above zero"));
    }
    Ok(round_body(from, along, radii))
}

/// Cylinder or cone from a place along a vector that is not zero, with the radii of both ends, mm.
fn round_body(from: Vector, along: Vector, radii: [f64; 2]) -> TriMesh {
    let length = along.norm();
    let largest = radii[0].max(radii[1]);
    let half_sector = (largest / (largest + FACET_TOLERANCE_MM)).acos();
    let sectors = ((PI / half_sector).ceil() as usize).max(12);
    // Rounding must not bring a facet inside.
    let [foot, top] = radii.map(|r| r / (PI / sectors as f64).cos() * (1.0 + 4.0 * f64::EPSILON));
    let upright = revolved_mesh(&[[0.0, 0.0], [foot, 0.0], [top, length], [0.0, length]], sectors);
    let z = along / length;
    let across = Vector::z().cross(&z);
    let turn = match across.try_normalize(PARALLEL) {
        Some(axis) => Pose::from_axis_angle(&axis, across.norm().atan2(z.z)),
        None if z.z > 0.0 => Pose::identity(),
        None => Pose::from_axis_angle(&Vector::x(), PI),
    };
    upright.transformed(&Pose { translation: from, ..turn })
}

fn part_prism(source: &Document<'_>, path: &[Step<'_>], part: &PrismFile) -> Checked<TriMesh> {
    let [low, high] = part.range_mm;
    let outline = &part.outline_mm;
    let n = outline.len();
    let wrong = |message: &str, remedy: &str| Err(source.error("machine-empty-body", path, message, remedy));
    let finite = outline.iter().flatten().chain(&part.range_mm).all(|v| v.is_finite());
    if !(low < high && n >= 3 && finite) {
        return wrong("a prism needs a range and three corners", "write the lower end of range_mm first");
    }
    let edge = |k: usize| {
        let ([ax, ay], [bx, by]) = (outline[k % n], outline[(k + 1) % n]);
        [bx - ax, by - ay]
    };
    let turns_left = |k: usize| {
        let ([ax, ay], [bx, by]) = (edge(k), edge(k + 1));
        ax * by - ay * bx > 0.0
    };
    let winding: f64 = (0..n)
        .map(|k| {
            let ([ax, ay], [bx, by]) = (edge(k), edge(k + 1));
            (ax * by - ay * bx).atan2(ax * bx + ay * by)
        })
        .sum();
    if !(0..n).all(turns_left) || (winding - 2.0 * PI).abs() > ONE_TURN {
        return wrong("the outline is not convex and counter-clockwise", "split it, or turn the order of its corners");
    }
    let place = |[a, b]: [f64; 2], t: f64| match part.along {
        AlongFile::X => Point::new(t, a, b),
        AlongFile::Y => Point::new(b, t, a),
        AlongFile::Z => Point::new(a, b, t),
    };
    let ends = outline.iter().map(|&c| place(c, low)).chain(outline.iter().map(|&c| place(c, high)));
    let mut mesh = TriMesh { positions: ends.collect(), triangles: Vec::new() };
    let count = n as u32;
    for k in 0..count {
        let next = (k + 1) % count;
        mesh.triangles.extend([[k, next, count + next], [k, count + next, count + k]]);
        if k >= 1 && k + 1 < count {
            mesh.triangles.extend([[0, k + 1, k], [count, count + k, count + k + 1]]);
        }
    }
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No facet of a round body cuts into the true shape, and no corner protrudes by more than the stated
    /// tolerance.
    #[test]
    fn cylinders_and_cones_are_nowhere_smaller_than_said() {
        for (from, to, radii) in [
            ([0.0, 0.0, 0.0], [0.0, 0.0, 80.0], [50.0, 50.0]),
            ([10.0, -20.0, 30.0], [10.0, 200.0, 90.0], [3.0, 310.0]),
            ([0.0, 0.0, 5.0], [0.0, 0.0, -400.0], [0.4, 0.4]),
        ] {
            let mesh = round_body(Vector::from(from), Vector::from(to) - Vector::from(from), radii);
            mesh.check_solid().expect("closed");
            let (foot, along) = (Point::from(from), Vector::from(to) - Vector::from(from));
            let (length, z) = (along.norm(), along.normalize());
            let radius_at = |p: &Point| {
                let h = (p - foot).dot(&z);
                (radii[0] + (radii[1] - radii[0]) * h / length, (p - foot - z * h).norm())
            };
            for p in &mesh.positions {
                let (said, r) = radius_at(p);
                assert!(r < 1e-9 || (said..=said + 1.001 * FACET_TOLERANCE_MM).contains(&r), "{said} {r}");
            }
            // Between two corners of a ring the facet is nearest to the axis.
            for t in &mesh.triangles {
                for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                    let (a, b) = (mesh.positions[a as usize], mesh.positions[b as usize]);
                    let middle = nalgebra::center(&a, &b);
                    let ((said_a, ra), (said_b, rb), (said, r)) = (radius_at(&a), radius_at(&b), radius_at(&middle));
                    if ra > 1e-9 && rb > 1e-9 && (said_a - said_b).abs() < 1e-9 {
                        assert!(r >= said * (1.0 - 1e-14), "{said} {r}");
                    }
                }
            }
        }
    }
}
