//! Words defined by a control file.

use super::block::is_function;
use super::interpreter::missing_subprogram;
use super::pending::Pending;
use super::run_state::Interpreter;
use crate::codes;
use crate::control::Meaning;
use crate::control::words::{Builtin, ListedWord};
use crate::diagnostic::{Fault, Span};
use crate::dialect::listed::{refused_by, unlisted};

/// Codes of control file words among the functions start at this number, ordered by their place in
/// its table.
pub(super) const LISTED: u32 = 2_000_000_000;

impl Interpreter {
    /// An M word: of the control file, or else of the reader.
    pub(super) fn m_word(&mut self, p: &mut Pending, code: u32, span: Span) -> Result<(), Fault> {
        if let Some((at, listed)) = self.settings.control.words.m(code) {
            let listed = listed.clone();
            return self.listed_word(p, at, &listed, span);
        }
        if self.settings.control.refuses_unlisted && !is_function(code) {
            return Err(unlisted(&self.settings.control, &format!("M{code}"), span));
        }
        p.functions.push(code);
        Ok(())
    }

    /// Collects a word of the control file.
    pub(super) fn listed_word(
        &mut self,
        p: &mut Pending,
        at: usize,
        listed: &ListedWord,
        span: Span,
    ) -> Result<(), Fault> {
        match &listed.meaning {
            Meaning::Does(words) => {
                for word in words {
                    match word {
                        Builtin::G(code) => self.own_g(p, code.0, span)?,
                        Builtin::M(code) => p.functions.push(*code),
                    }
                }
            }
            Meaning::Refuse(remedy) => return Err(refused_by(&self.settings.control, &listed.word, span, remedy)),
            Meaning::TcpOn | Meaning::TcpOff => {
                p.transformation = Some(listed.meaning == Meaning::TcpOn);
                p.transformation_word = Some(listed.word.clone());
            }
            Meaning::Call(name) => {
                if p.listed_call.replace(name.to_ascii_uppercase()).is_some() {
                    let message = format!("`{}` is the second call of the block", listed.word);
                    return Err(Fault::new(codes::CONFLICT, span, message).help("write it in a block of its own"));
                }
            }
            _ => p.functions.push(LISTED + at as u32),
        }
        Ok(())
    }

    /// A subprogram that does not exist: refused, or skipped where the control file says so. The
    /// tool position is then unknown.
    pub(super) fn missing(&mut self, name: &str, span: Span) -> Result<(), Fault> {
        if !self.leave_out(name) {
            return Err(missing_subprogram(name, span));
        }
        self.own.tangent = None;
        Ok(())
    }
}
