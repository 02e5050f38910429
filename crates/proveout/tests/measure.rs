//! `proveout measure` on the stock of a run, against closed forms, and what it refuses.

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

fn proveout(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// A block of 40 x 40 x 20 mm with a slot of 20 mm, 5 mm deep, along X; a patch over one of its edges; the
/// design is the block as text.
fn shop() -> &'static Path {
    static SHOP: OnceLock<TempDir> = OnceLock::new();
    let folder = SHOP.get_or_init(|| {
        let folder = tempfile::tempdir().expect("temporary folder");
        let (root, path) = (root(), folder.path());
        let scene = format!(
            "name = \"small\"\nmachine = {:?}\ntools = {:?}\nresolution_mm = 1.0\n[stock]\n\
             box = {{ min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }}\n[[stock.patch]]\nname = \"edge\"\n\
             min_mm = [-3, 8, -8]\nmax_mm = [3, 12, 1]\ncell_mm = 0.25\n[mount]\ntranslation_mm = [0, 0, 140]\n\
             [work_offsets.G54]\nZ_mm = 140\n[[program]]\nname = \"main\"\nfile = \"main.mpf\"\n",
            root.join("machines/spinner-u5-620").display().to_string(),
            root.join("tools/cone-frustum.toml").display().to_string(),
        );
        fs::write(path.join("scene.toml"), scene).expect("written");
        let program =
            "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X-40 Y0 Z50 S1000 M3 D1\nG0 Z-5\nG1 X40 F500\nG0 Z50\nM30\n";
        fs::write(path.join("main.mpf"), program).expect("written");
        let (mut obj, face) = (String::new(), |a: &str| format!("f {a}\n"));
        for k in 0..8 {
            let at = |bit: usize, low: i32, high: i32| if k >> bit & 1 == 1 { high } else { low };
            obj += &format!("v {} {} {}\n", at(0, -20, 20), at(1, -20, 20), at(2, -20, 0));
        }
        for f in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
            obj += &face(f);
        }
        fs::write(path.join("design.obj"), obj).expect("written");
        let output = proveout(path, &["run", ".", "--output", "result", "--rerun", "off"]);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "unchecked: no design in the scene\n{printed}");
        assert!(
            printed.contains("memory: stock ") && printed.contains(", edge ") && printed.contains("4096 MiB allowed"),
            "{printed}"
        );
        folder
    });
    folder.path()
}

/// Standard output of a call that did its work.
fn measured(arguments: &[&str]) -> String {
    let output = proveout(shop(), &[&["measure"], arguments].concat());
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{printed}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn json(name: &str) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(shop().join(name)).expect("written")).expect("JSON")
}

#[test]
fn a_run_with_a_patch_leaves_its_files() {
    let result = shop().join("result");
    let verdict: serde_json::Value = json("result/verdict.json");
    let patch = &verdict["removal"]["patches"][0];
    assert_eq!((patch["name"].as_str(), patch["cells_mm"][0].as_f64()), (Some("edge"), Some(0.25)));
    assert!(patch["sweep_bound_mm"].as_f64().expect("cut") < 1e-3 && patch["points"].as_u64() > Some(500));
    assert!(json("result/run.json")["stock_mib"]["edge"].as_f64().expect("given") > 0.0);
    assert!(result.join("stock.dexel").is_file() && result.join("stock-patch-edge.dexel").is_file());
    let report = fs::read_to_string(result.join("report.html")).expect("written");
    assert!(report.contains("edge: X -3 to 3, Y 8 to 12, Z -8 to 1 mm"), "the report tells of the patch");
}

#[test]
fn sections_have_the_area_of_the_part() {
    // Across the slot: 40 x 20 less 20 x 5.
    let text = measured(&["result", "--section", "x=3.7", "--design", "design.obj", "--output", "section.json"]);
    assert!(
        text.contains("700.0")
            && text.contains("round material 1, round holes 0, ")
            && text.contains("design 800.0000 mm²"),
        "{text}"
    );
    let section = &json("section.json")["section"];
    let area = section["stock"]["area_mm2"].as_f64().expect("a number");
    assert!((area - 700.0).abs() < 0.01, "{area}");
    let length = section["stock"]["outlines"][0]["length_mm"].as_f64().expect("a number");
    assert!((length - 130.0).abs() < 0.01, "40 + 2 x 20 + 2 x 10 + 2 x 5 + 20: {length}");
    // Through the slot: two bars.
    let text = measured(&["result/stock.dexel", "--section", "z=-2.5", "--output", "section.csv"]);
    assert!(text.contains("800.0") && text.contains("round material 2, "), "{text}");
    let table = fs::read_to_string(shop().join("section.csv")).expect("written");
    assert!(table.starts_with("body,outline,x_mm,y_mm,z_mm\nstock,1,") && table.contains("stock,2,"), "{table}");
    measured(&["result", "--section", "y=-15", "--output", "section.svg"]);
    let drawing = fs::read_to_string(shop().join("section.svg")).expect("written");
    assert!(drawing.starts_with("<svg") && drawing.contains("width=\"44.000mm\" height=\"24.000mm\""), "{drawing}");
}

#[test]
fn distances_and_walls_are_those_of_the_part() {
    let text = measured(&[
        "result",
        "--distance",
        "0,0,-2",
        "--distance",
        "0,15,-4",
        "--wall",
        "0,-30,-1,0,1,0",
        "--wall",
        "0,0,5,0,0,-1",
        "--wall",
        "0,0,5,0,0,1",
        "--design",
        "design.obj",
        "--output",
        "all.json",
    ]);
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[1].contains("3.0000 mm, outside, to X0.0000 Y0.0000 Z-5.0000; design -2.0000 mm"), "{text}");
    assert!(lines[1].contains("deviates by -5.0000 mm"), "{text}");
    assert!(lines[2].contains("-4.0000 mm, in material"), "{text}");
    assert!(lines[5].contains("no material ahead"), "{text}");
    let all = json("all.json");
    let number = |v: &serde_json::Value| v.as_f64().expect("a number");
    let wall = |k: usize, key: &str| number(&all["walls"][k][key]);
    assert!((wall(0, "thickness_mm") - 10.0).abs() < 1e-3 && (wall(0, "design_thickness_mm") - 40.0).abs() < 1e-9);
    assert!((wall(1, "thickness_mm") - 15.0).abs() < 1e-3, "below the slot");
    assert!(all["walls"][2]["thickness_mm"].is_null());
    assert!((number(&all["distances"][0]["distance_mm"]) - 3.0).abs() < 1e-3);
    // The patch measures with its own cells.
    let text = measured(&["result/stock-patch-edge.dexel", "--distance", "0,9.5,-2"]);
    assert!(text.contains("cells of 0.25") && text.contains("0.5000 mm, outside, to X0.0000 Y10.0000"), "{text}");
}

#[test]
fn wrong_questions_are_one_error_with_its_remedy() {
    let refused = |arguments: &[&str], words: &[&str]| {
        let output = proveout(shop(), &[&["measure"], arguments].concat());
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{printed}");
        for word in words {
            assert!(printed.contains(word), "{word:?} is not in:\n{printed}");
        }
        assert!(printed.matches("error: ").count() == 1 && !printed.contains("panicked"), "{printed}");
        printed.contains("help: ")
    };
    let helped = |arguments: &[&str], words: &[&str]| assert!(refused(arguments, words), "{arguments:?} has no remedy");
    helped(&["result"], &["no measurement requested", "--section z=12.5"]);
    helped(&["nowhere", "--section", "z=-1"], &["nowhere", "cannot be read", "run folder"]);
    helped(&["scene.toml", "--section", "z=-1"], &["not a stock file"]);
    helped(&["result", "--section", "z=9"], &["z=9 does not meet the stock", "-20.000 to 0.000"]);
    helped(&["result", "--section", "w=1"], &["w=1 is not a plane", "z=12.5"]);
    helped(&["result", "--section", "z=nan"], &["is not a plane"]);
    helped(&["result", "--distance", "1,2"], &["--distance 1,2 is not X,Y,Z", "3 numbers"]);
    helped(&["result", "--distance", "1,2,inf"], &["is not X,Y,Z"]);
    helped(&["result", "--wall", "1,2,3,0,0,0"], &["has no length"]);
    refused(&["result", "--distance", "1,2,3", "--design", "main.mpf"], &["main.mpf"]);
    helped(&["result", "--section", "z=-1", "--output", "a.dxf"], &["a.dxf", "unknown file extension", ".svg"]);
    helped(&["result", "--distance", "1,2,3", "--output", "a.svg"], &["only a section can be drawn"]);
    assert!(!shop().join("a.svg").exists());
}
