//! Random blocks of all modal groups compared with what the interpreter of `LinuxCNC` makes of them.
//!
//! `rs274/blocks.txt.gz` holds programs and the canonical calls of `rs274` (`rs274/record.py` says how, and
//! makes them again). The test needs no `LinuxCNC`. It runs all of them in seconds; `PROVEOUT_RS274_BLOCKS`
//! is the number of programs of a hundred that run, and `PROVEOUT_RS274_FILE` names another recording.
//!
//! * A block that `rs274` refuses must be refused.
//! * A block that it takes gives the same motions, in machine coordinates, with the same feed, spindle,
//!   coolant, dwells, stops and tool changes, or is refused: how often, each reason has its limit.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests fail by panic; the summary is for people"
)]

#[path = "rs274/recording.rs"]
mod recording;
#[path = "rs274/states.rs"]
mod states;

use std::collections::BTreeMap;

use recording::{Recorded, Recording};
use states::{Event, Kind, ours, theirs};

/// Units of the last digit that `rs274` prints, mm, for values in inch.
const PRINTED_MM: f64 = 0.004;

/// Refusals of blocks that `rs274` takes: the beginning of the message, and how many of 10,000 blocks may
/// have it.
const REFUSED_BY_NAME: &[(&str, f64)] = &[
    // The reader has no table of tools, and takes lengths from the program or by the number of the tool.
    ("`G10 L1` of other axes", 40.0),
    ("`G10 L", 90.0),
    ("the length of tool", 30.0),
    ("no tool is in the spindle", 40.0),
    // After a tool change, a probing motion and a machine motion places are not known to the program. Cycles
    // need the level of the tool.
    ("the position of", 80.0),
    ("the machine position is not known", 20.0),
    ("the start of the", 40.0),
    ("comes back to the initial level", 30.0),
    ("needs the level of the tool", 20.0),
    ("the polar coordinates before", 3.0),
    // Words of turning and those that a twin cannot do.
    ("is not supported", 60.0),
    ("takes X, Y and Z", 10.0),
    ("I, J and Q of G10", 8.0),
    ("has no meaning in this block", 20.0),
    // Combinations whose result at the control is a trap.
    ("under the shift of G92, and the control loses the place", 3.0),
    ("the control makes the motion that was in force before it", 3.0),
    ("must be above zero", 2.0),
    ("with a cycle: both take P", 4.0),
    ("the unit changes under", 20.0),
    ("exclude each other", 20.0),
    ("the rotary axis", 12.0),
    ("both take the axis letters", 30.0),
    ("needs a feed in G94", 12.0),
    ("has no `", 12.0),
    ("has no infeed Q", 6.0),
    ("names no axis", 8.0),
    ("in one block: both take P, Q and R", 5.0),
    ("the spline needs", 6.0),
    ("mm to go", 4.0),
    ("outside of the plane G17", 3.0),
    ("does not lie below the R plane", 6.0),
];

#[derive(Default)]
struct Found {
    blocks: usize,
    events: usize,
    refused_alike: usize,
    refused_by_name: BTreeMap<String, Vec<String>>,
    wrong: Vec<(String, String)>,
}

fn text_of(program: &[&Recorded]) -> String {
    program.iter().map(|block| format!("    {}\n", block.text)).collect()
}

/// What `rs274` refuses for its set-up, and not for the block: tools that its table lacks, axes that its
/// machine lacks, the programs of M100 to M199; G43.2 with axis letters, which later versions take.
const SET_UP: [&str; 3] = ["Requested tool", "Bad character", "Unknown m code used: M100"];

/// Under cutter compensation `rs274` keeps its calls back, so that nothing separates them by block.
fn is_compensated(block: &Recorded) -> bool {
    let text = block.text.to_ascii_uppercase().replace(' ', "");
    text.contains("G41") || text.contains("G42")
}

/// The number of blocks before the first in which `rs274` does other than a `LinuxCNC` that drives a machine.
/// The interpreter is the same; what it asks the canonical machine differs between `saicanon.cc` of `rs274`
/// and `emccanon.cc` and `ioControl.cc` of the machine (sources of 2.9, seen with programs of a few blocks):
///
/// * M61: `CHANGE_TOOL_NUMBER` of `rs274` leaves entry 0 of the tool table, the tool in the spindle, as it
///   was, and G43 without H in a later block takes the length of the tool before. The machine loads the tool
///   into entry 0 (`EMC_TOOL_SET_NUMBER`).
/// * G20 and G21: `USE_LENGTH_UNITS` of `rs274` leaves the number of the tool length as it was, 4 mm are 4
///   inch from there on. The machine gives it to the interpreter in the new unit
///   (`GET_EXTERNAL_TOOL_LENGTH_XOFFSET`).
/// * After a tool change the interpreter reads its position again. `rs274` gives the end of the last motion,
///   in the coordinates of the tool length that was in force there.
fn as_a_machine(program: &[Recorded]) -> usize {
    let (mut numbered, mut length, mut inch) = (false, false, false);
    // Another tool length is in force than at the end of the last motion.
    let mut stale = false;
    for (at, block) in program.iter().enumerate().filter(|(_, block)| block.refusal.is_none()) {
        let text = block.text.to_ascii_uppercase().replace(' ', "");
        let of_spindle = text.split("G43").skip(1).any(|rest| !rest.starts_with('.')) && !text.contains('H');
        if numbered && of_spindle {
            return at;
        }
        for call in &block.calls {
            match call.split_at(1) {
                ("x", _) => numbered = true,
                ("X", _) => numbered = false,
                ("H", lengths) => {
                    stale |= length || lengths.split(',').any(|value| value != "0");
                    length = lengths.split(',').any(|value| value != "0");
                }
                ("T" | "L" | "A" | "B" | "R" | "N", _) => stale = false,
                ("U", unit) if length && unit.contains("INCH") != inch => return at,
                ("U", unit) => inch = unit.contains("INCH"),
                _ => {}
            }
        }
        if stale && block.calls.iter().any(|call| call.starts_with(['x', 'X'])) {
            return at + 1;
        }
    }
    program.len()
}

fn compare(program: &[Recorded], found: &mut Found) {
    if program.iter().any(is_compensated) {
        return;
    }
    let program = &program[..as_a_machine(program)];
    let kept: Vec<&Recorded> = program.iter().filter(|block| block.refusal.is_none()).collect();
    let lines: Vec<&str> = kept.iter().map(|block| block.text.as_str()).collect();
    let (mine, fault) = ours(&lines);
    let reached = fault.as_ref().map_or(kept.len(), |(at, _)| *at);
    found.blocks += reached;
    if let Some((at, message)) = &fault {
        let reason: String = message.clone();
        let text = text_of(&kept[..=*at]);
        found.refused_by_name.entry(reason).or_default().push(text);
    }
    let other = theirs(&kept[..reached]);
    for at in 0..reached {
        let (a, b) = (&mine[at], &other[at]);
        found.events += b.len();
        if b.iter().any(|event| event.kind == Kind::Spline) {
            // The calls do not say where a NURBS ends.
            break;
        }
        if let Some(what) = difference(a, b) {
            let text = format!(
                "{what}\n{}    ours {}\n   rs274 {}\n   calls {}",
                text_of(&kept[..=at]),
                shown(a),
                shown(b),
                kept[at].calls.join(";")
            );
            found.wrong.push((what, text));
            break;
        }
    }
    // Each refused block after those before it.
    for (at, block) in program.iter().enumerate() {
        let Some(message) = block.refusal.as_ref().filter(|m| !SET_UP.iter().any(|start| m.starts_with(start))) else {
            continue;
        };
        let before: Vec<&Recorded> = program[..at].iter().filter(|b| b.refusal.is_none()).chain([block]).collect();
        if before.len() - 1 > reached {
            continue;
        }
        found.blocks += 1;
        let lines: Vec<&str> = before.iter().map(|block| block.text.as_str()).collect();
        match ours(&lines).1 {
            Some(_) => found.refused_alike += 1,
            None => {
                let what = format!("taken, and rs274 says: {}", message.split(':').next().unwrap_or(message));
                let text = format!("{what}\n{}", text_of(&before));
                found.wrong.push((what, text));
            }
        }
    }
}

fn shown(events: &[Event]) -> String {
    events.iter().map(|e| format!("{e:?}")).collect::<Vec<_>>().join("\n         ")
}

fn difference(a: &[Event], b: &[Event]) -> Option<String> {
    if a.len() != b.len() {
        return Some(format!("{} events instead of {}", a.len().min(9), b.len().min(9)));
    }
    // A tapping cycle is a thread here, and a feed with a spindle that turns back there.
    let taps = a.iter().any(|e| e.kind == Kind::Thread) && b.iter().any(|e| e.kind == Kind::Feed);
    for (a, b) in a.iter().zip(b) {
        let kinds = match (&a.kind, &b.kind) {
            (Kind::Dwell(x), Kind::Dwell(y)) => (x - y).abs() < 1e-4,
            (Kind::Arc { center: x, turns: n }, Kind::Arc { center: y, turns: m }) => {
                // The reader moves a center onto the bisector of rounded ends, by at most its tolerance.
                let near = x.iter().zip(y).all(|(x, y)| match (x, y) {
                    (Some(x), Some(y)) => (x - y).abs() <= 0.02,
                    _ => true,
                });
                near && n == m
            }
            (Kind::Thread, Kind::Feed) => true,
            (x, y) => x == y,
        };
        if !kinds {
            return Some(format!("another kind: {} instead of {}", a.kind.name(), b.kind.name()));
        }
        for axis in 0..6 {
            if let (Some(x), Some(y)) = (a.end[axis], b.end[axis])
                && (x - y).abs() > PRINTED_MM
                // `rs274` prints taps outside of G17 with the axes of the plane.
                && !taps
            {
                return Some(format!("another end of {}", ["X", "Y", "Z", "A", "B", "C"][axis]));
            }
        }
        if let (Some(x), Some(y)) = (a.feed, b.feed)
            && (x - y).abs() > 1e-3 * y.abs().max(1.0)
        {
            return Some("another feed".to_owned());
        }
        if taps || a.kind == Kind::End {
            continue;
        }
        if a.spindle != b.spindle && b.spindle.1 >= 0 {
            return Some("another spindle".to_owned());
        }
        if a.coolant != b.coolant {
            return Some("another coolant".to_owned());
        }
    }
    None
}

#[test]
fn blocks_are_read_as_linuxcnc_reads_them() {
    let recording = Recording::open();
    let part = std::env::var("PROVEOUT_RS274_BLOCKS").unwrap_or_default();
    let percent = part.parse().unwrap_or(100_usize);
    let mut found = Found::default();
    for (at, program) in recording.programs.iter().enumerate() {
        if (at * 37 + 11) % 100 < percent {
            compare(program, &mut found);
        }
    }
    let mut summary = format!(
        "{} blocks: {} motions and events agree, {} refusals agree\n",
        found.blocks, found.events, found.refused_alike
    );
    let show: usize = std::env::var("PROVEOUT_RS274_SHOW").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    let mut by_kind: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (what, text) in &found.wrong {
        by_kind.entry(what).or_default().push(text);
    }
    let mut too_many = Vec::new();
    let mut by_reason: BTreeMap<&str, Vec<&String>> = BTreeMap::new();
    for (message, texts) in &found.refused_by_name {
        let reason =
            REFUSED_BY_NAME.iter().find(|(start, _)| message.contains(start)).map_or(message.as_str(), |r| r.0);
        by_reason.entry(reason).or_default().extend(texts);
    }
    for (reason, texts) in &by_reason {
        let allowed = REFUSED_BY_NAME.iter().find(|(start, _)| reason.contains(start)).map_or(0.0, |(_, n)| *n);
        summary.push_str(&format!("refused by name, {} times: {reason}\n", texts.len()));
        let limit = (allowed * found.blocks as f64 / 10_000.0).ceil();
        // Few blocks are no measure.
        let limit = if percent < 100 && limit > 0.0 { limit + 3.0 } else { limit };
        if texts.len() as f64 > limit {
            too_many.push(format!("{} times, allowed {limit}: {reason}\n{}", texts.len(), texts[0]));
        }
    }
    println!("{summary}");
    let mut report = String::new();
    for (what, texts) in &by_kind {
        report.push_str(&format!("== {} times: {what}\n", texts.len()));
        for text in texts.iter().take(show) {
            report.push_str(text);
            report.push('\n');
        }
    }
    assert!(found.wrong.is_empty(), "{summary}{} differ:\n{report}", found.wrong.len());
    assert!(too_many.is_empty(), "{summary}refused too often:\n{}", too_many.join("\n"));
    assert!(found.blocks > 0, "{summary}");
}
