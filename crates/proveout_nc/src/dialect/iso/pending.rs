//! The words of one block, sorted: what the block asks for, before anything is done.

use super::words::Group;
use crate::g_code::{G0, G80, GCode};

/// The words of a block by letter. A word that has no use in its block is refused.
#[derive(Clone, Debug)]
pub(crate) struct Pending {
    values: [f64; 26],
    set: u32,
    taken: u32,
    points: u32,
    /// G words with their groups, in the order of the text.
    g: [(GCode, Group); 16],
    g_count: usize,
    /// Groups that occur, by bit.
    groups: u32,
    m: [u32; 10],
    m_count: usize,
    /// `@` and `^`: polar radius and angle.
    polar: [Option<f64>; 2],
    polar_taken: bool,
    second_tool: Option<f64>,
    /// Letters whose variable has no value.
    vacant: u32,
    /// `,C` and `,R`
    corner: [Option<f64>; 2],
    corner_taken: bool,
}

/// More words of one kind than a block may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Full;

fn bit(letter: u8) -> u32 {
    1 << (letter.wrapping_sub(b'A') & 31)
}

fn at(letter: u8) -> usize {
    usize::from(letter.wrapping_sub(b'A')).min(25)
}

/// Letters of axes in the order of [`crate::AXIS_LETTERS`].
pub(crate) const AXES: [u8; 9] = *b"XYZABCUVW";

impl Pending {
    pub(crate) fn new() -> Self {
        Self {
            values: [0.0; 26],
            set: 0,
            taken: 0,
            points: 0,
            g: [(G0, Group::OneShot); 16],
            g_count: 0,
            groups: 0,
            m: [0; 10],
            m_count: 0,
            polar: [None; 2],
            polar_taken: false,
            second_tool: None,
            vacant: 0,
            corner: [None; 2],
            corner_taken: false,
        }
    }

    /// Adds a word; false when the block has the letter already.
    pub(crate) fn put(&mut self, letter: u8, value: f64, point: bool) -> bool {
        let fresh = self.set & bit(letter) == 0;
        self.set |= bit(letter);
        self.values[at(letter)] = value;
        if point {
            self.points |= bit(letter);
        }
        fresh
    }

    /// A word whose variable has no value is none.
    pub(crate) fn leave_out(&mut self, letter: u8) {
        if letter.is_ascii_uppercase() {
            self.vacant |= bit(letter);
        }
    }

    /// Letters of the words that are left out.
    pub(crate) fn vacant(&self) -> impl Iterator<Item = u8> + use<> {
        let vacant = self.vacant;
        (b'A'..=b'Z').filter(move |&letter| vacant & bit(letter) != 0)
    }

    /// `@` or `^` (the angle); false where the block has it already.
    pub(crate) fn put_polar(&mut self, angle: bool, value: f64) -> bool {
        self.polar[usize::from(angle)].replace(value).is_none()
    }

    pub(crate) fn has_polar(&self) -> bool {
        !self.polar_taken && self.polar != [None; 2]
    }

    /// Polar radius and angle as written; they have found their use.
    pub(crate) fn take_polar(&mut self) -> [Option<f64>; 2] {
        self.polar_taken = true;
        self.polar
    }

    /// `,C`, or `,R` (`rounding`); false where the block has it already.
    pub(crate) fn put_corner(&mut self, rounding: bool, value: f64) -> bool {
        self.corner[usize::from(rounding)].replace(value).is_none()
    }

    /// `,C` and `,R` as written; they have found their use.
    pub(crate) fn take_corner(&mut self) -> [Option<f64>; 2] {
        self.corner_taken = true;
        self.corner
    }

    /// The block has `,C` or `,R`, and it has found no use.
    pub(crate) fn corner_left(&self) -> bool {
        !self.corner_taken && self.corner != [None; 2]
    }

    /// The block has `,C` or `,R`.
    pub(crate) fn corner_waits_in_block(&self) -> bool {
        self.corner != [None; 2]
    }

    /// A second T; false where the block has it already.
    pub(crate) fn put_second_tool(&mut self, value: f64) -> bool {
        self.second_tool.replace(value).is_none()
    }

    pub(crate) fn second_tool(&self) -> Option<f64> {
        self.second_tool
    }

    pub(crate) fn has(&self, letter: u8) -> bool {
        self.set & bit(letter) != 0
    }

    /// Value without taking it.
    pub(crate) fn peek(&self, letter: u8) -> Option<f64> {
        self.has(letter).then(|| self.values[at(letter)])
    }

    /// Value of a word; the word has found its use.
    pub(crate) fn take(&mut self, letter: u8) -> Option<f64> {
        self.taken |= bit(letter);
        self.peek(letter)
    }

    /// These words have found their use.
    pub(crate) fn use_up(&mut self, letters: &[u8]) {
        for &letter in letters {
            self.taken |= bit(letter);
        }
    }

    /// Everything has found its use.
    pub(crate) fn use_all(&mut self) {
        self.taken = u32::MAX;
    }

    pub(crate) fn has_point(&self, letter: u8) -> bool {
        self.points & bit(letter) != 0
    }

    /// A letter of the block that has no use there.
    pub(crate) fn left_over(&self) -> Option<u8> {
        let rest = self.set & !self.taken;
        (rest != 0).then(|| b'A' + rest.trailing_zeros() as u8)
    }

    /// Bit i is set when the block has a word of axis i of [`AXES`] that has found no use yet.
    pub(crate) fn axes(&self) -> u16 {
        let free = self.set & !self.taken;
        // Three neighbors each in the alphabet.
        let three = |first: u8| (free >> (first - b'A') & 0b111) as u16;
        three(b'X') | three(b'A') << 3 | three(b'U') << 6
    }

    /// The block has one of these words, and it has found no use yet.
    pub(crate) fn any_free(&self, letters: &[u8]) -> bool {
        letters.iter().any(|&letter| self.set & !self.taken & bit(letter) != 0)
    }

    /// Adds a G word; returns another word of its group in the block, if there is one.
    pub(crate) fn put_g(&mut self, code: GCode, group: Group) -> Result<Option<GCode>, Full> {
        let mask = 1 << group as u32;
        // On a LinuxCNC G80 is in the group of the motions, and any of them takes its place.
        if group == Group::Motion && self.groups & mask != 0 {
            if code == G80 {
                return Ok(None);
            }
            if let Some(slot) = self.g[..self.g_count].iter_mut().find(|(other, g)| *g == group && *other == G80) {
                slot.0 = code;
                return Ok(None);
            }
        }
        let clash = if self.groups & mask != 0 {
            self.g[..self.g_count].iter().find(|(_, g)| *g == group).map(|(code, _)| *code)
        } else {
            None
        };
        self.groups |= mask;
        *self.g.get_mut(self.g_count).ok_or(Full)? = (code, group);
        self.g_count += 1;
        Ok(clash)
    }

    /// The G word of a group.
    pub(crate) fn g(&self, group: Group) -> Option<GCode> {
        if self.groups & 1 << group as u32 == 0 {
            return None;
        }
        self.g[..self.g_count].iter().find(|(_, g)| *g == group).map(|(code, _)| *code)
    }

    pub(crate) fn no_g(&self) -> bool {
        self.g_count == 0
    }

    pub(crate) fn put_m(&mut self, code: u32) -> Result<(), Full> {
        *self.m.get_mut(self.m_count).ok_or(Full)? = code;
        self.m_count += 1;
        Ok(())
    }

    pub(crate) fn m(&self) -> &[u32] {
        &self.m[..self.m_count]
    }

    pub(crate) fn has_m(&self, code: u32) -> bool {
        self.m().contains(&code)
    }
}
