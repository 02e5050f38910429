use std::f64::consts::TAU;

use crate::{Aabb, Point, TriMesh};

/// Closed box mesh with outward faces.
pub fn box_mesh(b: &Aabb) -> TriMesh {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { b.max[axis] } else { b.min[axis] };
        Point::new(pick(0), pick(1), pick(2))
    };
    let quads: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriMesh {
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
    }
}

/// Closed mesh of a cylinder about +z, inscribed in the circle of `radius`, from `z_min` to `z_max` (mm).
pub fn cylinder_mesh(radius: f64, z_min: f64, z_max: f64, sectors: usize) -> TriMesh {
    revolved_mesh(&[[0.0, z_min], [radius, z_min], [radius, z_max], [0.0, z_max]], sectors)
}

/// Closed mesh of the profile `[r, z]` (mm) turned about +z, inscribed in its circles.
///
/// The profile runs from the axis to the axis, upward on the outside; inner points have r > 0. Fewer than
/// three `sectors` count as three.
pub fn revolved_mesh(profile: &[[f64; 2]], sectors: usize) -> TriMesh {
    let sectors = sectors.max(3);
    let mut mesh = TriMesh::default();
    let [Some(first), Some(last)] = [profile.first(), profile.last()] else { return mesh };
    let inner = &profile[1..profile.len().max(2) - 1];
    mesh.positions.push(Point::new(0.0, 0.0, first[1]));
    for &[r, z] in inner {
        mesh.positions.extend((0..sectors).map(|k| {
            let (s, c) = crate::sin_cos(TAU * k as f64 / sectors as f64);
            Point::new(r * c, r * s, z)
        }));
    }
    mesh.positions.push(Point::new(0.0, 0.0, last[1]));
    let top = mesh.positions.len() as u32 - 1;
    let n = sectors as u32;
    let at = |ring: u32, k: u32| 1 + ring * n + k % n;
    for k in 0..n {
        if inner.is_empty() {
            break;
        }
        mesh.triangles.push([0, at(0, k + 1), at(0, k)]);
        for ring in 0..inner.len() as u32 - 1 {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        let ring = inner.len() as u32 - 1;
        mesh.triangles.push([top, at(ring, k), at(ring, k + 1)]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cylinder_is_a_solid_with_the_volume_of_its_polygon() {
        let mesh = cylinder_mesh(2.0, -1.0, 4.0, 64);
        mesh.check_solid().expect("closed");
        let polygon = 0.5 * 64.0 * 4.0 * (TAU / 64.0).sin();
        assert!((mesh.volume() - 5.0 * polygon).abs() < 1e-9);
    }

    #[test]
    fn a_cone_is_a_solid() {
        let mesh = revolved_mesh(&[[0.0, 0.0], [3.0, 0.0], [0.0, 6.0]], 200);
        mesh.check_solid().expect("closed");
        assert!((mesh.volume() / (std::f64::consts::PI * 18.0) - 1.0).abs() < 1e-3);
    }
}
