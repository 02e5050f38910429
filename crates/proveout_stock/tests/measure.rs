//! Sections, distances and thicknesses against closed forms.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]

use std::f64::consts::PI;

use crate::common::{GIB, Random, ball, cuboid, flat, pose, remove};
use proveout_geom::{Point, Vector};
use proveout_stock::{Outline, Probe, TriDexel};

const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// A block 20 x 16 x 8 with a round hole through it at (6, 8) of radius 3.
fn holed(cell: f64) -> TriDexel {
    let mut stock = TriDexel::from_box(&cuboid([0.0; 3], [20.0, 16.0, 8.0]), cell, GIB).unwrap();
    let tool = flat(3.0, 30.0);
    stock.sweep(&[remove(1, &tool, pose([6.0, 8.0, 12.0], UP), pose([6.0, 8.0, -2.0], UP))]);
    stock
}

#[test]
fn a_section_is_closed_and_has_its_area() {
    let cell = 0.2;
    let probe = Probe::new(&holed(cell));
    for normal in [Vector::z(), -Vector::z(), Vector::new(0.2, -0.1, 1.0).normalize()] {
        let outlines = probe.section(&Point::new(10.0, 8.0, 4.01), &normal);
        assert_eq!(outlines.len(), 2, "the block and its hole");
        let area: f64 = outlines.iter().map(|o| o.area(&normal)).sum();
        // Oblique sections of prisms are larger by 1 / cosine.
        let want = (20.0 * 16.0 - PI * 9.0) / normal.z.abs();
        assert!((area / want - 1.0).abs() < 1e-3, "{area} {want}");
        let (mut outer, mut hole) = (0, 0);
        for o in &outlines {
            if o.area(&normal) > 0.0 {
                outer += 1
            } else {
                hole += 1
            }
            for p in &o.points {
                assert!((p - Point::new(10.0, 8.0, 4.01)).dot(&normal).abs() < 1e-9);
                let wall = (p.x - 6.0).hypot(p.y - 8.0) - 3.0;
                let face = p.x.abs().min((p.x - 20.0).abs()).min(p.y.abs()).min((p.y - 16.0).abs());
                // Facets of the hole are off by cell^2 / 8 r at most twice.
                assert!(face < 1e-6 || wall.abs() < cell * cell / 12.0, "{p}");
            }
        }
        assert_eq!((outer, hole), (1, 1));
    }
    assert!(probe.section(&Point::new(0.0, 0.0, 9.0), &Vector::z()).is_empty());
    assert!(probe.section(&Point::new(0.0, 0.0, 4.0), &Vector::zeros()).is_empty());
    let corners = vec![Point::new(0.0, 0.0, 0.0), Point::new(2.0, 0.0, 0.0), Point::new(2.0, 3.0, 0.0)];
    assert_eq!(Outline { points: corners }.area(&Vector::z()), 3.0);
}

#[test]
fn the_nearest_point_is_that_of_the_closed_form() {
    let cell = 0.25;
    let probe = Probe::new(&holed(cell));
    let mut random = Random(21);
    let mut inside = 0;
    for _ in 0..3000 {
        let p = Point::new(random.range(-6.0, 26.0), random.range(-6.0, 22.0), random.range(-5.0, 13.0));
        let near = probe.nearest(&p).unwrap();
        // Box and hole: exact outside of the box and within the hole away from its rims.
        let q = Vector::new((p.x - 10.0).abs() - 10.0, (p.y - 8.0).abs() - 8.0, (p.z - 4.0).abs() - 4.0);
        let box_distance = q.map(|x| x.max(0.0)).norm() + q.max().min(0.0);
        let radial = 3.0 - (p.x - 6.0).hypot(p.y - 8.0);
        let want = if q.z <= 0.0 {
            box_distance.max(radial)
        } else if radial > 0.0 {
            q.z.hypot(radial) // to the rim
        } else {
            box_distance
        };
        // Where box and hole both are near, the larger of the two is only a bound.
        if want > 0.0 || (box_distance - radial).abs() > 0.5 {
            assert!((near.distance - want).abs() < 0.02, "{p}: {near:?} {want}");
        }
        assert!(((near.point - p).norm() - near.distance.abs()).abs() < 1e-9);
        inside += u32::from(near.distance < 0.0);
    }
    assert!(inside > 200);
    assert_eq!(probe.nearest(&Point::new(f64::NAN, 0.0, 0.0)), None);
    let far = probe.nearest(&Point::new(500.0, 8.0, 4.0)).unwrap();
    assert!((far.distance - 480.0).abs() < 1e-6);
}

#[test]
fn a_wall_is_as_thick_as_a_caliper_reads() {
    let stock = holed(0.2);
    let probe = Probe::new(&stock);
    // Between the hole and the face x = 0: on the ray exactly, at its own place.
    let at = Point::new(1.0, 8.0, 4.0);
    let wall = stock.thickness_along(0, &at).unwrap();
    let y = wall.faces[0].y - 8.0;
    assert!((wall.thickness - (6.0 - (9.0 - y * y).sqrt())).abs() < 1e-6, "{wall:?}");
    let wall = probe.wall(&at, &Vector::x()).unwrap();
    assert!((wall.thickness - 3.0).abs() < 2e-3, "{wall:?}");
    // From outside, beyond the hole, and askew through the plate.
    let wall = probe.wall(&Point::new(6.0, 8.0, 4.0), &Vector::x()).unwrap();
    assert!((wall.thickness - 11.0).abs() < 2e-3 && (wall.faces[1].x - 20.0).abs() < 1e-6);
    let askew = Vector::new(0.3, 0.1, -1.0).normalize();
    let wall = probe.wall(&Point::new(13.0, 5.0, 11.0), &askew).unwrap();
    assert!((wall.thickness - 8.0 / askew.z.abs()).abs() < 1e-6);
    assert_eq!(probe.wall(&Point::new(6.0, 8.0, 4.0), &Vector::z()), None, "through the hole");
    assert_eq!(probe.wall(&Point::new(6.0, 8.0, 4.0), &Vector::zeros()), None);
    assert_eq!(stock.thickness_along(2, &Point::new(6.0, 8.0, 4.0)), None);
    // A web between two ball slots.
    let mut plate = TriDexel::from_box(&cuboid([0.0; 3], [20.0, 16.0, 8.0]), 0.2, GIB).unwrap();
    let tool = ball(2.0, 30.0);
    plate.sweep(&[
        remove(1, &tool, pose([-3.0, 5.0, 3.0], UP), pose([23.0, 5.0, 3.0], UP)),
        remove(2, &tool, pose([-3.0, 10.5, 3.0], UP), pose([23.0, 10.5, 3.0], UP)),
    ]);
    let wall = Probe::new(&plate).wall(&Point::new(10.0, 7.0, 6.0), &Vector::y()).unwrap();
    assert!((wall.thickness - 1.5).abs() < 2e-3, "{wall:?}");
}

#[test]
fn a_stock_with_nothing_left_has_nothing_to_measure() {
    let mut gone = TriDexel::from_box(&cuboid([0.0; 3], [4.0, 4.0, 4.0]), 0.5, GIB).unwrap();
    let tool = flat(60.0, 60.0);
    gone.sweep(&[remove(1, &tool, pose([2.0, 2.0, -1.0], UP), pose([2.5, 2.0, -1.0], UP))]);
    let probe = Probe::new(&gone);
    let p = Point::new(1.0, 1.0, 1.0);
    assert_eq!((probe.nearest(&p), probe.wall(&p, &Vector::x())), (None, None));
    assert!(probe.section(&p, &Vector::z()).is_empty());
}
