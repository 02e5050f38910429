//! A table of tools, CSV: a column a key of the library, with its unit in its name.
//!
//! `number` is needed, all else may be left out or empty: `name`, `description`, `kind`, the keys of the kind
//! (`diameter_mm`, `corner_radius_mm`, `point_angle_deg`, ...), `flute_length_mm`, `neck_diameter_mm`,
//! `neck_length_mm`, `shank_diameter_mm`, `overall_length_mm`, `stick_out_mm`, `gauge_length_mm`, `flutes`,
//! `center_cutting` (yes or no), `hand`, `holder_name`, `holder_diameter_mm`, `holder_length_mm`. Every
//! length may be given in inches instead: `diameter_inch`.

use std::path::Path;

use proveout_input::{InputError, nearest};

use super::words::center_cutting_of;
use super::{INCH_MM, ImportCall, Imported};
use crate::HolderSection;
use crate::draft::ToolDraft;
use crate::entry::{KIND_WORDS, SHAPE_KEYS};

/// Columns in addition to the keys of the shape.
const OTHERS: [&str; 17] = [
    "number",
    "name",
    "description",
    "kind",
    "flute_length_mm",
    "neck_diameter_mm",
    "neck_length_mm",
    "shank_diameter_mm",
    "overall_length_mm",
    "stick_out_mm",
    "gauge_length_mm",
    "flutes",
    "center_cutting",
    "hand",
    "holder_name",
    "holder_diameter_mm",
    "holder_length_mm",
];

pub(super) fn read(file: &Path, text: &str, call: &ImportCall) -> Result<Imported, InputError> {
    let separator = text.lines().next().filter(|l| l.contains(';') && !l.contains(',')).map_or(b',', |_| b';');
    let comma = separator == b';';
    let mut reader = csv::ReaderBuilder::new().delimiter(separator).trim(csv::Trim::All).from_reader(text.as_bytes());
    let wrong = |e: &csv::Error| {
        let line = e.position().map_or(1, |p| p.line() as usize);
        InputError::file(file, format!("the text is not CSV: {e}"), "write one row a tool, as many cells as columns")
            .with_line(line)
    };
    let header = reader.headers().map_err(|e| wrong(&e))?.clone();
    let mut columns = Vec::new();
    for name in &header {
        let (key, factor) = match name.strip_suffix("_inch") {
            Some(stem) => (format!("{stem}_mm"), INCH_MM),
            None => (name.to_owned(), 1.0),
        };
        let known = || SHAPE_KEYS.iter().chain(&OTHERS).copied().filter(|k| *k != "segments");
        let Some(key) = known().find(|k| *k == key) else {
            let help = nearest(name, known()).map_or_else(
                || "docs/first-part.md lists the columns".to_owned(),
                |near| format!("did you mean `{near}`? docs/first-part.md lists the columns"),
            );
            return Err(InputError::file(file, format!("column `{name}` is not known"), help).with_line(1));
        };
        if columns.iter().any(|(k, _)| *k == key) {
            return Err(
                InputError::file(file, format!("column `{key}` appears twice"), "keep one of them").with_line(1)
            );
        }
        columns.push((key, factor));
    }
    if !columns.iter().any(|(k, _)| *k == "number") {
        return Err(InputError::file(
            file,
            "there is no column `number`",
            "write the tool numbers of the program into it",
        )
        .with_line(1));
    }
    let mut imported = Imported { format: "CSV", ..Imported::default() };
    for row in reader.records() {
        let row = row.map_err(|e| wrong(&e))?;
        let line = row.position().map_or(0, |p| p.line() as usize);
        let refused = |key: &str, value: &str, want: &str| {
            InputError::file(file, format!("`{key}` = {value:?} is not {want}"), "correct the cell, or leave it empty")
                .with_line(line)
        };
        let cell = |key: &str| {
            let at = columns.iter().position(|(k, _)| *k == key)?;
            Some((row.get(at)?, columns[at].1)).filter(|(text, _)| !text.is_empty())
        };
        let length = |key: &str| match cell(key) {
            None => Ok(None),
            // Spreadsheets that write decimal commas separate cells by semicolons.
            Some((text, factor)) => {
                match if comma { text.replacen(',', ".", 1) } else { text.to_owned() }.parse::<f64>() {
                    Ok(v) if v.is_finite() && v >= 0.0 => Ok(Some(v * factor)),
                    _ => Err(refused(key, text, "a number, zero or above")),
                }
            }
        };
        let whole = |key: &str| match cell(key) {
            None => Ok(None),
            Some((text, _)) => text.parse::<u32>().map(Some).map_err(|_no_number| refused(key, text, "a whole number")),
        };
        let Some(number) = whole("number")? else { return Err(refused("number", "", "a whole number")) };
        if !call.selects(number) {
            continue;
        }
        let text = |key: &str| cell(key).map(|(text, _)| text.to_owned());
        let mut draft = ToolDraft::new(number, format!("table {}:{line}", file.display()));
        draft.name = text("name").unwrap_or(draft.name);
        draft.description = text("description").unwrap_or_default();
        if let Some((kind, _)) = cell("kind") {
            let known = KIND_WORDS.iter().find(|k| **k == kind && **k != "profile");
            draft.kind = Some(
                *known.ok_or_else(|| refused("kind", kind, "a kind of cutter (ball, flat, bull_nose, drill, ...)"))?,
            );
        }
        for key in SHAPE_KEYS.iter().filter(|k| **k != "segments") {
            if let Some(value) = length(key)? {
                draft.shape.push((key, value));
            }
        }
        draft.flute_length = length("flute_length_mm")?;
        draft.neck = length("neck_diameter_mm")?.zip(length("neck_length_mm")?);
        draft.shank = length("shank_diameter_mm")?;
        draft.overall = length("overall_length_mm")?;
        draft.stick_out = length("stick_out_mm")?;
        draft.gauge = length("gauge_length_mm")?;
        draft.flutes = whole("flutes")?;
        draft.center_cutting = match cell("center_cutting").map(|(c, _)| c) {
            None => center_cutting_of(&draft.description)
                .filter(|_| matches!(draft.kind, None | Some("flat" | "bull_nose"))),
            Some("true" | "yes") => Some(true),
            Some("false" | "no") => Some(false),
            Some(other) => return Err(refused("center_cutting", other, "yes or no")),
        };
        draft.left_handed = match cell("hand").map(|(h, _)| h) {
            None | Some("right") => false,
            Some("left") => true,
            Some(other) => return Err(refused("hand", other, "right or left")),
        };
        if let (Some(diameter), Some(length)) = (length("holder_diameter_mm")?, length("holder_length_mm")?) {
            draft.holder = vec![HolderSection { diameter, top_diameter: diameter, length }];
            draft.holder_name = text("holder_name").unwrap_or_else(|| "of the table".into());
        }
        imported.tools.push(draft);
    }
    Ok(imported)
}
