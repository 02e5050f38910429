//! What a fault or an unknown word most likely needs.

use super::arcs::{self, is_of_arc};
use super::draft::quoted;
use super::known_words::{KnownWord, is_near_the_language, known_word};
use super::whole_text;
use super::{Advised, Trial};
use crate::codes;
use crate::control::UnknownWord;
use crate::diagnostic::{Diagnostic, FaultSubject};
use crate::dialect::listed::WordState;
use crate::settings::Dialect;

/// Feed for a text that has no F at all, mm/min: a number that had to be chosen. It is reported as an
/// assumption.
const CHOSEN_FEED_MM_MIN: f64 = 500.0;

/// A statement that may help.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) advised: Advised,
    cause: Cause,
    /// Others exclude it: each is tried by itself.
    pub(super) rivals: bool,
}

/// What must be gone for a statement to have helped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// The word is refused no more.
    Word(String),
    /// All faults of the shape of arcs.
    Arcs,
    /// Every fault about a value of this name.
    Variable(String),
    /// The fault of this code at this place.
    Fault(&'static str, String, u32),
}

impl Candidate {
    pub(super) fn new(advised: Advised, cause: Cause) -> Self {
        Self { advised, cause, rivals: false }
    }

    pub(super) fn rival(advised: Advised, cause: Cause) -> Self {
        Self { advised, cause, rivals: true }
    }

    /// Key and value.
    pub(super) fn text(&self) -> String {
        format!("{} = {}", self.advised.key, self.advised.value)
    }

    /// What it was proposed for is gone.
    pub(super) fn has_helped(&self, before: &Trial, now: &Trial) -> bool {
        match &self.cause {
            Cause::Word(word) => !now.words.iter().any(|w| w.word == *word && w.state != WordState::Noted),
            Cause::Arcs => before.faults.iter().any(is_of_arc) && !now.faults.iter().any(is_of_arc),
            Cause::Variable(name) => {
                let about = FaultSubject::Variable(name.clone());
                !now.faults.iter().any(|fault| fault.about.as_deref() == Some(&about))
            }
            Cause::Fault(code, file, line) => {
                !now.faults.iter().any(|f| f.code == *code && *f.file == **file && f.line == *line)
            }
        }
    }
}

/// Candidates with one key as one, in the order of the text; each counts how often it was proposed.
pub(super) fn joined(all: Vec<Candidate>) -> Vec<Candidate> {
    let mut list: Vec<Candidate> = Vec::new();
    for candidate in all {
        match list.iter_mut().find(|other| other.text() == candidate.text()) {
            Some(_) if candidate.rivals => {}
            Some(other) => other.advised.count += candidate.advised.count,
            None => list.push(candidate),
        }
    }
    list
}

/// A statement for a fault.
fn for_fault(fault: &Diagnostic, key: &str, value: String, meaning: &str, why: String) -> Candidate {
    let advised = Advised {
        key: key.to_owned(),
        value,
        meaning: meaning.to_owned(),
        why,
        count: 1,
        first: (fault.file.to_string(), fault.line),
        line: fault.source_line.to_string(),
    };
    Candidate::new(advised, Cause::Fault(fault.code, fault.file.to_string(), fault.line))
}

/// What a fault most likely needs, the likeliest first.
pub(super) fn of_fault(fault: &Diagnostic, at: &Trial, texts: &[String]) -> Vec<Candidate> {
    if let Some(FaultSubject::Variable(name)) = fault.about.as_deref() {
        let of_name = |candidate: Candidate| Candidate { cause: Cause::Variable(name.clone()), ..candidate };
        return variable(fault, name, texts).map(of_name).into_iter().collect();
    }
    match fault.code {
        codes::NO_FEED => vec![feed(fault, at), feed_policy(fault)],
        codes::SUBPROGRAM => subprogram(fault),
        codes::POSITION_UNKNOWN => start(fault, at.dialect),
        codes::NO_END => whole_text::end(fault, texts)
            .into_iter()
            .map(|(value, why)| for_fault(fault, "program.end", value, "the end of the text ends the program", why))
            .collect(),
        codes::SYNTAX | codes::UNKNOWN_WORD | codes::MISSING_VALUE | codes::STRUCTURE
            if matches!(at.dialect.family(), Dialect::Iso | Dialect::Siemens840d) =>
        {
            whole_text::frame(fault, texts)
                .into_iter()
                .map(|(key, value, why)| for_fault(fault, key, value, "the line is no block", why))
                .collect()
        }
        _ if is_of_arc(fault) => arcs::candidates(fault, at),
        _ => Vec::new(),
    }
}

fn feed(fault: &Diagnostic, at: &Trial) -> Candidate {
    let (value, why) = match at.feed_mm_min {
        Some(feed) => {
            let feed = (feed * 1e3).round() / 1e3;
            (feed, format!("motions in feed come before the first F, and the first F of the text is {feed} mm/min"))
        }
        None => (
            CHOSEN_FEED_MM_MIN,
            format!(
                "the text has no F at all: {CHOSEN_FEED_MM_MIN} mm/min is chosen, and times of the run say nothing"
            ),
        ),
    };
    for_fault(fault, "feed.missing_mm_min", format!("{value}"), "feed before the first F", why)
}

fn feed_policy(fault: &Diagnostic) -> Candidate {
    let why = "the control keeps the feed of the program before, or has one of its own".to_owned();
    for_fault(fault, "feed.missing", "\"value\"".to_owned(), "a motion before the first F runs at a stated feed", why)
}

fn subprogram(fault: &Diagnostic) -> Vec<Candidate> {
    let reason = "it was not given with the program";
    let why = "programs of the control, such as for probing and tool measuring, stay there".to_owned();
    vec![
        for_fault(
            fault,
            "subprograms.missing",
            "\"note\"".to_owned(),
            "a call of a missing subprogram is left out",
            why,
        ),
        for_fault(
            fault,
            "subprograms.missing_reason",
            quoted(reason),
            "why it may be left out; the verdict is unchecked",
            "the program calls it, and it is not in its folder".to_owned(),
        ),
    ]
}

fn start(fault: &Diagnostic, dialect: Dialect) -> Vec<Candidate> {
    let why =
        "the program goes on from where the axes stand; the zero of the work offset is the only place that its text \
               names"
            .to_owned();
    let meaning = "positions before the first block, in the work offset that is then in force";
    let linear = for_fault(fault, "start.position_mm", "{ X = 0, Y = 0, Z = 0 }".to_owned(), meaning, why.clone());
    let rotary = (dialect != Dialect::Apt)
        .then(|| for_fault(fault, "start.position_deg", "{ A = 0, B = 0, C = 0 }".to_owned(), meaning, why));
    std::iter::once(linear).chain(rotary).collect()
}

/// A value that the program reads and does not set.
fn variable(fault: &Diagnostic, name: &str, texts: &[String]) -> Option<Candidate> {
    let key = format!("variables.{name}");
    if matches!(name, "Q108" | "$P_TOOLR") {
        let radius = whole_text::tool_radius(texts)?;
        let why = format!("the text states one tool diameter, {} mm", 2.0 * radius);
        return Some(for_fault(fault, &key, format!("{radius}"), "radius of the tool", why));
    }
    let (meaning, why) = if name.starts_with("M92_") {
        (
            "the datum of the machine builder for M92, machine coordinate",
            "M92 refers to a datum that only the machine knows; posts use it for a safe place, and zero is home",
        )
    } else if name.starts_with("ID") || name.starts_with('$') {
        (
            "a value of the control that the program reads",
            "the program does not set it; zero is what a control gives that has no such data",
        )
    } else {
        (
            "a value that the control keeps",
            "the program reads it and does not set it; it is zero on a control that was just set up",
        )
    };
    Some(for_fault(fault, &key, "0.0".to_owned(), meaning, why.to_owned()))
}

/// Words that are refused and may mean something.
pub(super) fn of_words(at: &Trial) -> Vec<Candidate> {
    at.words.iter().filter(|word| word.state != WordState::Noted).filter_map(|word| of_word(word, at)).collect()
}

fn of_word(word: &UnknownWord, at: &Trial) -> Option<Candidate> {
    let advised = |(value, meaning, why): (String, String, String)| Advised {
        key: format!("words.{}", word.word),
        value,
        meaning,
        why,
        count: word.count,
        first: (word.first.0.clone(), word.first.1),
        line: word.line.clone(),
    };
    let known = known_word(at.dialect, &word.word).map(|known| of_table(known, word));
    let statement = match (known, word.state) {
        (Some(known), _) => known,
        (None, WordState::Unknown) => without_meaning(word, at.dialect)?,
        (None, _) => return None,
    };
    Some(Candidate::new(advised(statement), Cause::Word(word.word.clone())))
}

fn of_table(known: &KnownWord, word: &UnknownWord) -> (String, String, String) {
    let (key, text) = known.means;
    let value = format!("{{ {key} = {}{} }}", quoted(text), values(key, &own_letters(known.values, word)));
    (value, format!("{}: {text}", word.word), known.whose.to_owned())
}

fn own_letters(known: &str, word: &UnknownWord) -> String {
    known.chars().filter(|letter| word.letters.contains(*letter)).collect()
}

fn values(key: &str, letters: &str) -> String {
    let takes = matches!(key, "note" | "ignore" | "message") && !letters.is_empty();
    if takes { format!(", values = {}", quoted(letters)) } else { String::new() }
}

/// A statement for an unknown word. In blocks without an axis it switches something; with an axis it may be a
/// motion, and stays refused.
fn without_meaning(word: &UnknownWord, dialect: Dialect) -> Option<(String, String, String)> {
    let function = word.word.starts_with('M') && word.word[1..].bytes().all(|b| b.is_ascii_digit());
    let name = dialect.family() != Dialect::Iso && !word.word.starts_with('G');
    if word.moves && !function && !name {
        return None;
    }
    // A word of the language with a wrong letter, or a cycle of the language that the twin does not do.
    if !function && is_near_the_language(dialect, &word.word) {
        return None;
    }
    let text = "a function of the machine that is not looked up yet";
    let letters = if function || dialect.family() != Dialect::Iso { "" } else { word.letters.as_str() };
    let value = format!("{{ note = {}{} }}", quoted(text), values("note", letters));
    let why = if function {
        "M functions that no language defines are switches of the machine builder, and mostly move no axis of the program"
    } else if name {
        "names that no language defines are functions of the machine builder"
    } else {
        "it appears only in blocks without an axis: it sets something and moves nothing"
    };
    Some((value, format!("{}: {text}", word.word), why.to_owned()))
}
