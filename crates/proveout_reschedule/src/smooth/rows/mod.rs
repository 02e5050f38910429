//! The smoothest schedule of a row: both rotary joints free, within the room that part and fixtures
//! leave for the tool.
//!
//! A row is a run of blocks along a surface, to one end. Contacts (ball centers), blocks and feeds stay; turn
//! and tilt of the machine are anything that `freedom.rs` allows.
//!
//! 1. *Starts* (`starts.rs`): the program before, the published methods for such rows, even turns from end to
//!    end. Where ends stay and an even turn is free and the fastest of these, nothing else is looked for in
//!    space: it is the least of what follows with nothing in the way.
//! 2. *Globally* (`search.rs`, `cells.rs`): stations along the row, cells of turn and tilt, and the way of
//!    least time from end to end by dynamic programming: the side of the pole, the branch, and what is gone
//!    round; then again in finer cells about what came out.
//! 3. *Locally* (`local.rs`): rectangles of free cells round that way, as large as they become; in
//!    them each joint has the least peak of acceleration over time, then the least jerk. Rectangles
//!    are grown again round the result, and it is solved again.
//! 4. *With the control*, where one is known: in the times that it takes, as long as that gains.
//!
//! The result is the fastest free schedule of all that were tried, starts included, by the time of
//! all blocks of the run with lifts; of those that are equally fast, the one with the least peak of
//! acceleration, as a part of the limits of its joint. Every block of it is proved free or judged
//! from end to end once more.
//!
//! Linear joints that follow the axes are looked at by the control only.

mod cells;
mod freedom;
mod ground;
mod joints;
mod local;
mod row;
mod search;
mod shown;
mod starts;

use proveout_geom::Vector;
use proveout_machine::JointValues;
use schemars::JsonSchema;
use serde::Deserialize;

use self::cells::DeadEnd;
use self::freedom::Freedom;
use self::joints::{Angles, TwoJoints};
use self::local::{Rectangles, peaks};
use self::row::RowBlocks;
use self::starts::between;
use super::super::{CuttingRun, Method, MultiScale, RescheduleError, Rescheduled, Surroundings};
use super::{GAIN, VELOCITY_GIVEN};

/// Largest turn of the axis from the program's own where nothing else limits it, radian.
const TURN_MAX: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// An end that is kept may be off by this while the others are looked for, radian.
const KEPT: f64 = 1e-7;
/// Schedules whose times differ by less than this part are as fast.
const AS_FAST: f64 = 1e-5;
/// What is asked of the control: how many times the least peak of velocity there may be, whether
/// the programs are solved in its own times, and whether the joints are at rest at the ends; given
/// up after some without a gain.
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
/// Whether the axes at both ends of a row stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RowEnds {
    /// As the program has them.
    Kept,
    /// They move as all others do.
    Free,
}

impl RowEnds {
    /// Every rule with its name.
    pub const NAMES: [(&'static str, Self); 2] = [("kept", Self::Kept), ("free", Self::Free)];
}

/// Parameters of the method for rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothRows {
    /// Largest lean of the tool axis from the normal of the surface, radian.
    pub lean_max: f64,
    /// Largest turn of the tool axis from the program's own, radian. None: 15 degrees, but for ball ends on a
    /// surface that is known.
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
struct RowSchedule {
    angles: Vec<Angles>,
    /// Times of the blocks after the first, by the control where it is known, s.
    times: Vec<f64>,
    /// Time of all blocks of the run, with what leads to the row and away from it, s.
    whole: f64,
    /// Largest acceleration as a part of its joint's limit, at the programmed feed.
    effort: f64,
    origin: ScheduleOrigin,
}

/// Where a schedule comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ScheduleOrigin {
    /// The search of this method.
    Search,
    /// Even turns from one end to the other.
    Even,
    /// The program itself, or another method.
    Given,
}

impl RowSchedule {
    fn time(&self) -> f64 {
        self.times.iter().sum()
    }

    fn ends(&self) -> Option<[Angles; 2]> {
        Some([*self.angles.first()?, *self.angles.last()?])
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
            let message = "the machine does not have two rotary joints that turn the tool axis";
            return Err(RescheduleError::new("reschedule-path", first, message, "choose a five-axis machine"));
        };
        let row = RowBlocks::new(self, run, around)?;
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
        let work = RowContext {
            run,
            around,
            row: &row,
            joints: &joints,
            least: &least,
            limits: [0, 1].map(|j| joints.limits(j)),
        };
        let mut found = self.starts(&work, &course, &freedom);
        let even =
            chosen(found.clone()).filter(|best| best.origin == ScheduleOrigin::Even && self.ends == RowEnds::Kept);
        if let Some(ends) = even.and_then(|best| best.ends()) {
            // It is what is looked for where nothing is in the way: what is in the way can only take of that.
            found.extend(work.with_control(&between(ends, course.len()), &found, &freedom));
        } else {
            self.search(&work, &course, &freedom, &mut found)?;
        }
        let Some(best) = chosen(found) else {
            let at = freedom.first_taken(&course).unwrap_or(0);
            let message = "neither a new schedule nor that of the program keeps all limits of this block";
            let help = "set a larger lean_max_deg or turn_max_deg, or wider limits of strip and roughness";
            return Err(RescheduleError::new("reschedule-channel", row.line(run, at), message, help));
        };
        Ok(work.handed_out(&best, &course, &freedom))
    }
}

/// A row with what it is planned in.
struct RowContext<'a> {
    run: &'a CuttingRun,
    around: &'a Surroundings<'a>,
    row: &'a RowBlocks,
    joints: &'a TwoJoints<'a>,
    least: &'a [f64],
    limits: [[f64; 2]; 2],
}

impl RowContext<'_> {
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
    fn tried(&self, angles: Vec<Angles>, origin: ScheduleOrigin) -> RowSchedule {
        let (poses, rotary) = self.poses(&angles);
        let never = vec![f64::INFINITY; self.least.len()];
        let mut whole = None;
        let times = match self.around.time_law {
            _ if rotary.is_some() && self.around.vectors => never,
            Some(law) => {
                let times = law.joint_times(&poses, rotary.as_deref());
                whole = times.as_ref().map(|t| t.iter().sum());
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
        let whole = whole.unwrap_or_else(|| times.iter().sum());
        RowSchedule { effort: self.effort(&angles), angles, times, whole, origin }
    }

    /// Largest acceleration of a schedule over its programmed times, as a part of its joint's limit.
    fn effort(&self, angles: &[Angles]) -> f64 {
        let part =
            |(peak, limit): ([f64; 2], [f64; 2])| if limit[1].is_finite() { peak[1] / limit[1] } else { peak[1] };
        peaks(angles, self.least).into_iter().zip(self.limits).map(part).fold(0.0, f64::max)
    }

    /// Schedules in the times that the control takes for the best one, as long as it is slower than the feed
    /// wants.
    fn with_control(
        &self,
        gates: &[Vec<[f64; 2]>; 2],
        found: &[RowSchedule],
        freedom: &Freedom<'_>,
    ) -> Vec<RowSchedule> {
        let shortest: f64 = self.least.iter().sum();
        let mut out: Vec<RowSchedule> = Vec::new();
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
                let next = self.tried(angles, ScheduleOrigin::Search);
                if next.time() < best.time() * (1.0 - AS_FAST) {
                    idle = 0;
                }
                out.push(next);
            }
        }
        out
    }

    fn closed(&self, closed: DeadEnd, nodes: &[usize], freedom: &Freedom<'_>, kept: bool) -> RescheduleError {
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
fn chosen(found: Vec<RowSchedule>) -> Option<RowSchedule> {
    let possible = |t: &RowSchedule| t.time().is_finite() && t.whole.is_finite();
    let least = found.iter().filter(|t| possible(t)).map(|t| t.whole).fold(f64::INFINITY, f64::min);
    let fast = found.into_iter().filter(|t| possible(t) && t.whole <= least * (1.0 + AS_FAST));
    fast.min_by(|a, b| a.effort.total_cmp(&b.effort))
}

fn put_ends(angles: &mut [Angles], [first, last]: [Option<Angles>; 2]) {
    if let (Some(place), Some(q)) = (angles.first_mut(), first) {
        *place = q;
    }
    if let (Some(place), Some(q)) = (angles.last_mut(), last) {
        *place = q;
    }
}
