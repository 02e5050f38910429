//! Probing motions (G31, G38).
//!
//! A probe runs as a straight motion to its end: what it would find is not known.

use proveout_nc::{Command, Location, ProbeMotion};

use super::{Controller, pace::Pace};
use crate::error::ControlError;

impl<E, I> Controller<'_, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    pub(super) fn probe(&mut self, probe: &ProbeMotion, location: &Location) -> Result<(), Box<ControlError>> {
        let (mapping, path) = {
            let context = self.context(probe.motion.machine_coordinates, location);
            (context.mapping, context.straight(&probe.motion, &self.state.position)?)
        };
        self.motion(&probe.motion, Pace::Probe, location, mapping, path)
    }
}
