//! Classifies the text that was not run: programs, subprograms, branches, text after the end of the
//! program.

use super::expr::Expr;
use super::parser::{self, AddressValue, Jump, SiemensBlock, SiemensStatement, WordKind};
use super::run_state::{Interpreter, Loaded};
use super::words::{self, Class};
use crate::AxisValues;
use crate::channel::coverage::{Flow, Layout, LineRole, LineStretch};
use crate::not_run::{NotRun, NotRunKind};
use crate::source::{Mark, Source};

/// The main file is a subprogram: by its ending, its header line or PROC.
pub(super) fn is_subprogram(main: &Loaded) -> bool {
    let ending = main.source.name.to_ascii_lowercase().ends_with(".spf");
    ending || main.index.parts.first().is_some_and(|part| part.subprogram)
}

pub(super) fn not_run(channel: &Interpreter) -> Vec<NotRun> {
    let mut found = Vec::new();
    for loaded in channel.loaded() {
        let targets = Targets::of(&loaded.source);
        let parts = loaded.index.parts.iter().map(|part| {
            let name = part.name.clone().unwrap_or_else(|| "without a name".to_owned());
            let kind = if part.subprogram { NotRunKind::Subprogram(name) } else { NotRunKind::Program(name) };
            LineStretch { lines: part.lines, kind }
        });
        let layout = Layout {
            source: &loaded.source,
            parts: parts.collect(),
            regions: Vec::new(),
            role: &|line, at| role(line, at, &targets),
        };
        found.extend(channel.coverage.not_run(loaded.file, &layout));
    }
    found
}

/// Labels and block numbers that a jump in the text names; none when a target is computed, because
/// it can then be any.
struct Targets(Option<Vec<String>>);

impl Targets {
    fn of(source: &Source) -> Self {
        let mut names = Vec::new();
        let (mut block, mut at) = (SiemensBlock::default(), Mark::START);
        while let Some((line, next)) = source.line(at) {
            at = next;
            // Plain blocks contain none of the words.
            let longer = line.as_bytes().windows(4).any(|w| w.iter().all(u8::is_ascii_alphabetic));
            if !longer || parser::parse_line(line, &mut block).is_err() {
                continue;
            }
            let mut take = |jump: &Jump| match &jump.target {
                Expr::Name(name) => {
                    names.push(name.clone());
                    true
                }
                Expr::Text(text) => {
                    names.push(text.to_ascii_uppercase());
                    true
                }
                _ => false,
            };
            let known = match &block.statement {
                Some(SiemensStatement::Goto(jump) | SiemensStatement::IfGoto(_, jump)) => take(jump),
                Some(SiemensStatement::Case { branches, default, .. }) => {
                    branches.iter().map(|(_, jump)| jump).chain(default).all(take)
                }
                Some(SiemensStatement::RepeatLabel { first, last, .. }) => {
                    names.push(first.clone());
                    names.extend(last.clone());
                    true
                }
                _ => true,
            };
            if !known {
                return Self(None);
            }
        }
        Self(Some(names))
    }

    fn holds(&self, name: &str) -> bool {
        self.0.as_ref().is_none_or(|names| names.iter().any(|n| n == name))
    }
}

fn role(line: &str, _: Mark, targets: &Targets) -> LineRole {
    let mut block = SiemensBlock::default();
    if parser::parse_line(line, &mut block).is_err() {
        // Faults are reported separately.
        return LineRole { code: !line.trim().is_empty(), ..LineRole::default() };
    }
    let named = block.label.as_ref().is_some_and(|label| targets.holds(label))
        || block.number.is_some_and(|number| targets.holds(&format!("N{number}")));
    let flow = match &block.statement {
        Some(
            SiemensStatement::If(_)
            | SiemensStatement::For { .. }
            | SiemensStatement::While(_)
            | SiemensStatement::Repeat
            | SiemensStatement::Loop,
        ) => Flow::Opens,
        Some(SiemensStatement::Else) => Flow::Between,
        Some(
            SiemensStatement::EndIf
            | SiemensStatement::EndFor
            | SiemensStatement::EndWhile
            | SiemensStatement::Until(_)
            | SiemensStatement::EndLoop,
        ) => Flow::Closes,
        _ if named => Flow::Target,
        _ => Flow::On,
    };
    let end = |kind: &WordKind| {
        matches!(
            kind,
            WordKind::Address { letter: b'M', extension: None, value: AddressValue::Number(2.0 | 17.0 | 30.0) }
        )
    };
    let code = match &block.statement {
        None => !block.words.iter().all(|word| end(&word.kind)),
        Some(
            SiemensStatement::Proc { .. }
            | SiemensStatement::Extern
            | SiemensStatement::Return
            | SiemensStatement::EndIf
            | SiemensStatement::EndFor
            | SiemensStatement::EndWhile
            | SiemensStatement::EndLoop
            | SiemensStatement::Else,
        ) => false,
        Some(_) => true,
    };
    let moves = matches!(block.statement, Some(SiemensStatement::CallText(_) | SiemensStatement::RepeatLabel { .. }))
        || block.words.iter().any(|word| match &word.kind {
            WordKind::Address { letter: b'L', extension: None, .. } => true,
            WordKind::Address { letter, extension: None | Some(2 | 3), .. } => {
                AxisValues::index(char::from(*letter)).is_some()
            }
            WordKind::Assign { name, .. } => matches!(name.as_str(), "AP" | "RP" | "POS"),
            WordKind::Name(name) | WordKind::Call(parser::Call { name, .. }) => {
                is_call(name) && words::classify_name(name) == Class::Unknown
            }
            WordKind::Address { .. } => false,
        });
    LineRole { code, moves, flow }
}

/// Names that the reader does not execute as words of its own: cycles and subprograms.
fn is_call(name: &str) -> bool {
    const WORDS: [&str; 30] = [
        "MSG",
        "TRAORI",
        "TRAFOOF",
        "SUPA",
        "CIP",
        "CT",
        "ORIAXES",
        "ORIVECT",
        "ORIPLANE",
        "ORIVECTPATH",
        "ORIWKS",
        "ORIMKS",
        "ORIRPY",
        "ORIEULER",
        "TRANS",
        "ATRANS",
        "ROT",
        "AROT",
        "SCALE",
        "ASCALE",
        "MIRROR",
        "AMIRROR",
        "CYCLE832",
        "CFC",
        "CFIN",
        "CFTCP",
        "NORM",
        "KONT",
        "CUT2D",
        "CUT2DF",
    ];
    !WORDS.contains(&name)
}
