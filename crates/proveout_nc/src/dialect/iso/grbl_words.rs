//! The words of a grbl 1.1, and what it refuses in a block.
//!
//! After grbl 1.1, `gcode.c` (`gc_execute_line`) and its list of error codes: error 1 (no letter), 2 (no
//! number), 20 (unsupported word), 21 (two words of one group), 24 (two words that take the axes), 25
//! (repeated letter), 26 to 36 (values that miss or that nothing takes), 37 (G43.1), 38 (T). What a control
//! file gives a meaning is left to it.

use super::parser::{IsoBlock, IsoWord, WordValue};
use super::pending::Pending;
use super::run_state::Interpreter;
use super::statement::IsoStatement;
use super::words::Group;
use crate::codes;
use crate::control::{Control, Meaning};
use crate::diagnostic::{Fault, Span};
use crate::g_code::*;

/// The G words of a grbl.
const G_WORDS: [GCode; 38] = [
    G0, G1, G2, G3, G4, G10, G17, G18, G19, G20, G21, G28, G28_1, G30, G30_1, G38_2, G38_3, G38_4, G38_5, G40, G43_1,
    G49, G53, G54, G55, G56, G57, G58, G59, G61, G80, G90, G91, G91_1, G92, G92_1, G93, G94,
];
const M_WORDS: [u32; 10] = [0, 1, 2, 3, 4, 5, 7, 8, 9, 30];
/// Letters with a value.
const LETTERS: &[u8] = b"FIJKLNPRSTXYZ";
/// Letters whose value must not be negative.
const NOT_NEGATIVE: &[u8] = b"FNPST";
const HIGHEST_TOOL: f64 = 255.0;
const HIGHEST_BLOCK_NUMBER: u32 = 10_000_000;
/// G54 to G59.
const WORK_OFFSETS: f64 = 6.0;

fn unknown(span: Span, what: String, error: u32, help: &str) -> Fault {
    Fault::new(codes::UNSUPPORTED_WORD, span, format!("{what} (error {error} of a grbl)")).help(help)
}

/// What no state of a grbl makes valid in this block.
pub(super) fn foreign(block: &IsoBlock, control: &Control) -> Option<Fault> {
    if let Some(assignment) = block.assignments.first() {
        return Some(unknown(
            assignment.span,
            "a grbl has no parameters".to_owned(),
            1,
            "write the numbers themselves",
        ));
    }
    match &block.statement {
        None | Some(IsoStatement::Dollar(_)) => {}
        Some(_) => {
            return Some(unknown(
                block.span,
                "a grbl has no O words, no subprograms and no program numbers".to_owned(),
                20,
                "write the blocks one after the other",
            ));
        }
    }
    if let Some(number) = block.number.filter(|number| *number > HIGHEST_BLOCK_NUMBER) {
        let what = format!("the block number {number} is above {HIGHEST_BLOCK_NUMBER}");
        return Some(unknown(block.span, what, 27, "remove the number"));
    }
    block.words.iter().find_map(|word| foreign_word(word, block, control))
}

fn foreign_word(word: &IsoWord, block: &IsoBlock, control: &Control) -> Option<Fault> {
    let WordValue::Number { value, .. } = word.value else {
        return Some(unknown(word.span, "a grbl calculates nothing".to_owned(), 2, "write the number itself"));
    };
    match word.letter {
        b'G' => {
            if GCode::of(value).is_some_and(|code| G_WORDS.contains(&code) || control.words.g(code).is_some()) {
                return None;
            }
            let what = format!("`G{value}` is not a word of a grbl");
            Some(unknown(word.span, what, 20, "remove it, or give it a meaning in a control file"))
        }
        b'M' => {
            let known = M_WORDS.iter().any(|&m| f64::from(m) == value);
            if known || value >= 0.0 && value.fract() == 0.0 && control.words.m(value as u32).is_some() {
                return None;
            }
            let what = format!("`M{value}` is not a word of a grbl");
            Some(unknown(word.span, what, 20, "remove it, or give it a meaning in a control file"))
        }
        letter if !LETTERS.contains(&letter) => {
            let taken = block.words.iter().any(|other| listed_takes(other, letter, control));
            let what = format!("`{}` is not a letter of a grbl", char::from(letter));
            let help = if b"ABCUVW".contains(&letter) { "it has the axes X, Y and Z" } else { "remove it" };
            (!taken).then(|| unknown(word.span, what, 20, help))
        }
        letter if value < 0.0 && NOT_NEGATIVE.contains(&letter) => {
            let what = format!("`{}{value}` is negative", char::from(letter));
            Some(unknown(word.span, what, 4, "write a number from zero on"))
        }
        b'T' if value > HIGHEST_TOOL => Some(unknown(
            word.span,
            format!("`T{value}` is above T{HIGHEST_TOOL}"),
            38,
            "remove it: no tool is changed",
        )),
        _ => None,
    }
}

/// The control file gives this word a meaning that takes the letter.
fn listed_takes(word: &IsoWord, letter: u8, control: &Control) -> bool {
    let WordValue::Number { value, .. } = word.value else { return false };
    let listed = match word.letter {
        b'G' => GCode::of(value).and_then(|code| control.words.g(code)),
        b'M' if value >= 0.0 => control.words.m(value as u32),
        _ => None,
    };
    listed.is_some_and(|(_, listed)| !matches!(listed.meaning, Meaning::Refuse(_)) && listed.values.contains(&letter))
}

impl Interpreter {
    /// What a grbl refuses in a block for its words together, before it does anything.
    pub(super) fn refused_by_grbl(&mut self, p: &Pending, block: &IsoBlock) -> Result<(), Fault> {
        let span = block.span;
        let wrong = |what: &str, error: u32, help: &str| Err(unknown(span, what.to_owned(), error, help));
        let axes = p.axes() != 0;
        let one_shot = p.g(Group::OneShot);
        let motion_word = p.g(Group::Motion);
        let length = p.g(Group::ToolLength);
        let takes = one_shot.filter(|code| matches!(*code, G10 | G28 | G30 | G92));
        let moving = motion_word.filter(|code| *code != G80);
        if [takes.is_some(), moving.is_some(), length.is_some()].into_iter().filter(|&taken| taken).count() > 1 {
            return wrong("two words of the block take its axis letters", 24, "write them in blocks of their own");
        }
        if length == Some(G43_1) && p.axes() != 0b100 {
            return wrong("G43.1 takes Z and no other axis", 37, "write G43.1 Z50");
        }
        if length == Some(G49) && axes {
            // A grbl takes them and does nothing with them.
            return wrong("axis letters with G49, which moves no axis", 36, "write the motion in a block of its own");
        }
        let mode = motion_word.or_else(|| self.modal.motion.map(|_| self.modal.motion_code)).unwrap_or(G80);
        if axes && mode == G80 {
            return wrong("axis letters under G80", 31, "write G0 or G1");
        }
        match one_shot {
            Some(G4) if !p.has(b'P') => {
                return wrong("G4 has no P", 28, "write G4 P0.5 (seconds)");
            }
            Some(G10) => {
                let list = p.peek(b'L').unwrap_or(0.0);
                if !axes || !p.has(b'P') || !(list == 2.0 || list == 20.0) {
                    return wrong("G10 needs L2 or L20, P and an axis", 28, "write G10 L2 P1 X0 Y0 Z0");
                }
                if p.peek(b'P').is_some_and(|number| number.trunc() > WORK_OFFSETS) {
                    return wrong("G10 has P0 to P6: G54 to G59", 29, "write P1 for G54");
                }
            }
            Some(G92) if !axes => return wrong("G92 names no axis", 26, "write G92 X0"),
            Some(G53) if !matches!(mode, G0 | G1) => {
                return wrong("G53 needs G0 or G1 in force", 30, "write G0 or G1 with G53");
            }
            _ => {}
        }
        // The axes belong to the motion where no other word takes them.
        let moves = moving.is_some() || axes && takes.is_none() && length.is_none();
        let arc = moves && matches!(mode, G2 | G3);
        if moves && !axes && (arc || matches!(mode, GCode(38, 2..=5))) {
            let what = format!("{mode} names no axis");
            return wrong(&what, 26, "write its end, a full circle with the coordinates of its start");
        }
        let radius = arc && p.has(b'R');
        let center = arc && !radius;
        if arc {
            let [u, v, _] = self.plane_axes_of(p);
            if p.axes() & (1 << u | 1 << v) == 0 {
                let what = format!("{mode} names no axis of its plane");
                return wrong(&what, 32, "write its end, a full circle with the coordinates of its start");
            }
            if center && ![b"IJK"[u], b"IJK"[v]].iter().any(|&letter| p.has(letter)) {
                let what = format!("{mode} has no center in its plane and no R");
                return wrong(&what, 35, "write I, J, K or R");
            }
        }
        let data = one_shot == Some(G10);
        for &letter in b"IJKLPR" {
            let used = match letter {
                b'I' | b'J' | b'K' => center,
                b'L' => data,
                b'P' => data || one_shot == Some(G4),
                _ => radius,
            };
            let listed = || block.words.iter().any(|word| listed_takes(word, letter, &self.settings.control));
            if p.has(letter) && !used && !listed() {
                let what = format!("no word in the block uses `{}`", char::from(letter));
                return wrong(&what, 36, "remove it");
            }
        }
        if p.has_m(7) {
            self.assume(
                "M7 is a word of a grbl that is built with it (ENABLE_M7 of config.h); without it the block is refused",
            );
        }
        Ok(())
    }

    fn plane_axes_of(&self, p: &Pending) -> [usize; 3] {
        let normal = match p.g(Group::Plane) {
            Some(G17) => 2,
            Some(G18) => 1,
            Some(_) => 0,
            None => self.modal.normal,
        };
        [(normal + 1) % 3, (normal + 2) % 3, normal]
    }
}
