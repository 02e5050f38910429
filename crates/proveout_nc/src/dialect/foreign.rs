//! Lines that a reader does not know, and the control whose words they look like: named in the
//! fault.

use crate::diagnostic::Fault;
use crate::scan::Scanner;

pub(super) const KLARTEXT: &str = "Heidenhain Klartext";
pub(super) const SIEMENS: &str = "Siemens 840D";
const OSP: &str = "Okuma OSP";
const APT: &str = "APT CL data";
const FAGOR_8065: &str = "a Fagor 8060 or 8065, whose statements are not read";
const NCI: &str = "an NCI listing of Mastercam (lines of numbers only)";
const ISO: &str = "ISO code of a Fanuc or its like";

/// Words at the start of a line, in upper case, with the control that has them. A blank in a word
/// matches any number of blanks.
const WORDS: [(&str, &str); 35] = [
    ("BEGIN PGM", KLARTEXT),
    ("BLK FORM", KLARTEXT),
    ("CYCL DEF", KLARTEXT),
    ("TOOL CALL", KLARTEXT),
    ("CALL O", OSP),
    ("DEF WORK", OSP),
    ("MODIN", OSP),
    ("MODOUT", OSP),
    ("NCYL", OSP),
    ("NOEX", OSP),
    ("VC", OSP),
    ("VZOF", OSP),
    ("CYCLE8", SIEMENS),
    ("MSG(", SIEMENS),
    ("SUPA", SIEMENS),
    ("TRAFOOF", SIEMENS),
    ("TRAORI", SIEMENS),
    ("FEDRAT", APT),
    ("GOTO/", APT),
    ("LOADTL", APT),
    ("#ACS ", FAGOR_8065),
    ("#COMMENT", FAGOR_8065),
    ("#CS ", FAGOR_8065),
    ("#HSC ", FAGOR_8065),
    ("#KIN ", FAGOR_8065),
    ("#MSG", FAGOR_8065),
    ("#RTCP", FAGOR_8065),
    ("#TLC", FAGOR_8065),
    ("#TOOL", FAGOR_8065),
    ("$ELSE", FAGOR_8065),
    ("$END", FAGOR_8065),
    ("$FOR", FAGOR_8065),
    ("$GOTO", FAGOR_8065),
    ("$IF", FAGOR_8065),
    ("$WHILE", FAGOR_8065),
];

/// The fault of a line, with the control that the line looks like where that is another than the one that
/// reads it.
pub(super) fn told(fault: Fault, line: &str, reader: &str) -> Fault {
    match looks_like(line).or_else(|| looks_iso(line)) {
        Some(control) if control != reader => fault.help(named(control)),
        _ => fault,
    }
}

/// What to do with a line of another control.
pub(super) fn named(control: &str) -> String {
    if control == FAGOR_8065 {
        return format!(
            "this looks like {control}: post the program for a Fagor 8055 (--control fagor-8055) or a Fanuc"
        );
    }
    format!("this looks like {control}: name that dialect, or post for this control")
}

/// `O1000`, `%`, `#1=`, `(text)` or a G word: what a program of a Fanuc begins with.
fn looks_iso(line: &str) -> Option<&'static str> {
    let line = line.trim();
    let next_is_digit = line.as_bytes().get(1).is_some_and(u8::is_ascii_digit);
    match line.bytes().next()? {
        b'%' => line.len() == 1,
        b'O' | b'G' | b'#' => next_is_digit,
        b'(' => line.ends_with(')'),
        _ => false,
    }
    .then_some(ISO)
}

/// The control whose words the line begins with, after its block number.
pub(super) fn looks_like(line: &str) -> Option<&'static str> {
    let mut s = Scanner::new(line);
    s.skip_blanks();
    // The first line of a program: `$NAME.MIN%`.
    if s.peek() == b'$' && line.trim_end().ends_with('%') {
        return Some(OSP);
    }
    let numbers = |text: &str| text.split_whitespace().all(|number| number.parse::<f64>().is_ok());
    if line.trim().len() > 3 && numbers(line) {
        return Some(NCI);
    }
    // `N10` or, in Klartext, a number alone; never the N of a word.
    if matches!(s.peek(), b'N' | b'n') && s.peek_at(1).is_ascii_digit() {
        s.bump();
    }
    s.integer();
    s.skip_blanks();
    let rest = line.get(s.pos()..)?.to_ascii_uppercase();
    let rest = rest.split_whitespace().collect::<Vec<_>>().join(" ");
    WORDS.iter().find(|(word, _)| rest.starts_with(word)).map(|(_, control)| *control)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_other_controls_are_reported() {
        for (line, want) in [
            ("12 TOOL  CALL 5 Z S100", Some("Heidenhain Klartext")),
            ("N10 CALL O1234", Some("Okuma OSP")),
            ("NOEX VC1=5", Some("Okuma OSP")),
            ("$PART.MIN%", Some("Okuma OSP")),
            ("N5 NCYL G81 Z-5", Some("Okuma OSP")),
            ("N5 TRAORI", Some("Siemens 840D")),
            ("GOTO/1,2,3", Some("APT CL data")),
            ("N10 #RTCP ON", Some("a Fagor 8060 or 8065, whose statements are not read")),
            ("$IF P1 > 3", Some("a Fagor 8060 or 8065, whose statements are not read")),
            ("#100=5", None),
            ("1050", Some(NCI)),
            ("2 0 10.5 0. -3. 250. 0", Some(NCI)),
            ("N10 G1 X5", None),
            ("", None),
        ] {
            assert_eq!(looks_like(line), want, "{line}");
        }
    }

    #[test]
    fn the_own_words_of_a_reader_are_no_hint() {
        let help = |line, reader| {
            let fault = Fault::new(crate::codes::SYNTAX, crate::diagnostic::Span::default(), "unexpected character");
            told(fault.help("own"), line, reader).help.unwrap_or_default()
        };
        assert!(help("0 BEGIN PGM A MM", SIEMENS).contains(KLARTEXT));
        assert!(help("O1000", KLARTEXT).contains("Fanuc"));
        assert!(help("#1=5", SIEMENS).contains("Fanuc"));
        for (line, reader) in [("CYCL DEF 9", KLARTEXT), ("MSG(\"a\"", SIEMENS), ("X10,5", SIEMENS), ("", KLARTEXT)] {
            assert_eq!(help(line, reader), "own", "{line}");
        }
    }
}
