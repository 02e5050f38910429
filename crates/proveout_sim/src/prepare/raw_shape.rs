//! The raw stock as a solid in closed form or as a mesh: so that a place between its rays is known to have been material or not.

use proveout_geom::{Aabb, Point, Vector};
use proveout_surface::{DesignMesh, DesignSurface};

use crate::{
    evidence::inputs::Inputs,
    prepare::{part_shape::Shape, prepared::Prepared},
};

/// What the raw stock is.
pub(crate) enum RawShape {
    Block(Aabb),
    Bar { base: Point, axis: Vector, radius: f64, length: f64 },
    Mesh(Box<DesignMesh>),
}

impl RawShape {
    /// That of a scene; none where it is known on rays alone: what an earlier run left, and meshes that had to be mended.
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
            (_, _, Some(named)) => Inputs::default().mesh(scene, "stock".into(), named, file.mesh_unit).ok()?.0,
            _ => return None,
        };
        Some(Self::Mesh(Box::new(DesignMesh::new(&mesh).ok()?)))
    }

    /// How far a place lay outside of it, mm, negative inside: never more than its distance from the skin. Not a number where a mesh
    /// gives none.
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
