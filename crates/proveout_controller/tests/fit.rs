//! Runs of short blocks: fitted within the tolerance, at the feed, without shaking the machine.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use crate::common::{Program, Random, Run, bc_machine, limit_use, motion, run_with, tool};
use proveout_controller::{Dynamics, MoveKind, Settings};
use proveout_geom::Point;
use proveout_nc::Op;

/// A wavy circle of radius 40 mm as chords of this length, coordinates rounded to `grid`, and its points.
fn chords(length: f64, grid: f64, blocks: u32, tolerance: f64, feed: f64) -> (Program, Vec<Point>) {
    let mut program = Program::default().continuous(tolerance).feed(feed);
    let mut points = Vec::new();
    for k in 0..=blocks {
        let a = f64::from(k) * length / 40.0;
        let exact = [40.0 * a.cos(), 40.0 * a.sin(), 5.0 * (3.0 * a).sin()];
        let p = exact.map(|x| if grid > 0.0 { (x / grid).round() * grid } else { x });
        let at = [('X', p[0]), ('Y', p[1]), ('Z', p[2])];
        program = if k == 0 { program.g0(&at) } else { program.g1(&at) };
        points.push(Point::new(p[0], p[1], p[2]));
    }
    (program, points)
}

fn off(p: &Point, points: &[Point]) -> f64 {
    let near = |w: &[Point]| {
        let d = w[1] - w[0];
        let t = if d.norm_squared() > 0.0 { ((p - w[0]).dot(&d) / d.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
        (p - (w[0] + d * t)).norm()
    };
    points.windows(2).map(near).fold(f64::INFINITY, f64::min)
}

/// Largest distance of the samples of the cut from the programmed path, mm.
fn worst_off(run: &Run, points: &[Point]) -> f64 {
    let cut = run.all.samples.iter().filter(|s| s.kind == MoveKind::Feed && s.block > 1);
    cut.map(|s| off(&s.pose.tip, points)).fold(0.0, f64::max)
}

/// Samples in the middle half of the cut.
fn cruise(run: &Run) -> impl Iterator<Item = &proveout_controller::Sample> {
    let cut: Vec<f64> = run.all.samples.iter().filter(|s| s.kind == MoveKind::Feed).map(|s| s.time).collect();
    let (from, to) = (cut[cut.len() / 4], cut[3 * cut.len() / 4]);
    run.all.samples.iter().filter(move |s| s.time >= from && s.time <= to)
}

#[test]
fn chords_of_a_curve_are_passed_at_the_feed_without_shaking_the_joints() {
    let machine = bc_machine();
    for (length, feed) in [(0.1, 60.0), (0.4, 60.0), (0.4, 100.0), (1.0, 100.0)] {
        let (program, points) = chords(length, 0.0, 1200, 0.01, feed);
        let run = run_with(&program, &machine, &[], &Settings::default());
        let slowest = cruise(&run).map(|s| s.feed).fold(f64::INFINITY, f64::min);
        let jerk = cruise(&run).map(|s| (0..3).map(|i| s.jerk[i].abs()).fold(0.0, f64::max)).fold(0.0, f64::max);
        let limit = machine.joints[0].max_jerk.expect("a limit");
        // The curve itself: v^3 x''' with the third derivative by the arc length, at most 5 (3/40)^3 + 1/40^2
        // per mm^2.
        let own = feed.powi(3) * (5.0 * (3.0_f64 / 40.0).powi(3) + 1.0 / 1600.0);
        let worst = worst_off(&run, &points);
        println!(
            "chords of {length} mm at {feed} mm/s: feed {slowest:.3}, jerk {jerk:.0} of {limit} (the curve's own {own:.0}), {worst:.5} mm off"
        );
        assert!(slowest > 0.999 * feed, "{slowest} of {feed}");
        assert!(worst <= 0.01 + 1e-9, "{worst}");
        // What the chords add to the curve's own jerk: waves of 4 percent of the curvature v^2/R at the
        // frequency of the blocks.
        let waves = 0.04 * feed * feed * (1.0 / 40.0 + 5.0 * 9.0 / 1600.0) * std::f64::consts::TAU * feed / length;
        assert!(jerk < 2.0 * (own + waves) && jerk < 0.75 * limit, "{jerk} {own} {waves}");
        let use_of = limit_use(&run, &machine, 0.002);
        assert!(use_of.jerk <= 1.001 && use_of.acceleration <= 1.001);
    }
}

#[test]
fn rounded_coordinates_of_short_blocks_cost_little_time() {
    let machine = bc_machine();
    let time = |grid: f64| {
        let (program, points) = chords(0.1, grid, 3000, 0.01, 60.0);
        let run = run_with(&program, &machine, &[], &Settings::default());
        let worst = worst_off(&run, &points);
        assert!(worst <= 0.01 + 1e-9, "{worst}");
        let use_of = limit_use(&run, &machine, 0.002);
        assert!(use_of.jerk <= 1.001 && use_of.acceleration <= 1.001);
        let length: f64 = points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        (run.summary.cutting_s, length / 60.0)
    };
    let ((exact, at_feed), (rounded, _)) = (time(0.0), time(0.001));
    println!("blocks of 0.1 mm: {exact:.3} s, rounded to 1 um {rounded:.3} s, at the feed {at_feed:.3} s");
    // Starting and stopping costs v/a + a/j at most.
    assert!(exact < at_feed + 0.2, "{exact}");
    assert!(rounded < 1.02 * exact, "{rounded} {exact}");
}

#[test]
fn sharp_corners_between_short_blocks_and_changes_of_the_tolerance_are_kept() {
    let machine = bc_machine();
    let mut r = Random::new(11);
    let (mut x, mut y, mut heading) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut program = Program::default().continuous(0.02).feed(50.0);
    let mut points = vec![(Point::new(0.0, 0.0, 0.0), 0.02)];
    let mut tolerance = 0.02;
    for k in 0..900 {
        if k % 90 == 45 {
            tolerance = if tolerance > 0.01 { 0.002 } else { 0.05 };
            program = program.continuous(tolerance);
        }
        heading += if k % 23 == 0 { r.range(-2.5, 2.5) } else { r.range(-0.02, 0.05) };
        let step = 10_f64.powf(r.range(-1.3, 0.4));
        (x, y) = (x + step * heading.cos(), y + step * heading.sin());
        program = program.g1(&[('X', x), ('Y', y)]);
        points.push((Point::new(x, y, 0.0), tolerance));
    }
    let run = run_with(&program, &machine, &[], &Settings::default());
    let use_of = limit_use(&run, &machine, 0.002);
    assert!(use_of.jerk <= 1.001 && use_of.acceleration <= 1.001 && use_of.velocity <= 1.001);
    // A sample belongs to a block; the tolerance of this block holds there, against it and its neighbors.
    let first = run.all.blocks.first().map_or(0, |b| b.index);
    let mut used = 0.0_f64;
    for s in run.all.samples.iter().filter(|s| s.kind == MoveKind::Feed) {
        let k = (s.block - first) as usize;
        let window = &points[k.saturating_sub(40)..(k + 41).min(points.len())];
        let path: Vec<Point> = window.iter().map(|p| p.0).collect();
        let allowed = points[(k + 1).min(points.len() - 1)].1;
        let d = off(&s.pose.tip, &path);
        assert!(d <= allowed + 1e-9, "{d} mm off in block {k}, tolerance {allowed}");
        used = used.max(d / allowed);
    }
    println!("{:.3} s, {used:.3} of the tolerance", run.summary.total_s);
    assert!(used > 0.5, "the tolerance is hardly used: {used}");
    assert!(run.summary.max_contour_error_mm <= 0.05 + 1e-12);
}

#[test]
fn five_axes_with_short_blocks_reach_the_feed_within_both_tolerances() {
    let machine = bc_machine();
    let mut program =
        Program::default().change(1).g0(&[('Z', 300.0), ('B', 0.5)]).tcp(true).continuous(0.01).feed(40.0);
    let mut points = Vec::new();
    for k in 0..800 {
        let a = f64::from(k) * 0.01;
        let p = [40.0 * a.cos(), 40.0 * a.sin(), 150.0 + 5.0 * (3.0 * a).sin()];
        let at = [('X', p[0]), ('Y', p[1]), ('Z', p[2]), ('B', 0.4 + 0.1 * a.cos()), ('C', 0.5 * a)];
        program = if k == 0 { program.g0(&at).exact_stop().feed(40.0).continuous(0.01) } else { program.g1(&at) };
        points.push(Point::new(p[0], p[1], p[2]));
    }
    let run = run_with(&program, &machine, &[tool(1, 120.0)], &Settings::default());
    let slowest = cruise(&run).map(|s| s.feed).fold(f64::INFINITY, f64::min);
    let first = run.all.blocks.len() - 798;
    let cut = run.all.samples.iter().filter(|s| s.kind == MoveKind::Feed && s.block as usize >= first);
    let worst = cut.map(|s| off(&s.pose.tip, &points)).fold(0.0, f64::max);
    println!("five axes: feed {slowest:.3} of 40 mm/s, {worst:.5} mm off");
    assert!(slowest > 0.999 * 40.0, "{slowest}");
    assert!(worst <= 0.01 + 1e-9, "{worst}");
}

#[test]
fn short_great_circles_are_fitted_too_and_keep_the_tolerance_of_the_axis() {
    let machine = bc_machine();
    let tools = [tool(1, 120.0)];
    let mut program =
        Program::default().change(1).g0(&[('Z', 300.0), ('B', 0.9)]).tcp_great_circle().continuous(0.01).feed(30.0);
    // The axis leans by 50 degrees and more and turns by half a degree a block, round the leading edge of a
    // blade.
    let axis = |k: u32| {
        let (c, b) = (0.012 * f64::from(k), 0.9 + 0.05 * (0.02 * f64::from(k)).sin());
        [b.sin() * c.cos(), b.sin() * c.sin(), b.cos()]
    };
    let blocks = 400;
    for k in 0..=blocks {
        let a = 0.012 * f64::from(k);
        let mut m = motion(&[('X', 20.0 * a.cos()), ('Y', 20.0 * a.sin()), ('Z', 150.0 + 0.01 * f64::from(k))]);
        m.tool_axis = Some(axis(k));
        m.tool_axis_base = m.tool_axis;
        program = program.op(if k == 0 { Op::Rapid(m) } else { Op::Linear(m) });
        if k == 0 {
            program = program.exact_stop().feed(30.0).continuous(0.01);
        }
    }
    let run = |dynamics| run_with(&program, &machine, &tools, &Settings { dynamics, ..Settings::default() });
    let (planned, ideal) = (run(Dynamics::Planned), run(Dynamics::Ideal));
    assert_eq!(planned.all.samples.len(), ideal.all.samples.len());
    let slowest = cruise(&planned).map(|s| s.feed).fold(f64::INFINITY, f64::min);
    let (mut tip, mut turn) = (0.0_f64, 0.0_f64);
    for (p, i) in planned.all.samples.iter().zip(&ideal.all.samples) {
        tip = tip.max((p.pose.tip - i.pose.tip).norm());
        turn = turn.max(p.pose.angle_to(&i.pose));
    }
    println!("great circles: feed {slowest:.3} of 30 mm/s, {tip:.5} mm and {turn:.6} rad off");
    assert!(slowest > 0.999 * 30.0, "{slowest}");
    let allowed = machine.control.default_orientation_tolerance.unwrap_or(Settings::FALLBACK_ORIENTATION_TOLERANCE);
    // Both rotary joints may be off by the tolerance at once.
    assert!(tip <= 0.01 + 1e-9 && turn <= std::f64::consts::SQRT_2 * allowed, "{tip} {turn}");
    assert!(tip > 1e-4 && planned.summary.max_contour_error_mm >= tip - 1e-9);
    let use_of = limit_use(&planned, &machine, 0.002);
    assert!(use_of.jerk <= 1.001 && use_of.acceleration <= 1.001 && use_of.velocity <= 1.001);
}
