//! What can be wrong with a program text, with its place and the remedy.

use std::fmt;
use std::sync::Arc;

use miette::{LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use crate::{Location, codes};

/// One thing that is wrong with a program.
///
/// Implements [`miette::Diagnostic`]: its source is the one line concerned, numbered as in the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {message}")]
pub struct Diagnostic {
    /// Stable code, one of [`crate::CODES`].
    pub code: &'static str,
    /// One sentence with the word, the value and the limit.
    pub message: String,
    /// File as given by the caller.
    pub file: Arc<str>,
    /// Line, from 1; 0 where the file could not be read at all.
    pub line: u32,
    /// Column of the first character concerned, from 1.
    pub column: u32,
    /// Length in characters.
    pub length: u32,
    /// What to do about it.
    pub help: Option<String>,
    /// Text of the line.
    pub source_line: Box<str>,
    /// What the reader asks of it again.
    pub(crate) about: Option<Box<FaultSubject>>,
}

/// What a fault is about, where its code does not say it all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FaultSubject {
    /// A word that the reader does not know.
    UnknownWord(String),
    /// A system variable that holds a position of an axis.
    PositionVariable,
    /// A value that the program reads and does not set, by the name under which it can be given.
    Variable(String),
    /// An arc whose radii at start and end differ, nanometers: whole numbers, so that faults can be compared.
    ArcRadii { start_nm: u64, end_nm: u64 },
}

impl Diagnostic {
    /// What is wrong at a place of a command, without the text of its line.
    pub fn at(location: &Location, code: &'static str, message: String, help: String) -> Self {
        Self {
            code,
            message,
            file: Arc::clone(&location.file),
            line: location.line,
            column: location.column,
            length: location.length,
            help: Some(help),
            source_line: Box::default(),
            about: None,
        }
    }
}

impl miette::Diagnostic for Diagnostic {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.code))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|h| Box::new(h) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        (self.line > 0).then_some(self as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        if self.line == 0 {
            return None;
        }
        let bytes_of = |chars: u32| {
            self.source_line.char_indices().nth(chars as usize).map_or(self.source_line.len(), |(at, _)| at)
        };
        let start = bytes_of(self.column.saturating_sub(1));
        let end = bytes_of((self.column + self.length).saturating_sub(1)).max(start);
        Some(Box::new(std::iter::once(LabeledSpan::new(Some("here".to_owned()), start, end - start))))
    }
}

/// The line of the diagnostic as a source of its own that knows its number in the file.
impl SourceCode for Diagnostic {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = (*self.source_line).read_span(span, before, after)?;
        let first_line = (self.line as usize).saturating_sub(1);
        Ok(Box::new(MietteSpanContents::new_named(
            self.file.to_string(),
            inner.data(),
            *inner.span(),
            inner.line() + first_line,
            inner.column(),
            inner.line_count(),
        )))
    }
}

/// All that was found wrong with a program; never empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.0.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{diagnostic}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

impl miette::Diagnostic for Diagnostics {
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn miette::Diagnostic> + 'a>> {
        Some(Box::new(self.0.iter().map(|d| d as &dyn miette::Diagnostic)))
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

/// Bytes of a line, from its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) start: u32,
    pub(crate) end: u32,
}

impl Span {
    pub(crate) fn new(start: usize, end: usize) -> Self {
        Self { start: start as u32, end: end.max(start) as u32 }
    }
}

/// A word that the control knows and the reader does not do.
pub(crate) fn refused(word: &str, span: Span, remedy: &str) -> Fault {
    Fault::new(codes::UNSUPPORTED_WORD, span, format!("`{word}` is not supported")).help(remedy)
}

/// A word that a block can have once.
pub(crate) fn twice(word: impl fmt::Display, span: Span) -> Fault {
    Fault::new(codes::CONFLICT, span, format!("`{word}` appears twice in the block")).help("remove one")
}

/// How a person gives a value that a program reads and does not set.
pub(crate) fn give(name: &str) -> String {
    format!("give \"{name}\" with --variable, or under [variables] of the control file")
}

/// A diagnostic before it knows its file and line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) code: &'static str,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
    pub(crate) span: Span,
    pub(crate) about: Option<FaultSubject>,
}

impl Fault {
    pub(crate) fn new(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), help: None, span, about: None }
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The fault of a value that is not known; it can be given under this name.
    pub(crate) fn of_variable(self, name: impl Into<String>) -> Self {
        self.about(Some(FaultSubject::Variable(name.into())))
    }

    pub(crate) fn about(mut self, subject: Option<FaultSubject>) -> Self {
        self.about = subject;
        self
    }

    /// Places the fault in a line of a file.
    pub(crate) fn at(self, file: &Arc<str>, line_number: u32, line: &str) -> Diagnostic {
        let (column, length) = column_and_length(line, self.span);
        Diagnostic {
            code: self.code,
            message: self.message,
            file: Arc::clone(file),
            line: line_number,
            column,
            length,
            help: self.help,
            source_line: line.into(),
            about: self.about.map(Box::new),
        }
    }
}

/// Column from 1 and length, both in characters, of a byte span of a line.
pub(crate) fn column_and_length(line: &str, span: Span) -> (u32, u32) {
    if line.is_ascii() {
        let length = line.len() as u32;
        let (start, end) = (span.start.min(length), span.end.min(length));
        return (start + 1, end.max(start) - start);
    }
    let floor = |at: u32| {
        let mut at = (at as usize).min(line.len());
        while !line.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let (start, end) = (floor(span.start), floor(span.end));
    let count = |text: &str| if text.is_ascii() { text.len() } else { text.chars().count() } as u32;
    (count(&line[..start]) + 1, count(&line[start..end.max(start)]))
}
