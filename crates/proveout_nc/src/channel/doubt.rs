//! What is unknown after a block that could not be read or executed.
//!
//! `check` goes on after a fault, so that one run reports all of them. What the block would have
//! set is then in doubt. A fault that depends on it may follow from the first one: it is not
//! reported. Doubt comes from the text that was not executed: an address letter puts its axis, the
//! feed or the tool in doubt, a G word or a keyword the modal state, a variable all values. It ends
//! when a later block sets the same again.

use std::collections::BTreeMap;

use crate::AxisValues;
use crate::codes;
use crate::diagnostic::Diagnostic;

/// Faults of the shape of a path.
const SHAPES: [&str; 4] = [codes::ARC_GEOMETRY, codes::ARC_RADIUS, codes::POSITION_UNKNOWN, codes::COMPENSATION];

/// Bits of X, Y, Z and A, B, C, U, V, W.
const ALL_AXES: u16 = 0x1ff;

/// What a program has set is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Doubt {
    /// Position of these axes.
    pub(crate) axes: u16,
    pub(crate) feed: bool,
    /// The motion word in force: a later block with its own ends the doubt.
    pub(crate) mode: bool,
    /// Other modal words, planes, offsets, cycles: in doubt until the end.
    pub(crate) modal: bool,
    pub(crate) tool: bool,
    /// Variables.
    pub(crate) values: bool,
}

impl Doubt {
    pub(crate) const NONE: Self = Self { axes: 0, feed: false, mode: false, modal: false, tool: false, values: false };
    /// After a subprogram that was not found.
    pub(crate) const ALL: Self = Self { axes: ALL_AXES, feed: true, mode: true, modal: true, tool: true, values: true };

    pub(crate) fn any(self) -> bool {
        self != Self::NONE
    }

    pub(crate) fn add(&mut self, other: Self) {
        self.axes |= other.axes;
        self.feed |= other.feed;
        self.mode |= other.mode;
        self.modal |= other.modal;
        self.tool |= other.tool;
        self.values |= other.values;
    }

    /// Ends the doubt about what a block sets again: the axes with a position, the feed, the tool.
    pub(crate) fn settle(&mut self, position: &AxisValues, feed: bool, tool: bool) {
        for axis in (0..9).filter(|axis| position.get(*axis).is_some()) {
            self.axes &= !(1 << axis);
        }
        self.feed &= !feed;
        self.tool &= !tool;
    }

    /// What text can set, in the languages of letters and keywords: single letters are addresses,
    /// longer words are keywords or names. Comments in `( )` and after `;` set nothing.
    pub(crate) fn of_text(text: &str) -> Self {
        let mut doubt = Self::NONE;
        let bytes = text.as_bytes();
        let mut at = 0;
        while let Some(&byte) = bytes.get(at) {
            let word = bytes[at..].iter().take_while(|b| b.is_ascii_alphabetic() || **b == b'_').count();
            match byte {
                b';' => break,
                b'(' if !text[..at].trim_end().ends_with(|c: char| c.is_ascii_alphanumeric()) => {
                    at += bytes[at..].iter().position(|b| *b == b')').unwrap_or(bytes.len());
                }
                b'#' | b'=' | b'$' => doubt.values = true,
                _ if word == 1 => match byte.to_ascii_uppercase() {
                    b'F' => doubt.feed = true,
                    b'T' => doubt.tool = true,
                    b'G' => (doubt.mode, doubt.modal) = (true, true),
                    b'D' | b'H' | b'S' | b'L' | b'P' => doubt.modal = true,
                    b'O' => doubt = Self::ALL,
                    b'M' => {
                        doubt.modal = true;
                        doubt.tool = true;
                    }
                    b'R' | b'Q' => doubt.values = true,
                    letter => doubt.axes |= AxisValues::index(char::from(letter)).map_or(0, |axis| 1 << axis),
                },
                _ if word > 1 => {
                    doubt.mode = true;
                    doubt.modal = true;
                    doubt.tool = true;
                    doubt.feed = true;
                    doubt.axes = ALL_AXES;
                    doubt.values |= !text[at..].trim_end().ends_with(|c: char| c.is_ascii_alphabetic());
                }
                _ => {}
            }
            at += word.max(1);
        }
        if ["M98", "M97", "M198", "G65", "G66"].iter().any(|call| text.to_ascii_uppercase().contains(call)) {
            doubt = Self::ALL;
        }
        doubt
    }

    /// What a block leaves in doubt whose motion failed with this fault: words that set something act before
    /// the motion, so that only its end is not known.
    pub(crate) fn of_motion(code: &str, text: &str) -> Self {
        let doubt = Self::of_text(text);
        match code {
            codes::ARC_GEOMETRY | codes::ARC_RADIUS | codes::POSITION_UNKNOWN | codes::NO_FEED => {
                Self { axes: doubt.axes, ..Self::NONE }
            }
            _ => doubt,
        }
    }

    /// A fault of the shape of a path that may be there only because of what is in doubt.
    pub(crate) fn hides_shape(self, code: &str) -> bool {
        SHAPES.contains(&code) && (self.axes != 0 || self.mode || self.values)
    }

    /// A fault that may be there only because of what is in doubt. A block whose text cannot be
    /// read has a fault of its own; while a block is being collected, only values can be in doubt.
    pub(crate) fn hides(self, fault: &Diagnostic, stage: Stage) -> bool {
        if stage == Stage::Unread {
            return false;
        }
        let acting = stage != Stage::Read;
        match fault.code {
            code if SHAPES.contains(&code) => self.hides_shape(code),
            codes::ARGUMENTS | codes::ORIENTATION | codes::CONFLICT | codes::MISSING_VALUE | codes::STRUCTURE => {
                self.modal && acting || self.values
            }
            codes::NO_FEED => self.feed || self.mode || self.values,
            codes::NO_TOOL => self.tool,
            // A word refused in some states only. A word refused everywhere is reported when its
            // line is read.
            codes::UNSUPPORTED_WORD => self.modal && acting,
            codes::UNKNOWN_VARIABLE
            | codes::ARITHMETIC
            | codes::TYPE
            | codes::BAD_VALUE
            | codes::PROGRAM_ALARM
            | codes::LOOP_LIMIT
            | codes::NESTING_LIMIT => self.values,
            codes::JUMP_TARGET | codes::SUBPROGRAM => self.values && is_computed(&fault.source_line),
            _ => false,
        }
    }
}

/// The target of a jump or call is computed: a parameter or expression follows its word.
fn is_computed(line: &str) -> bool {
    let upper = line.to_ascii_uppercase();
    let behind = ["GOTOF", "GOTOB", "GOTOC", "GOTO", "LBL", "CALL", "PGM", "M98", "M97", "M99", "G65", "G66"]
        .iter()
        .filter_map(|word| upper.rfind(word).map(|at| at + word.len()))
        .max();
    let target = upper.get(behind.unwrap_or(0)..).unwrap_or_default();
    target.contains(['#', '<']) || target.trim_start().starts_with(['[', 'Q']) || upper.trim_start().starts_with("O[")
}

/// How far a block has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Its text is being read.
    #[default]
    Unread,
    /// Its words are being collected.
    Read,
    /// It is being executed.
    Acting,
    /// It has been executed, except for words that have no use in it.
    Acted,
}

/// What a reader knows of the faults of its run.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    /// What is in doubt since the faults before.
    pub(crate) doubt: Doubt,
    /// How far the block has come that is executed.
    pub(crate) stage: Stage,
    /// Blocks that have failed, by file and line: how often.
    seen: BTreeMap<(usize, u32), u32>,
}

impl Faults {
    /// Counts a fault of a block; how often it has failed.
    pub(crate) fn count(&mut self, file: usize, line: u32) -> u32 {
        let times = self.seen.entry((file, line)).or_default();
        *times = times.saturating_add(1);
        *times
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_puts_in_doubt_what_it_could_set() {
        let of = Doubt::of_text;
        assert_eq!(of(""), Doubt::NONE);
        assert_eq!(of("X10 Y-5"), Doubt { axes: 0b11, ..Doubt::NONE });
        assert_eq!(of("F100"), Doubt { feed: true, ..Doubt::NONE });
        assert_eq!(of("(G1 X5) Z[#1]"), Doubt { axes: 0b100, values: true, ..Doubt::NONE });
        assert_eq!(of("G1 ; X5"), Doubt { mode: true, modal: true, ..Doubt::NONE });
        assert_eq!(of("#5=3"), Doubt { values: true, ..Doubt::NONE });
        assert!(of("CYCLE81(10,0,2)").modal && of("TOOL CALL 5").tool && of("SIDE").axes == ALL_AXES);
        assert_eq!(of("M98 P100"), Doubt::ALL);
        assert_eq!(of("@!~^"), Doubt::NONE);
    }
}
