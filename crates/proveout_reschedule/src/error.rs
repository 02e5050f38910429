use thiserror::Error;

/// Why a run cannot be re-scheduled: the first block concerned, what is wrong there, what would have to
/// change.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("line {line}: {message}")]
pub struct RescheduleError {
    /// Stable code: `reschedule-channel`, `reschedule-layers`, `reschedule-tool`, `reschedule-option`,
    /// `reschedule-path`.
    pub code: &'static str,
    /// Line of the first block concerned; 0 where no block is.
    pub line: u32,
    /// What is wrong, with value and limit.
    pub message: String,
    /// What would have to change.
    pub help: String,
}

impl RescheduleError {
    pub(crate) fn new(code: &'static str, line: u32, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { code, line, message: message.into(), help: help.into() }
    }
}
