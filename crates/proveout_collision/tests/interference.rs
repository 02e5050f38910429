//! Interference against dense sampling by an oracle that shares no code: points on the tool's surface, placed
//! by the forward kinematics of the machine, against closed-form distances of boxes.

use std::f64::consts::TAU;
use std::path::Path;

use proveout_collision::{CollisionError, Fixture, Interference, PartKind, Severity, Unchecked};
use proveout_geom::{Aabb, Point, Pose, ToolPose, TriMesh, Vector, box_mesh, cylinder_mesh, rad};
use proveout_machine::{Attachment, JointValues, Machine, MachineBody};
use proveout_tool::{Cutter, HolderSection, Tool, ToolBuilder};

use crate::common::Random;

/// X Y Z in the tool, B and C in the table; gauge line at the machine zero with all joints at zero.
fn machine() -> Machine {
    let linear = |name: &str, parent: &str, direction: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\n\
             direction = {direction}\ntravel_mm = [-1000, 1000]\n"
        )
    };
    let rotary = |name: &str, parent: &str, direction: &str, point: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"{parent}\"\n\
             direction = {direction}\npoint_mm = {point}\nsense = -1\n"
        )
    };
    let text = [
        "name = \"test\"\n".to_owned(),
        linear("X", "base", "[1, 0, 0]"),
        linear("Y", "X", "[0, 1, 0]"),
        linear("Z", "Y", "[0, 0, 1]"),
        rotary("B", "base", "[0, 1, 0]", "[0, 0, 40]"),
        rotary("C", "B", "[0, 0, 1]", "[0, 0, 0]"),
        "[spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nstart_time_s = 1\n".into(),
        "[table]\non = \"C\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n".into(),
        "[control]\ncycle_time_ms = 2\nblock_time_ms = 1\nrapid_mode = \"straight\"\ntool_change_time_s = 5\ndefault_tolerance_mm = 0.01\n".into(),
    ]
    .concat();
    Machine::from_text(Path::new("test.toml"), &text).unwrap_or_else(|e| panic!("{e}"))
}

fn body(machine: &Machine, name: &str, on: Option<&str>, mesh: TriMesh) -> MachineBody {
    let attached_to = on.map_or(Attachment::Base, |j| Attachment::Joint(machine.joint(j).expect("joint")));
    MachineBody { name: name.into(), role: name.into(), attached_to, mesh, mass: None, color: [0; 4], check: true }
}

const GAUGE: f64 = 120.0;

fn tool() -> Tool {
    let section = |diameter, top_diameter, length| HolderSection { diameter, top_diameter, length };
    ToolBuilder::new(1, "BALL", Cutter::ball(12.0).expect("ball"), 20.0, GAUGE)
        .shank(10.0)
        .holder([section(30.0, 40.0, 50.0), section(60.0, 60.0, 20.0)])
        .build()
        .expect("tool")
}

fn block(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb { min: Point::from(min), max: Point::from(max) }
}

fn fixture(name: &str, b: &Aabb) -> Fixture {
    Fixture { name: name.into(), mesh: box_mesh(b), on_table: true }
}

/// Joints with the tip at a point of M (rotary joints at zero): the gauge line is above it.
fn at(x: f64, y: f64, z: f64, b_deg: f64, c_deg: f64) -> JointValues {
    let mut q = JointValues::ZERO;
    (q[0], q[1], q[2], q[3], q[4]) = (x, y, z + GAUGE, rad(b_deg), rad(c_deg));
    q
}

/// Points on the skin of the tool, r and z in frame T; the step of the sampling is below `step` mm.
fn skin(tool: &Tool, step: f64) -> Vec<Point> {
    let mut points = Vec::new();
    for body in &tool.bodies {
        let curve = body.profile.polyline(1e-4);
        for w in curve.windows(2) {
            let n = ((w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]) / step).ceil().max(1.0) as usize;
            for i in 0..=n {
                let t = i as f64 / n as f64;
                let (r, z) = (w[0][0] + t * (w[1][0] - w[0][0]), w[0][1] + t * (w[1][1] - w[0][1]));
                let around = (TAU * r / step).ceil().max(1.0) as usize;
                points.extend((0..around).map(|k| {
                    let a = TAU * k as f64 / around as f64;
                    Point::new(r * a.cos(), r * a.sin(), z)
                }));
            }
        }
    }
    points
}

/// Smallest signed distance of skin points from a box in K: an upper bound of the distance of the tool, at
/// most `step` too large.
fn sampled_distance(skin: &[Point], pose: &ToolPose, b: &Aabb) -> f64 {
    let across = if pose.axis.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
    let u = across.cross(&pose.axis).normalize();
    let v = pose.axis.cross(&u);
    let distance = |p: &Point| {
        let q = pose.tip + u * p.x + v * p.y + pose.axis * p.z;
        let d: Vec<f64> = (0..3).map(|i| (b.min[i] - q[i]).max(q[i] - b.max[i])).collect();
        let outside = d.iter().map(|x| x.max(0.0).powi(2)).sum::<f64>().sqrt();
        outside + d.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0)
    };
    skin.iter().map(distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn random_motions_are_never_late_and_never_missed() {
    let machine = machine();
    let tool = tool();
    let step = 4.0;
    let skin = skin(&tool, step);
    let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
    let (mut hits, mut clears) = (0, 0);
    for case in 0..80 {
        let corner = [random.next(-60.0, 20.0), random.next(-60.0, 20.0), random.next(0.0, 60.0)];
        let size = [random.next(1.0, 60.0), random.next(1.0, 60.0), random.next(1.0, 60.0)];
        let b = block(corner, std::array::from_fn(|i| corner[i] + size[i]));
        // Both ends are outside, on opposite sides, so that many ways cross.
        let side = random.next(70.0, 130.0);
        let mut any = |x: f64, tilt: f64| {
            let (y, z) = (random.next(-60.0, 60.0), random.next(20.0, 100.0));
            at(x, y, z, random.next(-tilt, tilt), random.next(-tilt, tilt))
        };
        let (from, to) = (any(-side, 30.0), any(side, 30.0));
        let mut check = Interference::new(&machine, &[fixture("block", &b)], 0.0).expect("solids");
        check.set_tool(Some(&tool));
        check.check_piece(&from, &to, [0.0, 1.0], 0.0);
        let reported = check.breaches().iter().map(|x| x.time).fold(f64::INFINITY, f64::min);
        let samples = 150;
        let distance_at = |t: f64| {
            let pose = machine.forward(&from.interpolated(to, t), GAUGE);
            sampled_distance(&skin, &pose, &b)
        };
        let truth = (0..=samples).map(|k| f64::from(k) / f64::from(samples)).find(|t| distance_at(*t) <= 0.0);
        match truth {
            Some(t) => {
                assert!(reported <= t + 1e-12, "case {case}: reported {reported}, sampled {t}");
                hits += 1;
            }
            None => clears += 1,
        }
        if reported.is_finite() {
            let d = distance_at(reported);
            // Sampling error of the skin: half a diagonal of its grid.
            assert!(d <= 5.3e-3 + 0.71 * step, "case {case}: false report, distance {d} at {reported}");
        } else {
            let least =
                (0..=samples).map(|k| distance_at(f64::from(k) / f64::from(samples))).fold(f64::INFINITY, f64::min);
            let proved = check.clearance();
            assert!(proved.lower_bound <= least + 1e-9, "case {case}: bound {} above {least}", proved.lower_bound);
            if let Some(n) = proved.measured {
                assert!(n.distance >= proved.lower_bound - 1e-9);
                assert!(proved.lower_bound >= 0.74 * n.distance.min(50.0), "{} {}", proved.lower_bound, n.distance);
            }
        }
    }
    assert!(hits > 10 && clears > 10, "{hits} hits, {clears} clear");
}

#[test]
fn a_thin_plate_between_two_positions_is_found() {
    let machine = machine();
    let plate = block([10.0, -50.0, 0.0], [10.01, 50.0, 200.0]);
    let mut check = Interference::new(&machine, &[fixture("plate", &plate)], 0.0).expect("solids");
    check.set_tool(Some(&tool()));
    let new = check.check_piece(&at(-200.0, 0.0, 50.0, 0.0, 0.0), &at(200.0, 0.0, 50.0, 0.0, 0.0), [2.0, 6.0], 0.0);
    assert!(!new.is_empty());
    // The first that meets the plate is the holder of radius 30 at x = 10 - 30, 180 of 400 mm after the
    // begin.
    let first = check.breaches().iter().min_by(|a, b| a.time.total_cmp(&b.time)).expect("one");
    assert_eq!(first.kinds[0], PartKind::Holder);
    assert!(first.time <= 2.0 + 4.0 * 180.0 / 400.0 && first.time > 2.0 + 4.0 * 179.98 / 400.0, "{}", first.time);
    assert!((first.point_in_table.x - 10.0).abs() < 0.02, "{}", first.point_in_table);
    let cutter = check.breaches().iter().find(|b| b.kinds[0] == PartKind::Cutter).expect("the cutter as well");
    assert!(cutter.time <= 2.0 + 4.0 * 204.0 / 400.0 && cutter.time > 2.0 + 4.0 * 203.98 / 400.0, "{}", cutter.time);
    assert_eq!(cutter.severity, Severity::Collision);
}

#[test]
fn a_tool_wholly_inside_of_a_fixture_is_found() {
    let machine = machine();
    let around = block([-200.0, -200.0, -200.0], [200.0, 200.0, 400.0]);
    let mut check = Interference::new(&machine, &[fixture("shell", &around)], 0.0).expect("solids");
    check.set_tool(Some(&tool()));
    check.check_piece(&at(0.0, 0.0, 50.0, 0.0, 0.0), &at(1.0, 0.0, 50.0, 0.0, 0.0), [0.0, 1.0], 0.0);
    assert_eq!(check.breaches().len(), 3, "cutter, shank, holder");
    assert!(check.breaches().iter().all(|b| b.inside && b.time == 0.0));
    // And a small fixture wholly inside of the holder.
    let pin = block([-3.0, -3.0, 145.0], [3.0, 3.0, 150.0]);
    let mut check = Interference::new(&machine, &[fixture("pin", &pin)], 0.0).expect("solids");
    check.set_tool(Some(&tool()));
    check.check_piece(&at(0.0, 0.0, 50.0, 0.0, 0.0), &at(0.0, 0.0, 50.0, 0.0, 0.0), [0.0, 1.0], 0.0);
    let names: Vec<_> = check.breaches().iter().map(|b| (b.kinds[0], b.inside)).collect();
    assert_eq!(names, [(PartKind::Holder, true)]);
}

#[test]
fn the_inside_of_overlapping_shells_is_inside() {
    // Two boxes of one fixture that overlap: the nearest face to the tip is one of the other box.
    let machine = machine();
    let mut mesh = box_mesh(&block([-100.0, -100.0, 0.0], [100.0, 100.0, 300.0]));
    mesh.append(&box_mesh(&block([20.0, -300.0, 50.0], [120.0, 300.0, 60.0])));
    let shells = Fixture { name: "shells".into(), mesh, on_table: true };
    let small = ToolBuilder::new(1, "S", Cutter::ball(2.0).expect("ball"), 5.0, 20.0).build().expect("tool");
    let mut check = Interference::new(&machine, &[shells], 0.0).expect("solids");
    check.set_tool(Some(&small));
    let mut q = JointValues::ZERO;
    (q[0], q[2]) = (15.0, 54.0 + 20.0);
    check.check_piece(&q, &q, [0.0, 1.0], 0.0);
    assert!(check.breaches().iter().any(|b| b.kinds[0] == PartKind::Cutter && b.inside));
}

#[test]
fn grazing_is_a_near_miss_below_the_clearance_only() {
    let machine = machine();
    // The cutter of radius 6 passes the block at a distance of 1 mm; the holder stays above it.
    let b = block([7.0, -20.0, 0.0], [40.0, 20.0, 60.0]);
    let run = |clearance: f64, slack: f64| {
        let mut check = Interference::new(&machine, &[fixture("block", &b)], clearance).expect("solids");
        check.set_tool(Some(&tool()));
        let mut last = at(0.0, -100.0, 50.0, 0.0, 0.0);
        for k in 1..=400 {
            let next = at(0.0, -100.0 + 0.5 * f64::from(k), 50.0, 0.0, 0.0);
            check.check_piece(&last, &next, [f64::from(k - 1), f64::from(k)], slack);
            last = next;
        }
        check
    };
    assert!(run(0.9, 0.0).breaches().is_empty());
    let near = run(1.1, 0.0);
    let cutter: Vec<_> = near.breaches().iter().filter(|b| b.kinds[0] == PartKind::Cutter).collect();
    assert_eq!(cutter.len(), 1);
    assert_eq!(cutter[0].severity, Severity::NearMiss);
    assert!((cutter[0].distance - 1.1).abs() < 6e-3 && (cutter[0].least_distance - 1.0).abs() < 1e-3);
    assert_eq!(cutter[0].penetration_estimate, None);
    assert!(cutter[0].end_time.is_some_and(|t| t > cutter[0].time));
    let c = near.clearance();
    let n = c.measured.expect("measured");
    assert!((n.distance - 1.0).abs() < 1e-3 && &*n.bodies[0] == "cutter of BALL" && &*n.bodies[1] == "block");
    assert!(c.lower_bound > 0.7 && c.lower_bound <= 1.0);
    // What the motion may leave its straight line by counts as nearness.
    assert!(!run(0.9, 0.2).breaches().is_empty());
    assert!(run(0.7, 0.2).breaches().is_empty());
}

#[test]
fn a_turning_table_swings_its_fixture_into_the_tool() {
    let machine = machine();
    let clamp = block([90.0, -10.0, 0.0], [110.0, 10.0, 120.0]);
    let mut check = Interference::new(&machine, &[fixture("clamp", &clamp)], 0.0).expect("solids");
    check.set_tool(Some(&tool()));
    // C turns by 350 degrees in one piece; the tip is at radius 100 in the direction of 180 degrees.
    let (from, to) = (at(-100.0, 0.0, 50.0, 0.0, 0.0), at(-100.0, 0.0, 50.0, 0.0, 350.0));
    check.check_piece(&from, &to, [0.0, 1.0], 0.0);
    let cutter = check.breaches().iter().find(|b| b.kinds[0] == PartKind::Cutter).expect("hit");
    // The near face of the clamp reaches the cutter before the middle of the clamp would.
    assert!(cutter.time < 180.0 / 350.0 && cutter.time > 165.0 / 350.0, "{}", cutter.time);
    assert!(cutter.end_time.is_some());
    assert!(cutter.point_in_table.x > 85.0, "in the frame of the table: {}", cutter.point_in_table);
}

#[test]
fn penetration_and_distance_are_different_fields() {
    let machine = machine();
    let b = block([-50.0, -50.0, 0.0], [50.0, 50.0, 20.0]);
    let mut check = Interference::new(&machine, &[fixture("block", &b)], 0.0).expect("solids");
    check.set_tool(Some(&tool()));
    check.check_piece(&at(0.0, 0.0, 40.0, 0.0, 0.0), &at(0.0, 0.0, 17.0, 0.0, 0.0), [0.0, 1.0], 0.0);
    let hit = &check.breaches()[0];
    assert!((hit.time - 20.0 / 23.0).abs() < 1e-3 && hit.time <= 20.0 / 23.0);
    assert!((0.0..6e-3).contains(&hit.distance));
    assert!(hit.penetration_estimate.is_some_and(|d| (d - 3.0).abs() < 0.01), "{:?}", hit.penetration_estimate);
    assert_eq!(hit.end_time, None);
    check.check_piece(&at(0.0, 0.0, 17.0, 0.0, 0.0), &at(0.0, 0.0, 80.0, 0.0, 0.0), [1.0, 2.0], 0.0);
    assert_eq!(check.breaches().len(), 1);
    assert_eq!(check.breaches()[0].end_time, Some(2.0));
}

/// Machine with bodies: bed, slides, spindle, swivel, table.
fn machine_with_bodies() -> Machine {
    let mut m = machine();
    let bodies = vec![
        body(&m, "bed", None, box_mesh(&block([-400.0, -400.0, -300.0], [400.0, 400.0, -200.0]))),
        body(&m, "slide", Some("Y"), box_mesh(&block([-60.0, 100.0, 700.0], [60.0, 200.0, 900.0]))),
        body(&m, "spindle", Some("Z"), cylinder_mesh(50.0, 0.0, 250.0, 48)),
        body(&m, "swivel", Some("B"), box_mesh(&block([-150.0, -200.0, -100.0], [150.0, 200.0, -40.0]))),
        body(&m, "table", Some("C"), cylinder_mesh(120.0, -40.0, 0.0, 64)),
    ];
    m.bodies = bodies;
    m
}

#[test]
fn unchecked_pairs_are_named_with_their_reason() {
    let machine = machine_with_bodies();
    let mut check =
        Interference::new(&machine, &[fixture("vise", &block([-40.0, -40.0, 0.0], [40.0, 40.0, 30.0]))], 1.0)
            .expect("solids")
            .allow("bed", "spindle");
    check.set_tool(Some(&tool()));
    let reason = |a: &str, b: &str| {
        let found = check.pairs().iter().find(|p| {
            let n = [&*p.bodies[0], &*p.bodies[1]];
            n == [a, b] || n == [b, a]
        });
        found.unwrap_or_else(|| panic!("{a} {b}")).unchecked
    };
    // Neighbors are checked without what bears.
    assert_eq!(reason("slide", "spindle"), None);
    assert_eq!(reason("swivel", "table"), None);
    assert_eq!(reason("bed", "swivel"), None);
    assert_eq!(reason("bed", "spindle"), Some(Unchecked::Allowed));
    assert_eq!(reason("table", "vise"), Some(Unchecked::Rigid));
    assert_eq!(reason("spindle", "holder of BALL"), Some(Unchecked::Rigid));
    assert_eq!(reason("table", "bed"), None);
    assert_eq!(reason("vise", "swivel"), None);
    assert_eq!(reason("spindle", "table"), None);
    assert_eq!(reason("cutter of BALL", "vise"), None);
    assert!(check.pairs().iter().all(|p| p.kinds != [PartKind::Cutter, PartKind::Holder]));
    assert_eq!(check.part_names().count(), 9);
}

#[test]
fn meshes_meet_meshes() {
    let machine = machine_with_bodies();
    let mut check = Interference::new(&machine, &[], 0.0).expect("solids");
    // Without a tool the spindle comes down on the table: its nose is at the gauge line.
    let mut high = JointValues::ZERO;
    high[2] = 150.0;
    check.check_piece(&high, &JointValues([0.0, 0.0, -5.0, 0.0, 0.3, 0.0, 0.0, 0.0]), [0.0, 1.0], 0.0);
    let hit = check.breaches().iter().find(|b| &*b.bodies[0] == "spindle" || &*b.bodies[1] == "spindle").expect("hit");
    assert!((hit.time - 150.0 / 155.0).abs() < 1e-3 && hit.time <= 150.0 / 155.0, "{}", hit.time);
    // The swivel turns its table into the bed.
    let mut check = Interference::new(&machine, &[], 0.0).expect("solids");
    let mut tilted = JointValues::ZERO;
    (tilted[2], tilted[3]) = (500.0, rad(100.0));
    let mut up = JointValues::ZERO;
    up[2] = 500.0;
    check.check_piece(&up, &tilted, [0.0, 1.0], 0.0);
    // Radius of the rim about the swivel axis stays above the bed at z = -200: 40 + sqrt(80^2 + 120^2) = 184.
    assert!(check.breaches().is_empty(), "{:?}", check.breaches());
    let n = check.clearance().measured.expect("measured");
    assert!(n.distance > 0.0 && check.clearance().lower_bound > 0.0);
}

#[test]
fn the_same_motion_in_other_pieces_gives_the_same_times() {
    let machine = machine_with_bodies();
    let vise = fixture("vise", &block([-40.0, -40.0, 0.0], [40.0, 40.0, 30.0]));
    let run = |parts: u32| {
        let mut check = Interference::new(&machine, std::slice::from_ref(&vise), 2.0).expect("solids");
        check.set_tool(Some(&tool()));
        let (from, to) = (at(-150.0, 10.0, 25.0, 20.0, 0.0), at(150.0, 15.0, 28.0, -10.0, 45.0));
        for k in 0..parts {
            let t = |i: u32| f64::from(i) / f64::from(parts);
            check.check_piece(&from.interpolated(to, t(k)), &from.interpolated(to, t(k + 1)), [t(k), t(k + 1)], 0.0);
        }
        check
    };
    let first = |check: &Interference, kind: PartKind, severity: Severity| {
        let found = check.breaches().iter().filter(|b| b.kinds[0] == kind && b.severity == severity);
        found.map(|b| b.time).fold(f64::INFINITY, f64::min)
    };
    let (one, many, again) = (run(1), run(3000), run(3000));
    assert_eq!(many.breaches(), again.breaches());
    assert_eq!(many.clearance(), again.clearance());
    for (kind, severity) in [(PartKind::Cutter, Severity::NearMiss), (PartKind::Cutter, Severity::Collision)] {
        let (a, b) = (first(&one, kind, severity), first(&many, kind, severity));
        // The tolerance of 5 micrometers at about 300 mm a second, at any angle of approach here above a
        // degree.
        assert!(a.is_finite() && (a - b).abs() < 2e-3, "{kind:?} {severity:?}: {a} {b}");
    }
    assert!(many.queries() < 40 * u64::from(many.pairs().len() as u32) + 6000, "{} queries", many.queries());
}

#[test]
fn most_pieces_need_no_query() {
    let machine = machine_with_bodies();
    let vise = fixture("vise", &block([-40.0, -40.0, 0.0], [40.0, 40.0, 30.0]));
    let mut check = Interference::new(&machine, &[vise], 1.0).expect("solids");
    check.set_tool(Some(&tool()));
    let mut last = at(0.0, 0.0, 100.0, 0.0, 0.0);
    for k in 1..=20_000_u32 {
        let a = f64::from(k) * 0.01;
        let next = at(60.0 * a.cos() - 60.0, 60.0 * a.sin(), 100.0, 5.0 * (0.1 * a).sin(), 0.0);
        check.check_piece(&last, &next, [a - 0.01, a], 1e-3);
        last = next;
    }
    assert!(check.breaches().is_empty());
    assert_eq!(check.pieces(), 20_000);
    assert!(check.queries() < 4000, "{} queries", check.queries());
}

#[test]
fn a_tool_change_starts_anew() {
    let machine = machine();
    let b = block([-50.0, -50.0, 0.0], [50.0, 50.0, 20.0]);
    let mut check = Interference::new(&machine, &[fixture("block", &b)], 0.0).expect("solids");
    let q = at(0.0, 0.0, 10.0, 0.0, 0.0);
    check.check_piece(&q, &q, [0.0, 1.0], 0.0);
    assert!(check.breaches().is_empty());
    assert_eq!(check.clearance().lower_bound, f64::INFINITY);
    check.set_tool(Some(&tool()));
    check.check_piece(&q, &q, [1.0, 2.0], 0.0);
    assert_eq!(check.breaches().len(), 1);
    check.set_tool(None);
    assert_eq!(check.breaches()[0].end_time, Some(2.0));
    check.check_piece(&q, &q, [2.0, 3.0], 0.0);
    assert_eq!(check.breaches().len(), 1);
    assert_eq!(check.clearance().lower_bound, 0.0);
}

#[test]
fn bad_input_is_refused_or_counts_as_a_collision() {
    let machine = machine();
    let b = block([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]);
    let mut turned = fixture("inside out", &b);
    turned.mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let empty = Fixture { mesh: TriMesh::default(), ..fixture("empty", &b) };
    let mut numbers = fixture("no numbers", &b);
    numbers.mesh.positions[3].y = f64::NAN;
    let mut index = fixture("no vertex", &b);
    index.mesh.triangles[0][1] = 99;
    for bad in [turned, empty, numbers, index] {
        let name = bad.name.clone();
        let message = Interference::new(&machine, &[bad], 0.0).expect_err("no body").to_string();
        assert!(message.contains(&name), "{message}");
    }
    assert!(matches!(Interference::new(&machine, &[], f64::NAN), Err(CollisionError::Clearance { .. })));
    let mut check = Interference::new(&machine, &[fixture("block", &b)], 0.0).expect("solids");
    check.set_tool(Some(&tool()));
    let mut bad = at(0.0, 0.0, 100.0, 0.0, 0.0);
    bad[1] = f64::NAN;
    let new = check.check_piece(&at(0.0, 0.0, 100.0, 0.0, 0.0), &bad, [0.0, 1.0], 0.0);
    assert!(!new.is_empty() && check.breaches()[new].iter().all(|b| b.severity == Severity::QueryFailed));
}

/// Of a mesh with a hole the surface counts, and nothing shows that something is inside; a solid that holds
/// it is still reported.
#[test]
fn an_open_mesh_has_a_surface_and_no_inside() {
    let machine = machine();
    let around = block([-60.0, -60.0, 0.0], [60.0, 60.0, 300.0]);
    let here = at(0.0, 0.0, 100.0, 0.0, 0.0);
    for (open, within) in [(false, true), (true, true), (true, false)] {
        // The tool is wholly inside of a large one; a small one is wholly inside of the holder.
        let place = if within { around } else { block([-2.0, -2.0, 170.0], [2.0, 2.0, 175.0]) };
        let mut one = fixture("one", &place);
        if open {
            one.mesh.triangles.pop();
        }
        let mut check = Interference::new(&machine, &[one], 0.0).expect("surfaces");
        let faults: Vec<_> =
            check.mesh_faults().map(|(name, f)| (name.to_string(), f.open.is_some(), f.flat)).collect();
        assert_eq!(faults, if open { vec![("one".into(), true, 0)] } else { vec![] });
        check.set_tool(Some(&tool()));
        check.check_piece(&here, &here, [0.0, 1.0], 0.0);
        let inside = check.breaches().iter().any(|b| b.inside);
        assert_eq!(inside, !open || !within, "{open} {within}: {:?}", check.breaches());
        if within {
            let out = check.check_piece(&here, &at(40.0, 0.0, 100.0, 0.0, 0.0), [1.0, 2.0], 0.0);
            let met = check.breaches()[out].iter().any(|b| b.severity == Severity::Collision);
            assert!(met || !open, "its surface is met from inside: {:?}", check.breaches());
        }
    }
}

#[test]
fn fixtures_on_the_base_stay_while_the_table_turns() {
    let machine = machine();
    let post = Fixture { on_table: false, ..fixture("post", &block([90.0, -10.0, 0.0], [110.0, 10.0, 300.0])) };
    let mut check = Interference::new(&machine, &[post], 0.0).expect("solids");
    check.set_tool(Some(&tool()));
    check.check_piece(&at(0.0, 0.0, 50.0, 0.0, 0.0), &at(0.0, 0.0, 50.0, 80.0, 350.0), [0.0, 1.0], 0.0);
    assert!(check.breaches().is_empty());
    check.check_piece(&at(0.0, 0.0, 50.0, 80.0, 350.0), &at(100.0, 0.0, 50.0, 80.0, 350.0), [1.0, 2.0], 0.0);
    assert!(check.breaches().iter().any(|b| b.kinds[0] == PartKind::Cutter));
    // Places are given in the frame of the table, which has turned.
    let hit = &check.breaches()[0];
    let in_machine = machine.machine_from_table(&hit.joints).point(&hit.point_in_table);
    assert!((in_machine - Pose::identity().point(&in_machine)).norm() < 1e-12);
    assert!((80.0..112.0).contains(&in_machine.x), "{in_machine}");
}

#[test]
fn the_shipped_machines_stand_free_at_home_with_every_shipped_tool() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for name in ["spinner-u5-620", "ac-trunnion-620"] {
        let machine = Machine::read(&root.join("machines").join(name)).unwrap_or_else(|e| panic!("{e}"));
        assert!(!machine.bodies.is_empty(), "{name}");
        let mut check = Interference::new(&machine, &[], 0.0).unwrap_or_else(|e| panic!("{name}: {e}"));
        let home = machine.home();
        for library in ["axis-cross.toml", "cone-frustum.toml"] {
            let library = proveout_tool::ToolLibrary::read(&root.join("tools").join(library)).expect("library");
            for tool in &library.tools {
                check.set_tool(Some(tool));
                check.check_piece(&home, &home, [0.0, 1.0], 0.0);
            }
        }
        let pairs: Vec<_> = check.breaches().iter().map(|b| format!("{} {}", b.bodies[0], b.bodies[1])).collect();
        assert!(pairs.is_empty(), "{name}: {pairs:?}");
    }
}

/// A slide that goes out and comes back within one piece: its ends say nothing of it.
#[test]
fn a_joint_that_turns_back_within_a_piece_is_held_by_what_it_leaves_its_straight_motion_by() {
    let machine = machine();
    let wall = block([8.0, -20.0, 0.0], [40.0, 20.0, 65.0]);
    // The cutter of radius 6 is 2 mm from the wall.
    let stand = at(0.0, 0.0, 50.0, 0.0, 0.0);
    let run = |out: f64, off: f64| {
        let mut check = Interference::new(&machine, &[fixture("wall", &wall)], 0.0).expect("solids");
        check.set_tool(Some(&tool()));
        let mut bend = JointValues::ZERO;
        bend[0] = off;
        // The way over Y goes on meanwhile; X comes back to where it was.
        let mut end = stand;
        end[1] += out;
        check.check_bent_piece([&stand, &end], [0.0, 1.0], 0.0, &bend);
        check
    };
    for along in [0.0, 5.0] {
        assert!(!run(along, 2.5).breaches().is_empty());
        assert!(!run(along, 2.0).breaches().is_empty());
        let clear = run(along, 1.9);
        assert!(clear.breaches().is_empty());
        assert!(clear.clearance().lower_bound <= 0.1 + 1e-9 && clear.clearance().lower_bound > 0.0);
        let straight = run(along, 0.0);
        assert!(straight.breaches().is_empty() && straight.clearance().lower_bound > 1.4);
    }
    // A joint that is no number far from its line is no proof of anything.
    let mut check = run(0.0, 0.0);
    let new = check.check_bent_piece([&stand, &stand], [1.0, 2.0], 0.0, &at(f64::NAN, 0.0, 0.0, 0.0, 0.0));
    assert!(check.breaches()[new].iter().all(|b| b.severity == Severity::QueryFailed));
}

/// Curved motions of all joints, with reversals inside: parabolas about a straight motion, against dense
/// sampling.
#[test]
fn what_is_proved_holds_for_every_motion_within_the_deviation_of_its_joints() {
    let machine = machine();
    let tool = tool();
    let skin = skin(&tool, 4.0);
    let mut random = Random::new(0x5851_f42d_4c95_7f2d);
    let (mut clears, mut turned_back) = (0, 0);
    for case in 0..60 {
        let b = block([40.0, -30.0, 0.0], [80.0, 30.0, 60.0]);
        let from = at(
            random.next(-60.0, 0.0),
            random.next(-40.0, 40.0),
            random.next(20.0, 90.0),
            random.next(-20.0, 20.0),
            0.0,
        );
        let mut way = JointValues::ZERO;
        let mut bend = JointValues::ZERO;
        for j in 0..3 {
            (way[j], bend[j]) = (random.next(-3.0, 3.0), random.next(-8.0, 8.0));
        }
        for j in 3..5 {
            (way[j], bend[j]) = (rad(random.next(-2.0, 2.0)), rad(random.next(-4.0, 4.0)));
        }
        let to = from + way;
        // q = a + t w + 4 t (1 - t) e turns back where |4 e| > |w|.
        turned_back += (0..5).filter(|&j| 4.0 * bend[j].abs() > way[j].abs()).count();
        let mut check = Interference::new(&machine, &[fixture("block", &b)], 0.0).expect("solids");
        check.set_tool(Some(&tool));
        check.check_bent_piece([&from, &to], [0.0, 1.0], 0.0, &bend.zip_map(JointValues::ZERO, |e, _| e.abs()));
        let least = (0..=60).map(|k| {
            let t = f64::from(k) / 60.0;
            let q = from.interpolated(to, t) + bend * (4.0 * t * (1.0 - t));
            sampled_distance(&skin, &machine.forward(&q, GAUGE), &b)
        });
        let least = least.fold(f64::INFINITY, f64::min);
        if check.breaches().is_empty() {
            clears += 1;
            let proved = check.clearance().lower_bound;
            assert!(proved <= least + 1e-9, "case {case}: proved {proved}, sampled {least}");
        }
        assert!(least > 0.0 || !check.breaches().is_empty(), "case {case}: missed");
    }
    assert!(clears > 10 && turned_back > 150, "{clears} {turned_back}");
}
