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
