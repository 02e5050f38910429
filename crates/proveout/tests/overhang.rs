//! `run --find-stickout` as a person types it, and the picture of a first contact: a slot of 6 mm, 20 mm
//! deep, in a block whose face lies at zero. A holder of 20 mm diameter does not fit into the slot, so that
//! its nose has to stay above the face by the wanted clearance: the least overhang is 20 mm and that
//! clearance.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;

const DEPTH: f64 = 20.0;
const CLEARANCE: f64 = 1.0;
/// The reported overhang is at most this much more than needed, mm (`STEP_MM` of the search).
const STEP: f64 = 0.5;
const HOLDER: f64 = 40.0;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// Runs the slot with a tool that projects by `overhang`; gives exit code, what is said, and the run
/// folder.
fn run(folder: &Path, overhang: f64, options: &[&str]) -> (i32, String, PathBuf) {
    let scene = format!(
        "name = \"slot\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = 0.5\n\
         [stock.box]\nmin_mm = [-20, -20, -40]\nmax_mm = [20, 20, 0]\n[mount]\ntranslation_mm = [0, 0, 140]\n\
         [work_offsets.G54]\nZ_mm = 140\n[tolerances]\nnear_miss_mm = {CLEARANCE}\n\
         [[program]]\nname = \"main\"\nfile = \"main.nc\"\ndialect = \"fanuc\"\n",
        root().join("machines/three-axis-mill"),
    );
    let tools = format!(
        "[[tool]]\nnumber = 1\nname = \"B6\"\nkind = \"ball\"\ndiameter_mm = 6.0\nflute_length_mm = 10.0\nshank_diameter_mm = 5.0\n\
         overall_length_mm = 80.0\ngauge_length_mm = {}\nflutes = 2\n[tool.holder]\nname = \"H\"\n\
         sections = [{{ diameter_mm = 20.0, length_mm = {HOLDER} }}]\n",
        overhang + HOLDER
    );
    let mut program =
        String::from("G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS8000 M3\nG0 X-30. Y0.\nZ5.\n");
    let mut z = 0.0;
    while z > -DEPTH {
        z -= 4.0;
        writeln!(program, "G0 X-30.\nG1 Z{z:.1} F2000.\nX30.\nG0 Z5.").expect("a text");
    }
    program += "G0 Z60.\nM5\nM30\n";
    for (name, text) in [("scene.toml", &scene), ("tools.toml", &tools), ("main.nc", &program)] {
        fs::write(folder.join(name), text).expect("written");
    }
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "2"])
        .args(options)
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code().unwrap_or(-1), said, folder.join("result"))
}

fn verdict(result: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(result.join("verdict.json")).expect("a verdict")).expect("JSON")
}

fn assert_needed(said: &str, result: &Path) {
    let least =
        verdict(result)["tools"][0]["min_overhang_mm"].as_f64().unwrap_or_else(|| panic!("no overhang\n{said}"));
    let needed = DEPTH + CLEARANCE;
    assert!((needed - 1e-6..=needed + STEP + 1e-6).contains(&least), "{least}\n{said}");
    assert!(said.contains(&format!("B6                       {least:>8.1} mm")), "{said}");
}

#[test]
fn a_long_tool_hears_how_much_is_not_needed() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (_, said, result) = run(folder.path(), 34.0, &["--find-stickout"]);
    assert_needed(&said, &result);
    assert!(said.contains("clamped 34.0 mm, longer than needed by 1"), "{said}");
}

#[test]
fn a_short_tool_hears_what_it_lacks_and_the_report_shows_the_contact() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (code, said, result) = run(folder.path(), 16.0, &["--find-stickout"]);
    assert_eq!(code, 1, "{said}");
    assert_needed(&said, &result);
    assert!(said.contains("clamped 16.0 mm, too short by"), "{said}");
    let page = fs::read_to_string(result.join("report.html")).expect("a report");
    let begin = page.find("data:image/png;base64,").unwrap_or_else(|| panic!("no picture"));
    assert!(page[begin..].contains("B6&#x2f;holder") && page[begin..].contains(">stock</b>"), "names of both bodies");
}

#[test]
fn without_the_option_the_figure_stays_open() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (_, said, result) = run(folder.path(), 34.0, &[]);
    assert!(verdict(&result)["tools"][0]["min_overhang_mm"].is_null(), "{said}");
    let page = fs::read_to_string(result.join("report.html")).expect("a report");
    assert!(!page.contains("data:image/png;base64,"), "no contact, no picture");
}
