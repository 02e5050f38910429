use std::{iter, path::PathBuf, str::FromStr};

use clap::{
    ArgGroup, Args, Parser, Subcommand, ValueEnum,
    builder::{PossibleValue, PossibleValuesParser},
};
use proveout_sim::{
    SetValue,
    gates::GATES,
    partial::StopAt,
    scene::{HELIX, StrategyFile},
};

/// A machining digital twin: proves NC programs before the first cut.
#[derive(Debug, Parser)]
#[command(name = "proveout", version, max_term_width = 110)]
#[command(
    after_help = "Exit code: 0 verdict pass (or the command did its work); 1 verdict fail; 2 the input or the call is \
                        wrong, nothing is written; 3 verdict unchecked: nothing failed, but something was not checked; 130 stopped by Ctrl-C or TERM."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Make a scene from NC programs: what their text tells, what was chosen with the reason, and what you answer
    New(NewArgs),
    /// Write the tool library of another program (Fusion 360, LinuxCNC, CAMotics, CSV, G10 offsets) as one of this
    Tools(ToolsArgs),
    /// Write a machine from the INI file of a LinuxCNC configuration, as a start: what it does not tell is marked as chosen
    Machine(MachineArgs),
    /// Run a program of a scene on the twin and write the run folder
    Run(RunArgs),
    /// Run the setups of a part in order, the stock handed on from one to the next: one verdict, one page
    Job(JobArgs),
    /// Run a scene many times with other values of its keys, on as many machines as there are: plan, run, merge
    Sweep {
        #[command(subcommand)]
        command: SweepCommand,
    },
    /// Run all programs of a scene on the same twin and compare them: times with error, joints, cut parts
    Compare(CompareArgs),
    /// Diagnostics only: scenes, machines, tool libraries, NC programs
    Check(CheckArgs),
    /// Print the canonical commands of a program, one JSON object a line, or write it in another dialect
    Nc(NcArgs),
    /// Tool poses of joint positions, or joint positions of tool poses: CSV in, CSV out
    Kinematics(KinematicsArgs),
    /// Write the blade of a scene as a closed mesh, STL or glTF
    Blade(BladeArgs),
    /// Write a program for the blade of a scene
    Plan(PlanArgs),
    /// Write a program of a scene with new tool axes: contact points, feeds and structure stay
    Reschedule(RescheduleArgs),
    /// Measure the stock that a run left (section, distance, wall thickness), or the texture in a file (roughness)
    Measure(MeasureArgs),
    /// What changed between two run folders: findings gone, new, changed; numbers
    Diff(DiffArgs),
    /// Open the recording of a run folder in the Rerun viewer
    View(ViewArgs),
    /// Hold a run folder against its manifest: files that are not as the run wrote them, inputs that have changed since
    Verify(VerifyArgs),
    /// Sign the manifest of a run folder, so that `verify` tells who vouches for it
    Sign(SignArgs),
    /// Write the completions of a shell into a file that it reads
    Completions(CompletionsArgs),
    /// Write the manual pages of all commands into a folder
    Manual(ManualArgs),
}

/// Where the recording of a run goes where the call does not say so: into its folder, if this build can write one.
const RECORDING: &str = if cfg!(feature = "rerun") { "file" } else { "off" };

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Program of the scene (default: the first one)
    #[arg(long, value_name = "NAME")]
    pub(crate) program: Option<String>,
    /// Run this program text on the scene instead
    #[arg(long, value_name = "FILE")]
    pub(crate) nc: Option<PathBuf>,
    /// Run folder (default: out/SCENE-PROGRAM, with -preview or -stopped behind it where the run is one); an older run there is replaced when the new one is complete, other files stay
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Go on with the run to this run folder that was stopped (Ctrl-C, a kill, a full disk): its motion is planned and judged again,
    /// what it had cut is taken from its journal. The result is that of a run that was not stopped
    #[arg(long)]
    pub(crate) resume: bool,
    /// Quick look: cells four times as long, without patches and texture. What it finds is true; what it does not find proves nothing, so
    /// that gates which ask the stock are unchecked
    #[arg(long, conflicts_with_all = ["resolution_mm", "overhang", "free_axes", "accept_unchecked"])]
    pub(crate) preview: bool,
    /// End the run early: at the first finding of a code, or any that fails a gate; behind a line of the program, as 120; at a simulated
    /// time, as 12.5s. Gates are then unchecked unless they have failed
    #[arg(long, value_name = "any|CODE|LINE|TIMEs", allow_hyphen_values = true, conflicts_with_all = ["overhang", "free_axes", "accept_unchecked"])]
    pub(crate) stop_at: Option<StopAt>,
    /// Distance of the stock's rays, mm (default: the scene's)
    #[arg(long, value_name = "X")]
    pub(crate) resolution_mm: Option<f64>,
    /// Worker threads (default: all processors); the verdict does not depend on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// A value in the place of that in the files, by tables, names and key with points between; `machine.` and `tools.` lead into those
    /// files: `control.path_tolerance_mm=0.005`, `machine.A.max_velocity_deg_s=50`. The verdict names it. May be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<SetValue>,
    /// Which motion cuts (default: the scene's)
    #[arg(long, value_enum)]
    pub(crate) dynamics: Option<DynamicsArg>,
    /// What moves under the forces of the drives, with --dynamics servo (default: the scene's)
    #[arg(long, value_enum)]
    pub(crate) plant: Option<PlantArg>,
    /// Search how far each tool must stand out of its holder, by runs of its own before this one
    #[arg(long)]
    pub(crate) overhang: bool,
    /// Look for the free tool axes at so many places where a ball end touches the design: maps in the report and a file
    #[arg(long, value_name = "PLACES", value_parser = clap::value_parser!(u16).range(1..=2000))]
    pub(crate) free_axes: Option<u16>,
    /// Where the Rerun recording goes
    #[arg(long, value_enum, default_value = RECORDING)]
    pub(crate) rerun: RerunArg,
    /// Exit code 0 also where this gate is unchecked; may be repeated. The verdict stays as it is
    #[arg(long, value_name = "GATE", value_parser = PossibleValuesParser::new(GATES))]
    pub(crate) accept_unchecked: Vec<String>,
}

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
    /// Stock: X0,Y0,Z0,X1,Y1,Z1 in mm (or with inch at the end), X,Y,Z0,DIAMETER,HEIGHT, a mesh, or proposed
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
pub(crate) struct MachineArgs {
    /// INI file of a LinuxCNC configuration
    pub(crate) file: PathBuf,
    /// Linear axes that carry the table, such as XY (default: none, all carry the tool)
    #[arg(long, value_name = "LETTERS")]
    pub(crate) table_axes: Option<String>,
    /// Folder that is made; one that is there is refused
    #[arg(long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(Debug, Args)]
#[command(
    after_help = "A job lists its setups: [[setup]] with name, scene, and where wanted program and after. docs/jobs.md shows one."
)]
pub(crate) struct JobArgs {
    /// Folder of the job, or its job.toml
    pub(crate) job: PathBuf,
    /// Folder (default: out/JOB-job); an older one there is replaced when the new one is complete, other files stay
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Worker threads (default: all processors); no verdict depends on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Where the Rerun recording of each setup goes
    #[arg(long, value_enum, default_value = "off")]
    pub(crate) rerun: RerunArg,
}

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
    /// File, such as `/etc/bash_completion.d/proveout`
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Write over a file that is there
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ManualArgs {
    /// Folder, such as /usr/local/share/man/man1
    #[arg(value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Write over pages that are there
    #[arg(long)]
    pub(crate) force: bool,
}

/// What to do with a sweep.
#[derive(Debug, Subcommand)]
pub(crate) enum SweepCommand {
    /// Write a folder a job, with its values and the SHA-256 of all that it reads; jobs that are planned already stay with their results
    Plan(SweepPlanArgs),
    /// Run jobs of a plan that have no result yet, one after the other; may be called many times beside each other, on many machines
    Run(SweepRunArgs),
    /// Put all results into one table and one page; nothing is merged where one is missing, damaged or of another plan
    Merge(SweepMergeArgs),
}

#[derive(Debug, Args)]
pub(crate) struct SweepPlanArgs {
    /// Folder of the sweep, or its sweep.toml
    pub(crate) sweep: PathBuf,
    /// Folder (default: out/SWEEP-sweep)
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct SweepRunArgs {
    /// Folder that sweep plan has written
    pub(crate) sweep: PathBuf,
    /// Only this job, or these from one to another; may be repeated
    #[arg(long, value_name = "N|FIRST-LAST")]
    pub(crate) job: Vec<JobRange>,
    /// Only one part of the jobs, as 3/8: every eighth from the third on
    #[arg(long, value_name = "I/N")]
    pub(crate) part: Option<Part>,
    /// Worker threads of a job (default: all processors); no result depends on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug, Args)]
pub(crate) struct SweepMergeArgs {
    /// Folder that sweep plan has written
    pub(crate) sweep: PathBuf,
}

/// Jobs from one to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JobRange {
    pub(crate) first: usize,
    pub(crate) last: usize,
}

impl FromStr for JobRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        match (first.parse(), last.parse()) {
            (Ok(first), Ok(last)) if first <= last => Ok(Self { first, last }),
            _ => Err("write a job as 7, or jobs as 7-12".into()),
        }
    }
}

/// One part of several.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// From 1.
    pub(crate) number: usize,
    pub(crate) of: usize,
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('/').map(|(number, of)| (number.parse(), of.parse())) {
            Some((Ok(number), Ok(of))) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err("write a part as 3/8, from 1/8 to 8/8".into()),
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Program that the others are compared with (default: the scene's, else the first one)
    #[arg(long, value_name = "NAME")]
    pub(crate) baseline: Option<String>,
    /// Folder (default: out/SCENE-compare); an older comparison there is replaced when the new one is complete, other files stay
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Distance of the stock's rays, mm (default: the scene's)
    #[arg(long, value_name = "X")]
    pub(crate) resolution_mm: Option<f64>,
    /// Worker threads (default: all processors); compare.json does not depend on it
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Which motion cuts (default: the scene's)
    #[arg(long, value_enum)]
    pub(crate) dynamics: Option<DynamicsArg>,
    /// Where the Rerun recording of each program goes
    #[arg(long, value_enum, default_value = "off")]
    pub(crate) rerun: RerunArg,
    /// Exit code 0 also where this gate of a program is unchecked; may be repeated. The verdict stays as it is
    #[arg(long, value_name = "GATE", value_parser = PossibleValuesParser::new(GATES))]
    pub(crate) accept_unchecked: Vec<String>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DynamicsArg {
    /// The programmed path, at the planned times
    Ideal,
    /// The set points of the control, corners rounded within the tolerance
    Planned,
    /// What the drives make of the set points
    Servo,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum PlantArg {
    /// One mass a joint, loaded by recursive Newton-Euler
    NewtonEuler,
    /// Coupled rigid bodies in Rapier
    Rapier,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum RerunArg {
    /// No recording
    Off,
    /// recording.rrd in the run folder
    File,
    /// A viewer is started and fed
    Spawn,
    /// A running viewer is fed
    Connect,
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
    s-theta has clearance_deg, inset_deg, start_flat_mm, end_flat_percent, merge_mm and theta_unit (degree, radian, normalized, \
    unit-free); quaternion has keys and clearance_deg (of the channel that is shown); \
    singularity has cone_deg, rate_deg_mm and junction (off, free, pinned); min-angular-acceleration has cap_deg, \
    window_mm, criterion (paper, true-minimum) and key_axes (program, search); multi-scale has strip_min_mm, strip_max_mm, strip_height_mm, ra_um, evaluation_length_mm and run_in_mm; smooth, \
    which is of this project, has channel (clearance, tool, rows) and lean_max_deg, with the first two clearance_deg and monotone (true, \
    false), with rows turn_max_deg, ends (kept, free) and for a bull-nose the options of multi-scale.\n\n\
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

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("what").required(true).args(["file", "profile"]))]
#[command(after_help = "Examples:\n  \
    proveout measure out/part-main --section z=-12.5 --out section.svg\n  \
    proveout measure out/part-main --section x=0 --design part.stl --out section.json\n  \
    proveout measure out/part-main --distance 10,0,5 --distance 10,0,-5\n  \
    proveout measure out/part-main/stock.dexel --wall 0,-3,-1,0,1,0 --design part.stl\n  \
    proveout measure --profile gauge.smd --class Sc2 --to-lay-deg 90\n  \
    proveout measure --profile gauge.smd --standard iso4287 --json\n  \
    proveout measure patch.sdf --out patch.png\n\n\
    Coordinates of a stock are those of the workpiece frame, mm. Between rays the surface is that of the mesh of the stock: on faces of \
    curvature radius r it is off by about cell²/8r. A distance is negative in material.\n\
    Texture: a pitch of marks beyond the cut-off of the class goes to the next class; what the data do not carry is unchecked, with \
    the reason, and the exit code is 3.")]
pub(crate) struct MeasureArgs {
    /// Run folder, a stock file (.dexel) in it, or a file of texture: height map or profile (SDF, X3P, SMD)
    #[arg(value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
    /// Section with a plane across an axis, such as z=12.5 (mm)
    #[arg(long, value_name = "AXIS=MM", allow_hyphen_values = true)]
    pub(crate) section: Option<String>,
    /// Distance of a place from the surface, mm; may be repeated
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) distance: Vec<String>,
    /// Thickness of the wall that a line from a place along a direction goes through first; may be repeated
    #[arg(long, value_name = "X,Y,Z,DX,DY,DZ", allow_hyphen_values = true)]
    pub(crate) wall: Vec<String>,
    /// Closed mesh in the workpiece frame, mm (STL, OBJ, glTF): measured beside the stock
    #[arg(long, value_name = "MESH")]
    pub(crate) design: Option<PathBuf>,
    /// File of a profile (SMD, SDF, X3P): parameters of ISO 21920-2 or ISO 4287
    #[arg(long, value_name = "FILE")]
    pub(crate) profile: Option<PathBuf>,
    /// Setting class of a texture, Sc1 to Sc5 (default: Sc3); its cut-off is the L-filter of height maps
    #[arg(long, value_enum)]
    pub(crate) class: Option<ClassArg>,
    /// Definitions of the profile parameters (default: iso21920)
    #[arg(long, value_enum)]
    pub(crate) standard: Option<StandardArg>,
    /// How the form of a texture is removed (default: level)
    #[arg(long, value_enum)]
    pub(crate) form: Option<FormArg>,
    /// Direction of a profile to the lay: 0 along the marks, 90 across them (default: not known)
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub(crate) to_lay_deg: Option<f64>,
    /// Pitch of the marks, mm, as far as it is known (default: as found)
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    pub(crate) pitch_mm: Option<f64>,
    /// Print the texture as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// File for the result: .json everything; .svg and .csv the section; .png, .sdf and .x3p the texture
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write over a file that is there
    #[arg(long, requires = "out")]
    pub(crate) force: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum ClassArg {
    /// Cut-off 0.08 mm
    #[value(name = "Sc1", alias = "sc1")]
    Sc1,
    /// Cut-off 0.25 mm
    #[value(name = "Sc2", alias = "sc2")]
    Sc2,
    /// Cut-off 0.8 mm
    #[value(name = "Sc3", alias = "sc3")]
    Sc3,
    /// Cut-off 2.5 mm
    #[value(name = "Sc4", alias = "sc4")]
    Sc4,
    /// Cut-off 8 mm
    #[value(name = "Sc5", alias = "sc5")]
    Sc5,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum StandardArg {
    /// ISO 21920-2:2021: Ra, Rq, Rsk, Rku over the evaluation length
    Iso21920,
    /// ISO 4287:1997+A1:2009: Ra, Rq, Rsk, Rku as mean of the sampling lengths
    Iso4287,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormArg {
    /// Least-squares line of a profile, least-squares plane of a map
    Level,
    /// Nothing is taken off
    None,
}

#[derive(Debug, Args)]
pub(crate) struct DiffArgs {
    /// Older run folder
    pub(crate) run_a: PathBuf,
    /// Newer run folder
    pub(crate) run_b: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// Run folder
    pub(crate) run: PathBuf,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit code: 0 all is as the run left it; 1 a file of the run folder is not, or the signature does not hold; 3 the folder is, but an input has \
                        changed since, is gone, or cannot be found."
)]
pub(crate) struct VerifyArgs {
    /// Run folder, or the folder of a comparison
    pub(crate) run: PathBuf,
    /// Folder of the scene, or its scene.toml (default: as run.json says)
    #[arg(long, value_name = "SCENE")]
    pub(crate) scene: Option<PathBuf>,
    /// Ed25519 public key (PEM) whose signature the manifest must have
    #[arg(long, value_name = "FILE")]
    pub(crate) public_key: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct SignArgs {
    /// Run folder, or the folder of a comparison
    pub(crate) run: PathBuf,
    /// Ed25519 private key (PEM), as `openssl genpkey -algorithm ed25519` makes it
    #[arg(long, value_name = "FILE")]
    pub(crate) key: PathBuf,
}
