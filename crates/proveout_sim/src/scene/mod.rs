//! One scene is one setup: machine, tools, stock, mounting, design, fixtures, offsets, tolerances and
//! programs.
//!
//! | file | what it does |
//! |---|---|
//! | `asked.rs` | what the scene does not have: workholding, design, gates that it does not ask |
//! | `blade.rs` | blades, their platforms and ends |
//! | `choice.rs` | what a published experiment leaves open |
//! | `compare.rs` | baseline, stretch and published values of a comparison |
//! | `control.rs` | control and dynamics |
//! | `fixture.rs` | fixtures by their dimensions |
//! | `inspect.rs` | touches and walls to be measured on the cut part |
//! | `joint_limits.rs` | joint limits below those of the machine |
//! | `mesh_unit.rs` | unit and place of meshes |
//! | `names.rs` | names that become file names |
//! | `numbers.rs` | ranges that no unit implies |
//! | `part.rs` | the design part |
//! | `patch.rs` | boxes with finer cells |
//! | `place.rs` | the place of a key in the text |
//! | `plan.rs` | what `proveout plan` makes |
//! | `program.rs` | programs: read, planned or re-scheduled |
//! | `reschedule.rs` | the re-scheduling method and its options |
//! | `run_limits.rs` | the end of a run that would not end |
//! | `setup.rs` | mounting, fixtures, work offsets, start of the machine |
//! | `stock.rs` | raw stock and its cells |
//! | `surface.rs` | `[surface]`: patches, profiles, spindle phases |
//! | `tolerance.rs` | `[tolerances]` and regions with their own |

pub(crate) mod asked;
pub(crate) mod blade;
pub(crate) mod choice;
pub(crate) mod compare;
pub(crate) mod control;
pub(crate) mod fixture;
pub(crate) mod inspect;
pub(crate) mod joint_limits;
pub(crate) mod mesh_unit;
pub(crate) mod names;
pub(crate) mod numbers;
pub(crate) mod part;
pub(crate) mod patch;
pub(crate) mod place;
pub(crate) mod plan;
pub(crate) mod program;
pub(crate) mod reschedule;
pub(crate) mod run_limits;
pub(crate) mod setup;
pub(crate) mod step_file;
pub(crate) mod stock;
pub(crate) mod surface;
pub(crate) mod tolerance;

use std::{
    collections::BTreeMap,
    path::{Component, Path, PathBuf},
};

pub use proveout_controller::{Dynamics, servo::Plant};
use proveout_input::{Document, InputError, Step::Item, Step::Key, in_millimeters, read_input};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

pub use self::asked::{GatesFile, NoneFile};
pub use self::blade::{BladeFile, BladeKindFile, EndFile, EndPlatformFile, PlatformFile};
pub use self::choice::{ChoiceFile, ChoiceSourceFile, ChoiceValueFile};
pub use self::compare::{CompareFile, ExpectFile, FormFile, PublishedFile, PublishedKindFile, QuantityFile};
pub use self::control::ControlFile;
pub use self::fixture::FixtureKindFile;
pub use self::inspect::{InspectFile, InspectKindFile, probe_direction};
pub use self::joint_limits::JointLimitFile;
pub use self::mesh_unit::MeshUnitFile;
pub use self::part::{ConeFrustumFile, PartFile};
pub use self::patch::PatchFile;
pub use self::plan::{
    AxisFile, FeedReferenceFile, GivenAxisFile, HELIX, HelixFile, ParameterFile, PathFile, PlanFile, PostedFile,
    RulingsFile, StrategyFile,
};
pub use self::program::{ProgramFile, SwitchFile};
pub use self::reschedule::{ChannelFile, InsetFile, InsetWordFile, KeyAxesFile, MethodFile, RescheduleFile};
pub use self::run_limits::RunLimitsFile;
pub use self::setup::{FixtureFile, FixtureFrame, Mount, OffsetFile, StartFile};
pub use self::stock::{BoxFile, CylinderAxis, CylinderFile, ResolutionFile, StockFile};
pub use self::surface::{
    ProfileDirectionFile, SpindlePhaseFile, SurfaceFile, SurfaceGridFile, SurfaceModelFile, SurfacePatchFile,
    SurfaceProfileFile,
};
pub use self::tolerance::{ToleranceRegionFile, Tolerances};
use crate::scene::{place::offset_of, stock::resolution_fault};

/// A scene, as written in `scene.toml`. Paths are relative to the folder of the scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Unit of all lengths of this file. With `inch` every key that ends in `_mm` here ends in
    /// `_inch` (`_inch_min` for `_mm_min`), and one in millimeters is refused; meshes stay in
    /// millimeters, as they do not state their unit.
    #[serde(default)]
    pub unit: UnitFile,
    /// Short name.
    pub name: String,
    /// What the scene shows.
    #[serde(default)]
    pub description: String,
    /// Folder of the machine.
    pub machine: PathBuf,
    /// Tool library.
    pub tools: PathBuf,
    /// Distance of neighboring rays of the stock, mm: one for all, or along x, y and z.
    #[schemars(with = "ResolutionFile")]
    pub resolution_mm: Spanned<ResolutionFile>,
    /// Raw material.
    #[schemars(with = "StockFile")]
    pub stock: Spanned<StockFile>,
    /// Workpiece frame on the table.
    #[serde(default)]
    pub mount: Mount,
    /// Design part, in the workpiece frame.
    pub part: Option<PartFile>,
    /// Fixtures and platforms.
    #[serde(default)]
    pub fixture: Vec<FixtureFile>,
    /// `"none"`: nothing holds the part, and `workholding_reason` says why. Without this and without
    /// `[[fixture]]` the gates `collision` and `near_miss` are unchecked.
    pub workholding: Option<NoneFile>,
    /// Why the scene has no workholding; gate, report and setup sheet show it.
    pub workholding_reason: Option<String>,
    /// `"none"`: the scene has no design, and the gates `gouge` and `excess` are not asked.
    pub design: Option<NoneFile>,
    /// Gates that are not asked.
    #[serde(default)]
    pub gates: GatesFile,
    /// Work offsets of the control by their word, such as `G54`.
    #[serde(default)]
    pub work_offsets: BTreeMap<String, OffsetFile>,
    /// State of the machine before the first block.
    #[serde(default)]
    pub start: StartFile,
    /// Control and dynamics.
    #[serde(default)]
    pub control: ControlFile,
    /// Where a run ends that would not end by itself.
    #[serde(default)]
    pub run_limits: RunLimitsFile,
    /// Bounds of the gates.
    #[serde(default)]
    pub tolerances: Tolerances,
    /// Programs, the first one is run by default.
    #[serde(default)]
    pub program: Vec<ProgramFile>,
    /// Texture of the cut surface.
    pub surface: Option<SurfaceFile>,
    /// Features to measure on the cut part.
    #[serde(default)]
    pub inspect: Vec<InspectFile>,
    /// What `proveout plan` makes for this scene.
    pub plan: Option<PlanFile>,
    /// How `proveout compare` compares its programs.
    pub compare: Option<CompareFile>,
    /// Engagement of the cutter for every block in `blocks.parquet`: axial depth, radial width, entry and
    /// exit angle, chip thickness. Costs time in the removal.
    #[serde(default)]
    pub engagement: bool,
}

/// Unit of the lengths of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum UnitFile {
    /// Millimeters: keys end in `_mm`.
    #[default]
    Mm,
    /// Inches: keys end in `_inch`.
    Inch,
}

/// A scene with its place and text.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What the file says.
    pub file: SceneFile,
    /// Path of `scene.toml`.
    pub path: PathBuf,
    /// Folder that relative paths start from.
    pub folder: PathBuf,
    /// Whether a call has set values: places in the text are then not those of the file.
    pub(crate) values_set: bool,
}

/// A path without `folder/..`, which a person has to read past. After a link `..` leads elsewhere:
/// the shorter path is taken where it is the same file.
fn without_detours(path: PathBuf) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        let up = part == Component::ParentDir && matches!(short.components().next_back(), Some(Component::Normal(_)));
        if !(up && short.pop()) {
            short.push(part);
        }
    }
    match (path.canonicalize(), short.canonicalize()) {
        (Ok(a), Ok(b)) if a == b => short,
        _ => path,
    }
}

impl Scene {
    /// Reads a scene; `path` is its folder or its file.
    ///
    /// # Errors
    /// [`InputError`] with file, line, column and remedy for the first fault.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        const MADE: &str =
            "name the folder of a scene; `proveout new PROGRAM --machine NAME` creates one from an NC program";
        if path.is_dir() && !path.join("scene.toml").exists() {
            return Err(InputError::file(path, "the folder holds no scene.toml", MADE));
        }
        if path.is_file() && path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("toml")) {
            return Err(InputError::file(path, "the file is not a scene: scenes are TOML", MADE));
        }
        let path = if path.is_dir() { path.join("scene.toml") } else { path.to_owned() };
        let text = read_input(&path)?;
        Self::of_text(path, &text)
    }

    /// A scene from its text; `path` is the file that the text is taken from.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(crate) fn of_text(path: PathBuf, text: &str) -> Result<Self, InputError> {
        let text = in_millimeters(&path, text)?;
        let file: SceneFile = Document::new(&path, &text).read()?;
        check(&path, &text, &file)?;
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
        Ok(Self { file, path, folder, values_set: false })
    }

    /// A path of the scene file as one to open, without `folder/..` in it where that is the same file.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        without_detours(self.folder.join(path))
    }

    /// A fault at a byte offset of the scene file.
    pub(crate) fn fault(&self, offset: usize, message: impl Into<String>, help: impl Into<String>) -> InputError {
        match read_input(&self.path) {
            Ok(text) if !self.values_set => InputError::at(&self.path, &text, offset, message, help),
            _ => InputError::file(&self.path, message, help),
        }
    }

    /// The program with this name, or the first one.
    pub fn program(&self, name: Option<&str>) -> Option<&ProgramFile> {
        match name {
            Some(name) => self.file.program.iter().find(|p| p.name == name),
            None => self.file.program.first(),
        }
    }
}

fn check(path: &Path, text: &str, file: &SceneFile) -> Result<(), InputError> {
    let fault = |offset: usize, message: String, help: &str| Err(InputError::at(path, text, offset, message, help));
    let cells = file.resolution_mm.get_ref().edges();
    if let Some(message) = cells.iter().find_map(|cell| resolution_fault(*cell)) {
        return fault(file.resolution_mm.span().start, message, "write for example 0.2");
    }
    if file.run_limits.blocks == Some(0) {
        let at = offset_of(text, &[Key("run_limits"), Key("blocks")]);
        let message = format!("`run_limits.blocks` = 0 is out of range: 1 to {}", u32::MAX);
        return fault(at, message, "leave it out for the default, ten million");
    }
    // These become names of files and folders.
    let patches = file.stock.get_ref().patch.iter().enumerate();
    let patches = patches.map(|(i, p)| (vec![Key("stock"), Key("patch"), Item(i), Key("name")], &p.get_ref().name));
    let programs = file.program.iter().enumerate();
    let programs = programs.map(|(i, p)| (vec![Key("program"), Item(i), Key("name")], &p.name));
    for (path, name) in std::iter::once((vec![Key("name")], &file.name)).chain(programs).chain(patches) {
        if let Some(message) = names::fault(name) {
            return fault(offset_of(text, &path), message, names::REMEDY);
        }
    }
    if let Some((at, message, help)) = numbers::fault(text, file) {
        return fault(at, message, help);
    }
    if let Some((at, message, help)) = setup::fixture_fault(text, &file.fixture) {
        return fault(at, message, &help);
    }
    if let Some((at, message, help)) = asked::fault(text, file) {
        return fault(at, message, &help);
    }
    stock::check(path, text, file)?;
    if let Some(part) = &file.part {
        part::check(path, text, part)?;
    }
    if let Some((at, message, help)) = file.tolerances.fault(text, file.part.is_some()) {
        return fault(at, message, help);
    }
    inspect::check(path, text, &file.inspect)?;
    stock::check_blade(path, text, file)?;
    program::check(path, text, file)?;
    patch::check(path, text, &file.stock.get_ref().patch)?;
    if let Some(surface) = &file.surface {
        surface::check(path, text, surface)?;
    }
    compare::check(path, text, file)
}
