//! How far a re-scheduled program is from the best possible schedule: its time compared with a
//! bound on the time of every schedule in its channel.
//!
//! *The stretch* is the range of blocks that the method re-planned. Its time is that of the planned
//! set points, block by block. Where the program before has the same blocks, its time is given too.
//! The bound is that of [`Schedules`]. It covers every schedule of the channel, whatever its feed
//! law, under these assumptions, which are written to the file:
//!
//! * the tip moves no faster than the programmed feed (exceeded by at most `feed_passed`) along its
//!   actual path, and comes within `off_mm` of the end of each block; the least time that this
//!   leaves of the programmed times is proved from the paths of the tip ([`FeedFloor`]);
//! * the tip paths of other schedules are unknown until they are made; the bound covers those that
//!   bend no more at the end of a block, and are no shorter for their time, than the path of one of
//!   the programs named in `ways`;
//! * joints keep their limits to 0.1 percent, the tolerance of the control, and the programmed
//!   rotary positions to its rounding.
//!
//! Limits are those in force: what a scene lowers counts as lowered.

mod cells;
mod constant_feed;
mod ramps;

use proveout_controller::{Alternatives, ReprogrammedRun};
use proveout_geom::Point;
use proveout_reschedule::{FeedFloor, JointGates, Proof, Schedules};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    observe::study::{Role, StudyCurve},
    prepare::motion_only::FeedBlock,
    scene::joint_limits::ChangedLimit,
};

pub use cells::{CellCertificate, CellJoint};
pub use constant_feed::ConstantFeed;
pub use ramps::RampsApart;

/// Part by which the control may pass the programmed feed.
const FEED_PASSED: f64 = 0.0005;
/// What four decimals of X, Y and Z may lead a point of the program astray, mm.
const POINT_ROUNDED: f64 = 1e-4;
/// Part by which the control may pass limits of joints.
const LIMIT_PASSED: f64 = 0.001;
/// By how much programmed times of the text may differ from those of the commands: four decimals of a feed.
const TIME_ROUNDED: f64 = 1e-4;
/// By how much positions may be outside of their gates, radian: eight decimals of a tool vector. `cargo xtask
/// verify-schedule` has the same.
const PLACE_ROUNDED: f64 = 1e-4 * std::f64::consts::PI / 180.0;
/// Part by which a time may be below its bound: rounding of two sums of many terms.
const ROUNDING: f64 = 1e-9;

/// The certificate of a program, as it is written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScheduleCertificate {
    /// What the file is.
    pub format: &'static str,
    /// The method and its source.
    pub method: String,
    /// The paper.
    pub source: String,
    /// The program before.
    pub from: String,
    /// The machine.
    pub machine: String,
    /// Limits that the scene has lowered.
    pub changed_limits: Vec<ChangedLimit>,
    /// The stretches.
    pub runs: Vec<RunCertificate>,
}

impl ScheduleCertificate {
    /// What [`Self::format`] says.
    pub const FORMAT: &'static str = "proveout schedule certificate, version 2";
}

/// A joint with its gates; degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointCertificate {
    /// Name.
    pub name: String,
    /// Velocity limit.
    pub velocity_deg_s: f64,
    /// Acceleration limit; null where there is none.
    pub acceleration_deg_s2: Option<f64>,
    /// Jerk limit; null where there is none.
    pub jerk_deg_s3: Option<f64>,
    /// Lowest and highest position at the begin of the stretch and at the end of each of its blocks, widened
    /// by the rounding.
    pub gates_deg: Vec<[f64; 2]>,
    /// Positions of the new program there.
    pub new_deg: Vec<f64>,
    /// Positions of the program before.
    pub original_deg: Vec<f64>,
    /// Bound by the feed and this joint's velocity, s.
    pub velocity_bound_s: f64,
    /// What feed and velocity alone make of the stretch, over the velocity limit of this joint, falling.
    pub over_velocity: Vec<VelocityRow>,
}

/// Times of a stretch under one velocity limit, whatever acceleration, jerk and other joints allow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct VelocityRow {
    /// The limit.
    pub velocity_deg_s: f64,
    /// Where it comes from.
    pub is: VelocityLimit,
    /// Program before.
    pub original_s: f64,
    /// New program.
    pub new_s: f64,
    /// Least of all schedules in the channel.
    pub least_s: f64,
    /// Time that the new program saves, percent.
    pub saved_percent: f64,
    /// Time that the best schedule of the channel would save, percent.
    pub saved_at_most_percent: f64,
}

/// Where a limit of [`VelocityRow`] comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityLimit {
    /// One of a row, for the curve.
    Tried,
    /// What the program before needs: no schedule gains anything at this limit and above.
    OfOriginal,
    /// What is in force here.
    InForce,
    /// The machine's own, where a scene has lowered it.
    OfMachine,
}

/// Limits that are tried, parts of what the program before needs.
const TRIED: [f64; 8] = [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2];

/// A joint that is nowhere faster than this counts as at rest, rad/s: rounding of tool vectors.
const STANDS_STILL: f64 = 1e-3;

/// The curve of what a schedule gains over the velocity limit of its joint.
fn over_velocity(k: usize, programmed: &Schedules, [before, after]: [&[f64]; 2], own: Option<f64>) -> Vec<VelocityRow> {
    let Some(joint) = programmed.joints.get(k) else { return Vec::new() };
    let rates = before.windows(2).zip(&programmed.least).map(|(q, t)| (q[1] - q[0]).abs() / t);
    let needed = rates.fold(0.0, f64::max);
    if !(needed > STANDS_STILL && needed.is_finite()) {
        return Vec::new();
    }
    // The limit as reported, without the tolerance by which it may be exceeded.
    let force = joint.limits.velocity / (1.0 + LIMIT_PASSED);
    let mut limits: Vec<(f64, VelocityLimit)> = TRIED.map(|part| (part * needed, VelocityLimit::Tried)).into();
    limits.extend([(needed, VelocityLimit::OfOriginal), (force, VelocityLimit::InForce)]);
    limits.extend(own.map(|v| (v, VelocityLimit::OfMachine)));
    limits.sort_by(|a, b| b.0.total_cmp(&a.0));
    let row = |(velocity, is): (f64, VelocityLimit)| {
        let time = |own: &[f64]| -> f64 {
            own.windows(2).zip(&programmed.least).map(|(q, t)| t.max((q[1] - q[0]).abs() / velocity)).sum()
        };
        let mut alone = joint.clone();
        alone.limits.velocity = velocity;
        let schedules = Schedules { least: programmed.least.clone(), joints: vec![alone] };
        let least_s = schedules.certificate().ok()?.velocity.first().copied()?;
        let (original_s, new_s) = (time(before), time(after));
        let saved = |time: f64| 100.0 * (1.0 - time / original_s);
        Some(VelocityRow {
            velocity_deg_s: velocity.to_degrees(),
            is,
            original_s,
            new_s,
            least_s,
            saved_percent: saved(new_s),
            saved_at_most_percent: saved(least_s),
        })
    };
    limits.into_iter().filter_map(row).collect()
}

/// A linear joint that follows the axes of a channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinearCertificate {
    /// Name.
    pub name: String,
    /// Velocity limit.
    pub velocity_mm_s: f64,
    /// Acceleration limit; null where there is none.
    pub acceleration_mm_s2: Option<f64>,
    /// Jerk limit; null where there is none.
    pub jerk_mm_s3: Option<f64>,
    /// Lowest and highest position at the gates over all angles of the channel, widened by the rounding.
    pub gates_mm: Vec<[f64; 2]>,
    /// Longest way that all schedules must make at once, one way, and the time of it at the velocity limit.
    pub longest_way_mm: f64,
    /// Bound by the feed and this joint's velocity, s.
    pub velocity_bound_s: f64,
}

/// The way of the tip in a program, from which the least times of blocks are proved.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WayCertificate {
    /// `new` or `original`.
    pub program: &'static str,
    /// Time that the programmed feed gives to the length between these points, s.
    pub times_s: Vec<f64>,
    /// The tip at the gates, table frame; the linear joints without tool center point control.
    pub points_mm: Vec<[f64; 3]>,
}

/// A window of the proof.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WindowCertificate {
    /// `feed`, `travel`, `swings` or `cells`.
    pub proof: &'static str,
    /// The joint; none for the feed.
    pub joint: Option<String>,
    /// First and last gate; of swings every gate. 0 is the begin of the stretch.
    pub gates: Vec<usize>,
    /// The joint goes up from the first to the second.
    pub up: Option<bool>,
    /// What the window proves, s.
    pub time_s: f64,
}

/// A stretch with its bound.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunCertificate {
    /// First and last line of the stretch in the program before.
    pub lines: [u32; 2],
    /// What the bound rests on that is not proved, in words.
    pub rests_on: Vec<String>,
    /// Part by which the control may pass the feed.
    pub feed_passed: f64,
    /// What tip (or linear joints) may be off the end of a block.
    pub off_mm: f64,
    /// Ways of the tip that the feed is proved from.
    pub ways: Vec<WayCertificate>,
    /// Time that the program gives to each block, s, and to all.
    pub nominal_s: Vec<f64>,
    /// Sum of these.
    pub programmed_s: f64,
    /// Part by which joints may pass their limits.
    pub limit_passed: f64,
    /// What the control may leave rotary positions by, degrees.
    pub rounding_deg: f64,
    /// Least time of each block, s; in a window of blocks, less what it loses at its ends.
    pub least_s: Vec<f64>,
    /// What a window of feed loses where it begins or ends at a gate, s.
    pub seams_s: Vec<f64>,
    /// Time of each block in the new program, s.
    pub new_s: Vec<f64>,
    /// Time of each block in the program before, s.
    pub original_s: Vec<f64>,
    /// Joints that have a channel.
    pub joints: Vec<JointCertificate>,
    /// Linear joints that follow the axes.
    pub linear: Vec<LinearCertificate>,
    /// The bound with both angles free, where the method knows no channel of one.
    pub cells: Option<CellCertificate>,
    /// What the table needs at least at the programmed times.
    pub constant_feed: Vec<ConstantFeed>,
    /// The proof: consecutive windows.
    pub windows: Vec<WindowCertificate>,
    /// Bound by the feed, s.
    pub feed_bound_s: f64,
    /// The largest bound, s.
    pub bound_s: f64,
    /// Time of the new program, s.
    pub time_s: f64,
    /// Time of the program before, s.
    pub original_time_s: f64,
    /// The new program keeps to the channel, so that the bound is about it.
    pub new_inside: bool,
    /// The program before does.
    pub original_inside: bool,
    /// How much longer the new program takes than the bound, percent of the bound; null where it leaves the
    /// channel.
    pub gap_percent: Option<f64>,
    /// The same without the ramps at both ends; null where the new program leaves the channel, or little but
    /// ramps is there.
    pub ramps_apart: Option<RampsApart>,
}

impl RunCertificate {
    /// Time that windows of a proof prove, s.
    pub fn proved_by(&self, proof: &str) -> f64 {
        self.windows.iter().filter(|w| w.proof == proof).map(|w| w.time_s).sum()
    }

    /// Time saved against the program before, percent.
    pub fn gain_percent(&self) -> f64 {
        100.0 * (1.0 - self.time_s / self.original_time_s)
    }
}

/// Blocks of the runs of a motion that have the blocks of re-scheduled runs, in order.
pub(crate) fn blocks_of<'a>(motion: &'a [FeedBlock], runs: &[ReprogrammedRun]) -> Vec<Option<&'a [FeedBlock]>> {
    let mut left = motion.chunk_by(|a, b| a.run == b.run);
    runs.iter().map(|run| left.by_ref().find(|blocks| blocks.len() == run.commands.len())).collect()
}

/// The certificate of a stretch from the motions of both programs.
///
/// # Errors
/// Why there is none.
pub(crate) fn certify(
    run: &ReprogrammedRun,
    line: impl Fn(usize) -> u32,
    new: Option<&[FeedBlock]>,
    original: Option<&[FeedBlock]>,
    changed_limits: &[ChangedLimit],
) -> Result<RunCertificate, String> {
    let alternatives = run.alternatives.as_ref().map_err(|&e| e.to_owned())?;
    let (Some(new), Some(original)) = (new, original) else {
        return Err("the motion of a program does not have the blocks of its run".into());
    };
    let inner = run.stretch.start + 1..run.stretch.end;
    let (Some(new), Some(original), Some(commands)) =
        (new.get(inner.clone()), original.get(inner), run.commands.get(run.stretch.clone()))
    else {
        return Err("the stretch is not in the run".into());
    };
    let Alternatives { schedules, rounding, before, after, .. } = alternatives;
    let same = |blocks: &[FeedBlock]| {
        blocks.iter().zip(&schedules.least).all(|(b, t)| (b.programmed / t - 1.0).abs() < TIME_ROUNDED)
    };
    if new.len() != schedules.least.len() || !same(new) || !same(original) {
        return Err("the programmed times of the blocks differ between motion and program".into());
    }
    let times = |blocks: &[FeedBlock]| blocks.iter().map(|b| b.time[1] - b.time[0]).collect::<Vec<f64>>();
    let (new_s, original_s) = (times(new), times(original));
    let inside = |positions: &[Vec<f64>]| {
        schedules.joints.iter().zip(positions).all(|(joint, own)| {
            let mut pairs = joint.gates.iter().zip(own);
            pairs.all(|([low, high], q)| q - low > rounding - PLACE_ROUNDED && high - q > rounding - PLACE_ROUNDED)
        })
    };
    let (time_s, original_time_s) = (new_s.iter().sum::<f64>(), original_s.iter().sum::<f64>());
    let (new_inside, original_inside) = (inside(after), inside(before));
    let programs = [("new", new, true), ("original", original, original_inside)];
    let ways: Vec<WayCertificate> = [1, 0]
        .into_iter()
        .zip(programs)
        .filter(|(_, (_, _, counts))| *counts)
        .map(|(k, (program, blocks, _))| way(program, &alternatives.ways[k], blocks, &schedules.least))
        .collect();
    let off = alternatives.tip_rounding + POINT_ROUNDED;
    let FeedFloor { least, seams } = floor(&ways, off).map_err(|block| {
        let line = commands.get(block + 1).map_or(0, |c| line(*c));
        format!("the block in line {line} is too short for a time bound: its ends may be off by {off:.4} mm")
    })?;
    let rotary = schedules.joints.len();
    let passed = |joint: &JointGates| JointGates { limits: joint.limits.passed_by(LIMIT_PASSED), ..joint.clone() };
    let counted =
        Schedules { least, joints: schedules.joints.iter().chain(&alternatives.linear).map(passed).collect() };
    let certificate = counted.certificate_within(&seams).map_err(|e| e.to_string())?;
    let mut starts = vec![0.0];
    starts.extend(counted.least.iter().scan(0.0, |sum, t| {
        *sum += t;
        Some(*sum)
    }));
    let feed = |from: usize, to: usize| (starts[to] - starts[from] - seams[from] - seams[to]).max(0.0);
    let cells = alternatives.two_angles.as_ref().and_then(|angles| CellCertificate::new(angles, LIMIT_PASSED, feed));
    let by_cells = cells.as_ref().filter(|c| c.bound_s > certificate.bound).map(|c| c.bound_s);
    let bound = by_cells.unwrap_or(certificate.bound);
    for (name, is_inside, time) in [("new", new_inside, time_s), ("original", original_inside, original_time_s)] {
        if is_inside && time < bound * (1.0 - ROUNDING) {
            return Err(format!(
                "the {name} program takes {time:.6} s, less than its proven lower bound of {:.6} s: an assumption of the bound \
                 does not hold here",
                bound
            ));
        }
    }
    let degrees = |values: &[f64]| values.iter().map(|q| q.to_degrees()).collect::<Vec<f64>>();
    let stated = |v: f64| v.is_finite().then(|| v.to_degrees());
    let own_velocity = |name: &str| {
        let own = changed_limits.iter().find(|l| l.joint == name && l.quantity == "velocity");
        own.and_then(|l| l.of_machine).map(f64::to_radians)
    };
    // The curve is about feed and velocity alone, without what the control rounds off.
    let programmed = Schedules { least: schedules.least.clone(), joints: counted.joints.clone() };
    let joints = schedules.joints.iter().enumerate().map(|(k, joint)| JointCertificate {
        name: joint.name.clone(),
        velocity_deg_s: joint.limits.velocity.to_degrees(),
        acceleration_deg_s2: stated(joint.limits.acceleration),
        jerk_deg_s3: stated(joint.limits.jerk),
        gates_deg: joint.gates.iter().map(|g| g.map(f64::to_degrees)).collect(),
        new_deg: degrees(&after[k]),
        original_deg: degrees(&before[k]),
        velocity_bound_s: certificate.velocity[k],
        over_velocity: over_velocity(k, &programmed, [&before[k], &after[k]], own_velocity(&joint.name)),
    });
    let windows = match by_cells {
        Some(time_s) => {
            let gates = vec![0, counted.least.len()];
            vec![WindowCertificate { proof: "cells", joint: None, gates, up: None, time_s }]
        }
        None => certificate.windows.iter().map(|(proof, time)| window(proof, *time, &counted)).collect(),
    };
    let linear = alternatives.linear.iter().zip(&certificate.velocity[rotary..]).map(|(joint, bound)| {
        let stated = |v: f64| v.is_finite().then_some(v);
        LinearCertificate {
            name: joint.name.clone(),
            velocity_mm_s: joint.limits.velocity,
            acceleration_mm_s2: stated(joint.limits.acceleration),
            jerk_mm_s3: stated(joint.limits.jerk),
            longest_way_mm: longest_way(&joint.gates),
            gates_mm: joint.gates.clone(),
            velocity_bound_s: *bound,
        }
    });
    let table = alternatives.table.and_then(|k| Some((schedules.joints.get(k)?, after.get(k)?)));
    let constant_feed = table.map_or_else(Vec::new, |(joint, own)| {
        let gates: Vec<[f64; 2]> = joint.gates.iter().map(|[low, high]| [low + rounding, high - rounding]).collect();
        let velocity = joint.limits.velocity * (1.0 + LIMIT_PASSED);
        constant_feed::constant_feed(&joint.name, &schedules.least, &gates, velocity, own)
    });
    let names: Vec<&str> = ways.iter().map(|w| w.program).collect();
    let rests_on = vec![format!(
        "at block ends the tip path turns at most as sharply, and it is at least as long for its time, as in one of \
         these programs: {}",
        names.join(", ")
    )];
    Ok(RunCertificate {
        lines: [commands.first(), commands.last()].map(|c| c.map_or(0, |c| line(*c))),
        rests_on,
        feed_passed: FEED_PASSED,
        off_mm: off,
        ways,
        programmed_s: schedules.least.iter().sum(),
        nominal_s: schedules.least.clone(),
        limit_passed: LIMIT_PASSED,
        rounding_deg: rounding.to_degrees(),
        joints: joints.collect(),
        linear: linear.collect(),
        cells,
        constant_feed,
        windows,
        feed_bound_s: certificate.feed,
        bound_s: bound,
        gap_percent: new_inside.then(|| 100.0 * (time_s / bound - 1.0)),
        ramps_apart: new_inside.then(|| RampsApart::new(&counted, &seams, &new_s)).flatten(),
        seams_s: seams,
        least_s: counted.least,
        new_s,
        original_s,
        time_s,
        original_time_s,
        new_inside,
        original_inside,
    })
}

/// The way of a program: what its feed gives to the way between the points of the schedule, which its text
/// has with four decimals.
fn way(program: &'static str, points: &[Point], blocks: &[FeedBlock], least: &[f64]) -> WayCertificate {
    let steps = points.windows(2).map(|p| (p[1] - p[0]).norm());
    // A block of the text that is longer than that of the schedule has a higher feed.
    let times = steps.zip(blocks.iter().zip(least)).map(|(step, (block, t))| {
        if block.length > step { block.programmed.min(*t) * step / block.length } else { block.programmed.min(*t) }
    });
    WayCertificate { program, times_s: times.collect(), points_mm: points.iter().map(|p| (*p).into()).collect() }
}

/// The floor of all ways, with the shortest time that a block has in one of them.
fn floor(ways: &[WayCertificate], off: f64) -> Result<FeedFloor, usize> {
    let count = ways.first().map_or(0, |w| w.times_s.len());
    let times: Vec<f64> = (0..count).map(|i| ways.iter().map(|w| w.times_s[i]).fold(f64::INFINITY, f64::min)).collect();
    let points: Vec<Vec<Point>> = ways.iter().map(|w| w.points_mm.iter().map(|p| Point::from(*p)).collect()).collect();
    let all: Vec<&[Point]> = points.iter().map(Vec::as_slice).collect();
    FeedFloor::new(&times, &all, off, FEED_PASSED)
}

/// The longest way that a joint must make from one gate to a later one.
fn longest_way(gates: &[[f64; 2]]) -> f64 {
    let (mut high, mut low, mut longest) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    for gate in gates {
        longest = longest.max(gate[0] - high).max(low - gate[1]);
        (high, low) = (high.min(gate[1]), low.max(gate[0]));
    }
    longest
}

/// What a schedule gains over the velocity limit of a joint, as curves of a page.
pub(crate) fn gain_curves(joint: &JointCertificate) -> Vec<StudyCurve> {
    let axes = [format!("velocity limit of {}", joint.name), "time saved, by feed and velocity alone".to_owned()];
    let curve = |name: &str, role: Role, points: Vec<[f64; 2]>| StudyCurve {
        name: name.to_owned(),
        role,
        axes: axes.clone(),
        units: ["deg/s".to_owned(), "%".to_owned()],
        equal_scales: false,
        points,
    };
    let rising: Vec<&VelocityRow> = joint.over_velocity.iter().rev().collect();
    if rising.is_empty() {
        return Vec::new();
    }
    let points = |of: fn(&VelocityRow) -> f64| rising.iter().map(|r| [r.velocity_deg_s, of(r)]).collect::<Vec<_>>();
    let marked = |is: VelocityLimit| {
        let rows = rising.iter().filter(|r| r.is == is);
        rows.map(|r| [r.velocity_deg_s, r.saved_percent]).collect::<Vec<_>>()
    };
    let mut curves = vec![
        curve("at most, in the channel", Role::Limit, points(|r| r.saved_at_most_percent)),
        curve("this program", Role::Result, points(|r| r.saved_percent)),
        curve("limit in force", Role::KeyPoints, marked(VelocityLimit::InForce)),
    ];
    let own = marked(VelocityLimit::OfMachine);
    if !own.is_empty() {
        curves.push(curve("the machine's own limit", Role::KeyPoints, own));
    }
    curves
}

fn window(proof: &Proof, time_s: f64, schedules: &Schedules) -> WindowCertificate {
    let name = |joint: usize| schedules.joints.get(joint).map(|j| j.name.clone());
    match proof {
        Proof::Feed { gates } => {
            WindowCertificate { proof: "feed", joint: None, gates: gates.to_vec(), up: None, time_s }
        }
        Proof::Travel { joint, gates, up } => {
            WindowCertificate { proof: "travel", joint: name(*joint), gates: gates.to_vec(), up: Some(*up), time_s }
        }
        Proof::Swings { joint, gates, up } => {
            WindowCertificate { proof: "swings", joint: name(*joint), gates: gates.clone(), up: Some(*up), time_s }
        }
    }
}
