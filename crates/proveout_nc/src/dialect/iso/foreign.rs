//! Lines that no ISO control of the reader knows, and the control whose words they look like: told with the fault.

use crate::scan::Scanner;

/// Words at the begin of a line, in upper case, with the control that has them. A blank in a word stands for any number of them.
const WORDS: [(&str, &str); 20] = [
    ("BEGIN PGM", "Heidenhain Klartext"),
    ("BLK FORM", "Heidenhain Klartext"),
    ("CYCL DEF", "Heidenhain Klartext"),
    ("TOOL CALL", "Heidenhain Klartext"),
    ("CALL O", "Okuma OSP"),
    ("DEF WORK", "Okuma OSP"),
    ("MODIN", "Okuma OSP"),
    ("MODOUT", "Okuma OSP"),
    ("NCYL", "Okuma OSP"),
    ("NOEX", "Okuma OSP"),
    ("VC", "Okuma OSP"),
    ("VZOF", "Okuma OSP"),
    ("CYCLE8", "Siemens 840D"),
    ("MSG(", "Siemens 840D"),
    ("SUPA", "Siemens 840D"),
    ("TRAFOOF", "Siemens 840D"),
    ("TRAORI", "Siemens 840D"),
    ("FEDRAT", "APT CL data"),
    ("GOTO/", "APT CL data"),
    ("LOADTL", "APT CL data"),
];

/// The control whose words the line begins with, behind its block number.
pub(super) fn looks_like(line: &str) -> Option<&'static str> {
    let mut s = Scanner::new(line);
    s.skip_blanks();
    // The first line of a program: `$NAME.MIN%`.
    if s.peek() == b'$' && line.trim_end().ends_with('%') {
        return Some("Okuma OSP");
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
    fn words_of_other_controls_are_told() {
        for (line, want) in [
            ("12 TOOL  CALL 5 Z S100", Some("Heidenhain Klartext")),
            ("N10 CALL O1234", Some("Okuma OSP")),
            ("NOEX VC1=5", Some("Okuma OSP")),
            ("$PART.MIN%", Some("Okuma OSP")),
            ("N5 NCYL G81 Z-5", Some("Okuma OSP")),
            ("N5 TRAORI", Some("Siemens 840D")),
            ("GOTO/1,2,3", Some("APT CL data")),
            ("N10 G1 X5", None),
            ("", None),
        ] {
            assert_eq!(looks_like(line), want, "{line}");
        }
    }
}
