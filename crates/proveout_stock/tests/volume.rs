//! One volume: what cuts take and what they leave make up the stock, and plain faces are exact whatever the
//! cells.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use crate::common::{GIB, Random, ball, cuboid, flat, pose, random_cutter, remove};
use proveout_geom::{Point, Pose, Vector};
use proveout_stock::{SweepItem, TriDexel, Volume};

const SIZE: [f64; 3] = [100.0, 50.0, 20.0];

/// Axis `a` of the slab along z of the job, so that it lies across x, y or z.
fn turned(axis: usize, p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| p[(i + 2 - axis + 3) % 3])
}

/// A block whose edge across `axis` is the third of `SIZE`.
fn block(axis: usize, cells: [f64; 3]) -> TriDexel {
    TriDexel::from_box(&cuboid([0.0; 3], turned(axis, SIZE)), cells, GIB).unwrap()
}

/// Face mills a slab off, in passes side by side.
fn faced(stock: &mut TriDexel, axis: usize, thickness: f64) {
    let tool = flat(20.0, 60.0);
    let up = turned(axis, [0.0, 0.0, 1.0]);
    for (id, y) in [5.0, 28.0, 51.0].into_iter().enumerate() {
        let at = |x: f64| pose(turned(axis, [x, y, SIZE[2] - thickness]), up);
        stock.sweep(&[remove(id as u32, &tool, at(-30.0), at(130.0))]);
    }
}

/// 100 x 50 x 5 mm are 25000 mm³ across any axis, at cells that fit into the stock and at others, cubes or
/// not.
#[test]
fn a_plain_slab_has_its_volume_at_any_cells() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let cubes = [0.3, 0.4, 0.5, 0.7, 1.0, 1.3, 2.0, 3.0].map(|c| [c; 3]);
    let any: Vec<[f64; 3]> = (0..12).map(|_| [0; 3].map(|_| random.range(0.6, 3.0))).collect();
    for cells in cubes.into_iter().chain(any) {
        for axis in 0..3 {
            for thickness in [5.0, 0.05, 0.93, 7.77] {
                let mut stock = block(axis, cells);
                let mut volume = Volume::of(&stock);
                assert!((volume.total() - 1e5).abs() < 1e-6, "{cells:?}: {}", volume.total());
                faced(&mut stock, axis, thickness);
                let (gone, exact) = (volume.follow(&stock), 5000.0 * thickness);
                assert!((gone - exact).abs() < 2e-3, "{axis} {thickness} {cells:?}: {gone} of {exact}");
                assert!((volume.total() + gone - 1e5).abs() < 1e-6);
                assert!((stock.exact_volume() - volume.total()).abs() < 1e-6);
            }
        }
    }
}

/// Steps, shoulders and slots along the axes, in boxes at any place: out by less than a cell squared along
/// each edge.
#[test]
fn faces_along_several_axes_are_out_by_their_edges_only() {
    let mut random = Random(7);
    for case in 0..60 {
        let cell = random.range(0.3, 1.5);
        let mut stock = TriDexel::from_box(&cuboid([0.0; 3], SIZE), cell, GIB).unwrap();
        let mut volume = Volume::of(&stock);
        // A slot through the block along x, by a tool that leaves square corners: one wider than the slot is
        // deep, from the side.
        let (width, depth) = (random.range(3.0, 30.0), random.range(1.0, 15.0));
        let tool = flat(200.0, width);
        let y = random.range(0.0, SIZE[1] - width);
        let at = |x: f64| pose([x, y, SIZE[2] - depth + 200.0], [0.0, 1.0, 0.0]);
        stock.sweep(&[remove(0, &tool, at(-300.0), at(400.0))]);
        let (gone, exact) = (volume.follow(&stock), width * depth * SIZE[0]);
        assert!((gone - exact).abs() < 2.0 * SIZE[0] * 0.25 * cell * cell + 0.05, "{case} {cell}: {gone} of {exact}");
    }
}

/// Random cuts with random cutters: what each took adds up to what is missing, at any number of threads;
/// nothing is left of nothing.
#[test]
fn cuts_add_up() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let tools: Vec<_> = (0..6).map(|_| random_cutter(&mut random).1).collect();
    let ends: Vec<[Vector; 4]> = (0..40)
        .map(|_| {
            let place = |r: &mut Random| Vector::new(r.range(-5.0, 25.0), r.range(-5.0, 21.0), r.range(-2.0, 10.0));
            [place(&mut random), place(&mut random), random.direction(), random.direction()]
        })
        .collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [20.0, 16.0, 8.0]), 0.33, GIB).unwrap();
            let mut volume = Volume::of(&stock);
            let before = volume.total();
            let mut taken = Vec::new();
            for (k, [from, to, a, b]) in ends.iter().enumerate() {
                let at = |p: &Vector, axis: &Vector| pose((*p).into(), (*axis).into());
                let items: [SweepItem<'_>; 1] = [remove(k as u32, &tools[k % 6], at(from, a), at(to, b))];
                stock.sweep(&items);
                taken.push(volume.follow(&stock));
            }
            let sum: f64 = taken.iter().sum();
            assert!((before - sum - stock.exact_volume()).abs() < 1e-9 * before);
            taken
        })
    };
    let one = run(1);
    assert!(one.iter().sum::<f64>() > 200.0);
    assert_eq!(one, run(4));
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [20.0, 16.0, 8.0]), 0.33, GIB).unwrap();
    let mut volume = Volume::of(&stock);
    let all = flat(60.0, 60.0);
    stock.sweep(&[remove(0, &all, pose([10.0, 8.0, -5.0], [0.0, 0.0, 1.0]), pose([11.0, 8.0, -5.0], [0.0, 0.0, 1.0]))]);
    assert!((volume.follow(&stock) - 2560.0).abs() < 1e-9 && volume.total().abs() < 1e-9);
}

/// Round and slanted cuts come near their closed forms, no worse than a few cells of their skin.
#[test]
fn round_cuts_come_near_their_closed_forms() {
    for cell in [0.25, 0.4, 0.6] {
        let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [30.0, 24.0, 16.0]), cell, GIB).unwrap();
        let mut volume = Volume::of(&stock);
        let tool = ball(4.0, 40.0);
        stock.sweep(&[remove(
            1,
            &tool,
            pose([-9.0, 12.1, 12.3], [0.0, 0.0, 1.0]),
            pose([39.0, 12.1, 12.3], [0.0, 0.0, 1.0]),
        )]);
        // Segment of a circle of height 3.7 along the block.
        let (r, h) = (4.0_f64, 3.7_f64);
        let area = r * r * ((r - h) / r).acos() - (r - h) * (2.0 * r * h - h * h).sqrt();
        let gone = volume.follow(&stock);
        assert!((gone / (30.0 * area) - 1.0).abs() < 0.02, "{cell}: {gone} of {}", 30.0 * area);
    }
    let turn = Pose::from_axis_angle(&Vector::y(), 0.3);
    let axis = turn.vector(&Vector::z());
    let bar = TriDexel::from_cylinder(&Point::new(3.0, 2.0, 1.0), &axis, 8.0, 30.0, 0.4, GIB).unwrap();
    let exact = std::f64::consts::PI * 64.0 * 30.0;
    assert!((bar.exact_volume() / exact - 1.0).abs() < 0.005, "{} of {exact}", bar.exact_volume());
}
