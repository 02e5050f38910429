//! Pictures of first contacts: both bodies in color, at their positions when the finding begins.
//!
//! ```text
//!   +----------------+ +----------------+
//!   |  the setup     | |  near the      |   vermilion: the first body named by the finding, blue: the second
//!   |       + 50 mm  | |  place + 2 mm  |   gray: everything else, as glass where it stands in front
//!   +----------------+ +----------------+   a cross marks the place of the finding
//! ```
//!
//! One picture for each pair of bodies and code, of the first finding in time. Joints are those of the
//! finding; where a part of a tool is swept through the stock, they are those within its piece of motion at
//! which that part is nearest to the place. The stock is shown as it was at the end of the stretch of motion
//! in which the finding was raised.

pub(crate) mod raster;

use proveout_controller::Piece;
use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, revolved_mesh};
use proveout_machine::JointValues;
use proveout_sim::{
    finding::{Family, Finding},
    observer::{Batch, Setup},
};
use proveout_stock::{TileId, TriDexel};
use proveout_tool::{Role, Tool};

use self::raster::{PictureBody, Raster};
use crate::{
    canvas::{Canvas, width_of},
    color::NEUTRAL_INK,
    error::RecordError,
    projection::Projection,
    units::JointUnit,
};

/// Color of the first and of the second body.
pub(crate) const FIRST: [u8; 3] = raster::COLORS[0];
pub(crate) const SECOND: [u8; 3] = raster::COLORS[1];
/// Most pictures of a run: a report of many crashes is read from its first ones.
const MOST: usize = 12;
/// Points of one of the two panels.
const PANEL: [usize; 2] = [440, 340];
/// Points between the panels.
const GAP: usize = 12;
/// Half of the height of the setup that is shown, as a share of the smaller body's diagonal, and its range,
/// mm.
const SETUP: (f64, [f64; 2]) = (0.7, [30.0, 400.0]);
/// Half of the height near the place, mm.
const CLOSE: f64 = 8.0;
/// Points of the sketch that a direction of view is chosen by.
const SKETCH: [usize; 2] = [66, 51];
/// Cells of a block of the stock's surface along an edge.
const BLOCK: usize = 32;
/// Most cells along an edge of the stock's surface in the picture of the setup.
const COARSE: usize = 160;

/// One picture.
#[derive(Clone, Debug)]
pub(crate) struct ContactPicture {
    /// The finding that it shows.
    pub(crate) code: String,
    pub(crate) bodies: [String; 2],
    pub(crate) time_s: Option<f64>,
    /// PNG file.
    pub(crate) png: Vec<u8>,
}

/// Takes pictures while the run goes on.
#[derive(Default)]
pub(crate) struct ContactPictures {
    taken: Vec<ContactPicture>,
}

/// A mesh in the workpiece frame.
struct ContactMesh {
    part: PictureBody,
    mesh: TriMesh,
}

impl ContactPictures {
    /// Looks at the findings of a stretch.
    ///
    /// # Errors
    /// [`RecordError::Picture`] where the encoder refuses.
    pub(crate) fn take(&mut self, setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), RecordError> {
        for f in batch.findings {
            let [a, b] = f.bodies.as_slice() else { continue };
            let known = |p: &ContactPicture| p.code == f.code && p.bodies[0] == *a && p.bodies[1] == *b;
            let shown = matches!(f.family, Family::Collision | Family::Process);
            if !shown || self.taken.len() >= MOST || self.taken.iter().any(known) {
                continue;
            }
            if let Some(canvas) = picture(setup, batch, f) {
                let bodies = [a.clone(), b.clone()];
                self.taken.push(ContactPicture { code: f.code.clone(), bodies, time_s: f.time_s, png: canvas.png()? });
            }
        }
        Ok(())
    }

    pub(crate) fn all(&self) -> &[ContactPicture] {
        &self.taken
    }
}

/// The picture of a finding; none where it has no place, or names nothing that can be drawn.
fn picture(setup: &Setup<'_>, batch: &Batch<'_>, f: &Finding) -> Option<Canvas> {
    let stock = batch.stock;
    let focus = Point::from(f.point_mm.filter(|p| p.iter().all(|v| v.is_finite()))?);
    let mut q = JointValues::ZERO;
    for (i, unit) in JointUnit::all(setup.machine).iter().enumerate() {
        q[i] = f.axes.get(&unit.name).filter(|v| v.is_finite())? / unit.factor;
    }
    if let Some(nearest) = at_place(setup, batch.pieces, f, focus) {
        q = nearest;
    }
    let mut bodies = solids(setup, f, &q);
    let part = of_name("stock", f);
    let whole = stock.counts().into_iter().max().unwrap_or(1).div_ceil(COARSE);
    bodies.push(ContactMesh { part, mesh: stock.surface_with_step(whole).mesh });
    let sizes = [PictureBody::First, PictureBody::Second].map(|p| diagonal(&bodies, p));
    let least = sizes.into_iter().flatten().fold(f64::INFINITY, f64::min);
    if !least.is_finite() {
        return None;
    }
    let half = (SETUP.0 * least).clamp(SETUP.1[0], SETUP.1[1]);
    let back = best_view(&bodies, focus);
    let mut canvas = Canvas::new(2 * PANEL[0] + GAP, PANEL[1]);
    panel(&mut canvas, 0, &Projection::new(&back, focus, half, PANEL), &bodies);
    bodies.pop();
    bodies.push(ContactMesh { part, mesh: near(stock, focus, CLOSE * PANEL[0] as f64 / PANEL[1] as f64 * 1.5) });
    panel(&mut canvas, PANEL[0] + GAP, &Projection::new(&back, focus, CLOSE, PANEL), &bodies);
    Some(canvas)
}

/// Parts of a tool in the order in which they are drawn.
const ROLES: [Role; 4] = [Role::Cutting, Role::Neck, Role::Shank, Role::Holder];
/// Moments of a piece that are tried for the one at which a part of a tool is at the place.
const MOMENTS: u32 = 64;

/// Joints at which the part of a tool named in a finding is nearest to the place, within the piece that
/// begins with the finding; `None` for other findings.
fn at_place(setup: &Setup<'_>, pieces: &[Piece], f: &Finding, focus: Point) -> Option<JointValues> {
    let part = f.tool.filter(|part| part.swept)?;
    let (tool, role) = (setup.tools.tools.get(part.tool)?, part.role?);
    let piece = pieces.iter().find(|p| Some(p.time[0]) == f.time_s)?;
    let distance = |q: &JointValues| {
        let p = work_from_tip(setup, tool, q).inverse().point(&focus);
        let bodies = tool.bodies.iter().filter(|b| b.role == role);
        bodies.map(|b| b.profile.signed_distance([p.x.hypot(p.y), p.z])).fold(f64::INFINITY, f64::min)
    };
    let [from, to] = piece.joints;
    let moments = (0..=MOMENTS).map(|k| from.interpolated(to, f64::from(k) / f64::from(MOMENTS)));
    moments.map(|q| (distance(&q), q)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, q)| q)
}

fn work_from_machine(setup: &Setup<'_>, q: &JointValues) -> Pose {
    setup.table_from_work.inverse() * setup.machine.machine_from_table(q).inverse()
}

fn work_from_tip(setup: &Setup<'_>, tool: &Tool, q: &JointValues) -> Pose {
    let work_from_spindle = work_from_machine(setup, q) * setup.machine.machine_from_spindle(q);
    work_from_spindle * Pose::from_translation(Vector::new(0.0, 0.0, -tool.gauge_length))
}

fn of_name(name: &str, f: &Finding) -> PictureBody {
    of_place(f.bodies.iter().position(|b| b == name))
}

/// Which body of the finding it is, by its place among them.
fn of_place(place: Option<usize>) -> PictureBody {
    match place {
        Some(0) => PictureBody::First,
        Some(_) => PictureBody::Second,
        None => PictureBody::Other,
    }
}

/// Machine, fixtures and tool with the joints at `q`, in the workpiece frame.
fn solids(setup: &Setup<'_>, f: &Finding, q: &JointValues) -> Vec<ContactMesh> {
    let work_from_table = setup.table_from_work.inverse();
    let work_from_machine = work_from_machine(setup, q);
    let machine = setup.machine.bodies.iter().enumerate().map(|(i, b)| ContactMesh {
        part: of_name(&b.name, f),
        mesh: b.mesh.transformed(&(work_from_machine * setup.machine.body_pose(i, q))),
    });
    let fixtures = setup.fixtures.iter();
    let fixtures =
        fixtures.map(|(name, mesh)| ContactMesh { part: of_name(name, f), mesh: mesh.transformed(&work_from_table) });
    let mut all: Vec<ContactMesh> = machine.chain(fixtures).collect();
    let named = f.tool.filter(|part| part.role.is_some());
    if let Some((part, tool)) = named.and_then(|part| Some((part, setup.tools.tools.get(part.tool)?))) {
        let work_from_tip = work_from_tip(setup, tool, q);
        for role in ROLES {
            let drawn_as = of_place((part.role == Some(role)).then_some(part.body));
            let mut mesh = TriMesh::default();
            for body in tool.bodies.iter().filter(|b| b.role == role) {
                let chord = (0.01 * body.profile.max_radius()).clamp(0.005, 0.2);
                mesh.append(&revolved_mesh(&body.profile.polyline(chord), 64));
            }
            all.push(ContactMesh { part: drawn_as, mesh: mesh.transformed(&work_from_tip) });
        }
    }
    all
}

fn diagonal(bodies: &[ContactMesh], part: PictureBody) -> Option<f64> {
    let mut all = Aabb::empty();
    let points = bodies.iter().filter(|b| b.part == part).flat_map(|b| &b.mesh.positions);
    points.for_each(|p| all.grow(p));
    (!all.is_empty()).then(|| all.size().norm())
}

/// The surface of the stock in the blocks round a place.
fn near(stock: &TriDexel, focus: Point, half: f64) -> TriMesh {
    let (bounds, cells, counts) = (stock.bounds(), stock.cells_mm(), stock.counts());
    let blocks = counts.map(|n| n.div_ceil(BLOCK));
    let range = |k: usize| {
        let at = |x: f64| ((x - bounds.min[k]) / (cells[k] * BLOCK as f64)).floor().clamp(0.0, blocks[k] as f64 - 1.0);
        at(focus[k] - half) as usize..at(focus[k] + half) as usize + 1
    };
    let mut mesh = TriMesh::default();
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let tile = TileId(((z * blocks[1] + y) * blocks[0] + x) as u32);
                mesh.append(&stock.tile_surface(tile, 1).mesh);
            }
        }
    }
    mesh
}

/// The direction from which both bodies are seen best near the place, and the place itself.
fn best_view(bodies: &[ContactMesh], focus: Point) -> Vector {
    let signs = [1.0, -1.0];
    let oblique = signs.into_iter().flat_map(|z| {
        signs.into_iter().flat_map(move |x| signs.into_iter().map(move |y| Vector::new(x, -1.4 * y, 0.8 * z)))
    });
    let level = [(1.0, 0.2), (-1.0, 0.2), (0.2, -1.0), (0.2, 1.0)].map(|(x, y)| Vector::new(x, y, 0.25));
    let score = |back: &Vector| {
        let mut raster = Raster::new(Projection::new(back, focus, CLOSE, SKETCH));
        bodies.iter().filter(|b| b.part != PictureBody::Other).for_each(|b| raster.draw(&b.mesh, b.part));
        let ([a, b], depth) = raster.seen();
        let hidden = depth > 0.5 * CLOSE;
        // Both large, the place itself not hidden, from above rather than from below.
        a.min(b) as f64 * if hidden { 0.3 } else { 1.0 } * if back.z < 0.0 { 0.7 } else { 1.0 }
    };
    let mut best = (f64::NEG_INFINITY, Vector::new(1.0, -1.4, 0.8));
    for back in oblique.chain(level) {
        let s = score(&back);
        if s > best.0 {
            best = (s, back);
        }
    }
    best.1
}

fn panel(canvas: &mut Canvas, left: usize, view: &Projection, bodies: &[ContactMesh]) {
    let mut raster = Raster::new(*view);
    bodies.iter().for_each(|b| raster.draw(&b.mesh, b.part));
    raster.put(canvas, [left, 0]);
    let [x, y] = [left + PANEL[0] / 2, PANEL[1] / 2];
    for (w, h) in [(9, 1), (1, 9)] {
        canvas.fill([x - w, y - h], [2 * w + 1, 2 * h + 1], [255, 255, 255]);
    }
    for (w, h) in [(8, 0), (0, 8)] {
        canvas.fill([x - w, y - h], [2 * w + 1, 2 * h + 1], NEUTRAL_INK);
    }
    // A bar of a round length, about a fifth of the width.
    let wanted = 0.2 * PANEL[0] as f64 / view.scale();
    let power = 10_f64.powf(wanted.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|l| *l <= wanted).unwrap_or(power);
    let points = (length * view.scale()).round() as usize;
    let text = format!("{length} mm");
    let (right, bottom) = (left + PANEL[0] - 12, PANEL[1] - 12);
    // On white, so that it is read in front of any body.
    let wide = points.max(width_of(&text));
    canvas.fill([right - wide - 4, bottom - 28], [wide + 8, 32], [255, 255, 255]);
    canvas.fill([right - points, bottom - 4], [points, 4], NEUTRAL_INK);
    canvas.text([right - width_of(&text), bottom - 24], &text);
}
