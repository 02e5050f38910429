//! ISO 13399: an exchange file (ISO 10303-21) with one tool, values by the codes of the standard.
//!
//! ```text
//!  #119 = UNIT ('mm');
//!  #150 = NUMERICAL_VALUE ('DC', $, #119, '6.35');
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use proveout_input::InputError;

use super::catalog::{self, CatalogKeys, CatalogTool};
use super::{ImportCall, Imported, LengthUnit};

/// Schema of such files.
const SCHEMA: &str = "CUTTING_TOOL_SCHEMA_ARM";

/// Codes of ISO 13399.
const KEYS: CatalogKeys = CatalogKeys {
    format: "ISO 13399 file",
    diameter: &["DC"],
    corner_radius: &["RE"],
    flute_length: &["APMX"],
    shank: &["DMM", "DCONMS"],
    overall: &["OAL"],
    stick_out: &["LPR"],
    point_angle: &["SIG"],
    teeth: &["NOF", "ZEFF", "ZEFP"],
};

pub(super) fn is_iso13399(text: &str) -> bool {
    text.trim_start().starts_with("ISO-10303-21") && text.contains(SCHEMA)
}

pub(super) fn read(file: &Path, text: &str, call: &ImportCall) -> Result<Imported, InputError> {
    let refused = |message: String, help: &str| InputError::file(file, message, help);
    let mut tool = CatalogTool::default();
    let mut units: BTreeMap<String, f64> = BTreeMap::new();
    let (mut values, mut ended) = (Vec::new(), false);
    for statement in split(text, ';') {
        let statement = statement.trim();
        ended |= statement == "END-ISO-10303-21";
        let Some((id, value)) = statement.split_once('=').filter(|(id, _)| id.starts_with('#')) else { continue };
        let Some((keyword, list)) = value.split_once('(') else { continue };
        let list = list.trim_end().strip_suffix(')').unwrap_or(list);
        let arguments: Vec<&str> = split(list, ',').into_iter().map(str::trim).collect();
        match (keyword.trim(), arguments.as_slice()) {
            ("UNIT", [name, ..]) => {
                if let Some(unit) = unquoted(name).as_deref().and_then(LengthUnit::from_name) {
                    units.insert(id.trim().to_owned(), unit.mm());
                }
            }
            ("NUMERICAL_VALUE", [code, _, unit, number, ..]) => {
                if let (Some(code), Some(number)) = (unquoted(code), unquoted(number)) {
                    values.push((code, number, (*unit).to_owned()));
                }
            }
            ("STRING_VALUE", [code, .., word]) if unquoted(code).as_deref() == Some("HAND") => {
                tool.left_handed = unquoted(word).is_some_and(|w| w.eq_ignore_ascii_case("L"));
            }
            ("STRING_WITH_LANGUAGE", [words, ..]) => tool.words.extend(unquoted(words).filter(|w| !w.is_empty())),
            _ => {}
        }
    }
    if !ended {
        return Err(refused("it has no END-ISO-10303-21: the file is not whole".into(), "download it again"));
    }
    let lengths = KEYS.diameter.iter().chain(KEYS.corner_radius).chain(KEYS.flute_length).chain(KEYS.shank);
    let lengths: Vec<&str> = lengths.chain(KEYS.overall).chain(KEYS.stick_out).copied().collect();
    for (code, number, unit) in values {
        let mm = units.get(&unit).copied();
        if mm.is_none() && lengths.contains(&code.as_str()) {
            let message = format!("`{code}` = {number} has no unit of length");
            return Err(refused(message, "correct the file: lengths need a UNIT ('mm') or ('inch')"));
        }
        tool.values.push((code, number, mm.unwrap_or(1.0)));
    }
    catalog::drafts(file, &[tool], &KEYS, call)
}

/// Parts of a text between a separator that is in no string, comment or parentheses.
fn split(text: &str, separator: char) -> Vec<&str> {
    let (mut found, mut begin, mut depth) = (Vec::new(), 0, 0_usize);
    let mut rest = text.char_indices().peekable();
    let (mut in_string, mut comment) = (false, None);
    while let Some((at, c)) = rest.next() {
        if let Some(from) = comment {
            if c == '/' && text[..at].ends_with('*') && at > from + 2 {
                comment = None;
                if text[begin..from].trim().is_empty() {
                    begin = at + 1;
                }
            }
            continue;
        }
        match c {
            '\'' => in_string = !in_string,
            _ if in_string => {}
            '/' if rest.peek().is_some_and(|(_, next)| *next == '*') => comment = Some(at),
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ if c == separator && depth == 0 => {
                found.push(&text[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    found.push(&text[begin..]);
    found
}

/// The text of a string, a doubled apostrophe as one.
fn unquoted(argument: &str) -> Option<String> {
    Some(argument.strip_prefix('\'')?.strip_suffix('\'')?.replace("''", "'"))
}
