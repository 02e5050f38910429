//! Chains without a closed form: three rotary joints that move, four slides.

use std::path::Path;

use crate::kinematics::{
    branches::{Y, Z, machine},
    common::{Random, random_joints, rest},
};
use proveout_geom::{ToolPose, Vector, rad};
use proveout_machine::{JointValues, KinematicsError, Machine};

const X: [f64; 3] = [1.0, 0.0, 0.0];

/// B and C tables under an A head, once all moving and once with A held.
fn six(a_keys: &str) -> Machine {
    let rotary = [("B", "workpiece", "base", Y, ""), ("C", "workpiece", "B", Z, ""), ("A", "tool", "Z", X, a_keys)];
    machine(&rotary, "A", "C")
}

#[test]
fn a_third_rotary_joint_is_solved_numerically() {
    let moving = six("");
    assert!(!moving.has_closed_form() && six("held = true").has_closed_form());
    let mut random = Random(41);
    let (mut solved, mut worst) = (0, [0.0_f64; 2]);
    for _ in 0..3000 {
        let q = random_joints(&moving, &mut random);
        let pose = moving.forward(&q, 80.0);
        // From a place anywhere on the machine, as a first pose is, and from one next to it.
        let mut near = q;
        for &j in moving.rotary_joints() {
            near[j] += random.range(-0.05, 0.05);
        }
        for start in [near, random_joints(&moving, &mut random)] {
            let solution = moving.inverse_nearest(&pose, 80.0, &start).unwrap_or_else(|e| panic!("{e}"));
            let again = moving.forward(&solution.q, 80.0);
            worst[0] = worst[0].max((again.tip - pose.tip).norm());
            worst[1] = worst[1].max(again.angle_to(&pose));
            assert!(solution.axis_error < 1e-10 && solution.tip_error < 1e-9, "{solution:?}");
            solved += 1;
        }
    }
    assert_eq!(solved, 6000);
    assert!(worst[0] < 1e-9 && worst[1] < 1e-10, "{worst:?}");
}

/// Near the start the motion is the smallest one: no larger than with the third joint held, but for the
/// curvature, which is of the size of the step.
#[test]
fn the_numerical_way_is_the_smallest_motion() {
    let (moving, held) = (six(""), six("held = true"));
    let mut random = Random(42);
    let size = |a: &JointValues, b: &JointValues| {
        moving.rotary_joints().iter().map(|&j| (a[j] - b[j]).powi(2)).sum::<f64>().sqrt()
    };
    let (mut compared, mut shorter) = (0, 0);
    for _ in 0..1000 {
        let start = random_joints(&moving, &mut random);
        if held.smallest_axis_rate(&start).expect("two") < 0.1 {
            continue;
        }
        let mut aim = start;
        aim[4] += 1e-3;
        aim[3] -= 1e-3;
        let pose = moving.forward(&aim, 0.0);
        let ours = moving.inverse_nearest(&pose, 0.0, &start).expect("reached").q;
        let theirs = held.inverse_nearest(&pose, 0.0, &start).expect("reached").q;
        assert!(
            size(&ours, &start) < size(&theirs, &start) * 1.03,
            "{} {}",
            size(&ours, &start),
            size(&theirs, &start)
        );
        shorter += usize::from(size(&ours, &start) < 0.99 * size(&theirs, &start));
        compared += 1;
    }
    assert!(compared > 500 && shorter > compared / 2, "{shorter} of {compared}");
}

#[test]
fn end_stops_leave_the_work_to_the_other_joints() {
    let stopped = six("travel_deg = [-5, 5]");
    let axis = Vector::new(0.5, 0.6, 0.624_499_799_839_839_8).normalize();
    let pose = ToolPose { tip: [1.0, 2.0, 3.0].into(), axis };
    let solution = stopped.inverse_nearest(&pose, 50.0, &JointValues::ZERO).expect("B and C reach it");
    let again = stopped.forward(&solution.q, 50.0);
    assert!((again.tip - pose.tip).norm() < 1e-9 && again.angle_to(&pose) < 1e-10);
    assert!(solution.q[5].abs() <= rad(5.0) + 1e-9);
}

#[test]
fn what_no_joint_reaches_is_reported_with_its_residual() {
    // Heads that tilt by 30 degrees at most cannot look sideways.
    let keys = "travel_deg = [-10, 10]";
    let rotary = [("B", "tool", "Z", Y, keys), ("A", "tool", "B", X, keys), ("E", "tool", "A", Y, keys)];
    let machine = machine(&rotary, "E", "base");
    let pose = ToolPose { tip: [0.0; 3].into(), axis: Vector::x() };
    let error = machine.inverse_nearest(&pose, 0.0, &JointValues::ZERO).expect_err("90 degrees");
    let KinematicsError::AxisUnreachable { angle } = error else { panic!("{error}") };
    assert!((angle - rad(70.0)).abs() < 1e-3, "B and E tilt by 20 degrees together: {}", angle.to_degrees());
    let closest = machine.inverse_closest(&pose, 0.0);
    let reached = machine.forward(&closest[0].q, 0.0).angle_to(&pose);
    assert!((closest[0].axis_error - reached).abs() < 1e-12);
}

/// A quill next to Z: the smallest motion shares the way between both.
#[test]
fn a_fourth_slide_shares_the_way() {
    let mut text = "name = \"quill\"\n".to_owned();
    for (name, parent, d) in [("X", "base", X), ("Y", "X", Y), ("Z", "Y", Z), ("W", "Z", Z)] {
        text += &format!(
            "[[joint]]\nname = {name:?}\nkind = \"linear\"\ncarries = \"tool\"\nparent = {parent:?}\ndirection = {d:?}\n"
        );
    }
    let machine = Machine::from_text(Path::new("q.toml"), &(text + &rest("W", "base", Vector::z()))).expect("taken");
    let pose = ToolPose { tip: [3.0, 4.0, 10.0].into(), axis: Vector::z() };
    let mut previous = JointValues::ZERO;
    previous[3] = 2.0;
    let solution = machine.inverse_nearest(&pose, 0.0, &previous).expect("reached");
    assert!((solution.q.0[2] - 4.0).abs() < 1e-12 && (solution.q.0[3] - 6.0).abs() < 1e-12, "{:?}", solution.q);
    assert!((machine.forward(&solution.q, 0.0).tip - pose.tip).norm() < 1e-12 && solution.tip_error < 1e-12);
}

/// Pose by pose, without branches: no pose is left and no joint jumps.
#[test]
fn paths_of_redundant_machines_are_followed() {
    let moving = six("travel_deg = [-20, 20]");
    let mut before = moving.home();
    for k in 0..60 {
        let angle = 0.05 * f64::from(k);
        let axis = Vector::new(0.5 * angle.cos(), 0.5 * angle.sin(), 0.75_f64.sqrt());
        let pose = ToolPose { tip: [10.0 * angle, 0.0, 5.0].into(), axis };
        let q = moving.inverse_nearest(&pose, 60.0, &before).expect("followed").q;
        let again = moving.forward(&q, 60.0);
        assert!((again.tip - pose.tip).norm() < 1e-9 && again.angle_to(&pose) < 1e-10);
        let turn = moving.rotary_joints().iter().map(|&j| (q[j] - before[j]).abs()).fold(0.0, f64::max);
        assert!(k == 0 || turn < rad(10.0), "pose {k}: {}", turn.to_degrees());
        before = q;
    }
}
