//! What is no machine: one error with its place, and no panic.

use proveout_machine::{UrdfOptions, import_urdf};

use crate::urdf::{Desk, Random, between, of_head, sample_text};

/// The trunnion with one change.
fn changed(from: &str, to: &str) -> String {
    let text = sample_text("trunnion.urdf");
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn each_fault_is_reported_at_its_place() {
    let desk = Desk::new();
    let z_limit = "lower=\"-0.46\" upper=\"0\"";
    let cases = [
        (changed("0 0.1 0.37", "0 nan 0.37"), "xyz = \"0 nan 0.37\" of <origin> is not 3 numbers"),
        (changed("0 0.1 0.37", "0 0.37"), "not 3 numbers"),
        (changed("0 0.1 0.37", "0 0.1 0.37 1"), "not 3 numbers"),
        (changed("0 0.1 0.37", "0 0.1 1e6"), "the limit is 100000 mm"),
        (changed("0 0.1 0.37", "0 0.1 ${h}"), "not 3 numbers"),
        (changed(z_limit, "lower=\"inf\" upper=\"0\""), "lower = \"inf\" of <limit> is not a number"),
        (changed(z_limit, "lower=\"0.1\" upper=\"0\""), "lower = \"0.1\" is not below upper = \"0\""),
        (changed("velocity=\"0.5\"", "velocity=\"-1\""), "the velocity is below zero"),
        (changed("velocity=\"0.5\"", "velocity=\"1e9\""), "joint \"z_axis\" gives max_velocity_mm_min"),
        (changed("radius=\"0.015\"", "radius=\"0\""), "<sphere> measures 0 mm"),
        (changed("size=\"1.5 1.32 0.22\"", "size=\"1.5 -1 0.22\""), "<box> measures -1000 mm"),
        (changed("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>"), "the axis of joint \"z_axis\" has no direction"),
        (changed("type=\"continuous\"", "type=\"floating\""), "joint \"c_axis\" is of type \"floating\""),
        (changed("type=\"continuous\"", "type=\"planar\""), "is of type \"planar\""),
        (changed("type=\"continuous\"", ""), "is of type \"\""),
        (
            changed("<axis xyz=\"0 0 -1\"/>", "<axis xyz=\"0 0 -1\"/><mimic joint=\"a_axis\"/>"),
            "joint \"c_axis\" moves with another one (<mimic>)",
        ),
        (changed("<link name=\"beam\">", "<link name=\"bed\">"), "two links have the name \"bed\""),
        (changed("joint name=\"x_axis\"", "joint name=\"y_axis\""), "two joints have the name \"y_axis\""),
        (changed("<link name=\"beam\">", "<link>"), "<link> has no name"),
        (changed("<link name=\"beam\">", "<link name=\" \">"), "is not a valid name"),
        (changed("<child link=\"saddle\"/>", ""), "joint \"x_axis\" has no <child>"),
        (
            changed("<child link=\"saddle\"/>", "<child link=\"sledge\"/>"),
            "the child \"sledge\" of joint \"x_axis\" is not a link",
        ),
        (
            changed("<parent link=\"bed\"/><child link=\"beam\"/>", "<parent link=\"spindle\"/><child link=\"beam\"/>"),
            "the joints form a loop",
        ),
        (changed("<child link=\"saddle\"/>", "<child link=\"beam\"/>"), "link \"beam\" is the child of two joints"),
        (
            changed("<link name=\"cradle\">", "<link name=\"lost\"/><link name=\"cradle\">"),
            "2 links have no parent joint: \"bed\", \"lost\"",
        ),
        (changed("<origin xyz=\"0 0.361 1.786\"/>", "<origin/><origin/>"), "<origin> appears twice"),
        (
            changed("joint name=\"c_axis\"", "joint name=\"turntable\""),
            "no axis letter in the name of joint \"turntable\"",
        ),
        (changed("joint name=\"c_axis\"", "joint name=\"a\""), "both are axis A"),
        (changed("joint name=\"c_axis\"", "joint name=\"u\""), "joint \"u\" turns, and axis U slides"),
        (changed("<axis xyz=\"0 0 -1\"/>", "<axis xyz=\"1 0 0\"/>"), "the axes do not make a machine: the rotary axes"),
        (
            changed(
                "<link name=\"beam\">",
                "<link xmlns:xacro=\"http://ros.org/wiki/xacro\" name=\"beam\"><xacro:box/>",
            ),
            "<xacro:box> is a macro",
        ),
    ];
    for (text, word) in &cases {
        let error = desk.import(text, &between("spindle", "table")).expect_err(word);
        assert!(error.message.contains(word), "{word:?} is not in: {error}");
        assert!(error.line > 0 && !error.remedy.is_empty(), "{error}");
    }
}

#[test]
fn what_is_no_robot_is_refused_as_such() {
    let desk = Desk::new();
    let bomb = "<?xml version=\"1.0\"?>\n<!DOCTYPE robot [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]>\n<robot name=\"&b;\"/>";
    let whole = sample_text("trunnion.urdf");
    let cases = [
        (String::new(), "the file is empty"),
        (" \n\n".to_owned(), "the file is empty"),
        ("hello\n".to_owned(), "the file is not valid XML"),
        ("name = \"a\"\n".to_owned(), "the file is not valid XML"),
        ("<html><body/></html>".to_owned(), "the first element is <html>"),
        ("<robot name=\"a\"/>".to_owned(), "the robot has no link"),
        ("<robot><link name=\"a\"></robot>".to_owned(), "the file is not valid XML"),
        (whole[..whole.len() / 2].to_owned(), "the file"),
        (bomb.to_owned(), "declares entities"),
        ("<a>".repeat(300_000), "the file ends before its elements are closed"),
        (format!("<robot>{}", "<link>".repeat(600_000)), "more than 500000 elements"),
        ("x".repeat(10_000_000), "the file is not valid XML"),
        ("<".repeat(10_000_000), "the file is not valid XML"),
        (format!("<robot name=\"{}", "y".repeat(10_000_000)), "the file"),
        (format!("<robot {}/>", (0..100_000).map(|k| format!("a{k}=\">\" ")).collect::<String>()), "100000 attributes"),
        ((0..20_000).map(|k| format!("<a xmlns:n{k}='u'>\n")).collect(), "more than 100 namespaces"),
        ("z".repeat(17_000_000), "16777216"),
    ];
    for (text, word) in &cases {
        let error = desk.import(text, &between("spindle", "table")).expect_err(word);
        assert!(error.message.contains(word), "{word:?} is not in: {:.300}", error.message);
        assert!(error.message.len() < 400 && !error.remedy.is_empty(), "{:.300}", error.message);
    }
    let file = desk.path("picture.urdf");
    std::fs::write(&file, (0..10_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect::<Vec<_>>())
        .expect("written");
    assert!(import_urdf(&file, &between("a", "b")).expect_err("no text").message.contains("not UTF-8"));
    assert!(import_urdf(&desk.path("none.urdf"), &between("a", "b")).is_err());
}

/// Nesting and chains of any depth end in a message or a machine, and in time.
#[test]
fn long_chains_are_followed() {
    let desk = Desk::new();
    let mut text = sample_text("trunnion.urdf");
    let mut links = String::new();
    for k in 0..20_000 {
        let parent = if k == 0 { "spindle".to_owned() } else { format!("l{}", k - 1) };
        links += &format!(
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"l{k}\"/></joint>\n"
        );
    }
    text = text.replace("</robot>", &(links + "</robot>"));
    let made = desk.import(&text, &between("l19999", "table")).expect("read");
    assert_eq!(desk.machine(&made).tool_chain.len(), 3);
}

#[test]
fn what_the_caller_leaves_open_is_asked() {
    let desk = Desk::new();
    let text = sample_text("trunnion.urdf");
    let refusal = |options: &UrdfOptions| desk.import(&text, options).expect_err("refused").to_string();
    let both = refusal(&UrdfOptions::default());
    assert!(both.contains("links at the ends: \"bearings\", \"spindle\", \"table\""), "{both}");
    assert!(both.contains("--tool-link NAME and --table-link NAME"), "{both}");
    let one = refusal(&UrdfOptions { table_link: Some("table".into()), ..UrdfOptions::default() });
    assert!(one.contains("which link carries the tool;") && !one.contains("--table-link"), "{one}");
    let table = || between("spindle", "table");
    for (options, word) in [
        (between("spindle_2", "table"), "--tool-link \"spindle_2\": the file has no such link"),
        (between("spindle", "plate"), "--table-link \"plate\""),
        (between("table", "table"), "cannot carry tool and workpiece"),
        (between("bearings", "bed"), "no joint moves the tool against the workpiece"),
        (between("cradle", "bearings"), "0 joints slide and 1 turn"),
        (UrdfOptions { axis_names: Some("q=X".into()), ..table() }, "\"q\": the file has no such joint"),
        (UrdfOptions { axis_names: Some("c_axis".into()), ..table() }, "this names no axis"),
        (UrdfOptions { axis_names: Some("c_axis=Q".into()), ..table() }, "this names no axis"),
        (UrdfOptions { axis_names: Some("c_axis=B,c_axis=C".into()), ..table() }, "twice"),
        (UrdfOptions { axis_names: Some("bearings_on_bed=B".into()), ..table() }, "is not between table and tool"),
        (UrdfOptions { axis_names: Some("x_axis=W".into()), ..table() }, "no joint between table and tool is axis X"),
        (UrdfOptions { reverse: Some("B".into()), ..table() }, "--reverse \"B\": the machine has no such axis"),
        (UrdfOptions { tool_direction: Some("up".into()), ..table() }, "--tool-direction \"up\""),
        (UrdfOptions { table_normal: Some("".into()), ..table() }, "--table-normal \"\""),
    ] {
        let said = refusal(&options);
        assert!(said.contains(word), "{word:?} is not in: {said}");
    }
}

/// An arm of six joints is named as what it is, whatever its joints are called.
#[test]
fn a_robot_is_refused_by_its_joints() {
    let mut text = String::from("<robot name=\"arm\"><link name=\"l0\"/>");
    for k in 1..7 {
        text += &format!(
            "<link name=\"l{k}\"/><joint name=\"joint_{k}\" type=\"revolute\"><parent link=\"l{}\"/><child link=\"l{k}\"/><axis xyz=\"0 {} 1\"/>\
             <limit lower=\"-3\" upper=\"3\" velocity=\"2\" effort=\"1\"/></joint>",
            k - 1,
            k % 2
        );
    }
    let error = Desk::new().import(&(text + "</robot>"), &between("l6", "l0")).expect_err("a robot");
    assert!(error.message.contains("0 joints slide and 6 turn (\"joint_1\", \"joint_2\""), "{error}");
    assert!(error.message.contains("three slides X, Y, Z"), "{error}");
}

/// The turning of a spindle is no axis; the link before it is named, and what turns is at rest.
#[test]
fn a_spindle_that_turns_is_left_before_its_joint() {
    let desk = Desk::new();
    let text =
        changed("<joint name=\"spindle_in_headstock\" type=\"fixed\">", "<joint name=\"rotor\" type=\"continuous\">")
            .replace("<parent link=\"headstock\"/>", "<parent link=\"headstock\"/><axis xyz=\"0 0 1\"/>");
    let error = desk.import(&text, &between("spindle", "table")).expect_err("no letter");
    assert!(error.remedy.contains("the rotation of a spindle, name the link before it"), "{error}");
    let made = desk.import(&text, &between("headstock", "table")).expect("read");
    assert!(made.notes.join("\n").contains("not axes between table and tool are held at zero: \"rotor\""));
    assert!(desk.machine(&made).bodies.iter().any(|b| b.name == "spindle"));
}

/// A quill stays where it is: programs do not move W.
#[test]
fn a_quill_is_held() {
    let desk = Desk::new();
    let text =
        changed("<joint name=\"spindle_in_headstock\" type=\"fixed\">", "<joint name=\"w_axis\" type=\"prismatic\">")
            .replace(
                "<parent link=\"headstock\"/>",
                "<parent link=\"headstock\"/><axis xyz=\"0 0 1\"/><limit lower=\"-0.1\" upper=\"-0.02\"/>",
            );
    let machine = desk.machine(&desk.import(&text, &between("spindle", "table")).expect("read"));
    let w = &machine.joints[machine.joint("W").expect("W")];
    assert!(w.held && w.home == -20.0, "{}", w.home);
}

/// Random changes of both samples: an error or a machine, never a panic.
#[test]
fn changed_files_are_refused_or_read() {
    let count = std::env::var("PROVEOUT_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(300);
    let desk = Desk::new();
    let samples = [(sample_text("trunnion.urdf"), between("spindle", "table")), (sample_text("head.urdf"), of_head())];
    let mut random = Random(77);
    let (mut read, mut refused) = (0, 0);
    for case in 0..count {
        let (text, options) = &samples[case % 2];
        let mut bytes = text.clone().into_bytes();
        for _ in 0..1 + random.below(3) {
            let at = random.below(bytes.len());
            let end = (at + 1 + random.below(60)).min(bytes.len());
            match random.below(6) {
                0 => bytes[at] = random.below(256) as u8,
                1 => bytes[at] = b"0123456789.-eE\"<>/ x"[random.below(20)],
                2 => drop(bytes.drain(at..end)),
                3 => {
                    let piece = bytes[at..end].to_vec();
                    let to = random.below(bytes.len());
                    bytes.splice(to..to, piece);
                }
                4 => {
                    // A line twice, or one that is gone.
                    let start = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |p| p + 1);
                    let stop = bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |p| at + p + 1);
                    let line = bytes[start..stop].to_vec();
                    bytes.splice(start..stop, if random.next() < 0.5 { line.repeat(2) } else { Vec::new() });
                }
                // A number of another size.
                _ => {
                    let digit = bytes.iter().enumerate().skip(at).find(|(_, b)| b.is_ascii_digit()).map(|(i, _)| i);
                    let value =
                        ["1e308", "-1e-308", "nan", "inf", "1e5", "0", "-0", "1e9", "12345.678"][random.below(9)];
                    if let Some(i) = digit {
                        bytes.splice(i..=i, value.bytes());
                    }
                }
            }
            if bytes.is_empty() {
                bytes.push(b'<');
            }
        }
        let file = desk.path("changed.urdf");
        std::fs::write(&file, &bytes).expect("written");
        match import_urdf(&file, options) {
            Ok(made) => {
                desk.machine(&made);
                std::fs::remove_dir_all(desk.path("machine")).expect("removed");
                read += 1;
            }
            Err(error) => {
                assert!(!error.message.is_empty() && !error.remedy.is_empty(), "{error}");
                refused += 1;
            }
        }
    }
    assert!(read >= count / 20 && refused >= count / 10, "{read} read, {refused} refused");
}
