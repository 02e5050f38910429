//! What a control says, parents included.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use super::parameters::Parameters;
use super::words::WordTable;
use crate::settings::{Dialect, Limits};
use crate::{AxisValues, OrientationInterpolation};

/// How numbers without a decimal point are read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WholeNumbers {
    /// As millimeters, inches and degrees, with a note: nothing says how the control reads them.
    #[default]
    Assumed,
    /// The same with the finding `program-assumed`: a setting of the machine decides.
    Told,
    /// As millimeters, inches and degrees ("calculator type").
    Units,
    /// As least increments.
    Increments {
        /// Millimeters of one increment.
        mm: f64,
        /// Inches of one increment.
        inch: f64,
        /// Degrees of one increment.
        deg: f64,
    },
    /// Not at all: the control may read them one way or the other.
    Refused,
}

impl WholeNumbers {
    /// Increment system IS-B: 0.001 mm, 0.0001 inch, 0.001 degrees.
    pub const IS_B: Self = Self::Increments { mm: 1e-3, inch: 1e-4, deg: 1e-3 };
}

/// How far the radius at the end of an arc may be from that at its start.
///
/// A difference is taken up to `absolute_mm`, and up to `largest_mm` where it is not more than `relative` of
/// the larger radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcTolerance {
    /// Difference that is always taken, mm.
    pub absolute_mm: f64,
    /// Part of the radius that is taken beyond it.
    pub relative: f64,
    /// Largest difference that the part may come to, mm.
    pub largest_mm: f64,
}

impl ArcTolerance {
    /// A difference of lengths alone.
    pub const fn absolute(mm: f64) -> Self {
        Self { absolute_mm: mm, relative: 0.0, largest_mm: mm }
    }

    /// Largest difference of the radii of an arc whose larger radius is this, mm.
    pub(crate) fn of(self, radius: f64) -> f64 {
        self.absolute_mm.max((self.relative * radius).min(self.largest_mm))
    }
}

/// What I, J and K of an arc are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Centers {
    /// From the start to the center, with sign.
    #[default]
    Incremental,
    /// Coordinates of the center.
    Absolute,
    /// Distances without sign, within a quadrant.
    Unsigned,
}

/// What the word of a dwell counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
pub(crate) enum DwellUnit {
    /// Seconds.
    #[serde(rename = "s")]
    Seconds,
    /// Milliseconds.
    #[serde(rename = "ms")]
    Milliseconds,
    /// Milliseconds; with a decimal point seconds.
    #[serde(rename = "ms-or-s")]
    MillisecondsOrSeconds,
    /// Hundredths of a second.
    #[serde(rename = "hundredths")]
    Hundredths,
}

impl DwellUnit {
    pub(crate) fn seconds(self, value: f64, point: bool) -> f64 {
        match self {
            Self::Seconds => value,
            Self::MillisecondsOrSeconds if point => value,
            Self::Milliseconds | Self::MillisecondsOrSeconds => value / 1000.0,
            Self::Hundredths => value / 100.0,
        }
    }
}

/// What G76 does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum FineBoring {
    /// Fine boring; the shift off the wall (Q, or I and J) must be written.
    #[default]
    NeedsShift,
    /// Fine boring; without a shift the tool goes back through the middle.
    ShiftMayBeLeftOut,
    /// Another cycle, which the twin does not do: refused.
    #[serde(rename = "refuse")]
    Refused,
}

/// Motion of a block with axis words alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum StartMotion {
    /// None: such a block is refused before the first motion word.
    None,
    /// G0
    Rapid,
    /// G1
    Linear,
}

/// What F counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum StartFeed {
    /// G94
    PerMinute,
    /// G95
    PerRevolution,
    /// G93
    InverseTime,
}

/// What is in force before the first word; none where the control says nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Start {
    /// Index of the axis normal to the working plane.
    pub(crate) normal: Option<usize>,
    pub(crate) inch: Option<bool>,
    pub(crate) incremental: Option<bool>,
    pub(crate) feed: Option<StartFeed>,
    pub(crate) motion: Option<StartMotion>,
}

/// A control: what its file and the files that it inherits from say.
///
/// The default says nothing: programs are read as the reader of their language does alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Name for messages; empty for the control that says nothing.
    pub(crate) name: String,
    /// Language of its programs.
    pub(crate) dialect: Dialect,
    pub(crate) words: WordTable,
    /// M words that neither the reader nor the table knows are refused.
    pub(crate) refuses_unlisted: bool,
    pub(crate) start: Start,
    /// Positions of the axes at the start, coordinates of the work offset that is then in force;
    /// mm, radian.
    pub(crate) position: AxisValues,
    pub(crate) parameters: Parameters,
    pub(crate) whole_numbers: WholeNumbers,
    pub(crate) arc_tolerance: Option<ArcTolerance>,
    pub(crate) centers: Centers,
    /// CIRCLE of CL data runs clockwise about its normal; none: as its writer and the tangents say.
    pub(crate) clockwise_circles: Option<bool>,
    pub(crate) fine_boring: FineBoring,
    /// G71 and M53, M54 say where cycles come back to, and not G98 and G99.
    pub(crate) stated_returns: bool,
    /// I is the depth of a cycle, Z the plane above the hole, K the dwell: a Fagor, whose other words come
    /// with it.
    pub(crate) depth_in_i: bool,
    /// Words of Okuma OSP are read: VC variables, CALL, RTS, NCYL.
    pub(crate) osp_words: bool,
    /// #4012 is the work offset and #4014 the modal macro call.
    pub(crate) mitsubishi_variables: bool,
    /// Lines that begin with `$` are read.
    pub(crate) grbl_words: bool,
    /// The control has the language of a LinuxCNC, but does not refuse what its interpreter
    /// refuses.
    pub(crate) mach3_words: bool,
    /// G43 without H takes the length of the tool in the spindle.
    pub(crate) length_of_tool: bool,
    /// Where M6 leaves the axes, machine coordinates, mm.
    pub(crate) tool_change: AxisValues,
    /// By the letter of the word, A to Z.
    pub(crate) dwell: [Option<DwellUnit>; 26],
    /// Feed of a motion before the first F, mm/min; none: refused.
    pub(crate) missing_feed_mm_min: Option<f64>,
    /// F from which on a motion is a rapid one, mm/min.
    pub(crate) rapid_from_mm_min: Option<f64>,
    pub(crate) orientation: OrientationInterpolation,
    pub(crate) skipped_levels: u16,
    /// The file states the levels.
    pub(crate) skip_stated: bool,
    pub(crate) variables: BTreeMap<String, f64>,
    pub(crate) folders: Vec<PathBuf>,
    /// Files that it was read from, built-in ones left out, the control itself first.
    pub(crate) files: Vec<PathBuf>,
    /// Why a subprogram that is missing may be left out; none: it is refused.
    pub(crate) missing_subprogram: Option<String>,
    pub(crate) limits: Limits,
    /// The end of the text ends the program too.
    pub(crate) ends_with_text: bool,
    /// Statements that nobody has confirmed: path of the key, and why it is likely.
    pub(crate) assumed: BTreeMap<String, String>,
    /// Patterns of lines before and after the program.
    pub(crate) header: Vec<String>,
    pub(crate) trailer: Vec<String>,
}

impl Default for Control {
    fn default() -> Self {
        Self {
            name: String::new(),
            dialect: Dialect::Auto,
            words: WordTable::default(),
            refuses_unlisted: false,
            start: Start::default(),
            position: AxisValues::NONE,
            parameters: Parameters::default(),
            whole_numbers: WholeNumbers::Assumed,
            arc_tolerance: None,
            centers: Centers::Incremental,
            clockwise_circles: None,
            fine_boring: FineBoring::NeedsShift,
            stated_returns: false,
            depth_in_i: false,
            osp_words: false,
            mitsubishi_variables: false,
            grbl_words: false,
            mach3_words: false,
            length_of_tool: false,
            tool_change: AxisValues::NONE,
            dwell: [None; 26],
            missing_feed_mm_min: None,
            rapid_from_mm_min: None,
            orientation: OrientationInterpolation::GreatCircle,
            skipped_levels: 0,
            skip_stated: false,
            variables: BTreeMap::new(),
            folders: Vec::new(),
            files: Vec::new(),
            missing_subprogram: None,
            limits: Limits::default(),
            ends_with_text: false,
            assumed: BTreeMap::new(),
            header: Vec::new(),
            trailer: Vec::new(),
        }
    }
}

impl Control {
    /// Name of the control; empty for the one that says nothing.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Language of its programs; [`Dialect::Auto`] for the control that says nothing.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// Nothing says which control it is: programs are read as their text tells.
    pub fn is_open(&self) -> bool {
        matches!(self.dialect, Dialect::Auto | Dialect::Iso)
    }

    /// Whether lengths count in inches before the first word for the unit, as far as the control says.
    pub fn starts_in_inch(&self) -> Option<bool> {
        self.start.inch
    }

    /// Statements of its files that nobody has confirmed: the path of each key, and why it is likely.
    pub fn assumed(&self) -> &BTreeMap<String, String> {
        &self.assumed
    }

    /// Files that it was read from, the control itself first; built-in ones are none.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Unit of the word of a dwell, where the control states one.
    pub(crate) fn dwell_unit(&self, letter: u8) -> Option<DwellUnit> {
        self.dwell.get(usize::from(letter.wrapping_sub(b'A'))).copied().flatten()
    }
}

impl std::fmt::Display for ArcTolerance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.absolute_mm)?;
        if self.relative > 0.0 {
            write!(f, " mm, or {} percent of the radius", 100.0 * self.relative)?;
            if self.largest_mm.is_finite() {
                write!(f, " up to {}", self.largest_mm)?;
            }
        }
        Ok(())
    }
}
