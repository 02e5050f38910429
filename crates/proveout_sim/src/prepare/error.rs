//! Everything that keeps a run from being made, with its place and remedy.

use std::path::PathBuf;

use proveout_collision::CollisionError;
use proveout_controller::{ControlError, RunError};
use proveout_geom::{MeshError, MeshFileError};
use proveout_input::InputError;
use proveout_nc::{ControlFileError, Diagnostic, Diagnostics, post::PostError};
use proveout_step::StepError;
use proveout_stock::StockError;
use thiserror::Error;

use crate::{
    cut::{journal_error::JournalError, shard_records::ShardError},
    observe::observer_error::ObserverError,
};

/// Why there is no verdict.
#[derive(Debug, Error)]
pub enum SimError {
    /// Scene, machine, tool library, sections of a blade: file and place.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Control file.
    #[error(transparent)]
    ControlFile(#[from] Box<ControlFileError>),
    /// NC program: everything that was found wrong with its text, or the fault that stopped it.
    #[error(transparent)]
    Program(#[from] Diagnostics),
    /// Mesh file that is given to a command and cannot be read.
    #[error(transparent)]
    MeshFile(#[from] MeshFileError),
    /// STEP file that is given to a command and cannot be read.
    #[error(transparent)]
    Step(#[from] StepError),
    /// Mesh that bounds no solid.
    #[error("{}: {source}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// The defect.
        source: MeshError,
    },
    /// Stock that cannot be made.
    #[error("stock: {0}")]
    Stock(#[from] StockError),
    /// The stock has grown beyond what was announced.
    #[error(
        "the stock takes {used_mib:.0} MiB at {time_s:.1} s of the program, more than the {announced_mib:.0} MiB planned for it: its rays hold {intervals:.2} intervals of material on average"
    )]
    Memory {
        /// What it takes, MiB.
        used_mib: f64,
        /// What it was announced with, MiB.
        announced_mib: f64,
        /// Intervals on a ray, as a mean over all rays.
        intervals: f64,
        /// Time of the program, s.
        time_s: f64,
        /// What to write into the scene.
        remedy: String,
    },
    /// Bodies that cannot be checked.
    #[error(transparent)]
    Collision(#[from] CollisionError),
    /// Program that the control cannot execute.
    #[error("{0}")]
    Control(Box<ControlError>),
    /// Program that cannot be written in the language that is asked for.
    #[error(transparent)]
    Post(#[from] PostError),
    /// File that cannot be written.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// Journal of a run.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Motion or cuts of a run in shards.
    #[error(transparent)]
    Shard(#[from] ShardError),
    /// Place at which no run stops.
    #[error("{message}")]
    StopAt {
        /// What is wrong.
        message: String,
        /// What to do.
        help: String,
    },
    /// Run folder.
    #[error("run folder: {0}")]
    Folder(std::io::Error),
}

impl From<Diagnostic> for SimError {
    fn from(d: Diagnostic) -> Self {
        Self::Program(d.into())
    }
}

impl From<Box<ControlError>> for SimError {
    fn from(e: Box<ControlError>) -> Self {
        Self::Control(e)
    }
}

pub(crate) fn from_run_error(e: RunError<Diagnostic>) -> SimError {
    match e {
        RunError::Program(d) => SimError::from(d),
        RunError::Control(c) => SimError::Control(c),
    }
}
