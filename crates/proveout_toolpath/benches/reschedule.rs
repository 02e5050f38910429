//! Time of the re-scheduling methods over the number of blocks: growth should be close to linear.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use proveout_geom::Vector;
use proveout_geom::blade::{Blade, BladeSpec, CamberSection};
use proveout_tool::Cutter;
use proveout_toolpath::HelicalPass;
use proveout_toolpath::reschedule::{CuttingBlock, CuttingRun, Method, Quaternion, STheta, Surroundings};

fn run(blocks: usize) -> Option<CuttingRun> {
    let turns = blocks as f64 * 0.5 / 185.26;
    let spec = BladeSpec { section: CamberSection::stand_in(), length: 400.0, twist: 0.001, platform: None };
    let pass = HelicalPass {
        ball_radius: 8.0,
        allowance: 0.0,
        head_tilt: 0.087,
        lead: 0.26,
        from_x: 12.0,
        to_x: 12.0 + turns,
        pitch: 1.0,
        step: 0.5,
        start: 0.3,
    };
    let points = pass.points(&Blade::new(spec).ok()?).ok()?;
    Some(CuttingRun {
        blocks: points.iter().zip(1..).map(|(p, line)| CuttingBlock { pose: p.pose, line, time: None }).collect(),
    })
}

fn methods(c: &mut Criterion) {
    let bodies = Cutter::ball(16.0).and_then(|ball| ball.bodies(40.0));
    let Ok([cutter, ..]) = bodies.as_deref() else { return };
    let around = Surroundings::new(cutter, Vector::x());
    let mut group = c.benchmark_group("reschedule");
    group.sample_size(20);
    for blocks in [10_000, 100_000] {
        let Some(path) = run(blocks) else { continue };
        group.throughput(Throughput::Elements(path.blocks.len() as u64));
        let methods: [&dyn Method; 2] = [&STheta::default(), &Quaternion::default()];
        for method in methods {
            group.bench_with_input(BenchmarkId::new(method.name(), blocks), &path, |b, path| {
                b.iter(|| method.reschedule(path, &around).map(|r| r.poses.len()));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, methods);
criterion_main!(benches);
