//! Design mesh with signed distances.

use std::collections::HashMap;

use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::query::{PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{TriMesh as ParryMesh, TriMeshFlags, TrianglePointLocation};
use proveout_geom::{Aabb, MeshError, Point, TriMesh, Vector};
use thiserror::Error;

use crate::{DesignSurface, NearestOnDesign};

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
/// The sign comes from the angle-weighted pseudo-normal of the face, edge or vertex that holds the nearest
/// point (Baerentzen and Aanaes, Signed distance computation using the angle weighted pseudonormal, 2005,
/// theorem 1), which is right everywhere off the surface of one closed shell. Where shells touch, the nearest
/// face may lie inside of the solid. In a mesh of several shells, a point is therefore inside if more bodies
/// than cavities contain it.
///
/// ```
/// use proveout_geom::{Aabb, Point, box_mesh};
/// use proveout_surface::{DesignMesh, DesignSurface};
///
/// let block = Aabb { min: Point::origin(), max: Point::new(20.0, 16.0, 8.0) }; // mm
/// let design = DesignMesh::new(&box_mesh(&block))?;
/// let distance = |z: f64| design.signed_distance(&Point::new(10.0, 7.0, z)).expect("finite");
/// assert!((distance(11.0) - 3.0).abs() < 1e-9); // above the upper face
/// assert!((distance(7.0) + 1.0).abs() < 1e-9); // inside
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct DesignMesh {
    mesh: ParryMesh,
    bounds: Aabb,
    /// The shells of a mesh that has more than one.
    shells: Vec<Shell>,
}

/// Triangles connected by shared edges.
#[derive(Clone, Debug)]
struct Shell {
    mesh: ParryMesh,
    bounds: Aabb,
    is_cavity: bool,
}

impl Shell {
    /// Winding number at a point: 1 inside a body, -1 inside a cavity, else 0.
    fn turns(&self, p: &Point) -> i32 {
        let is_in_room = self.bounds.contains(p)
            && nearest_of(&self.mesh, p, f64::MAX).is_some_and(|n| (n.distance < 0.0) != self.is_cavity);
        match (is_in_room, self.is_cavity) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => -1,
        }
    }
}

fn tree_of(vertices: Vec<ParryVector>, triangles: Vec<[u32; 3]>) -> Result<ParryMesh, DesignError> {
    ParryMesh::with_flags(vertices, triangles, TriMeshFlags::ORIENTED).map_err(|e| DesignError::Tree(format!("{e:?}")))
}

/// The shells of a mesh; none where it is one.
fn shells_of(mesh: &TriMesh) -> Vec<TriMesh> {
    let mut parent: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    fn root(parent: &mut [u32], mut k: u32) -> u32 {
        while parent[k as usize] != k {
            parent[k as usize] = parent[parent[k as usize] as usize];
            k = parent[k as usize];
        }
        k
    }
    let mut first_at: HashMap<[u32; 2], u32> = HashMap::with_capacity(mesh.triangles.len() * 3 / 2);
    for (k, t) in mesh.triangles.iter().enumerate() {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let other = *first_at.entry([a.min(b), a.max(b)]).or_insert(k as u32);
            let (x, y) = (root(&mut parent, other), root(&mut parent, k as u32));
            parent[x.max(y) as usize] = x.min(y);
        }
    }
    let mut number: HashMap<u32, usize> = HashMap::new();
    let mut shells: Vec<TriMesh> = Vec::new();
    let mut vertices: Vec<HashMap<u32, u32>> = Vec::new();
    for (k, t) in mesh.triangles.iter().enumerate() {
        let next = number.len();
        let shell = *number.entry(root(&mut parent, k as u32)).or_insert(next);
        if shell == shells.len() {
            shells.push(TriMesh { positions: Vec::new(), triangles: Vec::new() });
            vertices.push(HashMap::new());
        }
        let (own, known) = (&mut shells[shell], &mut vertices[shell]);
        let triangle = t.map(|v| {
            *known.entry(v).or_insert_with(|| {
                own.positions.push(mesh.positions[v as usize]);
                own.positions.len() as u32 - 1
            })
        });
        own.triangles.push(triangle);
    }
    if shells.len() > 1 { shells } else { Vec::new() }
}

impl DesignMesh {
    /// Checks that the triangles bound a solid and builds the tree. Vertices with equal coordinates are
    /// joined first.
    ///
    /// # Errors
    /// The first place where the mesh is not a solid.
    pub fn new(mesh: &TriMesh) -> Result<Self, DesignError> {
        let mesh = mesh.merge_equal_vertices();
        mesh.check_solid()?;
        let vertices: Vec<ParryVector> = mesh.positions.iter().map(to_parry).collect();
        let tree = tree_of(vertices, mesh.triangles.clone())?;
        let mut shells = Vec::new();
        for own in shells_of(&mesh) {
            let vertices = own.positions.iter().map(to_parry).collect();
            let (is_cavity, bounds) = (own.volume() < 0.0, own.aabb());
            shells.push(Shell { mesh: tree_of(vertices, own.triangles)?, bounds, is_cavity });
        }
        Ok(Self { mesh: tree, bounds: mesh.aabb(), shells })
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

    /// The middle of every stretch of the straight line between two points that lies inside of the design and
    /// begins and ends on its surface; at most eight.
    pub fn middles_inside(&self, from: &Point, to: &Point) -> Vec<Point> {
        const MOST: usize = 16;
        /// Fraction of the line by which a search steps past a face.
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

    /// Thickness of the design below a point of its surface with outward normal `n`: way to the next face,
    /// mm; infinite where there is none.
    pub fn thickness(&self, p: &Point, n: &Vector) -> f64 {
        // A nanometer below, so that the face itself is not met.
        const UNDER: f64 = 1e-6;
        let from = p - n * UNDER;
        let ray = Ray::new(to_parry(&from), ParryVector::new(-n.x, -n.y, -n.z));
        self.mesh.cast_local_ray(&ray, f64::MAX, false).map_or(f64::INFINITY, |s| s + UNDER)
    }
}

impl DesignSurface for DesignMesh {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        /// Part by which the search reaches farther than asked: it keeps what is strictly nearer than its
        /// bound.
        const BEYOND: f64 = 1e-12;
        if !p.iter().all(|v| v.is_finite()) {
            return None;
        }
        let bound = if range < f64::MAX { range * (1.0 + BEYOND) + f64::MIN_POSITIVE } else { f64::MAX };
        let nearest = nearest_of(&self.mesh, p, bound)?;
        if self.shells.is_empty() {
            return Some(nearest);
        }
        let is_inside = self.shells.iter().map(|s| s.turns(p)).sum::<i32>() > 0;
        let length = nearest.distance.abs();
        Some(NearestOnDesign { distance: if is_inside { -length } else { length }, ..nearest })
    }
}

/// The nearest place of one shell or several that keep apart.
fn nearest_of(mesh: &ParryMesh, p: &Point, bound: f64) -> Option<NearestOnDesign> {
    let q = to_parry(p);
    let (projection, (triangle, location)) =
        mesh.project_local_point_and_get_location_with_max_dist(q, false, bound)?;
    let away = from_parry(q - projection.point);
    let length = away.norm();
    let index = mesh.indices().get(triangle as usize)?;
    let pseudo = mesh.pseudo_normals()?;
    let normal = match location {
        TrianglePointLocation::OnVertex(i) => {
            pseudo.vertices_pseudo_normal.get(*index.get(i as usize)? as usize).copied()
        }
        TrianglePointLocation::OnEdge(i, _) => {
            pseudo.edges_pseudo_normal.get(triangle as usize)?.get(i as usize).copied()
        }
        _ => Some(mesh.triangle(triangle).scaled_normal()),
    }?;
    let normal = from_parry(normal).try_normalize(0.0)?;
    Some(NearestOnDesign { distance: if away.dot(&normal) < 0.0 { -length } else { length }, normal })
}

fn to_parry(p: &Point) -> ParryVector {
    ParryVector::new(p.x, p.y, p.z)
}

fn from_parry(v: ParryVector) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use proveout_geom::box_mesh;

    use super::*;

    fn cube(low: [f64; 3], high: [f64; 3]) -> TriMesh {
        box_mesh(&Aabb { min: low.into(), max: high.into() })
    }

    #[test]
    fn shells_that_touch_are_one_solid_and_cavities_are_outside() {
        let mut mesh = cube([0.0; 3], [40.0, 40.0, 10.0]);
        mesh.append(&cube([19.9, 19.9, 10.0], [20.1, 20.1, 15.0]));
        let mut cavity = cube([5.0, 5.0, 3.0], [9.0, 9.0, 7.0]);
        cavity.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        mesh.append(&cavity);
        let design = DesignMesh::new(&mesh).expect("three shells");
        let sign = |p: [f64; 3]| design.signed_distance(&p.into()).expect("near").signum();
        // Below the bottom of the pin, where its face looks down.
        assert_eq!(sign([20.0, 20.0, 9.0]), -1.0);
        assert_eq!(sign([19.97, 20.03, 5.0008]), -1.0);
        assert_eq!(sign([20.0, 20.0, 12.0]), -1.0);
        assert_eq!(sign([20.2, 20.0, 12.0]), 1.0);
        assert_eq!(sign([7.0, 7.0, 5.0]), 1.0);
        assert_eq!(sign([4.9, 7.0, 5.0]), -1.0);
        assert_eq!(sign([7.0, 7.0, 11.0]), 1.0);
    }
}
