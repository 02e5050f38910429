//! Distance of two meshes of 10,000 and 100,000 triangles, near and far, asked for again at places next to
//! each other; and what the query library takes for the same.
#![allow(missing_docs, clippy::print_stdout, reason = "the macros make items without documentation; a bench prints")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use parry3d_f64::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d_f64::shape::TriMesh as ParryMesh;
use proveout_collision::SolidPair;
use proveout_geom::{Point, Pose, TriMesh};

/// Torus of radii 40 and 15 mm.
fn torus(triangles: usize) -> TriMesh {
    let around = ((triangles / 4) as f64).sqrt() as usize;
    let along = triangles / (2 * around);
    let at = |i: usize, k: usize| {
        let (s, c) = (std::f64::consts::TAU * i as f64 / along as f64).sin_cos();
        let (t, d) = (std::f64::consts::TAU * k as f64 / around as f64).sin_cos();
        Point::new((40.0 + 15.0 * d) * c, (40.0 + 15.0 * d) * s, 15.0 * t)
    };
    let number = |i: usize, k: usize| ((i % along) * around + k % around) as u32;
    let quad = |(i, k): (usize, usize)| {
        let [a, b, c, d] = [number(i, k), number(i + 1, k), number(i + 1, k + 1), number(i, k + 1)];
        [[a, b, c], [a, c, d]]
    };
    let places = || (0..along).flat_map(move |i| (0..around).map(move |k| (i, k)));
    TriMesh { positions: places().map(|(i, k)| at(i, k)).collect(), triangles: places().flat_map(quad).collect() }
}

/// Poses along a way past the other; `gap` over it, mm.
fn poses(gap: f64) -> Vec<Pose> {
    let at = |k: i32| {
        let a = 0.01 * f64::from(k);
        Pose::from_rpy(Vector3::new(3.0 * a, 20.0 * a, 30.0 + gap), 0.02 * a.sin(), 0.03 * a.cos(), a)
    };
    (0..100).map(at).collect()
}

fn meshes(c: &mut Criterion) {
    for triangles in [10_000, 100_000] {
        let mesh = torus(triangles);
        let pair = SolidPair::new(&mesh, &mesh).expect("solids");
        let vertices = mesh.positions.iter().map(|p| ParryVector::new(p.x, p.y, p.z)).collect();
        let parry = ParryMesh::new(vertices, mesh.triangles.clone()).expect("mesh");
        for gap in [0.1, 20.0] {
            let poses = poses(gap);
            let mut group = c.benchmark_group(format!("{triangles} triangles, {gap} mm"));
            group.sample_size(10);
            group.bench_function("ours", |bench| {
                bench.iter(|| {
                    let mut warm = pair.clone();
                    poses.iter().map(|p| black_box(warm.distance(p))).sum::<f64>()
                });
            });
            group.bench_function("library, one of the poses", |bench| {
                let pose: ParryPose = poses[50].to_isometry().into();
                bench.iter(|| black_box(parry3d_f64::query::distance(&ParryPose::IDENTITY, &parry, &pose, &parry)));
            });
            group.finish();
        }
    }
}

criterion_group!(benches, meshes);
criterion_main!(benches);
