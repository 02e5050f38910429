use proveout_geom::TriMesh;

/// The cut part's surface: extracted mesh, and the exact points of the dexel ends with what was measured there.
/// Workpiece frame, mm.
#[derive(Clone, Debug, Default)]
pub struct SurfaceMap {
    /// Extracted surface.
    pub mesh: TriMesh,
    /// Unit normals at the vertices of `mesh`, outward.
    pub normals: Vec<proveout_geom::Vector>,
    /// Signed deviation from the design at the vertices of `mesh`, mm; NaN where no design
    /// surface applies; empty when there is no design.
    pub vertex_deviation: Vec<f64>,
    /// Exact points, in the fixed order of the stock.
    pub points: Vec<MapPoint>,
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
