//! Options of the commands about parts and machines of one's own: new, tools, machine, migrate, check.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{ReaderArgs, ReportArgs};

/// Unit of length.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum UnitArg {
    /// Millimeters
    Mm,
    /// Inches
    Inch,
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    proveout new --list-machines\n\n\
    docs/first-part.md shows a first part, step by step. At a terminal the command asks for missing values; without one, give each \
    answer in the file of --answers under its key: stock = \"0,0,-20,100,60,0\", holder = \"40x60\". The answer `proposed` accepts \
    the proposal.")]
pub(crate) struct NewArgs {
    /// NC programs
    #[arg(value_name = "PROGRAM", required_unless_present = "list_machines")]
    pub(crate) programs: Vec<PathBuf>,
    /// Machine: a name from the library, or a folder with machine.toml
    #[arg(long, value_name = "NAME", required_unless_present = "list_machines")]
    pub(crate) machine: Option<String>,
    /// List the machines of the library, one per line: structure, travel, source
    #[arg(long, conflicts_with_all = ["programs", "machine", "control", "write_control", "stock", "design", "tools", "unit", "answers", "output"])]
    pub(crate) list_machines: bool,
    /// Control: a built-in name or a control file (default: that of the machine, else detected from the text)
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) control: Option<String>,
    /// Write the control file that lets the programs be read, and use it: what their words, feed, arcs, start
    /// and subprograms most likely mean. Each statement is assumed until you confirm it
    #[arg(long, value_name = "FILE")]
    pub(crate) write_control: Option<PathBuf>,
    /// Stock, mm (append inch for inches): block X0,Y0,Z0,X1,Y1,Z1; cylinder X,Y,Z0,DIAMETER,HEIGHT; lying
    /// bar X0,Y,Z,DIAMETER,LENGTH along X; a mesh file; or `proposed`
    #[arg(long, value_name = "STOCK", allow_hyphen_values = true)]
    pub(crate) stock: Option<String>,
    /// Design of the part: a closed mesh in program coordinates (STL, OBJ, glTF)
    #[arg(long, value_name = "FILE")]
    pub(crate) design: Option<PathBuf>,
    /// Tool library: Proveout .toml, Fusion 360 .json, LinuxCNC .tbl, CAMotics, .csv, or a program with G10
    /// offsets
    #[arg(long, value_name = "FILE")]
    pub(crate) tools: Option<PathBuf>,
    /// Unit of the tool library, where the file does not state it
    #[arg(long, value_enum, requires = "tools")]
    pub(crate) unit: Option<UnitArg>,
    /// TOML file with answers to the questions
    #[arg(long, value_name = "FILE")]
    pub(crate) answers: Option<PathBuf>,
    /// Folder to create, must not exist (default: name of the first program, in the current folder)
    #[arg(long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Print JSON to standard output, without prompting: the scene, the open questions (exit code 2), or the
    /// machines
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ToolsArgs {
    /// Tool library: Fusion 360 .json, LinuxCNC .tbl, CAMotics, .csv, or a program with offsets (G10 L10)
    pub(crate) file: PathBuf,
    /// Library to write
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Unit of the file, where the file does not state it
    #[arg(long, value_enum)]
    pub(crate) unit: Option<UnitArg>,
    /// Convert only the tool with this number; may be repeated
    #[arg(long, value_name = "N")]
    pub(crate) number: Vec<u32>,
    /// Holder for tools without one in the file: diameter x length to the gauge line, mm (append inch for
    /// inches). Default: none; checks against the holder are then unchecked
    #[arg(long, value_name = "DxL")]
    pub(crate) holder: Option<String>,
    /// Overwrite an existing file
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "A URDF file (.urdf, .xml) gives positions, axes and limits of joints, and shapes of links. --tool-link and \
                        --table-link name the two ends of the machine. Joints between them get the axis letter found in \
                        their name (X, x_axis, joint_B)."
)]
pub(crate) struct MachineArgs {
    /// LinuxCNC INI file, or a URDF file
    pub(crate) file: PathBuf,
    /// INI: linear axes that carry the table, such as XY (default: none, all carry the tool)
    #[arg(long, value_name = "LETTERS")]
    pub(crate) table_axes: Option<String>,
    /// URDF: link that carries the tool; its origin is the center of the gauge line
    #[arg(long, value_name = "NAME")]
    pub(crate) tool_link: Option<String>,
    /// URDF: link that carries the workpiece; its origin is the center of the clamping surface
    #[arg(long, value_name = "NAME")]
    pub(crate) table_link: Option<String>,
    /// URDF: axis letters of joints whose names do not contain one, such as `joint_1=X,joint_2=C`
    #[arg(long, value_name = "JOINT=LETTER,...")]
    pub(crate) axis_names: Option<String>,
    /// URDF: axes whose positive direction on the control is opposite to the joint of the file, such as X,C
    #[arg(long, value_name = "LETTERS")]
    pub(crate) reverse: Option<String>,
    /// URDF: axis of the tool link that points from the tool into the spindle: x, -x, y, -y, z, -z (default:
    /// z)
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub(crate) tool_direction: Option<String>,
    /// URDF: axis of the table link that points out of the clamping surface: x, -x, y, -y, z, -z (default: z)
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub(crate) table_normal: Option<String>,
    /// Folder to create; must not exist
    #[arg(long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Only the names of keys change: comments, order and line ends stay, and a file without old keys is not written. \
                        See docs/migrate.md.\n\n\
                        Exit code: 0 the files have today's keys; 1 with --check, a file has old keys; 2 a file cannot be read, \
                        nothing is written."
)]
pub(crate) struct MigrateArgs {
    /// Scenes, machines, tool libraries, control files, jobs or sweeps (TOML)
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// List the keys to rename, write nothing
    #[arg(long)]
    pub(crate) check: bool,
    /// Write to this file instead of in place; the call then names one FILE
    #[arg(long, value_name = "FILE", conflicts_with = "check")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long, requires = "output")]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Scenes, machines, tool libraries, control files or NC programs; files or folders
    #[arg(required = true)]
    pub(crate) paths: Vec<PathBuf>,
    /// Draw the machine to a PNG file: bodies at home, axes with letter, travel and what each one carries
    #[arg(long, value_name = "FILE")]
    pub(crate) picture: Option<PathBuf>,
    /// Overwrite an existing picture
    #[arg(long, requires = "picture")]
    pub(crate) force: bool,
    /// Print JSON to standard output, errors included: each path with notes and likely causes of findings
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) reports: ReportArgs,
    #[command(flatten)]
    pub(crate) reader: ReaderArgs,
}
