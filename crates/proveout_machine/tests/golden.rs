//! The four machine families of `tests/reference/kinematics_golden.csv`: pose to joints and back, to 1e-9.
//!
//! The linear columns of the file give the tip with the head at zero, so the spindle's gauge line at zero is
//! put one pivot length (and the head's axes as well) above the machine zero and the tool length equals it:
//! then a slide position is the file's coordinate.
#![allow(clippy::print_stdout, reason = "figures for people, shown with --nocapture")]

use std::path::Path;

use proveout_geom::{Point, ToolPose, Vector, rad, wrap_near};
use proveout_machine::{JointValues, Machine};

/// The file has nine decimals: half a unit in each of three coordinates (0.9e-9 mm) and half a unit of an
/// angle, 0.5e-9 degrees, on an arm of up to 200 mm (1.7e-9 mm).
const POSITION_MM: f64 = 2.6e-9;
/// Half a unit in each of three components of the axis.
const AXIS_RAD: f64 = 1e-9;

fn machine(family: &str) -> Machine {
    let rotary = |name: &str, carries: &str, parent: &str, direction: [f64; 3], point: [f64; 3]| {
        let sense = if carries == "tool" { 1 } else { -1 };
        format!(
            "[[joint]]\nname = {name:?}\nkind = \"rotary\"\ncarries = {carries:?}\nparent = {parent:?}\n\
             direction = {direction:?}\npoint_mm = {point:?}\nsense = {sense}\n"
        )
    };
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let (joints, spindle, table, gauge) = match family {
        "ab_table_head" => (
            rotary("A", "workpiece", "base", x, [0.0; 3]) + &rotary("B", "tool", "Z", y, [0.0, 0.0, 200.0]),
            "B",
            "A",
            200.0,
        ),
        "bc_head_table" => (
            rotary("C", "workpiece", "base", z, [0.0; 3]) + &rotary("B", "tool", "Z", y, [0.0, 0.0, 150.0]),
            "B",
            "C",
            150.0,
        ),
        "ac_table_table" => (
            rotary("A", "workpiece", "base", x, [0.0, 0.0, -40.0]) + &rotary("C", "workpiece", "A", z, [5.0, 0.0, 0.0]),
            "Z",
            "C",
            0.0,
        ),
        _ => (
            rotary("B", "workpiece", "base", y, [0.0, 0.0, -50.0]) + &rotary("C", "workpiece", "B", z, [0.0, 3.0, 0.0]),
            "Z",
            "C",
            0.0,
        ),
    };
    let mut text = format!("name = {family:?}\n");
    for (name, parent, d) in [("X", "base", x), ("Y", "X", y), ("Z", "Y", z)] {
        text += &format!(
            "[[joint]]\nname = {name:?}\nkind = \"linear\"\ncarries = \"tool\"\nparent = {parent:?}\ndirection = {d:?}\n"
        );
    }
    text += &joints;
    text += &format!(
        "[spindle]\non = {spindle:?}\norigin_mm = [0, 0, {gauge}]\ndirection = [0, 0, 1]\nstart_time_s = 1\n\
         [table]\non = {table:?}\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [control]\ncycle_time_ms = 1\nblock_time_ms = 1\ntool_change_time_s = 5\nrapid_mode = \"straight\"\n\
         default_tolerance_mm = 0.01\n"
    );
    Machine::from_text(Path::new("golden.toml"), &text).expect("the machine is right")
}

#[test]
fn the_golden_poses_are_reproduced() {
    let text = include_str!("reference/kinematics_golden.csv");
    let mut rows = 0;
    let mut worst = [0.0_f64; 4];
    for line in text.lines().skip(1) {
        let f: Vec<&str> = line.split(',').collect();
        let n: Vec<f64> = f[3..].iter().map(|t| t.parse().expect("number")).collect();
        let machine = machine(f[0]);
        let tool = if f[0].contains("head") { machine.spindle.gauge_pose.translation.z } else { 0.0 };
        let mut q = JointValues::ZERO;
        for (name, value) in [("X", n[7]), ("Y", n[8]), ("Z", n[9]), (f[1], rad(n[10])), (f[2], rad(n[11]))] {
            q[machine.joint(name).expect("joint")] = value;
        }
        let (tip, axis) = (Point::new(n[1], n[2], n[3]), Vector::new(n[4], n[5], n[6]));
        let pose = machine.forward(&q, tool);
        worst[0] = worst[0].max((pose.tip - tip).norm());
        worst[1] = worst[1].max((pose.axis - axis).norm());

        let placed = machine.inverse_with_rotary(&tip, &q, tool);
        worst[2] = worst[2].max((placed - q).max_abs());

        let rounded = ToolPose { tip, axis: axis.normalize() };
        let branch_of_file = if n[0] > 0.0 { 0 } else { 1 };
        let branches = machine.inverse(&rounded, tool);
        let branch = &branches[branch_of_file];
        let rate = machine.smallest_axis_rate(&q).expect("two rotary joints");
        for &j in machine.rotary_joints() {
            // What matters is the turn of the axis: the joint's error times the rate at which it turns it.
            worst[3] = worst[3].max((branch.q[j] - wrap_near(q[j], branch.q[j])).abs() * rate);
        }
        rows += 1;
    }
    println!("tip, axis, slides, turn: {}", worst.map(|v| format!("{v:.2e}")).join(", "));
    assert!(rows == 70, "only {rows} rows");
    assert!(worst[0] < POSITION_MM, "tip {}", worst[0]);
    assert!(worst[1] < AXIS_RAD, "axis {}", worst[1]);
    assert!(worst[2] < POSITION_MM, "slide {}", worst[2]);
    assert!(worst[3] < AXIS_RAD, "turn {}", worst[3]);
}

/// Rotary angles of two published methods' machines, both branches: a head-table and a table-table machine.
#[test]
fn the_golden_angles_are_reproduced() {
    let files = [
        ("bc_head_table", ["B", "C"], include_str!("reference/singularity_golden_ik.csv")),
        ("ac_table_table", ["A", "C"], include_str!("reference/min-angular-acceleration_golden_ik.csv")),
    ];
    for (family, names, text) in files {
        let machine = machine(family);
        let mut rows = 0;
        for line in text.lines().skip(1) {
            let n: Vec<f64> = line.split(',').map(|t| t.parse().expect("number")).collect();
            let axis = Vector::new(n[0], n[1], n[2]);
            let branches = machine.inverse(&ToolPose { tip: Point::origin(), axis: axis.normalize() }, 0.0);
            // Twelve significant digits of the axis, divided by its distance from the singular axis.
            let bound = 1e-12 / n[0].hypot(n[1]) + rad(1e-9);
            for (branch, angles) in branches.iter().zip(n[3..7].chunks(2)) {
                for (name, &degrees) in names.iter().zip(angles) {
                    let angle = branch.q[machine.joint(name).expect("joint")];
                    let error = (angle - wrap_near(rad(degrees), angle)).abs();
                    assert!(error < bound, "{family} {name}: {} against {degrees}", angle.to_degrees());
                }
            }
            assert_eq!(branches.len(), 2);
            rows += 1;
        }
        assert!(rows >= 8, "{rows} rows");
    }
}
