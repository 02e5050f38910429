//! What paces a motion, and the motions that the programmed feed paces: splines and retraction.

use proveout_nc::{Command, Contact, Location, Override, Retract, SplineMotion};

use super::Controller;
use crate::{error::ControlError, output::MoveKind};

/// What paces a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pace {
    Rapid,
    /// Feed of the program with its override.
    Feed,
    /// Like feed, and ends with a stop and the event of a probe.
    Probe {
        /// What is known of its end.
        contact: Contact,
    },
    /// Coupled to the spindle: this feed, mm/s, exactly.
    Thread {
        feed: f64,
        /// A stroke of a cycle with its own sense of rotation: it ends with a stop.
        stroke: bool,
    },
}

impl Pace {
    pub(super) fn kind(self) -> MoveKind {
        if self == Self::Rapid { MoveKind::Rapid } else { MoveKind::Feed }
    }
}

impl<E, I> Controller<'_, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    pub(super) fn spline(&mut self, spline: &SplineMotion, location: &Location) -> Result<(), Box<ControlError>> {
        let (mapping, path) = {
            let context = self.context(spline.motion.machine_coordinates, location);
            (context.mapping, context.spline(spline, &self.state.position)?)
        };
        self.motion(&spline.motion, Pace::Feed, location, mapping, path)
    }

    /// Factor of the programmed feed from here on.
    pub(super) fn feed_override(&mut self, change: Override, location: &Location) -> Result<(), Box<ControlError>> {
        if !(change.feed > 0.0 && change.feed.is_finite()) {
            let message = format!("a feed override of {} percent", change.feed * 100.0);
            let help = "program an override above zero";
            return Err(Box::new(ControlError::at(location, "control-feed", message, help)));
        }
        self.state.feed_override = change.feed;
        Ok(())
    }

    /// Retracts along the tool axis away from the workpiece, with a stop before and after.
    pub(super) fn retract(&mut self, retract: Retract, location: &Location) -> Result<(), Box<ControlError>> {
        let (mapping, path) = {
            let context = self.context(false, location);
            (context.mapping, context.retract(retract.distance, &self.state.position)?)
        };
        let pace = if retract.rapid { Pace::Rapid } else { Pace::Feed };
        self.stop_run();
        self.move_along(pace, location, mapping, path, true)?;
        self.stop_run();
        self.forget_linear();
        Ok(())
    }
}
