//! One line of text to one block.

use super::expr::{self, Expr};
use super::flavor::Flavor;
use super::osp;
use super::statement::{self, IsoStatement};
use crate::codes;
use crate::diagnostic::{Fault, Span, refused};
use crate::scan::Scanner;

/// A block as written. Reused from line to line, so that plain blocks allocate nothing.
#[derive(Debug, Default)]
pub(crate) struct IsoBlock {
    /// Level of `/`, if the block can be skipped.
    pub(crate) skip: Option<u8>,
    pub(crate) number: Option<u32>,
    pub(crate) words: Vec<IsoWord>,
    /// `#1 = 5`, in the order of the text.
    pub(crate) assignments: Vec<Assignment>,
    pub(crate) statement: Option<IsoStatement>,
    /// The line begins with `$`, as those of a grbl do.
    pub(crate) dollar: Option<Span>,
    /// IF after `WHILE [..] DO 1` or `DO 1`.
    pub(crate) behind: Option<IsoStatement>,
    /// Comments that say something to the operator or the control.
    pub(crate) remarks: Vec<Remark>,
    /// Text of the last comment.
    pub(crate) comment: Span,
    /// A word of Okuma OSP in the block.
    pub(crate) osp: Option<(&'static str, Span)>,
    /// `NCYL`: the cycle positions and does not machine.
    pub(crate) no_cycle: bool,
    /// `%`
    pub(crate) tape: bool,
    /// From the first word to the end of the last.
    pub(crate) span: Span,
}

/// `,C`, which no other word can be: their letters are upper case.
pub(crate) const CHAMFER: u8 = b'c';
/// `,R`
pub(crate) const ROUNDING: u8 = b'r';

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct IsoWord {
    /// Upper case; [`CHAMFER`] and [`ROUNDING`] for `,C` and `,R`.
    pub(crate) letter: u8,
    pub(crate) value: WordValue,
    pub(crate) span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum WordValue {
    Number {
        value: f64,
        /// Written with a decimal point.
        point: bool,
    },
    Expr(Box<Expr>),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Assignment {
    /// Parameter or named parameter.
    pub(crate) target: Expr,
    pub(crate) value: Expr,
    pub(crate) span: Span,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Remark {
    /// `(MSG, text)`
    Message(String),
    /// `(DEBUG, text)`, `(PRINT, text)`, `(LOG, text)` and the like, as written.
    Note(String),
    /// `(ABORT, text)`
    Abort(String),
    /// A word that changes nothing of what the twin does, and why.
    Idle(&'static str),
    /// How the text of the line is taken, where the control may take it in another way.
    Assumed(&'static str),
}

impl IsoBlock {
    fn clear(&mut self) {
        self.skip = None;
        self.number = None;
        self.words.clear();
        self.assignments.clear();
        self.statement = None;
        self.behind = None;
        self.dollar = None;
        self.remarks.clear();
        self.comment = Span::default();
        self.osp = None;
        self.no_cycle = false;
        self.tape = false;
        self.span = Span::default();
    }

    /// Nothing to execute.
    pub(crate) fn is_empty(&self) -> bool {
        self.words.is_empty()
            && self.assignments.is_empty()
            && self.statement.is_none()
            && self.remarks.is_empty()
            && !self.no_cycle
    }
}

/// Reads a line into the block.
pub(crate) fn parse_line(line: &str, flavor: Flavor, block: &mut IsoBlock) -> Result<(), Fault> {
    read_line(line, flavor, block).map_err(|fault| match crate::dialect::foreign::looks_like(line) {
        Some(control) => fault.help(crate::dialect::foreign::named(control)),
        None => fault,
    })
}

fn read_line(line: &str, flavor: Flavor, block: &mut IsoBlock) -> Result<(), Fault> {
    block.clear();
    let mut s = Scanner::new(line);
    s.skip_blanks();
    if s.peek() == b'%' {
        block.tape = true;
        return Ok(());
    }
    if s.peek() == b'$' && flavor.is_linuxcnc() {
        let at = s.pos();
        block.span = Span::new(at, line.trim_end().len());
        block.dollar = Some(block.span);
        block.statement = Some(IsoStatement::Dollar(line[at..].trim().to_ascii_uppercase()));
        return Ok(());
    }
    if !flavor.is_linuxcnc()
        && let Some(word) = osp::animation(line)
    {
        let at = s.pos();
        block.span = Span::new(at, line.trim_end().len());
        block.osp = Some((word, block.span));
        block.remarks.push(Remark::Note(line.trim().to_owned()));
        return Ok(());
    }
    let mut first = true;
    let mut start = None;
    let mut end = s.pos();
    loop {
        s.skip_blanks();
        let at = s.pos();
        let byte = s.peek();
        let held = (block.words.len(), block.assignments.len());
        match byte {
            b'(' => comment(&mut s, flavor, block)?,
            b';' => {
                after_semicolon(&mut s, flavor, block)?;
                break;
            }
            b'/' if first && block.skip.is_none() && block.number.is_none() => {
                s.bump();
                block.skip = Some(if s.peek().is_ascii_digit() {
                    let level = s.peek() - b'0';
                    s.bump();
                    level
                } else {
                    0
                });
            }
            b'N' | b'n' if !flavor.is_linuxcnc() && expr::next_is(&s, "NCYL") => {
                s.set_pos(at + 4);
                block.no_cycle = true;
                block.osp = Some(("`NCYL`", s.span_from(at)));
                start = start.or(Some(at));
                first = false;
                end = s.pos();
            }
            b'N' | b'n' if !flavor.is_linuxcnc() && expr::next_is(&s, "NOEX") => {
                s.set_pos(at + 4);
                block.osp = Some(("`NOEX`", s.span_from(at)));
                start = start.or(Some(at));
                first = false;
                end = s.pos();
            }
            b'A'..=b'Z' | b'a'..=b'z' if osp::local_is_next(&s, flavor) => {
                first = false;
                start = start.or(Some(at));
                let assignment = assignment(&mut s, flavor)?;
                block.osp = Some(("a variable by name", assignment.span));
                block.assignments.push(assignment);
                end = s.pos();
            }
            b'N' | b'n' if first && block.number.is_none() && statement::keyword(&s).is_none() => {
                s.bump();
                s.skip_blanks();
                let mut number = s.integer();
                if number.is_none()
                    && let Some(name) = osp::sequence(&mut s, flavor)
                {
                    number = Some(name);
                    block.osp = Some(("a sequence name of letters", s.span_from(at)));
                }
                if number.is_none() {
                    return Err(Fault::new(
                        codes::SYNTAX,
                        s.span_from(at),
                        "the block number has no digits, or too many",
                    )
                    .help("write N10"));
                }
                if s.peek() == b'.' {
                    // LinuxCNC allows N10.5: a place, never a value.
                    s.bump();
                    s.integer();
                }
                block.number = number;
                start = start.or(Some(at));
                end = s.pos();
            }
            b'#' => {
                first = false;
                start = start.or(Some(at));
                let assignment = assignment(&mut s, flavor)?;
                block.assignments.push(assignment);
                end = s.pos();
            }
            b'<' if first && flavor == Flavor::Fanuc => {
                // A Series 30i names programs: `<NAME>`.
                start = start.or(Some(at));
                block.statement = Some(statement::named_header(&mut s)?);
                first = false;
                end = s.pos();
            }
            b'@' | b'^' if flavor.is_linuxcnc() => {
                start = start.or(Some(at));
                let word = word(&mut s, flavor)?;
                block.words.push(word);
                first = false;
                end = s.pos();
            }
            b',' if !flavor.is_linuxcnc() && taps(&s, line) => {
                start = start.or(Some(at));
                s.set_pos(at + 3);
                // The path is the same with both, so that nothing is taken for granted.
                block.remarks.push(Remark::Idle(
                    "`,R` of a tapping cycle chooses between a rigid tap and a compensating chuck: the path follows the spindle with both",
                ));
                first = false;
                end = s.pos();
            }
            b',' if !flavor.is_linuxcnc() && matches!(s.peek_at(1).to_ascii_uppercase(), b'C' | b'R') => {
                start = start.or(Some(at));
                s.bump();
                let mut found = word(&mut s, flavor)?;
                found.letter = if found.letter == b'C' { CHAMFER } else { ROUNDING };
                found.span = s.span_from(at);
                block.words.push(found);
                first = false;
                end = s.pos();
            }
            b',' if !flavor.is_linuxcnc()
                && matches!(s.peek_at(1), b'K' | b'k')
                && line.to_ascii_uppercase().contains("G61.1") =>
            {
                s.bump();
                word(&mut s, flavor)?;
                block.remarks.push(Remark::Assumed(
                    "`,K` of G61.1 weighs accuracy against speed, which the controller of the twin does with its own tolerance",
                ));
                first = false;
                end = s.pos();
            }
            b'V' | b'v' if osp::variable_is_next(&s, flavor) => {
                first = false;
                start = start.or(Some(at));
                let assignment = assignment(&mut s, flavor)?;
                block.osp = Some(("`VC`", assignment.span));
                block.assignments.push(assignment);
                end = s.pos();
            }
            b'A'..=b'Z' | b'a'..=b'z' | b':' => {
                start = start.or(Some(at));
                if let Some(found) = statement::statement(&mut s, flavor, first)? {
                    block.osp = match found {
                        IsoStatement::Call(..) => Some(("`CALL`", s.span_from(at))),
                        IsoStatement::ModalCall(..) | IsoStatement::EndModal => Some(("`MODIN`", s.span_from(at))),
                        IsoStatement::Header(ref name) if name.starts_with('<') && flavor == Flavor::Fanuc => {
                            Some(("a program name of letters after O", s.span_from(at)))
                        }
                        IsoStatement::EndCall => Some(("`RTS`", s.span_from(at))),
                        IsoStatement::IfSequence(..) => Some(("`IF [..] N`", s.span_from(at))),
                        _ => block.osp,
                    };
                    let opens = matches!(block.statement, Some(IsoStatement::While(..))) && block.behind.is_none();
                    if opens && matches!(found, IsoStatement::IfGoto(..) | IsoStatement::IfThen(..)) {
                        block.behind = Some(found);
                    } else if block.statement.replace(found).is_some() {
                        let message = "a second statement in one block: the manual does not say how the control runs \
                                       both";
                        return Err(Fault::new(codes::CONFLICT, s.span_from(at), message)
                            .help("write it in a block of its own"));
                    }
                } else {
                    let word = word(&mut s, flavor)?;
                    if matches!(word.value, WordValue::Expr(_)) && s.slice(at).contains('=') {
                        block.osp = Some(("`=` after a letter", word.span));
                    }
                    if matches!(&word.value, WordValue::Expr(e) if osp::is_set_of_offsets(e)) {
                        block.osp = Some(("a letter after `H` or `D`", word.span));
                    }
                    block.words.push(word);
                }
                first = false;
                end = s.pos();
            }
            _ if s.at_end() => break,
            _ => return Err(unexpected(&s, flavor)),
        }
        if block.behind.is_some() && held != (block.words.len(), block.assignments.len()) {
            let message = "words after an IF that follows WHILE .. DO: the manual does not say how the control runs \
                           them";
            return Err(
                Fault::new(codes::CONFLICT, s.span_from(at), message).help("write them in a block of their own")
            );
        }
    }
    block.span = Span::new(start.unwrap_or(0), end);
    Ok(())
}

/// `,R0` or `,R1` in the block of a tapping cycle, as a Mitsubishi has it; the scanner is at the
/// comma.
fn taps(s: &Scanner<'_>, line: &str) -> bool {
    let digit = matches!(s.peek_at(1), b'R' | b'r') && matches!(s.peek_at(2), b'0' | b'1');
    let ends = !matches!(s.peek_at(3), b'0'..=b'9' | b'.' | b'[' | b'#');
    let upper = || line.split(['(', ';']).next().unwrap_or_default().to_ascii_uppercase();
    digit && ends && {
        let code = upper();
        ["G84", "G74"].iter().any(|word| {
            code.match_indices(word).any(|(at, _)| !code[at + word.len()..].starts_with(|c: char| c.is_ascii_digit()))
        })
    }
}

fn unexpected(s: &Scanner<'_>, flavor: Flavor) -> Fault {
    let shown = s.peek_char().unwrap_or(' ');
    let (code, help) = match shown {
        c if c.is_control() => (codes::SYNTAX, "remove the control character"),
        ',' if s.peek_at(1).is_ascii_digit() => (codes::SYNTAX, "decimal comma? write a decimal point"),
        ',' if flavor.is_linuxcnc() => {
            (codes::UNSUPPORTED_WORD, "program the chamfer or the rounding (,C ,R) with G1, G2, G3")
        }
        ',' => (codes::UNSUPPORTED_WORD, "`,C` and `,R` are read; write other points with their coordinates"),
        '@' | '^' => (codes::UNSUPPORTED_WORD, "program the point with X and Y"),
        '/' => (codes::UNSUPPORTED_WORD, "write `/` at the start of a block, and what it skips in a block of its own"),
        _ => (codes::SYNTAX, "remove it"),
    };
    let shown = if shown.is_control() { shown.escape_default().to_string() } else { shown.to_string() };
    Fault::new(code, s.here(), format!("`{shown}` has no meaning here for the {} reader", flavor.name())).help(help)
}

/// `X10`, `X-#1`, `X[#1+2]`; the scanner is at the letter.
fn word(s: &mut Scanner<'_>, flavor: Flavor) -> Result<IsoWord, Fault> {
    let start = s.pos();
    let letter = s.peek().to_ascii_uppercase();
    s.bump();
    s.skip_blanks();
    let from = s.pos();
    if let Some(value) = s.decimal() {
        let point = s.slice(from).as_bytes().contains(&b'.');
        let next = s.peek();
        if !(matches!(next, b' ' | b'\t' | b'.') || next.is_ascii_digit()) {
            return finite(letter, value, point, s.span_from(start));
        }
        // Blanks inside of a number belong to LinuxCNC alone.
        let after_number = s.pos();
        s.skip_blanks();
        if matches!(s.peek(), b'0'..=b'9' | b'.') {
            return spaced_number(s, flavor, letter, start, from);
        }
        s.set_pos(after_number);
        return finite(letter, value, point, s.span_from(start));
    }
    match s.peek() {
        // Okuma: `X=VC1+5`.
        b'=' if !flavor.is_linuxcnc() => {
            s.bump();
            let value = WordValue::Expr(Box::new(expr::expression(s, flavor)?));
            return Ok(IsoWord { letter, value, span: s.span_from(start) });
        }
        b'#' | b'[' | b'-' | b'+' => {}
        // Okuma: `G56 HA`.
        set @ (b'A'..=b'C' | b'a'..=b'c')
            if matches!(letter, b'H' | b'D') && !flavor.is_linuxcnc() && !s.peek_at(1).is_ascii_alphanumeric() =>
        {
            s.bump();
            let value = WordValue::Expr(Box::new(osp::set_of_offsets(letter, set)));
            return Ok(IsoWord { letter, value, span: s.span_from(start) });
        }
        byte if byte.is_ascii_alphabetic() && flavor.is_linuxcnc() && s.peek_at(1).is_ascii_alphabetic() => {}
        // Okuma: `VTOFH[1]=100`.
        byte if letter == b'V' && byte.is_ascii_alphabetic() && !flavor.is_linuxcnc() => {
            while s.peek().is_ascii_alphanumeric() {
                s.bump();
            }
            let name = s.slice(start).to_ascii_uppercase();
            return Err(refused(
                &name,
                s.span_from(start),
                "it is a system variable of an Okuma, which the twin does not have: write the value itself, or its offset in the scene",
            ));
        }
        _ => {
            let message = format!("`{}` has no value", char::from(letter));
            return Err(
                Fault::new(codes::MISSING_VALUE, Span::new(start, from), message).help("write the value after it")
            );
        }
    }
    let value = WordValue::Expr(Box::new(expr::operand(s, flavor)?));
    Ok(IsoWord { letter, value, span: s.span_from(start) })
}

fn finite(letter: u8, value: f64, point: bool, span: Span) -> Result<IsoWord, Fault> {
    if value.is_finite() {
        return Ok(IsoWord { letter, value: WordValue::Number { value, point }, span });
    }
    Err(Fault::new(codes::BAD_VALUE, span, "the number is too large").help("use fewer digits"))
}

fn spaced_number(s: &mut Scanner<'_>, flavor: Flavor, letter: u8, start: usize, from: usize) -> Result<IsoWord, Fault> {
    while matches!(s.peek(), b'0'..=b'9' | b'.' | b' ' | b'\t') {
        s.bump();
    }
    let text: String = s.slice(from).chars().filter(|c| !c.is_whitespace()).collect();
    let span = s.span_from(start);
    let wrong = |message: &str, help: &str| Err(Fault::new(codes::SYNTAX, span, message).help(help));
    if !flavor.is_linuxcnc() {
        return wrong("a number without a letter", "write a letter before it, or remove the blank");
    }
    match Scanner::new(&text).decimal() {
        Some(value) if text.matches('.').count() <= 1 => finite(letter, value, text.contains('.'), span),
        _ => wrong("not a number", "write one decimal point"),
    }
}

/// `#1 = value`, `VC1 = value`; the scanner is at the parameter.
pub(crate) fn assignment(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Assignment, Fault> {
    let start = s.pos();
    let target = match s.peek() {
        b'#' => expr::parameter(s, flavor)?,
        _ if osp::local_is_next(s, flavor) => Expr::Name(osp::local(s)),
        _ => osp::variable(s)?,
    };
    s.skip_blanks();
    if !s.take(b'=') {
        return Err(
            Fault::new(codes::SYNTAX, s.span_from(start), "`=` is missing after the parameter").help("write #1=5")
        );
    }
    let value = expr::expression(s, flavor)?;
    Ok(Assignment { target, value, span: s.span_from(start) })
}

/// Steps over `( ... )` and keeps what speaks to the operator.
fn comment(s: &mut Scanner<'_>, flavor: Flavor, block: &mut IsoBlock) -> Result<(), Fault> {
    let start = s.pos();
    s.bump();
    let from = s.pos();
    while !s.at_end() && s.peek() != b')' {
        s.bump();
    }
    let text = s.slice(from);
    block.comment = Span::new(from, s.pos());
    if let Some(at) = text.find('(').filter(|_| flavor.is_linuxcnc()) {
        let message = format!("a comment begins inside the comment `({text})`, which ends at the first `)`");
        return Err(Fault::new(codes::SYNTAX, Span::new(from + at, from + at + 1), message)
            .help("comments do not nest: write the inner brackets as [ ], or leave them out"));
    }
    if !s.take(b')') {
        return Err(
            Fault::new(codes::SYNTAX, s.span_from(start), "the comment has no end").help("write `)` at its end")
        );
    }
    if let Some(word) = text.strip_prefix(super::fagor_text::UNREAD) {
        let message = format!("`({word})` is not supported");
        return Err(Fault::new(codes::UNSUPPORTED_WORD, s.span_from(start), message)
            .help("of the statements in brackets assignments, IF GOTO, GOTO, SUB, RET, CALL, PCALL and RPT are read"));
    }
    if flavor.is_linuxcnc()
        && let Some((head, tail)) = text.split_once(',')
    {
        let remark = match head.trim().to_ascii_uppercase().as_str() {
            "MSG" => Remark::Message(tail.trim().to_owned()),
            "ABORT" => Remark::Abort(tail.trim().to_owned()),
            "DEBUG" | "PRINT" | "LOG" | "LOGOPEN" | "LOGAPPEND" | "PY" => Remark::Note(text.trim().to_owned()),
            _ => return Ok(()),
        };
        block.remarks.push(remark);
    } else if flavor.is_linuxcnc() && text.trim().to_ascii_uppercase().starts_with("PROBEOPEN") {
        block.remarks.push(Remark::Note(text.trim().to_owned()));
    }
    Ok(())
}

/// A comment follows `;`. On a Fanuc and a Haas `;` is the end of a block: words after it would be
/// a second one.
fn after_semicolon(s: &mut Scanner<'_>, flavor: Flavor, block: &mut IsoBlock) -> Result<(), Fault> {
    s.bump();
    if flavor.is_linuxcnc() {
        return Ok(());
    }
    let start = s.pos();
    let mut words = 0;
    let mut probe = s.clone();
    loop {
        probe.skip_blanks();
        if probe.at_end() || probe.peek() == b'(' {
            break;
        }
        if !probe.peek().is_ascii_alphabetic() {
            return Ok(());
        }
        probe.bump();
        if probe.decimal().is_none() {
            return Ok(());
        }
        words += 1;
    }
    if words == 0 {
        return Ok(());
    }
    if block.is_empty() && block.number.is_none() && block.skip.is_none() {
        // Nothing precedes the `;`: a block that was commented out.
        block.remarks.push(Remark::Assumed("the words of a line that begins with `;` are a comment"));
        return Ok(());
    }
    Err(Fault::new(codes::SYNTAX, Span::new(start, probe.pos()), "words after `;`, which ends the block")
        .help(
            "write them in a line of their own, or as a comment in ( ); on a LinuxCNC, a Mach3 and a Grbl they are a comment: \
             --control linuxcnc-2.9, mach3 or grbl-1.1 reads them so",
        ))
}
