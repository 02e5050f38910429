//! Functions defined by a control file, and its statements about the data of the control.

use super::functions::refused_function;
use super::run_state::Interpreter;
use super::variables::Val;
use super::words::{Block, MWord, Param, Value};
use crate::codes;
use crate::control::Meaning;
use crate::control::words::{Builtin, ListedWord};
use crate::diagnostic::{Fault, Span};
use crate::machine_data::KinematicsKind;
use crate::{SpindleDirection, ToolName};

/// Codes of control file functions start at this number, ordered by their place in its table.
pub(super) const LISTED: u32 = 4_000_000_000;
/// Numbers of system data from here on are none.
const SYSTEM_NUMBERS: f64 = 1e6;

impl Interpreter {
    /// Replaces functions by what the control file defines for them, and refuses those that are not
    /// valid on any machine.
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

    /// Executes a function of the control file.
    pub(super) fn act_listed(&mut self, code: u32, span: Span) -> Result<(), Fault> {
        let at = code.saturating_sub(LISTED) as usize;
        let Some(ListedWord { word, meaning, .. }) = self.settings.control.words.at(at).cloned() else { return Ok(()) };
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

    /// FN 18: SYSREAD: a value that the control file or the settings give under `ID270 NR1 IDX1`, or one that
    /// the program itself has set.
    pub(super) fn system_read(&mut self, target: Param, from: &[Option<Value>; 3], span: Span) -> Result<(), Fault> {
        let mut name = String::new();
        let mut numbers = [None; 3];
        for ((value, word), slot) in from.iter().zip(["ID", "NR", "IDX"]).zip(&mut numbers) {
            let Some(value) = value else { continue };
            let number = self.variables.value(*value, span)?;
            *slot = Some(number);
            let blank = if name.is_empty() { "" } else { " " };
            name.push_str(&format!("{blank}{word}{number}"));
        }
        let Some(value) = self.variables.given(&name).or_else(|| self.system_value(numbers)) else {
            let message = format!("FN 18 reads {name} of the control, and its value is not known");
            return Err(Fault::new(codes::UNKNOWN_VARIABLE, span, message)
                .help(format!("give \"{name}\" among the variables of the control file, or with --variable"))
                .of_variable(name));
        };
        self.variables.assign(target, Val::Number(value), span)
    }

    /// System data that follow from the program. Numbers after HEIDENHAIN, *TNC 640 Klartext programming*,
    /// "Reading system data": 20 state of the machine, 270 position in the active coordinate system.
    fn system_value(&self, [id, number, index]: [Option<f64>; 3]) -> Option<f64> {
        let whole = |value: Option<f64>| {
            value.filter(|v| v.fract() == 0.0 && (0.0..SYSTEM_NUMBERS).contains(v)).map(|v| v as u32)
        };
        let technology = &self.technology;
        match (whole(id)?, whole(number)?) {
            (20, 1) => match technology.in_spindle.as_ref()? {
                ToolName::Number(number) => Some(f64::from(*number)),
                ToolName::Empty => Some(0.0),
                ToolName::Name(_) => None,
            },
            (20, 3) => self.modal.plane_told.then_some(self.modal.normal as f64),
            (20, 4) => technology.speed,
            (20, 5) => Some(match technology.direction {
                SpindleDirection::Clockwise => 0.0,
                SpindleDirection::CounterClockwise => 1.0,
                // Whether M3 or M4 stood before M5 is not kept.
                SpindleDirection::Off => return None,
            }),
            (20, 8) => Some(f64::from(u8::from(technology.flood))),
            (270, 1) => {
                let axis = (whole(index)? as usize).checked_sub(1).filter(|axis| *axis < 9)?;
                let value = self.position.work.get(axis)?;
                Some(if (3..6).contains(&axis) { value.to_degrees() } else { value / self.modal.unit() })
            }
            _ => None,
        }
    }

    /// A program that does not exist: refused, or skipped where the control file says so. The tool
    /// position is then unknown.
    pub(super) fn missing(&mut self, name: &str, span: Span) -> Result<(), Fault> {
        if !self.leave_out(name) {
            let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
            return Err(Fault::new(codes::SUBPROGRAM, span, format!("program `{name}` not found"))
                .help(format!("put {stem}.H into the folder of the program")));
        }
        self.modal.tangent = None;
        Ok(())
    }
}
