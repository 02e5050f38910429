//! Files with old keys: the same text with new ones.
//!
//! Only the bytes of the keys change, so that comments, order, blanks and line ends stay. The parser reports
//! every key where it is written; its path is that of the table header, then the tables inline and the dots
//! of the key itself:
//!
//! ```text
//! [program.mount]      header:  program, mount            key 'chosen' below  program, mount
//! chosen = true
//! mount.chosen = true                                     key 'chosen' below  mount
//! mount = { chosen = true }                               key 'chosen' below  mount
//! ```

use std::{ops::Range, path::Path};

use toml::de::DeTable;
use toml_parser::{
    ErrorSink, Raw, Source, Span,
    decoder::Encoding,
    parser::{EventReceiver, parse_document},
};

use crate::{
    InputError,
    renamed_keys::{InputFileKind, new_dotted_key, new_name},
};

/// A file with the keys of today.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Migration {
    /// What the file is.
    pub kind: InputFileKind,
    /// The text; that of the file where nothing has changed.
    pub text: String,
    /// What has changed, in the order of the text.
    pub changes: Vec<KeyChange>,
}

/// A key with a new name, or a value that names one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyChange {
    /// Line, from 1.
    pub line: usize,
    /// The key with the tables above it, as in the file.
    pub old: String,
    /// The same with its new name.
    pub new: String,
}

/// Gives old keys of a scene, machine, tool library, control file, job or sweep their names of today.
///
/// ```
/// use proveout_input::migrate;
///
/// let old = "resolution_mm = 1\n[limits] # of a run\nblocks = 9\n";
/// let scene = migrate(std::path::Path::new("scene.toml"), old)?;
/// assert_eq!(scene.text, "resolution_mm = 1\n[run_limits] # of a run\nblocks = 9\n");
/// assert_eq!((scene.changes[0].line, scene.changes[0].new.as_str()), (2, "run_limits"));
/// # Ok::<(), proveout_input::InputError>(())
/// ```
///
/// # Errors
/// [`InputError`] where the text is not TOML, is none of these files, or holds a key by its old and its new
/// name.
pub fn migrate(file: &Path, text: &str) -> Result<Migration, InputError> {
    let tree = DeTable::parse(text).map_err(|e| {
        let message = format!("the text is not TOML: {}", e.message().lines().next().unwrap_or_default());
        InputError::file(file, message, "name a file in TOML").with_span(text, &e.span().unwrap_or(0..0))
    })?;
    let keys: Vec<&str> = tree.get_ref().keys().map(|key| &**key.get_ref()).collect();
    let kind = InputFileKind::of_keys(&keys).ok_or_else(|| {
        let message = "is no scene, machine, tool library, control file, job or sweep";
        InputError::file(file, message, "name one of these files")
    })?;
    let mut walk =
        KeyWalk { text, kind, header: false, dotted: false, tables: vec![OpenTable::default()], edits: vec![] };
    let tokens = Source::new(text).lex().into_vec();
    // The text is TOML: there is no error to report, and nesting is bounded.
    parse_document(&tokens, &mut walk, &mut ());
    let edits = walk.edits;
    let mut out = String::with_capacity(text.len() + 16 * edits.len());
    let mut from = 0;
    for edit in &edits {
        out.push_str(text.get(from..edit.span.start).unwrap_or_default());
        out.push_str(&edit.there);
        from = edit.span.end;
    }
    out.push_str(text.get(from..).unwrap_or_default());
    if let Err(e) = DeTable::parse(&out) {
        let span = e.span().unwrap_or(0..0);
        let message = "a key is there by its old name and by its new one";
        return Err(InputError::file(file, message, "remove one of them").with_span(&out, &span));
    }
    let (mut line, mut counted) = (1, 0);
    let changes = edits.into_iter().map(|edit| {
        line += text.get(counted..edit.span.start).unwrap_or_default().matches('\n').count();
        counted = edit.span.start;
        KeyChange { line, old: edit.old, new: edit.new }
    });
    Ok(Migration { kind, changes: changes.collect(), text: out })
}

/// New text for bytes of the file.
struct Edit {
    span: Range<usize>,
    there: String,
    /// What people are told.
    old: String,
    new: String,
}

/// A table whose keys are being read.
#[derive(Default)]
struct OpenTable {
    path: Vec<String>,
    /// The key that was read last, with its dots.
    key: Vec<String>,
}

/// Follows the keys of a text.
struct KeyWalk<'a> {
    text: &'a str,
    kind: InputFileKind,
    /// Between the brackets of a header.
    header: bool,
    /// A dot is before the next part of a key.
    dotted: bool,
    /// The table of the header, then the inline tables that are open.
    tables: Vec<OpenTable>,
    edits: Vec<Edit>,
}

impl<'a> KeyWalk<'a> {
    fn open_header(&mut self) {
        self.header = true;
        self.tables = vec![OpenTable::default()];
    }

    fn close_header(&mut self) {
        self.header = false;
        self.dotted = false;
    }

    fn written(&self, span: Span) -> &'a str {
        self.text.get(span.start()..span.end()).unwrap_or_default()
    }

    fn key(&mut self, span: Span, encoding: Option<Encoding>) {
        let mut name = String::new();
        Raw::new_unchecked(self.written(span), encoding, span).decode_key(&mut name, &mut ());
        let follows = std::mem::take(&mut self.dotted);
        let Some(table) = self.tables.last_mut() else { return };
        if !self.header && !follows {
            table.key.clear();
        }
        let mut tables = table.path.clone();
        tables.extend(table.key.iter().cloned());
        let path = if self.header { &mut table.path } else { &mut table.key };
        path.push(name.clone());
        let Some(new) = new_name(self.kind, &tables, &name) else { return };
        // A key in quotes keeps them, unless it is written in escapes.
        let written = self.written(span);
        let there = if written.contains(&name) { written.replace(&name, &new) } else { new.clone() };
        let shown = |last: &str| tables.iter().map(String::as_str).chain([last]).collect::<Vec<_>>().join(".");
        let (old, new) = (shown(&name), shown(&new));
        self.edits.push(Edit { span: span.start()..span.end(), there, old, new });
    }

    /// A value that names a key.
    fn value(&mut self, span: Span, encoding: Option<Encoding>) {
        let Some(table) = self.tables.last() else { return };
        let path: Vec<&str> = table.path.iter().chain(&table.key).map(String::as_str).collect();
        let names_a_key = match self.kind {
            InputFileKind::Sweep => path == ["vary", "key"],
            InputFileKind::Scene => path == ["compare", "choice", "key"],
            _ => false,
        };
        if !names_a_key || !matches!(encoding, Some(Encoding::BasicString | Encoding::LiteralString)) {
            return;
        }
        let written = self.written(span);
        let Some(old) = written.get(1..written.len().saturating_sub(1)) else { return };
        let Some(new) = new_dotted_key(old) else { return };
        let there = written.replace(old, &new);
        let (old, new) = (written.to_owned(), there.clone());
        self.edits.push(Edit { span: span.start()..span.end(), there, old, new });
    }
}

impl EventReceiver for KeyWalk<'_> {
    fn std_table_open(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.open_header();
    }

    fn std_table_close(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.close_header();
    }

    fn array_table_open(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.open_header();
    }

    fn array_table_close(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.close_header();
    }

    fn inline_table_open(&mut self, _span: Span, _error: &mut dyn ErrorSink) -> bool {
        let outer = self.tables.last();
        let path = outer.map_or_else(Vec::new, |t| t.path.iter().chain(&t.key).cloned().collect());
        self.tables.push(OpenTable { path, key: Vec::new() });
        true
    }

    fn inline_table_close(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.tables.pop();
    }

    fn simple_key(&mut self, span: Span, encoding: Option<Encoding>, _error: &mut dyn ErrorSink) {
        self.key(span, encoding);
    }

    fn key_sep(&mut self, _span: Span, _error: &mut dyn ErrorSink) {
        self.dotted = true;
    }

    fn scalar(&mut self, span: Span, encoding: Option<Encoding>, _error: &mut dyn ErrorSink) {
        self.value(span, encoding);
    }
}

#[cfg(test)]
mod tests;
