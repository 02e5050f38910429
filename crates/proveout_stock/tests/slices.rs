//! Engagement by slices and steps against closed forms.
#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use std::f64::consts::PI;

use crate::common::{GIB, ball, bull, cuboid, flat, pose, remove};
use proveout_geom::{Pose, ToolPose, Vector, rad};
use proveout_stock::{SliceContact, SlicePlan, TriDexel};

const UP: [f64; 3] = [0.0, 0.0, 1.0];
const CELL: f64 = 0.2;
/// Longest step and height of a slice, mm.
const STEP: f64 = 0.5;

fn block() -> TriDexel {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [40.0, 24.0, 10.0]), CELL, GIB).unwrap();
    stock.watch_slices(SlicePlan::new(STEP, 2.0 * CELL));
    stock
}

/// Contacts of one item.
fn of(all: &[SliceContact], id: u32) -> Vec<SliceContact> {
    all.iter().filter(|c| c.id == id).copied().collect()
}

/// Ranges by step, joined over a cell of path on either side, over all slices.
fn ranges(all: &[SliceContact], steps: u32, way: f64) -> Vec<[f64; 2]> {
    let reach = (CELL / (way / f64::from(steps))).ceil() as u32;
    let range = |step: u32| {
        let near = all.iter().filter(|c| c.step.abs_diff(step) <= reach);
        near.fold([f64::INFINITY, f64::NEG_INFINITY], |r, c| [r[0].min(c.angle[0]), r[1].max(c.angle[1])])
    };
    (0..steps).map(range).collect()
}

/// A cutter of radius r that leaves `width` of material on the left of its feed along x engaged: entry at 0.
fn shoulder(width: f64, way: f64) -> (Vec<SliceContact>, u32) {
    let (r, depth) = (4.0, 3.0);
    let tool = flat(r, 30.0);
    let wide = flat(6.0, 30.0);
    let mut stock = block();
    let (y, z) = (12.0, 10.0 - depth);
    let cleared = y + r - width - 6.0;
    stock.sweep(&[remove(9, &wide, pose([-9.0, cleared, z], UP), pose([49.0, cleared, z], UP))]);
    let at = |x: f64| pose([x, y, z], UP);
    stock.sweep(&[remove(10, &tool, at(-9.0), at(8.0)), remove(11, &tool, at(8.0), at(8.0 + way))]);
    let all = of(&stock.take_slices(), 11);
    let steps = all[0].steps;
    (all, steps)
}

#[test]
fn each_step_of_a_slot_half_and_quarter_has_the_angles_of_its_width() {
    let (r, way) = (4.0_f64, 24.0);
    for width in [8.0, 4.0, 2.0, 1.0] {
        let (all, steps) = shoulder(width, way);
        assert_eq!(steps, 48, "steps of half a millimeter");
        let want = (1.0 - width / r).acos();
        // A ray marks the end of the range within one cell across the feed.
        let play = (CELL / r).asin();
        for (step, [entry, exit]) in ranges(&all, steps, way).into_iter().enumerate() {
            assert!((-1e-3..play).contains(&entry), "{width} {step}: entry {entry}");
            let short = if want > 3.0 { play } else { want - (1.0 - (width - CELL) / r).acos() };
            assert!(exit <= want + 0.012 && exit >= want - short.max(play), "{width} {step}: {exit} of {want}");
        }
    }
}

#[test]
fn volumes_add_up_to_the_item_and_to_depth_times_width_times_way() {
    for width in [8.0, 4.0, 2.0] {
        let (all, _) = shoulder(width, 24.0);
        let sum: f64 = all.iter().map(|c| c.volume_mm3).sum();
        let want = width * 3.0 * 24.0;
        // Faces along the axes lie on the rays exactly; the round front is the same at both ends.
        assert!((sum / want - 1.0).abs() < 1e-3, "{width}: {sum} of {want}");
    }
}

#[test]
fn slices_hold_their_own_heights() {
    let (all, _) = shoulder(4.0, 10.0);
    for c in &all {
        let low = f64::from(c.slice) * 2.0 * CELL;
        assert!(c.height[0] >= low - 1e-4 && c.height[1] <= low + 2.0 * CELL + 1e-4, "{c:?}");
        assert!(!c.around, "{c:?}");
    }
    let top = all.iter().map(|c| c.height[1]).fold(0.0, f64::max);
    assert!((top - 3.0).abs() < 1e-3, "{top}");
    let slices: std::collections::BTreeSet<u32> = all.iter().map(|c| c.slice).collect();
    assert_eq!(slices.len(), 8, "{slices:?}: no slice between is left out");
}

#[test]
fn a_step_of_engagement_is_seen_where_the_cutter_meets_it() {
    // Up to x = 20 a shoulder of 1 mm, then one of 4 mm.
    let (r, way) = (4.0_f64, 24.0);
    let (tool, wide) = (flat(r, 30.0), flat(6.0, 30.0));
    let mut stock = block();
    let clear = |stock: &mut TriDexel, y: f64, to: f64| {
        stock.sweep(&[remove(1, &wide, pose([-20.0, y, 7.0], UP), pose([to, y, 7.0], UP))]);
    };
    clear(&mut stock, 12.0 - 6.0, 60.0);
    clear(&mut stock, 12.0 + 3.0 - 6.0, 14.0);
    let at = |x: f64| pose([x, 12.0, 7.0], UP);
    stock.sweep(&[remove(2, &tool, at(-9.0), at(8.0)), remove(3, &tool, at(8.0), at(8.0 + way))]);
    let all = of(&stock.take_slices(), 3);
    let steps = all[0].steps;
    let exits: Vec<f64> = ranges(&all, steps, way).into_iter().map(|r| r[1]).collect();
    let narrow = (1.0 - 1.0 / r).acos();
    // The wide cut ends at a half circle round x = 14: the cutter meets what it left well after x = 8.
    let x = |k: usize| 8.0 + (k as f64 + 0.5) * way / f64::from(steps);
    assert!((exits[0] - narrow).abs() < 0.15, "{} {narrow}", exits[0]);
    let met = exits.iter().position(|e| *e > 1.2).map(x).unwrap();
    assert!((8.5..20.0).contains(&met), "{met}");
    let wide_from = exits.iter().enumerate().filter(|(k, _)| x(*k) > 21.0);
    assert!(wide_from.clone().count() > 10);
    for (k, exit) in wide_from {
        assert!((exit - PI / 2.0).abs() < 0.06, "{}: {exit}", x(k));
    }
}

#[test]
fn going_down_is_met_all_around() {
    for tool in [flat(3.0, 30.0), bull(3.0, 1.0, 30.0), ball(3.0, 30.0)] {
        let mut stock = block();
        let at = |z: f64| pose([12.0, 12.0, z], UP);
        stock.sweep(&[remove(1, &tool, at(12.0), at(8.0)), remove(2, &tool, at(8.0), at(7.0))]);
        let all = of(&stock.take_slices(), 2);
        assert!(!all.is_empty() && all.iter().all(|c| c.around && c.entry_and_exit(true).is_none()), "{all:?}");
    }
}

#[test]
fn slices_turn_with_the_frame_and_do_not_depend_on_threads() {
    let tool = bull(4.0, 1.0, 30.0);
    let turn = Pose::from_rpy(Vector::new(3.0, 2.0, 1.0), rad(25.0), rad(-40.0), rad(70.0));
    let run = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
            let mut stock = TriDexel::from_box(&cuboid([-30.0; 3], [40.0, 40.0, 40.0]), 0.5, GIB).unwrap();
            stock.watch_slices(SlicePlan::new(STEP, 1.0));
            let at = |x: f64, z: f64| ToolPose::transformed(&pose([x, 0.0, z], UP), &turn);
            let room = flat(20.0, 80.0);
            stock.sweep(&[
                remove(1, &room, at(-30.0, 2.0), at(30.0, 2.0)),
                remove(2, &tool, at(-12.0, 0.0), at(-5.0, 0.0)),
            ]);
            stock.sweep(&[remove(3, &tool, at(-5.0, 0.0), at(5.0, 0.0))]);
            stock.take_slices()
        })
    };
    let all = run(1);
    assert_eq!(all, run(3));
    let own = of(&all, 3);
    let volume: f64 = own.iter().map(|c| c.volume_mm3).sum();
    // A slot 2 mm deep with a corner of 1 mm, over 10 mm: what each step takes is the section.
    let section = 8.0 * 2.0 - 2.0 * (1.0 - PI / 4.0);
    assert!((volume / (10.0 * section) - 1.0).abs() < 0.02, "{volume} {}", 10.0 * section);
    let range =
        own.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |r, c| [r[0].min(c.angle[0]), r[1].max(c.angle[1])]);
    assert!(range[0].abs() < 0.15 && (range[1] - PI).abs() < 0.15, "{range:?}");
}

#[test]
fn sorting_changes_nothing_else() {
    let tool = ball(3.0, 30.0);
    let at = |x: f64| pose([x, 12.0, 8.0], UP);
    let items = [remove(1, &tool, at(-9.0), at(8.0)), remove(2, &tool, at(8.0), at(20.0))];
    let mut with = block();
    let mut without = block();
    without.watch_slices(None);
    assert_eq!(with.sweep(&items), without.sweep(&items));
    assert!(without.take_slices().is_empty() && !with.take_slices().is_empty());
    assert!(with.take_slices().is_empty(), "taken once");
    let points = |s: &TriDexel| s.surface_points().collect::<Vec<_>>();
    assert_eq!(points(&with), points(&without));
}
