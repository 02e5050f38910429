//! A program as an iterator of commands.

use std::path::{Path, PathBuf};

use crate::Command;
use crate::compensation::Compensated;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::dialect::{self, detect};
use crate::settings::{Dialect, Settings};
use crate::source::Source;

/// Something that gives canonical commands one by one.
pub trait CommandSource: Iterator<Item = Result<Command, Diagnostic>> {}

impl<T: Iterator<Item = Result<Command, Diagnostic>>> CommandSource for T {}

/// A program being executed: gives its commands one by one and keeps none of them.
///
/// After an error the program is at its end.
#[derive(Debug)]
pub struct Program {
    commands: Compensated,
    dialect: Dialect,
}

impl Program {
    /// Opens a program file; subprograms are looked for in its folder and in those of the settings.
    ///
    /// # Errors
    /// The file cannot be read, its dialect is not known, or its control structures do not match.
    pub fn open(path: impl AsRef<Path>, settings: &Settings) -> Result<Self, Diagnostics> {
        let path = path.as_ref();
        let source = Source::read(path).map_err(|diagnostic| Diagnostics::from(*diagnostic))?;
        let folder = path.parent().map(|p| if p.as_os_str().is_empty() { PathBuf::from(".") } else { p.to_path_buf() });
        Self::new(source, folder, settings)
    }

    /// Takes a program from memory. `name` stands in for the file name in places of commands and errors.
    ///
    /// # Errors
    /// As [`Program::open`].
    pub fn from_text(name: &str, text: impl Into<String>, settings: &Settings) -> Result<Self, Diagnostics> {
        Self::new(Source::new(name, text.into()), None, settings)
    }

    fn new(source: Source, folder: Option<PathBuf>, settings: &Settings) -> Result<Self, Diagnostics> {
        let dialect = match settings.dialect {
            Dialect::Auto => detect(&source.name, &source.text),
            dialect => dialect,
        };
        let reader = dialect::open(dialect, source, folder, settings)?;
        Ok(Self { commands: Compensated::new(reader, dialect, settings), dialect })
    }

    /// The dialect that is read.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }
}

impl Iterator for Program {
    type Item = Result<Command, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        self.commands.next().map(|item| item.map_err(|diagnostic| *diagnostic))
    }
}

/// Everything that can be found wrong with a program: all faults of single lines and of structure, then the first fault of
/// its run. Empty when the program runs to its end.
pub fn check(path: impl AsRef<Path>, settings: &Settings) -> Vec<Diagnostic> {
    let source = match Source::read(path.as_ref()) {
        Ok(source) => source,
        Err(diagnostic) => return vec![*diagnostic],
    };
    let text = source.text.clone();
    match Program::open(path, settings) {
        Ok(program) => check_program(program, &source.name, text),
        Err(diagnostics) => with_lines(&source.name, text, settings, diagnostics.0),
    }
}

/// As [`check`], for a text in memory.
pub fn check_text(name: &str, text: &str, settings: &Settings) -> Vec<Diagnostic> {
    match Program::from_text(name, text, settings) {
        Ok(program) => check_program(program, name, text.to_owned()),
        Err(diagnostics) => with_lines(name, text.to_owned(), settings, diagnostics.0),
    }
}

fn check_program(program: Program, name: &str, text: String) -> Vec<Diagnostic> {
    let mut list = dialect::line_faults(program.dialect, &Source::new(name, text));
    if let Some(fault) = program.filter_map(Result::err).next() {
        let known = list.iter().any(|d| d.file == fault.file && d.line == fault.line && d.code == fault.code);
        if !known {
            list.push(fault);
        }
    }
    list
}

fn with_lines(name: &str, text: String, settings: &Settings, mut list: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let dialect = match settings.dialect {
        Dialect::Auto => detect(name, &text),
        dialect => dialect,
    };
    list.extend(dialect::line_faults(dialect, &Source::new(name, text)));
    list.sort_by_key(|d| (d.line, d.column));
    list
}
