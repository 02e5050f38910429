//! Words of Okuma OSP that a Fanuc does not have. They are parsed in every program with macro B,
//! and refused where the control file does not say `program.words = "osp"`.
//!
//! ```text
//!   VC1=VC2+5   X=VC1          common variables, and words by an expression
//!   IF [VC1 GT 5] N100         a jump
//!   CALL O200 Q3 ... RTS       a subprogram, three times
//!   CALL OBOLT PX=10 DIA=40    with values for local variables of the subprogram
//!   MODIN OBOLT PX=10 ... MODOUT   the same after every motion of an axis
//!   LX=10   X=LX+5             local variables: two letters and up to two letters or digits
//!   NEND G0 Z100 ... GOTO NEND a sequence name of letters
//!   NOEX VC1=3                 a block that is no step of its own
//!   NCYL X10. Y0.              a point of a cycle where it is only positioned
//!   DEF WORK ... END   DRAW    blank and picture of the animation: without effect
//! ```
//!
//! After Okuma, *OSP-E100M programming manual* (4292-E), "User task" (common variables `VC1` to `VC200`,
//! which keep their values, IF, GOTO, CALL, MODIN, RTS with Q for the number of passes, local variables,
//! sequence names) and "Fixed cycles" (NCYL). Local variables belong to the program that sets them; that a
//! subprogram does not see those of its caller is from memory.

use super::expr::{self, Expr};
use super::flavor::Flavor;
use super::parser::IsoBlock;
use super::run_state::Interpreter;
use super::statement::IsoStatement;
use crate::ToolName;
use crate::channel::expression::IndexedParameter;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::scan::Scanner;

/// Common variables are numbered above all parameters of macro B.
const COMMON: u32 = 900_000;
/// `VC1` to `VC200`.
const MOST_COMMON: u32 = 200;

/// Number of the common variable that is kept under a parameter number.
pub(super) fn common(parameter: u32) -> Option<u32> {
    parameter.checked_sub(COMMON).filter(|number| (1..=MOST_COMMON).contains(number))
}

/// `VC` and a digit are next.
pub(super) fn variable_is_next(s: &Scanner<'_>, flavor: Flavor) -> bool {
    !flavor.is_linuxcnc() && expr::next_is(s, "VC") && s.peek_at(2).is_ascii_digit()
}

/// `VC12`; the scanner is at its start.
pub(super) fn variable(s: &mut Scanner<'_>) -> Result<Expr, Fault> {
    let start = s.pos();
    s.set_pos(start + 2);
    match s.integer() {
        Some(number) if (1..=MOST_COMMON).contains(&number) => {
            Ok(IndexedParameter::expr(Expr::Number(f64::from(COMMON + number))))
        }
        _ => Err(Fault::new(
            codes::BAD_VALUE,
            s.span_from(start),
            format!("common variables are VC1 to VC{MOST_COMMON}"),
        )
        .help("use one of them")),
    }
}

/// A name of two letters and up to two letters or digits; returns the index of the byte after it.
fn name_at(s: &Scanner<'_>, from: usize) -> Option<usize> {
    let byte = |i: usize| s.peek_at(from + i);
    if !(byte(0).is_ascii_alphabetic() && byte(1).is_ascii_alphabetic()) {
        return None;
    }
    let length = (2..=4).find(|&i| !byte(i).is_ascii_alphanumeric())?;
    Some(from + length)
}

/// `LX=`: a local variable and its value are next.
#[inline]
pub(super) fn local_is_next(s: &Scanner<'_>, flavor: Flavor) -> bool {
    // In nearly all words a digit, a sign or a point follows the letter.
    if !s.peek_at(1).is_ascii_alphabetic() || flavor.is_linuxcnc() || variable_is_next(s, flavor) {
        return false;
    }
    let Some(mut at) = name_at(s, 0) else { return false };
    while matches!(s.peek_at(at), b' ' | b'\t') {
        at += 1;
    }
    s.peek_at(at) == b'='
}

/// The name of a local variable; the scanner is at its start.
pub(super) fn local(s: &mut Scanner<'_>) -> String {
    let start = s.pos();
    s.set_pos(start + name_at(s, 0).unwrap_or(0));
    s.slice(start).to_ascii_uppercase()
}

/// Sequence names are numbered above all block numbers.
pub(super) const NAMED_SEQUENCE: u32 = 1_000_000_000;

/// `END` after N, as a block number of its own; the scanner is after the N.
pub(super) fn sequence(s: &mut Scanner<'_>, flavor: Flavor) -> Option<u32> {
    if flavor.is_linuxcnc() || !s.peek().is_ascii_alphabetic() {
        return None;
    }
    let length = (1..=4).find(|&i| !s.peek_at(i).is_ascii_alphanumeric())?;
    let mut number = 0;
    for _ in 0..length {
        number = number * 37 + 1 + char::from(s.peek()).to_digit(36)?;
        s.bump();
    }
    Some(NAMED_SEQUENCE + number)
}

/// Program, passes and values of a CALL or MODIN.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ProgramCall {
    /// Number without leading zeros, or `<name>`.
    program: String,
    passes: Option<Expr>,
    values: Vec<(String, Expr)>,
}

/// `CALL O200 Q3`, `MODIN O200`, `MODOUT` or `RTS`, if it is next.
pub(super) fn call_or_return(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Option<IsoStatement>, Fault> {
    if !s.peek_at(1).is_ascii_alphabetic() || flavor.is_linuxcnc() {
        return Ok(None);
    }
    let start = s.pos();
    for (word, statement) in [("RTS", IsoStatement::EndCall), ("MODOUT", IsoStatement::EndModal)] {
        if expr::next_is(s, word) {
            s.set_pos(start + word.len());
            return Ok(Some(statement));
        }
    }
    let Some(word) = ["CALL", "MODIN"].into_iter().find(|word| expr::next_is(s, word)) else { return Ok(None) };
    s.set_pos(start + word.len());
    s.skip_blanks();
    if !s.take(b'O') && !s.take(b'o') {
        return Err(Fault::new(codes::SYNTAX, s.span_from(start), format!("{word} names no program"))
            .help(format!("write {word} O200")));
    }
    let program = match s.integer() {
        Some(number) => number.to_string(),
        None => {
            let from = s.pos();
            while s.peek().is_ascii_alphanumeric() {
                s.bump();
            }
            let name = s.slice(from).to_ascii_lowercase();
            if name.is_empty() {
                return Err(Fault::new(codes::SYNTAX, s.span_from(start), format!("{word} names no program"))
                    .help(format!("write {word} O200")));
            }
            format!("<{name}>")
        }
    };
    let (mut passes, mut values) = (None, Vec::new());
    loop {
        s.skip_blanks();
        if local_is_next(s, flavor) {
            let name = local(s);
            s.skip_blanks();
            s.bump();
            values.push((name, expr::expression(s, flavor)?));
        } else if passes.is_none() && (s.take(b'Q') || s.take(b'q')) {
            passes = Some(expr::operand(s, flavor)?);
        } else {
            break;
        }
    }
    let call = Box::new(ProgramCall { program, passes, values });
    Ok(Some(if word == "CALL" { IsoStatement::Call(call) } else { IsoStatement::ModalCall(call) }))
}

/// A line that describes the blank for the animation of the control, or draws: `DEF WORK`, `PS
/// LC,[0,0,-20],[100,80,20]`, `END`, `DRAW`, `CLEAR`.
pub(super) fn animation(line: &str) -> Option<&'static str> {
    // Every line of every ISO program passes here: the first two letters exclude nearly all of
    // them, without building a text.
    let starts = line.trim_start().as_bytes();
    let [first, second, ..] = starts else { return None };
    if !matches!(first, b'D' | b'd' | b'P' | b'p' | b'C' | b'c' | b'E' | b'e') || !second.is_ascii_alphabetic() {
        return None;
    }
    let code = line.split('(').next().unwrap_or_default().trim().to_ascii_uppercase();
    let mut words = code.split([' ', ',', '\t']).filter(|w| !w.is_empty());
    match (words.next()?, words.next()) {
        ("DEF", Some("WORK")) => Some("`DEF WORK`"),
        ("PS", Some(shape)) if shape.len() == 2 && shape.bytes().all(|b| b.is_ascii_uppercase()) => Some("`PS`"),
        ("DRAW", None) => Some("`DRAW`"),
        ("CLEAR", None) => Some("`CLEAR`"),
        ("END", None) => Some("`END` without a number"),
        _ => None,
    }
}

/// Offsets of the tool in the spindle by a letter, `HA` and `DA`: the first set of them, B and C the others.
const SETS: [&str; 6] = ["HA", "HB", "HC", "DA", "DB", "DC"];

/// The set of offsets that a letter after H or D means.
pub(super) fn set_of_offsets(letter: u8, set: u8) -> Expr {
    Expr::Name(String::from_iter([letter, set.to_ascii_uppercase()].map(char::from)))
}

/// Whether a value is such a set.
pub(super) fn is_set_of_offsets(value: &Expr) -> bool {
    matches!(value, Expr::Name(name) if SETS.contains(&name.as_str()))
}

/// The words of this language in a block, where the control does not have them.
pub(super) fn refused(block: &IsoBlock, has_them: bool) -> Option<Fault> {
    let (word, span) = block.osp.filter(|_| !has_them)?;
    let message = format!("{word} is a word of Okuma OSP, which this control has not");
    if word.starts_with("`END`") {
        let help =
            "write DO 1 and END 1 round a loop; where it ends the DEF WORK of an Okuma, --control okuma-osp reads it";
        return Some(Fault::new(codes::UNSUPPORTED_WORD, span, message).help(help));
    }
    Some(
        Fault::new(codes::UNSUPPORTED_WORD, span, message)
            .help("this looks like Okuma OSP: name that control (okuma-osp), or post for this control"),
    )
}

impl Interpreter {
    /// Offset number for a set of the tool in the spindle: the library gives a tool one length and
    /// one radius, by its number.
    pub(super) fn own_offset(&self, name: &str, span: Span) -> Option<Result<f64, Fault>> {
        if !SETS.contains(&name) {
            return None;
        }
        Some(match self.technology.in_spindle {
            Some(ToolName::Number(number)) if name.ends_with('A') => Ok(f64::from(number)),
            Some(ToolName::Number(_)) => {
                let message =
                    format!("`{name}` is a further offset of the tool in the spindle, and the library gives it one");
                Err(Fault::new(codes::UNSUPPORTED_WORD, span, message)
                    .help("write A for the first one, or give the other offset as a tool of its own"))
            }
            _ => Err(Fault::new(
                codes::NO_TOOL,
                span,
                format!("`{name}` is an offset of the tool in the spindle, and none is"),
            )
            .help("write it after the tool change")),
        })
    }

    /// CALL and MODIN: their block has no other words.
    pub(super) fn call_program(
        &mut self,
        call: &ProgramCall,
        modal: bool,
        block: &IsoBlock,
        span: Span,
    ) -> Result<(), Fault> {
        if !block.words.is_empty() || !block.assignments.is_empty() {
            let message = "other words in the block of a CALL or MODIN are not supported";
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message)
                .help("write them in a block of their own; values for the subprogram are LX=5"));
        }
        let passes = match &call.passes {
            Some(passes) => Some(self.number(passes, span)?),
            None => None,
        };
        let mut values = Vec::with_capacity(call.values.len());
        for (name, value) in &call.values {
            values.push((name.clone(), self.number(value, span)?));
        }
        self.call_with_names(call.program.clone(), passes, values, modal, span)
    }

    /// RTS.
    pub(super) fn end_call(&mut self, span: Span) -> Result<(), Fault> {
        if self.stack.len() <= 1 {
            return Err(Fault::new(codes::STRUCTURE, span, "RTS ends a subprogram, but is in the main program")
                .help("write M2"));
        }
        self.return_from_sub(None, span)
    }
}
