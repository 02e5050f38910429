//! Measurements on the cut part that a scene asks for.

use std::path::Path;

use proveout_input::InputError;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

/// A measurement on the cut part, from a point along one axis direction.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InspectFile {
    /// Name of the feature.
    pub name: String,
    /// What is measured.
    #[serde(default)]
    pub kind: InspectKindFile,
    /// Start of the touch in the workpiece frame, mm.
    #[schemars(with = "[f64; 3]")]
    pub from_mm: Spanned<[f64; 3]>,
    /// `+x`, `-x`, `+y`, `-y`, `+z` or `-z`.
    #[schemars(with = "String")]
    pub direction: Spanned<String>,
    /// Nominal coordinate of the surface along that axis in the workpiece frame, or nominal thickness, mm.
    pub nominal_mm: f64,
    /// Allowed deviation to both sides, mm.
    pub tolerance_mm: f64,
}

/// What a feature of the inspection plan measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum InspectKindFile {
    /// Coordinate of the first material from the start on.
    #[default]
    Touch,
    /// Thickness of the wall that holds the start or comes first after it, as a caliper along the direction
    /// reads it.
    Thickness,
}

/// Directions are those of axes.
///
/// # Errors
/// The first that is none.
pub(crate) fn check(path: &Path, text: &str, all: &[InspectFile]) -> Result<(), InputError> {
    for probe in all {
        if probe_direction(probe.direction.get_ref()).is_none() {
            let at = probe.direction.span().start;
            let message = format!("direction {:?} is not an axis direction", probe.direction.get_ref());
            let help = "write one of \"+x\", \"-x\", \"+y\", \"-y\", \"+z\", \"-z\"";
            return Err(InputError::at(path, text, at, message, help));
        }
    }
    Ok(())
}

/// Axis index and sign of a direction word.
pub fn probe_direction(word: &str) -> Option<(usize, f64)> {
    let axis = match word.get(1..)? {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        _ => return None,
    };
    match word.as_bytes()[0] {
        b'+' => Some((axis, 1.0)),
        b'-' => Some((axis, -1.0)),
        _ => None,
    }
}
