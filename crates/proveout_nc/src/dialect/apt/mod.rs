//! APT cutter location data.
//!
//! Words after ISO 4343:2000 (major words of the processor output and of post-processor
//! statements), with the forms that CAM systems write: CATIA V5 (`TLON,GOFWD/ (CIRCLE/...)`,
//! `INDIRV`, `TLAXIS`), NX (`CIRCLE/` with tolerances, `MSYS`, `TOOL PATH`,
//! `CYCLE/DRILL,RAPTO,..,FEDTO,..`), Creo (`CIRCLE/` before `GOTO`), `CAMWorks` (`UNIT/`, `CSYS/`,
//! `TRNTYP/`, `CYCLE/DEEP2`) and the ISO 4343 output of Autodesk's posts (`MOVARC/..,ANGLE,..`).
//! [`statement`] splits the text into statements, [`words`] lists what is read with a note or
//! refused, [`reader`] runs the statements, [`path`], [`circle`] and [`drilling`] make the motions,
//! [`writer`] determines which system wrote the text.
//!
//! CL data contains no machine and no zero point: its coordinates are those of work offset G54, and
//! the first command says so. Without tool vectors it runs with the axes of the machine. From the
//! first vector on, tool center point control is on and every motion carries the tool axis.

mod circle;
mod drilling;
mod feed;
mod items;
mod path;
mod post_text;
mod reader;
mod recover;
mod statement;
mod systems;
mod technology;
mod words;
mod writer;

use super::Reader;
use super::listed::{UnlistedWords, WordState};
use crate::control::words::{WordKey, word_key};
use crate::diagnostic::Diagnostic;
use crate::settings::Settings;
use crate::source::{Mark, Source};

use statement::AptStatement;

/// The reader of a program.
pub(crate) fn open(source: Source, settings: &Settings) -> Box<dyn Reader> {
    Box::new(reader::begin(source, settings))
}

/// Major words defined neither by the reader nor by the control file.
pub(crate) fn unlisted_words(source: &Source, settings: &Settings, found: &mut UnlistedWords<'_>) {
    let mut statement = AptStatement::default();
    let mut at = Mark::START;
    while let Some((result, next)) = statement::read(source, at, &mut statement) {
        match result {
            Err(bad) => found.faults.push(bad.diagnostic(source)),
            Ok(()) if !statement.major.is_empty() && !statement.assignment => {
                let now = match words::classify(&statement.major) {
                    words::MajorWordClass::Unknown => Some(WordState::Unknown),
                    words::MajorWordClass::Refused(_) => Some(WordState::NotSupported),
                    words::MajorWordClass::Done | words::MajorWordClass::Note => None,
                };
                let key = word_key(&statement.major).filter(|key| matches!(key, WordKey::Name(_)));
                let listed = settings.control.words.name(&statement.major).is_some();
                if let (Some(now), Some(key), false) = (now, key, listed) {
                    let mark = statement.head.mark;
                    let line = source.line(mark).map_or("", |(line, _)| line);
                    found.word(key, statement.head.span, mark, line, now);
                }
            }
            Ok(()) => {}
        }
        at = next;
    }
}

/// All faults of single statements: grammar, and words that are refused in any context.
pub(crate) fn line_faults(source: &Source, settings: &Settings) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    let mut statement = AptStatement::default();
    let mut at = Mark::START;
    while let Some((result, next)) = statement::read(source, at, &mut statement) {
        let bad = match result {
            Err(bad) => Some(bad),
            Ok(()) => reader::refused_word(&statement, &settings.control),
        };
        faults.extend(bad.map(|bad| bad.diagnostic(source)));
        at = next;
    }
    faults
}
