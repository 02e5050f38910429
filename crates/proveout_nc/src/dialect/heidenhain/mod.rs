//! Heidenhain TNC: Klartext and DIN/ISO.
//!
//! Text runs through [`text`] (lines to blocks), then [`parser`] (Klartext; [`statements`],
//! [`cycle_words`], [`plane_words`], [`q_functions`], [`expr`] for its parts) or [`din`] (DIN/ISO)
//! into the words of [`words`]. [`interpreter`] (labels, jumps, program calls) executes paths in
//! [`motion`], [`positioning`], [`circle`], [`corner`] and [`approach`], and everything else in
//! [`execute`], [`functions`], [`frames`], [`plane`], [`cycle`], [`drilling`], [`boring`],
//! [`milling`] and [`pattern`].
//!
//! Language after HEIDENHAIN, *TNC 640 User's Manual, Klartext programming* and *Programming of machining
//! cycles* (34059x), and the *iTNC 530* manuals (340 49x) for the old forms of cycles.

mod approach;
mod boring;
mod circle;
mod corner;
mod cycle;
mod cycle_words;
mod din;
mod din_path;
mod din_words;
mod drilling;
mod execute;
mod expr;
mod frames;
mod free;
mod functions;
mod interpreter;
mod leftover;
mod lexer;
mod listed;
mod milling;
mod motion;
mod parser;
mod pattern;
mod plane;
mod plane_words;
mod positioning;
mod q_functions;
mod recover;
mod run_state;
mod state;
mod statements;
mod takes;
mod text;
mod variables;
mod words;

use std::path::PathBuf;

use super::Reader;
use super::listed::{UnlistedWords, WordState};
use crate::control::words::{Builtin, WordKey};
use crate::diagnostic::Diagnostic;
use crate::settings::{Dialect, Settings};
use crate::source::{Mark, Source};

/// The reader of a program.
pub(crate) fn open(dialect: Dialect, source: Source, folder: Option<PathBuf>, settings: &Settings) -> Box<dyn Reader> {
    Box::new(interpreter::begin(dialect, source, folder, settings))
}

/// The reader executes this word itself. Words that end or call programs are excluded.
pub(crate) fn does_word(word: Builtin) -> bool {
    match word {
        Builtin::G(_) => false,
        Builtin::M(code) => functions::does_function(code),
    }
}

/// Functions defined neither by the reader nor by the control file.
pub(crate) fn unlisted_words(dialect: Dialect, source: &Source, settings: &Settings, found: &mut UnlistedWords<'_>) {
    let mut block = words::Block::default();
    let mut buffer = String::new();
    let mut at = Mark::START;
    while let Some(text) = text::block(source, at, &mut buffer) {
        let parsed = if dialect == Dialect::HeidenhainIso {
            din::parse(text.text, &mut block)
        } else {
            parser::parse(text.text, &mut block)
        };
        match parsed {
            Err(fault) => found.faults.push(text::locate(fault, source, at, text.text)),
            Ok(()) => {
                let key = match &block.statement {
                    words::Statement::Cycle { number, .. } if cycle_words::BUILDER.contains(number) => {
                        Some(format!("CYCL{number}"))
                    }
                    _ => None,
                };
                if let Some(key) = key.filter(|key| settings.control.words.name(key).is_none()) {
                    found.word(WordKey::Name(key), block.span, at, text.text, WordState::Unknown);
                }
                let named =
                    |axis: usize| settings.variables.contains_key(&format!("M92_{}", crate::AXIS_LETTERS[axis]));
                let machine = block.words.functions.iter().find(|m| m.code == 92);
                if let Some(m) = machine
                    && settings.control.words.m(92).is_none()
                    && (0..9).any(|axis| block.words.programmed >> axis & 1 == 1 && !named(axis))
                {
                    found.word(WordKey::M(92), m.span, at, text.text, WordState::NoDatum);
                }
                for m in &block.words.functions {
                    if let Some(now) = functions::unlisted_function(m, &settings.control) {
                        found.word(WordKey::M(m.code), m.span, at, text.text, now);
                    }
                }
            }
        }
        at = text.next;
    }
}

/// All faults of single blocks: grammar, and words that are refused in any context.
pub(crate) fn line_faults(dialect: Dialect, source: &Source, settings: &Settings) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    let mut block = words::Block::default();
    let mut buffer = String::new();
    let mut at = Mark::START;
    loop {
        let Some(found) = text::block(source, at, &mut buffer) else { return faults };
        let parsed = if dialect == Dialect::HeidenhainIso {
            din::parse(found.text, &mut block)
        } else {
            parser::parse(found.text, &mut block)
        };
        let functions = &block.words.functions;
        let refused = || functions.iter().filter_map(|m| functions::refused_function(m, &settings.control));
        let found_faults: Vec<_> = match parsed {
            Err(fault) => vec![fault],
            Ok(()) => refused().collect(),
        };
        faults.extend(found_faults.into_iter().map(|fault| text::locate(fault, source, at, found.text)));
        at = found.next;
    }
}
