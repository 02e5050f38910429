//! The surface of the cut part: what is shown of it band by band, and all of it gathered.

use std::ops::Range;

use proveout_geom::{Aabb, Point, TriMesh, Vector};

/// What the surface of a cut part is made of, without its points and triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceShape {
    /// Edges of the cells of the stock along x, y and z, mm.
    pub cells_mm: [f64; 3],
    /// Exact points, outside of the patches.
    pub points: u64,
    /// Triangles of the extracted surface, those inside of the windows of patches included.
    pub triangles: u64,
    /// Area, mm²; as `triangles`.
    pub area_mm2: f64,
    /// Whether the points have deviations.
    pub judged: bool,
    /// The patches, in the order of the scene.
    pub patches: Vec<PatchShape>,
}

/// What the surface in the window of a patch is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchShape {
    /// Name in the scene.
    pub name: String,
    /// Where it counts.
    pub window: Aabb,
    /// Edges of its cells along x, y and z, mm.
    pub cells_mm: [f64; 3],
    /// Exact points.
    pub points: u64,
    /// Triangles, those of its guard round the window included.
    pub triangles: u64,
    /// Area in the window, mm².
    pub area_mm2: f64,
}

impl SurfaceShape {
    /// Triangles of all parts.
    pub fn all_triangles(&self) -> u64 {
        self.triangles + self.patches.iter().map(|p| p.triangles).sum::<u64>()
    }

    /// Number of points of the stock's own cells that one point replaces: 1 outside of the patches.
    /// Means and shares over points take it as weight, so that a patch does not count more than its
    /// area.
    ///
    /// Rays along axis a with cells of area A meet a surface of unit normal n at `|n_a| / A` points an area.
    pub fn weight(stock_cells_mm: [f64; 3], patch_cells_mm: Option<[f64; 3]>, point: &MapPoint) -> f64 {
        let density = |cells: [f64; 3]| -> f64 {
            (0..3).map(|a| point.normal[a].abs() / (cells[(a + 1) % 3] * cells[(a + 2) % 3])).sum()
        };
        patch_cells_mm.map_or(1.0, |cells| {
            let fine = density(cells);
            if fine > 0.0 { density(stock_cells_mm) / fine } else { 0.0 }
        })
    }
}

/// The cut part's surface: extracted mesh, and the exact points of the dexel ends with what was measured
/// there. Workpiece frame, mm.
///
/// Where the stock has patches, mesh and points inside of their windows are those of the patch:
/// [`Self::mesh`] ends at the faces of the windows, where the mesh of a patch begins (their vertices there
/// are not shared).
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
    /// What the geometry of cutter, lean, step and design gives there, mm; none where it is not known.
    pub scallop_geometric: Option<f64>,
    /// Index of the motion piece that made the point; none for the skin of the stock.
    pub made_by: Option<u32>,
}

impl SurfaceMap {
    /// Triangles of all parts.
    pub fn triangles(&self) -> usize {
        self.mesh.triangles.len() + self.patches.iter().map(|p| p.mesh.triangles.len()).sum::<usize>()
    }

    /// All points, each with its [`SurfaceShape::weight`].
    pub fn weighted_points(&self) -> impl Iterator<Item = (&MapPoint, f64)> {
        let own = self.patches.first().map_or(self.points.len(), |p| p.points.start);
        let in_patches = self.patches.iter().flat_map(move |patch| {
            let weight = |p| SurfaceShape::weight(self.cells_mm, Some(patch.cells_mm), p);
            self.points[patch.points.clone()].iter().map(move |p| (p, weight(p)))
        });
        self.points[..own].iter().map(|p| (p, 1.0)).chain(in_patches)
    }

    /// What it is made of.
    pub fn shape(&self) -> SurfaceShape {
        let area = |mesh: &TriMesh| (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_normal(t).norm()).sum::<f64>();
        let own = self.patches.first().map_or(self.points.len(), |p| p.points.start);
        let patch = |p: &PatchMap| PatchShape {
            name: p.name.clone(),
            window: p.window,
            cells_mm: p.cells_mm,
            points: p.points.len() as u64,
            triangles: p.mesh.triangles.len() as u64,
            area_mm2: area(&p.mesh),
        };
        SurfaceShape {
            cells_mm: self.cells_mm,
            points: own as u64,
            triangles: self.mesh.triangles.len() as u64,
            area_mm2: area(&self.mesh),
            judged: !self.vertex_deviation.is_empty(),
            patches: self.patches.iter().map(patch).collect(),
        }
    }

    /// Its points as an observer sees them: one band for each part.
    pub fn point_bands(&self) -> impl Iterator<Item = PointBand<'_>> {
        let own = self.patches.first().map_or(self.points.len(), |p| p.points.start);
        let patches = self.patches.iter().enumerate();
        std::iter::once(PointBand { patch: None, points: &self.points[..own] })
            .chain(patches.map(move |(k, p)| PointBand { patch: Some(k), points: &self.points[p.points.clone()] }))
    }

    /// Its meshes as an observer sees them: one band for each part.
    pub fn mesh_parts(&self) -> impl Iterator<Item = MeshPart<'_>> {
        fn part<'a>(
            patch: Option<usize>,
            mesh: &'a TriMesh,
            normals: &'a [Vector],
            deviations: &'a [f64],
        ) -> MeshPart<'a> {
            let (positions, triangles) = (mesh.positions.as_slice(), mesh.triangles.as_slice());
            MeshPart {
                patch,
                first: 0,
                from_x: f64::NEG_INFINITY,
                positions,
                normals,
                deviations,
                made_by: &[],
                triangles,
            }
        }
        let patches = self.patches.iter().enumerate();
        patches.map(|(k, p)| part(Some(k), &p.mesh, &p.normals, &p.vertex_deviation)).chain(std::iter::once(part(
            None,
            &self.mesh,
            &self.normals,
            &self.vertex_deviation,
        )))
    }

    /// The surface of all parts as one mesh with its normals; parts are not joined at the faces of the
    /// windows.
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

/// Some points of the surface of the cut part, in the fixed order of the stock, then of each patch. Workpiece
/// frame, mm.
#[derive(Clone, Copy)]
pub struct PointBand<'a> {
    /// Number of the patch that they are points of; none for the stock itself.
    pub patch: Option<usize>,
    /// The points.
    pub points: &'a [MapPoint],
}

/// A part of the extracted surface: the meshes of the patches come first, then that of the stock, each band
/// by band along x. Workpiece frame, mm.
#[derive(Clone, Copy)]
pub struct MeshPart<'a> {
    /// Number of the patch that it belongs to; none for the stock itself.
    pub patch: Option<usize>,
    /// Vertices of this mesh in the bands before.
    pub first: u32,
    /// No vertex of this band or a later one, and no triangle of them, reaches below this x.
    pub from_x: f64,
    /// Its vertices.
    pub positions: &'a [Point],
    /// Outward unit normals.
    pub normals: &'a [Vector],
    /// Signed deviation from the design at the vertices; not a number where no design surface applies; empty
    /// when there is no design.
    pub deviations: &'a [f64],
    /// Number of the motion piece, in the order of [`Batch::pieces`](crate::observer::Batch::pieces), that
    /// made the surface at the vertex; none for the skin of the raw stock; empty where it is not known.
    pub made_by: &'a [Option<u32>],
    /// Triangles by the numbers of vertices in the whole mesh: those of this band and of the one before.
    pub triangles: &'a [[u32; 3]],
}
