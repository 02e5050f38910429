//! Speed of heights by envelope and by teeth over one patch of 4 x 4 mm at 5 um: straight passes of a ball and of a bull nose.
//!
//! `cargo run --release -p proveout_surface --example patch_speed`

use std::time::Instant;

use proveout_geom::{Point, Vector};
use proveout_surface::topography::{
    Corner, CutterPiece, Lattice, RunOut, Settings, heights_by_edges, heights_by_envelope,
};
use proveout_tool::Cutter;

fn passes(lead: f64, five_axis: bool) -> Vec<CutterPiece> {
    // Passes along x at 0.3 mm, pieces of 0.5 mm, 800 mm/min, 4800 rpm.
    let (feed, rate) = (800.0 / 60.0, -std::f64::consts::TAU * 80.0);
    let mut out = Vec::new();
    let mut time = 0.0;
    let mut azimuth = 0.0;
    for pass in 0..40 {
        let y = -4.0 + 0.3 * f64::from(pass);
        for k in 0..24 {
            let x = -4.0 + 0.5 * f64::from(k);
            let angle = |x: f64| if five_axis { lead + 0.02 * x } else { lead };
            let (a, b) = (angle(x), angle(x + 0.5));
            let axis = |a: f64| Vector::new(a.sin(), 0.0, a.cos());
            let tip = |x: f64, a: f64| Point::new(x, y, 0.0) + Vector::new(0.0, 0.0, 3.0) - axis(a) * 3.0;
            let z = axis(a);
            let duration = 0.5 / feed;
            out.push(CutterPiece {
                time: [time, time + duration],
                tip: [tip(x, a), tip(x + 0.5, b)],
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

fn main() {
    let n = 801;
    let lattice =
        Lattice::plane(Point::new(0.0, 0.0, 0.0), Vector::x(), Vector::y(), [0.005, 0.005], n, n).expect("a lattice");
    let settings = Settings { max_height: 0.2 };
    let bodies = Cutter::ball(6.0).and_then(|c| c.bodies(20.0)).expect("a ball");
    let profile = bodies[0].clone();
    let corner = Corner { radius: 3.0, corner_radius: 3.0, corner: [0.0, std::f64::consts::FRAC_PI_2], helix: 0.5 };
    let edges = corner.edges(&[RunOut::default(), RunOut { radial: 0.005, axial: 0.001 }]);
    for (name, five) in [("straight", false), ("five axes", true)] {
        let pieces = passes(0.2, five);
        let begin = Instant::now();
        let found = heights_by_envelope(&lattice, &profile, &pieces, &settings);
        report(name, "envelope", begin.elapsed().as_secs_f64(), n * n, found.again, found.uncut());
        let begin = Instant::now();
        let found = heights_by_edges(&lattice, &edges, &pieces, &settings);
        report(name, "2 teeth", begin.elapsed().as_secs_f64(), n * n, found.again, found.uncut());
    }
}

#[expect(clippy::print_stdout, reason = "a program whose output is its purpose")]
fn report(name: &str, what: &str, seconds: f64, points: usize, again: usize, uncut: usize) {
    println!(
        "{name} {what}: {:.3} s, {:.0} ns a point, searched again {again}, not cut {uncut}",
        seconds,
        seconds * 1e9 / points as f64
    );
}
