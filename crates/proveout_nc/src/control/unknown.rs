//! The words of a program that its control has no meaning for, as a table for a control file.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;

use super::words::{WordKey, word_key};
use crate::channel::doubt::Doubt;
use crate::codes;
use crate::diagnostic::{Diagnostic, Diagnostics, FaultSubject};
use crate::dialect::listed::{UnlistedWords, WordState};
use crate::dialect::{self};
use crate::program::Program;
use crate::settings::{Dialect, Settings};

/// Lines that cannot be read of which the table shows the place.
const SHOWN_LINES: usize = 5;
/// Letters whose values often belong to a word of the machine builder: no axes, feeds, speeds and tools.
const OWN_LETTERS: &str = "PQELRDHJIK";
/// Limit of faults after which the run goes on to find further names.
const MOST_FAULTS: u32 = 200_000;

/// A word of a program that its control has no meaning for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownWord {
    /// As a control file lists it: `M25`, `G38.2`, `CYCLE999`.
    pub word: String,
    /// Places in the text.
    pub count: u64,
    /// File, line and column of the first one, from 1.
    pub first: (String, u32, u32),
    /// Text of its line.
    pub line: String,
    /// What the reader does with it now.
    pub now: &'static str,
    /// What that is, for those who decide by it.
    pub(crate) state: WordState,
    /// Letters of its blocks that may belong to it, and are no axes.
    pub(crate) letters: String,
    /// One of its blocks has a word of an axis.
    pub(crate) moves: bool,
}

/// All of them, in the order of G words, M words and names, and what of the text cannot be read at all.
///
/// Displayed as text it is a TOML table that can be copied into a control file unchanged: every
/// word is refused until its meaning is entered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownWords {
    /// Name of the control; empty where none is named.
    pub control: String,
    /// The language that was read.
    pub dialect: Dialect,
    /// The words.
    pub words: Vec<UnknownWord>,
    /// Lines whose grammar cannot be read: words in them are not among the others.
    pub unreadable: Vec<Diagnostic>,
}

impl UnknownWords {
    /// Looks through a program file and the subprograms that its run reaches.
    ///
    /// # Errors
    /// The file cannot be read, or its dialect is not known.
    pub fn of_file(path: impl AsRef<Path>, settings: &Settings) -> Result<Self, Diagnostics> {
        Ok(Self::of(Program::open_leniently(path.as_ref(), settings)?, settings))
    }

    /// As [`UnknownWords::of_file`], for a text in memory.
    ///
    /// # Errors
    /// The dialect is not known.
    pub fn of_text(name: &str, text: impl Into<String>, settings: &Settings) -> Result<Self, Diagnostics> {
        Ok(Self::of(Program::text_leniently(name, text.into(), settings)?, settings))
    }

    fn of(mut program: Program, settings: &Settings) -> Self {
        let mut found: BTreeMap<WordKey, UnknownWord> = BTreeMap::new();
        let mut places: BTreeSet<(String, u32, u32)> = BTreeSet::new();
        let mut faults = 0;
        // Names that are no subprogram either are known only where they are run.
        loop {
            match program.next() {
                None => break,
                Some(Ok(_)) => {}
                Some(Err(fault)) => {
                    if let Some(key) = name_of(&fault, program.dialect())
                        && places.insert((fault.file.to_string(), fault.line, fault.column))
                    {
                        let first = (fault.file.to_string(), fault.line, fault.column);
                        put(&mut found, key, first, &fault.source_line, WordState::Unknown);
                    }
                    faults += 1;
                    if faults > MOST_FAULTS || !program.recover() {
                        break;
                    }
                }
            }
        }
        let mut unreadable = Vec::new();
        for source in program.sources() {
            let mut unlisted = UnlistedWords::new(source);
            dialect::unlisted_words(program.dialect(), source, settings, &mut unlisted);
            for (key, column, line, text, now) in unlisted.words {
                let first = (source.name.to_string(), line, column);
                if places.insert(first.clone()) {
                    put(&mut found, key, first, &text, now);
                }
            }
            unreadable.extend(unlisted.faults);
        }
        Self {
            control: settings.control.name().to_owned(),
            dialect: program.dialect(),
            words: found.into_values().collect(),
            unreadable,
        }
    }
}

/// The name that a fault calls unknown.
fn name_of(fault: &Diagnostic, dialect: Dialect) -> Option<WordKey> {
    if fault.code != codes::UNKNOWN_WORD || dialect != Dialect::Siemens840d {
        return None;
    }
    let Some(FaultSubject::UnknownWord(name)) = fault.about.as_deref() else { return None };
    word_key(name).filter(|key| matches!(key, WordKey::Name(_)))
}

fn put(
    found: &mut BTreeMap<WordKey, UnknownWord>,
    key: WordKey,
    first: (String, u32, u32),
    line: &str,
    state: WordState,
) {
    let word = key.to_string();
    let entry = found.entry(key).or_insert_with(|| UnknownWord {
        word,
        count: 0,
        first: first.clone(),
        line: line.trim().to_owned(),
        now: state.text(),
        state,
        letters: String::new(),
        moves: false,
    });
    entry.count += 1;
    entry.moves |= Doubt::of_text(line).axes != 0;
    for letter in letters(line).filter(|letter| OWN_LETTERS.contains(*letter)) {
        if !entry.letters.contains(letter) {
            entry.letters.push(letter);
        }
    }
    if first < entry.first {
        entry.first = first;
        entry.line = line.trim().to_owned();
    }
}

/// Letters that begin a word of a block, without its comments.
fn letters(line: &str) -> impl Iterator<Item = char> {
    let code: String = line.split(['(', ';']).next().unwrap_or_default().to_ascii_uppercase();
    let bytes: Vec<char> = code.chars().collect();
    let single = |at: usize| {
        let alone = at == 0 || !bytes[at - 1].is_ascii_alphabetic();
        alone && bytes[at].is_ascii_uppercase() && bytes.get(at + 1).is_none_or(|c| !c.is_ascii_alphabetic())
    };
    (0..bytes.len()).filter(|at| single(*at)).map(|at| bytes[at]).collect::<Vec<_>>().into_iter()
}

impl fmt::Display for UnknownWords {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reader = if self.control.is_empty() {
            format!("the {} reader", self.dialect.name())
        } else {
            format!("the control \"{}\"", self.control)
        };
        if self.words.is_empty() {
            writeln!(f, "# {reader} has a meaning for every word.")?;
        } else {
            writeln!(
                f,
                "# Words that {reader} has no meaning for. Each stays refused until `refuse` is replaced by one of"
            )?;
            writeln!(f, "# does, kinematics, call, macro, message, note, ignore (docs/controls.md).")?;
        }
        for UnknownWord { word, count, first: (file, line, column), line: text, now, .. } in &self.words {
            let times = if *count == 1 { "once".to_owned() } else { format!("{count} times, first") };
            let key = if word.contains('.') { format!("\"{word}\"") } else { word.clone() };
            let shown: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(100).collect();
            writeln!(f, "\n# {times} in {}:{line}:{column} ({now}): {shown}", one_line(file))?;
            writeln!(f, "[words.{key}]\nrefuse = \"not looked up yet\"")?;
        }
        if !self.unreadable.is_empty() {
            writeln!(f, "\n# {} lines cannot be read, and words in them are not listed:", self.unreadable.len())?;
            for fault in self.unreadable.iter().take(SHOWN_LINES) {
                writeln!(f, "# {}", one_line(&fault.to_string()))?;
            }
        }
        Ok(())
    }
}

/// A text that stays within its comment.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
