//! The motions of RS274 programs compared with those of `LinuxCNC`'s own interpreter, where its program
//! `rs274` is installed (Debian: `linuxcnc-uspace`).
//!
//! `PROVEOUT_RS274_FOLDER` names a folder of further programs. Compared are the ends of all motions in work
//! coordinates, whether they are rapid, and the centers of arcs. Left out are programs that one of the two
//! refuses, and what the canonical calls do not say or the reader does not do by itself: cutter compensation,
//! NURBS, threads outside of the XY plane, G33.1.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

use proveout_nc::{Dialect, Motion, Op, Program, Settings};

/// Half a unit of the last digit that `rs274` prints, with room for rounding, in units of the program.
const PRINTED: f64 = 0.000_08;
const INCH_MM: f64 = 25.4;

/// A motion: mm and degrees.
#[derive(Clone, Debug)]
struct Move {
    end: [Option<f64>; 6],
    /// None where the kind is not compared.
    rapid: Option<bool>,
    /// Center in the plane, with its axes.
    center: Option<[(usize, f64); 2]>,
    tolerance: f64,
}

/// Why a program is not compared.
type Skipped = &'static str;

fn calls(path: &Path, tools: &Path) -> Result<Vec<Move>, Skipped> {
    let folder = path.parent().unwrap();
    let output = Process::new("timeout")
        .args(["20", "rs274", "-t"])
        .arg(tools)
        .arg("-g")
        .arg(path.file_name().unwrap())
        .current_dir(folder)
        .output()
        .unwrap();
    if !output.status.success() {
        return Err("refused by rs274");
    }
    let (mut moves, mut unit, mut plane, mut here) = (Vec::new(), 1.0, [0, 1, 2], [0.0; 6]);
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        // `   12 N..... STRAIGHT_FEED(1.0000, ...)`, without the blank after a long line number.
        let call = line.split_once('N').map(|(_, rest)| rest.trim_start_matches(|c: char| !c.is_ascii_alphabetic()));
        let Some((name, rest)) = call.and_then(|call| call.split_once('(')) else {
            continue;
        };
        let text = rest.trim_end().trim_end_matches(')');
        let numbers: Vec<f64> = text.split(',').map_while(|n| n.trim().parse().ok()).collect();
        match name {
            "USE_LENGTH_UNITS" => unit = if text.contains("INCH") { INCH_MM } else { 1.0 },
            "SELECT_PLANE" => {
                plane = match text {
                    "CANON_PLANE_XZ" => [2, 0, 1],
                    "CANON_PLANE_YZ" => [1, 2, 0],
                    _ => [0, 1, 2],
                }
            }
            "NURBS_FEED" => return Err("a NURBS"),
            "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" | "STRAIGHT_PROBE" | "RIGID_TAP" => {
                for (axis, value) in numbers.iter().enumerate().take(6) {
                    here[axis] = value * if axis < 3 { unit } else { 1.0 };
                }
                let rapid = match name {
                    "STRAIGHT_TRAVERSE" => Some(true),
                    "STRAIGHT_FEED" => Some(false),
                    _ => None,
                };
                moves.push(Move { end: here.map(Some), rapid, center: None, tolerance: PRINTED * unit });
            }
            "ARC_FEED" => {
                let [u, v, w] = plane;
                (here[u], here[v], here[w]) = (numbers[0] * unit, numbers[1] * unit, numbers[5] * unit);
                here[3..6].copy_from_slice(&numbers[6..9]);
                let center = Some([(u, numbers[2] * unit), (v, numbers[3] * unit)]);
                moves.push(Move { end: here.map(Some), rapid: Some(false), center, tolerance: PRINTED * unit });
            }
            _ => {}
        }
    }
    Ok(moves)
}

fn commands(path: &Path) -> Result<Vec<Move>, Skipped> {
    let settings = Settings { dialect: Dialect::LinuxCnc, ..Settings::default() };
    let (mut moves, mut last, mut xy) = (Vec::<Move>::new(), [Some(0.0); 6], true);
    for command in Program::open(path, &settings).or(Err("refused by the reader"))? {
        let op = command.or(Err("refused by the reader"))?.op;
        let mut put = |motion: &Motion, rapid, center| {
            for (axis, slot) in last.iter_mut().enumerate() {
                let value = motion.end.get(axis).map(|v| if axis < 3 { v } else { v.to_degrees() });
                *slot = if motion.machine_coordinates { None } else { value.or(*slot) };
            }
            moves.push(Move { end: last, rapid, center, tolerance: 0.0 });
        };
        match &op {
            Op::Rapid(motion) => put(motion, Some(true), None),
            Op::Linear(motion) => put(motion, Some(false), None),
            Op::Probe(probe) => put(&probe.motion, None, None),
            Op::Thread(_) if !xy => return Err("a thread outside of the XY plane"),
            Op::Thread(thread) if thread.direction.is_none() => return Err("a thread"),
            Op::Thread(thread) => put(&thread.motion, Some(false), None),
            Op::Arc(arc) => {
                let normal = (0..3).find(|&axis| arc.normal[axis].abs() == 1.0).unwrap_or(2);
                let (u, v) = ((normal + 1) % 3, (normal + 2) % 3);
                put(&arc.motion, Some(false), Some([(u, arc.center[u]), (v, arc.center[v])]));
            }
            Op::Spline(spline) => put(&spline.motion, None, None),
            Op::CutterComp(comp) if comp.side != proveout_nc::CompSide::Off => return Err("cutter compensation"),
            // Coordinates that are not programmed again are those of the offset before.
            Op::Frame(_) => last = [None; 6],
            Op::Plane(normal) => xy = *normal == 'Z',
            _ => {}
        }
    }
    Ok(moves)
}

fn near(a: &Move, b: &Move) -> bool {
    let limit = b.tolerance;
    let ends = a.end.iter().zip(b.end).enumerate().all(|(axis, (a, b))| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= if axis < 3 { limit } else { PRINTED },
        _ => true,
    });
    let kinds = a.rapid.zip(b.rapid).is_none_or(|(a, b)| a == b);
    let centers = match (a.center, b.center) {
        (Some(a), Some(b)) => a.iter().all(|(axis, value)| {
            // The reader moves a center onto the bisector of rounded ends, by at most its tolerance.
            b.iter().any(|(other, theirs)| other == axis && (value - theirs).abs() <= 0.01 + limit)
        }),
        (None, None) => true,
        _ => false,
    };
    ends && kinds && centers
}

/// No motion: it ends where the one before has ended.
fn stands(moves: &[Move], at: usize, tolerance: f64) -> bool {
    let before = at.checked_sub(1).map_or([Some(0.0); 6], |before| moves[before].end);
    moves[at].center.is_none()
        && moves[at].end.iter().zip(before).all(|(a, b)| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() <= tolerance,
            _ => false,
        })
}

/// The number of motions that agree, or the first that does not.
fn compared(ours: &[Move], theirs: &[Move]) -> Result<usize, String> {
    let (mut i, mut k, mut same) = (0, 0, 0);
    while i < ours.len() || k < theirs.len() {
        if i < ours.len() && k < theirs.len() && near(&ours[i], &theirs[k]) {
            (i, k, same) = (i + 1, k + 1, same + 1);
        } else if k < theirs.len() && i > 0 && ours[i - 1].end == [None; 6] {
            // Machine coordinates are compared by their number alone, and G28 is two motions there.
            k += 1;
        } else if k < theirs.len() && stands(theirs, k, 2.0 * theirs[k].tolerance) {
            k += 1;
        } else if i < ours.len() && stands(ours, i, 1e-7) {
            i += 1;
        } else {
            return Err(format!("motion {}: {:?}\nrs274: {:?}", same + 1, ours.get(i), theirs.get(k)));
        }
    }
    Ok(same)
}

fn programs() -> Vec<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/linuxcnc");
    let mut files = Vec::new();
    for folder in [Some(own), std::env::var_os("PROVEOUT_RS274_FOLDER").map(PathBuf::from)].into_iter().flatten() {
        let entries = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        files.extend(entries.map(|entry| entry.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == "ngc")));
    }
    files.sort();
    files
}

#[test]
fn motions_are_those_of_linuxcnc() {
    if Process::new("rs274").arg("-h").output().is_err() {
        // Past the capture of the test harness: `cargo xtask ci` has these lines in its summary.
        let _ = std::io::Write::write_all(
            &mut std::io::stdout(),
            b"\nLEFT OUT: motions beside those of LinuxCNC: rs274 (Debian: linuxcnc-uspace) is not installed\n",
        );
        return;
    }
    let tools = std::env::temp_dir().join(format!("proveout-rs274-{}.tbl", std::process::id()));
    fs::write(&tools, (1..100).map(|n| format!("T{n} P{n} D0 Z0\n")).collect::<String>()).unwrap();
    let (mut programs_same, mut motions, mut skipped, mut different) = (0, 0, 0, Vec::new());
    for path in programs() {
        match commands(&path).and_then(|ours| Ok((ours, calls(&path, &tools)?))) {
            Err(_) => skipped += 1,
            Ok((ours, theirs)) => match compared(&ours, &theirs) {
                Ok(same) => (programs_same, motions) = (programs_same + 1, motions + same),
                Err(what) => different.push(format!("{}\n{what}", path.display())),
            },
        }
    }
    fs::remove_file(&tools).unwrap();
    let summary = format!("{programs_same} programs with {motions} motions agree, {skipped} are not compared");
    let _ = std::io::Write::write_all(&mut std::io::stdout(), format!("\n{summary}\n").as_bytes());
    assert!(different.is_empty(), "{summary}, {} differ:\n{}", different.len(), different.join("\n\n"));
    assert!(programs_same > 0, "{summary}");
}
