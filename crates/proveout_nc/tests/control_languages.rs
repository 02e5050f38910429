//! What a control file says holds for every language: keys, words, and the programs that it reads.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{Control, Kinematics, Program, Settings};

use crate::control_keys::{differs, outcome};

/// Keys that other languages use, too.
#[test]
fn the_languages_use_what_their_control_says() {
    let mut wrong = Vec::new();
    for (control, program, gives) in [
        ("dialect = \"siemens-840d\"\nstart.unit = \"inch\"", "G0 X1\nM30\n", "25.4"),
        (
            "dialect = \"siemens-840d\"\nstart.distance = \"incremental\"\nstart.position_mm = { X = 5 }",
            "G0 X1\nM30\n",
            "\"X\":6.0",
        ),
        ("dialect = \"siemens-840d\"\nstart.motion = \"rapid\"", "X1\nM30\n", "rapid"),
        ("dialect = \"siemens-840d\"\nstart.feed = \"per-revolution\"", "S100 M3\nG1 X1 F0.1\nM30\n", "mm_rev"),
        (
            "dialect = \"siemens-840d\"\nstart.plane = \"ZX\"",
            "G0 X0 Y0 Z0\nG2 X10 Z0 I5 K0 F100\nM30\n",
            "\"op\":\"arc\"",
        ),
        ("dialect = \"siemens-840d\"\nfeed = { missing = \"value\", missing_mm_min = 300 }", "G1 X1\nM30\n", "300.0"),
        ("dialect = \"siemens-840d\"\nwords.M13.does = \"M3 M8\"", "S100 M13\nM30\n", "flood"),
        (
            "dialect = \"linuxcnc\"\nwords.M400 = { macro = \"bore\", values = \"PQ\" }",
            "G21 G0 X0 Y0 Z0\no<bore> sub\nG0 X#<p> Y#1\no<bore> endsub\nM400 P7\nM2\n",
            "\"X\":7.0",
        ),
        (
            "dialect = \"linuxcnc\"\nwords.M400 = { macro = \"20\", values = \"P\" }",
            "G21 G0 X0 Y0 Z0\no20 sub\nG0 X9\no20 endsub\nM400\nM2\n",
            "\"X\":9.0",
        ),
        (
            "dialect = \"linuxcnc\"\nwords.M400 = { macro = \"bore\", values = \"P\" }",
            "G21 G0 X0 Y0 Z0\no<bore> sub\nG0 X#<p>\no<bore> endsub\nG1 M400 P7\nM2\n",
            "write it in a block of its own",
        ),
        (
            "dialect = \"linuxcnc\"\nwords.M400 = { macro = \"bore\" }",
            "G21 G0 X0 Y0 Z0\no<bore> sub\no<bore> endsub\nM400 P7\nM2\n",
            "`P7` has no meaning in this block",
        ),
        ("dialect = \"siemens-840d\"\nwords.G187.note = \"quality\"", "G187\nM30\n", "G187: quality"),
        ("dialect = \"siemens-840d\"\nwords.CYCLE999.ignore = \"log\"", "CYCLE999(1,2)\nM30\n", "log"),
        ("dialect = \"siemens-840d\"\nwords.CYCLE999.refuse = \"take it out\"", "CYCLE999(1,2)\nM30\n", "take it out"),
        ("dialect = \"siemens-840d\"\nwords.M50.kinematics = \"tcp-on\"", "M50\nM30\n", "\"op\":\"tcp\""),
        ("dialect = \"siemens-840d\"\nwords.M6.call = \"CHANGE\"", "M6\nM30\n", "CHANGE"),
        (
            "dialect = \"siemens-840d\"\nsubprograms = { missing = \"note\", missing_reason = \"log\" }",
            "L20\nG0 X1\nM30\n",
            "Unproven",
        ),
        ("dialect = \"siemens-840d\"\nunlisted.m = \"refuse\"", "M777\nM30\n", "does not list it"),
        ("dialect = \"siemens-840d\"\nprogram.header = [\"HEAD*\"]", "HEAD OF TAPE\nG0 X1\nM30\n", "is not a block"),
        (
            "dialect = \"heidenhain\"\nwords.M25.does = \"M3 M8\"",
            "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S100\n2 M25\n3 END PGM A MM\n",
            "flood",
        ),
        (
            "dialect = \"heidenhain\"\nwords.M25.ignore = \"vise\"",
            "0 BEGIN PGM A MM\n2 L X+1 R0 FMAX M25\n3 END PGM A MM\n",
            "vise",
        ),
        (
            "dialect = \"heidenhain\"\nwords.M114.note = \"old\"",
            "0 BEGIN PGM A MM\n2 L X+1 R0 FMAX M114\n3 END PGM A MM\n",
            "M114: old",
        ),
        (
            "dialect = \"heidenhain\"\nwords.M50.kinematics = \"tcp-on\"",
            "0 BEGIN PGM A MM\n2 M50\n3 END PGM A MM\n",
            "\"op\":\"tcp\"",
        ),
        (
            "dialect = \"heidenhain\"\nunlisted.m = \"refuse\"",
            "0 BEGIN PGM A MM\n2 M777\n3 END PGM A MM\n",
            "does not list it",
        ),
        (
            "dialect = \"heidenhain\"\nfeed = { missing = \"value\", missing_mm_min = 300 }",
            "0 BEGIN PGM A MM\n2 L X+1 R0\n3 END PGM A MM\n",
            "300.0",
        ),
        (
            "dialect = \"heidenhain\"\nstart.position_mm = { X = 5 }",
            "0 BEGIN PGM A MM\n2 L IX+1 R0 FMAX\n3 END PGM A MM\n",
            "\"X\":6.0",
        ),
        (
            "dialect = \"heidenhain\"\nvariables = { \"ID270 NR1 IDX1\" = 4.5 }",
            "0 BEGIN PGM A MM\n1 FN 18: SYSREAD Q1 = ID270 NR1 IDX1\n2 L X+Q1 R0 FMAX\n3 END PGM A MM\n",
            "\"X\":4.5",
        ),
        (
            "dialect = \"heidenhain\"\nsubprograms = { missing = \"note\", missing_reason = \"log\" }",
            "0 BEGIN PGM A MM\n1 CALL PGM OTHER\n3 END PGM A MM\n",
            "Unproven",
        ),
        (
            "dialect = \"heidenhain\"\nblocks.skipped_levels = [0]",
            "0 BEGIN PGM A MM\n/1 L X+77 R0 FMAX\n2 L X+1 R0 FMAX\n3 END PGM A MM\n",
            "\"X\":1.0",
        ),
        ("dialect = \"apt\"\nwords.FOOBAR.ignore = \"of the post\"", "FOOBAR/1\nGOTO/0,0,0\nFINI\n", "of the post"),
        ("dialect = \"apt\"\nstart.unit = \"inch\"", "RAPID\nGOTO/1,0,0\nFINI\n", "25.4"),
        ("dialect = \"apt\"\nstart.position_mm = { X = 5, Y = 0, Z = 0 }", "RAPID\nGODLTA/1,0,0\nFINI\n", "\"X\":6.0"),
        (
            "dialect = \"linuxcnc\"\narcs.centers = \"absolute\"",
            "G21 G0 X20 Y10 Z0\nG3 X10 Y20 I10 J10 F100\nM2\n",
            "\"op\":\"arc\"",
        ),
        ("dialect = \"linuxcnc\"\nwords.M428.kinematics = \"tcp-on\"", "G21 M428\nM2\n", "\"op\":\"tcp\""),
    ] {
        let dialect = control.lines().next().unwrap();
        let (without, with) = (outcome(dialect, program), outcome(control, program));
        if without == with || !with.contains(gives) {
            wrong.push(differs(control, gives, &without, &with));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn unsigned_centers_find_the_quadrant() {
    let control = "dialect = \"fanuc\"\narcs.centers = \"unsigned\"";
    for (program, center) in [
        ("G3 X10. Y20. I10. J0. F100", "10.0,10.0"),
        ("G2 X30. Y20. I10. J0. F100", "30.0,10.0"),
        ("G2 X10. Y0. I10. J0. F100", "10.0,10.0"),
    ] {
        let out = outcome(control, &format!("G21 G0 X20. Y10. Z0.\n{program}\nM30\n"));
        assert!(out.contains(&format!("\"center\":[{center}")), "{program}: {out}");
    }
    let out = outcome(control, "G21 G0 X20. Y10. Z0.\nG3 X10. Y25. I10. J0. F100\nM30\n");
    assert!(out.contains("0 centers fit"), "{out}");
}

#[test]
fn a_kinematics_word_is_refused_where_the_machine_does_not_list_it() {
    for (dialect, program) in [
        ("fanuc", "G43 H1\nM50\nM30\n"),
        ("siemens-840d", "M50\nM30\n"),
        ("heidenhain", "0 BEGIN PGM A MM\n1 M50\n2 END PGM A MM\n"),
    ] {
        let text = format!("dialect = \"{dialect}\"\nwords.M50.kinematics = \"tcp-on\"");
        let control = Control::from_text("shop.toml", &text, None).unwrap();
        let mut settings = Settings::of_control(control);
        settings.kinematics = Some(Kinematics { machine: "three axes".to_owned(), tcp: false, tilted_plane: false });
        let faults = proveout_nc::check_text("p", program, &settings);
        assert!(faults.iter().any(|f| f.message.contains("M50") && f.message.contains("three axes")), "{faults:?}");
    }
}

#[test]
fn a_control_reads_programs_of_its_language_only() {
    let mut settings = Settings::of_control(Control::find("fanuc-30i", None).unwrap());
    settings.dialect = proveout_nc::Dialect::Siemens840d;
    let fault = Program::from_text("p.mpf", "G0 X1\nM30\n", &settings).unwrap_err();
    assert!(fault.to_string().contains("is fanuc"), "{fault}");
}

#[test]
fn a_tnc_reads_both_forms_of_its_language() {
    let settings = Settings::of_control(Control::find("heidenhain-tnc-640", None).unwrap());
    for (name, text) in [
        ("p.h", "0 BEGIN PGM A MM\n1 L X+1 R0 FMAX\n2 END PGM A MM\n"),
        ("p.i", "%A G71 *\nN10 G00 G40 G90 X+1 *\nN99999999 %A G71 *\n"),
    ] {
        assert_eq!(proveout_nc::check_text(name, text, &settings), [], "{name}");
    }
    let settings = Settings::of_control(Control::find("haas-ngc", None).unwrap());
    let iso = Settings { dialect: proveout_nc::Dialect::Iso, ..settings };
    let program = Program::from_text("p.nc", "G0 G154 P3 X0\nM30\n", &iso).unwrap();
    assert_eq!(program.dialect(), proveout_nc::Dialect::Haas);
}
