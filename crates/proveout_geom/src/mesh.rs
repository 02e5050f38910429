use std::collections::BTreeMap;

use thiserror::Error;

use crate::{Aabb, Crossing, Point, Pose, Vector};

/// Why triangles do not bound a solid.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeshError {
    /// No triangle at all.
    #[error("the mesh has no triangles")]
    Empty,
    /// A coordinate is not a number.
    #[error("vertex {vertex} is not finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices}")]
    Index {
        /// Index of the triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// An edge belongs to one triangle only: the mesh has a hole.
    #[error(
        "the mesh has a hole: edge ({}) to ({}) belongs to one triangle only (triangle {triangle}; {open_edges} open edges in all)",
        show(from),
        show(to)
    )]
    Open {
        /// First end of the first open edge, mm.
        from: Point,
        /// Second end.
        to: Point,
        /// Triangle that has the edge.
        triangle: usize,
        /// Number of open edges.
        open_edges: usize,
    },
    /// Two triangles run along an edge in the same direction, or more than two share it.
    #[error(
        "edge ({}) to ({}) is run through twice in the same direction (triangle {triangle}): turned or doubled faces",
        show(from),
        show(to)
    )]
    NotManifold {
        /// First end of the edge, mm.
        from: Point,
        /// Second end.
        to: Point,
        /// Second triangle with the edge.
        triangle: usize,
    },
    /// An edge passes through a face.
    #[error(
        "the mesh crosses itself at ({}): edge ({}) to ({}) of triangle {} passes through triangle {}",
        show(&.0.at),
        show(&.0.edge[0]),
        show(&.0.edge[1]),
        .0.of,
        .0.through
    )]
    Crossing(Box<Crossing>),
    /// Two faces lie in each other.
    #[error(
        "the mesh overlaps itself near ({}): triangles {first} and {second} share a piece of the same face",
        show(near)
    )]
    Overlap {
        /// Index of one triangle.
        first: usize,
        /// Index of the other one.
        second: usize,
        /// Middle of the box that both share, mm.
        near: Point,
    },
    /// The faces look inward.
    #[error("the mesh is inside out: its volume is {volume_mm3:.3} mm3")]
    InsideOut {
        /// Signed volume, mm³.
        volume_mm3: f64,
    },
}

fn show(p: &Point) -> String {
    format!("{:.4}, {:.4}, {:.4}", p.x, p.y, p.z)
}

/// Indexed triangle mesh; counter-clockwise seen from outside.
///
/// ```
/// use proveout_geom::{Aabb, MeshError, Point, box_mesh};
///
/// let block = Aabb { min: Point::origin(), max: Point::new(100.0, 60.0, 20.0) }; // mm
/// let mut mesh = box_mesh(&block);
/// mesh.check_solid()?;
/// assert!((mesh.volume() - 120_000.0).abs() < 1e-6); // mm3
/// mesh.triangles.pop();
/// assert!(matches!(mesh.check_solid(), Err(MeshError::Open { open_edges: 3, .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertices, mm.
    pub positions: Vec<Point>,
    /// Three vertex indices a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Point; 3] {
        self.triangles[triangle].map(|i| self.positions[i as usize])
    }

    /// Smallest box round all vertices.
    pub fn aabb(&self) -> Aabb {
        Aabb::of_points(&self.positions)
    }

    /// Enclosed volume, mm³, by the divergence theorem; negative when inside out.
    pub fn volume(&self) -> f64 {
        let Some(origin) = self.positions.first() else { return 0.0 };
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t).map(|p| p - origin);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum()
    }

    /// The mesh in another frame.
    pub fn transformed(&self, a_from_b: &Pose) -> Self {
        Self {
            positions: self.positions.iter().map(|p| a_from_b.point(p)).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Adds another mesh; the two stay separate shells.
    pub fn append(&mut self, other: &Self) {
        let base = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }

    /// Joins vertices with identical coordinates, as files without indices (STL) need, and drops triangles
    /// that have lost a corner by it.
    pub fn merge_equal_vertices(&self) -> Self {
        let key = |p: &Point| [p.x, p.y, p.z].map(|v| (v + 0.0).to_bits()); // + 0.0 makes -0 and 0 one key
        let mut index = BTreeMap::new();
        let mut positions = Vec::new();
        let map: Vec<u32> = self
            .positions
            .iter()
            .map(|p| {
                *index.entry(key(p)).or_insert_with(|| {
                    positions.push(*p);
                    positions.len() as u32 - 1
                })
            })
            .collect();
        let triangles = self
            .triangles
            .iter()
            .map(|t| t.map(|i| map[i as usize]))
            .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            .collect();
        Self { positions, triangles }
    }

    /// Proves that the triangles bound a solid: finite, closed, consistently oriented, faces outward.
    ///
    /// # Errors
    /// The first violation, with its place.
    pub fn check_solid(&self) -> Result<(), MeshError> {
        if self.triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        if let Some(vertex) = self.positions.iter().position(|p| p.iter().any(|v| !v.is_finite())) {
            return Err(MeshError::NotFinite { vertex });
        }
        let edges = DirectedEdges::of(self)?;
        if let Some(error) = edges.first_open(self) {
            return Err(error);
        }
        let volume_mm3 = self.volume();
        if volume_mm3 <= 0.0 {
            return Err(MeshError::InsideOut { volume_mm3 });
        }
        Ok(())
    }

    /// Proves that no edge passes through a face and no faces lie in each other, on a mesh that
    /// [`Self::check_solid`] has found in order.
    ///
    /// # Errors
    /// [`MeshError::Crossing`] or [`MeshError::Overlap`] with the first one.
    pub fn check_uncrossed(&self) -> Result<(), MeshError> {
        if let Some(crossing) = self.first_crossing() {
            return Err(MeshError::Crossing(Box::new(crossing)));
        }
        let overlap = self.first_overlap();
        overlap.map_or(Ok(()), |o| Err(MeshError::Overlap { first: o.first, second: o.second, near: o.near }))
    }

    /// Outward normal of a triangle, not of unit length: twice the area, mm².
    pub fn area_normal(&self, triangle: usize) -> Vector {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(&(c - a))
    }
}

/// Edges of the triangles by the vertex that they begin at, each with its end and its place in the order of
/// triangles.
struct DirectedEdges {
    /// Where those of each vertex begin; one more than there are vertices.
    first: Vec<u32>,
    /// End and three times the triangle and the number in it, rising for each vertex.
    ends: Vec<(u32, u32)>,
}

impl DirectedEdges {
    /// # Errors
    /// The first triangle that names a vertex that does not exist, or runs along an edge as one before it
    /// does.
    fn of(mesh: &TriMesh) -> Result<Self, MeshError> {
        let vertices = mesh.positions.len();
        let wrong = |t: &[u32; 3]| t.iter().copied().find(|i| *i as usize >= vertices);
        let named = mesh.triangles.iter().position(|t| wrong(t).is_some()).unwrap_or(mesh.triangles.len());
        let triangles = &mesh.triangles[..named];
        let mut first = vec![0; vertices + 1];
        for i in triangles.iter().flatten() {
            first[*i as usize + 1] += 1;
        }
        for v in 0..vertices {
            first[v + 1] += first[v];
        }
        let mut next = first.clone();
        let mut ends = vec![(0, 0); 3 * triangles.len()];
        for (k, t) in triangles.iter().enumerate() {
            for i in 0..3 {
                let place = &mut next[t[i] as usize];
                ends[*place as usize] = (t[(i + 1) % 3], (3 * k + i) as u32);
                *place += 1;
            }
        }
        let mut twice: Option<u32> = None;
        for v in 0..vertices {
            let own = &mut ends[first[v] as usize..first[v + 1] as usize];
            own.sort_unstable();
            for w in own.windows(2).filter(|w| w[0].0 == w[1].0) {
                twice = Some(twice.map_or(w[1].1, |before| before.min(w[1].1)));
            }
        }
        if let Some(place) = twice {
            let (triangle, i) = (place as usize / 3, place as usize % 3);
            let t = &triangles[triangle];
            let [from, to] = [t[i], t[(i + 1) % 3]].map(|v| mesh.positions[v as usize]);
            return Err(MeshError::NotManifold { from, to, triangle });
        }
        match mesh.triangles.get(named).and_then(wrong) {
            Some(vertex) => Err(MeshError::Index { triangle: named, vertex, vertices }),
            None => Ok(Self { first, ends }),
        }
    }

    fn leaving(&self, vertex: usize) -> &[(u32, u32)] {
        &self.ends[self.first[vertex] as usize..self.first[vertex + 1] as usize]
    }

    /// The first edge, by its vertices, that no triangle runs along the other way.
    fn first_open(&self, mesh: &TriMesh) -> Option<MeshError> {
        let closed =
            |from: usize, to: u32| self.leaving(to as usize).binary_search_by_key(&(from as u32), |e| e.0).is_ok();
        let open = (0..mesh.positions.len())
            .flat_map(|v| self.leaving(v).iter().filter(move |e| !closed(v, e.0)).map(move |e| (v, *e)));
        let mut open = open.peekable();
        let (from, (to, place)) = *open.peek()?;
        let [from, to] = [from, to as usize].map(|v| mesh.positions[v]);
        Some(MeshError::Open { from, to, triangle: place as usize / 3, open_edges: open.count() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::box_mesh;

    fn cube() -> TriMesh {
        box_mesh(&Aabb { min: Point::new(-1.0, 0.0, 2.0), max: Point::new(1.0, 3.0, 6.0) })
    }

    #[test]
    fn a_box_is_a_solid_of_its_volume() {
        cube().check_solid().expect("a box is a solid");
        assert!((cube().volume() - 24.0).abs() < 1e-12);
    }

    #[test]
    fn each_defect_is_named() {
        let mut hole = cube();
        hole.triangles.pop();
        assert!(matches!(hole.check_solid(), Err(MeshError::Open { open_edges: 3, .. })));
        let mut turned = cube();
        turned.triangles[0].swap(0, 1);
        assert!(matches!(turned.check_solid(), Err(MeshError::NotManifold { .. })));
        let mut inside_out = cube();
        for t in &mut inside_out.triangles {
            t.swap(0, 1);
        }
        assert!(matches!(inside_out.check_solid(), Err(MeshError::InsideOut { .. })));
        assert_eq!(TriMesh::default().check_solid(), Err(MeshError::Empty));
        let mut nan = cube();
        nan.positions[3].y = f64::NAN;
        assert_eq!(nan.check_solid(), Err(MeshError::NotFinite { vertex: 3 }));
        let mut index = cube();
        index.triangles[2][1] = 99;
        assert!(matches!(index.check_solid(), Err(MeshError::Index { vertex: 99, .. })));
    }

    #[test]
    fn merging_restores_the_topology_of_loose_triangles() {
        let cube = cube();
        let mut loose = TriMesh::default();
        for t in 0..cube.triangles.len() {
            let base = loose.positions.len() as u32;
            loose.positions.extend(cube.corners(t));
            loose.triangles.push([base, base + 1, base + 2]);
        }
        assert!(loose.check_solid().is_err());
        let merged = loose.merge_equal_vertices();
        assert_eq!(merged.positions.len(), 8);
        merged.check_solid().expect("merged box is a solid");
    }

    /// The violation found with a map of all edges, in the order of the triangles.
    fn violation(mesh: &TriMesh) -> Option<MeshError> {
        let vertices = mesh.positions.len();
        let mut owner = BTreeMap::new();
        for (triangle, t) in mesh.triangles.iter().enumerate() {
            if let Some(&vertex) = t.iter().find(|i| **i as usize >= vertices) {
                return Some(MeshError::Index { triangle, vertex, vertices });
            }
            for i in 0..3 {
                let (a, b) = (t[i], t[(i + 1) % 3]);
                if owner.insert((a, b), triangle).is_some() {
                    let [from, to] = [a, b].map(|v| mesh.positions[v as usize]);
                    return Some(MeshError::NotManifold { from, to, triangle });
                }
            }
        }
        let open: Vec<_> = owner.iter().filter(|((a, b), _)| !owner.contains_key(&(*b, *a))).collect();
        let ((a, b), triangle) = *open.first()?;
        let [from, to] = [a, b].map(|v| mesh.positions[*v as usize]);
        Some(MeshError::Open { from, to, triangle: *triangle, open_edges: open.len() })
    }

    /// Triangles left out, doubled, turned, with a corner moved to another vertex or to none, and in any
    /// order: the first violation and its place are the same.
    #[test]
    fn the_first_violation_is_that_of_a_map_of_all_edges() {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut below = |n: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as usize % n
        };
        let mut seen = [0; 4];
        for case in 0..4000 {
            let mut mesh = crate::cylinder_mesh(5.0, 0.0, 9.0, 3 + case % 9);
            for _ in 0..below(4) {
                let (k, other) = (below(mesh.triangles.len()), below(mesh.triangles.len()));
                match below(6) {
                    0 => drop(mesh.triangles.remove(k)),
                    1 => mesh.triangles.push(mesh.triangles[k]),
                    2 => mesh.triangles[k].swap(0, 1),
                    3 => mesh.triangles[k][below(3)] = below(mesh.positions.len()) as u32,
                    4 => mesh.triangles[k][below(3)] = (mesh.positions.len() + below(2)) as u32,
                    _ => mesh.triangles.swap(k, other),
                }
            }
            let found = mesh.check_solid().err().filter(|e| !matches!(e, MeshError::InsideOut { .. }));
            assert_eq!(found, violation(&mesh), "case {case}: {mesh:?}");
            seen[match found {
                None => 0,
                Some(MeshError::Open { .. }) => 1,
                Some(MeshError::NotManifold { .. }) => 2,
                Some(_) => 3,
            }] += 1;
        }
        assert!(seen.iter().all(|n| *n > 200), "{seen:?}");
    }
}
