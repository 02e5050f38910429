//! Options of the commands that read and write programs: nc, kinematics, blade, plan, reschedule.

use std::{iter, path::PathBuf};

use clap::{
    ArgGroup, Args,
    builder::{PossibleValue, PossibleValuesParser},
};
use proveout_sim::scene::{HELIX, StrategyFile};

/// How NC programs are read.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Reading NC programs")]
pub(crate) struct ReaderArgs {
    /// Dialect (default: that of the control, else found from the ending and the text)
    #[arg(long)]
    pub(crate) dialect: Option<String>,
    /// Control: a built-in one (fanuc-0i, fanuc-30i, haas-ngc, siemens-840d-sl, heidenhain-tnc-640, heidenhain-itnc-530, linuxcnc-2.9,
    /// grbl-1.1, mach3, hurco-isnc, okuma-osp, fagor-8055, mazak-eia, mitsubishi-m800, brother-c00, millplus) or a control file
    /// (default: that of --machine)
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) control: Option<String>,
    /// Value of a variable that the program reads and does not set: #500=1.5, R5=2, Q10=3; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) variable: Vec<String>,
    /// Work offset, mm and degrees; may be repeated
    #[arg(long, value_name = "G54=X,Y,Z[,A,B,C]")]
    pub(crate) offset: Vec<String>,
    /// Where the axes stand before the first block, mm and degrees in the work offset that is then in force
    #[arg(long, value_name = "X..,Y..", allow_hyphen_values = true)]
    pub(crate) start: Option<String>,
    /// Feed of motions before the first F, mm/min (default: as the control says, else such a motion is refused)
    #[arg(long, value_name = "MM_MIN", allow_negative_numbers = true)]
    pub(crate) feed: Option<f64>,
    /// Folder of subprograms, searched after that of the program; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) subprograms: Vec<PathBuf>,
    /// Leave out calls of subprograms that are not there, for this reason; the verdict is then unchecked (default: as the control says,
    /// else such a call is refused)
    #[arg(long, value_name = "REASON")]
    pub(crate) without_subprograms: Option<String>,
    /// Largest difference of the radii at start and end of an arc, mm (default: as the control says, else 0.01)
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    pub(crate) arc_tolerance: Option<f64>,
}

impl ReaderArgs {
    /// The call states something of how programs are read.
    pub(crate) fn stated(&self) -> bool {
        let Self { dialect, control, variable, offset, start, feed, subprograms, without_subprograms, arc_tolerance } =
            self;
        dialect.is_some()
            || control.is_some()
            || !variable.is_empty()
            || !offset.is_empty()
            || start.is_some()
            || feed.is_some()
            || !subprograms.is_empty()
            || without_subprograms.is_some()
            || arc_tolerance.is_some()
    }
}

#[derive(Debug, Args)]
pub(crate) struct NcArgs {
    /// Program text
    pub(crate) program: PathBuf,
    #[command(flatten)]
    pub(crate) reader: ReaderArgs,
    /// Instead list the words that the control has no meaning for, with counts and first places, as a table for a control file
    #[arg(long, conflicts_with_all = ["tools", "post"])]
    pub(crate) unknown: bool,
    /// Tool library: tool calls must be in it, and compensated contours (G41, RL) come as the path of the tool center
    #[arg(long, value_name = "FILE")]
    pub(crate) tools: Option<PathBuf>,
    /// Machine (folder or machine.toml): G28 and G30 go to its reference points, kinematics that it does not list are refused
    #[arg(long, value_name = "FOLDER")]
    pub(crate) machine: Option<PathBuf>,
    /// Write the program in this dialect instead: siemens-840d, fanuc, haas, linuxcnc, iso, heidenhain, apt
    #[arg(long, value_name = "DIALECT")]
    pub(crate) post: Option<String>,
    /// With --post: decimals of lengths and angles (default: as programs of the dialect have them)
    #[arg(long, value_name = "N", requires = "post", value_parser = clap::value_parser!(u8).range(0..=9))]
    pub(crate) decimals: Option<u8>,
    /// With --post: lengths in inch, with one decimal more
    #[arg(long, requires = "post")]
    pub(crate) inch: bool,
    /// With --post: number the blocks in steps of N
    #[arg(long, value_name = "N", requires = "post")]
    pub(crate) block_numbers: Option<u32>,
    /// With --post: number or name of the program
    #[arg(long, value_name = "NAME", requires = "post")]
    pub(crate) program_name: Option<String>,
    /// With --post: arcs by their radius where that defines them well
    #[arg(long, requires = "post")]
    pub(crate) arc_radius: bool,
    /// With --post: write words in every block, also those that have not changed
    #[arg(long, requires = "post")]
    pub(crate) all_words: bool,
    /// With --post: write all decimals (10.000)
    #[arg(long, requires = "post")]
    pub(crate) trailing_zeros: bool,
}

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("direction").required(true).args(["forward", "inverse"]))]
#[command(after_help = "Examples:\n  \
    proveout kinematics machines/starrag-lx-451 --forward --tool-length-mm 100 < joints.csv\n  \
    proveout kinematics machines/starrag-lx-451 --inverse --input poses.csv --output branches.csv\n  \
    proveout kinematics machines/starrag-lx-451 --inverse --nearest --tool-length-mm 100 < poses.csv > joints.csv\n\n\
    Columns in any order, named by joint and unit (X_mm, A_deg), or x_mm, y_mm, z_mm, i, j, k: tip and unit axis in the frame of \
    the table. Further columns are passed through.")]
pub(crate) struct KinematicsArgs {
    /// Folder of the machine, or its machine.toml
    pub(crate) machine: PathBuf,
    /// Joint columns in, tip and axis appended
    #[arg(long)]
    pub(crate) forward: bool,
    /// Tip and axis in, joints of every branch appended
    #[arg(long)]
    pub(crate) inverse: bool,
    /// With --inverse: one row, continuous with the row before
    #[arg(long, requires = "inverse", conflicts_with = "forward")]
    pub(crate) nearest: bool,
    /// From the tip to the gauge line, mm
    #[arg(long, value_name = "X", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) tool_length_mm: f64,
    /// Table that is read (default: standard input)
    #[arg(long, value_name = "FILE")]
    pub(crate) input: Option<PathBuf>,
    /// Table that is written (default: standard output)
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Write over a file that is there
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    proveout blade scenes/li-2022-s-theta --output blade.stl\n  \
    proveout blade scenes/li-2022-s-theta --output stock.glb --allowance-mm 0.5 --chord-error-mm 0.01")]
pub(crate) struct BladeArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Mesh file: .stl (mm), .glb (glTF, meter)
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Material left on the blade, mm
    #[arg(long, value_name = "X", default_value_t = 0.0)]
    pub(crate) allowance_mm: f64,
    /// Largest distance of the mesh from the blade, mm (default: the scene's)
    #[arg(long, value_name = "X")]
    pub(crate) chord_error_mm: Option<f64>,
    /// Write over a file that is there
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    proveout plan scenes/li-2022-s-theta --strategy helix --output original.mpf\n  \
    proveout plan scenes/planned-blade --strategy quasi-circle --output lines.mpf --report lines.json\n  \
    proveout plan scenes/planned-blade --study\n\n\
    A plan is the table [plan.NAME] of the scene. What it asks of the machine is printed before anything runs; that it is free of \
    collisions and cuts the part is what `run` proves.")]
pub(crate) struct PlanArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// How the path is laid
    #[arg(long, value_parser = strategies(), required_unless_present = "study")]
    pub(crate) strategy: Option<String>,
    /// Program of the scene that this table writes: with its `planned_axis`, where it has one
    #[arg(long, value_name = "NAME", conflicts_with = "study")]
    pub(crate) program: Option<String>,
    /// Program file; its ending tells the language (.mpf 840D, .apt CL data, .h Heidenhain, .ngc and .nc ISO)
    #[arg(long, value_name = "FILE", required_unless_present = "study")]
    pub(crate) output: Option<PathBuf>,
    /// Writes what the path asks of the machine as JSON, point by point
    #[arg(long, value_name = "FILE", conflicts_with = "study")]
    pub(crate) report: Option<PathBuf>,
    /// Plans every table of the scene and prints them side by side; no program is written
    #[arg(long, conflicts_with_all = ["strategy", "output"])]
    pub(crate) study: bool,
    /// Write over files that are there
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
}

/// The strategies of scenes by their names.
fn strategies() -> PossibleValuesParser {
    let all = StrategyFile::ALL.into_iter().map(|(_, name, meaning)| (name, meaning));
    PossibleValuesParser::new(
        iter::once(HELIX).chain(all).map(|(name, meaning)| PossibleValue::new(name).help(meaning)),
    )
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    proveout reschedule scenes/li-2022-s-theta --program original --method s-theta --output new.mpf\n  \
    proveout reschedule scenes/li-2022-s-theta --program original --method quaternion --set keys=9 --output new.apt\n  \
    proveout reschedule scenes/li-2022-s-theta --program original --method smooth --set channel=tool --output smooth-tool.mpf\n\n\
    Options are those of the scene's program that is made from this one by the method, else the published and default ones. \
    s-theta has clearance_deg, inset_deg (or search), start_flat_mm, end_flat_percent, merge_mm and theta_unit (degree, radian, normalized, \
    unit-free); quaternion has keys and clearance_deg (of the channel that is shown); \
    singularity has cone_deg, rate_deg_mm and junction (off, free, pinned); min-angular-acceleration has cap_deg, \
    window_mm, criterion (paper, true-minimum) and key_axes (program, search); multi-scale has strip_min_mm, strip_max_mm, strip_height_mm, ra_um, evaluation_length_mm, run_in_mm, \
    margin_deg, coefficients, measured_part and measured_spread; smooth, \
    which is of this project, has channel (clearance, tool, rows) and lean_max_deg, with the first two clearance_deg, monotone (true, \
    false) and time_given_up_percent (for a lower peak of acceleration), with rows turn_max_deg, ends (kept, free) and for a bull-nose the options of multi-scale but margin_deg and coefficients.\n\n\
    Beside the time of both programs stands a bound: no schedule of axes in the channel, with the limits of the joints that are named, \
    is faster. A program that the control refuses is not written.")]
pub(crate) struct RescheduleArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Program of the scene that is re-scheduled, or one that the scene makes by the method
    #[arg(long, value_name = "NAME")]
    pub(crate) program: String,
    /// Method: s-theta, quaternion, singularity, min-angular-acceleration, multi-scale as published; smooth, of this project
    #[arg(long, value_name = "METHOD")]
    pub(crate) method: String,
    /// Option of the method, in place of the scene's; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Program file; its ending tells the language (.mpf 840D, .apt CL data, .h Heidenhain, .ngc and .nc ISO)
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Writes the bound of the time of all schedules with its proof as JSON; `cargo xtask verify-schedule` checks it
    #[arg(long, value_name = "FILE")]
    pub(crate) certificate: Option<PathBuf>,
    /// Write over a file that is there
    #[arg(long)]
    pub(crate) force: bool,
}
