//! Cuts APT CL text into statements: `$` continues a line, `$$` begins a comment, `major/minor,minor,...`.

/// A word or number with its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Word {
    pub(crate) text: String,
    pub(crate) line: u32,
    pub(crate) column: u32,
}

/// One statement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Words {
    pub(crate) line: u32,
    pub(crate) column: u32,
    /// Major word, upper case, single blanks inside (`TOOL PATH`).
    pub(crate) major: String,
    /// What stands behind the slash, cut at commas.
    pub(crate) minors: Vec<Word>,
    /// The statement as written, lines joined.
    pub(crate) raw: String,
    /// Text behind `$$`.
    pub(crate) comment: Option<String>,
}

/// Statements of a text, in order; lines without content are left out.
pub(crate) fn statements(text: &str) -> Vec<Words> {
    let mut out = Vec::new();
    let mut open: Option<Words> = None;
    for (number, full) in text.lines().enumerate() {
        let line = number as u32 + 1;
        let (code, comment) = match full.find("$$") {
            Some(at) => (&full[..at], Some(full[at + 2..].trim().to_owned())),
            None => (full, None),
        };
        let trimmed = code.trim_end();
        let (body, continues) = match trimmed.strip_suffix('$') {
            Some(rest) => (rest, true),
            None => (trimmed, false),
        };
        if let Some(words) = open.as_mut() {
            append(words, body, line, 0);
        } else if !body.trim().is_empty() || comment.is_some() {
            open = Some(begin(body, line));
        }
        if let Some(words) = open.as_mut()
            && comment.is_some()
        {
            words.comment = comment;
        }
        if !continues {
            out.extend(open.take());
        }
    }
    out.extend(open);
    out
}

fn begin(body: &str, line: u32) -> Words {
    let indent = body.len() - body.trim_start().len();
    let (major, rest_at) = match body.find('/') {
        Some(at) => (&body[..at], Some(at + 1)),
        None => (body, None),
    };
    let mut words = Words {
        line,
        column: body[..indent].chars().count() as u32 + 1,
        major: major.split_whitespace().collect::<Vec<_>>().join(" ").to_uppercase(),
        minors: Vec::new(),
        raw: String::new(),
        comment: None,
    };
    match rest_at {
        Some(at) => append_from(&mut words, body, line, at),
        None => words.raw.push_str(body.trim()),
    }
    words
}

fn append(words: &mut Words, body: &str, line: u32, at: usize) {
    append_from(words, body, line, at);
}

fn append_from(words: &mut Words, body: &str, line: u32, at: usize) {
    words.raw.push_str(body.trim());
    let mut start = at;
    for part in body[at..].split(',') {
        let lead = part.len() - part.trim_start().len();
        let text = part.trim();
        if !text.is_empty() {
            let column = body[..start + lead].chars().count() as u32 + 1;
            words.minors.push(Word { text: text.to_owned(), line, column });
        }
        start += part.len() + 1;
    }
}
