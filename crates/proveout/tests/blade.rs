//! A blade on the command line: its points are compared with the closed form, whatever mesh represents it.

use std::{fs, path::Path, process::Command};

use serde_json::Value;

/// The blade of the published experiment on a mesh of 0.05 mm chord error, two and a half turns of its
/// program, cells of 1 mm. In the judged box turns lie on both sides of every point.
fn verdict() -> (Value, String) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root");
    let folder = tempfile::tempdir().expect("temporary folder");
    let from = root.join("scenes/li-2022-s-theta");
    let path = |p: &str| format!("{:?}", root.join(p).display().to_string());
    let scene = fs::read_to_string(from.join("scene.toml")).expect("the scene");
    let scene = scene
        .replace("\"../../machines/starrag-lx-451\"", &path("machines/starrag-lx-451"))
        .replace("\"../../tools/li-2022.toml\"", &path("tools/li-2022.toml"))
        .replace("resolution_mm = 0.2", "resolution_mm = 1")
        .replace("chord_error_mm = 0.001", "chord_error_mm = 0.05")
        .replace("min_mm = [13.5, -200, -200]", "min_mm = [12.9, -200, -200]")
        .replace("max_mm = [16.5, 200, 200]", "max_mm = [13.5, 200, 200]");
    fs::write(folder.path().join("scene.toml"), scene).expect("written");
    let program = fs::read_to_string(from.join("original.mpf")).expect("the program");
    let lines: Vec<&str> = program.lines().collect();
    let text = lines[..1000].iter().chain(&["TRAFOOF", "M30"]).map(|l| format!("{l}\n")).collect::<String>();
    fs::write(folder.path().join("original.mpf"), text).expect("written");
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder.path())
        .args(["run", ".", "--program", "original", "--output", "run"])
        .output()
        .expect("the program starts");
    let text = fs::read_to_string(folder.path().join("run/verdict.json"));
    let text = text.unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)));
    let report = fs::read_to_string(folder.path().join("run/report.html")).expect("the report");
    (serde_json::from_str(&text).expect("the verdict"), report)
}

#[test]
fn a_blade_is_judged_against_its_closed_form() {
    let (verdict, report) = verdict();
    let deviation = &verdict["deviation"];
    let number = |key: &str| deviation[key].as_f64().unwrap_or_else(|| panic!("{key}: {deviation}"));
    assert_eq!(deviation["against"], "closed form of the blade");
    assert!(number("samples") > 50.0 && number("design_error_mm") < 1e-6, "{deviation}");
    // The chord error of the mesh is measured, not the 0.05 that were asked for.
    let mesh = number("mesh_error_mm");
    assert!(mesh > 0.03 && mesh < 0.2 && (mesh - 0.05).abs() > 1e-6, "{mesh}");
    // Chords of 0.5 mm round the trailing edge leave 3.4 micrometers, ridges between turns are 15.6
    // micrometers high, see the scene's README; a mesh that is 50 micrometers off shows neither.
    assert!(number("gouge_max_mm") < 0.005, "{deviation}");
    let ridge = number("excess_max_mm");
    assert!((0.012..0.0186).contains(&ridge), "{deviation}");
    assert!(number("tolerance_floor_mm") < 0.0015, "{deviation}");
    let gates = verdict["gates"].as_array().expect("gates");
    let gouge = gates.iter().find(|g| g["name"] == "gouge").expect("the gate");
    assert_eq!(gouge["state"], "pass", "{gouge}");
    let words = format!("missing walls on rays through its mesh, up to {:.2} um off as measured", 1e3 * mesh);
    let reason = gouge["reason"].as_str().unwrap_or_default();
    assert!(reason.contains("against the closed form of the blade") && reason.contains(&words), "{reason}");
    assert!(report.contains("closed form of the blade"));
}
