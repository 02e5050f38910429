//! A TOML document: scene, machine or tool library. Only this module turns the text into a type, so that
//! the same typo gets the same answer everywhere.
//!
//! The text and its syntax tree are kept with the value, so that a fault that a reader finds later has a
//! position as well.

mod strict;
mod toml_fault;
mod wording;

use std::{ops::Range, path::Path};

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use crate::{InputError, OutOfRange, check_quantities, input_error::InputFault};

use strict::Strict;
pub use toml_fault::{ExpectedType, TomlFault};
pub use wording::nearest;

/// Longest value that an error repeats, characters.
const SHOWN: usize = 60;

/// One step on the way to a value.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// A key of a table.
    Key(&'a str),
    /// A member of a list, from 0.
    Item(usize),
}

/// The text of a TOML file with its syntax tree.
///
/// ```
/// use proveout_input::Document;
///
/// #[derive(Debug, serde::Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Block {
///     height_mm: f64,
/// }
/// let file = std::path::Path::new("block.toml");
/// let block: Block = Document::new(file, "height_mm = 20\n").read()?;
/// assert_eq!(block.height_mm, 20.0);
/// let fault = Document::new(file, "height = 20\n").read::<Block>().expect_err("no unit");
/// assert_eq!((fault.line, fault.column), (1, 1));
/// assert_eq!(fault.remedy, "a key carries its unit: write `height_mm`");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Document<'a> {
    file: &'a Path,
    text: &'a str,
    tree: Option<DeTable<'a>>,
}

impl<'a> Document<'a> {
    /// A text; `file` names it in errors.
    pub fn new(file: &'a Path, text: &'a str) -> Self {
        Self { file, text, tree: DeTable::parse(text).ok().map(toml::Spanned::into_inner) }
    }

    /// The file that errors name.
    pub fn file(&self) -> &'a Path {
        self.file
    }

    /// The content as a value. Keys that the type does not know are refused where it denies them, numbers
    /// outside the range of their quantity always.
    ///
    /// # Errors
    /// [`InputError`] for the first fault: no TOML, no key, an unknown or missing key, a wrong type or word,
    /// a number out of range.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, InputError> {
        if let Err(e) = DeTable::parse(self.text) {
            let span = e.span().unwrap_or(0..0);
            let message = format!("the text is not TOML: {}", e.message().lines().next().unwrap_or_default());
            return Err(self.fault("input-syntax", String::new(), message, "correct the text at this place", &span));
        }
        if self.tree.as_ref().is_none_or(DeTable::is_empty) {
            let remedy = "write a file that matches docs/schemas, or name another file";
            return Err(self.fault("input-empty", String::new(), "the file holds no key".into(), remedy, &(0..0)));
        }
        let reader = toml::de::Deserializer::parse(self.text).map_err(|e| self.refused(&e))?;
        let value = T::deserialize(Strict(reader)).map_err(|e| self.refused(&e))?;
        check_quantities(self.text).map_err(|e| self.out_of_range(&e))?;
        Ok(value)
    }

    /// An error at a key with a message of the caller's own.
    pub fn error(
        &self,
        code: &'static str,
        path: &[Step<'_>],
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> InputError {
        self.fault(code, self.key_text(path), message.into(), remedy, &self.span(path))
    }

    /// The same with the value of the key, if there is one.
    pub fn error_with_value(
        &self,
        code: &'static str,
        path: &[Step<'_>],
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) -> InputError {
        let value = if self.has(path) { self.shown(&self.span(path)) } else { String::new() };
        let key = self.key_text(path);
        let fault = InputFault { code, key, value, continues_key: true, ..self.bare(message.into(), remedy) };
        InputError::from(fault).with_span(self.text, &self.span(path))
    }

    /// The tree of all keys, if the text is TOML.
    pub fn tree(&self) -> Option<&DeTable<'a>> {
        self.tree.as_ref()
    }

    /// True when there is a value at the path.
    pub fn has(&self, path: &[Step<'_>]) -> bool {
        self.value(path).is_some()
    }

    /// Keys of the table at a path.
    pub fn keys(&self, path: &[Step<'_>]) -> Vec<String> {
        let table = self.value(path).and_then(DeValue::as_table);
        table.map_or_else(Vec::new, |t| t.keys().map(|k| k.get_ref().to_string()).collect())
    }

    /// Line, from 1, of a byte of the text.
    pub fn line(&self, offset: usize) -> usize {
        self.text.get(..offset).unwrap_or(self.text).matches('\n').count() + 1
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

    /// Bytes of a key's value; of the deepest part that exists when the key does not.
    pub fn span(&self, path: &[Step<'_>]) -> Range<usize> {
        let mut span = 0..0;
        let Some(mut table) = self.tree.as_ref() else { return span };
        let mut value: Option<&DeValue<'_>> = None;
        for step in path {
            match (step, value) {
                (Step::Key(key), _) => {
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
                (Step::Item(index), Some(v)) => {
                    let Some(item) = v.as_array().and_then(|a| a.get(*index)) else { return span };
                    span = item.span();
                    value = Some(item.get_ref());
                }
                (Step::Item(_), None) => return span,
            }
        }
        span
    }

    /// A path for people: members of lists go by their `name` where they have one.
    fn key_text(&self, path: &[Step<'_>]) -> String {
        let mut text = String::new();
        for (i, step) in path.iter().enumerate() {
            match step {
                Step::Key(key) => push_key(&mut text, key),
                Step::Item(index) => push_item(&mut text, *index, self.value(&path[..=i])),
            }
        }
        text
    }

    /// A number that no workshop has.
    fn out_of_range(&self, fault: &OutOfRange) -> InputError {
        let key = self.path_at(&fault.span).unwrap_or_else(|| fault.key.clone());
        let message = format!("is out of range: {} to {}", fault.least, fault.most);
        let fault_there = InputFault {
            code: "input-out-of-range",
            key,
            value: fault.value.clone(),
            ..self.bare(message, OutOfRange::REMEDY)
        };
        InputError::from(fault_there).with_span(self.text, &fault.span)
    }

    /// What the TOML reader found while it filled the type, in the words of the trade.
    fn refused(&self, error: &toml::de::Error) -> InputError {
        let span = error.span().unwrap_or(0..0);
        let there = self.text.get(span.clone()).unwrap_or_default();
        let said = wording::of(error.message(), there);
        let mut key = self.path_at(&span).unwrap_or_default();
        if let Some(missing) = &said.missing {
            push_key(&mut key, missing);
        }
        let value = if said.shows_value { self.shown(&span) } else { String::new() };
        let fault =
            InputFault { code: said.code, key, value, continues_key: true, ..self.bare(said.message, said.remedy) };
        // The bytes of a table can be all its lines, of the whole document all of them: its beginning is the
        // place to look at.
        let span = if said.missing.is_some() { span.start..span.start } else { span };
        InputError::from(fault).with_span(self.text, &span)
    }

    fn bare(&self, message: String, remedy: impl Into<String>) -> InputFault {
        InputFault { file: self.file.into(), message, remedy: remedy.into(), ..InputFault::default() }
    }

    fn fault(
        &self,
        code: &'static str,
        key: String,
        message: String,
        remedy: impl Into<String>,
        span: &Range<usize>,
    ) -> InputError {
        InputError::from(InputFault { code, key, ..self.bare(message, remedy) }).with_span(self.text, span)
    }

    /// The text of a value, cut short.
    fn shown(&self, span: &Range<usize>) -> String {
        let value = self.text.get(span.clone()).unwrap_or_default().lines().next().unwrap_or_default().trim();
        let cut = value.chars().count() > SHOWN;
        value.chars().take(SHOWN).chain(if cut { "..." } else { "" }.chars()).collect()
    }

    /// The path of the key or value with these bytes; none for those of the whole document.
    fn path_at(&self, span: &Range<usize>) -> Option<String> {
        let tree = self.tree.as_ref()?;
        let mut path = String::new();
        in_table(tree, span, &mut path).then_some(path)
    }
}

/// Looks for the bytes below a table and leaves the path in `path`.
fn in_table(table: &DeTable<'_>, span: &Range<usize>, path: &mut String) -> bool {
    let length = path.len();
    for (key, value) in table {
        push_key(path, key.get_ref());
        // A list of tables has the bytes of its first one: the deepest is meant.
        if in_value(value.get_ref(), span, path) || key.span() == *span || value.span() == *span {
            return true;
        }
        path.truncate(length);
    }
    false
}

fn in_value(value: &DeValue<'_>, span: &Range<usize>, path: &mut String) -> bool {
    match value {
        DeValue::Table(table) => in_table(table, span, path),
        DeValue::Array(list) => {
            let length = path.len();
            list.iter().enumerate().any(|(i, item)| {
                push_item(path, i, Some(item.get_ref()));
                let found = in_value(item.get_ref(), span, path) || item.span() == *span;
                if !found {
                    path.truncate(length);
                }
                found
            })
        }
        _ => false,
    }
}

fn push_key(path: &mut String, key: &str) {
    if !path.is_empty() {
        path.push('.');
    }
    path.push_str(key);
}

fn push_item(path: &mut String, index: usize, item: Option<&DeValue<'_>>) {
    let named = item.and_then(DeValue::as_table).and_then(|t| t.get("name")).and_then(|n| n.get_ref().as_str());
    match named {
        Some(name) => push_key(path, name),
        None => path.push_str(&format!("[{index}]")),
    }
}

#[cfg(test)]
mod tests;
