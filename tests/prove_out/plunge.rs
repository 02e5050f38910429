//! Tools without edges at their center going down into material.

use proveout_sim::{run::RunResult, verdict::State};

use crate::prove_out::bench::{Bench, end_mill, fanuc, findings, gate, line_of, state};

fn bench(tool: &str, program: &str) -> Bench {
    Bench {
        tools: end_mill(1, 12.0, tool),
        block: [[0.0, 0.0, -20.0], [80.0, 40.0, 0.0]],
        resolution_mm: 0.5,
        program: fanuc(program),
        ..Bench::default()
    }
}

const HOLLOW: &str = "center_cutting = false";
const RAMPS: &str = "center_cutting = false\nmax_ramp_angle_deg = 3";

fn process(run: &RunResult) -> (State, String) {
    let gate = gate(run, "process");
    (gate.state, gate.reason.clone())
}

#[test]
fn plunging_with_a_tool_without_center_edges_is_a_finding_at_its_block() {
    for tool in [HOLLOW, RAMPS] {
        let bench = bench(tool, "G0 X20. Y20.\nZ5.\nG1 Z-3. F100. (HERE)\nG0 Z5.");
        let run = bench.planned();
        let found = findings(&run, "process-plunge");
        assert_eq!(found.len(), 1, "{:?}", run.verdict.findings);
        assert_eq!(found[0].line, Some(line_of(&bench.program, "(HERE)")));
        assert!((found[0].value.expect("an angle") - 90.0).abs() < 1e-6, "{:?}", found[0]);
        assert_eq!(state(&run, "process"), State::Fail);
    }
    let run = bench("center_cutting = true", "G0 X20. Y20.\nZ5.\nG1 Z-3. F100.\nG0 Z5.").planned();
    assert_eq!(process(&run).0, State::Pass, "{:?}", process(&run));
    // Whether it cuts there is not stated.
    let run = bench("", "G0 X20. Y20.\nZ5.\nG1 Z-3. F100.\nG0 Z5.").planned();
    let (unknown, reason) = process(&run);
    assert_eq!(unknown, State::Unchecked, "{reason}");
    assert!(reason.contains("T1") && reason.contains("center_cutting") && reason.contains("90.0 degrees"), "{reason}");
    assert!(findings(&run, "process-plunge").is_empty());
}

/// A ramp of 40 mm: 2 mm down are 2.9 degrees, 3 mm are 4.3.
#[test]
fn a_ramp_is_held_to_the_angle_of_the_tool() {
    let ramp = |depth: f64| format!("G0 X20. Y20.\nZ5.\nG1 Z0. F100.\nX60. Z-{depth:.3} (HERE)\nX20.\nG0 Z5.");
    let allowed = bench(RAMPS, &ramp(2.0)).planned();
    assert_eq!(process(&allowed).0, State::Pass, "{:?} {:?}", process(&allowed), allowed.verdict.findings);
    let steep = bench(RAMPS, &ramp(3.0));
    let run = steep.planned();
    let found = findings(&run, "process-plunge");
    assert_eq!(
        (found.len(), found[0].line),
        (1, Some(line_of(&steep.program, "(HERE)"))),
        "{:?}",
        run.verdict.findings
    );
    let wanted = (3.0_f64 / 40.0).atan().to_degrees();
    let (angle, limit) = (found[0].value.expect("an angle"), found[0].limit.expect("the tool states it"));
    assert!((angle - wanted).abs() < 0.01 && (limit - 3.0).abs() < 1e-9, "{:?}", found[0]);
    let run = bench(HOLLOW, &ramp(2.0)).planned();
    let (unknown, reason) = process(&run);
    assert_eq!(unknown, State::Unchecked, "{reason}");
    assert!(reason.contains("max_ramp_angle_deg") && reason.contains("2.9 degrees"), "{reason}");
}

#[test]
fn a_helix_is_a_ramp_unless_it_is_narrower_than_the_tool() {
    // Turns of 5 mm radius, 1 mm down each: 1.8 degrees. The tool has 6 mm.
    let helix = |radius: f64, pitch: f64, turns: u32| {
        let mut text = format!("G0 X{:.3} Y20.\nZ5.\nG1 Z0. F100.\n", 40.0 + radius);
        for turn in 1..=turns {
            text += &format!("G3 X{:.3} Y20. Z-{:.4} I-{radius:.3} J0.\n", 40.0 + radius, pitch * f64::from(turn));
        }
        text + &format!("G3 X{:.3} Y20. I-{radius:.3} J0.\nG0 Z5.", 40.0 + radius)
    };
    let run = bench(RAMPS, &helix(5.0, 1.0, 3)).planned();
    assert_eq!(process(&run).0, State::Pass, "{:?} {:?}", process(&run), run.verdict.findings);
    let run = bench(RAMPS, &helix(5.0, 2.0, 3)).planned();
    assert_eq!(process(&run).0, State::Fail, "3.6 degrees: {:?}", run.verdict.findings);
    // Half a millimeter round, 0.1 mm down a turn: 1.8 degrees, over the same place for 2 mm.
    let run = bench(RAMPS, &helix(0.5, 0.1, 20)).planned();
    let found = findings(&run, "process-plunge");
    assert!(!found.is_empty() && found[0].unit.as_deref() == Some("mm"), "{:?}", run.verdict.findings);
}

#[test]
fn going_down_where_nothing_is_under_the_center_is_allowed() {
    for program in [
        // Next to the block, with the rim in it.
        "G0 X-3. Y20.\nZ5.\nG1 Z-3. F100.\nG0 Z5.",
        // On a floor that is there already: faced from outside, then touched again from above.
        "G0 X-10. Y20.\nZ5.\nG1 Z-2. F400.\nX90.\nG0 Z5.\nX40.\nG1 Z-2. F100.\nX60.\nG0 Z5.",
        // Only in air.
        "G0 X20. Y20.\nZ5.\nG1 Z0.5 F100.\nG0 Z5.",
    ] {
        let run = bench(HOLLOW, program).planned();
        assert_eq!(process(&run).0, State::Pass, "{program}: {:?} {:?}", process(&run), run.verdict.findings);
    }
}
