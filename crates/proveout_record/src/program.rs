//! The text of a re-scheduled program: findings of its run cite its lines.

use std::{fs, path::Path};

use proveout_sim::{
    Observer,
    observer::{Batch, ObserverError, Outcome, Setup},
};

use crate::error::RecordError;

/// Writes the text that runs into the run folder where it was made from another program, under the name that
/// findings give it, before the first block is run.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProgramObserver;

impl Observer for ProgramObserver {
    fn name(&self) -> &'static str {
        "program"
    }

    fn begin(&mut self, setup: &Setup<'_>, folder: &Path) -> Result<(), ObserverError> {
        let Some(made) = setup.made else { return Ok(()) };
        let path = folder.join(&made.file);
        Ok(fs::write(&path, &made.text).map_err(RecordError::io(&path))?)
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, _outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}
