//! Values of expressions and assignments.

use super::expr::Expr;
use super::osp;
use super::parser::{Assignment, WordValue};
use super::run_state::{Interpreter, alarm};
use crate::channel::expression::{Function, IndexedParameter, Operator, apply, arithmetic, combine, truth};
use crate::codes;
use crate::diagnostic::{Fault, Span, give};

/// Number of the highest parameter (`RS274NGC_MAX_PARAMETERS` of the interpreter less one).
const LINUXCNC_PARAMETERS: u32 = 5601;
/// A calculated number of a parameter is this near to a whole one.
const WHOLE_NUMBER: f64 = 1e-6;
/// Whole numbers below this are exact.
const EXACT: f64 = 9.0e15;

/// `LinuxCNC` takes values nearer than this as equal (`TOLERANCE_EQUAL` of its interpreter).
const LINUXCNC_EQUAL: f64 = 1e-4;

impl Interpreter {
    /// Value of a word; none where it is a vacant parameter.
    pub(crate) fn word_value(&self, value: &WordValue, span: Span) -> Result<Option<f64>, Fault> {
        match value {
            WordValue::Number { value, .. } => Ok(Some(*value)),
            WordValue::Expr(expr) => self.value(expr, span),
        }
    }

    /// Value of an expression as a number; a vacant parameter is zero.
    pub(crate) fn number(&self, expr: &Expr, span: Span) -> Result<f64, Fault> {
        Ok(self.value(expr, span)?.unwrap_or(0.0))
    }

    /// Value of an expression; none where it is a single vacant parameter.
    pub(crate) fn value(&self, expr: &Expr, span: Span) -> Result<Option<f64>, Fault> {
        let value = match expr {
            Expr::Number(value) => *value,
            Expr::Param(IndexedParameter(index)) => return self.read_parameter(index, span),
            Expr::Name(name) => self.read_named(name, span)?,
            Expr::Unary(function, inner) => match self.value(inner, span)? {
                // The negative of nothing is nothing: a word X-#1 is left out as X#1 is.
                None if *function == Function::Negate => return Ok(None),
                x => apply(*function, x.unwrap_or(0.0), span)?,
            },
            Expr::Chain(first, rest) => {
                let mut left = self.value(first, span)?;
                for (operator, right) in rest {
                    let value = self.binary(*operator, left, self.value(right, span)?, span)?;
                    if !value.is_finite() {
                        return Err(endless(span));
                    }
                    left = Some(value);
                }
                return Ok(left);
            }
            Expr::Call(_, arguments) => truth(match arguments.first() {
                Some(Some(Expr::Name(name))) => {
                    self.variables.named(name).is_some() || self.system_named(name, span)?.is_some()
                }
                // Every numbered parameter of a LinuxCNC is there, with zero where nothing has set it.
                Some(Some(Expr::Param(IndexedParameter(index)))) => {
                    (1..=LINUXCNC_PARAMETERS).contains(&self.parameter_number(index, span)?)
                }
                _ => {
                    return Err(
                        Fault::new(codes::SYNTAX, span, "EXISTS takes a parameter").help("write EXISTS[#<name>]")
                    );
                }
            }),
            Expr::Text(_) | Expr::Element(..) => {
                return Err(Fault::new(codes::TYPE, span, "a text where a number is needed").help("write a number"));
            }
        };
        if value.is_finite() {
            return Ok(Some(value));
        }
        Err(endless(span))
    }

    fn binary(&self, operator: Operator, a: Option<f64>, b: Option<f64>, span: Span) -> Result<f64, Fault> {
        let linuxcnc = self.own.flavor.is_linuxcnc();
        if matches!(operator, Operator::Equal | Operator::NotEqual) {
            let same = match (a, b) {
                (Some(a), Some(b)) if linuxcnc => (a - b).abs() < LINUXCNC_EQUAL,
                // A vacant parameter equals only a vacant one.
                (a, b) => a == b,
            };
            return Ok(truth(same == (operator == Operator::Equal)));
        }
        let (a, b) = (a.unwrap_or(0.0), b.unwrap_or(0.0));
        match operator {
            // Never negative.
            Operator::Mod if linuxcnc && b != 0.0 => Ok(a.rem_euclid(b)),
            Operator::And | Operator::Or | Operator::Xor if !linuxcnc => bits(operator, a, b, span),
            Operator::Angle if a == 0.0 && b == 0.0 => {
                Err(arithmetic("the angle of a vector without length is not defined", span))
            }
            Operator::Angle => {
                let angle = combine(operator, a, b, span)?;
                // 0 to 360 degrees on a Fanuc (parameter 6004 bit 0 is 0).
                let whole_turn = self.own.flavor == super::flavor::Flavor::Fanuc && angle < 0.0;
                Ok(if whole_turn { angle + 360.0 } else { angle })
            }
            _ => combine(operator, a, b, span),
        }
    }

    pub(crate) fn parameter_number(&self, index: &Expr, span: Span) -> Result<u32, Fault> {
        let number = self.number(index, span)?;
        // Calculated numbers are whole up to rounding.
        let whole = number.round();
        if (number - whole).abs() < WHOLE_NUMBER && (0.0..=999_999.0).contains(&whole) {
            return Ok(whole as u32);
        }
        Err(Fault::new(codes::BAD_VALUE, span, format!("#{number} is not a parameter")).help("use a whole number"))
    }

    fn read_parameter(&self, index: &Expr, span: Span) -> Result<Option<f64>, Fault> {
        let number = self.parameter_number(index, span)?;
        if number == 0 {
            if self.own.flavor.is_linuxcnc() {
                return Err(Fault::new(codes::BAD_VALUE, span, "#0 is not a parameter").help("use #1 to #5000"));
            }
            return Ok(None);
        }
        if let Some(value) = self.variables.numbered(number) {
            return Ok(Some(value));
        }
        if let Some(common) = osp::common(number) {
            let message = format!("VC{common} keeps its value in the control, and the program has not set it");
            return Err(Fault::new(codes::UNKNOWN_VARIABLE, span, message).help(give(&format!("VC{common}"))));
        }
        if let Some(value) = self.system_number(number, span)? {
            return Ok(Some(value));
        }
        if self.own.flavor.is_linuxcnc() && number > LINUXCNC_PARAMETERS {
            let message = format!("#{number} is not a parameter: the highest one is #{LINUXCNC_PARAMETERS}");
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
            return Err(Fault::new(codes::UNKNOWN_VARIABLE, span, message).help(give(&format!("#{number}"))));
        }
        if (200..=499).contains(&number) && self.own.flavor == super::flavor::Flavor::Haas {
            return Ok(None);
        }
        Err(unknown_system(&format!("#{number}"), span))
    }

    fn read_named(&self, name: &str, span: Span) -> Result<f64, Fault> {
        if !self.own.flavor.is_linuxcnc() && !self.settings.control.osp_words {
            let message = format!("`{name}` is not a function of the {} reader", self.own.flavor.name());
            return Err(Fault::new(codes::UNKNOWN_WORD, span, message)
                .help("see the coverage table for the functions that are read"));
        }
        if let Some(own) = self.own_offset(name, span).filter(|_| self.variables.named(name).is_none()) {
            return own;
        }
        if self.settings.control.osp_words && self.variables.named(name).is_none() {
            let message = format!("the local variable {name} has no value in this program");
            return Err(Fault::new(codes::UNKNOWN_VARIABLE, span, message)
                .help(format!("assign it first, or hand it over with the CALL: CALL O1 {name}=5")));
        }
        if let Some(value) = self.variables.named(name) {
            return Ok(value);
        }
        if let Some(value) = self.system_named(name, span)? {
            return Ok(value);
        }
        Err(Fault::new(codes::UNKNOWN_VARIABLE, span, format!("the parameter `#<{name}>` has no value"))
            .help(format!("assign it first, or {}", give(&format!("#<{name}>")))))
    }

    /// Assigns after all values of the block are known.
    pub(crate) fn assign_all(&mut self, assignments: &[Assignment], comment: Span, line: &str) -> Result<(), Fault> {
        if let [one] = assignments {
            let value = self.value(&one.value, one.span)?;
            return self.assign(&one.target, value, one.span, comment, line);
        }
        if self.settings.control.osp_words || self.settings.control.depth_in_i {
            // One after the other.
            for one in assignments {
                let value = self.value(&one.value, one.span)?;
                self.assign(&one.target, value, one.span, comment, line)?;
            }
            return Ok(());
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
            Expr::Name(name) => {
                if name.starts_with('_') && self.system_named(name, span).is_ok_and(|found| found.is_some()) {
                    return Err(unknown_system(&format!("#<{name}>"), span));
                }
                self.variables.set_named(name, value.unwrap_or(0.0));
                return Ok(());
            }
            Expr::Param(IndexedParameter(index)) => self.parameter_number(index, span)?,
            _ => return Err(Fault::new(codes::SYNTAX, span, "only a parameter can be assigned to").help("write #1=5")),
        };
        let text = line.get(comment.start as usize..comment.end as usize).unwrap_or_default();
        match number {
            _ if osp::common(number).is_some() => {
                self.variables.set(number, value);
                Ok(())
            }
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

fn endless(span: Span) -> Fault {
    arithmetic("the result of the calculation is not finite", span)
}

/// AND, OR, XOR of macro B: bit by bit on whole numbers.
fn bits(operator: Operator, a: f64, b: f64, span: Span) -> Result<f64, Fault> {
    let whole = |v: f64| {
        if v.abs() < EXACT {
            Ok(v.round() as i64)
        } else {
            Err(arithmetic(format!("{v} is too large for AND, OR, XOR"), span))
        }
    };
    let (a, b) = (whole(a)?, whole(b)?);
    Ok(match operator {
        Operator::And => a & b,
        Operator::Or => a | b,
        _ => a ^ b,
    } as f64)
}

pub(crate) fn unknown_system(name: &str, span: Span) -> Fault {
    Fault::new(codes::UNSUPPORTED_WORD, span, format!("the system parameter `{name}` is not known to the twin"))
        .help(format!("{}, or remove its use", give(name)))
}
