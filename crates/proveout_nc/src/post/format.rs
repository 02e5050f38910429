//! What all posts share: lines with numbers, numbers with decimals, frames above a work offset, points on
//! circles.

use std::f64::consts::TAU;
use std::io::Write;

use super::{EdgeNumbers, PostSettings, Unpostable, positive};
use crate::frame::{self, Frame};
use crate::{ArcMotion, Feed, FrameChange, Op, ToolName};

/// Lines of text.
#[derive(Debug)]
pub(crate) struct PostLines<W> {
    pub(crate) sink: W,
    pub(crate) settings: PostSettings,
    number: u32,
}

impl<W: Write> PostLines<W> {
    pub(crate) fn new(sink: W, settings: PostSettings) -> Self {
        Self { sink, settings, number: 0 }
    }

    /// A block, with its N word where they are wanted.
    pub(crate) fn block(&mut self, words: &str) -> Result<(), Unpostable> {
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

    /// Writes a line unchanged.
    pub(crate) fn plain(&mut self, text: &str) -> Result<(), Unpostable> {
        writeln!(self.sink, "{text}")?;
        Ok(())
    }

    pub(crate) fn footer(&mut self) -> Result<(), Unpostable> {
        for line in std::mem::take(&mut self.settings.footer) {
            self.plain(&line)?;
        }
        self.sink.flush()?;
        Ok(())
    }

    /// G93, G94 or G95 where the mode changes, and F. In G93 mode F is repeated in every block with
    /// a motion.
    pub(crate) fn feed_words(&self, feed: Feed, mode_in_force: &mut Option<&'static str>) -> String {
        let (mode, value) = match feed {
            Feed::PerTime(v) => ("G94", Some(self.feed(v * 60.0))),
            Feed::PerRevolution(v) => {
                let decimals = self.settings.feed_decimals + 3;
                ("G95", Some(self.above_zero(self.in_unit(v), decimals)))
            }
            Feed::InverseTime(_) => ("G93", None),
        };
        let mode = (mode_in_force.replace(mode) != Some(mode)).then(|| mode.to_owned());
        let words: Vec<String> = mode.into_iter().chain(value.map(|v| format!("F{v}"))).collect();
        words.join(" ")
    }

    /// Millimeters in the unit of the text.
    pub(crate) fn in_unit(&self, mm: f64) -> f64 {
        if self.settings.inches { mm / 25.4 } else { mm }
    }

    pub(crate) fn number(&self, value: f64, decimals: usize) -> String {
        let mut text = format!("{value:.decimals$}");
        if !self.settings.trailing_zeros && text.contains('.') {
            text.truncate(text.trim_end_matches('0').len());
        }
        self.finished(text)
    }

    fn finished(&self, mut text: String) -> String {
        if text.ends_with('.') && !self.settings.decimal_point {
            text.pop();
        }
        if self.settings.decimal_point && !text.contains('.') {
            text.push('.');
        }
        if text.starts_with('-') && !text.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
            text.remove(0);
        }
        text
    }

    pub(crate) fn length(&self, mm: f64) -> String {
        self.number(self.in_unit(mm), self.settings.length_decimals)
    }

    pub(crate) fn center(&self, mm: f64) -> String {
        self.number(self.in_unit(mm), self.settings.center_decimals)
    }

    pub(crate) fn angle(&self, radian: f64) -> String {
        self.number(radian.to_degrees(), self.settings.angle_decimals)
    }

    /// Value of an axis by its index.
    pub(crate) fn axis(&self, axis: usize, value: f64) -> String {
        if (3..6).contains(&axis) { self.angle(value) } else { self.length(value) }
    }

    pub(crate) fn vector(&self, component: f64) -> String {
        self.number(component, self.settings.vector_decimals)
    }

    /// A value above zero never becomes zero.
    pub(crate) fn above_zero(&self, value: f64, decimals: usize) -> String {
        self.finished(positive(value, decimals))
    }

    pub(crate) fn feed(&self, mm: f64) -> String {
        self.above_zero(self.in_unit(mm), self.settings.feed_decimals)
    }

    /// The number that calls the length of a tool; 0 stays 0.
    pub(crate) fn edge(&self, edge: u32, tool: Option<&ToolName>) -> u32 {
        match (self.settings.edge_numbers, tool) {
            _ if edge == 0 => 0,
            (EdgeNumbers::Tool, Some(ToolName::Number(number))) => *number,
            (EdgeNumbers::One, _) => 1,
            _ => edge,
        }
    }
}

/// Whole number, or with up to three decimals: speeds.
pub(crate) fn speed(value: f64) -> String {
    super::decimal(value, 3)
}

/// Work offset in effect, and the frame of the commands above it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PostFrames {
    pub(crate) settable: Frame,
    /// From work coordinates of the commands to the coordinates of the work offset.
    pub(crate) above: Frame,
    /// A work offset has been called.
    called: bool,
}

impl PostFrames {
    pub(crate) fn new() -> Self {
        Self { settable: Frame::IDENTITY, above: Frame::IDENTITY, called: false }
    }

    /// A motion of a program that has called no work offset: the control has one in force from the start, so
    /// its values must be zero. 840D programs can do without any, and a TNC has row 0 of its presets.
    pub(crate) fn before_motion(&mut self, op: &Op, settings: &PostSettings, word: &str) -> Result<(), Unpostable> {
        let motion = match op {
            _ if self.called => return Ok(()),
            Op::Rapid(motion) | Op::Linear(motion) => motion,
            Op::Arc(arc) => &arc.motion,
            Op::Spline(spline) => &spline.motion,
            Op::Probe(probe) => &probe.motion,
            Op::Thread(thread) => &thread.motion,
            _ => return Ok(()),
        };
        let zero = settings.work_offsets.get(word).is_none_or(|o| o.translation == [0.0; 3] && o.rotary == [0.0; 3]);
        if motion.machine_coordinates || zero {
            return Ok(());
        }
        Err(Unpostable::new(
            format!("coordinates without a work offset: {word} is in force from the start, and not zero"),
            "call the work offset in the program, G54",
        ))
    }

    pub(crate) fn offset(&mut self, word: &str, settings: &PostSettings) {
        self.called = true;
        let values = settings.work_offsets.get(word).copied().unwrap_or_default();
        self.settable = Frame { rotary: values.rotary, ..Frame::translation(values.translation) };
    }

    pub(crate) fn change(&mut self, change: &FrameChange) {
        // A work offset only shifts, so what lies above it is the difference of the shifts.
        self.above = Frame {
            linear: change.rotation,
            translation: frame::sub(change.translation, self.settable.translation),
            rotary: frame::sub(change.rotary, self.settable.rotary),
        };
    }

    /// The new z leaves the z of the work offset.
    pub(crate) fn is_tilted(&self) -> bool {
        let m = &self.above.linear;
        let off = [m[0][2], m[1][2], m[2][0], m[2][1]];
        off.iter().any(|v| v.abs() > TILTED)
    }

    /// A pure rotation.
    pub(crate) fn is_rotation(&self) -> bool {
        self.above.determinant() > 0.0
            && self.above.uniform_scale().is_some_and(|s| (s - 1.0).abs() < frame::UNIT_SCALE)
    }
}

/// An arc that falls onto one point when it is written: shorter than the last decimal.
pub(crate) fn full_turns(arc: &ArcMotion) -> u32 {
    // Rounding of the angle must not make a full circle one turn and nothing.
    ((arc.sweep / TAU - TURNS).ceil() - 1.0).clamp(0.0, MOST_TURNS) as u32
}

/// The radius with its sign (negative beyond a half turn), where an arc is well said by it: near a half turn
/// and a full one the center would follow from it only roughly.
pub(crate) fn radius_word(arc: &ArcMotion, settings: &PostSettings) -> Option<f64> {
    const CLEAR_OF: f64 = 0.35;
    let half = TAU / 2.0;
    let well = (arc.sweep - half).abs() > CLEAR_OF && arc.sweep < TAU - CLEAR_OF;
    (settings.arc_radius && well).then(|| if arc.sweep > half { -arc.radius } else { arc.radius })
}

/// Largest difference of the radii at start and end of an arc that every reader takes, mm.
const RADII_MM: f64 = 0.009;
/// Component of the new z across that of the work offset above which the plane is tilted.
const TILTED: f64 = 1e-9;
/// Rounding of the turns of an arc.
const TURNS: f64 = 1e-9;
/// Most full turns of an arc.
const MOST_TURNS: f64 = 1e6;
/// Cosine of a middle angle below which the outer two turn about the same axis.
pub(super) const LEAST_COSINE: f64 = 1e-9;

/// The words of an arc, rounded as they are written, give radii that a control refuses.
pub(crate) fn radii_apart(start: [f64; 2], end: [f64; 2], center: [f64; 2]) -> bool {
    let radius = |p: [f64; 2]| (p[0] - center[0]).hypot(p[1] - center[1]);
    (radius(start) - radius(end)).abs() > RADII_MM
}

/// The arc leaves its chord by less than anything that is written.
pub(crate) fn is_flat(start: [f64; 2], end: [f64; 2], arc: &ArcMotion) -> bool {
    let chord = (end[0] - start[0]).hypot(end[1] - start[1]);
    arc.sweep < TAU / 2.0 && chord * chord < 8.0 * arc.radius * super::verify::FLAT_MM
}

/// The point nearest to a center that has the same distance from start and end.
pub(crate) fn between(start: [f64; 2], end: [f64; 2], center: [f64; 2]) -> [f64; 2] {
    let chord = [end[0] - start[0], end[1] - start[1]];
    let length = chord[0] * chord[0] + chord[1] * chord[1];
    if length <= 0.0 {
        return center;
    }
    let middle = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
    let along = ((center[0] - middle[0]) * chord[0] + (center[1] - middle[1]) * chord[1]) / length;
    [center[0] - along * chord[0], center[1] - along * chord[1]]
}

/// Coordinate axis along a direction, and its sign.
pub(crate) fn along_axis(direction: [f64; 3]) -> Option<(usize, f64)> {
    let axis = direction.iter().position(|v| v.abs() > frame::SAME_DIRECTION)?;
    Some((axis, direction[axis].signum()))
}

/// The number of a work offset, counted from 1 on every control: G54 to G59 are 1 to 6, `G54.1 P1` is 7
/// (G59.1 of `LinuxCNC` and `G154 P1` of a Haas too), G505 of an 840D is 5, row 1 of a preset table is 1.
pub(crate) fn offset_number(word: &str) -> Option<u32> {
    let number = |text: &str| text.parse::<u32>().ok();
    if let Some(row) = word.strip_prefix("PRESET") {
        return number(row).filter(|n| *n > 0);
    }
    let pages = ["G54.1 P", "G54.1P", "G154 P", "G154P"];
    if let Some(more) = pages.iter().find_map(|page| word.strip_prefix(page)) {
        return number(more).map(|n| n + 6);
    }
    if let Some(more) = word.strip_prefix("G59.") {
        return number(more).filter(|n| matches!(n, 1..=3)).map(|n| n + 6);
    }
    match number(word.strip_prefix('G')?)? {
        code @ 54..=59 => Some(code - 53),
        code @ 505..=599 => Some(code - 500),
        _ => None,
    }
}

/// Text without line ends and without the characters that end a comment.
pub(crate) fn one_line(text: &str, without: &[char]) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).filter(|c| !without.contains(c)).collect()
}
