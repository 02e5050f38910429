use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::{Contact, Overcut};

/// The axis letters that a program can address, in the order of [`AxisValues`].
pub const AXIS_LETTERS: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];

/// Coordinates by axis letter; only the axes that have a value. Linear axes in mm, A B C in radian.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisValues {
    values: [f64; 9],
    set: u16,
}

impl AxisValues {
    /// No axis has a value.
    pub const NONE: Self = Self { values: [0.0; 9], set: 0 };

    /// Index of a letter in [`AXIS_LETTERS`].
    pub fn index(letter: char) -> Option<usize> {
        AXIS_LETTERS.iter().position(|&l| l == letter)
    }

    /// Value of the axis with this index, if it has one.
    pub fn get(&self, index: usize) -> Option<f64> {
        (self.set >> index & 1 == 1).then(|| self.values[index])
    }

    /// Gives the axis a value.
    pub fn put(&mut self, index: usize, value: f64) {
        self.values[index] = value;
        self.set |= 1 << index;
    }

    /// Takes the value away.
    pub fn clear(&mut self, index: usize) {
        self.values[index] = 0.0;
        self.set &= !(1 << index);
    }

    /// X, Y and Z, where all three have values.
    pub fn xyz(&self) -> Option<[f64; 3]> {
        Some([self.get(0)?, self.get(1)?, self.get(2)?])
    }

    /// Letter and value of every axis that has one, in the order of [`AXIS_LETTERS`].
    pub fn iter(&self) -> impl Iterator<Item = (char, f64)> + '_ {
        AXIS_LETTERS.iter().enumerate().filter_map(|(i, &l)| self.get(i).map(|v| (l, v)))
    }

    /// True when no axis has a value.
    pub fn is_empty(&self) -> bool {
        self.set == 0
    }
}

/// Where in the text a command comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// File as given by the caller.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Column of the first character, from 1.
    pub column: u32,
    /// Length in characters.
    pub length: u32,
    /// Nesting of subprogram calls; 0 in the main program.
    pub depth: u32,
}

impl Location {
    /// Goes on to another block; the name of the file is shared and only touched when the file changes.
    pub(crate) fn move_to(&mut self, file: &Arc<str>, line: u32, column: u32, length: u32, depth: u32) {
        if !Arc::ptr_eq(&self.file, file) {
            self.file = Arc::clone(file);
        }
        (self.line, self.column, self.length, self.depth) = (line, column, length, depth);
    }
}

/// Prefix in the text of a [`Note`] on what the reader assumes.
pub const ASSUMED: &str = "assumed: ";

/// A remark of the reader: a word without effect, or an assumption on what depends on the control or on its
/// set-up. A judgement on the program leaves an assumption open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    text: String,
    assumed: bool,
}

impl Note {
    /// A word without effect.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), assumed: false }
    }

    /// What the reader assumes; its text begins with [`ASSUMED`].
    pub fn assuming(what: impl AsRef<str>) -> Self {
        Self { text: format!("{ASSUMED}{}", what.as_ref()), assumed: true }
    }

    /// The text as it is printed.
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// What is assumed, without the prefix; none for a word without effect.
    pub fn assumption(&self) -> Option<&str> {
        self.text.get(ASSUMED.len()..).filter(|_| self.assumed)
    }
}

impl std::ops::Deref for Note {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl From<String> for Note {
    fn from(text: String) -> Self {
        Self::new(text)
    }
}

/// One canonical command.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// Its place in the program.
    pub location: Location,
    /// What to do.
    pub op: Op,
}

/// What the control is to do. Names as printed by `proveout nc`.
#[derive(Clone, Debug, PartialEq)]
pub enum Op {
    /// Motion at rapid rate.
    Rapid(Motion),
    /// Straight motion in feed.
    Linear(Motion),
    /// Circular or helical motion in feed.
    Arc(ArcMotion),
    /// Motion in feed along a cubic Bezier curve (G5, G5.1).
    Spline(SplineMotion),
    /// Straight motion until a probe switches (G38, G31): the end is the farthest point it may reach.
    Probe(ProbeMotion),
    /// Straight motion coupled to the spindle (G33, rigid tapping).
    Thread(ThreadMotion),
    /// Motion along the tool axis away from the workpiece, of which the reader does not know start or
    /// direction (M140 MB).
    Retract(Retract),
    /// Wait.
    Dwell(Dwell),
    /// Feed value in force from here.
    Feed(Feed),
    /// What the feed counts from here where rotary axes turn in feed.
    FeedCounts(FeedCounts),
    /// Spindle rotation.
    Spindle(Spindle),
    /// Tool selection or change.
    Tool(ToolAction),
    /// Working plane G17 G18 G19: the axis letter of its normal.
    Plane(char),
    /// An offset of the control taken into or out of effect.
    Offset(Offset),
    /// A new transform from work coordinates to base coordinates (frame of offsets, rotations, mirrors,
    /// scales).
    Frame(FrameChange),
    /// Tool center point control (TRAORI, G43.4, M128).
    Tcp(Tcp),
    /// How corners are treated.
    PathMode(PathMode),
    /// Cutter radius compensation in the working plane.
    CutterComp(CutterComp),
    /// What the override switches may do, or a programmed override.
    Override(Override),
    /// Coolant.
    Coolant(Coolant),
    /// Text for the operator.
    Message(String),
    /// A word that the dialect reads and that has no effect on motion, removal or time of the twin: named,
    /// not lost.
    Note(Note),
    /// A place where the compensated path of the tool center enters its own contour and the control sees no
    /// fault.
    Overcut(Overcut),
    /// Program stop (M0) or optional stop (M1).
    Stop {
        /// True for M1.
        optional: bool,
    },
    /// End of the program (M2, M30).
    End,
}

/// End of a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Programmed coordinates in the active work frame; all axes whose position is known there.
    pub end: AxisValues,
    /// The same point in base coordinates: after all offsets, frames, mirrors and scales, tool
    /// length not applied. An axis without a value keeps the position that the machine has. Where
    /// the block has X, Y or Z and none of the three has a value here, the frame in force is turned
    /// and the program has not set all it needs (first block in a tilted plane): the rest of the
    /// point comes from the position of the machine, seen in that frame.
    pub end_base: AxisValues,
    /// Programmed tool axis in the work frame, where the orientation is programmed as a vector (unit length).
    pub tool_axis: Option<[f64; 3]>,
    /// The same vector in base coordinates.
    pub tool_axis_base: Option<[f64; 3]>,
    /// Bit i is set when this block has a word of axis i of [`AXIS_LETTERS`].
    pub programmed: u16,
    /// True for SUPA, G53, M91: `end_base` is in machine coordinates of the axes, and no five-axis
    /// transformation is active for the block. The active tool length still counts but for M91 and M92; where
    /// G53, G28 or G30 leave it out, it is switched off for the block.
    pub machine_coordinates: bool,
    /// Exact stop at the end of this block only (G9).
    pub exact_stop: bool,
    /// Which of two positions of the rotary axes reaches a tool axis; without a tool axis it has no meaning.
    pub solution: RotarySolution,
}

/// Which of the two positions of the rotary axes a tool axis takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotarySolution {
    /// The one with the least turn of the rotary axes from their present positions.
    #[default]
    Nearest,
    /// The one with the lower (true: the higher) angle of the reference axis.
    Angle {
        /// The higher angle.
        higher: bool,
        /// Letter of the reference axis; none: the rotary axis nearest to the tool.
        reference: Option<char>,
        /// Where it is out of travel, the control takes the other one; false: it refuses the block.
        or_other: bool,
    },
}

/// What F counts without tool center point control in a block that turns rotary axes: the speed along the
/// vector of the axes, each with its factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedCounts {
    /// X, Y, Z: 1 where the axis counts, 0 where it only arrives at the same time.
    pub linear: [f64; 3],
    /// A, B, C: the radius at which the angle counts, mm; 0 where the axis only arrives at the same time.
    pub radius: [f64; 3],
}

impl FeedCounts {
    /// Radius at which one degree counts as one millimeter, mm.
    pub const DEGREE_IS_MM: f64 = 180.0 / std::f64::consts::PI;

    /// Linear axes alone.
    pub const LINEAR: Self = Self { linear: [1.0; 3], radius: [0.0; 3] };
}

/// Circular motion; end and orientation as in [`Motion`].
///
/// ```
/// use proveout_nc::{Op, Program, Settings};
///
/// // A quarter of a circle of 20 mm about the work zero, counter-clockwise.
/// let text = "G17 G21 G90\nG0 X20. Y0. Z0.\nG3 X0. Y20. I-20. J0. F300.\nM30\n";
/// let program = Program::from_text("arc.nc", text, &Settings::default())?;
/// let commands = program.collect::<Result<Vec<_>, _>>()?;
/// let found = commands.iter().find_map(|c| match &c.op {
///     Op::Arc(arc) => Some(arc),
///     _ => None,
/// });
/// let arc = found.expect("G3 is an arc");
/// assert_eq!(arc.normal, [0.0, 0.0, 1.0]);
/// assert!((arc.radius * arc.sweep - 10.0 * std::f64::consts::PI).abs() < 1e-9); // length, mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ArcMotion {
    /// End of the motion.
    pub motion: Motion,
    /// Center in the active work frame, mm. Along the normal of the plane it has a meaning only where the end
    /// has a value.
    pub center: [f64; 3],
    /// Center in base coordinates, mm; along the normal as above.
    pub center_base: [f64; 3],
    /// Unit normal in the work frame; the arc runs counter-clockwise about it.
    pub normal: [f64; 3],
    /// The same normal in base coordinates.
    pub normal_base: [f64; 3],
    /// Radius at the start in base coordinates, mm. The radius at the end is the same but for arcs of more
    /// than half a turn between close points, where rounding of the program leaves a difference within the
    /// tolerance of the reader.
    pub radius: f64,
    /// Angle run through, radian, above zero; over two pi for several turns.
    pub sweep: f64,
}

/// Cubic Bezier curve from the position before; end and orientation as in [`Motion`]. A quadratic one comes
/// raised to cubic, which is the same curve.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineMotion {
    /// End of the motion.
    pub motion: Motion,
    /// The two inner control points in the active work frame, mm.
    pub control: [[f64; 3]; 2],
    /// The same points in base coordinates, mm.
    pub control_base: [[f64; 3]; 2],
}

/// Motion towards a probed surface. Where no answer is known ([`crate::TouchList`]) it runs to its end, and
/// the twin says so.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeMotion {
    /// To the farthest point; where the probe has switched, to the place where it did.
    pub motion: Motion,
    /// True where the motion leaves the surface (`G38.4`, `G38.5`).
    pub away: bool,
    /// True where a miss is an error of the control (`G38.2`, `G38.4`, `G31` of most controls).
    pub must_switch: bool,
    /// What is known of its end.
    pub contact: Contact,
}

/// Motion of which the path runs in proportion to the angle of the spindle.
#[derive(Clone, Debug, PartialEq)]
pub struct ThreadMotion {
    /// End of the motion.
    pub motion: Motion,
    /// Path for each spindle revolution, mm, above zero.
    pub pitch: f64,
    /// The spindle direction during the motion, where the cycle sets it (tapping in, tapping out); none: as
    /// it runs.
    pub direction: Option<SpindleDirection>,
}

/// Retraction along the tool axis. After it the program knows no linear coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retract {
    /// Way, mm; none: to the end of the traverse of the machine.
    pub distance: Option<f64>,
    /// At rapid rate, else in feed.
    pub rapid: bool,
}

/// Wait, in one of two units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dwell {
    /// Seconds.
    Seconds(f64),
    /// Spindle revolutions.
    Revolutions(f64),
}

/// Feed, converted from the unit of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feed {
    /// mm/s along the path (G94).
    PerTime(f64),
    /// mm a spindle revolution (G95).
    PerRevolution(f64),
    /// The block takes this many seconds (G93).
    InverseTime(f64),
}

/// Spindle rotation seen from the spindle towards the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spindle {
    /// Direction.
    pub direction: SpindleDirection,
    /// Speed in 1/min; none when none was ever programmed.
    pub speed_rpm: Option<f64>,
}

/// Direction of rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpindleDirection {
    /// M5.
    Off,
    /// M3.
    Clockwise,
    /// M4.
    CounterClockwise,
}

/// Tool handling.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ToolAction {
    /// Made ready in the magazine (`T5`, `T="NAME"`).
    Select(ToolName),
    /// Changed into the spindle (M6, or T where the control changes at once).
    Change(ToolName),
}

/// Name of a tool in the program.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ToolName {
    /// `T0`: an empty spindle.
    Empty,
    /// By number.
    Number(u32),
    /// By name.
    Name(String),
}

/// Offsets of the control.
#[derive(Clone, Debug, PartialEq)]
pub enum Offset {
    /// Tool length and radius of cutting edge `edge`; 0 switches the length off (D0, G49).
    ToolEdge {
        /// D or H number.
        edge: u32,
    },
    /// Delta values of a tool call (DL, DR, DR2), added to those of the tool table, mm.
    ToolDelta {
        /// Length.
        length: f64,
        /// Radius: counts for cutter radius compensation.
        radius: f64,
        /// Corner radius.
        corner_radius: f64,
    },
    /// With tool center point control, the point that stays on the workpiece while rotary axes turn: ahead of
    /// the tip by so much, away from the holder, as if the tool were longer (PLANE with MOVE and DIST). 0:
    /// the tip.
    TurnCenter {
        /// Distance from the tip, mm.
        ahead: f64,
    },
    /// Work offset in effect, by the word of the program (`G54`, `G500`).
    Work {
        /// The word.
        word: String,
    },
}

/// The transform from work to base coordinates after a change.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameChange {
    /// The word that changed it.
    pub word: String,
    /// Rotation, row by row (3 x 3, orthonormal; a mirror has determinant -1). Under SCALE the columns have
    /// the lengths of the factors.
    pub rotation: [[f64; 3]; 3],
    /// Translation, mm.
    pub translation: [f64; 3],
    /// Offsets of rotary axes A, B, C, radian.
    pub rotary: [f64; 3],
}

/// Tool center point control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tcp {
    /// In effect from here.
    pub on: bool,
    /// How the orientation runs between two blocks.
    pub interpolation: OrientationInterpolation,
}

/// Path of the tool axis between two blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OrientationInterpolation {
    /// In the plane of the two axes (ORIVECT).
    GreatCircle,
    /// As the rotary axes run (ORIAXES).
    Axes,
}

/// Treatment of corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathMode {
    /// Stop at the end of every block (G60, G61).
    ExactStop,
    /// Corners may be rounded within this distance of the tip, mm, and angle of the tool axis, radian; none:
    /// as the machine's control is set up.
    Continuous {
        /// Tolerance of the tip, mm.
        tolerance: Option<f64>,
        /// Tolerance of the tool axis, radian.
        orientation_tolerance: Option<f64>,
    },
}

/// Cutter radius compensation (G40, G41, G42; R0, RL, RR).
///
/// The ends of motions stay as programmed unless [`crate::Settings::compensation`] asks for the path of the
/// tool center.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutterComp {
    /// On which side of the contour the tool runs, seen along the motion.
    pub side: CompSide,
    /// Number of the offset (D) where the word names one.
    pub offset: Option<u32>,
    /// Radius, mm: from the block (`G41.1 D`, macro value) or from the settings; none when neither says it.
    pub radius: Option<f64>,
}

/// Side of the contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompSide {
    /// G40: on the contour.
    Off,
    /// G41: left of it.
    Left,
    /// G42: right of it.
    Right,
}

/// Overrides of feed and spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Override {
    /// The operator may change feed and speed (M48); false fixes both at 100 percent (M49).
    pub enabled: bool,
    /// Programmed feed override, 1 for 100 percent (`OVR=50` is 0.5).
    pub feed: f64,
}

/// Coolant state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coolant {
    /// M8.
    pub flood: bool,
    /// M7.
    pub mist: bool,
}
