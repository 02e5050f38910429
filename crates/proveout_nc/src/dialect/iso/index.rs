//! Structure of a program file: its programs, and the partner lines of every opening or closing word.
//!
//! Made once when a file is loaded, so that a jump or a skipped branch costs one look-up and an unclosed loop
//! is reported before anything runs. Only lines that begin with a structuring word are parsed: plain blocks
//! cost a few bytes.

use std::collections::BTreeMap;

use super::flavor::Flavor;
use super::osp;
use super::parser::{self, IsoBlock};
use super::statement::{IsoStatement, OLabel, OWord};
use crate::channel::ProgramSection;
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::scan::Scanner;
use crate::source::{Mark, Source};

/// A stretch of the text: a program, or what surrounds the tape.
#[derive(Clone, Debug)]
pub(crate) struct TapePart {
    /// First line, and the line after the last.
    pub(crate) lines: [u32; 2],
    /// Number or name of the program.
    pub(crate) name: Option<String>,
    /// No control reads it: before the first `%`, or after the last.
    pub(crate) outside: bool,
}

/// Lines that belong to a structuring line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Partner {
    /// IF, ELSEIF, ELSE: the next branch or the end. Opening word of a loop or subprogram: its end. End: its
    /// opening word. BREAK and CONTINUE: the opening word of the loop.
    pub(crate) next: Mark,
    /// The end of the whole structure.
    pub(crate) end: Mark,
}

#[derive(Debug, Default)]
pub(crate) struct Index {
    pub(crate) main: Option<ProgramSection>,
    /// Programs with a head, by its number or name.
    pub(crate) programs: BTreeMap<String, ProgramSection>,
    /// Subprograms of O words: the line with SUB and the program that contains it.
    pub(crate) subs: BTreeMap<String, (Mark, ProgramSection)>,
    pub(crate) partners: BTreeMap<usize, Partner>,
    /// All of the text that holds code, in order.
    pub(crate) parts: Vec<TapePart>,
    /// A line that may structure the program cannot be read: it may contain what seems to be
    /// missing.
    pub(crate) unreadable: bool,
}

/// One pass over a file.
struct IndexPass<'a> {
    source: &'a Source,
    faults: &'a mut Vec<Diagnostic>,
    open: Vec<OpenLoop>,
    subs: Vec<(String, Mark)>,
    /// Begin and name of the part that is read.
    start: Mark,
    name: Option<String>,
    /// Heads of programs in it, on a control that runs through them.
    heads: Vec<(String, Mark)>,
    seen_code: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LoopKind {
    Sub,
    If,
    While,
    Do,
    Repeat,
    /// WHILE DO of macro B.
    Macro,
}

impl LoopKind {
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Sub => ("sub", "endsub"),
            Self::If => ("if", "endif"),
            Self::While => ("while", "endwhile"),
            Self::Do => ("do", "while"),
            Self::Repeat => ("repeat", "endrepeat"),
            Self::Macro => ("DO", "END"),
        }
    }
}

#[derive(Debug)]
struct OpenLoop {
    kind: LoopKind,
    label: String,
    mark: Mark,
    span: Span,
    /// Opening line and further branches of an IF.
    branches: Vec<Mark>,
    /// An ELSE has been seen.
    last: bool,
    /// Lines with BREAK and CONTINUE.
    exits: Vec<Mark>,
}

/// Why a line does not fit, with its remedy.
type Misfit = (String, String);

/// True where a line may begin with a word that structures the program.
fn may_structure(line: &str) -> bool {
    let mut s = Scanner::new(line);
    s.skip_blanks();
    if s.take(b'/') {
        s.integer();
        s.skip_blanks();
    }
    if matches!(s.peek(), b'N' | b'n') {
        s.bump();
        s.skip_blanks();
        s.integer();
        s.skip_blanks();
    }
    match s.peek() {
        b'O' | b'o' | b':' | b'<' => true,
        b'W' | b'w' | b'D' | b'd' | b'E' | b'e' => s.peek_at(1).is_ascii_alphabetic(),
        _ => false,
    }
}

/// Where a line is on the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tape {
    /// No `%` yet.
    Before,
    Inside,
    /// After the `%` that closes it.
    Behind,
}

impl IndexPass<'_> {
    /// The text that the first `%` ends is no program: it has no head and no end, and a program follows.
    fn is_leader(&self, percent: Mark, behind: Mark) -> bool {
        if !self.seen_code || self.name.is_some() {
            return false;
        }
        let mut at = self.start;
        while let Some((line, next)) = self.source.line(at) {
            if at == percent {
                break;
            }
            if has_end(line) {
                return false;
            }
            at = next;
        }
        at = behind;
        while let Some((line, next)) = self.source.line(at) {
            if !line.trim().is_empty() && !line.trim_start().starts_with(['%', '(', ';']) {
                return true;
            }
            at = next;
        }
        false
    }
}

/// The number after each M of a line, outside of comments.
fn m_words(line: &str) -> impl Iterator<Item = u32> + '_ {
    let mut depth = 0;
    let bytes = line.as_bytes();
    (0..bytes.len()).filter_map(move |at| {
        match bytes[at] {
            b'(' => depth += 1,
            b')' => depth = 0,
            b'M' | b'm' if depth == 0 => {
                let mut s = Scanner::new(line);
                s.set_pos(at + 1);
                s.skip_blanks();
                return s.integer();
            }
            _ => {}
        }
        None
    })
}

/// The line contains M2, M30 or M99.
pub(crate) fn has_end(line: &str) -> bool {
    m_words(line).any(|m| matches!(m, 2 | 30 | 99))
}

/// The line contains M99.
pub(crate) fn has_return(line: &str) -> bool {
    m_words(line).any(|m| m == 99)
}

impl Index {
    /// Reads the structure of a file; faults of structure are added to the list.
    ///
    /// A Fanuc and a Haas keep each program by itself: its head ends the one before. A `LinuxCNC`
    /// runs through the heads of numbered programs, so that its text is one program from `%` to
    /// `%`. Text before the first `%` is the leader of a tape (which a `LinuxCNC` does not know).
    /// No control reads text after the closing `%` unless it has a head.
    pub(crate) fn new(source: &Source, flavor: Flavor, faults: &mut Vec<Diagnostic>) -> Self {
        let mut index = Self::default();
        let mut block = IsoBlock::default();
        let mut pass = IndexPass {
            source,
            faults,
            open: Vec::new(),
            subs: Vec::new(),
            start: Mark::START,
            name: None,
            heads: Vec::new(),
            seen_code: false,
        };
        let (mut at, mut tape) = (Mark::START, Tape::Before);
        while let Some((line, next)) = source.line(at) {
            let trimmed = line.trim_start();
            if trimmed.starts_with('%') {
                let leader = tape == Tape::Before && !flavor.is_linuxcnc() && pass.is_leader(at, next);
                let behind = tape == Tape::Behind && (pass.name.is_none() || flavor.is_linuxcnc());
                tape = match tape {
                    Tape::Before if leader || !pass.seen_code => Tape::Inside,
                    _ => Tape::Behind,
                };
                index.close(&mut pass, at, leader || behind);
                (pass.start, pass.name) = (next, None);
            } else if may_structure(line) {
                let readable = parser::parse_line(line, flavor, &mut block).is_ok();
                index.unreadable |= !readable;
                match block.statement.take().filter(|_| readable) {
                    Some(IsoStatement::Header(header)) if flavor.is_linuxcnc() => {
                        pass.heads.push((header, at));
                        pass.seen_code = true;
                    }
                    Some(IsoStatement::Header(header)) => {
                        if pass.seen_code {
                            let outside = tape == Tape::Behind && pass.name.is_none();
                            index.close(&mut pass, at, outside);
                        }
                        (pass.start, pass.name) = (if index.parts.is_empty() { pass.start } else { at }, Some(header));
                        pass.seen_code = true;
                    }
                    Some(statement) => {
                        pass.seen_code = true;
                        let span = block.span;
                        if let Err((message, help)) =
                            index.structure(at, span, &statement, &mut pass.open, &mut pass.subs)
                        {
                            let fault = Fault::new(codes::STRUCTURE, span, message).help(help);
                            pass.faults.push(fault.at(&source.name, at.line, line));
                        }
                    }
                    None => pass.seen_code = true,
                }
            } else {
                pass.seen_code = pass.seen_code || !trimmed.is_empty() && !trimmed.starts_with(['(', ';']);
            }
            at = next;
        }
        let behind = tape == Tape::Behind && (pass.name.is_none() || flavor.is_linuxcnc());
        let start = pass.start;
        index.close(&mut pass, at, behind);
        if index.unreadable {
            pass.faults.clear();
        }
        if index.parts.is_empty() {
            // Comments can speak to the control.
            index.main = Some(ProgramSection { start, end: at.offset });
        }
        index
    }

    /// Ends the part that is read in front of a line.
    fn close(&mut self, pass: &mut IndexPass<'_>, end: Mark, outside: bool) {
        for open in pass.open.drain(..) {
            let (word, end_word) = open.kind.words();
            let line = pass.source.line(open.mark).map_or("", |(line, _)| line);
            let fault = Fault::new(codes::STRUCTURE, open.span, format!("`{word} {}` has no `{end_word}`", open.label))
                .help(format!("write {end_word} where it ends"));
            pass.faults.push(fault.at(&pass.source.name, open.mark.line, line));
        }
        if !std::mem::take(&mut pass.seen_code) {
            return;
        }
        let section = ProgramSection { start: pass.start, end: end.offset };
        for (label, mark) in pass.subs.drain(..).filter(|_| !outside) {
            self.subs.entry(label).or_insert((mark, section));
        }
        let name = pass.name.take();
        // Numbered programs of a LinuxCNC: each a part of its own, and every one runs on to the end of the
        // text.
        let mut first = pass.start.line;
        let mut part_name = name.clone();
        for (head, mark) in pass.heads.drain(..) {
            if mark.line > first {
                self.parts.push(TapePart { lines: [first, mark.line], name: part_name.take(), outside });
            }
            (first, part_name) = (mark.line, Some(head.clone()));
            if !outside {
                self.programs.entry(head).or_insert(ProgramSection { start: mark, end: end.offset });
            }
        }
        self.parts.push(TapePart { lines: [first, end.line], name: part_name, outside });
        if outside {
            return;
        }
        self.main.get_or_insert(section);
        if let Some(name) = name {
            self.programs.entry(name).or_insert(section);
        }
    }

    fn structure(
        &mut self,
        at: Mark,
        span: Span,
        statement: &IsoStatement,
        open: &mut Vec<OpenLoop>,
        subs: &mut Vec<(String, Mark)>,
    ) -> Result<(), Misfit> {
        let (label, word) = match statement {
            IsoStatement::While(_, number) => {
                open.push(OpenLoop::new(LoopKind::Macro, number.to_string(), at, span));
                return Ok(());
            }
            IsoStatement::End(number) => return self.end(LoopKind::Macro, &number.to_string(), at, open),
            IsoStatement::OWord(OLabel::Fixed(label), word) => (label, word),
            IsoStatement::OWord(OLabel::Computed(_), OWord::Call(_)) => return Ok(()),
            IsoStatement::OWord(OLabel::Computed(_), _) => {
                return Err((
                    "only a call can compute its label".to_owned(),
                    "write the label as a number or name".to_owned(),
                ));
            }
            _ => return Ok(()),
        };
        let open_it = |kind: LoopKind| OpenLoop::new(kind, label.clone(), at, span);
        match word {
            OWord::Sub => {
                if open.iter().any(|o| o.kind == LoopKind::Sub) {
                    return Err((
                        "a subprogram begins inside of another one".to_owned(),
                        "close the first one with endsub".to_owned(),
                    ));
                }
                open.push(open_it(LoopKind::Sub));
                subs.push((label.clone(), at));
            }
            OWord::If(_) => open.push(open_it(LoopKind::If)),
            OWord::Do => open.push(open_it(LoopKind::Do)),
            OWord::Repeat(_) => open.push(open_it(LoopKind::Repeat)),
            OWord::While(_) => {
                if open.last().is_some_and(|o| o.kind == LoopKind::Do && o.label == *label) {
                    return self.end(LoopKind::Do, label, at, open);
                }
                open.push(open_it(LoopKind::While));
            }
            OWord::ElseIf(_) | OWord::Else => match open.last_mut() {
                Some(top) if top.kind == LoopKind::If && top.label == *label && !top.last => {
                    top.branches.push(at);
                    top.last = *word == OWord::Else;
                }
                other => return Err(misfit("else", label, other.as_deref())),
            },
            OWord::EndSub(_) => return self.end(LoopKind::Sub, label, at, open),
            OWord::EndIf => return self.end(LoopKind::If, label, at, open),
            OWord::EndWhile => return self.end(LoopKind::While, label, at, open),
            OWord::EndRepeat => return self.end(LoopKind::Repeat, label, at, open),
            OWord::Break | OWord::Continue => {
                let looping = |o: &&mut OpenLoop| {
                    o.label == *label && matches!(o.kind, LoopKind::While | LoopKind::Do | LoopKind::Repeat)
                };
                match open.iter_mut().rev().find(looping) {
                    Some(open) => open.exits.push(at),
                    None => {
                        return Err((
                            format!("no loop with the label {label} is open here"),
                            "write the label of the loop around it".to_owned(),
                        ));
                    }
                }
            }
            OWord::Call(_) | OWord::Return(_) => {}
        }
        Ok(())
    }

    fn end(&mut self, kind: LoopKind, label: &str, at: Mark, open: &mut Vec<OpenLoop>) -> Result<(), Misfit> {
        let Some(top) = open.pop_if(|top| top.kind == kind && top.label == label) else {
            return Err(misfit(kind.words().1, label, open.last()));
        };
        for (i, &branch) in top.branches.iter().enumerate() {
            let next = top.branches.get(i + 1).copied().unwrap_or(at);
            self.partners.insert(branch.offset, Partner { next, end: at });
        }
        for exit in top.exits {
            self.partners.insert(exit.offset, Partner { next: top.mark, end: at });
        }
        self.partners.insert(at.offset, Partner { next: top.mark, end: at });
        Ok(())
    }
}

impl OpenLoop {
    fn new(kind: LoopKind, label: String, mark: Mark, span: Span) -> Self {
        Self { kind, label, mark, span, branches: vec![mark], last: false, exits: Vec::new() }
    }
}

fn misfit(word: &str, label: &str, top: Option<&OpenLoop>) -> Misfit {
    let help = top.map_or_else(
        || "remove it, or write the word that opens it".to_owned(),
        |top| format!("`{} {}` of line {} must be closed first", top.kind.words().0, top.label, top.mark.line),
    );
    (format!("`{word} {label}` has nothing to close here"), help)
}

/// The line with this block number: searched from a line to the end of the program, then from its start.
pub(crate) fn find_block_number(source: &Source, section: ProgramSection, number: u32, from: Mark) -> Option<Mark> {
    let search = |mut at: Mark, end: usize| {
        while let Some((line, next)) = source.line(at) {
            if at.offset >= end {
                return None;
            }
            let mut s = Scanner::new(line);
            s.skip_blanks();
            if s.take(b'/') {
                s.integer();
                s.skip_blanks();
            }
            if s.take(b'N') || s.take(b'n') {
                s.skip_blanks();
                if s.integer().or_else(|| osp::sequence(&mut s, Flavor::Fanuc)) == Some(number) {
                    return Some(at);
                }
            }
            at = next;
        }
        None
    };
    search(from, section.end).or_else(|| search(section.start, from.offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(text: &str, flavor: Flavor) -> (Index, Vec<Diagnostic>) {
        let mut faults = Vec::new();
        let index = Index::new(&Source::new("t", text.to_owned()), flavor, &mut faults);
        (index, faults)
    }

    #[test]
    fn programs_of_a_tape() {
        let text = "%\n(head)\nO1000\nG0 X0\nM30\nO2000 (side)\nM99\n%\nG0 X5\nO3000\nM99\n%\n";
        let (index, faults) = index(text, Flavor::Fanuc);
        assert!(faults.is_empty());
        let names: Vec<_> = index.programs.keys().cloned().collect();
        assert_eq!(names, ["1000", "2000", "3000"]);
        assert_eq!(index.main.unwrap(), index.programs["1000"]);
        assert_eq!(index.programs["2000"].start.line, 6);
        assert_eq!(&text[index.programs["1000"].end..][..5], "O2000");
    }

    #[test]
    fn partners_of_o_words() {
        let text =
            "o1 if [1]\no1 elseif [2]\no1 else\no1 endif\no2 do\no2 break\no2 while [0]\no<a> sub\no<a> endsub\n";
        let (index, faults) = index(text, Flavor::LinuxCnc);
        assert!(faults.is_empty(), "{faults:?}");
        let lines: Vec<(u32, u32)> = index.partners.values().map(|p| (p.next.line, p.end.line)).collect();
        assert_eq!(lines, [(2, 4), (3, 4), (4, 4), (1, 4), (7, 7), (5, 7), (5, 7), (9, 9), (8, 9)]);
        assert_eq!(index.subs["<a>"].0.line, 8);
    }

    #[test]
    fn every_unclosed_word_is_reported() {
        let (_, faults) = index("o1 if [1]\no2 repeat [2]\no1 endif\no3 break\n", Flavor::LinuxCnc);
        assert_eq!(faults.len(), 4, "{faults:?}");
        let (_, faults) = index("WHILE [#1 LT 3] DO1\nEND2\n", Flavor::Fanuc);
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults.iter().all(|f| f.code == codes::STRUCTURE));
    }
}
