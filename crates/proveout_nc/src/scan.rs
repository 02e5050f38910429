//! Character level of all word-address dialects: blanks, numbers, identifiers.

use crate::diagnostic::Span;

/// Reads one line from left to right. The position is always on a character boundary.
#[derive(Clone, Debug)]
pub(crate) struct Scanner<'a> {
    text: &'a str,
    pos: usize,
}

impl<'a> Scanner<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        Self { text, pos: 0 }
    }

    pub(crate) fn pos(&self) -> usize {
        self.pos
    }

    pub(crate) fn set_pos(&mut self, pos: usize) {
        self.pos = pos;
    }

    /// Next byte; 0 at the end of the line.
    pub(crate) fn peek(&self) -> u8 {
        self.peek_at(0)
    }

    pub(crate) fn peek_at(&self, ahead: usize) -> u8 {
        self.text.as_bytes().get(self.pos + ahead).copied().unwrap_or(0)
    }

    pub(crate) fn at_end(&self) -> bool {
        self.pos >= self.text.len()
    }

    /// Next character, for messages.
    pub(crate) fn peek_char(&self) -> Option<char> {
        self.text[self.pos..].chars().next()
    }

    /// Steps over one character.
    #[inline]
    pub(crate) fn bump(&mut self) {
        if self.text.as_bytes().get(self.pos).is_some_and(u8::is_ascii) {
            self.pos += 1;
            return;
        }
        self.pos += self.peek_char().map_or(0, char::len_utf8);
    }

    /// Span of the next character.
    pub(crate) fn here(&self) -> Span {
        Span::new(self.pos, self.pos + self.peek_char().map_or(0, char::len_utf8))
    }

    pub(crate) fn span_from(&self, start: usize) -> Span {
        Span::new(start, self.pos)
    }

    pub(crate) fn slice(&self, start: usize) -> &'a str {
        &self.text[start..self.pos]
    }

    pub(crate) fn skip_blanks(&mut self) {
        while let Some(b' ' | b'\t') = self.text.as_bytes().get(self.pos) {
            self.pos += 1;
        }
    }

    /// Takes this ASCII byte if it is next.
    pub(crate) fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == byte && !self.at_end();
        self.pos += usize::from(found);
        found
    }

    /// Takes `[A-Za-z0-9_$]*`.
    pub(crate) fn identifier(&mut self) -> &'a str {
        let start = self.pos;
        while matches!(self.peek(), b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'_' | b'$') {
            self.pos += 1;
        }
        self.slice(start)
    }

    /// Takes the digits of an integer; none where there is no digit or where it has more than nine.
    pub(crate) fn integer(&mut self) -> Option<u32> {
        let start = self.pos;
        let mut value = 0u32;
        while let Some(digit @ b'0'..=b'9') = self.text.as_bytes().get(self.pos) {
            if self.pos - start >= 9 {
                return None;
            }
            value = value * 10 + u32::from(digit - b'0');
            self.pos += 1;
        }
        (self.pos > start).then_some(value)
    }

    /// Takes a decimal number without exponent: `[+-]? digits [. digits]` or `[+-]? . digits`. Stays where
    /// there is none.
    ///
    /// Up to 15 digits, the quotient of two exact doubles is the correctly rounded value (Clinger 1990, fast
    /// path); longer numbers take the general way.
    pub(crate) fn decimal(&mut self) -> Option<f64> {
        const POWERS: [f64; 16] =
            [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
        let start = self.pos;
        let bytes = self.text.as_bytes();
        let negative = matches!(bytes.get(start), Some(b'-'));
        let digits_from = start + usize::from(matches!(bytes.get(start), Some(b'-' | b'+')));
        // The value of more digits than fit is not used.
        let mut mantissa = 0u64;
        let mut digits = |mut at: usize| {
            while let Some(digit @ b'0'..=b'9') = bytes.get(at) {
                mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
                at += 1;
            }
            at
        };
        let mut end = digits(digits_from);
        let (mut count, mut decimals) = (end - digits_from, 0);
        if let Some(b'.') = bytes.get(end) {
            let from = end + 1;
            end = digits(from);
            decimals = end - from;
            count += decimals;
        }
        if count == 0 {
            return None;
        }
        self.pos = end;
        let magnitude = if count <= 15 {
            mantissa as f64 / POWERS[decimals]
        } else {
            // "5." and ".5" are valid for the standard parser too.
            self.text[digits_from..end].parse().unwrap_or(f64::INFINITY)
        };
        Some(if negative { -magnitude } else { magnitude })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_correctly_rounded() {
        for text in
            ["1", "-.5", "+5.", "165.236", "0.1", "123456789.123456", ".000000000000001", "99999999999999999999.5"]
        {
            let mut scanner = Scanner::new(text);
            let want: f64 = text.parse().unwrap();
            assert_eq!(scanner.decimal(), Some(want), "{text}");
            assert!(scanner.at_end());
        }
        for text in ["", "-", ".", "+.", "X"] {
            assert_eq!(Scanner::new(text).decimal(), None, "{text}");
        }
    }
}
