//! How circles of CL data run, and what its lengths count: known from the system that wrote it, checked by
//! the path, reported where neither decides.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fmt::Write;

use proveout_nc::{ASSUMED, Control, Dialect, Op, Program, Settings};

fn ops(text: &str, settings: &Settings) -> Vec<Op> {
    let program = Program::from_text("part.cls", text, settings).unwrap_or_else(|e| panic!("{e}\n{text}"));
    program.map(|c| c.unwrap_or_else(|e| panic!("{e}\n{text}")).op).collect()
}

fn settings() -> Settings {
    Settings { dialect: Dialect::Apt, ..Settings::default() }
}

fn assumed<'a>(ops: &'a [Op], word: &str) -> Vec<&'a str> {
    ops.iter()
        .filter_map(|op| match op {
            Op::Note(text) => text.strip_prefix(ASSUMED).filter(|text| text.contains(word)),
            _ => None,
        })
        .collect()
}

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *seed;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// A path of lines with tangent arcs between them, and the sense of each arc (true: clockwise seen from
/// above).
///
/// `flip`: the axis is written so that the arc runs clockwise about it. `sharp`: no line is tangent to an
/// arc.
fn path(seed: &mut u64, flip: bool, sharp: bool, eleven: bool) -> (String, Vec<bool>) {
    let (mut text, mut senses) = (String::new(), Vec::new());
    let (mut x, mut y, mut heading) = (0.0_f64, 0.0_f64, random(seed) * 6.0);
    writeln!(text, "GOTO/{x:.6},{y:.6},0").unwrap();
    for _ in 0..1 + (random(seed) * 5.0) as usize {
        let length = 5.0 + 20.0 * random(seed);
        (x, y) = (x + length * heading.cos(), y + length * heading.sin());
        writeln!(text, "GOTO/{x:.6},{y:.6},0").unwrap();
        if sharp {
            heading += 0.7;
        }
        let (clockwise, radius, turn) = (random(seed) < 0.5, 2.0 + 20.0 * random(seed), 0.3 + 2.5 * random(seed));
        let side = if clockwise { -1.0 } else { 1.0 };
        let (cx, cy) = (x - side * radius * heading.sin(), y + side * radius * heading.cos());
        let up = if clockwise == flip { 1 } else { -1 };
        let more = if eleven { ",0.06,0.5,10,0" } else { "" };
        writeln!(text, "CIRCLE/{cx:.6},{cy:.6},0,0,0,{up},{radius:.6}{more}").unwrap();
        heading += side * turn;
        (x, y) = (cx + side * radius * heading.sin(), cy - side * radius * heading.cos());
        writeln!(text, "GOTO/{x:.6},{y:.6},0").unwrap();
        senses.push(clockwise);
        if sharp {
            heading += 0.7;
        }
    }
    writeln!(text, "GOTO/{:.6},{:.6},0", x + 10.0 * heading.cos(), y + 10.0 * heading.sin()).unwrap();
    (text, senses)
}

fn senses_of(ops: &[Op]) -> Vec<bool> {
    ops.iter()
        .filter_map(|op| match op {
            Op::Arc(arc) => Some(arc.normal[2] < 0.0),
            _ => None,
        })
        .collect()
}

const NX: &str = "TOOL PATH/FINISH,TOOL,MILL\nTLDATA/MILL,10.0000,0.0000,75.0000,0.0000,0.0000\nFEDRAT/MMPM,250\n";
const CREO: &str =
    "$$*         Pro/CLfile  Version Wildfire 5.0\n$$-> MFGNO / PART\nPARTNO / PART\nUNITS / MM\nFEDRAT/250,MMPM\n";
const UNKNOWN: &str = "PARTNO/PART\nUNITS/MM\nFEDRAT/250,MMPM\n";

#[test]
fn circles_run_as_the_system_that_wrote_them_says_and_the_path_shows() {
    let mut seed = 11;
    for case in 0..300 {
        for (head, end, flip, eleven) in
            [(NX, "END-OF-PATH\n", true, true), (CREO, "FINI\n", false, false), (UNKNOWN, "FINI\n", false, false)]
        {
            let (path, truth) = path(&mut seed, flip, false, eleven);
            let text = format!("{head}{path}{end}");
            let found = ops(&text, &settings());
            assert_eq!(senses_of(&found), truth, "{case}\n{text}");
            assert!(assumed(&found, "circles").is_empty(), "{case}: {:?}\n{text}", assumed(&found, "circles"));
        }
    }
}

#[test]
fn a_path_that_contradicts_the_system_is_reported() {
    let mut seed = 12;
    for case in 0..200 {
        for (head, end, flip, eleven) in
            [(NX, "END-OF-PATH\n", false, true), (CREO, "FINI\n", true, false), (UNKNOWN, "FINI\n", true, false)]
        {
            let (path, truth) = path(&mut seed, flip, false, eleven);
            let text = format!("{head}{path}{end}");
            let found = ops(&text, &settings());
            assert_eq!(senses_of(&found), truth, "{case}\n{text}");
            let message = assumed(&found, "circles");
            assert!(message.len() == 1 && message[0].contains("arcs.clsf_sense"), "{case}: {message:?}\n{text}");
        }
    }
}

#[test]
fn circles_that_nothing_decides_are_reported() {
    let mut seed = 13;
    for case in 0..200 {
        let (path, _) = path(&mut seed, false, true, false);
        let text = format!("{UNKNOWN}{path}FINI\n");
        let ops_read = ops(&text, &settings());
        assert_eq!(assumed(&ops_read, "circles").len(), 1, "{case}\n{text}");
        // The control file states it: nothing is assumed, and each sense is the opposite of the other.
        let stated = |sense: &str| {
            let control = format!("dialect = \"apt\"\narcs.clsf_sense = \"{sense}\"\n");
            let found = ops(&text, &Settings::of_control(Control::from_text("c.toml", &control, None).unwrap()));
            assert!(assumed(&found, "circles").is_empty(), "{case}");
            senses_of(&found)
        };
        let (one, other) = (stated("clockwise"), stated("counter-clockwise"));
        assert!(one.iter().zip(&other).all(|(a, b)| a != b), "{case}\n{text}");
    }
}

/// The way along X that a text moves, mm, its feed in mm/min, and what is assumed of its lengths.
fn way_and_feed(text: &str) -> Result<(f64, f64, usize), String> {
    let program = Program::from_text("part.cls", text, &settings()).map_err(|e| e.to_string())?;
    let ops: Vec<Op> = program.map(|c| c.map(|c| c.op)).collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    let ends = ops.iter().filter_map(|op| match op {
        Op::Linear(m) | Op::Rapid(m) => m.end.get(0),
        _ => None,
    });
    let feed = ops.iter().find_map(|op| match op {
        Op::Feed(proveout_nc::Feed::PerTime(v)) => Some(v * 60.0),
        _ => None,
    });
    Ok((ends.fold(0.0, f64::max), feed.unwrap_or(0.0), assumed(&ops, "lengths").len()))
}

#[test]
fn lengths_without_units_count_as_the_feeds_do_and_are_reported() {
    for (head, feed, want) in [
        ("", "FEDRAT/10.,IPM", Ok((50.8, 254.0, 1))),
        ("", "FEDRAT/IPM,10.", Ok((50.8, 254.0, 1))),
        ("", "FEDRAT/250,MMPM", Ok((2.0, 250.0, 0))),
        ("", "FEDRAT/250", Ok((2.0, 250.0, 1))),
        ("UNITS/MM\n", "FEDRAT/10.,IPM", Ok((2.0, 254.0, 0))),
        ("UNITS/INCHES\n", "FEDRAT/250,MMPM", Ok((50.8, 250.0, 0))),
        ("UNITS/INCHES\n", "FEDRAT/10.,IPM", Ok((50.8, 254.0, 0))),
        ("", "FEDRAT/10.,IPM\nGOTO/1,0,0\nFEDRAT/250,MMPM", Err("contradict")),
    ] {
        for start in ["", "TOOL PATH/A,TOOL,B\n", "PARTNO/X\n"] {
            let text = format!("{start}{head}{feed}\nGOTO/0,0,0\nGOTO/2,0,0\nFINI\n");
            match (way_and_feed(&text), want) {
                (Ok((x, feed, notes)), Ok((want_x, want_feed, want_notes))) => {
                    assert!((x - want_x).abs() < 1e-9 && (feed - want_feed).abs() < 1e-6, "{x} {feed}\n{text}");
                    assert_eq!(notes, want_notes, "{text}");
                }
                (Err(message), Err(part)) => assert!(message.contains(part), "{message}\n{text}"),
                (found, _) => panic!("{found:?}\n{text}"),
            }
        }
    }
}

#[test]
fn the_last_operation_of_nx_ends_its_program() {
    let text = format!("{NX}GOTO/0,0,0\nGOTO/5,0,0\nEND-OF-PATH\n");
    let survey = |text: &str| proveout_nc::Survey::of_text("part.cls", text, &settings(), &mut |_, _| None);
    assert!(survey(&text).judged().is_empty());
    let two = format!("{text}{NX}GOTO/9,0,0\nEND-OF-PATH\n");
    assert!(survey(&two).judged().is_empty());
    let cut = format!("{text}{NX}GOTO/9,0,0\n");
    assert_eq!(survey(&cut).judged().first().map(|d| d.code), Some("nc-no-end"));
}
