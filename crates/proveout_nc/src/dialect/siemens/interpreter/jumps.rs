//! Jumps and repetitions.

use std::sync::Arc;

use super::super::eval;
use super::super::expr::Expr;
use super::super::index;
use super::super::parser::{Direction, Jump};
use super::super::run_state::{Interpreter, Loaded, Repetition};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::source::Mark;

impl Interpreter {
    pub(super) fn partner(loaded: &Loaded, at: Mark, span: Span) -> Result<Mark, Fault> {
        loaded.index.partners.get(&at.offset).copied().ok_or_else(|| {
            Fault::new(codes::STRUCTURE, span, "the other end of this control structure is missing").help("write it")
        })
    }

    pub(super) fn jump(&mut self, loaded: &Arc<Loaded>, at: Mark, jump: &Jump) -> Result<(), Fault> {
        let name = match &jump.target {
            Expr::Name(name) if !self.variables.is_defined(name) => name.clone(),
            other => eval::shown(&self.variables.eval(other, jump.span)?).to_ascii_uppercase(),
        };
        let found = match jump.direction {
            Direction::Forward => self.find_target(loaded, at, &name, true),
            Direction::Backward => self.find_target(loaded, at, &name, false),
            Direction::Either | Direction::Silent => {
                self.find_target(loaded, at, &name, true).or_else(|| self.find_target(loaded, at, &name, false))
            }
        };
        if found.is_none() && jump.direction == Direction::Silent {
            return Ok(());
        }
        let Some(target) = found else {
            let way = match jump.direction {
                Direction::Forward => "after this block",
                Direction::Backward => "before this block",
                Direction::Either | Direction::Silent => "in this program",
            };
            return Err(Fault::new(codes::JUMP_TARGET, jump.span, format!("jump target `{name}` not found {way}"))
                .help("write the label with a colon, or jump in the other direction"));
        };
        self.jump_to(at, target, jump.span)
    }

    pub(in super::super) fn find_target(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        name: &str,
        forward: bool,
    ) -> Option<Mark> {
        let section = self.stack.last()?.section;
        if let Some(mark) = loaded.index.label(name, section, at.offset, forward) {
            return Some(mark);
        }
        let number: u32 = name.strip_prefix('N')?.parse().ok()?;
        let key = (Arc::clone(&loaded.source.name), at.offset, number, forward);
        if let Some(mark) = self.own.block_numbers.get(&key) {
            return Some(*mark);
        }
        let mark = index::find_block_number(&loaded.source, section, number, at, forward)?;
        self.own.block_numbers.insert(key, mark);
        Some(mark)
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one statement")]
    pub(super) fn repeat(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        first: &str,
        last: Option<&str>,
        count: Option<&Expr>,
        only_block: bool,
        span: Span,
    ) -> Result<(), Fault> {
        let count = match count {
            Some(count) => self.variables.number(count, span)?.round().clamp(0.0, f64::from(u32::MAX)) as u32,
            None => 1,
        };
        if count == 0 {
            return Ok(());
        }
        let missing = |name: &str| {
            Fault::new(codes::JUMP_TARGET, span, format!("the program has no label `{name}` for the repetition"))
                .help("write the label with a colon")
        };
        let from = self
            .find_target(loaded, at, first, false)
            .or_else(|| self.find_target(loaded, at, first, true))
            .ok_or_else(|| missing(first))?;
        let after = |mark: Mark| loaded.source.line(mark).map_or(mark, |(_, next)| next).offset;
        let end = if only_block {
            after(from)
        } else {
            let last_line = match last {
                Some(last) => Some(
                    self.find_target(loaded, from, last, true)
                        .or_else(|| (last == first).then_some(from))
                        .ok_or_else(|| missing(last))?,
                ),
                None => self
                    .find_target(loaded, from, "ENDLABEL", true)
                    .filter(|m| m.offset < at.offset || from.offset > at.offset),
            };
            match last_line {
                Some(mark) => after(mark),
                None if from.offset < at.offset => at.offset,
                None => return Err(missing("ENDLABEL")),
            }
        };
        let Some(level) = self.stack.last_mut() else { return Ok(()) };
        let resume = level.cursor;
        // A repetition left by a jump is dropped when its REPEAT is reached again.
        if let Some(old) = level.own.repetitions.iter().position(|r| r.resume == resume) {
            level.own.repetitions.truncate(old);
        }
        level.own.repetitions.push(Repetition { first: from, end, remaining: count, resume });
        level.cursor = from;
        self.count_pass(span)
    }
}
