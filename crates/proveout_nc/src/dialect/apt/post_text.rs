//! `INSERT`, `PPWORD` and `PPFUN`: text that is meant for one post-processor or control.
//!
//! `INSERT` goes into the program of the control unchanged. Comments, and what `CAMWorks` writes
//! about tool and stock, have no effect. Words of a control (`G68.2 X0`, `M8`) would move it or
//! change what follows, and are refused. Only its post-processor knows the effect of any other
//! text: it is not followed, and an assumption says so.

use super::reader::AptReader;
use super::statement::{AptStatement, Bad};
use super::technology::unquoted;
use crate::codes;
use crate::source::Source;

impl AptReader {
    pub(crate) fn post_text(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let text = unquoted(st.literal.text(source)).to_owned();
        let body = text.trim().trim_end_matches('$').trim();
        let word = &st.major;
        if is_comment(body) {
            self.note(format!("{word} {body}"));
        } else if is_block(body) {
            return Err(st.head.bad(
                codes::UNSUPPORTED_WORD,
                format!("`{word} {body}` is not supported: its text is meant for one control"),
                "write what it does in words of CL data, or remove it for the prove-out",
            ));
        } else {
            self.assume(format!("`{word} {body}` is text for the post-processor: its effect is not simulated"));
        }
        Ok(())
    }
}

/// Comments of controls, and what `CAMWorks` says about the tool of an operation and the size of the stock.
fn is_comment(text: &str) -> bool {
    text.is_empty()
        || text.starts_with([';', '*', '!'])
        || text.starts_with('(') && text.ends_with(')')
        || text.starts_with("[HOLDER=")
        || text.starts_with("Stock Size ")
}

/// Only words of a control: letters with a number in sequence, or a call.
fn is_block(text: &str) -> bool {
    let mut words = 0;
    let mut bytes = text.bytes().filter(|b| !b.is_ascii_whitespace()).peekable();
    while let Some(byte) = bytes.next() {
        if !byte.is_ascii_alphabetic() && byte != b'#' {
            return false;
        }
        let mut digits = 0;
        while let Some(next) = bytes.next_if(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b'=')) {
            digits += u32::from(next.is_ascii_digit());
        }
        if digits == 0 {
            return false;
        }
        words += 1;
    }
    words > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_control_are_distinguished_from_text() {
        for text in ["G54", "M8", "G0 X-10. Y20", "N10G68.2X0Y0Z0I90.", "#100=5", "T1 M6"] {
            assert!(is_block(text) && !is_comment(text), "{text}");
        }
        for text in ["20MM CRB 2FL", "STOP TURN THE PART", "10", "X"] {
            assert!(!is_block(text) && !is_comment(text), "{text}");
        }
        for text in ["(G0 X5)", "; note", "[HOLDER=C40-M20EM3] 20MM CRB", "Stock Size X50. Y100. Z60.", ""] {
            assert!(is_comment(text), "{text}");
        }
    }
}
