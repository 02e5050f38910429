//! Meshes for pictures: positions in single precision, normals, a value a vertex, and their reduction to a
//! bounded size.

use nalgebra::{Matrix3, Vector3};
use proveout_geom::{Aabb, Point, TriMesh, Vector};

/// Least area that has a normal, mm²: any that is not zero.
pub(crate) const NO_AREA: f64 = 1e-300;
/// Square of the length of a normal that is given: a shorter one is none.
pub(crate) const LEAST_SQUARE: f64 = 1e-12;
/// Shortest edge of a cell in which vertices become one, mm.
pub(crate) const LEAST_CELL_MM: f64 = 1e-6;
/// Normals whose cosine is closer to 1 are the same: rounding.
const SAME_NORMAL: f64 = 1e-9;
/// Normals of a cell whose sum is shorter cancel out.
const NO_NORMAL: f64 = 1e-12;
/// Part of the largest eigenvalue from which on the faces of a cell say where its vertex lies along the
/// direction.
const CERTAIN: f64 = 1e-2;

/// Indexed triangles with a normal and a value a vertex; mm, counter-clockwise seen from outside.
///
/// Single precision is enough for pictures only (0.06 µm at 1000 mm); what is measured stays in
/// `surface.parquet`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Picture {
    /// Positions, mm.
    pub(crate) positions: Vec<[f32; 3]>,
    /// Unit normals, as many as positions.
    pub(crate) normals: Vec<[f32; 3]>,
    /// A value for each position, such as its deviation (mm), not a number where there is none; empty when no
    /// vertex has one.
    pub(crate) values: Vec<f32>,
    /// Motion piece that made each vertex, [`NO_PIECE`] where none did; empty when it is not known of any.
    pub(crate) pieces: Vec<u32>,
    /// Three vertex indices a triangle.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Of a vertex that no motion has made.
pub(crate) const NO_PIECE: u32 = u32::MAX;

/// In single precision.
pub(crate) fn single(v: &Vector) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

impl Picture {
    /// A mesh with the given outward normals and values (either may be empty).
    ///
    /// Missing normals, and normals that are not finite, are replaced by the area-weighted mean of the faces
    /// round the vertex. Triangles that name a missing vertex or one that is not finite are left out: files
    /// for viewers must not carry such numbers.
    pub(crate) fn new(mesh: &TriMesh, normals: &[Vector], values: &[f64]) -> Self {
        let count = mesh.positions.len();
        let finite: Vec<bool> = mesh.positions.iter().map(|p| p.iter().all(|v| v.is_finite())).collect();
        let good = |t: &&[u32; 3]| t.iter().all(|&i| finite.get(i as usize).copied().unwrap_or(false));
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(good).copied().collect();
        let given =
            |i: usize| normals.get(i).filter(|n| n.norm_squared().is_finite() && n.norm_squared() > LEAST_SQUARE);
        // If the surface gives all normals, no faces are needed.
        let mut sums = Vec::new();
        if !(0..count).all(|i| given(i).is_some()) {
            sums = vec![Vector::zeros(); count];
            for t in &triangles {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                let area = (b - a).cross(&(c - a));
                for &i in t {
                    sums[i as usize] += area;
                }
            }
        }
        let unit = |i: usize| {
            let normal = given(i).or_else(|| sums.get(i)).and_then(|n| n.try_normalize(NO_AREA));
            normal.unwrap_or_else(Vector::z)
        };
        Self {
            positions: mesh
                .positions
                .iter()
                .zip(&finite)
                .map(|(p, ok)| if *ok { single(&p.coords) } else { [0.0; 3] })
                .collect(),
            normals: (0..count).map(|i| single(&unit(i))).collect(),
            values: if values.len() == count { values.iter().map(|v| *v as f32).collect() } else { Vec::new() },
            pieces: Vec::new(),
            triangles,
        }
    }

    /// A mesh with sharp edges: where two faces meet at more than `crease` (radian), the vertex is doubled,
    /// so that boxes look like boxes.
    pub(crate) fn creased(mesh: &TriMesh, crease: f64) -> Self {
        let limit = crease.cos();
        let merged = mesh.merge_equal_vertices();
        let normal = |t: usize| merged.area_normal(t).try_normalize(NO_AREA);
        let faces: Vec<Option<Vector>> = (0..merged.triangles.len()).map(normal).collect();
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); merged.positions.len()];
        for (t, triangle) in merged.triangles.iter().enumerate() {
            for &i in triangle {
                around[i as usize].push(t as u32);
            }
        }
        let mut out = Self::default();
        let mut made: Vec<Vec<(Vector, u32)>> = vec![Vec::new(); merged.positions.len()];
        for (t, triangle) in merged.triangles.iter().enumerate() {
            let Some(face) = faces[t] else { continue };
            out.triangles.push(triangle.map(|i| {
                let mut sum = Vector::zeros();
                for &other in &around[i as usize] {
                    if let Some(n) = faces[other as usize].filter(|n| n.dot(&face) >= limit) {
                        sum += n * merged.area_normal(other as usize).norm();
                    }
                }
                let n = sum.try_normalize(NO_AREA).unwrap_or(face);
                let known = &mut made[i as usize];
                if let Some((_, index)) = known.iter().find(|(m, _)| m.dot(&n) > 1.0 - SAME_NORMAL) {
                    return *index;
                }
                let index = out.positions.len() as u32;
                out.positions.push(single(&merged.positions[i as usize].coords));
                out.normals.push(single(&n));
                known.push((n, index));
                index
            }));
        }
        out
    }

    /// Adds another mesh; values stay only when both have them or one is empty.
    pub(crate) fn append(&mut self, other: &Self) {
        let base = self.positions.len() as u32;
        if self.positions.is_empty() || (self.values.is_empty() == other.values.is_empty()) {
            self.values.extend_from_slice(&other.values);
        } else if !other.positions.is_empty() {
            self.values.clear();
        }
        if !self.pieces.is_empty() || !other.pieces.is_empty() {
            self.pieces.resize(self.positions.len(), NO_PIECE);
            self.pieces.extend_from_slice(&other.pieces);
            self.pieces.resize(self.positions.len() + other.positions.len(), NO_PIECE);
        }
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }

    /// Smallest box round the vertices that triangles use.
    pub(crate) fn aabb(&self) -> Aabb {
        let mut all = Aabb::empty();
        for i in self.triangles.iter().flatten() {
            all.grow(&self.point(*i));
        }
        all
    }

    fn point(&self, i: u32) -> Point {
        Point::from(self.positions[i as usize].map(f64::from))
    }

    /// The same shape with at most `limit` triangles, and the edge length (mm) of the cells it was gathered
    /// in; itself when it is small enough.
    pub(crate) fn reduced(self, limit: usize) -> (Self, Option<f64>) {
        if self.triangles.len() <= limit {
            return (self, None);
        }
        let area: f64 = (0..self.triangles.len()).map(|t| self.area_normal(t).norm() * 0.5).sum();
        // A cell of edge h keeps about two triangles a h² of surface.
        let mut cell = (2.0 * area / limit.max(1) as f64).sqrt().max(LEAST_CELL_MM);
        // Counting is cheap against placing the vertices.
        loop {
            let (of_vertex, _) = self.cells(cell);
            let apart = |t: &&[u32; 3]| {
                let [a, b, c] = t.map(|i| of_vertex[i as usize]);
                a != b && b != c && c != a
            };
            let count = self.triangles.iter().filter(apart).count();
            if count <= limit {
                return (self.clustered(cell), Some(cell));
            }
            cell *= (count as f64 / limit.max(1) as f64).sqrt().max(1.05);
        }
    }

    fn area_normal(&self, t: usize) -> Vector {
        let [a, b, c] = self.triangles[t].map(|i| self.point(i));
        (b - a).cross(&(c - a))
    }

    /// Number of the cell of each vertex (`u32::MAX` for vertices that no triangle uses), and the place of
    /// each cell in the grid, in rising order.
    fn cells(&self, cell: f64) -> (Vec<u32>, Vec<[i64; 3]>) {
        let key = |i: u32| self.positions[i as usize].map(|v| (f64::from(v) / cell).floor() as i64);
        let mut used = vec![false; self.positions.len()];
        for &i in self.triangles.iter().flatten() {
            used[i as usize] = true;
        }
        let mut keyed: Vec<([i64; 3], u32)> =
            (0..self.positions.len() as u32).filter(|&i| used[i as usize]).map(|i| (key(i), i)).collect();
        keyed.sort_unstable();
        let mut of_vertex = vec![u32::MAX; self.positions.len()];
        let mut keys: Vec<[i64; 3]> = Vec::new();
        for (k, i) in keyed {
            if keys.last() != Some(&k) {
                keys.push(k);
            }
            of_vertex[i as usize] = keys.len() as u32 - 1;
        }
        (of_vertex, keys)
    }

    /// Gathers the vertices of each cubic cell (edge `cell`, mm, grid through the origin) into one.
    ///
    /// Vertex clustering after Rossignac and Borrel (1993); the new vertex is put where the sum of squared
    /// distances from the planes of the cell's triangles is least (Lindstrom 2000, quadric error), so that
    /// edges and corners stay sharp. Along directions that the planes leave open it stays at the mean of the
    /// cell's vertices, and it never leaves the cell. Known limit: walls thinner than a cell may merge. For
    /// pictures only.
    pub(crate) fn clustered(&self, cell: f64) -> Self {
        let (cluster_of, keys) = self.cells(cell);
        let mut clusters: Vec<Cluster> = keys.into_iter().map(|key| Cluster::new(key, cell)).collect();
        for (i, &id) in cluster_of.iter().enumerate() {
            let Some(c) = clusters.get_mut(id as usize) else { continue }; // no triangle uses the vertex
            let value = self.values.get(i).map(|v| f64::from(*v));
            c.add_vertex(&self.positions[i], &Vector::from(self.normals[i].map(f64::from)), value);
        }
        let mut triangles = Vec::new();
        for (t, triangle) in self.triangles.iter().enumerate() {
            let ids = triangle.map(|i| cluster_of[i as usize]);
            let area = self.area_normal(t);
            if let Some(n) = area.try_normalize(NO_AREA) {
                let corner = self.point(triangle[0]).coords;
                for (k, &id) in ids.iter().enumerate() {
                    if !ids[..k].contains(&id) {
                        clusters[id as usize].add_plane(&n, &corner, area.norm());
                    }
                }
            }
            if ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0] {
                let least = (0..3).min_by_key(|&k| ids[k]).unwrap_or(0);
                triangles.push([ids[least], ids[(least + 1) % 3], ids[(least + 2) % 3]]);
            }
        }
        // Two sheets that fall together give the same triangle twice.
        triangles.sort_unstable();
        triangles.dedup();
        let mut pieces = Vec::new();
        if !self.pieces.is_empty() {
            pieces = vec![NO_PIECE; clusters.len()];
            // Of the first vertex of the cell that a motion has made.
            for (i, &id) in cluster_of.iter().enumerate() {
                if let (Some(piece), Some(made)) = (pieces.get_mut(id as usize), self.pieces.get(i))
                    && *piece == NO_PIECE
                {
                    *piece = *made;
                }
            }
        }
        Self {
            pieces,
            positions: clusters.iter().map(|c| single(&c.place(cell))).collect(),
            normals: clusters.iter().map(|c| single(&c.normal())).collect(),
            values: if self.values.is_empty() {
                Vec::new()
            } else {
                clusters.iter().map(Cluster::mean_value).collect()
            },
            triangles,
        }
    }
}

/// Sums over the vertices and planes of one cell, in any order.
#[derive(Clone, Debug)]
pub(crate) struct Cluster {
    key: [i64; 3],
    /// Middle of the cell: planes are taken from there, against rounding.
    middle: Vector,
    count: f64,
    position: Vector,
    normal: Vector,
    value: f64,
    valued: f64,
    /// Sum of w n nᵀ.
    a: Matrix3<f64>,
    /// Sum of w n (n · (p - middle)).
    b: Vector,
}

impl Cluster {
    /// The cell of edge `cell` (mm) with this place in the grid.
    pub(crate) fn new(key: [i64; 3], cell: f64) -> Self {
        Self {
            key,
            middle: Vector::from(key.map(|k| (k as f64 + 0.5) * cell)),
            count: 0.0,
            position: Vector::zeros(),
            normal: Vector::zeros(),
            value: 0.0,
            valued: 0.0,
            a: Matrix3::zeros(),
            b: Vector::zeros(),
        }
    }

    pub(crate) fn add_vertex(&mut self, position: &[f32; 3], normal: &Vector, value: Option<f64>) {
        self.count += 1.0;
        self.position += Vector3::from(position.map(f64::from)) - self.middle;
        self.normal += normal;
        if let Some(value) = value.filter(|v| v.is_finite()) {
            self.value += value;
            self.valued += 1.0;
        }
    }

    pub(crate) fn add_plane(&mut self, n: &Vector, p: &Vector, weight: f64) {
        self.a += n * n.transpose() * weight;
        self.b += n * (n.dot(&(p - self.middle)) * weight);
    }

    /// Mean of the normals.
    pub(crate) fn normal(&self) -> Vector {
        self.normal.try_normalize(NO_NORMAL).unwrap_or_else(Vector::z)
    }

    /// Least squares point in the cell: directions whose eigenvalue is below a hundredth of the largest are
    /// open.
    pub(crate) fn place(&self, cell: f64) -> Vector {
        let mean = self.position / self.count.max(1.0);
        let eigen = self.a.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let rest = self.b - self.a * mean;
        let mut shift = Vector::zeros();
        for k in 0..3 {
            let value = eigen.eigenvalues[k];
            if value > CERTAIN * largest && value > 0.0 {
                let direction = eigen.eigenvectors.column(k);
                shift += direction * (direction.dot(&rest) / value);
            }
        }
        let mut place = self.middle + mean + if shift.norm().is_finite() { shift } else { Vector::zeros() };
        for k in 0..3 {
            let low = self.key[k] as f64 * cell;
            place[k] = place[k].clamp(low, low + cell);
        }
        place
    }

    /// Not a number when no vertex of the cell has a value.
    pub(crate) fn mean_value(&self) -> f32 {
        (self.value / self.valued) as f32
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::{box_mesh, cylinder_mesh};

    use super::*;

    fn cube() -> TriMesh {
        box_mesh(&Aabb { min: Point::new(-1.0, -2.0, -3.0), max: Point::new(4.0, 3.0, 2.0) })
    }

    /// A box face split into many triangles keeps its corners.
    fn fine_box(n: u32) -> TriMesh {
        let mut mesh = TriMesh::default();
        let base = cube();
        for t in 0..base.triangles.len() {
            let [a, b, c] = base.corners(t);
            let at =
                |i: u32, j: u32| a + (b - a) * (f64::from(i) / f64::from(n)) + (c - a) * (f64::from(j) / f64::from(n));
            let mut put = |p: [Point; 3]| {
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(p);
                mesh.triangles.push([first, first + 1, first + 2]);
            };
            for i in 0..n {
                for j in 0..n - i {
                    put([at(i, j), at(i + 1, j), at(i, j + 1)]);
                    if i + j + 1 < n {
                        put([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                }
            }
        }
        mesh
    }

    #[test]
    fn creases_double_the_vertices_of_a_box_and_not_of_a_fine_cylinder() {
        let picture = Picture::creased(&cube(), 0.5);
        assert_eq!(picture.positions.len(), 24);
        assert_eq!(picture.triangles.len(), 12);
        for n in &picture.normals {
            assert_eq!(n.iter().map(|v| v.abs()).sum::<f32>(), 1.0, "normals of a box lie along axes");
        }
        let round = Picture::creased(&cylinder_mesh(5.0, 0.0, 10.0, 64), 0.5);
        assert_eq!(round.positions.len(), 2 * 64 + 2 * 65, "side and caps, each its own");
    }

    #[test]
    fn reduction_keeps_size_and_corners() {
        let fine = fine_box(40);
        let mut values = vec![0.25; fine.positions.len()];
        values[7] = f64::NAN;
        let picture = Picture::new(&fine, &[], &values);
        let before = picture.triangles.len();
        let (small, cell) = picture.clone().reduced(4000);
        let cell = cell.expect("it was reduced");
        assert!(small.triangles.len() <= 4000 && small.triangles.len() > 400, "{} of {before}", small.triangles.len());
        let (a, b) = (picture.aabb(), small.aabb());
        for k in 0..3 {
            assert!((a.min[k] - b.min[k]).abs() < 1e-5 && (a.max[k] - b.max[k]).abs() < 1e-5, "corners of a box stay");
        }
        assert!(cell < 2.0 && small.values.iter().all(|v| *v == 0.25));
        let mesh = TriMesh {
            positions: (0..small.positions.len() as u32).map(|i| small.point(i)).collect(),
            triangles: small.triangles.clone(),
        };
        // Planes stay planes and edges stay edges up to single precision: so does the volume.
        assert!((mesh.volume() - 125.0).abs() < 1e-3, "volume {}", mesh.volume());
    }

    #[test]
    fn numbers_that_are_not_finite_do_not_reach_a_viewer() {
        let mut bad = cube();
        bad.positions[3].x = f64::NAN;
        bad.triangles.push([0, 1, 99]);
        let picture = Picture::new(&bad, &[Vector::repeat(f64::NAN); 8], &[]);
        assert!(picture.positions.iter().chain(&picture.normals).flatten().all(|v| v.is_finite()));
        assert!(picture.triangles.iter().flatten().all(|&i| i != 3 && i < 8));
        assert!(!picture.triangles.is_empty());
        assert_eq!(Picture::default().reduced(10), (Picture::default(), None));
    }
}
