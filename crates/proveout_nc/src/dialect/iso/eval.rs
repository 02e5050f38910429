//! Values of expressions and assignments.

use super::expr::{Binary, Expr, Function};
use super::interpreter::{Interpreter, alarm};
use super::parser::{Assignment, Value};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::sin_cos_degrees;

/// Number of the highest parameter (`RS274NGC_MAX_PARAMETERS` of the interpreter less one).
const LINUXCNC_PARAMETERS: u32 = 5601;

/// `LinuxCNC` takes values nearer than this as equal (`TOLERANCE_EQUAL` of its interpreter).
const LINUXCNC_EQUAL: f64 = 1e-4;

impl Interpreter {
    /// Value of a word; none where it is a vacant parameter.
    pub(crate) fn word_value(&self, value: &Value, span: Span) -> Result<Option<f64>, Fault> {
        match value {
            Value::Number { value, .. } => Ok(Some(*value)),
            Value::Expr(expr) => self.value(expr, span),
        }
    }

    /// Value of an expression as a number; a vacant parameter is zero.
    pub(crate) fn number(&self, expr: &Expr, span: Span) -> Result<f64, Fault> {
        Ok(self.value(expr, span)?.unwrap_or(0.0))
    }

    /// Value of an expression; none for a vacant parameter that stands alone.
    pub(crate) fn value(&self, expr: &Expr, span: Span) -> Result<Option<f64>, Fault> {
        let value = match expr {
            Expr::Number(value) => *value,
            Expr::Param(index) => return self.read_parameter(index, span),
            Expr::Named(name) => self.read_named(name, span)?,
            Expr::Exists(inner) => f64::from(u8::from(match inner.as_ref() {
                Expr::Named(name) => self.variables.named(name).is_some() || self.system_named(name, span)?.is_some(),
                // Every numbered parameter of a LinuxCNC is there, with zero where nothing has set it.
                Expr::Param(index) => (1..=LINUXCNC_PARAMETERS).contains(&self.parameter_number(index, span)?),
                _ => {
                    return Err(
                        Fault::new(codes::SYNTAX, span, "EXISTS takes a parameter").help("write EXISTS[#<name>]")
                    );
                }
            })),
            Expr::Unary(function, inner) => {
                let Some(x) = self.value(inner, span)? else {
                    // The negative of nothing is nothing: a word X-#1 is left out as X#1 is.
                    if *function == Function::Negate {
                        return Ok(None);
                    }
                    return self.function(*function, 0.0, span).map(Some);
                };
                self.function(*function, x, span)?
            }
            Expr::Atan(y, x) => {
                let (y, x) = (self.number(y, span)?, self.number(x, span)?);
                if y == 0.0 && x == 0.0 {
                    return Err(arithmetic("the angle of a vector without length is not defined", span));
                }
                let angle = y.atan2(x).to_degrees();
                // 0 to 360 degrees on a Fanuc (parameter 6004 bit 0 is 0).
                if self.own.flavor == super::flavor::Flavor::Fanuc && angle < 0.0 { angle + 360.0 } else { angle }
            }
            Expr::Binary(operator, left, right) => self.binary(*operator, left, right, span)?,
        };
        if value.is_finite() {
            return Ok(Some(value));
        }
        Err(arithmetic("the result of the calculation is not finite", span))
    }

    fn function(&self, function: Function, x: f64, span: Span) -> Result<f64, Fault> {
        let range = |holds: bool| {
            if holds { Ok(()) } else { Err(arithmetic(&format!("{} of {x} is not defined", function.name()), span)) }
        };
        let linuxcnc = self.own.flavor.is_linuxcnc();
        Ok(match function {
            Function::Negate => -x,
            Function::Sin => sin_cos_degrees(x).0,
            Function::Cos => sin_cos_degrees(x).1,
            Function::Tan => {
                let (s, c) = sin_cos_degrees(x);
                range(c != 0.0)?;
                s / c
            }
            Function::Asin => {
                range(x.abs() <= 1.0)?;
                x.asin().to_degrees()
            }
            Function::Acos => {
                range(x.abs() <= 1.0)?;
                x.acos().to_degrees()
            }
            Function::Atan => x.atan().to_degrees(),
            Function::Sqrt => {
                range(x >= 0.0)?;
                x.sqrt()
            }
            Function::Abs => x.abs(),
            Function::Round => x.round(),
            // LinuxCNC rounds towards minus and plus infinity, macro B towards and away from zero.
            Function::Fix if linuxcnc => x.floor(),
            Function::Fup if linuxcnc => x.ceil(),
            Function::Fix => x.trunc(),
            Function::Fup => x.abs().ceil().copysign(x) + 0.0,
            Function::Exp => x.exp(),
            Function::Ln => {
                range(x > 0.0)?;
                x.ln()
            }
        })
    }

    fn binary(&self, operator: Binary, left: &Expr, right: &Expr, span: Span) -> Result<f64, Fault> {
        let (a, b) = (self.value(left, span)?, self.value(right, span)?);
        let linuxcnc = self.own.flavor.is_linuxcnc();
        if matches!(operator, Binary::Equal | Binary::NotEqual) {
            let same = match (a, b) {
                (Some(a), Some(b)) if linuxcnc => (a - b).abs() < LINUXCNC_EQUAL,
                // A vacant parameter equals only a vacant one.
                (a, b) => a == b,
            };
            return Ok(f64::from(u8::from(same == (operator == Binary::Equal))));
        }
        let (a, b) = (a.unwrap_or(0.0), b.unwrap_or(0.0));
        let truth = |holds: bool| f64::from(u8::from(holds));
        Ok(match operator {
            Binary::Add => a + b,
            Binary::Subtract => a - b,
            Binary::Multiply => a * b,
            Binary::Divide if b == 0.0 => return Err(arithmetic(&format!("{a} is divided by zero"), span)),
            Binary::Divide => a / b,
            Binary::Mod if b == 0.0 => return Err(arithmetic(&format!("{a} is divided by zero (MOD)"), span)),
            // LinuxCNC: never negative.
            Binary::Mod if linuxcnc => a.rem_euclid(b),
            Binary::Mod => a % b,
            Binary::Power => a.powf(b),
            Binary::Greater => truth(a > b),
            Binary::GreaterEqual => truth(a >= b),
            Binary::Less => truth(a < b),
            Binary::LessEqual => truth(a <= b),
            Binary::And if linuxcnc => truth(a != 0.0 && b != 0.0),
            Binary::Or if linuxcnc => truth(a != 0.0 || b != 0.0),
            Binary::Xor if linuxcnc => truth((a != 0.0) != (b != 0.0)),
            _ => bits(operator, a, b, span)?,
        })
    }

    pub(crate) fn parameter_number(&self, index: &Expr, span: Span) -> Result<u32, Fault> {
        let number = self.number(index, span)?;
        // Calculated numbers are whole up to rounding.
        let whole = number.round();
        if (number - whole).abs() < 1e-6 && (0.0..=999_999.0).contains(&whole) {
            return Ok(whole as u32);
        }
        Err(Fault::new(codes::BAD_VALUE, span, format!("#{number} is not a parameter")).help("use a whole number"))
    }

    fn read_parameter(&self, index: &Expr, span: Span) -> Result<Option<f64>, Fault> {
        let number = self.parameter_number(index, span)?;
        if number == 0 {
            return Ok(if self.own.flavor.is_linuxcnc() { Some(0.0) } else { None });
        }
        if let Some(value) = self.variables.numbered(number) {
            return Ok(Some(value));
        }
        if let Some(value) = self.system_number(number, span)? {
            return Ok(Some(value));
        }
        if self.own.flavor.is_linuxcnc() && number > LINUXCNC_PARAMETERS {
            let message = format!("#{number} is no parameter: the highest one is #{LINUXCNC_PARAMETERS}");
            return Err(
                Fault::new(codes::UNKNOWN_VARIABLE, span, message).help("use #1 to #5000, or a named parameter")
            );
        }
        if self.own.flavor.is_linuxcnc() {
            return Ok(Some(0.0));
        }
        if self.variables.is_local(number) || (100..=199).contains(&number) {
            return Ok(None);
        }
        if (500..=999).contains(&number) || (10_000..=10_999).contains(&number) {
            let message = format!("#{number} keeps its value in the control, and the program has not set it");
            return Err(
                Fault::new(codes::UNKNOWN_VARIABLE, span, message).help(format!("give \"#{number}\" in the settings"))
            );
        }
        if (200..=499).contains(&number) && self.own.flavor == super::flavor::Flavor::Haas {
            return Ok(None);
        }
        Err(unknown_system(&format!("#{number}"), span))
    }

    fn read_named(&self, name: &str, span: Span) -> Result<f64, Fault> {
        if let Some(value) = self.variables.named(name) {
            return Ok(value);
        }
        if let Some(value) = self.system_named(name, span)? {
            return Ok(value);
        }
        Err(Fault::new(codes::UNKNOWN_VARIABLE, span, format!("the parameter `#<{name}>` has no value"))
            .help(format!("assign it first, or give \"#<{name}>\" in the settings")))
    }

    /// Assigns after all values of the block are known.
    pub(crate) fn assign_all(&mut self, assignments: &[Assignment], comment: Span, line: &str) -> Result<(), Fault> {
        if let [one] = assignments {
            let value = self.value(&one.value, one.span)?;
            return self.assign(&one.target, value, one.span, comment, line);
        }
        let mut values = Vec::with_capacity(assignments.len());
        for assignment in assignments {
            values.push(self.value(&assignment.value, assignment.span)?);
        }
        for (assignment, value) in assignments.iter().zip(values) {
            self.assign(&assignment.target, value, assignment.span, comment, line)?;
        }
        Ok(())
    }

    fn assign(
        &mut self,
        target: &Expr,
        value: Option<f64>,
        span: Span,
        comment: Span,
        line: &str,
    ) -> Result<(), Fault> {
        let number = match target {
            Expr::Named(name) => {
                if name.starts_with('_') && self.system_named(name, span).is_ok_and(|found| found.is_some()) {
                    return Err(unknown_system(&format!("#<{name}>"), span));
                }
                self.variables.set_named(name, value.unwrap_or(0.0));
                return Ok(());
            }
            Expr::Param(index) => self.parameter_number(index, span)?,
            _ => return Err(Fault::new(codes::SYNTAX, span, "only a parameter can be assigned to").help("write #1=5")),
        };
        let text = line.get(comment.start as usize..comment.end as usize).unwrap_or_default();
        match number {
            0 => Err(Fault::new(codes::BAD_VALUE, span, "#0 is always vacant").help("use #1 to #33")),
            3000 if !self.own.flavor.is_linuxcnc() => Err(alarm(&format!("{} {text}", value.unwrap_or(0.0)), span)),
            3006 if !self.own.flavor.is_linuxcnc() => {
                self.stop_with_message(text.trim());
                Ok(())
            }
            _ if self.write_system(number, value, span)? => Ok(()),
            _ => {
                self.variables.set(number, value);
                Ok(())
            }
        }
    }
}

/// AND, OR, XOR of macro B: bit by bit on whole numbers.
fn bits(operator: Binary, a: f64, b: f64, span: Span) -> Result<f64, Fault> {
    let whole = |v: f64| {
        if v.abs() < 9.0e15 {
            Ok(v.round() as i64)
        } else {
            Err(arithmetic(&format!("{v} is too large for AND, OR, XOR"), span))
        }
    };
    let (a, b) = (whole(a)?, whole(b)?);
    Ok(match operator {
        Binary::And => a & b,
        Binary::Or => a | b,
        _ => a ^ b,
    } as f64)
}

fn arithmetic(message: &str, span: Span) -> Fault {
    Fault::new(codes::ARITHMETIC, span, message).help("check the values of the expression")
}

pub(crate) fn unknown_system(name: &str, span: Span) -> Fault {
    Fault::new(codes::UNSUPPORTED_WORD, span, format!("the system parameter `{name}` is not known to the twin"))
        .help(format!("give \"{name}\" in the settings, or take its use out"))
}
