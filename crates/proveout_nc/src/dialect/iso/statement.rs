//! Control structures: O words of `LinuxCNC`, macro B of Fanuc and Haas, program numbers.

use super::expr::{self, Expr, next_is};
use super::flavor::Flavor;
use super::osp;
use super::parser::{self, Assignment};
use crate::codes;
use crate::diagnostic::Fault;
use crate::scan::Scanner;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum IsoStatement {
    /// `O1234`, `:1234`, `O<NAME>`: the head of a program.
    Header(String),
    /// `o100 while [..]`: label and word.
    OWord(OLabel, OWord),
    /// `IF [..] GOTO n`
    IfGoto(Expr, Expr),
    /// `IF [..] THEN #1 = 5`
    IfThen(Expr, Assignment),
    Goto(Expr),
    /// `$H` and other lines of a grbl that begin with `$`.
    Dollar(String),
    /// `WHILE [..] DO n`; without a condition `DO n`.
    While(Option<Expr>, u32),
    /// `END n`
    End(u32),
    /// `IF [..] N100` of an Okuma.
    IfSequence(Expr, Expr),
    /// `CALL O200 Q3` of an Okuma.
    Call(Box<osp::ProgramCall>),
    /// `MODIN O200` and `MODOUT` of an Okuma.
    ModalCall(Box<osp::ProgramCall>),
    EndModal,
    /// `RTS` of an Okuma.
    EndCall,
    /// The blocks from one number to another run again (`(RPT N50,N60)N3` of a Fagor): first, last, passes.
    Repeat(u32, u32, u32),
    /// `POPEN`, `DPRNT[..]`: output to a printer, without effect here.
    Output(String),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum OLabel {
    /// Digits without leading zeros, or `<name>` in lower case.
    Fixed(String),
    /// `o[#1]`
    Computed(Expr),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum OWord {
    Sub,
    EndSub(Option<Expr>),
    Call(Vec<Expr>),
    Return(Option<Expr>),
    If(Expr),
    ElseIf(Expr),
    Else,
    EndIf,
    While(Expr),
    EndWhile,
    Do,
    Repeat(Expr),
    EndRepeat,
    Break,
    Continue,
}

/// Words of macro B that can take the place of an address letter.
const KEYWORDS: [&str; 10] = ["RPT", "IF", "GOTO", "WHILE", "DO", "END", "POPEN", "PCLOS", "DPRNT", "BPRNT"];

/// The keyword of macro B that is next.
pub(crate) fn keyword(s: &Scanner<'_>) -> Option<&'static str> {
    if !s.peek_at(1).is_ascii_alphabetic() {
        return None;
    }
    KEYWORDS.into_iter().find(|word| next_is(s, word))
}

/// The statement that is next, if it is one.
pub(crate) fn statement(s: &mut Scanner<'_>, flavor: Flavor, first: bool) -> Result<Option<IsoStatement>, Fault> {
    let byte = s.peek();
    if matches!(byte, b'O' | b'o' | b':') {
        if byte == b':' && flavor.is_linuxcnc() {
            let message = "`:` is a program number of Fanuc and Haas and not a word of LinuxCNC";
            return Err(Fault::new(codes::UNSUPPORTED_WORD, s.here(), message)
                .help("write N for a block number, O for a program number"));
        }
        if first {
            return o_line(s, flavor).map(Some);
        }
        return Err(Fault::new(codes::SYNTAX, s.here(), "`O` must be the first word of its block")
            .help("write it in a line of its own"));
    }
    let Some(word) = keyword(s) else { return osp::call_or_return(s, flavor) };
    let start = s.pos();
    s.set_pos(start + word.len());
    if flavor.is_linuxcnc() {
        let message = format!("`{word}` is a word of macro B and not of LinuxCNC");
        return Err(
            Fault::new(codes::UNSUPPORTED_WORD, s.span_from(start), message).help("use O words: o100 if [#1 GT 0]")
        );
    }
    let statement = match word {
        "IF" => {
            let condition = expr::bracket(s, flavor)?;
            s.skip_blanks();
            if next_is(s, "GOTO") {
                s.set_pos(s.pos() + 4);
                IsoStatement::IfGoto(condition, target(s, flavor)?)
            } else if next_is(s, "THEN") {
                s.set_pos(s.pos() + 4);
                s.skip_blanks();
                if s.peek() != b'#' {
                    return Err(Fault::new(codes::SYNTAX, s.span_from(start), "THEN takes an assignment")
                        .help("write IF [#1 EQ 0] THEN #2=5"));
                }
                IsoStatement::IfThen(condition, parser::assignment(s, flavor)?)
            } else if next_is(s, "N") && s.peek_at(1).is_ascii_alphanumeric() {
                IsoStatement::IfSequence(condition, target(s, flavor)?)
            } else {
                return Err(Fault::new(codes::SYNTAX, s.span_from(start), "IF needs GOTO or THEN after its condition")
                    .help("write IF [#1 EQ 0] GOTO 100"));
            }
        }
        "GOTO" => IsoStatement::Goto(target(s, flavor)?),
        "RPT" => {
            let mut number = || {
                s.skip_blanks();
                s.integer().ok_or_else(|| {
                    Fault::new(codes::SYNTAX, s.span_from(start), "RPT needs two block numbers")
                        .help("write (RPT N50,N60)")
                })
            };
            IsoStatement::Repeat(number()?, number()?, number()?)
        }
        "WHILE" => {
            let condition = expr::bracket(s, flavor)?;
            s.skip_blanks();
            if !next_is(s, "DO") {
                return Err(Fault::new(codes::SYNTAX, s.span_from(start), "WHILE needs DO after its condition")
                    .help("write WHILE [#1 LT 10] DO 1"));
            }
            s.set_pos(s.pos() + 2);
            IsoStatement::While(Some(condition), loop_number(s, start)?)
        }
        "DO" => IsoStatement::While(None, loop_number(s, start)?),
        "END" => IsoStatement::End(loop_number(s, start)?),
        _ => {
            while !s.at_end() && s.peek() != b';' {
                s.bump();
            }
            IsoStatement::Output(s.slice(start).trim().to_owned())
        }
    };
    Ok(Some(statement))
}

fn target(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Expr, Fault> {
    s.skip_blanks();
    if matches!(s.peek(), b'N' | b'n') {
        s.bump();
        if let Some(name) = osp::sequence(s, flavor) {
            return Ok(Expr::Number(f64::from(name)));
        }
    }
    expr::operand(s, flavor)
}

fn loop_number(s: &mut Scanner<'_>, start: usize) -> Result<u32, Fault> {
    s.skip_blanks();
    s.integer().ok_or_else(|| {
        Fault::new(codes::SYNTAX, s.span_from(start), "the loop has no number").help("write DO 1 and END 1")
    })
}

/// `<NAME>` as the head of a program.
pub(crate) fn named_header(s: &mut Scanner<'_>) -> Result<IsoStatement, Fault> {
    let start = s.pos();
    name_in_brackets(s, start).map(IsoStatement::Header)
}

/// `<name>` in lower case without blanks, brackets included; the scanner is at `<`.
fn name_in_brackets(s: &mut Scanner<'_>, start: usize) -> Result<String, Fault> {
    s.bump();
    let from = s.pos();
    while !s.at_end() && s.peek() != b'>' {
        s.bump();
    }
    let name: String = s.slice(from).chars().filter(|c| !c.is_whitespace()).collect();
    if !s.take(b'>') || name.is_empty() {
        return Err(Fault::new(codes::SYNTAX, s.span_from(start), "the name has no end").help("write <name>"));
    }
    Ok(format!("<{}>", name.to_ascii_lowercase()))
}

/// A line that begins with O or `:`.
fn o_line(s: &mut Scanner<'_>, flavor: Flavor) -> Result<IsoStatement, Fault> {
    let start = s.pos();
    s.bump();
    s.skip_blanks();
    let label = match s.peek() {
        b'<' => OLabel::Fixed(name_in_brackets(s, start)?),
        b'[' | b'#' if flavor.is_linuxcnc() => OLabel::Computed(expr::operand(s, flavor)?),
        // A Haas takes names of letters too, and an Okuma.
        byte if !flavor.is_linuxcnc() && byte.is_ascii_alphabetic() => {
            let from = s.pos();
            while s.peek().is_ascii_alphanumeric() || b"_-.".contains(&s.peek()) {
                s.bump();
            }
            OLabel::Fixed(format!("<{}>", s.slice(from).to_ascii_lowercase()))
        }
        _ => match s.integer() {
            Some(number) => OLabel::Fixed(number.to_string()),
            None => {
                return Err(Fault::new(
                    codes::SYNTAX,
                    s.span_from(start),
                    "`O` has no number of up to nine digits and no name",
                )
                .help("write O1000"));
            }
        },
    };
    s.skip_blanks();
    let Some(word) = o_word_name(s) else {
        return match label {
            OLabel::Fixed(name) => Ok(IsoStatement::Header(name)),
            OLabel::Computed(_) => {
                Err(Fault::new(codes::SYNTAX, s.span_from(start), "the O word has no keyword").help("write o[#1] call"))
            }
        };
    };
    if !flavor.is_linuxcnc() {
        let message = format!(
            "`{}` after an O number is a word of LinuxCNC and not of {}",
            word.to_ascii_lowercase(),
            flavor.name()
        );
        return Err(Fault::new(codes::UNSUPPORTED_WORD, s.span_from(start), message)
            .help("use M98, G65 and macro B, or name the dialect linuxcnc"));
    }
    s.set_pos(s.pos() + word.len());
    let word = match word {
        "SUB" => OWord::Sub,
        "ENDSUB" => OWord::EndSub(optional(s, flavor)?),
        "RETURN" => OWord::Return(optional(s, flavor)?),
        "CALL" => {
            let mut arguments = Vec::new();
            while let Some(argument) = optional(s, flavor)? {
                arguments.push(argument);
            }
            OWord::Call(arguments)
        }
        "IF" => OWord::If(expr::bracket(s, flavor)?),
        "ELSEIF" => OWord::ElseIf(expr::bracket(s, flavor)?),
        "ELSE" => OWord::Else,
        "ENDIF" => OWord::EndIf,
        "WHILE" => OWord::While(expr::bracket(s, flavor)?),
        "ENDWHILE" => OWord::EndWhile,
        "DO" => OWord::Do,
        "REPEAT" => OWord::Repeat(expr::bracket(s, flavor)?),
        "ENDREPEAT" => OWord::EndRepeat,
        "BREAK" => OWord::Break,
        _ => OWord::Continue,
    };
    s.skip_blanks();
    if !s.at_end() && !matches!(s.peek(), b'(' | b';') {
        return Err(Fault::new(codes::SYNTAX, s.here(), "no words are allowed after an O word")
            .help("write it in a line of its own"));
    }
    Ok(IsoStatement::OWord(label, word))
}

fn optional(s: &mut Scanner<'_>, flavor: Flavor) -> Result<Option<Expr>, Fault> {
    s.skip_blanks();
    // Comments are allowed between the arguments.
    let mut behind = s.clone();
    while behind.peek() == b'(' {
        while !behind.at_end() && behind.peek() != b')' {
            behind.bump();
        }
        behind.take(b')');
        behind.skip_blanks();
    }
    if behind.peek() == b'[' {
        s.set_pos(behind.pos());
    }
    if s.peek() == b'[' { expr::bracket(s, flavor).map(Some) } else { Ok(None) }
}

/// The keyword of an O line that is next; longer words first.
pub(crate) fn o_word_name(s: &Scanner<'_>) -> Option<&'static str> {
    const WORDS: [&str; 15] = [
        "SUB",
        "ENDSUB",
        "CALL",
        "RETURN",
        "IF",
        "ELSEIF",
        "ELSE",
        "ENDIF",
        "WHILE",
        "ENDWHILE",
        "DO",
        "REPEAT",
        "ENDREPEAT",
        "BREAK",
        "CONTINUE",
    ];
    WORDS.into_iter().find(|word| next_is(s, word))
}
