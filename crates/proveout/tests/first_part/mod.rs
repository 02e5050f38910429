//! A scene from a program of one's own, as a user types it: `new`, `tools`, `check`, `run`.

mod desk;
mod foreign;
mod left_out;
mod newcomers;
mod posts;
mod strangers;
mod urdf;

use std::{
    fs,
    process::{Command, Stdio},
};

use desk::{Desk, believable, gate, printed};
use serde_json::Value;

#[test]
fn a_plate_in_inch_comes_to_its_verdict() {
    let desk = Desk::new(&["plate.nc"]);
    desk.write("answers.toml", "holder = \"1.6x2.5 inch\"\nstock = \"0,0,-0.6,4,3,0 inch\"\n");
    let output = desk.done("new plate.nc --machine three-axis-mill --answers answers.toml --output plate");
    for word in
        ["unit: inch (G20 in line 8)", "face_mill D50.8", "flat D12.7", "drill D5.1054", "work offset G54", "2 answers"]
    {
        assert!(output.contains(word), "{word:?} is not in:\n{output}");
    }
    let scene = fs::read_to_string(desk.path("plate/scene.toml")).expect("written");
    assert!(scene.contains("assumed") && scene.contains("max_mm = [101.6, 76.2, 0]"), "{scene}");
    believable(&desk.verdict("plate"));
}

#[test]
fn a_program_of_840d_states_its_stock() {
    let desk = Desk::new(&["part.mpf"]);
    desk.write("answers.toml", "holder = \"40x60\"\n");
    let output = desk.done("new part.mpf --machine spinner-u5-620 --answers answers.toml --output plate");
    for word in [
        "siemens-840d",
        "WORKPIECE in line 3",
        "tool \"END_D12\": flat D12",
        "tool \"DRILL_D8\": drill D8",
        "1 answer;",
    ] {
        assert!(output.contains(word), "{word:?} is not in:\n{output}");
    }
    believable(&desk.verdict("plate"));
}

#[test]
fn a_klartext_program_states_its_blank() {
    let desk = Desk::new(&["part.h"]);
    desk.write("answers.toml", "holder = \"50x70\"\n");
    let output = desk.done("new part.h --machine three-axis-mill --answers answers.toml --output halter");
    for word in ["heidenhain", "BLK FORM in line 3", "work offset PRESET0", "flat D20", "drill D10"] {
        assert!(output.contains(word), "{word:?} is not in:\n{output}");
    }
    believable(&desk.verdict("halter"));
}

#[test]
fn five_axes_at_once_come_to_their_verdict() {
    let desk = Desk::new(&["five.nc"]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"-45,-15,-30,45,15,0\"\n");
    let output = desk.done("new five.nc --machine bc-trunnion --answers answers.toml --output five");
    for word in
        ["rotary axis B: 0.000 to 10.000", "rotary axis C: 0.000 to 45.000", "tool center point control", "ball D8"]
    {
        assert!(output.contains(word), "{word:?} is not in:\n{output}");
    }
    believable(&desk.verdict("five"));
}

#[test]
fn a_tilted_plane_comes_to_its_verdict() {
    let desk = Desk::new(&["tilted.nc"]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"-40,-20,-40,40,20,0\"\n");
    desk.done("new tilted.nc --machine bc-trunnion --answers answers.toml --output tilted");
    believable(&desk.verdict("tilted"));
}

#[test]
fn machines_are_listed_and_misspelt_ones_corrected() {
    let desk = Desk::new(&["plate.nc"]);
    let list = desk.done("new --list-machines");
    assert!(list.lines().count() >= 18 && list.contains("three-axis-mill") && list.contains("travel chosen"), "{list}");
    desk.refused("new plate.nc --machine three-axis-mil", &["three-axis-mil", "did you mean three-axis-mill?"]);
}

#[test]
fn nothing_is_taken_silently() {
    let desk = Desk::new(&["plate.nc"]);
    let output =
        desk.refused("new plate.nc --machine three-axis-mill", &["no answer for: holder, stock\n", "--answers"]);
    assert!(
        output.contains("proposed: none") && output.contains("holder = \"proposed\", stock = \"proposed\""),
        "{output}"
    );
    desk.write("answers.toml", "holder = \"none\"\nstok = \"proposed\"\n");
    desk.refused("new plate.nc --machine three-axis-mill --answers answers.toml", &["no answer for: stock"]);
    desk.write("answers.toml", "holder = \"none\"\nstock = \"proposed\"\nstok = \"1\"\n");
    desk.refused("new plate.nc --machine three-axis-mill --answers answers.toml", &["`stok`", "did you mean `stock`"]);
    desk.write("answers.toml", "holder = \"none\"\n");
    fs::create_dir(desk.path("plate")).expect("made");
    desk.refused("new plate.nc --machine three-axis-mill --answers answers.toml", &["plate is there already"]);
    desk.done("new plate.nc --machine three-axis-mill --answers answers.toml --stock proposed --output other");
}

#[test]
fn bad_input_gets_one_clear_answer() {
    let desk = Desk::new(&["plate.nc"]);
    desk.write("answers.toml", "holder = \"none\"\nstock = \"proposed\"\n");
    let new = |rest: &str| format!("new {rest} --machine three-axis-mill --answers answers.toml --output made");
    // Numbers of a multiplicative generator: as many control characters as any compressed file.
    let noise: Vec<u8> = (0..20_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8 | 1).collect();
    fs::write(desk.path("picture.nc"), noise).expect("written");
    desk.refused(&new("picture.nc"), &["picture.nc is not plain text: it looks like a binary file"]);
    desk.refused("check picture.nc", &["picture.nc is not plain text"]);
    desk.write("letter.txt", "Dear customer,\nplease find the drawing attached.\n");
    desk.refused(&new("letter.txt"), &["letter.txt"]);
    desk.write("tools.tbl", "T1 P1 D2 Z4\nT2 P2 D0.5 Z4\nT2 P3 D0.75 Z4\nT3 P4 D0.201 Z5\n");
    desk.refused(&new("plate.nc --tools tools.tbl --unit inch"), &["two tools have the number 2"]);
    desk.refused(&new("plate.nc --tools tools.tbl"), &["--unit"]);
    desk.write("far.stl", &block([500.0, 500.0, -20.0], [600.0, 570.0, 0.0]));
    desk.refused(&new("plate.nc --design far.stl"), &["far.stl", "they do not overlap"]);
    desk.refused(&new("nowhere.nc"), &["nowhere.nc"]);
    desk.refused(&new("plate.nc --control siemens-840d-sl"), &["siemens"]);
}

#[test]
#[ignore = "nightly, 40 s"]
fn a_design_in_inch_is_asked_for_and_converted_by_the_answer_alone() {
    let desk = Desk::new(&["plate.nc"]);
    desk.write("design.stl", &block([0.0, 0.0, -0.6], [4.0, 3.0, -0.02]));
    let answers = "holder = \"1.6x2.5 inch\"\nstock = \"0,0,-0.6,4,3,0 inch\"\n";
    desk.write("answers.toml", answers);
    let line = "new plate.nc --machine three-axis-mill --design design.stl --answers answers.toml --output plate";
    desk.refused(line, &["no answer for: design_unit", "25.4 times"]);
    desk.write("answers.toml", &format!("{answers}design_unit = \"mm\"\n"));
    desk.refused(line, &["they do not overlap"]);
    desk.write("answers.toml", &format!("{answers}design_unit = \"inch\"\n"));
    desk.done(line);
    let verdict = desk.verdict("plate");
    // The face is at its height; pocket and holes are not in this design.
    assert_eq!(gate(&verdict, "gouge").0, "fail", "{:?}", gate(&verdict, "gouge"));
    assert_eq!(gate(&verdict, "excess").0, "pass", "{:?}", gate(&verdict, "excess"));
}

/// A block as STL text.
fn block(min: [f64; 3], max: [f64; 3]) -> String {
    let corner = |k: usize| [0, 1, 2].map(|bit| if k >> bit & 1 == 1 { max[bit] } else { min[bit] });
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

#[test]
fn libraries_of_others_become_libraries_of_ours() {
    let desk = Desk::new(&["plate.nc"]);
    desk.write("shop.tbl", "T1 P1 D2 Z4 ;face mill\nT2 P2 D0.5 Z4 ;4FL end mill\nT3 P4 D0.201 Z5 ;drill\n");
    let output = desk.done("tools shop.tbl --unit inch --holder 40x60 --output tools.toml");
    assert!(output.contains("3 tools from a LinuxCNC tool table"), "{output}");
    desk.refused("tools shop.tbl --unit inch --output tools.toml", &["tools.toml already exists"]);
    desk.refused("tools shop.tbl --unit inch --number 9 --output other.toml", &["no tool 9"]);
    desk.done("check tools.toml");
    desk.write("answers.toml", "stock = \"0,0,-0.6,4,3,0 inch\"\n");
    desk.done("new plate.nc --machine three-axis-mill --tools tools.toml --answers answers.toml --output plate");
    believable(&desk.verdict("plate"));
}

/// The plate on its machine, with its program and scene changed.
fn changed(program: impl Fn(String) -> String, scene: impl Fn(String) -> String) -> Desk {
    let desk = Desk::new(&["plate.nc", "answers.toml"]);
    let text = fs::read_to_string(desk.path("plate.nc")).expect("there");
    desk.write("plate.nc", &program(text));
    desk.done("new plate.nc --machine three-axis-mill --answers answers.toml --output plate");
    let text = fs::read_to_string(desk.path("plate/scene.toml")).expect("there");
    desk.write("plate/scene.toml", &scene(text));
    desk
}

/// Causes that `check` reports, the first of them first; a run reports the same before it begins.
fn causes(desk: &Desk) -> String {
    let output = desk.done("check plate");
    let run = desk.call("run plate --rerun off --output out/plate");
    let stderr = String::from_utf8_lossy(&run.stderr).into_owned();
    for line in output.lines().filter_map(|l| l.split_once("before the run, ")) {
        assert!(stderr.contains(line.1), "{} is not in:\n{stderr}", line.1);
    }
    output
}

#[test]
fn an_orderly_scene_has_no_cause_but_what_is_chosen() {
    let desk = changed(|p| p, |s| s);
    let output = causes(&desk);
    assert!(!output.contains("before the run") && output.contains("note: the travel of Y, X, Z"), "{output}");
}

#[test]
#[ignore = "nightly, 200 s"]
fn a_length_that_is_not_active_is_one_cause_with_its_line() {
    let desk = changed(|p| p.replace("G43 ", ""), |s| s);
    let output = causes(&desk);
    // Z reaches the cuts without a length from 130 mm on; 89 mm is the gauge length of T1.
    for word in [
        "1: tool length compensation is not active while T1, T2, T3 cut (lines",
        "write G43 H1",
        "[work_offsets.G54] Z_mm = 219",
    ] {
        assert!(output.contains(word), "{word:?} is not in:\n{output}");
    }
}

#[test]
fn positions_of_the_machine_outside_of_travel_are_reported_with_the_other_zero() {
    let desk = changed(|p| p, |s| s);
    // Changed after the scene was made, which would have taken another zero.
    let text = fs::read_to_string(desk.path("plate.nc")).expect("there");
    desk.write("plate.nc", &text.replacen("G28 G91 Z0.", "G53 G0 Z0.", 1));
    let output = causes(&desk);
    let words = ["1: Z is sent to 0.000 mm of the machine", "line 9", "chosen in the machine file", "zero = \"home\""];
    for word in words {
        assert!(output.contains(word), "{word:?} is not in:\n{output}");
    }
    assert!(!output.contains("before the run, 2"), "where it still stands is no cause of its own:\n{output}");
    let verdict = desk.verdict("plate");
    let findings = verdict["findings"].as_array().expect("findings");
    let over = findings.iter().find(|f| f["code"] == "limits-overtravel").expect("overtravel");
    assert!(
        over["message"].as_str().is_some_and(|m| m.contains("chosen in the machine file, not published")),
        "{over}"
    );
}

#[test]
#[ignore = "nightly, 49 s"]
fn cuts_that_miss_the_stock_or_plunge_into_it_are_reported_with_the_shift() {
    let desk = changed(|p| p, |s| s.replace("X_mm = -50.8", "X_mm = 200"));
    let output = causes(&desk);
    assert!(
        output.contains("no motion in feed meets the stock") && output.contains("G54 shifted by about -2"),
        "{output}"
    );
    let desk = changed(|p| p, |s| s.replace("Z_mm = 65.24", "Z_mm = 55.24"));
    // The face mill begins next to the stock; the end mill is what plunges, but the first tool is looked at
    // alone.
    let output = causes(&desk);
    assert!(!output.contains("no motion in feed"), "{output}");
    let desk = changed(|p| p.replace("X-1.2 Y0.75", "X1. Y0.75"), |s| s.replace("Z_mm = 65.24", "Z_mm = 55.24"));
    let output = causes(&desk);
    // Z0.2 inch, 10 mm lower: 4.92 mm below the top.
    assert!(output.contains("T1 goes down in rapid into the stock before its first cut: 4.920 mm"), "{output}");
}

/// Numbers of a hint after a word of it.
fn hinted(text: &str, word: &str) -> Vec<f64> {
    let rest = text.split(word).nth(1).unwrap_or_else(|| panic!("{word:?} is not in:\n{text}"));
    rest.split([' ', ','])
        .map_while(|w| if w.is_empty() { Some(None) } else { w.parse().ok().map(Some) })
        .flatten()
        .collect()
}

/// A key of the scene with another value.
fn put(desk: &Desk, old: &str, new: &str) {
    let scene = fs::read_to_string(desk.path("plate/scene.toml")).expect("there");
    assert!(scene.contains(old), "{old:?} is not in:\n{scene}");
    desk.write("plate/scene.toml", &scene.replace(old, new));
}

/// What a hint says is what mends it: its numbers are written where it says so, and nothing is left to
/// report.
#[test]
fn each_hint_with_a_number_resolves_its_cause() {
    let clean = |desk: &Desk| {
        let output = desk.done("check plate");
        assert!(!output.contains("before the run"), "{output}");
    };
    let desk = changed(|p| p, |s| s.replace("X_mm = -50.8", "X_mm = 200"));
    let shift = hinted(&desk.done("check plate"), "G54 shifted by about ");
    put(&desk, "X_mm = 200", &format!("X_mm = {}", 200.0 + shift[0]));
    clean(&desk);
    let desk = changed(|p| p.replace("X-1.2 Y0.75", "X1. Y0.75"), |s| s.replace("Z_mm = 65.24", "Z_mm = 55.24"));
    let higher = hinted(&desk.done("check plate"), "G54 with Z_mm ");
    put(&desk, "Z_mm = 55.24", &format!("Z_mm = {}", 55.24 + higher[0]));
    clean(&desk);
    let beyond = |s: String| s.replace("X_mm = -50.8", "X_mm = 349.2").replace("[-50.8, ", "[349.2, ");
    let desk = changed(|p| p, beyond);
    let further = hinted(&desk.done("check plate"), "a mounting and a work offset that are ");
    let x = 349.2 + further[0];
    put(&desk, "X_mm = 349.2", &format!("X_mm = {x}"));
    put(&desk, "[349.2, ", &format!("[{x}, "));
    clean(&desk);
    // Lengths that come with the tool, as the control file of the hint has it.
    let desk = changed(|p| p.replace("G43 ", ""), |s| s);
    let output = desk.done("check plate");
    for word in ["inherits = \"fanuc-0i\"", "without_h = \"tool\"", "M6 = { does = \"M6 G43\" }"] {
        assert!(output.contains(word), "{word} is not in:\n{output}");
    }
    desk.write(
        "shop.toml",
        "inherits = \"fanuc-0i\"\n[tool_length]\nwithout_h = \"tool\"\n[words]\nM6 = { does = \"M6 G43\" }\n",
    );
    desk.done("new plate.nc --machine three-axis-mill --control shop.toml --answers answers.toml --output with-tool");
    let output = desk.done("check with-tool");
    assert!(!output.contains("before the run"), "{output}");
    let verdict = desk.verdict("with-tool");
    believable(&verdict);
}

#[test]
#[ignore = "nightly, 63 s"]
fn a_design_in_inch_is_reported_before_the_run_and_never_converted() {
    let desk = changed(|p| p, |s| s.replace("[[program]]", "[part]\nmesh = \"../design.stl\"\n\n[[program]]"));
    desk.write("design.stl", &block([0.0, 0.0, -0.6], [4.0, 3.0, -0.02]));
    let words = ["25.4 times smaller than the stock", "its numbers look like inches", "mesh_unit = \"inch\""];
    for call in ["check plate", "run plate --rerun off --output out"] {
        desk.refused(call, &words);
    }
    // The unit that the scene states is no longer asked for.
    let scene = fs::read_to_string(desk.path("plate/scene.toml")).expect("there");
    desk.write("plate/scene.toml", &scene.replace("[part]\n", "[part]\nmesh_unit = \"inch\"\n"));
    let output = causes(&desk);
    assert!(!output.contains("times smaller"), "{output}");
}

#[test]
fn a_program_without_a_tool_call_is_asked_for_its_tool() {
    let desk = Desk::new(&[]);
    desk.write(
        "slot.nc",
        "%\nG21 G90 G17\nG54\nS3000 M3\nG0 X-20. Y10.\nZ5.\nG1 Z-2. F200.\nX70. F500.\nG0 Z20.\nM30\n%\n",
    );
    desk.write(
        "answers.toml",
        "holder = \"40x60\"\nstock = \"0,0,-20,50,20,0\"\nstart_tool = 1\ntool.T1 = \"flat D10 L25\"\n",
    );
    let output = desk.done("new slot.nc --machine three-axis-mill --answers answers.toml --output slot");
    assert!(output.contains("the zero is assumed at the tip of the tool"), "{output}");
    let verdict = desk.verdict("slot");
    believable(&verdict);
    assert_eq!(verdict["tools"][0]["number"], 1, "{}", verdict["tools"]);
    // A slot of 10 x 2 mm along 50 mm.
    let volume = verdict["removal"]["volume_mm3"].as_f64().expect("a volume");
    assert!((volume - 1000.0).abs() < 1.0, "{volume}");
    // Without the tool the cause is reported, and the run fails.
    let scene = fs::read_to_string(desk.path("slot/scene.toml")).expect("there").replace("[start]\ntool = 1\n", "");
    desk.write("slot/scene.toml", &scene);
    let output = desk.done("check slot");
    assert!(
        output.contains("cuts with no tool in the spindle (line 7)") && output.contains("[start] tool = 1"),
        "{output}"
    );
    desk.write("slot/scene.toml", &(scene + "[start]\ntool = 9\n"));
    desk.refused("check slot", &["start.tool = 9"]);
}

#[test]
fn a_setup_in_inch_gives_what_the_same_one_gives_in_millimeters() {
    let desk = Desk::new(&[]);
    desk.write(
        "slot.nc",
        "%\nG20 G90 G17\nT1 M6\nG54\nS3000 M3\nG0 X-1. Y.5\nG43 H1 Z.5\nG1 Z-.125 F20.\nX3. F40.\nG0 Z1.\nM30\n%\n",
    );
    let tools = "[[tool]]\nnumber = 1\nname = \"END\"\nkind = \"flat\"\ndiameter_mm = 12.7\nflute_length_mm = 25.4\ngauge_length_mm = 101.6\n\
                 [tool.holder]\nsections = [{ diameter_mm = 50.8, length_mm = 50.8 }]\n";
    let scene = "name = \"slot\"\nmachine = \"machines/three-axis-mill\"\ntools = \"tools.toml\"\nresolution_mm = 0.508\n[stock]\nbox = { min_mm = [0, 0, -25.4], \
                 max_mm = [50.8, 25.4, 0] }\n[mount]\ntranslation_mm = [0, 0, 101.6]\n[work_offsets.G54]\nZ_mm = 101.6\n[[program]]\nname = \"slot\"\nfile = \"slot.nc\"\n";
    let inch = |text: &str| {
        let mut out = String::from("unit = \"inch\"\n");
        for line in text.lines() {
            let Some((key, values)) = line.split_once('=').filter(|_| line.contains("_mm")) else {
                out += &format!("{line}\n");
                continue;
            };
            // Every number of a line with lengths.
            let mut number = String::new();
            let put = |out: &mut String, number: &mut String| {
                let value = number.parse::<f64>().map_or(number.clone(), |v| (v / 25.4).to_string());
                out.push_str(&value);
                number.clear();
            };
            out += &format!("{}=", key.replace("_mm", "_inch"));
            for c in values.replace("_mm", "_inch").chars() {
                if c.is_ascii_digit() || matches!(c, '.' | '-') {
                    number.push(c);
                } else {
                    put(&mut out, &mut number);
                    out.push(c);
                }
            }
            put(&mut out, &mut number);
            out.push('\n');
        }
        out
    };
    for (folder, scene, tools) in [("in-mm", scene.to_owned(), tools.to_owned()), ("in-inch", inch(scene), inch(tools))]
    {
        fs::create_dir(desk.path(folder)).expect("made");
        desk.write(&format!("{folder}/tools.toml"), &tools);
        let scene = scene.replace("machines/", "../machines/").replace("slot.nc", "../slot.nc");
        desk.write(&format!("{folder}/scene.toml"), &scene);
    }
    let [mm, inch] = ["in-mm", "in-inch"].map(|scene| desk.verdict(scene));
    let volume = |v: &Value| v["removal"]["volume_mm3"].as_f64().expect("a volume");
    // 12.7 x 3.175 mm along 50.8 mm; rays along the walls of the slot are touched and not cut.
    assert!((volume(&mm) / (12.7 * 3.175 * 50.8) - 1.0).abs() < 0.1, "{}", volume(&mm));
    assert!((volume(&mm) - volume(&inch)).abs() < 1e-6, "{} {}", volume(&mm), volume(&inch));
    assert_eq!(mm["gates"], inch["gates"]);
    // A file counts in one unit, and says which.
    let text = fs::read_to_string(desk.path("in-inch/scene.toml")).expect("there");
    desk.write("in-inch/scene.toml", &text.replace("Z_inch = 4", "Z_mm = 101.6"));
    desk.refused("check in-inch", &["`Z_mm` is in millimeters", "write `Z_inch`", "scene.toml:11"]);
    desk.write("in-inch/scene.toml", &text.replace("unit = \"inch\"\n", ""));
    desk.refused("check in-inch", &["is in inch, but the file does not state inch", "unit = \"inch\""]);
}

#[test]
fn a_configuration_of_linuxcnc_becomes_a_machine_that_runs() {
    let desk = Desk::new(&["plate.nc", "answers.toml", "bench.ini"]);
    let output = desk.done("machine bench.ini --table-axes XY --output bench");
    assert!(
        output.contains("X Y table, Z tool; X 508, Y 305, Z 457; travel from LinuxCNC INI file")
            && output.contains("note: the machine has no bodies"),
        "{output}"
    );
    desk.done("check bench");
    desk.done("new plate.nc --machine bench --answers answers.toml --output plate");
    let verdict = desk.verdict("plate");
    // The file states no jerk, and there are no bodies: nothing fails, and nothing passes unseen.
    let (state, reason) = gate(&verdict, "limits");
    assert!(state == "unchecked" && reason.contains("jerk"), "{state}: {reason}");
    desk.refused("machine bench.ini --output bench", &["bench already exists"]);
    desk.refused("machine bench.ini --table-axes XQ --output other", &["Q is not a linear axis"]);
    desk.refused("machine plate.nc --output other", &["is neither a LinuxCNC INI file"]);
}

#[test]
fn every_open_question_is_reported_at_once() {
    let desk = Desk::new(&[]);
    // A tool without a description, a second offset, a turned table, no stock, no holder.
    desk.write(
        "bare.nc",
        "%\nO1\nG21 G90 G17 G94\nT7 M6\nS3000 M3\nG54\nG0 X0. Y0.\nG43 H7 Z20.\nG1 Z-1. F100.\nX50.\nG55\nC90.\nG1 X10.\nG0 Z20.\nM30\n%\n",
    );
    let output = desk.refused(
        "new bare.nc --machine bc-trunnion",
        &["no answer for: tool.T7, holder, offset.G55, mount, stock\n", "proposed: 0,0,0"],
    );
    // Without the tool it is not known how wide the cuts are.
    assert!(output.contains("stock = \"...\""), "{output}");
    desk.write(
        "answers.toml",
        "holder = \"none\"\nstock = \"0,-20,-10,50,20,0\"\nmount = \"proposed\"\n\"tool.T7\" = \"flat D10 L25\"\n\"offset.G55\" = \"0,0,0\"\n",
    );
    desk.done("new bare.nc --machine bc-trunnion --answers answers.toml --output bare");
}

/// Three questions, whatever the number of zeros and of tools that the text does not describe.
#[test]
fn several_zeros_and_several_tools_are_one_question_each() {
    let desk = Desk::new(&[]);
    let at = |zero: &str, tool: u32| {
        format!(
            "T{tool} M6\nS3000 M3\n{zero}\nG0 X-20. Y10.\nG43 H{tool} Z20.\nG0 Z5.\nG1 Z-2. F100.\nX70. F500.\nG0 Z20.\n"
        )
    };
    let text = format!("%\nO1\nG21 G90 G17 G94\n{}{}{}M30\n%\n", at("G54", 3), at("G55", 7), at("G56", 3));
    desk.write("vises.nc", &text);
    let call = "new vises.nc --machine three-axis-mill";
    desk.refused(call, &["no answer for: tools, holder, offsets, stock\n", "proposed: G55: 0,0,0; G56: 0,0,0"]);
    let answers = |tools: &str, offsets: &str| {
        desk.write(
            "answers.toml",
            &format!(
                "tools = \"{tools}\"\nholder = \"none\"\noffsets = \"{offsets}\"\nstock = \"-20,0,-20,70,100,0\"\n"
            ),
        );
    };
    let call = &format!("{call} --answers answers.toml --output vises");
    answers("T3: flat D10 L25", "G55: 0,40,0; G56: 0,70,0");
    desk.refused(call, &["`tools`: T7 is missing"]);
    answers("T3: flat D10 L25; T7: cube D3", "G55: 0,40,0; G56: 0,70,0");
    desk.refused(call, &["\"cube D3\" is not a tool"]);
    answers("T3: flat D10 L25; T7: ball D8", "G55: 0,40,0; G57: 0,70,0");
    desk.refused(call, &["`offsets`: there is no question for \"G57\": it is one of G55, G56"]);
    answers("T3: flat D10 L25; T7: ball D8", "G56: 0,70,0; G55: 0,40,0");
    let output = desk.done(call);
    assert!(output.contains("tool T7: ball D8") && output.contains("4 answers"), "{output}");
    let scene = fs::read_to_string(desk.path("vises/scene.toml")).expect("written");
    let y = |word: &str| -> f64 {
        let table = scene.split(&format!("[work_offsets.{word}]")).nth(1).expect("the offset");
        let line = table.lines().skip(1).take_while(|l| !l.starts_with('[')).find_map(|l| l.strip_prefix("Y_mm = "));
        line.map_or(0.0, |v| v.split(' ').next().unwrap_or_default().parse().expect("a number"))
    };
    assert!((y("G55") - y("G54") - 40.0).abs() < 1e-9 && (y("G56") - y("G54") - 70.0).abs() < 1e-9, "{scene}");
    // One of them known by its own key, the other one asked for alone.
    desk.write(
        "answers.toml",
        "tools = \"T3: flat D10; T7: ball D8\"\nholder = \"none\"\noffset.G55 = \"0,40,0\"\nstock = \"proposed\"\n",
    );
    desk.refused(call.replace("--output vises", "--output again").as_str(), &["no answer for: offset.G56\n"]);
}

fn json(text: &[u8]) -> Value {
    serde_json::from_slice(text).unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(text)))
}

#[test]
fn programs_that_read_get_json_and_nothing_else_on_the_standard_output() {
    let desk = Desk::new(&["plate.nc"]);
    let machines = json(&desk.call("new --list-machines --json").stdout);
    let mill = machines.as_array().expect("a list").iter().find(|m| m["name"] == "three-axis-mill").expect("there");
    let z = mill["joints"].as_array().expect("joints").iter().find(|j| j["name"] == "Z").expect("Z");
    assert_eq!((z["unit"].as_str(), z["travel_chosen"].as_bool()), (Some("mm"), Some(true)), "{z}");
    // Open questions, with the error next to them.
    let call = desk.call("new plate.nc --machine three-axis-mill --json");
    assert_eq!(call.status.code(), Some(2));
    let open = json(&call.stdout);
    let keys: Vec<&str> = open["open"].as_array().expect("open").iter().filter_map(|q| q["key"].as_str()).collect();
    assert_eq!(keys, ["holder", "stock"]);
    assert!(open["open"][1]["proposed"].as_str().is_some_and(|p| p.split(',').count() == 6), "{open}");
    assert!(String::from_utf8_lossy(&call.stderr).contains("error: no answer for: holder, stock"));
    desk.write("answers.toml", "holder = \"1.6x2.5 inch\"\nstock = \"0,0,-0.6,4,3,0 inch\"\n");
    let made =
        json(&desk.call("new plate.nc --machine three-axis-mill --answers answers.toml --output plate --json").stdout);
    assert_eq!((made["output"].as_str(), made["answers"].as_u64()), (Some("plate"), Some(2)), "{made}");
    assert_eq!(made["scene"]["stock"]["max_mm"].to_string(), "[101.6,76.19999999999999,0.0]", "{made}");
    assert_eq!(made["scene"]["tools"][1]["diameter_mm"].as_f64(), Some(12.7), "{made}");
    // A cause of findings, and an error with its place.
    let text = fs::read_to_string(desk.path("plate.nc")).expect("there");
    desk.write("plate.nc", &text.replace("G43 ", ""));
    desk.write("wrong.nc", "%\nO1\nG21 G90\nG1 X1. F100.\nG2 X5. Y5.\nM30\n%\n");
    let call = desk.call("check plate wrong.nc --json");
    assert_eq!(call.status.code(), Some(2), "{}", printed(&call));
    let found = json(&call.stdout);
    assert_eq!((found[0]["kind"].as_str(), found[0]["in_order"].as_bool()), (Some("scene"), Some(true)), "{found}");
    let cause = &found[0]["programs"][0]["causes"][0];
    assert!(cause["what"].as_str().is_some_and(|w| w.contains("tool length compensation is not active")), "{cause}");
    assert!(cause["add"].as_str().is_some_and(|a| a.contains("G43 H1")) && cause["note"] == false, "{cause}");
    let error = &found[1]["errors"][0];
    assert!(found[1]["in_order"] == false && error["line"] == 5 && error["message"].is_string(), "{found}");
    assert!(call.stderr.is_empty(), "{}", printed(&call));
}

/// What is wrong with the call, before anything is looked at.
#[test]
fn what_is_neither_file_nor_folder_is_refused_as_such() {
    let desk = Desk::new(&[]);
    desk.refused("check /dev/null", &["/dev/null is neither a file nor a folder"]);
    desk.refused("check nowhere.nc", &["nowhere.nc does not exist"]);
}

/// A program without a word for a tool length: heights are those of the tips.
#[test]
fn without_g43_the_stock_is_where_the_program_cuts() {
    let desk = Desk::new(&["plate.nc"]);
    let text = fs::read_to_string(desk.path("plate.nc")).expect("there").replace("G43 ", "");
    desk.write("plate.nc", &text);
    let output = desk.refused("new plate.nc --machine three-axis-mill", &["no answer for: holder, stock"]);
    let stock = |output: &str| output.split("proposed: ").nth(2).and_then(|t| t.lines().next()).map(str::to_owned);
    // What the same program is proposed with its lengths.
    let with =
        Desk::new(&["plate.nc"]).refused("new plate.nc --machine three-axis-mill", &["no answer for: holder, stock"]);
    assert!(stock(&output).is_some() && stock(&output) == stock(&with), "{:?} {:?}", stock(&output), stock(&with));
    desk.write("answers.toml", "holder = \"1.6x2.5 inch\"\nstock = \"proposed\"\n");
    desk.done("new plate.nc --machine three-axis-mill --answers answers.toml --output plate");
    let scene = fs::read_to_string(desk.path("plate/scene.toml")).expect("written");
    assert!(scene.contains("tool length compensation is never active (no G43)"), "{scene}");
    // Three tools cannot all be right, and `check` says so.
    assert!(desk.done("check plate").contains("1: tool length compensation is not active while T1, T2, T3 cut"));
}

/// One tool alone: its zero is taken at its tip, assumed and reported, and the run cuts what the program
/// says.
#[test]
fn a_program_of_one_tool_without_g43_counts_from_its_tip() {
    let desk = Desk::new(&[]);
    desk.write(
        "one.nc",
        "%\nO1\n(T1 D=10. CR=0. - ZMIN=-3. - FLAT END MILL)\nG21 G90 G17 G94\nT1 M6\nS3000 M3\nG54\nG0 X-20. Y10.\nZ20.\nG1 Z-3. F100.\nX70. F500.\n\
         G0 Z20.\nM30\n%\n",
    );
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,0,-20,50,20,0\"\n");
    let output = desk.done("new one.nc --machine three-axis-mill --answers answers.toml --output one");
    assert!(output.contains("the zero is assumed at the tip of the tool"), "{output}");
    let output = desk.done("check one");
    assert!(
        !output.contains("before the run") && output.contains("note: tool length compensation is never active"),
        "{output}"
    );
    let verdict = desk.verdict("one");
    believable(&verdict);
    // A slot of 10 x 3 x 50 mm.
    let volume = verdict["removal"]["volume_mm3"].as_f64().expect("a volume");
    assert!((volume / 1500.0 - 1.0).abs() < 0.02, "{volume}");
}

/// The questions at a terminal: `script` of util-linux gives the program one.
#[test]
fn a_terminal_is_asked_and_an_empty_line_takes_the_proposal() {
    if Command::new("script").arg("--version").output().is_err() {
        // Past the capture of the harness.
        use std::io::Write as _;
        writeln!(std::io::stderr(), "LEFT OUT: the dialogue at a terminal: `script` (util-linux) is not installed")
            .ok();
        return;
    }
    let desk = Desk::new(&["plate.nc"]);
    let line = format!("{} new plate.nc --machine three-axis-mill --output plate", env!("CARGO_BIN_EXE_proveout"));
    let mut child = Command::new("script")
        .current_dir(desk.0.path())
        .args(["-qec", &line, "/dev/null"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a terminal");
    use std::io::Write as _;
    child.stdin.as_mut().expect("input").write_all(b"1.6x2.5 inch\n\n").expect("typed");
    let output = child.wait_with_output().expect("ended");
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    for word in
        ["holder: What holder", "press Enter to accept: none", "stock: What is the stock?", "2 answers; written: plate"]
    {
        assert!(shown.contains(word), "{word:?} is not in:\n{shown}");
    }
    let scene = fs::read_to_string(desk.path("plate/scene.toml")).expect("written");
    assert!(scene.contains("assumed: the space that the cutters reach"), "{scene}");
}
