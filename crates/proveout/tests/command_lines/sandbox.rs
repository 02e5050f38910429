//! A folder laid out as the project is, in which the commands of the pages are typed: machines and tools are
//! those of the project, scenes are the project's with coarser cells and the first blocks of their programs,
//! and what the pages name by `out/part-main` is a small part of its own. A command stays as the page has it,
//! word for word; what it reads is smaller.

use std::{
    fs,
    os::unix::fs::{PermissionsExt, symlink},
    path::{Path, PathBuf},
};

use proveout_calibrate::{LawKind, LawShape};
use tempfile::TempDir;

/// The root of the project.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

/// Slot of 12 mm, 5 mm deep, along X.
const MAIN: &str =
    "G17 G54 G90 G94 G710\nT=\"SCHAFT_D12_N_AP30\"\nM6\nG0 X-40 Y0 Z50 S1000 M3 D1\nG0 Z15\nG1 X40 F600\nG0 Z50\nM30\n";
const FANUC: &str =
    "%\nO0001\nG21 G90 G17 G54\nT2 M6\nG0 G43 H2 X-40. Y0. Z50. S1000 M3\nG1 Z15. F600.\nX40.\nG0 Z50.\nM30\n%\n";

const SCENE: &str = r#"name = "part"
machine = "../machines/spinner-u5-620"
tools = "../tools/axis-cross.toml"
resolution_mm = 1.0

[stock]
box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 20] }

[[stock.patch]]
name = "letters-x"
min_mm = [-3, 5, 12]
max_mm = [3, 8, 21]
cell_mm = 0.25

[mount]
translation_mm = [0, 0, 160]

[work_offsets.G54]
Z_mm = 160

[[program]]
name = "main"
file = "main.mpf"

[[program]]
name = "other"
file = "other.mpf"
"#;

const PRIVATE_KEY: &str = "-----BEGIN PRIVATE KEY-----\nMC4CAQAwBQYDK2VwBCIEIJ1hsZ3v/VpguoRK9JLsLMREScVpezJpGXA7rAMcrn9g\n\
                           -----END PRIVATE KEY-----\n";
const PUBLIC_KEY: &str = "-----BEGIN PUBLIC KEY-----\nMCowBQYDK2VwAyEA11qYAYKxCrfVS/7TyWQHOg7hcvPapiMlrwIaaPcHURo=\n\
                          -----END PUBLIC KEY-----\n";

/// A published value that the comparison misses.
const MISSED: &str = r#"
[compare]
baseline = "main"

[[compare.published]]
name = "time saved"
program = "other"
against = "main"
quantity = "cutting-time"
value = 60
band = [55, 65]
source = "made up: two thirds of the time would be saved at three times the feed"
"#;

/// A scene with keys that have another name today.
const BEFORE: &str = r#"name = "before"
machine = "../machines/spinner-u5-620"
tools = "../tools/axis-cross.toml"
resolution_mm = 1.0

[mount]
translation_mm = [0, 0, 160]
chosen = true # as high as the spindle reaches

[limits]
blocks = 1000
"#;

/// A small block on a mill whose machine file is its own.
const MILL: &str = r#"name = "mill"
machine = "machine.toml"
tools = "../tools/axis-cross.toml"
resolution_mm = 5

[stock]
box = { min_mm = [-20, -20, 0], max_mm = [20, 20, 20] }
"#;

/// Set points of X every 2 ms: six lengths there and back, a little faster than the mill is described.
fn air() -> String {
    let shape = LawShape { kind: LawKind::JerkLimited, velocity: 620.0, shape: [5200.0, 97_000.0] };
    let mut text = String::from("time_s,X_command_mm\n");
    let (mut row, mut at) = (0, -300.0);
    for length in [600.0, 240.0, 90.0, 30.0, 9.0, 2.4] {
        for way in [length, -length] {
            let law = shape.law(way);
            let rows = ((law.duration + 0.4) / 0.002).ceil() as i32;
            for k in 0..rows {
                // Moves begin between two rows.
                let x = at + law.position(0.002 * f64::from(k) - 0.1007);
                text += &format!("{:.3},{x:.4}\n", 0.002 * f64::from(row + k));
            }
            (row, at) = (row + rows, at + way);
        }
    }
    text
}

/// Makes the folder.
pub(crate) fn sandbox() -> TempDir {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (root, to) = (root(), folder.path());
    for name in ["machines", "tools", "materials"] {
        symlink(root.join(name), to.join(name)).expect("a link");
    }
    fs::create_dir(to.join("tests")).expect("made");
    for name in ["tests/first-part", "tests/own-machine", "tests/job", "tests/sweep", "tests/feeds"] {
        symlink(root.join(name), to.join(name)).expect("a link");
    }
    for name in ["out", "part", "bin", "scenes", "before", "mill"] {
        fs::create_dir(to.join(name)).expect("made");
    }
    let write = |name: &str, text: &str| fs::write(to.join(name), text).expect("written");
    write("part/scene.toml", SCENE);
    write("part/missed.toml", &(SCENE.to_owned() + MISSED));
    write("part/main.mpf", MAIN);
    write("part/other.mpf", &MAIN.replace("F600", "F900"));
    write("part/fanuc.nc", FANUC);
    write("shop.nc", SHOP);
    write("shop.toml", SHOP_CONTROL);
    write("broken.toml", "inherits = \"fanuc-30i\"\n[words]\nM25 = { does = \"M333\" }\n");
    // The production program that `--nc` wants is published elsewhere.
    let stand_in = MAIN.replace("Y0", "Y25").replace("X-40", "X-70").replace("Z15", "Z-2");
    for name in ["stand-in.mpf", "Coordinate_system_representation_Achskreuz.mpf"] {
        write(name, &stand_in);
    }
    write("before/scene.toml", BEFORE);
    let mill = fs::read_to_string(root.join("machines/three-axis-mill/machine.toml")).expect("a machine");
    // Joints, spindle, table and control: without bodies it names no model, and may be written anywhere.
    let mill = mill.replace("model = \"model.glb\"\n", "");
    write("mill/machine.toml", mill.split_once("[body_density]").map_or(mill.as_str(), |(head, _)| head));
    write("mill/scene.toml", MILL);
    write("air.csv", &air());
    write("columns.toml", "time = \"time_s\"\n\n[[joint]]\nname = \"X\"\nunit = \"mm\"\ncommand = \"X_command_mm\"\n");
    write("backwards.csv", "time_s,X_command_mm\n0.001,0\n0.000,0\n");
    write("before/tools.toml", "[[tool]]\nnumber = 1\ngauge_length_is = \"measured\"\n");
    write("part.stl", &block());
    write("joints.csv", "label,X_mm,Y_mm,Z_mm,B_deg,A_deg\nhome,0,0,300,0,0\ntilted,10,20,300,5,-90\n");
    write("poses.csv", "x_mm,y_mm,z_mm,i,j,k\n0,0,300,0,0,1\n10,20,30,0,0.6,0.8\n");
    write("gauge.smd", &gauge());
    write("damaged.smd", &gauge().replacen("\r\n0.5", "\r\nhigh", 1));
    write("patch.sdf", &patch());
    // The first key of RFC 8032.
    write("key.pem", PRIVATE_KEY);
    write("public.pem", PUBLIC_KEY);
    // In place of the viewer.
    write(
        "bin/rerun",
        "#!/bin/sh\nif [ \"$1\" = --version ]; then echo \"rerun-cli 0.36.3\"; else echo \"the viewer opens $1\"; fi\n",
    );
    fs::set_permissions(to.join("bin/rerun"), fs::Permissions::from_mode(0o755)).expect("executable");
    for name in [
        "cone-frustum",
        "li-2022-s-theta",
        "axis-cross",
        "face-mill-marks",
        "planned-blade",
        "blade-root",
        "dong-2023-multi-scale",
        "lu-2022-quasi-circle",
    ] {
        smaller(&root.join("scenes").join(name), &to.join("scenes").join(name));
    }
    folder
}

/// A scene with coarser cells and the first blocks of its programs.
fn smaller(from: &Path, to: &Path) {
    fs::create_dir(to).expect("made");
    for file in fs::read_dir(from).expect("a scene").map(|e| e.expect("an entry").path()) {
        let name = file.file_name().expect("a name").to_string_lossy().into_owned();
        let Ok(text) = fs::read_to_string(&file) else { continue };
        let text = match name.as_str() {
            "scene.toml" | "finish.toml" | "methods.toml" => changed(
                &text,
                &[
                    ("resolution_mm = 0.5", "resolution_mm = 2"),
                    ("resolution_mm = 0.25", "resolution_mm = 1"),
                    ("resolution_mm = 0.2", "resolution_mm = 2"),
                    ("step_um = 10", "step_um = 100"),
                    // The bar of the cone frustum without what its first blocks do not reach.
                    (
                        "base_mm = [0, 0, -80], radius_mm = 50, height_mm = 80",
                        "base_mm = [0, 0, -14], radius_mm = 50, height_mm = 14",
                    ),
                    // The first turns of the blade; the program ends on it.
                    ("min_mm = [13.5, -200, -200]", "min_mm = [12.6, -200, -200]"),
                    ("max_mm = [16.5, 200, 200]", "max_mm = [12.9, 200, 200]"),
                    ("plot_window_s = [22, 34]", "plot_window_s = [2, 8]"),
                    ("size_mm = [3, 2.4]", "size_mm = [0.6, 0.6]"),
                    ("chord_error_mm = 0.001\nroot", "chord_error_mm = 0.02\nroot"),
                    // A few lines of the blade between platforms.
                    ("scallop_mm = 0.100", "scallop_mm = 0.3"),
                    ("scallop_mm = 0.010", "scallop_mm = 0.1"),
                    ("along = [0.3, 0.7]", "along = [0.43, 0.53]"),
                    ("along = [0.31, 0.69]", "along = [0.45, 0.51]"),
                    ("min_mm = [14, -40, -40]", "min_mm = [24.2, -40, -40]"),
                    ("max_mm = [40, 40, 40]", "max_mm = [26.8, 40, 40]"),
                ],
            ),
            "bc.mpf" | "ac.mpf" => first_blocks(&text, 72),
            // One line round the blade.
            "original.mpf" if to.ends_with("blade-root") => first_blocks(&text, 314),
            "original.mpf" => first_blocks(&text, 17 + 570),
            _ => text,
        };
        fs::write(to.join(name), text).expect("written");
    }
}

fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// The lines to this one, and the end of the program from where its transformation is switched off.
fn first_blocks(text: &str, lines: usize) -> String {
    let all: Vec<&str> = text.lines().collect();
    let tail = all.iter().rposition(|l| l.contains("TRAFOOF")).expect("an end");
    assert!(lines < tail, "the program is shorter than what is kept of it");
    all[..lines].iter().chain(&all[tail..]).map(|l| format!("{l}\n")).collect()
}

/// A softgauge: ridges of 1 um every 0.05 mm over 0.6 mm, points every 0.5 um.
fn gauge() -> String {
    let mut text =
        String::from("ISO 5436 - 2000\0gauge\r\nPRF\x000\0ridges\r\nCX\0I\x001201\0mm\x001.0E+000\0D\x005.0E-004\r\n");
    text += "CZ\0A\x001201\0um\x001.0E+000\0D\r\n\x03\r\nDATE\x0022-11-2026\r\n\x03\r\n";
    for i in 0..=1200 {
        let u = f64::from(i % 100) / 100.0 - 0.5;
        text += &format!("{}\r\n", 4.0 * u * u);
    }
    text += "\x03\r\n";
    let sum: u64 = text.bytes().map(u64::from).sum();
    text + &format!("{}\r\n\x03\x1a", sum % 65_535)
}

/// A height map of 2 x 1.6 mm every 20 um: ridges of 2 um along y every 0.4 mm, on a tilt.
fn patch() -> String {
    let mut text = String::from(
        "aISO-1.0\r\nManufacID = made\r\nCreateDate = 221120261200\r\nModDate = 221120261200\r\nNumPoints = 101\r\n",
    );
    text += "NumProfiles = 81\r\nXscale = 2e-5\r\nYscale = 2e-5\r\nZscale = 1e-6\r\nZresolution = -1\r\nCompression = 0\r\n";
    text += "DataType = 7\r\nCheckType = 0\r\n*\r\n";
    for j in 0..81 {
        for i in 0..101 {
            let u = f64::from(i % 20) / 20.0 - 0.5;
            text += &format!("{} ", 8.0 * u * u + 0.1 * f64::from(i) - 0.05 * f64::from(j));
        }
        text += "\r\n";
    }
    text + "*\r\n*\r\n"
}

/// A block of 40 mm edges as STL text.
fn block() -> String {
    let corner = |k: usize| [0, 1, 2].map(|bit| if k >> bit & 1 == 1 { 20 } else { -20 });
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

/// A program with words of its machine.
const SHOP: &str =
    "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nS1000 M13\nG0 X#500 Y0.\nG1 X10. M25\nG2 X0. Y10.05 R10.\nM25\nM30\n%\n";
/// What they mean.
const SHOP_CONTROL: &str =
    "name = \"Mill 7\"\ninherits = \"fanuc-30i\"\n\n[words]\nM13 = { does = \"M3 M8\" }\nM25 = { ignore = \"vise\" }\n";
