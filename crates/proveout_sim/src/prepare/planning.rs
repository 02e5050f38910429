//! Paths that a scene plans over its blade: contacts, program, and what it asks of the machine before it
//! runs.

use std::{fmt::Write as _, sync::Arc};

use proveout_blade::{FOOT_ERROR_MM, ParametricSurface};
use proveout_geom::{ToolPose, Vector, deg};
use proveout_input::{InputError, Step, Step::Key};
use proveout_machine::{JointValues, KinematicsError, Machine};
use proveout_nc::{AXIS_LETTERS, AxisValues, Command, Motion, Op, OrientationInterpolation, Tcp};
use proveout_path::{Extreme, LineContacts, LinkRule, Move, PathCutter, PathJudgement, Setting, Task, linked};
use proveout_tool::{Tool, ToolId, ToolLibrary};
use serde::Serialize;

use crate::{
    prepare::{
        error::SimError,
        part_shape::Shape,
        programs::{Head, Writer, offset_of, tip},
    },
    scene::{FeedReferenceFile, PathFile, PostedFile, Scene, StrategyFile},
    units::UM_PER_MM,
};

/// Longest step of a rapid, mm, and largest turn of the tool axis in it, radian (5 degrees): between two of
/// them a control without tool center point control leaves the straight way by `r (1 - cos 2.5 deg)`, 0.1 mm
/// at 100 mm.
const RAPID_STEP: [f64; 2] = [25.0, 0.087];
/// A position below this is written as zero, mm or radian.
const SAME_JOINT: f64 = 1e-12;
/// Least and most rpm of a spindle and mm/min of a feed: wider than any machine, so that times and lengths
/// stay numbers.
const LEAST_RATE: f64 = 1e-3;
const MOST_RATE: f64 = 1e6;

/// A path with its program.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The program.
    pub commands: Vec<Command>,
    /// What it asks.
    pub report: PlanReport,
    /// The contacts.
    pub lines: Vec<LineContacts>,
}

/// What a path asks of a machine, as it is printed and written.
#[derive(Clone, Debug, Serialize)]
pub struct PlanReport {
    /// Strategy.
    pub strategy: String,
    /// Machine.
    pub machine: String,
    /// `tool-center-point` or `joints`: what the program holds.
    pub posted: &'static str,
    /// Lines and contacts.
    pub lines: usize,
    /// Contacts of all lines.
    pub contacts: usize,
    /// Length of the contacts' path, mm.
    pub length_mm: f64,
    /// Feed of the contact, mm/min.
    pub feed_mm_min: f64,
    /// Time along the lines at that feed, s.
    pub time_at_feed_s: f64,
    /// The same where joint velocities allow no more, s.
    pub time_under_limits_s: f64,
    /// Contacts at which joint velocities allow less than the feed.
    pub slowed_contacts: usize,
    /// Lowest feed that they allow, mm/min.
    pub lowest_feed_mm_min: Option<PlaceReport>,
    /// Joint that allows no more there.
    pub slowest_joint: Option<String>,
    /// Largest turn of the tool axis, deg/mm.
    pub axis_rate_deg_mm: Option<PlaceReport>,
    /// Smallest angle between the tool axis and a pole of the rotary joints, degrees.
    pub pole_distance_deg: Option<PlaceReport>,
    /// Largest distance of the tip from its chord if joints move straight between the contacts, um.
    pub tip_error_without_tcp_um: Option<PlaceReport>,
    /// Largest error of the straight motion between contacts, um.
    pub chord_error_um: Option<PlaceReport>,
    /// Highest scallop as computed, um.
    pub scallop_um: Option<PlaceReport>,
    /// Largest side step, mm.
    pub side_step_mm: Option<PlaceReport>,
    /// Deepest cut of a flank into its ruled side, um.
    pub flank_gouge_um: Option<PlaceReport>,
    /// Most that a flank leaves on it, um.
    pub flank_left_um: Option<PlaceReport>,
    /// Largest angle between the normals at both ends of a ruling, degrees.
    pub ruling_twist_deg: Option<PlaceReport>,
    /// Joints and legs.
    pub joints: Vec<JointReport>,
    /// Every line, point by point.
    pub points: Vec<LineReport>,
}

/// A value with its place.
#[derive(Clone, Debug, Serialize)]
pub struct PlaceReport {
    /// The value.
    pub value: f64,
    /// Line.
    pub line: String,
    /// Part of the way along the blade.
    pub section: f64,
    /// Part of the way round the section.
    pub round: f64,
    /// Contact, workpiece frame, mm.
    pub point_mm: [f64; 3],
}

/// What a joint does; angles in degrees.
#[derive(Clone, Debug, Serialize)]
pub struct JointReport {
    /// Name.
    pub name: String,
    /// `mm` or `deg`.
    pub unit: &'static str,
    /// Sum of its steps along the lines.
    pub travel: f64,
    /// Lowest and highest position.
    pub range: [f64; 2],
    /// Changes of direction along lines.
    pub reversals: usize,
    /// Largest change for each mm of the contact's path, with its place.
    pub rate: Option<PlaceReport>,
    /// Velocity there at the programmed feed, unit/s.
    pub velocity: f64,
    /// Limit of its velocity, unit/s.
    pub limit: Option<f64>,
}

/// The points of a line.
#[derive(Clone, Debug, Serialize)]
pub struct LineReport {
    /// Its name.
    pub name: String,
    /// Length up to each contact, mm.
    pub length_mm: Vec<f64>,
    /// Feed that joint velocities allow up to it, mm/min; none where nothing limits it.
    pub feed_mm_min: Vec<Option<f64>>,
    /// Joint positions, mm and degrees, in the order of the machine's joints.
    pub joints: Vec<Vec<f64>>,
    /// Scallop to the next line as computed, um.
    pub scallop_um: Vec<Option<f64>>,
    /// Error of the straight motion that ends at each contact, um.
    pub chord_error_um: Vec<f64>,
}

fn place(e: &Extreme, factor: f64) -> PlaceReport {
    PlaceReport {
        value: e.value * factor,
        line: e.line.clone(),
        section: e.at.section,
        round: e.at.round,
        point_mm: e.at.point,
    }
}

/// The path of a strategy over the blade of a scene.
///
/// # Errors
/// The scene has no such plan, a key does not belong to it, the cutter does not fit, or the machine cannot
/// take a pose: with the table, the section and the point. Nothing is made then.
pub fn plan(
    scene: &Scene,
    machine: &Machine,
    tools: &ToolLibrary,
    strategy: StrategyFile,
) -> Result<Planned, SimError> {
    let shape = shape(scene)?;
    let planned = plan_over(scene, machine, tools, strategy, shape.surface().as_ref())?;
    check_ends(scene, strategy.name(), &shape, &planned.lines)?;
    check_ball(scene, tools, strategy, &shape, &planned.lines)?;
    Ok(planned)
}

/// The path of a strategy of a scene over any surface of the workpiece frame.
///
/// # Errors
/// As [`plan`].
pub fn plan_over(
    scene: &Scene,
    machine: &Machine,
    tools: &ToolLibrary,
    strategy: StrategyFile,
    surface: &dyn ParametricSurface,
) -> Result<Planned, SimError> {
    let name = strategy.name();
    let at_key = |key: Option<&str>, message: String, help: &str| {
        let path: Vec<Step<'_>> = [Key("plan"), Key(name)].into_iter().chain(key.map(Key)).collect();
        scene.error_at(&path, message, help)
    };
    let wrong = |message: String, help: &str| at_key(None, message, help);
    let Some(file) = scene.file.plan.as_ref().and_then(|p| strategy.of(p)) else {
        let message = format!("the scene has no [plan.{name}]");
        return Err(wrong(message, "describe the path in the scene").into());
    };
    // The message begins with its key where it is of one.
    let keyed = |(message, help): (String, String)| {
        let key =
            message.split([' ', ':']).next().filter(|word| word.contains('_') || *word == "posted").map(str::to_owned);
        at_key(key.as_deref(), format!("[plan.{name}]: {message}"), &help)
    };
    let own = file.machine.as_ref().map(|path| Machine::read(&scene.resolve(path))).transpose()?;
    let machine = own.as_ref().unwrap_or(machine);
    let tool = tool_of(scene, tools, name, &file.tool)?;
    let Some(cutter) = tip(tool).cloned().map(PathCutter::new) else {
        return Err(
            at_key(Some("tool"), format!("tool {:?} has no cutting end", file.tool), "name a tool that cuts").into()
        );
    };
    let planned = file.strategy(strategy).map_err(keyed)?;
    let rule = file.axis_rule();
    let task = Task {
        surface,
        cutter: &cutter,
        rule: &rule,
        step: file.step_rule().map_err(keyed)?,
        allowance: file.allowance_mm,
    };
    check(file).map_err(keyed)?;
    let refused = |e: proveout_path::PathError| {
        wrong(format!("[plan.{name}]: {e}"), "change the plan, the tool or the mount: nothing was written")
    };
    let lines = task.plan(planned.as_ref()).map_err(refused)?;
    let table_from_work = scene.file.mount.table_from_work();
    let setting = Setting {
        machine,
        table_from_surface: table_from_work,
        tool_length: tool.gauge_length,
        domain: surface.domain(),
        feed: file.feed_mm_min / 60.0,
    };
    let judged = setting.judge(&lines, &machine.home()).map_err(refused)?;
    let link = LinkRule {
        lift: file.lift_mm,
        clearance: file.clearance_mm,
        feed: setting.feed,
        step: RAPID_STEP,
        chords: file.feed_reference == FeedReferenceFile::Chord,
    };
    let moves = linked(surface, &cutter, &lines, &link).map_err(refused)?;
    let able = machine.control.kinematics.is_none_or(|k| k.tcp);
    if file.posted == Some(PostedFile::ToolCenterPoint) && !able {
        let message =
            format!("posted = \"tool-center-point\": the control of {} has no tool center point control", machine.name);
        return Err(keyed((message, "write posted = \"joints\", or name another machine".to_owned())).into());
    }
    let tcp = file.posted.map_or(able, |p| p == PostedFile::ToolCenterPoint);
    let commands = program(scene, machine, tool, (file, name), &moves, tcp)?;
    let report = report(name, machine, file, &lines, &judged, tcp);
    Ok(Planned { commands, report, lines })
}

fn check(file: &PathFile) -> Result<(), (String, String)> {
    let ranges = [
        ("spindle_rpm", file.spindle_rpm, LEAST_RATE, MOST_RATE),
        ("feed_mm_min", file.feed_mm_min, LEAST_RATE, MOST_RATE),
        ("tolerance_mm", file.tolerance_mm, 0.0, 10.0),
        ("allowance_mm", file.allowance_mm, 0.0, 1000.0),
    ];
    for (key, value, low, high) in ranges {
        if !(low..=high).contains(&value) {
            return Err((format!("{key} = {value} is out of range"), format!("write {low} to {high}")));
        }
    }
    Ok(())
}

/// The side of the part that is cut, without its ends.
///
/// # Errors
/// The scene has no blade, or numbers that make none.
pub fn surface(scene: &Scene) -> Result<Arc<dyn ParametricSurface>, InputError> {
    Ok(shape(scene)?.surface())
}

fn shape(scene: &Scene) -> Result<Shape, InputError> {
    let blade = scene.file.part.as_ref().and_then(|p| p.blade.as_ref());
    let Some(blade) = blade else {
        return Err(InputError::file(
            &scene.path,
            "the scene has no blade to plan over",
            "describe it as [part.blade]",
        ));
    };
    Shape::of_scene(scene, blade, 0.0)
}

/// Contacts that lie where an end of the blade cuts its surface off: there is no such face.
fn check_ends(scene: &Scene, name: &str, shape: &Shape, lines: &[LineContacts]) -> Result<(), InputError> {
    let Shape::Ended(solid) = shape else { return Ok(()) };
    for line in lines {
        for contact in &line.contacts {
            let ([u, v], p) = (contact.place.uv, contact.place.point);
            if !solid.leaves(u, v) {
                let message = format!(
                    "[plan.{name}]: line {} touches the blade at X{:.3} Y{:.3} Z{:.3}, where its end or a fillet is",
                    line.name, p.x, p.y, p.z
                );
                return Err(InputError::file(
                    &scene.path,
                    message,
                    "begin and end the path farther from the ends of the blade",
                ));
            }
        }
    }
    Ok(())
}

/// A ball that cuts into a fillet or a platform while it touches the blade next to it. Other
/// cutters are checked by the run alone, and so are shank and holder.
fn check_ball(
    scene: &Scene,
    tools: &ToolLibrary,
    strategy: StrategyFile,
    shape: &Shape,
    lines: &[LineContacts],
) -> Result<(), InputError> {
    let (Shape::Ended(solid), Some(file)) = (shape, scene.file.plan.as_ref().and_then(|p| strategy.of(p))) else {
        return Ok(());
    };
    let name = strategy.name();
    let tool = tool_of(scene, tools, name, &file.tool)?;
    let Some(radius) = tip(tool).and_then(|profile| profile.ball_radius()) else { return Ok(()) };
    if strategy == StrategyFile::Flank {
        return Ok(());
    }
    let allowed = file.chord_error_mm.unwrap_or(0.0).max(FOOT_ERROR_MM);
    let domain = solid.surface().domain();
    for line in lines {
        for contact in &line.contacts {
            let pose = &contact.touch.pose;
            let deep = radius - solid.nearest(&(pose.tip + pose.axis * radius)).distance;
            if deep > allowed {
                let at = contact.place.named(&domain);
                let message = format!(
                    "[plan.{name}]: a ball of R{radius:.3} mm is too large for the fillet or the platform near line {} at {at}: it cuts \
                     {deep:.4} mm into it",
                    line.name
                );
                let help = "use a cutter no larger than the fillet, or end the path farther from the ends of the \
                            blade: nothing was written";
                return Err(scene.error_at(&[Key("plan"), Key(name), Key("tool")], message, help));
            }
        }
    }
    Ok(())
}

fn tool_of<'a>(scene: &Scene, tools: &'a ToolLibrary, plan: &str, name: &str) -> Result<&'a Tool, InputError> {
    tools.find(&ToolId::Name(name.to_owned())).ok_or_else(|| {
        let message = format!("[plan.{plan}]: the tool library has no tool {name:?}");
        scene.error_at(&[Key("plan"), Key(plan), Key("tool")], message, "name one of its tools")
    })
}

/// The program of motions in the workpiece frame: tool vectors under tool center point control, or joints
/// where the control has none.
fn program(
    scene: &Scene,
    machine: &Machine,
    tool: &Tool,
    (file, name): (&PathFile, &str),
    moves: &[Move],
    tcp: bool,
) -> Result<Vec<Command>, SimError> {
    let wrong = |message: String, help: &str| scene.error_at(&[Key("plan"), Key(name)], message, help);
    let table_from_work = scene.file.mount.table_from_work();
    let offset = offset_of(scene, name, &file.work_offset)?;
    let zero = machine.program_zero().map_or_else(Vector::zeros, |zero| zero.coords);
    let mut positions = Vec::with_capacity(moves.len());
    let mut previous = machine.home();
    for (k, step) in moves.iter().enumerate() {
        let pose = step.pose.transformed(&table_from_work);
        let found = machine
            .inverse_nearest(&pose, tool.gauge_length, &previous)
            .map_err(|fault| unreachable(scene, name, (k, moves.len()), step, &fault))?;
        previous = found.q;
        positions.push(found.q);
    }
    let Some(&start) = positions.first() else { return Ok(Vec::new()) };
    let mut writer = Writer { commands: Vec::new(), line: 0, table_from_work, zero, offset };
    let feed = format!("Feed: inverse time of the contact, F{} mm/min", file.feed_mm_min);
    writer.head(Head {
        notes: vec![
            format!("{name} over the blade of {}", scene.file.name),
            format!("Written by: proveout plan SCENE --strategy {name}. {feed}"),
        ],
        tool: &file.tool,
        work_offset: &file.work_offset,
        spindle_rpm: file.spindle_rpm,
        tolerance: file.tolerance_mm,
    });
    writer.rotary(machine, &start);
    if tcp {
        writer.push(Op::Tcp(Tcp { on: true, interpolation: OrientationInterpolation::GreatCircle }));
    }
    for (step, q) in moves.iter().zip(&positions) {
        if let Some(seconds) = step.seconds {
            writer.feed(seconds);
        }
        if tcp {
            writer.motion(&step.pose, step.seconds.is_none());
        } else {
            let motion = joint_motion(machine, tool, &writer, q);
            let motion = motion.ok_or_else(|| {
                wrong(format!("machine {} has no joints X, Y and Z to post", machine.name), "plan for another machine")
            })?;
            writer.push(if step.seconds.is_none() { Op::Rapid(motion) } else { Op::Linear(motion) });
        }
    }
    if tcp {
        writer.push(Op::Tcp(Tcp { on: false, interpolation: OrientationInterpolation::GreatCircle }));
    }
    writer.tail();
    Ok(writer.commands)
}

fn unreachable(
    scene: &Scene,
    name: &str,
    (k, count): (usize, usize),
    step: &Move,
    fault: &KinematicsError,
) -> InputError {
    let ToolPose { tip, axis } = &step.pose;
    let message = format!(
        "[plan.{name}]: motion {} of {count} is out of reach (tip X{:.3} Y{:.3} Z{:.3}, axis {:.4} {:.4} {:.4}): {fault}",
        k + 1,
        tip.x,
        tip.y,
        tip.z,
        axis.x,
        axis.y,
        axis.z
    );
    scene.error_at(
        &[Key("plan"), Key(name)],
        message,
        "change the mount, the axis or the clearance: nothing was written",
    )
}

/// Without tool center point control base coordinates are those of the axes, less the tool length.
fn joint_motion(machine: &Machine, tool: &Tool, writer: &Writer, q: &JointValues) -> Option<Motion> {
    let length = machine.spindle.gauge_pose.vector(&Vector::z()) * tool.gauge_length;
    let (mut end, mut base, mut programmed) = (AxisValues::NONE, AxisValues::NONE, 0);
    for (index, &letter) in AXIS_LETTERS.iter().enumerate() {
        let Some(joint) = machine.joint_for_letter(letter).filter(|&j| !machine.joints[j].held) else {
            if index < 3 {
                return None;
            }
            continue;
        };
        let value = q[joint] - if index < 3 { length[index] } else { 0.0 };
        let shift = if index < 3 {
            writer.offset.translation[index]
        } else if index < 6 {
            writer.offset.rotary[index - 3]
        } else {
            0.0
        };
        // The sign of a zero is no position.
        let value = if value.abs() < SAME_JOINT { 0.0 } else { value };
        end.put(index, value - shift);
        base.put(index, value);
        programmed |= 1 << index;
    }
    Some(Motion { end, end_base: base, programmed, ..Motion::default() })
}

fn report(
    name: &str,
    machine: &Machine,
    file: &PathFile,
    lines: &[LineContacts],
    judged: &PathJudgement,
    tcp: bool,
) -> PlanReport {
    let shown = |e: &Option<Extreme>, factor: f64| e.as_ref().map(|e| place(e, factor));
    let joint = |d: &proveout_path::JointDemand| {
        let factor = if d.rotary { deg(1.0) } else { 1.0 };
        JointReport {
            name: d.name.clone(),
            unit: if d.rotary { "deg" } else { "mm" },
            travel: d.travel * factor,
            range: d.range.map(|r| r * factor),
            reversals: d.reversals,
            rate: shown(&d.rate, factor),
            velocity: d.velocity(file.feed_mm_min / 60.0) * factor,
            limit: d.limit.map(|l| l * factor),
        }
    };
    let in_unit =
        |q: &JointValues| machine.joints.iter().enumerate().map(|(j, joint)| joint.kind.in_unit(q[j])).collect();
    let points = lines.iter().zip(&judged.positions).zip(&judged.feeds).map(|((line, q), feeds)| LineReport {
        name: line.name.clone(),
        length_mm: line.contacts.iter().map(|c| c.length).collect(),
        feed_mm_min: feeds.iter().map(|f| f.is_finite().then_some(60.0 * f)).collect(),
        joints: q.iter().map(in_unit).collect(),
        scallop_um: line.contacts.iter().map(|c| c.scallop.map(|s| UM_PER_MM * s)).collect(),
        chord_error_um: line.contacts.iter().map(|c| UM_PER_MM * c.chord_error).collect(),
    });
    PlanReport {
        strategy: name.to_owned(),
        machine: machine.name.clone(),
        posted: if tcp { "tool-center-point" } else { "joints" },
        lines: lines.len(),
        contacts: judged.contacts,
        length_mm: judged.length,
        feed_mm_min: file.feed_mm_min,
        time_at_feed_s: judged.time[0],
        time_under_limits_s: judged.time[1],
        slowed_contacts: judged.slowed,
        lowest_feed_mm_min: shown(&judged.lowest_feed, 60.0).filter(|f| f.value.is_finite()),
        slowest_joint: judged.slowest_joint.clone(),
        axis_rate_deg_mm: shown(&judged.axis_rate, deg(1.0)),
        pole_distance_deg: shown(&judged.pole, deg(1.0)),
        tip_error_without_tcp_um: shown(&judged.tip_error_without_tcp, UM_PER_MM),
        chord_error_um: shown(&judged.chord_error, UM_PER_MM),
        scallop_um: shown(&judged.scallop, UM_PER_MM),
        side_step_mm: shown(&judged.side_step, 1.0),
        flank_gouge_um: shown(&judged.flank_gouge, UM_PER_MM),
        flank_left_um: shown(&judged.flank_left, UM_PER_MM),
        ruling_twist_deg: shown(&judged.ruling_twist, deg(1.0)),
        joints: judged.joints.iter().map(joint).collect(),
        points: points.collect(),
    }
}

impl PlanReport {
    /// The report for people.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let minutes = |s: f64| format!("{}:{:04.1}", (s / 60.0) as u64, s % 60.0);
        let mut line = |text: String| {
            out.push_str(&text);
            out.push('\n');
        };
        line(format!(
            "{} on {}: {} lines, {} contacts, {:.1} mm, posted as {}",
            self.strategy, self.machine, self.lines, self.contacts, self.length_mm, self.posted
        ));
        line(format!(
            "  time along the lines {} min at {} mm/min, {} min where joint velocities allow less ({} contacts)",
            minutes(self.time_at_feed_s),
            self.feed_mm_min,
            minutes(self.time_under_limits_s),
            self.slowed_contacts
        ));
        line(format!(
            "  {:<6} {:>12} {:>24} {:>9} {:>14} {:>14} {:>10}",
            "joint", "travel", "range", "reversals", "rate /mm", "at feed /s", "limit /s"
        ));
        for joint in &self.joints {
            line(format!(
                "  {:<6} {:>8.3} {:<3} {:>11.3} to {:>9.3} {:>9} {:>14.5} {:>14.3} {:>10}",
                joint.name,
                joint.travel,
                joint.unit,
                joint.range[0],
                joint.range[1],
                joint.reversals,
                joint.rate.as_ref().map_or(0.0, |r| r.value),
                joint.velocity,
                joint.limit.map_or_else(|| "not stated".to_owned(), |l| format!("{l:.3}"))
            ));
        }
        let shown = [
            ("lowest feed by joint velocities", &self.lowest_feed_mm_min, "mm/min"),
            ("largest turn of the tool axis", &self.axis_rate_deg_mm, "deg/mm"),
            ("nearest to a pole", &self.pole_distance_deg, "deg"),
            ("tip from its chord without TCP", &self.tip_error_without_tcp_um, "um"),
            ("largest chord error", &self.chord_error_um, "um"),
            ("highest scallop as computed", &self.scallop_um, "um"),
            ("largest side step", &self.side_step_mm, "mm"),
        ];
        let flank = [
            ("flank into the side", &self.flank_gouge_um, "um"),
            ("left by the flank", &self.flank_left_um, "um"),
            ("turn of the normal on a ruling", &self.ruling_twist_deg, "deg"),
        ];
        let flank = flank.into_iter().filter(|(_, value, _)| value.is_some());
        for (what, value, unit) in shown.into_iter().chain(flank) {
            match value {
                Some(v) => {
                    let [x, y, z] = v.point_mm;
                    let joint = if unit == "mm/min" {
                        self.slowest_joint.as_ref().map_or(String::new(), |j| format!(", {j}"))
                    } else {
                        String::new()
                    };
                    line(format!(
                        "  {what:<32} {:>10.4} {unit:<6} {} at X{x:.3} Y{y:.3} Z{z:.3} (section {:.4}){joint}",
                        v.value, v.line, v.section
                    ));
                }
                None => line(format!("  {what:<32} {:>10} ", "none")),
            }
        }
        out
    }

    /// The report of several strategies side by side, one row each.
    pub fn table(reports: &[Self]) -> String {
        let mut out = String::new();
        let rotary: Vec<&str> = reports
            .first()
            .map_or(Vec::new(), |r| r.joints.iter().filter(|j| j.unit == "deg").map(|j| j.name.as_str()).collect());
        let _ = write!(out, "{:<17} {:>5} {:>8}", "strategy", "lines", "mm");
        for name in &rotary {
            let _ = write!(
                out,
                " {:>11} {:>10} {:>10}",
                format!("{name} deg/mm"),
                format!("{name} range"),
                format!("{name} deg/s")
            );
        }
        let _ = writeln!(out, " {:>12} {:>9} {:>9} {:>9}", "feed mm/s", "pole deg", "chord um", "ridge um");
        for report in reports {
            let _ = write!(out, "{:<17} {:>5} {:>8.1}", report.strategy, report.lines, report.length_mm);
            for joint in report.joints.iter().filter(|j| j.unit == "deg") {
                let rate = joint.rate.as_ref().map_or(0.0, |r| r.value);
                let index = report.joints.iter().position(|j| j.name == joint.name);
                let range = report.points.iter().map(|line| {
                    let of = |f: fn(f64, f64) -> f64, start: f64| {
                        line.joints.iter().filter_map(|q| q.get(index?)).copied().fold(start, f)
                    };
                    of(f64::max, f64::MIN) - of(f64::min, f64::MAX)
                });
                let _ = write!(out, " {rate:>11.4} {:>10.3} {:>10.3}", range.fold(0.0, f64::max), joint.velocity);
            }
            let value = |p: &Option<PlaceReport>, factor: f64| {
                p.as_ref().map_or_else(|| "-".to_owned(), |p| format!("{:.3}", p.value * factor))
            };
            let _ = writeln!(
                out,
                " {:>12} {:>9} {:>9} {:>9}",
                value(&report.lowest_feed_mm_min, 1.0 / 60.0),
                value(&report.pole_distance_deg, 1.0),
                value(&report.chord_error_um, 1.0),
                value(&report.scallop_um, 1.0)
            );
        }
        out
    }
}
