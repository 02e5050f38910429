//! Real production programs, where they lie next to the checkout.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::path::{Path, PathBuf};

use proveout_nc::{Command, Motion, Op, Program, Settings, ToolAction, ToolName, check};

/// A folder of real inputs: next to the checkout, or one level higher where the checkout is one of several.
fn cases() -> Option<PathBuf> {
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).parent()?.parent()?;
    checkout.ancestors().skip(1).take(2).map(|dir| dir.join("shared/cases")).find(|dir| dir.is_dir())
}

fn program(name: &str) -> Option<PathBuf> {
    let path = cases().map(|cases| cases.join("spinner-u5-840d/NC_code").join(name)).filter(|path| path.is_file());
    if path.is_none() {
        // Past the capture of the test harness: `cargo xtask ci` has these lines in its summary.
        let line = b"\nLEFT OUT: reading of production programs: the data set doi:10.1038/s41597-025-05294-0 is not beside the checkout\n";
        let _ = std::io::Write::write_all(&mut std::io::stdout(), line);
    }
    path
}

const CROSS: &str = "Coordinate_system_representation_Achskreuz/Coordinate_system_representation_Achskreuz.mpf";
const KEYCHAIN: &str = "Keychain_Schluesselanhaenger/Keychain_Schluesselanhaenger.mpf";

fn read(path: &Path) -> Vec<Command> {
    Program::open(path, &Settings::default()).unwrap().map(|c| c.unwrap_or_else(|e| panic!("{e}"))).collect()
}

fn motion(op: &Op) -> Option<&Motion> {
    match op {
        Op::Rapid(m) | Op::Linear(m) => Some(m),
        Op::Arc(arc) => Some(&arc.motion),
        _ => None,
    }
}

fn count(commands: &[Command], test: impl Fn(&Op) -> bool) -> usize {
    commands.iter().filter(|c| test(&c.op)).count()
}

#[test]
fn axis_cross_is_read_to_its_end() {
    let Some(path) = program(CROSS) else { return };
    assert!(check(&path, &Settings::default()).is_empty());
    let commands = read(&path);
    // Counted in the text.
    assert_eq!(count(&commands, |op| matches!(op, Op::Message(_))), 25);
    assert_eq!(count(&commands, |op| matches!(op, Op::Tcp(tcp) if tcp.on)), 21);
    assert_eq!(count(&commands, |op| matches!(op, Op::Frame(f) if f.word == "AROT")), 41);
    assert_eq!(count(&commands, |op| matches!(op, Op::Frame(f) if f.word == "TRANS")), 21);
    let changes: Vec<_> = commands
        .iter()
        .filter_map(|c| match &c.op {
            Op::Tool(ToolAction::Change(ToolName::Name(name))) => Some(name.as_str()),
            Op::Tool(ToolAction::Change(_)) => Some(""),
            _ => None,
        })
        .collect();
    assert_eq!(changes, ["PLAN_D50_N_AP4", "SCHAFT_D12_N_AP30", "SCHAFT_D6_N_AP15", "ENTFRAESER_D8_N_90GRAD", ""]);
    assert!(matches!(commands.last().map(|c| &c.op), Some(Op::End)));
}

#[test]
fn tilted_blocks_have_the_base_coordinates_of_hand_calculation() {
    let Some(path) = program(CROSS) else { return };
    let commands = read(&path);
    let half = 0.5f64.sqrt();
    // Line, frame in the program, base coordinates by hand from the words of the line.
    for (line, want) in [
        // AROT Y90 takes (x y z) to (z y -x): X31 Y-15.001 Z165.236.
        (1034, [165.236, -15.001, -31.0]),
        // The next block: Z2.
        (1035, [2.0, -15.001, -31.0]),
        // AROT X-90, AROT Z90: first (-y x z), then (x z -y): X12 Y46.001 Z226.358.
        (1603, [-46.001, 226.358, -12.0]),
        // AROT X90, AROT Z-90: (y -x z), then (x -z y): X47.764 Y-58 Z193.642.
        (2100, [-58.0, -193.642, -47.764]),
        // AROT X90, AROT Y-45, AROT Z-90: (y -x z) = (-40.937 -20.882 298.656), then ((x-z)/sqrt2, y,
        // (x+z)/sqrt2), then (x -z y): X20.882 Y-40.937 Z298.656.
        (2143, [(-40.937 - 298.656) * half, -(-40.937 + 298.656) * half, -20.882]),
    ] {
        let got = commands.iter().find_map(|c| motion(&c.op).filter(|_| c.location.line == line)).unwrap();
        for (got, want) in got.end_base.xyz().unwrap().into_iter().zip(want) {
            // The coordinates carry three decimals; the calculation is exact to rounding.
            assert!((got - want).abs() < 1e-12, "line {line}: {got} {want}");
        }
    }
}

#[test]
fn tilted_feed_motions_lie_on_the_part() {
    let Some(path) = program(CROSS) else { return };
    let mut tilted = false;
    let mut seen = 0;
    for command in read(&path) {
        match &command.op {
            Op::Frame(frame) => tilted = frame.rotation != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Op::Linear(m) if tilted => {
                seen += 1;
                let [x, y, z] = m.end_base.xyz().unwrap();
                // The cube of the part is X -50..0, Y 0..50, Z -65..0; approaches and run-outs reach 15.001
                // mm beyond.
                let inside = (-65.1..=15.1).contains(&x) && (-15.1..=65.1).contains(&y) && (-66.1..=15.1).contains(&z);
                assert!(inside, "line {}: {x} {y} {z}", command.location.line);
            }
            _ => {}
        }
    }
    assert!(seen > 300, "{seen} motions in tilted frames");
}

#[test]
fn arcs_start_and_end_on_their_circles() {
    for name in [CROSS, KEYCHAIN] {
        let Some(path) = program(name) else { return };
        let mut from = None;
        for command in read(&path) {
            if let Op::Arc(arc) = &command.op {
                let distance =
                    |p: [f64; 3]| p.iter().zip(arc.center_base).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
                let start: [f64; 3] = from.unwrap();
                let end = arc.motion.end_base.xyz().unwrap();
                // No helices in these programs. The words carry 0.001 mm, so radii of arcs over half a turn,
                // whose center is kept, differ by about that; the others are exact.
                assert!((distance(start) - arc.radius).abs() < 1e-9, "line {}", command.location.line);
                assert!((distance(end) - arc.radius).abs() < 2e-3, "line {}", command.location.line);
                assert!(arc.sweep > 0.0 && arc.sweep <= std::f64::consts::TAU);
            }
            if let Some(m) = motion(&command.op) {
                from = m.end_base.xyz().filter(|_| !m.machine_coordinates);
            }
        }
    }
}

#[test]
fn keychain_is_read_to_its_end_and_drills() {
    let Some(path) = program(KEYCHAIN) else { return };
    assert!(check(&path, &Settings::default()).is_empty());
    let commands = read(&path);
    assert!(matches!(commands.last().map(|c| &c.op), Some(Op::End)));
    let names: Vec<_> = commands
        .iter()
        .filter_map(|c| match &c.op {
            Op::Tool(ToolAction::Change(ToolName::Name(name))) => Some(name.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(names, ["ENTFRAESER_D8_N_90GRAD", "BOHRER_D3.3_VHM"]);
}
