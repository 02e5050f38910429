//! Rapid motions on a tilted plane as posts write them: X and Y first, Z after the tool length. The axis
//! without a word stays where the machine has it, so that the tool passes over the post; one block with all
//! three goes straight through it.
//!
//! ```text
//!   z |  start .---------<---------.   X Y, at the height where the machine is
//!     |        |          . - '
//!     |        v    . - '[post]        one block: the straight line
//!     |   end  '- '
//!     '----------------------------- x   machine coordinates, the table turned by B30
//! ```

use std::{fs, path::Path, process::Command};

use serde_json::Value;
use tempfile::TempDir;

/// X, Y and Z carry the tool, B the table; the gauge line is at the machine zero with all joints at zero.
const MACHINE: &str = r#"
name = "small"
spindle = { on = "Z", origin_mm = [0, 0, 0], direction = [0, 0, 1], start_time_s = 1, max_speed_rpm = 9000 }
table = { on = "B", point_mm = [0, 0, -20], normal = [0, 0, 1] }
control = { cycle_time_ms = 2, block_time_ms = 1, rapid_mode = "straight", tool_change_time_s = 5, default_tolerance_mm = 0.01 }

[[joint]]
name = "B"
kind = "rotary"
carries = "workpiece"
parent = "base"
direction = [0, 1, 0]
point_mm = [0, 0, 0]
sense = -1
travel_deg = [-100, 100]
max_velocity_deg_s = 90
max_acceleration_deg_s2 = 900
max_jerk_deg_s3 = 20_000

[[body]]
name = "table"
role = "table"
attached_to = "B"
check = true
box = [{ min_mm = [-60, -60, -40], max_mm = [60, 60, -20] }]

[[body]]
name = "head"
role = "head"
attached_to = "Z"
check = true
box = [{ min_mm = [-50, -50, 10], max_mm = [50, 50, 100] }]
"#;

const TOOLS: &str = "[[tool]]\nnumber = 1\nname = \"T1\"\nkind = \"flat\"\ndiameter_mm = 6\nflute_length_mm = 20\nshank_diameter_mm = 6\n\
                     gauge_length_mm = 80\nflutes = 2\ncenter_cutting = true\nholder = { sections = [{ diameter_mm = 20, length_mm = 30 }] }\n";

/// Is at x 50 and z 60 of the machine when the table is turned by B30.
const POST: &str =
    "[[fixture]]\nname = \"post\"\nframe = \"table\"\nbox = { min_mm = [63, -15, 17], max_mm = [83, 15, 37] }\n";

fn machine(z_rapid: u32) -> String {
    let slide = |name: &str, parent: &str, direction: &str, rapid: u32| {
        format!(
            "\n[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\ndirection = {direction}\n\
             travel_mm = [-500, 500]\nhome_mm = {}\nmax_velocity_mm_min = 20_000\nrapid_velocity_mm_min = {rapid}\n\
             max_acceleration_mm_s2 = 3000\nmax_jerk_mm_s3 = 60_000\n",
            if name == "Z" { 300 } else { 0 }
        )
    };
    let joints = [
        slide("X", "base", "[1, 0, 0]", 18_000),
        slide("Y", "X", "[0, 1, 0]", 18_000),
        slide("Z", "Y", "[0, 0, 1]", z_rapid),
    ];
    MACHINE.replacen("\n[[joint]]", &(joints.concat() + "\n[[joint]]"), 1)
}

/// A shop with a part of 20 x 20 x 10 mm below the zero and the post next to it.
struct Shop(TempDir);

impl Shop {
    fn new(machine: &str, dialect: &str, fixture: &str, program: &str) -> Self {
        let shop = Self(tempfile::tempdir().expect("temporary folder"));
        let file = match dialect {
            "siemens-840d" => "main.mpf",
            "heidenhain" => "main.h",
            _ => "main.nc",
        };
        let workholding = if fixture.contains("[[fixture]]") {
            ""
        } else {
            "workholding = \"none\"\nworkholding_reason = \"not part of this test\"\n"
        };
        let scene = format!(
            "name = \"shop\"\n{workholding}machine = \"machine.toml\"\ntools = \"tools.toml\"\nresolution_mm = 0.5\n[stock]\n\
             box = {{ min_mm = [-10, -10, -10], max_mm = [10, 10, 0] }}\n[work_offsets.G54]\nZ_mm = 0\n\
             [work_offsets.PRESET1]\nZ_mm = 0\n{fixture}\n[[program]]\nname = \"main\"\nfile = {file:?}\ndialect = \"{dialect}\"\n"
        );
        for (name, text) in [("machine.toml", machine), ("tools.toml", TOOLS), ("scene.toml", &scene), (file, program)]
        {
            fs::write(shop.path().join(name), text).expect("written");
        }
        shop
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Exit code and output of a call.
    fn call(&self, line: &str) -> (Option<i32>, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_proveout"))
            .current_dir(self.path())
            .args(line.split_whitespace())
            .output()
            .expect("the program starts");
        let printed = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
        (output.status.code(), printed)
    }

    fn verdict(&self) -> Value {
        let (code, output) = self.call("run . --output result --rerun off");
        assert!(matches!(code, Some(0 | 1 | 3)), "{output}");
        let text = fs::read_to_string(self.path().join("result/verdict.json")).expect("written");
        serde_json::from_str(&text).expect("JSON")
    }
}

/// State and reason of a gate.
fn gate(verdict: &Value, name: &str) -> (String, String) {
    let gates = verdict["gates"].as_array().expect("gates");
    let gate = gates.iter().find(|g| g["name"] == name).expect("the gate");
    let text = |key: &str| gate[key].as_str().expect("a text").to_owned();
    (text("state"), text("reason"))
}

fn volume(verdict: &Value) -> f64 {
    verdict["removal"]["volume_mm3"].as_f64().expect("a volume")
}

const FANUC: &str = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 S3000 M3\nG0 G53 X150. Y0.\nG0 G53 Z240.\n\
                     G68.2 X0. Y0. Z0. I90. J30. K-90.\nG53.1\n@\nG1 Z5. F500.\nG0 Z160.\nG69\nM30\n%\n";
const HAAS: &str = "%\nO00001\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 S3000 M3\nG53 G0 X150. Y0.\nG53 G0 Z240.\nG0 B30.\nG254\n@\n\
                    G1 Z5. F500.\nG0 Z160.\nG255\nM30\n%\n";
const SIEMENS: &str = "G17 G54 G90 G94 G710\nT1 M6\nS3000 M3\nSUPA G0 X150 Y0 D0\nSUPA G0 Z240 D0\n\
                       CYCLE800(1,\"TABLE\",200000,57,0,0,0,0,30,0,0,0,0,1)\n@\nG1 Z5 F500\nG0 Z160\nCYCLE800()\nM30\n";
const KLARTEXT: &str = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000 F500\n2 CYCL DEF 247 Q339=+1\n3 M3\n4 L X+150 Y+0 R0 FMAX M91\n\
                        5 L Z+240 R0 FMAX M91\n6 PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN FMAX\n@\n9 L Z+5 F500\n10 L Z+160 FMAX\n\
                        11 PLANE RESET STAY\n12 END PGM A MM\n";

/// Language, program with a place for its approach, the approach in two blocks, and in one.
const APPROACHES: [(&str, &str, &str, &str); 4] = [
    ("fanuc", FANUC, "G0 X0. Y0.\nG43 H1 Z10.", "G0 G43 H1 X0. Y0. Z10."),
    ("haas", HAAS, "G0 X0. Y0.\nG43 H1 Z10.", "G0 G43 H1 X0. Y0. Z10."),
    ("siemens-840d", SIEMENS, "G0 X0 Y0 D1\nG0 Z10", "G0 X0 Y0 Z10 D1"),
    ("heidenhain", KLARTEXT, "7 L X+0 Y+0 FMAX\n8 L Z+10 FMAX", "7 L X+0 Y+0 Z+10 FMAX"),
];

#[test]
fn an_axis_without_a_word_stays_where_the_machine_has_it() {
    for (dialect, program, two, one) in APPROACHES {
        let run =
            |approach: &str| Shop::new(&machine(18_000), dialect, POST, &program.replace('@', approach)).verdict();
        let over = run(two);
        assert_eq!(gate(&over, "collision").0, "pass", "{dialect}: {:?}", gate(&over, "collision"));
        let through = run(one);
        assert_eq!(gate(&through, "collision").0, "fail", "{dialect}: {:?}", gate(&through, "collision"));
    }
}

/// The machine file says how rapids run, on a tilted plane too: with a slow Z the tool is next to the post
/// before it comes down.
#[test]
fn the_machine_says_how_rapids_run_on_a_plane() {
    for (dialect, program, _, one) in APPROACHES {
        let text = program.replace('@', one);
        let run = |machine: &str| gate(&Shop::new(machine, dialect, POST, &text).verdict(), "collision");
        let slow = machine(3000);
        assert_eq!(run(&slow).0, "fail", "{dialect}: {:?}", run(&slow));
        let own = slow.replace("rapid_mode = \"straight\"", "rapid_mode = \"independent\"");
        assert_eq!(run(&own).0, "pass", "{dialect}: {:?}", run(&own));
    }
}

/// The rest of the program goes on from there: an arc on the plane has its start, and a text that ends after
/// X and Y is none that is refused.
#[test]
fn lengths_found_at_x_and_y_hold_after_the_tool_length() {
    let text =
        FANUC.replace("@\nG1 Z5. F500.", "G0 X0. Y0.\nG43 H1 Z10.\nG1 Z5. F500.\nG3 X4. Y0. I2. J0.\nG91 G1 X1.\nG90");
    let verdict = Shop::new(&machine(18_000), "fanuc", POST, &text).verdict();
    assert_eq!(gate(&verdict, "collision").0, "pass", "{:?}", gate(&verdict, "collision"));
    // The tool length may come with G53.6, which turns the table about the tip.
    let about = FANUC.replace("G53.1\n@", "G53.6 H1\nG0 X150. Y0. Z160.\nG0 X0. Y0.\nG0 Z10.");
    let verdict = Shop::new(&machine(18_000), "fanuc", POST, &about).verdict();
    assert_eq!(gate(&verdict, "collision").0, "pass", "{:?}", gate(&verdict, "collision"));
    let ends = "%\nO1\nG17 G21 G90\nT1 M6\nG54\nG68.2 X0. Y0. Z0. I90. J30. K-90.\nG53.1\nG0 X0. Y0.\nM30\n%\n";
    let (code, output) = Shop::new(&machine(18_000), "fanuc", "", ends).call("nc main.nc");
    assert_eq!(code, Some(0), "{output}");
    // Feed to a place that is not known is refused.
    let feed = ends.replace("G0 X0. Y0.", "G1 X0. Y0. F100.");
    let (code, output) = Shop::new(&machine(18_000), "fanuc", "", &feed).call("nc main.nc");
    assert!(code == Some(2) && output.contains("nc-position-unknown") && output.contains("main.nc:8:"), "{output}");
}

/// PLANE with MOVE and DIST: the tool is 20 mm over the zero, and still is after the turn.
#[test]
fn plane_move_turns_the_tool_about_the_point_ahead_of_its_tip() {
    let program = |plane: &str| {
        format!(
            "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000 F500\n2 CYCL DEF 247 Q339=+1\n3 M3\n4 L X+0 Y+0 R0 FMAX\n5 L Z+20 FMAX\n{plane}\n\
             9 L Z-3 F500\n10 L Z+30 FMAX\n11 PLANE RESET STAY\n12 END PGM A MM\n"
        )
    };
    let run = |plane: &str| Shop::new(&machine(18_000), "heidenhain", "", &program(plane)).verdict();
    let turn = "6 L Z+100 FMAX\n7 PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN FMAX\n8 L X+0 Y+0 Z+20 FMAX";
    let expected = volume(&run(turn));
    assert!(expected > 20.0, "{expected}");
    for way in ["MOVE DIST20 F1000", "MOVE ABST20 FMAX SEQ+", "MOVE DIST+20 F1000 TABLE ROT", "MOVE DIST+Q1 F1000"] {
        let verdict = run(&format!("6 Q1 = 20\n7 PLANE SPATIAL SPA+0 SPB+30 SPC+0 {way}"));
        assert!((volume(&verdict) - expected).abs() < 1e-6 * expected, "{way}: {} {expected}", volume(&verdict));
    }
    let cycle = "6 CYCL DEF 19.0 BEARBEITUNGSEBENE\n7 CYCL DEF 19.1 A+0 B+30 C+0 F1000 ABST20";
    assert!((volume(&run(cycle)) - expected).abs() < 1e-6 * expected, "{} {expected}", volume(&run(cycle)));
    // From one plane to another, where the control holds the tip already: 20 mm over the zero of both.
    let again = "6 PLANE SPATIAL SPA+0 SPB+15 SPC+0 TURN FMAX\n7 L X+0 Y+0 Z+20 FMAX\n8 PLANE SPATIAL SPA+0 SPB+30 SPC+0 MOVE DIST20 F1000";
    assert!((volume(&run(again)) - expected).abs() < 1e-6 * expected, "{} {expected}", volume(&run(again)));
    // About the tip itself the tool comes to lie 20 mm aside, off the plane's zero by 20 sin 30.
    let beside = volume(&run("6 PLANE SPATIAL SPA+0 SPB+30 SPC+0 MOVE DIST0 F1000"));
    assert!((beside - expected).abs() > 1.0, "{beside} {expected}");
    let shop =
        Shop::new(&machine(18_000), "heidenhain", "", &program("6 PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN DIST20 FMAX"));
    let (code, output) = shop.call("run . --output result --rerun off");
    assert!(code == Some(2) && output.contains("DIST without MOVE") && output.contains("main.h:7:"), "{output}");
}

/// F9999 of an old program: a feed that is reported, or rapid traverse where the control file says so.
#[test]
fn the_highest_f_of_an_old_program_is_reported_or_stated() {
    let program = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 CYCL DEF 247 Q339=+1\n3 L X+0 Y+0 R0 F9999 M3\n4 L Z+10\n5 L Z-3\n\
                   6 L Z+30 F9999\n7 END PGM A MM\n";
    let shop = Shop::new(&machine(18_000), "heidenhain", "", program);
    let verdict = shop.verdict();
    let (state, reason) = gate(&verdict, "program");
    assert_eq!(state, "unchecked", "{reason}");
    let text = verdict["findings"].to_string();
    assert!(text.contains("F9999 is read as a feed") && text.contains("feed.rapid_from_mm_min"), "{text}");
    assert!(!text.contains("process-rapid-in-material"), "{text}");
    fs::write(shop.path().join("old.toml"), "dialect = \"heidenhain\"\nfeed.rapid_from_mm_min = 9999\n")
        .expect("written");
    let scene = fs::read_to_string(shop.path().join("scene.toml")).expect("a scene");
    fs::write(shop.path().join("scene.toml"), scene.replace("[stock]", "[control]\nfile = \"old.toml\"\n[stock]"))
        .expect("written");
    let text = shop.verdict()["findings"].to_string();
    assert!(text.contains("process-rapid-in-material") && !text.contains("F9999"), "{text}");
}

/// Words without effect on the path leave the program gate alone.
#[test]
fn a_word_that_moves_nothing_is_a_note() {
    let program = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nT1 M6\nG54 S500 M3\nG0 X0. Y0.\nG43 H1 Z10.\nG84 X0. Y0. Z-5. R3. F500.,R1\nG80\n\
                   G0 Z50.\nM30\n%\n";
    let verdict = Shop::new(&machine(18_000), "fanuc", "", program).verdict();
    let (state, reason) = gate(&verdict, "program");
    assert_eq!(state, "pass", "{reason}");
    assert!(verdict["findings"].to_string().contains("rigid tap and a compensating chuck"), "{}", verdict["findings"]);
}

/// A fault of a modal cycle is reported at the position, with the line of its MCALL.
#[test]
fn a_fault_of_a_modal_cycle_names_both_lines() {
    let program = "G17 G54 G90 G94 G710\nT1 D1 M6\nS3000 M3 F200\nG0 X0 Y0 Z10\nMCALL CYCLE81(10,20,2,-5)\nG0 X5\nG0 X8\n\
                   MCALL\nM30\n";
    let (code, output) = Shop::new(&machine(18_000), "siemens-840d", "", program).call("check main.mpf");
    assert_eq!(code, Some(2), "{output}");
    assert!(output.contains("main.mpf:6:") && output.contains("that of `MCALL CYCLE81` in line 5"), "{output}");
}

/// What a post writes in addition to the path is read, reported, or refused by its name with a way out.
#[test]
fn words_of_posts_are_read_reported_or_refused_by_name() {
    let check = |dialect: &str, program: &str, control: &str| {
        let file = if dialect == "siemens-840d" { "main.mpf" } else { "main.nc" };
        Shop::new(&machine(18_000), dialect, "", program).call(&format!("check {file}{control}"))
    };
    // Super-NURBS of an Okuma: its F is no feed.
    let okuma = "O1\nG15 H1\nT1 M6\nG0 X0 Y0 S100 M3\nG56 H1 Z10\nG131 F9000 J1 D0.01\nG1 Z5 F300\nG130\nM2\n";
    let (code, output) = check("okuma", okuma, " --control okuma-osp");
    assert_eq!(code, Some(0), "{output}");
    let (code, output) = check("okuma", &okuma.replace("G130", "VTOFH[1]=100"), " --control okuma-osp");
    assert!(
        code == Some(2) && output.contains("`VTOFH` is not supported") && output.contains("main.nc:8:"),
        "{output}"
    );
    for (control, word, says) in [
        ("", "G54.2 P1", "the offset that turns with the table"),
        ("", "G84.2 X1. Z-1. R1. F100.", "M29 S and G84"),
        (" --control linuxcnc-2.9", "M428", "[words] M428 = { kinematics = \"tcp-on\" }"),
        (" --control fagor-8055", "G48 S1", "tool center point here"),
        (" --control fagor-8055", "G49 X0 Y0 Z0 A0 B30 C0", "inclined plane here"),
        (" --control fanuc-30i", "#RTCP ON", "--control fagor-8055"),
        (" --control fanuc-30i", "$ENDIF", "--control fagor-8055"),
    ] {
        let (code, output) = check("fanuc", &format!("G21 G90 G54\nG0 X0. Y0. Z10.\n{word}\nM30\n"), control);
        assert!(code == Some(2) && output.contains(says) && output.contains("main.nc:3:"), "{word}: {output}");
    }
    let (code, output) = check("siemens-840d", "G17 G54 G90 G710\nT1 D1 M6\nRTLIOF\nG0 X0 Y0 Z10\nM30\n", "");
    assert_eq!(code, Some(0), "{output}");
    let siemens =
        Shop::new(&machine(18_000), "siemens-840d", "", "G17 G54 G90 G710\nT1 D1 M6\nRTLIOF\nG0 X0 Y0 Z10\nM30\n");
    let verdict = siemens.verdict();
    assert_eq!(gate(&verdict, "program").0, "unchecked");
    assert!(verdict["findings"].to_string().contains("rapid_mode"), "{}", verdict["findings"]);
}
