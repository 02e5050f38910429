//! Runs a program line by line: control structures, jumps, subprograms.

mod assign;
mod calls;
mod jumps;

use std::path::PathBuf;
use std::sync::Arc;

use super::eval::{self, Val, Variables};
use super::expr::Expr;
use super::index::Index;
use super::modal::{Interpolation, Modal};
use super::parser::{self, Call, SiemensBlock, SiemensStatement};
use super::run_state::{CallLevel, Loaded, ModalCall};
use super::{leftover, recover};
use crate::channel::corners::{CornerLanguage, CornerMark, Corners};
use crate::channel::doubt::{Doubt, Stage};
use crate::channel::{Channel, FailedBlock, Language, LineLanguage, UsualFeed};
use crate::compensation::CompStyle;
use crate::control::MixedFeed;
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::frame::Frame;
use crate::not_run::NotRun;
use crate::source::{Mark, Source};
use crate::{AxisValues, Command, Settings};

pub(super) use super::run_state::{Interpreter, Siemens};
pub(crate) use calls::missing_subprogram;

/// The program, before its first block. `folder`: where it lies, if it is a file.
pub(super) fn begin(source: Source, folder: Option<PathBuf>, settings: &Settings) -> Interpreter {
    let offsets = settings.work_offsets.iter().map(|(word, &offset)| (word.to_ascii_uppercase(), Frame::from(offset)));
    let own = Siemens { offsets: offsets.collect(), ..Siemens::default() };
    let variables = Variables::new(&settings.variables, settings.limits.max_array_elements);
    let modal = Modal::new(settings.orientation_interpolation, &settings.control);
    let main = |index: &Index| (index.main, CallLevel::default());
    let mut channel = Channel::new(source, folder, settings, own, main, variables, modal);
    channel.position.begin_at(&settings.start_position);
    channel
}

impl Language for Siemens {
    type Index = Index;
    type Level = CallLevel;
    type Block = SiemensBlock;
    /// What the end of a motion needs for its corner.
    type Mark = Option<Box<CornerMark>>;
    type Variables = Variables;
    type Modal = Modal;

    fn index(&self, source: &Source, _main: bool, faults: &mut Vec<Diagnostic>) -> Index {
        Index::new(source, faults)
    }

    fn step(channel: &mut Interpreter) -> Result<(), Box<Diagnostic>> {
        if let Some(level) = channel.stack.last_mut()
            && let Some(repetition) = level.own.repetitions.last_mut()
            && repetition.end == level.cursor.offset
        {
            if repetition.remaining > 1 {
                repetition.remaining -= 1;
                level.cursor = repetition.first;
                let loaded = Arc::clone(&level.loaded);
                let at = level.cursor;
                let line = loaded.source.line(at).map_or("", |(line, _)| line);
                return channel
                    .count_pass(Span::new(0, line.len()))
                    .map_err(|fault| channel.failed(&loaded, at, line, fault));
            }
            level.cursor = repetition.resume;
            level.own.repetitions.pop();
        }
        channel.step_line()
    }

    fn hand_out(channel: &mut Interpreter) -> Option<Command> {
        channel.past_corners()
    }

    fn moving(channel: &mut Interpreter) {
        channel.passes.moved();
    }

    /// F counts the axes of the path, and the others arrive at the same time (*Fundamentals*, "Feedrate");
    /// which axes those are without FGROUP is machine data (MD22420).
    fn mixed_feed(_channel: &Interpreter) -> UsualFeed {
        UsualFeed::Usual(MixedFeed::Linear)
    }

    fn may_follow(channel: &Interpreter, fault: &Diagnostic) -> bool {
        recover::may_follow(channel, fault)
    }

    fn settle_doubt(channel: &mut Interpreter) {
        recover::settle_doubt(channel);
    }

    fn resume(channel: &mut Interpreter) -> Option<bool> {
        channel.own.curve_torn = matches!(channel.modal.interpolation, Interpolation::Spline(_));
        channel.own.first_line = None;
        channel.own.two_lines_torn = true;
        if !channel.own.corners.resume() {
            return None;
        }
        channel.done = channel.stack.is_empty();
        Some(true)
    }

    fn go_on(channel: &mut Interpreter, failed: &FailedBlock<Index>) -> Option<Doubt> {
        Some(recover::go_on(channel, failed))
    }

    fn doubted(channel: &mut Interpreter, doubt: Doubt) {
        if doubt.axes != 0 {
            channel.own.tangent = None;
            channel.own.held = AxisValues::NONE;
        }
    }

    fn comp_style(channel: &Interpreter) -> Option<CompStyle> {
        Some(channel.modal.compensation.style)
    }

    fn not_run(channel: &Interpreter) -> Vec<NotRun> {
        leftover::not_run(channel)
    }

    fn is_subprogram(channel: &Interpreter) -> bool {
        leftover::is_subprogram(&channel.main)
    }
}

impl CornerLanguage for Siemens {
    #[inline]
    fn corners(&mut self) -> &mut Corners {
        &mut self.corners
    }
}

impl LineLanguage for Siemens {
    fn run_line(
        channel: &mut Interpreter,
        loaded: &Arc<Loaded>,
        line: &str,
        at: Mark,
        block: &mut SiemensBlock,
    ) -> Result<(), Fault> {
        channel.recovery.faults.stage = Stage::Unread;
        parser::parse_line(line, block)?;
        channel.recovery.faults.stage = Stage::Read;
        if block.is_empty() || block.skip.is_some_and(|level| channel.settings.skipped_levels >> level & 1 == 1) {
            return Ok(());
        }
        channel.stands_at(&loaded.source.name, at, line, block.span);
        if block.skip.is_some() {
            channel.run_with_slash();
        }
        if !block.is_plain() && (line.contains('$') || !channel.own.frame_variables.is_empty()) {
            channel.refresh_system(block)?;
        }
        match block.statement.take() {
            Some(_) if channel.own.first_line.is_some() => Err(channel.no_second_line(block.span)),
            Some(statement) => channel.statement(loaded, at, statement, block.span),
            None => channel.execute(block, line),
        }
    }

    /// The end of the text acts as M30 in a program and as M17 in a subprogram.
    fn end_of_text(channel: &mut Interpreter, loaded: &Arc<Loaded>, at: Mark) -> Result<(), Box<Diagnostic>> {
        let waits = channel.own.first_line.is_some();
        let ended = if waits { Err(channel.no_second_line(Span::new(0, 0))) } else { channel.end_curve(None) };
        ended.map_err(|fault| Box::new(fault.at(&loaded.source.name, at.line.saturating_sub(1), "")))?;
        if channel.stack.len() > 1 {
            channel.leave();
        } else {
            channel.done = true;
        }
        Ok(())
    }
}

impl Interpreter {
    /// Ends the program, or the subprogram.
    pub(crate) fn end_or_return(&mut self) {
        if self.stack.len() <= 1 {
            self.end_of_program();
        } else {
            self.leave();
        }
    }

    fn truth(&self, condition: &Expr, span: Span) -> Result<bool, Fault> {
        Ok(self.variables.number(condition, span)? != 0.0)
    }

    fn statement(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        statement: SiemensStatement,
        span: Span,
    ) -> Result<(), Fault> {
        match statement {
            SiemensStatement::If(condition) => {
                if !self.truth(&condition, span)? {
                    self.continue_after(loaded, Self::partner(loaded, at, span)?);
                }
            }
            SiemensStatement::Else => self.continue_after(loaded, Self::partner(loaded, at, span)?),
            SiemensStatement::EndIf
            | SiemensStatement::Repeat
            | SiemensStatement::Loop
            | SiemensStatement::Extern
            | SiemensStatement::Proc { .. } => {}
            SiemensStatement::IfGoto(condition, jump) => {
                if self.truth(&condition, span)? {
                    self.jump(loaded, at, &jump)?;
                }
            }
            SiemensStatement::For { variable, from, to } => {
                let value = if std::mem::take(&mut self.own.next_pass_of_for) {
                    self.variables.number(&variable, span)? + 1.0
                } else {
                    self.variables.number(&from, span)?
                };
                self.assign_expr(&variable, Val::Number(value), span)?;
                if value > self.variables.number(&to, span)? {
                    self.continue_after(loaded, Self::partner(loaded, at, span)?);
                }
            }
            SiemensStatement::EndFor => {
                self.count_pass(span)?;
                self.own.next_pass_of_for = true;
                self.set_cursor(Self::partner(loaded, at, span)?);
            }
            SiemensStatement::While(condition) => {
                if !self.truth(&condition, span)? {
                    self.continue_after(loaded, Self::partner(loaded, at, span)?);
                }
            }
            SiemensStatement::EndWhile => {
                self.count_pass(span)?;
                self.set_cursor(Self::partner(loaded, at, span)?);
            }
            SiemensStatement::EndLoop => {
                self.count_pass(span)?;
                self.continue_after(loaded, Self::partner(loaded, at, span)?);
            }
            SiemensStatement::Until(condition) => {
                if !self.truth(&condition, span)? {
                    self.count_pass(span)?;
                    self.continue_after(loaded, Self::partner(loaded, at, span)?);
                }
            }
            SiemensStatement::GotoStart => {
                self.count_pass(span)?;
                if let Some(level) = self.stack.last_mut() {
                    level.cursor = level.section.start;
                }
            }
            SiemensStatement::Goto(jump) => self.jump(loaded, at, &jump)?,
            SiemensStatement::Case { selector, branches, default } => {
                let selector = self.variables.number(&selector, span)?;
                for (value, jump) in &branches {
                    if self.variables.number(value, span)? == selector {
                        return self.jump(loaded, at, jump);
                    }
                }
                if let Some(jump) = default {
                    self.jump(loaded, at, &jump)?;
                }
            }
            SiemensStatement::RepeatLabel { first, last, count, only_block } => {
                self.repeat(loaded, at, &first, last.as_deref(), count.as_ref(), only_block, span)?;
            }
            SiemensStatement::Define { kind, variables } => {
                for definition in &variables {
                    self.define(kind, definition)?;
                }
            }
            SiemensStatement::Return => self.end_or_return(),
            SiemensStatement::ModalCall(call) => {
                self.own.modal_call = match call {
                    None => None,
                    Some(call) => Some(ModalCall {
                        call: self.with_values(&call, span)?,
                        level: self.depth(),
                        place: (Arc::clone(&self.location.file), self.location.line),
                    }),
                };
            }
            SiemensStatement::CallText(name) => {
                let name = eval::shown(&self.variables.eval(&name, span)?).to_ascii_uppercase();
                let name = name.rsplit(['/', '\\']).next().unwrap_or_default();
                let name = name.strip_prefix("_N_").unwrap_or(name);
                let name =
                    ["_SPF", "_MPF", ".SPF", ".MPF"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(name);
                let call = Call { name: name.to_owned(), arguments: None };
                if !self.call_subprogram(&call, 1, span)? {
                    return Err(missing_subprogram(&call.name, span));
                }
            }
        }
        Ok(())
    }
}
