//! What a program gives to a cycle, read and checked by its table.

use std::collections::BTreeMap;

use super::{CycleSpec, Key, Parameter, Unit, Usual, heidenhain};
use crate::codes;
use crate::diagnostic::{Fault, Span};

/// A value as the program writes it, evaluated.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Given {
    Number(f64),
    Text(String),
    /// FMAX
    Max,
    /// FAUTO
    Auto,
    /// FU
    PerRevolution(f64),
}

/// Names a parameter: by its name or its Q number.
pub(crate) trait Of: Copy {
    fn of(self, spec: &CycleSpec) -> Option<Parameter>;
}

impl Of for &str {
    fn of(self, spec: &CycleSpec) -> Option<Parameter> {
        spec.parameters.iter().copied().find(|parameter| parameter.name == self)
    }
}

impl Of for u32 {
    fn of(self, _spec: &CycleSpec) -> Option<Parameter> {
        Some(heidenhain::parameter(self))
    }
}

/// The values of one cycle.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    pub(crate) spec: &'static CycleSpec,
    pub(crate) given: BTreeMap<Key, Given>,
    /// mm in a unit of length of the program.
    pub(crate) length: f64,
    /// Height by which the surface lies above that of the definition, mm.
    pub(crate) lift: f64,
    pub(crate) span: Span,
}

impl Values {
    pub(crate) fn name(&self) -> &'static str {
        self.spec.name
    }

    /// A fault of this cycle.
    pub(crate) fn fault(&self, code: &'static str, message: impl Into<String>, help: &'static str) -> Fault {
        Fault::new(code, self.span, message.into()).help(help)
    }

    /// What is written for a parameter.
    pub(crate) fn given(&self, of: impl Of) -> Option<&Given> {
        self.given.get(&of.of(self.spec)?.key)
    }

    /// The program does not write the parameter.
    pub(crate) fn missing(&self, parameter: &Parameter) -> Fault {
        match parameter.key {
            Key::Position(at) => {
                let message = format!("`{}` has no {} (argument {at})", self.name(), parameter.what);
                self.fault(codes::ARGUMENTS, message, "write the argument")
            }
            Key::Q(number) => Fault::new(codes::ARGUMENTS, self.span, format!("the cycle has no Q{number}"))
                .help(format!("write Q{number}=")),
            Key::Letter(letter) => {
                let message = format!("{} has no `{}`", self.name(), char::from(letter));
                self.fault(codes::MISSING_VALUE, message, "write the word")
            }
        }
    }

    /// The number of a parameter; none where it is not written.
    fn number_of(&self, parameter: &Parameter) -> Result<Option<f64>, Fault> {
        let wrong = |message: String, help| Err(self.fault(codes::ARGUMENTS, message, help));
        match (self.given.get(&parameter.key), parameter.key) {
            (None, _) => Ok(None),
            (Some(Given::Number(number)), _) => Ok(Some(*number)),
            (Some(Given::Text(text)), Key::Position(at)) => {
                wrong(format!("argument {at} of `{}` is the text \"{text}\"", self.name()), "write a number there")
            }
            (Some(other), Key::Q(number)) => {
                wrong(format!("Q{number} must be a number and is {other:?}"), "write a number")
            }
            (Some(other), Key::Position(at)) => {
                wrong(format!("argument {at} of `{}` is {other:?}", self.name()), "write a number there")
            }
            (Some(other), Key::Letter(letter)) => {
                wrong(format!("`{}` of {} is {other:?}", char::from(letter), self.name()), "write a number")
            }
        }
    }

    /// A number in the unit of its parameter, mm for lengths; none where it is not written.
    pub(crate) fn get(&self, of: impl Of) -> Result<Option<f64>, Fault> {
        let Some(parameter) = of.of(self.spec) else { return Ok(None) };
        Ok(self.number_of(&parameter)?.map(|number| self.measured(&parameter, number)))
    }

    /// The number as it is written; none where it is not written.
    pub(crate) fn raw(&self, of: impl Of) -> Result<Option<f64>, Fault> {
        of.of(self.spec).map_or(Ok(None), |parameter| self.number_of(&parameter))
    }

    fn measured(&self, parameter: &Parameter, number: f64) -> f64 {
        match parameter.unit {
            Unit::Length => number * self.length,
            Unit::Size => number.abs() * self.length,
            Unit::Number | Unit::Feed | Unit::Text | Unit::Unread => number,
        }
    }

    /// The same where the cycle cannot do without, or has a value of its own for a parameter that is not
    /// written.
    pub(crate) fn value(&self, of: impl Of) -> Result<f64, Fault> {
        let Some(parameter) = of.of(self.spec) else { return Ok(0.0) };
        match (self.number_of(&parameter)?, parameter.usual) {
            (Some(number), _) | (None, Usual::Value(number)) => Ok(self.measured(&parameter, number)),
            (None, Usual::None) => Err(self.missing(&parameter)),
        }
    }

    /// A length above zero.
    pub(crate) fn above_zero(&self, of: impl Of) -> Result<f64, Fault> {
        let value = self.value(of)?.abs();
        match of.of(self.spec) {
            Some(parameter) if value <= 0.0 || !value.is_finite() => Err(self.missing(&parameter)),
            _ => Ok(value),
        }
    }

    /// A digit of a number that codes several things: `unit` is 1, 10, 100.
    pub(crate) fn digit(&self, of: impl Of, unit: f64) -> Result<f64, Fault> {
        Ok((self.value(of)? / unit).floor().rem_euclid(10.0))
    }

    /// Gives a Q parameter a number.
    pub(crate) fn put(&mut self, number: u32, value: f64) {
        self.given.insert(Key::Q(number), Given::Number(value));
    }

    /// The first argument that is set after the last one of the cycle; empty ones and zeros are none.
    pub(crate) fn surplus(&self) -> Option<u8> {
        self.surplus_after(self.spec.parameters.len())
    }

    /// The same after another argument.
    pub(crate) fn surplus_after(&self, last: usize) -> Option<u8> {
        self.given.iter().find_map(|(key, given)| match key {
            Key::Position(at) if usize::from(*at) > last && *given != Given::Number(0.0) => Some(*at),
            _ => None,
        })
    }
}
