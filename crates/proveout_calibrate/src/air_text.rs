//! The text of an air program in the languages of four controls.
//!
//! Every block names one axis in machine coordinates and is followed by a dwell. Where a language has no feed
//! in machine coordinates (G53 of an ISO control), moves are increments from a place that G53 has reached.

use std::fmt::Write as _;

use proveout_machine::Machine;
use proveout_nc::Dialect;

use crate::air_program::{AirProgram, AirStep, PlanError, REST_S};

/// Words of a language.
enum Language {
    Siemens,
    Heidenhain,
    /// Dwell, and whether a feed of a rotary axis alone is degrees a minute.
    Iso {
        dwell: &'static str,
        rotary_feed: bool,
    },
}

impl AirProgram {
    /// The program text.
    ///
    /// # Errors
    /// [`PlanError`] for a language that has no text here.
    pub fn text(&self, machine: &Machine, dialect: Dialect) -> Result<(String, Vec<String>), PlanError> {
        let language = match dialect {
            Dialect::Siemens840d => Language::Siemens,
            Dialect::Heidenhain => Language::Heidenhain,
            // P of a Fanuc counts milliseconds and takes no point; X counts seconds.
            Dialect::Fanuc | Dialect::Iso => Language::Iso { dwell: "G4 X", rotary_feed: true },
            Dialect::Haas => Language::Iso { dwell: "G4 P", rotary_feed: false },
            Dialect::LinuxCnc => Language::Iso { dwell: "G4 P", rotary_feed: true },
            Dialect::HeidenhainIso | Dialect::Apt | Dialect::Auto => {
                let message = format!("there is no air program in the language {}", dialect.name());
                let help = "name one of siemens-840d, heidenhain, fanuc, haas, linuxcnc";
                return Err(PlanError::new(message, help));
            }
        };
        let mut notes = self.notes.clone();
        let mut out = Writer { machine, language: &language, text: String::new(), line: 0, at: Vec::new() };
        out.head(self);
        for &joint in &self.order {
            out.send_home(joint);
        }
        let mut left_out = Vec::new();
        for step in &self.steps {
            let Some(joint) = machine.joints.get(step.joint) else { continue };
            let untold = matches!(language, Language::Iso { rotary_feed: false, .. });
            if step.feed.is_some() && joint.is_rotary() && untold {
                if !left_out.contains(&joint.name) {
                    left_out.push(joint.name.clone());
                }
                continue;
            }
            out.step(step);
        }
        for name in left_out {
            notes.push(format!(
                "{name}: no moves in feed, since setting 34 of the control says what a feed of it counts; its friction stays unknown"
            ));
        }
        out.end();
        Ok((out.text, notes))
    }
}

struct Writer<'a> {
    machine: &'a Machine,
    language: &'a Language,
    text: String,
    line: usize,
    /// Places of the joints, mm or degrees.
    at: Vec<f64>,
}

/// A number with the digits it needs, and a point.
fn number(v: f64) -> String {
    let text = format!("{v:.3}");
    let short = text.trim_end_matches('0');
    if short == "-0." { "0.".to_owned() } else { short.to_owned() }
}

impl Writer<'_> {
    fn block(&mut self, words: &str) {
        match self.language {
            Language::Heidenhain => {
                let _ = writeln!(self.text, "{} {words}", self.line);
                self.line += 1;
            }
            _ => {
                self.text.push_str(words);
                self.text.push('\n');
            }
        }
    }

    fn head(&mut self, program: &AirProgram) {
        self.at = self.machine.joints.iter().map(|j| j.kind.in_unit(j.home)).collect();
        let name: String = self.machine.name.chars().filter(|c| !"()\"".contains(*c) && !c.is_control()).collect();
        let words = format!("AIR PROGRAM FOR {name}: EACH AXIS ALONE, NO TOOL, NO PART NEEDED");
        match self.language {
            Language::Siemens => {
                self.block(&format!("; {words}"));
                self.block("G71 G90 G94 G40 G60 D0");
            }
            Language::Heidenhain => {
                self.block("BEGIN PGM AIR MM");
                self.block(&format!("; {words}"));
            }
            Language::Iso { .. } => {
                self.block("%");
                self.block("O9001");
                self.block(&format!("({words})"));
                self.block("G21 G90 G94 G17 G40 G49 G80");
            }
        }
        for note in &program.notes {
            let note: String = note.chars().filter(|c| !"()".contains(*c)).collect();
            match self.language {
                Language::Iso { .. } => self.block(&format!("({note})")),
                _ => self.block(&format!("; {note}")),
            }
        }
    }

    fn letter(&self, joint: usize) -> &str {
        self.machine.joints.get(joint).map_or("", |j| j.name.as_str())
    }

    fn dwell(&mut self) {
        match self.language {
            Language::Siemens => self.block(&format!("G4 F{REST_S}")),
            Language::Heidenhain => {
                self.block("CYCL DEF 9.0 DWELL TIME");
                self.block(&format!("CYCL DEF 9.1 DWELL {REST_S}"));
            }
            Language::Iso { dwell, .. } => self.block(&format!("{dwell}{REST_S}")),
        }
    }

    /// Home at rapid rate, in machine coordinates.
    fn send_home(&mut self, joint: usize) {
        let Some(to) = self.machine.joints.get(joint).map(|j| j.kind.in_unit(j.home)) else { return };
        let (letter, to) = (self.letter(joint).to_owned(), number(to));
        match self.language {
            Language::Siemens => self.block(&format!("SUPA G0 {letter}{}", to.trim_end_matches('.'))),
            Language::Heidenhain => self.block(&format!("L {letter}{} R0 FMAX M91", signed(&to))),
            Language::Iso { .. } => self.block(&format!("G90 G53 G0 {letter}{to}")),
        }
        self.dwell();
    }

    fn step(&mut self, step: &AirStep) {
        let letter = self.letter(step.joint).to_owned();
        let before = self.at.get(step.joint).copied().unwrap_or(0.0);
        let to = number(step.to);
        match (self.language, step.feed) {
            (Language::Siemens, None) => self.block(&format!("SUPA G0 {letter}{}", to.trim_end_matches('.'))),
            (Language::Siemens, Some(f)) => {
                self.block(&format!(
                    "SUPA G1 {letter}{} F{}",
                    to.trim_end_matches('.'),
                    number(f).trim_end_matches('.')
                ));
            }
            (Language::Heidenhain, None) => self.block(&format!("L {letter}{} R0 FMAX M91", signed(&to))),
            (Language::Heidenhain, Some(f)) => {
                self.block(&format!("L {letter}{} R0 F{} M91", signed(&to), number(f).trim_end_matches('.')));
            }
            (Language::Iso { .. }, None) => self.block(&format!("G91 G0 {letter}{}", number(step.to - before))),
            (Language::Iso { .. }, Some(f)) => {
                self.block(&format!("G91 G1 {letter}{} F{}", number(step.to - before), number(f)));
            }
        }
        if let Some(at) = self.at.get_mut(step.joint) {
            *at = step.to;
        }
        self.dwell();
    }

    fn end(&mut self) {
        match self.language {
            Language::Siemens => self.block("M30"),
            Language::Heidenhain => {
                self.block("M30");
                self.block("END PGM AIR MM");
            }
            Language::Iso { .. } => {
                self.block("G90");
                self.block("M30");
                self.block("%");
            }
        }
    }
}

/// With the sign that Klartext writes, and without a bare point.
fn signed(number: &str) -> String {
    let number = number.trim_end_matches('.');
    if number.starts_with('-') { number.to_owned() } else { format!("+{number}") }
}
