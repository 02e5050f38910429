//! The spindle, and the threads whose motion it paces.
//!
//! *Thread.* The path runs in proportion to the angle of the spindle: feed = pitch x speed, without any
//! override. The spindle follows the axis while it starts and stops (rigid tapping), so that the pitch holds
//! over the whole stroke; the wait for the spindle's index mark at the begin of a thread, up to one
//! revolution, is not counted. A direction that the cycle sets counts for the stroke alone; what the program
//! asked for comes back with the next motion. A change of the direction takes the start time of the spindle,
//! from one sense to the other twice that (it brakes and starts).

use proveout_nc::{Command, Location, Spindle, SpindleDirection, ThreadMotion};

use super::{Controller, pace::Pace};
use crate::{
    error::ControlError,
    mapping::Mapping,
    motion::BlockPath,
    output::{Event, LimitKind},
};

/// By how much a thread may pass a joint's velocity by rounding, part of it.
const ROUNDING: f64 = 1e-9;

impl<E, I> Controller<'_, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    pub(super) fn thread(&mut self, thread: &ThreadMotion, location: &Location) -> Result<(), Box<ControlError>> {
        let fail = |message: String, help: &str| Box::new(ControlError::at(location, "control-thread", message, help));
        let (mapping, path) = {
            let context = self.context(thread.motion.machine_coordinates, location);
            (context.mapping, context.straight(&thread.motion, &self.state.position)?)
        };
        let direction = thread.direction.unwrap_or(self.state.turning);
        let rpm = self.state.spindle.speed_rpm.unwrap_or(0.0);
        if direction == SpindleDirection::Off || rpm.is_nan() || rpm <= 0.0 {
            let message = "a motion coupled to the spindle, but the spindle does not turn".to_owned();
            return Err(fail(message, "start the spindle and program its speed before the thread"));
        }
        let feed = thread.pitch * rpm / 60.0;
        if !(feed > 0.0 && feed.is_finite()) {
            let message = format!("a thread of {} mm pitch at {rpm} 1/min", thread.pitch);
            return Err(fail(message, "program a pitch and a speed above zero"));
        }
        if path.length > 0.0 && !path.tip_moves {
            let message = "a motion coupled to the spindle that moves rotary axes alone".to_owned();
            return Err(fail(message, "program the axis of the thread"));
        }
        self.check_thread_speed(&path, mapping, feed, location)?;
        if !self.state.threading || thread.direction.is_some() {
            self.stop_run(); // the control waits for the spindle
        }
        self.state.threading = true;
        self.turn(direction, rpm);
        let pace = Pace::Thread { feed, stroke: thread.direction.is_some() };
        self.motion(&thread.motion, pace, location, mapping, path)
    }

    /// The axes must be able to follow the spindle at its speed.
    fn check_thread_speed(
        &self,
        path: &BlockPath,
        mapping: Mapping,
        feed: f64,
        location: &Location,
    ) -> Result<(), Box<ControlError>> {
        let help = "lower the spindle speed for the thread";
        let fail = |message: String| Box::new(ControlError::at(location, "control-thread", message, help));
        let block_time = self.device.machine.control.block_time;
        if path.length > 0.0 && path.length < feed * block_time {
            let message = format!("the block of the thread is too short: the control needs {block_time} s for a block");
            return Err(fail(message));
        }
        let frame = self.device.frame(mapping);
        let places = path.parts.iter().filter(|p| !p.turn).flat_map(|p| [0.0, 0.5, 1.0].map(|share| (p, share)));
        for (part, share) in places {
            let slope = frame.kinematics.joints(&part.shape.jet(share * part.length)).first();
            for i in 0..self.device.limits.count {
                let (need, most) = (slope[i].abs() * feed, self.device.limits.velocity[i]);
                if need > most * (1.0 + ROUNDING) {
                    let joint = &self.device.machine.joints[i];
                    let (unit, scale) = (joint.kind.unit(), joint.kind.unit_factor());
                    return Err(fail(format!(
                        "the thread needs {:.3} {unit}/s of joint {}, whose limit is {:.3} {unit}/s: it cannot follow the spindle",
                        need * scale,
                        joint.name,
                        most * scale
                    )));
                }
            }
        }
        Ok(())
    }

    /// After the last stroke of a thread the spindle turns again as the program asked.
    pub(super) fn end_thread(&mut self) {
        if self.state.threading {
            self.stop_run();
            self.state.threading = false;
            let Spindle { direction, speed_rpm } = self.state.spindle;
            if direction != self.state.turning {
                self.turn(direction, speed_rpm.unwrap_or(0.0));
            }
        }
    }

    pub(super) fn spindle(&mut self, spindle: Spindle) {
        let speed_rpm = spindle.speed_rpm.or(self.state.spindle.speed_rpm);
        self.state.spindle = Spindle { speed_rpm, ..spindle };
        let (direction, before) = (spindle.direction, self.state.turning);
        self.turn(direction, speed_rpm.unwrap_or(0.0));
        if direction == before {
            // Same direction: a new speed, reported without a wait.
            self.tell_spindle(direction, speed_rpm.unwrap_or(0.0));
        }
    }

    /// Turns the spindle in a sense, if it does not do so already; motion in feed waits for it.
    fn turn(&mut self, direction: SpindleDirection, rpm: f64) {
        let before = self.state.turning;
        if direction == before {
            return;
        }
        let both = before != SpindleDirection::Off && direction != SpindleDirection::Off;
        if direction == SpindleDirection::Off {
            // The tool must have cut up to the programmed point before the spindle stops: boring
            // cycles then move it aside.
            self.stop_run();
        }
        let duration = self.device.machine.control.spindle_start_time * if both { 2.0 } else { 1.0 };
        if self.settings.spindle_waits && duration > 0.0 {
            // The time of the word must be known: the run ends here. Rapid motion goes on meanwhile, feed
            // waits.
            self.stop_run();
            self.state.spindle_ready = self.state.spindle_ready.max(self.out.clock) + duration;
        }
        self.state.turning = direction;
        self.tell_spindle(direction, rpm);
    }

    fn tell_spindle(&mut self, direction: SpindleDirection, rpm: f64) {
        let speed = if direction == SpindleDirection::Off { 0.0 } else { rpm };
        let block = self.next_block;
        self.announce(Event::Spindle { time: 0.0, block, direction, speed_rpm: speed });
        let tool = self.state.tool.and_then(|i| self.tools[i].max_speed_rpm);
        for limit in [self.device.machine.spindle.max_speed_rpm, tool].into_iter().flatten() {
            if speed > limit {
                let kind = LimitKind::SpindleSpeed;
                self.announce(Event::Limit { time: 0.0, block, joint: None, value: speed, limit, kind });
            }
        }
    }
}
