//! Expressions of the 840D language: Pratt parser.
//!
//! Priorities as in the programming manual (Siemens, *NC programming*, "Priority of the operations"): NOT and
//! sign bind strongest, then `* / DIV MOD`, `+ -`, `B_AND`, `B_XOR`, `B_OR`, `AND`, `XOR`, `OR`, `<<`, and
//! the comparisons last. A chain of comparisons, which `IF R1==1 AND R2==2` is under these rules, is refused:
//! it is never intended.

use crate::channel::expression::{self, Function, IndexedParameter, Operator};
use crate::channel::formula::{self, Formulas, Grammar};
use crate::codes;
use crate::diagnostic::Fault;
use crate::scan::Scanner;

pub(crate) use crate::channel::formula::close;

/// An expression of the 840D language.
pub(crate) type Expr = expression::Expr<IndexedParameter>;

const MULTIPLY: u8 = 10;
const COMPARISON: u8 = 1;

static GRAMMAR: Grammar = Grammar {
    operators: &[
        (":", Operator::Chain, 11),
        ("*", Operator::Multiply, MULTIPLY),
        ("/", Operator::Divide, MULTIPLY),
        ("DIV", Operator::Div, MULTIPLY),
        ("MOD", Operator::Mod, MULTIPLY),
        ("+", Operator::Add, 9),
        ("-", Operator::Subtract, 9),
        ("B_AND", Operator::BitAnd, 8),
        ("B_XOR", Operator::BitXor, 7),
        ("B_OR", Operator::BitOr, 6),
        ("AND", Operator::And, 5),
        ("XOR", Operator::Xor, 4),
        ("OR", Operator::Or, 3),
        ("<<", Operator::Join, 2),
        ("==", Operator::Equal, COMPARISON),
        ("<>", Operator::NotEqual, COMPARISON),
        ("<=", Operator::LessEqual, COMPARISON),
        (">=", Operator::GreaterEqual, COMPARISON),
        ("<", Operator::Less, COMPARISON),
        (">", Operator::Greater, COMPARISON),
    ],
    whole_words: true,
    comparison: Some((
        COMPARISON,
        "comparisons bind weaker than AND and OR on this control: put each one into brackets",
    )),
    sign: MULTIPLY + 1,
    brackets: *b"()",
    name: "expression",
    split_with: "a variable",
    operands: "write a number, a variable, a function or a bracket",
};

impl<'a> Formulas<'a> for Scanner<'a> {
    type Param = IndexedParameter;

    fn grammar(&self) -> &'static Grammar {
        &GRAMMAR
    }

    fn scanner(&mut self) -> &mut Self {
        self
    }

    fn number(&mut self) -> Result<f64, Fault> {
        number(self)
    }

    fn other_operand(&mut self, depth: u32) -> Result<Option<Expr>, Fault> {
        Ok(Some(match self.peek() {
            b'"' => Expr::Text(string(self)?),
            b'\'' => based_integer(self)?,
            b'A'..=b'Z' | b'a'..=b'z' | b'_' | b'$' => named(self, depth)?,
            _ => return Ok(None),
        }))
    }
}

/// Parses an expression and leaves the scanner after it.
pub(crate) fn expression(s: &mut Scanner<'_>) -> Result<Expr, Fault> {
    formula::formula(s, 0)
}

/// Number with the exponent form `1.5EX-3`.
pub(crate) fn number(s: &mut Scanner<'_>) -> Result<f64, Fault> {
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
    Ok(value)
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
            return Ok(IndexedParameter::expr(Expr::Number(f64::from(index))));
        }
        if s.peek_at(1) == b'[' {
            s.set_pos(s.pos() + 2);
            let index = formula::formula(s, depth + 1)?;
            close(s, b']', start)?;
            return Ok(IndexedParameter::expr(index));
        }
    }
    let name = s.identifier().to_ascii_uppercase();
    if name == "NOT" || name == "B_NOT" {
        let function = if name == "NOT" { Function::Not } else { Function::BitNot };
        return Ok(Expr::Unary(function, Box::new(formula::parse(s, MULTIPLY + 1, depth + 1)?)));
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

/// `[a, b]`; the scanner is at the bracket.
pub(crate) fn indices(s: &mut Scanner<'_>, depth: u32) -> Result<Vec<Expr>, Fault> {
    let start = s.pos();
    s.bump();
    let mut list = Vec::new();
    loop {
        list.push(formula::formula(s, depth)?);
        s.skip_blanks();
        if !s.take(b',') {
            close(s, b']', start)?;
            return Ok(list);
        }
    }
}

/// `(a, , b)`; the scanner is at the bracket. An omitted argument is none.
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
        let argument = if matches!(s.peek(), b',' | b')') { None } else { Some(formula::formula(s, depth)?) };
        list.push(argument);
        s.skip_blanks();
        if !s.take(b',') {
            close(s, b')', start)?;
            return Ok(list);
        }
    }
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
                Expr::Chain(first, rest) => {
                    rest.iter().fold(show(first), |left, (o, right)| format!("({o:?} {left} {})", show(right)))
                }
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
