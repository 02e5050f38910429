//! Pieces against the true motion, looked at far more densely than they were cut: the tool between tip and
//! gauge line, its edges, the joints. The true motion is that of samples at a tenth of a millisecond; forward
//! kinematics are the machine's.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use crate::common::{Program, Random, Run, bc_machine, for_all, run_with, tool};
use proveout_controller::{MoveKind, Piece, Sample, Settings};
use proveout_geom::ToolPose;
use proveout_machine::{JointValues, MAX_JOINTS, Machine};

/// Way to the gauge line and to the end of the edges of the test tool, mm.
const LENGTH: f64 = 120.0;
const EDGES: f64 = 20.0;

/// Least over all places of the piece of the distance of `x`; `distance` is that of a place. Golden sections
/// after a coarse look.
fn nearest(distance: impl Fn(f64) -> f64) -> f64 {
    let n = 16;
    let best = (0..=n).min_by(|a, b| {
        let at = |k: &i32| distance(f64::from(*k) / f64::from(n));
        at(a).total_cmp(&at(b))
    });
    let middle = f64::from(best.expect("places")) / f64::from(n);
    let (mut a, mut b) = ((middle - 1.0 / f64::from(n)).max(0.0), (middle + 1.0 / f64::from(n)).min(1.0));
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    for _ in 0..60 {
        let (c, d) = (b - ratio * (b - a), a + ratio * (b - a));
        if distance(c) < distance(d) {
            b = d;
        } else {
            a = c;
        }
    }
    distance(0.5 * (a + b))
}

fn off_tool(piece: &Piece, pose: &ToolPose, length: f64) -> f64 {
    nearest(|t| {
        let on = piece.pose[0].interpolated(&piece.pose[1], t);
        // Points between are convex combinations of both ends.
        let end = |p: &ToolPose| p.tip + p.axis * length;
        (on.tip - pose.tip).norm().max((end(&on) - end(pose)).norm())
    })
}

/// Highest part of its bound by which a joint leaves the straight motion of all; rounding of 1e-9 is none.
fn off_joints(piece: &Piece, q: &JointValues) -> f64 {
    nearest(|t| {
        let straight = piece.joints[0] + (piece.joints[1] - piece.joints[0]) * t;
        (0..MAX_JOINTS)
            .map(|i| ((q[i] - straight[i]).abs() - 1e-9).max(0.0) / piece.joint_deviation[i].max(1e-9))
            .fold(0.0, f64::max)
    })
}

/// Highest parts of the bounds: whole tool, edges, joints; and the number of samples that were looked at.
fn compare(run: &Run) -> ([f64; 3], usize) {
    let (mut worst, mut count, mut at) = ([0.0_f64; 3], 0, 0);
    let pieces: Vec<&Piece> = run.all.pieces.iter().filter(|p| p.kind != MoveKind::Handling).collect();
    let inside = |s: &&Sample| s.kind != MoveKind::Handling;
    for sample in run.all.samples.iter().filter(inside).step_by(5) {
        while at + 1 < pieces.len() && pieces[at].time[1] < sample.time {
            at += 1;
        }
        let piece = pieces[at];
        if !(piece.time[0]..=piece.time[1]).contains(&sample.time) {
            continue;
        }
        count += 1;
        let tool = off_tool(piece, &sample.pose, LENGTH);
        let edges = off_tool(piece, &sample.pose, EDGES);
        let found = [
            (tool - 1e-9).max(0.0) / piece.deviation.max(1e-9),
            (edges - 1e-9).max(0.0) / piece.edge_deviation.max(1e-9),
            off_joints(piece, &sample.commanded),
        ];
        for (worst, found) in worst.iter_mut().zip(found) {
            *worst = worst.max(found);
        }
    }
    (worst, count)
}

fn dense(program: &Program, machine: &Machine) -> Run {
    let settings = Settings { sample_time: Some(1e-4), ..Settings::default() };
    run_with(program, machine, &[tool(1, LENGTH)], &settings)
}

/// Lines of 0.05 to 20 mm with turns up to a radian, waves through the pole of C, tolerances from 1 to 100
/// micrometers; reversals of single joints at every corner and within blocks (linear joints on turning
/// ones).
#[test]
fn the_true_motion_keeps_the_bounds_of_its_pieces() {
    let machine = bc_machine();
    let settings = Settings::default();
    for_all(0..24, |seed| {
        let mut r = Random::new(seed * 31 + 7);
        let step = 10_f64.powf(r.range(-1.3, 1.3));
        let turn = 10_f64.powf(r.range(-3.0, 0.0));
        let tolerance = 10_f64.powf(r.range(-3.0, -1.0));
        let mut at = [0.0, 0.0, 150.0, if seed % 3 == 0 { 0.0 } else { 0.4 }, 0.1];
        let values = |at: &[f64; 5]| -> Vec<(char, f64)> { "XYZBC".chars().zip(*at).collect() };
        let start = values(&at);
        let mut program =
            Program::default().change(1).g0(&start[..3]).g0(&start[3..]).tcp(true).g0(&start).continuous(tolerance);
        program = program.feed(10_f64.powf(r.range(0.7, 2.5)));
        for _ in 0..10 {
            for (i, v) in at.iter_mut().enumerate() {
                let size = [step, step, 0.3 * step, turn, 2.0 * turn][i];
                *v += r.range(-size, size);
            }
            at[3] = at[3].clamp(-1.2, 1.2);
            program = program.g1(&values(&at));
        }
        let run = dense(&program, &machine);
        let (worst, count) = compare(&run);
        assert!(count > 200, "seed {seed}: {count} samples");
        assert!(worst.iter().all(|w| *w <= 1.0), "seed {seed}: parts of the bounds of tool, edges, joints {worst:?}");
        for p in &run.all.pieces {
            assert!(p.edge_deviation <= p.deviation && p.deviation <= settings.piece_body_tolerance);
            assert!(p.edge_deviation <= settings.piece_tolerance);
        }
        println!("seed {seed}: {} pieces, {count} samples, parts of the bounds {worst:.3?}", run.all.pieces.len());
    });
}

/// A half turn of B about a still tip: the linear joints run on an arc about the axis of B, whose height over
/// a chord of angle a is r (1 - cos a/2).
#[test]
fn linear_joints_that_follow_a_turn_leave_their_chord_by_its_height() {
    let machine = bc_machine();
    let start = [('X', 30.0), ('Y', 0.0), ('Z', 150.0), ('B', -0.3), ('C', 0.0)];
    let end = [('X', 30.0), ('Y', 0.0), ('Z', 150.0), ('B', 0.3), ('C', 0.0)];
    let program = Program::default().change(1).g0(&start[..3]).g0(&start[3..]).tcp(true).g0(&start).feed(20.0).g1(&end);
    let run = dense(&program, &machine);
    let turning: Vec<&Piece> = run.all.pieces.iter().filter(|p| p.kind == MoveKind::Feed).collect();
    assert!(turning.len() > 5, "{}", turning.len());
    for p in turning {
        let angle = (p.joints[1][3] - p.joints[0][3]).abs();
        // The axis of B lies 60 mm above the table: the tip runs round it at this distance in the machine.
        let radius = (30.0_f64.powi(2) + 90.0_f64.powi(2)).sqrt();
        let height = radius * (1.0 - (0.5 * angle).cos());
        let deviation = (p.joint_deviation[0].powi(2) + p.joint_deviation[2].powi(2)).sqrt();
        assert!(deviation >= height && deviation < 1.6 * height + 1e-9, "{deviation} {height}");
    }
    assert!(compare(&run).0.iter().all(|w| *w <= 1.0));
}
