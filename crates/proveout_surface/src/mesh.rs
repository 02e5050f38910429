//! Design mesh with signed distances.

use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh as ParryMesh, TriMeshFlags, TrianglePointLocation};
use proveout_geom::{Aabb, MeshError, Point, TriMesh, Vector};
use thiserror::Error;

use crate::{DesignSurface, Nearest};

/// Why a mesh cannot be a design.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DesignError {
    /// The triangles do not bound a solid, so that inside and outside are not defined.
    #[error("the design mesh does not bound a solid: {0}; repair or export it again")]
    NotSolid(#[from] MeshError),
    /// The search tree refused it.
    #[error("the design mesh cannot be searched: {0}")]
    Tree(String),
}

/// Closed mesh with a bounding volume hierarchy.
///
/// The sign comes from the angle-weighted pseudo-normal of the face, edge or vertex that holds the nearest point
/// (Baerentzen and Aanaes, Signed distance computation using the angle weighted pseudonormal, 2005, theorem 1), which
/// is right everywhere off the surface for closed meshes.
#[derive(Clone, Debug)]
pub struct DesignMesh {
    mesh: ParryMesh,
    bounds: Aabb,
}

impl DesignMesh {
    /// Checks that the triangles bound a solid and builds the tree. Vertices with equal coordinates are joined first.
    ///
    /// # Errors
    /// The first place where the mesh is not a solid.
    pub fn new(mesh: &TriMesh) -> Result<Self, DesignError> {
        let mesh = mesh.merge_equal_vertices();
        mesh.check_solid()?;
        let vertices = mesh.positions.iter().map(to_parry).collect();
        let flags = TriMeshFlags::ORIENTED;
        let tree = ParryMesh::with_flags(vertices, mesh.triangles.clone(), flags)
            .map_err(|e| DesignError::Tree(format!("{e:?}")))?;
        Ok(Self { mesh: tree, bounds: mesh.aabb() })
    }

    /// Smallest box round the design.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
}

impl DesignSurface for DesignMesh {
    fn nearest(&self, p: &Point, range: f64) -> Option<Nearest> {
        if !p.iter().all(|v| v.is_finite()) {
            return None;
        }
        let q = to_parry(p);
        // The search keeps what is strictly nearer than its bound.
        let bound = if range < f64::MAX { range * (1.0 + 1e-12) + f64::MIN_POSITIVE } else { f64::MAX };
        let (projection, (triangle, location)) =
            self.mesh.project_local_point_and_get_location_with_max_dist(q, false, bound)?;
        let away = from_parry(q - projection.point);
        let length = away.norm();
        let index = self.mesh.indices().get(triangle as usize)?;
        let pseudo = self.mesh.pseudo_normals()?;
        let normal = match location {
            TrianglePointLocation::OnVertex(i) => {
                pseudo.vertices_pseudo_normal.get(*index.get(i as usize)? as usize).copied()
            }
            TrianglePointLocation::OnEdge(i, _) => {
                pseudo.edges_pseudo_normal.get(triangle as usize)?.get(i as usize).copied()
            }
            _ => Some(self.mesh.triangle(triangle).scaled_normal()),
        }?;
        let normal = from_parry(normal);
        let normal = normal.try_normalize(0.0)?;
        Some(Nearest { distance: if away.dot(&normal) < 0.0 { -length } else { length }, normal })
    }
}

fn to_parry(p: &Point) -> ParryVector {
    ParryVector::new(p.x, p.y, p.z)
}

fn from_parry(v: ParryVector) -> Vector {
    Vector::new(v.x, v.y, v.z)
}
