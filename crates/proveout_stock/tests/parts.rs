//! Parts of the stock against what is cut apart by construction.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

mod common;

use std::f64::consts::{PI, TAU};

use common::{GIB, cuboid, flat, pose, remove};
use proveout_stock::TriDexel;

const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// A slot along y through a block of 20 x 10 x 6 mm, at x = 12.5, down to `z`.
fn slotted(radius: f64, z: f64, y_end: f64) -> TriDexel {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [20.0, 10.0, 6.0]), 0.5, GIB).unwrap();
    let tool = flat(radius, 30.0);
    stock.sweep(&[remove(7, &tool, pose([12.5, -2.0, z], UP), pose([12.5, y_end, z], UP))]);
    stock
}

#[test]
fn a_block_is_one_part_until_it_is_cut_through() {
    let whole = TriDexel::from_box(&cuboid([0.0; 3], [20.0, 10.0, 6.0]), 0.5, GIB).unwrap().parts();
    assert_eq!((whole.len(), whole[0].last_made_by), (1, None));
    assert!((whole[0].volume_mm3 - 1200.0).abs() < 1e-9);
    assert_eq!(slotted(1.0, 0.5, 12.0).parts().len(), 1, "a floor is left");
    assert_eq!(slotted(1.0, -1.0, 8.0).parts().len(), 1, "a wall is left");
    let two = slotted(1.0, -1.0, 12.0).parts();
    assert_eq!(two.len(), 2);
    // Columns of 0.5 mm have their centers at odd quarters: the slot from 11.5 to 13.5 takes whole ones.
    for (part, width, x) in [(&two[0], 11.5, 5.75), (&two[1], 6.5, 16.75)] {
        assert!((part.volume_mm3 - width * 60.0).abs() < 1e-6, "{part:?}");
        assert!((part.center.x - x).abs() < 1e-6 && (part.center.y - 5.0).abs() < 1e-9);
        assert!((part.bounds.size().x - width).abs() < 1e-9 && (part.bounds.size().z - 6.0).abs() < 1e-6);
    }
}

#[test]
fn a_slot_narrower_than_a_cell_cuts_where_rays_across_see_it() {
    // 0.2 mm wide between the rays at 12.25 and 12.75 mm: no ray along z meets it.
    let parts = slotted(0.1, -1.0, 12.0).parts();
    assert_eq!(parts.len(), 2);
    assert!((parts[0].volume_mm3 - 12.5 * 60.0).abs() < 1e-6, "{parts:?}");
    assert_eq!(slotted(0.1, 0.9, 12.0).parts().len(), 1, "rows under the floor hold");
}

/// A plug of radius 6 mm cut out of a plate of 4 mm by a flat tool of radius 1 mm, but for the angle `left`.
fn plug(left: f64) -> TriDexel {
    let mut stock = TriDexel::from_box(&cuboid([-10.0, -10.0, 0.0], [10.0, 10.0, 4.0]), 0.2, GIB).unwrap();
    let tool = flat(1.0, 30.0);
    let n = 180;
    let at = |k: u32| {
        let a = (TAU - left) * f64::from(k) / f64::from(n);
        pose([7.0 * a.cos(), 7.0 * a.sin(), -1.0], UP)
    };
    let moves: Vec<_> = (0..n).map(|k| remove(k, &tool, at(k), at(k + 1))).collect();
    stock.sweep(&moves);
    stock
}

#[test]
fn a_plug_is_loose_when_its_last_tab_is_cut() {
    // A tab of 0.7 rad less the width of the tool at both ends: 7 * 0.7 - 2 = 2.9 mm.
    assert_eq!(plug(0.7).parts().len(), 1);
    let parts = plug(0.0).parts();
    assert_eq!(parts.len(), 2);
    let loose = &parts[1];
    // Rays count a disk by its area within the rim's cells.
    assert!((loose.volume_mm3 / (PI * 36.0 * 4.0) - 1.0).abs() < 0.01, "{loose:?}");
    assert!(loose.center.coords.xy().norm() < 0.02 && (loose.center.z - 2.0).abs() < 1e-6);
    assert_eq!(loose.last_made_by, Some(179), "the last move of the round made its wall");
}

#[test]
fn nothing_is_no_part() {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [2.0, 2.0, 2.0]), 0.5, GIB).unwrap();
    let tool = flat(5.0, 30.0);
    stock.sweep(&[remove(0, &tool, pose([-9.0, 1.0, -1.0], UP), pose([9.0, 1.0, -1.0], UP))]);
    assert!(stock.parts().is_empty());
}
