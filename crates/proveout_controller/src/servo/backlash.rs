//! Backlash: the lost motion between motor and load of a drive.
//!
//! *Lost motion.* Elastic: the flank that touches is known from x1 - x2 at the begin of the step. Stiff: the
//! load is pushed by the flanks and stays or falls between them.

use super::{model::DriveModel, step::DriveState};

impl DriveModel {
    /// Moves the load of a stiff drive through its lost motion.
    pub(crate) fn push_load(&self, s: &mut DriveState, motor_way: f64, w: f64) {
        if self.half_backlash == 0.0 {
            s.load_velocity = s.motor_velocity;
            return;
        }
        let held = w.abs() <= self.friction.stiction;
        let own = if held {
            0.0
        } else {
            let pull = (w - self.friction.coulomb * w.signum()) / self.share[1];
            s.load_velocity + pull * self.step
        };
        s.play += motor_way - own * self.step;
        s.load_velocity = own;
        if s.play.abs() >= self.half_backlash {
            s.play = self.half_backlash.copysign(s.play);
            s.load_velocity = s.motor_velocity;
        }
    }
}
