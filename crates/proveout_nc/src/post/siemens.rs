//! Siemens 840D text: TRAORI with rotary axes or vectors, frames as TRANS and AROT, arcs with absolute centers.

use std::f64::consts::TAU;
use std::io::Write;

use super::{PostError, PostSettings, decimal, positive};
use crate::frame::{self, Frame};
use crate::{
    AXIS_LETTERS, ArcMotion, AxisValues, Command, CompSide, Coolant, Dwell, Feed, FrameChange, Motion, Offset, Op,
    OrientationInterpolation, PathMode, SpindleDirection, Tcp, ToolAction, ToolName,
};

/// Writes canonical commands as a program for an 840D, one after the other.
#[derive(Debug)]
pub struct SiemensPost<W> {
    sink: W,
    settings: PostSettings,
    number: u32,
    interpolation: Option<&'static str>,
    plane: usize,
    feed: Option<Feed>,
    feed_mode: Option<&'static str>,
    coolant: Coolant,
    tcp: Option<Tcp>,
    settable: Frame,
    programmable: Frame,
    /// Text of the last coordinate of each axis, to see when an end point falls onto its start.
    written: [Option<String>; 9],
}

impl<W: Write> SiemensPost<W> {
    /// A post that writes to a sink.
    pub fn new(sink: W, settings: PostSettings) -> Self {
        Self {
            sink,
            settings,
            number: 0,
            interpolation: None,
            plane: 2,
            feed: None,
            feed_mode: None,
            coolant: Coolant { flood: false, mist: false },
            tcp: None,
            settable: Frame::IDENTITY,
            programmable: Frame::IDENTITY,
            written: Default::default(),
        }
    }

    /// Writes a command.
    ///
    /// # Errors
    /// The sink fails, or the command cannot be said in this language.
    pub fn write(&mut self, command: &Command) -> Result<(), PostError> {
        let unsupported = |what: &str, help: &'static str| PostError::Unsupported {
            what: what.to_owned(),
            help,
            location: command.location.clone(),
        };
        match &command.op {
            Op::Rapid(motion) | Op::Linear(motion) => {
                let word = if matches!(command.op, Op::Rapid(_)) { "G0" } else { "G1" };
                if motion.tool_axis.is_some() && !self.tcp.is_some_and(|tcp| tcp.on) {
                    return Err(unsupported(
                        "a tool vector without TRAORI",
                        "write swivel planes as frames and rotary axes",
                    ));
                }
                let words = self.motion_words(word, motion, 0);
                self.line(&words)
            }
            Op::Arc(arc) => match self.arc_words(arc) {
                Some(words) => self.line(&words),
                None => Err(unsupported("a full circle outside of G17, G18, G19", "split it into two arcs")),
            },
            Op::Dwell(Dwell::Seconds(seconds)) => self.line(&format!("G4 F{}", decimal(*seconds, 3))),
            Op::Dwell(Dwell::Revolutions(revolutions)) => self.line(&format!("G4 S{}", decimal(*revolutions, 3))),
            Op::Feed(feed) => self.feed(*feed),
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
            Op::Tool(ToolAction::Select(ToolName::Empty)) => self.line("T0"),
            Op::Tool(ToolAction::Select(ToolName::Number(number))) => self.line(&format!("T{number}")),
            Op::Tool(ToolAction::Select(ToolName::Name(name))) => self.line(&format!("T=\"{}\"", plain(name))),
            Op::Tool(ToolAction::Change(_)) => self.line("M6"),
            Op::Plane(normal) => {
                self.plane = AxisValues::index(*normal).filter(|&axis| axis < 3).unwrap_or(2);
                self.line(&format!("G{}", 19 - self.plane))
            }
            Op::Offset(Offset::ToolEdge { edge }) => self.line(&format!("D{edge}")),
            Op::Offset(Offset::ToolDelta { .. }) => {
                Err(unsupported("delta values of the tool", "write them into the tool table"))
            }
            Op::Offset(Offset::Work { word }) => {
                let values = self.settings.work_offsets.get(word).copied().unwrap_or_default();
                self.settable = Frame { rotary: values.rotary, ..Frame::translation(values.translation) };
                self.line(word)
            }
            Op::Frame(change) => match self.frame_lines(change) {
                Some(lines) => lines.iter().try_for_each(|line| self.line(line)),
                None => Err(unsupported("a frame with shear", "use rotations, mirrors and scales")),
            },
            Op::Tcp(tcp) => self.tcp(*tcp),
            Op::CutterComp(comp) => self.line(match comp.side {
                CompSide::Off => "G40",
                CompSide::Left => "G41",
                CompSide::Right => "G42",
            }),
            Op::Override(change) => self.line(&format!("OVR={}", decimal(change.feed * 100.0, 3))),
            Op::Spline(_) => Err(unsupported("a Bezier curve", "write it as short straight blocks")),
            Op::Probe(_) => Err(unsupported("a probing motion", "write the measuring cycle by hand")),
            Op::Retract(_) => Err(unsupported("a retraction along the tool axis", "write the retracted position")),
            Op::Thread(_) => Err(unsupported("a motion coupled to the spindle", "write the tapping cycle by hand")),
            Op::PathMode(PathMode::ExactStop) => self.line("G60"),
            Op::PathMode(PathMode::Continuous { tolerance, orientation_tolerance }) => {
                // A negative tolerance is the word for "as set up on the machine".
                let contour = tolerance.map_or("-1".to_owned(), |t| decimal(t, self.settings.length_decimals + 2));
                let orientation = orientation_tolerance
                    .map_or("-1".to_owned(), |t| decimal(t.to_degrees(), self.settings.angle_decimals + 2));
                self.line(&format!("CTOL={contour} OTOL={orientation} G645"))
            }
            Op::Coolant(coolant) => self.coolant(*coolant),
            Op::Message(text) => self.line(&format!("MSG(\"{}\")", plain(text))),
            Op::Note(text) => self.line(&format!("; {}", text.replace(['\n', '\r'], " "))),
            Op::Stop { optional } => self.line(if *optional { "M1" } else { "M0" }),
            Op::End => self.line("M30"),
        }
    }

    /// Gives the sink back.
    pub fn into_inner(self) -> W {
        self.sink
    }

    fn line(&mut self, words: &str) -> Result<(), PostError> {
        if words.is_empty() {
            return Ok(());
        }
        if let Some(step) = self.settings.block_number_step {
            self.number = self.number.saturating_add(step);
            write!(self.sink, "N{} ", self.number)?;
        }
        writeln!(self.sink, "{words}")?;
        Ok(())
    }

    fn coordinate(&self, axis: usize, value: f64) -> String {
        if (3..6).contains(&axis) {
            decimal(value.to_degrees(), self.settings.angle_decimals)
        } else {
            decimal(value, self.settings.length_decimals)
        }
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
                let text = self.coordinate(axis, value);
                words.push(format!("{letter}{text}"));
                self.written[axis] = (!motion.machine_coordinates).then_some(text);
            }
        }
        if let Some(axis) = motion.tool_axis {
            for (letter, component) in ['A', 'B', 'C'].iter().zip(axis) {
                words.push(format!("{letter}3={}", decimal(component, self.settings.vector_decimals)));
            }
        }
        if let Some(Feed::InverseTime(seconds)) = self.feed.filter(|_| word != "G0") {
            words.push(format!("F{}", positive(60.0 / seconds, 6)));
        }
        words.join(" ")
    }

    /// Words of an arc; none for what CIP cannot say.
    fn arc_words(&mut self, arc: &ArcMotion) -> Option<String> {
        let normal = arc.normal.iter().position(|v| v.abs() > 1.0 - 1e-9);
        let extra_turns = ((arc.sweep / TAU - 1e-9).ceil() - 1.0).max(0.0);
        let within = arc.sweep - extra_turns * TAU;
        let mut words = String::new();
        let plane_axes: u16 = match normal {
            Some(axis) => 0b111 & !(1 << axis),
            None => 0b111,
        };
        let falls_together = (0..3).filter(|axis| plane_axes >> axis & 1 == 1).all(|axis| {
            let end = arc.motion.end.get(axis).map(|value| self.coordinate(axis, value));
            end.is_some() && end == self.written[axis]
        });
        if falls_together && within < TAU / 2.0 {
            // Shorter than the last decimal: as an arc it would come back as a full circle.
            return Some(self.motion_words("G1", &arc.motion, plane_axes));
        }
        let d = self.settings.length_decimals;
        let turns = if extra_turns > 0.0 { format!(" TURN={extra_turns}") } else { String::new() };
        match normal {
            Some(axis) => {
                if self.plane != axis {
                    self.plane = axis;
                    words.push_str(&format!("G{} ", 19 - axis));
                }
                let word = if arc.normal[axis] > 0.0 { "G3" } else { "G2" };
                words.push_str(&self.motion_words(word, &arc.motion, plane_axes));
                for (at, letter) in ['I', 'J', 'K'].into_iter().enumerate().filter(|(at, _)| *at != axis) {
                    // Two decimals more than the end: the radius follows from the center.
                    words.push_str(&format!(" {letter}=AC({})", decimal(arc.center[at], d + 2)));
                }
            }
            None => {
                let end = arc.motion.end.xyz()?;
                if falls_together {
                    return None;
                }
                // The point half way, turned back from the end about the normal (Rodrigues, normal and radius are square).
                let out = frame::sub(end, arc.center);
                let (s, c) = (-0.5 * within).sin_cos();
                let across = frame::cross(arc.normal, out);
                let middle: [f64; 3] = std::array::from_fn(|i| arc.center[i] + c * out[i] + s * across[i]);
                words.push_str(&self.motion_words("CIP", &arc.motion, plane_axes));
                for (letter, value) in ['I', 'J', 'K'].into_iter().zip(middle) {
                    words.push_str(&format!(" {letter}1={}", decimal(value, d + 2)));
                }
            }
        }
        words.push_str(&turns);
        Some(words)
    }

    fn feed(&mut self, feed: Feed) -> Result<(), PostError> {
        let d = self.settings.feed_decimals;
        let (mode, value) = match feed {
            Feed::PerTime(v) => ("G94", format!("F{}", positive(v * 60.0, d))),
            Feed::PerRevolution(v) => ("G95", format!("F{}", positive(v, d + 3))),
            // Stands in every block with a motion.
            Feed::InverseTime(_) => ("G93", String::new()),
        };
        self.feed = Some(feed);
        let mut words = Vec::new();
        if self.feed_mode != Some(mode) {
            self.feed_mode = Some(mode);
            words.push(mode.to_owned());
        }
        if !value.is_empty() {
            words.push(value);
        }
        self.line(&words.join(" "))
    }

    fn coolant(&mut self, coolant: Coolant) -> Result<(), PostError> {
        let before = std::mem::replace(&mut self.coolant, coolant);
        let off = before.flood && !coolant.flood || before.mist && !coolant.mist;
        if off || !coolant.flood && !coolant.mist {
            self.line("M9")?;
        }
        if coolant.flood && (off || !before.flood) {
            self.line("M8")?;
        }
        if coolant.mist && (off || !before.mist) {
            self.line("M7")?;
        }
        Ok(())
    }

    fn tcp(&mut self, tcp: Tcp) -> Result<(), PostError> {
        let before = self.tcp.replace(tcp);
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

    /// TRANS, AROT, AMIRROR, ASCALE that make the transform above the work offset; none for a sheared one.
    fn frame_lines(&mut self, change: &FrameChange) -> Option<Vec<String>> {
        let total = Frame { linear: change.rotation, translation: change.translation, rotary: change.rotary };
        // A work offset only shifts, so what lies above it is the difference of the shifts.
        let above = Frame {
            linear: total.linear,
            translation: frame::sub(total.translation, self.settable.translation),
            rotary: frame::sub(total.rotary, self.settable.rotary),
        };
        if above == self.programmable {
            return Some(Vec::new());
        }
        let (angles, mirrored, factors) = decompose(&above)?;
        self.programmable = above;
        let (d, a) = (self.settings.length_decimals, self.settings.angle_decimals);
        let mut trans = format!(
            "TRANS X{} Y{} Z{}",
            decimal(above.translation[0], d),
            decimal(above.translation[1], d),
            decimal(above.translation[2], d)
        );
        for (letter, offset) in ['A', 'B', 'C'].into_iter().zip(above.rotary) {
            if offset != 0.0 {
                trans.push_str(&format!(" {letter}{}", decimal(offset.to_degrees(), a)));
            }
        }
        let mut lines = vec![trans];
        if angles != [0.0; 3] {
            // A frame turns points far from its origin: it is written finer than an axis.
            let text = angles.map(|v| decimal(v, a + 6));
            lines.push(format!("AROT X{} Y{} Z{}", text[0], text[1], text[2]));
        }
        if mirrored {
            lines.push("AMIRROR X0".to_owned());
        }
        if factors.iter().any(|f| (f - 1.0).abs() > 1e-9) {
            let text = factors.map(|v| decimal(v, 9));
            lines.push(format!("ASCALE X{} Y{} Z{}", text[0], text[1], text[2]));
        }
        Some(lines)
    }
}

/// Text between quotation marks: the mark itself cannot be written.
fn plain(text: &str) -> String {
    text.replace('"', "'").replace(['\n', '\r'], " ")
}

/// Linear part as Rz Ry Rx, a mirror of X, and scales: angles in degrees.
fn decompose(frame: &Frame) -> Option<([f64; 3], bool, [f64; 3])> {
    let m = &frame.linear;
    let column = |at: usize| [m[0][at], m[1][at], m[2][at]];
    let factors = [frame::norm(column(0)), frame::norm(column(1)), frame::norm(column(2))];
    let mirrored = frame.determinant() < 0.0;
    let mut unit = [frame::unit(column(0))?, frame::unit(column(1))?, frame::unit(column(2))?];
    if mirrored {
        unit[0] = unit[0].map(|v| -v);
    }
    let square = |a: usize, b: usize| frame::dot(unit[a], unit[b]).abs() < 1e-9;
    if !(square(0, 1) && square(0, 2) && square(1, 2)) {
        return None;
    }
    // R[i][j] is unit[j][i]; the image of e_x of Rz Ry Rx is (cz cy, sz cy, -sy).
    let r = |row: usize, at: usize| unit[at][row];
    let cy = r(0, 0).hypot(r(1, 0));
    let y = (-r(2, 0)).atan2(cy);
    let (x, z) = if cy > 1e-9 {
        (r(2, 1).atan2(r(2, 2)), r(1, 0).atan2(r(0, 0)))
    } else {
        // Y is plus or minus 90 degrees: X and Z turn about the same axis, all goes to Z.
        (0.0, (-r(0, 1)).atan2(r(1, 1)))
    };
    Some(([x, y, z].map(|v| v.to_degrees() + 0.0), mirrored, factors))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decomposition_gives_the_frame_back() {
        for angles in
            [[10.0, 20.0, 30.0], [0.0, 90.0, 40.0], [-170.0, -90.0, 12.0], [180.0, 0.0, -90.0], [0.0, -45.0, 0.0]]
        {
            for scale in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [2.0, 3.0, -4.0]] {
                let frame = Frame::rpy(angles).then(&Frame::scale(scale));
                let (angles, mirrored, factors) = decompose(&frame).unwrap();
                let mirror = Frame::scale([if mirrored { -1.0 } else { 1.0 }, 1.0, 1.0]);
                let again = Frame::rpy(angles).then(&mirror).then(&Frame::scale(factors));
                for (a, b) in again.linear.iter().flatten().zip(frame.linear.iter().flatten()) {
                    assert!((a - b).abs() < 1e-9, "{angles:?} {scale:?}");
                }
            }
        }
    }
}
