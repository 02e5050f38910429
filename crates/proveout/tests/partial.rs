//! `run --preview` and `run --stop-at` as a person types them: a slot of 6 mm in four passes of 4 mm depth
//! each, whose last retract at rapid rate goes through the wall.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

/// Line of the first pass in feed, and how many lines a pass has.
const FIRST: usize = 8;
const LINES: usize = 4;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// The lines of a program with so many passes; `last` is what comes after them.
fn program(passes: usize, last: &str) -> String {
    let mut text =
        String::from("G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS8000 M3\nG0 X-30. Y0.\nZ5.\n");
    for pass in 1..=passes {
        let z = -4.0 * pass as f64;
        text += &format!("G0 X-30.\nG1 Z{z:.1} F2000.\nX30.\nG0 Z5.\n");
    }
    text + last + "G0 Z60.\nM5\nM30\n"
}

struct Desk(TempDir);

impl Desk {
    /// The slot; `last` is what comes after its passes.
    fn new(last: &str) -> Self {
        let desk = Self(tempfile::tempdir().expect("temporary folder"));
        let machine = root().join("machines/three-axis-mill");
        let scene = format!(
            "name = \"slot\"\nmachine = {machine:?}\ntools = \"tools.toml\"\nresolution_mm = 0.5\n\
             [stock]\nbox = {{ min_mm = [-20, -20, -40], max_mm = [20, 20, 0] }}\n\
             [[stock.patch]]\nname = \"wall\"\nmin_mm = [-4, 2, -4]\nmax_mm = [4, 4, 0]\ncell_mm = 0.25\n\
             [part]\nmesh = \"design.stl\"\nchord_error_mm = 0\n\
             [mount]\ntranslation_mm = [0, 0, 140]\n[work_offsets.G54]\nZ_mm = 140\n\
             [[program]]\nname = \"main\"\nfile = \"main.nc\"\ndialect = \"fanuc\"\n",
        );
        desk.write("scene.toml", &scene);
        desk.write(
            "tools.toml",
            "[[tool]]\nnumber = 1\nname = \"F6\"\nkind = \"flat\"\ndiameter_mm = 6.0\nflute_length_mm = 25.0\nshank_diameter_mm = 6.0\n\
             overall_length_mm = 80.0\ngauge_length_mm = 100.0\nflutes = 2\n[tool.holder]\nname = \"H\"\n\
             sections = [{ diameter_mm = 20.0, length_mm = 60.0 }]\n",
        );
        desk.write("main.nc", &program(4, last));
        // What is left when the slot is cut off at its floor: material above it is excess.
        desk.write("design.stl", &block([-20.0, -20.0, -40.0], [20.0, 20.0, -16.0]));
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("written");
    }

    fn call(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(self.0.path())
            .args(line.split_whitespace())
            .output()
            .expect("the program starts")
    }

    /// A run with its exit code; what it said.
    fn run(&self, options: &str, code: i32) -> String {
        let output = self.call(&format!("run . --rerun off --threads 2 {options}"));
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(code), "{options}\n{text}");
        text
    }

    fn verdict(&self, folder: &str) -> Value {
        let text = fs::read_to_string(self.path(folder).join("verdict.json")).expect("written");
        serde_json::from_str(&text).expect("JSON")
    }

    fn volume(&self, folder: &str) -> f64 {
        self.verdict(folder)["removal"]["volume_mm3"].as_f64().expect("a volume")
    }
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

fn gate(verdict: &Value, name: &str) -> (String, String) {
    let gate = verdict["gates"].as_array().expect("gates").iter().find(|g| g["name"] == name).expect("the gate");
    (gate["state"].as_str().unwrap_or_default().to_owned(), gate["reason"].as_str().unwrap_or_default().to_owned())
}

fn codes(verdict: &Value) -> Vec<&str> {
    verdict["findings"].as_array().expect("findings").iter().filter_map(|f| f["code"].as_str()).collect()
}

/// A block as STL text.
fn block(min: [f64; 3], max: [f64; 3]) -> String {
    let corner = |k: usize| [0, 1, 2].map(|bit| if k >> bit & 1 == 1 { max[bit] } else { min[bit] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid block\n");
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(corner) {
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid block\n"
}

#[test]
fn a_preview_says_so_and_passes_nothing_that_asks_the_stock() {
    let desk = Desk::new("");
    // The same slot, finished: a design with the whole slot would pass; this one has excess in both.
    fs::remove_file(desk.path("design.stl")).expect("removed");
    let scene = fs::read_to_string(desk.path("scene.toml")).expect("there");
    desk.write("scene.toml", &scene.replace("[part]\nmesh = \"design.stl\"\nchord_error_mm = 0\n", ""));
    desk.run("", 3);
    let said = desk.run("--preview", 3);
    assert!(said.contains("preview with coarse cells: not a full check"), "{said}");
    assert!(said.contains("PREVIEW with cells of 2 mm instead of 0.5 mm"), "{said}");
    let (full, preview) = (desk.verdict("out/slot-main"), desk.verdict("out/slot-main-preview"));
    assert!(full["partial"].is_null(), "{}", full["partial"]);
    let used = &preview["partial"]["preview"];
    assert_eq!((used["cells_mm"][0].as_f64(), used["scene_cells_mm"][0].as_f64()), (Some(2.0), Some(0.5)), "{used}");
    assert!(used["left_out"][0].as_str().is_some_and(|w| w.contains("wall")), "{used}");
    for name in ["program", "limits"] {
        assert_eq!(gate(&preview, name), gate(&full, name), "{name} does not hang on the cells");
    }
    for name in ["process", "collision", "near_miss", "gouge", "excess"] {
        let (state, reason) = gate(&preview, name);
        assert!(state == "unchecked" && reason.contains("preview"), "{name}: {state}: {reason}");
    }
    assert_eq!(gate(&preview, "surface").0, "not_asked", "the scene has no tolerance of the surface");
    // A slot of 6 x 16 x 40 mm between rays of 2 mm.
    let volume = desk.volume("out/slot-main-preview");
    assert!((volume / 3840.0 - 1.0).abs() < 0.4, "{volume}");
}

#[test]
fn what_a_preview_finds_fails_it() {
    let desk = Desk::new("G0 Z-2.\nX-30. Y10.\n");
    let said = desk.run("--preview", 1);
    assert!(said.contains("FAIL: slot") && said.contains("PREVIEW"), "{said}");
    let verdict = desk.verdict("out/slot-main-preview");
    let (state, reason) = gate(&verdict, "process");
    assert!(state == "fail" && reason.contains("not checked: preview"), "{reason}");
}

#[test]
fn a_run_ends_behind_a_line_as_a_program_that_ends_there() {
    let desk = Desk::new("");
    let end_of_pass_2 = FIRST + 2 * LINES - 2;
    let said = desk.run(&format!("--stop-at {end_of_pass_2}"), 3);
    assert!(said.contains(&format!("after line {end_of_pass_2}: line {end_of_pass_2} was run")), "{said}");
    let stopped = desk.verdict("out/slot-main-stopped");
    let cut = desk.volume("out/slot-main-stopped");
    assert!((cut / (6.0 * 8.0 * 40.0) - 1.0).abs() < 0.02, "two passes of four: {cut}");
    let record = &stopped["partial"]["stopped"];
    assert_eq!((record["line"].as_u64(), record["file"].as_str()), (Some(end_of_pass_2 as u64), Some("main.nc")));
    for name in ["program", "limits", "process", "collision", "near_miss", "gouge", "excess"] {
        let (state, reason) = gate(&stopped, name);
        assert!(state == "unchecked" && reason.contains("stopped at"), "{name}: {state}: {reason}");
    }
    assert!(!codes(&stopped).contains(&"geometry-excess"), "an unfinished part has material everywhere");
    // An independent way to the same: the text itself ends there.
    desk.write("main.nc", &program(2, ""));
    desk.call("run . --rerun off --output out/short");
    assert!((cut - desk.volume("out/short")).abs() < 1e-6, "{cut} {}", desk.volume("out/short"));
    let [long, short] = [&stopped, &desk.verdict("out/short")].map(|v| v["time"]["cutting_s"].as_f64().expect("s"));
    assert!((long - short).abs() < 0.2 * short, "feed of two passes: {long} {short}");
}

#[test]
fn a_run_ends_at_a_time() {
    let desk = Desk::new("");
    desk.call("run . --rerun off --output out/whole");
    let whole = desk.verdict("out/whole")["time"]["total_s"].as_f64().expect("s");
    let half = (50.0 * whole).round() / 100.0;
    desk.run(&format!("--stop-at {half}s"), 3);
    let stopped = desk.verdict("out/slot-main-stopped");
    let time = stopped["partial"]["stopped"]["time_s"].as_f64().expect("s");
    assert!(time >= half - 0.05 && time < half + 2.0, "{half} {time}");
    assert_eq!(stopped["time"]["total_s"].as_f64(), Some(time));
    assert!(stopped["time"]["lower_bound_s"].is_null(), "a bound of the whole program");
    let said = desk.run(&format!("--stop-at {}s", 2.0 * whole), 1);
    assert!(said.contains("not reached; the run went to the end"), "{said}");
    assert!(desk.verdict("out/slot-main-stopped")["partial"].is_null());
}

#[test]
fn a_run_ends_at_the_first_finding() {
    let desk = Desk::new("G0 Z-2.\nX-30. Y10.\nX30. Y-10.\n");
    for option in ["any", "process-rapid-in-material"] {
        let said = desk.run(&format!("--stop-at {option}"), 1);
        assert!(said.contains("STOPPED at") && said.contains("process-rapid-in-material"), "{said}");
        let stopped = desk.verdict("out/slot-main-stopped");
        assert_eq!(codes(&stopped).iter().filter(|c| **c == "process-rapid-in-material").count(), 1);
        let all = stopped["findings"].as_array().expect("findings");
        let rapid = all.iter().find(|f| f["code"] == "process-rapid-in-material").expect("the finding");
        let found = rapid["time_s"].as_f64().expect("s");
        let time = stopped["partial"]["stopped"]["time_s"].as_f64().expect("s");
        assert!(time >= found && time <= found + 0.5, "{found} {time}");
        assert_eq!(gate(&stopped, "process").0, "fail");
        assert_eq!(gate(&stopped, "collision").0, "unchecked");
    }
    let said = desk.run("--stop-at collision-bodies", 1);
    assert!(said.contains("not reached; the run went to the end"), "{said}");
}

#[test]
fn the_next_setup_takes_no_stock_of_such_a_run() {
    let desk = Desk::new("");
    desk.run("--preview --output out/first", 1);
    let scene = fs::read_to_string(desk.path("scene.toml")).expect("there");
    let second = scene.replace("box = { min_mm = [-20, -20, -40], max_mm = [20, 20, 0] }", "from_run = \"out/first\"");
    desk.write("second.toml", &second);
    let refused = |what: &str| {
        let output = desk.call("run second.toml --rerun off --output out/second");
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(what) && text.contains("without --preview and --stop-at"), "{text}");
    };
    refused("is of a preview, with cells of 2 mm");
    desk.run("--stop-at 14 --output out/first", 3);
    refused("is of a run that was stopped at");
}

#[test]
fn a_stop_that_is_none_is_refused_before_anything_is_written() {
    let desk = Desk::new("");
    for (options, words) in [
        ("--stop-at 0", "a line is a whole number from 1"),
        ("--stop-at -4", "a line is a whole number from 1"),
        ("--stop-at 1.5", "12.5s"),
        ("--stop-at NaNs", "no finding has this code"),
        ("--stop-at 0s", "more than 0s"),
        ("--stop-at -1s", "more than 0s"),
        ("--stop-at collision-body", "did you mean collision-bodies?"),
        ("--stop-at geometry-gouge", "judged at the end of the program"),
        ("--stop-at 1", "the next line with a motion is 4"),
        ("--stop-at 4000", "the program has 26 lines"),
        ("--stop-at 4 --stop-at 5", "cannot be used multiple times"),
        ("--preview --resolution-mm 1", "cannot be used with"),
        ("--preview --accept-unchecked gouge", "cannot be used with"),
        ("--stop-at any --accept-unchecked gouge", "cannot be used with"),
        ("--preview --find-stickout", "cannot be used with"),
    ] {
        let said = desk.run(options, 2);
        assert!(said.contains(words), "{options}: {words:?} is not in\n{said}");
        assert!(!desk.path("out").exists(), "{options}: nothing is written");
    }
}
