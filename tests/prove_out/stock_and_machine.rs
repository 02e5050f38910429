//! Bodies of the machine against the stock: nothing sweeps them through it, and no gate passes what nobody has looked at.

use proveout_sim::verdict::State;

use crate::bench::{Bench, end_mill, fanuc, gate, state};

/// A tall wall beside the spindle: x 90..130, up to 450 mm over the work zero.
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
fn a_spindle_that_is_driven_through_the_stock_is_not_passed() {
    // Empty spindle, and a tool: the body of the spindle is in the wall in both.
    for tool in ["", "T1 M6\nG43 H1\n"] {
        let bench = wall(&format!("{HEAD}{tool}S1000 M3\nG0 X0 Y0 Z300\nG1 Z50 F5000\nG1 X20\nM30\n%\n"));
        let run = bench.planned();
        for name in ["collision", "near_miss"] {
            let gate = gate(&run, name);
            assert_ne!(gate.state, State::Pass, "{gate:?}");
            assert!(gate.reason.contains("stock against") && gate.reason.contains("spindle"), "{gate:?}");
        }
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
    assert!(collision.reason.contains("from the box of the raw stock all the way"), "{collision:?}");
    assert!(collision.reason.contains("table") && collision.reason.contains("mounting"), "{collision:?}");
    assert_eq!(state(&run, "near_miss"), State::Pass);
}

/// The face of the spindle nose is the gauge line, 80 mm over the tip: at a depth of 78.9 mm beside a wall it stays 1.1 mm over the
/// top of the stock, at 79.1 mm it does not keep the wanted 1 mm.
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
        let collision = gate(&run, "collision").clone();
        (collision.state, collision.reason)
    };
    let (state, reason) = at(78.9);
    assert_eq!(state, State::Pass, "{reason}");
    let (state, reason) = at(79.1);
    assert_eq!(state, State::Unchecked, "{reason}");
    assert!(reason.contains("spindle_nose (from"), "{reason}");
    assert!(!reason.contains("column"), "only what comes near is named: {reason}");
}

#[test]
fn a_stock_that_would_stand_in_the_table_is_not_passed() {
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
    assert_eq!(collision.state, State::Unchecked, "{collision:?}");
    assert!(
        collision.reason.contains("stock against the table") && collision.reason.contains("3.000 mm"),
        "{collision:?}"
    );
}
