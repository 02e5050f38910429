//! The library as `proveout_machine` reads it: complete, closed, in agreement with its kinematics, clear of
//! itself.

use std::{collections::BTreeSet, path::PathBuf};

use proveout_collision::Interference;
use proveout_geom::{Point, Vector};
use proveout_machine::{Attachment, JointValues, Machine};

use super::{MARK, library::LIBRARY};
use crate::workspace_root;

/// Coordinates of a model are rounded to a micrometer and stored in single precision, twice for a joint's
/// node.
const MODEL_MM: f64 = 2e-3;

fn folder(name: &str) -> PathBuf {
    workspace_root().join("machines").join(name)
}

fn machine(name: &str) -> Machine {
    Machine::read(&folder(name)).unwrap_or_else(|e| panic!("{e}"))
}

fn all() -> impl Iterator<Item = (&'static str, Machine)> {
    LIBRARY.iter().map(|(name, _)| (*name, machine(name)))
}

#[test]
fn every_machine_reads_without_remarks_and_is_described() {
    for (name, machine) in all() {
        assert_eq!(machine.diagnose(), [], "{name}");
        assert!(machine.first_over_travel(&machine.home()).is_none(), "{name}");
        let readme = std::fs::read_to_string(folder(name).join("README.md")).expect("README.md");
        for part in ["```", "**Chain.**", "**Signs and zero.**", "| number | value | basis | trust |"] {
            assert!(readme.contains(part), "{name}: README.md lacks {part}");
        }
        for joint in &machine.joints {
            assert!(
                readme.contains(&format!("| {} `", joint.name)),
                "{name}: README.md says nothing of {}",
                joint.name
            );
        }
    }
}

#[test]
fn every_folder_is_in_a_list() {
    let in_lists: BTreeSet<&str> = LIBRARY.iter().map(|(name, _)| *name).collect();
    let overview = std::fs::read_to_string(folder("README.md")).expect("machines/README.md");
    for entry in std::fs::read_dir(folder("")).expect("machines/") {
        let path = entry.expect("entry").path();
        if !path.is_dir() {
            continue;
        }
        let name = path.file_name().and_then(|n| n.to_str()).expect("name");
        let made = std::fs::read_to_string(path.join("machine.toml")).expect("machine.toml").contains(MARK);
        assert_eq!(made, in_lists.contains(name), "{name}");
        assert!(overview.contains(&format!("({name})")), "machines/README.md does not list {name}");
    }
}

#[test]
fn every_joint_moves_a_closed_body_and_every_node_is_bound() {
    for (name, machine) in all() {
        assert!(machine.unused_nodes.is_empty(), "{name}: {:?}", machine.unused_nodes);
        for body in &machine.bodies {
            body.mesh.check_solid().unwrap_or_else(|e| panic!("{name}: {}: {e}", body.name));
        }
        for (j, joint) in machine.joints.iter().enumerate() {
            // The heave of a platform on legs moves the tilting plate alone.
            if machine.joints.iter().any(|tilt| tilt.parent == Some(j))
                && (name, joint.name.as_str()) == ("lu-hybrid-ii", "Z")
            {
                continue;
            }
            let checked = |b: &proveout_machine::MachineBody| b.attached_to == Attachment::Joint(j) && b.check;
            assert!(machine.bodies.iter().any(checked), "{name}: joint {} moves no checked body", joint.name);
        }
        // Recognizable: castings, guides and more than one shade.
        let colors: BTreeSet<[u8; 4]> = machine.bodies.iter().map(|b| b.color).collect();
        assert!(machine.bodies.len() >= 10 && colors.len() >= 4, "{name}");
    }
}

/// Least height of a mesh over a point along a direction, and the middle of what lies at that height.
fn foot(mesh: &proveout_geom::TriMesh, from: &Point, along: &Vector) -> (f64, Point) {
    let height = |p: &Point| (p - from).dot(along);
    let least = mesh.positions.iter().map(height).fold(f64::INFINITY, f64::min);
    let low: Vec<&Point> = mesh.positions.iter().filter(|p| height(p) < least + MODEL_MM).collect();
    let sum = low.iter().fold(Vector::zeros(), |s, p| s + p.coords);
    (least, Point::from(sum / low.len() as f64))
}

#[test]
fn the_spindle_nose_ends_at_the_gauge_line_and_the_table_at_its_face() {
    for (name, machine) in all() {
        let gauge = machine.machine_from_spindle(&JointValues::ZERO);
        let (origin, axis) = (Point::from(gauge.translation), gauge.vector(&Vector::z()));
        let nose = machine.bodies.iter().find(|b| b.role == "spindle_nose").expect("spindle_nose");
        assert_eq!(nose.attached_to, machine.spindle.attached_to, "{name}");
        let (least, middle) = foot(&nose.mesh, &origin, &axis);
        assert!(least.abs() < MODEL_MM && (middle - origin).norm() < MODEL_MM, "{name}: nose {least} {middle}");
        // Clamping faces look along the normal: the highest point of the table is the face.
        let table = machine.bodies.iter().find(|b| b.role == "table" && b.attached_to == machine.table.attached_to);
        let table = table.unwrap_or_else(|| panic!("{name}: no table"));
        let (least, middle) = foot(&table.mesh, &machine.table.point, &-machine.table.normal);
        assert!(least.abs() < MODEL_MM && (middle - machine.table.point).norm() < MODEL_MM, "{name}: {least} {middle}");
    }
}

/// Bodies on bearings: a full turn of the joint alone must not change the outer radius, thus bearing parts
/// are round about the axis of their joint.
#[test]
fn journals_and_pivots_are_round_about_their_axis() {
    let mut seen = 0;
    for (name, machine) in all() {
        for body in
            machine.bodies.iter().filter(|b| ["journals", "spindle_pivots", "table_hub"].contains(&b.name.as_str()))
        {
            let Attachment::Joint(j) = body.attached_to else { panic!("{name}: {} does not turn", body.name) };
            let joint = &machine.joints[j];
            let sum = body.mesh.positions.iter().fold(Vector::zeros(), |s, p| s + (p - joint.point));
            let middle = sum / body.mesh.positions.len() as f64;
            let off = (middle - joint.direction * middle.dot(&joint.direction)).norm();
            assert!(off < MODEL_MM, "{name}: {} is {off} mm off the axis of {}", body.name, joint.name);
            seen += 1;
        }
    }
    assert!(seen >= 8, "{seen}");
}

/// Every joint through its travel (rotary ones at most a turn), one at a time from home: no body meets
/// another.
#[test]
fn no_body_meets_another_from_home_over_each_joint_alone() {
    for (name, machine) in all() {
        let mut check = Interference::new(&machine, &[], 0.0).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(!check.pairs().is_empty(), "{name}");
        let home = machine.home();
        let mut time = 0.0;
        let mut go = |from: &JointValues, to: &JointValues| {
            check.check_piece(from, to, [time, time + 1.0], 0.0);
            time += 1.0;
        };
        go(&home, &home);
        for (j, joint) in machine.joints.iter().enumerate() {
            let full = std::f64::consts::TAU;
            let [low, high] = joint.travel.unwrap_or([0.0, full]);
            let ends = if joint.is_rotary() { [low.max(-full), high.min(full)] } else { [low, high] };
            for end in ends {
                let mut to = home;
                to[j] = end;
                go(&home, &to);
                go(&to, &home);
            }
        }
        let breaches: Vec<String> = check.breaches().iter().map(|b| format!("{b:?}")).collect();
        assert!(breaches.is_empty(), "{name}: {} breaches, first {}", breaches.len(), breaches[0]);
    }
}

/// The working poses that the pictures show.
#[test]
fn no_body_meets_another_in_the_working_poses() {
    let text = std::fs::read_to_string(folder("poses.csv")).expect("machines/poses.csv");
    for (name, machine) in all() {
        let mut q = machine.home();
        for (j, joint) in machine.joints.iter().enumerate() {
            q[j] = joint.travel.filter(|_| !joint.is_rotary()).map_or(0.0, |[low, high]| 0.5 * (low + high));
        }
        let mut named = 0;
        for line in text.lines().filter(|l| l.split(',').next() == Some(name)) {
            let [_, joint, position, unit] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
            let position: f64 = position.parse().expect("number");
            let j = machine.joint(joint).expect("joint");
            assert_eq!(unit == "deg", machine.joints[j].is_rotary(), "{line}");
            q[j] = if unit == "deg" { position.to_radians() } else { position };
            named += 1;
        }
        assert!(named >= 3, "{name} has no working pose");
        assert!(machine.first_over_travel(&q).is_none(), "{name}");
        let mut check = Interference::new(&machine, &[], 0.0).unwrap_or_else(|e| panic!("{name}: {e}"));
        check.check_piece(&q, &q, [0.0, 1.0], 0.0);
        assert!(check.breaches().is_empty(), "{name}: {:?}", check.breaches().first());
    }
}

#[test]
fn models_are_small() {
    let mut total = 0;
    for (name, _) in LIBRARY {
        let size = std::fs::metadata(folder(name).join("model.glb")).expect("model.glb").len();
        assert!(size < 250_000, "{name}: {size} bytes");
        total += size;
    }
    // A clone carries them all.
    assert!(total < 4_000_000, "{total} bytes");
}

/// Rows of a table of reference values, by column name; texts stay texts.
fn rows(name: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    let path = workspace_root().join("crates/proveout_machine/tests/reference").join(name);
    let text = std::fs::read_to_string(&path).expect("reference values");
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().expect("head").split(',').collect();
    lines.map(|l| head.iter().map(|h| (*h).to_owned()).zip(l.split(',').map(str::to_owned)).collect()).collect()
}

/// The reference values have nine decimals: half a unit of the last one in each of three slides, and in two
/// angles at no more than 700 mm from the axes.
const REFERENCE_MM: f64 = 1e-8;

#[test]
fn machines_of_the_papers_reproduce_the_reference_values() {
    let kinds = [
        ("ab_table_head", "starrag-lx-451"),
        ("bc_head_table", "bc-head-table-grinder"),
        ("ac_table_table", "ma-ac-trunnion"),
        ("bc_table_table", "jdgr200t"),
    ];
    for (kind, name) in kinds {
        let machine = machine(name);
        let all: Vec<_> = rows("kinematics_golden.csv").into_iter().filter(|r| r["machine"] == kind).collect();
        assert!(all.len() >= 8, "{kind}: {}", all.len());
        for row in all {
            let number = |key: &str| -> f64 { row[key].parse().expect("number") };
            let mut q = JointValues::ZERO;
            for key in ["X", "Y", "Z"] {
                q[machine.joint(key).expect("slide")] = number(&format!("{key}_mm"));
            }
            for key in ["1", "2"] {
                let joint = machine.joint(&row[&format!("axis_r{key}")]).expect("rotary joint");
                q[joint] = number(&format!("r{key}_deg")).to_radians();
            }
            let pose = machine.forward(&q, 0.0);
            let tip = Point::new(number("px_mm"), number("py_mm"), number("pz_mm"));
            let axis = Vector::new(number("ti"), number("tj"), number("tk"));
            assert!((pose.tip - tip).norm() < REFERENCE_MM, "{name}: {} {tip}", pose.tip);
            assert!((pose.axis - axis).norm() < REFERENCE_MM, "{name}: {} {axis}", pose.axis);
        }
    }
}

#[test]
fn the_hybrid_machine_reproduces_its_reference_values() {
    let machine = machine("lu-hybrid-ii");
    let all = rows("hybrid_3rps_golden.csv");
    assert!(all.len() >= 8);
    for row in all {
        let number = |key: &str| -> f64 { row[key].parse().expect("number") };
        let mut q = JointValues::ZERO;
        for (joint, key) in [("X", "X_mm"), ("Y", "Y_mm"), ("Z", "heave_mm"), ("A", "alpha_deg"), ("B", "beta_deg")] {
            let value = number(key);
            q[machine.joint(joint).expect("joint")] = if key.ends_with("deg") { value.to_radians() } else { value };
        }
        let pose = machine.forward(&q, 0.0);
        // The blade's origin is at (0, 0, 460) with all joints at zero.
        let tip = Point::new(number("px_mm"), number("py_mm"), 460.0 + number("pz_mm"));
        let axis = Vector::new(number("ti"), number("tj"), number("tk"));
        assert!((pose.tip - tip).norm() < REFERENCE_MM, "{} {tip}", pose.tip);
        assert!((pose.axis - axis).norm() < REFERENCE_MM, "{} {axis}", pose.axis);
    }
}

/// Closed forms of the documentation of `LinuxCNC`: the tip of the bridge mill, the tool axis of the tilting
/// table.
#[test]
fn machines_of_linuxcnc_move_as_documented() {
    let (bridge, trunnion) = (machine("linuxcnc-bridge-mill"), machine("linuxcnc-xyzac-trt"));
    for k in 0..40 {
        let turn = |n: f64| (f64::from(k) * n).sin();
        let (b, c, a) = (2.0 * turn(0.7), 3.0 * turn(1.3), 1.5 * turn(0.9));
        let (x, y, z) = (400.0 * turn(0.31), 300.0 * turn(0.53), -200.0 + 200.0 * turn(0.17));
        let mut q = JointValues::ZERO;
        for (joint, value) in [("X", x), ("Y", y), ("Z", z), ("B", b), ("C", c)] {
            q[bridge.joint(joint).expect("joint")] = value;
        }
        let tool_length = 100.0;
        let pivot = 250.0 + tool_length;
        let tip = Point::new(
            x + pivot * b.sin() * c.cos(),
            y + pivot * b.sin() * c.sin(),
            z - tool_length + pivot * (1.0 - b.cos()),
        );
        assert!((bridge.forward(&q, tool_length).tip - tip).norm() < 1e-9);
        let mut q = JointValues::ZERO;
        for (joint, value) in [("A", a), ("C", c)] {
            q[trunnion.joint(joint).expect("joint")] = value;
        }
        let axis = Vector::new(a.sin() * c.sin(), a.sin() * c.cos(), a.cos());
        assert!((trunnion.forward(&q, 0.0).axis - axis).norm() < 1e-12);
    }
}
