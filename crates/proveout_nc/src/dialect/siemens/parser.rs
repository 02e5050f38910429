//! One line of text to one block.

use super::expr::{self, Expr};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::dialect::foreign::{SIEMENS, told};
use crate::scan::Scanner;

/// A block as written. Reused from line to line, so that plain blocks allocate nothing.
#[derive(Debug, Default)]
pub(crate) struct SiemensBlock {
    /// Level of `/`, if the block can be skipped.
    pub(crate) skip: Option<u8>,
    pub(crate) number: Option<u32>,
    pub(crate) label: Option<String>,
    pub(crate) words: Vec<Word>,
    pub(crate) statement: Option<SiemensStatement>,
    /// From the first word to the end of the last.
    pub(crate) span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Word {
    pub(crate) kind: WordKind,
    pub(crate) span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum WordKind {
    /// `X10`, `X=R1`, `A3=0.5` (extension 3), `R10=5`.
    Address { letter: u8, extension: Option<u32>, value: AddressValue },
    /// `_VAR=5`, `CR=10`, `$P_UIFR[1,X,TR]=3`, `R[5]=1`.
    Assign { name: String, indices: Vec<Expr>, value: Expr },
    /// `TRAORI`.
    Name(String),
    /// `CYCLE832(0.02, 1)`.
    Call(Call),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AddressValue {
    Number(f64),
    Expr(Box<Expr>),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Call {
    pub(crate) name: String,
    /// None where the call has no brackets.
    pub(crate) arguments: Option<Vec<Option<Expr>>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Forward,
    Backward,
    Either,
    /// GOTOC: as GOTO, and no fault where the target is missing.
    Silent,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Jump {
    pub(crate) direction: Direction,
    pub(crate) target: Expr,
    pub(crate) span: Span,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    Real,
    Int,
    Bool,
    Text,
    Frame,
    /// The letter of an axis.
    Axis,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Definition {
    pub(crate) name: String,
    pub(crate) sizes: Vec<Expr>,
    pub(crate) initial: Option<Expr>,
    pub(crate) span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    pub(crate) kind: Type,
    pub(crate) by_reference: bool,
    pub(crate) initial: Option<Expr>,
    /// Sizes of an array, none of a single value; `[,]` leaves both open.
    pub(crate) sizes: Option<Vec<Option<Expr>>>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SiemensStatement {
    If(Expr),
    IfGoto(Expr, Jump),
    Else,
    EndIf,
    For {
        variable: Expr,
        from: Expr,
        to: Expr,
    },
    EndFor,
    While(Expr),
    EndWhile,
    Repeat,
    Until(Expr),
    Loop,
    EndLoop,
    Goto(Jump),
    /// GOTOS: to the first block of the program.
    GotoStart,
    Case {
        selector: Expr,
        branches: Vec<(Expr, Jump)>,
        default: Option<Jump>,
    },
    /// `REPEAT FIRST [LAST] [P=n]`; `only_block` for REPEATB.
    RepeatLabel {
        first: String,
        last: Option<String>,
        count: Option<Expr>,
        only_block: bool,
    },
    Define {
        kind: Type,
        variables: Vec<Definition>,
    },
    Proc {
        name: String,
        parameters: Vec<Parameter>,
        save: bool,
    },
    Extern,
    Return,
    /// `MCALL` alone ends the modal call.
    ModalCall(Option<Call>),
    /// `CALL "NAME"`.
    CallText(Expr),
}

impl SiemensBlock {
    fn clear(&mut self) {
        self.skip = None;
        self.number = None;
        self.label = None;
        self.words.clear();
        self.statement = None;
        self.span = Span::default();
    }

    /// Addresses that take only numbers.
    pub(crate) fn is_plain(&self) -> bool {
        let plain = |word: &Word| matches!(word.kind, WordKind::Address { value: AddressValue::Number(_), .. });
        self.statement.is_none() && self.words.iter().all(plain)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.words.is_empty() && self.statement.is_none()
    }
}

/// Reads a line into the block.
pub(crate) fn parse_line(line: &str, block: &mut SiemensBlock) -> Result<(), Fault> {
    read_line(line, block).map_err(|fault| if fault.code == codes::SYNTAX { told(fault, line, SIEMENS) } else { fault })
}

fn read_line(line: &str, block: &mut SiemensBlock) -> Result<(), Fault> {
    block.clear();
    let mut s = Scanner::new(line);
    head(&mut s, block)?;
    let start = s.pos();
    let mut end = start;
    loop {
        s.skip_blanks();
        match s.peek() {
            b';' => break,
            0 if s.at_end() => break,
            b'A'..=b'Z' | b'a'..=b'z' | b'_' | b'$' => word(&mut s, block)?,
            _ => {
                let shown = s.peek_char().unwrap_or(' ').escape_default();
                return Err(Fault::new(codes::SYNTAX, s.here(), format!("unexpected character `{shown}`"))
                    .help("a block holds words such as X10 or NAME=1; comments begin with `;`"));
            }
        }
        end = s.pos();
    }
    block.span = Span::new(start, end);
    match (&block.statement, block.words.first()) {
        (Some(_), Some(word)) => Err(Fault::new(codes::SYNTAX, word.span, "a word after a statement")
            .help("write it in a block of its own; control structures, jumps and calls need their own block")),
        _ => Ok(()),
    }
}

/// Program header lines, `/`, block number and label.
fn head(s: &mut Scanner<'_>, block: &mut SiemensBlock) -> Result<(), Fault> {
    s.skip_blanks();
    if s.peek() == b'%' {
        // `%_N_NAME_MPF` of an archive: found by the index of the file, nothing to execute.
        while !s.at_end() {
            s.bump();
        }
        return Ok(());
    }
    if s.take(b'/') {
        block.skip = Some(if s.peek().is_ascii_digit() {
            let level = s.peek() - b'0';
            s.bump();
            level
        } else {
            0
        });
        s.skip_blanks();
    }
    let start = s.pos();
    let numbered = matches!(s.peek(), b'N' | b'n' | b':');
    if numbered && matches!(s.peek_at(1), b'0'..=b'9' | b' ' | b'\t') {
        s.bump();
        s.skip_blanks();
        block.number = Some(s.integer().ok_or_else(|| {
            Fault::new(codes::BAD_VALUE, s.span_from(start), "the block number is missing or has more than nine digits")
                .help("write N and up to nine digits")
        })?);
        s.skip_blanks();
    }
    // A second `/` position, `N10 /1 ...`, is written by some posts.
    if block.number.is_some() && block.skip.is_none() && s.take(b'/') {
        block.skip = Some(if s.peek().is_ascii_digit() { (s.integer().unwrap_or(0) % 10) as u8 } else { 0 });
        s.skip_blanks();
    }
    if matches!(s.peek(), b'A'..=b'Z' | b'a'..=b'z' | b'_') {
        let start = s.pos();
        let name = s.identifier();
        let label = name.len() > 1 && s.peek() == b':' && s.peek_at(1) != b'=';
        if label {
            block.label = Some(name.to_ascii_uppercase());
            s.bump();
            s.skip_blanks();
        } else {
            s.set_pos(start);
        }
    }
    Ok(())
}

fn is_letter(byte: u8) -> bool {
    byte.is_ascii_alphabetic() || byte == b'_'
}

fn word(s: &mut Scanner<'_>, block: &mut SiemensBlock) -> Result<(), Fault> {
    let start = s.pos();
    let first = s.peek();
    if !first.is_ascii_alphabetic() || is_letter(s.peek_at(1)) {
        return identifier_word(s, block);
    }
    let letter = first.to_ascii_uppercase();
    s.bump();
    let kind = address(s, letter, start)?;
    block.words.push(Word { kind, span: s.span_from(start) });
    Ok(())
}

/// True when `=` and not `==` is next, blanks before it allowed; the `=` is taken.
fn take_assign(s: &mut Scanner<'_>) -> bool {
    let before = s.pos();
    s.skip_blanks();
    if s.peek() == b'=' && s.peek_at(1) != b'=' {
        s.bump();
        return true;
    }
    s.set_pos(before);
    false
}

fn address(s: &mut Scanner<'_>, letter: u8, start: usize) -> Result<WordKind, Fault> {
    if s.peek() == b'[' {
        let indices = expr::indices(s, 0)?;
        if !take_assign(s) {
            return Err(no_value(s, start));
        }
        let value = expr::expression(s)?;
        return Ok(WordKind::Assign { name: char::from(letter).to_string(), indices, value });
    }
    if s.peek().is_ascii_digit() {
        // `A3=`: digits are an extension when `=` follows them.
        let digits = s.pos();
        let extension = s.integer();
        if take_assign(s) {
            let extension = extension.ok_or_else(|| {
                Fault::new(codes::BAD_VALUE, s.span_from(start), "the number after the letter is too large")
                    .help("use at most nine digits")
            })?;
            return Ok(WordKind::Address { letter, extension: Some(extension), value: value(s)? });
        }
        s.set_pos(digits);
    } else if take_assign(s) {
        return Ok(WordKind::Address { letter, extension: None, value: value(s)? });
    }
    let before = s.pos();
    s.skip_blanks();
    if !matches!(s.peek(), b'0'..=b'9' | b'.' | b'-' | b'+') {
        s.set_pos(before);
        return Err(no_value(s, start));
    }
    Ok(WordKind::Address { letter, extension: None, value: AddressValue::Number(expr::number(s)?) })
}

fn value(s: &mut Scanner<'_>) -> Result<AddressValue, Fault> {
    Ok(match expr::expression(s)? {
        Expr::Number(number) => AddressValue::Number(number),
        other => AddressValue::Expr(Box::new(other)),
    })
}

fn no_value(s: &Scanner<'_>, start: usize) -> Fault {
    let word = s.slice(start);
    Fault::new(codes::MISSING_VALUE, s.span_from(start), format!("`{word}` has no value"))
        .help(format!("write for example {word}10 or {word}=R1"))
}

fn identifier_word(s: &mut Scanner<'_>, block: &mut SiemensBlock) -> Result<(), Fault> {
    let start = s.pos();
    let name = s.identifier().to_ascii_uppercase();
    if take_assign(s) {
        let value = expr::expression(s)?;
        block
            .words
            .push(Word { kind: WordKind::Assign { name, indices: Vec::new(), value }, span: s.span_from(start) });
        return Ok(());
    }
    if s.peek() == b'[' && name != "STRING" {
        let indices = expr::indices(s, 0)?;
        if !take_assign(s) {
            return Err(no_value(s, start));
        }
        s.skip_blanks();
        // `PO[X]=(10, 2, -3)`: end and coefficients of a polynomial.
        let value = if name == "PO" && s.peek() == b'(' {
            Expr::Call(name.clone(), expr::arguments(s)?)
        } else {
            expr::expression(s)?
        };
        block.words.push(Word { kind: WordKind::Assign { name, indices, value }, span: s.span_from(start) });
        return Ok(());
    }
    if let Some(statement) = super::statement::statement(s, &name, start)? {
        if block.statement.is_some() || !block.words.is_empty() {
            return Err(Fault::new(
                codes::SYNTAX,
                s.span_from(start),
                format!("`{name}` must be the first word of its block"),
            )
            .help("begin a new line"));
        }
        block.statement = Some(statement);
        return Ok(());
    }
    let before = s.pos();
    s.skip_blanks();
    let kind = if s.peek() == b'(' {
        WordKind::Call(Call { name, arguments: Some(expr::arguments(s)?) })
    } else {
        s.set_pos(before);
        WordKind::Name(name)
    };
    block.words.push(Word { kind, span: s.span_from(start) });
    Ok(())
}
