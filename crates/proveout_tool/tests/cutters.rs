//! Each kind of cutter against closed forms, and its volume against a sum of thin disks.

use std::f64::consts::PI;

use proptest::prelude::*;
use proveout_tool::{Apt, Cutter, Profile, Role, Segment, ShapeError, ToolBuilder};

/// Volume by the midpoint rule over `radius_at`; shares nothing with the closed form of `Profile::volume`.
fn disks(p: &Profile) -> f64 {
    let n = 20_000;
    let step = (p.z_max() - p.z_min()) / f64::from(n);
    (0..n)
        .map(|i| {
            let r = p.radius_at(p.z_min() + (f64::from(i) + 0.5) * step).expect("inside");
            PI * r * r * step
        })
        .sum()
}

fn one(cutter: Result<Cutter, ShapeError>, flute: f64) -> Profile {
    let mut bodies = cutter.expect("cutter").bodies(flute).expect("bodies");
    assert_eq!(bodies.len(), 1);
    bodies.remove(0)
}

fn radii(p: &Profile, exact: impl Fn(f64) -> f64, from: f64, to: f64) {
    for i in 0..=100 {
        let z = from + (to - from) * f64::from(i) / 100.0;
        let r = p.radius_at(z).expect("inside");
        assert!((r - exact(z)).abs() < 1e-9, "z {z}: {r} against {}", exact(z));
    }
}

#[test]
fn ball() {
    let p = one(Cutter::ball(10.0), 30.0);
    radii(&p, |z| (25.0 - (z - 5.0) * (z - 5.0)).max(0.0).sqrt(), 0.0, 5.0);
    radii(&p, |_| 5.0, 5.0, 30.0);
    assert!((p.volume() - PI * (2.0 / 3.0 * 125.0 + 25.0 * 25.0)).abs() < 1e-9);
}

#[test]
fn flat() {
    let p = one(Cutter::flat(12.0), 30.0);
    radii(&p, |_| 6.0, 0.0, 30.0);
    assert!((p.volume() - PI * 36.0 * 30.0).abs() < 1e-9);
}

#[test]
fn bull_nose() {
    let p = one(Cutter::bull_nose(20.0, 3.0), 40.0);
    radii(&p, |z| 7.0 + (9.0 - (z - 3.0) * (z - 3.0)).max(0.0).sqrt(), 0.0, 3.0);
    // Quarter torus by Pappus: disk of 7, ring of a quarter circle with centroid at 4 r / (3 pi).
    let quarter = PI * 9.0 / 4.0;
    let ring = 2.0 * PI * (7.0 + 4.0 * 3.0 / (3.0 * PI)) * quarter;
    assert!((p.volume() - (PI * 49.0 * 3.0 + ring + PI * 100.0 * 37.0)).abs() < 1e-9);
}

#[test]
fn taper_ball() {
    let half = 5_f64.to_radians();
    let p = one(Cutter::taper_ball(4.0, 5.0, 10.0), 60.0);
    let tangent = 2.0 * (1.0 - half.sin());
    radii(&p, |z| (4.0 - (z - 2.0) * (z - 2.0)).max(0.0).sqrt(), 0.0, tangent);
    // Every point of the cone is 2 mm from the line that leaves the center of the ball at the half angle.
    let top = tangent + (5.0 - 2.0 * half.cos()) / half.tan();
    radii(&p, |z| (2.0 + (z - 2.0) * half.sin()) / half.cos(), tangent, top);
    radii(&p, |_| 5.0, top, 60.0);
    assert!((p.volume() / disks(&p) - 1.0).abs() < 1e-6);
}

#[test]
fn barrel_touches_its_ball_and_is_widest_at_its_diameter() {
    let p = one(Cutter::barrel(12.0, 3.0, 80.0, 25.0), 25.0);
    assert!((p.max_radius() - 6.0).abs() < 1e-12);
    let equator = 3.0 + (77.0_f64.powi(2) - 74.0_f64.powi(2)).sqrt();
    radii(&p, |z| (80.0_f64.powi(2) - (z - equator).powi(2)).sqrt() - 74.0, 5.0, 25.0);
    assert!((p.volume() / disks(&p) - 1.0).abs() < 1e-6);
}

#[test]
fn oval_runs_into_its_cylinder_without_a_corner() {
    let p = one(Cutter::oval(10.0, 2.0, 60.0), 30.0);
    let equator = 2.0 + (58.0_f64.powi(2) - 55.0_f64.powi(2)).sqrt();
    assert!((p.max_radius() - 5.0).abs() < 1e-12);
    radii(&p, |z| (3600.0 - (z - equator).powi(2)).sqrt() - 55.0, 3.0, equator);
    radii(&p, |_| 5.0, equator, 30.0);
    // Normal and curvature just below and above the equator: the same direction, 1 / 60 and 0.
    let (below, above) = (p.nearest([7.0, equator - 1e-6]), p.nearest([7.0, equator + 1e-6]));
    assert!((below.normal[0] - 1.0).abs() < 1e-9 && (above.normal[0] - 1.0).abs() < 1e-9);
    assert!((below.curvature - 1.0 / 60.0).abs() < 1e-12 && above.curvature == 0.0);
    assert!((p.nearest([0.0, -1.0]).curvature - 0.5).abs() < 1e-12, "the tip is the ball");
    assert!((p.volume() / disks(&p) - 1.0).abs() < 1e-6);
    assert!(Cutter::oval(10.0, 5.0, 60.0).is_err() && Cutter::oval(10.0, 2.0, 5.0).is_err());
}

#[test]
fn a_drum_wheel_is_the_same_from_above_and_below() {
    for corner in [0.0, 0.5] {
        let p = one(Cutter::drum_wheel(40.0, 30.0, corner, 8.0), 8.0);
        assert!((p.max_radius() - 20.0).abs() < 1e-12);
        radii(&p, |z| (900.0 - (z - 4.0).powi(2)).sqrt() - 10.0, 0.7, 7.3);
        for k in 0..40 {
            let z = 0.1 * f64::from(k) + 0.01;
            let (a, b) = (p.radius_at(z).expect("inside"), p.radius_at(8.0 - z).expect("inside"));
            assert!((a - b).abs() < 1e-9);
        }
        assert!((p.volume() / disks(&p) - 1.0).abs() < 1e-5);
    }
    assert!(Cutter::drum_wheel(40.0, 3.0, 0.5, 8.0).is_err(), "a rim below half of the height");
    assert!(Cutter::drum_wheel(40.0, 30.0, 4.0, 8.0).is_err(), "corners that meet");
    assert!(Cutter::drum_wheel(2.0, 30.0, 0.0, 60.0).is_err(), "the rim comes to the axis");
}

#[test]
fn lens() {
    let p = one(Cutter::lens(16.0, 60.0, 1.0), 20.0);
    radii(&p, |z| (3600.0 - (z - 60.0) * (z - 60.0)).max(0.0).sqrt(), 0.0, 0.3);
    assert!((p.max_radius() - 8.0).abs() < 1e-12);
    assert!((p.volume() / disks(&p) - 1.0).abs() < 1e-6);
    let sharp = one(Cutter::lens(16.0, 60.0, 0.0), 20.0);
    let rim = 60.0 - (3600.0_f64 - 64.0).sqrt();
    assert!((sharp.volume() - PI * (rim * rim * (60.0 - rim / 3.0) + 64.0 * (20.0 - rim))).abs() < 1e-9);
}

#[test]
fn drill_and_chamfer() {
    let p = one(Cutter::drill(10.0, 118.0), 50.0);
    let tip = 5.0 / 59_f64.to_radians().tan();
    radii(&p, |z| z * 59_f64.to_radians().tan(), 0.0, tip);
    assert!((p.volume() - PI * 25.0 * (tip / 3.0 + 50.0 - tip)).abs() < 1e-9);
    let p = one(Cutter::chamfer(8.0, 90.0, 1.0), 6.0);
    radii(&p, |z| 0.5 + z, 0.0, 3.5);
    assert!((p.volume() - PI * (3.5 * (0.25 + 2.0 + 16.0) / 3.0 + 16.0 * 2.5)).abs() < 1e-9);
}

#[test]
fn face_mill_meets_its_diameter_at_the_face() {
    let p = one(Cutter::face_mill(50.0, 0.0, 45.0, 4.0), 4.0);
    radii(&p, |z| 25.0 + z, 0.0, 4.0);
    let p = one(Cutter::face_mill(50.0, 0.8, 90.0, 4.0), 4.0);
    radii(&p, |_| 25.0, 0.8, 4.0);
}

#[test]
fn apt_covers_the_named_kinds() {
    let apt = |d, r, e, f, a, b, h| {
        one(
            Cutter::apt(&Apt {
                diameter: d,
                corner_radius: r,
                center_radius: e,
                center_height: f,
                lower_angle_deg: a,
                upper_angle_deg: b,
                height: h,
            }),
            h,
        )
    };
    let same = |a: &Profile, b: &Profile| {
        for i in 0..=200 {
            let z = a.z_max() * f64::from(i) / 200.0;
            let (x, y) = (a.radius_at(z).expect("in a"), b.radius_at(z).expect("in b"));
            assert!((x - y).abs() < 1e-9, "z {z}: {x} {y}");
        }
    };
    same(&apt(10.0, 5.0, 0.0, 5.0, 0.0, 0.0, 30.0), &one(Cutter::ball(10.0), 30.0));
    same(&apt(12.0, 0.0, 6.0, 0.0, 0.0, 0.0, 30.0), &one(Cutter::flat(12.0), 30.0));
    same(&apt(20.0, 3.0, 7.0, 3.0, 0.0, 0.0, 40.0), &one(Cutter::bull_nose(20.0, 3.0), 40.0));
    same(&apt(10.0, 0.0, 0.0, 0.0, 31.0, 0.0, 50.0), &one(Cutter::drill(10.0, 118.0), 50.0));
    // Tapered ball: the upper line is tangent to the ball and meets the plane of the tip at D/2.
    let half = 5_f64.to_radians();
    let foot = 2.0 / half.cos() - 2.0 * half.tan();
    same(&apt(2.0 * foot, 2.0, 0.0, 2.0, 0.0, 5.0, 30.0), &one(Cutter::taper_ball(4.0, 5.0, 10.0), 30.0));
}

#[test]
fn apt_refuses_what_is_no_convex_cutter() {
    let base = Apt {
        diameter: 20.0,
        corner_radius: 3.0,
        center_radius: 7.0,
        center_height: 3.0,
        lower_angle_deg: 0.0,
        upper_angle_deg: 0.0,
        height: 40.0,
    };
    let key = |a: Apt| match Cutter::apt(&a) {
        Err(ShapeError::Dimension { key, .. }) => key,
        other => panic!("expected a refused dimension, got {other:?}"),
    };
    assert_eq!(key(Apt { corner_radius: 2.0, ..base }), "corner_radius_mm");
    assert_eq!(key(Apt { height: 2.0, ..base }), "cutter_height_mm");
    assert_eq!(key(Apt { upper_angle_deg: -60.0, ..base }), "cutter_height_mm");
    assert_eq!(key(Apt { lower_angle_deg: 90.0, ..base }), "lower_angle_deg");
    assert_eq!(key(Apt { diameter: f64::NAN, ..base }), "diameter_mm");
    assert_eq!(key(Apt { diameter: -1.0, ..base }), "diameter_mm");
}

#[test]
fn a_free_profile_may_be_concave_and_must_not_fall() {
    let line = |from, to| Segment::Line { from, to };
    let lollipop = [
        Segment::Arc { center: [0.0, 5.0], radius: 5.0, from: [0.0, 0.0], to: [3.0, 9.0] },
        line([3.0, 9.0], [3.0, 30.0]),
    ];
    let bodies = Cutter::profile(&lollipop).expect("cutter").bodies(30.0).expect("bodies");
    assert_eq!(bodies.len(), 2);
    // Ball without its cap of height 1, then the stem.
    let cap = PI * (5.0 - 1.0 / 3.0);
    let exact = 4.0 / 3.0 * PI * 125.0 - cap + PI * 9.0 * 21.0;
    assert!((bodies.iter().map(Profile::volume).sum::<f64>() - exact).abs() < 1e-9);
    let falling = [line([0.0, 0.0], [3.0, 2.0]), line([3.0, 2.0], [5.0, 1.0])];
    assert!(Cutter::profile(&falling).is_err());
}

#[test]
fn an_assembly_is_contiguous_from_tip_to_gauge_line() {
    let section = |diameter, top_diameter, length| proveout_tool::HolderSection { diameter, top_diameter, length };
    let tool = ToolBuilder::new(1, "T", Cutter::ball(4.0).expect("ball"), 8.0, 100.0)
        .neck(3.8, 12.0)
        .transition(4.0)
        .shank(6.0)
        .overall_length(60.0)
        .holder([section(28.0, 28.0, 20.0), section(32.0, 40.0, 30.0), section(63.0, 63.0, 10.0)])
        .build()
        .expect("tool");
    let mut z = 0.0;
    for b in &tool.bodies {
        assert!((b.profile.z_min() - z).abs() < 1e-12, "gap at {z}");
        z = b.profile.z_max();
    }
    assert_eq!(z, 100.0);
    assert!(tool.has_holder);
    let top = |role| tool.bodies.iter().filter(|b| b.role == role).map(|b| b.profile.z_max()).fold(0.0, f64::max);
    assert_eq!(top(Role::Cutting), 8.0);
    assert_eq!(top(Role::Neck), 20.0);
    assert_eq!(top(Role::Shank), 40.0);
    assert_eq!(top(Role::Holder), 100.0);
}

#[test]
fn the_cone_of_a_cutter_above_its_flutes_is_neck() {
    let tool = ToolBuilder::new(1, "T", Cutter::chamfer(8.0, 90.0, 0.0).expect("cutter"), 2.0, 60.0)
        .shank(8.0)
        .build()
        .expect("tool");
    let shape: Vec<_> = tool.bodies.iter().map(|b| (b.role, b.profile.z_min(), b.profile.z_max())).collect();
    assert_eq!(shape, [(Role::Cutting, 0.0, 2.0), (Role::Neck, 2.0, 4.0), (Role::Shank, 4.0, 60.0)]);
    assert!(!tool.has_holder);
    let plain = ToolBuilder::new(1, "T", Cutter::flat(8.0).expect("cutter"), 20.0, 60.0).build().expect("tool");
    let shape: Vec<_> = plain.bodies.iter().map(|b| (b.role, b.profile.z_min(), b.profile.z_max())).collect();
    assert_eq!(shape, [(Role::Cutting, 0.0, 20.0), (Role::Neck, 20.0, 60.0)]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever the numbers, a cutter is refused or is a set of convex bodies whose closed-form volume is the
    /// sum of disks.
    #[test]
    fn any_apt_cutter_is_refused_or_sound(
        d in 0.1..80.0, r in 0.0..60.0, e in -80.0..40.0, f in 0.0..60.0, a in 0.0..89.0, b in -89.0..89.0, h in 0.1..90.0,
    ) {
        let apt = Apt { diameter: d, corner_radius: r, center_radius: e, center_height: f, lower_angle_deg: a,
                        upper_angle_deg: b, height: h };
        if let Ok(cutter) = Cutter::apt(&apt) {
            for body in cutter.bodies(h).expect("bodies of an accepted cutter") {
                // Disks near an end with a vertical tangent converge slowly: 1e-4 of the volume, or 1e-6 mm3.
                let exact = body.volume();
                prop_assert!((exact - disks(&body)).abs() < 1e-4 * exact + 1e-6, "{apt:?}: {exact} {}", disks(&body));
            }
        }
    }

    #[test]
    fn any_bull_nose_keeps_its_distances(d in 0.5..60.0, share in 0.01..0.99, z in 0.0..1.0) {
        let r: f64 = 0.5 * d * share;
        let p = one(Cutter::bull_nose(d, r), d);
        let h: f64 = z * d;
        let inset = if h < r { r - (r * r - (r - h) * (r - h)).sqrt() } else { 0.0 };
        let radius = p.radius_at(h).expect("inside");
        prop_assert!((radius - (0.5 * d - inset)).abs() < 1e-9);
    }
}
