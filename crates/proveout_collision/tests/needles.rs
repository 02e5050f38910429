//! Needles and plates at known small distances from the parts of a tool: nothing that keeps apart is called a
//! contact.
//!
//! `PROVEOUT_NEEDLES=5000 cargo test -p proveout_collision --test collision needles::` makes five thousand of
//! each kind; without the variable it is a hundredth.
//!
//! A long thin body is put at its distance by construction. At a point of the tool with outward normal n (on
//! a face, the side of a cylinder or cone, a rim) a box is turned at random until one of its corners, edges
//! or faces is its lowest along n, and shifted until that lies at the distance. Two parallel planes then have
//! the tool on one side and the box on the other, so that the distance is exact.
//!
//! Motions: the tool goes straight along a direction across n, through the place in the middle of its way.
//! The distance of two convex bodies along a straight way is convex, so that it is least in the middle. Or
//! the table turns about an axis through the needle's nearest place, along n: there the planes turn into
//! themselves.

use std::f64::consts::TAU;
use std::path::Path;

use nalgebra::Matrix3;
use proveout_collision::{Fixture, Interference};
use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector, box_mesh};
use proveout_machine::{JointValues, Machine};
use proveout_tool::{Cutter, HolderSection, Tool, ToolBuilder};

use crate::common::Random;

const GAUGE: f64 = 150.0;

/// X Y Z in the tool; a rotary axis in the table along any direction through any point.
fn machine(point: &Point, axis: &Vector) -> Machine {
    let linear = |name: &str, parent: &str, direction: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\n\
             direction = {direction}\ntravel_mm = [-2000, 2000]\n"
        )
    };
    let text = [
        "name = \"test\"\n".to_owned(),
        linear("X", "base", "[1, 0, 0]"),
        linear("Y", "X", "[0, 1, 0]"),
        linear("Z", "Y", "[0, 0, 1]"),
        format!(
            "[[joint]]\nname = \"C\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"base\"\n\
             direction = [{:?}, {:?}, {:?}]\npoint_mm = [{:?}, {:?}, {:?}]\nsense = 1\n",
            axis.x, axis.y, axis.z, point.x, point.y, point.z
        ),
        "[spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nstart_time_s = 1\n\
         [table]\non = \"C\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [control]\ncycle_time_ms = 2\nblock_time_ms = 1\nrapid_mode = \"straight\"\ntool_change_time_s = 5\n\
         default_tolerance_mm = 0.01\n"
            .into(),
    ]
    .concat();
    Machine::from_text(Path::new("test.toml"), &text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A convex tool of one radius: the shank as thick as the cutter, no holder. So the part that is near is all
/// of it.
fn tool(kind: usize) -> Tool {
    let cutter = match kind {
        0 => Cutter::flat(20.0),
        1 => Cutter::bull_nose(20.0, 3.0),
        _ => Cutter::flat(6.0),
    };
    let diameter = if kind == 2 { 6.0 } else { 20.0 };
    ToolBuilder::new(1, "T", cutter.expect("cutter"), 55.0, GAUGE)
        .shank(diameter)
        .holder([HolderSection { diameter: 0.9 * diameter, top_diameter: 0.9 * diameter, length: 20.0 }])
        .build()
        .expect("tool")
}

/// A point of the tool over its tip and an outward normal there: on the bottom, on its rim or round corner,
/// on the side.
fn place(random: &mut Random, kind: usize) -> (Point, Vector) {
    let (radius, corner) = [(10.0, 0.0), (10.0, 3.0), (3.0, 0.0)][kind];
    let angle = random.next(0.0, TAU);
    let (s, c) = angle.sin_cos();
    let at = |r: f64, z: f64| Point::new(r * c, r * s, z);
    match random.pick(4) {
        0 => (at(random.next(0.0, radius - corner), 0.0), -Vector::z()),
        1 => (at(radius, random.next(corner, 100.0)), Vector::new(c, s, 0.0)),
        _ => {
            let (down, out) = random.next(0.02, 1.55).sin_cos();
            let normal = Vector::new(out * c, out * s, -down);
            (at(radius - corner + corner * out, corner - corner * down), normal)
        }
    }
}

/// A needle, rod or plate in a frame of its own, its middle at the origin.
fn thin(random: &mut Random) -> Vector {
    let edge = |random: &mut Random, low: f64, high: f64| 10_f64.powf(random.next(low, high));
    let (a, b) = (edge(random, -2.0, 0.3), edge(random, -2.0, 0.3));
    let long = edge(random, 1.0, 2.7);
    match random.pick(4) {
        // A plate, a needle, a rod of square section, any box.
        0 => Vector::new(a, edge(random, 1.0, 2.3), long),
        1 => Vector::new(a, b, long),
        2 => Vector::new(a, a, long),
        _ => Vector::new(edge(random, -1.0, 1.7), edge(random, -1.0, 1.7), long),
    }
}

/// A body near the tool whose tip is at the origin: the box in the frame of the table, and what is known of
/// it.
struct Near {
    mesh: TriMesh,
    /// Where its planes have their distance, and their normal.
    at: Point,
    normal: Vector,
    distance: f64,
}

fn near(random: &mut Random, kind: usize) -> Near {
    let (on_tool, normal) = place(random, kind);
    let size = thin(random);
    let distance = 10_f64.powf(random.next(-3.0, -1.0));
    let mesh = box_mesh(&Aabb { min: Point::from(size * -0.5), max: Point::from(size * 0.5) });
    // Any turn; now and then a face or an edge of the box lies along the plane, or an axis along that of the
    // tool.
    let helper = if normal.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    let u = normal.cross(&helper).normalize();
    let frame = Matrix3::from_columns(&[u, normal.cross(&u), normal]);
    let small = |random: &mut Random| if random.yes() { 0.0 } else { 10_f64.powf(random.next(-8.0, -0.5)) };
    let turn = match random.pick(3) {
        0 => Pose::from_rpy(Vector::zeros(), random.next(0.0, TAU), random.next(0.0, TAU), random.next(0.0, TAU)),
        1 => Pose::from_rpy(Vector::zeros(), small(random), small(random), random.next(0.0, TAU)),
        _ => Pose::from_rpy(Vector::zeros(), small(random), TAU / 4.0 + small(random), random.next(0.0, TAU)),
    };
    let rotation = Pose { rotation: frame * turn.rotation, translation: Vector::zeros() };
    let turned = mesh.transformed(&rotation);
    let heights = || turned.positions.iter().map(|p| p.coords.dot(&normal));
    let lowest = heights().fold(f64::INFINITY, f64::min);
    // The lowest corner, or a place between all that are as low.
    let low: Vec<&Point> = turned.positions.iter().filter(|p| p.coords.dot(&normal) <= lowest + 1e-12).collect();
    let mut weights: Vec<f64> = low.iter().map(|_| random.part() + 1e-3).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    let foot = low.iter().zip(&weights).fold(Vector::zeros(), |all, (p, w)| all + p.coords * *w);
    let at = on_tool + normal * distance;
    let shift = Pose::from_translation(at.coords - foot);
    Near { mesh: turned.transformed(&shift), at, normal, distance }
}

fn cases() -> u64 {
    std::env::var("PROVEOUT_NEEDLES").ok().and_then(|n| n.parse().ok()).unwrap_or(50)
}

/// The joints with the tip of the tool at a place.
fn at(tip: &Vector, c: f64) -> JointValues {
    let mut q = JointValues::ZERO;
    (q[0], q[1], q[2], q[3]) = (tip.x, tip.y, tip.z + GAUGE, c);
    q
}

fn check(machine: &Machine, case: &Near, kind: usize) -> Interference {
    let body = Fixture { name: "needle".into(), mesh: case.mesh.clone(), on_table: true };
    let mut check = Interference::new(machine, &[body], 0.0).expect("solids").with_proof();
    check.set_tool(Some(&tool(kind)));
    check
}

/// At a place the least distance is that of the planes, to a tenth of a micrometer.
#[test]
fn a_needle_beside_the_tool_has_its_distance() {
    let mut random = Random::new(0x2545_f491_4f6c_dd1d);
    let machine = machine(&Point::origin(), &Vector::z());
    for k in 0..2 * cases() {
        let kind = random.pick(3);
        let case = near(&mut random, kind);
        let mut check = check(&machine, &case, kind);
        let q = at(&Vector::zeros(), 0.0);
        check.check_piece(&q, &q, [0.0, 1.0], 0.0);
        let description = || format!("{k}, tool {kind}: {:?} along {:?}", case.at, case.normal);
        assert!(check.breaches().is_empty(), "{}: {} mm, {:?}", description(), case.distance, check.breaches());
        let least = check.least_clearances().iter().map(|l| l.proved).fold(f64::INFINITY, f64::min);
        assert!((least - case.distance).abs() <= 1e-6, "{}: {least} of {}", description(), case.distance);
    }
}

/// Straight past a needle, and with a needle that turns next to the tool. A gap of micrometers that lasts
/// over a whole turn takes seconds to prove, step by step, so that there are fewer of these.
#[test]
fn a_needle_that_is_passed_is_no_contact() {
    let mut random = Random::new(0x9e37_79b9_7f4a_7c15);
    for k in 0..2 * (cases() / 25).max(1) {
        let kind = random.pick(3);
        let case = near(&mut random, kind);
        let turns = k % 2 == 1;
        let machine = if turns { machine(&case.at, &case.normal) } else { machine(&Point::origin(), &Vector::z()) };
        let mut check = check(&machine, &case, kind);
        let (from, to) = if turns {
            let swing = random.next(0.1, 3.0);
            (at(&Vector::zeros(), -swing), at(&Vector::zeros(), swing * random.part()))
        } else {
            let any = Vector::new(random.next(-1.0, 1.0), random.next(-1.0, 1.0), random.next(-1.0, 1.0));
            let across = (any - case.normal * any.dot(&case.normal)).normalize();
            (at(&(across * random.next(-200.0, -1.0)), 0.0), at(&(across * random.next(1.0, 200.0)), 0.0))
        };
        let pieces = 1 + random.pick(3) as u32;
        for i in 0..pieces {
            let part = |i: u32| from.interpolated(to, f64::from(i) / f64::from(pieces));
            check.check_piece(&part(i), &part(i + 1), [f64::from(i), f64::from(i + 1)], 0.0);
        }
        assert!(
            check.breaches().is_empty(),
            "{k}, tool {kind}, turns {turns}: {:?} along {:?}, {} mm, {:?}",
            case.at,
            case.normal,
            case.distance,
            check.breaches()
        );
    }
}

/// The same needles, so much nearer that they reach into the tool: each is a contact.
#[test]
fn a_needle_in_the_tool_is_a_contact() {
    let mut random = Random::new(77);
    let machine = machine(&Point::origin(), &Vector::z());
    for k in 0..2 * cases() {
        let kind = random.pick(3);
        let mut case = near(&mut random, kind);
        let deep = Pose::from_translation(case.normal * -(case.distance + 0.5e-3));
        case.mesh = case.mesh.transformed(&deep);
        let mut check = check(&machine, &case, kind);
        let q = at(&Vector::zeros(), 0.0);
        check.check_piece(&q, &q, [0.0, 1.0], 0.0);
        assert!(!check.breaches().is_empty(), "{k}, tool {kind}: {:?} along {:?}", case.at, case.normal);
    }
}
