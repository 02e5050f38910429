//! ISO 6983 / RS274: Fanuc, Haas, `LinuxCNC`.
//!
//! Text runs through [`parser`] (one line to one block; [`statement`] and [`expr`] for the language), [`index`] (structure of
//! a file, once), and [`interpreter`] (flow in [`control`], calls in [`calls`], parameters in [`eval`] and [`system`]), which
//! executes plain blocks in [`block`], [`technology`], [`motion`], [`arcs`], [`machine`], [`offsets`], [`length`], [`tilt`]
//! and [`cycles`] with [`boring`]. [`words`] lists what each control reads, notes or refuses; [`flavor`] tells the control.

mod arcs;
mod block;
mod boring;
mod calls;
mod control;
mod cycles;
mod eval;
mod expr;
mod flavor;
mod index;
mod interpreter;
mod leftover;
mod length;
mod machine;
mod modal;
mod motion;
mod nurbs;
mod offsets;
mod parser;
mod pending;
mod polar;
mod recover;
mod remarks;
mod statement;
mod system;
mod technology;
mod tilt;
mod variables;
mod words;

use std::path::PathBuf;

use super::Reader;
use crate::diagnostic::Diagnostic;
use crate::settings::{Dialect, Settings};
use crate::source::{Mark, Source};

/// The reader of a program.
pub(crate) fn open(dialect: Dialect, source: Source, folder: Option<PathBuf>, settings: &Settings) -> Box<dyn Reader> {
    let told = flavor::tell(dialect, &source);
    Box::new(interpreter::begin(source, folder, settings, told))
}

/// All faults of single lines: grammar, and words that are refused wherever they stand.
pub(crate) fn line_faults(dialect: Dialect, source: &Source) -> Vec<Diagnostic> {
    let told = flavor::tell(dialect, source);
    let flavor = told.flavor;
    let mut faults = Vec::new();
    let mut block = parser::Block::default();
    let mut at = Mark::START;
    let outside = index::Index::new(source, flavor, &mut Vec::new()).parts;
    let outside: Vec<[u32; 2]> = outside.into_iter().filter(|part| part.outside).map(|part| part.lines).collect();
    while let Some((line, next)) = source.line(at) {
        if outside.iter().any(|lines| (lines[0]..lines[1]).contains(&at.line)) {
            // No control reads it.
            at = next;
            continue;
        }
        match parser::parse_line(line, flavor, &mut block) {
            Err(fault) => faults.push(fault.at(&source.name, at.line, line)),
            Ok(()) => {
                let refused = block.words.iter().filter_map(|word| block::refused_word(flavor, !told.certain, word));
                faults.extend(refused.map(|fault| fault.at(&source.name, at.line, line)));
            }
        }
        at = next;
    }
    faults
}
