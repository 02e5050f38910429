//! Expressions of the 840D language: Pratt parser.
//!
//! Priorities as in the programming manual (Siemens, *NC programming*, "Priority of the operations"): NOT and sign bind
//! strongest, then `* / DIV MOD`, `+ -`, `B_AND`, `B_XOR`, `B_OR`, `AND`, `XOR`, `OR`, `<<`, and the comparisons last.
//! A chain of comparisons, which `IF R1==1 AND R2==2` is under these rules, is refused: it is never what was meant.

use crate::channel::expression::{self, Function, Indexed, MAX_DEPTH, Operator};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::scan::Scanner;

/// An expression of the 840D language.
pub(crate) type Expr = expression::Expr<Indexed>;

fn priority(operator: Operator) -> u8 {
    match operator {
        Operator::Chain => 11,
        Operator::Multiply | Operator::Divide | Operator::Div | Operator::Mod => MULTIPLY,
        Operator::Add | Operator::Subtract => 9,
        Operator::BitAnd => 8,
        Operator::BitXor => 7,
        Operator::BitOr => 6,
        Operator::And => 5,
        Operator::Xor => 4,
        Operator::Or => 3,
        Operator::Join => 2,
        _ => COMPARISON,
    }
}

const MULTIPLY: u8 = 10;
const COMPARISON: u8 = 1;

/// Parses an expression; the scanner stands behind it afterwards.
pub(crate) fn expression(s: &mut Scanner<'_>) -> Result<Expr, Fault> {
    parse(s, 0, 0)
}

fn parse(s: &mut Scanner<'_>, lowest: u8, depth: u32) -> Result<Expr, Fault> {
    let mut left = operand(s, depth)?;
    let mut compared = false;
    loop {
        let before = s.pos();
        s.skip_blanks();
        let from = s.pos();
        let Some(operator) = operator(s) else {
            s.set_pos(before);
            return Ok(left);
        };
        let priority = priority(operator);
        if priority < lowest {
            s.set_pos(before);
            return Ok(left);
        }
        if priority == COMPARISON && std::mem::replace(&mut compared, true) {
            return Err(Fault::new(codes::SYNTAX, s.span_from(from), "comparisons cannot be chained")
                .help("comparisons bind weaker than AND and OR on this control: put each one into brackets"));
        }
        let right = parse(s, priority + 1, depth + 1)?;
        left = Expr::Binary(operator, Box::new(left), Box::new(right));
    }
}

/// Takes the operator that is next, if any.
fn operator(s: &mut Scanner<'_>) -> Option<Operator> {
    let (operator, length) = match (s.peek(), s.peek_at(1)) {
        (b'+', _) => (Operator::Add, 1),
        (b'-', _) => (Operator::Subtract, 1),
        (b':', b) if b != b'=' => (Operator::Chain, 1),
        (b'*', _) => (Operator::Multiply, 1),
        (b'/', _) => (Operator::Divide, 1),
        (b'=', b'=') => (Operator::Equal, 2),
        (b'<', b'>') => (Operator::NotEqual, 2),
        (b'<', b'=') => (Operator::LessEqual, 2),
        (b'>', b'=') => (Operator::GreaterEqual, 2),
        (b'<', b'<') => (Operator::Join, 2),
        (b'<', _) => (Operator::Less, 1),
        (b'>', _) => (Operator::Greater, 1),
        (b'A'..=b'Z' | b'a'..=b'z', _) => {
            let start = s.pos();
            let word = s.identifier();
            let found = [
                ("DIV", Operator::Div),
                ("MOD", Operator::Mod),
                ("AND", Operator::And),
                ("OR", Operator::Or),
                ("XOR", Operator::Xor),
                ("B_AND", Operator::BitAnd),
                ("B_OR", Operator::BitOr),
                ("B_XOR", Operator::BitXor),
            ]
            .into_iter()
            .find(|(name, _)| name.eq_ignore_ascii_case(word));
            if found.is_none() {
                s.set_pos(start);
            }
            return found.map(|(_, operator)| operator);
        }
        _ => return None,
    };
    s.set_pos(s.pos() + length);
    Some(operator)
}

fn operand(s: &mut Scanner<'_>, depth: u32) -> Result<Expr, Fault> {
    s.skip_blanks();
    let start = s.pos();
    if depth > MAX_DEPTH {
        let message = format!("the expression is nested deeper than {MAX_DEPTH} levels");
        return Err(Fault::new(codes::NESTING_LIMIT, s.here(), message).help("split it with a variable"));
    }
    match s.peek() {
        b'0'..=b'9' | b'.' => number(s),
        b'-' | b'+' => {
            let minus = s.take(b'-');
            s.take(b'+');
            // The sign of a literal belongs to the literal, so that -0.5 is a number and not an operation.
            match parse(s, MULTIPLY + 1, depth + 1)? {
                inner if !minus => Ok(inner),
                Expr::Number(value) => Ok(Expr::Number(-value)),
                inner => Ok(Expr::Unary(Function::Negate, Box::new(inner))),
            }
        }
        b'(' => {
            s.bump();
            let inner = parse(s, 0, depth + 1)?;
            close(s, b')', start)?;
            Ok(inner)
        }
        b'"' => string(s).map(Expr::Text),
        b'\'' => based_integer(s),
        b'A'..=b'Z' | b'a'..=b'z' | b'_' | b'$' => named(s, depth),
        0 => {
            Err(Fault::new(codes::MISSING_VALUE, Span::new(start, start), "a value is missing at the end of the block")
                .help("write the value"))
        }
        _ => {
            let shown = s.peek_char().unwrap_or(' ');
            Err(Fault::new(codes::SYNTAX, s.here(), format!("a value was expected and `{shown}` was found"))
                .help("write a number, a variable, a function or a bracket"))
        }
    }
}

/// Number with the exponent form `1.5EX-3`.
pub(crate) fn number(s: &mut Scanner<'_>) -> Result<Expr, Fault> {
    let start = s.pos();
    let Some(mut value) = s.decimal() else {
        return Err(Fault::new(codes::SYNTAX, s.here(), "a number was expected").help("write digits"));
    };
    if matches!(s.peek(), b'E' | b'e') && matches!(s.peek_at(1), b'X' | b'x') {
        s.set_pos(s.pos() + 2);
        let from = s.pos();
        let exponent = s.decimal().filter(|e| e.fract() == 0.0 && e.abs() <= 308.0).ok_or_else(|| {
            Fault::new(codes::BAD_VALUE, s.span_from(start), "the exponent must be an integer from -308 to 308")
                .help("write for example 1.5EX-3")
        })?;
        debug_assert!(s.pos() > from);
        value *= 10f64.powi(exponent as i32);
    }
    if !value.is_finite() {
        return Err(
            Fault::new(codes::BAD_VALUE, s.span_from(start), "the number is too large").help("use fewer digits")
        );
    }
    Ok(Expr::Number(value))
}

/// `'H1F'` and `'B101'`.
fn based_integer(s: &mut Scanner<'_>) -> Result<Expr, Fault> {
    let start = s.pos();
    s.bump();
    let word = s.identifier();
    let radix = match word.bytes().next() {
        Some(b'H' | b'h') => 16,
        Some(b'B' | b'b') => 2,
        _ => 10,
    };
    let value = word.get(1..).and_then(|digits| u32::from_str_radix(digits, radix).ok()).filter(|_| radix != 10);
    match value {
        Some(value) if s.take(b'\'') => Ok(Expr::Number(f64::from(value))),
        _ => Err(Fault::new(codes::SYNTAX, s.span_from(start), "not a hexadecimal or binary number")
            .help("write 'H1F' or 'B101'")),
    }
}

fn string(s: &mut Scanner<'_>) -> Result<String, Fault> {
    let start = s.pos();
    s.bump();
    let from = s.pos();
    while !s.at_end() && s.peek() != b'"' {
        s.bump();
    }
    let text = s.slice(from).to_owned();
    if s.take(b'"') {
        Ok(text)
    } else {
        Err(Fault::new(codes::SYNTAX, s.span_from(start), "the text has no closing quotation mark")
            .help("write \" at its end"))
    }
}

fn named(s: &mut Scanner<'_>, depth: u32) -> Result<Expr, Fault> {
    let start = s.pos();
    if matches!(s.peek(), b'R' | b'r') {
        if s.peek_at(1).is_ascii_digit() {
            s.bump();
            let index = s.integer().ok_or_else(|| {
                Fault::new(codes::BAD_VALUE, s.span_from(start), "the R parameter number is too large")
                    .help("use R0 to R999999999")
            })?;
            return Ok(Indexed::expr(Expr::Number(f64::from(index))));
        }
        if s.peek_at(1) == b'[' {
            s.set_pos(s.pos() + 2);
            let index = parse(s, 0, depth + 1)?;
            close(s, b']', start)?;
            return Ok(Indexed::expr(index));
        }
    }
    let name = s.identifier().to_ascii_uppercase();
    if name == "NOT" || name == "B_NOT" {
        let function = if name == "NOT" { Function::Not } else { Function::BitNot };
        return Ok(Expr::Unary(function, Box::new(parse(s, MULTIPLY + 1, depth + 1)?)));
    }
    let after = s.pos();
    s.skip_blanks();
    match s.peek() {
        b'[' => {
            let indices = indices(s, depth + 1)?;
            Ok(Expr::Element(name, indices))
        }
        b'(' => Ok(Expr::Call(name, arguments_at(s, depth + 1)?)),
        _ => {
            s.set_pos(after);
            Ok(Expr::Name(name))
        }
    }
}

/// `[a, b]`; the scanner stands on the bracket.
pub(crate) fn indices(s: &mut Scanner<'_>, depth: u32) -> Result<Vec<Expr>, Fault> {
    let start = s.pos();
    s.bump();
    let mut list = Vec::new();
    loop {
        list.push(parse(s, 0, depth)?);
        s.skip_blanks();
        if !s.take(b',') {
            close(s, b']', start)?;
            return Ok(list);
        }
    }
}

/// `(a, , b)`; the scanner stands on the bracket. An argument left out is none.
pub(crate) fn arguments(s: &mut Scanner<'_>) -> Result<Vec<Option<Expr>>, Fault> {
    arguments_at(s, 0)
}

fn arguments_at(s: &mut Scanner<'_>, depth: u32) -> Result<Vec<Option<Expr>>, Fault> {
    let start = s.pos();
    s.bump();
    let mut list = Vec::new();
    s.skip_blanks();
    if s.take(b')') {
        return Ok(list);
    }
    loop {
        s.skip_blanks();
        let argument = if matches!(s.peek(), b',' | b')') { None } else { Some(parse(s, 0, depth)?) };
        list.push(argument);
        s.skip_blanks();
        if !s.take(b',') {
            close(s, b')', start)?;
            return Ok(list);
        }
    }
}

pub(crate) fn close(s: &mut Scanner<'_>, bracket: u8, start: usize) -> Result<(), Fault> {
    s.skip_blanks();
    if s.take(bracket) {
        return Ok(());
    }
    let bracket = char::from(bracket);
    Err(Fault::new(codes::SYNTAX, s.span_from(start), format!("`{bracket}` is missing"))
        .help(format!("write `{bracket}`")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(text: &str) -> String {
        fn show(e: &Expr) -> String {
            match e {
                Expr::Number(v) => v.to_string(),
                Expr::Name(n) => n.clone(),
                Expr::Param(p) => format!("R{}", show(&p.0)),
                Expr::Unary(u, a) => format!("({u:?} {})", show(a)),
                Expr::Binary(b, l, r) => format!("({b:?} {} {})", show(l), show(r)),
                other => format!("{other:?}"),
            }
        }
        show(&expression(&mut Scanner::new(text)).unwrap())
    }

    #[test]
    fn priorities_follow_the_manual() {
        assert_eq!(shape("1+2*3"), "(Add 1 (Multiply 2 3))");
        assert_eq!(shape("1-2-3"), "(Subtract (Subtract 1 2) 3)");
        assert_eq!(shape("-R1*2"), "(Multiply (Negate R1) 2)");
        assert_eq!(shape("(R1==1) AND NOT (R2>2)"), "(And (Equal R1 1) (Not (Greater R2 2)))");
        assert_eq!(shape("a or b and c"), "(Or A (And B C))");
        assert_eq!(shape("7 div 2 Y5"), "(Div 7 2)");
        assert_eq!(shape("2--3"), "(Subtract 2 -3)");
    }

    #[test]
    fn chained_comparison_is_refused() {
        let fault = expression(&mut Scanner::new("R1==1 AND R2==2")).unwrap_err();
        assert_eq!(fault.code, codes::SYNTAX);
    }

    #[test]
    fn deep_nesting_is_refused() {
        let text = format!("{}1", "(".repeat(5000));
        assert_eq!(expression(&mut Scanner::new(&text)).unwrap_err().code, codes::NESTING_LIMIT);
        let text = "-".repeat(5000);
        assert_eq!(expression(&mut Scanner::new(&text)).unwrap_err().code, codes::NESTING_LIMIT);
    }
}
