//! Programs as other people write them: tools in other languages and units, bars that lie, controls that
//! begin with what is active.

use std::fs;

use super::desk::{Desk, believable, gate, printed};

/// A bar of 60 mm in a rotary table that turns about x.
const BAR: &str = "O7001 (WALEK FI60)\nG21 G90 G94 G17 G40 G49 G80\nG54\nT1 M06 (FREZ FI9.6 4Z)\nG43 H1 Z50.\nS3000 M03\n\
                   G00 X-10. Y0\nG00 Z-4.8\nG01 X110. F600\nG00 Z50.\nM05\nM30\n";

/// Volume of the slot, mm3: what lies above 25.2 mm from the middle of the circle, 4.8 mm to both sides, the
/// integral of sqrt(900 - y^2) - 25.2. Walls and bottom lie midway between rays 0.4 mm apart, so that only
/// the round top is counted by cells: 2 percent is a quarter of one over the whole width.
fn slot() -> f64 {
    let half = 0.5 * (4.8 * (900.0_f64 - 4.8 * 4.8).sqrt() + 900.0 * (4.8_f64 / 30.0).asin());
    100.0 * (2.0 * half - 9.6 * 25.2)
}

#[test]
fn a_lying_bar_is_cut_as_its_circle_says() {
    let desk = Desk::new(&[]);
    desk.write("bar.nc", BAR);
    desk.write("answers.toml", "holder = \"20x60\"\nstock = \"0,0,-30,60,100 along X\"\n");
    let output = desk.done("new bar.nc --machine three-axis-mill --answers answers.toml --output bar");
    assert!(output.contains("tool T1: flat D9.6"), "{output}");
    assert!(output.contains("stock: X 0.00 to 100.00, Y -30.00 to 30.00, Z -60.00 to 0.00 mm"), "{output}");
    let scene = fs::read_to_string(desk.path("bar/scene.toml")).expect("written");
    assert!(
        scene.contains("cylinder = { base_mm = [0, 0, -30], radius_mm = 30, height_mm = 100, along = \"x\" }"),
        "{scene}"
    );
    let verdict = desk.verdict("bar");
    believable(&verdict);
    let (cut, slot) = (verdict["removal"]["volume_mm3"].as_f64().expect("a volume"), slot());
    assert!((cut - slot).abs() < 0.02 * slot, "{cut} for {slot}");

    desk.write("answers.toml", "holder = \"20x60\"\nstock = \"0,0,-30,60,100 along Q\"\n");
    desk.refused("new bar.nc --machine three-axis-mill --answers answers.toml --output other", &["along X"]);
    fs::write(desk.path("bar/scene.toml"), scene.replace("along = \"x\"", "along = \"w\"")).expect("written");
    desk.refused("check bar", &["scene.toml"]);
}

#[test]
fn a_bar_that_turns_is_proposed_about_its_own_axis() {
    let desk = Desk::new(&[]);
    let text =
        BAR.replace("G01 X110. F600\n", "G01 X110. F600\nG00 Z50.\nG00 A180.\nG00 X-10.\nG00 Z-4.8\nG01 X110. F600\n");
    desk.write("bar.nc", &text);
    let call = "new bar.nc --machine starrag-lx-451 --answers answers.toml --output bar";
    desk.write("answers.toml", "holder = \"20x60\"\nstock = \"0,0,-30,60,100 along X\"\n");
    desk.refused(call, &["mount", "turns about its own axis"]);
    desk.write("answers.toml", "holder = \"20x60\"\nmount = \"proposed\"\nstock = \"0,0,-30,60,100 along X\"\n");
    desk.done(call);
    // Both sides lose the same slot: twice the volume of one, which the bar about another axis would not.
    let cut = desk.verdict("bar")["removal"]["volume_mm3"].as_f64().expect("a volume");
    assert!((cut - 2.0 * slot()).abs() < 0.04 * slot(), "{cut} for {}", 2.0 * slot());
}

#[test]
fn what_no_scene_can_hold_is_refused_before_a_folder_is_made() {
    let desk = Desk::new(&[]);
    desk.write("bar.nc", BAR);
    desk.write("answers.toml", "holder = \"none\"\nstock = \"0,0,-1e300,1,1,0\"\n");
    desk.refused("new bar.nc --machine three-axis-mill --answers answers.toml --output bar", &["1.000e300 mm"]);
    desk.write("far.nc", &BAR.replace("X110.", "X99999999999999999999."));
    desk.write("answers.toml", "holder = \"none\"\nstock = \"proposed\"\n");
    desk.refused(
        "new far.nc --machine three-axis-mill --answers answers.toml --output far",
        &["beyond the travel of any machine"],
    );
}

#[test]
fn tools_are_reported_in_their_own_units_and_languages() {
    let desk = Desk::new(&[]);
    let text = "O7002 (INCH)\nG20 G90 G54\n(T1 = 10MM END MILL)\n(T2 - 90-DEG SPOT DRILL 3/8)\n(T3 - 5 MM TAP DRILL)\n(T4 - M6X1 TAP)\n\
                T1 M06\nG43 H1 Z1.\nS2000 M03\nG00 X0 Y0\nG01 Z-0.1 F10.\nX2.\nG00 Z1.\n\
                T2 M06\nG43 H2 Z1.\nG81 G99 X0.5 Y0 Z-0.15 R0.1 F5.\nG80\nT3 M06\nG43 H3 Z1.\nG81 G99 X0.5 Y0 Z-0.4 R0.1 F5.\nG80\n\
                T4 M06\nG43 H4 Z1.\nS300 M03\nG84 G99 X0.5 Y0 Z-0.3 R0.2 F11.811\nG80\nM30\n";
    desk.write("mixed.nc", text);
    desk.write("answers.toml", "holder = \"none\"\nstock = \"-1,-1,-1,3,1,0 inch\"\n");
    let output = desk.done("new mixed.nc --machine three-axis-mill --answers answers.toml --output mixed");
    for word in ["tool T1: flat D10,", "tool T2: chamfer D9.525", "tool T3: drill D5,", "tool T4: tap D6,", "2 answers"]
    {
        assert!(output.contains(word), "{word:?} is not in:\n{output}");
    }
}

#[test]
fn a_tool_that_is_named_and_never_changed_in_is_proposed() {
    let desk = Desk::new(&[]);
    let text = "(T26 D=6.35 CR=0 - ZMIN=-1 - flat end mill)\nG90 G94\nG17\nG21\nG28 G91 Z0\nG90\nT26\nS10000 M3\nG54\nG0 X0 Y0\nZ5\n\
                G1 Z-1 F300\nX30\nG0 Z5\nM5\nM30\n";
    desk.write("router.nc", text);
    desk.write("answers.toml", "holder = \"none\"\nstock = \"-5,-5,-3,35,5,0\"\n");
    let output = desk.refused(
        "new router.nc --machine three-axis-mill --answers answers.toml --output router",
        &["cuts in line 12", "T26 in line 7 has no tool change", "proposed: 26"],
    );
    assert!(!output.contains("tool.T"), "{output}");
    desk.write("answers.toml", "start_tool = \"proposed\"\nholder = \"none\"\nstock = \"-5,-5,-3,35,5,0\"\n");
    let output = desk.done("new router.nc --machine three-axis-mill --answers answers.toml --output router");
    assert!(output.contains("tool T26: flat D6.35"), "{output}");
    believable(&desk.verdict("router"));
}

#[test]
fn the_mounting_keeps_every_position_in_the_travel() {
    let desk = Desk::new(&[]);
    // Cuts 350 mm from the zero to which the program goes back: with the cuts in the middle of the table it
    // would leave the travel of Y.
    let text = "G21 G90 G54\nT1 M06 (END MILL D10)\nG43 H1 Z50.\nS3000 M03\nG00 X60. Y350.\nZ2.\nG01 Z-1. F300\nX400.\nG00 Z50.\n\
                X-10. Y-10.\nM05\nM30\n";
    desk.write("far.nc", text);
    desk.write("answers.toml", "holder = \"20x60\"\nstock = \"40,340,-10,420,360,0\"\n");
    let output = desk.done("new far.nc --machine three-axis-mill --answers answers.toml --output far");
    assert!(output.contains("so that every position of the program lies in the travel"), "{output}");
    assert!(!desk.done("check far").contains("before the run"));
    believable(&desk.verdict("far"));

    // Nothing helps where the way alone is longer than the travel.
    desk.write("wide.nc", &text.replace("X400.", "X1400."));
    desk.write("answers.toml", "holder = \"none\"\nstock = \"40,340,-10,1420,360,0\"\n");
    desk.done("new wide.nc --machine three-axis-mill --answers answers.toml --output wide");
    let causes = desk.done("check wide");
    assert!(causes.contains("and has 760.000 mm, wherever the part is mounted: correct the two lines"), "{causes}");

    // Where two offsets make it so, the machine may be large enough.
    desk.write("two.nc", &text.replace("X400.\n", "X400.\nG00 Z50.\nG55 X900.\nZ2.\nG01 Z-1. F300\nX950.\n"));
    desk.write("answers.toml", "holder = \"none\"\nstock = \"40,340,-10,1420,360,0\"\noffset.G55 = \"0,0,0\"\n");
    desk.done("new two.nc --machine three-axis-mill --answers answers.toml --output two");
    let causes = desk.done("check two");
    assert!(causes.contains("with G54, G55 placed as in this scene"), "{causes}");
}

#[test]
fn a_tnc_begins_with_the_preset_that_is_active() {
    let desk = Desk::new(&[]);
    let text = "0 BEGIN PGM P MM\n1 BLK FORM 0.1 Z X-10 Y-10 Z-20\n2 BLK FORM 0.2 X+60 Y+20 Z+0\n3 TOOL CALL 1 Z S3000 ; END MILL D10\n\
                4 L X+0 Y+0 Z+100 R0 FMAX M3\n5 CYCL DEF 247 DATUM SETTING ~\n  Q339=+1 ;DATUM NUMBER\n6 L Z+5 R0 FMAX\n7 L Z-1 F300\n8 L X+50\n\
                9 L Z+100 R0 FMAX\n10 M30\n11 END PGM P MM\n";
    desk.write("preset.h", text);
    let call = "new preset.h --machine bc-trunnion --answers answers.toml --output preset";
    desk.write("answers.toml", "holder = \"20x60\"\n");
    desk.refused(call, &["offset.PRESET0", "active before the program calls one", "proposed: 0,0,0"]);
    desk.write("answers.toml", "holder = \"20x60\"\noffset.PRESET0 = \"proposed\"\n");
    desk.done(call);
    let stated = desk.verdict("preset");
    believable(&stated);
    assert_eq!(gate(&stated, "program").0, "pass", "{:?}", gate(&stated, "program"));

    // A scene that does not state it is read from the zero of the machine, and says so.
    let scene = fs::read_to_string(desk.path("preset/scene.toml")).expect("written");
    let at = scene.find("[work_offsets.PRESET0]").expect("stated");
    let end = scene[at..].find("\n\n").map_or(scene.len(), |e| at + e);
    fs::write(desk.path("preset/scene.toml"), format!("{}{}", &scene[..at], &scene[end..])).expect("written");
    let output = gate(&desk.verdict("preset"), "program");
    assert_eq!(output.0, "unchecked", "{output:?}");
    assert!(output.1.contains("line 5 moves before a preset is called"), "{output:?}");
}

#[test]
fn an_error_of_many_lines_is_reported_once() {
    let desk = Desk::new(&[]);
    let text = "G21 G90 G54\nT1 M6\nG43 H1 Z50.\nS1000 M3\nG93 G1 X1. F10.\nX2.\nX3.\nX4.\nG94\nM30\n";
    desk.write("inverse.nc", text);
    let message = desk.refused("check inverse.nc", &["G93 needs F", "inverse.nc:6:1", "the same in lines 7, 8"]);
    assert_eq!(message.matches("G93 needs F").count(), 1, "{message}");
    let output = desk.call("check inverse.nc --json");
    let all: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(all.to_string().matches("G93 needs F").count(), 3, "programs that read get each: {all}");
}

#[test]
fn words_of_a_haas_are_named_as_such() {
    let desk = Desk::new(&[]);
    let text = "G20 G90 G54\nT1 M6 (1/4 DRILL)\nG43 H1 Z1.\nS1000 M3\nG0 X1. Y1.\nZ0.1\nG81 G98 Z-0.4 F5.\nG80\nM30\n";
    desk.write("drill.nc", text);
    desk.refused("check drill.nc", &["G81 has no `R`", "--control haas-ngc"]);
    desk.done("check drill.nc --control haas-ngc");
    desk.write("mirror.nc", &text.replace("G81 G98 Z-0.4 F5.\nG80", "G101 X0\nG1 Z-0.1 F5."));
    desk.refused("check mirror.nc", &["`G101`", "is a word of a Haas: --control haas-ngc"]);
    desk.done("check mirror.nc --control haas-ngc");
}

#[test]
fn a_subprogram_of_a_linuxcnc_is_left_out_by_its_own_control() {
    let desk = Desk::new(&[]);
    desk.write("call.ngc", "G21 G90\nT1 M6\nG43\nF300\no<probe> call [20] [-8]\nG1 X1\nM2\n");
    let output = desk.refused("check call.ngc", &["o<probe>", "linuxcnc-2.9"]);
    assert!(!output.contains("haas"), "{output}");
}

#[test]
fn the_folder_of_a_run_has_the_option_of_the_other_commands_too() {
    let desk = Desk::new(&[]);
    desk.write("bar.nc", BAR);
    desk.write("answers.toml", "holder = \"20x60\"\nstock = \"0,-20,-20,100,20,0\"\n");
    desk.done("new bar.nc --machine three-axis-mill --answers answers.toml --output bar");
    let output = desk.call("run bar --output there");
    assert!(desk.path("there/verdict.json").is_file(), "{}", printed(&output));
}
