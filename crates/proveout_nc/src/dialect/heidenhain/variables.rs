//! Q parameters and their formulas.

use std::collections::BTreeMap;

use super::expr::Expr;
use super::words::{Condition, Kind, Param, Relation, Value};
use crate::channel::expression::{self, Function, Operator, apply, arithmetic, combine};
use crate::codes;
use crate::diagnostic::{Fault, Span, give};

/// A value of a formula.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Val {
    Number(f64),
    Text(String),
}

#[derive(Debug)]
pub(crate) struct QParameters {
    numbers: BTreeMap<Param, f64>,
    texts: BTreeMap<u32, String>,
    /// QL parameters of the programs that called this one.
    saved: Vec<BTreeMap<Param, f64>>,
    settings: BTreeMap<String, f64>,
    limit: usize,
}

impl QParameters {
    pub(crate) fn new(settings: &BTreeMap<String, f64>, limit: usize) -> Self {
        let settings = settings.iter().map(|(name, &value)| (name.to_ascii_uppercase(), value)).collect();
        Self { numbers: BTreeMap::new(), texts: BTreeMap::new(), saved: Vec::new(), settings, limit }
    }

    /// A program is called: its QL parameters are its own.
    pub(crate) fn enter(&mut self) {
        let own = self.numbers.iter().filter(|(p, _)| p.kind == Kind::Local).map(|(p, v)| (*p, *v)).collect();
        self.numbers.retain(|p, _| p.kind != Kind::Local);
        self.saved.push(own);
    }

    pub(crate) fn leave(&mut self) {
        self.numbers.retain(|p, _| p.kind != Kind::Local);
        self.numbers.extend(self.saved.pop().unwrap_or_default());
    }

    pub(crate) fn get(&self, param: Param) -> Option<f64> {
        self.numbers.get(&param).copied().or_else(|| self.settings.get(&param.name()).copied())
    }

    /// A value that the settings give, by its name.
    pub(super) fn given(&self, name: &str) -> Option<f64> {
        self.settings.get(name).copied()
    }

    pub(crate) fn is_defined(&self, param: Param) -> bool {
        if param.kind == Kind::Text { self.texts.contains_key(&param.index) } else { self.get(param).is_some() }
    }

    pub(crate) fn set(&mut self, param: Param, value: f64, span: Span) -> Result<(), Fault> {
        if self.numbers.len() >= self.limit && !self.numbers.contains_key(&param) {
            let message = format!("the program uses more than {} Q parameters, which is the limit", self.limit);
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("use fewer parameters, or split the program"));
        }
        self.numbers.insert(param, value);
        Ok(())
    }

    /// Removes a value: it is no longer known.
    pub(crate) fn forget(&mut self, param: Param) {
        self.numbers.remove(&param);
    }

    pub(crate) fn assign(&mut self, param: Param, value: Val, span: Span) -> Result<(), Fault> {
        match (param.kind, value) {
            (Kind::Text, Val::Text(text)) => {
                if text.len() > 4096 || self.texts.len() > 2000 {
                    return Err(Fault::new(codes::BAD_VALUE, span, "the texts of the program are too long")
                        .help("a QS parameter holds 255 characters"));
                }
                self.texts.insert(param.index, text);
                Ok(())
            }
            (Kind::Text, Val::Number(_)) | (_, Val::Text(_)) => {
                Err(Fault::new(codes::TYPE, span, format!("the value does not fit the type of `{}`", param.name()))
                    .help("assign texts to QS, numbers to Q, QL and QR"))
            }
            (_, Val::Number(number)) => self.set(param, number, span),
        }
    }

    pub(crate) fn text(&self, param: Param, span: Span) -> Result<&str, Fault> {
        self.texts.get(&param.index).map(String::as_str).ok_or_else(|| self.unknown(param, span))
    }

    fn unknown(&self, param: Param, span: Span) -> Fault {
        let name = param.name();
        let help = match (param.kind, param.index) {
            (Kind::Global, 108 | 114) => format!("it comes from the tool table: {}", give(&name)),
            (Kind::Global, 120..=122) => format!(
                "it holds a rotary position that the control computes for the tilted plane; it is read in blocks such as L A+Q120 B+Q121 C+Q122. For other uses, {}",
                give(&name)
            ),
            (Kind::Global, 100..=199) => format!("the control sets it: {}", give(&name)),
            _ => format!("write {name} = 0 before it is used, or {}", give(&name)),
        };
        Fault::new(codes::UNKNOWN_VARIABLE, span, format!("`{name}` has no value")).help(help).of_variable(name)
    }

    pub(crate) fn value(&self, value: Value, span: Span) -> Result<f64, Fault> {
        match value {
            Value::Number(number) => Ok(number),
            Value::Param { negative, param } => {
                if param.kind == Kind::Text {
                    return Err(Fault::new(codes::TYPE, span, format!("`{}` is a text", param.name()))
                        .help("use a Q, QL or QR parameter"));
                }
                let number = self.get(param).ok_or_else(|| self.unknown(param, span))?;
                Ok(if negative { -number } else { number })
            }
        }
    }

    pub(crate) fn eval(&self, expr: &Expr, span: Span) -> Result<Val, Fault> {
        Ok(match expr {
            Expr::Number(number) => Val::Number(*number),
            Expr::Text(text) => Val::Text(text.clone()),
            Expr::Param(param) if param.kind == Kind::Text => Val::Text(self.text(*param, span)?.to_owned()),
            Expr::Param(param) => Val::Number(self.value(Value::Param { negative: false, param: *param }, span)?),
            Expr::Unary(Function::Text, inner) => match self.eval(inner, span)? {
                Val::Number(number) => Val::Text(format!("{number}")),
                text => text,
            },
            Expr::Unary(function, inner) => finite(apply(*function, self.number(inner, span)?, span)?, span)?,
            Expr::Chain(first, rest) => {
                let mut left = self.eval(first, span)?;
                for (operator, right) in rest {
                    left = binary(*operator, left, self.eval(right, span)?, span)?;
                }
                left
            }
            Expr::Name(_) | Expr::Element(..) | Expr::Call(..) => {
                return Err(Fault::new(codes::TYPE, span, "a name where a value is needed").help("use a Q parameter"));
            }
        })
    }

    fn number(&self, expr: &Expr, span: Span) -> Result<f64, Fault> {
        number(self.eval(expr, span)?, span)
    }

    pub(crate) fn truth(&self, condition: &Condition, span: Span) -> Result<bool, Fault> {
        Ok(match condition {
            Condition::Defined(param, defined) => self.is_defined(*param) == *defined,
            Condition::Compare(a, relation, b) => {
                let (a, b) = (self.value(*a, span)?, self.value(*b, span)?);
                match relation {
                    Relation::Equal => a == b,
                    Relation::NotEqual => a != b,
                    Relation::Greater => a > b,
                    Relation::Less => a < b,
                }
            }
        })
    }
}

fn shown(value: Val) -> String {
    match value {
        Val::Number(number) => format!("{number}"),
        Val::Text(text) => text,
    }
}

fn number(value: Val, span: Span) -> Result<f64, Fault> {
    match value {
        Val::Number(number) => Ok(number),
        Val::Text(text) => {
            Err(Fault::new(codes::TYPE, span, format!("the text \"{text}\" where a number is needed"))
                .help("use a number"))
        }
    }
}

/// Value of an operation.
fn binary(operator: Operator, left: Val, right: Val, span: Span) -> Result<Val, Fault> {
    if operator == Operator::Join {
        let mut text = shown(left);
        text.push_str(&shown(right));
        return expression::short_text(text, span).map(Val::Text);
    }
    let value = combine(operator, number(left, span)?, number(right, span)?, span)?;
    finite(if operator == Operator::Angle { value.rem_euclid(360.0) } else { value }, span)
}

/// Zero has no sign on this control.
fn finite(value: f64, span: Span) -> Result<Val, Fault> {
    if value.is_finite() {
        return Ok(Val::Number(value + 0.0));
    }
    Err(arithmetic(format!("the result {value} is not finite"), span))
}
