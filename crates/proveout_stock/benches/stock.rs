//! Prints what history, engagement, files and re-gridding of a stock cost, and how removal grows with the
//! material that is met.
//!
//! `cargo bench -p proveout_stock --bench stock`; `-- --rows 20` takes other rows of 192 moves of 0.5 mm, 0.3
//! mm apart.
#![allow(clippy::print_stdout, reason = "a benchmark prints its figures")]

use std::time::Instant;

use proveout_geom::{Aabb, Point, Pose, ToolPose, Vector, rad};
use proveout_stock::{Action, Patch, PatchPlan, Probe, RawBody, SweepItem, SweepMotion, TriDexel};
use proveout_tool::{Profile, Segment};

const MIB: f64 = 1_048_576.0;

fn ball(r: f64, l: f64) -> Profile {
    let segments = vec![
        Segment::Arc { center: [0.0, r], radius: r, from: [0.0, 0.0], to: [r, r] },
        Segment::Line { from: [r, r], to: [r, l] },
        Segment::Line { from: [r, l], to: [0.0, l] },
    ];
    match Profile::new(segments) {
        Ok(p) => p,
        Err(e) => {
            println!("{e}");
            std::process::exit(2);
        }
    }
}

fn block(cells: impl Into<proveout_stock::Cells>) -> TriDexel {
    let bounds = Aabb { min: Point::new(0.0, 0.0, -20.0), max: Point::new(100.0, 100.0, 0.0) };
    match TriDexel::from_box(&bounds, cells, 16 << 30) {
        Ok(s) => s,
        Err(e) => {
            println!("{e}");
            std::process::exit(2);
        }
    }
}

/// Rows back and forth over a waved surface `depth` below the top.
fn waves(rows: usize, depth: f64, tilt: f64) -> Vec<SweepMotion> {
    let pose = |x: f64, y: f64| {
        let z = -depth + 0.35 * (x * 0.12).sin() + 0.25 * (y * 0.17 + x * 0.05).cos();
        let axis = Vector::new(tilt * (x * 0.063).sin(), tilt * (y * 0.05 + 1.0).cos(), 1.0).normalize();
        ToolPose { tip: Point::new(x, y, z), axis }
    };
    let mut moves = Vec::new();
    for row in 0..rows {
        let y = 2.0 + 0.3 * row as f64;
        let x = |k: usize| if row % 2 == 0 { 2.0 + 0.5 * k as f64 } else { 98.0 - 0.5 * k as f64 };
        moves.extend((0..192).map(|k| SweepMotion { from: pose(x(k), y), to: pose(x(k + 1), y) }));
    }
    moves
}

/// Processor time of all threads so far, where the system says it.
fn cpu_seconds() -> f64 {
    let read = || {
        let tasks = std::fs::read_dir("/proc/self/task").ok()?;
        let nanoseconds = tasks.filter_map(|t| {
            let text = std::fs::read_to_string(t.ok()?.path().join("schedstat")).ok()?;
            text.split_whitespace().next()?.parse::<f64>().ok()
        });
        Some(nanoseconds.sum::<f64>() * 1e-9)
    };
    read().unwrap_or_default()
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let result = work();
    let used = cpu_seconds() - cpu;
    (result, if used > 0.0 { used } else { start.elapsed().as_secs_f64() })
}

/// Cuts; processor time and rays cut.
fn cut(stock: &mut TriDexel, body: &Profile, moves: &[SweepMotion]) -> (f64, u64) {
    let items: Vec<SweepItem<'_>> = moves
        .iter()
        .enumerate()
        .map(|(k, m)| SweepItem { id: k as u32, body, action: Action::Remove, motion: *m })
        .collect();
    let (reports, used) = timed(|| stock.sweep(&items));
    (used, reports.iter().map(|r| r.rays).sum())
}

fn watched(rows: usize) {
    let body = ball(4.0, 40.0);
    for tilt in [0.0, 0.36] {
        let moves = waves(rows, 1.5, tilt);
        // Least of three: other programs may run at the same time.
        let least = |prepare: &dyn Fn(&mut TriDexel)| {
            let mut best = (f64::INFINITY, 0, block(0.1));
            for _ in 0..3 {
                let mut stock = block(0.1);
                prepare(&mut stock);
                let (used, rays) = cut(&mut stock, &body, &moves);
                if used < best.0 {
                    best = (used, rays, stock);
                }
            }
            best
        };
        let plain = least(&|_| {});
        let engaged = least(&|s| s.watch_engagement(true));
        let kept = least(&TriDexel::keep_history);
        let ns = |x: &(f64, u64, TriDexel)| x.0 * 1e9 / x.1 as f64;
        println!(
            "ball R4, tilt {tilt:4}: {:.0} ns a ray cut; with engagement {:.0} ({:+.0} %), with history {:.0} ({:+.0} %)",
            ns(&plain),
            ns(&engaged),
            100.0 * (engaged.0 / plain.0 - 1.0),
            ns(&kept),
            100.0 * (kept.0 / plain.0 - 1.0),
        );
        let (bytes, changes) = (kept.2.history_bytes() as f64, kept.2.history_changes() as f64);
        println!(
            "    history: {changes:.0} changes, {:.1} bytes each, {:.1} MiB beside {:.1} MiB of stock",
            bytes / changes,
            bytes / MIB,
            plain.2.memory_bytes() as f64 / MIB
        );
        let (back, used) = timed(|| kept.2.after(moves.len() as u32 / 2));
        println!(
            "    the stock after half of the moves: {:.3} s, {}",
            used,
            if back.is_ok() { "found" } else { "lost" }
        );
    }
}

fn files(rows: usize) {
    let mut stock = block(0.1);
    cut(&mut stock, &ball(4.0, 40.0), &waves(rows, 1.5, 0.36));
    let mut bytes = Vec::new();
    let (saved, used) = timed(|| stock.save(&mut bytes));
    let intervals = stock.surface_points().count() as f64 / 2.0;
    println!(
        "file: {:.1} MiB for {intervals:.0} intervals ({:.1} bytes each), saved in {used:.2} s{}",
        bytes.len() as f64 / MIB,
        bytes.len() as f64 / intervals,
        if saved.is_ok() { "" } else { ", with an error" }
    );
    let (_, used) = timed(|| TriDexel::load(&mut bytes.as_slice(), 4 << 30));
    println!("    loaded in {used:.2} s");
    for (name, pose, cell) in [
        ("turned over", Pose::from_rpy(Vector::zeros(), rad(180.0), 0.0, 0.0), 0.1),
        ("turned by 30 degrees", Pose::from_rpy(Vector::zeros(), 0.0, 0.0, rad(30.0)), 0.1),
        ("with cells of 0.2 mm", Pose::identity(), 0.2),
    ] {
        let (new, used) = timed(|| stock.regridded(&pose, cell, 16 << 30));
        match new {
            Ok(new) => println!("    {name}: {used:.2} s, {:?}", new.regrid_bound()),
            Err(e) => println!("    {name}: {e}"),
        }
    }
    let (probe, used) = timed(|| Probe::new(&stock));
    let (found, asked) = timed(|| {
        (0..10_000).filter(|k| probe.nearest(&Point::new(50.0, 0.01 * f64::from(*k), -1.0)).is_some()).count()
    });
    println!("probe: {used:.2} s to make, {:.1} us a nearest point ({found} found)", asked * 100.0);
}

/// Time against the material that is met: the same moves at several depths, above the block, and with a
/// longer tool.
fn scaling(rows: usize) {
    for (name, depth, length) in [
        ("1.5 mm deep", 1.5, 40.0),
        ("3 mm deep", 3.0, 40.0),
        ("3 mm deep, tool twice as long", 3.0, 80.0),
        ("in the air above", -5.0, 40.0),
    ] {
        let body = ball(4.0, length);
        let moves = waves(rows, depth, 0.0);
        let mut best = (f64::INFINITY, 0);
        for _ in 0..3 {
            let (used, rays) = cut(&mut block(0.1), &body, &moves);
            best = if used < best.0 { (used, rays) } else { best };
        }
        println!(
            "{name:30} {:6.1} us a move, {:5.0} rays cut a move, {:6.1} ns a ray cut",
            best.0 * 1e6 / moves.len() as f64,
            best.1 as f64 / moves.len() as f64,
            best.0 * 1e9 / best.1.max(1) as f64
        );
    }
    for cells in [[0.1, 0.1, 0.1], [0.4, 0.1, 0.1]] {
        let mut stock = block(cells);
        let (used, rays) = cut(&mut stock, &ball(4.0, 40.0), &waves(rows, 1.5, 0.0));
        println!("cells {cells:?} mm: {:.1} MiB, {used:.2} s, {rays} rays cut", stock.memory_bytes() as f64 / MIB);
    }
}

/// What a patch of 10 x 10 mm with cells of half the size costs in addition to the stock: over the path, and
/// where no motion comes.
fn patches(rows: usize) {
    let (body, raw) = (ball(4.0, 40.0), RawBody::block(&block(1.0).bounds()));
    let moves = waves(rows, 1.5, 0.36);
    let items: Vec<SweepItem<'_>> = moves
        .iter()
        .enumerate()
        .map(|(k, m)| SweepItem { id: k as u32, body: &body, action: Action::Remove, motion: *m })
        .collect();
    let stock = (0..3).map(|_| cut(&mut block(0.1), &body, &moves).0).fold(f64::INFINITY, f64::min);
    for (name, low) in [("over the path", [45.0, 1.0]), ("far from it", [45.0, 85.0])] {
        let window = Aabb { min: Point::new(low[0], low[1], -5.0), max: Point::new(low[0] + 10.0, low[1] + 10.0, 1.0) };
        let bounds = Aabb { min: Point::new(0.0, 0.0, -20.0), max: Point::new(100.0, 100.0, 0.0) };
        let made = PatchPlan::new(&bounds, [0.1; 3], &window, 0.05).map(|plan| Patch::new("p", plan, &raw, 4 << 30));
        let Ok(Ok(patch)) = made else { continue };
        let mib = patch.stock().memory_bytes() as f64 / MIB;
        let once = || {
            let mut patch = patch.clone();
            timed(|| patch.sweep(&items)).1
        };
        let used = (0..3).map(|_| once()).fold(f64::INFINITY, f64::min);
        println!(
            "patch {name}: {mib:.1} MiB, {:.3} us a move, {:.2} % of the stock's {:.1} us",
            used * 1e6 / moves.len() as f64,
            100.0 * used / stock,
            stock * 1e6 / moves.len() as f64
        );
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let at = arguments.iter().position(|a| a == "--rows");
    let rows = at.and_then(|k| arguments.get(k + 1)).and_then(|n| n.parse().ok()).unwrap_or(40);
    watched(rows);
    files(rows);
    scaling(rows);
    patches(rows);
}
