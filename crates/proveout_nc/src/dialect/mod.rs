//! The languages of programs. Each reader lives in a folder of its own and gives the same canonical commands.

mod apt;
mod detect;
mod foreign;
mod heidenhain;
mod iso;
pub(crate) mod listed;
mod siemens;

use std::fmt::Debug;
use std::path::PathBuf;

use crate::Command;
use crate::codes;
use crate::compensation::CompStyle;
use crate::control::words::Builtin;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::not_run::NotRun;
use crate::settings::{Dialect, Settings};
use crate::source::Source;

use listed::UnlistedWords;

pub use detect::detect;

/// A program being executed. After an error or the end it gives nothing more.
pub(crate) trait Reader: Debug {
    /// The next command, or what ended the run.
    fn next_command(&mut self) -> Option<Result<Command, Box<Diagnostic>>>;

    /// How cutter compensation goes around corners and onto the contour, after the last command;
    /// none: as is usual for the dialect.
    fn comp_style(&self) -> Option<CompStyle> {
        None
    }

    /// Text of a line of a program that was read, for messages of the stages after the reader.
    fn source_line(&self, _file: &str, _line: u32) -> Option<String> {
        None
    }

    /// What is wrong with the structure of the main file: opening words without closing ones. Such a program
    /// is not run.
    fn take_structure_faults(&mut self) -> Vec<Diagnostic> {
        Vec::new()
    }

    /// Goes on after the block of the last fault; false where nothing can follow.
    fn recover(&mut self) -> bool {
        false
    }

    /// True where this fault may be there only because of one before: what a block with a fault would have
    /// set is not known.
    fn follows(&self, _fault: &Diagnostic) -> bool {
        false
    }

    /// The files that were read so far, the main program first.
    fn sources(&self) -> Vec<&Source> {
        Vec::new()
    }

    /// Text of these files that was not run, once the run is over.
    fn not_run(&self) -> Vec<NotRun> {
        Vec::new()
    }

    /// The text is that of a subprogram, which need not move and does not end with M30.
    fn is_subprogram(&self) -> bool {
        false
    }

    /// The run has ended at a probing motion whose answer is not known.
    fn waits_for_probe(&self) -> bool {
        false
    }
}

/// The reader of a program. `folder`: where the main program lies, if it is a file. `dialect` is not
/// [`Dialect::Auto`].
pub(crate) fn open(
    dialect: Dialect,
    source: Source,
    folder: Option<PathBuf>,
    settings: &Settings,
) -> Result<Box<dyn Reader>, Diagnostics> {
    Ok(match dialect {
        Dialect::Siemens840d => siemens::open(source, folder, settings),
        Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => {
            iso::open(dialect, source, folder, settings)
        }
        Dialect::Heidenhain | Dialect::HeidenhainIso => heidenhain::open(dialect, source, folder, settings),
        Dialect::Apt => apt::open(source, settings),
        Dialect::Auto => return Err(unknown(&source)),
    })
}

/// The reader executes this word without a control file: such a file may give its function to
/// another word. Words that end or call programs are excluded.
pub(crate) fn does_word(dialect: Dialect, word: Builtin) -> bool {
    match dialect {
        Dialect::Siemens840d => siemens::does_word(word),
        Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => iso::does_word(dialect, word),
        Dialect::Heidenhain | Dialect::HeidenhainIso => heidenhain::does_word(word),
        Dialect::Apt | Dialect::Auto => false,
    }
}

/// Words of a file that neither the reader nor the control file gives a meaning.
pub(crate) fn unlisted_words(dialect: Dialect, source: &Source, settings: &Settings, found: &mut UnlistedWords<'_>) {
    match dialect {
        Dialect::Siemens840d => siemens::unlisted_words(source, settings, found),
        Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => {
            iso::unlisted_words(dialect, source, settings, found);
        }
        Dialect::Heidenhain | Dialect::HeidenhainIso => heidenhain::unlisted_words(dialect, source, settings, found),
        Dialect::Apt => apt::unlisted_words(source, settings, found),
        Dialect::Auto => {}
    }
}

/// All faults of single lines: grammar, and words that are refused everywhere.
pub(crate) fn line_faults(dialect: Dialect, source: &Source, settings: &Settings) -> Vec<Diagnostic> {
    match dialect {
        Dialect::Siemens840d => siemens::line_faults(source, settings),
        Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => {
            iso::line_faults(dialect, source, settings)
        }
        Dialect::Heidenhain | Dialect::HeidenhainIso => heidenhain::line_faults(dialect, source, settings),
        Dialect::Apt => apt::line_faults(source, settings),
        Dialect::Auto => Vec::new(),
    }
}

fn unknown(source: &Source) -> Diagnostics {
    let names: Vec<&str> = Dialect::NAMES.iter().map(|(name, _)| *name).collect();
    let (message, help) = if source.text.trim().is_empty() {
        (format!("the program {} is empty", source.name), "name the file that was posted".to_owned())
    } else {
        (
            format!("the dialect of {} could not be determined from its file name extension and its text", source.name),
            format!(
                "no line of it reads as NC code: check that it is an NC program, or name the dialect: {}",
                names.join(", ")
            ),
        )
    };
    Diagnostics::from(Diagnostic {
        code: codes::DIALECT,
        message,
        file: source.name.clone(),
        line: 1,
        column: 1,
        length: 0,
        help: Some(help),
        source_line: source.text.lines().next().unwrap_or_default().into(),
        about: None,
    })
}

/// Statements of a Fagor as those of the reader.
pub(crate) fn fagor_text(text: &str) -> String {
    iso::fagor_text::translated(text)
}
