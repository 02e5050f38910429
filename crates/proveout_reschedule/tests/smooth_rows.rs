//! The method `smooth` for rows: random obstacles that only a detour passes, the pole of a table, what it
//! refuses, and how its time grows.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]
#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::time::Instant;

use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_reschedule::{
    AxisTurn, ContactPoint, ContactSurface, CuttingBlock, CuttingRun, FeasibleRegion, Method, Rescheduled, RowEnds,
    SmoothRows, Surroundings, TimeLaw,
};
use proveout_tool::{Cutter, Profile};

const RADIUS: f64 = 3.0;

fn machine(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name)).unwrap()
}

fn ball() -> Profile {
    Cutter::ball(2.0 * RADIUS).unwrap().bodies(20.0).unwrap().remove(0)
}

/// The plane z = 0.
struct Flat;

impl ContactSurface for Flat {
    fn contact(&self, near: &Point) -> Option<ContactPoint> {
        let point = Point::new(near.x, near.y, 0.0);
        Some(ContactPoint { point, normal: Vector::z(), curvatures: [(0.0, Vector::x()), (0.0, Vector::y())] })
    }
}

/// Places next to the row, each of which forbids a cap of axes while the ball center is near it along x.
#[derive(Clone, Debug, Default)]
struct Posts(Vec<Post>);

#[derive(Clone, Copy, Debug)]
struct Post {
    from: f64,
    to: f64,
    way: Vector,
    cap: f64,
}

impl Posts {
    fn near(&self, x: f64, drift: f64) -> impl Iterator<Item = &Post> {
        self.0.iter().filter(move |p| x + drift >= p.from && x - drift <= p.to)
    }
}

impl FeasibleRegion for Posts {
    fn clearance(&self, pose: &ToolPose) -> f64 {
        let center = pose.tip + pose.axis * RADIUS;
        self.near(center.x, 0.0).map(|p| angle(&p.way, &pose.axis) - p.cap).fold(1.0, f64::min)
    }

    fn free_turns(&self, turn: &AxisTurn) -> Option<Vec<[f64; 2]>> {
        // By looking, half a degree apart, with what lies between added to the caps.
        let step = TAU / 720.0;
        let across = (1.0 - turn.axial * turn.axial).sqrt();
        let axis = |a: f64| (turn.basis[0] * a.cos() + turn.basis[1] * a.sin()) * across + turn.basis[2] * turn.axial;
        let posts: Vec<&Post> = self.near(turn.center.x, turn.drift).collect();
        let free = |k: usize| {
            let axis = axis(-PI + step * (k as f64 + 0.5));
            posts.iter().all(|p| angle(&p.way, &axis) > p.cap + turn.spread + 0.5 * step)
        };
        if (0..720).all(free) {
            return Some(vec![[-PI, PI]]);
        }
        let shut = (0..720).find(|k| !free(*k)).unwrap();
        let mut out: Vec<[f64; 2]> = Vec::new();
        for k in shut + 1..shut + 720 {
            let [from, to] = [k, k + 1].map(|k| -PI + step * k as f64);
            if free(k % 720) {
                match out.last_mut().filter(|last| (last[1] - from).abs() < 1e-9) {
                    Some(last) => last[1] = to,
                    None => out.push([from, to]),
                }
            }
        }
        out.iter_mut().for_each(|i| {
            let off = TAU * ((i[0] + PI) / TAU).floor();
            *i = i.map(|a| a - off);
        });
        out.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Some(out)
    }
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// A row along x of blocks of half a millimeter whose axes are given over its length, 0 to 1.
fn row(blocks: usize, feed: f64, axis: impl Fn(f64) -> Vector) -> CuttingRun {
    let block = |i: usize| {
        let axis = axis(i as f64 / (blocks - 1) as f64).normalize();
        let center = Point::new(0.5 * i as f64, 0.0, RADIUS);
        let pose = ToolPose { tip: center - axis * RADIUS, axis };
        CuttingBlock { pose, line: i as u32 + 1, time: (i > 0).then_some(0.5 / feed) }
    };
    CuttingRun { blocks: (0..blocks).map(block).collect() }
}

fn made(
    method: &SmoothRows,
    run: &CuttingRun,
    machine: &Machine,
    region: &dyn FeasibleRegion,
    law: Option<&dyn TimeLaw>,
) -> Result<Rescheduled, proveout_reschedule::RescheduleError> {
    let cutter = ball();
    let around = Surroundings {
        machine: Some(machine),
        region: Some(region),
        surface: Some(&Flat),
        time_law: law,
        ..Surroundings::new(&cutter, Vector::z())
    };
    method.reschedule(run, &around)
}

/// Joint positions of poses as a control goes through them, or those that are given.
fn joints(made: &Rescheduled, machine: &Machine) -> Vec<JointValues> {
    if let Some(rotary) = &made.rotary {
        return rotary.clone();
    }
    let mut q = machine.home();
    let nearest = |pose: &ToolPose| {
        let pose = ToolPose { tip: Point::origin(), axis: pose.axis };
        q = match machine.inverse_nearest(&pose, 0.0, &q) {
            Ok(s) => s.q,
            Err(proveout_machine::KinematicsError::OverTravel { rotary: false, solution, .. }) => solution.q,
            Err(e) => panic!("{e}"),
        };
        q
    };
    made.poses.iter().map(nearest).collect()
}

/// Largest velocity and acceleration of the rotary joints over the blocks, deg.
fn peaks(q: &[JointValues], machine: &Machine, time: f64) -> [f64; 2] {
    let mut out = [0.0_f64; 2];
    for &j in machine.rotary_joints() {
        for w in q.windows(2) {
            out[0] = out[0].max(((w[1][j] - w[0][j]) / time).abs());
        }
        for w in q.windows(3) {
            out[1] = out[1].max(((w[2][j] - 2.0 * w[1][j] + w[0][j]) / (time * time)).abs());
        }
    }
    out.map(f64::to_degrees)
}

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// Rows whose own axes wave to and fro, past posts that the straight way from end to end hits: contacts and
/// ends stay, between blocks nothing is touched, and no schedule is slower or less even than the program
/// before.
#[test]
fn random_posts_are_passed_free_between_blocks_and_smoother_than_before() {
    let mut state = 11;
    let (mut detours, mut refused, mut planned) = (0, 0, 0);
    for case in 0..24 {
        let machine = machine(["jdgr200t", "ac-trunnion-620", "bc-head-table-grinder"][case % 3]);
        let lean = 0.25 + 0.25 * random(&mut state);
        let (turn, wave) = (TAU * random(&mut state), 0.5 + random(&mut state));
        let own = |s: f64| {
            let a = turn + wave * (TAU * 3.0 * s).sin();
            Vector::new(lean.sin() * a.cos(), lean.sin() * a.sin(), lean.cos())
        };
        let run = row(81, 20.0, own);
        // Posts in the middle of the ways that the program does not take, one on it in some cases.
        let posts = (0..2).map(|k| {
            let s = 0.3 + 0.3 * f64::from(k) + 0.1 * random(&mut state);
            let beside = own(s) + Vector::new(random(&mut state) - 0.5, random(&mut state) - 0.5, 0.0) * 0.5;
            let way = beside.normalize();
            let cap = (0.8 * angle(&way, &own(s))).min(0.15);
            Post { from: 40.0 * s - 2.0, to: 40.0 * s + 2.0, way, cap }
        });
        let posts = Posts(posts.collect());
        let done = match made(&SmoothRows::default(), &run, &machine, &posts, None) {
            Ok(done) => done,
            Err(e) => {
                // The program itself touches, or is in what cells count as taken: said with the block.
                assert!(e.code.starts_with("reschedule-") && e.line > 0, "{e:?}");
                refused += 1;
                continue;
            }
        };
        planned += 1;
        assert_eq!(done.poses.len(), run.blocks.len());
        for (pose, block) in done.poses.iter().zip(&run.blocks) {
            let [new, old] = [pose, &block.pose].map(|p| p.tip + p.axis * RADIUS);
            assert!((new - old).norm() < 1e-9, "the contact stays");
        }
        for (a, b) in [(done.poses.first(), run.blocks.first()), (done.poses.last(), run.blocks.last())] {
            assert!((a.unwrap().axis - b.unwrap().pose.axis).norm() < 1e-9, "the ends stay");
        }
        let q = joints(&done, &machine);
        for (i, pair) in q.windows(2).enumerate() {
            for k in 0..=20 {
                let t = f64::from(k) / 20.0;
                let axis = machine.forward(&pair[0].interpolated(pair[1], t), 0.0).axis;
                let center = Point::new(0.5 * (i as f64 + t), 0.0, RADIUS);
                let pose = ToolPose { tip: center - axis * RADIUS, axis };
                assert!(posts.clearance(&pose) > 0.0, "case {case}, block {i}, {t}");
                assert!(angle(&axis, &Vector::z()) < 80.001_f64.to_radians());
            }
        }
        let mut at = machine.home();
        let before: Vec<JointValues> = run
            .blocks
            .iter()
            .map(|b| {
                let pose = ToolPose { tip: Point::origin(), axis: b.pose.axis };
                at = match machine.inverse_nearest(&pose, 0.0, &at) {
                    Ok(s) => s.q,
                    Err(proveout_machine::KinematicsError::OverTravel { solution, .. }) => solution.q,
                    Err(e) => panic!("{e}"),
                };
                at
            })
            .collect();
        let [old, new] = [&before, &q].map(|q| peaks(q, &machine, 0.025));
        let free_before = run.blocks.iter().all(|b| posts.clearance(&b.pose) > 0.02);
        if free_before {
            assert!(new[1] <= old[1] * 1.0001, "case {case}: {new:?} after {old:?}");
        }
        // Straight from end to end in both joints hits a post: a detour was needed.
        let straight = (0..=400).any(|k| {
            let t = f64::from(k) / 400.0;
            let axis = machine.forward(&q[0].interpolated(q[q.len() - 1], t), 0.0).axis;
            let center = Point::new(40.0 * t, 0.0, RADIUS);
            posts.clearance(&ToolPose { tip: center - axis * RADIUS, axis }) <= 0.0
        });
        detours += usize::from(straight);
    }
    println!("{planned} planned, {refused} refused, {detours} detours");
    assert!(planned >= 18 && detours >= 4, "{planned} planned, {refused} refused, {detours} detours");
}

/// Everything is free.
struct Open;

impl FeasibleRegion for Open {
    fn clearance(&self, _: &ToolPose) -> f64 {
        1.0
    }

    fn free_turns(&self, _: &AxisTurn) -> Option<Vec<[f64; 2]>> {
        Some(vec![[-PI, PI]])
    }
}

/// On a great circle that passes the pole of the table by one degree, as in the row of Cui et al. 2022: 12
/// degrees at azimuth 5 to 12 at azimuth 175.
fn past_the_pole(blocks: usize) -> CuttingRun {
    let tilted = |azimuth: f64| {
        let (lean, a) = (12.0_f64.to_radians(), azimuth.to_radians());
        Vector::new(lean.sin() * a.cos(), lean.sin() * a.sin(), lean.cos())
    };
    let (from, to) = (tilted(5.0), tilted(175.0));
    let all = from.dot(&to).acos();
    row(blocks, 20.0, |s| (from * ((1.0 - s) * all).sin() + to * (s * all).sin()) / all.sin())
}

#[test]
fn through_the_pole_both_joints_turn_evenly_and_a_program_of_vectors_goes_beside_it() {
    let machine = machine("bc-head-table-grinder");
    let run = past_the_pole(121);
    let planned = made(&SmoothRows::default(), &run, &machine, &Open, None).unwrap();
    let q = joints(&planned, &machine);
    assert!(planned.rotary.is_some(), "a pose at the pole does not tell the table");
    // Evenly from end to end: 10 degrees of C and 24 of B in 60 mm, at most a quarter more for their ramps.
    let [velocity, acceleration] = peaks(&q, &machine, 0.025);
    let even = 24.0 / (120.0 * 0.025);
    assert!(velocity < 1.3 * even, "{velocity} of {even}");
    let limit =
        machine.rotary_joints().iter().filter_map(|&j| machine.joints[j].max_acceleration).fold(f64::MAX, f64::min);
    assert!(acceleration < 0.3 * limit.to_degrees(), "{acceleration}");
    let cutter = ball();
    let around = Surroundings {
        machine: Some(&machine),
        region: Some(&Open),
        surface: Some(&Flat),
        vectors: true,
        ..Surroundings::new(&cutter, Vector::z())
    };
    let beside = SmoothRows::default().reschedule(&run, &around).unwrap();
    assert!(beside.rotary.is_none());
    // Ends that move: nothing turns at all.
    let free = SmoothRows { ends: RowEnds::Free, ..SmoothRows::default() };
    let still = made(&free, &run, &machine, &Open, None).unwrap();
    assert!(peaks(&joints(&still, &machine), &machine, 0.025)[0] < 1e-6);
    // Near the program's own axes it is not still.
    let near = SmoothRows { turn_max: Some(3.0_f64.to_radians()), ..free };
    let near = made(&near, &run, &machine, &Open, None).unwrap();
    for (pose, block) in near.poses.iter().zip(&run.blocks) {
        assert!(angle(&pose.axis, &block.pose.axis) < 3.0001_f64.to_radians());
    }
}

/// A control that takes as long as the axis needs at some velocity, and more where it turns back.
struct Slow(f64);

impl TimeLaw for Slow {
    fn block_times(&self, poses: &[ToolPose]) -> Option<Vec<f64>> {
        let turn = |i: usize| poses[i].axis - poses[i - 1].axis;
        let time = |i: usize| {
            let jump = if i > 1 { (turn(i) - turn(i - 1)).norm() } else { 0.0 };
            0.025_f64.max(turn(i).norm() / self.0) + 2.0 * jump
        };
        Some((0..poses.len()).map(|i| if i == 0 { 0.0 } else { time(i) }).collect())
    }
}

#[test]
fn nothing_slower_for_the_control_than_the_program_before_is_handed_out() {
    let machine = machine("jdgr200t");
    for wave in [0.0, 0.2, 1.0] {
        let run = row(121, 20.0, |s| Vector::new(0.3 * (1.0 + wave * (TAU * 4.0 * s).sin()), 0.1 + 0.2 * s, 1.0));
        let law = Slow(0.5);
        let done = made(&SmoothRows::default(), &run, &machine, &Open, Some(&law)).unwrap();
        let before: Vec<ToolPose> = run.blocks.iter().map(|b| b.pose).collect();
        let [old, new] = [&before, &done.poses].map(|p| law.block_times(p).unwrap().iter().sum::<f64>());
        assert!(new <= old * (1.0 + 2e-5), "{wave}: {new} after {old}");
        assert!((done.study.figure("time of the blocks").unwrap() - new).abs() < 1e-9);
        if wave > 0.0 {
            assert!(new < 0.97 * old, "{wave}: {new} after {old}");
        }
    }
    // A control that refuses everything leaves nothing to hand out.
    struct Never;
    impl TimeLaw for Never {
        fn block_times(&self, _: &[ToolPose]) -> Option<Vec<f64>> {
            None
        }
    }
    let run = row(41, 20.0, |s| Vector::new(0.3 * s, 0.1, 1.0));
    let error = made(&SmoothRows::default(), &run, &machine, &Open, Some(&Never)).unwrap_err();
    assert_eq!(error.code, "reschedule-channel");
}

/// A control that takes as long for every block, and longer for the first one the farther the first axis is
/// from one.
struct Lift(Vector);

impl TimeLaw for Lift {
    fn block_times(&self, poses: &[ToolPose]) -> Option<Vec<f64>> {
        let lift = 5.0 * angle(&poses.first()?.axis, &self.0);
        Some((0..poses.len()).map(|i| if i == 0 { lift } else { 0.025 }).collect())
    }
}

/// What leads to a row counts: with ends that may move, the smoothest schedule is at rest, but begins
/// elsewhere.
#[test]
fn a_row_that_gains_nothing_but_lengthens_what_leads_to_it_is_not_handed_out() {
    let run = row(121, 20.0, |s| Vector::new(0.3 * (1.0 + 0.5 * (TAU * 4.0 * s + 1.0).sin()), 0.1 + 0.2 * s, 1.0));
    let law = Lift(run.blocks[0].pose.axis);
    let method = SmoothRows { ends: RowEnds::Free, ..SmoothRows::default() };
    let before: Vec<ToolPose> = run.blocks.iter().map(|b| b.pose).collect();
    let done = made(&method, &run, &machine("jdgr200t"), &Open, Some(&law)).unwrap();
    let [old, new] = [&before, &done.poses].map(|p| law.block_times(p).unwrap().iter().sum::<f64>());
    // Schedules within a hundred-thousandth are as fast.
    assert!(new <= old * (1.0 + 2e-5), "{new} after {old}");
}

#[test]
fn what_it_cannot_do_is_reported_with_the_block() {
    let table = machine("jdgr200t");
    let run = row(81, 20.0, |s| Vector::new(0.3 * s, 0.1, 1.0));
    let refusal = |method: &SmoothRows, run: &CuttingRun, machine: &Machine, region: &dyn FeasibleRegion| {
        let e = made(method, run, machine, region, None).unwrap_err();
        assert!(!e.help.is_empty() && !e.message.is_empty());
        (e.code, e.line)
    };
    let method = SmoothRows::default();
    assert_eq!(refusal(&method, &run, &machine("three-axis-mill"), &Open), ("reschedule-path", 1));
    assert_eq!(refusal(&SmoothRows { lean_max: 0.0, ..method }, &run, &table, &Open), ("reschedule-option", 0));
    assert_eq!(refusal(&SmoothRows { turn_max: Some(4.0), ..method }, &run, &table, &Open), ("reschedule-option", 0));
    let short = CuttingRun { blocks: run.blocks[..4].to_vec() };
    assert_eq!(refusal(&method, &short, &table, &Open), ("reschedule-layers", 1));
    let mut untimed = run.clone();
    untimed.blocks[6].time = None;
    assert_eq!(refusal(&method, &untimed, &table, &Open), ("reschedule-path", 7));
    // A tilt without the travel for the last axes.
    let mut narrow = machine("jdgr200t");
    let tilt = narrow.rotary_joints()[1];
    narrow.joints[tilt].travel = Some([-0.2, 0.2]);
    let (code, line) = refusal(&method, &run, &narrow, &Open);
    assert!(code == "reschedule-range" && line > 20 && line < 81, "{line}");
    // Nothing is free in the middle of the row.
    let wall = Posts(vec![Post { from: 19.0, to: 21.0, way: Vector::z(), cap: 1.5 }]);
    let (code, line) = refusal(&method, &run, &table, &wall);
    assert!(code == "reschedule-channel" && (36..=44).contains(&line), "{line}");
    // What must be kept away from is not known, nor where a cutter without a ball touches.
    let cutter = ball();
    let around =
        Surroundings { machine: Some(&table), surface: Some(&Flat), ..Surroundings::new(&cutter, Vector::z()) };
    assert_eq!(method.reschedule(&run, &around).unwrap_err().code, "reschedule-channel");
    let wheel = Cutter::drum_wheel(38.0, 1.5, 0.0, 3.0).unwrap().bodies(3.0).unwrap().remove(0);
    let around = Surroundings { machine: Some(&table), ..Surroundings::new(&wheel, Vector::z()) };
    assert_eq!(method.reschedule(&run, &around).unwrap_err().code, "reschedule-tool");
    let bull = Cutter::bull_nose(10.0, 3.0).unwrap().bodies(10.0).unwrap().remove(0);
    let around = Surroundings { machine: Some(&table), ..Surroundings::new(&bull, Vector::z()) };
    assert_eq!(method.reschedule(&run, &around).unwrap_err().code, "reschedule-path");
}

/// Same input, same numbers; a row of 10,000 blocks in time that is nearly in proportion.
/// `PROVEOUT_LONG_ROWS=100000` for one more.
#[test]
fn long_rows_are_planned_and_again_the_same() {
    let machine = machine("jdgr200t");
    let longer = std::env::var("PROVEOUT_LONG_ROWS").ok().and_then(|n| n.parse().ok());
    let mut took = Vec::new();
    for blocks in [1_000, 10_000].into_iter().chain(longer) {
        let run = row(blocks, 20.0, |s| {
            let a = 0.7 + 0.8 * (TAU * blocks as f64 / 800.0 * s).sin();
            Vector::new(0.35 * a.cos(), 0.35 * a.sin(), 1.0)
        });
        let begin = Instant::now();
        let done = made(&SmoothRows::default(), &run, &machine, &Open, None).unwrap();
        took.push((blocks, begin.elapsed().as_secs_f64()));
        if blocks == 1_000 {
            assert_eq!(done, made(&SmoothRows::default(), &run, &machine, &Open, None).unwrap());
        }
    }
    println!("{took:?}");
    for pair in took.windows(2) {
        let ([small, large], times) = ([pair[0].0, pair[1].0], [pair[0].1, pair[1].1]);
        // A busy machine may take four times as long, and short rows have what all have to do.
        assert!(times[1] < 4.0 * times[0].max(0.3) * large as f64 / small as f64, "{took:?}");
    }
    assert!(took[1].1 < 15.0, "{took:?}");
}
