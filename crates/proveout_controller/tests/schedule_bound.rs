//! The bound of all schedules in a channel against schedules that the control runs: no random schedule in a
//! random channel is faster.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::path::Path;
use std::sync::Mutex;

use crate::common::{Program, Random, bc_machine, for_all, run_with, tool};
use proveout_controller::Settings;
use proveout_geom::{Point, Vector};
use proveout_machine::Machine;
use proveout_reschedule::{
    AxisPair, Caps, CellBound, FeedFloor, JointGates, Proof, Schedules, SwingLimits, taut_string,
};

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

/// A row along X while A follows a schedule in a channel that waves, wanders or is ragged, wide or narrow;
/// the schedule is the taut string, the middle, or a random one.
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
            .map(|i| proveout_reschedule::TautGate { s: i as f64, low: gates[i][0], high: gates[i][1] })
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
    // Commands have radian, as everything inside.
    let a = |i: usize| schedule[i].to_radians();
    let place = |i: usize| [('X', 500.0 + step * i as f64), ('Y', 0.0), ('Z', 400.0), ('A', a(i)), ('B', 0.0)];
    // A run-up before and after, so that the stretch is passed in motion wherever the schedule lets it.
    let before = [('X', 500.0 - 40.0), ('Y', 0.0), ('Z', 400.0), ('A', a(0)), ('B', 0.0)];
    let behind = [('X', 500.0 + step * n as f64 + 40.0), ('Y', 0.0), ('Z', 400.0), ('A', a(n)), ('B', 0.0)];
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

/// Number of a variable.
fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// A way in the plane of random bends and steps, short blocks that are fitted together and long ones, gentle
/// and sharp, narrow and wide tolerances: the time of no window of blocks is below what is proved of its
/// feed. Gives the nearest ratio over long windows, and the part of the programmed time that the fastest
/// block takes.
fn feed_outcome(seed: u64) -> [f64; 2] {
    let mut random = Random::new(seed);
    let n = 30 + (120.0 * random.unit()) as usize;
    let tolerance = 10_f64.powf(random.range(-3.0, -1.3));
    let feed = 10_f64.powf(random.range(0.5, 1.7));
    let step = 10_f64.powf(random.range(-0.7, 0.5)).max(4.0 * tolerance);
    let (bend, even) = (10_f64.powf(random.range(-2.0, 0.1)), random.unit() < 0.5);
    let mut angle = random.range(0.0, 6.3);
    let mut p = Point::new(0.0, 0.0, 200.0);
    let mut points = vec![p];
    for k in 0..n {
        angle += if even { bend * (k as f64 / 7.0).sin() } else { random.range(-bend, bend) };
        p += Vector::new(angle.cos(), angle.sin(), 0.0) * (step * if even { 1.0 } else { random.range(0.5, 1.5) });
        points.push(p);
    }
    let at = |p: &Point| [('X', p.x), ('Y', p.y), ('Z', p.z)];
    let mut program = Program::default().change(1).continuous(tolerance).g0(&at(&points[0])).feed(feed);
    for p in &points[1..] {
        program = program.g1(&at(p));
    }
    let run = run_with(&program, &bc_machine(), &[tool(1, 100.0)], &Settings::default());
    let taken: Vec<f64> = run.all.blocks.iter().filter(|b| b.feed > 0.0).map(|b| b.end_time - b.start_time).collect();
    assert_eq!(taken.len(), n, "seed {seed}");
    let nominal: Vec<f64> = points.windows(2).map(|p| (p[1] - p[0]).norm() / feed).collect();
    let floor = FeedFloor::new(&nominal, &[&points], tolerance, FEED_PASSED)
        .unwrap_or_else(|block| panic!("seed {seed}: block {block} is short"));
    let mut nearest = f64::INFINITY;
    for a in 0..n {
        let (mut time, mut least) = (0.0, 0.0);
        for (b, (own, proved)) in taken.iter().zip(&floor.least).enumerate().skip(a) {
            time += own;
            least += proved;
            let proved = least - floor.seams[a] - floor.seams[b + 1];
            assert!(time >= proved - 1e-9, "seed {seed}, blocks {a} to {b}: {time} below {proved}");
            if b > a + 20 {
                nearest = nearest.min(time / proved);
            }
        }
    }
    [nearest, taken.iter().zip(&nominal).map(|(t, n)| t / n).fold(f64::INFINITY, f64::min)]
}

/// Twenty ways; `PROVEOUT_FEED_WAYS` for more.
#[test]
fn no_window_of_blocks_is_faster_than_is_proved_of_its_feed() {
    let count = number("PROVEOUT_FEED_WAYS").unwrap_or(20);
    let outcomes = Mutex::new(Vec::new());
    for_all(1..count + 1, |seed| outcomes.lock().expect("no panic elsewhere").push(feed_outcome(seed)));
    let outcomes = outcomes.into_inner().expect("no panic elsewhere");
    let least = |k: usize| outcomes.iter().map(|o| o[k]).fold(f64::INFINITY, f64::min);
    println!(
        "{count} ways: time over what is proved at least {:.5}; fastest block {:.4} of its time",
        least(0),
        least(1)
    );
    // Corners are cut, so that single blocks take less than their programmed time, and the windows are near
    // to what is proved.
    assert!(least(1) < 0.999 && least(0) < 1.01, "the ways show nothing");
}

/// What came of a row of two angles.
struct Turned {
    /// Time over the bound.
    ratio: f64,
    /// Bound over what is proved of the feed.
    forced: f64,
    /// The axes jump from block to block.
    jumps: bool,
}

/// B waves and C turns under tool center point control, past the pole of C and far from it, slowly and fast,
/// evenly or by jumps; caps about axes next to theirs: the control takes no less than the bound over cells.
/// The tip stays near the axis of the table, so that it is the rotary joints that bind, and lead-in and
/// lead-out turn on as the row does, so that it is passed in motion.
fn two_angles_outcome(seed: u64) -> Turned {
    let mut random = Random::new(seed);
    let n = 60 + (60.0 * random.unit()) as usize;
    let lead = 15;
    // Time of a block by the feed, and how much of its velocity C has in it: above one the joint binds.
    let (block, part) = (random.range(0.03, 0.08), random.range(0.3, 2.0));
    let step = random.range(10.0, 40.0) / n as f64;
    let feed = step / block;
    let radius = random.range(0.01, 0.05);
    let machine = bc_machine();
    let joint = |name: &str| &machine.joints[machine.joint(name).expect("of the machine")];
    let velocity = ["B", "C"].map(|j| joint(j).max_velocity.expect("given") * (1.0 + LIMIT_PASSED));
    // Both carry the workpiece with sense -1: seen from the table the axis turns by their values.
    let pair = AxisPair { inner: Vector::y(), outer: Vector::z(), zero: Vector::z(), travel: [-1.2, 1.2], velocity };
    // Every fifth row jumps from block to block.
    let jumps = seed.is_multiple_of(5);
    let size = if jumps { 0.02 } else { 0.0 };
    let (waver, phase) = (random.range(0.0, 0.3), random.range(0.0, 6.3));
    let (lean, start) = (random.range(-0.4, 0.4), random.range(-3.0, 3.0));
    let pace = part * block * velocity[1];
    let at = |i: i32| {
        let along = f64::from(i) / n as f64;
        [lean + waver * (4.0 * along + phase).sin(), start + pace * f64::from(i)]
    };
    let last = i32::try_from(n).expect("a hundred");
    let rows: Vec<[f64; 2]> = (-lead..=last + lead)
        .map(|i| {
            let [b, c] = at(i);
            [b + size * random.range(-1.0, 1.0), c + size * random.range(-1.0, 1.0)]
        })
        .collect();
    let own = lead as usize..lead as usize + n + 1;
    let middles = rows[own.clone()].iter().map(|q| {
        let off = Vector::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0));
        (pair.axis(*q) + off * (0.5 * radius)).normalize()
    });
    let rounding = 0.05_f64.to_radians();
    let caps = Caps { middles: middles.collect(), radius: radius + 2.0 * rounding };
    let tip = |k: usize| step * (k as f64 - lead as f64 - 0.5 * n as f64);
    let place = |k: usize| {
        let [b, c] = rows[k];
        [('X', tip(k)), ('Y', 0.0), ('Z', 80.0), ('B', b), ('C', c)]
    };
    let mut program = Program::default().change(1).continuous(0.01).tcp(true).g0(&place(0)).feed(feed);
    for k in 1..rows.len() {
        program = program.g1(&place(k));
    }
    let run = run_with(&program, &machine, &[tool(1, 100.0)], &Settings::default());
    let moves: Vec<_> = run.all.blocks.iter().filter(|b| b.feed > 0.0).collect();
    assert_eq!(moves.len() + 1, rows.len(), "seed {seed}");
    // A block of the program ends at the point of its number.
    let time = moves[own.end - 2].end_time - moves[own.start - 1].end_time;
    let way: Vec<Point> = own.clone().map(|k| Point::new(tip(k), 0.0, 80.0)).collect();
    let floor = FeedFloor::new(&vec![step / feed; n], &[&way], 0.01, FEED_PASSED).expect("long blocks");
    let proved =
        |a: usize, b: usize| (floor.least[a..b].iter().sum::<f64>() - floor.seams[a] - floor.seams[b]).max(0.0);
    let found = CellBound::new(&pair, &caps, proved).unwrap_or_else(|| panic!("seed {seed}: no cells"));
    assert!(found.time <= time * (1.0 + 1e-9), "seed {seed}: bound {} s, time {time} s", found.time);
    assert!(found.reached.is_none_or(|t| t >= found.time * (1.0 - 1e-12)), "seed {seed}");
    Turned { ratio: time / found.time, forced: found.time / proved(0, n), jumps }
}

/// Ten rows; `PROVEOUT_TWO_ANGLES` for more.
#[test]
#[ignore = "nightly, 23 s"]
fn no_row_of_two_angles_is_below_the_bound_over_cells() {
    let count = number("PROVEOUT_TWO_ANGLES").unwrap_or(10);
    let outcomes = Mutex::new(Vec::new());
    for_all(1..count + 1, |seed| outcomes.lock().expect("no panic elsewhere").push(two_angles_outcome(seed)));
    let outcomes = outcomes.into_inner().expect("no panic elsewhere");
    let sorted = |jumps: bool| {
        let mut ratios: Vec<f64> = outcomes.iter().filter(|o| o.jumps == jumps).map(|o| o.ratio).collect();
        ratios.sort_by(f64::total_cmp);
        ratios
    };
    let forced = outcomes.iter().filter(|o| o.forced > 1.01).count();
    let span = |r: &[f64]| match r {
        [] => "of none".to_owned(),
        _ => format!("{:.4} to {:.3}, half below {:.3}", r[0], r[r.len() - 1], r[r.len() / 2]),
    };
    let [even, jumping] = [sorted(false), sorted(true)];
    println!(
        "{count} rows: time over bound {}, of rows that jump {}; {forced} bound by more than the feed",
        span(&even),
        span(&jumping)
    );
    assert!(forced > 0, "no row is bound by its joints");
    assert!(even[even.len() / 2] < 2.0, "the bound says nothing of even rows: {}", span(&even));
}
