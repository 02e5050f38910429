//! Branch choice, travel, singular poses, and machines with other than two rotary joints.

use std::{f64::consts::PI, path::Path};

use crate::kinematics::common::{Random, random_joints, rest};
use proveout_geom::{Point, ToolPose, Vector, rad};
use proveout_machine::{JointValues, KinematicsError, Machine};

/// Three slides in the tool and the rotary joints given as (name, carries, parent, direction, extra keys).
pub(crate) fn machine(rotary: &[(&str, &str, &str, [f64; 3], &str)], spindle: &str, table: &str) -> Machine {
    let mut text = "name = \"test\"\n".to_owned();
    for (name, parent, d) in [("X", "base", [1, 0, 0]), ("Y", "X", [0, 1, 0]), ("Z", "Y", [0, 0, 1])] {
        text += &format!(
            "[[joint]]\nname = {name:?}\nkind = \"linear\"\ncarries = \"tool\"\nparent = {parent:?}\ndirection = {d:?}\n"
        );
    }
    for (name, carries, parent, d, extra) in rotary {
        let sense = if *carries == "tool" { 1 } else { -1 };
        text += &format!(
            "[[joint]]\nname = {name:?}\nkind = \"rotary\"\ncarries = {carries:?}\nparent = {parent:?}\ndirection = {d:?}\n\
             point_mm = [0, 0, 30]\nsense = {sense}\n{extra}\n"
        );
    }
    text += &rest(spindle, table, Vector::z());
    Machine::from_text(Path::new("test.toml"), &text).unwrap_or_else(|e| panic!("{e}"))
}

pub(crate) const Y: [f64; 3] = [0.0, 1.0, 0.0];
pub(crate) const Z: [f64; 3] = [0.0, 0.0, 1.0];

pub(crate) fn bc(b_keys: &str, c_keys: &str) -> Machine {
    machine(&[("B", "workpiece", "base", Y, b_keys), ("C", "workpiece", "B", Z, c_keys)], "Z", "C")
}

/// Types of machines with the singular cone on the upright tool, or on the pole of the head.
pub(crate) fn types() -> Vec<(&'static str, Machine)> {
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let x = [1.0, 0.0, 0.0];
    vec![
        ("BC table-table", bc("", "")),
        ("AC table-table", machine(&[("A", "workpiece", "base", x, ""), ("C", "workpiece", "A", Z, "")], "Z", "C")),
        ("B head, C table", machine(&[("B", "tool", "Z", Y, ""), ("C", "workpiece", "base", Z, "")], "B", "C")),
        (
            "45 degree head, C table",
            machine(&[("B", "tool", "Z", [0.0, h, h], ""), ("C", "workpiece", "base", Z, "")], "B", "C"),
        ),
        ("fork head", machine(&[("C", "tool", "Z", Z, ""), ("A", "tool", "C", x, "")], "A", "base")),
        (
            "nutating table",
            machine(&[("B", "workpiece", "base", [0.0, h, h], ""), ("C", "workpiece", "B", Z, "")], "Z", "C"),
        ),
    ]
}

#[test]
fn a_path_through_the_singular_cone_stays_continuous() {
    for (name, machine) in types() {
        let mut previous = JointValues::ZERO;
        let &[table_side, tilt] = machine.rotary_joints() else { panic!("two rotary joints") };
        let mut amplification = 0.0_f64;
        let mut singular = 0;
        let mut last: Option<JointValues> = None;
        // The tool passes the upright exactly, in the plane in which the tilting joint moves it at first
        // order.
        let probe = machine.jacobian(&JointValues::ZERO, 0.0);
        let way: Vector = probe.fixed_view::<3, 1>(3, tilt).into();
        for step in -50..=50 {
            let angle = rad(f64::from(step) * 0.4);
            let axis = Vector::z() * angle.cos() + way.normalize() * angle.sin();
            let pose = ToolPose { tip: Point::new(10.0, 20.0, 5.0), axis };
            let solution = machine.inverse_nearest(&pose, 100.0, &previous).unwrap_or_else(|e| panic!("{name}: {e}"));
            let again = machine.forward(&solution.q, 100.0);
            assert!((again.tip - pose.tip).norm() < 1e-9 && again.angle_to(&pose) < 1e-10, "{name} step {step}");
            singular += usize::from(solution.singular);
            if !solution.singular {
                amplification = amplification.max(machine.rotary_amplification(&solution.q).expect("two"));
            }
            if let Some(last) = last {
                let jump = (solution.q[table_side] - last[table_side]).abs().max((solution.q[tilt] - last[tilt]).abs());
                // A step of 0.4 degrees of the axis is 0.57 of a skew joint; no joint may turn over.
                assert!(jump < rad(0.8), "{name} step {step}: jump {}", jump.to_degrees());
            }
            last = Some(solution.q);
            previous = solution.q;
        }
        assert_eq!(singular, 1, "{name}: the singular pose is named");
        assert!(amplification > 100.0, "{name}: {amplification} at 0.4 degrees from the pole");
        assert_eq!(machine.rotary_amplification(&JointValues::ZERO), Some(f64::INFINITY), "{name}");
    }
}

#[test]
fn the_amplification_of_an_upright_tool_is_one_over_the_sine() {
    let machine = bc("", "");
    for tilt in [1.0, 5.0, 30.0, 89.0] {
        let mut q = JointValues::ZERO;
        q[3] = rad(tilt);
        let amplification = machine.rotary_amplification(&q).expect("two");
        assert!((amplification * rad(tilt).sin() - 1.0).abs() < 1e-12, "{tilt}: {amplification}");
    }
}

#[test]
fn a_free_joint_keeps_its_value() {
    let machine = bc("", "endless = true");
    let mut previous = JointValues::ZERO;
    previous[4] = rad(777.0);
    let pose = ToolPose { tip: Point::new(1.0, 2.0, 3.0), axis: Vector::z() };
    let solution = machine.inverse_nearest(&pose, 0.0, &previous).expect("reached");
    assert!(solution.singular);
    assert_eq!(solution.q[4], rad(777.0));
    assert!((machine.forward(&solution.q, 0.0).tip - pose.tip).norm() < 1e-12);
    let branches = machine.inverse(&pose, 0.0);
    assert_eq!((branches.len(), branches[0].free_joint, branches[0].q[4]), (1, Some(4), 0.0));
}

#[test]
fn travel_decides_on_the_branch_and_the_turn() {
    let pose = |b: f64, c: f64| {
        let machine = bc("", "");
        let mut q = JointValues::ZERO;
        (q[3], q[4]) = (rad(b), rad(c));
        machine.forward(&q, 0.0)
    };
    let machine = bc("travel_deg = [-10, 105]", "travel_deg = [-400, 400]");
    let mut previous = JointValues::ZERO;
    previous[4] = rad(170.0);
    let solution = machine.inverse_nearest(&pose(40.0, -170.0), 0.0, &previous).expect("reached");
    assert!((solution.q[4] - rad(190.0)).abs() < 1e-12, "unwrapped past the half turn");
    assert!((solution.q[3] - rad(40.0)).abs() < 1e-12, "B -40 is nearer for no joint and outside");
    previous[4] = rad(395.0);
    let solution = machine.inverse_nearest(&pose(40.0, 45.0), 0.0, &previous).expect("reached");
    assert!((solution.q[4] - rad(45.0)).abs() < 1e-12, "405 would pass the end stop");

    let tight = bc("travel_deg = [-10, 105]", "travel_deg = [-90, 90]");
    let error = tight.inverse_nearest(&pose(40.0, 120.0), 0.0, &JointValues::ZERO).expect_err("neither branch");
    let KinematicsError::OverTravel { joint, limit, ref name, ref solution, .. } = error else { panic!("{error}") };
    // The other branch is B -40 C -60: the first joint that passes is B.
    let (expected_joint, expected_limit) = if joint == 3 { (3, rad(-10.0)) } else { (4, rad(90.0)) };
    assert_eq!((joint, limit), (expected_joint, expected_limit));
    assert!(error.to_string().contains(name.as_str()) && error.to_string().contains("degrees"), "{error}");
    let again = tight.forward(&solution.q, 0.0);
    assert!(again.angle_to(&pose(40.0, 120.0)) < 1e-12, "the values past the limit are reported whole");
}

#[test]
fn exactly_on_a_limit_is_inside() {
    let machine = bc("travel_deg = [-10, 90]", "");
    let pose = ToolPose { tip: Point::origin(), axis: Vector::x() };
    let solution = machine.inverse_nearest(&pose, 0.0, &JointValues::ZERO).expect("B90 is the limit");
    assert_eq!(solution.q[3], PI / 2.0);
    assert_eq!(solution.q[4], 0.0);
}

#[test]
fn a_skew_head_tells_what_it_cannot_reach() {
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let machine = machine(&[("B", "tool", "Z", [0.0, h, h], ""), ("C", "workpiece", "base", Z, "")], "B", "C");
    // Half a turn of B lays the tool flat: 90 degrees of tilt is the end of its reach.
    for (tilt, reached) in [(89.0, true), (90.0, true), (91.0, false)] {
        let axis = Vector::new(rad(tilt).sin(), 0.0, rad(tilt).cos());
        let pose = ToolPose { tip: Point::origin(), axis };
        let branches = machine.inverse(&pose, 100.0);
        assert_eq!(!branches.is_empty(), reached, "{tilt}: error {}", branches.axis_error);
        let closest = machine.inverse_closest(&pose, 100.0);
        assert!((closest.axis_error - rad((tilt - 90.0).max(0.0))).abs() < 1e-7, "{}", closest.axis_error);
        let angle = machine.forward(&closest[0].q, 100.0).angle_to(&pose);
        assert!((angle - closest.axis_error).abs() < 1e-7, "{angle}");
    }
    let pose = ToolPose { tip: Point::origin(), axis: -Vector::z() };
    let error = machine.inverse_nearest(&pose, 0.0, &JointValues::ZERO).expect_err("upside down");
    assert!(matches!(error, KinematicsError::AxisUnreachable { angle } if (angle - PI / 2.0).abs() < 1e-12), "{error}");
}

#[test]
fn three_and_four_axes_report_what_they_miss() {
    let three = machine(&[], "Z", "base");
    let upright = ToolPose { tip: Point::new(1.0, 2.0, 3.0), axis: Vector::z() };
    let tilted = ToolPose { axis: Vector::new(0.6, 0.0, 0.8), ..upright };
    assert_eq!(three.inverse(&upright, 10.0)[0].q.0[..3], [1.0, 2.0, 13.0]);
    assert!(three.inverse(&tilted, 10.0).is_empty());
    assert!((three.inverse_closest(&tilted, 10.0)[0].axis_error - 0.6_f64.asin()).abs() < 1e-15);
    assert_eq!(three.rotary_amplification(&JointValues::ZERO), None);

    let four = machine(&[("B", "workpiece", "base", Y, "")], "Z", "B");
    let mut q = JointValues::ZERO;
    q.0[..4].copy_from_slice(&[5.0, 6.0, 7.0, rad(-150.0)]);
    let pose = four.forward(&q, 20.0);
    let branches = four.inverse(&pose, 20.0);
    assert_eq!(branches.len(), 1);
    assert!((branches[0].q - q).max_abs() < 1e-12);
    let off = ToolPose { axis: Vector::new(0.6, 0.1, 0.8).normalize(), ..upright };
    let closest = four.inverse_closest(&off, 0.0);
    assert!((closest[0].axis_error - (0.1 / off_length()).asin()).abs() < 1e-12);
    assert!((four.forward(&closest[0].q, 0.0).angle_to(&off) - closest[0].axis_error).abs() < 1e-12);

    // A table that turns about the tool leaves its angle to the program.
    let dividing = machine(&[("C", "workpiece", "base", Z, "")], "Z", "C");
    let mut previous = JointValues::ZERO;
    previous[3] = rad(30.0);
    let solution = dividing.inverse_nearest(&upright, 0.0, &previous).expect("reached");
    assert!(solution.singular && solution.q[3] == rad(30.0));
    assert!((dividing.forward(&solution.q, 0.0).tip - upright.tip).norm() < 1e-12);
}

fn off_length() -> f64 {
    Vector::new(0.6, 0.1, 0.8).norm()
}

/// More rotary joints than five-axis motion needs: the extra ones are held, and count where they are held.
#[test]
fn held_joints_take_part_where_they_stand() {
    let mut random = Random(11);
    let machine = machine(
        &[
            ("B", "workpiece", "base", Y, ""),
            ("C", "workpiece", "B", Z, ""),
            ("A", "workpiece", "C", [1.0, 0.0, 0.0], "held = true"),
            ("E", "tool", "Z", [0.8, 0.0, 0.6], "held = true"),
        ],
        "E",
        "A",
    );
    for _ in 0..500 {
        let q = random_joints(&machine, &mut random);
        let pose = machine.forward(&q, 60.0);
        match machine.inverse_nearest(&pose, 60.0, &q) {
            Ok(solution) => {
                if machine.smallest_axis_rate(&q).expect("two") > 1e-2 {
                    assert!((solution.q - q).max_abs() < 1e-9, "{:?}", (solution.q - q).max_abs());
                }
            }
            Err(e) => panic!("{e}"),
        }
    }
}

#[test]
fn poses_that_are_no_numbers_are_refused() {
    let machine = bc("", "");
    for pose in [
        ToolPose { tip: Point::new(f64::NAN, 0.0, 0.0), axis: Vector::z() },
        ToolPose { tip: Point::origin(), axis: Vector::zeros() },
        ToolPose { tip: Point::origin(), axis: Vector::new(f64::INFINITY, 0.0, 0.0) },
    ] {
        assert!(machine.inverse(&pose, 0.0).is_empty());
        let error = machine.inverse_nearest(&pose, 0.0, &JointValues::ZERO).expect_err("not finite");
        assert!(matches!(error, KinematicsError::NotFinite { .. }));
    }
}

/// Two slides cannot bring the tip everywhere: the distance is reported.
#[test]
fn missing_slides_leave_a_distance() {
    let text = "name = \"plotter\"\n\
        [[joint]]\nname = \"X\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"base\"\ndirection = [1, 0, 0]\n\
        [[joint]]\nname = \"Y\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"X\"\ndirection = [0, 1, 0]\n";
    let machine = Machine::from_text(Path::new("p.toml"), &(text.to_owned() + &rest("Y", "base", Vector::z())));
    let machine = machine.expect("a plotter is a machine");
    let pose = ToolPose { tip: Point::new(3.0, 4.0, 0.5), axis: Vector::z() };
    let branches = machine.inverse(&pose, 0.0);
    assert!((branches[0].q.0[0] - 3.0).abs() < 1e-12 && (branches[0].tip_error - 0.5).abs() < 1e-12);
    let error = machine.inverse_nearest(&pose, 0.0, &JointValues::ZERO).expect_err("too high");
    assert!(matches!(error, KinematicsError::TipUnreachable { distance } if (distance - 0.5).abs() < 1e-12));
}
