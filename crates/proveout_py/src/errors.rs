//! Faults as exceptions of `proveout.errors`.

use std::any::Any;

use proveout::front::{CommandError, FaultKind};
use pyo3::{prelude::*, types::PyDict};

/// The exception of a fault, with its parts as attributes.
pub(crate) fn raised(py: Python<'_>, fault: &CommandError) -> PyErr {
    let class = match fault.kind() {
        FaultKind::Input => "InputError",
        FaultKind::Program => "ProgramError",
        FaultKind::Control => "ControlError",
        FaultKind::Folder => "FolderError",
    };
    let made = || -> PyResult<Bound<'_, PyAny>> {
        let parts = PyDict::new(py);
        if let Some((file, line, column)) = fault.place() {
            parts.set_item("file", file)?;
            parts.set_item("line", Some(line).filter(|l| *l > 0))?;
            parts.set_item("column", Some(column).filter(|c| *c > 0))?;
        }
        parts.set_item("remedy", fault.remedy())?;
        parts.set_item("text", fault.to_string())?;
        py.import("proveout.errors")?.getattr(class)?.call((fault.message(),), Some(&parts))
    };
    made().map_or_else(|e| e, PyErr::from_value)
}

/// The exception of a call that is wrong.
pub(crate) fn wrong(py: Python<'_>, message: impl std::fmt::Display, remedy: &str) -> PyErr {
    raised(py, &CommandError::new(message, remedy))
}

/// The exception of a fault of this program.
pub(crate) fn internal(py: Python<'_>, payload: &(dyn Any + Send)) -> PyErr {
    let text = payload.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
    let made = || py.import("proveout.errors")?.getattr("InternalError")?.call1((text,));
    made().map_or_else(|e| e, PyErr::from_value)
}
