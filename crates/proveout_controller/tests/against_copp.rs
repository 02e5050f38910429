//! The time of the plan against another program: TOPP3-LP of copp 0.2.3 (TOPP-THU, on the solver Clarabel) on
//! 26 curves from rest to rest, with velocity, acceleration and jerk of three joints. Its times are in
//! `reference/copp_topp3.csv`, which `reference/copp_topp3.py` has written: copp is no dependency, so that
//! nothing is built for it.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::{path::Path, time::Instant};

use crate::common::{Program, bc_machine, motion, run_with, tool};
use proveout_controller::Settings;
use proveout_nc::{Op, SplineMotion};

/// A feed that no curve reaches: joints bind, mm/s.
const FEED: f64 = 1000.0;

/// Stations of the other program lie close enough on this many curves; on the longer ones after them its
/// iteration does not come to its end, and it takes up to five percent longer.
const SHORT: usize = 20;

/// No curve takes longer than the other program finds, and none of the shorter ones much less: that keeps its
/// limits at stations alone and begins and ends with a piece of its own. The search of the long curves goes
/// by chunks, which must see far enough ahead.
#[test]
fn curves_take_the_time_that_another_program_finds() {
    let machine = bc_machine();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/copp_topp3.csv");
    let rows: Vec<Vec<f64>> = std::fs::read_to_string(path)
        .expect("the other times")
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|v| v.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.len(), 26);
    let mut ratios = Vec::new();
    let begin = Instant::now();
    for row in &rows {
        let point = |k: usize| [row[3 * k], row[3 * k + 1], row[3 * k + 2]];
        let control = [point(0), point(1)];
        let [x, y, z] = point(2);
        let curve = SplineMotion { motion: motion(&[('X', x), ('Y', y), ('Z', z)]), control, control_base: control };
        let program = Program::default().exact_stop().feed(FEED).op(Op::Spline(curve));
        let run = run_with(&program, &machine, &[tool(1, 120.0)], &Settings::default());
        // Its iteration does not always come to its end on the finer grid: the shorter of both times is the
        // one that it found.
        let other = row[9].min(row[10]);
        let block = run.all.blocks.iter().find(|b| b.feed > 0.0).expect("the curve");
        let own = block.end_time - block.start_time;
        println!("{own:.5} s, of copp {other:.5} s ({:+.2} percent)", 100.0 * (own / other - 1.0));
        ratios.push(own / other);
    }
    let took = begin.elapsed().as_secs_f64();
    let least = ratios[..SHORT].iter().copied().fold(f64::INFINITY, f64::min);
    let most = ratios.iter().copied().fold(0.0, f64::max);
    println!("{least:.4} to {most:.4}; {:.0} ms a curve", 1e3 * took / ratios.len() as f64);
    assert!(least > 0.995 && most < 1.003, "{ratios:?}");
}
