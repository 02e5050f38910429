//! Why a run cannot keep a journal, or resume from one.

use std::path::PathBuf;

use thiserror::Error;

/// Why a run cannot keep a journal, or go on with one.
#[derive(Debug, Error)]
pub enum JournalError {
    /// There is none.
    #[error("{} is not there: there is no stopped run to resume", path.display())]
    Missing {
        /// Where it would be.
        path: PathBuf,
    },
    /// The system refuses.
    #[error("{} cannot be {what}: {source}", path.display())]
    System {
        /// The journal.
        path: PathBuf,
        /// `read`, `made`.
        what: &'static str,
        /// What it said.
        source: std::io::Error,
    },
    /// Another process has it.
    #[error("{} is in use: another run is writing to this run folder", path.display())]
    InUse {
        /// The journal.
        path: PathBuf,
    },
    /// It is something else, or of another layout.
    #[error("{} is not a journal that this version can read", path.display())]
    NoJournal {
        /// The file.
        path: PathBuf,
    },
    /// The run that was stopped was another one.
    #[error("the stopped run does not match this one: {what} was {then}, and is now {now}")]
    Other {
        /// What differs.
        what: String,
        /// With what it was begun.
        then: String,
        /// What it is in this call.
        now: String,
    },
    /// The journal does not fit the run, though all inputs are the same.
    #[error("{} does not match this run: {what}", path.display())]
    Unfit {
        /// The journal.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}
