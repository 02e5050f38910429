//! Parts of the stock against what is cut apart by construction.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use std::f64::consts::{PI, TAU};

use crate::common::{GIB, cuboid, flat, pose, remove};
use proveout_stock::{Cells, Coherence, Interval, TriDexel};

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
fn what_is_kept_between_looks_counts_the_parts_after_each_cut() {
    // Cut by cut: full slots, one that only rays across see, a shelf, and parts that are taken out and put
    // back. 43 by 37 columns: the last tiles are not full.
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [21.5, 18.5, 6.0]), 0.5, GIB).unwrap();
    let (thick, thin) = (flat(0.8, 30.0), flat(0.1, 30.0));
    let mut kept = Coherence::default();
    assert_eq!(kept.parts(&stock), 1);
    let mut counts = Vec::new();
    let cuts = [
        (&thick, [5.3, -2.0, -1.0], [5.3, 9.0, -1.0], UP),
        (&thick, [5.3, 9.0, -1.0], [5.3, 21.0, -1.0], UP),
        (&thin, [-2.0, 8.0, -1.0], [9.0, 8.0, -1.0], UP),
        (&thin, [9.0, 8.0, -1.0], [24.0, 8.0, -1.0], UP),
        (&thick, [-3.0, 13.0, 3.0], [25.0, 13.0, 3.0], [0.0, 1.0, 0.0]),
        (&thick, [12.0, -2.0, -1.0], [17.0, 21.0, -1.0], UP),
        (&thin, [-2.0, 3.0, 0.9], [24.0, 3.0, 0.9], UP),
        (&thin, [-2.0, 3.0, -1.0], [24.0, 3.0, -1.0], UP),
    ];
    for (k, (tool, from, to, axis)) in cuts.into_iter().enumerate() {
        stock.sweep(&[remove(k as u32, tool, pose(from, axis), pose(to, axis))]);
        let parts = stock.parts();
        assert_eq!(kept.parts(&stock), parts.len(), "after cut {k}");
        assert_eq!(kept.parts(&stock), Coherence::default().parts(&stock), "after cut {k}");
        counts.push(parts.len());
        if let Some(smallest) = parts.last().filter(|_| parts.len() > 1) {
            let taken = stock.take_part(smallest, k as u32, 0).unwrap();
            assert_eq!(kept.parts(&stock), parts.len() - 1, "without a part after cut {k}");
            stock.put_back(taken);
            assert_eq!(kept.parts(&stock), parts.len(), "with it again after cut {k}");
        }
    }
    // By construction: a slot half through, through, one thinner than a cell through its left half, and so
    // on.
    assert_eq!(counts[..4], [1, 2, 3, 4]);
    assert!(counts[7] > counts[6] && counts[6] == counts[5], "a floor holds, then it is cut: {counts:?}");
    // Of another stock nothing is kept.
    let small = TriDexel::from_box(&cuboid([0.0; 3], [9.0, 9.0, 6.0]), 0.5, GIB).unwrap();
    assert_eq!(kept.parts(&small), 1);
}

#[test]
fn nothing_is_no_part() {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [2.0, 2.0, 2.0]), 0.5, GIB).unwrap();
    let tool = flat(5.0, 30.0);
    stock.sweep(&[remove(0, &tool, pose([-9.0, 1.0, -1.0], UP), pose([9.0, 1.0, -1.0], UP))]);
    assert!(stock.parts().is_empty());
    assert_eq!(Coherence::default().parts(&stock), 0);
}

/// All intervals of all rays, set by set.
fn rays(stock: &TriDexel) -> Vec<Vec<Interval>> {
    let n = stock.counts();
    let set = |a: usize| {
        let [u, v] = [n[(a + 1) % 3], n[(a + 2) % 3]];
        (0..u * v).map(move |k| stock.ray_intervals(a, k % u, k / u))
    };
    (0..3).flat_map(set).collect()
}

/// A plate that is cut into pieces by slots in several directions, some of them tilted; the cells are no
/// cubes.
fn pieces() -> (TriDexel, u32) {
    let bounds = cuboid([0.0; 3], [30.0, 24.0, 6.0]);
    let mut stock = TriDexel::from_box(&bounds, Cells([0.5, 0.4, 0.3]), GIB).unwrap();
    stock.keep_history();
    let tool = flat(0.8, 30.0);
    let tilted = |c: f64, s: f64| [s, 0.0, c];
    let moves = [
        remove(0, &tool, pose([8.0, -3.0, -1.0], UP), pose([8.0, 27.0, -1.0], UP)),
        remove(1, &tool, pose([20.0, -3.0, -1.0], UP), pose([22.0, 27.0, -1.0], UP)),
        remove(2, &tool, pose([-3.0, 11.0, -1.0], UP), pose([33.0, 13.0, -1.0], UP)),
        remove(3, &tool, pose([13.0, -3.0, -1.0], tilted(0.8, 0.6)), pose([13.0, 27.0, -1.0], tilted(0.8, 0.6))),
        // A shelf: material that hangs over.
        remove(4, &tool, pose([-3.0, 18.0, 3.0], [0.0, 1.0, 0.0]), pose([33.0, 18.0, 3.0], [0.0, 1.0, 0.0])),
    ];
    stock.sweep(&moves);
    (stock, 4)
}

#[test]
fn a_part_is_taken_without_touching_the_rest_and_put_back_bit_for_bit() {
    let (mut stock, last) = pieces();
    let (whole, parts) = (rays(&stock), stock.parts());
    assert!(parts.len() >= 6, "{}", parts.len());
    assert_eq!(stock.parts_apart(0.0), parts[1..]);
    let middle = parts[parts.len() / 2].volume_mm3;
    let large: Vec<_> = parts[1..].iter().filter(|p| p.volume_mm3 >= middle).cloned().collect();
    assert_eq!(stock.parts_apart(middle), large);
    assert!(stock.parts_apart(1e9).is_empty());
    let mut left = parts.len();
    for part in parts.iter().rev() {
        let before = rays(&stock);
        let volumes = [0, 1, 2].map(|a| stock.volume_along(a));
        let taken = stock.take_part(part, last, 3).unwrap();
        left -= 1;
        assert_eq!(stock.parts().len(), left);
        // Every interval is in one of the two, as it was.
        let (rest, n) = (rays(&stock), stock.counts());
        let alone = taken.stock();
        let mut gone = 0;
        for (k, (was, is)) in before.iter().zip(&rest).enumerate() {
            assert!(is.iter().all(|i| was.contains(i)), "ray {k}: {was:?} {is:?}");
            gone += was.len() - is.len();
        }
        assert!(gone > 10 && n == stock.counts());
        for (a, volume) in volumes.into_iter().enumerate() {
            let both = stock.volume_along(a) + alone.volume_along(a);
            assert!((both - volume).abs() < 1e-9 * volume, "{a}: {both} {volume}");
        }
        assert!((alone.volume_along(2) - part.volume_mm3).abs() < 1e-9 * part.volume_mm3);
        assert!(part.lies_in(alone) && alone.parts().len() == 1, "{} parts", alone.parts().len());
        // The part's surface is closed and holds its volume.
        let mesh = alone.surface().mesh;
        assert!((mesh.volume() / part.volume_mm3 - 1.0).abs() < 0.05, "{} {}", mesh.volume(), part.volume_mm3);
        // Back: the same stock, with the same history.
        let out = rays(&stock);
        stock.put_back(taken);
        assert_eq!(rays(&stock), before);
        assert_eq!(rays(&stock.after(last).unwrap()), before);
        stock.take_part(part, last, 3).unwrap();
        assert_eq!(rays(&stock), out);
    }
    assert!(stock.is_empty());
    // The history knows the way: before the last item nothing was taken.
    assert_eq!(rays(&stock.after(last).unwrap()), rays(&stock));
    let earlier = rays(&stock.after(last - 1).unwrap());
    assert!(earlier.iter().flatten().count() > 0);
    let raw = rays(&stock.before_all().unwrap());
    assert!(raw.iter().all(|r| r.len() == 1));
    assert_ne!(whole, earlier);
}

#[test]
fn moments_are_those_of_a_box_and_of_a_cylinder() {
    let bounds = cuboid([1.0, -4.0, 100.0], [11.0, 2.0, 104.0]);
    let m = TriDexel::from_box(&bounds, 0.5, GIB).unwrap().moments().unwrap();
    let size = bounds.size();
    assert!((m.volume - size.product()).abs() < 1e-9 && (m.center - bounds.center()).norm() < 1e-9);
    for c in 0..3 {
        let (u, v) = (size[(c + 1) % 3], size[(c + 2) % 3]);
        let want = m.volume * (u * u + v * v) / 12.0;
        assert!((m.inertia[(c, c)] / want - 1.0).abs() < 1e-9, "{c}: {} {want}", m.inertia[(c, c)]);
        assert!(m.inertia[(c, (c + 1) % 3)].abs() < 1e-9 * want);
    }
    let (r, h) = (6.0, 4.0);
    let stock = plug(0.0);
    let part = stock.parts()[1].clone();
    let alone = stock.clone().take_part(&part, 179, 179).unwrap();
    let m = alone.stock().moments().unwrap();
    assert!((m.volume / (PI * r * r * h) - 1.0).abs() < 0.005, "{}", m.volume);
    assert!((m.inertia[(2, 2)] / (0.5 * m.volume * r * r) - 1.0).abs() < 0.01);
    let across = m.volume * (3.0 * r * r + h * h) / 12.0;
    assert!((m.inertia[(0, 0)] / across - 1.0).abs() < 0.01 && (m.inertia[(1, 1)] / across - 1.0).abs() < 0.01);
}
