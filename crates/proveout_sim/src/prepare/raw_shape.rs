//! The raw stock as a solid in closed form or as a mesh: so that a place between its rays is known to have
//! been material or not.

use proveout_geom::{Aabb, Point, Vector};
use proveout_surface::{DesignMesh, DesignSurface};

use crate::{
    evidence::inputs::{Inputs, MeshRole},
    prepare::{part_shape::Shape, prepared::Prepared},
};

/// What the raw stock is.
pub(crate) enum RawShape {
    Block(Aabb),
    Bar { base: Point, axis: Vector, radius: f64, length: f64 },
    Mesh(Box<DesignMesh>),
}

impl RawShape {
    /// That of a scene; none where it is known on rays alone: what an earlier run left, and meshes that had
    /// to be mended.
    pub(crate) fn of(prepared: &Prepared) -> Option<Self> {
        let scene = &prepared.scene;
        let file = scene.file.stock.get_ref();
        if file.from_run.is_some() || file.repair {
            return None;
        }
        if let Some(block) = &file.block {
            return Some(Self::Block(block.aabb()));
        }
        if let Some(c) = &file.cylinder {
            let axis = c.along.direction().try_normalize(0.0)?;
            return Some(Self::Bar { base: Point::from(c.base_mm), axis, radius: c.radius_mm, length: c.height_mm });
        }
        let blade = scene.file.part.as_ref().and_then(|p| p.blade.as_ref());
        let mesh = match (file.blade_allowance_mm, blade, &file.mesh) {
            (Some(allowance), Some(blade), _) => {
                Shape::of_scene(scene, blade, allowance).ok()?.mesh(scene, blade.chord_error_mm).ok()?.0
            }
            (_, _, Some(named)) => Inputs::default().mesh(scene, MeshRole::Stock, named, file.mesh_unit).ok()?.0,
            _ => return None,
        };
        Some(Self::Mesh(Box::new(DesignMesh::new(&mesh).ok()?)))
    }

    /// How far a place lay outside of it, mm, negative inside: never more than its distance from the skin.
    /// Not a number where a mesh gives none.
    pub(crate) fn outside(&self, p: &Point) -> f64 {
        match self {
            Self::Block(b) => (0..3).map(|k| (b.min[k] - p[k]).max(p[k] - b.max[k])).fold(f64::NEG_INFINITY, f64::max),
            Self::Bar { base, axis, radius, length } => {
                let q = p - base;
                let along = q.dot(axis);
                (-along).max(along - length).max((q - axis * along).norm() - radius)
            }
            Self::Mesh(mesh) => mesh.signed_distance(p).unwrap_or(f64::NAN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places on a lattice round a block and a bar: the sign says which lie inside, and no two places differ
    /// by more than they are apart, so that the value is never more than the distance from the skin.
    #[test]
    fn the_distance_outside_has_the_right_sign_and_is_never_too_large() {
        let block = Aabb { min: Point::new(-3.0, -2.0, 0.0), max: Point::new(4.0, 2.0, 1.0) };
        let bar = RawShape::Bar { base: Point::new(1.0, 0.0, -1.0), axis: Vector::z(), radius: 2.5, length: 4.0 };
        let in_block = |p: &Point| p.x > -3.0 && p.x < 4.0 && p.y.abs() < 2.0 && p.z > 0.0 && p.z < 1.0;
        let in_bar = |p: &Point| (p.x - 1.0).hypot(p.y) < 2.5 && p.z > -1.0 && p.z < 3.0;
        for (shape, is_block) in [(RawShape::Block(block), true), (bar, false)] {
            let lattice = (0..12_usize.pow(3)).map(|k| {
                let at = |i: usize| -6.05 + 1.13 * i as f64;
                Point::new(at(k % 12), at(k / 12 % 12), at(k / 144))
            });
            let places: Vec<(Point, f64)> = lattice.map(|p| (p, shape.outside(&p))).collect();
            assert!(places.iter().any(|p| p.1 < 0.0));
            for (i, (p, value)) in places.iter().enumerate() {
                let is_inside = if is_block { in_block(p) } else { in_bar(p) };
                assert_eq!(*value < 0.0, is_inside, "{p}");
                for (q, other) in places.iter().skip(i + 1).step_by(97) {
                    assert!((value - other).abs() <= (p - q).norm() + 1e-12, "{p} {q}");
                }
            }
        }
    }
}
