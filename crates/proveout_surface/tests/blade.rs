//! A blade as a design in closed form, and the chord error of its mesh as measured.

#![allow(clippy::unwrap_used, reason = "a failed test says why")]

use proveout_blade::{Blade, BladeSpec, CamberSection, Platform};
use proveout_geom::{Point, rad};
use proveout_surface::{DesignMesh, DesignSurface, chord_error};

fn blade() -> Blade {
    let platform = Some(Platform { fillet_radius: 10.0, margin: 14.0, thickness: 12.0 });
    Blade::new(BladeSpec { section: CamberSection::stand_in(), length: 45.0, twist: rad(0.1), platform }).unwrap()
}

#[test]
fn the_chord_error_is_that_of_the_worst_facet() {
    let blade = blade();
    let asked = 0.02;
    let mesh = blade.mesh(asked);
    let measured = chord_error(&mesh, &blade).unwrap();
    assert!(measured > 0.5 * asked && measured < 3.0 * asked, "{measured}");
    // No other place is off by more: random ones on facets of all faces, and the corners, which lie on the
    // blade.
    let mut state = 5_u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    let mut most = 0.0_f64;
    for triangle in mesh.triangles.iter().step_by(3) {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].coords);
        let (u, v) = (unit(), unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let p = Point::from(a + (b - a) * u + (c - a) * v);
        most = most.max(blade.signed_distance(&p).unwrap().abs());
        assert!(blade.signed_distance(&Point::from(a)).unwrap().abs() < 1e-6);
    }
    assert!(most <= 1.001 * measured && most > 0.7 * measured, "{most} {measured}");
    assert_eq!(chord_error(&blade.mesh(asked), &Blade::new(blade.spec().clone()).unwrap()), Some(measured));
}

#[test]
fn closed_form_and_mesh_agree_within_the_chord_error() {
    let blade = blade();
    let mesh = blade.mesh(0.05);
    let measured = chord_error(&mesh, &blade).unwrap();
    let tree = DesignMesh::new(&mesh).unwrap();
    for k in 0..20_u8 {
        for j in 0..20_u8 {
            let p = Point::new(f64::from(k) * 3.3 - 15.0, f64::from(j) * 4.1 - 40.0, f64::from(k ^ j) - 12.0);
            let (a, b) =
                (DesignSurface::nearest(&blade, &p, f64::INFINITY).unwrap(), tree.signed_distance(&p).unwrap());
            assert!((a.distance - b).abs() <= measured + 1e-6, "{p} {a:?} {b}");
            assert_eq!(DesignSurface::nearest(&blade, &p, 0.5 * a.distance.abs()), None);
        }
    }
    assert_eq!(blade.signed_distance(&Point::new(f64::NAN, 0.0, 0.0)), None);
}
