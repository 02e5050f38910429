//! A loose part and all that it may meet, as bodies in the table frame.

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, revolved_mesh};
use proveout_stock::{SurfaceMesh, TakenPart, TileId, TriDexel};
use proveout_tool::{Role, Tool};

use super::{
    Moment, Shop,
    course::{Course, felt},
    fall::{Decision, End, Fall},
    pieces::pieces,
    rapier_world::{IS_BUILT, hull},
    world::{Body, Standing},
};
use crate::{prepare::prepared::Prepared, units::KG_MM3_PER_KG_M3};

/// Sides of the polygon that approximates a circle of the tool.
const SECTORS: usize = 48;
/// Chord error of the tool's profile, mm.
const CHORD_MM: f64 = 0.005;
/// Weaker gravity has no direction, mm/s2.
const NO_GRAVITY: f64 = 1e-9;

/// Follows a part that was taken out of the stock; gives its mesh in K, too.
pub(super) fn follow(
    shop: &Shop<'_>,
    taken: &TakenPart,
    at: &Moment,
    course: &Course,
    last: bool,
) -> (Decision, Option<TriMesh>) {
    let unknown = |why: &str| Decision { end: End::Unknown(why.into()), struck: Vec::new(), track: Vec::new() };
    let prepared = shop.prepared;
    let machine = &prepared.machine;
    let part = taken.stock();
    let surface = part.surface();
    let mesh = surface.mesh.transformed(&prepared.table_from_work);
    if !IS_BUILT {
        return (unknown("this program was built without Rapier (feature `rapier`)"), Some(mesh));
    }
    let cell = part.cell_mm();
    let (Some(pieces), Some(moments)) = (pieces(part, &surface, 0.5 * cell), part.moments()) else {
        return (unknown("it is too thin for a shape"), None);
    };
    let table_from_work = &prepared.table_from_work;
    let center = table_from_work.point(&moments.center);
    let still = proveout_machine::JointValues::ZERO;
    let Some(gravity) = felt(machine, &center, [&at.joints, &still, &still]) else {
        return (unknown("the machine does not state `up`"), Some(mesh));
    };
    let density = prepared.scene.file.stock.get_ref().density() * KG_MM3_PER_KG_M3;
    let turn = table_from_work.rotation;
    let in_table = |piece: Vec<Point>| piece.iter().map(|p| table_from_work.point(p)).collect();
    let error = pieces.error + 0.5 * cell;
    let fall = Fall {
        body: Body {
            pieces: pieces.pieces.into_iter().map(in_table).collect(),
            mass: moments.volume * density,
            center,
            inertia: turn * moments.inertia * turn.transpose() * density,
        },
        error,
        standing: standing(shop.stock, prepared, at, &part_box(part, &surface), &gravity),
        tool: at.tool.and_then(|t| prepared.tools.tools.get(t)).map_or_else(Vec::new, |t| tool_bodies(t, error)),
        table: (machine.table.point, machine.table.normal),
        start: at.time,
        gravity,
    };
    (fall.decide(course, last), Some(mesh))
}

fn part_box(part: &TriDexel, surface: &SurfaceMesh) -> Aabb {
    if surface.mesh.positions.is_empty() { part.bounds() } else { surface.mesh.aabb() }
}

/// Fixtures, machine bodies and the rest of the stock near the way of the part, in K.
fn standing(stock: &TriDexel, prepared: &Prepared, at: &Moment, part: &Aabb, gravity: &Vector) -> Vec<Standing> {
    let machine = &prepared.machine;
    let mut out: Vec<Standing> = Vec::new();
    let rest = rest_of_stock(stock, part, &prepared.table_from_work.inverse().vector(gravity));
    if !rest.triangles.is_empty() {
        let mesh = rest.transformed(&prepared.table_from_work);
        out.push(Standing { name: "stock".into(), mesh, on_table: true });
    }
    for (name, mesh) in &prepared.fixtures {
        out.push(Standing { name: name.clone(), mesh: mesh.clone(), on_table: true });
    }
    let table_from_machine = machine.machine_from_table(&at.joints).inverse();
    for (k, body) in machine.bodies.iter().enumerate().filter(|(_, b)| !b.mesh.triangles.is_empty()) {
        let on_table = body.attached_to == machine.table.attached_to;
        // What moves with the table is at rest in K, to the last bit.
        let pose = if on_table { Pose::identity() } else { table_from_machine * machine.body_pose(k, &at.joints) };
        out.push(Standing { name: body.name.clone(), mesh: body.mesh.transformed(&pose), on_table });
    }
    out
}

/// The surface of the stock in the blocks that the part may come to: round it by its own size, and all that
/// lies below.
fn rest_of_stock(stock: &TriDexel, part: &Aabb, gravity_in_work: &Vector) -> TriMesh {
    let size = part.size().norm();
    let way = gravity_in_work.try_normalize(NO_GRAVITY).unwrap_or_else(Vector::zeros) * stock.bounds().size().norm();
    let moved = Aabb { min: part.min + way, max: part.max + way };
    let reach = part.union(&moved).expanded(size);
    let mut mesh = TriMesh::default();
    for tile in (0..stock.tile_count()).map(|k| TileId(k as u32)) {
        if stock.tile_bounds(tile).intersects(&reach) {
            mesh.append(&stock.tile_surface(tile, 1).mesh);
        }
    }
    mesh.merge_equal_vertices()
}

/// Convex bodies of a tool in T. What has just cut touches the part: the tool is smaller by `error`, so that
/// a touch that only comes from it is none.
fn tool_bodies(tool: &Tool, error: f64) -> Vec<Vec<Point>> {
    let body = |b: &proveout_tool::Body| {
        let lift = if b.role == Role::Cutting { error } else { 0.0 };
        let profile: Vec<[f64; 2]> =
            b.profile.polyline(CHORD_MM).iter().map(|[r, z]| [(r - error).max(0.0), z + lift]).collect();
        hull(&revolved_mesh(&profile, SECTORS).positions).map(|h| h.points)
    };
    tool.bodies.iter().filter_map(body).collect()
}
