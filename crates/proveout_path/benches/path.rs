//! Contacts a second, planned with their axes: lines of a blade by chord error, on one core.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use proveout_blade::{ClosedSurface, Lu};
use proveout_geom::rad;
use proveout_path::{
    AxisRule, IsoParametric, Label, PathCutter, QuasiCircle, Spacing, StepRule, Strategy, Task, Transverse,
};
use proveout_tool::Cutter;

fn paths(c: &mut Criterion) {
    let lu = ClosedSurface::new(Lu::stand_in());
    let cutters = [("ball", Cutter::ball(6.0)), ("bull-nose", Cutter::bull_nose(6.0, 1.0))];
    let rule = AxisRule::LeadTilt { lead: rad(15.0), tilt: rad(5.0) };
    let labels = |from: f64, to: f64| (0..40).map(|k| from + (to - from) * f64::from(k) / 39.0).collect::<Vec<f64>>();
    let strategies: [(&str, Box<dyn Strategy>); 3] = [
        (
            "quasi-circle",
            Box::new(QuasiCircle {
                focus_inside: 0.0,
                trailing: 0.0,
                range: [0.0, 1.0],
                along: [0.0, 1.0],
                spacing: Spacing::At(labels(rad(20.0), rad(160.0))),
            }),
        ),
        (
            "iso-parametric",
            Box::new(IsoParametric {
                label: Label::Length,
                range: [0.0, 1.0],
                along: [0.0, 1.0],
                spacing: Spacing::At(labels(0.02, 0.48)),
            }),
        ),
        (
            "transverse",
            Box::new(Transverse {
                round: [0.02, 0.48],
                range: [0.0, 1.0],
                spacing: Spacing::At(labels(0.05, 0.95)),
                one_way: false,
            }),
        ),
    ];
    let mut group = c.benchmark_group("path");
    group.sample_size(10);
    for (name, cutter) in cutters {
        let Ok(Some(flutes)) = cutter.and_then(|c| Ok(c.bodies(20.0)?.into_iter().next())) else { continue };
        let cutter = PathCutter::new(flutes);
        // Short steps, so that a line has some hundred contacts as in a finishing program.
        let step = StepRule::Chord { error: 1e-4, longest: 0.25 };
        let task = Task { surface: &lu, cutter: &cutter, rule: &rule, step, allowance: 0.0 };
        for (label, strategy) in &strategies {
            let Ok(lines) = task.plan(strategy.as_ref()) else { continue };
            let contacts: usize = lines.iter().map(|l| l.contacts.len()).sum();
            group.throughput(Throughput::Elements(contacts as u64));
            group.bench_function(format!("{name} {label} {contacts} contacts"), |b| {
                b.iter(|| black_box(task.plan(strategy.as_ref()).map(|l| l.len())));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, paths);
criterion_main!(benches);
