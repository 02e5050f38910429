//! Limits measured on the emitted samples alone: differences of the set points, taken here, against the
//! machine's limits.
//!
//! A difference of set points over a cycle is the mean of the velocity over this cycle; a second and a third
//! difference are means of acceleration and jerk over two and three cycles. None can pass a limit that the
//! motion itself keeps.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

use crate::common;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Mutex,
};

use crate::common::{Program, Random, Run, for_all, motion, run_with, tool};
use proveout_controller::{Chunk, Controller, Settings, Summary};
use proveout_geom::Point;
use proveout_machine::Machine;
use proveout_nc::{Op, Program as NcProgram, Settings as NcSettings, WorkOffset};
use proveout_tool::ToolLibrary;

/// The promise: no limit is passed by more than 0.1 percent.
const ALLOWED: f64 = 1.001;

/// Seeds of random paths: 200 from zero on. `PROVEOUT_SAMPLE_PATHS` raises the number (10,000 for the whole
/// check), `PROVEOUT_SAMPLE_FIRST` the first.
fn seeds() -> std::ops::Range<u64> {
    let number = |name: &str, usual: u64| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(usual);
    let first = number("PROVEOUT_SAMPLE_FIRST", 0);
    first..first + number("PROVEOUT_SAMPLE_PATHS", 200)
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Highest part of the limits of velocity, acceleration and jerk in differences of the samples.
fn highest_use(run: &Run, machine: &Machine, cycle: f64) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    let samples = &run.all.samples;
    for (i, joint) in machine.joints.iter().enumerate() {
        let limits = [joint.max_velocity, joint.max_acceleration, joint.max_jerk];
        for (order, weights) in [&[-1.0, 1.0][..], &[1.0, -2.0, 1.0], &[-1.0, 3.0, -3.0, 1.0]].into_iter().enumerate() {
            let Some(limit) = limits[order] else { continue };
            for w in samples.windows(weights.len()) {
                // Only neighbors on the grid: a standstill has its first and last sample.
                if w.windows(2).any(|p| (p[1].time - p[0].time - cycle).abs() > 1e-3 * cycle) {
                    continue;
                }
                let sum: f64 = weights.iter().zip(w).map(|(c, s)| c * s.commanded[i]).sum();
                let size = w.iter().fold(1.0_f64, |m, s| m.max(s.commanded[i].abs()));
                // Rounding of positions of this size, divided by the power of the cycle.
                let rounding = 8.0 * f64::EPSILON * size;
                let value = (sum.abs() - rounding).max(0.0) / cycle.powi(order as i32 + 1);
                worst[order] = worst[order].max(value / limit);
            }
        }
    }
    worst
}

fn check(name: &str, run: &Run, machine: &Machine, cycle: f64) -> [f64; 3] {
    let worst = highest_use(run, machine, cycle);
    assert!(worst.iter().all(|w| *w <= ALLOWED), "{name}: parts of velocity, acceleration, jerk limits {worst:?}");
    assert!(run.summary.lower_bound_s.is_some_and(|b| b <= run.summary.total_s * (1.0 + 1e-12)), "{name}");
    worst
}

fn distance_to_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let d = b - a;
    let n = d.norm_squared();
    let t = if n > 0.0 { ((p - a).dot(&d) / n).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + d * t)).norm()
}

/// Runs a program text of a scene on a machine with a tool library.
fn run_text(path: &Path, machine: &Machine, tools: &str, offset: [f64; 3]) -> Run {
    let library = ToolLibrary::read(&root().join("tools").join(tools)).expect("the library of the scene");
    let work = WorkOffset { translation: offset, rotary: [0.0; 3] };
    let settings = NcSettings { work_offsets: BTreeMap::from([("G54".to_owned(), work)]), ..NcSettings::default() };
    let program = NcProgram::open(path, &settings).expect("a readable program");
    let mut controller = Controller::new(program, machine, &library.tools, Settings::default()).expect("good settings");
    let mut run = Run { all: Chunk::default(), chunks: 0, summary: Summary::default() };
    while let Some(chunk) = controller.next_chunk().expect("no refusal") {
        run.all.samples.extend(chunk.samples);
    }
    run.summary = controller.summary();
    run
}

#[test]
fn programs_of_the_scenes_keep_the_limits() {
    let machine = |name: &str| Machine::read(&root().join("machines").join(name)).expect("a machine of the library");
    let mut files: Vec<(PathBuf, &str, &str, [f64; 3])> = vec![
        (root().join("scenes/cone-frustum/bc.mpf"), "spinner-u5-620", "cone-frustum.toml", [0.0, 0.0, 140.0]),
        (root().join("scenes/cone-frustum/ac.mpf"), "ac-trunnion-620", "cone-frustum.toml", [0.0, 0.0, 140.0]),
        (root().join("scenes/li-2022-s-theta/original.mpf"), "starrag-lx-451", "li-2022.toml", [260.0, 0.0, 0.0]),
    ];
    let cross = "shared/cases/spinner-u5-840d/NC_code/Coordinate_system_representation_Achskreuz/\
                 Coordinate_system_representation_Achskreuz.mpf";
    match ["..", "../.."].map(|beside| root().join(beside).join(cross)).into_iter().find(|p| p.is_file()) {
        Some(path) => files.push((path, "spinner-u5-620", "axis-cross.toml", [25.0, 0.0, 0.0])),
        None => left_out(
            "samples of the axis cross: the data set doi:10.1038/s41597-025-05294-0 is not beside the checkout",
        ),
    }
    for (path, name, tools, offset) in files {
        let machine = machine(name);
        let run = run_text(&path, &machine, tools, offset);
        assert!(run.all.samples.len() > 1000, "{}", path.display());
        let worst = check(&path.display().to_string(), &run, &machine, machine.control.cycle_time);
        println!("{name}: {} samples, parts of the limits {worst:.4?}", run.all.samples.len());
    }
}

/// X Y Z with the tool, C on A under the workpiece.
fn xyzac(cycle_ms: f64, linear: [[f64; 2]; 3], rotary: [[f64; 2]; 2], velocity: Option<[f64; 2]>) -> Machine {
    let mut text = "name = \"xyzac\"\ndescription = \"for tests\"\n".to_owned();
    for (k, (name, direction, parent)) in
        [("X", "[1, 0, 0]", "base"), ("Y", "[0, 1, 0]", "X"), ("Z", "[0, 0, 1]", "Y")].into_iter().enumerate()
    {
        let [a, j] = linear[k];
        let v = velocity.map_or(String::new(), |v| {
            format!("max_velocity_mm_min = {0}\nrapid_velocity_mm_min = {0}\n", v[0] * 60.0)
        });
        text += &format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\n\
             direction = {direction}\n{v}max_acceleration_mm_s2 = {a}\nmax_jerk_mm_s3 = {j}\n\n"
        );
    }
    for (k, (name, direction, parent)) in [("A", "[1, 0, 0]", "base"), ("C", "[0, 0, 1]", "A")].into_iter().enumerate()
    {
        let [a, j] = rotary[k];
        let v =
            velocity.map_or(String::new(), |v| format!("max_velocity_deg_s = {0}\nrapid_velocity_deg_s = {0}\n", v[1]));
        text += &format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"rotary\"\ncarries = \"workpiece\"\nparent = \"{parent}\"\n\
             direction = {direction}\npoint_mm = [0, 0, 0]\nsense = -1\nendless = true\n{v}\
             max_acceleration_deg_s2 = {a}\nmax_jerk_deg_s3 = {j}\n\n"
        );
    }
    text += &format!(
        "[spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nstart_time_s = 0\n\n\
         [table]\non = \"C\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\n\
         [control]\ncycle_time_ms = {cycle_ms}\nblock_time_ms = 0\ntool_change_time_s = 0\nrapid_mode = \"straight\"\n\
         default_tolerance_mm = 0.01\ndefault_orientation_tolerance_deg = 0.1\n"
    );
    match Machine::from_text(Path::new("xyzac.toml"), &text) {
        Ok(machine) => machine,
        Err(e) => panic!("{e}"),
    }
}

/// Printed past the capture of the test harness: `cargo xtask ci` has these lines in its summary.
fn left_out(what: &str) {
    use std::io::Write as _;
    writeln!(std::io::stdout(), "\nLEFT OUT: {what}").ok();
}

#[test]
fn the_fan_path_keeps_limits_and_tolerance() {
    let file = "shared/cases/ijms2021-fan-path/path.csv";
    let places = [root().join("..").join(file), root().join("../..").join(file)];
    let Some(path) = places.iter().find(|p| p.is_file()) else {
        left_out("samples of a fan path: shared/cases/ijms2021-fan-path is not beside the checkout");
        return;
    };
    let text = std::fs::read_to_string(path).expect("a readable path");
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|l| l.split(',').map(|v| v.trim().parse().expect("a number")).collect()).collect();
    assert_eq!(rows.len(), 25);
    // limits.txt of the case: accelerations and jerks; it states no velocities. Interpolation every
    // millisecond.
    let linear = [[500.0, 5000.0], [500.0, 5000.0], [400.0, 4000.0]];
    let machine = xyzac(1.0, linear, [[300.0, 3000.0], [500.0, 5000.0]], None);
    for (tolerance, great_circle) in [(0.001, false), (0.05, false), (0.05, true)] {
        let mut program = Program::default().change(1);
        program = if great_circle { program.tcp_great_circle() } else { program.tcp(true) };
        program = program.continuous(tolerance).feed(50.0);
        let mut points = Vec::new();
        for (k, r) in rows.iter().enumerate() {
            let mut m = motion(&[('X', r[0]), ('Y', r[1]), ('Z', r[2])]);
            let n = (r[3] * r[3] + r[4] * r[4] + r[5] * r[5]).sqrt();
            m.tool_axis = Some([r[3] / n, r[4] / n, r[5] / n]);
            m.tool_axis_base = m.tool_axis;
            program = program.op(if k == 0 { Op::Rapid(m) } else { Op::Linear(m) });
            if k == 0 {
                program = program.exact_stop().feed(50.0).continuous(tolerance);
            }
            points.push(Point::new(r[0], r[1], r[2]));
        }
        let run = run_with(&program, &machine, &[tool(1, 100.0)], &Settings::default());
        let worst = check("fan", &run, &machine, 0.001);
        let first = run.all.blocks.len() - rows.len() + 1;
        let mut off = 0.0_f64;
        for s in run.all.samples.iter().filter(|s| s.block as usize > first) {
            let near = points.windows(2).map(|w| distance_to_segment(&s.pose.tip, &w[0], &w[1]));
            off = off.max(near.fold(f64::INFINITY, f64::min));
        }
        assert!(off <= tolerance + 1e-9, "tip {off} mm off at a tolerance of {tolerance} mm");
        println!(
            "fan, tolerance {tolerance}: {:.3} s, bound {:.3?} s, parts of the limits {worst:.4?}, tip {off:.5} mm",
            run.summary.total_s, run.summary.lower_bound_s
        );
    }
}

#[test]
fn random_paths_keep_limits_and_tolerance() {
    let machine = common::bc_machine();
    let cycle = machine.control.cycle_time;
    let worst = Mutex::new([0.0_f64; 3]);
    for_all(seeds(), |seed| {
        let mut r = Random::new(seed.wrapping_mul(77) + 5);
        let tolerance = 10_f64.powf(r.range(-3.0, -0.7));
        let step = 10_f64.powf(r.range(-1.5, 1.5));
        let turn = if r.unit() < 0.4 { 0.0 } else { 10_f64.powf(r.range(-3.0, -0.7)) };
        let mut at = [0.0, 0.0, 150.0, 0.3, 0.2];
        let start: Vec<(char, f64)> = "XYZBC".chars().zip(at).collect();
        let mut program =
            Program::default().change(1).g0(&start[..3]).g0(&start[3..]).tcp(true).g0(&start).exact_stop();
        program = program.g0(&start).continuous(tolerance);
        let mut points = vec![Point::new(0.0, 0.0, 150.0)];
        let blocks = 30;
        for k in 0..blocks {
            if k % 8 == 0 {
                program = program.feed(10_f64.powf(r.range(0.5, 2.6)));
            }
            for (i, v) in at.iter_mut().enumerate() {
                let size = [step, step, 0.3 * step, turn, 2.0 * turn][i];
                *v += r.range(-size, size);
            }
            at[3] = at[3].clamp(-1.2, 1.2);
            let values: Vec<(char, f64)> = "XYZBC".chars().zip(at).collect();
            program = program.g1(&values);
            points.push(Point::new(at[0], at[1], at[2]));
        }
        let run = run_with(&program, &machine, &[tool(1, 120.0)], &Settings::default());
        let found = check(&format!("path {seed}"), &run, &machine, cycle);
        let mut worst = worst.lock().expect("no other thread has failed");
        for k in 0..3 {
            worst[k] = worst[k].max(found[k]);
        }
        drop(worst);
        let first = run.all.blocks.len() - blocks;
        for s in run.all.samples.iter().filter(|s| s.block as usize >= first && s.time < run.summary.total_s) {
            let near = points.windows(2).map(|w| distance_to_segment(&s.pose.tip, &w[0], &w[1]));
            let d = near.fold(f64::INFINITY, f64::min);
            assert!(d <= tolerance + 1e-9, "path {seed}: tip {d} off at {} s, tolerance {tolerance}", s.time);
        }
    });
    println!("seeds {:?}, parts of the limits {:.4?}", seeds(), worst.into_inner().expect("no thread has failed"));
}

/// The kind of path on which the `LinuxCNC` planner passes its joint limits with its five-axis kinematics
/// (tip nearly still, rotary axes turning, so that the linear joints run far faster than the tip).
#[test]
fn a_still_tip_with_turning_axes_keeps_the_joint_limits() {
    // 20 mm/s a linear joint and 15 degrees a second, as in the sample configuration of that kind; jerk
    // chosen.
    let machine = xyzac(1.0, [[200.0, 4000.0]; 3], [[60.0, 1200.0]; 2], Some([20.0, 15.0]));
    let mut program = Program::default().change(1).tcp(true);
    program = program.g0(&[('X', 60.0), ('Y', 10.0), ('Z', 40.0), ('A', -0.6), ('C', 0.0)]).exact_stop();
    program = program.feed(100.0).g1(&[('X', 60.0), ('Y', 10.0), ('Z', 40.0), ('A', -0.6), ('C', 0.0)]);
    program = program.continuous(0.02);
    let blocks = 160;
    for k in 1..=blocks {
        let t = f64::from(k) / f64::from(blocks);
        let wave = (9.0 * t).sin();
        program = program.g1(&[
            ('X', 60.0 + 2.0 * t),
            ('Y', 10.0 + 0.6 * wave),
            ('Z', 40.0 - 1.5 * t),
            ('A', -0.6 - 0.35 * wave),
            ('C', 3.0 * t + 0.4 * (14.0 * t).sin()),
        ]);
    }
    let run = run_with(&program, &machine, &[tool(1, 60.0)], &Settings::default());
    let worst = check("still tip", &run, &machine, 0.001);
    // The limits are what rules here, not the feed: a test that could not fail would show small parts.
    assert!(worst[0] > 0.9 && worst[1] > 0.5, "{worst:?}");
    println!("still tip: {:.2} s, parts of the limits {worst:.4?}", run.summary.total_s);
}
