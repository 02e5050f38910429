//! Bodies against the in-process stock: injected events whose truth is a closed form, half of them hits by 1
//! to 100 micrometers, half of them misses that begin at the stated error.
//!
//! 25 by default, as many as `PROVEOUT_STOCK_EVENTS` says else (`PROVEOUT_STOCK_EVENTS=2500 cargo test
//! --workspace --test collision stock_events::`). The generator visits: fins of 0.2 to 1 mm, thinner and
//! thicker than a cell, grazed at their upper edge and at their end; pins, upright and turned any way against
//! the rays, passed sideways and swung past by 90 to 350 degrees, also where the swing does not reach; walls
//! that are run at; material inside of a solid body and in the cavity of a hollow one. Cells of another edge
//! along each axis, no multiple of the stock; a raw box that is far larger than the material that is grazed,
//! so that it does not decide.
#![allow(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::path::Path;

use proveout_collision::{Interference, JointMotion, Severity, StockCheck};
use proveout_geom::{Aabb, Point, Pose, ToolPose, TriMesh, Vector, box_mesh, rad};
use proveout_machine::{Attachment, JointValues, Machine, MachineBody};
use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
use proveout_tool::{Profile, Segment};

use crate::common::Random;

/// A distance that counts as none, mm: what ends the advancement, and the slack of iterated distances.
const TOLERANCE_MM: f64 = 0.006;
const MEMORY: u64 = 1 << 30;

/// X Y Z in the tool, B and C in the table.
fn machine() -> Machine {
    let joint = |name: &str, kind: &str, carries: &str, parent: &str, direction: &str, more: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"{kind}\"\ncarries = \"{carries}\"\nparent = \"{parent}\"\n\
             direction = {direction}\n{more}\n"
        )
    };
    let travel = "travel_mm = [-1000, 1000]";
    let text = [
        "name = \"test\"\n".to_owned(),
        joint("X", "linear", "tool", "base", "[1, 0, 0]", travel),
        joint("Y", "linear", "tool", "X", "[0, 1, 0]", travel),
        joint("Z", "linear", "tool", "Y", "[0, 0, 1]", travel),
        joint("B", "rotary", "workpiece", "base", "[0, 1, 0]", "point_mm = [0, 0, 40]\nsense = -1"),
        joint("C", "rotary", "workpiece", "B", "[0, 0, 1]", "point_mm = [0, 0, 0]\nsense = -1"),
        "[spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nstart_time_s = 1\n".into(),
        "[table]\non = \"C\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n".into(),
        "[control]\ncycle_time_ms = 2\nblock_time_ms = 1\nrapid_mode = \"straight\"\ntool_change_time_s = 5\ndefault_tolerance_mm = 0.01\n"
            .into(),
    ]
    .concat();
    Machine::from_text(Path::new("test.toml"), &text).unwrap_or_else(|e| panic!("{e}"))
}

fn body(machine: &Machine, name: &str, on: Option<&str>, mesh: TriMesh) -> MachineBody {
    let attached_to = on.map_or(Attachment::Base, |j| Attachment::Joint(machine.joint(j).expect("joint")));
    MachineBody { name: name.into(), role: name.into(), attached_to, mesh, mass: None, color: [0; 4], check: true }
}

fn block(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb { min: Point::from(min), max: Point::from(max) }
}

fn linear(x: f64, y: f64, z: f64) -> JointValues {
    let mut q = JointValues::ZERO;
    (q[0], q[1], q[2]) = (x, y, z);
    q
}

fn turned(c: f64) -> JointValues {
    let mut q = JointValues::ZERO;
    q[4] = c;
    q
}

/// Edges of cells.
fn cells(random: &mut Random) -> [f64; 3] {
    [0; 3].map(|_| random.next(0.35, 0.8))
}

/// What is known of an event.
struct Event {
    what: &'static str,
    machine: Machine,
    stock: TriDexel,
    mount: Pose,
    way: [JointValues; 2],
    /// True distance at a time between 0 and 1, mm; zero where they overlap.
    distance: Box<dyn Fn(f64) -> f64>,
    hit: bool,
}

/// Distance of two boxes, mm.
fn apart(a: &Aabb, b: &Aabb) -> f64 {
    let d = |i: usize| (a.min[i] - b.max[i]).max(b.min[i] - a.max[i]).max(0.0);
    (0..3).map(|i| d(i).powi(2)).sum::<f64>().sqrt()
}

fn moved(b: &Aabb, q: &JointValues) -> Aabb {
    let by = Vector::new(q[0], q[1], q[2]);
    Aabb { min: b.min + by, max: b.max + by }
}

/// A spindle that is a box goes along a straight line past boxes of material.
fn boxes(
    what: &'static str,
    material: Vec<Aabb>,
    cells: [f64; 3],
    head: Aabb,
    way: [JointValues; 2],
    hit: bool,
) -> Event {
    let mut machine = machine();
    machine.bodies = vec![body(&machine, "spindle", Some("Z"), box_mesh(&head))];
    let mut mesh = TriMesh::default();
    material.iter().for_each(|b| mesh.append(&box_mesh(b)));
    let stock = TriDexel::from_mesh(&mesh, cells, MEMORY).expect("solid");
    let distance = move |t: f64| {
        let head = moved(&head, &way[0].interpolated(way[1], t));
        material.iter().map(|b| apart(&head, b)).fold(f64::INFINITY, f64::min)
    };
    Event { what, machine, stock, mount: Pose::identity(), way, distance: Box::new(distance), hit }
}

/// By how much a face is off, mm: below zero for hits.
fn gap(random: &mut Random, hit: bool, cells: [f64; 3]) -> f64 {
    let by = random.next(0.001, 0.1);
    if hit { -by } else { Vector::from(cells).norm() + TOLERANCE_MM + by }
}

fn event(random: &mut Random, family: u32) -> Event {
    let (hit, cells) = (random.yes(), cells(random));
    let off = gap(random, hit, cells);
    let thin = random.next(0.2, 1.0);
    // A tower at the side makes the raw box larger than what is grazed.
    let tower = block([-60.0, 40.0, 0.0], [-50.0, 50.0, 60.0]);
    match family {
        // Over the upper edge of a fin, thin along x or y, in any horizontal direction.
        0 => {
            let (length, height) = (random.next(8.0, 30.0), random.next(10.0, 30.0));
            let x = random.next(-3.0, 3.0);
            let fin = if random.yes() { [x, -length, x + thin, length] } else { [-length, x, length, x + thin] };
            let fin = block([fin[0], fin[1], 0.0], [fin[2], fin[3], height]);
            let head = block([-3.0, -3.0, 0.0], [3.0, 3.0, 20.0]);
            // Away from the tower; the way may end over the fin or beyond it.
            let a = random.next(-1.5, 1.5);
            let (from, to) = (random.next(45.0, 80.0), random.next(0.0, 40.0));
            let way = [from, -to].map(|s| linear(s * a.cos(), s * a.sin(), height + off));
            boxes("fin, upper edge", vec![fin, tower], cells, head, way, hit)
        }
        // Past the end of a fin, at its vertical edge.
        1 => {
            let (length, height) = (random.next(8.0, 30.0), random.next(10.0, 30.0));
            let fin = block([-0.5 * thin, -length, 0.0], [0.5 * thin, length, height]);
            let head = block([-4.0, -6.0, 0.0], [4.0, 0.0, 20.0]);
            let y = -length - off;
            let z = random.next(1.0, height - 1.0);
            let way = [linear(-40.0, y, z), linear(random.next(20.0, 60.0), y, z)];
            boxes("fin, end", vec![fin, tower], cells, head, way, hit)
        }
        // Run at a wall, slanted; the motion ends there.
        2 => {
            let wall = block([0.0, -20.0, 0.0], [random.next(1.0, 9.0), 20.0, 30.0]);
            let head = block([-12.0, -4.0, 0.0], [0.0, 4.0, 20.0]);
            let (y, z) = (random.next(-15.0, 15.0), random.next(-10.0, 20.0));
            let from = linear(-random.next(10.0, 80.0), y + random.next(-9.0, 9.0), z + random.next(-9.0, 9.0));
            boxes("wall", vec![wall, tower], cells, head, [from, linear(-off, y, z)], hit)
        }
        // A pin, turned any way against the rays, passed by the side of a head.
        3 => {
            let radius = random.next(0.6, 3.0) * Vector::from(cells).norm();
            let (mount, stock) = pin(random, [0.0, 0.0], radius, cells);
            let mut machine = machine();
            let head = block([0.0, -5.0, -2.0], [8.0, 5.0, 12.0]);
            machine.bodies = vec![body(&machine, "spindle", Some("Z"), box_mesh(&head))];
            let (x, z) = (radius + off, random.next(4.0, 10.0));
            let way = [linear(x, -30.0, z), linear(x, random.next(6.0, 60.0), z)];
            let distance = move |t: f64| {
                let head = moved(&head, &way[0].interpolated(way[1], t));
                (round_apart([0.0, 0.0], &head) - radius).max(0.0)
            };
            Event { what: "pin, passed", machine, stock, mount, way, distance: Box::new(distance), hit }
        }
        // A pin on the table, swung past a post on the base.
        4 => {
            let radius = random.next(0.6, 3.0) * Vector::from(cells).norm();
            let arm = random.next(10.0, 60.0);
            // Where it is at C0, and from where to where it goes: past 0, or short of it.
            let swing = rad(random.next(90.0, 350.0));
            let reaches = random.next(0.0, 1.0) < 0.8;
            let begin = -random.next(0.2, 0.8) * swing;
            let (begin, end) = if reaches { (begin, begin + swing) } else { (rad(60.0), rad(60.0) + 0.7 * swing) };
            let (mount, stock) = pin(random, [arm, 0.0], radius, cells);
            let mut machine = machine();
            let post = block([arm + radius + off, -6.0, 2.0], [arm + radius + off + 9.0, 6.0, 14.0]);
            machine.bodies = vec![body(&machine, "post", None, box_mesh(&post))];
            let sense = if random.yes() { 1.0 } else { -1.0 };
            let way = [turned(sense * begin), turned(sense * end)];
            let at = move |t: f64| {
                let c = way[0][4] + (way[1][4] - way[0][4]) * t;
                (round_apart([arm * c.cos(), -arm * c.sin()], &post) - radius).max(0.0)
            };
            // Short of the post, or once more round to it from the other side: sampled finely, far from the
            // border.
            let least = (0..=20_000).map(|k| at(f64::from(k) / 20_000.0)).fold(f64::INFINITY, f64::min);
            let hit = if reaches { hit } else { least <= 0.0 };
            Event { what: "pin, swung", machine, stock, mount, way, distance: Box::new(at), hit }
        }
        // Material inside of a body: solid, or with room round it.
        _ => {
            let inner = block([-5.0, -5.0, 0.0], [5.0, 4.0, 8.0]);
            let room = if hit { None } else { Some(inner.expanded(off)) };
            let mut mesh = box_mesh(&inner.expanded(30.0));
            if let Some(room) = &room {
                let mut cavity = box_mesh(room);
                cavity.triangles.iter_mut().for_each(|t| t.swap(0, 1));
                mesh.append(&cavity);
            }
            let mut machine = machine();
            machine.bodies = vec![body(&machine, "hood", Some("Z"), mesh)];
            let stock = TriDexel::from_box(&inner, cells, MEMORY).expect("a block");
            let way = [linear(0.0, 0.0, 0.0), linear(0.0, 0.0, 0.0)];
            let at = if hit { 0.0 } else { off };
            Event { what: "inside", machine, stock, mount: Pose::identity(), way, distance: Box::new(move |_| at), hit }
        }
    }
}

/// An upright round pin, 16 mm high, on a table at a place; its rays are turned any way, and the box of the
/// raw stock with them.
fn pin(random: &mut Random, place: [f64; 2], radius: f64, cells: [f64; 3]) -> (Pose, TriDexel) {
    let axis = Vector::new(random.next(-1.0, 1.0), random.next(-1.0, 1.0), random.next(-1.0, 1.0)).normalize();
    let turn = if random.yes() { Pose::identity() } else { Pose::from_axis_angle(&axis, random.next(0.0, 3.0)) };
    let mount = Pose::from_translation(Vector::new(place[0], place[1], 0.0)) * turn;
    let up = turn.inverse().vector(&Vector::z());
    let stock = TriDexel::from_cylinder(&Point::origin(), &up, radius, 16.0, cells, MEMORY).expect("a pin");
    (mount, stock)
}

/// Distance of an upright line from a box, mm.
fn round_apart(center: [f64; 2], b: &Aabb) -> f64 {
    let d = |i: usize| (b.min[i] - center[i]).max(center[i] - b.max[i]).max(0.0);
    d(0).hypot(d(1))
}

#[test]
fn injected_events_none_missed_none_invented() {
    let count = std::env::var("PROVEOUT_STOCK_EVENTS").ok().and_then(|n| n.parse().ok()).unwrap_or(25);
    let mut random = Random::new(0x6c62_272e_07bb_0142);
    let (mut hits, mut misses) = ([0; 6], [0; 6]);
    for k in 0..count {
        let family = k % 6;
        let e = event(&mut random, family);
        let world = Interference::new(&e.machine, &[], 0.0).expect("solids");
        let mut check = StockCheck::new(&world, &e.stock, &e.mount, 0.0).expect("a box");
        assert!(check.flush().0.is_empty());
        let done = check
            .follow(&e.stock, &[JointMotion { joints: e.way, time: [0.0, 1.0], off: JointValues::ZERO, slack: 0.0 }]);
        assert_eq!(done, 1);
        let found = check.breaches();
        let description = || format!("event {k}, {}: {:?} {found:?}", e.what, e.way);
        if e.hit {
            assert!(!found.is_empty() && found[0].severity == Severity::Collision, "missed: {}", description());
            // Never late: until then they stay apart. Early by no more than the stated error.
            let time = found[0].time;
            let until = (0..=400).map(|k| (e.distance)(time * f64::from(k) / 401.0));
            assert!(until.fold(f64::INFINITY, f64::min) > 0.0 || time == 0.0, "late: {}", description());
            assert!((e.distance)(time) <= check.unseen_mm() + 2.0 * TOLERANCE_MM, "early: {}", description());
            hits[family as usize] += 1;
        } else {
            assert!(found.is_empty(), "invented: {}", description());
            misses[family as usize] += 1;
        }
    }
    println!("{count} events, hits {hits:?}, misses {misses:?}");
    if count >= 24 {
        assert!(hits.iter().sum::<u32>() * 4 > count && misses.iter().sum::<u32>() * 4 > count, "{hits:?} {misses:?}");
    }
}

fn cylinder(radius: f64, height: f64) -> Profile {
    let corners = [[0.0, 0.0], [radius, 0.0], [radius, height], [0.0, height]];
    Profile::new(corners.windows(2).map(|w| Segment::Line { from: w[0], to: w[1] }).collect()).expect("a cylinder")
}

/// A head follows the cutter through a slot that the cutter has just cut, in one stretch: what is gone is no
/// obstacle. A slot that is too narrow is one, from its first motion on.
#[test]
fn material_that_was_cut_before_is_no_obstacle() {
    for (width, meets) in [(10.0, false), (6.5, true)] {
        let mut machine = machine();
        // Two millimeters over the floor of the slot.
        let head = block([-3.5, -30.0, 2.0], [3.5, -20.0, 40.0]);
        machine.bodies = vec![body(&machine, "spindle", Some("Z"), box_mesh(&head))];
        let raw = block([-30.0, 0.0, 0.0], [30.0, 40.0, 20.0]);
        let mut stock = TriDexel::from_box(&raw, 0.5, MEMORY).expect("a block");
        let world = Interference::new(&machine, &[], 0.0).expect("solids");
        let mut check = StockCheck::new(&world, &stock, &Pose::identity(), 0.0).expect("a box");
        let cutter = cylinder(0.5 * width, 50.0);
        let at = |k: usize| linear(0.0, -15.0 + f64::from(k as u32), 5.0);
        let motions: Vec<JointMotion> = (0..60)
            .map(|k| JointMotion {
                joints: [at(k), at(k + 1)],
                time: [k as f64, k as f64 + 1.0],
                off: JointValues::ZERO,
                slack: 0.0,
            })
            .collect();
        let mut done = 0;
        let mut calls = 0;
        while done < motions.len() {
            let next = done + check.follow(&stock, &motions[done..]);
            assert!(next > done, "the first motion is always done");
            for (k, m) in motions.iter().enumerate().take(next).skip(done) {
                let pose = |q: &JointValues| ToolPose { tip: Point::new(q[0], q[1], q[2]), axis: Vector::z() };
                let motion = SweepMotion { from: pose(&m.joints[0]), to: pose(&m.joints[1]) };
                stock.sweep(&[SweepItem { id: k as u32, body: &cutter, action: Action::Remove, motion }]);
            }
            (done, calls) = (next, calls + 1);
        }
        assert!(calls > 1, "asked again after cutting");
        assert_eq!(check.motions(), 60);
        let found = check.breaches();
        if meets {
            // The face of the head is 20 mm back from the tip; the slot's side walls, 3.5 mm from its middle,
            // are 3.5 - 3.25 = 0.25 mm too near.
            assert_eq!(found.len(), 1, "{found:?}");
            assert!((33.5..=35.0).contains(&found[0].time), "{found:?}");
        } else {
            assert!(found.is_empty(), "{found:?}");
        }
    }
}

/// A table that turns flush in its cradle: no collision, whichever way it turns; a cheek that rises
/// next to the stock is still seen, also by a plate of 1 mm, which is all in the layer (1.57 mm) that counts
/// for nothing against the cradle's face.
#[test]
fn a_cradle_flush_with_the_table_is_no_collision_and_its_cheek_is() {
    for (cheek, height) in [(None, 30.0), (Some(25.0), 30.0), (None, 1.0), (Some(25.0), 1.0)] {
        let mut machine = machine();
        let mut cradle = box_mesh(&block([-80.0, -80.0, -30.0], [80.0, 80.0, 0.0]));
        if let Some(x) = cheek {
            cradle.append(&box_mesh(&block([x, -5.0, 0.5], [x + 10.0, 5.0, 40.0])));
        }
        let table = box_mesh(&block([-20.0, -20.0, -5.0], [20.0, 20.0, 0.0]));
        machine.bodies = vec![body(&machine, "cradle", Some("B"), cradle), body(&machine, "table", Some("C"), table)];
        let raw = block([-20.0, -20.0, 0.0], [20.0, 20.0, height]);
        let stock = TriDexel::from_box(&raw, 0.5, MEMORY).expect("a block");
        let world = Interference::new(&machine, &[], 0.5).expect("solids");
        let mut check = StockCheck::new(&world, &stock, &Pose::identity(), 0.0).expect("a box");
        let names = |list: &[std::sync::Arc<str>]| list.iter().map(|n| n.to_string()).collect::<Vec<_>>();
        assert_eq!(names(check.fixed_to_stock()), ["table"]);
        assert_eq!(names(&check.flush().0), ["cradle"]);
        let motion = JointMotion {
            joints: [turned(0.0), turned(rad(300.0))],
            time: [0.0, 1.0],
            off: JointValues::ZERO,
            slack: 0.0,
        };
        check.follow(&stock, &[motion]);
        let found = check.breaches();
        match cheek {
            None => assert!(found.is_empty(), "{found:?}"),
            // The corner of the stock is 28.28 mm from the axis.
            Some(_) => assert_eq!(found.iter().filter(|b| b.severity == Severity::Collision).count(), 1, "{found:?}"),
        }
    }
}

#[test]
fn a_start_in_collision_and_joints_that_are_no_numbers_are_named() {
    let mut machine = machine();
    let head = block([-10.0, -10.0, 0.0], [10.0, 10.0, 50.0]);
    machine.bodies = vec![body(&machine, "spindle", Some("Z"), box_mesh(&head))];
    let raw = block([-30.0, -30.0, 0.0], [30.0, 30.0, 20.0]);
    let stock = TriDexel::from_box(&raw, 1.0, MEMORY).expect("a block");
    let world = Interference::new(&machine, &[], 0.0).expect("solids");
    let fresh = || StockCheck::new(&world, &stock, &Pose::identity(), 0.0).expect("a box");

    let mut check = fresh();
    let up = JointMotion {
        joints: [linear(0.0, 0.0, 17.0), linear(0.0, 0.0, 60.0)],
        time: [2.0, 3.0],
        off: JointValues::ZERO,
        slack: 0.0,
    };
    check.follow(&stock, &[up]);
    let [b] = check.breaches() else { panic!("{:?}", check.breaches()) };
    assert_eq!((b.severity, b.time, b.ray_distance), (Severity::Collision, 2.0, 0.0));

    let mut check = fresh();
    let down = JointMotion {
        joints: [linear(0.0, 0.0, 60.0), linear(0.0, 0.0, 17.0)],
        time: [2.0, 3.0],
        off: JointValues::ZERO,
        slack: 0.0,
    };
    check.follow(&stock, &[down]);
    let [b] = check.breaches() else { panic!("{:?}", check.breaches()) };
    assert!(b.penetration_estimate.is_some_and(|d| (2.4..=3.0).contains(&d)), "{b:?}");

    let mut check = fresh();
    let nan = JointMotion {
        joints: [linear(0.0, f64::NAN, 60.0), linear(0.0, 0.0, 60.0)],
        time: [0.0, 1.0],
        off: JointValues::ZERO,
        slack: 0.0,
    };
    let apart = JointMotion {
        joints: [linear(0.0, 0.0, 60.0), linear(5.0, 0.0, 60.0)],
        time: [1.0, 2.0],
        off: JointValues::ZERO,
        slack: 0.0,
    };
    assert_eq!(check.follow(&stock, &[nan, apart]), 2);
    assert_eq!(check.breaches()[0].severity, Severity::QueryFailed);
    assert_eq!(check.breaches()[0].end_time, Some(2.0), "proved clear again");
}

/// The head stays 3 mm above the block on the straight motion, less the diagonal; joints that may leave it by
/// more than the rest are no longer clear, and those that may leave it by less are.
#[test]
fn joints_that_leave_the_straight_motion_are_held_against_the_distance() {
    let mut machine = machine();
    machine.bodies =
        vec![body(&machine, "spindle", Some("Z"), box_mesh(&block([-10.0, -10.0, 0.0], [10.0, 10.0, 50.0])))];
    let stock = TriDexel::from_box(&block([-30.0, -30.0, 0.0], [30.0, 30.0, 20.0]), 1.0, MEMORY).expect("a block");
    let world = Interference::new(&machine, &[], 0.0).expect("solids");
    let z = (0..5).find(|&j| linear(0.0, 0.0, 1.0)[j] != 0.0).expect("a joint along Z");
    for (off, breaches) in [(2.9, 0), (3.1, 1)] {
        let mut check = StockCheck::new(&world, &stock, &Pose::identity(), 0.0).expect("a box");
        let mut joint_off = JointValues::ZERO;
        joint_off[z] = off;
        let joints = [linear(-5.0, 0.0, 23.0), linear(5.0, 0.0, 23.0)];
        check.follow(&stock, &[JointMotion { joints, time: [0.0, 1.0], off: joint_off, slack: 0.0 }]);
        assert_eq!(check.breaches().len(), breaches, "{off}: {:?}", check.breaches());
    }
}

/// The last ray may lie a whole cell from the edges of a block: half a diagonal would miss what touches
/// its corner.
#[test]
fn a_corner_needs_the_whole_diagonal() {
    let mut machine = machine();
    machine.bodies = vec![body(&machine, "spindle", Some("Z"), box_mesh(&block([0.0; 3], [5.0; 3])))];
    let stock = TriDexel::from_box(&block([0.0; 3], [10.49; 3]), 1.0, MEMORY).expect("a block");
    let world = Interference::new(&machine, &[], 0.0).expect("solids");
    let mut check = StockCheck::new(&world, &stock, &Pose::identity(), 0.0).expect("a box");
    let q = linear(10.489, 10.489, 10.489);
    check.follow(&stock, &[JointMotion { joints: [q, q], time: [0.0, 1.0], off: JointValues::ZERO, slack: 0.0 }]);
    let [found] = check.breaches() else { panic!("{:?}", check.breaches()) };
    assert_eq!(found.severity, Severity::Collision);
    assert!((found.ray_distance - 0.989 * 2.0_f64.sqrt()).abs() < 1e-9, "{found:?}");
    assert!(found.ray_distance > 0.5 * check.unseen_mm() && found.ray_distance < check.unseen_mm());
}
