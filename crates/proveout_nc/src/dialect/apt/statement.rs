//! Splits text into statements: `major/minor,minor,...`, `$` at the end of a line continues it,
//! `$$` begins a comment.

use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::scan::Scanner;
use crate::source::{Mark, Source};

/// A stretch of one line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineRange {
    /// The line.
    pub(crate) mark: Mark,
    /// Bytes of the line.
    pub(crate) span: Span,
}

impl LineRange {
    pub(crate) fn bad(self, code: &'static str, message: impl Into<String>, help: impl Into<String>) -> Box<Bad> {
        self.with(Fault::new(code, self.span, message).help(help))
    }

    /// A fault of its line.
    pub(crate) fn with(self, fault: Fault) -> Box<Bad> {
        Box::new(Bad { fault, mark: self.mark })
    }

    pub(crate) fn text(self, source: &Source) -> &str {
        let line = source.text.get(self.mark.offset..).unwrap_or_default();
        line.get(self.span.start as usize..self.span.end as usize).unwrap_or_default()
    }
}

/// A fault with its line.
#[derive(Debug)]
pub(crate) struct Bad {
    pub(crate) fault: Fault,
    pub(crate) mark: Mark,
}

impl Bad {
    pub(crate) fn diagnostic(self, source: &Source) -> Diagnostic {
        let line = source.line(self.mark).map_or("", |(line, _)| line);
        self.fault.at(&source.name, self.mark.line, line)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Token {
    Number(f64),
    /// A word, a name, or a text between quotation marks.
    Word,
    Open,
    Close,
    /// After the major word of a nested definition, `(CIRCLE/...`.
    Slash,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Item {
    pub(crate) token: Token,
    pub(crate) place: LineRange,
}

/// One statement; used again for the next one, so that plain statements allocate nothing.
#[derive(Debug)]
pub(crate) struct AptStatement {
    /// Major word: upper case, single blanks inside (`TOOL PATH`), none next to commas
    /// (`TLON,GOFWD`). Empty for a line without a statement.
    pub(crate) major: String,
    pub(crate) head: LineRange,
    /// Items after the slash.
    pub(crate) items: Vec<Item>,
    /// The rest of the line for words that take a text (`PPRINT`).
    pub(crate) literal: LineRange,
    /// `NAME = ...`.
    pub(crate) assignment: bool,
}

impl Default for AptStatement {
    fn default() -> Self {
        let nowhere = LineRange { mark: Mark::START, span: Span::default() };
        Self { major: String::new(), head: nowhere, items: Vec::new(), literal: nowhere, assignment: false }
    }
}

/// Words that take the rest of their line as a text.
const TEXTS: [&str; 12] = [
    "PARTNO", "PPRINT", "TPRINT", "INSERT", "REMARK", "LETTER", "LEADER", "DISPLY", "TITLES", "PPWORD", "PPFUN",
    "LPRINT",
];

/// Reads the statement that begins at a line, and returns the line after it; none at the end of the
/// text.
pub(crate) fn read(source: &Source, at: Mark, out: &mut AptStatement) -> Option<(Result<(), Box<Bad>>, Mark)> {
    let (line, mut next) = source.line(at)?;
    out.items.clear();
    out.major.clear();
    out.assignment = false;
    let (code, mut open) = code_of(line);
    let start = code.len() - code.trim_start().len();
    let body = &code[start..];
    out.head = LineRange { mark: at, span: Span::new(start, start) };
    out.literal = out.head;
    if body.is_empty() {
        if line.trim_start().starts_with("$$->") && line.trim_end().ends_with('$') {
            next = behind_numbers(source, next);
        }
        return Some((Ok(()), next));
    }
    if let Some(rest) = text_word(body) {
        out.major.push_str(&body[..rest]);
        out.major.make_ascii_uppercase();
        // The text is taken unchanged, including what would elsewhere be a comment.
        let tail = line.get(start + rest..).unwrap_or_default();
        let lead = tail.len() - tail.trim_start().trim_start_matches('/').trim_start().len();
        out.head.span = Span::new(start, start + rest);
        out.literal.span = Span::new(start + rest + lead, line.trim_end().len());
        return Some((Ok(()), next));
    }
    let head_end = body.bytes().position(|b| b == b'/' || b == b'=').map_or(body.len(), |at| at);
    out.assignment = body.as_bytes().get(head_end) == Some(&b'=');
    major_word(&body[..head_end], &mut out.major);
    out.head.span = Span::new(start, start + body[..head_end].trim_end().len());
    let mut value = false;
    let from = (start + head_end + 1).min(code.len());
    let mut result = items(code, from, at, &mut value, &mut out.items);
    let mut last = at;
    while open {
        let Some((line, after)) = source.line(next) else {
            let place = LineRange { mark: last, span: Span::new(0, source.line(last).map_or(0, |(l, _)| l.len())) };
            let fault = place.bad(
                codes::SYNTAX,
                "the text ends in a statement that `$` continues",
                "write the rest of the statement, or remove the `$`",
            );
            return Some((result.and(Err(fault)), next));
        };
        let (code, more) = code_of(line);
        if result.is_ok() {
            result = items(code, 0, next, &mut value, &mut out.items);
        }
        (open, last, next) = (more, next, after);
    }
    // CATIA omits values of TOOLNO; none of them has an effect.
    if result.is_err() && out.major == "TOOLNO" {
        result = Ok(());
    }
    Some((result, next))
}

/// Skips the lines of numbers that continue a remark of Creo, such as `$$-> CSYS / 1.0, 0.0, $`;
/// other lines are statements.
fn behind_numbers(source: &Source, mut at: Mark) -> Mark {
    while let Some((line, next)) = source.line(at) {
        let numbers = line.bytes().all(|b| b.is_ascii_digit() || b" \t+-.,eE$".contains(&b));
        if !numbers || !line.bytes().any(|b| b.is_ascii_digit()) {
            break;
        }
        at = next;
        if !line.trim_end().ends_with('$') {
            break;
        }
    }
    at
}

/// A line without its comment and its `$`; true when the next line continues it.
fn code_of(line: &str) -> (&str, bool) {
    let bytes = line.as_bytes();
    let code = match bytes.iter().position(|&b| b == b'$') {
        None => return (line.trim_end(), false),
        Some(first) if bytes.get(first + 1) == Some(&b'$') => &line[..first],
        Some(_) => line.find("$$").map_or(line, |at| &line[..at]),
    };
    let code = code.trim_end();
    code.strip_suffix('$').map_or((code, false), |rest| (rest.trim_end(), true))
}

/// Length of the first word when it is one that takes a text.
fn text_word(body: &str) -> Option<usize> {
    let length = body.bytes().take_while(u8::is_ascii_alphabetic).count();
    let word = &body[..length];
    let ends = matches!(body.as_bytes().get(length), None | Some(b'/' | b' ' | b'\t'));
    (ends && TEXTS.iter().any(|text| text.eq_ignore_ascii_case(word))).then_some(length)
}

fn major_word(text: &str, out: &mut String) {
    let mut blank = false;
    for c in text.chars() {
        if c.is_whitespace() {
            blank = !out.is_empty();
            continue;
        }
        if blank && c != ',' && !out.ends_with(',') {
            out.push(' ');
        }
        blank = false;
        out.push(c.to_ascii_uppercase());
    }
}

/// Items of a line. `value`: the previous item is a value, so a comma must come next.
fn items(code: &str, from: usize, mark: Mark, value: &mut bool, out: &mut Vec<Item>) -> Result<(), Box<Bad>> {
    let mut s = Scanner::new(code);
    s.set_pos(from);
    loop {
        s.skip_blanks();
        if s.at_end() {
            return Ok(());
        }
        let start = s.pos();
        let place = |s: &Scanner<'_>| LineRange { mark, span: s.span_from(start) };
        if s.take(b',') {
            if !*value {
                return Err(place(&s).bad(codes::SYNTAX, "no value before this comma", "write the value"));
            }
            *value = false;
            continue;
        }
        let token = if s.take(b'(') {
            *value = false;
            out.push(Item { token: Token::Open, place: place(&s) });
            continue;
        } else if s.take(b')') {
            Token::Close
        } else if s.take(b'/') {
            *value = false;
            out.push(Item { token: Token::Slash, place: place(&s) });
            continue;
        } else if *value {
            while !s.at_end() && !matches!(s.peek(), b',' | b' ' | b'\t') {
                s.bump();
            }
            return Err(place(&s).bad(
                codes::SYNTAX,
                "a comma is missing before this word",
                "write a comma between values",
            ));
        } else {
            item(&mut s)
        };
        *value = true;
        out.push(Item { token, place: place(&s) });
    }
}

/// A number or a word.
fn item(s: &mut Scanner<'_>) -> Token {
    let start = s.pos();
    if matches!(s.peek(), b'\'' | b'"') {
        let quote = s.peek();
        s.bump();
        while !s.at_end() && s.peek() != quote {
            s.bump();
        }
        s.bump();
        return Token::Word;
    }
    if let Some(mut number) = s.decimal() {
        if matches!(s.peek(), b'e' | b'E' | b'd' | b'D')
            && (s.peek_at(1).is_ascii_digit() || matches!(s.peek_at(1), b'+' | b'-') && s.peek_at(2).is_ascii_digit())
        {
            s.bump();
            s.bump();
            while s.peek().is_ascii_digit() {
                s.bump();
            }
            // FORTRAN writes double precision with D.
            let text = s.slice(start).replace(['d', 'D'], "e");
            number = text.parse().unwrap_or(f64::INFINITY);
        }
        if matches!(s.peek(), b',' | b' ' | b'\t' | b')' | b'(' | b'/') || s.at_end() {
            return Token::Number(number);
        }
    }
    let mut end = s.pos().max(start);
    while !s.at_end() && !matches!(s.peek(), b',' | b'(' | b')' | b'/') {
        let blank = matches!(s.peek(), b' ' | b'\t');
        s.bump();
        if !blank {
            end = s.pos();
        }
    }
    s.set_pos(end);
    Token::Word
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> (String, Vec<Token>, bool) {
        let source = Source::new("t", text.to_owned());
        let mut statement = AptStatement::default();
        let (result, _) = read(&source, Mark::START, &mut statement).unwrap();
        let tokens = statement.items.iter().map(|i| i.token).collect();
        (statement.major, tokens, result.is_ok())
    }

    #[test]
    fn statements_are_cut_at_their_signs() {
        use Token::{Close, Number, Open, Slash, Word};
        assert_eq!(
            parse(" goto  / 1, -2.5 ,3E1"),
            ("GOTO".into(), vec![Number(1.0), Number(-2.5), Number(30.0)], true)
        );
        assert_eq!(
            parse("GOTO/1,$ $$ one\n 2,$\n3D0"),
            ("GOTO".into(), vec![Number(1.0), Number(2.0), Number(3.0)], true)
        );
        assert_eq!(
            parse("TLON , GOFWD/ (CIRCLE/ 1,2),ON"),
            ("TLON,GOFWD".into(), vec![Open, Word, Slash, Number(1.0), Number(2.0), Close, Word], true)
        );
        assert_eq!(parse("TOOL  PATH/A B,TOOL,3D"), ("TOOL PATH".into(), vec![Word, Word, Word], true));
        assert_eq!(parse("$$ only a comment").0, "");
        assert!(!parse("GOTO/1,,2").2 && !parse("GOTO/1 2").2 && !parse("GOTO/1,$").2);
    }
}
