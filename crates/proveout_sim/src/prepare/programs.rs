//! Programs that are made: a pass over the blade of the scene, and re-scheduled programs. What runs is their
//! text.

use std::path::Path;

use proveout_controller::{Reprogrammed, Reprogramming};
use proveout_geom::{Pose, ToolPose, Vector};
use proveout_input::{InputError, Step::Key};
use proveout_machine::{JointValues, Machine};
use proveout_nc::{
    AXIS_LETTERS, AxisValues, Command, Coolant, Dialect, Feed, Location, Motion, Offset, Op, OrientationInterpolation,
    PathMode, Program, Settings, Spindle, SpindleDirection, Tcp, ToolAction, ToolName, WorkOffset,
    post::{PostSettings, post_for},
};
use proveout_tool::{Profile, Tool, ToolId, ToolLibrary};

use crate::{
    prepare::{
        error::SimError,
        machine_data::with_machine,
        motion_only::{MotionCase, Source},
        part_on_table::PartOnTable,
        reader_settings::settings_of_made,
    },
    scene::{MethodFile, ProgramFile, RescheduleFile, Scene},
};

/// The tip of a shorter motion is at rest, mm.
const AT_REST_MM: f64 = 1e-9;

/// Decimals of a made program: ends to 0.1 micrometers, tool vectors to 1e-8, which is 2 nm at a tip 200 mm
/// away. Positions of the axes without tool center point control to 1e-5: half of that in a head's angle
/// moves a tip 300 mm away by 26 nm.
fn format(commands: &[Command]) -> PostSettings {
    let controlled = commands.iter().any(|c| matches!(&c.op, Op::Tcp(tcp) if tcp.on));
    let turns = |m: &Motion| m.programmed >> 3 & 0b111 != 0 && m.programmed & 0b111 != 0;
    let joints = !controlled && commands.iter().any(|c| matches!(&c.op, Op::Linear(m) if turns(m)));
    let usual = PostSettings { length_decimals: 4, vector_decimals: 8, feed_decimals: 4, ..PostSettings::default() };
    if joints { PostSettings { length_decimals: 5, angle_decimals: 5, ..usual } } else { usual }
}

/// The cutting end of a tool.
pub(crate) fn tip(tool: &Tool) -> Option<&Profile> {
    tool.cutting().next().map(|body| &body.profile)
}

/// Text of commands in a language.
///
/// # Errors
/// A command that the language cannot say.
pub fn text(commands: &[Command], dialect: Dialect, settings: &Settings) -> Result<String, SimError> {
    let mut out = Vec::new();
    let format = PostSettings { work_offsets: settings.work_offsets.clone(), ..format(commands) };
    let mut post = post_for(dialect, format, &mut out)?;
    let commands = if dialect == Dialect::Apt { tip_feeds(commands) } else { commands.to_vec() };
    for command in &commands {
        post.write(command)?;
    }
    post.finish()?;
    drop(post);
    Ok(String::from_utf8_lossy(&out).into_owned())
}

/// CL data know no inverse time: the same times as feeds of the tip.
fn tip_feeds(commands: &[Command]) -> Vec<Command> {
    let mut at: Option<[f64; 3]> = None;
    let mut pending: Option<f64> = None;
    let mut out = Vec::with_capacity(commands.len());
    for command in commands {
        match &command.op {
            Op::Feed(Feed::InverseTime(seconds)) => pending = Some(*seconds),
            Op::Rapid(motion) | Op::Linear(motion) => {
                let end = motion.end_base.xyz();
                if let (Op::Linear(_), Some(seconds), Some(a), Some(b)) = (&command.op, pending, at, end) {
                    let length = (0..3).map(|i| (b[i] - a[i]).powi(2)).sum::<f64>().sqrt();
                    // A tip at rest has no feed of its own; the one before stays.
                    if length > AT_REST_MM {
                        let op = Op::Feed(Feed::PerTime(length / seconds));
                        out.push(Command { location: command.location.clone(), op });
                    }
                }
                at = end.or(at);
                // Positions of rotary axes alone belong to a machine, which CL data do not know.
                if end.is_some() {
                    out.push(command.clone());
                }
            }
            _ => out.push(command.clone()),
        }
    }
    out
}

/// The program of a helical pass over the blade of the scene, as canonical commands in the workpiece frame.
///
/// # Errors
/// The scene has no blade or no plan, the tool is no ball end mill, or the pass does not fit the blade.
pub fn helix(scene: &Scene, machine: &Machine, tools: &ToolLibrary) -> Result<Vec<Command>, SimError> {
    let file = |message: String, help: &str| scene.error_at(&[Key("plan"), Key("helix")], message, help);
    let blade = scene.file.part.as_ref().and_then(|p| p.blade);
    let (Some(blade), Some(plan)) = (blade, &scene.file.plan) else {
        return Err(file("the scene has no blade or no [plan.helix]".into(), "describe both in the scene").into());
    };
    let Some(plan) = &plan.helix else {
        return Err(file("the scene has no [plan.helix]".into(), "describe the pass in the scene").into());
    };
    let of_tool =
        |message: String, help: &str| scene.error_at(&[Key("plan"), Key("helix"), Key("tool")], message, help);
    let Some(tool) = tools.find(&ToolId::Name(plan.tool.clone())) else {
        return Err(of_tool(format!("the tool library has no tool {:?}", plan.tool), "name one of its tools").into());
    };
    let Some(radius) = tip(tool).and_then(Profile::ball_radius) else {
        return Err(of_tool(format!("tool {:?} is not a ball end mill", plan.tool), "name a ball end mill").into());
    };
    let wrong = |e: String| file(e, "correct [part.blade] and [plan.helix]");
    let blade = blade.blade(0.0).map_err(|e| wrong(e.to_string()))?;
    let points = plan.pass(radius).points(&blade).map_err(|e| wrong(e.to_string()))?;
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Ok(Vec::new()) };
    let table_from_work = scene.file.mount.table_from_work();
    let offset = offset_of(scene, "helix", &plan.work_offset)?;
    let zero = machine.program_zero().map_or_else(Vector::zeros, |zero| zero.coords);
    let mut writer = Writer { commands: Vec::new(), line: 0, table_from_work, zero, offset };
    let start = machine.inverse_nearest(&first.pose.transformed(&table_from_work), tool.gauge_length, &machine.home());
    let start =
        start.map_err(|e| file(format!("the machine cannot reach the start of the pass: {e}"), "move the mount"))?;
    writer.head(Head {
        notes: vec![
            format!(
                "Ball end mill on a helix round the blade, X {} to {}, pitch {}, tilt {} deg, lead {} deg",
                plan.from_x_mm, plan.to_x_mm, plan.pitch_mm, plan.head_tilt_deg, plan.lead_deg
            ),
            "Written by: proveout plan SCENE --strategy helix. Feed: inverse time of the ball center".into(),
        ],
        tool: &plan.tool,
        work_offset: &plan.work_offset,
        spindle_rpm: plan.spindle_rpm,
        tolerance: plan.tolerance_mm,
    });
    writer.rotary(machine, &start.q);
    writer.push(Op::Tcp(Tcp { on: true, interpolation: OrientationInterpolation::GreatCircle }));
    let off =
        |p: &proveout_path::PassPoint| ToolPose { tip: p.pose.tip + p.normal * plan.clearance_mm, axis: p.pose.axis };
    let rate = plan.feed_mm_min / 60.0;
    writer.motion(&off(first), true);
    writer.feed(plan.clearance_mm / rate);
    writer.motion(&first.pose, false);
    for pair in points.windows(2) {
        writer.feed((pair[1].center - pair[0].center).norm() / rate);
        writer.motion(&pair[1].pose, false);
    }
    writer.feed(plan.clearance_mm / rate);
    writer.motion(&off(last), false);
    writer.push(Op::Tcp(Tcp { on: false, interpolation: OrientationInterpolation::GreatCircle }));
    writer.tail();
    Ok(writer.commands)
}

/// A work offset that a plan names.
pub(crate) fn offset_of(scene: &Scene, strategy: &str, word: &str) -> Result<WorkOffset, InputError> {
    scene.file.work_offsets.get(word).map(WorkOffset::from).ok_or_else(|| {
        let known: Vec<&str> = scene.file.work_offsets.keys().map(String::as_str).collect();
        let message = format!("[plan.{strategy}] needs the work offset {word:?}, which the scene does not give");
        let help = format!("add [work_offsets.{word}], or name one of {known:?}");
        scene.error_at(&[Key("plan"), Key(strategy), Key("work_offset")], message, help)
    })
}

/// Builds commands one after the other, each on a line of its own.
pub(crate) struct Writer {
    pub(crate) commands: Vec<Command>,
    pub(crate) line: u32,
    pub(crate) table_from_work: Pose,
    /// Base coordinates with tool center point control count from here in K.
    pub(crate) zero: Vector,
    /// The work offset that the program calls.
    pub(crate) offset: WorkOffset,
}

/// What a program begins with.
pub(crate) struct Head<'a> {
    pub(crate) notes: Vec<String>,
    pub(crate) tool: &'a str,
    pub(crate) work_offset: &'a str,
    pub(crate) spindle_rpm: f64,
    pub(crate) tolerance: f64,
}

impl Writer {
    pub(crate) fn push(&mut self, op: Op) {
        self.line += 1;
        let location = Location { file: "plan".into(), line: self.line, column: 1, length: 0, depth: 0 };
        self.commands.push(Command { location, op });
    }

    pub(crate) fn head(&mut self, head: Head<'_>) {
        for note in head.notes {
            self.push(Op::Note(note.into()));
        }
        self.push(Op::Plane('Z'));
        self.push(Op::Tool(ToolAction::Select(ToolName::Name(head.tool.to_owned()))));
        self.push(Op::Tool(ToolAction::Change(ToolName::Name(head.tool.to_owned()))));
        self.push(Op::Offset(Offset::ToolEdge { edge: 1 }));
        self.push(Op::Offset(Offset::Work { word: head.work_offset.to_owned() }));
        let direction = SpindleDirection::Clockwise;
        self.push(Op::Spindle(Spindle { direction, speed_rpm: Some(head.spindle_rpm) }));
        self.push(Op::Coolant(Coolant { flood: true, mist: false }));
        self.push(Op::PathMode(PathMode::Continuous { tolerance: Some(head.tolerance), orientation_tolerance: None }));
    }

    /// The rotary axes turn while the tool is clear of the part, before tool center point control: with it
    /// the slides would carry the tool round the table.
    pub(crate) fn rotary(&mut self, machine: &Machine, q: &JointValues) {
        let (mut end, mut base) = (AxisValues::NONE, AxisValues::NONE);
        let mut programmed = 0;
        for &joint in machine.rotary_joints() {
            let letter = (3..6).find(|&l| machine.joint_for_letter(AXIS_LETTERS[l]) == Some(joint));
            if let Some(letter) = letter {
                end.put(letter, q[joint] - self.offset.rotary[letter - 3]);
                base.put(letter, q[joint]);
                programmed |= 1 << letter;
            }
        }
        self.push(Op::Rapid(Motion { end, end_base: base, programmed, ..Motion::default() }));
    }

    pub(crate) fn tail(&mut self) {
        self.push(Op::Coolant(Coolant { flood: false, mist: false }));
        self.push(Op::Spindle(Spindle { direction: SpindleDirection::Off, speed_rpm: None }));
        self.push(Op::End);
    }

    pub(crate) fn feed(&mut self, seconds: f64) {
        self.push(Op::Feed(Feed::InverseTime(seconds)));
    }

    /// A motion to a pose of the workpiece frame. Base coordinates are those of the table; a work offset
    /// shifts, so that the programmed vector is that of the table too.
    pub(crate) fn motion(&mut self, pose: &ToolPose, rapid: bool) {
        let axis = self.table_from_work.vector(&pose.axis);
        let turned = self.table_from_work.rotation * pose.tip.coords;
        let (mut end, mut base) = (AxisValues::NONE, AxisValues::NONE);
        for k in 0..3 {
            let place = self.table_from_work.translation[k] - self.zero[k];
            // Where the offset is the place of the mount, the programmed point is that of the workpiece, to
            // the last bit.
            end.put(k, turned[k] + (place - self.offset.translation[k]));
            base.put(k, turned[k] + place);
        }
        let motion = Motion {
            end,
            end_base: base,
            tool_axis: Some(axis.into()),
            tool_axis_base: Some(axis.into()),
            programmed: 0b111,
            ..Motion::default()
        };
        self.push(if rapid { Op::Rapid(motion) } else { Op::Linear(motion) });
    }
}

/// What a program is re-scheduled from.
#[derive(Clone, Copy, Debug)]
pub enum Original<'a> {
    /// A file.
    File(&'a Path),
    /// A text, as a plan has written it.
    Text(&'a str),
}

/// Reads a program, re-schedules it and gives the commands before posting. `part` is what the method may ask
/// about; where it asks how long the control takes, that is the control of the scene with planned set points.
///
/// # Errors
/// The program cannot be read, or the method refuses it, with the first block concerned.
pub fn rescheduled(
    scene: &Scene,
    reschedule: &RescheduleFile,
    from: Original<'_>,
    settings: &Settings,
    machine: &Machine,
    tools: &ToolLibrary,
    part: &PartOnTable,
) -> Result<Reprogrammed, SimError> {
    let settings = &with_machine(settings.clone(), machine);
    let commands = match from {
        Original::File(program) => Program::open(program, settings)?,
        Original::Text(text) => Program::from_text("planned.mpf", text, settings)?,
    };
    let commands = commands.collect::<Result<Vec<Command>, _>>()?;
    rescheduled_commands(scene, reschedule, commands, settings, machine, tools, part)
}

/// The same from commands that were read.
pub(crate) fn rescheduled_commands(
    scene: &Scene,
    reschedule: &RescheduleFile,
    commands: Vec<Command>,
    settings: &Settings,
    machine: &Machine,
    tools: &ToolLibrary,
    part: &PartOnTable,
) -> Result<Reprogrammed, SimError> {
    let settings = with_machine(settings.clone(), machine);
    let tool = |name: &ToolName| -> Option<&Tool> {
        let id = match name {
            ToolName::Empty => return None,
            ToolName::Number(n) => ToolId::Number(*n),
            ToolName::Name(n) => ToolId::Name(n.clone()),
        };
        tools.find(&id)
    };
    let method = reschedule.method();
    let cutter = |name: &ToolName| tip(tool(name)?).cloned();
    // Meshes that bound no solid are refused when the scene is read; a region that cannot be made is one that
    // is not known.
    let region = |name: &ToolName| part.region(tool(name)?).ok()?;
    let length = |name: &ToolName| tool(name).map(|t| t.gauge_length);
    let empty = Source::Text { name: "made.mpf".to_owned(), text: String::new() };
    let made = settings_of_made(settings.clone());
    let case = MotionCase::planned(scene, machine, tools, &made, empty)?;
    let times = |commands: Vec<Command>| {
        // What is asked about is the text that would be written, with its rounding.
        let text = text(&commands, Dialect::Siemens840d, &settings).ok()?;
        let read = Program::from_text("made.mpf", &text, &made).ok()?.collect::<Result<Vec<Command>, _>>().ok()?;
        let motion = case.of_commands(read).ok().filter(|motion| motion.over_travels.is_empty())?;
        let runs = motion.blocks.chunk_by(|a, b| a.run == b.run);
        Some(runs.map(|run| run.iter().map(|b| b.time[1] - b.time[0]).collect()).collect())
    };
    let work = Reprogramming {
        machine,
        method: method.as_ref(),
        cutter: &cutter,
        tip_tolerance: scene.file.control.path_tolerance_mm,
        length: &length,
        surface: part.surface(),
        region: &region,
        times: Some(&times),
    };
    work.apply(commands).map_err(SimError::Control)
}

/// How a program of a scene is re-scheduled: by an entry of the scene that makes it so, or with the options
/// of a method as they are published.
#[derive(Clone, Debug)]
pub struct Rescheduling<'a> {
    /// Program with the text.
    pub source: &'a ProgramFile,
    /// Entry whose options, machine, mounting and offsets are taken; that of the text where the scene does
    /// not re-schedule it by this method.
    pub entry: &'a ProgramFile,
    /// Method and options.
    pub file: RescheduleFile,
}

impl<'a> Rescheduling<'a> {
    /// What a scene says of re-scheduling a program by a method. `name` is that of a program with a text, or
    /// of a program that the scene makes by this method.
    ///
    /// # Errors
    /// What is wrong with value and remedy: no such program, another method, or several programs of the scene
    /// that make it with other options.
    pub fn of_scene(scene: &'a Scene, name: &str, method: MethodFile) -> Result<Self, InputError> {
        let wrong = |message: String, help: String| scene.error_at(&[Key("program")], message, help);
        let all = &scene.file.program;
        let names =
            |of: &mut dyn Iterator<Item = &ProgramFile>| of.map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
        let Some(named) = scene.program(Some(name)) else {
            let help = format!("programs of the scene: {}", names(&mut all.iter()));
            return Err(wrong(format!("there is no program {name:?}"), help));
        };
        let makes =
            |p: &&ProgramFile| p.reschedule.as_ref().is_some_and(|r| r.method == method && r.from == named.name);
        let (entry, source) = match &named.reschedule {
            Some(own) if own.method == method => (named, scene.program(Some(&own.from)).unwrap_or(named)),
            Some(_) => {
                let message = format!("the scene makes program {name:?} by another method");
                return Err(wrong(message, "name the program with the text, or that method".into()));
            }
            None => {
                let mut makers = all.iter().filter(makes);
                let first = makers.next();
                let options = |p: &ProgramFile| p.reschedule.clone();
                if let Some(first) = first
                    && makers.any(|other| options(other) != options(first))
                {
                    let message = format!("several programs of the scene are made from {name:?} by this method");
                    return Err(wrong(message, format!("name one of them: {}", names(&mut all.iter().filter(makes)))));
                }
                (first.unwrap_or(named), named)
            }
        };
        if source.file.is_none() {
            let help = "name a program with a file".into();
            return Err(wrong(format!("program {:?} has no text of its own", source.name), help));
        }
        let plain = || RescheduleFile::plain(method, &source.name);
        Ok(Self { source, entry, file: entry.reschedule.clone().unwrap_or_else(plain) })
    }
}
