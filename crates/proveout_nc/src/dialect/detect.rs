//! Detects the language of a program.

use std::path::Path;

use crate::settings::Dialect;

/// Lines that are looked at.
const LINES: usize = 200;

/// Detects the dialect from the ending of the name, then from the text; [`Dialect::Auto`] where
/// neither decides.
///
/// ```
/// use proveout_nc::{Dialect, detect};
///
/// assert_eq!(detect("housing.h", ""), Dialect::Heidenhain); // by its ending
/// assert_eq!(detect("housing.txt", "N10 TRAORI\n"), Dialect::Siemens840d); // by its text
/// assert_eq!(detect("housing.txt", "%\nO1234\nG21\n"), Dialect::Iso);
/// assert_eq!(Dialect::from_name("klartext"), Some(Dialect::Heidenhain));
/// ```
pub fn detect(name: &str, text: &str) -> Dialect {
    let ending = Path::new(name).extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("mpf" | "spf" | "arc") => return Dialect::Siemens840d,
        Some("h") => return Dialect::Heidenhain,
        Some("i") => return Dialect::HeidenhainIso,
        Some("apt" | "cls" | "cl" | "aptsource") => return Dialect::Apt,
        Some("ngc") => return Dialect::LinuxCnc,
        _ => {}
    }
    from_text(text)
}

fn from_text(text: &str) -> Dialect {
    const SIEMENS: [&str; 11] =
        ["%_N_", ";$PATH", "DEF REAL", "DEF INT", "TRAORI", "TRAFOOF", "CYCLE8", "SUPA", "G710", "AROT ", "MSG("];
    const APT: [&str; 11] = [
        "GOTO/", "GOTO /", "PARTNO", "FEDRAT", "LOADTL", "SPINDL", "MULTAX", "CUTTER/", "CUTTER /", "UNITS/", "UNITS /",
    ];
    for line in text.lines().take(LINES) {
        let line = line.trim_start().to_ascii_uppercase();
        let code = line.split(';').next().unwrap_or_default();
        if SIEMENS.iter().any(|mark| line.starts_with(mark) || code.contains(mark)) {
            return Dialect::Siemens840d;
        }
        let words = code.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ');
        if words.starts_with("BEGIN PGM") {
            return Dialect::Heidenhain;
        }
        if APT.iter().any(|mark| code.starts_with(mark)) || line.starts_with("$$") {
            return Dialect::Apt;
        }
        if let Some(name) = line.strip_prefix('%') {
            // A TNC writes `%NAME G71 *`; ISO controls leave the rest of the line empty or write a number or
            // a comment.
            return if name.contains('*') { Dialect::HeidenhainIso } else { Dialect::Iso };
        }
        if line.strip_prefix('O').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit())) {
            return Dialect::Iso;
        }
    }
    let first = |line: &str| {
        let line = line.trim_start().to_ascii_uppercase();
        line.starts_with('(') || word(&line, 'G') || word(&line, 'N')
    };
    if text.lines().take(LINES).any(first) { Dialect::Iso } else { Dialect::Auto }
}

/// The line starts with a word of this letter.
fn word(line: &str, letter: char) -> bool {
    line.strip_prefix(letter).is_some_and(|rest| rest.trim_start().starts_with(|c: char| c.is_ascii_digit()))
}
