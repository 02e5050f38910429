//! Forward and inverse kinematics of the library's five-axis machine, per call.
#![allow(missing_docs, reason = "criterion's macros make public items")]

use std::{hint::black_box, path::Path};

use criterion::{Criterion, criterion_group, criterion_main};
use proveout_machine::{ConstantErrors, ErrorOf, JointValues, Machine, MotionState};

fn kinematics(c: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/spinner-u5-620");
    let machine = match Machine::read(&folder) {
        Ok(machine) => machine,
        Err(e) => panic!("{e}"),
    };
    let mut q = JointValues::ZERO;
    q.0[..5].copy_from_slice(&[12.0, -34.0, 250.0, 0.6, 2.1]);
    let pose = machine.forward(&q, 100.0);
    c.bench_function("forward", |b| b.iter(|| machine.forward(black_box(&q), black_box(100.0))));
    c.bench_function("inverse, all branches", |b| b.iter(|| machine.inverse(black_box(&pose), black_box(100.0))));
    c.bench_function("inverse_nearest", |b| {
        b.iter(|| machine.inverse_nearest(black_box(&pose), black_box(100.0), black_box(&q)))
    });
    c.bench_function("inverse_with_rotary", |b| {
        b.iter(|| machine.inverse_with_rotary(black_box(&pose.tip), black_box(&q), black_box(100.0)))
    });
    c.bench_function("jacobian", |b| b.iter(|| machine.jacobian(black_box(&q), black_box(100.0))));
    let state = MotionState { q, ..MotionState::default() };
    c.bench_function("limit_violations", |b| b.iter(|| machine.limit_violations(black_box(&state), 0.001)));
    let mut actual = machine.clone();
    actual.errors.constant = vec![ConstantErrors { of: ErrorOf::Joint(4), components: [1e-3; 6] }];
    let actual = actual.recompiled();
    c.bench_function("actual_forward", |b| b.iter(|| actual.actual_forward(black_box(&q), black_box(100.0))));
    c.bench_function("actual_inverse_nearest", |b| {
        b.iter(|| actual.actual_inverse_nearest(black_box(&pose), black_box(100.0), black_box(&q)))
    });
    c.bench_function("joint_poses", |b| b.iter(|| machine.joint_poses(black_box(&q))));
}

criterion_group!(benches, kinematics);
criterion_main!(benches);
