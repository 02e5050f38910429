//! Tool center point control, machine coordinates, tool length, pieces.

use crate::common::{Program, Random, axes, bc_machine, motion, run, run_with, tool};
use proveout_controller::{Dynamics, Event, LimitKind, Piece, RunError, Settings};
use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_nc::{Offset, Op};

const LENGTH: f64 = 120.0;

fn ideal() -> Settings {
    Settings { dynamics: Dynamics::Ideal, ..Settings::default() }
}

fn distance_to_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
    (p - (a + d * t)).norm()
}

#[test]
fn the_tip_stays_on_the_line_while_b_and_c_turn() {
    let machine = bc_machine();
    let program = Program::default()
        .change(1)
        .g0(&[('X', 20.0), ('Y', -10.0), ('Z', 180.0)])
        .tcp(true)
        .feed(40.0)
        .g1(&[('X', 10.0), ('Y', 5.0), ('Z', 160.0), ('B', 0.0), ('C', 0.0)])
        .g1(&[('X', -40.0), ('Y', 35.0), ('Z', 140.0), ('B', 0.9), ('C', 2.0)]);
    let out = run_with(&program, &machine, &[tool(1, LENGTH)], &ideal());
    let (a, b) = (Point::new(10.0, 5.0, 160.0), Point::new(-40.0, 35.0, 140.0));
    let last = out.all.samples.iter().map(|s| s.block).max().expect("samples");
    let mut seen = 0;
    for s in out.all.samples.iter().filter(|s| s.block == last) {
        let tip = machine.forward(&s.actual, LENGTH).tip;
        assert!(distance_to_segment(&tip, &a, &b) < 1e-9);
        // Rotary joints in proportion to the path.
        let part = (tip - a).norm() / (b - a).norm();
        assert!((s.actual[3] - 0.9 * part).abs() < 1e-9 && (s.actual[4] - 2.0 * part).abs() < 1e-9);
        assert!((s.pose.tip - tip).norm() < 1e-12);
        seen += 1;
    }
    assert!(seen > 100);
    assert!((out.summary.end_position[3] - 0.9).abs() < 1e-12);
}

#[test]
fn without_tcp_the_length_is_added_along_the_spindle() {
    let machine = bc_machine();
    let program = Program::default().change(1).g0(&[('X', 10.0), ('Y', 20.0), ('Z', 30.0)]);
    let end = run(&program, &machine).summary.end_position;
    assert_eq!([end[0], end[1], end[2]], [10.0, 20.0, 150.0]);
    let pose = machine.forward(&end, LENGTH);
    assert!((pose.tip - Point::new(10.0, 20.0, 30.0)).norm() < 1e-12);
}

/// The control takes the tool for longer than it is: its tip stays back by so much along its own axis, with
/// tool center point control and without.
#[test]
fn a_delta_value_of_the_length_keeps_the_tip_off_by_as_much() {
    let machine = bc_machine();
    let delta = |length| Op::Offset(Offset::ToolDelta { length, radius: 0.3, corner_radius: 0.0 });
    let program = Program::default().change(1).op(delta(0.25)).g0(&[('X', 10.0), ('Y', 20.0), ('Z', 30.0)]);
    let end = run(&program, &machine).summary.end_position;
    assert_eq!([end[0], end[1], end[2]], [10.0, 20.0, 150.25]);
    // Alone it moves nothing; the next motion of Z counts it, and the length switched off takes it along.
    let end = run(&program.clone().op(delta(-0.5)).g0(&[('X', 5.0)]), &machine).summary.end_position;
    assert_eq!([end[0], end[2]], [5.0, 150.25]);
    let end = run(&program.clone().op(delta(-0.5)).g0(&[('Z', 30.0)]), &machine).summary.end_position;
    assert_eq!(end[2], 149.5);
    assert_eq!(run(&program.edge(0).g0(&[('Z', 30.0)]), &machine).summary.end_position[2], 30.0);
    let tilted = [('X', -40.0), ('Y', 35.0), ('Z', 140.0), ('B', 0.9), ('C', 2.0)];
    for length in [0.0, 0.4, -0.4] {
        let program = Program::default()
            .change(1)
            .op(delta(length))
            .g0(&[('X', 20.0), ('Y', -10.0), ('Z', 180.0)])
            .tcp(true)
            .feed(40.0)
            .g1(&tilted);
        let out = run_with(&program, &machine, &[tool(1, LENGTH)], &ideal());
        let pose = machine.forward(&out.summary.end_position, LENGTH);
        let stated = Point::new(-40.0, 35.0, 140.0) + pose.axis * length;
        assert!((pose.tip - stated).norm() < 1e-9, "{length}: {:?}", pose.tip - stated);
        assert!(out.summary.max_contour_error_mm < 0.011, "{}", out.summary.max_contour_error_mm);
    }
}

#[test]
fn machine_coordinates_and_the_length_switched_off() {
    let machine = bc_machine();
    // SUPA Z610 D0: the gauge line at Z 610. D1 alone moves nothing; X Y next keep Z.
    let program = Program::default().change(1).edge(0).supa(&[('Z', 610.0)]).edge(1).supa(&[
        ('X', -365.0),
        ('Y', 224.0),
        ('B', 0.0),
        ('C', 0.0),
    ]);
    let end = run(&program, &machine).summary.end_position;
    assert_eq!(end, JointValues([-365.0, 224.0, 610.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    // The next Z counts the length.
    let end = run(&program.supa(&[('Z', 400.0)]), &machine).summary.end_position;
    assert_eq!(end[2], 520.0);
    // An axis that is not programmed moves only where its base coordinate is new (a turned frame).
    let mut also = motion(&[('X', 5.0)]);
    also.end_base = axes(&[('X', 5.0), ('Z', 610.0)]);
    let program = Program::default().change(1).edge(0).g0(&[('Z', 610.0)]);
    let end = run(&program.clone().op(Op::Rapid(also.clone())), &machine).summary.end_position;
    assert_eq!([end[0], end[2]], [5.0, 610.0]);
    also.end_base = axes(&[('X', 5.0), ('Z', 600.0)]);
    let end = run(&program.op(Op::Rapid(also)), &machine).summary.end_position;
    assert_eq!([end[0], end[2]], [5.0, 600.0]);
    // In machine coordinates the transformation is off for the block.
    let program = Program::default()
        .change(1)
        .g0(&[('X', 0.0), ('Y', 0.0), ('Z', 200.0), ('B', 0.5)])
        .tcp(true)
        .edge(0)
        .supa(&[('Z', 500.0)]);
    let end = run(&program, &machine).summary.end_position;
    assert_eq!([end[0], end[1], end[2], end[3]], [0.0, 0.0, 500.0, 0.5]);
}

#[test]
fn switching_tcp_moves_nothing() {
    let machine = bc_machine();
    let before = Program::default().change(1).g0(&[('X', 30.0), ('Y', 0.0), ('Z', 200.0), ('B', 0.7), ('C', 0.4)]);
    let a = run(&before, &machine).summary;
    let b = run(&before.clone().tcp(true).tcp(false).tcp(true), &machine).summary;
    assert_eq!(a.end_position, b.end_position);
    assert_eq!(a.total_s, b.total_s);
    // Z alone in K afterwards: the tip moves along z of the turned table.
    let tip = machine.forward(&a.end_position, LENGTH).tip;
    let out = run(&before.tcp(true).g0(&[('Z', tip.z + 10.0)]), &machine).summary;
    let moved = machine.forward(&out.end_position, LENGTH).tip;
    assert!((moved - tip - Vector::new(0.0, 0.0, 10.0)).norm() < 1e-9);
}

#[test]
fn tool_axis_as_a_vector_on_the_great_circle() {
    let machine = bc_machine();
    let goal = Vector::new(0.5, 0.3, 0.8).normalize();
    let mut vector = motion(&[('X', 40.0), ('Y', 10.0), ('Z', 150.0)]);
    vector.tool_axis = Some(goal.into());
    vector.tool_axis_base = vector.tool_axis;
    let start = [('X', 0.0), ('Y', 0.0), ('Z', 150.0), ('B', 0.6), ('C', -0.9)];
    for great_circle in [false, true] {
        let mut program = Program::default().change(1).g0(&[('Z', 300.0)]);
        program = if great_circle { program.tcp_great_circle() } else { program.tcp(true) };
        let program = program.g0(&start).feed(30.0).exact_stop().op(Op::Linear(vector.clone()));
        let out = run_with(&program, &machine, &[tool(1, LENGTH)], &ideal());
        let end = machine.forward(&out.summary.end_position, LENGTH);
        assert!((end.axis - goal).norm() < 1e-9);
        let last = out.all.blocks.last().expect("blocks").index;
        let samples: Vec<_> = out.all.samples.iter().filter(|s| s.block == last).collect();
        let piece = out.all.pieces.iter().find(|p| p.block == last).expect("pieces");
        let from: ToolPose = piece.pose[0];
        assert!((from.tip - Point::new(0.0, 0.0, 150.0)).norm() < 1e-9);
        let mut off = 0.0_f64;
        for s in samples {
            assert!(distance_to_segment(&s.pose.tip, &from.tip, &end.tip) < 1e-6);
            let part = (s.pose.tip - from.tip).norm() / (end.tip - from.tip).norm();
            off = off.max(from.interpolated(&end, part).angle_to(&s.pose));
        }
        // The knots of the great circle keep it to far below any orientation tolerance; the axes in
        // proportion do not.
        assert!(if great_circle { off < 1e-6 } else { off > 1e-3 }, "{great_circle} {off}");
    }
}

/// The promise of a piece, by dense sampling through the kinematics alone: every point of the tool between
/// tip and gauge line is within the stated deviation of the straight-tip, great-circle motion at some moment
/// near its own.
fn check_piece(machine: &Machine, piece: &Piece, joints_at: &dyn Fn(f64) -> JointValues) {
    for k in 0..=40 {
        let q = joints_at(f64::from(k) / 40.0);
        let x = machine.forward(&q, LENGTH);
        let mut best = f64::INFINITY;
        for i in 0..=400 {
            let ideal = piece.pose[0].interpolated(&piece.pose[1], f64::from(i) / 400.0);
            let tip = (x.tip - ideal.tip).norm();
            let gauge = (x.tip + x.axis * LENGTH - ideal.tip - ideal.axis * LENGTH).norm();
            best = best.min(tip.max(gauge));
        }
        // A grid of 400 along the piece adds half a step of its length.
        let step = (piece.pose[1].tip - piece.pose[0].tip).norm() + LENGTH * piece.pose[0].angle_to(&piece.pose[1]);
        assert!(best <= piece.deviation + step / 800.0 + 1e-9, "{best} {}", piece.deviation);
    }
}

#[test]
fn pieces_hold_their_deviation_and_join() {
    let machine = bc_machine();
    let program = Program::default()
        .change(1)
        .g0(&[('X', 0.0), ('Y', 0.0), ('Z', 150.0), ('B', 0.2), ('C', 0.1)])
        .tcp(true)
        .feed(60.0)
        .g1(&[('X', 0.0), ('Y', 0.0), ('Z', 150.0), ('B', 0.2), ('C', 0.1)])
        .g1(&[('X', 30.0), ('Y', 12.0), ('Z', 140.0), ('B', 0.4), ('C', 0.5)]);
    let out = run_with(&program, &machine, &[tool(1, LENGTH)], &ideal());
    let last = out.all.blocks.last().expect("blocks").index;
    let pieces: Vec<&Piece> = out.all.pieces.iter().filter(|p| p.block == last).collect();
    assert!(pieces.len() > 5 && pieces.len() < 2000, "{}", pieces.len());
    let (from, to) = (pieces[0].pose[0].tip, pieces[pieces.len() - 1].pose[1].tip);
    let rotary = |part: f64| {
        let mut q = JointValues::ZERO;
        q[3] = 0.2 + 0.2 * part;
        q[4] = 0.1 + 0.4 * part;
        machine.inverse_with_rotary(&(from + (to - from) * part), &q, LENGTH)
    };
    for p in &pieces {
        assert!(p.edge_deviation <= 0.0005 && p.deviation <= 0.004);
        let part = |i: usize| (p.pose[i].tip - from).norm() / (to - from).norm();
        let (a, b) = (part(0), part(1));
        check_piece(&machine, p, &|t| rotary(a + (b - a) * t));
    }
    for pair in out.all.pieces.windows(2) {
        assert!((pair[0].pose[1].tip - pair[1].pose[0].tip).norm() < 1e-9);
        assert!(pair[0].time[1] <= pair[1].time[0] + 1e-12);
        assert!(pair[0].time[0] <= pair[0].time[1]);
    }
}

#[test]
fn long_straight_moves_and_arcs_make_few_pieces() {
    let machine = bc_machine();
    let program = Program::default().exact_stop().feed(100.0).g1(&[('X', 200.0)]).arc_xy(
        &[('X', 160.0), ('Y', 40.0)],
        [160.0, 0.0, 0.0],
        40.0,
        std::f64::consts::FRAC_PI_2,
    );
    let out = run(&program, &machine);
    let count = |block| out.all.pieces.iter().filter(|p| p.block == block).count();
    assert_eq!(count(0), 4); // 50 mm each
    // Sagitta 0.0005 at radius 40: chords of 0.4 mm, 157 of them for 63 mm.
    assert!((150..330).contains(&count(1)), "{}", count(1));
}

#[test]
fn rounded_corners_stay_within_the_tolerance() {
    let machine = bc_machine();
    let mut r = Random::new(11);
    for tolerance in [0.002, 0.02, 0.2] {
        let mut points = vec![Point::origin()];
        let mut program = Program::default().continuous(tolerance).feed(120.0);
        for _ in 0..60 {
            let p = points[points.len() - 1] + Vector::new(r.range(-9.0, 9.0), r.range(-9.0, 9.0), r.range(-3.0, 3.0));
            program = program.g1(&[('X', p.x), ('Y', p.y), ('Z', p.z)]);
            points.push(p);
        }
        let out = run(&program, &machine);
        let mut worst = 0.0_f64;
        for s in &out.all.samples {
            let p = Point::new(s.commanded[0], s.commanded[1], s.commanded[2]);
            let d = points.windows(2).map(|w| distance_to_segment(&p, &w[0], &w[1])).fold(f64::INFINITY, f64::min);
            worst = worst.max(d);
        }
        assert!(worst <= tolerance, "{worst} {tolerance}");
        assert!(out.summary.max_contour_error_mm <= tolerance * (1.0 + 1e-12));
        assert!(out.summary.max_contour_error_mm > 0.5 * tolerance);
    }
}

#[test]
fn swiveling_turns_the_rotary_joints_alone() {
    let machine = bc_machine();
    let goal = Vector::new(0.3, -0.4, 0.866_025_403_784_438_6);
    let mut swivel = motion(&[]);
    swivel.tool_axis = Some(goal.into());
    swivel.tool_axis_base = Some(goal.into());
    let program =
        Program::default().change(1).g0(&[('X', 7.0), ('Y', 8.0), ('Z', 300.0)]).op(Op::Rapid(swivel.clone()));
    let end = run(&program, &machine).summary.end_position;
    assert_eq!([end[0], end[1], end[2]], [7.0, 8.0, 420.0]);
    assert!((machine.forward(&end, LENGTH).axis - goal.normalize()).norm() < 1e-9);
    // A table that turns about two axes cannot point the tool from below where B would pass its travel:
    // reported, not lost.
    let mut machine = machine;
    machine.joints[3].held = true;
    let machine = machine.recompiled();
    let out = run(&program, &machine);
    assert!(out.all.events.iter().any(|e| matches!(e, Event::UnreachablePose { .. })));
}

#[test]
fn over_travel_is_reported_and_does_not_stop() {
    let machine = bc_machine();
    let program = Program::default().feed(50.0).g1(&[('X', -520.0)]).g1(&[('X', 0.0)]);
    let out = run(&program, &machine);
    let found: Vec<_> = out
        .all
        .events
        .iter()
        .filter_map(|e| match e {
            Event::Limit { joint: Some(0), value, limit, kind: LimitKind::Travel, block, .. } => {
                Some((*value, *limit, *block))
            }
            _ => None,
        })
        .collect();
    assert_eq!(found.len(), 2);
    assert_eq!(found[0].1, -500.0);
    assert!((found[0].0 + 520.0).abs() < 0.02);
    assert_eq!(out.summary.end_position[0], 0.0);
}

#[test]
fn what_the_control_refuses() {
    let machine = bc_machine();
    let first_error = |program: &Program| {
        let tools = [tool(1, LENGTH)];
        let mut c = proveout_controller::Controller::new(program.source(), &machine, &tools, Settings::default())
            .expect("good settings");
        loop {
            match c.next_chunk() {
                Ok(Some(_)) => {}
                Ok(None) => return None,
                Err(RunError::Control(e)) => return Some(*e),
                Err(RunError::Program(never)) => match never {},
            }
        }
    };
    let code = |p: &Program| first_error(p).map(|e| (e.code, e.location.map(|l| l.line)));
    let p = Program::default;
    assert_eq!(code(&p().g0(&[('A', 1.0)])), Some(("control-axis", Some(1))));
    assert_eq!(code(&p().change(7)), Some(("control-tool", Some(1))));
    assert_eq!(code(&p().g0(&[('X', 1.0)]).g1(&[('X', 2.0)])), Some(("control-feed", Some(2))));
    assert_eq!(code(&p().g0(&[('X', f64::NAN)])), Some(("control-not-a-number", Some(1))));
    assert_eq!(code(&p().feed(0.0).g1(&[('X', 2.0)])), Some(("control-feed", Some(2))));
    let arc = p().feed(5.0).arc_xy(&[('X', 10.0)], [3.0, 0.0, 0.0], 3.0, 3.0);
    assert_eq!(code(&arc), Some(("control-arc", Some(2))));
    assert!(first_error(&p().change(7)).expect("an error").to_string().contains("test.nc:1:1"));
    let bad = Settings { piece_tolerance: 0.0, ..Settings::default() };
    assert!(proveout_controller::Controller::new(p().source(), &machine, &[], bad).is_err());
}

/// Under tool center point control slides run on curves and turn back within pieces: at every sample all
/// joints are within their deviation of one place of the straight motion.
#[test]
fn pieces_say_how_far_their_joints_leave_the_straight_motion() {
    let machine = bc_machine();
    let program = Program::default()
        .change(1)
        .g0(&[('X', 180.0), ('Y', -10.0), ('Z', 180.0)])
        .tcp(true)
        .feed(60.0)
        .g1(&[('X', 180.0), ('Y', 5.0), ('Z', 160.0), ('B', 0.2), ('C', 0.0)])
        .g1(&[('X', 150.0), ('Y', 30.0), ('Z', 140.0), ('B', 0.9), ('C', 2.5)])
        .g1(&[('X', 150.0), ('Y', 30.0), ('Z', 140.0), ('B', -0.4), ('C', 3.0)]);
    // Pieces of the ideal motion run on the programmed path, its set points round the corners: those of the
    // planned motion are both on one.
    for settings in [Settings::default(), Settings { default_tolerance: Some(0.002), ..Settings::default() }] {
        let out = run_with(&program, &machine, &[tool(1, LENGTH)], &settings);
        let (mut looked, mut turned_back, mut farthest) = (0, 0, 0.0_f64);
        for s in &out.all.samples {
            let Some(piece) = out.all.pieces.iter().find(|p| p.time[0] <= s.time && s.time <= p.time[1]) else {
                continue;
            };
            let [from, to] = piece.joints;
            let way = to - from;
            const PARTS: u32 = 4000;
            let excess = |k: u32| {
                let t = f64::from(k) / f64::from(PARTS);
                // Half a step of the places tried.
                let room = |j: usize| piece.joint_deviation[j] + 0.5 * way[j].abs() / f64::from(PARTS) + 1e-9;
                (0..5)
                    .map(|j| (s.commanded[j] - from[j] - way[j] * t).abs() - room(j))
                    .fold(f64::NEG_INFINITY, f64::max)
            };
            let least = (0..=PARTS).map(excess).fold(f64::INFINITY, f64::min);
            assert!(
                least <= 0.0,
                "{:?} at {}: {least} beyond {:?}, joints {:?} in the piece {piece:?}",
                settings.dynamics,
                s.time,
                piece.joint_deviation,
                s.commanded
            );
            looked += 1;
            turned_back += (0..3)
                .filter(|&j| {
                    let (low, high) = (from[j].min(to[j]) - 1e-9, from[j].max(to[j]) + 1e-9);
                    s.commanded[j] < low || s.commanded[j] > high
                })
                .count();
            farthest = (0..3).map(|j| piece.joint_deviation[j]).fold(farthest, f64::max);
        }
        assert!(looked > 500 && turned_back > 0, "{looked} {turned_back}");
        // More than the tool leaves its own way by, which is at most the tolerance of a piece.
        assert!(farthest > 2.0 * settings.piece_tolerance && farthest < 0.1, "{farthest}");
    }
}
