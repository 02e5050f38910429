//! The stock in files, in other poses and at earlier moments.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use crate::common::{GIB, Random, ball, bull, cuboid, flat, pose, random_cutter, remove};
use proveout_geom::{Point, Pose, ToolPose, Vector, cylinder_mesh, rad};
use proveout_stock::{HistoryError, StockError, StockFileError, SurfacePoint, SweepItem, TriDexel};

const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn block(cells: impl Into<proveout_stock::Cells>) -> TriDexel {
    TriDexel::from_box(&cuboid([0.0; 3], [20.0, 16.0, 8.0]), cells, GIB).unwrap()
}

fn cut_block(cells: impl Into<proveout_stock::Cells>) -> TriDexel {
    let mut stock = block(cells);
    let (a, b, c) = (ball(2.0, 20.0), bull(3.0, 1.0, 20.0), flat(2.5, 20.0));
    stock.sweep(&[
        remove(1, &a, pose([-3.0, 4.03, 6.07], UP), pose([23.0, 5.0, 5.9], [0.1, 0.0, 1.0])),
        remove(2, &b, pose([5.02, 11.0, 10.0], UP), pose([5.02, 11.0, 5.13], UP)),
        remove(3, &c, pose([15.0, 11.0, 4.11], [0.3, 0.1, 1.0]), pose([16.0, 12.0, 4.11], [0.3, 0.1, 1.0])),
    ]);
    stock
}

/// Everything that can be seen of a stock.
fn seen(stock: &TriDexel) -> (Vec<SurfacePoint>, [u64; 3], [usize; 3], [f64; 3]) {
    let numbers = [stock.volume(), stock.initial_volume(), stock.sweep_bound_mm()].map(f64::to_bits);
    (stock.surface_points().collect(), numbers, stock.counts(), stock.cells_mm())
}

fn saved(stock: &TriDexel) -> Vec<u8> {
    let mut bytes = Vec::new();
    stock.save(&mut bytes).unwrap();
    bytes
}

fn loaded(bytes: &[u8]) -> Result<TriDexel, StockFileError> {
    TriDexel::load(&mut &bytes[..], GIB)
}

#[test]
fn a_saved_stock_comes_back_bit_for_bit() {
    let bar = TriDexel::from_cylinder(&Point::new(1.0, 2.0, 3.0), &Vector::new(0.2, -0.4, 1.0), 6.0, 12.0, 0.3, GIB);
    let mesh = TriDexel::from_mesh(&cylinder_mesh(5.0, 0.0, 9.0, 96), [0.3, 0.2, 0.45], GIB);
    for stock in [cut_block(0.2), cut_block([0.5, 0.2, 0.3]), bar.unwrap(), mesh.unwrap()] {
        let bytes = saved(&stock);
        let back = loaded(&bytes).unwrap();
        assert_eq!(seen(&back), seen(&stock));
        assert_eq!(saved(&back), bytes, "same stock, same bytes");
        // Every end of the block is found by what changed against its neighbor.
        assert!(bytes.len() < 33 * stock.surface_points().count() / 2);
        let mut both = [stock, back];
        let tool = flat(2.0, 20.0);
        for s in &mut both {
            s.sweep(&[remove(9, &tool, pose([0.0, 7.0, 3.0], UP), pose([20.0, 8.0, 3.0], UP))]);
        }
        assert_eq!(seen(&both[0]), seen(&both[1]), "and it is cut alike");
    }
}

#[test]
fn a_damaged_file_is_refused_whatever_the_damage() {
    let mut stock = block(2.0);
    stock.keep_history();
    let tool = ball(2.0, 20.0);
    stock.sweep(&[remove(1, &tool, pose([-3.0, 4.03, 6.07], UP), pose([23.0, 5.0, 5.9], UP))]);
    stock.note_end(1, 2.5);
    let good = saved(&stock);
    loaded(&good).unwrap();
    for cut in 0..good.len() {
        assert!(loaded(&good[..cut]).is_err(), "cut off after {cut} bytes");
    }
    let mut longer = good.clone();
    longer.push(0);
    assert!(matches!(loaded(&longer), Err(StockFileError::Length { .. })));
    for at in 0..good.len() {
        for bit in [1, 128] {
            let mut bad = good.clone();
            bad[at] ^= bit;
            assert!(loaded(&bad).is_err(), "byte {at} changed");
        }
    }
    assert!(matches!(loaded(b"solid part\n"), Err(StockFileError::NotStock)));
    assert!(matches!(loaded(&[]), Err(StockFileError::NotStock)));
    let mut newer = good.clone();
    newer[8] = 9;
    let text = loaded(&newer).unwrap_err().to_string();
    assert!(text.contains("version 9") && text.contains("version 1"), "{text}");
}

/// The header with another number, and the digest that belongs to it.
fn announced(good: &[u8], at: usize, number: u64) -> Vec<u8> {
    let mut bad = good.to_vec();
    bad[at..at + 8].copy_from_slice(&number.to_le_bytes());
    let digest =
        bad[..168].iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    bad[168..176].copy_from_slice(&digest.to_le_bytes());
    bad
}

#[test]
fn absurd_numbers_with_a_right_digest_are_refused_before_memory_is_taken() {
    let good = saved(&cut_block(1.0));
    for number in [0, 1, 1 << 20, 1 << 40, u64::MAX, f64::NAN.to_bits(), 1e-9_f64.to_bits(), 1e300_f64.to_bits()] {
        for at in (16..168).step_by(8) {
            // Bounds of the sweep and of re-gridding may be any number; all others hang together.
            // A lower corner that moves by less than a lattice step leaves the cells as they are.
            let same = (40..64).contains(&at) && f64::from_bits(number).abs() < 1e-8;
            let free = matches!(at, 88..=112) || good[at..at + 8] == number.to_le_bytes() || same;
            assert!(free || loaded(&announced(&good, at, number)).is_err(), "{number} at {at}");
        }
    }
    // More cells than the memory allowed: the cell that fits is named.
    let fine = announced(&good, 16, 1e-6_f64.to_bits());
    assert!(matches!(loaded(&fine), Err(StockFileError::Stock(StockError::Memory { .. }))));
}

#[test]
fn contents_that_are_no_stock_are_refused() {
    let good = saved(&cut_block(1.0));
    let digest =
        |b: &[u8]| b.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    let mut refused = 0;
    let mut random = Random(3);
    for _ in 0..2000 {
        let mut bad = good.clone();
        let at = 176 + random.pick(good.len() - 176);
        bad[at] = random.pick(256) as u8;
        let content = digest(&bad[176..]);
        let bad = announced(&bad, 160, content);
        // With a right digest some changes are another stock, as a height a little higher; none may panic.
        match loaded(&bad) {
            Ok(stock) => assert!(stock.surface_points().all(|p| p.point.iter().all(|x| x.is_finite()))),
            Err(e) => {
                assert!(!e.to_string().is_empty());
                refused += 1;
            }
        }
    }
    assert!(refused > 300, "{refused}");
}

/// Moves of several tools over the block, with two bodies in some of them.
fn program(random: &mut Random, moves: u32) -> Vec<(u32, usize, ToolPose, ToolPose)> {
    let mut at = pose([1.0, 1.0, 6.0], UP);
    (0..moves)
        .flat_map(|k| {
            let tip = [random.range(0.0, 20.0), random.range(0.0, 16.0), random.range(4.0, 8.0)];
            let next = ToolPose {
                tip: at.tip + (Point::from(tip) - at.tip) * 0.4,
                axis: (at.axis + random.direction() * 0.05).normalize(),
            };
            let tool = random.pick(3);
            let from = std::mem::replace(&mut at, next);
            let item = (k, tool, from, next);
            if k % 4 == 1 { vec![item, (k, (tool + 1) % 3, from, next)] } else { vec![item] }
        })
        .collect()
}

#[test]
fn the_stock_of_an_earlier_moment_is_that_of_a_run_stopped_there() {
    let tools = [ball(2.0, 20.0), bull(3.0, 1.0, 20.0), flat(1.5, 20.0)];
    let mut random = Random(11);
    let program = program(&mut random, 60);
    let items: Vec<SweepItem<'_>> = program.iter().map(|p| remove(p.0, &tools[p.1], p.2, p.3)).collect();
    for batch in [1, 7, 200] {
        let mut whole = block([0.4, 0.25, 0.3]);
        whole.keep_history();
        for part in items.chunks(batch) {
            whole.sweep(part);
        }
        for k in 0..60 {
            whole.note_end(k, f64::from(k) + 1.0);
        }
        let points = |s: &TriDexel| s.surface_points().collect::<Vec<_>>();
        for stop in [0, 1, 17, 18, 40, 59] {
            let mut stopped = block([0.4, 0.25, 0.3]);
            let until: Vec<SweepItem<'_>> = items.iter().filter(|i| i.id <= stop).copied().collect();
            stopped.sweep(&until);
            let back = whole.after(stop).unwrap();
            assert_eq!(points(&back), points(&stopped), "after {stop}");
            assert_eq!(back.volume().to_bits(), stopped.volume().to_bits());
            let (timed, move_id) = whole.at_time(f64::from(stop) + 1.4).unwrap();
            assert_eq!((points(&timed), move_id), (points(&back), stop));
        }
        assert_eq!(points(&whole.before_all().unwrap()), points(&block([0.4, 0.25, 0.3])));
        // The history goes through a file.
        let file = loaded(&saved(&whole)).unwrap();
        assert_eq!(points(&file.after(17).unwrap()), points(&whole.after(17).unwrap()));
        assert_eq!(file.history_changes(), whole.history_changes());
        assert!(matches!(file.at_time(0.5), Err(HistoryError::Time { .. })));
        let per_change = whole.history_bytes() as f64 / whole.history_changes() as f64;
        println!("{} changes, {per_change:.1} bytes each with spare room", whole.history_changes());
    }
    assert_eq!(block(1.0).after(3).unwrap_err(), HistoryError::Missing);
    let mut mixed = block(1.0);
    mixed.keep_history();
    let deeper = |id: u32, z: f64| remove(id, &tools[2], pose([2.0, 8.0, z], UP), pose([18.0, 8.0, z], UP));
    mixed.sweep(&[deeper(9, 7.0), deeper(2, 5.0)]);
    let order = mixed.after(5);
    assert!(matches!(order, Err(HistoryError::Order { id: 2, before: 9 })), "tiles that both have cut tell: {order:?}");
}

#[test]
fn keeping_the_history_changes_no_result() {
    let mut random = Random(4);
    let (_, tool) = random_cutter(&mut random);
    let items = [remove(1, &tool, pose([2.0, 3.0, 5.0], UP), pose([15.0, 9.0, 4.0], [0.05, 0.0, 1.0]))];
    let (mut with, mut without) = (block(0.3), block(0.3));
    with.keep_history();
    assert_eq!(with.sweep(&items), without.sweep(&items));
    assert_eq!(seen(&with), seen(&without));
}

#[test]
fn a_stock_turned_by_right_angles_loses_nothing() {
    let stock = cut_block([0.5, 0.2, 0.3]);
    let turns = [(0.0, 0.0, 0.0), (180.0, 0.0, 0.0), (90.0, 0.0, 0.0), (0.0, -90.0, 180.0), (90.0, 0.0, 90.0)];
    for (x, y, z) in turns {
        let new_from_old = Pose::from_rpy(Vector::new(3.0, -7.0, 11.5), rad(x), rad(y), rad(z));
        let size = new_from_old.vector(&Vector::from(stock.cells_mm())).map(f64::abs);
        let new = stock.regridded(&new_from_old, <[f64; 3]>::from(size), GIB).unwrap();
        assert_eq!(new.regrid_bound(), None);
        assert_eq!(new.sweep_bound_mm(), stock.sweep_bound_mm());
        assert!((new.volume() - stock.volume()).abs() < 1e-9 * stock.volume());
        let key = |p: Point| [0, 1, 2].map(|k| (p[k] * 1e6).round() as i64);
        let mut want: Vec<([i64; 3], Vector)> = stock
            .surface_points()
            .map(|p| (key(new_from_old.point(&p.point)), new_from_old.vector(&p.normal.unwrap())))
            .collect();
        let mut have: Vec<([i64; 3], Vector)> = new
            .surface_points()
            .map(|p| {
                assert_eq!(p.made_by, None, "raw stock");
                (key(p.point), p.normal.unwrap())
            })
            .collect();
        want.sort_by(|a, b| a.partial_cmp(b).unwrap());
        have.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(want.len(), have.len());
        for (w, h) in want.iter().zip(&have) {
            assert!(w.0 == h.0 && (w.1 - h.1).norm() < 2e-4, "{w:?} {h:?}");
        }
    }
}

/// A block with a ball slot along x, as distances: positive outside of the material.
fn slotted_block(p: &Point, size: [f64; 3], y: f64, z: f64, r: f64) -> (f64, f64) {
    let faces = (0..3).map(|k| (p[k] - size[k]).max(-p[k])).fold(f64::NEG_INFINITY, f64::max);
    let slot = r - (p.y - y).hypot((p.z - z).min(0.0));
    // Distance from the surface of the part, and how near the second surface is: an edge.
    (faces.max(slot), faces.min(slot))
}

#[test]
fn a_block_with_a_ball_slot_in_a_new_pose_stays_within_its_bound() {
    let size = [20.0, 16.0, 8.0];
    let (y, z, r) = (7.03, 6.51, 3.0);
    let tool = ball(r, 30.0);
    for (cell, new_cell, angles) in [
        (0.2, 0.2, [20.0, 35.0, 50.0]),
        (0.25, 0.15, [0.0, 0.0, 0.0]),
        (0.3, 0.4, [0.0, 0.0, 30.0]),
        (0.2, 0.3, [-70.0, 5.0, 0.1]),
    ] {
        let mut stock = TriDexel::from_box(&cuboid([0.0; 3], size), cell, GIB).unwrap();
        stock.sweep(&[remove(1, &tool, pose([-9.0, y, z - r], UP), pose([29.0, y, z - r], UP))]);
        let [a, b, c] = angles.map(rad);
        let new_from_old = Pose::from_rpy(Vector::new(1.0, 2.0, 3.0), a, b, c);
        let new = stock.regridded(&new_from_old, new_cell, GIB).unwrap();
        let bound = new.regrid_bound().unwrap();
        let back = new_from_old.inverse();
        let (mut smooth, mut edge, mut count) = (0.0_f64, 0.0_f64, 0);
        for p in new.surface_points() {
            let x = back.point(&p.point);
            // Distance by the largest of the parts is exact away from edges, and a lower bound of the error
            // at them.
            let (off, second) = slotted_block(&x, size, y, z, r);
            // Faces of the box meet along edges, too.
            let near_face = (0..3).filter(|&k| x[k].abs() < 2.0 * cell || (x[k] - size[k]).abs() < 2.0 * cell).count();
            let at_edge = near_face >= 2
                || near_face >= 1 && (r - (x.y - y).hypot(x.z - z)).abs() < 4.0 * cell && second > -4.0 * cell;
            if at_edge {
                edge = edge.max(off.abs());
            } else {
                smooth = smooth.max(off.abs());
                count += 1;
            }
        }
        println!(
            "{cell} to {new_cell}: {smooth:.6} of {:.6} on faces, {edge:.6} of {:.6} at edges",
            bound.surface_mm, bound.edge_mm
        );
        assert!(count > 3000 && new.surface_points().all(|p| p.made_by.is_none()));
        assert!(smooth <= bound.surface_mm + new.sweep_bound_mm(), "{smooth} {bound:?}");
        assert!(edge <= bound.edge_mm + bound.surface_mm, "{edge} {bound:?}");
        // The bound says something: a facet of the slot is off by cell^2 / 8 r.
        assert!(bound.surface_mm < cell * cell / r, "{bound:?}");
        // Nothing is missing: a ray represents the area of its cell, of which the last may reach past a face.
        assert!((new.volume() / stock.volume() - 1.0).abs() < 0.015);
    }
}

#[test]
fn a_stock_in_no_pose_or_with_nothing_left_is_refused() {
    let stock = cut_block(0.5);
    let bad = Pose::from_translation(Vector::new(f64::NAN, 0.0, 0.0));
    assert!(matches!(stock.regridded(&bad, 0.5, GIB), Err(StockError::Degenerate { .. })));
    assert!(matches!(stock.regridded(&Pose::identity(), 0.001, GIB), Err(StockError::Memory { .. })));
    assert!(matches!(stock.regridded(&Pose::identity(), -1.0, GIB), Err(StockError::Cell { .. })));
    let mut gone = block(1.0);
    let tool = flat(60.0, 60.0);
    gone.sweep(&[remove(1, &tool, pose([10.0, 8.0, -1.0], UP), pose([10.5, 8.0, -1.0], UP))]);
    assert!(matches!(gone.regridded(&Pose::identity(), 0.7, GIB), Err(StockError::Degenerate { .. })));
}
