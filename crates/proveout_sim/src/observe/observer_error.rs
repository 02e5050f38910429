//! Why an observer could not write.

use thiserror::Error;

/// Why an observer could not write what it saw.
#[derive(Debug, Error)]
#[error("cannot write {what}: {message}")]
pub struct ObserverError {
    /// File or stream.
    pub what: String,
    /// Reason.
    pub message: String,
}
