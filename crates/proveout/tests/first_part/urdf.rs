//! Machines from URDF files, as a user types it: `machine`, `check`, `new`, `run`.

use std::fs;

use crate::first_part::desk::{Desk, believable, gate, open_by_setup_alone};

const HEAD: &str = "machine head.urdf --tool-link nose --table-link table --axis-names joint_1=X,joint_2=Y,joint_3=Z --tool-direction -z --output head";

#[test]
fn a_trunnion_comes_to_its_verdict() {
    let desk = Desk::new(&["plate.nc", "answers.toml", "trunnion.urdf"]);
    let output = desk.done("machine trunnion.urdf --tool-link spindle --table-link table --output trunnion");
    for word in [
        "trunnion mill: A C table, Y X Z tool; X 620, Y 520, Z 460, A -120 to 30\u{b0}, C endless; travel from URDF file",
        "note: axes: X is joint \"x_axis\"",
        "note: assumed: acceleration, jerk and home",
        "the middle of the gauge line is the origin of link \"spindle\", and the z of its frame points into the spindle",
        "angles whose digits are those of a right angle",
        "written: trunnion; next: proveout check trunnion",
    ] {
        assert!(output.contains(word), "{word:?} is not in:\n{output}");
    }
    assert!(desk.path("trunnion/model.glb").is_file(), "the ball is a mesh");
    let output = desk.done("check trunnion");
    assert!(!output.contains("no body is attached to") && output.contains("max_speed_rpm"), "{output}");
    desk.done("new plate.nc --machine trunnion --answers answers.toml --output plate");
    let verdict = desk.verdict("plate");
    believable(&verdict);
    open_by_setup_alone(&verdict, "collision");
    desk.refused(
        "machine trunnion.urdf --tool-link spindle --table-link table --output trunnion",
        &["trunnion already exists"],
    );
}

#[test]
fn a_swivel_head_comes_to_its_verdict() {
    let desk = Desk::new(&["five.nc", "head.urdf"]);
    let output = desk.done(HEAD);
    assert!(output.contains("head mill: Y C table, X Z B tool") && output.contains("\"door_hinge\""), "{output}");
    desk.done("check head");
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"-45,-15,-30,45,15,0\"\n");
    desk.done("new five.nc --machine head --answers answers.toml --output five");
    believable(&desk.verdict("five"));
}

/// A collision that the imported bodies alone can show: the tool goes down next to the part into the table.
#[test]
fn bodies_of_links_are_checked() {
    let desk = Desk::new(&["head.urdf"]);
    desk.done(HEAD);
    let text = "%\nO1\nG21 G90 G17 G94\nT1 M6 (FLAT D10 L25)\nS3000 M3\nG54\nG0 X0. Y0.\nG43 H1 Z50.\nG1 Z-1. F500.\nX20.\nG0 Z50.\nX200.\nG1 Z-100. F2000.\nG0 Z50.\nM30\n%\n";
    desk.write("deep.nc", text);
    desk.write(
        "answers.toml",
        "holder = \"80x60\"\nstock = \"-10,-10,-10,40,10,0\"\nmount = \"0,0,870\"\n\"tool.T1\" = \"flat D10 L25\"\n",
    );
    desk.done("new deep.nc --machine head --answers answers.toml --output deep");
    let verdict = desk.verdict("deep");
    let (state, reason) = gate(&verdict, "collision");
    assert_eq!(state, "fail", "{reason}");
    let findings = verdict["findings"].as_array().expect("findings");
    let messages: Vec<&str> = findings.iter().filter_map(|f| f["message"].as_str()).collect();
    assert!(messages.iter().any(|m| m.contains("hits table")), "{messages:#?}");
}

#[test]
fn what_is_missing_or_wrong_is_asked_and_nothing_is_written() {
    let desk = Desk::new(&["trunnion.urdf", "head.urdf", "bench.ini", "plate.nc"]);
    let open = desk.refused(
        "machine trunnion.urdf --output made",
        &["links at the ends: \"bearings\", \"spindle\", \"table\"", "--tool-link NAME and --table-link NAME"],
    );
    assert!(open.contains("trunnion.urdf"), "{open}");
    let between = "--tool-link spindle --table-link table --output made";
    desk.refused(
        "machine head.urdf --tool-link nose --table-link table --output made",
        &["no axis letter in the name of joint \"joint_1\", \"joint_3\", \"joint_2\"", "--axis-names joint_"],
    );
    desk.refused(
        &format!("machine trunnion.urdf --table-axes XY {between}"),
        &["--table-axes does not apply to", "--table-link"],
    );
    desk.refused("machine bench.ini --reverse X --output made", &["--reverse does not apply to bench.ini", "URDF"]);
    desk.refused(&format!("machine plate.nc {between}"), &["is neither a LinuxCNC INI file nor a URDF file"]);
    desk.refused(&format!("machine nowhere.urdf {between}"), &["nowhere.urdf"]);
    let text = fs::read_to_string(desk.path("trunnion.urdf")).expect("there");
    let bad = |name: &str, from: &str, to: &str, words: &[&str]| {
        assert!(text.contains(from), "{from}");
        desk.write(name, &text.replacen(from, to, 1));
        desk.refused(&format!("machine {name} {between}"), words);
    };
    bad("nan.urdf", "0 0.361 1.786", "0 nan 1.786", &["nan.urdf:23:", "xyz = \"0 nan 1.786\"", "is not 3 numbers"]);
    bad(
        "mesh.urdf",
        "<sphere radius=\"0.015\"/>",
        "<mesh filename=\"package://mill/probe.stl\"/>",
        &["mesh.urdf:10:", "not found"],
    );
    bad("arm.urdf", "type=\"continuous\"", "type=\"floating\"", &["joint \"c_axis\" is of type \"floating\""]);
    desk.write("macro.xacro", "<robot/>");
    desk.refused(&format!("machine macro.xacro {between}"), &["is a xacro file"]);
    desk.write("empty.urdf", "");
    desk.refused(&format!("machine empty.urdf {between}"), &["the file is empty"]);
    desk.write("junk.urdf", &"junk ".repeat(2_000_000));
    let output = desk.refused(&format!("machine junk.urdf {between}"), &["the file is not valid XML"]);
    assert!(output.len() < 2000, "a line of ten million characters is not repeated: {}", output.len());
}
