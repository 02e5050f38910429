//! Formulas of Q parameters: `Q1 = Q2 * SIN 30 + SQRT Q5`.
//!
//! Priorities after the user's manual (HEIDENHAIN, *TNC 640 Klartext programming*, "Entering formulas directly"): a function
//! binds to the operand behind it, then `^`, then `* / %`, then `+ -`; operators of the same priority run from left to right.

use super::lexer::Lexer;
use super::words::Param;
use crate::codes;
use crate::diagnostic::{Fault, Span};

/// Nesting of brackets, signs and functions in one formula.
const MAX_DEPTH: u32 = 60;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expr {
    Number(f64),
    Text(String),
    Param(Param),
    Call(Function, Box<Self>),
    Binary(Operator, Box<Self>, Box<Self>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
    Power,
    /// FN 8: root of the sum of squares.
    Length,
    /// FN 13: angle of opposite and adjacent side.
    Angle,
    /// `||`: texts one behind the other.
    Join,
}

impl Operator {
    fn priority(self) -> u8 {
        match self {
            Self::Power => 3,
            Self::Multiply | Self::Divide | Self::Modulo => 2,
            _ => 1,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Sq,
    Sqrt,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Ln,
    Log,
    Exp,
    Neg,
    Int,
    Abs,
    Frac,
    Sgn,
    ToChar,
}

const FUNCTIONS: [(&str, Function); 17] = [
    ("SQRT", Function::Sqrt),
    ("SQ", Function::Sq),
    ("SIN", Function::Sin),
    ("COS", Function::Cos),
    ("TAN", Function::Tan),
    ("ASIN", Function::Asin),
    ("ACOS", Function::Acos),
    ("ATAN", Function::Atan),
    ("LN", Function::Ln),
    ("LOG", Function::Log),
    ("EXP", Function::Exp),
    ("NEG", Function::Neg),
    ("INT", Function::Int),
    ("ABS", Function::Abs),
    ("FRAC", Function::Frac),
    ("SGN", Function::Sgn),
    ("TOCHAR", Function::ToChar),
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
            (b'%', _) => (Operator::Modulo, 1),
            (b'^', _) => (Operator::Power, 1),
            (b'|', b'|') => (Operator::Join, 2),
            _ => {
                x.set_pos(before);
                return Ok(left);
            }
        };
        if operator.priority() <= lowest {
            x.set_pos(before);
            return Ok(left);
        }
        x.set_pos(x.pos() + length);
        let right = parse(x, operator.priority(), depth + 1)?;
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
                inner => Expr::Call(Function::Neg, Box::new(inner)),
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
                    if function == Function::ToChar {
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
                        return Ok(Expr::Call(function, Box::new(inner)));
                    }
                    Ok(Expr::Call(function, Box::new(operand(x, depth + 1)?)))
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

/// Value of a function; the message of what is wrong.
pub(crate) fn apply(function: Function, v: f64) -> Result<f64, String> {
    use crate::frame::sin_cos_degrees;
    let value = match function {
        Function::Sq => v * v,
        Function::Sqrt if v < 0.0 => return Err(format!("the root of {v} is not real")),
        Function::Sqrt => v.sqrt(),
        Function::Sin => sin_cos_degrees(v).0,
        Function::Cos => sin_cos_degrees(v).1,
        Function::Tan => {
            let (s, c) = sin_cos_degrees(v);
            if c == 0.0 {
                return Err(format!("the tangent of {v} degrees is infinite"));
            }
            s / c
        }
        Function::Asin | Function::Acos if v.abs() > 1.0 => return Err(format!("no angle has the value {v}")),
        Function::Asin => v.asin().to_degrees(),
        Function::Acos => v.acos().to_degrees(),
        Function::Atan => v.atan().to_degrees(),
        Function::Ln | Function::Log if v <= 0.0 => return Err(format!("the logarithm of {v} is not real")),
        Function::Ln => v.ln(),
        Function::Log => v.log10(),
        Function::Exp => v.exp(),
        Function::Neg => -v,
        Function::Int => v.trunc(),
        Function::Abs => v.abs(),
        Function::Frac => v.fract(),
        Function::Sgn => {
            if v == 0.0 {
                0.0
            } else {
                v.signum()
            }
        }
        Function::ToChar => v,
    };
    Ok(value + 0.0)
}

/// Value of an operation; the message of what is wrong.
pub(crate) fn combine(operator: Operator, a: f64, b: f64) -> Result<f64, String> {
    let value = match operator {
        Operator::Add | Operator::Join => a + b,
        Operator::Subtract => a - b,
        Operator::Multiply => a * b,
        Operator::Divide | Operator::Modulo if b == 0.0 => return Err(format!("{a} is divided by zero")),
        Operator::Divide => a / b,
        Operator::Modulo => a % b,
        Operator::Power => a.powf(b),
        Operator::Length => a.hypot(b),
        Operator::Angle => a.atan2(b).to_degrees().rem_euclid(360.0),
    };
    Ok(value + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(e: &Expr) -> f64 {
        match e {
            Expr::Number(v) => *v,
            Expr::Call(f, a) => apply(*f, number(a)).unwrap(),
            Expr::Binary(o, a, b) => combine(*o, number(a), number(b)).unwrap(),
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
