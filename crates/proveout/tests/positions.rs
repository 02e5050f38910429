//! Where positions come from, as a user meets it: reference points of the machine, work offsets of a machine
//! whose axes are zero at home, retractions under tool center point control, words that switch kinematics.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;
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

/// A scene in a temporary folder: a small block on the machine, a program, a work offset.
struct Shop {
    folder: TempDir,
}

impl Shop {
    fn new(machine: &Path, program: (&str, &str), offset: [f64; 3]) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let shop = Self { folder };
        let tools = root().join("tools/cone-frustum.toml");
        shop.write(
            "scene.toml",
            &format!(
                "name = \"small\"\nmachine = {:?}\ntools = {:?}\nresolution_mm = 4\n[stock]\n\
                 box = {{ min_mm = [0, 0, -20], max_mm = [40, 40, 0] }}\n[mount]\ntranslation_mm = [-50, -50, 140]\n\
                 [work_offsets.G54]\nX_mm = {}\nY_mm = {}\nZ_mm = {}\n[[program]]\nname = \"main\"\nfile = {:?}\n",
                machine.display().to_string(),
                tools.display().to_string(),
                offset[0],
                offset[1],
                offset[2],
                program.0
            ),
        );
        shop.write(program.0, program.1);
        shop
    }

    fn on(machine: &str, program: (&str, &str), offset: [f64; 3]) -> Self {
        Self::new(&root().join("machines").join(machine), program, offset)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.folder.path().join(name), text).expect("written");
    }

    fn run(&self) -> Output {
        proveout(self.folder.path(), &["run", ".", "--output", "result", "--rerun", "off"])
    }

    /// The verdict of a run that was not refused.
    fn verdict(&self) -> Value {
        let output = self.run();
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_ne!(output.status.code(), Some(2), "{printed}");
        let text = fs::read_to_string(self.folder.path().join("result/verdict.json")).expect("written");
        serde_json::from_str(&text).expect("JSON")
    }

    /// Asserts that the program is refused with all of these words and that nothing is written.
    fn refused(&self, words: &[&str]) {
        let output = self.run();
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{printed}");
        // Long texts are wrapped for the terminal.
        let flat = printed.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ");
        for word in words {
            assert!(flat.contains(word), "{word:?} is not in:\n{printed}");
        }
        assert!(!self.folder.path().join("result").exists());
    }
}

fn codes(verdict: &Value) -> Vec<String> {
    let findings = verdict["findings"].as_array().expect("a list");
    findings.iter().map(|f| f["code"].as_str().expect("a code").to_owned()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn gate<'v>(verdict: &'v Value, name: &str) -> &'v Value {
    let gates = verdict["gates"].as_array().expect("a list");
    gates.iter().find(|g| g["name"] == name).expect("the gate")
}

/// Machine zero lies outside of the travel of all but the last two.
#[test]
fn g28_goes_to_the_home_position_of_the_machine() {
    for (machine, home) in [
        ("three-axis-mill", 610.0),
        ("fork-head-gantry", 1100.0),
        ("spinner-u5-620", 610.0),
        ("linuxcnc-xyzac-trt", 120.0),
        ("bc-trunnion-home-zero", 0.0),
    ] {
        let below = home - 30.0;
        let text = format!("%\nO1\nG21 G90 G17\nT1 M6\nG53 G0 Z{below:.1}\nG91 G28 Z0.\nG90\nM30\n%\n");
        let verdict = Shop::on(machine, ("part.nc", &text), [0.0; 3]).verdict();
        let z = &verdict["axes"]["Z"];
        assert!((number(&z["max"]) - home).abs() < 1e-6 && (number(&z["min"]) - below).abs() < 1e-6, "{machine}: {z}");
        assert!(!codes(&verdict).contains(&"limits-overtravel".to_owned()), "{machine}: {:?}", codes(&verdict));
        for axis in ["X", "Y"] {
            assert_eq!(verdict["axes"][axis]["max"], verdict["axes"][axis]["min"], "{machine}: only Z is named");
        }
    }
}

#[test]
fn g28_meets_its_intermediate_point_and_g30_the_tool_change_position() {
    // Z home 610; the increment of G28 leads down to 480 first. X and Y go to the second reference point.
    let text = "%\nO1\nG21 G90 G17\nT1 M6\nG53 G0 Z500.\nG54\nG0 Z210.\nG91 G28 Z-20.\nG30 P2 X0 Y0\nG90\nM30\n%\n";
    let verdict = Shop::on("spinner-u5-620", ("part.nc", text), [0.0, 0.0, 140.0]).verdict();
    // Without tool length Z 210 is the axis at 350, the intermediate point at 330.
    assert!((number(&verdict["axes"]["Z"]["min"]) - 330.0).abs() < 0.02, "{}", verdict["axes"]["Z"]);
    assert!((number(&verdict["axes"]["Z"]["max"]) - 610.0).abs() < 1e-6);
    assert!(!codes(&verdict).contains(&"limits-overtravel".to_owned()));
}

/// A copy of a machine that is described by primitives, with changed text.
fn changed(machine: &str, change: impl Fn(String) -> String) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let file = root().join("machines").join(machine).join("machine.toml");
    let path = folder.path().join("machine.toml");
    fs::write(&path, change(fs::read_to_string(file).expect("readable"))).expect("written");
    (folder, path)
}

#[test]
fn a_reference_point_that_no_one_states_is_refused() {
    let no_home = |text: String| {
        let keep = |line: &&str| !(line.starts_with("home_mm = 610") || line.starts_with("tool_change_mm = 610"));
        text.lines()
            .filter(keep)
            .fold(String::new(), |all, line| all + line + "\n")
            .replace("travel_mm = [151, 611]", "travel_mm = [0, 611]")
    };
    let (_folder, machine) = changed("ac-trunnion-620", no_home);
    let text = "G21 G90 G17\nT1 M6\nG53 G0 Z500.\nG91 G28 Z0.\nM30\n";
    Shop::new(&machine, ("part.nc", text), [0.0; 3]).refused(&[
        "part.nc:4:1",
        "G28 sends Z to its reference point",
        "AC trunnion 620",
        "home_mm",
        "help: ",
    ]);
    // The same machine runs what does not use it.
    Shop::new(&machine, ("part.nc", &text.replace("G91 G28 Z0.", "G53 G0 Z600.")), [0.0; 3]).verdict();
    // `check` names it before any program does.
    let output = proveout(machine.parent().expect("folder"), &["check", "machine.toml"]);
    let printed = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(printed.contains("machine-no-reference-point") && printed.contains("joint.Z.home_mm"), "{printed}");
}

#[test]
fn words_that_switch_kinematics_are_refused_by_name() {
    for (file, word) in [
        ("part.ngc", "M428"),
        ("part.ngc", "M429"),
        ("part.ngc", "M430"),
        ("part.ngc", "M68 E3 Q1"),
        ("part.nc", "M128"),
        ("part.mpf", "TRAORI(2)"),
        ("part.h", "FUNCTION MODE SET \"HEAD\""),
    ] {
        let text = match file {
            "part.h" => format!("BEGIN PGM P MM\nTOOL CALL 1 Z S1000\n{word}\nL Z+100 R0 FMAX\nM30\nEND PGM P MM\n"),
            "part.mpf" => format!("G54 G90\nT=\"END_D20\"\n{word}\nG0 Z100\nM30\n"),
            _ => format!("G21 G90\nT1 M6\n{word}\nG0 Z100.\nM2\n"),
        };
        let named = word.split(' ').next().expect("a word");
        Shop::on("linuxcnc-xyzac-trt", (file, &text), [0.0; 3]).refused(&[&format!("{file}:3:"), named, "help: "]);
    }
}

#[test]
fn a_kinematics_that_the_machine_does_not_list_is_refused() {
    let mill = |file: &str, text: &str, word: &str| {
        Shop::on("three-axis-mill", (file, text), [0.0; 3]).refused(&[
            &format!("{file}:3:"),
            word,
            "Three-axis mill",
            "kinematics",
            "help: ",
        ]);
    };
    mill("part.mpf", "G54 G90\nT=\"END_D20\"\nTRAORI\nG0 Z400\nM30\n", "TRAORI");
    mill("part.nc", "G21 G90\nT1 M6\nG43.4 H1\nG0 Z400.\nM30\n", "G43.4");
    mill(
        "part.h",
        "BEGIN PGM P MM\nTOOL CALL 1 Z S1000\nPLANE SPATIAL SPA+0 SPB+10 SPC+0 STAY\nM30\nEND PGM P MM\n",
        "PLANE SPATIAL",
    );
    // The list is what decides.
    let without =
        |text: String| text.replace("kinematics = [\"tcp\", \"tilted-plane\"]", "kinematics = [\"tilted-plane\"]");
    let (_folder, machine) = changed("ac-trunnion-620", without);
    let program = ("part.mpf", "G54 G90\nT=\"END_D20\"\nTRAORI\nG0 Z400\nM30\n");
    Shop::new(&machine, program, [0.0; 3]).refused(&["TRAORI", "tcp"]);
    Shop::on("ac-trunnion-620", program, [0.0; 3]).verdict();
    let swivel = ("part.mpf", "G54 G90\nT=\"END_D20\"\nCYCLE800(0,\"TC1\",0,57,0,0,0,10,0,0,0,0,0,1)\nM30\n");
    Shop::new(&machine, swivel, [0.0; 3]).verdict();
}

/// Work offsets mean the same point of the table with tool center point control and without.
#[test]
fn repeating_a_point_behind_the_switch_moves_nothing_on_a_machine_with_its_zero_at_home() {
    let text = "%\nO1\nG21 G90 G94 G17\nT1 M6\nG54 G43 H1\nS1000 M3\nG0 B0 C0\nG0 X50. Y50. Z100.\nG1 Z90. F1000\nG49\n\
                G234 H1\nG1 X50. Y50. Z90. F1000\nG1 X51. Y50. Z90. F1000\nG255\nM30\n%\n";
    // The part's zero is at (-50, -50, 140) of the table; the gauge line at home at (-420, 350, 700).
    let offset = [-50.0 + 420.0, -50.0 - 350.0, 140.0 - 700.0];
    let verdict = Shop::on("bc-trunnion-home-zero", ("part.nc", text), offset).verdict();
    assert!(!codes(&verdict).contains(&"limits-overtravel".to_owned()), "{:?}", codes(&verdict));
    // X from home to the middle of the table and one millimeter on; Y likewise; Z down to 90 mm above the
    // part, tool 150 mm.
    for (axis, low, high) in [("X", 0.0, 421.0), ("Y", -350.0, 0.0), ("Z", -560.0 + 90.0 + 150.0, 0.0)] {
        let range = &verdict["axes"][axis];
        assert!((number(&range["min"]) - low).abs() < 0.02, "{axis}: {range}");
        assert!((number(&range["max"]) - high).abs() < 0.02, "{axis}: {range}");
    }
}

/// After a retraction of the machine axis under tool center point control a turn alone must not bring the
/// tool back down.
#[test]
fn behind_a_retraction_under_tcp_the_tool_stays_up() {
    for (file, text) in [
        (
            "part.nc",
            "%\nO1\nG21 G90 G94 G17\nT1 M6\nG54\nS1000 M3\nG53 G0 Z605.\nG0 B90. C0\nG234 H1\nG0 X150. Y50. Z10.\nG53 G0 Z605.\n@G0 B80.\nM30\n%\n",
        ),
        (
            "part.mpf",
            "G54 G90 G94\nT=\"END_D20\"\nM6\nS1000 M3 D1\nSUPA G0 Z605 D0\nG0 B90 C0\nD1\nTRAORI\nG0 X150 Y50 Z10\nSUPA G0 Z605 D0\nD1\n@G0 B80\nM30\n",
        ),
        (
            "part.h",
            "BEGIN PGM P MM\nTOOL CALL 1 Z S1000\nL Z+605 R0 FMAX M91\nL B+90 C+0 R0 FMAX\nM128\n\
             L X+150 Y+50 Z+10 R0 FMAX\nL Z+605 R0 FMAX M91\n@L B+80 R0 FMAX\nM30\nEND PGM P MM\n",
        ),
    ] {
        let shop = |text: &str| Shop::on("spinner-u5-620", (file, text), [-50.0, -50.0, 140.0]).verdict();
        let turned = shop(&text.replace('@', ""));
        let without = text.lines().filter(|l| !l.starts_with('@')).fold(String::new(), |all, l| all + l + "\n");
        let before = shop(&without);
        let length = |v: &Value| number(&v["path"]["length_mm"]);
        // The tip is at rest while the table turns by ten degrees; a plunge would add 180 mm and more.
        let more = length(&turned) - length(&before);
        assert!(more.abs() < 20.0, "{file}: {more} mm more behind the retraction");
        let lowest = |v: &Value| number(&v["axes"]["Z"]["min"]);
        assert!((lowest(&turned) - lowest(&before)).abs() < 1e-6, "{file}");
        // What the control does with such coordinates is not certain: no pass.
        assert!(codes(&turned).contains(&"program-assumed".to_owned()), "{file}: {:?}", codes(&turned));
        let program = gate(&turned, "program");
        assert_eq!(program["state"], "unchecked", "{file}: {program}");
        assert!(program["reason"].as_str().is_some_and(|r| r.contains("assumed: ")), "{file}: {program}");
    }
}

/// A written program moves to coordinates: a reference point needs its machine.
#[test]
fn a_program_with_g28_is_written_for_a_machine() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let program = "G21 G90\nT1 M6\nG0 Z100.\nG91 G28 Z0.\nG90\nM30\n";
    fs::write(folder.path().join("part.nc"), program).expect("written");
    let output = proveout(folder.path(), &["nc", "part.nc", "--post", "siemens-840d"]);
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{printed}");
    assert!(printed.contains("part.nc:4:1") && printed.contains("--machine"), "{printed}");
    let machine = root().join("machines/spinner-u5-620").display().to_string();
    let output = proveout(folder.path(), &["nc", "part.nc", "--post", "siemens-840d", "--machine", &machine]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let written = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(written.lines().any(|l| l.contains("SUPA") && l.contains("Z610")), "{written}");
    // Looked at as commands, the text is read by itself, with a note.
    let output = proveout(folder.path(), &["nc", "part.nc"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("machine zero"));
    let output = proveout(folder.path(), &["nc", "part.nc", "--machine", &machine]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("\"Z\":610"), "{output:?}");
}
