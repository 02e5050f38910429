use std::path::PathBuf;

use thiserror::Error;

/// A machine file that cannot be used.
#[derive(Debug, Error)]
pub enum MachineError {
    /// The file is missing or may not be read.
    #[error("cannot read {path}: {source}; give the machine's folder or its machine.toml")]
    Open {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A value in the file is wrong, missing or unknown.
    #[error(transparent)]
    Content(Box<ContentError>),
}

/// Place, value and remedy of a mistake in a machine file.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}:{line}:{column}: {key}: {message}; {remedy} [{code}]", file.display())]
pub struct ContentError {
    /// Stable name of the kind of mistake (`machine-parallel-rotary-axes`).
    pub code: &'static str,
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Path of the key, `joint.B.travel_deg`.
    pub key: String,
    /// What is wrong, with the value.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

impl From<Box<ContentError>> for MachineError {
    fn from(e: Box<ContentError>) -> Self {
        Self::Content(e)
    }
}
