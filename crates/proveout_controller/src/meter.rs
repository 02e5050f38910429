use proveout_machine::{JointValues, MAX_JOINTS, Machine};

use crate::{
    limits::JointLimits,
    output::{MoveKind, Sample},
    summary::{JointSummary, Summary, UnlimitedJoint},
    tube::Tube,
};

/// Below this speed (mm/s or rad/s) a motion has no direction.
const STANDSTILL: f64 = 1e-6;

/// Part by which the feed must fall, or rise, to be taken for falling or rising.
const STEADY: f64 = 1e-3;

/// Looks for places of low feed between the ramps of a motion in feed: where the feed falls and rises again
/// without a stop.
///
/// ```text
///   feed |   ____      ___
///        |  /    \    /   \        Ramps from and to a standstill or a rapid motion do not count. The
///        | /      \__/     \       lowest place between them does, and where there is none, the highest.
///        |/        x        \
///        +-----------------------> t
/// ```
#[derive(Clone, Copy, Debug, Default)]
struct FeedWatch {
    trend: Trend,
    /// Highest feed while it rises, else lowest.
    turn: f64,
    /// Highest part of the programmed feed since the begin.
    reached: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Trend {
    /// Nothing is known yet.
    #[default]
    Begin,
    /// Falls on from what was before.
    Entering,
    Rising,
    /// With the part of the programmed feed at the lowest place.
    Falling(f64),
}

impl FeedWatch {
    /// The part of the programmed feed at a minimum, once this feed shows that the minimum has been
    /// passed.
    fn next(&mut self, feed: f64, programmed: f64) -> Option<f64> {
        let part = feed / programmed;
        if self.trend == Trend::Begin {
            self.turn = feed;
        }
        self.reached = Some(self.reached.map_or(part, |most| most.max(part)));
        let (rises, falls) = (feed > self.turn * (1.0 + STEADY), feed < self.turn * (1.0 - STEADY));
        let found = match self.trend {
            Trend::Falling(lowest) if rises => Some(lowest),
            _ => None,
        };
        self.trend = match self.trend {
            Trend::Begin => Trend::Entering,
            _ if rises => Trend::Rising,
            Trend::Rising if falls => Trend::Falling(part),
            Trend::Falling(_) if feed < self.turn => Trend::Falling(part),
            as_it_was => as_it_was,
        };
        self.turn = match self.trend {
            Trend::Rising => self.turn.max(feed),
            Trend::Falling(_) | Trend::Entering | Trend::Begin => self.turn.min(feed),
        };
        found
    }

    /// The highest part of the programmed feed before the end of a motion in feed.
    fn end(&mut self) -> Option<f64> {
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

    /// A motion in feed has ended.
    pub(crate) fn rest(&mut self) {
        if let Some(part) = self.feed.end() {
            self.feed_ratio(part);
        }
    }

    /// The feed at a sample of a motion in feed, outside of corners to other motions.
    pub(crate) fn feed(&mut self, feed: f64, programmed: f64) {
        let found = if programmed > 0.0 { self.feed.next(feed, programmed) } else { None };
        if let Some(part) = found {
            self.feed_ratio(part);
        }
    }

    /// Takes note of how far a place of the motion is from the programmed way: mm and radian.
    pub(crate) fn off_program(&mut self, off: Option<(f64, f64)>) {
        if let Some((tip, angle)) = off {
            self.summary.max_contour_error_mm = self.summary.max_contour_error_mm.max(tip);
            self.summary.max_axis_error = self.summary.max_axis_error.max(angle);
        }
    }

    pub(crate) fn sample(&mut self, sample: &Sample) {
        self.position(&sample.actual);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Lowest place and highest part of a row of feeds, 10 being programmed.
    fn seen(feeds: &[f64]) -> (Option<f64>, Option<f64>) {
        let mut watch = FeedWatch::default();
        let mut lowest: Option<f64> = None;
        for feed in feeds {
            if let Some(part) = watch.next(*feed, 10.0) {
                lowest = Some(lowest.map_or(part, |low| low.min(part)));
            }
        }
        (lowest, watch.end())
    }

    #[test]
    fn dips_count_and_ramps_do_not() {
        assert_eq!(seen(&[0.0, 2.0, 8.0, 10.0, 10.0, 7.0, 1.0, 0.0]), (None, Some(1.0)));
        assert_eq!(seen(&[0.0, 8.0, 10.0, 6.0, 5.0, 9.0, 10.0, 8.0, 9.0, 3.0]), (Some(0.5), Some(1.0)));
        // From a rapid motion through a corner: what falls first belongs to the corner.
        assert_eq!(seen(&[9.0, 4.0, 2.0, 6.0, 10.0, 2.0]), (None, Some(1.0)));
        assert_eq!(seen(&[9.0, 4.0, 2.0, 6.0, 5.0, 9.0]), (Some(0.5), Some(0.9)));
        // A short motion does not get there; the last digits are no dips.
        assert_eq!(seen(&[0.0, 2.0, 3.0, 2.0, 0.0]), (None, Some(0.3)));
        assert_eq!(seen(&[0.0, 10.0, 9.9995, 10.0, 9.9992, 10.0]), (None, Some(1.0)));
        assert_eq!(seen(&[]), (None, None));
    }
}
