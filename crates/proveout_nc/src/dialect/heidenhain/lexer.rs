//! Words of both forms: blanks, comments, values, keywords.

use super::words::{FeedWord, Kind, Param, Value};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::scan::Scanner;

pub(crate) use crate::diagnostic::refused;

/// Scanner of one block, which may have several lines.
#[derive(Clone, Debug)]
pub(crate) struct Lexer<'a> {
    pub(crate) s: Scanner<'a>,
    text: &'a str,
    /// A comma is a decimal sign, as on controls with that setting. In DIN/ISO it separates a label
    /// number from its repeats.
    comma: bool,
}

impl<'a> Lexer<'a> {
    /// Klartext.
    pub(crate) fn new(text: &'a str) -> Self {
        Self { s: Scanner::new(text), text, comma: true }
    }

    pub(crate) fn din(text: &'a str) -> Self {
        Self { comma: false, ..Self::new(text) }
    }

    /// A number with its sign.
    pub(crate) fn number(&mut self) -> Option<f64> {
        let start = self.pos();
        let whole = self.s.decimal()?;
        if !self.comma || self.s.peek() != b',' || self.s.slice(start).contains('.') {
            return Some(whole);
        }
        self.s.bump();
        while self.s.peek().is_ascii_digit() {
            self.s.bump();
        }
        Scanner::new(&self.s.slice(start).replace(',', ".")).decimal()
    }

    /// Skips blanks, comments, continuation marks and line ends.
    pub(crate) fn blanks(&mut self) {
        loop {
            match self.s.peek() {
                b' ' | b'\t' | b'\n' | b'\r' | b'~' => self.s.bump(),
                b';' => {
                    let rest = &self.text.as_bytes()[self.s.pos()..];
                    let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                    self.s.set_pos(self.s.pos() + length);
                }
                _ => return,
            }
        }
    }

    /// True when nothing but blanks and comments follows.
    pub(crate) fn ended(&mut self) -> bool {
        self.blanks();
        self.s.at_end()
    }

    pub(crate) fn pos(&self) -> usize {
        self.s.pos()
    }

    pub(crate) fn set_pos(&mut self, pos: usize) {
        self.s.set_pos(pos);
    }

    pub(crate) fn span_from(&self, start: usize) -> Span {
        self.s.span_from(start)
    }

    pub(crate) fn peek(&self) -> u8 {
        self.s.peek().to_ascii_uppercase()
    }

    pub(crate) fn peek_at(&self, ahead: usize) -> u8 {
        self.s.peek_at(ahead).to_ascii_uppercase()
    }

    /// True when this upper-case text is next.
    pub(crate) fn at(&self, word: &str) -> bool {
        let bytes = &self.text.as_bytes()[self.s.pos()..];
        bytes.len() >= word.len() && bytes[..word.len()].eq_ignore_ascii_case(word.as_bytes())
    }

    /// Takes this upper-case text if it is next and no letter follows it; skips blanks before it.
    pub(crate) fn word(&mut self, word: &str) -> bool {
        let before = self.pos();
        self.blanks();
        if self.at(word) && !self.peek_at(word.len()).is_ascii_alphabetic() {
            self.set_pos(self.pos() + word.len());
            return true;
        }
        self.set_pos(before);
        false
    }

    /// Takes this text if it is next, whatever follows.
    pub(crate) fn prefix(&mut self, word: &str) -> bool {
        let before = self.pos();
        self.blanks();
        if self.at(word) {
            self.set_pos(self.pos() + word.len());
            return true;
        }
        self.set_pos(before);
        false
    }

    /// Takes the letters that are next, upper case.
    pub(crate) fn letters(&mut self) -> String {
        let start = self.pos();
        while self.peek().is_ascii_alphabetic() {
            self.s.bump();
        }
        self.s.slice(start).to_ascii_uppercase()
    }

    /// Takes the rest of the block up to a comment.
    pub(crate) fn rest(&mut self) -> &'a str {
        self.blanks();
        let start = self.pos();
        let rest = &self.text[start..];
        let length = rest.bytes().position(|b| matches!(b, b';' | b'\n')).unwrap_or(rest.len());
        self.set_pos(start + length);
        rest[..length].trim_end().trim_end_matches('~').trim_end()
    }

    /// `"text"` or `'text'`, if one is next.
    pub(crate) fn quoted(&mut self) -> Result<Option<String>, Fault> {
        self.blanks();
        let quote = self.s.peek();
        if !matches!(quote, b'"' | b'\'') {
            return Ok(None);
        }
        let start = self.pos();
        self.s.bump();
        let from = self.pos();
        while !self.s.at_end() && self.s.peek() != quote && self.s.peek() != b'\n' {
            self.s.bump();
        }
        let text = self.s.slice(from).to_owned();
        if self.s.take(quote) {
            return Ok(Some(text));
        }
        Err(Fault::new(codes::SYNTAX, self.span_from(start), "the text has no closing quotation mark")
            .help("write \" at its end"))
    }

    /// A Q parameter, if one is next.
    pub(crate) fn param(&mut self) -> Result<Option<Param>, Fault> {
        self.blanks();
        let start = self.pos();
        if self.peek() != b'Q' {
            return Ok(None);
        }
        let (kind, letters) = match self.peek_at(1) {
            b'L' => (Kind::Local, 2),
            b'R' => (Kind::Retained, 2),
            b'S' => (Kind::Text, 2),
            _ => (Kind::Global, 1),
        };
        if !self.peek_at(letters).is_ascii_digit() {
            return Ok(None);
        }
        self.set_pos(start + letters);
        let index = self.s.integer().ok_or_else(|| {
            Fault::new(codes::BAD_VALUE, self.span_from(start), "the number of the Q parameter is too large")
                .help("use Q0 to Q1999, QL0 to QL499, QR0 to QR499, QS0 to QS1999")
        })?;
        Ok(Some(Param { kind, index }))
    }

    /// A number or a signed Q parameter, if one is next.
    pub(crate) fn value(&mut self) -> Result<Option<Value>, Fault> {
        self.blanks();
        let start = self.pos();
        match self.s.peek() {
            b'0'..=b'9' | b'.' => {}
            b'+' | b'-' => {
                let negative = self.s.peek() == b'-';
                let mut probe = self.clone();
                probe.s.bump();
                if let Some(param) = probe.param()? {
                    *self = probe;
                    return Ok(Some(Value::Param { negative, param }));
                }
                probe.blanks();
                if !matches!(self.s.peek_at(1), b'0'..=b'9' | b'.') && matches!(probe.s.peek(), b'0'..=b'9' | b'.') {
                    // A blank between sign and digits.
                    *self = probe;
                    let number = self.number().unwrap_or(0.0);
                    return Ok(Some(Value::Number(if negative { -number } else { number })));
                }
            }
            b'Q' | b'q' => return Ok(self.param()?.map(|param| Value::Param { negative: false, param })),
            _ => return Ok(None),
        }
        let Some(number) = self.number() else { return Ok(None) };
        if number.is_finite() {
            return Ok(Some(Value::Number(number)));
        }
        Err(Fault::new(codes::BAD_VALUE, self.span_from(start), "the number is too large").help("use fewer digits"))
    }

    /// The value required after a word that began at `start`.
    pub(crate) fn need(&mut self, start: usize) -> Result<Value, Fault> {
        let end = self.pos();
        self.value()?.ok_or_else(|| {
            let span = Span::new(start, end);
            let word = self.text.get(start..end).unwrap_or_default().trim();
            Fault::new(codes::MISSING_VALUE, span, format!("`{word}` has no value"))
                .help(format!("write for example {word}+10 or {word}+Q1"))
        })
    }

    /// Feed after the `F` taken at `start`.
    pub(crate) fn feed(&mut self, start: usize) -> Result<FeedWord, Fault> {
        self.blanks();
        let timed = self.at("MAXT") && !matches!(self.peek_at(4), b'X' | b'Y' | b'Z');
        if !timed && self.prefix("MAX") {
            return Ok(FeedWord::Max);
        }
        if self.prefix("AUTO") {
            return Ok(FeedWord::Auto);
        }
        if self.at("U") && !self.peek_at(1).is_ascii_alphabetic() || self.at("UQ") {
            self.s.bump();
            return Ok(FeedWord::PerRevolution(self.need(start)?));
        }
        for (word, remedy) in [
            ("Z", "the number of teeth is in the tool table: write F in mm/min"),
            ("MAXT", "write F or FMAX"),
            ("T", "write F in mm/min"),
        ] {
            if self.at(word) {
                self.set_pos(self.pos() + word.len());
                return Err(refused(&format!("F{word}"), self.span_from(start), remedy));
            }
        }
        Ok(FeedWord::Value(self.need(start)?))
    }

    /// Fault for the text at the current position.
    pub(crate) fn unexpected(&mut self) -> Fault {
        self.blanks();
        let start = self.pos();
        while !self.s.at_end() && !matches!(self.s.peek(), b' ' | b'\t' | b'\n' | b';') {
            self.s.bump();
        }
        if self.pos() == start {
            return Fault::new(codes::SYNTAX, self.span_from(start), "the block is not complete")
                .help("write the missing words");
        }
        unknown(self.s.slice(start), self.span_from(start))
    }

    /// Nothing more may follow.
    pub(crate) fn finish(&mut self) -> Result<(), Fault> {
        if self.ended() { Ok(()) } else { Err(self.unexpected()) }
    }
}

pub(crate) fn unknown(word: &str, span: Span) -> Fault {
    Fault::new(codes::UNKNOWN_WORD, span, format!("unknown word `{}`", word.escape_default()))
        .help("see the coverage table of the Heidenhain reader for the words that are read")
}
