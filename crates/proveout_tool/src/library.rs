//! Tool libraries and their files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use proveout_input::{Document, InputError, Step, Step::Item, Step::Key, in_millimeters, nearest, read_input};

use crate::cutter::ShapeError;
use crate::entry::tool_of;
use crate::library_file::{CutterKind, GaugeLengthSource, LibraryFile};
use crate::{Tool, ToolId};

/// Tables of a tool that contain its keys, in addition to its own table.
const TABLES: [&[Step<'_>]; 4] =
    [&[Key("holder")], &[Key("edges")], &[Key("residual")], &[Key("edges"), Key("round_insert")]];

/// The key of a tool's length.
const GAUGE_LENGTH: &str = "gauge_length_mm";

/// Where the numbers of a tool come from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolNotes {
    /// Catalogue reference.
    pub source: String,
    /// Keys whose values come from no catalogue, and why they have these values.
    pub chosen: Vec<(Vec<String>, String)>,
    /// Name of the holder.
    pub holder: String,
    /// The file has the tool clamped to its gauge length (`gauge_length_source = "prescribed"`).
    pub length_prescribed: bool,
}

/// The tools of a scene, in the order of their file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolLibrary {
    /// The assemblies.
    pub tools: Vec<Tool>,
    /// Origin of the numbers, one entry a tool.
    pub notes: Vec<ToolNotes>,
    /// What the library is for.
    pub description: String,
    /// The file it was read from, empty when made in code.
    pub file: PathBuf,
}

impl ToolLibrary {
    /// Reads a library file (TOML; one `[[tool]]` a tool, see [`crate::library_schema`]).
    ///
    /// # Errors
    /// The first defect with file, line, column, key, value and remedy; nothing is filled in silently.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::from_text(path, &read_input(path)?)
    }

    /// The same from a text; errors show `name`.
    ///
    /// ```
    /// use proveout_tool::{ToolId, ToolLibrary};
    ///
    /// let text = r#"
    /// [[tool]]
    /// number = 5
    /// name = "BALL_D8"
    /// kind = "ball"
    /// diameter_mm = 8
    /// flute_length_mm = 20
    /// gauge_length_mm = 110
    /// "#;
    /// let library = ToolLibrary::from_text("tools.toml".as_ref(), text)?;
    /// let tool = library.find(&ToolId::Number(5)).expect("the text has it");
    /// assert_eq!(tool.max_radius(), 4.0); // mm
    /// assert_eq!(library.nearest_name("BALL_D6"), Some("BALL_D8"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn from_text(name: &Path, text: &str) -> Result<Self, InputError> {
        let text = in_millimeters(name, text)?;
        let document = Document::new(name, &text);
        let file: LibraryFile = document.read()?;
        let mut library = Self { file: name.to_owned(), description: file.description, ..Self::default() };
        let mut numbers = BTreeMap::new();
        let mut names = BTreeMap::new();
        for (index, entry) in file.tool.iter().enumerate() {
            let refused = |key: &str, message: String, remedy: &str| {
                document.error_with_value("", &place_of(&document, index, key), message, remedy)
            };
            if let Some(first) = numbers.insert(entry.number, index) {
                let other: &Tool = &library.tools[first];
                let message = format!("is the number of tool \"{}\" as well", other.name);
                return Err(refused("number", message, "give each tool its own number"));
            }
            if entry.name.is_empty() || entry.name.trim() != entry.name {
                let message = "is empty or has blanks at an end".to_owned();
                return Err(refused("name", message, "write the name as the program does"));
            }
            if names.insert(entry.name.clone(), index).is_some() {
                return Err(refused("name", "is used twice".into(), "give each tool its own name"));
            }
            for chosen in &entry.chosen {
                if let Some(stray) = chosen.keys.iter().find(|k| !document.has(&place_of(&document, index, k))) {
                    let message = format!("names `{stray}`, which this tool does not have");
                    return Err(refused("chosen", message, "name keys that are written above"));
                }
            }
            match tool_of(entry) {
                Ok(tool) => library.tools.push(tool),
                Err(ShapeError::Dimension { key, limit, .. }) => {
                    return Err(refused(key, limit, "correct the dimension"));
                }
                Err(ShapeError::Profile(e)) => {
                    let key = if entry.kind == CutterKind::Profile { "segments" } else { "kind" };
                    return Err(refused(key, format!("gives no cutter: {e}"), "correct the curve"));
                }
            }
            let measured = entry.gauge_length_source == Some(GaugeLengthSource::Measured);
            let still = |key: &&String| !(measured && *key == GAUGE_LENGTH);
            library.notes.push(ToolNotes {
                source: entry.source.clone(),
                chosen: entry
                    .chosen
                    .iter()
                    .map(|c| (c.keys.iter().filter(still).cloned().collect::<Vec<_>>(), c.reason.clone()))
                    .filter(|(keys, _)| !keys.is_empty())
                    .collect(),
                holder: entry.holder.as_ref().map(|h| h.name.clone()).unwrap_or_default(),
                length_prescribed: entry.gauge_length_source == Some(GaugeLengthSource::Prescribed),
            });
        }
        Ok(library)
    }

    /// Whether the length of a tool was assumed, neither measured nor prescribed.
    pub fn is_length_assumed(&self, index: usize) -> bool {
        let chosen = |notes: &ToolNotes| notes.chosen.iter().any(|(keys, _)| keys.iter().any(|k| k == GAUGE_LENGTH));
        self.notes.get(index).is_some_and(|notes| chosen(notes) && !notes.length_prescribed)
    }

    /// Whether the file has a tool clamped to its gauge length.
    pub fn is_length_prescribed(&self, index: usize) -> bool {
        self.notes.get(index).is_some_and(|notes| notes.length_prescribed)
    }

    /// The tool that a program names.
    pub fn find(&self, id: &ToolId) -> Option<&Tool> {
        self.position(id).map(|i| &self.tools[i])
    }

    /// Its index in [`Self::tools`].
    pub fn position(&self, id: &ToolId) -> Option<usize> {
        self.tools.iter().position(|t| match id {
            ToolId::Number(n) => t.number == *n,
            ToolId::Name(n) => t.name == *n,
        })
    }

    /// The name in the library nearest to one that it lacks, for a diagnostic.
    pub fn nearest_name(&self, name: &str) -> Option<&str> {
        nearest(name, self.tools.iter().map(|t| t.name.as_str()))
    }
}

/// The path of a key of tool `index`, in the table of the tool that has it; in the tool itself where none
/// does.
fn place_of<'a>(document: &Document<'_>, index: usize, key: &'a str) -> Vec<Step<'a>> {
    let path = |below: &[Step<'a>]| [&[Key("tool"), Item(index)], below, &[Key(key)]].concat();
    let own = path(&[]);
    if document.has(&own) {
        return own;
    }
    TABLES.iter().map(|table| path(table)).find(|path| document.has(path)).unwrap_or(own)
}
