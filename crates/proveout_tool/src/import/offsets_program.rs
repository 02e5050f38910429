//! Tool offsets as a program: `G10 L10 P1 R152.4` (length) and `G10 L12 P1 R12.7` (diameter on a Haas), as
//! controls write them out.
//!
//! L10 is the length geometry, L11 its wear, L12 the geometry of the diameter, L13 its wear (HAAS, *Mill
//! operator's manual*, G10). A Fanuc writes the radius with L12: the program must say which it is, by
//! `--control`-like words in its comments, or the call. Here the value of L12 is the diameter, as a Haas has
//! it with its default setting 40, and a note says so. Wear is added.

use std::collections::BTreeMap;
use std::path::Path;

use proveout_input::InputError;

use super::{INCH_MM, ImportCall, Imported, linuxcnc_table::described};
use crate::draft::{ToolDraft, plain_number};

/// The text sets tool offsets.
pub(super) fn is_offsets_program(text: &str) -> bool {
    text.lines().any(|line| {
        let line = line.to_ascii_uppercase().replace(' ', "");
        line.contains("G10") && ["L10", "L11", "L12", "L13"].iter().any(|l| line.contains(l))
    })
}

#[derive(Default)]
struct Offsets {
    length: f64,
    diameter: f64,
    line: usize,
    remark: String,
    set: [usize; 4],
}

pub(super) fn read(file: &Path, text: &str, call: &ImportCall) -> Result<Imported, InputError> {
    let mut unit = call.unit.map(super::LengthUnit::mm);
    let mut all: BTreeMap<u32, Offsets> = BTreeMap::new();
    for (at, line) in text.lines().enumerate() {
        let (code, remark) = split(line);
        let words = words(&code);
        let value = |letter: char| words.iter().find(|(l, _)| *l == letter).map(|(_, v)| *v);
        let has = |g: f64| words.iter().any(|(l, v)| *l == 'G' && *v == g);
        if has(20.0) {
            unit = Some(INCH_MM);
        }
        if has(21.0) {
            unit = Some(1.0);
        }
        if !has(10.0) {
            continue;
        }
        let refused = |message: String| {
            InputError::file(file, message, "write G10 L10 P1 R152.4, a block for each offset").with_line(at + 1)
        };
        let kind = match value('L') {
            Some(l) if (10.0..=13.0).contains(&l) => l as usize - 10,
            _ => continue,
        };
        if has(91.0) {
            return Err(refused("an offset that is added to the one before (G91) is not known".into()));
        }
        let (Some(p), Some(r)) = (value('P'), value('R')) else {
            return Err(refused("the block has no P or no R".into()));
        };
        if !(1.0..=9999.0).contains(&p) || p.fract() != 0.0 {
            return Err(refused(format!("P{p} is not an offset number")));
        }
        let Some(unit) = unit else {
            return Err(call.stated_unit(file, "the text").err().unwrap_or_else(|| refused("no unit".into())));
        };
        let own = all.entry(p as u32).or_default();
        if own.set[kind] > 0 {
            let message =
                format!("offset {p} is set twice by L{}, in lines {} and {}", kind + 10, own.set[kind], at + 1);
            return Err(InputError::file(file, message, "keep one of them").with_line(at + 1));
        }
        own.set[kind] = at + 1;
        own.line = at + 1;
        if kind < 2 {
            own.length += r * unit
        } else {
            own.diameter += r * unit
        }
        if !remark.is_empty() {
            own.remark = remark;
        }
    }
    let mut imported = Imported { format: "program of tool offsets", ..Imported::default() };
    if all.values().any(|o| o.set[2] > 0) {
        imported.notes.push("L12 is read as the diameter, as on a Haas; a Fanuc writes the radius there".into());
    }
    for (number, own) in all {
        if !call.selects(number) {
            continue;
        }
        let mut draft = ToolDraft::new(number, format!("offsets, {}:{}", file.display(), own.line));
        if own.diameter > 0.0 {
            draft.put("diameter_mm", own.diameter);
        }
        if own.length > 0.0 {
            draft.gauge = Some(own.length);
        } else if own.length < 0.0 {
            let mm = plain_number(own.length);
            imported.notes.push(format!("T{number}: the length {mm} mm is negative, so that it does not count from the gauge line and is left out"));
        }
        described(&mut draft, &own.remark);
        imported.tools.push(draft);
    }
    Ok(imported)
}

/// Code and comment of a line.
fn split(line: &str) -> (String, String) {
    let (mut code, mut remark, mut depth) = (String::new(), String::new(), 0);
    for c in line.chars() {
        match c {
            ';' if depth == 0 => break,
            '(' => depth += 1,
            ')' if depth > 0 => depth -= 1,
            c if depth > 0 => remark.push(c),
            c => code.push(c.to_ascii_uppercase()),
        }
    }
    (code, remark.trim().to_owned())
}

/// Letters with numbers.
fn words(code: &str) -> Vec<(char, f64)> {
    let mut all = Vec::new();
    let mut rest = code.trim_start();
    while let Some(letter) = rest.chars().next() {
        let body = rest[letter.len_utf8()..].trim_start();
        let end = body.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+'))).unwrap_or(body.len());
        if let (true, Ok(value)) = (letter.is_ascii_alphabetic(), body[..end].parse()) {
            all.push((letter, value));
        }
        rest = body[end..].trim_start();
        if end == 0 && !letter.is_ascii_alphabetic() && rest.len() == body.len() {
            continue;
        }
    }
    all
}
