//! From keys of a control file to lines and columns, and from what the TOML reader found to remedies.

use std::ops::Range;

use proveout_input::TomlFault;
use toml::de::DeTable;

use super::error::ControlFileError;

/// A control file's text with its syntax tree, to find the place of a key.
pub(super) struct ControlText<'a> {
    pub(super) file: &'a str,
    text: &'a str,
    tree: Option<DeTable<'a>>,
}

impl<'a> ControlText<'a> {
    pub(super) fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, text, tree: DeTable::parse(text).ok().map(toml::Spanned::into_inner) }
    }

    /// Span of the value at a path of keys; of the deepest part that exists where the key does not.
    fn span(&self, path: &[&str]) -> Range<usize> {
        let mut span = 0..0;
        let mut table = self.tree.as_ref();
        for key in path {
            let Some((name, value)) = table.and_then(|t| t.get_key_value(*key)) else { return span };
            // The span of a table can be all its lines: its name is the place to look at.
            span = if value.get_ref().is_table() { name.span() } else { value.span() };
            table = value.get_ref().as_table();
        }
        span
    }

    /// Paths of all keys with a value that is no table, outermost first; a word with its meaning counts as
    /// one.
    pub(super) fn paths(&self) -> Vec<String> {
        let mut list = Vec::new();
        let Some(tree) = &self.tree else { return list };
        for (key, value) in tree {
            let key = key.get_ref();
            match value.get_ref().as_table() {
                Some(inner) => list.extend(inner.keys().map(|name| format!("{key}.{}", name.get_ref()))),
                None => list.push(key.to_string()),
            }
        }
        list
    }

    fn place(&self, offset: usize) -> (usize, usize) {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// An error at a key.
    pub(super) fn error(
        &self,
        code: &'static str,
        path: &[&str],
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Box<ControlFileError> {
        let (line, column) = self.place(self.span(path).start);
        Box::new(ControlFileError {
            code,
            file: self.file.to_owned(),
            line,
            column,
            key: path.join("."),
            message: message.into(),
            remedy: remedy.into(),
        })
    }

    /// What the TOML reader found, with a remedy.
    pub(super) fn toml_error(&self, error: &toml::de::Error) -> Box<ControlFileError> {
        let span = error.span().unwrap_or(0..0);
        let (line, column) = self.place(span.start);
        let message = error.message().lines().next().unwrap_or_default().to_owned();
        let at = self.text.get(span).unwrap_or_default();
        let (code, key, remedy) = explain(&message, at);
        Box::new(ControlFileError { code, file: self.file.to_owned(), line, column, key, message, remedy })
    }
}

/// Code, key and remedy for a message of the TOML reader.
fn explain(message: &str, at: &str) -> (&'static str, String, String) {
    let fault = TomlFault::of(message);
    if let TomlFault::UnknownKey { key, known } = fault {
        let key = key.unwrap_or(at).to_owned();
        let units = known.iter().copied().filter(|k| k.strip_prefix(key.as_str()).is_some_and(|r| r.starts_with('_')));
        let units: Vec<&str> = units.collect();
        if !units.is_empty() {
            let remedy = format!("a key carries its unit: write {}", units.join(" or "));
            return ("control-unknown-key", key, remedy);
        }
        let remedy = nearest(&key, &known);
        return ("control-unknown-key", key, remedy);
    }
    if let TomlFault::UnknownWord { word, known } = fault {
        return ("control-unknown-value", word.unwrap_or(at).to_owned(), format!("write {}", known.join(" or ")));
    }
    let shown: String = at.lines().next().unwrap_or_default().chars().take(40).collect();
    ("control-syntax", shown, "correct the TOML at this place".to_owned())
}

/// `did you mean x?`, or all of them.
pub(super) fn nearest(name: &str, known: &[&str]) -> String {
    // Of two as near as each other the one that begins alike.
    let alike = |k: &str| name.bytes().zip(k.bytes()).take_while(|(a, b)| a == b).count();
    match known.iter().min_by_key(|k| (strsim::levenshtein(name, k), std::cmp::Reverse(alike(k)))) {
        Some(k) if strsim::levenshtein(name, k) <= name.len().max(k.len()) / 3 + 1 => format!("did you mean {k}?"),
        _ => format!("known here: {}", known.join(", ")),
    }
}
