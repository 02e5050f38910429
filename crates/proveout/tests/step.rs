//! STEP files as design, stock and fixture, typed as a person types them, with a helper that leaves prepared
//! boxes: what is measured counts, and what is wrong is refused with its place.

use std::{fs, os::unix::fs::PermissionsExt, path::Path, process::Command};

use serde_json::{Value, json};

use crate::hostile::workshop::Workshop;

/// Faces of a box as triangles of its corners; bit 0 of a corner is its x, bit 1 its y, bit 2 its z.
const FACES: [[[u32; 3]; 2]; 6] = [
    [[0, 2, 3], [0, 3, 1]],
    [[4, 5, 7], [4, 7, 6]],
    [[0, 1, 5], [0, 5, 4]],
    [[2, 6, 7], [2, 7, 3]],
    [[0, 4, 6], [0, 6, 2]],
    [[1, 3, 7], [1, 7, 5]],
];

struct Shop {
    workshop: Workshop,
}

/// SHA-256 by the tool of the system: the program must not check itself.
fn sha256(file: &Path) -> String {
    let output = Command::new("sha256sum").arg(file).output().expect("sha256sum of coreutils");
    String::from_utf8_lossy(&output.stdout).split(' ').next().unwrap_or_default().to_owned()
}

impl Shop {
    fn new() -> Self {
        let workshop = Workshop::new();
        let place = workshop.path().display().to_string();
        workshop.write(
            "helper",
            format!("#!/bin/sh\necho call >> '{place}/calls'\ncp '{place}/answers/'\"$(basename \"$9\")\"/* \"$8\"\n"),
        );
        let helper = workshop.path().join("helper");
        fs::set_permissions(helper, fs::Permissions::from_mode(0o755)).expect("executable");
        Self { workshop }
    }

    /// A STEP file of a box and what the helper leaves for it: the lower face is so many micrometers off its
    /// mesh.
    fn step_box(&self, name: &str, min: [f64; 3], max: [f64; 3], off_um: f64) {
        let faces: String = (3..9).map(|id| format!("#{id}=ADVANCED_FACE('face {id}',(#18),#32,.F.);\n")).collect();
        self.workshop.write(
            name,
            format!(
                "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n/* {name} {off_um} */\n\
                 #1=MANIFOLD_SOLID_BREP('{name}',#2);\n{faces}\
                 #90=(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#91)) REPRESENTATION_CONTEXT('',''));\n\
                 #91=(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.));\nENDSEC;\nEND-ISO-10303-21;\n"
            ),
        );
        let corner = |k: u32| [0, 1, 2].map(|i| if k >> i & 1 == 1 { max[i] } else { min[i] });
        let middle =
            |corners: &[[f64; 3]]| [0, 1, 2].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / corners.len() as f64);
        let bytes = |points: &[[f64; 3]]| points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let (mut mesh, mut samples) = (bytes(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner)), Vec::new());
        for (face, triangles) in FACES.iter().enumerate() {
            for t in triangles {
                let [a, b, c] = t.map(corner);
                let mut points = [middle(&[a, b, c]), middle(&[a, b]), middle(&[b, c]), middle(&[c, a])];
                if face == 0 {
                    points[0][2] -= off_um / 1000.0;
                }
                samples.extend(bytes(&points));
                mesh.extend(t.iter().flat_map(|i| i.to_le_bytes()));
            }
        }
        mesh.extend((0..12_u32).flat_map(|t| (t / 2).to_le_bytes()));
        let volume: f64 = (0..3).map(|i| max[i] - min[i]).product();
        let head = json!({
            "protocol": 1, "kernel": "boxes 1.0", "sha256": sha256(&self.workshop.path().join(name)),
            "units": ["millimetre"], "loose": [], "solids": [{ "faces": [0, 6], "volume_mm3": volume, "edge_samples": 0 }],
            "faces": (0..6).map(|f| json!({ "entity": f, "tri": [2 * f, 2] })).collect::<Vec<_>>(),
            "vertices": 8, "triangles": 12,
        });
        let answer = self.workshop.path().join("answers").join(name);
        fs::create_dir_all(&answer).expect("made");
        for (file, bytes) in
            [("mesh.json", head.to_string().into_bytes()), ("mesh.bin", mesh), ("samples.bin", samples)]
        {
            fs::write(answer.join(file), bytes).expect("written");
        }
    }

    /// Exit code and all that is printed.
    fn call(&self, words: &[&str], helper: &str) -> (Option<i32>, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_proveout"));
        command.current_dir(self.workshop.path()).args(words);
        // Nothing but the tools of the system is on the path.
        command.env("PATH", "/usr/bin:/bin").env("PROVEOUT_STEP", helper);
        let output = command.output().expect("it starts");
        let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        (output.status.code(), text)
    }

    fn run(&self) -> Value {
        let words = ["run", ".", "--output", "result", "--rerun", "off", "--threads", "1"];
        let (code, text) = self.call(&words, "./helper");
        assert_ne!(code, Some(2), "{text}");
        serde_json::from_str(&self.workshop.read("result/verdict.json")).expect("JSON")
    }

    fn refused(&self, words: &[&str]) {
        let (code, text) = self.call(&["run", ".", "--output", "never", "--rerun", "off"], "./helper");
        assert_eq!(code, Some(2), "{text}");
        for word in words {
            assert!(text.contains(word), "{word:?} is not in:\n{text}");
        }
        assert!(!self.workshop.path().join("never").exists());
    }

    fn calls(&self) -> usize {
        fs::read_to_string(self.workshop.path().join("calls")).unwrap_or_default().lines().count()
    }
}

fn findings<'a>(verdict: &'a Value, code: &str) -> Vec<&'a Value> {
    verdict["findings"].as_array().expect("findings").iter().filter(|f| f["code"] == code).collect()
}

fn message(finding: &Value) -> &str {
    finding["message"].as_str().unwrap_or_default()
}

const DESIGN: &str = "[part]\nmesh = \"part.step\"\n\n[tolerances]\ngouge_mm = 0.05\nexcess_mm = 0.05\n";

/// Design, stock and clamp are STEP files; the chord error of the design is the floor of its tolerances.
#[test]
fn design_stock_and_fixture_are_step_files() {
    let shop = Shop::new();
    shop.step_box("part.step", [-20.0, -20.0, -20.0], [20.0, 20.0, -2.0], 3.0);
    shop.step_box("raw.stp", [-20.0, -20.0, -20.0], [20.0, 20.0, 0.0], 0.0);
    shop.step_box("clamp.step", [60.0, -20.0, -20.0], [80.0, 20.0, 5.0], 0.0);
    shop.workshop.scene(&format!("{DESIGN}\n[[fixture]]\nname = \"clamp\"\nmesh = \"clamp.step\"\nchord_um = 2\n"));
    shop.workshop.replace(
        "scene.toml",
        "box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }",
        "mesh = \"raw.stp\"",
    );
    let verdict = shop.run();
    let read = findings(&verdict, "setup-step-read");
    assert_eq!(read.len(), 3, "{read:?}");
    let part = read.iter().find(|f| f["bodies"] == json!(["part"])).expect("the part");
    for words in [
        "part: part.step (AUTOMOTIVE_DESIGN, millimetre) by boxes 1.0: 1 solid, 6 faces, 12 triangles, 28800.000 mm3",
        "chord error 3.00 um measured at (",
        "among 48 points, 3.20 um taken (5 um asked, assumed: state `chord_um`)",
    ] {
        assert!(message(part).contains(words), "{words:?} is not in {}", message(part));
    }
    let clamp = read.iter().find(|f| f["bodies"] == json!(["clamp"])).expect("the clamp");
    assert!(message(clamp).ends_with("(2 um asked)"), "{}", message(clamp));
    assert!(findings(&verdict, "setup-step-coarse").is_empty());
    // 16/15 of what was measured.
    let floor = verdict["deviation"]["design_error_mm"].as_f64().expect("a floor");
    assert!((floor - 0.0032).abs() < 1e-9, "{floor}");
    assert!(verdict["digests"]["part"].as_str().is_some_and(|d| d == sha256(&shop.workshop.path().join("part.step"))));
}

/// A mesh that is coarser than asked is reported, and one that is coarser than the tolerance decides nothing.
#[test]
fn what_is_coarser_than_asked_or_than_the_tolerance_is_named() {
    let shop = Shop::new();
    shop.step_box("part.step", [-20.0, -20.0, -20.0], [20.0, 20.0, -2.0], 60.0);
    shop.step_box("clamp.step", [60.0, -20.0, -20.0], [80.0, 20.0, 5.0], 1500.0);
    shop.workshop.scene(&format!("{DESIGN}\n[[fixture]]\nname = \"clamp\"\nmesh = \"clamp.step\"\n"));
    let verdict = shop.run();
    let coarse = findings(&verdict, "setup-step-coarse");
    assert_eq!(coarse.len(), 2, "{coarse:?}");
    assert!(message(coarse[0]).contains("60.00 um off its surface"), "{}", message(coarse[0]));
    assert_eq!(coarse[0]["severity"], "warning");
    let gate = |name: &str| {
        verdict["gates"].as_array().expect("gates").iter().find(|g| g["name"] == name).expect("the gate").clone()
    };
    assert_eq!(gate("gouge")["state"], "unchecked", "{}", gate("gouge"));
    let reason = gate("gouge")["reason"].as_str().unwrap_or_default().to_owned();
    assert!(reason.contains("accurate to 0.06400 mm as measured") && reason.contains("`chord_um`"), "{reason}");
    let reason = gate("collision")["reason"].as_str().unwrap_or_default().to_owned();
    assert!(reason.contains("fixture clamp is known to 1.6000 mm only, more than near_miss_mm = 1 mm"), "{reason}");
    assert_eq!(gate("collision")["state"], "unchecked");
}

#[test]
fn keys_that_do_not_belong_to_a_step_file_are_refused_with_their_place() {
    let shop = Shop::new();
    shop.step_box("part.step", [-20.0, -20.0, -20.0], [20.0, 20.0, -2.0], 0.0);
    for (keys, words) in [
        ("mesh_unit = \"mm\"", ["scene.toml:21", "a STEP file states its unit"]),
        ("chord_error_mm = 0.01", ["scene.toml:21", "the chord error of a STEP file is measured"]),
        ("chord_um = 0", ["scene.toml:21", "chord_um = 0 um is out of range"]),
    ] {
        shop.workshop.scene(&format!("[part]\nmesh = \"part.step\"\n{keys}"));
        shop.refused(&words);
    }
    shop.workshop.scene("[part]\nmesh = \"part.stl\"\nchord_um = 5");
    shop.refused(&["scene.toml:21", "`chord_um` belongs to a STEP file"]);
    shop.workshop.scene("[[fixture]]\nname = \"clamp\"\nmesh = \"part.stl\"\nchord_um = 5");
    shop.refused(&["fixture \"clamp\": `chord_um` belongs to a STEP file"]);
}

/// Without a helper the refusal has the line of the key and the one command that brings it.
#[test]
fn without_a_helper_the_refusal_names_the_command_that_brings_it() {
    let shop = Shop::new();
    shop.step_box("part.step", [-20.0, -20.0, -20.0], [20.0, 20.0, -2.0], 0.0);
    shop.workshop.scene(DESIGN);
    let run = |helper: &str| shop.call(&["run", ".", "--output", "never", "--rerun", "off"], helper);
    let (code, text) = run("");
    assert_eq!(code, Some(2), "{text}");
    for words in ["scene.toml:20:8", "part: ", "proveout-step", "pip install \"proveout[step]\""] {
        assert!(text.contains(words), "{words:?} is not in:\n{text}");
    }
    let (code, text) = run("nowhere/helper");
    assert!(code == Some(2) && text.contains("PROVEOUT_STEP names nowhere/helper, which is no file"), "{text}");
}

/// Two programs of a scene, a check and a comparison: one command calls the helper once for a file.
#[test]
fn a_command_reads_a_file_once() {
    let shop = Shop::new();
    shop.step_box("part.step", [-20.0, -20.0, -20.0], [20.0, 20.0, -2.0], 1.0);
    shop.workshop.scene(&format!("[[program]]\nname = \"second\"\nfile = \"program.mpf\"\n\n{DESIGN}"));
    let (_, text) = shop.call(&["check", "."], "./helper");
    assert_eq!(shop.calls(), 1, "check: {text}");
    let (code, text) = shop.call(&["compare", ".", "--output", "both"], "./helper");
    assert_ne!(code, Some(2), "{text}");
    assert_eq!(shop.calls(), 2, "compare: {text}");
}

/// The answers of the kernel stay with the file: the same bytes at any number of threads.
#[test]
fn the_verdict_has_the_same_bytes_at_any_thread_count() {
    let shop = Shop::new();
    shop.step_box("part.step", [-20.0, -20.0, -20.0], [20.0, 20.0, -2.0], 3.0);
    shop.workshop.scene(DESIGN);
    let of = |threads: &str| {
        let words = ["run", ".", "--output", "result", "--rerun", "off", "--threads", threads];
        let (code, text) = shop.call(&words, "./helper");
        assert_ne!(code, Some(2), "{text}");
        shop.workshop.read("result/verdict.json")
    };
    assert_eq!(of("1"), of("2"));
}
