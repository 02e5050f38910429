//! What the verdict says of the scallop.

use proveout_surface::scallop::Heights;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::units::UM_PER_MM;

/// The ridges between the passes; means and percentiles are weighted by the length of the ridges, heights
/// count from the design.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Scallop {
    /// How far a height may be off at most: the design's own error, and deviation of the pieces of motion
    /// from the path, µm.
    pub bound_um: f64,
    /// How far the mean may be off, µm.
    pub mean_bound_um: f64,
    /// How far the 95th percentile may be off, µm.
    pub p95_bound_um: f64,
    /// All ridges.
    pub all: ScallopHeights,
    /// Mean of what the geometry of cutter, lean, step and design gives, over ridges with a valley on both
    /// sides, µm.
    pub geometric_mean_um: Option<f64>,
    /// Mean of measured less geometric height, µm.
    pub difference_mean_um: Option<f64>,
    /// 95th percentile of the magnitude of that difference, µm.
    pub difference_p95_um: Option<f64>,
    /// Mean distance of the passes along the design, mm.
    pub spacing_mean_mm: Option<f64>,
    /// Largest distance of the passes along the design, mm.
    pub spacing_max_mm: Option<f64>,
    /// Smallest width of the strip that the standing cutter cuts up to the tolerance above the design, along
    /// it, mm.
    pub strip_width_min_mm: Option<f64>,
    /// Smallest width of the strip that the moving cutter cuts up to the tolerance above the design, along
    /// it, mm.
    pub swept_width_min_mm: Option<f64>,
    /// Ridges by the bounds that the scene sets, where it sets some for regions.
    pub regions: Vec<ScallopRegion>,
    /// Length of the ridges by height.
    pub histogram: Vec<ScallopBar>,
    /// Cubes of 4 mm, the worst first, at most twenty.
    pub patches: Vec<ScallopPatch>,
    /// Passes in the order in which they were cut; the worst fifty where there are more.
    pub passes: Vec<ScallopPass>,
    /// How many patches and passes there are.
    pub patch_count: u64,
    /// See `patch_count`.
    pub pass_count: u64,
}

/// Heights of some ridges, µm.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScallopHeights {
    /// Places at which ridges were measured.
    pub places: u64,
    /// Length of the ridges, mm.
    pub length_mm: f64,
    /// Mean.
    pub mean_um: f64,
    /// 95th percentile.
    pub p95_um: f64,
    /// Largest.
    pub max_um: f64,
}

impl From<&Heights> for ScallopHeights {
    fn from(h: &Heights) -> Self {
        let [mean_um, p95_um, max_um] = [h.mean, h.p95, h.max].map(|v| UM_PER_MM * v);
        Self { places: h.places, length_mm: h.length, mean_um, p95_um, max_um }
    }
}

/// Ridges with one bound.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScallopRegion {
    /// Name of the region; none outside of all regions.
    pub name: Option<String>,
    /// Allowed 95th percentile, µm.
    pub limit_um: f64,
    /// Its ridges; none where none was found.
    pub heights: Option<ScallopHeights>,
}

/// A bar of the histogram.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScallopBar {
    /// Heights from here, µm.
    pub from_um: f64,
    /// To here, µm.
    pub to_um: f64,
    /// Length of the ridges, mm.
    pub length_mm: f64,
}

/// Ridges in a cube.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScallopPatch {
    /// Its middle, workpiece frame, mm.
    pub middle_mm: [f64; 3],
    /// Its highest ridge, mm.
    pub highest_mm: [f64; 3],
    /// File and line of the blocks on both sides of the highest ridge.
    pub blocks: Vec<String>,
    /// Its ridges.
    pub heights: ScallopHeights,
}

/// Ridges that a pass leaves against the ones before.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScallopPass {
    /// File and line of the block with which it begins.
    pub begins: String,
    /// Its ridges.
    pub heights: ScallopHeights,
}
