//! CAMotics: a project (`.camotics`) or a tool table, JSON with a table `tools` by number.

use std::collections::BTreeMap;
use std::path::Path;

use proveout_input::InputError;
use serde::Deserialize;

use super::words::{SubstituteBody, center_cutting_of, kind_of};
use super::{ImportCall, Imported, LengthUnit};
use crate::draft::ToolDraft;

/// Part of its diameter by which the cutting length of a ball may differ from it: rounding of inches.
const SAME_LENGTH: f64 = 1e-6;

/// A tool as written in the file.
#[derive(Debug, Deserialize)]
pub(super) struct CamoticsTool {
    units: Option<String>,
    shape: Option<String>,
    length: Option<f64>,
    diameter: Option<f64>,
    #[serde(rename = "snub_diameter")]
    snub: Option<f64>,
    description: Option<String>,
}

pub(super) fn drafts(
    file: &Path,
    tools: BTreeMap<String, CamoticsTool>,
    units: Option<&str>,
    call: &ImportCall,
) -> Result<Imported, InputError> {
    let mut imported = Imported { format: "CAMotics project", ..Imported::default() };
    for (number, entry) in tools {
        let refused = |message: String, help: &str| InputError::file(file, format!("tool {number}: {message}"), help);
        let n: u32 = number
            .trim()
            .parse()
            .map_err(|_no_number| refused("its key is not a number".into(), "number the tools"))?;
        if !call.selects(n) {
            continue;
        }
        let unit = match entry.units.as_deref().or(units) {
            Some(word) => LengthUnit::from_name(word)
                .ok_or_else(|| refused(format!("units {word:?} are not known"), "write METRIC or IMPERIAL"))?
                .mm(),
            None => call.stated_unit(file, "the file")?,
        };
        let length = |what: &str, value: Option<f64>| match value {
            Some(v) if v > 0.0 && v.is_finite() => Ok(v * unit),
            _ => {
                Err(refused(format!("{what} is missing or not above zero"), "give the tool its dimensions in CAMotics"))
            }
        };
        let diameter = length("diameter", entry.diameter)?;
        let cut = length("length", entry.length)?;
        let mut draft = ToolDraft::new(n, format!("CAMotics, {}", file.display()));
        let words = entry.description.unwrap_or_default();
        if !words.trim().is_empty() {
            draft.description = words.trim().to_owned();
        }
        draft.flute_length = Some(cut);
        draft.put("diameter_mm", diameter);
        let shape = entry.shape.unwrap_or_else(|| "Cylindrical".into()).to_ascii_lowercase();
        match shape.as_str() {
            "cylindrical" => match kind_of(&words) {
                Some(("tap", why)) => draft.become_tap(&words, None, why.map_or("", SubstituteBody::reason)),
                _ => {
                    draft.kind = Some("flat");
                    draft.center_cutting = center_cutting_of(&words);
                }
            },
            "ballnose" => draft.kind = Some("ball"),
            // Its length is the height of the cone.
            "conical" | "snubnose" => {
                let tip = if shape == "conical" { 0.0 } else { entry.snub.map_or(0.0, |s| s * unit) };
                draft.kind = Some("chamfer");
                draft.put("point_angle_deg", 2.0 * (0.5 * (diameter - tip)).atan2(cut).to_degrees());
                draft.put("tip_diameter_mm", tip);
            }
            "spheroid" if (cut - diameter).abs() <= SAME_LENGTH * diameter => draft.kind = Some("ball"),
            other => {
                let message = format!("shape {other:?} is not one of the library's");
                return Err(refused(message, "use Cylindrical, Ballnose, Conical or Snubnose"));
            }
        }
        imported.tools.push(draft);
    }
    imported.tools.sort_by_key(|t| t.number);
    Ok(imported)
}
