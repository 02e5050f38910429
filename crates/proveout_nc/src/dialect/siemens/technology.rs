//! Feed, spindle, edge, coolant, functions, dwell, path mode and tool center point control.

use super::block::LINEAR;
use super::listed::LISTED;
use super::modal::{FeedMode, Interpolation};
use super::pending::Pending;
use super::run_state::Interpreter;
use crate::channel::direction_of;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{Dwell, Feed, Offset, Op, OrientationInterpolation, Override, PathMode, SpindleDirection, Tcp};

impl Interpreter {
    pub(super) fn feed_mode(&mut self, mode: FeedMode) {
        if self.modal.feed_mode != mode {
            self.modal.feed_mode = mode;
            // A number has no meaning in another mode: F must be programmed again.
            self.technology.feed = None;
        }
    }

    /// Puts a corner treatment into effect and emits it.
    pub(crate) fn path_mode(&mut self, mode: PathMode) {
        self.modal.path_mode = mode;
        self.emit(Op::PathMode(mode));
    }

    pub(super) fn orientation(&mut self, interpolation: OrientationInterpolation) {
        self.modal.orientation = interpolation;
        self.tell_tcp();
    }

    /// Emits the state of tool center point control.
    pub(crate) fn tell_tcp(&mut self) {
        // ORIMKS interpolates the machine axes regardless of the other words.
        let interpolation =
            if self.modal.machine_vectors { OrientationInterpolation::Axes } else { self.modal.orientation };
        self.emit(Op::Tcp(Tcp { on: self.own.tcp(), interpolation }));
    }

    pub(super) fn feed_word(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let Some(value) = p.feed else {
            if self.modal.feed_mode == FeedMode::InverseTime {
                // Inverse time holds for one block.
                self.technology.feed = None;
            }
            return Ok(());
        };
        let feed = self.feed_of(value, span)?;
        self.set_feed(Some(feed));
        Ok(())
    }

    pub(super) fn feed_of(&self, value: f64, span: Span) -> Result<Feed, Fault> {
        if !(value > 0.0 && value.is_finite()) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("the feed must be above zero and is {value}"))
                .help("write F100"));
        }
        let factor = self.modal.units.feed();
        Ok(match self.modal.feed_mode {
            FeedMode::PerTime => Feed::PerTime(value * factor / 60.0),
            FeedMode::PerRevolution => Feed::PerRevolution(value * factor),
            FeedMode::InverseTime => Feed::InverseTime(60.0 / value),
        })
    }

    pub(super) fn speed_word(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let Some(speed) = p.speed else { return Ok(()) };
        let turns_it = p.functions.iter().any(|m| matches!(m, 3..=5));
        self.set_speed(Self::checked_speed(speed, span)?, turns_it);
        Ok(())
    }

    pub(super) fn edge(&mut self, edge: u32) {
        self.emit(Op::Offset(Offset::ToolEdge { edge }));
        let before = self.own.edge.replace(edge);
        if before.unwrap_or(1) != edge {
            self.edge_changed_radius();
        }
        if before != Some(edge) {
            // The tool does not move, but its tip is now another point.
            let turned = self.own.tcp() || self.position.frame().is_rotated();
            self.position.forget(if turned { LINEAR } else { 1 << self.modal.normal });
            self.own.tangent = None;
        }
    }

    pub(super) fn functions_before(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        for &m in &p.functions {
            match m {
                0 | 1 | 2 | 5 | 9 | 17 | 30 => {}
                3 | 4 => self.spindle(direction_of(f64::from(m))),
                6 => {
                    let tool = self.selected_tool(span)?;
                    self.change_tool(tool, LINEAR);
                    self.own.tangent = None;
                }
                m if m >= LISTED => self.tell_listed((m - LISTED) as usize, ""),
                7 | 8 => self.coolant(m),
                _ => self.note(format!("M{m}")),
            }
        }
        Ok(())
    }

    pub(super) fn functions_after(&mut self, p: &Pending) {
        for &m in &p.functions {
            match m {
                5 => self.spindle(SpindleDirection::Off),
                9 => self.coolant(m),
                0 | 1 => self.emit(Op::Stop { optional: m == 1 }),
                _ => {}
            }
        }
    }

    pub(super) fn dwell(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let dwell = match (p.feed, p.speed) {
            (Some(seconds), None) => Dwell::Seconds(seconds),
            (None, Some(revolutions)) => Dwell::Revolutions(revolutions),
            _ => {
                return Err(Fault::new(codes::MISSING_VALUE, span, "G4 needs either F in seconds or S in revolutions")
                    .help("write G4 F2"));
            }
        };
        if p.has_axis() {
            return Err(Fault::new(codes::CONFLICT, span, "G4 cannot share a block with a motion")
                .help("write G4 in a block of its own"));
        }
        if !matches!(dwell, Dwell::Seconds(v) | Dwell::Revolutions(v) if v >= 0.0) {
            return Err(Fault::new(codes::BAD_VALUE, span, "the dwell must not be negative").help("write G4 F2"));
        }
        self.emit(Op::Dwell(dwell));
        Ok(())
    }

    /// OVR=: programmed feed override.
    pub(super) fn feed_override(&mut self, percent: f64, span: Span) -> Result<(), Fault> {
        if !(percent > 0.0 && percent <= 200.0) {
            return Err(Fault::new(
                codes::BAD_VALUE,
                span,
                format!("OVR= must be above 0 and at most 200 and is {percent}"),
            )
            .help("write OVR=100"));
        }
        self.emit(Op::Override(Override { enabled: true, feed: percent / 100.0 }));
        Ok(())
    }

    /// FB=: a feed for this block only; returns the feed to go back to.
    pub(super) fn block_feed(&mut self, p: &Pending, span: Span) -> Result<Option<Option<Feed>>, Fault> {
        let Some(value) = p.block_feed else { return Ok(None) };
        let before = self.technology.feed;
        let feed = self.feed_of(value, span)?;
        self.set_feed(Some(feed));
        Ok(Some(before))
    }

    /// POS[]=: positioning axes alone in a block.
    pub(super) fn positioning(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        if p.has_orientation() || p.has_center() || p.machine {
            return Err(Fault::new(codes::CONFLICT, span, "POS[ ]= in a block with words of a path motion")
                .help("write it in a block of its own"));
        }
        self.note("POS[ ]=: the axes are moved at rapid rate");
        let before = std::mem::replace(&mut self.modal.interpolation, Interpolation::Rapid);
        let result = self.motion(p, span);
        self.modal.interpolation = before;
        result
    }
}
