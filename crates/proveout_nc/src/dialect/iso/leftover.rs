//! What the text that was not run is: programs, subprograms, branches, text after the end.

use std::path::Path;

use super::expr::Expr;
use super::flavor::Flavor;
use super::index::{Index, has_end, has_return};
use super::parser::{self, IsoBlock, IsoWord, WordValue};
use super::pending::AXES;
use super::run_state::{Interpreter, Loaded};
use super::statement::{IsoStatement, OLabel, OWord};
use crate::channel::ProgramSection;
use crate::channel::coverage::{Flow, Layout, LineRole, LineStretch};
use crate::not_run::{NotRun, NotRunKind};
use crate::source::{Mark, Source};

/// The main file is a subprogram: it returns with M99 and has no other end, or defines the O word of its own
/// name.
pub(super) fn is_subprogram(main: &Loaded, flavor: Flavor) -> bool {
    let (source, index) = (&main.source, &main.index);
    let stem = Path::new(&*source.name).file_stem().map(|stem| stem.to_string_lossy().to_ascii_lowercase());
    if let Some(stem) = stem.filter(|_| flavor.is_linuxcnc())
        && index.subs.contains_key(&format!("<{stem}>"))
    {
        return true;
    }
    let Some(part) = index.parts.iter().find(|part| !part.outside) else { return false };
    let (mut at, mut returns) = (Mark::START, false);
    while let Some((line, next)) = source.line(at).filter(|_| at.line < part.lines[1]) {
        if at.line >= part.lines[0] && has_end(line) {
            if !has_return(line) {
                return false;
            }
            returns = true;
        }
        at = next;
    }
    returns
}

pub(super) fn not_run(channel: &Interpreter) -> Vec<NotRun> {
    let flavor = channel.own.flavor;
    let mut found = Vec::new();
    for loaded in channel.loaded() {
        let targets = Targets::of(&loaded.source, flavor);
        let layout = Layout {
            source: &loaded.source,
            parts: parts(&loaded.source, &loaded.index),
            regions: regions(&loaded.source, &loaded.index),
            role: &|line, at| role(line, at, &loaded.index, flavor, &targets),
        };
        found.extend(channel.coverage.not_run(loaded.file, &layout));
    }
    found
}

/// A part with M99 is a subprogram; every other is a program that an operator can choose.
fn parts(source: &Source, index: &Index) -> Vec<LineStretch> {
    let mut at = Mark::START;
    let mut out = Vec::with_capacity(index.parts.len());
    for part in &index.parts {
        let mut returns = false;
        while let Some((line, next)) = source.line(at).filter(|_| at.line < part.lines[1]) {
            returns |= at.line >= part.lines[0] && has_return(line);
            at = next;
        }
        let name = part.name.clone().map_or_else(|| "without a number".to_owned(), |name| format!("O{name}"));
        let kind = match (part.outside, returns) {
            (true, _) => NotRunKind::Outside,
            (false, true) => NotRunKind::Subprogram(name),
            (false, false) => NotRunKind::Program(name),
        };
        out.push(LineStretch { lines: part.lines, kind });
    }
    out
}

/// Subprograms of O words, from SUB to ENDSUB; the line of SUB is run where the flow steps over the
/// definition.
fn regions(source: &Source, index: &Index) -> Vec<LineStretch> {
    let region = |(label, (mark, _)): (&String, &(Mark, ProgramSection))| {
        let (_, first) = source.line(*mark)?;
        let end = index.partners.get(&mark.offset)?.end;
        // The line of ENDSUB itself is stepped over too.
        Some(LineStretch { lines: [first.line, end.line], kind: NotRunKind::Subprogram(format!("o{label}")) })
    };
    index.subs.iter().filter_map(region).collect()
}

/// Block numbers that a jump of the text names; none where a target is computed, so that it can be any.
struct Targets(Option<Vec<u32>>);

impl Targets {
    fn of(source: &Source, flavor: Flavor) -> Self {
        let mut numbers = Vec::new();
        let (mut block, mut at) = (IsoBlock::default(), Mark::START);
        while let Some((line, next)) = source.line(at) {
            at = next;
            let upper = |b: &u8| b.to_ascii_uppercase();
            // Plain blocks have neither.
            let jumps = line
                .as_bytes()
                .windows(2)
                .any(|w| matches!((upper(&w[0]), upper(&w[1])), (b'G', b'O') | (b'M', b'9') | (b'I', b'F')));
            if !jumps || parser::parse_line(line, flavor, &mut block).is_err() {
                continue;
            }
            let target = match block.behind.as_ref().or(block.statement.as_ref()) {
                Some(
                    IsoStatement::Goto(target) | IsoStatement::IfGoto(_, target) | IsoStatement::IfSequence(_, target),
                ) => Some(target.clone()),
                _ => block
                    .words
                    .iter()
                    .any(|w| w.letter == b'M' && matches!(w.value, WordValue::Number { value: 97.0 | 99.0, .. }))
                    .then(|| block.words.iter().find(|w| w.letter == b'P'))
                    .flatten()
                    .map(|word| match &word.value {
                        WordValue::Number { value, .. } => Expr::Number(*value),
                        WordValue::Expr(expr) => (**expr).clone(),
                    }),
            };
            match target {
                None => {}
                Some(Expr::Number(number)) => numbers.push(number as u32),
                Some(_) => return Self(None),
            }
        }
        Self(Some(numbers))
    }

    fn holds(&self, number: u32) -> bool {
        self.0.as_ref().is_none_or(|numbers| numbers.contains(&number))
    }
}

fn role(line: &str, at: Mark, index: &Index, flavor: Flavor, targets: &Targets) -> LineRole {
    let mut block = IsoBlock::default();
    if parser::parse_line(line, flavor, &mut block).is_err() {
        // Faults are reported separately.
        return LineRole { code: !line.trim().is_empty(), ..LineRole::default() };
    }
    let flow = match (&block.statement, block.number) {
        (Some(IsoStatement::While(..)), _) => Flow::Opens,
        (Some(IsoStatement::End(_)), _) => Flow::Closes,
        (Some(IsoStatement::OWord(OLabel::Fixed(_), word)), _) => match word {
            OWord::While(_) if index.partners.get(&at.offset).is_some_and(|p| p.next < at) => Flow::Closes,
            OWord::If(_) | OWord::Repeat(_) | OWord::Do | OWord::While(_) | OWord::Sub => Flow::Opens,
            OWord::ElseIf(_) | OWord::Else => Flow::Between,
            OWord::EndIf | OWord::EndWhile | OWord::EndRepeat | OWord::EndSub(_) => Flow::Closes,
            _ => Flow::On,
        },
        (_, Some(number)) if targets.holds(number) => Flow::Target,
        _ => Flow::On,
    };
    let is = |letter: u8, numbers: &[f64], word: &IsoWord| {
        word.letter == letter && matches!(word.value, WordValue::Number { value, .. } if numbers.contains(&value))
    };
    // Nothing is missed where further end words follow an end word.
    let closing = block.words.iter().all(|w| w.letter == b'N' || is(b'M', &[2.0, 30.0, 99.0], w));
    let calls = matches!(
        block.statement,
        Some(IsoStatement::OWord(_, OWord::Call(_)) | IsoStatement::Call(..) | IsoStatement::ModalCall(..))
    ) || block.words.iter().any(|w| is(b'M', &[97.0, 98.0, 198.0], w) || is(b'G', &[65.0, 66.0], w));
    let steers = matches!(
        block.statement,
        Some(
            IsoStatement::Goto(_)
                | IsoStatement::IfGoto(..)
                | IsoStatement::IfSequence(..)
                | IsoStatement::IfThen(..)
                | IsoStatement::While(..)
                | IsoStatement::Dollar(_)
        )
    );
    LineRole {
        code: !closing || calls || steers || !block.assignments.is_empty(),
        moves: calls || block.words.iter().any(|w| AXES.contains(&w.letter)),
        flow,
    }
}
