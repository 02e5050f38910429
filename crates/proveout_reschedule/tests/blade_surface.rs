//! Contacts on a blade: nearest points, normals and principal curvatures against laws that share no formula
//! with them.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_blade::{Blade, BladeSpec, CamberSection, Platform};
use proveout_geom::{Pose, Vector};
use proveout_reschedule::{BladeSurface, ContactSurface};

fn blade(twist: f64) -> Blade {
    let platform = Platform { fillet_radius: 10.0, margin: 14.0, thickness: 12.0 };
    Blade::new(BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist, platform: Some(platform) }).unwrap()
}

fn somewhere() -> Pose {
    Pose::from_rpy(Vector::new(260.0, -3.0, 7.0), 0.4, -0.2, 1.1)
}

#[test]
fn a_point_off_the_surface_along_its_normal_comes_back() {
    for twist in [0.0, 0.002, -0.01] {
        let blade = blade(twist);
        let place = somewhere();
        let surface = BladeSurface::new(blade.clone(), place);
        for i in 0..400 {
            let (arc, x) = (f64::from(i) * 0.337, 12.0 + f64::from(i % 41));
            let at = blade.at(arc, x);
            for distance in [0.0, 0.3, 8.0] {
                let near = place.point(&(at.point + at.normal * distance));
                let contact = surface.contact(&near).unwrap();
                assert!((contact.point - place.point(&at.point)).norm() < 1e-8, "{twist} {arc} {x} {distance}");
                assert!((contact.normal - place.vector(&at.normal)).norm() < 1e-8, "{twist} {arc} {x} {distance}");
            }
        }
    }
}

#[test]
fn principal_curvatures_are_those_of_the_surface_beside_the_point() {
    for twist in [0.0, 0.004, -0.01] {
        let blade = blade(twist);
        let surface = BladeSurface::new(blade.clone(), Pose::identity());
        let starts = blade.outline().piece_starts();
        for i in 0..300 {
            let (arc, x, h) = (0.13 + f64::from(i) * 0.443, 15.0 + f64::from(i % 31), 1e-3);
            // Across the end of an edge arc there are two curvatures.
            if starts.iter().any(|s| (s - arc).abs() < 0.01) {
                continue;
            }
            let at = blade.at(arc, x);
            let here = surface.contact(&at.point).unwrap();
            let [(high, u), (low, v)] = here.curvatures;
            assert!(high >= low && u.dot(&v).abs() < 1e-9 && u.dot(&here.normal).abs() < 1e-9);
            for (k, direction) in [(high, u), (low, v)] {
                // A step h along the tangent and back to the surface: the surface falls off by k h^2 / 2
                // there.
                let off = |side: f64| {
                    let there = surface.contact(&(at.point + direction * (side * h))).unwrap();
                    (there.point - at.point).dot(&at.normal)
                };
                let measured = -(off(1.0) + off(-1.0)) / (h * h);
                // Rounding 1e-14 over h^2, and terms of third order that cancel; radii down to 1.2 mm: (h
                // k)^2 k.
                assert!((measured - k).abs() < 1e-6 + 1e-5 * k.abs(), "{twist} {arc} {x}: {measured} {k}");
            }
            if twist == 0.0 {
                let section = blade.outline().at(arc).curvature;
                let expected = if section > 0.0 { [section, 0.0] } else { [0.0, section] };
                assert!((high - expected[0]).abs() < 1e-12 && (low - expected[1]).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn fillet_and_tip_are_not_answered_for() {
    let surface = BladeSurface::new(blade(0.002), Pose::identity());
    let on = blade(0.002).at(20.0, 5.0).point;
    assert!(surface.contact(&on).is_none(), "in the fillet");
    assert!(surface.contact(&(on + Vector::new(70.0, 0.0, 0.0))).is_none(), "beyond the tip");
    assert!(surface.contact(&(on * f64::NAN)).is_none());
}
