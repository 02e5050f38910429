//! The command line: commands here, their options in files by subject.

mod calibrate;
mod feeds;
mod folders;
mod own_part;
mod programs;
mod runs;

use clap::{
    Parser, Subcommand,
    error::{ContextKind, ContextValue, ErrorKind},
};

pub(crate) use self::{calibrate::*, feeds::*, folders::*, own_part::*, programs::*, runs::*};

/// A machining digital twin: proves NC programs before the first cut.
#[derive(Debug, Parser)]
#[command(name = "proveout", version, max_term_width = 110)]
#[command(
    after_help = "Exit code: 0 verdict pass (or command succeeded); 1 verdict fail; 2 invalid input or arguments, \
                        nothing is written; 3 verdict unchecked: nothing failed, but something was not checked; \
                        130 interrupted by Ctrl-C or TERM."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Create a scene from NC programs: values read from their text, proposed values with the reason, and
    /// your answers
    New(NewArgs),
    /// Convert a tool library (Fusion 360, LinuxCNC, CAMotics, CSV, G10 offsets, ISO 13399, DIN 4000,
    /// hyperMILL, SolidCAM) to a Proveout library
    Tools(ToolsArgs),
    /// Create a draft machine from a LinuxCNC INI file or a URDF file; values missing there are marked as
    /// chosen
    Machine(MachineArgs),
    /// Simulate a program of a scene on the twin and write the run folder
    Run(RunArgs),
    /// Run the setups of a part in order, passing the stock from one to the next: one verdict, one page
    Job(JobArgs),
    /// Run a scene many times with varied key values, on any number of computers: plan, run, merge
    Sweep {
        #[command(subcommand)]
        command: SweepCommand,
    },
    /// Run all programs of a scene on the same twin and compare cycle times (with error), joints and cut
    /// parts
    Compare(CompareArgs),
    /// Learn a machine from measured traces: the air program to record, and the fit with standard errors
    Calibrate {
        #[command(subcommand)]
        command: CalibrateCommand,
    },
    /// Check scenes, machines, tool libraries, control files and NC programs without running them
    Check(CheckArgs),
    /// Rename old keys in scenes, machines, tool libraries, control files, jobs and sweeps; comments and
    /// order stay
    Migrate(MigrateArgs),
    /// Print the canonical commands of a program, one JSON object per line, or write it in another dialect
    Nc(NcArgs),
    /// Convert joint positions to tool poses, or tool poses to joint positions: CSV in, CSV out
    Kinematics(KinematicsArgs),
    /// Write the blade of a scene as a closed mesh (STL or glTF)
    Blade(BladeArgs),
    /// Generate a program for the blade of a scene
    Plan(PlanArgs),
    /// Rewrite a program with new tool axes; contact points, feeds and structure are kept
    Reschedule(RescheduleArgs),
    /// Write a program with new feeds: as high as the limits of the tools allow where the machine reaches
    /// them
    Feeds(FeedsArgs),
    /// Measure the stock after a run (section, distance, wall thickness) or a measured surface texture
    /// (roughness)
    Measure(MeasureArgs),
    /// Compare two run folders: findings gone, new and changed; numbers that differ
    Diff(DiffArgs),
    /// Open the recording of a run folder in the Rerun viewer
    View(ViewArgs),
    /// Check a run folder against its manifest: list files and inputs that have changed since the run
    Verify(VerifyArgs),
    /// Sign the manifest of a run folder, so that `verify` can confirm who signed it
    Sign(SignArgs),
    /// Show what this machine has of what the program uses, one line each with the remedy
    Doctor(DoctorArgs),
    /// Write the completion script of a shell to a file
    Completions(CompletionsArgs),
    /// Write the manual pages of all commands to a folder
    Manual(ManualArgs),
}

/// Options of `run` with a new name.
const RENAMED: [(&str, &str); 2] = [("--free-axes", "--orientation-maps"), ("--overhang", "--find-stickout")];

/// The same error, with the new name of an option that had another one before.
pub(crate) fn with_new_name(mut error: clap::Error) -> clap::Error {
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) else { return error };
    let given = given.split('=').next().unwrap_or_default();
    let renamed = RENAMED.iter().find(|(old, _)| *old == given);
    if let Some((old, new)) = renamed.filter(|_| error.kind() == ErrorKind::UnknownArgument) {
        let tip = format!("the name of '{old}' is '{new}' now");
        error.remove(ContextKind::SuggestedArg);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}
