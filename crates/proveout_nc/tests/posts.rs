//! What a post writes, its reader reads as the same motions: for every dialect that has both.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use crate::common;
use crate::common::{ops, post, same_commands};
use proptest::prelude::*;
use proveout_nc::post::{EdgeNumbers, PostError, PostSettings, post_for};
use proveout_nc::{Dialect, Op, Settings, WorkOffset};

/// Dialects that the posts write.
const TARGETS: [Dialect; 6] =
    [Dialect::Siemens840d, Dialect::Fanuc, Dialect::Haas, Dialect::LinuxCnc, Dialect::Heidenhain, Dialect::Apt];

fn settings(dialect: Dialect) -> Settings {
    let mut settings = Settings { dialect, ..Settings::default() };
    let offset = WorkOffset { translation: [100.0, -20.0, 30.0], rotary: [0.0; 3] };
    // The first offset has another name on a TNC.
    for word in ["G54", "PRESET1"] {
        settings.work_offsets.insert(word.to_owned(), offset);
    }
    settings
}

fn formats(from: Dialect, to: Dialect) -> Vec<PostSettings> {
    let offsets = settings(to).work_offsets;
    let plain = PostSettings { work_offsets: offsets, ..PostSettings::between(from, to) };
    vec![
        PostSettings { block_number_step: Some(5), modal: false, ..plain.clone() },
        PostSettings { trailing_zeros: true, decimal_point: true, modal: true, ..plain.clone() },
        PostSettings { arc_radius: true, ..plain.clone() },
        plain.in_inches(),
    ]
}

/// Writes a program in a dialect and reads it back; the motions must be the same within the decimals.
fn round_trip(from: Dialect, text: &str, to: Dialect) {
    let first = ops(from, text, &settings(from));
    for format in formats(from, to) {
        if to == Dialect::Heidenhain && format.inches && text.contains("MMPR") {
            let error = post(&first, to, format).unwrap_err().to_string();
            assert!(error.contains("feed per revolution in inch"), "{error}");
            continue;
        }
        let written = post(&first, to, format.clone()).unwrap_or_else(|e| panic!("{to:?}: {e}\n{text}"));
        let second = ops(to, &written, &settings(to));
        // Half of the last decimal, of an inch where that is the unit; rounding adds up in sums of two.
        let unit = if format.inches { 25.4 } else { 1.0 };
        let length = 1.2 * unit * 10f64.powi(-(format.length_decimals as i32));
        same_commands(&first, &second, length, &format!("{to:?} {format:?}\n{text}\n---\n{written}"));
    }
}

const PLAIN: &str = "\
PARTNO/PLAIN
LOADTL/3
SPINDL/8000,RPM,CLW
COOLNT/ON
RAPID
GOTO/0,0,50
RAPID
GOTO/10.1234,-20.5678,5
FEDRAT/800,MMPM
GOTO/10.1234,-20.5678,-1.25
GOTO/30,-20.5678,-1.25
CIRCLE/30,-10.5678,-1.25,0,0,1,10
GOTO/40,-10.5678,-1.25
CIRCLE/40,-5.5678,-1.25,0,0,-1,5
GOTO/40,-0.5678,-1.25
MOVARC/45,-0.5678,-1.25,0,0,1,5,ANGLE,360
GOTO/40,-0.5678,-1.25
CIRCLE/45,-0.5678,-1.25,0,0,-1,5
GOTO/50,-0.5678,-4
FEDRAT/0.15,MMPR
GOTO/60,0,-4
DELAY/0.25
RAPID
GOTO/60,0,50
COOLNT/OFF
SPINDL/OFF
FINI
";

const VECTORS: &str = "\
LOADTL/7
SPINDL/12000,RPM,CLW
MULTAX/ON
RAPID
GOTO/0,0,50,0,0,1
FEDRAT/1500,MMPM
GOTO/10,0,40,0.6,0,0.8
GOTO/20,5,40,0,0.28,0.96
GOTO/30,5,41,-0.352,0.36,0.864
RAPID
GOTO/30,5,90,0,0,1
SPINDL/OFF
FINI
";

/// Dialects whose reader takes what the post writes; a reader that is not there yet gives the code
/// `nc-dialect`.
fn readable(dialect: Dialect) -> bool {
    let probe = proveout_nc::Program::from_text("probe", "", &Settings { dialect, ..Settings::default() });
    probe.is_ok()
}

#[test]
fn plain_milling_goes_through_every_post_and_back() {
    for to in TARGETS.into_iter().filter(|d| readable(*d)) {
        round_trip(Dialect::Apt, PLAIN, to);
    }
}

#[test]
fn tool_vectors_go_through_every_post_that_has_them() {
    for to in [Dialect::Siemens840d, Dialect::Fanuc, Dialect::Heidenhain, Dialect::Apt] {
        if readable(to) {
            round_trip(Dialect::Apt, VECTORS, to);
        }
    }
    for to in [Dialect::Haas, Dialect::LinuxCnc] {
        let first = ops(Dialect::Apt, VECTORS, &settings(Dialect::Apt));
        let error = post(&first, to, PostSettings::between(Dialect::Apt, to)).unwrap_err();
        assert!(matches!(error, PostError::Unsupported { .. }), "{error}");
        assert!(error.to_string().contains("program:5"), "{error}");
    }
}

#[test]
fn a_number_for_the_length_is_chosen_for_the_control() {
    let first = ops(Dialect::Apt, PLAIN, &settings(Dialect::Apt));
    let text = |to| post(&first, to, PostSettings::between(Dialect::Apt, to)).unwrap();
    assert!(text(Dialect::Fanuc).contains("T3\nM6\nG43 H3\n"), "{}", text(Dialect::Fanuc));
    assert!(text(Dialect::Siemens840d).contains("T3\nM6\nD1\n"));
    assert!(text(Dialect::Heidenhain).contains("TOOL CALL 3 Z"));
    let as_programmed = PostSettings { edge_numbers: EdgeNumbers::AsProgrammed, ..PostSettings::default() };
    assert!(post(&first, Dialect::Haas, as_programmed).unwrap().contains("G43 H1"));
}

#[test]
fn an_iso_whole_number_has_its_point() {
    let first = ops(Dialect::Apt, PLAIN, &settings(Dialect::Apt));
    let text = post(&first, Dialect::Fanuc, PostSettings::between(Dialect::Apt, Dialect::Fanuc)).unwrap();
    for word in text.lines().filter(|l| !l.starts_with(['(', '%', 'O'])).flat_map(str::split_whitespace) {
        if word.starts_with(['X', 'Y', 'Z', 'I', 'J', 'K', 'R', 'F']) {
            assert!(word.contains('.'), "{word}\n{text}");
        }
    }
    assert!(text.starts_with("%\nO0001\nG21 G17 G40 G49 G80 G90 G94\n") && text.ends_with("M30\n%\n"), "{text}");
}

#[test]
fn header_and_footer_are_written_as_they_stand() {
    let first = ops(Dialect::Apt, PLAIN, &settings(Dialect::Apt));
    for to in TARGETS {
        let format = PostSettings {
            header: Some(vec!["HEAD".to_owned()]),
            footer: vec!["FOOT".to_owned()],
            ..PostSettings::between(Dialect::Apt, to)
        };
        let text = post(&first, to, format).unwrap();
        assert!(text.starts_with("HEAD\n") && text.ends_with("FOOT\n"), "{to:?}\n{text}");
    }
}

#[test]
fn what_a_language_cannot_say_is_refused_with_its_place() {
    let cases = [
        ("G0 X0 Y0 Z0 B10\n", Dialect::Apt, "rotary axes"),
        ("SUPA G0 Z500\n", Dialect::Apt, "machine coordinates"),
        ("G93\nG1 X1 Y1 Z1 F10\n", Dialect::Heidenhain, "inverse time"),
        ("T=\"MILL\" M6\n", Dialect::Fanuc, "by number"),
        ("G4 S3\n", Dialect::LinuxCnc, "revolutions"),
        ("G60\nG0 X1\n", Dialect::Heidenhain, "exact stop"),
        ("G0 X0 Y0 Z0\nCIP X=5 Y=0 Z=0 I1=0 J1=3 K1=4 F100\n", Dialect::Fanuc, "outside"),
    ];
    for (text, to, what) in cases {
        let first = ops(Dialect::Siemens840d, text, &settings(Dialect::Siemens840d));
        let error = post(&first, to, PostSettings::between(Dialect::Siemens840d, to)).unwrap_err().to_string();
        assert!(error.contains(what) && error.starts_with("program:") && error.contains("; "), "{error}");
    }
    let none = post_for(Dialect::HeidenhainIso, PostSettings::default(), Vec::new());
    assert!(matches!(none, Err(PostError::NoPost { .. })));
}

#[test]
fn a_swivel_plane_comes_back_as_cycle800() {
    let text = "G54\nT1 M6 D1\nG0 X1 Y2 Z300\nCYCLE800(0,\"TC\",0,57,1,2,3,20,-35,70,0,0,0,1)\nG0 X5 Y6 Z7\nG1 Z-2 F100\nTRANS X1\n\
                G1 X3 Y4 Z5\nCYCLE800(0,\"TC\",0,57,0,0,0,0,90,0,0,0,0,1)\nG0 X0 Y0 Z5\nCYCLE800()\nG0 X0 Y0 Z300\nM30\n";
    round_trip(Dialect::Siemens840d, text, Dialect::Siemens840d);
    let first = ops(Dialect::Siemens840d, text, &settings(Dialect::Siemens840d));
    let format = PostSettings {
        work_offsets: settings(Dialect::Siemens840d).work_offsets,
        ..PostSettings::between(Dialect::Siemens840d, Dialect::Siemens840d)
    };
    let written = post(&first, Dialect::Siemens840d, format).unwrap();
    assert_eq!(written.matches("CYCLE800(").count(), 3, "{written}");
}

prop_compose! {
    /// A path of straight blocks and arcs in CL data, with two more decimals than are written.
    fn path()(steps in prop::collection::vec((0..4u8, -50.0..50.0f64, -50.0..50.0f64, -20.0..20.0f64, 3.0..30.0f64, 5.0..355.0f64), 1..25),
              vectors in any::<bool>()) -> (String, bool) {
        let mut text = String::from("LOADTL/2\nFEDRAT/500,MMPM\nRAPID\n");
        text.push_str(if vectors { "GOTO/1,2,60,0,0,1\n" } else { "GOTO/1,2,60\n" });
        for (kind, x, y, z, r, turn) in steps {
            match kind {
                0 => text.push_str(&format!("RAPID\nGOTO/{x:.5},{y:.5},{z:.5}\n")),
                1 if vectors => {
                    // A unit vector within 70 degrees of the z axis.
                    let (a, b) = (x * 0.024, y * 0.06);
                    let v = [a.sin() * b.cos(), a.sin() * b.sin(), a.cos()];
                    text.push_str(&format!("GOTO/{x:.5},{y:.5},{z:.5},{:.8},{:.8},{:.8}\n", v[0], v[1], v[2]));
                }
                1 => text.push_str(&format!("GOTO/{x:.5},{y:.5},{z:.5}\n")),
                _ => {
                    let n = if kind == 2 { 1 } else { -1 };
                    let start = [x + r, y];
                    let angle = turn.to_radians() * f64::from(n);
                    let end = [x + r * angle.cos(), y + r * angle.sin()];
                    text.push_str(&format!("GOTO/{:.5},{:.5},{z:.5}\nCIRCLE/{x:.5},{y:.5},{z:.5},0,0,{n},{r:.5}\nGOTO/{:.5},{:.5},{:.5}\n",
                        start[0], start[1], end[0], end[1], z + if turn > 180.0 { 1.0 } else { 0.0 }));
                }
            }
        }
        text.push_str("FINI\n");
        (text, vectors)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: common::cases(40), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_paths_survive_every_pair((text, vectors) in path()) {
        for to in TARGETS.into_iter().filter(|d| readable(*d)) {
            let can = !vectors || matches!(to, Dialect::Siemens840d | Dialect::Apt);
            if can {
                round_trip(Dialect::Apt, &text, to);
            }
        }
    }

    #[test]
    fn two_posts_in_a_row_say_the_same((text, _) in path().prop_filter("no vectors", |p| !p.1), a in 0..6usize, b in 0..6usize) {
        let readers: Vec<Dialect> = TARGETS.into_iter().filter(|d| readable(*d)).collect();
        let (a, b) = (readers[a % readers.len()], readers[b % readers.len()]);
        let first = ops(Dialect::Apt, &text, &settings(Dialect::Apt));
        let format = |from, to| PostSettings { work_offsets: settings(to).work_offsets, ..PostSettings::between(from, to) };
        let one = post(&first, a, format(Dialect::Apt, a)).unwrap();
        let middle = ops(a, &one, &settings(a));
        let two = post(&middle, b, format(a, b)).unwrap_or_else(|e| panic!("{a:?} {b:?}: {e}\n{one}"));
        let last = ops(b, &two, &settings(b));
        same_commands(&first, &last, 2.5e-3, &format!("{a:?} {b:?}\n{text}\n---\n{one}\n---\n{two}"));
    }
}

#[test]
fn commands_that_are_no_motion_come_back_too() {
    for to in TARGETS.into_iter().filter(|d| readable(*d)) {
        let first = ops(Dialect::Apt, PLAIN, &settings(Dialect::Apt));
        let format =
            PostSettings { work_offsets: settings(to).work_offsets, ..PostSettings::between(Dialect::Apt, to) };
        let written = post(&first, to, format).unwrap();
        let second = ops(to, &written, &settings(to));
        let of = |list: &[proveout_nc::Command], test: fn(&Op) -> bool| {
            list.iter().map(|c| c.op.clone()).filter(test).collect::<Vec<_>>()
        };
        let spindle =
            |op: &Op| matches!(op, Op::Spindle(_) | Op::Coolant(_) | Op::Dwell(_) | Op::Stop { .. } | Op::End);
        let mut got = of(&second, spindle);
        // A speed that is called before its direction may come as a command of its own.
        got.dedup();
        assert_eq!(of(&first, spindle), got, "{to:?}\n{written}");
        let changes = |op: &Op| matches!(op, Op::Tool(proveout_nc::ToolAction::Change(_)));
        assert_eq!(of(&first, changes), of(&second, changes), "{to:?}\n{written}");
    }
}
