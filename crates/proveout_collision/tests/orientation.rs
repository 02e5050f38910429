//! Regions of the tool axis at a contact against closed forms, and against points of the tool in dense poses,
//! whose distances from boxes share no code with the search.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests fail by panic; counts are worth seeing")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proveout_collision::{
    AxisState, Obstacle, OrientationError, OrientationMap, OrientationSettings, OrientationSpace, Refusal,
    SurfaceContact,
};
use proveout_geom::{Aabb, Point, ToolPose, TriMesh, Vector, box_mesh, revolved_mesh};
use proveout_tool::{Cutter, HolderSection, Role, Tool, ToolBuilder};

use crate::common::Random;

const HALF_DEGREE: f64 = PI / 360.0;

fn section(diameter: f64, top_diameter: f64, length: f64) -> HolderSection {
    HolderSection { diameter, top_diameter, length }
}

fn cuboid(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb { min: Point::from(min), max: Point::from(max) }
}

/// Tilts up to a right angle.
fn wide() -> OrientationSettings {
    OrientationSettings { tilt_limit: FRAC_PI_2, ..OrientationSettings::default() }
}

fn on_floor() -> SurfaceContact {
    SurfaceContact { point: Point::origin(), normal: Vector::z(), feed: Vector::x(), curvatures: None }
}

fn space(tool: &Tool, solids: &[(Aabb, bool)], settings: &OrientationSettings) -> OrientationSpace {
    let meshes: Vec<(TriMesh, bool)> = solids.iter().map(|(b, cut)| (box_mesh(b), *cut)).collect();
    let solids: Vec<Obstacle<'_>> =
        meshes.iter().map(|(mesh, cut)| Obstacle { name: "box", mesh, cut: *cut }).collect();
    OrientationSpace::new(tool, &solids, settings).unwrap()
}

/// Leaning from the normal with a yaw, the axes up to a limit are free and those beyond it blocked, but for a
/// finest cell.
fn assert_limit(map: &OrientationMap, yaw: f64, limit: f64, to: f64) {
    for k in 0..=900 {
        let tilt = f64::from(k) * 1e-3 * FRAC_PI_2 / 0.9;
        if tilt > to {
            break;
        }
        let state = map.state(&map.axis(tilt, yaw)).unwrap();
        if tilt < limit - 1.5 * HALF_DEGREE {
            assert_eq!(state, AxisState::Free, "tilt {} of {}", tilt.to_degrees(), limit.to_degrees());
        } else if tilt > limit + 2.0 * HALF_DEGREE {
            assert_eq!(state, AxisState::Blocked, "tilt {} of {}", tilt.to_degrees(), limit.to_degrees());
        } else {
            assert!(
                state != AxisState::Free || tilt <= limit + 1e-9,
                "tilt {} of {}",
                tilt.to_degrees(),
                limit.to_degrees()
            );
        }
    }
}

/// First tilt at which `clearance` falls to zero.
fn crossing(clearance: impl Fn(f64) -> f64) -> f64 {
    let mut tilt = 0.0;
    while clearance(tilt) > 0.0 && tilt < FRAC_PI_2 {
        tilt += 1e-5;
    }
    tilt
}

#[test]
fn a_shank_in_a_straight_slot_leans_as_far_as_its_edges_let_it() {
    let settings = wide();
    for (width, depth, clearance) in [(10.0, 30.0, 0.2), (14.0, 25.0, 0.5), (40.0, 22.0, 0.0)] {
        let tool = ToolBuilder::new(1, "BALL", Cutter::ball(6.0).unwrap(), 8.0, 160.0).shank(6.0).build().unwrap();
        let half = 0.5 * width;
        let solids = [
            (cuboid([-300.0, -300.0, -20.0], [300.0, 300.0, 0.0]), true),
            (cuboid([-300.0, -300.0, -20.0], [300.0, -half, depth]), true),
            (cuboid([-300.0, half, -20.0], [300.0, 300.0, depth]), true),
        ];
        let map = space(&tool, &solids, &OrientationSettings { clearance, ..settings }).map(&on_floor()).unwrap();
        assert_eq!(map.refusal(), None);
        // The upper edge of a wall, seen from the ball center: `half` aside and `depth - 3` up; its distance
        // from the axis is that times (cos, -sin) of the tilt. Its foot is far above the flutes.
        let limit = ((3.0 + clearance) / half.hypot(depth - 3.0)).asin();
        let limit = (half / (depth - 3.0)).atan() - limit;
        for yaw in [FRAC_PI_2, -FRAC_PI_2] {
            assert_limit(&map, yaw, limit, 1.2);
        }
        // Along the slot only the floor ends it: a ball on a plane may lean until the shank comes down.
        assert!(map.is_free(&map.axis(60_f64.to_radians(), 0.0)));
    }
}

#[test]
fn a_shank_near_a_wall_leans_towards_it_as_far_as_its_side_lets_it() {
    let tool = ToolBuilder::new(1, "BALL", Cutter::ball(8.0).unwrap(), 12.0, 160.0).shank(8.0).build().unwrap();
    let solids = [
        (cuboid([-400.0, -400.0, -20.0], [400.0, 400.0, 0.0]), true),
        (cuboid([-400.0, 5.0, 0.0], [400.0, 60.0, 300.0]), false),
    ];
    let map = space(&tool, &solids, &wide()).map(&on_floor()).unwrap();
    // A wall taller than the tool: the top rim of the shank (in the plane of the lean) comes near first, or
    // the flutes where they end.
    let top = tool.bodies.iter().map(|b| b.profile.z_max()).fold(0.0, f64::max) - 4.0;
    let limit = crossing(|t| 5.0 - 0.2 - (top * t.sin() + 4.0 * t.cos()));
    assert!(limit > 0.001 && limit < 0.2, "{limit}");
    for (yaw, sign) in [(FRAC_PI_2, 1.0), (-FRAC_PI_2, -1.0)] {
        for k in 0..200 {
            let tilt = f64::from(k) * 2e-3;
            let state = map.state(&map.axis(tilt, yaw)).unwrap();
            if sign < 0.0 && tilt > 0.02 {
                assert_eq!(state, AxisState::Free, "away from the wall at {tilt}");
            } else if sign > 0.0 && tilt > limit + 1.5 * HALF_DEGREE {
                assert_eq!(state, AxisState::Blocked, "towards the wall at {tilt}");
            } else if sign > 0.0 && tilt > limit {
                assert_ne!(state, AxisState::Free, "towards the wall at {tilt}");
            }
        }
    }
}

#[test]
fn a_conical_holder_over_a_plane_leans_until_a_rim_is_down() {
    let builder = ToolBuilder::new(1, "BALL", Cutter::ball(10.0).unwrap(), 15.0, 120.0).shank(10.0);
    let tool = builder.holder([section(24.0, 44.0, 30.0), section(63.0, 63.0, 20.0)]).build().unwrap();
    let solids = [(cuboid([-400.0, -400.0, -20.0], [400.0, 400.0, 0.0]), true)];
    let map = space(&tool, &solids, &wide()).map(&on_floor()).unwrap();
    // The lowest point of a rim (radius r, h above the ball center) over the plane: 5 + h cos t - r sin t.
    let rims: Vec<[f64; 2]> = tool
        .not_cutting()
        .flat_map(|b| b.profile.segments().iter().flat_map(|s| [s.from(), s.to()]))
        .map(|[r, z]| [r, z - 5.0])
        .collect();
    let limit = crossing(|t| rims.iter().map(|[r, h]| 5.0 + h * t.cos() - r * t.sin()).fold(f64::MAX, f64::min) - 0.2);
    assert!(limit > 0.8 && limit < 1.4, "{limit}");
    for yaw in [-3.0, -1.0, 0.0, 0.7, 2.2] {
        assert_limit(&map, yaw, limit, FRAC_PI_2);
    }
    // The share of the cap, in closed form.
    let [free, _, unknown] = map.shares();
    assert!((free - (1.0 - limit.cos())).abs() < 0.02 && unknown < 0.02, "{free} {unknown}");
    assert!(map.free_cells() > 100);
}

#[test]
fn a_cutter_in_a_fillet_is_as_round_as_it_must_be() {
    let cylinder = |radius: f64| {
        // A hollow fillet along x: flat along the feed, hollow across.
        SurfaceContact { curvatures: Some([(0.0, Vector::x()), (-1.0 / radius, Vector::y())]), ..on_floor() }
    };
    let ball = ToolBuilder::new(1, "BALL", Cutter::ball(6.0).unwrap(), 12.0, 120.0).build().unwrap();
    let settings = wide();
    let free = space(&ball, &[], &settings);
    assert_eq!(free.map(&cylinder(2.99)).unwrap().refusal(), Some(Refusal::Curvature));
    assert_eq!(free.map(&cylinder(2.99)).unwrap().shares(), [0.0, 1.0, 0.0]);
    assert_eq!(
        free.map(&cylinder(3.0)).unwrap().shares(),
        [1.0, 0.0, 0.0],
        "a ball in a groove of its own radius fits"
    );
    assert_eq!(free.map(&cylinder(3.01)).unwrap().refusal(), None);
    // A torus-shaped fillet is hollow both ways: the larger hollow counts, whatever the direction of the
    // feed.
    let turned = [Vector::new(0.6, 0.8, 0.0), Vector::new(-0.8, 0.6, 0.0)];
    let torus = |a: f64, b: f64| SurfaceContact {
        curvatures: Some([(-1.0 / a, turned[0]), (-1.0 / b, turned[1])]),
        ..on_floor()
    };
    assert_eq!(free.map(&torus(20.0, 2.9)).unwrap().refusal(), Some(Refusal::Curvature));
    assert_eq!(free.map(&torus(20.0, 3.1)).unwrap().refusal(), None);
    // Bull-nose R5 r1 leaning along the feed: across it the curvature is sin t / (4 + sin t), which must
    // reach 1/radius.
    let bull = ToolBuilder::new(2, "BULL", Cutter::bull_nose(10.0, 1.0).unwrap(), 12.0, 120.0).build().unwrap();
    let free = space(&bull, &[], &settings);
    for radius in [6.0, 9.0, 20.0] {
        let map = free.map(&cylinder(radius)).unwrap();
        let limit = (4.0_f64 / (radius - 1.0)).asin();
        for yaw in [0.0, PI - 1e-3] {
            for k in 0..1500 {
                let tilt = f64::from(k) * 1e-3;
                let state = map.state(&map.axis(tilt, yaw)).unwrap();
                let exact = free.curvature_margin(&cylinder(radius), tilt, yaw).unwrap().unwrap();
                if yaw == 0.0 {
                    assert!((exact - (tilt.sin() / (4.0 + tilt.sin()) - 1.0 / radius).min(1.0)).abs() < 1e-12);
                    assert!(state != AxisState::Free || tilt > limit - 1e-9, "{tilt} {limit}");
                }
                assert!(state == AxisState::Free || tilt < limit + 3.0 * HALF_DEGREE, "{tilt} {limit} {state:?}");
                assert!(state == AxisState::Blocked || tilt > limit - 3.0 * HALF_DEGREE, "{tilt} {limit} {state:?}");
            }
        }
        // Leaning across the fillet, its corner radius of 1 mm is in the hollow direction: round enough at
        // every tilt.
        assert!(map.is_free(&map.axis(0.3, FRAC_PI_2)) && map.is_free(&map.axis(1.2, FRAC_PI_2)));
    }
}

/// A tool's points about its axis: role, distance along the axis from the tip, radius.
fn rings(tool: &Tool) -> Vec<(Role, f64, f64)> {
    let mut out = Vec::new();
    for body in &tool.bodies {
        let (low, high) = (body.profile.z_min(), body.profile.z_max());
        let steps = ((high - low) / 0.7).ceil() as usize;
        for i in 0..=steps {
            let z = low + (high - low) * i as f64 / steps as f64;
            let radius = body.profile.radius_at(z).unwrap_or(0.0);
            for share in [0.0, 0.5, 1.0] {
                out.push((body.role, z, radius * share));
            }
        }
    }
    out
}

fn from_box(p: &Point, b: &Aabb) -> f64 {
    let off: [f64; 3] = std::array::from_fn(|i| (b.min[i] - p[i]).max(p[i] - b.max[i]));
    let outside = off.iter().map(|d| d.max(0.0).powi(2)).sum::<f64>().sqrt();
    if outside > 0.0 { outside } else { off.iter().copied().fold(f64::MIN, f64::max) }
}

/// Least distance from boxes, of the parts that do not cut and of the cutter from what it does not cut; and
/// the depth of the cutter in what it cuts.
fn sampled(rings: &[(Role, f64, f64)], pose: &ToolPose, solids: &[(Aabb, bool)]) -> (f64, f64) {
    let u = pose.axis.cross(&if pose.axis.x.abs() < 0.8 { Vector::x() } else { Vector::y() }).normalize();
    let v = pose.axis.cross(&u);
    let (mut clear, mut deep) = (f64::MAX, 0.0_f64);
    for &(role, z, radius) in rings {
        for k in 0..24 {
            let (s, c) = (TAU * f64::from(k) / 24.0).sin_cos();
            let p = pose.tip + pose.axis * z + u * (radius * c) + v * (radius * s);
            for (solid, cut) in solids {
                let d = from_box(&p, solid);
                if role == Role::Cutting && *cut { deep = deep.max(-d) } else { clear = clear.min(d) }
            }
        }
    }
    (clear, deep)
}

#[test]
fn no_pose_of_a_free_cell_touches_and_none_of_a_blocked_one_is_clear() {
    let poses: usize = std::env::var("PROVEOUT_ORIENTATION_POSES").ok().and_then(|n| n.parse().ok()).unwrap_or(5_000);
    let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
    let tools = [
        ToolBuilder::new(1, "BALL", Cutter::ball(6.0).unwrap(), 10.0, 90.0)
            .shank(6.0)
            .holder([section(20.0, 32.0, 30.0)]),
        ToolBuilder::new(2, "NECK", Cutter::ball(8.0).unwrap(), 6.0, 90.0).neck(6.0, 25.0).shank(12.0),
        ToolBuilder::new(3, "TAPER", Cutter::taper_ball(4.0, 6.0, 10.0).unwrap(), 35.0, 95.0).shank(10.0),
        ToolBuilder::new(4, "BULL", Cutter::bull_nose(12.0, 2.0).unwrap(), 14.0, 80.0).shank(10.0),
        ToolBuilder::new(5, "FLAT", Cutter::flat(8.0).unwrap(), 14.0, 80.0)
            .shank(8.0)
            .holder([section(30.0, 30.0, 20.0)]),
    ];
    let tools: Vec<Tool> = tools.into_iter().map(|b| b.build().unwrap()).collect();
    let (mut tried, mut free, mut blocked, mut unknown, mut refused) = (0, 0, 0, 0, 0);
    let mut scene = 0;
    while tried < poses {
        // Corners of the generator: every kind of cutter; contacts on the floor, next to a wall (down to
        // where the ball does not fit), on the edge of the floor and on a wall with its normal aside; walls
        // that are cut and others, thin ones, one over the contact, one far away; no gouge allowance to speak
        // of, no clearance; tilts at 0, at the limit, and yaws at the seam.
        let tool = &tools[scene % tools.len()];
        let settings = OrientationSettings {
            finest_cell: [1.0_f64, 2.0, 4.0][scene % 3].to_radians(),
            clearance: [0.2, 0.0, 1.5][scene / 3 % 3],
            gouge: [0.02, 1e-4, 0.1][scene / 2 % 3],
            tilt_limit: [FRAC_PI_2, 75_f64.to_radians()][scene / 4 % 2],
            ..OrientationSettings::default()
        };
        let wall = random.next(-0.5, 20.0) + if scene % 4 == 0 { 0.0 } else { 5.0 };
        let height = random.next(2.0, 80.0);
        let solids = [
            (cuboid([-150.0, -150.0, -30.0], [150.0, 150.0, 0.0]), true),
            (cuboid([wall, -100.0, -30.0], [wall + random.next(0.3, 30.0), 100.0, height]), scene % 2 == 0),
            (cuboid([-60.0, random.next(8.0, 30.0), random.next(0.0, 20.0)], [30.0, 45.0, 60.0]), false),
            (cuboid([-50.0, -80.0, 40.0], [-20.0, -30.0, 43.0]), scene % 5 == 0),
        ];
        let on_wall = scene % 6 == 5;
        let contact = if on_wall {
            let point = Point::new(wall, random.next(-20.0, 20.0), random.next(0.3, 1.0) * height);
            SurfaceContact { point, normal: -Vector::x(), feed: Vector::new(0.3, 1.0, 0.2), curvatures: None }
        } else {
            let turn = random.next(-PI, PI);
            let point = Point::new(random.next(-4.0, 0.0), random.next(-5.0, 3.0), 0.0);
            SurfaceContact { point, feed: Vector::new(turn.cos(), turn.sin(), 0.0), ..on_floor() }
        };
        scene += 1;
        let space = space(tool, &solids, &settings);
        let map = space.map(&contact).unwrap();
        refused += usize::from(map.refusal().is_some());
        let rings = rings(tool);
        for n in 0..400 {
            let tilt = match n % 10 {
                0 => 0.0,
                1 => map_limit(&space),
                _ => space.tilt_limit() * random.part(),
            };
            let yaw = if n % 13 == 0 { -PI } else { random.next(-PI, PI) };
            let pose = space.pose(&contact, tilt, yaw).unwrap();
            if n % 10 == 0 && matches!(tool.number, 4 | 5) && yaw != 0.0 {
                // At the pole the axis alone does not fix the pose of a bull-nose.
                continue;
            }
            let state = map.state(&pose.axis).unwrap();
            tried += 1;
            let (clear, deep) = sampled(&rings, &pose, &solids);
            match state {
                AxisState::Free => {
                    free += 1;
                    assert!(clear >= settings.clearance - 1e-9, "scene {scene}, {}: {clear} {pose:?}", tool.name);
                    assert!(deep <= settings.gouge + 1e-9, "scene {scene}, {}: {deep} deep {pose:?}", tool.name);
                }
                // Points lie 0.7 mm along and a 24th of a circle of 16 mm apart.
                AxisState::Blocked => {
                    blocked += 1;
                    let near = clear < settings.clearance + 3.0 || deep > 0.0 || map.refusal().is_some();
                    assert!(near, "scene {scene}, {}: {clear} {deep} {pose:?}", tool.name);
                }
                AxisState::Unknown => unknown += 1,
            }
        }
    }
    println!(
        "{tried} poses in {scene} scenes: {free} free, {blocked} blocked, {unknown} unknown; {refused} contacts refused"
    );
    assert!(free > tried / 10 && blocked > tried / 5 && unknown < tried / 5 && refused > 0);
}

fn map_limit(space: &OrientationSpace) -> f64 {
    space.tilt_limit() * (1.0 - 1e-12)
}

/// The cutter touches its contact and no plane across the normal is passed: in every pose, by points of the
/// tool.
#[test]
fn poses_touch_at_the_contact() {
    let contact = SurfaceContact {
        point: Point::new(3.0, -2.0, 7.0),
        normal: Vector::new(2.0, -1.0, 2.0) / 3.0,
        feed: Vector::new(0.1, 0.9, -0.4),
        curvatures: None,
    };
    for cutter in
        [Cutter::ball(6.0), Cutter::bull_nose(12.0, 2.0), Cutter::flat(8.0), Cutter::taper_ball(4.0, 6.0, 10.0)]
    {
        let tool = ToolBuilder::new(1, "T", cutter.unwrap(), 30.0, 90.0).build().unwrap();
        let space = space(&tool, &[], &OrientationSettings::default());
        for k in 0..300 {
            let (tilt, yaw) = (space.tilt_limit() * f64::from(k % 20) / 19.0, 0.31 * f64::from(k) % TAU - PI);
            let pose = space.pose(&contact, tilt, yaw).unwrap();
            let from = contact.point - pose.tip;
            let z = from.dot(&pose.axis);
            let place = [(from - pose.axis * z).norm(), z];
            let body = tool.cutting().next().unwrap();
            assert!(body.profile.signed_distance(place).abs() < 1e-9, "{tilt} {yaw}");
            let out = contact.point + contact.normal * 1e-3 - pose.tip;
            let z = out.dot(&pose.axis);
            assert!(
                tilt > 1.5 || body.profile.signed_distance([(out - pose.axis * z).norm(), z]) < 1e-9,
                "{tilt} {yaw}"
            );
        }
    }
}

/// A hub with a flange, about z, and contacts round its flank.
fn flank() -> (TriMesh, Vec<SurfaceContact>) {
    let hub = revolved_mesh(&[[0.0, 0.0], [45.0, 0.0], [45.0, 8.0], [18.0, 8.0], [16.0, 50.0], [0.0, 50.0]], 360);
    let slope = Vector::new(42.0, 0.0, 2.0).normalize();
    let contacts = (0..12).map(|k| {
        let (s, c) = (f64::from(k) * 0.02).sin_cos();
        let (normal, feed) = (Vector::new(slope.x * c, slope.x * s, slope.z), Vector::new(-s, c, 0.01));
        let z = 20.0 + 0.05 * f64::from(k);
        let radius = 18.0 - (z - 8.0) / 21.0;
        SurfaceContact { point: Point::new(radius * c, radius * s, z), normal, feed, curvatures: None }
    });
    (hub, contacts.collect())
}

#[test]
fn a_walk_finds_what_each_contact_finds_alone() {
    let (hub, contacts) = flank();
    let tools = [
        ToolBuilder::new(1, "BALL", Cutter::ball(6.0).unwrap(), 10.0, 90.0)
            .shank(6.0)
            .holder([section(20.0, 32.0, 30.0)]),
        ToolBuilder::new(4, "BULL", Cutter::bull_nose(12.0, 2.0).unwrap(), 14.0, 80.0).shank(10.0),
    ];
    let mut random = Random::new(0x2545_f491_4f6c_dd1d);
    for (builder, [finest, count]) in tools.into_iter().zip([[2.0_f64, 12.0], [8.0, 3.0]]) {
        let contacts = &contacts[..count as usize];
        let tool = builder.build().unwrap();
        let obstacle = [Obstacle { name: "hub", mesh: &hub, cut: true }];
        let settings = OrientationSettings { finest_cell: finest.to_radians(), ..OrientationSettings::default() };
        let space = OrientationSpace::new(&tool, &obstacle, &settings).unwrap();
        let limit = space.tilt_limit();
        let mut walk = space.walk();
        let (mut differing, mut looked) = (0, [0, 0]);
        for contact in contacts {
            let (cold, warm) = (space.map(contact).unwrap(), walk.next(contact).unwrap());
            looked[0] += cold.looked();
            looked[1] += warm.looked();
            assert_eq!(cold.refusal(), warm.refusal());
            for _ in 0..300 {
                let axis = cold.axis(limit * random.part(), random.next(-PI, PI));
                let (a, b) = (cold.state(&axis).unwrap(), warm.state(&axis).unwrap());
                let opposed =
                    matches!((a, b), (AxisState::Free, AxisState::Blocked) | (AxisState::Blocked, AxisState::Free));
                assert!(!opposed, "one finds free what the other finds blocked");
                differing += usize::from(a != b);
            }
            let off = (cold.shares()[0] - warm.shares()[0]).abs();
            assert!(off < 1e-2, "{off}");
        }
        // A ball's center is known to be outside from the contact before, a bull-nose's neighborhood reaches
        // to the next ones. The twelve contacts of the ball are 0.36 mm apart, its center 3 mm from the hub.
        let cold = if tool.name == "BALL" { 2 } else { 1 };
        assert_eq!(walk.counts(), [cold, contacts.len() - cold], "{}", tool.name);
        assert!(differing < 10 * contacts.len(), "{differing} of {}", 300 * contacts.len());
        println!("{}: {differing} axes differ; looked at {looked:?}", tool.name);
    }
}

#[test]
fn the_nearest_free_axis_and_ways_are_those_of_dense_samples() {
    let tool = ToolBuilder::new(1, "BALL", Cutter::ball(6.0).unwrap(), 10.0, 90.0).shank(6.0).build().unwrap();
    let post = (cuboid([8.0, -6.0, 0.0], [20.0, 6.0, 70.0]), false);
    let solids = [(cuboid([-150.0, -150.0, -30.0], [150.0, 150.0, 0.0]), true), post];
    let map = space(&tool, &solids, &wide()).map(&on_floor()).unwrap();
    let mut random = Random::new(0x6c62_272e_07bb_0142);
    let (mut open, mut shut) = (0, 0);
    for _ in 0..300 {
        let aim = map.axis(1.5 * random.part(), random.next(-0.9, 0.9));
        let found = map.nearest_free(&aim).unwrap();
        assert!(map.is_free(&found));
        let away = (found - aim).norm();
        for _ in 0..400 {
            let other = map.axis(1.5 * random.part(), random.next(-1.5, 1.5));
            assert!(!map.is_free(&other) || (other - aim).norm() > away - 5e-5);
        }
        assert!(map.way_is_free(&found, &found));
        let from = map.axis(1.3 * random.part(), random.next(-PI, PI));
        let to = map.axis(1.3 * random.part(), random.next(-PI, PI));
        let free = map.way_is_free(&from, &to);
        let samples = (0..=2000).all(|k| {
            let t = f64::from(k) / 2000.0;
            map.is_free(&(from * (1.0 - t) + to * t))
        });
        assert!(!free || samples, "a way that is called free leaves the free cells");
        open += u32::from(free);
        shut += u32::from(!samples);
    }
    assert!(open > 30 && shut > 30, "{open} {shut}");
    // Round the post there are ways, through it there is none.
    let [left, right] = [1.0, -1.0].map(|side| map.axis(1.0, 1.3 * side));
    assert!(map.is_free(&left) && map.is_free(&right) && !map.way_is_free(&left, &right));
    assert!(map.way_is_free(&left, &Vector::z()) && map.way_is_free(&Vector::z(), &right));
    assert!(!map.way_is_free(&left, &-left) && !map.way_is_free(&left, &Vector::repeat(f64::NAN)));
    assert_eq!(map.nearest_free(&Vector::zeros()), None);
    assert_eq!(map.state(&-Vector::z()), None);
}

#[test]
fn a_tool_inside_of_a_solid_and_a_ball_that_does_not_fit_are_reported() {
    let tool = ToolBuilder::new(1, "BALL", Cutter::ball(6.0).unwrap(), 10.0, 90.0).build().unwrap();
    let block = [(cuboid([-150.0, -150.0, -300.0], [150.0, 150.0, 0.0]), true)];
    let space = space(&tool, &block, &OrientationSettings::default());
    let inward = SurfaceContact { normal: -Vector::z(), ..on_floor() };
    assert_eq!(space.map(&inward).unwrap().refusal(), Some(Refusal::Inside));
    let below = SurfaceContact { point: Point::new(0.0, 0.0, -0.05), ..on_floor() };
    assert_eq!(space.map(&below).unwrap().refusal(), Some(Refusal::Cutter));
    assert_eq!(space.map(&below).unwrap().nearest_free(&Vector::z()), None);
    let above = SurfaceContact { point: Point::new(0.0, 0.0, -0.015), ..on_floor() };
    assert_eq!(space.map(&above).unwrap().refusal(), None);
    let mut walk = space.walk();
    for _ in 0..3 {
        assert_eq!(walk.next(&inward).unwrap().refusal(), Some(Refusal::Inside));
    }
}

#[test]
fn bad_input_is_named() {
    let tool = ToolBuilder::new(1, "BALL", Cutter::ball(6.0).unwrap(), 10.0, 90.0).build().unwrap();
    let settings = OrientationSettings::default();
    let floor = [(cuboid([-50.0, -50.0, -30.0], [50.0, 50.0, 0.0]), true)];
    let free = space(&tool, &floor, &settings);
    let refusal = |contact: SurfaceContact| free.map(&contact).unwrap_err();
    let nan = f64::NAN;
    assert!(matches!(
        refusal(SurfaceContact { point: Point::new(nan, 0.0, 0.0), ..on_floor() }),
        OrientationError::NotFinite { what: "point", .. }
    ));
    assert!(matches!(
        refusal(SurfaceContact { normal: Vector::new(0.0, f64::INFINITY, 0.0), ..on_floor() }),
        OrientationError::NotFinite { what: "normal", .. }
    ));
    assert!(matches!(
        refusal(SurfaceContact { normal: Vector::zeros(), ..on_floor() }),
        OrientationError::NoNormal { length, .. } if length == 0.0
    ));
    assert!(matches!(refusal(SurfaceContact { feed: Vector::z(), ..on_floor() }), OrientationError::NoFeed { .. }));
    assert!(matches!(refusal(SurfaceContact { feed: Vector::zeros(), ..on_floor() }), OrientationError::NoFeed { .. }));
    let edge =
        refusal(SurfaceContact { curvatures: Some([(f64::INFINITY, Vector::x()), (0.0, Vector::y())]), ..on_floor() });
    assert!(edge.to_string().contains("an edge or a corner has no normal of its own"), "{edge}");
    let skew = SurfaceContact { curvatures: Some([(0.1, Vector::x()), (0.0, Vector::x())]), ..on_floor() };
    assert!(matches!(refusal(skew), OrientationError::Directions { .. }));

    let refused = |settings: OrientationSettings| OrientationSpace::new(&tool, &[], &settings).unwrap_err().to_string();
    let default = settings;
    assert!(refused(OrientationSettings { gouge: 0.0, ..default }).starts_with("gouge_mm = 0 must be"));
    assert!(refused(OrientationSettings { clearance: nan, ..default }).starts_with("clearance_mm = NaN must be"));
    assert!(refused(OrientationSettings { tilt_limit: 2.0, ..default }).contains("above 0 and at most 90"));
    assert!(refused(OrientationSettings { finest_cell: 1e-5, ..default }).starts_with("finest_cell_deg"));
    assert!(refused(OrientationSettings { largest_cell: 1.0, ..default }).starts_with("largest_cell_deg"));
    let cone = ToolBuilder::new(1, "CONE", Cutter::chamfer(8.0, 90.0, 0.0).unwrap(), 4.0, 90.0).build().unwrap();
    let message = OrientationSpace::new(&cone, &[], &settings).unwrap_err().to_string();
    assert!(message.contains("\"CONE\"") && message.contains("its bottom rises from the axis as a cone"), "{message}");
    let nothing = Tool { bodies: Vec::new(), ..tool.clone() };
    let message = OrientationSpace::new(&nothing, &[], &settings).unwrap_err().to_string();
    assert!(message.contains("it has no cutting end"), "{message}");
    let mut open = box_mesh(&floor[0].0);
    open.triangles.pop();
    let obstacle = [Obstacle { name: "open", mesh: &open, cut: true }];
    let message = OrientationSpace::new(&tool, &obstacle, &settings).unwrap_err().to_string();
    assert!(message.contains("\"open\" does not bound a solid"), "{message}");
}
