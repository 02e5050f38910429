//! One scene is one setup: machine, tools, stock, mounting, design, fixtures, offsets, tolerances and programs.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use proveout_geom::{Aabb, Document, InputError, Point, Pose, Vector, in_millimeters, rad, read_input};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::names;
pub use crate::scene_blade::{BladeFile, BladeKindFile, EndFile, EndPlatformFile, PlatformFile};
pub use crate::scene_choice::{ChoiceFile, ChoiceSourceFile, ChoiceValueFile};
pub use crate::scene_compare::{CompareFile, ExpectFile, FormFile, PublishedFile, QuantityFile};
pub use crate::scene_limits::JointLimitFile;
pub use crate::scene_patch::PatchFile;
pub use crate::scene_plan::{
    AxisFile, GivenAxisFile, HELIX, HelixFile, ParameterFile, PathFile, PlanFile, PostedFile, RulingsFile,
    StrategyFile, TimedByFile,
};
pub use crate::scene_reschedule::{ChannelFile, JunctionFile, MethodFile, RescheduleFile, ThetaUnitFile};
pub use crate::scene_run_limits::RunLimitsFile;
pub use crate::scene_surface::{
    ProfileDirectionFile, ProfileStandardFile, SettingClassFile, SpindlePhaseFile, SurfaceFile, SurfaceGridFile,
    SurfaceModelFile, SurfacePatchFile, SurfaceProfileFile,
};
pub use crate::scene_tolerance::{ToleranceRegionFile, Tolerances};

/// A scene as it stands in `scene.toml`. Paths are relative to the folder of the scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Unit of all lengths of this file. With `inch` every key that ends in `_mm` here ends in `_inch` (`_inch_min` for `_mm_min`), and one in
    /// millimeters is refused; meshes stay in millimeters, as they do not tell their unit.
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
    /// Work offsets of the control by their word, such as `G54`.
    #[serde(default)]
    pub work_offsets: BTreeMap<String, OffsetFile>,
    /// How the machine stands before the first block.
    #[serde(default)]
    pub start: StartFile,
    /// Control and dynamics.
    #[serde(default)]
    pub control: ControlFile,
    /// Where a run ends that would not end by itself.
    #[serde(default)]
    pub limits: RunLimitsFile,
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
    /// Engagement of the cutter for every block in `blocks.parquet`: axial depth, radial width, entry and exit angle, chip
    /// thickness. Costs time in the removal.
    #[serde(default)]
    pub engagement: bool,
}

/// Edges of the cells of the stock, mm.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "write one length in mm, or three for x, y and z")]
pub enum ResolutionFile {
    /// Cubes.
    Cube(f64),
    /// Along x, y and z of the workpiece frame.
    Edges([f64; 3]),
}

impl ResolutionFile {
    /// Along x, y and z.
    pub fn edges(self) -> [f64; 3] {
        match self {
            Self::Cube(edge) => [edge; 3],
            Self::Edges(edges) => edges,
        }
    }
}

/// Raw material in the workpiece frame: exactly one of the forms.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StockFile {
    /// Block.
    #[serde(rename = "box")]
    pub block: Option<BoxFile>,
    /// Round bar.
    pub cylinder: Option<CylinderFile>,
    /// Watertight mesh file, mm.
    pub mesh: Option<PathBuf>,
    /// The blade of `[part.blade]` with so much more material on its sides, mm.
    pub blade_allowance_mm: Option<f64>,
    /// What an earlier run left: its folder, or the `stock.dexel` in it. Taken over exactly where the cells stay and `place`
    /// turns by right angles only; re-gridded otherwise, with `removal.regrid_bound_mm` in the verdict.
    pub from_run: Option<PathBuf>,
    /// Workpiece frame of the earlier run in that of this scene; the same when left out. Only with `from_run`.
    pub place: Option<Mount>,
    /// The stock as it stood at this time of the earlier run, s, after the last motion that had ended; at its end when left
    /// out. The earlier run must have kept its `history`.
    pub at_time_s: Option<f64>,
    /// Remembers what every motion has changed, so that the stock at any time can be had from `stock.dexel`. Takes about 28
    /// bytes for each interval that a motion removes from a ray; given up, with a note, above 2 GiB.
    #[serde(default)]
    pub history: bool,
    /// Intervals of material that a ray will hold, as a mean over all rays, for the memory that is announced. Counted on the raw
    /// stock and the design when left out; parts with many fins or ribs cut from the full may need more.
    #[schemars(with = "Option<f64>")]
    pub intervals_per_ray: Option<Spanned<f64>>,
    /// Mends a `mesh` that is inside out or whose shells cross: faces are turned, and the union of the shells counts. Without it
    /// such a mesh is refused. A mesh with holes is refused in any case.
    #[serde(default)]
    pub repair: bool,
    /// Boxes in which the surface is wanted finer. Motions, findings and volumes are judged on the stock itself.
    #[serde(default)]
    #[schemars(with = "Vec<PatchFile>")]
    pub patch: Vec<Spanned<PatchFile>>,
    /// Density of the material, for the weight of parts that come off; that of steel, 7850, when left out.
    #[schemars(with = "Option<f64>")]
    pub density_kg_m3: Option<Spanned<f64>>,
    /// Where the numbers come from.
    #[serde(default)]
    pub source: String,
}

/// Density of steel, kg/m³: taken where a scene states none.
const STEEL_KG_M3: f64 = 7850.0;

impl StockFile {
    /// Density of the material, kg/m³.
    pub(crate) fn density(&self) -> f64 {
        self.density_kg_m3.as_ref().map_or(STEEL_KG_M3, |d| *d.get_ref())
    }
}

/// Axis-parallel box, mm.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxFile {
    /// Smallest coordinates.
    pub min_mm: [f64; 3],
    /// Largest coordinates.
    pub max_mm: [f64; 3],
}

/// Cylinder, mm.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderFile {
    /// Center of the end face with the smallest coordinate along its axis.
    pub base_mm: [f64; 3],
    /// Radius.
    pub radius_mm: f64,
    /// Length along its axis.
    pub height_mm: f64,
    /// Axis of its coordinates that the cylinder lies along: of a bar in a rotary table that turns about x, `x`.
    #[serde(default)]
    pub along: CylinderAxis,
}

/// Axis that a cylinder lies along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CylinderAxis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    #[default]
    Z,
}

impl CylinderAxis {
    /// Direction, of length one.
    pub fn direction(self) -> Vector {
        match self {
            Self::X => Vector::x(),
            Self::Y => Vector::y(),
            Self::Z => Vector::z(),
        }
    }

    /// Name of the axis of an index, as the key has it.
    pub(crate) fn name_of(index: usize) -> &'static str {
        ["x", "y", "z"][index.min(2)]
    }
}

/// Where the workpiece frame sits in the table frame (which equals the machine frame when all joints are at zero).
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mount {
    /// Origin of the workpiece frame, mm.
    #[serde(default)]
    pub translation_mm: [f64; 3],
    /// Turns about the fixed x, y and z axes, in this order, degrees.
    #[serde(default)]
    pub rotation_deg: [f64; 3],
    /// Nobody told the place: findings about what stands on the table say so.
    #[serde(default)]
    pub chosen: bool,
}

/// Design part: a mesh, or a surface with a closed form.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartFile {
    /// Watertight mesh file in the workpiece frame, mm.
    pub mesh: Option<PathBuf>,
    /// Largest distance of the mesh from the true design, mm: deviations below it are not judged.
    #[serde(default)]
    pub chord_error_mm: f64,
    /// Lateral face of a circular cone frustum.
    pub cone_frustum: Option<ConeFrustumFile>,
    /// Blade on a platform, or a face with a closed form.
    pub blade: Option<BladeFile>,
    /// File of the sections of a blade of kind `sections`, CSV; see docs/blades.md.
    pub sections: Option<PathBuf>,
    /// Only surface points in this box are judged, workpiece frame; everywhere when left out.
    pub judged: Option<BoxFile>,
}

/// Lateral face of a circular cone frustum; only surface points on it are judged.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConeFrustumFile {
    /// Apex, mm.
    pub apex_mm: [f64; 3],
    /// Direction from the apex into the cone.
    pub axis: [f64; 3],
    /// Half apex angle, degrees.
    pub half_angle_deg: f64,
    /// The face is judged between these distances from the apex along the axis, mm.
    pub from_mm: f64,
    /// See `from_mm`.
    pub to_mm: f64,
    /// Points farther than this from the cone belong to another face, mm.
    pub reach_mm: f64,
}

/// A body that stands on the table or on the bed.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixtureFile {
    /// Name in findings.
    pub name: String,
    /// Mesh file, mm.
    pub mesh: Option<PathBuf>,
    /// Block.
    #[serde(rename = "box")]
    pub block: Option<BoxFile>,
    /// Round body.
    pub cylinder: Option<CylinderFile>,
    /// Coordinates are those of the workpiece frame (default) or of the table frame.
    #[serde(default)]
    pub frame: FixtureFrame,
    /// Where the numbers come from.
    #[serde(default)]
    pub source: String,
}

/// Frame of a fixture's coordinates; it moves with the table in both cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FixtureFrame {
    /// Workpiece frame.
    #[default]
    Workpiece,
    /// Table frame.
    Table,
}

/// A work offset of the control.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case, reason = "axis letters as the machinist writes them")]
pub struct OffsetFile {
    /// mm.
    #[serde(default)]
    pub X_mm: f64,
    /// mm.
    #[serde(default)]
    pub Y_mm: f64,
    /// mm.
    #[serde(default)]
    pub Z_mm: f64,
    /// degrees.
    #[serde(default)]
    pub A_deg: f64,
    /// degrees.
    #[serde(default)]
    pub B_deg: f64,
    /// degrees.
    #[serde(default)]
    pub C_deg: f64,
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

/// How the machine stands before the first block of each program.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StartFile {
    /// Number of the tool in the spindle, for programs that call none before they cut; an empty spindle when left out. Its length is active
    /// where it is behind a tool change (840D, Klartext, CL data), elsewhere behind G43.
    pub tool: Option<u32>,
}

/// Which motion cuts the stock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum DynamicsFile {
    /// The programmed path without corner rounding, at the planned times.
    Ideal,
    /// The set points of the control: corners rounded within the tolerance.
    #[default]
    Planned,
    /// What the drives make of the set points; the machine must describe its drives.
    Servo,
}

/// What moves under the forces of the drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlantFile {
    /// One mass a joint, loaded by recursive Newton-Euler.
    #[default]
    NewtonEuler,
    /// Coupled rigid bodies in Rapier; every body needs a mass.
    Rapier,
}

/// Control and dynamics.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControlFile {
    /// Control file that says what words of the programs mean: the name of a built-in one (fanuc-30i), or a path from the folder of
    /// the scene; otherwise that of the machine. Programs in another language are read without it.
    pub file: Option<String>,
    /// Which motion cuts the stock.
    #[serde(default)]
    pub dynamics: DynamicsFile,
    /// What moves under the forces of the drives, for dynamics = "servo".
    #[serde(default)]
    pub plant: PlantFile,
    /// Corner tolerance where the program sets none, mm; otherwise as the machine says.
    pub path_tolerance_mm: Option<f64>,
    /// By how much the pieces of motion that cut may leave the true motion at the cutting edges, mm; 0.0005 when left out.
    #[schemars(with = "Option<f64>")]
    pub piece_tolerance_mm: Option<Spanned<f64>>,
    /// Cone about a pole of the rotary axes, 0 to 5 degrees: a great circle of the tool axis that passes the pole nearer than this
    /// is led through it, which a finding tells; otherwise as the machine says.
    pub pole_cone_deg: Option<f64>,
    /// Limits of joints below those of the machine, by joint; in force for all programs.
    #[serde(default)]
    pub joint_limits: BTreeMap<String, JointLimitFile>,
}

/// One named program.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProgramFile {
    /// Name.
    pub name: String,
    /// Program text, relative to the scene; left out where the text is not ours: give it with `--nc`.
    pub file: Option<PathBuf>,
    /// Table under `[plan]` that writes `file`, for choices of `compare` that change the plan.
    pub planned: Option<String>,
    /// How the tool axis stands instead of what that table says, for `planned` by contacts.
    pub planned_axis: Option<AxisFile>,
    /// How the program is made from another one of this scene, instead of `file`.
    pub reschedule: Option<RescheduleFile>,
    /// Dialect; found from the ending and the text when left out.
    pub dialect: Option<String>,
    /// Machine for this program, where it is not the scene's.
    pub machine: Option<PathBuf>,
    /// Work offsets for this program, where they are not the scene's.
    pub work_offsets: Option<BTreeMap<String, OffsetFile>>,
    /// Mounting for this program, where it is not the scene's.
    pub mount: Option<Mount>,
    /// Dynamics for this program, where they are not the scene's.
    pub dynamics: Option<DynamicsFile>,
}

/// A measurement on the cut part, from a point along one axis direction.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InspectFile {
    /// Name of the feature.
    pub name: String,
    /// What is measured.
    #[serde(default)]
    pub kind: InspectKindFile,
    /// Start of the touch in the workpiece frame, mm.
    #[schemars(with = "[f64; 3]")]
    pub from_mm: Spanned<[f64; 3]>,
    /// `+x`, `-x`, `+y`, `-y`, `+z` or `-z`.
    #[schemars(with = "String")]
    pub direction: Spanned<String>,
    /// Nominal coordinate of the surface along that axis in the workpiece frame, or nominal thickness, mm.
    pub nominal_mm: f64,
    /// Allowed deviation to both sides, mm.
    pub tolerance_mm: f64,
}

/// What a feature of the inspection plan measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum InspectKindFile {
    /// Coordinate of the first material from the start on.
    #[default]
    Touch,
    /// Thickness of the wall that holds the start or comes first after it, as a caliper along the direction reads it.
    Thickness,
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

impl Scene {
    /// Reads a scene; `path` is its folder or its file.
    ///
    /// # Errors
    /// [`InputError`] with file, line, column and remedy for the first fault.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        const MADE: &str =
            "name the folder of a scene; `proveout new PROGRAM --machine NAME` makes one of an NC program";
        if path.is_dir() && !path.join("scene.toml").exists() {
            return Err(InputError::file(path, "the folder holds no scene.toml", MADE));
        }
        if path.is_file() && path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("toml")) {
            return Err(InputError::file(path, "the file is no scene: scenes are TOML", MADE));
        }
        let path = if path.is_dir() { path.join("scene.toml") } else { path.to_owned() };
        let text = read_input(&path)?;
        Self::of_text(path, &text)
    }

    /// A scene from its text; `path` is the file that it stands for.
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

    /// A path of the scene file as one to open.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
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

    /// This scene with the table that writes a program as that program wants it.
    pub fn planned_for(&self, program: &ProgramFile) -> Cow<'_, Self> {
        let strategy = program.planned.as_deref().and_then(StrategyFile::named);
        let (Some(strategy), Some(axis)) = (strategy, &program.planned_axis) else { return Cow::Borrowed(self) };
        let mut own = self.clone();
        if let Some(table) = own.file.plan.as_mut().and_then(|plan| strategy.of_mut(plan)) {
            table.axis = axis.clone();
        }
        Cow::Owned(own)
    }
}

impl Mount {
    /// Workpiece frame to table frame.
    pub fn table_from_work(&self) -> Pose {
        let [x, y, z] = self.rotation_deg.map(rad);
        Pose::from_rpy(Vector::from(self.translation_mm), x, y, z)
    }
}

impl BoxFile {
    /// As a box.
    pub fn aabb(&self) -> Aabb {
        Aabb { min: Point::from(self.min_mm), max: Point::from(self.max_mm) }
    }
}

fn check(path: &Path, text: &str, file: &SceneFile) -> Result<(), InputError> {
    let fault = |offset: usize, message: String, help: &str| Err(InputError::at(path, text, offset, message, help));
    let cells = file.resolution_mm.get_ref().edges();
    if let Some(cell) = cells.iter().find(|c| !(**c > 0.0 && c.is_finite())) {
        let at = file.resolution_mm.span().start;
        return fault(at, format!("resolution_mm = {cell} is not a positive length"), "write for example 0.2");
    }
    if file.limits.blocks == Some(0) {
        let at = text.find("blocks").unwrap_or(0);
        let message = format!("`limits.blocks` = 0 is out of range: 1 to {}", u32::MAX);
        return fault(at, message, "leave it out for ten million");
    }
    // These become names of files and folders.
    let patches = file.stock.get_ref().patch.iter().map(|p| &p.get_ref().name);
    let programs = file.program.iter().map(|p| &p.name);
    for name in std::iter::once(&file.name).chain(programs).chain(patches) {
        if let Some(message) = names::fault(name) {
            let at = text.find(&format!("\"{name}\"")).unwrap_or(0);
            return fault(at, message, names::REMEDY);
        }
    }
    if let Some((at, message, help)) = crate::scene_numbers::fault(text, file) {
        return fault(at, message, help);
    }
    let stock = file.stock.get_ref();
    let forms = [
        stock.block.is_some(),
        stock.cylinder.is_some(),
        stock.mesh.is_some(),
        stock.blade_allowance_mm.is_some(),
        stock.from_run.is_some(),
    ];
    let forms = forms.into_iter().filter(|given| *given).count();
    if forms != 1 {
        let at = file.stock.span().start;
        return fault(
            at,
            format!("the stock has {forms} forms"),
            "give exactly one of `box`, `cylinder`, `mesh`, `blade_allowance_mm`, `from_run`",
        );
    }
    let of_a_run = stock.place.is_some() || stock.at_time_s.is_some();
    if of_a_run && stock.from_run.is_none() || stock.repair && stock.mesh.is_none() {
        let key = if of_a_run { "`place` and `at_time_s` belong to `from_run`" } else { "`repair` belongs to `mesh`" };
        return fault(file.stock.span().start, key.into(), "leave it out, or give the stock in that form");
    }
    if let Some(told) = stock.density_kg_m3.as_ref().filter(|d| !(100.0..=25_000.0).contains(d.get_ref())) {
        let message = format!("density_kg_m3 = {} is no density of a material that is cut", told.get_ref());
        let help = "write it in kg/m3, 100 to 25000: 7850 for steel, 2700 for aluminum";
        return Err(InputError::at(path, text, told.span().start, message, help));
    }
    if let Some(told) = stock.intervals_per_ray.as_ref().filter(|n| !(1.0..=1000.0).contains(n.get_ref())) {
        let message = format!("intervals_per_ray = {} is no number of intervals", told.get_ref());
        return fault(told.span().start, message, "write a number from 1 to 1000, or leave it out");
    }
    if let Some(b) = stock.block
        && !(0..3).all(|i| b.min_mm[i] < b.max_mm[i])
    {
        let at = file.stock.span().start;
        return fault(at, format!("box {:?} to {:?} holds nothing", b.min_mm, b.max_mm), "min_mm must be below max_mm");
    }
    if let Some(c) = stock.cylinder
        && !(c.radius_mm > 0.0 && c.height_mm > 0.0)
    {
        let at = file.stock.span().start;
        return fault(at, "the cylinder holds nothing".into(), "radius_mm and height_mm must be above 0");
    }
    if let Some(part) = &file.part {
        let fault =
            |message: &str, help: &str| Err(InputError::at(path, text, text.find("[part").unwrap_or(0), message, help));
        let forms = [part.mesh.is_some(), part.cone_frustum.is_some(), part.blade.is_some()];
        if forms.into_iter().filter(|given| *given).count() != 1 {
            return fault("the part needs exactly one form", "give one of `mesh`, `cone_frustum`, `blade`");
        }
        if let Some(b) = part.judged
            && !(0..3).all(|i| b.min_mm[i] < b.max_mm[i])
        {
            return fault("the judged box holds nothing", "min_mm must be below max_mm");
        }
        match &part.blade {
            Some(blade) => {
                if let Some((message, help)) = blade.fault(part.sections.is_some()) {
                    return fault(&message, &help);
                }
            }
            None if part.sections.is_some() => {
                return fault("`sections` belongs to a blade", "give [part.blade] with kind = \"sections\"");
            }
            None => {}
        }
        if part.blade.is_some_and(|b| !(1e-5..=1.0).contains(&b.chord_error_mm)) {
            return fault("chord_error_mm of the blade is out of range", "give 0.00001 to 1 mm");
        }
        if part.chord_error_mm.is_nan() || part.chord_error_mm < 0.0 {
            return fault(
                "chord_error_mm must not be negative",
                "give the largest distance of the mesh from the design",
            );
        }
        if let Some(c) = part.cone_frustum
            && !(c.half_angle_deg > 0.0
                && c.half_angle_deg < 90.0
                && 0.0 <= c.from_mm
                && c.from_mm < c.to_mm
                && c.reach_mm > 0.0
                && Vector::from(c.axis).norm() > 1e-9)
        {
            return fault(
                "the cone frustum is not one",
                "half_angle_deg between 0 and 90, 0 <= from_mm < to_mm, reach_mm above 0, axis with a length",
            );
        }
    }
    if let Some((at, message, help)) = file.tolerances.fault(text, file.part.is_some()) {
        return fault(at, message, help);
    }
    for probe in &file.inspect {
        if probe_direction(probe.direction.get_ref()).is_none() {
            let at = probe.direction.span().start;
            let message = format!("direction {:?} is not an axis direction", probe.direction.get_ref());
            return fault(at, message, "write one of \"+x\", \"-x\", \"+y\", \"-y\", \"+z\", \"-z\"");
        }
    }
    let stock_blade = stock.blade_allowance_mm.is_some_and(|a| !(0.0..1e3).contains(&a));
    if stock_blade || stock.blade_allowance_mm.is_some() && file.part.as_ref().is_none_or(|p| p.blade.is_none()) {
        let at = file.stock.span().start;
        let help = "give an allowance from 0 mm, and the blade as [part.blade]";
        return fault(at, "blade_allowance_mm has no blade to stand on, or is no allowance".into(), help);
    }
    for (i, program) in file.program.iter().enumerate() {
        if program.reschedule.is_some() && program.file.is_some() {
            let at = text.rfind(&format!("{:?}", program.name)).unwrap_or(0);
            let message = format!("program {:?} has a text and is re-scheduled", program.name);
            return fault(at, message, "give either `file` or `reschedule`");
        }
        let plan = |name: &str| {
            let plans = file.plan.as_ref();
            let helix = name == HELIX.0 && plans.is_some_and(|p| p.helix.is_some());
            helix || StrategyFile::named(name).is_some_and(|s| plans.is_some_and(|p| s.of(p).is_some()))
        };
        if let Some(name) = program.planned.as_deref().filter(|name| program.file.is_none() || !plan(name)) {
            let at = text.rfind(&format!("{:?}", program.name)).unwrap_or(0);
            let message =
                format!("program {:?} is planned by {name:?}, which writes no file of this scene", program.name);
            return fault(at, message, "name a table under [plan], for a program with a file");
        }
        let by_contacts = program.planned.as_deref().is_some_and(|name| StrategyFile::named(name).is_some());
        if program.planned_axis.is_some() && !by_contacts {
            let at = text.rfind(&format!("{:?}", program.name)).unwrap_or(0);
            let message = format!("program {:?} gives `planned_axis` without a plan that reads it", program.name);
            return fault(at, message, "name a table under [plan] other than helix as `planned`, or leave it out");
        }
        if let Some(reschedule) = &program.reschedule
            && let Some(key) = reschedule.unread()
        {
            let at = text.rfind(&format!("{:?}", program.name)).unwrap_or(0);
            let read = reschedule.read().join(", ");
            let message = format!("program {:?} gives `{key}`, which its method does not read", program.name);
            return fault(at, message, &format!("leave it out; options of the method: {read}"));
        }
        if let Some(reschedule) = &program.reschedule
            && !file.program.iter().any(|p| p.name == reschedule.from && p.file.is_some())
        {
            let at = text.rfind(&format!("{:?}", program.name)).unwrap_or(0);
            let message =
                format!("program {:?} is made from {:?}, which has no text here", program.name, reschedule.from);
            return fault(at, message, "name a program of this scene that has a file");
        }
        if file.program[..i].iter().any(|p| p.name == program.name) {
            let at = text.rfind(&format!("{:?}", program.name)).unwrap_or(0);
            return fault(at, format!("two programs are named {:?}", program.name), "give each its own name");
        }
    }
    crate::scene_patch::check(path, text, &stock.patch)?;
    if let Some(surface) = &file.surface {
        crate::scene_surface::check(path, text, surface)?;
    }
    crate::scene_compare::check(path, text, file)
}

/// Axis index and sign of a direction word.
pub fn probe_direction(word: &str) -> Option<(usize, f64)> {
    let axis = match word.get(1..)? {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        _ => return None,
    };
    match word.as_bytes()[0] {
        b'+' => Some((axis, 1.0)),
        b'-' => Some((axis, -1.0)),
        _ => None,
    }
}
