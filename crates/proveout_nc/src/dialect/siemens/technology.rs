//! Feed, spindle, edge, coolant, functions, dwell, path mode and tool center point control.

use super::block::LINEAR;
use super::interpreter::Interpreter;
use super::listed::LISTED;
use super::modal::{FeedMode, Interpolation};
use super::pending::Pending;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{
    Coolant, Dwell, Feed, Offset, Op, OrientationInterpolation, Override, PathMode, Spindle, SpindleDirection, Tcp,
    ToolAction,
};

impl Interpreter {
    pub(super) fn feed_mode(&mut self, mode: FeedMode) {
        if self.modal.feed_mode != mode {
            self.modal.feed_mode = mode;
            // A number keeps no meaning across modes: F must be programmed anew.
            self.technology.feed = None;
        }
    }

    /// Takes a corner treatment into effect and tells it.
    pub(crate) fn path_mode(&mut self, mode: PathMode) {
        self.modal.path_mode = mode;
        self.emit(Op::PathMode(mode));
    }

    pub(super) fn orientation(&mut self, interpolation: OrientationInterpolation) {
        self.modal.orientation = interpolation;
        self.tell_tcp();
    }

    /// Hands the state of the tool center point control out.
    pub(crate) fn tell_tcp(&mut self) {
        // ORIMKS interpolates the machine axes whatever else is said.
        let interpolation =
            if self.modal.machine_vectors { OrientationInterpolation::Axes } else { self.modal.orientation };
        self.emit(Op::Tcp(Tcp { on: self.technology.tcp(), interpolation }));
    }

    pub(super) fn feed_word(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let Some(value) = p.feed else {
            if self.modal.feed_mode == FeedMode::InverseTime {
                // Inverse time holds for one block.
                self.technology.feed = None;
            }
            return Ok(());
        };
        self.technology.feed = Some(self.feed_of(value, span)?);
        self.tell_feed();
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

    /// Hands the feed out when it differs from the last one.
    pub(crate) fn tell_feed(&mut self) {
        let inverse = self.modal.feed_mode == FeedMode::InverseTime;
        if let Some(feed) = self.technology.feed
            && (inverse || self.technology.told_feed != Some(feed))
        {
            self.technology.told_feed = Some(feed);
            self.emit(Op::Feed(feed));
        }
    }

    pub(super) fn speed_word(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let Some(speed) = p.speed else { return Ok(()) };
        if !(speed >= 0.0 && speed.is_finite()) {
            return Err(Fault::new(
                codes::BAD_VALUE,
                span,
                format!("the spindle speed must not be negative and is {speed}"),
            )
            .help("write S1000 and the direction with M3 or M4"));
        }
        let changed = self.technology.speed != Some(speed);
        self.technology.speed = Some(speed);
        let turns = self.technology.direction != SpindleDirection::Off;
        if changed && turns && !p.functions.iter().any(|m| matches!(m, 3..=5)) {
            self.tell_spindle();
        }
        Ok(())
    }

    pub(super) fn tell_spindle(&mut self) {
        let spindle = Spindle { direction: self.technology.direction, speed_rpm: self.technology.speed };
        self.emit(Op::Spindle(spindle));
    }

    pub(super) fn edge(&mut self, edge: u32) {
        self.emit(Op::Offset(Offset::ToolEdge { edge }));
        let before = self.technology.edge.replace(edge);
        if before.unwrap_or(1) != edge {
            self.edge_changed_radius();
        }
        if before != Some(edge) {
            // The tool stands still and its tip is now another point.
            let turned = self.technology.tcp() || self.position.frame().is_rotated();
            self.position.forget(if turned { LINEAR } else { 1 << self.modal.normal });
            self.tangent = None;
        }
    }

    pub(super) fn functions_before(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        for &m in &p.functions {
            match m {
                0 | 1 | 2 | 5 | 9 | 17 | 30 => {}
                3 | 4 => {
                    self.technology.direction =
                        if m == 3 { SpindleDirection::Clockwise } else { SpindleDirection::CounterClockwise };
                    self.tell_spindle();
                }
                6 => {
                    let tool = self.technology.selected.clone().ok_or_else(|| {
                        Fault::new(codes::NO_TOOL, span, "M6 stands before any T").help("select the tool with T first")
                    })?;
                    self.technology.in_spindle = Some(tool.clone());
                    self.emit(Op::Tool(ToolAction::Change(tool)));
                    // The change moves the machine to where its tool changer is.
                    self.position.forget(LINEAR);
                    self.tangent = None;
                }
                7 | 8 => {
                    if m == 7 {
                        self.technology.mist = true
                    } else {
                        self.technology.flood = true
                    }
                    self.tell_coolant();
                }
                m if m >= LISTED => self.act_listed(m),
                _ => self.note(format!("M{m}")),
            }
        }
        Ok(())
    }

    pub(super) fn tell_coolant(&mut self) {
        let coolant = Coolant { flood: self.technology.flood, mist: self.technology.mist };
        self.emit(Op::Coolant(coolant));
    }

    pub(super) fn functions_after(&mut self, p: &Pending) {
        for &m in &p.functions {
            match m {
                5 => {
                    self.technology.direction = SpindleDirection::Off;
                    self.tell_spindle();
                }
                9 => {
                    self.technology.flood = false;
                    self.technology.mist = false;
                    self.tell_coolant();
                }
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
            return Err(Fault::new(codes::CONFLICT, span, "G4 cannot stand with a motion")
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

    /// FB=: a feed for this block only; the answer is the feed to come back to.
    pub(super) fn block_feed(&mut self, p: &Pending, span: Span) -> Result<Option<Option<Feed>>, Fault> {
        let Some(value) = p.block_feed else { return Ok(None) };
        let before = self.technology.feed;
        self.technology.feed = Some(self.feed_of(value, span)?);
        self.tell_feed();
        Ok(Some(before))
    }

    /// POS[]=: positioning axes alone in a block.
    pub(super) fn positioning(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        if p.has_orientation() || p.has_center() || p.machine {
            return Err(Fault::new(codes::CONFLICT, span, "POS[ ]= stands with words of a path motion")
                .help("write it in a block of its own"));
        }
        self.note("POS[ ]=: the axes are moved at rapid rate");
        let before = std::mem::replace(&mut self.modal.interpolation, Interpolation::Rapid);
        let result = self.motion(p, span);
        self.modal.interpolation = before;
        result
    }
}
