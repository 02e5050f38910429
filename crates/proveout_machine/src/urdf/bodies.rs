//! Links as bodies of the machine: boxes along the axes and cylinders as such, all else as meshes of the
//! model file.

use std::{f64::consts::PI, fmt::Write as _};

use nalgebra::Matrix3;
use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, box_mesh, revolved_mesh};
use proveout_input::{InputError, MAX_LENGTH_MM};

use super::{
    axes::Axes,
    glb,
    link_tree::LinkTree,
    meshes::Meshes,
    read::{Inertia, Robot, UrdfGeometry, UrdfLink, UrdfShape},
    source::{UrdfSource, reach, shown},
    write::{number, place, quoted},
};
use crate::{TOOL_PARTS, mass::is_inertia};

/// Facets round a sphere, as for other round bodies: its corners protrude by two thousandths of the radius.
const SECTORS: usize = 72;
/// Masses and moments of inertia that a body of a machine can have, kg and kg m²; a file that describes
/// pictures states others.
const LEAST_KG: f64 = 1e-6;
const MOST_KG: f64 = 1e7;
const MOST_KG_M2: f64 = 1e6;
/// Part by which a polyhedron about a ball is made larger: rounding must not bring a face inside.
const OUTSIDE: f64 = 1e-12;

/// A direction that misses an axis of the machine by less than this (sine) runs along it: rounding.
const ALONG: f64 = 1e-9;

/// Tables of bodies, and the model file.
#[derive(Default)]
pub(super) struct Bodies {
    pub(super) text: String,
    pub(super) model: Option<Vec<u8>>,
}

/// What a link becomes.
#[derive(Default)]
struct LinkBody {
    boxes: String,
    cylinders: String,
    mesh: TriMesh,
}

/// Bodies of all links that have a shape.
pub(super) fn bodies(
    source: &UrdfSource<'_>,
    robot: &Robot,
    tree: &LinkTree,
    axes: &Axes,
    notes: &mut Vec<String>,
) -> Result<Bodies, InputError> {
    let mut text = String::new();
    let mut parts: Vec<(String, TriMesh)> = Vec::new();
    let mut meshes = Meshes::default();
    let mut spheres = 0;
    for &l in &tree.order {
        let (link, machine_from_link) = (&robot.links[l], &tree.poses[l]);
        let mut body = LinkBody::default();
        for shape in &link.shapes {
            body.take(source, link, shape, &(*machine_from_link * shape.link_from_shape), &mut meshes, notes)?;
            spheres += usize::from(matches!(shape.form, UrdfGeometry::Sphere(_)));
        }
        let has_mesh = !body.mesh.triangles.is_empty();
        if body.boxes.is_empty() && body.cylinders.is_empty() && !has_mesh {
            continue;
        }
        // The name of a part of every tool is taken.
        let mut name = link.name.clone();
        while TOOL_PARTS.contains(&name.as_str()) || (name != link.name && robot.links.iter().any(|o| o.name == name)) {
            name.push_str("_link");
        }
        if name != link.name {
            notes.push(format!("link {} is body {}: each tool has a {}", shown(&link.name), shown(&name), link.name));
        }
        let on = axes.carrier[l].map_or_else(|| "base".to_owned(), |letter| letter.to_string());
        let _ = write!(
            text,
            "\n[[body]]\nname = {}\nrole = \"link\"\nattached_to = \"{on}\"\ncheck = true\n",
            quoted(&name)
        );
        if has_mesh {
            let _ = writeln!(text, "node = {}", quoted(&name));
            parts.push((name, std::mem::take(&mut body.mesh)));
        }
        if let Some(inertia) = &link.inertia {
            text.push_str(&mass(link, inertia, machine_from_link, notes));
        }
        let _ = write!(
            text,
            "source = {{ \"*\" = {} }}\n{}{}",
            quoted(&format!("URDF file, link {}", link.name)),
            body.boxes,
            body.cylinders
        );
    }
    if spheres > 0 {
        notes.push(format!("spheres are polyhedra of {SECTORS} facets round, nowhere smaller than said: {spheres}"));
    }
    let model = (!parts.is_empty()).then(|| glb::bytes(&parts)).transpose();
    let model = model.map_err(|e| source.whole(format!("its meshes: {e}"), "give the links fewer triangles"))?;
    Ok(Bodies { text, model })
}

/// Line of the mass; none where the file states none that a body can have.
fn mass(link: &UrdfLink, inertia: &Inertia, machine_from_link: &Pose, notes: &mut Vec<String>) -> String {
    let center = *machine_from_link * inertia.link_from_center;
    let tensor = inertia.tensor.map(|t| center.rotation * t * center.rotation.transpose());
    let largest = tensor.map_or(0.0, |t: Matrix3<f64>| t.amax());
    let known = inertia.mass_kg > LEAST_KG
        && inertia.mass_kg <= MOST_KG
        && largest <= MOST_KG_M2
        && center.translation.amax() <= MAX_LENGTH_MM
        && tensor.as_ref().is_some_and(is_inertia);
    let Some(t) = tensor.filter(|_| known) else {
        notes.push(format!(
            "mass of link {} is not imported: mass and inertia are not those of a body",
            shown(&link.name)
        ));
        return String::new();
    };
    let values = [t.m11, t.m22, t.m33, t.m12, t.m23, t.m13].map(|v| format!("{v}"));
    format!(
        "mass = {{ mass_kg = {}, center_mm = {}, inertia_kg_m2 = [{}] }}\n",
        inertia.mass_kg,
        place(&Point::from(center.translation)),
        values.join(", ")
    )
}

/// The signs and axes of a rotation by right angles: where each axis of the shape lies in M.
fn quarter_turn(pose: &Pose) -> Option<[usize; 3]> {
    let mut axes = [0; 3];
    for (axis, column) in axes.iter_mut().zip(pose.rotation.column_iter()) {
        *axis = column.iter().position(|v| v.abs() > 0.5)?;
        if column.iter().enumerate().any(|(k, v)| k != *axis && v.abs() > ALONG) {
            return None;
        }
    }
    Some(axes)
}

/// A polyhedron that holds a ball about the origin.
///
/// Its faces are flat trapezoids between two circles of latitude. With the corners on a sphere of radius R, N
/// facets round and N / 2 in height, no face is nearer to the middle than `R cos²(pi / N)`.
fn ball(radius: f64) -> TriMesh {
    let outer = radius / (PI / SECTORS as f64).cos().powi(2) * (1.0 + OUTSIDE);
    let stacks = SECTORS / 2;
    let ring = |k: usize| {
        let (s, c) = proveout_geom::sin_cos(PI * (k as f64 / stacks as f64 - 0.5));
        [if k == 0 || k == stacks { 0.0 } else { outer * c }, outer * s]
    };
    let profile: Vec<[f64; 2]> = (0..=stacks).map(ring).collect();
    revolved_mesh(&profile, SECTORS)
}

impl LinkBody {
    fn take(
        &mut self,
        source: &UrdfSource<'_>,
        link: &UrdfLink,
        shape: &UrdfShape,
        machine_from_shape: &Pose,
        meshes: &mut Meshes,
        notes: &mut Vec<String>,
    ) -> Result<(), InputError> {
        let in_reach = |points: &[Point]| {
            let far = reach(points);
            if far <= MAX_LENGTH_MM {
                return Ok(());
            }
            let message = format!("a shape of link {} reaches {far:.0} mm off the root", shown(&link.name));
            Err(source.at(&shape.place, message, format!("the limit is {MAX_LENGTH_MM} mm: write meters")))
        };
        let mesh = match &shape.form {
            UrdfGeometry::Box(size) => {
                let half = size * 0.5;
                if let Some(axes) = quarter_turn(machine_from_shape) {
                    let mut corner = Vector::zeros();
                    for (axis, h) in axes.iter().zip(half.iter()) {
                        corner[*axis] = *h;
                    }
                    let middle = Point::from(machine_from_shape.translation);
                    let ends = [middle - corner, middle + corner];
                    in_reach(&ends)?;
                    let _ = write!(
                        self.boxes,
                        "[[body.box]]\nmin_mm = {}\nmax_mm = {}\n",
                        place(&ends[0]),
                        place(&ends[1])
                    );
                    return Ok(());
                }
                box_mesh(&Aabb { min: Point::from(-half), max: Point::from(half) })
            }
            UrdfGeometry::Cylinder { radius, length } => {
                let end = |z: f64| machine_from_shape.point(&Point::new(0.0, 0.0, z));
                let ends = [end(-0.5 * length), end(0.5 * length)];
                in_reach(&ends)?;
                let _ = write!(
                    self.cylinders,
                    "[[body.cylinder]]\nfrom_mm = {}\nto_mm = {}\nradius_mm = {}\n",
                    place(&ends[0]),
                    place(&ends[1]),
                    number(*radius)
                );
                return Ok(());
            }
            UrdfGeometry::Sphere(radius) => ball(*radius),
            UrdfGeometry::Mesh { file, scale } => {
                let Some(mesh) = meshes.read(source, &shape.place, &link.name, (file.as_str(), scale), notes)? else {
                    return Ok(());
                };
                mesh
            }
            UrdfGeometry::Other(kind) => {
                notes.push(format!("<{kind}> of link {} is not imported", shown(&link.name)));
                return Ok(());
            }
        };
        let mesh = mesh.transformed(machine_from_shape);
        in_reach(&mesh.positions)?;
        self.mesh.append(&mesh);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_is_nowhere_smaller_than_said() {
        let mesh = ball(40.0);
        mesh.check_solid().expect("closed");
        for t in 0..mesh.triangles.len() {
            let [a, _, _] = mesh.corners(t);
            let distance = mesh.area_normal(t).normalize().dot(&a.coords);
            assert!((40.0..40.0 * 1.004).contains(&distance), "{distance}");
        }
        assert!(mesh.positions.iter().all(|p| p.coords.norm() < 40.0 * 1.002));
    }

    #[test]
    fn turns_by_right_angles_are_known() {
        let of = |x, y, z| quarter_turn(&Pose::from_rpy(Vector::zeros(), x, y, z));
        assert_eq!(of(0.0, 0.0, 0.0), Some([0, 1, 2]));
        assert_eq!(of(PI / 2.0, 0.0, 0.0), Some([0, 2, 1]));
        assert_eq!(of(0.0, PI / 2.0, PI / 2.0), Some([2, 0, 1]));
        assert_eq!(of(0.0, 0.0, 1e-6), None);
    }
}
