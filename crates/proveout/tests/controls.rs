//! Control files as a user meets them: named by the call, by a machine, by a scene; the first five minutes
//! with a new machine.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

fn call(folder: &TempDir, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder.path())
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn write(folder: &TempDir, name: &str, text: &str) {
    fs::write(folder.path().join(name), text).expect("written");
}

/// A scene with a block, and the lines of `extra` in front of its tables; its program is Siemens and says so.
fn scene(folder: &TempDir, extra: &str) {
    let path = |p: &str| root().join(p).display().to_string();
    let text = format!(
        "name = \"small\"\nmachine = {:?}\ntools = {:?}\nresolution_mm = 4\n{extra}\n[stock]\n\
         box = {{ min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }}\n[mount]\ntranslation_mm = [0, 0, 100]\n\
         [work_offsets.G54]\nZ_mm = 100\n[[program]]\nname = \"main\"\nfile = \"main.mpf\"\ndialect = \"siemens-840d\"\n",
        path("machines/three-axis-mill"),
        path("tools/axis-cross.toml"),
    );
    write(folder, "scene.toml", &text);
    write(
        folder,
        "main.mpf",
        "G17 G54 G90 G94 G710 G60\nT=\"SCHAFT_D6_N_AP15\"\nM6\nS3000 M3\nD1\nG0 X-30 Y0 Z5\nX30\nM5\nM30\n",
    );
}

const ISO: &str =
    "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT3 M6\nG54\nS3000 M3\nG0 X-30. Y0.\nG43 Z5. H3\nX30. M25\nM5\nM30\n%\n";

#[test]
fn the_table_of_unknown_words_makes_a_program_readable() {
    let folder = tempfile::tempdir().expect("temporary folder");
    write(&folder, "part.nc", "%\nO1\nG21 G17 G90\nS1000 M213\nG0 X1. Y1. Z1.\nG187 P2\nG330\nM25\nM25\nM30\n%\n");
    write(&folder, "shop.toml", "inherits = \"fanuc-30i\"\nunlisted.m = \"refuse\"\n");
    let refused = call(&folder, &["check", "part.nc", "--control", "shop.toml"]);
    assert_eq!(refused.status.code(), Some(2), "{}", printed(&refused));
    let table = call(&folder, &["nc", "part.nc", "--unknown", "--control", "shop.toml"]);
    assert_eq!(table.status.code(), Some(0), "{}", printed(&table));
    let table = String::from_utf8_lossy(&table.stdout).into_owned();
    for word in ["[words.G187]", "[words.G330]", "[words.M25]", "[words.M213]", "2 times, first in part.nc:8:1"] {
        assert!(table.contains(word), "{word}\n{table}");
    }
    let pasted = "inherits = \"fanuc-30i\"\nunlisted.m = \"refuse\"\n\n".to_owned() + &table;
    write(&folder, "shop.toml", &pasted);
    let checked = call(&folder, &["check", "shop.toml"]);
    assert_eq!(checked.status.code(), Some(0), "{}", printed(&checked));
    let filled = pasted
        .replace("[words.M213]\nrefuse = \"not looked up yet\"", "[words.M213]\ndoes = \"M3 M8\"")
        .replace("[words.G187]\nrefuse = \"not looked up yet\"", "[words.G187]\nnote = \"quality\"\nvalues = \"P\"")
        .replace("refuse = \"not looked up yet\"", "ignore = \"without effect on the path\"");
    write(&folder, "shop.toml", &filled);
    let read = call(&folder, &["nc", "part.nc", "--control", "shop.toml"]);
    assert_eq!(read.status.code(), Some(0), "{}", printed(&read));
    let lines = String::from_utf8_lossy(&read.stdout).into_owned();
    for part in ["\"op\":\"spindle\"", "\"flood\":true", "G187 P2: quality", "without effect on the path"] {
        assert!(lines.contains(part), "{part}\n{lines}");
    }
}

#[test]
fn every_option_changes_the_commands() {
    let folder = tempfile::tempdir().expect("temporary folder");
    fs::create_dir(folder.path().join("subs")).expect("made");
    write(&folder, "subs/O9300.nc", "O9300\nG0 X93.\nM99\n");
    write(&folder, "shop.toml", "inherits = \"fanuc-30i\"\nwords.M300.call = \"O9300\"\n");
    for (program, options, says) in [
        ("G21\nG0 X1.\nM300\nM30\n", &["--control", "shop.toml", "--subprograms", "subs"][..], "\"X\":93.0"),
        ("G21\nG0 X#500\nM30\n", &["--variable", "#500=7.5"], "\"X\":7.5"),
        ("G21\nG54 G0 X1. Y0. Z0.\nM30\n", &["--offset", "G54=10,0,0"], "\"X\":11.0"),
        ("G21\nG91 G0 X1.\nM30\n", &["--start", "X5,Y0,Z0"], "\"X\":6.0"),
        ("G21\nG1 X1.\nM30\n", &["--feed", "321"], "321.0"),
        ("G21\nG0 X10. Y0. Z0.\nG3 X0. Y10.05 I-10. F100\nM30\n", &["--arc-tolerance", "0.1"], "\"op\":\"arc\""),
        ("G0 X1 Y1 Z1\nG4 P2\nM2\n", &["--dialect", "linuxcnc"], "\"seconds\":2.0"),
    ] {
        write(&folder, "part.nc", program);
        let mut arguments = vec!["nc", "part.nc"];
        let without = call(&folder, &arguments);
        arguments.extend(options);
        let with = call(&folder, &arguments);
        assert_eq!(with.status.code(), Some(0), "{options:?}: {}", printed(&with));
        assert!(printed(&with).contains(says), "{options:?}: {}", printed(&with));
        assert!(!printed(&without).contains(says), "{options:?}: {}", printed(&without));
        arguments[0] = "check";
        let checked = call(&folder, &arguments);
        assert_eq!(checked.status.code(), Some(0), "{options:?}: {}", printed(&checked));
    }
}

#[test]
fn a_given_program_is_read_in_its_own_language() {
    let folder = tempfile::tempdir().expect("temporary folder");
    scene(&folder, "control = { file = \"siemens-840d-sl\" }");
    write(&folder, "iso.nc", ISO);
    let run = call(&folder, &["run", ".", "--nc", "iso.nc", "--output", "result", "--rerun", "off"]);
    assert_ne!(run.status.code(), Some(2), "{}", printed(&run));
    let says = "is written in iso: the control \"Siemens 840D sl\", which is for siemens-840d, is not applied";
    assert!(printed(&run).contains(says), "{}", printed(&run));
    let verdict = fs::read_to_string(folder.path().join("result/verdict.json")).expect("written");
    let verdict: Value = serde_json::from_str(&verdict).expect("JSON");
    assert!(verdict["axes"]["X"]["max"].as_f64().is_some_and(|x| x >= 30.0 - 1e-6), "{verdict}");
}

#[test]
fn a_scene_goes_before_its_machine_and_both_name_a_control() {
    let folder = tempfile::tempdir().expect("temporary folder");
    write(&folder, "shop.toml", "inherits = \"siemens-840d-sl\"\nwords.M5.refuse = \"the spindle stops with M30\"\n");
    scene(&folder, "control = { file = \"shop.toml\" }");
    let by_scene = call(&folder, &["check", "."]);
    assert_eq!(by_scene.status.code(), Some(2), "{}", printed(&by_scene));
    assert!(printed(&by_scene).contains("the spindle stops with M30"), "{}", printed(&by_scene));

    let machine = fs::read_to_string(root().join("machines/three-axis-mill/machine.toml")).expect("readable");
    let machine = machine.replace("\n[control]\n", "\n[control]\nfile = \"../shop.toml\"\n");
    let source = root().join("machines/three-axis-mill");
    let to = folder.path().join("mill");
    fs::create_dir(&to).expect("made");
    for entry in fs::read_dir(source).expect("the machine").map(|e| e.expect("an entry").path()) {
        fs::copy(&entry, to.join(entry.file_name().expect("a name"))).expect("copied");
    }
    write(&folder, "mill/machine.toml", &machine);
    scene(&folder, "");
    let text = fs::read_to_string(folder.path().join("scene.toml")).expect("written");
    let own = root().join("machines/three-axis-mill").display().to_string();
    write(&folder, "scene.toml", &text.replace(&own, "mill"));
    let by_machine = call(&folder, &["check", "."]);
    assert!(printed(&by_machine).contains("the spindle stops with M30"), "{}", printed(&by_machine));
    let nc = call(&folder, &["nc", "main.mpf", "--machine", "mill"]);
    assert!(printed(&nc).contains("the spindle stops with M30"), "{}", printed(&nc));
    let other = call(&folder, &["nc", "main.mpf", "--machine", "mill", "--control", "siemens-840d-sl"]);
    assert_eq!(other.status.code(), Some(0), "{}", printed(&other));

    let scene_text = fs::read_to_string(folder.path().join("scene.toml")).expect("written");
    let named = scene_text.replace("\n[stock]", "\ncontrol = { file = \"siemens-840d-sl\" }\n[stock]");
    write(&folder, "scene.toml", &named);
    let before = call(&folder, &["check", "."]);
    assert_eq!(before.status.code(), Some(0), "{}", printed(&before));
}

#[test]
fn a_subprogram_that_is_left_out_makes_the_gates_unchecked() {
    let folder = tempfile::tempdir().expect("temporary folder");
    write(
        &folder,
        "shop.toml",
        "inherits = \"siemens-840d-sl\"\nsubprograms = { missing = \"note\", missing_reason = \"warm-up of the spindle\" }\n",
    );
    scene(&folder, "control = { file = \"shop.toml\" }");
    let program =
        "G17 G54 G90 G94 G710 G60\nT=\"SCHAFT_D6_N_AP15\"\nM6\nS3000 M3\nD1\nL900\nG0 X-30 Y0 Z5\nX30\nM5\nM30\n";
    write(&folder, "main.mpf", program);
    let run = call(&folder, &["run", ".", "--output", "result", "--rerun", "off"]);
    assert!(matches!(run.status.code(), Some(1 | 3)), "{}", printed(&run));
    let verdict = fs::read_to_string(folder.path().join("result/verdict.json")).expect("written");
    let verdict: Value = serde_json::from_str(&verdict).expect("JSON");
    assert_eq!(verdict["verdict"], "unchecked", "{verdict}");
    assert!(verdict.to_string().contains("L900"), "{verdict}");
}

#[test]
fn a_wrong_control_is_one_error_with_place_and_remedy() {
    let folder = tempfile::tempdir().expect("temporary folder");
    write(&folder, "part.nc", ISO);
    for (text, says) in [
        ("dialect = \"fanuc\"\n[words]\nM25 = { does = \"M333\" }\n", "shop.toml:3:16"),
        ("inherits = \"fanuc-30\"\n", "did you mean fanuc-30i?"),
        ("inherits = \"shop.toml\"\n", "in a circle"),
        ("dialect = \"fanuc\"\nwordz = 1\n", "did you mean words?"),
    ] {
        write(&folder, "shop.toml", text);
        for arguments in [&["check", "shop.toml"][..], &["nc", "part.nc", "--control", "shop.toml"]] {
            let output = call(&folder, arguments);
            assert_eq!(output.status.code(), Some(2), "{}", printed(&output));
            assert!(printed(&output).contains(says), "{says}: {}", printed(&output));
            assert_eq!(printed(&output).matches("error:").count(), 1, "{}", printed(&output));
        }
    }
}

#[test]
fn forms_of_real_programs_are_read_as_they_are_typed() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let read = |name: &str, text: &str, options: &[&str], says: &[&str]| {
        write(&folder, name, text);
        let output = call(&folder, &[&["nc", name][..], options].concat());
        assert_eq!(output.status.code(), Some(0), "{name}: {}", printed(&output));
        for part in says {
            assert!(printed(&output).contains(part), "{name}: {part}\n{}", printed(&output));
        }
    };
    // Two ways of an elongated hole, 18 mm each, with a tool of 12 mm.
    read(
        "hole.mpf",
        "T1 D1 M6\nS900 M3 F300\nG0 X0 Y0 Z50\nLONGHOLE(5,0,1,-4,,1,30,40,45,20,0,0,100,320,2)\nM30\n",
        &["--variable", "$P_TOOLR=6"],
        &["\"X\":66.0,\"Y\":45.0,\"Z\":-2.0", "\"X\":84.0,\"Y\":45.0,\"Z\":-4.0", "\"X\":66.0,\"Y\":45.0,\"Z\":-4.0"],
    );
    read(
        "tool_frame.mpf",
        "TRAORI\nG0 X10 Y20 Z50 A3=0.6 C3=0.8\nTOROT\nG0 X5 Y0 Z20\nM30\n",
        &[],
        &["\"end_base\":{\"X\":16.0,\"Y\":0.0,\"Z\":13.0}"],
    );
    // The contacts of a tangent between two circles: directions 0.6, 0.8.
    read(
        "free.h",
        "0 BEGIN PGM FREE MM\n1 TOOL CALL 1 Z S500 F250\n2 L X+2 Y+30 Z+5 R0 FMAX M3\n3 FC DR- R18 CLSD+ CCX+20 CCY+30\n4 FLT\n\
         5 FCT DR- R15 X+65 Y+75 CCX+50 CCY+75\n6 L Z+50 FMAX M2\n7 END PGM FREE MM\n",
        &["--control", "heidenhain-tnc-640"],
        &["\"X\":5.6,\"Y\":40.8", "\"X\":38.0,\"Y\":84.0"],
    );
    read(
        "scaled.nc",
        "G21 G90 G54\nG0 X0. Y0. Z0.\nG51 X0. Y0. Z0. I500 J2000 K1000\nG1 X10. Y10. F100.\nM30\n",
        &["--control", "fanuc-30i"],
        &["\"end_base\":{\"X\":5.0,\"Y\":20.0,\"Z\":0.0}", "count thousandths"],
    );
    read("whole.nc", "G21 G90 G54\nG0 X10 Y0 Z0\nM30\n", &["--control", "fanuc-30i"], &["numbers.without_point"]);
    read("router.nc", "$H\nG21 G90\nG0 X1 Y2 Z3\nM2\n", &["--control", "grbl-1.1"], &["\"machine_coordinates\":true"]);
    // What is not published, or not there, is refused by name, at its place.
    for (name, text, says) in [
        ("contour.mpf", "G0 X0 Y0 Z5\nCYCLE72(\"K\",5,0,1,-5)\nM30\n", "contour `K` not found"),
        ("contour.h", "0 BEGIN PGM A MM\n1 CYCL DEF 14.0 CONTOUR\n2 END PGM A MM\n", "is not published"),
        ("router.nc", "G21\n$J=G91X1F100\nM2\n", "begins a line of a grbl"),
    ] {
        write(&folder, name, text);
        let output = call(
            &folder,
            &[
                "nc",
                name,
                "--dialect",
                if name.ends_with('h') {
                    "heidenhain"
                } else if name.ends_with("mpf") {
                    "siemens-840d"
                } else {
                    "linuxcnc"
                },
            ],
        );
        assert_eq!(output.status.code(), Some(2), "{name}: {}", printed(&output));
        assert!(printed(&output).contains(says) && printed(&output).contains(":2:"), "{name}: {}", printed(&output));
    }
}
