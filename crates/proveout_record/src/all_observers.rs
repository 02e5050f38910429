//! All observers together.

use proveout_sim::Observer;

use crate::{
    ClearanceObserver, FreeAxesObserver, GltfObserver, JsonObserver, MapFilesObserver, ProgramObserver, RecordError,
    ReportObserver, RerunMode, SetupSheetObserver, StockObserver, TableObserver,
};

/// The observers that write a whole run folder (but `run.json`, which is known only after them).
///
/// # Errors
/// [`RecordError::Recording`] when a recording is asked for and this build has none.
pub fn observers(rerun: &RerunMode) -> Result<Vec<Box<dyn Observer>>, RecordError> {
    let mut all: Vec<Box<dyn Observer>> = vec![
        Box::new(JsonObserver),
        Box::new(ProgramObserver),
        Box::<TableObserver>::default(),
        Box::new(ClearanceObserver),
        Box::<MapFilesObserver>::default(),
        Box::<FreeAxesObserver>::default(),
        Box::new(StockObserver),
        Box::<GltfObserver>::default(),
        Box::<ReportObserver>::default(),
        Box::<SetupSheetObserver>::default(),
    ];
    if *rerun != RerunMode::Off {
        all.push(recording(rerun)?);
    }
    Ok(all)
}

#[cfg(feature = "rerun")]
#[allow(clippy::unnecessary_wraps, reason = "without the feature it fails")]
fn recording(rerun: &RerunMode) -> Result<Box<dyn Observer>, RecordError> {
    Ok(Box::new(crate::RerunObserver::new(rerun.clone())))
}

#[cfg(not(feature = "rerun"))]
fn recording(_rerun: &RerunMode) -> Result<Box<dyn Observer>, RecordError> {
    Err(RecordError::Recording {
        target: "recording".into(),
        message: "this build has no Rerun support".into(),
        remedy: Some("build with the feature `rerun`, or run with `--rerun off`"),
    })
}
