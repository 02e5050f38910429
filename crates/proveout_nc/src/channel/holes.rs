//! Holes: courses of strokes along one axis.
//!
//! ```text
//!   Rapid     - - -o            every stroke ends where the next one turns back or rests, so that the tool
//!                  :            stops at its end, at the bottom above all, whatever the path mode is
//!   Rapid          v
//!                  |  Feed
//!   Wait           v  Wait
//! ```
//!
//! A language says with [`Holes`] how one stroke becomes a motion; what its cycles do is then a list.

use super::milling::Heights;
use super::{Channel, Language};
use crate::diagnostic::{Fault, Span};
use crate::{Dwell, Feed, Motion, Op, SpindleDirection};

/// One step of the course of a hole; coordinates are those along its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stroke {
    /// At rapid rate.
    Rapid(f64),
    /// In the feed in force.
    Feed(f64),
    /// In this feed, which then is in force.
    FeedAt(f64, Feed),
    /// With the spindle: the pitch is above zero, the direction that of the spindle.
    Thread {
        to: f64,
        pitch: f64,
        turn: SpindleDirection,
    },
    Wait(Option<Dwell>),
    /// Turns the spindle in this direction, and emits that.
    Turn(SpindleDirection),
}

impl Stroke {
    /// In a feed; at rapid rate where none is given.
    pub(crate) fn at(to: f64, feed: Option<Feed>) -> Self {
        feed.map_or(Self::Rapid(to), |feed| Self::FeedAt(to, feed))
    }

    /// A dwell in seconds; none where it is not above zero.
    pub(crate) fn wait(seconds: Option<f64>) -> Self {
        Self::Wait(seconds.filter(|s| *s > 0.0).map(Dwell::Seconds))
    }
}

impl Heights {
    /// Down to where the feed begins.
    pub(crate) fn approach(self) -> Stroke {
        Stroke::Rapid(self.clear)
    }

    /// To the bottom in the feed in force.
    pub(crate) fn to_depth(self) -> Stroke {
        Stroke::Feed(self.depth)
    }

    /// To the retraction plane.
    pub(crate) fn out(self) -> Stroke {
        Stroke::Rapid(self.second)
    }
}

/// A language with cycles for holes.
pub(crate) trait Holes: Language {
    /// The tool is at this coordinate already, so that no stroke to it is needed.
    fn stands_at(channel: &Channel<Self>, to: f64) -> bool;

    /// Moves the tool along the axis of the hole.
    fn stroke(channel: &mut Channel<Self>, to: f64, rapid: bool, span: Span) -> Result<(), Fault>;

    /// The motion of a stroke that follows the spindle.
    fn thread_stroke(channel: &mut Channel<Self>, to: f64, span: Span) -> Result<Motion, Fault>;
}

impl<L: Holes> Channel<L> {
    /// Runs a course.
    pub(crate) fn course(&mut self, strokes: &[Stroke], span: Span) -> Result<(), Fault> {
        for &stroke in strokes {
            match stroke {
                Stroke::Rapid(to) => self.along(to, true, span)?,
                Stroke::Feed(to) => self.along(to, false, span)?,
                Stroke::FeedAt(to, feed) => {
                    if !L::stands_at(self, to) {
                        self.technology.feed = Some(feed);
                        L::stroke(self, to, false, span)?;
                    }
                }
                Stroke::Thread { to, pitch, turn } => {
                    let motion = L::thread_stroke(self, to, span)?;
                    self.go_thread(motion, pitch, Some(turn));
                }
                Stroke::Wait(None) => {}
                Stroke::Wait(Some(dwell)) => self.emit(Op::Dwell(dwell)),
                Stroke::Turn(direction) => self.spindle(direction),
            }
        }
        Ok(())
    }

    fn along(&mut self, to: f64, rapid: bool, span: Span) -> Result<(), Fault> {
        if L::stands_at(self, to) { Ok(()) } else { L::stroke(self, to, rapid, span) }
    }
}
