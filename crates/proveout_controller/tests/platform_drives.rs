//! Drives of a platform's legs: what they make of heave and tilt, against an integration of its own of the
//! legs by themselves.

#![allow(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::path::Path;

use crate::common::{Program, Run, run_with, tool};
use proveout_controller::{
    Controller, Dynamics, Event, LimitKind, Sample, Settings, servo::Plant, servo::without_drive,
};
use proveout_machine::{Drive, Encoder, Machine, VelocityGain};

/// Gain of the velocity loops, 1/s: 100 Hz.
const VELOCITY: f64 = 200.0 * std::f64::consts::PI;
/// Radii and height of the library machine, mm.
const MOVING: f64 = 150.0;
const FIXED: f64 = 220.0;
const HEIGHT: f64 = 400.0;

fn drive(gain: f64) -> Drive {
    Drive {
        position_gain: gain,
        velocity_gain: VelocityGain::Bandwidth(VELOCITY),
        integral_time: None,
        velocity_feed_forward: 0.0,
        acceleration_feed_forward: 0.0,
        max_force: None,
        viscous_friction: 0.0,
        coulomb_friction: 0.0,
        static_friction: 0.0,
        stribeck_velocity: 0.0,
        backlash: 0.0,
        encoder: Encoder::Motor,
        elastic: None,
        motor_inertia: None,
        counterbalance: 0.0,
    }
}

/// The hybrid machine of the library, with these gains of leg 1, of legs 2 and 3, and of all other joints.
fn machine([first, others, joints]: [f64; 3]) -> Machine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/lu-hybrid-ii");
    let mut machine = Machine::read(&path).expect("the library machine");
    let platform = machine.platforms.first_mut().expect("a platform");
    let of_legs = [platform.heave, platform.tilt];
    for (leg, gain) in platform.legs.iter_mut().zip([first, others, others]) {
        (leg.drive, leg.moving_mass) = (Some(drive(gain)), Some(100.0));
    }
    for (j, joint) in machine.joints.iter_mut().enumerate().filter(|(j, _)| !of_legs.contains(j)) {
        (joint.drive, joint.moving_inertia) = (Some(drive(joints)), Some(if j == 3 { 1e6 } else { 300.0 }));
    }
    machine
}

fn servo() -> Settings {
    Settings { dynamics: Dynamics::Servo, ..Settings::default() }
}

/// Heave and tilt together, to both sides, with a standstill in between.
fn swaying() -> Program {
    let mut p = Program::default().g0(&[('Z', -40.0), ('A', 0.0), ('X', 0.0), ('Y', 0.0)]).continuous(0.01).feed(40.0);
    for k in 0..60 {
        let a = f64::from(k) * 0.15;
        p = p.g1(&[
            ('Z', -40.0 + 25.0 * a.sin()),
            ('A', 0.35 * (0.7 * a).sin()),
            ('X', 3.0 * a),
            ('Y', 10.0 * a.cos()),
        ]);
    }
    p.op(proveout_nc::Op::Dwell(proveout_nc::Dwell::Seconds(0.4))).g1(&[('Z', -60.0), ('A', -0.1)])
}

/// Lengths of leg 1 and of legs 2 and 3 of the library machine, from the places of their joints.
fn lengths(heave: f64, tilt: f64) -> [f64; 2] {
    let (s, c) = tilt.sin_cos();
    let height = HEIGHT + heave;
    let shift = -0.5 * MOVING * (1.0 - c);
    // Ball joint 1 lies along +Y of the plate, 2 at -r/2 along it and r sqrt(3)/2 across; hinges on the
    // circle below.
    let first = [shift + MOVING * c - FIXED, height + MOVING * s];
    let across = 0.75_f64.sqrt() * (MOVING - FIXED);
    let second = [shift - 0.5 * MOVING * c + 0.5 * FIXED, height - 0.5 * MOVING * s];
    [first[0].hypot(first[1]), second[0].hypot(second[1]).hypot(across)]
}

/// Heave and tilt for lengths, by Newton with differences.
fn pose(wanted: [f64; 2], mut at: [f64; 2]) -> [f64; 2] {
    for _ in 0..20 {
        let now = lengths(at[0], at[1]);
        let h = 1e-6;
        let by =
            [lengths(at[0] + h, at[1]), lengths(at[0], at[1] + h)].map(|l| [(l[0] - now[0]) / h, (l[1] - now[1]) / h]);
        let determinant = by[0][0] * by[1][1] - by[1][0] * by[0][1];
        let r = [wanted[0] - now[0], wanted[1] - now[1]];
        at[0] += (r[0] * by[1][1] - by[1][0] * r[1]) / determinant;
        at[1] += (by[0][0] * r[1] - by[0][1] * r[0]) / determinant;
    }
    at
}

/// Legs that lag their set points, x'' = w (Kv (r - x) - x'), in steps of 20 micrometers of a second between
/// the samples; the set point is the cubic with lengths and rates at both. Gives heave and tilt at every
/// sample.
fn followed(samples: &[Sample], gains: [f64; 2], [heave, tilt]: [usize; 2]) -> Vec<[f64; 2]> {
    let set = |s: &Sample| {
        let (z, a) = (s.commanded[heave], s.commanded[tilt]);
        let h = 1e-4;
        let [ahead, behind] = [h, -h].map(|h| lengths(z + h * s.velocity[heave], a + h * s.velocity[tilt]));
        let now = lengths(z, a);
        [0, 1].map(|k| [now[k], (ahead[k] - behind[k]) / (2.0 * h)])
    };
    let mut state: Option<[[f64; 2]; 2]> = None;
    let mut out: Vec<[f64; 2]> = Vec::new();
    for (k, sample) in samples.iter().enumerate() {
        let to = set(sample);
        let legs = match (state, k.checked_sub(1).map(|k| &samples[k])) {
            (Some(mut legs), Some(last)) => {
                let (from, gap) = (set(last), sample.time - last.time);
                let steps = (gap / 20e-6).ceil();
                let h = gap / steps;
                for (leg, x) in legs.iter_mut().enumerate() {
                    let reference = |t: f64| {
                        let t = t / gap;
                        let [[r0, v0], [r1, v1]] = [from[leg], to[leg]];
                        let (t2, t3) = (t * t, t * t * t);
                        r0 * (2.0 * t3 - 3.0 * t2 + 1.0)
                            + r1 * (3.0 * t2 - 2.0 * t3)
                            + gap * (v0 * (t3 - 2.0 * t2 + t) + v1 * (t3 - t2))
                    };
                    let rate = |t: f64, [x, v]: [f64; 2]| [v, VELOCITY * (gains[leg] * (reference(t) - x) - v)];
                    for i in 0..steps as usize {
                        let t = i as f64 * h;
                        let at = |k: [f64; 2], h: f64| [x[0] + k[0] * h, x[1] + k[1] * h];
                        let k1 = rate(t, *x);
                        let k2 = rate(t + 0.5 * h, at(k1, 0.5 * h));
                        let k3 = rate(t + 0.5 * h, at(k2, 0.5 * h));
                        let k4 = rate(t + h, at(k3, h));
                        *x = [0, 1].map(|n| x[n] + h / 6.0 * (k1[n] + 2.0 * k2[n] + 2.0 * k3[n] + k4[n]));
                    }
                }
                legs
            }
            _ => to.map(|[r, _]| [r, 0.0]),
        };
        state = Some(legs);
        let near = out.last().copied().unwrap_or([sample.commanded[heave], sample.commanded[tilt]]);
        out.push(pose([legs[0][0], legs[1][0]], near));
    }
    out
}

fn largest(run: &Run, of: impl Fn(&Sample) -> f64) -> f64 {
    run.all.samples.iter().map(|s| of(s).abs()).fold(0.0, f64::max)
}

#[test]
fn heave_and_tilt_follow_the_legs_and_not_drives_of_their_own() {
    for gains in [[74.0, 74.0], [50.0, 90.0]] {
        let machine = machine([gains[0], gains[1], 60.0]);
        let [z, a] = ["Z", "A"].map(|n| machine.joint(n).expect("a joint"));
        let run = run_with(&swaying(), &machine, &[tool(1, 100.0)], &servo());
        let mine = followed(&run.all.samples, gains, [z, a]);
        let mut off = [0.0_f64; 2];
        for (sample, [heave, tilt]) in run.all.samples.iter().zip(&mine) {
            off[0] = off[0].max((sample.actual[z] - heave).abs());
            off[1] = off[1].max((sample.actual[a] - tilt).abs());
        }
        let lag = [z, a].map(|j| largest(&run, |s| s.commanded[j] - s.actual[j]));
        println!("gains {gains:?}: lags {lag:?}, off by {off:?} of {} samples", mine.len());
        // Measured 1.5e-11 mm and 1.4e-13 rad: steps of 20 us of a loop of 628 1/s, rates of the set points
        // by differences of 0.1 ms.
        assert!(off[0] < 1e-9 && off[1] < 1e-11, "{off:?}");
        // Heave goes at 40 mm/s at most over gains of 50 to 90 1/s.
        assert!(lag[0] > 0.2 && lag[0] < 1.2 && lag[1] > 1e-3, "{lag:?}");
    }
}

#[test]
fn unequal_legs_tilt_the_plate_of_a_pure_heave() {
    // At constant heave of an upright plate all legs grow at v h / L; leg 1 lags by v h / (L 50), the others
    // by v h / (L 90).
    let machine = machine([50.0, 90.0, 60.0]);
    let [z, a] = ["Z", "A"].map(|n| machine.joint(n).expect("a joint"));
    let speed = 20.0;
    let p = Program::default().g0(&[('Z', -90.0), ('A', 0.0)]).feed(speed).g1(&[('Z', 50.0)]);
    let run = run_with(&p, &machine, &[], &servo());
    let steady = |s: &&Sample| (s.velocity[z] - speed).abs() < 1e-9 && s.acceleration[z] == 0.0;
    let last = run.all.samples.iter().rfind(steady).expect("a steady stretch");
    // Lengths of a time ago: a ramp is followed with its lag exactly, and the legs' rates hardly change over
    // 20 ms.
    let [first, second] = lengths(last.commanded[z], 0.0);
    let rate = speed * (HEIGHT + last.commanded[z]) / first;
    let [heave, tilt] = pose([first - rate / 50.0, second - rate / 90.0], [last.commanded[z], 0.0]);
    println!("heave {} of {}, tilt {tilt} rad", last.actual[z], last.commanded[z]);
    assert!((last.actual[z] - heave).abs() < 2e-4 && (last.actual[a] - tilt).abs() < 2e-6, "{heave} {tilt} {last:?}");
    assert!(tilt < -5e-4, "leg 1 is behind: {tilt}");
}

#[test]
fn pieces_run_along_the_actual_plate_within_their_bound() {
    let machine = machine([50.0, 90.0, 60.0]);
    let run = run_with(&swaying(), &machine, &[tool(1, 100.0)], &servo());
    let (mut at, mut checked) = (0, 0);
    for sample in &run.all.samples {
        while at + 1 < run.all.pieces.len() && run.all.pieces[at].time[1] < sample.time {
            at += 1;
        }
        let p = &run.all.pieces[at];
        if sample.time < p.time[0] || sample.time > p.time[1] {
            continue;
        }
        let way = p.pose[1].tip - p.pose[0].tip;
        let t = if way.norm() > 0.0 { (sample.pose.tip - p.pose[0].tip).dot(&way) / way.norm_squared() } else { 0.0 };
        let off = (sample.pose.tip - (p.pose[0].tip + way * t.clamp(0.0, 1.0))).norm();
        assert!(off <= p.deviation + 1e-9, "{}: {off} {}", sample.time, p.deviation);
        assert!(p.deviation <= 2.0 * Settings::default().piece_tolerance, "{}", p.deviation);
        checked += 1;
    }
    assert!(checked > 500, "{checked}");
    // Everything else is as with drives of joints: the same plan, blocks in order.
    let planned = run_with(&swaying(), &machine, &[tool(1, 100.0)], &Settings::default());
    assert_eq!((run.summary.total_s, run.all.blocks), (planned.summary.total_s, planned.all.blocks));
}

#[test]
fn a_weak_leg_saturates_under_its_own_name_and_forces_are_those_of_virtual_work() {
    let mut machine = machine([74.0, 74.0, 60.0]);
    let [z, a] = ["Z", "A"].map(|n| machine.joint(n).expect("a joint"));
    let run = run_with(&swaying(), &machine, &[tool(1, 100.0)], &servo());
    // Without limits nothing saturates, and the summary names the legs that have none.
    let loads = run.summary.loads.as_ref().expect("drives");
    assert_eq!(loads.no_force_limit, ["Y", "leg L1", "legs L2 and L3", "B", "X"]);
    let unknown: Vec<&str> = loads.unknown.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(unknown, ["Y", "Z", "A", "B"], "weight and coupling of a platform are not known, and said so");
    // Legs of 100 kg each: a heave that accelerates takes about 300 kg times it, in addition to the small
    // part of the legs' turn.
    let fastest = largest(&run, |s| s.acceleration[z]);
    let force = run.summary.joints[z].drive.expect("a drive").max_force;
    assert!(force > 0.1 * fastest && force < 0.6 * fastest, "{force} N at {fastest} mm/s2");
    assert!(run.summary.joints[a].drive.is_some_and(|d| d.max_force > 0.0 && d.energy > 0.0));

    for leg in &mut machine.platforms[0].legs {
        leg.drive.as_mut().expect("a drive").max_force = Some(30.0);
    }
    let run = run_with(&swaying(), &machine, &[tool(1, 100.0)], &servo());
    let drives: Vec<usize> = run
        .all
        .events
        .iter()
        .filter_map(|e| match e {
            Event::Limit { joint: Some(j), limit, kind: LimitKind::DriveForce, .. } if limit.abs() == 30.0 => Some(*j),
            _ => None,
        })
        .collect();
    assert!(drives.contains(&z) && drives.contains(&a), "{drives:?}");
    assert_eq!(run.summary.joints[z].drive.and_then(|d| d.force_utilisation), Some(1.0));
}

#[test]
fn what_is_not_simulated_is_refused_by_name() {
    let whole = machine([74.0, 74.0, 60.0]);
    assert!(without_drive(&whole).is_empty());
    let refused = |machine: &Machine, plant: Plant| {
        let settings = Settings { plant, ..servo() };
        let e = Controller::new(Program::default().source(), machine, &[], settings).err().expect("refused");
        assert_eq!(e.code, "control-servo");
        e.to_string()
    };
    let mut missing = whole.clone();
    missing.platforms[0].legs[1].drive = None;
    assert_eq!(without_drive(&missing), ["legs L2 and L3"]);
    let text = refused(&missing, Plant::NewtonEuler);
    assert!(text.contains("legs L2 and L3") && text.contains("planned"), "{text}");
    let text = refused(&whole, Plant::Rapier);
    assert!(text.contains("platform P") && text.contains("newton-euler"), "{text}");
}
