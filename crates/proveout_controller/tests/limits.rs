//! Random programs: what the samples themselves say about limits, path and time.

mod common;

use common::{Program, Random, Run, bc_machine, limit_use, run_with, tool};
use proveout_controller::{Dynamics, Settings};
use proveout_machine::Machine;

/// Number of random programs of each kind; `PROVEOUT_RANDOM_PATHS` raises it.
fn count() -> u64 {
    std::env::var("PROVEOUT_RANDOM_PATHS").ok().and_then(|v| v.parse().ok()).unwrap_or(60)
}

fn check_limits(name: &str, out: &Run, machine: &Machine) {
    let worst = limit_use(out, machine, machine.control.cycle_time);
    for (what, value) in [("velocity", worst.velocity), ("acceleration", worst.acceleration), ("jerk", worst.jerk)] {
        assert!(value <= 1.001, "{name}: {what} at {value} of its limit");
    }
    for (k, value) in worst.differences.iter().enumerate() {
        assert!(*value <= 1.001, "{name}: difference {k} at {value} of its limit");
    }
    let bound = out.summary.lower_bound_s.expect("a bound");
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
    let mut r = Random::new(seed ^ 0xA5A5);
    let mut p = Program::default().change(1).g0(&[('Z', 350.0)]).g0(&[('B', 0.3), ('C', 0.2)]).tcp(true);
    p = p.continuous(10_f64.powf(r.range(-2.5, -1.0)));
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
    }
    p
}

#[test]
fn polylines_keep_limits_and_tolerance() {
    let machine = bc_machine();
    for seed in 0..count() {
        let out = run_with(&polyline(seed), &machine, &[], &Settings::default());
        check_limits(&format!("polyline {seed}"), &out, &machine);
    }
}

#[test]
fn five_axis_paths_keep_limits() {
    let machine = bc_machine();
    for seed in 0..count() {
        let out = run_with(&five_axis(seed), &machine, &[tool(1, 120.0)], &Settings::default());
        check_limits(&format!("five axes {seed}"), &out, &machine);
    }
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
    assert_eq!(ideal.summary.max_contour_error_mm, 0.0);
    assert!(planned.summary.max_contour_error_mm > 0.0);
}
