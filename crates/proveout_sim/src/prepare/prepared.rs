//! Everything a run needs, read and checked before the first command is executed.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use proveout_controller::{Dynamics, servo::Plant};
use proveout_geom::{Pose, TriMesh};
use proveout_machine::Machine;
use proveout_nc::{Program, Settings as NcSettings, Survey};
use proveout_tool::{Profile, ToolLibrary};

use crate::{
    evidence::{
        digest,
        inputs::{FlatMesh, StepInput},
    },
    observe::schedule_rows::Schedule,
    prepare::{
        choice::Choice, error::SimError, made_program::MadeProgram, memory::Memory, part_on_table::PartOnTable,
        preview::Wanted, raw_stock::RawStock, texture_plan::Plan,
    },
    scene::{Scene, joint_limits::ChangedLimit},
    verdict::verdict_file::Probed,
};

/// A program on its scene, ready to run.
#[derive(Debug)]
pub struct Prepared {
    /// The scene.
    pub scene: Scene,
    /// Name of the program for people and folders.
    pub program_name: String,
    /// Its text.
    pub program_path: PathBuf,
    /// Lines of its text.
    pub program_lines: u32,
    /// The text that runs instead, where the program is re-scheduled from `program_path`.
    pub made: Option<MadeProgram>,
    /// The same text with other feeds, which runs in its place.
    pub(crate) with_feeds: Option<String>,
    /// Part and fixtures as the method has seen them, where the program is made.
    pub(crate) part_on_table: Option<PartOnTable>,
    /// The made program compared with the one before, where already known; a run makes the
    /// comparison where an observer asks for it.
    pub(crate) schedule: Option<Schedule>,
    /// Settings of the reader.
    pub nc_settings: NcSettings,
    /// Calls of the other readings of the program that the scene wants proved.
    pub(crate) other_readings: Vec<Choice>,
    /// Those of the text that a program is made from; the same where it is not made.
    pub source_nc_settings: NcSettings,
    /// Why the control file of scene or machine has no part in reading the program, where it has none.
    pub control_note: Option<String>,
    /// The machine, with the limits that the scene sets.
    pub machine: Machine,
    /// Those limits compared with the machine's own.
    pub changed_limits: Vec<ChangedLimit>,
    /// The machine as its file describes it, where the scene sets limits.
    pub own_machine: Option<Machine>,
    /// The tools.
    pub tools: ToolLibrary,
    /// For each tool the parts of its holder, widened by the clearance that the scene wants.
    pub holder_zones: Vec<Vec<Profile>>,
    /// Stock before the first cut with its patches, workpiece frame.
    pub stock: RawStock,
    /// Memory that the run was announced with.
    pub memory: Memory,
    /// Design mesh, workpiece frame.
    pub part_mesh: Option<TriMesh>,
    /// Largest distance of that mesh from the closed form of its blade, or from the surfaces of its STEP
    /// file, mm, where it was measured as the mesh was made.
    pub part_mesh_error: Option<f64>,
    /// Places of `[surface]`, where the scene has them.
    pub(crate) texture: Option<Plan>,
    /// Fixtures: name and closed mesh in the table frame.
    pub fixtures: Vec<(String, TriMesh)>,
    /// Workpiece frame to table frame.
    pub table_from_work: Pose,
    /// The place of the workpiece on the table was assumed.
    pub(crate) mount_assumed: bool,
    /// Least overhangs that were searched, by name of the tool, mm.
    pub least_overhang_mm: BTreeMap<String, f64>,
    /// Places along the motion at which the free tool axes are looked for; zero for none.
    pub free_axes: usize,
    /// Values that the call sets, by key.
    pub set: BTreeMap<String, String>,
    /// In what the run is less than the whole check.
    pub(crate) wanted: Wanted,
    /// Which motion cuts.
    pub dynamics: Dynamics,
    /// What moves under the forces of the drives.
    pub plant: Plant,
    /// SHA-256 of the input files by role.
    pub digests: BTreeMap<String, String>,
    /// The input files themselves.
    pub inputs: Vec<digest::InputFile>,
    /// Meshes of which some triangles have no area.
    pub(crate) flat_meshes: Vec<FlatMesh>,
    /// STEP files, with the chord errors that were measured.
    pub(crate) step_files: Vec<StepInput>,
    /// Program files as findings and tables name them, from the folder of the scene, by the names under which
    /// they were opened: a verdict does not depend on where the run was started.
    pub shown: BTreeMap<String, Arc<str>>,
    /// Result of reading the program to its end: no fault, and the text that its run does not
    /// reach.
    pub survey: Survey,
    /// What the probing motions of the program have met.
    pub(crate) probed: Vec<Probed>,
    /// Wall time of reading, and of measuring what the program probes, s.
    pub read_time: f64,
}

impl Prepared {
    /// Whether the motion is kept to the end of the run: where there is a design to hold the surface that it
    /// swept against.
    pub(crate) fn keeps_motion(&self) -> bool {
        self.scene.file.part.is_some()
    }

    /// The text that runs, as findings name it.
    pub fn running_file(&self) -> PathBuf {
        let shown = || PathBuf::from(self.shown_as(&self.program_path.display().to_string()));
        self.made.as_ref().map_or_else(shown, |made| PathBuf::from(&made.file))
    }

    /// A program file as findings name it.
    pub(crate) fn shown_as(&self, opened: &str) -> String {
        self.shown.get(opened).map_or_else(|| opened.to_owned(), |name| name.to_string())
    }

    /// The text that runs, as commands.
    ///
    /// # Errors
    /// What is wrong with the text as a whole.
    pub fn program(&self) -> Result<Program, SimError> {
        if let Some(text) = &self.with_feeds {
            // Subprograms are looked for where the program lies.
            let mut settings = self.nc_settings.clone();
            let folder = self.program_path.parent().unwrap_or(Path::new("")).to_owned();
            settings.subprogram_folders.insert(0, folder);
            return Ok(Program::from_text(&self.program_path.display().to_string(), text.as_str(), &settings)?);
        }
        Ok(match &self.made {
            Some(made) => Program::from_text(&made.file, made.text.as_str(), &self.nc_settings)?,
            None => Program::open(&self.program_path, &self.nc_settings)?,
        })
    }
}
