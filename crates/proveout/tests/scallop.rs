//! `[tolerances] scallop_um` as a person types it: a block milled row by row with a ball, on the command
//! line.
//!
//! Rows of a ball of 3 mm every 0.5 mm leave 3 - sqrt(9 - 0.25^2) = 10.4348 micrometers between them.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;

const TOOLS: &str = "[[tool]]\nnumber = 1\nname = \"B6\"\nkind = \"ball\"\ndiameter_mm = 6.0\nflute_length_mm = 25.0\n\
                     shank_diameter_mm = 6.0\noverall_length_mm = 140.0\ngauge_length_mm = 140.0\nflutes = 2\n";
/// Step of the rows, mm.
const STEP: f64 = 0.5;
/// Height of the finished face, mm.
const FACE: f64 = 9.0;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// A folder with scene, program, tools and part; `wide` is a step that is doubled somewhere, `tolerances` and
/// `part` are lines of the scene.
fn write(folder: &Path, wide: bool, tolerances: &str, part: &str) {
    let scene = format!(
        "name = \"rows\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = 0.2\n[stock]\n\
         box = {{ min_mm = [0, 0, 0], max_mm = [20, 12, 10] }}\n{part}[mount]\ntranslation_mm = [-10, -6, 40]\n\
         [work_offsets.G54]\nX_mm = -10\nY_mm = -6\nZ_mm = 40\n[tolerances]\ngouge_mm = 0.05\nexcess_mm = 0.1\n{tolerances}\
         [[program]]\nname = \"main\"\nfile = \"main.nc\"\ndialect = \"fanuc\"\n",
        root().join("machines/three-axis-mill"),
    );
    let mut program =
        format!("G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z30.\nS8000 M3\nG0 X-6. Y-2.\nZ{FACE:.3}\n");
    let rows = (16.0 / STEP) as usize;
    let mut forth = true;
    for row in 0..=rows {
        let y = -2.0 + STEP * row as f64;
        if wide && (y - 6.0).abs() < 1e-9 {
            continue;
        }
        let (from, to) = if forth { (-6.0, 26.0) } else { (26.0, -6.0) };
        forth = !forth;
        writeln!(program, "G1 X{from:.4} Y{y:.4} F3000.\nX{to:.4}").expect("a text");
    }
    program += "G0 Z30.\nM5\nM30\n";
    let mut obj = String::new();
    for k in 0..8 {
        let at = |bit: usize, high: f64| if k >> bit & 1 == 1 { high } else { 0.0 };
        writeln!(obj, "v {} {} {}", at(0, 20.0), at(1, 12.0), at(2, FACE)).expect("a text");
    }
    for f in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
        writeln!(obj, "f {f}").expect("a text");
    }
    for (name, text) in [("scene.toml", &scene), ("main.nc", &program), ("part.obj", &obj)] {
        fs::write(folder.join(name), text).expect("written");
    }
    fs::write(folder.join("tools.toml"), TOOLS).expect("written");
}

const PART: &str = "[part]\nmesh = \"part.obj\"\njudged_box = { min_mm = [4, 3, 8], max_mm = [16, 9, 10] }\n";

/// Exit code, verdict where there is one, and output.
fn run(wide: bool, tolerances: &str, part: &str) -> (i32, Option<Value>, String) {
    let folder = tempfile::tempdir().expect("temporary folder");
    write(folder.path(), wide, tolerances, part);
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder.path())
        .args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "2"])
        .output()
        .expect("the program starts");
    let printed = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let verdict = fs::read_to_string(folder.path().join("result/verdict.json")).ok();
    (output.status.code().expect("an end"), verdict.map(|v| serde_json::from_str(&v).expect("JSON")), printed)
}

fn gate(verdict: &Value) -> (String, String) {
    let gates = verdict["gates"].as_array().expect("gates");
    let gate = gates.iter().find(|g| g["name"] == "surface").expect("the gate");
    (gate["state"].as_str().expect("a state").into(), gate["reason"].as_str().expect("a reason").into())
}

#[test]
fn rows_within_the_tolerance_pass() {
    let (code, verdict, output) = run(false, "scallop_um = 11\n", PART);
    let verdict = verdict.unwrap_or_else(|| panic!("no verdict:\n{output}"));
    let (state, reason) = gate(&verdict);
    assert_eq!(state, "pass", "{reason}");
    let surface = &verdict["surface"];
    let exact = 1e3 * (3.0 - (9.0 - 0.0625_f64).sqrt());
    for key in ["scallop_mean_um", "scallop_p95_um", "scallop_max_um"] {
        let value = surface[key].as_f64().expect(key);
        assert!((value - exact).abs() < 1e-4, "{key}: {value}, exact {exact}");
    }
    let figures = &surface["scallop"];
    assert!((figures["geometric_mean_um"].as_f64().expect("geometry") - exact).abs() < 1e-6);
    assert!((figures["spacing_mean_mm"].as_f64().expect("spacing") - STEP).abs() < 1e-6);
    // 11 micrometers above a plane: 2 sqrt(2 R h - h^2).
    let width = 2.0 * (2.0 * 3.0 * 0.011 - 0.011 * 0.011_f64).sqrt();
    assert!((figures["swept_width_min_mm"].as_f64().expect("a width") - width).abs() < 1e-9);
    // Twelve ridges of 12 mm in the judged box of 12 x 6 mm.
    let length = figures["all"]["length_mm"].as_f64().expect("a length");
    assert!((length - 144.0).abs() < 4.0, "{length}");
    let passes = figures["pass_count"].as_u64().expect("passes");
    assert!((12..=13).contains(&passes), "{passes}");
    // All gates that this scene can check have passed, whatever the others say of it.
    assert_ne!(code, 2, "{output}");
}

#[test]
fn one_row_that_is_missing_fails_at_its_place() {
    // Without the row at Y 6 one of eleven ridges is 42 micrometers high: more than 5 percent of the length.
    let (code, verdict, output) = run(true, "scallop_um = 11\n", PART);
    let verdict = verdict.unwrap_or_else(|| panic!("no verdict:\n{output}"));
    let (state, reason) = gate(&verdict);
    assert_eq!((state.as_str(), code), ("fail", 1), "{reason}");
    let finding = verdict["findings"].as_array().expect("findings").iter().find(|f| f["code"] == "surface-scallop");
    let finding = finding.expect("the finding");
    let high = 1e3 * (3.0 - (9.0 - 0.25_f64).sqrt());
    assert!((finding["value"].as_f64().expect("a value") - high).abs() < 1e-3, "{finding}");
    let point = finding["point_mm"].as_array().expect("a place");
    assert!((point[1].as_f64().expect("y") - 6.0).abs() < 1e-3, "{finding}");
    // Rows begin in line 8, two lines each: the ridge is that of the rows at Y 5.5 and 6.5.
    assert!(reason.contains("main.nc:39") && reason.contains("main.nc:41"), "{reason}");
    // The mean hardly shows it.
    let surface = &verdict["surface"];
    assert!(surface["scallop_mean_um"].as_f64().expect("a mean") < 14.0);
}

#[test]
fn regions_have_bounds_of_their_own() {
    let region = |name: &str, x: [f64; 2], limit: f64| {
        format!(
            "[[tolerances.region]]\nname = {name:?}\nmin_mm = [{}, -100, 0]\nmax_mm = [{}, 100, 20]\nscallop_um = {limit}\n",
            x[0], x[1]
        )
    };
    let judged = |tolerances: &str| {
        let (code, verdict, output) = run(false, tolerances, PART);
        let verdict = verdict.unwrap_or_else(|| panic!("no verdict:\n{output}"));
        (code, gate(&verdict), verdict)
    };
    // 10.43 micrometers everywhere: the land allows 9, the rest 11.
    let (code, (state, reason), verdict) = judged(&format!("scallop_um = 11\n{}", region("land", [0.0, 8.0], 9.0)));
    assert_eq!((code, state.as_str()), (1, "fail"), "{reason}");
    assert!(reason.contains("region \"land\": 95th percentile 10.43") && reason.contains("elsewhere: "), "{reason}");
    let finding = verdict["findings"].as_array().expect("findings").iter().find(|f| f["code"] == "surface-scallop");
    assert_eq!(finding.expect("the finding")["limit"], 9.0);
    let regions = verdict["surface"]["scallop"]["regions"].as_array().expect("regions").clone();
    let length = |k: usize| regions[k]["heights"]["length_mm"].as_f64().expect("a length");
    assert_eq!((regions.len(), &regions[0]["name"], &regions[1]["name"]), (2, &Value::Null, &"land".into()));
    // X 4 to 8 of X 4 to 16.
    assert!((length(1) / (length(0) + length(1)) - 1.0 / 3.0).abs() < 0.03, "{regions:?}");
    // A looser region forgives what the rest would not.
    let loose = format!("scallop_um = 9\n{}", region("free", [0.0, 30.0], 30.0));
    assert_eq!(judged(&loose).1.0, "pass", "the region covers all that is judged");
    // A bound of a region alone is asked for, and must find something.
    let beside = region("beside", [40.0, 50.0], 9.0);
    let (_, (state, reason), _) = judged(&beside);
    assert_eq!(state, "unchecked", "{reason}");
    assert!(reason.contains("region \"beside\": no ridge between two passes was found there"), "{reason}");
}

#[test]
fn the_map_has_measured_and_geometric_heights_and_the_page_shows_them() {
    let folder = tempfile::tempdir().expect("temporary folder");
    write(folder.path(), false, "scallop_um = 11\n", PART);
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder.path())
        .args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "2"])
        .output()
        .expect("the program starts");
    assert_ne!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    let page = fs::read_to_string(folder.path().join("result/report.html")).expect("the page");
    let section = page.split("<section id=\"scallop\">").nth(1).expect("a section on the scallop");
    let section = section.split("</section>").next().expect("its end");
    for words in ["95th percentile of the height", "10.43", "Worst patches", "main.nc:", "Passes"] {
        assert!(section.contains(words), "{words} in {section}");
    }
    let file = fs::File::open(folder.path().join("result/surface.parquet")).expect("the table");
    let batches = parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder::try_new(file)
        .expect("parquet")
        .build()
        .expect("batches");
    let mut seen = 0;
    for batch in batches {
        let batch = batch.expect("a batch");
        let column = |name: &str| {
            let column = batch.column_by_name(name).unwrap_or_else(|| panic!("{name}"));
            column.as_any().downcast_ref::<arrow_array::Float64Array>().expect("numbers").clone()
        };
        let [measured, geometric, difference] =
            ["scallop_mm", "scallop_geometric_mm", "scallop_difference_mm"].map(column);
        for i in 0..batch.num_rows() {
            use arrow_array::Array;
            if measured.is_null(i) || geometric.is_null(i) {
                assert!(difference.is_null(i));
                continue;
            }
            seen += 1;
            let high = 3.0 - (9.0 - 0.25_f64.powi(2)).sqrt();
            assert!((geometric.value(i) - high).abs() < 1e-6, "{}", geometric.value(i));
            assert!((measured.value(i) - geometric.value(i) - difference.value(i)).abs() < 1e-12);
        }
    }
    assert!(seen > 1000, "{seen} points beside ridges");
}

#[test]
fn a_limit_within_the_error_of_the_design_is_unchecked() {
    let part = PART.replace("part.obj\"\n", "part.obj\"\nchord_error_mm = 0.001\n");
    let (_, verdict, output) = run(false, "scallop_um = 11\n", &part);
    let (state, reason) = gate(&verdict.unwrap_or_else(|| panic!("no verdict:\n{output}")));
    assert_eq!(state, "unchecked", "{reason}");
    assert!(reason.contains("the limit lies within the error"), "{reason}");
    let (_, verdict, _) = run(false, "scallop_um = 9\n", &part);
    assert_eq!(gate(&verdict.expect("a verdict")).0, "fail", "beyond the error it is surely too high");
}

#[test]
fn a_scene_that_asks_for_nothing_gets_no_report() {
    let (_, verdict, output) = run(false, "", PART);
    let verdict = verdict.unwrap_or_else(|| panic!("no verdict:\n{output}"));
    assert_eq!(
        gate(&verdict),
        ("not_asked".into(), "the scene has no tolerance of the surface (scallop_um, ra_um, rz_um)".into())
    );
    assert!(verdict["surface"]["scallop"].is_null() && verdict["surface"]["scallop_p95_um"].is_null());
}

#[test]
fn rows_nearer_than_two_cells_are_not_passed() {
    let coarse = "scallop_um = 11\n";
    let folder = tempfile::tempdir().expect("temporary folder");
    write(folder.path(), false, coarse, PART);
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder.path())
        .args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "2", "--resolution-mm", "0.4"])
        .output()
        .expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stderr);
    let text =
        fs::read_to_string(folder.path().join("result/verdict.json")).unwrap_or_else(|e| panic!("{e}\n{printed}"));
    let (state, reason) = gate(&serde_json::from_str(&text).expect("JSON"));
    assert_eq!(state, "unchecked", "{reason}");
    assert!(reason.contains("closer to their neighbor than two cells"), "{reason}");
}

#[test]
fn a_height_that_is_none_or_has_no_design_is_refused_by_name() {
    for (tolerances, part, words) in [
        ("scallop_um = -1\n", PART, "scallop_um = -1 is not a height"),
        ("scallop_um = 0\n", PART, "scallop_um = 0 is not a height"),
        ("scallop_um = nan\n", PART, "`tolerances.scallop_um` = nan: is out of range"),
        ("scallop_um = 11\n", "", "scallop_um needs a design"),
        (
            "[[tolerances.region]]\nname = \"land\"\nmin_mm = [0, 0, 0]\nmax_mm = [1, 1, 1]\n",
            PART,
            "region \"land\" sets no bound",
        ),
    ] {
        let (code, verdict, output) = run(false, tolerances, part);
        assert_eq!(code, 2, "{output}");
        assert!(verdict.is_none() && output.contains(words) && output.contains("scene.toml:"), "{output}");
    }
}

/// A dip of the ball to 0.21 mm between rays 0.4 mm apart: the finding names the deepest place, not that of
/// the nearest ray (which is up to 0.2^2 / 3 = 13 micrometers higher).
#[test]
fn a_gouge_between_the_rays_has_its_whole_depth() {
    let folder = tempfile::tempdir().expect("temporary folder");
    write(folder.path(), false, "", PART);
    let program = fs::read_to_string(folder.path().join("main.nc")).expect("the program");
    let dip = "G0 Z12.\nX8.03 Y6.07\nG1 Z8.79 F500.\nX11.1 Y6.21 Z8.83\nZ12.\nG0 Z30.\nM5\n";
    fs::write(folder.path().join("main.nc"), program.replace("G0 Z30.\nM5\n", dip)).expect("written");
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder.path())
        .args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "2"])
        .args(["--resolution-mm", "0.4", "--dynamics", "ideal"])
        .output()
        .expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stderr);
    let text =
        fs::read_to_string(folder.path().join("result/verdict.json")).unwrap_or_else(|e| panic!("{e}\n{printed}"));
    let verdict: Value = serde_json::from_str(&text).expect("JSON");
    let gouges: Vec<&Value> =
        verdict["findings"].as_array().expect("findings").iter().filter(|f| f["code"] == "geometry-gouge").collect();
    assert_eq!(gouges.len(), 1, "{gouges:?}");
    let depth = gouges[0]["value"].as_f64().expect("a depth");
    assert!((depth - 0.21).abs() < 1e-5, "{depth}");
    assert_eq!(verdict["deviation"]["gouge_max_mm"].as_f64(), Some(depth));
    let point = gouges[0]["point_mm"].as_array().expect("a place");
    let at = [point[0].as_f64().expect("x"), point[1].as_f64().expect("y")];
    assert!((at[0] - 8.03).abs() < 0.01 && (at[1] - 6.07).abs() < 0.01, "{at:?}");
}
