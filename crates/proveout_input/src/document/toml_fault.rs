//! What the TOML reader found. Its errors are texts alone: this is the one place that takes them apart.

/// What is wrong with a TOML text, from the message of the reader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TomlFault<'a> {
    /// A key that its table does not have, and the keys that it has.
    UnknownKey {
        /// The key, where the message names it.
        key: Option<&'a str>,
        /// Keys of the table.
        known: Vec<&'a str>,
    },
    /// A key that the table must have.
    MissingKey(&'a str),
    /// A word that is none of those of a key.
    UnknownWord {
        /// The word, where the message names it.
        word: Option<&'a str>,
        /// The words of the key.
        known: Vec<&'a str>,
    },
    /// A value of another type.
    WrongType(ExpectedType<'a>),
    /// A value in none of several forms.
    NoForm,
    /// Anything else; the message in one line.
    Other(&'a str),
}

/// The type that a value must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExpectedType<'a> {
    /// A number.
    Number,
    /// A whole number.
    Whole,
    /// A whole number, 0 or more.
    Unsigned,
    /// A whole number, 0 to the largest one.
    UnsignedTo(u64),
    /// A whole number, 1 or more.
    Positive,
    /// True or false.
    Flag,
    /// Text.
    Text,
    /// A list.
    List,
    /// A list with so many values.
    ListOf(u64),
    /// A table.
    Table,
    /// Another one, in the words of the reader.
    Other(&'a str),
}

impl<'a> TomlFault<'a> {
    /// Takes a message apart; the names in back quotes are a key or word and its alternatives.
    pub fn of(message: &'a str) -> Self {
        let message = message.lines().next().unwrap_or_default().trim();
        let mut quoted = message.split('`').skip(1).step_by(2);
        if message.starts_with("unknown field") {
            return Self::UnknownKey { key: quoted.next(), known: quoted.collect() };
        }
        if message.starts_with("missing field") {
            return Self::MissingKey(quoted.next().unwrap_or_default());
        }
        if message.starts_with("unknown variant") {
            return Self::UnknownWord { word: quoted.next(), known: quoted.collect() };
        }
        if ["invalid type", "invalid value", "invalid length"].iter().any(|begin| message.starts_with(begin))
            && let Some((found, expected)) = message.rsplit_once(", expected ")
        {
            return Self::WrongType(ExpectedType::of(found, expected.trim()));
        }
        if message.contains("untagged enum") { Self::NoForm } else { Self::Other(message) }
    }
}

impl<'a> ExpectedType<'a> {
    /// From the reader's name of a type; `found` names the value.
    fn of(found: &str, expected: &'a str) -> Self {
        let count = || expected.split_whitespace().find_map(|word| word.parse::<u64>().ok());
        // A number that is too large for its type is given in back quotes.
        let is_large = || found.contains('`') && !found.contains("`-");
        match expected {
            "f64" | "f32" => Self::Number,
            "u8" if is_large() => Self::UnsignedTo(u64::from(u8::MAX)),
            "u16" if is_large() => Self::UnsignedTo(u64::from(u16::MAX)),
            "u32" if is_large() => Self::UnsignedTo(u64::from(u32::MAX)),
            "u64" | "usize" if is_large() => Self::UnsignedTo(u64::MAX),
            "u8" | "u16" | "u32" | "u64" | "usize" => Self::Unsigned,
            "i8" | "i16" | "i32" | "i64" | "isize" => Self::Whole,
            "a boolean" => Self::Flag,
            "a string" | "path string" | "a borrowed string" => Self::Text,
            "a sequence" => Self::List,
            "a map" => Self::Table,
            _ if expected.starts_with("struct ") => Self::Table,
            _ if expected.starts_with("an array of length") || expected.starts_with("a tuple of size") => {
                count().map_or(Self::Other(expected), Self::ListOf)
            }
            _ if expected.starts_with("a nonzero ") => Self::Positive,
            _ => Self::Other(expected),
        }
    }

    /// Whether a number is wanted.
    pub fn is_number(self) -> bool {
        matches!(self, Self::Number | Self::Whole | Self::Unsigned | Self::UnsignedTo(_) | Self::Positive)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_the_reader_are_told_apart() {
        #[derive(Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        #[allow(dead_code, reason = "only its errors are looked at")]
        struct Block {
            height_mm: f64,
            teeth: u8,
            name: Option<String>,
            at: Option<[f64; 3]>,
            kind: Option<Kind>,
        }
        #[derive(Debug, serde::Deserialize)]
        #[serde(rename_all = "lowercase")]
        enum Kind {
            Vise,
            Plate,
        }
        let fault = |text: &str| toml::from_str::<Block>(text).expect_err(text).message().to_owned();
        let said = fault("height_m = 1\nteeth = 1");
        let keys = vec!["height_mm", "teeth", "name", "at", "kind"];
        assert_eq!(TomlFault::of(&said), TomlFault::UnknownKey { key: Some("height_m"), known: keys });
        assert_eq!(TomlFault::of(&fault("teeth = 1")), TomlFault::MissingKey("height_mm"));
        let said = fault("height_mm = 1\nteeth = 1\nkind = \"wise\"");
        assert_eq!(TomlFault::of(&said), TomlFault::UnknownWord { word: Some("wise"), known: vec!["vise", "plate"] });
        for (value, expected) in [
            ("height_mm = \"1\"\nteeth = 1", ExpectedType::Number),
            ("height_mm = 1\nteeth = 300", ExpectedType::UnsignedTo(255)),
            ("height_mm = 1\nteeth = -3", ExpectedType::Unsigned),
            ("height_mm = 1\nteeth = 1\nname = 3", ExpectedType::Text),
            ("height_mm = 1\nteeth = 1\nat = [1, 2]", ExpectedType::ListOf(3)),
        ] {
            assert_eq!(TomlFault::of(&fault(value)), TomlFault::WrongType(expected), "{value}");
        }
    }
}
