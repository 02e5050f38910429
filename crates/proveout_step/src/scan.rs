//! Instances and records of an exchange file (ISO 10303-21), without building its data.
//!
//! ```text
//!  #15 = MANIFOLD_SOLID_BREP ( 'plate' , #16 ) ;              one record
//!  #430 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(...) ) ;      several records of one instance
//! ```
//!
//! Strings are in apostrophes, an apostrophe in them is doubled; comments are between `/*` and `*/`. A
//! statement ends with a semicolon outside of both.

/// Statements of a text, one after the other, without surrounding space and comments.
pub(crate) struct Statements<'a> {
    text: &'a [u8],
    at: usize,
}

/// A text ended within a statement, a string or a comment: the place where that begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unended(pub(crate) usize);

impl<'a> Statements<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0 }
    }

    /// The next statement, with the place where it begins.
    pub(crate) fn next(&mut self) -> Result<Option<(usize, &'a [u8])>, Unended> {
        self.at = after_space(self.text, self.at)?;
        let begin = self.at;
        let mut at = begin;
        while let Some(byte) = self.text.get(at) {
            match byte {
                b';' => {
                    self.at = at + 1;
                    return Ok(Some((begin, self.text.get(begin..at).unwrap_or_default().trim_ascii_end())));
                }
                b'\'' => at = after_string(self.text, at)?,
                b'/' if self.text.get(at + 1) == Some(&b'*') => at = after_comment(self.text, at)?,
                _ => at += 1,
            }
        }
        if begin == self.text.len() { Ok(None) } else { Err(Unended(begin)) }
    }
}

/// The place after space, line ends and comments.
fn after_space(text: &[u8], mut at: usize) -> Result<usize, Unended> {
    while let Some(byte) = text.get(at) {
        match byte {
            b'/' if text.get(at + 1) == Some(&b'*') => at = after_comment(text, at)?,
            b if b.is_ascii_whitespace() || *b == 0 => at += 1,
            _ => break,
        }
    }
    Ok(at)
}

/// The place after the string that begins at a place. A doubled apostrophe ends one string and begins the
/// next.
fn after_string(text: &[u8], at: usize) -> Result<usize, Unended> {
    let rest = text.get(at + 1..).unwrap_or_default();
    rest.iter().position(|b| *b == b'\'').map(|length| at + length + 2).ok_or(Unended(at))
}

fn after_comment(text: &[u8], at: usize) -> Result<usize, Unended> {
    let rest = text.get(at + 2..).unwrap_or_default();
    rest.windows(2).position(|w| w == b"*/").map(|length| at + length + 4).ok_or(Unended(at))
}

/// Number and value of a statement `#15 = ...`.
pub(crate) fn instance(statement: &[u8]) -> Option<(u64, &[u8])> {
    let rest = statement.strip_prefix(b"#")?;
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let id = std::str::from_utf8(rest.get(..digits)?).ok()?.parse().ok()?;
    let value = rest.get(digits..)?.trim_ascii_start().strip_prefix(b"=")?;
    let begin = after_space(value, 0).ok()?;
    Some((id, value.get(begin..)?))
}

/// The number of a reference `#15`.
pub(crate) fn reference(value: &[u8]) -> Option<u64> {
    let digits = value.trim_ascii().strip_prefix(b"#")?;
    std::str::from_utf8(digits).ok()?.parse().ok()
}

/// Keyword and arguments of each record of an instance.
pub(crate) fn records(value: &[u8]) -> Vec<(&[u8], &[u8])> {
    let mut rest = match value.first() {
        Some(b'(') => inside(value).unwrap_or_default(),
        _ => value,
    };
    let mut found = Vec::new();
    while let Some(open) = rest.iter().position(|b| *b == b'(') {
        let (keyword, list) = rest.split_at(open);
        let Some(arguments) = inside(list) else { break };
        found.push((trimmed(keyword), arguments));
        rest = list.get(arguments.len() + 2..).unwrap_or_default();
    }
    found
}

/// A keyword without space and comments around it.
fn trimmed(keyword: &[u8]) -> &[u8] {
    let begin = after_space(keyword, 0).unwrap_or(0);
    let word = keyword.get(begin..).unwrap_or_default();
    let length = word.iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
    word.get(..length).unwrap_or_default()
}

/// What is between the parenthesis that a text begins with and the one that closes it.
fn inside(text: &[u8]) -> Option<&[u8]> {
    let (mut at, mut depth) = (0, 0_usize);
    while let Some(byte) = text.get(at) {
        match byte {
            b'(' => depth += 1,
            b')' => {
                depth = depth.checked_sub(1)?;
                if depth == 0 {
                    return text.get(1..at);
                }
            }
            b'\'' => {
                at = after_string(text, at).ok()?;
                continue;
            }
            b'/' if text.get(at + 1) == Some(&b'*') => {
                at = after_comment(text, at).ok()?;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    None
}

/// Arguments of a record, or members of a list in parentheses.
pub(crate) fn arguments(list: &[u8]) -> Vec<&[u8]> {
    let list = match list.trim_ascii() {
        l if l.first() == Some(&b'(') => inside(l).unwrap_or_default(),
        l => l,
    };
    let (mut at, mut depth, mut begin) = (0, 0_usize, 0);
    let mut found = Vec::new();
    while let Some(byte) = list.get(at) {
        match byte {
            b'(' => depth += 1,
            b')' => depth = depth.saturating_sub(1),
            b',' if depth == 0 => {
                found.push(list.get(begin..at).unwrap_or_default().trim_ascii());
                begin = at + 1;
            }
            b'\'' => {
                at = after_string(list, at).unwrap_or(list.len());
                continue;
            }
            b'/' if list.get(at + 1) == Some(&b'*') => {
                at = after_comment(list, at).unwrap_or(list.len());
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found.push(list.get(begin..).unwrap_or_default().trim_ascii());
    found
}

/// The text of a string argument: doubled apostrophes and the `\X2\` and `\X\` forms of other characters are
/// those that they mean. None of another argument.
pub(crate) fn string(argument: &[u8]) -> Option<String> {
    let raw = argument.trim_ascii().strip_prefix(b"'")?.strip_suffix(b"'")?;
    let text = String::from_utf8_lossy(raw).replace("''", "'");
    let mut found = String::new();
    let mut rest = text.as_str();
    while let Some(at) = rest.find('\\') {
        found.push_str(&rest[..at]);
        rest = &rest[at..];
        let taken = wide(rest).or_else(|| narrow(rest));
        let Some((meant, length)) = taken else {
            found.push('\\');
            rest = &rest[1..];
            continue;
        };
        found.push_str(&meant);
        rest = rest.get(length..).unwrap_or_default();
    }
    found.push_str(rest);
    // Control characters would garble a message.
    Some(found.chars().filter(|c| !c.is_control()).collect())
}

/// `\X2\00E4\X0\`: characters in UTF-16.
fn wide(text: &str) -> Option<(String, usize)> {
    let digits = text.strip_prefix("\\X2\\")?;
    let end = digits.find("\\X0\\")?;
    let units: Option<Vec<u16>> = digits
        .get(..end)?
        .as_bytes()
        .chunks(4)
        .map(|c| u16::from_str_radix(std::str::from_utf8(c).ok()?, 16).ok())
        .collect();
    Some((String::from_utf16_lossy(&units?), end + 8))
}

/// `\X\E4`: one character of ISO 8859-1.
fn narrow(text: &str) -> Option<(String, usize)> {
    let code = u8::from_str_radix(text.strip_prefix("\\X\\")?.get(..2)?, 16).ok()?;
    Some((char::from(code).to_string(), 5))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Result<Vec<&str>, Unended> {
        let mut statements = Statements::new(text.as_bytes());
        let mut found = Vec::new();
        while let Some((_, statement)) = statements.next()? {
            found.push(std::str::from_utf8(statement).expect("text"));
        }
        Ok(found)
    }

    #[test]
    fn semicolons_in_strings_and_comments_end_nothing() {
        let text = "A;\n/* #1=B; */ #2 = C('it''s; one', /* ; */ $) ;\n";
        assert_eq!(all(text), Ok(vec!["A", "#2 = C('it''s; one', /* ; */ $)"]));
        assert_eq!(all("A; #2 = C('it"), Err(Unended(10)), "the string");
        assert_eq!(all("A; #2 = C(1)"), Err(Unended(3)), "the statement");
        assert_eq!(all("A; /* for ever"), Err(Unended(3)), "the comment");
        assert_eq!(all(""), Ok(vec![]));
    }

    #[test]
    fn records_and_arguments_are_those_of_the_standard() {
        let (id, value) = instance(b"#430 = ( LENGTH_UNIT ( ) NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )").expect("one");
        assert_eq!(id, 430);
        let names: Vec<&[u8]> = records(value).iter().map(|r| r.0).collect();
        assert_eq!(names, [b"LENGTH_UNIT".as_slice(), b"NAMED_UNIT", b"SI_UNIT"]);
        assert_eq!(arguments(records(value)[2].1), [b".MILLI.".as_slice(), b".METRE."]);
        let (_, value) = instance(b"#7=ADVANCED_FACE('a,(b',(#18, #19),#32,.F.)").expect("one");
        let arguments_of = arguments(records(value)[0].1);
        assert_eq!(arguments_of.len(), 4);
        assert_eq!(string(arguments_of[0]).as_deref(), Some("a,(b"));
        assert_eq!(arguments(arguments_of[1]).iter().filter_map(|a| reference(a)).collect::<Vec<_>>(), [18, 19]);
        assert!(instance(b"DATA").is_none() && instance(b"#x=A()").is_none() && records(b"A(").is_empty());
    }

    #[test]
    fn strings_mean_what_their_escapes_say() {
        assert_eq!(string(b"'it''s'").as_deref(), Some("it's"));
        assert_eq!(string(b"'Fl\\X2\\00E4\\X0\\che'").as_deref(), Some("Fl\u{e4}che"));
        assert_eq!(string(b"'\\X\\E4\\S\\'").as_deref(), Some("\u{e4}\\S\\"));
        assert_eq!(string(b"'a\x1b[31m'").as_deref(), Some("a[31m"));
        assert_eq!((string(b"$"), string(b"'")), (None, None));
    }
}
