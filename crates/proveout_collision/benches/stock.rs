//! Prints what the check of machine bodies against the stock costs in addition to the cut: the boxes over the
//! tiles, a query that the raw box answers, one that goes to the rays, and a pass of finishing moves with its
//! refreshes.
//!
//! `cargo bench -p proveout_collision --bench stock`
#![allow(clippy::print_stdout, reason = "a benchmark prints its figures")]

use std::path::Path;
use std::time::Instant;

use proveout_collision::{Interference, JointMotion, StockCheck};
use proveout_geom::{Aabb, Point, Pose, ToolPose, Vector};
use proveout_machine::{JointValues, Machine};
use proveout_stock::{Action, SweepItem, SweepMotion, TileTree, TriDexel};
use proveout_tool::{Profile, Segment};

/// Moves of a stretch, as a run cuts them in one go.
const STRETCH: usize = 64;
const ROWS: usize = 40;
const MOVES: usize = 192;

fn fail(what: impl std::fmt::Display) -> ! {
    println!("{what}");
    std::process::exit(2);
}

fn ball(r: f64, l: f64) -> Profile {
    let segments = vec![
        Segment::Arc { center: [0.0, r], radius: r, from: [0.0, 0.0], to: [r, r] },
        Segment::Line { from: [r, r], to: [r, l] },
        Segment::Line { from: [r, l], to: [0.0, l] },
    ];
    Profile::new(segments).unwrap_or_else(|e| fail(e))
}

/// Seconds of each of `n` calls.
fn each(n: usize, mut work: impl FnMut(usize)) -> f64 {
    let start = Instant::now();
    (0..n).for_each(&mut work);
    start.elapsed().as_secs_f64() / n as f64
}

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/three-axis-mill");
    let machine = Machine::read(&folder).unwrap_or_else(|e| fail(e));
    let bounds = Aabb { min: Point::new(0.0, 0.0, -20.0), max: Point::new(100.0, 100.0, 0.0) };
    let mut stock = TriDexel::from_box(&bounds, 0.2, 16 << 30).unwrap_or_else(|e| fail(e));
    let mount = Pose::from_translation(Vector::new(0.0, 0.0, 150.0));
    let world = Interference::new(&machine, &[], 1.0).unwrap_or_else(|e| fail(e));
    let mut check = StockCheck::new(&world, &stock, &mount, 0.0).unwrap_or_else(|e| fail(e));
    let boxes = each(5, |_| drop(TileTree::new(&stock)));
    println!(
        "{:.2e} rays, {} bodies; boxes made in {:.2} ms, {:.2} MiB",
        stock.rays() as f64,
        check.followed().count(),
        1e3 * boxes,
        check.memory_bytes() as f64 / f64::from(1 << 20)
    );

    // Finishing rows: the gauge line is `gauge` over the tip.
    let body = ball(3.0, 40.0);
    let gauge = 80.0;
    let joints = |p: &Point| {
        let mut q = machine.inverse_with_rotary(&mount.point(p), &JointValues::ZERO, gauge);
        if !q.is_finite() {
            q = JointValues::ZERO;
        }
        q
    };
    let mut points = Vec::new();
    for row in 0..ROWS {
        for k in 0..=MOVES {
            let x = if row % 2 == 0 { k } else { MOVES - k } as f64 * 0.5 + 2.0;
            points.push(Point::new(x, 2.0 + 0.3 * row as f64, -1.0 + 0.35 * (x * 0.12).sin()));
        }
    }
    let motions: Vec<JointMotion> = points
        .windows(2)
        .enumerate()
        .map(|(k, w)| JointMotion {
            joints: [joints(&w[0]), joints(&w[1])],
            time: [k as f64, k as f64 + 1.0],
            off: JointValues::ZERO,
            slack: 5e-4,
        })
        .collect();
    let (mut cutting, mut following) = (0.0, 0.0);
    let mut done = 0;
    while done < motions.len() {
        let last = (done + STRETCH).min(motions.len());
        let start = Instant::now();
        let n = check.follow(&stock, &motions[done..last]);
        following += start.elapsed().as_secs_f64();
        let pose = |p: &Point| ToolPose { tip: *p, axis: Vector::z() };
        let items: Vec<SweepItem<'_>> = (done..done + n)
            .map(|k| SweepItem {
                id: k as u32,
                body: &body,
                action: Action::Remove,
                motion: SweepMotion { from: pose(&points[k]), to: pose(&points[k + 1]) },
            })
            .collect();
        let start = Instant::now();
        stock.sweep(&items);
        cutting += start.elapsed().as_secs_f64();
        done += n;
    }
    let moves = motions.len() as f64;
    println!(
        "{moves} moves: cut {:.2} us a move, followed {:.2} us a move ({:.1} % of the cut), {} queries, {} breaches",
        1e6 * cutting / moves,
        1e6 * following / moves,
        100.0 * following / cutting,
        check.queries(),
        check.breaches().len()
    );

    // A jump before each motion forgets what was proved, so that each motion asks for every body.
    for (name, z) in [("far: the raw box alone", 200.0), ("5 mm over the surface: rays", 5.0 - gauge)] {
        let at = |k: usize| joints(&Point::new(50.0 + 0.01 * k as f64, 50.0, z));
        let before = check.queries();
        let n = 200;
        let seconds = each(n, |k| {
            let q = at(100 * (k % 2) + k);
            let motion = JointMotion {
                joints: [q, q],
                time: [1e6 + k as f64, 1e6 + k as f64 + 1.0],
                off: JointValues::ZERO,
                slack: 5e-4,
            };
            check.follow(&stock, &[motion]);
        });
        let queries = (check.queries() - before) as f64 / n as f64;
        println!("{name}: {:.2} us a query ({queries:.1} queries a motion)", 1e6 * seconds / queries);
    }
}
