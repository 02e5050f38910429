//! An observer for Python: reports progress, ends the run when the caller wants no more, keeps the final
//! surface.

use std::{
    path::Path,
    sync::{Arc, Mutex, PoisonError},
};

use proveout_sim::{
    Observer, Prepared, SurfaceShape, SurfaceTexture,
    observer::{Batch, MeshPart, ObserverError, Outcome, Setup},
};

use crate::work::WorkState;

/// Share of the progress that the program takes; the rest is for judgement and files.
const PROGRAM_SHARE: f64 = 0.9;

/// The surface of a cut part, workpiece frame: patches first, then the stock. Flat rows, as arrays want them.
#[derive(Debug, Default)]
pub(crate) struct CutSurface {
    /// Vertices by three, mm.
    pub(crate) vertices: Vec<f64>,
    /// Outward unit normals by three.
    pub(crate) normals: Vec<f64>,
    /// Deviation at the vertices, mm; not a number where no design surface applies; empty without a design.
    pub(crate) deviations: Vec<f64>,
    /// Vertices of triangles by three.
    pub(crate) triangles: Vec<u32>,
    /// Vertices before the mesh that is being shown.
    before: u32,
    pub(crate) maps: Vec<KeptMap>,
}

/// A roughness map.
#[derive(Debug)]
pub(crate) struct KeptMap {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    /// Along columns and rows.
    pub(crate) step_mm: [f64; 2],
    /// Heights by rows, mm.
    pub(crate) heights: Vec<f64>,
    /// Nodes on the design by rows, three numbers each, mm.
    pub(crate) points: Vec<f64>,
}

/// The observer.
pub(crate) struct Watcher {
    shared: Arc<WorkState>,
    kept: Option<Arc<Mutex<CutSurface>>>,
    main_file: String,
    /// What of the whole work this run is.
    share: [f64; 2],
    findings: usize,
    line: u32,
}

impl Watcher {
    /// For a run that takes the work from one share to another; `kept` where its surface is wanted.
    pub(crate) fn boxed(
        shared: &Arc<WorkState>,
        prepared: &Prepared,
        share: [f64; 2],
        kept: Option<Arc<Mutex<CutSurface>>>,
    ) -> Box<dyn Observer> {
        let main_file = prepared.running_file().display().to_string();
        Box::new(Self { shared: Arc::clone(shared), kept, main_file, share, findings: 0, line: 0 })
    }

    fn look(&self) -> Result<(), ObserverError> {
        if self.shared.ends() {
            return Err(ObserverError { what: "the run".to_owned(), message: "it was interrupted".to_owned() });
        }
        Ok(())
    }

    fn tell(&self, share: f64, text: String) {
        let [from, to] = self.share;
        self.shared.tell(from + (to - from) * share, text);
    }

    fn keep(&self, what: impl FnOnce(&mut CutSurface)) {
        if let Some(kept) = &self.kept {
            what(&mut kept.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }
}

impl Observer for Watcher {
    fn name(&self) -> &'static str {
        "python"
    }

    fn begin(&mut self, setup: &Setup<'_>, _: &Path) -> Result<(), ObserverError> {
        self.tell(0.0, format!("{}: {} lines", setup.program, setup.program_lines));
        self.look()
    }

    fn batch(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        let last = batch.blocks.iter().rev().find(|b| *b.file == *self.main_file);
        self.line = last.map_or(self.line, |b| b.line);
        self.findings += batch.findings.len();
        let part = f64::from(self.line) / f64::from(setup.program_lines.max(1));
        let (program, line, lines) = (setup.program, self.line, setup.program_lines);
        let text =
            format!("{program}: line {line} of {lines}, {:.0} s simulated, {} findings", batch.time, self.findings);
        self.tell(PROGRAM_SHARE * part.min(1.0), text);
        self.look()
    }

    fn surface_texture(&mut self, _: &Setup<'_>, texture: &SurfaceTexture) -> Result<(), ObserverError> {
        if let Some(map) = &texture.map {
            self.keep(|kept| {
                kept.maps.push(KeptMap {
                    name: texture.name.clone(),
                    rows: map.rows,
                    columns: map.columns,
                    step_mm: map.step_mm,
                    heights: map.heights.clone(),
                    points: map.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect(),
                });
            });
        }
        self.look()
    }

    fn surface_mesh(&mut self, setup: &Setup<'_>, _: &SurfaceShape, part: &MeshPart<'_>) -> Result<(), ObserverError> {
        self.tell(PROGRAM_SHARE, format!("{}: the surface of the cut part", setup.program));
        self.keep(|kept| {
            if part.first == 0 {
                kept.before = u32::try_from(kept.vertices.len() / 3).unwrap_or(u32::MAX);
            }
            kept.vertices.extend(part.positions.iter().flat_map(|p| [p.x, p.y, p.z]));
            kept.normals.extend(part.normals.iter().flat_map(|n| [n.x, n.y, n.z]));
            kept.deviations.extend_from_slice(part.deviations);
            let before = kept.before;
            kept.triangles.extend(part.triangles.iter().flat_map(|t| t.map(|v| v.saturating_add(before))));
        });
        self.look()
    }

    fn end(&mut self, setup: &Setup<'_>, _: &Outcome<'_>) -> Result<(), ObserverError> {
        self.tell(1.0, format!("{}: judged", setup.program));
        self.look()
    }
}
