//! Expressions of macro B and RS274/NGC: parameters, brackets, functions.
//!
//! Priorities: `LinuxCNC` (*G-code overview, binary operators*) `**`, then `* / MOD`, `+ -`, comparisons,
//! `AND OR XOR`; Fanuc (*Custom macro B, arithmetic and logic operation*) `* / AND MOD`, then `+ - OR XOR`,
//! comparisons in conditions last. A chain of comparisons without brackets is refused where the control would
//! compare the result of a comparison.

use super::flavor::Flavor;
use super::osp;
use crate::channel::expression::{self, Function, IndexedParameter, Operator};
use crate::channel::formula::{self, Formulas, Grammar};
use crate::codes;
use crate::diagnostic::Fault;
use crate::scan::Scanner;

/// An expression; a name is that of `#<name>`, lower case without blanks.
pub(crate) type Expr = expression::Expr<IndexedParameter>;

/// Functions, longer names before their beginnings.
const FUNCTIONS: [(&str, Function); 16] = [
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
    ("BIN", Function::FromDigits),
    ("BCD", Function::ToDigits),
];

/// The function that asks whether a parameter has a value.
pub(crate) const EXISTS: &str = "EXISTS";

const COMPARISON: u8 = 3;

static MACRO_B: Grammar = Grammar {
    operators: &[
        ("*", Operator::Multiply, 5),
        ("/", Operator::Divide, 5),
        ("MOD", Operator::Mod, 5),
        ("AND", Operator::And, 5),
        ("+", Operator::Add, 4),
        ("-", Operator::Subtract, 4),
        ("XOR", Operator::Xor, 4),
        ("OR", Operator::Or, 4),
        ("EQ", Operator::Equal, COMPARISON),
        ("NE", Operator::NotEqual, COMPARISON),
        ("GT", Operator::Greater, COMPARISON),
        ("GE", Operator::GreaterEqual, COMPARISON),
        ("LT", Operator::Less, COMPARISON),
        ("LE", Operator::LessEqual, COMPARISON),
    ],
    whole_words: false,
    comparison: Some((COMPARISON, "put each comparison into brackets: [#1 GT 0] AND [#2 LT 5]")),
    sign: u8::MAX,
    brackets: *b"[]",
    name: "expression",
    split_with: "a parameter",
    operands: "write a number, a parameter, a function or a bracket",
};

static LINUXCNC: Grammar = Grammar {
    operators: &[
        ("**", Operator::Power, 6),
        ("*", Operator::Multiply, 5),
        ("/", Operator::Divide, 5),
        ("MOD", Operator::Mod, 5),
        ("+", Operator::Add, 4),
        ("-", Operator::Subtract, 4),
        ("EQ", Operator::Equal, COMPARISON),
        ("NE", Operator::NotEqual, COMPARISON),
        ("GT", Operator::Greater, COMPARISON),
        ("GE", Operator::GreaterEqual, COMPARISON),
        ("LT", Operator::Less, COMPARISON),
        ("LE", Operator::LessEqual, COMPARISON),
        ("AND", Operator::And, 2),
        ("XOR", Operator::Xor, 2),
        ("OR", Operator::Or, 2),
    ],
    ..MACRO_B
};

/// Text of a control.
struct ExprText<'s, 'a> {
    s: &'s mut Scanner<'a>,
    flavor: Flavor,
}

impl<'a> Formulas<'a> for ExprText<'_, 'a> {
    type Param = IndexedParameter;

    fn grammar(&self) -> &'static Grammar {
        if self.flavor.is_linuxcnc() { &LINUXCNC } else { &MACRO_B }
    }

    fn scanner(&mut self) -> &mut Scanner<'a> {
        self.s
    }

    fn number(&mut self) -> Result<f64, Fault> {
        let start = self.s.pos();
        self.s.decimal().filter(|value| value.is_finite()).ok_or_else(|| {
            Fault::new(codes::SYNTAX, self.s.span_from(start), "a number was expected").help("write digits")
        })
    }

    fn other_operand(&mut self, depth: u32) -> Result<Option<Expr>, Fault> {
        match self.s.peek() {
            b'#' => parameter_at(self, depth).map(Some),
            b'V' | b'v' if osp::variable_is_next(self.s, self.flavor) => osp::variable(self.s).map(Some),
            byte if byte.is_ascii_alphabetic() => function(self, depth).map(Some),
            _ => Ok(None),
        }
    }
}

/// Parses a whole expression; leaves the scanner after it.
pub(crate) fn expression(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    formula::formula(&mut ExprText { s, flavor }, 0)
}

/// One operand, as it may follow an address letter: a number, a parameter, a function, a bracket,
/// with its sign.
pub(crate) fn operand(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    formula::operand(&mut ExprText { s, flavor }, 0)
}

/// `[expression]`; the scanner is before the bracket or before blanks.
pub(crate) fn bracket(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    formula::bracket(&mut ExprText { s, flavor }, 0)
}

/// The next letters are this word, in any case. A longer name that begins with it matches too:
/// blanks are optional in these languages.
pub(crate) fn next_is(s: &Scanner<'_>, word: &str) -> bool {
    word.bytes().enumerate().all(|(i, byte)| s.peek_at(i).to_ascii_uppercase() == byte)
}

/// `#5`, `#[expression]`, `##5`, `#<name>`; the scanner is at `#`.
pub(crate) fn parameter(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    parameter_at(&mut ExprText { s, flavor }, 0)
}

fn parameter_at(text: &mut ExprText<'_, '_>, depth: u32) -> Result<Expr, Fault> {
    let (s, flavor) = (&mut *text.s, text.flavor);
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
    Ok(IndexedParameter::expr(formula::operand(text, depth + 1)?))
}

fn function(text: &mut ExprText<'_, '_>, depth: u32) -> Result<Expr, Fault> {
    let (s, flavor) = (&mut *text.s, text.flavor);
    let start = s.pos();
    if next_is(s, EXISTS) && flavor.is_linuxcnc() {
        s.set_pos(start + EXISTS.len());
        return Ok(Expr::Call(EXISTS.to_owned(), vec![Some(formula::bracket(text, depth + 1)?)]));
    }
    // SQRT before SQR, ATAN before nothing shorter: the table is in the order of the longest name.
    let known =
        |function: Function| !flavor.is_linuxcnc() || !matches!(function, Function::FromDigits | Function::ToDigits);
    let found = FUNCTIONS.into_iter().find(|(name, function)| known(*function) && next_is(s, name));
    let Some((name, function)) = found else {
        let word = s.identifier().to_owned();
        // A local variable of an Okuma; the reader of another control refuses it where it is read.
        if !flavor.is_linuxcnc()
            && (2..=4).contains(&word.len())
            && word.bytes().take(2).all(|b| b.is_ascii_alphabetic())
        {
            return Ok(Expr::Name(word.to_ascii_uppercase()));
        }
        let message = format!("`{word}` is not a function of the {} reader", flavor.name());
        return Err(Fault::new(codes::UNKNOWN_WORD, s.span_from(start), message)
            .help("see the coverage table for the functions that are read"));
    };
    s.set_pos(start + name.len());
    s.skip_blanks();
    // LinuxCNC rounds towards minus and plus infinity, macro B towards and away from zero.
    let function = match function {
        Function::Atan => return atan(text, depth),
        Function::TowardsZero if flavor.is_linuxcnc() => Function::Down,
        Function::AwayFromZero if flavor.is_linuxcnc() => Function::Up,
        function => function,
    };
    Ok(Expr::Unary(function, Box::new(formula::bracket(text, depth + 1)?)))
}

/// `ATAN[y]/[x]`, on a Fanuc also `ATAN[y,x]` and `ATAN[t]`.
fn atan(text: &mut ExprText<'_, '_>, depth: u32) -> Result<Expr, Fault> {
    let s = &mut *text.s;
    let start = s.pos();
    if !s.take(b'[') {
        return Err(Fault::new(codes::SYNTAX, s.here(), "`[` is missing").help("write ATAN[y]/[x]"));
    }
    let y = formula::formula(text, depth + 1)?;
    text.blanks();
    if text.s.take(b',') {
        let x = formula::formula(text, depth + 1)?;
        formula::close(text, b']', start)?;
        return Ok(Expr::pair(Operator::Angle, y, x));
    }
    formula::close(text, b']', start)?;
    text.blanks();
    let before = text.s.pos();
    if text.s.take(b'/') {
        text.blanks();
        if text.s.peek() == b'[' {
            let x = formula::bracket(text, depth + 1)?;
            return Ok(Expr::pair(Operator::Angle, y, x));
        }
        text.s.set_pos(before);
    }
    if text.flavor.is_linuxcnc() {
        return Err(
            Fault::new(codes::SYNTAX, text.s.span_from(start), "ATAN needs two values").help("write ATAN[y]/[x]")
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
                Expr::Chain(first, rest) => {
                    rest.iter().fold(show(first), |left, (o, right)| format!("({o:?} {left} {})", show(right)))
                }
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
