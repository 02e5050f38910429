//! The rules of the dialects, on commands made here: corners, entries, where the radius comes from.

use std::collections::VecDeque;
use std::f64::consts::PI;
use std::sync::Arc;

use super::*;
use crate::{Location, Op, RotarySolution};

#[derive(Debug)]
struct Script(VecDeque<Command>);

impl Reader for Script {
    fn next_command(&mut self) -> Option<Result<Command, Box<Diagnostic>>> {
        self.0.pop_front().map(Ok)
    }
}

fn to(x: f64, y: f64) -> Motion {
    let mut end = AxisValues::NONE;
    for (axis, value) in [x, y, 0.0].into_iter().enumerate() {
        end.put(axis, value);
    }
    Motion {
        end,
        end_base: end,
        tool_axis: None,
        tool_axis_base: None,
        programmed: 0b11,
        machine_coordinates: false,
        exact_stop: false,
        solution: RotarySolution::Nearest,
    }
}

fn line(x: f64, y: f64) -> Op {
    Op::Linear(to(x, y))
}

fn comp(side: CompSide, offset: Option<u32>, radius: Option<f64>) -> Op {
    Op::CutterComp(CutterComp { side, offset, radius })
}

fn run(dialect: Dialect, ops: Vec<Op>) -> Result<Vec<Op>, Fault> {
    let location = Location { file: Arc::from("x"), line: 1, column: 1, length: 1, depth: 0 };
    let script = ops.into_iter().map(|op| Command { location: location.clone(), op }).collect();
    let mut radii = ToolRadii::default();
    radii.by_offset.insert(3, 2.0);
    radii.by_tool.insert(ToolName::Number(1), 5.0);
    let settings = Settings { compensation: Compensation::ToolCenter(radii), ..Settings::default() };
    let mut stage = CompensatedReader::new(Box::new(Script(script)), dialect, false, &settings);
    std::iter::from_fn(|| stage.next()).map(|item| item.map(|command| command.op)).collect()
}

/// Ends of motions in the plane; the center of an arc follows its end.
fn ends(ops: &[Op]) -> Vec<[f64; 2]> {
    let mut list = Vec::new();
    for op in ops {
        if let Some(motion) = motion_of(op) {
            list.push([motion.end_base.get(0).unwrap_or(f64::NAN), motion.end_base.get(1).unwrap_or(f64::NAN)]);
        }
        if let Op::Arc(arc) = op {
            list.push([arc.center_base[0], arc.center_base[1]]);
        }
    }
    // Rounding of a few operations on numbers of this size.
    list.iter().map(|p| p.map(|v| (v * 1e9).round() / 1e9 + 0.0)).collect()
}

/// Right of a wedge: along X, then back at 45 degrees above; the change of direction is 135 degrees.
fn wedge() -> Vec<Op> {
    vec![
        Op::Rapid(to(0.0, -20.0)),
        comp(CompSide::Right, Some(3), None),
        line(0.0, 0.0),
        line(30.0, 0.0),
        line(0.0, 30.0),
        comp(CompSide::Off, None, None),
        line(0.0, 60.0),
    ]
}

#[test]
fn fanuc_goes_around_sharp_corners_with_three_lines() {
    let ops = run(Dialect::Fanuc, wedge()).unwrap();
    let h = 2.0 * 0.5f64.sqrt();
    let beside = |x: f64, y: f64| [x + h, y + h];
    let round = |p: [f64; 2]| p.map(|v| (v * 1e9).round() / 1e9);
    assert_eq!(
        ends(&ops),
        [
            [0.0, -20.0],
            [0.0, -2.0],
            // One radius beyond the corner along the first line, and one before it along the second.
            [32.0, -2.0],
            round([30.0 + h + h, 0.0 + h - h]),
            round(beside(0.0, 30.0)),
            [0.0, 60.0],
        ]
    );
    // No arc: everything is straight.
    assert!(!ops.iter().any(|op| matches!(op, Op::Arc(_))));
}

#[test]
fn others_go_around_on_a_circle() {
    for dialect in [Dialect::Heidenhain, Dialect::Apt, Dialect::Siemens840d] {
        let ops = run(dialect, wedge()).unwrap();
        let arcs: Vec<_> = ops.iter().filter_map(|op| if let Op::Arc(a) = op { Some(a) } else { None }).collect();
        assert_eq!(arcs.len(), 1);
        assert!((arcs[0].sweep - 0.75 * PI).abs() < 1e-12 && arcs[0].radius == 2.0);
        assert_eq!(arcs[0].normal_base, [0.0, 0.0, 1.0]);
        assert_eq!(arcs[0].center_base, [30.0, 0.0, 0.0]);
    }
}

#[test]
fn linuxcnc_enters_along_its_first_block() {
    // Entry straight up to (0, 0) with the tool on the right: it ends right of itself at (2, 0), where the
    // contour along X turns right, an inside corner: the equidistants x = 2 and y = -2 meet in (2, -2).
    let inside = vec![
        Op::Rapid(to(0.0, -20.0)),
        comp(CompSide::Right, Some(3), None),
        line(0.0, 0.0),
        line(30.0, 0.0),
        comp(CompSide::Off, None, None),
        line(40.0, 0.0),
    ];
    assert_eq!(ends(&run(Dialect::LinuxCnc, inside).unwrap()), [[0.0, -20.0], [2.0, -2.0], [30.0, -2.0], [40.0, 0.0]]);
    // On the left it is an outside corner: the entry ends at (-2, 0), then around (0, 0) to (0, 2).
    let outside = vec![
        Op::Rapid(to(0.0, -20.0)),
        comp(CompSide::Left, Some(3), None),
        line(0.0, 0.0),
        line(30.0, 0.0),
        comp(CompSide::Off, None, None),
        line(40.0, 0.0),
    ];
    assert_eq!(
        ends(&run(Dialect::LinuxCnc, outside).unwrap()),
        [[0.0, -20.0], [-2.0, 0.0], [0.0, 2.0], [0.0, 0.0], [30.0, 2.0], [40.0, 0.0]]
    );
    let short = vec![Op::Rapid(to(0.0, -1.5)), comp(CompSide::Left, Some(3), None), line(0.0, 0.0), line(30.0, 0.0)];
    let fault = run(Dialect::LinuxCnc, short).unwrap_err();
    assert!(fault.code == codes::COMPENSATION && fault.message.contains("entry move"), "{fault}");
}

#[test]
fn the_radius_comes_from_the_word_then_the_offset_then_the_tool() {
    let first = |offset, radius, tool: bool| {
        let mut ops = vec![Op::Rapid(to(0.0, -20.0))];
        if tool {
            ops.insert(0, Op::Tool(ToolAction::Change(ToolName::Number(1))));
        }
        ops.extend([comp(CompSide::Left, offset, radius), line(0.0, 0.0), line(30.0, 0.0), Op::End]);
        run(Dialect::Iso, ops).map(|ops| ends(&ops)[1][1])
    };
    assert_eq!(first(Some(3), Some(7.0), true).unwrap(), 7.0);
    assert_eq!(first(Some(3), None, true).unwrap(), 2.0);
    assert_eq!(first(Some(4), None, true).unwrap(), 5.0);
    assert_eq!(first(None, None, true).unwrap(), 5.0);
    assert_eq!(first(Some(0), None, true).unwrap(), 0.0, "D0 is no radius");
    let fault = first(Some(4), None, false).unwrap_err();
    assert!(fault.code == codes::COMPENSATION && fault.message.contains("D4"), "{fault}");
    assert_eq!(first(Some(3), Some(-7.0), true).unwrap(), -7.0, "a negative radius is the other side");
}

#[test]
fn rapid_corners_are_straight_and_outside_of_the_circle() {
    let mut ops = wedge();
    ops[3] = Op::Rapid(to(30.0, 0.0));
    ops[4] = Op::Rapid(to(0.0, 30.0));
    let ops = run(Dialect::Heidenhain, ops).unwrap();
    assert!(!ops.iter().any(|op| matches!(op, Op::Arc(_))));
    assert_eq!(ends(&ops).len(), 6);
}

#[test]
fn a_stage_without_radii_hands_on() {
    let script = Script(
        wedge()
            .into_iter()
            .map(|op| Command {
                location: Location { file: Arc::from("x"), line: 1, column: 1, length: 1, depth: 0 },
                op,
            })
            .collect(),
    );
    let mut stage = CompensatedReader::new(Box::new(script), Dialect::Fanuc, false, &Settings::default());
    let ops: Vec<Op> = std::iter::from_fn(|| stage.next()).map(|c| c.unwrap().op).collect();
    assert_eq!(ops, wedge());
}
