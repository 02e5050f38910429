use std::ops::Range;

use proveout_geom::{Aabb, Point, TriMesh, Vector};

/// The cut part's surface: extracted mesh, and the exact points of the dexel ends with what was measured there.
/// Workpiece frame, mm.
///
/// Where the stock has patches, mesh and points inside of their windows are those of the patch: [`Self::mesh`] ends at the faces
/// of the windows, where the mesh of a patch begins (their vertices there are not shared).
#[derive(Clone, Debug, Default)]
pub struct SurfaceMap {
    /// Extracted surface outside of the patches.
    pub mesh: TriMesh,
    /// Unit normals at the vertices of `mesh`, outward.
    pub normals: Vec<Vector>,
    /// Signed deviation from the design at the vertices of `mesh`, mm; NaN where no design
    /// surface applies; empty when there is no design.
    pub vertex_deviation: Vec<f64>,
    /// Exact points, in the fixed order of the stock, then of each patch.
    pub points: Vec<MapPoint>,
    /// Edges of the cells of the stock along x, y and z, mm.
    pub cells_mm: [f64; 3],
    /// The surface in the patches, in the order of the scene.
    pub patches: Vec<PatchMap>,
}

/// The surface in the window of a patch.
#[derive(Clone, Debug)]
pub struct PatchMap {
    /// Name in the scene.
    pub name: String,
    /// Where it counts.
    pub window: Aabb,
    /// Edges of its cells along x, y and z, mm.
    pub cells_mm: [f64; 3],
    /// As in [`SurfaceMap`].
    pub mesh: TriMesh,
    /// As in [`SurfaceMap`].
    pub normals: Vec<Vector>,
    /// As in [`SurfaceMap`].
    pub vertex_deviation: Vec<f64>,
    /// Which of [`SurfaceMap::points`] are its own.
    pub points: Range<usize>,
}

/// An exact point of the cut surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPoint {
    /// Position, mm.
    pub position: [f64; 3],
    /// Outward unit normal.
    pub normal: [f64; 3],
    /// Signed deviation from the design, mm; none where no design surface applies.
    pub deviation: Option<f64>,
    /// Scallop height, mm; none where not evaluated.
    pub scallop: Option<f64>,
    /// Index of the motion piece that made the point; none for the skin of the stock.
    pub made_by: Option<u32>,
}

impl SurfaceMap {
    /// Triangles of all parts.
    pub fn triangles(&self) -> usize {
        self.mesh.triangles.len() + self.patches.iter().map(|p| p.mesh.triangles.len()).sum::<usize>()
    }

    /// All points, each with the number of points of the stock's own cells that would stand in its place: 1 outside of the
    /// patches. Means and shares over points take it as weight, so that a patch does not count more than its area.
    ///
    /// Rays along axis a with cells of area A meet a surface of unit normal n at `|n_a| / A` points an area.
    pub fn weighted_points(&self) -> impl Iterator<Item = (&MapPoint, f64)> {
        let density = |p: &MapPoint, cells: [f64; 3]| -> f64 {
            (0..3).map(|a| p.normal[a].abs() / (cells[(a + 1) % 3] * cells[(a + 2) % 3])).sum()
        };
        let own = self.patches.first().map_or(self.points.len(), |p| p.points.start);
        let in_patches = self.patches.iter().flat_map(move |patch| {
            self.points[patch.points.clone()].iter().map(move |p| {
                let fine = density(p, patch.cells_mm);
                (p, if fine > 0.0 { density(p, self.cells_mm) / fine } else { 0.0 })
            })
        });
        self.points[..own].iter().map(|p| (p, 1.0)).chain(in_patches)
    }

    /// The surface of all parts as one mesh with its normals; parts are not joined at the faces of the windows.
    pub fn whole_mesh(&self) -> (TriMesh, Vec<Vector>) {
        let (mut mesh, mut normals) = (self.mesh.clone(), self.normals.clone());
        for patch in &self.patches {
            mesh.append(&patch.mesh);
            normals.extend_from_slice(&patch.normals);
        }
        (mesh, normals)
    }

    /// Deviation at the vertices of [`Self::whole_mesh`].
    pub fn whole_deviation(&self) -> Vec<f64> {
        let parts = self.patches.iter().flat_map(|p| &p.vertex_deviation);
        self.vertex_deviation.iter().chain(parts).copied().collect()
    }

    /// Points and cell (longest edge, mm) that count at a place.
    pub(crate) fn part_at(&self, place: &Point) -> usize {
        self.patches.iter().position(|p| p.window.contains(place)).map_or(0, |k| k + 1)
    }

    /// Points of a part, as [`Self::part_at`] counts them, and its longest cell, mm.
    pub(crate) fn part(&self, index: usize) -> (&[MapPoint], f64) {
        let longest = |cells: [f64; 3]| cells.into_iter().fold(0.0, f64::max);
        match index.checked_sub(1).and_then(|k| self.patches.get(k)) {
            Some(patch) => (&self.points[patch.points.clone()], longest(patch.cells_mm)),
            None => {
                let own = self.patches.first().map_or(self.points.len(), |p| p.points.start);
                (&self.points[..own], longest(self.cells_mm))
            }
        }
    }
}
