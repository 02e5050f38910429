//! Programs and files as people bring them who have never seen this program: what was once taken for
//! something else, refused, or explained in words that led nowhere.

use std::fs;

use super::desk::{Desk, believable, gate, printed};

const MILL: &str = "--machine three-axis-mill --answers answers.toml";

/// A closed block as STL text.
fn block(min: [f64; 3], max: [f64; 3]) -> String {
    let p = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { max[k] } else { min[k] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid block\n");
    for [a, b, c, d] in faces {
        for corners in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in corners.map(p) {
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid block\n"
}

/// A program in inches that drills with T2, described by a comment in line 2.
fn drills(comment: &str) -> String {
    format!(
        "O1\n({comment})\nG20 G90 G17 G40 G80\nT2 M6\nG54 G0 X0 Y0 S2000 M3\nG43 H2 Z1.\nG81 G98 X0. Y0. Z-.4 R.1 F8.\nX1.\nG80\nG0 Z1.\nM30\n"
    )
}

#[test]
fn the_size_of_a_tool_is_no_number_of_something_else() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"-0.5,-0.5,-0.75,1.5,0.5,0 inch\"\n");
    for (n, (comment, words)) in [
        // Names of sizes, and not seven inches.
        ("T2 | NO. 7 DRILL | H2", "T2: drill D5.1054"),
        ("T2 F DRILL", "T2: drill D6.5278"),
        ("T2 - 10-32 TAP", "T2: tap D4.826"),
        // The count of the operation is no diameter.
        ("OPER: 9  TOOL: 2  0.25 DIA DRILL", "T2: drill D6.35"),
        ("T1 = 1/2 EM  T2 = 1/4 DRILL", "T2: drill D6.35"),
    ]
    .into_iter()
    .enumerate()
    {
        desk.write(&format!("n{n}.nc"), &drills(comment));
        let output = desk.done(&format!("new n{n}.nc {MILL} --output n{n}"));
        assert!(output.contains(words), "{words}: {output}");
    }
    // What only may be a size is asked for.
    desk.write("seven.nc", &drills("T2 7 DRILL"));
    desk.refused(&format!("new seven.nc {MILL} --output seven"), &["no answer for: tool.T2"]);
}

#[test]
fn a_comment_right_behind_a_change_is_of_the_tool_that_has_come() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,-1,-1,3,1,0 inch\"\n");
    let text = "O7\nG20 G90 G17 G40 G80\nT1 M6\n(1/2 ENDMILL)\nT2\nG54 G0 X-.5 Y0. S5000 M3\nG43 H1 Z1.\nZ.1\nG1 Z-.2 F20.\nX3.5\nG0 Z1.\n\
                T2 M6\n(1/4 DRILL)\nT1\nG54 G0 X1. Y.5 S2000 M3\nG43 H2 Z1.\nG81 G98 X1. Y.5 Z-.5 R.1 F8.\nG80\nM30\n";
    desk.write("behind.nc", text);
    let output = desk.done(&format!("new behind.nc {MILL} --output behind"));
    assert!(output.contains("T1: flat D12.7") && output.contains("T2: drill D6.35"), "{output}");
    believable(&desk.verdict("behind"));
    // Lists with a number of their own, and German ones with a comma.
    desk.write(
        "list.nc",
        "(1 = End Mill {1/4 inch})\n(2 = V-Bit {90 deg 0.5\"})\nG20 G90\nT1 M6\nG0 X-.5 Y0. S5000 M3\nG43 H1 Z1.\nG1 Z-.1 F20.\nX3.5\nG0 Z1.\nT2 M6\n\
         G0 X-.5 Y.5 S5000 M3\nG43 H2 Z1.\nG1 Z-.1 F20.\nX3.5\nG0 Z1.\nM30\n",
    );
    let output = desk.done(&format!("new list.nc {MILL} --output list"));
    assert!(output.contains("T1: flat D6.35") && output.contains("T2: chamfer D12.7"), "{output}");
    desk.write("answers.toml", "holder = \"40x60\"\n");
    desk.write(
        "wkz.h",
        "0 BEGIN PGM WKZ MM\n1 BLK FORM 0.1 Z X-40 Y-40 Z-60\n2 BLK FORM 0.2 X+40 Y+40 Z+0\n3 ;WKZ 12 = SCHAFTFRAESER D20\n4 ;WKZ 21 = BOHRER D8,5\n\
         5 TOOL CALL 12 Z S3200\n6 L X-60 Y+0 R0 FMAX M3\n7 L Z+2 FMAX\n8 L Z-5 F400\n9 L X+60 F800\n10 L Z+50 FMAX\n11 TOOL CALL 21 Z S2500\n\
         12 L X+0 Y+20 R0 FMAX M3\n13 L Z+2 FMAX\n14 L Z-12 F200\n15 L Z+50 FMAX\n16 M30\n17 END PGM WKZ MM\n",
    );
    let output = desk.done(&format!("new wkz.h {MILL} --output wkz"));
    assert!(output.contains("T12: flat D20") && output.contains("T21: drill D8.5"), "{output}");
}

#[test]
fn a_program_that_names_no_tool_is_asked_for_the_tool_alone() {
    let desk = Desk::new(&[]);
    let text = "(Rosette)\nG17\nG21\nG90\nG0Z20.32\nS16000M3\nG0X10Y10Z5\nG1Z-1.5F600\nX90F1800\nG0Z20.32\nM2\n";
    desk.write("router.gcode", text);
    desk.refused("new router.gcode --machine three-axis-mill", &["no answer for: tool.T1, holder, stock\n"]);
    // All comments of a text without a call describe one tool.
    desk.write("told.gcode", &text.replace("Rosette", "TC: 5mm Endmill"));
    desk.write("answers.toml", "holder = \"none\"\nstock = \"0,0,-12,100,20,0\"\n");
    let output = desk.done(&format!("new told.gcode {MILL} --output told"));
    assert!(output.contains("T1: flat D5"), "{output}");
    let scene = fs::read_to_string(desk.path("told/scene.toml")).expect("written");
    assert!(scene.contains("the program names no tool"), "{scene}");
}

#[test]
fn a_hole_in_a_large_plate_has_its_design_in_inches() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,0,-0.5,2,2,0 inch\"\n");
    desk.write("plate.stl", &block([0.0, 0.0, -0.5], [2.0, 2.0, 0.0]));
    let text = "O33\n(T20 | 3/8 FLAT ENDMILL | H20)\nG20 G90 G17 G40 G80\nT20 M6\nG54 G0 X1. Y1. S6500 M3\nG43 H20 Z1.\nG1 Z-.2 F10.\n\
                X1.1 F20.\nG3 X1.1 Y1. I-.1 J0.\nG1 X1.\nG0 Z1.\nM30\n";
    desk.write("hole.nc", text);
    desk.refused(
        &format!("new hole.nc {MILL} --design plate.stl --output hole"),
        &["no answer for: design_unit", "counts in inch by G20"],
    );
}

#[test]
fn a_program_that_sets_its_own_zero_is_mounted_there() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,0,-20,80,20,0\"\n");
    let cuts = "S2500 M3\nG0 X-15. Y10.\nG43 H1 Z50.\nZ2.\nG1 Z-4. F250.\nX95. F600.\nG0 Z50.\nM5\nG91 G28 Z0\nM30\n";
    // The zero as a number of the program, from home.
    desk.write(
        "g10.nc",
        &format!(
            "O6\n(T1 | 16. FLAT ENDMILL | H1)\nG21 G90 G17 G40 G80\nG10 L2 P1 X-50. Y-30. Z-400.\nT1 M6\nG54\n{cuts}"
        ),
    );
    let output = desk.done(&format!("new g10.nc {MILL} --output g10"));
    assert!(output.contains("as the program says, line") && output.contains("(G10)"), "{output}");
    assert!(!desk.done("check g10").contains("meets the stock"), "{}", desk.done("check g10"));
    let cut = |scene: &str| {
        let verdict = desk.verdict(scene);
        believable(&verdict);
        verdict["removal"]["volume_mm3"].as_f64().expect("a volume")
    };
    // A slot of 16 x 4 x 80 mm, 50 cells wide.
    let volume = cut("g10");
    assert!((volume / 5120.0 - 1.0).abs() < 0.04, "{volume}");
    // By the place where the machine is.
    desk.write(
        "g92.nc",
        &format!("O7\n(T1 16MM ENDMILL)\nG21 G90 G17 G40 G80\nG28 Z0\nG28 X0 Y0\nG92 X20. Y200. Z400.\nT1 M6\n{cuts}"),
    );
    let output = desk.done(&format!("new g92.nc {MILL} --output g92"));
    assert!(output.contains("as the program says") && output.contains("G92"), "{output}");
    let volume = cut("g92");
    assert!((volume / 5120.0 - 1.0).abs() < 0.04, "{volume}");
    // Without a length the tip hangs below.
    desk.write("bare.nc", &fs::read_to_string(desk.path("g92.nc")).expect("there").replace("G43 H1 ", ""));
    desk.done(&format!("new bare.nc {MILL} --output bare"));
    let volume = cut("bare");
    assert!((volume / 5120.0 - 1.0).abs() < 0.04, "{volume}");
}

#[test]
fn a_retract_just_past_a_travel_that_was_chosen_keeps_the_others_at_home() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"-0.5,-0.5,-0.75,1.5,0.5,0 inch\"\n");
    // X of this machine has its home in the middle and reaches 14.96 inches from it.
    desk.write("vf2.nc", &drills("T2 1/4 DRILL").replace("M30", "G53 G0 Z0.\nG53 X-15. Y0.\nM30"));
    let output = desk.done(&format!("new vf2.nc {MILL} --output vf2"));
    assert!(output.contains("zero = \"home\""), "{output}");
    let checked = desk.done("check vf2");
    assert!(checked.contains("X is sent to -381.000 mm") && !checked.contains("Z is sent"), "{checked}");
}

#[test]
fn words_of_other_controls_are_read_or_lead_on() {
    let desk = Desk::new(&[]);
    let tap = |words: &str| {
        format!(
            "O4\n(T7 M6X1.0 TAP)\nG21 G90 G17\nT7 M6\nG54 G0 X0 Y0 S600 M3\nG43 H7 Z25.\nG99 G84 X0 Y0 Z-10. R5. P100 F1. {words}\nG80\nM30\n"
        )
    };
    desk.write("m80.nc", &tap("S600 ,R1"));
    assert!(desk.done("check m80.nc --control mitsubishi-m800").contains("in order"));
    for other in [",R2", ",R1.5"] {
        desk.write("m80.nc", &tap(other));
        desk.refused("check m80.nc --control mitsubishi-m800", &["`,C` and `,R` need a motion"]);
    }
    let osp = "$PLATE07.MIN%\nO0707\nDEF WORK\nPS LC,[0,0,-1],[5,3,1]\nEND\nDRAW\nVC1=5.\nG15 H1\nT1 M6\nS4500 M3\nG0 X-1. Y0.\nG56 H1 Z1.\nG1 Z-.2 F20.\n\
               X=VC1\nG0 Z5.\nM2\n";
    desk.write("plate.min", osp);
    assert!(desk.done("check plate.min --control okuma-osp").contains("in order"));
    let other = printed(&desk.call("check plate.min"));
    assert!(other.contains("`DEF WORK` is a word of Okuma OSP") && other.contains("okuma-osp"), "{other}");
    // A subprogram by its name, in a file of its own.
    desk.write("side.min", "O0708\nG15 H1\nT1 M6\nS4500 M3\nG0 X-1. Y0.\nG56 H1 Z1.\nCALL OPROF\nM2\n");
    desk.write("OPROF.SUB", "OPROF\nG1 Z-.2 F20.\nX5.\nG0 Z5.\nRTS\n");
    assert!(desk.done("check side.min --control okuma-osp").contains("in order"));
    desk.write("end.nc", "O1\nG21 G90\n#1=1\nWHILE [#1 LT 3] DO1\nG1 X#1 F100.\n#1=#1+1\nEND\nM30\n");
    let end = printed(&desk.call("check end.nc"));
    assert!(end.contains("write DO 1 and END 1"), "{end}");
    desk.write("carbide.nc", "%\nG90\nG21\nM0 ;T201\nM3 S18000\nG0 X20 Y20\nZ0.5\nG1 Z-2 F300\nX80\nM2\n%\n");
    desk.refused("check carbide.nc", &["words after `;`", "--control linuxcnc-2.9"]);
    desk.done("check carbide.nc --control linuxcnc-2.9");
    let pilot = "%\nG90 G54 G64 G50 G17 G40 G80 G94 G91.1 G49\nG20\nG0 X0 Y0 Z1\nG1 Z0.5 F10\nM30\n%\n";
    desk.write("pilot.ngc", pilot);
    desk.refused("check pilot.ngc", &["unknown word `G50`", "PathPilot", "linuxcnc-2.9"]);
    desk.write("pilot.toml", "inherits = \"linuxcnc-2.9\"\n[words]\nG50 = { ignore = \"no scale is in force\" }\n");
    desk.done("check pilot.ngc --control pilot.toml");
}

#[test]
fn a_gouge_of_a_tap_says_that_its_cylinder_has_cut_it() {
    let desk = Desk::new(&[]);
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"-20,-20,-20,20,20,0\"\n");
    // No hole in the design at all: whatever cuts is a gouge.
    desk.write("block.stl", &block([-20.0, -20.0, -20.0], [20.0, 20.0, 0.0]));
    for (name, comment, round) in [("tap", "8MM TAP", true), ("mill", "8MM FLAT ENDMILL", false)] {
        let cycle = if round { "G84 Z-10. R3. F1250." } else { "G1 Z-10. F200." };
        desk.write(
            &format!("{name}.nc"),
            &format!("O1\nG21 G90 G17 G40 G80\n(T2 {comment})\nT2 M6\nG54 G0 X0 Y0 S1000 M3\nG43 H2 Z20.\nG0 Z3.\n{cycle}\nG80\nG0 Z20.\nM30\n"),
        );
        desk.done(&format!("new {name}.nc {MILL} --design block.stl --output {name}"));
        let verdict = desk.verdict(name);
        assert_eq!(gate(&verdict, "gouge").0, "fail", "{name}");
        let text = verdict["findings"].to_string();
        assert_eq!(text.contains("is modeled here as a cylinder"), round, "{name}: {text}");
    }
}

#[test]
fn files_that_are_no_program_are_refused_as_such() {
    let desk = Desk::new(&["plate.nc"]);
    desk.write("letter.nc", "Dear Sir or Madam,\n\nplease find enclosed the drawing.\n\nKind regards\n");
    desk.write("list.nc", "Pos;Artikel;Menge;Preis\n1;Fraeser;5;39\n");
    desk.write("zip.nc", "PK\u{3}\u{4}\nO100\nG0 X1.\nM30\n");
    desk.write("cut.nc", "O1\nG21 G90\nG0 X1. Y1.\nG1 Z-1. F100.\nG3 X2.5 Y1.5\n");
    let call = |name: &str| format!("new {name} --machine three-axis-mill");
    for name in ["letter.nc", "list.nc"] {
        desk.refused(&call(name), &["could not be determined", "check that it is an NC program"]);
    }
    desk.refused(&call("zip.nc"), &["is not plain text"]);
    desk.refused(&call("cut.nc"), &["the text ends in this line: is the file complete?"]);
    // A list of NX without its unit.
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,0,-1,4,2.5,0\"\n");
    desk.write(
        "part.cls",
        "TOOL PATH/FACE,TOOL,MILL\nTLDATA/MILL,0.7500,0.0000,3.0000,0.0000,0.0000\nLOAD/TOOL,1,ADJUST,1\nSPINDL/RPM,4000,CLW\nRAPID\n\
         GOTO/-0.6,0.5,0.1\nFEDRAT/IPM,30.0\nGOTO/-0.6,0.5,-0.1\nGOTO/4.6,0.5,-0.1\nRAPID\nGOTO/4.6,0.5,1.0\nFINI\n",
    );
    // The feed counts in inch, and so do the lengths.
    let output = desk.done(&format!("new part.cls {MILL} --output part"));
    assert!(
        output.contains("unit: inch") && output.contains("without UNITS") && output.contains("T1: flat D19.05"),
        "{output}"
    );
    let text = fs::read_to_string(desk.path("part.cls")).expect("there");
    desk.write("inch.cls", &format!("UNITS/INCHES\n{text}"));
    let output = desk.done(&format!("new inch.cls {MILL} --output inch"));
    assert!(output.contains("unit: inch") && output.contains("T1: flat D19.05"), "{output}");
}

#[test]
fn findings_and_paths_say_what_is_missing() {
    let desk = Desk::new(&[]);
    fs::create_dir_all(desk.path("jobs")).expect("made");
    fs::create_dir_all(desk.path("nc")).expect("made");
    desk.write("answers.toml", "holder = \"40x60\"\nstock = \"0,-10,-10,50,10,0\"\n");
    let text = "O1\n(T1 D=10. CR=0. - ZMIN=-3. - FLAT END MILL)\nG21 G90 G17\nT1 M6\nM3\nG54 G0 X-20. Y0.\nG43 H1 Z20.\nZ2.\nG1 Z-3. F100.\nX70.\nG0 Z20.\nM30\n";
    desk.write("nc/slow.nc", text);
    desk.done("new nc/slow.nc --machine three-axis-mill --answers answers.toml --output jobs/slow");
    let output = desk.call("run jobs/slow --rerun off --output out/slow");
    assert!(
        printed(&output).contains("it is on but has no speed: the S word is missing, or is S0"),
        "{}",
        printed(&output)
    );
    let text = text.replace("M3\n", "");
    desk.write("nc/slow.nc", &text);
    let output = desk.call("run jobs/slow --rerun off --output out/off");
    assert!(printed(&output).contains("no M3 or M4 is in force"), "{}", printed(&output));
    // A fault names the path that a person would write.
    desk.write("nc/slow.nc", &text.replace("X70.", "G2 X70. Y3."));
    let output = desk.call("check jobs/slow");
    let message = printed(&output);
    assert!(message.contains("at nc/slow.nc:") && !message.contains("/../"), "{message}");
    let verdict = fs::read_to_string(desk.path("out/off/verdict.json")).expect("written");
    let verdict: serde_json::Value = serde_json::from_str(&verdict).expect("JSON");
    assert_eq!(gate(&verdict, "process").0, "fail");
}
