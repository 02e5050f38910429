//! Prints the nanoseconds a point and core that heights by the envelope and by the teeth take, and what
//! follows for 90 patches of 4 x 4 mm at 5 um (57.7 million points) on two cores; and the time of a million
//! points against a design of 200 000 triangles.
//!
//! `cargo bench -p proveout_surface --bench topography`; `-- --quick` takes a sixteenth of the patch. One
//! thread, and the processor time of it, which other programs on the machine lengthen less than the wall
//! time.
#![allow(clippy::print_stdout, reason = "a benchmark prints its figures")]

use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Instant;

use proveout_geom::{Point, Vector, revolved_mesh};
use proveout_surface::topography::{
    CutterPiece, Edge, Lattice, RunOut, Settings, TeethCorner, Topography, heights_by_edges, heights_by_envelope,
};
use proveout_surface::{DesignMesh, DesignSurface};
use proveout_tool::Cutter;
use rayon::prelude::*;

/// Points of 90 patches of 801 x 801.
const PATCHES: f64 = 90.0 * 801.0 * 801.0;

/// Processor time of this thread, s; none where the system does not say.
fn processor_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse::<f64>().ok().map(|ns| ns * 1e-9)
}

/// Passes along x at 0.3 mm in pieces of 0.5 mm, 800 mm/min, 4800 1/min; the axis leans by `lead`, and turns
/// by `swing` a millimeter.
fn passes(center_radius: f64, height: f64, lead: f64, swing: f64) -> Vec<CutterPiece> {
    let (feed, rate) = (800.0 / 60.0, -TAU * 80.0);
    let (mut out, mut time, mut azimuth) = (Vec::new(), 0.0, 0.0);
    for pass in 0..40 {
        let y = -4.0 + 0.3 * f64::from(pass);
        for k in 0..24 {
            let x = -4.0 + 0.5 * f64::from(k);
            let (a, b) = (lead + swing * x, lead + swing * (x + 0.5));
            // The corner's lowest place touches z = 0 at x.
            let tip = |x: f64, a: f64| {
                let (axis, down) = (Vector::new(a.sin(), 0.0, a.cos()), Vector::new(a.cos(), 0.0, -a.sin()));
                Point::new(x, y, 0.0) + Vector::z() * height - axis * height - down * center_radius
            };
            let z = Vector::new(a.sin(), 0.0, a.cos());
            let (from, to) = (tip(x, a), tip(x + 0.5, b));
            let duration = (to - from).norm() / feed;
            out.push(CutterPiece {
                time: [time, time + duration],
                tip: [from, to],
                housing: [Vector::y().cross(&z), Vector::y(), z],
                turn: Vector::y() * (b - a),
                azimuth,
                azimuth_rate: rate,
                motion: 24 * pass as u32 + k as u32,
            });
            time += duration;
            azimuth += rate * duration;
        }
        time += 1.0;
    }
    out
}

fn row(name: &str, points: usize, work: impl FnOnce() -> Topography) {
    let (wall, before) = (Instant::now(), processor_s());
    let found = work();
    let wall = wall.elapsed().as_secs_f64();
    let taken = match (before, processor_s()) {
        (Some(a), Some(b)) => b - a,
        _ => wall,
    };
    println!(
        "{name:<34} {:>6.0} ns a point-core, 90 patches on two cores {:>5.1} s; wall {wall:.2} s, again {}, not cut {}",
        taken * 1e9 / points as f64,
        0.5 * taken * PATCHES / points as f64,
        found.again,
        found.uncut()
    );
}

fn main() {
    let quick = std::env::args().any(|a| a == "--quick");
    let n = if quick { 201 } else { 801 };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    let Ok(one) = one else { return println!("no thread pool") };
    let lattice = Lattice::plane(Point::new(0.5, 0.5, 0.0), Vector::x(), Vector::y(), [0.005, 0.005], n, n);
    let settings = Settings { max_height: 0.2 };
    let (Some(lattice), Ok(ball), Ok(bull)) = (
        lattice,
        Cutter::ball(6.0).and_then(|c| c.bodies(20.0)),
        Cutter::bull_nose(8.0, 1.5).and_then(|c| c.bodies(20.0)),
    ) else {
        return println!("no cutter");
    };
    let teeth = |radius: f64, corner_radius: f64| -> Vec<Edge> {
        TeethCorner { radius, corner_radius, corner: [0.0, FRAC_PI_2], helix: 0.5 }
            .edges(&[RunOut::default(), RunOut { radial: 0.005, axial: 0.001 }])
    };
    let rows = [
        ("ball, straight", 0.0, 3.0, 0.2, 0.0),
        ("ball, five axes", 0.0, 3.0, 0.2, 0.02),
        ("ball upright, straight", 0.0, 3.0, 0.0, 0.0),
        ("bull nose, straight", 2.5, 1.5, 0.2, 0.0),
        ("bull nose, five axes", 2.5, 1.5, 0.2, 0.02),
    ];
    for (name, center, height, lead, swing) in rows {
        let pieces = passes(center, height, lead, swing);
        let cutter = if center == 0.0 { &ball[0] } else { &bull[0] };
        let edges = teeth(center + height, height);
        one.install(|| {
            row(&format!("{name}: envelope"), n * n, || heights_by_envelope(&lattice, cutter, &pieces, &settings));
            row(&format!("{name}: two teeth"), n * n, || heights_by_edges(&lattice, &edges, &pieces, &settings));
        });
    }
    against_a_design(if quick { 62_500 } else { 1_000_000 });
}

/// Distances of points near a design of 200 000 triangles, on all threads.
fn against_a_design(points: usize) {
    // A ball of 30 mm: rings of 400 sectors.
    let rings = 251;
    let profile: Vec<[f64; 2]> = (0..=rings)
        .map(|k| std::f64::consts::PI * f64::from(k) / f64::from(rings))
        .map(|a| [if (1e-9..std::f64::consts::PI - 1e-9).contains(&a) { 30.0 * a.sin() } else { 0.0 }, -30.0 * a.cos()])
        .collect();
    let mesh = revolved_mesh(&profile, 400);
    let Ok(design) = DesignMesh::new(&mesh) else { return println!("the ball is no solid") };
    let cloud: Vec<Point> = (0..points)
        .map(|i| {
            // Evenly over the ball (golden spiral), up to 20 um off it.
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / points as f64;
            let (a, r) = (2.399_963_229_728_653 * i as f64, (1.0 - z * z).sqrt());
            Point::from(Vector::new(r * a.cos(), r * a.sin(), z) * (30.0 + 0.02 * (i as f64 * 0.7).sin()))
        })
        .collect();
    let begin = Instant::now();
    let worst = cloud.par_iter().filter_map(|p| design.signed_distance(p)).map(f64::abs).reduce(|| 0.0, f64::max);
    println!(
        "{points} points against {} triangles: {:.2} s wall on {} threads, farthest {:.4} mm",
        mesh.triangles.len(),
        begin.elapsed().as_secs_f64(),
        rayon::current_num_threads(),
        worst
    );
}
