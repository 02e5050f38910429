//! What a program refers to and the machine states: reference points and kinematics; what is known of the
//! position after motions of the machine axes.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{
    ASSUMED, AxisValues, Command, Dialect, Kinematics, Motion, Offset, Op, Program, ReferencePoints, Settings, Tcp,
};

fn read_with(text: &str, settings: &Settings) -> Result<Vec<Op>, String> {
    let commands: Result<Vec<Command>, _> = Program::from_text("p.nc", text, settings).unwrap().collect();
    commands.map(|c| c.into_iter().map(|c| c.op).collect()).map_err(|e| format!("{} {e}", e.code))
}

fn motions(ops: &[Op]) -> Vec<&Motion> {
    ops.iter().filter_map(|op| if let Op::Rapid(m) | Op::Linear(m) = op { Some(m) } else { None }).collect()
}

fn values(list: &[(char, f64)]) -> AxisValues {
    let mut values = AxisValues::NONE;
    for &(letter, value) in list {
        values.put(AxisValues::index(letter).unwrap(), value);
    }
    values
}

/// A machine with X Y Z B C: home, and a tool change position of X and Z; C states none.
fn machine() -> ReferencePoints {
    ReferencePoints {
        machine: "M".to_owned(),
        axes: 0b110111,
        endless: 0,
        first: values(&[('X', -365.0), ('Y', 224.0), ('Z', 610.0), ('B', 0.25)]),
        second: values(&[('X', -100.0), ('Y', 224.0), ('Z', 500.0), ('B', 0.25)]),
        tool_change: values(&[]),
    }
}

fn on_machine(dialect: Dialect) -> Settings {
    Settings { dialect, reference_points: Some(machine()), ..Settings::default() }
}

const ISO: [Dialect; 3] = [Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc];

#[test]
fn named_axes_go_by_the_intermediate_point_to_the_reference_point() {
    for dialect in ISO {
        let settings = on_machine(dialect);
        let ops = read_with("G21 G90 G0 X10. Y20. Z30.\nG91 G28 Z0\n", &settings).unwrap();
        let targets = motions(&ops);
        // An increment of zero is where the axis is: no motion of its own.
        assert_eq!(targets.len(), 2, "{dialect:?}");
        assert_eq!((targets[1].end_base, targets[1].programmed), (values(&[('Z', 610.0)]), 0b100), "{dialect:?}");
        assert!(targets[1].machine_coordinates);
        assert!(!ops.iter().any(|op| matches!(op, Op::Note(text) if text.contains("machine zero"))), "{dialect:?}");
        // The intermediate point of G90, and of G91 with an increment.
        for (block, z) in [("G28 Z100.", 100.0), ("G91 G28 Z25.", 55.0)] {
            let ops = read_with(&format!("G21 G90 G0 X10. Y20. Z30.\n{block}\n"), &settings).unwrap();
            let targets = motions(&ops);
            assert_eq!(targets.len(), 3, "{dialect:?} {block}");
            assert_eq!(
                (targets[1].end_base.get(2), targets[1].machine_coordinates),
                (Some(z), false),
                "{dialect:?} {block}"
            );
            assert_eq!(
                (targets[2].end_base.get(2), targets[2].programmed),
                (Some(610.0), 0b100),
                "{dialect:?} {block}"
            );
        }
        // The second point: tool change, else home.
        // A LinuxCNC takes no P here.
        let second = if dialect == Dialect::LinuxCnc { "G30" } else { "G30 P2" };
        let text = format!("G21 G90 G0 X10. Y20. Z30. B0\nG91 {second} X0 Y0 Z0 B0\n");
        let ops = read_with(&text, &settings).unwrap();
        assert_eq!(motions(&ops)[1].end_base, machine().second, "{dialect:?}");
    }
}

#[test]
fn no_axis_named_means_every_axis_of_the_machine() {
    for dialect in [Dialect::Haas, Dialect::LinuxCnc] {
        let mut settings = on_machine(dialect);
        let error = read_with("G21 G90 G0 X1. Y2. Z3.\nG28\n", &settings).unwrap_err();
        assert!(error.starts_with("nc-position-unknown") && error.contains("sends C"), "{error}");
        let points = settings.reference_points.as_mut().unwrap();
        points.first.put(5, 0.5);
        let all = points.first;
        let ops = read_with("G21 G90 G0 X1. Y2. Z3.\nG28\n", &settings).unwrap();
        assert_eq!((motions(&ops)[1].end_base, motions(&ops)[1].programmed), (all, 0b110111), "{dialect:?}");
    }
    assert!(read_with("G21 G28\n", &on_machine(Dialect::Fanuc)).unwrap_err().starts_with("nc-missing-value"));
}

#[test]
fn a_point_that_nobody_states_is_refused_by_name() {
    for dialect in ISO {
        let error = read_with("G21 G90 G0 X1. Y2. Z3. C0\nG91 G28 C0\n", &on_machine(dialect)).unwrap_err();
        assert!(error.starts_with("nc-position-unknown"), "{error}");
        for word in ["G28 sends C", "\"M\"", "home_deg", "p.nc:2"] {
            let diagnostic =
                Program::from_text("p.nc", "G21 G90 G0 X1. Y2. Z3. C0\nG91 G28 C0\n", &on_machine(dialect))
                    .unwrap()
                    .find_map(Result::err)
                    .unwrap();
            let message = format!("{diagnostic} {}", diagnostic.help.clone().unwrap_or_default());
            assert!(message.contains(word), "{word}: {message}");
        }
        let error = read_with("G21 G90 G0 X1. Y2. Z3. A0\nG91 G28 A0\n", &on_machine(dialect)).unwrap_err();
        assert!(error.contains("no axis of this letter"), "{error}");
        // Parameters of the settings come before the machine, in mm and degrees.
        let mut settings = on_machine(dialect);
        settings.variables.insert("#5166".to_owned(), 90.0);
        let ops = read_with("G21 G90 G0 X1. Y2. Z3. C0\nG91 G28 Z0 C0\n", &settings).unwrap();
        assert_eq!(motions(&ops)[1].end_base, values(&[('Z', 610.0), ('C', std::f64::consts::FRAC_PI_2)]));
        // No machine in sight, as where a program is written out again.
        let nowhere = Settings { reference_points: Some(ReferencePoints::default()), ..on_machine(dialect) };
        let error = read_with("G21 G90 G0 X1. Y2. Z3.\nG91 G28 Z0\n", &nowhere).unwrap_err();
        assert!(error.contains("no machine is named"), "{error}");
    }
}

/// The machine drives X and Y to its tool change position; Z, which it does not state, is unknown after M6.
#[test]
fn the_tool_change_position_of_the_machine_is_known() {
    let text = "G21 G90 G17 G54\nG0 X1. Y2. Z50.\nT1 M6\nG91 G0 X-10.\nG90 G3 X-115. Y229. I-5. J0. F100.\nM30\n";
    let nothing = on_machine(Dialect::Fanuc);
    let error = read_with(text, &nothing).unwrap_err();
    assert!(error.contains("the position of `X` is not known"), "{error}");
    let mut points = machine();
    points.tool_change = values(&[('X', -100.0), ('Y', 224.0)]);
    let ops = read_with(text, &Settings { reference_points: Some(points.clone()), ..nothing.clone() }).unwrap();
    let ends: Vec<_> = motions(&ops).iter().map(|m| (m.end.get(0), m.end.get(1), m.end.get(2))).collect();
    assert_eq!(ends[1..], [(Some(-110.0), Some(224.0), None)]);
    assert!(ops.iter().any(|op| matches!(op, Op::Arc(a) if a.radius == 5.0 && a.motion.end.get(1) == Some(229.0))));
    let z = "G21 G90 G17 G54\nT1 M6\nG91 G0 Z-10.\nM30\n";
    let error = read_with(z, &Settings { reference_points: Some(points), ..nothing }).unwrap_err();
    assert!(error.contains("the position of `Z` is not known"), "{error}");
}

/// Haas, *Mill operator's manual*, G28: "G28 cancels tool length offsets for the following lines of code".
#[test]
fn on_a_haas_g28_cancels_the_tool_length() {
    let edges = |dialect, text: &str| -> Vec<u32> {
        let ops = read_with(text, &on_machine(dialect)).unwrap();
        ops.iter()
            .filter_map(|op| if let Op::Offset(Offset::ToolEdge { edge }) = op { Some(*edge) } else { None })
            .collect()
    };
    let text = "G21 G90 G0 X1. Y2.\nG43 H4 Z50.\nG91 G28 Z0\n";
    assert_eq!(edges(Dialect::Haas, text), [4, 0]);
    assert_eq!(edges(Dialect::LinuxCnc, text), [4, 0, 4]);
    assert_eq!(edges(Dialect::Haas, "G21 G90 G0 X1. Y2.\nG43 H4 Z50.\nG53 G0 Z0\n"), [4, 0, 4]);
    // G234 ends with it.
    let ops =
        read_with("G21 G90 G0 B0 C0\nG234 H4\nG0 X1. Y2. Z50.\nG91 G28 Z0\nG90 G0 B90.\n", &on_machine(Dialect::Haas));
    let ops = ops.unwrap();
    let tcp: Vec<bool> =
        ops.iter().filter_map(|op| if let Op::Tcp(Tcp { on, .. }) = op { Some(*on) } else { None }).collect();
    assert_eq!(tcp, [true, false]);
    assert!(!ops.iter().any(|op| matches!(op, Op::Note(text) if text.starts_with(ASSUMED))), "{ops:?}");
}

fn assumed(text: &str, dialect: Dialect) -> usize {
    let ops = read_with(text, &on_machine(dialect)).unwrap();
    ops.iter().filter(|op| matches!(op, Op::Note(text) if text.starts_with(ASSUMED))).count()
}

#[test]
fn a_tool_length_that_depends_on_the_set_up_of_a_fanuc_is_reported() {
    let head = "G21 G90 G0 X1. Y2.\nG43 H4 Z50.\n";
    for way in ["G91 G28 Z0", "G53 Z0", "G91 G30 Z0"] {
        let all = |tail: &str, dialect| assumed(&format!("{head}{way}\nG90\n{tail}\n"), dialect);
        assert_eq!(all("G0 Z10.", Dialect::Fanuc), 1, "{way}");
        assert_eq!(all("G0 X5.\nG99 G81 Z-3. R2. F100.\nX7.", Dialect::Fanuc), 1, "{way}");
        // Said once; not where the program says it, nor where Z stays, nor on the other controls.
        assert_eq!(all("G0 Z10.\nZ5.", Dialect::Fanuc), 1, "{way}");
        // A length that changes without Z is an assumption of its own.
        assert_eq!(all("G49\nZ10.", Dialect::Fanuc), 1, "{way}");
        for clear in ["G43 H4 Z10.", "G49 Z10.", "H4\nZ10.", "X10. Y5."] {
            assert_eq!(all(clear, Dialect::Fanuc), 0, "{way} {clear}");
        }
        assert_eq!(all("G0 Z10.", Dialect::LinuxCnc), 0, "{way}");
        assert_eq!(all("G0 Z10.", Dialect::Haas), 0, "{way}");
    }
    assert_eq!(assumed(&format!("{head}G53 X0 Y0\nG0 Z10."), Dialect::Fanuc), 0);
    assert_eq!(assumed("G21 G90 G0 X1. Y2. Z50.\nG91 G28 Z0\nG90 G0 Z10.", Dialect::Fanuc), 0);
}

#[test]
fn words_that_switch_the_kinematics_are_refused_by_name() {
    for dialect in ISO {
        for word in ["M428", "M429", "M430", "M129"] {
            let error = read_with(&format!("G21 G0 X1.\n{word}\n"), &on_machine(dialect)).unwrap_err();
            assert!(error.starts_with("nc-unsupported-word"), "{dialect:?} {error}");
            assert!(error.contains(word) && error.contains("kinematics"), "{dialect:?} {error}");
            // Also where the word is not executed.
            let faults = proveout_nc::check_text("p.nc", &format!("G21 G0 X1.\nM30\n{word}\n"), &on_machine(dialect));
            assert!(faults.iter().all(|f| f.code != "nc-unknown-word"), "{faults:?}");
        }
    }
    // TCPM of a Hurco and of older LinuxCNC configurations; on a Haas an output for the user.
    assert!(read_with("G21 G0 X1.\nM128\n", &on_machine(Dialect::Fanuc)).is_err());
    assert!(read_with("G21 G0 X1.\nM128\n", &on_machine(Dialect::LinuxCnc)).is_err());
    assert!(read_with("G21 G0 X1.\nM128\n", &on_machine(Dialect::Haas)).is_ok());
    // The analog output that selects the kinematics in the documentation of LinuxCNC.
    for (block, refused) in [("M68 E3 Q1", true), ("M67 E3 Q0", true), ("M68 E0 Q500", false), ("M64 P3", false)] {
        let result = read_with(&format!("G21 G0 X1.\n{block}\n"), &on_machine(Dialect::LinuxCnc));
        assert_eq!(result.as_ref().is_err_and(|e| e.contains("kinematics")), refused, "{block}: {result:?}");
    }
    for (dialect, block, refused) in [
        (Dialect::Siemens840d, "TRAORI(2)", true),
        (Dialect::Siemens840d, "TRAORI(1)", false),
        (Dialect::Siemens840d, "TRAORI(1,0,0,1)", false),
        (Dialect::Siemens840d, "TRAORI(1,0,1,0)", true),
        (Dialect::Siemens840d, "TRAORI(1,0,0,1,0,15)", true),
        (Dialect::Heidenhain, "L M138 C", true),
        (Dialect::Heidenhain, "L M138 B C", false),
        (Dialect::Heidenhain, "FUNCTION MODE MILL", false),
        (Dialect::Heidenhain, "FUNCTION MODE MILL KINEMATICS \"HEAD\"", true),
        (Dialect::Heidenhain, "FUNCTION MODE SET \"ROTARY\"", true),
    ] {
        let result = read_with(&format!("{block}\n"), &on_machine(dialect));
        assert_eq!(
            result.as_ref().is_err_and(|e| e.starts_with("nc-unsupported-word")),
            refused,
            "{block}: {result:?}"
        );
    }
}

/// Each word that switches a kinematics on, with what the machine must list for it.
const SWITCHES: [(Dialect, &str, bool); 12] = [
    (Dialect::Fanuc, "G21 G90 G0 B0 C0\nG43.4 H1", true),
    (Dialect::Fanuc, "G21 G90 G0 B0 C0\nG43.5 H1", true),
    (Dialect::Fanuc, "G21 G68.2 X0 Y0 Z0 I0 J30. K0", false),
    (Dialect::Haas, "G21 G90 G0 B0 C0\nG234 H1", true),
    (Dialect::Haas, "G21 G90 G0 B30. C0\nG254", false),
    (Dialect::Siemens840d, "TRAORI", true),
    (Dialect::Siemens840d, "TRAORI(1)", true),
    (Dialect::Siemens840d, "CYCLE800(0,\"TC1\",0,57,0,0,0,0,30,0,0,0,0,1)", false),
    (Dialect::Heidenhain, "L M128", true),
    (Dialect::Heidenhain, "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS", true),
    (Dialect::Heidenhain, "PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY", false),
    (Dialect::Heidenhain, "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+30 C+0", false),
];

#[test]
fn a_kinematics_that_the_machine_does_not_list_is_refused() {
    for (dialect, text, tcp) in SWITCHES {
        let with = |kinematics: Option<Kinematics>| {
            read_with(&format!("{text}\n"), &Settings { kinematics, ..on_machine(dialect) })
        };
        let listed = |tcp, tilted_plane| Some(Kinematics { machine: "Mill 3".to_owned(), tcp, tilted_plane });
        assert!(with(None).is_ok(), "{text}: {:?}", with(None));
        assert!(with(listed(tcp, !tcp)).is_ok(), "{text}: {:?}", with(listed(tcp, !tcp)));
        for none in [listed(false, false), listed(!tcp, tcp)] {
            let error = with(none).unwrap_err();
            assert!(error.starts_with("nc-unsupported-word"), "{text}: {error}");
            assert!(error.contains("kinematics of machine \"Mill 3\""), "{text}: {error}");
        }
    }
    // What switches off is never refused.
    for (dialect, text) in [
        (Dialect::Fanuc, "G21 G49\nG69"),
        (Dialect::Haas, "G21 G255"),
        (Dialect::Siemens840d, "TRAFOOF\nCYCLE800()"),
        (Dialect::Heidenhain, "L M129\nPLANE RESET STAY\nFUNCTION RESET TCPM"),
    ] {
        let kinematics = Some(Kinematics::default());
        let result = read_with(&format!("{text}\n"), &Settings { kinematics, ..on_machine(dialect) });
        assert!(result.is_ok(), "{text}: {result:?}");
    }
}

/// Tool center point control, a point, a motion of machine axes, a turn: no stale coordinate is handed out,
/// and nothing is computed from one.
#[test]
fn behind_machine_coordinates_under_tcp_no_coordinate_of_the_tip_is_known() {
    struct Way {
        dialect: Dialect,
        head: &'static str,
        machine: &'static [&'static str],
        turn: &'static str,
        increment: &'static str,
        assumed: bool,
    }
    let fanuc = |head| Way {
        dialect: Dialect::Fanuc,
        head,
        machine: &["G53 Z0", "G91 G28 Z0", "G53 X0", "G53 C0", "G91 G30 Z0 B0"],
        turn: "G90 G0 B80.",
        increment: "G91 G1 X1. F100.",
        assumed: true,
    };
    let ways = [
        fanuc("G21 G90 G0 B90. C0\nG43.4 H1\nG0 X150. Y50. Z10."),
        fanuc("G21 G90 G0 B90. C0\nG43.5 H1\nG0 X150. Y50. Z10."),
        Way {
            dialect: Dialect::Haas,
            head: "G21 G90 G0 B90. C0\nG234 H1\nG0 X150. Y50. Z10.",
            machine: &["G53 G0 Z650.", "G53 G0 Y0", "G53 G0 B0"],
            turn: "G0 B80.",
            increment: "G91 G1 Y1. F100.",
            assumed: true,
        },
        Way {
            dialect: Dialect::Siemens840d,
            head: "G54 G90 G0 B90 C0\nTRAORI\nG0 X150 Y50 Z10",
            machine: &["SUPA G0 Z650", "G53 G0 Z650", "G153 G0 X0", "SUPA G0 B0"],
            turn: "G0 B80",
            increment: "G91 G1 X1 F100",
            assumed: true,
        },
        Way {
            dialect: Dialect::Heidenhain,
            head: "L B+90 C+0 R0 FMAX\nM128\nL X+150 Y+50 Z+10 R0 FMAX",
            machine: &["L Z+650 R0 FMAX M91", "L X+0 R0 FMAX M91", "L B+0 R0 FMAX M91", "L M140 MB 50"],
            turn: "L B+80 R0 FMAX",
            increment: "L IX+1 R0 F100",
            assumed: true,
        },
        Way {
            dialect: Dialect::Heidenhain,
            head: "L B+90 C+0 R0 FMAX\nFUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\nL X+150 Y+50 Z+10 R0 FMAX",
            machine: &["L Z+650 R0 FMAX M91"],
            turn: "L B+80 R0 FMAX",
            increment: "L IZ+1 R0 F100",
            assumed: true,
        },
        // Planes: coordinates are those of the table too, and machine coordinates are what they are.
        Way {
            dialect: Dialect::Siemens840d,
            head: "G54 G90\nCYCLE800(0,\"TC1\",0,57,0,0,0,0,30,0,0,0,0,1)\nG0 X150 Y50 Z10",
            machine: &["SUPA G0 Z650"],
            turn: "",
            increment: "G91 G1 X1 F100",
            assumed: false,
        },
        Way {
            dialect: Dialect::Fanuc,
            head: "G21 G90 G68.2 X0 Y0 Z0 I0 J30. K0\nG53.1\nG0 X150. Y50. Z10.",
            machine: &["G53 Z0"],
            turn: "",
            increment: "G91 G1 Y1. F100.",
            assumed: false,
        },
    ];
    for way in ways {
        let mut settings = on_machine(way.dialect);
        settings.reference_points.as_mut().unwrap().first.put(5, 0.0);
        for machine in way.machine {
            let text = format!("{}\n{machine}\n", way.head);
            let before = read_with(&text, &settings).unwrap_or_else(|e| panic!("{text}{e}"));
            // What DIR of CYCLE800 refers to is another assumption, of the head.
            let counts = |text: &str| text.starts_with(ASSUMED) && !text.contains("parameters.tilt_reference");
            let notes = before.iter().filter(|op| matches!(op, Op::Note(text) if counts(text))).count();
            let retract = machine.contains("M140");
            assert_eq!(notes, usize::from(way.assumed && !retract), "{text}{before:?}");
            if !way.turn.is_empty() {
                let ops = read_with(&format!("{text}{}\n", way.turn), &settings).unwrap();
                let last = *motions(&ops).last().unwrap();
                for axis in 0..3 {
                    assert_eq!((last.end_base.get(axis), last.end.get(axis)), (None, None), "{text}{last:?}");
                }
                // The turn itself is as programmed.
                assert_eq!(last.end_base.get(4).map(|b| (b.to_degrees() * 1e9).round() / 1e9), Some(80.0), "{text}");
            }
            let error = read_with(&format!("{text}{}\n", way.increment), &settings).unwrap_err();
            assert!(error.starts_with("nc-position-unknown"), "{text}{error}");
        }
    }
}

/// Without tool center point control the other axes stay known, as ever.
#[test]
fn behind_machine_coordinates_of_one_axis_the_others_are_known() {
    // An ISO control knows Z itself, where no tool length is between the axis and the tip.
    for (dialect, text, z) in [
        (Dialect::Fanuc, "G21 G90 G0 X150. Y50. Z10.\nG53 Z-5.\nG91 G1 X1. F100.", Some(-5.0)),
        (Dialect::Fanuc, "G21 G90 G43 H1 G0 X150. Y50. Z10.\nG53 Z-5.\nG91 G1 X1. F100.", None),
        (Dialect::Haas, "G21 G90 G0 X150. Y50. Z10.\nG53 Z-7.\nG91 G1 X1. F100.", Some(-7.0)),
        (Dialect::LinuxCnc, "G21 G90 G0 X150. Y50. Z10.\nG53 G0 Z-9\nG91 G1 X1. F100.", Some(-9.0)),
        (Dialect::Siemens840d, "G54 G90 G0 X150 Y50 Z10\nSUPA G0 Z650\nG91 G1 X1 F100", None),
        (Dialect::Heidenhain, "L X+150 Y+50 Z+10 R0 FMAX\nL Z+650 R0 FMAX M91\nL IX+1 R0 F100", None),
    ] {
        let ops = read_with(&format!("{text}\n"), &on_machine(dialect)).unwrap_or_else(|e| panic!("{text}\n{e}"));
        let last = *motions(&ops).last().unwrap();
        assert_eq!((last.end_base.get(0), last.end_base.get(2)), (Some(151.0), z), "{text}");
    }
}
