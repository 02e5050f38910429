//! From keys of a machine file to lines and columns, and from the TOML reader's messages to remedies.

use std::{ops::Range, path::Path};

use proveout_geom::OutOfRange;
use toml::de::{DeTable, DeValue};

use crate::error::ContentError;

/// One step on the way to a value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Step<'a> {
    Key(&'a str),
    Item(usize),
}

/// A machine file's text with its syntax tree, to find the place of a key.
pub(crate) struct Source<'a> {
    pub(crate) file: &'a Path,
    text: &'a str,
    tree: Option<DeTable<'a>>,
}

impl<'a> Source<'a> {
    pub(crate) fn new(file: &'a Path, text: &'a str) -> Self {
        let tree = DeTable::parse(text).ok().map(toml::Spanned::into_inner);
        Self { file, text, tree }
    }

    /// Span of a key's value; of the deepest part that exists when the key does not.
    fn span(&self, path: &[Step<'_>]) -> Range<usize> {
        let mut span = 0..0;
        let Some(mut table) = self.tree.as_ref() else { return span };
        let mut steps = path.iter();
        let mut value: Option<&DeValue<'_>> = None;
        loop {
            match (steps.next(), value) {
                (Some(Step::Key(key)), _) => {
                    if let Some(v) = value {
                        let Some(inner) = v.as_table() else { return span };
                        table = inner;
                    }
                    let Some((name, v)) = table.get_key_value(*key) else { return span };
                    let inner = v.get_ref();
                    // A table's own span can be all its lines: its name is the place to look at.
                    span = if inner.is_table() || inner.is_array() && v.span().is_empty() {
                        name.span()
                    } else {
                        v.span()
                    };
                    value = Some(inner);
                }
                (Some(Step::Item(index)), Some(v)) => {
                    let Some(item) = v.as_array().and_then(|a| a.get(*index)) else { return span };
                    span = item.span();
                    value = Some(item.get_ref());
                }
                _ => return span,
            }
        }
    }

    /// Line and column, both from 1, of a byte offset.
    pub(crate) fn place(&self, offset: usize) -> (usize, usize) {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// Name of a step's table for people: its `name` where it has one.
    fn key_text(&self, path: &[Step<'_>]) -> String {
        let mut text = String::new();
        for (i, step) in path.iter().enumerate() {
            match step {
                Step::Key(key) => {
                    if i > 0 {
                        text.push('.');
                    }
                    text.push_str(key);
                }
                Step::Item(index) => {
                    let named = self.value(&path[..=i]).and_then(DeValue::as_table);
                    match named.and_then(|t| t.get("name")).and_then(|n| n.get_ref().as_str()) {
                        Some(name) => {
                            text.push('.');
                            text.push_str(name);
                        }
                        None => text.push_str(&format!("[{index}]")),
                    }
                }
            }
        }
        text
    }

    fn value(&self, path: &[Step<'_>]) -> Option<&DeValue<'a>> {
        let mut steps = path.iter();
        let Some(Step::Key(first)) = steps.next() else { return None };
        let mut value = self.tree.as_ref()?.get(*first)?.get_ref();
        for step in steps {
            value = match step {
                Step::Key(key) => value.as_table()?.get(*key)?.get_ref(),
                Step::Item(index) => value.as_array()?.get(*index)?.get_ref(),
            };
        }
        Some(value)
    }

    /// True when there is a value at the path.
    pub(crate) fn has(&self, path: &[Step<'_>]) -> bool {
        self.value(path).is_some()
    }

    /// The tree of all keys, if the text is TOML.
    pub(crate) fn tree(&self) -> Option<&DeTable<'a>> {
        self.tree.as_ref()
    }

    /// Keys of the table at a path.
    pub(crate) fn keys(&self, path: &[Step<'_>]) -> Vec<String> {
        let table = self.value(path).and_then(DeValue::as_table);
        table.map_or_else(Vec::new, |t| t.keys().map(|k| k.get_ref().to_string()).collect())
    }

    /// An error at a key.
    pub(crate) fn error(
        &self,
        code: &'static str,
        path: &[Step<'_>],
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Box<ContentError> {
        let (line, column) = self.place(self.span(path).start);
        Box::new(ContentError {
            code,
            file: self.file.into(),
            line,
            column,
            key: self.key_text(path),
            message: message.into(),
            remedy: remedy.into(),
        })
    }

    /// A number that no machine has.
    pub(crate) fn out_of_range(&self, fault: &OutOfRange) -> Box<ContentError> {
        let (line, column) = self.place(fault.span.start);
        Box::new(ContentError {
            code: "machine-out-of-range",
            file: self.file.into(),
            line,
            column,
            key: fault.key.clone(),
            message: fault.to_string(),
            remedy: OutOfRange::REMEDY.into(),
        })
    }

    /// What the TOML reader found, with a remedy.
    pub(crate) fn toml_error(&self, error: &toml::de::Error) -> Box<ContentError> {
        let span = error.span().unwrap_or(0..0);
        let (line, column) = self.place(span.start);
        let message = error.message().lines().next().unwrap_or_default().to_owned();
        let (code, key, remedy) = explain(&message, self.text.get(span).unwrap_or_default());
        Box::new(ContentError { code, file: self.file.into(), line, column, key, message, remedy })
    }
}

/// Code, key and remedy for a message of the TOML reader; the names in back quotes are the key and its alternatives.
fn explain(message: &str, at: &str) -> (&'static str, String, String) {
    let mut quoted = message.split('`').skip(1).step_by(2);
    if message.starts_with("unknown field") {
        let key = quoted.next().unwrap_or(at).to_owned();
        let known: Vec<&str> = quoted.collect();
        let with_unit: Vec<&str> = known
            .iter()
            .copied()
            .filter(|k| k.strip_prefix(key.as_str()).is_some_and(|r| r.starts_with('_')))
            .collect();
        if !with_unit.is_empty() {
            let remedy = format!("a key carries its unit: write {}", with_unit.join(" or "));
            return ("machine-unit-missing", key, remedy);
        }
        let nearest = known.iter().min_by_key(|k| strsim::levenshtein(&key, k));
        let remedy = match nearest {
            Some(k) if strsim::levenshtein(&key, k) <= key.len().max(k.len()) / 3 + 1 => format!("did you mean {k}?"),
            _ => format!("known keys here: {}", known.join(", ")),
        };
        return ("machine-unknown-key", key, remedy);
    }
    if message.starts_with("missing field") {
        let key = quoted.next().unwrap_or_default().to_owned();
        let remedy = format!("add {key} to this table");
        return ("machine-missing-key", key, remedy);
    }
    if message.starts_with("unknown variant") {
        let key = quoted.next().unwrap_or(at).to_owned();
        return ("machine-unknown-word", key, format!("write {}", quoted.collect::<Vec<_>>().join(" or ")));
    }
    let shown: String = at.lines().next().unwrap_or_default().chars().take(40).collect();
    ("machine-syntax", shown, "correct the TOML at this place".to_owned())
}
