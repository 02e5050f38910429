//! Fixtures and platforms of a scene as meshes in the table frame.

use std::path::PathBuf;

use proveout_geom::{MeshError, Pose, TriMesh, Vector, box_mesh, cylinder_mesh, rad};
use proveout_input::{InputError, Step::Item, Step::Key};
use proveout_machine::Machine;

use crate::{
    evidence::inputs::{Inputs, MeshRole},
    prepare::{error::SimError, fixture_bodies},
    scene::{CylinderAxis, CylinderFile, FixtureFile, FixtureFrame, Scene},
};

/// Sides of the polygon that approximates a circle of a fixture. The polygon is drawn round the
/// circle, so that the body is never too small.
pub(crate) const FIXTURE_SECTORS: usize = 96;

/// A fixture by its name, with its mesh in the table frame.
pub(crate) type Fixture = (String, TriMesh);

/// Fixtures of a scene in its order; files that they are read from are added to `inputs`.
///
/// # Errors
/// A mesh that cannot be read, or that has no surface.
pub(crate) fn fixture_meshes(
    scene: &Scene,
    table_from_work: &Pose,
    inputs: &mut Inputs,
) -> Result<Vec<Fixture>, SimError> {
    let named = |f: &FixtureFile| Ok((f.name.clone(), fixture_mesh(scene, f, table_from_work, inputs)?));
    scene.file.fixture.iter().map(named).collect()
}

/// Refuses a fixture with the name of a machine body.
///
/// # Errors
/// The first one.
pub(crate) fn check_names(scene: &Scene, machine: &Machine) -> Result<(), InputError> {
    let taken = |f: &&FixtureFile| machine.bodies.iter().any(|b| b.name == f.name);
    scene.file.fixture.iter().enumerate().find(|(_, f)| taken(f)).map_or(Ok(()), |(i, FixtureFile { name, .. })| {
        let message =
            format!("fixture {name:?} has the name of a body of the machine: findings could not distinguish them");
        let path = [Key("fixture"), Item(i), Key("name")];
        Err(scene.error_at(&path, message, "give the fixture another name"))
    })
}

fn fixture_mesh(
    scene: &Scene,
    fixture: &FixtureFile,
    table_from_work: &Pose,
    inputs: &mut Inputs,
) -> Result<TriMesh, SimError> {
    let mesh = match (fixture.named_mesh(), fixture.block, fixture.cylinder) {
        (None, None, None) => fixture.kind.map(|kind| fixture_bodies::mesh(fixture, kind)).unwrap_or_default(),
        (Some(named), None, None) => {
            let (mesh, path) = inputs.mesh(scene, MeshRole::Fixture(fixture.name.clone()), named)?;
            surface(mesh, path)?
        }
        (None, Some(b), None) => box_mesh(&b.aabb()),
        (None, None, Some(c)) => round_mesh(&c),
        // The scene has none of this kind.
        _ => TriMesh::default(),
    };
    Ok(match fixture.frame {
        FixtureFrame::Workpiece => mesh.transformed(table_from_work),
        FixtureFrame::Table => mesh,
    })
}

/// A mesh that may have holes or turned faces: its surface is checked, and the gates name what is not.
fn surface(mesh: TriMesh, path: PathBuf) -> Result<TriMesh, SimError> {
    match mesh.check_solid() {
        Ok(()) | Err(MeshError::Open { .. } | MeshError::NotManifold { .. }) => Ok(mesh),
        Err(source) => Err(SimError::Mesh { path, source }),
    }
}

fn round_mesh(c: &CylinderFile) -> TriMesh {
    let outer = c.radius_mm / (std::f64::consts::PI / FIXTURE_SECTORS as f64).cos();
    // A body along z is turned over a right angle, which is exact.
    let lying = match c.along {
        CylinderAxis::X => Pose::from_axis_angle(&Vector::y(), rad(90.0)),
        CylinderAxis::Y => Pose::from_axis_angle(&Vector::x(), rad(-90.0)),
        CylinderAxis::Z => Pose::identity(),
    };
    cylinder_mesh(outer, 0.0, c.height_mm, FIXTURE_SECTORS)
        .transformed(&lying)
        .transformed(&Pose::from_translation(Vector::from(c.base_mm)))
}
