//! Design mesh with signed distances.

use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::query::{PointQueryWithLocation, Ray, RayCast};
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

    /// Whether the straight line between two points meets no face.
    pub fn is_free(&self, from: &Point, to: &Point) -> bool {
        let way = to - from;
        if way.norm_squared() == 0.0 {
            return true;
        }
        let ray = Ray::new(to_parry(from), ParryVector::new(way.x, way.y, way.z));
        self.mesh.cast_local_ray(&ray, 1.0, false).is_none()
    }

    /// The middle of every stretch of the straight line between two points that lies inside of the design and begins and ends on
    /// its surface; at most eight.
    pub fn middles_inside(&self, from: &Point, to: &Point) -> Vec<Point> {
        const MOST: usize = 16;
        /// Part of the line by which a search goes on behind a face.
        const STEP: f64 = 1e-9;
        let (way, mut at, mut last) = (to - from, 0.0, None);
        let mut out = Vec::new();
        for _ in 0..MOST {
            let start = from + way * at;
            let ray = Ray::new(to_parry(&start), ParryVector::new(way.x, way.y, way.z));
            let Some(next) = self.mesh.cast_local_ray(&ray, 1.0 - at, false) else { break };
            let hit = at + next;
            if let Some(before) = last {
                let middle = from + way * (0.5 * (before + hit));
                if self.signed_distance(&middle).is_some_and(|d| d < 0.0) {
                    out.push(middle);
                }
            }
            last = Some(hit);
            at = hit + STEP;
            if at >= 1.0 {
                break;
            }
        }
        out
    }

    /// Thickness of the design below a point of its surface with outward normal `n`: way to the next face, mm; infinite where
    /// there is none.
    pub fn thickness(&self, p: &Point, n: &Vector) -> f64 {
        // A nanometer below, so that the face itself is not met.
        const UNDER: f64 = 1e-6;
        let from = p - n * UNDER;
        let ray = Ray::new(to_parry(&from), ParryVector::new(-n.x, -n.y, -n.z));
        self.mesh.cast_local_ray(&ray, f64::MAX, false).map_or(f64::INFINITY, |s| s + UNDER)
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
