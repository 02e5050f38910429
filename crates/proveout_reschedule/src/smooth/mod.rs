//! The smoothest axes of a channel: least time by the velocity of the rotary axis first, then the least peak
//! of its acceleration, in time.
//!
//! A method of this project, for paths as [`super::STheta`] takes them. Ball centers and the inclination of
//! the tool axis to the table axis stay; the angle about the table axis is anything in a [`Channel`]: that of
//! the paper with its clearance, or what the tool itself leaves free ([`ChannelKind::Tool`],
//! `tool_channel.rs`). A schedule is judged by time, not by its shape over the path:
//!
//! 1. *Globally*: over the nominal time (the sum of the programmed times of blocks) the taut string through
//!    the gates with both ends free. It minimizes the sum of every convex function of the slopes at once,
//!    that of `max(least time, way / velocity)` among them, so that no schedule is faster by feed and
//!    velocity. Where it is steeper than the joint can turn, the time of its blocks grows by that.
//! 2. *Locally*: in that time the spline with the least peak of acceleration, then with the least jerk
//!    (`spline_in_corridor.rs`): a convex program.
//! 3. *With the control*, where one is known ([`TimeLaw`]): it is asked for the times of the blocks, and the
//!    program is solved again in those, as long as that gains.
//!
//! Between the fastest schedule for the control of these and the one with the least peak of
//! acceleration two more lie in the channel, which is convex. The result is, of those within
//! `given_up` of the fastest, the one with the least peak between the ramps. The original program
//! or s-theta, as far as they are in the channel, replaces it where they are faster, or, where the
//! feed leaves nothing to gain, have a lower peak (the local stage gives its velocity a bound of
//! its own, they may turn faster). Only the control checks the linear joints that follow the axes.
//! Without a jump of speed at its ends the angle is constant there, as in lead-in and lead-out.
//!
//! *Between blocks*: limits and angles run straight from block to block, so that what holds at both
//! ends of a block holds between them; the free intervals of the tool are proved for whole blocks.

pub(super) mod corridor_program;
mod rows;
mod spline_in_corridor;
mod tries;

use std::f64::consts::TAU;

use proveout_machine::{Carries, Joint, Machine};

use self::spline_in_corridor::Corridor;
pub(super) use self::tries::peaks;
use self::tries::{TimedSchedule, effort};
use super::s_theta::{curve, poses, rescheduled, study};
use super::study::{ChannelWidth, KeptSchedule};
use super::taut::{TautGate, free_taut_string};
use super::tool_channel::ToolChannel;
use super::{
    Channel, Curve, CurveKind, CuttingRun, Figure, Method, RescheduleError, Rescheduled, STHETA_DEFAULTS, STheta,
    SectionPath, Surroundings,
};
pub use rows::{RowEnds, SmoothRows};

/// Part of the joint's velocity that is planned with at most.
const VELOCITY_USED: f64 = 0.995;
/// Where the string itself needs more than this part of it, its blocks take longer.
const VELOCITY_OF_STRING: f64 = 0.985;
/// The peak of velocity may be this many times the least one, in the order in which it is tried: what is
/// faster than needed leaves room for less acceleration.
const VELOCITY_GIVEN: [f64; 2] = [1.25, 1.02];
/// Part of the joint's acceleration that ramps at the ends of the path take.
const RAMP_PART: f64 = 0.25;
/// Acceleration of the ramps where the machine gives none, rad/s2.
const RAMP: f64 = 3.0;
/// Nothing more is tried where no other schedule can be faster than by this part.
const GAIN: f64 = 5e-4;
/// More of the time is not given up for a lower peak of acceleration, part.
const MOST_GIVEN_UP: f64 = 0.1;
/// Rounding of sums of angles, radian.
const ROUNDED: f64 = 1e-9;
/// Another clearance of the same rule, shown together with the published one, radian.
const OTHER_CLEARANCE: f64 = 10.0 * TAU / 360.0;
/// Part of the time that is given up where none is stated.
const USUAL_GIVEN_UP: f64 = 1e-3;
/// Speed of a joint that is planned for at least, rad/s: one that stands still needs none.
const LEAST_SPEED: f64 = 1e-6;

/// Where the limits of the angle come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelKind {
    /// The rule of Li et al. 2022 with a clearance on both sides.
    Clearance,
    /// What the tool leaves free.
    Tool,
}

/// Parameters of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smooth {
    /// The channel.
    pub channel: ChannelKind,
    /// Clearance of the channel by the paper's rule, radian.
    pub clearance: f64,
    /// Largest lean of the tool axis from the normal in the channel of the tool, radian.
    pub lean_max: f64,
    /// The axis does not turn back.
    pub monotone: bool,
    /// Part of the time of the control that is given up for a lower peak of acceleration.
    pub given_up: f64,
}

impl Default for Smooth {
    /// The published clearance of 50 degrees; a lean of 80, beyond which the end of a ball does not cut but
    /// its side; no turning back; a tenth of a percent of the time.
    fn default() -> Self {
        Self {
            channel: ChannelKind::Clearance,
            clearance: STHETA_DEFAULTS.clearance,
            lean_max: 80.0 * TAU / 360.0,
            monotone: true,
            given_up: USUAL_GIVEN_UP,
        }
    }
}

/// Limits of the joint that turns the angle; infinite where there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnLimits {
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Acceleration, rad/s2.
    pub acceleration: f64,
}

/// Angles that the method has planned without a control.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothPlan {
    /// Angle at each block, radian.
    pub angles: Vec<f64>,
    /// Largest acceleration between the ramps, rad/s2; none where the channel bends so sharply that the taut
    /// string was left.
    pub acceleration: Option<f64>,
}

impl TurnLimits {
    /// Those of the rotary joint next to the workpiece.
    fn of(machine: Option<&Machine>) -> Self {
        let table = |m: &&Machine| {
            let last = m.work_chain.iter().rfind(|&&j| m.joints[j].is_rotary());
            last.map(|&j| m.joints[j].clone()).filter(|j| j.carries == Carries::Workpiece)
        };
        let joint: Option<Joint> = machine.as_ref().and_then(table);
        let velocity = joint.as_ref().and_then(|j| j.max_velocity).filter(|v| *v > 0.0).unwrap_or(f64::INFINITY);
        let acceleration = joint.and_then(|j| j.max_acceleration).filter(|a| *a > 0.0).unwrap_or(f64::INFINITY);
        Self { velocity, acceleration }
    }

    fn ramp(&self) -> f64 {
        if self.acceleration.is_finite() { RAMP_PART * self.acceleration } else { RAMP }
    }
}

impl Smooth {
    fn check(&self) -> Result<(), RescheduleError> {
        let quarter = 0.25 * TAU;
        let options = [
            ("clearance_deg", self.clearance, (0.0..quarter).contains(&self.clearance)),
            ("lean_max_deg", self.lean_max, self.lean_max > 0.0 && self.lean_max <= quarter),
        ];
        if !(0.0..=MOST_GIVEN_UP).contains(&self.given_up) {
            return Err(RescheduleError::new(
                "reschedule-option",
                0,
                format!("max_time_loss_percent = {:.6} of smooth is outside of its range", 100.0 * self.given_up),
                "0 to 10 percent",
            ));
        }
        let Some((key, value, _)) = options.into_iter().find(|(.., fits)| !fits) else { return Ok(()) };
        Err(RescheduleError::new(
            "reschedule-option",
            0,
            format!("{key} = {:.6} of smooth is outside of its range", value.to_degrees()),
            "clearance 0 to 90 degrees, largest lean above 0 to 90 degrees",
        ))
    }

    /// The gates that a schedule of this method keeps: the channel, or what of it an angle that does not fall
    /// can reach.
    fn gates(&self, path: &SectionPath, channel: &Channel) -> Result<Vec<[f64; 2]>, RescheduleError> {
        let mut gates: Vec<[f64; 2]> = channel.lower.iter().zip(&channel.upper).map(|(l, u)| [*l, *u]).collect();
        if self.monotone {
            for i in 1..gates.len() {
                gates[i][0] = gates[i][0].max(gates[i - 1][0]);
            }
            for i in (0..gates.len().saturating_sub(1)).rev() {
                gates[i][1] = gates[i][1].min(gates[i + 1][1]);
            }
        }
        match gates.iter().position(|[low, high]| low > high) {
            None => Ok(gates),
            Some(first) => Err(RescheduleError::new(
                "reschedule-channel",
                path.lines[first],
                format!(
                    "no angle that only grows passes the channel: it must be at least {:.2} degrees here and at most {:.2} degrees later",
                    gates[first][0].to_degrees(),
                    gates[first][1].to_degrees()
                ),
                "set monotone=false, a smaller clearance or a larger lean",
            )),
        }
    }

    /// The angles with the least peak of acceleration in a channel, where the blocks after the
    /// first take at least these times. Of the path only its lines are used.
    ///
    /// # Errors
    /// `reschedule-channel`: no angle passes the channel.
    pub fn plan(
        &self,
        path: &SectionPath,
        channel: &Channel,
        least: &[f64],
        limits: TurnLimits,
    ) -> Result<SmoothPlan, RescheduleError> {
        self.check()?;
        let gates = self.gates(path, channel)?;
        self.solve(path, &gates, least, limits, VELOCITY_GIVEN[0])
    }

    fn solve(
        &self,
        path: &SectionPath,
        gates: &[[f64; 2]],
        least: &[f64],
        limits: TurnLimits,
        given: f64,
    ) -> Result<SmoothPlan, RescheduleError> {
        let mut times = vec![0.0];
        for t in least {
            times.push(times[times.len() - 1] + t);
        }
        let row = gates.iter().zip(&times).map(|([low, high], s)| TautGate { s: *s, low: *low, high: *high });
        let string = free_taut_string(&row.collect::<Vec<_>>()).map_err(|gate| {
            let message = "the channel is closed here".to_owned();
            RescheduleError::new("reschedule-channel", path.lines[gate], message, "set a smaller clearance")
        })?;
        let way = kept(at_gates(&string, &times), gates);
        // Where the joint cannot turn as fast as the string wants it, time grows.
        let most = VELOCITY_OF_STRING * limits.velocity;
        let mut stretched = vec![0.0];
        for (i, t) in least.iter().enumerate() {
            let needed = (way[i + 1] - way[i]).abs() / most;
            stretched.push(stretched[i] + t.max(needed));
        }
        let slope = |i: usize| (way[i + 1] - way[i]).abs() / (stretched[i + 1] - stretched[i]);
        let needed = (0..least.len()).map(slope).fold(LEAST_SPEED, f64::max);
        let corridor = Corridor {
            times: &stretched,
            gates,
            way: &way,
            velocity: (VELOCITY_USED * limits.velocity).min(given * needed),
            rising: self.monotone,
            ramp: limits.ramp(),
            rests: &[true, false],
        };
        // A channel that bends within a block leaves nothing but the string.
        Ok(match corridor.least_peak() {
            Some(found) => SmoothPlan { angles: found.angles, acceleration: Some(found.acceleration) },
            None => SmoothPlan { angles: way, acceleration: None },
        })
    }
}

impl Smooth {
    /// Schedules of others that are in the gates: the program's own, and that of s-theta.
    fn others(&self, path: &SectionPath, gates: &[[f64; 2]]) -> Vec<(KeptSchedule, Vec<f64>)> {
        let s_theta = STheta { clearance: self.clearance, ..STHETA_DEFAULTS };
        let planned = Channel::tabulated(path, self.clearance, 2.0 * s_theta.inset);
        let planned = planned.and_then(|channel| s_theta.plan(path, &channel)).map(|plan| plan.angles);
        let inside = |angles: &Vec<f64>| {
            let fits = angles.iter().zip(gates).all(|(q, [low, high])| *q >= low - ROUNDED && *q <= high + ROUNDED);
            fits && (!self.monotone || angles.windows(2).all(|q| q[1] >= q[0] - ROUNDED))
        };
        let others =
            [(KeptSchedule::OwnAxes, Some(path.axis_angle.clone())), (KeptSchedule::STheta, planned.ok())].into_iter();
        let others = others.filter_map(|(whose, angles)| Some((whose, angles?))).filter(|(_, angles)| inside(angles));
        others.map(|(whose, angles)| (whose, kept(angles, gates))).collect()
    }
}

/// Angles clamped to their gates, which rounding may have left slightly.
fn kept(mut angles: Vec<f64>, gates: &[[f64; 2]]) -> Vec<f64> {
    angles.iter_mut().zip(gates).for_each(|(q, [low, high])| *q = q.clamp(*low, *high));
    angles
}

/// Adds the limits of the tool to those that were kept.
fn add_limits(curves: &mut Vec<Curve>, path: &SectionPath, channel: &Channel) {
    for (name, values) in
        [("forward limit by the tool", &channel.upper), ("backward limit by the tool", &channel.lower)]
    {
        curves.push(curve(name, CurveKind::Limit, path.arc.iter().zip(values).map(|(s, v)| [*s, *v])));
    }
}

/// Values of a polyline at rising abscissas within it.
fn at_gates(string: &[[f64; 2]], times: &[f64]) -> Vec<f64> {
    let mut k = 0;
    times
        .iter()
        .map(|&t| {
            while k + 2 < string.len() && string[k + 1][0] < t {
                k += 1;
            }
            let (Some(a), Some(b)) = (string.get(k), string.get(k + 1)) else { return string[k][1] };
            let part = if b[0] > a[0] { ((t - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0) } else { 1.0 };
            a[1] + (b[1] - a[1]) * part
        })
        .collect()
}

/// Least peak of the velocity in a channel at the programmed feed, rad/s.
fn least_velocity(channel: &Channel, least: &[f64]) -> Option<f64> {
    let mut s = 0.0;
    let mut gates = Vec::with_capacity(channel.lower.len());
    for (i, (low, high)) in channel.lower.iter().zip(&channel.upper).enumerate() {
        gates.push(TautGate { s, low: *low, high: *high });
        s += least.get(i).copied().unwrap_or(0.0);
    }
    let string = free_taut_string(&gates).ok()?;
    Some(string.windows(2).map(|p| ((p[1][1] - p[0][1]) / (p[1][0] - p[0][0])).abs()).fold(0.0, f64::max))
}

impl Method for Smooth {
    fn name(&self) -> &'static str {
        "smooth"
    }

    fn source(&self) -> &'static str {
        "this project: taut string over time, least peak of acceleration"
    }

    fn needs_region(&self) -> bool {
        // The channel of the tool is shown together with the others where the part is known.
        true
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        self.check()?;
        let path = SectionPath::new(run, around)?;
        let own = &run.blocks[path.stretch()];
        let least: Option<Vec<f64>> =
            own.iter().skip(1).map(|b| b.time.filter(|t| t.is_finite() && *t > 0.0)).collect();
        let Some(least) = least else {
            let first = own.iter().skip(1).find(|b| b.time.is_none_or(|t| !(t.is_finite() && t > 0.0)));
            let line = first.map_or(0, |b| b.line);
            return Err(RescheduleError::new(
                "reschedule-path",
                line,
                "the program gives this block no feed, so its time is not known",
                "program a feed before it",
            ));
        };
        let rule = |clearance: f64, narrowest: f64| Channel::tabulated(&path, clearance, narrowest);
        let tool = ToolChannel { lean_max: self.lean_max }.channel(&path, around);
        let channel = match self.channel {
            ChannelKind::Clearance => rule(self.clearance, 0.0)?,
            ChannelKind::Tool => tool.clone()?,
        };
        let gates = self.gates(&path, &channel)?;
        let limits = TurnLimits::of(around.machine);
        let shortest: f64 = least.iter().sum();
        let stretch = path.stretch().start + 1..path.stretch().end;
        let judged = |angles: &[f64]| -> Option<Vec<f64>> {
            let times = around.time_law?.block_times(&poses(run, &path, angles))?;
            times.get(stretch.clone()).map(<[f64]>::to_vec)
        };
        let SmoothPlan { angles, acceleration: asked } =
            self.solve(&path, &gates, &least, limits, VELOCITY_GIVEN[0])?;
        let mut best = TimedSchedule { angles, time: f64::INFINITY, asked };
        let mut rounds = 0;
        let mut of_other = None;
        if let Some(mut times) = judged(&best.angles) {
            let mut fastest: f64 = times.iter().sum();
            best.time = fastest;
            let mut all = vec![best.clone()];
            // In the time of the control, then with less room for the velocity, in both times.
            let [roomy, tight] = VELOCITY_GIVEN;
            for (given, in_time_of_control) in [(roomy, true), (tight, false), (tight, true)] {
                if fastest <= shortest * (1.0 + GAIN) {
                    break;
                }
                // No block is planned with less than its own time.
                let slower: Vec<f64> = times.iter().zip(&least).map(|(t, l)| t.max(*l)).collect();
                let blocks = if in_time_of_control { &slower } else { &least };
                let SmoothPlan { angles, acceleration } = self.solve(&path, &gates, blocks, limits, given)?;
                let Some(next) = judged(&angles) else { continue };
                let time: f64 = next.iter().sum();
                all.push(TimedSchedule { angles, time, asked: acceleration });
                if time < fastest * (1.0 - GAIN) {
                    (fastest, times) = (time, next);
                }
            }
            if fastest > shortest * (1.0 + GAIN) {
                for angles in tries::between(&all, &least) {
                    let angles = kept(angles, &gates);
                    let Some(times) = judged(&angles) else { continue };
                    all.push(TimedSchedule { angles, time: times.iter().sum(), asked: None });
                }
            }
            rounds = all.len();
            best = tries::chosen(all, &least, self.given_up).unwrap_or(best);
        }
        if best.time.is_finite() {
            // Where feed leaves no time to gain, what is smoother gains still.
            let at_feed = best.time <= shortest * (1.0 + GAIN);
            for (whose, angles) in self.others(&path, &gates) {
                if at_feed && effort(&angles, &least) >= effort(&best.angles, &least) {
                    continue;
                }
                let Some(times) = judged(&angles) else { continue };
                let time: f64 = times.iter().sum();
                if time < best.time || at_feed && time <= shortest * (1.0 + GAIN) {
                    best = TimedSchedule { angles, time, asked: None };
                    of_other = Some(whose);
                }
            }
        }
        let TimedSchedule { angles, asked, .. } = best;
        let mut study = study(&path, &channel, &angles);
        let mut figure = |name, unit, value: f64| study.figures.push(Figure { name, unit, value });
        let [velocity, acceleration] = peaks(&angles, &least).map(f64::to_degrees);
        figure("peak velocity at the programmed feed", "deg/s", velocity);
        figure("peak acceleration at the programmed feed, ramps too", "deg/s2", acceleration);
        if let Some(planned) = asked {
            figure("peak acceleration between the ramps, as planned", "deg/s2", planned.to_degrees());
        }
        figure("times the control was asked", "", rounds as f64);
        study.kept = of_other;
        study.figures.extend(of_other.map(KeptSchedule::figure));
        let published = rule(STHETA_DEFAULTS.clearance, f64::MIN).ok();
        let other = rule(OTHER_CLEARANCE, f64::MIN).ok();
        let by_tool = tool.ok();
        let shown = [
            (
                published,
                "clearance 50 deg",
                ["narrowest channel, clearance 50 deg", "least peak velocity, clearance 50 deg"],
            ),
            (
                other,
                "clearance 10 deg",
                ["narrowest channel, clearance 10 deg", "least peak velocity, clearance 10 deg"],
            ),
            (by_tool.clone(), "by the tool", ["narrowest channel, by the tool", "least peak velocity, by the tool"]),
        ];
        for (channel, name, [narrowest, fastest]) in shown {
            let Some(channel) = channel else { continue };
            let width = (0..path.len()).map(|i| channel.width(i)).fold(f64::MAX, f64::min);
            let narrowest_deg = width.to_degrees();
            let least_velocity_deg_s = least_velocity(&channel, &least).map(f64::to_degrees);
            study.figures.push(Figure { name: narrowest, unit: "deg", value: narrowest_deg });
            let velocity = least_velocity_deg_s.map(|value| Figure { name: fastest, unit: "deg/s", value });
            study.figures.extend(velocity);
            study.channels.push(ChannelWidth { name, narrowest_deg, least_velocity_deg_s });
        }
        if let (ChannelKind::Clearance, Some(channel)) = (self.channel, &by_tool) {
            add_limits(&mut study.curves, &path, channel);
        }
        Ok(rescheduled(run, &path, &channel, angles, study))
    }
}
