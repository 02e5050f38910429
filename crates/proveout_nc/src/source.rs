//! Program text with its name, line by line.

use std::path::Path;
use std::sync::Arc;

use crate::codes;
use crate::diagnostic::Diagnostic;

/// Largest file, in bytes: places in a line are 32-bit, places in a file 64-bit; a program beyond this is a mistake.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// A program text.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) name: Arc<str>,
    pub(crate) text: String,
}

/// Start of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Mark {
    /// Byte of the first character in the text.
    pub(crate) offset: usize,
    /// Line number from 1.
    pub(crate) line: u32,
}

impl Mark {
    pub(crate) const START: Self = Self { offset: 0, line: 1 };
}

impl Source {
    pub(crate) fn new(name: &str, text: String) -> Self {
        Self { name: Arc::from(name), text }
    }

    /// Reads a file. Text that is not UTF-8 is taken as Latin-1, as older controls write it.
    pub(crate) fn read(path: &Path) -> Result<Self, Box<Diagnostic>> {
        let name = path.display().to_string();
        let refuse = |message: String, help: &str| {
            Box::new(Diagnostic {
                code: codes::FILE,
                message,
                file: Arc::from(name.as_str()),
                line: 0,
                column: 0,
                length: 0,
                help: Some(help.to_owned()),
                source_line: String::new(),
            })
        };
        let size = std::fs::metadata(path).map_err(|e| refuse(format!("cannot read {name}: {e}"), "check the path"))?;
        if !size.is_file() {
            return Err(refuse(format!("{name} is not a file"), "name the program file"));
        }
        if size.len() > MAX_FILE_BYTES {
            let message = format!("{name} has {} bytes; the limit is {MAX_FILE_BYTES}", size.len());
            return Err(refuse(message, "split the program into subprograms"));
        }
        let bytes = std::fs::read(path).map_err(|e| refuse(format!("cannot read {name}: {e}"), "check the rights"))?;
        let mut text =
            String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect());
        if text.starts_with('\u{feff}') {
            text.drain(..'\u{feff}'.len_utf8());
        }
        Ok(Self::new(&name, text))
    }

    /// The line that starts at the mark, without its end, and the mark of the next line; none at the end of the text.
    pub(crate) fn line(&self, at: Mark) -> Option<(&str, Mark)> {
        let rest = self.text.get(at.offset..)?;
        if rest.is_empty() {
            return None;
        }
        let end = rest.as_bytes().iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let next = Mark { offset: at.offset + (end + 1).min(rest.len()), line: at.line + 1 };
        let line = &rest[..end];
        Some((line.strip_suffix('\r').unwrap_or(line), next))
    }
}
