use std::sync::Arc;

use thiserror::Error;

/// Why a CL file is not read: place, what is there, what to do.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{file}:{line}:{column}: {message} (help: {help})")]
pub struct ClError {
    /// File as given by the caller.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Column of the first character, from 1.
    pub column: u32,
    /// What is wrong, with the value.
    pub message: String,
    /// What to do about it.
    pub help: String,
}
