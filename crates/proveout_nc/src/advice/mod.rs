//! The control file that lets a program be read, from the program itself.
//!
//! A text that its control does not read mostly lacks a few statements that an engineer would write into a
//! control file: what a builder's word means, the feed before the first F, how arc centers count, a missing
//! subprogram. [`Advice`] writes that file. Each statement is the most likely one, with its reason and with
//! how often the text needs it, and the file lists it under `[assumed]`: programs are then `program-assumed`
//! until somebody has confirmed it.
//!
//! ```text
//!   survey ─► faults, unknown words ─► candidates (proposals, arcs) ─► draft ─┐
//!     ▲                                                                       │
//!     └──────────── a statement stays when its fault is gone ◄── control file ┘
//! ```
//!
//! Nothing is taken on the word of a fault alone: every statement is tried on the text, and one whose fault
//! stays is dropped. In the end each statement is left out once; one that the text does not need goes too.
//! What no statement mends - a wrong word, an arc that closes under no convention, a text that is cut off -
//! stays refused and is listed as it is.
//!
//! [`draft`] is the file, [`proposals`] says what a fault or a word most likely needs, [`arcs`] tries
//! conventions of centers, [`whole_text`] looks at the text as a whole: its end, its head, tools in comments,
//! [`known_words`] is the table of builders' words with their sources.

mod arcs;
mod draft;
mod known_words;
mod proposals;
#[cfg(test)]
mod tests;
mod whole_text;

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::control::{Control, UnknownWord, UnknownWords};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::dialect::listed::WordState;
use crate::settings::{Dialect, Settings};
use crate::survey::Survey;
use crate::{Feed, Op};

use draft::Draft;
use proposals::Candidate;

/// Rounds of survey and proposals: each round can show faults that those before have hidden.
const MOST_ROUNDS: usize = 24;
/// Statements of a file; a text that needs more is one for another control.
const MOST_STATEMENTS: usize = 200;
/// Left faults that are shown.
const SHOWN_FAULTS: usize = 20;

/// What the reader needs in addition to the control file.
pub struct AdviceCall<'a> {
    /// Settings without that file.
    pub settings: Settings,
    /// Name or path of the control of these settings, from which the file inherits; none where none is named.
    pub inherits: Option<String>,
    /// Adds to the settings of a control what the call and the machine state.
    pub complete: &'a dyn Fn(Settings) -> Settings,
}

/// A statement of the control file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Advised {
    /// Path of the key: `words.M25`, `feed.missing_mm_min`.
    pub key: String,
    /// Its value as TOML, on one line.
    pub value: String,
    /// What it says, in words of the trade.
    pub meaning: String,
    /// Why it is the most likely one.
    pub why: String,
    /// How often the text needs it.
    pub count: u64,
    /// File and line of the first place, from 1.
    pub first: (String, u32),
    /// Text of that line.
    pub line: String,
}

/// What lets programs be read, and what does not.
#[derive(Clone, Debug)]
pub struct Advice {
    /// The language that was read.
    pub dialect: Dialect,
    /// Statements of the file, in its order.
    pub statements: Vec<Advised>,
    /// Words that do nothing and are named in notes.
    pub noted: Vec<UnknownWord>,
    /// Faults that no statement mends.
    pub left: Vec<Diagnostic>,
    file: String,
}

/// A program of the call.
enum Input {
    File(PathBuf),
    Text(String, String),
}

/// What one reading of all programs gave.
struct Trial {
    dialect: Dialect,
    faults: Vec<Diagnostic>,
    words: Vec<UnknownWord>,
    /// First feed of a program, mm/min.
    feed_mm_min: Option<f64>,
}

impl Advice {
    /// What lets these programs be read with one control file.
    ///
    /// # Errors
    /// A file cannot be read, or no line of it is that of an NC program.
    pub fn of_files(programs: &[PathBuf], call: &AdviceCall<'_>) -> Result<Self, Diagnostics> {
        Self::of(programs.iter().cloned().map(Input::File).collect(), call)
    }

    /// As [`Advice::of_files`], for a text in memory.
    ///
    /// # Errors
    /// No line of the text is that of an NC program.
    pub fn of_text(name: &str, text: &str, call: &AdviceCall<'_>) -> Result<Self, Diagnostics> {
        Self::of(vec![Input::Text(name.to_owned(), text.to_owned())], call)
    }

    /// The programs are read without a file.
    pub fn needs_nothing(&self) -> bool {
        self.statements.is_empty() && self.left.is_empty()
    }

    /// The programs are read with the file.
    pub fn reads(&self) -> bool {
        self.left.is_empty()
    }

    /// Text of the control file, ready to run.
    pub fn control_file(&self) -> &str {
        &self.file
    }

    fn of(inputs: Vec<Input>, call: &AdviceCall<'_>) -> Result<Self, Diagnostics> {
        let texts = texts(&inputs)?;
        let plain = trial(&inputs, &call.settings)?;
        let mut draft = Draft::new(call.inherits.clone(), plain.dialect);
        if plain.faults.is_empty() {
            return Ok(Self::put_together(&draft, plain));
        }
        let mut search = Search { inputs: &inputs, texts: &texts, call, refused: BTreeSet::new() };
        let mut at = plain;
        for _ in 0..MOST_ROUNDS {
            if at.faults.is_empty() {
                break;
            }
            match search.round(&mut draft, &at) {
                Some(next) => at = next,
                None => break,
            }
        }
        search.leave_out_unneeded(&mut draft, &mut at);
        Ok(Self::put_together(&draft, at))
    }

    fn put_together(draft: &Draft, at: Trial) -> Self {
        let noted = at.words.into_iter().filter(|word| word.state == WordState::Noted).collect();
        let file = draft.file(&at.faults);
        Self { dialect: at.dialect, statements: draft.statements.clone(), noted, left: at.faults, file }
    }
}

/// A way through the statements that a text may need.
struct Search<'a> {
    inputs: &'a [Input],
    texts: &'a [String],
    call: &'a AdviceCall<'a>,
    /// Statements that did not help, as `key = value`.
    refused: BTreeSet<String>,
}

impl Search<'_> {
    /// Tries what the faults ask for; none where nothing helps.
    fn round(&mut self, draft: &mut Draft, at: &Trial) -> Option<Trial> {
        let mut all = proposals::of_words(at);
        all.extend(at.faults.iter().flat_map(|fault| proposals::of_fault(fault, at, self.texts)));
        let (alone, together): (Vec<Candidate>, Vec<Candidate>) =
            proposals::joined(all).into_iter().partition(|candidate| candidate.rivals);
        let mut next = draft.clone();
        let mut added = Vec::new();
        for candidate in together {
            if self.is_open(&candidate, &next) {
                next = next.with(&candidate);
                added.push(candidate);
            }
        }
        // A word that keeps its meaning makes the whole file wrong: it goes.
        while self.settings(&next).is_none() && !added.is_empty() {
            let keys: Vec<String> = added.iter().map(|candidate| candidate.advised.key.clone()).collect();
            let wrong = keys.iter().position(|key| {
                let mut fewer = next.clone();
                fewer.statements.retain(|statement| statement.key != *key);
                self.settings(&fewer).is_some()
            });
            let candidate = added.remove(wrong.unwrap_or(added.len() - 1));
            next.statements.retain(|statement| statement.key != candidate.advised.key);
            self.refused.insert(candidate.text());
        }
        if !added.is_empty() && next.statements.len() <= MOST_STATEMENTS {
            let tried = self.trial(&next)?;
            let useless: Vec<&Candidate> = added.iter().filter(|c| !c.has_helped(at, &tried)).collect();
            if useless.len() < added.len() {
                self.refused.extend(useless.iter().map(|c| c.text()));
                let keys: Vec<String> = useless.iter().map(|c| c.advised.key.clone()).collect();
                if keys.is_empty() {
                    *draft = next;
                    return Some(tried);
                }
                let mut fewer = next.clone();
                fewer.statements.retain(|statement| !keys.contains(&statement.key));
                // Two statements of one cause belong together.
                let (kept, tried) = match self.trial(&fewer) {
                    Some(again) => (fewer, again),
                    None => (next, tried),
                };
                *draft = kept;
                return Some(tried);
            }
            self.refused.extend(added.iter().map(Candidate::text));
        }
        // Of statements that exclude each other the first one that mends all its faults.
        for candidate in alone {
            if !self.is_open(&candidate, draft) {
                continue;
            }
            let with = draft.with(&candidate);
            let tried = self.trial(&with).filter(|tried| candidate.has_helped(at, tried));
            match tried {
                Some(tried) => {
                    *draft = with;
                    return Some(tried);
                }
                None => {
                    self.refused.insert(candidate.text());
                }
            }
        }
        None
    }

    fn is_open(&self, candidate: &Candidate, draft: &Draft) -> bool {
        !self.refused.contains(&candidate.text()) && draft.statements.iter().all(|s| s.key != candidate.advised.key)
    }

    /// A statement that the text does not need goes: the fewer there are, the fewer have to be confirmed.
    fn leave_out_unneeded(&self, draft: &mut Draft, at: &mut Trial) {
        let mut place = 0;
        while place < draft.statements.len() {
            let mut fewer = draft.clone();
            fewer.statements.remove(place);
            match self.trial(&fewer) {
                Some(tried) if tried.faults.len() <= at.faults.len() => {
                    *draft = fewer;
                    *at = tried;
                }
                _ => place += 1,
            }
        }
    }

    /// Settings with the draft; none where it is no valid control file.
    fn settings(&self, draft: &Draft) -> Option<Settings> {
        let control = Control::from_text("the written control file", &draft.file(&[]), None).ok()?;
        Some(with_control(self.call, control))
    }

    fn trial(&self, draft: &Draft) -> Option<Trial> {
        if draft.statements.is_empty() {
            return trial(self.inputs, &self.call.settings).ok();
        }
        trial(self.inputs, &self.settings(draft)?).ok()
    }
}

fn with_control(call: &AdviceCall<'_>, control: Arc<Control>) -> Settings {
    (call.complete)(Settings::of_control(control))
}

/// Texts of the programs, for what is read out of comments and lines.
fn texts(inputs: &[Input]) -> Result<Vec<String>, Diagnostics> {
    let of = |input: &Input| -> Result<String, Diagnostics> {
        match input {
            Input::Text(_, text) => Ok(text.clone()),
            Input::File(path) => read(path),
        }
    };
    inputs.iter().map(of).collect()
}

fn read(path: &Path) -> Result<String, Diagnostics> {
    let source = crate::source::Source::read(path).map_err(|fault| Diagnostics::from(*fault))?;
    Ok(source.text.to_string())
}

/// Reads all programs.
fn trial(inputs: &[Input], settings: &Settings) -> Result<Trial, Diagnostics> {
    let mut all = Trial { dialect: settings.dialect, faults: Vec::new(), words: Vec::new(), feed_mm_min: None };
    for input in inputs {
        let mut feed = None;
        let mut look = |command: &crate::Command, _| {
            if let (Op::Feed(Feed::PerTime(mm_s)), None) = (&command.op, feed) {
                feed = Some(60.0 * mm_s);
            }
            None
        };
        let (survey, words) = match input {
            Input::File(path) => (Survey::of_file(path, settings, &mut look), UnknownWords::of_file(path, settings)),
            Input::Text(name, text) => (
                Survey::of_text(name, text.clone(), settings, &mut look),
                UnknownWords::of_text(name, text.clone(), settings),
            ),
        };
        if survey.dialect != Dialect::Auto {
            all.dialect = survey.dialect;
        }
        all.faults.extend(survey.judged());
        all.words.extend(words?.words);
        all.feed_mm_min = all.feed_mm_min.or(feed);
    }
    Ok(all)
}

impl fmt::Display for Advice {
    /// What keeps the text from running, each with its most likely meaning, as comments of a control file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.statements.is_empty() {
            let (these, are) = if self.statements.len() == 1 { ("statement", "is") } else { ("statements", "are") };
            writeln!(
                f,
                "# What keeps the text from running; {} {these} of a control file {are} most likely:",
                self.statements.len()
            )?;
        }
        for statement in &self.statements {
            writeln!(f, "#   {} = {}", statement.key, statement.value)?;
            writeln!(f, "#     {}: {}", statement.place(), statement.meaning)?;
            writeln!(f, "#     since {}", statement.why)?;
        }
        if !self.left.is_empty() {
            let faults = if self.left.len() == 1 { "fault" } else { "faults" };
            writeln!(f, "# No statement of a control file mends {} {faults}:", self.left.len())?;
        }
        for fault in self.left.iter().take(SHOWN_FAULTS) {
            writeln!(f, "#   {}", draft::one_line(&fault.to_string()))?;
        }
        if self.left.len() > SHOWN_FAULTS {
            writeln!(f, "#   and {} more", self.left.len() - SHOWN_FAULTS)?;
        }
        Ok(())
    }
}

impl Advised {
    /// How often and where.
    pub fn place(&self) -> String {
        let times = if self.count == 1 { "once".to_owned() } else { format!("{} times", self.count) };
        format!("{times}, first in line {} of {}", self.first.1, draft::one_line(&self.first.0))
    }
}
