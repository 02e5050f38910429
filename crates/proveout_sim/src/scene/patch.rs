//! Boxes of a scene in which the stock has finer cells.

use std::path::Path;

use proveout_geom::{Aabb, Point};
use proveout_input::InputError;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::scene::ResolutionFile;

/// Longest name of a patch: it becomes part of a file name.
const LONGEST_NAME: usize = 40;

/// A box in which the stock has finer cells: `[[stock.patch]]`.
///
/// In the box, deviations, scallops, gouge and excess findings, the inspection plan, pictures and
/// `surface.parquet` take the surface from the fine cells, outside from those of the stock. Volume,
/// engagement, process, collision and near-miss gates are judged on the stock itself. Choose faces that run
/// through air or through material, not along a face of the part.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchFile {
    /// Name, unique in the scene: letters, digits, `-` and `_`. What is left in the box and round it goes to
    /// `stock-patch-NAME.dexel` of the run folder.
    pub name: String,
    /// Smallest coordinates in the workpiece frame.
    pub min_mm: [f64; 3],
    /// Largest coordinates. Boxes may touch but not overlap; what reaches out of the stock is left out.
    pub max_mm: [f64; 3],
    /// Distance of neighboring rays, mm: one for all, or along x, y and z. No edge may be longer than that of
    /// the stock, and one must be shorter.
    pub cell_mm: ResolutionFile,
}

impl PatchFile {
    /// The box.
    pub fn aabb(&self) -> Aabb {
        Aabb { min: Point::from(self.min_mm), max: Point::from(self.max_mm) }
    }
}

/// Checks what can be seen without the stock: names, boxes, overlaps.
pub(crate) fn check(path: &Path, text: &str, patches: &[Spanned<PatchFile>]) -> Result<(), InputError> {
    for (i, spanned) in patches.iter().enumerate() {
        let (patch, offset) = (spanned.get_ref(), spanned.span().start);
        let fault = |message: String, help: &str| Err(InputError::at(path, text, offset, message, help));
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        let name = &patch.name;
        if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(plain) {
            let help = "use 1 to 40 letters, digits, `-` and `_`: the name becomes part of a file name";
            return fault(format!("{name:?} is not a name of a patch"), help);
        }
        if let Some(k) =
            (0..3).find(|&k| patch.min_mm[k] >= patch.max_mm[k] || (patch.max_mm[k] - patch.min_mm[k]).is_nan())
        {
            let message = format!(
                "patch {name:?}: its box is empty: along {} it goes from {} to {} mm",
                ['x', 'y', 'z'][k],
                patch.min_mm[k],
                patch.max_mm[k]
            );
            return fault(message, "min_mm must be below max_mm along x, y and z");
        }
        for other in patches[..i].iter().map(Spanned::get_ref) {
            if other.name == *name {
                return fault(format!("two patches are named {name:?}"), "give each its own name");
            }
            let shared =
                [0, 1, 2].map(|k| [patch.min_mm[k].max(other.min_mm[k]), patch.max_mm[k].min(other.max_mm[k])]);
            if shared.iter().all(|[low, high]| low < high) {
                let [x, y, z] = shared.map(|[low, high]| format!("{low} to {high}"));
                let message =
                    format!("patch {name:?} overlaps patch {:?}: x {x}, y {y}, z {z} mm are in both", other.name);
                return fault(message, "make one box of them, or move a face: boxes may touch");
            }
        }
    }
    Ok(())
}
