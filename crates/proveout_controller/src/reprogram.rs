//! Re-scheduling of whole programs: canonical commands in, the same commands with new tool axes out.
//!
//! A *run* is a sequence of straight motions in feed under tool center point control without a rapid, a tool change or a stop
//! between them. Its poses go through a [`Method`]; each motion gets the new tip and axis in the words it was written with
//! (vector or rotary axes). Rapids under tool center point control before a run take the first new axis, those behind it the
//! last one, with the ball center kept; a rapid that turns the rotary axes before tool center point control goes to the first
//! new axis too. Nothing else changes: count and order of the commands, feeds, tools, messages.

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, KinematicsError, Machine};
use proveout_nc::{AXIS_LETTERS, AxisValues, Command, Location, Motion, Op, ToolAction, ToolName};
use proveout_tool::Profile;
use proveout_toolpath::reschedule::{CuttingBlock, CuttingRun, Method, Picture, RescheduleError, Surroundings};

use crate::error::ControlError;

/// Motions of fewer blocks are links and stay as they are.
const SHORTEST_RUN: usize = 8;

/// A program with new tool axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Reprogrammed {
    /// The commands.
    pub commands: Vec<Command>,
    /// The runs that were re-scheduled.
    pub runs: Vec<ReprogrammedRun>,
}

/// A run that was re-scheduled.
#[derive(Clone, Debug, PartialEq)]
pub struct ReprogrammedRun {
    /// Index of the command of each block.
    pub commands: Vec<usize>,
    /// Poses before, in base coordinates.
    pub before: Vec<ToolPose>,
    /// Poses after, in base coordinates.
    pub after: Vec<ToolPose>,
    /// What the method shows of its work.
    pub picture: Picture,
}

/// A motion with its pose in base coordinates.
#[derive(Clone, Copy)]
struct Placed {
    command: usize,
    pose: ToolPose,
    frame: Frame,
}

/// Work to base coordinates, without scale.
#[derive(Clone, Copy)]
struct Frame {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
    rotary: [f64; 3],
}

impl Frame {
    const IDENTITY: Self =
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3], rotary: [0.0; 3] };

    fn turned_back(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|k| self.rotation[k][i] * v[k]).sum())
    }

    fn work_point(&self, p: &Point) -> [f64; 3] {
        self.turned_back(std::array::from_fn(|k| p[k] - self.translation[k]))
    }

    fn is_rigid(&self) -> bool {
        (0..3).all(|a| {
            (0..3).all(|b| {
                let dot: f64 = (0..3).map(|k| self.rotation[a][k] * self.rotation[b][k]).sum();
                (dot - f64::from(u8::from(a == b))).abs() < 1e-9
            })
        })
    }
}

/// A run with the rapids that lead to it and away from it.
#[derive(Default)]
struct Found {
    tool: Option<ToolName>,
    /// The last rapid before tool center point control that turns rotary axes.
    turning: Option<(usize, Frame)>,
    before: Vec<Placed>,
    blocks: Vec<Placed>,
    after: Vec<Placed>,
}

/// What a program is re-scheduled with.
pub struct Reprogramming<'a> {
    /// The machine that runs the program: rotary axes of the program, ranges of its joints.
    pub machine: &'a Machine,
    /// The method.
    pub method: &'a dyn Method,
    /// Cutting end of a tool.
    pub cutter: &'a dyn Fn(&ToolName) -> Option<Profile>,
}

impl Reprogramming<'_> {
    /// The program with new tool axes in every run.
    ///
    /// # Errors
    /// The program has no run, the method refuses one, or a new axis is out of the machine's range; with the first block
    /// concerned.
    pub fn apply(&self, commands: Vec<Command>) -> Result<Reprogrammed, Box<ControlError>> {
        let found = self.runs(&commands)?;
        let mut out = Reprogrammed { commands, runs: Vec::new() };
        for run in found.iter().filter(|run| run.blocks.len() >= SHORTEST_RUN) {
            self.run(run, &mut out)?;
        }
        if out.runs.is_empty() {
            let help = "re-scheduling needs straight feed blocks with TRAORI, G43.4 or M128";
            let message = "the program has no run of blocks under tool center point control".to_owned();
            let location = out.commands.first().map(|c| c.location.clone());
            let code = "reschedule-layers";
            return Err(Box::new(ControlError { code, message, location, help: Some(help.to_owned()) }));
        }
        Ok(out)
    }

    /// Table axis in the frame of the table: of the rotary joint that carries the workpiece; across it sections are cut.
    fn table_axis(&self) -> Vector {
        let carrying = |&&j: &&usize| self.machine.joints[j].carries == proveout_machine::Carries::Workpiece;
        let rotary = self.machine.rotary_joints();
        let joint = rotary.iter().rfind(carrying).or(rotary.first());
        joint.map_or(Vector::z(), |&j| self.machine.joints[j].direction)
    }

    fn runs(&self, commands: &[Command]) -> Result<Vec<Found>, Box<ControlError>> {
        let mut runs = vec![Found::default()];
        let mut state = State { q: self.machine.home(), rotary: [None; 3], ..State::default() };
        for (index, command) in commands.iter().enumerate() {
            match &command.op {
                Op::Tcp(tcp) => {
                    state.tcp = tcp.on;
                    let turning = state.turning.take().filter(|_| tcp.on);
                    runs.push(Found { tool: state.tool.clone(), turning, ..Found::default() });
                }
                Op::Tool(ToolAction::Change(name)) => {
                    state.tool = Some(name.clone());
                    runs.push(Found { tool: state.tool.clone(), ..Found::default() });
                }
                Op::Frame(change) => {
                    let frame =
                        Frame { rotation: change.rotation, translation: change.translation, rotary: change.rotary };
                    state.frame = frame;
                }
                Op::Rapid(motion) | Op::Linear(motion) => {
                    let turns = motion.programmed >> 3 & 0b111 != 0 && !motion.machine_coordinates;
                    if !state.tcp && turns && matches!(command.op, Op::Rapid(_)) {
                        state.turning = Some((index, state.frame));
                    }
                    let placed = self.place(&mut state, motion, index);
                    let Some(placed) = placed.filter(|_| state.tcp && !motion.machine_coordinates) else { continue };
                    if !state.frame.is_rigid() {
                        let message = "a scaled frame is in force".to_owned();
                        return Err(fail(
                            &command.location,
                            "reschedule-path",
                            message,
                            "write the path without SCALE",
                        ));
                    }
                    let feed = matches!(command.op, Op::Linear(_));
                    let fresh = Found { tool: state.tool.clone(), ..Found::default() };
                    let Some(run) = runs.last_mut() else { continue };
                    if feed && run.after.is_empty() {
                        run.blocks.push(placed);
                    } else if feed {
                        runs.push(Found { blocks: vec![placed], ..fresh });
                    } else if run.blocks.is_empty() {
                        run.before.push(placed);
                    } else {
                        run.after.push(placed);
                    }
                }
                Op::Arc(_) | Op::Spline(_) | Op::Thread(_) | Op::Probe(_) if state.tcp => {
                    let message = "only straight blocks can be re-scheduled".to_owned();
                    return Err(fail(
                        &command.location,
                        "reschedule-path",
                        message,
                        "post the path as straight blocks",
                    ));
                }
                _ => {}
            }
        }
        Ok(runs)
    }

    /// Pose at the end of a motion, where the program has told enough.
    fn place(&self, state: &mut State, motion: &Motion, command: usize) -> Option<Placed> {
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
            for &joint in self.machine.rotary_joints() {
                let letter =
                    AXIS_LETTERS[3..6].iter().position(|&l| self.machine.joint_for_letter(l) == Some(joint))?;
                q[joint] = state.rotary[letter]?;
            }
            state.q = q;
            state.axis = Some(self.machine.forward(&q, 0.0).axis);
        }
        let [Some(x), Some(y), Some(z)] = state.tip else { return None };
        Some(Placed { command, pose: ToolPose { tip: Point::new(x, y, z), axis: state.axis? }, frame: state.frame })
    }

    fn run(&self, found: &Found, out: &mut Reprogrammed) -> Result<(), Box<ControlError>> {
        let line = |placed: &Placed| out.commands[placed.command].location.line;
        let run =
            CuttingRun { blocks: found.blocks.iter().map(|b| CuttingBlock { pose: b.pose, line: line(b) }).collect() };
        let first = out.commands[found.blocks[0].command].location.clone();
        let cutter = found.tool.as_ref().and_then(|name| (self.cutter)(name)).ok_or_else(|| {
            let message = format!("the tool of this run is not in the library: {:?}", found.tool);
            fail(&first, "reschedule-tool", message, "add the tool to the library")
        })?;
        let around = Surroundings { cutter: &cutter, table_axis: self.table_axis(), surface: None };
        let result = self.method.reschedule(&run, &around).map_err(|e| Box::new(located(e, &first)))?;
        let ball = cutter.ball_radius().unwrap_or(0.0);
        let kept = |placed: &Placed, axis: &Vector| ToolPose {
            tip: placed.pose.tip + (placed.pose.axis - axis) * ball,
            axis: *axis,
        };
        let mut q = self.machine.home();
        let (Some(start), Some(end)) = (result.poses.first(), result.poses.last()) else { return Ok(()) };
        let before = found.before.iter().map(|p| (p, kept(p, &start.axis)));
        let after = found.after.iter().map(|p| (p, kept(p, &end.axis)));
        let new: Vec<(&Placed, ToolPose)> =
            before.chain(found.blocks.iter().zip(result.poses.iter().copied())).chain(after).collect();
        for (k, (placed, pose)) in new.into_iter().enumerate() {
            self.rewrite(out, placed, &pose, &mut q)?;
            if let Some((command, frame)) = found.turning.filter(|_| k == 0) {
                self.turn_first(out, command, &frame, &q);
            }
        }
        out.runs.push(ReprogrammedRun {
            commands: found.blocks.iter().map(|b| b.command).collect(),
            before: found.blocks.iter().map(|b| b.pose).collect(),
            after: result.poses,
            picture: result.picture,
        });
        Ok(())
    }

    fn rewrite(
        &self,
        out: &mut Reprogrammed,
        placed: &Placed,
        pose: &ToolPose,
        q: &mut JointValues,
    ) -> Result<(), Box<ControlError>> {
        let Some(command) = out.commands.get_mut(placed.command) else { return Ok(()) };
        let location = &command.location;
        // Slides depend on the length of the tool and are judged when the program runs.
        *q = match self.machine.inverse_nearest(pose, 0.0, q) {
            Ok(solution) => solution.q,
            Err(KinematicsError::OverTravel { rotary: false, solution, .. }) => solution.q,
            Err(e) => {
                let help = "choose another clearance or tilt of the head, or a machine with a wider range";
                return Err(fail(
                    location,
                    "reschedule-range",
                    format!("the new orientation is out of reach: {e}"),
                    help,
                ));
            }
        };
        let (Op::Rapid(motion) | Op::Linear(motion)) = &mut command.op else { return Ok(()) };
        let mut changed = 0;
        put(&mut motion.end, &mut motion.end_base, &mut changed, placed.frame.work_point(&pose.tip), &pose.tip);
        if motion.tool_axis.is_some() {
            motion.tool_axis = Some(placed.frame.turned_back(pose.axis.into()));
            motion.tool_axis_base = Some(pose.axis.into());
        } else {
            for &joint in self.machine.rotary_joints() {
                let letter = AXIS_LETTERS[3..6].iter().position(|&l| self.machine.joint_for_letter(l) == Some(joint));
                let Some(letter) = letter else { continue };
                let work = q[joint] - placed.frame.rotary[letter];
                if motion.end.get(3 + letter).is_none_or(|old| (old - work).abs() > 1e-12) {
                    changed |= 1 << (3 + letter);
                }
                motion.end.put(3 + letter, work);
                motion.end_base.put(3 + letter, q[joint]);
            }
        }
        motion.programmed |= changed;
        Ok(())
    }
}

impl Reprogramming<'_> {
    /// Sends a rapid of the rotary axes to where the first new axis wants them.
    fn turn_first(&self, out: &mut Reprogrammed, command: usize, frame: &Frame, q: &JointValues) {
        let Some(Op::Rapid(motion)) = out.commands.get_mut(command).map(|c| &mut c.op) else { return };
        for &joint in self.machine.rotary_joints() {
            let letter = (3..6).find(|&l| self.machine.joint_for_letter(AXIS_LETTERS[l]) == Some(joint));
            if let Some(letter) = letter.filter(|&l| motion.programmed >> l & 1 == 1) {
                motion.end.put(letter, q[joint] - frame.rotary[letter - 3]);
                motion.end_base.put(letter, q[joint]);
            }
        }
    }
}

/// Writes a tip into work and base coordinates and notes the axes that have changed.
fn put(end: &mut AxisValues, base: &mut AxisValues, changed: &mut u16, work: [f64; 3], tip: &Point) {
    for axis in 0..3 {
        if end.get(axis).is_none_or(|old| (old - work[axis]).abs() > 1e-9) {
            *changed |= 1 << axis;
        }
        end.put(axis, work[axis]);
        base.put(axis, tip[axis]);
    }
}

#[derive(Default)]
struct State {
    turning: Option<(usize, Frame)>,
    tcp: bool,
    tool: Option<ToolName>,
    frame: Frame,
    tip: [Option<f64>; 3],
    rotary: [Option<f64>; 3],
    axis: Option<Vector>,
    q: JointValues,
}

impl Default for Frame {
    fn default() -> Self {
        Self::IDENTITY
    }
}

fn fail(location: &Location, code: &'static str, message: String, help: &str) -> Box<ControlError> {
    Box::new(ControlError::at(location, code, message, help))
}

fn located(error: RescheduleError, first: &Location) -> ControlError {
    let line = if error.line > 0 { error.line } else { first.line };
    let location = Location { line, column: 1, length: 0, ..first.clone() };
    ControlError { code: error.code, message: error.message, location: Some(location), help: Some(error.help) }
}
