//! Times of simple motions against closed forms that share no code with the planner.

use crate::common::{Program, bc_machine, run};
use proveout_controller::{BlockKind, Event, MoveKind};
use proveout_machine::Machine;
use proveout_nc::{Dwell, Op};

/// Time of a rest-to-rest motion under V, A, J (Biagiotti and Melchiorri 2008, section 3.4), all four cases
/// by hand.
fn rest_to_rest(d: f64, v: f64, a: f64, j: f64) -> f64 {
    if j.is_infinite() {
        return if d * a >= v * v { d / v + v / a } else { 2.0 * (d / a).sqrt() };
    }
    if v * j >= a * a {
        let ramp = v / a + a / j; // reaches A on the way to V
        if d >= v * ramp {
            return d / v + ramp;
        }
        let least = 2.0 * a * a * a / (j * j); // reaches A at all
        if d >= least {
            return a / j + ((a / j) * (a / j) + 4.0 * d / a).sqrt();
        }
    } else if d >= 2.0 * v * (v / j).sqrt() {
        return d / v + 2.0 * (v / j).sqrt();
    }
    4.0 * (d / (2.0 * j)).cbrt()
}

fn total(program: &Program, machine: &Machine) -> f64 {
    run(program, machine).summary.total_s
}

#[test]
fn single_s_curve_in_all_its_shapes() {
    let machine = bc_machine();
    for feed in [1.0, 20.0, 150.0, 400.0] {
        for d in [0.001, 0.02, 0.5, 3.0, 12.0, 60.0, 400.0] {
            let program = Program::default().feed(feed).g1(&[('X', d)]);
            let t = total(&program, &machine);
            let expected = rest_to_rest(d, feed, 4000.0, 80_000.0);
            // Rounding of the roots alone.
            assert!((t - expected).abs() < 1e-9 * expected, "F {feed} d {d}: {t} against {expected}");
        }
    }
}

#[test]
fn a_rapid_along_two_axes_is_limited_by_both() {
    let machine = bc_machine();
    let program = Program::default().g0(&[('X', 300.0), ('Y', 300.0)]);
    let root2 = 2_f64.sqrt();
    let expected = rest_to_rest(300.0 * root2, 400.0 * root2, 4000.0 * root2, 80_000.0 * root2);
    assert!((total(&program, &machine) - expected).abs() < 1e-9);
    // A rotary joint alone.
    let program = Program::default().g0(&[('B', 1.5)]);
    let r = std::f64::consts::PI;
    let expected = rest_to_rest(1.5, r, 4.0 * r, 80.0 * r);
    assert!((total(&program, &machine) - expected).abs() < 1e-9);
}

#[test]
fn trapezoid_without_jerk_limit_and_step_without_any() {
    let mut machine = bc_machine();
    for joint in &mut machine.joints {
        joint.max_jerk = None;
    }
    for d in [0.5, 10.0, 200.0] {
        let program = Program::default().feed(100.0).g1(&[('Y', d)]);
        let t = total(&program, &machine);
        let expected = rest_to_rest(d, 100.0, 4000.0, f64::INFINITY);
        assert!((t - expected).abs() < 1e-10, "{t} {expected}");
    }
    for joint in &mut machine.joints {
        joint.max_acceleration = None;
    }
    let r = run(&Program::default().feed(100.0).g1(&[('Y', 50.0)]), &machine);
    assert!((r.summary.total_s - 0.5).abs() < 1e-12);
    assert_eq!(r.summary.unlimited_joints.len(), 5);
    assert!(r.summary.unlimited_joints.iter().all(|u| u.acceleration && u.jerk && !u.velocity));
}

#[test]
fn full_circle_runs_at_constant_feed() {
    let machine = bc_machine();
    let (r, f) = (20.0, 50.0);
    let program = Program::default().exact_stop().g0(&[('X', r)]).feed(f).arc_xy(
        &[('X', r), ('Y', 0.0)],
        [0.0; 3],
        r,
        std::f64::consts::TAU,
    );
    let out = run(&program, &machine);
    let arc = out.all.blocks.iter().find(|b| b.kind == BlockKind::Move(MoveKind::Feed)).expect("the arc");
    assert!((arc.length - std::f64::consts::TAU * r).abs() < 1e-9);
    let constant = out.all.samples.iter().filter(|s| s.block == arc.index && (s.feed - f).abs() < 1e-6 * f).count();
    // Centripetal 125 mm/s² of 4000: the feed is reached and held over nearly the whole length.
    assert!(constant as f64 * 0.002 > 0.95 * (arc.length / f));
    for s in out.all.samples.iter().filter(|s| s.block == arc.index) {
        assert!((s.commanded[0].hypot(s.commanded[1]) - r).abs() < 1e-9);
    }
    // Rest to rest with the path limits of the slowest direction; the bound needs no jerk.
    let fastest = rest_to_rest(arc.length, f, 4000.0, f64::INFINITY);
    let slowest = rest_to_rest(arc.length, f, 0.7 * 4000.0, 0.5 * 80_000.0);
    let t = arc.end_time - arc.start_time;
    assert!(t > fastest && t < slowest, "{fastest} {t} {slowest}");
}

#[test]
fn dwell_and_inverse_time() {
    let machine = bc_machine();
    let program = Program::default().op(Op::Dwell(Dwell::Seconds(0.75)));
    let out = run(&program, &machine);
    assert_eq!(out.summary.total_s, 0.75);
    assert_eq!(out.summary.dwell_s, 0.75);
    assert!(out.all.events.iter().any(|e| matches!(e, Event::Dwell { duration, .. } if *duration == 0.75)));
    // G93: 10 mm in 2 s is 5 mm/s.
    let program = Program::default().op(Op::Feed(proveout_nc::Feed::InverseTime(2.0))).g1(&[('X', 10.0)]);
    let expected = rest_to_rest(10.0, 5.0, 4000.0, 80_000.0);
    assert!((total(&program, &machine) - expected).abs() < 1e-9);
}

#[test]
fn exact_stop_adds_up_and_blocks_in_line_do_not_stop() {
    let machine = bc_machine();
    let steps: Vec<f64> = (1..=10).map(|k| f64::from(k) * 7.0).collect();
    let mut stopped = Program::default().exact_stop().feed(80.0);
    let mut through = Program::default().continuous(0.01).feed(80.0);
    for &x in &steps {
        stopped = stopped.g1(&[('X', x), ('Y', 0.5 * x)]);
        through = through.g1(&[('X', x), ('Y', 0.5 * x)]);
    }
    let s = 1.25_f64.sqrt();
    let (a, j) = (4000.0 * s, 80_000.0 * s);
    assert!((total(&stopped, &machine) - 10.0 * rest_to_rest(7.0 * s, 80.0, a, j)).abs() < 1e-8);
    assert!((total(&through, &machine) - rest_to_rest(70.0 * s, 80.0, a, j)).abs() < 1e-8);
}

#[test]
fn a_step_of_the_feed_costs_one_ramp() {
    let machine = bc_machine();
    let program = Program::default().continuous(0.01).feed(30.0).g1(&[('X', 100.0)]).feed(90.0).g1(&[('X', 300.0)]);
    // Ramps 0-30, 30-90, 90-0 in their own places: distances by the mean speed.
    let ramp = |dv: f64| if dv > 200.0 { unreachable!() } else { 2.0 * (dv / 80_000.0).sqrt() };
    let (t1, t2, t3) = (ramp(30.0), ramp(60.0), ramp(90.0));
    let first = t1 + (100.0 - 15.0 * t1) / 30.0;
    let second = t2 + t3 + (200.0 - 60.0 * t2 - 45.0 * t3) / 90.0;
    assert!((total(&program, &machine) - first - second).abs() < 1e-9);
}
