//! Siemens 840D text: TRAORI with rotary axes or vectors, frames as TRANS and AROT, arcs with absolute
//! centers.

use std::f64::consts::TAU;
use std::io::Write;

use super::format::{PostLines, full_turns, offset_number, radius_word};
use super::{Post, PostError, PostSettings, Unpostable, decimal};
use crate::frame::{self, Frame};
use crate::settings::Dialect;
use crate::{
    AXIS_LETTERS, ArcMotion, AxisValues, Command, CompSide, Coolant, CutterComp, Dwell, Feed, FrameChange, Motion,
    Offset, Op, OrientationInterpolation, PathMode, SpindleDirection, Tcp, ThreadMotion, ToolAction, ToolName,
};

/// An axis that is this near to where it was does not move, in the unit of the program.
const STANDS: f64 = 1e-9;

/// Writes canonical commands as a program for an 840D, one after the other.
#[derive(Debug)]
pub struct SiemensPost<W> {
    pub(crate) out: PostLines<W>,
    begun: bool,
    interpolation: Option<&'static str>,
    plane: usize,
    feed: Option<Feed>,
    feed_mode: Option<&'static str>,
    coolant: Coolant,
    tcp: Option<Tcp>,
    tool: Option<ToolName>,
    selected: Option<ToolName>,
    pub(crate) settable: Frame,
    /// CYCLE800.
    pub(crate) swivel: Frame,
    pub(crate) programmable: Frame,
    /// A frame not yet written: the next command decides whether the control orients the tool
    /// normal to it.
    pub(crate) waiting: Option<FrameChange>,
    /// The swivel plane ends with it.
    pub(crate) plane_ends: bool,
    /// Direction of the tapping motion that went in.
    tapping: Option<SpindleDirection>,
    /// CYCLE800 has switched tool center point control on.
    pub(crate) swiveled: bool,
    /// Text of the last coordinate of each axis, to see when an end point falls onto its start.
    written: [Option<String>; 9],
}

impl<W: Write> SiemensPost<W> {
    /// A post that writes to a sink.
    pub fn new(sink: W, settings: PostSettings) -> Self {
        Self {
            out: PostLines::new(sink, settings),
            begun: false,
            interpolation: None,
            plane: 2,
            feed: None,
            feed_mode: None,
            coolant: Coolant { flood: false, mist: false },
            tcp: None,
            tool: None,
            selected: None,
            settable: Frame::IDENTITY,
            swivel: Frame::IDENTITY,
            waiting: None,
            plane_ends: false,
            swiveled: false,
            tapping: None,
            programmable: Frame::IDENTITY,
            written: Default::default(),
        }
    }

    fn begin(&mut self) -> Result<(), Unpostable> {
        self.begun = true;
        if let Some(header) = self.out.settings.header.take() {
            return header.iter().try_for_each(|line| self.out.plain(line));
        }
        if self.out.settings.inches { self.line("G700") } else { Ok(()) }
    }

    fn command(&mut self, op: &Op) -> Result<(), Unpostable> {
        if !self.begun {
            self.begin()?;
        }
        if self.waiting.is_some() {
            if let Op::Tcp(tcp) = op
                && !tcp.on
            {
                // The next command decides whether the plane continues.
                if self.swiveled {
                    self.plane_ends = true;
                    self.tcp = Some(*tcp);
                    return Ok(());
                }
                return self.tcp(*tcp);
            }
            if let (Op::Rapid(motion), Some(change)) = (op, &self.waiting)
                && is_swivel(motion)
            {
                let (change, solution) = (change.clone(), motion.solution);
                (self.waiting, self.plane_ends) = (None, false);
                return self.cycle800(&change, solution);
            }
            // A note between a plane and its swivel belongs to both.
            if let Op::Note(text) = op {
                return self.line(&format!("; {}", text.replace(['\n', '\r'], " ")));
            }
            self.write_frame()?;
        }
        match op {
            Op::Rapid(motion) | Op::Linear(motion) => {
                let word = if matches!(op, Op::Rapid(_)) { "G0" } else { "G1" };
                if motion.tool_axis.is_some() && (!self.tcp.is_some_and(|tcp| tcp.on) || self.swiveled) {
                    return Err(Unpostable::new(
                        "a tool vector without TRAORI",
                        "write swivel planes as frames and rotary axes",
                    ));
                }
                let words = self.motion_words(word, motion, 0);
                self.line(&words)
            }
            Op::Arc(arc) => match self.arc_words(arc) {
                Some(words) => self.line(&words),
                None => Err(Unpostable::new("a full circle outside of G17, G18, G19", "split it into two arcs")),
            },
            Op::Thread(thread) => self.thread(thread),
            Op::Dwell(Dwell::Seconds(seconds)) => self.line(&format!("G4 F{}", decimal(*seconds, 3))),
            Op::Dwell(Dwell::Revolutions(revolutions)) => self.line(&format!("G4 S{}", decimal(*revolutions, 3))),
            Op::Feed(feed) => self.feed(*feed),
            Op::FeedCounts(counts) => super::feed_counts(*counts, Dialect::Siemens840d),
            Op::Spindle(spindle) => {
                let m = match spindle.direction {
                    SpindleDirection::Off => "M5",
                    SpindleDirection::Clockwise => "M3",
                    SpindleDirection::CounterClockwise => "M4",
                };
                match spindle.speed_rpm {
                    Some(speed) if m != "M5" => self.line(&format!("S{} {m}", decimal(speed, 3))),
                    _ => self.line(m),
                }
            }
            Op::Tool(ToolAction::Select(tool)) => {
                self.selected = Some(tool.clone());
                self.line(&tool_word(tool))
            }
            Op::Tool(ToolAction::Change(tool)) => {
                let selected = self.tool.replace(tool.clone());
                let ready = self.selected.take().or(selected);
                if ready.as_ref() != Some(tool) {
                    self.line(&tool_word(tool))?;
                }
                self.line("M6")
            }
            Op::Plane(normal) => {
                self.plane = AxisValues::index(*normal).filter(|&axis| axis < 3).unwrap_or(2);
                self.line(&format!("G{}", 19 - self.plane))
            }
            Op::Offset(Offset::ToolEdge { edge }) => {
                let edge = self.out.edge(*edge, self.tool.as_ref());
                self.line(&format!("D{edge}"))
            }
            Op::Offset(Offset::ToolDelta { length, radius, corner_radius }) => {
                if [length, radius, corner_radius].iter().all(|v| **v == 0.0) {
                    return Ok(());
                }
                Err(Unpostable::new("delta values of the tool", "write them into the tool table"))
            }
            Op::Offset(Offset::TurnCenter { .. }) => Err(super::turns_ahead()),
            Op::Offset(Offset::Work { word }) => {
                let values = self.out.settings.work_offsets.get(word).copied().unwrap_or_default();
                self.settable = Frame { rotary: values.rotary, ..Frame::translation(values.translation) };
                self.line(&offset_word(word)?)
            }
            Op::Frame(change) => {
                self.waiting = Some(change.clone());
                Ok(())
            }
            Op::Tcp(tcp) => self.tcp(*tcp),
            Op::CutterComp(comp) => self.compensation(comp),
            Op::Override(change) if !change.enabled => {
                Err(Unpostable::new("a fixed override (M49)", "write the feed without override"))
            }
            Op::Override(change) => self.line(&format!("OVR={}", decimal(change.feed * 100.0, 3))),
            Op::Spline(_) => Err(Unpostable::new("a Bezier curve", "write it as short straight blocks")),
            Op::Probe(_) => Err(Unpostable::new("a probing motion", "write the measuring cycle by hand")),
            Op::Retract(_) => Err(Unpostable::new("a retraction along the tool axis", "write the retracted position")),
            Op::PathMode(PathMode::ExactStop) => self.line("G60"),
            Op::PathMode(PathMode::Continuous { tolerance, orientation_tolerance }) => {
                // A negative tolerance is the word for "as set up on the machine".
                let contour = tolerance
                    .map_or("-1".to_owned(), |t| decimal(self.out.in_unit(t), self.out.settings.length_decimals + 2));
                let orientation = orientation_tolerance
                    .map_or("-1".to_owned(), |t| decimal(t.to_degrees(), self.out.settings.angle_decimals + 2));
                self.line(&format!("CTOL={contour} OTOL={orientation} G645"))
            }
            Op::Coolant(coolant) => self.coolant(*coolant),
            Op::Message(text) => self.line(&format!("MSG(\"{}\")", plain(text))),
            Op::Overcut(overcut) => self.line(&format!("; {overcut}")),
            Op::Note(text) => self.line(&format!("; {}", text.replace(['\n', '\r'], " "))),
            Op::Stop { optional } => self.line(if *optional { "M1" } else { "M0" }),
            Op::End => self.line("M30"),
        }
    }

    /// Returns the sink.
    pub fn into_inner(self) -> W {
        self.out.sink
    }

    pub(crate) fn line(&mut self, words: &str) -> Result<(), Unpostable> {
        self.out.block(words)
    }

    /// G word, coordinates and tool vector of a motion; `forced` axes are written even when not programmed.
    fn motion_words(&mut self, word: &'static str, motion: &Motion, forced: u16) -> String {
        let mut words = Vec::new();
        if motion.machine_coordinates {
            words.push("SUPA".to_owned());
        }
        if motion.exact_stop {
            words.push("G9".to_owned());
        }
        if self.interpolation != Some(word) {
            self.interpolation = Some(word);
            words.push(word.to_owned());
        }
        let all = motion.programmed == 0 && motion.tool_axis.is_none();
        for (axis, letter) in AXIS_LETTERS.iter().enumerate() {
            let wanted = all || (motion.programmed | forced) >> axis & 1 == 1;
            if let Some(value) = motion.end.get(axis).filter(|_| wanted) {
                let text = self.out.axis(axis, value);
                words.push(format!("{letter}{text}"));
                self.written[axis] = (!motion.machine_coordinates).then_some(text);
            }
        }
        if let Some(axis) = motion.tool_axis {
            for (letter, component) in ['A', 'B', 'C'].iter().zip(axis) {
                words.push(format!("{letter}3={}", self.out.vector(component)));
            }
        }
        if let Some(Feed::InverseTime(seconds)) = self.feed.filter(|_| word != "G0") {
            words.push(format!("F{}", self.out.above_zero(60.0 / seconds, 6)));
        }
        words.join(" ")
    }

    /// Words of an arc; none for what CIP cannot say.
    fn arc_words(&mut self, arc: &ArcMotion) -> Option<String> {
        let normal = arc.normal.iter().position(|v| v.abs() > frame::SAME_DIRECTION);
        let extra_turns = full_turns(arc);
        let within = arc.sweep - f64::from(extra_turns) * TAU;
        let mut words = String::new();
        let plane_axes: u16 = match normal {
            Some(axis) => 0b111 & !(1 << axis),
            None => 0b111,
        };
        let falls_together = (0..3).filter(|axis| plane_axes >> axis & 1 == 1).all(|axis| {
            let end = arc.motion.end.get(axis).map(|value| self.out.axis(axis, value));
            end.is_some() && end == self.written[axis]
        });
        if falls_together && within < TAU / 2.0 {
            // Shorter than the last decimal: as an arc it would come back as a full circle.
            return Some(self.motion_words("G1", &arc.motion, plane_axes));
        }
        let turns = if extra_turns > 0 { format!(" TURN={extra_turns}") } else { String::new() };
        match normal {
            Some(axis) => {
                if self.plane != axis {
                    self.plane = axis;
                    words.push_str(&format!("G{} ", 19 - axis));
                }
                let word = if arc.normal[axis] > 0.0 { "G3" } else { "G2" };
                words.push_str(&self.motion_words(word, &arc.motion, plane_axes));
                if let Some(radius) = radius_word(arc, &self.out.settings).filter(|_| !falls_together) {
                    words.push_str(&format!(" CR={}", self.out.center(radius)));
                    return Some(words);
                }
                for (at, letter) in ['I', 'J', 'K'].into_iter().enumerate().filter(|(at, _)| *at != axis) {
                    words.push_str(&format!(" {letter}=AC({})", self.out.center(arc.center[at])));
                }
            }
            None => {
                let end = arc.motion.end.xyz()?;
                if falls_together {
                    return None;
                }
                // The point half way, turned back from the end about the normal (Rodrigues, normal and radius
                // are square).
                let out = frame::sub(end, arc.center);
                let (s, c) = (-0.5 * within).sin_cos();
                let across = frame::cross(arc.normal, out);
                let middle: [f64; 3] = std::array::from_fn(|i| arc.center[i] + c * out[i] + s * across[i]);
                words.push_str(&self.motion_words("CIP", &arc.motion, plane_axes));
                for (letter, value) in ['I', 'J', 'K'].into_iter().zip(middle) {
                    words.push_str(&format!(" {letter}1={}", self.out.center(value)));
                }
            }
        }
        words.push_str(&turns);
        Some(words)
    }

    fn feed(&mut self, feed: Feed) -> Result<(), Unpostable> {
        self.feed = Some(feed);
        let words = self.out.feed_words(feed, &mut self.feed_mode);
        self.line(&words)
    }

    fn coolant(&mut self, coolant: Coolant) -> Result<(), Unpostable> {
        let before = std::mem::replace(&mut self.coolant, coolant);
        super::tell_coolant(before, coolant, ["M9", "M8", "M7"], |words| self.line(words))
    }

    fn tcp(&mut self, tcp: Tcp) -> Result<(), Unpostable> {
        let mut before = self.tcp.replace(tcp);
        if self.swiveled {
            // CYCLE800 has it on, and its end switches it off.
            if !tcp.on {
                self.end_swivel()?;
            }
            before = Some(tcp);
        }
        let interpolation = match tcp.interpolation {
            OrientationInterpolation::Axes => "ORIAXES",
            OrientationInterpolation::GreatCircle => "ORIVECT",
        };
        if before.is_none_or(|b| b.on != tcp.on) {
            self.line(if tcp.on { "TRAORI" } else { "TRAFOOF" })?;
        }
        if before.is_none_or(|b| b.interpolation != tcp.interpolation) {
            self.line(interpolation)?;
        }
        Ok(())
    }

    /// G41, G42 with the number of the cutting edge where the commands name one.
    fn compensation(&mut self, comp: &CutterComp) -> Result<(), Unpostable> {
        let word = match comp.side {
            CompSide::Off => return self.line("G40"),
            CompSide::Left => "G41",
            CompSide::Right => "G42",
        };
        // An 840D has length and radius under one number, which is in force already.
        self.line(word)
    }

    /// G33 while the spindle runs, G331 in and G332 out for rigid tapping.
    fn thread(&mut self, thread: &ThreadMotion) -> Result<(), Unpostable> {
        let axes: Vec<usize> = (0..3).filter(|axis| thread.motion.programmed >> axis & 1 == 1).collect();
        let start: Vec<Option<f64>> =
            axes.iter().map(|&a| self.written[a].as_ref().and_then(|t| t.parse().ok())).collect();
        let moves = |at: usize| {
            let end = thread.motion.end.get(axes[at]).map(|v| self.out.in_unit(v));
            end.zip(start[at]).is_none_or(|(end, start)| (end - start).abs() > STANDS)
        };
        let moving: Vec<usize> = (0..axes.len()).filter(|&at| moves(at)).map(|at| axes[at]).collect();
        let [axis] = moving.as_slice() else {
            return Err(Unpostable::new("a thread that is not along one axis", "turn the frame so that it is"));
        };
        let letter = ['I', 'J', 'K'][*axis];
        let pitch = self.out.center(thread.pitch);
        let (word, sign) = match (thread.direction, self.tapping) {
            (None, _) => ("G33", ""),
            (Some(direction), None) => {
                self.tapping = Some(direction);
                ("G331", if direction == SpindleDirection::CounterClockwise { "-" } else { "" })
            }
            (Some(_), Some(inward)) => {
                self.tapping = None;
                ("G332", if inward == SpindleDirection::CounterClockwise { "-" } else { "" })
            }
        };
        let alone = Motion { programmed: 1 << axis, ..thread.motion.clone() };
        let words = self.motion_words(word, &alone, 0);
        self.line(&format!("{words} {letter}{sign}{pitch}"))
    }
}

impl<W: Write> Post for SiemensPost<W> {
    fn write(&mut self, command: &Command) -> Result<(), PostError> {
        self.command(&command.op).map_err(|unsaid| unsaid.at(&command.location))
    }

    fn finish(&mut self) -> Result<(), PostError> {
        let end = |post: &mut Self| -> Result<(), Unpostable> {
            post.write_frame()?;
            post.out.footer()
        };
        end(self).map_err(|unsaid| unsaid.at(&super::nowhere()))
    }
}

/// A motion that only turns the tool upright on the new frame.
fn is_swivel(motion: &Motion) -> bool {
    motion.programmed == 0 && motion.tool_axis.is_some_and(|axis| axis[2] > frame::SAME_DIRECTION)
}

fn tool_word(tool: &ToolName) -> String {
    match tool {
        ToolName::Empty => "T0".to_owned(),
        ToolName::Number(number) => format!("T{number}"),
        ToolName::Name(name) => format!("T=\"{}\"", plain(name)),
    }
}

/// The word of a work offset on an 840D.
fn offset_word(word: &str) -> Result<String, Unpostable> {
    match offset_number(word) {
        _ if word == "G500" => Ok(word.to_owned()),
        Some(number @ 1..=4) => Ok(format!("G{}", number + 53)),
        Some(number @ 5..=99) => Ok(format!("G{}", number + 500)),
        _ => Err(Unpostable::new(format!("the work offset {word}"), "use G54 to G57 or G505 to G599")),
    }
}

/// Text between quotation marks: the mark itself cannot be written.
fn plain(text: &str) -> String {
    text.replace('"', "'").replace(['\n', '\r'], " ")
}
