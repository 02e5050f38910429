//! The sweep against dense stamping: every end that it makes lies on the swept surface, and what it removes
//! and leaves is in and out of the swept body, to one micrometer in the direction of the normal.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use crate::common::{GIB, KINDS, Random, oracle, pose, random_cutter, remove};
use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_stock::{SweepMotion, TriDexel};
use proveout_tool::Profile;
use rayon::prelude::*;

/// The promise of the crate, mm.
const BOUND: f64 = 1e-3;

#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    rays: usize,
    /// Distance of an end from the swept surface.
    end: f64,
    /// Depth of material left inside, and height of material removed outside.
    left: f64,
    gone: f64,
    bound: f64,
    /// The largest of the three beyond the bound that the stock states for the same motion.
    beyond: f64,
}

/// The oracle finds the nearest time to 1e-9 of the motion, and distances to rounding, mm.
const ORACLE_ERROR: f64 = 1e-8;

fn random_motion(random: &mut Random, length: f64) -> SweepMotion {
    let axis = match random.pick(3) {
        0 => Vector::z(),
        1 => (Vector::z() + random.direction() * 0.4).normalize(),
        _ => random.direction(),
    };
    let travel = match random.pick(6) {
        0 => axis * length,                                         // plunge
        1 => axis * -length + random.direction() * (0.01 * length), // nearly axial
        2 => axis.cross(&random.direction()).normalize() * length,  // across
        3 => Vector::zeros(),                                       // turn on the spot
        _ => random.direction() * length,
    };
    let turn = match random.pick(4) {
        0 => 0.0,
        1 => 0.002 * length,
        2 => 0.0873 * length, // 5 degrees in 1 mm
        _ => random.range(0.0, 0.05),
    };
    let aside = axis.cross(&random.direction()).normalize();
    let to_axis = (axis * turn.cos() + aside * turn.sin()).normalize();
    let tip = Point::new(0.01, -0.02, 0.03);
    SweepMotion { from: ToolPose { tip, axis }, to: ToolPose { tip: tip + travel, axis: to_axis } }
}

fn check(body: &Profile, motion: &SweepMotion, random: &mut Random) -> Worst {
    // A stock of some 8 x 8 x 8 coarse cells at a random place of the swept body.
    let reach = body.max_radius();
    let z = random.range(body.z_min() - 0.2, body.z_max());
    let at = motion.from.interpolated(&motion.to, random.next());
    let side = reach * random.range(0.3, 2.5) + 0.2;
    let center = at.tip + at.axis * z + random.direction() * (reach * random.next());
    let half = Vector::repeat(0.5 * side);
    let bounds = Aabb { min: center - half, max: center + half };
    let cell = side / 8.0;
    let mut stock = TriDexel::from_box(&bounds, cell, GIB).unwrap();
    let report = stock.sweep(&[remove(7, body, motion.from, motion.to)]);
    assert!(report[0].volume_mm3.is_finite());
    let stamps = 64;
    let mut worst = Worst { bound: stock.sweep_bound_mm(), ..Worst::default() };
    for axis in 0..3 {
        for i in 0..8 {
            for j in 0..8 {
                let [u, v] = stock.ray_place(axis, i, j);
                let point = |s: f64| {
                    let mut p = Point::origin();
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (s, u, v);
                    p
                };
                let spans = stock.ray_intervals(axis, i, j);
                worst.rays += 1;
                for s in &spans {
                    for (end, made_by) in [(s.lo, s.lo_made_by), (s.hi, s.hi_made_by)] {
                        if made_by == Some(7) {
                            let d = oracle(body, motion, &point(end), stamps).abs();
                            worst.end = worst.end.max(d);
                            if d > BOUND {
                                eprintln!(
                                    "end off by {:e} at {} axis {axis}: {body:?} {motion:?}",
                                    oracle(body, motion, &point(end), 400),
                                    point(end)
                                );
                            }
                        }
                    }
                }
                let inside = |x: f64| spans.iter().any(|s| s.lo <= x && x <= s.hi);
                for k in 0..7 {
                    let x = bounds.min[axis] + side * (k as f64 + random.next()) / 7.0;
                    let d = oracle(body, motion, &point(x), 24);
                    if inside(x) {
                        worst.left = worst.left.max(-d);
                        if -d > BOUND {
                            eprintln!("left {d:e} at {} axis {axis}: {body:?} {motion:?}", point(x));
                        }
                    } else {
                        worst.gone = worst.gone.max(d);
                        if d > BOUND {
                            eprintln!("gone {d:e} at {} axis {axis}: {body:?} {motion:?}", point(x));
                        }
                    }
                }
            }
        }
    }
    worst.beyond = worst.end.max(worst.left).max(worst.gone) - worst.bound;
    worst
}

#[test]
fn the_sweep_agrees_with_dense_stamping_to_one_micrometer() {
    let rays: usize = std::env::var("PROVEOUT_ORACLE_RAYS").ok().and_then(|v| v.parse().ok()).unwrap_or(20_000);
    let cases = rays.div_ceil(192);
    let results: Vec<(usize, Worst)> = (0..cases)
        .into_par_iter()
        .map(|case| {
            let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ (case as u64 + 1).wrapping_mul(0xD1B5_4A32_D192_ED03));
            random.next();
            let (kind, body) = random_cutter(&mut random);
            let length = [0.05, 0.5, 1.0, 5.0][random.pick(4)] * random.range(0.5, 1.5);
            let motion = random_motion(&mut random, length);
            (kind, check(&body, &motion, &mut random))
        })
        .collect();
    let mut all = Worst { beyond: f64::NEG_INFINITY, ..Worst::default() };
    let mut kinds = [(0, 0.0_f64); KINDS];
    for (kind, w) in &results {
        all.rays += w.rays;
        all.end = all.end.max(w.end);
        all.left = all.left.max(w.left);
        all.gone = all.gone.max(w.gone);
        all.bound = all.bound.max(w.bound);
        all.beyond = all.beyond.max(w.beyond);
        kinds[*kind].0 += w.rays;
        kinds[*kind].1 = kinds[*kind].1.max(w.end).max(w.left).max(w.gone);
    }
    println!("{all:?}\nby kind of cutter (rays, worst mm): {kinds:?}");
    assert!(all.rays >= rays);
    assert!(all.bound <= BOUND, "stated bound {} mm", all.bound);
    assert!(all.beyond <= ORACLE_ERROR, "a motion is off by more than its bound: {all:?}");
    assert!(all.end <= BOUND && all.left <= BOUND && all.gone <= BOUND, "{all:?}");
}

#[test]
fn a_pose_helper_normalizes() {
    assert!((pose([0.0; 3], [0.0, 3.0, 4.0]).axis.norm() - 1.0).abs() < 1e-15);
}
