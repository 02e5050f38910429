//! `proveout job` as a person types it: two setups of a block, a slot in each, the stock handed on.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

const JOB: &str =
    "name = \"block\"\n[[setup]]\nname = \"op10\"\nscene = \"op10\"\n[[setup]]\nname = \"op20\"\nscene = \"op20\"\n";
const BOX: &str = "box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

fn scene(name: &str, stock: &str) -> String {
    format!(
        "name = \"{name}\"\nmachine = {:?}\ntools = \"../tools.toml\"\nresolution_mm = 0.5\n[stock]\n{stock}\n\
         [mount]\ntranslation_mm = [0, 0, 140]\n[work_offsets.G54]\nZ_mm = 140\n\
         [[program]]\nname = \"main\"\nfile = \"main.nc\"\ndialect = \"fanuc\"\n",
        root().join("machines/three-axis-mill")
    )
}

/// A slot of 6 mm, 4 mm deep, along X at this place of Y; `before` is put in front of it.
fn slot(y: f64, before: &str) -> String {
    format!(
        "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS8000 M3\n{before}G0 X-30. Y{y:.1}\nZ5.\nG1 Z-4. F2000.\nX30.\nG0 Z60.\nM5\nM30\n"
    )
}

struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().expect("temporary folder"));
        for name in ["op10", "op20"] {
            fs::create_dir(desk.path(name)).expect("made");
        }
        desk.write("job.toml", JOB);
        desk.write("op10/scene.toml", &scene("first", BOX));
        desk.write("op20/scene.toml", &scene("second", "from_run = \"before\""));
        desk.write("op10/main.nc", &slot(-10.0, ""));
        desk.write("op20/main.nc", &slot(10.0, ""));
        desk.write(
            "tools.toml",
            "[[tool]]\nnumber = 1\nname = \"F6\"\nkind = \"flat\"\ndiameter_mm = 6.0\nflute_length_mm = 25.0\nshank_diameter_mm = 6.0\n\
             overall_length_mm = 80.0\ngauge_length_mm = 100.0\nflutes = 2\n[tool.holder]\nname = \"H\"\n\
             sections = [{ diameter_mm = 20.0, length_mm = 60.0 }]\n",
        );
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("written");
    }

    fn call(&self, line: &str, code: i32) -> String {
        let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(self.0.path())
            .args(line.split_whitespace())
            .output()
            .expect("the program starts");
        let text = printed(&output);
        assert_eq!(output.status.code(), Some(code), "{line}\n{text}");
        text
    }

    /// The call is refused with these words, and nothing is written.
    fn refused(&self, words: &[&str]) {
        let output = self.call("job .", 2);
        for word in words {
            assert!(output.contains(word), "{word:?} is not in:\n{output}");
        }
        assert_eq!(output.matches("error: ").count(), 1, "one clear answer:\n{output}");
        let left: Vec<_> = fs::read_dir(self.path("out")).into_iter().flatten().collect();
        assert!(left.is_empty(), "nothing by halves: {left:?}");
    }

    fn result(&self) -> Value {
        let text = fs::read_to_string(self.path("out/block-job/job.json")).expect("written");
        serde_json::from_str(&text).expect("JSON")
    }
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

#[test]
fn the_stock_is_handed_on_and_one_verdict_says_all() {
    let desk = Desk::new();
    // Without designs it is not known whether the part is right.
    let said = desk.call("job . --threads 2", 3);
    assert!(said.contains("UNCHECKED: block") && said.contains("stock of op10"), "{said}");
    let job = desk.result();
    let setups = job["setups"].as_array().expect("setups");
    let volume = |k: usize, key: &str| setups[k][key].as_f64().expect("a volume");
    // A block of 40 x 40 x 20 mm, then less a slot of 6 x 4 x 40 mm, then less another one.
    assert!((volume(0, "stock_left_mm3") - (32_000.0 - 960.0)).abs() < 10.0, "{job}");
    assert!((volume(1, "stock_left_mm3") - (32_000.0 - 1920.0)).abs() < 20.0, "{job}");
    assert!((volume(1, "removed_mm3") - 960.0).abs() < 10.0, "{job}");
    let stock = fs::read(desk.path("out/block-job/op10/stock.dexel")).expect("a stock");
    let digest = proveout_sim::digest::of_bytes(&stock);
    assert_eq!(setups[1]["stock_digest"].as_str(), Some(digest.as_str()), "op20 began with what op10 left");
    let page = fs::read_to_string(desk.path("out/block-job/job.html")).expect("a page");
    assert!(page.contains("href=\"op10/report.html\"") && page.contains("href=\"op20/report.html\""));
    // The folder and each setup in it agree with their manifests, from where they lie now.
    desk.call("verify out/block-job --scene .", 0);
    for name in ["op10", "op20"] {
        desk.call(&format!("verify out/block-job/{name}"), 0);
    }
    // Again, to the same bytes.
    let before = fs::read(desk.path("out/block-job/job.json")).expect("read");
    desk.call("job . --threads 1", 3);
    assert_eq!(before, fs::read(desk.path("out/block-job/job.json")).expect("read"));
}

#[test]
fn behind_a_setup_that_failed_nothing_is_run() {
    let desk = Desk::new();
    desk.write("op10/main.nc", &slot(-10.0, "G0 X-30. Y0.\nZ-2.\nX30.\nZ60.\n"));
    let said = desk.call("job .", 1);
    assert!(
        said.contains("FAIL: block") && said.contains("op20             not run: setup op10 before it failed"),
        "{said}"
    );
    let job = desk.result();
    assert!(job["setups"][1]["verdict"].is_null() && job["setups"][0]["verdict"] == "fail", "{job}");
    assert!(!desk.path("out/block-job/op20").exists() && desk.path("out/block-job/op10/report.html").exists());
}

#[test]
fn a_job_that_is_wrong_is_refused_before_anything_is_cut() {
    let desk = Desk::new();
    let with = |job: &str, words: &[&str]| {
        desk.write("job.toml", job);
        desk.refused(words);
    };
    with("name = \"block\"\n", &["the job has no setup"]);
    with("", &["job.toml"]);
    with(
        &JOB.replace("\"op20\"\nscene = \"op20\"", "\"op20\"\nscene = \"op30\""),
        &["scene of setup \"op20\" is not there", "op30"],
    );
    with(&JOB.replace("\"op20\"\n", "\"op10\"\n"), &["two setups have the name \"op10\""]);
    with(&(JOB.to_owned() + "after = \"op20\"\n"), &["the setups would depend on each other in a circle"]);
    with(&(JOB.to_owned() + "after = \"op1\"\n"), &["not a setup of the job", "did you mean \"op10\"?"]);
    with(&JOB.replacen("scene = \"op10\"\n", "scene = \"op10\"\nafter = \"op20\"\n", 1), &["no setup comes before it"]);
    with(&JOB.replace("op20\"\nscene", "../op20\"\nscene"), &["begins with a point or a dash"]);
    with(&JOB.replace("[[setup]]\nname = \"op20\"", "[[setups]]\nname = \"op20\""), &["did you mean `setup`?"]);
    with(&(JOB.to_owned() + "program = \"third\"\n"), &["there is no program \"third\""]);
    desk.write("job.toml", JOB);
    desk.write("op20/scene.toml", &scene("second", BOX));
    desk.refused(&["defines its own stock", "from_run = \"before\""]);
    // A fault in the last program costs no run of the first one.
    desk.write("op20/scene.toml", &scene("second", "from_run = \"before\""));
    desk.write("op20/main.nc", &slot(10.0, "G1 X=\n"));
    desk.refused(&["main.nc"]);
    desk.write("op20/main.nc", &slot(10.0, "T9 M6\n"));
    desk.refused(&["T9"]);
}
