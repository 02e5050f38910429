//! Options of the commands about parts and machines of one's own: new, tools, machine, check.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::ReaderArgs;

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
    docs/first-part.md goes through a part, step by step. Questions are asked at the terminal; without one each wants an answer in the file of \
    --answers, by its key: stock = \"0,0,-20,100,60,0\", holder = \"40x60\". The word proposed takes what is proposed.")]
pub(crate) struct NewArgs {
    /// Program texts
    #[arg(value_name = "PROGRAM", required_unless_present = "list_machines")]
    pub(crate) programs: Vec<PathBuf>,
    /// Machine: a name of the library, or a folder with machine.toml
    #[arg(long, value_name = "NAME", required_unless_present = "list_machines")]
    pub(crate) machine: Option<String>,
    /// List the machines of the library, a line each: structure, travel, source
    #[arg(long, conflicts_with_all = ["programs", "machine", "control", "stock", "design", "tools", "unit", "answers", "output"])]
    pub(crate) list_machines: bool,
    /// Control: a built-in one or a control file (default: that of the machine, else told from the text)
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) control: Option<String>,
    /// Stock: X0,Y0,Z0,X1,Y1,Z1 in mm (or with inch at the end), X,Y,Z0,DIAMETER,HEIGHT (a lying bar: X0,Y,Z,DIAMETER,LENGTH along X), a mesh, or proposed
    #[arg(long, value_name = "STOCK", allow_hyphen_values = true)]
    pub(crate) stock: Option<String>,
    /// Design of the part, a closed mesh in the coordinates of the program (STL, OBJ, glTF)
    #[arg(long, value_name = "FILE")]
    pub(crate) design: Option<PathBuf>,
    /// Tool library: .toml of this program, Fusion 360 .json, LinuxCNC .tbl, CAMotics, .csv, offsets as a program
    #[arg(long, value_name = "FILE")]
    pub(crate) tools: Option<PathBuf>,
    /// Unit of the tool library, where it does not tell it
    #[arg(long, value_enum, requires = "tools")]
    pub(crate) unit: Option<UnitArg>,
    /// Answers to the questions, TOML
    #[arg(long, value_name = "FILE")]
    pub(crate) answers: Option<PathBuf>,
    /// Folder that is made (default: the name of the first program, here); one that is there is refused
    #[arg(long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Tell it as JSON on the standard output: the scene, questions that are open (then with exit code 2), or the machines. Nobody is asked
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ToolsArgs {
    /// Tool library: Fusion 360 .json, LinuxCNC .tbl, CAMotics, .csv, offsets as a program (G10 L10)
    pub(crate) file: PathBuf,
    /// Library that is written
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Unit of the file, where it does not tell it
    #[arg(long, value_enum)]
    pub(crate) unit: Option<UnitArg>,
    /// Only the tool of this number; may be repeated
    #[arg(long, value_name = "N")]
    pub(crate) number: Vec<u32>,
    /// Holder of tools of which the file tells none: diameter and length to the gauge line, mm or with inch at the end (default: none, checks against it are unchecked)
    #[arg(long, value_name = "DxL")]
    pub(crate) holder: Option<String>,
    /// Write over a file that is there
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "A URDF file (.urdf, .xml) knows places, axes and limits of joints, and shapes of links; --tool-link and --table-link say which of them are \
                        the two ends of the machine. Joints between them get the letter that their name tells (X, x_axis, joint_B)."
)]
pub(crate) struct MachineArgs {
    /// INI file of a LinuxCNC configuration, or a URDF file
    pub(crate) file: PathBuf,
    /// INI file: linear axes that carry the table, such as XY (default: none, all carry the tool)
    #[arg(long, value_name = "LETTERS")]
    pub(crate) table_axes: Option<String>,
    /// URDF: link that carries the tool; its origin is the middle of the gauge line
    #[arg(long, value_name = "NAME")]
    pub(crate) tool_link: Option<String>,
    /// URDF: link that carries the workpiece; its origin is the middle of the clamping surface
    #[arg(long, value_name = "NAME")]
    pub(crate) table_link: Option<String>,
    /// URDF: letters of joints whose names tell none, such as `joint_1=X,joint_2=C`
    #[arg(long, value_name = "JOINT=LETTER,...")]
    pub(crate) axis_names: Option<String>,
    /// URDF: axes that the control counts against the joint of the file, such as X,C
    #[arg(long, value_name = "LETTERS")]
    pub(crate) reverse: Option<String>,
    /// URDF: axis of the tool link that points from the tool into the spindle: x, -x, y, -y, z, -z (default: z)
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub(crate) tool_direction: Option<String>,
    /// URDF: axis of the table link that points out of the clamping surface, likewise (default: z)
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub(crate) table_normal: Option<String>,
    /// Folder that is made; one that is there is refused
    #[arg(long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Scenes, machines, tool libraries, control files, NC programs; files or folders
    #[arg(required = true)]
    pub(crate) paths: Vec<PathBuf>,
    /// Draw the machine that is checked: its bodies at home, its axes with their letters, travel and what each carries (PNG)
    #[arg(long, value_name = "FILE")]
    pub(crate) picture: Option<PathBuf>,
    /// Write over a picture that is there
    #[arg(long, requires = "picture")]
    pub(crate) force: bool,
    /// Tell it as JSON on the standard output, errors in it: each path with notes and causes of findings to come
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) reader: ReaderArgs,
}
