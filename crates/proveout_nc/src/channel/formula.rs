//! How formulas are read: one parser by priorities (Pratt, *Top down operator precedence*, 1973) for all
//! languages.
//!
//! ```text
//!   formula = operand { operator operand }        operators of one priority from left to right
//!   operand = sign operand | number | bracket | what the language has besides: variables, functions, texts
//! ```
//!
//! A language is a [`Grammar`], a table of its operators and the words of its messages, and the [`Formulas`]
//! that it reads.

use super::expression::{Expr, Function, MAX_DEPTH, Operator};
use crate::codes;
use crate::diagnostic::Fault;
use crate::scan::Scanner;

/// What the formulas of a language are made of.
#[derive(Debug)]
pub(crate) struct Grammar {
    /// Operators with their priorities, the highest binds strongest; longer ones before those that they begin
    /// with.
    pub(crate) operators: &'static [(&'static str, Operator, u8)],
    /// A word is an operator only where no letter or digit follows it; otherwise blanks are
    /// optional and words may follow each other directly.
    pub(crate) whole_words: bool,
    /// Priority of comparisons that cannot be chained, and what to write instead.
    pub(crate) comparison: Option<(u8, &'static str)>,
    /// A sign binds to operators of this priority and above; [`u8::MAX`]: to the operand that
    /// follows it.
    pub(crate) sign: u8,
    /// What encloses a formula within another.
    pub(crate) brackets: [u8; 2],
    /// For messages: what a formula is called, how to split one that is nested too deeply, and what
    /// is allowed where a value is expected.
    pub(crate) name: &'static str,
    pub(crate) split_with: &'static str,
    pub(crate) operands: &'static str,
}

/// Text with formulas of a language.
pub(crate) trait Formulas<'a> {
    type Param;

    fn grammar(&self) -> &'static Grammar;

    fn scanner(&mut self) -> &mut Scanner<'a>;

    /// Skips what is allowed between two words.
    fn blanks(&mut self) {
        self.scanner().skip_blanks();
    }

    /// Takes the operator that is next, if any.
    fn operator(&mut self) -> Option<(Operator, u8)> {
        let grammar = self.grammar();
        grammar.take_operator(self.scanner())
    }

    /// A number; a digit or a point is next.
    fn number(&mut self) -> Result<f64, Fault>;

    /// An operand that is neither number, sign nor bracket; none where the next text begins no
    /// operand.
    fn other_operand(&mut self, depth: u32) -> Result<Option<Expr<Self::Param>>, Fault>;
}

impl Grammar {
    fn take_operator(&self, s: &mut Scanner<'_>) -> Option<(Operator, u8)> {
        let next = |text: &str| text.bytes().enumerate().all(|(at, byte)| s.peek_at(at).to_ascii_uppercase() == byte);
        let ends = |text: &str| {
            let behind = s.peek_at(text.len());
            let word = text.as_bytes().first().is_some_and(u8::is_ascii_alphabetic);
            !(self.whole_words && word && (behind.is_ascii_alphanumeric() || matches!(behind, b'_' | b'$')))
        };
        let &(text, operator, priority) = self.operators.iter().find(|(text, ..)| next(text) && ends(text))?;
        s.set_pos(s.pos() + text.len());
        Some((operator, priority))
    }
}

/// Reads a formula; leaves the scanner after it.
pub(crate) fn formula<'a, F: Formulas<'a>>(text: &mut F, depth: u32) -> Result<Expr<F::Param>, Fault> {
    parse(text, 0, depth)
}

/// Reads as far as operators bind at least as strongly as `lowest`.
pub(crate) fn parse<'a, F: Formulas<'a>>(text: &mut F, lowest: u8, depth: u32) -> Result<Expr<F::Param>, Fault> {
    let first = operand(text, depth)?;
    let mut rest = Vec::new();
    let mut compared = false;
    loop {
        let before = text.scanner().pos();
        text.blanks();
        let from = text.scanner().pos();
        let Some((operator, priority)) = text.operator().filter(|(_, priority)| *priority >= lowest) else {
            text.scanner().set_pos(before);
            return Ok(if rest.is_empty() { first } else { Expr::Chain(Box::new(first), rest) });
        };
        if let Some((comparison, help)) = text.grammar().comparison
            && priority == comparison
            && std::mem::replace(&mut compared, true)
        {
            let span = text.scanner().span_from(from);
            return Err(Fault::new(codes::SYNTAX, span, "comparisons cannot be chained").help(help));
        }
        rest.push((operator, parse(text, priority + 1, depth + 1)?));
    }
}

/// Reads one operand with its signs.
pub(crate) fn operand<'a, F: Formulas<'a>>(text: &mut F, depth: u32) -> Result<Expr<F::Param>, Fault> {
    text.blanks();
    let grammar = text.grammar();
    let s = text.scanner();
    if depth > MAX_DEPTH {
        let message = format!("the {} is nested deeper than {MAX_DEPTH} levels", grammar.name);
        let help = format!("split it with {}", grammar.split_with);
        return Err(Fault::new(codes::NESTING_LIMIT, s.here(), message).help(help));
    }
    match s.peek() {
        b'0'..=b'9' | b'.' => text.number().map(Expr::Number),
        sign @ (b'-' | b'+') => {
            s.bump();
            // The sign of a literal belongs to the literal, so that -0.5 is a number and not an operation.
            Ok(match parse(text, grammar.sign, depth + 1)? {
                inner if sign == b'+' => inner,
                Expr::Number(value) => Expr::Number(-value),
                inner => Expr::Unary(Function::Negate, Box::new(inner)),
            })
        }
        byte if byte == grammar.brackets[0] => bracket(text, depth),
        _ => match text.other_operand(depth)? {
            Some(operand) => Ok(operand),
            None => Err(no_operand(text.scanner(), grammar)),
        },
    }
}

/// A formula in brackets; the scanner is before the opening one, or before blanks.
pub(crate) fn bracket<'a, F: Formulas<'a>>(text: &mut F, depth: u32) -> Result<Expr<F::Param>, Fault> {
    text.blanks();
    let grammar = text.grammar();
    let [open, end] = grammar.brackets;
    let s = text.scanner();
    let start = s.pos();
    if !s.take(open) {
        let message = format!("`{}` is missing", char::from(open));
        return Err(
            Fault::new(codes::SYNTAX, s.here(), message).help(format!("put the {} into brackets", grammar.name))
        );
    }
    let inner = formula(text, depth + 1)?;
    close(text, end, start)?;
    Ok(inner)
}

/// Takes the closing bracket of what began at `start`.
pub(crate) fn close<'a, F: Formulas<'a>>(text: &mut F, bracket: u8, start: usize) -> Result<(), Fault> {
    text.blanks();
    if text.scanner().take(bracket) {
        return Ok(());
    }
    let bracket = char::from(bracket);
    Err(Fault::new(codes::SYNTAX, text.scanner().span_from(start), format!("`{bracket}` is missing"))
        .help(format!("write `{bracket}`")))
}

fn no_operand(s: &Scanner<'_>, grammar: &Grammar) -> Fault {
    let Some(found) = s.peek_char() else {
        return Fault::new(codes::MISSING_VALUE, s.here(), "a value is missing at the end of the block")
            .help("write the value");
    };
    let shown = if found.is_control() { found.escape_default().to_string() } else { found.to_string() };
    Fault::new(codes::SYNTAX, s.here(), format!("a value was expected and `{shown}` was found")).help(grammar.operands)
}
