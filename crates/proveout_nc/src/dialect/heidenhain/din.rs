//! DIN/ISO form of the TNC: G functions to the same blocks as Klartext.
//!
//! Words after HEIDENHAIN, *TNC 640 DIN/ISO programming*, "Overview of G functions": path functions are
//! modal, I J K set the pole (as CC), R and H are polar radius and angle, `L1,3` repeats, `D00` to `D14`
//! calculate and jump, `%NAME` calls a program.

use super::lexer::{Lexer, refused, unknown};
use super::words::{
    Block, Condition, Coordinate, CycleValue, DinBlock, DinWords, FeedWord, Label, OldWord, Param, PathFunction,
    RadiusSide, Reference, Relation, Statement, ToolCall, ToolRef, Value,
};
use super::{cycle_words, din_words, q_functions, statements};
use crate::AxisValues;
use crate::codes;
use crate::diagnostic::{Fault, Span, twice};

/// Reads a block.
pub(crate) fn parse(text: &str, block: &mut Block) -> Result<(), Fault> {
    block.clear();
    // The star ends a block; a comment may follow it.
    let code = text.find(';').map_or(text, |at| &text[..at]);
    let end = code.rfind('*').filter(|at| code[at + 1..].trim().is_empty()).unwrap_or(text.len());
    let body = if end < text.len() && !text[..end].trim_start().is_empty() { &text[..end] } else { text };
    let mut x = Lexer::din(body);
    x.blanks();
    if x.s.take(b'/') {
        block.skip = true;
        x.blanks();
    }
    if x.peek() == b'N' && matches!(x.peek_at(1), b'0'..=b'9' | b' ') {
        x.s.bump();
        x.blanks();
        while x.s.peek().is_ascii_digit() {
            x.s.bump();
        }
        x.blanks();
        if x.s.take(b'/') {
            block.skip = true;
        }
    }
    x.blanks();
    let start = x.pos();
    if x.s.at_end() || x.s.peek() == b'*' || x.s.peek() == b'(' {
        return Ok(());
    }
    let mut probe = x.clone();
    if probe.letters().len() >= 4 {
        // PLANE, FUNCTION TCPM and the like are written as in Klartext.
        let offset = start;
        let mut inner = Block::default();
        let shift = |span: Span| Span { start: span.start + offset as u32, end: span.end + offset as u32 };
        super::parser::parse(&body[offset..], &mut inner).map_err(|f| Fault { span: shift(f.span), ..f })?;
        inner.skip = block.skip;
        inner.span = shift(inner.span);
        *block = inner;
        return Ok(());
    }
    let mut raw = DinWords::default();
    while !x.ended() {
        word(&mut x, &mut raw, block)?;
    }
    block.span = Span::new(start, body.trim_end().len().max(start));
    let present = din_words::present(&raw, block);
    block.statement = meaning(raw, block)?;
    din_words::all_used(&present, &block.statement, block.span)
}

fn word(x: &mut Lexer<'_>, raw: &mut DinWords, block: &mut Block) -> Result<(), Fault> {
    let start = x.pos();
    let (first, second) = (x.peek(), x.peek_at(1));
    if let Some(axis) = AxisValues::index(char::from(first)) {
        x.s.bump();
        let value = if raw.g.iter().any(|(g, _)| *g == 28) {
            // G28 names axes to mirror.
            x.value()?.unwrap_or(Value::Number(0.0))
        } else {
            x.need(start)?
        };
        if block.words.programmed >> axis & 1 == 1 {
            return Err(Fault::new(
                codes::CONFLICT,
                x.span_from(start),
                format!("`{}` appears twice in the block", char::from(first)),
            )
            .help("remove one"));
        }
        block.words.axes[axis] = Some(Coordinate { value, reference: Reference::Modal });
        block.words.programmed |= 1 << axis;
        return Ok(());
    }
    match (first, second) {
        (b'G', _) => {
            x.s.bump();
            x.blanks();
            let Some(code) = x.s.integer() else {
                return Err(Fault::new(codes::MISSING_VALUE, x.span_from(start), "`G` has no number").help("write G01"));
            };
            raw.g.push((code, x.span_from(start)));
        }
        (b'D', b'L' | b'R') => {
            let which = if x.prefix("DR2") {
                2
            } else if x.prefix("DR") {
                1
            } else {
                x.set_pos(start + 2);
                0
            };
            let value = x.need(start)?;
            once(&mut raw.delta[which], value, "the delta value", x.span_from(start))?;
        }
        (b'D', b'0'..=b'9') => {
            x.s.bump();
            let number = x.s.integer().unwrap_or(99);
            if !matches!(number, 0..=16 | 19 | 20 | 29 | 37 | 38) {
                return Err(refused(
                    &format!("D{number:02}"),
                    x.span_from(start),
                    "assign the value to the Q parameter",
                ));
            }
            let target = if matches!(number, 0..=8 | 13) { x.param()? } else { None };
            once(&mut raw.function, (number, target), "D", x.span_from(start))?;
        }
        (b'I' | b'J' | b'K', _) => {
            x.s.bump();
            let value = x.need(start)?;
            let name = char::from(first).to_string();
            once(&mut raw.din.pole[usize::from(first - b'I')], value, &name, x.span_from(start))?;
        }
        (b'R', _) => {
            x.s.bump();
            let value = x.need(start)?;
            once(&mut raw.din.radius, value, "R", x.span_from(start))?;
        }
        (b'H', _) => {
            x.s.bump();
            let value = x.need(start)?;
            once(&mut raw.din.angle, value, "H", x.span_from(start))?;
        }
        (b'F', _) => {
            x.s.bump();
            let feed = x.feed(start)?;
            once(&mut block.words.feed, feed, "F", x.span_from(start))?;
        }
        (b'S', _) => {
            x.s.bump();
            let value = x.need(start)?;
            once(&mut raw.speed, value, "S", x.span_from(start))?;
        }
        (b'T', _) => {
            x.s.bump();
            let tool = match x.quoted()? {
                Some(name) => ToolRef::Name(name),
                None => ToolRef::Number(x.need(start)?),
            };
            once(&mut raw.tool, tool, "T", x.span_from(start))?;
        }
        (b'M', _) => {
            x.s.bump();
            let function = super::functions::word(x, start)?;
            block.words.functions.push(function);
        }
        (b'L', _) => {
            x.s.bump();
            let label = statements::label(x, start)?;
            x.blanks();
            let repeat = if x.s.take(b',') { Some(x.need(start)?) } else { None };
            once(&mut raw.label, (label, repeat), "L", x.span_from(start))?;
        }
        (b'P', _) => {
            x.s.bump();
            x.s.integer();
            if let Some(name) = x.quoted()? {
                raw.target = Some(Label::Name(name));
                return Ok(());
            }
            raw.values.push(x.need(start)?);
        }
        (b'Q', _) => {
            let Some(param) = x.param()? else { return Err(x.unexpected()) };
            x.blanks();
            if !x.s.take(b'=') {
                return Err(x.unexpected());
            }
            if raw.g.is_empty() {
                if raw.function.is_some() || raw.label.is_some() || raw.tool.is_some() {
                    x.set_pos(start);
                    return Err(x.unexpected());
                }
                let formula = super::expr::formula(x)?;
                x.finish()?;
                block.statement = Statement::Assign(param, formula);
                return Ok(());
            }
            for (word, value) in [
                ("FMAX", CycleValue::Max),
                ("MAX", CycleValue::Max),
                ("FAUTO", CycleValue::Auto),
                ("AUTO", CycleValue::Auto),
            ] {
                if x.word(word) {
                    raw.settings.push((param, value, x.span_from(start)));
                    return Ok(());
                }
            }
            let value = CycleValue::Value(x.need(start)?);
            raw.settings.push((param, value, x.span_from(start)));
        }
        (b'%', _) => {
            x.s.bump();
            let from = x.pos();
            while !x.s.at_end() && !matches!(x.s.peek(), b' ' | b'\t' | b'*' | b'\n') {
                x.s.bump();
            }
            raw.program = Some(x.s.slice(from).to_owned());
        }
        _ => return Err(x.unexpected()),
    }
    Ok(())
}

/// Stores a word that may appear only once in its block.
fn once<T>(slot: &mut Option<T>, value: T, word: &str, span: Span) -> Result<(), Fault> {
    if slot.replace(value).is_some() {
        return Err(twice(word, span));
    }
    Ok(())
}

/// What a block means.
fn meaning(mut raw: DinWords, block: &mut Block) -> Result<Statement, Fault> {
    if matches!(block.statement, Statement::Assign(..)) {
        return Ok(std::mem::replace(&mut block.statement, Statement::Empty));
    }
    let span = block.span;
    let missing =
        |what: &str| Fault::new(codes::MISSING_VALUE, span, format!("{what} is missing")).help(format!("write {what}"));
    if let Some(name) = raw.program.take() {
        let unit = raw.g.iter().find(|(g, _)| matches!(g, 70 | 71));
        return Ok(match unit {
            // The first line has no block number; the last one closes the program.
            Some((g, _)) if span.start == 0 => Statement::Begin { inch: *g == 70 },
            Some(_) => Statement::End,
            None => Statement::CallProgram(name),
        });
    }
    if let Some((number, target)) = raw.function {
        return function(number, target, &raw, span);
    }
    let mut special = None;
    for (code, at) in &raw.g {
        match code {
            0..=3 | 5 | 6 | 10..=13 | 15 | 16 => raw.din.path = Some(*code),
            17..=19 => {}
            29 => raw.din.pole_here = true,
            40 => block.words.side = Some(RadiusSide::Off),
            41 => block.words.side = Some(RadiusSide::Left),
            42 => block.words.side = Some(RadiusSide::Right),
            90 => raw.din.incremental = Some(false),
            91 => raw.din.incremental = Some(true),
            50 | 70 | 71 => {}
            code => {
                if let Some((other, _)) = special.replace((*code, *at)) {
                    let message = format!("G{other:02} and G{code:02} in one block, which may hold only one of them");
                    return Err(Fault::new(codes::CONFLICT, *at, message).help("write them in blocks of their own"));
                }
            }
        }
    }
    let reference = match raw.din.incremental {
        Some(true) => Reference::Incremental,
        Some(false) => Reference::Absolute,
        None => Reference::Modal,
    };
    if let Some((code, at)) = special {
        for c in block.words.axes.iter_mut().flatten() {
            c.reference = reference;
        }
        block.incremental = raw.din.incremental;
        return special_function(code, at, raw, block, reference);
    }
    if let Some((label, repeat)) = raw.label {
        return Ok(Statement::CallLabel { label, repeat });
    }
    let axis = raw.g.iter().find_map(|(g, _)| match g {
        17 => Some('Z'),
        18 => Some('Y'),
        19 => Some('X'),
        _ => None,
    });
    if raw.tool.is_some() || raw.speed.is_some() || axis.is_some() && block.words.programmed == 0 {
        let [length, radius, corner] = raw.delta;
        let call = ToolCall { tool: raw.tool, axis, speed: raw.speed, feed: block.words.feed, length, radius, corner };
        // G40, G90 and M functions in a block with T act as in a block of their own.
        let more = raw.din.path.is_some() || raw.din.incremental.is_some() || block.words.side.is_some();
        if more || !block.words.functions.is_empty() {
            return Ok(Statement::Din(Box::new(DinBlock { tool: Some(call), ..raw.din })));
        }
        return Ok(Statement::ToolCall(call));
    }
    if axis.is_some() {
        raw.din.tool = Some(ToolCall { axis, ..ToolCall::default() });
    }
    if raw.delta.iter().any(Option::is_some) {
        return Err(missing("T before the delta values"));
    }
    Ok(Statement::Din(Box::new(raw.din)))
}

fn special_function(
    code: u32,
    at: Span,
    raw: DinWords,
    block: &mut Block,
    reference: Reference,
) -> Result<Statement, Fault> {
    let span = block.span;
    let missing =
        |what: &str| Fault::new(codes::MISSING_VALUE, span, format!("{what} is missing")).help(format!("write {what}"));
    let number = |at: usize| raw.values.get(at).copied();
    let old = |number: u32, list: Vec<(u32, Value)>| {
        let words = list.into_iter().map(|(_, value)| OldWord { name: String::new(), value: Some(value), span });
        Statement::OldCycle { number, part: 1, words: words.collect() }
    };
    Ok(match code {
        4 => match block.words.feed {
            Some(FeedWord::Value(value)) => old(9, vec![(1, value)]),
            _ => return Err(missing("F with the seconds of G04")),
        },
        24 | 25 => {
            let size = raw.din.radius.ok_or_else(|| missing("R"))?;
            if code == 24 {
                block.words.length = Some(size);
                Statement::Path(PathFunction::Chamfer)
            } else {
                block.words.radius = Some(size);
                Statement::Path(PathFunction::Round)
            }
        }
        26 | 27 => {
            return Err(refused(&format!("G{code}"), at, "write the arc of approach or departure with G02 or G03"));
        }
        28 => Statement::TransMirror(true),
        30 | 31 => Statement::Note(format!("G{code}")),
        36 => Statement::Note("G36".to_owned()),
        38 => Statement::Stop,
        39 => match raw.target {
            Some(Label::Name(name)) => Statement::OldCycleProgram(name),
            _ => return Err(missing("P01 with the name of the program in quotes")),
        },
        51 | 99 => Statement::ToolDef(raw.tool.ok_or_else(|| missing("T"))?, String::new()),
        53 => Statement::DatumRow(number(0).ok_or_else(|| missing("P01 with the row"))?),
        54 => Statement::Datum(true),
        62 => {
            let tolerance = match raw.tool {
                Some(ToolRef::Number(value)) => Some(value),
                _ => None,
            };
            let mut words = Vec::new();
            if let Some(value) = tolerance {
                words.push(OldWord { name: "T".to_owned(), value: Some(value), span });
            }
            if let Some(value) = number(0) {
                words.push(OldWord { name: "HSC-MODE".to_owned(), value: Some(value), span });
            }
            if let Some(value) = number(1) {
                words.push(OldWord { name: "TA".to_owned(), value: Some(value), span });
            }
            Statement::OldCycle { number: 32, part: 1, words }
        }
        72 => match block.words.feed {
            Some(FeedWord::Value(value)) => Statement::TransScale(Some(value)),
            _ => return Err(missing("F with the scale factor")),
        },
        73 => {
            let value = raw.din.angle.ok_or_else(|| missing("H with the angle"))?;
            Statement::TransRotation(Some(Coordinate { value, reference }))
        }
        79 => Statement::CycleCall,
        80 => {
            if block.words.programmed & !0b11_1000 != 0 {
                return Err(Fault::new(codes::CONFLICT, span, "G80 takes the angles A, B and C, and no other axis")
                    .help("remove the other axis"));
            }
            let mut words = Vec::new();
            for (axis, letter) in ["A", "B", "C"].iter().enumerate() {
                if let Some(c) = block.words.axes[axis + 3] {
                    words.push(OldWord { name: (*letter).to_owned(), value: Some(c.value), span });
                }
            }
            Statement::OldCycle { number: 19, part: 1, words }
        }
        98 => match raw.label {
            Some((label, None)) => Statement::Label(label),
            _ => return Err(missing("L with the label")),
        },
        200..=299 => {
            cycle_words::check_cycle(code, at)?;
            Statement::Cycle { number: code, values: raw.settings }
        }
        14 | 20..=23 | 34 | 35 | 37 | 43 | 44 | 55..=59 | 74..=78 | 83..=89 | 120..=136 | 300..=499 => {
            return Err(refused(
                &format!("G{code}"),
                at,
                "use the cycles with Q parameters, or post the path as G01, G02, G03",
            ));
        }
        _ => return Err(unknown(&format!("G{code}"), at)),
    })
}

fn function(number: u32, target: Option<Param>, raw: &DinWords, span: Span) -> Result<Statement, Fault> {
    let missing = || {
        Fault::new(codes::MISSING_VALUE, span, format!("D{number:02} has too few values"))
            .help("write P01, P02 and so on")
    };
    let value = |at: usize| raw.values.get(at).copied().ok_or_else(missing);
    match number {
        0..=8 | 13 => {
            let target = target.ok_or_else(missing)?;
            let first = value(0)?;
            q_functions::arithmetic(number, first, raw.values.get(1).copied())
                .map(|formula| Statement::Assign(target, formula))
                .ok_or_else(missing)
        }
        9..=12 => {
            let relation =
                [Relation::Equal, Relation::NotEqual, Relation::Greater, Relation::Less][number as usize - 9];
            let label = match &raw.target {
                Some(label) => label.clone(),
                None => Label::Number(value(2)?),
            };
            Ok(Statement::Branch(Condition::Compare(value(0)?, relation, value(1)?), label))
        }
        14 => Ok(Statement::Error(value(0)?)),
        15 | 16 | 19 | 20 | 29 | 37 | 38 => Ok(Statement::Note(format!("D{number:02}"))),
        _ => Err(refused(&format!("D{number:02}"), span, "assign the value to the Q parameter")),
    }
}
