//! Corners of feed and rapid: what is removed belongs to the block whose path it follows, and a rapid in
//! material is as deep as it is.

use proveout_sim::{run::RunResult, scene::Dynamics, verdict::State};

use crate::prove_out::bench::{Bench, end_mill, fanuc, findings, gate, line_of, state};

const RAPID: &str = "process-rapid-in-material";

fn bench(program: &str) -> Bench {
    Bench { tools: end_mill(1, 3.0, "center_cutting = true"), program: fanuc(program), ..Bench::default() }
}

/// A hole and a slot, each left by a vertical rapid, with the words that separate the last feed from the
/// rapid.
fn slot_and_retract(end: &str, stop: &str) -> String {
    format!(
        "G0 X10.03 Y10.03\nZ3.\nG1 Z-15. F600\nG0 Z3.\nX30.03\nG1 Z-5. F600\n{end} X50.03\n{stop}G0 Z3.\n\
         X20. Y5.\nG1 Z-4. F600\nG2 X26. Y5. I3. J0.\nG0 Z3.\nX40. Y8.\nG1 Z-3.\nX44. Y4.\nG0 Z3."
    )
}

const DYNAMICS: [Dynamics; 3] = [Dynamics::Ideal, Dynamics::Planned, Dynamics::Servo];

#[test]
fn a_retract_out_of_a_slot_is_no_rapid_in_material() {
    let mut removed = Vec::new();
    for (end, stop) in [("G1", ""), ("G9 G1", ""), ("G1", "G4 P100\n")] {
        for dynamics in DYNAMICS {
            let bench = bench(&slot_and_retract(end, stop));
            let run = bench.run(dynamics).unwrap_or_else(|e| panic!("{e}"));
            assert!(findings(&run, RAPID).is_empty(), "{end} {stop} {dynamics:?}: {:?}", run.verdict.findings);
            // Under ideal dynamics no corner is rounded: nothing is found, and nothing passes.
            let wanted = if dynamics == Dynamics::Ideal { State::Unchecked } else { State::Pass };
            assert_eq!(state(&run, "process"), wanted, "{:?}", gate(&run, "process"));
            if dynamics != Dynamics::Servo {
                removed.push(run.verdict.removal.volume_mm3);
            }
        }
    }
    // With an exact stop, with a dwell or with neither: the slot has the same end. Corners of feed and feed
    // do not occur but for that of plunge and slot, which the path tolerance of 0.01 mm rounds.
    let (low, high) = removed.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(high - low < 0.2 && low > 300.0, "{removed:?}");
}

#[test]
fn the_end_of_a_slot_is_where_the_program_says() {
    // The wall at the end of the slot, from inside: the axis at 50.1 and the radius of 1.5, on a ray through
    // the axis.
    let wall = "[[inspect]]\nname = \"end\"\nfrom_mm = [45, 10.125, -3.125]\ndirection = \"+x\"\nnominal_mm = 51.6\ntolerance_mm = 0.001\n";
    let program = "G0 X30. Y10.125\nZ3.\nG1 Z-5. F600\nX50.1\nG0 Z3.";
    let run = Bench { extra: wall.into(), ..bench(program) }.planned();
    assert!(findings(&run, "geometry-inspection").is_empty(), "{:?}", run.verdict.inspection);
}

/// Cycles leave their holes at rapid rate as well.
#[test]
fn drilling_cycles_leave_their_holes_without_a_finding() {
    let drill = "[[tool]]\nnumber = 1\nname = \"DRILL\"\nkind = \"drill\"\ndiameter_mm = 3.0\npoint_angle_deg = 135.0\nflute_length_mm = 16.0\n\
         shank_diameter_mm = 3.0\ngauge_length_mm = 75.0\nholder = { sections = [{ diameter_mm = 40, length_mm = 50 }] }\n";
    for cycle in ["G81 Z-15. R3. F600", "G83 Z-15. R3. Q4. F600", "G73 Z-15. R3. Q4. F600"] {
        let program = fanuc(&format!("G0 X10.03 Y10.03 Z3.\n{cycle}\nX20.03\nX30.03 Z-6.\nG80"));
        let run = Bench { tools: drill.into(), program, ..Bench::default() }.planned();
        assert!(findings(&run, RAPID).is_empty(), "{cycle}: {:?}", run.verdict.findings);
        // The point of a drill cuts at its center: no one has to say so.
        assert_eq!(state(&run, "process"), State::Pass, "{:?}", gate(&run, "process"));
    }
}

fn only(run: &RunResult, program: &str, line: &str) -> f64 {
    let found = findings(run, RAPID);
    assert_eq!(found.len(), 1, "{:?}", run.verdict.findings);
    assert_eq!(found[0].line, Some(line_of(program, line)), "{:?}", found[0]);
    assert_eq!(state(run, "process"), State::Fail);
    found[0].penetration_mm.expect("a depth")
}

#[test]
fn a_true_rapid_is_found_with_its_depth_and_its_line() {
    // Axes lie on rays, so that they see the deepest line of the cutter.
    for depth in [0.05, 1.0, 12.0] {
        let plunge = format!("G0 X30.125 Y10.125\nZ-{depth:.3} (HERE)\nZ5.");
        for dynamics in DYNAMICS {
            let bench = bench(&plunge);
            let run = bench.run(dynamics).unwrap_or_else(|e| panic!("{e}"));
            let found = only(&run, &bench.program, "(HERE)");
            // Drives overshoot by a micrometer or two.
            let within = if dynamics == Dynamics::Servo { 0.02 } else { 1e-4 };
            assert!((found - depth).abs() < within, "plunge {depth} {dynamics:?}: {found}");
        }
    }
    // Next to the block at z = -8, then into its face x = 0 by so much: the radius is 1.5.
    for depth in [0.05, 0.8, 3.0] {
        let bench = bench(&format!("G0 X-10. Y10.125\nZ-8.\nX{:.3} (HERE)\nX-10.\nZ5.", depth - 1.5));
        let found = only(&bench.planned(), &bench.program, "(HERE)");
        assert!((found - depth).abs() < 1e-4, "aside {depth}: {found}");
    }
    // A slot in feed, then on along it at rapid: as deep as it has gone on, at most as deep as the slot.
    for (on, depth) in [(0.4, 0.4), (2.0, 2.0), (9.0, 4.0)] {
        let bench =
            bench(&format!("G0 X20.125 Y10.125\nZ3.\nG1 Z-4. F600\nX30.125\nG0 X{:.3} (HERE)\nZ5.", 30.125 + on));
        let found = only(&bench.planned(), &bench.program, "(HERE)");
        assert!((found - depth).abs() < 1e-3, "on {on}: {found}");
    }
}

/// A rapid that turns the table drags the cutter round in hundreds of short pieces, each of which shaves its
/// own thin layer.
#[test]
fn a_rapid_on_a_circle_is_as_deep_as_the_groove_that_it_cuts() {
    let program = "N10 G17 G710 G90 G94\nN20 T=\"T1\"\nN30 M6\nN40 G54 D1\nN50 S3000 M3\nN60 G0 B0 C0\nN70 G0 X12.125 Y0.125\n\
                   N80 G0 Z5\nN90 G1 Z-2 F600\nN100 G0 C20 ; HERE\nN110 G0 Z5\nN120 M30\n";
    let bench = Bench {
        machine: "spinner-u5-620",
        block: [[-20.0, -20.0, -20.0], [20.0, 20.0, 0.0]],
        program: program.into(),
        file: "program.mpf",
        ..bench("")
    };
    let run = bench.planned();
    let depth = only(&run, program, "HERE");
    // The groove is 2 mm deep and 3 mm wide; it goes on by 4.2 mm, farther than it is deep.
    assert!((depth - 2.0).abs() < 0.01, "{depth}");
}

#[test]
fn a_tool_that_stands_still_is_found_with_its_depth_too() {
    let program = fanuc("M5\nG0 X30.125 Y10.125\nZ3.\nG1 Z-4. F600 (HERE)\nX40.\nG0 Z3.");
    let run = Bench { program: program.clone(), ..bench("") }.planned();
    let found = findings(&run, "process-spindle-off");
    assert_eq!((found.len(), found[0].line), (1, Some(line_of(&program, "(HERE)"))), "{:?}", run.verdict.findings);
    // The slot after it goes on in the same run: it is no deeper than its floor.
    assert!((found[0].penetration_mm.expect("a depth") - 4.0).abs() < 1e-3, "{:?}", found[0]);
    assert!(findings(&run, RAPID).is_empty(), "{:?}", run.verdict.findings);
}
