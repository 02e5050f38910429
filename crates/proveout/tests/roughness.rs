//! Roughness maps on the command line: the scene with teeth and run-out, as it is, with tolerances that it
//! misses, and with teeth that are not described.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use tempfile::TempDir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// The scene in a folder of its own, coarser and with fewer nodes, so that it takes seconds.
struct Copy(TempDir);

impl Copy {
    fn new(change: impl Fn(String) -> String, tools: impl Fn(String) -> String) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let (from, root) = (root().join("scenes/face-mill-marks"), root());
        for name in ["face.nc", "part.stl"] {
            fs::copy(from.join(name), folder.path().join(name)).expect("copied");
        }
        let library = fs::read_to_string(root.join("tools/face-mill-marks.toml")).expect("tools");
        fs::write(folder.path().join("tools.toml"), tools(library)).expect("written");
        let scene = fs::read_to_string(from.join("scene.toml")).expect("scene");
        let machine = root.join("machines/three-axis-mill").display().to_string();
        let scene = scene
            .replace("../../machines/three-axis-mill", &machine)
            .replace("../../tools/face-mill-marks.toml", "tools.toml")
            .replace("resolution_mm = 0.25", "resolution_mm = 0.5")
            .replace("step_um = 10", "step_um = 50\nrandom_phases = 2");
        fs::write(folder.path().join("scene.toml"), change(scene)).expect("written");
        Self(folder)
    }

    fn run(&self) -> Output {
        Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(self.0.path())
            .args(["run", ".", "--output", "result", "--rerun", "off"])
            .output()
            .expect("the program starts")
    }

    fn verdict(&self) -> serde_json::Value {
        let text = fs::read_to_string(self.0.path().join("result/verdict.json")).expect("a verdict");
        serde_json::from_str(&text).expect("JSON")
    }
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn surface_gate(verdict: &serde_json::Value) -> (String, String) {
    let gates = verdict["gates"].as_array().expect("gates");
    let gate = gates.iter().find(|g| g["name"] == "surface").expect("the gate");
    let text = |key: &str| gate[key].as_str().unwrap_or_default().to_owned();
    (text("state"), text("reason"))
}

#[test]
fn a_scene_that_keeps_its_tolerances_passes_with_exit_code_0_and_leaves_its_maps() {
    let copy = Copy::new(|s| s, |t| t);
    let output = copy.run();
    let verdict = copy.verdict();
    assert_eq!(output.status.code(), Some(0), "{}\n{:#}", printed(&output), verdict["gates"]);
    assert_eq!(verdict["verdict"], "pass");
    let (state, reason) = surface_gate(&verdict);
    assert_eq!(state, "pass", "{reason}");
    assert!(reason.contains("ra_um: 2 profiles at most 2.5 um; worst "), "{reason}");
    let textures = verdict["surface"]["textures"].as_array().expect("textures");
    assert_eq!(textures.len(), 2);
    for texture in textures {
        assert_eq!(texture["residual"]["source"], "FACE_D20 states none: unknown, not zero");
        assert_eq!(texture["phases"]["repeats"], 2);
        let report = &texture["profiles"][0]["report"];
        for key in [
            "standard",
            "class",
            "lambda_s_um",
            "lambda_c_mm",
            "evaluation_length_mm",
            "form_removal",
            "end_rule",
            "spacing_um",
        ] {
            assert!(!report[key].is_null(), "{key}");
        }
    }
    let result = copy.0.path().join("result");
    for name in ["middle", "side"] {
        for ending in ["png", "sdf", "x3p"] {
            let path = result.join(format!("maps/{name}.{ending}"));
            assert!(fs::metadata(&path).is_ok_and(|m| m.len() > 1000), "{}", path.display());
        }
    }
    assert!(fs::metadata(result.join("roughness.glb")).is_ok_and(|m| m.len() > 10_000));
    let page = fs::read_to_string(result.join("report.html")).expect("a page");
    assert!(
        page.contains("Texture of the surface")
            && page.contains("texture-data")
            && page.contains("FACE_D20 states none")
    );
}

#[test]
fn tolerances_that_are_missed_fail_with_place_and_block() {
    let copy = Copy::new(|s| s.replace("ra_um = 2.5", "ra_um = 0.4"), |t| t);
    let output = copy.run();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    let verdict = copy.verdict();
    let (state, reason) = surface_gate(&verdict);
    assert_eq!(state, "fail", "{reason}");
    let findings = verdict["findings"].as_array().expect("findings");
    let found: Vec<_> = findings.iter().filter(|f| f["code"] == "surface-roughness").collect();
    assert!(!found.is_empty());
    assert!(
        found.iter().all(|f| f["line"] == 9 && f["file"].as_str().is_some_and(|n| n.ends_with("face.nc"))),
        "{found:#?}"
    );
    assert!(
        found.iter().all(|f| f["limit"] == 0.4 && f["unit"] == "um" && f["value"].as_f64().is_some_and(|v| v > 0.4))
    );
}

#[test]
fn teeth_that_nobody_describes_are_unchecked_by_name() {
    let bare = |t: String| {
        let (before, after) = t.split_once("[tool.edges]").expect("edges");
        let holder = after.find("[tool.holder]").expect("a holder");
        format!("{before}{}", &after[holder..])
    };
    let copy = Copy::new(|s| s, bare);
    let output = copy.run();
    assert_eq!(output.status.code().map(|c| c == 0), Some(false), "{}", printed(&output));
    let (state, reason) = surface_gate(&copy.verdict());
    assert_eq!(state, "unchecked", "{reason}");
    assert!(reason.contains("tool \"FACE_D20\" has no [tool.edges]"), "{reason}");
}

#[test]
fn a_patch_off_the_part_is_refused_with_line_and_remedy() {
    let copy = Copy::new(|s| s.replace("at_mm = [20, 7, 0]", "at_mm = [20, 8.5, 0]"), |t| t);
    let output = copy.run();
    assert_eq!(output.status.code(), Some(2), "{}", printed(&output));
    let text = printed(&output);
    for words in ["scene.toml:", "patch \"side\"", "leaves the surface of the design", "move it, or make it smaller"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!copy.0.path().join("result").exists());
}
