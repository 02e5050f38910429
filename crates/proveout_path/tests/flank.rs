//! Flanks on ruled sides with closed forms, against dense evaluation; axis rules against their definitions.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::f64::consts::FRAC_PI_2;

use proveout_blade::{
    Blade, BladeSpec, CamberSection, CamberSide, ClosedSurface, Cui, Domain, Local, Lu, ParametricSurface,
};
use proveout_geom::{Point, Vector, rad};
use proveout_path::{
    AxisRule, Flank, LineContacts, ParameterCurve, PathCutter, PathError, PathPoint, Rulings, StepRule, Task,
};
use proveout_tool::{Apt, Cutter};

fn cutter(cutter: &Cutter, flutes: f64) -> PathCutter {
    PathCutter::new(cutter.bodies(flutes).unwrap().remove(0))
}

fn cylinder() -> PathCutter {
    cutter(&Cutter::bull_nose(12.0, 0.5).unwrap(), 40.0)
}

/// Half angle of 5 degrees above a corner of 1 mm, which is tangent to the bottom and, but for a nanometer,
/// to the flank.
fn cone() -> Apt {
    let (sine, cosine) = rad(5.0).sin_cos();
    Apt {
        diameter: 10.0,
        corner_radius: 1.0,
        center_radius: 5.0 + (sine - 1.0) / cosine + 1e-6,
        center_height: 1.0,
        lower_angle_deg: 0.0,
        upper_angle_deg: 5.0,
        height: 60.0,
    }
}

fn flank(rulings: Rulings, round: [f64; 2], along: [f64; 2], limit: f64) -> Flank {
    Flank { rulings, round, along, below: 1.0, limit }
}

const QUARTERS: AxisRule = AxisRule::Ruling { points: [0.25, 0.75] };

fn plan(
    surface: &dyn ParametricSurface,
    cutter: &PathCutter,
    allowance: f64,
    flank: &Flank,
) -> Result<Vec<LineContacts>, PathError> {
    let step = StepRule::Chord { error: 0.001, longest: 2.0 };
    Task { surface, cutter, rule: &QUARTERS, step, allowance }.plan(flank)
}

/// How deep the side of rulings along u is in the cutter, over the whole ruling and 2 mm around it, by
/// the widths of the profile.
fn dense(surface: &dyn ParametricSurface, cutter: &PathCutter, line: &LineContacts, k: usize) -> f64 {
    let contact = &line.contacts[k];
    let [low, high] = surface.domain().u;
    let pose = contact.touch.pose;
    let mut deepest = 0.0_f64;
    for i in 0..=800 {
        for j in 0..=200 {
            let u = low + (high - low) * f64::from(j) / 200.0;
            let off = surface.local(u, contact.place.uv[1] + f64::from(i - 400) / 200.0).point - pose.tip;
            let z = off.dot(&pose.axis);
            let r = (off - pose.axis * z).norm();
            let Some(skin) = cutter.profile().radius_at(z) else { continue };
            deepest = deepest.max(skin - r);
        }
    }
    deepest
}

#[test]
fn the_flank_touches_a_developable_side_along_its_rulings() {
    let section = CamberSection::stand_in();
    let side = CamberSide::new(Blade::new(BladeSpec { section, length: 30.0, twist: 0.0, platform: None }).unwrap());
    for (name, cutter) in [("cylinder", cylinder()), ("cone", cutter(&Cutter::apt(&cone()).unwrap(), 60.0))] {
        // Convex side and both ends of the blade's length; concave side by a cutter that its hollow takes.
        for (round, allowance) in [([0.6, 0.9], 0.0), ([0.6, 0.9], 0.3), ([0.1, 0.4], 0.0)] {
            let lines = plan(&side, &cutter, allowance, &flank(Rulings::Along, round, [0.1, 0.9], 1e-4)).unwrap();
            assert!(lines.len() == 1 && lines[0].contacts.len() > 10, "{name}");
            for contact in &lines[0].contacts {
                let error = contact.flank.unwrap();
                assert!(error.gouge < 1e-7 && error.left < 1e-7 && error.twist < 1e-12, "{name} {error:?}");
                // The axis is off by the radius, turned by the half angle of the cone.
                let angle = contact.touch.pose.axis.dot(&contact.place.normal).asin();
                let half = if name == "cone" { rad(5.0) } else { 0.0 };
                assert!((angle - half).abs() < 1e-9, "{name} {angle}");
                assert!(contact.chord_error <= 0.001);
            }
        }
    }
}

/// The twisted face: its normals turn by psi over the ruling, `tan(psi / 2) = w p / 1` with the pitch p for
/// each mm, and the flank errs by about rho psi^2 / 8 of the part between the points.
#[test]
fn the_error_on_a_twisted_side_is_that_of_dense_evaluation_and_grows_with_the_square_of_the_twist() {
    let cutter = cylinder();
    let of = |half_width: f64| {
        let cui = ClosedSurface::new(Cui { half_width, twist: 0.02, ..Cui::stand_in() });
        let lines = plan(&cui, &cutter, 0.0, &flank(Rulings::Across, [0.0, 1.0], [0.3, 0.7], 0.5)).unwrap();
        let k = lines[0].contacts.len() / 2;
        let error = lines[0].contacts[k].flank.unwrap();
        let slow = dense(&cui, &cutter, &lines[0], k);
        assert!((error.gouge - slow).abs() < 1e-4 * error.gouge.max(0.01), "{half_width}: {error:?} {slow}");
        // The normal of w t + z e_z turned by twist z is at atan(w twist) from its middle.
        let twist = 2.0 * (half_width * 0.02).atan();
        assert!((error.twist - twist).abs() < 1e-6, "{error:?} {twist}");
        error.gouge.max(error.left)
    };
    let (narrow, wide) = (of(2.0), of(4.0));
    assert!((wide / narrow - 4.0).abs() < 0.4, "{narrow} {wide}");
    assert!(narrow > 1e-4, "{narrow}");
}

#[test]
fn a_flank_that_does_not_fit_is_refused_with_its_place() {
    let cutter = cylinder();
    let refusal = |surface: &dyn ParametricSurface, cutter: &PathCutter, flank: &Flank| {
        plan(surface, cutter, 0.0, flank).unwrap_err().to_string()
    };
    let cui = ClosedSurface::new(Cui { half_width: 4.0, twist: 0.02, ..Cui::stand_in() });
    let error = refusal(&cui, &cutter, &flank(Rulings::Across, [0.0, 1.0], [0.3, 0.7], 1e-4));
    assert!(error.contains("the flank of the cutter errs at section 0.3") && error.contains("turn by 9.1"), "{error}");
    // Lines along a twisted blade are no straight ones.
    let lu = ClosedSurface::new(Lu::stand_in());
    let error = refusal(&lu, &cutter, &flank(Rulings::Along, [0.1, 0.3], [0.1, 0.9], 0.01));
    assert!(error.contains("the side is not ruled"), "{error}");
    // A cutter larger than the hollow of the concave side.
    let section = CamberSection::stand_in();
    let side = CamberSide::new(Blade::new(BladeSpec { section, length: 30.0, twist: 0.0, platform: None }).unwrap());
    let large = self::cutter(&Cutter::bull_nose(160.0, 0.5).unwrap(), 40.0);
    let error = refusal(&side, &large, &flank(Rulings::Along, [0.1, 0.4], [0.1, 0.9], 0.01));
    assert!(error.contains("the flank of the cutter errs at section"), "{error}");
    // Cutters without a straight side, or with one that is too short.
    let ball = self::cutter(&Cutter::lens(12.0, 30.0, 1.0).unwrap(), 3.0);
    let error = refusal(&side, &ball, &flank(Rulings::Along, [0.6, 0.9], [0.1, 0.9], 0.01));
    assert!(error.contains("straight side"), "{error}");
    let short = self::cutter(&Cutter::bull_nose(12.0, 0.5).unwrap(), 20.0);
    let error = refusal(&side, &short, &flank(Rulings::Along, [0.6, 0.9], [0.1, 0.9], 0.01));
    assert!(error.contains("ends 20.000 mm above its tip, the ruling 25.500 mm"), "{error}");
    // The axis along the ruling belongs to the flank, and the flank to it.
    let step = StepRule::Length(1.0);
    let task = Task { surface: &side, cutter: &cutter, rule: &AxisRule::Normal, step, allowance: 0.0 };
    let error = task.plan(&flank(Rulings::Along, [0.6, 0.9], [0.1, 0.9], 0.01)).unwrap_err().to_string();
    assert!(error.contains("takes its axis from the ruling"), "{error}");
    let row = proveout_path::Row { label: proveout_path::Label::Surface, at: 0.5, trailing: 0.0, along: [0.0, 1.0] };
    let task = Task { surface: &side, cutter: &cutter, rule: &QUARTERS, step, allowance: 0.0 };
    let error = task.plan(&row).unwrap_err().to_string();
    assert!(error.contains("belongs to the flank"), "{error}");
}

/// z = 0 with the travel along x.
#[derive(Debug)]
struct Face;

impl ParametricSurface for Face {
    fn domain(&self) -> Domain {
        Domain { u: [0.0, 10.0], v: [0.0, 10.0], u_closed: false }
    }
    fn local(&self, u: f64, v: f64) -> Local {
        Local {
            point: Point::new(u, v, 0.0),
            normal: Vector::z(),
            first: [Vector::x(), Vector::y()],
            second: [Vector::zeros(); 3],
        }
    }
    fn nearest(&self, p: &Point) -> [f64; 2] {
        [p.x, p.y]
    }
}

/// Every rule on a face with n = z, f = x, k = y: axes and tips as their definitions have them, written out.
#[test]
fn axes_and_tips_on_a_face() {
    let place = PathPoint::on(&Face, &ParameterCurve::straight([2.0, 3.0], [8.0, 3.0]).unwrap(), 0.5);
    let v = |x: f64, y: f64, z: f64| Vector::new(x, y, z);
    let (l, t) = (0.3_f64, 0.2_f64);
    let (h, w) = (0.4_f64, 0.5_f64);
    let tilted = v(0.0, 0.6, 0.8);
    let half = v(0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt());
    let cases = [
        (AxisRule::Normal, v(0.0, 0.0, 1.0)),
        (AxisRule::LeadTilt { lead: l, tilt: 0.0 }, v(l.sin(), 0.0, l.cos())),
        (AxisRule::LeadTilt { lead: 0.0, tilt: t }, v(0.0, t.sin(), t.cos())),
        (AxisRule::LeadTilt { lead: l, tilt: t }, v(l.sin() * t.cos(), t.sin(), l.cos() * t.cos())),
        (AxisRule::InclinationTilt { inclination: l, tilt: 0.0 }, v(l.sin(), 0.0, l.cos())),
        (AxisRule::InclinationTilt { inclination: l, tilt: FRAC_PI_2 }, v(0.0, l.sin(), l.cos())),
        // The table turns about y: the head leans towards it by h, the rest is w towards the travel.
        (
            AxisRule::FixedHead { table: Vector::y(), head: h, lead: w },
            v(h.cos() * w.sin(), h.sin(), h.cos() * w.cos()),
        ),
        (
            AxisRule::FixedHead { table: -Vector::y(), head: h, lead: w },
            v(h.cos() * w.sin(), -h.sin(), h.cos() * w.cos()),
        ),
        // Half of the way on the great circle, and a quarter of it.
        (AxisRule::Interpolated(vec![(0.0, Vector::x()), (1.0, Vector::z())]), half),
        (AxisRule::Interpolated(vec![(0.0, Vector::z()), (0.5, tilted), (1.0, Vector::x())]), tilted),
    ];
    for (rule, wanted) in cases {
        rule.check().unwrap();
        let axis = rule.axis(&place, 0.5).unwrap();
        assert!((axis - wanted).norm() < 1e-14, "{rule:?}: {axis:?}");
    }
    // A travel along the table that leans to either side of it, or goes back, has one axis.
    let head = AxisRule::FixedHead { table: Vector::x(), head: 0.0, lead: w };
    for to in [[8.0, 3.1], [8.0, 2.9], [-8.0, 3.1], [-8.0, 2.9]] {
        let place = PathPoint::on(&Face, &ParameterCurve::straight([2.0, 3.0], to).unwrap(), 0.5);
        assert!((head.axis(&place, 0.5).unwrap() - v(0.0, -w.sin(), w.cos())).norm() < 1e-14);
    }
    assert_eq!(AxisRule::FixedHead { table: Vector::z(), head: 0.0, lead: 0.0 }.axis(&place, 0.5), None);
    // Tips for an axis that leads by l, contact (5, 3, 0): the center of the corner circle is r above it,
    // the tip below that center.
    let axis = v(l.sin(), 0.0, l.cos());
    let tip = |cutter: &Cutter, flutes: f64| self::cutter(cutter, flutes).touch(&place, &axis, 0.0, None).pose.tip;
    let near = |a: Point, b: Vector, name: &str| assert!((a.coords - b).norm() < 1e-12, "{name} {a:?} {b:?}");
    let contact = v(5.0, 3.0, 0.0);
    let up = Vector::z();
    // The part of the normal across the axis points from the axis away from the contact.
    let aside = (up - axis * axis.dot(&up)).normalize();
    near(tip(&Cutter::ball(6.0).unwrap(), 15.0), contact + up * 3.0 - axis * 3.0, "ball");
    near(tip(&Cutter::bull_nose(10.0, 2.0).unwrap(), 15.0), contact + up * 2.0 + aside * 3.0 - axis * 2.0, "bull-nose");
    let wheel = Cutter::drum_wheel(38.0, 1.5, 0.0, 3.0).unwrap();
    near(tip(&wheel, 3.0), contact + up * 1.5 + aside * 17.5 - axis * 1.5, "drum wheel");
    let apt = Apt { corner_radius: 2.0, center_radius: 3.2, center_height: 2.0, ..cone() };
    near(tip(&Cutter::apt(&apt).unwrap(), 20.0), contact + up * 2.0 + aside * 3.2 - axis * 2.0, "apt");
}
