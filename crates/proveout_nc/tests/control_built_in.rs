//! The built-in controls: what they read as the standard of their language, what they read otherwise, what
//! they refuse by name.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{Command, Control, Op, Program, Settings, builtin_controls, check_text};

fn settings(control: &str) -> Settings {
    Settings::of_control(Control::find(control, None).unwrap())
}

fn commands(control: &str, text: &str) -> Vec<Op> {
    let program = Program::from_text("part", text, &settings(control)).unwrap();
    let commands: Result<Vec<Command>, _> = program.collect();
    commands.unwrap_or_else(|e| panic!("{control}: {e}\n{text}")).into_iter().map(|c| c.op).collect()
}

/// A program that each control reads.
fn plain(control: &str) -> &'static str {
    match control {
        "siemens-840d-sl" => "G0 X1 Y2 Z3\nG1 X2 F100\nM5\nM30\n",
        "heidenhain-tnc-640" | "heidenhain-itnc-530" | "dmg-tnc-640" => {
            "0 BEGIN PGM A MM\n1 L X+1 Y+2 Z+3 R0 FMAX M3\n2 L X+2 F100\n3 END PGM A MM\n"
        }
        "fagor-8055" | "millplus" | "mach3" => "G71 G0 X1. Y2. Z3.\nG1 X2. F100\nM5\nM30\n",
        "okuma-osp" => "$PART.MIN%\nG21 G0 X1. Y2. Z3.\nG1 X2. F100\nM5\nM30\n",
        _ => "G21 G0 X1. Y2. Z3.\nG1 X2. F100\nM5\nM30\n",
    }
}

#[test]
fn each_control_reads_a_program() {
    for control in builtin_controls() {
        assert_eq!(check_text("part", plain(control), &settings(control)), [], "{control}");
        let ops = commands(control, plain(control));
        let ends: Vec<_> = ops
            .iter()
            .filter_map(|op| match op {
                Op::Rapid(m) | Op::Linear(m) => m.end.xyz(),
                _ => None,
            })
            .collect();
        assert_eq!(ends, [[1.0, 2.0, 3.0], [2.0, 2.0, 3.0]], "{control}");
    }
}

#[test]
fn words_with_another_meaning_are_refused_by_name() {
    for (control, text, says) in [
        ("fanuc-0i", "G21 G43.4 H1\nM30\n", "`G43.4` is refused by the control \"Fanuc 0i\""),
        ("haas-ngc", "M46 Q1 P10\nM30\n", "`M46` is refused"),
        ("okuma-osp", "G21 G15 H0\nM2\n", "`G15 H0` makes machine coordinates"),
        ("okuma-osp", "G21 G0 G16 H2 Z0.\nM2\n", "`G16 H2` is not supported"),
        ("okuma-osp", "G21 G0 Z50.\nG71 Z20.\nG81 X1. Y1. Z-5. R2. F100. M52\nM2\n", "`M52` is not supported"),
        ("okuma-osp", "G21 G0 Z50.\nG81 X1. Y1. Z-5. R2. F100.\nM2\n", "neither M53 nor M54"),
        ("okuma-osp", "G21 G0 Z50.\nG81 X1. Y1. Z-5. R2. F100. M53\nM2\n", "level of G71"),
        ("okuma-osp", "G21 G54 G0 X1.\nM2\n", "`G54` is refused"),
        ("okuma-osp", "G43 H1\nM2\n", "`G43` is refused"),
        ("okuma-osp", "T5 M6\nG56 HB Z50.\nM2\n", "`HB` is a further offset of the tool"),
        ("okuma-osp", "G56 HA Z50.\nM2\n", "`HA` is an offset of the tool in the spindle, and none is"),
        ("fanuc-30i", "T5 M6\nG43 HA Z50.\nM2\n", "a letter after `H` or `D` is a word of Okuma OSP"),
        ("fagor-8055", "G21 G0 X1.\nM30\n", "`G21` is refused"),
        ("fagor-8055", "G0 Z50\nG83 G99 X0 Y0 Z2 I-10 F100\nM30\n", "the number of infeeds J"),
        ("fagor-8055", "G0 Z50\nG83 G99 X0 Y0 Z2 I10 J2 F100\nM30\n", "the infeed I10"),
        ("fagor-8055", "G0 Z50\nG83 G99 X0 Y0 Z2 I-10 J1.5 F100\nM30\n", "the number of infeeds J1.5"),
        ("fagor-8055", "G0 Z50\nG91 G83 G99 X0 Y0 Z-2 I-10 J2 F100\nM30\n", "`G83` with G91"),
        ("fagor-8055", "G0 Z50\nVC1=5\nM30\n", "`VC` is a word of Okuma OSP"),
        ("fanuc-0i", "G0 X=5\nM30\n", "`=` after a letter is a word of Okuma OSP"),
        ("haas-ngc", "RTS\nM30\n", "`RTS` is a word of Okuma OSP"),
        ("fanuc-30i", "IF [#1 EQ 1] N5\nN5 M30\n", "`IF [..] N` is a word of Okuma OSP"),
        ("fanuc-30i", "G81 Z-5. R2. F100.\nNCYL X5.\nM30\n", "`NCYL` is a word of Okuma OSP"),
        ("okuma-osp", "CALL O200 PXX=5\nM2\n", "`O200` not found"),
        ("okuma-osp", "G0 X=PXX\nM2\n", "the local variable PXX has no value"),
        ("okuma-osp", "G0 X1.\nGOTO NOUT\nM2\n", "the program has no sequence name"),
        ("okuma-osp", "G30 P3\nM2\n", "`G30 P3` is not supported"),
        ("fanuc-30i", "LX=5\nM30\n", "a variable by name is a word of Okuma OSP"),
        ("fanuc-30i", "NEND G0 X1.\nM30\n", "a sequence name of letters is a word of Okuma OSP"),
        ("fanuc-30i", "MODIN O5\nM30\n", "`MODIN` is a word of Okuma OSP"),
        ("fanuc-30i", "#1=[FOO]\nM30\n", "`FOO` is not a function"),
        ("fanuc-30i", "RPT 5 6 1\nN5 G0 X1.\nN6 M30\n", "`RPT` is a word of a Fagor"),
        ("fagor-8055", "(MCALL 5)\nG0 X1\nM30\n", "`(MCALL 5)` is not supported"),
        ("fagor-8055", "(IF P1 EQ 2 GOTO N5 ELSE GOTO N6)\nG0 X1\nM30\n", "is not supported"),
        ("fagor-8055", "N5 G0 X1\nN6 (RPT N5,N9)\nM30\n", "no block number N9"),
        ("fagor-8055", "N5 G0 X1\nN6 (RPT N5,N6)\nM30\n", "hold their own repetition"),
        ("fagor-8055", "G0 Z50\nG1 F100 S100 M3\nG88 G98 X0 Y0 Z2 I5 J20 B4\nM30\n", "does not lie below the surface"),
        ("fagor-8055", "G0 Z50\nG1 F100 S100 M3\nG87 G98 X0 Y0 Z2 I-5 J20 B4\nM30\n", "has no `K`"),
        ("fagor-8055", "G93 I5\nM30\n", "both coordinates of the pole"),
        ("fagor-8055", "G1 G41 G37 R5 X0 Y0 F100\nM30\n", "`G37` is refused"),
        ("okuma-osp", "CALL O200 P5\nM2\nO200\nRTS\n", "words in the block of a CALL or MODIN"),
        ("okuma-osp", "CALL OABC\nM2\n", "`OABC` not found"),
        ("okuma-osp", "CALL O200\nM2\n", "`O200` not found"),
        ("okuma-osp", "G0 X=VC7\nM2\n", "VC7 keeps its value"),
        ("okuma-osp", "VC201=1\nM2\n", "VC1 to VC200"),
        ("okuma-osp", "G21 G0 X1.\nRTS\n", "RTS ends a subprogram"),
        ("okuma-osp", "G21 G0 X1.\nNCYL X5.\nM2\n", "NCYL positions in a cycle"),
        ("fagor-8055", "G0 Z50\nG91 G81 X0 Y0 Z-2 I-10 F100\nM30\n", "`G81` with G91"),
        ("mazak-eia", "G21 G54.2 P1\nM30\n", "`G54.2` is refused"),
        ("brother-c00", "G21 G100 T1 X0. Y0. Z50. G43 H1\nM30\n", "`G100` is refused"),
        ("brother-c00", "G21 G77 X0. Y0. Z-5. R2. I1.\nM30\n", "`G77` is refused"),
        ("mitsubishi-m800", "G21 G61.2\nM30\n", "`G61.2` is refused"),
        ("mitsubishi-m800", "G21 G34 X0. Y0. I10. J0. K4\nM30\n", "`G34` is refused"),
        ("mach3", "G51 X2\nM2\n", "`G51` is refused"),
        ("millplus", "G79 X0 Y0\nM30\n", "`G79` is refused"),
        ("hurco-isnc", "M140\nM30\n", "`M140` is refused"),
        ("grbl-1.1", "G21 G43 H1\nM2\n", "`G43` is refused"),
        ("grbl-1.1", "M777\nM2\n", "does not list it"),
        ("mach3", "G4 P2\nM2\n", "`G4` is refused"),
        ("linuxcnc-2.9", "M110\nM2\n", "does not list it"),
        ("linuxcnc-2.9", "X1 Y1\nM2\n", "without a motion word"),
        ("heidenhain-tnc-640", "0 BEGIN PGM A MM\n1 M115\n2 END PGM A MM\n", "`M115` is refused"),
        ("heidenhain-itnc-530", "0 BEGIN PGM A MM\n1 M200\n2 END PGM A MM\n", "`M200` is refused"),
    ] {
        let faults = check_text("part", text, &settings(control));
        assert!(faults.iter().any(|f| f.message.contains(says)), "{control}: {says}: {faults:?}");
    }
}

#[test]
fn what_a_control_states_is_taken() {
    let seconds = |control: &str, text: &str| {
        commands(control, text).into_iter().find_map(|op| match op {
            Op::Dwell(dwell) => Some(dwell),
            _ => None,
        })
    };
    let dwell = |value: f64| Some(proveout_nc::Dwell::Seconds(value));
    assert_eq!(seconds("fagor-8055", "G4 K150\nG0 X1\nM30\n"), dwell(1.5));
    assert_eq!(seconds("millplus", "G4 X2\nG0 X1\nM30\n"), dwell(2.0));
    assert_eq!(seconds("haas-ngc", "G4 P2.\nG21 G0 X1.\nM30\n"), dwell(2.0));
    assert_eq!(seconds("haas-ngc", "G4 P200\nG21 G0 X1.\nM30\n"), dwell(0.2));
    // Radii of 100 and 100.09 mm: 0.1 percent of the radius.
    let arc = "G0 X100 Y0 Z0\nG3 X0 Y100.09 I-100 J0 F100\n";
    for (control, taken) in [("siemens-840d-sl", true), ("grbl-1.1", true), ("linuxcnc-2.9", true), ("mach3", false)] {
        let end = if control == "siemens-840d-sl" { "M30\n" } else { "M2\n" };
        let head = if control == "siemens-840d-sl" { "" } else { "G21\n" };
        let faults = check_text("part", &format!("{head}{arc}{end}"), &settings(control));
        assert_eq!(faults.is_empty(), taken, "{control}: {faults:?}");
    }
    // Centers are coordinates on a MillPlus.
    let ops = commands("millplus", "G71 G17 G0 X20 Y10 Z0\nG3 X10 Y20 I10 J10 F100\nM30\n");
    assert!(ops.iter().any(|op| matches!(op, Op::Arc(arc) if arc.center == [10.0, 10.0, 0.0])), "{ops:?}");
    // The path of a Mitsubishi under G61.1 runs through; words that take back what was never on do nothing.
    let through = |op: &Op| matches!(op, Op::PathMode(proveout_nc::PathMode::Continuous { .. }));
    assert!(commands("mitsubishi-m800", "G21 G61.1\nG0 X1.\nM30\n").iter().any(through));
    assert_eq!(check_text("part", "G15 G50 G69 G21 G0 X1.\nM30\n", &settings("mach3")), []);
    // The first set of offsets is that of the tool in the spindle.
    let okuma = |offset: &str| {
        format!("G21 G90\nT5 M6\nG0 X0. Y0.\nG56 H{offset} Z50.\nG1 G41 X5. D{offset} F100.\nX9.\nG40 X12.\nM2\n")
    };
    assert_eq!(commands("okuma-osp", &okuma("A")), commands("okuma-osp", &okuma("5")));
    // Grbl begins with G0.
    assert!(commands("grbl-1.1", "X1 Y1\nM2\n").iter().any(|op| matches!(op, Op::Rapid(_))));
    assert!(commands("hurco-isnc", "G21 G43 H1\nM128\nM30\n").iter().any(|op| matches!(op, Op::Tcp(tcp) if tcp.on)));
}

#[test]
fn numbers_without_a_point_are_read_as_units_and_reported() {
    for control in ["fanuc-0i", "fanuc-30i", "haas-ngc", "mazak-eia", "brother-c00", "hurco-isnc", "mitsubishi-m800"] {
        let ops = commands(control, "G21 G0 X10. Y5. Z20.\nX20\nG81 Z-5. R2. F100.\nG80\nM30\n");
        let is_whole_number_note = |op: &&Op| matches!(op, Op::Note(text) if text.contains("X20 without a decimal point is read as 20 units") && text.contains("numbers.without_point"));
        assert_eq!(ops.iter().filter(is_whole_number_note).count(), 1, "{control}: {ops:?}");
        assert!(ops.iter().any(|op| matches!(op, Op::Rapid(m) if m.end.get(0) == Some(20.0))), "{control}: {ops:?}");
    }
    // A file of one's own still refuses them; a number of holes is none of them.
    let folder = std::env::temp_dir().join(format!("proveout-nc-refuse-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("mine.toml");
    std::fs::write(&file, "name = \"mine\"\ninherits = \"fanuc-30i\"\nnumbers.without_point = \"refuse\"\n").unwrap();
    let settings = Settings::of_control(Control::find(file.to_str().unwrap(), None).unwrap());
    let faults = check_text("part", "G21 G0 X10. Y5. Z20.\nG81 Z-5. R2. F100. K2\nG80\nM30\n", &settings);
    assert!(faults.is_empty(), "{faults:?}");
    let faults = check_text("part", "G21 G0 X10\nM30\n", &settings);
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(faults[0].message.contains("X10 has no decimal point"), "{faults:?}");
}
