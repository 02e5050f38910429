use proveout_machine::{JointValues, MAX_JOINTS, Machine};

use crate::{
    limits::JointLimits,
    output::{MoveKind, Sample},
    summary::{JointSummary, Summary, UnlimitedJoint},
};

/// Speeds below this (mm/s or rad/s) do not tell a direction of motion.
const STANDSTILL: f64 = 1e-6;

/// Collects the summary while the run goes on.
pub(crate) struct Meter {
    pub(crate) summary: Summary,
    pub(crate) bound_s: f64,
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
            bound_s: 0.0,
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
        s.lower_bound_s = Some(self.bound_s);
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
