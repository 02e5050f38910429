//! Subprograms: finding, entering, leaving.

use std::sync::Arc;

use super::super::eval::{Val, Variable};
use super::super::expr::Expr;
use super::super::parser::{self, Call, Parameter, SiemensBlock, SiemensStatement};
use super::super::run_state::{CallLevel, Interpreter, Loaded};
use crate::Op;
use crate::channel::ProgramSection;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::source::Mark;

impl Interpreter {
    /// The call with its arguments replaced by their values.
    pub(super) fn with_values(&self, call: &Call, span: Span) -> Result<Call, Fault> {
        let arguments = match &call.arguments {
            None => None,
            Some(list) => Some(
                list.iter()
                    .map(|argument| match argument {
                        None => Ok(None),
                        Some(expr) => self.variables.eval(expr, span).map(|value| {
                            Some(match value {
                                Val::Number(number) => Expr::Number(number),
                                Val::Text(text) => Expr::Text(text),
                            })
                        }),
                    })
                    .collect::<Result<Vec<_>, Fault>>()?,
            ),
        };
        Ok(Call { name: call.name.clone(), arguments })
    }

    /// Enters a subprogram of the same file or of the folders; false when there is none with this name.
    pub(crate) fn call_subprogram(&mut self, call: &Call, passes: u32, span: Span) -> Result<bool, Fault> {
        let Some((loaded, section)) = self.find_subprogram(&call.name, span)? else {
            return Ok(false);
        };
        self.room_for_call(&format!("`{}` is called", call.name), span)?;
        let (parameters, save, first_line) = procedure_head(&loaded, section).map_err(|fault| {
            let message = format!("the head of the subprogram `{}` is broken: {}", call.name, fault.message);
            Fault { code: codes::SUBPROGRAM, message, help: fault.help, span, about: None }
        })?;
        let given = call.arguments.as_deref().unwrap_or_default();
        if given.len() > parameters.len() {
            let message = format!("`{}` takes {} arguments and is given {}", call.name, parameters.len(), given.len());
            return Err(Fault::new(codes::ARGUMENTS, span, message).help("compare the call with the PROC line"));
        }
        let mut values = Vec::new();
        let mut references = Vec::new();
        let mut arrays = Vec::new();
        for (i, parameter) in parameters.iter().enumerate() {
            let argument = given.get(i).and_then(Option::as_ref);
            if parameter.sizes.is_some() {
                let array = self.array_argument(parameter, argument, span)?;
                if let Some(argument) = argument.filter(|_| parameter.by_reference) {
                    references.push((parameter.name.clone(), argument.clone()));
                }
                arrays.push((parameter.name.clone(), array));
                values.push(None);
                continue;
            }
            let value = match argument.or(parameter.initial.as_ref()) {
                Some(expr) => Some(self.variables.eval(expr, span)?),
                None => None,
            };
            if let Some(argument) = argument.filter(|_| parameter.by_reference) {
                references.push((parameter.name.clone(), argument.clone()));
            }
            values.push(value);
        }
        self.variables.enter();
        for (name, array) in arrays {
            self.variables.define_copy(&name, array, span)?;
        }
        for (parameter, value) in parameters.iter().zip(values).filter(|(parameter, _)| parameter.sizes.is_none()) {
            self.variables.define(&parameter.name, parameter.kind, Vec::new(), span)?;
            if let Some(value) = value {
                self.variables.assign(&parameter.name, &[], value, span)?;
            }
        }
        let saved = save.then(|| Box::new(self.modal.clone()));
        let own = CallLevel { repetitions: Vec::new(), references, saved };
        self.enter((loaded, section), first_line, passes, own);
        Ok(true)
    }

    /// The array passed for a parameter.
    fn array_argument(&self, parameter: &Parameter, argument: Option<&Expr>, span: Span) -> Result<Variable, Fault> {
        let name = &parameter.name;
        let array = match argument {
            Some(Expr::Name(given)) => self.variables.array(given),
            _ => None,
        };
        let Some(array) = array else {
            return Err(Fault::new(codes::ARGUMENTS, span, format!("the parameter `{name}` takes an array"))
                .help("give the name of an array, such as DEF REAL A[3]"));
        };
        let sizes = parameter.sizes.as_deref().unwrap_or_default();
        let fits = sizes.len() == array.sizes().len() && parameter.kind == array.kind;
        for (size, has) in sizes.iter().zip(array.sizes()) {
            let Some(size) = size else { continue };
            let wanted = self.variables.number(size, span)?;
            if wanted != *has as f64 {
                let message =
                    format!("the parameter `{name}` has {wanted} elements, and the array that is given {has}");
                return Err(Fault::new(codes::ARGUMENTS, span, message).help("define both alike"));
            }
        }
        if !fits {
            let message = format!("the array that is given for `{name}` has another type or number of dimensions");
            return Err(Fault::new(codes::ARGUMENTS, span, message).help("define both alike"));
        }
        Ok(array.clone())
    }

    /// Leaves a subprogram, or begins its next pass.
    pub(super) fn leave(&mut self) {
        if self.next_pass() {
            return;
        }
        let Some(level) = self.stack.pop() else { return };
        let locals = self.variables.leave();
        for (inside, outside) in level.own.references {
            let Some(variable) = locals.get(&inside) else { continue };
            if let (false, Expr::Name(name)) = (variable.sizes().is_empty(), &outside) {
                self.variables.take_over(name, variable);
            } else if let Some(value) = variable.single() {
                // The target was read when the call was made, so it can be assigned now.
                let _ = self.assign_expr(&outside, value.clone(), Span::default());
            }
        }
        if self.own.modal_call.as_ref().is_some_and(|modal| modal.level > self.depth()) {
            self.own.modal_call = None;
        }
        if let Some(saved) = level.own.saved {
            let (path_mode, side) = (self.modal.path_mode, self.modal.compensation.side);
            self.modal = *saved;
            if self.modal.compensation.side != side {
                self.tell_compensation();
            }
            if self.modal.path_mode != path_mode {
                self.emit(Op::PathMode(self.modal.path_mode));
            }
            if *self.position.frame() != self.modal.frames.total() {
                self.take_frames("SAVE");
            }
        }
    }

    pub(in super::super) fn find_subprogram(
        &mut self,
        name: &str,
        span: Span,
    ) -> Result<Option<(Arc<Loaded>, ProgramSection)>, Fault> {
        for level in self.stack.iter().rev() {
            if let Some(section) = level.loaded.index.procs.get(name) {
                return Ok(Some((Arc::clone(&level.loaded), *section)));
            }
        }
        // SPF before MPF.
        let found = self.file_beside(|path| {
            let stem = path.file_stem()?.to_string_lossy().to_ascii_uppercase();
            let ending = path.extension()?.to_string_lossy().to_ascii_uppercase();
            (stem == name && matches!(&*ending, "SPF" | "MPF")).then_some(ending == "MPF")
        });
        let Some(path) = found else { return Ok(None) };
        let loaded = self.load(path, "subprogram", name, span)?;
        let section = loaded.index.main;
        Ok(Some((loaded, section)))
    }
}

pub(crate) fn missing_subprogram(name: &str, span: Span) -> Fault {
    Fault::new(codes::SUBPROGRAM, span, format!("subprogram `{name}` not found"))
        .help(format!("put {name}.SPF into the folder of the program, or `PROC {name}` into its file"))
}

/// Parameters of a subprogram, whether it saves modal state, and its first line after PROC.
fn procedure_head(loaded: &Loaded, section: ProgramSection) -> Result<(Vec<Parameter>, bool, Mark), Fault> {
    let mut block = SiemensBlock::default();
    let mut at = section.start;
    while let Some((line, next)) = loaded.source.line(at) {
        if at.offset >= section.end {
            break;
        }
        if let Err(fault) = parser::parse_line(line, &mut block) {
            // A fault in another line than PROC is reported when that line is run.
            let word = line.trim_start().get(..4).unwrap_or_default();
            if word.eq_ignore_ascii_case("PROC") {
                return Err(fault);
            }
            break;
        }
        if let Some(SiemensStatement::Proc { parameters, save, .. }) = block.statement.take() {
            return Ok((parameters, save, next));
        }
        if !block.is_empty() {
            break;
        }
        at = next;
    }
    Ok((Vec::new(), false, section.start))
}
