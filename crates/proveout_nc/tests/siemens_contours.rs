//! CYCLE72 of an 840D with the tool center computed: the tool never crosses the contour, touches it
//! all along, with its allowance where it roughs, and goes as deep as the program says; and what of contours
//! is refused.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_nc::{Compensation, Dialect, Op, Program, Settings, ToolName, ToolRadii, check_text};

const RADIUS: f64 = 6.0;
const CONTOUR: &str = "KON: G1 X0 Y0\nY40\nX60\nY0\nX0\nKONE: M17\n";

fn settings() -> Settings {
    let mut radii = ToolRadii::default();
    radii.by_tool.insert(ToolName::Number(1), RADIUS);
    Settings { dialect: Dialect::Siemens840d, compensation: Compensation::ToolCenter(radii), ..Settings::default() }
}

/// Points of the tool center in feed below zero, 0.2 mm apart at most.
fn below(cycle: &str) -> Vec<[f64; 3]> {
    let text = format!("T1 D1 M6\nS900 M3 F300\nG0 X-60 Y-70 Z50\n{cycle}\nG0 Z60\nM30\n{CONTOUR}");
    let (mut at, mut all) = ([0.0; 3], Vec::new());
    for command in Program::from_text("p.mpf", text.as_str(), &settings()).unwrap() {
        match command.unwrap_or_else(|e| panic!("{e}\n{text}")).op {
            Op::Rapid(m) => at = std::array::from_fn(|i| m.end_base.get(i).unwrap_or(at[i])),
            Op::Linear(m) => {
                let to: [f64; 3] = std::array::from_fn(|i| m.end_base.get(i).unwrap());
                for i in 0..=400 {
                    let t = f64::from(i) / 400.0;
                    all.push(std::array::from_fn(|k| at[k] + t * (to[k] - at[k])));
                }
                at = to;
            }
            Op::Arc(arc) => {
                let d = [at[0] - arc.center_base[0], at[1] - arc.center_base[1]];
                let to: [f64; 3] = std::array::from_fn(|i| arc.motion.end_base.get(i).unwrap());
                for i in 0..=200 {
                    let t = f64::from(i) / 200.0;
                    let (s, c) = (arc.normal_base[2] * arc.sweep * t).sin_cos();
                    let z = at[2] + t * (to[2] - at[2]);
                    all.push([arc.center_base[0] + c * d[0] - s * d[1], arc.center_base[1] + s * d[0] + c * d[1], z]);
                }
                let last = *all.last().unwrap();
                assert!((last[0] - to[0]).hypot(last[1] - to[1]) < 1e-6, "{arc:?}");
                at = to;
            }
            Op::Overcut(overcut) => panic!("{cycle}: {overcut:?}"),
            _ => {}
        }
    }
    all.into_iter().filter(|p| p[2] < -1e-9).collect()
}

/// Distance from the rectangle 0 to 60, 0 to 40; below zero inside.
fn distance(p: &[f64; 3]) -> f64 {
    let q = [(p[0] - 30.0).abs() - 30.0, (p[1] - 20.0).abs() - 20.0];
    q[0].max(0.0).hypot(q[1].max(0.0)) + q[0].max(q[1]).min(0.0)
}

#[test]
fn the_tool_keeps_its_distance_all_around() {
    // The contour runs clockwise: the tool is outside on the left.
    for (vari, allowance) in [(1, 0.5), (11, 0.5), (101, 0.5), (202, 0.0), (2, 0.0), (12, 0.0)] {
        for ways in ["2,10,900,2,10", "1,8,900,1,8", "3,6,900,2,4", "2,10,900,,"] {
            let cycle = format!("CYCLE72(\"KON:KONE\",50,0,2,-6,3,0.5,0.25,800,300,{vari},41,{ways})");
            let points = below(&cycle);
            let keeps = RADIUS + allowance;
            assert!(!points.is_empty());
            for p in &points {
                assert!(distance(p) > keeps - 1e-6, "{cycle}: {p:?} is {} from the contour", distance(p));
            }
            let deepest = points.iter().map(|p| p[2]).fold(0.0, f64::min);
            let floor = if vari % 10 == 1 { -5.75 } else { -6.0 };
            assert!((deepest - floor).abs() < 1e-9, "{cycle}: {deepest}");
            // Against each of the four sides at full depth.
            for (axis, side) in [(0, -keeps), (1, -keeps), (0, 60.0 + keeps), (1, 40.0 + keeps)] {
                let beside = points.iter().any(|p| {
                    let other = [40.0, 60.0][axis];
                    (p[axis] - side).abs() < 1e-6
                        && (p[1 - axis] - 0.5 * other).abs() < 1.0
                        && (p[2] - floor).abs() < 1e-9
                });
                assert!(beside, "{cycle}: not along {axis} {side}");
            }
        }
    }
}

#[test]
fn the_state_of_the_program_is_as_before_the_contour() {
    let text = "T1 D1 M6\nS900 M3 F300 G90 G17\nG0 X-60 Y-70 Z50\nR1=1\nCYCLE72(\"KON:KONE\",50,0,2,-6,6,0,0,800,300,2,41,2,10,900,2,10)\n\
         G0 X5 Y5\nG91 X1\nM30\nKON: G1 X0 Y0\nG91 Y40\nX60\nG90 Y0\nX0\nR1=R1+1\nKONE: M17\n";
    let program = Program::from_text("p.mpf", text, &settings()).unwrap();
    let last = program.filter_map(|c| match c.unwrap().op {
        Op::Rapid(m) => Some([m.end.get(0), m.end.get(1)]),
        _ => None,
    });
    assert_eq!(last.last().unwrap(), [Some(6.0), Some(5.0)]);
}

#[test]
fn contours_that_are_none_are_refused() {
    for (contour, says) in [
        ("KON: G1 X0 Y0\nKONE: M17", "fewer than two points"),
        ("KON: G2 X5 Y0 I5 J0\nX9 Y9\nKONE: M17", "start of the arc is not known"),
        ("KON: G1 X0 Y0\nX5 Z-2\nKONE: M17", "another axis"),
        ("KON: G1 X0 Y0\nT2 M6\nX5\nKONE: M17", "changes the tool"),
        ("KON: G1 X0 Y0\nATRANS X5\nX5\nKONE: M17", "changes the frame"),
        ("KON: G1 X0\nX5\nKONE: M17", "both coordinates"),
        ("KON: G1 X0 Y0\nKON1: GOTOB KON1\nKONE: M17", "more than 20000 blocks"),
        ("KON: G1 X0 Y0\nX5\nM17", "no label KONE"),
        (
            "KON: G1 X0 Y0\nCYCLE72(\"KON:KONE\",5,0,2,-6,6,0,0,800,300,2,41,2,9,900,2,9)\nKONE: M17",
            "within another contour",
        ),
    ] {
        let text = format!(
            "T1 D1 M6\nS900 M3 F300\nCYCLE72(\"KON:KONE\",50,0,2,-6,6,0,0,800,300,2,41,2,10,900,2,10)\nM30\n{contour}\n"
        );
        let faults = check_text("p.mpf", &text, &settings());
        assert!(faults.iter().any(|f| f.code == "nc-subprogram" && f.message.contains(says)), "{says}: {faults:?}");
    }
    for (cycle, code) in [
        ("CYCLE72(\"KON:KONE\",50,0,2,-6,6,0,0,800,300,10002,41,2,10,900,2,10)", "nc-unsupported-word"),
        ("CYCLE72(\"KON:KONE\",50,0,2,-6,6,0,0,800,300,5,41,2,10,900,2,10)", "nc-arguments"),
        ("CYCLE72(\"KON:KONE\",50,0,2,-6,6,0,0,800,300,2,43,2,10,900,2,10)", "nc-arguments"),
        ("CYCLE72(\"KON:KONE\",50,0,2,-6,6,0,0,800,300,2,41,4,10,900,2,10)", "nc-unsupported-word"),
        ("CYCLE72(\"KON:KONE\",50,0,2,-6,6,0,0,800,300,2,40,2,10,900,2,10)", "nc-arguments"),
        ("CYCLE72(,50,0,2,-6,6,0,0,800,300,2,41,2,10,900,2,10)", "nc-arguments"),
        ("CYCLE62(\"KON\",3)", "nc-unsupported-word"),
    ] {
        let text = format!("T1 D1 M6\nS900 M3 F300\nG0 X-60 Y-70 Z50\n{cycle}\nM30\n{CONTOUR}");
        let faults = check_text("p.mpf", &text, &settings());
        assert!(faults.iter().any(|f| f.code == code), "{cycle}: {faults:?}");
    }
}
