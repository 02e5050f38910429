//! What parameters of a control decide about the motion: the position on a tilted plane, the time of blocks
//! that turn rotary axes, blocks without a way, and the contour error of the drives.

use crate::common;
use std::path::Path;

use crate::common::{Program, Random, motion, run, run_with, tool};
use proveout_controller::{Dynamics, Event, Settings};
use proveout_machine::{JointValues, Machine};
use proveout_nc::{FeedCounts, Motion, Op, RotarySolution};

fn library(name: &str) -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name);
    Machine::read(&folder).unwrap_or_else(|e| panic!("{e}"))
}

/// A rapid that turns the tool to an axis while the linear axes are at rest.
fn swivel(axis: [f64; 3], solution: RotarySolution) -> Op {
    let turn = motion(&[]);
    Op::Rapid(Motion { tool_axis: Some(axis), tool_axis_base: Some(axis), exact_stop: true, solution, ..turn })
}

fn notes(run: &common::Run) -> Vec<&str> {
    run.all
        .events
        .iter()
        .filter_map(|e| if let Event::Note { text, .. } = e { Some(text.as_str()) } else { None })
        .collect()
}

#[test]
fn a_swivel_takes_the_position_that_is_asked_for_and_else_the_other_one() {
    let names = [
        "ac-trunnion-620",
        "bc-trunnion",
        "bc-head-table-home-zero",
        "spinner-u5-620",
        "fork-head-gantry",
        "dmu-50-type",
    ];
    let mut random = Random::new(11);
    let mut seen = [0; 2];
    for name in names {
        let machine = library(name);
        let &[_, tilting] = machine.rotary_joints() else { panic!("{name}: two rotary joints") };
        for _ in 0..12 {
            let (tilt, turn) = (random.range(3.0, 60.0).to_radians(), random.range(-180.0, 180.0).to_radians());
            let axis = [tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos()];
            let end = |solution| {
                let program = Program::default().op(swivel(axis, solution));
                let out = run(&program, &machine);
                let reached = machine.forward(&out.summary.end_position, 0.0).axis;
                let noted = notes(&out).iter().any(|text| text.contains("out of travel"));
                assert!((0..3).all(|k| (reached[k] - axis[k]).abs() < 1e-6), "{name}: {reached:?} {axis:?}");
                (out.summary.end_position[tilting], noted)
            };
            let ask = |higher| RotarySolution::Angle { higher, reference: None, or_other: true };
            let [(low, low_told), (high, high_told)] = [end(ask(false)), end(ask(true))];
            let travel = machine.joints[tilting].travel;
            let inside = |q: f64| travel.is_none_or(|[a, b]| (a - 1e-9..=b + 1e-9).contains(&q));
            assert!(inside(low) && inside(high), "{name}: {low} {high}");
            if low_told || high_told {
                // One position alone is within travel, and both words come to it.
                assert!((low - high).abs() < 1e-9 && low_told != high_told, "{name}: {low} {high}");
                seen[1] += 1;
            } else {
                assert!(low < high - 1e-6, "{name}: {low} {high}");
                seen[0] += 1;
            }
        }
    }
    assert!(seen[0] > 10 && seen[1] > 3, "{seen:?}");
}

#[test]
fn a_control_that_refuses_the_other_position_is_reported_as_an_assumption() {
    let machine = library("spinner-u5-620");
    let positions = |or_other| {
        let axis = [0.5, 0.0, 0.75_f64.sqrt()];
        let both = [false, true].map(|higher| {
            let program =
                Program::default().op(swivel(axis, RotarySolution::Angle { higher, reference: None, or_other }));
            let out = run(&program, &machine);
            notes(&out).iter().any(|text| text.starts_with(proveout_nc::ASSUMED))
        });
        both[0] || both[1]
    };
    assert_eq!((positions(true), positions(false)), (false, true));
}

#[test]
fn f_counts_the_vector_of_the_axes_that_the_control_counts() {
    let machine = library("bc-trunnion");
    let degree = FeedCounts::DEGREE_IS_MM;
    let home = machine.joints[machine.joint_for_letter('X').expect("X")].home;
    let mut random = Random::new(5);
    for _ in 0..10 {
        let (x, turn, feed) = (random.range(60.0, 120.0), random.range(-90.0, 90.0), random.range(4.0, 10.0));
        let radius = random.range(20.0, 90.0);
        for (linear, of_c) in [(1.0, 0.0), (1.0, degree), (1.0, radius), (0.0, radius)] {
            let counts = FeedCounts { linear: [linear; 3], radius: [0.0, 0.0, of_c] };
            let start = Program::default().feed(feed).op(Op::FeedCounts(counts));
            let program = start.g1(&[('X', home + x), ('C', turn.to_radians())]);
            let out = run(&program, &machine);
            let counted = (linear * x).hypot(of_c * turn.to_radians());
            // The joint's own limits and the ramps make it longer.
            let c = machine.joint_for_letter('C').expect("C");
            let fastest = turn.to_radians().abs() / machine.joints[c].max_velocity.unwrap_or(f64::INFINITY);
            let least = (counted / feed).max(fastest);
            let time = out.summary.total_s;
            assert!(time >= least * (1.0 - 1e-3) && time < least + 0.5, "{linear} {of_c}: {time} {least}");
        }
    }
    // Rotary axes alone: degrees by default, and the arc at a radius that is stated.
    let alone = |counts: Option<FeedCounts>| {
        let start = Program::default().feed(5.0);
        let start = counts.map_or(start.clone(), |counts| start.op(Op::FeedCounts(counts)));
        run(&start.g1(&[('C', 1.0)]), &machine).summary.total_s
    };
    let plain = alone(None);
    assert_eq!(plain, alone(Some(FeedCounts { radius: [degree; 3], ..FeedCounts::LINEAR })));
    let wide = alone(Some(FeedCounts { radius: [100.0; 3], ..FeedCounts::LINEAR }));
    assert!((wide - 20.0).abs() < 0.5 && (plain - 11.46).abs() < 0.5, "{wide} {plain}");
}

#[test]
fn a_block_without_a_way_is_no_stop_in_continuous_path_mode() {
    let machine = library("three-axis-mill");
    let feed = 15.0;
    for seed in 0..6 {
        let mut random = Random::new(seed);
        let points: Vec<[f64; 3]> = (0..60)
            .map(|k| [0.4 * f64::from(k), 3.0 * (0.05 * f64::from(k)).sin(), random.range(-0.002, 0.002)])
            .collect();
        let path = |times: &mut dyn FnMut() -> u32, mode: fn(Program) -> Program| {
            let mut program = mode(Program::default().g0(&[('X', 0.0), ('Y', 0.0), ('Z', 0.0)]).feed(feed));
            for p in &points {
                for _ in 0..times() {
                    program = program.g1(&[('X', p[0]), ('Y', p[1]), ('Z', p[2])]);
                }
            }
            run(&program, &machine)
        };
        let once = path(&mut || 1, |p| p.continuous(0.01));
        let more = path(&mut || 1 + (random.unit() * 3.0) as u32, |p| p.continuous(0.01));
        assert!(
            (once.summary.total_s - more.summary.total_s).abs() < 1e-6,
            "{} {}",
            once.summary.total_s,
            more.summary.total_s
        );
        let records = &more.all.blocks;
        assert!(records.windows(2).all(|w| w[0].index + 1 == w[1].index && w[0].end_time <= w[1].start_time + 1e-9));
        assert_eq!(more.summary.blocks as usize, records.len());
        // An exact stop is one, with a way or without.
        let stop = path(&mut || 1, Program::exact_stop);
        let stops = path(&mut || 2, Program::exact_stop);
        assert!((stop.summary.total_s - stops.summary.total_s).abs() < 1e-6);
        // Each of the 58 stops between blocks of some length costs the time of a ramp: half of it down, half
        // of it up.
        let x = &machine.joints[machine.joint_for_letter('X').expect("X")];
        let ramp = 2.0 * (feed / x.max_jerk.expect("a limit")).sqrt();
        let (stop, once) = (stop.summary.total_s, once.summary.total_s);
        assert!(stop - once > 0.9 * 58.0 * ramp, "{stop} {once} {ramp}");
    }
}

#[test]
fn the_contour_error_of_the_drives_is_held_against_the_nearest_block() {
    let machine = library("ac-trunnion-620");
    let settings = Settings { dynamics: Dynamics::Servo, ..Settings::default() };
    for seed in 0..3 {
        let mut random = Random::new(40 + seed);
        let mut p =
            Program::default().change(1).g0(&[('X', 0.0), ('Y', 0.0)]).g0(&[('Z', 500.0), ('A', 0.2), ('C', 0.0)]);
        p = p.tcp(true).continuous(0.01).feed(30.0);
        for _ in 0..8 {
            let at = [random.range(-30.0, 30.0), random.range(-30.0, 30.0)];
            let turned = [('A', random.range(-0.4, 0.4)), ('C', random.range(-1.0, 1.0))];
            // Rapids to and fro between the cuts, a turn alone, and a cut.
            p = p.g0(&[('X', at[0]), ('Y', at[1]), ('Z', 180.0)]).g1(&[('Z', 160.0)]);
            p = p.g1(&[turned[0], turned[1]]).g1(&[('X', at[0] + 20.0), ('Y', at[1] + 20.0)]).g0(&[('Z', 200.0)]);
        }
        let out = run_with(&p, &machine, &[tool(1, 120.0)], &settings);
        // The tip of the actual joints against that of the set points of some cycles before, in feed.
        let tip = |q: &JointValues| machine.forward(q, 120.0).tip;
        let samples = &out.all.samples;
        let mut worst = 0.0_f64;
        for (k, s) in samples.iter().enumerate().filter(|(_, s)| s.kind == proveout_controller::MoveKind::Feed) {
            let path: Vec<_> = samples[k.saturating_sub(200)..=k].iter().map(|s| tip(&s.commanded)).collect();
            let at = tip(&s.actual);
            let off = path.windows(2).map(|w| {
                let way = w[1] - w[0];
                let t = ((at - w[0]).dot(&way) / way.norm_squared().max(1e-30)).clamp(0.0, 1.0);
                (at - (w[0] + way * t)).norm()
            });
            worst = worst.max(off.fold((at - path[0]).norm(), f64::min));
        }
        let largest = out.summary.max_servo_contour_error_mm.expect("drives");
        assert!(largest <= worst + 1e-6, "{seed}: {largest} mm, and the tip is never farther than {worst} mm");
        assert!(
            largest > 0.0 && out.summary.max_axis_error.to_degrees() < 3.0,
            "{largest} {}",
            out.summary.max_axis_error
        );
    }
}
