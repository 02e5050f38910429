//! Engagement against closed forms.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use std::f64::consts::{FRAC_PI_2, PI};

use crate::common::{GIB, ball, bull, cuboid, flat, pose, remove};
use proveout_geom::{Pose, ToolPose, Vector, rad};
use proveout_stock::{Contact, SweepItem, TriDexel};
use proveout_tool::Profile;

const UP: [f64; 3] = [0.0, 0.0, 1.0];
const CELL: f64 = 0.2;

fn block() -> TriDexel {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [30.0, 24.0, 10.0]), CELL, GIB).unwrap();
    stock.watch_engagement(true);
    stock
}

/// Engagement of the last item.
fn last(stock: &mut TriDexel, items: &[SweepItem<'_>]) -> Contact {
    stock.sweep(items).last().unwrap().contact.unwrap()
}

/// Range of angles of a cutter of radius r: short of the true one by less than asin(cell / r), never wider.
fn angles(contact: &Contact, want: [f64; 2], r: f64) {
    let [entry, exit] = contact.entry_and_exit(true).unwrap();
    let play = (CELL / r).asin();
    assert!(want[0] - 0.012 <= entry && entry <= want[0] + play, "entry {entry}, not {}", want[0]);
    assert!(want[1] - play <= exit && exit <= want[1] + 0.012, "exit {exit}, not {}", want[1]);
}

/// A length that rays see: short by less than a cell, never longer.
fn length(have: f64, want: f64) {
    assert!(have <= want + 1e-3 && have > want - CELL, "{have}, not {want}");
}

/// A cut from x = 8 on to the given end, in material that begins at x = 0, so that the cutter is engaged all
/// around.
fn feed<'a>(id: u32, tool: &'a Profile, y: f64, z: f64, way: f64) -> [SweepItem<'a>; 2] {
    let at = |x: f64| pose([x, y, z], UP);
    [remove(id, tool, at(-9.0), at(8.0)), remove(id + 1, tool, at(8.0), at(8.0 + way))]
}

#[test]
fn a_slot_with_a_flat_cutter_is_full_engagement() {
    for way in [0.35, 2.0, 15.0] {
        let tool = flat(4.0, 30.0);
        let contact = last(&mut block(), &feed(1, &tool, 12.03, 7.0, way));
        angles(&contact, [0.0, PI], 4.0);
        length(contact.axial_depth(), 3.0);
        length(contact.radial_width().unwrap(), 8.0);
        // In front the skin goes with the whole feed.
        assert!((contact.advance - way).abs() < 1e-3 * way, "{} of {way}", contact.advance);
    }
}

#[test]
fn a_shoulder_of_half_the_cutter_is_up_or_climb_milling() {
    let tool = flat(4.0, 30.0);
    // The right half is free: the material lies to the left of a feed along x, where a clockwise tooth enters
    // without a chip.
    let free = |stock: &mut TriDexel, y: f64| {
        let side = flat(6.0, 30.0);
        stock.sweep(&[remove(9, &side, pose([-9.0, y, 7.0], UP), pose([39.0, y, 7.0], UP))]);
    };
    let mut stock = block();
    free(&mut stock, 12.0 - 6.0);
    let up = last(&mut stock, &feed(10, &tool, 12.0, 7.0, 3.0));
    angles(&up, [0.0, FRAC_PI_2], 4.0);
    length(up.radial_width().unwrap(), 4.0);
    let mut stock = block();
    free(&mut stock, 12.0 + 6.0);
    let climb = last(&mut stock, &feed(10, &tool, 12.0, 7.0, 3.0));
    angles(&climb, [FRAC_PI_2, PI], 4.0);
    // For a spindle that turns the other way up and climb change places.
    let [entry, exit] = climb.entry_and_exit(false).unwrap();
    assert!(entry < 0.06 && (exit - FRAC_PI_2).abs() < 0.06, "{entry} {exit}");
    // A shoulder of width b: the last angle is acos(1 - b / r) from the side.
    let (b, r) = (1.5_f64, 4.0_f64);
    let mut stock = block();
    free(&mut stock, 12.0 + r - b - 6.0);
    let narrow = last(&mut stock, &feed(10, &tool, 12.0, 7.0, 3.0));
    angles(&narrow, [0.0, (1.0 - b / r).acos()], r);
    length(narrow.radial_width().unwrap(), b);
    // The thickest chip is where the tooth leaves: feed times the sine of that angle.
    let want = 3.0 * (1.0 - b / r).acos().sin();
    assert!(
        narrow.advance <= want * 1.001 && narrow.advance > want * (1.0 - 2.0 * CELL / b),
        "{} {want}",
        narrow.advance
    );
}

#[test]
fn a_ball_slot_has_the_width_of_its_chord_and_the_chip_of_its_slope() {
    let (r, depth, way) = (4.0_f64, 1.5_f64, 2.0);
    let tool = ball(r, 30.0);
    let contact = last(&mut block(), &feed(1, &tool, 12.03, 10.0 - depth, way));
    angles(&contact, [0.0, PI], (2.0 * r * depth - depth * depth).sqrt());
    length(contact.axial_depth(), depth);
    length(contact.radial_width().unwrap(), 2.0 * (2.0 * r * depth - depth * depth).sqrt());
    // The thickest chip is at the top edge in front: sine of the slope there, cos = (r - depth) / r.
    let slope = (1.0 - ((r - depth) / r).powi(2)).sqrt();
    assert!(contact.advance <= way * slope * 1.001 && contact.advance > way * slope * 0.95, "{}", contact.advance);
}

#[test]
fn a_plunge_has_no_angles_and_a_chip_of_its_whole_feed() {
    for tool in [flat(3.0, 30.0), bull(3.0, 1.0, 30.0)] {
        let mut stock = block();
        let at = |z: f64| pose([12.0, 12.0, z], UP);
        let contact = last(&mut stock, &[remove(1, &tool, at(12.0), at(8.0)), remove(2, &tool, at(8.0), at(7.2))]);
        assert_eq!((contact.radial_width(), contact.entry_and_exit(true)), (None, None));
        assert!((contact.advance - 0.8).abs() < 1e-3);
    }
}

#[test]
fn a_second_pass_finds_nothing_and_a_deeper_one_only_its_own_depth() {
    let tool = flat(4.0, 30.0);
    let mut stock = block();
    stock.sweep(&feed(1, &tool, 12.03, 7.0, 15.0));
    let reports = stock.sweep(&feed(5, &tool, 12.03, 7.0, 15.0));
    assert!(reports.iter().all(|r| r.contact.is_none()));
    let contact = last(&mut stock, &feed(7, &tool, 12.03, 6.0, 10.0));
    length(contact.axial_depth(), 1.0);
    assert!(contact.height[0] > -1e-3 && contact.height[1] < 1.0 + 1e-3);
}

#[test]
fn engagement_turns_with_the_frame_and_does_not_depend_on_threads() {
    // A slot in a block that is turned, cut along the same way: the same engagement but for the places of
    // the rays.
    let tool = bull(4.0, 1.0, 30.0);
    let turn = Pose::from_rpy(Vector::new(3.0, 2.0, 1.0), rad(25.0), rad(-40.0), rad(70.0));
    let bounds = cuboid([-30.0; 3], [40.0, 40.0, 40.0]);
    let cells = 0.5;
    let run = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
            let mut stock = TriDexel::from_box(&bounds, cells, GIB).unwrap();
            stock.watch_engagement(true);
            let at = |x: f64, z: f64| ToolPose::transformed(&pose([x, 0.0, z], UP), &turn);
            // A room for the tool above its way, then the slot below: 2 mm of new depth.
            let room = flat(20.0, 80.0);
            let items = [
                remove(1, &room, at(-30.0, 2.0), at(30.0, 2.0)),
                remove(2, &tool, at(-12.0, 0.0), at(-5.0, 0.0)),
                remove(3, &tool, at(-5.0, 0.0), at(2.0, 0.0)),
            ];
            stock.sweep(&items)
        })
    };
    let reports = run(1);
    assert_eq!(reports, run(3));
    let contact = reports[2].contact.unwrap();
    let near = |have: f64, want: f64, play: f64| assert!((have - want).abs() < play, "{have}, not {want}");
    near(contact.axial_depth(), 2.0, 2.0 * cells);
    near(contact.radial_width().unwrap(), 8.0, cells);
    near(contact.advance, 7.0, 0.05);
    let [entry, exit] = contact.entry_and_exit(true).unwrap();
    near(entry, 0.0, 0.15);
    near(exit, PI, 0.15);
}

#[test]
fn watching_changes_nothing_else() {
    let tool = ball(3.0, 30.0);
    let items = feed(1, &tool, 12.0, 8.0, 5.0);
    let mut with = block();
    let mut without = block();
    without.watch_engagement(false);
    for (a, b) in with.sweep(&items).iter().zip(without.sweep(&items)) {
        assert_eq!(b.contact, None);
        assert_eq!((a.volume_mm3, a.overlap_mm, a.region, a.rays), (b.volume_mm3, b.overlap_mm, b.region, b.rays));
    }
    let points = |s: &TriDexel| s.surface_points().collect::<Vec<_>>();
    assert_eq!(points(&with), points(&without));
}
