//! Klartext blocks that are no paths: tools, cycles, labels, calls, jumps, functions.

use super::expr::{self, Expr, Operator};
use super::lexer::{Lexer, refused, unknown};
use super::plane_words;
use super::words::{
    Block, Condition, CycleValue, Kind, Label, OldWord, Param, Relation, Statement, ToolCall, ToolRef, Value,
};
use crate::AxisValues;
use crate::codes;
use crate::diagnostic::{Fault, Span};

/// Cycles in the old form, `CYCL DEF 7.1`, that are read.
const OLD_CYCLES: [u32; 15] = [1, 2, 7, 8, 9, 10, 11, 12, 13, 17, 18, 19, 26, 32, 247];
/// Cycles in the form with Q parameters that are read.
pub(crate) const CYCLES: [u32; 14] = [200, 201, 202, 203, 205, 206, 207, 209, 220, 221, 240, 241, 247, 32];

/// Reads the statement that begins with these letters; false when they begin none.
pub(crate) fn statement(x: &mut Lexer<'_>, word: &str, start: usize, block: &mut Block) -> Result<bool, Fault> {
    block.statement = match word {
        "BEGIN" => {
            let rest = x.rest().to_ascii_uppercase();
            Statement::Begin { inch: rest.ends_with(" INCH") }
        }
        "END" => {
            x.rest();
            Statement::End
        }
        "BLK" => Statement::Note(format!("BLK {}", x.rest())),
        "TOOL" => return tool(x, start, block).map(|()| true),
        "CYCL" => return cycle(x, start, block).map(|()| true),
        "CALL" => return call(x, start, block).map(|()| true),
        "SEL" => select(x, start)?,
        "LBL" => {
            let label = label(x, start)?;
            x.finish()?;
            Statement::Label(label)
        }
        "FN" => function(x, start)?,
        "IF" => branch(x, start)?,
        "GOTO" => {
            if !x.word("LBL") {
                return Err(x.unexpected());
            }
            Statement::Goto(label(x, start)?)
        }
        "STOP" => {
            block.statement = Statement::Stop;
            super::parser::path_words(x, block, super::words::Path::Nothing)?;
            return Ok(true);
        }
        "PLANE" => Statement::Plane(plane_words::plane(x, start)?),
        "FUNCTION" => plane_words::function(x, start)?,
        "TRANS" => {
            let trans = plane_words::trans(x, start)?;
            if trans == Statement::Datum(true) {
                super::parser::path_words(x, block, super::words::Path::Line)?;
            } else if trans == Statement::TransMirror(true) {
                while !x.ended() {
                    let Some(axis) = AxisValues::index(char::from(x.peek())) else { return Err(x.unexpected()) };
                    x.s.bump();
                    block.words.programmed |= 1 << axis;
                }
            }
            trans
        }
        "PATTERN" => pattern(x, start)?,
        "DECLARE" => {
            if !x.word("STRING") {
                return Err(x.unexpected());
            }
            let Some(param) = x.param()?.filter(|p| p.kind == Kind::Text) else { return Err(x.unexpected()) };
            x.blanks();
            if !x.s.take(b'=') {
                return Err(x.unexpected());
            }
            let text = expr::formula(x)?;
            x.finish()?;
            Statement::Assign(param, text)
        }
        "WMAT" | "STRUCTURE" => Statement::Note(format!("{word} {}", x.rest())),
        "GLOBAL" => {
            return Err(refused("GLOBAL DEF", x.span_from(start), "write the values into the cycles themselves"));
        }
        "TCH" => {
            x.rest();
            return Err(refused(
                "TCH PROBE",
                x.span_from(start),
                "what a probe finds is not known: take the cycle out and give its result in the settings",
            ));
        }
        "FL" | "FLT" | "FC" | "FCT" | "FPOL" | "FSELECT" => {
            return Err(refused(
                word,
                x.span_from(start),
                "convert the free contour (FK) into L and C blocks on the control",
            ));
        }
        "SPL" => return Err(refused(word, x.span_from(start), "write the path with L blocks")),
        "CONTOUR" | "POLARKIN" | "AFC" | "OPEN" | "TABDATA" | "CFGWRITE" | "FEED" | "SECTION" => {
            return Err(refused(word, x.span_from(start), "take the block out for the prove-out"));
        }
        _ => return Ok(false),
    };
    Ok(true)
}

fn tool_ref(x: &mut Lexer<'_>) -> Result<Option<ToolRef>, Fault> {
    if let Some(name) = x.quoted()? {
        return Ok(Some(ToolRef::Name(name)));
    }
    Ok(match x.value()? {
        Some(Value::Param { param, .. }) if param.kind == Kind::Text => Some(ToolRef::Text(param)),
        other => other.map(ToolRef::Number),
    })
}

fn tool(x: &mut Lexer<'_>, start: usize, block: &mut Block) -> Result<(), Fault> {
    x.blanks();
    match x.letters().as_str() {
        "DEF" => {
            let Some(tool) = tool_ref(x)? else {
                return Err(Fault::new(codes::MISSING_VALUE, x.span_from(start), "TOOL DEF names no tool")
                    .help("write TOOL DEF 5"));
            };
            // `TOOL DEF 5 L+10 R+3` fills the tool table, which the scene gives.
            x.rest();
            block.statement = Statement::ToolDef(tool);
            Ok(())
        }
        "CALL" => {
            let mut call = ToolCall { tool: tool_ref(x)?, ..ToolCall::default() };
            if matches!(call.tool, Some(ToolRef::Number(_))) && x.s.peek() == b'.' {
                return Err(x.unexpected());
            }
            loop {
                x.blanks();
                if x.s.at_end() {
                    break;
                }
                tool_word(x, &mut call)?;
            }
            block.statement = Statement::ToolCall(call);
            Ok(())
        }
        _ => Err(unknown("TOOL", x.span_from(start))),
    }
}

fn tool_word(x: &mut Lexer<'_>, call: &mut ToolCall) -> Result<(), Fault> {
    let at = x.pos();
    for (name, which) in [("DR2", 2), ("DL", 0), ("DR", 1)] {
        if x.prefix(name) {
            let value = x.need(at)?;
            let slot = match which {
                0 => &mut call.length,
                1 => &mut call.radius,
                _ => &mut call.corner,
            };
            *slot = Some(value);
            return Ok(());
        }
    }
    match x.peek() {
        letter @ (b'X' | b'Y' | b'Z') if !x.peek_at(1).is_ascii_alphabetic() || x.peek_at(1) == b'S' => {
            x.s.bump();
            call.axis = Some(char::from(letter));
        }
        b'S' if x.at("S(") || x.at("S (") => {
            return Err(refused("S( VC = )", Span::new(at, at + 1), "write the spindle speed S in 1/min"));
        }
        b'S' => {
            x.s.bump();
            x.blanks();
            call.speed = Some(x.need(at)?);
        }
        b'F' => {
            x.s.bump();
            call.feed = Some(x.feed(at)?);
        }
        b'U' | b'V' | b'W' if !x.peek_at(1).is_ascii_alphabetic() => {
            return Err(refused("U V W as tool axis", Span::new(at, at + 1), "use X, Y or Z"));
        }
        _ => return Err(x.unexpected()),
    }
    Ok(())
}

fn cycle(x: &mut Lexer<'_>, start: usize, block: &mut Block) -> Result<(), Fault> {
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
                super::words::Path::Line
            } else {
                super::words::Path::Nothing
            };
            super::parser::path_words(x, block, kind)
        }
        "DEF" => {
            x.blanks();
            let Some(number) = x.s.integer() else { return Err(x.unexpected()) };
            let span = x.span_from(start);
            block.statement = if x.s.take(b'.') {
                let part = x.s.integer().ok_or_else(|| x.unexpected())?;
                known(number, &OLD_CYCLES, span)?;
                old_cycle(x, number, part)?
            } else {
                known(number, &CYCLES, span)?;
                Statement::Cycle { number, values: cycle_values(x)? }
            };
            Ok(())
        }
        _ => Err(unknown("CYCL", x.span_from(start))),
    }
}

/// Refuses cycles that are not read, with a remedy for their kind.
pub(crate) fn known(number: u32, list: &[u32], span: Span) -> Result<(), Fault> {
    if list.contains(&number) {
        return Ok(());
    }
    let remedy = match number {
        204 => "bore from below needs the dimensions of the boring bar: write its motions with L blocks",
        208 | 251..=299 => {
            "its path depends on the tool radius of the control's table: post the path as L and C blocks"
        }
        14 | 20..=25 | 27..=31 | 39 | 210..=239 => "post the path as L and C blocks",
        3..=6 | 15 | 16 => "post the path as L and C blocks",
        400..=499 => "what a probe finds is not known: take the cycle out and give its result in the settings",
        _ => "write its motions with L blocks",
    };
    Err(refused(&format!("CYCL DEF {number}"), span, remedy))
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
            while x.peek().is_ascii_alphabetic()
                && !(x.peek() == b'Q'
                    && (x.peek_at(1).is_ascii_digit()
                        || matches!(x.peek_at(1), b'L' | b'R') && x.peek_at(2).is_ascii_digit()))
                || x.pos() > start
                    && (matches!(x.peek(), b'.' | b':') && !x.peek_at(1).is_ascii_digit()
                        || x.peek() == b'-' && x.peek_at(1).is_ascii_alphabetic())
            {
                x.s.bump();
            }
        }
        let name = x.s.slice(start).to_ascii_uppercase();
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

/// `Q200=+2 ;SET-UP CLEARANCE ~ ...`; the name of the cycle before them is skipped.
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
                x.s.take(b'=').then_some(param)
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
        return Err(refused("FZ", x.span_from(start), "the number of teeth stands in the tool table: write mm/min"));
    }
    x.need(start).map(CycleValue::Value)
}

pub(crate) fn label(x: &mut Lexer<'_>, start: usize) -> Result<Label, Fault> {
    if let Some(name) = x.quoted()? {
        return Ok(Label::Name(name));
    }
    match x.value()? {
        Some(Value::Param { param, .. }) if param.kind == Kind::Text => Ok(Label::Text(param)),
        Some(value) => Ok(Label::Number(value)),
        None => Err(Fault::new(codes::MISSING_VALUE, x.span_from(start), "the label has no number and no name")
            .help("write LBL 1 or LBL \"NAME\"")),
    }
}

fn call(x: &mut Lexer<'_>, start: usize, block: &mut Block) -> Result<(), Fault> {
    x.blanks();
    block.statement = match x.letters().as_str() {
        "LBL" => {
            let label = label(x, start)?;
            let repeat = if x.prefix("REP") {
                let value = x.need(start)?;
                // Older controls write `REP 5/5`.
                x.blanks();
                if x.s.take(b'/') {
                    x.value()?;
                }
                Some(value)
            } else {
                None
            };
            x.finish()?;
            Statement::CallLabel { label, repeat }
        }
        "PGM" => match x.param()?.filter(|p| p.kind == Kind::Text) {
            Some(param) => Statement::CallProgramText(param),
            None => Statement::CallProgram(file_name(x, start)?),
        },
        "SELECTED" => {
            x.rest();
            Statement::CallSelected
        }
        _ => return Err(unknown("CALL", x.span_from(start))),
    };
    Ok(())
}

pub(crate) fn file_name(x: &mut Lexer<'_>, start: usize) -> Result<String, Fault> {
    let name = match x.quoted()? {
        Some(name) => name,
        None => x.rest().to_owned(),
    };
    if name.trim().is_empty() {
        return Err(Fault::new(codes::MISSING_VALUE, x.span_from(start), "the program has no name")
            .help("write its name, such as CALL PGM PART2.H"));
    }
    Ok(name)
}

fn select(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    x.blanks();
    match x.letters().as_str() {
        "PGM" => Ok(match x.param()?.filter(|p| p.kind == Kind::Text) {
            Some(param) => Statement::SelectProgramText(param),
            None => Statement::SelectProgram(file_name(x, start)?),
        }),
        word @ ("TABLE" | "PATTERN" | "CONTOUR" | "CORR" | "TOOL") => {
            x.rest();
            Err(refused(&format!("SEL {word}"), x.span_from(start), "write the values into the program"))
        }
        _ => Err(unknown("SEL", x.span_from(start))),
    }
}

/// `POS1 (X+10 Y+20 Z+0) ~ POS2 (...)`.
fn pattern(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    if !x.word("DEF") {
        return Err(x.unexpected());
    }
    let mut points = Vec::new();
    while !x.ended() {
        if !x.prefix("POS") {
            let mut probe = x.clone();
            let word = probe.letters();
            return Err(if word.is_empty() {
                x.unexpected()
            } else {
                refused(&format!("PATTERN DEF {word}"), x.span_from(start), "write the points as POS1 ( X.. Y.. Z.. )")
            });
        }
        x.s.integer();
        x.blanks();
        if !x.s.take(b'(') {
            return Err(x.unexpected());
        }
        let mut point = [Value::Number(0.0); 3];
        loop {
            x.blanks();
            if x.s.take(b')') {
                break;
            }
            let at = x.pos();
            let axis = match x.peek() {
                b'X' => 0,
                b'Y' => 1,
                b'Z' => 2,
                _ => return Err(x.unexpected()),
            };
            x.s.bump();
            point[axis] = x.need(at)?;
        }
        points.push(point);
    }
    Ok(Statement::Pattern(points))
}

/// Value of a term of FN 0 to FN 13.
fn term(x: &mut Lexer<'_>, start: usize) -> Result<Value, Fault> {
    x.need(start)
}

fn as_expr(value: Value) -> Expr {
    match value {
        Value::Number(number) => Expr::Number(number),
        Value::Param { negative: false, param } => Expr::Param(param),
        Value::Param { negative: true, param } => Expr::Call(expr::Function::Neg, Box::new(Expr::Param(param))),
    }
}

/// What function `FN 0` to `FN 13` or `D00` to `D13` makes of its terms; none for others.
pub(crate) fn arithmetic(number: u32, first: Value, second: Option<Value>) -> Option<Expr> {
    let one = |function| Some(Expr::Call(function, Box::new(as_expr(first))));
    let two = |operator| Some(Expr::Binary(operator, Box::new(as_expr(first)), Box::new(as_expr(second?))));
    match number {
        0 => Some(as_expr(first)),
        1 => two(Operator::Add),
        2 => two(Operator::Subtract),
        3 => two(Operator::Multiply),
        4 => two(Operator::Divide),
        5 => one(expr::Function::Sqrt),
        6 => one(expr::Function::Sin),
        7 => one(expr::Function::Cos),
        8 => two(Operator::Length),
        13 => two(Operator::Angle),
        _ => None,
    }
}

fn function(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    x.blanks();
    let Some(number) = x.s.integer() else { return Err(x.unexpected()) };
    x.blanks();
    x.s.take(b':');
    match number {
        0..=8 | 13 => {
            let Some(target) = x.param()? else { return Err(x.unexpected()) };
            x.blanks();
            if !x.s.take(b'=') {
                return Err(x.unexpected());
            }
            match number {
                5 => x.prefix("SQRT"),
                6 => x.prefix("SIN"),
                7 => x.prefix("COS"),
                _ => false,
            };
            let first = term(x, start)?;
            let second = if matches!(number, 1..=4 | 8 | 13) {
                let sign = ["+", "-", "*", "DIV", "", "", "", "LEN", "", "", "", "", "ANG"];
                let word = sign.get(number as usize - 1).copied().unwrap_or_default();
                if !(x.prefix(word) || number == 4 && x.prefix("/")) {
                    return Err(x.unexpected());
                }
                Some(term(x, start)?)
            } else {
                None
            };
            x.finish()?;
            arithmetic(number, first, second).map(|e| Statement::Assign(target, e)).ok_or_else(|| x.unexpected())
        }
        9..=12 => {
            if !x.word("IF") {
                return Err(x.unexpected());
            }
            branch(x, start)
        }
        14 => {
            x.word("ERROR");
            x.blanks();
            x.s.take(b'=');
            Ok(Statement::Error(x.need(start)?))
        }
        23 => {
            let Some(target) = x.param()? else { return Err(x.unexpected()) };
            x.blanks();
            x.s.take(b'=');
            x.word("CDATA");
            let Some(from) = x.param()? else { return Err(x.unexpected()) };
            x.finish()?;
            Ok(Statement::CircleData(target, from))
        }
        15 | 16 | 19 | 20 | 29 | 37 | 38 => Ok(Statement::Note(format!("FN {number}: {}", x.rest()))),
        _ => {
            x.rest();
            let remedy = match number {
                18 => "data of the control are not known: assign the value to the Q parameter",
                17 | 25 => "change the datum with CYCL DEF 7 or CYCL DEF 247",
                26..=28 => "tables of the control are not known: assign the values to Q parameters",
                _ => "assign the result to the Q parameter",
            };
            Err(refused(&format!("FN {number}"), x.span_from(start), remedy))
        }
    }
}

fn branch(x: &mut Lexer<'_>, start: usize) -> Result<Statement, Fault> {
    let left = term(x, start)?;
    let condition = if x.word("IS") {
        let defined = if x.word("DEFINED") {
            true
        } else if x.word("UNDEFINED") {
            false
        } else {
            return Err(x.unexpected());
        };
        let Value::Param { param, .. } = left else { return Err(x.unexpected()) };
        Condition::Defined(param, defined)
    } else {
        let mut relation = None;
        for (word, found) in
            [("EQU", Relation::Equal), ("NE", Relation::NotEqual), ("GT", Relation::Greater), ("LT", Relation::Less)]
        {
            if x.prefix(word) {
                relation = Some(found);
                break;
            }
        }
        let Some(relation) = relation else { return Err(x.unexpected()) };
        Condition::Compare(left, relation, term(x, start)?)
    };
    if !x.word("GOTO") || !x.prefix("LBL") {
        return Err(x.unexpected());
    }
    let target = label(x, start)?;
    x.finish()?;
    Ok(Statement::Branch(condition, target))
}
