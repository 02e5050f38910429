//! The drives with their lag: inner steps a second of one joint, loads by Newton-Euler, and whole runs
//! with the drives on against the time of the simulated machine, on one core.
//!
//! Times are those of the thread on the processor where the system gives them (Linux), so that other work on
//! the machine does not count.

use std::{
    convert::Infallible,
    hint::black_box,
    path::Path,
    time::{Duration, Instant},
};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use proveout_controller::{
    Controller, Dynamics, Settings,
    dynamics::RigidTree,
    servo::{DriveModel, Plant, SetPointRates},
};
use proveout_machine::{JointValues, Machine};
use proveout_nc::Command;
use proveout_tool::Tool;

#[path = "../tests/common/mod.rs"]
mod common;

/// Time that this thread has spent on a processor, ns; none where the system does not say.
fn processor_ns() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok()
}

/// Time of `n` calls.
fn timed<T>(n: u64, mut work: impl FnMut() -> T) -> Duration {
    let (begin, wall) = (processor_ns(), Instant::now());
    for _ in 0..n {
        black_box(work());
    }
    match (begin, processor_ns()) {
        (Some(a), Some(b)) => Duration::from_nanos(b - a),
        _ => wall.elapsed(),
    }
}

fn library() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/spinner-u5-620");
    Machine::read(&folder).expect("the library machine")
}

/// Flank cut on a swinging circle in short five-axis blocks.
fn five_axis(blocks: u32) -> common::Program {
    let mut p = common::Program::default().change(1).g0(&[('X', 0.0), ('Y', 0.0)]).g0(&[('Z', 420.0), ('B', 0.5)]);
    p = p.tcp(true).continuous(0.01).feed(40.0);
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

fn execute(commands: &[Command], machine: &Machine, tools: &[Tool], settings: &Settings) -> f64 {
    let source = commands.iter().cloned().map(Ok::<_, Infallible>);
    let mut controller = Controller::new(source, machine, tools, settings.clone()).expect("good settings");
    while let Some(chunk) = controller.next_chunk().expect("a good program") {
        black_box(&chunk);
    }
    controller.summary().total_s
}

fn servo(c: &mut Criterion) {
    let machine = library();
    let cycle = machine.control.cycle_time;
    let mut group = c.benchmark_group("servo");
    group.sample_size(10);
    let stiff = machine.joint("C").expect("C");
    let elastic = machine.joint("X").expect("X");
    for (name, joint, load) in
        [("stiff with Stribeck friction", stiff, 4e6), ("elastic with Stribeck friction", elastic, 600.0)]
    {
        let drive = machine.joints[joint].drive.as_ref().expect("a drive");
        let model = DriveModel::new(drive, load, cycle).expect("a good drive");
        let cycles = 1000;
        group.throughput(Throughput::Elements(cycles * model.inner_steps() as u64));
        group.bench_function(format!("joint-steps, {name}"), |b| {
            let mut state = model.rest(0.0);
            let mut k = 0_u32;
            b.iter_custom(|n| {
                timed(n, || {
                    for _ in 0..cycles {
                        k = k.wrapping_add(1);
                        let v = 10.0 * (f64::from(k % 1000) * 0.006_283).sin();
                        model.cycle(
                            &mut state,
                            SetPointRates { velocity: v, acceleration: 0.0, jerk: 0.0 },
                            black_box(3.0),
                        );
                    }
                    state
                })
            });
        });
    }
    group.throughput(Throughput::Elements(1));
    let tree = RigidTree::new(&machine);
    let (q, v, a) = (machine.home(), JointValues([1.0; 8]), JointValues([10.0; 8]));
    group.bench_function("loads of five joints by Newton-Euler", |b| {
        b.iter_custom(|n| timed(n, || tree.inverse_dynamics(black_box(&q), &v, &a)))
    });

    const BLOCKS: u32 = 4000;
    let tools = [common::tool(1, 120.0)];
    let program = five_axis(BLOCKS);
    for (name, dynamics) in [("planned", Dynamics::Planned), ("servo", Dynamics::Servo)] {
        let settings = Settings { dynamics, plant: Plant::NewtonEuler, ..Settings::default() };
        let seconds = execute(&program.commands, &machine, &tools, &settings);
        group.throughput(Throughput::Elements(seconds as u64)); // "elements" are seconds of the machine
        group.bench_function(format!("plan with {name}, {seconds:.1} s of the machine"), |b| {
            b.iter_custom(|n| timed(n, || execute(black_box(&program.commands), &machine, &tools, &settings)));
        });
    }
    group.finish();
}

criterion_group!(benches, servo);
criterion_main!(benches);
