//! Formulas of Q parameters: `Q1 = Q2 * SIN 30 + SQRT Q5`.
//!
//! Priorities after the user's manual (HEIDENHAIN, *TNC 640 Klartext programming*, "Entering formulas directly"): a function
//! binds to the operand behind it, then `^`, then `* / %`, then `+ -`; operators of the same priority run from left to right.

use super::lexer::Lexer;
use super::words::Param;
use crate::channel::expression::{self, Function, MAX_DEPTH, Operator};
use crate::codes;
use crate::diagnostic::{Fault, Span};

/// A formula of Q parameters.
pub(crate) type Expr = expression::Expr<Param>;

fn priority(operator: Operator) -> u8 {
    match operator {
        Operator::Power => 3,
        Operator::Multiply | Operator::Divide | Operator::Mod => 2,
        _ => 1,
    }
}

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

/// Parses a formula.
pub(crate) fn formula(x: &mut Lexer<'_>) -> Result<Expr, Fault> {
    parse(x, 0, 0)
}

fn parse(x: &mut Lexer<'_>, lowest: u8, depth: u32) -> Result<Expr, Fault> {
    let mut left = operand(x, depth)?;
    loop {
        let before = x.pos();
        x.blanks();
        let (operator, length) = match (x.peek(), x.peek_at(1)) {
            (b'+', _) => (Operator::Add, 1),
            (b'-', _) => (Operator::Subtract, 1),
            (b'*', _) => (Operator::Multiply, 1),
            (b'/', _) => (Operator::Divide, 1),
            (b'%', _) => (Operator::Mod, 1),
            (b'^', _) => (Operator::Power, 1),
            (b'|', b'|') => (Operator::Join, 2),
            _ => {
                x.set_pos(before);
                return Ok(left);
            }
        };
        if priority(operator) <= lowest {
            x.set_pos(before);
            return Ok(left);
        }
        x.set_pos(x.pos() + length);
        let right = parse(x, priority(operator), depth + 1)?;
        left = Expr::Binary(operator, Box::new(left), Box::new(right));
    }
}

fn operand(x: &mut Lexer<'_>, depth: u32) -> Result<Expr, Fault> {
    x.blanks();
    let start = x.pos();
    if depth > MAX_DEPTH {
        let message = format!("the formula is nested deeper than {MAX_DEPTH} levels");
        return Err(Fault::new(codes::NESTING_LIMIT, x.s.here(), message).help("split it with a Q parameter"));
    }
    match x.peek() {
        b'0'..=b'9' | b'.' => x.s.decimal().filter(|v| v.is_finite()).map(Expr::Number).ok_or_else(|| {
            Fault::new(codes::BAD_VALUE, x.span_from(start), "not a number that can be used").help("use fewer digits")
        }),
        sign @ (b'+' | b'-') => {
            x.s.bump();
            let inner = operand(x, depth + 1)?;
            Ok(match inner {
                inner if sign == b'+' => inner,
                Expr::Number(number) => Expr::Number(-number),
                inner => Expr::Unary(Function::Negate, Box::new(inner)),
            })
        }
        b'(' => {
            x.s.bump();
            let inner = parse(x, 0, depth + 1)?;
            x.blanks();
            if x.s.take(b')') {
                return Ok(inner);
            }
            Err(Fault::new(codes::SYNTAX, x.span_from(start), "`)` is missing").help("write `)`"))
        }
        b'"' | b'\'' => Ok(Expr::Text(x.quoted()?.unwrap_or_default())),
        b'Q' => match x.param()? {
            Some(param) => Ok(Expr::Param(param)),
            None => Err(x.unexpected()),
        },
        b'A'..=b'Z' => {
            let word = x.letters();
            if word == "PI" {
                return Ok(Expr::Number(std::f64::consts::PI));
            }
            match FUNCTIONS.iter().find(|(name, _)| *name == word) {
                Some(&(_, function)) => {
                    if function == Function::Text {
                        x.blanks();
                        let open = x.s.take(b'(');
                        x.prefix("DAT");
                        let inner = parse(x, 0, depth + 1)?;
                        if x.prefix("DECIMALS") {
                            return Err(super::lexer::refused("DECIMALS", x.span_from(start), "write the text itself"));
                        }
                        x.blanks();
                        if open && !x.s.take(b')') {
                            return Err(
                                Fault::new(codes::SYNTAX, x.span_from(start), "`)` is missing").help("write `)`")
                            );
                        }
                        return Ok(Expr::Unary(function, Box::new(inner)));
                    }
                    Ok(Expr::Unary(function, Box::new(operand(x, depth + 1)?)))
                }
                None if matches!(
                    word.as_str(),
                    "SUBSTR" | "TONUMB" | "INSTR" | "STRLEN" | "STRCOMP" | "SYSSTR" | "CFGREAD"
                ) =>
                {
                    Err(super::lexer::refused(&word, x.span_from(start), "write the value itself"))
                }
                None => Err(super::lexer::unknown(&word, x.span_from(start))),
            }
        }
        0 => {
            Err(Fault::new(codes::MISSING_VALUE, Span::new(start, start), "a value is missing at the end of the block")
                .help("write the value"))
        }
        _ => {
            let shown = x.s.peek_char().unwrap_or(' ').escape_default();
            Err(Fault::new(codes::SYNTAX, x.s.here(), format!("a value was expected and `{shown}` was found"))
                .help("write a number, a Q parameter, a function or a bracket"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(e: &Expr) -> f64 {
        match e {
            Expr::Number(v) => *v,
            Expr::Unary(f, a) => expression::apply(*f, number(a), Span::default()).unwrap(),
            Expr::Binary(o, a, b) => expression::combine(*o, number(a), number(b), Span::default()).unwrap(),
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
