//! Finer patches against whole stocks of their cells, and against closed forms.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use std::collections::BTreeMap;

use crate::common::{GIB, Random, ball, cuboid, flat, line, pose, probe, random_cutter, remove};
use proveout_geom::{Aabb, Point, Pose, Vector, box_mesh};
use proveout_stock::{
    Action, Interval, Patch, PatchError, PatchPlan, RawBody, StockError, SurfaceMesh, SurfacePoint, SweepItem,
    SweepMotion, TriDexel, patched_intervals,
};
use proveout_tool::Profile;

const UP: [f64; 3] = [0.0, 0.0, 1.0];
/// Cells that are sums of powers of two: places of rays are then exact, and those of patch and whole stock
/// the same bits.
const COARSE: f64 = 1.0;
const FINE: f64 = 0.125;

fn plan(stock: &TriDexel, window: &Aabb, cells: f64) -> PatchPlan {
    PatchPlan::new(&stock.bounds(), stock.cells_mm(), window, cells).unwrap()
}

/// A block with one patch, and the same block with the cells of the patch all over.
fn block(window: &Aabb) -> (TriDexel, Patch, TriDexel) {
    let bounds = cuboid([-3.0, 1.0, 0.0], [37.0, 31.0, 12.0]);
    let body = RawBody::block(&bounds);
    let stock = body.stock(COARSE, GIB).unwrap();
    let patch = Patch::new("edge", plan(&stock, window, FINE), &body, GIB).unwrap();
    (stock, patch, body.stock(FINE, GIB).unwrap())
}

fn random_motions(random: &mut Random, bodies: &[Profile]) -> Vec<([Vector; 2], [Vector; 2], usize)> {
    (0..120)
        .map(|_| {
            let tip = Vector::new(random.range(-10.0, 44.0), random.range(-6.0, 38.0), random.range(8.0, 20.0));
            let way = random.direction() * random.range(0.0, 6.0);
            let axis = (Vector::z() * 1.5 + random.direction()).normalize();
            let turn = (axis + random.direction() * 0.2).normalize();
            ([tip, tip + way], [axis, turn], random.pick(bodies.len()))
        })
        .collect()
}

fn items<'a>(bodies: &'a [Profile], motions: &[([Vector; 2], [Vector; 2], usize)]) -> Vec<SweepItem<'a>> {
    motions
        .iter()
        .enumerate()
        .map(|(k, (tip, axis, body))| SweepItem {
            id: k as u32,
            body: &bodies[*body],
            action: if k % 7 == 3 { Action::Probe } else { Action::Remove },
            motion: SweepMotion { from: pose(tip[0].into(), axis[0].into()), to: pose(tip[1].into(), axis[1].into()) },
        })
        .collect()
}

/// Volume by the divergence theorem about the origin: that of parts of a closed mesh add up.
fn volume(s: &SurfaceMesh) -> f64 {
    let of = |t: usize| {
        let [a, b, c] = s.mesh.corners(t).map(|p| p.coords);
        a.dot(&b.cross(&c)) / 6.0
    };
    (0..s.mesh.triangles.len()).map(of).sum()
}

fn area(s: &SurfaceMesh) -> f64 {
    (0..s.mesh.triangles.len()).map(|t| 0.5 * s.mesh.area_normal(t).norm()).sum()
}

/// Points that have no partner on the same ray within `bound` along the normal (in either direction), and
/// those that are equal.
fn unmatched(a: &[SurfacePoint], b: &[SurfacePoint], bound: f64) -> (usize, usize) {
    let key = |p: &SurfacePoint| {
        let k = usize::from(p.axis);
        (p.axis, p.point[(k + 1) % 3].to_bits(), p.point[(k + 2) % 3].to_bits())
    };
    let rays = |list: &[SurfacePoint]| {
        let mut rays: BTreeMap<_, Vec<SurfacePoint>> = BTreeMap::new();
        list.iter().for_each(|p| rays.entry(key(p)).or_default().push(*p));
        rays
    };
    let (on_a, on_b) = (rays(a), rays(b));
    let near = |p: &SurfacePoint, q: &SurfacePoint| {
        let slope = p.normal.unwrap()[usize::from(p.axis)].abs().max(1e-3);
        (p.point - q.point).norm() * slope <= bound
    };
    let met = |p: &SurfacePoint, on: &BTreeMap<_, Vec<SurfacePoint>>| {
        on.get(&key(p)).is_some_and(|list| list.iter().any(|q| near(p, q)))
    };
    let unmet = a.iter().filter(|p| !met(p, &on_b)).count() + b.iter().filter(|p| !met(p, &on_a)).count();
    let same = a.iter().filter(|p| on_b.get(&key(p)).is_some_and(|list| list.contains(p))).count();
    (unmet, same)
}

fn in_window(stock: &TriDexel, window: &Aabb) -> Vec<SurfacePoint> {
    stock.surface_points().filter(|p| window.contains(&p.point)).collect()
}

/// Positions of the vertices as bits, with the triangles at each counted: two meshes of the same shape are
/// equal, whatever the order of their vertices.
fn shape(surface: &SurfaceMesh) -> BTreeMap<[u64; 3], usize> {
    let mut out = BTreeMap::new();
    for v in surface.mesh.triangles.iter().flatten() {
        // Plus zero: -0.0 is 0.0.
        let key = surface.mesh.positions[*v as usize].coords.map(|x| (x + 0.0).to_bits()).into();
        *out.entry(key).or_default() += 1;
    }
    out
}

#[test]
fn a_patch_has_the_rays_of_a_whole_stock_of_its_cells() {
    let mut random = Random(20_260_101);
    let bodies: Vec<Profile> = (0..6).map(|_| random_cutter(&mut random).1).chain([ball(2.0, 20.0)]).collect();
    // In the middle, over an edge, and over a corner of the stock.
    let windows = [
        cuboid([10.3, 12.1, 4.0], [19.7, 18.9, 9.6]),
        cuboid([30.0, 11.0, 5.0], [41.0, 17.5, 20.0]),
        cuboid([-9.0, -9.0, 3.0], [7.3, 9.1, 12.0]),
    ];
    for window in windows {
        let (_, mut patch, mut whole) = block(&window);
        let motions = random_motions(&mut random, &bodies);
        let items = items(&bodies, &motions);
        // Batches of different length change nothing.
        items.chunks(37).for_each(|part| patch.sweep(part));
        whole.sweep(&items);
        let (mine, other) = (patch.surface_points().collect::<Vec<_>>(), in_window(&whole, patch.window()));
        let cut = mine.iter().filter(|p| p.made_by.is_some()).count();
        assert!(cut > 200, "only {cut} points were cut");
        // Where a ray leaves the box of the patch the searches begin elsewhere and end within their bound;
        // the rays are the same, and with them, to the bit, the ends that a closed form or the raw stock
        // gives: a quarter and more of these random cuts.
        let (unmet, same) = unmatched(&mine, &other, 2.0 * whole.sweep_bound_mm());
        assert!(unmet * 1000 <= mine.len() && same * 4 > mine.len(), "{unmet} missing, {same} equal of {}", mine.len());
        let (have, want) = (patch.surface(), whole.surface().inside(patch.window()));
        let off = (volume(&have) - volume(&want)).abs();
        // A node within the bound of a face may count to either side, so that cells at sharp edges come out
        // otherwise.
        let cells = 10.0 * FINE.powi(3);
        assert!(off <= whole.sweep_bound_mm() * area(&want) + cells, "{off} mm³");
        assert!(patch.stock().sweep_bound_mm() <= whole.sweep_bound_mm());
        // What the patch costs is its box, not that of the stock.
        assert!(patch.stock().rays() * 4 < whole.rays());
    }
}

#[test]
fn blocks_of_the_surface_of_a_patch_are_its_surface() {
    let (_, mut patch, _) = block(&cuboid([10.3, 2.0, 4.0], [26.0, 29.0, 13.0]));
    let tool = ball(3.0, 20.0);
    patch.sweep(&[remove(1, &tool, pose([8.0, 4.0, 9.0], UP), pose([30.0, 27.0, 7.0], [0.2, 0.1, 1.0]))]);
    let mut parts = BTreeMap::new();
    let tiles = patch.stock_mut().take_changed_tiles();
    assert_eq!(tiles.len(), patch.stock().tile_count());
    for tile in tiles {
        for (key, count) in shape(&patch.tile_surface(tile, 1)) {
            *parts.entry(key).or_insert(0) += count;
        }
    }
    // Corners of triangles agree; on the faces of the window a quadrilateral on a seam may be cut in another
    // order.
    let whole = shape(&patch.surface());
    assert_eq!(parts.keys().collect::<Vec<_>>(), whole.keys().collect::<Vec<_>>());
}

#[test]
fn the_slot_of_a_ball_in_a_patch_is_its_closed_form() {
    let (_, mut patch, _) = block(&cuboid([10.0, 5.0, 3.0], [20.0, 25.0, 15.0]));
    let tool = ball(4.0, 20.0);
    patch.sweep(&[remove(7, &tool, pose([14.3, -20.0, 6.1], UP), pose([14.3, 50.0, 6.1], UP))]);
    let bound = patch.stock().sweep_bound_mm();
    assert!(bound > 0.0 && bound < 1e-3);
    let mut cut = 0;
    for p in patch.surface_points().filter(|p| p.made_by == Some(7)) {
        let (dx, dz) = (p.point.x - 14.3, p.point.z - 10.1);
        // Round below the center of the ball, plane walls above it.
        let off = if dz < 0.0 { dx.hypot(dz) - 4.0 } else { dx.abs() - 4.0 };
        // Along the ray the bound is longer by one over the cosine to the normal; grazing rays only count
        // from 6 degrees.
        let n = p.normal.unwrap();
        let slope = n[usize::from(p.axis)].abs();
        if slope > 0.1 {
            assert!(off.abs() <= bound, "{off} at {}", p.point);
            cut += 1;
        }
    }
    // Two sets of rays see the slot: 8 mm wide, 20 mm long, cells of 1/8 mm.
    assert!(cut > 2 * 60 * 150, "{cut}");
    // The mesh too: a chord across a cell is off by cell² / 8 r.
    let sag = 2.0 * FINE * FINE / 8.0 / 4.0;
    let surface = patch.surface();
    let cut_vertices = surface.mesh.positions.iter().zip(&surface.made_by).filter(|(_, by)| by.is_some());
    for (p, _) in cut_vertices.filter(|(p, _)| p.z < 9.5) {
        let off = (p.x - 14.3).hypot(p.z - 10.1) - 4.0;
        assert!(off.abs() <= bound + sag, "{off} at {p}");
    }
}

/// A saw of 0.3 mm leaves a groove that no coarse ray across meets: only the patch shows it.
#[test]
fn a_groove_narrower_than_the_cells_shows_in_the_patch_alone() {
    let window = cuboid([5.0, 5.0, 8.0], [15.0, 25.0, 13.0]);
    let (mut stock, mut patch, _) = block(&window);
    let saw = Profile::new(vec![
        line([0.0, 0.0], [0.15, 0.0]),
        line([0.15, 0.0], [0.15, 9.0]),
        line([0.15, 9.0], [0.0, 9.0]),
    ])
    .unwrap();
    // Coarse rays of the block run at whole numbers and a half; the groove lies at x = 10.0, 2 mm deep.
    let cut = [remove(1, &saw, pose([10.0, -5.0, 10.0], UP), pose([10.0, 40.0, 10.0], UP))];
    stock.sweep(&cut);
    patch.sweep(&cut);
    let in_groove = |s: &SurfaceMesh| {
        let inside = |p: &&Point| (p.x - 10.0).abs() < 0.2 && (9.0..11.0).contains(&p.z) && p.y > 6.0 && p.y < 24.0;
        s.mesh.positions.iter().filter(inside).count()
    };
    assert_eq!(in_groove(&stock.surface()), 0);
    assert!(in_groove(&patch.surface()) > 500);
    // A probe that falls into the groove, read on rays through both.
    let down = |y: f64| {
        let material = patched_intervals(&stock, std::slice::from_ref(&patch), 2, 10.0, y);
        material.last().map(|m: &Interval| m.hi).unwrap()
    };
    assert!((down(10.0) - 10.0).abs() < 1e-6, "in the window the floor of the groove: {}", down(10.0));
    assert!((down(2.0) - 12.0).abs() < 1e-9, "outside of it the face: {}", down(2.0));
}

#[test]
fn rays_through_stock_and_patch_are_joined_at_the_faces_of_the_window() {
    let window = cuboid([5.0, 5.0, 3.0], [15.0, 25.0, 8.0]);
    let (stock, mut patch, _) = block(&window);
    let on = |patch: &Patch, y: f64| patched_intervals(&stock, std::slice::from_ref(patch), 2, 10.0, y);
    let lengths = |list: &[Interval]| list.iter().map(|m| [m.lo, m.hi]).collect::<Vec<_>>();
    assert_eq!(lengths(&on(&patch, 10.0)), [[0.0, 12.0]], "whole material has no seam");
    // Cut in the patch alone, so that it can be recognized: a cavity from 4 to 7.
    let tool = flat(2.0, 3.0);
    patch.sweep(&[remove(1, &tool, pose([10.0, 10.0, 4.0], UP), pose([10.0, 10.5, 4.0], UP))]);
    let material = lengths(&on(&patch, 10.0));
    assert_eq!(material.len(), 2, "{material:?}");
    assert!((material[0][1] - 4.0).abs() < 1e-6 && (material[1][0] - 7.0).abs() < 1e-6, "{material:?}");
    assert_eq!((material[0][0], material[1][1]), (0.0, 12.0));
    assert_eq!(lengths(&on(&patch, 3.0)), [[0.0, 12.0]], "beside the window the patch does not count");
}

#[test]
fn what_is_inside_and_what_is_outside_of_a_box_is_the_whole_mesh() {
    let mut random = Random(77);
    let (mut stock, _, _) = block(&cuboid([5.0, 5.0, 3.0], [15.0, 25.0, 8.0]));
    let bodies = [ball(4.0, 20.0), flat(3.0, 20.0)];
    let motions = random_motions(&mut random, &bodies);
    stock.sweep(&items(&bodies, &motions));
    let whole = stock.surface();
    for _ in 0..20 {
        let low = Point::new(random.range(-5.0, 30.0), random.range(-5.0, 25.0), random.range(-2.0, 9.0));
        let size = Vector::new(random.range(0.5, 20.0), random.range(0.5, 20.0), random.range(0.5, 9.0));
        let bounds = Aabb { min: low, max: low + size };
        let (inside, outside) = (whole.inside(&bounds), whole.outside(&[bounds]));
        let sum = area(&inside) + area(&outside);
        assert!((sum / area(&whole) - 1.0).abs() < 1e-9, "{sum}");
        assert!((volume(&inside) + volume(&outside) - volume(&whole)).abs() < 1e-6);
        let play = 1e-9;
        assert!(inside.mesh.positions.iter().all(|p| bounds.expanded(play).contains(p)));
        for t in 0..outside.mesh.triangles.len() {
            let [a, b, c] = outside.mesh.corners(t);
            let middle = Point::from((a.coords + b.coords + c.coords) / 3.0);
            assert!(!bounds.expanded(-play).contains(&middle), "{middle}");
        }
        for s in [&inside, &outside] {
            assert_eq!((s.normals.len(), s.made_by.len()), (s.mesh.positions.len(), s.mesh.positions.len()));
        }
    }
    // A box that the mesh does not meet leaves every number as it is.
    let far = cuboid([100.0; 3], [101.0; 3]);
    assert_eq!(whole.outside(&[far]), whole);
    assert!(whole.inside(&far).mesh.triangles.is_empty());
}

/// Stock outside of the windows and patches inside make one surface: volume by the divergence theorem.
#[test]
fn stock_and_patches_together_bound_the_part() {
    let bounds = cuboid([0.0; 3], [30.0, 20.0, 10.0]);
    let body = RawBody::block(&bounds);
    let mut stock = body.stock(0.5, GIB).unwrap();
    let windows = [cuboid([8.1, -1.0, 2.0], [15.2, 11.0, 11.0]), cuboid([15.2, 4.0, 2.0], [22.0, 21.0, 11.0])];
    let mut patches: Vec<Patch> =
        windows.iter().map(|w| Patch::new("p", plan(&stock, w, 0.1), &body, GIB).unwrap()).collect();
    let tool = ball(3.0, 20.0);
    let cut: Vec<SweepItem<'_>> = (0..8)
        .map(|k| {
            let y = 2.0 + 2.3 * f64::from(k);
            remove(k as u32, &tool, pose([-5.0, y, 6.0], UP), pose([35.0, y, 7.0], UP))
        })
        .collect();
    stock.sweep(&cut);
    patches.iter_mut().for_each(|p| p.sweep(&cut));
    let windows: Vec<Aabb> = patches.iter().map(|p| *p.window()).collect();
    let outside = volume(&stock.surface().outside(&windows));
    let together = outside + patches.iter().map(|p| volume(&p.surface())).sum::<f64>();
    let (fine, coarse) = (body.stock(0.1, GIB).unwrap(), stock.volume());
    let mut fine = fine;
    fine.sweep(&cut);
    // Chords of the coarse mesh cut off cell² / 8 r = 0.01 mm of the slots outside of the windows, some 430
    // mm².
    assert!((together - fine.volume()).abs() < 4.5, "{together} {} {coarse}", fine.volume());
}

#[test]
fn cylinders_and_meshes_have_patches_too() {
    let window = cuboid([2.0, -4.0, 1.0], [12.0, 4.0, 7.0]);
    let bar = RawBody::cylinder(&Point::new(0.0, 0.0, -2.0), &Vector::z(), 8.0, 12.0).unwrap();
    let cube = RawBody::mesh(box_mesh(&cuboid([-8.0, -8.0, -2.0], [8.0, 8.0, 10.0]))).unwrap();
    for mut body in [bar, cube] {
        let bounds = body.prepare(COARSE, true).unwrap();
        let plan = PatchPlan::new(&bounds, [COARSE; 3], &window, FINE).unwrap();
        let (patch, whole) = (Patch::new("p", plan, &body, GIB).unwrap(), body.stock(FINE, GIB).unwrap());
        let mine: Vec<SurfacePoint> = patch.surface_points().collect();
        assert!(mine.len() > 2000 && mine.iter().all(|p| p.point.x > 4.0), "the skin, and no face of the patch");
        assert_eq!(mine, in_window(&whole, patch.window()));
    }
}

#[test]
fn a_patch_of_an_earlier_stock_is_taken_over_where_it_can_be() {
    let window = cuboid([10.0, 5.0, 3.0], [20.0, 25.0, 15.0]);
    let (mut stock, mut patch, _) = block(&window);
    let tool = ball(4.0, 20.0);
    let cut = [remove(7, &tool, pose([14.3, -20.0, 6.1], UP), pose([14.3, 50.0, 6.1], UP))];
    stock.sweep(&cut);
    patch.sweep(&cut);
    let places = |p: &Patch| p.surface_points().map(|p| (p.point, p.normal)).collect::<Vec<_>>();
    let next = |fine: Vec<TriDexel>, pose: &Pose| {
        let mut body = RawBody::earlier(stock.clone(), fine, pose).unwrap();
        let bounds = body.prepare(COARSE, true).unwrap();
        let by = pose.translation;
        let window = Aabb { min: window.min + by, max: window.max + by };
        let plan = PatchPlan::new(&bounds, [COARSE; 3], &window, FINE).unwrap();
        (body.stock(COARSE, GIB).unwrap(), Patch::new("p", plan, &body, GIB).unwrap())
    };
    // The same patch again: bit for bit, and no bound.
    let (again, exact) = next(vec![patch.stock().clone()], &Pose::identity());
    assert_eq!((again.regrid_bound(), exact.stock().regrid_bound()), (None, None));
    assert_eq!(places(&exact), places(&patch));
    assert_eq!(exact.stock().sweep_bound_mm(), patch.stock().sweep_bound_mm());
    assert!(exact.surface_points().all(|p| p.made_by.is_none()), "it is raw stock now");
    // Shifted by half a mm: still its rays.
    let (_, shifted) = next(vec![patch.stock().clone()], &Pose::from_translation(Vector::new(0.5, -0.25, 2.0)));
    assert_eq!((shifted.stock().regrid_bound(), places(&shifted).len()), (None, places(&patch).len()));
    // Without it the coarse stock is re-gridded, which is reported: chords of 1 mm in a ball of 4 mm.
    let (again, coarse) = next(Vec::new(), &Pose::identity());
    assert_eq!(again.regrid_bound(), None);
    let bound = coarse.stock().regrid_bound().unwrap();
    assert!(bound.surface_mm > 0.01 && bound.surface_mm < 0.2, "{bound:?}");
    for p in coarse.surface_points().filter(|p| p.point.z < 8.0) {
        let off = ((p.point.x - 14.3).hypot(p.point.z - 10.1) - 4.0).abs();
        assert!(off <= bound.surface_mm + 1e-3, "{off} at {}", p.point);
    }
}

#[test]
fn patches_that_cannot_be_are_refused_with_their_numbers() {
    let stock = cuboid([0.0; 3], [40.0, 30.0, 12.0]);
    let refused = |low: [f64; 3], high: [f64; 3], cells: [f64; 3]| {
        PatchPlan::new(&stock, [1.0, 1.0, 0.5], &cuboid(low, high), cells).unwrap_err()
    };
    let fine = [0.1; 3];
    assert_eq!(
        refused([1.0, 5.0, 1.0], [9.0, 5.0, 2.0], fine),
        PatchError::NoVolume { axis: 'y', from_mm: 5.0, to_mm: 5.0 }
    );
    assert!(matches!(refused([1.0, 5.0, 1.0], [9.0, f64::NAN, 2.0], fine), PatchError::NoVolume { axis: 'y', .. }));
    assert!(matches!(
        refused([1.0, 5.0, f64::NEG_INFINITY], [9.0, 6.0, 2.0], fine),
        PatchError::NoVolume { axis: 'z', .. }
    ));
    assert_eq!(
        refused([40.0, 1.0, 1.0], [50.0, 2.0, 2.0], fine),
        PatchError::Outside { axis: 'x', from_mm: 40.0, to_mm: 50.0, stock_from_mm: 0.0, stock_to_mm: 40.0 }
    );
    assert!(matches!(
        refused([39.85, 1.0, 1.0], [50.0, 2.0, 2.0], fine),
        PatchError::Thin { axis: 'x', size_mm, cell_mm: 0.1 } if (size_mm - 0.15).abs() < 1e-9
    ));
    assert!(matches!(refused([1.0; 3], [9.0; 3], [0.1, 0.0, 0.1]), PatchError::Cell { axis: 'y', .. }));
    assert_eq!(
        refused([1.0; 3], [9.0; 3], [0.1, 0.1, 0.6]),
        PatchError::Coarse { axis: 'z', cell_mm: 0.6, stock_mm: 0.5 }
    );
    assert!(
        matches!(refused([1.0; 3], [9.0; 3], [1.0, 1.0, 0.5]), PatchError::Coarse { .. }),
        "no finer than the stock"
    );
    for e in [refused([1.0; 3], [1.0; 3], fine), refused([-9.0; 3], [-8.0; 3], fine)] {
        assert!(!e.remedy().is_empty() && e.to_string().contains("mm"), "{e}");
    }
    // Memory is refused before it is taken.
    let body = RawBody::block(&stock);
    let plan = PatchPlan::new(&stock, [1.0; 3], &cuboid([1.0; 3], [11.0; 3]), 0.001).unwrap();
    assert!(plan.memory_estimate() > GIB);
    assert!(matches!(Patch::new("p", plan, &body, GIB), Err(StockError::Memory { .. })));
}

#[test]
fn a_probe_and_a_motion_far_away_leave_a_patch_as_it_is() {
    let (_, mut patch, _) = block(&cuboid([10.0, 5.0, 3.0], [20.0, 25.0, 15.0]));
    let before: Vec<SurfacePoint> = patch.surface_points().collect();
    let tool = ball(4.0, 20.0);
    let nowhere = remove(3, &tool, pose([f64::NAN, 10.0, 5.0], UP), pose([16.0, 10.0, 5.0], UP));
    patch.sweep(&[
        probe(1, &tool, pose([14.0, 10.0, 5.0], UP), pose([16.0, 10.0, 5.0], UP)),
        remove(2, &tool, pose([-300.0, 10.0, 5.0], UP), pose([-40.0, 10.0, 5.0], UP)),
    ]);
    assert_eq!(patch.stock().sweep_bound_mm(), 0.0, "nothing came near it");
    patch.sweep(&[nowhere]);
    assert_eq!(patch.surface_points().collect::<Vec<_>>(), before);
}
