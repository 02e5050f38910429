use proveout_nc::Location;
use thiserror::Error;

/// Why the control refuses to go on: what, where in the program, and what to do about it.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{}{message}{}", place(.location.as_ref()), remedy(.help.as_ref()))]
pub struct ControlError {
    /// Stable code (`control-axis`, `control-tool`, ...).
    pub code: &'static str,
    /// What is wrong, with value and limit.
    pub message: String,
    /// Place in the program; none when the fault lies in machine or settings.
    pub location: Option<Location>,
    /// What to do about it.
    pub help: Option<String>,
}

fn place(location: Option<&Location>) -> String {
    location.map(|l| format!("{}:{}:{}: ", l.file, l.line, l.column)).unwrap_or_default()
}

fn remedy(help: Option<&String>) -> String {
    help.map(|h| format!(" (help: {h})")).unwrap_or_default()
}

impl ControlError {
    pub(crate) fn at(location: &Location, code: &'static str, message: String, help: &str) -> Self {
        Self { code, message, location: Some(location.clone()), help: Some(help.to_owned()) }
    }
}

/// Why a run ended early: the program text or the control.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RunError<E: std::error::Error + 'static> {
    /// The source of commands reported a fault; passed through unchanged.
    #[error(transparent)]
    Program(E),
    /// The control refused a command.
    #[error(transparent)]
    Control(#[from] Box<ControlError>),
}
