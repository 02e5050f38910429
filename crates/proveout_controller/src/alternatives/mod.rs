//! All schedules of tool axes that were possible in a run, as gates of joints: a bound of the time
//! refers to them.
//!
//! *What all of them share.* The blocks and their programmed times (inverse time, since with a feed
//! of the tip the time would depend on the axes). The inclination of the tool axis to the table
//! axis, and the branch of the inverse kinematics, at each end of a block. Then the angle about the
//! table axis is the table's joint except for sign and zero, and the joints that incline the tool
//! go through the same positions in all of them.
//!
//! *What the control may do.* It may leave the programmed rotary positions by its rounding of the
//! orientation, which widens every gate, and the tip by its rounding of the tip.
//!
//! *Methods without a channel of one angle*: axes may be anywhere within the largest angle by which
//! the method turned an axis of the original program (`two_angles.rs`).

mod linear;
mod two_angles;

pub use two_angles::TwoAngles;

use proveout_geom::{Point, ToolPose};
use proveout_machine::{Carries, JointValues, KinematicsError, Machine};
use proveout_nc::{Command, Op, PathMode};
use proveout_reschedule::{JointGates, Rescheduled, Schedules, SwingLimits, TurnChannel};

use linear::{AtGate, linear_gates};

use crate::{Settings, program_runs::RunBlocks};

/// By how much a joint may be off what the angles of a method say, radian: rounding of sums.
const ROUNDED: f64 = 1e-6;
/// By how much the sense of a table that turns with the angles may be off one.
const ALONG: f64 = 1e-9;

/// The schedules of a run, and where its programs are among them.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternatives {
    /// Programmed time of each block of the stretch but its first, which only begins it, and gates of the
    /// rotary joints that are widened by [`Self::rounding`].
    pub schedules: Schedules,
    /// What the control may leave programmed rotary positions by, radian.
    pub rounding: f64,
    /// Positions of these joints at the gates, in the program before and after: `[joint][gate]`, radian.
    pub before: Vec<Vec<f64>>,
    /// The same of the new program.
    pub after: Vec<Vec<f64>>,
    /// What the control may leave the tip by (the linear joints of a program without tool center point
    /// control), mm.
    pub tip_rounding: f64,
    /// Where the programmed feed leads in the program before and in the new one: the tip at the gates in the
    /// table frame, without tool center point control the linear joints, mm.
    pub ways: [Vec<Point>; 2],
    /// The joint of the channel, by its place in [`Self::schedules`].
    pub table: Option<usize>,
    /// Gates of the linear joints over all angles of the channel, mm.
    pub linear: Vec<JointGates>,
    /// Schedules with both angles free, where the method knows no channel of one.
    pub two_angles: Option<TwoAngles>,
}

/// What a run is given to the control with.
pub(crate) struct ScheduleRun<'a> {
    pub(crate) found: &'a RunBlocks,
    /// What the control may leave tip (mm) and rotary joints (radian) by.
    pub(crate) rounding: [f64; 2],
    /// Radius of the ball, zero for other cutters, and gauge length of the tool where it is known, mm.
    pub(crate) ball: f64,
    pub(crate) length: Option<f64>,
}

impl Alternatives {
    pub(crate) fn new(
        machine: &Machine,
        run: &ScheduleRun<'_>,
        result: &Rescheduled,
        joints: &[JointValues],
    ) -> Result<Self, &'static str> {
        let ScheduleRun { found, rounding: [tip_rounding, rounding], .. } = *run;
        let stretch = result.stretch.clone();
        let (Some(blocks), Some(after)) = (found.blocks.get(stretch.clone()), joints.get(stretch)) else {
            return Err("the stretch is not in the run");
        };
        let least: Option<Vec<f64>> = blocks.iter().skip(1).map(|b| b.time).collect();
        let Some(least) = least.filter(|t| t.iter().all(|t| t.is_finite() && *t > 0.0)) else {
            return Err("the program gives some block no feed");
        };
        if !blocks.iter().skip(1).all(|b| b.timed) {
            return Err(
                "the feed applies to the tip, whose path depends on the tool axes: program it by inverse time \
                        (G93)",
            );
        }
        let Some(before) = positions(machine, found, result.stretch.start) else {
            return Err("the original program is out of the machine's range");
        };
        let poses: Vec<ToolPose> = blocks.iter().map(|b| b.pose).collect();
        let new_poses = result.poses.get(result.stretch.clone()).ok_or("the stretch is not in the run")?;
        let way = |poses: &[ToolPose], joints: &[JointValues]| -> Vec<Point> {
            if found.joints.is_none() {
                return poses.iter().map(|p| p.tip).collect();
            }
            let slides = machine.linear_joints();
            let place = |q: &JointValues| Point::from(std::array::from_fn(|k| slides.get(k).map_or(0.0, |&j| q[j])));
            joints.iter().map(place).collect()
        };
        let ways = [way(&poses, &before[..after.len()]), way(new_poses, after)];
        let (mut table, mut linear) = (None, Vec::new());
        let mut gates = Vec::new();
        let mut positions = [Vec::new(), Vec::new()];
        for &j in machine.rotary_joints() {
            let joint = &machine.joints[j];
            let Some(velocity) = joint.max_velocity else { continue };
            let own: Vec<f64> = after.iter().map(|q| q[j]).collect();
            let free = result.channel.as_ref().filter(|_| is_table(machine, j));
            let limits = match free {
                Some(channel) => turned(joint.sense * joint.direction.dot(&channel.axis), channel, &own)?,
                // Without a channel nothing is known of what else this joint might have done.
                None if result.channel.is_none() => continue,
                None => own.iter().map(|q| [*q; 2]).collect(),
            };
            let widened: Vec<[f64; 2]> = limits.iter().map(|[low, high]| [low - rounding, high + rounding]).collect();
            if free.is_some() {
                table = Some(gates.len());
                let places = new_poses.iter().zip(after).zip(&widened);
                let at: Vec<AtGate<'_>> =
                    places.map(|((pose, joints), table)| AtGate { pose, joints, table: *table }).collect();
                let known = run.length.filter(|_| run.ball > 0.0);
                let own = known.and_then(|l| linear_gates(machine, j, &at, (run.ball, l), (tip_rounding, rounding)));
                linear = own.unwrap_or_default();
            }
            gates.push(JointGates {
                name: joint.name.clone(),
                limits: SwingLimits {
                    velocity,
                    acceleration: joint.max_acceleration.unwrap_or(f64::INFINITY),
                    jerk: joint.max_jerk.unwrap_or(f64::INFINITY),
                },
                gates: widened,
            });
            let mut old: Vec<f64> = before[..own.len()].iter().map(|q| q[j]).collect();
            // The original program may be whole turns away.
            let turn = std::f64::consts::TAU;
            let away = old.first().zip(own.first()).map_or(0.0, |(a, b)| turn * ((a - b) / turn).round());
            old.iter_mut().for_each(|q| *q -= away);
            positions[0].push(old);
            positions[1].push(own);
        }
        let two_angles = match result.channel {
            Some(_) => None,
            None => TwoAngles::new(machine, [&poses, new_poses], [&before[..after.len()], after], rounding),
        };
        let [before, after] = positions;
        let schedules = Schedules { least, joints: gates };
        Ok(Self { schedules, rounding, before, after, tip_rounding, ways, table, linear, two_angles })
    }
}

/// Joint positions of the program before, from a block on to the end.
fn positions(machine: &Machine, found: &RunBlocks, from: usize) -> Option<Vec<JointValues>> {
    let mut q = machine.home();
    let mut all = Vec::with_capacity(found.blocks.len());
    for block in &found.blocks {
        q = match machine.inverse_nearest(&block.pose, found.joints.unwrap_or(0.0), &q) {
            Ok(solution) => solution.q,
            Err(KinematicsError::OverTravel { rotary: false, solution, .. }) => solution.q,
            Err(_) => return None,
        };
        all.push(q);
    }
    Some(all.split_off(from))
}

/// The rotary joint that carries the workpiece.
fn is_table(machine: &Machine, joint: usize) -> bool {
    machine.work_chain.iter().rfind(|&&j| machine.joints[j].is_rotary()) == Some(&joint)
        && machine.joints[joint].carries == Carries::Workpiece
}

/// Limits of angles as limits of the table's joint, whose physical motion is `sense` times its value about
/// the axis of the angles. The tool turns against the table: a growing angle is a motion of the table the
/// other way.
fn turned(sense: f64, channel: &TurnChannel, joint: &[f64]) -> Result<Vec<[f64; 2]>, &'static str> {
    const APART: &str = "the table's joint does not turn as the angles of the channel do";
    let (Some(&zero), Some(&first)) = (joint.first(), channel.angles.first()) else { return Ok(Vec::new()) };
    if (sense.abs() - 1.0).abs() > ALONG || joint.len() != channel.angles.len() || joint.len() != channel.limits.len() {
        return Err(APART);
    }
    let place = |angle: f64| zero - sense.signum() * (angle - first);
    if joint.iter().zip(&channel.angles).any(|(q, angle)| (place(*angle) - q).abs() > ROUNDED) {
        return Err(APART);
    }
    let both = |limits: &[f64; 2]| {
        let [a, b] = limits.map(place);
        [a.min(b), a.max(b)]
    };
    Ok(channel.limits.iter().map(both).collect())
}

/// The most by which the control may leave the tip (mm) and the rotary positions (radian) of a run;
/// `tip` applies where the program sets no tolerance.
pub(crate) fn rounding(machine: &Machine, tip: Option<f64>, commands: &[Command], found: &RunBlocks) -> [f64; 2] {
    let (Some(first), Some(last)) = (found.blocks.first(), found.blocks.last()) else { return [0.0; 2] };
    let own = |mode: &PathMode| match mode {
        PathMode::ExactStop => [0.0; 2],
        PathMode::Continuous { tolerance, orientation_tolerance } => [
            tolerance.or(tip).unwrap_or(machine.control.default_tolerance),
            orientation_tolerance
                .or(machine.control.default_orientation_tolerance)
                .unwrap_or(Settings::FALLBACK_ORIENTATION_TOLERANCE),
        ],
    };
    let mut now = PathMode::Continuous { tolerance: None, orientation_tolerance: None };
    let mut most = [0.0_f64; 2];
    for (index, command) in commands.iter().enumerate().take(last.command + 1) {
        if let Op::PathMode(mode) = &command.op {
            now = *mode;
        }
        if index >= first.command {
            most = std::array::from_fn(|k| most[k].max(own(&now)[k]));
        }
    }
    most
}
