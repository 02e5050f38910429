//! Lines of a grbl that begin with `$`: read where the control file says `program.words = "grbl"`.
//!
//! After grbl 1.1, wiki page "Grbl v1.1 Commands": `$H` homes the machine, `$X` clears an alarm, `$$ $# $G $I
//! $N` print, `$C` checks. `$J=` jogs and settings (`$32=1`) are no part of a program: they are refused. The
//! homing cycle runs Z first, then the other axes (`HOMING_CYCLE_0`, `HOMING_CYCLE_1` of config.h), to the
//! place that the switches have.

use super::grbl_words;
use super::parser::IsoBlock;
use super::run_state::Interpreter;
use crate::codes;
use crate::control::Control;
use crate::diagnostic::{Fault, Span};

/// Lines without an effect on what is cut.
const WITHOUT_EFFECT: [&str; 7] = ["$X", "$$", "$#", "$G", "$I", "$N", "$C"];

/// Refuses a line with `$` on a control that has none, and on a grbl one that it does not know.
pub(super) fn refused(block: &IsoBlock, control: &Control) -> Option<Fault> {
    if control.grbl_words {
        return grbl_words::foreign(block, control);
    }
    let span = block.dollar?;
    Some(
        Fault::new(codes::UNSUPPORTED_WORD, span, "`$` begins a line of a grbl, which this control is not")
            .help("name that control (grbl-1.1), or remove the line"),
    )
}

impl Interpreter {
    pub(super) fn dollar(&mut self, text: &str, span: Span) -> Result<(), Fault> {
        if WITHOUT_EFFECT.contains(&text) {
            self.note(text);
            return Ok(());
        }
        if text == "$H" {
            return self.home(span);
        }
        let what = if text.starts_with("$J=") {
            "jogs the machine"
        } else if text.contains('=') {
            "changes a setting of the machine"
        } else {
            "is not read"
        };
        Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`{text}` {what}"))
            .help("remove the line: it is a command to send by hand"))
    }
}
