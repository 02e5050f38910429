//! The stock in its clamping as a picture: stock blue, fixtures vermilion, the tool next to it gray.

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, revolved_mesh};
use proveout_sim::observer::Setup;
use proveout_stock::TriDexel;
use proveout_tool::Tool;

use crate::{
    canvas::Canvas,
    contact::raster::{PictureBody, Raster},
    error::RecordError,
    page_encoding::base64,
    projection::Projection,
};

/// Points of a picture.
const SIZE: [usize; 2] = [480, 360];
/// Half of the height that is shown, as a share of the diagonal of stock and fixtures.
const HALF: f64 = 0.55;
/// Most cells along an edge of the stock's surface.
const COARSE: usize = 120;
/// Distance of the tip of a tool above the stock, as a share of the picture's half height.
const ABOVE: f64 = 0.12;
/// Sine of the angle to Z below which a direction is along it.
const PARALLEL: f64 = 1e-9;

/// The stock in its present state with its fixtures, and a tool over it; as PNG in Base64.
pub(super) fn clamped(setup: &Setup<'_>, stock: &TriDexel, tool: Option<&Tool>) -> Result<String, RecordError> {
    let work_from_table = setup.table_from_work.inverse();
    let step = stock.counts().into_iter().max().unwrap_or(1).div_ceil(COARSE);
    let mut bodies = vec![(PictureBody::Second, stock.surface_with_step(step).mesh)];
    bodies.extend(setup.fixtures.iter().map(|(_, mesh)| (PictureBody::First, mesh.transformed(&work_from_table))));
    let mut bounds = Aabb::empty();
    bodies.iter().flat_map(|b| &b.1.positions).for_each(|p| bounds.grow(p));
    if bounds.is_empty() {
        return Ok(String::new());
    }
    let half = (HALF * bounds.size().norm()).max(1.0);
    let mut focus = bounds.center();
    if let Some(tool) = tool {
        let up = work_from_table.vector(&Vector::z());
        let top = bodies[0].1.positions.iter().map(|p| p.coords.dot(&up)).fold(f64::NEG_INFINITY, f64::max);
        let middle = stock.bounds().center();
        let tip = middle + up * (top - middle.coords.dot(&up) + ABOVE * half);
        bodies.push((PictureBody::Other, assembly(tool, tip, &up)));
        focus += up * (0.35 * half);
    }
    let view = Projection::new(&Vector::new(0.75, -1.4, 0.8), focus, 1.15 * half, SIZE);
    let mut raster = Raster::new(view);
    bodies.iter().for_each(|(part, mesh)| raster.draw(mesh, *part));
    let mut canvas = Canvas::new(SIZE[0], SIZE[1]);
    raster.put(&mut canvas, [0, 0]);
    Ok(base64(&canvas.png()?))
}

/// All parts of a tool, with its tip at a place.
fn assembly(tool: &Tool, tip: Point, up: &Vector) -> TriMesh {
    let mut mesh = TriMesh::default();
    for body in &tool.bodies {
        let chord = (0.01 * body.profile.max_radius()).clamp(0.005, 0.2);
        mesh.append(&revolved_mesh(&body.profile.polyline(chord), 48));
    }
    let across = Vector::z().cross(up);
    let turn = match across.try_normalize(PARALLEL) {
        Some(axis) => Pose::from_axis_angle(&axis, across.norm().atan2(up.z)),
        None => Pose::identity(),
    };
    mesh.transformed(&(Pose::from_translation(tip.coords) * turn))
}
