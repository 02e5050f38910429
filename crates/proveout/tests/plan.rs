//! Plans on the command line that do not fit: each is refused with its table, its section and its point, and
//! nothing is written.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

/// What is wrong with a plan.
struct Wrong {
    name: &'static str,
    part: &'static str,
    table: &'static str,
    /// Parts of the message.
    expected: &'static [&'static str],
}

const CAMBER: &str = "[part.blade]\nchord_mm = 60\ncamber_angle_deg = 60\nthickness_mm = 8\nleading_radius_mm = 1.6\ntrailing_radius_mm = 1.2\n\
                      length_mm = 25\ntwist_deg_per_mm = 0.1\nchord_error_mm = 0.05\n";
/// Fillets of 3 mm.
const LU: &str = "[part.blade]\nkind = \"lu\"\nchord_error_mm = 0.05\ntip = { x_mm = 98 }\n\
                  root = { x_mm = 1, platform = { fillet_radius_mm = 3, thickness_mm = 8, y_mm = [-30, 30], z_mm = [-30, 30] } }\n";

const WRONG: [Wrong; 6] = [
    Wrong {
        name: "a ball of 8 mm beside a fillet of 3 mm",
        part: LU,
        table: "[plan.transverse]\ntool = \"BALL_D16\"\nlines = [0.06]\nacross = [0.2, 0.3]\nchord_error_mm = 0.01\n\
                axis = { rule = \"fixed-head\", table = [1, 0, 0], lead_deg = 10 }\n",
        expected: &[
            "[plan.transverse]: a ball of R8.000 mm is too large for the fillet",
            "section 0.0600, point 0.2",
            "mm into it",
        ],
    },
    Wrong {
        name: "a ball of 400 mm in the concave side",
        part: CAMBER,
        table: "[plan.row]\ntool = \"LARGE\"\nat = 0.25\nalong = [0.2, 0.8]\nchord_error_mm = 0.01\n\
                axis = { rule = \"fixed-head\", table = [1, 0, 0], lead_deg = 10 }\n",
        expected: &["[plan.row]: the cutter is too large at section 0.", "point 0.2", "the hollow of the surface has"],
    },
    Wrong {
        name: "an axis out of the reach of the B head",
        part: CAMBER,
        table: "[plan.row]\ntool = \"BALL_D16\"\nat = 0.25\nalong = [0.2, 0.8]\nchord_error_mm = 0.01\n\
                axis = { rule = \"fixed-head\", table = [1, 0, 0], head_deg = 89 }\n",
        expected: &["[plan.row]: the machine cannot take the tool axis at section 0.2000, point 0.2", "B"],
    },
    Wrong {
        name: "an axis that points into the blade",
        part: CAMBER,
        table: "[plan.row]\ntool = \"BALL_D16\"\nat = 0.25\nalong = [0.2, 0.8]\nchord_error_mm = 0.01\n\
                axis = { rule = \"interpolated\", axes = [{ part = 0.0, direction = [0, -1, 0.2] }, { part = 1.0, direction = [0, -1, 0] }] }\n",
        expected: &["[plan.row]: the tool axis at section", "is tilted", "degrees from the outward normal"],
    },
    Wrong {
        name: "a step longer than the radius of an edge",
        part: CAMBER,
        table: "[plan.transverse]\ntool = \"BALL_D16\"\nlines = [0.5]\nstep_mm = 3\n\
                axis = { rule = \"fixed-head\", table = [1, 0, 0], lead_deg = 10 }\n",
        expected: &[
            "[plan.transverse]: the step of",
            "mm at section 0.5000, point 0.",
            "is longer than the radius of the path, 1.",
        ],
    },
    Wrong {
        name: "a flank on a side that is not ruled",
        part: CAMBER,
        table: "[plan.flank]\ntool = \"BALL_D16\"\nacross = [0.6, 0.9]\nalong = [0.0, 0.9]\nrulings = \"along\"\nflank_error_mm = 0.001\n\
                chord_error_mm = 0.01\naxis = { rule = \"ruling\" }\n",
        expected: &["[plan.flank]: the side is not ruled", "at section 0."],
    },
];

fn typed(folder: &Path, wrong: &Wrong) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root");
    let path = |p: &str| format!("{:?}", root.join(p).display().to_string());
    let ball = fs::read_to_string(root.join("tools/li-2022.toml")).expect("the library");
    let large = ball[ball.find("[[tool]]").expect("a tool")..]
        .replace("number = 1", "number = 2")
        .replace("\"BALL_D16\"", "\"LARGE\"")
        .replace("diameter_mm = 16.0\nflute_length_mm = 32.0", "diameter_mm = 400.0\nflute_length_mm = 250.0")
        .replace("overall_length_mm = 170.0", "overall_length_mm = 500.0")
        .replace("gauge_length_mm = 190.0", "gauge_length_mm = 520.0")
        .replace("shank_diameter_mm = 16.0", "shank_diameter_mm = 100.0");
    fs::write(folder.join("tools.toml"), ball + "\n" + &large).expect("written");
    let scene = format!(
        "name = \"wrong\"\nmachine = {}\ntools = \"tools.toml\"\nresolution_mm = 2\n{}\n[stock]\nblade_allowance_mm = 0.3\n\
         [mount]\ntranslation_mm = [260, 0, 0]\n[work_offsets.G54]\nX_mm = 260\n{}\
         spindle_rpm = 8000\nfeed_mm_min = 1000\nwork_offset = \"G54\"\ntolerance_mm = 0.01\nlift_mm = 2\nclearance_mm = 10\n",
        path("machines/starrag-lx-451"),
        wrong.part,
        wrong.table
    );
    fs::write(folder.join("scene.toml"), scene).expect("written");
    let strategy = wrong.table.split(['.', ']']).nth(1).expect("a table");
    Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(["plan", ".", "--strategy", strategy, "--output", "lines.mpf", "--report", "lines.json"])
        .output()
        .expect("the program starts")
}

#[test]
fn what_does_not_fit_is_refused_with_its_place_and_nothing_is_written() {
    for wrong in &WRONG {
        let folder = tempfile::tempdir().expect("a folder");
        let output = typed(folder.path(), wrong);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{}: {text}", wrong.name);
        for part in wrong.expected {
            assert!(text.contains(part), "{}: no {part:?} in {text}", wrong.name);
        }
        for file in ["lines.mpf", "lines.json"] {
            assert!(!folder.path().join(file).exists(), "{}: {file}", wrong.name);
        }
    }
}

fn strategy(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout")).arg("plan").args(words).output().expect("the program starts")
}

/// Planes at equal distances, with the axis of the table and with that of a program which the same table
/// writes: the files that lie in the scene.
#[test]
fn a_table_writes_both_programs_of_the_face_as_they_lie_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root");
    let scene = root.join("scenes/dong-2023-multi-scale");
    let folder = tempfile::tempdir().expect("a folder");
    let place = scene.display().to_string();
    for (program, file) in [("original", "original.mpf"), ("constant", "constant.mpf")] {
        let made = folder.path().join(file);
        let word = made.display().to_string();
        let output = strategy(&[&place, "--strategy", "iso-planar", "--program", program, "--output", &word]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(fs::read(&made).expect("written") == fs::read(scene.join(file)).expect("the program"), "{file}");
    }
    let never = folder.path().join("never.mpf").display().to_string();
    let output = strategy(&[&place, "--strategy", "iso-planar", "--program", "free-ends", "--output", &never]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.code() == Some(2)
            && text.contains("program \"free-ends\" of the scene is not planned by iso-planar"),
        "{text}"
    );
    assert!(!Path::new(&never).exists());
}

#[test]
fn distances_of_planes_that_are_none_are_refused_by_their_key() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root");
    let from = root.join("scenes/dong-2023-multi-scale");
    let text = fs::read_to_string(from.join("scene.toml")).expect("the scene");
    let library = |name: &str| format!("{:?}", root.join(name).display().to_string());
    let text = text
        .replace("\"../../machines/jdgr200t\"", &library("machines/jdgr200t"))
        .replace("\"../../tools/dong-2023.toml\"", &library("tools/dong-2023.toml"));
    // Written into the scene instead of a distance of 0.8 mm between 16 and 24 mm.
    for (lines, expected) in [
        ("across_mm = [16, 24]\nlines_apart_mm = 0", "lines_apart_mm = 0 between 16 and 24 mm makes"),
        ("across_mm = [16, 24]\nlines_apart_mm = -1", "lines_apart_mm = -1"),
        ("across_mm = [16, 16]\nlines_apart_mm = 0.8", "makes 0 distances"),
        ("across_mm = [16, 24]\nlines_apart_mm = 1e-9", "lines_apart_mm = 0.000000001"),
        ("lines_apart_mm = 0.8", "lines_apart_mm needs `across_mm`"),
        ("across_mm = [16, 24]\nlines_apart_mm = 0.8\nlines_mm = [16]", "give either lines_apart_mm or lines_mm"),
        ("across_mm = [16, 24]\nlines_apart_mm = 0.8\nscallop_mm = 0.01", "give either scallop_mm"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["original.mpf", "constant.mpf"] {
            fs::copy(from.join(name), folder.path().join(name)).expect("copied");
        }
        let wrong = text.replace("across_mm = [16, 24]\nlines_apart_mm = 0.8", lines);
        fs::write(folder.path().join("scene.toml"), wrong).expect("written");
        let (place, file) = (folder.path().display().to_string(), folder.path().join("never.mpf"));
        let output = strategy(&[&place, "--strategy", "iso-planar", "--output", &file.display().to_string()]);
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && words.contains(expected), "{lines}: {words}");
        assert!(!file.exists(), "{lines}");
    }
}
