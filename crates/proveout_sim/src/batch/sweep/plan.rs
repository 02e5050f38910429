//! The plan of a sweep on disk: what every job is, before any is run.

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
};

use proveout_input::{InputError, read_regular_text};
use serde::{Deserialize, Serialize};

use super::file::{KeepFile, Sweep};
use crate::{
    evidence::{
        digest,
        manifest::{Listed, relative},
    },
    prepare::{choice::Choice, error::SimError, memory::Recorded, prepared::Prepared, set_value::SetValue},
    run::shards::{MOTION, MotionPlan, plan_motion, raw_files},
    scene::ChoiceValueFile,
};

/// The plan, in the folder of a sweep.
pub const PLAN: &str = "plan.json";
/// Folder of its jobs.
pub const JOBS: &str = "jobs";
/// A job, in its folder.
pub const JOB: &str = "job.json";
/// Version of the layout of plan and jobs.
const VERSION: u32 = 2;
/// Largest plan that is read: a million digests.
const MAX_BYTES: u64 = 128 << 20;
/// Largest job that is read.
const MAX_JOB_BYTES: u64 = 16 << 20;

/// `plan.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Layout of this file.
    pub plan_version: u32,
    /// Program and version that planned, and alone may run and merge.
    pub made_by: String,
    /// Name of the sweep.
    pub name: String,
    /// What varies.
    pub keys: Vec<String>,
    /// What is kept of every run.
    pub keep: KeepFile,
    /// The jobs are this many shards of a single run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shards: Option<u16>,
    /// Digests of the jobs in order.
    pub jobs: Vec<String>,
    /// SHA-256 of the above.
    pub check: String,
}

/// `job.json`: all that a job depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Planned {
    /// Number, from 0.
    pub job: usize,
    /// Program and version.
    pub made_by: String,
    /// Scene, from the folder of the sweep's results.
    pub scene: String,
    /// What varies, in the order of the keys.
    pub values: serde_json::Map<String, serde_json::Value>,
    /// The shard that is cut, from 0, and of how many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<[u16; 2]>,
    /// Files that are read, with SHA-256; paths from the folder of the sweep's results.
    pub inputs: Vec<Listed>,
    /// SHA-256 of the above.
    pub digest: String,
}

/// What a call for a plan did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlanReport {
    /// Jobs of the plan.
    pub jobs: usize,
    /// Those that are as they were planned before.
    pub as_before: usize,
    /// Folders of jobs of an earlier, longer plan, which stay.
    pub left_over: usize,
    /// The motion of a run in shards.
    pub motion: Option<MotionPlan>,
}

/// Folder of a job.
pub fn job_folder(sweep: &Path, job: usize) -> PathBuf {
    sweep.join(JOBS).join(format!("{job:05}"))
}

/// This program and its version.
pub(super) fn made_by() -> String {
    format!("proveout {}", env!("CARGO_PKG_VERSION"))
}

/// What the job chooses; paths of values are from `folder`.
fn choice(values: &[SetValue], folder: &Path) -> Choice {
    let mut choice = Choice { recorded: Recorded::Folder, ..Choice::default() };
    for value in values {
        match (value.key.as_str(), &value.value) {
            ("program", ChoiceValueFile::Word(name)) => choice.program = Some(name.clone()),
            ("nc", ChoiceValueFile::Word(name)) => choice.nc = Some(folder.join(name)),
            _ => choice.set.push(value.clone()),
        }
    }
    choice
}

/// Writes the plan of a sweep into `out`. Jobs that are planned there already, and have not changed, stay as
/// they are with their results.
///
/// Files are looked up once for all jobs that have the same words (names of programs, machines, files):
/// numbers do not choose files.
///
/// # Errors
/// An input that cannot be read, a scene that refuses its values, a folder that cannot be written.
pub fn plan(sweep: &Sweep, out: &Path) -> Result<PlanReport, SimError> {
    let folder_fault = |e: io::Error| SimError::Folder(e);
    check_place(out)?;
    fs::create_dir_all(out.join(JOBS)).map_err(folder_fault)?;
    let scene = sweep.scene();
    let scene_shown = relative(out, &scene);
    let mut files: BTreeMap<String, Vec<Listed>> = BTreeMap::new();
    let shards = sweep.file.shards.as_ref().map(|n| *n.get_ref());
    let jobs = shards.map_or(sweep.design.len(), usize::from);
    let mut plan = Plan {
        plan_version: VERSION,
        made_by: made_by(),
        name: sweep.file.name.clone(),
        keys: sweep.design.keys().to_vec(),
        keep: sweep.file.keep.unwrap_or_default(),
        shards,
        jobs: Vec::with_capacity(jobs),
        check: String::new(),
    };
    let mut report = PlanReport { jobs, ..PlanReport::default() };
    for job in 0..jobs {
        let values = sweep.design.job(if shards.is_some() { 0 } else { job });
        let is_word = |v: &&SetValue| matches!(v.value, ChoiceValueFile::Word(_));
        let words: Vec<SetValue> = values.iter().filter(is_word).cloned().collect();
        let group = words.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
        let inputs = match files.get(&group) {
            Some(inputs) => inputs.clone(),
            None => {
                let read = |values: &[SetValue]| Prepared::read(&scene, &choice(values, &sweep.folder));
                // A job whose numbers are refused is a result; the files are then those of the scene's own
                // numbers. Of a single run in shards it is the end.
                let prepared = match read(&values) {
                    Ok(prepared) => prepared,
                    Err(refused) if shards.is_some() => return Err(refused),
                    Err(refused) => read(&words).ok().ok_or(refused)?,
                };
                let mut inputs = listed(&prepared, out);
                if let Some(shards) = shards {
                    report.motion = Some(plan_motion(prepared, shards, out, |k| job_folder(out, usize::from(k)))?);
                    inputs.push(own_file(out, "motion", MOTION)?);
                }
                files.entry(group).or_insert(inputs).clone()
            }
        };
        let mut inputs = inputs;
        for name in report.motion.iter().flat_map(|m| raw_files(m.patches)) {
            inputs.push(own_file(out, "raw stock", &format!("{JOBS}/{job:05}/{name}"))?);
        }
        let values = values
            .iter()
            .map(|v| {
                let path = matches!((v.key.as_str(), &v.value), ("nc", ChoiceValueFile::Word(_)));
                let own = if path { relative(out, &sweep.folder.join(v.value.exact())).into() } else { v.value.json() };
                (v.key.clone(), own)
            })
            .collect();
        let mut planned = Planned {
            job,
            made_by: made_by(),
            scene: scene_shown.clone(),
            values,
            shard: shards.map(|of| [job as u16, of]),
            inputs,
            digest: String::new(),
        };
        planned.digest = planned.own_digest()?;
        let (at, text) = (job_folder(out, job), json(&planned)?);
        let path = at.join(JOB);
        if fs::read(&path).is_ok_and(|before| before == text.as_bytes()) {
            report.as_before += 1;
        } else {
            // One that is cut short has another digest than the plan, which comes last.
            fs::create_dir(&at).or_else(there_already).map_err(folder_fault)?;
            fs::write(&path, &text).map_err(folder_fault)?;
        }
        plan.jobs.push(planned.digest);
    }
    plan.check = plan.own_check()?;
    // Last: a plan that is there is whole.
    replace(&out.join(PLAN), &json(&plan)?).map_err(folder_fault)?;
    report.left_over = (plan.jobs.len()..).take_while(|job| job_folder(out, *job).is_dir()).count();
    Ok(report)
}

fn there_already(e: io::Error) -> io::Result<()> {
    if e.kind() == io::ErrorKind::AlreadyExists { Ok(()) } else { Err(e) }
}

/// The folder is new, empty, or that of a sweep.
fn check_place(out: &Path) -> Result<(), SimError> {
    let taken = match fs::read_dir(out) {
        Ok(mut entries) => entries.next().is_some() && !out.join(PLAN).is_file() && !out.join(JOBS).is_dir(),
        Err(e) if e.kind() == io::ErrorKind::NotFound => false,
        Err(e) => return Err(SimError::Folder(e)),
    };
    if taken {
        let message = "is not empty and not the folder of a sweep: nothing is written into it";
        return Err(InputError::file(out, message, "choose another folder by --output").into());
    }
    Ok(())
}

fn listed(prepared: &Prepared, out: &Path) -> Vec<Listed> {
    let mut all: Vec<Listed> = prepared
        .inputs
        .iter()
        .map(|i| Listed {
            role: i.role.clone(),
            path: relative(out, &i.path),
            bytes: i.bytes,
            sha256: i.sha256.clone(),
        })
        .collect();
    all.sort_by(|a, b| (&a.role, &a.path).cmp(&(&b.role, &b.path)));
    all
}

/// A file that the plan itself has made.
fn own_file(out: &Path, role: &str, name: &str) -> Result<Listed, SimError> {
    let (bytes, sha256) = digest::measure(&out.join(name)).map_err(SimError::Folder)?;
    Ok(Listed { role: role.into(), path: name.into(), bytes, sha256 })
}

fn json(value: &impl Serialize) -> Result<String, SimError> {
    serde_json::to_string_pretty(value).map(|text| text + "\n").map_err(|e| SimError::Folder(e.into()))
}

/// Writes a file next to its place and moves it there: it is whole, or does not exist.
pub(super) fn replace(path: &Path, text: &str) -> io::Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = path.with_file_name(format!(".{name}.{}", std::process::id()));
    let written = fs::write(&beside, text).and_then(|()| fs::rename(&beside, path));
    if written.is_err() {
        fs::remove_file(&beside).ok();
    }
    written
}

impl Plan {
    /// Reads the plan of a sweep.
    ///
    /// # Errors
    /// None there, one that cannot be read, or one of another version of the program: its jobs would be other
    /// jobs.
    pub fn read(sweep: &Path) -> Result<Self, InputError> {
        let path = sweep.join(PLAN);
        let again = "plan the sweep again: proveout sweep plan";
        let text = read_regular_text(&path, MAX_BYTES).map_err(|e| {
            InputError::file(&path, format!("cannot be read: {e}"), "name the folder that sweep plan has written")
        })?;
        let plan: Self = serde_json::from_str(&text)
            .map_err(|e| InputError::file(&path, format!("is not a plan of a sweep: {e}"), again))?;
        if plan.plan_version != VERSION || plan.made_by != made_by() {
            let message =
                format!("was planned by {} (layout {}), but this is {}", plan.made_by, plan.plan_version, made_by());
            return Err(InputError::file(&path, message, again));
        }
        let own = plan.own_check().map_err(|e| InputError::file(&path, e.to_string(), again))?;
        if own != plan.check {
            let message = "has changed since it was planned: its SHA-256 differs from the one in it";
            return Err(InputError::file(&path, message, again));
        }
        Ok(plan)
    }

    /// SHA-256 of all but the digest itself.
    fn own_check(&self) -> Result<String, SimError> {
        Ok(digest::of_bytes(json(&Self { check: String::new(), ..self.clone() })?.as_bytes()))
    }
}

impl Planned {
    /// Reads a job and checks it against the plan.
    ///
    /// # Errors
    /// None of this number, one that cannot be read, or one that is not as it was planned.
    pub fn read(sweep: &Path, plan: &Plan, job: usize) -> Result<Self, InputError> {
        let path = job_folder(sweep, job).join(JOB);
        let fault = |message: String| InputError::file(&path, message, "plan the sweep again: proveout sweep plan");
        let Some(digest) = plan.jobs.get(job) else {
            return Err(fault(format!("there is no job {job}: the plan has {}", plan.jobs.len())));
        };
        let text = read_regular_text(&path, MAX_JOB_BYTES).map_err(|e| fault(format!("cannot be read: {e}")))?;
        let planned: Self = serde_json::from_str(&text).map_err(|e| fault(format!("is not a job: {e}")))?;
        let own = planned.own_digest().map_err(|e| fault(e.to_string()))?;
        if planned.job != job || planned.digest != *digest || own != *digest {
            return Err(fault("has changed since it was planned: its digest differs".into()));
        }
        Ok(planned)
    }

    /// SHA-256 of all but the digest itself.
    fn own_digest(&self) -> Result<String, SimError> {
        Ok(digest::of_bytes(json(&Self { digest: String::new(), ..self.clone() })?.as_bytes()))
    }

    /// The values, in the order of the keys.
    pub fn settings(&self) -> Vec<SetValue> {
        let values = self.values.iter();
        values.filter_map(|(key, v)| Some(SetValue { key: key.clone(), value: ChoiceValueFile::of_json(v)? })).collect()
    }
}

/// SHA-256 of input files by path, each measured once; what the system says of one that cannot be read.
type Measured = BTreeMap<String, Result<String, String>>;

/// Holds what a shard reads, motion and its own stock, against what was planned.
///
/// # Errors
/// A file that is not as it was planned.
pub fn check_shard(sweep: &Path, job: &Planned) -> Result<(), InputError> {
    check_inputs(sweep, job, of_shard, &mut Measured::new())
}

fn of_shard(input: &Listed) -> bool {
    ["motion", "raw stock"].contains(&input.role.as_str())
}

/// Holds jobs and their inputs against the plan again, when their results are there: a result counts for as
/// long as what it was made of is there unchanged. Files that many jobs read are measured once.
#[derive(Debug)]
pub struct Recheck<'a> {
    sweep: &'a Path,
    plan: &'a Plan,
    measured: Measured,
}

impl<'a> Recheck<'a> {
    /// For the jobs of a plan.
    pub fn new(sweep: &'a Path, plan: &'a Plan) -> Self {
        Self { sweep, plan, measured: Measured::new() }
    }

    /// Checks a job and all its inputs; of a shard those that it reads itself.
    ///
    /// # Errors
    /// A job or an input that is not as it was planned, by name.
    pub fn job(&mut self, job: usize) -> Result<(), InputError> {
        let planned = Planned::read(self.sweep, self.plan, job)?;
        let which: fn(&Listed) -> bool = if planned.shard.is_some() { of_shard } else { |_: &Listed| true };
        check_inputs(self.sweep, &planned, which, &mut self.measured)
    }
}

fn check_inputs(
    sweep: &Path,
    job: &Planned,
    which: impl Fn(&Listed) -> bool,
    measured: &mut Measured,
) -> Result<(), InputError> {
    for input in job.inputs.iter().filter(|i| which(i)) {
        let path = sweep.join(&input.path);
        let changed = |why: String| {
            InputError::file(
                &path,
                format!("the {} of job {}: {why}", input.role, job.job),
                "plan the sweep again: proveout sweep plan",
            )
        };
        let now = measured
            .entry(input.path.clone())
            .or_insert_with(|| digest::measure(&path).map(|(_, sha256)| sha256).map_err(|e| e.to_string()));
        match now {
            Err(e) => return Err(changed(format!("cannot be read: {e}"))),
            Ok(sha256) if *sha256 != input.sha256 => {
                return Err(changed("it has changed since the sweep was planned".into()));
            }
            Ok(_) => {}
        }
    }
    Ok(())
}

/// Reads all that a job names, and checks it against what was planned.
///
/// # Errors
/// What the scene refuses with these values ([`SimError::Input`] and its like: a result), or an input that is
/// not as it was planned.
pub fn prepare_job(sweep: &Path, job: &Planned) -> Result<Result<Prepared, SimError>, InputError> {
    check_inputs(sweep, job, |_| true, &mut Measured::new())?;
    let prepared = Prepared::read(&sweep.join(&job.scene), &choice(&job.settings(), sweep));
    if let Ok(prepared) = &prepared {
        let now = listed(prepared, sweep);
        if let Some(other) = now.iter().find(|n| !job.inputs.contains(n)) {
            let message = format!("job {} reads this {} too, which its plan does not name", job.job, other.role);
            return Err(InputError::file(
                &sweep.join(&other.path),
                message,
                "plan the sweep again: proveout sweep plan",
            ));
        }
    }
    Ok(prepared)
}
