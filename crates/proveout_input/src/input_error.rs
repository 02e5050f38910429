//! The one error of input files: place, value, limit, remedy.

use std::{
    error::Error,
    fmt,
    io::{self, ErrorKind},
    ops::{Deref, Range},
    path::{Path, PathBuf},
};

use crate::read_regular_file;

/// Largest text of an input file: thousands of tools, or joints, or programs.
const MAX_BYTES: u64 = 16 << 20;

/// What keeps an input file (scene, machine, tool library) from being used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError(Box<InputFault>);

/// The parts of an [`InputError`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InputFault {
    /// Stable name of the kind of fault (`input-unknown-key`, `machine-loop`); empty where it has none.
    pub code: &'static str,
    /// The file.
    pub file: PathBuf,
    /// Line, from 1; 0 when the fault is the file itself.
    pub line: usize,
    /// Column in characters, from 1; 0 when the fault is the file itself or a whole line.
    pub column: usize,
    /// Characters of the line that are at fault.
    pub length: usize,
    /// Path of the key, `joint.B.travel_deg`; empty where the message names it.
    pub key: String,
    /// The value as written; empty where there is none, or the message names it.
    pub value: String,
    /// What is wrong, with the limit.
    pub message: String,
    /// Whether the message is what the sentence says of the key: `is missing`.
    pub continues_key: bool,
    /// What to do about it.
    pub remedy: String,
    /// The line of text.
    pub source_line: String,
}

/// Key, value and message in one sentence, with the code where there is one: the text that follows the
/// position.
impl fmt::Display for InputFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.key.is_empty(), self.value.is_empty()) {
            (true, _) => {}
            (false, true) if self.continues_key => write!(f, "`{}` ", self.key)?,
            (false, true) => write!(f, "`{}`: ", self.key)?,
            (false, false) => write!(f, "`{}` = {}: ", self.key, self.value)?,
        }
        write!(f, "{}", self.message)?;
        if self.code.is_empty() { Ok(()) } else { write!(f, " [{}]", self.code) }
    }
}

impl InputFault {
    /// `file:line:column`, or the file where the fault is all of it.
    pub fn place(&self) -> String {
        match (self.line, self.column) {
            (0, _) => self.file.display().to_string(),
            (line, 0) => format!("{}:{line}", self.file.display()),
            (line, column) => format!("{}:{line}:{column}", self.file.display()),
        }
    }
}

/// All in one line: place, key, value, message, remedy.
impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place(), self.0)?;
        if self.remedy.is_empty() { Ok(()) } else { write!(f, "; {}", self.remedy) }
    }
}

impl Error for InputError {}

impl Deref for InputError {
    type Target = InputFault;

    fn deref(&self) -> &InputFault {
        &self.0
    }
}

impl From<InputFault> for InputError {
    fn from(fault: InputFault) -> Self {
        Self(Box::new(fault))
    }
}

impl InputError {
    /// A fault of a whole file.
    pub fn file(file: &Path, message: impl Into<String>, remedy: impl Into<String>) -> Self {
        let (message, remedy) = (message.into(), remedy.into());
        InputFault { file: file.into(), message, remedy, ..InputFault::default() }.into()
    }

    /// A fault at a byte of the text.
    pub fn at(file: &Path, text: &str, offset: usize, message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::file(file, message, remedy).with_span(text, &(offset..offset))
    }

    /// The same fault at these bytes of the text.
    #[must_use]
    pub fn with_span(mut self, text: &str, span: &Range<usize>) -> Self {
        let line_start = text.get(..span.start).and_then(|before| before.rfind('\n')).map_or(0, |i| i + 1);
        let line = text[line_start..].lines().next().unwrap_or_default();
        let before = text.get(line_start..span.start).unwrap_or_default();
        let at_fault = text.get(span.clone()).and_then(|t| t.lines().next()).unwrap_or_default();
        self.0.line = text[..line_start].matches('\n').count() + 1;
        self.0.column = before.chars().count() + 1;
        self.0.length = at_fault.chars().count().max(1);
        line.clone_into(&mut self.0.source_line);
        self
    }

    /// The same fault on a line, from 1, whose text and column are not known.
    #[must_use]
    pub fn with_line(mut self, line: usize) -> Self {
        self.0.line = line;
        self
    }
}

/// Reads an input file as text.
///
/// # Errors
/// [`InputError`] with the path where it is missing, is a folder, a pipe or a device, or has more than 16
/// MiB; with the place of the first byte that is not UTF-8.
pub fn read_input(file: &Path) -> Result<String, InputError> {
    const CODE: &str = "input-unreadable";
    let bytes = read_regular_file(file, MAX_BYTES).map_err(|e| {
        let message = format!("the file cannot be read: {e}");
        InputFault { code: CODE, file: file.into(), message, remedy: remedy(&e).into(), ..InputFault::default() }
    })?;
    String::from_utf8(bytes).map_err(|e| {
        let good = e.utf8_error().valid_up_to();
        let byte = e.as_bytes().get(good).copied().unwrap_or_default();
        let text = String::from_utf8_lossy(e.as_bytes().get(..good).unwrap_or_default());
        let message = format!("the text is not UTF-8: byte {byte:#04x} begins no character");
        let fault = InputFault {
            code: CODE,
            file: file.into(),
            message,
            remedy: "save the file as UTF-8".into(),
            ..InputFault::default()
        };
        InputError::from(fault).with_span(&text, &(text.len()..text.len()))
    })
}

fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::IsADirectory => "name a file",
        ErrorKind::InvalidInput => "save it as a file of its own and name that",
        ErrorKind::FileTooLarge => "leave out what does not belong to it",
        ErrorKind::PermissionDenied => "ask for the right to read it",
        _ => "check the path",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_that_is_no_text_has_its_place() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, b"name = \"a\"\nunit = \"\xb5m\"\n").expect("written");
        let error = read_input(&path).expect_err("Latin 1");
        assert_eq!((error.line, error.column, error.source_line.as_str()), (2, 9, "unit = \""));
        assert!(error.to_string().contains("byte 0xb5") && error.to_string().contains("; save the file as UTF-8"));
        assert_eq!(read_input(folder.path()).expect_err("a folder").remedy, "name a file");
    }

    #[test]
    fn places_count_characters() {
        let text = "a = 1\nm\u{fc} = \"x\ny\"\n";
        let error = InputError::file(Path::new("f"), "wrong", "mend it").with_span(text, &(12..text.len()));
        assert_eq!((error.line, error.column, error.length), (2, 6, 2));
        assert_eq!(error.to_string(), "f:2:6: wrong; mend it");
        let outside = InputError::at(Path::new("f"), "", 7, "wrong", "");
        assert_eq!((outside.line, outside.column, outside.to_string().as_str()), (1, 1, "f:1:1: wrong"));
    }
}
