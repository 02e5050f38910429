//! `stock.dexel` and `stock-patch-NAME.dexel`: the stock that is left, for the next setup.

use std::{
    fs::File,
    io::{BufWriter, Error},
    path::Path,
};

use proveout_sim::{
    Observer, STOCK_FILE,
    observer::{Batch, ObserverError, Outcome, Setup},
    patch_file,
};
use proveout_stock::{StockFileError, TriDexel};

use crate::error::RecordError;

/// Writes the stock that is left, with its history where the scene keeps one; the layout is in
/// `docs/stock-file.md`.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub fn write_stock(path: &Path, stock: &TriDexel) -> Result<(), RecordError> {
    let mut file = BufWriter::new(File::create(path).map_err(RecordError::io(path))?);
    stock.save(&mut file).map_err(|e| {
        RecordError::io(path)(match e {
            StockFileError::Io { source, .. } => source,
            other => Error::other(other.to_string()),
        })
    })
}

/// Writes `stock.dexel` at the end of the run, and one file more for each patch.
#[derive(Clone, Copy, Debug, Default)]
pub struct StockObserver;

impl Observer for StockObserver {
    fn name(&self) -> &'static str {
        "stock"
    }

    fn begin(&mut self, _setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        write_stock(&outcome.folder.join(STOCK_FILE), outcome.stock)?;
        for patch in outcome.patches {
            write_stock(&outcome.folder.join(patch_file(patch.name())), patch.stock())?;
        }
        Ok(())
    }
}
