//! APT cutter location data.

use std::path::PathBuf;

use super::{Reader, unknown};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::settings::Settings;
use crate::source::Source;

/// The reader of a program.
pub(crate) fn open(
    source: Source,
    _folder: Option<PathBuf>,
    _settings: &Settings,
) -> Result<Box<dyn Reader>, Diagnostics> {
    Err(unknown(&source))
}

/// All faults of single lines.
pub(crate) fn line_faults(_source: &Source) -> Vec<Diagnostic> {
    Vec::new()
}
