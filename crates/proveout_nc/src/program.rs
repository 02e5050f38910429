//! A program as an iterator of commands.

use std::path::{Path, PathBuf};

use crate::Command;
use crate::codes;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::dialect::siemens;
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
    reader: Reader,
    dialect: Dialect,
}

#[derive(Debug)]
enum Reader {
    Siemens(Box<siemens::Interpreter>),
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
        match dialect {
            Dialect::Siemens840d => {
                let interpreter = siemens::Interpreter::new(source, folder, settings)?;
                Ok(Self { reader: Reader::Siemens(Box::new(interpreter)), dialect })
            }
            Dialect::Iso | Dialect::Auto => {
                let message = format!("{} is no Siemens 840D program, and no other dialect is read yet", source.name);
                Err(Diagnostics::from(Diagnostic {
                    code: codes::DIALECT,
                    message,
                    file: source.name,
                    line: 1,
                    column: 1,
                    length: 0,
                    help: Some("name the file .mpf or .spf, or set the dialect".to_owned()),
                    source_line: source.text.lines().next().unwrap_or_default().to_owned(),
                }))
            }
        }
    }

    /// The dialect that is read.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }
}

impl Iterator for Program {
    type Item = Result<Command, Diagnostic>;

    fn next(&mut self) -> Option<Self::Item> {
        match &mut self.reader {
            Reader::Siemens(interpreter) => interpreter.next().map(|item| item.map_err(|diagnostic| *diagnostic)),
        }
    }
}

/// Tells the dialect from the ending of the name, then from the text; [`Dialect::Auto`] where neither says.
pub fn detect(name: &str, text: &str) -> Dialect {
    let ending = Path::new(name).extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("mpf" | "spf" | "arc") => return Dialect::Siemens840d,
        Some("h" | "i" | "apt" | "cls") => return Dialect::Auto,
        _ => {}
    }
    for line in text.lines().take(200) {
        let line = line.trim_start().to_ascii_uppercase();
        let code = line.split(';').next().unwrap_or_default();
        let siemens =
            ["%_N_", ";$PATH", "DEF REAL", "DEF INT", "TRAORI", "TRAFOOF", "CYCLE8", "SUPA", "G710", "AROT ", "MSG("];
        if siemens.iter().any(|mark| line.starts_with(mark) || code.contains(mark)) {
            return Dialect::Siemens840d;
        }
        if line.starts_with('%') || line.starts_with('O') && line[1..].starts_with(|c: char| c.is_ascii_digit()) {
            return Dialect::Iso;
        }
    }
    if text.lines().take(200).any(|line| line.trim_start().starts_with('(')) { Dialect::Iso } else { Dialect::Auto }
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
    let mut list = match program.dialect {
        Dialect::Siemens840d => siemens::line_faults(&Source::new(name, text)),
        _ => Vec::new(),
    };
    if let Some(fault) = program.filter_map(Result::err).next() {
        let known = list.iter().any(|d| d.file == fault.file && d.line == fault.line && d.code == fault.code);
        if !known {
            list.push(fault);
        }
    }
    list
}

fn with_lines(name: &str, text: String, settings: &Settings, mut list: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let siemens = settings.dialect == Dialect::Siemens840d || detect(name, &text) == Dialect::Siemens840d;
    if siemens {
        list.extend(siemens::line_faults(&Source::new(name, text)));
        list.sort_by_key(|d| (d.line, d.column));
    }
    list
}
