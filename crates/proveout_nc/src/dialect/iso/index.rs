//! Structure of a program file: its programs, and the partner lines of every opening or closing word.
//!
//! Made once when a file is loaded, so that a jump or a skipped branch costs one look-up and an unclosed loop is reported
//! before anything runs. Only lines that begin with a structuring word are parsed: plain blocks cost a few bytes.

use std::collections::BTreeMap;

use super::flavor::Flavor;
use super::parser::{self, Block};
use super::statement::{Label, OWord, Statement};
use crate::codes;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::scan::Scanner;
use crate::source::{Mark, Source};

/// Lines of one program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Section {
    pub(crate) start: Mark,
    /// Byte behind the last line.
    pub(crate) end: usize,
}

/// Lines that belong to a structuring line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Partner {
    /// IF, ELSEIF, ELSE: the next branch or the end. Opening word of a loop or subprogram: its end. End: its opening word.
    /// BREAK and CONTINUE: the opening word of the loop.
    pub(crate) next: Mark,
    /// The end of the whole structure.
    pub(crate) end: Mark,
}

#[derive(Debug, Default)]
pub(crate) struct Index {
    pub(crate) main: Option<Section>,
    /// Programs with a head, by its number or name.
    pub(crate) programs: BTreeMap<String, Section>,
    /// Subprograms of O words: the line with SUB and the program it stands in.
    pub(crate) subs: BTreeMap<String, (Mark, Section)>,
    pub(crate) partners: BTreeMap<usize, Partner>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Sub,
    If,
    While,
    Do,
    Repeat,
    /// WHILE DO of macro B.
    Macro,
}

impl Kind {
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
struct Open {
    kind: Kind,
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

impl Index {
    /// Reads the structure of a file; faults of structure are added to the list.
    pub(crate) fn new(source: &Source, flavor: Flavor, faults: &mut Vec<Diagnostic>) -> Self {
        let mut index = Self::default();
        let mut open: Vec<Open> = Vec::new();
        let mut block = Block::default();
        let mut pending_subs = Vec::new();
        let (mut at, mut start, mut name) = (Mark::START, Mark::START, None::<String>);
        let (mut seen_code, mut closed) = (false, false);
        while let Some((line, next)) = source.line(at) {
            let trimmed = line.trim_start();
            if trimmed.starts_with('%') {
                if seen_code && !closed {
                    index.close(source, start, at.offset, name.take(), &mut open, &mut pending_subs, faults);
                    closed = true;
                }
                if closed {
                    start = next;
                    seen_code = false;
                }
            } else if may_structure(line) && parser::parse_line(line, flavor, &mut block).is_ok() {
                match block.statement.take() {
                    Some(Statement::Header(header)) => {
                        if seen_code && !closed {
                            index.close(source, start, at.offset, name.take(), &mut open, &mut pending_subs, faults);
                        }
                        if seen_code || closed {
                            start = at;
                        }
                        closed = false;
                        name = Some(header);
                        seen_code = true;
                    }
                    Some(statement) => {
                        seen_code = true;
                        let span = block.span;
                        if let Err((message, help)) =
                            index.structure(at, span, &statement, &mut open, &mut pending_subs)
                        {
                            let fault = Fault::new(codes::STRUCTURE, span, message).help(help);
                            faults.push(fault.at(&source.name, at.line, line));
                        }
                    }
                    None => seen_code = true,
                }
            } else {
                seen_code = seen_code || !trimmed.is_empty() && !trimmed.starts_with(['(', ';']);
            }
            at = next;
        }
        if !closed || seen_code && name.is_some() {
            index.close(source, start, at.offset, name, &mut open, &mut pending_subs, faults);
        }
        index
    }

    #[expect(clippy::too_many_arguments, reason = "the state of one pass over the file")]
    fn close(
        &mut self,
        source: &Source,
        start: Mark,
        end: usize,
        name: Option<String>,
        open: &mut Vec<Open>,
        subs: &mut Vec<(String, Mark)>,
        faults: &mut Vec<Diagnostic>,
    ) {
        for open in open.drain(..) {
            let (word, end_word) = open.kind.words();
            let line = source.line(open.mark).map_or("", |(line, _)| line);
            let fault = Fault::new(codes::STRUCTURE, open.span, format!("`{word} {}` has no `{end_word}`", open.label))
                .help(format!("write {end_word} where it ends"));
            faults.push(fault.at(&source.name, open.mark.line, line));
        }
        let section = Section { start, end };
        self.main.get_or_insert(section);
        for (label, mark) in subs.drain(..) {
            self.subs.entry(label).or_insert((mark, section));
        }
        if let Some(name) = name {
            self.programs.entry(name).or_insert(section);
        }
    }

    fn structure(
        &mut self,
        at: Mark,
        span: Span,
        statement: &Statement,
        open: &mut Vec<Open>,
        subs: &mut Vec<(String, Mark)>,
    ) -> Result<(), Misfit> {
        let (label, word) = match statement {
            Statement::While(_, number) => {
                open.push(Open::new(Kind::Macro, number.to_string(), at, span));
                return Ok(());
            }
            Statement::End(number) => return self.end(Kind::Macro, &number.to_string(), at, open),
            Statement::OWord(Label::Fixed(label), word) => (label, word),
            Statement::OWord(Label::Computed(_), OWord::Call(_)) => return Ok(()),
            Statement::OWord(Label::Computed(_), _) => {
                return Err((
                    "only a call can compute its label".to_owned(),
                    "write the label as a number or name".to_owned(),
                ));
            }
            _ => return Ok(()),
        };
        let open_it = |kind: Kind| Open::new(kind, label.clone(), at, span);
        match word {
            OWord::Sub => {
                if open.iter().any(|o| o.kind == Kind::Sub) {
                    return Err((
                        "a subprogram begins inside of another one".to_owned(),
                        "close the first one with endsub".to_owned(),
                    ));
                }
                open.push(open_it(Kind::Sub));
                subs.push((label.clone(), at));
            }
            OWord::If(_) => open.push(open_it(Kind::If)),
            OWord::Do => open.push(open_it(Kind::Do)),
            OWord::Repeat(_) => open.push(open_it(Kind::Repeat)),
            OWord::While(_) => {
                if open.last().is_some_and(|o| o.kind == Kind::Do && o.label == *label) {
                    return self.end(Kind::Do, label, at, open);
                }
                open.push(open_it(Kind::While));
            }
            OWord::ElseIf(_) | OWord::Else => match open.last_mut() {
                Some(top) if top.kind == Kind::If && top.label == *label && !top.last => {
                    top.branches.push(at);
                    top.last = *word == OWord::Else;
                }
                other => return Err(misfit("else", label, other.as_deref())),
            },
            OWord::EndSub(_) => return self.end(Kind::Sub, label, at, open),
            OWord::EndIf => return self.end(Kind::If, label, at, open),
            OWord::EndWhile => return self.end(Kind::While, label, at, open),
            OWord::EndRepeat => return self.end(Kind::Repeat, label, at, open),
            OWord::Break | OWord::Continue => {
                let looping =
                    |o: &&mut Open| o.label == *label && matches!(o.kind, Kind::While | Kind::Do | Kind::Repeat);
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

    fn end(&mut self, kind: Kind, label: &str, at: Mark, open: &mut Vec<Open>) -> Result<(), Misfit> {
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

impl Open {
    fn new(kind: Kind, label: String, mark: Mark, span: Span) -> Self {
        Self { kind, label, mark, span, branches: vec![mark], last: false, exits: Vec::new() }
    }
}

fn misfit(word: &str, label: &str, top: Option<&Open>) -> Misfit {
    let help = top.map_or_else(
        || "take it out, or write the word that opens it".to_owned(),
        |top| format!("`{} {}` of line {} must be closed first", top.kind.words().0, top.label, top.mark.line),
    );
    (format!("`{word} {label}` has nothing to close here"), help)
}

/// The line with this block number: searched from a line to the end of the program, then from its start.
pub(crate) fn find_block_number(source: &Source, section: Section, number: u32, from: Mark) -> Option<Mark> {
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
                if s.integer() == Some(number) {
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
