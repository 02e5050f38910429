//! Tool libraries of other programs, read into [`ToolDraft`]s.
//!
//! | file | recognized by | unit |
//! |---|---|---|
//! | Fusion 360 library | JSON with a list `data` | each tool and each holder has its own |
//! | CAMotics project or tool table | JSON with a table `tools` | of the tool, else of the project |
//! | LinuxCNC tool table | ending `.tbl` | that of the machine: the call states it |
//! | Haas or Fanuc offset program (G10 L10, L12) | `G10` in the text | G20 or G21, else the call states it |
//! | CSV | ending `.csv` | in the name of each column |
//! | ISO 13399 | ending `.p21`, schema `CUTTING_TOOL_SCHEMA_ARM` | of each value |
//! | DIN 4000, hyperMILL, SolidCAM | ending `.xml`, by its root element | millimeters; of each tool |
//!
//! Nothing is filled in here: what a file does not give is missing in the draft. What a file gives and a
//! library cannot store is in [`Imported::notes`]. Two tools with the same number are refused, unless they
//! are the same tool.

mod camotics;
mod catalog;
mod catalog_xml;
mod fusion;
mod iso13399;
mod linuxcnc_table;
mod offsets_program;
mod spreadsheet;
pub(crate) mod words;

use std::collections::BTreeSet;
use std::path::Path;

use proveout_input::{InputError, open_regular_file, read_input};

use crate::draft::ToolDraft;

/// Largest library that is read, bytes: tens of thousands of tools.
const MAX_BYTES: u64 = 256 << 20;
/// Millimeters of an inch.
pub(crate) const INCH_MM: f64 = 25.4;

/// Unit of length for a file that does not state one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimeters.
    Millimeter,
    /// Inches.
    Inch,
}

impl LengthUnit {
    /// Millimeters of one unit.
    pub fn mm(self) -> f64 {
        match self {
            Self::Millimeter => 1.0,
            Self::Inch => INCH_MM,
        }
    }

    /// The unit of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        match name.trim().to_ascii_lowercase().as_str() {
            "mm" | "millimeter" | "millimeters" | "metric" => Some(Self::Millimeter),
            "inch" | "inches" | "in" | "imperial" => Some(Self::Inch),
            _ => None,
        }
    }
}

/// Tools of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// What kind of file it is.
    pub format: &'static str,
    /// The tools, in the order of the file.
    pub tools: Vec<ToolDraft>,
    /// What the file gives and the drafts cannot store.
    pub notes: Vec<String>,
}

/// What a call says about a file.
#[derive(Clone, Debug, Default)]
pub struct ImportCall {
    /// Unit of length, where the file does not state it.
    pub unit: Option<LengthUnit>,
    /// Numbers of the tools that are wanted; all where none.
    pub wanted: Option<BTreeSet<u32>>,
}

impl ImportCall {
    pub(crate) fn selects(&self, number: u32) -> bool {
        self.wanted.as_ref().is_none_or(|all| all.contains(&number))
    }

    /// The unit of a file whose format cannot state one.
    pub(crate) fn stated_unit(&self, file: &Path, what: &str) -> Result<f64, InputError> {
        self.unit.map(LengthUnit::mm).ok_or_else(|| {
            InputError::file(
                file,
                format!("{what} does not state its unit of length"),
                "state it: --unit mm or --unit inch",
            )
        })
    }
}

/// Reads the tools of another program's file.
///
/// # Errors
/// [`InputError`] with the file, and the line where the format has lines: a file of no known kind, a value
/// that is not a dimension, a unit that is not stated, two tools of one number.
pub fn import_tools(file: &Path, call: &ImportCall) -> Result<Imported, InputError> {
    let ending = file.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let imported = match ending.as_str() {
        "tbl" => linuxcnc_table::read(file, &read_input(file)?, call)?,
        "csv" => spreadsheet::read(file, &read_input(file)?, call)?,
        "json" | "camotics" | "ctbl" => json(file, call)?,
        "xml" => catalog_xml::read(file, call)?,
        "p21" => {
            let text = read_input(file)?;
            if !iso13399::is_iso13399(&text) {
                let message = "it is no ISO 13399 file (schema CUTTING_TOOL_SCHEMA_ARM)";
                return Err(InputError::file(file, message, "give the property file of the tool, not its solid"));
            }
            iso13399::read(file, &text, call)?
        }
        "zip" => {
            let message = "a GTC package is not read as it is";
            return Err(InputError::file(file, message, "unpack it, and give a .p21 file of its product_data_files"));
        }
        "tools" | "hsmlib" => {
            let message = "a packed library is not read".to_owned();
            return Err(InputError::file(file, message, "export it from Fusion as JSON (.json)"));
        }
        _ => {
            let text = read_input(file)?;
            if !offsets_program::is_offsets_program(&text) {
                let message = "the file is not a tool library of a known format".to_owned();
                let known = "give a Fusion 360 library (.json), a LinuxCNC tool table (.tbl), offsets as a program (G10 L10), a CAMotics \
                             project, a table (.csv), an ISO 13399 file (.p21), DIN 4000, hyperMILL or SolidCAM (.xml), or a library of this program (.toml)";
                return Err(InputError::file(file, message, known));
            }
            offsets_program::read(file, &text, call)?
        }
    };
    unique(file, imported)
}

/// A JSON file; its keys decide which of the two formats it is.
fn json(file: &Path, call: &ImportCall) -> Result<Imported, InputError> {
    let refused = |e: &dyn std::fmt::Display| {
        InputError::file(
            file,
            format!("the file cannot be read: {e}"),
            "check the path, and that the file is a tool library",
        )
    };
    let open = || open_regular_file(file).map_err(|e| refused(&e));
    let length = open()?.metadata().map_err(|e| refused(&e))?.len();
    if length > MAX_BYTES {
        return Err(refused(&format!("it has {length} bytes; the limit is {MAX_BYTES}")));
    }
    let reader = std::io::BufReader::new(open()?);
    // A list of one kind or the other; members that neither has are passed over and not held.
    let either: Either = serde_json::from_reader(reader).map_err(|e| {
        InputError::file(file, format!("the text is not the JSON of a tool library: {e}"), "export the library again")
            .with_line(e.line())
    })?;
    match (either.data, either.tools) {
        (Some(data), _) => fusion::drafts(file, data, call),
        (None, Some(tools)) => camotics::drafts(file, tools, either.units.as_deref(), call),
        (None, None) => {
            let message = "the JSON has neither `data` (Fusion 360) nor `tools` (CAMotics)";
            Err(InputError::file(file, message, "export the tool library as JSON"))
        }
    }
}

#[derive(serde::Deserialize)]
struct Either {
    data: Option<Vec<fusion::FusionTool>>,
    tools: Option<std::collections::BTreeMap<String, camotics::CamoticsTool>>,
    units: Option<String>,
}

/// Refuses two tools of one number; the same tool given twice counts once.
fn unique(file: &Path, mut imported: Imported) -> Result<Imported, InputError> {
    let mut kept: Vec<ToolDraft> = Vec::new();
    for tool in std::mem::take(&mut imported.tools) {
        let Some(first) = kept.iter().find(|t| t.number == tool.number) else {
            kept.push(tool);
            continue;
        };
        let same = ToolDraft {
            name: first.name.clone(),
            description: first.description.clone(),
            source: first.source.clone(),
            ..tool.clone()
        };
        if same != *first {
            let message =
                format!("two tools have the number {}: \"{}\" and \"{}\"", tool.number, first.name, tool.name);
            return Err(InputError::file(
                file,
                message,
                "give each tool its own number, or name a file with the tools of this program alone",
            ));
        }
        imported.notes.push(format!(
            "T{}: \"{}\" is given twice with the same dimensions and is kept once",
            tool.number, tool.name
        ));
    }
    for (at, name) in twice(&kept) {
        // Programs that call tools by name would be ambiguous; the number makes the names differ.
        kept[at].name = format!("{name} (T{})", kept[at].number);
        imported.notes.push(format!(
            "T{}: another tool has the name \"{name}\" as well: this one is \"{}\"",
            kept[at].number, kept[at].name
        ));
    }
    imported.tools = kept;
    Ok(imported)
}

/// Tools whose name an earlier one has.
fn twice(tools: &[ToolDraft]) -> Vec<(usize, String)> {
    let mut seen = BTreeSet::new();
    let late = |(at, tool): (usize, &ToolDraft)| (!seen.insert(tool.name.clone())).then(|| (at, tool.name.clone()));
    tools.iter().enumerate().filter_map(late).collect()
}

#[cfg(test)]
mod tests;
