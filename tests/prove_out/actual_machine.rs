//! Geometric errors of a machine: the control believes in the described machine, and the actual one cuts.

use proveout_sim::{run::RunResult, scene::Dynamics, verdict::State};

use crate::prove_out::bench::{Bench, end_mill, fanuc, gate};

const INSPECT: &str = "[[inspect]]\nname = \"floor\"\nfrom_mm = [30.125, 10.125, 5]\ndirection = \"-z\"\nnominal_mm = -3\ntolerance_mm = 0.002\n\
                       [[inspect]]\nname = \"right wall\"\nfrom_mm = [30.125, 10.125, -1.125]\ndirection = \"+x\"\nnominal_mm = 35.125\ntolerance_mm = 0.01\n\
                       [[inspect]]\nname = \"rear wall\"\nfrom_mm = [30.125, 10.125, -1.125]\ndirection = \"+y\"\nnominal_mm = 15.125\ntolerance_mm = 0.01\n";

/// A blind hole of 10 mm by an end mill.
fn bench(errors: &str) -> Bench {
    Bench {
        tools: end_mill(1, 10.0, "center_cutting = true"),
        machine_extra: errors.into(),
        program: fanuc("G0 X30.125 Y10.125\nZ5.\nG1 Z-3. F400\nG0 Z5."),
        extra: INSPECT.into(),
        ..Bench::default()
    }
}

/// Floor, right wall and rear wall.
fn measured(run: &RunResult) -> [f64; 3] {
    std::array::from_fn(|k| run.verdict.inspection[k].measured_mm.expect("it is there"))
}

const DYNAMICS: [Dynamics; 3] = [Dynamics::Ideal, Dynamics::Planned, Dynamics::Servo];

#[test]
fn the_cut_moves_by_the_stated_errors_with_any_dynamics() {
    // Spindle 0.5 mm up; X and Y zero off by 40 and -30 micrometers: both carry the table, which moves the
    // tool the other way.
    let errors = "\n[errors.constant]\nEZ0S_um = 500\nEX0X_um = 40\nEY0Y_um = -30\n[errors.chosen]\n\"*\" = \"test\"\n";
    for dynamics in DYNAMICS {
        let plain = measured(&bench("").run(dynamics).expect("runs"));
        let actual = bench(errors).run(dynamics).expect("runs");
        let moved: Vec<f64> = measured(&actual).iter().zip(plain).map(|(a, p)| a - p).collect();
        for (moved, wanted) in moved.iter().zip([0.5, -0.04, 0.03]) {
            // The walls are round: 0.04 mm aside of their crown they are 1.6e-4 mm back; twice the sweep's
            // bound.
            assert!((moved - wanted).abs() < 6e-4, "{dynamics:?}: {moved} instead of {wanted}");
        }
        let plain_floor = if dynamics == Dynamics::Servo { 0.02 } else { 1e-4 };
        assert!((plain[0] + 3.0).abs() < plain_floor, "{dynamics:?}: {plain:?}");
        assert!(gate(&actual, "collision").reason.contains("geometric errors"), "{:?}", gate(&actual, "collision"));
        assert_ne!(gate(&actual, "excess").state, State::Pass, "the floor is half a millimeter high");
        // The control knows nothing of it: the same set points.
        let z = |r: &RunResult| (r.verdict.axes["Z"].min, r.verdict.time.total_s);
        assert_eq!(z(&actual).1, bench("").run(dynamics).expect("runs").verdict.time.total_s);
    }
}

/// Straightness of X against its position, with kinks: the floor of a slot follows it, between the places as
/// well.
#[test]
fn a_slot_follows_the_table_of_errors_of_its_slide() {
    // EZX: the table is lower by 20, 0, 60 micrometers at X = 10, 25, 45, so that the tool is that much
    // higher over it.
    let errors = "\n[[errors.table]]\njoint = \"X\"\nat_mm = [10, 25, 45]\n[errors.table.values]\nEZX_um = [-20, 0, -60]\n\
                  [errors.chosen]\n\"*\" = \"test\"\n";
    let probe = |x: f64| {
        format!(
            "[[inspect]]\nname = \"{x}\"\nfrom_mm = [{x}, 10.125, 5]\ndirection = \"-z\"\nnominal_mm = -3\ntolerance_mm = 1\n"
        )
    };
    // The lowest of the cutter counts, and its face is flat: the floor at x is the lowest that the tip has
    // been within the radius of x, so that small cutters follow best.
    let places = [12.125, 17.125, 30.125, 35.125, 42.125, 52.125];
    let bench = Bench {
        tools: end_mill(1, 0.5, "center_cutting = true"),
        program: fanuc("G0 X5.125 Y10.125\nZ5.\nG1 Z-3. F400\nX55.125\nG0 Z5."),
        extra: places.map(probe).concat(),
        ..bench(errors)
    };
    for dynamics in DYNAMICS {
        let run = bench.run(dynamics).expect("runs");
        for (place, found) in places.iter().zip(&run.verdict.inspection) {
            let height = |x: f64| match x {
                x if x < 10.0 => 0.02,
                x if x < 25.0 => 0.02 * (25.0 - x) / 15.0,
                x if x < 45.0 => 0.06 * (x - 25.0) / 20.0,
                _ => 0.06,
            };
            let wanted = -3.0 + height(place - 0.25).min(height(place + 0.25));
            let found = found.measured_mm.expect("a floor");
            let within = if dynamics == Dynamics::Servo { 3e-3 } else { 6e-4 };
            assert!((found - wanted).abs() < within, "{dynamics:?} {place}: {found} instead of {wanted}");
        }
    }
}
