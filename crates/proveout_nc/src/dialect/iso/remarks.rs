//! Parameters in the comments of a `LinuxCNC` that speak: `(DEBUG, #1)`, `(PRINT, #<name>)`, `(LOG, ..)`
//! (*G-code overview*, "Debug messages": every `#` with its name is replaced by its value).

use super::expr;
use super::run_state::Interpreter;
use crate::diagnostic::Span;
use crate::scan::Scanner;

impl Interpreter {
    /// The text with the values of its parameters; one that has none is `######`, as the control shows it.
    pub(crate) fn expanded(&self, text: &str, span: Span) -> String {
        let mut s = Scanner::new(text);
        let mut out = String::with_capacity(text.len());
        while !s.at_end() {
            let start = s.pos();
            if s.peek() != b'#' {
                s.bump();
                out.push_str(s.slice(start));
                continue;
            }
            let value =
                expr::parameter(&mut s, self.own.flavor).ok().and_then(|read| self.value(&read, span).ok().flatten());
            match value {
                Some(value) => out.push_str(&format!("{value:.6}")),
                None => out.push_str("######"),
            }
            if s.pos() == start {
                s.bump();
            }
        }
        out
    }
}
