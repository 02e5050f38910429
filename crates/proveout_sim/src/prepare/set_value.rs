//! A value of the call that overrides one in the files: `KEY=VALUE`.

use std::str::FromStr;

use crate::scene::ChoiceValueFile;

/// A key and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct SetValue {
    /// The key, as the module says.
    pub key: String,
    /// Its value.
    pub value: ChoiceValueFile,
}

/// `KEY=VALUE`: a number, `true`, `false`, or else a word.
impl FromStr for SetValue {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text.split_once('=').ok_or("write KEY=VALUE, such as resolution_mm=0.2")?;
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || key.split('.').any(|step| step.trim().is_empty()) {
            return Err(format!("{key:?} is not a key: write tables and key with dots between them"));
        }
        if value.is_empty() {
            return Err(format!("{key} has no value"));
        }
        let number = |v: f64| v.is_finite().then_some(ChoiceValueFile::Number(v));
        let value = match (value, value.parse::<i64>(), value.parse::<f64>()) {
            ("true" | "false", ..) => ChoiceValueFile::Switch(value == "true"),
            (_, Ok(whole), _) => ChoiceValueFile::Whole(whole),
            (_, _, Ok(v)) => number(v).ok_or_else(|| format!("{key} = {value} is not a usable number"))?,
            _ => ChoiceValueFile::Word(
                value.strip_prefix('"').and_then(|v| v.strip_suffix('"')).unwrap_or(value).to_owned(),
            ),
        };
        Ok(Self { key: key.to_owned(), value })
    }
}
