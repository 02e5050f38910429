//! Least angular acceleration of tool axes against its specification: golden files, published vectors, the
//! rows of both scenes as an independent implementation counts them, and the printed forms that are wrong.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::f64::consts::TAU;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_reschedule::{
    CuttingBlock, CuttingRun, FeasibleRegion, Method, MinAngularAcceleration, Surroundings, between_keys, capped,
    inflections, true_minimum,
};
use proveout_tool::Cutter;

fn rows(text: &str) -> Vec<Vec<f64>> {
    text.lines().skip(1).map(|l| l.split(',').map(|v| v.trim().parse().unwrap_or(f64::NAN)).collect()).collect()
}

fn summed(steps: &[f64]) -> Vec<f64> {
    let mut arc = vec![0.0];
    for step in steps {
        arc.push(arc[arc.len() - 1] + step);
    }
    arc
}

#[test]
fn golden_axes_between_two_keys() {
    let golden = rows(include_str!("reference/min-angular-acceleration_golden_slerp.csv"));
    let axis = |c: f64, a: f64| {
        let ((sa, ca), (sc, cc)) = (a.to_radians().sin_cos(), c.to_radians().sin_cos());
        Vector::new(sa * sc, -sa * cc, ca)
    };
    let arc = summed(&[0.5, 0.8, 0.65, 1.2, 0.3, 0.9]);
    let keys = [(0, axis(30.0, 10.0)), (6, axis(70.0, 35.0))];
    let axes = between_keys(&arc, &keys, 6.0);
    assert_eq!(golden.len(), 7);
    for (v, axis) in golden.iter().zip(&axes) {
        assert!((axis - Vector::new(v[2], v[3], v[4])).norm() < 1e-11, "{v:?} {axis:?}");
    }
    // As printed, (35) divides a sum by itself: every axis would be the last one.
    let printed = arc[6] / arc[6];
    assert!((proveout_reschedule::slerp(&keys[0].1, &keys[1].1, printed) - axes[3]).norm() > 0.1);
}

#[test]
fn published_axes_follow_arc_length() {
    let table = rows(include_str!("reference/min-angular-acceleration_vectors.csv"));
    let printed = |v: &[f64], k: usize| Vector::new(v[6], v[7], v[k]);
    let steps: Vec<f64> = table.iter().map(|v| v[13]).take_while(|s| s.is_finite()).collect();
    let arc = summed(&steps);
    let keys = [(0, printed(&table[0], 9).normalize()), (7, printed(&table[7], 9).normalize())];
    let axes = between_keys(&arc, &keys, 0.0);
    for (v, axis) in table.iter().zip(&axes) {
        assert!((printed(v, 9).norm() - 1.0).abs() < 6e-5);
        assert!((axis - printed(v, 9)).norm() < 2e-4, "{v:?} {axis:?}");
        assert!(((-axis.y).atan2(axis.z).to_degrees() + v[10]).abs() < 0.01, "A has the other sign at C = 180");
    }
    // The third vector as printed is that of no tool above the table.
    assert!((axes[2] - printed(&table[2], 8)).norm() > 1.8);
}

/// A row along y on z = m/k (1 - cos k y) in steps of equal arc, from a phase over 1.5 periods: points, and
/// initial axes that lean 5 degrees from the normal towards the feed.
fn sine(m: f64, k: f64, step: f64, phase_deg: f64) -> (Vec<Point>, Vec<Vector>) {
    let slope = |y: f64| m * (k * y).sin();
    let (from, to) = (phase_deg.to_radians() / k, phase_deg.to_radians() / k + 1.5 * TAU / k);
    let (mut y, mut left, mut at) = (from, 0.0, vec![from]);
    let fine = 1e-5;
    while y < to {
        left += fine * slope(y + 0.5 * fine).hypot(1.0);
        y += fine;
        if left >= step {
            left -= step;
            at.push(y);
        }
    }
    let points = at.iter().map(|&y| Point::new(0.0, y, m / k * (1.0 - (k * y).cos()))).collect();
    let axes = at.iter().map(|&y| {
        let lean = -slope(y).atan() + 5.0_f64.to_radians();
        Vector::new(0.0, lean.sin(), lean.cos())
    });
    (points, axes.collect())
}

/// Largest angular velocity and acceleration of A, deg and s, at 250 mm/min (specification 4); A of both
/// signs, or of one with C.
fn peaks(axes: &[Vector], arc: &[f64], one_sign: bool) -> [f64; 2] {
    let v = 250.0 / 60.0;
    let steps: Vec<f64> = arc.windows(2).map(|s| s[1] - s[0]).collect();
    let joints: Vec<[f64; 2]> = axes
        .iter()
        .map(|t| {
            let a = (-t.y).atan2(t.z).to_degrees();
            if one_sign { [-a.abs(), if a > 0.0 { 180.0 } else { 0.0 }] } else { [a, 0.0] }
        })
        .collect();
    let pairs = joints.windows(2).zip(&steps);
    let rates: Vec<[f64; 2]> = pairs.map(|(p, l)| [0, 1].map(|k| v * (p[1][k] - p[0][k]) / l)).collect();
    let size = |r: &[f64; 2]| r[0].hypot(r[1]);
    let changes = rates
        .windows(2)
        .zip(steps.windows(2))
        .map(|(p, l)| 2.0 * v / (l[0] + l[1]) * (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]));
    [rates.iter().map(size).fold(0.0, f64::max), changes.fold(0.0, f64::max)]
}

/// Way along the chords of equal arcs.
fn chords(points: &[Point]) -> Vec<f64> {
    summed(&points.windows(2).map(|p| (p[1] - p[0]).norm()).collect::<Vec<_>>())
}

fn close(got: [f64; 2], wanted: [f64; 2], part: f64) {
    for (g, w) in got.iter().zip(wanted) {
        assert!((g / w - 1.0).abs() < part, "{got:?} {wanted:?}");
    }
}

fn keys_of(points: &[Point], axes: &[Vector]) -> Vec<(usize, Vector)> {
    let cuts = inflections(points, &Vector::z());
    let at = [0].into_iter().chain(cuts).chain([points.len() - 1]);
    at.map(|i| (i, capped(&axes[i], &Vector::z(), 47.0_f64.to_radians()))).collect()
}

#[test]
fn the_published_ratio_comes_out_on_the_steep_sine() {
    let step = 0.78;
    let (points, axes) = sine(3.2, 0.22, step, 8.1);
    let phase = |i: usize| (0.22 * points[i].y).to_degrees();
    assert!((phase(points.len() - 1) - 544.09).abs() < 0.05, "{}", phase(points.len() - 1));
    let keys = keys_of(&points, &axes);
    // The cuts are the inflections, to half a step.
    assert_eq!(keys.len(), 5);
    for (key, wanted) in keys[1..4].iter().zip([90.0, 270.0, 450.0]) {
        let nearest =
            (0..points.len()).min_by(|&a, &b| (phase(a) - wanted).abs().total_cmp(&(phase(b) - wanted).abs()));
        assert_eq!(Some(key.0), nearest, "{wanted}: {}", phase(key.0));
        assert!((key.1.z.acos().to_degrees() - 47.0).abs() < 1e-9);
    }
    let arc = chords(&points);
    close(peaks(&axes, &arc, false), [163.5, 341.7], 1e-3);
    let law = between_keys(&arc, &keys, 0.0);
    close(peaks(&law, &arc, false), [15.8, 146.6], 4e-3);
    // With windows the jump of speed at the keys is spread over 12 mm: no law takes less acceleration than
    // the mean.
    let smoothed = |window| peaks(&between_keys(&arc, &keys, window), &arc, false)[1];
    let mean = |window: f64| 146.6 * step / (2.0 * window);
    assert!((smoothed(6.0) / mean(6.0) - 1.0).abs() < 0.02, "{} {}", smoothed(6.0), mean(6.0));
    // The other count's 7.3 is that of ten points on each side, 7.8 mm.
    assert!((smoothed(7.8) / 7.3 - 1.0).abs() < 0.02, "{}", smoothed(7.8));
    // A of one sign: three half turns of C decide, by the step at which they happen, and nothing is gained.
    let turns = |axes: &[Vector]| axes.windows(2).filter(|p| p[0].y * p[1].y < 0.0).count();
    assert_eq!((turns(&axes), turns(&law)), (3, 3));
    close(peaks(&axes, &arc, true), [982.0, 5445.5], 2e-3);
    close(peaks(&law, &arc, true), [972.5, 5246.1], 0.03);
}

#[test]
fn on_a_gentle_sine_the_windows_are_what_helps() {
    let step = 0.6;
    let k = TAU / 40.0;
    let (points, axes) = sine(6.0 * k, k, step, 8.1);
    let arc = chords(&points);
    let keys = keys_of(&points, &axes);
    close(peaks(&axes, &arc, false), [35.3, 20.9], 5e-3);
    let law = |window| peaks(&between_keys(&arc, &keys, window), &arc, false);
    close(law(0.0), [16.1, 214.6], 5e-3);
    close([law(6.0)[1], 1.0], [10.7, 1.0], 5e-3);
    assert!(law(6.0)[1] < 20.9, "not more than the program before");
}

/// Between two keys with windows each has half of the way; a window next to an end of the row reaches to the
/// end.
#[test]
fn a_window_beside_an_end_of_the_row_has_all_of_the_way() {
    let axis = |lean: f64| Vector::new(0.0, -lean.sin(), lean.cos());
    let lean = |axis: &Vector| (-axis.y).atan2(axis.z);
    let arc: Vec<f64> = (0..=44).map(|i| 0.5 * f64::from(i)).collect();
    // Keys at 0, 5, 12 and 22 mm: 5 mm to the first end, 7 mm between the windows, 10 mm to the last end.
    let keys = [(0, axis(0.0)), (10, axis(0.5)), (24, axis(-0.2)), (44, axis(0.8))];
    let straight = between_keys(&arc, &keys, 0.0);
    let changed = |window| -> Vec<usize> {
        let law = between_keys(&arc, &keys, window);
        (0..arc.len()).filter(|&i| (lean(&law[i]) - lean(&straight[i])).abs() > 1e-9).collect()
    };
    // 3 mm fit on the side of the first end, where they would not next to another window.
    let found = changed(3.2);
    assert_eq!((found.first(), found.last()), (Some(&4), Some(&30)), "{found:?}");
    // Never beyond the middle between two windows.
    let found = changed(100.0);
    assert_eq!((found.first(), found.last()), (Some(&4), Some(&30)), "{found:?}");
    // The middle itself keeps the law between the keys.
    assert!(found.contains(&16) && !found.contains(&17) && found.contains(&18), "{found:?}");
}

#[test]
fn the_profile_of_unequal_steps_is_cut_where_it_bends_the_other_way() {
    // Straight, whatever the steps (as printed, (27) bends a straight line), then one cut.
    let straight: Vec<Point> = [0.0, 1.0, 3.0, 3.5, 6.0].iter().map(|y| Point::new(0.0, *y, 2.0 * y)).collect();
    assert_eq!(inflections(&straight, &Vector::z()), Vec::<usize>::new());
    let y = [0.0, 1.0, 3.0];
    let printed = (2.0 * y[2] - 2.0 * 2.0 * y[1] + 2.0 * y[0]) / (1.0 * 2.0);
    assert_eq!(printed, 1.0);
    let mut y = -20.0;
    let cubic: Vec<Point> = (0..=50)
        .map(|i| {
            y += 0.6 + 0.2 * f64::from(i % 5);
            Point::new(0.0, y, 0.001 * y.powi(3))
        })
        .collect();
    let cuts = inflections(&cubic, &Vector::z());
    assert!(cuts.len() == 1 && cubic[cuts[0]].y.abs() <= 1.4, "{cuts:?}");
}

struct Slab;

impl FeasibleRegion for Slab {
    /// Free while the axis leans to one side of the plane y = 0 by no more than 0.2.
    fn clearance(&self, pose: &ToolPose) -> f64 {
        0.2 - pose.axis.y
    }
}

fn run_of(points: &[Point], axes: &[Vector]) -> CuttingRun {
    let blocks = points.iter().zip(axes).zip(1..).map(|((p, axis), line)| CuttingBlock {
        pose: ToolPose { tip: p - axis * 3.0, axis: *axis },
        line,
        time: Some(0.1),
    });
    CuttingRun { blocks: blocks.collect() }
}

#[test]
fn ball_centers_stay_and_what_it_is_not_for_is_refused_with_the_block() {
    let (points, axes) = sine(6.0 * TAU / 40.0, TAU / 40.0, 0.6, 8.1);
    let run = run_of(&points, &axes);
    let ball = Cutter::ball(6.0).unwrap().bodies(10.0).unwrap().remove(0);
    let around = Surroundings::new(&ball, Vector::z());
    let method = MinAngularAcceleration::default();
    let made = method.reschedule(&run, &around).unwrap();
    for (pose, center) in made.poses.iter().zip(&points) {
        assert!((pose.tip + pose.axis * 3.0 - center).norm() < 1e-12 && (pose.axis.norm() - 1.0).abs() < 1e-12);
    }
    let refused = |run: &CuttingRun, method: MinAngularAcceleration, around: &Surroundings<'_>| {
        let error = method.reschedule(run, around).unwrap_err();
        (error.code, error.line)
    };
    assert_eq!(refused(&run, MinAngularAcceleration { cap: 0.0, ..method }, &around), ("reschedule-option", 0));
    let short = CuttingRun { blocks: run.blocks[..4].to_vec() };
    assert_eq!(refused(&short, method, &around), ("reschedule-layers", 1));
    let mut twice = run.clone();
    twice.blocks[7] = twice.blocks[6];
    twice.blocks[7].line = 8;
    assert_eq!(refused(&twice, method, &around), ("reschedule-path", 8));
    let flat = Cutter::bull_nose(10.0, 1.0).unwrap().bodies(10.0).unwrap().remove(0);
    assert_eq!(refused(&run, method, &Surroundings::new(&flat, Vector::z())), ("reschedule-tool", 1));
    // A program that was free where the new axes are not: the first of them is named.
    let upright = run_of(&points, &vec![Vector::z(); points.len()]);
    let mut leaned = upright.clone();
    let n = leaned.blocks.len();
    leaned.blocks[n - 1].pose.axis = Vector::new(0.0, 0.6, 0.8);
    leaned.blocks[n - 1].pose.tip = points[n - 1] - leaned.blocks[n - 1].pose.axis * 3.0;
    let region = Surroundings { region: Some(&Slab), ..around };
    assert!(method.reschedule(&upright, &region).is_ok());
    let (code, line) = refused(&leaned, method, &region);
    assert!(code == "reschedule-channel" && line > 1 && (line as usize) < n, "{line} of {n}");
}

/// The specification's example: two intervals of ten steps with mean rates 1 and 2. The law between keys has
/// a sum of 1.0, the least one 0.149.
#[test]
fn over_the_whole_row_the_sum_is_less_than_between_two_keys_each() {
    let scale = 0.01;
    let axis = |a: f64| Vector::new(0.0, -a.sin(), a.cos());
    let arc: Vec<f64> = (0..=20).map(f64::from).collect();
    let keys = [(0, axis(0.0)), (10, axis(10.0 * scale)), (20, axis(30.0 * scale))];
    let law = between_keys(&arc, &keys, 0.0);
    let turn = |a: &Vector, b: &Vector| a.cross(b).norm().atan2(a.dot(b));
    let sum = |axes: &[Vector]| -> f64 {
        let rates: Vec<f64> = axes.windows(2).map(|w| turn(&w[0], &w[1])).collect();
        rates.windows(2).map(|r| (r[1] - r[0]).powi(2)).sum::<f64>() / (scale * scale)
    };
    let (least, value) = true_minimum(&arc, &keys, law.clone());
    assert!((sum(&law) - 1.0).abs() < 1e-9 && (sum(&least) - 0.149).abs() < 5e-4, "{} {}", sum(&law), sum(&least));
    assert!((value / (scale * scale) - sum(&least)).abs() < 1e-6);
    for (i, key) in keys {
        assert!((least[i] - key).norm() < 1e-12, "keys stay");
    }
    // On one great circle it is the spline of numbers: rates have no jump that a small move of an axis could
    // take down.
    assert!(least.iter().all(|a| a.x.abs() < 1e-9));
}

/// On the sphere, off any one great circle and with unequal steps: no small move of any axis lowers the sum.
#[test]
fn no_small_move_of_an_axis_lowers_the_true_minimum() {
    let mut state = 5_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..20 {
        let mut arc = vec![0.0];
        for _ in 0..60 {
            arc.push(arc[arc.len() - 1] + 0.3 + random());
        }
        let keys: Vec<(usize, Vector)> = [0, 17, 33, 60]
            .into_iter()
            .map(|i| (i, Vector::new(1.2 * (random() - 0.5), 1.2 * (random() - 0.5), 1.0).normalize()))
            .collect();
        let law = between_keys(&arc, &keys, 0.0);
        let turn = |a: &Vector, b: &Vector| {
            let across = b - a * b.dot(a);
            across * (across.norm().atan2(b.dot(a)) / across.norm().max(1e-15))
        };
        let sum = |axes: &[Vector]| -> f64 {
            let rate = |i: usize, j: usize| turn(&axes[i], &axes[j]) / (arc[j] - arc[i]).abs();
            (1..axes.len() - 1).map(|i| (rate(i, i + 1) + rate(i, i - 1)).norm_squared()).sum()
        };
        let (least, value) = true_minimum(&arc, &keys, law.clone());
        let best = sum(&least);
        assert!((value - best).abs() < 1e-9 * best && best < sum(&law), "{value} {best}");
        for _ in 0..200 {
            let size = 1e-4 * (0.2 + random());
            let bend: Vec<f64> = (0..6).map(|_| size * (random() - 0.5)).collect();
            let moved: Vec<Vector> = (0..least.len())
                .map(|i| {
                    if keys.iter().any(|(k, _)| *k == i) {
                        return least[i];
                    }
                    let x = i as f64 / 60.0;
                    let by = |k: usize| bend[k] * (1.0 + k as f64 * 6.0 * x).sin();
                    (least[i] + Vector::new(by(1) + by(3), by(2) + by(4), by(5))).normalize()
                })
                .collect();
            assert!(sum(&moved) > best * (1.0 - 2e-6), "{} {best}", sum(&moved));
        }
    }
}
