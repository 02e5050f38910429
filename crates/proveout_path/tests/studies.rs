//! Published paths before any treatment: lines near the leading edge of Lu et al. 2022 on both of its
//! machines, and the row of Cui et al. 2022, against the figures of an independent implementation.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

use std::path::Path;

use proveout_blade::{ClosedSurface, Cui, Lu, ParametricSurface};
use proveout_geom::{Pose, Vector, rad};
use proveout_machine::Machine;
use proveout_path::{
    AxisRule, IsoParametric, IsoPlanar, Label, LineContacts, PathCutter, PathJudgement, QuasiCircle, Row, Setting,
    Spacing, StepRule, Strategy, Task, Transverse,
};
use proveout_tool::Cutter;

fn machine(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name)).expect("library machine")
}

fn ball() -> PathCutter {
    PathCutter::new(Cutter::ball(6.0).unwrap().bodies(20.0).unwrap().remove(0))
}

/// Where the span has to point: along z of the table for machine I, along y for machine II.
fn mounted(name: &str) -> (Machine, Pose) {
    let x_to_z = Pose::from_axis_angle(&Vector::y(), rad(-90.0));
    // x to y, y to z, z to x.
    let x_to_y = Pose::from_axis_angle(&Vector::z(), rad(90.0)) * Pose::from_axis_angle(&Vector::x(), rad(90.0));
    let pose = if name == "lu-serial-i" { x_to_z } else { x_to_y };
    assert_eq!(pose.vector(&Vector::x()), if name == "lu-serial-i" { Vector::z() } else { Vector::y() });
    (machine(name), pose)
}

/// Contacts every 0.05 mm, tool along the normal: what the lines ask, whatever their blocks are.
fn judged(surface: &dyn ParametricSurface, name: &str, strategy: &dyn Strategy) -> (Vec<LineContacts>, PathJudgement) {
    let (machine, pose) = mounted(name);
    let (cutter, rule) = (ball(), AxisRule::Normal);
    let task = Task { surface, cutter: &cutter, rule: &rule, step: StepRule::Length(0.05), allowance: 0.0 };
    let lines = task.plan(strategy).unwrap();
    // The joint travel of the library machines is not what this is about: the blade is where all of it is
    // in reach.
    let mut free = machine;
    for joint in &mut free.joints {
        if !joint.is_rotary() {
            joint.travel = None;
        }
    }
    let setting = Setting {
        machine: &free,
        table_from_surface: pose,
        tool_length: 0.0,
        domain: surface.domain(),
        feed: 500.0 / 60.0,
    };
    let home = free.home();
    let result = setting.judge(&lines, &home).unwrap();
    (lines, result)
}

fn iso(values: &[f64]) -> IsoParametric {
    IsoParametric { label: Label::Length, range: [0.0, 1.0], along: [0.0, 1.0], spacing: Spacing::At(values.to_vec()) }
}

fn quasi(degrees: &[f64]) -> QuasiCircle {
    QuasiCircle {
        focus_inside: 0.0,
        trailing: 0.0,
        range: [0.0, rad(360.0)],
        along: [0.0, 1.0],
        spacing: Spacing::At(degrees.iter().map(|d| rad(*d)).collect()),
    }
}

/// Largest rate of the rotary joint that turns about the span (deg/mm), its largest range on one line (deg),
/// its velocity at 500 mm/min (deg/s), and the lowest feed under 30 deg/s (mm/s).
fn figures(surface: &dyn ParametricSurface, name: &str, strategy: &dyn Strategy) -> [f64; 4] {
    let joint = if name == "lu-serial-i" { "C" } else { "B" };
    let (_, all) = judged(surface, name, strategy);
    let demand = all.joints.iter().find(|j| j.name == joint).expect("the joint about the span");
    let index = mounted(name).0.joint(joint).unwrap();
    let range = all
        .positions
        .iter()
        .map(|q| {
            let of = |f: fn(f64, f64) -> f64, start| q.iter().map(|q| q[index]).fold(start, f);
            of(f64::max, f64::MIN) - of(f64::min, f64::MAX)
        })
        .fold(0.0, f64::max);
    let rate = demand.rate.as_ref().unwrap().value.to_degrees();
    [rate, range.to_degrees(), rate * 500.0 / 60.0, 30.0 / rate]
}

fn within_a_percent(found: [f64; 4], wanted: [f64; 4]) {
    for (f, w) in found.iter().zip(wanted) {
        assert!((f - w).abs() < 0.01 * w, "{found:?} {wanted:?}");
    }
}

#[test]
fn lines_near_the_leading_edge_turn_the_joints_as_an_independent_count_has_it() {
    let lu = ClosedSurface::new(Lu::stand_in());
    for name in ["lu-hybrid-ii", "lu-serial-i"] {
        within_a_percent(figures(&lu, name, &iso(&[0.505, 0.510, 0.515])), [4.124, 142.62, 34.37, 7.275]);
        within_a_percent(figures(&lu, name, &quasi(&[175.0, 180.0, 185.0])), [0.510, 48.82, 4.25, 58.83]);
    }
    // Suprema over all lines near the edge: u = 0.5046 and 184 degrees.
    let most = |s: &dyn Strategy| figures(&lu, "lu-hybrid-ii", s)[0];
    let sweep: Vec<f64> = (0..=24).map(|k| 0.5034 + 0.0001 * f64::from(k)).collect();
    assert!((most(&iso(&sweep)) - 4.165).abs() < 0.01 * 4.165, "{}", most(&iso(&sweep)));
    assert!((most(&iso(&[0.5046])) - 4.165).abs() < 0.01 * 4.165);
    let sweep: Vec<f64> = (0..=16).map(|k| 182.0 + 0.25 * f64::from(k)).collect();
    assert!((most(&quasi(&sweep)) - 0.534).abs() < 0.01 * 0.534, "{}", most(&quasi(&sweep)));
}

#[test]
fn without_twist_the_turning_falls_by_92_percent() {
    let lu = ClosedSurface::new(Lu::untwisted());
    let before = figures(&lu, "lu-hybrid-ii", &iso(&[0.505, 0.510, 0.515]))[0];
    let after = figures(&lu, "lu-hybrid-ii", &quasi(&[175.0, 180.0, 185.0]))[0];
    assert!((before - 3.839).abs() < 0.04 && (after - 0.298).abs() < 0.003, "{before} {after}");
    let fall = 100.0 * (1.0 - after / before);
    assert!((fall - 92.0).abs() < 0.5, "{fall}");
}

/// The edges have theta 0 and 180 degrees in every section, exactly.
#[test]
fn quasi_circle_lines_stay_on_the_edge() {
    let lu = ClosedSurface::new(Lu::stand_in());
    let sections = proveout_path::Sections::new(&lu, Label::PolarAngle { focus_inside: 0.0 }, [0.0, 1.0], 101, 0.0);
    let sections = sections.unwrap();
    for (label, edge) in [(0.0, 0), (0.5, 1)] {
        let line = sections.line(label).unwrap();
        for section in sections.sections() {
            let u = line.at(section.v).u[0];
            assert!((u - section.edges[edge]).abs() < 1e-12 || (u - section.edges[edge]).abs() > 6.0, "{u}");
        }
    }
    // Monotone round the section, and the image of its label.
    for j in [0, 50, 100] {
        let mut last = -1.0;
        for k in 1..400 {
            let label = sections.label(j, std::f64::consts::TAU * f64::from(k) / 400.0);
            assert!(label > last, "{k}");
            last = label;
        }
    }
}

#[test]
fn cuis_row_before_treatment() {
    let cui = ClosedSurface::new(Cui::stand_in());
    let lean = |azimuth: f64| {
        let (s, c) = rad(azimuth).sin_cos();
        Vector::new(rad(12.0).sin() * c, rad(12.0).sin() * s, rad(12.0).cos())
    };
    let rule = AxisRule::Interpolated(vec![(0.0, lean(5.0)), (1.0, lean(175.0))]);
    let wheel = PathCutter::new(Cutter::drum_wheel(38.0, 1.5, 0.0, 3.0).unwrap().bodies(3.0).unwrap().remove(0));
    // 120 blocks over 120.05 mm of the row, 1 mm along z each.
    let task = Task { surface: &cui, cutter: &wheel, rule: &rule, step: StepRule::Length(1.001), allowance: 0.0 };
    let row = Row { label: Label::Surface, at: 0.5, trailing: 0.0, along: [1.0, 0.0] };
    let lines = task.plan(&row).unwrap();
    assert_eq!(lines[0].contacts.len(), 121);
    let polar = |c: &proveout_path::PathContact| c.touch.pose.axis.z.acos().to_degrees();
    let least = lines[0].contacts.iter().map(polar).fold(f64::MAX, f64::min);
    assert!((least - 1.06).abs() < 0.005, "{least}");
    let mut grinder = machine("bc-head-table-grinder");
    for joint in &mut grinder.joints {
        if !joint.is_rotary() {
            joint.travel = None;
        }
    }
    // The pivot is 150 mm from the tip.
    let setting = Setting {
        machine: &grinder,
        table_from_surface: Pose::identity(),
        tool_length: 150.0,
        domain: cui.domain(),
        feed: 20.0,
    };
    let judged = setting.judge(&lines, &grinder.home()).unwrap();
    let of = |name: &str| judged.joints.iter().find(|j| j.name == name).unwrap();
    let (b, c) = (of("B"), of("C"));
    assert!((c.travel.to_degrees() - 170.0).abs() < 0.01, "{}", c.travel.to_degrees());
    assert!((c.rate.as_ref().unwrap().value.to_degrees() - 10.63).abs() < 0.01, "{:?}", c.rate);
    assert_eq!(b.reversals, 1);
    assert!((judged.pole.as_ref().unwrap().value.to_degrees() - 1.06).abs() < 0.005);
    let tip = judged.tip_error_without_tcp.as_ref().unwrap().value;
    assert!((1e3 * tip - 120.8).abs() < 0.5, "{}", 1e3 * tip);
    // F1200 asks 212.6 deg/s of C.
    assert!((c.velocity(20.0).to_degrees() - 212.6).abs() < 0.3);
}

/// The other kinds as well: what a plane that cuts the edge and lines round the sections ask.
#[test]
fn other_kinds_of_path_beside_the_edge() {
    let lu = ClosedSurface::new(Lu::stand_in());
    let transverse =
        Transverse { round: [0.4, 0.6], range: [0.3, 0.6], spacing: Spacing::At(vec![0.3, 0.6]), one_way: false };
    let across = figures(&lu, "lu-hybrid-ii", &transverse)[0];
    // Round an edge with a radius of 0.1 to 0.24 mm: 57.3 / radius at least.
    assert!(across > 200.0, "{across}");
    // Planes across the chord of the root, next to the leading edge: they run along the span.
    let normal = Vector::new(0.0, rad(35.0).cos(), rad(35.0).sin());
    let planes = IsoPlanar {
        normal,
        range: [-13.0, -13.0],
        round: [0.0, 1.0],
        along: [0.0, 1.0],
        spacing: Spacing::At(vec![-13.0]),
    };
    let (lines, _) = judged(&lu, "lu-hybrid-ii", &planes);
    assert!(lines.len() >= 2);
    for line in &lines {
        for contact in &line.contacts {
            assert!(
                (contact.place.point.coords.dot(&normal) + 13.0).abs() < 2e-5,
                "{} {:?}",
                line.name,
                contact.place.point
            );
        }
    }
}
