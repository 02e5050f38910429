//! Klartext blocks that are not paths: tools, cycles, labels, calls, jumps, functions.

use super::expr;
use super::lexer::{Lexer, refused, unknown};
use super::words::{Block, FeedWord, Kind, Label, Statement, ToolCall, ToolRef, Value};
use super::{cycle_words, plane_words, q_functions};
use crate::AxisValues;
use crate::codes;
use crate::diagnostic::{Fault, Span, twice};

/// Reads the statement that begins with these letters; false when none does.
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
        // Some posts write the word in full.
        "CYCL" | "CYCLE" => return cycle_words::cycle(x, start, block).map(|()| true),
        "CALL" => return call(x, start, block).map(|()| true),
        "SEL" => select(x, start)?,
        "LBL" => {
            let label = label(x, start)?;
            x.finish()?;
            Statement::Label(label)
        }
        "FN" => q_functions::function(x, start)?,
        "IF" => q_functions::branch(x, start)?,
        "GOTO" => {
            if !x.word("LBL") {
                return Err(x.unexpected());
            }
            Statement::Goto(label(x, start)?)
        }
        "STOP" => {
            block.statement = Statement::Stop;
            super::parser::path_words(x, block, super::words::PathFunction::Nothing)?;
            return Ok(true);
        }
        "PLANE" => Statement::Plane(plane_words::plane(x, start)?),
        "FUNCTION" => plane_words::function(x, start)?,
        "TRANS" => {
            let trans = plane_words::trans(x, start)?;
            if trans == Statement::Datum(true) {
                super::parser::path_words(x, block, super::words::PathFunction::Line)?;
                super::takes::axes_alone(&block.words, "TRANS DATUM", x.span_from(start))?;
            } else if trans == Statement::TransMirror(true) {
                while !x.ended() {
                    let Some(axis) = AxisValues::index(char::from(x.peek())) else { return Err(x.unexpected()) };
                    x.s.bump();
                    block.words.programmed |= 1 << axis;
                }
            }
            trans
        }
        "PATTERN" => cycle_words::pattern(x, start)?,
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
                "the twin does not measure: remove the cycle and give its result with --variable or in the control \
                 file",
            ));
        }
        "FSELECT" => {
            return Err(refused(
                word,
                x.span_from(start),
                "convert the free contour (FK) into L and C blocks on the control",
            ));
        }
        "SPL" => return Err(refused(word, x.span_from(start), "write the path with L blocks")),
        "CONTOUR" | "POLARKIN" | "AFC" | "OPEN" | "TABDATA" | "CFGWRITE" | "FEED" | "SECTION" => {
            return Err(refused(word, x.span_from(start), "remove the block for the prove-out"));
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
            // `TOOL DEF 5 L+10 R+3` fills the tool table, which comes from the scene.
            block.statement = Statement::ToolDef(tool, x.rest().to_owned());
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
            return once(slot, value, name, x.span_from(at));
        }
    }
    match x.peek() {
        letter @ (b'X' | b'Y' | b'Z') if !x.peek_at(1).is_ascii_alphabetic() || x.peek_at(1) == b'S' => {
            x.s.bump();
            once(&mut call.axis, char::from(letter), "the tool axis", x.span_from(at))?;
        }
        b'S' if x.at("S(") || x.at("S (") => {
            return Err(refused("S( VC = )", Span::new(at, at + 1), "write the spindle speed S in 1/min"));
        }
        b'S' => {
            x.s.bump();
            x.blanks();
            let speed = x.need(at)?;
            once(&mut call.speed, speed, "S", x.span_from(at))?;
        }
        b'F' => {
            x.s.bump();
            let feed = x.feed(at)?;
            if feed == FeedWord::Max {
                return Err(Fault::new(codes::CONFLICT, x.span_from(at), "TOOL CALL does not take `FMAX`")
                    .help("write a feed, or FMAX in the straight blocks that need it"));
            }
            once(&mut call.feed, feed, "F", x.span_from(at))?;
        }
        b'U' | b'V' | b'W' if !x.peek_at(1).is_ascii_alphabetic() => {
            return Err(refused("U V W as tool axis", Span::new(at, at + 1), "use X, Y or Z"));
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
            x.word("PGM");
            x.word("PROGRAM");
            x.finish()?;
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
