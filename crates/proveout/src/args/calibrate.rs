//! Options of `proveout calibrate`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Steps of a calibration.
#[derive(Debug, Subcommand)]
pub(crate) enum CalibrateCommand {
    /// Write the air program to record: each axis alone, six lengths and eight feeds there and back. It is
    /// run on the twin of the scene first, and written only when nothing is found
    Plan(CalibratePlanArgs),
    /// Fit limits, gains and friction to recorded traces, and write the machine file with each value, its
    /// source and standard error. What the traces do not determine keeps its value, with the reason
    Fit(CalibrateFitArgs),
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  \
    proveout calibrate plan scenes/axis-cross --range Z=300..610 --output air.mpf\n\n\
    The axis along the spindle needs its range: nothing else says how far down is safe. See docs/calibrate.md.")]
pub(crate) struct CalibratePlanArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Positions that an axis may use, machine coordinates in mm or degrees; may be repeated (default: the
    /// travel, less a margin at both ends)
    #[arg(long, value_name = "AXIS=LOW..HIGH", allow_hyphen_values = true)]
    pub(crate) range: Vec<String>,
    /// Language: siemens-840d, heidenhain, fanuc, haas, linuxcnc (default: that of the control of the scene
    /// or machine, else by the ending of the output file)
    #[arg(long)]
    pub(crate) dialect: Option<String>,
    /// Program to write
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Columns are found by their names (time_s, X_command_mm, X_actual_mm, X_force_N, C_torque_Nm, block, \
                        override_percent), or named in a file of --columns. See docs/calibrate.md."
)]
pub(crate) struct CalibrateFitArgs {
    /// Folder of the scene, or its scene.toml
    pub(crate) scene: PathBuf,
    /// Recorded trace (CSV); may be repeated
    #[arg(long, value_name = "FILE", required = true)]
    pub(crate) trace: Vec<PathBuf>,
    /// TOML file that names the columns and their units
    #[arg(long, value_name = "FILE")]
    pub(crate) columns: Option<PathBuf>,
    /// Program that was recorded, where the trace has a column of its lines: for the times of tool changes,
    /// dwells and words
    #[arg(long, value_name = "FILE")]
    pub(crate) program: Option<PathBuf>,
    /// Machine file to write, in the folder of the machine file that it inherits from
    #[arg(long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Write all estimates with errors, correlations and reasons as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub(crate) force: bool,
}
