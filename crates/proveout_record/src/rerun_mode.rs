//! Where the recording for the Rerun viewer goes.

/// Where the recording goes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum RerunMode {
    /// No recording.
    Off,
    /// `recording.rrd` in the run folder.
    #[default]
    File,
    /// A viewer is started (`rerun` must be on the path) and shows the run while it goes on.
    Spawn,
    /// A viewer that listens on this host (`rerun` started beforehand) shows the run while it goes on.
    Connect,
}

/// Name of the recording in a run folder.
pub const RECORDING_FILE: &str = "recording.rrd";
