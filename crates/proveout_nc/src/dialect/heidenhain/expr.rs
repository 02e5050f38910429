//! Formulas of Q parameters: `Q1 = Q2 * SIN 30 + SQRT Q5`.
//!
//! Priorities after the user's manual (HEIDENHAIN, *TNC 640 Klartext programming*, "Entering
//! formulas directly"): a function applies to the operand after it; then `^`, then `* / %`, then
//! `+ -`. Operators of the same priority run from left to right.

use super::lexer::{Lexer, refused, unknown};
use super::words::Param;
use crate::channel::expression::{self, Function, Operator};
use crate::channel::formula::{self, Formulas, Grammar};
use crate::codes;
use crate::diagnostic::Fault;
use crate::scan::Scanner;

/// A formula of Q parameters.
pub(crate) type Expr = expression::Expr<Param>;

static GRAMMAR: Grammar = Grammar {
    operators: &[
        ("^", Operator::Power, 3),
        ("*", Operator::Multiply, 2),
        ("/", Operator::Divide, 2),
        ("%", Operator::Mod, 2),
        ("+", Operator::Add, 1),
        ("-", Operator::Subtract, 1),
        ("||", Operator::Join, 1),
    ],
    whole_words: false,
    comparison: None,
    sign: u8::MAX,
    brackets: *b"()",
    name: "formula",
    split_with: "a Q parameter",
    operands: "write a number, a Q parameter, a function or a bracket",
};

const FUNCTIONS: [(&str, Function); 17] = [
    ("SQRT", Function::Sqrt),
    ("SQ", Function::Square),
    ("SIN", Function::Sin),
    ("COS", Function::Cos),
    ("TAN", Function::Tan),
    ("ASIN", Function::Asin),
    ("ACOS", Function::Acos),
    ("ATAN", Function::Atan),
    ("LN", Function::Ln),
    ("LOG", Function::Log),
    ("EXP", Function::Exp),
    ("NEG", Function::Negate),
    ("INT", Function::TowardsZero),
    ("ABS", Function::Abs),
    ("FRAC", Function::Fraction),
    ("SGN", Function::Sign),
    ("TOCHAR", Function::Text),
];

/// Functions of texts, which are known and not done.
const TEXT_FUNCTIONS: [&str; 7] = ["SUBSTR", "TONUMB", "INSTR", "STRLEN", "STRCOMP", "SYSSTR", "CFGREAD"];

/// Parses a formula.
pub(crate) fn formula(x: &mut Lexer<'_>) -> Result<Expr, Fault> {
    formula::formula(x, 0)
}

impl<'a> Formulas<'a> for Lexer<'a> {
    type Param = Param;

    fn grammar(&self) -> &'static Grammar {
        &GRAMMAR
    }

    fn scanner(&mut self) -> &mut Scanner<'a> {
        &mut self.s
    }

    fn blanks(&mut self) {
        Self::blanks(self);
    }

    fn number(&mut self) -> Result<f64, Fault> {
        let start = self.pos();
        self.number().filter(|v| v.is_finite()).ok_or_else(|| {
            Fault::new(codes::BAD_VALUE, self.span_from(start), "not a number that can be used")
                .help("use fewer digits")
        })
    }

    fn other_operand(&mut self, depth: u32) -> Result<Option<Expr>, Fault> {
        Ok(Some(match self.peek() {
            b'"' | b'\'' => Expr::Text(self.quoted()?.unwrap_or_default()),
            b'Q' => Expr::Param(self.param()?.ok_or_else(|| self.unexpected())?),
            b'A'..=b'Z' => named(self, depth)?,
            _ => return Ok(None),
        }))
    }
}

/// PI, or a function with its operand.
fn named(x: &mut Lexer<'_>, depth: u32) -> Result<Expr, Fault> {
    let start = x.pos();
    let word = x.letters();
    if word == "PI" {
        return Ok(Expr::Number(std::f64::consts::PI));
    }
    match FUNCTIONS.iter().find(|(name, _)| *name == word) {
        Some((_, Function::Text)) => {
            x.blanks();
            let open = x.s.take(b'(');
            x.prefix("DAT");
            let inner = formula::formula(x, depth + 1)?;
            if x.prefix("DECIMALS") {
                return Err(refused("DECIMALS", x.span_from(start), "write the text itself"));
            }
            if open {
                formula::close(x, b')', start)?;
            }
            Ok(Expr::Unary(Function::Text, Box::new(inner)))
        }
        Some(&(_, function)) => Ok(Expr::Unary(function, Box::new(formula::operand(x, depth + 1)?))),
        None if TEXT_FUNCTIONS.contains(&word.as_str()) => {
            Err(refused(&word, x.span_from(start), "write the value itself"))
        }
        None => Err(unknown(&word, x.span_from(start))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::Span;

    fn number(e: &Expr) -> f64 {
        match e {
            Expr::Number(v) => *v,
            Expr::Unary(f, a) => expression::apply(*f, number(a), Span::default()).unwrap(),
            Expr::Chain(first, rest) => rest.iter().fold(number(first), |left, (o, right)| {
                expression::combine(*o, left, number(right), Span::default()).unwrap()
            }),
            _ => f64::NAN,
        }
    }

    #[test]
    fn priorities_follow_the_manual() {
        for (text, want) in [
            ("12 + 2 * 3 ^ 2", 30.0),
            ("12 - 10 - 1", 1.0),
            ("2 ^ 3 ^ 2", 64.0),
            ("- 3 ^ 2", 9.0),
            ("SQ 3 + 1", 10.0),
            ("SQRT 16 * 2", 8.0),
            ("SIN 90 * 2 + COS ( 30 + 60 )", 2.0),
            ("7 % 4 * 2", 6.0),
            ("INT 7.9 - FRAC 1.5 + SGN -3 + NEG 2", 3.5),
            ("+5 * -2", -10.0),
        ] {
            let mut x = Lexer::new(text);
            let got = number(&formula(&mut x).unwrap());
            assert!((got - want).abs() < 1e-12, "{text}: {got}");
            assert!(x.ended());
        }
    }

    #[test]
    fn deep_nesting_is_refused() {
        for text in ["(".repeat(5000), "-".repeat(5000), "SIN ".repeat(5000)] {
            assert_eq!(formula(&mut Lexer::new(&text)).unwrap_err().code, codes::NESTING_LIMIT);
        }
    }
}
