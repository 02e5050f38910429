//! The smoothest schedule of a row: both rotary joints free, in what the tool leaves free beside part and fixtures.
//!
//! A row is a run of blocks along a surface, to one end. Contacts (ball centers), blocks and feeds stay; turn and tilt of the machine are anything that
//! `freedom.rs` allows.
//!
//! 1. *Globally* (`cells.rs`): stations along the row, cells of turn and tilt, and the way of least time from end to end by dynamic programming: the side of the
//!    pole, the branch, and what is gone round.
//! 2. *Locally* (`local.rs`): rectangles of free cells round that way, as large as they become; in them each joint has the least peak of acceleration over
//!    time, then the least jerk. Rectangles are grown anew round what came out, and it is solved again.
//! 3. *With the control*, where one is known: in the times that it takes, as long as that gains.
//!
//! What is handed out is the fastest of all that were tried, of the program before and of the published methods for such rows, as far as they are free; of those
//! that are as fast, the one with the least peak of acceleration, as a part of the limits of its joint. Every block of it is proved free or judged
//! from end to end once more.
//!
//! Linear joints that follow the axes are looked at by the control only.

mod cells;
mod freedom;
mod joints;
mod local;
mod row;
mod shown;

use proveout_geom::Vector;
use proveout_machine::JointValues;

use self::cells::{Cell, Cells, Closed, Scale};
use self::freedom::Freedom;
use self::joints::{Angles, TwoJoints, one_turn};
use self::local::{Rectangles, peaks};
use self::row::Row;
use super::super::{
    CuttingRun, Method, MinAngularAcceleration, MultiScale, RescheduleError, Rescheduled, Singularity, Surroundings,
};
use super::{GAIN, VELOCITY_GIVEN};

/// Largest turn of the axis from the program's own where nothing else limits it, radian.
const TURN_MAX: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Cells of turn and tilt, radian; the finer ones for the rules of a bull-nose, which leave a few degrees.
const CELLS: [f64; 2] = [5.0 * std::f64::consts::PI / 180.0, 2.0 * std::f64::consts::PI / 180.0];
const FINE_CELLS: [f64; 2] = [2.0 * std::f64::consts::PI / 180.0, 0.75 * std::f64::consts::PI / 180.0];
/// No more cells than this at a station, nor stations.
const MOST_CELLS: f64 = 8_000.0;
const MOST_STATIONS: usize = 100;
/// Stations where the rules of a bull-nose are looked at: each costs sections of the surface.
const MOST_JUDGED: usize = 15;
/// Half a turn each way beside the turns of the program is looked at; a sixth for the rules of a bull-nose.
const BESIDE: f64 = std::f64::consts::PI;
const BESIDE_RULES: f64 = std::f64::consts::FRAC_PI_3;
/// How far beside the tilts of the program is looked first, radian.
const BAND: f64 = 12.0 * std::f64::consts::PI / 180.0;
/// How often rectangles are grown anew.
const ROUNDS: usize = 3;
/// An end that is kept may be off by this while the others are looked for, radian.
const KEPT: f64 = 1e-7;
/// Schedules whose times differ by less than this part are as fast.
const AS_FAST: f64 = 1e-5;
/// What is asked of the control: how many times the least peak of velocity there may be, whether the programs are solved in its own times, and whether the joints
/// stand still at the ends; given up after some without a gain.
const WITH_CONTROL: [(f64, bool, bool); 9] = {
    let [roomy, tight] = VELOCITY_GIVEN;
    [
        (roomy, true, true),
        (tight, false, true),
        (tight, true, true),
        (roomy, true, false),
        (tight, true, false),
        (1.1, false, true),
        (1.1, true, true),
        (1.1, true, false),
        (roomy, true, true),
    ]
};
const IDLE: usize = 5;
/// By how much the rules of a bull-nose are taken narrower, as a part of their limits, in the order in which it is tried: between stations nothing is known.
const MARGINS: [f64; 3] = [0.01, 0.025, 0.05];

/// Whether the axes at the ends of a row may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowEnds {
    /// They stay as the program has them.
    Kept,
    /// They move as all others do.
    Free,
}

/// Parameters of the method for rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothRows {
    /// Largest lean of the tool axis from the normal of the surface, radian.
    pub lean_max: f64,
    /// Largest turn of the tool axis from the program's own, radian. None: 15 degrees, but for ball ends on a surface that is known.
    pub turn_max: Option<f64>,
    /// The ends of the row.
    pub ends: RowEnds,
    /// Rules of a bull-nose: strip and roughness.
    pub rules: MultiScale,
}

impl Default for SmoothRows {
    /// A lean of 80 degrees, ends that stay, the published rules.
    fn default() -> Self {
        Self { lean_max: 80.0_f64.to_radians(), turn_max: None, ends: RowEnds::Kept, rules: MultiScale::default() }
    }
}

/// A schedule that was tried.
#[derive(Clone, Debug)]
struct Tried {
    angles: Vec<Angles>,
    /// Times of the blocks behind the first, by the control where it is known, s.
    times: Vec<f64>,
    /// Largest acceleration as a part of its joint's limit, at the programmed feed.
    effort: f64,
    name: &'static str,
}

impl Tried {
    fn time(&self) -> f64 {
        self.times.iter().sum()
    }
}

impl SmoothRows {
    fn check(&self) -> Result<(), RescheduleError> {
        let quarter = 0.5 * std::f64::consts::PI;
        let lean = self.lean_max > 0.0 && self.lean_max <= quarter;
        let turn = self.turn_max.is_none_or(|t| t > 0.0 && t <= 2.0 * quarter);
        let (key, value) = match (lean, turn) {
            (true, true) => return Ok(()),
            (false, _) => ("lean_max_deg", self.lean_max),
            (true, false) => ("turn_max_deg", self.turn_max.unwrap_or_default()),
        };
        Err(RescheduleError::new(
            "reschedule-option",
            0,
            format!("{key} = {:.6} of smooth is outside of its range", value.to_degrees()),
            "largest lean above 0 to 90 degrees, largest turn above 0 to 180 degrees",
        ))
    }
}

impl Method for SmoothRows {
    fn name(&self) -> &'static str {
        "smooth"
    }

    fn source(&self) -> &'static str {
        "this project: ways through cells of both rotary joints, least peak of acceleration"
    }

    fn needs_region(&self) -> bool {
        true
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        self.check()?;
        let first = run.blocks.first().map_or(0, |b| b.line);
        let Some(joints) = TwoJoints::new(around.machine) else {
            let message = "the machine has not two rotary joints that turn the tool axis";
            return Err(RescheduleError::new("reschedule-path", first, message, "choose a five-axis machine"));
        };
        let row = Row::new(self, run, around)?;
        let least = row.times(run)?;
        let own = &run.blocks[row.stretch.clone()];
        let mut course = joints.course(run, run.blocks.iter().map(|b| &b.pose.axis))?;
        course = course[row.stretch.clone()].to_vec();
        let pose = |i: usize, axis: &Vector| row.pose(row.stretch.start + i, axis);
        let normals = row.normals(around);
        let known = normals.iter().all(Option::is_some);
        let ball = row.ball().zip(around.region).map(|(radius, region)| (region, radius));
        if row.ball().is_some() && ball.is_none() {
            let message = "what the tool must keep away from is not known";
            let help = "give the scene a part or fixtures: a row of a ball end is as free as these leave it";
            return Err(RescheduleError::new("reschedule-channel", row.line(run, 0), message, help));
        }
        let capped = if ball.is_some() && known { std::f64::consts::PI } else { TURN_MAX };
        let turn_max = self.turn_max.unwrap_or(capped);
        let bodies = around.region.filter(|_| ball.is_none()).and_then(|r| Some((r, r.reach()?)));
        let freedom = Freedom {
            joints: &joints,
            points: row.points(),
            normals,
            own: own.iter().map(|b| b.pose.axis).collect(),
            lean_max: self.lean_max,
            turn_max,
            ball,
            bodies,
            pose: &pose,
            rules: row.rules.as_ref(),
            length: row.arc.last().copied().unwrap_or(0.0),
        };
        let work =
            Work { run, around, row: &row, joints: &joints, least: &least, limits: [0, 1].map(|j| joints.limits(j)) };
        let margins = if row.rules.is_some() { &MARGINS[..] } else { &[0.0] };
        let mut found = Vec::new();
        let mut refused = None;
        // Near the tilts of the program first: elsewhere it is looked where the schedule wants to go on there.
        for band in [Some(BAND), None] {
            let ground = Ground::new(&work, &freedom, &course, band)?;
            let before = found.len();
            let mut left = false;
            for margin in margins {
                match self.planned(&work, &freedom, &course, (&ground, *margin)) {
                    Ok(planned) => {
                        left = planned.angles.iter().flatten().any(|q| ground.at_cut(q[1]));
                        let free = planned.angles.into_iter().filter(|angles| freedom.is_free(angles));
                        found.extend(free.map(|angles| work.tried(angles, "smoothest")));
                        refused = None;
                        if found.len() > before {
                            found.extend(work.with_control(&planned.gates, &found, &freedom));
                            break;
                        }
                    }
                    Err(e) => refused = Some(e),
                }
            }
            if !ground.is_cut() || found.len() > before && !left {
                break;
            }
        }
        if let (Some(e), true) = (refused, found.is_empty()) {
            return Err(e);
        }
        self.add_others(&work, &course, &freedom, &mut found);
        let Some(best) = chosen(found) else {
            let at = freedom.first_taken(&course).unwrap_or(0);
            let message = "neither a new schedule nor that of the program keeps all limits of this block";
            let help = "set a larger lean_max_deg or turn_max_deg, or wider limits of strip and roughness";
            return Err(RescheduleError::new("reschedule-channel", row.line(run, at), message, help));
        };
        Ok(work.handed_out(&best, &course, &freedom))
    }
}

/// What was planned through cells.
struct Planned {
    /// Schedules that stand at the ends, where that can be, and that do not: of all rounds those with the least effort.
    angles: Vec<Vec<Angles>>,
    /// Gates of turn and tilt at the blocks in the last round.
    gates: [Vec<[f64; 2]>; 2],
}

/// What is free at the stretches of a row.
struct Ground {
    scales: [Scale; 2],
    /// Blocks at the stations.
    nodes: Vec<usize>,
    /// How far cells are past the rules ([`Freedom::cells`]), stretch by stretch.
    excess: Vec<Vec<Vec<f64>>>,
    /// Lowest and highest tilt where there are others beyond.
    cut: [Option<f64>; 2],
}

impl Ground {
    /// Within a band of tilts beside those of the program, radian, or of all.
    fn new(
        work: &Work<'_>,
        freedom: &Freedom<'_>,
        course: &[Angles],
        band: Option<f64>,
    ) -> Result<Self, RescheduleError> {
        let (scales, cut) = work.scales(freedom, course, band)?;
        let n = course.len();
        let most = if work.row.rules.is_some() { MOST_JUDGED } else { MOST_STATIONS };
        let stretches = (n - 1).min(most);
        let nodes: Vec<usize> = (0..=stretches).map(|k| k * (n - 1) / stretches).collect();
        let excess = nodes.windows(2).map(|pair| freedom.cells(pair[0]..pair[1] + 1, scales)).collect();
        Ok(Self { scales, nodes, excess, cut })
    }

    fn is_cut(&self) -> bool {
        self.cut.iter().any(Option::is_some)
    }

    /// Whether a tilt is in the last cell before others that are not looked at.
    fn at_cut(&self, tilt: f64) -> bool {
        let step = self.scales[1].step;
        self.cut[0].is_some_and(|low| tilt < low + step) || self.cut[1].is_some_and(|high| tilt > high - step)
    }

    /// Cells that keep the rules by a part of their limits.
    fn cells(&self, margin: f64) -> Cells {
        let mut cells = Cells::new(self.scales);
        for stretch in &self.excess {
            let open = |row: &Vec<f64>| row.iter().map(|excess| *excess <= -margin).collect();
            cells.push(&stretch.iter().map(open).collect::<Vec<Vec<bool>>>());
        }
        cells
    }
}

/// A row with what it is planned in.
struct Work<'a> {
    run: &'a CuttingRun,
    around: &'a Surroundings<'a>,
    row: &'a Row,
    joints: &'a TwoJoints<'a>,
    least: &'a [f64],
    limits: [[f64; 2]; 2],
}

impl SmoothRows {
    /// The way through the cells and the smoothest schedules round it.
    fn planned(
        &self,
        work: &Work<'_>,
        freedom: &Freedom<'_>,
        course: &[Angles],
        (ground, margin): (&Ground, f64),
    ) -> Result<Planned, RescheduleError> {
        let n = course.len();
        let Ground { scales, nodes, .. } = ground;
        let cells = ground.cells(margin);
        let times: Vec<f64> = nodes.windows(2).map(|p| work.least[p[0]..p[1]].iter().sum()).collect();
        let velocities = work.limits.map(|[v, _]| if v.is_finite() { v } else { std::f64::consts::PI });
        let cell = |q: &Angles| -> Cell { [0, 1].map(|j| scales[j].cell(q[j])) };
        let kept = self.ends == RowEnds::Kept;
        let ranges = scales.map(|s| [s.edge(0), s.edge(s.count)]);
        let ends = work.joints.all(&freedom.own[n - 1], ranges);
        let starts = [cell(&course[0])];
        let last: Vec<Cell> = ends.iter().map(cell).collect();
        let way = cells
            .way(kept.then_some(&starts[..]), kept.then_some(&last[..]), &times, velocities)
            .map_err(|closed| work.closed(closed, nodes, freedom, kept))?;
        let end = kept.then(|| {
            let off = |q: &Angles| usize::from(way.last() != Some(&cell(q)));
            ends.iter().copied().min_by_key(off).unwrap_or(course[n - 1])
        });
        let fixed = [kept.then_some(course[0]), end];
        let mut rectangles: Vec<[Cell; 2]> = way.windows(2).map(|w| [w[0], w[1]]).collect();
        let mut planned = Planned { angles: Vec::new(), gates: [Vec::new(), Vec::new()] };
        let mut least: [Option<(f64, Vec<Angles>)>; 2] = [None, None];
        for _ in 0..ROUNDS {
            for (stretch, rectangle) in rectangles.iter_mut().enumerate() {
                *rectangle = cells.grown(stretch, *rectangle);
            }
            let gates = gates(&cells, &rectangles, nodes, fixed);
            let within = Rectangles { gates: &gates, limits: work.limits };
            let mut next = None;
            for (least, rest) in least.iter_mut().zip([true, false]) {
                let Some(mut angles) = within.smoothest(work.least, rest, VELOCITY_GIVEN[0]) else { continue };
                put_ends(&mut angles, fixed);
                let effort = work.effort(&angles);
                if least.as_ref().is_none_or(|(most, _)| effort < *most) {
                    *least = Some((effort, angles.clone()));
                }
                next = Some(angles);
            }
            planned.gates = gates;
            let Some(angles) = next else { break };
            for (stretch, pair) in nodes.windows(2).enumerate() {
                let [mut low, mut high] = [cell(&angles[pair[0]]); 2];
                for q in &angles[pair[0]..=pair[1]] {
                    let c = cell(q);
                    (low, high) = ([low[0].min(c[0]), low[1].min(c[1])], [high[0].max(c[0]), high[1].max(c[1])]);
                }
                if cells.is_free(stretch, [low, high]) {
                    rectangles[stretch] = [low, high];
                }
            }
        }
        planned.angles = least.into_iter().flatten().map(|(_, angles)| angles).collect();
        Ok(planned)
    }

    /// The program before, and what published methods for such rows make of it, as far as the ends keep what they must; those that could be faster, or more even, than
    /// what was found.
    fn add_others(&self, work: &Work<'_>, course: &[Angles], freedom: &Freedom<'_>, found: &mut Vec<Tried>) {
        let shortest: f64 = work.least.iter().sum();
        let best = chosen(found.clone());
        let wanted = |angles: &[Angles]| {
            let done = best.as_ref().filter(|b| b.time() <= shortest * (1.0 + GAIN));
            done.is_none_or(|b| work.effort(angles) < b.effort) && freedom.is_free(angles)
        };
        if wanted(course) {
            found.push(work.tried(course.to_vec(), "program before"));
        }
        let made = |method: &dyn Method| {
            let made = method.reschedule(work.run, work.around).ok()?;
            Some((method.name(), made.poses, made.rotary))
        };
        let methods = match work.row.rules {
            Some(_) => {
                let poses = work.row.by_strip_and_roughness(&self.rules, work.run, work.around);
                vec![poses.map(|poses| (self.rules.name(), poses, None))]
            }
            None => vec![made(&Singularity::default()), made(&MinAngularAcceleration::default())],
        };
        for (name, poses, rotary) in methods.into_iter().flatten() {
            let angles = match rotary {
                Some(rotary) => Ok(rotary.iter().map(|q| work.joints.of(q)).collect()),
                None => work.joints.course(work.run, poses.iter().map(|p| &p.axis)),
            };
            let Ok(Some(angles)) = angles.map(|a: Vec<Angles>| a.get(work.row.stretch.clone()).map(<[_]>::to_vec))
            else {
                continue;
            };
            let same = |i: usize| {
                let [a, b] = [&angles, course].map(|q: &[Angles]| q.get(i).map(|q| work.joints.axis(*q)));
                a.zip(b).is_some_and(|(a, b)| (a - b).norm() < 1e-6)
            };
            if (self.ends == RowEnds::Free || (same(0) && same(course.len() - 1))) && wanted(&angles) {
                found.push(work.tried(angles, name));
            }
        }
    }
}

impl Work<'_> {
    /// Poses of all blocks for angles of the row; lead-in and lead-out keep to its ends.
    fn poses(&self, angles: &[Angles]) -> (Vec<proveout_geom::ToolPose>, Option<Vec<JointValues>>) {
        let stretch = &self.row.stretch;
        let all: Vec<Angles> = (0..self.run.blocks.len())
            .map(|i| angles[i.clamp(stretch.start, stretch.end - 1) - stretch.start])
            .collect();
        let poses = all.iter().enumerate().map(|(i, q)| self.row.pose(i, &self.joints.axis(*q))).collect();
        let told = self.joints.must_be_told(&all);
        (poses, told.then(|| all.iter().map(|q| self.joints.values(*q)).collect()))
    }

    /// A schedule with its time; infinite where the program cannot say it or the control refuses it.
    fn tried(&self, angles: Vec<Angles>, name: &'static str) -> Tried {
        let (poses, rotary) = self.poses(&angles);
        let never = vec![f64::INFINITY; self.least.len()];
        let times = match self.around.time_law {
            _ if rotary.is_some() && self.around.vectors => never,
            Some(law) => {
                let times = law.joint_times(&poses, rotary.as_deref());
                let inside = self.row.stretch.start + 1..self.row.stretch.end;
                times.and_then(|t| t.get(inside).map(<[f64]>::to_vec)).unwrap_or(never)
            }
            None => {
                let needed = |(q, t): (&[Angles], &f64)| {
                    (0..2).map(|j| (q[1][j] - q[0][j]).abs() / self.limits[j][0]).fold(*t, f64::max)
                };
                angles.windows(2).zip(self.least).map(needed).collect()
            }
        };
        Tried { effort: self.effort(&angles), angles, times, name }
    }

    /// Largest acceleration of a schedule over its programmed times, as a part of its joint's limit.
    fn effort(&self, angles: &[Angles]) -> f64 {
        let part =
            |(peak, limit): ([f64; 2], [f64; 2])| if limit[1].is_finite() { peak[1] / limit[1] } else { peak[1] };
        peaks(angles, self.least).into_iter().zip(self.limits).map(part).fold(0.0, f64::max)
    }

    /// Schedules in the times that the control takes for the best one, as long as it is slower than the feed wants.
    fn with_control(&self, gates: &[Vec<[f64; 2]>; 2], found: &[Tried], freedom: &Freedom<'_>) -> Vec<Tried> {
        let shortest: f64 = self.least.iter().sum();
        let mut out: Vec<Tried> = Vec::new();
        if self.around.time_law.is_none() {
            return out;
        }
        let within = Rectangles { gates, limits: self.limits };
        let mut idle = 0;
        for (given, in_time_of_control, rest) in WITH_CONTROL {
            let Some(best) = chosen(found.iter().chain(&out).cloned().collect()) else { break };
            if !best.time().is_finite() || best.time() <= shortest * (1.0 + GAIN) || idle == IDLE {
                break;
            }
            let slower: Vec<f64> = best.times.iter().zip(self.least).map(|(t, l)| t.max(*l)).collect();
            let times = if in_time_of_control { &slower } else { self.least };
            let ends = [best.angles.first().copied(), best.angles.last().copied()];
            idle += 1;
            let Some(mut angles) = within.smoothest(times, rest, given) else { continue };
            put_ends(
                &mut angles,
                ends.map(|e| e.filter(|_| gates[0].iter().chain(&gates[1]).any(|g| g[1] - g[0] < 3.0 * KEPT))),
            );
            if freedom.is_free(&angles) {
                let next = self.tried(angles, "smoothest in the time of the control");
                if next.time() < best.time() * (1.0 - AS_FAST) {
                    idle = 0;
                }
                out.push(next);
            }
        }
        out
    }

    /// Cells of turn and tilt: of the tilt what the limits leave anywhere, within a band beside those of the program where one is given; and where the band
    /// ends before the limits do.
    fn scales(
        &self,
        freedom: &Freedom<'_>,
        course: &[Angles],
        band: Option<f64>,
    ) -> Result<([Scale; 2], [Option<f64>; 2]), RescheduleError> {
        let widths = if self.row.rules.is_some() { FINE_CELLS } else { CELLS };
        let beside = if self.row.rules.is_some() { BESIDE_RULES } else { BESIDE };
        let turns = course.iter().map(|q| q[0]);
        let mut range =
            [turns.clone().fold(f64::INFINITY, f64::min) - beside, turns.fold(f64::NEG_INFINITY, f64::max) + beside];
        if let Some([low, high]) = self.joints.travel(0) {
            range = [range[0].max(low), range[1].min(high)];
        }
        let all = Scale::new(one_turn(self.joints.travel(1)), 0.5 * widths[1]);
        let some = |at: &usize| freedom.some_within(all.edge(*at) + 0.5 * all.step);
        let open: Vec<usize> = (0..all.count).filter(some).collect();
        let (Some(first), Some(last)) = (open.first(), open.last()) else {
            return Err(self.closed(Closed { stretch: 0 }, &[0, 0], freedom, false));
        };
        // The program's own tilts are looked at in any case: where they are not free, the block is told.
        let own = |pick: fn(f64, f64) -> f64, start: f64| course.iter().map(|q| q[1]).fold(start, pick);
        let [low, high] = [own(f64::min, f64::INFINITY), own(f64::max, f64::NEG_INFINITY)];
        let mut tilts = [all.edge(*first).min(low), all.edge(last + 1).max(high)];
        let mut cut = [None; 2];
        if let Some(band) = band {
            // The other branch of both ends too: the way may go through the pole.
            let ends = [freedom.own.first(), freedom.own.last()].into_iter().flatten();
            let ends = ends.flat_map(|axis| self.joints.all(axis, [range, [all.low, all.edge(all.count)]]));
            let (low, high) = ends.fold((low, high), |(low, high), q| (low.min(q[1]), high.max(q[1])));
            let near = [low - band, high + band];
            cut = [(near[0] > tilts[0]).then_some(near[0]), (near[1] < tilts[1]).then_some(near[1])];
            tilts = [tilts[0].max(near[0]), tilts[1].min(near[1])];
        }
        let count = (range[1] - range[0]) / widths[0] * (tilts[1] - tilts[0]) / widths[1];
        let coarser = (count / MOST_CELLS).sqrt().max(1.0);
        Ok(([Scale::new(range, coarser * widths[0]), Scale::new(tilts, coarser * widths[1])], cut))
    }

    fn closed(&self, closed: Closed, nodes: &[usize], freedom: &Freedom<'_>, kept: bool) -> RescheduleError {
        let at = nodes.get(closed.stretch).copied().unwrap_or(0);
        let to = nodes.get(closed.stretch + 1).copied().unwrap_or(at);
        let lean = if freedom.normals.iter().any(Option::is_some) {
            format!(" leans by at most {:.1} degrees,", freedom.lean_max.to_degrees())
        } else {
            String::new()
        };
        let turn = format!(" is within {:.1} degrees of the program's own", freedom.turn_max.to_degrees());
        let rules = if freedom.rules.is_some() { " and keeps gouge, strip and roughness" } else { "" };
        let ends = if kept { ", from and to the axes that the program has at the ends of the row" } else { "" };
        let message = format!(
            "no way of both rotary joints whose axis is free,{lean}{turn}{rules} goes on from here to line {}{ends}",
            self.row.line(self.run, to)
        );
        let help = "set ends=free, a larger lean_max_deg or turn_max_deg, wider limits of strip and roughness, or take a slimmer tool";
        RescheduleError::new("reschedule-channel", self.row.line(self.run, at), message, help)
    }
}

/// The fastest; of those that are as fast the one with the least peak of acceleration.
fn chosen(found: Vec<Tried>) -> Option<Tried> {
    let least = found.iter().map(Tried::time).fold(f64::INFINITY, f64::min);
    let fast = found.into_iter().filter(|t| t.time().is_finite() && t.time() <= least * (1.0 + AS_FAST));
    fast.min_by(|a, b| a.effort.total_cmp(&b.effort))
}

/// Gates at the blocks from rectangles of the stretches between nodes, with ends that are fixed.
fn gates(cells: &Cells, rectangles: &[[Cell; 2]], nodes: &[usize], fixed: [Option<Angles>; 2]) -> [Vec<[f64; 2]>; 2] {
    let n = nodes.last().copied().unwrap_or(0) + 1;
    let mut gates = [vec![[f64::NEG_INFINITY, f64::INFINITY]; n], vec![[f64::NEG_INFINITY, f64::INFINITY]; n]];
    for (rectangle, pair) in rectangles.iter().zip(nodes.windows(2)) {
        let limits = cells.limits(*rectangle);
        for i in pair[0]..=pair[1] {
            for (gates, [low, high]) in gates.iter_mut().zip(limits) {
                gates[i] = [gates[i][0].max(low), gates[i][1].min(high)];
            }
        }
    }
    for (i, end) in [0, n - 1].into_iter().zip(fixed) {
        let Some(q) = end else { continue };
        for (gates, q) in gates.iter_mut().zip(q) {
            gates[i] = [q - KEPT, q + KEPT];
        }
    }
    gates
}

fn put_ends(angles: &mut [Angles], [first, last]: [Option<Angles>; 2]) {
    if let (Some(place), Some(q)) = (angles.first_mut(), first) {
        *place = q;
    }
    if let (Some(place), Some(q)) = (angles.last_mut(), last) {
        *place = q;
    }
}
