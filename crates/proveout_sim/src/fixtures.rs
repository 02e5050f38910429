//! Fixtures and platforms of a scene as meshes in the table frame.

use std::path::{Path, PathBuf};

use proveout_geom::{Aabb, InputError, MeshError, Pose, TriMesh, Vector, box_mesh, cylinder_mesh, rad, read_mesh};

use crate::{
    error::SimError,
    scene::{BoxFile, CylinderAxis, CylinderFile, FixtureFile, FixtureFrame, Scene},
};

/// Sides of the polygon that stands for a circle of a fixture; the polygon is drawn round the circle, so that the body
/// is never smaller than it is.
const FIXTURE_SECTORS: usize = 96;

/// A fixture by its name, with its mesh in the table frame.
pub(crate) type Fixture = (String, TriMesh);

/// Fixtures of a scene in its order; files that they are read from are added to `inputs`.
///
/// # Errors
/// A fixture without a form, a box that holds nothing, a mesh that cannot be read.
pub(crate) fn fixture_meshes(
    scene: &Scene,
    table_from_work: &Pose,
    inputs: &mut Vec<(String, PathBuf)>,
) -> Result<Vec<Fixture>, SimError> {
    let named = |f: &FixtureFile| Ok((f.name.clone(), fixture_mesh(scene, f, table_from_work, inputs)?));
    scene.file.fixture.iter().map(named).collect()
}

fn fixture_mesh(
    scene: &Scene,
    fixture: &FixtureFile,
    table_from_work: &Pose,
    inputs: &mut Vec<(String, PathBuf)>,
) -> Result<TriMesh, SimError> {
    let mesh = match (&fixture.mesh, fixture.block, fixture.cylinder) {
        (Some(path), None, None) => {
            let path = scene.resolve(path);
            inputs.push((format!("fixture {}", fixture.name), path.clone()));
            read_surface(&path)?
        }
        (None, Some(b), None) => box_mesh(&checked_box(scene, fixture, &b)?),
        (None, None, Some(c)) => round_mesh(&c),
        _ => {
            let message = format!("fixture {:?} needs exactly one form", fixture.name);
            return Err(InputError::file(&scene.path, message, "give one of `mesh`, `box`, `cylinder`").into());
        }
    };
    Ok(match fixture.frame {
        FixtureFrame::Workpiece => mesh.transformed(table_from_work),
        FixtureFrame::Table => mesh,
    })
}

fn checked_box(scene: &Scene, fixture: &FixtureFile, b: &BoxFile) -> Result<Aabb, InputError> {
    let aabb = b.aabb();
    if (0..3).all(|i| aabb.min[i] < aabb.max[i]) {
        return Ok(aabb);
    }
    let message = format!("the box of fixture {:?} holds nothing", fixture.name);
    Err(InputError::file(&scene.path, message, "min_mm must be below max_mm"))
}

/// A mesh that may have holes or turned faces: its surface is checked, and the gates name what is not.
fn read_surface(path: &Path) -> Result<TriMesh, SimError> {
    let mesh = read_mesh(path)?;
    match mesh.check_solid() {
        Ok(()) | Err(MeshError::Open { .. } | MeshError::NotManifold { .. }) => Ok(mesh),
        Err(source) => Err(SimError::Mesh { path: path.into(), source }),
    }
}

fn round_mesh(c: &CylinderFile) -> TriMesh {
    let outer = c.radius_mm / (std::f64::consts::PI / FIXTURE_SECTORS as f64).cos();
    // What stands along z is turned over a right angle, which is exact.
    let lying = match c.along {
        CylinderAxis::X => Pose::from_axis_angle(&Vector::y(), rad(90.0)),
        CylinderAxis::Y => Pose::from_axis_angle(&Vector::x(), rad(-90.0)),
        CylinderAxis::Z => Pose::identity(),
    };
    cylinder_mesh(outer, 0.0, c.height_mm, FIXTURE_SECTORS)
        .transformed(&lying)
        .transformed(&Pose::from_translation(Vector::from(c.base_mm)))
}
