//! A re-scheduled program compared with the one that it is made from, block by block: what a person
//! looks at.
//!
//! *Times* are those at which the new program ends its blocks. The program before is shown at the
//! same blocks, so that both can be compared place by place. *Positions* are those of the joints at
//! the ends of blocks, whole turns between the programs taken out. Velocity and acceleration are
//! what the program asks for at its programmed feed, as in a comparison. *The channel* of a joint
//! is made of its gates without what the control rounds off.

use std::ops::Range;

use proveout_controller::ReprogrammedRun;
use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::Machine;

use crate::{
    compare::{
        certificate::{RunCertificate, blocks_of, certify},
        study_of,
    },
    observe::study::StudyCurve,
    prepare::{
        error::SimError,
        motion_only::{FeedBlock, Motion, MotionCase},
        prepared::Prepared,
    },
    scene::joint_limits::ChangedLimit,
};

pub use crate::observe::schedule_rows::{
    Demand, MethodCurve, Schedule, ScheduleBound, ScheduledBlock, ScheduledJoint, ScheduledRun,
};

/// A joint whose gates are nowhere wider than this has no choice, radian.
const NO_CHOICE: f64 = 1e-6;

impl ScheduleBound {
    pub(crate) fn of(found: &RunCertificate) -> Self {
        Self {
            time: found.time_s,
            original_time: found.original_time_s,
            bound: found.bound_s,
            gap_percent: found.gap_percent,
        }
    }
}

/// Blocks of each run of a motion.
type Blocks<'a> = Vec<Option<&'a [FeedBlock]>>;

/// Motions of the two programs.
#[derive(Clone, Copy)]
pub(crate) struct Motions<'a> {
    /// By the planned set points: new, before.
    pub(crate) planned: [&'a Motion; 2],
    /// Along the programmed path: new, before.
    pub(crate) ideal: [&'a Motion; 2],
}

impl Schedule {
    /// The schedule of a program that is ready to run; none where it is not re-scheduled. Runs the motion of
    /// both programs.
    pub(crate) fn of_prepared(prepared: &Prepared) -> Option<Self> {
        let made = prepared.made.as_ref().filter(|made| !made.runs.is_empty())?;
        let head = Self::head(prepared)?;
        let motions = || -> Result<[[Motion; 2]; 2], SimError> {
            let planned = [MotionCase::new(prepared)?.planned_only(), MotionCase::of_source(prepared)?.planned_only()];
            let (new, old) = rayon::join(|| planned[0].run(), || planned[1].run());
            Ok([new?, old?].map(|motion| [motion.along_program(), motion]))
        };
        Some(match motions() {
            Err(why) => Self { unknown: Some(why.to_string()), ..head },
            Ok([new, old]) => {
                let motions = Motions { planned: [&new[1], &old[1]], ideal: [&new[0], &old[0]] };
                let bounds = bounds(&made.runs, motions, &prepared.changed_limits);
                head.with(&made.runs, &prepared.machine, motions, bounds)
            }
        })
    }

    /// What is known without motion; none where the program is not re-scheduled.
    pub(crate) fn head(prepared: &Prepared) -> Option<Self> {
        let file = prepared.scene.program(Some(&prepared.program_name))?.reschedule.as_ref()?;
        let method = file.method();
        Some(Self {
            method: method.name().to_owned(),
            source: method.source().to_owned(),
            from: file.from.clone(),
            ..Self::default()
        })
    }

    /// Adds the runs from the motions, with the time and bound of each.
    pub(crate) fn with<'a>(
        mut self,
        runs: &[ReprogrammedRun],
        machine: &Machine,
        motions: Motions<'a>,
        bounds: Vec<Result<ScheduleBound, String>>,
    ) -> Self {
        let [new, old] = motions.ideal.map(|motion| blocks_of(&motion.blocks, runs));
        let times = blocks_of(&motions.planned[0].blocks, runs);
        for (k, (run, bound)) in runs.iter().zip(bounds).enumerate() {
            let at = |list: &Blocks<'a>| list.get(k).copied().flatten();
            let (times, new, old) = (at(&times), at(&new), at(&old));
            if let (Some(times), Some(new), Some(old)) = (times, new, old) {
                self.runs.push(scheduled(run, machine, times, [old, new], bound));
            }
        }
        self
    }
}

/// Time and bound of each run.
fn bounds(
    runs: &[ReprogrammedRun],
    motions: Motions<'_>,
    changed_limits: &[ChangedLimit],
) -> Vec<Result<ScheduleBound, String>> {
    let [new, old] = motions.planned.map(|motion| blocks_of(&motion.blocks, runs));
    let pairs = runs.iter().zip(new.into_iter().zip(old));
    let bound = |(run, (new, old)): (&ReprogrammedRun, _)| {
        certify(run, |_| 0, new, old, changed_limits).map(|found| ScheduleBound::of(&found))
    };
    pairs.map(bound).collect()
}

fn scheduled(
    run: &ReprogrammedRun,
    machine: &Machine,
    times: &[FeedBlock],
    [old, new]: [&[FeedBlock]; 2],
    bound: Result<ScheduleBound, String>,
) -> ScheduledRun {
    let mut way = 0.0;
    let mut last: Option<Point> = None;
    let place = |block: &FeedBlock| block.center.unwrap_or(block.tip);
    let mut blocks = Vec::with_capacity(times.len());
    for (k, block) in times.iter().enumerate() {
        let at = place(&new[k]);
        way += last.map_or(0.0, |from| (at - from).norm());
        last = Some(at);
        let poses = [(&run.before, old), (&run.after, new)].map(|(poses, blocks)| ToolPose {
            tip: place(&blocks[k]),
            axis: poses.get(k).map_or(Vector::z(), |p| p.axis),
        });
        blocks.push(ScheduledBlock { time: block.time[1], way, poses });
    }
    let joints = (0..machine.joints.len()).map(|j| {
        let (mut original, after) = (demand(old, j), demand(new, j));
        if machine.joints[j].is_rotary() {
            let turn = std::f64::consts::TAU;
            let start = run.stretch.start;
            let away = original.position.get(start).zip(after.position.get(start));
            let away = away.map_or(0.0, |(a, b)| turn * ((a - b) / turn).round());
            original.position.iter_mut().for_each(|q| *q -= away);
        }
        ScheduledJoint { joint: j, channel: channel(run, &machine.joints[j].name), original, new: after }
    });
    let joints = joints.collect();
    let study = study_of(run);
    let curves = study.curves.iter().filter_map(|curve| along(curve, &study.curves, &run.stretch)).collect();
    ScheduledRun { blocks, stretch: run.stretch.clone(), joints, curves, figures: study.figures, bound }
}

/// The gates of a joint without what the control rounds off.
fn channel(run: &ReprogrammedRun, name: &str) -> Option<Vec<[f64; 2]>> {
    let all = run.alternatives.as_ref().ok()?;
    let joint = all.schedules.joints.iter().find(|j| j.name == name)?;
    let gates: Vec<[f64; 2]> =
        joint.gates.iter().map(|[low, high]| [low + all.rounding, high - all.rounding]).collect();
    gates.iter().any(|[low, high]| high - low > NO_CHOICE).then_some(gates)
}

fn demand(blocks: &[FeedBlock], joint: usize) -> Demand {
    let position: Vec<f64> = blocks.iter().map(|b| b.end[joint]).collect();
    let mut velocity = vec![f64::NAN; blocks.len()];
    let mut acceleration = velocity.clone();
    for i in 1..blocks.len() {
        velocity[i] = (position[i] - position[i - 1]) / blocks[i].programmed;
    }
    for i in 1..blocks.len().saturating_sub(1) {
        acceleration[i] = 2.0 * (velocity[i + 1] - velocity[i]) / (blocks[i].programmed + blocks[i + 1].programmed);
    }
    Demand { position, velocity, acceleration }
}

/// A curve whose abscissa is the way along the stretch, at the blocks: the curves of a method that have a
/// point for each block say where blocks lie.
fn along(curve: &StudyCurve, all: &[StudyCurve], stretch: &Range<usize>) -> Option<MethodCurve> {
    if curve.units[0] != "mm" || curve.points.is_empty() {
        return None;
    }
    let whole = |c: &&StudyCurve| c.axes[0] == curve.axes[0] && c.points.len() == stretch.len();
    let ruler: Vec<f64> = all.iter().find(whole)?.points.iter().map(|p| p[0]).collect();
    let place = |s: f64| -> f64 {
        let next = ruler.partition_point(|r| *r < s);
        let Some((from, to)) = next.checked_sub(1).zip(ruler.get(next)).map(|(k, to)| (ruler[k], *to)) else {
            return next.min(ruler.len() - 1) as f64;
        };
        (next - 1) as f64 + if to > from { (s - from) / (to - from) } else { 1.0 }
    };
    let points = if curve.points.len() == stretch.len() {
        curve.points.iter().enumerate().map(|(k, p)| [(stretch.start + k) as f64, p[1]]).collect()
    } else {
        curve.points.iter().map(|p| [stretch.start as f64 + place(p[0]), p[1]]).collect()
    };
    Some(MethodCurve {
        name: curve.name.clone(),
        role: curve.role,
        quantity: [curve.axes[1].clone(), curve.units[1].clone()],
        points,
    })
}
