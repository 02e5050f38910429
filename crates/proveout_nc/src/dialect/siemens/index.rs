//! Structure of a program file: sections, labels, and the partner line of every opening or closing word.
//!
//! Built once when a file is loaded, so that a jump or a skipped branch costs one look-up and an
//! unclosed loop is reported before anything runs. Only lines that begin with a word are examined:
//! plain motion blocks cost a few bytes.

use std::collections::BTreeMap;

use super::parser::{self, SiemensBlock, SiemensStatement};
use crate::channel::ProgramSection;
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::scan::Scanner;
use crate::source::{Mark, Source};

/// A stretch of the text: a program or subprogram.
#[derive(Clone, Debug)]
pub(crate) struct ProgramPart {
    /// First line, and the line after the last.
    pub(crate) lines: [u32; 2],
    pub(crate) name: Option<String>,
    /// It begins with PROC, or its header line ends with `_SPF`.
    pub(crate) subprogram: bool,
}

#[derive(Debug)]
pub(crate) struct Index {
    pub(crate) main: ProgramSection,
    /// All of the text, in order.
    pub(crate) parts: Vec<ProgramPart>,
    /// A PROC line cannot be read: a subprogram that seems to be missing may be this one.
    pub(crate) unreadable: bool,
    /// Further programs of the same file, by upper-case name.
    pub(crate) procs: BTreeMap<String, ProgramSection>,
    /// From the offset of a line to the line that belongs to it: IF to ELSE or ENDIF, ELSE to ENDIF, the
    /// opening word of a loop to its end and back.
    pub(crate) partners: BTreeMap<usize, Mark>,
    labels: BTreeMap<String, Vec<Mark>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OpenStructure {
    If,
    Else,
    For,
    While,
    Repeat,
    Loop,
}

impl OpenStructure {
    fn word(self) -> &'static str {
        match self {
            Self::If => "IF",
            Self::Else => "ELSE",
            Self::For => "FOR",
            Self::While => "WHILE",
            Self::Repeat => "REPEAT",
            Self::Loop => "LOOP",
        }
    }

    fn end_word(self) -> &'static str {
        match self {
            Self::If | Self::Else => "ENDIF",
            Self::For => "ENDFOR",
            Self::While => "ENDWHILE",
            Self::Repeat => "UNTIL",
            Self::Loop => "ENDLOOP",
        }
    }
}

/// What the head of a line says about structure.
struct LineHead<'a> {
    label: Option<&'a str>,
    /// First word when it is longer than an address letter; empty otherwise.
    word: &'a str,
    word_span: Span,
}

fn head(line: &str) -> Option<LineHead<'_>> {
    let mut s = Scanner::new(line);
    s.skip_blanks();
    if s.take(b'/') {
        s.integer();
        s.skip_blanks();
    }
    if matches!(s.peek(), b'N' | b'n') && matches!(s.peek_at(1), b'0'..=b'9' | b' ') {
        s.bump();
        s.skip_blanks();
        s.integer();
        s.skip_blanks();
    }
    let mut label = None;
    loop {
        // An address letter and its number: no structural word begins like this.
        let long = (s.peek().is_ascii_alphabetic() || s.peek() == b'_')
            && matches!(s.peek_at(1), b'A'..=b'Z' | b'a'..=b'z' | b'_' | b'0'..=b'9');
        if !long {
            return label.map(|label| LineHead { label: Some(label), word: "", word_span: Span::default() });
        }
        let start = s.pos();
        let word = s.identifier();
        if label.is_none() && s.peek() == b':' && s.peek_at(1) != b'=' {
            label = Some(word);
            s.bump();
            s.skip_blanks();
            continue;
        }
        return Some(LineHead { label, word, word_span: s.span_from(start) });
    }
}

/// Name in a header line `%_N_NAME_MPF` or `%_N_NAME_SPF`.
fn header_name(line: &str) -> Option<String> {
    let name = line.trim().strip_prefix('%')?.trim().to_ascii_uppercase();
    let name = name.strip_prefix("_N_")?;
    Some(name.strip_suffix("_MPF").or_else(|| name.strip_suffix("_SPF")).unwrap_or(name).to_owned())
}

impl Index {
    /// Reads the structure of a file; faults of structure are added to the list.
    pub(crate) fn new(source: &Source, faults: &mut Vec<Diagnostic>) -> Self {
        let mut index = Self {
            main: ProgramSection { start: Mark::START, end: source.text.len() },
            parts: Vec::new(),
            unreadable: false,
            procs: BTreeMap::new(),
            partners: BTreeMap::new(),
            labels: BTreeMap::new(),
        };
        let mut open: Vec<(OpenStructure, Mark, Span)> = Vec::new();
        let mut block = SiemensBlock::default();
        let (mut at, mut name, mut start) = (Mark::START, None::<String>, Mark::START);
        let (mut seen_code, mut subprogram) = (false, false);
        while let Some((line, next)) = source.line(at) {
            let trimmed = line.trim_start();
            let header = if trimmed.starts_with('%') { header_name(line) } else { None };
            let head = if header.is_none() { head(line) } else { None };
            let proc = head.as_ref().is_some_and(|h| h.word.eq_ignore_ascii_case("PROC"));
            if header.is_some() || proc {
                let new_name = header.or_else(|| match parser::parse_line(line, &mut block) {
                    Ok(()) => match &block.statement {
                        Some(SiemensStatement::Proc { name, .. }) => Some(name.clone()),
                        _ => None,
                    },
                    Err(_) => {
                        index.unreadable = true;
                        None
                    }
                });
                // A PROC line that follows a header line, or that is the first line with code, names the
                // section it is in.
                if seen_code {
                    index.close_section(source, name.take(), subprogram, start, at, &mut open, faults);
                    start = at;
                    subprogram = false;
                }
                subprogram |= proc || line.trim().to_ascii_uppercase().ends_with("_SPF");
                name = new_name.or(name);
                seen_code = proc;
                at = next;
                continue;
            }
            seen_code = seen_code || !trimmed.is_empty() && !trimmed.starts_with(';');
            if let Some(head) = head {
                if let Some(label) = head.label {
                    index.labels.entry(label.to_ascii_uppercase()).or_default().push(at);
                }
                if !head.word.is_empty() {
                    index.structure(source, line, at, &head, &mut open, &mut block, faults);
                }
            }
            at = next;
        }
        index.close_section(source, name, subprogram, start, at, &mut open, faults);
        index
    }

    #[expect(clippy::too_many_arguments, reason = "the state of one pass over the file")]
    fn close_section(
        &mut self,
        source: &Source,
        name: Option<String>,
        subprogram: bool,
        start: Mark,
        end: Mark,
        open: &mut Vec<(OpenStructure, Mark, Span)>,
        faults: &mut Vec<Diagnostic>,
    ) {
        for (kind, mark, span) in open.drain(..) {
            let line = source.line(mark).map_or("", |(line, _)| line);
            let fault = Fault::new(codes::STRUCTURE, span, format!("`{}` has no `{}`", kind.word(), kind.end_word()))
                .help(format!("write {} where it ends", kind.end_word()));
            faults.push(fault.at(&source.name, mark.line, line));
        }
        let section = ProgramSection { start, end: end.offset };
        if self.parts.is_empty() {
            self.main = section;
        }
        self.parts.push(ProgramPart { lines: [start.line, end.line], name: name.clone(), subprogram });
        if let Some(name) = name {
            self.procs.entry(name).or_insert(section);
        }
    }

    #[expect(clippy::too_many_arguments, reason = "the state of one pass over the file")]
    fn structure(
        &mut self,
        source: &Source,
        line: &str,
        at: Mark,
        head: &LineHead<'_>,
        open: &mut Vec<(OpenStructure, Mark, Span)>,
        block: &mut SiemensBlock,
        faults: &mut Vec<Diagnostic>,
    ) {
        // An address letter with its number has no structural meaning.
        if head.word.as_bytes().get(1).is_some_and(u8::is_ascii_digit) {
            return;
        }
        let word = head.word.to_ascii_uppercase();
        let kind = match word.as_str() {
            "IF" => OpenStructure::If,
            "FOR" => OpenStructure::For,
            "WHILE" => OpenStructure::While,
            "REPEAT" => OpenStructure::Repeat,
            "LOOP" => OpenStructure::Loop,
            "ELSE" | "ENDIF" | "ENDFOR" | "ENDWHILE" | "UNTIL" | "ENDLOOP" => {
                let matches = |open: OpenStructure| match word.as_str() {
                    "ELSE" => open == OpenStructure::If,
                    end => open.end_word() == end,
                };
                match open.last().copied() {
                    Some((kind, mark, _)) if matches(kind) => {
                        open.pop();
                        self.partners.insert(mark.offset, at);
                        if !matches!(kind, OpenStructure::If | OpenStructure::Else) {
                            self.partners.insert(at.offset, mark);
                        }
                        if word == "ELSE" {
                            open.push((OpenStructure::Else, at, head.word_span));
                        }
                    }
                    last => {
                        let help = last.map_or_else(
                            || "remove it, or write the word that opens it".to_owned(),
                            |(kind, mark, _)| format!("`{}` of line {} must be closed first", kind.word(), mark.line),
                        );
                        let message = format!("`{word}` has nothing to close here");
                        let fault = Fault::new(codes::STRUCTURE, head.word_span, message).help(help);
                        faults.push(fault.at(&source.name, at.line, line));
                    }
                }
                return;
            }
            _ => return,
        };
        // IF with a jump and REPEAT with a label are complete by themselves. A line with a fault of
        // its own is reported when it is read; its jump word shows whether it opens something.
        let complete = matches!(kind, OpenStructure::If | OpenStructure::Repeat)
            && match parser::parse_line(line, block) {
                Ok(()) => !matches!(block.statement, Some(SiemensStatement::If(_) | SiemensStatement::Repeat)),
                Err(_) if kind == OpenStructure::If => line.to_ascii_uppercase().contains("GOTO"),
                // A label after it.
                Err(_) => {
                    let rest = line.get(head.word_span.end as usize..).unwrap_or_default();
                    rest.trim_start().starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                }
            };
        if !complete {
            open.push((kind, at, head.word_span));
        }
    }

    /// The nearest line of the section with this label, after a line (`forward`) or before it.
    pub(crate) fn label(&self, name: &str, section: ProgramSection, from: usize, forward: bool) -> Option<Mark> {
        let marks = self.labels.get(name)?;
        let inside = |m: &&Mark| m.offset >= section.start.offset && m.offset < section.end;
        if forward {
            marks.iter().filter(inside).find(|m| m.offset > from).copied()
        } else {
            marks.iter().filter(inside).rev().find(|m| m.offset <= from).copied()
        }
    }
}

/// The line with this block number, searched from a line on in one direction.
pub(crate) fn find_block_number(
    source: &Source,
    section: ProgramSection,
    number: u32,
    from: Mark,
    forward: bool,
) -> Option<Mark> {
    let mut found = None;
    let mut at = if forward { from } else { section.start };
    while let Some((line, next)) = source.line(at) {
        if at.offset >= section.end || !forward && at.offset > from.offset {
            break;
        }
        let mut s = Scanner::new(line);
        s.skip_blanks();
        if s.take(b'/') {
            s.integer();
            s.skip_blanks();
        }
        let here = (s.take(b'N') || s.take(b'n')) && {
            s.skip_blanks();
            s.integer() == Some(number)
        };
        if here && !(forward && at.offset == from.offset) {
            found = Some(at);
            if forward {
                break;
            }
        }
        at = next;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(text: &str) -> (Index, Vec<Diagnostic>) {
        let mut faults = Vec::new();
        let index = Index::new(&Source::new("t", text.to_owned()), &mut faults);
        (index, faults)
    }

    #[test]
    fn partners_and_labels() {
        let (index, faults) =
            index("IF R1\nG1\nELSE\nX1\nENDIF\nN5 L1: LOOP\nENDLOOP\nIF R1 GOTOF L1\nREPEAT L1 P=2\n");
        assert!(faults.is_empty(), "{faults:?}");
        let lines: Vec<u32> = index.partners.values().map(|m| m.line).collect();
        assert_eq!(lines, [3, 5, 7, 6]);
        assert_eq!(index.label("L1", index.main, 0, true).map(|m| m.line), Some(6));
    }

    #[test]
    fn sections_of_an_archive_and_of_proc() {
        let (index, faults) =
            index("%_N_MAIN_MPF\n;$PATH=/_N_MPF_DIR\nG0 X1\nM30\n%_N_SUB_SPF\nPROC SUB(REAL A)\nRET\n");
        assert!(faults.is_empty());
        assert_eq!(index.main.start.line, 1);
        assert_eq!(index.procs["SUB"].start.line, 5);
        assert_eq!(index.procs["MAIN"], index.main);
    }

    #[test]
    fn every_unclosed_word_is_reported() {
        let (_, faults) = index("IF R1\nFOR I=1 TO 2\nENDIF\nENDWHILE\n");
        assert_eq!(faults.len(), 4, "{faults:?}");
        assert!(faults.iter().all(|f| f.code == codes::STRUCTURE));
    }
}
