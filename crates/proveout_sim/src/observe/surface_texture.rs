//! The texture of the cut surface, as observers get it.

use proveout_geom::{Point, Vector};

/// The texture of a place, as observers see it.
#[derive(Clone, Debug)]
pub struct SurfaceTexture {
    /// Name in the scene.
    pub name: String,
    /// The map; none for a profile of its own.
    pub map: Option<TextureMap>,
    /// Profiles.
    pub profiles: Vec<TextureProfile>,
}

/// Heights over a patch, workpiece frame, mm.
#[derive(Clone, Debug)]
pub struct TextureMap {
    /// Nodes along the columns.
    pub columns: usize,
    /// Rows of nodes.
    pub rows: usize,
    /// Distance of the nodes along columns and rows.
    pub step_mm: [f64; 2],
    /// Nodes on the design, columns running fastest.
    pub points: Vec<Point>,
    /// Outward normals of the design.
    pub normals: Vec<Vector>,
    /// Heights above the design along its normals; not a number where nothing cuts.
    pub heights: Vec<f64>,
    /// Who made each node.
    pub makers: Vec<Option<Maker>>,
    /// Direction of the lay, degrees from the columns towards the rows; none on a flat.
    pub lay_deg: Option<f64>,
}

/// What made a node of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maker {
    /// Index of the block.
    pub block: u32,
    /// Index of the tool in the library.
    pub tool: u32,
    /// Number of the tooth from 0; none for an envelope.
    pub tooth: Option<u32>,
}

/// Heights along a line on the design, mm.
#[derive(Clone, Debug)]
pub struct TextureProfile {
    /// Direction, in words.
    pub direction: &'static str,
    /// Distance of the points.
    pub step_mm: f64,
    /// Heights; not a number where nothing cuts.
    pub heights: Vec<f64>,
    /// Roughness profile over the evaluation length in the middle; empty where it could not be evaluated.
    pub roughness: Vec<f64>,
    /// Ra and Rz, µm, likewise.
    pub ra_rz_um: Option<[f64; 2]>,
    /// Setting class.
    pub class: String,
}
