//! Executes canonical commands: state of the control, runs between stops, standstill.

mod actions;
mod bounds;
mod check;
mod counted;
mod numbers;
mod pace;
mod probe;
mod runs;
mod spindle;

use std::{sync::Arc, time::Instant};

use proveout_machine::{JointValues, Machine};
use proveout_nc::{
    AXIS_LETTERS, ArcMotion, Command, Feed, FeedCounts, Location, Motion, Offset, Op, OrientationInterpolation,
    PathMode, Spindle, SpindleDirection, Tcp, ToolAction,
};
use proveout_tool::Tool;

use self::pace::Pace;
pub use self::probe::ProbeWay;
use crate::{
    emit::{Emitter, PendingEntry, QueuedEntry, Scope},
    error::{ControlError, RunError},
    idle_tools::IdleTools,
    limits::JointLimits,
    mapping::{ActiveKinematics, Mapping},
    motion::{BlockPath, Context, Leaves, Position, ProgrammedMotion},
    output::{BlockKind, Chunk, Event, MoveKind},
    path::{PathBlock, PathContext, RunPath, Tolerance},
    retime::{LawEntry, Stages},
    rtcp::Rig,
    servo::stage::ServoStage,
    settings::{Dynamics, Settings},
    stretch::Reserve,
    summary::Summary,
};

/// Machine and what is derived from it once.
struct Device<'m> {
    machine: &'m Machine,
    rig: Option<Rig>,
    limits: JointLimits,
    /// Base coordinates have the same zero with tool center point control and without.
    common_zero: bool,
}

impl Device<'_> {
    fn frame(&self, mapping: Mapping) -> PathContext<'_> {
        PathContext {
            kinematics: ActiveKinematics { machine: self.machine, rig: self.rig.as_ref(), mapping },
            limits: &self.limits,
        }
    }
}

/// What the program has set.
struct ProgramState {
    position: Position,
    tool: Option<usize>,
    edge_on: bool,
    /// What the program adds to the length of the tool: by so much the control takes it for longer than it
    /// is, mm.
    delta_length: f64,
    tcp: Tcp,
    /// Point that stays while rotary axes turn under tool center point control: so much ahead of the tip, mm.
    turn_center: f64,
    path_mode: PathMode,
    feed: Option<Feed>,
    /// What the feed counts where rotary axes turn; none: the way of the tip, else the turn.
    feed_counts: Option<FeedCounts>,
    /// What the program asked of the spindle, and the sense in which it turns: a tapping cycle has its own.
    spindle: Spindle,
    turning: SpindleDirection,
    /// The motion before was coupled to the spindle.
    threading: bool,
    /// Factor of the programmed feed.
    feed_override: f64,
    /// When the spindle is at its speed, or at rest, s.
    spindle_ready: f64,
    /// Rotation and translation from work to base coordinates.
    frame: Option<([[f64; 3]; 3], [f64; 3])>,
    /// Whether the last motion of X, Y or Z in work coordinates was under tool center point control.
    in_table: Option<bool>,
}

/// How the machine moves at the begin of the path's first cell.
#[derive(Default)]
struct Begin {
    /// Speed of the first law, and the tempo.
    speed: f64,
    entry: LawEntry,
    /// How it comes to rest from there; none where it is at rest.
    reserve: Option<Reserve>,
    /// It is at rest there although the path goes on.
    halted: bool,
}

/// The control: takes canonical commands and gives the motion of the machine in chunks.
///
/// ```text
/// while let Some(chunk) = controller.next_chunk()? { ... }
/// let summary = controller.summary();
/// ```
///
/// ```
/// use proveout_controller::{Controller, Settings};
/// use proveout_machine::Machine;
/// use proveout_nc::Program;
///
/// let machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
/// // From its home at -365 mm X runs 40 mm at 100 mm/s.
/// let text = "G21 G90\nG1 X-325. F6000.\nM30\n";
/// let program = Program::from_text("part.nc", text, &proveout_nc::Settings::default())?;
/// let mut controller = Controller::new(program, &machine, &[], Settings::default())?;
/// while controller.next_chunk()?.is_some() {}
/// // At a jerk of 100 m/s3 speeding up and braking add 2 sqrt(v / j) to the time at the feed.
/// let time = 40.0 / 100.0 + 2.0 * (100.0_f64 / 100_000.0).sqrt(); // s
/// assert!((controller.summary().cutting_s - time).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Controller<'m, I> {
    commands: I,
    tools: &'m [Tool],
    device: Device<'m>,
    settings: Settings,
    state: ProgramState,
    path: RunPath,
    mapping: Mapping,
    begin: Begin,
    /// Number of blocks at which the known part of the run is planned next.
    window: usize,
    /// Time of that part at its feeds, and the one at which it is planned next, s.
    window_time: (f64, f64),
    /// Room of the searches for the tempo.
    stages: Stages,
    out: Emitter,
    /// The drives, where they are simulated.
    servo: Option<Box<ServoStage<'m>>>,
    servo_wall: f64,
    standing: IdleTools,
    next_block: u32,
    ready: bool,
    ended: bool,
    /// Where the machine stopped when the program ended in the middle of a motion: nothing that was
    /// under way is run any more.
    cut_short: Option<JointValues>,
    finished: bool,
    /// A probing motion that waits for its answer.
    asked: Option<Box<ProbeWay>>,
}

impl<'m, E, I> Controller<'m, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    /// A control with all joints at home, no tool, and the path mode "continuous".
    ///
    /// # Errors
    /// [`ControlError`] when a setting or a limit of the machine is not a number above zero, or when the axis
    /// dynamics are asked for and a drive is not described, is not stable, or moves an unknown mass.
    pub fn new(
        commands: I,
        machine: &'m Machine,
        tools: &'m [Tool],
        settings: Settings,
    ) -> Result<Self, Box<ControlError>> {
        check::check_settings(&settings)?;
        check::check_limits(machine)?;
        check::check_cycle(machine)?;
        let cycle = settings.sample_time.unwrap_or(machine.control.cycle_time);
        let servo = match settings.dynamics {
            Dynamics::Servo => Some(Box::new(ServoStage::new(machine, tools, &settings, cycle)?)),
            Dynamics::Ideal | Dynamics::Planned => None,
        };
        let home = machine.home();
        let mapping = Mapping { tcp_length: None, tool_length: 0.0, edge_length: 0.0 };
        let start_tool = settings.start_tool.map(|number| check::start_tool(tools, number)).transpose()?;
        let mut control = Self {
            commands,
            tools,
            device: Device {
                machine,
                rig: Rig::new(machine),
                limits: JointLimits::new(machine),
                common_zero: machine.program_zero().is_some(),
            },
            state: ProgramState {
                position: Position { q: home, base: [None; AXIS_LETTERS.len()], told: None },
                tool: None,
                edge_on: false,
                delta_length: 0.0,
                tcp: Tcp { on: false, interpolation: OrientationInterpolation::Axes },
                turn_center: 0.0,
                path_mode: PathMode::Continuous { tolerance: None, orientation_tolerance: None },
                feed: None,
                feed_counts: None,
                spindle: Spindle { direction: SpindleDirection::Off, speed_rpm: None },
                turning: SpindleDirection::Off,
                threading: false,
                feed_override: 1.0,
                spindle_ready: 0.0,
                frame: None,
                in_table: None,
            },
            window: settings.look_ahead_blocks,
            window_time: (0.0, bounds::WINDOW_SAMPLES * cycle),
            stages: Stages::default(),
            settings,
            path: RunPath::default(),
            mapping,
            begin: Begin::default(),
            out: Emitter::new(cycle, &home, JointLimits::new(machine)),
            servo,
            servo_wall: 0.0,
            standing: IdleTools::at(home),
            next_block: 0,
            ready: false,
            ended: false,
            cut_short: None,
            finished: false,
            asked: None,
        };
        if start_tool.is_some() {
            control.state.tool = start_tool;
            control.state.edge_on = control.settings.length_active_after_change;
            control.mapping = control.mapping_with(None);
            control.out.chunk.events.push(Event::ToolChange { time: 0.0, block: 0, tool: start_tool });
        }
        Ok(control)
    }

    /// The next stretch of the run; none after the end.
    ///
    /// # Errors
    /// What the source of commands reports, and commands that the control refuses. After an error there is no
    /// further chunk.
    pub fn next_chunk(&mut self) -> Result<Option<Chunk>, RunError<E>> {
        let Some(mut chunk) = self.next_planned()? else { return Ok(None) };
        if let Some(servo) = &mut self.servo {
            let begin = Instant::now();
            let followed = servo.follow(chunk, self.finished);
            self.servo_wall += begin.elapsed().as_secs_f64();
            chunk = followed.map_err(|e| {
                self.finished = true;
                RunError::Control(e)
            })?;
        }
        self.standing.complete(self.device.machine, self.tools, &mut chunk, self.finished);
        Ok(Some(chunk))
    }

    /// The next stretch of the plan.
    fn next_planned(&mut self) -> Result<Option<Chunk>, RunError<E>> {
        while !self.finished {
            if self.ended {
                self.stop_run();
                let frame = self.device.frame(self.mapping);
                self.out.meter.tube.stand(&frame, 0.0);
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
        let mut summary =
            self.out.meter.summary(self.device.machine, &self.device.limits, self.out.clock, &self.state.position.q);
        if let Some(servo) = &self.servo {
            servo.complete(&mut summary);
        }
        summary
    }

    /// Wall time spent on the drives so far, s.
    pub fn servo_wall_s(&self) -> f64 {
        self.servo_wall
    }

    /// Control cycle in use, s.
    pub fn cycle_time(&self) -> f64 {
        self.out.cycle
    }

    fn execute(&mut self, command: &Command) -> Result<(), Box<ControlError>> {
        let location = &command.location;
        numbers::check_numbers(command)?;
        match &command.op {
            Op::Rapid(motion) => self.straight(motion, Pace::Rapid, location)?,
            Op::Linear(motion) => self.straight(motion, Pace::Feed, location)?,
            Op::Arc(arc) => self.arc(arc, location)?,
            Op::Dwell(dwell) => self.dwell(*dwell, location)?,
            Op::Spline(spline) => self.spline(spline, location)?,
            Op::Probe(probe) => self.probe(probe, location)?,
            Op::Thread(thread) => self.thread(thread, location)?,
            Op::Retract(retract) => self.retract(*retract, location)?,
            Op::Override(change) => self.feed_override(*change, location)?,
            Op::CutterComp(_) => actions::special(&command.op, location)?,
            Op::Feed(feed) => self.state.feed = Some(*feed),
            Op::FeedCounts(counts) => self.state.feed_counts = Some(*counts),
            Op::Spindle(spindle) => self.spindle(*spindle),
            Op::Tool(ToolAction::Select(name)) => self.select(name, location),
            Op::Frame(frame) => self.state.frame = Some((frame.rotation, frame.translation)),
            Op::Plane(_) | Op::Offset(Offset::Work { .. }) => {}
            Op::Tool(ToolAction::Change(name)) => self.tool_change(name, location)?,
            Op::Offset(Offset::ToolEdge { edge }) => self.set_edge(*edge != 0),
            // The radius counts in the reader, whose path is that of the tool center.
            Op::Offset(Offset::ToolDelta { length, .. }) => self.set_delta_length(*length),
            Op::Offset(Offset::TurnCenter { ahead }) => self.set_turn_center(*ahead),
            Op::Tcp(tcp) => self.switch_tcp(*tcp, location)?,
            Op::PathMode(mode) => self.state.path_mode = *mode,
            Op::Coolant(coolant) => {
                self.announce(Event::Coolant { time: 0.0, block: self.next_block, coolant: *coolant });
            }
            Op::Message(text) => {
                self.announce(Event::Message { time: 0.0, block: self.next_block, text: text.clone() });
            }
            Op::Overcut(overcut) => self.announce(Event::Overcut {
                time: 0.0,
                block: self.next_block,
                location: location.clone(),
                overcut: Box::new(overcut.clone()),
            }),
            Op::Note(text) => self.announce(Event::Note { time: 0.0, block: self.next_block, text: text.clone() }),
            Op::Stop { optional } => {
                let block = self.action(location, BlockKind::Action, 0.0);
                if self.cut_short.is_some() {
                    return Ok(());
                }
                self.out.chunk.events.push(Event::Stop { time: self.out.clock, block, optional: *optional });
            }
            Op::End => {
                let block = self.action(location, BlockKind::Action, 0.0);
                if self.cut_short.is_some() {
                    return Ok(());
                }
                self.out.chunk.events.push(Event::End { time: self.out.clock, block });
                self.ended = true;
            }
        }
        Ok(())
    }

    /// An event at the start of the next block of motion, or at the next standstill.
    fn announce(&mut self, event: Event) {
        let before = self.path.first_block + self.path.blocks.len() as u64;
        self.out.waiting.push_back(QueuedEntry { before, what: PendingEntry::Event(event) });
    }

    fn tool_length(&self) -> f64 {
        self.state.tool.map_or(0.0, |i| self.tools[i].gauge_length)
    }

    fn mapping_with(&self, tcp_length: Option<f64>) -> Mapping {
        Mapping { tcp_length, tool_length: self.tool_length(), edge_length: self.reach().min(self.tool_length()) }
    }

    fn active_length(&self) -> f64 {
        if self.state.edge_on { self.tool_length() + self.state.delta_length } else { 0.0 }
    }

    fn straight(&mut self, motion: &Motion, pace: Pace, location: &Location) -> Result<(), Box<ControlError>> {
        let completed = self.state.frame.and_then(|frame| {
            let context = self.context(motion.machine_coordinates, location);
            context.completed(motion, frame, &self.state.position)
        });
        let motion = completed.as_ref().unwrap_or(motion);
        let (mapping, path) = {
            let mut context = self.context(motion.machine_coordinates, location);
            context.rapid = pace == Pace::Rapid;
            (context.mapping, context.straight(motion, &self.state.position)?)
        };
        self.motion(motion, pace, location, mapping, path)
    }

    fn arc(&mut self, arc: &ArcMotion, location: &Location) -> Result<(), Box<ControlError>> {
        let (mapping, path) = {
            let context = self.context(arc.motion.machine_coordinates, location);
            (context.mapping, context.arc(arc, &self.state.position)?)
        };
        self.motion(&arc.motion, Pace::Feed, location, mapping, path)
    }

    fn context<'a>(&'a self, machine_coordinates: bool, location: &'a Location) -> Context<'a> {
        let tcp = self.state.tcp.on && !machine_coordinates;
        Context {
            machine: self.device.machine,
            rig: self.device.rig.as_ref(),
            mapping: self.mapping_with(tcp.then(|| self.active_length() + self.state.turn_center)),
            active_length: match machine_coordinates && !self.settings.length_in_machine_coordinates {
                true => 0.0,
                false => self.active_length(),
            },
            orientation: self.state.tcp.interpolation,
            pole_cone: self.settings.pole_cone.unwrap_or(self.device.machine.control.pole_cone),
            rapid: false,
            location,
        }
    }

    fn motion(
        &mut self,
        motion: &Motion,
        pace: Pace,
        location: &Location,
        mapping: Mapping,
        path: BlockPath,
    ) -> Result<(), Box<ControlError>> {
        self.check_coordinates(motion, mapping, location)?;
        // The base coordinates change only once the motion is accepted.
        self.move_along(pace, location, mapping, path, motion.exact_stop)?;
        // Positions of axes say nothing about the coordinates of the tip on the table, or without the tool
        // length.
        let of_axes = motion.machine_coordinates && (self.state.tcp.on || !self.settings.length_in_machine_coordinates);
        for letter in 0..AXIS_LETTERS.len() {
            let told = motion.end_base.get(letter);
            if told.is_some() || motion.tool_axis_base.is_some() && (3..6).contains(&letter) {
                self.state.position.base[letter] = told.filter(|_| letter >= 3 || !of_axes);
            }
        }
        Ok(())
    }

    /// Where X, Y and Z of a machine do not move the tool along x, y and z of its table, a work offset cannot
    /// mean the same point with tool center point control and without; a program that moves them in both is
    /// refused.
    fn check_coordinates(
        &mut self,
        motion: &Motion,
        mapping: Mapping,
        location: &Location,
    ) -> Result<(), Box<ControlError>> {
        if self.device.common_zero || motion.machine_coordinates || motion.programmed & 0b111 == 0 {
            return Ok(());
        }
        let in_table = mapping.tcp_length.is_some();
        if self.state.in_table.replace(in_table).is_none_or(|before| before == in_table) {
            return Ok(());
        }
        let message = format!(
            "X, Y and Z of machine {} do not move the tool along x, y and z of its table, so that a work offset is another point \
             with tool center point control than without; this program moves them in both",
            self.device.machine.name
        );
        let help = "move X, Y and Z under tool center point control alone, and elsewhere in machine coordinates";
        Err(Box::new(ControlError::at(location, "control-coordinates", message, help)))
    }

    fn move_along(
        &mut self,
        pace: Pace,
        location: &Location,
        mapping: Mapping,
        path: BlockPath,
        exact_stop: bool,
    ) -> Result<(), Box<ControlError>> {
        if !path.end.is_finite() {
            let message = format!("the motion ends at joint positions that are not numbers: {:?}", path.end.0);
            let help = "check the programmed values and the machine description";
            return Err(Box::new(ControlError::at(location, "control-not-a-number", message, help)));
        }
        let (feed, feed_programmed) = self.feed(pace, &path, mapping, location)?;
        if self.ends_before(&path, pace, feed, location) {
            return Ok(());
        }
        let kind = pace.kind();
        if !matches!(pace, Pace::Thread { .. }) {
            self.end_thread();
        }
        if kind == MoveKind::Feed {
            self.await_spindle(location);
        }
        let index = self.next_block;
        self.next_block += 1;
        if let Some((pose, reason)) = &path.unreachable {
            let event = Event::UnreachablePose { time: 0.0, block: index, pose: *pose, reason: reason.clone() };
            self.announce(event);
        }
        if let Pace::Probe { contact } = pace {
            let spindle_turns = self.state.spindle.direction != SpindleDirection::Off;
            self.announce(Event::Probe { time: 0.0, block: index, contact, spindle_turns });
        }
        if let Some(text) = &path.other_position {
            self.announce(Event::Note { time: 0.0, block: index, text: text.clone() });
        }
        if let Some(Leaves { angle, in_cone, reason }) = path.leaves {
            let at_flank = angle * self.reach();
            let event = Event::LeavesCircle { time: 0.0, block: index, angle, at_flank, in_cone, reason };
            self.announce(event);
        }
        let from = self.state.position.q;
        self.state.position.q = path.end;
        self.state.position.told = path.programmed.as_ref().and_then(|p| p.end(self.device.machine));
        if mapping != self.mapping {
            self.stop_run();
            let frame = self.device.frame(self.mapping);
            self.out.meter.tube.remap(&frame);
            self.mapping = mapping;
        }
        let stops = exact_stop || matches!(pace, Pace::Probe { .. } | Pace::Thread { stroke: true, .. });
        let programmed: Option<Arc<ProgrammedMotion>> = path.programmed.map(Arc::from);
        let parts = path.parts.len();
        let mut last = index;
        for (k, part) in path.parts.into_iter().enumerate() {
            if k > 0 {
                last = self.next_block;
                self.next_block += 1;
            }
            // A turn in a pole is made by the control itself, with a stop on either side.
            if part.turn {
                self.stop_run();
            }
            let corner = self.corner(stops || part.turn || k + 1 < parts);
            // What the program allows, also where this control stops.
            let whole = k + 1 == parts;
            let loose = self.corner(stops && whole);
            let block = PathBlock {
                index: last,
                length: part.length,
                shape: part.shape,
                chord: None,
                s0: 0.0,
                kind: if part.turn { MoveKind::Handling } else { kind },
                feed: if part.turn { f64::INFINITY } else { feed },
                feed_programmed: if part.turn { 0.0 } else { feed_programmed },
                coupled: !part.turn && matches!(pace, Pace::Thread { .. }),
                corner,
                loose,
                stands: whole && (stops || self.state.path_mode == PathMode::ExactStop),
                tip_moves: part.tip_moves,
                told: programmed.clone().map(|way| (way, part.t)),
                file: location.file.clone(),
                line: location.line,
            };
            self.push_block(block, from);
            if part.turn {
                self.stop_run();
            }
        }
        Ok(())
    }

    /// Speed along the path parameter, and the programmed feed in mm/s.
    fn feed(
        &self,
        pace: Pace,
        path: &BlockPath,
        mapping: Mapping,
        location: &Location,
    ) -> Result<(f64, f64), Box<ControlError>> {
        let fail = |message: String, help: &str| Box::new(ControlError::at(location, "control-feed", message, help));
        let block_time = self.device.machine.control.block_time;
        let fastest = if block_time > 0.0 { path.length / block_time } else { f64::INFINITY };
        if pace == Pace::Rapid {
            return Ok((fastest, 0.0));
        }
        if let Pace::Thread { feed, .. } = pace {
            return Ok((feed, feed));
        }
        let programmed = match self.state.feed {
            None => {
                return Err(fail("a motion in feed, but no feed is programmed".into(), "program F before this block"));
            }
            Some(Feed::PerTime(f)) => f * self.feed_share(path, mapping),
            Some(Feed::PerRevolution(f)) => {
                let rpm = self.state.spindle.speed_rpm.unwrap_or(0.0);
                if self.state.spindle.direction == SpindleDirection::Off || rpm <= 0.0 {
                    let message = "feed per revolution, but the spindle does not turn".to_owned();
                    return Err(fail(message, "start the spindle or program the feed per minute (G94)"));
                }
                f * rpm / 60.0 * self.feed_share(path, mapping)
            }
            Some(Feed::InverseTime(seconds)) => path.length / seconds,
        } * self.state.feed_override;
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
            .unwrap_or_else(|| Settings::orientation_tolerance(tip, self.reach()));
        (tip > 0.0 && angle > 0.0).then_some(Tolerance { tip, angle })
    }

    /// Way from the tip to the end of the cutting edges of the tool in the spindle, mm.
    fn reach(&self) -> f64 {
        self.state.tool.map_or(0.0, |i| reach(&self.tools[i]))
    }
}

/// Distance from the tip to the end of the cutting edges, mm; to the gauge line if the tool gives
/// no flute length.
fn reach(tool: &Tool) -> f64 {
    if tool.flute_length > 0.0 { tool.flute_length } else { tool.gauge_length }
}

fn scope<'a>(device: &'a Device<'_>, settings: &'a Settings, mapping: Mapping) -> Scope<'a> {
    let frame = device.frame(mapping);
    Scope { machine: device.machine, settings, kinematics: frame.kinematics }
}
