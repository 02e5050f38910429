//! `run --orientation-maps` as a person types it: a ball end mill on a flat face next to a wall. The wall
//! is parallel to the way at a distance that lets the shank lean against it by an angle in closed form.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;

const RADIUS: f64 = 4.0;
const SHANK: f64 = 3.0;
/// Length of tool over the ball's center: all of it is shank, so that no holder is met.
const LENGTH: f64 = 76.0;
/// Face of the wall, mm from the way, and its height over the floor: higher than the tool reaches.
const WALL: f64 = 30.0;
const CLEARANCE: f64 = 1.0;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// An L: floor up to z = 0, wall at y of 30 to 40 mm, 100 mm high; closed, counter-clockwise from outside.
fn corner() -> String {
    let outline = [[-40.0, -20.0], [40.0, -20.0], [40.0, 100.0], [WALL, 100.0], [WALL, 0.0], [-40.0, 0.0]];
    let n = outline.len();
    let point = |x: f64, [y, z]: [f64; 2]| format!("vertex {x} {y} {z}\n");
    let mut text = String::from("solid corner\n");
    let mut facet = |corners: [String; 3]| {
        text += &format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", corners.concat());
    };
    let (low, high) = (-50.0, 50.0);
    for k in 0..n {
        let (a, b) = (outline[k], outline[(k + 1) % n]);
        facet([point(low, a), point(low, b), point(high, b)]);
        facet([point(low, a), point(high, b), point(high, a)]);
    }
    // Both ends: the outline in four triangles.
    for [a, b, c] in [[0, 1, 4], [0, 4, 5], [1, 2, 4], [2, 3, 4]] {
        facet([point(high, outline[a]), point(high, outline[b]), point(high, outline[c])]);
        facet([point(low, outline[a]), point(low, outline[c]), point(low, outline[b])]);
    }
    text + "endsolid corner\n"
}

fn run(folder: &Path, tool: &str, options: &[&str]) -> (i32, String) {
    let scene = format!(
        "name = \"corner\"\nmachine = {:?}\ntools = \"tools.toml\"\nresolution_mm = 2\n\
         [stock.box]\nmin_mm = [-50, -40, -20]\nmax_mm = [50, 40, 0]\n[mount]\ntranslation_mm = [0, 0, 140]\n[part]\nmesh = \"corner.stl\"\n\
         [work_offsets.G54]\nZ_mm = 140\n[tolerances]\nnear_miss_mm = {CLEARANCE}\n\
         [[program]]\nname = \"main\"\nfile = \"main.nc\"\ndialect = \"fanuc\"\n",
        root().join("machines/three-axis-mill"),
    );
    let program = "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nG0 G43 H1 Z60.\nS8000 M3\nG0 X-20. Y0.\nZ5.\nG1 Z0. F500.\nX20.\nG0 Z60.\nM5\nM30\n";
    for (name, text) in [("scene.toml", &*scene), ("tools.toml", tool), ("main.nc", program), ("corner.stl", &corner())]
    {
        fs::write(folder.join(name), text).expect("written");
    }
    let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(["run", ".", "--output", "result", "--rerun", "off", "--threads", "2"])
        .args(options)
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code().unwrap_or(-1), said)
}

fn ball() -> String {
    format!(
        "[[tool]]\nnumber = 1\nname = \"B8\"\nkind = \"ball\"\ndiameter_mm = {}\nflute_length_mm = 10.0\nshank_diameter_mm = {}\n\
         overall_length_mm = {}\ngauge_length_mm = {}\nflutes = 2\n",
        2.0 * RADIUS,
        2.0 * SHANK,
        LENGTH + RADIUS,
        LENGTH + RADIUS,
    )
}

fn axes(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("result/free_axes.json")).expect("the file is there");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn an_axis_beside_a_wall_has_the_room_of_the_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, said) = run(folder.path(), &ball(), &["--orientation-maps", "7"]);
    let found = axes(folder.path());
    let places = found["places"].as_array().unwrap_or_else(|| panic!("{said}"));
    assert_eq!(places.len(), 7, "{said}");
    assert!(said.contains("free axes: 7 contact points of a ball end"), "{said}");
    // Leaned against the wall by t in the plane across the way, the corner of the shank's end is the
    // farthest: L sin t + r cos t = wall - clearance. To the other side the end of the tilts comes first.
    let limit = (0..90_000)
        .map(|k| f64::from(k) * 1e-3)
        .find(|t| {
            let (s, c) = t.to_radians().sin_cos();
            LENGTH * s + SHANK * c > WALL - CLEARANCE
        })
        .expect("a lean");
    let mut last = -1.0;
    for place in places {
        let number = |key: &str| place[key].as_f64().expect("a number");
        assert_eq!(place["state"], "free");
        assert!(number("tilt_deg").abs() < 1e-6 && number("time_s") > last);
        last = number("time_s");
        let normal: Vec<f64> = place["normal"].as_array().expect("three").iter().filter_map(Value::as_f64).collect();
        assert!(
            (normal[2] - 1.0).abs() < 1e-9 && place["point_mm"][2].as_f64().expect("z").abs() < 0.01,
            "{}",
            place["point_mm"]
        );
        // A cell of 2 degrees, half its diagonal and half a cell for the pieces of the wall: the border may
        // be reported early, never late.
        let room = number("room_deg");
        assert!(room <= limit + 1e-6 && room > limit - 4.5, "{room} {limit}");
        let cells = place["cells"].as_array().expect("cells");
        for cell in cells.iter().filter(|c| c[4] == "free") {
            let of = |k: usize| cell[k].as_f64().expect("degrees");
            // Straight towards the wall is 90 degrees from the feed along +x.
            let towards = of(2) <= 90.0 && of(3) >= 90.0;
            assert!(!towards || of(1) <= limit + 1e-6, "{cell} {limit}");
        }
        let away = |c: &&Value| c[2].as_f64().is_some_and(|y| y <= -90.0) && c[3].as_f64().is_some_and(|y| y >= -90.0);
        let free_away =
            cells.iter().filter(away).filter(|c| c[4] == "free").filter_map(|c| c[1].as_f64()).fold(0.0, f64::max);
        assert!(free_away > 70.0, "{free_away}");
    }
    let report = fs::read_to_string(folder.path().join("result/report.html")).expect("a report");
    assert_eq!(report.matches("class=\"axes-map\"").count(), 7);
    assert!(report.contains("Free tool axes") && report.contains("7 contact points of a ball end"));
}

#[test]
fn what_cannot_be_looked_at_is_named_and_none_is_written_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let flat = "[[tool]]\nnumber = 1\nname = \"F8\"\nkind = \"flat\"\ndiameter_mm = 8.0\nflute_length_mm = 10.0\noverall_length_mm = 80.0\n\
                gauge_length_mm = 80.0\nflutes = 2\n";
    let (_, said) = run(folder.path(), flat, &["--orientation-maps", "5"]);
    let found = axes(folder.path());
    assert_eq!(found["places"].as_array().map(Vec::len), Some(0), "{said}");
    assert!(said.contains("free axes: not checked: F8"), "{said}");
    assert!(found["unchecked"][0].as_str().is_some_and(|u| u.contains("F8") && u.contains("not a ball")), "{found}");
    let report = fs::read_to_string(folder.path().join("result/report.html")).expect("a report");
    assert!(report.contains("not checked") && report.contains("not a ball"));

    let folder = tempfile::tempdir().expect("a folder");
    run(folder.path(), &ball(), &[]);
    assert!(!folder.path().join("result/free_axes.json").exists());
    let (code, said) = run(folder.path(), &ball(), &["--orientation-maps", "0"]);
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("1..=2000"), "{said}");
}
