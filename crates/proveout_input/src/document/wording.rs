//! From what the TOML reader found to the words of the pages: what is wrong with a value, and what to write.

use std::cmp::Reverse;

use super::toml_fault::{ExpectedType, TomlFault};
use crate::renamed_key;

/// What the reader's message means.
pub(super) struct Said {
    pub(super) code: &'static str,
    pub(super) message: String,
    pub(super) remedy: String,
    /// The key that a table lacks.
    pub(super) missing: Option<String>,
    /// Whether the value belongs into the sentence.
    pub(super) shows_value: bool,
}

/// The nearest of the known words to an unknown one by edits (Levenshtein 1966), when it is near enough to be
/// a slip; of two as near as each other the one that begins alike.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let alike = |k: &str| word.bytes().zip(k.bytes()).take_while(|(a, b)| a == b).count();
    let near = |k: &str| word.chars().count().max(k.chars().count()) / 3 + 1;
    let distances = known.into_iter().map(|k| (strsim::levenshtein(word, k), k)).filter(|(d, k)| *d <= near(k));
    distances.min_by_key(|(d, k)| (*d, Reverse(alike(k)))).map(|(_, k)| k)
}

/// Explains a message about the text `there`.
pub(super) fn of(message: &str, there: &str) -> Said {
    let said =
        |code, message: String, remedy: String, shows_value| Said { code, message, remedy, missing: None, shows_value };
    let allowed = || "see docs/schemas for what is allowed here".to_owned();
    match TomlFault::of(message) {
        TomlFault::UnknownKey { key, known } => unknown_key(key.unwrap_or(there), &known),
        TomlFault::MissingKey(key) => {
            let remedy = format!("add `{key} = ...`");
            Said { missing: Some(key.to_owned()), ..said("input-missing-key", "is missing".into(), remedy, false) }
        }
        TomlFault::UnknownWord { word, known } => {
            let remedy = nearest(word.unwrap_or(there), known.iter().copied())
                .map_or_else(|| "write one of them".to_owned(), |near| format!("did you mean \"{near}\"?"));
            said("input-unknown-word", format!("must be one of {}", known.join(", ")), remedy, true)
        }
        TomlFault::WrongType(expected) => {
            let wanted = wanted(expected);
            let remedy = match there.chars().next() {
                Some('"' | '\'') if expected.is_number() => "write it without quotes".to_owned(),
                Some(c) if expected == ExpectedType::Text && c != '[' && c != '{' => "write it in quotes".to_owned(),
                _ => format!("write {wanted}"),
            };
            said("input-wrong-type", format!("must be {wanted}"), remedy, true)
        }
        TomlFault::NoForm => {
            said("input-wrong-type", "has none of the forms that are allowed here".into(), allowed(), true)
        }
        TomlFault::Other(message) => said("input-not-accepted", format!("is not accepted: {message}"), allowed(), true),
    }
}

fn unknown_key(key: &str, known: &[&str]) -> Said {
    let units = known.iter().filter(|k| k.strip_prefix(key).is_some_and(|rest| rest.starts_with('_')));
    let units: Vec<String> = units.map(|k| format!("`{k}`")).collect();
    let (code, remedy) = if let Some(new) = renamed_key(key, known) {
        ("input-unknown-key", format!("its name is `{new}` now: write that, or let `proveout migrate` rename it"))
    } else if !units.is_empty() && !key.is_empty() {
        ("input-unit-missing", format!("a key carries its unit: write {}", units.join(" or ")))
    } else if let Some(near) = nearest(key, known.iter().copied()) {
        ("input-unknown-key", format!("did you mean `{near}`?"))
    } else {
        ("input-unknown-key", format!("known keys here: {}", known.join(", ")))
    };
    Said { code, message: "is not a known key".into(), remedy, missing: None, shows_value: false }
}

/// What a value must be, in words.
fn wanted(expected: ExpectedType<'_>) -> String {
    match expected {
        ExpectedType::Number => "a number".to_owned(),
        ExpectedType::Whole => "a whole number".to_owned(),
        ExpectedType::Unsigned => "a whole number, 0 or more".to_owned(),
        ExpectedType::UnsignedTo(most) => format!("a whole number, 0 to {most}"),
        ExpectedType::Positive => "a whole number, 1 or more".to_owned(),
        ExpectedType::Flag => "true or false".to_owned(),
        ExpectedType::Text => "text in quotes".to_owned(),
        ExpectedType::List => "a list [...]".to_owned(),
        ExpectedType::ListOf(count) => format!("a list of {count} values"),
        ExpectedType::Table => "a table".to_owned(),
        ExpectedType::Other(words) => words.to_owned(),
    }
}
