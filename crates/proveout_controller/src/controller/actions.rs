//! What the control does while the axes are at rest: dwell, spindle, tool change, switching of tool
//! length and tool center point control.

use proveout_machine::MAX_JOINTS;
use proveout_nc::{Command, CompSide, Dwell, Location, Op, OrientationInterpolation, SpindleDirection, Tcp, ToolName};

use super::{Controller, scope};
use crate::{
    error::ControlError,
    motion::Context,
    output::{BlockKind, Event, MoveKind},
    path::PathBlock,
};

/// Joints that are this near to the position for a tool change are there, mm or radian.
const STANDS: f64 = 1e-9;

/// Commands that this control does not execute are refused by name.
pub(super) fn special(op: &Op, location: &Location) -> Result<(), Box<ControlError>> {
    let what = match op {
        Op::CutterComp(comp) if comp.side != CompSide::Off => "a contour that is not yet the path of the tool center",
        _ => return Ok(()),
    };
    let message = format!("{what} is not executed by this control");
    Err(Box::new(ControlError::at(location, "control-unsupported", message, "program the motion in another way")))
}

impl<E, I> Controller<'_, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    /// A standstill of some time with its block record.
    pub(super) fn action(&mut self, location: &Location, kind: BlockKind, duration: f64) -> u32 {
        self.stop_run();
        if self.cut_short.is_some() {
            return self.next_block.saturating_sub(1);
        }
        let index = self.next_block;
        self.next_block += 1;
        let scope = scope(&self.device, &self.settings, self.mapping);
        let start = self.out.clock;
        self.out.stand(&scope, &self.state.position.q, index, duration);
        self.record(index, &location.file, location.line, kind, start);
        self.out.meter.bound_s += duration;
        let frame = self.device.frame(self.mapping);
        self.out.meter.tube.stand(&frame, duration);
        self.ready = true;
        index
    }

    pub(super) fn dwell(&mut self, dwell: Dwell, location: &Location) -> Result<(), Box<ControlError>> {
        let rpm = self.state.spindle.speed_rpm.unwrap_or(0.0);
        let duration = match dwell {
            Dwell::Seconds(s) => s,
            Dwell::Revolutions(n) if rpm > 0.0 && self.state.spindle.direction != SpindleDirection::Off => {
                n * 60.0 / rpm
            }
            Dwell::Revolutions(n) => {
                let message = format!("a dwell of {n} revolutions, but the spindle does not turn");
                let help = "start the spindle before or program the dwell in seconds";
                return Err(Box::new(ControlError::at(location, "control-dwell", message, help)));
            }
        };
        if !(duration >= 0.0 && duration.is_finite()) {
            let message = format!("a dwell of {duration} s");
            let help = "program a time of zero or more";
            return Err(Box::new(ControlError::at(location, "control-dwell", message, help)));
        }
        if self.ends_before_standstill(duration, location) {
            return Ok(());
        }
        self.stop_run();
        if self.cut_short.is_some() {
            return Ok(());
        }
        let time = self.out.clock;
        self.out.meter.summary.dwell_s += duration;
        let block = self.action(location, BlockKind::Dwell, duration);
        self.out.chunk.events.push(Event::Dwell { time, block, duration });
        Ok(())
    }

    /// What the base coordinates X, Y, Z mean has changed: what the program said about them is void.
    pub(super) fn forget_linear(&mut self) {
        self.state.position.base[..3].fill(None);
        self.state.position.told = None;
    }

    pub(super) fn set_edge(&mut self, on: bool) {
        if on != self.state.edge_on {
            self.state.edge_on = on;
            self.forget_linear();
        }
    }

    /// Waits until the spindle has reached its speed (or rest).
    pub(super) fn await_spindle(&mut self, location: &Location) {
        if self.state.spindle_ready <= 0.0 {
            return;
        }
        self.stop_run();
        let wait = self.state.spindle_ready - self.out.clock;
        self.state.spindle_ready = 0.0;
        if wait > 0.0 && self.cut_short.is_none() {
            let time = self.out.clock;
            self.out.meter.summary.dwell_s += wait;
            let block = self.action(location, BlockKind::Action, wait);
            self.out.chunk.events.push(Event::Dwell { time, block, duration: wait });
        }
    }

    pub(super) fn set_delta_length(&mut self, length: f64) {
        if length != self.state.delta_length {
            self.stop_run();
            self.state.delta_length = length;
            self.forget_linear();
        }
    }

    /// The tool turns about another point: where its tip is in the table frame afterwards, the program has
    /// not said.
    pub(super) fn set_turn_center(&mut self, ahead: f64) {
        if ahead != self.state.turn_center {
            self.stop_run();
            self.state.turn_center = ahead;
            self.forget_linear();
        }
    }

    pub(super) fn switch_tcp(&mut self, tcp: Tcp, location: &Location) -> Result<(), Box<ControlError>> {
        if tcp.on && self.device.rig.is_none() {
            let message = format!(
                "tool center point control on machine {}, which does not have exactly three free, independent linear \
                 joints",
                self.device.machine.name
            );
            let help = "switch it off in the program, or hold the surplus linear joints in the machine description";
            return Err(Box::new(ControlError::at(location, "control-tcp", message, help)));
        }
        if tcp.on != self.state.tcp.on {
            self.stop_run();
            self.forget_linear();
        }
        self.state.tcp = tcp;
        Ok(())
    }

    /// Index of a tool in the library; none for an empty spindle.
    pub(super) fn find_tool(&self, name: &ToolName, location: &Location) -> Result<Option<usize>, Box<ControlError>> {
        let tool = match name {
            ToolName::Empty => None,
            ToolName::Number(n) => Some(self.tools.iter().position(|t| t.number == *n)),
            ToolName::Name(n) => Some(self.tools.iter().position(|t| t.name == *n)),
        };
        if tool == Some(None) {
            let shown = match name {
                ToolName::Empty => "T0".to_owned(),
                ToolName::Number(n) => format!("T{n}"),
                ToolName::Name(n) => format!("\"{n}\""),
            };
            let message = format!("tool {shown} is not in the tool library ({} tools)", self.tools.len());
            let help = "add the tool to the library or correct its name in the program";
            return Err(Box::new(ControlError::at(location, "control-tool", message, help)));
        }
        Ok(tool.flatten())
    }

    /// A tool that is made ready and never comes into the spindle need not be known.
    pub(super) fn select(&mut self, name: &ToolName, location: &Location) {
        if let Err(unknown) = self.find_tool(name, location) {
            let text = format!("{}: it is made ready, and may not come into the spindle", unknown.message);
            self.announce(Event::Note { time: 0.0, block: self.next_block, text: text.into() });
        }
    }

    pub(super) fn tool_change(&mut self, name: &ToolName, location: &Location) -> Result<(), Box<ControlError>> {
        let tool = self.find_tool(name, location)?;
        self.stop_run();
        self.visit_change_position(location);
        self.await_spindle(location);
        if self.cut_short.is_some() {
            return Ok(());
        }
        let duration = self.device.machine.control.tool_change_time.max(0.0);
        self.out.meter.summary.tool_change_s += duration;
        let block = self.action(location, BlockKind::ToolChange, duration);
        self.state.tool = tool;
        self.mapping = self.mapping_with(self.mapping.tcp_length);
        self.state.edge_on |= self.settings.length_active_after_change;
        self.forget_linear();
        self.out.chunk.events.push(Event::ToolChange { time: self.out.clock, block, tool: self.state.tool });
        Ok(())
    }

    /// Drives to the tool change position of the machine, if it has one: first the linear joint along the
    /// spindle, then the others together.
    pub(super) fn visit_change_position(&mut self, location: &Location) {
        let frame = self.device.frame(self.mapping);
        self.out.meter.tube.stand(&frame, 0.0);
        let machine = self.device.machine;
        let position = machine.control.tool_change_position;
        let spindle = machine.spindle.gauge_pose.vector(&proveout_geom::Vector::z());
        let along =
            |i: usize| machine.joints.get(i).is_some_and(|j| !j.is_rotary() && j.direction.dot(&spindle).abs() > 0.9);
        for lift in [true, false] {
            let from = self.state.position.q;
            let mut to = from;
            for i in (0..machine.joints.len().min(MAX_JOINTS)).filter(|&i| along(i) == lift) {
                if let Some(value) = position[i] {
                    to[i] = value;
                }
            }
            if (to - from).max_abs() <= STANDS {
                continue;
            }
            self.mapping = self.mapping_with(None);
            let context = Context {
                machine,
                rig: None,
                mapping: self.mapping,
                active_length: 0.0,
                orientation: OrientationInterpolation::Axes,
                pole_cone: 0.0,
                rapid: true,
                location,
            };
            let path = context.between(from, to);
            let Some(part) = path.parts.into_iter().next() else { continue };
            let index = self.next_block;
            self.next_block += 1;
            self.state.position.q = to;
            let block = PathBlock {
                index,
                shape: part.shape,
                chord: None,
                length: part.length,
                s0: 0.0,
                kind: MoveKind::Handling,
                feed: f64::INFINITY,
                feed_programmed: 0.0,
                coupled: false,
                corner: None,
                loose: None,
                stands: true,
                tip_moves: path.tip_moves,
                told: path.programmed.map(|way| (std::sync::Arc::from(way), part.t)),
                file: location.file.clone(),
                line: location.line,
            };
            self.push_block(block, from);
            self.stop_run();
        }
    }

    /// The sample after the end: the machine is at rest.
    pub(super) fn last_sample(&mut self) {
        let time = crate::stretch::grid_number(self.out.clock, self.out.cycle) * self.out.cycle;
        let scope = scope(&self.device, &self.settings, self.mapping);
        let block = self.next_block.saturating_sub(1);
        let q = self.cut_short.unwrap_or(self.state.position.q);
        self.out.still_sample(&scope, &q, block, time);
    }
}
