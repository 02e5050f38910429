//! Siemens Sinumerik 840D sl.
//!
//! Text runs through [`parser`] (one line to one block; [`statement`] and [`expr`] for the language), [`index`] (structure of
//! a file, once), and [`interpreter`] (control flow and calls), which executes plain blocks in [`block`], [`motion`],
//! [`frames`] and [`drilling`]. [`words`] lists what is read with a note or refused.

mod block;
mod drilling;
mod eval;
mod expr;
mod frames;
mod index;
mod interpreter;
mod modal;
mod motion;
mod parser;
mod pending;
mod statement;
mod words;

pub(crate) use interpreter::Interpreter;

use crate::diagnostic::Diagnostic;
use crate::source::{Mark, Source};

/// All faults of single lines: grammar, and words that are refused wherever they stand.
pub(crate) fn line_faults(source: &Source) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    let mut block = parser::Block::default();
    let mut at = Mark::START;
    while let Some((line, next)) = source.line(at) {
        let fault = match parser::parse_line(line, &mut block) {
            Err(fault) => Some(fault),
            Ok(()) => block.words.iter().find_map(block::refused_word),
        };
        if let Some(fault) = fault {
            faults.push(fault.at(&source.name, at.line, line));
        }
        at = next;
    }
    faults
}
