//! The command line: commands here, their options in files by subject.

mod folders;
mod own_part;
mod programs;
mod runs;

use clap::{Parser, Subcommand};

pub(crate) use self::{folders::*, own_part::*, programs::*, runs::*};

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
    /// Write a machine from the INI file of a LinuxCNC configuration or from a URDF file, as a start: what it does not tell is marked as chosen
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
