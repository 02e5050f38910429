//! F words of a program text: found and rewritten, byte for byte the same but for them.
//!
//! The text is not parsed here. Comments and strings are passed over, and an F that begins a word is a feed.
//! Whether it was one is for the reader to say: who changes feeds reads the new text again, and compares all
//! commands but the feeds ([`same_but_feeds`]) and the feed of every motion ([`feed_motions`]).

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::settings::Dialect;
use crate::{Command, Feed, Op};

/// The F word of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum FeedWord {
    /// A number, in the unit of the program.
    Number {
        /// Its value.
        value: f64,
        /// Its text without the letter.
        text: String,
    },
    /// A value that the control computes (`F=R5`, `F#101`, `F Q1`): its text.
    Computed(String),
}

/// Why the feeds of a text cannot be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FeedTextFault {
    /// UTF-16: its bytes are no characters of a program.
    Wide,
    /// CL data has statements of its own for feeds.
    ClData,
}

/// A program text by lines.
#[derive(Clone, Debug)]
pub struct FeedText {
    bytes: Vec<u8>,
    lines: Vec<Range<usize>>,
    family: Dialect,
}

impl FeedText {
    /// Takes the bytes of a program file.
    ///
    /// # Errors
    /// A text whose feeds are no F words of single bytes.
    pub fn new(bytes: Vec<u8>, dialect: Dialect) -> Result<Self, FeedTextFault> {
        if bytes.starts_with(&[0xFE, 0xFF]) || bytes.starts_with(&[0xFF, 0xFE]) {
            return Err(FeedTextFault::Wide);
        }
        let family = dialect.family();
        if family == Dialect::Apt {
            return Err(FeedTextFault::ClData);
        }
        let mut lines = Vec::new();
        let mut first = 0;
        for (at, byte) in bytes.iter().enumerate() {
            if *byte == b'\n' {
                lines.push(first..at);
                first = at + 1;
            }
        }
        lines.push(first..bytes.len());
        Ok(Self { bytes, lines, family })
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Number of lines.
    pub fn lines(&self) -> u32 {
        self.lines.len() as u32
    }

    fn line(&self, line: u32) -> &[u8] {
        let range = (line as usize).checked_sub(1).and_then(|k| self.lines.get(k));
        range.and_then(|r| self.bytes.get(r.clone())).unwrap_or(&[])
    }

    /// The first F word of a line, counted from 1.
    pub fn word(&self, line: u32) -> Option<FeedWord> {
        let line = self.line(line);
        let place = self.place(line)?;
        let text = |r: &Range<usize>| String::from_utf8_lossy(line.get(r.clone()).unwrap_or(&[])).into_owned();
        Some(match place {
            Place::Number(range) => {
                let text = text(&range);
                FeedWord::Number { value: text.parse().ok()?, text }
            }
            Place::Computed(range) => FeedWord::Computed(text(&range)),
        })
    }

    /// The text with new F words on lines: the text after the letter, by line from 1. A line without an F
    /// word gets one at the end of its block.
    pub fn with_feeds(&self, feeds: &BTreeMap<u32, String>) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.bytes.len() + 8 * feeds.len());
        for (k, range) in self.lines.iter().enumerate() {
            if k > 0 {
                out.push(b'\n');
            }
            let line = self.bytes.get(range.clone()).unwrap_or(&[]);
            let Some(feed) = feeds.get(&(k as u32 + 1)) else {
                out.extend_from_slice(line);
                continue;
            };
            match self.place(line) {
                Some(Place::Number(word) | Place::Computed(word)) => {
                    out.extend_from_slice(line.get(..word.start).unwrap_or(&[]));
                    out.extend_from_slice(feed.as_bytes());
                    out.extend_from_slice(line.get(word.end..).unwrap_or(&[]));
                }
                None => {
                    let at = self.room(line);
                    let (before, after) = line.split_at(at);
                    out.extend_from_slice(before);
                    out.extend_from_slice(b" F");
                    out.extend_from_slice(feed.as_bytes());
                    out.extend_from_slice(after);
                }
            }
        }
        out
    }

    /// Bytes of a line that are code: outside of comments and strings.
    fn code(&self, line: &[u8]) -> Vec<bool> {
        let mut code = vec![true; line.len()];
        let (mut depth, mut string) = (0_u32, false);
        for (at, &byte) in line.iter().enumerate() {
            let iso = self.family == Dialect::Iso;
            match byte {
                b'"' if !iso && depth == 0 => string = !string,
                b';' if !string && depth == 0 => {
                    code[at..].fill(false);
                    break;
                }
                b'(' if iso => depth += 1,
                _ => {}
            }
            code[at] = depth == 0 && !string && byte != b'"';
            if byte == b')' && iso {
                depth = depth.saturating_sub(1);
            }
        }
        code
    }

    /// The first F word: the range after the letter (and after a sign of equality before a number).
    fn place(&self, line: &[u8]) -> Option<Place> {
        let code = self.code(line);
        let byte = |at: usize| line.get(at).copied().filter(|_| code[at]);
        let is_name = |b: u8| b.is_ascii_alphabetic() || b == b'_' || b == b'$';
        for at in 0..line.len() {
            if !matches!(byte(at), Some(b'F' | b'f')) || at > 0 && byte(at - 1).is_some_and(is_name) {
                continue;
            }
            let blanks = |from: usize| (from..line.len()).find(|k| !matches!(byte(*k), Some(b' ' | b'\t')));
            let Some(mut from) = blanks(at + 1) else { continue };
            let equals = byte(from) == Some(b'=');
            if equals {
                from = blanks(from + 1)?;
            }
            let number = |b: Option<u8>| b.is_some_and(|b| b.is_ascii_digit() || matches!(b, b'.' | b'+' | b'-'));
            let end_of = |from: usize, part: &dyn Fn(u8) -> bool| {
                (from..line.len()).find(|k| !byte(*k).is_some_and(part)).unwrap_or(line.len())
            };
            if number(byte(from)) {
                let signed = from + usize::from(matches!(byte(from), Some(b'+' | b'-')));
                let end = end_of(signed, &|b| b.is_ascii_digit() || b == b'.');
                // `F=100*R1`: the number is not all of the value.
                let goes_on = equals && blanks(end).and_then(byte).is_some_and(|b| b"+-*/".contains(&b));
                if !goes_on {
                    return Some(Place::Number(from..end));
                }
            }
            let computed = match self.family {
                Dialect::Heidenhain => matches!(byte(from), Some(b'Q' | b'q')) || equals,
                Dialect::Siemens840d => equals,
                _ => equals || matches!(byte(from), Some(b'#' | b'[' | b'<')),
            };
            if computed {
                let end = end_of(from, &|b| !matches!(b, b' ' | b'\t' | b'\r'));
                return Some(Place::Computed(from..end));
            }
        }
        None
    }

    /// Where a new word goes: after the last word of the block, in Klartext before its M functions.
    fn room(&self, line: &[u8]) -> usize {
        let code = self.code(line);
        let ends_block = |b: u8| b.is_ascii_whitespace() || b == b'*' && self.family != Dialect::Siemens840d;
        let last = (0..line.len()).rev().find(|k| code[*k] && !ends_block(line[*k]));
        let end = last.map_or(0, |k| k + 1);
        if self.family != Dialect::Heidenhain {
            return end;
        }
        let begins_m = |k: &usize| {
            let here = line.get(*k..*k + 3);
            code[*k] && here.is_some_and(|w| w[0] == b' ' && matches!(w[1], b'M' | b'm') && w[2].is_ascii_digit())
        };
        (0..end).find(begins_m).unwrap_or(end)
    }
}

/// Where the F word of a line is.
enum Place {
    Number(Range<usize>),
    Computed(Range<usize>),
}

/// A motion in feed of a program, in the order of execution.
#[derive(Clone, Debug, PartialEq)]
pub struct FeedMotion {
    /// File as given.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Nesting of subprogram calls; 0 in the main program.
    pub depth: u32,
    /// Feed in force.
    pub feed: Option<Feed>,
    /// It is all that its block moves: no motion of a cycle, of an inserted corner or of a thread.
    pub plain: bool,
}

/// The motions in feed of a program, with the feed in force at each.
pub fn feed_motions(commands: &[Command]) -> Vec<FeedMotion> {
    let mut feed = None;
    let mut all = Vec::new();
    let place = |c: &Command| (Arc::clone(&c.location.file), c.location.line, c.location.depth);
    for block in commands.chunk_by(|a, b| place(a) == place(b)) {
        let moves = block.iter().filter(|c| is_motion(&c.op)).count();
        for command in block {
            match &command.op {
                Op::Feed(new) => feed = Some(*new),
                Op::Linear(_) | Op::Arc(_) | Op::Spline(_) => {
                    let (file, line, depth) = place(command);
                    all.push(FeedMotion { file, line, depth, feed, plain: moves == 1 });
                }
                _ => {}
            }
        }
    }
    all
}

fn is_motion(op: &Op) -> bool {
    matches!(
        op,
        Op::Rapid(_)
            | Op::Linear(_)
            | Op::Arc(_)
            | Op::Spline(_)
            | Op::Probe(_)
            | Op::Thread(_)
            | Op::Retract(_)
            | Op::Dwell(_)
    )
}

/// Whether two programs command the same but for their feeds; else the line of the first difference in the
/// second one, or 0 where one of them ends before the other.
///
/// # Errors
/// That line.
pub fn same_but_feeds(a: &[Command], b: &[Command]) -> Result<(), u32> {
    let rest = |all: &'_ [Command]| all.iter().filter(|c| !matches!(c.op, Op::Feed(_))).cloned().collect::<Vec<_>>();
    let (a, b) = (rest(a), rest(b));
    for (x, y) in a.iter().zip(&b) {
        if x.op != y.op || x.location.line != y.location.line || x.location.depth != y.location.depth {
            return Err(y.location.line);
        }
    }
    if a.len() == b.len() { Ok(()) } else { Err(0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(text: &str, dialect: Dialect) -> Option<FeedWord> {
        FeedText::new(text.as_bytes().to_vec(), dialect).unwrap_or_else(|e| panic!("{e:?}")).word(1)
    }

    fn number(text: &str) -> Option<FeedWord> {
        Some(FeedWord::Number { value: text.parse().unwrap_or_else(|e| panic!("{e}")), text: text.to_owned() })
    }

    #[test]
    fn an_f_word_is_found_in_the_code_alone() {
        use Dialect::{Fanuc, Heidenhain, Siemens840d};
        for (text, dialect, want) in [
            ("N10 G1 X10.F500. M8", Fanuc, number("500.")),
            ("G1 (F100) X1 F 250", Fanuc, number("250")),
            ("G1 X1 ; F100", Fanuc, None),
            ("G1 X1 Y2", Fanuc, None),
            ("IF[#1 GT 2] GOTO 5", Fanuc, None),
            ("G1 X1 F#101", Fanuc, Some(FeedWord::Computed("#101".into()))),
            ("G1 X1 F[2*3]", Fanuc, Some(FeedWord::Computed("[2*3]".into()))),
            ("MSG(\"F100\") G1 X1 F=300", Siemens840d, number("300")),
            ("G1 X1 F=R5", Siemens840d, Some(FeedWord::Computed("R5".into()))),
            ("G1 X1 F=100*R5", Siemens840d, Some(FeedWord::Computed("100*R5".into()))),
            ("GOTOF LABEL1", Siemens840d, None),
            ("FGROUP(X,Y) FB=20", Siemens840d, None),
            ("12 L X+10 R0 FMAX M3", Heidenhain, None),
            ("12 L X+10 R0 F AUTO", Heidenhain, None),
            ("12 L X+10 R0 F1200 M3", Heidenhain, number("1200")),
            ("12 L X+10 R0 F Q1", Heidenhain, Some(FeedWord::Computed("Q1".into()))),
            ("12 L X+10 FZ0.1", Heidenhain, None),
            ("", Fanuc, None),
            ("F", Fanuc, None),
            ("F=", Siemens840d, None),
        ] {
            assert_eq!(word(text, dialect), want, "{text}");
        }
    }

    #[test]
    fn a_text_with_new_feeds_differs_in_them_alone() {
        let change = |text: &str, dialect: Dialect, line: u32, feed: &str| {
            let text = FeedText::new(text.as_bytes().to_vec(), dialect).unwrap_or_else(|e| panic!("{e:?}"));
            String::from_utf8(text.with_feeds(&BTreeMap::from([(line, feed.to_owned())]))).unwrap_or_default()
        };
        let iso = "%\r\nG1 X1. F500. (cut)\r\nX2. (F9)\r\nM30\r\n%";
        assert_eq!(change(iso, Dialect::Fanuc, 2, "300."), "%\r\nG1 X1. F300. (cut)\r\nX2. (F9)\r\nM30\r\n%");
        assert_eq!(change(iso, Dialect::Fanuc, 3, "300."), "%\r\nG1 X1. F500. (cut)\r\nX2. F300. (F9)\r\nM30\r\n%");
        assert_eq!(change("5 L X+1 R0 M3 ; hi\n", Dialect::Heidenhain, 1, "80"), "5 L X+1 R0 F80 M3 ; hi\n");
        assert_eq!(change("N5 X1 *\n", Dialect::HeidenhainIso, 1, "80"), "N5 X1 F80 *\n");
        assert_eq!(change("G1 X1 F=500 ; hi", Dialect::Siemens840d, 1, "80"), "G1 X1 F=80 ; hi");
        // Nothing else moves, at any byte.
        let odd = b"\xFF\xE4 ; x\nG1 X1\n\n".to_vec();
        let text = FeedText::new(odd.clone(), Dialect::Siemens840d);
        assert_eq!(text.map(|t| t.with_feeds(&BTreeMap::new())), Ok(odd));
        assert_eq!(FeedText::new(vec![0xFF, 0xFE, 0], Dialect::Iso).err(), Some(FeedTextFault::Wide));
        assert_eq!(FeedText::new(Vec::new(), Dialect::Apt).err(), Some(FeedTextFault::ClData));
    }
}
