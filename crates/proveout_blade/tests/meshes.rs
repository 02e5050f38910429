//! Meshes of every kind: closed, and within the chord error that was asked, at random points against the
//! closed form.
#![allow(clippy::print_stdout, reason = "the table is what is asked for")]

use std::sync::Arc;

use proveout_blade::{
    Backing, Blade, BladeEnd, BladeSolid, BladeSpec, CamberSection, ClosedForm, ClosedSurface, Cui, Dong, Lu,
    MeasuredMesh, ParametricSurface, Plate, Platform, PointedSection, SectionPart, Sine, SkinnedBlade, face_mesh,
};
use proveout_geom::{Point, TriMesh, Vector};

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

/// Random points of each mesh: 1,000, or as many as the environment variable `PROVEOUT_BLADE_POINTS` says.
fn points() -> u32 {
    std::env::var("PROVEOUT_BLADE_POINTS").map_or(1_000, |text| text.parse().expect("a count of points"))
}

/// A name, a surface, its ends, and the material left on it, mm.
type Ended = (&'static str, Arc<dyn ParametricSurface>, [BladeEnd; 2], f64);

/// A spline through sections of Lu's blade, its edges as arcs of their own: 10 degrees of w to either side of
/// the ends of the chord.
fn through_sections() -> SkinnedBlade {
    let blade = Lu::stand_in();
    let section = |j: u32| {
        let point = |k: u32| Point::from(Vector::from(blade.place(f64::from(k).to_radians(), f64::from(j) / 8.0)));
        let part = |k: u32| match k {
            0..=10 | 350.. => SectionPart::Trailing,
            11..=169 => SectionPart::Suction,
            170..=190 => SectionPart::Leading,
            _ => SectionPart::Pressure,
        };
        PointedSection {
            name: j.to_string(),
            points: (0..360).map(point).collect(),
            parts: (0..360).map(part).collect(),
        }
    };
    SkinnedBlade::new(&(0..=8).map(section).collect::<Vec<_>>()).expect("a blade")
}

#[test]
fn blades_with_platforms_at_both_ends_are_met_within_the_chord_error() {
    let count = points();
    let on = |x, radius, side| BladeEnd { x, plate: Some(plate(radius, side)) };
    let cut = |x| BladeEnd { x, plate: None };
    let kinds: Vec<Ended> = vec![
        ("lu", Arc::new(ClosedSurface::new(Lu::stand_in())), [on(1.0, 3.0, 30.0), on(98.0, 1.5, 30.0)], 0.0),
        ("lu untwisted", Arc::new(ClosedSurface::new(Lu::untwisted())), [on(1.0, 3.0, 30.0), on(98.0, 1.5, 30.0)], 0.0),
        ("sections", Arc::new(through_sections()), [on(1.0, 3.0, 30.0), on(98.0, 1.5, 30.0)], 0.0),
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
        say(name, count, worst, &made, error);
        // What was measured is what any point keeps; a third of it is met somewhere, so that nothing was
        // measured in vain.
        assert!(worst <= made.measured + 1e-6 && worst > 0.3 * made.measured, "{name}: {worst} of {}", made.measured);
    }
}

/// One line of the table.
fn say(name: &str, count: u32, worst: f64, made: &MeasuredMesh, error: f64) {
    println!(
        "{name:18} {count:7} points: {:7.3} um at most, {:7.3} um as measured, {:7.3} um asked; {} triangles",
        1e3 * worst,
        1e3 * made.measured,
        1e3 * error,
        made.mesh.triangles.len()
    );
}

/// Kind `camber` on its platform has a mesh of its own making, with steps by sagitta that are not corrected
/// by what is measured: it may be off by more than was asked, here 12.7 um of 10, twisted 15.3. A run
/// therefore counts with what `chord_error` of `proveout_surface` measures.
#[test]
fn a_blade_on_a_camber_line_is_met_near_the_chord_error() {
    let platform = Some(Platform { fillet_radius: 4.0, margin: 8.0, thickness: 10.0 });
    for (name, twist) in [("camber", 0.0), ("camber, twisted", 0.004)] {
        let spec = BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist, platform };
        let blade = Blade::new(spec).expect(name);
        let (error, count) = (0.01, points());
        let mesh = blade.mesh(error);
        let (mut draw, mut worst) = (Draw(31), 0.0_f64);
        for _ in 0..count {
            let found = blade.nearest(&random_point(&mesh, &mut draw)).expect(name);
            worst = worst.max(found.distance.abs());
        }
        println!(
            "{name:18} {count:7} points: {:7.3} um at most, {:7.3} um asked; {} triangles",
            1e3 * worst,
            1e3 * error,
            mesh.triangles.len()
        );
        assert!(worst <= 1.6 * error && worst > 0.1 * error, "{name}: {worst}");
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
            say(name, 10 * points(), worst, &made, error);
            assert!(
                worst <= made.measured + 1e-6 && worst > 0.3 * made.measured,
                "{name}: {worst} of {}",
                made.measured
            );
        }
    }
}

/// The point of a triangle nearest to p (Ericson 2005, section 5.1.5).
fn on_triangle([a, b, c]: [Point; 3], p: Point) -> Point {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let whole = va + vb + vc;
    a + ab * (vb / whole) + ac * (vc / whole)
}

/// The part of the sphere round p that a triangle covers, steradian (van Oosterom & Strackee 1983, equation
/// 8).
fn solid_angle(corners: [Point; 3], p: Point) -> f64 {
    let [a, b, c] = corners.map(|q| q - p);
    let [x, y, z] = [a.norm(), b.norm(), c.norm()];
    2.0 * a.dot(&b.cross(&c)).atan2(x * y * z + a.dot(&b) * z + a.dot(&c) * y + b.dot(&c) * x)
}

/// Signed distance to a closed mesh from all of its triangles, below zero inside.
fn by_all_triangles(mesh: &TriMesh, p: Point) -> f64 {
    let (mut least, mut angle) = (f64::INFINITY, 0.0);
    for k in 0..mesh.triangles.len() {
        let corners = mesh.corners(k);
        least = least.min((on_triangle(corners, p) - p).norm_squared());
        angle += solid_angle(corners, p);
    }
    if angle > std::f64::consts::TAU { -least.sqrt() } else { least.sqrt() }
}

/// Places that the draw visits: all round the part up to 6 mm outside of its bounds, deep inside of it,
/// within the platforms, and up to 1.5 mm to both sides of every face, fillets and rims among them.
#[test]
fn the_nearest_point_of_a_blade_with_ends_is_that_of_all_triangles_of_its_mesh() {
    let on = |x, radius, side| BladeEnd { x, plate: Some(plate(radius, side)) };
    let cut = |x| BladeEnd { x, plate: None };
    let lu = || Arc::new(ClosedSurface::new(Lu::stand_in()));
    let error = 0.005;
    for (name, ends, allowance) in [
        ("platforms", [on(1.0, 3.0, 30.0), on(98.0, 1.5, 30.0)], 0.0),
        ("cut", [cut(5.0), cut(60.0)], 0.0),
        ("low", [on(1.0, 6.0, 30.0), cut(16.0)], 0.0),
        ("allowance", [on(1.0, 3.0, 30.0), cut(98.0)], 0.4),
    ] {
        let solid = BladeSolid::new(lu(), ends, allowance).expect(name);
        let mesh = solid.mesh(error).expect(name).mesh;
        let (low, high) = mesh.positions.iter().fold((mesh.positions[0].coords, mesh.positions[0].coords), |b, p| {
            (b.0.inf(&p.coords), b.1.sup(&p.coords))
        });
        let mut draw = Draw(41);
        let mut random = || [draw.next(), draw.next(), draw.next()];
        let (mut inside, mut deepest) = (0, 0.0_f64);
        for k in 0..300 {
            let [r, s, t] = random();
            let p = match k % 3 {
                0 => Point::from(low.zip_map(&Point::new(r, s, t).coords, |a, r| a - 6.0 + r * 12.0).zip_zip_map(
                    &high.zip_map(&low, |b, a| b - a),
                    &Point::new(r, s, t).coords,
                    |a, wide, r| a + wide * r,
                )),
                // Within the thickness of the blade or below its foot.
                1 => {
                    let at = solid.surface().local(r * std::f64::consts::TAU, s);
                    at.point - at.normal * (2.0 * t)
                }
                _ => {
                    let at = random_point(&mesh, &mut Draw(k));
                    at + (Point::new(r, s, t) - Point::new(0.5, 0.5, 0.5)) * 3.0
                }
            };
            let found = solid.nearest(&p);
            let wanted = by_all_triangles(&mesh, p);
            assert!((found.distance - wanted).abs() <= 1.5 * error, "{name}, {p}: {} not {wanted}", found.distance);
            // Along the normal by the distance there is the surface.
            let foot = p - found.normal * found.distance;
            assert!(by_all_triangles(&mesh, foot).abs() <= 1.5 * error, "{name}, {p}: the normal");
            inside += u32::from(wanted < 0.0);
            deepest = deepest.min(wanted);
        }
        assert!((60..240).contains(&inside) && deepest < -1.0, "{name}: {inside} {deepest}");
    }
}
