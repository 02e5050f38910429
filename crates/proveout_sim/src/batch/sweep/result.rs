//! What a job of a sweep gives: one small file, under the digest of the job.

use std::{
    collections::BTreeMap,
    io,
    path::{Path, PathBuf},
};

use proveout_input::read_regular_text;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    file::KeepFile,
    plan::{Plan, Planned, job_folder, made_by, replace},
};
use crate::{
    evidence::{digest, manifest::verify_files},
    run::shards::ShardCost,
    verdict::{
        finding::Severity,
        verdict_file::{State, Verdict},
    },
};

/// Result of a job, in its folder.
pub const RESULT: &str = "result.json";
/// Verdict of a job, in its folder or in that of its run.
const VERDICT: &str = "verdict.json";
/// Run folder of a job that keeps it.
const RUN: &str = "run";
/// Largest result that is read.
const MAX_BYTES: u64 = 4 << 20;

/// What became of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JobState {
    /// Its verdict is pass.
    Pass,
    /// Its verdict is fail.
    Fail,
    /// Its verdict is unchecked.
    Unchecked,
    /// Scene, control or method refuse its values: there is no run.
    Refused,
    /// A shard of a run, cut; the verdict comes with the merge.
    Cut,
}

impl JobState {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Unchecked => "unchecked",
            Self::Refused => "refused",
            Self::Cut => "cut",
        }
    }
}

/// Figures by name, with the unit at its end; null where a run has none.
pub type Figures = BTreeMap<String, Option<f64>>;

/// `result.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobResult {
    /// Number, from 0.
    pub job: usize,
    /// Digest of the job.
    pub digest: String,
    /// Program and version.
    pub made_by: String,
    /// Its values.
    pub values: serde_json::Map<String, serde_json::Value>,
    /// What became of it.
    pub state: JobState,
    /// Why it was refused; empty elsewhere.
    pub refused: String,
    /// Gates that do not pass, with their state.
    pub gates: BTreeMap<String, State>,
    /// Its figures.
    pub figures: Figures,
    /// SHA-256 of `verdict.json`, or of the cuts of a shard; empty where it was refused.
    pub verdict_sha256: String,
    /// SHA-256 of the above.
    pub check: String,
}

/// Why a result cannot be merged.
#[derive(Debug, Error)]
pub enum ResultFault {
    /// The job was not run, or not to its end.
    #[error("job {0} has no result")]
    Missing(usize),
    /// It is of another plan: an input, a value or the version has changed.
    #[error("the result of job {0} is of an earlier plan")]
    Other(usize),
    /// It was changed after the run, or half of it is lost.
    #[error("the result of job {job} is damaged: {message} ({})", path.display())]
    Damaged {
        /// The job.
        job: usize,
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
}

/// The result of a job from its verdict (`verdict.json` as it was written), or from why it was refused.
pub fn result_of(job: &Planned, outcome: Result<(&Verdict, &[u8]), String>) -> JobResult {
    let mut result = JobResult {
        job: job.job,
        digest: job.digest.clone(),
        made_by: made_by(),
        values: job.values.clone(),
        state: JobState::Refused,
        refused: String::new(),
        gates: BTreeMap::new(),
        figures: Figures::new(),
        verdict_sha256: String::new(),
        check: String::new(),
    };
    match outcome {
        Err(why) => result.refused = why,
        Ok((verdict, bytes)) => {
            result.state = match verdict.verdict {
                State::Pass => JobState::Pass,
                State::Fail => JobState::Fail,
                State::Unchecked | State::NotAsked => JobState::Unchecked,
            };
            let open = verdict.gates.iter().filter(|g| g.state != State::Pass);
            result.gates = open.map(|g| (g.gate.name().to_owned(), g.state)).collect();
            result.figures = figures(verdict);
            result.verdict_sha256 = digest::of_bytes(bytes);
        }
    }
    result.check = result.own_check();
    result
}

/// The result of a shard: `cuts` are its own, on disk.
///
/// # Errors
/// What the system says when they are read.
pub fn result_of_shard(job: &Planned, cost: &ShardCost, cuts: &Path) -> io::Result<JobResult> {
    let mut result = result_of(job, Err(String::new()));
    result.state = JobState::Cut;
    result.figures = [("pieces", cost.pieces), ("cuts_bytes", cost.bytes)]
        .map(|(name, count)| (name.to_owned(), Some(count as f64)))
        .into();
    result.verdict_sha256 = digest::measure(cuts)?.1;
    result.check = result.own_check();
    Ok(result)
}

/// Figures of a verdict in a flat table.
fn figures(v: &Verdict) -> Figures {
    let mut all = Figures::new();
    let mut put = |name: &str, value: Option<f64>| {
        // The sum of nothing is -0.
        all.insert(name.to_owned(), value.filter(|v| v.is_finite()).map(|v| v + 0.0));
    };
    put("time_s", Some(v.time.total_s));
    put("cutting_s", Some(v.time.cutting_s));
    put("rapid_s", Some(v.time.rapid_s));
    put("lower_bound_s", v.time.lower_bound_s);
    put("path_mm", Some(v.path.length_mm));
    put("blocks", Some(v.path.blocks as f64));
    put("contour_error_mm", v.path.max_contour_error_mm);
    put("min_feed_ratio", v.path.min_feed_ratio);
    put("removed_mm3", Some(v.removal.volume_mm3));
    put("stock_left_mm3", Some(v.removal.stock_left_mm3));
    put("cell_mm", Some(v.removal.cell_mm));
    put("gouge_mm", v.deviation.gouge_max_mm);
    put("excess_mm", v.deviation.excess_max_mm);
    put("rms_mm", v.deviation.rms_mm);
    put("scallop_um", v.surface.scallop_max_um);
    put("scallop_p95_um", v.surface.scallop_p95_um);
    put("clearance_mm", v.clearance.min_mm);
    for (name, spread) in [
        ("ra_um", &v.surface.ra_um),
        ("rz_um", &v.surface.rz_um),
        ("sa_um", &v.surface.sa_um),
        ("sz_um", &v.surface.sz_um),
    ] {
        put(name, spread.as_ref().map(|s| s.max));
    }
    for texture in &v.surface.textures {
        put(&format!("{}_sa_um", texture.name), texture.sa_um);
        put(&format!("{}_sz_um", texture.name), texture.sz_um);
        for (k, profile) in texture.profiles.iter().enumerate() {
            put(&format!("{}_profile{}_ra_um", texture.name, k + 1), profile.ra_um.map(|r| r[1]));
            put(&format!("{}_profile{}_rz_um", texture.name, k + 1), profile.rz_um.map(|r| r[1]));
        }
    }
    for (name, axis) in &v.axes {
        let unit = axis.unit.name();
        put(&format!("{name}_max_velocity_{unit}_s"), Some(axis.max_velocity));
        put(&format!("{name}_max_acceleration_{unit}_s2"), Some(axis.max_acceleration));
        put(&format!("{name}_max_jerk_{unit}_s3"), Some(axis.max_jerk));
        put(&format!("{name}_reversals"), Some(axis.reversals as f64));
    }
    let count = |severity: Severity| {
        let found = v.findings.iter().filter(|f| f.severity == severity);
        Some(found.map(|f| 1.0 + f64::from(f.repeats)).sum())
    };
    put("errors", count(Severity::Error));
    put("warnings", count(Severity::Warning));
    all
}

impl JobResult {
    fn own_check(&self) -> String {
        let bare = Self { check: String::new(), ..self.clone() };
        serde_json::to_string_pretty(&bare).map(|text| digest::of_bytes(text.as_bytes())).unwrap_or_default()
    }
}

/// Writes the result of a job: whole, or not at all.
///
/// # Errors
/// What the system says.
pub fn write_result(sweep: &Path, result: &JobResult) -> io::Result<()> {
    let text = serde_json::to_string_pretty(result)? + "\n";
    replace(&job_folder(sweep, result.job).join(RESULT), &text)
}

/// Holds the verdict that a job keeps against its result; a whole run folder against its manifest too. The
/// cuts of a shard are not looked at: whoever merges them does it.
///
/// # Errors
/// [`ResultFault::Damaged`]: a file that is gone, or not as the job wrote it.
pub fn check_verdict(sweep: &Path, plan: &Plan, result: &JobResult) -> Result<(), ResultFault> {
    if matches!(result.state, JobState::Refused | JobState::Cut) {
        return Ok(());
    }
    let at = job_folder(sweep, result.job);
    let folder = match plan.keep {
        KeepFile::Verdict => at,
        KeepFile::Folder => at.join(RUN),
    };
    let path = folder.join(VERDICT);
    let damaged = |path: &Path, message: String| ResultFault::Damaged { job: result.job, path: path.into(), message };
    let now = digest::measure(&path).map_err(|e| damaged(&path, format!("its verdict cannot be read: {e}")))?.1;
    if now != result.verdict_sha256 {
        return Err(damaged(&path, "its verdict has changed since the job wrote it".into()));
    }
    if plan.keep == KeepFile::Folder {
        let found = verify_files(&folder).map_err(|e| damaged(&folder, e.to_string()))?;
        if let Some(what) = found.changed_files.into_iter().next() {
            return Err(damaged(&folder, format!("its run folder has changed since the job wrote it: {what}")));
        }
    }
    Ok(())
}

/// The result of a job, if it is that of the plan.
///
/// # Errors
/// [`ResultFault`]: there is none, it is of another plan, or damaged.
pub fn read_result(sweep: &Path, plan: &Plan, job: usize) -> Result<JobResult, ResultFault> {
    let path = job_folder(sweep, job).join(RESULT);
    let text = match read_regular_text(&path, MAX_BYTES) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Err(ResultFault::Missing(job)),
        other => other.map_err(|e| ResultFault::Damaged { job, path: path.clone(), message: e.to_string() })?,
    };
    let damaged = |message: String| ResultFault::Damaged { job, path: path.clone(), message };
    let result: JobResult = serde_json::from_str(&text).map_err(|e| damaged(e.to_string()))?;
    if result.check != result.own_check() {
        return Err(damaged("it has changed since it was written".into()));
    }
    if result.job != job {
        return Err(damaged(format!("it is that of job {}", result.job)));
    }
    if plan.jobs.get(job) != Some(&result.digest) || result.made_by != plan.made_by {
        return Err(ResultFault::Other(job));
    }
    Ok(result)
}
