//! Klartext: one block of text to one [`Block`].

use super::expr;
use super::lexer::{Lexer, refused, unknown};
use super::statements;
use super::takes::{self, PathWord};
use super::words::{
    Block, Coordinate, FeedWord, FreeKind, Kind, Lead, PathFunction, RadiusSide, Reference, Statement, Words,
};
use crate::AxisValues;
use crate::codes;
use crate::diagnostic::{Fault, Span, twice};
use crate::dialect::foreign::{KLARTEXT, told};

/// Reads a block.
pub(crate) fn parse(text: &str, block: &mut Block) -> Result<(), Fault> {
    read(text, block).map_err(|fault| told(fault, text, KLARTEXT))
}

fn read(text: &str, block: &mut Block) -> Result<(), Fault> {
    block.clear();
    let mut x = Lexer::new(text);
    let start = head(&mut x, block);
    if x.s.at_end() || x.s.peek() == b'*' || x.s.peek() == b'%' {
        // `* - text` is a structure comment.
        return Ok(());
    }
    if x.peek() == b'L' && !x.peek_at(1).is_ascii_alphabetic() {
        x.s.bump();
        block.statement = Statement::Path(PathFunction::Line);
        path_words(&mut x, block, PathFunction::Line)?;
    } else {
        statement(&mut x, block, start)?;
    }
    let end = text.get(..x.pos()).map_or(x.pos(), |t| t.trim_end().len());
    block.span = Span::new(start, end.max(start));
    Ok(())
}

/// Block number and `/`; returns the position of the first word.
pub(crate) fn head(x: &mut Lexer<'_>, block: &mut Block) -> usize {
    x.blanks();
    for _ in 0..2 {
        if x.s.take(b'/') {
            block.skip = true;
            x.blanks();
        }
        // Editors for many controls write `N10` for the number of the block.
        if x.peek() == b'N' && x.peek_at(1).is_ascii_digit() {
            x.s.bump();
        }
        while x.s.peek().is_ascii_digit() {
            x.s.bump();
        }
        x.blanks();
    }
    x.pos()
}

fn statement(x: &mut Lexer<'_>, block: &mut Block, start: usize) -> Result<(), Fault> {
    if x.peek() == b'Q' || x.at("?") {
        if let Some(param) = x.param()? {
            return assignment(x, block, param, start);
        }
        return Err(x.unexpected());
    }
    let word = x.letters();
    let path = match word.as_str() {
        "L" => Some(PathFunction::Line),
        "LN" => Some(PathFunction::Normal),
        "LP" => Some(PathFunction::PolarLine),
        "C" if !matches!(x.s.peek(), b'+' | b'-' | b'0'..=b'9') => Some(PathFunction::Arc),
        "CC" => Some(PathFunction::Pole),
        "CR" => Some(PathFunction::Radius),
        "CT" => Some(PathFunction::Tangent),
        "CP" => Some(PathFunction::PolarArc),
        "CTP" => Some(PathFunction::PolarTangent),
        "RND" => Some(PathFunction::Round),
        "CHF" => Some(PathFunction::Chamfer),
        "APPR" => Some(PathFunction::Approach(lead(x, start)?)),
        "DEP" => Some(PathFunction::Depart(lead(x, start)?)),
        "FL" => Some(PathFunction::Free(FreeKind::Line)),
        "FLT" => Some(PathFunction::Free(FreeKind::LineTangent)),
        "FC" => Some(PathFunction::Free(FreeKind::Arc)),
        "FCT" => Some(PathFunction::Free(FreeKind::ArcTangent)),
        "FPOL" => Some(PathFunction::FreePole),
        _ => None,
    };
    if let Some(path) = path {
        block.statement = Statement::Path(path);
        return path_words(x, block, path);
    }
    if statements::statement(x, &word, start, block)? {
        return Ok(());
    }
    // Written without blanks, `LX+10`; or a positioning block without L, `X+10 R0`; or M functions alone.
    x.set_pos(start);
    let compact = [
        ("CTP", PathFunction::PolarTangent),
        ("LN", PathFunction::Normal),
        ("LP", PathFunction::PolarLine),
        ("CP", PathFunction::PolarArc),
        ("CR", PathFunction::Radius),
        ("CC", PathFunction::Pole),
        ("CT", PathFunction::Tangent),
        ("L", PathFunction::Line),
        ("C", PathFunction::Arc),
    ];
    for (name, path) in compact {
        let rest = word.strip_prefix(name).unwrap_or_default();
        if matches!(
            rest,
            "X" | "Y"
                | "Z"
                | "A"
                | "B"
                | "C"
                | "U"
                | "V"
                | "W"
                | "IX"
                | "IY"
                | "IZ"
                | "IA"
                | "IB"
                | "IC"
                | "PR"
                | "PA"
                | "IPR"
                | "IPA"
                | "NX"
                | "DR"
                | "F"
                | "M"
                | "R"
                | "RL"
                | "RR"
        ) {
            x.set_pos(start + name.len());
            block.statement = Statement::Path(path);
            return path_words(x, block, path);
        }
    }
    if matches!(word.as_str(), "M" | "F" | "FMAX" | "R" | "RL" | "RR") {
        block.statement = Statement::Path(PathFunction::Nothing);
        return path_words(x, block, PathFunction::Nothing);
    }
    let axis = word.strip_prefix('I').unwrap_or(&word);
    if axis.len() == 1 && AxisValues::index(axis.chars().next().unwrap_or(' ')).is_some() {
        block.statement = Statement::Path(PathFunction::Line);
        return path_words(x, block, PathFunction::Line);
    }
    Err(x.unexpected())
}

fn assignment(x: &mut Lexer<'_>, block: &mut Block, param: super::words::Param, start: usize) -> Result<(), Fault> {
    x.blanks();
    if !x.s.take(b'=') {
        return Err(Fault::new(codes::SYNTAX, x.span_from(start), format!("`=` is missing after `{}`", param.name()))
            .help(format!("write {} = 5", param.name())));
    }
    if param.kind == Kind::Text {
        x.prefix("DECLARE STRING");
    }
    block.statement = Statement::Assign(param, expr::formula(x)?);
    x.finish()
}

fn lead(x: &mut Lexer<'_>, start: usize) -> Result<Lead, Fault> {
    x.blanks();
    match x.letters().as_str() {
        // With P the point is given by PR and PA.
        "LT" | "PLT" => Ok(Lead::LineTangent),
        "LN" | "PLN" => Ok(Lead::LineNormal),
        "CT" | "PCT" => Ok(Lead::Circle),
        "LCT" | "PLCT" => Ok(Lead::LineCircle),
        "" => Err(Fault::new(codes::SYNTAX, x.span_from(start), "the form of approach or departure is missing")
            .help("write LT, LN, CT or LCT")),
        other => Err(unknown(other, x.span_from(start))),
    }
}

/// Reads the words of a path block.
pub(crate) fn path_words(x: &mut Lexer<'_>, block: &mut Block, path: PathFunction) -> Result<(), Fault> {
    let words = &mut block.words;
    if path == PathFunction::Chamfer {
        x.blanks();
        if matches!(x.s.peek(), b'0'..=b'9' | b'.' | b'+' | b'-' | b'Q' | b'q') {
            words.length = x.value()?;
        }
    }
    loop {
        x.blanks();
        if x.s.at_end() {
            return Ok(());
        }
        word(x, words, path)?;
    }
}

/// A word without a value, as older controls write it: `L X+10 R F M`.
fn empty(x: &Lexer<'_>) -> bool {
    let mut probe = x.clone();
    matches!(probe.s.peek(), b' ' | b'\t' | b'\n' | 0) && {
        probe.blanks();
        probe.s.at_end() || matches!(probe.peek(), b'F' | b'M') && !probe.at("MAX")
    }
}

/// Index of an axis letter.
fn axis(byte: u8) -> Option<usize> {
    Some(match byte {
        b'X' => 0,
        b'Y' => 1,
        b'Z' => 2,
        b'A' => 3,
        b'B' => 4,
        b'C' => 5,
        b'U' => 6,
        b'V' => 7,
        b'W' => 8,
        _ => return None,
    })
}

fn put_axis(words: &mut Words, index: usize, coordinate: Coordinate, span: Span) -> Result<(), Fault> {
    if words.programmed >> index & 1 == 1 {
        return Err(twice(crate::AXIS_LETTERS[index], span));
    }
    words.axes[index] = Some(coordinate);
    words.programmed |= 1 << index;
    Ok(())
}

fn set<T>(slot: &mut Option<T>, value: T, word: &str, span: Span) -> Result<(), Fault> {
    if slot.replace(value).is_some() {
        return Err(twice(word, span));
    }
    Ok(())
}

fn word(x: &mut Lexer<'_>, words: &mut Words, path: PathFunction) -> Result<(), Fault> {
    let start = x.pos();
    let first = x.peek();
    let second = x.peek_at(1);
    let arc_lead = matches!(
        path,
        PathFunction::Approach(Lead::Circle) | PathFunction::Depart(Lead::Circle) | PathFunction::Free(_)
    );
    if first == b'C' && second == b'C' && x.peek_at(2) == b'A' && arc_lead {
        x.set_pos(start + 3);
        let value = x.need(start)?;
        return set(&mut words.arc_angle, value, "CCA", x.span_from(start));
    }
    if matches!(path, PathFunction::Free(_)) && free_word(x, words, start)? {
        return Ok(());
    }
    if let Some(index) = axis(first)
        && (!second.is_ascii_alphabetic() || second == b'Q')
    {
        x.s.bump();
        let value = x.need(start)?;
        takes::check(path, PathWord::Axis(index), x.s.slice(start), x.span_from(start))?;
        return put_axis(words, index, Coordinate { value, reference: Reference::Absolute }, x.span_from(start));
    }
    match (first, second) {
        (b'I', letter) if axis(letter).is_some() => {
            x.set_pos(start + 2);
            let value = x.need(start)?;
            let index = axis(letter).unwrap_or(0);
            takes::check(path, PathWord::Axis(index), x.s.slice(start), x.span_from(start))?;
            put_axis(words, index, Coordinate { value, reference: Reference::Incremental }, x.span_from(start))
        }
        (b'P', b'R' | b'A') | (b'I', b'P') => {
            let incremental = first == b'I';
            let at = usize::from(incremental);
            let which = x.peek_at(at + 1);
            if !matches!(which, b'R' | b'A') {
                return Err(x.unexpected());
            }
            x.set_pos(start + at + 2);
            let value = x.need(start)?;
            let reference = if incremental { Reference::Incremental } else { Reference::Absolute };
            let coordinate = Coordinate { value, reference };
            let (slot, name, kind) = if which == b'R' {
                (&mut words.polar_radius, "PR", PathWord::PolarRadius)
            } else {
                (&mut words.polar_angle, "PA", PathWord::PolarAngle)
            };
            takes::check(path, kind, x.s.slice(start), x.span_from(start))?;
            set(slot, coordinate, name, x.span_from(start))
        }
        (b'D', b'R') if matches!(x.peek_at(2), b'+' | b'-') => {
            let clockwise = x.peek_at(2) == b'-';
            x.set_pos(start + 3);
            takes::check(path, PathWord::Turn, x.s.slice(start), x.span_from(start))?;
            set(&mut words.clockwise, clockwise, "DR", x.span_from(start))
        }
        (b'R', _) => radius_word(x, words, path, start),
        (b'F', _) => {
            x.s.bump();
            if empty(x) && x.peek() != 0 {
                return Ok(());
            }
            let feed = x.feed(start)?;
            let kind = if feed == FeedWord::Max { PathWord::Rapid } else { PathWord::Feed };
            takes::check(path, kind, x.s.slice(start), x.span_from(start))?;
            set(&mut words.feed, feed, "F", x.span_from(start))
        }
        (b'M', _) => {
            x.s.bump();
            let function = super::functions::word(x, start)?;
            takes::check(path, PathWord::Function, x.s.slice(start), x.span_from(start))?;
            words.functions.push(function);
            Ok(())
        }
        (b'N' | b'T', b'X' | b'Y' | b'Z') => {
            if path != PathFunction::Normal {
                return Err(Fault::new(codes::CONFLICT, Span::new(start, start + 2), "a vector in a block without LN")
                    .help("write LN, or remove the vector"));
            }
            x.set_pos(start + 2);
            let value = x.need(start)?;
            let component = usize::from(second - b'X');
            let list = if first == b'N' { &mut words.normal } else { &mut words.vector };
            set(&mut list[component], value, "the component of the vector", x.span_from(start))
        }
        (b'L', b'E') if x.at("LEN") && has_length(path) => {
            x.set_pos(start + 3);
            let value = x.need(start)?;
            set(&mut words.length, value, "LEN", x.span_from(start))
        }
        _ => Err(x.unexpected()),
    }
}

/// LEN belongs to the block.
fn has_length(path: PathFunction) -> bool {
    matches!(
        path,
        PathFunction::Approach(Lead::LineTangent | Lead::LineNormal)
            | PathFunction::Depart(Lead::LineTangent | Lead::LineNormal)
            | PathFunction::Chamfer
            | PathFunction::Free(_)
    )
}

/// AN, CCX, CCY, CLSD of a free contour, if one is next.
fn free_word(x: &mut Lexer<'_>, words: &mut Words, start: usize) -> Result<bool, Fault> {
    if x.at("CLSD") && matches!(x.peek_at(4), b'+' | b'-') {
        let begins = x.peek_at(4) == b'+';
        x.set_pos(start + 5);
        set(&mut words.closed, begins, "CLSD", x.span_from(start))?;
        return Ok(true);
    }
    let (length, slot, name) = match (x.peek(), x.peek_at(1), x.peek_at(2)) {
        (b'A', b'N', _) => (2, &mut words.line_angle, "AN"),
        (b'C', b'C', b'X') => (3, &mut words.circle[0], "CCX"),
        (b'C', b'C', b'Y') => (3, &mut words.circle[1], "CCY"),
        _ => return Ok(false),
    };
    x.set_pos(start + length);
    let value = x.need(start)?;
    set(slot, value, name, x.span_from(start))?;
    Ok(true)
}

fn radius_word(x: &mut Lexer<'_>, words: &mut Words, path: PathFunction, start: usize) -> Result<(), Fault> {
    x.s.bump();
    let next = x.peek();
    if empty(x)
        && matches!(
            path,
            PathFunction::Line
                | PathFunction::Arc
                | PathFunction::PolarLine
                | PathFunction::PolarArc
                | PathFunction::Tangent
        )
    {
        return Ok(());
    }
    if matches!(next, b'L' | b'R') {
        x.s.bump();
        let side = if next == b'L' { RadiusSide::Left } else { RadiusSide::Right };
        takes::check(path, PathWord::Side, x.s.slice(start), x.span_from(start))?;
        return set(&mut words.side, side, "radius compensation", x.span_from(start));
    }
    let takes_radius = matches!(
        path,
        PathFunction::Radius
            | PathFunction::Round
            | PathFunction::Approach(Lead::Circle | Lead::LineCircle)
            | PathFunction::Depart(Lead::Circle | Lead::LineCircle)
            | PathFunction::Free(_)
    );
    if next == b'0' && !matches!(x.peek_at(1), b'0'..=b'9' | b'.') {
        x.s.bump();
        takes::check(path, PathWord::Side, x.s.slice(start), x.span_from(start))?;
        return set(&mut words.side, RadiusSide::Off, "radius compensation", x.span_from(start));
    }
    if !takes_radius {
        if matches!(next, b'+' | b'-') {
            x.s.bump();
            return Err(refused(
                "R+ R-",
                x.span_from(start),
                "paraxial compensation changes the path by the radius: program the path with RL or RR",
            ));
        }
        return Err(x.unexpected());
    }
    let value = x.need(start)?;
    set(&mut words.radius, value, "R", x.span_from(start))
}
