//! Texture of the cut surface: `[surface]` of a scene, its patches, grids of patches, profiles and spindle
//! phases.

use std::path::Path;

use proveout_input::{InputError, Step::Key};
use proveout_surface::texture::{SettingClass, Standard};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::{scene::place::offset_of, units::UM_PER_MM};

/// Longest name of a patch: it becomes part of a file name.
const LONGEST_NAME: usize = 40;
/// Most nodes of a patch: 4000 x 4000.
const MOST_NODES: f64 = 16e6;
/// Most patches of a scene.
const MOST_PATCHES: usize = 10_000;
/// Most repetitions with random spindle phases.
const MOST_PHASES: u32 = 100;
/// Largest coordinate, mm, and largest angle, degrees.
const FARTHEST: f64 = 1e6;
/// Shorter and longer vectors are no direction.
const SHORTEST: f64 = 1e-9;
const LONGEST: f64 = 1e9;
/// Steps of a map, micrometers: wider than what instruments sample with.
const STEP_UM: std::ops::RangeInclusive<f64> = 0.01..=1e4;
/// Sides of a map, mm.
const SIDE_MM: std::ops::RangeInclusive<f64> = 0.001..=1e3;
/// Part of a spacing that a side may lack for one more patch: rounding.
const ROUNDING: f64 = 1e-9;

/// What leaves the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceModelFile {
    /// The nominal cutter along its motion: rows between passes, without marks of single teeth and without
    /// run-out.
    #[default]
    Envelope,
    /// The edges of the teeth, with run-out, spindle speed and phase; the tool library must describe them.
    Teeth,
}

/// Texture of the cut surface, on patches and profiles of the design: `[surface]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceFile {
    /// What leaves the surface.
    #[serde(default)]
    pub model: SurfaceModelFile,
    /// Sides of the patches, mm, where a patch gives none: along its columns and across.
    #[serde(default = "default_size")]
    pub size_mm: [f64; 2],
    /// Spacing of the nodes, µm, where a patch gives none.
    #[serde(default = "default_step")]
    pub step_um: f64,
    /// Heights above this over the design count as not cut, mm.
    #[serde(default = "default_height")]
    pub max_height_mm: f64,
    /// Definitions of the profile parameters.
    #[serde(default)]
    pub standard: Standard,
    /// Setting class to begin with, of profiles and of the L-filter of patches: Sc3 when left out. Where the
    /// marks lie farther apart than its cut-off, the next class is taken, and said to be.
    pub class: Option<SettingClass>,
    /// Profiles through the middle of every patch, across and along the lay.
    #[serde(default = "default_true")]
    pub profiles: bool,
    /// Repetitions with random spindle phases, for teeth whose phase is not given.
    #[serde(default = "default_random_phases")]
    pub random_phases: u32,
    /// Seed of the random phases.
    #[serde(default)]
    pub seed: u32,
    /// Writes all nodes: a row each in `surface.parquet`, and `maps/NAME.sdf` and `.x3p` of the run folder.
    #[serde(default = "default_true")]
    pub save_nodes: bool,
    /// Patches.
    #[serde(default)]
    #[schemars(with = "Vec<SurfacePatchFile>")]
    pub patch: Vec<Spanned<SurfacePatchFile>>,
    /// Patches in rows and columns.
    #[serde(default)]
    #[schemars(with = "Vec<SurfaceGridFile>")]
    pub grid: Vec<Spanned<SurfaceGridFile>>,
    /// Profiles anywhere.
    #[serde(default)]
    #[schemars(with = "Vec<SurfaceProfileFile>")]
    pub profile: Vec<Spanned<SurfaceProfileFile>>,
    /// Spindle phases, where they are known.
    #[serde(default)]
    #[schemars(with = "Vec<SpindlePhaseFile>")]
    pub phase: Vec<Spanned<SpindlePhaseFile>>,
}

fn default_size() -> [f64; 2] {
    [4.0, 4.0]
}

fn default_step() -> f64 {
    5.0
}

fn default_height() -> f64 {
    0.5
}

fn default_true() -> bool {
    true
}

fn default_random_phases() -> u32 {
    4
}

/// A rectangle on the design: `[[surface.patch]]`. It lies at `at_mm`, or on a blade at `arc_mm` and `x_mm`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfacePatchFile {
    /// Name, unique in the scene: letters, digits, `-` and `_`.
    pub name: String,
    /// Middle of the patch in the workpiece frame, mm: the nearest point of the design counts.
    pub at_mm: Option<[f64; 3]>,
    /// On a blade: arc length on the section from the leading end of the pressure side, mm.
    pub arc_mm: Option<f64>,
    /// On a blade: height above the platform, mm.
    pub x_mm: Option<f64>,
    /// Makes the patch a plane of its own through `at_mm` with this outward normal; no design is asked.
    pub normal: Option<[f64; 3]>,
    /// Direction of the columns, laid into the surface; left out, along the section of a blade,
    /// elsewhere X, or Y where X is normal to the surface.
    pub along: Option<[f64; 3]>,
    /// Sides, mm.
    pub size_mm: Option<[f64; 2]>,
    /// Spacing of the nodes, µm.
    pub step_um: Option<f64>,
}

/// Patches in rows and columns over the design: `[[surface.grid]]`. On a blade over ranges of `arc_mm` and
/// `x_mm`, elsewhere over the parallelogram of `corner_mm`, `u_mm` and `v_mm`, whose points are projected on
/// the design.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceGridFile {
    /// Name; the patches are `NAME-ROW-COLUMN`.
    pub name: String,
    /// Patches along both directions; the outer ones have their middles on the ends of the ranges.
    pub count: Option<[u32; 2]>,
    /// Instead of `count`: distance of the middles, mm.
    pub spacing_mm: Option<[f64; 2]>,
    /// On a blade: arc length on the section, from and to, mm.
    pub arc_mm: Option<[f64; 2]>,
    /// On a blade: height above the platform, from and to, mm.
    pub x_mm: Option<[f64; 2]>,
    /// Corner, mm.
    pub corner_mm: Option<[f64; 3]>,
    /// First side from the corner, mm.
    pub u_mm: Option<[f64; 3]>,
    /// Second side from the corner, mm.
    pub v_mm: Option<[f64; 3]>,
}

/// Direction of a profile to the lay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ProfileDirectionFile {
    /// Across the marks.
    Across,
    /// Along the marks.
    Along,
}

/// A profile of its own: `[[surface.profile]]`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceProfileFile {
    /// Name, unique among patches and profiles.
    pub name: String,
    /// Middle, as of a patch, mm.
    pub at_mm: Option<[f64; 3]>,
    /// As of a patch, mm.
    pub arc_mm: Option<f64>,
    /// As of a patch, mm.
    pub x_mm: Option<f64>,
    /// As of a patch.
    pub normal: Option<[f64; 3]>,
    /// Direction to the lay, which is found on the surface round the middle.
    pub direction: Option<ProfileDirectionFile>,
    /// Instead of `direction`: a direction that is laid into the surface.
    pub along: Option<[f64; 3]>,
}

/// Angle of the spindle at a place of the path: `[[surface.phase]]`. Of several for one tool, each
/// holds from the block that passes its place on.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpindlePhaseFile {
    /// The tip passes here in feed, workpiece frame, mm: the first time that it comes nearest with the
    /// spindle turning.
    pub at_mm: [f64; 3],
    /// Azimuth of the first tooth (its lowest point) then, degrees: right-handed about the axis from tip to
    /// holder, from the feed direction as seen along the axis; from X where the tool moves along its axis.
    pub tooth_deg: f64,
    /// Name of the tool; left out, whichever comes nearest.
    pub tool: Option<String>,
}

/// Where a middle is written.
pub(crate) struct Middle<'a> {
    pub(crate) at: &'a Option<[f64; 3]>,
    pub(crate) arc: Option<f64>,
    pub(crate) x: Option<f64>,
    pub(crate) normal: &'a Option<[f64; 3]>,
}

impl SurfacePatchFile {
    pub(crate) fn middle(&self) -> Middle<'_> {
        Middle { at: &self.at_mm, arc: self.arc_mm, x: self.x_mm, normal: &self.normal }
    }
}

impl SurfaceProfileFile {
    pub(crate) fn middle(&self) -> Middle<'_> {
        Middle { at: &self.at_mm, arc: self.arc_mm, x: self.x_mm, normal: &self.normal }
    }
}

impl Middle<'_> {
    fn fault(&self) -> Option<(String, &'static str)> {
        let on_blade = [self.arc, self.x].iter().filter(|v| v.is_some()).count();
        if (self.at.is_some(), on_blade) != (true, 0) && (self.at.is_some(), on_blade) != (false, 2) {
            return Some((
                "its place must be given exactly once".into(),
                "give `at_mm`, or on a blade `arc_mm` and `x_mm`",
            ));
        }
        if self.normal.is_some() && self.at.is_none() {
            return Some(("`normal` makes a plane through `at_mm`, which is missing".into(), "give `at_mm`"));
        }
        let numbers = self.at.iter().flatten().copied().chain(self.arc).chain(self.x);
        numbers
            .into_iter()
            .find(|v| !v.is_finite() || v.abs() > FARTHEST)
            .map(|v| (format!("{v} is not a coordinate"), "write lengths in mm of the workpiece frame"))
    }
}

fn direction_fault(key: &str, v: &Option<[f64; 3]>) -> Option<(String, &'static str)> {
    let v = (*v)?;
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    (!(length > SHORTEST && length < LONGEST))
        .then(|| (format!("{key} = {v:?} is not a direction"), "write for example [1, 0, 0]"))
}

fn size_fault(size: [f64; 2], step_um: f64) -> Option<(String, &'static str)> {
    if !STEP_UM.contains(&step_um) {
        return Some((format!("step_um = {step_um} is out of range"), "write 0.01 to 10000 micrometers"));
    }
    if !size.iter().all(|s| SIDE_MM.contains(s)) {
        return Some((format!("size_mm = {size:?} is out of range"), "write sides of 0.001 to 1000 mm"));
    }
    let nodes: f64 = size.iter().map(|s| (s * UM_PER_MM / step_um).round() + 1.0).product();
    if size.iter().any(|s| s * UM_PER_MM < 2.0 * step_um) {
        return Some((
            format!("sides of {size:?} mm are shorter than two steps of {step_um} um"),
            "give a larger patch or a smaller step_um",
        ));
    }
    (nodes > MOST_NODES).then(|| {
        (
            format!("{nodes:.0} nodes are more than the {MOST_NODES:.0} of a patch"),
            "give a smaller patch or a larger step_um",
        )
    })
}

/// Checks what can be seen without design and motion.
pub(crate) fn check(path: &Path, text: &str, file: &SurfaceFile) -> Result<(), InputError> {
    let of_key = |key: &'static str| offset_of(text, &[Key("surface"), Key(key)]);
    let fault = |offset: usize, what: &str, (message, help): (String, &'static str)| {
        Err(InputError::at(path, text, offset, format!("{what}: {message}"), help))
    };
    if let Some(f) = size_fault(file.size_mm, file.step_um) {
        return fault(of_key("size_mm"), "[surface]", f);
    }
    if !(file.max_height_mm > 0.0 && file.max_height_mm <= 100.0) {
        let m = format!("max_height_mm = {} is out of range", file.max_height_mm);
        return fault(of_key("max_height_mm"), "[surface]", (m, "write a height above 0 and at most 100 mm"));
    }
    if file.random_phases == 0 || file.random_phases > MOST_PHASES {
        let m = format!("random_phases = {} is out of range", file.random_phases);
        return fault(of_key("random_phases"), "[surface]", (m, "write 1 to 100 repetitions"));
    }
    let mut names: Vec<&str> = Vec::new();
    let entries = file.patch.iter().map(|p| (p.span().start, p.get_ref().name.as_str(), "patch"));
    let entries = entries.chain(file.grid.iter().map(|g| (g.span().start, g.get_ref().name.as_str(), "grid")));
    let entries = entries.chain(file.profile.iter().map(|p| (p.span().start, p.get_ref().name.as_str(), "profile")));
    for (offset, name, kind) in entries {
        let what = format!("{kind} {name:?}");
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(plain) {
            return fault(
                offset,
                &what,
                (
                    "this is not a valid name".into(),
                    "use 1 to 40 letters, digits, `-` and `_`: the name becomes part of file names",
                ),
            );
        }
        if names.contains(&name) {
            return fault(
                offset,
                &what,
                ("the name is taken".into(), "give patches, grids and profiles each a name of their own"),
            );
        }
        names.push(name);
    }
    for spanned in &file.patch {
        let (patch, offset) = (spanned.get_ref(), spanned.span().start);
        let what = format!("patch {:?}", patch.name);
        let (size, step) = (patch.size_mm.unwrap_or(file.size_mm), patch.step_um.unwrap_or(file.step_um));
        let found = patch
            .middle()
            .fault()
            .or_else(|| direction_fault("normal", &patch.normal))
            .or_else(|| direction_fault("along", &patch.along))
            .or_else(|| size_fault(size, step));
        if let Some(f) = found {
            return fault(offset, &what, f);
        }
    }
    for spanned in &file.grid {
        let (grid, offset) = (spanned.get_ref(), spanned.span().start);
        if let Some(f) = grid.fault() {
            return fault(offset, &format!("grid {:?}", grid.name), f);
        }
    }
    for spanned in &file.profile {
        let (profile, offset) = (spanned.get_ref(), spanned.span().start);
        let found = profile
            .middle()
            .fault()
            .or_else(|| direction_fault("normal", &profile.normal))
            .or_else(|| direction_fault("along", &profile.along))
            .or_else(|| {
                let one = profile.direction.is_some() != profile.along.is_some();
                (!one).then(|| ("its direction must be given exactly once".into(), "give `direction` or `along`"))
            });
        if let Some(f) = found {
            return fault(offset, &format!("profile {:?}", profile.name), f);
        }
    }
    for spanned in &file.phase {
        let (phase, offset) = (spanned.get_ref(), spanned.span().start);
        if !phase.at_mm.iter().chain([&phase.tooth_deg]).all(|v| v.is_finite() && v.abs() <= FARTHEST) {
            return fault(offset, "[[surface.phase]]", ("a value is not a number".into(), "write mm and degrees"));
        }
    }
    if let Some(spanned) = file.phase.first().filter(|_| file.model == SurfaceModelFile::Envelope) {
        let message = "the envelope of the cutter has no phase".to_owned();
        return fault(spanned.span().start, "[[surface.phase]]", (message, "write model = \"teeth\", or leave it out"));
    }
    Ok(())
}

impl SurfaceGridFile {
    fn fault(&self) -> Option<(String, &'static str)> {
        let of_blade = self.arc_mm.is_some() && self.x_mm.is_some();
        let in_space = self.corner_mm.is_some() && self.u_mm.is_some() && self.v_mm.is_some();
        let given = [
            self.arc_mm.is_some(),
            self.x_mm.is_some(),
            self.corner_mm.is_some(),
            self.u_mm.is_some(),
            self.v_mm.is_some(),
        ];
        let given = given.iter().filter(|g| **g).count();
        if !(of_blade && given == 2 || in_space && given == 3) {
            return Some((
                "its region must be given exactly once".into(),
                "give `corner_mm`, `u_mm` and `v_mm`, or on a blade `arc_mm` and `x_mm`",
            ));
        }
        let sides = [&self.u_mm, &self.v_mm].into_iter().flatten().flatten();
        let numbers =
            self.arc_mm.iter().chain(&self.x_mm).flatten().chain(self.corner_mm.iter().flatten()).chain(sides);
        if let Some(v) = numbers.into_iter().find(|v| !v.is_finite() || v.abs() > FARTHEST) {
            return Some((format!("{v} is not a coordinate"), "write lengths in mm of the workpiece frame"));
        }
        if let Some(f) = direction_fault("u_mm", &self.u_mm).or_else(|| direction_fault("v_mm", &self.v_mm)) {
            return Some(f);
        }
        let [rows, columns] = match (self.count, self.spacing_mm) {
            (Some(count), None) => count.map(f64::from),
            (None, Some(spacing)) if spacing.iter().all(|s| *s > 0.0) => self.counts().map(|n| n as f64),
            (None, Some(s)) => {
                return Some((format!("spacing_mm = {s:?} is not a distance"), "write lengths above 0 mm"));
            }
            _ => return Some(("it needs a number of patches".into(), "give `count` or `spacing_mm`")),
        };
        let patches = rows * columns;
        (!(1.0..=MOST_PATCHES as f64).contains(&patches))
            .then(|| (format!("{patches:.0} patches are out of range: 1 to {MOST_PATCHES}"), "give 1 to 10000 patches"))
    }

    /// Lengths of its sides, mm.
    fn sides(&self) -> [f64; 2] {
        let norm = |v: &Option<[f64; 3]>| v.map_or(0.0, |v| v.iter().map(|c| c * c).sum::<f64>().sqrt());
        let range = |r: &Option<[f64; 2]>| r.map_or(0.0, |[a, b]| (b - a).abs());
        if self.arc_mm.is_some() {
            [range(&self.arc_mm), range(&self.x_mm)]
        } else {
            [norm(&self.u_mm), norm(&self.v_mm)]
        }
    }

    /// Patches along both directions.
    pub(crate) fn counts(&self) -> [usize; 2] {
        let sides = self.sides();
        [0, 1].map(|k| match (self.count, self.spacing_mm) {
            (Some(count), _) => count[k] as usize,
            (None, Some(spacing)) => ((sides[k] / spacing[k] + ROUNDING).floor() as usize).saturating_add(1),
            (None, None) => 0,
        })
    }

    /// Where the middles lie along both directions, as parts of the sides.
    pub(crate) fn middles(&self) -> [Vec<f64>; 2] {
        let (counts, sides) = (self.counts(), self.sides());
        [0, 1].map(|k| {
            let n = counts[k];
            if n == 1 {
                return vec![0.5];
            }
            let step = match self.spacing_mm {
                Some(spacing) => spacing[k] / sides[k],
                None => 1.0 / (n - 1) as f64,
            };
            let first = 0.5 * (1.0 - step * (n - 1) as f64);
            (0..n).map(|i| first + step * i as f64).collect()
        })
    }
}
