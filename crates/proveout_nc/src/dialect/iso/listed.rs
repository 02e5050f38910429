//! Words whose meaning a control file gives.

use super::calls::whole;
use super::modal::{MotionMode, Plane};
use super::parser::IsoBlock;
use super::pending::{Full, Pending};
use super::run_state::Interpreter;
use super::statement::OLabel;
use crate::codes;
use crate::control::Meaning;
use crate::control::words::{Builtin, ListedWord};
use crate::diagnostic::{Fault, Span};
use crate::dialect::listed::refused_by;
use crate::g_code::G53;
use crate::machine_data::KinematicsKind;

/// Words of the control file are kept among the functions, from this number on by their place in
/// its table.
pub(crate) const LISTED: u32 = 2_000_000_000;

impl Interpreter {
    /// Collects a word of the control file.
    pub(super) fn put_listed(&self, p: &mut Pending, at: usize, listed: &ListedWord, span: Span) -> Result<(), Fault> {
        match &listed.meaning {
            Meaning::Does(words) => words.iter().try_for_each(|word| match word {
                Builtin::G(code) => self.put_g(p, *code, span),
                Builtin::M(code) => self.put_m(p, *code, span),
            }),
            Meaning::Refuse(remedy) => Err(refused_by(&self.settings.control, &listed.word, span, remedy)),
            _ => p.put_m(LISTED + at as u32).map_err(|Full| {
                Fault::new(codes::BAD_VALUE, span, "the block has too many M words").help("write several blocks")
            }),
        }
    }

    fn listed(&self, m: u32) -> Option<&ListedWord> {
        self.settings.control.words.at(m.checked_sub(LISTED)? as usize)
    }

    /// Does a word of the control file, as far as it acts before the motion of its block.
    pub(super) fn listed_word(&mut self, m: u32, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(ListedWord { word, meaning, values }) = self.listed(m).cloned() else { return Ok(()) };
        let mut shown = String::new();
        for letter in values {
            if p.any_free(&[letter])
                && let Some(value) = p.take(letter)
            {
                shown.push_str(&format!(" {}{value}", char::from(letter)));
            }
        }
        match meaning {
            Meaning::TcpOn => self.listed_tcp(&word, true, span)?,
            Meaning::TcpOff => self.listed_tcp(&word, false, span)?,
            Meaning::Offset(letter) => self.listed_offset(&word, letter, p, span)?,
            Meaning::OffsetOnce(letter) => self.listed_offset_once(&word, letter, p, span)?,
            // Calls follow the motion.
            _ => self.tell_listed((m - LISTED) as usize, &shown),
        }
        Ok(())
    }

    /// The work offset whose number another word gives.
    fn listed_offset(&mut self, word: &str, letter: u8, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let number = offset_number(word, letter, p, span)?;
        if number == 0 {
            let message = format!(
                "`{word} {}0` makes machine coordinates those of the program: it is not supported",
                char::from(letter)
            );
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help("call a work offset from 1 on"));
        }
        let offset = if number <= 6 { format!("G{}", 53 + number) } else { format!("G54.1 P{}", number - 6) };
        self.call_offset(offset, span)
    }

    /// Machine coordinates for the block, where the number is zero.
    fn listed_offset_once(&mut self, word: &str, letter: u8, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let number = offset_number(word, letter, p, span)?;
        if number != 0 {
            let message = format!("`{word} {}{number}` is not supported", char::from(letter));
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message)
                .help("program the position in the work offset in force"));
        }
        if self.modal.motion != Some(MotionMode::Rapid) {
            return Err(Fault::new(codes::CONFLICT, span, format!("machine coordinates of {word} need G0 in force"))
                .help("write G0 in its block"));
        }
        self.put_g(p, G53, span)
    }

    fn listed_tcp(&mut self, word: &str, on: bool, span: Span) -> Result<(), Fault> {
        self.forget_kept();
        if on {
            self.settings.check_kinematics(KinematicsKind::Tcp, word, span)?;
            if self.has_programmed_length() {
                let message = format!("{word} with a length that the program writes itself is not supported");
                return Err(
                    Fault::new(codes::UNSUPPORTED_WORD, span, message).help("give the length in the tool library")
                );
            }
            if self.modal.plane == Plane::Dynamic {
                return Err(Fault::new(codes::CONFLICT, span, format!("{word} while G254 is in force"))
                    .help("write G255 before it"));
            }
        }
        self.set_tcp(on, false);
        Ok(())
    }

    /// A word that calls a macro takes the whole block; true where the block has one.
    pub(super) fn listed_macro(&mut self, p: &mut Pending, block: &IsoBlock) -> Result<bool, Fault> {
        let found = p.m().iter().find_map(|&m| self.listed(m).filter(|l| matches!(l.meaning, Meaning::Macro(_))));
        let Some(ListedWord { word, meaning: Meaning::Macro(program), values }) = found.cloned() else {
            return Ok(false);
        };
        if self.own.flavor.is_linuxcnc() {
            self.listed_o_sub(&word, &program, &values, p, block.span)?;
            return Ok(true);
        }
        p.use_all();
        self.call_macro(number_of(&program), &word, block)?;
        Ok(true)
    }

    /// As a remapped word (`LinuxCNC`, "Remap: extending G-code", `ngc=` with `argspec=`): the
    /// letters of the block are local named parameters of the subprogram, `#<p>` for P.
    fn listed_o_sub(
        &mut self,
        word: &str,
        label: &str,
        letters: &[u8],
        p: &mut Pending,
        span: Span,
    ) -> Result<(), Fault> {
        if !p.no_g() || p.m().len() > 1 {
            let message = format!("{word} calls the subprogram o{label}, and its block has other G or M words");
            return Err(Fault::new(codes::CONFLICT, span, message).help("write it in a block of its own"));
        }
        let values: Vec<(u8, f64)> = letters.iter().filter_map(|&letter| Some((letter, p.take(letter)?))).collect();
        let depth = self.depth();
        self.call_o_sub(&OLabel::Fixed(label.to_owned()), &[], span)?;
        if self.depth() > depth {
            for (letter, value) in values {
                self.variables.set_named(&char::from(letter).to_ascii_lowercase().to_string(), value);
            }
        }
        Ok(())
    }

    /// A word that calls a subprogram does so after the motion of its block.
    pub(super) fn listed_call(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let found = p.m().iter().find_map(|&m| match &self.listed(m)?.meaning {
            Meaning::Call(program) => Some(number_of(program)),
            _ => None,
        });
        match found {
            Some(program) => self.call_sub(Some(program), Some(1.0), span),
            None => Ok(()),
        }
    }

    /// A subprogram that does not exist: refused, or left out where the control says so. The
    /// position after the call is unknown.
    pub(crate) fn missing(&mut self, name: &str, span: Span) -> Result<(), Fault> {
        if !self.leave_out(name) {
            return Err(super::calls::missing(name, self.own.flavor, span));
        }
        self.own.feed = None;
        Ok(())
    }
}

/// Number of a work offset in the word of this letter.
fn offset_number(word: &str, letter: u8, p: &mut Pending, span: Span) -> Result<u32, Fault> {
    let shown = char::from(letter);
    let number = p.take(letter).ok_or_else(|| {
        Fault::new(codes::MISSING_VALUE, span, format!("{word} has no {shown}")).help(format!("write {word} {shown}1"))
    })?;
    whole(number, &shown.to_string(), 300.0, span)
}

/// The control file allows digits only.
fn number_of(program: &str) -> f64 {
    program.parse().unwrap_or(0.0)
}
