//! Questions to the stock that a run left: sections, distances, walls; with the same figures of a
//! design.

use std::{
    io::BufReader,
    path::{Path, PathBuf},
};

use proveout_geom::{Point, Vector, read_mesh};
use proveout_input::{InputError, open_regular_file};
use proveout_step::{DEFAULT_CHORD_UM, StepFiles, is_step};
use proveout_stock::{Outline, Probe, TriDexel};
use serde::Serialize;

use crate::prepare::{error::SimError, memory::MEMORY, part_mesh::solid, raw_stock::STOCK_FILE};

/// Cells of the search grid along the longest edge of a design.
const DESIGN_CELLS: f64 = 100.0;
/// Shorter vectors are no direction.
const SHORTEST: f64 = 1e-9;

/// What is asked; workpiece frame, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Questions {
    /// Run folder, or a stock file.
    pub stock: PathBuf,
    /// Closed mesh or STEP file that is measured too.
    pub design: Option<PathBuf>,
    /// Plane across an axis (0 x, 1 y, 2 z) at a coordinate.
    pub section: Option<(usize, f64)>,
    /// Places whose distance from the surface is asked.
    pub distances: Vec<[f64; 3]>,
    /// Place and direction of lines that go through a wall.
    pub walls: Vec<([f64; 3], [f64; 3])>,
}

/// The answers; what is null was not met or not asked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answers {
    /// The stock file.
    pub stock: String,
    /// Edges of its cells along x, y and z, mm.
    pub cells_mm: [f64; 3],
    /// Largest error of the swept surface on its rays, mm.
    pub sweep_bound_mm: f64,
    /// Of a design from a STEP file: largest distance of its mesh from the surfaces, as measured, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design_chord_error_mm: Option<f64>,
    /// The section.
    pub section: Option<Section>,
    /// In the order of the questions.
    pub distances: Vec<Distance>,
    /// In the order of the questions.
    pub walls: Vec<Wall>,
}

/// A section across an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Section {
    /// `x`, `y` or `z`.
    pub axis: char,
    /// Coordinate along it, mm.
    pub at_mm: f64,
    /// Of the stock.
    pub stock: Outlines,
    /// Of the design.
    pub design: Option<Outlines>,
}

/// Closed outlines in a plane.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Outlines {
    /// Area of material, mm².
    pub area_mm2: f64,
    /// Each outline; the last point joins the first.
    pub outlines: Vec<ClosedLine>,
}

/// One outline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosedLine {
    /// Positive round material, negative round a hole, mm².
    pub area_mm2: f64,
    /// Length, mm.
    pub length_mm: f64,
    /// Points x, y, z in order, mm.
    pub points_mm: Vec<[f64; 3]>,
}

/// Distance of a place from the surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Distance {
    /// The place, mm.
    pub place_mm: [f64; 3],
    /// Distance from the stock, mm; negative in material.
    pub distance_mm: f64,
    /// The point of its surface that is nearest, mm.
    pub nearest_mm: [f64; 3],
    /// Distance of the place from the design, mm.
    pub design_distance_mm: Option<f64>,
    /// Deviation of the nearest point of the stock from the design, mm: positive is material left.
    pub deviation_mm: Option<f64>,
}

/// A wall on a line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wall {
    /// Begin of the line, mm.
    pub from_mm: [f64; 3],
    /// Its direction as asked.
    pub direction: [f64; 3],
    /// Thickness, mm; null where the line meets no material.
    pub thickness_mm: Option<f64>,
    /// Where it enters and leaves material, mm.
    pub faces_mm: Option<[[f64; 3]; 2]>,
    /// Thickness of the design on the same line, mm.
    pub design_thickness_mm: Option<f64>,
}

/// Reads stock and design and answers.
///
/// # Errors
/// Files that cannot be read, a stock with nothing left, a section outside the stock, a direction
/// without a length.
pub fn measure(questions: &Questions) -> Result<Answers, SimError> {
    let path = if questions.stock.is_dir() { questions.stock.join(STOCK_FILE) } else { questions.stock.clone() };
    let refuse = |message: String, help: &str| SimError::from(InputError::file(&path, message, help));
    for (_, direction) in &questions.walls {
        let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        if length <= SHORTEST || !length.is_finite() {
            return Err(refuse(
                format!("the direction {direction:?} of a wall has no length"),
                "give three numbers that are not all 0, such as 0,0,1",
            ));
        }
    }
    let stock = load(&path)?;
    if stock.is_empty() {
        return Err(refuse("no material is left in it".into(), "measure an earlier stock"));
    }
    let probe = Probe::new(&stock);
    let (design, design_chord_error) = questions.design.as_deref().map(design_probe).transpose()?.unzip();
    let section = questions.section.map(|(axis, at)| section(&probe, design.as_ref(), axis, at)).transpose();
    let section = section.map_err(|(message, help)| refuse(message, &help))?;
    let distance = |place: &[f64; 3]| {
        let at = Point::from(*place);
        let near = probe.nearest(&at)?;
        let from_design = |p: &Point| Some(design.as_ref()?.nearest(p)?.distance);
        Some(Distance {
            place_mm: *place,
            distance_mm: near.distance,
            nearest_mm: near.point.coords.into(),
            design_distance_mm: from_design(&at),
            deviation_mm: from_design(&near.point),
        })
    };
    let wall = |(from, direction): &([f64; 3], [f64; 3])| {
        let (at, way) = (Point::from(*from), Vector::from(*direction));
        let wall = probe.wall(&at, &way);
        Wall {
            from_mm: *from,
            direction: *direction,
            thickness_mm: wall.map(|w| w.thickness),
            faces_mm: wall.map(|w| w.faces.map(|f| f.coords.into())),
            design_thickness_mm: design.as_ref().and_then(|d| d.wall(&at, &way)).map(|w| w.thickness),
        }
    };
    Ok(Answers {
        stock: path.display().to_string(),
        cells_mm: stock.cells_mm(),
        sweep_bound_mm: stock.sweep_bound_mm(),
        design_chord_error_mm: design_chord_error.flatten(),
        section,
        distances: questions.distances.iter().filter_map(distance).collect(),
        walls: questions.walls.iter().map(wall).collect(),
    })
}

fn load(path: &Path) -> Result<TriDexel, SimError> {
    let opened = open_regular_file(path).map_err(|e| {
        let help = "name a run folder, or a stock file such as out/part-main/stock.dexel";
        InputError::file(path, format!("cannot be read: {e}"), help)
    })?;
    TriDexel::load(&mut BufReader::new(opened), MEMORY)
        .map_err(|e| InputError::file(path, e.to_string(), "run the scene again").into())
}

/// The design, with the chord error of a STEP file, mm.
fn design_probe(path: &Path) -> Result<(Probe, Option<f64>), SimError> {
    let (mesh, error) = if is_step(path) {
        let step = StepFiles::default().read(path, DEFAULT_CHORD_UM)?;
        (step.mesh.clone(), Some(step.chord_error_mm()))
    } else {
        (read_mesh(path)?, None)
    };
    let mesh = solid(mesh, path.to_owned())?;
    let cell = mesh.aabb().size().max() / DESIGN_CELLS;
    Ok((Probe::of_mesh(mesh, cell), error))
}

fn section(probe: &Probe, design: Option<&Probe>, axis: usize, at: f64) -> Result<Section, (String, String)> {
    let name = ['x', 'y', 'z'][axis.min(2)];
    let bounds = probe.mesh().aabb();
    let (low, high) = (bounds.min[axis], bounds.max[axis]);
    if at <= low || at >= high || at.is_nan() {
        let message =
            format!("the section {name}={at} does not meet the stock, which reaches from {low:.3} to {high:.3} mm");
        return Err((message, format!("choose a {name} between them")));
    }
    let normal = Vector::ith(axis, 1.0);
    let mut on = Point::origin();
    on[axis] = at;
    let of = |probe: &Probe| {
        let lines: Vec<ClosedLine> = probe.section(&on, &normal).iter().map(|o| closed_line(o, &normal)).collect();
        Outlines { area_mm2: lines.iter().map(|l| l.area_mm2).sum(), outlines: lines }
    };
    Ok(Section { axis: name, at_mm: at, stock: of(probe), design: design.map(of) })
}

fn closed_line(outline: &Outline, normal: &Vector) -> ClosedLine {
    let points = &outline.points;
    let length = (0..points.len()).map(|k| (points[(k + 1) % points.len()] - points[k]).norm()).sum();
    ClosedLine {
        area_mm2: outline.area(normal),
        length_mm: length,
        points_mm: points.iter().map(|p| p.coords.into()).collect(),
    }
}
