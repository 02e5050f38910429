//! Heidenhain TNC: Klartext and DIN/ISO.

use std::path::PathBuf;

use super::{Reader, unknown};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::settings::{Dialect, Settings};
use crate::source::Source;

/// The reader of a program.
pub(crate) fn open(
    _dialect: Dialect,
    source: Source,
    _folder: Option<PathBuf>,
    _settings: &Settings,
) -> Result<Box<dyn Reader>, Diagnostics> {
    Err(unknown(&source))
}

/// All faults of single lines.
pub(crate) fn line_faults(_dialect: Dialect, _source: &Source) -> Vec<Diagnostic> {
    Vec::new()
}
