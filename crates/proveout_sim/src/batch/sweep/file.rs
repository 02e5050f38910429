//! `sweep.toml`: what varies.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use proveout_input::{Document, InputError, nearest, read_input};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_spanned::Spanned;

use super::design::Design;
use crate::{
    prepare::{
        set_value::SetValue,
        set_values::{self},
    },
    scene::{ChoiceValueFile, Scene, names},
};

/// Most jobs of a sweep.
const MOST_JOBS: usize = 1_000_000;
/// Most shards of a run: each sorts all of its motion.
const MOST_SHARDS: u16 = 1024;
/// Values of a key that are tried on the scene before anything is planned; the others are read by their jobs.
const TRIED: usize = 200;

/// `sweep.toml`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// Name, for folders and people.
    pub name: String,
    /// Folder of the scene, or its scene.toml, from the folder of the sweep.
    pub scene: PathBuf,
    /// How the values are put together.
    #[serde(default)]
    pub method: DesignFile,
    /// Jobs of a Latin hypercube.
    pub draws: Option<usize>,
    /// Where the order of a Latin hypercube begins; 0 when left out.
    pub seed: Option<u64>,
    /// What is kept of every run; the verdict when left out. A run in shards keeps its whole folder.
    pub keep: Option<KeepFile>,
    /// Jobs into which a single run is split: each cuts its share of the stock.
    #[serde(default)]
    #[schemars(with = "Option<u16>")]
    pub shards: Option<Spanned<u16>>,
    /// What varies; of a run in shards each key has one value.
    #[serde(default)]
    #[schemars(with = "Vec<VaryFile>")]
    pub vary: Vec<Spanned<VaryFile>>,
}

/// How the values of a sweep are put together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DesignFile {
    /// All combinations.
    #[default]
    Grid,
    /// The first values of all keys, then the second ones.
    List,
    /// Draws that fill every range evenly.
    LatinHypercube,
}

/// What is kept of every run of a sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum KeepFile {
    /// `verdict.json`.
    #[default]
    Verdict,
    /// The whole run folder, without a recording.
    Folder,
}

/// A key and its values.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VaryFile {
    /// The key, as `run --set` takes it; `program` for the program of the scene, `nc` for a program text,
    /// from the folder of the sweep.
    pub key: String,
    /// Its values. Either this or `range`.
    pub values: Option<Vec<ChoiceValueFile>>,
    /// From where to where it goes, in the unit of the key.
    pub range: Option<[f64; 2]>,
    /// Values of a range, its ends among them; not for a Latin hypercube.
    pub steps: Option<usize>,
}

/// A sweep as it was read.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// What the file says.
    pub file: SweepFile,
    /// Its path.
    pub path: PathBuf,
    /// Folder that relative paths start from.
    pub folder: PathBuf,
    /// The values of every job.
    pub design: Design,
}

impl Sweep {
    /// Reads a sweep, and tries its values on the scene that it names; `path` is its folder or its file.
    ///
    /// # Errors
    /// [`InputError`] with place and remedy for the first fault: a key that does not exist, values that
    /// nothing can have.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let path = if path.is_dir() { path.join("sweep.toml") } else { path.to_owned() };
        let text = read_input(&path)?;
        let file: SweepFile = Document::new(&path, &text).read()?;
        let fault = |at: usize, message: String, help: &str| InputError::at(&path, &text, at, message, help);
        if let Some(message) = names::fault(&file.name) {
            return Err(fault(0, message, names::REMEDY));
        }
        if file.vary.is_empty() && file.shards.is_none() {
            return Err(fault(0, "the sweep varies nothing".into(), "add a [[vary]] with key and values"));
        }
        let mut known = BTreeSet::new();
        for vary in &file.vary {
            let (at, vary) = (vary.span().start, vary.get_ref());
            if !known.insert(vary.key.as_str()) {
                return Err(fault(at, format!("two [[vary]] have the key {:?}", vary.key), "give each key once"));
            }
            if let Some((message, help)) = vary.fault(file.method) {
                return Err(fault(at, format!("{:?}: {message}", vary.key), help));
            }
        }
        let draws = match (file.method, file.draws) {
            (DesignFile::LatinHypercube, Some(n)) if n > 0 => n,
            (DesignFile::LatinHypercube, _) => {
                return Err(fault(
                    0,
                    "a Latin hypercube needs a number of draws".into(),
                    "write for example draws = 100",
                ));
            }
            (_, Some(_)) => {
                let help = "leave it out, or write method = \"latin-hypercube\"";
                return Err(fault(0, "`draws` belong to a Latin hypercube".into(), help));
            }
            (_, None) => 0,
        };
        if file.seed.is_some() && file.method != DesignFile::LatinHypercube {
            let help = "leave it out, or write method = \"latin-hypercube\"";
            return Err(fault(0, "`seed` belongs to a Latin hypercube".into(), help));
        }
        if let (Some(shards), Some(_)) = (&file.shards, file.keep) {
            let message = "`keep` says what is kept of many runs: a run in shards keeps its whole folder".into();
            return Err(fault(shards.span().start, message, "leave `keep` out, or `shards`"));
        }
        let axes: Vec<VaryFile> = file.vary.iter().map(|v| v.get_ref().clone()).collect();
        let design = Design::new(file.method, &axes, draws, file.seed.unwrap_or(0)).map_err(|(k, message)| {
            fault(
                file.vary.get(k).map_or(0, |v| v.span().start),
                message,
                "give all keys of a list equally many values",
            )
        })?;
        if design.len() > MOST_JOBS {
            let message = format!("{} jobs are too many: the limit is {MOST_JOBS}", design.len());
            return Err(fault(0, message, "vary less, or draw: method = \"latin-hypercube\""));
        }
        if let Some(shards) = &file.shards {
            let (at, n) = (shards.span().start, *shards.get_ref());
            if n == 0 || n > MOST_SHARDS {
                let message = format!("shards = {n}: a run is split into 1 to {MOST_SHARDS}");
                return Err(fault(at, message, "write as many as there are machines, for example shards = 8"));
            }
            if design.len() != 1 {
                let message = format!("shards split a single run, but the sweep has {}", design.len());
                return Err(fault(at, message, "give each key one value, or leave `shards` out"));
            }
        }
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
        let sweep = Self { file, path: path.clone(), folder, design };
        let scene = Scene::read(&sweep.scene())?;
        for vary in &sweep.file.vary {
            let (at, vary) = (vary.span().start, vary.get_ref());
            sweep.try_values(&scene, vary).map_err(|(message, help)| fault(at, message, &help))?;
        }
        Ok(sweep)
    }

    /// The scene that is run.
    pub fn scene(&self) -> PathBuf {
        self.folder.join(&self.file.scene)
    }

    /// Puts the values of a key into the scene, each alone.
    fn try_values(&self, scene: &Scene, vary: &VaryFile) -> Result<(), (String, String)> {
        for value in vary.tried().into_iter().take(TRIED) {
            let set = SetValue { key: vary.key.clone(), value };
            match (vary.key.as_str(), &set.value) {
                ("program", ChoiceValueFile::Word(name)) => {
                    if scene.program(Some(name)).is_none() {
                        let names = scene.file.program.iter().map(|p| p.name.as_str());
                        let near = nearest(name, names).map_or_else(String::new, |n| format!("; did you mean {n:?}?"));
                        return Err((
                            format!("the scene has no program {name:?}{near}"),
                            "name programs of the scene".into(),
                        ));
                    }
                }
                ("nc", ChoiceValueFile::Word(name)) => {
                    if !self.folder.join(name).is_file() {
                        return Err((
                            format!("the program text {name:?} is not there"),
                            "write the path from the folder of the sweep".into(),
                        ));
                    }
                }
                ("program" | "nc", _) => return Err((format!("{set} is not a name"), "write names in quotes".into())),
                _ => {
                    let one = std::slice::from_ref(&set);
                    let tried = set_values::scene(&scene.path, one).and_then(|scene| {
                        set_values::machine(&scene.resolve(&scene.file.machine), one)?;
                        set_values::tools(&scene.resolve(&scene.file.tools), one)
                    });
                    tried.map_err(|e| (e.message.clone(), e.remedy.clone()))?;
                }
            }
        }
        Ok(())
    }
}

impl VaryFile {
    fn fault(&self, method: DesignFile) -> Option<(String, &'static str)> {
        if self.key.trim().is_empty() {
            return Some(("no key".into(), "name a key as run --set takes it"));
        }
        match (&self.values, self.range, self.steps) {
            (Some(values), None, None) => {
                let finite = |v: &ChoiceValueFile| !matches!(v, ChoiceValueFile::Number(x) if !x.is_finite());
                let unlike = values.iter().map(ChoiceValueFile::exact).collect::<BTreeSet<_>>().len() == values.len();
                if values.is_empty() || !values.iter().all(finite) || (method != DesignFile::List && !unlike) {
                    return Some(("values are missing, repeated, or not numbers".into(), "give each value once"));
                }
                None
            }
            (None, Some([low, high]), steps) => {
                if !(low < high && low.is_finite() && high.is_finite()) {
                    return Some((format!("range = [{low}, {high}] is empty"), "write range = [low, high]"));
                }
                match (method, steps) {
                    (DesignFile::LatinHypercube, None) => None,
                    (DesignFile::LatinHypercube, Some(_)) => {
                        Some(("a Latin hypercube draws from the whole range".into(), "leave `steps` out"))
                    }
                    (_, Some(n)) if (2..=MOST_JOBS).contains(&n) => None,
                    _ => Some(("a range needs a number of values".into(), "write steps = 2 or more")),
                }
            }
            _ => {
                Some(("needs either values or range".into(), "write values = [...], or range = [low, high] with steps"))
            }
        }
    }

    /// All values, or the ends of a range.
    fn tried(&self) -> Vec<ChoiceValueFile> {
        match (&self.values, self.range) {
            (Some(values), _) => values.clone(),
            (None, Some(ends)) => ends.map(ChoiceValueFile::Number).to_vec(),
            (None, None) => Vec::new(),
        }
    }
}
