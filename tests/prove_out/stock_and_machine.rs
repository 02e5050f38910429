//! Bodies of machine and setup against the stock, as it is at each moment.

use proveout_sim::verdict::State;

use crate::prove_out::bench::{Bench, end_mill, fanuc, findings, gate, line_of, state};

/// A tall wall next to the spindle: x 90..130, up to 450 mm over the work zero.
fn wall(program: &str) -> Bench {
    Bench {
        tools: end_mill(1, 10.0, "center_cutting = true"),
        resolution_mm: 5.0,
        block: [[90.0, -50.0, -100.0], [130.0, 50.0, 450.0]],
        program: program.into(),
        ..Bench::default()
    }
}

const HEAD: &str = "%\nO1\nG17 G21 G40 G49 G80 G90 G94\nG54\n";

#[test]
fn a_spindle_that_is_driven_through_the_stock_fails_at_its_line() {
    // Empty spindle, and a tool: the body of the spindle is in the wall in both.
    for tool in ["", "T1 M6\nG43 H1\n"] {
        let bench = wall(&format!("{HEAD}{tool}S1000 M3\nG0 X0 Y0 Z300\nG1 Z50 F5000\nG1 X20\nM30\n%\n"));
        let run = bench.planned();
        let collision = gate(&run, "collision");
        assert_eq!(collision.state, State::Fail, "{collision:?}");
        let hits = findings(&run, "collision-stock-body");
        assert!(hits.iter().any(|f| f.bodies == ["spindle", "stock"]), "{hits:?}");
        // The head is wider, and comes down on the wall before.
        for hit in hits.iter().filter(|f| f.bodies[0].starts_with("spindle")) {
            assert_eq!(hit.line, Some(line_of(&bench.program, "G1 X20")), "{hit:?}");
        }

        // The same wall as a fixture agrees in time to within the stated error: the diagonal of a cell, on
        // the way along X.
        let mut fixed = wall(&bench.program);
        fixed.block = [[-300.0, -300.0, -100.0], [-290.0, -290.0, -90.0]];
        fixed.extra =
            "[[fixture]]\nname = \"wall\"\nbox = { min_mm = [90, -50, -100], max_mm = [130, 50, 450] }\n".into();
        let other = fixed.planned();
        let walls = findings(&other, "collision-bodies");
        for hit in &hits {
            let wall = walls.iter().find(|f| f.bodies.contains(&hit.bodies[0])).expect("the same body");
            assert_eq!(hit.line, wall.line);
            let way = |f: &proveout_sim::finding::Finding| f.axes["X"] - f.axes["Z"];
            let early = way(wall) - way(hit);
            assert!((-0.02..=5.0 * 3.0_f64.sqrt() + 0.02).contains(&early), "{early} mm early: {hit:?} {wall:?}");
        }
    }
}

/// Two levels with a face mill whose flutes are shorter than the block is high: on the lower one the spindle
/// nose is 30 mm under the top of the raw block, in the room that the upper one has made. Without the upper
/// one it hits what is left there.
#[test]
fn what_the_cutter_has_taken_is_no_obstacle_to_the_spindle() {
    let tools = "[[tool]]\nnumber = 1\nname = \"FACE\"\nkind = \"flat\"\ndiameter_mm = 160\nflute_length_mm = 60\n\
                 shank_diameter_mm = 20\ngauge_length_mm = 70\ncenter_cutting = true\n\
                 holder = { sections = [{ diameter_mm = 30, length_mm = 10 }] }\n";
    for (upper, hits) in [("Z-50.\nG1 X160. F6000\nG0 Z20.\nX-100.\n", false), ("", true)] {
        let bench = Bench {
            tools: tools.into(),
            resolution_mm: 2.0,
            block: [[0.0, -20.0, -120.0], [60.0, 60.0, 0.0]],
            program: fanuc(&format!("G0 X-100. Y20.\n{upper}Z-100.\nG1 X155. F6000\nG0 X160.\nZ50.")),
            ..Bench::default()
        };
        let run = bench.planned();
        let found = findings(&run, "collision-stock-body");
        assert_eq!(!found.is_empty(), hits, "{:?}", gate(&run, "collision"));
        assert!(found.iter().all(|f| f.line == Some(line_of(&bench.program, "G1 X155."))), "{found:?}");
    }
}

#[test]
fn what_stays_away_from_the_box_of_the_stock_passes_and_says_so() {
    let bench = Bench {
        tools: end_mill(1, 10.0, "center_cutting = true"),
        program: fanuc("G0 X-10. Y10.\nZ5.\nG1 Z-2. F600\nX70.\nG0 Z5."),
        ..Bench::default()
    };
    let run = bench.planned();
    let collision = gate(&run, "collision");
    assert_eq!(collision.state, State::Pass, "{collision:?}");
    assert!(collision.reason.contains("from the in-process stock throughout"), "{collision:?}");
    assert!(collision.reason.contains("may touch it: ") && collision.reason.contains("table"), "{collision:?}");
    assert_eq!(state(&run, "near_miss"), State::Pass);
}

/// The face of the spindle nose is the gauge line, 80 mm over the tip: at a depth of 78.9 mm next to a wall
/// it stays 1.1 mm over the top of the stock, at 79.1 mm it does not keep the wanted 1 mm.
#[test]
fn the_clearance_of_the_scene_decides_and_a_thin_motion_is_not_stepped_over() {
    let at = |depth: f64| {
        let bench = Bench {
            tools: "[[tool]]\nnumber = 1\nname = \"PIN\"\nkind = \"flat\"\ndiameter_mm = 2\nflute_length_mm = 10\n\
                    shank_diameter_mm = 2\ngauge_length_mm = 80\ncenter_cutting = true\n\
                    holder = { sections = [{ diameter_mm = 3, length_mm = 10 }] }\n"
                .into(),
            block: [[0.0, 0.0, -60.0], [60.0, 20.0, 0.0]],
            resolution_mm: 1.0,
            // Down and up again in one block each, outside of the block by 5 mm.
            program: fanuc(&format!("G0 X-5. Y10.\nZ5.\nG0 Z-{depth:.3}\nZ5.")),
            ..Bench::default()
        };
        let run = bench.planned();
        let near: Vec<_> = findings(&run, "collision-near-miss").into_iter().cloned().collect();
        (state(&run, "collision"), state(&run, "near_miss"), near)
    };
    // The raw box proves more than rays every millimeter, whose diagonal is 1.732 mm.
    assert_eq!(at(78.9), (State::Pass, State::Pass, vec![]));
    let (collision, near_miss, found) = at(79.1);
    assert_eq!((collision, near_miss), (State::Pass, State::Fail));
    let [near] = &found[..] else { panic!("only the nose comes near: {found:?}") };
    assert_eq!(near.bodies, ["spindle_nose", "stock"]);
    assert!(near.clearance_mm.is_some_and(|c| (0.85..=1.01).contains(&c)), "{near:?}");
}

#[test]
fn a_stock_that_would_stand_in_the_table_fails_with_its_depth() {
    let mut bench = Bench {
        tools: end_mill(1, 10.0, "center_cutting = true"),
        program: fanuc("G0 X-10. Y10.\nZ5."),
        height_mm: 20.0,
        ..Bench::default()
    };
    assert_eq!(state(&bench.planned(), "collision"), State::Pass, "its lower face lies on the table");
    bench.height_mm = 17.0;
    let run = bench.planned();
    let collision = gate(&run, "collision");
    assert_eq!(collision.state, State::Fail, "{collision:?}");
    assert!(
        collision.reason.contains("stock against the table") && collision.reason.contains("3.000 mm"),
        "{collision:?}"
    );
    let [standing] = findings(&run, "collision-stock-at-rest")[..] else { panic!("{:?}", run.verdict.findings) };
    assert_eq!(standing.bodies, ["table", "stock"]);
    assert!((standing.penetration_mm.expect("a depth") - 3.0).abs() < 1e-6, "{standing:?}");
}

#[test]
fn a_jaw_that_is_sunk_into_the_stock_is_reported_with_its_depth() {
    for (sunk, state_then) in [(0.0, State::Pass), (0.35, State::Fail)] {
        let x = 60.0 - sunk;
        let bench = Bench {
            tools: end_mill(1, 10.0, "center_cutting = true"),
            program: fanuc("G0 X-10. Y10.\nZ5."),
            extra: format!("[[fixture]]\nname = \"jaw\"\nbox = {{ min_mm = [{x}, 0, -30], max_mm = [90, 20, -8] }}\n"),
            ..Bench::default()
        };
        let run = bench.planned();
        assert_eq!(state(&run, "collision"), state_then, "{:?}", gate(&run, "collision"));
        let standing = findings(&run, "collision-stock-at-rest");
        assert_eq!(standing.len(), usize::from(sunk > 0.0));
        assert!(standing.iter().all(|f| (f.penetration_mm.unwrap_or(0.0) - sunk).abs() < 1e-6), "{standing:?}");
    }
}

/// A rapid through the block, and through a fin of 0.2 mm that lies between the cells along Y: the cutter
/// meets both at their line.
#[test]
fn a_rapid_through_material_and_through_a_thin_fin_is_found() {
    // The fin is a stock of its own, which cells of a millimeter do not hold.
    for (block, resolution_mm) in
        [([[0.0, 0.0, -20.0], [60.0, 20.0, 0.0]], 1.0), ([[30.0, -40.0, -20.0], [30.2, 60.0, 0.0]], 0.26)]
    {
        let at_rapid = "G0 X80.";
        let bench = Bench {
            tools: end_mill(1, 4.0, "center_cutting = true"),
            resolution_mm,
            block,
            program: fanuc(&format!("G0 X-10. Y10.\nZ-3.\n{at_rapid}\nZ5.")),
            ..Bench::default()
        };
        let run = bench.planned();
        let found = findings(&run, "process-rapid-in-material");
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].line, Some(line_of(&bench.program, at_rapid)));
        assert_eq!(state(&run, "process"), State::Fail);
    }
}
