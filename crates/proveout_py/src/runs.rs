//! Prove-outs and comparisons of scenes.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf, absolute},
    sync::{Arc, Mutex, PoisonError},
};

use numpy::{PyArray1, PyArray2, PyArray3};
use proveout::front::{CommandError, CompareOrder, compare as compare_programs, default_place, prove_out};
use proveout_record::RerunMode;
use proveout_sim::{
    Choice, Prepared, Recorded,
    compare::CompareChoice,
    partial::StopAt,
    resolution_fault,
    scene::{Dynamics, Plant},
};
use pyo3::prelude::*;

use crate::{
    arrays::{frozen, frozen_row, frozen_rows},
    errors::wrong,
    watcher::{CutSurface, KeptMap, Watcher},
    work::{WorkState, beside},
};

/// Most worker threads: above the number of processors they only take memory.
const MAX_THREADS: usize = 512;

/// Folders that runs of this process are writing: two runs to one place would write over each other.
static PLACES: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A place that no other run of this process writes to as long as this lives.
struct FolderClaim(PathBuf);

impl FolderClaim {
    fn take(place: &Path) -> Result<Self, CommandError> {
        let place = absolute(place).unwrap_or_else(|_| place.to_owned());
        if !PLACES.lock().unwrap_or_else(PoisonError::into_inner).insert(place.clone()) {
            let message = format!("another run of this process writes to {}", place.display());
            return Err(CommandError::new(message, "give each run its own folder with `output`"));
        }
        Ok(Self(place))
    }
}

impl Drop for FolderClaim {
    fn drop(&mut self) {
        PLACES.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.0);
    }
}

/// The surface of a cut part, workpiece frame.
#[pyclass(frozen, name = "Part", module = "proveout._proveout")]
pub(crate) struct CutPart {
    /// (n, 3), mm.
    #[pyo3(get)]
    vertices: Py<PyArray2<f64>>,
    /// (m, 3).
    #[pyo3(get)]
    triangles: Py<PyArray2<u32>>,
    /// (n, 3).
    #[pyo3(get)]
    normals: Py<PyArray2<f64>>,
    /// (n,), mm; (0,) without a design.
    #[pyo3(get)]
    deviation: Py<PyArray1<f64>>,
}

#[pymethods]
impl CutPart {
    /// Vertices and triangles.
    fn mesh(&self, py: Python<'_>) -> (Py<PyArray2<f64>>, Py<PyArray2<u32>>) {
        (self.vertices.clone_ref(py), self.triangles.clone_ref(py))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let count = |array: &Py<PyAny>| array.bind(py).len();
        let [vertices, triangles] = [self.vertices.as_any(), self.triangles.as_any()].map(count);
        Ok(format!("Part({} vertices, {} triangles)", vertices?, triangles?))
    }
}

/// A height map: name, heights (rows, columns), nodes (rows, columns, 3), steps; mm.
type Map = (String, Py<PyAny>, Py<PyArray3<f64>>, [f64; 2]);

fn map_of(py: Python<'_>, map: KeptMap) -> PyResult<Map> {
    let heights = frozen(py, map.heights, (map.rows, map.columns))?.into_any();
    let points = frozen(py, map.points, (map.rows, map.columns, 3))?;
    Ok((map.name, heights, points, map.step_mm))
}

/// What a call of `run` or `compare` chooses, as words and numbers.
struct RunChoice {
    resolution_mm: Option<f64>,
    threads: usize,
    dynamics: Option<Dynamics>,
    rerun: bool,
}

impl RunChoice {
    fn read(
        py: Python<'_>,
        resolution_mm: Option<f64>,
        threads: Option<i64>,
        dynamics: Option<&str>,
        rerun: bool,
    ) -> PyResult<Self> {
        if let Some(fault) = resolution_mm.and_then(resolution_fault) {
            return Err(wrong(py, fault, "give a length in mm"));
        }
        let threads = match threads {
            None => std::thread::available_parallelism().map_or(1, usize::from),
            Some(n) => usize::try_from(n).ok().filter(|n| (1..=MAX_THREADS).contains(n)).ok_or_else(|| {
                let remedy = format!("use 1 to {MAX_THREADS}, or omit it: one thread per processor is fastest");
                wrong(py, format!("threads = {n} is out of range"), &remedy)
            })?,
        };
        let dynamics = match dynamics {
            None => None,
            Some("ideal") => Some(Dynamics::Ideal),
            Some("planned") => Some(Dynamics::Planned),
            Some("servo") => Some(Dynamics::Servo),
            Some(other) => {
                return Err(wrong(py, format!("unknown dynamics {other:?}"), "use ideal, planned or servo"));
            }
        };
        if rerun && !cfg!(feature = "rerun") {
            let message = "rerun = True: this build cannot write recordings";
            return Err(wrong(py, message, "build the wheel with the feature `rerun`, or omit it"));
        }
        Ok(Self { resolution_mm, threads, dynamics, rerun })
    }

    fn pool(&self) -> Result<rayon::ThreadPool, CommandError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads).build();
        pool.map_err(|e| CommandError::new(format!("{} threads cannot be started: {e}", self.threads), ""))
    }

    fn recorder(&self) -> RerunMode {
        if self.rerun { RerunMode::File } else { RerunMode::Off }
    }
}

/// Runs a program of a scene; folder, part and height maps.
#[pyfunction]
#[pyo3(signature = (scene, *, program, nc, resolution_mm, threads, dynamics, plant, output, preview, stop_at, set, rerun, keep_surface, progress))]
#[expect(
    clippy::too_many_arguments,
    clippy::fn_params_excessive_bools,
    reason = "keyword arguments of one Python call"
)]
pub(crate) fn run<'py>(
    py: Python<'py>,
    scene: PathBuf,
    program: Option<String>,
    nc: Option<PathBuf>,
    resolution_mm: Option<f64>,
    threads: Option<i64>,
    dynamics: Option<&str>,
    plant: Option<&str>,
    output: Option<PathBuf>,
    preview: bool,
    stop_at: Option<&str>,
    set: Vec<String>,
    rerun: bool,
    keep_surface: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<(PathBuf, Option<CutPart>, Vec<Map>)> {
    let chosen = RunChoice::read(py, resolution_mm, threads, dynamics, rerun)?;
    let plant = match plant {
        None => None,
        Some("newton-euler") => Some(Plant::NewtonEuler),
        Some("rapier") => Some(Plant::Rapier),
        Some(other) => {
            return Err(wrong(py, format!("unknown plant {other:?}"), "use newton-euler or rapier"));
        }
    };
    let stop_at = stop_at.map(str::parse::<StopAt>).transpose();
    let stop_at = stop_at.map_err(|e| wrong(py, format!("stop_at: {e}"), ""))?;
    if preview && resolution_mm.is_some() {
        return Err(wrong(py, "a preview sets its own cell size", "omit preview or resolution_mm"));
    }
    let choice = Choice {
        program,
        nc,
        resolution_mm: chosen.resolution_mm,
        dynamics: chosen.dynamics,
        plant,
        recorded: if chosen.rerun { Recorded::Recording } else { Recorded::Folder },
        preview,
        stop_at,
        set: set.iter().map(|s| s.parse()).collect::<Result<_, _>>().map_err(|e: String| wrong(py, e, ""))?,
        ..Choice::default()
    };
    let kept = keep_surface.then(|| Arc::new(Mutex::new(CutSurface::default())));
    let place = beside(py, progress.as_ref(), |shared: &Arc<WorkState>| {
        chosen.pool()?.install(|| {
            let prepared = Prepared::read(&scene, &choice)?;
            let place = output.unwrap_or_else(|| default_place(&prepared, preview, choice.stop_at.is_some()));
            let _claim = FolderClaim::take(&place)?;
            let watcher = Watcher::boxed(shared, &prepared, [0.0, 1.0], kept.clone());
            let (_, committed) = prove_out(prepared, &place, chosen.threads, &chosen.recorder(), vec![watcher])?;
            Ok(committed.place)
        })
    })?;
    let Some(kept) = kept else { return Ok((place, None, Vec::new())) };
    let kept = std::mem::take(&mut *kept.lock().unwrap_or_else(PoisonError::into_inner));
    let part = CutPart {
        vertices: frozen_rows(py, kept.vertices, 3)?,
        triangles: frozen_rows(py, kept.triangles, 3)?,
        normals: frozen_rows(py, kept.normals, 3)?,
        deviation: frozen_row(py, kept.deviations)?,
    };
    let maps = kept.maps.into_iter().map(|m| map_of(py, m)).collect::<PyResult<_>>()?;
    Ok((place, Some(part), maps))
}

/// Compares the programs of a scene; the folder.
#[pyfunction]
#[pyo3(signature = (scene, *, baseline, resolution_mm, threads, dynamics, output, rerun, progress))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of one Python call")]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    scene: PathBuf,
    baseline: Option<String>,
    resolution_mm: Option<f64>,
    threads: Option<i64>,
    dynamics: Option<&str>,
    output: Option<PathBuf>,
    rerun: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<PathBuf> {
    /// Share of the varied motions in the progress.
    const MOTIONS: f64 = 0.2;
    let chosen = RunChoice::read(py, resolution_mm, threads, dynamics, rerun)?;
    let choice = CompareChoice {
        baseline,
        resolution_mm: chosen.resolution_mm,
        dynamics: chosen.dynamics,
        ..CompareChoice::default()
    };
    beside(py, progress.as_ref(), |shared: &Arc<WorkState>| {
        chosen.pool()?.install(|| {
            let _claim = output.as_deref().map(FolderClaim::take).transpose()?;
            let recorder = chosen.recorder();
            let order = CompareOrder {
                scene: &scene,
                choice: &choice,
                place: output.as_deref(),
                threads: chosen.threads,
                rerun: &recorder,
            };
            let told = |done: usize, of: usize| {
                shared.leave_if_it_ends();
                shared.tell(
                    MOTIONS * done as f64 / of.max(1) as f64,
                    format!("{done} of {of} motions on variations of the twin"),
                );
            };
            let mut runs = 0_i32;
            let mut watchers = |prepared: &Prepared| {
                let programs = prepared.scene.file.program.len().max(1) as f64;
                let share = |k: i32| MOTIONS + (1.0 - MOTIONS) * f64::from(k) / programs;
                runs += 1;
                vec![Watcher::boxed(shared, prepared, [share(runs - 1), share(runs)], None)]
            };
            Ok(compare_programs(&order, &told, &mut watchers)?.1.place)
        })
    })
}
