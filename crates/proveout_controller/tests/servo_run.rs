//! Whole runs with drives that lag: order, streaming, cuts along the actual motion,
//! refusals.

#![allow(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use crate::common;
use std::path::Path;

use crate::common::{Program, Run, run_with, tool};
use proveout_controller::{Controller, Dynamics, Event, LimitKind, Settings, servo::Plant};
use proveout_geom::Point;
use proveout_machine::{Encoder, Machine};
use proveout_nc::{Dwell, Op};

fn library(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name))
        .expect("the library machine")
}

fn servo() -> Settings {
    Settings { dynamics: Dynamics::Servo, ..Settings::default() }
}

/// All five axes, with rapids, a tool change and a dwell.
fn five_axes(blocks: u32) -> Program {
    let mut p = Program::default().change(1).g0(&[('X', 0.0), ('Y', 0.0)]).g0(&[('Z', 420.0), ('B', 0.5), ('C', 0.0)]);
    p = p.tcp(true).continuous(0.01).feed(50.0);
    for k in 0..blocks {
        let a = f64::from(k) * 0.02;
        let point = [
            ('X', 40.0 * a.cos()),
            ('Y', 40.0 * a.sin()),
            ('Z', 150.0 + 5.0 * (3.0 * a).sin()),
            ('B', 0.4 + 0.1 * a.cos()),
            ('C', 0.5 * a),
        ];
        p = p.g1(&point);
    }
    p.op(Op::Dwell(Dwell::Seconds(0.3))).tcp(false).g0(&[('Z', 600.0)])
}

fn tools() -> [proveout_tool::Tool; 2] {
    [tool(1, 120.0), tool(2, 90.0)]
}

fn check_stream(name: &str, run: &Run) {
    let pieces = &run.all.pieces;
    for pair in pieces.windows(2) {
        assert!(pair[1].time[0] >= pair[0].time[1], "{name}: pieces overlap at {:?}", pair[1].time);
        assert!(pair[1].block >= pair[0].block, "{name}: blocks out of order");
        // A tool at rest has no pieces: it may creep by rounding.
        assert!((pair[1].joints[0] - pair[0].joints[1]).max_abs() < 1e-7, "{name}: a jump at {:?}", pair[1].time);
    }
    assert!(run.all.samples.windows(2).all(|w| w[0].time < w[1].time));
    assert!(run.all.blocks.windows(2).all(|w| w[0].index < w[1].index));
    assert!(run.all.events.windows(2).all(|w| w[0].time() <= w[1].time()));
}

#[test]
fn the_plan_stays_as_it_is_and_the_joints_follow() {
    for name in ["spinner-u5-620", "ac-trunnion-620"] {
        let machine = library(name);
        let mut program = five_axes(150);
        if name.starts_with("ac") {
            for command in &mut program.commands {
                if let Op::Linear(m) | Op::Rapid(m) = &mut command.op
                    && let Some(b) = m.end.get(4)
                {
                    for values in [&mut m.end, &mut m.end_base] {
                        *values = common::axes(
                            &"XYZABC"
                                .chars()
                                .zip(0..)
                                .filter_map(|(c, k)| values.get(k).filter(|_| c != 'B').map(|v| (c, v)))
                                .chain([('A', -b)])
                                .collect::<Vec<_>>(),
                        );
                    }
                }
            }
        }
        let planned = run_with(&program, &machine, &tools(), &Settings::default());
        let run = run_with(&program, &machine, &tools(), &servo());
        check_stream(name, &run);
        assert_eq!(run.summary.total_s, planned.summary.total_s);
        assert_eq!(run.all.blocks, planned.all.blocks);
        assert_eq!(run.all.samples.len(), planned.all.samples.len());
        for (a, b) in run.all.samples.iter().zip(&planned.all.samples) {
            assert_eq!((a.time, a.commanded, a.block), (b.time, b.commanded, b.block));
        }
        let s = &run.summary;
        for (joint, m) in s.joints.iter().zip(&machine.joints) {
            let used = joint.drive.expect("drives");
            // With full feed-forward, what is left comes from friction, elasticity and changes of load.
            let bound = if m.is_rotary() { 0.05_f64.to_radians() } else { 0.08 };
            assert!(used.max_following_error > 0.0 && used.max_following_error < bound, "{name} {}: {used:?}", m.name);
            assert!(used.force_utilisation.is_some_and(|u| u > 0.001 && u < 0.999), "{name} {}: {used:?}", m.name);
        }
        let contour = s.max_servo_contour_error_mm.expect("drives");
        assert!(contour > 1e-4 && contour < 0.1, "{name}: {contour}");
        let loads = s.loads.as_ref().expect("drives");
        assert!(loads.unknown.is_empty() && loads.no_force_limit.is_empty() && !loads.estimated.is_empty());
        assert!(!run.all.events.iter().any(|e| matches!(e, Event::Limit { kind: LimitKind::DriveForce, .. })));
        println!(
            "{name}: following {:?}",
            s.joints.iter().map(|j| j.drive.expect("drives").max_following_error).collect::<Vec<_>>()
        );
    }
}

/// Every control sample lies on the piece of its time, and pieces keep their own bound.
#[test]
fn pieces_run_along_the_actual_joints() {
    let machine = library("spinner-u5-620");
    let run = run_with(&five_axes(150), &machine, &tools(), &servo());
    let mut at = 0;
    let mut checked = 0;
    let settings = Settings::default();
    for sample in &run.all.samples {
        while at + 1 < run.all.pieces.len() && run.all.pieces[at].time[1] < sample.time {
            at += 1;
        }
        let p = &run.all.pieces[at];
        if sample.time < p.time[0] || sample.time > p.time[1] {
            continue;
        }
        // Nearest place on the straight piece.
        let way = p.pose[1].tip - p.pose[0].tip;
        let t = if way.norm() > 0.0 { (sample.pose.tip - p.pose[0].tip).dot(&way) / way.norm_squared() } else { 0.0 };
        let on = p.pose[0].tip + way * t.clamp(0.0, 1.0);
        assert!(
            (sample.pose.tip - on).norm() <= p.deviation + 1e-9,
            "{}: {}",
            sample.time,
            (sample.pose.tip - on).norm()
        );
        // The bound between samples adds little to what the pieces may leave.
        assert!(p.deviation <= settings.piece_tolerance * 2.0, "{}", p.deviation);
        checked += 1;
    }
    assert!(checked > 500, "{checked}");
}

#[test]
fn without_feed_forward_the_tool_lags_and_goes_on_after_the_plan_stands() {
    let mut machine = library("spinner-u5-620");
    for joint in &mut machine.joints {
        let drive = joint.drive.as_mut().expect("a drive");
        (drive.velocity_feed_forward, drive.acceleration_feed_forward) = (0.0, 0.0);
        (drive.elastic, drive.encoder, drive.motor_inertia) = (None, Encoder::Motor, None);
    }
    let feed = 60.0;
    let p = Program::default().g0(&[('X', -100.0), ('Y', 0.0)]).feed(feed).g1(&[('X', 100.0)]);
    let p = p.op(Op::Dwell(Dwell::Seconds(1.0))).g1(&[('Y', 10.0)]);
    let run = run_with(&p, &machine, &[], &servo());
    check_stream("lag", &run);
    let mut cruise = run.all.samples.iter().filter(|s| s.velocity[0] == feed && s.acceleration[0] == 0.0);
    let last = cruise.next_back().expect("a stretch at constant feed");
    assert!((last.commanded[0] - last.actual[0] - feed / 50.0).abs() < 1e-6, "{}", last.commanded[0] - last.actual[0]);
    // Pieces go on into the dwell, and come to the end point.
    let dwell = run.all.blocks.iter().find(|b| b.length == 0.0 && b.end_time - b.start_time > 0.9).expect("the dwell");
    let late: Vec<_> = run.all.pieces.iter().filter(|p| p.block == dwell.index).collect();
    assert!(late.len() > 3, "{}", late.len());
    assert!((late[late.len() - 1].joints[1][0] - 100.0).abs() < 2e-3);
    assert!(run.all.pieces.iter().any(|p| p.time[0] > run.summary.total_s), "the machine comes to rest after the end");
}

#[test]
fn the_same_run_in_windows_and_again_is_the_same() {
    let machine = library("spinner-u5-620");
    let mut p = Program::default().g0(&[('X', 0.0), ('Y', 0.0)]).continuous(0.02).feed(80.0);
    let mut heading = 0.0_f64;
    let (mut x, mut y) = (0.0, 0.0);
    for k in 0..900 {
        heading += 0.3 * (f64::from(k) * 0.37).sin() + 0.02;
        (x, y) = (x + 1.5 * heading.cos(), y + 1.5 * heading.sin());
        p = p.g1(&[('X', x), ('Y', y)]);
    }
    let with = |look_ahead_blocks| run_with(&p, &machine, &[], &Settings { look_ahead_blocks, ..servo() });
    let (whole, windows, again) = (with(100_000), with(200), with(200));
    assert!(windows.chunks > 3, "{}", windows.chunks);
    assert_eq!(windows.all, again.all);
    check_stream("windows", &windows);
    // What lies more than half a second ahead of a window changes times by parts in 1e5, so that samples do
    // not fall on each other; blocks do, and the machine comes to rest at the same place.
    let (a, b) = (whole.summary.total_s, windows.summary.total_s);
    println!("in windows {b} s, whole {a} s");
    assert!((b - a).abs() < 1e-3 * a, "{a} {b}");
    assert_eq!(whole.all.blocks.len(), windows.all.blocks.len());
    let rest = |run: &Run| run.all.samples.last().expect("samples").actual;
    // Dry friction holds a joint up to Fc / (Kv loop stiffness) off its end; which side depends on the last
    // micrometers.
    assert!((rest(&whole) - rest(&windows)).max_abs() < 1e-5, "{:?} {:?}", rest(&whole), rest(&windows));
}

#[test]
fn a_weak_drive_saturates_and_says_so_with_its_block() {
    let mut machine = library("spinner-u5-620");
    let x = machine.joint("X").expect("X");
    machine.joints[x].drive.as_mut().expect("a drive").max_force = Some(2500.0);
    let p = Program::default().g0(&[('X', 100.0)]).g0(&[('Y', 0.0)]).g0(&[('X', -100.0)]);
    let run = run_with(&p, &machine, &[], &servo());
    let limit_events: Vec<_> = run
        .all
        .events
        .iter()
        .filter_map(|e| match e {
            Event::Limit { joint, value, limit, block, kind: LimitKind::DriveForce, .. } => {
                Some((*joint, *value, *limit, *block))
            }
            _ => None,
        })
        .collect();
    // Block 1 moves Y alone; X may still come back from where it was left.
    let blocks: Vec<u32> = limit_events.iter().map(|t| t.3).collect();
    assert!(
        limit_events.iter().all(|t| t.0 == Some(x)) && blocks.contains(&0) && blocks.contains(&2),
        "{limit_events:?}"
    );
    assert!(blocks.windows(2).all(|b| b[0] < b[1]), "one event a block: {limit_events:?}");
    assert!(limit_events.iter().all(|t| t.1.abs() > 2500.0 && (t.2.abs() - 2500.0).abs() < 1e-6 && t.1 * t.2 > 0.0));
    let used = run.summary.joints[x].drive.expect("drives");
    assert!(used.force_utilisation.is_some_and(|u| u <= 1.0 + 1e-12 && u > 0.999) && used.max_following_error > 0.1);
    assert!(run.all.samples.iter().all(|s| s.drive.expect("drives").force[x].abs() <= 2500.0 + 1e-6));
}

#[test]
fn rapier_as_plant_gives_nearly_the_same_motion() {
    let machine = library("spinner-u5-620");
    let program = five_axes(30);
    let own = run_with(&program, &machine, &tools(), &servo());
    let other = run_with(&program, &machine, &tools(), &Settings { plant: Plant::Rapier, ..servo() });
    check_stream("rapier", &other);
    let (mut apart, mut force) = ([0.0_f64; 5], [0.0_f64; 5]);
    for (a, b) in own.all.samples.iter().zip(&other.all.samples) {
        for j in 0..5 {
            apart[j] = apart[j].max((a.actual[j] - b.actual[j]).abs());
            let (fa, fb) = (a.drive.expect("drives").force[j], b.drive.expect("drives").force[j]);
            let most = machine.joints[j].drive.as_ref().and_then(|d| d.max_force).expect("a limit");
            force[j] = force[j].max((fa - fb).abs() / most);
        }
    }
    println!("apart {apart:?}, forces {force:?} of the limit");
    for j in 0..5 {
        // The law is sampled at 0.1 ms there and continuous here; rapid motion at 0.5 g lies between.
        let bound = if machine.joints[j].is_rotary() { 2e-4 } else { 0.03 };
        assert!(apart[j] < bound, "{apart:?}");
        assert!(force[j] < 0.15, "{force:?}");
    }
}

#[test]
fn the_tool_in_the_spindle_counts_for_tip_and_pieces() {
    let machine = library("spinner-u5-620");
    let p = Program::default().change(1).g0(&[('X', 0.0), ('Z', 500.0)]).change(2).g0(&[('X', 50.0), ('Z', 500.0)]);
    let run = run_with(&p, &machine, &tools(), &servo());
    for piece in &run.all.pieces {
        for (q, pose) in piece.joints.iter().zip(&piece.pose) {
            let lengths = [0.0, 120.0, 90.0];
            assert!(lengths.iter().any(|l| (machine.forward(q, *l).tip - pose.tip).norm() < 1e-9));
        }
    }
    let last = run.all.samples.last().expect("samples");
    assert!((last.pose.tip - machine.forward(&last.actual, 90.0).tip).norm() < 1e-12);
    assert!((last.pose.tip - Point::new(50.0, last.pose.tip.y, 500.0)).norm() < 0.02, "{}", last.pose.tip);
}

#[test]
fn a_machine_without_drives_is_refused_with_key_and_remedy() {
    let refused = |machine: &Machine, settings: &Settings| match Controller::new(
        Program::default().source(),
        machine,
        &[],
        settings.clone(),
    ) {
        Ok(_) => panic!("not refused"),
        Err(e) => *e,
    };
    let e = refused(&common::bc_machine(), &servo());
    assert_eq!(e.code, "control-servo");
    let text = e.to_string();
    assert!(text.contains("joint X") && text.contains("[joint.drive]") && text.contains("planned"), "{text}");

    let mut machine = library("spinner-u5-620");
    for body in &mut machine.bodies {
        body.mass = None;
    }
    let text = refused(&machine, &servo()).to_string();
    assert!(text.contains("moving_mass_kg") && text.contains("has no mass"), "{text}");
    // With the moved masses stated it runs; loads by weight and coupling are then not known, and the summary
    // says so.
    for joint in &mut machine.joints {
        joint.moving_inertia = Some(if joint.is_rotary() { 2e7 } else { 500.0 });
    }
    let run = run_with(&Program::default().g0(&[('X', 10.0)]), &machine, &[], &servo());
    assert_eq!(run.summary.loads.expect("drives").unknown.len(), 5);
    let text = refused(&machine, &Settings { plant: Plant::Rapier, ..servo() }).to_string();
    assert!(text.contains("newton-euler"), "{text}");

    let mut machine = library("spinner-u5-620");
    machine.joints[0].drive.as_mut().expect("a drive").position_gain = 900.0;
    let text = refused(&machine, &servo()).to_string();
    assert!(text.contains("not stable"), "{text}");
    machine.joints[0].drive.as_mut().expect("a drive").position_gain = f64::NAN;
    refused(&machine, &servo());
}

#[test]
fn limits_that_are_not_stated_do_not_stop_the_drives() {
    let mut machine = library("spinner-u5-620");
    for joint in &mut machine.joints {
        (joint.max_acceleration, joint.max_jerk) = (None, None);
    }
    let p = Program::default().feed(100.0).g1(&[('X', -300.0)]).g1(&[('X', -300.0), ('Y', 100.0)]);
    let run = run_with(&p, &machine, &[], &servo());
    check_stream("no limits", &run);
    assert!(run.all.samples.iter().all(|s| s.actual.is_finite()));
    assert_eq!(run.summary.unlimited_joints.len(), 5);
}
