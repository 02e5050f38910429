//! Where the control ends a program by itself: targets that no machine has, and motion that would never end.
//!
//! Over-travel alone ends nothing: the motion runs on, so that later findings are seen. But ten travels away, or after days of
//! simulated time, a value of the program has the wrong unit or lost its point, and all that follows is computed in vain.

use proveout_machine::MAX_JOINTS;
use proveout_nc::{Command, Location};

use super::{Controller, coupled::Pace};
use crate::{
    motion::BlockPath,
    output::{BlockKind, Event},
};

/// Travels past the end of a travel beyond which a target is none.
const TRAVELS: f64 = 10.0;
/// Most samples of one motion: all of them are planned and checked together. About a gigabyte while they are.
const MOTION_SAMPLES: f64 = 1e6;
/// Samples of the known part of a run at which it is planned, whatever the number of its blocks.
pub(super) const WINDOW_SAMPLES: f64 = 5e5;

impl<E, I> Controller<'_, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    /// Ends the program before a motion that is out of all bounds; true when it has. `feed` is the speed along the path parameter.
    pub(super) fn ends_before(&mut self, path: &BlockPath, pace: Pace, feed: f64, location: &Location) -> bool {
        match self.too_far(path).or_else(|| self.too_long(self.least_time(path, pace, feed))) {
            Some(reason) => {
                self.end_program(location, reason);
                true
            }
            None => false,
        }
    }

    /// Ends the program before a standstill that would last past the limit; true when it has.
    pub(super) fn ends_before_standstill(&mut self, duration: f64, location: &Location) -> bool {
        match self.too_late(duration) {
            Some(reason) => {
                self.end_program(location, reason);
                true
            }
            None => false,
        }
    }

    fn end_program(&mut self, location: &Location, reason: String) {
        let block = self.action(location, BlockKind::Action, 0.0);
        let (time, location) = (self.out.clock, location.clone());
        self.out.chunk.events.push(Event::Ended { time, block, location, reason });
        self.ended = true;
    }

    fn too_far(&self, path: &BlockPath) -> Option<String> {
        self.device.machine.joints.iter().enumerate().take(MAX_JOINTS).find_map(|(i, joint)| {
            let [low, high] = joint.travel?;
            let beyond = TRAVELS * (high - low);
            let (factor, unit) = (joint.kind.unit_factor(), joint.kind.unit());
            let q = path.end[i];
            (q < low - beyond || q > high + beyond).then(|| {
                format!(
                    "{} is sent to {} {unit}, more than {TRAVELS} travels past its travel of {} to {} {unit}: the program ends here",
                    joint.name,
                    q * factor,
                    low * factor,
                    high * factor
                )
            })
        })
    }

    /// Time that a motion takes at least, s.
    fn least_time(&self, path: &BlockPath, pace: Pace, feed: f64) -> f64 {
        let from = self.state.position.q;
        let limits = &self.device.limits;
        let way = (0..limits.count).map(|i| {
            let speed = if pace == Pace::Rapid { limits.rapid[i] } else { limits.velocity[i] };
            (path.end[i] - from[i]).abs() / speed
        });
        let by_joints = way.filter(|t| t.is_finite()).fold(0.0, f64::max);
        let by_feed = path.parts.iter().map(|part| part.length).sum::<f64>() / feed;
        if by_feed.is_finite() { by_joints.max(by_feed) } else { by_joints }
    }

    fn too_long(&self, time: f64) -> Option<String> {
        let most = MOTION_SAMPLES * self.out.cycle;
        if time > most {
            return Some(format!(
                "the motion takes {time:.0} s at least, and one motion may take {most:.0} s (a million control cycles): the program ends here"
            ));
        }
        self.too_late(time)
    }

    fn too_late(&self, time: f64) -> Option<String> {
        let limit = self.settings.max_time;
        let end = self.out.clock + time;
        (end > limit).then(|| {
            format!("the run would take {end:.0} s at least, past the limit of {limit:.0} s of simulated time: the program ends here")
        })
    }
}
