//! ISO 6983 / RS274: Fanuc, Haas, `LinuxCNC`.
//!
//! Text runs through [`parser`] (one line to one block; [`statement`] and [`expr`] for the
//! language), [`index`] (structure of a file, once), and [`interpreter`] (flow in [`control`],
//! calls in [`calls`], parameters in [`eval`] and [`system`]), which executes plain blocks in
//! [`block`], [`technology`], [`motion`], [`arcs`], [`machine`], [`offsets`], [`length`], [`tilt`]
//! with [`planes`] and [`cycles`] with [`boring`], [`bolt_holes`] and [`circle_pocket`]. Chamfers
//! and roundings are in [`corners`], words of a control file in [`listed`], those of an Okuma in
//! [`osp`], of a Fagor in [`fagor`] and [`fagor_text`]. [`words`] lists what each control reads,
//! notes or refuses; [`flavor`] detects the control.

mod arcs;
mod block;
mod bolt_holes;
mod boring;
mod calls;
mod circle_pocket;
mod control;
mod corners;
mod cycles;
mod eval;
mod expr;
mod fagor;
pub(crate) mod fagor_text;
mod flavor;
mod grbl;
mod grbl_words;
mod index;
mod interpreter;
mod leftover;
mod length;
mod listed;
mod machine;
mod modal;
mod motion;
mod nurbs;
mod offsets;
mod osp;
mod parser;
mod pending;
mod planes;
mod polar;
mod recover;
mod remarks;
mod rs274;
mod run_state;
mod statement;
mod system;
mod technology;
mod tilt;
mod variables;
mod words;

use std::path::PathBuf;

use flavor::Flavor;

use super::Reader;
use super::listed::{UnlistedWords, each_line};
use crate::control::words::Builtin;
use crate::diagnostic::Diagnostic;
use crate::g_code::{G65, G66, G67};
use crate::settings::{Dialect, Settings};
use crate::source::Source;

/// The reader executes this word without a control file; words that end or call programs are left
/// out.
pub(crate) fn does_word(dialect: Dialect, word: Builtin) -> bool {
    let flavor = match dialect {
        Dialect::Haas => Flavor::Haas,
        Dialect::LinuxCnc => Flavor::LinuxCnc,
        _ => Flavor::Fanuc,
    };
    match word {
        Builtin::G(code) => {
            !matches!(code, G65 | G66 | G67) && matches!(words::classify(flavor, code), words::GWordClass::Known(_))
        }
        Builtin::M(code) => {
            use words::Function::{CoolantOff, CoolantOn, Orient, Override, Rigid, Spindle, Stop, ToolChange};
            let function = words::function(flavor, code);
            !matches!(code, 2 | 30)
                && matches!(function, Stop | Spindle | ToolChange | CoolantOn | CoolantOff | Override | Orient | Rigid)
        }
    }
}

/// The reader of a program.
pub(crate) fn open(dialect: Dialect, source: Source, folder: Option<PathBuf>, settings: &Settings) -> Box<dyn Reader> {
    let told = flavor::tell(dialect, &source);
    Box::new(interpreter::begin(source, folder, settings, told))
}

/// Words that neither the reader nor the control file gives a meaning.
pub(crate) fn unlisted_words(dialect: Dialect, source: &Source, settings: &Settings, found: &mut UnlistedWords<'_>) {
    let told = flavor::tell(dialect, source);
    let parse = |line: &str, block: &mut parser::IsoBlock| parser::parse_line(line, told.flavor, block);
    each_line(source, parse, |at, line, block| {
        let unlisted = |word: &parser::IsoWord| {
            block::unlisted_word(told.flavor, !told.certain, &settings.control, word)
                .map(|(key, now)| (key, word.span, now))
        };
        found.block(at, line, block.map(|block| block.words.iter().filter_map(unlisted)));
    });
}

/// All faults of single lines: grammar, and words that are refused everywhere.
pub(crate) fn line_faults(dialect: Dialect, source: &Source, settings: &Settings) -> Vec<Diagnostic> {
    let told = flavor::tell(dialect, source);
    let flavor = told.flavor;
    let mut faults = Vec::new();
    let outside = index::Index::new(source, flavor, &mut Vec::new()).parts;
    let outside: Vec<[u32; 2]> = outside.into_iter().filter(|part| part.outside).map(|part| part.lines).collect();
    let parse = |line: &str, block: &mut parser::IsoBlock| parser::parse_line(line, flavor, block);
    each_line(source, parse, |at, line, block| {
        if outside.iter().any(|lines| (lines[0]..lines[1]).contains(&at.line)) {
            // No control reads it.
            return;
        }
        let refused = |word| block::refused_word(flavor, !told.certain, &settings.control, word);
        let of_line = block.map_or_else(
            |fault| vec![fault],
            |b| {
                b.words
                    .iter()
                    .filter_map(refused)
                    .chain(osp::refused(b, settings.control.osp_words))
                    .chain(grbl::refused(b, &settings.control))
                    .collect()
            },
        );
        faults.extend(of_line.into_iter().map(|fault| fault.at(&source.name, at.line, line)));
    });
    faults
}
