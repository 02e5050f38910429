use proveout_machine::{JointValues, MAX_JOINTS, Machine};

use crate::{
    limits::JointLimits,
    output::{MoveKind, Sample},
    summary::{JointSummary, Summary, UnlimitedJoint},
    tube::Tube,
};

/// Speeds below this (mm/s or rad/s) do not tell a direction of motion.
const STANDSTILL: f64 = 1e-6;

/// Part by which the feed must fall, or rise, to be taken for falling or rising.
const STEADY: f64 = 1e-3;

/// Looks for places of low feed between the ramps of a run: where the feed falls and rises again without a stop.
///
/// ```text
///   feed |   ____      ___
///        |  /    \    /   \        ramps from and to a standstill do not count: the lowest place does,
///        | /      \__/     \       and where there is none, the highest
///        |/        x        ///        +-----------------------> t
/// ```
#[derive(Clone, Copy, Debug, Default)]
struct FeedWatch {
    /// Highest part of the programmed feed since the last standstill.
    reached: Option<f64>,
    /// Highest feed while it rises, lowest while it falls.
    turn: f64,
    /// The part of the programmed feed at the lowest feed, while it falls; none there in rapid motion.
    falling: Option<Option<f64>>,
}

impl FeedWatch {
    /// The lowest place that this feed turns out to be behind; `programmed` is zero in rapid motion.
    fn next(&mut self, feed: f64, programmed: f64) -> Option<f64> {
        let part = (programmed > 0.0).then(|| feed / programmed);
        if let Some(part) = part {
            self.reached = Some(self.reached.map_or(part, |most| most.max(part)));
        }
        match self.falling {
            None if feed >= self.turn * (1.0 - STEADY) => self.turn = self.turn.max(feed),
            Some(_) if feed > self.turn * (1.0 + STEADY) => {
                self.turn = feed;
                return self.falling.take().flatten();
            }
            Some(_) if feed >= self.turn => {}
            _ => (self.turn, self.falling) = (feed, Some(part)),
        }
        None
    }

    /// A standstill: the highest part of the programmed feed before it.
    fn rest(&mut self) -> Option<f64> {
        std::mem::take(self).reached
    }
}

/// Collects the summary while the run goes on.
pub(crate) struct Meter {
    pub(crate) summary: Summary,
    feed: FeedWatch,
    /// Bounds of the time on the path that is run, and on any within the tolerances.
    pub(crate) bound_s: f64,
    pub(crate) tube: Tube,
    low: JointValues,
    high: JointValues,
    velocity: JointValues,
    acceleration: JointValues,
    jerk: JointValues,
    direction: [i8; MAX_JOINTS],
    reversals: [u32; MAX_JOINTS],
}

impl Meter {
    pub(crate) fn new(start: &JointValues) -> Self {
        Self {
            summary: Summary::default(),
            feed: FeedWatch::default(),
            bound_s: 0.0,
            tube: Tube::default(),
            low: *start,
            high: *start,
            velocity: JointValues::ZERO,
            acceleration: JointValues::ZERO,
            jerk: JointValues::ZERO,
            direction: [0; MAX_JOINTS],
            reversals: [0; MAX_JOINTS],
        }
    }

    pub(crate) fn position(&mut self, q: &JointValues) {
        self.low = self.low.zip_map(*q, f64::min);
        self.high = self.high.zip_map(*q, f64::max);
    }

    /// A part of the programmed feed that was not passed.
    pub(crate) fn feed_ratio(&mut self, ratio: f64) {
        let least = self.summary.min_feed_ratio.get_or_insert(1.0);
        *least = least.min(ratio);
    }

    /// The machine stands.
    pub(crate) fn rest(&mut self) {
        if let Some(part) = self.feed.rest() {
            self.feed_ratio(part);
        }
    }

    pub(crate) fn sample(&mut self, sample: &Sample) {
        self.position(&sample.actual);
        if let Some(part) = self.feed.next(sample.feed, sample.feed_programmed) {
            self.feed_ratio(part);
        }
        let high = |m: f64, v: f64| m.max(v.abs());
        self.velocity = self.velocity.zip_map(sample.velocity, high);
        self.acceleration = self.acceleration.zip_map(sample.acceleration, high);
        self.jerk = self.jerk.zip_map(sample.jerk, high);
        for i in 0..MAX_JOINTS {
            let v = sample.velocity[i];
            if v.abs() > STANDSTILL {
                let direction = if v > 0.0 { 1 } else { -1 };
                if self.direction[i] == -direction {
                    self.reversals[i] += 1;
                }
                self.direction[i] = direction;
            }
        }
    }

    pub(crate) fn motion(&mut self, kind: MoveKind, seconds: f64) {
        match kind {
            MoveKind::Feed => self.summary.cutting_s += seconds,
            MoveKind::Rapid | MoveKind::Handling => self.summary.rapid_s += seconds,
        }
    }

    /// The summary so far, at the given time and position.
    pub(crate) fn summary(&self, machine: &Machine, limits: &JointLimits, time: f64, q: &JointValues) -> Summary {
        let mut s = self.summary.clone();
        s.total_s = time;
        s.end_position = *q;
        let any = self.tube.bound_s();
        // The path that is run is one of those within the tolerances.
        (s.lower_bound_s, s.path_bound_s) = (Some(any), Some(self.bound_s.max(any)));
        let use_of = |value: f64, limit: f64| limit.is_finite().then(|| value / limit);
        s.joints = (0..limits.count)
            .map(|i| JointSummary {
                min: self.low[i],
                max: self.high[i],
                max_velocity: self.velocity[i],
                max_acceleration: self.acceleration[i],
                max_jerk: self.jerk[i],
                velocity_utilisation: use_of(self.velocity[i], limits.velocity[i]),
                acceleration_utilisation: use_of(self.acceleration[i], limits.acceleration[i]),
                jerk_utilisation: use_of(self.jerk[i], limits.jerk[i]),
                reversals: self.reversals[i],
                drive: None,
            })
            .collect();
        s.unlimited_joints = (0..limits.count)
            .map(|i| UnlimitedJoint {
                joint: machine.joints[i].name.clone(),
                velocity: limits.velocity[i].is_infinite(),
                acceleration: limits.acceleration[i].is_infinite(),
                jerk: limits.jerk[i].is_infinite(),
            })
            .filter(|u| u.velocity || u.acceleration || u.jerk)
            .collect();
        s
    }
}
