//! Closed forms and laws of the stock.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use std::f64::consts::PI;

use crate::common::{GIB, Random, ball, bull, cuboid, flat, pose, probe, random_cutter, remove};
use proveout_geom::{Point, ToolPose, Vector, box_mesh, cylinder_mesh};
use proveout_stock::{StockError, SurfacePoint, SweepItem, TriDexel};

const UP: [f64; 3] = [0.0, 0.0, 1.0];
/// The promise of the crate, mm.
const BOUND: f64 = 1e-3;

fn block(cell: f64) -> TriDexel {
    TriDexel::from_box(&cuboid([0.0, 0.0, 0.0], [20.0, 16.0, 8.0]), cell, GIB).unwrap()
}

#[test]
fn a_box_has_its_volume_and_ends() {
    let stock = block(0.5);
    assert!((stock.volume() - 2560.0).abs() < 1e-9);
    assert_eq!(stock.counts(), [40, 32, 16]);
    assert_eq!(stock.surface_points().count(), 2 * stock.rays());
    let ([x, y], spans) = stock.intervals_on(2, 3.3, 4.1);
    assert_eq!((x, y), (3.25, 4.25));
    assert_eq!((spans.len(), spans[0].lo, spans[0].hi), (1, 0.0, 8.0));
}

#[test]
fn a_ball_cuts_a_round_slot() {
    let mut stock = block(0.25);
    let tool = ball(3.0, 30.0);
    // Depth 2: bottom at z = 6, axis at z = 9.
    stock.sweep(&[remove(1, &tool, pose([-5.0, 8.0, 6.0], UP), pose([25.0, 8.0, 6.0], UP))]);
    let mut cut = 0;
    for p in stock.surface_points().filter(|p| p.made_by == Some(1)) {
        let off = (p.point.y - 8.0).hypot(p.point.z - 9.0) - 3.0;
        assert!(off.abs() < 1e-6, "{:?} is {off} mm off the cylinder", p.point);
        let radial = Vector::new(0.0, 8.0 - p.point.y, 9.0 - p.point.z) / 3.0;
        assert!((p.normal.unwrap() - radial).norm() < 1e-3);
        cut += 1;
    }
    assert!(cut > 1000);
    // Segment of a circle of height 2, 20 mm long; the rays along x see it in full, the others sample it.
    let area = 9.0 * (1.0_f64 / 3.0).acos() - 1.0 * 8.0_f64.sqrt();
    assert!((stock.initial_volume() - stock.volume() - 20.0 * area).abs() < 0.02 * 20.0 * area);
}

#[test]
fn a_plunge_leaves_the_body() {
    for (tool, r, c) in [(flat(4.0, 40.0), 4.0, 0.0), (bull(4.0, 1.5, 40.0), 4.0, 1.5)] {
        let mut stock = block(0.25);
        stock.sweep(&[remove(1, &tool, pose([10.0, 8.0, 20.0], UP), pose([10.0, 8.0, 3.0], UP))]);
        for p in stock.surface_points().filter(|p| p.made_by == Some(1)) {
            let (d, z) = ((p.point.x - 10.0).hypot(p.point.y - 8.0), p.point.z - 3.0);
            let off = if z < c && d > r - c { (d - r + c).hypot(z - c) - c } else { (d - r).max(-z) };
            assert!(off.abs() < 1e-6, "{:?} is {off} mm off", p.point);
        }
        let ([x, y], spans) = stock.intervals_on(2, 10.0, 8.0);
        assert!((x - 10.0).abs() < 0.2 && (y - 8.0).abs() < 0.2);
        assert!((spans[0].hi - 3.0).abs() < 1e-6);
    }
}

#[test]
fn a_bull_nose_on_a_circle_cuts_a_torus_groove() {
    // 720 chords of a circle of radius 5: the surface is the torus tube with a chord error of 5 (1 - cos 0.25
    // deg).
    let mut stock = block(0.25);
    let tool = ball(1.5, 30.0);
    let at = |k: usize| {
        let (s, c) = (PI * k as f64 / 360.0).sin_cos();
        pose([10.0 + 5.0 * c, 8.0 + 5.0 * s, 7.0], UP)
    };
    let items: Vec<SweepItem<'_>> = (0..720).map(|k| remove(1, &tool, at(k), at(k + 1))).collect();
    stock.sweep(&items);
    let chord = 5.0 * (1.0 - (PI / 720.0).cos());
    let mut cut = 0;
    for p in stock.surface_points().filter(|p| p.made_by.is_some()) {
        let d = (p.point.x - 10.0).hypot(p.point.y - 8.0);
        let off = (d - 5.0).hypot(p.point.z - 8.5) - 1.5;
        assert!(off.abs() < chord + 1e-4, "{off}");
        cut += 1;
    }
    assert!(cut > 500);
}

#[test]
fn the_tube_of_a_bull_nose_on_a_circle_leaves_a_flat_groove_with_round_walls() {
    // The corner circle of radius 2.5 about a path of radius 5 sweeps the ring from 2.5 to 7.5 at z = 6.5:
    // the groove is all within 1 mm of it. 720 chords, as above.
    let mut stock = block(0.25);
    let tool = bull(3.5, 1.0, 30.0);
    let at = |k: usize| {
        let (s, c) = (PI * k as f64 / 360.0).sin_cos();
        pose([10.0 + 5.0 * c, 8.0 + 5.0 * s, 5.5], UP)
    };
    let items: Vec<SweepItem<'_>> = (0..720).map(|k| remove(1, &tool, at(k), at(k + 1))).collect();
    stock.sweep(&items);
    let chord = 5.0 * (1.0 - (PI / 720.0).cos());
    let mut cut = 0;
    for p in stock.surface_points().filter(|p| p.made_by.is_some()) {
        let d = (p.point.x - 10.0).hypot(p.point.y - 8.0);
        let outside = (d - 7.5).max(2.5 - d).max(0.0);
        // Above the tube the walls are straight.
        let below = (6.5 - p.point.z).max(0.0);
        let off = outside.hypot(below) - 1.0;
        assert!(off.abs() < chord + 1e-3, "{:?}: {off}", p.point);
        cut += 1;
    }
    assert!(cut > 2000);
}

#[test]
fn a_tilted_cylinder_on_a_helix_cuts_to_its_radius_from_the_axis() {
    // The axis leans 17 degrees along the path and goes round on a helix. By the symmetry of the helix the
    // distance of a cut point from the axis, minimized over the angle, is the radius. Steps of half a degree
    // leave the helix by 6 (1 - cos 0.25 deg) = 0.06 micrometers, the axis leaves its cone by less than 0.03
    // in the 10 mm that cut.
    let mut stock = block(0.4);
    let tool = flat(2.0, 60.0);
    let line_at = |angle: f64| {
        let (s, c) = angle.sin_cos();
        let axis = Vector::new(-0.3 * s, 0.3 * c, 1.0).normalize();
        (Point::new(10.0 + 6.0 * c, 8.0 + 6.0 * s, -3.0 - 0.2 * angle), axis)
    };
    let at = |k: usize| {
        let (tip, axis) = line_at(0.5_f64.to_radians() * k as f64);
        ToolPose { tip, axis }
    };
    let items: Vec<SweepItem<'_>> = (0..180).map(|k| remove(k, &tool, at(k as usize), at(k as usize + 1))).collect();
    stock.sweep(&items);
    let mut cut = 0;
    for p in stock.surface_points().filter(|p| p.made_by.is_some()) {
        let distance = |angle: f64| {
            let (tip, axis) = line_at(angle);
            (p.point - tip).cross(&axis).norm()
        };
        let n = 400;
        let best = (0..=n).map(|k| 0.5 * PI * f64::from(k) / f64::from(n));
        let near = best.min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap();
        let step = 0.5 * PI / f64::from(n);
        let (mut a, mut b) = ((near - step).max(0.0), (near + step).min(0.5 * PI));
        for _ in 0..60 {
            let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
            if distance(c) < distance(d) { b = d } else { a = c }
        }
        let off = distance(a) - 2.0;
        assert!(off.abs() < BOUND, "{:?}: {off}", p.point);
        cut += 1;
    }
    assert!(cut > 500 && stock.sweep_bound_mm() <= BOUND);
}

#[test]
fn the_order_of_moves_that_do_not_meet_changes_nothing() {
    let tool = bull(1.0, 0.4, 20.0);
    let mut random = Random(5);
    let moves: Vec<(ToolPose, ToolPose)> = (0..12)
        .map(|k| {
            let (x, y) = (2.5 + 5.0 * f64::from(k % 4), 3.0 + 5.0 * f64::from(k / 4));
            let axis = [0.2 * random.next(), 0.2 * random.next(), 1.0];
            let turned = [axis[0] + 0.03, axis[1] - 0.02, 1.0];
            (pose([x, y, 5.5], axis), pose([x + 0.6, y + 0.3, 5.0], turned))
        })
        .collect();
    let run = |order: &[usize]| {
        let mut stock = block(0.2);
        let items: Vec<SweepItem<'_>> =
            order.iter().map(|&k| remove(k as u32, &tool, moves[k].0, moves[k].1)).collect();
        let reports = stock.sweep(&items);
        let mut volumes = vec![0.0; order.len()];
        for (&k, r) in order.iter().zip(&reports) {
            volumes[k] = r.volume_mm3;
        }
        (volumes, stock.surface_points().collect::<Vec<_>>())
    };
    let forward: Vec<usize> = (0..12).collect();
    let mixed = [7, 2, 11, 0, 5, 9, 1, 10, 3, 8, 6, 4];
    let ((a, b), (a_points, b_points)) = {
        let (first, second) = (run(&forward), run(&mixed));
        ((first.0, second.0), (first.1, second.1))
    };
    for (a, b) in a.iter().zip(&b) {
        assert!(*a > 0.1 && (a - b).abs() < 1e-5 * a, "{a} {b}");
    }
    assert_eq!(a_points.len(), b_points.len());
    for (a, b) in a_points.iter().zip(&b_points) {
        assert_eq!((a.made_by, a.axis), (b.made_by, b.axis));
        // The search begins at the material, which another move has changed: the same end within the bound,
        // along the ray.
        assert!((a.point - b.point).norm() < 0.01, "{a:?} {b:?}");
        let normal = a.normal.unwrap()[usize::from(a.axis)].abs();
        assert!((a.point - b.point).norm() * normal < BOUND, "{a:?} {b:?}");
    }
}

#[test]
fn a_face_exactly_on_a_ray_or_at_the_origin_is_no_gouge() {
    // Rays at -0.75, -0.25, 0.25, ...: walls and floors of the tool fall on rays, and on the faces of the
    // stock.
    for (x0, y0) in [(0.0, 0.0), (-1.0, -1.0)] {
        let bounds = cuboid([x0, y0, 0.0], [x0 + 10.0, y0 + 10.0, 5.0]);
        let fresh = || TriDexel::from_box(&bounds, 0.5, GIB).unwrap();
        for tilt in [0.0, 1e-9] {
            let tool = flat(2.0, 30.0);
            let axis = [0.0, tilt, 1.0];
            let wall = y0 + 1.25; // the flank stands on rays along x and z
            let mut stock = fresh();
            let items = [
                remove(1, &tool, pose([x0 - 5.0, wall - 2.0, 0.0], UP), pose([x0 + 15.0, wall - 2.0, 0.0], axis)),
                remove(2, &tool, pose([x0 - 5.0, wall - 2.0, -1.0], UP), pose([x0 + 15.0, wall - 2.0, -1.0], UP)),
            ];
            stock.sweep(&items);
            // What the wall leaves: the slab beyond it, every ray of it whole.
            for i in 0..20 {
                for j in 0..20 {
                    let at = stock.ray_place(2, i, j);
                    let length: f64 = stock.ray_intervals(2, i, j).iter().map(|s| s.hi - s.lo).sum();
                    let want = if at[1] < wall - 1e-6 { 0.0 } else { 5.0 };
                    assert!((length - want).abs() < 1e-6 || (at[1] - wall).abs() < 1e-6, "{at:?}: {length}");
                }
            }
            let probed = stock.sweep(&[probe(3, &tool, items[1].motion.from, items[1].motion.to)])[0];
            assert_eq!(probed.rays, 0, "its own wall is touched, not cut");
            // A tool that only slides along the faces x = x0 and z = 5 meets nothing.
            let mut whole = fresh();
            let slide = [
                remove(4, &tool, pose([x0 - 2.0, y0 - 5.0, -1.0], UP), pose([x0 - 2.0, y0 + 15.0, -1.0], UP)),
                remove(5, &tool, pose([x0 - 2.0, y0 + 5.0, 5.0], UP), pose([x0 + 12.0, y0 + 5.0, 5.0], UP)),
            ];
            assert!(whole.sweep(&slide).iter().all(|r| r.rays == 0));
            assert_eq!(whole.volume(), whole.initial_volume());
        }
    }
}

#[test]
fn a_tilted_cylinder_along_its_side_leaves_a_plane() {
    let mut stock = block(0.25);
    let tool = flat(3.0, 40.0);
    let axis = [0.3, 0.0, 1.0];
    // The axis lies in the xz plane through y = 16, so the flank leaves the plane y = 13.
    stock.sweep(&[remove(1, &tool, pose([-20.0, 16.0, -6.0], axis), pose([30.0, 16.0, -6.0], axis))]);
    let mut walls = 0;
    for p in stock.surface_points().filter(|p| p.made_by == Some(1)) {
        assert!((p.point.y - 13.0).abs() < stock.sweep_bound_mm(), "{:?}", p.point);
        walls += 1;
    }
    assert!(walls > 500);
}

#[test]
fn a_ruled_flank_cut_follows_the_offset_of_the_ruled_surface() {
    // The axis sweeps the ruled surface c(z, t); the flank leaves its offset by the radius. The distance of
    // every cut point from the axis, minimized over the motion, is the radius.
    let mut stock = block(0.5);
    let tool = flat(3.0, 40.0);
    let from = pose([-2.0, 16.5, -4.0], [0.0, 0.08, 1.0]);
    let to = pose([22.0, 17.5, -4.0], [0.05, -0.1, 1.0]);
    let motion = remove(1, &tool, from, to).motion;
    stock.sweep(&[remove(1, &tool, from, to)]);
    let distance = |p: &SurfacePoint, t: f64| {
        let at: ToolPose = motion.from.interpolated(&motion.to, t);
        (p.point - at.tip).cross(&at.axis).norm()
    };
    let mut cut = 0;
    for p in stock.surface_points().filter(|p| p.made_by == Some(1)) {
        let (mut a, mut b) = (0.0, 1.0);
        for _ in 0..100 {
            let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
            if distance(&p, c) < distance(&p, d) { b = d } else { a = c }
        }
        let off = distance(&p, a) - 3.0;
        assert!(off.abs() < BOUND, "{:?}: {off}", p.point);
        cut += 1;
    }
    assert!(cut > 300 && stock.sweep_bound_mm() <= BOUND);
}

#[test]
fn what_is_removed_and_what_is_left_make_the_whole() {
    let mut random = Random(77);
    for _ in 0..12 {
        let mut stock = block(0.4);
        let (_, tool) = random_cutter(&mut random);
        let mut place = || {
            let tip = [random.range(-2.0, 22.0), random.range(-2.0, 18.0), random.range(3.0, 9.0)];
            ToolPose { axis: (Vector::z() + random.direction() * 0.3).normalize(), ..pose(tip, UP) }
        };
        let mut at = place();
        let mut removed = 0.0;
        for id in 0..6 {
            let mut next = place();
            // Turns of up to some 10 degrees between neighbors.
            next.axis = (at.axis + (next.axis - at.axis) * 0.3).normalize();
            removed += stock.sweep(&[remove(id, &tool, at, next)])[0].volume_mm3;
            at = next;
        }
        assert!((removed + stock.volume() - stock.initial_volume()).abs() < 1e-7 * stock.initial_volume());
        assert!(removed > 0.0);
    }
}

#[test]
fn a_probe_reports_what_removal_would_take_and_changes_nothing() {
    let tool = flat(2.0, 20.0);
    let (from, to) = (pose([-5.0, 5.0, 6.0], UP), pose([12.0, 9.0, 5.0], [0.05, 0.0, 1.0]));
    let mut stock = block(0.25);
    let before = stock.volume();
    let probed = stock.sweep(&[probe(1, &tool, from, to)])[0];
    assert_eq!(stock.volume(), before);
    let removed = stock.sweep(&[remove(2, &tool, from, to)])[0];
    assert!((probed.volume_mm3 - removed.volume_mm3).abs() < 1e-9 && probed.rays == removed.rays);
    let again = stock.sweep(&[probe(3, &tool, from, to)])[0];
    // In length along the ray; at 1 degree to the surface the bound of 0.4 micrometers is 23 long.
    assert!(again.overlap_mm < 0.03 && again.volume_mm3 < 1e-2, "nothing is left in the swept body: {again:?}");
}

#[test]
fn touching_is_no_overlap() {
    let mut stock = block(0.25);
    let holder = flat(5.0, 30.0);
    let touching = [
        probe(1, &holder, pose([-3.0, 8.0, 8.0], UP), pose([23.0, 8.0, 8.0], UP)), // along the top
        probe(2, &holder, pose([10.0, 8.0, 20.0], UP), pose([10.0, 8.0, 8.0], UP)), // down to the top
        probe(3, &holder, pose([-5.0, -9.0, -3.0], UP), pose([-5.0, 25.0, -3.0], UP)), // flank along x = 0
        probe(4, &holder, pose([10.0, -1e-13, 0.0], [0.0, 0.0, -1.0]), pose([10.0, 8.0, 0.0], [0.0, 0.0, -1.0])), // below
    ];
    for r in stock.sweep(&touching) {
        assert_eq!((r.volume_mm3, r.overlap_mm, r.rays, r.first_point), (0.0, 0.0, 0, None));
    }
    // A slot that is cut touches its own walls and floor afterwards.
    let tool = flat(3.0, 30.0);
    let slot = (pose([0.0, 8.0, 5.0], UP), pose([20.0, 8.0, 5.0], UP));
    stock.sweep(&[remove(5, &tool, slot.0, slot.1)]);
    let back = stock.sweep(&[probe(6, &tool, slot.1, slot.0), remove(7, &tool, slot.1, slot.0)]);
    for r in back {
        // Nothing but the bound of the sweep.
        assert!(r.overlap_mm <= 1.6e-4 && r.volume_mm3 < 1e-4, "{r:?}");
    }
}

#[test]
fn dividing_a_motion_does_not_change_its_result() {
    let mut random = Random(5);
    for round in 0..10 {
        let (_, tool) = random_cutter(&mut random);
        let from = ToolPose { axis: (Vector::z() + random.direction() * 0.3).normalize(), ..pose([2.0, 5.0, 4.0], UP) };
        let turn = if round % 2 == 0 { 0.0 } else { 0.08 };
        let axis = (from.axis + random.direction() * turn).normalize();
        let to = ToolPose { axis, ..pose([15.0, 11.0, 5.0], UP) };
        let mut whole = block(0.4);
        whole.sweep(&[remove(1, &tool, from, to)]);
        let mut parts = block(0.4);
        let at = |k: usize| from.interpolated(&to, k as f64 / 7.0);
        let items: Vec<SweepItem<'_>> = (0..7).map(|k| remove(1, &tool, at(k), at(k + 1))).collect();
        parts.sweep(&items);
        let limit = 2.0 * BOUND * 3.0 * (20.0 * 16.0 + 16.0 * 8.0 + 8.0 * 20.0);
        assert!((whole.volume() - parts.volume()).abs() < limit, "{} {}", whole.volume(), parts.volume());
        // What one has removed is free for the other to within the bound.
        let left = parts.sweep(&[probe(2, &tool, from, to)])[0];
        let shallow = |d: f64| d < 0.2; // along a grazing ray a micrometer is long
        assert!(shallow(left.overlap_mm), "{left:?}");
        assert!(left.volume_mm3 < limit);
    }
}

#[test]
fn threads_and_batches_do_not_change_a_byte() {
    let mut random = Random(99);
    let tools = [ball(2.0, 20.0), bull(3.0, 1.0, 20.0), flat(1.5, 20.0)];
    let mut at = pose([1.0, 1.0, 6.0], UP);
    let items: Vec<SweepItem<'_>> = (0..150)
        .map(|k| {
            let tip = [random.range(0.0, 20.0), random.range(0.0, 16.0), random.range(5.0, 8.0)];
            let tip = at.tip + (Point::from(tip) - at.tip) * 0.2;
            let next = ToolPose { tip, axis: (at.axis + random.direction() * 0.02).normalize() };
            let tool = &tools[random.pick(3)];
            let item = if k % 5 == 4 { probe(k, tool, at, next) } else { remove(k, tool, at, next) };
            at = next;
            item
        })
        .collect();
    let run = |threads: usize, batch: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut stock = block(0.3);
            let mut reports = Vec::new();
            for part in items.chunks(batch) {
                reports.extend(stock.sweep(part));
            }
            let points: Vec<SurfacePoint> = stock.surface_points().collect();
            (format!("{reports:?}{points:?}"), stock.surface(), stock.volume().to_bits())
        })
    };
    let first = run(1, 150);
    assert!(first == run(2, 150) && first == run(5, 7) && first == run(2, 1));
}

#[test]
fn cylinders_and_meshes_become_stock() {
    let axis = Vector::new(0.2, -0.4, 1.0).normalize();
    let bar = TriDexel::from_cylinder(&Point::new(1.0, 2.0, 3.0), &axis, 6.0, 12.0, 0.1, GIB).unwrap();
    assert!((bar.volume() / (PI * 36.0 * 12.0) - 1.0).abs() < 2e-3);
    for p in bar.surface_points() {
        let y = p.point - Point::new(1.0, 2.0, 3.0);
        let z = y.dot(&axis);
        let off = ((y - axis * z).norm() - 6.0).max(z - 12.0).max(-z);
        assert!(off.abs() < 1e-9);
    }
    let mesh = cylinder_mesh(5.0, 0.0, 9.0, 96);
    let stock = TriDexel::from_mesh(&mesh, 0.1, GIB).unwrap();
    for axis in 0..3 {
        assert!((stock.volume_along(axis) / mesh.volume() - 1.0).abs() < 3e-3);
    }
    // A box mesh is the box, ray by ray, whatever the place of its faces: on rays, and on the origin.
    for (min, max, cell) in [([0.0, 0.0, 0.0], [4.0, 3.0, 2.0], 0.5), ([-1.25, -0.75, 0.25], [2.0, 1.25, 1.0], 0.5)] {
        let bounds = cuboid(min, max);
        let (a, b) = (
            TriDexel::from_box(&bounds, cell, GIB).unwrap(),
            TriDexel::from_mesh(&box_mesh(&bounds), cell, GIB).unwrap(),
        );
        let points = |s: &TriDexel| s.surface_points().collect::<Vec<_>>();
        assert_eq!(points(&a), points(&b));
    }
}

#[test]
fn bad_stocks_are_refused() {
    let bounds = cuboid([0.0; 3], [100.0, 100.0, 50.0]);
    let Err(StockError::Memory { fitting_cell_mm, .. }) = TriDexel::from_box(&bounds, 0.01, GIB) else {
        panic!("10 micrometer cells do not fit into a gibibyte")
    };
    assert!(TriDexel::memory_estimate(&bounds, fitting_cell_mm) <= GIB);
    assert!(TriDexel::memory_estimate(&bounds, 0.99 * fitting_cell_mm) > GIB);
    for cell in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(TriDexel::from_box(&bounds, cell, GIB), Err(StockError::Cell { .. })));
    }
    let empty = cuboid([0.0; 3], [1.0, 0.0, 1.0]);
    assert!(matches!(TriDexel::from_box(&empty, 0.1, GIB), Err(StockError::Degenerate { .. })));
    let mut open = box_mesh(&bounds);
    open.triangles.pop();
    let text = TriDexel::from_mesh(&open, 1.0, GIB).unwrap_err().to_string();
    assert!(text.contains("hole") && text.contains("edge"), "{text}");
    let mut crossing = box_mesh(&bounds);
    crossing.append(&box_mesh(&cuboid([50.0, 50.0, 10.0], [150.0, 150.0, 40.0])));
    let text = TriDexel::from_mesh(&crossing, 1.0, GIB).unwrap_err().to_string();
    assert!(text.contains("crosses itself") && text.contains("passes through"), "{text}");
    // The union is what a repair makes of it.
    let mended = TriDexel::from_mesh_repaired(&crossing, 1.0, GIB).unwrap();
    assert!((mended.volume() / (100.0 * 100.0 * 50.0 + 1e4 * 30.0 - 2500.0 * 30.0) - 1.0).abs() < 0.01);
    // Shells in each other do not cross, but a ray enters twice.
    let mut nested = box_mesh(&bounds);
    nested.append(&box_mesh(&cuboid([10.0, 10.0, 10.0], [20.0, 20.0, 20.0])));
    assert!(matches!(TriDexel::from_mesh(&nested, 1.0, GIB), Err(StockError::SelfCrossing { .. })));
}

#[test]
fn numbers_that_are_not_finite_meet_nothing() {
    let mut stock = block(0.5);
    let tool = flat(3.0, 20.0);
    let bad = pose([f64::NAN, 0.0, 0.0], UP);
    let good = pose([10.0, 8.0, 4.0], UP);
    let far = ToolPose { tip: Point::new(f64::INFINITY, 0.0, 0.0), ..good };
    let reports = stock.sweep(&[remove(1, &tool, bad, good), remove(2, &tool, good, far)]);
    assert!(reports.iter().all(|r| r.rays == 0));
    assert!(stock.sweep(&[]).is_empty());
}
