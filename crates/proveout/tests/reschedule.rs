//! Re-scheduled programs on the command line: what a run keeps, what `reschedule` writes, and which options they take.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
    sync::OnceLock,
};

use tempfile::TempDir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

fn proveout(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder())
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// The blade of the published experiment with one and a half turns of its program, coarse cells, other options than the default
/// ones, and a tolerance that every chord passes, so that there are findings.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().expect("temporary folder");
        let from = root().join("scenes/li-2022-s-theta");
        let path = |p: &str| format!("{:?}", root().join(p).display().to_string());
        let scene = fs::read_to_string(from.join("scene.toml")).expect("the scene");
        let scene = scene
            .replace("\"../../machines/starrag-lx-451\"", &path("machines/starrag-lx-451"))
            .replace("\"../../tools/li-2022.toml\"", &path("tools/li-2022.toml"))
            .replace("resolution_mm = 0.2", "resolution_mm = 2")
            .replace("gouge_mm = 0.03", "gouge_mm = 0.00001")
            .replace("excess_mm = 0.05", "excess_mm = 0.00001")
            .replace("keys = 15", "keys = 9")
            .replace(
                "method = \"s-theta\", from = \"original\"",
                "method = \"s-theta\", from = \"original\", clearance_deg = 45",
            );
        fs::write(folder.path().join("scene.toml"), scene).expect("written");
        let program = fs::read_to_string(from.join("original.mpf")).expect("the program");
        let lines: Vec<&str> = program.lines().collect();
        let text = lines[..600].iter().chain(&["TRAFOOF", "M30"]).map(|l| format!("{l}\n")).collect::<String>();
        fs::write(folder.path().join("original.mpf"), text).expect("written");
        folder
    });
    folder.path()
}

/// A program as `reschedule` writes it.
fn written(words: &[&str], file: &str) -> String {
    let output = proveout(&[&["reschedule", "."], words, &["--output", file, "--force"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read_to_string(folder().join(file)).expect("written")
}

#[test]
fn a_run_keeps_the_text_that_its_findings_cite_and_reschedule_writes_the_same() {
    for (name, method) in [("quaternion", "quaternion"), ("s-theta", "s-theta")] {
        let out = format!("run-{name}");
        let output = proveout(&["run", ".", "--program", name, "--rerun", "off", "--out", &out]);
        assert!(matches!(output.status.code(), Some(1 | 3)), "{}", String::from_utf8_lossy(&output.stderr));
        let run = folder().join(&out);
        let kept = fs::read_to_string(run.join(format!("{name}.mpf"))).expect("the text is kept");
        let verdict = fs::read_to_string(run.join("verdict.json")).expect("written");
        let verdict: serde_json::Value = serde_json::from_str(&verdict).expect("JSON");
        let cited: Vec<_> =
            verdict["findings"].as_array().expect("a list").iter().filter(|f| f["line"].is_u64()).collect();
        assert!(!cited.is_empty(), "a tolerance of nothing is passed somewhere");
        for finding in cited {
            let file = run.join(finding["file"].as_str().expect("a file"));
            let lines =
                fs::read_to_string(&file).expect("the file that a finding cites is in the folder").lines().count();
            assert!(finding["line"].as_u64().expect("a line") <= lines as u64, "{finding}");
        }
        // The options of the scene are those of the command too, whichever way the program is named.
        let by_source = written(&["--program", "original", "--method", method], &format!("{name}-a.mpf"));
        let by_name = written(&["--program", name, "--method", method], &format!("{name}-b.mpf"));
        assert!(by_source == kept && by_name == kept, "{name}: not the program that runs");
    }
}

#[test]
fn set_takes_the_place_of_the_scene() {
    let scene = written(&["--program", "original", "--method", "quaternion"], "k.mpf");
    let nine = written(&["--program", "original", "--method", "quaternion", "--set", "keys=9"], "k9.mpf");
    let other = written(&["--program", "original", "--method", "quaternion", "--set", "keys=15"], "k15.mpf");
    assert!(scene == nine && scene != other);
    let scene = written(&["--program", "original", "--method", "s-theta"], "s.mpf");
    for option in ["clearance_deg=50", "inset_deg=4", "theta_unit=radian"] {
        let other = written(&["--program", "original", "--method", "s-theta", "--set", option], "s2.mpf");
        assert!(scene != other, "{option} changes nothing");
    }
}

#[test]
fn two_programs_with_other_options_must_be_told_apart() {
    let own = tempfile::tempdir().expect("temporary folder");
    let scene = fs::read_to_string(folder().join("scene.toml")).expect("readable");
    let more =
        "\n[[program]]\nname = \"coarse\"\nreschedule = { method = \"quaternion\", from = \"original\", keys = 5 }\n";
    fs::write(own.path().join("scene.toml"), scene + more).expect("written");
    fs::copy(folder().join("original.mpf"), own.path().join("original.mpf")).expect("copied");
    let call = |program: &str| {
        let scene = own.path().display().to_string();
        proveout(&["reschedule", &scene, "--program", program, "--method", "quaternion", "--output", "two.mpf"])
    };
    let refused = call("original");
    let told = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{told}");
    assert!(told.contains("several programs") && told.contains("quaternion, coarse"), "{told}");
    assert_eq!(call("coarse").status.code(), Some(0));
}
