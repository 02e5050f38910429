//! Mass, center and inertia of bodies: stated, or estimated from the shape and a density, the body's own or
//! that of its role in `[body_density]`.
//!
//! A closed shell of triangles bounds the signed tetrahedra of its triangles and any one point. With
//! `a, b, c` the corners of a triangle seen from that point and `v = a . (b x c) / 6` its tetrahedron's
//! volume, the sums
//!
//! ```text
//!   V = sum v        V center = sum v (a + b + c) / 4
//!   integral x x^T = sum v / 20 (a a^T + b b^T + c c^T + s s^T),   s = a + b + c
//! ```
//!
//! are exact for every polyhedron (Lien and Kajiya 1984; Tonon 2004). The inertia tensor is trace(J) 1 - J.
//!
//! Limits: shells of one body that overlap count twice where they overlap; a stated mass scales the result,
//! so that only its distribution is then estimated.

use nalgebra::Matrix3;
use proveout_geom::{Point, TriMesh, Vector};
use proveout_input::{Document, InputError, Step, Step::Item, Step::Key};

use crate::{
    description::MachineFile,
    reading::{Checked, finite_vector, positive},
    units::{KG_MM3_PER_KG_M3, MM2_PER_M2},
};

/// Part by which a moment of inertia may be above the sum of the two others: rounding of what a file states.
const ROUNDING: f64 = 1e-9;

/// Checks `[body_density]`: densities above zero, and roles that bodies have.
pub(crate) fn check_densities(source: &Document<'_>, content: &MachineFile) -> Checked<()> {
    let Some(densities) = &content.body_density else { return Ok(()) };
    positive(source, &[Key("body_density"), Key("default_kg_m3")], Some(densities.default_kg_m3))?;
    for (role, density) in &densities.roles_kg_m3 {
        let at = [Key("body_density"), Key("roles_kg_m3"), Key(role)];
        positive(source, &at, Some(*density))?;
        if content.body.iter().all(|b| b.role != *role) {
            let mut roles: Vec<&str> = content.body.iter().map(|b| b.role.as_str()).collect();
            roles.sort_unstable();
            roles.dedup();
            let remedy = format!("name a role of this file: {}", roles.join(", "));
            return Err(source.error("machine-unknown-role", &at, format!("no body has the role {role:?}"), remedy));
        }
    }
    Ok(())
}

/// Mass, center and inertia of a body in M with all joints at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMass {
    /// kg.
    pub mass: f64,
    /// Center of mass, mm.
    pub center: Point,
    /// About the center, along the axes of M, kg mm².
    pub inertia: Matrix3<f64>,
    /// True when a part of it was found from the shape and not stated.
    pub estimated: bool,
}

/// Volume (mm³), center (mm) and inertia over density about the center (mm⁵) of a closed mesh; none when the
/// volume is not above zero.
pub(crate) fn solid_moments(mesh: &TriMesh) -> Option<(f64, Point, Matrix3<f64>)> {
    let origin = mesh.aabb().center();
    let (mut volume, mut first, mut second) = (0.0, Vector::zeros(), Matrix3::zeros());
    for t in &mesh.triangles {
        let corner = |k: usize| mesh.positions.get(t[k] as usize).map(|p| p - origin);
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else { return None };
        let v = a.dot(&b.cross(&c)) / 6.0;
        let s = a + b + c;
        volume += v;
        first += s * (v / 4.0);
        second += (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose()) * (v / 20.0);
    }
    if !(volume > 0.0 && volume.is_finite()) {
        return None;
    }
    let center = first / volume;
    let about = second - center * center.transpose() * volume;
    let inertia = Matrix3::identity() * about.trace() - about;
    Some((volume, origin + center, inertia))
}

/// Checks the mass of body `index` and completes it from the shape; a body without one takes the density of
/// its role.
pub(crate) fn read_mass(
    source: &Document<'_>,
    index: usize,
    content: &MachineFile,
    mesh: &TriMesh,
) -> Checked<Option<BodyMass>> {
    let Some(body) = content.body.get(index) else { return Ok(None) };
    let Some(f) = &body.mass else {
        let Some(densities) = &content.body_density else { return Ok(None) };
        let density = densities.roles_kg_m3.get(&body.role).copied().unwrap_or(densities.default_kg_m3);
        return match solid_moments(mesh) {
            Some(moments) => Ok(Some(spread(moments, density * KG_MM3_PER_KG_M3 * moments.0))),
            None => Err(no_volume(source, &[Key("body"), Item(index), Key("name")])),
        };
    };
    let at = |key| [Key("body"), Item(index), Key("mass"), Key(key)];
    let stated = positive(source, &at("mass_kg"), f.mass_kg)?;
    let density = positive(source, &at("density_kg_m3"), f.density_kg_m3)?;
    if stated.is_some() == density.is_some() {
        let remedy = "give mass_kg or density_kg_m3, and not both";
        return Err(source.error("machine-mass", &at("mass_kg"), "the body's mass must be stated once", remedy));
    }
    if f.center_mm.is_some() != f.inertia_kg_m2.is_some() || f.center_mm.is_some() && stated.is_none() {
        let remedy = "give mass_kg, center_mm and inertia_kg_m2 together, or the mass alone";
        return Err(source.error("machine-mass", &at("center_mm"), "center and inertia go with the mass", remedy));
    }
    if let (Some(mass), Some(center), Some([xx, yy, zz, xy, yz, zx])) = (stated, f.center_mm, f.inertia_kg_m2) {
        let center = Point::from(finite_vector(source, &at("center_mm"), center)?);
        let inertia = Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz) * MM2_PER_M2;
        if !is_inertia(&inertia) {
            let message = "no body can have this inertia";
            let remedy = "each principal inertia must be above zero and at most the sum of the other two";
            return Err(source.error("machine-mass", &at("inertia_kg_m2"), message, remedy));
        }
        return Ok(Some(BodyMass { mass, center, inertia, estimated: false }));
    }
    let Some(moments) = solid_moments(mesh) else { return Err(no_volume(source, &at("mass_kg"))) };
    let mass = stated.unwrap_or_else(|| density.unwrap_or(0.0) * KG_MM3_PER_KG_M3 * moments.0);
    Ok(Some(spread(moments, mass)))
}

fn no_volume(source: &Document<'_>, path: &[Step<'_>]) -> InputError {
    let message = "the shape has no volume for its mass";
    let remedy = "give mass_kg, center_mm and inertia_kg_m2, or close the shape";
    source.error("machine-mass", path, message, remedy)
}

/// A mass (kg) that is spread evenly over a shape with these moments.
fn spread((volume, center, over_density): (f64, Point, Matrix3<f64>), mass: f64) -> BodyMass {
    BodyMass { mass, center, inertia: over_density * (mass / volume), estimated: true }
}

/// True for the tensor of a body: positive, and no principal value above the sum of the others (within
/// rounding).
pub(crate) fn is_inertia(tensor: &Matrix3<f64>) -> bool {
    if !tensor.iter().all(|v| v.is_finite()) {
        return false;
    }
    let e = tensor.symmetric_eigenvalues();
    let sum = e.sum();
    e.iter().all(|v| *v > 0.0 && 2.0 * v <= sum * (1.0 + ROUNDING))
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Aabb, box_mesh, cylinder_mesh};

    use super::*;

    #[test]
    fn a_block_has_its_closed_form() {
        let mesh = box_mesh(&Aabb { min: Point::new(100.0, -20.0, 5.0), max: Point::new(160.0, 20.0, 15.0) });
        let (volume, center, inertia) = solid_moments(&mesh).expect("closed");
        assert!((volume - 60.0 * 40.0 * 10.0).abs() < 1e-9);
        assert!((center - Point::new(130.0, 0.0, 10.0)).norm() < 1e-12);
        let expected = [40.0 * 40.0 + 10.0 * 10.0, 60.0 * 60.0 + 10.0 * 10.0, 60.0 * 60.0 + 40.0 * 40.0];
        for k in 0..3 {
            // Sums of a dozen terms of size 1e8: rounding of 1e-15 relative each.
            assert!((inertia[(k, k)] - volume / 12.0 * expected[k]).abs() < 1e-6);
        }
        assert!(inertia[(0, 1)].abs() + inertia[(1, 2)].abs() + inertia[(2, 0)].abs() < 1e-6);
    }

    #[test]
    fn a_fine_cylinder_comes_near_its_closed_form() {
        let (r, h) = (30.0, 80.0);
        let mesh = cylinder_mesh(r, 0.0, h, 720);
        let (volume, center, inertia) = solid_moments(&mesh).expect("closed");
        // A polygon of n sides has 1 - 6.6/n^2 of the circle's area: 1.3e-5 for 720; twice that for the
        // inertia.
        assert!((volume / (std::f64::consts::PI * r * r * h) - 1.0).abs() < 2e-5);
        assert!((center.z - h / 2.0).abs() < 1e-9);
        assert!((inertia[(2, 2)] / (volume * r * r / 2.0) - 1.0).abs() < 4e-5);
        assert!((inertia[(0, 0)] / (volume * (3.0 * r * r + h * h) / 12.0) - 1.0).abs() < 4e-5);
    }

    #[test]
    fn tensors_that_no_body_has_are_reported() {
        let diagonal = |a, b, c| Matrix3::from_diagonal(&Vector::new(a, b, c));
        assert!(is_inertia(&diagonal(1.0, 1.0, 2.0)) && is_inertia(&diagonal(2.0, 3.0, 4.0)));
        assert!(!is_inertia(&diagonal(1.0, 1.0, 2.1)) && !is_inertia(&diagonal(1.0, -1.0, 1.0)));
        assert!(!is_inertia(&diagonal(f64::NAN, 1.0, 1.0)));
    }
}
