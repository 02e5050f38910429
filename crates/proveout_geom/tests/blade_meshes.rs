//! Meshes of every kind: closed, and within the chord error that was asked, at random points against the closed form.

use std::sync::Arc;

use proveout_geom::blade::{
    Backing, BladeEnd, BladeSolid, ClosedSurface, Cui, Dong, Lu, MeasuredMesh, ParametricSurface, Plate, Sine,
    face_mesh,
};
use proveout_geom::{Point, TriMesh};

/// Numbers from 0 to 1, the same in every run (Steele, Lea & Flood 2014, splitmix64).
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ z >> 31) as f64 / u64::MAX as f64
    }
}

/// A random point of a random triangle.
fn random_point(mesh: &TriMesh, draw: &mut Draw) -> Point {
    let triangle = (draw.next() * mesh.triangles.len() as f64) as usize % mesh.triangles.len();
    let [a, b, c] = mesh.corners(triangle);
    let (mut s, mut t) = (draw.next(), draw.next());
    if s + t > 1.0 {
        (s, t) = (1.0 - s, 1.0 - t);
    }
    a + (b - a) * s + (c - a) * t
}

fn checked(name: &str, made: &MeasuredMesh, error: f64) {
    made.mesh.check_solid().unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(made.measured <= error && made.measured > 0.02 * error, "{name}: {}", made.measured);
}

fn plate(fillet_radius: f64, side: f64) -> Plate {
    Plate { fillet_radius, thickness: 8.0, y: [-side, side], z: [-side, side] }
}

/// Random points of each mesh: 1,000, or as many as the environment variable PROVEOUT_BLADE_POINTS says.
fn points() -> u32 {
    std::env::var("PROVEOUT_BLADE_POINTS").map_or(1_000, |text| text.parse().expect("a count of points"))
}

#[test]
fn blades_with_platforms_at_both_ends_are_met_within_the_chord_error() {
    let count = points();
    let on = |x, radius, side| BladeEnd { x, plate: Some(plate(radius, side)) };
    let cut = |x| BladeEnd { x, plate: None };
    let kinds: Vec<(&str, Arc<dyn ParametricSurface>, [BladeEnd; 2], f64)> = vec![
        ("lu", Arc::new(ClosedSurface::new(Lu::stand_in())), [on(1.0, 3.0, 30.0), on(98.0, 1.5, 30.0)], 0.0),
        ("lu cut", Arc::new(ClosedSurface::new(Lu::stand_in())), [cut(0.0), cut(100.0)], 0.0),
        ("lu with allowance", Arc::new(ClosedSurface::new(Lu::stand_in())), [on(1.0, 3.0, 30.0), cut(98.0)], 0.4),
    ];
    for (name, surface, ends, allowance) in kinds {
        let error = 0.01;
        let solid = BladeSolid::new(surface.clone(), ends, allowance).expect(name);
        let made = solid.mesh(error).expect(name);
        checked(name, &made, error);
        let (mut draw, mut worst) = (Draw(23), 0.0_f64);
        for _ in 0..count {
            let p = random_point(&made.mesh, &mut draw);
            worst = worst.max(solid.nearest(&p).distance.abs());
        }
        // What was measured is what any point keeps; a third of it is met somewhere, so that nothing was measured in vain.
        assert!(worst <= made.measured + 1e-6 && worst > 0.3 * made.measured, "{name}: {worst} of {}", made.measured);
    }
}

#[test]
fn faces_with_rims_are_met_within_the_chord_error() {
    let kinds: Vec<(&str, Box<dyn ParametricSurface>, Backing)> = vec![
        ("sine", Box::new(ClosedSurface::new(Sine::published_ratio())), Backing::Plane { z: -5.0 }),
        ("gentle sine", Box::new(ClosedSurface::new(Sine::gentle())), Backing::Plane { z: -5.0 }),
        ("dong", Box::new(ClosedSurface::new(Dong::stand_in())), Backing::Plane { z: -5.0 }),
        ("cui", Box::new(ClosedSurface::new(Cui::stand_in())), Backing::Behind { depth: 8.0 }),
    ];
    for (name, surface, backing) in kinds {
        for error in [0.01, 0.001] {
            let made = face_mesh(surface.as_ref(), backing, 0.0, error).expect(name);
            checked(name, &made, error);
            let faces = made.mesh.triangles.len();
            let (mut draw, mut worst) = (Draw(29), 0.0_f64);
            let half = (made.mesh.positions.len() / 2) as u32;
            let face = TriMesh {
                positions: made.mesh.positions.clone(),
                triangles: made.mesh.triangles.iter().filter(|t| t.iter().all(|i| *i < half)).copied().collect(),
            };
            assert!(face.triangles.len() * 2 < faces);
            for _ in 0..10 * points() {
                let p = random_point(&face, &mut draw);
                let [u, v] = surface.nearest(&p);
                worst = worst.max((surface.local(u, v).point - p).norm());
            }
            assert!(worst <= error, "{name}: {worst}");
        }
    }
}
