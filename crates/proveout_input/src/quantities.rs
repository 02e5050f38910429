//! Ranges of the quantities in scenes, machines and tool libraries, in one place.
//!
//! A key of an input file ends in its unit, so the unit decides the range: [`RANGES`] has one line for each
//! unit and one for each key whose range is narrower. A value outside means a mistake in the unit or the
//! exponent (`1e18`, a stock of 10 km) and is refused before it is used in any calculation. Tighter limits
//! of a machine or tool are checked afterwards by its own reader. The same table provides `minimum` and
//! `maximum` of the JSON schemas.

use std::ops::Range;

use serde_json::{Map, Value, json};
use thiserror::Error;
use toml::de::{DeTable, DeValue};

/// Longest way, mm: a hundred meters. The largest gantries have some sixty.
pub const MAX_LENGTH_MM: f64 = 1e5;
/// Of numbers without a unit.
const PLAIN: f64 = 1e9;
/// Values that are written without an exponent, and zero.
const WRITTEN_PLAIN: Range<f64> = 1e-7..1e9;

/// A unit (`_mm`) or a whole key, its least and its largest value, and whether zero is also allowed
/// ("none", "not stated").
const RANGES: [(&str, f64, f64, bool); 30] = [
    // Keys with a range of their own; they come before the units.
    ("resolution_mm", 1e-5, 1e3, false),
    ("cell_mm", 1e-5, 1e3, false),
    ("cycle_time_ms", 0.01, 100.0, false),
    ("block_time_ms", 0.0, 1e3, true),
    ("tool_change_time_s", 0.0, 3600.0, true),
    ("start_time_s", 0.0, 3600.0, true),
    ("simulated_time_s", 1.0, 1e7, false),
    ("max_velocity_mm_min", 0.1, 1e6, false),
    ("max_velocity_deg_s", 1e-3, 1e5, false),
    ("max_acceleration_mm_s2", 0.1, 1e6, false),
    ("max_acceleration_deg_s2", 1e-2, 1e7, false),
    ("max_jerk_mm_s3", 1.0, 1e9, false),
    ("max_jerk_deg_s3", 0.1, 1e10, false),
    // Units; longer ones before those that they end in.
    ("_mm_min", -1e6, 1e6, true),
    ("_deg_per_mm", -1e5, 1e5, true),
    ("_mm", -MAX_LENGTH_MM, MAX_LENGTH_MM, true),
    ("_um", -1e6, 1e6, true),
    ("_deg", -1e5, 1e5, true),
    ("_deg_s", -1e5, 1e5, true),
    ("_rev_min", -1e5, 1e5, true),
    ("_rpm", -1e6, 1e6, true),
    ("_ms", -1e6, 1e6, true),
    ("_hz", -1e6, 1e6, true),
    ("_1_s", -1e6, 1e6, true),
    ("_s", -1e7, 1e7, true),
    ("_kg_m3", 0.0, 3e4, true),
    ("_kg_m2", -1e6, 1e6, true),
    ("_kg", -1e7, 1e7, true),
    ("_Nm", -1e9, 1e9, true),
    ("_N", -1e9, 1e9, true),
];

/// Units of keys that no line of [`RANGES`] may take by its end: `_N_s_m` is no second, and no meter.
const OF_PLAIN_RANGE: [&str; 2] = ["_N_s_m", "_Nm_s_rad"];

/// A value that no workshop has.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("`{key}` = {value} is out of range: {least} to {most}")]
pub struct OutOfRange {
    /// Bytes of the value in the text.
    pub span: Range<usize>,
    /// Path of the key with the unit, `stock.box.max_mm`.
    pub key: String,
    /// The value as written.
    pub value: String,
    /// The least value that is taken, in the unit of the key.
    pub least: f64,
    /// The largest one.
    pub most: f64,
}

impl OutOfRange {
    /// What to do about it.
    pub const REMEDY: &str = "check the value and the unit of its key";
}

/// Least and largest value of a key; none where its name ends in no unit.
pub fn range_of(key: &str) -> Option<(f64, f64, bool)> {
    if OF_PLAIN_RANGE.iter().any(|unit| key.ends_with(unit)) {
        return None;
    }
    let fits = |known: &str| if known.starts_with('_') { key.ends_with(known) } else { key == known };
    RANGES.iter().find(|(known, ..)| fits(known)).map(|&(_, least, most, zero)| (least, most, zero))
}

/// Checks a value that a call or another program gives for a key, by the range that the key has in a file.
///
/// # Errors
/// A value outside of the range, or that is no number.
pub fn check_quantity(key: &str, value: f64) -> Result<(), OutOfRange> {
    let (least, most, zero) = range_of(key).unwrap_or((-PLAIN, PLAIN, true));
    if (least..=most).contains(&value) || zero && value == 0.0 {
        return Ok(());
    }
    let plain = value == 0.0 || WRITTEN_PLAIN.contains(&value.abs());
    let value = if plain { value.to_string() } else { format!("{value:e}") };
    Err(OutOfRange { span: 0..0, key: key.to_owned(), value, least, most })
}

/// Holds every number of a TOML text against the range of its key. A text that is no TOML is left to its
/// reader.
///
/// # Errors
/// The first number outside of its range, or that is not finite.
pub fn check_quantities(text: &str) -> Result<(), OutOfRange> {
    DeTable::parse(text).map_or(Ok(()), |table| {
        table.get_ref().iter().try_for_each(|(key, value)| {
            let key = key.get_ref().as_ref();
            check(text, key, range_of(key), value.get_ref(), value.span())
        })
    })
}

fn check(
    text: &str,
    path: &str,
    range: Option<(f64, f64, bool)>,
    value: &DeValue<'_>,
    span: Range<usize>,
) -> Result<(), OutOfRange> {
    let number = match value {
        DeValue::Table(table) => {
            return table.iter().try_for_each(|(key, value)| {
                let key = key.get_ref().as_ref();
                // `roles_kg_m3 = { column = 7000 }`: a key without a unit has that of the table.
                let range = range_of(key).or(range);
                check(text, &format!("{path}.{key}"), range, value.get_ref(), value.span())
            });
        }
        DeValue::Array(array) => {
            return array.iter().try_for_each(|value| check(text, path, range, value.get_ref(), value.span()));
        }
        DeValue::Float(number) => number.as_str().parse().unwrap_or(f64::NAN),
        // A number beyond 64 bits is reported by the reader.
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix()).map_or(0.0, |n| n as f64),
        _ => return Ok(()),
    };
    let (least, most, zero) = range.unwrap_or((-PLAIN, PLAIN, true));
    // A sign or a zero that the quantity cannot have is reported by the reader of the file, which knows the
    // key's meaning.
    let small = least > 0.0 && number.abs() < least && number != 0.0;
    if number.abs() <= most && !small || zero && number == 0.0 {
        return Ok(());
    }
    let value = text.get(span.clone()).unwrap_or_default().chars().take(40).collect();
    Err(OutOfRange { span, key: path.to_owned(), value, least, most })
}

/// Writes the ranges into a JSON schema, wherever a property that is a number, or an array of numbers, has a
/// unit.
pub fn add_ranges_to_schema(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            if let Some(Value::Object(properties)) = map.get_mut("properties") {
                for (key, property) in properties.iter_mut() {
                    if let (Some((least, most, _)), Value::Object(of)) = (range_of(key), property) {
                        bound(of, least, most);
                    }
                }
            }
            map.values_mut().for_each(add_ranges_to_schema);
        }
        Value::Array(all) => all.iter_mut().for_each(add_ranges_to_schema),
        _ => {}
    }
}

fn bound(of: &mut Map<String, Value>, least: f64, most: f64) {
    let named =
        |kind: &Value, name: &str| kind == name || kind.as_array().is_some_and(|all| all.iter().any(|k| k == name));
    let is = |of: &Map<String, Value>, name: &str| of.get("type").is_some_and(|kind| named(kind, name));
    if is(of, "number") || is(of, "integer") {
        // What a type says already is the narrower one.
        of.entry("minimum").or_insert_with(|| json!(least));
        of.entry("maximum").or_insert_with(|| json!(most));
    } else if is(of, "array")
        && let Some(Value::Object(items)) = of.get_mut("items")
    {
        bound(items, least, most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_decide_the_range() {
        assert_eq!(range_of("height_mm"), Some((-1e5, 1e5, true)));
        assert_eq!(range_of("cycle_time_ms"), Some((0.01, 100.0, false)));
        assert_eq!(range_of("feed_mm_min").expect("feed").1, 1e6, "mm/min is no mm");
        assert_eq!(range_of("count"), None);
        assert_eq!(range_of("velocity_gain_N_s_m"), None);
        for (at, (key, least, most, _)) in RANGES.iter().enumerate() {
            assert!(least < most);
            let earlier = RANGES[..at].iter().find(|(before, ..)| key.ends_with(before));
            assert_eq!(earlier, None, "{key} would never be reached");
        }
    }

    #[test]
    fn values_outside_are_reported_with_key_value_and_range() {
        let fault = |text: &str| check_quantities(text).expect_err(text).to_string();
        let message = fault("[stock]\nbox = { min_mm = [0, 0, 0], max_mm = [20, 1e18, 0] }");
        assert_eq!(message, "`stock.box.max_mm` = 1e18 is out of range: -100000 to 100000");
        assert!(fault("[control]\ncycle_time_ms = 1e-4").contains("0.01 to 100"));
        assert!(fault("roles_kg_m3 = { column = 1e9 }").contains("roles_kg_m3.column"));
        assert!(fault("[[a]]\n[[a]]\nx = nan").contains("`a.x` = nan"));
        assert!(fault("x = -inf").contains("-inf"));
        assert!(fault("n = 0xfffffffffff").contains("0xfffffffffff"));
        check_quantities("a_mm = 1e5\nb_mm = -100_000.0\nc = 1e9\nname = \"1e99\"\nd_ms = 0").expect("in range");
        check_quantities("no toml at all =").expect("left to the reader");
    }

    #[test]
    fn schemas_get_the_ranges() {
        let mut schema = json!({"properties": {
            "x_mm": {"type": ["number", "null"]},
            "at_mm": {"type": "array", "items": {"type": "number"}},
            "radius_mm": {"type": "number", "minimum": 1.0},
            "name": {"type": "string"}
        }});
        add_ranges_to_schema(&mut schema);
        assert_eq!(schema["properties"]["x_mm"]["maximum"], 1e5);
        assert_eq!(schema["properties"]["at_mm"]["items"]["minimum"], -1e5);
        assert_eq!(schema["properties"]["radius_mm"]["minimum"], 1.0);
        assert_eq!(schema["properties"]["name"], json!({"type": "string"}));
    }
}
