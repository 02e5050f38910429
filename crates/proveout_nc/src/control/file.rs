//! The text of a control file as types, and its schema.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::model::{Centers, DwellUnit, FineBoring, StartFeed, StartMotion};
use super::parameters::ParametersFile;
use crate::{OrientationInterpolation, settings::Dialect};

/// A control: what its programs mean beyond the standard of their language.
///
/// Keys that are left out are taken from the parent, and where no parent says them the reader of the language
/// decides alone.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ControlFile {
    /// Name for messages; when left out, that of the file.
    pub(crate) name: Option<String>,
    /// Control that this one differs from: the name of a built-in one, or the path of a file
    /// (relative to this one, ending .toml).
    pub(crate) inherits: Option<String>,
    /// Language of the programs; needed where no parent names it.
    pub(crate) dialect: Option<Dialect>,
    /// What is in force before the first word of the program.
    #[serde(default)]
    pub(crate) start: StartFile,
    /// What parameters and machine data of the control decide.
    #[serde(default)]
    pub(crate) parameters: ParametersFile,
    /// How numbers are read.
    #[serde(default)]
    pub(crate) numbers: NumbersFile,
    /// How arcs are read.
    #[serde(default)]
    pub(crate) arcs: ArcsFile,
    /// How drilling cycles are read.
    #[serde(default)]
    pub(crate) cycles: CyclesFile,
    /// What a tool change does besides.
    #[serde(default)]
    pub(crate) tool_change: ToolChangeFile,
    /// Tool length.
    #[serde(default)]
    pub(crate) tool_length: ToolLengthFile,
    /// What the words of a dwell count, by their letter: G4 P500, and P in drilling cycles.
    #[serde(default)]
    pub(crate) dwell: BTreeMap<String, DwellUnit>,
    /// Feed.
    #[serde(default)]
    pub(crate) feed: FeedFile,
    /// Tool orientation.
    #[serde(default)]
    pub(crate) orientation: OrientationFile,
    /// Blocks with a slash.
    #[serde(default)]
    pub(crate) blocks: BlocksFile,
    /// Values of variables that programs read and do not set themselves, system variables included: `#500`,
    /// `R5`, `$MC_X`, `Q10`, and "ID270 NR1 IDX1" for FN 18: SYSREAD.
    #[serde(default)]
    pub(crate) variables: BTreeMap<String, f64>,
    /// Subprograms.
    #[serde(default)]
    pub(crate) subprograms: SubprogramsFile,
    /// Lines around a program.
    #[serde(default)]
    pub(crate) program: ProgramFile,
    /// What stops a program that never ends by itself.
    #[serde(default)]
    pub(crate) limits: LimitsFile,
    /// M words that neither the language nor this file knows.
    #[serde(default)]
    pub(crate) unlisted: UnlistedFile,
    /// Meaning of words: M25, G70, G38.2; for a Sinumerik names of functions and cycles too, for APT the
    /// major words.
    #[serde(default)]
    pub(crate) words: BTreeMap<String, WordFile>,
    /// Where the statements of this file come from: the path of a key ("start.plane", "words.M25", "start"
    /// for a table, "*" for all others) and the source.
    #[serde(default)]
    pub(crate) source: BTreeMap<String, String>,
    /// Statements of this file that nobody has confirmed, by the path of their key as in `source`, and why
    /// each is likely. While one is listed, every program of the control is `program-assumed`.
    #[serde(default)]
    pub(crate) assumed: BTreeMap<String, String>,
}

/// What is in force before the first word of the program.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StartFile {
    /// Working plane.
    pub(crate) plane: Option<PlaneFile>,
    /// Unit of length.
    pub(crate) unit: Option<UnitFile>,
    /// Coordinates.
    pub(crate) distance: Option<DistanceFile>,
    /// What F counts.
    pub(crate) feed: Option<StartFeed>,
    /// Motion of a block with axis words alone.
    pub(crate) motion: Option<StartMotion>,
    /// Positions of linear axes at the start, by their letter: coordinates of the work offset that
    /// is in force at the start.
    #[serde(default)]
    pub(crate) position_mm: BTreeMap<String, f64>,
    /// Positions of rotary axes at the start, by their letter.
    #[serde(default)]
    pub(crate) position_deg: BTreeMap<String, f64>,
}

/// A working plane.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
pub(crate) enum PlaneFile {
    /// G17
    XY,
    /// G18
    ZX,
    /// G19
    YZ,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum UnitFile {
    /// Millimeters.
    Mm,
    /// Inches.
    Inch,
}

/// How coordinates count.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum DistanceFile {
    /// G90
    Absolute,
    /// G91
    Incremental,
}

/// How numbers are read.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NumbersFile {
    /// Numbers of axes and arcs without a decimal point.
    pub(crate) without_point: Option<WithoutPointFile>,
    /// Least increment of lengths where the unit is mm; 0.001 when left out.
    pub(crate) increment_mm: Option<f64>,
    /// Least increment of lengths where the unit is inch; 0.0001 when left out.
    pub(crate) increment_inch: Option<f64>,
    /// Least increment of rotary axes; 0.001 when left out.
    pub(crate) increment_deg: Option<f64>,
}

/// Numbers without a decimal point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum WithoutPointFile {
    /// X10 is 10 mm, inches or degrees.
    Units,
    /// X10 is ten least increments.
    Increments,
    /// X10 is 10 mm, inches or degrees, and the finding program-assumed says so: a setting of the machine
    /// decides.
    Assume,
    /// X10 is refused, X0 is not.
    Refuse,
}

/// How arcs are read.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ArcsFile {
    /// Difference of the radii at start and end that is always taken.
    pub(crate) tolerance_mm: Option<f64>,
    /// Part of the radius that is taken beyond it.
    pub(crate) tolerance_ratio: Option<f64>,
    /// Most that the part may come to.
    pub(crate) largest_difference_mm: Option<f64>,
    /// What I, J and K are.
    pub(crate) centers: Option<Centers>,
    /// How CIRCLE of CL data runs about its axis; left out: as the system that wrote it and the tangents of
    /// the path say.
    pub(crate) clsf_sense: Option<SenseFile>,
}

/// How a circle of CL data runs about its axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SenseFile {
    /// Clockwise, seen against the axis: NX.
    Clockwise,
    /// Counter-clockwise, the right hand rule: Creo.
    CounterClockwise,
}

/// How drilling cycles are read.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CyclesFile {
    /// G76.
    pub(crate) g76: Option<FineBoring>,
    /// What says where cycles come back to.
    pub(crate) returns: Option<CycleReturnFile>,
    /// The word with the depth.
    pub(crate) depth: Option<CycleDepthFile>,
}

/// The word with the depth of a cycle.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
pub(crate) enum CycleDepthFile {
    /// Z is the depth and R the plane above the hole.
    Z,
    /// I is the depth, Z the plane above the hole and K the dwell (Fagor).
    I,
}

/// What says where cycles come back to.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum CycleReturnFile {
    /// G98: the initial level; G99: the R plane.
    G98,
    /// G71 Z sets a level; M53 comes back to it, M54 to the R plane; G80 stops the spindle too (Okuma OSP).
    M53,
}

/// Tool length.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToolLengthFile {
    /// G43 without H.
    pub(crate) without_h: Option<WithoutHFile>,
}

/// G43 without H.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum WithoutHFile {
    /// It is refused where no H is in force.
    Refuse,
    /// It takes the length of the tool in the spindle.
    Tool,
}

/// What a tool change does besides.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToolChangeFile {
    /// Where M6 leaves linear axes, by their letter: machine coordinates. After M6 they go there at
    /// rapid rate.
    #[serde(default)]
    pub(crate) position_mm: BTreeMap<String, f64>,
}

/// Feed.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FeedFile {
    /// A motion in feed before the first F.
    pub(crate) missing: Option<MissingFeedFile>,
    /// With missing = "value": the feed that is taken, reported as an assumption.
    pub(crate) missing_mm_min: Option<f64>,
    /// F of this number and above is rapid traverse, as on older controls whose programs have F9999 or F15999
    /// for it.
    pub(crate) rapid_from_mm_min: Option<f64>,
}

/// A motion in feed before the first F.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum MissingFeedFile {
    /// It is refused.
    Refuse,
    /// It runs at `missing_mm_min`.
    Value,
}

/// Tool orientation.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OrientationFile {
    /// Path of the tool axis between two blocks before the program says otherwise.
    pub(crate) interpolation: Option<OrientationInterpolation>,
}

/// Blocks with a slash.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BlocksFile {
    /// Levels of blocks that are skipped: 0 for a slash alone, 1 to 9 for one with this number.
    pub(crate) skipped_levels: Option<Vec<u8>>,
}

/// Subprograms.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SubprogramsFile {
    /// Folders that are searched after that of the program; relative ones begin at this file.
    pub(crate) folders: Option<Vec<String>>,
    /// A call of one that is not there.
    pub(crate) missing: Option<MissingSubprogramFile>,
    /// With missing = "note": why it may be left out.
    pub(crate) missing_reason: Option<String>,
}

/// A call of a subprogram that is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum MissingSubprogramFile {
    /// It is refused.
    Refuse,
    /// It is named and left out, and the verdict is unchecked.
    Note,
}

/// Words of another language that a control has in addition to those of its own.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ProgramWordsFile {
    /// Okuma OSP: `VC1=5`, `X=VC1`, `IF [..] N100`, `CALL O200 Q3`, `RTS`, `NCYL`.
    Osp,
    /// Grbl: lines that begin with `$`, and no other words than those of grbl.
    Grbl,
    /// Mach3: what a block may hold is not checked as the interpreter of LinuxCNC does.
    Mach3,
}

/// Numbers of the groups of G words in system variables.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ModalVariablesFile {
    /// #4012 is G66 or G67, #4014 the work offset.
    Fanuc,
    /// #4012 is the work offset, #4014 G66 or G67.
    Mitsubishi,
}

/// What ends a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ProgramEndFile {
    /// A word of the language: M30, END PGM, FINI. A text without one is refused.
    Word,
    /// The end of the text as well, as on controls that are fed line by line.
    Text,
}

/// Lines around a program.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProgramFile {
    /// Words in addition to those of the language.
    pub(crate) words: Option<ProgramWordsFile>,
    /// How the system variables #4001 and on number the groups of G words.
    pub(crate) modal_variables: Option<ModalVariablesFile>,
    /// What ends a program; a word where the key is left out.
    pub(crate) end: Option<ProgramEndFile>,
    /// Patterns of lines before the first block that are no blocks: `*` for any characters.
    pub(crate) header: Option<Vec<String>>,
    /// Patterns of lines after the last block.
    pub(crate) trailer: Option<Vec<String>>,
}

/// What stops a program that never ends by itself.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LimitsFile {
    /// Subprogram calls within each other; default 32.
    pub(crate) call_depth: Option<u32>,
    /// Jumps back to an earlier block in the whole run: passes of loops and of subprograms; default
    /// 100 million.
    pub(crate) passes: Option<u64>,
    /// Jumps back without a motion between them; default one million.
    pub(crate) idle_passes: Option<u64>,
}

/// M words that neither the language nor the file knows.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct UnlistedFile {
    /// What is done with them.
    pub(crate) m: Option<UnlistedMFile>,
}

/// M words that neither the language nor the file knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum UnlistedMFile {
    /// Named in a note, without effect.
    Note,
    /// Refused.
    Refuse,
}

/// Meaning of a word: exactly one of the keys but values and source.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct WordFile {
    /// What these words of the language do: "M3", or several: "M3 M8".
    pub(crate) does: Option<String>,
    /// It switches the kinematics of the control; refused where the machine does not list it.
    pub(crate) kinematics: Option<KinematicsWordFile>,
    /// It calls the subprogram of this number or name.
    pub(crate) call: Option<String>,
    /// It calls the macro of this number, with the words of the block as arguments; on a `LinuxCNC` the O
    /// word subprogram of this name, with the words of `values` as its named parameters.
    #[serde(rename = "macro")]
    pub(crate) macro_call: Option<String>,
    /// It shows the operator this text.
    pub(crate) message: Option<String>,
    /// It has no effect on the twin, and is named with this text each time.
    pub(crate) note: Option<String>,
    /// It has no effect on the twin; the reason, which is reported once.
    pub(crate) ignore: Option<String>,
    /// It is refused; what to do instead.
    pub(crate) refuse: Option<String>,
    /// It calls the work offset whose number this word gives, the first one (G54) with 1, the seventh (G54.1
    /// P1) with 7: "H".
    pub(crate) offset: Option<String>,
    /// As `offset`, for its block alone; 0 is the machine.
    pub(crate) offset_once: Option<String>,
    /// Letters of the words of the block that belong to it: "PQ".
    pub(crate) values: Option<String>,
    /// Where the statement comes from.
    pub(crate) source: Option<String>,
}

/// A switch of the kinematics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum KinematicsWordFile {
    /// Tool center point control on.
    TcpOn,
    /// Tool center point control off.
    TcpOff,
}

/// JSON Schema of a control file.
pub fn control_schema() -> schemars::Schema {
    schemars::schema_for!(ControlFile)
}
