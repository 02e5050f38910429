//! Errors of library files, with their place.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

/// Why a tool library cannot be used.
#[derive(Debug, Error)]
pub enum ToolError {
    /// The file cannot be read.
    #[error("cannot read the tool library {}: {source}; check the path and its permissions", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Something in it is wrong.
    #[error(transparent)]
    Defect(Box<Defect>),
}

impl ToolError {
    /// The defect, when the file could be read.
    pub fn defect(&self) -> Option<&Defect> {
        match self {
            Self::Defect(d) => Some(d),
            _ => None,
        }
    }
}

/// A defect at a place of a library file.
#[derive(Clone, Debug, Error, PartialEq)]
pub struct Defect {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Tool by name, empty when it concerns none.
    pub tool: String,
    /// Key, empty when the text is no TOML.
    pub key: String,
    /// Value as written, empty when there is none.
    pub value: String,
    /// What is wrong, with the limit.
    pub message: String,
    /// What to do.
    pub remedy: String,
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: ", self.file.display(), self.line, self.column)?;
        if !self.tool.is_empty() {
            write!(f, "tool \"{}\": ", self.tool)?;
        }
        if !self.key.is_empty() {
            write!(f, "`{}`", self.key)?;
            if !self.value.is_empty() {
                write!(f, " = {}", self.value)?;
            }
            write!(f, " ")?;
        }
        write!(f, "{}", self.message)?;
        if self.remedy.is_empty() { Ok(()) } else { write!(f, "; {}", self.remedy) }
    }
}

/// The known word nearest to an unknown one by edits (Levenshtein 1966), when it is near enough to be a slip.
pub(crate) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (word.chars().count() / 3).max(2);
    known.into_iter().map(|k| (strsim::levenshtein(word, k), k)).filter(|(d, _)| *d <= limit).min().map(|(_, k)| k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_find_their_word() {
        assert_eq!(nearest("diamter_mm", ["number", "diameter_mm", "flutes"]), Some("diameter_mm"));
        assert_eq!(nearest("zzzzzz", ["number", "diameter_mm", "flutes"]), None);
    }
}
