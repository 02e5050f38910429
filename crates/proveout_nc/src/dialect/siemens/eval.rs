//! Variables and the values of expressions. Angles in degrees, as on the control.

use std::collections::BTreeMap;

use super::expr::Expr;
use super::parser::Type;
use super::system::subject_of;
use crate::channel::expression::{self, Function, IndexedParameter, Operator, apply, arithmetic, combine, truth};
use crate::codes;
use crate::diagnostic::{Fault, FaultSubject, Span, give};

/// Two numbers that differ by less than this, relative to the larger, are equal: the control compares
/// relatively too.
const RELATIVE_EQUALITY: f64 = 1e-12;
/// Indices of arrays and numbers of R parameters from here on are none.
const INDICES: f64 = 1e9;

/// Functions of one argument.
const FUNCTIONS: [(&str, Function); 13] = [
    ("SIN", Function::Sin),
    ("COS", Function::Cos),
    ("TAN", Function::Tan),
    ("ASIN", Function::Asin),
    ("ACOS", Function::Acos),
    ("SQRT", Function::Sqrt),
    ("ABS", Function::Abs),
    ("POT", Function::Square),
    ("TRUNC", Function::TowardsZero),
    ("ROUND", Function::Round),
    ("ROUNDUP", Function::Up),
    ("LN", Function::Ln),
    ("EXP", Function::Exp),
];

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
    /// Values given only by the settings.
    given: BTreeMap<String, f64>,
    /// Local variables, one map for each call level; subprograms see those of the main program.
    levels: Vec<BTreeMap<String, Variable>>,
    /// System variables with their values before the current line.
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

    /// Leaves a call level and returns its variables.
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
        let initial = if matches!(kind, Type::Text | Type::Axis) { Val::Text(String::new()) } else { Val::Number(0.0) };
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

    /// An array by its name.
    pub(crate) fn array(&self, name: &str) -> Option<&Variable> {
        self.find(name).filter(|variable| !variable.sizes.is_empty())
    }

    /// Puts a copy of an array into the innermost level.
    pub(crate) fn define_copy(&mut self, name: &str, array: Variable, span: Span) -> Result<(), Fault> {
        self.define(name, array.kind, array.sizes.clone(), span)?;
        if let Some(variable) = self.levels.last_mut().and_then(|level| level.get_mut(name)) {
            variable.values = array.values;
        }
        Ok(())
    }

    /// Takes the values of an array over into the one of this name.
    pub(crate) fn take_over(&mut self, name: &str, array: &Variable) {
        let level = match self.levels.last() {
            Some(level) if level.contains_key(name) => self.levels.len() - 1,
            _ => 0,
        };
        if let Some(variable) = self.levels.get_mut(level).and_then(|level| level.get_mut(name))
            && variable.values.len() == array.values.len()
        {
            variable.values.clone_from(&array.values);
        }
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
            Expr::Param(IndexedParameter(index)) => {
                let index = param_index(self.number(index, span)?, span)?;
                Val::Number(*self.params.get(&index).ok_or_else(|| {
                    Fault::new(codes::UNKNOWN_VARIABLE, span, format!("R{index} is read and was never assigned"))
                        .help(format!("assign it in the program, or {}", give(&format!("R{index}"))))
                        .of_variable(format!("R{index}"))
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
            Expr::Call(name, arguments) if name == "AXNAME" => self.axis_name(arguments, span)?,
            Expr::Call(name, arguments) => Val::Number(self.function(name, arguments, span)?),
            Expr::Unary(function, inner) => Val::Number(apply(*function, self.number(inner, span)?, span)?),
            Expr::Chain(first, rest) => {
                let mut left = self.eval(first, span)?;
                for (operator, right) in rest {
                    left = binary(*operator, left, self.eval(right, span)?, span)?;
                }
                left
            }
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
                if (0.0..INDICES).contains(&value) {
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
            // Added to one of them; changes only other digits.
            "_TOP_SURFACE_SMOOTH_ON" => 100.0,
            "_TOP_SURFACE_SMOOTH_OFF" => 200.0,
            _ if is_axis(name) => return Ok(Val::Text(name.to_owned())),
            _ => return Err(unknown(name, span)),
        }))
    }

    /// `AXNAME("X")`: the axis of a name.
    fn axis_name(&self, arguments: &[Option<Expr>], span: Span) -> Result<Val, Fault> {
        let [Some(argument)] = arguments else {
            return Err(Fault::new(codes::ARGUMENTS, span, "`AXNAME` takes one text").help("write AXNAME(\"X\")"));
        };
        match self.eval(argument, span)? {
            Val::Text(name) if is_axis(&name.to_ascii_uppercase()) => Ok(Val::Text(name.to_ascii_uppercase())),
            other => {
                Err(Fault::new(codes::TYPE, span, format!("`{}` is the name of no axis of the reader", shown(&other)))
                    .help("use X Y Z A B C U V W"))
            }
        }
    }

    fn function(&self, name: &str, arguments: &[Option<Expr>], span: Span) -> Result<f64, Fault> {
        let one = FUNCTIONS.iter().find(|(known, _)| *known == name).map(|(_, function)| *function);
        let arity = match (one, name) {
            (Some(_), _) => 1,
            (None, "ATAN2" | "MINVAL" | "MAXVAL") => 2,
            (None, "BOUND") => 3,
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
        Ok(match (one, name) {
            (Some(function), _) => apply(function, a, span)?,
            (None, "ATAN2") => combine(Operator::Angle, a, b, span)?,
            (None, "MINVAL") => a.min(b),
            (None, "MAXVAL") => a.max(b),
            _ if a <= b => c.clamp(a, b),
            _ => return Err(arithmetic(format!("the lower bound {a} of BOUND lies above the upper one, {b}"), span)),
        })
    }
}

pub(crate) fn param_index(value: f64, span: Span) -> Result<u32, Fault> {
    let index = value.round();
    if (0.0..INDICES).contains(&index) {
        return Ok(index as u32);
    }
    Err(Fault::new(codes::BAD_VALUE, span, format!("R{value} is not an R parameter")).help("use R0 and above"))
}

fn unknown(name: &str, span: Span) -> Fault {
    if name.starts_with('$') {
        return Fault::new(codes::UNSUPPORTED_WORD, span, format!("the system variable `{name}` is not supported"))
            .help(format!("{}, or remove it", give(name)))
            .about(subject_of(name).or_else(|| Some(FaultSubject::Variable(name.to_owned()))));
    }
    Fault::new(codes::UNKNOWN_VARIABLE, span, format!("the variable `{name}` is not defined"))
        .help(format!("write DEF REAL {name}, or {}", give(name)))
        .of_variable(name)
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

/// A value as a variable of this type stores it: INT is rounded, BOOL is 0 or 1.
fn convert(kind: Type, value: Val, name: &str, span: Span) -> Result<Val, Fault> {
    match (kind, value) {
        (Type::Text, Val::Text(text)) => Ok(Val::Text(text)),
        (Type::Axis, Val::Text(text)) if is_axis(&text) => Ok(Val::Text(text)),
        (Type::Axis, value) => {
            let message = format!("`{}` is not an axis that `{name}` could hold", shown(&value));
            Err(Fault::new(codes::TYPE, span, message).help("assign X Y Z A B C U V or W, or AXNAME(\"X\")"))
        }
        (Type::Real, Val::Number(value)) => Ok(Val::Number(value)),
        (Type::Int, Val::Number(value)) => Ok(Val::Number(value.round())),
        (Type::Bool, Val::Number(value)) => Ok(Val::Number(f64::from(u8::from(value != 0.0)))),
        (_, value) => {
            let message = format!("`{}` does not fit the type of `{name}`", shown(&value));
            Err(Fault::new(codes::TYPE, span, message).help("assign a text to STRING, a number to REAL, INT, BOOL"))
        }
    }
}

/// The letter of an axis of the reader.
pub(crate) fn is_axis(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|letter| crate::AxisValues::index(letter).is_some()) && letters.next().is_none()
}

pub(crate) fn shown(value: &Val) -> String {
    match value {
        Val::Number(number) => format!("{number}"),
        Val::Text(text) => text.clone(),
    }
}

impl Variable {
    /// The value of a variable that is not an array.
    pub(crate) fn single(&self) -> Option<&Val> {
        self.values.first().filter(|_| self.sizes.is_empty())
    }

    pub(crate) fn sizes(&self) -> &[usize] {
        &self.sizes
    }
}
/// Value of an operation.
fn binary(operator: Operator, left: Val, right: Val, span: Span) -> Result<Val, Fault> {
    if operator == Operator::Join {
        let text = format!("{}{}", shown(&left), shown(&right));
        return expression::short_text(text, span).map(Val::Text);
    }
    let number = |value: f64| Ok(Val::Number(value));
    let (a, b) = match (left, right) {
        (Val::Number(a), Val::Number(b)) => (a, b),
        (Val::Text(a), Val::Text(b)) if operator == Operator::Equal => return number(truth(a == b)),
        (Val::Text(a), Val::Text(b)) if operator == Operator::NotEqual => return number(truth(a != b)),
        (a, b) => {
            let message = format!("`{}` and `{}` cannot be combined like this", shown(&a), shown(&b));
            return Err(Fault::new(codes::TYPE, span, message).help("combine numbers; join texts with <<"));
        }
    };
    let equal = (a - b).abs() <= RELATIVE_EQUALITY * a.abs().max(b.abs());
    number(match operator {
        Operator::Mod if b != 0.0 => a - (a / b).trunc() * b,
        Operator::Equal => truth(equal),
        Operator::NotEqual => truth(!equal),
        Operator::Less => truth(a < b && !equal),
        Operator::Greater => truth(a > b && !equal),
        Operator::LessEqual => truth(a < b || equal),
        Operator::GreaterEqual => truth(a > b || equal),
        Operator::Chain => return Ok(Val::Text(String::new())),
        _ => combine(operator, a, b, span)?,
    })
}
