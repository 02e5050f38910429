//! Files whose lengths are inches: `unit = "inch"` at their top, and `_inch` where a key ends in `_mm`
//! otherwise.
//!
//! Before it is read, the text is converted line by line to the same text in millimeters, so that there is
//! one reader and one set of checks. A file in inches that has a length in millimeters is refused by that
//! key: each key shows its own unit, and no file mixes both.
//!
//! Units that are made with the length follow it (`_inch_min` for `_mm_min`, `_inch_s2`, `_inch_s3`);
//! micrometers, and angles over a length (`_deg_mm`), stay as they are. An error shows the line in
//! millimeters.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use serde_json::{Map, Value, json};
use toml::de::{DeTable, DeValue};

use crate::InputError;

/// Millimeters of an inch.
const INCH_MM: f64 = 25.4;
/// Ends of keys that count a length once, in millimeters and in inches.
const UNITS: [(&str, &str); 4] =
    [("_mm", "_inch"), ("_mm_min", "_inch_min"), ("_mm_s2", "_inch_s2"), ("_mm_s3", "_inch_s3")];
/// Ends that look like lengths and are angles over one.
const NO_LENGTHS: [&str; 2] = ["_deg_mm", "_deg_per_mm"];

/// The key of the same quantity in inches.
fn in_inch(key: &str) -> Option<String> {
    if NO_LENGTHS.iter().any(|end| key.ends_with(end)) {
        return None;
    }
    UNITS.iter().find_map(|(mm, inch)| Some(format!("{}{inch}", key.strip_suffix(mm)?)))
}

/// The key of the same quantity in millimeters.
fn in_mm(key: &str) -> Option<String> {
    UNITS.iter().find_map(|(mm, inch)| Some(format!("{}{mm}", key.strip_suffix(inch)?)))
}

/// The text in millimeters; as it is where it does not say `unit = "inch"`.
///
/// # Errors
/// [`InputError`] at a key in millimeters in a file that counts in inch, and at one in inch in a file that
/// does not.
pub fn in_millimeters<'a>(file: &Path, text: &'a str) -> Result<Cow<'a, str>, InputError> {
    // The reader reports text that is not TOML.
    let Ok(tree) = DeTable::parse(text) else { return Ok(Cow::Borrowed(text)) };
    let inch = tree.get_ref().get("unit").and_then(|u| u.get_ref().as_str()) == Some("inch");
    let mut walk = InchWalk { file, text, inch, changes: Vec::new() };
    walk.table(tree.get_ref())?;
    if walk.changes.is_empty() {
        return Ok(Cow::Borrowed(text));
    }
    walk.changes.sort_by_key(|(span, _)| span.start);
    let mut out = String::with_capacity(text.len());
    let mut from = 0;
    for (span, new) in &walk.changes {
        out.push_str(text.get(from..span.start).unwrap_or_default());
        out.push_str(new);
        from = span.end;
    }
    out.push_str(text.get(from..).unwrap_or_default());
    Ok(Cow::Owned(out))
}

struct InchWalk<'a> {
    file: &'a Path,
    text: &'a str,
    inch: bool,
    changes: Vec<(Range<usize>, String)>,
}

impl InchWalk<'_> {
    fn table(&mut self, table: &DeTable<'_>) -> Result<(), InputError> {
        for (key, value) in table {
            let name = key.get_ref().as_ref();
            let refused = |message: String, remedy: String| {
                Err(InputError::file(self.file, message, remedy).with_span(self.text, &key.span()))
            };
            match (self.inch, in_mm(name), in_inch(name)) {
                (true, Some(mm), _) => {
                    let span = key.span();
                    // A key in quotes keeps them.
                    let there = self.text.get(span.clone()).unwrap_or_default().replace(name, &mm);
                    self.changes.push((span, there));
                    self.numbers(value.get_ref(), &value.span());
                }
                (false, Some(mm), _) => {
                    return refused(
                        format!("`{name}` is in inch, but the file does not state inch"),
                        format!("write unit = \"inch\" as its first line and all lengths in inch, or `{mm}`"),
                    );
                }
                (true, None, Some(inch)) => {
                    return refused(
                        format!("`{name}` is in millimeters, and the file counts in inch (unit = \"inch\")"),
                        format!("write `{inch}`, or remove the line with `unit` and write all lengths in mm"),
                    );
                }
                _ => self.below(value.get_ref())?,
            }
        }
        Ok(())
    }

    fn below(&mut self, value: &DeValue<'_>) -> Result<(), InputError> {
        match value {
            DeValue::Table(table) => self.table(table),
            DeValue::Array(list) => list.iter().try_for_each(|item| self.below(item.get_ref())),
            _ => Ok(()),
        }
    }

    /// Numbers of a length, of lists of them, and of tables by name.
    fn numbers(&mut self, value: &DeValue<'_>, span: &Range<usize>) {
        let number = match value {
            DeValue::Float(n) => n.as_str().parse::<f64>().ok(),
            DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix()).ok().map(|i| i as f64),
            DeValue::Array(list) => return list.iter().for_each(|item| self.numbers(item.get_ref(), &item.span())),
            DeValue::Table(table) => {
                return table.iter().for_each(|(_, item)| self.numbers(item.get_ref(), &item.span()));
            }
            _ => None,
        };
        // The reader reports what is not a number, with its position.
        if let Some(number) = number.filter(|n| n.is_finite()) {
            self.changes.push((span.clone(), format!("{}", number * INCH_MM)));
        }
    }
}

/// Lets a JSON schema take `_inch` in place of `_mm`, wherever it takes a length.
pub fn add_inches_to_schema(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            // What is added below holds keys of its own that are in order.
            map.values_mut().for_each(add_inches_to_schema);
            let mut patterns = Map::new();
            if let Some(Value::Object(properties)) = map.get("properties") {
                for (key, property) in properties {
                    if let Some(inch) = in_inch(key) {
                        let mut property = property.clone();
                        if let Value::Object(of) = &mut property {
                            ["minimum", "maximum", "exclusiveMinimum"].iter().for_each(|k| drop(of.remove(*k)));
                        }
                        patterns.insert(format!("^{inch}$"), property);
                    }
                }
            }
            if !patterns.is_empty() {
                map.insert("patternProperties".into(), Value::Object(patterns));
            }
            if let Some(Value::Array(required)) = map.get_mut("required") {
                let (lengths, others): (Vec<Value>, Vec<Value>) =
                    required.drain(..).partition(|k| k.as_str().and_then(in_inch).is_some());
                *required = others;
                let either: Vec<Value> = lengths
                    .iter()
                    .filter_map(Value::as_str)
                    .filter_map(|k| Some(json!({ "anyOf": [{ "required": [k] }, { "required": [in_inch(k)?] }] })))
                    .collect();
                if required.is_empty() {
                    map.remove("required");
                }
                if !either.is_empty() {
                    match map.get_mut("allOf") {
                        Some(Value::Array(all)) => all.extend(either),
                        _ => {
                            map.insert("allOf".into(), Value::Array(either));
                        }
                    }
                }
            }
        }
        Value::Array(all) => all.iter_mut().for_each(add_inches_to_schema),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(text: &str) -> Result<String, InputError> {
        in_millimeters(Path::new("scene.toml"), text).map(Cow::into_owned)
    }

    #[test]
    fn lengths_of_an_inch_file_are_millimeters_line_by_line() {
        let text = "unit = \"inch\"\nresolution_inch = 0.01 # fine\n[stock]\nbox = { min_inch = [0, 0, -1], max_inch = [4, 3.0, 0] }\n\
                    [control]\npole_cone_deg = 1\n[control.joint_limits.X]\nmax_velocity_inch_min = 100\nrate_deg_mm = 2\nra_um = 5\n";
        let want = "unit = \"inch\"\nresolution_mm = 0.254 # fine\n[stock]\nbox = { min_mm = [0, 0, -25.4], max_mm = [101.6, 76.19999999999999, 0] }\n\
                    [control]\npole_cone_deg = 1\n[control.joint_limits.X]\nmax_velocity_mm_min = 2540\nrate_deg_mm = 2\nra_um = 5\n";
        assert_eq!(converted(text).expect("inch"), want);
        assert_eq!(converted("a_mm = 1\n").expect("mm"), "a_mm = 1\n");
        assert_eq!(converted("no toml at all").expect("left to its reader"), "no toml at all");
    }

    #[test]
    fn no_file_counts_in_both() {
        let both = converted("unit = \"inch\"\na_inch = 1\n[t]\nb_mm = 2\n").expect_err("both");
        assert_eq!((both.line, both.column), (4, 1));
        assert!(both.message.contains("b_mm") && both.remedy.contains("b_inch"), "{both}");
        let unsaid = converted("x = [{ d_inch = 1 }]\n").expect_err("not said");
        assert!(unsaid.remedy.contains("unit = \"inch\""), "{unsaid}");
    }

    #[test]
    fn schemas_take_either() {
        let mut schema =
            json!({ "properties": { "d_mm": { "type": "number", "maximum": 5 }, "n": {} }, "required": ["n", "d_mm"] });
        add_inches_to_schema(&mut schema);
        assert_eq!(schema["patternProperties"]["^d_inch$"], json!({ "type": "number" }));
        assert_eq!(schema["required"], json!(["n"]));
        assert_eq!(schema["allOf"][0]["anyOf"][1]["required"], json!(["d_inch"]));
    }
}
