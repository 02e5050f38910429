//! Great circles of the tool axis at and near poles of the rotary axes, on every library machine that has two
//! of them.
//!
//! *Oracle.* The forward kinematics of every sample against the programmed circle, at the share of the way
//! that its tip has come, or, where the tip is at rest, against the circle's nearest point.
//!
//! *Corners that the generator visits*: circles that begin, end, or have their closest approach in the pole
//! itself, at distances from 1e-9 to 20 degrees; all azimuths, in steps and at random; rapid and feed; with
//! and without motion of the tip; from home and from any turn of the first rotary joint; tilts at the end of
//! travel on one side of the pole.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::path::Path;

use crate::common::{Program, Random, Run, for_all, motion, run_with, tool};
use proveout_controller::{Dynamics, Event, LimitKind, Settings};
use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_nc::{Motion, Op};

const LENGTH: f64 = 120.0;
/// Distances of a circle from the pole, degrees.
const DISTANCES: [f64; 12] = [0.0, 1e-9, 1e-6, 0.0005, 0.00099, 0.01, 0.1, 0.7, 1.0, 3.0, 10.0, 20.0];
/// The cone of the control by default, radian.
const CONE: f64 = Machine::USUAL_POLE_CONE;
/// What the joints' polynomials may leave of the circle, and what counts as standing in the pole, radian.
const FOLLOWED: f64 = 2e-8;
const ROUNDING: f64 = 1.1e-6;

/// Machines of the library with two rotary joints.
fn library() -> Vec<(String, Machine)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let mut found: Vec<(String, Machine)> = std::fs::read_dir(folder)
        .expect("the folder machines/")
        .map(|e| e.expect("entry").path())
        .filter(|p| p.join("machine.toml").is_file())
        .map(|p| {
            let name = p.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            (name, Machine::read(&p).unwrap_or_else(|e| panic!("{e}")))
        })
        .filter(|(_, m)| m.rotary_joints().len() == 2)
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    assert!(found.len() >= 14, "{} machines", found.len());
    found
}

/// The same machine without end stops of linear joints: their travel depends on the part and its place, which
/// is not the matter here.
fn with_free_slides(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    for joint in machine.joints.iter_mut().filter(|j| !j.is_rotary()) {
        joint.travel = None;
    }
    machine
}

/// A number of cases: the full count with `PROVEOUT_POLE_CASES=full`, or as many as it says.
fn cases(default: u64, full: u64) -> u64 {
    match std::env::var("PROVEOUT_POLE_CASES") {
        Ok(text) if text == "full" => full,
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("PROVEOUT_POLE_CASES is a number or full, not {text}")),
        Err(_) => default,
    }
}

/// The point of the table frame at which base coordinates are zero.
fn zero(machine: &Machine) -> Vector {
    machine.program_zero().map_or_else(Vector::zeros, |p| p.coords)
}

/// A motion to a tip in base coordinates with a tool axis.
fn vector(tip: &Vector, axis: &Vector) -> Motion {
    let mut motion = motion(&[('X', tip.x), ('Y', tip.y), ('Z', tip.z)]);
    motion.tool_axis = Some((*axis).into());
    motion.tool_axis_base = motion.tool_axis;
    motion
}

/// Largest angle of the samples of blocks from the programmed circle.
fn off_circle(run: &Run, machine: &Machine, blocks: &[u32], [from, to]: [&ToolPose; 2]) -> f64 {
    let way = to.tip - from.tip;
    let mut worst = 0.0_f64;
    let mut seen = 0;
    for s in run.all.samples.iter().filter(|s| blocks.contains(&s.block)) {
        let pose = machine.forward(&s.actual, LENGTH);
        let share = if way.norm() > 1e-3 {
            ((pose.tip - from.tip).dot(&way) / way.norm_squared()).clamp(0.0, 1.0)
        } else {
            // The place of the circle that is nearest.
            let across = from.axis.cross(&to.axis).normalize();
            let ahead = across.cross(&from.axis);
            (pose.axis.dot(&ahead).atan2(pose.axis.dot(&from.axis)) / from.angle_to(to)).clamp(0.0, 1.0)
        };
        let on = from.interpolated(to, share);
        assert!((pose.tip - (from.tip + way * share)).norm() < 2e-6, "the tip leaves its line");
        worst = worst.max(on.angle_to(&pose));
        seen += 1;
    }
    assert!(seen > 3, "{seen} samples");
    worst
}

fn blocks_of(run: &Run, line: u32) -> Vec<u32> {
    run.all.blocks.iter().filter(|b| b.line == line).map(|b| b.index).collect()
}

fn over_travel(run: &Run) -> Vec<(usize, f64)> {
    let found = run.all.events.iter().filter_map(|e| match e {
        Event::Limit { joint: Some(joint), value, kind: LimitKind::Travel, .. } => Some((*joint, *value)),
        _ => None,
    });
    found.collect()
}

fn ideal() -> Settings {
    Settings { dynamics: Dynamics::Ideal, ..Settings::default() }
}

/// Shortest time of a joint from rest to rest under its limits, by the trapezoid of velocity, without jerk.
fn shortest(machine: &Machine, joint: usize, way: f64) -> f64 {
    let j = &machine.joints[joint];
    let v = j.rapid_velocity.unwrap_or(f64::INFINITY).min(j.max_velocity.unwrap_or(f64::INFINITY));
    let a = j.max_acceleration.unwrap_or(f64::INFINITY);
    if way * a >= v * v { way / v + v / a } else { 2.0 * (way / a).sqrt() }
}

/// A great circle out of the pole in which the machine is at home turns the first rotary joint to the
/// side that it needs, by half a turn at most, and tilts then. No azimuth takes longer than the joints need.
#[test]
fn a_pole_is_left_in_any_direction() {
    let step = if cases(0, 1) > 0 { 1 } else { 15 };
    let mut tried = 0;
    for (name, machine) in library() {
        let machine = with_free_slides(&machine);
        let home = machine.home();
        let start = machine.forward(&home, LENGTH);
        let Some(pole) = machine.poles(&home).find(|p| (p - start.axis).norm() < 1e-9) else { continue };
        let first = machine.rotary_joints()[0];
        let across = pole.cross(&Vector::new(0.48, 0.64, 0.6)).normalize();
        for degrees in (0..360).step_by(step) {
            let azimuth = f64::from(degrees as u32).to_radians();
            let direction = across * azimuth.cos() + pole.cross(&across) * azimuth.sin();
            let axis = pole * 20_f64.to_radians().cos() + direction * 20_f64.to_radians().sin();
            let tip = start.tip.coords + Vector::new(5.0, 5.0, -30.0);
            let end = ToolPose { tip: Point::from(tip), axis };
            for rapid in [true, false] {
                let block = vector(&(tip - zero(&machine)), &axis);
                let op = if rapid { Op::Rapid(block) } else { Op::Linear(block) };
                let program = Program::default().change(1).edge(0).edge(1).tcp_great_circle().feed(100.0).op(op);
                let run = run_with(&program, &machine, &[tool(1, LENGTH)], &ideal());
                let from = machine.forward(&home, LENGTH);
                let blocks = blocks_of(&run, 6);
                let off = off_circle(&run, &machine, &blocks, [&from, &end]);
                assert!(off < FOLLOWED, "{name} azimuth {degrees}: {off} rad off the circle");
                let arrived = machine.forward(&run.summary.end_position, LENGTH);
                assert!(arrived.angle_to(&end) < 1e-8 && (arrived.tip - end.tip).norm() < 1e-6, "{name} {degrees}");
                // Half a turn at most; a 45 degree head adds what it swings while it tilts.
                let turned = (run.summary.end_position[first] - home[first]).abs();
                assert!(turned < 191_f64.to_radians(), "{name} azimuth {degrees}: turned by {}", turned.to_degrees());
                assert_eq!(over_travel(&run), [], "{name} azimuth {degrees}");
                assert!(run.summary.max_axis_error < FOLLOWED && run.summary.max_contour_error_mm < 2e-6);
                if rapid {
                    // What each part needs at least: every joint from rest to rest over the way between its
                    // ends.
                    let (mut time, mut least) = (0.0, 0.0);
                    for block in run.all.blocks.iter().filter(|b| b.line == 6) {
                        let pieces: Vec<_> = run.all.pieces.iter().filter(|p| p.block == block.index).collect();
                        let way = pieces[pieces.len() - 1].joints[1] - pieces[0].joints[0];
                        let joints = 0..machine.joints.len();
                        least += joints.map(|j| shortest(&machine, j, way[j].abs())).fold(0.0, f64::max);
                        time += block.end_time - block.start_time;
                    }
                    // Jerk is not in it, nor the arc on which the linear joints follow a turn.
                    assert!(time < 2.5 * least, "{name} azimuth {degrees}: {time} s, least {least} s");
                    let bound = run.summary.path_bound_s.expect("a bound");
                    assert!(
                        run.summary.total_s < 1.06 * bound,
                        "{name} {degrees}: {} of {bound} s",
                        run.summary.total_s
                    );
                }
                tried += 1;
            }
        }
    }
    assert!(tried >= 10 * 2 * 24, "{tried}");
}

/// A random circle next to a pole.
#[derive(Debug)]
struct Case {
    from: Vector,
    to: Vector,
    tips: [Vector; 2],
    rapid: bool,
    #[expect(dead_code, reason = "printed with a case that fails")]
    at: &'static str,
    /// Turns of the first rotary joint before the block.
    turns: f64,
    /// Which branch it begins on, where travel leaves the choice.
    branch: usize,
}

/// Angle from the pole up to which the tilt joint may go on one side at least, at most 60 degrees.
fn room(machine: &Machine, pole: &Vector) -> f64 {
    let way = pole.cross(&Vector::new(0.48, 0.64, 0.6)).normalize();
    let reached = |degrees: u32| {
        let angle = f64::from(degrees).to_radians();
        !begins(machine, &(pole * angle.cos() + way * angle.sin())).is_empty()
    };
    (1..=60).take_while(|k| reached(*k)).last().map_or(0.0, |k| f64::from(k).to_radians())
}

/// Joints of the branches on which a tool axis is within the travel of the rotary joints.
fn begins(machine: &Machine, axis: &Vector) -> Vec<JointValues> {
    let home = machine.home();
    let rotary = machine.rotary_joints();
    let both = [0, 1].into_iter().filter_map(|branch| machine.on_branch(axis, branch, &home));
    both.filter(|q| rotary.iter().all(|&j| machine.joints[j].travel_violation(q[j]).is_none())).collect()
}

fn case(r: &mut Random, pole: &Vector, room: f64, number: u64) -> Case {
    let distance = DISTANCES[(number % DISTANCES.len() as u64) as usize].to_radians();
    let azimuth = if r.unit() < 0.3 { (r.unit() * 24.0).floor() * 15.0 } else { r.range(0.0, 360.0) }.to_radians();
    let across = pole.cross(&Vector::new(0.48, 0.64, 0.6)).normalize();
    let along = across * azimuth.cos() + pole.cross(&across) * azimuth.sin();
    let aside = pole.cross(&along);
    let closest = pole * distance.cos() + aside * distance.sin();
    let at = |s: f64| closest * s.cos() + along * s.sin();
    let far = 0.7 * room;
    let [a, b] = [r.range(0.1, 1.0) * far, r.range(0.1, 1.0) * far];
    let (from, to, name) = match (r.unit() * 4.0) as u32 {
        0 => (at(0.0), at(b), "begin"),
        1 => (at(-a), at(0.0), "end"),
        _ => (at(-a), at(b), "middle"),
    };
    let tip = Vector::new(r.range(-20.0, 20.0), r.range(-20.0, 20.0), r.range(20.0, 60.0));
    let moves = r.unit() < 0.8;
    let to_tip = if moves { tip + Vector::new(r.range(-30.0, 30.0), r.range(-30.0, 30.0), 10.0) } else { tip };
    let turns = (r.unit() * 5.0).floor() - 2.0;
    Case { from, to, tips: [tip, to_tip], rapid: r.unit() < 0.5, at: name, turns, branch: (r.unit() * 2.0) as usize }
}

/// Least angle between a pole and a circle, and whether it lies between its ends.
fn closest_approach(from: &Vector, to: &Vector, pole: &Vector) -> (f64, bool) {
    let angle = |a: &Vector, b: &Vector| a.cross(b).norm().atan2(a.dot(b));
    let normal = from.cross(to).normalize();
    let ahead = normal.cross(from);
    let s = pole.dot(&ahead).atan2(pole.dot(from));
    if s > 1e-12 && s < angle(from, to) - 1e-12 {
        (normal.dot(pole).abs().asin(), true)
    } else {
        (angle(from, pole).min(angle(to, pole)), false)
    }
}

/// Name, machine, and its poles with the tilt that is free round each.
type Mechanism = (String, Machine, Vec<(Vector, f64)>);

/// Machines with free slides, and where an end stop keeps the tool out of its poles, with free tilt.
fn mechanisms() -> Vec<Mechanism> {
    let poles = |machine: &Machine| -> Vec<(Vector, f64)> {
        let all = machine.poles(&machine.home()).map(|p| (p, room(machine, &p)));
        all.filter(|p| p.1 > 0.3).collect()
    };
    let all = library().into_iter().map(|(name, machine)| {
        let mut machine = with_free_slides(&machine);
        let mut found = poles(&machine);
        if found.is_empty() {
            let second = machine.rotary_joints()[1];
            machine.joints[second].travel = None;
            found = poles(&machine);
        }
        assert!(!found.is_empty(), "{name} has no pole");
        (name, machine, found)
    });
    all.collect()
}

/// Circles at all distances from all poles that a machine reaches: the axis is on the programmed circle at
/// every sample, or inside of the cone and reported; where an end stop forbids it, that is reported.
#[test]
#[ignore = "nightly, 26 s"]
fn circles_are_followed_at_any_distance_from_a_pole() {
    use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
    let count = cases(3, 300) * DISTANCES.len() as u64;
    let [followed, crossed, stopped] = [AtomicU32::new(0), AtomicU32::new(0), AtomicU32::new(0)];
    for (name, machine, poles) in &mechanisms() {
        for_all(0..count, |seed| {
            let mut r = Random::new(seed + 1000);
            let (pole, room) = poles[(r.unit() * poles.len() as f64) as usize % poles.len()];
            let c = case(&mut r, &pole, room, seed);
            let begins = begins(machine, &c.from);
            let Some(mut begin) = begins.get(c.branch % begins.len().max(1)).copied() else { return };
            let &[first, second] = machine.rotary_joints() else { unreachable!() };
            let turned = begin[first] + std::f64::consts::TAU * c.turns;
            if machine.joints[first].travel_violation(turned).is_none() {
                begin[first] = turned;
            }
            let letter = |j: usize| machine.joints[j].name.chars().next().expect("a letter");
            let [from, to] = c.tips;
            let base = from - zero(machine);
            let place = [
                ('X', base.x),
                ('Y', base.y),
                ('Z', base.z),
                (letter(first), begin[first]),
                (letter(second), begin[second]),
            ];
            let block = vector(&(to - zero(machine)), &c.to);
            let program = Program::default()
                .change(1)
                .exact_stop()
                .tcp(true)
                .g0(&place)
                .tcp_great_circle()
                .feed(80.0)
                .op(if c.rapid { Op::Rapid(block) } else { Op::Linear(block) });
            let dynamics = if seed % 3 == 0 { Dynamics::Planned } else { Dynamics::Ideal };
            let run = run_with(&program, machine, &[tool(1, LENGTH)], &Settings { dynamics, ..ideal() });
            let ends = [(from, c.from), (to, c.to)].map(|(tip, axis)| ToolPose { tip: Point::from(tip), axis });
            let off = off_circle(&run, machine, &blocks_of(&run, 7), [&ends[0], &ends[1]]);
            let nearest = poles.iter().map(|(p, _)| closest_approach(&c.from, &c.to, p));
            let (distance, between) = nearest.fold((f64::INFINITY, false), |a, b| if b.0 < a.0 { b } else { a });
            let values: Vec<f64> = run
                .all
                .events
                .iter()
                .filter_map(|e| match e {
                    Event::LeavesCircle { angle, in_cone, reason, .. } => {
                        assert!(in_cone, "{name} {seed} {c:?}: {reason}");
                        Some(*angle)
                    }
                    _ => None,
                })
                .collect();
            let what = || format!("{name} {seed} {c:?}, {} degrees from the pole", distance.to_degrees());
            if between && distance > ROUNDING && distance < CONE {
                assert_eq!(values.len(), 1, "{}", what());
                assert!(
                    (values[0] - distance).abs() < 1e-3 * distance + 1e-9 && off < distance + FOLLOWED,
                    "{}",
                    what()
                );
                crossed.fetch_add(1, Relaxed);
            } else {
                assert!(values.is_empty(), "{}: {values:?}", what());
                let rounding = if distance <= ROUNDING { ROUNDING } else { 0.0 };
                assert!(off < FOLLOWED + rounding, "{}: {off} rad off the circle", what());
                followed.fetch_add(1, Relaxed);
            }
            // What the summary says is what the samples show.
            assert!(run.summary.max_axis_error >= off - FOLLOWED, "{}", what());
            assert!(run.summary.max_axis_error < distance.clamp(ROUNDING, CONE) + FOLLOWED, "{}", what());
            assert!(run.summary.max_contour_error_mm < 2e-6, "{}", what());
            let end = machine.forward(&run.summary.end_position, LENGTH);
            assert!(end.angle_to(&ends[1]) < ROUNDING && (end.tip - ends[1].tip).norm() < 1e-6, "{}", what());
            // An endless table may always turn: only the tilt can be stopped, and only where the circle goes
            // there on both branches.
            let over = over_travel(&run);
            let both =
                (0..=200).map(|k| begins_on(machine, &ends[0].interpolated(&ends[1], f64::from(k) / 200.0).axis));
            let within = both.fold([true; 2], |a, b| [a[0] && b[0], a[1] && b[1]]);
            if machine.joints[first].travel.is_none() && within.iter().any(|w| *w) {
                let branch = machine.branch_of(&begin);
                let stays = branch.is_none_or(|b| within[b]);
                assert!(over.is_empty() || !stays, "{}: {over:?}", what());
            }
            stopped.fetch_add(u32::from(!over.is_empty()), Relaxed);
            let broken = run.all.events.iter().find(|e| {
                matches!(e, Event::Limit { kind: LimitKind::Velocity | LimitKind::Acceleration | LimitKind::Jerk, .. })
            });
            assert!(broken.is_none(), "{}: {broken:?}", what());
        });
    }
    let counts = [followed, crossed, stopped].map(AtomicU32::into_inner);
    println!("{counts:?} followed, crossed, with an end stop");
    assert!(counts[0] > 200 && counts[1] > 20, "{counts:?}");
}

/// Whether each branch points the tool along an axis within the travel of the tilt joint.
fn begins_on(machine: &Machine, axis: &Vector) -> [bool; 2] {
    let second = machine.rotary_joints()[1];
    [0, 1].map(|branch| {
        let q = machine.on_branch(axis, branch, &machine.home());
        q.is_some_and(|q| machine.joints[second].travel_violation(q[second]).is_none())
    })
}
