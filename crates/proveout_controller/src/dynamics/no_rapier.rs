//! Replaces the Rapier plant in a build without the feature `rapier`: it cannot be constructed, and
//! the error says so.

use std::convert::Infallible;

use proveout_machine::JointValues;

use super::tree::RigidTree;

/// A machine as a multibody in Rapier; there is none in this build.
#[derive(Debug)]
pub struct RapierPlant(Infallible);

impl RapierPlant {
    /// Longest step, s.
    pub const LONGEST_STEP: f64 = 1e-4;

    /// # Errors
    /// Always: a sentence that names the feature.
    pub fn new(_tree: &RigidTree, _step: f64, _armature: &JointValues) -> Result<Self, String> {
        Err("this program was built without Rapier (feature `rapier`)".to_owned())
    }

    /// Puts the joints to positions and velocities.
    pub fn place(&mut self, _q: &JointValues, _v: &JointValues) {
        match self.0 {}
    }

    /// One step with the drives' forces (N) and torques (N mm).
    pub fn step(&mut self, _tau: &JointValues) {
        match self.0 {}
    }

    /// Positions, mm and radian.
    pub fn position(&self) -> JointValues {
        match self.0 {}
    }

    /// Velocities, mm/s and radian/s.
    pub fn velocity(&self) -> JointValues {
        match self.0 {}
    }
}
