//! `docs/nc-json.md` names every op and key that is printed, and no other.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use proveout_nc::*;

fn motion() -> Motion {
    let mut end = AxisValues::NONE;
    end.put(0, 1.0);
    Motion {
        end,
        end_base: end,
        tool_axis: Some([0.0, 0.0, 1.0]),
        tool_axis_base: Some([0.0, 0.0, 1.0]),
        programmed: 1,
        machine_coordinates: true,
        exact_stop: true,
        solution: RotarySolution::Angle { higher: true, reference: Some('A'), or_other: true },
    }
}

fn arc() -> ArcMotion {
    let (center, normal) = ([0.0; 3], [0.0, 0.0, 1.0]);
    ArcMotion { motion: motion(), center, center_base: center, normal, normal_base: normal, radius: 1.0, sweep: 1.0 }
}

/// Every op with every optional part.
fn every_op() -> Vec<Op> {
    let points = [[0.0; 3]; 2];
    let feeds = [Feed::PerTime(1.0), Feed::PerRevolution(1.0), Feed::InverseTime(1.0)];
    let mut ops = vec![];
    for feed in feeds {
        ops.extend([Op::Feed(feed), Op::Rapid(motion()), Op::Linear(motion()), Op::Arc(arc())]);
        ops.push(Op::Spline(SplineMotion { motion: motion(), control: points, control_base: points }));
        ops.push(Op::Probe(ProbeMotion { motion: motion(), away: true, must_switch: true, contact: Contact::Touched }));
    }
    ops.extend([
        Op::Thread(ThreadMotion { motion: motion(), pitch: 1.0, direction: Some(SpindleDirection::Clockwise) }),
        Op::Dwell(Dwell::Seconds(1.0)),
        Op::Dwell(Dwell::Revolutions(1.0)),
        Op::Spindle(Spindle { direction: SpindleDirection::Off, speed_rpm: None }),
        Op::Tool(ToolAction::Select(ToolName::Number(1))),
        Op::Tool(ToolAction::Change(ToolName::Name("A".to_owned()))),
        Op::Plane('Z'),
        Op::FeedCounts(FeedCounts::LINEAR),
        Op::Offset(Offset::ToolEdge { edge: 1 }),
        Op::Offset(Offset::ToolDelta { length: 1.0, radius: 1.0, corner_radius: 1.0 }),
        Op::Offset(Offset::TurnCenter { ahead: 1.0 }),
        Op::Retract(Retract { distance: None, rapid: true }),
        Op::Offset(Offset::Work { word: "G54".to_owned() }),
        Op::Frame(FrameChange {
            word: "ROT".to_owned(),
            rotation: [[0.0; 3]; 3],
            translation: [0.0; 3],
            rotary: [0.0; 3],
        }),
        Op::Tcp(Tcp { on: true, interpolation: OrientationInterpolation::Axes }),
        Op::PathMode(PathMode::ExactStop),
        Op::PathMode(PathMode::Continuous { tolerance: None, orientation_tolerance: None }),
        Op::CutterComp(CutterComp { side: CompSide::Left, offset: None, radius: None }),
        Op::Override(Override { enabled: true, feed: 1.0 }),
        Op::Coolant(Coolant { flood: true, mist: false }),
        Op::Message("A".to_owned()),
        Op::Note("A".to_owned().into()),
        Op::Overcut(Overcut {
            kind: OvercutKind::Narrow,
            depth: 1.0,
            radius: 1.0,
            contour_file: "f".into(),
            contour_line: 1,
            point: AxisValues::NONE,
            programmed_point: AxisValues::NONE,
            blocks: 1,
        }),
        Op::Stop { optional: true },
        Op::End,
    ]);
    // A new op has no row here and no section in the page: this stops compiling.
    for op in &ops {
        match op {
            Op::Rapid(_) | Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Probe(_) | Op::Thread(_) | Op::Dwell(_) => {
            }
            Op::Feed(_) | Op::Spindle(_) | Op::Tool(_) | Op::Plane(_) | Op::Offset(_) | Op::Frame(_) | Op::Tcp(_) => {}
            Op::PathMode(_) | Op::CutterComp(_) | Op::Override(_) | Op::Coolant(_) | Op::Message(_) | Op::Note(_) => {}
            Op::Stop { .. } | Op::Retract(_) | Op::Overcut(_) | Op::FeedCounts(_) | Op::End => {}
        }
    }
    ops
}

fn printed() -> BTreeMap<String, BTreeSet<String>> {
    let mut writer = JsonWriter::new();
    let mut keys: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for op in every_op() {
        let location = Location { file: "f".into(), line: 1, column: 1, length: 1, depth: 0 };
        for value in writer.values(&Command { location, op }) {
            let object = value.as_object().unwrap();
            let op = object["op"].as_str().unwrap().to_owned();
            keys.entry(op).or_default().extend(object.keys().cloned());
        }
    }
    keys
}

/// Keys of each section of the page.
fn sections() -> BTreeMap<String, BTreeSet<String>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/nc-json.md");
    let text = std::fs::read_to_string(path).unwrap();
    let mut list: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut current = String::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("## ").or(line.strip_prefix("### ")) {
            current = title.trim_matches('`').to_owned();
            list.entry(current.clone()).or_default();
        } else if let Some(key) = line.strip_prefix("| `") {
            list.get_mut(&current).unwrap().insert(key.split('`').next().unwrap().to_owned());
        }
    }
    list
}

#[test]
fn the_page_names_every_op_and_key() {
    let (printed, mut sections) = (printed(), sections());
    let common = sections.remove("Every line").unwrap();
    let motions = sections.remove("Motions").unwrap();
    for group in ["Feed, spindle, tool", "Offsets, frames, modes", "Texts, stops"] {
        assert!(sections.remove(group).unwrap().is_empty());
    }
    assert_eq!(printed.keys().collect::<Vec<_>>(), sections.keys().collect::<Vec<_>>());
    for (op, keys) in &printed {
        let mut page: BTreeSet<String> = sections[op].union(&common).cloned().collect();
        if matches!(op.as_str(), "rapid" | "linear" | "arc" | "spline" | "probe" | "thread") {
            let feedless = matches!(op.as_str(), "rapid" | "thread");
            let is_feed = |k: &String| k.starts_with("feed_") || k.starts_with("inverse_");
            page.extend(motions.iter().filter(|k| !(feedless && is_feed(k))).cloned());
        }
        assert_eq!(keys, &page, "{op}");
    }
}
