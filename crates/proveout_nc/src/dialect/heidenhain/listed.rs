//! Functions whose meaning a control file gives, and what it says of the data of the control.

use super::functions::refused_function;
use super::interpreter::Interpreter;
use super::variables::Val;
use super::words::{Block, MWord, Param, Value};
use crate::codes;
use crate::control::Meaning;
use crate::control::words::{Builtin, Listed};
use crate::diagnostic::{Fault, Span};
use crate::machine_data::KinematicsKind;

/// Functions of the control file have codes from this number on, by their place in its table.
pub(super) const LISTED: u32 = 4_000_000_000;

impl Interpreter {
    /// Puts what the control file says in the place of its functions, and refuses what is not valid on any machine.
    pub(super) fn list_functions(&mut self, block: &mut Block) -> Result<(), Fault> {
        let control = &self.settings.control;
        let mut more: Vec<MWord> = Vec::new();
        for m in &mut block.words.functions {
            if let Some(fault) = refused_function(m, control) {
                return Err(fault);
            }
            let Some((at, listed)) = control.words.m(m.code) else { continue };
            m.code = match &listed.meaning {
                Meaning::Does(words) => {
                    let codes: Vec<u32> = words
                        .iter()
                        .filter_map(|w| if let Builtin::M(code) = w { Some(*code) } else { None })
                        .collect();
                    let (first, rest) = codes.split_first().unwrap_or((&LISTED, &[]));
                    more.extend(rest.iter().map(|&code| MWord { code, ..*m }));
                    *first
                }
                _ => LISTED + at as u32,
            };
        }
        block.words.functions.extend(more);
        Ok(())
    }

    /// Does a function of the control file.
    pub(super) fn act_listed(&mut self, code: u32, span: Span) -> Result<(), Fault> {
        let at = code.saturating_sub(LISTED) as usize;
        let Some(Listed { word, meaning, .. }) = self.settings.control.words.at(at).cloned() else { return Ok(()) };
        match meaning {
            Meaning::TcpOn => {
                self.settings.check_kinematics(KinematicsKind::Tcp, &word, span)?;
                self.modal.spatial = false;
                self.modal.interpolation = crate::OrientationInterpolation::Axes;
                self.set_tcpm(true);
            }
            Meaning::TcpOff => self.set_tcpm(false),
            _ => self.tell_listed(at, ""),
        }
        Ok(())
    }

    /// FN 18: SYSREAD: a value that the control file or the settings give under `ID270 NR1 IDX1`.
    pub(super) fn system_read(&mut self, target: Param, from: &[Option<Value>; 3], span: Span) -> Result<(), Fault> {
        let mut name = String::new();
        for (value, word) in from.iter().zip(["ID", "NR", "IDX"]) {
            let Some(value) = value else { continue };
            let number = self.variables.value(*value, span)?;
            let blank = if name.is_empty() { "" } else { " " };
            name.push_str(&format!("{blank}{word}{number}"));
        }
        let Some(value) = self.variables.given(&name) else {
            let message = format!("FN 18 reads {name} of the control, and its value is not known");
            return Err(Fault::new(codes::UNKNOWN_VARIABLE, span, message)
                .help(format!("give \"{name}\" among the variables of the control file, or with --variable")));
        };
        self.variables.assign(target, Val::Number(value), span)
    }

    /// A program that is not there: refused, or left out where the control says so. Where the tool then stands is not known.
    pub(super) fn missing(&mut self, name: &str, span: Span) -> Result<(), Fault> {
        if !self.leave_out(name) {
            let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
            return Err(Fault::new(codes::SUBPROGRAM, span, format!("the program `{name}` is not there"))
                .help(format!("put {stem}.H into the folder of the program")));
        }
        self.modal.tangent = None;
        Ok(())
    }
}
