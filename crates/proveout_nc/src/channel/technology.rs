//! Feed, spindle, coolant and tool: what is in force, emitted when it changes.

use super::{Channel, Language};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{Coolant, Feed, Op, Spindle, SpindleDirection, ToolAction, ToolName};

/// Feed, spindle, coolant and tool in force.
#[derive(Clone, Debug)]
pub(crate) struct Technology {
    pub(crate) feed: Option<Feed>,
    /// Feed emitted last.
    pub(crate) told_feed: Option<Feed>,
    pub(crate) direction: SpindleDirection,
    /// Speed of the spindle, 1/min.
    pub(crate) speed: Option<f64>,
    pub(crate) flood: bool,
    pub(crate) mist: bool,
    /// Tool that the next change takes.
    pub(crate) selected: Option<ToolName>,
    /// Tool in the spindle, as far as the program says.
    pub(crate) in_spindle: Option<ToolName>,
}

impl Default for Technology {
    fn default() -> Self {
        Self {
            feed: None,
            told_feed: None,
            direction: SpindleDirection::Off,
            speed: None,
            flood: false,
            mist: false,
            selected: None,
            in_spindle: None,
        }
    }
}

impl Technology {
    /// M7, M8 and M9.
    pub(crate) fn set_coolant(&mut self, m: u32) {
        match m {
            7 => self.mist = true,
            8 => self.flood = true,
            _ => (self.flood, self.mist) = (false, false),
        }
    }
}

/// The other direction; a stopped spindle has none.
pub(crate) fn opposite(direction: SpindleDirection) -> SpindleDirection {
    match direction {
        SpindleDirection::Clockwise => SpindleDirection::CounterClockwise,
        SpindleDirection::CounterClockwise => SpindleDirection::Clockwise,
        SpindleDirection::Off => SpindleDirection::Off,
    }
}

/// Direction of M3, M4 and M5, and of the number for them in a cycle; any other is a stop.
pub(crate) fn direction_of(m: f64) -> SpindleDirection {
    if m == 3.0 {
        SpindleDirection::Clockwise
    } else if m == 4.0 {
        SpindleDirection::CounterClockwise
    } else {
        SpindleDirection::Off
    }
}

/// Direction in which a thread of this pitch is cut: right-hand above zero.
pub(crate) fn direction_of_thread(pitch: f64) -> SpindleDirection {
    if pitch > 0.0 { SpindleDirection::Clockwise } else { SpindleDirection::CounterClockwise }
}

impl<L: Language> Channel<L> {
    /// Emits the feed in force when it differs from the last one. Inverse time holds for one block
    /// and is emitted each time.
    pub(crate) fn tell_feed(&mut self) {
        if let Some(feed) = self.technology.feed
            && (matches!(feed, Feed::InverseTime(_)) || self.technology.told_feed != Some(feed))
        {
            self.technology.told_feed = Some(feed);
            self.emit(Op::Feed(feed));
        }
    }

    /// Takes a feed into force and emits it.
    pub(crate) fn set_feed(&mut self, feed: Option<Feed>) {
        self.technology.feed = feed;
        self.tell_feed();
    }

    /// A speed of the spindle as a program may write it, 1/min.
    pub(crate) fn checked_speed(speed: f64, span: Span) -> Result<f64, Fault> {
        if speed >= 0.0 && speed.is_finite() {
            return Ok(speed);
        }
        Err(Fault::new(codes::BAD_VALUE, span, format!("the spindle speed must not be negative and is {speed}"))
            .help("write S1000 and the direction with M3 or M4"))
    }

    /// Takes a speed into force; emits it for a spindle that turns, unless the block turns it
    /// itself.
    pub(crate) fn set_speed(&mut self, speed: f64, block_turns_it: bool) {
        let changed = self.technology.speed.replace(speed) != Some(speed);
        if changed && self.technology.direction != SpindleDirection::Off && !block_turns_it {
            self.tell_spindle();
        }
    }

    pub(crate) fn tell_spindle(&mut self) {
        let spindle = Spindle { direction: self.technology.direction, speed_rpm: self.technology.speed };
        self.emit(Op::Spindle(spindle));
    }

    /// Turns the spindle and emits that.
    pub(crate) fn spindle(&mut self, direction: SpindleDirection) {
        self.technology.direction = direction;
        self.tell_spindle();
    }

    /// Turns the spindle; emits that when it is a change.
    pub(crate) fn turn_spindle(&mut self, direction: SpindleDirection) {
        if self.technology.direction != direction {
            self.spindle(direction);
        }
    }

    /// M7, M8 and M9.
    pub(crate) fn coolant(&mut self, m: u32) {
        self.technology.set_coolant(m);
        self.tell_coolant();
    }

    pub(crate) fn tell_coolant(&mut self) {
        self.emit(Op::Coolant(Coolant { flood: self.technology.flood, mist: self.technology.mist }));
    }

    /// T: the tool that the next change takes.
    pub(crate) fn select_tool(&mut self, tool: ToolName) {
        self.technology.selected = Some(tool.clone());
        self.emit(Op::Tool(ToolAction::Select(tool)));
    }

    /// The tool that M6 takes.
    pub(crate) fn selected_tool(&self, span: Span) -> Result<ToolName, Fault> {
        self.technology.selected.clone().ok_or_else(|| {
            Fault::new(codes::NO_TOOL, span, "M6 without a T word before it").help("select the tool with T first")
        })
    }

    /// A tool comes into the spindle. The change moves the machine to where its tool changer is: these axes
    /// (bit mask) have no programmed position any more.
    pub(crate) fn change_tool(&mut self, tool: ToolName, axes: u16) {
        self.technology.in_spindle = Some(tool.clone());
        self.emit(Op::Tool(ToolAction::Change(tool)));
        self.position.forget(axes);
    }
}
