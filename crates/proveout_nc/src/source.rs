//! Program text with its name, line by line.
//!
//! Line ends are made LF when a text is taken over, so that all later stages meet one kind. Texts
//! have CR LF, a single CR (old Macs, some serial lines), or a mix of both. Where a text has line
//! feeds at all, a CR next to one belongs to it (`CR CR LF` of a transfer that converted twice,
//! `LF CR CR` of a punch); any other CR ends a line.

use std::path::Path;
use std::sync::Arc;

use crate::codes;
use crate::diagnostic::Diagnostic;

/// Largest file, in bytes: places in a line are 32-bit, places in a file 64-bit; a program beyond this is a
/// mistake.
const MAX_FILE_BYTES: u64 = 4 << 30;
/// Share of NUL bytes beyond which a file is taken for UTF-16 without its mark, or for no text at
/// all: in UTF-16 of a program every second byte is NUL; the leader of a tape is at the ends, which
/// are cut off before.
const NUL_SHARE: f64 = 0.1;

/// A program text.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) name: Arc<str>,
    pub(crate) text: String,
}

/// Start of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Mark {
    /// Byte of the first character in the text.
    pub(crate) offset: usize,
    /// Line number from 1.
    pub(crate) line: u32,
}

impl Mark {
    pub(crate) const START: Self = Self { offset: 0, line: 1 };
}

impl Source {
    pub(crate) fn new(name: &str, text: String) -> Self {
        Self { name: Arc::from(name), text: with_line_feeds(text) }
    }

    /// Reads a file. A byte order mark identifies UTF-16; text that is not UTF-8 is taken as
    /// Latin-1, as older controls write it.
    pub(crate) fn read(path: &Path) -> Result<Self, Box<Diagnostic>> {
        let name = path.display().to_string();
        let refuse = |message: String, help: &str| {
            Box::new(Diagnostic {
                code: codes::FILE,
                message,
                file: Arc::from(name.as_str()),
                line: 0,
                column: 0,
                length: 0,
                help: Some(help.to_owned()),
                source_line: Box::default(),
                about: None,
            })
        };
        let size =
            std::fs::metadata(path).map_err(|e| refuse(format!("{name} cannot be read: {e}"), "check the path"))?;
        if !size.is_file() {
            return Err(refuse(format!("{name} is not a file"), "name the program file"));
        }
        if size.len() > MAX_FILE_BYTES {
            let message = format!("{name} has {} bytes; the limit is {MAX_FILE_BYTES}", size.len());
            return Err(refuse(message, "split the program into subprograms"));
        }
        let bytes =
            std::fs::read(path).map_err(|e| refuse(format!("{name} cannot be read: {e}"), "check the rights"))?;
        let text = decoded(bytes).map_err(|what| {
            refuse(format!("{name} {what}"), "save the program as plain text (UTF-8, ASCII or Latin-1)")
        })?;
        Ok(Self::new(&name, text))
    }

    /// The line that starts at the mark, without its end, and the mark of the next line; none at the end of
    /// the text.
    pub(crate) fn line(&self, at: Mark) -> Option<(&str, Mark)> {
        let rest = self.text.get(at.offset..)?;
        if rest.is_empty() {
            return None;
        }
        let end = line_feed(rest.as_bytes()).unwrap_or(rest.len());
        let next = Mark { offset: at.offset + (end + 1).min(rest.len()), line: at.line + 1 };
        Some((&rest[..end], next))
    }

    /// Blanks the lines at the start that fit a pattern of the header, and those at the end that
    /// fit one of the trailer; returns them with their numbers. In a pattern `*` matches any
    /// characters; blank lines between them are allowed.
    pub(crate) fn take_out(&mut self, header: &[String], trailer: &[String]) -> Vec<(u32, String)> {
        if header.is_empty() && trailer.is_empty() {
            return Vec::new();
        }
        let lines: Vec<&str> = self.text.split('\n').collect();
        let around = |patterns: &[String], order: &mut dyn Iterator<Item = usize>| {
            let mut found = Vec::new();
            for at in order {
                let line = lines[at].trim();
                if line.is_empty() {
                    continue;
                }
                if !patterns.iter().any(|pattern| fits(pattern.trim(), line)) {
                    break;
                }
                found.push(at);
            }
            found
        };
        let mut out = around(header, &mut (0..lines.len()));
        // A text of nothing else is a header.
        let first_left = out.last().map_or(0, |at| at + 1);
        out.extend(around(trailer, &mut (first_left..lines.len()).rev()));
        out.sort_unstable();
        let taken: Vec<(u32, String)> = out.iter().map(|&at| (at as u32 + 1, lines[at].to_owned())).collect();
        if !out.is_empty() {
            let kept: Vec<&str> = lines
                .iter()
                .enumerate()
                .map(|(at, line)| if out.binary_search(&at).is_ok() { "" } else { line })
                .collect();
            self.text = kept.join("\n");
        }
        taken
    }

    /// Statements that the control writes in a language of its own become those of the reader; lines stay
    /// where they are.
    pub(crate) fn speak_as(&mut self, control: &crate::control::Control) {
        if control.depth_in_i {
            self.text = crate::dialect::fagor_text(&self.text);
        }
    }

    /// Text of a line, from 1.
    pub(crate) fn text_of(&self, line: u32) -> Option<&str> {
        self.text.split('\n').nth((line as usize).checked_sub(1)?)
    }

    /// Lines of the text; a last line without an end counts.
    pub(crate) fn lines(&self) -> usize {
        self.text.bytes().filter(|&b| b == b'\n').count()
            + usize::from(!self.text.is_empty() && !self.text.ends_with('\n'))
    }
}

/// The first line feed. Eight bytes at a time, as lines are short: a byte of `x` is zero where
/// there is one, and the lowest bit that is left marks the first of them (Mycroft 1987).
fn line_feed(text: &[u8]) -> Option<usize> {
    const ONES: u64 = u64::MAX / 255;
    let (blocks, rest) = text.as_chunks::<8>();
    for (at, block) in blocks.iter().enumerate() {
        let x = u64::from_le_bytes(*block) ^ (ONES * b'\n' as u64);
        let found = x.wrapping_sub(ONES) & !x & (ONES << 7);
        if found != 0 {
            return Some(at * 8 + found.trailing_zeros() as usize / 8);
        }
    }
    rest.iter().position(|&byte| byte == b'\n').map(|at| blocks.len() * 8 + at)
}

/// The line fits the pattern, in which `*` matches any characters; the case of letters does not
/// matter.
fn fits(pattern: &str, line: &str) -> bool {
    let (pattern, line) = (pattern.to_ascii_uppercase(), line.to_ascii_uppercase());
    let mut parts = pattern.split('*');
    let Some(mut rest) = line.strip_prefix(parts.next().unwrap_or_default()) else { return false };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else { return rest.is_empty() };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.len() >= last.len() && rest.ends_with(last)
}

/// How a program file is read, for what shows lines of it or counts them.
#[derive(Clone, Debug)]
pub struct ProgramText {
    source: Arc<Source>,
}

impl ProgramText {
    /// Reads a program file.
    ///
    /// # Errors
    /// The file cannot be read, or is no text.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Diagnostic> {
        Source::read(path.as_ref()).map(|source| Self { source: Arc::new(source) }).map_err(|diagnostic| *diagnostic)
    }

    /// Number of its lines.
    pub fn lines(&self) -> usize {
        self.source.lines()
    }

    /// All of them, in order.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        self.source.text.split('\n').take(self.lines())
    }

    /// A line, from 1; the search begins at the start of the text.
    pub fn line(&self, number: usize) -> Option<&str> {
        self.source.text_of(u32::try_from(number).ok()?)
    }
}

/// Bytes of a file as text, without what surrounds it on a tape or disk: byte order mark, NUL of a
/// leader, Ctrl-Z.
fn decoded(bytes: Vec<u8>) -> Result<String, &'static str> {
    let utf16 = |pair: fn([u8; 2]) -> u16, rest: &[u8]| {
        let units = rest.chunks_exact(2).map(|p| pair([p[0], p[1]]));
        let whole = rest.len().is_multiple_of(2);
        let text: Option<String> = char::decode_utf16(units).collect::<Result<_, _>>().ok();
        text.filter(|_| whole).ok_or("begins with a UTF-16 byte order mark but is not UTF-16")
    };
    let text = match bytes.as_slice() {
        [0xff, 0xfe, rest @ ..] => utf16(u16::from_le_bytes, rest)?,
        [0xfe, 0xff, rest @ ..] => utf16(u16::from_be_bytes, rest)?,
        _ => {
            let around = |b: &u8| *b == 0;
            let first = bytes.iter().position(|b| !around(b)).unwrap_or(bytes.len());
            let last = bytes.iter().rposition(|b| !around(b)).map_or(first, |at| at + 1);
            let nuls = bytes[first..last].iter().filter(|b| **b == 0).count();
            if nuls as f64 > NUL_SHARE * (last - first) as f64 {
                return Err("is not plain text: it looks like UTF-16 without a byte order mark, or like a binary file");
            }
            String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect())
        }
    };
    Ok(text)
}

/// NUL and DEL are blanks of a tape, DC1 to DC4 switch a reader or punch, Ctrl-Z ends a file of CP/M and DOS.
fn is_tape_blank(c: char) -> bool {
    matches!(c, '\0' | '\u{11}'..='\u{14}' | '\u{7f}')
}

/// The text has a tape blank. Each block of bytes is checked without a branch, so that the compiler
/// uses vector instructions.
fn has_tape_blank(text: &[u8]) -> bool {
    let blanks = |block: &[u8]| block.iter().fold(false, |found, &byte| found | is_tape_blank(char::from(byte)));
    text.chunks(256).any(blanks)
}

/// The text with LF as its only line end, blanks for what is blank on a tape, and without what
/// follows its end.
fn with_line_feeds(mut text: String) -> String {
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    // The leader of a tape precedes the first line.
    let leader = text.len() - text.trim_start_matches(is_tape_blank).len();
    text.drain(..leader);
    let behind = |c: char| is_tape_blank(c) || c == '\u{1a}';
    let kept = text.trim_end_matches(|c: char| behind(c) || matches!(c, ' ' | '\t' | '\r' | '\n')).len();
    if text[kept..].contains(behind) {
        // What follows the last line end in front of them is no line of its own.
        let end = text[kept..].find(behind).map_or(text.len(), |at| kept + at);
        text.truncate(end);
    }
    if has_tape_blank(text.as_bytes()) {
        text = text.chars().map(|c| if is_tape_blank(c) { ' ' } else { c }).collect();
    }
    if !text.contains('\r') {
        return text;
    }
    let mut out = String::with_capacity(text.len());
    let mut rest = text.as_str();
    while let Some(at) = rest.find(['\r', '\n']) {
        out.push_str(&rest[..at]);
        let run = rest[at..].len() - rest[at..].trim_start_matches(['\r', '\n']).len();
        let ends = &rest[at..at + run];
        let feeds = ends.bytes().filter(|&b| b == b'\n').count();
        let count = if feeds > 0 { feeds } else { run };
        out.extend(std::iter::repeat_n('\n', count));
        rest = &rest[at + run..];
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        let source = Source::new("t", text.to_owned());
        let (mut out, mut at) = (Vec::new(), Mark::START);
        while let Some((line, next)) = source.line(at) {
            assert_eq!(at.line as usize, out.len() + 1);
            out.push(line.to_owned());
            at = next;
        }
        assert_eq!(source.lines(), out.len());
        out
    }

    #[test]
    fn all_line_ends_give_the_same_lines() {
        for end in ["\n", "\r\n", "\r", "\r\r\n", "\n\r\r", "\n\r"] {
            assert_eq!(lines(&["G0 X1", "G1 X2", "M30", ""].join(end)), ["G0 X1", "G1 X2", "M30"], "{end:?}");
            assert_eq!(lines(&["G0 X1", "M30"].join(end)), ["G0 X1", "M30"], "{end:?}");
        }
        assert_eq!(lines("A\rB\nC\r\nD"), ["A", "B", "C", "D"], "mixed");
        // Empty lines keep their numbers.
        assert_eq!(lines("A\n\nB\n"), ["A", "", "B"]);
        assert_eq!(lines("A\r\n\r\nB\r\n"), ["A", "", "B"]);
        assert_eq!(lines("A\r\rB\r"), ["A", "", "B"]);
        assert!(lines("").is_empty());
        assert_eq!(lines("\r"), [""]);
    }

    #[test]
    fn what_stands_around_a_text_on_tape_and_disk_is_no_text() {
        for tail in ["\u{1a}", "\0\0\0", "\r\n\u{1a}\u{1a}\0", "\u{14}", " \u{1a}"] {
            let found = lines(&format!("%\nM30\n%{tail}"));
            assert_eq!(found.iter().map(|l| l.trim_end()).collect::<Vec<_>>(), ["%", "M30", "%"], "{tail:?}");
        }
        assert_eq!(lines("\u{12}\0\0%\nM30")[0], "%");
        assert_eq!(lines("G0\0X1")[0], "G0 X1");
        // A Ctrl-Z in the middle stays: what follows it would be lost.
        assert_eq!(lines("M0\n\u{1a}\nG0 X1\n").len(), 3);
    }

    #[test]
    fn the_first_line_feed_is_found_at_every_place() {
        for length in 0..40 {
            for other in [b'\n' - 1, b'\n' + 1, b'X', 0, 0x80, 0x8a, 0xff] {
                let mut text = vec![other; length];
                assert_eq!(line_feed(&text), None);
                for at in (0..length).rev() {
                    text[at] = b'\n';
                    assert_eq!(line_feed(&text), Some(at), "{other} {length}");
                }
            }
        }
    }

    #[test]
    fn lines_around_a_program_are_taken_out_by_pattern() {
        let text = "$PART.MIN%\n\nO100\n%KEPT\nG0 X1\nM2\n%\n\n";
        let mut source = Source::new("t", text.to_owned());
        let header = ["$*.MIN%".to_owned(), "o*".to_owned()];
        let taken = source.take_out(&header, &["%".to_owned()]);
        assert_eq!(taken, [(1, "$PART.MIN%".to_owned()), (3, "O100".to_owned()), (7, "%".to_owned())]);
        assert_eq!(source.text, "\n\n\n%KEPT\nG0 X1\nM2\n\n\n");
        for (pattern, line, want) in [
            ("*", "", true),
            ("A*C", "abbc", true),
            ("A*C", "ac", true),
            ("A*C", "a", false),
            ("A", "ab", false),
            ("*B*", "abc", true),
            ("AB*B", "ab", false),
        ] {
            assert_eq!(fits(pattern, line), want, "{pattern} {line}");
        }
    }

    #[test]
    fn utf_16_is_read_by_its_mark_and_refused_without_it() {
        let text = "G21\r\nG0 X1.\r\n";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        assert_eq!(decoded([&[0xff, 0xfe], little.as_slice()].concat()).as_deref(), Ok(text));
        assert_eq!(decoded([&[0xfe, 0xff], big.as_slice()].concat()).as_deref(), Ok(text));
        assert!(decoded([&[0xff, 0xfe], &little[..5]].concat()).is_err_and(|e| e.contains("UTF-16")));
        assert!(decoded(little).is_err_and(|e| e.contains("UTF-16")));
        assert!(decoded(big).is_err_and(|e| e.contains("UTF-16")));
        // A leader of NUL is a tape.
        assert_eq!(decoded([vec![0; 100], b"%\nM30\n".to_vec(), vec![0; 100]].concat()).map(|t| t.len()), Ok(206));
        assert_eq!(decoded(vec![0x47, 0xe4]).as_deref(), Ok("Gä"));
        assert_eq!(decoded(Vec::new()).as_deref(), Ok(""));
    }
}
