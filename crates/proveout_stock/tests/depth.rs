//! Depth of motions in the material against closed forms: distance of the deepest point from the free
//! surface, whatever the rays see along other directions, and however the motion is cut into pieces.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use crate::common;
use crate::common::{Random, ball, cuboid, drill, flat, pose, probe, remove};
use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_stock::{Depths, Measure, SweepItem, SweepReport, TriDexel};
use proveout_tool::Profile;

const UP: [f64; 3] = [0.0, 0.0, 1.0];
/// Overlap that counts as touching in scenes, mm.
const CONTACT: f64 = 0.01;

fn block(cell: f64) -> TriDexel {
    stock(&cuboid([0.0, 0.0, -20.0], [60.0, 20.0, 0.0]), cell)
}

fn stock(bounds: &Aabb, cell: f64) -> TriDexel {
    TriDexel::from_box(bounds, cell, common::GIB).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> ToolPose {
    pose([x, y, z], UP)
}

/// A straight motion in so many pieces with rising ids, the depth of each measured since the first.
fn rapid(stock: &mut TriDexel, depths: &mut Depths, body: &Profile, id: u32, way: [ToolPose; 2], pieces: u32) -> f64 {
    let on = |k: u32| way[0].interpolated(&way[1], f64::from(k) / f64::from(pieces));
    let items: Vec<SweepItem<'_>> = (0..pieces).map(|k| remove(id + k, body, on(k), on(k + 1))).collect();
    let reports = stock.sweep_measured(&items, &vec![Measure::Since(id); items.len()], depths);
    deepest(&reports)
}

fn deepest(reports: &[SweepReport]) -> f64 {
    reports.iter().filter_map(|r| r.depth_mm).fold(0.0, f64::max)
}

/// Chords of the same, what a ray saw at its longest.
fn longest(reports: &[SweepReport]) -> f64 {
    reports.iter().map(|r| r.overlap_mm).fold(0.0, f64::max)
}

#[test]
fn a_plunge_is_as_deep_as_its_tip() {
    // A drill is slender: rays across it see 3 mm at most, those along it all of its way.
    for (name, body) in [("flat", flat(1.5, 40.0)), ("drill", drill(1.5, 1.18, 40.0)), ("ball", ball(4.0, 40.0))] {
        for (depth, pieces) in [(0.02, 1), (0.3, 7), (4.0, 150), (15.0, 1), (15.0, 9)] {
            let mut stock = block(0.2);
            // The axis lies on a ray along z, so that this one sees the tip.
            let way = [at(30.1, 10.1, 3.0), at(30.1, 10.1, -depth)];
            let found = rapid(&mut stock, &mut Depths::new(CONTACT), &body, 5, way, pieces);
            // Only the very tip of a cone is that deep: it lies on the ray, and 1e-7 mm are the body's
            // shrinkage.
            assert!((found - depth).abs() < 2e-6, "{name} {depth} in {pieces}: {found}");
        }
    }
}

#[test]
fn a_side_step_is_as_deep_as_it_goes() {
    for side in [0.05, 1.0, 3.5] {
        for pieces in [1, 9, 50] {
            let mut stock = block(0.2);
            let body = flat(5.0, 40.0);
            // Next to the block, 8 mm below its top, then into its face x = 0: the deepest point is the apex
            // on a ray along x.
            let way = [at(-6.0, 10.1, -8.0), at(-5.0 + side, 10.1, -8.0)];
            let found = rapid(&mut stock, &mut Depths::new(CONTACT), &body, 0, way, pieces);
            assert!((found - side).abs() < 2e-6, "{side} in {pieces}: {found}");
        }
    }
}

/// A slot in feed to x = 50, 5 mm deep; then at rapid rate on, along the slot. What stops the cutter is the
/// floor of the groove as long as it has not gone further than it is deep.
#[test]
fn dragging_on_after_a_slot_is_as_deep_as_the_nearest_face() {
    let body = flat(1.0, 20.0);
    for (on, depth) in [(0.5, 0.5), (2.0, 2.0), (8.0, 5.0)] {
        for pieces in [1, 40] {
            let mut stock = block(0.1);
            stock.sweep(&[
                remove(0, &body, at(30.05, 10.05, 3.0), at(30.05, 10.05, -5.0)),
                remove(1, &body, at(30.05, 10.05, -5.0), at(50.05, 10.05, -5.0)),
            ]);
            let way = [at(50.05, 10.05, -5.0), at(50.05 + on, 10.05, -5.0)];
            let found = rapid(&mut stock, &mut Depths::new(CONTACT), &body, 2, way, pieces);
            assert!((found - depth).abs() < 2e-6, "{on}: {found}");
        }
    }
}

/// The end of a slot that was not quite reached, taken by the retract along it: a shaving of 3 micrometers
/// over 5 mm of height. It lies on a ray along z.
#[test]
fn a_shaving_is_as_deep_as_it_is_wide() {
    let body = flat(1.5, 20.0);
    let mut stock = block(0.2);
    let (short, end) = (49.3985, 49.4015);
    stock.sweep(&[
        remove(0, &body, at(30.1, 10.1, 3.0), at(30.1, 10.1, -5.0)),
        remove(1, &body, at(30.1, 10.1, -5.0), at(short, 10.1, -5.0)),
    ]);
    let items = [
        remove(2, &body, at(short, 10.1, -5.0), at(end, 10.1, -4.9)),
        remove(3, &body, at(end, 10.1, -4.9), at(end, 10.1, 3.0)),
    ];
    let reports = stock.sweep_measured(&items, &[Measure::Since(2); 2], &mut Depths::new(CONTACT));
    assert!(longest(&reports) > 4.0, "{reports:?}");
    let depth = deepest(&reports);
    assert!((depth - 0.003).abs() < 1e-5, "{depth}");
}

/// A shaved wall and a real cut in one motion: the one does not hide the other.
#[test]
fn a_deep_place_is_seen_beside_a_shaving() {
    let body = flat(2.0, 20.0);
    let mut stock = block(0.2);
    // A pocket 6 mm deep, whose scalloped wall at x = 10 is shaved, while the tip goes into its floor.
    for k in 0..9 {
        let y = 6.1 + f64::from(k);
        stock.sweep(&[remove(k, &body, at(12.002, y, -6.0), at(18.0, y, -6.0))]);
    }
    let way = [at(12.0, 6.1, -1.0), at(12.0, 14.1, -6.7)];
    let mut depths = Depths::new(CONTACT);
    let found = rapid(&mut stock, &mut depths, &body, 30, way, 3);
    assert!((found - 0.7).abs() < 1e-5, "{found}");
}

#[test]
fn a_rib_that_is_cut_through_is_as_deep_as_thick() {
    let rib = cuboid([0.0, 0.0, 0.0], [30.0, 0.8, 10.0]);
    let body = flat(4.0, 40.0);
    for pieces in [1, 3, 28, 150] {
        let mut stock = stock(&rib, 0.1);
        let way = [at(15.05, -6.0, -1.0), at(15.05, 8.0, -1.0)];
        let found = rapid(&mut stock, &mut Depths::new(CONTACT), &body, 1, way, pieces);
        assert!((found - 0.8).abs() < 1e-6, "{pieces}: {found}");
    }
}

/// A face under 45 degrees, entered along its normal: no ray runs that way.
#[test]
fn slanting_faces_have_their_depth_along_the_normal() {
    let mut stock = stock(&cuboid([0.0, 0.0, 0.0], [30.0, 30.0, 30.0]), 0.25);
    // The corner x + z > 30 goes first.
    let n = Vector::new(1.0, 0.0, 1.0) / 2_f64.sqrt();
    let plane = Point::new(15.0, 15.0, 15.0);
    let wide = flat(40.0, 60.0);
    let on = |p: Point| ToolPose { tip: p, axis: n };
    stock.sweep(&[remove(0, &wide, on(plane - Vector::new(0.0, 50.0, 0.0)), on(plane + Vector::new(0.0, 50.0, 0.0)))]);
    for (k, depth) in [0.4, 2.0, 6.0].into_iter().enumerate() {
        let mut stock = stock.clone();
        let body = flat(3.0, 50.0);
        let items = [remove(1 + k as u32, &body, on(plane + n * 2.0), on(plane - n * depth))];
        let reports = stock.sweep_measured(&items, &[Measure::Alone], &mut Depths::new(CONTACT));
        let found = deepest(&reports);
        // Slanting faces lie between the rays: 7e-5 rad of the stored normals over the way.
        assert!((found - depth).abs() < 2e-3, "{depth}: {found}");
        assert!(longest(&reports) > 1.3 * depth);
    }
}

/// A shank that rubs, probed again and again by short motions: the depth is that in the wall as it is.
#[test]
fn probes_see_the_whole_depth_each_time() {
    let mut stock = block(0.2);
    let shank = flat(6.0, 40.0);
    let mut depths = Depths::new(CONTACT);
    let items: Vec<_> = (0..20)
        .map(|k| {
            let x = -5.3 + 1e-3 * f64::from(k);
            probe(k as u32, &shank, at(x, 10.1, -9.0), at(x + 1e-3, 10.1, -9.0))
        })
        .collect();
    let reports = stock.sweep_measured(&items, &[Measure::Alone; 20], &mut depths);
    for (k, r) in reports.iter().enumerate() {
        let depth = 0.7 + 1e-3 * (k as f64 + 1.0);
        assert!((r.depth_mm.unwrap() - depth).abs() < 2e-6, "{k}: {r:?}");
        assert!(r.overlap_mm > 4.0);
    }
    assert_eq!(stock.volume(), stock.initial_volume());
}

#[test]
fn what_touches_only_has_no_depth_and_small_overlaps_are_their_own() {
    let mut stock = block(0.2);
    let body = flat(2.0, 20.0);
    let mut depths = Depths::new(CONTACT);
    let items = [
        remove(1, &body, at(10.1, 10.1, 5.0), at(10.1, 10.1, 0.0)),
        remove(2, &body, at(20.1, 10.1, 5.0), at(20.1, 10.1, 0.0)),
    ];
    let reports = stock.sweep_measured(&items, &[Measure::Since(1), Measure::No], &mut depths);
    assert!(reports.iter().all(|r| r.depth_mm.is_none()), "{reports:?}");
    assert!(stock.sweep(&[remove(3, &body, at(10.1, 10.1, 5.0), at(10.1, 10.1, -1.0))])[0].depth_mm.is_none());
}

/// A body that is inside of the block from the beginning has no free surface to be seen from: never a small
/// number.
#[test]
fn a_start_inside_of_material_is_as_deep_as_its_longest_overlap() {
    let mut stock = block(0.5);
    let body = flat(2.0, 4.0);
    let items = [remove(1, &body, at(30.1, 10.1, -12.0), at(31.1, 10.1, -12.0))];
    let reports = stock.sweep_measured(&items, &[Measure::Since(1)], &mut Depths::new(CONTACT));
    assert_eq!(reports[0].depth_mm, Some(reports[0].overlap_mm));
    assert!(reports[0].overlap_mm > 4.0);
}

/// Batches and runs: the depth of a run goes on over calls, a new run begins again; measuring changes nothing
/// that is cut.
#[test]
fn runs_go_on_over_batches_and_measuring_cuts_nothing_else() {
    let mut random = Random(77);
    let body = ball(3.0, 30.0);
    let mut places = vec![at(5.0, 5.0, 4.0)];
    for _ in 0..60 {
        places.push(at(random.range(2.0, 58.0), random.range(2.0, 18.0), random.range(-6.0, 3.0)));
    }
    let items: Vec<_> = places.windows(2).enumerate().map(|(k, w)| remove(k as u32, &body, w[0], w[1])).collect();
    // Every third motion begins a run of three.
    let measures: Vec<Measure> = (0..items.len() as u32).map(|k| Measure::Since(k - k % 3)).collect();
    let (mut plain, mut whole, mut parts) = (block(0.3), block(0.3), block(0.3));
    let a = plain.sweep(&items);
    let mut depths = Depths::new(CONTACT);
    let b = whole.sweep_measured(&items, &measures, &mut depths);
    let mut depths = Depths::new(CONTACT);
    let c: Vec<_> =
        (0..items.len()).flat_map(|k| parts.sweep_measured(&items[k..=k], &measures[k..=k], &mut depths)).collect();
    assert_eq!(b, c);
    for (x, y) in a.iter().zip(&b) {
        assert_eq!(*x, SweepReport { depth_mm: None, ..*y });
        assert!(y.depth_mm.is_none_or(|d| d > 0.0), "{y:?}");
    }
    assert!(b.iter().filter(|r| r.depth_mm.is_some()).count() > 30);
    assert_eq!(plain.surface_points().collect::<Vec<_>>(), whole.surface_points().collect::<Vec<_>>());
}

/// A ray touches the cone of a drill at its deepest place: what the way down may leave of it is no depth on
/// the way up.
#[test]
fn a_chord_that_the_sweep_may_leave_is_no_depth() {
    // Half angle 67.5 degrees; the ray x = any, y = 9.125, z = -14.625 lies 0.905 mm off the axis, where
    // the cone has 0.90533.
    let drill = drill(1.5, 67.5_f64.to_radians(), 30.0);
    let mut stock = block(0.25);
    stock.sweep(&[remove(0, &drill, at(10.03, 10.03, 3.0), at(10.03, 10.03, -15.0))]);
    for pieces in [1, 7] {
        let way = [at(10.03, 10.03, -15.0), at(10.03, 10.03, 3.0)];
        let found = rapid(&mut stock.clone(), &mut Depths::new(CONTACT), &drill, 1, way, pieces);
        assert!(found < 4e-4, "{found}");
    }
}

/// A body that goes through ribs at random, measured in full and as far as a finding asks for it: the deepest
/// item of each run has its depth, no other is said to be deeper than it is, and which items are deeper than
/// a touch is the same.
#[test]
fn what_a_finding_asks_for_is_that_of_the_whole_measure() {
    let body = flat(9.0, 6.0);
    let mut random = Random(11);
    let mut runs = 0;
    for _ in 0..12 {
        let cell = random.range(0.25, 0.6);
        let mut stock = block(cell);
        let cutter = flat(1.6, 40.0);
        for k in 0..1 + random.pick(5) as u32 {
            let x = random.range(0.0, 60.0);
            stock.sweep(&[remove(k, &cutter, at(x, -3.0, -12.0), at(x, 23.0, -12.0))]);
        }
        // In and out of the block, some of it just touching its top.
        let mut from = at(-12.0, 10.1, 0.5);
        let ways: Vec<[ToolPose; 2]> = (0..60)
            .map(|k| {
                let dip = if k % 9 < 3 { 0.3 } else { random.range(-1.8, 0.006) };
                let to = at(from.tip.x + random.range(0.2, 2.2), 10.1, dip);
                [std::mem::replace(&mut from, to), to]
            })
            .collect();
        let items: Vec<_> = ways.iter().zip(50..).map(|([a, b], id)| probe(id, &body, *a, *b)).collect();
        let mut depths = |measure: &dyn Fn(usize) -> Measure| -> Vec<f64> {
            let measures: Vec<Measure> = (0..items.len()).map(measure).collect();
            let reports = stock.sweep_measured(&items, &measures, &mut Depths::new(CONTACT));
            reports.iter().map(|r| r.depth_mm.unwrap_or(r.overlap_mm)).collect()
        };
        let whole = depths(&|_| Measure::Alone);
        let touch = depths(&|_| Measure::Touch);
        // Runs end where nothing is met, and at every twentieth item.
        let deepest_of = depths(&|k| Measure::Deepest(50 + k as u32 / 20 * 20));
        for k in 0..items.len() {
            for (how, least) in [("touch", touch[k]), ("deepest", deepest_of[k])] {
                assert_eq!(least > CONTACT, whole[k] > CONTACT, "{how} {k}: {least} of {}", whole[k]);
                assert!(least <= whole[k] + 1e-9, "{how} {k}: {least} of {}", whole[k]);
            }
        }
        let mut k = 0;
        while k < items.len() {
            let end = (k + 1..items.len()).find(|&e| e % 20 == 0 || whole[e] <= CONTACT).unwrap_or(items.len());
            let most = |of: &[f64]| of[k..end].iter().copied().fold(0.0, f64::max);
            let both = [most(&deepest_of), most(&whole)];
            assert!((both[0] - both[1]).abs() < 1e-9, "{k} to {end}: {both:?}");
            runs += usize::from(most(&whole) > CONTACT);
            k = end;
        }
    }
    assert!(runs > 60, "{runs} runs in material");
}
