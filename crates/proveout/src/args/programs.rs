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
    /// Dialect (default: that of the control, else detected from file extension and text)
    #[arg(long)]
    pub(crate) dialect: Option<String>,
    /// Control: a built-in name (fanuc-0i, fanuc-30i, haas-ngc, siemens-840d-sl, heidenhain-tnc-640,
    /// dmg-tnc-640, heidenhain-itnc-530, linuxcnc-2.9, linuxcnc-xyzbc-trt, grbl-1.1, mach3, hurco-isnc,
    /// okuma-osp, fagor-8055, mazak-eia, mitsubishi-m800, brother-c00, millplus) or a control file (default:
    /// that of --machine)
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) control: Option<String>,
    /// Set a variable that the program reads but does not set: #500=1.5, R5=2, Q10=3; may be repeated
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) variable: Vec<String>,
    /// Set a work offset, mm and degrees; may be repeated
    #[arg(long, value_name = "G54=X,Y,Z[,A,B,C]")]
    pub(crate) offset: Vec<String>,
    /// Axis positions before the first block, mm and degrees, in the work offset active there
    #[arg(long, value_name = "X..,Y..", allow_hyphen_values = true)]
    pub(crate) start: Option<String>,
    /// Feed of motions before the first F, mm/min (default: that of the control; without one such a motion is
    /// an error)
    #[arg(long, value_name = "MM_MIN", allow_negative_numbers = true)]
    pub(crate) feed: Option<f64>,
    /// Search this folder for subprograms, after the folder of the program; may be repeated
    #[arg(long, value_name = "DIR")]
    pub(crate) subprograms: Vec<PathBuf>,
    /// Skip calls of missing subprograms, for this reason; the verdict is then unchecked (default: as the
    /// control file states; otherwise such a call is an error)
    #[arg(long, value_name = "REASON")]
    pub(crate) without_subprograms: Option<String>,
    /// Largest difference between the radii at start and end of an arc, mm (default: that of the control,
    /// else 0.01)
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
    /// NC program
    pub(crate) program: PathBuf,
    #[command(flatten)]
    pub(crate) reader: ReaderArgs,
    /// List the words that the control does not know, with count and first occurrence, as a table for a
    /// control file, and what else keeps the program from being read
    #[arg(long, conflicts_with_all = ["tools", "post"])]
    pub(crate) unknown: bool,
    /// Write the control file that lets the program be read: what its words, feed, arcs, start and
    /// subprograms most likely mean. The file marks each statement as assumed until you confirm it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["tools", "post"])]
    pub(crate) write_control: Option<PathBuf>,
    /// With --write-control: overwrite an existing file
    #[arg(long, requires = "write_control")]
    pub(crate) force: bool,
    /// Tool library: look up every tool call in it, and convert compensated contours (G41, RL) to the tool
    /// center path
    #[arg(long, value_name = "FILE")]
    pub(crate) tools: Option<PathBuf>,
    /// Machine (folder or machine.toml): G28 and G30 move to its reference points; kinematics that it does
    /// not list are an error
    #[arg(long, value_name = "FOLDER")]
    pub(crate) machine: Option<PathBuf>,
    /// Write the program in this dialect: siemens-840d, fanuc, haas, linuxcnc, iso, heidenhain, apt
    #[arg(long, value_name = "DIALECT")]
    pub(crate) post: Option<String>,
    /// With --post: decimals of lengths and angles (default: as usual in the dialect)
    #[arg(long, value_name = "N", requires = "post", value_parser = clap::value_parser!(u8).range(0..=9))]
    pub(crate) decimals: Option<u8>,
    /// With --post: write lengths in inches, with one more decimal
    #[arg(long, requires = "post")]
    pub(crate) inch: bool,
    /// With --post: number the blocks in steps of N
    #[arg(long, value_name = "N", requires = "post")]
    pub(crate) block_numbers: Option<u32>,
    /// With --post: number or name of the program
    #[arg(long, value_name = "NAME", requires = "post")]
    pub(crate) program_name: Option<String>,
    /// With --post: write arcs by radius, where the radius defines them well
    #[arg(long, requires = "post")]
    pub(crate) arc_radius: bool,
    /// With --post: repeat all words in every block, even unchanged ones
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
    Columns may be in any order. Joint positions: joint and unit (X_mm, A_deg). Tool pose: x_mm, y_mm, z_mm, i, j, k, the tip and \
    the unit vector of the tool axis in the table frame. Other columns are copied.")]
pub(crate) struct KinematicsArgs {
    /// Folder of the machine, or its machine.toml
    pub(crate) machine: PathBuf,
    /// Read joint columns and append tip and axis
    #[arg(long)]
    pub(crate) forward: bool,
    /// Read tip and axis and append the joints of every branch
    #[arg(long)]
    pub(crate) inverse: bool,
    /// With --inverse: write one branch per pose, continuous with the previous row
    #[arg(long, requires = "inverse", conflicts_with = "forward")]
    pub(crate) nearest: bool,
    /// Distance from the tip to the gauge line, mm
    #[arg(long, value_name = "X", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) tool_length_mm: f64,
    /// Input table (default: standard input)
    #[arg(long, value_name = "FILE")]
    pub(crate) input: Option<PathBuf>,
    /// Output table (default: standard output)
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file
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
    /// Machining allowance left on the blade, mm
    #[arg(long, value_name = "X", default_value_t = 0.0)]
    pub(crate) allowance_mm: f64,
    /// Largest distance between mesh and blade, mm (default: that of the scene)
    #[arg(long, value_name = "X")]
    pub(crate) chord_error_mm: Option<f64>,
    /// Overwrite an existing file
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    proveout plan scenes/li-2022-s-theta --strategy helix --output original.mpf\n  \
    proveout plan scenes/planned-blade --strategy quasi-circle --output lines.mpf --report lines.json\n  \
    proveout plan scenes/planned-blade --study\n\n\
    A plan is a table [plan.NAME] of the scene. The command prints the demands of the path on the machine; `proveout run` then \
    checks collisions and the cut part.")]
pub(crate) struct PlanArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Strategy of the tool path
    #[arg(long, value_parser = strategies(), required_unless_present = "study")]
    pub(crate) strategy: Option<String>,
    /// Program of the scene to generate from this table, with its `planned_axis` if it has one
    #[arg(long, value_name = "NAME", conflicts_with = "study")]
    pub(crate) program: Option<String>,
    /// Program file; the extension selects the language (.mpf 840D, .apt CL data, .h Heidenhain, .ngc and .nc
    /// ISO)
    #[arg(long, value_name = "FILE", required_unless_present = "study")]
    pub(crate) output: Option<PathBuf>,
    /// Write the demands of the path on the machine as JSON, point by point
    #[arg(long, value_name = "FILE", conflicts_with = "study")]
    pub(crate) report: Option<PathBuf>,
    /// Plan every table of the scene and print the results side by side, without writing a program
    #[arg(long, conflicts_with_all = ["strategy", "output"])]
    pub(crate) study: bool,
    /// Overwrite existing files
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
    Default options are those of the scene's program that this method derives from this one, else the published and default values.\n\
    s-theta: clearance_deg, inset_deg (or search), start_flat_mm, end_flat_percent, merge_mm, theta_unit (degree, radian, \
    normalized, unit-free).\n\
    quaternion: keys, clearance_deg (of the channel that is printed).\n\
    singularity: cone_deg, rate_deg_mm, junction (off, free, pinned).\n\
    min-angular-acceleration: max_key_lean_deg, window_mm, criterion (paper, true-minimum), key_axes (program, search).\n\
    multi-scale: strip_min_mm, strip_max_mm, strip_height_mm, ra_um, evaluation_length_mm, run_in_mm, margin_deg, coefficients, \
    measured_ratio, measured_spread.\n\
    smooth: channel (clearance, tool, rows), lean_max_deg. With channel clearance or tool: clearance_deg, monotone (true, false), \
    max_time_loss_percent (for a lower peak acceleration). With channel rows: turn_max_deg, ends (kept, free), and for a bull-nose \
    cutter the options of multi-scale except margin_deg and coefficients.\n\n\
    The command prints the times of both programs and a lower bound: within the joint limits listed, no schedule of tool axes in \
    the channel is faster. A program that the control rejects is not written.")]
pub(crate) struct RescheduleArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Program of the scene to reschedule, or one that the scene derives by this method
    #[arg(long, value_name = "NAME")]
    pub(crate) program: String,
    /// Method: s-theta, quaternion, singularity, min-angular-acceleration, multi-scale (published), or smooth
    /// (Proveout's own)
    #[arg(long, value_name = "METHOD")]
    pub(crate) method: String,
    /// Set an option of the method, overriding the scene; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Program file; the extension selects the language (.mpf 840D, .apt CL data, .h Heidenhain, .ngc and .nc
    /// ISO)
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Write the lower bound on the time of any schedule, with its proof, as JSON;
    /// `cargo xtask verify-schedule` checks it
    #[arg(long, value_name = "FILE")]
    pub(crate) certificate: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long)]
    pub(crate) force: bool,
}
