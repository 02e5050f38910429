//! Variables and the values of expressions. Angles in degrees, as on the control.

use std::collections::BTreeMap;

use super::expr::{Binary, Expr, Unary};
use super::parser::Type;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::sin_cos_degrees;

/// Two numbers that differ by less than this, relative to the larger, are equal: the control compares relatively too.
const RELATIVE_EQUALITY: f64 = 1e-12;
/// Longest text that `<<` builds, in bytes.
const MAX_TEXT: usize = 1000;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Val {
    Number(f64),
    Text(String),
}

/// A variable or array of a program.
#[derive(Clone, Debug)]
pub(crate) struct Variable {
    pub(crate) kind: Type,
    sizes: Vec<usize>,
    values: Vec<Val>,
}

/// All variables of a run.
#[derive(Debug)]
pub(crate) struct Variables {
    params: BTreeMap<u32, f64>,
    /// Values given by the settings and by nobody else.
    given: BTreeMap<String, f64>,
    /// Local variables, one map for each call level; those of the main program are seen from subprograms.
    levels: Vec<BTreeMap<String, Variable>>,
    /// System variables with the values that they have before the line in work.
    system: BTreeMap<String, f64>,
    elements: usize,
    max_elements: usize,
}

impl Variables {
    pub(crate) fn new(given: &BTreeMap<String, f64>, max_elements: usize) -> Self {
        let mut params = BTreeMap::new();
        let mut names = BTreeMap::new();
        for (name, &value) in given {
            let name = name.to_ascii_uppercase();
            match name.strip_prefix('R').and_then(|n| n.parse::<u32>().ok()) {
                Some(number) => {
                    params.insert(number, value);
                }
                None => {
                    names.insert(name, value);
                }
            }
        }
        Self { params, given: names, levels: vec![BTreeMap::new()], system: BTreeMap::new(), elements: 0, max_elements }
    }

    /// Values of system variables by name and indices.
    pub(crate) fn set_system(&mut self, values: Vec<(String, f64)>) {
        self.system = values.into_iter().collect();
    }

    pub(crate) fn enter(&mut self) {
        self.levels.push(BTreeMap::new());
    }

    /// Leaves a call level and hands its variables out.
    pub(crate) fn leave(&mut self) -> BTreeMap<String, Variable> {
        let level = self.levels.pop().unwrap_or_default();
        self.elements = self.elements.saturating_sub(level.values().map(|v| v.values.len()).sum());
        level
    }

    pub(crate) fn define(&mut self, name: &str, kind: Type, sizes: Vec<usize>, span: Span) -> Result<(), Fault> {
        let count = sizes.iter().try_fold(1usize, |product, &size| product.checked_mul(size)).unwrap_or(usize::MAX);
        let free = self.max_elements.saturating_sub(self.elements);
        if count > free {
            let message = format!("`{name}` has {count} elements; {free} of {} are left", self.max_elements);
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("define a smaller array"));
        }
        let initial = if kind == Type::Text { Val::Text(String::new()) } else { Val::Number(0.0) };
        let variable = Variable { kind, sizes, values: vec![initial; count] };
        let level = self.levels.last_mut();
        if let Some(old) = level.and_then(|level| level.insert(name.to_owned(), variable)) {
            self.elements -= old.values.len();
        }
        self.elements += count;
        Ok(())
    }

    fn find(&self, name: &str) -> Option<&Variable> {
        self.levels.last()?.get(name).or_else(|| self.levels.first()?.get(name))
    }

    /// Assigns to a variable; false when no variable has this name.
    pub(crate) fn assign(&mut self, name: &str, indices: &[usize], value: Val, span: Span) -> Result<bool, Fault> {
        let level = match self.levels.last() {
            Some(level) if level.contains_key(name) => self.levels.len() - 1,
            _ => 0,
        };
        let Some(variable) = self.levels.get_mut(level).and_then(|level| level.get_mut(name)) else {
            if let (Some(given), Val::Number(number), []) = (self.given.get_mut(name), &value, indices) {
                *given = *number;
                return Ok(true);
            }
            return Ok(false);
        };
        let at = position(name, &variable.sizes, indices, span)?;
        variable.values[at] = convert(variable.kind, value, name, span)?;
        Ok(true)
    }

    pub(crate) fn assign_param(&mut self, index: u32, value: f64) {
        self.params.insert(index, value);
    }

    pub(crate) fn is_defined(&self, name: &str) -> bool {
        self.find(name).is_some() || self.given.contains_key(name)
    }

    /// Value of an expression.
    pub(crate) fn eval(&self, expr: &Expr, span: Span) -> Result<Val, Fault> {
        Ok(match expr {
            Expr::Number(value) => Val::Number(*value),
            Expr::Text(text) => Val::Text(text.clone()),
            Expr::Param(index) => {
                let index = param_index(self.number(index, span)?, span)?;
                Val::Number(*self.params.get(&index).ok_or_else(|| {
                    Fault::new(codes::UNKNOWN_VARIABLE, span, format!("R{index} is read and was never assigned"))
                        .help(format!("assign it in the program, or give `R{index}` in the settings"))
                })?)
            }
            Expr::Name(name) => self.name(name, span)?,
            Expr::Element(name, indices) => {
                let Some(variable) = self.find(name) else {
                    let key = super::system::system_key(name, indices, &|e| self.number(e, span).ok());
                    let value = self.given.get(&key).or_else(|| self.system.get(&key));
                    return value.map(|v| Val::Number(*v)).ok_or_else(|| unknown(&key, span));
                };
                let indices = self.indices(indices, span)?;
                variable.values[position(name, &variable.sizes, &indices, span)?].clone()
            }
            Expr::Call(name, arguments) => Val::Number(self.function(name, arguments, span)?),
            Expr::Unary(unary, inner) => {
                let value = self.number(inner, span)?;
                Val::Number(match unary {
                    Unary::Minus => -value,
                    Unary::Plus => value,
                    Unary::Not => f64::from(u8::from(value == 0.0)),
                    Unary::BitNot => !(value as i32) as f64,
                })
            }
            Expr::Binary(operator, left, right) => self.binary(*operator, left, right, span)?,
        })
    }

    /// Value of an expression that must be a number.
    pub(crate) fn number(&self, expr: &Expr, span: Span) -> Result<f64, Fault> {
        match self.eval(expr, span)? {
            Val::Number(value) if value.is_finite() => Ok(value),
            Val::Number(_) => {
                Err(Fault::new(codes::ARITHMETIC, span, "the calculation has no finite result")
                    .help("check its values"))
            }
            Val::Text(text) => {
                Err(Fault::new(codes::TYPE, span, format!("a number is needed and \"{text}\" is a text"))
                    .help("use a number or a numeric variable"))
            }
        }
    }

    pub(crate) fn indices(&self, indices: &[Expr], span: Span) -> Result<Vec<usize>, Fault> {
        indices
            .iter()
            .map(|index| {
                let value = self.number(index, span)?.round();
                if (0.0..1e9).contains(&value) {
                    return Ok(value as usize);
                }
                Err(Fault::new(codes::BAD_VALUE, span, format!("{value} is not an index")).help("indices begin at 0"))
            })
            .collect()
    }

    fn name(&self, name: &str, span: Span) -> Result<Val, Fault> {
        if let Some(variable) = self.find(name) {
            if !variable.sizes.is_empty() {
                let message = format!("`{name}` is an array and has no single value");
                return Err(Fault::new(codes::TYPE, span, message).help(format!("write {name}[0]")));
            }
            return Ok(variable.values[0].clone());
        }
        if let Some(&value) = self.given.get(name) {
            return Ok(Val::Number(value));
        }
        if let Some(&value) = self.system.get(name) {
            return Ok(Val::Number(value));
        }
        Ok(Val::Number(match name {
            "TRUE" => 1.0,
            "FALSE" => 0.0,
            "$PI" => std::f64::consts::PI,
            // Names of the machining types of CYCLE832.
            "_OFF" => 0.0,
            "_FINISH" => 1.0,
            "_SEMIFIN" => 2.0,
            "_ROUGH" => 3.0,
            "_ORI_FINISH" => 11.0,
            "_ORI_SEMIFIN" => 12.0,
            "_ORI_ROUGH" => 13.0,
            _ => return Err(unknown(name, span)),
        }))
    }

    fn binary(&self, operator: Binary, left: &Expr, right: &Expr, span: Span) -> Result<Val, Fault> {
        let (left, right) = (self.eval(left, span)?, self.eval(right, span)?);
        if operator == Binary::Join {
            let text = format!("{}{}", shown(&left), shown(&right));
            if text.len() > MAX_TEXT {
                let message = format!("the text has {} bytes; the limit is {MAX_TEXT}", text.len());
                return Err(Fault::new(codes::BAD_VALUE, span, message).help("join fewer texts"));
            }
            return Ok(Val::Text(text));
        }
        let truth = |b: bool| Val::Number(f64::from(u8::from(b)));
        let (a, b) = match (left, right) {
            (Val::Number(a), Val::Number(b)) => (a, b),
            (Val::Text(a), Val::Text(b)) if operator == Binary::Equal => return Ok(truth(a == b)),
            (Val::Text(a), Val::Text(b)) if operator == Binary::NotEqual => return Ok(truth(a != b)),
            (a, b) => {
                let message = format!("`{}` and `{}` cannot be combined like this", shown(&a), shown(&b));
                return Err(Fault::new(codes::TYPE, span, message).help("combine numbers; join texts with <<"));
            }
        };
        let equal = (a - b).abs() <= RELATIVE_EQUALITY * a.abs().max(b.abs());
        let nonzero = |b: f64| {
            if b == 0.0 {
                Err(Fault::new(codes::ARITHMETIC, span, "division by zero").help("check the divisor"))
            } else {
                Ok(b)
            }
        };
        Ok(match operator {
            Binary::Add => Val::Number(a + b),
            Binary::Subtract => Val::Number(a - b),
            Binary::Multiply => Val::Number(a * b),
            Binary::Divide => Val::Number(a / nonzero(b)?),
            Binary::Div => Val::Number((a / nonzero(b)?).trunc()),
            Binary::Mod => Val::Number(a - (a / nonzero(b)?).trunc() * b),
            Binary::BitAnd => Val::Number(f64::from(a as i32 & b as i32)),
            Binary::BitOr => Val::Number(f64::from(a as i32 | b as i32)),
            Binary::BitXor => Val::Number(f64::from(a as i32 ^ b as i32)),
            Binary::And => truth(a != 0.0 && b != 0.0),
            Binary::Or => truth(a != 0.0 || b != 0.0),
            Binary::Xor => truth((a != 0.0) != (b != 0.0)),
            Binary::Equal => truth(equal),
            Binary::NotEqual => truth(!equal),
            Binary::Less => truth(a < b && !equal),
            Binary::Greater => truth(a > b && !equal),
            Binary::LessEqual => truth(a < b || equal),
            Binary::GreaterEqual => truth(a > b || equal),
            Binary::Join | Binary::Chain => Val::Text(String::new()),
        })
    }

    fn function(&self, name: &str, arguments: &[Option<Expr>], span: Span) -> Result<f64, Fault> {
        let arity = match name {
            "SIN" | "COS" | "TAN" | "ASIN" | "ACOS" | "SQRT" | "ABS" | "POT" | "TRUNC" | "ROUND" | "ROUNDUP" | "LN"
            | "EXP" => 1,
            "ATAN2" | "MINVAL" | "MAXVAL" => 2,
            "BOUND" => 3,
            _ => {
                return Err(Fault::new(codes::UNKNOWN_WORD, span, format!("the function `{name}` is not known"))
                    .help("see the functions in the coverage table"));
            }
        };
        let mut values = [0.0; 3];
        if arguments.len() != arity {
            let message = format!("`{name}` takes {arity} arguments and has {}", arguments.len());
            return Err(Fault::new(codes::ARGUMENTS, span, message).help("separate arguments by commas"));
        }
        for (value, argument) in values.iter_mut().zip(arguments) {
            let argument = argument.as_ref().ok_or_else(|| {
                Fault::new(codes::ARGUMENTS, span, format!("an argument of `{name}` is missing"))
                    .help("write all arguments")
            })?;
            *value = self.number(argument, span)?;
        }
        let [a, b, c] = values;
        let domain = |inside: bool, what: &str| {
            if inside {
                Ok(())
            } else {
                Err(Fault::new(codes::ARITHMETIC, span, format!("`{name}` of {a} does not exist; {what}"))
                    .help("check the argument"))
            }
        };
        Ok(match name {
            "SIN" => sin_cos_degrees(a).0,
            "COS" => sin_cos_degrees(a).1,
            "TAN" => {
                let (s, c) = sin_cos_degrees(a);
                domain(c != 0.0, "90 degrees has no tangent")?;
                s / c
            }
            "ASIN" | "ACOS" => {
                domain(a.abs() <= 1.0, "the argument must be from -1 to 1")?;
                if name == "ASIN" { a.asin().to_degrees() } else { a.acos().to_degrees() }
            }
            "ATAN2" => a.atan2(b).to_degrees(),
            "SQRT" => {
                domain(a >= 0.0, "the argument must not be negative")?;
                a.sqrt()
            }
            "ABS" => a.abs(),
            "POT" => a * a,
            "TRUNC" => a.trunc(),
            "ROUND" => a.round(),
            "ROUNDUP" => a.ceil(),
            "LN" => {
                domain(a > 0.0, "the argument must be above zero")?;
                a.ln()
            }
            "EXP" => a.exp(),
            "MINVAL" => a.min(b),
            "MAXVAL" => a.max(b),
            _ => {
                domain(a <= b, "the lower bound lies above the upper one")?;
                c.clamp(a, b)
            }
        })
    }
}

pub(crate) fn param_index(value: f64, span: Span) -> Result<u32, Fault> {
    let index = value.round();
    if (0.0..1e9).contains(&index) {
        return Ok(index as u32);
    }
    Err(Fault::new(codes::BAD_VALUE, span, format!("R{value} is not an R parameter")).help("use R0 and above"))
}

fn unknown(name: &str, span: Span) -> Fault {
    if name.starts_with('$') {
        return Fault::new(codes::UNSUPPORTED_WORD, span, format!("the system variable `{name}` is not supported"))
            .help(format!("give a value for `{name}` in the settings, or take it out"));
    }
    Fault::new(codes::UNKNOWN_VARIABLE, span, format!("the variable `{name}` is not defined"))
        .help(format!("write DEF REAL {name}, or give `{name}` in the settings"))
}

fn position(name: &str, sizes: &[usize], indices: &[usize], span: Span) -> Result<usize, Fault> {
    if sizes.len() != indices.len() {
        let message = format!("`{name}` has {} dimensions and {} indices", sizes.len(), indices.len());
        return Err(Fault::new(codes::TYPE, span, message).help("give one index for each dimension"));
    }
    let mut at = 0;
    for (&size, &index) in sizes.iter().zip(indices) {
        if index >= size {
            let message = format!("index {index} of `{name}` is out of its range 0 to {}", size as i64 - 1);
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("define a larger array"));
        }
        at = at * size + index;
    }
    Ok(at)
}

/// Value as a variable of this type keeps it: INT is rounded, BOOL is 0 or 1.
fn convert(kind: Type, value: Val, name: &str, span: Span) -> Result<Val, Fault> {
    match (kind, value) {
        (Type::Text, Val::Text(text)) => Ok(Val::Text(text)),
        (Type::Real, Val::Number(value)) => Ok(Val::Number(value)),
        (Type::Int, Val::Number(value)) => Ok(Val::Number(value.round())),
        (Type::Bool, Val::Number(value)) => Ok(Val::Number(f64::from(u8::from(value != 0.0)))),
        (_, value) => {
            let message = format!("`{}` does not fit the type of `{name}`", shown(&value));
            Err(Fault::new(codes::TYPE, span, message).help("assign a text to STRING, a number to REAL, INT, BOOL"))
        }
    }
}

pub(crate) fn shown(value: &Val) -> String {
    match value {
        Val::Number(number) => format!("{number}"),
        Val::Text(text) => text.clone(),
    }
}

impl Variable {
    /// The value of a variable that is no array.
    pub(crate) fn single(&self) -> Option<&Val> {
        self.values.first()
    }
}
