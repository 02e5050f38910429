//! The bound of all schedules in a channel against schedules that the control runs: no random schedule in a random channel is faster.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

mod common;

use std::path::Path;
use std::sync::Mutex;

use common::{Program, Random, for_all, run_with, tool};
use proveout_controller::Settings;
use proveout_machine::Machine;
use proveout_toolpath::reschedule::{JointGates, Proof, Schedules, SwingLimits, taut_string};

/// The feed may be passed by 0.05 percent, limits of joints by 0.1.
const FEED_PASSED: f64 = 0.0005;
const LIMIT_PASSED: f64 = 0.001;

/// A blade machine whose A axis has other limits, degrees and seconds.
fn machine([velocity, acceleration, jerk]: [f64; 3]) -> Machine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/starrag-lx-451");
    let mut machine = Machine::read(&path).expect("the machine of the library");
    let a = machine.joint("A").expect("the A axis");
    machine.joints[a].max_velocity = Some(velocity.to_radians());
    machine.joints[a].max_acceleration = Some(acceleration.to_radians());
    machine.joints[a].max_jerk = Some(jerk.to_radians());
    machine
}

/// What came of a channel: time over bound, and the kinds of proof.
struct Outcome {
    ratio: f64,
    travels: bool,
    swings: bool,
}

/// A row along X while A follows a schedule in a channel that waves, wanders or is ragged, wide or narrow; the schedule is the taut
/// string, the middle, or a random one.
fn outcome(seed: u64) -> Outcome {
    let mut random = Random::new(seed);
    let n = 20 + (200.0 * random.unit().powi(2)) as usize;
    let limits =
        [10_f64.powf(random.range(0.7, 2.5)), 10_f64.powf(random.range(2.0, 4.0)), 10_f64.powf(random.range(2.7, 4.7))];
    let feed = 10_f64.powf(random.range(0.7, 1.8));
    let step = random.range(0.5, 3.0);
    let (kind, width) = ((3.0 * random.unit()) as usize, 10_f64.powf(random.range(-1.0, 1.1)));
    let (waves, phase) = (random.range(0.3, 3.0), random.range(0.0, 6.3));
    let mut walk = 0.0;
    let middle: Vec<f64> = (0..=n)
        .map(|i| {
            walk += random.range(-4.0, 4.0);
            match kind {
                0 => 20.0 * (6.3 * waves * i as f64 / n as f64 + phase).sin(),
                1 => walk,
                _ => 40.0 * i as f64 / n as f64 + 6.0 * (6.3 * waves * i as f64 / n as f64).sin(),
            }
        })
        .collect();
    let gates: Vec<[f64; 2]> = middle.iter().map(|m| [m - width * random.unit(), m + width * random.unit()]).collect();
    let chosen = (3.0 * random.unit()) as usize;
    let string = taut_string(
        [0.0, middle[0]],
        &(1..n)
            .map(|i| proveout_toolpath::reschedule::Gate { s: i as f64, low: gates[i][0], high: gates[i][1] })
            .collect::<Vec<_>>(),
        [n as f64, middle[n]],
    )
    .expect("gates that are open");
    let on_string = |i: usize| {
        let k = string.partition_point(|p| p[0] <= i as f64).clamp(1, string.len() - 1);
        let (a, b) = (string[k - 1], string[k]);
        a[1] + (b[1] - a[1]) * (i as f64 - a[0]) / (b[0] - a[0])
    };
    let schedule: Vec<f64> = (0..=n)
        .map(|i| match chosen {
            0 => on_string(i).clamp(gates[i][0], gates[i][1]),
            1 => middle[i],
            _ => gates[i][0] + (gates[i][1] - gates[i][0]) * random.unit(),
        })
        .collect();
    let machine = machine(limits);
    let place = |i: usize| [('X', 500.0 + step * i as f64), ('Y', 0.0), ('Z', 400.0), ('A', schedule[i]), ('B', 0.0)];
    // A run-up before and behind, so that the stretch is passed in motion wherever the schedule lets it.
    let before = [('X', 500.0 - 40.0), ('Y', 0.0), ('Z', 400.0), ('A', schedule[0]), ('B', 0.0)];
    let behind = [('X', 500.0 + step * n as f64 + 40.0), ('Y', 0.0), ('Z', 400.0), ('A', schedule[n]), ('B', 0.0)];
    let mut program = Program::default().change(1).continuous(0.01).g0(&before).feed(feed);
    for i in 0..=n {
        program = program.g1(&place(i));
    }
    program = program.g1(&behind);
    let run = run_with(&program, &machine, &[tool(1, 150.0)], &Settings::default());
    let moves: Vec<_> = run.all.blocks.iter().filter(|b| b.feed > 0.0).collect();
    let ended = run.all.events.iter().find(|e| matches!(e, proveout_controller::Event::Ended { .. }));
    assert!(moves.len() == n + 2, "seed {seed}: {} blocks of {}, {ended:?}", moves.len(), n + 2);
    let time = moves[n].end_time - moves[0].end_time;
    let rounding = Settings::FALLBACK_ORIENTATION_TOLERANCE;
    // Corners of A alone do not cut the way of the linear axes short.
    let least = vec![step / feed / (1.0 + FEED_PASSED); n];
    let joint = JointGates {
        name: "A".into(),
        limits: SwingLimits {
            velocity: limits[0].to_radians(),
            acceleration: limits[1].to_radians(),
            jerk: limits[2].to_radians(),
        }
        .passed_by(LIMIT_PASSED),
        gates: gates.iter().map(|[l, h]| [l.to_radians() - rounding, h.to_radians() + rounding]).collect(),
    };
    let certificate = Schedules { least, joints: vec![joint] }.certificate().expect("sound");
    assert!(certificate.bound <= time * (1.0 + 1e-9), "seed {seed}: bound {} s, time {time} s", certificate.bound);
    let has = |of: fn(&Proof) -> bool| certificate.windows.iter().any(|(p, _)| of(p));
    Outcome {
        ratio: time / certificate.bound,
        travels: has(|p| matches!(p, Proof::Travel { .. })),
        swings: has(|p| matches!(p, Proof::Swings { .. })),
    }
}

/// Paths of which the last part of the last block is rounding: the block was run, and had no record.
#[test]
fn a_block_whose_end_is_rounded_has_its_record() {
    for seed in [485, 639] {
        outcome(seed);
    }
}

/// Ten channels; `PROVEOUT_SCHEDULES` for more, `PROVEOUT_SCHEDULES_FROM` for others than the first ones.
#[test]
fn no_schedule_is_below_the_bound() {
    let number = |name| std::env::var(name).ok().and_then(|n| n.parse::<u64>().ok());
    let (from, count) = (number("PROVEOUT_SCHEDULES_FROM"), number("PROVEOUT_SCHEDULES").unwrap_or(10));
    let outcomes = Mutex::new(Vec::new());
    let from_first = from.unwrap_or(1);
    for_all(from_first..from_first + count, |seed| {
        let outcome = outcome(seed);
        outcomes.lock().expect("no panic elsewhere").push(outcome);
    });
    let outcomes = outcomes.into_inner().expect("no panic elsewhere");
    assert_eq!(outcomes.len() as u64, count);
    let mut ratios: Vec<f64> = outcomes.iter().map(|o| o.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let share = |of: fn(&Outcome) -> bool| outcomes.iter().filter(|o| of(o)).count();
    println!(
        "{count} channels: time over bound {:.5} to {:.3}, half below {:.3}; {} with travels, {} with swings",
        ratios[0],
        ratios[ratios.len() - 1],
        ratios[ratios.len() / 2],
        share(|o| o.travels),
        share(|o| o.swings)
    );
    assert!(from.is_some() || share(|o| o.travels) > 0 && share(|o| o.swings) > 0, "the channels force nothing");
}
