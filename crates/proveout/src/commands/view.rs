use std::{path::Path, process::Command};

use crate::failure::Failure;

/// Opens the recording of a run folder in the Rerun viewer.
pub(crate) fn view(run: &Path) -> Result<(), Failure> {
    let recording = run.join("recording.rrd");
    if !recording.is_file() {
        return Err(Failure::new(format!("{} does not exist", recording.display()))
            .with_help("run the scene with `--rerun file` (the default), then name its run folder"));
    }
    let status = Command::new("rerun").arg(&recording).status().map_err(|e| {
        Failure::new(format!("the Rerun viewer cannot be started: {e}"))
            .with_help("install it with `pip install rerun-sdk==0.36.3` or `cargo install rerun-cli --version 0.36.3`")
    })?;
    if status.success() { Ok(()) } else { Err(Failure::new(format!("the viewer exited with {status}"))) }
}
