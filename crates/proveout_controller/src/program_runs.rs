//! Runs of a program: straight motions in feed under tool center point control without a rapid, a tool change
//! or a stop between them, with the pose at the end of each block.
//!
//! A program that never switches tool center point control on gives positions of the axes. Its runs are found
//! where the length of the tool is known: the pose is that of the machine at these positions, the length
//! along the tool.

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_nc::{AXIS_LETTERS, Command, Feed, Location, Motion, Op, ToolAction, ToolName};

use crate::error::ControlError;

/// By how much products of the columns of a rotation may be off those of unit vectors.
const RIGID: f64 = 1e-9;

/// A run of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramRun {
    /// The tool in the spindle.
    pub tool: Option<ToolName>,
    /// Its blocks, in order.
    pub blocks: Vec<ProgramBlock>,
}

/// A block of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramBlock {
    /// Index of its command.
    pub command: usize,
    /// Line in its file.
    pub line: u32,
    /// Tip and axis at its end, in the table frame K.
    pub pose: ToolPose,
    /// Time by the programmed feed, s; none for the first block of a run and where no feed is
    /// programmed.
    pub time: Option<f64>,
}

/// The runs of a program that have at least `shortest` blocks.
///
/// # Errors
/// Arcs, splines, threads or probing under tool center point control, or a scaled frame: with the block.
pub fn program_runs(
    machine: &Machine,
    commands: &[Command],
    shortest: usize,
) -> Result<Vec<ProgramRun>, Box<ControlError>> {
    let found = find_runs(machine, commands, None)?;
    let long = found.into_iter().filter(|run| run.blocks.len() >= shortest.max(1));
    let run = |run: RunBlocks| ProgramRun { blocks: run.placed_blocks(commands).collect(), tool: run.tool };
    Ok(long.map(run).collect())
}

/// A motion with its pose in the table frame K.
#[derive(Clone, Copy)]
pub(crate) struct BlockPose {
    pub(crate) command: usize,
    pub(crate) pose: ToolPose,
    /// Time by the programmed feed, s.
    pub(crate) time: Option<f64>,
    /// The program gives the block this time whatever its way is (inverse time).
    pub(crate) timed: bool,
    pub(crate) frame: WorkFrame,
}

/// Work to base coordinates, without scale.
#[derive(Clone, Copy)]
pub(crate) struct WorkFrame {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
    pub(crate) rotary: [f64; 3],
}

impl WorkFrame {
    const IDENTITY: Self =
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3], rotary: [0.0; 3] };

    pub(crate) fn turned_back(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|k| self.rotation[k][i] * v[k]).sum())
    }

    pub(crate) fn work_point(&self, p: &Point) -> [f64; 3] {
        self.turned_back(std::array::from_fn(|k| p[k] - self.translation[k]))
    }

    fn is_rigid(&self) -> bool {
        (0..3).all(|a| {
            (0..3).all(|b| {
                let dot: f64 = (0..3).map(|k| self.rotation[a][k] * self.rotation[b][k]).sum();
                (dot - f64::from(u8::from(a == b))).abs() < RIGID
            })
        })
    }
}

impl RunBlocks {
    fn is_empty(&self) -> bool {
        self.before.is_empty() && self.blocks.is_empty() && self.after.is_empty()
    }

    /// The blocks, each with its line; the first one has no time, since it comes from somewhere else.
    pub(crate) fn placed_blocks<'a>(&'a self, commands: &'a [Command]) -> impl Iterator<Item = ProgramBlock> + 'a {
        self.blocks.iter().enumerate().map(|(k, block)| ProgramBlock {
            command: block.command,
            line: commands.get(block.command).map_or(0, |c| c.location.line),
            pose: block.pose,
            time: block.time.filter(|_| k > 0),
        })
    }
}

/// A run with the rapids that lead to it and away from it.
#[derive(Default)]
pub(crate) struct RunBlocks {
    pub(crate) tool: Option<ToolName>,
    /// Gauge length of the tool, mm, where the blocks are positions of the axes, without tool center point
    /// control.
    pub(crate) joints: Option<f64>,
    /// The last rapid before tool center point control that turns rotary axes.
    pub(crate) turning: Option<(usize, WorkFrame)>,
    pub(crate) before: Vec<BlockPose>,
    pub(crate) blocks: Vec<BlockPose>,
    pub(crate) after: Vec<BlockPose>,
    /// Nothing but rapids under tool center point control is between the run before and this one.
    pub(crate) linked: bool,
}

/// Gauge length of a tool, mm; none where the library does not have it.
pub(crate) type ToolLengths<'a> = dyn Fn(&ToolName) -> Option<f64> + 'a;

/// The runs of a program, with what leads to them; runs without a block among them. With lengths of tools,
/// those of a program without tool center point control as well.
pub(crate) fn find_runs(
    machine: &Machine,
    commands: &[Command],
    lengths: Option<&ToolLengths<'_>>,
) -> Result<Vec<RunBlocks>, Box<ControlError>> {
    let controlled = commands.iter().any(|c| matches!(&c.op, Op::Tcp(tcp) if tcp.on));
    if let Some(lengths) = lengths.filter(|_| !controlled) {
        return find_joint_runs(machine, commands, lengths);
    }
    let mut runs = vec![RunBlocks::default()];
    let mut state = RunFinder { q: machine.home(), zero: base_zero(machine), ..RunFinder::default() };
    for (index, command) in commands.iter().enumerate() {
        match &command.op {
            Op::Tcp(tcp) => {
                state.tcp = tcp.on;
                // ORIVECT after TRAORI repeats it: the turn before the first one still leads to the
                // run.
                let idle = runs.pop_if(|run| run.is_empty() && tcp.on).and_then(|run| run.turning);
                let turning = state.turning.take().or(idle).filter(|_| tcp.on);
                runs.push(RunBlocks { tool: state.tool.clone(), turning, ..RunBlocks::default() });
            }
            Op::Feed(feed) => state.feed = Some(*feed),
            Op::Tool(ToolAction::Change(name)) => {
                state.tool = Some(name.clone());
                runs.push(RunBlocks { tool: state.tool.clone(), ..RunBlocks::default() });
            }
            Op::Frame(change) => {
                let frame =
                    WorkFrame { rotation: change.rotation, translation: change.translation, rotary: change.rotary };
                state.frame = frame;
            }
            Op::Rapid(motion) | Op::Linear(motion) => {
                let turns = motion.programmed >> 3 & 0b111 != 0 && !motion.machine_coordinates;
                if !state.tcp && turns && matches!(command.op, Op::Rapid(_)) {
                    state.turning = Some((index, state.frame));
                }
                let placed = place(machine, &mut state, motion, index);
                let Some(placed) = placed.filter(|_| state.tcp && !motion.machine_coordinates) else { continue };
                if !state.frame.is_rigid() {
                    let message = "a scaled frame is in force".to_owned();
                    return Err(fail(&command.location, "reschedule-path", message, "write the path without SCALE"));
                }
                let feed = matches!(command.op, Op::Linear(_));
                let fresh = RunBlocks { tool: state.tool.clone(), ..RunBlocks::default() };
                let Some(run) = runs.last_mut() else { continue };
                if feed && run.after.is_empty() {
                    run.blocks.push(placed);
                } else if feed {
                    runs.push(RunBlocks { blocks: vec![placed], linked: true, ..fresh });
                } else if run.blocks.is_empty() {
                    run.before.push(placed);
                } else {
                    run.after.push(placed);
                }
            }
            Op::Arc(_) | Op::Spline(_) | Op::Thread(_) | Op::Probe(_) if state.tcp => {
                let message = "only straight blocks can be re-scheduled".to_owned();
                return Err(fail(&command.location, "reschedule-path", message, "post the path as straight blocks"));
            }
            _ => {}
        }
    }
    Ok(runs)
}

/// The runs of a program of positions of axes.
fn find_joint_runs(
    machine: &Machine,
    commands: &[Command],
    lengths: &ToolLengths<'_>,
) -> Result<Vec<RunBlocks>, Box<ControlError>> {
    let mut runs = vec![RunBlocks::default()];
    let mut state = RunFinder { q: machine.home(), ..RunFinder::default() };
    let mut joints = None;
    for (index, command) in commands.iter().enumerate() {
        let fresh = |state: &RunFinder, joints| RunBlocks { tool: state.tool.clone(), joints, ..RunBlocks::default() };
        match &command.op {
            Op::Feed(feed) => state.feed = Some(*feed),
            Op::Tool(ToolAction::Change(name)) => {
                joints = lengths(name);
                state.tool = Some(name.clone());
                runs.push(fresh(&state, joints));
            }
            Op::Frame(change) => {
                let frame =
                    WorkFrame { rotation: change.rotation, translation: change.translation, rotary: change.rotary };
                state.frame = frame;
            }
            Op::Rapid(motion) | Op::Linear(motion) => {
                let feed = matches!(command.op, Op::Linear(_));
                let Some(length) = joints.filter(|_| !motion.machine_coordinates) else { continue };
                let placed = place_joints(machine, &mut state, motion, index, length);
                let Some(run) = runs.last_mut() else { continue };
                if !feed && motion.programmed & 0b111 == 0 && motion.programmed >> 3 & 0b111 != 0 && run.is_empty() {
                    run.turning = Some((index, state.frame));
                    continue;
                }
                let Some(placed) = placed else { continue };
                if !state.frame.is_rigid() {
                    let message = "a scaled frame is in force".to_owned();
                    return Err(fail(&command.location, "reschedule-path", message, "write the path without SCALE"));
                }
                if feed && run.after.is_empty() {
                    run.blocks.push(placed);
                } else if feed {
                    runs.push(RunBlocks { blocks: vec![placed], ..fresh(&state, joints) });
                } else if run.blocks.is_empty() {
                    run.before.push(placed);
                } else {
                    run.after.push(placed);
                }
            }
            Op::Arc(_) | Op::Spline(_) | Op::Thread(_) | Op::Probe(_) => {
                // Where these end is not tracked: the next motion has to program every axis.
                state.tip = [None; 3];
                runs.push(fresh(&state, joints));
            }
            _ => {}
        }
    }
    Ok(runs)
}

/// Tool length as base coordinates without tool center point control leave it out, mm: along the tool with
/// all joints at zero.
pub(crate) fn length_at_zero(machine: &Machine, length: f64) -> Vector {
    machine.spindle.gauge_pose.vector(&Vector::z()) * length
}

/// Pose at the end of a motion of the axes; none where not all of them are programmed, or the
/// machine has no X, Y and Z.
fn place_joints(
    machine: &Machine,
    state: &mut RunFinder,
    motion: &Motion,
    command: usize,
    length: f64,
) -> Option<BlockPose> {
    for axis in 0..3 {
        state.tip[axis] = motion.end_base.get(axis).or(state.tip[axis]);
        state.rotary[axis] = motion.end_base.get(3 + axis).or(state.rotary[axis]);
    }
    if motion.tool_axis.is_some() {
        return None;
    }
    let mut q = machine.home();
    let shift = length_at_zero(machine, length);
    for ((letter, place), shift) in AXIS_LETTERS.into_iter().zip(state.tip).zip(shift.iter()) {
        q[machine.joint_for_letter(letter)?] = place? + shift;
    }
    for &joint in machine.rotary_joints() {
        let letter = AXIS_LETTERS[3..6].iter().position(|&l| machine.joint_for_letter(l) == Some(joint))?;
        q[joint] = state.rotary[letter]?;
    }
    // A feed in mm/min is that of some of the axes, which only the control knows.
    let time = match state.feed {
        Some(Feed::InverseTime(seconds)) => Some(seconds),
        _ => None,
    };
    Some(BlockPose { command, pose: machine.forward(&q, length), time, timed: time.is_some(), frame: state.frame })
}

/// Pose at the end of a motion, if enough coordinates are programmed.
fn place(machine: &Machine, state: &mut RunFinder, motion: &Motion, command: usize) -> Option<BlockPose> {
    for axis in 0..3 {
        state.tip[axis] = motion.end_base.get(axis);
        if let Some(value) = motion.end_base.get(3 + axis) {
            state.rotary[axis] = Some(value);
        }
    }
    if let Some(axis) = motion.tool_axis_base {
        state.axis = Some(Vector::from(axis).normalize());
    } else if motion.programmed >> 3 & 0b111 != 0 || state.axis.is_none() {
        let mut q = state.q;
        for &joint in machine.rotary_joints() {
            let letter = AXIS_LETTERS[3..6].iter().position(|&l| machine.joint_for_letter(l) == Some(joint))?;
            q[joint] = state.rotary[letter]?;
        }
        state.q = q;
        state.axis = Some(machine.forward(&q, 0.0).axis);
    }
    let [Some(x), Some(y), Some(z)] = state.tip else { return None };
    let tip = Point::new(x, y, z) + state.zero;
    let before = state.last_tip.replace(tip);
    let time = match (state.feed, before) {
        (Some(Feed::InverseTime(seconds)), _) => Some(seconds),
        (Some(Feed::PerTime(rate)), Some(before)) if rate > 0.0 => Some((tip - before).norm() / rate),
        _ => None,
    };
    let timed = matches!(state.feed, Some(Feed::InverseTime(_)));
    Some(BlockPose { command, pose: ToolPose { tip, axis: state.axis? }, time, timed, frame: state.frame })
}

/// Where base coordinates are zero with tool center point control, from the origin of K.
pub(crate) fn base_zero(machine: &Machine) -> Vector {
    machine.program_zero().map_or_else(Vector::zeros, |zero| zero.coords)
}

#[derive(Default)]
struct RunFinder {
    /// Base coordinates count from here in K.
    zero: Vector,
    turning: Option<(usize, WorkFrame)>,
    tcp: bool,
    tool: Option<ToolName>,
    frame: WorkFrame,
    tip: [Option<f64>; 3],
    /// Tip of the motion before, where it was known.
    last_tip: Option<Point>,
    feed: Option<Feed>,
    rotary: [Option<f64>; 3],
    axis: Option<Vector>,
    q: JointValues,
}

impl Default for WorkFrame {
    fn default() -> Self {
        Self::IDENTITY
    }
}

pub(crate) fn fail(location: &Location, code: &'static str, message: String, help: &str) -> Box<ControlError> {
    Box::new(ControlError::at(location, code, message, help))
}
