//! The machines of the folder `machines/`: each reads without warnings, its bodies are solids that clear each
//! other at home, and the poses that its scenes need lie within travel.

use std::path::{Path, PathBuf};

use proveout_geom::{Point, Pose, ToolPose, Vector, deg, rad};
use proveout_machine::{Attachment, JointValues, Machine, RemarkSeverity};

fn library() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let entries = std::fs::read_dir(folder).expect("the folder machines/");
    let mut all: Vec<PathBuf> = entries.map(|e| e.expect("entry").path()).filter(|p| p.is_dir()).collect();
    all.sort();
    all
}

fn read(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name)).expect("readable")
}

#[test]
fn every_machine_is_complete() {
    let all = library();
    assert!(all.len() >= 2, "{all:?}");
    for folder in all {
        let machine = Machine::read(&folder).unwrap_or_else(|e| panic!("{e}"));
        let warnings: Vec<String> = machine
            .diagnose()
            .iter()
            .filter(|d| d.severity == RemarkSeverity::Warning)
            .map(ToString::to_string)
            .collect();
        assert!(warnings.is_empty(), "{}: {warnings:#?}", folder.display());
        assert!(folder.join("README.md").is_file(), "{} has no README.md", folder.display());
        for body in &machine.bodies {
            body.mesh.check_solid().unwrap_or_else(|e| panic!("{}: {}: {e}", folder.display(), body.name));
        }
        assert!(machine.first_over_travel(&machine.home()).is_none());
    }
}

/// Axis-aligned boxes of bodies that move differently must not overlap at home, else every check would begin
/// with a collision. At home no body is turned, and the bodies concerned are boxes or are clear of each
/// other's boxes.
#[test]
fn slides_clear_the_table_at_home() {
    for folder in library() {
        let machine = Machine::read(&folder).expect("readable");
        let q = machine.home();
        let on_tool = |a: Attachment| matches!(a, Attachment::Joint(j) if machine.tool_chain.contains(&j));
        let on_work = |a: Attachment| matches!(a, Attachment::Joint(j) if machine.work_chain.contains(&j));
        for (i, a) in machine.bodies.iter().enumerate().filter(|(_, b)| b.check && on_tool(b.attached_to)) {
            for (k, b) in machine.bodies.iter().enumerate().filter(|(_, b)| b.check && on_work(b.attached_to)) {
                let box_of = |n: usize| machine.bodies[n].mesh.transformed(&machine.body_pose(n, &q)).aabb();
                assert!(!box_of(i).intersects(&box_of(k)), "{}: {} and {}", folder.display(), a.name, b.name);
            }
        }
    }
}

/// The tool axis in the workpiece that both machines are described by.
fn tilted(tilt_about: Vector, tilt_deg: f64, c_deg: f64) -> Pose {
    Pose::from_axis_angle(&Vector::z(), rad(c_deg)) * Pose::from_axis_angle(&tilt_about, rad(tilt_deg))
}

#[test]
fn tilting_joints_have_the_sign_of_their_programs() {
    for (name, joint, about) in [("spinner-u5-620", "B", Vector::y()), ("ac-trunnion-620", "A", Vector::x())] {
        let machine = read(name);
        let (tilt, c) = (machine.joint(joint).expect("joint"), machine.joint_for_letter('c').expect("C"));
        for tilt_deg in [-10.0, 0.0, 30.0, -90.0, 90.0] {
            for c_deg in [-135.0, 0.0, 90.0, 270.0] {
                let mut q = JointValues::ZERO;
                q[tilt] = rad(tilt_deg);
                q[c] = rad(c_deg);
                let axis = machine.forward(&q, 0.0).axis;
                assert!((axis - tilted(about, tilt_deg, c_deg).vector(&Vector::z())).norm() < 1e-15);
            }
        }
    }
}

/// Tips round a workpiece whose zero is 100 to 160 mm above the table on the C axis, tool lengths 80 to
/// 150 mm: the face from above, the sides at any C with the tool lying flat, and the retract planes, within
/// travel on both machines. Numbers in the tilted frame: x, y across the tool, z along it.
#[test]
fn the_poses_of_the_scenes_lie_within_travel() {
    let cases = [
        // tilt, x from, x to, y, z from, z to
        (0.0, -80.0, 80.0, 80.0, -28.0, 170.0),
        (30.0, -80.0, 80.0, 80.0, -20.0, 300.0),
        (60.0, -80.0, 80.0, 80.0, -20.0, 300.0),
        // Lying tool: x is downward from the top of the workpiece, z reaches from inside it to the retract
        // plane.
        (90.0, -10.0, 65.0, 80.0, -45.0, 325.0),
    ];
    for (name, about) in [("spinner-u5-620", Vector::y()), ("ac-trunnion-620", Vector::x())] {
        let machine = read(name);
        for height in [100.0, 130.0, 160.0] {
            let table_from_work = Pose::from_translation(Vector::new(0.0, 0.0, height));
            for tool_length in [80.0, 150.0] {
                for (tilt, x0, x1, y, z0, z1) in cases {
                    let mut previous = machine.home();
                    for c in (-135..=270).step_by(45) {
                        let work_from_plane = tilted(about, tilt, f64::from(c));
                        // On the A machine the tilt brings y, not x, downward.
                        let corners = [x0, x1].into_iter().flat_map(|x| [-y, y].map(|y| (x, y)));
                        for (x, y) in corners {
                            for z in [z0, z1] {
                                let p = if about.y == 1.0 { Point::new(x, y, z) } else { Point::new(y, -x, z) };
                                let plane_pose = ToolPose { tip: p, axis: Vector::z() };
                                let pose = plane_pose.transformed(&work_from_plane).transformed(&table_from_work);
                                let solution =
                                    machine.inverse_nearest(&pose, tool_length, &previous).unwrap_or_else(|e| {
                                        panic!("{name} h{height} L{tool_length} t{tilt} C{c} {p}: {e}")
                                    });
                                let again = machine.forward(&solution.q, tool_length);
                                assert!((again.tip - pose.tip).norm() < 1e-9 && again.angle_to(&pose) < 1e-10);
                                previous = solution.q;
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Machine zero, home and the retract moves of the production programs: slide positions are the gauge line's
/// place.
#[test]
fn slides_read_as_the_place_of_the_gauge_line() {
    let machine = read("spinner-u5-620");
    let home = machine.home();
    assert_eq!(machine.machine_from_spindle(&home).translation, Vector::new(-365.0, 224.0, 610.0));
    assert_eq!(machine.table.point, Point::origin());
    let mut q = home;
    q[machine.joint("B").expect("B")] = rad(90.0);
    // The tool lies along +x of the workpiece, so the workpiece's +x points up: exactly.
    assert_eq!(machine.machine_from_table(&q).vector(&Vector::x()), Vector::z());
    assert_eq!(machine.forward(&q, 100.0).axis, Vector::x());
    assert_eq!(deg(q[machine.joint("B").expect("B")]), 90.0);
}
