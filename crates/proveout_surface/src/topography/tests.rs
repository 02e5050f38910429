//! Closed forms and the published case of plane face milling.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proveout_geom::{Point, Vector};

use super::{CutterPiece, Edge, Lattice, Settings, heights_by_edges};

/// Two round inserts, D = 10 mm, face milling along +y; Duong, Nguyen 2026, case A1.
fn face_mill(n: usize, wind: f64) -> Vec<f64> {
    let (d, r) = (10.0, 5.0);
    let (vc, fz, eps_r, eps_a) = (170_000.0 / 60.0, 0.6, 0.011, 0.003);
    let rake = proveout_geom::rad(0.6);
    let turns = vc / (PI * d);
    let feed = fz * 2.0 * turns;
    let duration = (1.5 * d + 5.0) / feed;
    let edges: Vec<Edge> = [0.0, 1.0]
        .iter()
        .map(|k| Edge {
            center_radius: d / 2.0 + k * eps_r,
            center_height: r + k * eps_a,
            radius: r,
            corner: [-FRAC_PI_2, FRAC_PI_2],
            // Counter-clockwise, counted from -y.
            azimuth: -(FRAC_PI_2 + k * PI) + rake,
            lead: 0.0,
            nose_turn: 0.0,
        })
        .collect();
    let piece = CutterPiece {
        time: [0.0, duration],
        tip: [Point::new(5.0, -5.0, 0.0), Point::new(5.0, -5.0 + feed * duration, 0.0)],
        housing: [Vector::x(), Vector::y(), Vector::z()],
        turn: Vector::zeros(),
        azimuth: 0.0,
        azimuth_rate: wind * TAU * turns,
        motion: 0,
    };
    let lattice =
        Lattice::plane(Point::origin(), Vector::x(), Vector::y(), [5.0 / n as f64, 5.0 / n as f64], 2 * n + 1, n + 1)
            .expect("a lattice");
    let found = heights_by_edges(&lattice, &edges, &[piece], &Settings { max_height: 0.5 });
    assert_eq!(found.uncut(), 0);
    found.heights()
}

#[test]
fn face_mill_with_two_round_inserts_leaves_the_published_surface() {
    for (n, sa_um) in [(25, 1.48499349337313), (50, 1.5998235023622), (100, 1.58088191701734), (200, 1.57102844765609)]
    {
        let z = face_mill(n, 1.0);
        let mean = z.iter().sum::<f64>() / z.len() as f64;
        let sa = z.iter().map(|z| (z - mean).abs()).sum::<f64>() / z.len() as f64 * 1e3;
        assert!((sa - sa_um).abs() < 1e-9, "n {n}: {sa} against {sa_um}");
    }
}
