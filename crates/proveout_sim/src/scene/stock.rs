//! Raw material of a scene: cells, forms (a lying cylinder too), what an earlier run left.

use std::path::{Path, PathBuf};

use proveout_geom::{Aabb, Point, Vector};
use proveout_input::{InputError, check_quantity};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::scene::{
    Mount, SceneFile,
    mesh_unit::MeshUnitFile,
    patch::PatchFile,
    step_file::{self, NamedMesh},
};

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
    /// Watertight mesh file, mm, or a STEP file.
    #[schemars(with = "Option<PathBuf>")]
    pub mesh: Option<Spanned<PathBuf>>,
    /// Unit of the numbers of `mesh`, which is converted to millimeters: `mm`, `cm`, `m` or `inch`.
    /// Millimeters when left out; a mesh far smaller than the cuts is refused then. Say `mm` where the size
    /// is meant.
    pub mesh_unit: Option<MeshUnitFile>,
    /// Of a STEP file: largest distance of its mesh from the exact surfaces that is asked for, micrometers;
    /// 5 when left out, which is reported as assumed. The distance that is measured counts.
    #[schemars(with = "Option<f64>")]
    pub chord_um: Option<Spanned<f64>>,
    /// The blade of `[part.blade]` with so much more material on its sides, mm.
    pub blade_allowance_mm: Option<f64>,
    /// What an earlier run left: its folder, or the `stock.dexel` in it. Taken over exactly where the cells
    /// stay and `place` turns by right angles only; re-gridded otherwise, with `removal.regrid_bound_mm` in
    /// the verdict.
    pub from_run: Option<PathBuf>,
    /// Workpiece frame of the earlier run in that of this scene; the same when left out. Only with
    /// `from_run`.
    pub place: Option<Mount>,
    /// The stock as it stood at this time of the earlier run, s, after the last motion that had ended; at its
    /// end when left out. The earlier run must have kept its `history`.
    pub at_time_s: Option<f64>,
    /// Remembers what every motion has changed, so that the stock at any time can be had from `stock.dexel`.
    /// Takes about 28 bytes for each interval that a motion removes from a ray; given up, with a note, above
    /// 2 GiB.
    #[serde(default)]
    pub history: bool,
    /// Intervals of material that a ray will hold, as a mean over all rays, for the memory that is announced.
    /// Counted on the raw stock and the design when left out; parts with many fins or ribs cut from the full
    /// may need more.
    #[schemars(with = "Option<f64>")]
    pub intervals_per_ray: Option<Spanned<f64>>,
    /// Mends a `mesh` that is inside out or whose shells cross: faces are turned, and the union of the shells
    /// counts. Without it such a mesh is refused. A mesh with holes is refused in any case.
    #[serde(default)]
    pub repair: bool,
    /// Boxes in which the surface is wanted finer. Motions, findings and volumes are judged on the stock
    /// itself.
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
    /// Its mesh, where it has one.
    pub(crate) fn named_mesh(&self) -> Option<NamedMesh<'_>> {
        let (unit, chord_um) = (self.mesh_unit, self.chord_um.as_ref().map(|c| *c.get_ref()));
        self.mesh.as_ref().map(|file| NamedMesh { file, unit, chord_um })
    }

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
    /// Axis of its coordinates that the cylinder lies along: of a bar in a rotary table that turns about x,
    /// `x`.
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

impl BoxFile {
    /// As a box.
    pub fn aabb(&self) -> Aabb {
        Aabb { min: Point::from(self.min_mm), max: Point::from(self.max_mm) }
    }
}

/// One form, with numbers that make sense.
///
/// # Errors
/// The first fault.
pub(crate) fn check(path: &Path, text: &str, file: &SceneFile) -> Result<(), InputError> {
    let fault = |offset: usize, message: String, help: &str| Err(InputError::at(path, text, offset, message, help));
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
    if stock.mesh_unit.is_some() && stock.mesh.is_none() {
        let message = "`mesh_unit` belongs to `mesh`".to_owned();
        return fault(file.stock.span().start, message, "leave it out, or give `mesh`");
    }
    let chord_um = stock.chord_um.as_ref();
    if let Some((_, message, help)) =
        step_file::fault(stock.mesh.as_ref(), stock.mesh_unit, chord_um.map(|c| *c.get_ref()))
    {
        return fault(chord_um.map_or(file.stock.span().start, |c| c.span().start), message, &help);
    }
    if of_a_run && stock.from_run.is_none() || stock.repair && stock.mesh.is_none() {
        let key = if of_a_run { "`place` and `at_time_s` belong to `from_run`" } else { "`repair` belongs to `mesh`" };
        return fault(file.stock.span().start, key.into(), "leave it out, or give the stock in that form");
    }
    if let Some(told) = stock.density_kg_m3.as_ref().filter(|d| !(100.0..=25_000.0).contains(d.get_ref())) {
        let message = format!("density_kg_m3 = {} is not the density of a workpiece material", told.get_ref());
        let help = "write it in kg/m3, 100 to 25000: 7850 for steel, 2700 for aluminum";
        return Err(InputError::at(path, text, told.span().start, message, help));
    }
    if let Some(told) = stock.intervals_per_ray.as_ref().filter(|n| !(1.0..=1000.0).contains(n.get_ref())) {
        let message = format!("intervals_per_ray = {} is not a number of intervals", told.get_ref());
        return fault(told.span().start, message, "write a number from 1 to 1000, or leave it out");
    }
    if let Some(b) = stock.block
        && !(0..3).all(|i| b.min_mm[i] < b.max_mm[i])
    {
        let at = file.stock.span().start;
        return fault(at, format!("box {:?} to {:?} is empty", b.min_mm, b.max_mm), "min_mm must be below max_mm");
    }
    if let Some(c) = stock.cylinder
        && !(c.radius_mm > 0.0 && c.height_mm > 0.0)
    {
        let at = file.stock.span().start;
        return fault(at, "the cylinder is empty".into(), "radius_mm and height_mm must be above 0");
    }
    Ok(())
}

/// Checks that an allowance has a blade to lie on.
///
/// # Errors
/// There is none.
pub(crate) fn check_blade(path: &Path, text: &str, file: &SceneFile) -> Result<(), InputError> {
    let stock = file.stock.get_ref();
    let stock_blade = stock.blade_allowance_mm.is_some_and(|a| !(0.0..1e3).contains(&a));
    if stock_blade || stock.blade_allowance_mm.is_some() && file.part.as_ref().is_none_or(|p| p.blade.is_none()) {
        let at = file.stock.span().start;
        let help = "give an allowance from 0 mm, and the blade as [part.blade]";
        return Err(InputError::at(path, text, at, "blade_allowance_mm has no blade, or is negative", help));
    }
    Ok(())
}

/// What is wrong with a cell size that a call gives, by the range that `resolution_mm` has in a scene.
pub fn resolution_fault(cell_mm: f64) -> Option<String> {
    check_quantity("resolution_mm", cell_mm).err().map(|e| e.to_string())
}
