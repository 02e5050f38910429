//! Formulas: one tree for all languages, and the values of its functions and operators. A language
//! keeps the grammar, the names of its functions, its parameters, and what truth and equality are
//! on its control. Angles are in degrees, as on the controls.

use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::sin_cos_degrees;

/// Nesting of brackets, signs, functions and rising priorities in one formula. Operators of one
/// nesting level follow each other in [`Expr::Chain`], so that the depth of a formula is bounded
/// and its length is not.
pub(crate) const MAX_DEPTH: u32 = 60;

/// Bytes of a text.
const MAX_TEXT: usize = 1000;

/// A formula. `P` is a numbered parameter of the language.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expr<P> {
    Number(f64),
    Text(String),
    /// Variable, constant, axis or label.
    Name(String),
    Param(P),
    /// `NAME[i, j]`.
    Element(String, Vec<Self>),
    /// `NAME(a, , b)`.
    Call(String, Vec<Option<Self>>),
    Unary(Function, Box<Self>),
    /// Operands with the operators before them, from left to right. Not a pair of two: a sum of ten thousand
    /// terms would be a tree ten thousand deep, and whoever walks it needs a stack as deep.
    Chain(Box<Self>, Vec<(Operator, Self)>),
}

impl<P> Expr<P> {
    /// One operator between two operands.
    pub(crate) fn pair(operator: Operator, left: Self, right: Self) -> Self {
        Self::Chain(Box::new(left), vec![(operator, right)])
    }
}

/// A parameter whose number is itself a formula: `R[R1+1]`, `#[#2+1]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct IndexedParameter(pub(crate) Box<Expr<Self>>);

impl IndexedParameter {
    pub(crate) fn expr(index: Expr<Self>) -> Expr<Self> {
        Expr::Param(Self(Box::new(index)))
    }
}

/// Functions of one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Negate,
    Not,
    /// Bit by bit, on whole numbers of 32 bits.
    BitNot,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Square,
    Sqrt,
    Exp,
    Ln,
    Log,
    Abs,
    Sign,
    Fraction,
    /// To the nearest whole number, away from zero, towards zero, down and up.
    Round,
    AwayFromZero,
    TowardsZero,
    Down,
    Up,
    /// Decimal digits in four bits each to a number, and back.
    FromDigits,
    ToDigits,
    /// A number as a text.
    Text,
}

/// Operators of two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    /// Whole part of the quotient.
    Div,
    Mod,
    Power,
    /// Root of the sum of squares.
    Length,
    /// Angle of opposite and adjacent side.
    Angle,
    And,
    Or,
    Xor,
    BitAnd,
    BitOr,
    BitXor,
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    /// Concatenates texts.
    Join,
    /// Between frames.
    Chain,
}

/// A calculation without a result.
pub(crate) fn arithmetic(message: impl Into<String>, span: Span) -> Fault {
    Fault::new(codes::ARITHMETIC, span, message).help("check the values of the calculation")
}

/// A text that was put together, refused where it grows without end: doubled forty times it would fill the
/// memory.
pub(crate) fn short_text(text: String, span: Span) -> Result<String, Fault> {
    if text.len() <= MAX_TEXT {
        return Ok(text);
    }
    let message = format!("the text has {} bytes; the limit is {MAX_TEXT}", text.len());
    Err(Fault::new(codes::BAD_VALUE, span, message).help("join fewer texts"))
}

pub(crate) fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

/// Value of a function.
pub(crate) fn apply(function: Function, x: f64, span: Span) -> Result<f64, Fault> {
    let undefined = |what: &str| Err(arithmetic(format!("the {what} of {x} is not defined"), span));
    Ok(match function {
        Function::Negate => -x,
        Function::Not => truth(x == 0.0),
        Function::BitNot => f64::from(!(x as i32)),
        Function::Sin => sin_cos_degrees(x).0,
        Function::Cos => sin_cos_degrees(x).1,
        Function::Tan => match sin_cos_degrees(x) {
            (_, 0.0) => return undefined("tangent"),
            (sin, cos) => sin / cos,
        },
        Function::Asin if x.abs() > 1.0 => return undefined("arc sine"),
        Function::Acos if x.abs() > 1.0 => return undefined("arc cosine"),
        Function::Asin => x.asin().to_degrees(),
        Function::Acos => x.acos().to_degrees(),
        Function::Atan => x.atan().to_degrees(),
        Function::Square => x * x,
        Function::Sqrt if x < 0.0 => return undefined("square root"),
        Function::Sqrt => x.sqrt(),
        Function::Exp => x.exp(),
        Function::Ln | Function::Log if x <= 0.0 => return undefined("logarithm"),
        Function::Ln => x.ln(),
        Function::Log => x.log10(),
        Function::Abs => x.abs(),
        Function::Sign if x == 0.0 => 0.0,
        Function::Sign => x.signum(),
        Function::Fraction => x.fract(),
        Function::Round => x.round(),
        Function::AwayFromZero => x.abs().ceil().copysign(x) + 0.0,
        Function::TowardsZero => x.trunc(),
        Function::Down => x.floor(),
        Function::Up => x.ceil(),
        Function::FromDigits => match from_digits(x) {
            Some(number) => number,
            None => return undefined("number of the decimal digits"),
        },
        Function::ToDigits => match to_digits(x) {
            Some(digits) => digits,
            None => return undefined("form in decimal digits"),
        },
        Function::Text => x,
    })
}

/// Most digits in four bits each.
const DIGITS: u32 = 8;

/// The number whose decimal digits stand in four bits each: 12 of 0x12; none where four bits are no digit.
fn from_digits(x: f64) -> Option<f64> {
    let bits = u64::from(u32::MAX);
    if x.fract() != 0.0 || !(0.0..=bits as f64).contains(&x) {
        return None;
    }
    let bits = x as u64;
    (0..DIGITS)
        .rev()
        .try_fold(0_u64, |number, place| {
            let digit = bits >> (4 * place) & 0xf;
            (digit < 10).then_some(10 * number + digit)
        })
        .map(|number| number as f64)
}

/// The digits of a number in four bits each: 0x12 of 12.
fn to_digits(x: f64) -> Option<f64> {
    if x.fract() != 0.0 || !(0.0..1e8).contains(&x) {
        return None;
    }
    let (mut rest, mut bits, mut place) = (x as u64, 0_u64, 0);
    while rest > 0 {
        bits |= (rest % 10) << place;
        rest /= 10;
        place += 4;
    }
    Some(bits as f64)
}

/// Value of an operation on numbers. Languages in which an operator means something else ask here for the
/// others.
pub(crate) fn combine(operator: Operator, a: f64, b: f64, span: Span) -> Result<f64, Fault> {
    let divides = matches!(operator, Operator::Divide | Operator::Div | Operator::Mod);
    if divides && b == 0.0 {
        return Err(arithmetic(format!("{a} is divided by zero"), span));
    }
    let bits = |of: fn(i32, i32) -> i32| f64::from(of(a as i32, b as i32));
    Ok(match operator {
        Operator::Add => a + b,
        Operator::Subtract => a - b,
        Operator::Multiply => a * b,
        Operator::Divide => a / b,
        Operator::Div => (a / b).trunc(),
        Operator::Mod => a % b,
        Operator::Power => a.powf(b),
        Operator::Length => a.hypot(b),
        Operator::Angle => a.atan2(b).to_degrees(),
        Operator::And => truth(a != 0.0 && b != 0.0),
        Operator::Or => truth(a != 0.0 || b != 0.0),
        Operator::Xor => truth((a != 0.0) != (b != 0.0)),
        Operator::BitAnd => bits(|a, b| a & b),
        Operator::BitOr => bits(|a, b| a | b),
        Operator::BitXor => bits(|a, b| a ^ b),
        Operator::Equal => truth(a == b),
        Operator::NotEqual => truth(a != b),
        Operator::Less => truth(a < b),
        Operator::LessEqual => truth(a <= b),
        Operator::Greater => truth(a > b),
        Operator::GreaterEqual => truth(a >= b),
        // Of texts and frames.
        Operator::Join | Operator::Chain => f64::NAN,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_have_the_values_of_the_trade() {
        let at = |function, x| apply(function, x, Span::default()).unwrap();
        assert_eq!(at(Function::Sin, 30.0), 30f64.to_radians().sin());
        assert_eq!((at(Function::Sin, 180.0), at(Function::Cos, 90.0)), (0.0, 0.0), "right angles are exact");
        assert!((at(Function::Tan, 45.0) - 1.0).abs() < 1e-15);
        for number in [0.0, 7.0, 12.0, 99.0, 12_345_678.0] {
            assert_eq!(at(Function::FromDigits, at(Function::ToDigits, number)), number);
        }
        assert_eq!((at(Function::ToDigits, 12.0), at(Function::FromDigits, 18.0)), (18.0, 12.0));
        for wrong in [10.0, -1.0, 1.5, 1e12] {
            assert!(apply(Function::FromDigits, wrong, Span::default()).is_err(), "{wrong}");
        }
        assert!(apply(Function::ToDigits, 1e8, Span::default()).is_err());
        assert_eq!((at(Function::TowardsZero, -1.5), at(Function::AwayFromZero, -1.5)), (-1.0, -2.0));
        assert_eq!((at(Function::Down, -1.5), at(Function::Up, -1.5)), (-2.0, -1.0));
        assert_eq!((at(Function::Sign, 0.0), at(Function::Sign, -3.0)), (0.0, -1.0));
        assert_eq!(at(Function::Fraction, 1.5), 0.5);
    }

    #[test]
    fn what_has_no_value_is_refused() {
        for (function, x) in [
            (Function::Tan, 90.0),
            (Function::Asin, 1.1),
            (Function::Acos, -1.1),
            (Function::Sqrt, -1.0),
            (Function::Ln, 0.0),
            (Function::Log, -1.0),
        ] {
            let fault = apply(function, x, Span::default()).unwrap_err();
            assert!(fault.code == codes::ARITHMETIC && fault.message.contains(&format!("{x}")), "{fault:?}");
        }
        for operator in [Operator::Divide, Operator::Div, Operator::Mod] {
            assert_eq!(combine(operator, 1.0, 0.0, Span::default()).unwrap_err().code, codes::ARITHMETIC);
        }
    }
}
