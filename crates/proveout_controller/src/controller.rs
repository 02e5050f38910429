//! Executes canonical commands: state of the control, runs between stops, standstill.

use std::sync::Arc;

use proveout_machine::{JointValues, MAX_JOINTS, Machine, RapidMode};
use proveout_nc::{
    AXIS_LETTERS, ArcMotion, Command, Dwell, Feed, Location, Motion, Offset, Op, OrientationInterpolation, PathMode,
    Spindle, SpindleDirection, Tcp, ToolAction, ToolName,
};
use proveout_tool::Tool;

use crate::{
    emit::{Emitter, Scope, Waiting},
    error::{ControlError, RunError},
    limits::JointLimits,
    mapping::{Kinematics, Mapping},
    motion::{BlockPath, Context, Position},
    output::{BlockKind, BlockRecord, Chunk, Event, LimitKind, MoveKind},
    path::{Frame, Path, PathBlock, Tolerance},
    profile::Law,
    rig::Rig,
    scurve::{Rates, peak_speed},
    settings::Settings,
    shape::{Shape, Timed},
    stretch::{self, Stretch},
    summary::Summary,
};

/// Machine and what is derived from it once.
struct Device<'m> {
    machine: &'m Machine,
    rig: Option<Rig>,
    limits: JointLimits,
}

impl Device<'_> {
    fn frame(&self, mapping: Mapping) -> Frame<'_> {
        Frame {
            kinematics: Kinematics { machine: self.machine, rig: self.rig.as_ref(), mapping },
            limits: &self.limits,
        }
    }
}

/// What the program has set.
struct State {
    position: Position,
    tool: Option<usize>,
    edge_on: bool,
    tcp: Tcp,
    path_mode: PathMode,
    feed: Option<Feed>,
    spindle: Spindle,
}

/// The control: takes canonical commands and gives the motion of the machine in chunks.
///
/// ```text
/// while let Some(chunk) = controller.next_chunk()? { ... }
/// let summary = controller.summary();
/// ```
pub struct Controller<'m, I> {
    commands: I,
    tools: &'m [Tool],
    device: Device<'m>,
    settings: Settings,
    state: State,
    path: Path,
    mapping: Mapping,
    /// Speed at the begin of the path's first cell.
    v_start: f64,
    out: Emitter,
    next_block: u32,
    ready: bool,
    ended: bool,
    finished: bool,
}

impl<'m, E, I> Controller<'m, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    /// A control with all joints at home, no tool, and the path mode "continuous".
    ///
    /// # Errors
    /// [`ControlError`] when a setting or a limit of the machine is not a number above zero.
    pub fn new(
        commands: I,
        machine: &'m Machine,
        tools: &'m [Tool],
        settings: Settings,
    ) -> Result<Self, Box<ControlError>> {
        check_settings(&settings)?;
        check_limits(machine)?;
        check_cycle(machine)?;
        let cycle = settings.sample_time.unwrap_or(machine.control.cycle_time);
        let home = machine.home();
        let mapping = Mapping { tcp_length: None, tool_length: 0.0 };
        Ok(Self {
            commands,
            tools,
            device: Device { machine, rig: Rig::new(machine), limits: JointLimits::new(machine) },
            state: State {
                position: Position { q: home, base: [None; AXIS_LETTERS.len()] },
                tool: None,
                edge_on: false,
                tcp: Tcp { on: false, interpolation: OrientationInterpolation::Axes },
                path_mode: PathMode::Continuous { tolerance: None, orientation_tolerance: None },
                feed: None,
                spindle: Spindle { direction: SpindleDirection::Off, speed_rpm: None },
            },
            settings,
            path: Path::default(),
            mapping,
            v_start: 0.0,
            out: Emitter::new(cycle, &home),
            next_block: 0,
            ready: false,
            ended: false,
            finished: false,
        })
    }

    /// The next stretch of the run; none after the end.
    ///
    /// # Errors
    /// What the source of commands reports, and commands that the control refuses. After an error there is no further
    /// chunk.
    pub fn next_chunk(&mut self) -> Result<Option<Chunk>, RunError<E>> {
        while !self.finished {
            if self.ended {
                self.stop_run();
                self.last_sample();
                self.finished = true;
                return Ok(Some(self.out.take()));
            }
            match self.commands.next() {
                None => self.ended = true,
                Some(Ok(command)) => {
                    if let Err(e) = self.execute(&command) {
                        self.finished = true;
                        return Err(RunError::Control(e));
                    }
                }
                Some(Err(e)) => {
                    self.finished = true;
                    return Err(RunError::Program(e));
                }
            }
            if self.ready {
                self.ready = false;
                return Ok(Some(self.out.take()));
            }
        }
        Ok(None)
    }

    /// What the run took so far; complete after the last chunk.
    pub fn summary(&self) -> Summary {
        self.out.meter.summary(self.device.machine, &self.device.limits, self.out.clock, &self.state.position.q)
    }

    /// Control cycle in use, s.
    pub fn cycle_time(&self) -> f64 {
        self.out.cycle
    }

    fn execute(&mut self, command: &Command) -> Result<(), Box<ControlError>> {
        let location = &command.location;
        match &command.op {
            Op::Rapid(motion) => self.straight(motion, MoveKind::Rapid, location)?,
            Op::Linear(motion) => self.straight(motion, MoveKind::Feed, location)?,
            Op::Arc(arc) => self.arc(arc, location)?,
            Op::Dwell(dwell) => self.dwell(*dwell, location)?,
            Op::Feed(feed) => self.state.feed = Some(*feed),
            Op::Spindle(spindle) => self.spindle(*spindle, location),
            Op::Tool(ToolAction::Select(_)) | Op::Plane(_) | Op::Frame(_) | Op::Offset(Offset::Work { .. }) => {}
            Op::Tool(ToolAction::Change(name)) => self.tool_change(name, location)?,
            Op::Offset(Offset::ToolEdge { edge }) => self.set_edge(*edge != 0),
            Op::Tcp(tcp) => self.switch_tcp(*tcp, location)?,
            Op::PathMode(mode) => self.state.path_mode = *mode,
            Op::Coolant(coolant) => {
                self.announce(Event::Coolant { time: 0.0, block: self.next_block, coolant: *coolant });
            }
            Op::Message(text) => {
                self.announce(Event::Message { time: 0.0, block: self.next_block, text: text.clone() });
            }
            Op::Note(text) => self.announce(Event::Note { time: 0.0, block: self.next_block, text: text.clone() }),
            Op::Stop { optional } => {
                let block = self.action(location, BlockKind::Action, 0.0);
                self.out.chunk.events.push(Event::Stop { time: self.out.clock, block, optional: *optional });
            }
            Op::End => {
                let block = self.action(location, BlockKind::Action, 0.0);
                self.out.chunk.events.push(Event::End { time: self.out.clock, block });
                self.ended = true;
            }
        }
        Ok(())
    }

    /// An event at the start of the next block of motion, or at the next standstill.
    fn announce(&mut self, event: Event) {
        let before = self.path.first_block + self.path.blocks.len() as u64;
        self.out.waiting.push_back(Waiting { before, event });
    }

    fn tool_length(&self) -> f64 {
        self.state.tool.map_or(0.0, |i| self.tools[i].gauge_length)
    }

    fn active_length(&self) -> f64 {
        if self.state.edge_on { self.tool_length() } else { 0.0 }
    }

    fn straight(&mut self, motion: &Motion, kind: MoveKind, location: &Location) -> Result<(), Box<ControlError>> {
        let (mapping, path) = {
            let context = self.context(motion.machine_coordinates, location);
            (context.mapping, context.straight(motion, &self.state.position)?)
        };
        self.motion(motion, kind, location, mapping, path)
    }

    fn arc(&mut self, arc: &ArcMotion, location: &Location) -> Result<(), Box<ControlError>> {
        let (mapping, path) = {
            let context = self.context(arc.motion.machine_coordinates, location);
            (context.mapping, context.arc(arc, &self.state.position)?)
        };
        self.motion(&arc.motion, MoveKind::Feed, location, mapping, path)
    }

    fn context<'a>(&'a self, machine_coordinates: bool, location: &'a Location) -> Context<'a> {
        let tcp = self.state.tcp.on && !machine_coordinates;
        Context {
            machine: self.device.machine,
            rig: self.device.rig.as_ref(),
            mapping: Mapping { tcp_length: tcp.then(|| self.active_length()), tool_length: self.tool_length() },
            active_length: self.active_length(),
            orientation: self.state.tcp.interpolation,
            location,
        }
    }

    fn motion(
        &mut self,
        motion: &Motion,
        kind: MoveKind,
        location: &Location,
        mapping: Mapping,
        path: BlockPath,
    ) -> Result<(), Box<ControlError>> {
        if !path.end.is_finite() {
            let message = format!("the motion ends at joint positions that are not numbers: {:?}", path.end.0);
            let help = "check the programmed values and the machine description";
            return Err(Box::new(ControlError::at(location, "control-not-a-number", message, help)));
        }
        let (feed, feed_programmed) = self.feed(kind, &path, location)?;
        let index = self.next_block;
        self.next_block += 1;
        for letter in 0..AXIS_LETTERS.len() {
            let told = motion.end_base.get(letter);
            if told.is_some() || motion.tool_axis_base.is_some() && (3..6).contains(&letter) {
                self.state.position.base[letter] = told;
            }
        }
        if let Some((pose, reason)) = &path.unreachable {
            let event = Event::UnreachablePose { time: 0.0, block: index, pose: *pose, reason: reason.clone() };
            self.announce(event);
        }
        let from = self.state.position.q;
        self.state.position.q = path.end;
        if mapping != self.mapping {
            self.stop_run();
            self.mapping = mapping;
        }
        let corner = self.corner(motion.exact_stop);
        let block = PathBlock {
            index,
            length: path.length,
            shape: path.shape,
            s0: 0.0,
            kind,
            feed,
            feed_programmed,
            corner,
            tip_moves: path.tip_moves,
            file: location.file.clone(),
            line: location.line,
        };
        self.push_block(block, from);
        Ok(())
    }

    fn push_block(&mut self, block: PathBlock, from: JointValues) {
        if block.length <= 0.0 {
            // No way to go: a record without time, in its place in the order of blocks.
            self.stop_run();
            self.record(block.index, &block.file, block.line, BlockKind::Move(block.kind), self.out.clock);
            return;
        }
        let independent = self.device.machine.control.rapid_mode == RapidMode::IndependentJoints
            && block.kind != MoveKind::Feed
            && self.mapping.tcp_length.is_none();
        if independent {
            self.stop_run();
            self.independent(block, from);
            return;
        }
        let frame = self.device.frame(self.mapping);
        let block_copy = if self.path.is_empty() { None } else { Some(block.clone()) };
        if !self.path.push(&frame, block) {
            self.stop_run();
            if let Some(block) = block_copy {
                let frame = self.device.frame(self.mapping);
                self.path.push(&frame, block);
            }
        }
        if self.path.blocks.len() >= self.settings.look_ahead_blocks {
            self.commit_window();
        }
    }

    /// Speed along the path parameter, and the programmed feed in mm/s.
    fn feed(&self, kind: MoveKind, path: &BlockPath, location: &Location) -> Result<(f64, f64), Box<ControlError>> {
        let fail = |message: String, help: &str| Box::new(ControlError::at(location, "control-feed", message, help));
        let block_time = self.device.machine.control.block_time;
        let fastest = if block_time > 0.0 { path.length / block_time } else { f64::INFINITY };
        if kind != MoveKind::Feed {
            return Ok((fastest, 0.0));
        }
        let programmed = match self.state.feed {
            None => {
                return Err(fail("a motion in feed, but no feed is programmed".into(), "program F before this block"));
            }
            Some(Feed::PerTime(f)) => f,
            Some(Feed::PerRevolution(f)) => {
                let rpm = self.state.spindle.speed_rpm.unwrap_or(0.0);
                if self.state.spindle.direction == SpindleDirection::Off || rpm <= 0.0 {
                    let message = "feed per revolution, but the spindle does not turn".to_owned();
                    return Err(fail(message, "start the spindle or program the feed per minute (G94)"));
                }
                f * rpm / 60.0
            }
            Some(Feed::InverseTime(seconds)) => path.length / seconds,
        };
        if !(programmed > 0.0 && programmed.is_finite()) && path.length > 0.0 {
            let message = format!("the feed is {programmed} mm/s; it must be above zero");
            return Err(fail(message, "program a feed above zero"));
        }
        Ok((programmed.min(fastest), programmed))
    }

    fn corner(&self, exact_stop: bool) -> Option<Tolerance> {
        let PathMode::Continuous { tolerance, orientation_tolerance } = self.state.path_mode else { return None };
        if exact_stop {
            return None;
        }
        let control = &self.device.machine.control;
        let tip = tolerance.or(self.settings.default_tolerance).unwrap_or(control.default_tolerance);
        let angle = orientation_tolerance
            .or(self.settings.default_orientation_tolerance)
            .or(control.default_orientation_tolerance)
            .unwrap_or(Settings::FALLBACK_ORIENTATION_TOLERANCE);
        (tip > 0.0 && angle > 0.0).then_some(Tolerance { tip, angle })
    }

    /// Plans and emits all of the run; the machine then stands.
    fn stop_run(&mut self) {
        let frame = self.device.frame(self.mapping);
        self.path.finish(&frame);
        if !self.path.cells.is_empty() {
            let grid = self.out.grid();
            if let Some(s) = stretch::plan(&mut self.path, &frame, grid, self.v_start, true, 0) {
                let scope = scope(&self.device, &self.settings, self.mapping);
                self.out.stretch(&scope, &self.path, &s, [self.v_start > 0.0, false]);
            }
            self.ready = true;
        }
        let number = self.path.first_block + self.path.blocks.len() as u64;
        self.out.length_before += self.path.end();
        self.path = Path::starting_with(number);
        self.v_start = 0.0;
        self.out.release(number, self.out.clock);
    }

    /// Plans the known part of a long run and emits what the unknown part cannot change.
    fn commit_window(&mut self) {
        let frame = self.device.frame(self.mapping);
        let keep = self.path.cells.len() / 4;
        let grid = self.out.grid();
        let Some(s) = stretch::plan(&mut self.path, &frame, grid, self.v_start, false, keep) else { return };
        let scope = scope(&self.device, &self.settings, self.mapping);
        self.out.stretch(&scope, &self.path, &s, [self.v_start > 0.0, true]);
        self.path.drop_before(s.s_end, s.cells);
        self.v_start = s.v_end;
        self.ready = true;
    }

    /// A rapid motion with every joint at its own speed.
    fn independent(&mut self, mut block: PathBlock, from: JointValues) {
        let to = block.shape.jet(block.length).0[0];
        let l = &self.device.limits;
        let mut joints = Vec::new();
        let mut duration = 0.0_f64;
        for i in 0..l.count {
            let distance = (to[i] - from[i]).abs();
            if distance > 0.0 {
                let rates = Rates { acceleration: l.acceleration[i], jerk: l.jerk[i] };
                let fastest = l.rapid[i].min(crate::limits::UNLIMITED_SPEED);
                let peak = peak_speed(0.0, 0.0, distance, fastest, rates, rates);
                let mut law = Law::default();
                law.push_move([0.0, distance], [0.0, peak, 0.0], rates, rates);
                duration = duration.max(law.duration);
                joints.push((i, (to[i] - from[i]).signum(), law));
            }
        }
        let length = block.length;
        block.shape = Shape::Timed(Box::new(Timed { from, joints }));
        block.length = duration;
        let number = self.path.first_block;
        self.path = Path::single(number, block);
        let frame = self.device.frame(self.mapping);
        let law = Law::uniform(0.0, duration);
        let samples = stretch::measure(&self.path, &frame, self.out.grid(), &law);
        let s = Stretch { law, cells: 0, s_end: duration, v_end: 0.0, samples };
        let scope = scope(&self.device, &self.settings, self.mapping);
        self.out.stretch(&scope, &self.path, &s, [false, false]);
        if let Some(record) = self.out.chunk.blocks.last_mut() {
            record.length = length;
        }
        self.out.length_before += length;
        self.path = Path::starting_with(number + 1);
        self.ready = true;
    }

    /// A standstill of some time with its block record.
    fn action(&mut self, location: &Location, kind: BlockKind, duration: f64) -> u32 {
        self.stop_run();
        let index = self.next_block;
        self.next_block += 1;
        let scope = scope(&self.device, &self.settings, self.mapping);
        let start = self.out.clock;
        self.out.stand(&scope, &self.state.position.q, index, duration);
        self.record(index, &location.file, location.line, kind, start);
        self.out.meter.bound_s += duration;
        self.ready = true;
        index
    }

    fn record(&mut self, index: u32, file: &Arc<str>, line: u32, kind: BlockKind, start_time: f64) {
        self.out.meter.summary.blocks += 1;
        self.out.chunk.blocks.push(BlockRecord {
            index,
            file: file.clone(),
            line,
            start_time,
            end_time: self.out.clock,
            length: 0.0,
            feed: 0.0,
            kind,
        });
    }

    fn dwell(&mut self, dwell: Dwell, location: &Location) -> Result<(), Box<ControlError>> {
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
        self.stop_run();
        let time = self.out.clock;
        self.out.meter.summary.dwell_s += duration;
        let block = self.action(location, BlockKind::Dwell, duration);
        self.out.chunk.events.push(Event::Dwell { time, block, duration });
        Ok(())
    }

    fn spindle(&mut self, spindle: Spindle, location: &Location) {
        let before = self.state.spindle;
        let speed_rpm = spindle.speed_rpm.or(before.speed_rpm);
        self.state.spindle = Spindle { speed_rpm, ..spindle };
        let turning = spindle.direction != SpindleDirection::Off;
        let speed = if turning { speed_rpm.unwrap_or(0.0) } else { 0.0 };
        let starts = spindle.direction != before.direction;
        let wait = self.device.machine.control.spindle_start_time;
        let waits = starts && self.settings.spindle_waits && wait > 0.0;
        let event = |time, block| Event::Spindle { time, block, direction: spindle.direction, speed_rpm: speed };
        let block = if waits {
            self.out.meter.summary.dwell_s += wait;
            let block = self.action(location, BlockKind::Action, wait);
            self.out.chunk.events.push(event(self.out.clock, block));
            block
        } else {
            self.announce(event(0.0, self.next_block));
            self.next_block
        };
        let tool = self.state.tool.and_then(|i| self.tools[i].max_speed_rpm);
        for limit in [self.device.machine.spindle.max_speed_rpm, tool].into_iter().flatten() {
            if speed > limit {
                let kind = LimitKind::SpindleSpeed;
                self.announce(Event::Limit { time: 0.0, block, joint: None, value: speed, limit, kind });
            }
        }
    }

    /// What the base coordinates X, Y, Z mean has changed: what the program said about them is void.
    fn forget_linear(&mut self) {
        self.state.position.base[..3].fill(None);
    }

    fn set_edge(&mut self, on: bool) {
        if on != self.state.edge_on {
            self.state.edge_on = on;
            self.forget_linear();
        }
    }

    fn switch_tcp(&mut self, tcp: Tcp, location: &Location) -> Result<(), Box<ControlError>> {
        if tcp.on && self.device.rig.is_none() {
            let message = format!(
                "tool center point control on machine {}, which has not exactly three free, independent linear joints",
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

    fn tool_change(&mut self, name: &ToolName, location: &Location) -> Result<(), Box<ControlError>> {
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
        self.stop_run();
        self.visit_change_position(location);
        let duration = self.device.machine.control.tool_change_time.max(0.0);
        self.out.meter.summary.tool_change_s += duration;
        let block = self.action(location, BlockKind::ToolChange, duration);
        self.state.tool = tool.flatten();
        self.mapping.tool_length = self.tool_length();
        self.state.edge_on |= self.settings.length_active_after_change;
        self.forget_linear();
        self.out.chunk.events.push(Event::ToolChange { time: self.out.clock, block, tool: self.state.tool });
        Ok(())
    }

    /// Drives to the tool change position of the machine, if it has one: first the linear joint along the spindle, then
    /// the others together.
    fn visit_change_position(&mut self, location: &Location) {
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
            if (to - from).max_abs() <= 1e-9 {
                continue;
            }
            self.mapping = Mapping { tcp_length: None, tool_length: self.tool_length() };
            let context = Context {
                machine,
                rig: None,
                mapping: self.mapping,
                active_length: 0.0,
                orientation: OrientationInterpolation::Axes,
                location,
            };
            let path = context.between(from, to);
            let index = self.next_block;
            self.next_block += 1;
            self.state.position.q = to;
            let block = PathBlock {
                index,
                shape: path.shape,
                length: path.length,
                s0: 0.0,
                kind: MoveKind::Handling,
                feed: f64::INFINITY,
                feed_programmed: 0.0,
                corner: None,
                tip_moves: path.tip_moves,
                file: location.file.clone(),
                line: location.line,
            };
            self.push_block(block, from);
            self.stop_run();
        }
    }

    /// The sample after the end: the machine stands.
    fn last_sample(&mut self) {
        let time = (self.out.clock / self.out.cycle).ceil() * self.out.cycle;
        let scope = scope(&self.device, &self.settings, self.mapping);
        let block = self.next_block.saturating_sub(1);
        self.out.still_sample(&scope, &self.state.position.q, block, time);
    }
}

fn scope<'a>(device: &'a Device<'_>, settings: &'a Settings, mapping: Mapping) -> Scope<'a> {
    let frame = device.frame(mapping);
    Scope { machine: device.machine, settings, kinematics: frame.kinematics }
}

fn check_settings(settings: &Settings) -> Result<(), Box<ControlError>> {
    let named = [
        ("default_tolerance", settings.default_tolerance.unwrap_or(1.0), true),
        ("default_orientation_tolerance", settings.default_orientation_tolerance.unwrap_or(1.0), true),
        ("piece_tolerance", settings.piece_tolerance, false),
        ("piece_length", settings.piece_length, false),
        ("piece_angle", settings.piece_angle, false),
        ("sample_time", settings.sample_time.unwrap_or(1.0), false),
    ];
    for (name, value, zero_allowed) in named {
        if !(value.is_finite() && (value > 0.0 || zero_allowed && value == 0.0)) {
            return Err(Box::new(ControlError {
                code: "control-settings",
                message: format!("the setting {name} is {value}"),
                location: None,
                help: Some("give a number above zero".to_owned()),
            }));
        }
    }
    Ok(())
}

fn check_cycle(machine: &Machine) -> Result<(), Box<ControlError>> {
    let cycle = machine.control.cycle_time;
    if cycle > 0.0 && cycle.is_finite() {
        return Ok(());
    }
    Err(Box::new(ControlError {
        code: "control-limits",
        message: format!("the control cycle of machine {} is {cycle} s", machine.name),
        location: None,
        help: Some("give a cycle above zero".to_owned()),
    }))
}

fn check_limits(machine: &Machine) -> Result<(), Box<ControlError>> {
    for joint in &machine.joints {
        let named = [
            ("max_velocity", joint.max_velocity),
            ("max_acceleration", joint.max_acceleration),
            ("max_jerk", joint.max_jerk),
            ("rapid_velocity", joint.rapid_velocity),
        ];
        for (name, value) in named {
            if value.is_some_and(|v| v.is_nan() || v <= 0.0) {
                return Err(Box::new(ControlError {
                    code: "control-limits",
                    message: format!("joint {} has {name} = {:?}", joint.name, value.unwrap_or(f64::NAN)),
                    location: None,
                    help: Some(
                        "give a number above zero, or leave the key out where the limit is not known".to_owned(),
                    ),
                }));
            }
        }
    }
    Ok(())
}
