//! What the reader must know besides the text.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::control::{ArcTolerance, CompensatedPath, Control, WholeNumbers};
use crate::{AxisValues, Kinematics, OptionalStop, OrientationInterpolation, ReferencePoints, ToolName, TouchList};

/// A language.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Dialect {
    /// Detected from the ending of the file name and from the text.
    #[default]
    #[serde(skip)]
    Auto,
    /// Siemens Sinumerik 840D sl.
    #[serde(rename = "siemens-840d")]
    Siemens840d,
    /// ISO 6983 / RS274; the control is detected from the text, Fanuc where the text does not say.
    Iso,
    /// ISO with macro B, as a Fanuc and many others speak it.
    Fanuc,
    /// ISO of a Haas.
    Haas,
    /// RS274/NGC of `LinuxCNC`.
    #[serde(rename = "linuxcnc")]
    LinuxCnc,
    /// Heidenhain Klartext.
    Heidenhain,
    /// Heidenhain DIN/ISO.
    HeidenhainIso,
    /// APT cutter location data.
    Apt,
}

impl Dialect {
    /// Every dialect with its name on the command line and in scenes.
    pub const NAMES: [(&'static str, Self); 8] = [
        ("siemens-840d", Self::Siemens840d),
        ("iso", Self::Iso),
        ("fanuc", Self::Fanuc),
        ("haas", Self::Haas),
        ("linuxcnc", Self::LinuxCnc),
        ("heidenhain", Self::Heidenhain),
        ("heidenhain-iso", Self::HeidenhainIso),
        ("apt", Self::Apt),
    ];

    /// The dialect of this name; `auto` and the usual short forms are taken too.
    pub fn from_name(name: &str) -> Option<Self> {
        let name = name.trim().to_ascii_lowercase().replace('_', "-");
        let found = Self::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, dialect)| dialect);
        found.or(match name.as_str() {
            "auto" => Some(Self::Auto),
            "siemens" | "840d" | "sinumerik" | "siemens-840d-sl" => Some(Self::Siemens840d),
            "rs274" | "rs274ngc" | "rs274/ngc" | "ngc" | "emc" => Some(Self::LinuxCnc),
            "gcode" | "g-code" | "din" | "din66025" => Some(Self::Iso),
            "klartext" | "tnc" | "heidenhain-klartext" | "itnc" => Some(Self::Heidenhain),
            "heidenhain-din" => Some(Self::HeidenhainIso),
            "cl" | "apt-cl" | "cls" => Some(Self::Apt),
            _ => None,
        })
    }

    /// The language, whichever control speaks it: ISO for Fanuc, Haas and `LinuxCNC`, Heidenhain for both
    /// forms of it.
    pub fn family(self) -> Self {
        match self {
            Self::Fanuc | Self::Haas | Self::LinuxCnc => Self::Iso,
            Self::HeidenhainIso => Self::Heidenhain,
            other => other,
        }
    }

    /// Name of the dialect; `auto` for [`Dialect::Auto`].
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, dialect)| *dialect == self).map_or("auto", |(name, _)| name)
    }
}

/// What is done with cutter radius compensation.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Compensation {
    /// Motions stay as programmed; [`crate::Op::CutterComp`] says that the control would offset them.
    #[default]
    Programmed,
    /// `end_base` and centers of motions are those of the tool center; a radius that is not known is an
    /// error.
    ToolCenter(ToolRadii),
}

/// Radii that the control has in its tool table, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolRadii {
    /// By the number of a radius offset (D of an ISO control).
    pub by_offset: BTreeMap<u32, f64>,
    /// By the tool in the spindle; used where the program names no offset, or one that is not in `by_offset`.
    pub by_tool: BTreeMap<ToolName, f64>,
    /// The programmed contour is the path of the tool center, and offsets hold the wear alone: one that is
    /// not in `by_offset` is zero.
    pub wear: bool,
    /// An offset has the number of its tool: one that is neither in `by_offset` nor that of the tool in the
    /// spindle is not known.
    pub offset_is_tool: bool,
}

/// Values of one work offset.
///
/// ```
/// use proveout_nc::{Op, Program, Settings, WorkOffset};
///
/// let mut settings = Settings::default();
/// let offset = WorkOffset { translation: [100.0, 50.0, 20.0], ..WorkOffset::default() }; // mm
/// settings.work_offsets.insert("G54".to_owned(), offset);
/// let program = Program::from_text("part.nc", "G21 G54\nG0 X10. Y0. Z5.\nM30\n", &settings)?;
/// let commands = program.collect::<Result<Vec<_>, _>>()?;
/// let found = commands.iter().find_map(|c| match &c.op {
///     Op::Rapid(motion) => Some(motion),
///     _ => None,
/// });
/// let motion = found.expect("G0 moves");
/// assert_eq!(motion.end.xyz(), Some([10.0, 0.0, 5.0]));
/// assert_eq!(motion.end_base.xyz(), Some([110.0, 50.0, 25.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorkOffset {
    /// Offset of X, Y, Z in base coordinates, mm.
    pub translation: [f64; 3],
    /// Offset of the rotary axes A, B, C, radian.
    pub rotary: [f64; 3],
}

/// What stops a program that never ends by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Subprogram calls within each other.
    pub max_call_depth: u32,
    /// Jumps back to an earlier block (loop passes, GOTOB, REPEAT) in the whole run.
    pub max_loop_passes: u64,
    /// Jumps back without any motion between them.
    pub max_idle_passes: u64,
    /// Blocks executed in the whole run, those of loops and subprograms each time.
    pub max_blocks: u64,
    /// Elements of all arrays of a program together.
    pub max_array_elements: usize,
}

impl Default for Limits {
    /// 32 calls deep (an 840D allows 16), two million passes, one million of them without motion, ten million
    /// blocks, a million elements. The longest programs of finishing cuts have some five million blocks.
    fn default() -> Self {
        Self {
            max_call_depth: 32,
            max_loop_passes: 2_000_000,
            max_idle_passes: 1_000_000,
            max_blocks: 10_000_000,
            max_array_elements: 1_000_000,
        }
    }
}

/// Settings of a reader.
///
/// [`Settings::of_control`] takes from a control what it states; the caller may then change single
/// settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Language of the program.
    pub dialect: Dialect,
    /// What words mean on the control, and what is in force at the start.
    pub control: Arc<Control>,
    /// Work offsets by the word that calls them (`G54`, `G505`). An offset that is not named here is zero.
    pub work_offsets: BTreeMap<String, WorkOffset>,
    /// Values of variables that the program reads and does not set itself: `R5`, names of global user data.
    pub variables: BTreeMap<String, f64>,
    /// Folders searched for subprograms after the folder of the program.
    pub subprogram_folders: Vec<PathBuf>,
    /// Levels 0 to 9 of blocks with `/` that are skipped: bit i for level i.
    pub skipped_levels: u16,
    /// The skipped levels are stated; otherwise a block with `/` is run and the program is
    /// `assumed` to have the switch off.
    pub skip_stated: bool,
    /// How the switch of the optional stop (M1) is set.
    pub optional_stop: OptionalStop,
    /// Largest difference between the radius at the start and at the end of an arc. None: 0.01 mm
    /// (as `MD21000` of an 840D), on a `LinuxCNC` the tolerance of its interpreter.
    pub arc_tolerance: Option<ArcTolerance>,
    /// How a Fanuc and a Haas read numbers without a decimal point.
    pub whole_numbers: WholeNumbers,
    /// Where the axes are before the first block: coordinates of the work offset that is then in
    /// force, mm and radian.
    pub start_position: AxisValues,
    /// Feed of motions before the program gives one, mm/min; where it is used the program is `assumed` to run
    /// at it. None: such motions are refused, in CL data (APT) they come without a feed and with a note.
    pub default_feed_mm_per_min: Option<f64>,
    /// Path of the orientation before the program says otherwise.
    pub orientation_interpolation: OrientationInterpolation,
    /// Cutter radius compensation.
    pub compensation: Compensation,
    /// Reference points of the machine that runs the program. None where only the text is looked
    /// at: G28 and G30 then end at machine zero, with a note. With them an axis whose point is not
    /// stated is refused.
    pub reference_points: Option<ReferencePoints>,
    /// Kinematics that the machine's control has. None where that is not known: every one is taken.
    pub kinematics: Option<Kinematics>,
    /// Why a call of a subprogram that is not there is left out; what it does is then not proven. None: it is
    /// refused.
    pub missing_subprogram: Option<String>,
    /// What the probing motions find, in their order: the run stops at the first one without an answer. None:
    /// they run to their ends, and what they find is not known.
    pub touches: Option<TouchList>,
    /// Limits of loops, calls and memory.
    pub limits: Limits,
}

impl Default for Settings {
    /// No control, no offsets, no block skipped, tool axis on the great circle.
    fn default() -> Self {
        Self::of_control(Arc::new(Control::default()))
    }
}

impl Settings {
    /// Largest difference of the radii of an arc where the language has no rule of its own.
    pub(crate) fn arc_limit(&self) -> ArcTolerance {
        self.arc_tolerance.unwrap_or(ArcTolerance::absolute(0.01))
    }

    /// The same with the radius offsets from the memory of the control; none where there is nothing
    /// to add.
    pub(crate) fn with_radius_offsets(&self) -> Option<Self> {
        let offsets = &self.control.parameters.radius_offsets;
        let wear = self.control.parameters.compensation == Some(CompensatedPath::Wear);
        if offsets.is_empty() && !wear || !matches!(self.compensation, Compensation::ToolCenter(_)) {
            return None;
        }
        let mut settings = self.clone();
        if let Compensation::ToolCenter(radii) = &mut settings.compensation {
            radii.wear |= wear;
            for (&offset, &radius) in offsets {
                radii.by_offset.entry(offset).or_insert(radius);
            }
        }
        Some(settings)
    }

    /// Settings as a control states them, without work offsets, tools and machine.
    pub fn of_control(control: Arc<Control>) -> Self {
        Self {
            dialect: control.dialect,
            work_offsets: BTreeMap::new(),
            variables: control.variables.clone(),
            subprogram_folders: control.folders.clone(),
            skipped_levels: control.skipped_levels,
            skip_stated: control.skip_stated,
            optional_stop: OptionalStop::Unknown,
            arc_tolerance: control.arc_tolerance,
            whole_numbers: control.whole_numbers,
            start_position: control.position,
            default_feed_mm_per_min: control.missing_feed_mm_min,
            orientation_interpolation: control.orientation,
            missing_subprogram: control.missing_subprogram.clone(),
            limits: control.limits,
            control,
            compensation: Compensation::Programmed,
            reference_points: None,
            kinematics: None,
            touches: None,
        }
    }
}
