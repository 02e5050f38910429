//! `verdict.json` and `run.json`.

use std::{collections::BTreeMap, fs, path::Path};

use proveout_sim::{
    Observer,
    observer::{Batch, ObserverError, Outcome, Setup},
};
use serde::Serialize;

use crate::error::RecordError;

/// Writes a value as indented JSON with a newline at the end. Keys keep the order of the type, numbers are
/// the shortest that read back as the same double: same value, same bytes. Numbers that JSON lacks (infinite,
/// not a number) become `null`.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), RecordError> {
    let mut text = serde_json::to_string_pretty(value).map_err(|e| RecordError::io(path)(e.into()))?;
    text.push('\n');
    fs::write(path, text).map_err(RecordError::io(path))
}

/// What a run costs on its host (`run.json`): everything that may differ between two runs of the same inputs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunInfo {
    /// The scene, as an absolute path.
    pub scene: String,
    /// The call.
    pub command: Vec<String>,
    /// Wall time from the call to the written files, s.
    pub wall_s: f64,
    /// Time of all processor cores, s; none where the host does not report it.
    pub cpu_s: Option<f64>,
    /// Threads of the run.
    pub threads: usize,
    /// Largest resident memory, MiB; none where the host does not report it.
    pub peak_rss_mib: Option<f64>,
    /// Memory that was announced before the stock was made, MiB; none where several runs share the process.
    pub announced_mib: Option<f64>,
    /// Memory of the stock, and of each patch by its name, at the end of the run, MiB.
    pub stock_mib: BTreeMap<String, f64>,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Simulated over wall time.
    pub realtime_factor: f64,
    /// Swept motion pieces a second of wall time.
    pub moves_per_s: f64,
    /// Wall time of each stage.
    pub stages: StageTimes,
    /// How the checks of bodies were settled.
    pub checks: CheckCounts,
    /// Versions by name: `proveout`, `rustc`, libraries that matter.
    pub versions: BTreeMap<String, String>,
    /// Facts about the host: `os`, `arch`, `cpu`, `cores`.
    pub host: BTreeMap<String, String>,
}

/// Wall time of the stages of a run, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StageTimes {
    /// Reading scene, machine, tools and meshes, making the stock.
    pub read_s: f64,
    /// Reading the program and planning its motion.
    pub plan_s: f64,
    /// Axis dynamics.
    pub servo_s: f64,
    /// Sweeping the stock.
    pub removal_s: f64,
    /// Interference; runs in parallel with the removal.
    pub collision_s: f64,
    /// Surface, deviation, inspection.
    pub surface_s: f64,
    /// Observers.
    pub record_s: f64,
}

/// How the checks of bodies were settled, from the cheapest to the dearest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CheckCounts {
    /// Pieces of motion that were checked, bodies against bodies.
    pub pieces: u64,
    /// Share of them that one comparison settled for all pairs, 0 to 1.
    pub share_by_one_comparison: f64,
    /// Pairs that were looked at one by one in the other pieces.
    pub pairs: u64,
    /// Those of them that one comparison settled.
    pub pairs_by_one_comparison: u64,
    /// Queries that ended with "farther than is needed", and a proved distance.
    pub queries_farther: u64,
    /// Queries that ended with a distance.
    pub queries_distance: u64,
    /// Motions that were followed against the stock.
    pub stock_motions: u64,
    /// Distances from its rays that were asked for.
    pub stock_queries: u64,
    /// Stretches of motion that were looked at for the least clearance of each pair.
    pub clearance_looks: u64,
}

/// Writes `run.json` into a run folder.
///
/// # Errors
/// [`RecordError::Io`] with the path.
pub fn write_run_json(folder: &Path, info: &RunInfo) -> Result<(), RecordError> {
    write_json(&folder.join("run.json"), info)
}

/// Writes `verdict.json` at the end of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct JsonObserver;

impl Observer for JsonObserver {
    fn name(&self) -> &'static str {
        "json"
    }

    fn begin(&mut self, _setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, _batch: &Batch<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(write_json(&outcome.folder.join("verdict.json"), outcome.verdict)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn run_json_has_the_agreed_keys_and_a_last_newline() {
        let folder = tempfile::tempdir().expect("folder");
        let info = RunInfo { wall_s: 0.1 + 0.2, peak_rss_mib: Some(f64::NAN), ..RunInfo::default() };
        write_run_json(folder.path(), &info).expect("written");
        let text = fs::read_to_string(folder.path().join("run.json")).expect("there");
        assert!(text.ends_with("}\n"));
        let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let keys: Vec<&String> = value.as_object().expect("object").keys().collect();
        assert_eq!(
            keys,
            [
                "scene",
                "command",
                "wall_s",
                "cpu_s",
                "threads",
                "peak_rss_mib",
                "announced_mib",
                "stock_mib",
                "simulated_s",
                "realtime_factor",
                "moves_per_s",
                "stages",
                "checks",
                "versions",
                "host"
            ]
        );
        assert_eq!(value["wall_s"].as_f64(), Some(0.1 + 0.2), "the same double");
        assert!(value["peak_rss_mib"].is_null());
    }
}
