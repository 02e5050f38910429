//! Words of Okuma OSP that a Fanuc has not: they are parsed in every program with macro B, and refused where the control file
//! does not say `program.words = "osp"`.
//!
//! ```text
//!   VC1=VC2+5   X=VC1          common variables, and words by an expression
//!   IF [VC1 GT 5] N100         a jump
//!   CALL O200 Q3 ... RTS       a subprogram, three times
//!   NCYL X10. Y0.              a point of a cycle where it is only positioned
//! ```
//!
//! After Okuma, *OSP-E100M programming manual* (4292-E), "User task" (common variables `VC1` to `VC200`, which keep their values,
//! IF, GOTO, CALL, RTS with Q for the number of passes) and "Fixed cycles" (NCYL). Local variables by name, variables that a CALL
//! hands over, sequence names of letters, NOEX and MODIN are refused.

use super::expr::{self, Expr};
use super::flavor::Flavor;
use super::interpreter::Interpreter;
use super::parser::Block;
use super::statement::Statement;
use crate::channel::expression::Indexed;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::scan::Scanner;

/// Common variables are kept behind all parameters of macro B.
const COMMON: u32 = 900_000;
/// `VC1` to `VC200`.
const MOST_COMMON: u32 = 200;

/// Number of the common variable that a parameter stands for.
pub(super) fn common(parameter: u32) -> Option<u32> {
    parameter.checked_sub(COMMON).filter(|number| (1..=MOST_COMMON).contains(number))
}

/// `VC` and a digit are next.
pub(super) fn variable_is_next(s: &Scanner<'_>, flavor: Flavor) -> bool {
    !flavor.is_linuxcnc() && expr::next_is(s, "VC") && s.peek_at(2).is_ascii_digit()
}

/// `VC12`; the scanner stands on it.
pub(super) fn variable(s: &mut Scanner<'_>) -> Result<Expr, Fault> {
    let start = s.pos();
    s.set_pos(start + 2);
    match s.integer() {
        Some(number) if (1..=MOST_COMMON).contains(&number) => {
            Ok(Indexed::expr(Expr::Number(f64::from(COMMON + number))))
        }
        _ => Err(Fault::new(
            codes::BAD_VALUE,
            s.span_from(start),
            format!("common variables are VC1 to VC{MOST_COMMON}"),
        )
        .help("use one of them")),
    }
}

/// `CALL O200 Q3` or `RTS`, if it is next.
pub(super) fn call_or_return(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Option<Statement>, Fault> {
    if !s.peek_at(1).is_ascii_alphabetic() || flavor.is_linuxcnc() {
        return Ok(None);
    }
    let start = s.pos();
    if expr::next_is(s, "RTS") {
        s.set_pos(start + 3);
        return Ok(Some(Statement::EndCall));
    }
    if !expr::next_is(s, "CALL") {
        return Ok(None);
    }
    s.set_pos(start + 4);
    s.skip_blanks();
    if !s.take(b'O') && !s.take(b'o') {
        return Err(Fault::new(codes::SYNTAX, s.span_from(start), "CALL names no program").help("write CALL O200"));
    }
    let Some(program) = s.integer() else {
        let message = "CALL of a program whose name has letters is not supported";
        return Err(
            Fault::new(codes::UNSUPPORTED_WORD, s.span_from(start), message).help("give the program a number: O200")
        );
    };
    s.skip_blanks();
    let passes = if s.take(b'Q') || s.take(b'q') { Some(expr::operand(s, flavor)?) } else { None };
    Ok(Some(Statement::Call(program, passes)))
}

/// The words of this language in a block, where the control does not have them.
pub(super) fn refused(block: &Block, has_them: bool) -> Option<Fault> {
    let (word, span) = block.osp.filter(|_| !has_them)?;
    let message = format!("{word} is a word of Okuma OSP, which this control has not");
    Some(
        Fault::new(codes::UNSUPPORTED_WORD, span, message)
            .help("this looks like Okuma OSP: name that control (okuma-osp), or post for this control"),
    )
}

impl Interpreter {
    /// CALL: nothing else stands in its block.
    pub(super) fn call_program(
        &mut self,
        program: u32,
        passes: Option<&Expr>,
        block: &Block,
        span: Span,
    ) -> Result<(), Fault> {
        if !block.words.is_empty() || !block.assignments.is_empty() {
            let message = "words in the block of a CALL, which would be handed over, are not supported";
            return Err(
                Fault::new(codes::UNSUPPORTED_WORD, span, message).help("write the values into VC variables before it")
            );
        }
        let passes = match passes {
            Some(passes) => self.number(passes, span)?,
            None => 1.0,
        };
        self.call_sub(Some(f64::from(program)), Some(passes), span)
    }

    /// RTS.
    pub(super) fn end_call(&mut self, span: Span) -> Result<(), Fault> {
        if self.stack.len() <= 1 {
            return Err(Fault::new(codes::STRUCTURE, span, "RTS ends a subprogram, and stands in the main program")
                .help("write M2"));
        }
        self.return_from_sub(None, span)
    }
}
