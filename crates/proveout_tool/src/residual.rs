//! What a tool leaves on a surface in addition to the marks of its motion.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::cutter::{ShapeError, refuse};

/// Largest residual that is believed, µm.
const LARGEST_UM: f64 = 1000.0;

/// What vibration, ploughing and tear add to the roughness of the motion alone, in the material that the tool
/// is meant for.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Least and most that it adds to Ra, µm.
    pub ra_um: [f64; 2],
    /// Least and most that it adds to Rz, µm.
    pub rz_um: [f64; 2],
    /// Where the numbers come from.
    pub source: String,
}

/// What vibration, ploughing and tear add to the roughness that the motion alone leaves; nothing when left
/// out, and said to be.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ResidualEntry {
    /// Least and most that it adds to Ra, micrometer.
    pub(crate) ra_um: [f64; 2],
    /// Least and most that it adds to Rz, micrometer.
    pub(crate) rz_um: [f64; 2],
    /// Where the numbers come from.
    pub(crate) source: String,
}

pub(crate) fn residual_of(e: &ResidualEntry) -> Result<Residual, ShapeError> {
    for (key, [low, high]) in [("ra_um", e.ra_um), ("rz_um", e.rz_um)] {
        if !(0.0 <= low && low <= high && high <= LARGEST_UM) {
            let limit = format!("must be two heights, 0 to {LARGEST_UM} um, the smaller one first");
            return refuse(key, if low >= 0.0 { high } else { low }, limit);
        }
    }
    if e.source.trim().is_empty() {
        return refuse("source", f64::NAN, "is missing: a residual needs the place that its numbers come from");
    }
    Ok(Residual { ra_um: e.ra_um, rz_um: e.rz_um, source: e.source.clone() })
}
