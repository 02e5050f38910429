//! Klartext for a Heidenhain TNC: `L`, `LN` with tool vectors, `CC` and `C`, helices as `CP`, M128 or
//! FUNCTION TCPM, tilted planes as PLANE SPATIAL.
//!
//! Shifts are datum shifts (cycle 7). Under turns about Z, mirrors and scales the coordinates are those of
//! the datum, which is the same motion. The length of a tool comes with its call; switching it off cannot be
//! said.

use std::f64::consts::TAU;
use std::io::Write;

use super::format::{
    LEAST_COSINE, PostFrames, PostLines, along_axis, full_turns, offset_number, one_line, radius_word, speed,
};
use super::{Post, PostError, PostSettings, Unpostable};
use crate::frame::Frame;
use crate::settings::Dialect;
use crate::{
    AXIS_LETTERS, ArcMotion, Command, CompSide, Coolant, Dwell, Feed, FrameChange, Motion, Offset, Op,
    OrientationInterpolation, PathMode, RotarySolution, Spindle, SpindleDirection, Tcp, ToolAction, ToolName,
};

/// Writes canonical commands as a Klartext program.
#[derive(Debug)]
pub struct HeidenhainPost<W> {
    out: PostLines<W>,
    number: u64,
    begun: bool,
    feed: Option<f64>,
    told_feed: Option<String>,
    per_revolution: bool,
    speed: Option<f64>,
    comp: Option<CompSide>,
    told_comp: CompSide,
    tcp: Option<Tcp>,
    length_on: bool,
    frames: PostFrames,
    /// Coordinates of the datum instead of those of the commands.
    flat: bool,
    tilted: bool,
    /// A tilted plane not yet written: the next command decides whether the control orients the
    /// tool normal to it.
    tilt: Option<[f64; 3]>,
    swiveled: bool,
    shifted: bool,
    coolant: Coolant,
    written: [Option<String>; 9],
    at: [Option<f64>; 3],
}

impl<W: Write> HeidenhainPost<W> {
    /// A post that writes to a sink.
    pub fn new(sink: W, settings: PostSettings) -> Self {
        // Blocks are numbered from 0 in any case.
        let settings = PostSettings { block_number_step: None, ..settings };
        Self {
            out: PostLines::new(sink, settings),
            number: 0,
            begun: false,
            feed: None,
            told_feed: None,
            per_revolution: false,
            speed: None,
            comp: None,
            told_comp: CompSide::Off,
            tcp: None,
            length_on: false,
            frames: PostFrames::new(),
            flat: false,
            tilted: false,
            tilt: None,
            swiveled: false,
            shifted: false,
            coolant: Coolant { flood: false, mist: false },
            written: Default::default(),
            at: [None; 3],
        }
    }

    /// Returns the sink.
    pub fn into_inner(self) -> W {
        self.out.sink
    }

    fn block(&mut self, words: &str) -> Result<(), Unpostable> {
        let number = self.number;
        self.number += 1;
        self.out.plain(&format!("{number} {words}"))
    }

    fn title(&self) -> String {
        let name: String =
            self.out.settings.program_name.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        let name = if name.is_empty() { "PROVEOUT".to_owned() } else { name };
        format!("PGM {name} {}", if self.out.settings.inches { "INCH" } else { "MM" })
    }

    fn begin(&mut self) -> Result<(), Unpostable> {
        self.begun = true;
        if let Some(header) = self.out.settings.header.take() {
            return header.iter().try_for_each(|line| self.out.plain(line));
        }
        let title = self.title();
        self.block(&format!("BEGIN {title}"))
    }

    fn forget(&mut self) {
        self.written = Default::default();
        self.at = [None; 3];
    }

    fn command(&mut self, op: &Op) -> Result<(), Unpostable> {
        if !self.begun {
            self.begin()?;
        }
        self.frames.before_motion(op, &self.out.settings, "PRESET0")?;
        let swivel = matches!(op, Op::Rapid(m) if m.programmed == 0 && m.tool_axis.is_some());
        if let Some(angles) = self.tilt.take() {
            let solution = if let Op::Rapid(motion) = op { motion.solution } else { RotarySolution::Nearest };
            self.plane(angles, swivel, solution)?;
            if swivel {
                return Ok(());
            }
        }
        match op {
            Op::Rapid(_) if swivel => Err(Unpostable::new(
                "a motion that turns the tool with the linear axes at rest",
                "write the positions of the rotary axes",
            )),
            Op::Rapid(motion) => self.straight(motion, true),
            Op::Linear(motion) => self.straight(motion, false),
            Op::Arc(arc) => self.arc(arc),
            Op::Dwell(Dwell::Seconds(seconds)) => {
                self.block("CYCL DEF 9.0 DWELL TIME")?;
                self.block(&format!("CYCL DEF 9.1 DWELL {seconds:.3}"))
            }
            Op::Dwell(_) => Err(Unpostable::new("a dwell in spindle revolutions", "write the dwell in seconds")),
            Op::Feed(feed) => self.feed(*feed),
            Op::FeedCounts(counts) => super::feed_counts(*counts, Dialect::Heidenhain),
            Op::Spindle(spindle) => self.spindle(*spindle),
            Op::Tool(action) => self.tool(action),
            Op::Plane('Z') => Ok(()),
            Op::Plane(_) => Err(Unpostable::new("a working plane other than XY", "use a tilted plane")),
            Op::Offset(Offset::ToolEdge { edge: 0 }) if self.length_on => Err(Unpostable::new(
                "switching the tool length off",
                "remove D0 or G49: a TNC keeps the length of the tool that was called",
            )),
            Op::Offset(Offset::ToolEdge { .. }) => Ok(()),
            Op::Offset(Offset::ToolDelta { length, radius, corner_radius }) => {
                let text = [*length, *radius, *corner_radius].map(|v| Self::signed(self.out.length(v)));
                self.block(&format!("TOOL CALL DL{} DR{} DR2:{}", text[0], text[1], text[2]))
            }
            Op::Retract(retract) => {
                self.forget();
                let way = match retract.distance {
                    Some(distance) => self.out.length(distance),
                    None => "MAX".to_owned(),
                };
                self.block(&format!("L M140 MB {way}{}", if retract.rapid { " FMAX" } else { "" }))
            }
            Op::Offset(Offset::TurnCenter { .. }) => Err(super::turns_ahead()),
            Op::Offset(Offset::Work { word }) => self.work_offset(word),
            Op::Frame(change) => self.frame(change),
            Op::Tcp(tcp) => self.tool_center(*tcp),
            Op::CutterComp(comp) => {
                self.comp = Some(comp.side);
                Ok(())
            }
            Op::PathMode(PathMode::Continuous { tolerance, orientation_tolerance }) => {
                self.block("CYCL DEF 32.0 TOLERANCE")?;
                let text =
                    tolerance.map(|t| format!(" T{}", super::decimal(self.out.in_unit(t), 5))).unwrap_or_default();
                self.block(&format!("CYCL DEF 32.1{text}"))?;
                match orientation_tolerance {
                    Some(angle) => {
                        self.block(&format!("CYCL DEF 32.2 HSC-MODE:0 TA{}", super::decimal(angle.to_degrees(), 5)))
                    }
                    None => Ok(()),
                }
            }
            Op::PathMode(PathMode::ExactStop) => {
                Err(Unpostable::new("an exact stop at the end of every block", "remove G60 or G61"))
            }
            Op::Override(change) if change.enabled && change.feed == 1.0 => Ok(()),
            Op::Override(_) => Err(Unpostable::new("a fixed or programmed override", "write the feed itself")),
            Op::Spline(_) => Err(Unpostable::new("a Bezier curve", "write it as short straight blocks")),
            Op::Probe(_) => Err(Unpostable::new("a probing motion", "write the measuring cycle by hand")),
            Op::Thread(_) => Err(Unpostable::new("a motion coupled to the spindle", "write the tapping cycle by hand")),
            Op::Coolant(coolant) => self.coolant(*coolant),
            Op::Overcut(overcut) => self.block(&format!("; {}", one_line(&overcut.to_string(), &[]))),
            Op::Message(text) => self.block(&format!("; {}", one_line(text, &[]))),
            Op::Note(note) => self.block(&format!("; {}", one_line(note, &[]))),
            Op::Stop { optional } => self.block(if *optional { "M1" } else { "M0" }),
            Op::End => self.block("M30"),
        }
    }

    fn signed(text: String) -> String {
        if text.starts_with('-') { text } else { format!("+{text}") }
    }

    fn value(&self, motion: &Motion, axis: usize) -> Option<f64> {
        if motion.machine_coordinates || !self.flat {
            return motion.end.get(axis);
        }
        let base = motion.end_base.get(axis)?;
        Some(base - if axis < 3 { self.frames.settable.translation[axis] } else { 0.0 })
    }

    fn coordinates(&mut self, motion: &Motion, forced: u16) -> Result<String, Unpostable> {
        super::must_be_known(motion, |axis| self.value(motion, axis))?;
        let turned = if self.flat && motion.programmed & 0b111 != 0 { 0b111 } else { 0 };
        let wanted = motion.programmed | turned | forced;
        let mut words = String::new();
        let mut kept = String::new();
        for (axis, letter) in AXIS_LETTERS.iter().enumerate() {
            let Some(value) = self.value(motion, axis).filter(|_| wanted >> axis & 1 == 1) else { continue };
            let text = Self::signed(self.out.axis(axis, value));
            let word = format!(" {letter}{text}");
            let same = self.out.settings.modal
                && !motion.machine_coordinates
                && forced >> axis & 1 == 0
                && self.written[axis].as_deref() == Some(&text);
            if !same {
                words.push_str(&word);
            } else if kept.is_empty() {
                kept = word;
            }
            let unit = if self.out.settings.inches { 25.4 } else { 1.0 };
            let rounded = text.parse::<f64>().ok().map(|v| v * unit).filter(|_| !motion.machine_coordinates);
            if let Some(slot) = self.at.get_mut(axis) {
                *slot = rounded;
            }
            self.written[axis] = rounded.map(|_| text);
        }
        Ok(if words.is_empty() { kept } else { words })
    }

    /// R0, RL, RR where it changes, and the feed.
    fn tail(&mut self, rapid: bool) -> Result<String, Unpostable> {
        let mut words = String::new();
        if let Some(side) = self.comp.take().filter(|side| *side != self.told_comp) {
            self.told_comp = side;
            words.push_str(match side {
                CompSide::Off => " R0",
                CompSide::Left => " RL",
                CompSide::Right => " RR",
            });
        }
        if rapid {
            words.push_str(" FMAX");
        } else if let Some(feed) = self.feed {
            let text = self.feed_text(feed);
            if self.told_feed.as_ref() != Some(&text) {
                words.push_str(&format!(" F{text}"));
                self.told_feed = Some(text);
            }
        } else {
            return Err(Unpostable::new("a motion without a feed", "program the feed"));
        }
        Ok(words)
    }

    fn feed_text(&self, feed: f64) -> String {
        let decimals = self.out.settings.feed_decimals + if self.per_revolution { 3 } else { 0 };
        // A TNC counts the feed of an inch program in tenths of an inch.
        let tenths = if self.out.settings.inches { 10.0 } else { 1.0 };
        self.out.above_zero(self.out.in_unit(feed) * tenths, decimals)
    }

    fn straight(&mut self, motion: &Motion, rapid: bool) -> Result<(), Unpostable> {
        if motion.exact_stop {
            return Err(Unpostable::new("an exact stop of one block", "remove G9"));
        }
        let axis = if self.flat { motion.tool_axis_base } else { motion.tool_axis };
        if axis.is_some() && !self.tcp.is_some_and(|tcp| tcp.on) && !self.swiveled {
            return Err(Unpostable::new("a tool vector without tool center point control", "switch it on before"));
        }
        let forced = if axis.is_some() { 0b111 } else { 0 };
        let mut words = self.coordinates(motion, forced)?;
        let mut word = "L";
        if let Some(axis) = axis {
            word = "LN";
            for (letter, component) in ["TX", "TY", "TZ"].iter().zip(axis) {
                words.push_str(&format!(" {letter}{}", Self::signed(self.out.vector(component))));
            }
        }
        let tail = self.tail(rapid)?;
        let machine = if motion.machine_coordinates { " M91" } else { "" };
        self.block(&format!("{word}{words}{tail}{machine}"))
    }

    fn arc(&mut self, arc: &ArcMotion) -> Result<(), Unpostable> {
        let (center, normal) = if self.flat {
            let shift = self.frames.settable.translation;
            (std::array::from_fn(|i| arc.center_base[i] - shift[i]), arc.normal_base)
        } else {
            (arc.center, arc.normal)
        };
        let Some((2, sense)) = along_axis(normal) else {
            return Err(Unpostable::new(
                "a circle outside of the XY plane",
                "use a tilted plane, or short straight blocks",
            ));
        };
        if arc.motion.tool_axis.is_some() {
            return Err(Unpostable::new("a circle with a tool vector", "write it as short straight blocks"));
        }
        if self.comp.is_some_and(|side| side != self.told_comp) {
            return Err(Unpostable::new(
                "a change of the radius compensation on a circle",
                "change it on a straight block",
            ));
        }
        if arc.motion.programmed >> 3 != 0 {
            return Err(Unpostable::new("a circle with rotary axes", "write it as short straight blocks"));
        }
        let height = self.value(&arc.motion, 2);
        let climbs = match (self.at[2], height) {
            (Some(from), Some(to)) => (to - from).abs() > 0.5 * 10f64.powi(-(self.out.settings.length_decimals as i32)),
            (None, Some(_)) => arc.motion.programmed & 0b100 != 0,
            _ => false,
        };
        let falls_together = [0, 1].iter().all(|&i| {
            let text = self.value(&arc.motion, i).map(|v| Self::signed(self.out.length(v)));
            text.is_some() && text == self.written[i]
        });
        let turns = full_turns(arc);
        if falls_together && turns == 0 && arc.sweep < TAU / 2.0 {
            return self.straight(&arc.motion, false);
        }
        let direction = if sense > 0.0 { "DR+" } else { "DR-" };
        let (x, y) = (Self::signed(self.out.center(center[0])), Self::signed(self.out.center(center[1])));
        if climbs || turns > 0 {
            let (Some(from), Some(to)) = (self.at[2], height) else {
                return Err(Unpostable::new(
                    "a helix whose start has not been written",
                    "program X, Y and Z before it",
                ));
            };
            self.block(&format!("CC X{x} Y{y}"))?;
            // The end follows from the angle: it is written finer than an axis.
            let decimals = self.out.settings.angle_decimals + 4;
            let angle = Self::signed(self.out.number(sense * arc.sweep.to_degrees(), decimals));
            let climb = Self::signed(self.out.length(to - from));
            let tail = self.tail(false)?;
            self.coordinates(&arc.motion, 0b111)?;
            return self.block(&format!("CP IPA{angle} IZ{climb} {direction}{tail}"));
        }
        if let Some(radius) = radius_word(arc, &self.out.settings).filter(|_| !falls_together) {
            let words = self.coordinates(&arc.motion, 0b11)?;
            let tail = self.tail(false)?;
            let radius = Self::signed(self.out.center(radius));
            return self.block(&format!("CR{words} R{radius} {direction}{tail}"));
        }
        self.block(&format!("CC X{x} Y{y}"))?;
        let words = self.coordinates(&Motion { programmed: 0b11, ..arc.motion.clone() }, 0b11)?;
        let tail = self.tail(false)?;
        self.block(&format!("C{words} {direction}{tail}"))
    }

    fn feed(&mut self, feed: Feed) -> Result<(), Unpostable> {
        let per_revolution = matches!(feed, Feed::PerRevolution(_));
        if per_revolution && self.out.settings.inches {
            return Err(Unpostable::new("a feed per revolution in inch", "write the program in mm"));
        }
        if per_revolution != self.per_revolution {
            self.per_revolution = per_revolution;
            self.told_feed = None;
            self.block(if per_revolution { "M136" } else { "M137" })?;
        }
        self.feed = Some(match feed {
            Feed::PerTime(v) => v * 60.0,
            Feed::PerRevolution(v) => v,
            Feed::InverseTime(_) => {
                return Err(Unpostable::new("inverse time feed", "write the feed in mm/min (G94)"));
            }
        });
        Ok(())
    }

    fn spindle(&mut self, spindle: Spindle) -> Result<(), Unpostable> {
        if let Some(value) =
            spindle.speed_rpm.filter(|v| self.speed != Some(*v) && spindle.direction != SpindleDirection::Off)
        {
            self.speed = Some(value);
            self.block(&format!("TOOL CALL S{}", speed(value)))?;
        }
        self.block(match spindle.direction {
            SpindleDirection::Off => "M5",
            SpindleDirection::Clockwise => "M3",
            SpindleDirection::CounterClockwise => "M4",
        })
    }

    fn tool(&mut self, action: &ToolAction) -> Result<(), Unpostable> {
        let (ToolAction::Select(tool) | ToolAction::Change(tool)) = action;
        let text = match tool {
            ToolName::Empty => "0".to_owned(),
            ToolName::Number(number) => number.to_string(),
            ToolName::Name(name) => format!("\"{}\"", one_line(name, &['"'])),
        };
        if matches!(action, ToolAction::Select(_)) {
            return self.block(&format!("TOOL DEF {text}"));
        }
        self.forget();
        self.length_on = *tool != ToolName::Empty;
        let speed = self.speed.map(|v| format!(" S{}", speed(v))).unwrap_or_default();
        self.block(&format!("TOOL CALL {text} Z{speed}"))
    }

    fn work_offset(&mut self, word: &str) -> Result<(), Unpostable> {
        let number = match offset_number(word) {
            Some(number) => number,
            None if word == "PRESET0" => 0,
            None => return Err(Unpostable::new(format!("the work offset {word}"), "use G54 to G59 or G505 to G599")),
        };
        let settings = std::mem::take(&mut self.out.settings);
        self.frames.offset(word, &settings);
        self.out.settings = settings;
        self.forget();
        self.block(&format!("CYCL DEF 247 DATUM SETTING Q339=+{number}"))?;
        // A preset ends the datum shift; a frame that stays in force is written again.
        let above = std::mem::replace(&mut self.frames.above, Frame::IDENTITY);
        self.shifted = false;
        if above == Frame::IDENTITY {
            return Ok(());
        }
        let total = self.frames.settable.then(&above);
        let change = FrameChange {
            word: word.to_owned(),
            rotation: total.linear,
            translation: total.translation,
            rotary: total.rotary,
        };
        self.frame(&change)
    }

    fn frame(&mut self, change: &FrameChange) -> Result<(), Unpostable> {
        let before = self.frames.above;
        self.frames.change(change);
        let above = self.frames.above;
        if above == before {
            return Ok(());
        }
        if above.rotary != [0.0; 3] {
            return Err(Unpostable::new("a shift of rotary axes", "put it into the datum of the control"));
        }
        self.forget();
        if std::mem::take(&mut self.tilted) {
            self.swiveled = false;
            self.block("PLANE RESET STAY")?;
        }
        let tilted = self.frames.is_tilted();
        if tilted && !self.frames.is_rotation() {
            return Err(Unpostable::new(
                "a tilted frame with a mirror or a scale",
                "mirror or scale the path in the CAM system",
            ));
        }
        self.flat = !tilted && above.linear != Frame::IDENTITY.linear;
        let shift = if self.flat { [0.0; 3] } else { above.translation };
        if shift != [0.0; 3] || self.shifted {
            self.shifted = shift != [0.0; 3];
            self.block("CYCL DEF 7.0 DATUM SHIFT")?;
            for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
                let text = Self::signed(self.out.length(shift[i]));
                self.block(&format!("CYCL DEF 7.{} {letter}{text}", i + 1))?;
            }
        }
        if tilted {
            self.tilted = true;
            // Rz Ry Rx: the image of e_x is (cz cy, sz cy, -sy).
            let m = above.linear;
            let flat = m[0][0].hypot(m[1][0]);
            let b = (-m[2][0]).atan2(flat);
            let (a, c) = if flat > LEAST_COSINE {
                (m[2][1].atan2(m[2][2]), m[1][0].atan2(m[0][0]))
            } else {
                (0.0, (-m[0][1]).atan2(m[1][1]))
            };
            self.tilt = Some([a, b, c]);
        }
        Ok(())
    }

    fn plane(&mut self, angles: [f64; 3], turn: bool, solution: RotarySolution) -> Result<(), Unpostable> {
        // A frame turns points far from its origin: it is written finer than an axis.
        let decimals = self.out.settings.angle_decimals + 3;
        let text = angles.map(|v| Self::signed(self.out.number(v.to_degrees(), decimals)));
        self.swiveled = turn;
        let motion = if turn { "TURN FMAX" } else { "STAY" };
        let choice = match solution {
            RotarySolution::Nearest => "",
            RotarySolution::Angle { higher: true, .. } => " SEQ+",
            RotarySolution::Angle { higher: false, .. } => " SEQ-",
        };
        self.block(&format!("PLANE SPATIAL SPA{} SPB{} SPC{} {motion}{choice}", text[0], text[1], text[2]))
    }

    fn tool_center(&mut self, tcp: Tcp) -> Result<(), Unpostable> {
        let before = self.tcp.replace(tcp);
        if tcp.on && self.swiveled || before.is_none_or(|b| !b.on) && !tcp.on {
            // PLANE has switched it on, or it is off.
            self.tcp = if tcp.on { None } else { Some(tcp) };
            return Ok(());
        }
        if before == Some(tcp) {
            return Ok(());
        }
        self.forget();
        self.block(match (tcp.on, tcp.interpolation) {
            (false, _) => "FUNCTION RESET TCPM",
            (true, OrientationInterpolation::Axes) => "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS",
            (true, OrientationInterpolation::GreatCircle) => "FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR",
        })
    }

    fn coolant(&mut self, coolant: Coolant) -> Result<(), Unpostable> {
        let before = std::mem::replace(&mut self.coolant, coolant);
        super::tell_coolant(before, coolant, ["M9", "M8", "M7"], |words| self.block(words))
    }
}

impl<W: Write> Post for HeidenhainPost<W> {
    fn write(&mut self, command: &Command) -> Result<(), PostError> {
        self.command(&command.op).map_err(|unsaid| unsaid.at(&command.location))
    }

    fn finish(&mut self) -> Result<(), PostError> {
        let end = |post: &mut Self| -> Result<(), Unpostable> {
            if post.begun {
                let title = post.title();
                post.block(&format!("END {title}"))?;
            }
            post.out.footer()
        };
        end(self).map_err(|unsaid| unsaid.at(&super::nowhere()))
    }
}
