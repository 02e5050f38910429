//! Contacts of cutters on surfaces with closed forms: positions against golden numbers, errors between
//! contacts against dense evaluation, curvatures of the envelope against the envelope itself.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use proveout_blade::{ClosedSurface, Domain, Local, Lu, ParametricSurface, Sine};
use proveout_geom::{Point, Vector};
use proveout_path::{
    AxisRule, Line, ParameterCurve, PathCutter, PathError, PathPoint, Sampler, StepRule, envelope_across,
};
use proveout_tool::{Apt, Cutter};

/// A torus about z with the hole's radius `big`, u round the tube, v round the axis.
#[derive(Debug)]
struct Torus {
    big: f64,
    small: f64,
}

impl ParametricSurface for Torus {
    fn domain(&self) -> Domain {
        Domain { u: [-3.0, 3.0], v: [0.0, 3.0], u_closed: false }
    }
    fn local(&self, u: f64, v: f64) -> Local {
        let (su, cu, sv, cv) = (u.sin(), u.cos(), v.sin(), v.cos());
        let w = self.big + self.small * cu;
        let radial = Vector::new(cv, sv, 0.0);
        let about = Vector::new(-sv, cv, 0.0);
        Local {
            point: Point::from(radial * w + Vector::z() * (self.small * su)),
            normal: radial * cu + Vector::z() * su,
            first: [(Vector::z() * cu - radial * su) * self.small, about * w],
            second: [-(radial * cu + Vector::z() * su) * self.small, about * (-self.small * su), -radial * w],
        }
    }
    fn nearest(&self, p: &Point) -> [f64; 2] {
        [p.z.atan2(p.x.hypot(p.y) - self.big), p.y.atan2(p.x)]
    }
}

fn cutter(cutter: &Cutter, flutes: f64) -> PathCutter {
    PathCutter::new(cutter.bodies(flutes).unwrap().remove(0))
}

fn cutters() -> Vec<(&'static str, PathCutter)> {
    let apt = Apt {
        diameter: 12.0,
        corner_radius: 2.0,
        center_radius: 4.2,
        center_height: 2.3,
        lower_angle_deg: 5.0,
        upper_angle_deg: 6.0,
        height: 25.0,
    };
    vec![
        ("ball", cutter(&Cutter::ball(6.0).unwrap(), 15.0)),
        ("bull-nose", cutter(&Cutter::bull_nose(10.0, 3.0).unwrap(), 15.0)),
        ("wheel", cutter(&Cutter::drum_wheel(38.0, 1.5, 0.0, 3.0).unwrap(), 3.0)),
        ("barrel", cutter(&Cutter::barrel(10.0, 2.0, 60.0, 20.0).unwrap(), 20.0)),
        ("lens", cutter(&Cutter::lens(12.0, 30.0, 1.0).unwrap(), 10.0)),
        ("apt", cutter(&Cutter::apt(&apt).unwrap(), 20.0)),
    ]
}

#[test]
fn wheels_stand_where_the_golden_numbers_say() {
    let golden = include_str!("data/singularity_golden_wheel.csv");
    let mut rows = 0;
    for line in golden.lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(|n| n.trim().parse().unwrap()).collect();
        let wheel = cutter(&Cutter::drum_wheel(v[0], v[1], 0.0, 2.0 * v[1]).unwrap(), 2.0 * v[1]);
        let normal = Vector::new(v[5], v[6], v[7]);
        let feed = normal.cross(&Vector::new(0.3, 0.5, -0.8)).normalize();
        let place = PathPoint {
            t: 0.0,
            uv: [0.0; 2],
            point: Point::new(v[2], v[3], v[4]),
            normal,
            feed,
            across: normal.cross(&feed),
            speed: 1.0,
            path_curvature: 0.0,
            form: [0.0; 3],
        };
        let touch = wheel.touch(&place, &Vector::new(v[8], v[9], v[10]), 0.0, None);
        assert!((touch.pose.tip - Point::new(v[11], v[12], v[13])).norm() < 1e-9, "{line}: {:?}", touch.pose.tip);
        assert!(wheel.gap(&touch.pose, &place.point, &normal).abs() < 1e-9);
        rows += 1;
    }
    assert_eq!(rows, 8);
}

/// Every cutter touches the tangent plane from outside: no point of its skin lies below it, and the contact
/// lies on its skin.
#[test]
fn cutters_touch_and_do_not_cross_the_tangent_plane() {
    let torus = Torus { big: 60.0, small: 25.0 };
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for (name, cutter) in cutters() {
        for round in 0..300 {
            let from = [5.0 * random() - 2.5, 3.0 * random()];
            let curve = ParameterCurve::straight(from, [from[0] + random() - 0.5, from[1] + random()]).unwrap();
            let place = PathPoint::on(&torus, &curve, random());
            // Corners of the generator: along the normal, and at right angles to it.
            let lean = match round % 10 {
                0 => 0.0,
                1 => std::f64::consts::FRAC_PI_2,
                _ => 1.5 * random(),
            };
            let turn = 6.3 * random();
            let axis = place.normal * lean.cos() + (place.feed * turn.cos() + place.across * turn.sin()) * lean.sin();
            let touch = cutter.touch(&place, &axis, 0.3, None);
            let contact = place.point + place.normal * 0.3;
            assert!(cutter.gap(&touch.pose, &contact, &place.normal).abs() < 1e-11, "{name}");
            let d = contact - touch.pose.tip;
            let z = d.dot(&axis);
            let r = (d - axis * z).norm();
            assert!(cutter.profile().signed_distance([r, z]).abs() < 1e-9, "{name} {lean}: contact off the skin");
            for p in cutter.profile().polyline(1e-3) {
                // The lowest point of the parallel at this height.
                let sine = (place.normal - axis * place.normal.dot(&axis)).norm();
                let height =
                    (touch.pose.tip - contact).dot(&place.normal) + p[1] * axis.dot(&place.normal) - p[0] * sine;
                assert!(height > -1e-9, "{name} {lean}: {height}");
            }
        }
    }
}

fn rules() -> Vec<AxisRule> {
    vec![
        AxisRule::Normal,
        AxisRule::LeadTilt { lead: 0.2, tilt: -0.3 },
        AxisRule::InclinationTilt { inclination: 0.4, tilt: 1.0 },
        AxisRule::FixedHead { table: Vector::x(), head: 0.1, lead: 0.25 },
    ]
}

/// Dense evaluation of the gap and the chord between contacts: 64 places for each step instead of the one to
/// three that the planner looks at.
#[test]
fn the_chord_error_holds_between_all_contacts() {
    let lu = ClosedSurface::new(Lu::stand_in());
    let sine = ClosedSurface::new(Sine::gentle());
    let torus = Torus { big: 60.0, small: 25.0 };
    let cases: [(&dyn ParametricSurface, [f64; 2], [f64; 2]); 5] = [
        (&lu, [0.4, 0.02], [2.6, 0.9]),
        (&lu, [2.6, 0.3], [3.7, 0.35]), // round the leading edge
        (&sine, [3.0, 2.0], [25.0, 78.0]),
        (&torus, [-2.0, 0.1], [2.0, 2.5]),
        (&torus, [0.0, 0.1], [0.0, 2.5]),
    ];
    let ball = cutter(&Cutter::ball(6.0).unwrap(), 15.0);
    let bull = cutter(&Cutter::bull_nose(8.0, 2.0).unwrap(), 15.0);
    let mut most_used = 0.0_f64;
    for (surface, from, to) in cases {
        for (which, cutter) in [(0, &ball), (1, &bull)] {
            for rule in rules() {
                for error in [1e-4, 1e-3, 0.02] {
                    let line = Line::new("test".into(), ParameterCurve::straight(from, to).unwrap());
                    let step = StepRule::Chord { error, longest: 5.0 };
                    let sampler = Sampler { surface, cutter, rule: &rule, step };
                    let path = match sampler.line(&line) {
                        Ok(path) => path,
                        // A bull-nose mill along the normal of a hollow touches with its rim: that is
                        // refused, not planned.
                        Err(PathError::CutterTooLarge { .. }) if which == 1 => continue,
                        Err(e) => panic!("{e}"),
                    };
                    let mut worst = 0.0_f64;
                    for pair in path.contacts.windows(2) {
                        let chord = pair[1].place.point - pair[0].place.point;
                        assert!(chord.norm() <= 5.01);
                        let mut here = 0.0_f64;
                        for k in 1..64 {
                            let t = pair[0].place.t + (pair[1].place.t - pair[0].place.t) * f64::from(k) / 64.0;
                            let place = PathPoint::on(surface, &line.curve, t);
                            let way = place.point - pair[0].place.point;
                            let part = way.dot(&chord) / chord.norm_squared();
                            let pose = pair[0].touch.pose.interpolated(&pair[1].touch.pose, part);
                            let gap = cutter.gap(&pose, &place.point, &place.normal);
                            here = here.max(gap.abs()).max((way - chord * part).norm());
                        }
                        assert!(here <= error, "{surface:?} {rule:?} {error}: {here}");
                        // What the plan says of itself is what it is, within the fourth that its places may
                        // miss.
                        assert!(here <= 1.25 * pair[1].chord_error + 0.12 * error, "{here} {}", pair[1].chord_error);
                        worst = worst.max(here);
                    }
                    most_used = most_used.max(worst / error);
                }
            }
        }
    }
    assert!(most_used > 0.7, "steps are far shorter than the error allows: {most_used}");
}

/// The curvature across the feed of what a moving cutter leaves, against the cutter itself: lowest points of
/// many poses.
#[test]
fn the_envelope_across_the_feed_is_that_of_the_moving_cutter() {
    let torus = Torus { big: 60.0, small: 25.0 };
    let curve = ParameterCurve::straight([-0.6, 0.5], [0.9, 1.1]).unwrap();
    for (name, cutter) in cutters().into_iter().filter(|(name, _)| *name != "barrel") {
        for rule in
            [AxisRule::LeadTilt { lead: 0.3, tilt: 0.2 }, AxisRule::InclinationTilt { inclination: 0.5, tilt: 0.8 }]
        {
            let line = Line::new("test".into(), curve.clone());
            let at = PathPoint::on(&torus, &curve, 0.5);
            let pose = |t: f64| {
                let place = PathPoint::on(&torus, &line.curve, t);
                cutter.touch(&place, &rule.axis(&place, t).unwrap(), 0.0, None)
            };
            let here = pose(0.5);
            let Some(envelope) = envelope_across(&here.form, &at.form) else { continue };
            // Height of the cutter over the tangent plane above a point x across the feed, least over all
            // poses.
            let height = |x: f64| {
                let foot = at.point + at.across * x;
                (-4000..=4000)
                    .map(|k| {
                        let pose = pose(0.5 + f64::from(k) * 2e-6 * 4.0).pose;
                        // Along the normal line through the foot: where it meets the skin, by bisection of
                        // the distance.
                        let distance = |h: f64| {
                            let d = foot + at.normal * h - pose.tip;
                            let z = d.dot(&pose.axis);
                            cutter.profile().signed_distance([(d - pose.axis * z).norm(), z])
                        };
                        let (mut low, mut high) = (-0.02, 0.05);
                        for _ in 0..44 {
                            let middle = 0.5 * (low + high);
                            if distance(middle) > 0.0 { low = middle } else { high = middle }
                        }
                        low
                    })
                    .fold(f64::MAX, f64::min)
            };
            let x = 0.08;
            let measured = (height(x) + height(-x)) / (x * x);
            assert!(
                (measured - envelope).abs() < 0.02 * envelope.abs() + 1e-3,
                "{name} {rule:?}: {measured} {envelope}"
            );
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_with_its_place() {
    // The troughs of the sine have a radius of 6.75 mm.
    let sine = ClosedSurface::new(Sine::gentle());
    let across = Line::new("across".into(), ParameterCurve::straight([15.0, 10.0], [15.0, 70.0]).unwrap());
    let step = StepRule::Chord { error: 0.005, longest: 2.0 };
    let rule = AxisRule::Normal;
    for (diameter, fits) in [(13.4, true), (13.6, false)] {
        let cutter = cutter(&Cutter::ball(diameter).unwrap(), 20.0);
        let sampler = Sampler { surface: &sine, cutter: &cutter, rule: &rule, step };
        match sampler.line(&across) {
            Ok(_) => assert!(fits, "{diameter}"),
            Err(PathError::CutterTooLarge { at, cutter_1_mm, surface_1_mm }) => {
                assert!(!fits && (cutter_1_mm - 2.0 / diameter).abs() < 1e-12 && surface_1_mm > 0.147, "{cutter_1_mm}");
                // The trough lies in the middle, at y = 0, 40 or 80 mm.
                assert!((at.point[1] - 40.0).abs() < 3.0 && (at.section - 0.5).abs() < 0.05, "{at}");
            }
            Err(e) => panic!("{e}"),
        }
    }
    let ball = cutter(&Cutter::ball(6.0).unwrap(), 20.0);
    let long = Sampler { surface: &sine, cutter: &ball, rule: &rule, step: StepRule::Length(9.0) };
    let message = long.line(&across).unwrap_err();
    assert!(
        matches!(message, PathError::StepLongerThanRadius { step_mm, radius_mm, .. } if step_mm > radius_mm),
        "{message}"
    );
    let head = AxisRule::FixedHead { table: Vector::z(), head: 0.1, lead: 0.0 };
    let fixed = Sampler { surface: &sine, cutter: &ball, rule: &head, step };
    assert!(matches!(
        fixed.line(&Line::new("crest".into(), ParameterCurve::straight([1.0, 20.0], [9.0, 20.0]).unwrap())),
        Err(PathError::NoAxis { .. })
    ));
}
