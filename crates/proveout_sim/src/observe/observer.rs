//! The trait that recorders, reports and progress bars implement.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use proveout_controller::{Dynamics, Event, Piece, Sample, servo::Plant};
use proveout_geom::{Pose, TriMesh};
use proveout_machine::Machine;
use proveout_stock::{Patch, TileId, TriDexel};
use proveout_tool::ToolLibrary;

use crate::{
    observe::{
        free_axes_map::FreeAxes, schedule_rows::Schedule, surface_map::SurfaceShape, surface_texture::SurfaceTexture,
    },
    prepare::made_program::MadeProgram,
    scene::Scene,
    verdict::{finding::Finding, verdict_file::Verdict},
};

pub use crate::observe::{
    block_rows::{BlockRow, ClearanceProof, LooseMotion, SampleSignals},
    observer_error::ObserverError,
    surface_map::{MeshPart, PointBand},
};

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
    /// Program files as findings and blocks name them, by the names under which they were opened; see
    /// [`crate::run::listing`].
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

/// Sees a run as it goes on. The engine knows nothing of files or viewers; Rerun, tables and reports
/// implement this.
pub trait Observer: Send {
    /// Name for error texts and timing.
    fn name(&self) -> &'static str;

    /// Before the first command.
    ///
    /// # Errors
    /// When the observer cannot write.
    fn begin(&mut self, setup: &Setup<'_>, folder: &Path) -> Result<(), ObserverError>;

    /// Whether it shows a [`Schedule`]: the motion of both programs is run for it, where no comparison has
    /// done so.
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
