//! Re-scheduling of whole programs: canonical commands in, the same commands with new tool axes out.
//!
//! The poses of each [run](crate::ProgramRun) go through a [`Method`]; each motion gets the new tip
//! and axis in the words it was written with (vector or rotary axes). Under tool center point
//! control, rapids before a run take its first new axis and rapids after it the last one, with the
//! ball center kept. Between two runs the axis turns from one to the other after the first and
//! before the last of the rapids. A rapid that turns the rotary axes before tool center point
//! control goes to the first new axis too. Nothing else changes: count and order of the commands,
//! feeds, tools, messages.
//!
//! A program that never switches tool center point control on is rewritten in positions of its
//! axes, which follow from the new poses and the length of the tool; its blocks must turn rotary
//! axes.

mod excerpt;

use std::ops::Range;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, KinematicsError, Machine};
use proveout_nc::{AXIS_LETTERS, AxisValues, Command, Location, Offset, Op, ToolName};
use proveout_reschedule::{
    ContactSurface, CuttingBlock, CuttingRun, FeasibleRegion, Method, RescheduleError, Study, Surroundings, TimeLaw,
    slerp,
};
use proveout_tool::Profile;

use crate::{
    alternatives::{Alternatives, ScheduleRun, rounding},
    error::ControlError,
    program_runs::{BlockPose, ProgramBlock, RunBlocks, WorkFrame, base_zero, fail, find_runs, length_at_zero},
};

/// Motions of fewer blocks are links and stay as they are.
const SHORTEST_RUN: usize = 8;
/// A rotary axis that is this near to where it was has not changed, radian.
const SAME_ANGLE: f64 = 1e-12;
/// A linear axis that is this near to where it was has not changed, mm.
const SAME_MM: f64 = 1e-9;

/// Axes of a run without tool center point control that stay within this do not turn, radian.
const SAME_AXIS: f64 = 1e-9;
/// How near slides must bring the tip to where it shall be, mm.
const SLIDES: f64 = 1e-6;

/// A rotary joint that turns by more than this between two blocks rewinds for lack of travel,
/// degrees: the orientation of the block is one whole turn away. Passing a singular position turns
/// by half of that at most.
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
    /// The blocks, by their place in the lists above, that cut: without lead-in and lead-out. What programs
    /// are compared on.
    pub stretch: Range<usize>,
    /// What the method shows of its work.
    pub study: Study,
    /// All possible schedules of the stretch, or the reason why they are not available.
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
    /// Rounding of the tip by the control where a program sets none, mm; none for the machine's
    /// own.
    pub tip_tolerance: Option<f64>,
    /// Gauge length of a tool, mm: for programs without tool center point control, and for what their slides
    /// do.
    pub length: &'a dyn Fn(&ToolName) -> Option<f64>,
    /// The surface that is cut, in the table frame K.
    pub surface: Option<&'a dyn ContactSurface>,
    /// What a tool must not touch, in the table frame K; asked for where the method needs it.
    pub region: &'a dyn Fn(&ToolName) -> Option<Box<dyn FeasibleRegion>>,
    /// What the control takes for a program, for methods that are led by it; none where it is not asked.
    pub times: Option<&'a BlockTimes<'a>>,
}

/// Times of the blocks in feed that a control takes for commands, s: one list for each sequence of blocks
/// without a rapid or a tool change between them; none where it refuses the program.
pub type BlockTimes<'a> = dyn Fn(Vec<Command>) -> Option<Vec<Vec<f64>>> + 'a;

/// Regions of tools, as far as they were asked for.
type Regions = Vec<(ToolName, Option<Box<dyn FeasibleRegion>>)>;

/// The time law of the control for one run, with the program unchanged.
struct RunTimes<'a> {
    work: &'a Reprogramming<'a>,
    times: &'a BlockTimes<'a>,
    found: &'a RunBlocks,
    commands: &'a [Command],
    ball: f64,
    /// Runs before it with as many blocks.
    alike: usize,
    /// The commands that are asked about first.
    excerpt: Option<Vec<bool>>,
    link: Option<RapidLink<'a>>,
}

/// The rapids from the run before, which ends with the axis `from`.
#[derive(Clone, Copy)]
struct RapidLink<'a> {
    rapids: &'a [BlockPose],
    from: Vector,
}

impl RapidLink<'_> {
    /// Axes at the ends of the rapids: out with the old one, turning on the way, in with the new one.
    fn axes(&self, to: &Vector) -> Vec<Vector> {
        let count = self.rapids.len();
        let mut way = vec![0.0; count];
        for i in 1..count {
            // Into the part, and out of it, nothing turns.
            let turns = i + 1 < count || count <= 2;
            let step = (self.rapids[i].pose.tip - self.rapids[i - 1].pose.tip).norm();
            way[i] = way[i - 1] + if turns { step } else { 0.0 };
        }
        let total = way.last().copied().unwrap_or(0.0);
        let part = |s: f64| if total > 0.0 { s / total } else { 1.0 };
        way.into_iter().map(|s| slerp(&self.from, to, part(s))).collect()
    }
}

impl TimeLaw for RunTimes<'_> {
    fn block_times(&self, poses: &[ToolPose]) -> Option<Vec<f64>> {
        self.joint_times(poses, None)
    }

    fn joint_times(&self, poses: &[ToolPose], rotary: Option<&[JointValues]>) -> Option<Vec<f64>> {
        let mut commands = self.commands.to_vec();
        self.work.rewritten(&mut commands, (self.found, self.link), poses, rotary, self.ball).ok()?;
        let of = |runs: Vec<Vec<f64>>, alike: usize| {
            runs.into_iter().filter(|run| run.len() == self.found.blocks.len()).nth(alike)
        };
        let near = self.excerpt.as_ref().and_then(|keep| {
            let near = commands.iter().zip(keep).filter(|(_, keep)| **keep).map(|(c, _)| c.clone());
            of((self.times)(near.collect())?, 0)
        });
        near.or_else(|| of((self.times)(commands)?, self.alike))
    }
}

impl Reprogramming<'_> {
    /// The program with new tool axes in every run.
    ///
    /// # Errors
    /// The program has no run, the method refuses one, or a new axis is out of the machine's range; with the
    /// first block concerned.
    pub fn apply(&self, commands: Vec<Command>) -> Result<Reprogrammed, Box<ControlError>> {
        let delta = |c: &&Command| matches!(c.op, Op::Offset(Offset::ToolDelta { length, .. }) if length != 0.0);
        if let Some(delta) = commands.iter().find(delta) {
            let message =
                "a delta value of the tool length is in force: the tip is not where the program says".to_owned();
            let help = "write the path for the tool itself, without DL";
            return Err(fail(&delta.location, "reschedule-path", message, help));
        }
        let found = find_runs(self.machine, &commands, Some(self.length))?;
        let long = |run: &RunBlocks| run.blocks.len() >= SHORTEST_RUN && turns(run);
        let found: Vec<(usize, &RunBlocks)> = found.iter().enumerate().filter(|(_, run)| long(run)).collect();
        let rows: Vec<CuttingRun> = found.iter().map(|(_, run)| cutting_run(run, &commands)).collect();
        let mut out = Reprogrammed { commands, runs: Vec::new() };
        let mut regions = Vec::new();
        for (row, &(place, run)) in found.iter().enumerate() {
            // Rapids from the run before belong to both.
            let link = row.checked_sub(1).and_then(|k| {
                let &(at, last) = found.get(k)?;
                let from = out.runs.last()?.after.last()?.axis;
                (at + 1 == place && run.linked).then_some(RapidLink { rapids: &last.after, from })
            });
            self.run(run, (&rows, row), link, (&mut regions, &mut out))?;
        }
        if out.runs.is_empty() {
            let help = "re-scheduling needs straight feed blocks with TRAORI, G43.4 or M128, or blocks that turn rotary axes without it";
            let message =
                "the program has no run of blocks under tool center point control, and none that turn rotary axes without it"
                    .to_owned();
            let location = out.commands.first().map(|c| c.location.clone());
            let code = "reschedule-layers";
            return Err(Box::new(ControlError { code, message, location, help: Some(help.to_owned()) }));
        }
        Ok(out)
    }

    /// What a tool must not touch; meshes and search trees are made once for each tool.
    fn region_of<'r>(&self, name: &ToolName, regions: &'r mut Regions) -> Option<&'r dyn FeasibleRegion> {
        let at = regions.iter().position(|(of, _)| of == name).unwrap_or_else(|| {
            regions.push((name.clone(), (self.region)(name)));
            regions.len() - 1
        });
        regions.get(at)?.1.as_deref()
    }

    /// Table axis in the frame of the table: of the rotary joint that carries the workpiece; across it
    /// sections are cut.
    fn table_axis(&self) -> Vector {
        let carrying = |&&j: &&usize| self.machine.joints[j].carries == proveout_machine::Carries::Workpiece;
        let rotary = self.machine.rotary_joints();
        let joint = rotary.iter().find(carrying).or(rotary.first());
        joint.map_or(Vector::z(), |&j| self.machine.joints[j].direction)
    }

    fn run(
        &self,
        found: &RunBlocks,
        (rows, row): (&[CuttingRun], usize),
        link: Option<RapidLink<'_>>,
        (regions, out): (&mut Regions, &mut Reprogrammed),
    ) -> Result<(), Box<ControlError>> {
        let run = cutting_run(found, &out.commands);
        let first = out.commands[found.blocks[0].command].location.clone();
        let cutter = found.tool.as_ref().and_then(|name| (self.cutter)(name)).ok_or_else(|| {
            let message = format!("the tool of this run is not in the library: {:?}", found.tool);
            fail(&first, "reschedule-tool", message, "add the tool to the library")
        })?;
        let region = found.tool.as_ref().filter(|_| self.method.needs_region());
        let region = region.and_then(|name| self.region_of(name, regions));
        let ball = cutter.ball_radius().unwrap_or(0.0);
        let alike = out.runs.iter().filter(|run| run.commands.len() == found.blocks.len()).count();
        let ends = [found.blocks.first(), found.blocks.last()].map(|b| b.map_or(0, |b| b.command));
        let law = self.times.map(|times| {
            let commands = &out.commands[..];
            let excerpt = excerpt::excerpt(commands, ends);
            RunTimes { work: self, times, found, commands, ball, alike, excerpt, link }
        });
        let around = Surroundings {
            machine: Some(self.machine),
            surface: self.surface,
            region,
            time_law: law.as_ref().map(|law| law as &dyn TimeLaw),
            vectors: first_vector(&out.commands, found).is_some(),
            rows,
            row,
            ..Surroundings::new(&cutter, self.table_axis())
        };
        let result = self.method.reschedule(&run, &around).map_err(|e| Box::new(located(e, &first)))?;
        if result.rotary.is_some() {
            refuse_vectors(out, found)?;
        }
        let joints = self.rewritten(&mut out.commands, (found, link), &result.poses, result.rotary.as_deref(), ball)?;
        let rounding = rounding(self.machine, self.tip_tolerance, &out.commands, found);
        let length = found.joints.or_else(|| (self.length)(found.tool.as_ref()?));
        let run = ScheduleRun { found, rounding, ball, length };
        let alternatives = Alternatives::new(self.machine, &run, &result, &joints);
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

    /// Puts new poses of a run into its commands, with what leads to it and away from it: positions of the
    /// joints at its blocks.
    fn rewritten(
        &self,
        commands: &mut [Command],
        (found, link): (&RunBlocks, Option<RapidLink<'_>>),
        poses: &[ToolPose],
        rotary: Option<&[JointValues]>,
        ball: f64,
    ) -> Result<Vec<JointValues>, Box<ControlError>> {
        let kept = |placed: &BlockPose, axis: &Vector| ToolPose {
            tip: placed.pose.tip + (placed.pose.axis - axis) * ball,
            axis: *axis,
        };
        let mut q = self.machine.home();
        let mut joints = Vec::with_capacity(found.blocks.len());
        let (Some(start), Some(end)) = (poses.first(), poses.last()) else { return Ok(joints) };
        let lead = match link {
            Some(link) => link.rapids.iter().zip(link.axes(&start.axis)).map(|(p, axis)| (p, kept(p, &axis))).collect(),
            None => found.before.iter().map(|p| (p, kept(p, &start.axis))).collect::<Vec<_>>(),
        };
        let own = lead.len()..lead.len() + found.blocks.len();
        let after = found.after.iter().map(|p| (p, kept(p, &end.axis)));
        let new: Vec<(&BlockPose, ToolPose)> =
            lead.into_iter().chain(found.blocks.iter().zip(poses.iter().copied())).chain(after).collect();
        for (k, (placed, pose)) in new.into_iter().enumerate() {
            let last = q;
            let rotary_pose = own.contains(&k).then(|| rotary?.get(k - own.start)).flatten();
            self.rewrite(commands, placed, (&pose, rotary_pose, found.joints), &mut q)?;
            if k > 0
                && let Some(command) = commands.get(placed.command)
            {
                self.refuse_rewind(&command.location, &last, &q)?;
            }
            if own.contains(&k) {
                joints.push(q);
            }
            if let Some((command, frame)) = found.turning.filter(|_| k == 0) {
                self.turn_first(commands, command, &frame, &q);
            }
        }
        Ok(joints)
    }

    /// Between two blocks a joint with end stops may have to turn back by a whole turn to go on: in a cut
    /// that is out of range.
    fn refuse_rewind(&self, location: &Location, last: &JointValues, q: &JointValues) -> Result<(), Box<ControlError>> {
        for &j in self.machine.rotary_joints() {
            let joint = &self.machine.joints[j];
            let turned = (q[j] - last[j]).to_degrees();
            if let Some([low, high]) = joint.travel.filter(|_| turned.abs() > REWIND_DEG) {
                let message = format!(
                    "the new orientation is out of reach: {} is at {:.1} degrees and would have to turn back by {:.0} degrees to \
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
        commands: &mut [Command],
        placed: &BlockPose,
        (pose, rotary_pose, length): (&ToolPose, Option<&JointValues>, Option<f64>),
        q: &mut JointValues,
    ) -> Result<(), Box<ControlError>> {
        let Some(command) = commands.get_mut(placed.command) else { return Ok(()) };
        let location = &command.location;
        let rotary_pose = match (rotary_pose, length) {
            (Some(rotary_pose), Some(length)) => {
                Some(self.with_slides(rotary_pose, pose, length).ok_or_else(|| {
                    let message = "the slides of the machine cannot bring the tip to its position".to_owned();
                    fail(
                        location,
                        "reschedule-path",
                        message,
                        "the method is for machines with straight slides X, Y and Z",
                    )
                })?)
            }
            (rotary_pose, _) => rotary_pose.copied(),
        };
        // Slides depend on the length of the tool and are judged when the program runs.
        let reached = |q: &JointValues| self.machine.inverse_nearest(pose, length.unwrap_or(0.0), q).map(|s| s.q);
        *q = match rotary_pose.map_or_else(|| reached(q), Ok) {
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
        let tip_in_base = match length {
            None => pose.tip - base_zero(self.machine),
            Some(length) => {
                let shift = length_at_zero(self.machine, length);
                let slide = |k: usize| self.machine.joint_for_letter(AXIS_LETTERS[k]).map_or(0.0, |j| q[j]);
                Point::new(slide(0), slide(1), slide(2)) - shift
            }
        };
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
                if motion.end.get(3 + letter).is_none_or(|old| (old - work).abs() > SAME_ANGLE) {
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
    /// Rotary joints with the slides that bring the tip of a tool to a pose. A slide moves the tip along a
    /// straight line, so that three linear equations are solved.
    fn with_slides(&self, rotary: &JointValues, pose: &ToolPose, length: f64) -> Option<JointValues> {
        let mut joints = [0; 3];
        let mut q = *rotary;
        for (joint, letter) in joints.iter_mut().zip(AXIS_LETTERS) {
            *joint = self.machine.joint_for_letter(letter)?;
            q[*joint] = 0.0;
        }
        let tip = |q: &JointValues| self.machine.forward(q, length).tip;
        let from = tip(&q);
        let [a, b, c] = joints.map(|j| {
            let mut moved = q;
            moved[j] = 1.0;
            tip(&moved) - from
        });
        let to = pose.tip - from;
        let volume = a.dot(&b.cross(&c));
        let parts = [to.dot(&b.cross(&c)), a.dot(&to.cross(&c)), a.dot(&b.cross(&to))];
        for (joint, part) in joints.into_iter().zip(parts) {
            q[joint] = part / volume;
        }
        ((tip(&q) - pose.tip).norm() < SLIDES).then_some(q)
    }

    /// Sends a rapid of the rotary axes to where the first new axis wants them.
    fn turn_first(&self, commands: &mut [Command], command: usize, frame: &WorkFrame, q: &JointValues) {
        let Some(Op::Rapid(motion)) = commands.get_mut(command).map(|c| &mut c.op) else { return };
        for &joint in self.machine.rotary_joints() {
            let letter = (3..6).find(|&l| self.machine.joint_for_letter(AXIS_LETTERS[l]) == Some(joint));
            if let Some(letter) = letter.filter(|&l| motion.programmed >> l & 1 == 1) {
                motion.end.put(letter, q[joint] - frame.rotary[letter - 3]);
                motion.end_base.put(letter, q[joint]);
            }
        }
    }
}

fn cutting_run(found: &RunBlocks, commands: &[Command]) -> CuttingRun {
    let block = |b: ProgramBlock| CuttingBlock { pose: b.pose, line: b.line, time: b.time };
    CuttingRun { blocks: found.placed_blocks(commands).map(block).collect() }
}

/// Whether a run may be rewritten: under tool center point control always, in positions of the axes
/// only if rotary ones turn.
fn turns(run: &RunBlocks) -> bool {
    let Some(first) = run.blocks.first().filter(|_| run.joints.is_some()) else { return run.joints.is_none() };
    run.blocks.iter().any(|b| b.pose.angle_to(&first.pose) > SAME_AXIS)
}

/// A program with tool vectors cannot give the position of a rotary joint at a pole.
fn refuse_vectors(out: &Reprogrammed, found: &RunBlocks) -> Result<(), Box<ControlError>> {
    let Some(command) = first_vector(&out.commands, found) else { return Ok(()) };
    let message = "the block gives a tool vector, which does not define the angle of the table at its pole".to_owned();
    let help = "post the program with rotary axes, or choose another method";
    Err(fail(&command.location, "reschedule-path", message, help))
}

/// The first block of a run that gives a tool vector.
fn first_vector<'a>(commands: &'a [Command], found: &RunBlocks) -> Option<&'a Command> {
    let own = found.blocks.iter().filter_map(|b| commands.get(b.command));
    own.into_iter().find(|c| matches!(&c.op, Op::Linear(motion) if motion.tool_axis.is_some()))
}

/// Writes a tip into work and base coordinates and notes the axes that have changed.
fn put(end: &mut AxisValues, base: &mut AxisValues, changed: &mut u16, work: [f64; 3], tip: &Point) {
    for axis in 0..3 {
        if end.get(axis).is_none_or(|old| (old - work[axis]).abs() > SAME_MM) {
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
