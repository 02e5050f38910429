//! Options of the commands that run programs: run, job, sweep, compare.

use std::{path::PathBuf, str::FromStr};

use clap::{
    Args, Subcommand, ValueEnum,
    builder::{PossibleValuesParser, TypedValueParser},
};
use proveout_sim::{SetValue, partial::StopAt, verdict::Gate};

/// Where the recording of a run goes where the call does not say so: into its folder, if this build can write
/// one.
const RECORDING: &str = if cfg!(feature = "rerun") { "file" } else { "off" };

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Program of the scene (default: the first one)
    #[arg(long, value_name = "NAME")]
    pub(crate) program: Option<String>,
    /// Run this NC program on the scene instead
    #[arg(long, value_name = "FILE")]
    pub(crate) nc: Option<PathBuf>,
    /// Run folder (default: out/SCENE-PROGRAM, with suffix -preview or -stopped for such a run). An older run
    /// there is replaced once the new one is complete; other files are kept
    #[arg(long, value_name = "DIR", alias = "out")]
    pub(crate) output: Option<PathBuf>,
    /// Resume an interrupted run (Ctrl-C, a kill, a full disk); the result is identical to an uninterrupted
    /// one. Motion is planned and judged again, finished cuts are read from the journal
    #[arg(long)]
    pub(crate) resume: bool,
    /// Keep no journal: the disk stays free of it (a million moves at 0.1 mm write some gigabytes), and a run
    /// that is interrupted starts again
    #[arg(long, conflicts_with = "resume")]
    pub(crate) no_journal: bool,
    /// Run a quick preview with cells four times as large, without patches and texture. Its findings are
    /// real, but their absence proves nothing: gates that depend on the stock stay unchecked
    #[arg(long, conflicts_with_all = ["resolution_mm", "find_stickout", "orientation_maps", "accept_unchecked"])]
    pub(crate) preview: bool,
    /// Stop at the first finding with CODE (`any`: one that fails a gate), after program line LINE (`120`),
    /// or at a simulated time (`12.5s`). Gates that have not failed by then are unchecked
    #[arg(long, value_name = "any|CODE|LINE|TIMEs", allow_hyphen_values = true, conflicts_with_all = ["find_stickout", "orientation_maps", "accept_unchecked"])]
    pub(crate) stop_at: Option<StopAt>,
    /// Cell size of the stock (distance between its rays), mm (default: that of the scene)
    #[arg(long, value_name = "X")]
    pub(crate) resolution_mm: Option<f64>,
    /// Worker threads (default: all processors); the verdict does not depend on their number
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Override a value of the scene, or with prefix `machine.` or `tools.` of those files, by its dotted
    /// key: `control.path_tolerance_mm=0.005`, `machine.A.max_velocity_deg_s=50`. The verdict lists it. May
    /// be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<SetValue>,
    /// Motion model that cuts the stock (default: that of the scene)
    #[arg(long, value_enum)]
    pub(crate) dynamics: Option<DynamicsArg>,
    /// With --dynamics servo: mechanical model driven by the drive forces (default: that of the scene)
    #[arg(long, value_enum)]
    pub(crate) plant: Option<PlantArg>,
    /// Find the smallest overhang of each tool from its holder that is collision-free, by extra runs before
    /// this one
    #[arg(long)]
    pub(crate) find_stickout: bool,
    /// Compute collision-free orientation maps at this many contact points (ball-end tools), for the report
    /// and as a file
    #[arg(long, value_name = "PLACES", value_parser = clap::value_parser!(u16).range(1..=2000))]
    pub(crate) orientation_maps: Option<u16>,
    /// Destination of the Rerun recording
    #[arg(long, value_enum, default_value = RECORDING)]
    pub(crate) rerun: RerunArg,
    /// Exit with code 0 even if this gate is unchecked; the verdict is not changed. May be repeated
    #[arg(long, value_name = "GATE", value_parser = gate_parser())]
    pub(crate) accept_unchecked: Vec<Gate>,
    #[command(flatten)]
    pub(crate) reports: ReportArgs,
}

/// Results for other programs.
#[derive(Debug, Default, Args)]
pub(crate) struct ReportArgs {
    /// Write the findings as a SARIF 2.1.0 log (.sarif, .json), for code review and editors. An older log
    /// there is replaced
    #[arg(long, value_name = "FILE")]
    pub(crate) sarif: Option<PathBuf>,
    /// Write the gates as JUnit XML (.xml), for build servers; an unchecked gate is an error. An older file
    /// of this kind is replaced
    #[arg(long, value_name = "FILE")]
    pub(crate) junit: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(
    after_help = "A job lists its setups: one [[setup]] each, with name, scene, and optionally program and after. See docs/jobs.md."
)]
pub(crate) struct JobArgs {
    /// Folder of the job, or its job.toml
    pub(crate) job: PathBuf,
    /// Output folder (default: out/JOB-job). An older job there is replaced once the new one is complete;
    /// other files are kept
    #[arg(long, value_name = "DIR", alias = "out")]
    pub(crate) output: Option<PathBuf>,
    /// Worker threads (default: all processors); no verdict depends on their number
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Destination of the Rerun recording of each setup
    #[arg(long, value_enum, default_value = "off")]
    pub(crate) rerun: RerunArg,
}

/// Steps of a sweep.
#[derive(Debug, Subcommand)]
pub(crate) enum SweepCommand {
    /// Write one folder per job, with its values and the SHA-256 of its inputs; jobs planned before keep
    /// their results
    Plan(SweepPlanArgs),
    /// Run the jobs that have no result yet, one after another; may run several times in parallel, on several
    /// computers
    Run(SweepRunArgs),
    /// Merge all results into one table and one page; stop if a result is missing, damaged or from another
    /// plan
    Merge(SweepMergeArgs),
}

#[derive(Debug, Args)]
pub(crate) struct SweepPlanArgs {
    /// Folder of the sweep, or its sweep.toml
    pub(crate) sweep: PathBuf,
    /// Output folder (default: out/SWEEP-sweep)
    #[arg(long, value_name = "DIR", alias = "out")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct SweepRunArgs {
    /// Folder written by `proveout sweep plan`
    pub(crate) sweep: PathBuf,
    /// Run only this job, or this range of jobs; may be repeated
    #[arg(long, value_name = "N|FIRST-LAST")]
    pub(crate) job: Vec<JobRange>,
    /// Run only one share of the jobs: 3/8 is every eighth job, starting with the third
    #[arg(long, value_name = "I/N")]
    pub(crate) part: Option<SweepShare>,
    /// Worker threads of a job (default: all processors); no result depends on their number
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug, Args)]
pub(crate) struct SweepMergeArgs {
    /// Folder written by `proveout sweep plan`
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
pub(crate) struct SweepShare {
    /// From 1.
    pub(crate) number: usize,
    pub(crate) of: usize,
}

impl FromStr for SweepShare {
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
    /// Program to compare the others with (default: that of the scene, else the first one)
    #[arg(long, value_name = "NAME")]
    pub(crate) baseline: Option<String>,
    /// Output folder (default: out/SCENE-compare). An older comparison there is replaced once the new one is
    /// complete; other files are kept
    #[arg(long, value_name = "DIR", alias = "out")]
    pub(crate) output: Option<PathBuf>,
    /// Cell size of the stock (distance between its rays), mm (default: that of the scene)
    #[arg(long, value_name = "X")]
    pub(crate) resolution_mm: Option<f64>,
    /// Worker threads (default: all processors); compare.json does not depend on their number
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Motion model that cuts the stock (default: that of the scene)
    #[arg(long, value_enum)]
    pub(crate) dynamics: Option<DynamicsArg>,
    /// Destination of the Rerun recording of each program
    #[arg(long, value_enum, default_value = "off")]
    pub(crate) rerun: RerunArg,
    /// Exit with code 0 even if this gate is unchecked for a program; the verdict is not changed. May be
    /// repeated
    #[arg(long, value_name = "GATE", value_parser = gate_parser())]
    pub(crate) accept_unchecked: Vec<Gate>,
}

/// Reads the name of a gate.
fn gate_parser() -> impl TypedValueParser<Value = Gate> {
    PossibleValuesParser::new(Gate::NAMES).try_map(|name| Gate::named(&name).ok_or("not a gate"))
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DynamicsArg {
    /// The programmed path, at the planned times
    Ideal,
    /// The set points of the control, corners rounded within the tolerance
    Planned,
    /// The motion of the drives following the set points
    Servo,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum PlantArg {
    /// One mass per joint, loads by recursive Newton-Euler
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
    /// Start a viewer and stream to it
    Spawn,
    /// Stream to a running viewer
    Connect,
}
