//! Why a file of the run folder could not be written.

use std::path::{Path, PathBuf};

use proveout_sim::observer::ObserverError;
use thiserror::Error;

/// A file of the run folder could not be written.
#[derive(Debug, Error)]
pub enum RecordError {
    /// The operating system refused.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The Parquet or Arrow library refused the table.
    #[error("cannot write table {}: {message}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// What the library says.
        message: String,
    },
    /// The page could not be filled in.
    #[error("cannot fill in the report: {message}")]
    Page {
        /// What the template engine says, with its line.
        message: String,
    },
    /// A picture could not be encoded.
    #[error("cannot make the picture: {message}")]
    Picture {
        /// What the encoder says.
        message: String,
    },
    /// The recording could not be written or sent.
    #[error("cannot write the Rerun recording to {target}: {message}{}", remedy_text(remedy))]
    Recording {
        /// File or viewer.
        target: String,
        /// What the library says.
        message: String,
        /// What to do about it.
        remedy: Option<&'static str>,
    },
}

#[allow(clippy::ref_option, reason = "the error macro hands out a reference to the field")]
fn remedy_text(remedy: &Option<&'static str>) -> String {
    remedy.map_or_else(String::new, |r| format!(" ({r})"))
}

impl RecordError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Io { path: path.to_path_buf(), source }
    }

    pub(crate) fn table<E: std::fmt::Display>(path: &Path) -> impl FnOnce(E) -> Self + '_ {
        move |e| Self::Table { path: path.to_path_buf(), message: e.to_string() }
    }
}
impl From<RecordError> for ObserverError {
    fn from(e: RecordError) -> Self {
        let what = match &e {
            RecordError::Io { path, .. } | RecordError::Table { path, .. } => path.display().to_string(),
            RecordError::Page { .. } => "report.html".into(),
            RecordError::Picture { .. } => "picture".into(),
            RecordError::Recording { target, .. } => target.clone(),
        };
        let message = match &e {
            RecordError::Io { source, .. } => source.to_string(),
            RecordError::Table { message, .. } | RecordError::Page { message } | RecordError::Picture { message } => {
                message.clone()
            }
            RecordError::Recording { message, remedy, .. } => format!("{message}{}", remedy_text(remedy)),
        };
        Self { what, message }
    }
}
