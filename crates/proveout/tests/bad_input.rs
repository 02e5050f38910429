//! Wrong input gets one error with its place and remedy, exit code 2, and no run folder.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
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

/// A small scene of its own in a temporary folder.
struct Small {
    folder: TempDir,
}

const PROGRAM: &str = "G17 G54 G90 G94 G710\nT=\"END_D20\"\nM6\nG0 X0 Y0 Z50 S1000 M3 D1\nG1 Z10 F500\nM30\n";

impl Small {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let small = Self { folder };
        small.write("program.mpf", PROGRAM);
        small.write("scene.toml", &small.scene("box = { min_mm = [-20, -20, -20], max_mm = [20, 20, 0] }"));
        small
    }

    fn scene(&self, stock: &str) -> String {
        let root = root();
        let path = |p: &str| root.join(p).display().to_string();
        format!(
            "name = \"small\"\nmachine = {:?}\ntools = {:?}\nresolution_mm = 1.0\n\n[stock]\n{stock}\n\n\
             [mount]\ntranslation_mm = [0, 0, 140]\n\n[work_offsets.G54]\nZ_mm = 140\n\n\
             [[program]]\nname = \"main\"\nfile = \"program.mpf\"\n",
            path("machines/spinner-u5-620"),
            path("tools/cone-frustum.toml")
        )
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.folder.path().join(name), text).expect("written");
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn run(&self) -> Output {
        proveout(self.path(), &["run", ".", "--output", "result", "--rerun", "off"])
    }

    /// Runs and asserts that the error says all of `words`, and that nothing but the input is left.
    fn refused(&self, words: &[&str]) {
        self.refuses(&["run", ".", "--output", "result", "--rerun", "off"], words);
    }

    /// The same for another call.
    fn refuses(&self, arguments: &[&str], words: &[&str]) {
        let before = names(self.path());
        let output = proveout(self.path(), arguments);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{printed}");
        for word in words {
            assert!(printed.contains(word), "{word:?} is not in:\n{printed}");
        }
        assert_eq!(printed.matches("error: ").count(), 1, "one error:\n{printed}");
        assert!(!printed.contains("panicked"), "{printed}");
        assert_eq!(names(self.path()), before, "nothing is left behind");
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("readable");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn the_small_scene_itself_runs() {
    let small = Small::new();
    let output = small.run();
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "no design part: unchecked\n{printed}");
    for file in
        ["verdict.json", "run.json", "signals.parquet", "blocks.parquet", "surface.parquet", "part.glb", "report.html"]
    {
        assert!(small.path().join("result").join(file).is_file(), "{file} is missing");
    }
    let verdict = fs::read_to_string(small.path().join("result/verdict.json")).expect("written");
    let verdict: serde_json::Value = serde_json::from_str(&verdict).expect("JSON");
    assert_eq!(verdict["machine"]["name"], "Spinner U5-620");
    assert_eq!(verdict["machine"]["digest"], verdict["digests"]["machine"]);
}

#[test]
fn a_program_without_motion_passes_nothing_but_its_reading() {
    let small = Small::new();
    small.write("program.mpf", "M30\n");
    assert_eq!(small.run().status.code(), Some(3));
    let verdict = fs::read_to_string(small.path().join("result/verdict.json")).expect("written");
    assert_eq!(verdict.matches("\"state\": \"pass\"").count(), 1, "{verdict}");
}

#[test]
fn an_empty_program() {
    for text in ["", "\n \n\t\n", "%\n%\n"] {
        let small = Small::new();
        small.write("program.mpf", text);
        small.refused(&["program.mpf", "the program is empty", "help: export the program again"]);
    }
}

#[test]
fn a_missing_program() {
    let small = Small::new();
    fs::remove_file(small.path().join("program.mpf")).expect("removed");
    small.refused(&["program.mpf", "cannot be read", "help: check the path"]);
}

#[test]
fn a_missing_scene() {
    let small = Small::new();
    let output = proveout(small.path(), &["run", "nowhere"]);
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{printed}");
    assert!(printed.contains("nowhere") && printed.contains("cannot be read"), "{printed}");
}

#[test]
fn an_unknown_g_word() {
    let small = Small::new();
    small.write("program.mpf", &PROGRAM.replace("G1 Z10 F500", "G1 Z10 G777 F500"));
    small.refused(&["program.mpf:5:8", "G777", "help: "]);
}

#[test]
fn a_tool_that_the_library_lacks() {
    let small = Small::new();
    small.write("program.mpf", &PROGRAM.replace("END_D20", "NO_SUCH_TOOL"));
    small.refused(&["program.mpf:2:", "NO_SUCH_TOOL", "help: "]);
}

#[test]
fn a_work_offset_that_the_scene_does_not_give() {
    let small = Small::new();
    small.write("program.mpf", &PROGRAM.replace("G54", "G55"));
    small.refused(&["program.mpf:1:", "work offset G55", "[work_offsets.G55]"]);
}

#[test]
fn a_stock_mesh_with_a_hole() {
    let small = Small::new();
    small.write("open.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 -9\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
    small.write("scene.toml", &small.scene("mesh = \"open.obj\""));
    small.refused(&["open.obj", "hole", "edge", "help: "]);
}

#[test]
fn a_misspelt_key() {
    let small = Small::new();
    let scene = fs::read_to_string(small.path().join("scene.toml")).expect("readable");
    small.write("scene.toml", &scene.replace("resolution_mm", "resolutoin_mm"));
    small.refused(&["scene.toml:4:1", "resolutoin_mm", "did you mean `resolution_mm`?"]);
}

#[test]
fn a_stock_that_does_not_fit_into_memory() {
    let small = Small::new();
    let scene = fs::read_to_string(small.path().join("scene.toml")).expect("readable");
    small.write("scene.toml", &scene.replace("resolution_mm = 1.0", "resolution_mm = 0.0005"));
    small.refused(&["MiB", "0.0005 mm", "use cells of"]);
}

#[test]
fn a_folder_with_other_things_is_not_written_over() {
    let small = Small::new();
    fs::create_dir(small.path().join("result")).expect("made");
    small.write("result/thesis.txt", "work of years");
    small.refused(&["result", "it is not overwritten", "--output"]);
    assert_eq!(fs::read_to_string(small.path().join("result/thesis.txt")).expect("still there"), "work of years");
}

#[test]
fn a_comparison_that_cannot_be_made() {
    let small = Small::new();
    let compare = ["compare", ".", "--output", "result"];
    small.refuses(&compare, &["scene.toml", "1 program", "nothing to compare", "[[program]]"]);
    let one = fs::read_to_string(small.path().join("scene.toml")).expect("readable");
    small.write("scene.toml", &format!("{one}\n[[program]]\nname = \"other\"\nfile = \"other.mpf\"\n"));
    small.refuses(&compare, &["other.mpf", "cannot be read"]);
    small.write("other.mpf", &PROGRAM.replace("F500", "F1000"));
    small.refuses(&["compare", ".", "--baseline", "third", "--output", "result"], &["third", "main, other"]);
    small.write("other.mpf", &PROGRAM.replace("G1 Z10", "G1 Z10 FROB=3"));
    small.refuses(&["compare", ".", "--baseline", "other", "--output", "result"], &["other.mpf:5", "FROB"]);
    let two = fs::read_to_string(small.path().join("scene.toml")).expect("readable");
    small.write(
        "scene.toml",
        &format!("{two}\n[[compare.expect]]\nname = \"fast\"\nprogram = \"third\"\ngate = \"limits\"\n"),
    );
    small.refuses(&compare, &["scene.toml:25:11", "third", "main, other"]);
}

#[test]
fn a_comparison_writes_its_folder_and_replaces_an_older_one() {
    let small = Small::new();
    let one = fs::read_to_string(small.path().join("scene.toml")).expect("readable");
    let criterion = "[[compare.expect]]\nname = \"fast\"\nprogram = \"other\"\nagainst = \"main\"\nquantity = \"cutting-time\"\n\
                     at_least = 10\n";
    small.write("scene.toml", &format!("{one}\n[[program]]\nname = \"other\"\nfile = \"other.mpf\"\n{criterion}"));
    small.write("other.mpf", &PROGRAM.replace("F500", "F1000"));
    for _ in 0..2 {
        let output = proveout(small.path(), &["compare", ".", "--output", "result"]);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        // Surface texture is not evaluated: the verdicts are unchecked, and so is the comparison.
        assert_eq!(output.status.code(), Some(3), "{printed}");
        let shown = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(shown.contains("UNCHECKED") && shown.contains("fast"), "{shown}");
        assert_eq!(
            names(&small.path().join("result")),
            ["compare.html", "compare.json", "main", "manifest.json", "other"]
        );
        assert!(small.path().join("result/other/verdict.json").is_file());
        assert!(small.path().join("result/other/report.html").is_file());
    }
    let json = fs::read_to_string(small.path().join("result/compare.json")).expect("written");
    assert!(json.contains("\"state\": \"pass\"") && json.contains("\"sign_holds\": true"), "{json}");
}

/// The scene of Li et al. 2022 in the temporary folder, at coarse cells, its program cut off or its scene
/// file changed.
fn li_2022(small: &Small, blocks: Option<usize>, scene: impl Fn(String) -> String) {
    let folder = root().join("scenes/li-2022-s-theta");
    let text = fs::read_to_string(folder.join("scene.toml")).expect("the scene");
    let path = |p: &str| format!("{:?}", root().join(p).display().to_string());
    let text = text
        .replace("\"../../machines/starrag-lx-451\"", &path("machines/starrag-lx-451"))
        .replace("\"../../tools/li-2022.toml\"", &path("tools/li-2022.toml"))
        .replace("resolution_mm = 0.2", "resolution_mm = 2");
    small.write("scene.toml", &scene(text));
    let program = fs::read_to_string(folder.join("original.mpf")).expect("the program");
    let lines: Vec<&str> = program.lines().collect();
    let first = lines.iter().position(|l| l.starts_with("G1 ")).expect("a motion in feed");
    let kept = blocks.map_or(lines.len(), |n| first + n);
    let tail: &[&str] = if blocks.is_some() { &["TRAFOOF", "M30"] } else { &[] };
    let cut: Vec<&str> = lines[..kept].iter().chain(tail).copied().collect();
    small.write("original.mpf", &(cut.join("\n") + "\n"));
    fs::remove_file(small.path().join("program.mpf")).expect("removed");
}

/// `proveout reschedule` is refused with all of `words`, and leaves nothing.
fn not_rescheduled(small: &Small, words: &[&str]) {
    let before = names(small.path());
    let arguments = ["reschedule", ".", "--program", "original", "--method", "s-theta", "--output", "rescheduled.mpf"];
    let output = proveout(small.path(), &arguments);
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{printed}");
    for word in words {
        assert!(printed.contains(word), "{word:?} is not in:\n{printed}");
    }
    assert_eq!(printed.matches("error: ").count(), 1, "one error:\n{printed}");
    assert_eq!(names(small.path()), before, "nothing is left behind");
}

#[test]
fn a_path_without_layers_is_not_rescheduled() {
    let small = Small::new();
    li_2022(&small, Some(200), |scene| scene);
    not_rescheduled(&small, &["original.mpf:", "no whole layer", "one turn or more", "help: "]);
}

#[test]
fn a_path_of_a_flat_end_mill_is_not_rescheduled() {
    let small = Small::new();
    let tools = format!("{:?}", root().join("tools/li-2022.toml").display().to_string());
    li_2022(&small, None, |scene| scene.replace(&tools, "\"flat.toml\""));
    let library = fs::read_to_string(root().join("tools/li-2022.toml")).expect("the library");
    small.write("flat.toml", &library.replace("kind = \"ball\"", "kind = \"flat\""));
    not_rescheduled(&small, &["original.mpf:16:", "not a ball end mill", "help: ", "use a ball end mill"]);
}

#[test]
fn an_orientation_out_of_the_range_of_a_joint_is_not_rescheduled() {
    let small = Small::new();
    let folder = root().join("machines/starrag-lx-451");
    let own = format!("{:?}", folder.display().to_string());
    li_2022(&small, None, |scene| scene.replace(&own, "\"machine\""));
    fs::create_dir(small.path().join("machine")).expect("made");
    fs::copy(folder.join("model.glb"), small.path().join("machine/model.glb")).expect("copied");
    let machine = fs::read_to_string(folder.join("machine.toml")).expect("the machine");
    small.write("machine/machine.toml", &machine.replacen("travel_deg = [-87, 87]", "travel_deg = [-87, 3]", 1));
    not_rescheduled(&small, &["original.mpf:14:", "the new orientation is out of reach", "B", "help: "]);
}

#[test]
fn a_scene_whose_program_has_no_channel_does_not_run() {
    let small = Small::new();
    li_2022(&small, None, |scene| {
        let wide = "method = \"s-theta\", from = \"original\", clearance_deg = 62 }";
        // The program that is run by default is the first one: take the others out.
        let start = scene.find("[[program]]\nname = \"quaternion\"").expect("the quaternion program");
        let original = scene.find("[[program]]\nname = \"original\"").expect("the original program");
        let own = &scene[original..start];
        format!("{}[[program]]\nname = \"wide\"\nreschedule = {{ {wide}\n\n{own}", &scene[..original])
    });
    small.refused(&["original.mpf:", "no channel", "62.0 degrees", "set the clearance to at most"]);
}

#[test]
fn an_option_that_its_method_does_not_read() {
    for (option, method, wanted) in [
        ("keys = 9", "s-theta", "clearance_deg, inset_deg, start_flat_mm, end_flat_percent, merge_mm, theta_unit"),
        ("inset_deg = 3", "quaternion", "keys"),
    ] {
        let small = Small::new();
        li_2022(&small, None, |scene| {
            let program = format!(
                "\n[[program]]\nname = \"odd\"\nreschedule = {{ method = {method:?}, from = \"original\", {option} }}\n"
            );
            scene + &program
        });
        let key = option.split(' ').next().expect("a key");
        small.refused(&["scene.toml", "\"odd\"", key, "does not read", wanted]);
    }
}

#[test]
fn a_joint_limit_above_that_of_the_machine() {
    let small = Small::new();
    let scene = fs::read_to_string(small.path().join("scene.toml")).expect("readable");
    let limit = "\n[control.joint_limits.X]\nmax_velocity_mm_min = 1e6\nsource = \"wishful\"\n";
    small.write("scene.toml", &(scene + limit));
    small.refused(&["scene.toml", "control.joint_limits.X", "above the machine's limit", "help: "]);
}

#[test]
fn an_old_key_is_refused_with_its_new_name() {
    let small = Small::new();
    let scene = fs::read_to_string(small.path().join("scene.toml")).expect("readable");
    let mount = scene.replace("[mount]\n", "[mount]\nchosen = true\n");
    assert_ne!(mount, scene);
    for (text, old, new) in [
        (scene.clone() + "\n[limits]\nblocks = 9\n", "`limits`", "`run_limits`"),
        (scene.clone() + "\n[surface]\nphases = 2\n", "`surface.phases`", "`random_phases`"),
        (mount, "`mount.chosen`", "`assumed`"),
    ] {
        small.write("scene.toml", &text);
        small.refused(&["scene.toml:", old, "is not a known key", new, "proveout migrate"]);
    }
}

/// An error about a key of a scene points to that key, even if the same word occurs earlier in a comment, in
/// a name or in another table.
#[test]
fn a_fault_of_a_key_has_its_line_and_column() {
    let decoy = "# gouge_mm contact_mm path_tolerance_mm blocks tool [start] [part [surface [compare baseline draws \"main\" dialect\n";
    // What is put into the scene, the line that is at fault, and the value or name that the column points at.
    let cases: [(&str, &str, &str); 14] = [
        ("[tolerances]\ngouge_mm = -0.1\n", "gouge_mm = -0.1", "-0.1"),
        ("[tolerances]\ncontact_mm = 5000\n", "contact_mm = 5000", "5000"),
        ("[tolerances]\nra_um = 0\n", "ra_um = 0", "0"),
        ("[run_limits]\nblocks = 0\n", "blocks = 0", "0"),
        ("[run_limits]\nsimulated_time_s = 0.5\n", "simulated_time_s = 0.5", "0.5"),
        ("[start]\ntool = 99\n", "tool = 99", "99"),
        ("[control.joint_limits.Q]\nsource = \"s\"\nmax_velocity_deg_s = 1\n", "[control.joint_limits.Q]", "Q"),
        ("[control.joint_limits.X]\nsource = \"s\"\nmax_velocity_deg_s = 1\n", "max_velocity_deg_s = 1", "1"),
        ("[surface]\nsize_mm = [4, 3]\nstep_um = 20\nrandom_phases = 0\n", "random_phases = 0", "0"),
        ("[part]\nsections = \"s.csv\"\nmesh = \"p.stl\"\n", "sections = \"s.csv\"", "\"s.csv\""),
        ("[[program]]\nname = \"main\"\nfile = \"program.mpf\"\n", "name = \"main\"", "\"main\""),
        (
            "[[program]]\nname = \"b\"\nfile = \"program.mpf\"\n[compare]\nbaseline = \"nobody\"\n",
            "baseline = \"nobody\"",
            "\"nobody\"",
        ),
        (
            "[[program]]\nname = \"b\"\nfile = \"program.mpf\"\n[compare]\nmust_pass = [\"main\", \"c\"]\n",
            "must_pass = [\"main\", \"c\"]",
            "\"c\"",
        ),
        (
            "[[program]]\nname = \"b\"\nfile = \"program.mpf\"\ndialect = \"basic\"\n",
            "dialect = \"basic\"",
            "\"basic\"",
        ),
    ];
    for (added, line, value) in cases {
        let small = Small::new();
        let text = fs::read_to_string(small.path().join("scene.toml")).expect("a scene");
        let text = format!("{decoy}{text}\n{added}");
        small.write("scene.toml", &text);
        // The last such line is the one that was put in.
        let at = text.lines().enumerate().filter(|(_, l)| *l == line).last().map(|(i, _)| i + 1).expect(line);
        let column = line.find(value).expect(value) + 1;
        let output = proveout(small.path(), &["check", "scene.toml"]);
        let printed = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(2), "{added}\n{printed}");
        assert!(printed.contains(&format!("scene.toml:{at}:{column}")), "{added} stands at {at}:{column}\n{printed}");
    }
}
