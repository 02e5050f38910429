//! Tool poses of an imported machine against those of the description.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use proveout_machine::{Carries, JointValues, Machine, UrdfOptions, import_urdf};

use crate::urdf::{
    Desk, Random, between, of_head,
    oracle::{M4, OracleJoint, joints, root_from_link, times, undone},
    sample, sample_text,
};

/// Which joint of the file an axis is, and whether the control counts against it.
type Letters<'a> = &'a [(&'a str, &'a str, bool)];

/// Largest difference in mm and in the axis between both at zero, at both ends of every joint, and at random
/// places.
fn compare(
    machine: &Machine,
    all: &[OracleJoint],
    letters: Letters<'_>,
    [tool, table]: [&str; 2],
    into: [f64; 3],
    seed: u64,
) {
    let mut random = Random(seed);
    let range = |name: &str| {
        let j = all.iter().find(|j| j.name == name).expect("joint");
        if j.kind == "continuous" { [-7.0, 7.0] } else { j.limit }
    };
    let moving: Vec<&str> = letters.iter().map(|l| l.1).collect();
    let mut states: Vec<BTreeMap<String, f64>> = vec![BTreeMap::new()];
    for name in &moving {
        for end in range(name) {
            let mut state: BTreeMap<String, f64> =
                moving.iter().map(|n| ((*n).to_owned(), random.between(range(n)[0], range(n)[1]))).collect();
            state.insert((*name).to_owned(), end);
            states.push(state);
        }
    }
    while states.len() < 100 {
        states.push(moving.iter().map(|n| ((*n).to_owned(), random.between(range(n)[0], range(n)[1]))).collect());
    }
    // K of the machine equals the frame of the root with all joints at zero.
    let root_from_table_at_zero = root_from_link(all, table, &BTreeMap::new());
    for state in &states {
        let table_from_tool = times(&undone(&root_from_link(all, table, state)), &root_from_link(all, tool, state));
        let wanted: M4 = times(&root_from_table_at_zero, &table_from_tool);
        let mut q = JointValues::ZERO;
        for (letter, name, reversed) in letters {
            let j = machine.joint(letter).unwrap_or_else(|| panic!("no {letter}"));
            let value = state.get(*name).copied().unwrap_or(0.0);
            let in_unit = if machine.joints[j].is_rotary() { value } else { value * 1e3 };
            q[j] = if *reversed { -in_unit } else { in_unit };
            assert_eq!(machine.joints[j].travel_violation(q[j]), None, "{letter} at {}", q[j]);
        }
        let got = machine.forward(&q, 0.0);
        let axis: Vec<f64> = (0..3).map(|r| (0..3).map(|c| wanted[r][c] * into[c]).sum()).collect();
        for k in 0..3 {
            // Places of the file are written with nine decimals of a millimeter.
            assert!((got.tip[k] - wanted[k][3] * 1e3).abs() < 1e-6, "{state:?}: {got:?} {wanted:?}");
            assert!((got.axis[k] - axis[k]).abs() < 1e-9, "{state:?}: {got:?} {wanted:?}");
        }
        // The whole pose of the tool moves as the link does.
        let pose = machine.table_from_spindle(&q);
        let at_zero = machine.table_from_spindle(&JointValues::ZERO);
        let wanted_at_zero = times(
            &root_from_table_at_zero,
            &times(&undone(&root_from_table_at_zero), &root_from_link(all, tool, &BTreeMap::new())),
        );
        for (r, of_link) in wanted.iter().enumerate().take(3) {
            for (c, of_link_at_zero) in wanted_at_zero.iter().enumerate().take(3) {
                // R_KS(q) R_KS(0)^T is the turn of the tool in K on both sides.
                let of_machine: f64 = (0..3).map(|k| pose.rotation[(r, k)] * at_zero.rotation[(c, k)]).sum();
                let of_file: f64 = of_link.iter().zip(of_link_at_zero).take(3).map(|(a, b)| a * b).sum();
                assert!((of_machine - of_file).abs() < 1e-9, "{state:?}");
            }
        }
    }
}

/// The text with the digits of right angles that the import squares, so that both mean the same angle.
fn squared(text: &str) -> String {
    let half = std::f64::consts::FRAC_PI_2.to_string();
    let whole = std::f64::consts::PI.to_string();
    ["3.14159265", "3.1416"].iter().fold(text.replace("1.5708", &half).replace("1.5707963", &half), |t, pi| {
        t.replace(&format!("\"{pi} "), &format!("\"{whole} ")).replace(&format!(" {pi}\""), &format!(" {whole}\""))
    })
}

#[test]
fn the_trunnion_moves_as_its_description() {
    let desk = Desk::new();
    let made = import_urdf(&sample("trunnion.urdf"), &between("spindle", "table")).expect("read");
    let machine = desk.machine(&made);
    let letters = [
        ("X", "x_axis", false),
        ("Y", "y_axis", false),
        ("Z", "z_axis", false),
        ("A", "a_axis", false),
        ("C", "c_axis", false),
    ];
    let all = joints(&squared(&sample_text("trunnion.urdf")));
    compare(&machine, &all, &letters, ["spindle", "table"], [0.0, 0.0, 1.0], 1);
    let text = made.notes.join("\n");
    assert!(!text.contains("--reverse"), "axes count as programs do: {text}");
    // Axes that run with their letters: X, Y, Z move the tool along the frame of the table, exactly.
    assert!(machine.program_zero().is_some_and(|p| (p.z - 1510.0).abs() < 1e-9), "{:?}", machine.program_zero());
    for (letter, carries) in [("X", Carries::Tool), ("A", Carries::Workpiece), ("C", Carries::Workpiece)] {
        let joint = &machine.joints[machine.joint(letter).expect("axis")];
        assert_eq!(joint.carries, carries);
        assert_eq!(joint.sense, if carries == Carries::Tool { 1.0 } else { -1.0 });
    }
    let a = &machine.joints[machine.joint("A").expect("A")];
    assert_eq!([a.direction.x, a.direction.y, a.direction.z], [1.0, 0.0, 0.0], "the way of the tool (ISO 841)");
    assert!(machine.joints[machine.joint("C").expect("C")].endless);
    let x = &machine.joints[machine.joint("X").expect("X")];
    assert_eq!(x.travel, Some([-370.0, 250.0]));
    assert!((x.max_velocity.expect("given") - 600.0).abs() < 1e-9 && x.max_jerk.is_some());
    let z = &machine.joints[machine.joint("Z").expect("Z")];
    assert_eq!(z.home, 0.0, "off the table");
    for key in ["max_acceleration_mm_s2", "max_jerk_mm_s3", "home_mm"] {
        assert!(machine.trust.iter().any(|t| t.chosen && t.key == format!("joint.X.{key}")), "{key} is marked");
    }
}

#[test]
fn the_swivel_head_moves_as_its_description() {
    let desk = Desk::new();
    let made = import_urdf(&sample("head.urdf"), &of_head()).expect("read");
    let machine = desk.machine(&made);
    let letters = [
        ("X", "joint_1", false),
        ("Y", "joint_2", false),
        ("Z", "joint_3", false),
        ("B", "joint_B", false),
        ("C", "joint_C", false),
    ];
    let all = joints(&squared(&sample_text("head.urdf")));
    compare(&machine, &all, &letters, ["nose", "table"], [0.0, 0.0, -1.0], 2);
    assert!(machine.program_zero().is_some());
    let text = made.notes.join("\n");
    assert!(text.contains("door_hinge") && text.contains("X is joint \"joint_1\""), "{text}");
    assert_eq!(machine.in_one_line().split(';').next(), Some("Y C table, X Z B tool"));
}

/// A control that counts against the joint: same places at the opposite value, travel turned.
#[test]
fn reversed_axes_count_the_other_way() {
    let desk = Desk::new();
    let text = sample_text("trunnion.urdf")
        .replace("<axis xyz=\"0 0 -1\"/>", "<axis xyz=\"0 0 1\"/>")
        .replace("rpy=\"0 0 3.14159265\"", "");
    let output = desk.import(&text, &between("spindle", "table")).expect("read").notes.join("\n");
    assert!(output.contains("--reverse A,C"), "{output}");
    let options = UrdfOptions { reverse: Some("A,C".into()), ..between("spindle", "table") };
    let made = desk.import(&text, &options).expect("read");
    assert!(!made.notes.join("\n").contains("--reverse"));
    let machine = desk.machine(&made);
    let letters = [
        ("X", "x_axis", false),
        ("Y", "y_axis", false),
        ("Z", "z_axis", false),
        ("A", "a_axis", true),
        ("C", "c_axis", true),
    ];
    compare(&machine, &joints(&text), &letters, ["spindle", "table"], [0.0, 0.0, 1.0], 3);
    // A and C of the tool past the workpiece: t_W = Rz(C) Rx(A) e_z (CONVENTIONS.md).
    let mut q = JointValues::ZERO;
    (q[machine.joint("A").expect("A")], q[machine.joint("C").expect("C")]) = (0.4, 0.3);
    let axis = machine.forward(&q, 0.0).axis;
    let (sa, ca, sc, cc) = (0.4_f64.sin(), 0.4_f64.cos(), 0.3_f64.sin(), 0.3_f64.cos());
    for (got, wanted) in axis.iter().zip([sc * sa, -cc * sa, ca]) {
        assert!((got - wanted).abs() < 1e-12, "{axis:?}");
    }
}

/// Random trees: fixed joints between, oblique axes and frames, axes on both sides in any order, side
/// branches.
#[test]
fn random_trees_move_as_their_description() {
    let (mut seen, mut oblique) = (0, 0);
    for seed in 0..60 {
        let mut random = Random(1000 + seed);
        let (text, sides) = random_tree(&mut random);
        let desk = Desk::new();
        let made = match desk.import(&text, &between("tool", "table")) {
            Ok(made) => made,
            // Two parallel rotary axes, or one along the tool, are no machine.
            Err(e) => {
                assert!(e.message.contains("the axes do not make a machine") && e.line > 0, "{e}\n{text}");
                continue;
            }
        };
        let machine = desk.machine(&made);
        let all = joints(&text);
        let names: Vec<(String, String)> =
            sides.iter().map(|letter| (letter.to_string(), format!("axis_{}", letter.to_ascii_lowercase()))).collect();
        let letters: Vec<(&str, &str, bool)> = names.iter().map(|(l, n)| (l.as_str(), n.as_str(), false)).collect();
        compare(&machine, &all, &letters, ["tool", "table"], [0.0, 0.0, 1.0], seed);
        seen += 1;
        oblique += usize::from(machine.program_zero().is_none());
    }
    assert!(seen >= 50 && oblique >= 40, "{seen} {oblique}");
}

/// A tree with a root, a base, five axes between tool and table, and something on the side.
fn random_tree(random: &mut Random) -> (String, Vec<char>) {
    let mut text = String::from("<robot name=\"random\">\n<link name=\"root\"/>\n<link name=\"side\"/>\n");
    let mut letters = vec!['X', 'Y', 'Z', ['A', 'B'][random.below(2)], 'C'];
    for k in (1..letters.len()).rev() {
        letters.swap(k, random.below(k + 1));
    }
    let on_table = random.below(6);
    let numbers = |random: &mut Random, size: f64| {
        let v = [0; 3].map(|_| random.between(-size, size));
        format!("{} {} {}", v[0], v[1], v[2])
    };
    let join = |random: &mut Random, text: &mut String, name: &str, kind: &str, parent: &str, child: &str| {
        let (xyz, rpy, axis) = (numbers(random, 0.6), numbers(random, 3.0), numbers(random, 2.0));
        let (low, high) = if kind == "prismatic" { (-0.3, 0.4) } else { (-2.0, 1.8) };
        let limit = if kind == "fixed" { String::new() } else { format!("<limit lower=\"{low}\" upper=\"{high}\"/>") };
        let _ = writeln!(
            text,
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>\
             <axis xyz=\"{axis}\"/>{limit}</joint>"
        );
    };
    let mut parents = ["root".to_owned(), "root".to_owned()];
    for (k, letter) in letters.iter().enumerate() {
        let side = usize::from(k < on_table);
        for (name, kind) in [
            (format!("mount {k}"), "fixed"),
            (
                format!("axis_{}", letter.to_ascii_lowercase()),
                if "XYZ".contains(*letter) { "prismatic" } else { "revolute" },
            ),
        ] {
            if kind == "fixed" && random.next() < 0.5 {
                continue;
            }
            let child = format!("link {name}");
            let _ = writeln!(text, "<link name=\"{child}\"/>");
            join(random, &mut text, &name, kind, &parents[side], &child);
            parents[side] = child;
        }
    }
    let _ = writeln!(text, "<link name=\"tool\"/><link name=\"table\"/>");
    join(random, &mut text, "to the tool", "fixed", &parents[0], "tool");
    join(random, &mut text, "to the table", "fixed", &parents[1], "table");
    let last = random.below(2);
    join(random, &mut text, "aside", "revolute", &parents[last], "side");
    (text + "</robot>\n", letters)
}
