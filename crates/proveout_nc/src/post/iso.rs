//! ISO text for Fanuc (G43.4, G43.5, G68.2), Haas (G234) and `LinuxCNC`.
//!
//! Coordinates are those of the active frame where it shifts (G52) or, on Fanuc, tilts (G68.2, G53.1). Under
//! turns about Z, mirrors and scales they are written as those of the work offset, which is the same motion
//! without words that half of the controls lack. Motions are in [`super::iso_motion`].

use std::io::Write;

use super::format::{PostFrames, PostLines, full_turns, offset_number, one_line, speed};
use super::{Post, PostError, PostSettings, Unpostable};
use crate::frame;
use crate::settings::Dialect;
use crate::{
    Command, CompSide, Coolant, CutterComp, Dwell, Feed, FrameChange, Motion, Offset, Op, Override, PathMode,
    RotarySolution, Spindle, SpindleDirection, ToolAction, ToolName,
};

/// An override this near to one is none.
const SAME_FEED: f64 = 1e-12;

/// Which coordinates are written under a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CoordinateFrame {
    /// Those of the commands.
    AsProgrammed,
    /// Those of the work offset.
    Flat,
}

/// Writes canonical commands as an ISO program.
#[derive(Debug)]
pub struct IsoPost<W> {
    pub(crate) out: PostLines<W>,
    pub(crate) dialect: Dialect,
    begun: bool,
    /// G word of the last motion.
    pub(crate) word: Option<&'static str>,
    /// Axis normal to the plane.
    pub(crate) plane: usize,
    pub(crate) feed: Option<Feed>,
    feed_mode: Option<&'static str>,
    coolant: Coolant,
    /// Tool center point control is asked for; its word is chosen by the next motion.
    pub(crate) tcp: bool,
    pub(crate) tcp_word: Option<&'static str>,
    pub(crate) edge: Option<u32>,
    pub(crate) tool: Option<ToolName>,
    selected: Option<ToolName>,
    /// Length that was called for a tool that is selected and not yet in the spindle.
    next_length: Option<u32>,
    /// G41 or G42 is in force.
    compensated: bool,
    pub(crate) frames: PostFrames,
    pub(crate) way: CoordinateFrame,
    pub(crate) tilted: bool,
    shifted: bool,
    /// G53.1 has turned the tool upright on the tilted plane, and switched tool center point control on.
    swiveled: bool,
    /// Text of the last coordinate of each axis, and the position it represents.
    pub(crate) written: [Option<String>; 9],
    pub(crate) at: [Option<f64>; 9],
    pub(crate) axis: Option<[f64; 3]>,
}

impl<W: Write> IsoPost<W> {
    /// A post that writes to a sink.
    pub fn new(dialect: Dialect, sink: W, settings: PostSettings) -> Self {
        Self {
            out: PostLines::new(sink, settings),
            dialect: if dialect == Dialect::Iso { Dialect::Fanuc } else { dialect },
            begun: false,
            word: None,
            plane: 2,
            feed: None,
            feed_mode: None,
            coolant: Coolant { flood: false, mist: false },
            tcp: false,
            tcp_word: None,
            edge: None,
            tool: None,
            selected: None,
            next_length: None,
            compensated: false,
            frames: PostFrames::new(),
            way: CoordinateFrame::AsProgrammed,
            tilted: false,
            shifted: false,
            swiveled: false,
            written: Default::default(),
            at: [None; 9],
            axis: None,
        }
    }

    /// Returns the sink.
    pub fn into_inner(self) -> W {
        self.out.sink
    }

    fn begin(&mut self) -> Result<(), Unpostable> {
        self.begun = true;
        if let Some(header) = self.out.settings.header.take() {
            return header.iter().try_for_each(|line| self.out.plain(line));
        }
        let name = self.out.settings.program_name.clone();
        if self.dialect == Dialect::LinuxCnc {
            self.out.plain(&format!("({})", one_line(&name, &['(', ')'])))?;
        } else {
            self.out.plain("%")?;
            match name.parse::<u32>() {
                Ok(number) => self.out.plain(&format!("O{number:04}"))?,
                Err(_) => self.out.plain(&format!("O0001 ({})", one_line(&name, &['(', ')'])))?,
            }
        }
        self.feed_mode = Some("G94");
        let unit = if self.out.settings.inches { "G20" } else { "G21" };
        self.out.block(&format!("{unit} G17 G40 G49 G80 G90 G94"))
    }

    /// What was written about positions does not hold any more.
    pub(crate) fn forget(&mut self) {
        self.written = Default::default();
        self.at = [None; 9];
    }

    fn command(&mut self, op: &Op) -> Result<(), Unpostable> {
        if !self.begun {
            self.begin()?;
        }
        self.frames.before_motion(op, &self.out.settings, "G54")?;
        if matches!(op, Op::Rapid(_) | Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Probe(_) | Op::Thread(_))
            && let Some(edge) = self.next_length.take()
        {
            // It is needed before the tool comes.
            self.selected = None;
            self.length(edge)?;
        }
        match op {
            Op::Rapid(motion) if motion.programmed == 0 && motion.tool_axis.is_some() => self.swivel(motion),
            Op::Rapid(motion) => self.straight("G0", motion),
            Op::Linear(motion) => self.straight("G1", motion),
            Op::Arc(arc) => {
                let turns = full_turns(arc);
                self.arc(arc, turns)
            }
            Op::Spline(spline) => self.spline(spline),
            Op::Probe(probe) => self.probe(probe),
            Op::Thread(thread) => self.thread(thread),
            Op::Dwell(dwell) => self.dwell(*dwell),
            Op::Feed(feed) => self.feed(*feed),
            Op::FeedCounts(counts) => super::feed_counts(*counts, self.dialect),
            Op::Spindle(spindle) => self.spindle(*spindle),
            Op::Tool(action) => self.tool(action),
            Op::Plane(normal) => {
                self.plane = crate::AxisValues::index(*normal).filter(|&axis| axis < 3).unwrap_or(2);
                self.out.block(&format!("G{}", 19 - self.plane))
            }
            Op::Offset(Offset::ToolEdge { edge }) => self.length(*edge),
            Op::Offset(Offset::ToolDelta { length, radius, corner_radius }) => {
                if [length, radius, corner_radius].iter().all(|v| **v == 0.0) {
                    return Ok(());
                }
                Err(Unpostable::new("delta values of the tool", "write them into the tool table"))
            }
            Op::Retract(_) => Err(Unpostable::new("a retraction along the tool axis", "write the retracted position")),
            Op::Offset(Offset::TurnCenter { .. }) => Err(super::turns_ahead()),
            Op::Offset(Offset::Work { word }) => self.work_offset(word),
            Op::Frame(change) => self.frame(change),
            Op::Tcp(tcp) => self.tool_center(tcp.on),
            Op::CutterComp(comp) => self.compensation(comp),
            Op::Override(change) => self.override_word(*change),
            Op::PathMode(mode) => self.path_mode(*mode),
            Op::Coolant(coolant) => self.coolant(*coolant),
            Op::Message(text) if self.dialect == Dialect::LinuxCnc => {
                self.out.block(&format!("(MSG, {})", one_line(text, &['(', ')'])))
            }
            Op::Overcut(overcut) => self.comment(&overcut.to_string()),
            Op::Message(text) => self.comment(text),
            Op::Note(note) => self.comment(note),
            Op::Stop { optional } => self.out.block(if *optional { "M1" } else { "M0" }),
            Op::End => self.out.block("M30"),
        }
    }

    fn comment(&mut self, text: &str) -> Result<(), Unpostable> {
        self.out.block(&format!("({})", one_line(text, &['(', ')', '%'])))
    }

    fn dwell(&mut self, dwell: Dwell) -> Result<(), Unpostable> {
        match dwell {
            Dwell::Seconds(seconds) if self.dialect == Dialect::Fanuc => {
                self.out.block(&format!("G4 P{}", (seconds * 1000.0).round()))
            }
            // A decimal point makes it seconds on a Haas.
            Dwell::Seconds(seconds) => self.out.block(&format!("G4 P{seconds:.3}")),
            Dwell::Revolutions(_) => {
                Err(Unpostable::new("a dwell in spindle revolutions", "write the dwell in seconds"))
            }
        }
    }

    fn feed(&mut self, feed: Feed) -> Result<(), Unpostable> {
        self.feed = Some(feed);
        let words = self.out.feed_words(feed, &mut self.feed_mode);
        self.out.block(&words)
    }

    fn spindle(&mut self, spindle: Spindle) -> Result<(), Unpostable> {
        let m = match spindle.direction {
            SpindleDirection::Off => "M5",
            SpindleDirection::Clockwise => "M3",
            SpindleDirection::CounterClockwise => "M4",
        };
        match spindle.speed_rpm {
            Some(value) if m != "M5" => self.out.block(&format!("S{} {m}", speed(value))),
            _ => self.out.block(m),
        }
    }

    fn tool(&mut self, action: &ToolAction) -> Result<(), Unpostable> {
        let (ToolAction::Select(tool) | ToolAction::Change(tool)) = action;
        let number = match tool {
            ToolName::Empty => 0,
            ToolName::Number(number) => *number,
            ToolName::Name(name) => {
                return Err(Unpostable::new(
                    format!("the tool {name:?}: ISO programs call tools by number"),
                    "give the tools numbers",
                ));
            }
        };
        match action {
            ToolAction::Select(_) => {
                self.selected = Some(tool.clone());
                self.out.block(&format!("T{number}"))
            }
            ToolAction::Change(_) => {
                self.forget();
                self.tool = Some(tool.clone());
                if self.selected.as_ref() == Some(tool) {
                    self.out.block("M6")?;
                } else {
                    self.out.block(&format!("T{number} M6"))?;
                }
                self.selected = None;
                match self.next_length.take() {
                    Some(edge) => self.length(edge),
                    None => Ok(()),
                }
            }
        }
    }

    fn length(&mut self, edge: u32) -> Result<(), Unpostable> {
        // The length programmed with T belongs to the next tool: a G43 before M6 would apply it to
        // the old tool.
        if edge != 0 && self.selected.is_some() && self.selected != self.tool {
            self.next_length = Some(edge);
            return Ok(());
        }
        self.not_under_compensation("a tool length that changes under cutter compensation")?;
        self.edge = Some(edge);
        self.forget();
        if edge == 0 {
            self.tcp_word = None;
            return self.out.block("G49");
        }
        if self.tcp && self.tcp_word.is_some() {
            // The word with the new number comes with the next motion.
            self.tcp_word = None;
            return Ok(());
        }
        let number = self.out.edge(edge, self.tool.as_ref());
        self.out.block(&format!("G43 H{number}"))
    }

    fn work_offset(&mut self, word: &str) -> Result<(), Unpostable> {
        let text = match (offset_number(word), self.dialect) {
            (Some(number @ 1..=6), _) => format!("G{}", number + 53),
            (Some(number @ 7..=9), Dialect::LinuxCnc) => format!("G59.{}", number - 6),
            (Some(number), Dialect::Haas) if number <= 105 => format!("G154 P{}", number - 6),
            (Some(number), Dialect::Fanuc) if number <= 306 => format!("G54.1 P{}", number - 6),
            _ => return Err(Unpostable::new(format!("the work offset {word}"), "use G54 to G59")),
        };
        let settings = std::mem::take(&mut self.out.settings);
        self.frames.offset(word, &settings);
        self.out.settings = settings;
        self.forget();
        self.out.block(&text)
    }

    fn frame(&mut self, change: &FrameChange) -> Result<(), Unpostable> {
        let before = self.frames.above;
        self.frames.change(change);
        let above = self.frames.above;
        if above == before {
            return Ok(());
        }
        self.forget();
        let tilted = self.frames.is_tilted() && self.frames.is_rotation();
        if self.tilted {
            self.tilted = false;
            self.swiveled = false;
            self.out.block("G69")?;
        }
        if tilted && self.dialect == Dialect::Fanuc && self.tcp_word.is_some() {
            return Err(Unpostable::new(
                "a turned frame while tool center point control is on",
                "switch it off before the frame, or post for an 840D",
            ));
        }
        if tilted && self.dialect == Dialect::Fanuc {
            self.unshift()?;
            self.way = CoordinateFrame::AsProgrammed;
            self.tilted = true;
            return self.tilt();
        }
        if self.frames.above.linear != frame::Frame::IDENTITY.linear {
            self.unshift()?;
            self.way = CoordinateFrame::Flat;
            if above.rotary != [0.0; 3] {
                return Err(Unpostable::new("a shift of rotary axes in a turned frame", "use a work offset"));
            }
            return Ok(());
        }
        self.way = CoordinateFrame::AsProgrammed;
        let words = [0, 1, 2].map(|i| format!("{}{}", ['X', 'Y', 'Z'][i], self.out.length(above.translation[i])));
        let mut text = format!("G52 {}", words.join(" "));
        for (letter, value) in ['A', 'B', 'C'].into_iter().zip(above.rotary) {
            if value != 0.0 || self.shifted && before.rotary != [0.0; 3] {
                text.push_str(&format!(" {letter}{}", self.out.angle(value)));
            }
        }
        self.shifted = above != frame::Frame::IDENTITY;
        self.out.block(&text)
    }

    /// Takes G52 out of effect.
    fn unshift(&mut self) -> Result<(), Unpostable> {
        if std::mem::take(&mut self.shifted) { self.out.block("G52 X0. Y0. Z0.") } else { Ok(()) }
    }

    /// G68.2: origin, and Euler angles about Z, the new X, the newest Z.
    fn tilt(&mut self) -> Result<(), Unpostable> {
        let m = self.frames.above.linear;
        // R = Rz(a) Rx(b) Rz(c): the third column is (sin a sin b, -cos a sin b, cos b), the third row (..,
        // sin b cos c, cos b).
        let b = m[0][2].hypot(m[1][2]).atan2(m[2][2]);
        let (a, c) = (m[0][2].atan2(-m[1][2]), m[2][0].atan2(m[2][1]));
        let t = self.frames.above.translation.map(|v| self.out.length(v));
        // A frame turns points far from its origin: it is written finer than an axis.
        let decimals = self.out.settings.angle_decimals + 3;
        let angles = [a, b, c].map(|v| self.out.number(v.to_degrees(), decimals));
        self.out.block(&format!("G68.2 X{} Y{} Z{} I{} J{} K{}", t[0], t[1], t[2], angles[0], angles[1], angles[2]))
    }

    /// The rotary axes turn the tool upright on the tilted plane.
    fn swivel(&mut self, motion: &Motion) -> Result<(), Unpostable> {
        let upright = motion.tool_axis.is_some_and(|axis| axis[2] > frame::SAME_DIRECTION);
        if self.tilted && upright {
            self.swiveled = true;
            self.forget();
            return self.out.block(match motion.solution {
                RotarySolution::Nearest => "G53.1",
                RotarySolution::Angle { higher: true, .. } => "G53.1 P1",
                RotarySolution::Angle { higher: false, .. } => "G53.1 P2",
            });
        }
        if self.tcp && self.dialect == Dialect::Fanuc {
            return self.straight("G0", motion);
        }
        Err(Unpostable::new(
            "a motion that turns the tool with the linear axes at rest",
            "post it for fanuc, or write the positions of the rotary axes",
        ))
    }

    fn tool_center(&mut self, on: bool) -> Result<(), Unpostable> {
        if on == self.tcp {
            return Ok(());
        }
        self.tcp = on;
        if on && self.swiveled {
            return Ok(());
        }
        self.forget();
        if !on {
            let was = self.tcp_word.take();
            if was.is_some() {
                self.out.block("G49")?;
                if let Some(edge) = self.edge.filter(|edge| *edge != 0) {
                    return self.length(edge);
                }
            }
        }
        Ok(())
    }

    /// The word of tool center point control, once it is known whether vectors or rotary axes follow.
    pub(crate) fn tell_tool_center(&mut self, vectors: bool) -> Result<(), Unpostable> {
        if !self.tcp || self.swiveled {
            return Ok(());
        }
        let word = match (self.dialect, vectors) {
            (Dialect::Fanuc, true) => "G43.5",
            (Dialect::Fanuc, false) => "G43.4",
            (Dialect::Haas, false) => "G234",
            (Dialect::Haas, true) => {
                return Err(Unpostable::new(
                    "tool vectors: a Haas takes rotary axes only",
                    "post for fanuc or siemens-840d, or write the positions of the rotary axes",
                ));
            }
            _ => {
                return Err(Unpostable::new(
                    "tool center point control: LinuxCNC has no word for it",
                    "post for fanuc, haas, siemens-840d or heidenhain",
                ));
            }
        };
        // G43.5 takes no rotary axis words; while it is active, points without a vector keep the
        // tool axis.
        if self.tcp_word == Some(word) || self.tcp_word == Some("G43.5") && word == "G43.4" {
            return Ok(());
        }
        let number = self.out.edge(self.edge.unwrap_or(1).max(1), self.tool.as_ref());
        self.tcp_word = Some(word);
        self.forget();
        self.out.block(&format!("{word} H{number}"))
    }

    fn compensation(&mut self, comp: &CutterComp) -> Result<(), Unpostable> {
        let word = match comp.side {
            CompSide::Off => {
                self.compensated = false;
                return self.out.block("G40");
            }
            CompSide::Left => "G41",
            CompSide::Right => "G42",
        };
        self.not_under_compensation("cutter compensation that changes while it is in force")?;
        self.compensated = true;
        match (comp.offset, comp.radius) {
            (Some(offset), _) => self.out.block(&format!("{word} D{offset}")),
            (None, Some(radius)) if self.dialect == Dialect::LinuxCnc => {
                let diameter = self.out.center(2.0 * radius);
                self.out.block(&format!("{word}.1 D{diameter}"))
            }
            _ if self.dialect == Dialect::LinuxCnc => self.out.block(word),
            _ => {
                let number = self.out.edge(self.edge.unwrap_or(1).max(1), self.tool.as_ref());
                self.out.block(&format!("{word} D{number}"))
            }
        }
    }

    /// The interpreter of a `LinuxCNC` refuses G41, G42, G43 and G49 while G41 or G42 is in force.
    fn not_under_compensation(&self, what: &str) -> Result<(), Unpostable> {
        if self.compensated && self.dialect == Dialect::LinuxCnc {
            return Err(Unpostable::new(
                format!("{what}: a LinuxCNC refuses it"),
                "end the compensation before, or post for another control",
            ));
        }
        Ok(())
    }

    fn override_word(&mut self, change: Override) -> Result<(), Unpostable> {
        if (change.feed - 1.0).abs() > SAME_FEED {
            return Err(Unpostable::new("a programmed feed override", "write the feed itself"));
        }
        self.out.block(if change.enabled { "M48" } else { "M49" })
    }

    fn path_mode(&mut self, mode: PathMode) -> Result<(), Unpostable> {
        match mode {
            PathMode::ExactStop => self.out.block("G61"),
            PathMode::Continuous { tolerance: Some(tolerance), .. } if self.dialect == Dialect::LinuxCnc => {
                let text = self.out.center(tolerance);
                self.out.block(&format!("G64 P{text}"))
            }
            PathMode::Continuous { tolerance, .. } => {
                self.out.block("G64")?;
                match tolerance {
                    Some(tolerance) => self.comment(&format!("TOLERANCE {} MM", super::decimal(tolerance, 6))),
                    None => Ok(()),
                }
            }
        }
    }

    fn coolant(&mut self, coolant: Coolant) -> Result<(), Unpostable> {
        let before = std::mem::replace(&mut self.coolant, coolant);
        super::tell_coolant(before, coolant, ["M9", "M8", "M7"], |words| self.out.block(words))
    }
}

impl<W: Write> Post for IsoPost<W> {
    fn write(&mut self, command: &Command) -> Result<(), PostError> {
        self.command(&command.op).map_err(|unsaid| unsaid.at(&command.location))
    }

    fn finish(&mut self) -> Result<(), PostError> {
        let nowhere = super::nowhere();
        let end = |post: &mut Self| -> Result<(), Unpostable> {
            if post.dialect != Dialect::LinuxCnc && post.begun {
                post.out.plain("%")?;
            }
            post.out.footer()
        };
        end(self).map_err(|unsaid| unsaid.at(&nowhere))
    }
}
