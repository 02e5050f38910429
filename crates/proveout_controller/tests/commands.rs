//! Commands of real programs: threads, overrides, splines, probing, retraction.

use crate::common;
use crate::common::{Program, Run, axes, bc_machine, motion, run, run_with, tool};
use proveout_controller::{BlockKind, Event, RunError, Settings};
use proveout_geom::{Point, Vector};
use proveout_machine::Machine;
use proveout_nc::{
    Contact, Feed, Op, Override, ProbeMotion, Retract, Spindle, SpindleDirection, SplineMotion, ThreadMotion,
};

fn spindle(direction: SpindleDirection, rpm: f64) -> Op {
    Op::Spindle(Spindle { direction, speed_rpm: Some(rpm) })
}

fn thread(values: &[(char, f64)], pitch: f64, direction: Option<SpindleDirection>) -> Op {
    Op::Thread(ThreadMotion { motion: motion(values), pitch, direction })
}

fn refusal(program: &Program, machine: &Machine) -> Option<(&'static str, u32)> {
    let tools = [tool(1, 120.0)];
    let mut c = proveout_controller::Controller::new(program.source(), machine, &tools, Settings::default())
        .expect("good settings");
    loop {
        match c.next_chunk() {
            Ok(Some(_)) => {}
            Ok(None) => return None,
            Err(RunError::Control(e)) => return Some((e.code, e.location.map_or(0, |l| l.line))),
            Err(RunError::Program(never)) => match never {},
        }
    }
}

fn block_time(out: &Run, line: u32) -> f64 {
    let moves = out.all.blocks.iter().filter(|b| b.line == line && matches!(b.kind, BlockKind::Move(_)));
    moves.map(|b| b.end_time - b.start_time).sum()
}

/// A machine without acceleration limits runs at the feed from the first moment: times are plain quotients.
fn rigid() -> Machine {
    let mut machine = bc_machine();
    for joint in &mut machine.joints {
        (joint.max_acceleration, joint.max_jerk) = (None, None);
    }
    machine
}

#[test]
fn a_thread_runs_at_pitch_times_speed_and_ignores_the_override() {
    let machine = rigid();
    let program = Program::default()
        .op(spindle(SpindleDirection::Clockwise, 600.0))
        .op(Op::Override(Override { enabled: true, feed: 0.5 }))
        .op(thread(&[('Z', -30.0)], 1.5, None));
    let out = run(&program, &machine);
    // 1.5 mm x 10 revolutions a second = 15 mm/s.
    assert!((block_time(&out, 3) - 2.0).abs() < 1e-9, "{}", block_time(&out, 3));
    let record = out.all.blocks.iter().find(|b| b.line == 3 && b.length > 0.0).expect("the thread");
    assert_eq!(record.feed, 15.0);
    // It waits until the spindle turns.
    assert!(record.start_time >= machine.control.spindle_start_time - 1e-12);
}

#[test]
fn a_tapping_cycle_reverses_the_spindle_and_gives_it_back() {
    let machine = rigid();
    let start = machine.control.spindle_start_time;
    let (cw, ccw) = (SpindleDirection::Clockwise, SpindleDirection::CounterClockwise);
    let program = Program::default()
        .op(spindle(cw, 600.0))
        .op(thread(&[('Z', -30.0)], 1.5, Some(cw)))
        .op(thread(&[('Z', 0.0)], 1.5, Some(ccw)))
        .g0(&[('X', 10.0)])
        .feed(10.0)
        .g1(&[('X', 20.0)]);
    let out = run(&program, &machine);
    let states: Vec<(SpindleDirection, f64)> = out
        .all
        .events
        .iter()
        .filter_map(|e| match e {
            Event::Spindle { direction, time, .. } => Some((*direction, *time)),
            _ => None,
        })
        .collect();
    assert_eq!(states.iter().map(|t| t.0).collect::<Vec<_>>(), [cw, ccw, cw]);
    let begin = |line: u32| {
        let moves = out.all.blocks.iter().find(|b| b.line == line && b.length > 0.0);
        moves.map(|b| (b.start_time, b.end_time)).expect("a motion")
    };
    // In, brake and start the other way, out.
    assert!((begin(2).0 - start).abs() < 1e-9);
    assert!((begin(3).0 - begin(2).1 - 2.0 * start).abs() < 1e-9);
    // The rapid does not wait for the spindle, the feed does.
    assert!((begin(4).0 - begin(3).1).abs() < 1e-9);
    assert!((begin(6).0 - begin(3).1 - 2.0 * start).abs() < 1e-9);
}

#[test]
fn threads_that_cannot_be_cut_are_refused() {
    let machine = bc_machine();
    let p = Program::default;
    assert_eq!(refusal(&p().op(thread(&[('Z', -9.0)], 1.0, None)), &machine), Some(("control-thread", 1)));
    // 400 mm/s is the limit of Z; 5 mm x 100 revolutions a second is more.
    let fast = p().op(spindle(SpindleDirection::Clockwise, 6000.0)).op(thread(&[('Z', -9.0)], 5.0, None));
    assert_eq!(refusal(&fast, &machine), Some(("control-thread", 2)));
    let turn = p().op(spindle(SpindleDirection::Clockwise, 600.0)).op(thread(&[('C', 1.0)], 1.0, None));
    assert_eq!(refusal(&turn, &machine), Some(("control-thread", 2)));
}

#[test]
fn chained_threads_run_through_and_other_motions_stop_at_them() {
    let machine = bc_machine();
    let speed = |steps: &[f64]| {
        let mut program = Program::default().op(spindle(SpindleDirection::Clockwise, 600.0));
        for z in steps {
            program = program.op(thread(&[('Z', *z)], 1.0, None));
        }
        run(&program.g0(&[('X', 20.0)]), &machine)
    };
    let (one, two) = (speed(&[-20.0]), speed(&[-7.0, -20.0]));
    assert!((one.summary.total_s - two.summary.total_s).abs() < 1e-9);
    // The pull-out does not cut the corner: X waits until Z is at its end.
    for s in one.all.samples.iter().filter(|s| s.commanded[0] > 1e-9) {
        assert!((s.commanded[2] + 20.0).abs() < 1e-9);
    }
}

#[test]
fn the_programmed_override_scales_every_kind_of_feed() {
    let machine = rigid();
    let plain = |op: Op, factor: f64| {
        let program = Program::default()
            .op(spindle(SpindleDirection::Clockwise, 600.0))
            .op(Op::Feed(match op {
                Op::Feed(f) => f,
                _ => Feed::PerTime(1.0),
            }))
            .op(Op::Override(Override { enabled: true, feed: factor }))
            .op(Op::Linear(motion(&[('X', 30.0)])));
        block_time(&run(&program, &machine), 4)
    };
    for feed in [Feed::PerTime(10.0), Feed::PerRevolution(1.0), Feed::InverseTime(3.0)] {
        let (whole, half) = (plain(Op::Feed(feed), 1.0), plain(Op::Feed(feed), 0.5));
        assert!((whole - 3.0).abs() < 1e-9, "{feed:?}: {whole}");
        assert!((half - 6.0).abs() < 1e-9, "{feed:?}: {half}");
    }
    let zero = Program::default().op(Op::Override(Override { enabled: true, feed: 0.0 }));
    assert_eq!(refusal(&zero, &machine), Some(("control-feed", 1)));
}

/// de Casteljau, and the nearest distance of a point to the curve by dense points.
fn distance_to_curve(p: &Point, c: &[[f64; 3]; 4]) -> f64 {
    let at = |t: f64| {
        let mut level: Vec<Vector> = c.iter().map(|v| Vector::from(*v)).collect();
        while level.len() > 1 {
            level = level.windows(2).map(|w| w[0] * (1.0 - t) + w[1] * t).collect();
        }
        level[0]
    };
    let n = 2000;
    let mut best = (f64::INFINITY, 0.0);
    for i in 0..=n {
        let t = f64::from(i) / f64::from(n);
        let d = (p.coords - at(t)).norm();
        if d < best.0 {
            best = (d, t);
        }
    }
    // Between two points: the foot on the chord.
    let h = 1.0 / f64::from(n);
    let mut least = best.0;
    for side in [-1.0, 1.0] {
        let (a, b) = (at(best.1), at((best.1 + side * h).clamp(0.0, 1.0)));
        let d = b - a;
        if d.norm() > 0.0 {
            let t = ((p.coords - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
            least = least.min((p.coords - (a + d * t)).norm());
        }
    }
    least
}

const CONTROL: [[f64; 3]; 4] = [[0.0, 0.0, 150.0], [30.0, 0.0, 150.0], [5.0, 40.0, 150.0], [40.0, 35.0, 150.0]];

fn spline(rotary: &[(char, f64)]) -> Op {
    let [_, b, c, end] = CONTROL;
    let mut values = vec![('X', end[0]), ('Y', end[1]), ('Z', end[2])];
    values.extend_from_slice(rotary);
    Op::Spline(SplineMotion { motion: motion(&values), control: [b, c], control_base: [b, c] })
}

fn check_limits(out: &Run, machine: &Machine) {
    let worst = common::limit_use(out, machine, machine.control.cycle_time);
    for value in [worst.velocity, worst.acceleration, worst.jerk].into_iter().chain(worst.differences) {
        assert!(value <= 1.001, "{worst:?}");
    }
}

#[test]
fn a_spline_is_followed_with_and_without_tool_center_point_control() {
    let machine = bc_machine();
    let start = [('X', 0.0), ('Y', 0.0), ('Z', 150.0)];
    let flat = Program::default().exact_stop().change(1).g0(&start).feed(60.0).op(spline(&[]));
    let out = run(&flat, &machine);
    let last = out.all.blocks.last().expect("blocks").index;
    let samples: Vec<_> = out.all.samples.iter().filter(|s| s.block == last).collect();
    assert!(samples.len() > 50);
    let mut feed = 0.0_f64;
    for s in &samples {
        // Chords of the comparison: 1/8 h^2 r'' below 1e-5 mm.
        assert!(distance_to_curve(&s.pose.tip, &CONTROL) < 1e-5);
        feed = feed.max(s.feed);
    }
    assert!((feed - 60.0).abs() < 1e-6, "{feed}");
    check_limits(&out, &machine);

    let turned = Program::default()
        .change(1)
        .g0(&[('X', 0.0), ('Y', 0.0), ('Z', 150.0), ('B', 0.1), ('C', 0.2)])
        .tcp(true)
        .g0(&start)
        .feed(60.0)
        .op(spline(&[('B', 0.4), ('C', 0.9)]));
    let out = run(&turned, &machine);
    let last = out.all.blocks.last().expect("blocks").index;
    for s in out.all.samples.iter().filter(|s| s.block == last && s.time < out.summary.total_s) {
        assert!(distance_to_curve(&s.pose.tip, &CONTROL) < 0.0101, "{:?}", s.pose.tip); // rounded corner before it
    }
    check_limits(&out, &machine);
    assert!((out.summary.end_position[4] - 0.9).abs() < 1e-12);
    // A straight spline is a straight block.
    let straight = |op: Op| {
        let program = Program::default().exact_stop().feed(60.0).op(op);
        run(&program, &machine).summary.total_s
    };
    let control = [[4.0, 0.0, 0.0], [20.0, 0.0, 0.0]];
    let curve = SplineMotion { motion: motion(&[('X', 30.0), ('Y', 0.0), ('Z', 0.0)]), control, control_base: control };
    let (a, b) = (straight(Op::Spline(curve)), straight(Op::Linear(motion(&[('X', 30.0)]))));
    assert!((a - b).abs() < 1e-6 * b, "{a} {b}");
}

#[test]
fn a_spline_with_a_cusp_is_refused() {
    let inner = [[10.0, 10.0, 0.0], [0.0, 10.0, 0.0]];
    let cusp =
        SplineMotion { motion: motion(&[('X', 10.0), ('Y', 0.0), ('Z', 0.0)]), control: inner, control_base: inner };
    let program = Program::default().feed(60.0).op(Op::Spline(cusp));
    assert_eq!(refusal(&program, &bc_machine()), Some(("control-spline", 2)));
}

#[test]
fn a_probe_runs_to_its_end_stops_and_is_reported() {
    let machine = bc_machine();
    let probe =
        ProbeMotion { motion: motion(&[('Z', -5.0)]), away: false, must_switch: true, contact: Contact::Unknown };
    let program = Program::default().feed(10.0).op(Op::Probe(probe)).g1(&[('X', 8.0)]);
    let out = run(&program, &machine);
    let probes: Vec<_> = out.all.events.iter().filter(|e| matches!(e, Event::Probe { .. })).collect();
    assert_eq!(probes.len(), 1);
    let probed = out.all.blocks.iter().find(|b| b.line == 2).expect("the probe");
    assert_eq!(probes[0].block(), probed.index);
    assert!(probes[0].time() <= probed.start_time + 1e-12);
    for s in out.all.samples.iter().filter(|s| s.commanded[0] > 1e-9) {
        assert!((s.commanded[2] + 5.0).abs() < 1e-9);
    }
    let no_feed = Program::default().op(Op::Probe(ProbeMotion {
        motion: motion(&[('Z', -5.0)]),
        away: false,
        must_switch: true,
        contact: Contact::Unknown,
    }));
    assert_eq!(refusal(&no_feed, &machine), Some(("control-feed", 1)));
}

#[test]
fn a_retraction_goes_along_the_tool_axis() {
    let machine = bc_machine();
    let before = Program::default().change(1).g0(&[('X', 10.0), ('Y', 5.0), ('Z', 150.0), ('B', 0.5), ('C', 0.3)]);
    for tcp in [false, true] {
        let at = |op: Option<Op>| {
            let mut program = before.clone().tcp(tcp);
            if let Some(op) = op {
                program = program.op(op);
            }
            run_with(&program, &machine, &[tool(1, 120.0)], &Settings::default())
        };
        let from = machine.forward(&at(None).summary.end_position, 120.0);
        let out = at(Some(Op::Retract(Retract { distance: Some(40.0), rapid: true })));
        let to = machine.forward(&out.summary.end_position, 120.0);
        assert!((to.tip - from.tip - from.axis * 40.0).norm() < 1e-9);
        assert!((to.axis - from.axis).norm() < 1e-12);
        // To the end of travel: Z is at its upper end, and nothing is beyond.
        let out = at(Some(Op::Retract(Retract { distance: None, rapid: true })));
        assert!((out.summary.end_position[2] - 700.0).abs() < 1e-9, "{:?}", out.summary.end_position);
        assert!(!out.all.events.iter().any(|e| matches!(e, Event::Limit { .. })));
    }
    // The program must set the linear axes again: Z is forgotten, X without a word stays where the machine
    // is.
    let mut stale = motion(&[('X', 12.0)]);
    stale.end_base = axes(&[('X', 12.0), ('Z', 150.0)]);
    let program = before.op(Op::Retract(Retract { distance: Some(40.0), rapid: true })).op(Op::Rapid(stale));
    let end = run(&program, &machine).summary.end_position;
    assert_eq!(end[2], 270.0); // the frame's Z is new to the control: it goes there
    let mut boundless = bc_machine();
    for joint in &mut boundless.joints {
        joint.travel = None;
    }
    let program = Program::default().op(Op::Retract(Retract { distance: None, rapid: true }));
    assert_eq!(refusal(&program, &boundless), Some(("control-retract", 1)));
    let negative = Program::default().op(Op::Retract(Retract { distance: Some(-1.0), rapid: true }));
    assert_eq!(refusal(&negative, &machine), Some(("control-retract", 1)));
}
