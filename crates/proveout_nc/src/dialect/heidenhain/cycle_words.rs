//! Words of cycles, in the old form and with Q parameters, and of hole patterns.

use super::lexer::{Lexer, refused, unknown};
use super::words::{Block, CycleValue, OldWord, Param, Pattern, PatternKind, Statement, Value};
use crate::cycle::heidenhain as table;
use crate::diagnostic::{Fault, Span};

/// Cycles in the old form, `CYCL DEF 7.1`, that are read.
const OLD_CYCLES: [u32; 16] = [1, 2, 4, 5, 7, 8, 9, 10, 11, 12, 13, 17, 19, 26, 32, 247];
/// Cycles that builders of machines add.
pub(crate) const BUILDER: std::ops::RangeInclusive<u32> = 300..=399;

pub(crate) fn cycle(x: &mut Lexer<'_>, start: usize, block: &mut Block) -> Result<(), Fault> {
    x.blanks();
    match x.letters().as_str() {
        "CALL" => {
            block.statement = if x.word("POS") {
                Statement::CycleCallPos
            } else if x.word("PAT") {
                Statement::CycleCallPattern
            } else {
                Statement::CycleCall
            };
            let kind = if block.statement == Statement::CycleCallPos {
                super::words::PathFunction::Line
            } else {
                super::words::PathFunction::Nothing
            };
            super::parser::path_words(x, block, kind)
        }
        "DEF" => {
            x.blanks();
            let Some(number) = x.s.integer() else { return Err(x.unexpected()) };
            let span = x.span_from(start);
            // Typed by hand: `CYCL DEF 9 .0`.
            x.blanks();
            block.statement = if x.s.take(b'.') {
                let part = x.s.integer().ok_or_else(|| x.unexpected())?;
                if !OLD_CYCLES.contains(&number) {
                    return Err(not_read(number, span));
                }
                old_cycle(x, number, part)?
            } else {
                check_cycle(number, span)?;
                Statement::Cycle { number, values: cycle_values(x)? }
            };
            Ok(())
        }
        _ => Err(unknown("CYCL", x.span_from(start))),
    }
}

/// Refuses cycles with Q parameters that are not read. Of those of the machine builder a control file says
/// what they mean.
pub(crate) fn check_cycle(number: u32, span: Span) -> Result<(), Fault> {
    let read = BUILDER.contains(&number) || number >= 100 && table::spec(number).is_some();
    if read { Ok(()) } else { Err(not_read(number, span)) }
}

/// The fault of a cycle that is not read, with a remedy for its kind.
fn not_read(number: u32, span: Span) -> Fault {
    let remedy = match number {
        267 => "how the tool comes onto the outer thread is not published to the point: write the helix as CP blocks",
        255 | 258..=269 | 277..=299 => {
            "post the path as L and C blocks; of the milling cycles 208, 230 to 233, 251 to 254, 256, 257 and 262 to 265 are read"
        }
        14 | 20..=24 | 270..=276 => {
            "the path on which the control clears a contour (SL cycles) is not published: post the path as L and C blocks"
        }
        25 | 27..=31 | 39 | 216..=239 => "post the path as L and C blocks",
        3 | 6 | 15 | 16 => "post the path as L and C blocks",
        400..=499 => {
            "the twin does not measure: remove the cycle and give its result with --variable or in the control file"
        }
        _ => "write its motions with L blocks",
    };
    refused(&format!("CYCL DEF {number}"), span, remedy)
}

fn old_cycle(x: &mut Lexer<'_>, number: u32, part: u32) -> Result<Statement, Fault> {
    if part == 0 {
        x.rest();
        return Ok(Statement::OldCycle { number, part, words: Vec::new() });
    }
    if number == 12 {
        x.word("PGM");
        let name = match x.quoted()? {
            Some(name) => name,
            None => x.rest().to_owned(),
        };
        return Ok(Statement::OldCycleProgram(name));
    }
    let mut words = Vec::new();
    loop {
        x.blanks();
        if x.s.at_end() {
            return Ok(Statement::OldCycle { number, part, words });
        }
        let start = x.pos();
        if !x.s.take(b'#') {
            while x.peek().is_ascii_alphabetic() && !parameter_at(x, 0)
                || x.pos() > start
                    && (matches!(x.peek(), b'.' | b':') && !x.peek_at(1).is_ascii_digit()
                        || x.peek() == b'-' && x.peek_at(1).is_ascii_alphabetic() && !parameter_at(x, 1))
            {
                x.s.bump();
            }
        }
        let mut name = x.s.slice(start).to_ascii_uppercase();
        if name == "DR" && matches!(x.s.peek(), b'+' | b'-') {
            name.push(if x.s.take(b'+') { '+' } else { '-' });
            x.s.take(b'-');
        }
        x.s.take(b':');
        let before = x.pos();
        x.blanks();
        let signed = matches!(x.s.peek(), b'+' | b'-' | b'0'..=b'9' | b'.' | b'Q' | b'q');
        let value = if signed { x.value()? } else { None };
        if value.is_none() {
            x.set_pos(before);
            if name.is_empty() {
                return Err(x.unexpected());
            }
        }
        words.push(OldWord { name, value, span: x.span_from(start) });
    }
}

/// `Q1`, `QL1`, `QR1` so many bytes ahead.
fn parameter_at(x: &Lexer<'_>, ahead: usize) -> bool {
    x.peek_at(ahead) == b'Q'
        && (x.peek_at(ahead + 1).is_ascii_digit()
            || matches!(x.peek_at(ahead + 1), b'L' | b'R') && x.peek_at(ahead + 2).is_ascii_digit())
}

/// `Q200=+2 ;SET-UP CLEARANCE ~ ...`, `Q206 FAUTO`; the name of the cycle before them is skipped.
pub(crate) fn cycle_values(x: &mut Lexer<'_>) -> Result<Vec<(Param, CycleValue, Span)>, Fault> {
    let mut values = Vec::new();
    loop {
        x.blanks();
        if x.s.at_end() {
            return Ok(values);
        }
        let start = x.pos();
        let assigned = match x.param() {
            Ok(Some(param)) => {
                x.blanks();
                // A feed by name may also come without `=`.
                (x.s.take(b'=') || !values.is_empty() && ["FAUTO", "FMAX", "FU"].iter().any(|word| x.at(word)))
                    .then_some(param)
            }
            _ => None,
        };
        let Some(param) = assigned else {
            if values.is_empty() {
                // Name of the cycle, in the language of the control.
                x.set_pos(start);
                while !x.s.at_end() && !matches!(x.s.peek(), b' ' | b'\t' | b'\n' | b';') {
                    x.s.bump();
                }
                continue;
            }
            x.set_pos(start);
            return Err(x.unexpected());
        };
        let value = cycle_value(x, start)?;
        values.push((param, value, x.span_from(start)));
    }
}

fn cycle_value(x: &mut Lexer<'_>, start: usize) -> Result<CycleValue, Fault> {
    x.blanks();
    if x.peek() == b'"' {
        let text = x.quoted()?.unwrap_or_default();
        return Err(refused(&format!("\"{text}\""), x.span_from(start), "write a number"));
    }
    for (word, value) in
        [("FMAX", CycleValue::Max), ("MAX", CycleValue::Max), ("FAUTO", CycleValue::Auto), ("AUTO", CycleValue::Auto)]
    {
        if x.word(word) {
            return Ok(value);
        }
    }
    if x.word("PREDEF") {
        return Err(refused("PREDEF", x.span_from(start), "write the value into the cycle"));
    }
    if x.prefix("FU") {
        return Ok(CycleValue::PerRevolution(x.need(start)?));
    }
    if x.prefix("FZ") {
        return Err(refused("FZ", x.span_from(start), "the number of teeth is in the tool table: write mm/min"));
    }
    x.need(start).map(CycleValue::Value)
}

/// Words of a pattern, the longer ones first.
const PATTERN_WORDS: [&str; 14] =
    ["NUMX", "NUMY", "NUM", "ROTX", "ROTY", "ROT", "START", "STEP", "DX", "DY", "D", "X", "Y", "Z"];

/// `POS1 (X+10 Y+20 Z+0) ~ ROW1 (X+25 Y+33 D+8 NUM5 ROT+0 Z+0)`.
pub(crate) fn pattern(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    if !x.word("DEF") {
        return Err(x.unexpected());
    }
    let mut patterns = Vec::new();
    while !x.ended() {
        let at = x.pos();
        let forms = [
            ("PITCHCIRC", PatternKind::Sector),
            ("CIRC", PatternKind::Circle),
            ("FRAME", PatternKind::Frame),
            ("PAT", PatternKind::Grid),
            ("ROW", PatternKind::Row),
            ("POS", PatternKind::Point),
        ];
        let Some((_, kind)) = forms.into_iter().find(|(word, _)| x.prefix(word)) else {
            let word = x.clone().letters();
            return Err(if word.is_empty() {
                x.unexpected()
            } else {
                refused(
                    &format!("PATTERN DEF {word}"),
                    x.span_from(start),
                    "write POS, ROW, PAT, FRAME, CIRC or PITCHCIRC",
                )
            });
        };
        x.s.integer();
        x.blanks();
        if !x.s.take(b'(') {
            return Err(x.unexpected());
        }
        let mut values: Vec<(&'static str, Value)> = Vec::new();
        loop {
            x.blanks();
            if x.s.take(b')') {
                break;
            }
            let at = x.pos();
            let taken = |word: &str| match kind {
                PatternKind::Point => matches!(word, "X" | "Y" | "Z"),
                PatternKind::Row => matches!(word, "X" | "Y" | "Z" | "D" | "NUM" | "ROT"),
                PatternKind::Grid | PatternKind::Frame => !matches!(word, "D" | "NUM" | "START" | "STEP"),
                PatternKind::Circle => matches!(word, "X" | "Y" | "Z" | "D" | "NUM" | "START"),
                PatternKind::Sector => matches!(word, "X" | "Y" | "Z" | "D" | "NUM" | "START" | "STEP"),
            };
            let Some(word) = PATTERN_WORDS.into_iter().find(|word| taken(word) && x.prefix(word)) else {
                return Err(x.unexpected());
            };
            if values.iter().any(|(other, _)| *other == word) {
                return Err(crate::diagnostic::twice(word, x.span_from(at)));
            }
            values.push((word, x.need(at)?));
        }
        patterns.push(Pattern { kind, values, span: x.span_from(at) });
    }
    Ok(Statement::Pattern(patterns))
}
