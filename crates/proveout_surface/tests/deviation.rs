//! Signed distances against closed forms and against a slow oracle that shares no code: all triangles one by
//! one, and the winding number for the sign.

use std::f64::consts::{PI, TAU};

use proptest::prelude::*;
use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, box_mesh, revolved_mesh};
use proveout_surface::{
    ConeFlank, ConeFrustum, DesignError, DesignMesh, DesignSurface, DeviationSettings, HalfSpaceDesign, Sphere,
    SurfacePoint, measure,
};

fn cube() -> Aabb {
    Aabb { min: Point::new(-10.0, -5.0, 0.0), max: Point::new(10.0, 5.0, 8.0) }
}

/// Signed distance of a box in closed form.
fn box_distance(b: &Aabb, p: &Point) -> f64 {
    let d: Vec<f64> = (0..3).map(|i| (b.min[i] - p[i]).max(p[i] - b.max[i])).collect();
    let outside = d.iter().map(|v| v.max(0.0).powi(2)).sum::<f64>().sqrt();
    let inside = d.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0);
    outside + inside
}

fn sphere_mesh(radius: f64, rings: usize, sectors: usize) -> TriMesh {
    let profile: Vec<[f64; 2]> = (0..=rings)
        .map(|i| {
            let a = PI * i as f64 / rings as f64;
            let r = if i == 0 || i == rings { 0.0 } else { radius * a.sin() };
            [r, -radius * a.cos()]
        })
        .collect();
    revolved_mesh(&profile, sectors)
}

/// Distance by projecting on every triangle: minimum over a fine search of the face plane and the three
/// edges.
fn slow_distance(mesh: &TriMesh, p: &Point) -> f64 {
    let mut best = f64::INFINITY;
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        for (u, v) in [(a, b), (b, c), (c, a)] {
            let d = v - u;
            let s = ((p - u).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
            best = best.min((p - (u + d * s)).norm());
        }
        let n = (b - a).cross(&(c - a)).normalize();
        let foot = p - n * (p - a).dot(&n);
        let inside = [(a, b), (b, c), (c, a)].iter().all(|(u, v)| (v - u).cross(&(foot - u)).dot(&n) >= 0.0);
        if inside {
            best = best.min((p - foot).norm());
        }
    }
    best
}

/// Sum of the signed solid angles of all triangles over the full sphere (van Oosterom and Strackee 1983).
fn winding_number(mesh: &TriMesh, p: &Point) -> f64 {
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t).map(|q| q - p);
            let (x, y, z) = (a.norm(), b.norm(), c.norm());
            let numerator = a.dot(&b.cross(&c));
            let denominator = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
            2.0 * numerator.atan2(denominator)
        })
        .sum::<f64>()
        / (2.0 * TAU)
}

#[test]
fn a_box_mesh_has_the_distances_of_the_box() {
    let design = DesignMesh::new(&box_mesh(&cube())).expect("solid");
    for i in 0..4000 {
        let f = |k: f64| (f64::from(i) * k).fract() * 2.0 - 1.0;
        let p = Point::new(16.0 * f(0.618_033), 9.0 * f(0.414_213), 4.0 + 9.0 * f(0.732_050));
        let d = design.signed_distance(&p).expect("answers");
        assert!((d - box_distance(&cube(), &p)).abs() < 1e-12, "{p}: {d}");
    }
}

#[test]
fn a_sphere_mesh_lies_within_its_chord_error() {
    let (radius, rings, sectors) = (20.0, 60, 120);
    let design = DesignMesh::new(&sphere_mesh(radius, rings, sectors)).expect("solid");
    // The farthest that a facet lies inside: both half steps, of latitude and of longitude.
    let chord = radius * (1.0 - (PI / (2 * rings) as f64).cos() * (PI / sectors as f64).cos());
    let exact = Sphere { center: Point::origin(), radius };
    for i in 0..3000 {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 3000.0;
        let a = f64::from(i) * 2.399_963;
        let direction = Vector::new((1.0 - z * z).sqrt() * a.cos(), (1.0 - z * z).sqrt() * a.sin(), z);
        for r in [18.0, 19.9, 20.0, 20.1, 25.0] {
            let p = Point::from(direction * r);
            let d = design.signed_distance(&p).expect("answers");
            let truth = exact.signed_distance(&p).expect("answers");
            assert!(d >= truth - 1e-9 && d <= truth + chord + 1e-9, "r {r}: {d} against {truth}, chord {chord}");
        }
    }
}

#[test]
fn a_hollow_shape_agrees_with_the_slow_oracle() {
    // A cup: concave edges, thin walls.
    let cup =
        revolved_mesh(&[[0.0, 0.0], [8.0, 0.0], [9.0, 12.0], [8.0, 12.0], [7.0, 1.0], [2.0, 1.5], [0.0, 1.0]], 24);
    let design = DesignMesh::new(&cup).expect("solid");
    for i in 0..1500 {
        let f = |k: f64| (f64::from(i) * k).fract() * 2.0 - 1.0;
        let p = Point::new(11.0 * f(0.618_033), 11.0 * f(0.414_213), 6.0 + 9.0 * f(0.732_050));
        let d = design.signed_distance(&p).expect("answers");
        assert!((d.abs() - slow_distance(&cup, &p)).abs() < 1e-10, "{p}");
        if d.abs() > 1e-9 {
            assert_eq!(d < 0.0, winding_number(&cup, &p) > 0.5, "{p}: {d}");
        }
    }
}

#[test]
fn the_frustum_in_closed_form_agrees_with_its_mesh() {
    let frustum =
        ConeFrustum { base: Point::origin(), axis: Vector::z(), base_radius: 30.0, top_radius: 18.0, height: 25.0 };
    let sectors = 2000;
    let mesh = revolved_mesh(&[[0.0, 0.0], [30.0, 0.0], [18.0, 25.0], [0.0, 25.0]], sectors);
    let place = Pose::from_rpy(Vector::new(3.0, -4.0, 5.0), 0.4, -0.7, 1.1);
    let design = DesignMesh::new(&mesh.transformed(&place)).expect("solid");
    let placed = ConeFrustum { base: place.point(&frustum.base), axis: place.vector(&frustum.axis), ..frustum };
    let chord = 30.0 * (1.0 - (PI / sectors as f64).cos());
    for i in 0..2000 {
        let f = |k: f64| (f64::from(i) * k).fract() * 2.0 - 1.0;
        let p = place.point(&Point::new(40.0 * f(0.618_033), 40.0 * f(0.414_213), 12.0 + 20.0 * f(0.732_050)));
        let (a, b) = (placed.nearest(&p, 1e9).expect("answers"), design.nearest(&p, 1e9).expect("answers"));
        assert!((a.distance - b.distance).abs() <= chord + 1e-9, "{p}: {} {}", a.distance, b.distance);
        assert!((a.normal.norm() - 1.0).abs() < 1e-12);
        // A step along the normal changes the distance by its length, away from the medial axis and edges.
        let on_flank = ConeFlank { frustum: placed, end_margin: 2.0 }.nearest(&p, 3.0);
        if let Some(n) = on_flank {
            let q = p + n.normal * 0.1;
            let d = ConeFlank { frustum: placed, end_margin: 0.0 }.signed_distance(&q).expect("still on the flank");
            assert!((d - n.distance - 0.1).abs() < 1e-12);
        }
    }
}

#[test]
fn the_flank_answers_only_between_its_ends() {
    let frustum =
        ConeFrustum { base: Point::origin(), axis: Vector::z(), base_radius: 10.0, top_radius: 10.0, height: 20.0 };
    let flank = ConeFlank { frustum, end_margin: 1.0 };
    assert_eq!(flank.signed_distance(&Point::new(10.5, 0.0, 10.0)), Some(0.5));
    assert_eq!(flank.signed_distance(&Point::new(9.0, 0.0, 10.0)), Some(-1.0));
    assert_eq!(flank.signed_distance(&Point::new(10.5, 0.0, 0.5)), None);
    assert_eq!(flank.signed_distance(&Point::new(10.5, 0.0, 19.5)), None);
    assert_eq!(flank.nearest(&Point::new(10.5, 0.0, 10.0), 0.4), None);
}

fn settings() -> DeviationSettings {
    DeviationSettings { range: f64::INFINITY, region: None, only_cut: false, tolerance_floor: 0.0, cells: [1.0; 3] }
}

/// Points of the plane n . x = 0 (pushed out by `offset` along n) on rays of all three directions.
fn plane_samples(n: Vector, cell: f64, offset: f64) -> Vec<SurfacePoint> {
    let cells = (20.0 / cell) as i32;
    let mut all = Vec::new();
    for axis in 0..3_usize {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for i in -cells..cells {
            for j in -cells..cells {
                let mut p = Point::origin();
                p[u] = (f64::from(i) + 0.5) * cell;
                p[v] = (f64::from(j) + 0.5) * cell;
                p[axis] = (offset - n[u] * p[u] - n[v] * p[v]) / n[axis];
                if p.coords.norm() < 10.0 {
                    all.push(SurfacePoint { point: p, normal: Some(n), axis: axis as u8, made_by: Some(7) });
                }
            }
        }
    }
    all
}

#[test]
fn weights_give_the_area_of_a_slanted_disk() {
    let n = Vector::new(1.0, 2.0, 3.0).normalize();
    let design = HalfSpaceDesign { point: Point::origin(), normal: n };
    let cell = 0.1;
    let samples = plane_samples(n, cell, 0.0);
    let d = measure(&samples, &design, &DeviationSettings { cells: [cell; 3], ..settings() });
    // Counting grid points in a disk of radius 100 cells: well within 0.5 percent.
    assert!((d.area / (PI * 100.0) - 1.0).abs() < 5e-3, "{}", d.area);
    assert!(d.rms < 1e-12 && d.gouge_max < 1e-12 && d.excess_max < 1e-12);
}

#[test]
fn offsets_are_gouge_or_excess() {
    let n = Vector::new(-2.0, 1.0, 2.0) / 3.0;
    let design = HalfSpaceDesign { point: Point::origin(), normal: n };
    for offset in [-0.25, 0.25] {
        let samples = plane_samples(n, 0.5, offset);
        let d = measure(&samples, &design, &DeviationSettings { cells: [0.5; 3], tolerance_floor: 0.01, ..settings() });
        assert!((d.mean - offset).abs() < 1e-12 && (d.rms - 0.25).abs() < 1e-12);
        assert!((d.gouge_max - (-offset).max(0.0)).abs() < 1e-12);
        assert!((d.excess_max - offset.max(0.0)).abs() < 1e-12);
        assert_eq!(d.gouge_area > 0.0, offset < 0.0);
        assert!(offset > 0.0 || (d.gouge_area - d.area).abs() < 1e-9);
        assert_eq!(d.samples as usize, samples.len());
        assert_eq!(d.worst.and_then(|w| w.made_by), Some(7));
    }
}

#[test]
fn range_region_and_raw_skin_are_left_out_and_counted() {
    let n = Vector::z();
    let design = HalfSpaceDesign { point: Point::origin(), normal: n };
    let at = |x: f64, z: f64, made_by| SurfacePoint { point: Point::new(x, 0.0, z), normal: None, axis: 2, made_by };
    let samples = [
        at(0.0, 0.1, Some(1)),
        at(1.0, -0.3, Some(2)),
        at(2.0, 5.0, Some(3)),
        at(9.0, 0.0, Some(4)),
        at(3.0, 0.0, None),
    ];
    let region = Aabb { min: Point::new(-1.0, -1.0, -9.0), max: Point::new(5.0, 1.0, 9.0) };
    let d = measure(
        &samples,
        &design,
        &DeviationSettings { range: 1.0, region: Some(region), only_cut: true, ..settings() },
    );
    assert_eq!((d.samples, d.out_of_range, d.masked), (2, 1, 2));
    assert_eq!(d.gouge_max, 0.3);
    assert_eq!(d.worst.map(|w| (w.deviation, w.made_by)), Some((-0.3, Some(2))));
    assert_eq!(d.values[..2], [0.1, -0.3]);
    assert!(d.values[2..].iter().all(|v| v.is_nan()));
    let none = measure(&[], &design, &settings());
    assert_eq!((none.samples, none.worst, none.rms), (0, None, 0.0));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let design = DesignMesh::new(&sphere_mesh(9.0, 30, 40)).expect("solid");
    let samples = plane_samples(Vector::new(1.0, 2.0, 3.0).normalize(), 0.3, 0.1);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
        let d = pool.install(|| measure(&samples, &design, &settings()));
        (d.mean.to_bits(), d.rms.to_bits(), d.area.to_bits(), d.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn a_mesh_with_a_hole_is_refused() {
    let mut open = box_mesh(&cube());
    open.triangles.pop();
    assert!(matches!(DesignMesh::new(&open), Err(DesignError::NotSolid(_))));
    let design = DesignMesh::new(&box_mesh(&cube())).expect("solid");
    assert_eq!(design.nearest(&Point::new(f64::NAN, 0.0, 0.0), 1.0), None);
    assert_eq!(design.bounds(), cube());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A bounded search finds the same point, or proves that it is further away.
    #[test]
    fn a_bounded_search_is_the_full_search(x in -20.0..20.0, y in -12.0..12.0, z in -8.0..16.0, range in 0.0..8.0) {
        let design = DesignMesh::new(&box_mesh(&cube())).expect("solid");
        let p = Point::new(x, y, z);
        let exact = box_distance(&cube(), &p);
        match design.nearest(&p, range) {
            Some(n) => prop_assert!((n.distance - exact).abs() < 1e-12),
            None => prop_assert!(exact.abs() > range * (1.0 - 1e-12)),
        }
    }
}

#[test]
fn a_slot_cut_into_stock_is_measured_exactly() {
    use proveout_geom::ToolPose;
    use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
    let bounds = Aabb { min: Point::origin(), max: Point::new(40.0, 30.0, 20.0) };
    let mut stock = TriDexel::from_box(&bounds, 0.5, 1 << 30).expect("stock");
    let cutter = proveout_tool::Cutter::flat(10.0).expect("flat").bodies(30.0).expect("bodies").remove(0);
    let at = |x: f64| ToolPose { tip: Point::new(x, 15.0, 12.0), axis: Vector::z() };
    let motion = SweepMotion { from: at(-10.0), to: at(50.0) };
    stock.sweep(&[SweepItem { id: 3, body: &cutter, action: Action::Remove, motion }]);
    let samples: Vec<SurfacePoint> = stock.surface_points().collect();
    let floor = HalfSpaceDesign { point: Point::new(0.0, 0.0, 12.0), normal: Vector::z() };
    // The walls of the slot begin at its floor: they are kept out by the region.
    let region = Aabb { min: Point::new(0.0, 10.5, 11.0), max: Point::new(40.0, 19.5, 13.0) };
    let settings =
        DeviationSettings { cells: [0.5; 3], only_cut: true, region: Some(region), range: 1.0, ..settings() };
    let d = measure(&samples, &floor, &settings);
    // The stock promises its sweep within this bound.
    let bound = stock.sweep_bound_mm();
    assert!(d.samples > 1000 && bound <= 1e-3);
    assert!(d.gouge_max <= bound && d.excess_max <= bound, "{} {}", d.gouge_max, d.excess_max);
    assert!((d.area / (40.0 * 9.0) - 1.0).abs() < 0.03, "{}", d.area);
    assert_eq!(d.worst.and_then(|w| w.made_by), Some(3));
}
