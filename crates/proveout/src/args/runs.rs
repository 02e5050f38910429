//! Options of the commands that run programs: run, job, sweep, compare.

use std::{path::PathBuf, str::FromStr};

use clap::{Args, Subcommand, ValueEnum, builder::PossibleValuesParser};
use proveout_sim::{SetValue, gates::GATES, partial::StopAt};

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
    #[arg(long, value_name = "DIR", alias = "output")]
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
