//! Re-scheduling of whole programs: canonical commands in, the same commands with new tool axes out.
//!
//! The poses of each [run](crate::ProgramRun) go through a [`Method`]; each motion gets the new tip and axis in the words it was written with
//! (vector or rotary axes). Rapids under tool center point control before a run take the first new axis, those behind it the
//! last one, with the ball center kept; a rapid that turns the rotary axes before tool center point control goes to the first
//! new axis too. Nothing else changes: count and order of the commands, feeds, tools, messages.

use std::ops::Range;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, KinematicsError, Machine};
use proveout_nc::{AXIS_LETTERS, AxisValues, Command, Location, Op, ToolName};
use proveout_tool::Profile;
use proveout_toolpath::reschedule::{
    ContactSurface, CuttingBlock, CuttingRun, FeasibleRegion, Method, RescheduleError, Study, Surroundings,
};

use crate::{
    alternatives::{Alternatives, rotary_rounding},
    error::ControlError,
    program_runs::{Found, Frame, Placed, ProgramBlock, base_zero, fail, find_runs},
};

/// Motions of fewer blocks are links and stay as they are.
const SHORTEST_RUN: usize = 8;

/// A rotary joint that turns by more than this between two blocks turns back for lack of travel, degrees: the orientation of a
/// block is that of a whole turn before or behind; passing a singular position turns by half of that at most.
const REWIND_DEG: f64 = 270.0;

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
    /// Poses before, in the table frame K.
    pub before: Vec<ToolPose>,
    /// Poses after, in the table frame K.
    pub after: Vec<ToolPose>,
    /// The blocks, by their place in the lists above, that cut: without lead-in and lead-out. What programs are compared on.
    pub stretch: Range<usize>,
    /// What the method shows of its work.
    pub study: Study,
    /// All schedules of the stretch that were possible, or why they cannot be told.
    pub alternatives: Result<Alternatives, &'static str>,
}

/// What a program is re-scheduled with.
pub struct Reprogramming<'a> {
    /// The machine that runs the program: rotary axes of the program, ranges of its joints.
    pub machine: &'a Machine,
    /// The method.
    pub method: &'a dyn Method,
    /// Cutting end of a tool.
    pub cutter: &'a dyn Fn(&ToolName) -> Option<Profile>,
    /// The surface that is cut, in the table frame K.
    pub surface: Option<&'a dyn ContactSurface>,
    /// What a tool must not touch, in the table frame K; asked for where the method needs it.
    pub region: &'a dyn Fn(&ToolName) -> Option<Box<dyn FeasibleRegion>>,
}

impl Reprogramming<'_> {
    /// The program with new tool axes in every run.
    ///
    /// # Errors
    /// The program has no run, the method refuses one, or a new axis is out of the machine's range; with the first block
    /// concerned.
    pub fn apply(&self, commands: Vec<Command>) -> Result<Reprogrammed, Box<ControlError>> {
        let found = find_runs(self.machine, &commands)?;
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
        let joint = rotary.iter().find(carrying).or(rotary.first());
        joint.map_or(Vector::z(), |&j| self.machine.joints[j].direction)
    }

    fn run(&self, found: &Found, out: &mut Reprogrammed) -> Result<(), Box<ControlError>> {
        let block = |b: ProgramBlock| CuttingBlock { pose: b.pose, line: b.line, time: b.time };
        let run = CuttingRun { blocks: found.placed_blocks(&out.commands).map(block).collect() };
        let first = out.commands[found.blocks[0].command].location.clone();
        let cutter = found.tool.as_ref().and_then(|name| (self.cutter)(name)).ok_or_else(|| {
            let message = format!("the tool of this run is not in the library: {:?}", found.tool);
            fail(&first, "reschedule-tool", message, "add the tool to the library")
        })?;
        let region = found.tool.as_ref().filter(|_| self.method.needs_region()).and_then(|name| (self.region)(name));
        let around = Surroundings {
            machine: Some(self.machine),
            surface: self.surface,
            region: region.as_deref(),
            ..Surroundings::new(&cutter, self.table_axis())
        };
        let result = self.method.reschedule(&run, &around).map_err(|e| Box::new(located(e, &first)))?;
        let ball = cutter.ball_radius().unwrap_or(0.0);
        let kept = |placed: &Placed, axis: &Vector| ToolPose {
            tip: placed.pose.tip + (placed.pose.axis - axis) * ball,
            axis: *axis,
        };
        let mut q = self.machine.home();
        let mut joints = Vec::with_capacity(found.blocks.len());
        let (Some(start), Some(end)) = (result.poses.first(), result.poses.last()) else { return Ok(()) };
        let before = found.before.iter().map(|p| (p, kept(p, &start.axis)));
        let after = found.after.iter().map(|p| (p, kept(p, &end.axis)));
        let new: Vec<(&Placed, ToolPose)> =
            before.chain(found.blocks.iter().zip(result.poses.iter().copied())).chain(after).collect();
        if result.rotary.is_some() {
            refuse_vectors(out, found)?;
        }
        let own = found.before.len()..found.before.len() + found.blocks.len();
        for (k, (placed, pose)) in new.into_iter().enumerate() {
            let last = q;
            let told = own.contains(&k).then(|| result.rotary.as_ref()?.get(k - own.start)).flatten();
            self.rewrite(out, placed, (&pose, told), &mut q)?;
            if k > 0 {
                self.refuse_rewind(&out.commands[placed.command].location, &last, &q)?;
            }
            if own.contains(&k) {
                joints.push(q);
            }
            if let Some((command, frame)) = found.turning.filter(|_| k == 0) {
                self.turn_first(out, command, &frame, &q);
            }
        }
        let rounding = rotary_rounding(self.machine, &out.commands, found);
        let alternatives = Alternatives::new(self.machine, found, &result, &joints, rounding);
        out.runs.push(ReprogrammedRun {
            commands: found.blocks.iter().map(|b| b.command).collect(),
            before: found.blocks.iter().map(|b| b.pose).collect(),
            after: result.poses,
            stretch: result.stretch,
            study: result.study,
            alternatives,
        });
        Ok(())
    }

    /// Between two blocks a joint with end stops may have to turn back by a whole turn to go on: in a cut that is out of range.
    fn refuse_rewind(&self, location: &Location, last: &JointValues, q: &JointValues) -> Result<(), Box<ControlError>> {
        for &j in self.machine.rotary_joints() {
            let joint = &self.machine.joints[j];
            let turned = (q[j] - last[j]).to_degrees();
            if let Some([low, high]) = joint.travel.filter(|_| turned.abs() > REWIND_DEG) {
                let message = format!(
                    "the new orientation is out of reach: {} stands at {:.1} degrees and would have to turn back by {:.0} degrees to \
                     stay in its travel of {:.1} to {:.1} degrees",
                    joint.name,
                    last[j].to_degrees(),
                    turned.abs(),
                    low.to_degrees(),
                    high.to_degrees()
                );
                let help =
                    "split the path before this block, or take a machine with a wider range or without end stops";
                return Err(fail(location, "reschedule-range", message, help));
            }
        }
        Ok(())
    }

    fn rewrite(
        &self,
        out: &mut Reprogrammed,
        placed: &Placed,
        (pose, told): (&ToolPose, Option<&JointValues>),
        q: &mut JointValues,
    ) -> Result<(), Box<ControlError>> {
        let Some(command) = out.commands.get_mut(placed.command) else { return Ok(()) };
        let location = &command.location;
        // Slides depend on the length of the tool and are judged when the program runs.
        *q = match told.map_or_else(|| self.machine.inverse_nearest(pose, 0.0, q).map(|s| s.q), |q| Ok(*q)) {
            Ok(q) => q,
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
        let tip_in_base = pose.tip - base_zero(self.machine);
        let work = placed.frame.work_point(&tip_in_base);
        put(&mut motion.end, &mut motion.end_base, &mut changed, work, &tip_in_base);
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

/// A program with tool vectors cannot say where a rotary joint stands at a pole.
fn refuse_vectors(out: &Reprogrammed, found: &Found) -> Result<(), Box<ControlError>> {
    let commands = found.blocks.iter().filter_map(|b| out.commands.get(b.command));
    for command in commands {
        if let Op::Linear(motion) = &command.op
            && motion.tool_axis.is_some()
        {
            let message =
                "the block gives a tool vector, which does not tell where the table stands at its pole".to_owned();
            let help = "post the program with rotary axes, or choose another method";
            return Err(fail(&command.location, "reschedule-path", message, help));
        }
    }
    Ok(())
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

fn located(error: RescheduleError, first: &Location) -> ControlError {
    let line = if error.line > 0 { error.line } else { first.line };
    let location = Location { line, column: 1, length: 0, ..first.clone() };
    ControlError { code: error.code, message: error.message, location: Some(location), help: Some(error.help) }
}
