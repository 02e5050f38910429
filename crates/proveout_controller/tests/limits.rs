//! Random programs: what the samples themselves say about limits, path and time.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::sync::Mutex;

use crate::common::{Program, Random, Run, bc_machine, for_all, limit_use, run_with, tool};
use proveout_controller::{Dynamics, Settings};
use proveout_geom::Point;
use proveout_machine::Machine;

/// Number of random programs of each kind; `PROVEOUT_RANDOM_PATHS` raises it.
fn count() -> u64 {
    std::env::var("PROVEOUT_RANDOM_PATHS").ok().and_then(|v| v.parse().ok()).unwrap_or(100)
}

fn distance_to_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
    (p - (a + d * t)).norm()
}

fn check_limits(name: &str, out: &Run, machine: &Machine) {
    let worst = limit_use(out, machine, machine.control.cycle_time);
    for (what, value) in [("velocity", worst.velocity), ("acceleration", worst.acceleration), ("jerk", worst.jerk)] {
        assert!(value <= 1.001, "{name}: {what} at {value} of its limit");
    }
    for (k, value) in worst.differences.iter().enumerate() {
        assert!(*value <= 1.001, "{name}: difference {k} at {value} of its limit");
    }
    let bound = out.summary.path_bound_s.expect("a bound");
    assert!(bound <= out.summary.total_s * (1.0 + 1e-12), "{name}: bound {bound}, time {}", out.summary.total_s);
}

fn polyline(seed: u64) -> Program {
    let mut r = Random::new(seed);
    let mut p = Program::default().continuous(10_f64.powf(r.range(-3.0, -0.7)));
    let size = 10_f64.powf(r.range(-1.0, 2.3));
    let (mut x, mut y, mut z) = (0.0, 0.0, 0.0);
    for k in 0..40 {
        if k % 7 == 0 {
            p = p.feed(10_f64.powf(r.range(0.5, 2.6)));
        }
        x += r.range(-size, size) * 0.5;
        y += r.range(-size, size) * 0.5;
        z += r.range(-size, size) * 0.2;
        let axes = [('X', x), ('Y', y), ('Z', z)];
        p = if r.unit() < 0.15 { p.g0(&axes) } else { p.g1(&axes) };
        if r.unit() < 0.05 {
            p = p.exact_stop();
        } else if r.unit() < 0.1 {
            p = p.continuous(10_f64.powf(r.range(-3.0, -0.7)));
        }
    }
    p
}

fn five_axis(seed: u64) -> Program {
    five_axis_with_points(seed).0
}

/// The program, its tolerance, and the tips of its blocks with tool center point control.
fn five_axis_with_points(seed: u64) -> (Program, f64, Vec<Point>) {
    let mut r = Random::new(seed ^ 0xA5A5);
    let mut p = Program::default().change(1).g0(&[('Z', 350.0)]).g0(&[('B', 0.3), ('C', 0.2)]).tcp(true);
    let tolerance = 10_f64.powf(r.range(-2.5, -1.0));
    p = p.continuous(tolerance);
    let mut points = Vec::new();
    let step = 10_f64.powf(r.range(-1.0, 1.3));
    let turn = 10_f64.powf(r.range(-3.0, -0.7));
    let (mut x, mut y, mut z, mut b, mut c): (f64, f64, f64, f64, f64) = (0.0, 0.0, 150.0, 0.3, 0.2);
    for k in 0..50 {
        if k % 9 == 0 {
            p = p.feed(10_f64.powf(r.range(0.5, 2.3)));
        }
        x += r.range(-step, step);
        y += r.range(-step, step);
        z += r.range(-step, step) * 0.3;
        b = (b + r.range(-turn, turn)).clamp(-1.2, 1.2);
        c += r.range(-turn, turn) * 2.0;
        p = p.g1(&[('X', x), ('Y', y), ('Z', z), ('B', b), ('C', c)]);
        points.push(Point::new(x, y, z));
    }
    (p, tolerance, points)
}

#[test]
fn polylines_keep_limits_and_tolerance() {
    let machine = bc_machine();
    for_all(0..count(), |seed| {
        let out = run_with(&polyline(seed), &machine, &[], &Settings::default());
        check_limits(&format!("polyline {seed}"), &out, &machine);
    });
}

#[test]
fn five_axis_paths_keep_limits() {
    let machine = bc_machine();
    for_all(0..count(), |seed| {
        let (program, tolerance, points) = five_axis_with_points(seed);
        let out = run_with(&program, &machine, &[tool(1, 120.0)], &Settings::default());
        check_limits(&format!("five axes {seed}"), &out, &machine);
        // The first block comes from a place that the program does not name; the second begins at points[0].
        let first = out.all.blocks.len() - points.len();
        for s in out.all.samples.iter().filter(|s| s.block as usize > first) {
            let near = points.windows(2).map(|w| distance_to_segment(&s.pose.tip, &w[0], &w[1]));
            let d = near.fold(f64::INFINITY, f64::min);
            assert!(d <= tolerance + 1e-9, "five axes {seed}: tip {d} off at {} s, tolerance {tolerance}", s.time);
        }
    });
}

#[test]
fn dynamics_do_not_change_the_time() {
    let machine = bc_machine();
    let program = five_axis(3);
    let tools = [tool(1, 120.0)];
    let planned = run_with(&program, &machine, &tools, &Settings::default());
    let ideal = run_with(&program, &machine, &tools, &Settings { dynamics: Dynamics::Ideal, ..Settings::default() });
    assert_eq!(planned.summary.total_s, ideal.summary.total_s);
    assert_eq!(planned.all.blocks, ideal.all.blocks);
    // Against the programmed path, whose circles and joints are computed twice: rounding.
    assert!(ideal.summary.max_contour_error_mm < 1e-10, "{}", ideal.summary.max_contour_error_mm);
    assert!(planned.summary.max_contour_error_mm > 0.0);
}

/// Total time over the bound, summed over random programs.
fn over_bound(make: fn(u64) -> Program, machine: &Machine) -> f64 {
    let sums = Mutex::new([0.0; 2]);
    for_all(0..20, |seed| {
        let s = run_with(&make(seed), machine, &[tool(1, 120.0)], &Settings::default()).summary;
        let mut sums = sums.lock().expect("no other thread has failed");
        sums[0] += s.total_s - s.tool_change_s;
        sums[1] += s.path_bound_s.expect("a bound") - s.tool_change_s;
    });
    let [total, bound] = sums.into_inner().expect("no thread has failed");
    total / bound
}

#[test]
fn time_is_near_the_bound() {
    let machine = bc_machine();
    let mut quick = bc_machine();
    for joint in &mut quick.joints {
        joint.max_jerk = joint.max_jerk.map(|j| j * 1000.0);
    }
    // With jerk limits as good as none the bound is the optimum under velocity and acceleration limits.
    let free = [over_bound(polyline, &quick), over_bound(five_axis, &quick)];
    // With the real ones the bound lies below the optimum by what jerk costs.
    let real = [over_bound(polyline, &machine), over_bound(five_axis, &machine)];
    println!("time over bound: jerk free {free:?}, jerk limited {real:?}");
    assert!(free.iter().all(|r| *r < 1.15), "{free:?}");
}
