//! Control structures: branches, loops, jumps.

use std::sync::Arc;

use super::expr::Expr;
use super::index::{self, Partner};
use super::osp::NAMED_SEQUENCE;
use super::parser::{self, IsoBlock};
use super::run_state::CallKind;
use super::run_state::{Interpreter, Loaded};
use super::statement::{IsoStatement, OLabel, OWord};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::source::Mark;

/// Block numbers from here on are none: they and those of sequence names are whole numbers of 32 bits.
const BLOCK_NUMBERS: f64 = 4e9;

impl Interpreter {
    /// Does a statement; false where it leaves a loop, and nothing else of its block is run.
    pub(crate) fn statement(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        statement: IsoStatement,
        block: &IsoBlock,
        line: &str,
    ) -> Result<bool, Fault> {
        let span = block.span;
        match statement {
            // A LinuxCNC runs through the heads of numbered programs, but not from a subprogram of O words.
            IsoStatement::Header(name) => {
                let in_sub = self.stack.last().is_some_and(|level| level.own.kind == CallKind::OSub);
                if self.own.flavor.is_linuxcnc() && in_sub {
                    let message = format!("a subprogram of O words runs into the head of the numbered program {name}");
                    return Err(
                        Fault::new(codes::STRUCTURE, span, message).help("close it with endsub before the head")
                    );
                }
            }
            IsoStatement::Output(text) => self.note(text),
            IsoStatement::Call(call) => self.call_program(&call, false, block, span)?,
            IsoStatement::ModalCall(call) => self.call_program(&call, true, block, span)?,
            IsoStatement::EndModal => self.own.modal_macro = None,
            IsoStatement::EndCall => self.end_call(span)?,
            IsoStatement::IfGoto(condition, target) | IsoStatement::IfSequence(condition, target) => {
                if self.truth(&condition, span)? {
                    self.goto(loaded, at, &target, span)?;
                }
            }
            IsoStatement::IfThen(condition, assignment) => {
                if self.truth(&condition, span)? {
                    self.assign_all(std::slice::from_ref(&assignment), block.comment, line)?;
                }
            }
            IsoStatement::Goto(target) => self.goto(loaded, at, &target, span)?,
            IsoStatement::Repeat(first, last, passes) => self.repeat_blocks(loaded, at, [first, last, passes], span)?,
            IsoStatement::While(condition, _) => {
                if let Some(condition) = condition
                    && !self.truth(&condition, span)?
                {
                    self.continue_after(loaded, partner(loaded, at, span)?.next);
                    return Ok(false);
                }
            }
            IsoStatement::End(_) => {
                self.count_pass(span)?;
                self.set_cursor(partner(loaded, at, span)?.next);
            }
            IsoStatement::Dollar(text) => self.dollar(&text, span)?,
            IsoStatement::OWord(label, word) => self.o_word(loaded, at, &label, word, span)?,
        }
        Ok(true)
    }

    fn o_word(&mut self, loaded: &Arc<Loaded>, at: Mark, label: &OLabel, word: OWord, span: Span) -> Result<(), Fault> {
        match word {
            // A definition that the flow reaches is stepped over.
            OWord::Sub => self.continue_after(loaded, partner(loaded, at, span)?.next),
            OWord::EndSub(value) | OWord::Return(value) => {
                let value = match value {
                    Some(value) => Some(self.number(&value, span)?),
                    None => None,
                };
                self.return_from_o_sub(value, span)?;
            }
            OWord::Call(arguments) => self.call_o_sub(label, &arguments, span)?,
            OWord::If(condition) => {
                if !self.truth(&condition, span)? {
                    self.next_branch(loaded, at, span)?;
                }
            }
            // Reached from above: the branch before has run.
            OWord::ElseIf(_) | OWord::Else => self.continue_after(loaded, partner(loaded, at, span)?.end),
            OWord::EndIf | OWord::Do => {}
            OWord::While(condition) => {
                let partner = partner(loaded, at, span)?;
                let closes_do = partner.next.offset < at.offset;
                match (self.truth(&condition, span)?, closes_do) {
                    (true, true) => {
                        self.count_pass(span)?;
                        self.continue_after(loaded, partner.next);
                    }
                    (false, false) => self.continue_after(loaded, partner.next),
                    _ => {}
                }
            }
            OWord::EndWhile => {
                self.count_pass(span)?;
                self.set_cursor(partner(loaded, at, span)?.next);
            }
            OWord::Repeat(count) => {
                let count = self.number(&count, span)?.round();
                self.forget_repeat(at.offset);
                if count >= 1.0 {
                    if let Some(level) = self.stack.last_mut() {
                        level.own.repeats.push((at.offset, count as u64));
                    }
                } else {
                    self.continue_after(loaded, partner(loaded, at, span)?.next);
                }
            }
            OWord::EndRepeat => {
                let first = partner(loaded, at, span)?.next;
                self.again(loaded, first, span)?;
            }
            OWord::Break => {
                let partner = partner(loaded, at, span)?;
                self.forget_repeat(partner.next.offset);
                self.continue_after(loaded, partner.end);
            }
            OWord::Continue => {
                let loop_ = partner(loaded, at, span)?;
                if loop_.next.offset < at.offset && self.is_repeat(loop_.next.offset) {
                    return self.again(loaded, loop_.next, span);
                }
                // WHILE is evaluated in its first line, DO in its last.
                let do_while = is_do(loaded, loop_.next, self);
                if do_while {
                    self.set_cursor(loop_.end);
                } else {
                    self.count_pass(span)?;
                    self.set_cursor(loop_.next);
                }
            }
        }
        Ok(())
    }

    fn is_repeat(&self, first: usize) -> bool {
        self.stack.last().is_some_and(|level| level.own.repeats.iter().any(|(offset, _)| *offset == first))
    }

    fn forget_repeat(&mut self, first: usize) {
        if let Some(level) = self.stack.last_mut() {
            level.own.repeats.retain(|(offset, _)| *offset != first);
        }
    }

    /// The end of a pass of O REPEAT.
    fn again(&mut self, loaded: &Loaded, first: Mark, span: Span) -> Result<(), Fault> {
        let left = self
            .stack
            .last_mut()
            .and_then(|level| level.own.repeats.iter_mut().find(|(offset, _)| *offset == first.offset));
        match left {
            Some((_, left)) if *left > 1 => {
                *left -= 1;
                self.count_pass(span)?;
                self.continue_after(loaded, first);
            }
            _ => {
                self.forget_repeat(first.offset);
                let end = partner_of(loaded, first).map_or(first, |p| p.end);
                self.continue_after(loaded, end);
            }
        }
        Ok(())
    }

    /// Goes on after the next ELSEIF whose condition holds, or after ELSE or ENDIF.
    fn next_branch(&mut self, loaded: &Arc<Loaded>, from: Mark, span: Span) -> Result<(), Fault> {
        let mut at = partner(loaded, from, span)?.next;
        let mut block = IsoBlock::default();
        loop {
            let line = loaded.source.line(at).map_or("", |(line, _)| line);
            parser::parse_line(line, self.own.flavor, &mut block)?;
            match block.statement.take() {
                Some(IsoStatement::OWord(_, OWord::ElseIf(condition))) if !self.truth(&condition, span)? => {
                    at = partner(loaded, at, span)?.next;
                }
                _ => {
                    self.continue_after(loaded, at);
                    return Ok(());
                }
            }
        }
    }

    fn goto(&mut self, loaded: &Arc<Loaded>, at: Mark, target: &Expr, span: Span) -> Result<(), Fault> {
        let number = self.number(target, span)?;
        self.goto_number(loaded, at, number, span)
    }

    /// Jumps to a block number of the running program.
    pub(crate) fn goto_number(&mut self, loaded: &Arc<Loaded>, at: Mark, number: f64, span: Span) -> Result<(), Fault> {
        let target = self.find_number(loaded, at, number, span)?;
        self.jump_to(at, target, span)
    }

    pub(crate) fn find_number(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        number: f64,
        span: Span,
    ) -> Result<Mark, Fault> {
        let missing = || {
            let what = if number < f64::from(NAMED_SEQUENCE) {
                format!("block number N{number}")
            } else {
                "sequence name".to_owned()
            };
            Fault::new(codes::JUMP_TARGET, span, format!("the program has no {what}"))
                .help("write the block number at the start of its block")
        };
        let Some(level) = self.stack.last() else { return Err(missing()) };
        if !(number.fract() == 0.0 && (0.0..BLOCK_NUMBERS).contains(&number)) {
            return Err(missing());
        }
        let (section, wanted) = (level.section, number as u32);
        // A file keeps its address for the whole run: the address identifies it.
        let key = (Arc::as_ptr(loaded) as usize, at.offset, wanted);
        if let Some(mark) = self.own.block_numbers.get(&key) {
            return Ok(*mark);
        }
        let mark = index::find_block_number(&loaded.source, section, wanted, at).ok_or_else(missing)?;
        self.own.block_numbers.insert(key, mark);
        Ok(mark)
    }

    pub(crate) fn truth(&self, condition: &Expr, span: Span) -> Result<bool, Fault> {
        Ok(self.number(condition, span)? != 0.0)
    }
}

fn partner_of(loaded: &Loaded, at: Mark) -> Option<Partner> {
    loaded.index.partners.get(&at.offset).copied()
}

fn partner(loaded: &Loaded, at: Mark, span: Span) -> Result<Partner, Fault> {
    partner_of(loaded, at).ok_or_else(|| {
        Fault::new(codes::STRUCTURE, span, "the other end of this control structure is missing").help("write it")
    })
}

/// The line opens a DO loop of O words.
fn is_do(loaded: &Loaded, at: Mark, interpreter: &Interpreter) -> bool {
    let mut block = IsoBlock::default();
    let line = loaded.source.line(at).map_or("", |(line, _)| line);
    parser::parse_line(line, interpreter.own.flavor, &mut block).is_ok()
        && matches!(block.statement, Some(IsoStatement::OWord(_, OWord::Do)))
}
