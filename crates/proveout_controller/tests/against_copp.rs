//! The time of the plan against another program: TOPP3-LP of copp 0.2.3 (TOPP-THU, on the solver Clarabel) on 20 curves from rest to rest, with velocity, acceleration and jerk of
//! three joints. Its times stand in `reference/copp_topp3.csv`, which `reference/copp_topp3.py` has written: copp is no dependency, so that nothing is built for it.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

mod common;

use std::{path::Path, time::Instant};

use common::{Program, bc_machine, motion, run_with, tool};
use proveout_controller::Settings;
use proveout_nc::{Op, SplineMotion};

/// A feed that no curve reaches: joints bind, mm/s.
const FEED: f64 = 1000.0;
/// How far a time may be from the other one.
const APART: f64 = 0.01;

#[test]
fn twenty_curves_take_what_another_program_finds() {
    let machine = bc_machine();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/copp_topp3.csv");
    let rows: Vec<Vec<f64>> = std::fs::read_to_string(path)
        .expect("the other times")
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|v| v.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.len(), 20);
    let mut ratios = Vec::new();
    let begin = Instant::now();
    for row in &rows {
        let point = |k: usize| [row[3 * k], row[3 * k + 1], row[3 * k + 2]];
        let control = [point(0), point(1)];
        let [x, y, z] = point(2);
        let curve = SplineMotion { motion: motion(&[('X', x), ('Y', y), ('Z', z)]), control, control_base: control };
        let program = Program::default().exact_stop().feed(FEED).op(Op::Spline(curve));
        let run = run_with(&program, &machine, &[tool(1, 120.0)], &Settings::default());
        // By how much its time still falls with twice the stations is told beside it: what is left of its grid.
        let (coarse, fine) = (row[9], row[10]);
        let block = run.all.blocks.iter().find(|b| b.feed > 0.0).expect("the curve");
        let own = block.end_time - block.start_time;
        println!(
            "{own:.5} s, of copp {fine:.5} s ({:+.2} percent; its grid {:.2})",
            100.0 * (own / fine - 1.0),
            100.0 * (coarse / fine - 1.0)
        );
        ratios.push(own / fine);
    }
    let took = begin.elapsed().as_secs_f64();
    let mean = ratios.iter().sum::<f64>() / 20.0;
    let most = ratios.iter().map(|r| (r - 1.0).abs()).fold(0.0, f64::max);
    println!(
        "mean {:+.3} percent, farthest {:.3} percent, {:.0} ms a curve",
        100.0 * (mean - 1.0),
        100.0 * most,
        50.0 * took
    );
    assert!(ratios.iter().all(|r| (r - 1.0).abs() < APART), "{ratios:?}");
}
