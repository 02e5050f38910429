//! Fills templates, and keeps a page from doing more than to show: a content security policy, and text
//! without characters that steer.

use minijinja::{Environment, Value};
use proveout_sim::digest::sha256;

use crate::{error::RecordError, page_encoding::base64};

/// A page from a template whose name ends in `.html`, which turns escaping on.
///
/// # Errors
/// [`RecordError::Page`] when the template does not fit its data, which is a fault of this crate.
pub(crate) fn fill(name: &str, template: &str, data: impl Into<Value>) -> Result<String, RecordError> {
    let page = Environment::new().render_named_str(name, template, data);
    page.map(strip_control_chars).map_err(|e| RecordError::Page { message: format!("{e:#}") })
}

/// The policy of a page with these scripts, in the exact text of the page: nothing is loaded, and no other
/// script runs.
pub(crate) fn policy(scripts: &[&str]) -> String {
    let scripts: Vec<String> = scripts.iter().map(|s| format!("'sha256-{}'", base64(&sha256(s.as_bytes())))).collect();
    format!(
        "default-src 'none'; script-src {}; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'",
        scripts.join(" ")
    )
}

/// A page with control characters and those that turn the direction of text (Unicode, UAX 9) replaced.
pub(crate) fn strip_control_chars(page: String) -> String {
    let steers = |c: char| {
        c.is_control() && !matches!(c, '\n' | '\t' | '\r')
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if page.contains(steers) { page.replace(steers, "\u{fffd}") } else { page }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_hold_nothing_that_steers() {
        assert_eq!(strip_control_chars("a\u{1b}[2J\u{202e}b\n\tc".into()), "a\u{fffd}[2J\u{fffd}b\n\tc");
    }

    #[test]
    fn the_policy_names_each_script_by_its_digest() {
        // SHA-256 of nothing (FIPS 180-4).
        assert!(policy(&[""]).contains("'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"));
    }
}
