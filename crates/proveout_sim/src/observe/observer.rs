//! The trait that recorders, reports and progress bars implement.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use proveout_collision::ProvedSpan;
use proveout_controller::{Dynamics, Event, MoveKind, Piece, Sample, servo::Plant};
use proveout_geom::{Point, Pose, TriMesh, Vector};
use proveout_machine::Machine;
use proveout_stock::{Patch, TileId, TriDexel};
use proveout_tool::ToolLibrary;
use thiserror::Error;

use crate::{
    checks::engagement::Engagement,
    compare::schedule::Schedule,
    judge::{free_axes::FreeAxes, texture::SurfaceTexture},
    observe::surface_map::{MapPoint, SurfaceShape},
    prepare::made_program::MadeProgram,
    scene::Scene,
    verdict::{finding::Finding, verdict_file::Verdict},
};

/// Why an observer could not write what it saw.
#[derive(Debug, Error)]
#[error("cannot write {what}: {message}")]
pub struct ObserverError {
    /// File or stream.
    pub what: String,
    /// Reason.
    pub message: String,
}

/// What does not change during a run.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// The scene as read.
    pub scene: &'a Scene,
    /// Name of the program.
    pub program: &'a str,
    /// Lines of the program text, for progress.
    pub program_lines: u32,
    /// The text that runs, where it was made from another program.
    pub made: Option<&'a MadeProgram>,
    /// Program files as findings and blocks name them, by the names under which they were opened; see [`crate::run::listing`].
    pub sources: &'a BTreeMap<String, Arc<str>>,
    /// The machine.
    pub machine: &'a Machine,
    /// The tool library.
    pub tools: &'a ToolLibrary,
    /// Present stock, workpiece frame: in [`Observer::begin`] before the first cut.
    pub stock: &'a TriDexel,
    /// Patches of the stock with finer cells, likewise.
    pub patches: &'a [Patch],
    /// Design part, workpiece frame, where the scene has one as a mesh.
    pub part: Option<&'a TriMesh>,
    /// Fixtures and platforms: name and mesh in the table frame.
    pub fixtures: &'a [(String, TriMesh)],
    /// Workpiece frame to table frame.
    pub table_from_work: Pose,
    /// Which motion cuts in this run.
    pub dynamics: Dynamics,
    /// What moves under the forces of the drives, where they are simulated.
    pub plant: Plant,
}

/// Signals for the motion of one sample; same order as [`Batch::samples`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleSignals {
    /// Material removal rate, mm³/s, of the piece that holds the sample.
    pub removal_rate: f64,
    /// Proved clearance of the piece that holds the sample, mm; none when nothing was checked.
    pub clearance: Option<f64>,
    /// Index of the tool in the library.
    pub tool: Option<u32>,
}

/// What proves the least clearance of every pair of bodies: spans of time with a distance that is proved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClearanceProof {
    /// Names of the two bodies of each pair.
    pub bodies: Vec<[Arc<str>; 2]>,
    /// By pair (an index of `bodies`), in order of time.
    pub spans: Vec<ProvedSpan>,
}

/// One executed block, complete.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockRow {
    /// Index of the block, from 0.
    pub block: u32,
    /// File as given.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Kind of motion.
    pub kind: MoveKind,
    /// Index of the tool in the library.
    pub tool: Option<u32>,
    /// Start, s.
    pub start_time: f64,
    /// End, s.
    pub end_time: f64,
    /// Path of the tip in the workpiece, mm.
    pub length: f64,
    /// Programmed feed, mm/s; none for rapids.
    pub feed: Option<f64>,
    /// Removed volume, mm³.
    pub volume_mm3: f64,
    /// Largest length of cutter in material on a ray, mm: a measure of engagement.
    pub engagement_mm: f64,
    /// Engagement of the cutter, where the scene asks for it and the block has cut.
    pub engagement: Option<Engagement>,
}

/// The way of a part that came off the stock.
#[derive(Clone, Debug, PartialEq)]
pub struct LooseMotion {
    /// Name in findings.
    pub name: String,
    /// Its surface where it came off, table frame, mm.
    pub mesh: TriMesh,
    /// Time, s, and motion since then in the table frame: applied to the mesh it gives the part at that time. Rising times.
    pub track: Vec<(f64, Pose)>,
    /// It is no longer stock; otherwise it rests, or it is not known where it goes and this is one of its ways.
    pub gone: bool,
}

/// A stretch of the run, in order of time.
#[derive(Clone, Copy)]
pub struct Batch<'a> {
    /// Control samples.
    pub samples: &'a [Sample],
    /// Signals for the samples.
    pub signals: &'a [SampleSignals],
    /// Motion pieces that were cut and checked.
    pub pieces: &'a [Piece],
    /// Blocks that ended within the stretch.
    pub blocks: &'a [BlockRow],
    /// Tool changes, spindle, messages.
    pub events: &'a [Event],
    /// Findings raised within the stretch.
    pub findings: &'a [Finding],
    /// Time at the end of the stretch, s.
    pub time: f64,
    /// Stock after the stretch, workpiece frame.
    pub stock: &'a TriDexel,
    /// Tiles of the stock that changed within the stretch.
    pub changed_tiles: &'a [TileId],
    /// Patches of the stock after the stretch.
    pub patches: &'a [Patch],
    /// Tiles of each patch that changed within the stretch.
    pub changed_in_patches: &'a [Vec<TileId>],
    /// Parts that came off the stock, whose way was decided within the stretch.
    pub loose: &'a [LooseMotion],
}

/// Some points of the surface of the cut part, in the fixed order of the stock, then of each patch. Workpiece frame, mm.
#[derive(Clone, Copy)]
pub struct PointBand<'a> {
    /// Number of the patch that they are points of; none for the stock itself.
    pub patch: Option<usize>,
    /// The points.
    pub points: &'a [MapPoint],
}

/// A part of the extracted surface: the meshes of the patches come first, then that of the stock, each band by band along x.
/// Workpiece frame, mm.
#[derive(Clone, Copy)]
pub struct MeshPart<'a> {
    /// Number of the patch that it belongs to; none for the stock itself.
    pub patch: Option<usize>,
    /// Vertices of this mesh in the bands before.
    pub first: u32,
    /// No vertex of this band or a later one, and no triangle of them, reaches below this x.
    pub from_x: f64,
    /// Its vertices.
    pub positions: &'a [Point],
    /// Outward unit normals.
    pub normals: &'a [Vector],
    /// Signed deviation from the design at the vertices; not a number where no design surface applies; empty when there is no
    /// design.
    pub deviations: &'a [f64],
    /// Number of the motion piece, in the order of [`Batch::pieces`], that made the surface at the vertex; none for the skin of the raw
    /// stock; empty where it is not known.
    pub made_by: &'a [Option<u32>],
    /// Triangles by the numbers of vertices in the whole mesh: those of this band and of the one before.
    pub triangles: &'a [[u32; 3]],
}

/// The end of a run.
#[derive(Clone, Copy)]
pub struct Outcome<'a> {
    /// The judgement.
    pub verdict: &'a Verdict,
    /// Stock as it is left, workpiece frame.
    pub stock: &'a TriDexel,
    /// Its patches as they are left.
    pub patches: &'a [Patch],
    /// What the surface of the cut part was made of, whose points and meshes were shown before.
    pub surface: &'a SurfaceShape,
    /// Proof of the least clearances.
    pub proof: &'a ClearanceProof,
    /// Folder for the files of the run; it exists.
    pub folder: &'a Path,
}

/// Sees a run as it goes on. The engine knows nothing of files or viewers; Rerun, tables and reports implement this.
pub trait Observer: Send {
    /// Name for error texts and timing.
    fn name(&self) -> &'static str;

    /// Before the first command.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn begin(&mut self, setup: &Setup<'_>, folder: &Path) -> Result<(), ObserverError>;

    /// Whether it shows a [`Schedule`]: the motion of both programs is run for it, where no comparison has done so.
    fn shows_schedule(&self) -> bool {
        false
    }

    /// The program compared with the one that it is re-scheduled from, after [`Self::begin`]; not
    /// called where it is not re-scheduled, or where no observer shows it.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn schedule(&mut self, setup: &Setup<'_>, schedule: &Schedule) -> Result<(), ObserverError> {
        let _ = (setup, schedule);
        Ok(())
    }

    /// After each stretch.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn batch(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError>;

    /// Points of the cut part's surface, band by band, after the last stretch.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn surface_points(&mut self, setup: &Setup<'_>, band: &PointBand<'_>) -> Result<(), ObserverError> {
        let _ = (setup, band);
        Ok(())
    }

    /// The texture of each patch and profile of `[surface]`, after all points.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn surface_texture(&mut self, setup: &Setup<'_>, texture: &SurfaceTexture) -> Result<(), ObserverError> {
        let _ = (setup, texture);
        Ok(())
    }

    /// Free tool axes along the motion, where the call asks for them; after the textures.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn free_axes(&mut self, setup: &Setup<'_>, axes: &FreeAxes) -> Result<(), ObserverError> {
        let _ = (setup, axes);
        Ok(())
    }

    /// The extracted surface, band by band, after all points. `shape` says what all bands together are.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn surface_mesh(
        &mut self,
        setup: &Setup<'_>,
        shape: &SurfaceShape,
        part: &MeshPart<'_>,
    ) -> Result<(), ObserverError> {
        let _ = (setup, shape, part);
        Ok(())
    }

    /// After judgement.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn end(&mut self, setup: &Setup<'_>, outcome: &Outcome<'_>) -> Result<(), ObserverError>;
}
