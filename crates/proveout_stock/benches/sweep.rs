//! Prints moves a second, time a ray touched and memory on a 100 x 100 x 20 mm block, and what the machine
//! could do at most.
//!
//! `cargo bench -p proveout_stock` runs all rows; `-- --quick` takes a tenth of the moves, `-- --cell 0.2`
//! another cell size, `-- --only tilting` the rows with that word. A core is one thread: rows marked so use
//! the processor time of all threads, the row with two threads their wall time, which other programs on the
//! machine lengthen.
#![allow(clippy::print_stdout, reason = "a benchmark prints its figures")]

use std::time::Instant;

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_stock::{Action, SweepItem, SweepMotion, TriDexel};
use proveout_tool::{Profile, Segment};

fn profile(segments: Vec<Segment>) -> Profile {
    match Profile::new(segments) {
        Ok(p) => p,
        Err(e) => {
            println!("{e}");
            std::process::exit(2);
        }
    }
}

fn line(from: [f64; 2], to: [f64; 2]) -> Segment {
    Segment::Line { from, to }
}

fn bull(r: f64, c: f64, l: f64) -> Profile {
    let arc = Segment::Arc { center: [r - c, c], radius: c, from: [r - c, 0.0], to: [r, c] };
    let mut segments = vec![arc, line([r, c], [r, l]), line([r, l], [0.0, l])];
    if r > c {
        segments.insert(0, line([0.0, 0.0], [r - c, 0.0]));
    }
    profile(segments)
}

fn flat(r: f64, l: f64) -> Profile {
    profile(vec![line([0.0, 0.0], [r, 0.0]), line([r, 0.0], [r, l]), line([r, l], [0.0, l])])
}

/// Rows of 0.5 mm moves, 0.3 mm apart, back and forth over z = -1.5 + waves of 0.5 mm.
fn waves(rows: usize, tilt: f64) -> Vec<SweepMotion> {
    let pose = |x: f64, y: f64| {
        let z = -1.5 + 0.35 * (x * 0.12).sin() + 0.25 * (y * 0.17 + x * 0.05).cos();
        let (a, b) = (tilt * (x * 0.063).sin(), tilt * (y * 0.05 + 1.0).cos());
        ToolPose { tip: Point::new(x, y, z), axis: Vector::new(a.sin(), b.sin(), 1.0).normalize() }
    };
    let mut moves = Vec::new();
    for row in 0..rows {
        let y = 2.0 + 0.3 * row as f64;
        let x = |k: usize| if row % 2 == 0 { 2.0 + 0.5 * k as f64 } else { 98.0 - 0.5 * k as f64 };
        moves.extend((0..192).map(|k| SweepMotion { from: pose(x(k), y), to: pose(x(k + 1), y) }));
    }
    moves
}

/// Slots and pockets of a flat end mill at constant height.
fn pocket(rows: usize) -> Vec<SweepMotion> {
    let pose = |x: f64, y: f64| ToolPose { tip: Point::new(x, y, -2.0), axis: Vector::z() };
    let mut moves = Vec::new();
    for row in 0..rows {
        let y = 2.0 + 3.0 * row as f64;
        let x = |k: usize| if row % 2 == 0 { 2.0 + 0.5 * k as f64 } else { 98.0 - 0.5 * k as f64 };
        moves.extend((0..192).map(|k| SweepMotion { from: pose(x(k), y), to: pose(x(k + 1), y) }));
    }
    moves
}

/// A 40 mm flank that cuts along the side of the block and tilts all the time.
fn flank(rows: usize) -> Vec<SweepMotion> {
    let mut moves = Vec::new();
    for row in 0..rows {
        let pose = |x: f64| ToolPose {
            tip: Point::new(x, -4.0 + 0.5 * row as f64 + 0.01 * x, -21.0),
            axis: Vector::new(0.05 * (x * 0.2).sin(), 0.1 * (x * 0.06).sin(), 1.0).normalize(),
        };
        moves
            .extend((0..192).map(|k| SweepMotion { from: pose(2.0 + 0.5 * k as f64), to: pose(2.5 + 0.5 * k as f64) }));
    }
    moves
}

/// Processor time of all threads so far, where the system says it (Linux: nanoseconds in the first field of
/// schedstat).
fn cpu_seconds() -> Option<f64> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let nanoseconds = tasks.filter_map(|t| {
        let text = std::fs::read_to_string(t.ok()?.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    Some(nanoseconds.sum::<f64>() * 1e-9)
}

fn run(name: &str, only: Option<&String>, cell: f64, body: &Profile, moves: &[SweepMotion], action: Action) {
    if only.is_some_and(|word| !name.contains(word.as_str())) {
        return;
    }
    let block = Aabb { min: Point::new(0.0, 0.0, -20.0), max: Point::new(100.0, 100.0, 0.0) };
    let mut stock = match TriDexel::from_box(&block, cell, 16 << 30) {
        Ok(s) => s,
        Err(e) => {
            println!("{name}: {e}");
            return;
        }
    };
    let items: Vec<SweepItem<'_>> =
        moves.iter().enumerate().map(|(k, m)| SweepItem { id: k as u32, body, action, motion: *m }).collect();
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let reports = stock.sweep(&items);
    let (wall, used) = (start.elapsed().as_secs_f64(), cpu_seconds().zip(cpu).map(|(b, a)| b - a));
    // On a machine that others use too only the processor time says something.
    let seconds = used.unwrap_or(wall * rayon::current_num_threads() as f64);
    let rays: u64 = reports.iter().map(|r| r.rays).sum();
    let volume: f64 = reports.iter().map(|r| r.volume_mm3).sum();
    println!(
        "{name:34} {:6} moves {:8.0} moves/s of a core {:6.1} ns/ray cut {:5.0} rays/move {:8.0} mm3 {:4.0} MiB bound {:.2} um \
         wall {wall:.2} s = {:.0} moves/s",
        items.len(),
        items.len() as f64 / seconds,
        seconds * 1e9 / rays.max(1) as f64,
        rays as f64 / items.len() as f64,
        volume,
        stock.memory_bytes() as f64 / f64::from(1 << 20),
        stock.sweep_bound_mm() * 1e3,
        items.len() as f64 / wall,
    );
}

/// Surface of a 50 x 50 x 65 mm block with 0.2 mm cells (250 x 250 x 325) after some cuts.
fn surface(ball: &Profile) {
    let block = Aabb { min: Point::new(0.0, 0.0, -65.0), max: Point::new(50.0, 50.0, 0.0) };
    let Ok(mut stock) = TriDexel::from_box(&block, 0.2, 1 << 30) else { return };
    let moves: Vec<SweepMotion> = waves(32, 0.2);
    let item = |m: &SweepMotion| SweepItem { id: 1, body: ball, action: Action::Remove, motion: *m };
    stock.sweep(&moves.iter().map(item).collect::<Vec<_>>());
    let start = Instant::now();
    let mesh = stock.surface();
    println!(
        "surface of {:?} cells: {} triangles in {:.2} s; closed: {}",
        stock.counts(),
        mesh.mesh.triangles.len(),
        start.elapsed().as_secs_f64(),
        mesh.mesh.check_solid().is_ok()
    );
}

/// Two threads against one, by the clock on the wall.
fn two_threads(cell: f64, name: &str, body: &Profile, moves: &[SweepMotion]) {
    let block = Aabb { min: Point::new(0.0, 0.0, -20.0), max: Point::new(100.0, 100.0, 0.0) };
    let time = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()?;
        let mut stock = TriDexel::from_box(&block, cell, 16 << 30).ok()?;
        let item = |(k, m): (usize, &SweepMotion)| SweepItem { id: k as u32, body, action: Action::Remove, motion: *m };
        let items: Vec<SweepItem<'_>> = moves.iter().enumerate().map(item).collect();
        let start = Instant::now();
        pool.install(|| stock.sweep(&items));
        Some(start.elapsed().as_secs_f64())
    };
    let least = |threads: usize| (0..3).filter_map(|_| time(threads)).fold(f64::INFINITY, f64::min);
    let (one, two) = (least(1), least(2));
    println!(
        "{name:34} {:8.0} moves/s of wall time with two threads, {:.2} times one thread (other programs lengthen it)",
        moves.len() as f64 / two,
        one / two
    );
}

/// What one thread can calculate: multiplications and additions on independent numbers that stay in
/// registers, in the same vectors of four that the kernels are compiled for.
fn arithmetic() -> f64 {
    struct TileWork;
    impl pulp::WithSimd for TileWork {
        type Output = f64;

        #[inline(always)]
        fn with_simd<S: pulp::Simd>(self, simd: S) -> f64 {
            const ROUNDS: usize = 40_000_000;
            let (a, b) = (simd.splat_f64s(0.999_999), simd.splat_f64s(1e-6));
            let start = cpu_seconds();
            let (mut x0, mut x1, mut x2, mut x3) = (a, b, a, b);
            let (mut x4, mut x5, mut x6, mut x7) = (a, b, a, b);
            for _ in 0..ROUNDS {
                x0 = simd.add_f64s(simd.mul_f64s(x0, a), b);
                x1 = simd.add_f64s(simd.mul_f64s(x1, a), b);
                x2 = simd.add_f64s(simd.mul_f64s(x2, a), b);
                x3 = simd.add_f64s(simd.mul_f64s(x3, a), b);
                x4 = simd.add_f64s(simd.mul_f64s(x4, a), b);
                x5 = simd.add_f64s(simd.mul_f64s(x5, a), b);
                x6 = simd.add_f64s(simd.mul_f64s(x6, a), b);
                x7 = simd.add_f64s(simd.mul_f64s(x7, a), b);
            }
            std::hint::black_box((x0, x1, x2, x3, x4, x5, x6, x7));
            let seconds = cpu_seconds().zip(start).map_or(f64::NAN, |(end, start)| end - start);
            16.0 * (ROUNDS * S::F64_LANES) as f64 / seconds
        }
    }
    (0..3).map(|_| pulp::Arch::new().dispatch(TileWork)).fold(0.0, f64::max)
}

/// How much longer a program takes when its moves in air become twice as long.
fn air_share(cell: f64, body: &Profile, rows: usize) {
    let block = Aabb { min: Point::new(0.0, 0.0, -20.0), max: Point::new(100.0, 100.0, 0.0) };
    let with_air = |count: u32, length: f64| {
        let mut moves = Vec::new();
        for row in waves(rows, 0.349).chunks(192) {
            moves.extend_from_slice(row);
            let high =
                |k: u32| ToolPose { tip: Point::new(20.0 + length * f64::from(k), 50.0, 15.0), axis: Vector::z() };
            moves.extend((0..count).map(|k| SweepMotion { from: high(k % 64), to: high(k % 64 + 1) }));
        }
        moves
    };
    let programs = [with_air(200, 0.5), with_air(200, 1.0), with_air(400, 0.5)];
    // One thread, since threads that wait for work take processor time too; in turns, since the machine's
    // speed drifts.
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(1).build() else { return };
    let seconds = |moves: &[SweepMotion]| {
        let item = |(k, m): (usize, &SweepMotion)| SweepItem { id: k as u32, body, action: Action::Remove, motion: *m };
        let items: Vec<SweepItem<'_>> = moves.iter().enumerate().map(item).collect();
        let mut stock = TriDexel::from_box(&block, cell, 16 << 30).ok()?;
        let start = cpu_seconds();
        pool.install(|| stock.sweep(&items));
        cpu_seconds().zip(start).map(|(b, a)| b - a)
    };
    let mut least = [f64::INFINITY; 3];
    for _ in 0..15 {
        for (least, moves) in least.iter_mut().zip(&programs) {
            *least = seconds(moves).unwrap_or(f64::INFINITY).min(*least);
        }
    }
    let more = |k: usize| 100.0 * (least[k] / least[0] - 1.0);
    println!("air moves twice as long: {:+.2} percent of processor time, twice as many: {:+.2}", more(1), more(2));
}

/// Memory of a blade block with fine cells, and the speed of memory itself.
fn memory() {
    let block = Aabb { min: Point::origin(), max: Point::new(100.0, 60.0, 40.0) };
    let announced = TriDexel::memory_estimate(&block, 0.05) as f64 / f64::from(1 << 20);
    if let Ok(stock) = TriDexel::from_box(&block, 0.05, 4 << 30) {
        let used = stock.memory_bytes() as f64 / f64::from(1 << 20);
        println!(
            "100 x 60 x 40 mm, 0.05 mm cells: {} rays, {used:.0} MiB in use, {announced:.0} MiB announced",
            stock.rays()
        );
    }
    let from = vec![1.0_f64; 32 << 20];
    let mut to = vec![0.0_f64; from.len()];
    // Eight times, so that the grain of the clock does not count.
    let start = cpu_seconds();
    for _ in 0..8 {
        to.copy_from_slice(std::hint::black_box(&from));
        std::hint::black_box(&mut to);
    }
    let seconds = cpu_seconds().zip(start).map_or(f64::NAN, |(end, start)| end - start);
    println!("memory: {:.1} GB/s read and written by one thread", 8.0 * 16.0 * from.len() as f64 * 1e-9 / seconds);
    println!("arithmetic: {:.1} Gflop/s of one thread, multiplication and addition in halves", arithmetic() * 1e-9);
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let quick = arguments.iter().any(|a| a == "--quick");
    let value = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1)?.parse().ok());
    let cell = value("--cell").unwrap_or(0.1);
    let only = arguments.iter().position(|a| a == "--only").and_then(|k| arguments.get(k + 1));
    let rows = if quick { 32 } else { 320 };
    let twenty_degrees = 0.349;
    let (ball, bull, flat) = (bull(4.0, 4.0, 40.0), bull(5.0, 3.0, 40.0), flat(5.0, 40.0));
    println!("100 x 100 x 20 mm block, {cell} mm cells, {} threads", rayon::current_num_threads());
    run("ball R4, three axes", only, cell, &ball, &waves(rows, 0.0), Action::Remove);
    run("ball R4, tilting to 20 deg", only, cell, &ball, &waves(rows, twenty_degrees), Action::Remove);
    run("bull-nose R5 r3, three axes", only, cell, &bull, &waves(rows, 0.0), Action::Remove);
    run("bull-nose R5 r3, tilting to 20 deg", only, cell, &bull, &waves(rows, twenty_degrees), Action::Remove);
    run("flat R5, pocket at one height", only, cell, &flat, &pocket(rows.min(32)), Action::Remove);
    run("flat R5, flank 20 mm deep, tilting", only, cell, &flat, &flank(rows.min(16)), Action::Remove);
    // The same cut with five times the tool: what is not met must not count.
    let long = profile(vec![
        Segment::Arc { center: [0.0, 4.0], radius: 4.0, from: [0.0, 0.0], to: [4.0, 4.0] },
        line([4.0, 4.0], [4.0, 200.0]),
        line([4.0, 200.0], [0.0, 200.0]),
    ]);
    run("ball R4, 200 mm long, three axes", only, cell, &long, &waves(rows, 0.0), Action::Remove);
    let above = |m: &SweepMotion| {
        let up = |p: ToolPose| ToolPose { tip: p.tip + Vector::z() * 8.0, ..p };
        SweepMotion { from: up(m.from), to: up(m.to) }
    };
    let air: Vec<SweepMotion> = waves(rows, twenty_degrees).iter().map(above).collect();
    run("ball R4 in air", only, cell, &ball, &air, Action::Remove);
    if only.is_none_or(|word| "two threads".contains(word.as_str())) {
        two_threads(cell, "ball R4, tilting to 20 deg", &ball, &waves(rows.min(64), twenty_degrees));
        two_threads(cell, "bull-nose R5 r3, tilting to 20 deg", &bull, &waves(rows.min(64), twenty_degrees));
    }
    if only.is_none_or(|word| "air".contains(word.as_str())) {
        air_share(cell, &ball, rows.min(64));
    }
    if only.is_none_or(|word| "memory".contains(word.as_str())) {
        memory();
    }
    if only.is_none() {
        surface(&ball);
    }
}
