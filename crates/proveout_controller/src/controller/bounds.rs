//! Where the control ends a program by itself: targets that no machine has, and motion that would never end.
//!
//! Over-travel alone ends nothing: the motion runs on, so that later findings are seen. But ten travels away,
//! or after days of simulated time, a value of the program has the wrong unit or lost its point, and all that
//! follows is computed in vain.

use proveout_machine::MAX_JOINTS;
use proveout_nc::{Command, Location};

use super::{Begin, Controller, pace::Pace};
use crate::{
    motion::BlockPath,
    output::{BlockKind, Event},
    path::RunPath,
    stretch::MOST_SAMPLES,
    tube::Tube,
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
    /// Ends the program before a motion that is out of all bounds; true when it has. `feed` is the speed
    /// along the path parameter.
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

    /// Ends the program where the known part of the path would take more samples than can be held.
    /// The cause is not the program but joints that are slow compared with the control cycle. The
    /// rest of the path is not run; the finding names the block at `at`.
    pub(super) fn ends_on_the_way(&mut self, time: f64, at: f64) {
        if let Some(reserve) = self.begin.reserve.take() {
            let (frame, grid) = (self.device.frame(self.mapping), self.out.grid());
            let stretch = reserve.stretch(&self.path, &frame, grid);
            self.emit(stretch, true);
        }
        let number = self.path.first_block + self.path.blocks.len() as u64;
        let there = self.path.blocks.iter().find(|block| block.end() > at);
        let Some(block) = there.or(self.path.blocks.last()) else { return };
        let location = Location { file: block.file.clone(), line: block.line, column: 1, length: 1, depth: 0 };
        let frame = self.device.frame(self.mapping);
        let rest = frame.kinematics.position(&self.path.rounded(self.path.s_begin, &mut 0).0[0]);
        self.state.position.q = rest;
        self.path = RunPath::starting_with(number);
        self.begin = Begin::default();
        // Gates of what is not run bind nothing.
        self.out.meter.tube = Tube::default();
        let most = MOST_SAMPLES * self.out.cycle;
        let reason = format!(
            "the motion up to the next stop takes {time:.1} s, most of it here; the limit is {most:.1} s (two \
             million control cycles): the joints are too slow for this cycle, and the program ends here"
        );
        self.end_program(&location, reason);
        self.cut_short = Some(rest);
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
                "the motion takes at least {time:.0} s; the limit for one motion is {most:.0} s (a million control \
                 cycles): the program ends here"
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
