//! Siemens Sinumerik 840D sl.
//!
//! Text runs through [`parser`] (one line to one block; [`statement`] and [`expr`] for the
//! language), [`index`] (structure of a file, once), and [`interpreter`] (control flow and calls),
//! which executes plain blocks: [`block`] and [`assignments`] collect their words, [`act`] executes
//! them with [`motion`], [`arcs`], [`polar`], [`frames`], [`technology`], [`splines`],
//! [`compensation`] and the cycles in [`drilling`], [`tapping`] and [`boring`]. [`corners`] inserts
//! chamfers and roundings between motions, [`waiting`] holds rapids back whose end is not known
//! yet, [`fixed_point`] moves to points of the machine, [`contour`] and [`contour_milling`] mill
//! along a subprogram, [`frame_values`] and [`system`] are variables of the control, [`words`]
//! lists what is read with a note or refused.

mod act;
mod arcs;
mod assignments;
mod block;
mod boring;
mod compensation;
mod contour;
mod contour_milling;
mod corners;
mod drilling;
mod eval;
mod expr;
mod feed_group;
mod fixed_point;
mod frame_values;
mod frames;
mod index;
mod interpreter;
mod leftover;
mod listed;
mod measuring;
mod milling;
mod modal;
mod motion;
mod parser;
mod pending;
mod polar;
mod recover;
mod run_state;
mod slots;
mod splines;
mod statement;
mod surfaces;
mod system;
mod tapping;
mod technology;
mod tool_frame;
mod two_lines;
mod waiting;
mod without_use;
mod words;

use std::path::PathBuf;

use super::Reader;
use super::listed::{UnlistedWords, each_line};
use crate::control::words::Builtin;
use crate::diagnostic::{Diagnostic, Fault};
use crate::g_code::GCode;
use crate::settings::Settings;
use crate::source::Source;

/// The reader executes this word itself. Words that end programs are excluded.
pub(crate) fn does_word(word: Builtin) -> bool {
    match word {
        Builtin::G(GCode(code, tenth)) => tenth == 0 && block::does_g(i64::from(code)),
        Builtin::M(code) => matches!(code, 0 | 1 | 3..=9),
    }
}

/// The reader of a program.
pub(crate) fn open(source: Source, folder: Option<PathBuf>, settings: &Settings) -> Box<dyn Reader> {
    Box::new(interpreter::begin(source, folder, settings))
}

/// Words defined neither by the reader nor by the control file. Names that are not words of the
/// reader may be subprograms: they are reported when they are run.
pub(crate) fn unlisted_words(source: &Source, settings: &Settings, found: &mut UnlistedWords<'_>) {
    each_line(source, parser::parse_line, |at, line, block| {
        let unlisted =
            |word: &parser::Word| block::unlisted_word(word, &settings.control).map(|(key, now)| (key, word.span, now));
        found.block(at, line, block.map(|block| block.words.iter().filter_map(unlisted)));
    });
}

/// All faults of single lines: grammar, and words that are refused in any context.
pub(crate) fn line_faults(source: &Source, settings: &Settings) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    each_line(source, parser::parse_line, |at, line, block: Result<&parser::SiemensBlock, Fault>| {
        let refused = |word| block::refused_word(word, &settings.control);
        let of_line = block.map_or_else(|fault| vec![fault], |b| b.words.iter().filter_map(refused).collect());
        faults.extend(of_line.into_iter().map(|fault| fault.at(&source.name, at.line, line)));
    });
    faults
}
