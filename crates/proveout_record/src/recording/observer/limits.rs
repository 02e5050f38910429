//! Limits of the axes as lines in their plots.

use proveout_sim::observer::Setup;

use super::OpenRecording;
use crate::{
    color::Rgba,
    error::RecordError,
    recording::{sink::path, tracks::Signal},
};

const LIMIT_COLOR: Rgba = [150, 60, 64, 255];

impl OpenRecording {
    /// Lines at the limits that a signal comes near: travel, speed, acceleration, jerk, force of the drive.
    pub(super) fn limits(&self, setup: &Setup<'_>, end: f64) -> Result<(), RecordError> {
        let draw = |signal: &Signal, bounds: [f64; 2], factor: f64| {
            for (name, bound) in ["lower_limit", "upper_limit"].into_iter().zip(bounds) {
                let bound = bound * factor;
                if signal.comes_near(bound) {
                    let entity = signal.path().join(&path([name]));
                    self.sink.signal_style(entity.clone(), "limit", LIMIT_COLOR, false)?;
                    self.sink.signal(entity, &[(0.0, bound), (end, bound)])?;
                }
            }
            Ok(())
        };
        for (k, (joint, unit)) in setup.machine.joints.iter().zip(&self.units).enumerate() {
            let Some(signals) = self.joints.get(k) else { continue };
            if let Some(travel) = joint.travel {
                draw(&signals[0], travel, unit.factor)?;
            }
            let rates = [joint.max_velocity, joint.max_acceleration, joint.max_jerk];
            for (signal, limit) in signals[1..].iter().zip(rates) {
                if let Some(limit) = limit {
                    draw(signal, [-limit, limit], unit.factor)?;
                }
            }
            let force = joint.drive.as_ref().and_then(|d| d.max_force);
            if let (Some(drive), Some(force)) = (self.drives.get(k), force) {
                draw(&drive[1], [-force, force], unit.force_factor)?;
            }
        }
        Ok(())
    }
}
