//! TOML text with the places of its keys and values, checked against the schema.

use std::ops::Range;
use std::path::Path;

use serde_json::Value;
use serde_spanned::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Defect, nearest};

/// Parsed text that knows where everything stands.
pub(crate) struct Text<'a> {
    file: &'a Path,
    text: &'a str,
    root: Spanned<DeTable<'a>>,
}

impl<'a> Text<'a> {
    /// Parses TOML.
    pub(crate) fn parse(file: &'a Path, text: &'a str) -> Result<Self, Box<Defect>> {
        match DeTable::parse(text) {
            Ok(root) => Ok(Self { file, text, root }),
            Err(e) => {
                let span = e.span().unwrap_or(0..0);
                let (line, column) = place(text, span.start);
                Err(Box::new(Defect {
                    file: file.to_owned(),
                    line,
                    column,
                    tool: String::new(),
                    key: String::new(),
                    value: shown(text, &span),
                    message: format!("the text is not valid TOML: {}", e.message()),
                    remedy: "correct the line".into(),
                }))
            }
        }
    }

    /// A defect at a place of the text.
    pub(crate) fn defect(&self, span: &Range<usize>, key: &str, message: String, remedy: String) -> Box<Defect> {
        let (line, column) = place(self.text, span.start);
        let value = shown(self.text, span);
        let key = key.to_owned();
        Box::new(Defect {
            file: self.file.to_owned(),
            line,
            column,
            tool: self.tool_at(span),
            key,
            value,
            message,
            remedy,
        })
    }

    /// Place of a key's value in tool `index`; where the key is missing, the place of the tool and false.
    pub(crate) fn place_of(&self, index: usize, key: &str) -> (Range<usize>, bool) {
        let Some(tool) = self.tool(index) else { return (0..0, false) };
        let mut candidates = vec![tool.get_ref()];
        // Keys of holder sections are found in the holder, those of inserts in the edges.
        candidates.extend(
            ["holder", "edges", "residual"].iter().filter_map(|k| tool.get_ref().get(*k)).map(Spanned::get_ref),
        );
        let insert = tool.get_ref().get("edges").and_then(|e| e.get_ref().get("round_insert"));
        candidates.extend(insert.map(Spanned::get_ref));
        for table in candidates {
            if let Some(value) = table.get(key) {
                return (value.span(), true);
            }
        }
        (tool.span(), false)
    }

    fn tool(&self, index: usize) -> Option<&Spanned<DeValue<'a>>> {
        entry(self.root.get_ref(), "tool").and_then(|list| list.get_ref().get(index))
    }

    /// Name of the tool whose text holds a place: the last one that begins before it.
    fn tool_at(&self, span: &Range<usize>) -> String {
        let named = |i: usize| {
            let tool = self.tool(i)?;
            let name = tool.get_ref().get("name").and_then(|n| n.get_ref().as_str()).unwrap_or("");
            Some((tool.span().start, name))
        };
        (0..).map_while(named).take_while(|(start, _)| *start <= span.start).last().map_or("", |t| t.1).to_owned()
    }

    /// Checks keys, types and enumerations against a JSON Schema.
    pub(crate) fn check(&self, schema: &Value) -> Result<(), Box<Defect>> {
        self.check_table(self.root.get_ref(), &self.root.span(), resolved(schema, schema), schema)
    }

    fn check_table(
        &self,
        table: &DeTable<'_>,
        span: &Range<usize>,
        schema: &Value,
        all: &Value,
    ) -> Result<(), Box<Defect>> {
        let Some(known) = schema.get("properties").and_then(Value::as_object) else { return Ok(()) };
        for (key, value) in table {
            let Some(inner) = known.get(key.get_ref().as_ref()) else {
                let remedy = match nearest(key.get_ref(), known.keys().map(String::as_str)) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => {
                        let list: Vec<_> = known.keys().map(String::as_str).collect();
                        format!("known keys are {}", list.join(", "))
                    }
                };
                let mut defect = self.defect(&key.span(), key.get_ref(), "is not a known key".into(), remedy);
                defect.value = String::new();
                return Err(defect);
            };
            self.check_value(key.get_ref(), value, resolved(inner, all), all)?;
        }
        let required = schema.get("required").and_then(Value::as_array);
        for key in required.into_iter().flatten().filter_map(Value::as_str) {
            if entry(table, key).is_none() {
                let mut defect = self.defect(span, key, "is missing".into(), format!("add `{key} = ...`"));
                defect.value = String::new();
                return Err(defect);
            }
        }
        Ok(())
    }

    fn check_value(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        schema: &Value,
        all: &Value,
    ) -> Result<(), Box<Defect>> {
        let wrong = |what: String, remedy: String| Err(self.defect(&value.span(), key, what, remedy));
        let words = enumeration(schema);
        if !words.is_empty() {
            let word = value.get_ref().as_str().unwrap_or("");
            if words.contains(&word) {
                return Ok(());
            }
            let remedy = match nearest(word, words.iter().copied()) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("write one of {}", words.join(", ")),
            };
            return wrong(format!("must be one of {}", words.join(", ")), remedy);
        }
        let type_is = |name: &str| match schema.get("type") {
            Some(Value::String(t)) => t == name,
            Some(Value::Array(list)) => list.iter().any(|t| t == name),
            _ => false,
        };
        match value.get_ref() {
            DeValue::Table(table) if type_is("object") => self.check_table(table, &value.span(), schema, all),
            DeValue::Array(list) if type_is("array") => {
                let count = list.iter().len() as u64;
                let fewest = schema.get("minItems").and_then(Value::as_u64).unwrap_or(0);
                let most = schema.get("maxItems").and_then(Value::as_u64).unwrap_or(u64::MAX);
                if count < fewest || count > most {
                    return wrong(format!("must have {fewest} values"), "write `[radius, height]`".into());
                }
                match schema.get("items") {
                    Some(inner) => list.iter().try_for_each(|v| self.check_value(key, v, resolved(inner, all), all)),
                    None => Ok(()),
                }
            }
            DeValue::Float(number) if type_is("number") => {
                if number.as_str().contains("inf") || number.as_str().contains("nan") {
                    return wrong("must be a finite number".into(), "write the dimension".into());
                }
                Ok(())
            }
            DeValue::Integer(_) if type_is("number") || type_is("integer") => Ok(()),
            DeValue::String(_) if type_is("string") => Ok(()),
            DeValue::Boolean(_) if type_is("boolean") => Ok(()),
            _ => {
                let name = ["number", "integer", "string", "boolean", "array", "object"]
                    .into_iter()
                    .find(|n| type_is(n))
                    .map_or("another type", |n| match n {
                        "number" => "a number",
                        "integer" => "a whole number",
                        "string" => "text in quotes",
                        "boolean" => "true or false",
                        "array" => "a list [...]",
                        _ => "a table",
                    });
                wrong(format!("must be {name}"), String::new())
            }
        }
    }
}

fn entry<'t, 'a>(table: &'t DeTable<'a>, key: &str) -> Option<&'t Spanned<DeValue<'a>>> {
    table.iter().find(|(k, _)| k.get_ref() == key).map(|(_, v)| v)
}

/// Follows references, and the one alternative of an optional value that is not null.
fn resolved<'s>(schema: &'s Value, all: &'s Value) -> &'s Value {
    if let Some(reference) = schema.get("$ref").and_then(Value::as_str) {
        let target = reference.strip_prefix('#').and_then(|pointer| all.pointer(pointer));
        return target.map_or(schema, |s| resolved(s, all));
    }
    let alternatives = schema.get("anyOf").and_then(Value::as_array);
    let real = alternatives.into_iter().flatten().find(|s| s.get("type") != Some(&Value::from("null")));
    real.map_or(schema, |s| resolved(s, all))
}

/// Words that a value may be.
fn enumeration(schema: &Value) -> Vec<&str> {
    let listed = schema.get("enum").and_then(Value::as_array).into_iter().flatten();
    let described = schema.get("oneOf").and_then(Value::as_array).into_iter().flatten();
    listed.chain(described.filter_map(|s| s.get("const"))).filter_map(Value::as_str).collect()
}

/// Line and column, both from 1, of a byte of a text.
fn place(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte.min(text.len())).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |l| l.chars().count()) + 1;
    (line, column)
}

/// The text of a value, cut short.
fn shown(text: &str, span: &Range<usize>) -> String {
    const MOST: usize = 60;
    let value = text.get(span.clone()).unwrap_or("").lines().next().unwrap_or("").trim();
    if value.chars().count() <= MOST {
        value.to_owned()
    } else {
        value.chars().take(MOST).chain("...".chars()).collect()
    }
}
