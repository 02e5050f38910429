//! Feed, length, ratio and time are those of the path that is run; bounds hold for the paths that they name.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::path::Path;

use crate::common::{Program, Random, Run, bc_machine, for_all, limit_use, run_with, tool};
use proveout_controller::{Dynamics, MoveKind, Sample, Settings};
use proveout_machine::Machine;

fn three_axis() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/three-axis-mill");
    let mut machine = Machine::read(&folder).expect("library machine");
    // The programs begin where the machine is.
    machine.joints.iter_mut().for_each(|joint| joint.home = 0.0);
    machine
}

/// Steps of 2 mm to and fro between X and Y.
fn stairs(steps: u32, tolerance: f64, feed: f64) -> Program {
    let mut program = Program::default().continuous(tolerance).feed(feed);
    let mut at = [0.0, 0.0];
    for k in 0..steps {
        let axis = (k % 2) as usize;
        at[axis] += 2.0;
        program = program.g1(&[(['X', 'Y'][axis], at[axis])]);
    }
    program
}

fn in_feed(run: &Run) -> Vec<&Sample> {
    run.all.samples.iter().filter(|s| s.kind == MoveKind::Feed).collect()
}

/// Way of the tip against the table between samples.
fn chords(samples: &[&Sample]) -> f64 {
    samples.windows(2).map(|w| (w[1].pose.tip - w[0].pose.tip).norm()).sum()
}

#[test]
fn stairs_are_cut_at_the_feed_and_measured_on_the_path_that_is_run() {
    for (machine, feed) in [(three_axis(), 10.0), (bc_machine(), 10.0), (bc_machine(), 25.0)] {
        let run = run_with(&stairs(60, 0.75, feed), &machine, &[], &Settings::default());
        let s = &run.summary;
        let samples = in_feed(&run);
        let first = samples.iter().position(|s| s.feed > 0.999 * feed).expect("the feed is reached");
        let last = samples.iter().rposition(|s| s.feed > 0.999 * feed).expect("the feed is reached");
        let feeds = || samples[first..=last].iter().map(|s| s.feed);
        let (low, high) = (feeds().fold(f64::INFINITY, f64::min), feeds().fold(0.0, f64::max));
        let ratio = s.min_feed_ratio.expect("a motion in feed");
        println!(
            "{feed} mm/s: {:.3} mm in {:.3} s, feed {low:.3} to {high:.3}, ratio {ratio:.4}, bounds {:?} {:?}",
            s.length_mm, s.cutting_s, s.lower_bound_s, s.path_bound_s
        );
        assert!(s.length_mm < 118.0, "the corners are rounded: {}", s.length_mm);
        let seen = chords(&samples);
        assert!((seen - s.length_mm).abs() < 2e-3 * s.length_mm, "{seen} mm of samples, {} mm told", s.length_mm);
        let path_length: f64 = run.all.blocks.iter().map(|b| b.length).sum();
        let programmed: f64 = run.all.blocks.iter().map(|b| b.programmed_length).sum();
        assert!(
            (path_length - s.length_mm).abs() < 1e-9 && (programmed - 120.0).abs() < 1e-9,
            "{path_length} {programmed}"
        );
        // Joints that permit the feed: 10 mm/s over a corner of half a millimeter needs a tenth of the
        // acceleration.
        assert!(low > 0.99 * feed && high < 1.001 * feed, "{low} {high}");
        assert!(ratio > 0.99, "{ratio}");
        // Ramps from and to rest take less than 0.05 s.
        let at_feed = s.length_mm / feed;
        assert!(s.cutting_s >= at_feed * 0.9995 && s.cutting_s < at_feed + 0.05, "{} {at_feed}", s.cutting_s);
        // The programmed length at the feed is no bound of this path: 12 s at 10 mm/s.
        let path = s.path_bound_s.expect("bounded");
        assert!(path <= s.total_s && path > 0.98 * s.total_s && path < 118.0 / feed, "{path} {}", s.total_s);
        let use_of = limit_use(&run, &machine, machine.control.cycle_time);
        assert!(use_of.velocity <= 1.001 && use_of.acceleration <= 1.001 && use_of.jerk <= 1.001, "{use_of:?}");
    }
}

/// A control that blends with arcs of the largest radius that half a step allows needs pi/2 mm for each
/// corner and stays within 0.75 mm; one that goes straight along the diagonal needs less still. Both are
/// legal, and no bound may lie above them.
#[test]
fn faster_paths_within_the_tolerance_do_not_beat_the_bound() {
    let machine = three_axis();
    let feed = 10.0;
    let s = run_with(&stairs(60, 0.75, feed), &machine, &[], &Settings::default()).summary;
    let bound = s.lower_bound_s.expect("bounded");
    let arcs = (59.0 * std::f64::consts::FRAC_PI_2 + 2.0) / feed;
    // From the start to the middle line between both rows of corners within some steps, along it, and to the
    // end: 0.7072 mm off at most.
    let diagonal = (60.0_f64.hypot(60.0) + 0.3) / feed;
    println!(
        "bound {bound:.3} s, arcs {arcs:.3} s, diagonal {diagonal:.3} s; on the path that is run {:?}",
        s.path_bound_s
    );
    assert!(arcs > 9.4 && bound <= diagonal && bound < arcs, "{bound}");
    assert!(bound > 0.95 * diagonal, "of some use: {bound} of {diagonal}");
    assert!(s.path_bound_s.expect("bounded") > arcs, "the bound on one path is none for all");
}

/// Programs made of a smooth curve and noise within the tolerance: the curve itself is a legal path. Without
/// limits of acceleration it takes its length over the feed.
#[test]
fn the_curve_behind_a_noisy_program_is_never_faster_than_the_bound() {
    let mut machine = bc_machine();
    for joint in &mut machine.joints {
        joint.max_acceleration = None;
        joint.max_jerk = None;
    }
    let count = std::env::var("PROVEOUT_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(60);
    let least = std::sync::Mutex::new(f64::INFINITY);
    for_all(0..count, |seed| {
        let mut r = Random::new(seed + 70_000);
        let tcp = r.unit() < 0.5;
        let tolerance = 10_f64.powf(r.range(-3.0, 0.0));
        let orientation = 10_f64.powf(r.range(-4.0, -2.0));
        let step = 10_f64.powf(r.range(-1.5, 1.0));
        let radius = 10_f64.powf(r.range(0.5, 2.0));
        let feed = 10_f64.powf(r.range(0.0, 1.5));
        // Sharp corners and reversals of the curve itself every now and then.
        let corners = r.unit() < 0.3;
        let tools = [tool(1, 120.0)];
        let start = [('X', 0.0), ('Y', 0.0), ('Z', 150.0), ('B', 0.5), ('C', 0.0)];
        let mut program = Program::default().change(1).g0(&[('Z', 350.0)]).g0(&start[3..]).tcp(tcp).g0(&start);
        program = program.exact_stop().g1_at_feed(&start, feed);
        program = program.op(proveout_nc::Op::PathMode(proveout_nc::PathMode::Continuous {
            tolerance: Some(tolerance),
            orientation_tolerance: Some(orientation),
        }));
        let (mut heading, mut at) = (0.0_f64, [0.0, 0.0, 150.0, 0.5, 0.0]);
        let mut length = 0.0;
        let blocks = 150;
        for k in 1..=blocks {
            heading += step / radius;
            if corners && r.unit() < 0.05 {
                heading += r.range(-3.2, 3.2);
            }
            at[0] += step * heading.cos();
            at[1] += step * heading.sin();
            at[3] = 0.5 + 0.02 * (0.1 * f64::from(k)).sin();
            length += step;
            let mut noisy = at;
            if k < blocks {
                // Within the tolerance in any direction, forth and back along the path as well.
                let way: [f64; 3] = std::array::from_fn(|_| r.range(-1.0, 1.0));
                let size = way.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
                let off = 0.99 * tolerance * r.unit();
                (0..3).for_each(|i| noisy[i] += off * way[i] / size);
                (3..5).for_each(|i| noisy[i] += 0.99 * orientation * r.range(-1.0, 1.0));
            }
            let values: Vec<(char, f64)> = "XYZBC".chars().zip(noisy).collect();
            program = program.g1(&values);
        }
        let run = run_with(&program, &machine, &tools, &Settings::default());
        // What comes before the curve: the same program without it.
        let before = Program { commands: program.commands[..program.commands.len() - blocks as usize].to_vec() };
        let before = run_with(&before, &machine, &tools, &Settings::default()).summary;
        let [bound, ahead] = [&run.summary, &before].map(|s| s.lower_bound_s.expect("bounded"));
        let (bound, legal) = (bound - ahead, length / feed);
        assert!(
            bound <= legal * (1.0 + 1e-9),
            "seed {seed}: {bound} s claimed, {legal} s possible (tcp {tcp}, tolerance {tolerance}, steps of {step} mm)"
        );
        assert!(run.summary.lower_bound_s <= Some(run.summary.total_s));
        assert!(run.summary.lower_bound_s <= run.summary.path_bound_s);
        if !corners && length > 2e3 * tolerance && radius > 300.0 * tolerance {
            let mut least = least.lock().expect("no other thread has failed");
            *least = least.min(bound / legal);
        }
    });
    let least = least.into_inner().expect("no thread has failed");
    println!("smooth curves: the bound is at least {least:.4} of what is possible");
    assert!(least > 0.9, "{least}");
}

/// Where the program stops the machine, ramps count; where it does not, they do not.
#[test]
fn stops_that_the_program_asks_for_count_and_those_of_this_control_do_not() {
    let machine = bc_machine();
    let bound = |program: &Program| {
        let s = run_with(program, &machine, &[], &Settings::default()).summary;
        (s.lower_bound_s.expect("bounded"), s.total_s)
    };
    // 100 mm at 20 mm/s and 4000 mm/s2, rest to rest; the feed may be passed by half a thousandth.
    let line = Program::default().exact_stop().feed(20.0).g1(&[('X', 100.0)]);
    let rest_to_rest = |d: f64| d / 20.0 / 1.0005 + 20.0 * 1.0005 / 4000.0;
    assert!((bound(&line).0 - rest_to_rest(100.0)).abs() < 1e-9, "{}", bound(&line).0);
    let stops = Program::default().exact_stop().feed(20.0).g1(&[('X', 50.0)]).g1(&[('X', 100.0)]);
    assert!((bound(&stops).0 - 2.0 * rest_to_rest(50.0)).abs() < 1e-9);
    // A reversal is a stop of this control: another one may turn back within the tolerance.
    let tolerance = 0.3;
    let back = Program::default().continuous(tolerance).feed(20.0).g1(&[('X', 50.0)]).g1(&[('X', 0.0)]);
    let (lower, total) = bound(&back);
    let shortcut = 2.0 * (50.0 - tolerance) / 20.0;
    assert!(lower <= shortcut + 20.0 / 4000.0 + 1e-9 && lower > 0.99 * shortcut && lower < total, "{lower} {shortcut}");
    // A rapid motion of several joints: the slowest of them.
    let rapid = Program::default().exact_stop().g0(&[('X', 200.0), ('B', 3.0)]);
    let r = std::f64::consts::PI;
    let slowest = (200.0 / 400.0 + 400.0 / 4000.0_f64).max(3.0 / r + r / (4.0 * r));
    assert!((bound(&rapid).0 - slowest).abs() < 1e-9, "{} {slowest}", bound(&rapid).0);
    // Dwell and tool change take their time.
    let dwell = Program::default().change(1).op(proveout_nc::Op::Dwell(proveout_nc::Dwell::Seconds(0.7)));
    let tools = [tool(1, 100.0)];
    let s = run_with(&dwell, &machine, &tools, &Settings::default()).summary;
    assert!(s.lower_bound_s.is_some_and(|b| (b - 4.7).abs() < 1e-9) && s.lower_bound_s == s.path_bound_s);
}

/// Feed, length and samples of random programs agree.
#[test]
fn the_feed_of_the_samples_is_their_way_by_time_and_never_above_the_program() {
    let machine = bc_machine();
    let count = std::env::var("PROVEOUT_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(60);
    for_all(0..count, |seed| {
        let mut r = Random::new(seed + 90_000);
        let tcp = seed % 3 == 0;
        let start = [('X', 0.0), ('Y', 0.0), ('Z', 150.0), ('B', 0.4), ('C', 0.0)];
        let mut program = Program::default().change(1).g0(&[('Z', 350.0)]).g0(&start[3..]).tcp(tcp).g0(&start);
        program = program.exact_stop().g1_at_feed(&start, 20.0).continuous(10_f64.powf(r.range(-3.0, 0.0)));
        let (mut at, mut heading) = ([0.0, 0.0, 150.0, 0.4, 0.0], 0.0_f64);
        let step = 10_f64.powf(r.range(-1.0, 1.3));
        for k in 0..60 {
            if k % 15 == 0 {
                program = program.feed(10_f64.powf(r.range(0.5, 2.2)));
            }
            // Gentle, sharp and reversing corners; rotary joints with the tip and alone.
            heading += match seed % 4 {
                0 => r.range(-0.2, 0.3),
                1 => r.range(-1.7, 1.7),
                _ => r.range(-3.2, 3.2) * r.unit(),
            };
            let alone = tcp && r.unit() < 0.05;
            if !alone {
                at[0] += step * heading.cos();
                at[1] += step * heading.sin();
            }
            if tcp {
                at[3] = (at[3] + r.range(-0.05, 0.05)).clamp(-1.0, 1.0);
                at[4] += r.range(-0.05, 0.05);
            }
            let values: Vec<(char, f64)> = "XYZBC".chars().zip(at).collect();
            program = program.g1(if tcp { &values } else { &values[..2] });
        }
        let run = run_with(&program, &machine, &[tool(1, 120.0)], &Settings::default());
        let samples = in_feed(&run);
        for s in &samples {
            let most = s.feed_programmed * 1.001;
            assert!(s.feed <= most, "seed {seed} at {} s: {} of {}", s.time, s.feed, s.feed_programmed);
        }
        // Blocks of rotary motion alone have lengths in degrees and are no part of the tip's way.
        let lengths: f64 =
            run.all.blocks.iter().filter(|b| b.kind != proveout_controller::BlockKind::Dwell).map(|b| b.length).sum();
        let last = run.all.samples.last().map_or(0.0, |s| s.path_length);
        assert!((lengths - last).abs() < 1e-6 * lengths.max(1.0), "seed {seed}: {lengths} {last}");
        for w in samples.windows(2).filter(|w| w[0].block == w[1].block && w[1].time - w[0].time < 0.003) {
            let way = w[1].path_length - w[0].path_length;
            let mean = 0.5 * (w[0].feed + w[1].feed) * (w[1].time - w[0].time);
            // The rule of trapezoids: acceleration along the path up to 4000 * 3 mm/s2 changes within a cycle
            // of 2 ms.
            assert!((way - mean).abs() < 2e-3 * mean + 3e-3, "seed {seed} at {}: {way} {mean}", w[0].time);
            let tip = (w[1].pose.tip - w[0].pose.tip).norm();
            assert!(
                !tcp || tip <= way + 1e-6 || w[0].feed_programmed == 0.0,
                "seed {seed} at {}: {tip} {way}",
                w[0].time
            );
        }
        assert!(run.summary.min_feed_ratio.is_some_and(|ratio| ratio > 0.0 && ratio <= 1.0));
    });
}

/// A corner that the joints cannot pass at the feed is reported as the samples show it.
#[test]
fn the_least_feed_ratio_is_that_of_the_slowest_corner() {
    let machine = bc_machine();
    let program = Program::default()
        .continuous(0.01)
        .feed(100.0)
        .g1(&[('X', 60.0)])
        .g1(&[('X', 100.0), ('Y', 50.0)])
        .g1(&[('X', 100.0), ('Y', 120.0)]);
    let run = run_with(&program, &machine, &[], &Settings::default());
    let samples = in_feed(&run);
    let reached = |s: &&Sample| s.feed > 99.9;
    let (first, last) = (samples.iter().position(reached), samples.iter().rposition(reached));
    let between = &samples[first.expect("reached")..=last.expect("reached")];
    let slowest = between.iter().map(|s| s.feed).fold(f64::INFINITY, f64::min);
    let ratio = run.summary.min_feed_ratio.expect("a motion in feed");
    println!("slowest {slowest:.3} of 100 mm/s, told {ratio:.4}");
    assert!(slowest < 60.0 && (ratio - slowest / 100.0).abs() < 1e-9, "{slowest} {ratio}");
    // Half a millimeter at 400 mm/s is not enough way to reach it.
    let program = Program::default().exact_stop().feed(400.0).g1(&[('X', 0.5)]);
    let run = run_with(&program, &machine, &[], &Settings::default());
    let most = in_feed(&run).iter().map(|s| s.feed).fold(0.0, f64::max);
    assert!(run.summary.min_feed_ratio.is_some_and(|ratio| (ratio - most / 400.0).abs() < 1e-9 && ratio < 0.2));
    // Joints that are too slow for the feed.
    let program = Program::default().exact_stop().feed(600.0).g1(&[('X', 300.0)]);
    let run = run_with(&program, &machine, &[], &Settings::default());
    assert!(run.summary.min_feed_ratio.is_some_and(|ratio| (ratio - 400.0 / 600.0).abs() < 1e-6));
}

/// Independent joints in rapid motion: the way of the tip is no straight line, and is reported as it is.
#[test]
fn a_dog_leg_is_as_long_as_it_is() {
    let mut machine = bc_machine();
    machine.control.rapid_mode = proveout_machine::RapidMode::IndependentJoints;
    let run = run_with(&Program::default().g0(&[('X', 300.0), ('Y', 30.0)]), &machine, &[], &Settings::default());
    let all: Vec<&Sample> = run.all.samples.iter().collect();
    let s = &run.summary;
    assert!((chords(&all) - s.length_mm).abs() < 0.01 * s.length_mm, "{} {}", chords(&all), s.length_mm);
    assert!(s.length_mm > 300.0_f64.hypot(30.0) + 5.0 && s.length_mm < 330.0, "{}", s.length_mm);
    let last = run.all.samples.last().map_or(0.0, |s| s.path_length);
    assert!((last - s.length_mm).abs() < 0.01, "{last}");
}

/// The programmed path in the geometry, the plan in everything about time.
#[test]
fn ideal_dynamics_have_the_feed_and_the_length_of_the_plan() {
    let machine = bc_machine();
    let program = stairs(20, 0.3, 15.0);
    let run = |dynamics| run_with(&program, &machine, &[], &Settings { dynamics, ..Settings::default() });
    let (planned, ideal) = (run(Dynamics::Planned), run(Dynamics::Ideal));
    assert_eq!(planned.all.blocks, ideal.all.blocks);
    assert_eq!(planned.summary.length_mm, ideal.summary.length_mm);
    assert_eq!(planned.summary.min_feed_ratio, ideal.summary.min_feed_ratio);
    for (a, b) in planned.all.samples.iter().zip(&ideal.all.samples) {
        assert!(a.feed == b.feed && a.path_length == b.path_length);
    }
}
