//! Blocks planned a second: short five-axis blocks with tool center point control, and short three-axis
//! blocks.

use std::{convert::Infallible, hint::black_box};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use proveout_controller::{Controller, Settings};
use proveout_machine::Machine;
use proveout_nc::Command;
use proveout_tool::Tool;

#[path = "../tests/common/mod.rs"]
mod common;

fn five_axis(blocks: u32) -> common::Program {
    let mut p = common::Program::default().change(1).g0(&[('Z', 300.0), ('B', 0.5)]).tcp(true).continuous(0.01);
    p = p.feed(40.0);
    for k in 0..blocks {
        let a = f64::from(k) * 0.01;
        let point = [
            ('X', 40.0 * a.cos()),
            ('Y', 40.0 * a.sin()),
            ('Z', 150.0 + 5.0 * (3.0 * a).sin()),
            ('B', 0.4 + 0.1 * a.cos()),
            ('C', 0.5 * a),
        ];
        p = p.g1(&point);
    }
    p
}

fn three_axis(blocks: u32) -> common::Program {
    let mut p = common::Program::default().continuous(0.01).feed(60.0);
    for k in 0..blocks {
        let a = f64::from(k) * 0.01;
        p = p.g1(&[('X', 40.0 * a.cos()), ('Y', 40.0 * a.sin()), ('Z', 5.0 * (3.0 * a).sin())]);
    }
    p
}

fn execute(commands: &[Command], machine: &Machine, tools: &[Tool]) -> f64 {
    let source = commands.iter().cloned().map(Ok::<_, Infallible>);
    let mut controller = Controller::new(source, machine, tools, Settings::default()).expect("good settings");
    while let Some(chunk) = controller.next_chunk().expect("a good program") {
        black_box(&chunk);
    }
    controller.summary().total_s
}

fn plan(c: &mut Criterion) {
    const BLOCKS: u32 = 20_000;
    let machine = common::bc_machine();
    let tools = [common::tool(1, 120.0)];
    let mut group = c.benchmark_group("plan");
    group.sample_size(10).throughput(Throughput::Elements(u64::from(BLOCKS)));
    for (name, program) in [("five_axis_tcp", five_axis(BLOCKS)), ("three_axis", three_axis(BLOCKS))] {
        let seconds = execute(&program.commands, &machine, &tools);
        group.bench_function(format!("{name} ({seconds:.1} s of machine time)"), |b| {
            b.iter(|| execute(black_box(&program.commands), &machine, &tools));
        });
    }
    group.finish();
}

criterion_group!(benches, plan);
criterion_main!(benches);
