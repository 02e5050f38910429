//! From the messages of the TOML reader to the words of the pages: what is wrong with a value, and what to write.

use std::cmp::Reverse;

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

/// Explains a message about the text `there`; the names in back quotes are a key and its alternatives.
pub(super) fn of(message: &str, there: &str) -> Said {
    let message = message.lines().next().unwrap_or_default().trim();
    let mut quoted = message.split('`').skip(1).step_by(2);
    let said =
        |code, message: String, remedy: String, shows_value| Said { code, message, remedy, missing: None, shows_value };
    if message.starts_with("unknown field") {
        let key = quoted.next().unwrap_or(there);
        let known: Vec<&str> = quoted.collect();
        return unknown_key(key, &known);
    }
    if message.starts_with("missing field") {
        let key = quoted.next().unwrap_or_default();
        let remedy = format!("add `{key} = ...`");
        return Said { missing: Some(key.to_owned()), ..said("input-missing-key", "is missing".into(), remedy, false) };
    }
    if message.starts_with("unknown variant") {
        let word = quoted.next().unwrap_or(there);
        let known: Vec<&str> = quoted.collect();
        let remedy = nearest(word, known.iter().copied())
            .map_or_else(|| "write one of them".to_owned(), |near| format!("did you mean \"{near}\"?"));
        return said("input-unknown-word", format!("must be one of {}", known.join(", ")), remedy, true);
    }
    if ["invalid type", "invalid value", "invalid length"].iter().any(|begin| message.starts_with(begin))
        && let Some((found, expected)) = message.rsplit_once(", expected ")
    {
        let wanted = wanted(found, expected);
        let remedy = match there.chars().next() {
            Some('"' | '\'') if wanted.contains("number") => "write it without quotes".to_owned(),
            Some(c) if wanted == TEXT && c != '[' && c != '{' => "write it in quotes".to_owned(),
            _ => format!("write {wanted}"),
        };
        return said("input-wrong-type", format!("must be {wanted}"), remedy, true);
    }
    let remedy = "see docs/schemas for what is allowed here".to_owned();
    if message.contains("untagged enum") {
        return said("input-wrong-type", "has none of the forms that are allowed here".into(), remedy, true);
    }
    said("input-not-accepted", format!("is not accepted: {message}"), remedy, true)
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

const TEXT: &str = "text in quotes";

/// What a value must be, from the reader's name of a type.
fn wanted(found: &str, expected: &str) -> String {
    let expected = expected.trim();
    let count = || expected.split_whitespace().find_map(|word| word.parse::<u64>().ok());
    match expected {
        "f64" | "f32" => "a number".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" if found.contains("`") && !found.contains("`-") => {
            let most = match expected {
                "u8" => u64::from(u8::MAX),
                "u16" => u64::from(u16::MAX),
                "u32" => u64::from(u32::MAX),
                _ => u64::MAX,
            };
            format!("a whole number, 0 to {most}")
        }
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or more".to_owned(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" | "path string" | "a borrowed string" => TEXT.to_owned(),
        "a sequence" => "a list [...]".to_owned(),
        "a map" => "a table".to_owned(),
        _ if expected.starts_with("struct ") => "a table".to_owned(),
        _ if expected.starts_with("an array of length") || expected.starts_with("a tuple of size") => {
            count().map_or_else(|| expected.to_owned(), |n| format!("a list of {n} values"))
        }
        _ if expected.starts_with("a nonzero ") => "a whole number, 1 or more".to_owned(),
        _ => expected.to_owned(),
    }
}
