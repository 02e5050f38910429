//! Words that a control file lists, as far as all languages do the same with them.

use std::sync::Arc;

use crate::codes;
use crate::control::Control;
use crate::control::words::WordKey;
use crate::diagnostic::{Diagnostic, Fault, FaultSubject, Span, column_and_length};
use crate::not_run::{NotRun, NotRunKind};
use crate::settings::Settings;
use crate::source::{Mark, Source};

/// A word that the control file refuses.
pub(crate) fn refused_by(control: &Control, word: &str, span: Span, remedy: &str) -> Fault {
    Fault::new(codes::UNSUPPORTED_WORD, span, format!("`{word}` is refused by the control \"{}\"", control.name))
        .help(remedy)
}

/// An M word that neither the reader nor the control file knows.
pub(crate) fn unlisted(control: &Control, word: &str, span: Span) -> Fault {
    let message = format!("unknown word `{word}`: the control \"{}\" does not list it", control.name);
    Fault::new(codes::UNKNOWN_WORD, span, message)
        .help("give the word a meaning in the control file")
        .about(Some(FaultSubject::UnknownWord(word.to_owned())))
}

/// What a word does that is without effect, for its one note.
pub(crate) fn ignored(control: &Control, word: &str, reason: &str) -> String {
    format!("{word} is without effect on the control \"{}\": {reason}", control.name)
}

/// A subprogram that is not there, where the control or the call says that it may be left out.
pub(crate) fn left_out(settings: &Settings, name: &str) -> Option<String> {
    let reason = settings.missing_subprogram.as_deref()?;
    let control = &settings.control;
    let who = if control.missing_subprogram.as_deref() == Some(reason) {
        format!("the control \"{}\" says", control.name)
    } else {
        "the call of the reader says".to_owned()
    };
    Some(format!("the subprogram {name} is not there and is left out, as {who}: {reason}"))
}

/// The call of a subprogram that was left out.
pub(crate) fn call_not_run(source: &Source, line: u32, name: &str) -> NotRun {
    NotRun {
        file: Arc::clone(&source.name),
        lines: [line; 2],
        kind: NotRunKind::MissingSubprogram(name.to_owned()),
        moves: true,
        text: source.text_of(line).unwrap_or_default().to_owned(),
    }
}

/// Reads the lines of a file one by one; `take` receives what each one is.
pub(crate) fn each_line<B: Default>(
    source: &Source,
    parse: impl Fn(&str, &mut B) -> Result<(), Fault>,
    mut take: impl FnMut(Mark, &str, Result<&B, Fault>),
) {
    let (mut block, mut at) = (B::default(), Mark::START);
    while let Some((line, next)) = source.line(at) {
        let parsed = parse(line, &mut block);
        take(at, line, parsed.map(|()| &block));
        at = next;
    }
}

/// What a reader does with a word that its control has no meaning for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WordState {
    /// It is named in a note and does nothing.
    Noted,
    /// It is refused, since nothing says what it means.
    Unknown,
    /// It is refused: the twin does not do what it means.
    NotSupported,
    /// It is refused: it needs a datum that nothing states.
    NoDatum,
}

impl WordState {
    /// For the list of unknown words.
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Noted => "a note, without effect",
            Self::Unknown => "refused: unknown",
            Self::NotSupported => "refused: not supported",
            Self::NoDatum => "refused: its datum is not stated",
        }
    }
}

/// Words of a file that the control has no meaning for, and lines that cannot be read.
#[derive(Debug)]
pub(crate) struct UnlistedWords<'a> {
    source: &'a Source,
    /// Word, column, line, text of the line, and what the reader does with it.
    pub(crate) words: Vec<(WordKey, u32, u32, String, WordState)>,
    pub(crate) faults: Vec<Diagnostic>,
}

impl<'a> UnlistedWords<'a> {
    pub(crate) fn new(source: &'a Source) -> Self {
        Self { source, words: Vec::new(), faults: Vec::new() }
    }

    pub(crate) fn word(&mut self, key: WordKey, span: Span, at: Mark, line: &str, now: WordState) {
        self.words.push((key, column_and_length(line, span).0, at.line, line.to_owned(), now));
    }

    /// Passes on the words of a block, each with what the reader does with it.
    pub(crate) fn block(
        &mut self,
        at: Mark,
        line: &str,
        words: Result<impl Iterator<Item = (WordKey, Span, WordState)>, Fault>,
    ) {
        match words {
            Err(fault) => self.fault(fault, at, line),
            Ok(words) => words.for_each(|(key, span, now)| self.word(key, span, at, line, now)),
        }
    }

    pub(crate) fn fault(&mut self, fault: Fault, at: Mark, line: &str) {
        self.faults.push(fault.at(&self.source.name, at.line, line));
    }
}
