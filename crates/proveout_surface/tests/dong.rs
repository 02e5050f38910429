//! The analytic profile of a bull-nose tool: reference widths, closed forms, and the published trends.
//!
//! The reference widths were computed by a program of its own (dense sampling of the torus); the trends are
//! those of Dong et al. 2023.

use std::f64::consts::PI;

use proveout_surface::texture::{
    Asked, ProfileReport, cusp,
    dong::{Cut, Dong, DongError},
};

fn tool(inclination_deg: f64, azimuth_deg: f64, curvature: f64) -> Dong {
    Dong::new(5.0, 3.0, inclination_deg.to_radians(), azimuth_deg.to_radians(), curvature).expect("a model")
}

/// Inclination, azimuth, left and right of the section, swept width; R 5, r 3, height 0.1 mm, plane.
const WIDTHS: [[f64; 5]; 9] = [
    [10.0, 0.0, 1.499857618, 1.499857618, 3.256604643],
    [10.0, 10.0, 1.342113242, 1.639252662, 3.224062514],
    [10.0, 20.0, 1.194657346, 1.700784939, 3.128799414],
    [15.0, 20.0, 1.143505263, 1.445842441, 2.747758177],
    [20.0, 0.0, 1.280853954, 1.280853954, 2.616177493],
    [20.0, 20.0, 1.103656498, 1.30077706, 2.522405711],
    [25.0, 10.0, 1.150729819, 1.239548158, 2.435629612],
    [30.0, 0.0, 1.163415503, 1.163415503, 2.343647721],
    [30.0, 20.0, 1.047112519, 1.147236584, 2.268344176],
];

#[test]
fn widths_are_the_reference_ones() {
    for [l, w, left, right, swept] in WIDTHS {
        let model = tool(l, w, 0.0);
        let (a, b) = model.strip_width(0.1, Cut::Section).expect("a width");
        assert!((a - left).abs() < 2e-8 && (b - right).abs() < 2e-8, "{l} {w}: {a} {b} instead of {left} {right}");
        let (a, b) = model.strip_width(0.1, Cut::Swept).expect("a width");
        assert!((a + b - swept).abs() < 2e-8, "{l} {w}: {} instead of {swept}", a + b);
    }
    let (a, b) = tool(20.0, 10.0, 0.0).tool_curvatures();
    assert!((a - 1.0 / 3.0).abs() < 1e-15 && (b - 0.1130248887).abs() < 1e-9);
    assert!((tool(10.0, 10.0, 0.0).swept_curvature() - 0.07057041198).abs() < 1e-10);
    assert!((1.0 / tool(20.0, 20.0, 0.0).section_curvature() - 7.204814371).abs() < 1e-8);
}

#[test]
fn a_ball_leaves_arcs() {
    // A ball of 4 mm at any lean; passes 0.6 mm apart on a plane.
    for (l, w) in [(20.0, 0.0), (45.0, 33.0), (80.0, -120.0)] {
        let model = Dong::new(4.0, 4.0, f64::to_radians(l), f64::to_radians(w), 0.0).expect("a model");
        for cut in [Cut::Section, Cut::Swept] {
            // Twenty whole periods, so that the mean line is that of the closed form.
            let z = model.profile(0.6, 12.0, 0.0005, cut).expect("a profile");
            let top = z.heights().iter().copied().fold(0.0, f64::max);
            assert!((top - cusp::arc_height(4.0, 0.6).expect("arcs")).abs() < 1e-9, "{cut:?}: {top}");
            let mean = z.heights()[..24_000].iter().sum::<f64>() / 24_000.0;
            let ra = z.heights()[..24_000].iter().map(|h| (h - mean).abs()).sum::<f64>() / 24_000.0;
            assert!((1e3 * ra - 2.890_006_182_07).abs() < 1e-5, "{cut:?}: {ra}");
        }
    }
}

#[test]
fn ra_is_that_of_the_table_of_the_model() {
    // Plane, R 5, r 3, azimuth 0: inclination, Ra at 0.63 and at 0.8 mm, um, to the digits printed.
    for (l, narrow, wide) in
        [(10.0, 0.88, 1.41), (15.0, 1.19, 1.91), (20.0, 1.44, 2.32), (25.0, 1.65, 2.66), (45.0, 2.18, 3.52)]
    {
        for (pitch, want) in [(0.63, narrow), (0.8, wide)] {
            let quick = 1e3 * tool(l, 0.0, 0.0).ra(pitch, Cut::Section);
            assert!((quick - want).abs() < 0.0051 + 0.003 * want, "{l}, {pitch}: {quick} instead of {want}");
        }
    }
    // The exact torus over whole periods stays within a percent of the parabola there.
    for l in [12.0, 20.0, 35.0] {
        for cut in [Cut::Section, Cut::Swept] {
            let model = tool(l, 0.0, 0.0);
            let z = model.profile(0.8, 4.0, 0.001, cut).expect("a profile");
            let mean = z.heights()[..4000].iter().sum::<f64>() / 4000.0;
            let ra = z.heights()[..4000].iter().map(|h| (h - mean).abs()).sum::<f64>() / 4000.0;
            let quick = model.ra(0.8, cut);
            assert!((ra / quick - 1.0).abs() < 0.03, "{l} {cut:?}: {ra} beside {quick}");
        }
    }
}

#[test]
fn width_falls_and_roughness_rises_with_inclination() {
    let mut last: Option<(f64, f64, f64)> = None;
    for l in [8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0] {
        let model = tool(l, 0.0, 0.004);
        let (a, b) = model.strip_width(0.1, Cut::Section).expect("a width");
        assert!((a - b).abs() < 1e-9, "left and right are alike along the feed: {a} {b}");
        let z = model.profile(0.8, 4.0, 0.002, Cut::Section).expect("a profile");
        let top = z.heights().iter().copied().fold(f64::MIN, f64::max);
        let now = (a + b, model.ra(0.8, Cut::Section), top);
        if let Some(before) = last {
            assert!(now.0 < before.0 && now.1 > before.1 && now.2 > before.2, "{l}: {now:?} after {before:?}");
        }
        last = Some(now);
    }
}

#[test]
fn the_section_is_widest_and_smoothest_without_tilt() {
    let at = |w: f64| {
        let model = tool(20.0, w, 0.004);
        let (a, b) = model.strip_width(0.1, Cut::Section).expect("a width");
        (a + b, model.ra(0.8, Cut::Section))
    };
    let (width, ra) = at(0.0);
    let mut last = (width, ra);
    for w in [5.0, 10.0, 20.0, 35.0, 60.0, 90.0] {
        let now = at(w);
        assert!(now.0 < last.0 && now.1 > last.1, "{w}: {now:?} after {last:?}");
        let mirrored = at(-w);
        assert!((mirrored.0 - now.0).abs() < 1e-9 && (mirrored.1 - now.1).abs() < 1e-12);
        last = now;
    }
    // Left and right change places with the side of the tilt.
    let (a, b) = tool(20.0, 15.0, 0.0).strip_width(0.1, Cut::Section).expect("a width");
    let (c, d) = tool(20.0, -15.0, 0.0).strip_width(0.1, Cut::Section).expect("a width");
    assert!((a - d).abs() < 1e-9 && (b - c).abs() < 1e-9 && a < b);
}

#[test]
fn concave_surfaces_are_smoother_and_stops_add_the_marks_of_the_teeth() {
    let ra: Vec<f64> = [-0.02, 0.0, 0.02, 0.05].iter().map(|c| tool(20.0, 0.0, *c).ra(0.8, Cut::Swept)).collect();
    assert!(ra.windows(2).all(|w| w[1] < w[0]), "{ra:?}");
    for c in [-0.02, 0.02] {
        let model = tool(20.0, 0.0, c);
        let z = model.profile(0.8, 4.0, 0.002, Cut::Swept).expect("a profile");
        let top = z.heights().iter().copied().fold(f64::MIN, f64::max);
        assert!((top / model.ridge_height(0.8, Cut::Swept) - 1.0).abs() < 0.03, "{c}: {top}");
    }
    // Feed per tooth 0.0417 mm: at most f^2 / (8 r) = 0.07 um more, and never less.
    let model = tool(20.0, 10.0, 0.0);
    let swept = model.profile(0.8, 2.0, 0.002, Cut::Swept).expect("a profile");
    let stops = model.profile(0.8, 2.0, 0.002, Cut::Stops(0.0417)).expect("a profile");
    let limit = 0.0417_f64.powi(2) / (8.0 * 3.0) * 1.05;
    let (mut least, mut most) = (f64::MAX, f64::MIN);
    for (a, b) in swept.heights().iter().zip(stops.heights()) {
        least = least.min(b - a);
        most = most.max(b - a);
    }
    assert!(least > -1e-11 && most <= limit && most > 0.5 * limit, "{least} {most} {limit}");
}

#[test]
fn the_profile_goes_through_the_report() {
    let z = tool(20.0, 0.0, 0.0).profile(0.6, 5.6, 0.0005, Cut::Swept).expect("a profile");
    let report = ProfileReport::of(&z, &Asked { to_lay: Some(90.0), pitch: Some(0.6), ..Asked::default() });
    let (filtered, raw) = (report.filtered.expect("evaluated"), report.unfiltered);
    // A cut-off of 0.8 mm takes the Ra of such a profile to 0.72 at 0.6 mm.
    assert!((filtered.ra_um / raw.ra_um - 0.72).abs() < 0.01, "{report}");
}

#[test]
fn what_the_model_does_not_hold_is_refused() {
    let angle = PI / 9.0;
    assert!(matches!(Dong::new(5.0, 6.0, angle, 0.0, 0.0), Err(DongError::Tool { .. })));
    assert!(matches!(Dong::new(5.0, 3.0, 0.0, 0.0, 0.0), Err(DongError::Inclination(_))));
    assert!(matches!(Dong::new(5.0, 3.0, angle, f64::NAN, 0.0), Err(DongError::Number { .. })));
    assert!(matches!(Dong::new(5.0, 3.0, angle, 0.0, 0.2), Err(DongError::Gouge { .. })));
    let model = tool(20.0, 0.0, 0.0);
    assert!(matches!(model.profile(30.0, 60.0, 0.1, Cut::Section), Err(DongError::Apart { .. })));
    assert!(matches!(model.profile(0.8, -1.0, 0.1, Cut::Section), Err(DongError::Length { .. })));
    assert!(matches!(model.profile(0.8, 4.0, 0.1, Cut::Stops(0.0)), Err(DongError::Length { .. })));
    assert_eq!(model.strip_width(50.0, Cut::Section), None);
}
