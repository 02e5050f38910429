//! Commands that hold something that is no number are refused at their block, before anything is made of
//! them.

use proveout_nc::{AXIS_LETTERS, AxisValues, Command, Dwell, Feed, Motion, Offset, Op, PathMode};

use crate::error::ControlError;

/// What a command states, and whether a value of it is not a finite number.
#[derive(Default)]
struct Values {
    found: Option<(String, f64)>,
}

impl Values {
    fn one(&mut self, what: &str, value: f64) {
        if !value.is_finite() && self.found.is_none() {
            self.found = Some((what.to_owned(), value));
        }
    }

    fn maybe(&mut self, what: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.one(what, value);
        }
    }

    fn all<'v>(&mut self, what: &str, values: impl IntoIterator<Item = &'v f64>) {
        for value in values {
            self.one(what, *value);
        }
    }

    fn axes(&mut self, values: &AxisValues) {
        for (i, letter) in AXIS_LETTERS.iter().enumerate() {
            if let Some(value) = values.get(i).filter(|v| !v.is_finite()) {
                self.one(&format!("the position of {letter}"), value);
            }
        }
    }

    fn motion(&mut self, motion: &Motion) {
        self.axes(&motion.end);
        self.axes(&motion.end_base);
        self.all("the tool axis", motion.tool_axis.iter().flatten());
        self.all("the tool axis", motion.tool_axis_base.iter().flatten());
    }
}

/// Refuses a command with a value that is not a finite number.
pub(super) fn check_numbers(command: &Command) -> Result<(), Box<ControlError>> {
    let mut v = Values::default();
    match &command.op {
        Op::Rapid(motion) | Op::Linear(motion) => v.motion(motion),
        Op::Arc(arc) => {
            v.motion(&arc.motion);
            v.all("the center of the arc", arc.center.iter().chain(&arc.center_base));
            v.all("the plane of the arc", arc.normal.iter().chain(&arc.normal_base));
            v.one("the radius of the arc", arc.radius);
            v.one("the angle of the arc", arc.sweep);
        }
        Op::Spline(spline) => {
            v.motion(&spline.motion);
            v.all("a control point of the spline", spline.control.iter().chain(&spline.control_base).flatten());
        }
        Op::Probe(probe) => v.motion(&probe.motion),
        Op::Thread(thread) => {
            v.motion(&thread.motion);
            v.one("the pitch", thread.pitch);
        }
        Op::Retract(retract) => v.maybe("the way of the retraction", retract.distance),
        Op::Dwell(Dwell::Seconds(t) | Dwell::Revolutions(t)) => v.one("the dwell", *t),
        Op::Feed(Feed::PerTime(f) | Feed::PerRevolution(f) | Feed::InverseTime(f)) => v.one("the feed", *f),
        Op::Spindle(spindle) => v.maybe("the spindle speed", spindle.speed_rpm),
        Op::FeedCounts(counts) => {
            v.all("what the feed counts", counts.linear.iter().chain(&counts.radius));
        }
        Op::Offset(Offset::ToolDelta { length, radius, corner_radius }) => {
            v.all("the delta value of the tool", [length, radius, corner_radius]);
        }
        Op::Offset(Offset::TurnCenter { ahead }) => {
            v.one("the distance from the tip to the center of the turn", *ahead)
        }
        Op::Frame(frame) => {
            let numbers = frame.rotation.iter().flatten().chain(&frame.translation).chain(&frame.rotary);
            v.all(&format!("the frame of {}", frame.word), numbers);
        }
        Op::PathMode(PathMode::Continuous { tolerance, orientation_tolerance }) => {
            v.maybe("the path tolerance", *tolerance);
            v.maybe("the tolerance of the tool axis", *orientation_tolerance);
        }
        Op::CutterComp(compensation) => v.maybe("the radius of the compensation", compensation.radius),
        Op::Override(change) => v.one("the override", change.feed),
        Op::Tool(_)
        | Op::Plane(_)
        | Op::Offset(Offset::ToolEdge { .. } | Offset::Work { .. })
        | Op::Tcp(_)
        | Op::PathMode(PathMode::ExactStop)
        | Op::Coolant(_)
        | Op::Message(_)
        | Op::Note(_)
        | Op::Overcut(_)
        | Op::Stop { .. }
        | Op::End => {}
    }
    match v.found {
        None => Ok(()),
        Some((what, value)) => {
            let message = format!("{what} is {value}, which is not a number");
            let help = "check the programmed values, offsets and variables of this block";
            Err(Box::new(ControlError::at(&command.location, "control-not-a-number", message, help)))
        }
    }
}
