//! What the interpreter of a `LinuxCNC` refuses in a block, before it does any of it.
//!
//! After *G-code reference* and what `rs274` of `LinuxCNC` 2.9 says to random blocks
//! (`tests/linuxcnc_blocks.rs`): which words a letter belongs to, which words take the axis letters, which M
//! words exclude each other. A grbl and a Mach3 share the language and have rules of their own.

use super::block::NOTED_G;
use super::listed::LISTED;
use super::modal::FeedMode;
use super::pending::{AXES, Pending};
use super::run_state::Interpreter;
use super::words::Group;
use crate::CompSide;
use crate::SpindleDirection;
use crate::codes;
use crate::control::Meaning;
use crate::cycle::Key;
use crate::diagnostic::{Fault, Span};
use crate::g_code::*;

/// Most M words of a block.
const MOST_M: usize = 4;
/// One-shot words that take the axis letters of their block.
const TAKES_AXES: [GCode; 5] = [G10, G28, G30, G52, G92];
/// A number is whole where its fraction is no more than this.
const NOT_WHOLE: f64 = 1e-4;

/// A letter, and the words that it belongs to: motion words, other G words, M words.
struct Letter {
    letter: u8,
    motions: &'static [GCode],
    others: &'static [GCode],
    functions: &'static [u32],
}

/// Letters that have a meaning only together with one of these words.
const LETTERS: [Letter; 10] = [
    Letter { letter: b'D', motions: &[G70, G71, G71_1, G71_2], others: &[G41, G42, G41_1, G42_1, G96], functions: &[] },
    Letter { letter: b'E', motions: &[G70, G76], others: &[], functions: &[66, 67, 68] },
    Letter { letter: b'H', motions: &[G76], others: &[G43, G43_2], functions: &[] },
    Letter {
        letter: b'I',
        motions: &[G2, G3, G5, G5_1, G33_1, G70, G71, G71_1, G71_2, G72, G76, G87],
        others: &[G10],
        functions: &[],
    },
    Letter { letter: b'J', motions: &[G2, G3, G5, G5_1, G76, G87], others: &[G10], functions: &[] },
    Letter { letter: b'K', motions: &[G2, G3, G33, G33_1, G76, G87], others: &[], functions: &[] },
    Letter {
        letter: b'L',
        motions: &[G5_2, G73, G74, G76, G81, G82, G83, G84, G85, G86, G87, G88, G89],
        others: &[G10, G41, G42, G41_1, G42_1],
        functions: &[66, 98],
    },
    Letter {
        letter: b'P',
        motions: &[G2, G3, G5, G5_2, G74, G76, G82, G84, G86, G88, G89],
        others: &[G10, G4, G64],
        functions: &[50, 51, 52, 53, 62, 63, 64, 65, 66, 19, 98],
    },
    Letter {
        letter: b'Q',
        motions: &[G5, G70, G71, G71_1, G71_2, G72, G73, G76, G83],
        others: &[G10, G64],
        functions: &[61, 66, 67, 68, 19],
    },
    Letter {
        letter: b'R',
        motions: &[G2, G3, G70, G71, G71_1, G71_2, G72, G73, G74, G76, G81, G82, G83, G84, G85, G86, G87, G88, G89],
        others: &[G10, G41_1, G42_1],
        functions: &[19],
    },
];

/// M words that exclude each other, by the group of the interpreter.
fn group_of(m: u32) -> Option<u32> {
    Some(match m {
        0 | 1 | 2 | 30 | 60 | 98 | 99 => 4,
        62..=68 => 5,
        6 | 61 => 6,
        3..=5 | 19 => 7,
        7..=9 => 8,
        48..=53 => 9,
        70..=73 => 10,
        _ => return None,
    })
}

fn wrong(span: Span, message: impl Into<String>, help: impl Into<String>) -> Fault {
    Fault::new(codes::CONFLICT, span, message.into()).help(help.into())
}

impl Interpreter {
    /// The control is a `LinuxCNC`, or one that cannot be distinguished from it.
    pub(crate) fn is_rs274(&self) -> bool {
        let control = &self.settings.control;
        self.own.flavor.is_linuxcnc() && !control.grbl_words && !control.mach3_words
    }

    /// The motion word of a block; none where its axis letters belong to another word.
    pub(super) fn motion_to_be(&self, p: &Pending) -> Option<GCode> {
        if let Some(code) = p.g(Group::Motion) {
            return Some(code);
        }
        if p.g(Group::OneShot).is_some_and(|code| TAKES_AXES.contains(&code)) {
            return None;
        }
        let in_force = self.modal.cycle.or_else(|| self.modal.motion.map(|_| self.modal.motion_code));
        if p.axes() != 0 || p.has_polar() {
            return in_force.filter(|_| p.g(Group::ToolLength) != Some(G43_1));
        }
        in_force.filter(|code| matches!(*code, G2 | G3) && p.any_free(b"IJK"))
    }

    /// What the interpreter refuses before it does anything.
    pub(super) fn refused_by_interpreter(&self, p: &Pending, span: Span) -> Result<(), Fault> {
        // The control file says what a word that calls a macro takes.
        let remapped = |m: u32| {
            let listed = m.checked_sub(LISTED).and_then(|at| self.settings.control.words.at(at as usize));
            listed.is_some_and(|listed| matches!(listed.meaning, Meaning::Macro(_) | Meaning::Call(_)))
        };
        if !self.is_rs274() || p.m().iter().any(|&m| remapped(m)) {
            return Ok(());
        }
        let motion = self.motion_to_be(p);
        self.axis_letters(p, motion, span)?;
        self.one_shot_rules(p, motion, span)?;
        self.behind_spline(p, motion, span)?;
        self.functions_of_one_group(p, span)?;
        self.letters_of_words(p, motion, span)?;
        self.compensation_rules(p, motion, span)?;
        self.motion_rules(p, motion, span)
    }

    /// G5 and G5.1 leave the motion word in force as it was (`convert_spline` sets no motion mode):
    /// a block after them without a motion word is a line, an arc or a hole, and not a spline.
    fn behind_spline(&self, p: &Pending, motion: Option<GCode>, span: Span) -> Result<(), Fault> {
        let Some(code @ (G5 | G5_1)) = motion.filter(|_| p.g(Group::Motion).is_none()) else { return Ok(()) };
        let message = format!(
            "the block after {} has no motion word: the control makes the motion that was in force before it",
            code
        );
        Err(Fault::new(codes::MISSING_VALUE, span, message).help("write the motion word in this block"))
    }

    /// Refuses what is not allowed while cutter compensation is on.
    fn compensation_rules(&self, p: &Pending, motion: Option<GCode>, span: Span) -> Result<(), Fault> {
        let before = self.modal.comp != CompSide::Off;
        let word = p.g(Group::CutterComp);
        let behind = word.map_or(before, |code| code != G40);
        if !before && !behind {
            return Ok(());
        }
        let refuse = |what: &str| Err(wrong(span, format!("{what} under cutter compensation"), "write G40 before it"));
        if word.is_some_and(|code| code != G40) {
            if before {
                return refuse("G41 or G42");
            }
            if self.plane_of(p) == 0 {
                return Err(wrong(span, "cutter compensation in the plane G19", "choose G17 or G18"));
            }
        }
        if before {
            let early = p.m().iter().filter_map(|&m| self.function_number(m));
            for m in early {
                if matches!(m, 6 | 48..=53 | 62..=65 | 67 | 68) {
                    return refuse(&format!("M{m}"));
                }
            }
            if self.plane_of(p) != self.modal.normal {
                return refuse("another plane");
            }
        }
        if behind {
            for group in [Group::ToolLength, Group::WorkOffset, Group::PathMode, Group::Return] {
                if let Some(code) = p.g(group) {
                    return refuse(&code.to_string());
                }
            }
            if let Some(code) = p.g(Group::OneShot).filter(|code| *code != G4) {
                return refuse(&code.to_string());
            }
            if let Some(code) = motion.filter(|code| matches!(*code, GCode(38, 2..=5))) {
                return refuse(&code.to_string());
            }
        }
        Ok(())
    }

    fn axis_letters(&self, p: &Pending, motion: Option<GCode>, span: Span) -> Result<(), Fault> {
        let axes = p.axes() != 0;
        let one_shot = p.g(Group::OneShot);
        let takes = one_shot.filter(|code| TAKES_AXES.contains(code));
        if p.has_polar() && (self.modal.normal != 2 || self.plane_of(p) != 2) {
            return Err(wrong(span, "@ and ^ outside of the plane G17", "write the point with its axes"));
        }
        if p.has_polar() && (p.has(b'X') || p.has(b'Y')) {
            return Err(wrong(span, "X or Y together with a polar radius or angle", "write one of the two"));
        }
        if let Some(length) = p.g(Group::ToolLength).filter(|code| matches!(*code, G43_1 | G43_2) && axes)
            && let Some(motion) = p.g(Group::Motion).filter(|code| *code != G80)
        {
            let message = format!("{length} and {motion} both take the axis letters of the block");
            return Err(wrong(span, message, "write them in blocks of their own"));
        }
        if let Some(length) = p.g(Group::ToolLength).filter(|code| matches!(*code, G43_1 | G43_2) && axes)
            && let Some(other) = takes
        {
            let message = format!("{length} and {other} both take the axis letters of the block");
            return Err(wrong(span, message, "write them in blocks of their own"));
        }
        if let Some(code) = takes.filter(|code| matches!(*code, G52 | G92) && !axes) {
            let message = format!("{code} names no axis");
            return Err(Fault::new(codes::MISSING_VALUE, span, message).help(format!("write {code} X0")));
        }
        match (p.g(Group::Motion), takes) {
            (Some(G80), None) if axes || p.has_polar() => {
                Err(wrong(span, "axis letters with G80, which moves no axis", "write G0 or G1"))
            }
            (Some(code), Some(other)) if code != G80 => {
                let message = format!("{code} and {other} both take the axis letters of the block");
                Err(wrong(span, message, "write them in blocks of their own"))
            }
            (Some(code), None) if !axes && !p.has_polar() && !matches!(code, G0 | G1 | G2 | G3 | G5_2 | G5_3 | G80) => {
                let message = format!("{code} names no axis");
                Err(Fault::new(codes::MISSING_VALUE, span, message).help("write its point"))
            }
            (None, None) if (axes || p.has_polar()) && motion.is_none() && !Self::offsets_take_axes(p) => {
                let message = "axis letters without a motion word in force";
                if p.g(Group::OneShot) == Some(G4) {
                    return Err(
                        Fault::new(codes::MISSING_VALUE, span, message).help("a dwell is written G4 P0.5 (seconds)")
                    );
                }
                Err(Fault::new(codes::MISSING_VALUE, span, message).help("write G0 or G1 before them"))
            }
            _ => Ok(()),
        }
    }

    /// G43.1 takes the axis letters of a block without a motion word.
    fn offsets_take_axes(p: &Pending) -> bool {
        p.g(Group::ToolLength) == Some(G43_1)
    }

    fn plane_of(&self, p: &Pending) -> usize {
        match p.g(Group::Plane) {
            Some(G17) => 2,
            Some(G18) => 1,
            Some(_) => 0,
            None => self.modal.normal,
        }
    }

    fn one_shot_rules(&self, p: &Pending, motion: Option<GCode>, span: Span) -> Result<(), Fault> {
        match p.g(Group::OneShot) {
            Some(G4) if matches!(motion, Some(G2 | G3)) => {
                Err(wrong(span, "G4 in a block with an arc: both take P", "write them in blocks of their own"))
            }
            Some(G4) if matches!(motion, Some(G74 | G82 | G84 | G86 | G88 | G89)) => {
                Err(wrong(span, "G4 in a block with a cycle: both take P", "write them in blocks of their own"))
            }
            Some(G10) => self.data_rules(p, span),
            Some(G53) if !matches!(motion, Some(G0 | G1)) => {
                Err(wrong(span, "G53 needs a motion with G0 or G1", "write G0 or G1 with G53, and its axes"))
            }
            Some(G53) if p.g(Group::Distance).map_or(self.modal.incremental, |code| code == G91) => {
                let message = "G53 under G91: the control refuses both a position and an increment";
                Err(wrong(span, message, "write G90 G53"))
            }
            _ => Ok(()),
        }
    }

    /// G10.
    fn data_rules(&self, p: &Pending, span: Span) -> Result<(), Fault> {
        let list = p.peek(b'L').unwrap_or(-1.0);
        if ![0.0, 1.0, 2.0, 10.0, 11.0, 20.0].contains(&list) {
            return Err(wrong(span, "G10 has no L0, L1, L2, L10, L11 or L20", "write G10 L2 P1 X0 Y0 Z0"));
        }
        if list == 0.0 {
            return Ok(());
        }
        let number = p.peek(b'P').unwrap_or(-1.0);
        let (least, most) = if list == 2.0 || list == 20.0 { (0.0, 9.0) } else { (1.0, f64::INFINITY) };
        if number.fract().abs() > NOT_WHOLE || number < least || number > most {
            let message = format!("P of G10 L{list} is a whole number from {least} and is {number}");
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("write G10 L2 P1"));
        }
        if list == 1.0 && p.axes() == 0 && !p.any_free(b"RIJQ") {
            return Err(wrong(span, "G10 L1 names no value of the tool", "write G10 L1 P1 Z50"));
        }
        if list == 20.0 && p.has(b'R') {
            return Err(wrong(span, "R with G10 L20", "write R with G10 L2"));
        }
        if (list == 2.0 || list == 20.0) && p.any_free(b"IJQ") {
            return Err(wrong(span, "I, J and Q of G10 belong to tools", "remove them"));
        }
        Ok(())
    }

    fn functions_of_one_group(&self, p: &Pending, span: Span) -> Result<(), Fault> {
        let listed: Vec<u32> = p.m().iter().filter_map(|&m| self.function_number(m)).collect();
        if listed.len() > MOST_M {
            return Err(wrong(span, format!("the block has more than {MOST_M} M words"), "write several blocks"));
        }
        for (at, &m) in listed.iter().enumerate() {
            let group = group_of(m);
            if let Some(&other) = listed[..at].iter().find(|&&other| group.is_some() && group_of(other) == group) {
                let message = format!("M{other} and M{m} exclude each other in a block");
                return Err(wrong(span, message, "write them in blocks of their own"));
            }
        }
        Ok(())
    }

    /// Number of an M word of the block, as it is written.
    fn function_number(&self, m: u32) -> Option<u32> {
        if m >= LISTED {
            let listed = self.settings.control.words.at((m - LISTED) as usize)?;
            return listed.word.strip_prefix('M')?.parse().ok();
        }
        (m < NOTED_G).then_some(m)
    }

    fn letters_of_words(&self, p: &Pending, motion: Option<GCode>, span: Span) -> Result<(), Fault> {
        const GROUPS: [Group; 5] =
            [Group::OneShot, Group::CutterComp, Group::ToolLength, Group::SpindleMode, Group::PathMode];
        for rule in &LETTERS {
            if !p.has(rule.letter) {
                continue;
            }
            let used = motion.is_some_and(|code| rule.motions.contains(&code))
                || GROUPS.into_iter().filter_map(|group| p.g(group)).any(|code| rule.others.contains(&code))
                || p.m().iter().any(|&m| self.function_takes(m, rule));
            if !used {
                let letter = char::from(rule.letter);
                let message = format!("`{letter}` without a word that takes it");
                let words: Vec<String> = rule
                    .motions
                    .iter()
                    .chain(rule.others)
                    .filter(|code| !matches!(**code, GCode(70..=72, _) | G76 | G87 | G88))
                    .map(ToString::to_string)
                    .chain(rule.functions.iter().map(|m| format!("M{m}")))
                    .collect();
                let help = if words.is_empty() {
                    "remove it".to_owned()
                } else {
                    format!("remove it; it goes with {}", words.join(", "))
                };
                return Err(Fault::new(codes::UNKNOWN_WORD, span, message).help(help));
            }
        }
        Ok(())
    }

    /// An M word takes this letter: by its own meaning, by the control file, or as one of the
    /// user's (M100 to M199, P and Q).
    fn function_takes(&self, m: u32, rule: &Letter) -> bool {
        if let Some(number) = self.function_number(m)
            && (rule.functions.contains(&number) || (100..=199).contains(&number) && matches!(rule.letter, b'P' | b'Q'))
        {
            return true;
        }
        m.checked_sub(LISTED)
            .and_then(|at| self.settings.control.words.at(at as usize))
            .is_some_and(|listed| listed.values.contains(&rule.letter))
    }

    fn motion_rules(&self, p: &Pending, motion: Option<GCode>, span: Span) -> Result<(), Fault> {
        let has_m = |range: std::ops::RangeInclusive<u32>| {
            p.m().iter().any(|&m| self.function_number(m).is_some_and(|m| range.contains(&m)))
        };
        if has_m(62..=65) && p.peek(b'P').is_none_or(|v| v < 0.0 || v.fract() != 0.0) {
            let message = "M62 to M65 need the number of the output in P";
            return Err(Fault::new(codes::MISSING_VALUE, span, message).help("write M62 P0"));
        }
        if has_m(19..=19) {
            let places = p.peek(b'P').is_some_and(|v| ![0.0, 1.0, 2.0].contains(&v));
            if places || p.peek(b'R').is_some_and(|v| !(0.0..=360.0).contains(&v)) {
                let message = "M19 takes an angle R from 0 to 360 and P0, P1 or P2";
                return Err(Fault::new(codes::BAD_VALUE, span, message).help("write M19 R90"));
            }
        }
        let Some(motion) = motion else { return Ok(()) };
        let name = motion.to_string();
        let feed_mode = match p.g(Group::FeedMode) {
            Some(G93) => FeedMode::InverseTime,
            Some(G94) => FeedMode::PerTime,
            Some(_) => FeedMode::PerRevolution,
            None => self.modal.feed_mode,
        };
        let turns = p.m().iter().find_map(|m| match m {
            3 => Some(SpindleDirection::Clockwise),
            4 => Some(SpindleDirection::CounterClockwise),
            5 | 6 | 19 => Some(SpindleDirection::Off),
            _ => None,
        });
        let turns = turns.unwrap_or(self.technology.direction);
        let compensated = match p.g(Group::CutterComp) {
            Some(code) => code != G40,
            None => self.modal.comp != CompSide::Off,
        };
        if p.g(Group::ToolLength) == Some(G43_2) && p.has(b'H') && p.axes() != 0 {
            return Err(wrong(span, "G43.2 has H and axis letters", "write one of the two"));
        }
        let in_feed = matches!(motion, G1 | G2 | G3 | GCode(73 | 74 | 81..=89, 0));
        if in_feed && self.settings.default_feed_mm_per_min.is_none() && !self.has_feed(p, feed_mode) {
            return Err(self.no_feed(span));
        }
        if motion == G5_1 && !(p.has(b'I') && p.has(b'J')) {
            return Err(Fault::new(codes::MISSING_VALUE, span, "G5.1 needs I and J").help("write both"));
        }
        // The S of G96 counts too.
        let in_force = self.technology.speed.or(self.modal.surface.map(|(surface, _)| surface));
        let speed = p.peek(b'S').or(in_force).unwrap_or(0.0);
        if matches!(motion, G1 | G2 | G3) && feed_mode == FeedMode::PerRevolution && speed == 0.0 {
            return Err(wrong(span, format!("{name} in G95 has no spindle speed"), "write S before it"));
        }
        match motion {
            G2 | G3 => return self.arc_rules(p, &name, span),
            G33 | G33_1 => {
                if p.has(b'F') {
                    return Err(wrong(span, format!("F with {name}, whose feed is K"), "remove F"));
                }
                if !p.has(b'K') {
                    return Err(Fault::new(codes::MISSING_VALUE, span, format!("{name} has no K"))
                        .help("write the pitch in the block"));
                }
                if turns == SpindleDirection::Off {
                    return Err(wrong(span, format!("the spindle is stopped in {name}"), "write M3 or M4 before it"));
                }
            }
            GCode(38, 2..=5) if feed_mode != FeedMode::PerTime => {
                return Err(wrong(span, format!("{name} needs a feed in G94"), "write G94 and F"));
            }
            GCode(73 | 74 | 81..=89, 0) => {
                if compensated {
                    let message = format!("{name} under cutter compensation");
                    return Err(wrong(span, message, "write G40 before it"));
                }
                if feed_mode == FeedMode::InverseTime {
                    return Err(wrong(span, format!("{name} under G93"), "write G94 and F"));
                }
                return self.cycle_rules(p, motion, turns, span);
            }
            _ => {}
        }
        Ok(())
    }

    /// F of the block, or the feed in force where no word has taken it away.
    fn has_feed(&self, p: &Pending, mode: FeedMode) -> bool {
        let kept = self.own.feed.filter(|_| p.g(Group::FeedMode).is_none() && mode != FeedMode::InverseTime);
        p.peek(b'F').or(kept).is_some_and(|feed| feed > 0.0)
    }

    fn arc_rules(&self, p: &Pending, name: &str, span: Span) -> Result<(), Fault> {
        let normal = self.plane_of(p);
        let letters = *b"IJK";
        if p.has(letters[normal]) {
            let letter = char::from(letters[normal]);
            let message = format!("`{letter}` does not lie in the working plane of {name}");
            return Err(wrong(span, message, "choose the plane with G17, G18 or G19"));
        }
        let absolute = p.g(Group::ArcDistance).map_or(self.modal.absolute_centers, |code| code == G90_1);
        if absolute && !p.has(b'R') {
            for axis in (0..3).filter(|&axis| axis != normal) {
                if !p.has(letters[axis]) {
                    let message = format!("{name} with absolute centers has no `{}`", char::from(letters[axis]));
                    return Err(Fault::new(codes::MISSING_VALUE, span, message).help("write both, or G91.1"));
                }
            }
        }
        Ok(())
    }

    fn cycle_rules(&self, p: &Pending, code: GCode, turns: SpindleDirection, span: Span) -> Result<(), Fault> {
        let name = code.to_string();
        for letter in *b"ABC" {
            if p.any_free(&[letter]) {
                let message = format!("the rotary axis {} in the block of {name}", char::from(letter));
                return Err(wrong(span, message, "turn it in a block of its own, before the cycle"));
            }
        }
        if p.peek(b'L') == Some(0.0) {
            return Err(wrong(span, format!("L0 repeats {name} zero times"), "remove L"));
        }
        let turns_wrongly = match code {
            G74 => turns == SpindleDirection::Clockwise,
            G84 => turns == SpindleDirection::CounterClockwise,
            _ => false,
        };
        if turns_wrongly || matches!(code, G74 | G84) && turns == SpindleDirection::Off {
            let (word, thread) = if code == G84 { ("M3", "right-hand") } else { ("M4", "left-hand") };
            let message = format!("{name} cuts a {thread} thread, and the spindle does not turn with {word}");
            return Err(wrong(span, message, format!("write {word} before it")));
        }
        if code == G86 && turns == SpindleDirection::Off {
            return Err(wrong(span, format!("the spindle is stopped in {name}"), "write M3 or M4 before it"));
        }
        // The interpreter takes Q-1 for no Q, and drills with the infeed of the block before.
        if matches!(code, G73 | G83) && p.peek(b'Q').is_some_and(|q| q <= 0.0) {
            return Err(wrong(span, format!("the infeed Q of {name} must be above zero"), "write Q1"));
        }
        if self.modal.cycle == Some(code) {
            return Ok(());
        }
        // Values of another cycle do not count for this one.
        let depth = AXES[self.plane_of(p)];
        let needed = self.cycles().words(code).iter().filter(|word| word.written).filter_map(|word| match word.key {
            Key::Letter(letter) if letter != b'Z' => Some(letter),
            _ => None,
        });
        for letter in needed.chain([depth]) {
            if !p.has(letter) {
                let message = format!("{name} has no `{}` in its first block", char::from(letter));
                return Err(Fault::new(codes::MISSING_VALUE, span, message)
                    .help(format!("write {name} with its own depth and R plane")));
            }
        }
        Ok(())
    }
}
