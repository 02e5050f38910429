//! What is not a number is refused at its block, wherever it is; limits that are not stated are named
//! and do not stop the plan.

use crate::common;
use crate::common::{Program, axes, bc_machine, motion, run, tool};
use proveout_controller::{Controller, Dynamics, RunError, Settings};
use proveout_machine::Machine;
use proveout_nc::{
    CompSide, Contact, CutterComp, Dwell, Feed, FrameChange, Motion, Offset, Op, OrientationInterpolation, Override,
    PathMode, ProbeMotion, Retract, Spindle, SpindleDirection, SplineMotion, Tcp, ThreadMotion,
};

/// Code and line of the refusal; none for a program that runs.
fn refusal(program: &Program, machine: &Machine) -> Option<(&'static str, u32, String)> {
    let tools = [tool(1, 100.0)];
    let mut c = Controller::new(program.source(), machine, &tools, Settings::default()).expect("good settings");
    loop {
        match c.next_chunk() {
            Ok(Some(_)) => {}
            Ok(None) => return None,
            Err(RunError::Control(e)) => {
                let line = e.location.as_ref().map_or(0, |l| l.line);
                return Some((e.code, line, e.to_string()));
            }
            Err(RunError::Program(never)) => match never {},
        }
    }
}

#[test]
fn what_is_not_a_number_is_refused_at_its_block() {
    let machine = bc_machine();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let at = |values: &[(char, f64)]| motion(values);
        let vector =
            |axis: [f64; 3]| Motion { tool_axis: Some(axis), tool_axis_base: Some(axis), ..motion(&[('X', 1.0)]) };
        let arc = |center: [f64; 3], radius: f64, sweep: f64| {
            let p = Program::default().arc_xy(&[('X', 10.0), ('Y', 0.0)], center, radius, sweep);
            p.commands[0].op.clone()
        };
        let spline = |control: [[f64; 3]; 2]| {
            Op::Spline(SplineMotion { motion: at(&[('X', 9.0)]), control, control_base: control })
        };
        let frame = |rotation: f64, translation: f64, rotary: f64| {
            let rotation = [[1.0, 0.0, 0.0], [0.0, rotation, 0.0], [0.0, 0.0, 1.0]];
            let (translation, rotary) = ([0.0, 0.0, translation], [0.0, rotary, 0.0]);
            Op::Frame(FrameChange { word: "ROT".into(), rotation, translation, rotary })
        };
        let wanted_base = Motion { end_base: axes(&[('Y', bad)]), ..at(&[('Y', 1.0)]) };
        let cases: Vec<(&str, Op)> = vec![
            ("rapid", Op::Rapid(at(&[('X', bad)]))),
            ("rotary", Op::Rapid(at(&[('B', bad)]))),
            ("line", Op::Linear(at(&[('Z', bad)]))),
            ("base coordinates", Op::Linear(wanted_base)),
            ("tool axis", Op::Linear(vector([0.0, bad, 1.0]))),
            ("arc's end", {
                let mut op = arc([5.0, 0.0, 0.0], 5.0, 3.0);
                if let Op::Arc(arc) = &mut op {
                    arc.motion = at(&[('X', bad)]);
                }
                op
            }),
            ("arc's center", arc([5.0, bad, 0.0], 5.0, 3.0)),
            ("arc's radius", arc([5.0, 0.0, 0.0], bad, 3.0)),
            ("arc's angle", arc([5.0, 0.0, 0.0], 5.0, bad)),
            ("spline", spline([[3.0, bad, 0.0], [6.0, 3.0, 0.0]])),
            (
                "probe",
                Op::Probe(ProbeMotion {
                    motion: at(&[('Z', bad)]),
                    away: false,
                    must_switch: true,
                    contact: Contact::Unknown,
                }),
            ),
            ("thread's end", Op::Thread(ThreadMotion { motion: at(&[('Z', bad)]), pitch: 1.0, direction: None })),
            ("pitch", Op::Thread(ThreadMotion { motion: at(&[('Z', -5.0)]), pitch: bad, direction: None })),
            ("retraction", Op::Retract(Retract { distance: Some(bad), rapid: true })),
            ("dwell", Op::Dwell(Dwell::Seconds(bad))),
            ("dwell in revolutions", Op::Dwell(Dwell::Revolutions(bad))),
            ("feed", Op::Feed(Feed::PerTime(bad))),
            ("feed per revolution", Op::Feed(Feed::PerRevolution(bad))),
            ("inverse time", Op::Feed(Feed::InverseTime(bad))),
            ("speed", Op::Spindle(Spindle { direction: SpindleDirection::Clockwise, speed_rpm: Some(bad) })),
            ("delta", Op::Offset(Offset::ToolDelta { length: bad, radius: 0.0, corner_radius: 0.0 })),
            ("frame's rotation", frame(bad, 0.0, 0.0)),
            ("frame's shift", frame(1.0, bad, 0.0)),
            ("frame's rotary shift", frame(1.0, 0.0, bad)),
            ("tolerance", Op::PathMode(PathMode::Continuous { tolerance: Some(bad), orientation_tolerance: None })),
            (
                "orientation tolerance",
                Op::PathMode(PathMode::Continuous { tolerance: None, orientation_tolerance: Some(bad) }),
            ),
            ("compensation", Op::CutterComp(CutterComp { side: CompSide::Off, offset: None, radius: Some(bad) })),
            ("override", Op::Override(Override { enabled: true, feed: bad })),
        ];
        for (name, op) in cases {
            for tcp in [false, true] {
                let begin = Program::default().change(1).g0(&[('X', 0.0), ('Y', 0.0), ('Z', 300.0)]).feed(20.0);
                let begin = begin.op(Op::Tcp(Tcp { on: tcp, interpolation: OrientationInterpolation::Axes }));
                // Motion after it would have been planned together with the bad block.
                let p = begin.op(op.clone()).g1(&[('X', 20.0)]);
                let message = refusal(&p, &machine);
                let Some((code, line, text)) = message else { panic!("{name} {bad}: runs") };
                assert_eq!((code, line), ("control-not-a-number", 5), "{name} {bad}, tcp {tcp}: {text}");
                assert!(text.contains("test.nc:5:1"), "{text}");
            }
        }
    }
}

#[test]
fn settings_and_machine_data_that_are_no_numbers_are_refused_before_the_run() {
    let p = Program::default();
    let settings = |change: &dyn Fn(&mut Settings)| {
        let mut s = Settings::default();
        change(&mut s);
        Controller::new(p.source(), &bc_machine(), &[], s).err().map(|e| e.code)
    };
    assert_eq!(settings(&|_| {}), None);
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        assert_eq!(settings(&|s| s.sample_time = Some(bad)), Some("control-settings"));
        assert_eq!(settings(&|s| s.default_tolerance = Some(bad)), Some("control-settings"));
        assert_eq!(settings(&|s| s.default_orientation_tolerance = Some(bad)), Some("control-settings"));
        assert_eq!(settings(&|s| s.piece_tolerance = bad), Some("control-settings"));
        assert_eq!(settings(&|s| s.piece_length = bad), Some("control-settings"));
        assert_eq!(settings(&|s| s.piece_angle = bad), Some("control-settings"));
    }
    let limits = |change: &dyn Fn(&mut Machine)| {
        let mut machine = bc_machine();
        change(&mut machine);
        Controller::new(p.source(), &machine, &[], Settings::default()).err().map(|e| e.code)
    };
    for bad in [f64::NAN, 0.0, -5.0] {
        assert_eq!(limits(&|m| m.joints[0].max_velocity = Some(bad)), Some("control-limits"));
        assert_eq!(limits(&|m| m.joints[1].max_acceleration = Some(bad)), Some("control-limits"));
        assert_eq!(limits(&|m| m.joints[2].max_jerk = Some(bad)), Some("control-limits"));
        assert_eq!(limits(&|m| m.joints[3].rapid_velocity = Some(bad)), Some("control-limits"));
        assert_eq!(limits(&|m| m.control.cycle_time = bad), Some("control-limits"));
    }
}

/// Without jerk, without acceleration, without both: the plan takes what is there, keeps it, and names what
/// is missing.
#[test]
fn limits_that_are_not_stated_are_named_and_the_rest_is_kept() {
    let base = || {
        let p = Program::default().change(1).g0(&[('X', 0.0), ('Y', 0.0)]).continuous(0.02).feed(150.0);
        p.g1(&[('X', 40.0)])
            .g1(&[('X', 60.0), ('Y', 30.0)])
            .g1(&[('X', 10.0), ('Y', 50.0)])
            .exact_stop()
            .g1(&[('X', 0.0)])
    };
    let full = run(&base(), &bc_machine());
    assert!(full.summary.unlimited_joints.is_empty());
    for (acceleration, jerk) in [(true, false), (false, true), (false, false)] {
        let mut machine = bc_machine();
        for joint in &mut machine.joints[..2] {
            if !acceleration {
                joint.max_acceleration = None;
            }
            if !jerk {
                joint.max_jerk = None;
            }
        }
        let out = run(&base(), &machine);
        let named: Vec<_> = out.summary.unlimited_joints.iter().map(|u| (u.joint.as_str(), u.velocity)).collect();
        assert_eq!(named, [("X", false), ("Y", false)], "those two and no other");
        let missing = |u: &proveout_controller::UnlimitedJoint| (u.acceleration, u.jerk) == (!acceleration, !jerk);
        assert!(out.summary.unlimited_joints.iter().all(missing), "{:?}", out.summary.unlimited_joints);
        // Fewer limits take no longer, but for the gap at which the search of a tempo ends (5e-6 of the time
        // seen), and what is limited stays so (0.1 percent, the promise of the planner).
        let (a, b) = (out.summary.total_s, full.summary.total_s);
        assert!(a <= b * (1.0 + 1e-4), "{acceleration} {jerk}: {a} {b}");
        for (j, joint) in machine.joints.iter().enumerate() {
            for s in &out.all.samples {
                assert!(s.commanded.is_finite() && s.velocity.is_finite());
                assert!(s.velocity[j].abs() <= joint.max_velocity.expect("a limit") * 1.001);
                if let Some(limit) = joint.max_acceleration {
                    assert!(s.acceleration[j].abs() <= limit * 1.001, "{}: {}", joint.name, s.acceleration[j]);
                }
            }
        }
        let ideal = Settings { dynamics: Dynamics::Ideal, ..Settings::default() };
        let again = common::run_with(&base(), &machine, &[tool(1, 120.0)], &ideal);
        assert_eq!(again.summary.total_s, out.summary.total_s);
    }
}
