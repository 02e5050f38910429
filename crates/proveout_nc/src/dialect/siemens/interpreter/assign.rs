//! Definition and assignment of variables.

use super::super::eval::{self, Val};
use super::super::expr::Expr;
use super::super::parser::{Definition, Type};
use super::super::run_state::Interpreter;
use super::super::system::subject_of;
use crate::channel::expression::IndexedParameter;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::Frame;

/// Most variables of type FRAME.
const MAX_FRAMES: usize = 10_000;

impl Interpreter {
    pub(super) fn define(&mut self, kind: Type, definition: &Definition) -> Result<(), Fault> {
        let span = definition.span;
        if kind == Type::Frame {
            if !definition.sizes.is_empty() {
                return Err(Fault::new(codes::UNSUPPORTED_WORD, span, "arrays of frames are not supported")
                    .help("define one variable for each frame"));
            }
            let frame = match &definition.initial {
                Some(initial) => self.frame_value(initial, span)?,
                None => Frame::IDENTITY,
            };
            if self.own.frame_variables.len() >= MAX_FRAMES && !self.own.frame_variables.contains_key(&definition.name)
            {
                return Err(Fault::new(codes::BAD_VALUE, span, format!("more than {MAX_FRAMES} frames are defined"))
                    .help("define fewer frames"));
            }
            self.own.frame_variables.insert(definition.name.clone(), frame);
            return Ok(());
        }
        let sizes = self.variables.indices(&definition.sizes, span)?;
        let count = sizes.len();
        self.variables.define(&definition.name, kind, sizes.clone(), span)?;
        let Some(initial) = &definition.initial else { return Ok(()) };
        if count > 0 {
            return self.fill(&definition.name, &sizes, initial, span);
        }
        let value = self.variables.eval(initial, span)?;
        self.variables.assign(&definition.name, &[], value, span).map(|_| ())
    }

    /// `DEF REAL A[3] = SET(1, 2, 3)`, `= REP(0)`, `= 5`.
    pub(super) fn fill(&mut self, name: &str, sizes: &[usize], initial: &Expr, span: Span) -> Result<(), Fault> {
        let (list, repeat) = match initial {
            Expr::Call(function, arguments) if function == "SET" => {
                (arguments.iter().flatten().cloned().collect(), false)
            }
            Expr::Call(function, arguments) if function == "REP" => {
                (arguments.iter().flatten().take(1).cloned().collect(), true)
            }
            other => (vec![other.clone()], true),
        };
        let count: usize = sizes.iter().product();
        for at in 0..count {
            let Some(expr) = (if repeat { list.first() } else { list.get(at) }) else { break };
            let mut rest = at;
            let mut indices = vec![0; sizes.len()];
            for (index, size) in indices.iter_mut().zip(sizes).rev() {
                *index = rest % size;
                rest /= size;
            }
            let value = self.variables.eval(expr, span)?;
            self.variables.assign(name, &indices, value, span)?;
        }
        Ok(())
    }

    /// Assigns to a variable, an element or an R parameter given as an expression.
    pub(crate) fn assign_expr(&mut self, target: &Expr, value: Val, span: Span) -> Result<(), Fault> {
        let (name, indices) = match target {
            Expr::Param(IndexedParameter(index)) => {
                let index = eval::param_index(self.variables.number(index, span)?, span)?;
                let Val::Number(value) = value else {
                    return Err(Fault::new(codes::TYPE, span, format!("R{index} cannot hold a text"))
                        .help("use a STRING variable"));
                };
                self.variables.assign_param(index, value);
                return Ok(());
            }
            Expr::Name(name) => (name, Vec::new()),
            Expr::Element(name, indices) => (name, self.variables.indices(indices, span)?),
            _ => {
                return Err(
                    Fault::new(codes::SYNTAX, span, "only a variable can be assigned to").help("write NAME=value")
                );
            }
        };
        if self.variables.assign(name, &indices, value, span)? {
            return Ok(());
        }
        let fault = if name.starts_with('$') {
            Fault::new(codes::UNSUPPORTED_WORD, span, format!("the system variable `{name}` cannot be written here"))
                .help("of the system variables, frames such as $P_UIFR[1] can be written")
                .about(subject_of(name))
        } else {
            Fault::new(codes::UNKNOWN_VARIABLE, span, format!("the variable `{name}` is not defined"))
                .help(format!("write DEF REAL {name} before it is used"))
        };
        Err(fault)
    }
}
