//! Time of the re-scheduling methods over the number of blocks: growth should be close to linear.

use std::path::Path;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use proveout_blade::{Blade, BladeSpec, CamberSection};
use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::Machine;
use proveout_path::HelicalPass;
use proveout_reschedule::{
    AxisTurn, ContactPoint, ContactSurface, CuttingBlock, CuttingRun, FeasibleRegion, Method, Quaternion, STheta,
    Smooth, SmoothRows, Surroundings,
};
use proveout_tool::Cutter;

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
    let block = |(p, line): (&proveout_path::PassPoint, u32)| CuttingBlock {
        pose: p.pose,
        line,
        time: (line > 1).then_some(0.03),
    };
    Some(CuttingRun { blocks: points.iter().zip(1..).map(block).collect() })
}

/// A row along x of half a millimeter a block whose axis waves to and fro.
fn row(blocks: usize) -> CuttingRun {
    let block = |i: usize| {
        let about = 0.7 + 0.8 * (i as f64 * 0.008).sin();
        let axis = Vector::new(0.35 * about.cos(), 0.35 * about.sin(), 1.0).normalize();
        let pose = ToolPose { tip: Point::new(0.5 * i as f64, 0.0, 8.0) - axis * 8.0, axis };
        CuttingBlock { pose, line: i as u32 + 1, time: (i > 0).then_some(0.025) }
    };
    CuttingRun { blocks: (0..blocks).map(block).collect() }
}

/// Maps of what is free are timed elsewhere (`orientation` of `proveout_collision`): here everything is.
struct Open;

impl FeasibleRegion for Open {
    fn clearance(&self, _: &ToolPose) -> f64 {
        1.0
    }

    fn free_turns(&self, _: &AxisTurn) -> Option<Vec<[f64; 2]>> {
        Some(vec![[-std::f64::consts::PI, std::f64::consts::PI]])
    }
}

impl ContactSurface for Open {
    fn contact(&self, near: &Point) -> Option<ContactPoint> {
        let point = Point::new(near.x, near.y, 0.0);
        Some(ContactPoint { point, normal: Vector::z(), curvatures: [(0.0, Vector::x()), (0.0, Vector::y())] })
    }
}

fn methods(c: &mut Criterion) {
    let bodies = Cutter::ball(16.0).and_then(|ball| ball.bodies(40.0));
    let Ok([cutter, ..]) = bodies.as_deref() else { return };
    let around = Surroundings::new(cutter, Vector::x());
    let table = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/jdgr200t")).ok();
    let on_table = Surroundings {
        machine: table.as_ref(),
        region: Some(&Open),
        surface: Some(&Open),
        ..Surroundings::new(cutter, Vector::z())
    };
    let mut group = c.benchmark_group("reschedule");
    group.sample_size(10);
    for blocks in [10_000, 100_000] {
        let Some(path) = run(blocks) else { continue };
        group.throughput(Throughput::Elements(path.blocks.len() as u64));
        let methods: [&dyn Method; 3] = [&STheta::default(), &Quaternion::default(), &Smooth::default()];
        for method in methods {
            group.bench_with_input(BenchmarkId::new(method.name(), blocks), &path, |b, path| {
                b.iter(|| method.reschedule(path, &around).map(|r| r.poses.len()));
            });
        }
        let path = row(blocks);
        group.bench_with_input(BenchmarkId::new("smooth of rows", blocks), &path, |b, path| {
            b.iter(|| SmoothRows::default().reschedule(path, &on_table).map(|r| r.poses.len()));
        });
    }
    group.finish();
}

criterion_group!(benches, methods);
criterion_main!(benches);
