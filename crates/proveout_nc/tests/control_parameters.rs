//! What parameters of a control decide: the rules of each control, and the assumption where none is stated
//! them.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{
    ASSUMED, Command, Control, Dialect, FeedCounts, Op, Program, ReferencePoints, RotarySolution, Settings,
};

fn read(control: &str, text: &str) -> Result<Vec<Command>, String> {
    let control = Control::from_text("shop.toml", control, None).unwrap_or_else(|e| panic!("{e}"));
    let settings = Settings::of_control(control);
    read_with(&settings, text)
}

fn read_with(settings: &Settings, text: &str) -> Result<Vec<Command>, String> {
    let program = Program::from_text("program", text, settings).map_err(|e| e.to_string())?;
    program.map(|command| command.map_err(|fault| fault.to_string())).collect()
}

fn assumptions(commands: &[Command]) -> Vec<&str> {
    commands.iter().filter_map(|c| if let Op::Note(text) = &c.op { text.strip_prefix(ASSUMED) } else { None }).collect()
}

fn assumes(commands: &[Command], words: &str) -> bool {
    assumptions(commands).iter().any(|text| text.contains(words))
}

/// Positions of an axis after each motion that names it, degrees.
fn positions(commands: &[Command], axis: usize) -> Vec<f64> {
    let motion = |c: &Command| match &c.op {
        Op::Rapid(m) | Op::Linear(m) if m.programmed >> axis & 1 == 1 => m.end.get(axis).map(f64::to_degrees),
        _ => None,
    };
    commands.iter().filter_map(motion).collect()
}

/// A linear congruential sequence, 0 to 1.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

#[test]
fn an_endless_axis_goes_the_way_that_the_control_is_set_up_for() {
    let mut state = 7;
    for (dialect, end) in [("fanuc", "M30"), ("siemens-840d", "M30"), ("linuxcnc", "M2")] {
        for mode in ["as-written", "shortest", "sign"] {
            let control = format!("dialect = \"{dialect}\"\nparameters.rollover = \"{mode}\"");
            let targets: Vec<f64> = (0..40).map(|_| (random(&mut state) * 1440.0 - 720.0).round()).collect();
            let blocks: String = targets.iter().map(|t| format!("G0 C{t:.1}\n")).collect();
            let commands = read(&control, &format!("G0 C0.\n{blocks}{end}\n")).unwrap();
            assert!(assumptions(&commands).is_empty(), "{control}: {:?}", assumptions(&commands));
            let found = positions(&commands, 5);
            assert_eq!(found.len(), targets.len() + 1);
            for (k, target) in targets.iter().enumerate() {
                let (from, to) = (found[k], found[k + 1]);
                let way = to - from;
                let place = if mode == "sign" { target.abs() } else { *target };
                let off = (to - place).rem_euclid(360.0);
                assert!(off.min(360.0 - off) < 1e-6, "{control}: {from} to {target}: {to}");
                match mode {
                    "as-written" => assert!((to - target).abs() < 1e-9, "{to} {target}"),
                    "shortest" => assert!(way.abs() <= 180.0 + 1e-9, "{from} to {target}: {way}"),
                    _ => assert!(
                        if target.is_sign_negative() {
                            way <= 1e-9 && way > -360.0
                        } else {
                            (-1e-9..360.0).contains(&way)
                        },
                        "{from} to {target}: {way}"
                    ),
                }
            }
        }
    }
    // The examples of the manuals.
    let control = "dialect = \"fanuc\"\nparameters.rollover = \"shortest\"";
    let ways = |text: &str, axis| {
        let all = positions(&read(control, text).unwrap(), axis);
        all.windows(2).map(|w| (w[1] - w[0]).round()).collect::<Vec<f64>>()
    };
    assert_eq!(ways("G90 G0 A0.\nA-150.\nA540.\nA-620.\nM30\n", 3), [-150.0, -30.0, -80.0]);
    assert_eq!(ways("G90 G0 C350.\nC10.\nM30\n", 5), [20.0]);
}

#[test]
fn a_way_of_more_than_half_a_turn_is_reported_until_the_roll_over_is_stated() {
    let klartext = "0 BEGIN PGM A MM\n1 L C+350 FMAX\n2 L C+10 FMAX\n3 END PGM A MM\n";
    for (control, text) in [
        ("dialect = \"fanuc\"", "G0 C350.\nC10.\nM30\n"),
        ("dialect = \"haas\"", "G0 C350.\nC10.\nM30\n"),
        ("inherits = \"mazak-eia\"", "G0 C350.\nC10.\nM30\n"),
        ("dialect = \"siemens-840d\"", "G0 C350\nC10\nM30\n"),
        ("dialect = \"heidenhain\"", klartext),
    ] {
        assert!(assumes(&read(control, text).unwrap(), "parameters.rollover"), "{control}");
        // Less than half a turn is the same way under every set-up.
        let near = text.replace("C10", "C200").replace("C+10", "C+200");
        assert!(!assumes(&read(control, &near).unwrap(), "parameters.rollover"), "{control}");
    }
    // M126 says the way itself; an axis with limits of travel has one.
    let short = klartext.replace("1 L", "1 M126\n2 L");
    assert!(!assumes(&read("dialect = \"heidenhain\"", &short).unwrap(), "parameters.rollover"));
    let limited =
        ReferencePoints { machine: "M".to_owned(), axes: 0b111111, endless: 0b1000, ..ReferencePoints::default() };
    let settings = Settings { dialect: Dialect::Fanuc, reference_points: Some(limited), ..Settings::default() };
    assert!(!assumes(&read_with(&settings, "G0 C350.\nC10.\nM30\n").unwrap(), "parameters.rollover"));
    assert!(assumes(&read_with(&settings, "G0 A350.\nA10.\nM30\n").unwrap(), "parameters.rollover"));
}

#[test]
fn dc_acp_and_acn_take_positions_of_one_turn() {
    for word in ["DC", "ACP", "ACN"] {
        for value in ["0", "10", "359.999"] {
            assert!(read("dialect = \"siemens-840d\"", &format!("G0 C10\nC={word}({value})\nM30\n")).is_ok());
        }
        for value in ["-90", "-0.001", "360", "725"] {
            let text = format!("G0 C10\nC={word}({value})\nM30\n");
            let fault = read("dialect = \"siemens-840d\"", &text).unwrap_err();
            assert!(fault.contains("0 to 359.999"), "{word}({value}): {fault}");
            assert!(read("dialect = \"siemens-840d\"\nparameters.outside_modulo = \"convert\"", &text).is_ok());
        }
    }
}

/// What the feed of a program counts, A B C.
fn counted(commands: &[Command]) -> Option<FeedCounts> {
    commands.iter().rev().find_map(|c| if let Op::FeedCounts(counts) = c.op { Some(counts) } else { None })
}

#[test]
fn each_control_counts_linear_and_rotary_axes_in_its_own_way() {
    let vector = FeedCounts { radius: [FeedCounts::DEGREE_IS_MM; 3], ..FeedCounts::LINEAR };
    let iso = "G21 G90 G0 X0. C0.\nG91 G94 G1 X20. C40. F300.\nM30\n";
    let klartext = "0 BEGIN PGM A MM\n1 L X+0 C+0 FMAX\n2 L IX+20 IC+40 F300\n3 END PGM A MM\n";
    let linuxcnc = "G21 G90 G0 X0 C0\nG91 G94 G1 X20 C40 F300\nM2\n";
    let at = "parameters = { mixed_feed = \"vector\", reference_radius_mm = { C = 50 } }";
    let radius = FeedCounts { radius: [FeedCounts::DEGREE_IS_MM, FeedCounts::DEGREE_IS_MM, 50.0], ..vector };
    for (control, text, counts, expected) in [
        ("dialect = \"fanuc\"".to_owned(), iso, vector, true),
        ("inherits = \"fanuc-30i\"".to_owned(), iso, vector, false),
        ("inherits = \"fanuc-0i\"".to_owned(), iso, vector, false),
        ("inherits = \"mazak-eia\"".to_owned(), iso, vector, true),
        ("inherits = \"haas-ngc\"".to_owned(), iso, vector, true),
        (format!("inherits = \"haas-ngc\"\n{at}"), iso, radius, false),
        ("inherits = \"linuxcnc-2.9\"".to_owned(), linuxcnc, FeedCounts::LINEAR, false),
        ("inherits = \"heidenhain-tnc-640\"".to_owned(), klartext, vector, true),
        (
            "inherits = \"siemens-840d-sl\"".to_owned(),
            "G0 X0 C0\nG91 G94 G1 X20 C40 F300\nM30\n",
            FeedCounts::LINEAR,
            true,
        ),
        (
            "inherits = \"siemens-840d-sl\"\nparameters.mixed_feed = \"vector\"".to_owned(),
            "G0 X0 C0\nG91 G94 G1 X20 C40 F300\nM30\n",
            vector,
            false,
        ),
    ] {
        let commands = read(&control, text).unwrap();
        assert_eq!(counted(&commands), Some(counts), "{control}");
        assert_eq!(assumes(&commands, "parameters.mixed_feed"), expected, "{control}: {:?}", assumptions(&commands));
        // The time of the block (G93) counts nothing, and neither does a block of one kind of axes.
        for other in [text.replace("G94", "G93"), text.replace(" C40.", "").replace(" C40", "").replace(" IC+40", "")] {
            if other != text {
                let commands = read(&control, &other).unwrap();
                assert!(counted(&commands).is_none() && !assumes(&commands, "mixed_feed"), "{control}: {other}");
            }
        }
    }
}

#[test]
fn fgroup_and_fgref_say_what_the_feed_counts() {
    let text = |words: &str| format!("{words}\nG0 X0 C0\nG91 G94 G1 X20 C40 F300\nM30\n");
    let counts = |words: &str| counted(&read("dialect = \"siemens-840d\"", &text(words)).unwrap());
    let one = FeedCounts::DEGREE_IS_MM;
    assert_eq!(counts("FGROUP(X,C)"), Some(FeedCounts { linear: [1.0, 0.0, 0.0], radius: [0.0, 0.0, one] }));
    assert_eq!(
        counts("FGROUP(X,Y,Z,C)\nFGREF[C]=100"),
        Some(FeedCounts { linear: [1.0; 3], radius: [0.0, 0.0, 100.0] })
    );
    assert_eq!(counts("FGROUP(X,Y,Z,C)\nFGROUP()"), Some(FeedCounts::LINEAR));
    assert!(read("dialect = \"siemens-840d\"", &text("FGREF[C]=0")).is_err());
    assert!(read("dialect = \"siemens-840d\"", &text("FGREF[X]=10")).is_err());
}

#[test]
fn a_length_without_z_is_reported_and_moves_where_the_control_moves() {
    for word in ["G43 H1", "G49"] {
        let before = if word == "G49" { "G43 H1 Z100.\n" } else { "" };
        let text = format!("G21 G90 G0 X0. Y0. Z100.\n{before}{word}\nX10.\nM30\n");
        let commands = read("dialect = \"fanuc\"", &text).unwrap();
        assert!(assumes(&commands, "parameters.length_word"), "{word}");
        let shifts = read("dialect = \"fanuc\"\nparameters.length_word = \"shifts\"", &text).unwrap();
        assert!(!assumes(&shifts, "length_word"));
        let moves = read("dialect = \"fanuc\"\nparameters.length_word = \"moves\"", &text).unwrap();
        let motions = |c: &[Command]| c.iter().filter(|c| matches!(c.op, Op::Rapid(_))).count();
        assert_eq!(motions(&moves), motions(&shifts) + 1, "{word}");
        // With Z in the block nothing is open; a Haas and a LinuxCNC move nothing.
        let with_z = text.replace(word, &format!("{word} Z50."));
        assert!(!assumes(&read("dialect = \"fanuc\"", &with_z).unwrap(), "length_word"));
        assert!(!assumes(&read("dialect = \"haas\"", &text).unwrap(), "length_word"));
    }
}

#[test]
fn numbers_without_a_point_are_reported_wherever_they_are_lengths() {
    let head = "G21 G90 G17 G0 X0. Y0. Z50.\n";
    for (block, letter) in [
        ("G98 G83 X10. Y0. Z-10. R2. Q4000 F50.", 'Q'),
        ("G98 G73 X10. Y0. Z-10. R2. Q4000 F50.", 'Q'),
        ("G98 G81 X10. Y0. Z-10. R2000 F50.", 'R'),
        ("G2 X10. Y0. R10000 F50.", 'R'),
        ("G3 X10. Y0. I5000 F50.", 'I'),
        ("G3 X0. Y10. J5000 F50.", 'J'),
        ("G18 G3 X0. Z60. K5000 F50.", 'K'),
        ("G1 X10000 F50.", 'X'),
    ] {
        for control in ["fanuc-0i", "fanuc-30i", "haas-ngc", "mazak-eia", "okuma-osp", "mitsubishi-m800", "brother-c00"]
        {
            let named = format!("inherits = \"{control}\"");
            let text = format!("{head}{block}\nG80\nM30\n");
            let found = read(&named, &text);
            // A word that this control does not have is refused by name.
            let Ok(commands) = found else { continue };
            assert!(assumes(&commands, &format!("{letter}")), "{control}: {block}: {:?}", assumptions(&commands));
            let pointed = text.replace("000 F50", "000. F50");
            if let Ok(commands) = read(&named, &pointed) {
                assert!(!assumes(&commands, "without a decimal point"), "{control}: {block}");
            }
            let counted = format!("{named}\nnumbers.without_point = \"increments\"");
            assert!(!assumes(&read(&counted, &text).unwrap(), "without a decimal point"), "{control}: {block}");
        }
    }
    // Numbers that are no lengths.
    for block in ["G98 G82 X10. Y0. Z-10. R2. P500 F50.", "G98 G81 X10. Y0. Z-10. R2. F50. K3", "G4 P500", "M98 P20 L3"]
    {
        let text = format!("{head}{block}\nG80\nM30\nO20\nM99\n");
        assert!(!assumes(&read("inherits = \"fanuc-0i\"", &text).unwrap(), "decimal point"), "{block}");
    }
}

#[test]
fn orientation_angles_are_eulers_as_delivered_and_reported() {
    let text = |word: &str| format!("TRAORI\n{word}\nG0 X0 Y0 Z0 A2=30 B2=45 C2=90\nM30\n");
    let axis = |control: &str, word: &str| {
        let commands = read(control, &text(word)).unwrap();
        let message = assumes(&commands, "parameters.orientation_angles");
        let axis = commands.iter().find_map(|c| if let Op::Rapid(m) = &c.op { m.tool_axis } else { None });
        (axis.unwrap(), message)
    };
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
    let (euler, rpy) = ([0.354, -0.612, 0.707], [0.5, 0.612, 0.612]);
    let siemens = "dialect = \"siemens-840d\"";
    for (control, word, wanted, message) in [
        (siemens, "", euler, true),
        (siemens, "ORIEULER", euler, false),
        (siemens, "ORIRPY", rpy, false),
        ("dialect = \"siemens-840d\"\nparameters.orientation_angles = \"rpy\"", "", rpy, false),
        ("dialect = \"siemens-840d\"\nparameters.orientation_angles = \"euler\"", "", euler, false),
    ] {
        let (found, assumed) = axis(control, word);
        assert!(near(found, wanted) && assumed == message, "{control} {word}: {found:?} {assumed}");
    }
}

#[test]
fn cycles_come_back_to_where_the_control_begins() {
    let text = "G21 G90 G0 X0 Y0 Z10\nG81 X10 Y0 Z-5 R2 F100\nX20\nG80\nM2\n";
    let heights = |control: &str, text: &str| {
        let commands = read(control, text).unwrap();
        let last = commands.iter().rev().find_map(|c| if let Op::Rapid(m) = &c.op { m.end.get(2) } else { None });
        (last.unwrap(), assumes(&commands, "parameters.return_level"))
    };
    let linuxcnc = "dialect = \"linuxcnc\"";
    assert_eq!(heights(linuxcnc, text), (2.0, true));
    assert_eq!(heights("dialect = \"linuxcnc\"\nparameters.return_level = \"initial\"", text), (10.0, false));
    assert_eq!(heights("dialect = \"linuxcnc\"\nparameters.return_level = \"r-plane\"", text), (2.0, false));
    for (word, level) in [("G98", 10.0), ("G99", 2.0)] {
        assert_eq!(heights(linuxcnc, &text.replace("G81", &format!("{word} G81"))), (level, false));
    }
    assert_eq!(heights("dialect = \"fanuc\"", text), (10.0, false));
}

#[test]
fn g64_without_p_has_no_tolerance() {
    let tolerance = |control: &str, text: &str| {
        let commands = read(control, text).unwrap();
        let message = assumes(&commands, "parameters.g64_tolerance_mm");
        let found = commands.iter().find_map(|c| match c.op {
            Op::PathMode(proveout_nc::PathMode::Continuous { tolerance, .. }) => tolerance,
            _ => None,
        });
        (found.unwrap(), message)
    };
    let (alone, message) = tolerance("dialect = \"linuxcnc\"", "G21 G64\nG0 X1\nM2\n");
    assert!(alone > 100.0 && message);
    assert_eq!(tolerance("dialect = \"linuxcnc\"", "G21 G64 P0.02\nG0 X1\nM2\n"), (0.02, false));
    let stated = "dialect = \"linuxcnc\"\nparameters.g64_tolerance_mm = 0.05";
    assert_eq!(tolerance(stated, "G21 G64\nG0 X1\nM2\n"), (0.05, false));
}

/// The positions that swivels of a program ask for.
fn solutions(control: &str, text: &str) -> Vec<RotarySolution> {
    let commands = read(control, text).unwrap();
    let swivel = |c: &Command| match &c.op {
        Op::Rapid(m) if m.tool_axis.is_some() => Some(m.solution),
        _ => None,
    };
    commands.iter().filter_map(swivel).collect()
}

#[test]
fn dir_seq_and_sym_ask_for_one_of_two_positions() {
    let angle = |higher, or_other| RotarySolution::Angle { higher, reference: None, or_other };
    for name in ["\"\"", "\"TC1\"", ""] {
        for (direction, higher) in [("-1", false), ("1", true)] {
            let text = format!("CYCLE800(1,{name},0,57,0,0,0,0,30,0,0,0,0,{direction})\nM30\n");
            assert_eq!(solutions("dialect = \"siemens-840d\"", &text), [angle(higher, true)], "{text}");
            let commands = read("dialect = \"siemens-840d\"", &text).unwrap();
            assert!(assumes(&commands, "parameters.tilt_reference"));
        }
    }
    // "0" takes the swivel data set away.
    assert!(solutions("dialect = \"siemens-840d\"", "CYCLE800(1,\"0\",0,57,0,0,0,0,30,0,0,0,0,1)\nM30\n").is_empty());
    for (word, wanted) in [
        ("SEQ+", angle(true, false)),
        ("SEQ-", angle(false, false)),
        ("SYM+", angle(true, false)),
        ("SYM-", angle(false, false)),
        ("", RotarySolution::Nearest),
    ] {
        for way in ["TURN FMAX", "MOVE FMAX"] {
            let text = format!("0 BEGIN PGM A MM\n1 PLANE SPATIAL SPA+20 SPB+0 SPC+0 {way} {word}\n2 END PGM A MM\n");
            assert_eq!(solutions("dialect = \"heidenhain\"", &text), [wanted], "{text}");
        }
        // The words of the program turn the axes to where the plane has chosen.
        let text = format!(
            "0 BEGIN PGM A MM\n1 PLANE SPATIAL SPA+20 SPB+0 SPC+0 STAY {word}\n2 L A+Q120 C+Q122 FMAX\n3 END PGM A MM\n"
        );
        assert_eq!(solutions("dialect = \"heidenhain\"", &text), [wanted], "{text}");
    }
}

#[test]
fn a_fanuc_takes_r_beside_a_center_and_drills_either_way() {
    let commands = read("inherits = \"fanuc-0i\"", "G21 G90 G17 G0 X0. Y0. Z0.\nG2 X10. Y0. R8. I5. J0. F100.\nM30\n");
    let commands = commands.unwrap();
    let arc = commands.iter().find_map(|c| if let Op::Arc(arc) = &c.op { Some(arc) } else { None }).unwrap();
    assert!((arc.center[0] - 5.0).abs() < 1e-9 && (arc.center[1] + 39f64.sqrt()).abs() < 1e-9, "{:?}", arc.center);
    assert!(read("dialect = \"linuxcnc\"", "G21 G0 X0 Y0 Z0\nG2 X10 Y0 R8 I5 J0 F100\nM2\n").is_err());
    let drill =
        |normal: &str, axis: char| format!("G21 G90 {normal} G0 X0. Y0. Z0.\nG98 G81 {axis}10. R5. F100.\nG80\nM30\n");
    for (normal, axis, index) in [("G17", 'Z', 2), ("G18", 'Y', 1), ("G19", 'X', 0)] {
        let commands = read("inherits = \"fanuc-0i\"", &drill(normal, axis)).unwrap();
        let deepest = commands.iter().find_map(|c| if let Op::Linear(m) = &c.op { m.end.get(index) } else { None });
        assert_eq!(deepest, Some(10.0), "{normal}");
        let fault = read("dialect = \"linuxcnc\"", &drill(normal, axis)).unwrap_err();
        assert!(fault.contains("R plane"), "{fault}");
    }
}
