//! The schedule of a re-scheduled program in the recording of its run, typed as a person does and read back.
#![cfg(feature = "rerun")]

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use proveout_record::{RecordedEntity, read_recording};
use serde_json::Value;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

fn proveout(folder: &Path, arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts");
    assert!(matches!(output.status.code(), Some(0 | 1 | 3)), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// One and a half turns of the published experiment, coarse cells, nothing that is left open.
fn scene(folder: &Path) {
    let from = root().join("scenes/li-2022-s-theta");
    let path = |p: &str| format!("{:?}", root().join(p).display().to_string());
    let scene = fs::read_to_string(from.join("scene.toml")).expect("the scene");
    let scene = scene
        .replace("\"../../machines/starrag-lx-451\"", &path("machines/starrag-lx-451"))
        .replace("\"../../tools/li-2022.toml\"", &path("tools/li-2022.toml"))
        .replace("resolution_mm = 0.2", "resolution_mm = 2");
    let scene = scene.replace("chord_error_mm = 0.001", "chord_error_mm = 0.02");
    let scene = scene.split("[[compare.choice]]").next().unwrap_or_default();
    let (before, others) = scene.split_once("[[program]]\nname = \"quaternion\"").expect("another program");
    let (_, behind) = others.split_once("[[program]]").expect("a program behind it");
    let scene = format!("{before}[[program]]{behind}");
    let (before, patches) = scene.split_once("[surface]").expect("patches");
    let (_, behind) = patches.split_once("# What `proveout plan").expect("a plan");
    fs::write(folder.join("scene.toml"), format!("{before}# {behind}")).expect("written");
    let program = fs::read_to_string(from.join("original.mpf")).expect("the program");
    let lines: Vec<&str> = program.lines().collect();
    let text = lines[..600].iter().chain(&["TRAFOOF", "M30"]).map(|l| format!("{l}\n")).collect::<String>();
    fs::write(folder.join("original.mpf"), text).expect("written");
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

fn recorded(folder: &Path, run: &str) -> BTreeMap<String, RecordedEntity> {
    read_recording(&folder.join(run).join("recording.rrd")).unwrap_or_else(|e| panic!("{e}"))
}

/// Where the second list begins in the first.
fn place(all: &[[f64; 2]], part: &[f64], within: f64) -> Option<usize> {
    (0..=all.len().checked_sub(part.len())?)
        .find(|k| all[*k..].iter().zip(part).all(|(a, b)| (a[1] - b).abs() < within))
}

#[test]
#[ignore = "nightly, 26 s"]
fn the_recording_of_a_run_and_of_a_comparison_shows_the_schedule() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    scene(folder);
    proveout(folder, &["run", ".", "--program", "s-theta", "--rerun", "file", "--output", "one"]);
    let words = ["reschedule", ".", "--program", "original", "--method", "s-theta", "--output", "t.mpf"];
    proveout(folder, &[&words[..], &["--certificate", "t.json"]].concat());
    let certificate = fs::read_to_string(folder.join("t.json")).expect("written");
    let certificate: Value = serde_json::from_str(&certificate).expect("JSON");
    let run = &certificate["runs"][0];
    let joint = run["joints"].as_array().expect("a list").iter().find(|j| j["name"] == "A").expect("A");
    let one = recorded(folder, "one");
    let entity =
        |name: &str| one.get(&format!("/schedule/{name}")).unwrap_or_else(|| panic!("no {name}: {:?}", one.keys()));

    // Positions at the ends of all blocks; the stretch is that of the certificate.
    let [before, after] = [numbers(&joint["original_deg"]), numbers(&joint["new_deg"])];
    let [old, new] = ["original", "new"].map(|name| entity(&format!("joints/A/position/{name}")));
    let rows = [new.rows, new.values.len(), old.rows];
    assert!(rows.iter().all(|n| *n == rows[0]) && rows[0] >= after.len(), "{rows:?} {}", after.len());
    let start = place(&new.values, &after, 1e-4).expect("the new positions");
    assert_eq!(place(&old.values, &before, 1e-4), Some(start));
    // The channel with it, without what the control rounds off.
    let rounding = run["rounding_deg"].as_f64().expect("a number");
    let gates: Vec<Vec<f64>> = joint["gates_deg"].as_array().expect("a list").iter().map(numbers).collect();
    for (k, (name, sign)) in [("lowest", 1.0), ("highest", -1.0)].into_iter().enumerate() {
        let shown = entity(&format!("joints/A/position/{name}"));
        assert_eq!(shown.rows, gates.len(), "{name}");
        for (i, (row, gate)) in shown.values.iter().zip(&gates).enumerate() {
            assert!((row[1] - gate[k] - sign * rounding).abs() < 1e-9, "{name} {i}");
            assert!((row[0] - new.values[start + i][0]).abs() < 1e-12, "at the time of its block");
        }
    }
    // What is asked at the programmed feed, by differences of its own.
    let times = numbers(&run["nominal_s"]);
    let velocity = &entity("joints/A/velocity/new").values;
    let at: BTreeMap<u64, f64> = velocity.iter().map(|row| (row[0].to_bits(), row[1])).collect();
    for i in 1..after.len() {
        let shown = at[&new.values[start + i][0].to_bits()];
        let own = (after[i] - after[i - 1]) / times[i - 1];
        assert!((shown - own).abs() < 0.01 + 1e-3 * own.abs(), "{i}: {shown} and {own}");
    }
    let most = |name: &str| {
        let values = &entity(&format!("joints/A/acceleration/{name}")).values;
        values.iter().map(|v| v[1].abs()).fold(0.0, f64::max)
    };
    assert!(most("new") < most("original"), "{} {}", most("new"), most("original"));
    // Times of the blocks rise, and are those of the run.
    assert!(new.values.windows(2).all(|w| w[1][0] > w[0][0]));
    let text = entity("text").text.clone().expect("a page");
    for key in ["gap_percent", "bound_s", "time_s", "original_time_s"] {
        let number = run[key].as_f64().expect("a number");
        let words = if key == "gap_percent" { format!("{number:.2} percent") } else { format!("{number:.3} s") };
        assert!(text.contains(&words), "{key} {words} is not in:\n{text}");
    }
    assert!(text.contains("made from **original** by **s-theta**"), "{text}");
    // Tool axes: unit vectors of the workpiece frame that the playhead moves, and arrows of one length at the
    // blade.
    for name in ["original", "new"] {
        let points = &entity(&format!("sphere/{name}_now")).points;
        assert_eq!(points.len(), new.rows);
        let length = |v: &[f32; 3]| v.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!(points.iter().all(|p| (length(p) - 1.0).abs() < 0.006));
        let arrows = &one[&format!("/machine/table/work/schedule/{name}")].arrows;
        assert!(arrows.len() > 80 && arrows.len() <= 160, "{}", arrows.len());
        assert!(arrows.iter().all(|a| (length(a) / length(&arrows[0]) - 1.0).abs() < 1e-5));
    }
    let curves: Vec<&String> =
        one.keys().filter(|k| k.starts_with("/schedule/method/tool_axis_angle_in_the_section/")).collect();
    assert!(curves.iter().any(|k| k.ends_with("/original")) && curves.len() >= 4, "{curves:?}");

    // A comparison, which has the motions already, records the same; the program before has no schedule.
    proveout(folder, &["compare", ".", "--rerun", "file", "--output", "all"]);
    let all = recorded(folder, "all/s-theta");
    for (name, entity) in one.iter().filter(|(name, _)| name.starts_with("/schedule/")) {
        assert!(all.get(name).is_some_and(|other| same(other, entity)), "{name} differs");
    }
    assert!(recorded(folder, "all/original").keys().all(|k| !k.contains("schedule")));
}

fn same(a: &RecordedEntity, b: &RecordedEntity) -> bool {
    let bits = |rows: &[[f64; 2]]| rows.iter().map(|r| r.map(f64::to_bits)).collect::<Vec<_>>();
    a.rows == b.rows && bits(&a.values) == bits(&b.values) && a.points == b.points && a.text == b.text
}
