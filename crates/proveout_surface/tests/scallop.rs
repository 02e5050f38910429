//! Strip widths and ridges from the geometry of contacts, against the values of an independent implementation
//! and closed forms.

use proveout_surface::scallop::{CutterContact, ball_scallop, ball_step, scallop_between};
use proveout_tool::{Cutter, Profile};

fn body(cutter: Cutter) -> Profile {
    cutter.bodies(20.0).expect("a cutter").remove(0)
}

/// Bull-nose cutter of radius 5 mm with a corner of 3 mm at a height of 0.1 mm: recomputed from Dong et al.
/// 2023 with an exact torus by other hands, ten figures.
const STRIP_WIDTH: &str = include_str!("reference/multi-scale_golden_strip_width.csv");
/// Steps of a ball of 3 mm for a ridge of 0.02 mm: Ma et al. 2020, exact forms solved for L by other hands,
/// ten figures.
const BALL_STEPS: &str = include_str!("reference/min-angular-acceleration_golden_scallop.csv");

/// The rows of a table of numbers under its names.
fn rows(table: &str) -> Vec<Vec<f64>> {
    let numbers = |line: &str| line.split(',').map(|v| v.trim().parse().expect("a number")).collect();
    table.lines().skip(1).filter(|l| !l.trim().is_empty()).map(numbers).collect()
}

#[test]
fn strip_widths_of_a_bull_nose_cutter_have_the_printed_figures() {
    let profile = body(Cutter::bull_nose(10.0, 3.0).expect("a bull-nose"));
    let table = rows(STRIP_WIDTH);
    assert_eq!(table.len(), 15);
    for row in table {
        let [_, _, _, inclination, azimuth, smallest, radius, by_radius, left, right, section, curvature, swept] =
            row[..]
        else {
            panic!("thirteen columns")
        };
        let contact =
            CutterContact::with_tilt(&profile, inclination.to_radians(), azimuth.to_radians()).expect("leans");
        let own = contact.section_width(0.1).expect("a section");
        let moving = contact.swept_width(0.1).expect("a shadow");
        let values = [
            (contact.curvatures()[1], smallest),
            (contact.radius_across(), radius),
            (contact.width_by_radius(0.1), by_radius),
            (own[0], left),
            (own[1], right),
            (own[0] + own[1], section),
            (contact.swept_curvature(), curvature),
            (moving[0] + moving[1], swept),
        ];
        for (k, (value, printed)) in values.into_iter().enumerate() {
            // Ten figures are printed.
            assert!(
                (value - printed).abs() <= 6e-10 * printed.abs().max(1.0),
                "{inclination} {azimuth} [{k}]: {value} {printed}"
            );
        }
    }
}

#[test]
fn steps_of_a_ball_have_the_printed_figures_and_lead_back() {
    let flat = ball_step(3.0, 0.02, 0.0).expect("a step");
    assert!((flat - 0.6916646586).abs() < 1e-10 && (flat - 2.0 * (2.0 * 3.0 * 0.02 - 0.0004_f64).sqrt()).abs() < 1e-15);
    let table = rows(BALL_STEPS);
    assert_eq!(table.len(), 8);
    for row in table {
        let (radius, convex, concave) = (row[2], row[4], row[7]);
        for (curvature, printed) in [(1.0 / radius, convex), (-1.0 / radius, concave)] {
            let step = ball_step(3.0, 0.02, curvature).expect("a step");
            assert!((step - printed).abs() < 6e-10, "{radius} {curvature}: {step} {printed}");
            let back = ball_scallop(3.0, step, curvature).expect("a ridge");
            assert!((back - 0.02).abs() < 1e-14, "{back}");
        }
    }
    assert_eq!(ball_scallop(3.0, 6.1, 0.0), None, "the balls do not meet");
    assert_eq!(ball_scallop(3.0, 0.5, -1.0 / 2.9), None, "the ball does not fit into the hollow");
    assert_eq!(ball_step(3.0, 0.02, -1.0 / 2.9), None);
}

#[test]
fn two_contacts_of_a_ball_leave_the_ridge_of_the_closed_form_however_it_leans() {
    let profile = body(Cutter::ball(6.0).expect("a ball"));
    for curvature in [0.0, 0.08, -0.08, 0.3, -0.25] {
        for step in [0.05, 0.7, 2.0] {
            let exact = ball_scallop(3.0, step, curvature).expect("a ridge");
            for (inclination, azimuth) in [(0.0, 0.0), (0.3, 0.0), (0.3, 1.2), (1.2, -2.0)] {
                let contact = CutterContact::with_tilt(&profile, inclination, azimuth).expect("leans");
                let found = scallop_between(&contact, &contact, step, curvature).expect("a ridge");
                assert!((found - exact).abs() < 1e-12, "{curvature} {step} {inclination}: {found} {exact}");
            }
        }
    }
}

/// A flat cutter of radius R that leans by a along the feed leaves an ellipse with half axes R and R sin a; a
/// bull-nose leaves its parallel curve. On a plane the ridge lies half way.
#[test]
fn leaning_flat_and_bull_nose_cutters_leave_ellipses_and_their_parallel_curves() {
    let flat = body(Cutter::flat(10.0).expect("a flat end"));
    let bull = body(Cutter::bull_nose(10.0, 2.0).expect("a bull-nose"));
    for degrees in [2.0, 10.0, 30.0_f64] {
        let lean = degrees.to_radians();
        for step in [0.3, 1.0, 4.0_f64] {
            let contact = CutterContact::with_tilt(&flat, lean, 0.0).expect("leans");
            let low = 5.0 * lean.sin();
            let exact = low * (1.0 - (1.0 - (0.1 * step).powi(2)).sqrt());
            let found = scallop_between(&contact, &contact, step, 0.0).expect("a ridge");
            assert!((found - exact).abs() < 1e-11, "flat {degrees} {step}: {found} {exact}");

            let contact = CutterContact::with_tilt(&bull, lean, 0.0).expect("leans");
            let found = scallop_between(&contact, &contact, step, 0.0).expect("a ridge");
            // Parametric: the ellipse of the centers at t, grown by the corner along its normal.
            let (a, b) = (3.0, 3.0 * lean.sin());
            let at = |t: f64| {
                let (s, c) = t.sin_cos();
                let n = (b * s).hypot(a * c);
                (a * s + 2.0 * b * s / n, (b + 2.0) - (b * c + 2.0 * a * c / n))
            };
            let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if at(middle).0 < 0.5 * step { low = middle } else { high = middle }
            }
            assert!((found - at(low).1).abs() < 1e-11, "bull {degrees} {step}: {found} {}", at(low).1);
        }
    }
    // Upright, both leave the plane bare between passes that overlap.
    let upright = CutterContact::with_tilt(&flat, 0.0, 0.0).expect("stands");
    assert!(scallop_between(&upright, &upright, 4.0, 0.0).is_none_or(|h| h.abs() < 1e-9));
    assert!((upright.swept_width(0.1).expect("a shadow")[0] - 5.0).abs() < 1e-12);
}

/// Dong's trends: the swept and the section's width fall with the inclination, and the section is widest
/// where the lean follows the feed.
#[test]
fn trends_over_inclination_and_tilt() {
    let profile = body(Cutter::bull_nose(10.0, 3.0).expect("a bull-nose"));
    let width = |inclination: f64, azimuth: f64| {
        let contact =
            CutterContact::with_tilt(&profile, inclination.to_radians(), azimuth.to_radians()).expect("leans");
        let (section, swept) = (contact.section_width(0.1).expect("wide"), contact.swept_width(0.1).expect("wide"));
        [section[0] + section[1], swept[0] + swept[1], section[0] - section[1]]
    };
    for k in 0..8 {
        let inclination = 8.0 + 4.0 * f64::from(k);
        let (here, steeper) = (width(inclination, 0.0), width(inclination + 4.0, 0.0));
        assert!(here[0] > steeper[0] && here[1] > steeper[1] && here[1] > here[0]);
        assert!(here[2].abs() < 1e-9, "as wide to both sides");
        let tilted = [-50.0, -25.0, 25.0, 50.0].map(|azimuth| width(inclination, azimuth));
        assert!(tilted.iter().all(|w| w[0] < here[0] && w[1] < here[1]), "{inclination}: {tilted:?} {here:?}");
        // The lean to the left narrows the left half, and the two sides are mirrored.
        assert!(tilted[2][2] < 0.0 && (tilted[1][2] + tilted[2][2]).abs() < 1e-9);
    }
}
