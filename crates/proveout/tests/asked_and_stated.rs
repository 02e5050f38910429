//! A gate passes only on what the setup states: workholding, tool lengths, teeth, operator switches, corners
//! under ideal dynamics. A gate that the scene does not ask for does not count in the verdict. Each small
//! scene runs with the statement and without it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;
use tempfile::TempDir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace root").to_owned()
}

const NONE: &str = "workholding = \"none\"\nworkholding_reason = \"glued to the table\"\n";
const NO_DESIGN: &str = "design = \"none\"\n";
/// A slot along X through the middle of the block, 3 mm deep, with the cutter next to the block at Z-3 before
/// and after it.
const SLOT: &str = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G0 X-60. Y0.\nG43 H1 Z20.\nS3000 M3\nZ-3.\nG1 X60. F2000.\nG0 Z20.\nM5\nM30\n%\n";
/// Once round the block, 5 mm above its lower face.
const ROUND: &str = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G0 X-45. Y-35.\nG43 H1 Z20.\nS3000 M3\nZ-15.\nG1 X45. F2000.\nY35.\nX-45.\nY-35.\n\
                     G0 Z20.\nM5\nM30\n%\n";

/// A scene with a block of 60 x 40 x 20 mm, its top at zero.
struct Shop(TempDir);

impl Shop {
    fn new(head: &str, more: &str, program: (&str, &str)) -> Self {
        let shop = Self(tempfile::tempdir().expect("temporary folder"));
        let (file, text) = program;
        let machine = root().join("machines/three-axis-mill");
        let scene = format!(
            "name = \"shop\"\n{head}machine = {machine:?}\ntools = \"tools.toml\"\nresolution_mm = 1\n[stock]\n\
             box = {{ min_mm = [-30, -20, -20], max_mm = [30, 20, 0] }}\n[mount]\ntranslation_mm = [0, 0, 150]\n[work_offsets.G54]\nZ_mm = 150\n\
             [work_offsets.PRESET1]\nZ_mm = 150\n{more}\n[[program]]\nname = \"main\"\nfile = {file:?}\n"
        );
        shop.write("scene.toml", &scene);
        shop.write("tools.toml", &tool(""));
        shop.write(file, text);
        shop
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(name), text).expect("written");
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.path().join(name)).expect(name)
    }

    fn call(&self, args: &[&str]) -> (i32, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(self.0.path())
            .args(args)
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(!said.contains("panicked"), "{said}");
        (output.status.code().unwrap_or(-1), said)
    }

    fn run_with(&self, more: &[&str]) -> (i32, String, Value) {
        let (code, said) =
            self.call(&[&["run", ".", "--output", "result", "--rerun", "off", "--threads", "2"], more].concat());
        let text =
            fs::read_to_string(self.0.path().join("result/verdict.json")).unwrap_or_else(|e| panic!("{e}: {said}"));
        (code, said, serde_json::from_str(&text).expect("JSON"))
    }

    fn run(&self) -> (i32, String, Value) {
        self.run_with(&[])
    }
}

/// A flat end mill of 10 mm, 45 mm out of a holder of 40 x 60 mm.
fn tool(more: &str) -> String {
    format!(
        "[[tool]]\nnumber = 1\nname = \"F10\"\nkind = \"flat\"\ndiameter_mm = 10\nflute_length_mm = 25\nshank_diameter_mm = 10\n\
         overall_length_mm = 90\ngauge_length_mm = 105\nflutes = 4\ncenter_cutting = true\n{more}[tool.holder]\nname = \"H\"\n\
         sections = [{{ diameter_mm = 40, length_mm = 60 }}]\n"
    )
}

fn gate(verdict: &Value, name: &str) -> (String, String) {
    let gates = verdict["gates"].as_array().expect("gates");
    let gate = gates.iter().find(|g| g["name"] == name).expect("the gate");
    (gate["state"].as_str().expect("a state").to_owned(), gate["reason"].as_str().expect("a reason").to_owned())
}

const HELD: [(&str, &str, bool); 6] = [
    // The jaws reach 3 mm above the lower face: below the cutter.
    (
        "vise",
        "at_mm = [0, 0, -17]\nopening_mm = 40\njaw_width_mm = 80\njaw_height_mm = 30\njaw_thickness_mm = 20\nbed_height_mm = 20\n",
        false,
    ),
    // Up to 8 mm above it: the cutter goes through them.
    (
        "vise",
        "at_mm = [0, 0, -12]\nopening_mm = 40\njaw_width_mm = 80\njaw_height_mm = 30\njaw_thickness_mm = 20\nbed_height_mm = 20\n",
        true,
    ),
    ("plate", "at_mm = [0, 0, -20]\nlength_mm = 200\nwidth_mm = 150\nthickness_mm = 20\n", false),
    (
        "chuck",
        "at_mm = [0, 0, -20]\ndiameter_mm = 160\nlength_mm = 60\ngrip_diameter_mm = 60\njaws = 4\njaw_width_mm = 20\njaw_height_mm = 10\n",
        true,
    ),
    (
        "tombstone",
        "at_mm = [0, 0, -130]\nside_mm = 60\nheight_mm = 110\nbase_side_mm = 120\nbase_thickness_mm = 20\n",
        false,
    ),
    (
        "toe-clamp",
        "at_mm = [30, 0, 0]\nlength_mm = 80\nwidth_mm = 30\nthickness_mm = 15\nreach_mm = 8\nheight_mm = 20\nstud_diameter_mm = 12\nstud_height_mm = 10\n",
        true,
    ),
];

#[test]
fn collision_is_open_until_the_scene_says_what_holds_the_part() {
    let (_, _, verdict) = Shop::new("", "", ("main.nc", ROUND)).run();
    for name in ["collision", "near_miss"] {
        let (state, reason) = gate(&verdict, name);
        assert!(
            state == "unchecked" && reason.contains("not checked: no workholding in the scene"),
            "{name}: {state}: {reason}"
        );
    }
    let shop = Shop::new(NONE, "", ("main.nc", ROUND));
    let (_, _, verdict) = shop.run();
    for name in ["collision", "near_miss"] {
        let (state, reason) = gate(&verdict, name);
        assert!(
            state == "pass" && reason.contains("workholding: none, as the scene states: glued to the table"),
            "{name}: {state}: {reason}"
        );
    }
    for page in ["report.html", "setup.html"] {
        assert!(shop.read(&format!("result/{page}")).contains("glued to the table"), "{page}");
    }
    // Fixtures by their dimensions are checked against the tools like meshes.
    for (kind, dimensions, hits) in HELD {
        let fixture = format!("[[fixture]]\nname = \"held\"\nkind = \"{kind}\"\n{dimensions}");
        let shop = Shop::new("", &fixture, ("main.nc", ROUND));
        let (_, said, verdict) = shop.run();
        let (state, reason) = gate(&verdict, "collision");
        assert_eq!(state, if hits { "fail" } else { "pass" }, "{kind}: {reason}\n{said}");
        assert!(!reason.contains("no workholding"), "{reason}");
        let met = verdict["findings"].to_string();
        assert_eq!(met.contains("collision-bodies") && met.contains("held"), hits, "{kind}: {met}");
        assert!(shop.read("result/setup.html").contains("held"), "{kind}");
    }
}

#[test]
fn a_chosen_length_leaves_the_holder_open_and_tells_the_shortest_that_clears() {
    // A step along a side of the block, 20 mm deep, of which no piece comes off: the holder clears by 1 mm at
    // 21 mm.
    let deep = SLOT.replace("Y0.", "Y-20.").replace("Z-3.", "Z-20.").replace("G1 X60. F2000.", "G1 X60. F800.");
    let chosen = "chosen = [{ keys = [\"gauge_length_mm\"], reason = \"a usual one\" }]\n";
    for (more, state) in [
        ("", "pass"),
        (chosen, "unchecked"),
        (&*format!("gauge_length_source = \"measured\"\n{chosen}"), "pass"),
        (&*format!("gauge_length_source = \"prescribed\"\n{chosen}"), "pass"),
    ] {
        let shop = Shop::new(NONE, "", ("main.nc", &deep));
        shop.write("tools.toml", &tool(more));
        let (_, said, verdict) = shop.run();
        for name in ["collision", "near_miss"] {
            let (is, reason) = gate(&verdict, name);
            assert_eq!(is, state, "{more}: {name}: {reason}\n{said}");
            assert_eq!(reason.contains("prescribes: F10 45.0 mm"), more.contains("prescribed"), "{reason}");
            if state == "unchecked" {
                assert!(reason.contains("assumed: the holder of F10, with 45.0 mm out of its holder"), "{reason}");
                let least = reason.split("the shortest that clears is ").nth(1).expect("given");
                let least: f64 = least.split(' ').next().expect("a number").parse().expect("a number");
                // Its nose stays above the face by the wanted clearance; at least the flutes project.
                assert!((25.0..=26.0).contains(&least), "{reason}");
                assert_eq!(
                    verdict["tools"][0]["min_overhang_mm"].as_f64().map(|v| (v * 10.0 - 1e-6).ceil() / 10.0),
                    Some(least)
                );
            }
        }
    }
}

#[test]
fn a_gate_that_nobody_asked_has_no_part_in_the_verdict() {
    for (head, more, code, states) in [
        (NONE.to_owned(), "", 3, ["unchecked", "unchecked", "not_asked"]),
        (format!("{NONE}{NO_DESIGN}"), "", 0, ["not_asked", "not_asked", "not_asked"]),
        (
            format!("{NONE}{NO_DESIGN}"),
            "[gates]\nnot_asked = [\"gouge\", \"surface\"]\n",
            0,
            ["not_asked", "not_asked", "not_asked"],
        ),
        (format!("{NONE}{NO_DESIGN}"), "[gates]\nnot_asked = []\n", 3, ["not_asked", "not_asked", "unchecked"]),
        (
            format!("{NONE}{NO_DESIGN}"),
            "[[inspect]]\nname = \"floor\"\nfrom_mm = [0, 0, 10]\ndirection = \"-z\"\nnominal_mm = -3\ntolerance_mm = 0.01\n",
            0,
            ["not_asked", "pass", "not_asked"],
        ),
    ] {
        let shop = Shop::new(&head, more, ("main.nc", SLOT));
        let (is, said, verdict) = shop.run();
        assert_eq!(is, code, "{head}{more}: {said}\n{:#}", verdict["gates"]);
        for (name, state) in ["gouge", "excess", "surface"].into_iter().zip(states) {
            let (is, reason) = gate(&verdict, name);
            assert_eq!(is, state, "{name}: {reason}");
        }
        assert!(said.contains("not asked surface") || states[2] == "unchecked", "{said}");
        if code == 0 {
            assert!(said.contains("PASS") && said.contains("  not asked: gouge"), "{said}");
            assert_eq!(verdict["verdict"], "pass");
            for page in ["report.html", "setup.html"] {
                let text = shop.read(&format!("result/{page}")).to_lowercase();
                assert!(text.contains("not asked: gouge"), "{page}");
            }
        }
    }
}

#[test]
fn ideal_dynamics_pass_no_gate_that_depends_on_the_path() {
    for (dynamics, state) in [("ideal", "unchecked"), ("planned", "pass")] {
        let shop = Shop::new(NONE, "", ("main.nc", SLOT));
        let (_, said, verdict) = shop.run_with(&["--dynamics", dynamics]);
        for name in ["process", "collision", "near_miss"] {
            let (is, reason) = gate(&verdict, name);
            assert_eq!(is, state, "{name}: {reason}\n{said}");
            assert_eq!(
                reason.contains("dynamics are ideal: the cut ignores corner rounding"),
                state == "unchecked",
                "{reason}"
            );
        }
    }
}

/// The only retract comes after a `/`: without it the next rapid goes through the block.
const SLASHED: [(&str, &str, &str); 4] = [
    (
        "main.nc",
        "fanuc",
        "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G0 X-60. Y0.\nG43 H1 Z20.\nS3000 M3\nZ-3.\n@G0 Z20.\nG0 X60.\nZ20.\nM30\n%\n",
    ),
    (
        "main.ngc",
        "linuxcnc",
        "G17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 G0 X-60 Y0\nG43 H1 Z20\nS3000 M3\nG0 Z-3\n@G0 Z20\nG0 X60\nZ20\nM2\n",
    ),
    (
        "main.mpf",
        "siemens-840d",
        "G17 G54 G90 G94 G710 G60\nT1\nM6\nD1\nG0 X-60 Y0 S3000 M3\nG0 Z20\nG0 Z-3\n@G0 Z20\nG0 X60\nG0 Z20\nM30\n",
    ),
    (
        "main.h",
        "heidenhain",
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000 F500\n2 CYCL DEF 247 Q339=+1\n3 L X-60 Y+0 Z+20 R0 FMAX M3\n4 L Z-3 FMAX\n@5 L Z+20 FMAX\n\
         6 L X+60 FMAX\n7 L Z+20 FMAX M30\n8 END PGM A MM\n",
    ),
];

#[test]
fn blocks_with_a_slash_are_proved_as_the_scene_says_in_every_language() {
    for (file, dialect, text) in SLASHED {
        let run = |slash: &str, switch: &str| {
            let shop = Shop::new(NONE, "", (file, &text.replace('@', slash)));
            let scene = shop.read("scene.toml") + &format!("dialect = \"{dialect}\"\n{switch}");
            shop.write("scene.toml", &scene);
            let (_, said, verdict) = shop.run();
            let of = |name: &str| gate(&verdict, name);
            (of("program"), of("process"), said)
        };
        for (slash, switch, program, process) in [
            ("", "", "pass", "pass"),
            ("/", "", "unchecked", "pass"),
            ("/", "block_skip = \"off\"\n", "pass", "pass"),
            ("/", "block_skip = \"on\"\n", "pass", "fail"),
            ("/", "block_skip = \"both\"\n", "pass", "fail"),
            ("", "block_skip = \"both\"\n", "pass", "pass"),
        ] {
            let (of_program, of_process, said) = run(slash, switch);
            let what = format!("{dialect} {slash:?} {switch:?}");
            assert_eq!(of_program.0, program, "{what}: {} {said}", of_program.1);
            assert_eq!(of_process.0, process, "{what}: {} {said}", of_process.1);
            assert_eq!(of_program.1.contains("block-skip switch"), program == "unchecked", "{what}: {}", of_program.1);
            if slash == "/" && switch.contains("both") {
                assert!(of_process.1.contains("without the `/` blocks"), "{what}: {}", of_process.1);
                assert!(said.contains("without the `/` blocks: "), "{said}");
            }
        }
    }
}

#[test]
fn a_cut_behind_m1_is_proved_as_the_scene_says() {
    let text = SLOT.replace("G1 X60. F2000.", "M1\nG1 X60. F2000.");
    for (switch, program, process) in [
        ("", "unchecked", "pass"),
        ("optional_stop = \"off\"\n", "pass", "pass"),
        ("optional_stop = \"on\"\n", "pass", "fail"),
        ("optional_stop = \"both\"\n", "pass", "fail"),
    ] {
        let shop = Shop::new(NONE, "", ("main.nc", &text));
        let scene = shop.read("scene.toml") + switch;
        shop.write("scene.toml", &scene);
        let (_, said, verdict) = shop.run();
        assert_eq!(gate(&verdict, "program").0, program, "{switch}: {said}");
        assert_eq!(gate(&verdict, "process").0, process, "{switch}: {said}");
        assert_eq!(said.contains("process-spindle-off"), process == "fail", "{switch}: {said}");
    }
}
