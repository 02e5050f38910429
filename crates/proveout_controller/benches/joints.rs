//! Blocks planned a second where the joints rule the time, not the feed: a five-axis raster over waves whose
//! flanks turn the tool axis by up to 3.8 degrees in a block of 0.5 mm.
//!
//! The first line of each row says what is planned, with the processor's instructions to be counted from
//! outside (`perf stat -e instructions:u`). `JOINTS_BLOCKS` gives another number of blocks than 6,000; 61,759
//! are a whole blade.

#![expect(clippy::print_stdout, reason = "figures for people who read the output")]

use std::{convert::Infallible, hint::black_box, path::Path, time::Instant};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use proveout_controller::{Controller, Settings, Summary};
use proveout_machine::Machine;
use proveout_nc::Command;
use proveout_tool::Tool;

#[path = "../tests/common/mod.rs"]
mod common;

/// Way of the tip in a block, mm, and length of a pass.
const STEP: f64 = 0.5;
const PASS: f64 = 40.0;
/// Length of a wave, mm, and its steepest tilt: 2 pi A / L is 7.6 degrees a mm, 3.8 degrees a block.
const WAVE: f64 = 20.0;
const STEEPEST_DEG: f64 = 24.2;

/// Tip and tool axis along the raster. Each pass has its own phase and height of the waves, so that no two
/// are alike, and leans the tool across by some degrees, which makes the second rotary axis follow.
fn raster(blocks: usize) -> Vec<([f64; 3], [f64; 3])> {
    let a_pass = (PASS / STEP) as usize;
    (0..=blocks)
        .map(|k| {
            let (pass, i) = (k / (a_pass + 1), k % (a_pass + 1));
            let forth = pass.is_multiple_of(2);
            let x = STEP * if forth { i as f64 } else { (a_pass - i) as f64 } - 0.5 * PASS;
            let row = pass as f64;
            let height = 0.6 + 0.4 * (1.7 * row).sin();
            let phase = 0.9 * row;
            let tilt = height * STEEPEST_DEG.to_radians() * (std::f64::consts::TAU * x / WAVE + phase).sin();
            let lean = (12.0 + 6.0 * (0.31 * row).sin() + 4.0 * (x / 9.0 + row).sin()).to_radians();
            let axis = [tilt.sin() * lean.cos(), lean.sin(), tilt.cos() * lean.cos()];
            let z = -height * STEEPEST_DEG.to_radians() * WAVE / std::f64::consts::TAU
                * (std::f64::consts::TAU * x / WAVE + phase).cos();
            ([x, 0.5 * row - 100.0, z], axis)
        })
        .collect()
}

/// The raster with the rotary axes of a machine: `Rz(C) Ry(B)` or `Rx(A) Ry(B)` times the upright tool gives
/// the axis.
fn program(letter: char, blocks: usize, origin: [f64; 3]) -> common::Program {
    let points = raster(blocks);
    let mut program = common::Program::default().change(1).continuous(0.01).feed(80.0);
    let mut last = 0.0;
    for (k, (tip, n)) in points.iter().enumerate() {
        let (b, second) = if letter == 'C' {
            (n[2].acos(), proveout_geom::wrap_near(n[1].atan2(n[0]), last))
        } else {
            // Rx(A) Ry(B) z = (sin B, -cos B sin A, cos B cos A).
            (n[0].asin(), proveout_geom::wrap_near((-n[1]).atan2(n[2]), last))
        };
        last = second;
        let p = [tip[0] + origin[0], tip[1] + origin[1], tip[2] + origin[2]];
        let values = [('X', p[0]), ('Y', p[1]), ('Z', p[2]), ('B', b), (letter, second)];
        if k == 0 {
            program = program.g0(&[('Z', 400.0)]).tcp(true).g0(&values);
        } else {
            program = program.g1(&values);
        }
    }
    program
}

fn execute(commands: &[Command], machine: &Machine, tools: &[Tool]) -> (Summary, [usize; 2]) {
    let source = commands.iter().cloned().map(Ok::<_, Infallible>);
    let mut controller = Controller::new(source, machine, tools, Settings::default()).expect("good settings");
    let mut count = [0; 2];
    while let Some(chunk) = controller.next_chunk().expect("a good program") {
        count[0] += chunk.pieces.len();
        count[1] += chunk.samples.len();
        black_box(&chunk);
    }
    (controller.summary(), count)
}

fn joints(c: &mut Criterion) {
    let blocks = std::env::var("JOINTS_BLOCKS").ok().and_then(|v| v.parse().ok()).unwrap_or(6_000);
    let library = |name: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name);
        Machine::read(&folder).expect("a machine of the library")
    };
    let rows = [
        ("starrag-lx-451", library("starrag-lx-451"), 'A', [260.0, 100.0, 60.0]),
        ("bc-trunnion", library("bc-trunnion"), 'C', [0.0, 0.0, 150.0]),
    ];
    let tools = [common::tool(1, 120.0)];
    let mut group = c.benchmark_group("joints");
    group.sample_size(10).throughput(Throughput::Elements(blocks as u64));
    for (name, machine, letter, origin) in rows {
        let program = program(letter, blocks, origin);
        let begin = Instant::now();
        let (summary, [pieces, samples]) = execute(&program.commands, &machine, &tools);
        let took = begin.elapsed().as_secs_f64();
        println!(
            "{name}: {blocks} blocks in {took:.2} s, {:.0} a second; machine {:.3} s, bound of the path {:.3} s, {samples} samples, {pieces} pieces, \
             deviation {:.6} mm",
            blocks as f64 / took,
            summary.total_s,
            summary.path_bound_s.unwrap_or(f64::NAN),
            summary.max_chord_error_mm,
        );
        group.bench_function(name, |b| b.iter(|| execute(black_box(&program.commands), &machine, &tools)));
    }
    group.finish();
}

criterion_group!(benches, joints);
criterion_main!(benches);
