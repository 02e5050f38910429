//! The gain of a re-scheduled path does not depend on the cycle of the control or on the sampling.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::path::Path;

use crate::common::{Program, motion, run_with, tool};
use proveout_blade::{Blade, BladeSpec, CamberSection};
use proveout_controller::Settings;
use proveout_geom::{ToolPose, Vector};
use proveout_machine::Machine;
use proveout_nc::{Feed, Op};
use proveout_path::HelicalPass;
use proveout_reschedule::{CuttingBlock, CuttingRun, Method, STheta, Surroundings};
use proveout_tool::Cutter;

/// Original and re-scheduled poses of a pass round the substitute blade of the s-theta specification, and the
/// way of the ball center to each block.
fn passes() -> (Vec<ToolPose>, Vec<ToolPose>, Vec<f64>) {
    let spec = BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist: 0.0, platform: None };
    let blade = Blade::new(spec).expect("a blade");
    let pass = HelicalPass {
        ball_radius: 8.0,
        allowance: 0.0,
        head_tilt: 5.0_f64.to_radians(),
        lead: 15.0_f64.to_radians(),
        from_x: 12.0,
        to_x: 14.0,
        pitch: 1.0,
        step: 0.5,
        start: 0.3,
    };
    let points = pass.points(&blade).expect("a pass");
    let blocks = points.iter().zip(1..).map(|(p, line)| CuttingBlock { pose: p.pose, line, time: None }).collect();
    let run = CuttingRun { blocks };
    let cutter = Cutter::ball(16.0).expect("a ball").bodies(40.0).expect("bodies").remove(0);
    let around = Surroundings::new(&cutter, Vector::x());
    let after = STheta::default().reschedule(&run, &around).expect("a solution").poses;
    let ways = points.windows(2).map(|p| (p[1].center - p[0].center).norm()).collect();
    (points.iter().map(|p| p.pose).collect(), after, ways)
}

fn program(poses: &[ToolPose], ways: &[f64], feed: f64) -> Program {
    let place = |p: &ToolPose| {
        let mut m = motion(&[('X', p.tip.x + 260.0), ('Y', p.tip.y), ('Z', p.tip.z)]);
        m.tool_axis = Some(p.axis.into());
        m.tool_axis_base = m.tool_axis;
        m
    };
    let mut out = Program::default().change(1).tcp(true).continuous(0.01).op(Op::Rapid(place(&poses[0]))).exact_stop();
    out = out.feed(feed).op(Op::Linear(place(&poses[0]))).continuous(0.01);
    for (pose, way) in poses[1..].iter().zip(ways) {
        out = out.op(Op::Feed(Feed::InverseTime(way / feed))).op(Op::Linear(place(pose)));
    }
    out
}

fn machine(cycle: f64) -> Machine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/starrag-lx-451");
    let mut machine = Machine::read(&path).expect("the machine of the library");
    let a = machine.joint("A").expect("the A axis");
    // Tightened, so that the A axis rules: the paper's case.
    machine.joints[a].max_velocity = Some(90.0_f64.to_radians());
    machine.joints[a].max_acceleration = Some(300.0_f64.to_radians());
    machine.joints[a].max_jerk = Some(6000.0_f64.to_radians());
    machine.control.cycle_time = cycle;
    machine
}

#[test]
fn halving_the_cycle_or_the_sampling_leaves_the_gain() {
    let (before, after, ways) = passes();
    let feed = 3000.0 / 60.0;
    let gain = |cycle: f64, sampling: Option<f64>| {
        let machine = machine(cycle);
        let settings = Settings { sample_time: sampling, ..Settings::default() };
        let time = |poses: &[ToolPose]| {
            let run = run_with(&program(poses, &ways, feed), &machine, &[tool(1, 150.0)], &settings);
            run.summary.cutting_s
        };
        let (original, new) = (time(&before), time(&after));
        println!("cycle {cycle}, sampling {sampling:?}: original {original:.6} s, re-scheduled {new:.6} s");
        original - new
    };
    let coarse = gain(0.002, None);
    // A difference that is not there would be stable in any case.
    assert!(coarse.abs() > 0.05, "{coarse}");
    for (cycle, sampling) in [(0.001, None), (0.002, Some(0.001)), (0.001, Some(0.0005))] {
        let fine = gain(cycle, sampling);
        println!("gain {coarse:.6} s and {fine:.6} s: {:.5} percent", 100.0 * (fine - coarse) / coarse);
        assert!((fine - coarse).abs() < 0.01 * coarse.abs(), "{coarse} {fine}");
    }
}
