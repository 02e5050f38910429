//! Executes blocks that are not paths.

use std::sync::Arc;

use super::run_state::{Interpreter, Loaded};
use super::variables::Val;
use super::words::{Block, PathFunction, Reference, Statement, ToolCall, ToolRef};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::machine_data::KinematicsKind;
use crate::source::Mark;
use crate::{Offset, Op, ToolAction, ToolName};

impl Interpreter {
    pub(crate) fn statement(
        &mut self,
        loaded: &Arc<Loaded>,
        at: Mark,
        statement: Statement,
        block: &mut Block,
    ) -> Result<(), Fault> {
        let span = block.span;
        match statement {
            // These are allowed between the elements of a contour.
            Statement::Empty | Statement::Path(_) => Ok(()),
            Statement::Note(text) => {
                self.modal.held &= self.modal.corner.is_some();
                self.note(text);
                Ok(())
            }
            Statement::Assign(param, formula) => {
                let value = self.variables.eval(&formula, span)?;
                self.variables.assign(param, value, span)
            }
            Statement::Branch(condition, label) => {
                if self.variables.truth(&condition, span)? {
                    self.goto(loaded, at, &label, span)?;
                }
                Ok(())
            }
            Statement::Goto(label) => self.goto(loaded, at, &label, span),
            Statement::Label(label) => {
                if matches!(label, super::words::Label::Number(super::words::Value::Number(0.0))) {
                    self.label_end();
                }
                Ok(())
            }
            Statement::CallLabel { label, repeat } => {
                let repeat = repeat.map(|value| self.variables.value(value, span)).transpose()?;
                self.call_label(loaded, at, &label, repeat, span)
            }
            Statement::Din(din) => self.din(&din, block),
            Statement::Begin { .. } if self.follows_code(loaded, at) => {
                Err(Fault::new(codes::NO_END, span, "another program begins here, and the one before has no end")
                    .help("write END PGM in front of it, and give each program a file of its own"))
            }
            other => {
                self.settle_contour(span)?;
                self.settled(other, block)
            }
        }
    }

    fn settled(&mut self, statement: Statement, block: &Block) -> Result<(), Fault> {
        let (span, words) = (block.span, &block.words);
        match statement {
            Statement::Begin { inch } => {
                self.modal.inch = inch;
                if *self.position.frame() != self.modal.frames.total() {
                    self.take_frames("PRESET0", span)?;
                }
                if self.stack.len() == 1 {
                    self.position.begin_at(&self.settings.start_position);
                }
                Ok(())
            }
            Statement::End => self.program_end(),
            Statement::ToolCall(call) => self.tool_call(&call, span),
            Statement::ToolDef(tool, rest) => {
                let name = self.tool_name(&tool, span)?;
                self.emit(Op::Tool(ToolAction::Select(name)));
                if !rest.trim().is_empty() {
                    self.note(format!("TOOL DEF {}: the tool library gives the dimensions", rest.trim()));
                }
                Ok(())
            }
            Statement::OldCycle { number, part, words } => self.old_cycle(number, part, words, span),
            Statement::OldCycleProgram(name) => {
                self.cycle_program(name);
                Ok(())
            }
            Statement::Cycle { number, values } => self.cycle(number, &values, span),
            Statement::CycleCall => {
                super::takes::functions_alone(words, "CYCL CALL", span)?;
                self.functions_before(words, span)?;
                self.run_cycle(span)?;
                self.functions_after(words, span)?;
                self.functions_last(words);
                Ok(())
            }
            Statement::CycleCallPos => self.cycle_call_pos(words, span),
            Statement::CycleCallPattern => self.cycle_call_pattern(words, span),
            Statement::Pattern(points) => {
                self.modal.pattern = points;
                Ok(())
            }
            Statement::CallProgram(name) => self.call_program(&name, span),
            Statement::CallProgramText(param) => {
                let name = self.variables.text(param, span)?.to_owned();
                self.call_program(&name, span)
            }
            Statement::SelectProgram(name) => {
                self.select_program(name);
                Ok(())
            }
            Statement::SelectProgramText(param) => {
                let name = self.variables.text(param, span)?.to_owned();
                self.select_program(name);
                Ok(())
            }
            Statement::CallSelected => self.call_selected(span),
            Statement::SystemRead(target, from) => self.system_read(target, &from, span),
            Statement::CircleData(target, from) => self.circle_data(target, from, span),
            Statement::Error(value) => {
                let number = self.variables.value(value, span)?;
                Err(Fault::new(codes::BAD_VALUE, span, format!("the program stops itself with error {number} (FN 14)"))
                    .help("check the condition that leads here"))
            }
            Statement::Plane(plane) => self.plane(&plane, span),
            Statement::Tcpm(tcpm) => {
                self.settings.check_kinematics(KinematicsKind::Tcp, "FUNCTION TCPM", span)?;
                self.function_tcpm(&tcpm);
                Ok(())
            }
            Statement::ResetTcpm => {
                self.set_tcpm(false);
                Ok(())
            }
            Statement::Datum(true) => self.shift(words, "TRANS DATUM", span),
            Statement::Datum(false) => self.shift_to([0.0; 6], "TRANS DATUM RESET", span),
            Statement::DatumRow(row) => {
                let row = self.variables.value(row, span)?;
                self.datum_row(row, span)
            }
            Statement::TransMirror(on) => self.mirror(if on { words.programmed } else { 0 }, "TRANS MIRROR", span),
            Statement::TransRotation(angle) => {
                let none = super::words::Coordinate {
                    value: super::words::Value::Number(0.0),
                    reference: Reference::Absolute,
                };
                self.rotation(angle.unwrap_or(none), "TRANS ROTATION", span)
            }
            Statement::TransScale(factor) => {
                let factor = factor.map_or(Ok(1.0), |value| self.variables.value(value, span))?;
                self.scale([factor; 3], [0.0; 3], false, "TRANS SCALE", span)
            }
            Statement::Stop => {
                self.path(PathFunction::Nothing, words, span)?;
                if !words.functions.iter().any(|m| matches!(m.code, 0 | 1 | 2 | 30)) {
                    self.emit(Op::Stop { optional: false });
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn tool_name(&self, tool: &ToolRef, span: Span) -> Result<ToolName, Fault> {
        Ok(match tool {
            ToolRef::Name(name) => ToolName::Name(name.clone()),
            ToolRef::Text(param) => ToolName::Name(self.variables.text(*param, span)?.to_owned()),
            ToolRef::Number(value) => {
                let number = self.variables.value(*value, span)?;
                if number > 0.0 && (number * 10.0).fract() == 0.0 && number.fract() != 0.0 {
                    // `TOOL CALL 5.2`: an index of the tool table, which counts as a tool of its
                    // own.
                    return Ok(ToolName::Name(format!("{number}")));
                }
                if !(0.0..=4_294_967_295.0).contains(&number) || number.fract() != 0.0 {
                    return Err(Fault::new(codes::BAD_VALUE, span, format!("{number} is not a tool number"))
                        .help("write a whole number"));
                }
                if number == 0.0 { ToolName::Empty } else { ToolName::Number(number as u32) }
            }
        })
    }

    /// TOOL CALL: tool, tool axis, speed, feed and delta values. The tool length acts from here.
    pub(crate) fn tool_call(&mut self, call: &ToolCall, span: Span) -> Result<(), Fault> {
        let unit = self.modal.unit();
        if let Some(tool) = &call.tool {
            let name = self.tool_name(tool, span)?;
            if self.technology.in_spindle.as_ref() != Some(&name) {
                self.emit(Op::Tool(ToolAction::Change(name.clone())));
                let edge = u32::from(name != ToolName::Empty);
                self.emit(Op::Offset(Offset::ToolEdge { edge }));
                self.technology.in_spindle = Some(name);
            }
        }
        let given = [call.length, call.radius, call.corner];
        let alone = call.tool.is_none() && given.iter().any(Option::is_some);
        if alone {
            self.assume(
                "delta values of a TOOL CALL without a tool hold for the tool in the spindle; those that it does not \
                 name stay",
            );
        }
        if call.tool.is_some() || alone {
            // A change moves the machine, and with another length the tip is another point.
            self.position.forget(super::motion::LINEAR);
            self.modal.tangent = None;
            let mut delta = if alone { self.modal.delta } else { [0.0; 3] };
            for (slot, value) in delta.iter_mut().zip(given) {
                if let Some(value) = value {
                    *slot = self.variables.value(value, span)? * unit;
                }
            }
            if delta != self.modal.delta {
                self.modal.delta = delta;
                let [length, radius, corner_radius] = delta;
                self.emit(Op::Offset(Offset::ToolDelta { length, radius, corner_radius }));
            }
            self.take_tool_radius(span)?;
        }
        if let Some(axis) = call.axis {
            let normal = usize::from(axis as u8 - b'X');
            if !self.modal.plane_told || normal != self.modal.normal {
                self.modal.normal = normal;
                self.modal.plane_told = true;
                self.modal.pole = None;
                self.emit(Op::Plane(axis));
            }
        }
        if let Some(speed) = call.speed {
            let speed = self.variables.value(speed, span)?;
            self.technology.speed = Some(Self::checked_speed(speed, span)?);
            if self.technology.direction != crate::SpindleDirection::Off {
                self.tell_spindle();
            }
        }
        if let Some(feed) = call.feed {
            // It holds until the next F, and FAUTO comes back to it.
            if let Some(feed) = self.feed_of(feed, span)? {
                self.modal.tool_feed = Some(feed);
                self.set_feed(Some(feed));
                self.rapid_by_number(Some(feed));
            }
        }
        Ok(())
    }

    /// FN 23: center and radius of the circle through three points, given in six parameters.
    fn circle_data(&mut self, target: super::words::Param, from: super::words::Param, span: Span) -> Result<(), Fault> {
        let mut p = [0.0; 6];
        for (slot, by) in p.iter_mut().zip(0u32..) {
            let param = super::words::Param { index: from.index.saturating_add(by), ..from };
            *slot = self.variables.value(super::words::Value::Param { negative: false, param }, span)?;
        }
        let (bx, by, cx, cy) = (p[2] - p[0], p[3] - p[1], p[4] - p[0], p[5] - p[1]);
        let d = 2.0 * (bx * cy - by * cx);
        if d == 0.0 {
            return Err(Fault::new(codes::ARITHMETIC, span, "the three points of FN 23 lie on one line")
                .help("choose other points"));
        }
        let (b, c) = (bx * bx + by * by, cx * cx + cy * cy);
        let (ux, uy) = ((cy * b - by * c) / d, (bx * c - cx * b) / d);
        for (value, by) in [p[0] + ux, p[1] + uy, ux.hypot(uy)].into_iter().zip(0u32..) {
            let param = super::words::Param { index: target.index.saturating_add(by), ..target };
            self.variables.assign(param, Val::Number(value), span)?;
        }
        Ok(())
    }
}
