//! Words of machine builders and of other controls that programs bring along, with their sources.
//!
//! A word of this table is still an assumption: the same number means something else on another machine.

use crate::settings::Dialect;

/// A word of this table.
pub(super) struct KnownWord {
    /// The language family in which programs bring it along.
    pub(super) family: Dialect,
    pub(super) word: &'static str,
    /// Key of its meaning in a control file, and the value.
    pub(super) means: (&'static str, &'static str),
    /// Letters of its block that belong to it.
    pub(super) values: &'static str,
    /// Whose word it is, with the source.
    pub(super) whose: &'static str,
}

const fn word(
    family: Dialect,
    word: &'static str,
    means: (&'static str, &'static str),
    values: &'static str,
    whose: &'static str,
) -> KnownWord {
    KnownWord { family, word, means, values, whose }
}

const ISO: Dialect = Dialect::Iso;
const TNC: Dialect = Dialect::Heidenhain;

/// The table.
pub(super) const KNOWN_WORDS: &[KnownWord] = &[
    word(
        TNC,
        "CYCL392",
        (
            "note",
            "ATC: tunes the drives to speed, surface or accuracy (Q240) and to the weight of the part (Q241); no axis moves",
        ),
        "",
        "it is the cycle ATC, Application Tuning Cycle, of DMG MORI machines: programs of posts for them call it with Q240 and Q241 before each tool",
    ),
    word(
        TNC,
        "CYCL332",
        ("note", "tuning of the drives; no axis moves"),
        "",
        "it is the cycle Tuning of DMG machines with a TNC, the one before ATC",
    ),
    word(
        ISO,
        "G187",
        ("note", "smoothness level and corner tolerance"),
        "PE",
        "it is the smoothness of a Haas (Mill Operator's Manual, G187 Accuracy Control)",
    ),
    word(
        ISO,
        "G50",
        ("ignore", "no scale is in force"),
        "",
        "it cancels a scale of G51 on a Fanuc and a PathPilot, and the text has no G51",
    ),
    word(
        ISO,
        "M128",
        ("kinematics", "tcp-on"),
        "",
        "it switches tool center point control on, as on a TNC and a Hurco (WinMax NC Programming, M128)",
    ),
    word(
        ISO,
        "M129",
        ("kinematics", "tcp-off"),
        "",
        "it switches tool center point control off, as on a TNC and a Hurco (WinMax NC Programming, M129)",
    ),
    word(
        ISO,
        "M428",
        ("kinematics", "tcp-on"),
        "",
        "it is the remap of the LinuxCNC configuration xyzbc-trt for tool center point kinematics (LinuxCNC 2.9, xyzbc-trt.txt)",
    ),
    word(
        ISO,
        "M429",
        ("kinematics", "tcp-off"),
        "",
        "it is the remap of the LinuxCNC configuration xyzbc-trt for identity kinematics (LinuxCNC 2.9, xyzbc-trt.txt)",
    ),
];

/// The row of a word in a language.
pub(super) fn known_word(dialect: Dialect, word: &str) -> Option<&'static KnownWord> {
    KNOWN_WORDS.iter().find(|known| known.family == dialect.family() && known.word == word)
}

/// Names of a Sinumerik, and major words of APT, that a name of a builder is not mistaken for.
const NAMES: [(Dialect, &[&str]); 2] = [
    (
        Dialect::Siemens840d,
        &[
            "TRAORI", "TRAFOOF", "TRANS", "ATRANS", "ROT", "AROT", "MIRROR", "AMIRROR", "SCALE", "ASCALE", "SUPA",
            "TRANSMIT", "TRACYL", "CFC", "CFIN", "CFTCP", "CDON", "CDOF", "NORM", "KONT", "ORIWKS", "ORIMKS",
            "ORIAXES", "ORIVECT", "BRISK", "SOFT", "DRIVE", "FFWON", "FFWOF", "COMPON", "COMPCAD", "COMPCURV",
            "COMPOF", "MCALL", "STOPRE", "REPEAT", "GOTOF", "GOTOB", "GOTO", "DIAMON", "DIAMOF", "TOROT", "TOFRAME",
            "BSPLINE", "CSPLINE", "ASPLINE", "POLY", "HOLES1", "HOLES2", "POCKET3", "POCKET4", "SLOT1", "SLOT2",
            "LONGHOLE", "ENDIF", "ENDWHILE", "ENDFOR", "WHILE", "UNTIL", "ELSE", "PROC",
        ],
    ),
    (
        Dialect::Apt,
        &[
            "GOTO", "GODLTA", "FEDRAT", "RAPID", "SPINDL", "LOADTL", "CUTTER", "COOLNT", "CIRCLE", "CYCLE", "MULTAX",
            "UNITS", "PARTNO", "FROM", "HOME", "GOHOME", "TLAXIS", "FINI", "STOP", "DELAY", "MOVARC",
        ],
    ),
];
/// Numbers of the cycles that a Sinumerik has itself: drilling and milling from CYCLE60 on, measuring up to
/// CYCLE998.
const OWN_CYCLES: std::ops::RangeInclusive<u32> = 60..=998;
/// A name of five letters and more may have two wrong ones, a shorter one one.
const LONG_NAME: usize = 5;

/// The name is one of the language's own cycles, or one of its words with a wrong letter.
pub(super) fn is_near_the_language(dialect: Dialect, name: &str) -> bool {
    let cycle = name.strip_prefix("CYCLE").and_then(|number| number.parse::<u32>().ok());
    if dialect == Dialect::Siemens840d && cycle.is_some_and(|number| OWN_CYCLES.contains(&number)) {
        return true;
    }
    let words = NAMES.iter().find(|(language, _)| *language == dialect).map_or(&[][..], |(_, words)| words);
    words.iter().any(|word| strsim::damerau_levenshtein(word, name) <= if word.len() < LONG_NAME { 1 } else { 2 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_letter_is_no_word_of_a_builder() {
        for (dialect, name, near) in [
            (Dialect::Siemens840d, "TRAORRI", true),
            (Dialect::Siemens840d, "CYCLE95", true),
            (Dialect::Siemens840d, "CYCLE977", true),
            (Dialect::Siemens840d, "CYCLE999", false),
            (Dialect::Siemens840d, "TOOL_CHECK", false),
            (Dialect::Apt, "FEDRTA", true),
            (Dialect::Apt, "FOOBAR", false),
            (Dialect::Fanuc, "TRAORRI", false),
        ] {
            assert_eq!(is_near_the_language(dialect, name), near, "{name}");
        }
    }

    #[test]
    fn every_row_of_the_table_has_a_meaning_and_whose_word_it_is() {
        for known in KNOWN_WORDS {
            assert!(
                known_word(known.family, known.word)
                    .is_some_and(|row| !row.whose.is_empty() && !row.means.1.is_empty())
            );
        }
    }
}
