//! TOML text to a typed value, with errors that name file, line, column and remedy.

use std::path::{Path, PathBuf};

use proveout_geom::{OutOfRange, check_quantities, read_regular_text};
use serde::de::DeserializeOwned;
use thiserror::Error;

/// Largest text of a scene.
const MAX_FILE_BYTES: u64 = 64 << 20;

/// A fault in an input file, with its place.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}:{line}:{column}: {message}", file.display())]
pub struct ConfigError {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1; 0 when the fault is the file itself.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
    /// What is wrong, with the value.
    pub message: String,
    /// What to do about it.
    pub help: String,
    /// The line of text.
    pub source_line: String,
}

impl ConfigError {
    /// A fault of a whole file: missing, or not readable.
    pub fn file(file: &Path, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            line: 0,
            column: 0,
            message: message.into(),
            help: help.into(),
            source_line: String::new(),
        }
    }

    /// A fault at a byte offset of the text.
    pub fn at(file: &Path, text: &str, offset: usize, message: impl Into<String>, help: impl Into<String>) -> Self {
        let before = text.get(..offset).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Self {
            file: file.into(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message: message.into(),
            help: help.into(),
            source_line: text[line_start..].lines().next().unwrap_or_default().into(),
        }
    }
}

/// Reads a file as text.
///
/// # Errors
/// [`ConfigError`] with the path when it is missing or not UTF-8.
pub fn read_text(file: &Path) -> Result<String, ConfigError> {
    read_regular_text(file, MAX_FILE_BYTES)
        .map_err(|e| ConfigError::file(file, format!("cannot be read: {e}"), "check the path"))
}

/// Parses TOML; unknown keys are refused when the type says so.
///
/// # Errors
/// [`ConfigError`] at the key or value, with the nearest known key as remedy.
pub fn parse_toml<T: DeserializeOwned>(file: &Path, text: &str) -> Result<T, ConfigError> {
    let value = toml::from_str(text).map_err(|e| {
        let offset = e.span().map_or(0, |s| s.start);
        let message = e.message().trim().to_owned();
        let help = help_for(&message);
        ConfigError::at(file, text, offset, message, help)
    })?;
    check_quantities(text).map_err(|e| ConfigError::at(file, text, e.span.start, e.to_string(), OutOfRange::REMEDY))?;
    Ok(value)
}

/// The remedy for a message of the TOML reader.
fn help_for(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    if message.starts_with("unknown field") {
        let Some(wrong) = quoted.next() else { return String::new() };
        let best = quoted.min_by_key(|known| strsim::levenshtein(wrong, known));
        return best.map_or_else(String::new, |known| format!("did you mean `{known}`?"));
    }
    if message.starts_with("missing field") {
        return format!("add `{}`", quoted.next().unwrap_or_default());
    }
    "see docs/schemas for what is allowed here".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Sample {
        #[expect(dead_code, reason = "only the reading is tested")]
        resolution_mm: f64,
    }

    #[test]
    fn a_misspelt_key_has_place_and_remedy() {
        let text = "# scene\nresolution_mm = 1.0\nresolutoin_mm = 2.0\n";
        let error = parse_toml::<Sample>(Path::new("scene.toml"), text).expect_err("unknown key");
        assert_eq!((error.line, error.column), (3, 1));
        assert_eq!(error.help, "did you mean `resolution_mm`?");
        assert_eq!(error.source_line, "resolutoin_mm = 2.0");
    }

    #[test]
    fn a_missing_key_says_what_to_add() {
        let error = parse_toml::<Sample>(Path::new("scene.toml"), "").expect_err("missing key");
        assert_eq!(error.help, "add `resolution_mm`");
    }
}
