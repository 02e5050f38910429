//! Blades of every kind on the command line: their meshes, and what is refused.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use serde_json::Value;

/// A scene of the published experiment with another `[part]`.
fn scene(folder: &Path, part: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root");
    let path = |p: &str| format!("{:?}", root.join(p).display().to_string());
    let text = format!(
        "name = \"blade\"\nmachine = {}\ntools = {}\nresolution_mm = 2\n{part}\n[stock]\nbox = {{ min_mm = [-40, -40, -40], max_mm = [140, 60, 60] }}\n",
        path("machines/starrag-lx-451"),
        path("tools/li-2022.toml"),
    );
    fs::write(folder.join("scene.toml"), text).expect("written");
}

fn proveout(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_proveout"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

const ENDS: &str = "root = { x_mm = 1, platform = { fillet_radius_mm = 3, thickness_mm = 8, y_mm = [-30, 30], z_mm = [-30, 30] } }\n\
                    tip = { x_mm = 98 }\n";

#[test]
fn a_blade_of_every_kind_is_written_as_a_closed_mesh() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let folder = folder.path();
    for (kind, keys) in [
        ("lu", ENDS),
        ("lu-untwisted", ENDS),
        ("sine", "underside_mm = -5\n"),
        ("sine-gentle", "underside_mm = -5\n"),
        ("dong", "underside_mm = -5\n"),
        ("cui", ""),
    ] {
        scene(folder, &format!("[part.blade]\nkind = \"{kind}\"\nchord_error_mm = 0.05\n{keys}"));
        for name in ["part.stl", "part.glb"] {
            let arguments = ["blade", ".", "--output", name, "--allowance-mm", "0.2", "--force"];
            let output = proveout(folder, &arguments);
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success() && text.contains("as measured, 0.05 mm asked"), "{kind}: {text}");
            // Without the last word nothing is written over.
            let before = fs::read(folder.join(name)).expect("the file");
            let output = proveout(folder, &arguments[..6]);
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.code() == Some(2) && text.contains("already exists"), "{kind}: {text}");
            assert!(before == fs::read(folder.join(name)).expect("the file"), "{kind}");
        }
        let coarse = fs::metadata(folder.join("part.stl")).expect("the file").len();
        let output = proveout(folder, &["blade", ".", "--output", "part.stl", "--chord-error-mm", "0.01", "--force"]);
        assert!(output.status.success(), "{kind}: {}", String::from_utf8_lossy(&output.stderr));
        let fine = fs::metadata(folder.join("part.stl")).expect("the file").len();
        assert!(fine > coarse, "{kind}: {fine} {coarse}");
    }
}

/// Highest Z of an STL file, binary.
fn top(path: &Path) -> f64 {
    let bytes = fs::read(path).expect("the mesh");
    let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    let places = bytes[84..].chunks_exact(50).enumerate();
    let all = places.flat_map(|(k, _)| (1..4).map(move |corner| 84 + 50 * k + 12 * corner + 8));
    all.map(|at| f64::from(number(at))).fold(f64::NEG_INFINITY, f64::max)
}

/// A slab is milled flat across the part, a tenth of a millimeter above the highest place of the design, then
/// 0.2 mm below it.
#[test]
fn a_part_of_another_kind_is_cut_and_judged() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root");
    let ends = "root = { x_mm = 30 }\ntip = { x_mm = 60 }\n";
    for (kind, keys, against) in
        [("lu-untwisted", ends, "closed form of the blade"), ("sine-gentle", "underside_mm = -5\n", "mesh")]
    {
        let folder = tempfile::tempdir().expect("temporary folder");
        let folder = folder.path();
        fs::write(
            folder.join("tools.toml"),
            "[[tool]]\nnumber = 1\nname = \"END_D20\"\nkind = \"flat\"\ndiameter_mm = 20\nflute_length_mm = 30\n\
             center_cutting = true\ngauge_length_mm = 100\n",
        )
        .expect("written");
        let machine = root.join("machines/three-axis-mill").display().to_string();
        let text = format!(
            "name = \"blade\"\nmachine = {machine:?}\ntools = \"tools.toml\"\nresolution_mm = 0.5\n[part.blade]\nkind = \"{kind}\"\n\
             chord_error_mm = 0.01\n{keys}[stock]\nblade_allowance_mm = 0.5\n[mount]\ntranslation_mm = [0, 0, 100]\n\
             [work_offsets.G54]\nZ_mm = 100\n[tolerances]\ngouge_mm = 0.05\nexcess_mm = 1\n[[program]]\nname = \"main\"\nfile = \"main.nc\"\n"
        );
        fs::write(folder.join("scene.toml"), text).expect("written");
        let output = proveout(folder, &["blade", ".", "--output", "part.stl"]);
        assert!(output.status.success(), "{kind}: {}", String::from_utf8_lossy(&output.stderr));
        let top = top(&folder.join("part.stl"));
        for (height, gate) in [(0.1, "pass"), (-0.2, "fail")] {
            let z = top + height;
            let mut program =
                "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G43 H1\nS4000 M3\nG0 X-40. Y-60.\n".to_owned();
            program += &format!("G0 Z{:.3}\nG1 Z{z:.4} F2000\n", z + 10.0);
            for row in 0..10 {
                let x = -40 + 15 * row;
                let (from, to) = if row % 2 == 0 { (-60, 60) } else { (60, -60) };
                program += &format!("X{x}. Y{from}.\nY{to}.\n");
            }
            program += "G0 Z60.\nM5\nM30\n%\n";
            fs::write(folder.join("main.nc"), program).expect("written");
            let out = if height > 0.0 { "above" } else { "below" };
            let output = proveout(folder, &["run", ".", "--output", out]);
            let verdict = fs::read_to_string(folder.join(out).join("verdict.json"));
            let verdict = verdict.unwrap_or_else(|e| panic!("{kind} {e}: {}", String::from_utf8_lossy(&output.stderr)));
            let verdict: Value = serde_json::from_str(&verdict).expect("the verdict");
            let deviation = &verdict["deviation"];
            let error = |key: &str| deviation[key].as_f64().unwrap_or_else(|| panic!("{kind}: {deviation}"));
            let (measured, asked) = (error("mesh_error_mm"), error("mesh_asked_mm"));
            assert!(asked == 0.01 && measured > 0.001 && measured < asked, "{kind}: {deviation}");
            assert!(deviation["against"].as_str().is_some_and(|a| a.contains(against)), "{kind}: {deviation}");
            let gates = verdict["gates"].as_array().expect("gates");
            let gouge = gates.iter().find(|g| g["name"] == "gouge").expect("the gate");
            assert_eq!(gouge["state"], gate, "{kind}, {height}: {gouge}");
            let deepest = deviation["gouge_max_mm"].as_f64().unwrap_or_else(|| panic!("{kind}: {deviation}"));
            // The flat is 0.2 mm below the highest point of a mesh that lies within 0.01 mm of the design; on
            // a ray that loses all of a thin crest no point is deeper than half of it.
            let fits = if height > 0.0 { deepest < 0.015 } else { (deepest - 0.2).abs() < 0.011 };
            assert!(fits, "{kind}, {height}: {deepest}");
            let excess = deviation["excess_max_mm"].as_f64().unwrap_or_else(|| panic!("{kind}: {deviation}"));
            assert!(
                (excess - 0.5).abs() < 0.02,
                "{kind}, {height}: the allowance is left where nothing cuts, {excess}"
            );
        }
    }
}

#[test]
fn sections_of_a_file_are_skinned_and_faults_in_it_are_named() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let folder = folder.path();
    let ends = "root = { x_mm = 0 }\ntip = { x_mm = 30 }\n";
    scene(
        folder,
        &format!(
            "[part]\nsections = \"sections.csv\"\n[part.blade]\nkind = \"sections\"\nchord_error_mm = 0.05\n{ends}"
        ),
    );
    let sections = |last: f64| {
        let mut text = "section,x_mm,y_mm,z_mm\n".to_owned();
        for j in 0..4 {
            for k in 0..60 {
                let (s, c) = (f64::from(k) * std::f64::consts::TAU / 60.0).sin_cos();
                let x = if j == 3 { last } else { 10.0 * f64::from(j) };
                text += &format!("s{j},{x},{},{}\n", 20.0 * c, 5.0 * s);
            }
        }
        text
    };
    fs::write(folder.join("sections.csv"), sections(30.0)).expect("written");
    let output = proveout(folder, &["blade", ".", "--output", "part.stl"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines: Vec<String> = sections(30.0).lines().map(str::to_owned).collect();
    // Lines of the file by section, after its header.
    let changed = |change: &dyn Fn(&mut Vec<Vec<String>>)| {
        let mut all: Vec<Vec<String>> = lines[1..].chunks(60).map(<[String]>::to_vec).collect();
        change(&mut all);
        format!("{}\n{}\n", lines[0], all.concat().join("\n"))
    };
    for (text, words) in [
        (sections(15.0), "section s3 crosses s2 near point 1"),
        (changed(&|s| s[2].truncate(59)), "section s2 has 59 points, s0 has 60"),
        (changed(&|s| s[1].reverse()), "section s1 runs the other way round than s0"),
        (
            changed(&|s| s[3].rotate_left(20)),
            "section s3 begins at a different place than s2: its point 1 lies where s2 has point 21",
        ),
        (changed(&|s| s[2].swap(10, 20)), "section s2 crosses itself between points"),
        (changed(&|s| s[2][7] = s[2][6].clone()), "section s2, point 8: it lies on the point before it"),
        (changed(&|s| s.truncate(1)), "at least two"),
    ] {
        fs::write(folder.join("sections.csv"), text).expect("written");
        let output = proveout(folder, &["blade", ".", "--output", "other.stl"]);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{printed}");
        assert!(printed.contains(words) && printed.contains("sections.csv"), "{words}: {printed}");
        assert!(!folder.join("other.stl").exists(), "{words}: nothing is written");
    }
}

#[test]
fn keys_that_do_not_belong_to_a_kind_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let folder = folder.path();
    for (keys, words) in [
        ("kind = \"lu\"\nchord_error_mm = 0.05\n", "missing key `root` of a blade of kind \"lu\""),
        ("kind = \"dong\"\nchord_error_mm = 0.05\n", "missing key `underside_mm`"),
        ("kind = \"cui\"\nchord_error_mm = 0.05\nchord_mm = 60\n", "does not read `chord_mm`"),
        ("chord_error_mm = 0.05\n", "missing key `chord_mm` of a blade of kind \"camber\""),
        ("kind = \"wing\"\nchord_error_mm = 0.05\n", "wing"),
        (
            "kind = \"lu\"\nchord_error_mm = 0.05\nroot = { x_mm = -20 }\ntip = { x_mm = 98 }\n",
            "the blade does not reach its end at X = -20 mm",
        ),
    ] {
        scene(folder, &format!("[part.blade]\n{keys}"));
        let output = proveout(folder, &["blade", ".", "--output", "part.stl"]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && text.contains(words), "{words}: {text}");
        assert!(!folder.join("part.stl").exists());
    }
    scene(folder, "[part.blade]\nkind = \"cui\"\nchord_error_mm = 0.05\n");
    for (arguments, words) in [
        (["blade", ".", "--output", "part.step"].as_slice(), "use the extension .stl or .glb"),
        (&["blade", ".", "--output", "part.stl", "--allowance-mm=-1"], "is out of range"),
        (&["blade", ".", "--output", "part.stl", "--chord-error-mm", "2"], "is out of range"),
    ] {
        let output = proveout(folder, arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && text.contains(words), "{words}: {text}");
    }
}
