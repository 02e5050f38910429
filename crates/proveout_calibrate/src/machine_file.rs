//! The machine file with the values that were found: every other byte stays.

use std::path::Path;

use proveout_input::{InputError, InputFault};
use proveout_machine::Machine;
use proveout_nc::builtin_controls;
use toml_edit::{DocumentMut, Item, Table as TomlTable, TableLike, Value, value};

use crate::calibration::{Calibration, Parameter, Table};

/// Digits of a value after the first digit of its standard error.
const MORE_DIGITS: i32 = 1;
/// Digits where the error is zero.
const MOST_DIGITS: i32 = 9;

/// A number with the digits that its standard error leaves.
pub(crate) fn rounded(number: f64, error: f64) -> f64 {
    let first = |v: f64| v.abs().log10().floor() as i32;
    let digits = if error > 0.0 && error.is_finite() { MORE_DIGITS - first(error) } else { MOST_DIGITS };
    let most = MOST_DIGITS - if number == 0.0 { 0 } else { first(number) };
    let digits = digits.min(most);
    if digits >= 0 {
        // Through text: ten to the power of -k is no binary number.
        format!("{number:.*}", digits as usize).parse().unwrap_or(number)
    } else {
        let unit = 10_f64.powi(-digits);
        (number / unit).round() * unit
    }
}

/// Value and standard error with the digits that the error leaves.
pub fn with_error(number: f64, error: f64) -> String {
    format!("{} (standard error {})", rounded(number, error), rounded(error, error))
}

/// The text of a machine file with the written parameters, each with its source and standard error.
///
/// # Errors
/// [`InputError`] where the text is not the file that the machine was read from, or the new values
/// contradict each other.
pub fn calibrated_machine(file: &Path, text: &str, found: &Calibration) -> Result<String, InputError> {
    let fault = |message: String, remedy: &str| -> InputError {
        InputFault { code: "calibrate", file: file.into(), message, remedy: remedy.into(), ..InputFault::default() }
            .into()
    };
    let mut document: DocumentMut = text
        .parse()
        .map_err(|e: toml_edit::TomlError| fault(format!("the text is not TOML: {}", e.message()), "correct it"))?;
    for parameter in found.parameters.iter().filter(|p| p.written) {
        put(&mut document, parameter, &found.source)
            .ok_or_else(|| fault(format!("there is no table for {}", parameter.key), "name the file of the machine"))?;
    }
    let traces: Vec<String> =
        found.traces.iter().map(|[name, digest]| format!("# {name}: sha256 {digest}\n")).collect();
    let head = format!(
        "# Values with the source \"fitted\" come from measured traces (`proveout calibrate fit`):\n{}",
        traces.concat()
    );
    let out = format!("{head}{document}");
    Machine::from_text(file, &out)?;
    Ok(out)
}

/// What a machine file names that is looked for in its folder; none where it needs no other file.
pub fn needs_folder(text: &str) -> Option<String> {
    let document: DocumentMut = text.parse().ok()?;
    let name = |item: Option<&Item>| item.and_then(Item::as_str).map(str::to_owned);
    let control = name(document.get("control").and_then(|c| c.get("file")));
    name(document.get("model")).or_else(|| control.filter(|c| builtin_controls().all(|known| known != *c)))
}

fn joint<'d>(document: &'d mut DocumentMut, name: &str) -> Option<&'d mut TomlTable> {
    let joints = document.get_mut("joint")?.as_array_of_tables_mut()?;
    joints.iter_mut().find(|j| j.get("name").and_then(Item::as_str) == Some(name))
}

/// Sets a number and keeps the comment beside it.
fn set(table: &mut dyn TableLike, key: &str, number: f64) {
    let decor = table.get(key).and_then(Item::as_value).map(|v| v.decor().clone());
    let mut new = value(number);
    if let (Some(decor), Some(value)) = (decor, new.as_value_mut()) {
        *value.decor_mut() = decor;
    }
    table.insert(key, new);
}

fn number(table: &dyn TableLike, key: &str) -> Option<f64> {
    let item = table.get(key)?.as_value()?;
    match item {
        Value::Float(v) => Some(*v.value()),
        Value::Integer(v) => Some(*v.value() as f64),
        _ => None,
    }
}

/// Notes the source of a key, and takes it from what was chosen.
fn note(table: &mut TomlTable, key: &str, words: &str) -> Option<()> {
    if let Some(chosen) = table.get_mut("chosen").and_then(Item::as_table_like_mut) {
        chosen.remove(key);
    }
    let source = table.entry("source").or_insert_with(|| Item::Table(TomlTable::new()));
    let source = source.as_table_like_mut()?;
    let before = source.get(key).and_then(Item::as_str).filter(|t| t.starts_with("fitted")).map(str::to_owned);
    let text = before.filter(|_| key == "drive").map_or_else(|| words.to_owned(), |b| format!("{b}; {words}"));
    source.insert(key, value(text));
    Some(())
}

fn put(document: &mut DocumentMut, parameter: &Parameter, source: &str) -> Option<()> {
    let (estimate, error) = (parameter.estimate?, parameter.standard_error?);
    let new = rounded(estimate, error);
    let words = |what: &str| format!("{source}: {what}{}", with_error(estimate, error));
    match (parameter.table, &parameter.joint) {
        (Table::Control, _) => {
            let table = document.get_mut("control")?.as_table_mut()?;
            set(table, parameter.key, new);
            note(table, parameter.key, &words(""))
        }
        (Table::Joint, Some(name)) => {
            let table = joint(document, name)?;
            let is_velocity = parameter.key.starts_with("rapid_velocity");
            if !is_velocity {
                set(table, parameter.key, new);
                return note(table, parameter.key, &words(""));
            }
            let most = parameter.key.replace("rapid", "max");
            // Revolutions a minute become degrees a second: one velocity has one key.
            for (old, key) in [("rapid_velocity_rev_min", parameter.key), ("max_velocity_rev_min", most.as_str())] {
                if let Some(turns) = number(table, old) {
                    table.remove(old);
                    for notes in ["source", "chosen"] {
                        if let Some(notes) = table.get_mut(notes).and_then(Item::as_table_like_mut)
                            && let Some(text) = notes.remove(old)
                        {
                            notes.insert(key, text);
                        }
                    }
                    const DEG_S: f64 = 6.0;
                    set(table, key, turns * DEG_S);
                }
            }
            let (rapid, highest) = (number(table, parameter.key), number(table, &most));
            // Where both were one number, both are measured; a rapid above the highest raises it.
            if highest.is_some_and(|h| h < new || rapid.is_none_or(|r| r == h)) {
                set(table, &most, new);
                note(table, &most, &words(""))?;
            }
            set(table, parameter.key, new);
            note(table, parameter.key, &words(""))
        }
        (Table::Drive, Some(name)) => {
            let table = joint(document, name)?;
            let drive = table.get_mut("drive")?.as_table_like_mut()?;
            let of = |linear: &'static str, turning: &'static str| match parameter.key {
                "coulomb_friction_N" => Some(linear),
                "coulomb_friction_Nm" => Some(turning),
                _ => None,
            };
            if let Some(key) = of("static_friction_N", "static_friction_Nm") {
                // Static friction keeps its proportion to the dry one.
                if let (Some(held), Some(dry)) = (number(drive, key), number(drive, parameter.key)) {
                    let times = if dry > 0.0 { (held / dry).max(1.0) } else { 1.0 };
                    set(drive, key, rounded(estimate * times, error).max(new));
                }
            }
            set(drive, parameter.key, new);
            note(table, "drive", &words(&format!("{} ", parameter.key)))
        }
        (_, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_digits_of_their_error() {
        assert_eq!(rounded(22_861.234_567, 0.037), 22_861.235);
        assert_eq!(rounded(2999.87, 12.0), 3000.0);
        assert_eq!(rounded(0.123_456, 0.001_3), 0.1235);
        assert_eq!(rounded(1234.5, 200.0), 1230.0);
        assert_eq!(rounded(54.0, 0.0), 54.0);
        assert_eq!(rounded(0.0, 0.0), 0.0);
        assert_eq!(with_error(54.012_34, 0.021), "54.012 (standard error 0.021)");
    }
}
