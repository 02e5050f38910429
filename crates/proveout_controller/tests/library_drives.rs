//! The drives of the library machines: sized by the rule, strong enough, stable at every control cycle; they
//! lag their set points by what the closed form says.

#![allow(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::path::Path;

use crate::common::{Program, run_with};
use proveout_controller::{
    Controller, Dynamics, Event, LimitKind, Settings,
    dynamics::RigidTree,
    servo::{largest_loads, size_drives, without_drive},
};
use proveout_machine::Machine;

/// All machines of the library, the one with a platform apart.
fn library() -> (Vec<Machine>, Machine) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines");
    let entries = std::fs::read_dir(folder).expect("the folder machines/");
    let mut all: Vec<_> = entries.map(|e| e.expect("entry").path()).filter(|p| p.is_dir()).collect();
    all.sort();
    let read = all.iter().map(|p| Machine::read(p).unwrap_or_else(|e| panic!("{e}")));
    let (mut platform, serial): (Vec<_>, Vec<_>) = read.partition(|m| !m.platforms.is_empty());
    assert!(serial.len() >= 14 && platform.len() == 1, "{} {}", serial.len(), platform.len());
    (serial, platform.remove(0))
}

/// Machines whose file says that its drives are those of the rule.
fn by_rule(machine: &Machine) -> bool {
    machine.trust.iter().any(|t| t.key.ends_with(".drive") && t.note.contains("by the rule"))
}

fn servo(cycle: f64) -> Settings {
    Settings { dynamics: Dynamics::Servo, sample_time: Some(cycle), ..Settings::default() }
}

#[test]
fn drives_are_those_of_the_rule() {
    let mut count = 0;
    for machine in library().0.iter().filter(|m| by_rule(m)) {
        count += 1;
        for sized in size_drives(machine).unwrap_or_else(|e| panic!("{e}")) {
            let joint = &machine.joints[sized.joint];
            let drive = joint.drive.as_ref().unwrap_or_else(|| panic!("{}: {} has no drive", machine.name, joint.name));
            let of = |keys: [&str; 2]| sized.keys.iter().find(|(k, _)| keys.contains(k)).map_or(0.0, |(_, v)| *v);
            let force = if joint.is_rotary() { 1e3 } else { 1.0 };
            let pairs = [
                ("Kv", drive.position_gain, of(["position_gain_1_s"; 2])),
                ("force", drive.max_force.expect("a limit") / force, of(["max_force_N", "max_torque_Nm"])),
                ("friction", drive.coulomb_friction / force, of(["coulomb_friction_N", "coulomb_friction_Nm"])),
                ("motor", drive.motor_inertia.unwrap_or(0.0), of(["motor_mass_kg"; 2])),
            ];
            for (what, stated, by_rule) in pairs {
                // Two digits are kept, and bodies are redrawn from time to time: 10 percent.
                assert!(
                    (stated - by_rule).abs() <= 0.1 * by_rule,
                    "{}, joint {}: {what} {stated}, and the rule gives {by_rule}: run the example size_drives --write",
                    machine.name,
                    joint.name
                );
            }
        }
    }
    assert_eq!(count, library().0.len() - 2, "all but the two that state their own drives");
}

/// States of another seed than those that sized the drives.
#[test]
fn every_drive_can_make_every_motion_within_the_limits() {
    for machine in library().0 {
        let tree = RigidTree::new(&machine);
        assert!(tree.report().unknown.is_empty(), "{}: {:?}", machine.name, tree.report());
        let loads = largest_loads(&machine, &tree, 2000, 77);
        for (j, joint) in machine.joints.iter().enumerate() {
            let drive = joint.drive.as_ref().expect("a drive");
            let motor = drive.motor_inertia.unwrap_or(0.0) * joint.max_acceleration.expect("a limit") * 1e-3;
            let friction = drive.static_friction + drive.viscous_friction * joint.max_velocity.expect("a limit");
            let need = loads[j] + motor + friction;
            let limit = drive.max_force.expect("a limit");
            // A control needs some force of its own above that of the motion.
            assert!(limit > 1.1 * need, "{}, {}: {need} of {limit}", machine.name, joint.name);
        }
    }
}

/// One joint after the other, over a good part of its travel at constant speed, at cycles from 0.5 to 10 ms:
/// the drives come to rest, and with the feed-forward taken out each lags by its speed over Kv.
#[test]
#[ignore = "nightly, 34 s"]
fn every_machine_is_stable_and_lags_by_speed_over_gain_at_every_cycle() {
    for mut machine in library().0 {
        for joint in &mut machine.joints {
            let drive = joint.drive.as_mut().expect("a drive");
            (drive.velocity_feed_forward, drive.acceleration_feed_forward) = (0.0, 0.0);
        }
        let home = machine.home();
        let mut worst = 0.0_f64;
        for cycle in [0.5e-3, 2e-3, 10e-3] {
            for (j, joint) in machine.joints.iter().enumerate() {
                let letter = joint.name.chars().next().expect("a letter");
                let [low, high] = joint.travel.unwrap_or([-3.0, 3.0]);
                let (from, to) = (low + 0.1 * (high - low), high - 0.1 * (high - low));
                // Most of two seconds at constant speed: transients die like exp(-15 t) or faster.
                let speed = (0.5 * joint.max_velocity.expect("a limit")).min(0.5 * (to - from));
                let kv = joint.drive.as_ref().expect("a drive").position_gain;
                // A feed of rotary joints alone is in degrees where lengths are in mm.
                let feed = if joint.is_rotary() { speed.to_degrees() } else { speed };
                let p = Program::default().g0(&[(letter, from)]).feed(feed).g1(&[(letter, to)]);
                let run = run_with(&p, &machine, &[], &servo(cycle));
                let name = format!("{}, joint {}, {} ms", machine.name, joint.name, cycle * 1e3);
                let steady = |s: &&proveout_controller::Sample| {
                    s.block == 1 && s.acceleration[j] == 0.0 && (s.velocity[j] / speed - 1.0).abs() < 1e-9
                };
                let last = run.all.samples.iter().rfind(steady).unwrap_or_else(|| panic!("{name}: no steady stretch"));
                let lag = last.commanded[j] - last.actual[j];
                let off = (lag / (speed / kv) - 1.0).abs();
                worst = worst.max(off);
                // Weight on a swivel changes while it turns, and its integral part follows with a lag of its
                // own.
                assert!(off < 0.01, "{name}: lags by {lag}, and speed over Kv is {}", speed / kv);
                let end = run.all.pieces.last().expect("pieces").joints[1];
                for k in 0..machine.joints.len() {
                    let target = if k == j { to } else { home[k] };
                    // At rest friction may hold a joint off by a hundredth of the lag.
                    assert!((end[k] - target).abs() < 0.02 * speed / kv, "{name}: {k} ends at {} of {target}", end[k]);
                }
            }
        }
        println!("{}: lag within {worst:.1e} of speed over Kv", machine.name);
    }
}

/// With the feed-forward of the file and rapid motion of all joints at once no drive saturates.
#[test]
fn rapid_motion_saturates_no_drive() {
    for machine in library().0 {
        let mut p = Program::default();
        for part in [0.2, 0.8, 0.35, 0.6] {
            let at: Vec<(char, f64)> = machine
                .joints
                .iter()
                .map(|joint| {
                    let [low, high] = joint.travel.unwrap_or([-3.0, 3.0]);
                    (joint.name.chars().next().expect("a letter"), low + part * (high - low))
                })
                .collect();
            p = p.g0(&at);
        }
        let run = run_with(&p, &machine, &[], &servo(machine.control.cycle_time));
        let limited = run.all.events.iter().any(|e| matches!(e, Event::Limit { kind: LimitKind::DriveForce, .. }));
        let used: Vec<f64> =
            run.summary.joints.iter().map(|j| j.drive.expect("drives").force_utilisation.expect("a limit")).collect();
        println!("{}: drives are used by {used:.2?}", machine.name);
        assert!(!limited && used.iter().all(|u| *u > 0.01 && *u < 1.0), "{}: {used:?}", machine.name);
    }
}

#[test]
fn a_platform_without_drives_is_refused_by_its_leg() {
    let machine = library().1;
    let platform = &machine.platforms[0].name;
    let program = Program::default();
    let refused = Controller::new(program.source(), &machine, &[], servo(2e-3));
    let Err(e) = refused else { panic!("not refused") };
    let text = e.to_string();
    assert!(e.code == "control-servo" && text.contains(&machine.name), "{text}");
    assert!(text.contains("joint Y") && text.contains("planned"), "{text}");
    assert_eq!(without_drive(&machine), ["Y", "leg L1", "legs L2 and L3", "B", "X"]);
    // Its other loads are known only where the platform has no part in them.
    let tree = RigidTree::new(&machine);
    for (j, joint) in machine.joints.iter().enumerate() {
        assert_eq!(tree.knows(j), joint.name == "X", "{}", joint.name);
    }
    assert!(tree.report().unknown.iter().all(|(_, why)| why.contains(platform)), "{:?}", tree.report());
    assert!(size_drives(&machine).is_err_and(|e| e.contains(platform)));
}
