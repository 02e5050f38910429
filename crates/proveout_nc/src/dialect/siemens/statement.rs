//! Statements of the 840D language: definitions, control structures, jumps, calls.

use super::expr::{self, Expr};
use super::parser::{Call, Definition, Direction, Jump, Parameter, SiemensStatement, Type};
use crate::codes;
use crate::diagnostic::Fault;
use crate::scan::Scanner;

/// Reads the rest of a statement that begins with this word; none if no statement begins with it.
pub(crate) fn statement(s: &mut Scanner<'_>, name: &str, start: usize) -> Result<Option<SiemensStatement>, Fault> {
    Ok(Some(match name {
        "IF" => {
            let condition = expr::expression(s)?;
            match jump(s)? {
                Some(jump) => SiemensStatement::IfGoto(condition, jump),
                None => SiemensStatement::If(condition),
            }
        }
        "ELSE" => SiemensStatement::Else,
        "ENDIF" => SiemensStatement::EndIf,
        "FOR" => for_loop(s, start)?,
        "ENDFOR" => SiemensStatement::EndFor,
        "WHILE" => SiemensStatement::While(expr::expression(s)?),
        "ENDWHILE" => SiemensStatement::EndWhile,
        "UNTIL" => SiemensStatement::Until(expr::expression(s)?),
        "LOOP" => SiemensStatement::Loop,
        "ENDLOOP" => SiemensStatement::EndLoop,
        "REPEAT" | "REPEATB" => repeat(s, name == "REPEATB", start)?,
        "GOTOS" => SiemensStatement::GotoStart,
        "GOTO" | "GOTOF" | "GOTOB" | "GOTOC" => {
            s.set_pos(start);
            match jump(s)? {
                Some(jump) => SiemensStatement::Goto(jump),
                None => {
                    let message = format!("`{name}` is not supported");
                    return Err(Fault::new(codes::UNSUPPORTED_WORD, s.span_from(start), message)
                        .help("jump with GOTOF, GOTOB or GOTO to a label"));
                }
            }
        }
        "CASE" => case(s, start)?,
        "DEF" => define(s, start)?,
        "PROC" => proc(s, start)?,
        "EXTERN" => {
            // Only declares the parameters of a subprogram; they are read from the subprogram
            // itself.
            while !s.at_end() && s.peek() != b';' {
                s.bump();
            }
            SiemensStatement::Extern
        }
        "RET" => {
            s.skip_blanks();
            if s.peek() == b'(' {
                let message = "`RET` with arguments is not supported";
                return Err(Fault::new(codes::UNSUPPORTED_WORD, s.span_from(start), message).help("write RET alone"));
            }
            SiemensStatement::Return
        }
        "MCALL" => SiemensStatement::ModalCall(call(s)?),
        "CALL" | "EXTCALL" => SiemensStatement::CallText(expr::expression(s)?),
        "WHEN" | "WHENEVER" | "EVERY" => {
            let message = format!("`{name}` (a synchronized action) is not supported");
            return Err(Fault::new(codes::UNSUPPORTED_WORD, s.span_from(start), message)
                .help("remove the synchronized action; the twin has no signals that it could wait for"));
        }
        _ => return Ok(None),
    }))
}

/// Takes a jump if one is next.
fn jump(s: &mut Scanner<'_>) -> Result<Option<Jump>, Fault> {
    let before = s.pos();
    s.skip_blanks();
    let start = s.pos();
    let direction = match s.identifier().to_ascii_uppercase().as_str() {
        "GOTO" => Direction::Either,
        "GOTOF" => Direction::Forward,
        "GOTOB" => Direction::Backward,
        "GOTOC" => Direction::Silent,
        _ => {
            s.set_pos(before);
            return Ok(None);
        }
    };
    let target = expr::expression(s)?;
    Ok(Some(Jump { direction, target, span: s.span_from(start) }))
}

fn expect_word(s: &mut Scanner<'_>, word: &str, start: usize) -> Result<(), Fault> {
    s.skip_blanks();
    let before = s.pos();
    if s.identifier().eq_ignore_ascii_case(word) {
        return Ok(());
    }
    s.set_pos(before);
    Err(Fault::new(codes::SYNTAX, s.span_from(start), format!("`{word}` is missing")).help(format!("write {word}")))
}

fn for_loop(s: &mut Scanner<'_>, start: usize) -> Result<SiemensStatement, Fault> {
    s.skip_blanks();
    // The variable ends at `=`, which no expression contains.
    let variable = expr::expression(s)?;
    s.skip_blanks();
    if !s.take(b'=') {
        return Err(Fault::new(codes::SYNTAX, s.span_from(start), "`=` is missing after the variable of FOR")
            .help("write FOR I = 1 TO 10"));
    }
    let from = expr::expression(s)?;
    expect_word(s, "TO", start)?;
    let to = expr::expression(s)?;
    Ok(SiemensStatement::For { variable, from, to })
}

fn repeat(s: &mut Scanner<'_>, only_block: bool, start: usize) -> Result<SiemensStatement, Fault> {
    let mut labels = Vec::new();
    let mut count = None;
    loop {
        s.skip_blanks();
        let at = s.pos();
        let name = s.identifier().to_ascii_uppercase();
        if name.is_empty() {
            break;
        }
        s.skip_blanks();
        if name == "P" && s.take(b'=') {
            count = Some(expr::expression(s)?);
        } else if let Some(number) =
            name.strip_prefix('P').and_then(|n| n.parse::<u32>().ok()).filter(|_| !labels.is_empty())
        {
            count = Some(Expr::Number(f64::from(number)));
        } else if labels.len() < 2 {
            labels.push(name);
        } else {
            let message = format!("`{name}` is one label too many");
            return Err(Fault::new(codes::SYNTAX, s.span_from(at), message).help("write REPEAT FIRST LAST P=2"));
        }
    }
    let mut labels = labels.into_iter();
    match labels.next() {
        None if only_block || count.is_some() => {
            Err(Fault::new(codes::SYNTAX, s.span_from(start), "the label is missing").help("write REPEAT LABEL P=2"))
        }
        None => Ok(SiemensStatement::Repeat),
        Some(first) => Ok(SiemensStatement::RepeatLabel { first, last: labels.next(), count, only_block }),
    }
}

fn case(s: &mut Scanner<'_>, start: usize) -> Result<SiemensStatement, Fault> {
    let selector = expr::expression(s)?;
    expect_word(s, "OF", start)?;
    let mut branches = Vec::new();
    let mut default = None;
    let missing = |s: &Scanner<'_>| {
        Fault::new(codes::SYNTAX, s.span_from(start), "a jump is missing in CASE")
            .help("write CASE (R1) OF 1 GOTOF LABEL")
    };
    loop {
        s.skip_blanks();
        if s.at_end() || s.peek() == b';' {
            break;
        }
        let before = s.pos();
        if s.identifier().eq_ignore_ascii_case("DEFAULT") {
            default = Some(jump(s)?.ok_or_else(|| missing(s))?);
            continue;
        }
        s.set_pos(before);
        let value = expr::expression(s)?;
        branches.push((value, jump(s)?.ok_or_else(|| missing(s))?));
    }
    Ok(SiemensStatement::Case { selector, branches, default })
}

fn variable_type(s: &mut Scanner<'_>) -> Result<Type, Fault> {
    s.skip_blanks();
    let start = s.pos();
    let name = s.identifier().to_ascii_uppercase();
    Ok(match name.as_str() {
        "REAL" => Type::Real,
        "INT" | "CHAR" => Type::Int,
        "BOOL" => Type::Bool,
        "STRING" => {
            s.skip_blanks();
            if s.peek() == b'[' {
                expr::indices(s, 0)?;
            }
            Type::Text
        }
        "FRAME" => Type::Frame,
        "AXIS" => Type::Axis,
        _ => {
            let message = format!("`{name}` is not a type of a variable");
            return Err(Fault::new(codes::SYNTAX, s.span_from(start), message)
                .help("use REAL, INT, BOOL, CHAR, STRING, AXIS or FRAME"));
        }
    })
}

fn variable_name(s: &mut Scanner<'_>) -> Result<String, Fault> {
    s.skip_blanks();
    let start = s.pos();
    let name = s.identifier().to_ascii_uppercase();
    if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(Fault::new(codes::SYNTAX, s.span_from(start), "the name of the variable is missing")
            .help("names begin with a letter or an underscore"));
    }
    Ok(name)
}

fn define(s: &mut Scanner<'_>, start: usize) -> Result<SiemensStatement, Fault> {
    let kind = variable_type(s)?;
    let mut variables = Vec::new();
    loop {
        let at = s.pos();
        let name = variable_name(s)?;
        s.skip_blanks();
        let sizes = if s.peek() == b'[' { expr::indices(s, 0)? } else { Vec::new() };
        s.skip_blanks();
        let initial = if s.take(b'=') { Some(expr::expression(s)?) } else { None };
        variables.push(Definition { name, sizes, initial, span: s.span_from(at) });
        s.skip_blanks();
        if !s.take(b',') {
            break;
        }
    }
    debug_assert!(s.pos() > start);
    Ok(SiemensStatement::Define { kind, variables })
}

fn proc(s: &mut Scanner<'_>, start: usize) -> Result<SiemensStatement, Fault> {
    let name = variable_name(s)?;
    let mut parameters = Vec::new();
    s.skip_blanks();
    if s.take(b'(') {
        s.skip_blanks();
        while s.peek() != b')' {
            s.skip_blanks();
            let before = s.pos();
            let by_reference = s.identifier().eq_ignore_ascii_case("VAR");
            if !by_reference {
                s.set_pos(before);
            }
            let kind = variable_type(s)?;
            let name = variable_name(s)?;
            s.skip_blanks();
            let sizes = if s.peek() == b'[' { Some(open_sizes(s)?) } else { None };
            s.skip_blanks();
            let initial = if s.take(b'=') { Some(expr::expression(s)?) } else { None };
            parameters.push(Parameter { name, kind, by_reference, initial, sizes });
            s.skip_blanks();
            if !s.take(b',') {
                break;
            }
        }
        expr::close(s, b')', start)?;
    }
    let mut save = false;
    loop {
        s.skip_blanks();
        let at = s.pos();
        match s.identifier().to_ascii_uppercase().as_str() {
            "" => break,
            "SAVE" => save = true,
            "DISPLOF" | "DISPLON" | "ACTBLOCNO" | "SBLOF" | "ICYCOF" | "ICYCON" | "PREPRO" => {}
            other => {
                let message = format!("`{other}` is not an attribute of PROC");
                return Err(Fault::new(codes::UNKNOWN_WORD, s.span_from(at), message).help("use SAVE, SBLOF, DISPLOF"));
            }
        }
    }
    Ok(SiemensStatement::Proc { name, parameters, save })
}

/// `[3, 4]`, `[]`, `[,]` of an array that is a parameter.
fn open_sizes(s: &mut Scanner<'_>) -> Result<Vec<Option<Expr>>, Fault> {
    let start = s.pos();
    s.bump();
    let mut sizes = Vec::new();
    loop {
        s.skip_blanks();
        sizes.push(if matches!(s.peek(), b',' | b']') { None } else { Some(expr::expression(s)?) });
        s.skip_blanks();
        if !s.take(b',') {
            expr::close(s, b']', start)?;
            return Ok(sizes);
        }
    }
}

/// The call after MCALL: `NAME`, `NAME(...)`, `L100`; none when the block ends.
fn call(s: &mut Scanner<'_>) -> Result<Option<Call>, Fault> {
    s.skip_blanks();
    let name = s.identifier().to_ascii_uppercase();
    if name.is_empty() {
        return Ok(None);
    }
    s.skip_blanks();
    let arguments = if s.peek() == b'(' { Some(expr::arguments(s)?) } else { None };
    Ok(Some(Call { name, arguments }))
}
