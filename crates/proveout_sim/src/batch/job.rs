//! Several setups of one part: `job.toml` lists their scenes in the order in which they are clamped, and the
//! stock is handed on.
//!
//! ```toml
//! name = "bracket"
//!
//! [[setup]]
//! name = "op10"
//! scene = "op10"             # folder or scene.toml, from the folder of the job
//!
//! [[setup]]
//! name = "op20"
//! scene = "op20"
//! program = "finish"         # the first one of the scene when left out
//! after = "op10"             # whose stock it takes; the setup before when left out
//! ```
//!
//! A scene after the first one must begin with what an earlier run left (`[stock] from_run`, with
//! `place` for the new clamping); the job replaces the path given there by the run of the setup
//! before. Everything is read before anything is cut ([`Job::check`]), and a setup after one that
//! failed is not run: it would cut a part that does not exist.

use std::path::{Path, PathBuf};

use proveout_input::{Document, InputError, nearest, read_input};
use proveout_step::StepFiles;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_spanned::Spanned;

use crate::{
    prepare::{
        choice::{Choice, StockChoice},
        error::SimError,
        prepared::Prepared,
    },
    scene::{Scene, names},
    verdict::{
        finding::Severity,
        gates,
        verdict_file::{GateVerdict, State, Verdict},
    },
};

/// Version of the layout of [`JobVerdict`].
pub const SCHEMA_VERSION: u32 = 1;
/// Findings of a setup that are repeated.
const FINDINGS: usize = 5;

/// `job.toml`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JobFile {
    /// Name, for folders and people.
    pub name: String,
    /// The setups, in the order in which they are clamped.
    #[serde(default)]
    #[schemars(with = "Vec<SetupFile>")]
    pub setup: Vec<Spanned<SetupFile>>,
}

/// One clamping.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetupFile {
    /// Name, for folders and people; unlike the others.
    pub name: String,
    /// Folder of the scene, or its scene.toml, from the folder of the job.
    pub scene: PathBuf,
    /// Program of the scene; the first one when left out.
    pub program: Option<String>,
    /// Setup whose stock it takes; the one before when left out.
    pub after: Option<String>,
}

/// A job as it was read.
#[derive(Clone, Debug)]
pub struct Job {
    /// Name.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    /// The setups in order.
    pub setups: Vec<Setup>,
}

/// A setup of a job.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Name.
    pub name: String,
    /// The scene to read.
    pub scene: PathBuf,
    /// Program of the scene.
    pub program: Option<String>,
    /// Index of the setup whose stock it takes; none for the first one.
    pub after: Option<usize>,
}

impl Job {
    /// Reads a job and the scenes that it names; `path` is its folder or its file.
    ///
    /// # Errors
    /// [`InputError`] with place and remedy for the first fault of the job or of a scene.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let path = if path.is_dir() { path.join("job.toml") } else { path.to_owned() };
        let text = read_input(&path)?;
        let file: JobFile = Document::new(&path, &text).read()?;
        let fault = |at: usize, message: String, help: &str| Err(InputError::at(&path, &text, at, message, help));
        if let Some(message) = names::fault(&file.name) {
            return fault(0, message, names::REMEDY);
        }
        if file.setup.is_empty() {
            return fault(0, "the job has no setup".into(), "add a [[setup]] with name and scene");
        }
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
        let mut setups: Vec<Setup> = Vec::new();
        for entry in &file.setup {
            let (at, setup) = (entry.span().start, entry.get_ref());
            if let Some(message) = names::fault(&setup.name) {
                return fault(at, message, names::REMEDY);
            }
            if setups.iter().any(|s| s.name == setup.name) {
                let message = format!("two setups have the name {:?}", setup.name);
                return fault(at, message, "give each setup a name of its own");
            }
            let before = setups.len().checked_sub(1);
            let after = match (&setup.after, before) {
                (None, before) => before,
                (Some(name), None) => {
                    let message =
                        format!("the first setup {:?} has after = {name:?}, but no setup comes before it", setup.name);
                    return fault(at, message, "leave `after` out there");
                }
                (Some(name), Some(_)) => match setups.iter().position(|s| s.name == *name) {
                    Some(index) => Some(index),
                    None => {
                        let later = file.setup.iter().any(|s| s.get_ref().name == *name);
                        let message = format!("setup {:?} comes after {name:?}", setup.name);
                        if later {
                            let message = message
                                + ", which does not come before it: the setups would depend on \
                                                     each other in a circle";
                            return fault(at, message, "list the setups in the order in which they are clamped");
                        }
                        let near = nearest(name, file.setup.iter().map(|s| s.get_ref().name.as_str()));
                        let hint = near.map_or_else(String::new, |n| format!("; did you mean {n:?}?"));
                        return fault(
                            at,
                            format!("{message}, which is not a setup of the job{hint}"),
                            "name an earlier setup",
                        );
                    }
                },
            };
            let scene_path = folder.join(&setup.scene);
            if !scene_path.exists() {
                let message = format!("the scene of setup {:?} is not there: {}", setup.name, scene_path.display());
                return fault(at, message, "correct `scene`: a folder with scene.toml, from the folder of the job");
            }
            let scene = Scene::read(&scene_path)?;
            if after.is_some() && scene.file.stock.get_ref().from_run.is_none() {
                let message = format!(
                    "the scene of setup {:?} defines its own stock, so the result of setup {:?} would not be used",
                    setup.name,
                    after.map_or("", |i| setups[i].name.as_str())
                );
                let help = "write from_run = \"before\" under [stock] of that scene, with `place` for the new clamping: the job puts its own run there";
                return fault(at, message, help);
            }
            setups.push(Setup { name: setup.name.clone(), scene: scene_path, program: setup.program.clone(), after });
        }
        Ok(Self { name: file.name, path, setups })
    }

    /// Reads everything that the setups name, programs to their end, with a stand-in for the stock
    /// that does not exist yet. STEP files are read into those of the call.
    ///
    /// # Errors
    /// The first fault of a setup, as its run would report it.
    pub fn check(&self, step_files: &StepFiles) -> Result<(), SimError> {
        let call = Choice { step_files: step_files.clone(), ..Choice::default() };
        for setup in &self.setups {
            let stock = if setup.after.is_some() { StockChoice::StandIn } else { StockChoice::OfScene };
            Prepared::read(&setup.scene, &Choice { program: setup.program.clone(), stock, ..call.clone() })?;
        }
        Ok(())
    }
}

/// What a job says: `job.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JobVerdict {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Name of the job.
    pub job: String,
    /// Fail if one setup fails, else unchecked if one is unchecked or was not run, else pass.
    pub verdict: State,
    /// The setups in order.
    pub setups: Vec<SetupVerdict>,
}

/// What a setup says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SetupVerdict {
    /// Name; its run folder has the same.
    pub name: String,
    /// Setup whose stock it took; null for the first one.
    pub after: Option<String>,
    /// Its verdict; null where it was not run.
    pub verdict: Option<State>,
    /// Why it was not run.
    pub not_run: Option<String>,
    /// Name of the scene.
    pub scene: Option<String>,
    /// Program of the scene.
    pub program: Option<String>,
    /// Its gates.
    pub gates: Vec<GateVerdict>,
    /// Findings that fail a gate.
    pub errors: u64,
    /// The first of them, in words.
    pub first_errors: Vec<String>,
    /// Machine time, s.
    pub time_s: Option<f64>,
    /// Removed volume, mm³.
    pub removed_mm3: Option<f64>,
    /// Volume that is handed on, mm³.
    pub stock_left_mm3: Option<f64>,
    /// SHA-256 of the stock that it began with, as the setup before has left it; null where it brought its
    /// own.
    pub stock_digest: Option<String>,
}

impl JobVerdict {
    /// A job of which nothing was run yet.
    pub fn new(job: &Job) -> Self {
        Self { schema_version: SCHEMA_VERSION, job: job.name.clone(), verdict: State::Unchecked, setups: Vec::new() }
    }

    /// Name of the setup that keeps another one from being run: the one that it comes after has failed or was
    /// not run itself.
    pub fn blocked(&self, job: &Job, setup: &Setup) -> Option<String> {
        let before = setup.after?;
        let ok = self.setups.get(before).is_some_and(|s| matches!(s.verdict, Some(State::Pass | State::Unchecked)));
        (!ok).then(|| job.setups[before].name.clone())
    }

    /// Takes a setup that was run.
    pub fn add(&mut self, job: &Job, setup: &Setup, v: &Verdict) {
        let errors = || v.findings.iter().filter(|f| f.severity == Severity::Error);
        let line = |l: Option<u32>| l.map_or_else(String::new, |l| format!("line {l}: "));
        self.setups.push(SetupVerdict {
            name: setup.name.clone(),
            after: setup.after.map(|i| job.setups[i].name.clone()),
            verdict: Some(v.verdict),
            not_run: None,
            scene: Some(v.scene.clone()),
            program: Some(v.program.clone()),
            gates: v.gates.clone(),
            errors: errors().count() as u64,
            first_errors: errors()
                .take(FINDINGS)
                .map(|f| format!("{}{} [{}]", line(f.line), f.message, f.code))
                .collect(),
            time_s: Some(v.time.total_s),
            removed_mm3: Some(v.removal.volume_mm3),
            stock_left_mm3: Some(v.removal.stock_left_mm3),
            stock_digest: setup.after.and_then(|_| v.digests.get("stock").cloned()),
        });
        self.judge();
    }

    /// Takes a setup that was not run, since the named one before it failed.
    pub fn leave_out(&mut self, job: &Job, setup: &Setup, before: &str) {
        self.setups.push(SetupVerdict {
            name: setup.name.clone(),
            after: setup.after.map(|i| job.setups[i].name.clone()),
            not_run: Some(format!("not run: setup {before} before it failed or was not run")),
            ..SetupVerdict::default()
        });
        self.judge();
    }

    fn judge(&mut self) {
        self.verdict = gates::overall(self.setups.iter().map(|s| s.verdict.unwrap_or(State::Unchecked)));
    }
}
