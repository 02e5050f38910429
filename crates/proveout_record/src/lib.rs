//! Observers: Rerun, HTML report, glTF, Parquet, JSON.
mod color;
mod encode;
mod envelope;
mod error;
mod glb;
mod json;
mod mode;
mod part;
mod picture;
#[cfg(feature = "rerun")]
mod recording;
mod report;
mod table;
mod tables;
mod units;

pub use color::{DeviationMap, Rgba};
pub use error::RecordError;
pub use json::{JsonObserver, RunInfo, StageTimes, write_json, write_run_json};
pub use mode::{RECORDING_FILE, RerunMode};
pub use part::{GltfObserver, write_part_files};
#[cfg(feature = "rerun")]
pub use recording::RerunObserver;
pub use report::ReportObserver;
pub use tables::{TableObserver, write_surface_table};
