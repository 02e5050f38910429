//! Expressions of macro B and RS274/NGC: parameters, brackets, functions.
//!
//! Priorities: `LinuxCNC` (*G-code overview, binary operators*) `**`, then `* / MOD`, `+ -`, comparisons, `AND OR XOR`; Fanuc
//! (*Custom macro B, arithmetic and logic operation*) `* / AND MOD`, then `+ - OR XOR`, comparisons in conditions last. A chain
//! of comparisons without brackets is refused where the control would compare the result of a comparison.

use super::flavor::Flavor;
use crate::channel::expression::{self, Function, Indexed, MAX_DEPTH, Operator};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::scan::Scanner;

/// An expression; a name is that of `#<name>`, lower case without blanks.
pub(crate) type Expr = expression::Expr<Indexed>;

/// Functions, longer names before their beginnings.
const FUNCTIONS: [(&str, Function); 14] = [
    ("SIN", Function::Sin),
    ("COS", Function::Cos),
    ("TAN", Function::Tan),
    ("ASIN", Function::Asin),
    ("ACOS", Function::Acos),
    ("ATAN", Function::Atan),
    ("SQRT", Function::Sqrt),
    ("SQR", Function::Sqrt),
    ("ABS", Function::Abs),
    ("ROUND", Function::Round),
    ("FIX", Function::TowardsZero),
    ("FUP", Function::AwayFromZero),
    ("EXP", Function::Exp),
    ("LN", Function::Ln),
];

/// The function that asks whether a parameter has a value.
pub(crate) const EXISTS: &str = "EXISTS";

const COMPARISON: u8 = 3;

fn priority(operator: Operator, flavor: Flavor) -> u8 {
    match operator {
        Operator::Power => 6,
        Operator::Multiply | Operator::Divide | Operator::Mod => 5,
        Operator::Add | Operator::Subtract => 4,
        Operator::And if !flavor.is_linuxcnc() => 5,
        Operator::Or | Operator::Xor if !flavor.is_linuxcnc() => 4,
        Operator::And | Operator::Or | Operator::Xor => 2,
        _ => COMPARISON,
    }
}

/// Parses a whole expression; the scanner stands behind it afterwards.
pub(crate) fn expression(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    parse(s, flavor, 0, 0)
}

/// One operand, as it may stand behind an address letter: a number, a parameter, a function, a bracket, with its sign.
pub(crate) fn operand(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    operand_at(s, flavor, 0)
}

/// `[expression]`; the scanner stands before the bracket or before blanks.
pub(crate) fn bracket(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    bracket_at(s, flavor, 0)
}

fn parse(s: &mut Scanner<'_>, flavor: Flavor, lowest: u8, depth: u32) -> Result<Expr, Fault> {
    let mut left = operand_at(s, flavor, depth)?;
    let mut compared = false;
    loop {
        let before = s.pos();
        s.skip_blanks();
        let from = s.pos();
        let Some(operator) = operator(s, flavor) else {
            s.set_pos(before);
            return Ok(left);
        };
        let priority = priority(operator, flavor);
        if priority < lowest {
            s.set_pos(before);
            return Ok(left);
        }
        if priority == COMPARISON && std::mem::replace(&mut compared, true) {
            return Err(Fault::new(codes::SYNTAX, s.span_from(from), "comparisons cannot be chained")
                .help("put each comparison into brackets: [#1 GT 0] AND [#2 LT 5]"));
        }
        let right = parse(s, flavor, priority + 1, depth + 1)?;
        left = Expr::Binary(operator, Box::new(left), Box::new(right));
    }
}

/// Takes the operator that is next, if any.
fn operator(s: &mut Scanner<'_>, flavor: Flavor) -> Option<Operator> {
    const WORDS: [(&str, Operator); 10] = [
        ("MOD", Operator::Mod),
        ("AND", Operator::And),
        ("XOR", Operator::Xor),
        ("OR", Operator::Or),
        ("EQ", Operator::Equal),
        ("NE", Operator::NotEqual),
        ("GT", Operator::Greater),
        ("GE", Operator::GreaterEqual),
        ("LT", Operator::Less),
        ("LE", Operator::LessEqual),
    ];
    let (operator, length) = match (s.peek(), s.peek_at(1)) {
        (b'*', b'*') if flavor.is_linuxcnc() => (Operator::Power, 2),
        (b'*', _) => (Operator::Multiply, 1),
        (b'/', _) => (Operator::Divide, 1),
        (b'+', _) => (Operator::Add, 1),
        (b'-', _) => (Operator::Subtract, 1),
        (byte, _) if byte.is_ascii_alphabetic() => {
            let (word, operator) = WORDS.into_iter().find(|(word, _)| next_is(s, word))?;
            (operator, word.len())
        }
        _ => return None,
    };
    s.set_pos(s.pos() + length);
    Some(operator)
}

/// The next letters are this word, in any case. A longer name is not told apart: blanks are free in these languages.
pub(crate) fn next_is(s: &Scanner<'_>, word: &str) -> bool {
    word.bytes().enumerate().all(|(i, byte)| s.peek_at(i).to_ascii_uppercase() == byte)
}

fn operand_at(s: &mut Scanner<'_>, flavor: Flavor, depth: u32) -> Result<Expr, Fault> {
    s.skip_blanks();
    if depth > MAX_DEPTH {
        let message = format!("the expression is nested deeper than {MAX_DEPTH} levels");
        return Err(Fault::new(codes::NESTING_LIMIT, s.here(), message).help("split it with a parameter"));
    }
    match s.peek() {
        b'0'..=b'9' | b'.' => number(s),
        sign @ (b'-' | b'+') => {
            s.bump();
            let inner = operand_at(s, flavor, depth + 1)?;
            Ok(match (sign, inner) {
                (b'+', inner) => inner,
                (_, Expr::Number(value)) => Expr::Number(-value),
                (_, inner) => Expr::Unary(Function::Negate, Box::new(inner)),
            })
        }
        b'[' => bracket_at(s, flavor, depth),
        b'#' => parameter_at(s, flavor, depth),
        byte if byte.is_ascii_alphabetic() => function(s, flavor, depth),
        0 if s.at_end() => {
            Err(Fault::new(codes::MISSING_VALUE, s.here(), "a value is missing at the end of the block")
                .help("write the value"))
        }
        _ => {
            let shown = s.peek_char().unwrap_or(' ');
            Err(Fault::new(codes::SYNTAX, s.here(), format!("a value was expected and `{shown}` was found"))
                .help("write a number, a parameter, a function or a bracket"))
        }
    }
}

fn number(s: &mut Scanner<'_>) -> Result<Expr, Fault> {
    let start = s.pos();
    match s.decimal() {
        Some(value) if value.is_finite() => Ok(Expr::Number(value)),
        _ => Err(Fault::new(codes::SYNTAX, s.span_from(start), "a number was expected").help("write digits")),
    }
}

fn bracket_at(s: &mut Scanner<'_>, flavor: Flavor, depth: u32) -> Result<Expr, Fault> {
    s.skip_blanks();
    let start = s.pos();
    if !s.take(b'[') {
        return Err(Fault::new(codes::SYNTAX, s.here(), "`[` is missing").help("put the expression into brackets"));
    }
    let inner = parse(s, flavor, 0, depth + 1)?;
    close(s, start)?;
    Ok(inner)
}

fn close(s: &mut Scanner<'_>, start: usize) -> Result<(), Fault> {
    s.skip_blanks();
    if s.take(b']') {
        return Ok(());
    }
    Err(Fault::new(codes::SYNTAX, s.span_from(start), "`]` is missing").help("write `]`"))
}

/// `#5`, `#[expression]`, `##5`, `#<name>`; the scanner stands on `#`.
pub(crate) fn parameter(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    parameter_at(s, flavor, 0)
}

fn parameter_at(s: &mut Scanner<'_>, flavor: Flavor, depth: u32) -> Result<Expr, Fault> {
    let start = s.pos();
    s.bump();
    s.skip_blanks();
    if s.peek() == b'<' {
        s.bump();
        let from = s.pos();
        while !s.at_end() && s.peek() != b'>' {
            s.bump();
        }
        let name: String = s.slice(from).chars().filter(|c| !c.is_whitespace()).collect();
        if !s.take(b'>') || name.is_empty() {
            return Err(Fault::new(codes::SYNTAX, s.span_from(start), "the name of the parameter has no end")
                .help("write #<name>"));
        }
        if !flavor.is_linuxcnc() {
            let message = format!("`#<{name}>`: named parameters are not read on a {}", flavor.name());
            return Err(Fault::new(codes::UNSUPPORTED_WORD, s.span_from(start), message)
                .help("use a number, or name the dialect linuxcnc"));
        }
        return Ok(Expr::Name(name.to_ascii_lowercase()));
    }
    Ok(Indexed::expr(operand_at(s, flavor, depth + 1)?))
}

fn function(s: &mut Scanner<'_>, flavor: Flavor, depth: u32) -> Result<Expr, Fault> {
    let start = s.pos();
    if next_is(s, EXISTS) && flavor.is_linuxcnc() {
        s.set_pos(start + EXISTS.len());
        return Ok(Expr::Call(EXISTS.to_owned(), vec![Some(bracket_at(s, flavor, depth + 1)?)]));
    }
    // SQRT before SQR, ATAN before nothing shorter: the table is in the order of the longest name.
    let found = FUNCTIONS.into_iter().find(|(name, _)| next_is(s, name));
    let Some((name, function)) = found else {
        let word = s.identifier().to_owned();
        let message = format!("`{word}` is no function of the {} reader", flavor.name());
        return Err(Fault::new(codes::UNKNOWN_WORD, s.span_from(start), message)
            .help("see the coverage table for the functions that are read"));
    };
    s.set_pos(start + name.len());
    s.skip_blanks();
    // LinuxCNC rounds towards minus and plus infinity, macro B towards and away from zero.
    let function = match function {
        Function::Atan => return atan(s, flavor, depth),
        Function::TowardsZero if flavor.is_linuxcnc() => Function::Down,
        Function::AwayFromZero if flavor.is_linuxcnc() => Function::Up,
        function => function,
    };
    Ok(Expr::Unary(function, Box::new(bracket_at(s, flavor, depth + 1)?)))
}

/// `ATAN[y]/[x]`, on a Fanuc also `ATAN[y,x]` and `ATAN[t]`.
fn atan(s: &mut Scanner<'_>, flavor: Flavor, depth: u32) -> Result<Expr, Fault> {
    let start = s.pos();
    if !s.take(b'[') {
        return Err(Fault::new(codes::SYNTAX, s.here(), "`[` is missing").help("write ATAN[y]/[x]"));
    }
    let y = parse(s, flavor, 0, depth + 1)?;
    s.skip_blanks();
    if s.take(b',') {
        let x = parse(s, flavor, 0, depth + 1)?;
        close(s, start)?;
        return Ok(Expr::Binary(Operator::Angle, Box::new(y), Box::new(x)));
    }
    close(s, start)?;
    s.skip_blanks();
    let before = s.pos();
    if s.take(b'/') {
        s.skip_blanks();
        if s.peek() == b'[' {
            let x = bracket_at(s, flavor, depth + 1)?;
            return Ok(Expr::Binary(Operator::Angle, Box::new(y), Box::new(x)));
        }
        s.set_pos(before);
    }
    if flavor.is_linuxcnc() {
        return Err(
            Fault::new(codes::SYNTAX, Span::new(start, s.pos()), "ATAN needs two values").help("write ATAN[y]/[x]")
        );
    }
    Ok(Expr::Unary(Function::Atan, Box::new(y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(text: &str, flavor: Flavor) -> String {
        fn show(e: &Expr) -> String {
            match e {
                Expr::Number(v) => v.to_string(),
                Expr::Param(p) => format!("#{}", show(&p.0)),
                Expr::Unary(u, a) => format!("({u:?} {})", show(a)),
                Expr::Binary(b, l, r) => format!("({b:?} {} {})", show(l), show(r)),
                other => format!("{other:?}"),
            }
        }
        show(&expression(&mut Scanner::new(text), flavor).unwrap())
    }

    #[test]
    fn priorities_follow_the_manuals() {
        let (l, f) = (Flavor::LinuxCnc, Flavor::Fanuc);
        assert_eq!(shape("2+3*4**2", l), "(Add 2 (Multiply 3 (Power 4 2)))");
        assert_eq!(shape("1-2-3", l), "(Subtract (Subtract 1 2) 3)");
        assert_eq!(shape("#1 GT 0 AND #2 LT 5", l), "(And (Greater #1 0) (Less #2 5))");
        assert_eq!(shape("1+2AND3", f), "(Add 1 (And 2 3))");
        assert_eq!(shape("#1+#[2*3]", f), "(Add #1 #(Multiply 2 3))");
        assert_eq!(shape("##3", f), "##3");
        assert_eq!(shape("-#1*2", f), "(Multiply (Negate #1) 2)");
        assert_eq!(shape("2--3", f), "(Subtract 2 -3)");
        assert_eq!(shape("sqrt[4]*SIN[30]", l), "(Multiply (Sqrt 4) (Sin 30))");
    }

    #[test]
    fn chains_and_deep_nesting_are_refused() {
        let parse = |text: &str| expression(&mut Scanner::new(text), Flavor::Fanuc).unwrap_err().code;
        assert_eq!(parse("#1 EQ 1 EQ 2"), codes::SYNTAX);
        assert_eq!(parse(&format!("{}1", "[".repeat(5000))), codes::NESTING_LIMIT);
        assert_eq!(parse(&format!("{}1", "#".repeat(5000))), codes::NESTING_LIMIT);
        assert_eq!(parse(&format!("{}1", "-".repeat(5000))), codes::NESTING_LIMIT);
    }
}
