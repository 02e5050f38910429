//! The cycles of the controls that speak ISO 6983: the words that each takes.
//!
//! Sources: those of the reader of these cycles (`dialect/iso/cycles.rs`, `fagor.rs`). A word stands for its
//! letter; Z is the axis normal to the working plane.

use super::{CycleSpec, Key, Parameter, Unit, Usual};
use crate::g_code::{G69, G73, G74, G76, G77, G81, G82, G83, G84, G85, G86, G87, G88, G89, GCode};

/// The cycles of a control.
#[derive(Debug)]
pub(crate) struct CycleSet {
    /// Words without effect in their cycle are noted.
    pub(crate) notes_idle_words: bool,
    /// Way above the last depth to which the tool comes back after an infeed, mm: 0.010 inch of the
    /// interpreter of `LinuxCNC`; setting 22 of a Haas (0.05 inch); chosen for parameters 5114 and 5115 of a
    /// Fanuc.
    pub(crate) peck_clearance_mm: f64,
    /// G73 and G83 dwell at the bottom.
    pub(crate) pecks_dwell: bool,
    /// G74, G84 and G89 come out in feed all the way to the return level, as `convert_cycle_g74_g84` and
    /// `convert_cycle_g89` of the interpreter of `LinuxCNC`.
    pub(crate) feeds_out_to_return: bool,
    /// A tap dwells at the bottom, and not at the R plane too.
    pub(crate) tap_dwells_at_bottom_only: bool,
    /// Holes feed from R to the depth whichever way that is: angle heads, work from below.
    pub(crate) feeds_either_way: bool,
    cycles: &'static [(GCode, CycleSpec)],
}

impl CycleSet {
    /// The cycle of a G word.
    pub(crate) fn spec(&self, code: GCode) -> Option<&'static CycleSpec> {
        self.cycles.iter().find(|(other, _)| *other == code).map(|(_, spec)| spec)
    }

    /// The words of a cycle; none where the control has no such cycle.
    pub(crate) fn words(&self, code: GCode) -> &'static [Parameter] {
        self.spec(code).map(|spec| spec.parameters).unwrap_or_default()
    }

    /// A word of a cycle, by its letter.
    pub(crate) fn word(&self, code: GCode, letter: u8) -> Option<&'static Parameter> {
        self.words(code).iter().find(|parameter| parameter.key == Key::Letter(letter))
    }

    /// The same where it has this meaning.
    pub(crate) fn named(&self, code: GCode, letter: u8, name: &str) -> Option<&'static Parameter> {
        self.word(code, letter).filter(|parameter| parameter.name == name)
    }
}

/// The R plane of a hole.
pub(crate) const R_PLANE: &str = R.name;
/// How often a block is repeated.
pub(crate) const REPETITIONS: &str = L.name;
/// By how much faster a tap comes out.
pub(crate) const MULTIPLE_OF_SPEED: &str = SPEED_OUT.name;

/// A word that the cycle needs.
const fn word(letter: u8, name: &'static str, unit: Unit) -> Parameter {
    Parameter { key: Key::Letter(letter), name, unit, what: "", usual: Usual::None, written: true }
}

/// A word that may be left out: another one takes its place, or the state of the control.
const fn optional(parameter: Parameter) -> Parameter {
    Parameter { written: false, ..parameter }
}

/// A word that has this value where it is left out.
const fn or(parameter: Parameter, value: f64) -> Parameter {
    Parameter { written: false, usual: Usual::Value(value), ..parameter }
}

/// A word that the control takes, and keeps for a later cycle.
const fn idle(parameter: Parameter) -> Parameter {
    Parameter { written: false, unit: Unit::Unread, ..parameter }
}

const Z: Parameter = word(b'Z', "depth", Unit::Length);
const R: Parameter = word(b'R', "R plane", Unit::Length);
const Q: Parameter = word(b'Q', "infeed", Unit::Length);
const P: Parameter = word(b'P', "dwell", Unit::Number);
const SHIFT: Parameter = word(b'Q', "shift off the wall", Unit::Length);
const I: Parameter = word(b'I', "infeed or shift", Unit::Length);
const J: Parameter = word(b'J', "infeed or shift", Unit::Length);
const K: Parameter = word(b'K', "infeed or shift", Unit::Length);
const L: Parameter = word(b'L', "repetitions", Unit::Number);
const TIMES: Parameter = word(b'K', "repetitions", Unit::Number);
const SPEED_OUT: Parameter = word(b'J', "multiple of the speed out", Unit::Number);
const PLANE: Parameter = word(b'Z', "plane above the hole", Unit::Length);
const DEPTH: Parameter = word(b'I', "depth", Unit::Length);
const DWELL: Parameter = word(b'K', "dwell", Unit::Number);
const FOLLOWS: Parameter = word(b'R', "how the tap follows the spindle", Unit::Number);
const EACH: Parameter = word(b'I', "infeed", Unit::Length);
const COUNT: Parameter = word(b'J', "number of infeeds", Unit::Number);
const B: Parameter = word(b'B', "infeed", Unit::Length);
const C: Parameter = word(b'C', "approach, or milling pass", Unit::Length);
const D: Parameter = word(b'D', "way above the surface", Unit::Length);
const LIFT: Parameter = word(b'H', "lift after each infeed", Unit::Length);
const LEAST: Parameter = word(b'L', "least infeed", Unit::Length);
const EVERY: Parameter = word(b'J', "infeeds to a retraction", Unit::Number);
const FACTOR: Parameter = word(b'R', "factor of the infeeds", Unit::Number);
const HALF_U: Parameter = word(b'J', "half of the first side, or radius", Unit::Length);
const HALF_V: Parameter = word(b'K', "half of the second side", Unit::Length);
const ALLOWANCE: Parameter = word(b'L', "allowance of the wall", Unit::Length);
const FINISH: Parameter = word(b'H', "feed of finishing", Unit::Feed);
const PLUNGE: Parameter = word(b'V', "feed of the infeed", Unit::Feed);

pub(crate) static FANUC: CycleSet = CycleSet {
    notes_idle_words: true,
    peck_clearance_mm: 1.0,
    pecks_dwell: true,
    feeds_out_to_return: false,
    tap_dwells_at_bottom_only: false,
    feeds_either_way: true,
    cycles: &[
        (
            G73,
            CycleSpec {
                name: "G73",
                parameters: &[Z, R, Q, or(P, 0.0), idle(I), idle(J), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G74,
            CycleSpec {
                name: "G74",
                parameters: &[Z, R, optional(Q), or(P, 0.0), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G76,
            CycleSpec {
                name: "G76",
                parameters: &[Z, R, optional(SHIFT), or(P, 0.0), optional(I), optional(J), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G81,
            CycleSpec { name: "G81", parameters: &[Z, R, idle(P), idle(Q), or(L, 1.0), or(TIMES, 1.0)], assumed: None },
        ),
        (
            G82,
            CycleSpec {
                name: "G82",
                parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G83,
            CycleSpec {
                name: "G83",
                parameters: &[Z, R, Q, or(P, 0.0), idle(I), idle(J), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G84,
            CycleSpec {
                name: "G84",
                parameters: &[Z, R, optional(Q), or(P, 0.0), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G85,
            CycleSpec { name: "G85", parameters: &[Z, R, idle(P), idle(Q), or(L, 1.0), or(TIMES, 1.0)], assumed: None },
        ),
        (
            G86,
            CycleSpec {
                name: "G86",
                parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G87,
            CycleSpec {
                name: "G87",
                parameters: &[Z, R, optional(SHIFT), or(P, 0.0), optional(I), optional(J), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G89,
            CycleSpec {
                name: "G89",
                parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
    ],
};

pub(crate) static HAAS: CycleSet = CycleSet {
    notes_idle_words: true,
    peck_clearance_mm: 1.27,
    pecks_dwell: true,
    feeds_out_to_return: false,
    tap_dwells_at_bottom_only: false,
    feeds_either_way: false,
    cycles: &[
        (
            G73,
            CycleSpec {
                name: "G73",
                parameters: &[
                    Z,
                    optional(R),
                    optional(Q),
                    or(P, 0.0),
                    optional(I),
                    optional(J),
                    optional(K),
                    or(L, 1.0),
                ],
                assumed: None,
            },
        ),
        (
            G74,
            CycleSpec {
                name: "G74",
                parameters: &[Z, optional(R), optional(Q), or(P, 0.0), or(L, 1.0)],
                assumed: None,
            },
        ),
        (
            G76,
            CycleSpec {
                name: "G76",
                parameters: &[Z, optional(R), optional(SHIFT), or(P, 0.0), optional(I), optional(J), or(L, 1.0)],
                assumed: None,
            },
        ),
        (
            G77,
            CycleSpec {
                name: "G77",
                parameters: &[Z, optional(R), optional(SHIFT), or(P, 0.0), optional(I), optional(J), or(L, 1.0)],
                assumed: None,
            },
        ),
        (G81, CycleSpec { name: "G81", parameters: &[Z, optional(R), idle(P), idle(Q), or(L, 1.0)], assumed: None }),
        (G82, CycleSpec { name: "G82", parameters: &[Z, optional(R), or(P, 0.0), idle(Q), or(L, 1.0)], assumed: None }),
        (
            G83,
            CycleSpec {
                name: "G83",
                parameters: &[
                    Z,
                    optional(R),
                    optional(Q),
                    or(P, 0.0),
                    optional(I),
                    optional(J),
                    optional(K),
                    or(L, 1.0),
                ],
                assumed: None,
            },
        ),
        (
            G84,
            CycleSpec {
                name: "G84",
                parameters: &[Z, optional(R), optional(Q), or(P, 0.0), optional(SPEED_OUT), or(L, 1.0)],
                assumed: None,
            },
        ),
        (G85, CycleSpec { name: "G85", parameters: &[Z, optional(R), idle(P), idle(Q), or(L, 1.0)], assumed: None }),
        (G86, CycleSpec { name: "G86", parameters: &[Z, optional(R), or(P, 0.0), idle(Q), or(L, 1.0)], assumed: None }),
        (G89, CycleSpec { name: "G89", parameters: &[Z, optional(R), or(P, 0.0), idle(Q), or(L, 1.0)], assumed: None }),
    ],
};

pub(crate) static LINUXCNC: CycleSet = CycleSet {
    notes_idle_words: false,
    peck_clearance_mm: 0.254,
    pecks_dwell: false,
    feeds_out_to_return: true,
    tap_dwells_at_bottom_only: true,
    feeds_either_way: false,
    cycles: &[
        (G73, CycleSpec { name: "G73", parameters: &[Z, R, Q, or(L, 1.0)], assumed: None }),
        (G74, CycleSpec { name: "G74", parameters: &[Z, R, or(P, 0.0), or(L, 1.0)], assumed: None }),
        (G81, CycleSpec { name: "G81", parameters: &[Z, R, or(L, 1.0)], assumed: None }),
        (G82, CycleSpec { name: "G82", parameters: &[Z, R, P, or(L, 1.0)], assumed: None }),
        (G83, CycleSpec { name: "G83", parameters: &[Z, R, Q, or(L, 1.0)], assumed: None }),
        (G84, CycleSpec { name: "G84", parameters: &[Z, R, or(P, 0.0), or(L, 1.0)], assumed: None }),
        (G85, CycleSpec { name: "G85", parameters: &[Z, R, or(L, 1.0)], assumed: None }),
        (G86, CycleSpec { name: "G86", parameters: &[Z, R, P, or(L, 1.0)], assumed: None }),
        (G89, CycleSpec { name: "G89", parameters: &[Z, R, P, or(L, 1.0)], assumed: None }),
    ],
};

pub(crate) static MACH3: CycleSet = CycleSet {
    notes_idle_words: false,
    peck_clearance_mm: 0.254,
    pecks_dwell: false,
    feeds_out_to_return: true,
    tap_dwells_at_bottom_only: true,
    feeds_either_way: false,
    cycles: &[
        (
            G73,
            CycleSpec {
                name: "G73",
                parameters: &[Z, R, Q, idle(P), idle(I), idle(J), idle(K), or(L, 1.0)],
                assumed: None,
            },
        ),
        (G74, CycleSpec { name: "G74", parameters: &[Z, R, or(P, 0.0), or(L, 1.0)], assumed: None }),
        (G81, CycleSpec { name: "G81", parameters: &[Z, R, idle(Q), idle(P), or(L, 1.0)], assumed: None }),
        (G82, CycleSpec { name: "G82", parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0)], assumed: None }),
        (
            G83,
            CycleSpec {
                name: "G83",
                parameters: &[Z, R, Q, idle(P), idle(I), idle(J), idle(K), or(L, 1.0)],
                assumed: None,
            },
        ),
        (G84, CycleSpec { name: "G84", parameters: &[Z, R, or(P, 0.0), or(L, 1.0)], assumed: None }),
        (G85, CycleSpec { name: "G85", parameters: &[Z, R, idle(Q), idle(P), or(L, 1.0)], assumed: None }),
        (G86, CycleSpec { name: "G86", parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0)], assumed: None }),
        (G89, CycleSpec { name: "G89", parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0)], assumed: None }),
    ],
};

pub(crate) static OKUMA: CycleSet = CycleSet {
    notes_idle_words: false,
    peck_clearance_mm: 1.0,
    pecks_dwell: true,
    feeds_out_to_return: false,
    tap_dwells_at_bottom_only: false,
    feeds_either_way: true,
    cycles: &[
        (
            G73,
            CycleSpec {
                name: "G73",
                parameters: &[Z, R, optional(Q), or(P, 0.0), optional(I), optional(J), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G74,
            CycleSpec {
                name: "G74",
                parameters: &[Z, R, optional(Q), or(P, 0.0), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G76,
            CycleSpec {
                name: "G76",
                parameters: &[Z, R, optional(SHIFT), or(P, 0.0), optional(I), optional(J), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G81,
            CycleSpec { name: "G81", parameters: &[Z, R, idle(P), idle(Q), or(L, 1.0), or(TIMES, 1.0)], assumed: None },
        ),
        (
            G82,
            CycleSpec {
                name: "G82",
                parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G83,
            CycleSpec {
                name: "G83",
                parameters: &[Z, R, Q, or(P, 0.0), idle(I), idle(J), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G84,
            CycleSpec {
                name: "G84",
                parameters: &[Z, R, optional(Q), or(P, 0.0), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G85,
            CycleSpec { name: "G85", parameters: &[Z, R, idle(P), idle(Q), or(L, 1.0), or(TIMES, 1.0)], assumed: None },
        ),
        (
            G86,
            CycleSpec {
                name: "G86",
                parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G87,
            CycleSpec {
                name: "G87",
                parameters: &[Z, R, optional(SHIFT), or(P, 0.0), optional(I), optional(J), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
        (
            G89,
            CycleSpec {
                name: "G89",
                parameters: &[Z, R, or(P, 0.0), idle(Q), or(L, 1.0), or(TIMES, 1.0)],
                assumed: None,
            },
        ),
    ],
};

pub(crate) static FAGOR: CycleSet = CycleSet {
    notes_idle_words: false,
    peck_clearance_mm: 1.0,
    pecks_dwell: true,
    feeds_out_to_return: false,
    tap_dwells_at_bottom_only: false,
    feeds_either_way: true,
    cycles: &[
        (
            G69,
            CycleSpec {
                name: "G69",
                parameters: &[
                    PLANE,
                    DEPTH,
                    B,
                    or(C, 1.0),
                    or(D, 0.0),
                    optional(LIFT),
                    or(LEAST, 0.0),
                    optional(EVERY),
                    or(DWELL, 0.0),
                    or(FACTOR, 1.0),
                ],
                assumed: None,
            },
        ),
        (G81, CycleSpec { name: "G81", parameters: &[PLANE, DEPTH, or(DWELL, 0.0), or(L, 1.0)], assumed: None }),
        (G82, CycleSpec { name: "G82", parameters: &[PLANE, DEPTH, or(DWELL, 0.0), or(L, 1.0)], assumed: None }),
        (G83, CycleSpec { name: "G83", parameters: &[PLANE, EACH, COUNT, or(L, 1.0), or(TIMES, 1.0)], assumed: None }),
        (
            G84,
            CycleSpec {
                name: "G84",
                parameters: &[PLANE, DEPTH, or(DWELL, 0.0), or(FOLLOWS, 0.0), or(L, 1.0)],
                assumed: None,
            },
        ),
        (G85, CycleSpec { name: "G85", parameters: &[PLANE, DEPTH, or(DWELL, 0.0), or(L, 1.0)], assumed: None }),
        (G86, CycleSpec { name: "G86", parameters: &[PLANE, DEPTH, or(DWELL, 0.0), or(L, 1.0)], assumed: None }),
        (
            G87,
            CycleSpec {
                name: "G87",
                parameters: &[
                    PLANE,
                    DEPTH,
                    HALF_U,
                    HALF_V,
                    B,
                    optional(C),
                    or(D, 0.0),
                    or(ALLOWANCE, 0.0),
                    optional(FINISH),
                    optional(PLUNGE),
                ],
                assumed: None,
            },
        ),
        (
            G88,
            CycleSpec {
                name: "G88",
                parameters: &[
                    PLANE,
                    DEPTH,
                    HALF_U,
                    idle(HALF_V),
                    B,
                    optional(C),
                    or(D, 0.0),
                    or(ALLOWANCE, 0.0),
                    optional(FINISH),
                    optional(PLUNGE),
                ],
                assumed: None,
            },
        ),
        (G89, CycleSpec { name: "G89", parameters: &[PLANE, DEPTH, or(DWELL, 0.0), or(L, 1.0)], assumed: None }),
    ],
};

/// Every control.
#[cfg(test)]
const ALL: [(&str, &CycleSet); 6] = [
    ("Fanuc", &FANUC),
    ("Haas", &HAAS),
    ("LinuxCNC", &LINUXCNC),
    ("Mach3", &MACH3),
    ("Okuma", &OKUMA),
    ("Fagor", &FAGOR),
];

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Rows of the README: the words of each cycle by control.
    pub(crate) fn rows() -> Vec<String> {
        let mut codes: Vec<GCode> = ALL.iter().flat_map(|(_, set)| set.cycles.iter().map(|(code, _)| *code)).collect();
        codes.sort();
        codes.dedup();
        let cell = |parameter: &Parameter| match (parameter.key, parameter.usual) {
            (Key::Letter(letter), _) if parameter.unit == Unit::Unread => format!("({})", char::from(letter)),
            (Key::Letter(letter), _) if parameter.written => char::from(letter).to_string(),
            (Key::Letter(letter), Usual::Value(value)) => format!("{}={value}", char::from(letter)),
            (Key::Letter(letter), Usual::None) => format!("{}=", char::from(letter)),
            (key, _) => format!("{key:?}"),
        };
        let row = |code: &GCode| {
            let cells = ALL.map(|(_, set)| set.words(*code).iter().map(cell).collect::<Vec<_>>().join(" "));
            format!(
                "| `{code}` | {} |",
                cells.map(|cell| if cell.is_empty() { "–".to_owned() } else { cell }).join(" | ")
            )
        };
        codes.iter().map(row).collect()
    }

    #[test]
    fn a_letter_is_in_its_cycle_once() {
        for (control, set) in ALL {
            for (code, spec) in set.cycles {
                assert_eq!(code.to_string(), spec.name, "{control}");
                for (at, parameter) in spec.parameters.iter().enumerate() {
                    let again = spec.parameters[..at].iter().any(|other| other.key == parameter.key);
                    assert!(!again && !parameter.name.is_empty(), "{control} {code} {:?}", parameter.key);
                }
            }
        }
    }

    #[test]
    fn controls_of_one_language_have_the_same_cycles() {
        let codes = |set: &CycleSet| set.cycles.iter().map(|(code, _)| *code).collect::<Vec<_>>();
        assert_eq!(codes(&OKUMA), codes(&FANUC));
        assert_eq!(codes(&MACH3), codes(&LINUXCNC));
    }
}
