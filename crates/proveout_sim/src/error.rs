//! Everything that keeps a run from being made, with its place and remedy.

use std::path::PathBuf;

use proveout_collision::CollisionError;
use proveout_controller::ControlError;
use proveout_geom::{MeshError, MeshFileError};
use proveout_machine::MachineError;
use proveout_nc::post::PostError;
use proveout_nc::{Diagnostic, Diagnostics};
use proveout_stock::StockError;
use proveout_tool::ToolError;
use thiserror::Error;

use crate::{config::ConfigError, observer::ObserverError};

/// Why there is no verdict.
#[derive(Debug, Error)]
pub enum SimError {
    /// Scene file.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// NC program: everything that was found wrong with its text, or the fault that stopped it.
    #[error(transparent)]
    Program(#[from] Diagnostics),
    /// Machine file.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// Tool library.
    #[error(transparent)]
    Tools(#[from] ToolError),
    /// Mesh file that cannot be read.
    #[error(transparent)]
    MeshFile(#[from] MeshFileError),
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
