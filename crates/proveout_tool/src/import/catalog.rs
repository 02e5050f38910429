//! Tools of catalogs: named values without a place in a tool table.
//!
//! | file | recognized by | values |
//! |---|---|---|
//! | ISO 13399 file (`.p21`) | schema `CUTTING_TOOL_SCHEMA_ARM` | codes `DC`, `OAL`, with their unit |
//! | DIN 4000 (`.xml`) | element `Tool-Data` | `A1`, `C3` of class DIN4000-82, mm, decimal comma |
//! | hyperMILL (`.xml`) | element `omtdx` | `toolDiameter`, unit in `lengthOfUnit` |
//! | SolidCAM (`.xml`) | element `Results` | `diameter`, unit in `unit` |
//!
//! Such files have no tool numbers: tools are numbered in the order of the file, with a note. The kind comes
//! from the words of type and name; a corner radius makes a ball or a bull nose of an end mill. A value that
//! is given twice in two sizes is refused by name, since the file does not say which one is meant.

use std::path::Path;

use proveout_input::InputError;

use super::words::{center_cutting_of, kind_of};
use super::{ImportCall, Imported};
use crate::draft::ToolDraft;

/// Lengths that differ by less are one, as a part of the larger one.
const SAME: f64 = 1e-6;
/// Half of the diameter is a ball, within this part of it: catalogs round inches to micrometers.
const HALF: f64 = 1e-3;

/// Which names of a format mean what; the first one that is given counts.
pub(super) struct CatalogKeys {
    pub(super) format: &'static str,
    pub(super) diameter: &'static [&'static str],
    pub(super) corner_radius: &'static [&'static str],
    pub(super) flute_length: &'static [&'static str],
    pub(super) shank: &'static [&'static str],
    pub(super) overall: &'static [&'static str],
    pub(super) stick_out: &'static [&'static str],
    pub(super) point_angle: &'static [&'static str],
    pub(super) teeth: &'static [&'static str],
}

/// A tool of a catalog, as written.
#[derive(Clone, Debug, Default)]
pub(super) struct CatalogTool {
    /// Words about it: its name first.
    pub(super) words: Vec<String>,
    /// What the format calls its type, in words.
    pub(super) kind: String,
    /// Names with their values and the millimeters of their unit.
    pub(super) values: Vec<(String, String, f64)>,
    /// It cuts when the spindle turns counter-clockwise.
    pub(super) left_handed: bool,
}

impl CatalogTool {
    /// A value by the first of its names that is given.
    fn value(&self, names: &[&str], scaled: bool) -> Result<Option<f64>, String> {
        for name in names {
            let mut found: Option<(f64, &str)> = None;
            for (_, text, unit) in self.values.iter().filter(|(known, ..)| known == name) {
                let number =
                    number(text).ok_or_else(|| format!("`{name}` = {text:?} is not a number, zero or above"))?;
                let value = if scaled { number * unit } else { number };
                if let Some((other, written)) = found
                    && (other - value).abs() > SAME * other.max(value)
                {
                    return Err(format!("`{name}` has two values: {written} and {text}"));
                }
                found = Some((value, text));
            }
            // Zero says that it has none.
            if let Some((value, _)) = found.filter(|(value, _)| *value > 0.0) {
                return Ok(Some(value));
            }
        }
        Ok(None)
    }

    fn draft(&self, number: u32, file: &Path, keys: &CatalogKeys) -> Result<ToolDraft, String> {
        let length = |names: &[&str]| self.value(names, true);
        let mut draft = ToolDraft::new(number, format!("{}, {}", keys.format, file.display()));
        let name = self.words.iter().map(|w| w.trim()).find(|w| !w.is_empty());
        if let Some(name) = name {
            name.clone_into(&mut draft.name);
        }
        draft.description = self.words.join(", ");
        let diameter =
            length(keys.diameter)?.ok_or_else(|| format!("`{}` is not given", keys.diameter.join("`, `")))?;
        draft.put("diameter_mm", diameter);
        let named = kind_of(&self.kind).or_else(|| kind_of(&draft.description));
        draft.kind = named.map(|(kind, _)| kind);
        if let Some((_, Some(body))) = named {
            draft.stand_in(body);
        }
        let radius = length(keys.corner_radius)?;
        match (draft.kind, radius) {
            (None | Some("flat" | "bull_nose"), Some(r)) if (2.0 * r - diameter).abs() <= HALF * diameter => {
                draft.kind = Some("ball");
            }
            (None | Some("flat" | "bull_nose"), Some(r)) if 2.0 * r < diameter => {
                draft.kind = Some("bull_nose");
                draft.put("corner_radius_mm", r);
            }
            (None | Some("flat" | "bull_nose"), Some(r)) => {
                return Err(format!("its corner radius of {r} mm is above half of its diameter of {diameter} mm"));
            }
            (Some("bull_nose"), None) if keys.corner_radius.is_empty() => {
                return Err(format!("it has a corner radius, and a {} states none", keys.format));
            }
            (Some("bull_nose"), None) => return Err(format!("`{}` is not given", keys.corner_radius.join("`, `"))),
            _ => {}
        }
        if let (Some("drill" | "chamfer"), Some(angle)) = (draft.kind, self.value(keys.point_angle, false)?) {
            draft.put("point_angle_deg", angle);
        }
        draft.flute_length = length(keys.flute_length)?;
        draft.shank = length(keys.shank)?;
        draft.overall = length(keys.overall)?;
        draft.stick_out = length(keys.stick_out)?;
        draft.flutes = match self.value(keys.teeth, false)? {
            Some(n) if n.fract() == 0.0 && n <= 200.0 => Some(n as u32),
            Some(n) => return Err(format!("`{}` = {n} is no number of teeth", keys.teeth.join("`, `"))),
            None => None,
        };
        draft.center_cutting = center_cutting_of(&draft.description).filter(|_| draft.kind != Some("ball"));
        draft.left_handed = self.left_handed;
        Ok(draft)
    }
}

/// A number with a decimal point or a decimal comma, zero or above.
fn number(text: &str) -> Option<f64> {
    let number: f64 = text.trim().replacen(',', ".", 1).parse().ok()?;
    (number.is_finite() && number >= 0.0).then_some(number)
}

/// Tools of a catalog as drafts, numbered in their order.
pub(super) fn drafts(
    file: &Path,
    tools: &[CatalogTool],
    keys: &CatalogKeys,
    call: &ImportCall,
) -> Result<Imported, InputError> {
    let mut imported = Imported { format: keys.format, ..Imported::default() };
    for (number, tool) in (1..).zip(tools).filter(|(number, _)| call.selects(*number)) {
        let draft = tool.draft(number, file, keys).map_err(|message| {
            let name = tool.words.first().map_or("", String::as_str);
            let help = "correct the file, or leave the tool out with --number";
            InputError::file(file, format!("tool {number} of the file ({name:?}): {message}"), help)
        })?;
        imported.tools.push(draft);
    }
    if tools.is_empty() {
        return Err(InputError::file(file, format!("the {} has no tool", keys.format), "export the library again"));
    }
    imported
        .notes
        .push(format!("a {} has no tool numbers: its tools are numbered from 1 in the order of the file", keys.format));
    Ok(imported)
}
